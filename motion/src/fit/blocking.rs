//! Blocking: the few key poses that a motion can be told by.
//!
//! In: a clip. Out: [`Blocking`]: frames at least [`LEAST_S`] apart, so no more than four a second, whose poses, joined by named
//! transition curves, are nearest to the clip. All joints have their keys at the same frames. It is where an animator begins, not
//! a fit: what is left is said, not bounded.
//!
//! The keys are the best there are, by dynamic programming over all choices: least is the sum over frames and DOFs of the squared
//! difference (rad², m² times [`LENGTHS`]) and of a price for each key, that of [`PRICE_DEG`] in every DOF over [`LEAST_S`]. Each
//! transition has the curve of [`NAMED`] that is nearest. The difference of rotations is that of their vectors from the first key.

use crate::{Clip, Curve, Dof, Value};

use super::is_length;
use super::segment::{NAMED, Way};

/// Keys are not nearer to one another, s.
pub const LEAST_S: f64 = 0.25;
/// Nor further apart, s.
const MOST_S: f64 = 2.0;
/// A key must be worth this much, degrees RMS.
pub const PRICE_DEG: f64 = 4.0;
/// rad² for a m².
pub const LENGTHS: f64 = 9.0;
/// Frames that are looked at, per second.
const LOOKS_HZ: f64 = 30.0;

/// A key pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyPose {
    /// Its frame.
    pub frame: usize,
    /// The curve of the transition that leads to it.
    pub curve: Curve,
}

/// The key poses of a clip. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Blocking {
    /// In order; the first is the first frame, the last the last.
    pub keys: Vec<KeyPose>,
}

impl Blocking {
    /// Of a clip of at least two frames; one shorter than [`LEAST_S`] has its two ends.
    pub fn of(clip: &Clip) -> Self {
        let step = ((clip.rate_hz / LOOKS_HZ).round() as usize).max(1);
        let mut frames: Vec<usize> = (0..clip.frames()).step_by(step).collect();
        let last = clip.frames() - 1;
        if frames.last() != Some(&last) {
            frames.push(last);
        }
        let s = &clip.skeleton;
        let paths: Vec<(f64, Vec<Value>)> = Dof::all(s)
            .into_iter()
            .map(|dof| {
                let values = frames.iter().map(|f| dof.read(s, clip.pose(*f))).collect();
                (if is_length(s, dof) { LENGTHS } else { 1.0 }, values)
            })
            .collect();
        let time = |i: usize| frames[i] as f64 / clip.rate_hz;
        let price = PRICE_DEG.to_radians().powi(2) * paths.len() as f64 * LEAST_S * LOOKS_HZ;
        // least cost until each frame, with the key before it and the curve from there
        let n = frames.len();
        let mut best: Vec<Option<(f64, usize, Curve)>> = vec![None; n];
        best[0] = Some((0.0, 0, Curve::Linear));
        for to in 1..n {
            // the last frame may have nobody at the right distance: then the nearest that has a cost
            let near = |from: usize| time(to) - time(from) < LEAST_S - 1e-9;
            for from in (0..to).rev().filter(|from| !near(*from)) {
                if time(to) - time(from) > MOST_S && best[to].is_some() {
                    break;
                }
                let Some((cost, ..)) = best[from] else { continue };
                let (own, curve) = transition(&paths, from, to);
                let cost = cost + own + price;
                if best[to].is_none_or(|b| cost < b.0) {
                    best[to] = Some((cost, from, curve));
                }
            }
        }
        let mut keys = Vec::new();
        let mut at = n - 1;
        while let Some((_, from, curve)) = best[at].filter(|_| at > 0) {
            keys.push(KeyPose { frame: frames[at], curve });
            at = from;
        }
        if keys.is_empty() {
            keys.push(KeyPose { frame: last, curve: transition(&paths, 0, n - 1).1 });
        }
        keys.push(KeyPose { frame: 0, curve: Curve::Linear });
        keys.reverse();
        Self { keys }
    }
}

/// The least cost of going straight from one frame to another, and the curve that has it.
fn transition(paths: &[(f64, Vec<Value>)], from: usize, to: usize) -> (f64, Curve) {
    let ways: Vec<(f64, Way)> = paths.iter().map(|(w, v)| (*w, Way::new(&v[from..=to]))).collect();
    let cost = |curve: &Curve| -> f64 {
        let of = |(weight, way): &(f64, Way)| -> f64 {
            (1..to - from).map(|f| weight * way.about(curve, f).powi(2)).sum()
        };
        ways.iter().map(of).sum()
    };
    let all = NAMED.map(|curve| (cost(&curve), curve));
    all.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, Curve::Linear))
}
