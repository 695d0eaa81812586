//! Conditions of a performance: what acts on a body beside its own muscles.
//!
//! Plain values, no engine and no files. What holds the root ([`RootMode`]), pushes ([`Push`]), masses that are carried for a
//! time ([`Carrying`]). The floor and its turns are geometry: [`motion::Floor`], [`motion::Tilt`]. What of them acted in
//! a run is in its trace: [`crate::Disturbed`].
//!
//! Units: m, s, kg, N, N·m; times count from the beginning of the run; world frame, y up.

use bodies::Carried;
use motion::Vec3;
use motion::names::Word;

/// Gravity where nothing else is said: that of the Earth, world, m/s².
pub const GRAVITY: Vec3 = Vec3::new(0.0, -9.81, 0.0);

/// Least downward gravity in which feet stand, m/s²: a tenth of the Moon's. Below, a body takes seconds to fall back on its
/// feet, and nothing that feet do balances it.
pub const LEAST_GRAVITY: f64 = 0.16;

/// What holds the root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RootMode {
    /// Nothing but muscles and contacts.
    Free,
    /// A root wrench with a hard budget towards the kinematic path.
    Assisted {
        /// Largest force, N.
        force_n: f64,
        /// Largest moment, N·m.
        moment_nm: f64,
    },
    /// The root follows the kinematic path; only the limbs are dynamic.
    Pinned,
}

impl RootMode {
    /// Its name.
    pub fn name(self) -> RootName {
        match self {
            Self::Free => RootName::Free,
            Self::Assisted { .. } => RootName::Assisted,
            Self::Pinned => RootName::Pinned,
        }
    }
}

/// The names of what can be asked to hold the root. A run knows the three of [`RootMode`]; a fidelity becomes one of them
/// before it begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RootName {
    /// [`RootMode::Free`].
    Free,
    /// [`RootMode::Assisted`].
    Assisted,
    /// [`RootMode::Pinned`].
    Pinned,
    /// [`RootMode::Assisted`] with a budget that grows with a number from 0 to 1, and [`RootMode::Free`] at 0.
    Fidelity,
}

impl Word for RootName {
    const KIND: &'static str = "root";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Free, "free", "Muscles and contacts only"),
        (Self::Assisted, "assisted", "A wrench towards the kinematic path, within a budget"),
        (Self::Pinned, "pinned", "The root follows the kinematic path"),
        (Self::Fidelity, "fidelity", "Assisted with a budget that grows with a number from 0 to 1"),
    ];
}

/// A push from outside during a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Push {
    /// Link pushed.
    pub link: usize,
    /// Point in the link's frame, m.
    pub at: Vec3,
    /// Force, world, N.
    pub force: Vec3,
    /// When it begins, s.
    pub start_s: f64,
    /// How long it lasts, s.
    pub duration_s: f64,
}

impl Push {
    /// Whether it acts during the step that begins at a time, s.
    pub fn acts(&self, t_s: f64) -> bool {
        t_s >= self.start_s - 1e-9 && t_s < self.start_s + self.duration_s - 1e-9
    }
}

/// A mass that is carried for a part of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Carrying {
    /// The mass.
    pub what: Carried,
    /// When it is handed over, at the velocity of its link, s.
    pub from_s: f64,
    /// When it is taken, s; infinite if it is kept.
    pub to_s: f64,
    /// Whether the muscles are told: they hold the load from the moment it comes. If not they are surprised.
    pub known: bool,
}

impl Carrying {
    /// Whether it is carried during the step that begins at a time, s.
    pub fn at(&self, t_s: f64) -> bool {
        t_s > self.from_s - 1e-9 && t_s < self.to_s - 1e-9
    }
}
