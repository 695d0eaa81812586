//! Overrides: numbers of the dynamic pass given beside the file, as on a command line.
//!
//! In: text such as `assisted:80,50`. Out: changes to [`Physics`]. The ranges allowed are those of a
//! scene file.

use std::ops::RangeInclusive;
use std::str::FromStr;

use bodies::soles::{Pads, Toes};
use bodies::{Character, Prop};
pub use controllers::Strategy;
use dynamics::RootMode;
pub use dynamics::RootName;
use motion::Kinematics;
use motion::names::Word;

use crate::conditions::{ConditionsSpec, Physics, SoleKind, ToesKind};
pub use crate::conditions::{SoleName, ToesName};
use crate::props::prop_of;
use crate::{Patch, SceneError};

/// Rates a simulation may run at, Hz.
pub const RATES: RangeInclusive<f64> = 30.0..=20_000.0;
/// Tensions a scene may ask for; 1 = natural.
pub const TENSIONS: RangeInclusive<f64> = 1e-3..=1e3;
/// Engine substeps a control step may have.
pub const SUBSTEPS: RangeInclusive<usize> = 1..=64;

/// Default force of an assisted root, part of the body weight.
const ASSIST_WEIGHT: f64 = 0.1;
/// Default moment of an assisted root, N·m.
const ASSIST_MOMENT: f64 = 50.0;
/// Factor on every tension at fidelity 1.
const STIFFEST: f64 = 4.0;
/// Largest budget of an assisted root, N and N·m.
const BUDGETS: RangeInclusive<f64> = 0.0..=1e6;

/// What is to hold the root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RootChoice {
    /// Muscles and contacts only: `free`.
    Free,
    /// A wrench within a budget: `assisted`, which takes 10 % of the body weight and 50 N·m, or
    /// `assisted:FORCE_N,MOMENT_NM`.
    Assisted(Option<(f64, f64)>),
    /// The kinematic path: `pinned`.
    Pinned,
    /// A wrench whose budget grows with a number from 0 to 1, see [`set_fidelity`].
    Fidelity(f64),
}

/// Sets a fidelity `f` from 0 to 1: how closely the motion asked for is to be followed, whatever it costs.
///
/// At 0 nothing changes but that the root is free. Above, the root is assisted by at most `f²` of the body weight, and
/// by at most the moment of that force at the height `h` of the root above the soles in the rest pose, `f² m g h`: at
/// 1 the help could carry the body, at 0.32 it is the 10 % of `assisted`; how it pulls is in
/// [`controllers::assist`]. And all tensions are multiplied by `4^f`.
pub fn set_fidelity(physics: &mut Physics, f: f64, character: &Character) {
    let f = f.clamp(0.0, 1.0);
    physics.tension *= STIFFEST.powf(f);
    physics.root = RootMode::Free;
    if f > 0.0 {
        let skeleton = &character.skeleton;
        let k = Kinematics::new(skeleton, &character.rest);
        let sites = character.contacts.iter().map(|&c| &skeleton.sites()[c]);
        let sites = sites.map(|s| k.point(s.link, &s.at).y);
        let links = k.world.iter().map(|w| w.translation.y);
        let lowest = sites.chain(links).fold(f64::INFINITY, f64::min);
        let force_n = f * f * character.mass() * physics.gravity.norm();
        physics.root = RootMode::Assisted { force_n, moment_nm: force_n * (k.origin(0).y - lowest) };
    }
}

/// A text that is no [`RootChoice`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` holds no root; allowed: {free}, {pinned}, {assisted}, or {assisted}:FORCE_N,MOMENT_NM with numbers from 0 to 1000000",
    free = RootName::Free.word(),
    pinned = RootName::Pinned.word(),
    assisted = RootName::Assisted.word()
)]
pub struct RootChoiceError(String);

impl FromStr for RootChoice {
    type Err = RootChoiceError;

