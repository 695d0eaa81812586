//! Columns of a trace as curves, and the sums that figures share.
//!
//! In: a [`Trace`]. Out: series and vectors per row. SI units.

use bodies::Character;
use dynamics::Trace;
use motion::{ContactPlan, Vec3};

use crate::excerpt::Excerpt;
use crate::figure::Figure;
use crate::panel::{Bar, Key, Panel, Stroke, VerticalGuide, page};
use crate::style::{BLUE, Color, GREEN, PURPLE, VERMILION};

/// Width of the pages with panels, px.
pub const WIDTH: f64 = 1500.0;
/// Of a fall.
const FALL: Color = Color(150, 0, 60);
/// Under every axis of time.
pub const TIME: &str = "time (s)";

/// Rows that have a pose and a target.
pub fn rows(trace: &Trace) -> usize {
    let n = trace.character.skeleton.nq();
    trace.q.len().min(trace.target.len()).checked_div(n).unwrap_or(0)
}

/// Body weight, N.
pub fn weight(trace: &Trace) -> f64 {
    trace.character.mass() * trace.gravity.norm()
}

/// Vectors stored `stride` numbers apart, from the offset `at` of each row.
pub fn vectors(data: &[f64], stride: usize, at: usize) -> Vec<Vec3> {
    data.chunks_exact(stride).map(|row| Vec3::new(row[at], row[at + 1], row[at + 2])).collect()
}

/// Name of a direction: `x`, `−y`, or its number when it is no axis.
pub fn axis_name(axis: &Vec3, number: usize) -> String {
    for (i, name) in ["x", "y", "z"].iter().enumerate() {
        if axis[i].abs() > 0.98 {
            return if axis[i] > 0.0 { (*name).to_owned() } else { format!("\u{2212}{name}") };
        }
    }
    (number + 1).to_string()
}

/// Colours of points that stand; the first two are those of the feet in all figures of forces.
const STAND: [Color; 4] = [BLUE, VERMILION, GREEN, PURPLE];

/// The points of a plan, legs first in the order of their feet, each with its colour and its times, by a clock that has the plan's zero at
/// `start_s`.
pub fn stands(character: &Character, plan: &ContactPlan, start_s: f64) -> Vec<(String, Bar)> {
    let foot = |name: &str| character.legs().find(|leg| leg.name == name).map(|leg| leg.end);
    let mut points = plan.points();
    points.sort_by_key(|name| foot(name).unwrap_or(usize::MAX));
    let bar = |(i, name): (usize, &str)| {
        let spans = plan.of(name).map(|c| [start_s + c.from_s, start_s + c.to_s]).collect();
        (name.to_owned(), Bar { spans, color: STAND[i.min(STAND.len() - 1)] })
    };
    points.into_iter().enumerate().map(bar).collect()
}

/// Marks what is to stand, as bars under the axis, and the fall of a run with the loss that led to it, on panels over time; the legend
/// gets their names.
pub fn mark_times(trace: &Excerpt, panels: &mut [Panel], keys: &mut Vec<Key>) {
    let stands = stands(&trace.character, &trace.plan, trace.clock().start_s);
    keys.extend(stands.iter().map(|(name, bar)| Key::area(&format!("{name} is to stand"), bar.color)));
    for panel in panels.iter_mut().filter(|p| p.message.is_empty()) {
        panel.bars = stands.iter().map(|(_, bar)| bar.clone()).collect();
    }
    let Some(fall) = trace.fall() else { return };
    let mut lines = vec![VerticalGuide { x: fall.time_s, color: FALL, stroke: Stroke::Solid }];
    keys.push(Key::line("the body has fallen", FALL));
    if let Some(cause) = fall.cause() {
        lines.push(VerticalGuide { x: cause.time_s, color: FALL, stroke: Stroke::Dashed });
        keys.push(Key::dashed(&cause.to_string(), FALL));
    }
    for panel in panels {
        panel.vertical_guides.extend(&lines);
    }
}

/// A page that says why it is empty.
pub fn empty_page(title: &str, note: &str, why: &str) -> Figure {
    let panel = Panel { message: why.to_owned(), ..Panel::default() };
    page(title, note, &[], &[panel], 1, WIDTH, 180.0)
}

/// Mean square root of lengths; zero of nothing.
pub fn rms<'a>(vectors: impl IntoIterator<Item = &'a Vec3>) -> f64 {
    let (sum, n) = (vectors.into_iter().filter(|v| v.norm().is_finite()))
        .fold((0.0, 0.0), |(s, n), v| (s + v.norm_squared(), n + 1.0));
    if n > 0.0 { f64::sqrt(sum / n) } else { 0.0 }
}

/// Three significant digits.
pub fn short(x: f64) -> String {
    match x.abs() {
        0.0 => "0".into(),
        a if a < 1e-3 => format!("{x:.1e}"),
        a if a < 1.0 => format!("{x:.3}"),
        a if a < 10.0 => format!("{x:.2}"),
        a if a < 100.0 => format!("{x:.1}"),
        _ => format!("{x:.0}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_nothing_is_zero() {
        let (none, far) = (Vec3::zeros(), Vec3::new(3.0, 0.0, 4.0));
        assert_eq!((rms([]), rms([&none; 3]), rms([&far])), (0.0, 0.0, 5.0));
        // what was not measured does not count
        assert_eq!(rms([&far, &Vec3::repeat(f64::NAN)]), 5.0);
    }
}
