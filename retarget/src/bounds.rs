//! By how much each stage may move a motion, and what is said of it.

use motion::names::Word;

/// What a stage may do. See [`mod@crate::guard`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Farthest turn of a joint, rad.
    pub joint_rad: f64,
    /// Farthest turn of a joint that follows by dynamics, rad.
    pub swaying_rad: f64,
    /// Farthest way of the root over the stature.
    pub root_share: f64,
    /// Farthest turn of the root, rad.
    pub root_rad: f64,
    /// Largest speed over that of the stage before.
    pub speed: f64,
    /// Largest acceleration over that of the stage before.
    pub acceleration: f64,
    /// Whether links may be as deep in one another as they were anywhere in the clip, rather than nearby: what comes after parts
    /// them.
    pub deep_elsewhere: bool,
    /// Whether displacements saturate near their bounds; otherwise the stage gives way where they are beyond, since a foot that
    /// is nearly where it rests slips.
    pub saturate: bool,
}

const DEG: f64 = std::f64::consts::PI / 180.0;

impl Bounds {
    /// Of the global transform, against the same clip with the human's heading: the heading follows the momentum. No joint turns, but for
    /// rounding.
    pub const GLOBAL: Self = Self {
        joint_rad: 1e-6,
        swaying_rad: 1e-6,
        root_share: 0.5,
        root_rad: 90.0 * DEG,
        speed: 3.0,
        acceleration: 5.0,
        deep_elsewhere: true,
        saturate: false,
    };
    /// Of contact adjustment: legs reach for places, a plate lies flat.
    pub const CONTACT: Self = Self {
        joint_rad: 60.0 * DEG,
        swaying_rad: 60.0 * DEG,
        root_share: 0.2,
        root_rad: 90.0 * DEG,
        speed: 3.0,
        acceleration: 5.0,
        deep_elsewhere: true,
        saturate: false,
    };
    /// Of parts that swing and of links turned apart: the end of a whip is faster than the hand.
    pub const SWAY: Self = Self {
        joint_rad: 25.0 * DEG,
        swaying_rad: 60.0 * DEG,
        root_share: 0.0,
        root_rad: 0.0,
        speed: 4.0,
        acceleration: 8.0,
        deep_elsewhere: false,
        saturate: true,
    };
    /// Of the refinement. Joints turn only if they are asked to.
    pub const REFINE: Self = Self {
        joint_rad: 90.0 * DEG,
        swaying_rad: 90.0 * DEG,
        root_share: 0.1,
        root_rad: 45.0 * DEG,
        speed: 3.0,
        acceleration: 5.0,
        deep_elsewhere: false,
        saturate: true,
    };
}

/// A stage as it is held to bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// The global transform.
    Global,
    /// Contact adjustment.
    Contact,
    /// Parts that swing, and links turned apart that would be in one another.
    Sway,
    /// The refinement.
    Refine,
}

impl Word for Step {
    const KIND: &'static str = "step";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Global, "global", "The heading that the momentum asks for"),
        (Self::Contact, "contact", "Contact points held on the ground"),
        (Self::Sway, "sway", "Parts that follow by dynamics, links turned apart"),
        (Self::Refine, "refine", "Forces that a ground can give"),
    ];
}

/// A joint that was turned.
#[derive(Clone, Debug, PartialEq)]
pub struct Turned {
    /// Its link.
    pub link: String,
    /// How far, rad.
    pub rad: f64,
    /// When, s.
    pub at_s: f64,
}

/// How far a stage moved the motion from the stage before.
#[derive(Clone, Debug, PartialEq)]
pub struct StepReport {
    /// The stage.
    pub step: Step,
    /// What it was held to.
    pub bounds: Bounds,
    /// Farthest way of the root that is allowed, m.
    pub root_bound_m: f64,
    /// The joint that was turned farthest; `None` if none was.
    pub joint: Option<Turned>,
    /// The largest displacement over its bound.
    pub nearest_bound: f64,
    /// Farthest way of the root, or of a slide, m.
    pub root_m: f64,
    /// Farthest turn of the root, rad.
    pub root_rad: f64,
    /// Largest speed over the fastest of the stage before nearby.
    pub speed: f64,
    /// Largest acceleration likewise.
    pub acceleration: f64,
    /// Deepest that links are in one another, before and after, m.
    pub penetration_m: [f64; 2],
    /// Times in which the stage was held back, because a speed, an acceleration or a depth would have been beyond, s.
    pub held_back_s: Vec<[f64; 2]>,
}

impl StepReport {
    /// Share of a bound, of a displacement, a speed or an acceleration, from which on a stage is said to be at it.
    pub const AT_BOUND: f64 = 0.95;

    /// Whether a displacement is at its bound.
    pub fn at_bound(&self) -> bool {
        self.nearest_bound > Self::AT_BOUND
    }
}
