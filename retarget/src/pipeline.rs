//! The pipeline: mapping, global transform, contacts, refinement, one page from top to bottom.

use motion::Clip;

use crate::contacts::{adjust, phases};
use crate::global_transform::global_transform;
use crate::mapping::{Mapping, map_clip};
use crate::options::Stage;
use crate::refine::refine;
use crate::{KeyPoses, Options, Performer, Puppet, RetargetError, Retargeted, prepare};

/// Learns a mapping from key poses and puts a human motion on a puppet with it.
///
/// * `clip`: of the performer's skeleton, of which some joints may be welded
///
/// # Errors
/// See [`RetargetError`].
pub fn run(
    clip: &Clip,
    performer: &Performer,
    puppet: &Puppet,
    key_poses: &KeyPoses,
    options: &Options,
) -> Result<Retargeted, RetargetError> {
    let mapping = Mapping::learn(puppet, key_poses, options.model, &options.gplvm)?;
    run_with(&mapping, clip, performer, puppet, options)
}

/// As [`run`], with a mapping learned before; of the options, `model` and `latent` are its own.
///
/// # Errors
/// See [`RetargetError`].
pub fn run_with(
    mapping: &Mapping,
    clip: &Clip,
    performer: &Performer,
    puppet: &Puppet,
    options: &Options,
) -> Result<Retargeted, RetargetError> {
    let human = prepare(clip, performer, options.rate_hz, options.smoothing, options.ground_m)?;
    let (mapped, report) = map_clip(mapping, performer, &human, puppet)?;
    let mut out = Retargeted {
        clip: mapped.clone(),
        stages: vec![(Stage::Map, mapped)],
        human,
        mapping: report,
        momentum: None,
        phases: Vec::new(),
        contact: None,
        refinement: None,
    };
    if options.stop_after == Stage::Map {
        return Ok(out);
    }
    let (moved, momentum) = global_transform(performer, &out.human, puppet, &out.clip, &options.global);
    out.reached(Stage::Global, moved);
    out.momentum = Some(momentum);
    if options.stop_after == Stage::Global {
        return Ok(out);
    }
    out.phases = phases::find(performer, &out.human, puppet, &options.contact)?;
    let (held, contact) = adjust(puppet, &out.clip, &out.phases)?;
    out.reached(Stage::Contact, held);
    out.contact = Some(contact);
    if options.stop_after == Stage::Contact {
        return Ok(out);
    }
    let mut options = options.refine.clone();
    options.accepted.extend(mapping.poses.iter().cloned());
    let (refined, refinement) = refine(puppet, &out.clip, &out.phases, &out.mapping.variance, &options)?;
    out.reached(Stage::Refine, refined);
    out.refinement = Some(refinement);
    Ok(out)
}

impl Retargeted {
    fn reached(&mut self, stage: Stage, clip: Clip) {
        self.stages.push((stage, clip.clone()));
        self.clip = clip;
    }
}
