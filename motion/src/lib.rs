//! Motion without mass: skeletons, poses, clips, and everything that needs only geometry and time.
//!
//! In: joint values, scripts. Out: [`Clip`]s, which every stage takes and gives. No forces, no engine, no formats.
//!
//! | module | holds |
//! |---|---|
//! | [`mod@runs`] | runs of frames of a kind |
//! | [`rotation`] | quaternion logarithm and exponential, swing and twist, Euler orders |
//! | [`skeleton`] | links, joints, limits, sites, limbs |
//! | [`clip`] | uniformly sampled poses |
//! | [`time_map`] | strictly increasing maps of time; retimed clips |
//! | [`contact_plan`] | which point stands, from when to when, and where |
//! | [`mod@contacts`] | the contact plan of a clip, found by height and speed |
//! | [`cycle`] | a part of a clip that repeats; clips that go on |
//! | [`derivatives`] | velocities and accelerations |
//! | [`mod@smooth`] | a smoother that minimises acceleration noise |
//! | [`curve`] | named transition curves |
//! | [`dof`] | degrees of freedom as scripts name them, and their values |
//! | [`tread`] | ways of feet that stand where a plan says, and roll without slipping |
//! | [`track`] | transition-element tracks: the editable form of a motion |
//! | [`script`] | actions, cycles, poses: the written form of a motion |
//! | [`timing`] | what muscles know of a written motion |
//! | [`plant`] | feet that stay where they stand |
//! | [`shape`] | capsules, boxes, balls |
//! | [`mod@file`] | reading a file within a limit |
//! | [`mod@fit`] | a clip as transition elements; its few key poses |
//! | [`fk`] | forward kinematics |
//! | [`mod@fnv`] | one number for many bytes |
//! | [`mod@glitch`] | joints that jump as no muscle could make them |
//! | [`ik`] | two-bone limbs to a target, whole bodies to many, posing by dragging; axes of joints |
//! | [`limits`] | the way of a joint back into its range |
//! | [`linear`] | small dense systems of equations |
//! | [`metrics`] | joint errors, foot slip, jerk |
//! | [`names`] | tables of names of values; the nearest known name, for error messages |
//! | [`sole`] | the points of a foot that a floor can press on |
//! | [`stance`] | where in a clip the feet stand, and where they step |
//! | [`support`] | convex hull of ground contacts, margin of a point |
//! | [`symmetry`] | left and right: which link mirrors which, clips mirrored |
//!
//! Units and frames: metres, radians, seconds; right-handed, Y up, +Z forward, +X to the left of
//! the character.

pub mod clip;
pub mod contact_plan;
pub mod contacts;
pub mod curve;
pub mod cycle;
pub mod derivatives;
pub mod dof;
pub mod file;
pub mod fit;
pub mod fk;
pub mod floor;
pub mod fnv;
pub mod glitch;
pub mod ik;
pub mod limits;
pub mod linear;
pub mod metrics;
pub mod names;
pub mod plant;
pub mod rotation;
pub mod runs;
pub mod script;
pub mod shape;
pub mod skeleton;
pub mod smooth;
pub mod sole;
pub mod stance;
pub mod support;
pub mod symmetry;
pub mod time_map;
pub mod timing;
pub mod track;
pub mod tread;

pub use clip::Clip;
pub use contact_plan::{Contact, ContactPlan};
pub use contacts::contacts;
pub use curve::{Curve, CurveName, smoothstep};
pub use cycle::{Cycle, CycleError};
pub use derivatives::Derivatives;
pub use dof::{Dof, Value};
pub use fit::{Fit, FitReport, Tolerance};
pub use fk::Kinematics;
pub use floor::{Floor, Tilt};
pub use fnv::Fnv;
pub use plant::{Knee, Plant};
pub use rotation::{EulerOrder, Quat, Vec3};
pub use runs::runs;
pub use script::{Script, ScriptError};
pub use shape::Shape;
pub use skeleton::{BallLimits, Joint, Limb, LimbKind, Limits, Link, Range, Site, Skeleton, SkeletonError};
pub use smooth::{SmoothReport, Smoothed, Smoothing, Strength, smooth};
pub use sole::Sole;
pub use support::Support;
pub use symmetry::Symmetry;
pub use time_map::TimeMap;
pub use timing::Timing;
pub use track::{Element, Label, Track, Tracks};

/// A rigid transform; `world_from_link` maps points of the link into the world.
pub type Transform = nalgebra::Isometry3<f64>;
