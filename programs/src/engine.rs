//! The engine that runs programs: the language, and the values that edits and reactive properties hand out.

use rhai::Engine;

use crate::language::language;
use crate::{body, elements, frames};

/// An engine that stops a program after `steps` steps.
pub fn engine(steps: u64) -> Engine {
    let mut engine = language(steps);
    elements::register(&mut engine);
    frames::register(&mut engine);
    body::register(&mut engine);
    engine
}
