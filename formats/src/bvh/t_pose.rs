//! Whether the first frame of a file is an inserted T-pose, and how far the motion jumps from it.
//!
//! In: a [`Bvh`]. Out: a [`TPose`].
//!
//! In an inserted T-pose nearly all angles that move in the clip are zero, and the step to the second frame, of
//! the limbs or of the root, is far beyond the steps that follow. A step of more than 20 times the steps of the
//! clip is no motion of anybody: such a T-pose is left out unless the caller keeps it.

use std::fmt;

use motion::rotation::log;

use super::pose::{of_joint, rotation};
use super::{Bvh, Channel};

/// A step this many times as large as the clip's own is no motion.
pub(super) const IMPOSSIBLE: f64 = 20.0;
/// Part of the moving angles that are zero in a T-pose.
const AT_ZERO: f64 = 0.75;
/// A first step this many times as large as those right after it marks an inserted frame.
const STANDS_OUT: f64 = 3.0;
/// Frames whose steps are compared with the first.
const LATER: usize = 12;

/// What the caller wants of the first frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TPoseRule {
    /// It is left out, whatever it is.
    Drop,
    /// It stays.
    Keep,
}

/// The first frame of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TPose {
    /// Whether it is an inserted T-pose.
    pub found: bool,
    /// Whether it was left out.
    pub dropped: bool,
    /// The step after it, in steps of the clip (the larger of limbs and root): of their median, which glitches do not
    /// raise.
    pub jump: f64,
    /// Whether the caller said what to do with it.
    pub stated: bool,
}

impl fmt::Display for TPose {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { found, dropped, jump, stated } = *self;
        match (found, dropped) {
            (true, true) if stated => write!(f, "first frame: an inserted T-pose, dropped as stated"),
            (true, true) => write!(
                f,
                "first frame: an inserted T-pose, dropped: the step after it is {jump:.0} times the clip's own; \
                 state that it stays if this is wrong"
            ),
            (true, false) if stated => write!(f, "first frame: an inserted T-pose, kept as stated"),
            (true, false) => write!(
                f,
                "first frame: an inserted T-pose, kept: the step after it is {jump:.0} times the clip's own, \
                 dropped is it beyond {IMPOSSIBLE:.0}; state that it goes if this is wrong"
            ),
            (false, _) => write!(f, "first frame: no inserted T-pose, dropped as stated"),
        }
    }
}

/// What is done with the first frame; `None` if it is a frame as any other.
pub(super) fn first_frame(bvh: &Bvh, rule: Option<TPoseRule>) -> Option<TPose> {
    let stated = rule.is_some();
    let can_go = bvh.frames > 1;
    match jump(bvh) {
        Some(jump) => {
            let dropped = match rule {
                None => jump > IMPOSSIBLE,
                Some(TPoseRule::Drop) => true,
                Some(TPoseRule::Keep) => false,
            };
            Some(TPose { found: true, dropped: dropped && can_go, jump, stated })
        }
        None if rule == Some(TPoseRule::Drop) && can_go => {
            Some(TPose { found: false, dropped: true, jump: 0.0, stated })
        }
        None => None,
    }
}

/// The step after an inserted T-pose, in steps of the clip; `None` if there is no T-pose.
fn jump(bvh: &Bvh) -> Option<f64> {
    if bvh.frames < 3 || bvh.joints.len() < 4 {
        return None;
    }
    let moving: Vec<usize> = bvh
        .joints
        .iter()
        .skip(1)
        .flat_map(|joint| joint.channels.iter().zip(joint.channels_at..))
        .filter(|(channel, _)| matches!(channel, Channel::Rotation(_)))
        .map(|(_, at)| at)
        .filter(|&at| {
            let values = (0..bvh.frames).map(|f| bvh.frame(f)[at]);
            let (lo, hi) =
                values.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)));
            hi - lo > 1.0
        })
        .collect();
    let at_zero = moving.iter().filter(|&&at| bvh.frame(0)[at].abs() < 1.0).count();
    if moving.is_empty() || (at_zero as f64) < AT_ZERO * moving.len() as f64 {
        return None;
    }
    // Some programs smooth the limbs into the T-pose but not the root, so either step tells.
    let root = |frame: usize| rotation(&bvh.joints[0], of_joint(&bvh.joints[0], bvh.frame(frame)));
    let turn = |frame: usize| log(&(root(frame + 1) * root(frame).inverse())).norm().to_degrees();
    let step = |frame: usize| {
        let (a, b) = (bvh.frame(frame), bvh.frame(frame + 1));
        moving.iter().map(|&at| (a[at] - b[at]).abs().min(360.0)).sum::<f64>() / moving.len() as f64
    };
    let later = |step: &dyn Fn(usize) -> f64| (1..bvh.frames.min(LATER) - 1).map(step).fold(0.0, f64::max);
    let limbs_jump = step(0) > (STANDS_OUT * later(&step)).max(1.0);
    let root_jumps = log(&root(0)).norm() < 1e-3 && turn(0) > (STANDS_OUT * later(&turn)).max(10.0);
    // Motion that is nearly still has steps of noise: a tenth of a degree counts at least.
    let own = |step: &dyn Fn(usize) -> f64| {
        let mut steps: Vec<f64> = (1..bvh.frames - 1).map(step).collect();
        steps.sort_by(f64::total_cmp);
        step(0) / steps[steps.len() / 2].max(0.1)
    };
    (limbs_jump || root_jumps).then(|| own(&step).max(own(&turn)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twelve angles that turn by 1° a frame, after a frame of zeros with a jump (degrees) behind it; `off` of them are not
    /// zero there.
    fn clip(jump: f64, off: usize) -> Bvh {
        let joint = |name: &str, inside: &str| {
            format!("{name}\n{{ OFFSET 0 1 0 CHANNELS 3 Zrotation Xrotation Yrotation {inside} }}")
        };
        let limbs = joint("JOINT b", &joint("JOINT c", &joint("JOINT d", "")));
        let root = joint("ROOT a", &(joint("JOINT e", "") + &limbs));
        let mut rows = String::new();
        for frame in 0..30 {
            for k in 0..15 {
                let angle = match (frame, k) {
                    (_, 0..3) => 0.0,
                    (0, k) if k - 3 < off => jump - 1.0,
                    (0, _) => 0.0,
                    _ => jump + f64::from(frame - 1),
                };
                rows += &format!("{angle} ");
            }
        }
        let text = format!("HIERARCHY {root} MOTION Frames: 30 Frame Time: 0.04 {rows}");
        Bvh::parse(text.as_bytes()).unwrap_or_else(|e| panic!("{e}"))
    }

    /// From both sides of each threshold: what stands out, how many angles are zero, what is impossible.
    #[test]
    fn a_t_pose_is_found_and_dropped_from_its_thresholds_on() {
        assert!(first_frame(&clip(2.9, 0), None).is_none());
        assert!(first_frame(&clip(3.1, 0), None).is_some_and(|t| t.found && !t.dropped));
        assert!(first_frame(&clip(19.9, 0), None).is_some_and(|t| !t.dropped));
        assert!(first_frame(&clip(20.1, 0), None).is_some_and(|t| t.dropped));
        assert!(first_frame(&clip(100.0, 3), None).is_some_and(|t| t.dropped));
        assert!(first_frame(&clip(100.0, 4), None).is_none());
    }
}
