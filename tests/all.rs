//! Promises across the crates. Each module is one kind of promise.

mod arrows;
mod circles;
mod laws;
mod nothing;
mod program;
mod promises;
mod scenes;
mod third_party;
