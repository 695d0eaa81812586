//! The clip edits of a scene, applied in order to a sampled motion.
//!
//! In: a [`Motion`] from any source, the edits a scene declares. Out: the motion edited, or an error at the edit that does not fit; of a
//! script also which joints are now performed as a dense clip, and how tense they are when.

use std::sync::Arc;

use controllers::plan::dense::BLEND_S;
use controllers::{Dense, DenseJoint};
use dynamics::conditions::RootMode;
use edits::tension::Steps;
use edits::{ByExample, ClipChange, ClipEdit, EditLog, Motion};
use motion::{Clip, Dof, Joint, LimbKind, TimeMap, Tracks};
use scenes::library;
use scenes::scene::{EditKind, Scene, SceneEdit, StoredEdit};
use scenes::{SceneError, Source};

use crate::user_programs::{clip_program, edit_fault};

/// A motion after the clip edits of its scene.
pub(crate) struct Clips {
    /// The motion.
    pub motion: Motion,
    /// Whether any edit changed it: what was changed is performed as a dense clip.
    pub changed: bool,
    /// Tension over time of each link's joint, in the time of the motion; of motions without a script.
    pub tension: Vec<Steps>,
}

impl Clips {
    /// The joints whose tension edits changed, as the pass takes them.
    pub(crate) fn tense(&self) -> Dense {
        let joints = self.tension.iter().enumerate().filter(|(_, steps)| !steps.is_empty());
        Dense { joints: joints.map(|(link, steps)| DenseJoint::throughout(link, steps.clone())).collect() }
    }
}

/// Applies the clip edits of a scene; track edits have been applied before. `seen` is what will be seen of a motion, feet planted, where that is
/// not the motion itself: edits that were learned from motions as they are seen recognise it by that.
///
/// # Errors
/// Places that the motion does not have, parameters that make no sense: at the edit.
pub(crate) fn apply(
    scene: &Scene,
    motion: Motion,
    log: &mut EditLog,
    seen: impl Fn(&Motion) -> Result<Option<Clip>, SceneError>,
) -> Result<Clips, SceneError> {
    let edits = scene.edits.iter().map(|e| (&scene.source, e));
    let root = scene.conditions.physics.root;
    apply_all(edits, motion, root, log, seen)
}

/// Applies edits, each with the text it stands in, to a motion whose root is held like this.
///
/// # Errors
/// As [`apply`].
pub(crate) fn apply_all<'a>(
    edits: impl IntoIterator<Item = (&'a Source, &'a SceneEdit)>,
    mut motion: Motion,
    root: RootMode,
    log: &mut EditLog,
    seen: impl Fn(&Motion) -> Result<Option<Clip>, SceneError>,
) -> Result<Clips, SceneError> {
    let mut changed = false;
    let s = motion.clip.skeleton.clone();
    let mut tension = vec![Steps::new(); s.links().len()];
    // the balance of a body on its own feet has the legs
    let legs = s.limbs().iter().filter(|l| l.kind == LimbKind::Leg && root != RootMode::Pinned);
    let legs: Vec<usize> = legs.flat_map(|l| l.links()).collect();
    for (source, e) in edits {
        let edited = match &e.kind {
            // pins act last, on a motion that was made possible: `pins`
            EditKind::Track(_) | EditKind::Pin(_) => continue,
            EditKind::Tension(edit) => {
                let fixed = (&*legs, "of legs that stand the balance decides, but under `root: Pinned`");
                edit.on_clip(&motion, &e.place, fixed, &mut tension, log)
                    .map_err(|x| edit_fault(source, &e.at, x))?;
                continue;
            }
            EditKind::Clip(edit) => edit.apply(&motion, &e.place, log),
            EditKind::Stored(stored) => {
                if matches!(stored, StoredEdit::ByExample { .. }) {
                    motion.seen = seen(&motion)?;
                }
                open(stored, source, &e.at)?.apply(&motion, &e.place, log)
            }
            EditKind::Program(_) => match clip_program(source, e, &motion)? {
                Some(program) => ClipEdit::apply(&program, &motion, &e.place, log),
                None => continue,
            },
        }
        .map_err(|x| edit_fault(source, &e.at, x))?;
        changed |= edited.clip != motion.clip || !edited.times.is_identity();
        for step in tension.iter_mut().flatten() {
            step.0 = edited.times.at(step.0);
        }
        motion = motion.with(edited);
    }
    Ok(Clips { motion, changed, tension })
}

/// The edit that a file holds.
///
/// # Errors
/// Files that hold none: at the edit.
fn open(stored: &StoredEdit, source: &Source, at: &str) -> Result<Box<dyn ClipEdit>, SceneError> {
    match stored {
        StoredEdit::ByExample { model, amount, contacts } => {
            let opened = match library::bytes(model) {
                Some(bytes) => formats::example_file::read(std::io::Cursor::new(bytes)),
                None => formats::example_file::open(model),
            };
            let edit = opened
                .map_err(|x| source.error(&format!("{at}.model"), format!("{}: {x}", model.display())))?;
            let whole = ByExample::new(Arc::new(edit));
            let contacts = contacts.unwrap_or(whole.contacts);
            Ok(Box::new(ByExample { amount: *amount, contacts, ..whole }))
        }
        StoredEdit::Style(spec) => {
            let style = crate::styles::of_spec(spec).map_err(|x| source.error(at, x.to_string()))?;
            Ok(Box::new(style))
        }
    }
}

/// The joints of a script that clip edits changed, each with the tension that its elements say at their (edited) times.
///
/// What was retimed changed as a whole. A joint that a clip edit touched is dense while the edit acts; before and after it follows
/// its elements.
pub(crate) fn dense(tracks: &Tracks, log: &EditLog, times: &TimeMap) -> Dense {
    let skeleton = &tracks.skeleton;
    let all = !times.is_identity();
    let moves = |link: &usize| !matches!(skeleton.links()[*link].joint, Joint::Fixed);
    let joint = |link: usize| {
        let whole = DenseJoint::throughout(link, tension(tracks, link, times));
        if all {
            return Some(whole);
        }
        let name = &skeleton.links()[link].name;
        // dense as the change begins
        let of = |c: &ClipChange| c.joints.contains(name).then_some((c.from_s - BLEND_S, c.to_s));
        let spans: Vec<(f64, f64)> = log.clip_changes().iter().filter_map(of).collect();
        (!spans.is_empty()).then(|| DenseJoint::during(link, whole.tension, spans))
    };
    Dense { joints: (0..skeleton.links().len()).filter(moves).filter_map(joint).collect() }
}

/// Tension of a joint over time, as its elements say.
pub(crate) fn tension(tracks: &Tracks, link: usize, times: &TimeMap) -> Vec<(f64, f64)> {
    let own = Dof::of_link(&tracks.skeleton, link).and_then(|dof| tracks.track(dof));
    let mut steps = vec![(0.0, tracks.base_tension[link])];
    for e in own.iter().flat_map(|t| &t.elements) {
        steps.push((times.at(e.start_s), tracks.tension_at(link, e.start_s + 1e-9)));
    }
    steps.sort_by(|a, b| a.0.total_cmp(&b.0));
    steps.dedup_by(|b, a| a.1 == b.1);
    steps
}
