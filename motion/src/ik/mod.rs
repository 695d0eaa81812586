//! Inverse kinematics: joint values from where points have to be.
//!
//! | module | holds | method |
//! |---|---|---|
//! | [`two_bone`] | an arm or leg to a target, the swivel kept | closed form |
//! | [`whole_body`] | points of any links to goals, the rest of the pose kept, joints within their limits | damped least squares |
//! | [`pose`] | joints dragged, others pinned exactly, the rest near where it was; from call to call | Newton with constraints |
//! | [`swivel`] | where the knee of a planted leg lies | closed form |
//! | [`axes`] | joint axes in the world: the columns of every point's Jacobian | |
//!
//! The way of a joint back to its limits is in [`limits`](crate::limits), the solution of normal equations in
//! [`linear`](crate::linear).

pub mod axes;
mod chain;
pub mod pose;
pub mod swivel;
pub mod two_bone;
pub mod whole_body;

pub use axes::{Axis, JointAxes};
pub use two_bone::{IkError, Reach, reach_range, solve_two_bone, solve_two_bone_oriented};
pub use whole_body::{Floor, Goal, Method, Point, Problem, Unknowns, WholeBody};
