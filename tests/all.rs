//! Promises that no crate can make alone, as tests. One file per idea.

mod arrows;
mod laws;
