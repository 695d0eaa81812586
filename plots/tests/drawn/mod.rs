//! What the marks of a page say: where faces look, which sign a torque has, whose colour a limb is in, from which side a strip is seen.

mod colors;
mod heads;
mod sides;
mod torques;

use plots::Figure;
use plots::figure::Mark;

/// Middle of the smallest rectangle around marks, px.
fn middle(marks: &[Mark]) -> [f64; 2] {
    let [left, top, right, bottom] = around(marks);
    [0.5 * (left + right), 0.5 * (top + bottom)]
}

/// The smallest rectangle around marks: left, top, right, bottom, px.
fn around(marks: &[Mark]) -> [f64; 4] {
    let (far, none) = (f64::INFINITY, f64::NEG_INFINITY);
    marks
        .iter()
        .map(Figure::bounds)
        .fold([far, far, none, none], |a, b| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])])
}
