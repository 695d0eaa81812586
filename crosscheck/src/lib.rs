//! Every number about force, against MuJoCo.

pub mod bridge;
pub mod environment;
pub mod layout;
pub mod world;
