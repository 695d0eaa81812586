//! What a motion made possible says in words: weights that shift, and what could not be made possible.
//!
//! Units: m, s; world frame, y up.

use std::fmt;

use motion::{Clip, ContactPlan, Kinematics, Sole, Vec3};

/// Smaller shifts are not worth a word, m.
const WORTH_M: f64 = 0.02;
/// Times of trouble closer than this are one, s.
const NEAR_S: f64 = 0.1;
/// Shorter trouble is not worth a word, s.
const LASTS_S: f64 = 0.05;

/// A shift of the weight.
#[derive(Clone, Debug, PartialEq)]
pub struct WeightShift {
    /// From when on, s.
    pub from_s: f64,
    /// Until when, s.
    pub to_s: f64,
    /// The furthest, m.
    pub by_m: f64,
    /// The foot that it goes to: of those that stand then, the one in its direction; `None` where it goes to none.
    pub to: Option<String>,
}

impl fmt::Display for WeightShift {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { from_s, to_s, by_m, to } = self;
        write!(f, "weight shifts {:.0} mm", 1e3 * by_m)?;
        if let Some(to) = to {
            write!(f, " to {to}")?;
        }
        write!(f, " from {from_s:.1} s to {to_s:.1} s")
    }
}

impl WeightShift {
    /// The shifts over the ground worth a word.
    pub fn all(shift: &[Vec3], plan: &ContactPlan, soles: &[Sole], clip: &Clip) -> Vec<Self> {
        let across: Vec<f64> = shift.iter().map(|s| s.x.hypot(s.z)).collect();
        let to = |at: usize| {
            let t_s = at as f64 / clip.rate_hz;
            let k = Kinematics::new(&clip.skeleton, clip.pose(at));
            let way = Vec3::new(shift[at].x, 0.0, shift[at].z);
            let from = k.origin(0);
            let along = |s: &Sole| (s.center(&k) - from).dot(&way) / way.norm().max(1e-9);
            let standing = soles.iter().filter(|s| plan.at(t_s).any(|c| c.point == s.name));
            let nearest = standing.max_by(|a, b| along(a).total_cmp(&along(b)))?;
            (along(nearest) > 0.0).then(|| nearest.name.clone())
        };
        let mut out = Vec::new();
        let mut f = 0;
        while f < across.len() {
            let end = (f..across.len()).find(|x| across[*x] < 0.5 * WORTH_M).unwrap_or(across.len());
            let most = (f..end).max_by(|a, b| across[*a].total_cmp(&across[*b]));
            if let Some(most) = most.filter(|at| across[*at] >= WORTH_M) {
                let time = |f: usize| f as f64 / clip.rate_hz;
                out.push(Self { from_s: time(f), to_s: time(end - 1), by_m: across[most], to: to(most) });
            }
            f = end.max(f + 1);
        }
        out
    }
}

/// What could not be made possible: where, when, by how much; and in what the whole is no longer what was captured.
#[derive(Clone, Debug, PartialEq)]
pub enum Unmet {
    /// The ground would have to push outside the soles.
    Pressure {
        /// From, s.
        from_s: f64,
        /// Until, s.
        to_s: f64,
        /// The furthest outside, m.
        by_m: f64,
    },
    /// Something bears the body that is no sole: hands, a prop.
    Held {
        /// From, s.
        from_s: f64,
        /// Until, s.
        to_s: f64,
    },
    /// A leg that is too short for its foot.
    Reach {
        /// The leg.
        limb: String,
        /// From, s.
        from_s: f64,
        /// Until, s.
        to_s: f64,
        /// The furthest, m.
        by_m: f64,
    },
    /// A body that is far from what was asked.
    Far {
        /// From, s.
        from_s: f64,
        /// Until, s.
        to_s: f64,
        /// The furthest, mean over its links, m.
        by_m: f64,
    },
    /// The whole motion is far from its capture.
    Links {
        /// RMS over links and frames, m.
        by_m: f64,
    },
    /// The upper body is turned.
    Upper {
        /// RMS, degrees.
        by_deg: f64,
    },
    /// A sole comes down or leaves at another time than planned.
    Times {
        /// The leg.
        limb: String,
        /// When it was to, s.
        at_s: f64,
        /// How much later it does, s.
        by_s: f64,
    },
    /// Contacts that are in the plan or in the motion only.
    Contacts {
        /// How many.
        count: usize,
    },
    /// A flight of another height.
    Rise {
        /// Part of the captured.
        by: f64,
    },
    /// A stride of another length.
    Stride {
        /// Part of the captured.
        by: f64,
    },
}

impl fmt::Display for Unmet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pressure { from_s, to_s, by_m } => write!(
                f,
                "{from_s:.2}–{to_s:.2} s: the ground would have to push up to {:.0} mm outside the soles that stand",
                1e3 * by_m
            ),
            Self::Held { from_s, to_s } => {
                write!(f, "{from_s:.2}–{to_s:.2} s: something bears the body, but no sole is near the ground")
            }
            Self::Reach { limb, from_s, to_s, by_m } => {
                write!(
                    f,
                    "{from_s:.2}–{to_s:.2} s: {limb} is up to {:.0} mm too short for its foot",
                    1e3 * by_m
                )
            }
            Self::Far { from_s, to_s, by_m } => {
                write!(
                    f,
                    "{from_s:.2}–{to_s:.2} s: the body is up to {:.0} mm from what was asked",
                    1e3 * by_m
                )
            }
            Self::Links { by_m } => write!(f, "links are {:.0} mm from the capture", 1e3 * by_m),
            Self::Upper { by_deg } => write!(f, "the upper body is turned by {by_deg:.1}°"),
            Self::Times { limb, at_s, by_s } => {
                let when = if *by_s < 0.0 { "early" } else { "late" };
                write!(f, "{at_s:.2} s: {limb} comes down or leaves {:.2} s too {when}", by_s.abs())
            }
            Self::Contacts { count: 1 } => {
                write!(f, "one contact is in the plan or in the motion, but not in both")
            }
            Self::Contacts { count } => {
                write!(f, "{count} contacts are in the plan or in the motion, but not in both")
            }
            Self::Rise { by } => {
                let than = if *by < 0.0 { "less high" } else { "higher" };
                write!(f, "a flight rises {:.0} % {than} than captured", 100.0 * by.abs())
            }
            Self::Stride { by } => {
                let than = if *by < 0.0 { "shorter" } else { "longer" };
                write!(f, "a stride is {:.0} % {than} than captured", 100.0 * by.abs())
            }
        }
    }
}

impl Unmet {
    /// The times in which a value is above its limit for [`LASTS_S`], those near one another as one.
    pub(crate) fn spans(
        values: &[f64],
        limit: f64,
        rate_hz: f64,
        of: impl Fn(f64, f64, f64) -> Self,
    ) -> Vec<Self> {
        let mut spans: Vec<(usize, usize, f64)> = Vec::new();
        for (f, value) in values.iter().enumerate().filter(|(_, v)| **v > limit) {
            match spans.last_mut().filter(|s| (f - s.1) as f64 <= NEAR_S * rate_hz) {
                Some(last) => *last = (last.0, f, last.2.max(*value)),
                None => spans.push((f, f, *value)),
            }
        }
        spans.retain(|(a, b, _)| (b - a + 1) as f64 >= LASTS_S * rate_hz);
        spans.into_iter().map(|(a, b, by)| of(a as f64 / rate_hz, b as f64 / rate_hz, by)).collect()
    }
}
