//! What a search did: costs over its course, cost along every parameter, terms before and after.
//!
//! In: costs and values as numbers. Out: [`Figure`]s. Costs are dimensionless; parameters are in their units.

use crate::figure::{Anchor, Figure};
use crate::panel::{Guide, Key, Panel, Series, Stroke, header, page};
use crate::style::{self, LABEL, LINE, MARGIN, SMALL};

/// Width of a page, px.
const WIDTH: f64 = 1000.0;

/// One parameter varied, all others kept.
#[derive(Clone, Debug, PartialEq)]
pub struct CostSlice {
    /// Its name.
    pub name: String,
    /// Its unit; empty for a pure number.
    pub unit: String,
    /// Value and cost, by value.
    pub points: Vec<[f64; 2]>,
    /// Values tried all over the grid, with their costs; for a sweep.
    pub cloud: Vec<[f64; 2]>,
    /// Its value before.
    pub was: Option<f64>,
    /// The value chosen, and the cost there.
    pub is: Option<[f64; 2]>,
}

/// Cost of every point in the order in which they were tried, and the best so far; `before`: of the scene as it was.
pub fn convergence(costs: &[f64], before: f64, note: &str) -> Figure {
    let mut best = f64::INFINITY;
    let mut line = Vec::new();
    for (i, cost) in costs.iter().enumerate() {
        let at = i as f64 + 1.0;
        if best.is_finite() {
            line.push([at, best]);
        }
        best = best.min(*cost);
        line.push([at, best]);
    }
    let panel = Panel {
        x_label: "points costed".into(),
        y_label: "cost".into(),
        series: vec![Series { points: line, color: style::BLUE, width: LINE, stroke: Stroke::Solid }],
        guides: vec![Guide { y: before, color: style::VERMILION, stroke: Stroke::Dashed, always: true }],
        dots: costs
            .iter()
            .enumerate()
            .map(|(i, c)| ([i as f64 + 1.0, *c], 2.2, style::BLUE.mix(style::WHITE, 0.55)))
            .collect(),
        ..Panel::default()
    };
    let keys = [
        Key::line("best so far", style::BLUE),
        Key::dot("a point", style::BLUE.mix(style::WHITE, 0.55)),
        Key::dashed("before", style::VERMILION),
    ];
    page("Cost over the search", note, &keys, &[panel], 1, WIDTH, 260.0)
}

/// Cost along every parameter.
pub fn cost_slices(slices: &[CostSlice], title: &str, note: &str) -> Figure {
    let faint = style::BLUE.mix(style::WHITE, 0.6);
    let dots = |s: &CostSlice| {
        let cloud = s.cloud.iter().map(|p| (*p, 2.0, faint));
        let points = s.points.iter().map(|p| (*p, 2.2, style::BLUE));
        let is = s.is.iter().map(|p| (*p, 4.5, style::GREEN));
        cloud.chain(points).chain(is).collect()
    };
    // one vertical range for all, so that flat ones look flat
    let all = || slices.iter().flat_map(|s| s.points.iter().chain(&s.cloud)).map(|p| p[1]);
    let (lo, hi) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    let panels: Vec<Panel> = slices
        .iter()
        .enumerate()
        .map(|(i, s)| {
            let mut series = vec![Series {
                points: s.points.clone(),
                color: style::BLUE,
                width: LINE,
                stroke: Stroke::Solid,
            }];
            if let Some(was) = s.was {
                let points = vec![[was, lo], [was, hi]];
                series.push(Series { points, color: style::VERMILION, width: 1.2, stroke: Stroke::Dashed });
            }
            Panel {
                title: s.name.clone(),
                x_label: s.unit.clone(),
                y_label: if i % 4 == 0 { "cost".into() } else { String::new() },
                series,
                dots: dots(s),
                guides: [lo, hi]
                    .map(|y| Guide { y, color: style::WHITE, stroke: Stroke::Solid, always: true })
                    .into(),
                ..Panel::default()
            }
        })
        .collect();
    let mut keys = vec![Key::line("cost, all others kept", style::BLUE)];
    if slices.iter().any(|s| !s.cloud.is_empty()) {
        keys = vec![Key::line("least cost over the others", style::BLUE), Key::dot("a sample", faint)];
    }
    if slices.iter().any(|s| s.is.is_some()) {
        keys.push(Key::dot("chosen", style::GREEN));
    }
    if slices.iter().any(|s| s.was.is_some()) {
        keys.push(Key::dashed("before", style::VERMILION));
    }
    page(title, note, &keys, &panels, 4, WIDTH, 120.0)
}

/// A term of a cost: its name, and its value before and after.
pub type TermPair = (String, f64, f64);

/// Terms of a cost before and after, as pairs of bars.
pub fn terms_before_after(terms: &[TermPair], note: &str) -> Figure {
    let width = 680.0;
    let keys = [Key::area("before", style::VERMILION), Key::area("after", style::BLUE)];
    let title = "Terms of the cost";
    let top = header(&mut Figure::new(width, 100.0), title, note, &keys);
    let row = 46.0;
    let mut figure = Figure::new(width, top + row * terms.len() as f64 + MARGIN);
    header(&mut figure, title, note, &keys);
    let names = terms.iter().map(|t| style::text_width(&t.0, LABEL)).fold(0.0, f64::max);
    let left = MARGIN + names + 12.0;
    let most = terms.iter().flat_map(|t| [t.1, t.2]).filter(|x| x.is_finite()).fold(1e-9, f64::max);
    let scale = (width - MARGIN - 60.0 - left) / most;
    for (i, (name, before, after)) in terms.iter().enumerate() {
        let y = top + row * i as f64 + 6.0;
        figure.text(name.as_str(), [left - 12.0, y + 20.0], LABEL, style::INK, Anchor::End);
        for (k, (value, color)) in
            [(*before, style::VERMILION), (*after, style::BLUE)].into_iter().enumerate()
        {
            let at = y + 16.0 * k as f64;
            figure.rectangle([left, at], [(value * scale).max(1.0), 13.0], color);
            let text = format!("{value:.3}");
            figure.text(text, [left + value * scale + 8.0, at + 10.5], SMALL, style::SOFT, Anchor::Start);
        }
    }
    figure
}
