//! Motion without mass: skeletons, poses, clips, and everything that needs only geometry and time.
//!
//! In: joint values, scripts, files. Out: [`Clip`]s, the one coin of the project. No forces, no
//! engine, no scene files.
//!
//! | module | holds |
//! |---|---|
//! | [`rotation`] | quaternion logarithm and exponential, swing and twist, Euler orders |
//! | [`skeleton`] | links, joints, limits, sites, limbs |
//! | [`clip`] | uniformly sampled poses |
//! | [`shape`] | capsules, boxes, balls |
//! | [`fk`] | forward kinematics |
//! | [`mod@format`] | BVH and other files |
//!
//! Units and frames: metres, radians, seconds; right-handed, Y up, +Z forward, +X to the left of
//! the character.

pub mod clip;
pub mod fk;
pub mod format;
pub mod rotation;
pub mod shape;
pub mod skeleton;

pub use clip::Clip;
pub use fk::Kinematics;
pub use rotation::{EulerOrder, Quat, Vec3};
pub use shape::Shape;
pub use skeleton::{BallLimits, Joint, Limb, LimbKind, Limits, Link, Range, Site, Skeleton, SkeletonError};

/// A rigid transform; `world_from_link` maps points of the link into the world.
pub type Transform = nalgebra::Isometry3<f64>;
