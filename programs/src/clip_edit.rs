//! A program as an edit of clips: `fn clip(clip, params)`.
//!
//! In: a motion, a place in it. Out: the motion as the program left it, then retimed if it gave anchors ([`edits::Warp`]), and its notes
//! in the log.

use edits::{ClipEdit, ClipPlace, EditError, EditLog, Edited, Motion, Warp};

use crate::engine::engine;
use crate::frames::ClipHandle;
use crate::limits::EDIT_STEPS;
use crate::program::NAME;
use crate::{Entry, Program};

impl ClipEdit for Program {
    fn name(&self) -> &'static str {
        NAME
    }

    fn change(&self, motion: &Motion, at: &ClipPlace, log: &mut EditLog) -> Result<Edited, EditError> {
        self.must(Entry::Clip)?;
        let joints = motion.clip.skeleton.links().len();
        let engine = engine(EDIT_STEPS.0 + EDIT_STEPS.1 * (motion.clip.frames() * joints) as u64);
        let given = || ClipHandle::new(&motion.clip, at);
        let clip = given();
        self.call(&engine, Entry::Clip, None, clip.clone(), given)?;
        let left = clip.take();
        log.note(self.file().display().to_string());
        left.notes.into_iter().for_each(|note| log.note(note));
        let edited = Edited { clip: left.clip, ..Edited::unchanged(motion) };
        if left.anchors.is_empty() {
            return Ok(edited);
        }
        let changed = Motion { clip: edited.clip, ..motion.clone() };
        Warp { anchors: left.anchors }.change(&changed, at, log)
    }
}