    fn from_str(text: &str) -> Result<Self, RootChoiceError> {
        let number = |s: &str| s.trim().parse().ok().filter(|x| BUDGETS.contains(x));
        let (name, budget) = match text.split_once(':') {
            Some((name, budget)) => (name, Some(budget)),
            None => (text, None),
        };
        let choice = match (RootName::find(name).ok(), budget) {
            (Some(RootName::Free), None) => Some(Self::Free),
            (Some(RootName::Pinned), None) => Some(Self::Pinned),
            (Some(RootName::Assisted), None) => Some(Self::Assisted(None)),
            (Some(RootName::Assisted), Some(budget)) => budget
                .split_once(',')
                .and_then(|(force, moment)| Some((number(force)?, number(moment)?)))
                .map(|budget| Self::Assisted(Some(budget))),
            _ => None, // a fidelity has an option of its own
        };
        choice.ok_or_else(|| RootChoiceError(text.into()))
    }
}

/// What is to differ from the file; `None` leaves it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overrides {
    /// Parameters of tension and balance; comes before the factor on the tension.
    pub patch: Option<Patch>,
    /// What holds the root.
    pub root: Option<RootChoice>,
    /// Factor on the file's tension.
    pub tension: Option<f64>,
    /// Control steps per second, Hz.
    pub rate_hz: Option<f64>,
    /// Engine substeps per control step.
    pub substeps: Option<usize>,
    /// Strategies of balance to switch off, beside those the file does.
    pub without: Vec<Strategy>,
    /// Part of a clip, from and to, s.
    pub span_s: Option<(f64, f64)>,
    /// Go on after a fall.
    pub past_fall: bool,
    /// Props beside those of the file.
    pub props: Vec<Prop>,
    /// Let links touch each other.
    pub self_collision: bool,
    /// What the soles are; pads have the file's numbers where it has some.
    pub soles: Option<SoleName>,
    /// What the toes do; those that bend have the file's numbers where it has some.
    pub toes: Option<ToesName>,
}

/// How long a clip may go on, s.
pub const LOOPS_S: RangeInclusive<f64> = 0.1..=3600.0;

/// Reads a part of a clip: `FROM..TO` in seconds.
///
/// # Errors
/// What is allowed.
pub fn span(text: &str) -> Result<(f64, f64), String> {
    let number = |s: &str| s.trim().parse::<f64>().ok().filter(|x| (0.0..=1e6).contains(x));
    let ends = text.split_once("..").and_then(|(a, b)| Some((number(a)?, number(b)?)));
    ends.filter(|(a, b)| a < b)
        .ok_or_else(|| "allowed: FROM..TO in seconds, FROM before TO, such as 2.5..7".into())
}

/// Reads how long a clip goes on, s.
///
/// # Errors
/// What is allowed.
pub fn loop_s(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|s| LOOPS_S.contains(s));
    seconds.ok_or_else(|| format!("allowed: {} to {} s", LOOPS_S.start(), LOOPS_S.end()))
}

/// Reads props as a scene has them, each a text of its own.
///
/// # Errors
/// Syntax, numbers out of range: at their place.
pub fn props(texts: &[String]) -> Result<Vec<Prop>, SceneError> {
    texts.iter().enumerate().map(|(i, text)| prop_of(text, i)).collect()
}

