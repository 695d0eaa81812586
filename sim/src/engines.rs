//! Engines by name: the table from which a pass gets its engine.
//!
//! In: entries. Out: the [`EngineEntry`] of a name, the value that [`Pass::start`](crate::Pass::start) builds its
//! engine from. [`Engines::default`] knows the engines of this crate; a program adds others by
//! [`add`](Engines::add), and nothing else has to know of them.

use motion::names::hint;
use thiserror::Error;

use crate::EngineEntry;

impl Default for EngineEntry {
    /// The engine that is used where none is chosen: rapier.
    fn default() -> Self {
        crate::rapier::engine()
    }
}

/// A name that no engine has.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("unknown engine `{name}`{hint} (allowed: {allowed})")]
pub struct UnknownEngine {
    /// The name asked for.
    pub name: String,
    /// The nearest name, as the end of a sentence.
    hint: String,
    /// All names there are.
    pub allowed: String,
}

/// The engines of a program, by name, in the order in which they were added.
#[derive(Clone, Debug)]
pub struct Engines(Vec<EngineEntry>);

impl Default for Engines {
    /// rapier and the core.
    fn default() -> Self {
        Self(vec![EngineEntry::default(), crate::core::engine()])
    }
}

impl Engines {
    /// Adds an engine; one of the same name is replaced.
    ///
    /// # Examples
    /// ```
    /// use sim::{EngineEntry, EngineError, Engines};
    /// let mut engines = Engines::default();
    /// engines.add(EngineEntry::new("bullet", "an engine of another kind", |_, _, _, _| {
    ///     Err(EngineError::Failed("not on this machine".into()))
    /// }));
    /// assert_eq!(engines.get("bullet").unwrap().name(), "bullet");
    /// let error = engines.get("bulet").unwrap_err().to_string();
    /// assert_eq!(error, "unknown engine `bulet`; did you mean `bullet`? (allowed: rapier, core, bullet)");
    /// ```
    pub fn add(&mut self, entry: EngineEntry) {
        match self.0.iter_mut().find(|e| e.name() == entry.name()) {
            Some(old) => *old = entry,
            None => self.0.push(entry),
        }
    }

    /// The engine of this name.
    ///
    /// # Errors
    /// [`UnknownEngine`], with the nearest name and those allowed.
    pub fn get(&self, name: &str) -> Result<&EngineEntry, UnknownEngine> {
        self.0.iter().find(|e| e.name() == name).ok_or_else(|| {
            let known: Vec<&str> = self.0.iter().map(EngineEntry::name).collect();
            let near = motion::names::nearest(name, known.iter().copied()).is_some();
            let hint = if near { hint(name, known.iter().copied()) } else { String::new() };
            UnknownEngine { name: name.into(), hint, allowed: known.join(", ") }
        })
    }

    /// All engines.
    pub fn iter(&self) -> impl Iterator<Item = &EngineEntry> {
        self.0.iter()
    }
}
