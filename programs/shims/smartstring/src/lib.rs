//! An empty package in place of the one of this name, whose licence (MPL-2.0) this project does not take.
//!
//! rhai always names `smartstring`. With its feature `compact_str` no line of rhai uses it, so that nothing has to be
//! here. `[patch.crates-io]` of the workspace puts this package in its place; rhai would not compile if it did use it.
