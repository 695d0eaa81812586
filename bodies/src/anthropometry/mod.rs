//! Anthropometry: a body for any human-like skeleton.
//!
//! In: a [`motion::Skeleton`] whose links have human-like names. Out: a [`crate::Character`] with masses,
//! inertias, shapes, limits and contact points, and a report of what was guessed. Tables are cited
//! where they stand.
//!
//! | module | holds |
//! |---|---|
//! | [`aliases`] | joint names of common rigs → anatomical roles |
//! | `names` | what a name says by itself |
//! | [`frame`] | the anatomical neutral pose of a skeleton |
//! | [`segments`] | segment masses, centres and radii of gyration \[deL96\] |
//! | [`limits`] | ranges of motion \[BA79, AAOS\] in the coordinates of a skeleton |
//! | [`shapes`] | capsules and boxes that look like a body |
//! | [`guess`] | all of them together |
//! | [`standing`] | a body for a clip: the pelvis below other roots, a standing pose where the zero pose is none |
//! | [`human`] | the standard figure of the project |

pub mod aliases;
mod error;
pub mod frame;
pub mod guess;
pub mod human;
pub mod limits;
mod names;
pub mod segments;
pub mod shapes;
mod side;
pub mod standing;

pub use aliases::{Anatomy, AnatomyError, Role, Side};
pub use error::GuessError;
pub use guess::{BodyOptions, BodyReport, guess_body};
pub use limits::NeckShare;
pub use segments::Sex;
pub use standing::{folded_to_pelvis, guess_body_of_clip, standing_frame};
