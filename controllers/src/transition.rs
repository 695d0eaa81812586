//! Gains along a transition: how a joint's muscles get from one pose to the next \[NF02\].
//!
//! When an element becomes active, the stiffness and rest its end pose will need (load predicted
//! there) are known; muscles run from where they are to there along the element's curve. Blending the
//! pair (K, rest angle) keeps the rest on the curve; blending the gains (k_lo, k_hi) themselves, as
//! \[NF02\] does, moves it off (80 % of the way at half the curve for K 10 → 40).
//!
//! In: the current and the final drive, times, a curve. Out: the drive at a time.

use motion::Curve;
use motion::names::Word;

use crate::{Drive, Rest};

/// What is interpolated along a transition.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GainBlend {
    /// Stiffness and rest angle: the rest follows the curve.
    #[default]
    RestAngle,
    /// The two gains, literally as in \[NF02\].
    Gains,
}

impl Word for GainBlend {
    const KIND: &'static str = "blend";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::RestAngle, "rest-angle", "Stiffness and rest angle: the rest follows the curve"),
        (Self::Gains, "gains", "The two gains, literally as in NF02"),
    ];
}

/// A joint's muscles on their way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition {
    from: Drive,
    to: Drive,
    start_s: f64,
    end_s: f64,
    curve: Curve,
    blend: GainBlend,
}

impl Transition {
    /// Muscles that stay as they are.
    pub fn still(drive: Drive) -> Self {
        let (start_s, end_s) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        let (curve, blend) = (Curve::Linear, GainBlend::RestAngle);
        Self { from: drive, to: drive, start_s, end_s, curve, blend }
    }

    /// Muscles that go from where they are at `start_s` to `to` at `end_s`.
    pub fn redirect(&self, to: Drive, start_s: f64, end_s: f64, curve: Curve, blend: GainBlend) -> Self {
        Self { from: self.at(start_s), to, start_s, end_s, curve, blend }
    }

    /// Drive at a time, s.
    pub fn at(&self, t_s: f64) -> Drive {
        if t_s >= self.end_s {
            return self.to;
        }
        let u = ((t_s - self.start_s) / (self.end_s - self.start_s)).clamp(0.0, 1.0);
        let s = self.curve.at(u);
        // an overshooting curve shapes the rest; stiffness and damping stay between their ends
        let inside = s.clamp(0.0, 1.0);
        let mix = |a: f64, b: f64| a + (b - a) * inside;
        let stiffness = mix(self.from.stiffness, self.to.stiffness);
        let along = match self.blend {
            GainBlend::RestAngle => s,
            // k_lo, k_hi linear: the rest is their weighted mean
            GainBlend::Gains => self.to.stiffness * s / stiffness,
        };
        let rest: Rest = self.from.rest.blend(&self.to.rest, along);
        Drive { stiffness, damping: mix(self.from.damping, self.to.damping), rest }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive(stiffness: f64, rest: f64) -> Drive {
        Drive { stiffness, damping: 1.0, rest: Rest::Scalar(rest) }
    }

    /// DESIGN §4: with K 10 → 40, half the curve is half the way, or 80 % of it with literal gains.
    #[test]
    fn the_rest_follows_the_curve() {
        let start = Transition::still(drive(10.0, 0.0));
        let at_half = |blend| {
            let t = start.redirect(drive(40.0, 1.0), 0.0, 1.0, Curve::Linear, blend);
            let Rest::Scalar(rest) = t.at(0.5).rest else { panic!() };
            rest
        };
        assert!((at_half(GainBlend::RestAngle) - 0.5).abs() < 1e-15);
        assert!((at_half(GainBlend::Gains) - 0.8).abs() < 1e-15);
    }

    /// A redirected muscle starts where it is: torque is continuous.
    #[test]
    fn redirection_is_continuous() {
        let first = Transition::still(drive(10.0, 0.0)).redirect(
            drive(40.0, 1.0),
            0.0,
            1.0,
            Curve::EaseInOut,
            GainBlend::RestAngle,
        );
        let second = first.redirect(drive(20.0, -1.0), 0.4, 1.0, Curve::EaseInOut, GainBlend::RestAngle);
        assert_eq!(first.at(0.4), second.at(0.4));
        assert_eq!(second.at(1.0), drive(20.0, -1.0));
    }
}
