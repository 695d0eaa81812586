//! Contacts that cannot be kept give way, and are named.
//!
//! In: a clip, the phases of its points and the paths that hold them there. Out: the clip with its points held as far as the
//! body can without popping, the phases that are left, and those that gave way.
//!
//! A place that is out of reach, or that a link would have to flip for, is reached by the least-squares pose half and half: the
//! body jumps to it and back. So the clip is held against the bounds of the stage ([`Bounds::CONTACT`]), and around every moment at
//! which it goes farther or faster, or links are deeper in one another, or a point in a phase is not where it rests, the link that is
//! farthest from its own path is let go: its goals become its own path, smoothly (`share`), and it is no longer held. What is still beyond then is held back as a whole
//! ([`Guard::hold`]).

use motion::Clip;

use super::paths::by_link;
use super::{firmness, follow, pace, phases, point_paths, report};
use crate::bounds::{Bounds, Step, StepReport};
use crate::guard::{Before, Guard, around, faded};
use crate::options::ContactOptions;
use crate::phase::{Path, Phase, PhaseFrames, rests, runs};
use crate::result::ContactReport;
use crate::{Puppet, RetargetError};

/// What is done with a clip after its contacts are placed, in the phases that are kept.
type Finish<'a> = &'a dyn Fn(&mut Clip, &[Vec<PhaseFrames>]) -> Result<(), RetargetError>;

/// Distance from its place, over the stature, from which on a point does not rest there.
const MISSED: f64 = 0.002;
/// Least correction for which a link can be the reason, over the stature.
const LEAST: f64 = 0.001;
/// Time around a moment in which links are looked at, s.
const AROUND_S: f64 = 0.15;
/// Time for which a link is let go at first, and over which it goes, s; both grow from round to round.
const GONE_S: f64 = 0.05;
const FADE_S: f64 = 0.3;
const WIDER: f64 = 1.5;
/// Rounds in which links are let go.
const ROUNDS: i32 = 6;
/// Fewest frames of what is left of a phase.
const FEWEST: usize = 3;

/// What contact adjustment gives.
#[derive(Clone, Debug)]
pub struct Kept {
    /// The clip.
    pub clip: Clip,
    /// Phases in which points rest.
    pub phases: Vec<Phase>,
    /// Parts of phases in which they do not, although the human's do.
    pub gave_way: Vec<Phase>,
    /// Slip, depth and jerk of what rests.
    pub report: ContactReport,
    /// How far the stage went.
    pub step: StepReport,
}

