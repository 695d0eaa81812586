//! The take of a script: poses to tracks, tracks edited, sampled, feet planted.
//!
//! In: a checked scene whose motion is a script. Out: its [`Take`], or an error at the place of what makes no sense.
//!
//! ```text
//! script ─→ tracks ─→ track edits ─→ sampled ─→ clip edits ─→ limits, feet planted, balanced ⇄ pins ─→ Take
//! ```

use std::cell::RefCell;

use crate::conditions::begin_in_time;
use controllers::{Dense, DenseJoint};
use dynamics::conditions::RootMode;
use edits::{EditLog, Motion, TrackEdit, Where};
use motion::plant::{Knee, Plant};
use motion::{Clip, Dof, Element, Floor, Joint, LimbKind, TimeMap, Timing, Tracks, Transform};
use nalgebra::Translation3;
use scenes::SceneError;
use scenes::scene::{EditKind, Scene, SceneEdit, ScriptSpec};

use crate::clip_edits::{self, Clips};
use crate::error::{MOST_STEPS, too_long};
use crate::ignored::ignored;
use crate::pins;
use crate::possible::{Finished, Sampler};
use crate::steps::{Steps, contacts};
use crate::take::{Asked, Body, Source, Take, USUAL_RATE_HZ};
use crate::user_programs::{edit_fault, reactions, track_program, tracks_first};
use crate::{Ask, Conditions};

/// Frames per second of a script that says nothing about it, Hz.
pub(crate) const USUAL_FRAMES_HZ: f64 = 120.0;

/// The tracks of a script, without and with the edits of its scene, and what the edits did.
///
/// # Errors
/// Scripts and edits that make no sense, at their place in the file.
pub fn edited_tracks(scene: &Scene, script: &ScriptSpec) -> Result<(Tracks, Tracks, EditLog), SceneError> {
    let whole = |e: &dyn std::error::Error| scene.source.error("script", e.to_string());
    let skeleton = &scene.character.skeleton;
    let plain = script.script.build(skeleton, &scene.character.rest).map_err(|e| whole(&e))?;
    let mut tracks = plain.clone();
    let mut log = EditLog::default();
    // the last clip edit before, and the last of them that only its program says to be one
    let (mut after, mut after_program) = (None, None);
    for e in &scene.edits {
        let program;
        let edit: &dyn TrackEdit = match &e.kind {
            EditKind::Track(edit) => edit.as_ref(),
            EditKind::Program(_) => match track_program(&scene.source, e, after)? {
                Some(found) => {
                    program = found;
                    &program
                }
                None => {
                    (after, after_program) = (Some(e.kind.name()), Some(e.kind.name()));
                    continue;
                }
            },
            EditKind::Clip(_) | EditKind::Stored(_) => {
                after = Some(e.kind.name());
                continue;
            }
            EditKind::Tension(_) | EditKind::Pin(_) => continue,
        };
        if let EditKind::Track(_) = &e.kind {
            tracks_first(&scene.source, e, after_program)?;
        }
        let fault = |field: &str, text: String| scene.source.error(&format!("{}{field}", e.at), text);
        let selectors = e.place.selectors().map_err(|x| fault(".on", x.to_string()))?;
        for (i, selector) in selectors.into_iter().enumerate() {
            let selection = selector.select(&tracks).map_err(|x| fault(".on", x.to_string()))?;
            if selection.is_empty() && !selection.is_whole_script() {
                return Err(fault(".on", nothing_selected(&tracks, e, i)));
            }
            edit.apply(&mut tracks, &selection, &mut log).map_err(|x| edit_fault(&scene.source, &e.at, x))?;
        }
    }
    Ok((plain, tracks, log))
}

/// What is said of the `i`-th label of an edit that has none of the edit's parts.
fn nothing_selected(tracks: &Tracks, edit: &SceneEdit, i: usize) -> String {
    let quoted = |names: &[String]| names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
    let (place, whole) = match edit.place.on.get(i).filter(|text| !text.is_empty()) {
        Some(text) => (format!("`{text}`"), Where { on: vec![text.clone()], ..edit.place.clone() }),
        None => ("the script".into(), edit.place.clone()),
    };
    let all = Where { parts: Vec::new(), ..whole }.selectors().ok();
    let selection = all.and_then(|all| all.first()?.select(tracks).ok());
    let elements =
        tracks.elements().filter(|(_, e)| selection.as_ref().is_some_and(|s| s.contains(&e.label)));
    let mut moves: Vec<String> = elements.map(|(dof, _)| dof.name(&tracks.skeleton)).collect();
    moves.sort();
    moves.dedup();
    let moves = if moves.is_empty() { "nothing".into() } else { quoted(&moves) };
    format!("nothing is selected: {place} has no element of {}; it moves {moves}", quoted(&edit.place.parts))
}

