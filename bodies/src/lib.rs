//! Bodies: what a skeleton needs to have weight.
//!
//! In: skeletons, clips, published tables, densities. Out: a [`Character`]: mass, inertia, shapes, joint limits and
//! contact points on a skeleton. No motion is computed here and no file is read.
//!
//! | module | holds |
//! |---|---|
//! | [`character`] | mass, inertia, shapes and contact points on a skeleton |
//! | [`carried`] | masses a character carries |
//! | [`anthropometry`] | a body for any human-like skeleton |
//! | [`density`] | mass and inertia of solids of even density |
//! | [`mass`] | rigid bodies taken as one |
//! | [`prop`] | boxes and ramps fixed in the world |
//! | [`soles`] | pads and toes that yield under load |
//! | [`self_collision`] | which shapes of a body may touch each other |
//! | [`pose_map`] | poses between a clip's skeleton and a character's |
//!
//! Units: kg, m, rad; kg·m² about the centre of mass, link axes.

pub mod anthropometry;
pub mod carried;
pub mod character;
pub mod density;
pub mod mass;
pub mod pose_map;
pub mod prop;
pub mod self_collision;
pub mod soles;

pub use anthropometry::{BodyOptions, BodyReport, GuessError, guess_body, guess_body_of_clip};
pub use carried::Carried;
pub use character::{Body, Character, CharacterError, JointClass};
pub use pose_map::{PoseMap, PoseMapError};
pub use prop::Prop;
pub use self_collision::LinkCapsule;
pub use soles::{OnSoles, Soles, SolesError};
