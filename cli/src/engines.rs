//! The engines of the command: those of `sim`, and MuJoCo from `crosscheck`.
//!
//! In: the word after `--engine`. Out: an engine. Another engine is one more line in [`engines`].

use takes::{EngineEntry, Engines, UnknownEngine};

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

/// The word of `--confirm` for no engine.
pub const NONE: &str = "none";

/// The engine of the word after `--confirm`; `None` for the word `none`, and for the engine that searched: it would say the same again.
///
/// # Errors
/// A name that no engine has.
pub fn confirming<'a>(
    engines: &'a Engines,
    word: &str,
    searcher: &EngineEntry,
) -> Result<Option<&'a EngineEntry>, UnknownEngine> {
    if word == NONE {
        return Ok(None);
    }
    engines.get(word).map(|e| (e.name() != searcher.name()).then_some(e))
}
