//! The pipeline: mapping, global transform, contacts, swaying parts, refinement, one page from top to bottom.
//!
//! *Rate.* What is asked for at 30, 60 or 120 Hz is done at 120 Hz, and every fourth, second or each frame is given
//! ([`LEAST_RATE_HZ`]): whether a foot stands for a tenth of a second, or where a step is jerked too much, is decided once.
//!
//! *Bounds.* Every stage from the global transform on is held to bounds ([`mod@crate::guard`]), and flights stay flights
//! ([`flights`]).

use motion::{Clip, Smoothing, Vec3, smooth};

use crate::bounds::{Bounds, Step};
use crate::contacts::{keep, phases};
use crate::flights::{self, Flight};
use crate::global_transform::GlobalPath;
use crate::guard::{Guard, length};
use crate::mapping::{Mapping, map_clip};
use crate::options::{FlightSpan, PipelineStage};
use crate::phase::PhaseFrames;
use crate::prepare::FEWEST_FRAMES;
use crate::refine::{apart, refine_with};
use crate::result::FlightReport;
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
    let rate_hz = options.rate_hz.unwrap_or(clip.rate_hz);
    let times = times(rate_hz);
    let human = prepare(clip, performer, Some(rate_hz * times as f64), options.smoothing, options.ground_m)?;
    let frames = human.frames().div_ceil(times);
    if frames < FEWEST_FRAMES {
        return Err(RetargetError::TooShort { frames, rate_hz, least: FEWEST_FRAMES });
    }
    let mut options = options.clone();
    // a phase to the last frame that is given lasts to the end
    let last_s = (frames as f64 - 1.5) / rate_hz;
    let given = options.contact.phases.iter_mut().flatten().filter(|p| p.to_s > last_s);
    given.for_each(|p| p.to_s = p.to_s.max(human.duration_s()));
    Ok(thinned(at_own_rate(mapping, human, performer, puppet, &options)?, times, rate_hz))
}

/// Least frame rate at which the work is done, Hz.
pub const LEAST_RATE_HZ: f64 = 100.0;

/// How many frames are worked on for each that is given: the fewest with which the rate is [`LEAST_RATE_HZ`] at least. 30, 60 and
/// 120 Hz all work at 120 Hz.
fn times(rate_hz: f64) -> usize {
    if rate_hz > 0.0 { ((LEAST_RATE_HZ / rate_hz).ceil() as usize).clamp(1, 1000) } else { 1 }
}

/// All stages, at the rate of the prepared human clip.
fn at_own_rate(
    mapping: &Mapping,
    human: Clip,
    performer: &Performer,
    puppet: &Puppet,
    options: &Options,
) -> Result<Retargeted, RetargetError> {
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
        steps: Vec::new(),
        gave_way: Vec::new(),
        flights: Vec::new(),
    };
    let gravity = options.world.gravity_m_s2;
    let flights = flights::find(performer, &out.human, puppet, &options.contact, gravity);
    out.saw(puppet, &flights);
    if options.stop_after == PipelineStage::Map {
        return Ok(out);
    }
    let mut refining = options.refine.clone();
    refining.accepted.extend(mapping.poses.iter().cloned());
    let guard = Guard::new(puppet, &refining.accepted, gravity);
    let path = GlobalPath::new(performer, &out.human, puppet, &out.clip, &options.global);
    let by_human = path.clip(|_| 0.0);
    let before = guard.before(&by_human);
    let held = guard.hold(Step::Global, (&by_human, &before), path.clip(|_| 1.0), &Bounds::GLOBAL);
    // where a share of the heading is held back, the path of the centre of mass stays
    let mut moved = path.clip(|i| held.share[i]);
    let momentum = path.report(&moved);
    flights::lift(puppet, &mut moved, &flights);
    out.reached(PipelineStage::Global, moved, puppet, &flights);
    out.momentum = Some(momentum);
    out.steps.push(held.report);
    if options.stop_after == PipelineStage::Global {
        return Ok(out);
    }
    let found = phases::find(performer, &out.human, puppet, &options.contact)?;
    let found = match options.contact.phases {
        Some(_) => found,
        None => phases::without_flipped_feet(puppet, &out.clip, &found)?,
    };
    let was = flights::heights(puppet, &out.clip, &flights);
    let before = guard.before(&out.clip);
    let finish = |clip: &mut Clip, spans: &[Vec<PhaseFrames>]| {
        flights::keep(puppet, clip, &flights, &was, spans);
        Ok(())
    };
    let kept = keep(puppet, (&out.clip, &before), &found, &options.contact, &guard, &finish)?;
    out.reached(PipelineStage::Contact, kept.clip, puppet, &flights);
    (out.phases, out.gave_way, out.contact) = (kept.phases, kept.gave_way, Some(kept.report));
    out.steps.push(kept.step);
    if options.stop_after == PipelineStage::Contact {
        return Ok(out);
    }
    let variance = &out.mapping.variance;
    let mut followed = out.clip.clone();
    let sways = options.sway && !puppet.sways.is_empty();
    if sways {
        let (swung, report) = sway(puppet, &followed, gravity);
        followed = swung;
        out.sway = Some(report);
    }
    followed = apart(puppet, &followed, &out.phases, variance, &options.world, &refining)?;
    let before = guard.before(&out.clip);
    let depth_m = before.deepest_m();
    if followed != out.clip {
        let held = guard.hold(Step::Sway, (&out.clip, &before), followed, &Bounds::SWAY);
        if let Some(report) = &mut out.sway {
            report.most_rad = farthest_swing(puppet, &out.clip, &held.clip);
        }
        out.clip = held.clip;
        out.steps.push(held.report);
    }
    let was = flights::heights(puppet, &out.clip, &flights);
    for (flight, height_m) in flights.iter().zip(&was) {
        let at = |frame: usize| frame as f64 / out.clip.rate_hz;
        let (from_s, to_s) = (at(flight.frames.first), at(flight.frames.last));
        refining.flights.push(FlightSpan { from_s, to_s, height_m: *height_m });
    }
    let spans = phases::frames_of_phases(puppet, &out.phases, &out.clip)?;
    let before = guard.before(&out.clip);
    let said = std::cell::RefCell::new(None);
    let finish = |clip: &mut Clip| {
        flights::keep(puppet, clip, &flights, &was, &spans);
        let held = guard.hold(Step::Refine, (&out.clip, &before), clip.clone(), &Bounds::REFINE);
        *clip = held.clip;
        said.replace(Some(held.report));
    };
    let (refined, mut refinement) =
        refine_with(puppet, &out.clip, &out.phases, variance, &options.world, &refining, &finish)?;
    out.steps.extend(said.into_inner());
    refinement.collision_m[0] = depth_m;
    out.reached(PipelineStage::Refine, refined, puppet, &flights);
    out.refinement = Some(refinement);
    Ok(out)
}

