//! One transition fitted to the frames between two keys.
//!
//! In: the frames of a DOF from key to key. Out: the curve along the way from the first to the last value that is nearest to
//! the frames, and how far each frame is from it. The ends are the frames themselves, so that a chain of transitions has no
//! jumps.
//!
//! The way of a rotation is its geodesic: with `D = log(R_b R_a⁻¹)` and `r_f = log(R_f R_a⁻¹)` the fraction of frame `f` is
//! `s_f = r_f·D / D·D`. The curve is a cubic Bezier with its handles at a third and two thirds of the time,
//! `s(u) = 3u(1−u)² y₁ + 3u²(1−u) y₂ + u³`, and `y₁, y₂` by least squares over the frames.

use crate::rotation::{exp, log};
use crate::{Curve, Value};

/// Handles of fitted curves, least and most: a curve goes back, or past its end, by no more than a quarter of its way. So it stays
/// sensible between other ends, as an edit may set them.
const HANDLES: (f64, f64) = (-0.6, 1.6);
/// Ways shorter than this are none (rad, m): no curve is seen along them.
const NO_WAY: f64 = 1e-9;

/// The curves of transitions between named poses, as people write them.
pub const NAMED: [Curve; 4] = [Curve::EaseInOut, Curve::Linear, Curve::EaseIn, Curve::EaseOut];

/// What a DOF does from one key to another.
pub struct Way<'a> {
    values: &'a [Value],
    /// From the first value to each: rotation vectors, or scalars along x.
    from_first: Vec<crate::Vec3>,
}

impl<'a> Way<'a> {
    /// Of the values of one DOF, from key to key, both included.
    pub fn new(values: &'a [Value]) -> Self {
        let from_first = values
            .iter()
            .map(|v| match (&values[0], v) {
                (Value::Scalar(a), Value::Scalar(x)) => crate::Vec3::new(x - a, 0.0, 0.0),
                (Value::Rotation(a), Value::Rotation(x)) => log(&(x * a.inverse())),
                _ => crate::Vec3::zeros(),
            })
            .collect();
        Self { values, from_first }
    }

    /// The last frame, as the number of intervals.
    fn last(&self) -> usize {
        self.values.len() - 1
    }

    /// The curve nearest to the frames.
    pub fn bezier(&self) -> Curve {
        let n = self.last();
        let way = self.from_first[n];
        let squared = way.norm_squared();
        if n < 2 || squared < NO_WAY * NO_WAY {
            return Curve::Linear;
        }
        // normal equations of s_f − u³ = y₁ b₁(u) + y₂ b₂(u)
        let (mut a11, mut a12, mut a22, mut c1, mut c2) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (f, r) in self.from_first.iter().enumerate().take(n).skip(1) {
            let u = f as f64 / n as f64;
            let rest = 1.0 - u;
            let (b1, b2) = (3.0 * u * rest * rest, 3.0 * u * u * rest);
            let s = r.dot(&way) / squared - u * u * u;
            a11 += b1 * b1;
            a12 += b1 * b2;
            a22 += b2 * b2;
            c1 += b1 * s;
            c2 += b2 * s;
        }
        let det = a11 * a22 - a12 * a12;
        let (y1, y2) = if n > 2 && det > 1e-9 * a11 * a22 {
            ((c1 * a22 - c2 * a12) / det, (c2 * a11 - c1 * a12) / det)
        } else {
            // one frame between the keys: the symmetric curve through it
            let lift = (c1 + c2) / (a11 + 2.0 * a12 + a22) - 0.5;
            (1.0 / 3.0 + lift, 2.0 / 3.0 + lift)
        };
        let within = |y: f64| y.clamp(HANDLES.0, HANDLES.1);
        Curve::Bezier(1.0 / 3.0, within(y1), 2.0 / 3.0, within(y2))
    }

    /// How far frame `f` is from the transition with this curve, rad or m.
    pub fn error(&self, curve: &Curve, f: usize) -> f64 {
        let n = self.last();
        if f == 0 || f == n {
            return 0.0;
        }
        let s = fraction(curve, f as f64 / n as f64);
        let there = self.from_first[n] * s;
        match self.values[0] {
            Value::Scalar(_) => (self.from_first[f] - there).norm(),
            // both from the first value
            Value::Rotation(_) => log(&(exp(&there) * exp(&self.from_first[f]).inverse())).norm(),
        }
    }

    /// The same, roughly: the difference of rotation vectors, which needs no rotation.
    pub fn about(&self, curve: &Curve, f: usize) -> f64 {
        let n = self.last();
        (self.from_first[f] - self.from_first[n] * fraction(curve, f as f64 / n as f64)).norm()
    }
}

/// [`Curve::at`] without the search for the parameter of a Bezier, which is the time where handles are at the thirds.
fn fraction(curve: &Curve, u: f64) -> f64 {
    match *curve {
        Curve::Bezier(_, y1, _, y2) => {
            let rest = 1.0 - u;
            3.0 * u * rest * (rest * y1 + u * y2) + u * u * u
        }
        _ => curve.at(u),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vec3;

    /// A cubic along a geodesic is found again, exactly; the frames lie on it.
    #[test]
    fn a_bezier_is_found_again() {
        let (a, way) = (exp(&Vec3::new(0.2, -0.4, 0.1)), Vec3::new(0.3, 0.8, -0.5));
        let asked = Curve::Bezier(1.0 / 3.0, -0.2, 2.0 / 3.0, 1.3);
        let values: Vec<Value> =
            (0..=12).map(|f| Value::Rotation(exp(&(way * asked.at(f as f64 / 12.0))) * a)).collect();
        let w = Way::new(&values);
        let found = w.bezier();
        let Curve::Bezier(_, y1, _, y2) = found else { panic!("{found:?}") };
        assert!((y1 + 0.2).abs() < 1e-9 && (y2 - 1.3).abs() < 1e-9, "{y1} {y2}"); // 1e-14 seen
        let worst = (0..=12).map(|f| w.error(&found, f)).fold(0.0, f64::max);
        assert!(worst < 1e-9, "{worst:e}"); // 1e-15 seen
    }
}
