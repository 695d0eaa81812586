//! The clip edit `Style`: components of a set in any clip.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::set::StyleSet;
use super::transfer::{Transfer, transfer};
use crate::{ClipEdit, ClipPlace, EditError, EditLog, Edited, Motion};

/// Components of a set, put into a clip. See [`mod@super::transfer`].
#[derive(Clone, Debug, PartialEq)]
pub struct Style {
    /// The components.
    pub set: Arc<StyleSet>,
    /// Which of them, how much, aligned how.
    pub how: Transfer,
    /// Bones of the set and what the clip calls them, where the names differ.
    pub names: BTreeMap<String, String>,
}

impl ClipEdit for Style {
    fn name(&self) -> &'static str {
        "style"
    }

    fn change(&self, motion: &Motion, at: &ClipPlace, log: &mut EditLog) -> Result<Edited, EditError> {
        if !at.parts.is_empty() {
            return Err(EditError::WholeBody { edit: self.name(), parts: at.parts.join(", ") });
        }
        let styled = transfer(&self.set, motion, &self.how, (at.from_s, at.to_s), &self.names)
            .map_err(|e| EditError::Style(Box::new(e)))?;
        for note in styled.notes {
            log.note(note);
        }
        Ok(styled.edited)
    }
}
