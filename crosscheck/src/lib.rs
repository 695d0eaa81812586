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
//! | [`push`] | the push-recovery map in both engines |
//! | [`inject`] | faults put in on purpose |
//! | [`check`], [`report`] | a row of the table; the table as text, page and JSON |
//! | [`world`] | MuJoCo as an engine of the dynamic pass |
//! | [`bridge`], [`environment`] | the process, the Python it runs in |

pub mod bridge;
pub mod check;
pub mod environment;
pub mod forward;
pub mod ground;
pub mod inject;
pub mod push;
pub mod report;
pub mod rigid;
pub mod subject;
pub mod world;

pub use check::Check;
pub use inject::Injection;
pub use subject::{CrossCheck, CrossCheckError, Event, Options, run};
