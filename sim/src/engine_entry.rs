//! An entry of the table of engines: a name, one line about it, and a constructor.
//!
//! In: what builds an [`Engine`]. Out: an [`EngineEntry`], which an engine gives of itself and [`crate::Engines`] keeps.

use std::fmt;
use std::sync::Arc;

use bodies::Character;

use crate::{Engine, EngineError, EngineSettings};

/// A constructor: body, settings, first pose (`nq`) and first velocity (`nv`) to an engine in that state.
type Build =
    dyn Fn(&Character, EngineSettings, &[f64], &[f64]) -> Result<Box<dyn Engine>, EngineError> + Send + Sync;

/// An engine that can be built: its name, one line about it, its constructor. Cheap to clone.
#[derive(Clone)]
pub struct EngineEntry {
    name: Arc<str>,
    description: Arc<str>,
    substeps: Option<usize>,
    build: Arc<Build>,
}

impl EngineEntry {
    /// An entry of this name.
    ///
    /// `build` is given the body, the settings, the first pose (`nq`) and the first velocity (`nv`).
    pub fn new(
        name: &str,
        description: &str,
        build: impl Fn(&Character, EngineSettings, &[f64], &[f64]) -> Result<Box<dyn Engine>, EngineError>
        + Send
        + Sync
        + 'static,
    ) -> Self {
        Self { name: name.into(), description: description.into(), substeps: None, build: Arc::new(build) }
    }

    /// The same entry, whose engine takes `substeps` per control step where none are asked for; otherwise the pass takes as many
    /// as its stiffest joint needs.
    pub fn with_substeps(self, substeps: usize) -> Self {
        Self { substeps: Some(substeps), ..self }
    }

    /// Substeps per control step where none are asked for, if the engine has a number of its own.
    pub fn substeps(&self) -> Option<usize> {
        self.substeps
    }

    /// The name by which it is chosen.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// One line about it.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// Builds the engine with the body at the pose `q` (`nq`) with the velocity `v` (`nv`).
    ///
    /// # Errors
    /// [`EngineError`]: what the engine finds wrong.
    pub fn build(
        &self,
        character: &Character,
        settings: EngineSettings,
        q: &[f64],
        v: &[f64],
    ) -> Result<Box<dyn Engine>, EngineError> {
        (self.build)(character, settings, q, v)
    }
}

impl fmt::Debug for EngineEntry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("EngineEntry").field("name", &self.name).finish_non_exhaustive()
    }
}
