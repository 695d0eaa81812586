//! The pipeline: mapping, global transform, contacts, swaying parts, refinement, one page from top to bottom.

use motion::{Clip, Smoothing, smooth};

use crate::contacts::{adjust, adjust_in_time, phases};
use crate::global_transform::global_transform;
use crate::mapping::{Mapping, map_clip};
use crate::options::PipelineStage;
use crate::refine::refine;
use crate::{KeyPoses, Options, Performer, Puppet, RetargetError, Retargeted, prepare, sway};

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

/// As [`run`], with a mapping learned before; the options `model` and `gplvm` do not count, they are the mapping's own.
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
    options.world.check()?;
    let human = prepare(clip, performer, options.rate_hz, options.smoothing, options.ground_m)?;
    let (mapped, report) = map_clip(mapping, performer, &human, puppet)?;
    let mapped = smoothed(mapped, options.mapped);
    let mut out = Retargeted {
        clip: mapped.clone(),
        stages: vec![(PipelineStage::Map, mapped)],
        human,
        mapping: report,
        momentum: None,
        phases: Vec::new(),
        contact: None,
        sway: None,
        refinement: None,
    };
    if options.stop_after == PipelineStage::Map {
        return Ok(out);
    }
    let (moved, momentum) = global_transform(performer, &out.human, puppet, &out.clip, &options.global);
    out.reached(PipelineStage::Global, moved);
    out.momentum = Some(momentum);
    if options.stop_after == PipelineStage::Global {
        return Ok(out);
    }
    out.phases = phases::find(performer, &out.human, puppet, &options.contact)?;
    let (held, contact) = if options.contact.phases.is_some() {
        adjust(puppet, &out.clip, &out.phases)?
    } else {
        let landed = phases::without_flipped_feet(puppet, &out.clip, &out.phases)?;
        let (phases, held, contact) = adjust_in_time(puppet, &out.clip, &landed, &options.contact)?;
        out.phases = phases;
        (held, contact)
    };
    out.reached(PipelineStage::Contact, held);
    out.contact = Some(contact);
    if options.stop_after == PipelineStage::Contact {
        return Ok(out);
    }
    if options.sway && !puppet.sways.is_empty() {
        let (swung, report) = sway(puppet, &out.clip, options.world.gravity_m_s2);
        out.clip = swung;
        out.sway = Some(report);
    }
    let mut refining = options.refine.clone();
    refining.accepted.extend(mapping.poses.iter().cloned());
    let variance = &out.mapping.variance;
    let (refined, refinement) = refine(puppet, &out.clip, &out.phases, variance, &options.world, &refining)?;
    out.reached(PipelineStage::Refine, refined);
    out.refinement = Some(refinement);
    Ok(out)
}

/// A mapped motion as a body moves, within its limits ([`Options::mapped`]).
pub fn smoothed(clip: Clip, smoothing: Smoothing) -> Clip {
    if smoothing == Smoothing::Off {
        return clip;
    }
    let mut out = smooth(&clip, smoothing).clip;
    let skeleton = out.skeleton.clone();
    for i in 0..out.frames() {
        skeleton.clamp_to_limits(out.pose_mut(i));
    }
    out
}

impl Retargeted {
    fn reached(&mut self, stage: PipelineStage, clip: Clip) {
        self.stages.push((stage, clip.clone()));
        self.clip = clip;
    }
}
