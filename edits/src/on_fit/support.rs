//! What carries the body: the root and the limbs that stand, which an edit through a fit leaves out.
//!
//! In: a motion with its contacts, and a span. Out: how much of an edit each DOF takes at a time, 0 to 1. Feet that stand
//! decide where the root can be, so neither the root nor a standing leg follows an edit that nobody asked of them. A leg that
//! lifts for a step stands as far as this goes: its swing leads from one place to the next, and so does that of a foot that is dragged.
//! A leg high in the air for longer (a kick, a jump) takes the edit there.

use std::ops::RangeInclusive;

use motion::{Clip, Dof, Kinematics, Limb, smoothstep};

use crate::Motion;
use crate::feet::{RAMP_S, of_limb};

/// A limb in the air for less is stepping, s.
pub const STEP_S: f64 = 0.8;
/// A limb whose end is no higher over where it stands lowest is stepping, or dragged, however long it takes, m. It is free from
/// twice this height on.
pub const STEP_M: f64 = 0.1;

/// What is left out.
pub(super) struct Support {
    root: bool,
    limbs: Vec<Standing>,
}

/// A limb that stands.
struct Standing {
    name: String,
    /// Its links, from the hip out.
    links: Vec<usize>,
    /// How much of an edit it takes, frame by frame, 0 to 1.
    free: Vec<f64>,
}

impl Support {
    /// Of a motion, within a span, s.
    pub(super) fn of(motion: &Motion, from_s: f64, to_s: f64) -> Self {
        let clip = &motion.clip;
        let s = &clip.skeleton;
        let root = motion.contacts.contacts().iter().any(|c| c.from_s <= to_s && c.to_s >= from_s);
        let all: Vec<Kinematics> = (0..clip.frames()).map(|f| Kinematics::new(s, clip.pose(f))).collect();
        let standing = |limb: &Limb| {
            let heights: Vec<f64> = all.iter().map(|k| k.origin(limb.end).y).collect();
            let free = free(clip, &heights, of_limb(s, &motion.contacts, limb).map(|c| (c.from_s, c.to_s)))?;
            let of = |link: &usize| *link == limb.upper || s.ancestors(*link).any(|a| a == limb.upper);
            let links = (0..s.links().len()).filter(of).collect();
            Some(Standing { name: limb.name.clone(), links, free })
        };
        Self { root, limbs: s.limbs().iter().filter_map(standing).collect() }
    }

    /// Nothing is left out.
    pub(super) fn none() -> Self {
        Self { root: false, limbs: Vec::new() }
    }

    /// How much of an edit a DOF takes in a frame.
    pub(super) fn share(&self, dof: Dof, frame: usize) -> f64 {
        if dof.link() == 0 && self.root {
            return 0.0;
        }
        self.limbs.iter().find(|l| l.links.contains(&dof.link())).map_or(1.0, |l| l.free[frame])
    }

    /// Whether a DOF is left out in all of these frames.
    pub(super) fn leaves_out(&self, dof: Dof, frames: RangeInclusive<usize>) -> bool {
        frames.into_iter().all(|frame| self.share(dof, frame) == 0.0)
    }

    /// In words; `None` where nothing is left out.
    pub(super) fn words(&self, root: &str) -> Option<String> {
        let mut all: Vec<&str> = Vec::new();
        if self.root {
            all.push(root);
        }
        all.extend(self.limbs.iter().map(|l| l.name.as_str()));
        (!all.is_empty()).then(|| {
            format!("left out while feet stand or step, unless named in `parts`: {}", all.join(", "))
        })
    }
}

/// How free a limb is that stands in these spans (s), frame by frame; `None` if it never stands. `heights`: of its end, m.
fn free(clip: &Clip, heights: &[f64], spans: impl Iterator<Item = (f64, f64)>) -> Option<Vec<f64>> {
    let mut spans: Vec<(f64, f64)> = spans.collect();
    spans.sort_by(|a, b| a.0.total_cmp(&b.0));
    let time = |f: usize| f as f64 / clip.rate_hz;
    let down = |f: usize| spans.iter().any(|(from, to)| *from <= time(f) && time(f) <= *to);
    let lowest_m = (0..heights.len()).filter(|f| down(*f)).map(|f| heights[f]).reduce(f64::min)?;
    // steps join the spans beside them; a clip may begin or end in one
    let mut joined: Vec<(f64, f64)> = Vec::new();
    for (from, to) in spans {
        let before = joined.last().map_or(0.0, |last| last.1);
        match joined.last_mut() {
            Some(last) if from - before < STEP_S => last.1 = last.1.max(to),
            None if from < STEP_S => joined.push((0.0, to)),
            _ => joined.push((from, to)),
        }
    }
    if let Some(last) = joined.last_mut().filter(|last| clip.duration_s() - last.1 < STEP_S) {
        last.1 = clip.duration_s();
    }
    let away = |t: f64| {
        joined.iter().map(|(from, to)| (from - t).max(t - to).max(0.0)).fold(f64::INFINITY, f64::min)
    };
    let of = |f: usize| {
        let high = smoothstep((heights[f] - lowest_m - STEP_M) / STEP_M);
        smoothstep(away(time(f)) / RAMP_S).min(high)
    };
    Some((0..heights.len()).map(of).collect())
}