/// Farthest turn of a joint that follows by dynamics, rad.
fn farthest_swing(puppet: &Puppet, before: &Clip, after: &Clip) -> f64 {
    let s = &after.skeleton;
    let (mut way, mut most) = (vec![0.0; s.nv()], 0.0f64);
    for i in 0..after.frames() {
        s.difference(before.pose(i), after.pose(i), 1.0, &mut way);
        for &l in puppet.sways.iter().flat_map(|w| &w.links) {
            let of_joint = &way[s.v_at(l)..s.v_at(l) + s.links()[l].joint.nv()];
            most = most.max(length(of_joint));
        }
    }
    most
}

/// Every so manieth frame of everything.
fn thinned(mut out: Retargeted, times: usize, rate_hz: f64) -> Retargeted {
    if times == 1 {
        return out;
    }
    fn every<T: Clone>(x: &mut Vec<T>, times: usize) {
        *x = x.iter().step_by(times).cloned().collect();
    }
    let clip = |clip: &Clip| {
        let data = (0..clip.frames()).step_by(times).flat_map(|i| clip.pose(i).to_vec()).collect();
        Clip::new(clip.skeleton.clone(), rate_hz, data)
    };
    let frames = |x: &mut Vec<usize>| {
        x.iter_mut().for_each(|i| *i /= times);
        x.dedup();
    };
    (out.clip, out.human) = (clip(&out.clip), clip(&out.human));
    out.stages.iter_mut().for_each(|(_, stage)| *stage = clip(stage));
    let end_s = out.clip.duration_s();
    for phases in [&mut out.phases, &mut out.gave_way] {
        phases.retain(|p| p.from_s <= end_s);
        phases.iter_mut().for_each(|p| p.to_s = p.to_s.min(end_s));
    }
    let m = &mut out.mapping;
    every(&mut m.variance, times);
    every(&mut m.confidence, times);
    every(&mut m.extrapolates, times);
    every(&mut m.latent, times);
    every(&mut m.fit_rms_m, times);
    frames(&mut m.jumps);
    if let Some(m) = &mut out.momentum {
        // between frames, linear momentum is the mean of that between those in between
        for x in [&mut m.human, &mut m.character] {
            *x = x.chunks_exact(times).map(|c| c.iter().sum::<Vec3>() / c.len() as f64).collect();
        }
        for x in [&mut m.human_spin, &mut m.character_spin] {
            *x = x.chunks_exact(times).map(|c| c.iter().sum::<f64>() / c.len() as f64).collect();
        }
    }
    if let Some(r) = &mut out.refinement {
        for x in [&mut r.required_before, &mut r.contact_before, &mut r.required_after, &mut r.contact_after]
        {
            every(x, times);
        }
        for cone in [&mut r.cone_before, &mut r.cone_after] {
            cone.retain(|i| i % times == 0);
            frames(cone);
        }
        // summed over frames: over those that are left
        for x in r.before.iter_mut().chain(&mut r.after) {
            *x /= times as f64;
        }
    }
    out
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
    fn reached(&mut self, stage: PipelineStage, clip: Clip, puppet: &Puppet, flights: &[Flight]) {
        self.stages.push((stage, clip.clone()));
        self.clip = clip;
        self.saw(puppet, flights);
    }

    /// Takes down the heights of the flights after the last stage.
    fn saw(&mut self, puppet: &Puppet, flights: &[Flight]) {
        let at = |frame: usize| frame as f64 / self.clip.rate_hz;
        let report = |f: &Flight| FlightReport {
            from_s: at(f.frames.first),
            to_s: at(f.frames.last),
            scaled_m: f.scaled_m,
            heights_m: Vec::new(),
        };
        if self.flights.is_empty() {
            self.flights = flights.iter().map(report).collect();
        }
        let stage = self.stages.last().map_or(PipelineStage::Map, |s| s.0);
        let heights = flights::heights(puppet, &self.clip, flights);
        self.flights.iter_mut().zip(heights).for_each(|(f, h)| f.heights_m.push((stage, h)));
    }
}
