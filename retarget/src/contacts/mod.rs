//! Contacts: when points touch the ground, and the motion that keeps them there \[YAH10, §5.2\].
//!
//! In: the human clip, the character's clip in the world. Out: the phases in which each of the character's
//! contact points rests on the ground, and the character's clip with the points held there.
//!
//! | module | holds |
//! |---|---|
//! | [`phases`] | when human points touch, and the character's with them |
//! | `pace` | phases shortened where flights are too quick |
//! | [`mod@keep`] | contacts that cannot be kept give way |
//! | [`paths`] | where each point has to be in every frame: `planted`, link by link |
//! | [`ik`] | the pose that puts the points there |
//!
//! \[YAH10\] Yamane, Ariki, Hodgins. Animating Non-Humanoid Characters with Human Motion Data, SCA 2010.

pub mod ik;
pub mod keep;
mod pace;
pub mod paths;
pub mod phases;
mod places;
mod planted;

use motion::{Clip, Vec3, smoothstep};

use crate::global_transform::low_pass;
use crate::options::ContactOptions;
use crate::phase::{Path, PhaseFrames};
use crate::result::ContactReport;
use crate::{Puppet, RetargetError};
use ik::ContactIk;
use paths::held_paths;

pub use crate::phase::Phase;
pub use keep::{Kept, keep};
pub use places::point_paths;

/// Holds the contact points of `clip` in their phases; what else moves, moves as little as it can.
///
/// # Errors
/// A phase of an unknown point, reversed, outside the clip, or overlapping another of its point.
pub fn adjust(
    puppet: &Puppet,
    clip: &Clip,
    phases: &[Phase],
) -> Result<(Clip, ContactReport), RetargetError> {
    let spans = phases::frames_of_phases(puppet, phases, clip)?;
    let source = point_paths(puppet, clip);
    let goals = held_paths(puppet, &source, &spans, clip.rate_hz);
    Ok(held(puppet, clip, &source, &goals, &spans))
}

/// The clip whose points are at their goals in `spans`, and what came of it.
fn held(
    puppet: &Puppet,
    clip: &Clip,
    source: &[Path],
    goals: &[Path],
    spans: &[Vec<PhaseFrames>],
) -> (Clip, ContactReport) {
    let hold: Vec<Vec<f64>> = spans.iter().map(|s| firmness(s, clip)).collect();
    let out = follow(puppet, clip, goals, &hold, spans);
    let report = report(source, &point_paths(puppet, &out), spans, clip.rate_hz);
    (out, report)
}

/// As [`adjust`], with phases shortened where flights are too quick, by up to [`ContactOptions::phase_slack_s`] at either
/// end: the phases, the clip, its report.
///
/// # Errors
/// As [`adjust`].
pub fn adjust_in_time(
    puppet: &Puppet,
    clip: &Clip,
    phases: &[Phase],
    options: &ContactOptions,
) -> Result<(Vec<Phase>, Clip, ContactReport), RetargetError> {
    let spans = phases::frames_of_phases(puppet, phases, clip)?;
    let source = point_paths(puppet, clip);
    let (spans, goals) = pace::pace(puppet, &source, spans, clip.rate_hz, options);
    let (out, report) = held(puppet, clip, &source, &goals, &spans);
    Ok((phases::phases_of_frames(puppet, &spans, clip.rate_hz), out, report))
}