impl Overrides {
    /// Changes `physics` for a body. Numbers out of range are taken to its nearest end.
    pub fn apply(&self, physics: &mut Physics, character: &Character) {
        let clamp = |x: f64, range: RangeInclusive<f64>| x.clamp(*range.start(), *range.end());
        match self.root {
            None | Some(RootChoice::Fidelity(_)) => {}
            Some(RootChoice::Free) => physics.root = RootMode::Free,
            Some(RootChoice::Pinned) => physics.root = RootMode::Pinned,
            Some(RootChoice::Assisted(budget)) => {
                let weight = character.mass() * physics.gravity.norm();
                let (force_n, moment_nm) = budget.unwrap_or((ASSIST_WEIGHT * weight, ASSIST_MOMENT));
                physics.root = RootMode::Assisted { force_n, moment_nm };
            }
        }
        if let Some(RootChoice::Fidelity(f)) = self.root {
            set_fidelity(physics, f, character);
        }
        if let Some(patch) = &self.patch {
            patch.apply(physics);
        }
        if let Some(factor) = self.tension {
            physics.tension = clamp(physics.tension * factor, TENSIONS);
        }
        if let Some(rate_hz) = self.rate_hz {
            physics.rate_hz = Some(clamp(rate_hz, RATES));
        }
        if let Some(n) = self.substeps {
            physics.substeps = Some(n.clamp(*SUBSTEPS.start(), *SUBSTEPS.end()));
        }
        physics.past_fall |= self.past_fall;
        physics.soles = match (self.soles, physics.soles) {
            (None, file) | (Some(SoleName::Pads), file @ Some(SoleKind::Pads(_))) => file,
            (Some(SoleName::Pads), _) => Some(SoleKind::Pads(Pads::default())),
            (Some(SoleName::Rigid), _) => Some(SoleKind::Rigid),
        };
        physics.toes = match (self.toes, physics.toes) {
            (None, file) | (Some(ToesName::Bend), file @ Some(ToesKind::Bend(_))) => file,
            (Some(ToesName::Bend), _) => Some(ToesKind::Bend(Toes::default())),
            (Some(ToesName::Welded), _) => Some(ToesKind::Welded),
        };
        for &strategy in &self.without {
            physics.balance = physics.balance.without(strategy);
        }
    }

    /// Changes what is in the world beside the ground.
    pub fn apply_world(&self, conditions: &mut ConditionsSpec) {
        for prop in &self.props {
            let mut prop = prop.clone();
            if conditions.props.iter().any(|p| p.name == prop.name) {
                prop.name += " of the command line";
            }
            conditions.props.push(prop);
        }
        conditions.self_collision |= self.self_collision;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A word of the command line goes before the file's; pads keep the numbers that the file has.
    #[test]
    fn soles_keep_the_numbers_of_the_file() {
        let human = bodies::anthropometry::human::human().0;
        let mut pads = Pads::default();
        pads.heel.stiffness_n_m = 7e4;
        let bend = Toes { stiffness_nm_rad: 9.0, ..Toes::default() };
        let file = [(None, None), (Some(SoleKind::Pads(pads)), Some(ToesKind::Bend(bend)))];
        let applied = |(soles, toes), asked: Overrides| {
            let mut physics = Physics { soles, toes, ..Physics::of_clip() };
            asked.apply(&mut physics, &human);
            (physics.soles, physics.toes)
        };
        let asked = |soles, toes| Overrides { soles: Some(soles), toes: Some(toes), ..Overrides::default() };
        for of_file in file {
            assert_eq!(applied(of_file, Overrides::default()), of_file);
            let hard = applied(of_file, asked(SoleName::Rigid, ToesName::Welded));
            assert_eq!(hard, (Some(SoleKind::Rigid), Some(ToesKind::Welded)));
        }
        let soft = |of_file| applied(of_file, asked(SoleName::Pads, ToesName::Bend));
        assert_eq!(
            soft(file[0]),
            (Some(SoleKind::Pads(Pads::default())), Some(ToesKind::Bend(Toes::default())))
        );
        assert_eq!(soft(file[1]), file[1]);
    }

    #[test]
    fn roots_are_read_and_refused() {
        for free in ["free", "Free"] {
            assert_eq!(free.parse(), Ok(RootChoice::Free));
        }
        assert_eq!("assisted".parse(), Ok(RootChoice::Assisted(None)));
        assert_eq!("assisted:80, 50".parse(), Ok(RootChoice::Assisted(Some((80.0, 50.0)))));
        for bad in [
            "",
            "fre",
            "free:1,2",
            "fidelity",
            "assisted:",
            "assisted:80",
            "assisted:-1,2",
            "assisted:NaN,1",
            "assisted:1,inf",
        ] {
            let refused = bad.parse::<RootChoice>();
            assert_eq!(refused, Err(RootChoiceError(bad.into())), "{bad}");
        }
    }
}
