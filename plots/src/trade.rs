//! What help from outside buys: tracking error against root wrench, per fidelity.
//!
//! In: [`TradePoint`]s. Out: a [`Figure`]: the curve, what help each fidelity allowed and took, and the joints'
//! errors. A run that fell is an open question, not a point of the curve: it is drawn apart, at the top.

use crate::figure::Figure;
use crate::panel::{Key, Panel, Series, Stroke, page};
use crate::style::{BLUE, GREEN, INK, SOFT, VERMILION};

/// One run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TradePoint {
    /// From 0 (free) to 1.
    pub fidelity: f64,
    /// RMS force on the root, % of body weight.
    pub force_rms_percent: f64,
    /// Peak force on the root, % of body weight.
    pub force_peak_percent: f64,
    /// Largest force allowed, % of body weight.
    pub budget_percent: f64,
    /// RMS distance of the links to the motion asked for, mm.
    pub error_mm: f64,
    /// RMS angle of the joints to the motion asked for, degrees.
    pub error_deg: f64,
    /// Whether the body stands to the end.
    pub stands: bool,
}

/// Width of the page, px.
const WIDTH: f64 = 900.0;
/// Runs that fell are drawn this much above the worst that stands.
const ABOVE: f64 = 1.25;

/// Draws a curve; `note` stands under the title.
pub fn trade_off(points: &[TradePoint], note: &str) -> Figure {
    let keys = [
        Key::dot("stands", BLUE),
        Key::dot("fell (at the top if further off)", VERMILION),
        Key::dashed("force allowed", SOFT),
        Key::line("force used, peak", GREEN),
        Key::line("force used, RMS", INK),
    ];
    let panels = [
        curve(points, "links from the motion asked for", "mm, RMS", |p| p.error_mm),
        root_force(points),
        curve_over_fidelity(points),
    ];
    page("Tracking against help from outside", note, &keys, &panels, 1, WIDTH, 230.0)
}

/// Worst value among the runs that stand; of all where none does.
fn worst(points: &[TradePoint], of: impl Fn(&TradePoint) -> f64) -> f64 {
    let standing = points.iter().filter(|p| p.stands).map(&of).filter(|x| x.is_finite()).fold(0.0, f64::max);
    if standing > 0.0 {
        standing
    } else {
        points.iter().map(of).filter(|x| x.is_finite()).fold(1e-3, f64::max)
    }
}

fn curve(points: &[TradePoint], title: &str, unit: &str, of: impl Fn(&TradePoint) -> f64 + Copy) -> Panel {
    let top = ABOVE * worst(points, of);
    let at = |p: &TradePoint| [p.force_rms_percent, if p.stands { of(p) } else { of(p).min(top) }];
    let x_most = points.iter().map(|p| p.force_rms_percent).filter(|x| x.is_finite()).fold(0.0, f64::max);
    let mut labels = Vec::new();
    for (i, p) in points.iter().enumerate() {
        // of points that nearly coincide only the last is labelled
        let next = points.get(i + 1).map(at);
        let hidden = next.is_some_and(|[x, y]| {
            let [a, b] = at(p);
            (x - a).abs() < 0.012 * x_most && (y - b).abs() < 0.05 * top
        });
        if !hidden {
            labels.push((at(p), short(p.fidelity), SOFT));
        }
    }
    Panel {
        title: title.into(),
        x_label: "force on the root, RMS, % of body weight".into(),
        y_label: unit.into(),
        series: vec![
            Series {
                points: points.iter().filter(|p| p.stands).map(at).collect(),
                color: BLUE,
                width: 1.7,
                stroke: Stroke::Solid,
            },
            frame(0.0, 1.06 * x_most.max(1e-3), 0.0),
        ],
        dots: dots(points, at),
        labels,
        ..Panel::default()
    }
}

fn root_force(points: &[TradePoint]) -> Panel {
    let line = |of: fn(&TradePoint) -> f64, color| Series {
        points: points.iter().map(|p| [p.fidelity, of(p)]).collect(),
        color,
        width: 1.7,
        stroke: Stroke::Solid,
    };
    Panel {
        title: "force on the root".into(),
        x_label: "fidelity".into(),
        y_label: "% of body weight".into(),
        series: vec![
            line(|p| p.budget_percent, SOFT).dashed(),
            line(|p| p.force_peak_percent, GREEN),
            line(|p| p.force_rms_percent, INK),
        ],
        ..Panel::default()
    }
}

fn curve_over_fidelity(points: &[TradePoint]) -> Panel {
    let top = ABOVE * worst(points, |p| p.error_deg);
    let at = |p: &TradePoint| [p.fidelity, if p.stands { p.error_deg } else { p.error_deg.min(top) }];
    let standing: Vec<[f64; 2]> = points.iter().filter(|p| p.stands).map(at).collect();
    Panel {
        title: "joints from the motion asked for".into(),
        x_label: "fidelity".into(),
        y_label: "degrees, RMS".into(),
        series: vec![
            Series { points: standing, color: BLUE, width: 1.7, stroke: Stroke::Solid },
            frame(points.first().map_or(0.0, |p| p.fidelity), points.last().map_or(1.0, |p| p.fidelity), 0.0),
        ],
        dots: dots(points, at),
        ..Panel::default()
    }
}

fn dots(
    points: &[TradePoint],
    at: impl Fn(&TradePoint) -> [f64; 2],
) -> Vec<([f64; 2], f64, crate::style::Color)> {
    points.iter().map(|p| (at(p), 4.0, if p.stands { BLUE } else { VERMILION })).collect()
}

/// Two points that make an axis reach from `from` to `to` and down to `y`; nothing is drawn.
fn frame(from: f64, to: f64, y: f64) -> Series {
    let gap = [f64::NAN, f64::NAN];
    Series { points: vec![[from, y], gap, [to, y]], color: SOFT, width: 0.0, stroke: Stroke::Solid }
}

fn short(x: f64) -> String {
    let text = format!("{x:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An axis has a length, also without runs and where all errors are zero or none is a number.
    #[test]
    fn the_worst_of_nothing_has_a_length() {
        let point = TradePoint {
            fidelity: 0.0,
            force_rms_percent: 0.0,
            force_peak_percent: 0.0,
            budget_percent: 0.0,
            error_mm: f64::NAN,
            error_deg: 0.0,
            stands: true,
        };
        for points in [&[][..], &[point][..]] {
            assert_eq!((worst(points, |p| p.error_deg), worst(points, |p| p.error_mm)), (1e-3, 1e-3));
        }
    }
}
