//! What a learned edit predicts over time: mean with a band of how unsure it is, beside the source and the blended answer.
//!
//! In: one number for each frame of each. Out: a [`Figure`], a row for each stretch of time. Units are the caller's.

use crate::figure::Figure;
use crate::panel::{Clock, Key, Panel, Series, page};
use crate::style::{BLUE, GREEN, LINE, REFERENCE, VERMILION, WHITE};

/// Width of a page, px.
const WIDTH: f64 = 1600.0;
/// Height of a row, px.
const HEIGHT: f64 = 170.0;
/// A band is drawn in pieces of so many frames.
const PIECE: usize = 30;

/// One number of an edit over time, all as values of the body, not as differences.
#[derive(Clone, Copy, Debug)]
pub struct Predicted<'a> {
    /// Frames a second, Hz.
    pub rate_hz: f64,
    /// The source.
    pub source: &'a [f64],
    /// What the model predicts.
    pub mean: &'a [f64],
    /// Its standard deviation.
    pub deviation: &'a [f64],
    /// The blended answer.
    pub blended: &'a [f64],
    /// What is right, where that is known.
    pub truth: Option<&'a [f64]>,
    /// What it is, with its unit.
    pub label: &'a str,
    /// Length of a row, s.
    pub row_s: f64,
}

/// Prediction ± two standard deviations, source, blended answer and truth, in rows of `row_s`.
pub fn prediction(of: &Predicted, title: &str, note: &str) -> Figure {
    let band = BLUE.mix(WHITE, 0.72);
    let frames = of.source.len();
    let per_row = ((of.row_s * of.rate_hz).round() as usize).clamp(2, frames.max(2));
    let low = |f: usize| of.mean[f] - 2.0 * of.deviation[f];
    let high = |f: usize| of.mean[f] + 2.0 * of.deviation[f];
    let all = (0..frames).flat_map(|f| [low(f), high(f), of.source[f], of.blended[f]]);
    let (bottom, top) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), y| (a.min(y), b.max(y)));
    let panels: Vec<Panel> = (0..frames.saturating_sub(1))
        .step_by(per_row)
        .map(|from| {
            let to = (from + per_row).min(frames - 1);
            let clock = Clock { rate_hz: of.rate_hz, start_s: from as f64 / of.rate_hz };
            let at = |f: usize, y: f64| [f as f64 / of.rate_hz, y];
            let areas = (from..to)
                .step_by(PIECE)
                .map(|a| {
                    let b = (a + PIECE).min(to);
                    let upper = (a..=b).map(|f| at(f, high(f)));
                    (upper.chain((a..=b).rev().map(|f| at(f, low(f)))).collect(), band)
                })
                .collect();
            let line = |of: &[f64], color| Series::over_time(clock, of[from..=to].iter().copied(), color);
            let mut series = vec![
                line(of.source, REFERENCE),
                line(of.mean, BLUE),
                line(of.blended, VERMILION).wide(1.4 * LINE),
            ];
            if let Some(truth) = of.truth {
                series.push(line(truth, GREEN).dashed());
            }
            Panel {
                y_label: of.label.into(),
                x_label: if to + 1 >= frames { "time, s".into() } else { String::new() },
                areas,
                series,
                // all rows have one scale
                dots: [bottom, top].map(|y| (at(from, y), 0.0, WHITE)).to_vec(),
                ..Panel::default()
            }
        })
        .collect();
    let mut keys = vec![
        Key::line("source", REFERENCE),
        Key::line("predicted", BLUE),
        Key::area("± 2 standard deviations", band),
        Key::line("blended answer", VERMILION),
    ];
    if of.truth.is_some() {
        keys.push(Key::dashed("as scripted, never shown to the model", GREEN));
    }
    page(title, note, &keys, &panels, 1, WIDTH, HEIGHT)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every row holds its stretch of time, and the last one the rest.
    #[test]
    fn rows_hold_all_frames() {
        let y: Vec<f64> = (0..100).map(|f| f64::from(f).sin()).collect();
        let of = Predicted {
            rate_hz: 10.0,
            source: &y,
            mean: &y,
            deviation: &[0.1; 100],
            blended: &y,
            truth: None,
            label: "lean, °",
            row_s: 4.0,
        };
        let tall = |row_s| prediction(&Predicted { row_s, ..of }, "t", "n").height;
        let (three, one) = (tall(4.0), tall(20.0));
        assert!(three > one + 2.0 * HEIGHT && three < one + 3.0 * HEIGHT, "{three} {one}");
    }
}
