//! Which figures a run gets.

/// Names of all figures a run may get.
pub const STEMS: &[&str] = &[];
