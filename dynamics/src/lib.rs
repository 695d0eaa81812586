//! Bodies with mass: characters, inverse dynamics, mass matrices, momentum, traces.
//!
//! In: a [`Character`](bodies::Character), poses, velocities, accelerations, outside wrenches. Out: joint torques,
//! inertia, momentum. No engine and no control.
//!
//! | module | holds |
//! |---|---|
//! | [`analysis`] | what forces a clip needs, and whether the ground can give them |
//! | [`conditions`] | what acts on a performer: what holds its root, pushes, carried masses |
//! | [`fall`] | whether and why a body fell |
//! | [`trigger`] | what the motion or the world brought that made it fall |
//! | [`digest`] | numbers that tell bodies, motions and conditions apart |
//! | [`feet`] | what the feet of a run did on its ground |
//! | [`verdict`] | how a motion was performed, in words and with numbers |
//! | [`model`] | a character compiled for dynamics, and its world-frame state |
//! | [`rnea`] | inverse dynamics with outside wrenches, bias, Coriolis terms, gravity load |
//! | [`crba`] | mass matrix |
//! | [`articulated`] | the inertia of each axis with the joints further out left free |
//! | [`derivatives`] | slopes of inverse dynamics by pose, velocity and acceleration |
//! | [`forward`] | accelerations from forces |
//! | [`inertia`] | composites, momentum and its rate, energy, gravity stiffness |
//! | [`jacobian`] | how a point of a body moves with the joints |
//! | [`ground_forces`] | ground forces required, given and measured, per foot |
//! | [`penalty`] | the force of the ground on a point, from its height and slip |
//! | [`rejoined`] | whether a body that was thrown off its motion came back |
//! | [`walked`] | whether a body that steps kept its feet |
//! | [`trace`] | what a dynamic run recorded |

pub mod analysis;
pub mod articulated;
mod composite;
pub mod conditions;
pub mod crba;
pub mod derivatives;
pub mod digest;
pub mod fall;
pub mod feet;
pub mod forward;
pub mod ground_forces;
pub mod inertia;
pub mod jacobian;
pub mod model;
pub mod penalty;
pub mod rejoined;
pub mod rnea;
mod spans;
pub mod trace;
pub mod trigger;
pub mod verdict;
pub mod walked;

pub use analysis::{Analysis, AnalysisError, AnalysisOptions, FloorChoice, Grade, analyze};
pub use conditions::{Carrying, Push, RootMode, RootName};
pub use derivatives::InverseDerivatives;
pub use forward::{ForwardDynamics, NoInertia};
pub use ground_forces::{FootForce, GivenBy, GroundForces};
pub use inertia::{Momentum, MomentumRate};
pub use model::{Model, MovingBody, State};
pub use penalty::Penalty;
pub use rejoined::Rejoined;
pub use rnea::{Wrench, total_wrench};
pub use trace::{Against, ContactSample, Disturbed, Handed, Trace};
pub use verdict::Verdict;
pub use walked::Walked;
