//! Control without an engine and without a clock: (state, goal) → gains and torques.
//!
//! | module | holds |
//! |---|---|
//! | [`antagonist`] | pairs of springs: gains, least tension, set points |
//! | [`stops`] | what ligaments do beyond a joint's range |
//! | [`tension`] | from dimensionless tension to stiffness and damping |
//! | [`transition`] | gains along a transition |
//! | [`drive`] | what a muscle pair asks of its joint in one step |
//! | [`goal`] | the motion asked for, at the control rate |
//! | [`support`] | feet, and how they share the load |
//! | [`posture`] | the pelvis shift that keeps a pose over its feet |
//! | [`balance`] | the reactive property that keeps a body on its feet |
//! | [`reactive`] | the trait of properties that read the state every step |
//! | [`gaze`] | one that keeps the eyes on a point |
//! | [`assist`] | a root wrench with a hard budget |
//! | [`controller`] | all of them, step by step |

pub mod antagonist;
pub mod assist;
pub mod balance;
pub mod controller;
pub mod drive;
pub mod gaze;
pub mod goal;
pub mod posture;
pub mod reactive;
pub mod stops;
pub mod support;
pub mod tension;
pub mod transition;

pub use antagonist::{Antagonist, HoldError, SetPoints};
pub use balance::{Balance, BalanceSettings};
pub use controller::{Controller, Sagging, Setup};
pub use drive::{Drive, Rest, rest_of};
pub use gaze::{Gaze, GazeError, GazeSettings, Sight};
pub use goal::Goal;
pub use reactive::{Moment, Reactive};
pub use tension::{Need, StanceLeg, TensionScale};
pub use transition::GainBlend;
