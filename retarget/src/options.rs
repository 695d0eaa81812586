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
    /// [`SizeRatio::PerAxis`], but along width and depth no more than the ratio of the legs' lengths, or where one of the
    /// two has no legs of the heights at rest: the paper's ratio counts joints more than it counts
    /// lengths, and steps longer than the legs end in the air.
    #[default]
    Stride,
    /// As in the paper, per axis of the local frame: mean speed of the feature points when every degree of
    /// freedom turns at unit rate, one by one.
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
        Self { size: SizeRatio::Stride, drift_hz: 0.25 }
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
    /// Time by which a phase may begin later or end earlier than the human's where the step beside it needs it, s.
    pub give_s: f64,
    /// Phases by hand; replaces what is found, and nothing gives way.
    pub phases: Option<Vec<Phase>>,
}

impl Default for ContactOptions {
    fn default() -> Self {
        Self { height_m: 0.025, speed_m_s: 0.6, shortest_s: 0.1, give_s: 0.1, phases: None }
    }
}

/// Degrees of freedom that the refinement may move.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum RefineDofs {
    /// The height of the root: the paper's choice.
    #[default]
    RootHeight,
    /// The six of the root.
    Root,
    /// The six of the root and those of all links between it and a contact point that ever touches. Where those lie on the
    /// root itself, as under a lamp, the links that carry at least half of the other mass: they move the body against its
    /// foot as legs do.
    RootAndLegs,
    /// Those of the named links (a free root gives six), and the root's height.
    Links(Vec<String>),
}

/// Weight of the friction cone, see [`RefineOptions::cone`].
pub const CONE: f64 = 100.0;

/// Options of the physics refinement.
#[derive(Clone, Debug, PartialEq)]
pub struct RefineOptions {
    /// What may move.
    pub dofs: RefineDofs,
    /// Weight of the force mismatch, `k1` of (11).
    pub k1: f64,
    /// Weight of the negative log-likelihood, `k2` of (11).
    pub k2: f64,
    /// Weight of what leaves the friction cone against the force mismatch; by default [`CONE`] where something moves that can
    /// change horizontal forces, and 1 for the root's height alone, which cannot.
    pub cone: Option<f64>,
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
    /// Most steps for each stretch of the clip, with each choice of what moves.
    pub iterations: usize,
}

impl Default for RefineOptions {
    fn default() -> Self {
        Self {
            dofs: RefineDofs::RootHeight,
            k1: 1e-5,
            k2: 1.0,
            cone: None,
            spacing_s: 0.05,
            sink_m: 0.0015,
            friction: dynamics::penalty::FRICTION,
            obstacles: Vec::new(),
            collisions: true,
            accepted: Vec::new(),
            iterations: 30,
        }
    }
}

/// Frequency at which half of the mapped motion's amplitude passes, Hz.
///
/// What a model says of two frames next to each other need not be a motion that a body can do: unsmoothed, dances mapped
/// onto the lamp ask for eight times its weight from one frame to the next, and no displacement of its root gives that.
pub const MAPPED_HZ: f64 = 6.0;

/// Options of the pipeline.
#[derive(Clone, Debug, PartialEq)]
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
    /// How the mapped motion is smoothed, before it travels: the mapping answers frame by frame.
    pub mapped: Smoothing,
    /// Height of the ground in the human clip, m; by default where its lowest contact points stand.
    pub ground_m: Option<f64>,
    /// Global transform.
    pub global: GlobalOptions,
    /// Contacts.
    pub contact: ContactOptions,
    /// Whether parts that can follow by dynamics do; otherwise they go as the key poses have it.
    pub sway: bool,
    /// Refinement.
    pub refine: RefineOptions,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            model: MappingModel::default(),
            gplvm: GplvmOptions::default(),
            stop_after: Stage::default(),
            rate_hz: None,
            smoothing: Smoothing::default(),
            mapped: Smoothing::CutoffHz(MAPPED_HZ),
            ground_m: None,
            global: GlobalOptions::default(),
            contact: ContactOptions::default(),
            sway: true,
            refine: RefineOptions::default(),
        }
    }
}
