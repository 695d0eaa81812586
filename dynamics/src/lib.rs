//! Bodies with mass: characters, inverse dynamics, mass matrices, momentum, traces.
//!
//! In: a [`Character`], poses, velocities, accelerations, outside wrenches. Out: joint torques,
//! inertia, momentum. No engine and no control: what a body needs, not how it gets it.
//!
//! | module | holds |
//! |---|---|
//! | [`analysis`] | what forces a clip needs, and whether the ground can give them |
//! | [`analysis_files`] | an analysis as CSV, MOT, npz, and as a trace |
//! | [`anthropometry`] | a body for any human-like skeleton |
//! | [`carried`] | masses a character carries |
//! | [`character`] | mass, inertia, shapes and contact points on a skeleton |
//! | [`fall`] | whether and why a body fell |
//! | [`density`] | mass and inertia of solids of even density |
//! | [`mjcf`] | a character as MJCF |
//! | [`mujoco_layout`] | between our vectors and MuJoCo's |
//! | [`model`] | a character compiled for dynamics, and its world-frame state |
//! | [`rnea`] | inverse dynamics with outside wrenches, bias, Coriolis terms, gravity load |
//! | [`crba`] | mass matrix |
//! | [`derivatives`] | slopes of inverse dynamics by pose, velocity and acceleration |
//! | [`forward`] | accelerations from forces |
//! | [`inertia`] | composites, momentum and its rate, energy, gravity stiffness |
//! | [`jacobian`] | how a point of a body moves with the joints |
//! | [`ground_forces`] | ground forces required, given and measured, per foot |
//! | [`penalty`] | the force of the ground on a point, from its height and slip |
//! | [`rnea`] | inverse dynamics with outside wrenches |
//! | [`import`] | characters from MJCF and URDF |
//! | [`inertia`] | mass matrix, momentum, energy, gravity stiffness |
//! | [`pose_map`] | poses between a clip's skeleton and a character's |
//! | [`trace`] | what a dynamic run recorded |
//! | [`trace_npz`] | a trace as numpy arrays, written and read |

pub mod analysis;
pub mod analysis_files;
pub mod anthropometry;
pub mod carried;
pub mod character;
pub mod crba;
pub mod density;
pub mod derivatives;
pub mod fall;
pub mod forward;
pub mod ground_forces;
pub mod import;
pub mod inertia;
pub mod jacobian;
pub mod mjcf;
pub mod model;
pub mod mujoco_layout;
pub mod penalty;
pub mod pose_map;
pub mod rnea;
pub mod trace;
pub mod trace_npz;

pub use analysis::{Analysis, AnalysisError, AnalysisOptions, Grade, Ground, analyze};
pub use anthropometry::{BodyOptions, BodyReport, GuessError, guess_body, guess_body_of_clip};
pub use carried::{Carried, Carrying};
pub use character::{Body, Character, CharacterError, JointClass};
pub use derivatives::InverseDerivatives;
pub use forward::{ForwardDynamics, NoInertia};
pub use ground_forces::{FootForce, GivenBy, GroundForces};
pub use inertia::{Momentum, MomentumRate};
pub use model::{Model, MovingBody, State};
pub use penalty::Penalty;
pub use pose_map::{PoseMap, PoseMapError};
pub use rnea::{Wrench, total_wrench};
pub use trace::{ContactSample, Disturbed, Handed, RootMode, Trace};
pub use trace_npz::TraceFileError;
