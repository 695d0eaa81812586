//! The take of a script: poses to tracks, tracks edited, sampled, feet planted.
//!
//! In: a checked scene whose motion is a script. Out: its [`Take`], or an error at the place of what makes no sense.
//!
//! ```text
//! script ─→ tracks ─→ track edits ─→ sampled ─→ clip edits ─→ limits, feet planted, balanced ─→ Take
//! ```

use crate::conditions::begin_in_time;
use controllers::Dense;
use dynamics::conditions::RootMode;
use dynamics::{Model, State};
use edits::{EditLog, Motion};
use motion::plant::{Plant, plant};
use motion::support::ground;
use motion::{Clip, Contact, ContactPlan, Floor, TimeMap, Tracks, Transform, Vec3};
use nalgebra::{Point3, Translation3};
use scenes::SceneError;
use scenes::scene::{EditKind, Scene, ScriptSpec};

use crate::clip_edits::{self, Clips};
use crate::error::{MOST_STEPS, too_long};
use crate::take::{Asked, Body, Source, Take, USUAL_RATE_HZ};
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
    for e in &scene.edits {
        let EditKind::Track(edit) = &e.kind else { continue };
        let fault = |field: &str, text: String| scene.source.error(&format!("{}{field}", e.at), text);
        for selector in e.place.selectors().map_err(|x| fault(".on", x.to_string()))? {
            let selection = selector.select(&tracks).map_err(|x| fault(".on", x.to_string()))?;
            if selection.is_empty() && !selection.is_whole_script() {
                return Err(fault(".on", "nothing is selected: the place has none of these parts".into()));
            }
            edit.apply(&mut tracks, &selection, &mut log).map_err(|x| fault("", x.to_string()))?;
        }
    }
    Ok((plain, tracks, log))
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
        Plant { world_from_end: onto * here.world_from_end, ..here }
    };
    let plants: Vec<Plant> = script.planted.iter().map(planted).collect();
    let sampler = Sampler { scene, script, plants: &plants, onto };
    let contacts = contacts(script, &plants, end);
    let (unedited, _) = sampler.finish(plain.sample(rate_hz), &TimeMap::identity())?;
    let (asked, tracks) = if ask.no_edits {
        log = EditLog::default();
        let motion = Motion { contacts, ..Motion::of(plain.sample(rate_hz)) };
        (Clips { motion, changed: false }, plain)
    } else {
        let motion = Motion {
            contacts,
            floor_m: ground.map(|g| g.height_m),
            tracks: Some(tracks.clone().into()),
            ..Motion::of(tracks.sample(rate_hz))
        };
        (clip_edits::apply(scene, motion, &mut log)?, tracks)
    };
    let times = asked.motion.times.clone();
    let length = if asked.changed { asked.motion.clip.duration_s() } else { end };
    begin_in_time(scene, [end, length], "settle_s makes the still time after the last element longer")?;
    let (clip, clamped) = sampler.finish(asked.motion.clip, &times)?;
    let dense = if asked.changed { clip_edits::dense(&tracks, &log, &times) } else { Dense::default() };
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
            contacts: asked.motion.contacts,
            stance: None,
            clamped,
            times: times.clone(),
        },
        unedited,
        log,
        conditions: Conditions::resolve(&scene.conditions, &times, ground),
        strip: scene.strip,
        tune: scene.tune.clone(),
        files: scene.files.clone(),
    })
}

/// From level ground to tilted ground: a turn about the point of the ground under the world's origin.
pub(crate) fn onto(ground: &Floor) -> Transform {
    ground.place() * Translation3::from(ground.pivot()).inverse()
}

/// What stands when in a script: the planted limbs, but while they step or jump.
fn contacts(script: &ScriptSpec, plants: &[Plant], end_s: f64) -> ContactPlan {
    let work = &script.footwork;
    let mut all = Vec::new();
    for (i, plant) in plants.iter().enumerate() {
        let steps = work.steps.iter().filter(|s| s.plant == i).map(|s| (s.start_s, s.start_s + s.duration_s));
        let jumps = work.jumps.iter().map(|j| (j.start_s, j.start_s + j.duration_s));
        let mut flights: Vec<(f64, f64)> = steps.chain(jumps).filter(|f| f.0 < end_s).collect();
        flights.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut from_s = 0.0;
        let mut stand = |from_s: f64, to_s: f64| {
            if from_s <= to_s {
                let place = work.at(0.5 * (from_s + to_s), plants).0[i].world_from_end;
                let point = plant.limb.name.clone();
                all.push(Contact { point, from_s, to_s, world_from_point: Some(place) });
            }
        };
        for (leaves_s, lands_s) in flights {
            stand(from_s, leaves_s);
            from_s = lands_s.max(from_s);
        }
        stand(from_s, end_s);
    }
    // times come from a checked scene, sorted and apart
    ContactPlan::new(all).unwrap_or_default()
}

struct Sampler<'a> {
    scene: &'a Scene,
    script: &'a ScriptSpec,
    plants: &'a [Plant],
    /// From level ground to the scene's.
    onto: Transform,
}

impl Sampler<'_> {
    /// Keeps joint limits, plants the feet, and moves the pelvis so that the centre of mass stays where it is at rest (plus
    /// what the script moves the root). `times`: from the script's time to the clip's.
    fn finish(&self, mut clip: Clip, times: &TimeMap) -> Result<(Clip, f64), SceneError> {
        let character = &self.scene.character;
        let skeleton = &character.skeleton;
        let physics = &self.scene.conditions.physics;
        let model = Model::new(character, physics.gravity);
        let mut state = State::new(&model);
        state.update(&model, &character.rest, &vec![0.0; model.nv()]);
        let floor = physics.ground.map_or(0.0, |g| g.height_m);
        let com = ground(&state.com(&model));
        let stance = ground(&(self.onto * Point3::new(com.x, floor, com.y)).coords);
        let home = skeleton.position(&character.rest, 0);
        let ik = |e: motion::ik::IkError| self.scene.source.error("planted", e.to_string());
        let script_s = (!times.is_identity()).then(|| times.inverse());
        let mut clamped = 0;
        for f in 0..clip.frames() {
            let t_s = f as f64 / clip.rate_hz;
            let q = clip.pose_mut(f);
            clamped += usize::from(skeleton.clamp_to_limits(q));
            if self.plants.is_empty() {
                continue;
            }
            if physics.root == RootMode::Pinned {
                let t_s = script_s.as_ref().map_or(t_s, |map| map.at(t_s));
                let (plants, height) = self.script.footwork.at(t_s, self.plants);
                if height > 0.0 {
                    let root = skeleton.position(q, 0) + Vec3::y() * height;
                    skeleton.set_position(q, 0, &root);
                }
                plant(skeleton, q, &plants).map_err(ik)?;
            } else {
                let moved = ground(&(skeleton.position(q, 0) - home));
                controllers::posture::settle(&model, &mut state, q, self.plants, stance + moved)
                    .map_err(ik)?;
            }
        }
        let share = clamped as f64 / clip.frames() as f64;
        Ok((clip, share))
    }
}
