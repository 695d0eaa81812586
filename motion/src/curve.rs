//! Transition curves: how a transition runs from its start value (0) to its end value (1).
//!
//! In: `u`, the fraction of the duration gone, in [0, 1]. Out: `s(u)`, the fraction of the way, and
//! its slope `ds/du`. `s(0) = 0` and `s(1) = 1` to the bit; `s` may leave [0, 1] in between, and then a
//! value is extrapolated. For rotations `s` is the slerp parameter.
//!
//! | curve | `s(u)` | slope at 0, at 1 |
//! |---|---|---|
//! | `Linear` | `u` | 1, 1 |
//! | `EaseIn` | `u²` | 0, 2 |
//! | `EaseOut` | `u (2 − u)` | 2, 0 |
//! | `EaseInOut` | `m(u) = u³ (10 − 15u + 6u²)`, least jerk | 0, 0 |
//! | `Overshoot` | `o(u) = m(u) + 8 u³ (1 − u)²`: passes 1 at u = 0.625, peaks at 1.110 | 0, 0 |
//! | `Anticipate` | `1 − o(1 − u)`: first goes back to −0.110 | 0, 0 |
//! | `Bezier(x1, y1, x2, y2)` | as CSS `cubic-bezier`: ends (0, 0), (1, 1), handles as given | `y1/x1`, `(1−y2)/(1−x2)` |
//!
//! `m` is the curve of human reaching (Flash, Hogan, J. Neurosci. 5, 1985): speed and acceleration
//! vanish at both ends, so joint torques do not jump there.

use std::fmt;

use crate::names::Word;

/// A transition curve. Formulas are in the module header.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Curve {
    /// Constant speed.
    Linear,
    /// Starts gently, ends at full speed.
    EaseIn,
    /// Starts at full speed, ends gently.
    EaseOut,
    /// Starts and ends gently: least jerk.
    #[default]
    EaseInOut,
    /// Goes past the end and comes back.
    Overshoot,
    /// Draws back before it goes.
    Anticipate,
    /// CSS-style cubic with handles (x1, y1) and (x2, y2); both x in [0, 1].
    Bezier(f64, f64, f64, f64),
}

/// The names of the [`Curve`]s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveName {
    /// [`Curve::Linear`].
    Linear,
    /// [`Curve::EaseIn`].
    EaseIn,
    /// [`Curve::EaseOut`].
    EaseOut,
    /// [`Curve::EaseInOut`].
    EaseInOut,
    /// [`Curve::Overshoot`].
    Overshoot,
    /// [`Curve::Anticipate`].
    Anticipate,
    /// [`Curve::Bezier`].
    Bezier,
}

impl Word for CurveName {
    const KIND: &'static str = "curve";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Linear, "linear", "Constant speed"),
        (Self::EaseIn, "ease-in", "Starts gently, ends at full speed"),
        (Self::EaseOut, "ease-out", "Starts at full speed, ends gently"),
        (Self::EaseInOut, "ease-in-out", "Starts and ends gently: least jerk"),
        (Self::Overshoot, "overshoot", "Goes past the end and comes back"),
        (Self::Anticipate, "anticipate", "Draws back before it goes"),
        (Self::Bezier, "bezier", "CSS-style cubic with handles (x1, y1, x2, y2)"),
    ];
}

impl fmt::Display for Curve {
    /// As scenes write it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name().identifier())?;
        match self {
            Self::Bezier(x1, y1, x2, y2) => write!(f, "({x1:?}, {y1:?}, {x2:?}, {y2:?})"),
            _ => Ok(()),
        }
    }
}

impl Curve {
    /// Its name.
    pub fn name(&self) -> CurveName {
        match self {
            Self::Linear => CurveName::Linear,
            Self::EaseIn => CurveName::EaseIn,
            Self::EaseOut => CurveName::EaseOut,
            Self::EaseInOut => CurveName::EaseInOut,
            Self::Overshoot => CurveName::Overshoot,
            Self::Anticipate => CurveName::Anticipate,
            Self::Bezier(..) => CurveName::Bezier,
        }
    }

    /// The curve of a name; `None` of [`CurveName::Bezier`], which needs handles.
    pub fn named(name: CurveName) -> Option<Self> {
        match name {
            CurveName::Linear => Some(Self::Linear),
            CurveName::EaseIn => Some(Self::EaseIn),
            CurveName::EaseOut => Some(Self::EaseOut),
            CurveName::EaseInOut => Some(Self::EaseInOut),
            CurveName::Overshoot => Some(Self::Overshoot),
            CurveName::Anticipate => Some(Self::Anticipate),
            CurveName::Bezier => None,
        }
    }
}

/// Height of the bump that makes an overshoot.
const BUMP: f64 = 8.0;

fn least_jerk(u: f64) -> f64 {
    u * u * u * (10.0 + u * (6.0 * u - 15.0))
}

fn overshoot(u: f64) -> f64 {
    let rest = 1.0 - u;
    least_jerk(u) + BUMP * u * u * u * rest * rest
}

fn overshoot_slope(u: f64) -> f64 {
    let rest = 1.0 - u;
    30.0 * u * u * rest * rest + BUMP * u * u * rest * (3.0 - 5.0 * u)
}

/// One coordinate of a Bezier with ends 0 and 1 and handles `p1`, `p2`: `3t(1−t)²p1 + 3t²(1−t)p2 + t³`.
fn bezier(p1: f64, p2: f64, t: f64) -> f64 {
    let r = 1.0 - t;
    3.0 * t * r * (r * p1 + t * p2) + t * t * t
}

fn bezier_slope(p1: f64, p2: f64, t: f64) -> f64 {
    let r = 1.0 - t;
    3.0 * (r * r * p1 + 2.0 * r * t * (p2 - p1) + t * t * (1.0 - p2))
}

