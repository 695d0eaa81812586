//! Track edits: changes to transition-element tracks in an animator's words (NF03).
//!
//! In: [`Tracks`] and a [`Selection`] of their elements. Out: the tracks changed. [`TrackEdit::apply`] gives every
//! edit the log, the check that results are possible, and the promise that a failed edit leaves tracks and log as
//! they were; an edit itself writes only [`TrackEdit::change`].
//!
//! NF03: Neff, Fiume. Aesthetic edits for character animation. SCA 2003.

use motion::{Track, Tracks};

use crate::fit_place::FitPlace;
use crate::{EditError, EditLog, Selection};

/// A movement-property edit of tracks. See the module header.
pub trait TrackEdit {
    /// Its name, as scenes and the log call it.
    fn name(&self) -> &'static str;

    /// Changes the tracks. Called by [`TrackEdit::apply`]; may use [`EditLog::clamp`] and [`EditLog::note`],
    /// need not restore anything when it fails.
    ///
    /// Elements keep their labels. Tracks are put in order of time afterwards.
    ///
    /// # Errors
    /// Bad parameters, bodies the edit does not fit.
    fn change(&self, tracks: &mut Tracks, selection: &Selection, log: &mut EditLog) -> Result<(), EditError>;

    /// Changes the tracks that a clip was fitted by, see [`crate::on_fit`]; called by [`crate::OnFit`]. Keys of a fit are
    /// dense and are nobody's poses: an edit that thinks in poses says here what it means for them. By default it acts as on a script.
    ///
    /// # Errors
    /// As [`TrackEdit::change`]; edits and parameters that mean nothing on a fit.
    fn change_fit(&self, tracks: &mut Tracks, place: &FitPlace, log: &mut EditLog) -> Result<(), EditError> {
        self.change(tracks, &place.selection, log)
    }

    /// Applies the edit to the elements selected: the tracks lengthen if need be, the log learns every
    /// change.
    ///
    /// # Errors
    /// Those of [`TrackEdit::change`], and results no element can have ([`EditError::Result`]); tracks and log are
    /// then as before.
    fn apply(&self, tracks: &mut Tracks, selection: &Selection, log: &mut EditLog) -> Result<(), EditError> {
        let mut changed = tracks.clone();
        log.begin(self.name());
        let done = self.change(&mut changed, selection, log).and_then(|()| check(self.name(), &changed));
        if let Err(e) = done {
            log.abandon();
            return Err(e);
        }
        changed.tracks.iter_mut().for_each(Track::sort);
        changed.extend_duration();
        log.record(tracks, &changed);
        *tracks = changed;
        Ok(())
    }
}

/// Refuses numbers that are not finite and lengths that are negative.
pub(crate) fn check(edit: &'static str, tracks: &Tracks) -> Result<(), EditError> {
    for (_, e) in tracks.elements() {
        let numbers = [e.start_s, e.duration_s, e.hold_s, e.tension];
        let finite = e.end.is_valid() && numbers.iter().all(|x| x.is_finite());
        if !finite || e.duration_s < 0.0 || e.hold_s < 0.0 {
            return Err(EditError::Result { edit, label: e.label.named(&tracks.skeleton) });
        }
    }
    Ok(())
}
