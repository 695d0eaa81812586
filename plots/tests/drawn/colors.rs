//! Colours of a body's links on film strips.

use dynamics::Trace;
use motion::Clip;
use plots::figure::Mark;
use plots::style::Color;
use plots::{StripOptions, StripRow, View, film_strip_with};

use super::middle;
use crate::sample;

/// Fills of a strip of a trace's motion, seen from the front, in the colours that the trace has.
fn fills(trace: &Trace) -> Vec<Mark> {
    let view = View::degrees(0.0).unwrap();
    let options = StripOptions { count: 1, view, colors: trace.colors.clone(), ..StripOptions::default() };
    let clip = trace.clip();
    let marks = film_strip_with(&[StripRow::new("run", &clip)], &trace.character, "", &options).marks;
    marks.into_iter().filter(|m| matches!(m, Mark::Fill { .. })).collect()
}

fn of_color(marks: &[Mark], is: impl Fn(i32, i32, i32) -> bool) -> Vec<Mark> {
    let is = |m: &&Mark| match m {
        Mark::Fill { color: Color(r, g, b), .. } => is((*r).into(), (*g).into(), (*b).into()),
        _ => false,
    };
    marks.iter().filter(is).cloned().collect()
}

/// Left thigh green, right thigh magenta, which no tint is: each is drawn on its side, in its colour; without colours nothing is; and
/// links without a colour keep their tints.
#[test]
fn links_are_drawn_in_their_colors() {
    let character = sample::human();
    let clip = Clip::new(character.skeleton.clone(), 120.0, character.rest.repeat(3));
    let mut trace = sample::trace(&character, &clip);
    let green = |r: i32, g: i32, b: i32| g > r + 30 && g > b + 30;
    let magenta = |r: i32, g: i32, b: i32| r > g + 30 && b > g + 30;
    // tints of the sides: limbs on the left bluish, on the right orange
    let orange = |r: i32, g: i32, b: i32| r > g + 15 && g > b + 8;
    let plain = fills(&trace);
    assert!(of_color(&plain, green).is_empty() && of_color(&plain, magenta).is_empty());
    let tinted = of_color(&plain, orange).len();
    assert!(tinted > 20, "{tinted}");

    trace.colors = vec![None; character.skeleton.links().len()];
    let link = |name: &str| character.skeleton.link(name).unwrap();
    trace.colors[link("thigh_l")] = Some([20, 220, 20]);
    trace.colors[link("thigh_r")] = Some([220, 20, 220]);
    let colored = fills(&trace);
    let (left, right) = (of_color(&colored, green), of_color(&colored, magenta));
    // a contour and its bands each
    assert!(left.len() >= 7 && left.len() == right.len(), "{} {}", left.len(), right.len());
    let ([left_x, left_y], [right_x, right_y]) = (middle(&left), middle(&right));
    // from the front the left is on the viewer's right
    assert!(left_x > right_x + 20.0 && (left_y - right_y).abs() < 1e-6, "{left_x} {right_x}");
    let rest = of_color(&colored, orange).len();
    assert!(rest > 10 && rest < tinted, "{rest} of {tinted}");
    let exact = |marks: &[Mark], color: Color| {
        marks.iter().any(|m| {
            matches!(m, Mark::Fill { color: Color(r, g, b), .. }
            if r.abs_diff(color.0) < 50 && g.abs_diff(color.1) < 50 && b.abs_diff(color.2) < 50)
        })
    };
    assert!(exact(&left, Color(20, 220, 20)) && exact(&right, Color(220, 20, 220)));
}