/// The clip whose points are at their goals.
///
/// In two passes: solved frame by frame, the root's path has jerks wherever a straight leg has to reach. The low-passed
/// path of the first pass is where the second starts from, with a root that moves only where legs cannot reach.
///
/// * `goals`, `hold`: of every point in every frame, its place and how firmly it is held there
fn follow(
    puppet: &Puppet,
    clip: &Clip,
    goals: &[Path],
    hold: &[Vec<f64>],
    spans: &[Vec<PhaseFrames>],
) -> Clip {
    let mut ik = ContactIk::new(puppet, spans);
    let mut out = clip.clone();
    let put = |ik: &mut ContactIk, from: &[f64], i: usize, q: &mut [f64]| {
        ik.solve(from, &|c| (goals[c][i], hold[c][i]), q);
    };
    for i in 0..clip.frames() {
        put(&mut ik, clip.pose(i), i, out.pose_mut(i));
    }
    // the root's way, smoothed, is where the second pass starts from and stays
    let (nv, frames) = (clip.skeleton.nv(), clip.frames());
    let mut ways = vec![vec![0.0; frames]; ROOT_DOFS];
    let mut way = vec![0.0; nv];
    for i in 0..frames {
        clip.skeleton.difference(clip.pose(i), out.pose(i), 1.0, &mut way);
        (0..ROOT_DOFS).for_each(|d| ways[d][i] = way[d]);
    }
    let ways: Vec<Vec<f64>> = ways.iter().map(|w| low_pass(w, ROOT_HZ, clip.rate_hz)).collect();
    ik.hold_root();
    let mut from = clip.pose(0).to_vec();
    for i in 0..frames {
        way.fill(0.0);
        (0..ROOT_DOFS).for_each(|d| way[d] = ways[d][i]);
        from.copy_from_slice(clip.pose(i));
        clip.skeleton.integrate(&mut from, &way, 1.0);
        put(&mut ik, &from, i, out.pose_mut(i));
    }
    out
}

/// How firmly a point is held in each frame: 1 in its phases, fading beside them.
fn firmness(spans: &[PhaseFrames], clip: &Clip) -> Vec<f64> {
    let away = |i: usize| spans.iter().map(|s| s.first.saturating_sub(i).max(i.saturating_sub(s.last))).min();
    let fade = FADE_S * clip.rate_hz;
    let of_frame = |i: usize| away(i).map_or(0.0, |frames| 1.0 - smoothstep(frames as f64 / fade));
    (0..clip.frames()).map(of_frame).collect()
}

/// Degrees of freedom of a free root.
const ROOT_DOFS: usize = 6;
/// The root follows its contacts below this frequency, Hz: above, the legs do.
const ROOT_HZ: f64 = 2.0;

/// Time beside a phase in which a point comes to count as it does in it, s.
const FADE_S: f64 = 0.2;
/// Frames on either side of a phase's end in which jerk is looked at, s.
const NEAR_S: f64 = 0.1;

/// What is left to see: slip and depth of the points, jerk near the phases' ends against the source.
pub fn report(source: &[Path], result: &[Path], spans: &[Vec<PhaseFrames>], rate_hz: f64) -> ContactReport {
    let mut out = ContactReport::default();
    for (after, spans) in result.iter().zip(spans) {
        out.penetration_m = after.iter().map(|p| -p.y).fold(out.penetration_m, f64::max);
        for s in spans {
            out.slip_m = out.slip_m.max(slip(&after[s.first..=s.last]));
        }
    }
    let (theirs, own) = (peak(source, spans, rate_hz), peak(result, spans, rate_hz));
    out.jerk_ratio = if theirs > 0.0 { own / theirs } else { 0.0 };
    out
}

/// Farthest horizontal distance from the mean, m.
fn slip(p: &[Vec3]) -> f64 {
    let mean = p.iter().sum::<Vec3>() / p.len() as f64;
    p.iter().map(|x| (x.x - mean.x).hypot(x.z - mean.z)).fold(0.0, f64::max)
}

/// Jerk of a corrected path over the motion's from which on it becomes softer, and phases give way: what is added by the pose
/// that reaches for it stays below the rest of the way to 1.2.
const ALLOWED: f64 = 1.1;

/// Largest third difference near the ends of phases, m.
fn peak(paths: &[Path], spans: &[Vec<PhaseFrames>], rate_hz: f64) -> f64 {
    let of_point = |(p, spans): (&Path, &Vec<PhaseFrames>)| {
        let ends = spans.iter().flat_map(|s| [s.first, s.last]);
        ends.map(|end| peak_near(p, end, rate_hz)).fold(0.0, f64::max)
    };
    paths.iter().zip(spans).map(of_point).fold(0.0, f64::max)
}

/// Largest third difference near a phase's end, m.
fn peak_near(p: &[Vec3], end: usize, rate_hz: f64) -> f64 {
    let near = (NEAR_S * rate_hz).ceil() as usize;
    let around = &p[end.saturating_sub(near)..=(end + near).min(p.len() - 1)];
    around.windows(4).map(|w| (w[3] - (w[2] - w[1]) * 3.0 - w[0]).norm()).fold(0.0, f64::max)
}
