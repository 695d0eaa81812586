//! Promises across the crates. Each module is one kind of promise.

mod arrows;
mod laws;
mod scenes;
