//! The engines of the command: those of `sim`, and MuJoCo from `crosscheck`.
//!
//! In: the word after `--engine`. Out: an engine. Another engine is one more line in [`engines`].

use takes::{EngineEntry, Engines};

/// All engines.
pub fn engines() -> Engines {
    let mut all = Engines::default();
    all.add(crosscheck::engine(|note| eprintln!("{note}")));
    all
}

/// Every engine in one line, for the help of `--engine`.
pub fn help() -> String {
    let line = |e: &EngineEntry| format!("{} ({})", e.name(), e.description());
    engines().iter().map(line).collect::<Vec<_>>().join(", or ")
}
