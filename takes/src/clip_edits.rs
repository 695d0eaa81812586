//! The clip edits of a scene, applied in order to a sampled motion.
//!
//! In: a [`Motion`] from any source, the edits a scene declares. Out: the motion edited, or an error at the edit that does not fit; of a
//! script also which joints are now performed as a dense clip, and how tense they are when.

use std::sync::Arc;

use controllers::plan::dense::BLEND_S;
use controllers::{Dense, DenseJoint};
use edits::{ByExample, ClipChange, ClipEdit, EditLog, Motion};
use motion::{Dof, Joint, TimeMap, Tracks};
use scenes::SceneError;
use scenes::scene::{EditKind, Scene, StoredEdit};

use crate::user_programs::{clip_program, edit_fault};

/// A motion after the clip edits of its scene.
pub(crate) struct Clips {
    /// The motion.
    pub motion: Motion,
    /// Whether any edit changed it: what was changed is performed as a dense clip.
    pub changed: bool,
}

/// Applies the clip edits of a scene; track edits have been applied before.
///
/// # Errors
/// Places that the motion does not have, parameters that make no sense: at the edit.
pub(crate) fn apply(scene: &Scene, mut motion: Motion, log: &mut EditLog) -> Result<Clips, SceneError> {
    let mut changed = false;
    for e in &scene.edits {
        let edited = match &e.kind {
            EditKind::Track(_) => continue,
            EditKind::Clip(edit) => edit.apply(&motion, &e.place, log),
            EditKind::Stored(stored) => open(stored, scene, &e.at)?.apply(&motion, &e.place, log),
            EditKind::Program(_) => match clip_program(scene, e)? {
                Some(program) => ClipEdit::apply(&program, &motion, &e.place, log),
                None => continue,
            },
        }
        .map_err(|x| edit_fault(scene, &e.at, x))?;
        changed |= edited.clip != motion.clip || !edited.times.is_identity();
        motion = motion.with(edited);
    }
    Ok(Clips { motion, changed })
}

/// The edit that a file holds.
///
/// # Errors
/// Files that hold none: at the edit.
fn open(stored: &StoredEdit, scene: &Scene, at: &str) -> Result<Box<dyn ClipEdit>, SceneError> {
    match stored {
        StoredEdit::ByExample { model, amount, contacts } => {
            let edit = formats::example_file::open(model).map_err(|x| {
                scene.source.error(&format!("{at}.model"), format!("{}: {x}", model.display()))
            })?;
            let whole = ByExample::new(Arc::new(edit));
            let contacts = contacts.unwrap_or(whole.contacts);
            Ok(Box::new(ByExample { amount: *amount, contacts, ..whole }))
        }
        StoredEdit::Style(spec) => {
            let style = crate::styles::of_spec(spec).map_err(|x| scene.source.error(at, x.to_string()))?;
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
