//! Promises that no crate can make alone, as tests. One file per idea.

mod arrows;
mod laws;
//! Promises across the crates. Each module is one kind of promise.

mod scenes;