/// Parameter at which the x coordinate is `u`: bisection, because Newton stalls where handles are level.
fn bezier_parameter(x1: f64, x2: f64, u: f64) -> f64 {
    let (mut lo, mut hi) = (0.0, 1.0);
    // 60 halvings pass the spacing of doubles
    for _ in 0..60 {
        let mid = 0.5 * (lo + hi);
        if bezier(x1, x2, mid) < u { lo = mid } else { hi = mid }
    }
    0.5 * (lo + hi)
}

/// 0 up to `x = 0`, 1 from `x = 1`, between them the cubic 3x² − 2x³ that is level at both ends: for what fades in and
/// out. Transitions have [`Curve`].
pub fn smoothstep(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

impl Curve {
    /// The fraction of the way at `u`; `u` is clamped to [0, 1], whose ends give 0 and 1 exactly.
    pub fn at(&self, u: f64) -> f64 {
        if u <= 0.0 {
            return 0.0;
        }
        if u >= 1.0 {
            return 1.0;
        }
        match *self {
            Curve::Linear => u,
            Curve::EaseIn => u * u,
            Curve::EaseOut => u * (2.0 - u),
            Curve::EaseInOut => least_jerk(u),
            Curve::Overshoot => overshoot(u),
            Curve::Anticipate => 1.0 - overshoot(1.0 - u),
            Curve::Bezier(x1, y1, x2, y2) => bezier(y1, y2, bezier_parameter(x1, x2, u)),
        }
    }

    /// Slope `ds/du` at `u`, clamped to [0, 1]: one-sided at the ends.
    ///
    /// Where a Bezier is vertical (`x1 = 0` or `x2 = 1`) the slope is taken a millionth of its parameter
    /// inside, so it is large but finite.
    pub fn slope(&self, u: f64) -> f64 {
        let u = u.clamp(0.0, 1.0);
        match *self {
            Curve::Linear => 1.0,
            Curve::EaseIn => 2.0 * u,
            Curve::EaseOut => 2.0 * (1.0 - u),
            Curve::EaseInOut => 30.0 * u * u * (1.0 - u) * (1.0 - u),
            Curve::Overshoot => overshoot_slope(u),
            Curve::Anticipate => overshoot_slope(1.0 - u),
            Curve::Bezier(x1, y1, x2, y2) => {
                let t = bezier_parameter(x1, x2, u).clamp(1e-6, 1.0 - 1e-6);
                bezier_slope(y1, y2, t) / bezier_slope(x1, x2, t).max(1e-12)
            }
        }
    }

    /// Whether the numbers of the curve are usable: all finite, Bezier handles with x in [0, 1].
    pub fn is_valid(&self) -> bool {
        match *self {
            Curve::Bezier(x1, y1, x2, y2) => {
                (0.0..=1.0).contains(&x1) && (0.0..=1.0).contains(&x2) && y1.is_finite() && y2.is_finite()
            }
            _ => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Curve; 8] = [
        Curve::Linear,
        Curve::EaseIn,
        Curve::EaseOut,
        Curve::EaseInOut,
        Curve::Overshoot,
        Curve::Anticipate,
        Curve::Bezier(0.25, 0.1, 0.25, 1.0),
        Curve::Bezier(0.7, -0.4, 0.3, 1.6),
    ];

    #[test]
    fn ends_are_exact_and_joined_smoothly() {
        for c in ALL {
            assert_eq!((c.at(0.0), c.at(1.0)), (0.0, 1.0), "{c:?}");
            assert_eq!((c.at(-3.0), c.at(7.0)), (0.0, 1.0), "{c:?}");
            assert!(c.at(1e-9).abs() < 1e-7 && (c.at(1.0 - 1e-9) - 1.0).abs() < 1e-7, "{c:?}");
        }
    }

    /// Two roads to one number: the slope and central differences. 4e-9 seen.
    #[test]
    fn slope_is_the_derivative() {
        for c in ALL {
            for i in 1..200 {
                let (u, h) = (f64::from(i) / 200.0, 1e-6);
                let difference = (c.at(u + h) - c.at(u - h)) / (2.0 * h);
                assert!((difference - c.slope(u)).abs() < 1e-7, "{c:?} at {u}: {difference}");
            }
        }
    }

    #[test]
    fn overshoot_passes_the_end_and_anticipation_mirrors_it() {
        let peak = (0..=1000).map(|i| Curve::Overshoot.at(f64::from(i) / 1000.0)).fold(0.0, f64::max);
        assert!((peak - 1.1097).abs() < 1e-3, "{peak}");
        for i in 0..=100 {
            let u = f64::from(i) / 100.0;
            assert!((Curve::Anticipate.at(u) - (1.0 - Curve::Overshoot.at(1.0 - u))).abs() < 1e-15);
        }
    }

    /// The CSS curve `ease` at half time, from the specification's formula solved by hand: 0.8024.
    #[test]
    fn bezier_is_that_of_css() {
        let ease = Curve::Bezier(0.25, 0.1, 0.25, 1.0);
        assert!((ease.at(0.5) - 0.802_403_387_9).abs() < 1e-9, "{}", ease.at(0.5));
        let line = Curve::Bezier(1.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0);
        assert!((line.at(0.37) - 0.37).abs() < 1e-14);
    }

    #[test]
    fn vertical_handles_have_a_finite_slope() {
        let c = Curve::Bezier(0.0, 1.0, 1.0, 0.0);
        assert!(c.is_valid() && c.slope(0.0).is_finite() && c.slope(1.0).is_finite());
        assert!(!Curve::Bezier(1.2, 0.0, 0.5, 1.0).is_valid());
        assert!(!Curve::Bezier(0.2, f64::NAN, 0.5, 1.0).is_valid());
    }
}
