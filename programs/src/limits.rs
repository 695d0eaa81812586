//! Limits of programs: what bounds time and memory whatever a program does.

/// How deep functions of a program may call each other.
pub const CALL_LEVELS: usize = 24;
/// The longest text, bytes.
pub const TEXT: usize = 65_536;
/// The most entries of a list or map, those of what is in it counted. They are counted at every change: larger ones would be slow.
pub const ITEMS: usize = 20_000;
/// The most variables at a time.
pub const VARIABLES: usize = 256;
/// How deep expressions and blocks may be nested.
pub const NESTING: usize = 32;
/// Steps of an edit: those that every program has, and those for each element or joint of a frame.
pub const EDIT_STEPS: (u64, u64) = (1_000_000, 2_000);
/// Steps of a reactive property each time it is called.
pub const REACT_STEPS: u64 = 100_000;
/// Steps of the functions that are called once, `params` and `memory`.
pub const START_STEPS: u64 = 100_000;
