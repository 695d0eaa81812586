//! The laws of every stage.

mod bodies;
mod contacts;
mod fit;
mod global;
