//! The take of a human motion put on the character of a scene.
//!
//! In: a checked scene whose motion is retargeted. Out: its [`Take`]: what the pipeline of `retarget` made of the performance, edited,
//! under the conditions of the scene.

use controllers::Dense;
use edits::{EditLog, Motion};
use formats::bvh::ImportOptions;
use motion::{Contact, ContactPlan, TimeMap};
use retarget::contacts::Phase;
use scenes::SceneError;
use scenes::scene::{RetargetSpec, Scene};

use super::{Performance, RetargetingError, Session};
use crate::clip_edits;
use crate::conditions::begin_in_time;
use crate::error::{MOST_STEPS, too_long};
use crate::limited::within_limits;
use crate::opening::Opening;
use crate::pins;
use crate::take::{Asked, Body, RetargetSource, Source, Take};
use crate::user_programs::reactions;
use crate::{Ask, Conditions};

/// The take of a retargeted motion. `opening` has the scene as its youngest file.
///
/// # Errors
/// Anything wrong with the performance, the key poses, the contact phases or the edits, at its place.
pub(crate) fn take(
    scene: &Scene,
    spec: &RetargetSpec,
    ask: &Ask,
    opening: &Opening,
) -> Result<Take, SceneError> {
    let fault = |e: RetargetingError| match e {
        RetargetingError::Scene(e) => e, // it has a place of its own
        e => scene.source.error("motion", e.to_string()),
    };
    let import = ImportOptions::default();
    let performance = Performance::opened_by(opening, &spec.of, None, &import).map_err(|e| match e {
        RetargetingError::Take(e) => scene.source.error("motion.of", e.to_string()),
        e => fault(e),
    })?;
    let session =
        Session::opened_by(opening, performance, &spec.to, spec.key_poses.as_deref()).map_err(fault)?;
    let mut options = spec.options.clone();
    options.rate_hz = scene.rate_hz.or(options.rate_hz);
    let physics = &scene.conditions.physics;
    let Some(down) = physics.gravity_down_m_s2() else {
        let message = "a motion is put on a body where gravity points down; allowed: (0, negative, 0)";
        return Err(scene.source.error("world.gravity_m_s2", message));
    };
    options.world.gravity_m_s2 = down;
    if let Some(ground) = physics.ground {
        if ground.friction <= 0.0 {
            let message = "a motion is put on a body whose feet are held by friction; allowed: more than 0";
            return Err(scene.source.error("world.ground.friction", message));
        }
        options.world.friction = ground.friction;
    }
    if let Some(path) = &spec.contacts {
        options.contact.phases = Some(session.contacts(path).map_err(fault)?);
    }
    let mapping = session.learn(&options).map_err(fault)?;
    let done = session.run(&mapping, &options).map_err(fault)?;
    let unedited = done.clip.clone();
    let contacts = plan(&done.phases);
    let mut log = EditLog::default();
    let (mut clip, mut contacts, mut times, mut clamped) = (done.clip, contacts, TimeMap::identity(), 0.0);
    let (mut limited, mut dense) = (Vec::new(), Dense::default());
    if !ask.no_edits {
        let motion = Motion { contacts: contacts.clone(), floor_m: Some(0.0), ..Motion::of(clip.clone()) };
        let edited = clip_edits::apply(scene, motion, &mut log, |_| Ok(None))?;
        dense = edited.tense();
        if edited.changed {
            contacts = edited.motion.contacts;
            times = edited.motion.times;
            (clip, clamped, limited) = within_limits(edited.motion.clip);
        }
    }
    if !ask.no_edits {
        let motion = Motion {
            contacts: contacts.clone(),
            floor_m: Some(0.0),
            unedited: Some(unedited.clone().into()),
            times: times.clone(),
            ..Motion::of(clip.clone())
        };
        if let Some(held) = pins::hold(&pins::edits(scene), &motion, 0.0, &|_| Ok(()), &mut log)? {
            clip = held;
        }
    }
    let mut take = Take {
        name: scene.name.clone(),
        body: Body {
            character: session.actor.puppet.character.clone(),
            colors: session.actor.file.colors.clone(),
        },
        source: Source::Retarget(Box::new(RetargetSource {
            performance: session.performance.name.clone(),
            phases: done.phases,
        })),
        conditions: Conditions::resolve(
            &scene.conditions,
            reactions(scene)?,
            &times,
            scene.conditions.physics.ground,
        ),
        asked: Asked {
            clip,
            tracks: None,
            dense,
            plants: Vec::new(),
            contacts,
            stance: None,
            times,
            clamped,
            ignored: Vec::new(),
            limited,
            shifted: None,
            contacts_given: spec.contacts.is_some(),
            stepping: Vec::new(),
        },
        unedited,
        log,
        strip: scene.strip,
        tune: scene.tune.clone(),
        files: scene.files.clone(),
    };
    let (length, steps_hz) = (take.asked.clip.duration_s(), take.control_rate_hz());
    if length * steps_hz.max(take.asked.clip.rate_hz) > MOST_STEPS {
        return Err(scene.source.error("motion", too_long(length, steps_hz)));
    }
    if let Some(file) = &ask.contacts {
        take.give_contacts(file)?;
    }
    begin_in_time(scene, [done_s(&take), length], "the motion is as long as its performance")?;
    Ok(take)
}

/// Length of the motion before it was edited, s.
fn done_s(take: &Take) -> f64 {
    take.unedited.duration_s()
}

/// Phases of contact points as a plan.
pub fn plan(phases: &[Phase]) -> ContactPlan {
    let contact = |p: &Phase| Contact {
        point: p.point.clone(),
        from_s: p.from_s,
        to_s: p.to_s,
        world_from_point: None,
    };
    // phases of one point are apart: found so, or checked when they were read
    ContactPlan::new(phases.iter().map(contact).collect()).unwrap_or_default()
}
