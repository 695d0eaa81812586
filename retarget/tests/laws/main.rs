//! The laws of every stage.

mod bodies;
mod contacts;
mod dump;
mod fit;
mod global;
mod refine;
