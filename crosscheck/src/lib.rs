//! Every number about force, against MuJoCo.
//!
//! In: a scene, a clip, a character or a model file. Out: a table of quantities, ours and MuJoCo's, with
//! thresholds and verdicts. The only crate that names MuJoCo, which runs in a process of its own.
//!
//! | module | holds |
//! |---|---|
//! | [`subject`] | what is compared, and the whole of it |
//! | [`rigid`] | masses, mass matrix, forces, momenta, energies at random states |
//! | [`forward`] | motion without contacts, order of convergence |
//! | [`ground`] | contact: boxes, standing, a scene on its feet |
//! | [`stepping`](mod@stepping) | a motion that steps, performed free in three engines |
//! | [`push`] | the push-recovery map in both engines |
//! | [`inject`] | faults put in on purpose |
//! | [`check`], [`report`], [`results`] | a row of the table; the table as text, page and JSON; its folder |
//! | [`mujoco`], [`engine`](mod@engine) | MuJoCo as an engine of the dynamic pass; its entry in the table of engines |
//! | [`bridge`], [`environment`] | the process, the Python it runs in |

pub mod box_contact;
pub mod bridge;
pub mod check;
pub mod engine;
pub mod environment;
mod error;
pub mod forward;
pub mod ground;
pub mod inject;
pub mod mujoco;
pub mod push;
pub mod report;
pub mod results;
pub mod rigid;
pub mod stepping;
pub mod subject;

pub use check::Check;
pub use engine::engine;
pub use error::CrossCheckError;
pub use inject::Injection;
pub use subject::{CrossCheck, Event, Options, run};
