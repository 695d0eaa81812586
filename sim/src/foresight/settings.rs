//! How far foresight looks and how hard it searches, and the words for it.

use std::ops::RangeInclusive;
use std::str::FromStr;

use thiserror::Error;

use super::cost::Scales;
use crate::core::Effort;

/// How far a body looks ahead, and how hard it searches. `docs/WALKING.md` has the measurements behind the defaults.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// How far ahead, s; longer sees a fall earlier and costs in proportion.
    pub horizon_s: f64,
    /// Rollouts of every window of the horizon; more find better offsets and cost in proportion.
    pub rollouts: usize,
    /// Part of the rollouts of a window whose states go on to the next.
    pub beam: f64,
    /// Time from knot to knot and from search to search, s.
    pub window_s: f64,
    /// Control steps of the pass in one step of a rollout.
    pub stride: usize,
    /// How exactly rollouts are solved.
    pub effort: Effort,
    /// Factor on the deviations of all channels.
    pub width: f64,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Scales of the cost.
    pub scales: Scales,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            horizon_s: 0.5,
            rollouts: 600,
            beam: 0.15,
            window_s: 0.1,
            stride: 2,
            effort: Effort::Rough,
            width: 1.0,
            seed: 1,
            scales: Scales::default(),
        }
    }
}

impl Settings {
    /// For looking at a motion quickly: four tenths of the rollouts.
    pub fn draft() -> Self {
        Self { rollouts: 240, ..Self::default() }
    }

    /// Windows in the horizon, at least one.
    pub(crate) fn windows(&self) -> usize {
        ((self.horizon_s / self.window_s).round() as usize).max(1)
    }

    /// States that go on from window to window, at least one.
    pub(crate) fn kept(&self) -> usize {
        ((self.beam * self.rollouts as f64).round() as usize).clamp(1, self.rollouts.max(1))
    }
}

/// How far ahead may be asked for, s.
pub const HORIZONS: RangeInclusive<f64> = 0.1..=2.0;
/// How many rollouts may be asked for.
pub const ROLLOUTS: RangeInclusive<usize> = 10..=100_000;

/// Foresight as a command line names it.
///
/// # Examples
/// ```
/// use sim::foresight::{Choice, Settings};
/// assert_eq!("off".parse::<Choice>().unwrap().settings(), None);
/// assert_eq!("draft".parse::<Choice>().unwrap().settings(), Some(Settings::draft()));
/// let asked = "0.4,900".parse::<Choice>().unwrap().settings().unwrap();
/// assert_eq!((asked.horizon_s, asked.rollouts), (0.4, 900));
/// assert!("0.4".parse::<Choice>().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Choice {
    /// Muscles and contacts alone: `off`.
    Off,
    /// As [`Settings::default`]: `on`.
    On,
    /// As [`Settings::draft`]: `draft`.
    Draft,
    /// So many seconds and rollouts: `SECONDS,ROLLOUTS`.
    Of(f64, usize),
}

/// A text that is no [`Choice`].
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error(
    "`{0}` is no foresight; allowed: off, on, draft, or SECONDS,ROLLOUTS with {from_s} to {to_s} s and {least} to {most} rollouts",
    from_s = HORIZONS.start(), to_s = HORIZONS.end(), least = ROLLOUTS.start(), most = ROLLOUTS.end()
)]
pub struct ChoiceError(String);

impl FromStr for Choice {
    type Err = ChoiceError;

    fn from_str(text: &str) -> Result<Self, ChoiceError> {
        let numbers = |text: &str| {
            let (seconds, rollouts) = text.split_once(',')?;
            let seconds = seconds.trim().parse().ok().filter(|s| HORIZONS.contains(s))?;
            let rollouts = rollouts.trim().parse().ok().filter(|n| ROLLOUTS.contains(n))?;
            Some(Self::Of(seconds, rollouts))
        };
        match text {
            "off" => Ok(Self::Off),
            "on" => Ok(Self::On),
            "draft" => Ok(Self::Draft),
            _ => numbers(text).ok_or_else(|| ChoiceError(text.into())),
        }
    }
}

impl Choice {
    /// The settings asked for; `None` where there is to be no foresight.
    pub fn settings(self) -> Option<Settings> {
        match self {
            Self::Off => None,
            Self::On => Some(Settings::default()),
            Self::Draft => Some(Settings::draft()),
            Self::Of(horizon_s, rollouts) => Some(Settings { horizon_s, rollouts, ..Settings::default() }),
        }
    }
}
