//! Movement-property edits: changes to transition-element tracks in an animator's words (NF03).
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
//! ```
//! # use motion::script::{Action, Cycle, Pose, PoseValue, Script};
//! # use motion::{Joint, Link, Skeleton, Vec3};
//! use edits::{Amplitude, Edit, EditLog, Selector};
//! # let hinge = Joint::Revolute(Vec3::x());
//! # let links = vec![Link::new("lamp", None, Vec3::zeros(), hinge)];
//! # let lamp = std::sync::Arc::new(Skeleton::new(links).unwrap());
//! # let pose = |x| Pose { values: vec![PoseValue::scalar("lamp", x)], ..Pose::default() };
//! # let cycle = Cycle { repetitions: 4, poses: vec![pose(0.5), pose(0.1)], ..Cycle::default() };
//! # let nod = Action { name: "nod".into(), cycles: vec![cycle], ..Action::default() };
//! # let script = Script { actions: vec![nod], ..Script::default() };
//! let mut tracks = script.build(&lamp, &lamp.zero_pose()).unwrap();
//! let mut log = EditLog::default();
//! for (edit, on) in [(Amplitude::new(0.5), "nod"), (Amplitude::new(2.0), "nod_0_1")] {
//!     let selection = Selector::label(on).select(&tracks).unwrap();
//!     edit.apply(&mut tracks, &selection, &mut log).unwrap();
//! }
//! assert_eq!(log.conflicts().len(), 4); // nod_0_1, in each repetition, was written twice
//! ```
//!
//! A new edit is a type that implements [`Edit`]; [`Edit::apply`] gives it the log, the check that
//! results are possible and the promise that a failed edit leaves the tracks alone.
//!
//! NF03: Neff, Fiume. Aesthetic edits for character animation. SCA 2003.

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

use motion::{Track, Tracks};

/// A movement-property edit.
pub trait Edit {
    /// Its name, as scenes and the log call it.
    fn name(&self) -> &'static str;

    /// Changes the tracks. Called by [`Edit::apply`]; may use [`EditLog::clamp`] and [`EditLog::note`],
    /// need not restore anything when it fails.
    ///
    /// Elements keep their labels. Tracks are put in order of time afterwards.
    ///
    /// # Errors
    /// Bad parameters, bodies the edit does not fit.
    fn change(&self, tracks: &mut Tracks, selection: &Selection, log: &mut EditLog) -> Result<(), EditError>;

    /// Applies the edit to the elements selected: the tracks lengthen if need be, the log learns every
    /// change.
    ///
    /// # Errors
    /// Those of [`Edit::change`], and results no element can have ([`EditError::Result`]); tracks and log are
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
fn check(edit: &'static str, tracks: &Tracks) -> Result<(), EditError> {
    for (_, e) in tracks.elements() {
        let numbers = [e.start_s, e.duration_s, e.hold_s, e.tension];
        let finite = e.end.is_valid() && numbers.iter().all(|x| x.is_finite());
        if !finite || e.duration_s < 0.0 || e.hold_s < 0.0 {
            return Err(EditError::Result { edit, label: e.label.named(&tracks.skeleton) });
        }
    }
    Ok(())
}
