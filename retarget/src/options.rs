//! What may be told to the pipeline; everything has a default.

use std::fmt;
use std::str::FromStr;

use learn::Method;
use motion::names::Word;
use motion::{Shape, Smoothing};

use crate::RetargetError;
use crate::phase::Phase;

/// Settings of the shared GPLVM.
pub use learn::{GplvmOptions, Locate};

/// The statistical model of the static mapping.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MappingModel {
    /// Shared GPLVM.
    #[default]
    Gplvm,
    /// GP regression.
    Gp,
    /// PCA and a linear map.
    Pca,
    /// Three nearest neighbours.
    Nn3,
    /// Ten nearest neighbours.
    Nn10,
}

impl MappingModel {
    /// All of them, the paper's own first.
    pub const ALL: [Self; 5] = [Self::Gplvm, Self::Gp, Self::Pca, Self::Nn3, Self::Nn10];

    /// What learns it.
    pub const fn method(self) -> Method {
        match self {
            Self::Gplvm => Method::Gplvm,
            Self::Gp => Method::Gp,
            Self::Pca => Method::Pca,
            Self::Nn3 => Method::Nn3,
            Self::Nn10 => Method::Nn10,
        }
    }

    /// Key poses it needs at least.
    pub fn least_pairs(self) -> usize {
        self.method().least_pairs()
    }
}

impl Word for MappingModel {
    const KIND: &'static str = "model";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Gplvm, Method::Gplvm.name(), "Shared Gaussian-process latent-variable model"),
        (Self::Gp, Method::Gp.name(), "Gaussian-process regression"),
        (Self::Pca, Method::Pca.name(), "Principal components and a linear map"),
        (Self::Nn3, Method::Nn3.name(), "Mean of the three nearest key poses"),
        (Self::Nn10, Method::Nn10.name(), "Mean of the ten nearest key poses"),
    ];
}

impl fmt::Display for MappingModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

/// Where the pipeline ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum PipelineStage {
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

impl Word for PipelineStage {
    const KIND: &'static str = "stage";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Map, "map", "Poses, in place"),
        (Self::Global, "global", "Travel and turning, by momentum"),
        (Self::Contact, "contact", "Contact points held on the ground"),
        (Self::Refine, "refine", "Forces that a ground can give"),
    ];
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

/// The names of the [`SizeRatio`]s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SizeRatioName {
    /// [`SizeRatio::Stride`].
    Stride,
    /// [`SizeRatio::PerAxis`].
    PerAxis,
    /// [`SizeRatio::Uniform`].
    Uniform,
    /// [`SizeRatio::Fixed`].
    Fixed,
}

impl Word for SizeRatioName {
    const KIND: &'static str = "size ratio";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::PerAxis, "per-axis", "The paper's ratio"),
        (Self::Uniform, "uniform", "The mean of depth and width for both: paths keep their shape"),
        (Self::Stride, "stride", "The paper's ratio, but no longer than legs can step"),
        (Self::Fixed, "fixed", "A stated ratio"),
    ];
    const ALIASES: &'static [(Self, &'static str)] = &[(Self::PerAxis, "paper")];
}

impl SizeRatio {
    /// The ratio of a name; `None` of [`SizeRatioName::Fixed`], which needs a number.
    pub fn named(name: SizeRatioName) -> Option<Self> {
        match name {
            SizeRatioName::Stride => Some(Self::Stride),
            SizeRatioName::PerAxis => Some(Self::PerAxis),
            SizeRatioName::Uniform => Some(Self::Uniform),
            SizeRatioName::Fixed => None,
        }
    }
}

/// A text that is no [`SizeRatio`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("allowed: {}, or a positive number", short_names(SizeRatioName::Fixed))]
pub struct SizeRatioError;

impl FromStr for SizeRatio {
    type Err = SizeRatioError;

    /// A name, or a positive number for a fixed ratio.
    fn from_str(text: &str) -> Result<Self, SizeRatioError> {
        if let Some(ratio) = SizeRatioName::find(text).ok().and_then(Self::named) {
            return Ok(ratio);
        }
        let number = text.parse().ok().filter(|x: &f64| *x > 0.0 && x.is_finite());
        number.map(Self::Fixed).ok_or(SizeRatioError)
    }
}

/// All names but that of the value that a text says without one.
fn short_names<W: Word>(but: W) -> String {
    let words = W::WORDS.iter().map(|w| (w.0, w.1)).chain(W::ALIASES.iter().copied());
    let names: Vec<&str> = words.filter(|(value, _)| *value != but).map(|(_, name)| name).collect();
    names.join(", ")
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
    /// Time by which a phase may begin later or end earlier than the human's where the flight beside it is too short for the
    /// character, s.
    pub phase_slack_s: f64,
    /// Phases by hand; they replace what is found, and are kept as they are.
    pub phases: Option<Vec<Phase>>,
}

impl Default for ContactOptions {
    fn default() -> Self {
        Self { height_m: 0.025, speed_m_s: 0.6, shortest_s: 0.1, phase_slack_s: 0.1, phases: None }
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

/// The names of the [`RefineDofs`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RefineDofsName {
    /// [`RefineDofs::RootHeight`].
    RootHeight,
    /// [`RefineDofs::Root`].
    Root,
    /// [`RefineDofs::RootAndLegs`].
    RootAndLegs,
    /// [`RefineDofs::Links`].
    Links,
}

impl Word for RefineDofsName {
    const KIND: &'static str = "set of degrees of freedom";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::RootHeight, "root-height", "The height of the root: the paper's choice"),
        (Self::Root, "root", "The six of the root"),
        (Self::RootAndLegs, "root-and-legs", "Those of the root and of what carries it"),
        (Self::Links, "links", "Those of named links, and the root's height"),
    ];
    const ALIASES: &'static [(Self, &'static str)] =
        &[(Self::RootHeight, "height"), (Self::RootAndLegs, "legs")];
}

