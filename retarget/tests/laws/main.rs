//! The laws of every stage.

mod bodies;
mod contacts;
mod errors;
mod fit;
mod global;
mod guard;
mod live;
mod refine;
mod sway;