/// The take of a script.
///
/// # Errors
/// As [`edited_tracks`]; what begins after the motion has ended; a motion too long; legs that cannot be solved.
pub(crate) fn take(scene: &Scene, script: &ScriptSpec, ask: &Ask) -> Result<Take, SceneError> {
    let (mut plain, mut tracks, mut log) = edited_tracks(scene, script)?;
    let end = tracks.duration_s.max(plain.duration_s) + script.settle_s;
    let rate_hz = scene.rate_hz.unwrap_or(USUAL_FRAMES_HZ);
    let steps_hz = rate_hz.max(scene.conditions.physics.rate_hz.unwrap_or(USUAL_RATE_HZ));
    if end * steps_hz > MOST_STEPS {
        return Err(scene.source.error("script", too_long(end, steps_hz)));
    }
    tracks.duration_s = end;
    plain.duration_s = end;
    let character = scene.character.clone();
    let skeleton = &character.skeleton;
    let ground = scene.conditions.physics.ground;
    let onto = ground.as_ref().map_or(Transform::identity(), onto);
    let planted = |&l: &usize| {
        let here = Plant::here(skeleton, &character.rest, &skeleton.limbs()[l]);
        let legs = here.limb.kind == LimbKind::Leg;
        let knee = if legs { Knee::Follows } else { Knee::Kept };
        Plant { world_from_end: onto * here.world_from_end, knee, ..here }
    };
    let plants: Vec<Plant> = script.planted.iter().map(planted).collect();
    let steps = |tracks: &Tracks| Steps::of(scene, script, tracks, &plants, rate_hz);
    let plain_steps = steps(&plain);
    let sampler = Sampler { scene, script, plants: &plants, onto, steps: plain_steps.as_ref() };
    let unedited = sampler.finish(plain.sample(rate_hz), &plain, &TimeMap::identity())?.clip;
    let steps = if ask.no_edits { plain_steps } else { steps(&tracks) };
    let free = scene.conditions.physics.root == RootMode::Free;
    if free && steps.is_none() && !script.footwork.is_still() {
        let e = "footwork of a free root needs legs that are planted on level ground that does not tilt";
        return Err(scene.source.error("footwork", e));
    }
    let sampler = Sampler { scene, script, plants: &plants, onto, steps: steps.as_ref() };
    let contacts = match &steps {
        Some(steps) => steps.contacts(end),
        None => contacts(&script.footwork, &plants, &[], end),
    };
    let (asked, tracks) = if ask.no_edits {
        log = EditLog::default();
        let motion = Motion { contacts, ..Motion::of(plain.sample(rate_hz)) };
        (Clips { motion, changed: false, tension: Vec::new() }, plain)
    } else {
        let motion = Motion {
            contacts,
            floor_m: ground.map(|g| g.height_m),
            tracks: Some(tracks.clone().into()),
            ..Motion::of(tracks.sample(rate_hz))
        };
        let seen = |motion: &Motion| {
            let planted = !plants.is_empty();
            let finish = || sampler.finish(motion.clip.clone(), &tracks, &motion.times);
            Ok(planted.then(finish).transpose()?.map(|f| f.clip))
        };
        (clip_edits::apply(scene, motion, &mut log, seen)?, tracks)
    };
    let times = asked.motion.times.clone();
    let length = if asked.changed { asked.motion.clip.duration_s() } else { end };
    begin_in_time(scene, [end, length], "settle_s makes the still time after the last element longer")?;
    let Clips { motion, mut changed, .. } = asked;
    let contacts = motion.contacts.clone();
    let mut finished = sampler.finish(motion.clip.clone(), &tracks, &times)?;
    if !ask.no_edits {
        let sampled = &motion.clip;
        let last = RefCell::new(None);
        let again = |clip: &mut Clip| {
            let done = sampler.again(clip.clone(), sampled, &tracks, &times)?;
            clip.clone_from(&done.clip);
            last.replace(Some(done));
            Ok(())
        };
        let possible =
            Motion { clip: finished.clip.clone(), unedited: Some(unedited.clone().into()), ..motion.clone() };
        if let Some(clip) = pins::hold(&pins::edits(scene), &possible, 0.0, &again, &mut log)? {
            changed |= clip != finished.clip;
            // what was limited was limited before the pins
            if let Some(Finished { lowered_m, shifted, .. }) = last.into_inner() {
                finished = Finished { lowered_m, shifted, ..finished };
            }
            finished.clip = clip;
        }
    }
    let Finished { clip, clamped, limited, lowered_m, shifted } = finished;
    let mut dense = if changed { clip_edits::dense(&tracks, &log, &times) } else { Dense::default() };
    follow_led(&mut dense, &tracks, &times);
    let unbalanced = scene.conditions.physics.root == RootMode::Pinned || steps.is_some();
    let limbs = steps.as_ref().map_or(&plants[..], Steps::plants);
    follow_plants(&mut dense, &tracks, limbs, unbalanced);
    let lowered = |from_s: f64, to_s: f64| {
        let frame = |t_s: f64| ((times.at(t_s) * rate_hz).round() as usize).min(lowered_m.len() - 1);
        lowered_m[frame(from_s)..=frame(to_s)].iter().copied().fold(0.0, f64::max)
    };
    let still: Vec<Plant> =
        plants.iter().filter(|p| steps.is_none() || p.limb.kind != LimbKind::Leg).cloned().collect();
    let ignored = ignored(&tracks, &still, lowered);
    // feet that step stand by their contacts alone
    let plants = if steps.is_some() { Vec::new() } else { plants };
    // transitions are left where some joint still follows its elements at their own times
    let transitions = times.is_identity();
    Ok(Take {
        name: scene.name.clone(),
        body: Body { character: character.clone(), colors: scene.colors.clone() },
        source: Source::Script,
        asked: Asked {
            clip,
            tracks: transitions.then_some(tracks),
            dense,
            plants,
            contacts,
            stance: None,
            clamped,
            ignored,
            limited,
            shifted,
            contacts_given: false,
            stepping: Vec::new(),
            times: times.clone(),
        },
        unedited,
        log,
        conditions: Conditions::resolve(&scene.conditions, reactions(scene)?, &times, ground),
        strip: scene.strip,
        tune: scene.tune.clone(),
        files: scene.files.clone(),
    })
}