impl RefineDofs {
    /// Those of a name; `None` of [`RefineDofsName::Links`], which needs the links.
    pub fn named(name: RefineDofsName) -> Option<Self> {
        match name {
            RefineDofsName::RootHeight => Some(Self::RootHeight),
            RefineDofsName::Root => Some(Self::Root),
            RefineDofsName::RootAndLegs => Some(Self::RootAndLegs),
            RefineDofsName::Links => None,
        }
    }
}

/// A text that is no [`RefineDofs`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("an empty name; allowed: {}, or links of the character", short_names(RefineDofsName::Links))]
pub struct RefineDofsError;

impl FromStr for RefineDofs {
    type Err = RefineDofsError;

    /// A name, or links separated by commas. Names are taken letter by letter: a link may be called `Root`.
    fn from_str(text: &str) -> Result<Self, RefineDofsError> {
        let names: Vec<String> = text.split(',').map(|s| s.trim().to_owned()).collect();
        if names.iter().any(String::is_empty) {
            return Err(RefineDofsError);
        }
        let words = RefineDofsName::WORDS.iter().map(|w| (w.0, w.1));
        let mut words = words.chain(RefineDofsName::ALIASES.iter().copied());
        let named = words.find(|(_, name)| *name == text).and_then(|(name, _)| Self::named(name));
        Ok(named.unwrap_or(Self::Links(names)))
    }
}

/// Where the body moves: gravity along −Y, a level ground at height 0, solids.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldOptions {
    /// Gravity, m/s², > 0.
    pub gravity_m_s2: f64,
    /// Coefficient of friction of the ground, > 0.
    pub friction: f64,
    /// Solids of the scene, world frame, that the body should not enter; the ground is always one.
    pub obstacles: Vec<Shape>,
}

impl Default for WorldOptions {
    fn default() -> Self {
        Self {
            gravity_m_s2: -dynamics::conditions::GRAVITY.y,
            friction: motion::floor::FRICTION,
            obstacles: Vec::new(),
        }
    }
}

impl WorldOptions {
    /// Checks that all numbers are in their ranges.
    ///
    /// # Errors
    /// The first that is not.
    pub fn check(&self) -> Result<(), RetargetError> {
        let of = [("gravity (m/s²)", self.gravity_m_s2), ("the coefficient of friction", self.friction)];
        match of.into_iter().find(|(_, value)| !(*value > 0.0 && value.is_finite())) {
            Some((name, value)) => Err(RetargetError::Option { name, value, allowed: "positive numbers" }),
            None => Ok(()),
        }
    }
}

/// Weight of the friction cone, see [`RefineOptions::cone`].
pub const CONE: f64 = 100.0;

/// A span in which the character is in the air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlightSpan {
    /// From, s.
    pub from_s: f64,
    /// To, s.
    pub to_s: f64,
    /// Greatest height of its lowest contact point, m.
    pub height_m: f64,
}

/// Options of the physics refinement.
#[derive(Clone, Debug, PartialEq)]
pub struct RefineOptions {
    /// What may move.
    pub dofs: RefineDofs,
    /// Weight of the force mismatch, `k1` of (11), 1/N².
    pub k1: f64,
    /// Weight of the negative log-likelihood, `k2` of (11), a pure number.
    pub k2: f64,
    /// Weight of what leaves the friction cone against the force mismatch; by default [`CONE`] where something moves that can
    /// change horizontal forces, and 1 for the root's height alone, which cannot.
    pub cone: Option<f64>,
    /// Distance of the basis functions, s.
    pub spacing_s: f64,
    /// Depth at which the standing body rests in the penalty ground, m.
    pub sink_m: f64,
    /// Whether penetrations of the body with itself and the scene are pushed out.
    pub collisions: bool,
    /// Poses (`nq` each) whose touches are meant, such as the key poses of a body that folds its arms: two links may
    /// be as deep in one another as in any of them. The pipeline adds those of the mapping.
    pub accepted: Vec<Vec<f64>>,
    /// Flights whose height is kept; the pipeline adds those of the human.
    pub flights: Vec<FlightSpan>,
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
            collisions: true,
            accepted: Vec::new(),
            flights: Vec::new(),
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
    pub stop_after: PipelineStage,
    /// Frame rate to give; by default the clip's. What is done is done at a rate of its own, see [`mod@crate::pipeline`].
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
    /// Gravity, friction and solids: what the swaying parts and the refinement reckon with.
    pub world: WorldOptions,
    /// Refinement.
    pub refine: RefineOptions,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            model: MappingModel::default(),
            gplvm: GplvmOptions::default(),
            stop_after: PipelineStage::default(),
            rate_hz: None,
            smoothing: Smoothing::default(),
            mapped: Smoothing::CutoffHz(MAPPED_HZ),
            ground_m: None,
            global: GlobalOptions::default(),
            contact: ContactOptions::default(),
            sway: true,
            world: WorldOptions::default(),
            refine: RefineOptions::default(),
        }
    }
}
