//! Clip edits: changes to a sampled motion, wherever it came from.
//!
//! In: a [`Motion`]: a clip with what else is known of it (contacts, floor, the script it was sampled from). Out: an
//! [`Edited`]: the clip changed, its contacts, and how time was changed. [`ClipEdit::apply`] gives every edit its
//! place, the log, the check that results are possible, and the promise that a failed edit leaves no trace; an
//! edit itself writes only [`ClipEdit::change`].
//!
//! Edits are chained by [`Motion::with`]. All times are those of the clip as it is when the edit runs.
//!
//! A new clip edit is four small things: a file here that implements [`ClipEdit`], a word in the scene's list of
//! edits, a scene, and a test that it moves its own number. The first of them, whole:
//!
//! ```
//! use edits::{ClipEdit, ClipPlace, EditError, EditLog, Edited, Motion, Where};
//! use motion::{Dof, Value};
//!
//! /// Bends hinges further, most in the middle of the span.
//! struct Bend {
//!     by_rad: f64,
//! }
//!
//! impl ClipEdit for Bend {
//!     fn name(&self) -> &'static str {
//!         "bend"
//!     }
//!
//!     fn change(&self, motion: &Motion, at: &ClipPlace, _: &mut EditLog) -> Result<Edited, EditError> {
//!         let mut edited = Edited::unchanged(motion);
//!         let clip = &mut edited.clip;
//!         let s = clip.skeleton.clone();
//!         for frame in 0..clip.frames() {
//!             let t_s = frame as f64 / clip.rate_hz;
//!             if !at.covers(t_s) {
//!                 continue;
//!             }
//!             let u = (t_s - at.from_s) / (at.to_s - at.from_s);
//!             let by = self.by_rad * 16.0 * (u * (1.0 - u)).powi(2); // smooth at both ends
//!             let q = clip.pose_mut(frame);
//!             for &dof in &at.dofs {
//!                 if let Value::Scalar(x) = dof.read(&s, q) && matches!(dof, Dof::Axis(_)) {
//!                     dof.write(&s, q, &Value::Scalar(x + by));
//!                 }
//!             }
//!         }
//!         Ok(edited)
//!     }
//! }
//! # use motion::{Clip, Joint, Link, Skeleton, Vec3};
//! # let links = vec![Link::new("lamp", None, Vec3::zeros(), Joint::Revolute(Vec3::x()))];
//! # let clip = Clip::new(std::sync::Arc::new(Skeleton::new(links).unwrap()), 30.0, vec![0.2; 61]);
//!
//! let mut log = EditLog::default();
//! let motion = Motion::of(clip);
//! let edited = Bend { by_rad: 0.5 }.apply(&motion, &Where::span(0.0, 2.0), &mut log).unwrap();
//! assert!((edited.clip.pose(30)[0] - 0.7).abs() < 1e-12);
//! assert_eq!(log.to_string(), "bend (edit 0): 0.033 s to 1.967 s: lamp; at most 28.65° at lamp\n");
//! ```

use crate::clip_change::ClipChange;
use crate::{ClipPlace, EditError, EditLog, Edited, Motion, Where};

/// An edit of clips. See the module header.
pub trait ClipEdit {
    /// Its name, as scenes and the log call it.
    fn name(&self) -> &'static str;

    /// Gives the motion changed. Called by [`ClipEdit::apply`]; may use [`EditLog::note`].
    ///
    /// # Errors
    /// Bad parameters, places and bodies the edit does not fit.
    fn change(&self, motion: &Motion, at: &ClipPlace, log: &mut EditLog) -> Result<Edited, EditError>;

    /// Applies the edit to a place; the log learns what it changed ([`EditLog::clip_changes`]).
    ///
    /// # Errors
    /// Those of [`Where::in_clip`] and of [`ClipEdit::change`], and results no clip can have
    /// ([`EditError::ClipResult`]); the log is then as before.
    fn apply(&self, motion: &Motion, at: &Where, log: &mut EditLog) -> Result<Edited, EditError> {
        let place = at.in_clip(motion)?;
        log.begin(self.name());
        let done = self.change(motion, &place, log).and_then(|edited| {
            Ok((ClipChange::measure(self.name(), log.current(), motion, &edited)?, edited))
        });
        match done {
            Ok((change, edited)) => {
                log.record_clip(change);
                Ok(edited)
            }
            Err(e) => {
                log.abandon();
                Err(e)
            }
        }
    }
}