/// From level ground to tilted ground: a turn about the point of the ground under the world's origin.
pub(crate) fn onto(ground: &Floor) -> Transform {
    ground.place() * Translation3::from(ground.pivot()).inverse()
}

/// Adds the joints that are led, while they are: from an element that is to the next that is not.
fn follow_led(dense: &mut Dense, tracks: &Tracks, times: &TimeMap) {
    for track in &tracks.tracks {
        let (Dof::Axis(link) | Dof::Rotation(link)) = track.dof else { continue };
        let led = |(i, e): (usize, &Element)| {
            let to_s = track.elements.get(i + 1).map_or(f64::INFINITY, |next| next.start_s);
            (e.timing == Timing::Led).then_some((e.start_s, to_s))
        };
        let spans: Vec<(f64, f64)> = track.elements.iter().enumerate().filter_map(led).collect();
        if !spans.is_empty() && tracks.skeleton.links()[link].joint != Joint::Free {
            let tension = clip_edits::tension(tracks, link, times);
            dense.add(DenseJoint { tenses: true, ..DenseJoint::during(link, tension, spans) });
        }
    }
}

/// Adds the joints of planted limbs that no balance drives: their muscles follow the IK, as they follow a clip.
///
/// The balance drives the legs of a body that stands on them (`unbalanced` false). Under a pinned root nothing does, nor of a body that
/// steps, nor planted arms of any.
fn follow_plants(dense: &mut Dense, tracks: &Tracks, plants: &[Plant], unbalanced: bool) {
    let links = tracks.skeleton.links();
    for limb in plants.iter().map(|p| &p.limb).filter(|l| unbalanced || l.kind == LimbKind::Arm) {
        for link in limb.links() {
            // what the elements of these joints say is ignored, their tension with it
            dense.joints.retain(|j| j.link != link);
            if links[link].joint != Joint::Fixed {
                let tension = vec![(0.0, tracks.base_tension[link])];
                dense.joints.push(DenseJoint { tenses: true, ..DenseJoint::throughout(link, tension) });
            }
        }
    }
}
