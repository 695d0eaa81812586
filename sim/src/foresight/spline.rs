//! Offsets over time: cubics of Hermite through knots of position and slope.
//!
//! In: a knot at the beginning and one at the end of a window. Out: offsets between them, continuous with their rates from window to window.
//! A knot is reached from the one before: its slope is half of the mean rate on the way, so that offsets that go on in one direction do not
//! stop at every knot, and those that turn back do not overshoot.

/// Offsets and their slopes at the end of a window, one of each per channel; slopes per window.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Knot {
    /// Offsets, rad (m for slides).
    pub at: Vec<f64>,
    /// Slopes, rad per window.
    pub slope: Vec<f64>,
}

/// Part of the mean rate of a window that is left at its end.
const LEFT: f64 = 0.5;

impl Knot {
    /// Nothing, for so many channels.
    pub fn zero(channels: usize) -> Self {
        Self { at: vec![0.0; channels], slope: vec![0.0; channels] }
    }

    /// The slopes of a knot whose offsets are set, reached from `before`.
    pub fn reach(&mut self, before: &Self) {
        for (slope, (to, from)) in self.slope.iter_mut().zip(self.at.iter().zip(&before.at)) {
            *slope = LEFT * (to - from);
        }
    }
}

/// Offsets at the fraction `s` of the way from one knot to the next.
pub fn between(from: &Knot, to: &Knot, s: f64, out: &mut [f64]) {
    let (s2, s3) = (s * s, s * s * s);
    let (a, b) = (3.0 * s2 - 2.0 * s3, s3 - 2.0 * s2 + s);
    let c = s3 - s2;
    for k in 0..out.len() {
        out[k] = from.at[k] + (to.at[k] - from.at[k]) * a + from.slope[k] * b + to.slope[k] * c;
    }
}

/// Offsets and slopes at the fraction `s` of the way from one knot to the next, as a knot.
pub fn on_the_way(from: &Knot, to: &Knot, s: f64) -> Knot {
    let mut knot = Knot::zero(from.at.len());
    between(from, to, s, &mut knot.at);
    let (a, b, c) = (6.0 * s * (1.0 - s), 3.0 * s * s - 4.0 * s + 1.0, 3.0 * s * s - 2.0 * s);
    for (k, slope) in knot.slope.iter_mut().enumerate() {
        *slope = (to.at[k] - from.at[k]) * a + from.slope[k] * b + to.slope[k] * c;
    }
    knot
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Knots are passed through, with their slopes, whatever comes before and after.
    #[test]
    fn offsets_and_rates_are_continuous() {
        let mut knots = vec![Knot::zero(1)];
        for at in [0.3, -0.1, -0.2, 0.0] {
            let mut knot = Knot { at: vec![at], slope: vec![0.0] };
            knot.reach(&knots[knots.len() - 1]);
            knots.push(knot);
        }
        let at = |x: f64| {
            let i = (x.floor() as usize).min(knots.len() - 2);
            let mut out = [0.0];
            between(&knots[i], &knots[i + 1], x - i as f64, &mut out);
            out[0]
        };
        let h = 1e-5;
        for i in 1..knots.len() - 1 {
            let x = i as f64;
            assert!((at(x) - knots[i].at[0]).abs() < 1e-15);
            let (before, after) = ((at(x) - at(x - h)) / h, (at(x + h) - at(x)) / h);
            assert!((before - after).abs() < 1e-4, "{before} {after}"); // 2e-5 seen: curvature times h
            assert!((after - knots[i].slope[0]).abs() < 1e-4);
            let middle = on_the_way(&knots[i], &knots[i + 1], 0.3);
            let rate = (at(x + 0.3 + h) - at(x + 0.3 - h)) / (2.0 * h);
            assert!((middle.at[0] - at(x + 0.3)).abs() < 1e-14);
            assert!((middle.slope[0] - rate).abs() < 1e-8, "{} {rate}", middle.slope[0]);
        }
    }
}
