//! A program as an edit of tracks: `fn elements(script, params)`.
//!
//! In: tracks, the elements selected. Out: the tracks as the program left them, and its notes in the log.

use edits::{EditError, EditLog, Selection, TrackEdit};
use motion::Tracks;

use crate::elements::ScriptHandle;
use crate::engine::engine;
use crate::limits::EDIT_STEPS;
use crate::program::NAME;
use crate::{Entry, Program};

impl TrackEdit for Program {
    fn name(&self) -> &'static str {
        NAME
    }

    fn change(&self, tracks: &mut Tracks, selection: &Selection, log: &mut EditLog) -> Result<(), EditError> {
        self.must(Entry::Elements)?;
        let elements: usize = tracks.tracks.iter().map(|t| t.elements.len()).sum();
        let engine = engine(EDIT_STEPS.0 + EDIT_STEPS.1 * elements as u64);
        let given = || ScriptHandle::new(tracks, selection);
        let script = given();
        self.call(&engine, Entry::Elements, None, script.clone(), given)?;
        let (changed, notes) = script.take();
        *tracks = changed;
        log.note(self.file().display().to_string());
        notes.into_iter().for_each(|note| log.note(note));
        Ok(())
    }
}
