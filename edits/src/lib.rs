//! Movement-property edits: changes to transition-element tracks in an animator's words [NF03].
//!
//! In: [`Tracks`] and a [`Selection`] of their elements. Out: the tracks changed, and an [`EditLog`] that
//! says which edit last wrote what. Edits know nothing of files, of physics or of each other; they run in
//! the order the caller applies them.
//!
//! | module | holds |
//! |---|---|
//! | [`selector`] | what an edit applies to: script, action, cycle, repetition, pose, element, body part |
//! | [`param`] | parameters: constants, curves over time or repetition, one value for each pose |
//! | [`log`] | which edit last wrote each element; conflicts |
//! | [`succession`] | joints start one after another along the body |
//! | [`amplitude`] | how far a movement goes about its average or a reference pose |
//! | [`extent_shoulder`] | how far the arms are from the body |
//! | [`extent_reach`] | how far the hands are from the shoulders |
//! | [`tension`] | how stiff the muscles are |
//! | [`poses`] | elements grouped by pose: for edits that think in poses |
//! | [`error`] | what can be wrong |
//!
//! A new edit is a type that implements [`Edit`]; [`Edit::apply`] gives it the log, the check that
//! results are finite and the promise that a failed edit leaves the tracks alone.
//!
//! [NF03] Neff, Fiume. Aesthetic edits for character animation. SCA 2003.

pub mod amplitude;
pub mod error;
pub mod extent_reach;
pub mod extent_shoulder;
pub mod log;
pub mod param;
pub mod poses;
pub mod selector;
pub mod succession;
pub mod tension;

pub use amplitude::Amplitude;
pub use error::EditError;
pub use extent_reach::ExtentReach;
pub use extent_shoulder::ExtentShoulder;
pub use log::{Conflict, EditLog, Field};
pub use param::Parameter;
pub use selector::{Place, Selection, Selector};
pub use succession::{Direction, Succession};
pub use tension::{Amount, Tension};

use motion::Tracks;

/// A movement-property edit.
pub trait Edit {
    /// Its name, as scenes and the log call it.
    fn name(&self) -> &'static str;

    /// Changes the tracks. Called by [`Edit::apply`]; may use [`EditLog::clamp`] and [`EditLog::note`],
    /// need not restore anything when it fails.
    ///
    /// Elements keep their labels; each track must be left in order of time.
    ///
    /// # Errors
    /// Bad parameters, bodies the edit does not fit.
    fn change(&self, tracks: &mut Tracks, selection: &Selection, log: &mut EditLog) -> Result<(), EditError>;

    /// Applies the edit to the elements selected: the tracks lengthen if need be, the log learns every
    /// change.
    ///
    /// # Errors
    /// Those of [`Edit::change`], and results that are not finite; tracks and log are then as before.
    fn apply(&self, tracks: &mut Tracks, selection: &Selection, log: &mut EditLog) -> Result<(), EditError> {
        let mut changed = tracks.clone();
        log.begin(self.name());
        let done = self.change(&mut changed, selection, log).and_then(|()| self.check(&changed));
        if let Err(e) = done {
            log.abandon();
            return Err(e);
        }
        changed.extend_duration();
        log.record(tracks, &changed);
        *tracks = changed;
        Ok(())
    }

    /// Refuses results that are not finite. Called by [`Edit::apply`].
    ///
    /// # Errors
    /// [`EditError::NotFinite`] with the first such element.
    fn check(&self, tracks: &Tracks) -> Result<(), EditError> {
        for (_, e) in tracks.elements() {
            let numbers = [e.start_s, e.duration_s, e.hold_s, e.tension];
            if !e.end.is_valid() || !numbers.iter().all(|x| x.is_finite()) {
                let label = e.label.named(&tracks.skeleton);
                return Err(EditError::NotFinite { edit: self.name(), label });
            }
        }
        Ok(())
    }
}
