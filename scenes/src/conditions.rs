//! Conditions of a performance, as a file states them: what acts on the body, what holds it, how it is simulated.
//!
//! In: numbers of a scene, of a command line, of a patch. Out: plain values in SI units. What has a time keeps either the
//! motion's or the world's ([`Clock`]): an edit that retimes the motion moves the first and leaves the second.

use bodies::Prop;
use bodies::soles::{Pads, Toes};
use controllers::{BalanceSettings, GainBlend, Gaze};
use dynamics::conditions::Carrying;
use dynamics::conditions::{GRAVITY, Push, RootMode};
use motion::floor::FRICTION;
use motion::names::Word;
use motion::{Floor, Tilt, Vec3};

use crate::ProgramSpec;

/// The engine that performs where no other is named.
pub const ENGINE: &str = "rapier";

/// The engine in which a study searches (many short runs) where no other is named.
pub const SEARCH_ENGINE: &str = "core";

/// Numbers of the dynamic pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Physics {
    /// Control steps per second, Hz; `None`: near 240, whole steps per frame of a clip.
    pub rate_hz: Option<f64>,
    /// Engine substeps; `None`: as many as the stiffest joint needs, at least two.
    pub substeps: Option<usize>,
    /// Factor on every tension.
    pub tension: f64,
    /// What transitions interpolate.
    pub blend: GainBlend,
    /// What holds the root.
    pub root: RootMode,
    /// Gravity, m/s².
    pub gravity: Vec3,
    /// The ground, if any.
    pub ground: Option<Floor>,
    /// Parameters of the balance property.
    pub balance: BalanceSettings,
    /// Go on after a fall, muscles and assist letting go, until the body rests; otherwise the run ends with the fall.
    pub past_fall: bool,
    /// What the soles are; `None`: pads under a body that steps by looking ahead and can have them, else rigid.
    pub soles: Option<SoleKind>,
    /// What the toes do; `None`: they are welded.
    pub toes: Option<ToesKind>,
}

impl Physics {
    /// Those of a clip without a scene: root pinned, level ground.
    pub fn of_clip() -> Self {
        Self {
            rate_hz: None,
            substeps: None,
            tension: 1.0,
            blend: GainBlend::RestAngle,
            root: RootMode::Pinned,
            gravity: GRAVITY,
            ground: Some(Floor::level(0.0, FRICTION)),
            balance: BalanceSettings::default(),
            past_fall: false,
            soles: None,
            toes: None,
        }
    }

    /// Magnitude of gravity, m/s²; `None` unless it points straight down.
    pub fn gravity_down_m_s2(&self) -> Option<f64> {
        let down = -self.gravity.y;
        (down > 0.0 && self.gravity.xz().norm() <= 1e-9 * down).then_some(down)
    }
}

/// What a sole is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SoleKind {
    /// As hard as the engine's contacts.
    Rigid,
    /// Pads under heel and ball.
    Pads(Pads),
}

/// The names of soles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SoleName {
    /// [`SoleKind::Rigid`].
    Rigid,
    /// [`SoleKind::Pads`].
    Pads,
}

impl Word for SoleName {
    const KIND: &'static str = "sole";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Rigid, "rigid", "As hard as the engine's contacts"),
        (Self::Pads, "pads", "Pads under heel and ball that give way as tissue does"),
    ];
}

/// What toes do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ToesKind {
    /// They are parts of their foot.
    Welded,
    /// They bend about a hinge where the rig's toes begin.
    Bend(Toes),
}

/// The names of what toes do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToesName {
    /// [`ToesKind::Welded`].
    Welded,
    /// [`ToesKind::Bend`].
    Bend,
}

impl Word for ToesName {
    const KIND: &'static str = "kind of toes";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Welded, "welded", "They are parts of their foot"),
        (Self::Bend, "bend", "They bend about a hinge where the rig's toes begin, held by a spring"),
    ];
}

/// Whose time something keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Clock {
    /// That of the motion: it happens at the same moment of the motion, wherever that is moved to.
    #[default]
    Motion,
    /// That of the world: it happens when the scene says, whatever the motion does.
    World,
}

impl Word for Clock {
    const KIND: &'static str = "clock";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Motion, "motion", "It happens at the same moment of the motion, wherever that is moved to"),
        (Self::World, "world", "It happens when the scene says, whatever the motion does"),
    ];
}

/// The names of grounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GroundName {
    /// None: the body hangs in the air.
    None,
    /// A plane.
    Plane,
}

impl Word for GroundName {
    const KIND: &'static str = "ground";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::None, "none", "The body hangs in the air"),
        (Self::Plane, "plane", "A plane, level or tilted"),
    ];
}

/// The names of props.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PropName {
    /// A box that stands upright.
    Box,
    /// A plank that rises.
    Ramp,
}

impl Word for PropName {
    const KIND: &'static str = "prop";
    const WORDS: &'static [(Self, &'static str, &'static str)] =
        &[(Self::Box, "box", "A box that stands upright"), (Self::Ramp, "ramp", "A plank that rises")];
}

/// A condition with the clock of its times.
#[derive(Clone, Debug, PartialEq)]
pub struct Timed<T> {
    /// The condition, at the times that the file says.
    pub value: T,
    /// Whose time it keeps.
    pub clock: Clock,
}

/// All conditions of a performance, as its file states them.
#[derive(Clone, Debug)]
pub struct ConditionsSpec {
    /// Numbers of the dynamic pass.
    pub physics: Physics,
    /// Whether the file says how high its ground is; if not, a clip stands where its feet are.
    pub height_given: bool,
    /// Turns of the ground, in order of time.
    pub tilts: Vec<Timed<Tilt>>,
    /// Boxes and ramps fixed in the world.
    pub props: Vec<Prop>,
    /// Whether links touch each other.
    pub self_collision: bool,
    /// Pushes from outside.
    pub pushes: Vec<Timed<Push>>,
    /// Masses carried.
    pub carried: Vec<Timed<Carrying>>,
    /// Gazes: reactive properties beside the balance.
    pub gazes: Vec<Timed<Gaze>>,
    /// Programs of the user: reactive properties that act after the gazes.
    pub programs: Vec<ProgramSpec>,
    /// Name of the engine asked for; `None`: [`ENGINE`] performs, [`SEARCH_ENGINE`] serves searches.
    pub engine: Option<String>,
}

impl ConditionsSpec {
    /// Those of a clip without a scene.
    pub fn of_clip() -> Self {
        Self {
            physics: Physics::of_clip(),
            height_given: false,
            tilts: Vec::new(),
            props: Vec::new(),
            self_collision: false,
            pushes: Vec::new(),
            carried: Vec::new(),
            gazes: Vec::new(),
            programs: Vec::new(),
            engine: None,
        }
    }
}
