//! Edits of tracks on any motion: succession, amplitude and extent through a fit.
//!
//! In: a clip and a [`TrackEdit`]. Out: the clip edited. Three steps:
//!
//! 1. the clip is fitted by transition elements within a tolerance ([`motion::fit`]);
//! 2. the edit acts on the elements ([`TrackEdit::change_fit`]);
//! 3. the *difference* it makes is laid over the clip: with `F` the fit and `E` the fit edited, a rotation becomes
//!    `E F⁻¹ R`, a length `x + E − F`. What the fit left out, the detail, stays, and goes with its element where that is moved in
//!    time; corners, where elements meet, are smoothed out of the difference (12 Hz); and an edit that changes nothing returns the
//!    clip to the bit.
//!
//! The root and legs that stand are left out unless `parts` names them ([`STEP_S`], [`STEP_M`]); feet then stand where they stood
//! in the clip, by IK. At the ends of a span after or before which the clip goes on, the difference is blended in and out over
//! 0.25 s.
//!
//! Beyond \[NF03\], whose edits act on scripts only.
//!
//! ```
//! # use motion::{Clip, Joint, Link, Skeleton, Vec3};
//! use edits::{Amplitude, ClipEdit, EditLog, Motion, OnFit, Where};
//! # let links = vec![Link::new("lamp", None, Vec3::zeros(), Joint::Revolute(Vec3::x()))];
//! # let lamp = std::sync::Arc::new(Skeleton::new(links).unwrap());
//! // a lamp that nods about 0.4 rad
//! let nod = |frame: usize| 0.4 + 0.3 * (frame as f64 * 0.05).sin();
//! let clip = Clip::new(lamp, 60.0, (0..=377).map(nod).collect()); // three times
//! let calm = OnFit::new(Amplitude::new(0.5));
//! let edited = calm.apply(&Motion::of(clip), &Where::default(), &mut EditLog::default()).unwrap();
//! for frame in 0..=377 {
//!     let half = 0.4 + 0.5 * (nod(frame) - 0.4);
//!     assert!((edited.clip.pose(frame)[0] - half).abs() < 0.02); // 1.1°
//! }
//! ```
//!
//! NF03: Neff, Fiume. Aesthetic edits for character animation. SCA 2003.

mod lay;
mod support;

use std::collections::{BTreeMap, BTreeSet};

use motion::{Dof, Fit, LimbKind, Skeleton, Tolerance, Track, Tracks};

use crate::feet::{Feet, worlds};
use crate::fit_place::FitPlace;
use crate::track_edit::check;
use crate::{ClipEdit, ClipPlace, EditError, EditLog, Edited, Motion, Selection, TrackEdit};

use support::Support;
pub use support::{STEP_M, STEP_S};

/// Times that differ by less are one time, s.
const SAME_S: f64 = 1e-9;

/// A track edit on a clip. See the module header.
pub struct OnFit {
    /// The edit.
    pub edit: Box<dyn TrackEdit + Send + Sync>,
    /// How close the elements are to the clip.
    pub fit: Tolerance,
}

impl OnFit {
    /// With the default tolerance, 2° and 10 mm.
    pub fn new(edit: impl TrackEdit + Send + Sync + 'static) -> Self {
        Self { edit: Box::new(edit), fit: Tolerance::default() }
    }
}

impl ClipEdit for OnFit {
    fn name(&self) -> &'static str {
        self.edit.name()
    }

    fn change(&self, motion: &Motion, at: &ClipPlace, log: &mut EditLog) -> Result<Edited, EditError> {
        let edit = self.name();
        let clip = &motion.clip;
        let s = &clip.skeleton;
        let fit = Fit::of(clip, &self.fit).map_err(|source| EditError::Fit { edit, source })?;
        let support =
            if at.parts.is_empty() { Support::of(motion, at.from_s, at.to_s) } else { Support::none() };
        let mut dofs = at.dofs.clone();
        let frame = |t_s: f64| ((t_s * clip.rate_hz).round() as usize).min(clip.frames() - 1);
        dofs.retain(|dof| !support.leaves_out(*dof, frame(at.from_s)..=frame(at.to_s)));
        let (from_s, to_s, end_s) = (at.from_s, at.to_s, clip.duration_s());
        let arrives = |t: f64| t > from_s - SAME_S && t < to_s + SAME_S;
        let selection =
            Selection::of_fit(&fit.tracks, dofs.clone(), !at.parts.is_empty(), |e| arrives(e.arrives_s()));
        if selection.is_empty() {
            let what = nothing(&fit.tracks, &dofs, at);
            return Err(EditError::NothingFitted { edit, what });
        }
        let place = FitPlace { selection, from_s, to_s, end_s };
        let mut changed = fit.tracks.clone();
        let mut inner = EditLog::default();
        self.edit.change_fit(&mut changed, &place, &mut inner)?;
        check(edit, &changed)?;
        changed.tracks.iter_mut().for_each(Track::sort);
        log.note(fit.report.to_string());
        tell(log, &inner, s);
        if changed == fit.tracks {
            return Ok(Edited::unchanged(motion));
        }
        log.note_all(support.words(&s.links()[0].name));
        let mut edited = Edited::unchanged(motion);
        lay::over(&mut edited.clip, &fit.tracks, &changed, &place, &support);
        let feet = Feet::of(clip, &motion.contacts, &worlds(clip));
        let legs = s.limbs().iter().any(|l| l.kind == LimbKind::Leg);
        if !feet.is_empty() || legs {
            let said = feet.hold(&mut edited.clip)?;
            log.note_all(said);
        }
        Ok(edited)
    }
}

/// Why nothing is selected.
fn nothing(tracks: &Tracks, dofs: &BTreeSet<Dof>, at: &ClipPlace) -> String {
    let names = |dofs: &mut dyn Iterator<Item = Dof>| {
        let names: BTreeSet<String> = dofs.map(|d| d.name(&tracks.skeleton)).collect();
        names.into_iter().collect::<Vec<_>>().join(", ")
    };
    let moves = |dof: &Dof| tracks.track(*dof).is_some_and(|t| !t.elements.is_empty());
    if !at.dofs.iter().any(moves) {
        return format!("{} keep still in this clip", names(&mut at.dofs.iter().copied()));
    }
    if !dofs.iter().any(moves) {
        return "all that moves stands, or carries what stands; name it in `parts` to change it all the same"
            .into();
    }
    format!(
        "no key of {} lies within {:.3} s to {:.3} s: take a longer span, or a closer `fit`",
        names(&mut dofs.iter().copied().filter(moves)),
        at.from_s,
        at.to_s
    )
}

/// Hands on what the edit said of elements nobody wrote: counted, not key by key.
fn tell(log: &mut EditLog, inner: &EditLog, skeleton: &Skeleton) {
    let mut cut: BTreeMap<usize, usize> = BTreeMap::new();
    for (_, label) in inner.clamped() {
        *cut.entry(label.dof).or_default() += 1;
    }
    let dofs = Dof::all(skeleton);
    for (dof, keys) in cut {
        log.note(format!("{}: {keys} keys cut by a limit", dofs[dof].name(skeleton)));
    }
    let notes: Vec<&String> = inner.notes().iter().map(|(_, note)| note).collect();
    if let [first, rest @ ..] = notes.as_slice() {
        let more =
            if rest.is_empty() { String::new() } else { format!(" (and {} more like this)", rest.len()) };
        log.note(format!("{first}{more}"));
    }
}
