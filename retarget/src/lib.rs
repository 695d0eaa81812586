//! Human motion onto bodies of other proportions and topology \[YAH10\].
//!
//! In: a human clip, a character, pairs of key poses. Out: a clip of the character, physically plausible, with
//! the numbers that say so. Plain clips in and out; files are the business of `scenes`.
//!
//! | module | holds |
//! |---|---|
//! | `suggest` | which frames to key next |
//! | [`bounds`], [`guard`] | what a stage may do to a motion, and what holds it to that |
//! | [`flights`] | flights of the human stay flights |
//! | [`subject`] | performer and puppet |
//! | [`features`] | feature points and the root's local frame |
//! | [`key_poses`] | pairs of human and character poses |
//! | [`mod@prepare`] | the human clip as the stages want it |
//! | [`mapping`] | a character pose for each human pose |
//! | [`fit`] | joint angles from feature points |
//! | [`mod@global_transform`] | where the body goes |
//! | [`contacts`] | contact phases, contact adjustment |
//! | [`mod@sway`] | parts that follow by dynamics |
//! | [`mod@refine`] | physics and collisions |
//! | [`mod@guess`] | a first guess for a new key pose |
//! | [`live`] | frame by frame as it happens |
//! | [`options`] | what may be told |
//! | [`result`] | what comes out |
//! | [`pipeline`] | all stages in order |
//!
//! Units and frames: metres, radians, seconds, kilograms; right-handed, Y up, +Z forward.
//!
//! \[YAH10\] Yamane, Ariki, Hodgins. Animating Non-Humanoid Characters with Human Motion Data, SCA 2010.

pub mod bounds;
pub mod contacts;
mod error;
pub mod features;
pub mod fit;
pub mod flights;
pub mod global_transform;
pub mod guard;
pub mod guess;
pub mod key_poses;
pub mod live;
pub mod mapping;
pub mod options;
mod phase;
pub mod pipeline;
pub mod prepare;
pub mod refine;
pub mod result;
pub mod subject;
mod suggest;
pub mod sway;

pub use bounds::{Bounds, Step, StepReport, Turned};
pub use error::RetargetError;
pub use features::{Features, RootFrame};
pub use global_transform::{GlobalPath, Scale, global_transform};
pub use guard::Guard;
pub use guess::guess;
pub use key_poses::{KeyPose, KeyPoses};
pub use live::{Live, LiveFrame};
pub use mapping::Mapping;
pub use options::{
    ContactOptions, FlightSpan, GlobalOptions, GplvmOptions, Locate, MappingModel, Options, PipelineStage,
    RefineDofs, RefineDofsName, RefineOptions, SizeRatio, SizeRatioName, WorldOptions,
};
pub use phase::Phase;
pub use pipeline::{run, run_with};
pub use prepare::prepare;
pub use result::{
    ContactReport, FlightReport, MappingReport, MomentumReport, RefinementReport, Retargeted, SwayReport,
};
pub use subject::{ContactPoint, Follow, Performer, Puppet, Sway};
pub use sway::sway;
