//! Learning curves: the error of several ways over how much each was given.
//!
//! In: numbers. Out: a [`Figure`]. Units of the errors are the panel's.

use crate::figure::Figure;
use crate::panel::{Guide, Key, Panel, Series, Stroke, page};
use crate::style::{BLUE, Color, GREEN, LINE, PURPLE, REFERENCE, VERMILION};

/// Width of a page, px.
const WIDTH: f64 = 1200.0;
/// Colours of the ways, in their order.
const COLORS: [Color; 5] = [BLUE, GREEN, PURPLE, REFERENCE, VERMILION];

/// What is learned, by every way.
#[derive(Clone, Debug, PartialEq)]
pub struct LearningPanel {
    /// What is learned.
    pub title: String,
    /// Error with its unit.
    pub y_label: String,
    /// How much was given, and the error, for each way in the order of their names.
    pub curves: Vec<Vec<[f64; 2]>>,
    /// What is asked for, if anything is.
    pub bar: Option<f64>,
}

/// One panel for each thing learned and one curve for each way, dashed those of `dashed`. The horizontal axis is of equal ratios: a
/// unit is a doubling. Curves are cut where an error is above four times the median of its panel.
pub fn learning_curves(
    panels: &[LearningPanel],
    ways: &[(&str, bool)],
    given: &str,
    title: &str,
    note: &str,
) -> Figure {
    let keys: Vec<Key> = ways
        .iter()
        .zip(COLORS)
        .map(
            |((name, dashed), color)| {
                if *dashed { Key::dashed(name, color) } else { Key::line(name, color) }
            },
        )
        .collect();
    let draw = |p: &LearningPanel| {
        let mut all: Vec<f64> = p.curves.iter().flatten().map(|x| x[1]).collect();
        all.sort_by(f64::total_cmp);
        let median = all.get(all.len() / 2).copied().unwrap_or(1.0);
        let ceiling = (4.0 * median).max(p.bar.unwrap_or(0.0) * 1.1);
        let points = |c: &Vec<[f64; 2]>| -> Vec<[f64; 2]> { c.iter().map(|x| [x[0].log2(), x[1]]).collect() };
        let shown = |c: &Vec<[f64; 2]>| points(c).into_iter().filter(|x| x[1] <= ceiling).collect::<Vec<_>>();
        Panel {
            title: p.title.clone(),
            x_label: format!("log₂ of {given}"),
            y_label: p.y_label.clone(),
            series: (p.curves.iter().zip(ways).zip(COLORS))
                .map(|((c, (_, dashed)), color)| Series {
                    points: points(c),
                    color,
                    width: LINE,
                    stroke: if *dashed { Stroke::Dashed } else { Stroke::Solid },
                })
                .collect(),
            dots: (p.curves.iter().zip(COLORS))
                .flat_map(|(c, color)| shown(c).into_iter().map(move |x| (x, 3.0, color)))
                .collect(),
            guides: (p.bar.iter())
                .map(|y| Guide { y: *y, color: REFERENCE, stroke: Stroke::Dashed, always: true })
                .collect(),
            ceiling: (all.last().is_some_and(|x| *x > ceiling)).then_some(ceiling),
            ..Panel::default()
        }
    };
    let panels: Vec<Panel> = panels.iter().map(draw).collect();
    page(title, note, &keys, &panels, 4, WIDTH, 240.0)
}
