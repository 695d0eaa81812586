//! How smoothly an edit comes and goes: jerk and peak speed of the hands, to be compared with those of a script.
//!
//! In: a clip, links, frames. Out: [`Smoothness`]. The frames of a transition are those in which the script changes a joint
//! by more than nothing and less than all ([`transition`]).
//!
//! Units: m, s, rad; world axes.

use std::ops::RangeInclusive;

use edits::by_example::Pair;
use motion::rotation::log;
use motion::{Clip, Kinematics, Vec3};

/// The frames of a transition go on for this long before and after, s.
pub const AROUND_S: f64 = 0.25;

/// Share of the edit that is nothing; the rest of it is all.
const SHARE: f64 = 0.01;

/// How the origins of some links move.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Smoothness {
    /// RMS over frames and links of the third difference by time of the origins, m/s³.
    pub jerk_rms: f64,
    /// Largest speed of one of them, by central differences, m/s.
    pub peak_m_s: f64,
}

/// Of the origins of `links` in the frames of a clip. Nothing of fewer than four frames.
pub fn smoothness(clip: &Clip, links: &[usize], frames: RangeInclusive<usize>) -> Smoothness {
    let mut out = Smoothness::default();
    let (mut sum, mut count) = (0.0, 0_usize);
    let mut k = Kinematics::new(&clip.skeleton, clip.pose(0));
    let mut places: Vec<Vec<Vec3>> = vec![Vec::new(); links.len()];
    for f in frames {
        k.update(&clip.skeleton, clip.pose(f));
        links.iter().zip(&mut places).for_each(|(&l, p)| p.push(k.origin(l)));
    }
    for p in &places {
        for w in p.windows(4) {
            let third = (w[3] - w[2] * 3.0 + w[1] * 3.0 - w[0]) * clip.rate_hz.powi(3);
            sum += third.norm_squared();
            count += 1;
        }
        for w in p.windows(3) {
            out.peak_m_s = out.peak_m_s.max((w[2] - w[0]).norm() * 0.5 * clip.rate_hz);
        }
    }
    out.jerk_rms = (sum / count.max(1) as f64).sqrt();
    out
}

/// How far the pair turns a joint in a frame, rad.
pub fn turned(pair: &Pair, link: usize, frame: usize) -> f64 {
    let s = &pair.source.skeleton;
    log(&(s.rotation(pair.source.pose(frame), link).inverse() * s.rotation(pair.target.pose(frame), link)))
        .norm()
}

/// From the first frame to the last in which the pair turns a joint by neither nothing nor the most that it does, with
/// [`AROUND_S`] on both sides; all frames where there is none.
pub fn transition(pair: &Pair, link: usize) -> RangeInclusive<usize> {
    let last = pair.source.frames() - 1;
    let angles: Vec<f64> = (0..=last).map(|f| turned(pair, link, f)).collect();
    let most = angles.iter().copied().fold(0.0, f64::max);
    let between = |f: &usize| (SHARE * most..(1.0 - SHARE) * most).contains(&angles[*f]);
    let around = (AROUND_S * pair.source.rate_hz).round() as usize;
    match ((0..=last).find(between), (0..=last).rev().find(between)) {
        (Some(a), Some(b)) => a.saturating_sub(around)..=(b + around).min(last),
        _ => 0..=last,
    }
}
