//! What may be told to the pipeline; everything has a default.

use motion::{Shape, Smoothing};

use crate::contacts::Phase;

/// The statistical model of the static mapping.
pub use learn::Method as MappingModel;
/// Settings of the shared GPLVM.
pub use learn::{GplvmOptions, Locate};

/// Where the pipeline ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// After the static mapping: in place.
    Map,
    /// After the global transform.
    Global,
    /// After contact adjustment.
    Contact,
    /// After physics refinement.
    #[default]
    Refine,
}

/// How distances of travel scale.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum SizeRatio {
    /// As in the paper, per axis of the local frame: mean speed of the feature points when every degree of
    /// freedom turns at unit rate, one by one.
    #[default]
    PerAxis,
    /// The mean of depth and width for both: paths keep their shape.
    Uniform,
    /// A stated ratio.
    Fixed(f64),
}

/// Options of the global transform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlobalOptions {
    /// How distances of travel scale.
    pub size: SizeRatio,
    /// Below this frequency the yaw follows the human's, above it the momentum, Hz.
    pub drift_hz: f64,
}

impl Default for GlobalOptions {
    fn default() -> Self {
        Self { size: SizeRatio::PerAxis, drift_hz: 0.25 }
    }
}

/// Options of contact detection and adjustment.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactOptions {
    /// A human point is in contact below this height above the ground, m (of a figure of standard size).
    pub height_m: f64,
    /// And below this speed, m/s (likewise).
    pub speed_m_s: f64,
    /// Phases and gaps shorter than this are dropped, s.
    pub shortest_s: f64,
    /// Phases by hand; replaces what is found.
    pub phases: Option<Vec<Phase>>,
}

impl Default for ContactOptions {
    fn default() -> Self {
        Self { height_m: 0.025, speed_m_s: 0.6, shortest_s: 0.1, phases: None }
    }
}

/// Degrees of freedom that the refinement may move.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum RefineDofs {
    /// The height of the root: the paper's choice.
    #[default]
    RootHeight,
    /// The six of the root and those of all links between it and a contact point.
    RootAndLegs,
    /// Those of the named links (a free root gives six), and the root's height.
    Links(Vec<String>),
}

/// Options of the physics refinement.
#[derive(Clone, Debug, PartialEq)]
pub struct RefineOptions {
    /// What may move.
    pub dofs: RefineDofs,
    /// Weight of the force mismatch, `k1` of (11).
    pub k1: f64,
    /// Weight of the negative log-likelihood, `k2` of (11).
    pub k2: f64,
    /// Distance of the basis functions, s.
    pub spacing_s: f64,
    /// Depth at which the standing body rests in the penalty ground, m.
    pub sink_m: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Solids of the scene, world, that the body should not enter; the ground is always one.
    pub obstacles: Vec<Shape>,
    /// Whether penetrations of the body with itself and the scene are pushed out.
    pub collisions: bool,
    /// Poses (`nq` each) whose touches are meant, such as the key poses of a body that folds its arms: two links may
    /// be as deep in one another as in any of them. The pipeline adds those of the mapping.
    pub accepted: Vec<Vec<f64>>,
    /// Most Gauss–Newton steps.
    pub iterations: usize,
}

impl Default for RefineOptions {
    fn default() -> Self {
        Self {
            dofs: RefineDofs::RootHeight,
            k1: 1e-5,
            k2: 1.0,
            spacing_s: 1.0 / 30.0,
            sink_m: 0.0015,
            friction: dynamics::penalty::FRICTION,
            obstacles: Vec::new(),
            collisions: true,
            accepted: Vec::new(),
            iterations: 20,
        }
    }
}

/// Options of the pipeline.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// The model.
    pub model: MappingModel,
    /// How the shared GPLVM is learned, and how it finds the latent point of a pose.
    pub gplvm: GplvmOptions,
    /// Where to stop.
    pub stop_after: Stage,
    /// Frame rate to work at and to write; by default the clip's.
    pub rate_hz: Option<f64>,
    /// How the human clip is smoothed before anything else.
    pub smoothing: Smoothing,
    /// Height of the ground in the human clip, m; by default where its lowest contact points stand.
    pub ground_m: Option<f64>,
    /// Global transform.
    pub global: GlobalOptions,
    /// Contacts.
    pub contact: ContactOptions,
    /// Refinement.
    pub refine: RefineOptions,
}
