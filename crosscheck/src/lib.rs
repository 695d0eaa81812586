//! Every number about force, against MuJoCo.

pub mod bridge;
pub mod check;
pub mod environment;
pub mod layout;
pub mod ground;
pub mod inject;
pub mod rigid;
pub mod world;