/// Holds the contact points of a clip in their phases as far as the body can. See the module header.
///
/// * `found`: shortened where flights are too quick unless they were given by hand ([`super::adjust_in_time`])
/// * `finish`: what is done to the clip before it is judged; it has the phases
///
/// # Errors
/// As [`super::adjust`]; what `finish` says.
pub fn keep(
    puppet: &Puppet,
    (clip, before): (&Clip, &Before),
    found: &[Phase],
    options: &ContactOptions,
    guard: &Guard,
    finish: Finish,
) -> Result<Kept, RetargetError> {
    let spans = phases::frames_of_phases(puppet, found, clip)?;
    let source = point_paths(puppet, clip);
    let (spans, goals) = match options.phases {
        Some(_) => {
            let goals = super::held_paths(puppet, &source, &spans, clip.rate_hz);
            (spans, goals)
        }
        None => pace::pace(puppet, &source, spans, clip.rate_hz, options),
    };
    let hold: Vec<Vec<f64>> = spans.iter().map(|s| firmness(s, clip)).collect();
    let links = by_link(puppet);
    let mut share = vec![vec![1.0; clip.frames()]; links.len()];
    let mut gone_at = vec![vec![false; clip.frames()]; links.len()];
    let mut round = 0;
    let out = loop {
        let (mut now, mut firm) = (goals.clone(), hold.clone());
        for (of_link, share) in links.iter().zip(&share) {
            for &c in of_link {
                for (i, s) in share.iter().enumerate().filter(|(_, s)| **s < 1.0) {
                    now[c][i] = source[c][i] + (goals[c][i] - source[c][i]) * *s;
                    firm[c][i] *= s;
                }
            }
        }
        let mut out = follow(puppet, clip, &now, &firm, &spans);
        finish(&mut out, &spans)?;
        let (_, mut wrong) = guard.exceeded(before, &out, &Bounds::CONTACT);
        let beyond = guard.beyond(clip, &out, &Bounds::CONTACT);
        wrong.iter_mut().zip(beyond).for_each(|(wrong, beyond)| *wrong |= beyond);
        let missed = missed(&point_paths(puppet, &out), &goals, &spans, guard.stature_m());
        for (l, of_link) in links.iter().enumerate() {
            let off = |i: usize| share[l][i] == 1.0 && of_link.iter().any(|&c| missed[c][i]);
            (0..wrong.len()).filter(|&i| off(i)).for_each(|i| wrong[i] = true);
        }
        if round == ROUNDS || !wrong.contains(&true) {
            break out;
        }
        let of_rate = WIDER.powi(round) * clip.rate_hz;
        let reach = [GONE_S * of_rate, FADE_S * of_rate];
        let least = LEAST * guard.stature_m();
        if !let_go((&source, &goals), &links, (&wrong, &share), &mut gone_at, (least, clip.rate_hz)) {
            break out;
        }
        share = gone_at.iter().map(|gone| faded(gone, reach)).collect();
        round += 1;
    };
    let held = guard.hold(Step::Contact, (clip, before), out, &Bounds::CONTACT);
    let points = point_paths(puppet, &held.clip);
    let missed = missed(&points, &goals, &spans, guard.stature_m());
    let (mut kept, mut gone) = (vec![Vec::new(); spans.len()], vec![Vec::new(); spans.len()]);
    for (l, of_link) in links.iter().enumerate() {
        for &c in of_link {
            let there = |i: usize| share[l][i] == 1.0 && held.share[i] == 1.0 && !missed[c][i];
            for s in &spans[c] {
                let mut part = runs(s.first..s.last + 1, there);
                part.retain(|p| p.last - p.first + 1 >= FEWEST || (p.first, p.last) == (s.first, s.last));
                gone[c].extend(runs(s.first..s.last + 1, |i| !rests(&part, i)));
                kept[c].extend(part);
            }
        }
    }
    // jerk is that of steps: where a contact gives way speed and acceleration are within their bounds
    let near = (super::NEAR_S * clip.rate_hz).ceil() as usize;
    let mut steps = vec![Vec::new(); spans.len()];
    for (of_link, share) in links.iter().zip(&share) {
        let whole = |end: usize| {
            share[end.saturating_sub(near)..=(end + near).min(share.len() - 1)].iter().all(|s| *s == 1.0)
        };
        for &c in of_link {
            let ends = spans[c].iter().flat_map(|s| [s.first, s.last]);
            steps[c] = ends.filter(|&e| whole(e)).map(|e| PhaseFrames { first: e, last: e }).collect();
        }
    }
    let jerk_ratio = report(&source, &points, &steps, clip.rate_hz).jerk_ratio;
    Ok(Kept {
        report: ContactReport { jerk_ratio, ..report(&source, &points, &kept, clip.rate_hz) },
        phases: phases::phases_of_frames(puppet, &kept, clip.rate_hz),
        gave_way: phases::phases_of_frames(puppet, &gone, clip.rate_hz),
        step: held.report,
        clip: held.clip,
    })
}

/// In which frames each point is not where it should rest.
fn missed(points: &[Path], goals: &[Path], spans: &[Vec<PhaseFrames>], stature_m: f64) -> Vec<Vec<bool>> {
    let of_point = |((p, goal), spans): ((&Path, &Path), &Vec<PhaseFrames>)| {
        let mut out = vec![false; p.len()];
        for s in spans {
            (s.first..=s.last).for_each(|i| out[i] = (p[i] - goal[i]).norm() > MISSED * stature_m);
        }
        out
    };
    points.iter().zip(goals).zip(spans).map(of_point).collect()
}

/// Marks the link that is farthest from its own path, in each wrong frame, as let go; whether there was any.
fn let_go(
    (source, goals): (&[Path], &[Path]),
    links: &[Vec<usize>],
    (wrong, share): (&[bool], &[Vec<f64>]),
    gone_at: &mut [Vec<bool>],
    (least, rate_hz): (f64, f64),
) -> bool {
    let near = (AROUND_S * rate_hz).round() as usize;
    let far = |(of_link, share): (&Vec<usize>, &Vec<f64>)| {
        let off = |i: usize| {
            let most = of_link.iter().map(|&c| (goals[c][i] - source[c][i]).norm()).fold(0.0, f64::max);
            most * share[i]
        };
        around(&(0..wrong.len()).map(off).collect::<Vec<f64>>(), near)
    };
    let far: Vec<Vec<f64>> = links.iter().zip(share).map(far).collect();
    let mut any = false;
    for i in (0..wrong.len()).filter(|&i| wrong[i]) {
        let link = (0..links.len()).max_by(|&a, &b| far[a][i].total_cmp(&far[b][i]));
        if let Some(link) = link.filter(|&l| far[l][i] > least) {
            gone_at[link][i] = true;
            any = true;
        }
    }
    any
}
