//! Activations of style components over time: one panel a component, the two clips one after the other.
//!
//! In: activations (standard deviations) of both clips at one rate. Out: a [`Figure`]; one vertical range for all panels.

use crate::figure::Figure;
use crate::panel::{Guide, Key, Panel, Series, Stroke, page};
use crate::style::{self, LINE};

/// A component: its words, and of each of its parts the activations in both clips.
#[derive(Clone, Debug, PartialEq)]
pub struct ActivationPanel {
    /// What it is, in words.
    pub title: String,
    /// For each part of a merged component, frames of the first clip and of the second.
    pub curves: Vec<[Vec<f64>; 2]>,
}

/// Width of the page, px.
const WIDTH: f64 = 1600.0;
/// Height of a panel, px.
const HEIGHT: f64 = 110.0;

/// Panels below each other. `rate_hz`: of the activations.
pub fn activations(panels: &[ActivationPanel], names: [&str; 2], rate_hz: f64) -> Figure {
    let colors = [style::BLUE, style::VERMILION];
    let all = || panels.iter().flat_map(|p| p.curves.iter().flatten().flatten());
    let (lo, hi) = all().fold((0.0_f64, 0.0_f64), |(lo, hi), x| (lo.min(*x), hi.max(*x)));
    let last = panels.len().saturating_sub(1);
    let drawn: Vec<Panel> = panels
        .iter()
        .enumerate()
        .map(|(i, p)| {
            let mut series = Vec::new();
            for curve in &p.curves {
                let mut first = 0.0;
                for (values, color) in curve.iter().zip(colors) {
                    let points =
                        values.iter().enumerate().map(|(f, u)| [first + f as f64 / rate_hz, *u]).collect();
                    series.push(Series { points, color, width: LINE, stroke: Stroke::Solid });
                    first += values.len() as f64 / rate_hz;
                }
            }
            Panel {
                title: p.title.clone(),
                x_label: if i == last { "s, the clips one after the other".into() } else { String::new() },
                y_label: "u".into(),
                series,
                guides: [lo, hi]
                    .map(|y| Guide { y, color: style::WHITE, stroke: Stroke::Solid, always: true })
                    .into(),
                ..Panel::default()
            }
        })
        .collect();
    let keys = [Key::line(names[0], colors[0]), Key::line(names[1], colors[1])];
    let note = "activations u of each component, in standard deviations over both clips; a level is posture, a swing is rhythm";
    page("Style components over time", note, &keys, &drawn, 1, WIDTH, HEIGHT)
}
