//! Control without an engine and without a clock: (state, goal) → gains and torques.
//!
//! | module | holds |
//! |---|---|
//! | [`antagonist`] | pairs of springs: gains, least tension, set points |
//! | [`stops`] | what ligaments do beyond a joint's range |
//! | [`tension`] | from dimensionless tension to stiffness and damping |
//! | [`transition`] | gains along a transition |
//! | [`drive`] | spring and damper of a joint in one step |
//! | [`goal`] | the motion asked for, at the control rate |
//! | [`feed`] | what a moving goal needs of the ground |
//! | [`support`] | feet, and how they share the load |
//! | [`posture`] | the pelvis shift that keeps a pose over its feet |
//! | [`admissible`] | a path whose ground reaction stays inside its soles |
//! | [`shift`] | the same over a plan of contacts: weights that shift before feet leave, flights that fall |
//! | `bearing` | the contacts of a clip where forces speak |
//! | [`stepping`], [`unmet`] | a clip that steps, made possible; what of it is not |
//! | [`likeness`] | how near that stays to its capture |
//! | [`balance`] | the reactive property that keeps a body on its feet |
//! | [`reactive`] | the trait of properties that read the state every step |
//! | [`gaze`] | one that keeps the eyes on a point |
//! | [`assist`] | a root wrench with a hard budget |
//! | [`parameters`] | what may be tuned: names, units, ranges, consequences |
//! | [`plan`] | a whole motion, planned before its first step |
//! | [`controller`] | a plan, step by step |

pub mod admissible;
pub mod antagonist;
pub mod assist;
pub mod balance;
mod bearing;
pub mod controller;
pub mod drive;
pub mod feed;
pub mod gaze;
pub mod goal;
pub mod likeness;
pub mod parameters;
pub mod plan;
pub mod posture;
pub mod reactive;
pub mod shift;
pub mod stepping;
pub mod stops;
pub mod support;
pub mod tension;
pub mod transition;
pub mod unmet;

pub use antagonist::{Antagonist, HoldError, SetPoints};
pub use balance::{Balance, BalanceSettings, Strategy};
pub use controller::Controller;
pub use drive::{Drive, Rest, rest_of};
pub use feed::Feed;
pub use gaze::{Gaze, GazeError, GazeSettings, Sight};
pub use goal::Goal;
pub use parameters::{PARAMETERS, Parameter, Tunable, parameter};
pub use plan::dense::{Dense, DenseJoint};
pub use plan::{LegTension, Plan, Sagging, Setup};
pub use reactive::{ControlStep, Impedance, Reactive, ReactiveError};
pub use tension::{Need, StanceLeg, TensionScale};
pub use transition::GainBlend;
