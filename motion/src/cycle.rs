//! Cycles: a clip that goes on by repeating a part of itself, such as a stride of a walk.
//!
//! In: a [`Clip`]. Out: the [`Cycle`] whose ends are most alike, and clips of any length that repeat it.
//!
//! *Ends are alike* where the body about the one is the body about the other, moved along the ground and turned about the vertical:
//! the RMS distance of the origins and ends of all links over [`SEAM_S`] before and after, when the one is laid best upon the other
//! (\[KGP02\] §3.1; the best turn and displacement are in closed form). A time and not a frame, so velocities are alike too. Lengths from
//! [`LEAST_S`] to [`MOST_S`] are looked at. The cycle found is the one whose seam is the smallest part of how far the body comes
//! from its first pose on the way (the same distance): frames side by side are alike, but nothing happens between them.
//!
//! *Repeated*, every cycle goes on where and as turned as the one before ended: a walk goes on, and what turns goes round in a
//! circle. Over the seam, [`SEAM_S`] before and after, one goes over into the other.
//!
//! Units: m, rad, s; world frame, y up.
//!
//! \[KGP02\] Kovar, Gleicher, Pighin. Motion Graphs. SIGGRAPH 2002.

use std::fmt;

use thiserror::Error;

use crate::rotation::{Quat, Vec3, log};
use crate::{Clip, Joint, Kinematics, Transform, smoothstep};

/// Before and after a seam the ends are compared, and go over into each other, for so long, s.
pub const SEAM_S: f64 = 0.1;
/// Shortest cycle, s.
pub const LEAST_S: f64 = 0.3;
/// Longest cycle, s.
pub const MOST_S: f64 = 10.0;
/// A seam that is a larger part of the movement is none.
pub const LARGEST: f64 = 0.25;

/// Cycles are looked for at this rate first, Hz, then frame by frame about the best.
const COARSE_HZ: f64 = 30.0;
/// Poses compared on either side of an end.
const SIDE: usize = 2;

/// A part of a clip that repeats.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    /// First frame.
    pub from: usize,
    /// The frame that is like it, and in whose place it comes.
    pub to: usize,
    /// Frames per second of the clip, Hz.
    pub rate_hz: f64,
    /// RMS distance of the links about the seam, m.
    pub seam_m: f64,
    /// RMS turn of the joints at the seam, the root's included, rad.
    pub seam_rad: f64,
    /// The furthest that the body comes from its first pose on the way, as the seam is measured, m.
    pub range_m: f64,
    /// From the first end to the second: turn about the vertical and displacement along the ground.
    pub step: Transform,
}

/// Why a clip does not go on.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum CycleError {
    /// Too short for a cycle and its seam.
    #[error(
        "the clip has {duration_s:.2} s; a cycle and its seam need at least {least:.2} s",
        least = LEAST_S + 2.0 * SEAM_S
    )]
    Short {
        /// Its length, s.
        duration_s: f64,
    },
    /// The root does not move freely.
    #[error("the root of the clip does not move freely: it cannot go on from where it is")]
    Rooted,
    /// No two ends are alike.
    #[error(
        "nothing in the clip repeats: what comes nearest is {from_s:.2} to {to_s:.2} s, with a seam of {seam_mm:.0} mm in a movement of {range_mm:.0} mm; allowed: {allowed:.0} %",
        allowed = 100.0 * LARGEST
    )]
    Unlike {
        /// Where the best cycle begins, s.
        from_s: f64,
        /// And ends, s.
        to_s: f64,
        /// Its seam, mm.
        seam_mm: f64,
        /// Its movement, mm.
        range_mm: f64,
    },
    /// Shorter than the clip itself.
    #[error("looped for {asked_s} s; allowed: longer than the clip, which has {duration_s:.2} s")]
    Shorter {
        /// Length asked for, s.
        asked_s: f64,
        /// Length of the clip, s.
        duration_s: f64,
    },
}

impl fmt::Display for Cycle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let time = |frame: usize| frame as f64 / self.rate_hz;
        let along = self.step.translation.vector.xz().norm();
        write!(
            f,
            "{:.2} to {:.2} s goes on, one cycle of {:.2} s, {along:.2} m and {:.1}° about the vertical; seam {:.1}°, {:.0} mm",
            time(self.from),
            time(self.to),
            time(self.to - self.from),
            log(&self.step.rotation).y.to_degrees(),
            self.seam_rad.to_degrees(),
            1e3 * self.seam_m,
        )
    }
}

impl Cycle {
    /// The best cycle of a clip. See the module header.
    ///
    /// # Errors
    /// [`CycleError`]: a clip too short, one without a free root, one in which nothing repeats.
    pub fn find(clip: &Clip) -> Result<Self, CycleError> {
        if !matches!(clip.skeleton.links()[0].joint, Joint::Free) {
            return Err(CycleError::Rooted);
        }
        let short = CycleError::Short { duration_s: clip.duration_s() };
        let clouds = Clouds::new(clip);
        let (first, last) = (clouds.side, clip.frames().saturating_sub(clouds.side + 1));
        let stride = ((clip.rate_hz / COARSE_HZ).round() as usize).max(1);
        let least = (LEAST_S * clip.rate_hz).ceil() as usize;
        if last < first + least + 2 * stride {
            return Err(short);
        }
        let most = (MOST_S * clip.rate_hz) as usize;
        let mut best: Option<(f64, f64, usize, usize)> = None;
        for from in (first..=last).step_by(stride) {
            let mut range = 0.0_f64;
            for to in (from + stride..=last.min(from + most)).step_by(stride) {
                let apart = clouds.apart(from, to).1;
                if to - from >= least {
                    let part = apart / range.max(1e-12);
                    if best.is_none_or(|b| part < b.0) {
                        best = Some((part, range, from, to));
                    }
                }
                range = range.max(apart);
            }
        }
        let Some((_, range_m, from, to)) = best else { return Err(short) };
        let about = |x: usize| x.saturating_sub(stride).max(first)..=(x + stride).min(last);
        let pairs = about(from).flat_map(|a| about(to).map(move |b| (a, b)));
        let far = pairs.filter(|(a, b)| a + least <= *b);
        let (from, to) = far
            .min_by(|x, y| clouds.apart(x.0, x.1).1.total_cmp(&clouds.apart(y.0, y.1).1))
            .unwrap_or((from, to));
        let (step, seam_m) = clouds.apart(from, to);
        if seam_m > LARGEST * range_m {
            let (from_s, to_s) = (from as f64 / clip.rate_hz, to as f64 / clip.rate_hz);
            return Err(CycleError::Unlike { from_s, to_s, seam_mm: 1e3 * seam_m, range_mm: 1e3 * range_m });
        }
        let seam_rad = turned(clip, &moved(clip, from, &step), clip.pose(to));
        Ok(Self { from, to, rate_hz: clip.rate_hz, seam_m, seam_rad, range_m, step })
    }

    /// The clip from its beginning, going on with its cycle until it has `seconds`. See the module header.
    ///
    /// # Errors
    /// [`CycleError::Shorter`].
    pub fn repeat(&self, clip: &Clip, seconds: f64) -> Result<Clip, CycleError> {
        let frames = (seconds * clip.rate_hz).round() as usize + 1;
        if frames <= clip.frames() {
            return Err(CycleError::Shorter { asked_s: seconds, duration_s: clip.duration_s() });
        }
        let (period, side) = (self.to - self.from, side(clip.rate_hz));
        let mut q = Vec::with_capacity(frames * clip.skeleton.nq());
        let mut pose = vec![0.0; clip.skeleton.nq()];
        // where the cycle that is being played lies, and the one after it
        let (mut now, mut next) = (Transform::identity(), self.step);
        let mut seam = self.to;
        for frame in 0..frames {
            if frame > seam + side {
                (now, next, seam) = (next, next * self.step, seam + period);
            }
            // from the seam on the source is counted from the cycle's end, before it from there back
            let source = |end: usize| (end + frame) - seam;
            let here = moved(clip, source(self.to), &now);
            if frame + side <= seam {
                q.extend(here);
                continue;
            }
            let there = moved(clip, source(self.from), &next);
            let over = smoothstep((frame + side - seam) as f64 / (2 * side) as f64);
            clip.skeleton.interpolate(&here, &there, over, &mut pose);
            q.extend_from_slice(&pose);
        }
        Ok(Clip::new(clip.skeleton.clone(), clip.rate_hz, q))
    }
}

/// Frames on either side of a seam.
fn side(rate_hz: f64) -> usize {
    ((SEAM_S * rate_hz).round() as usize).max(1)
}

/// A pose of the clip, moved in the world by `by`.
fn moved(clip: &Clip, frame: usize, by: &Transform) -> Vec<f64> {
    let s = &clip.skeleton;
    let mut q = clip.pose(frame).to_vec();
    let zero = s.links()[0].parent_from_zero;
    let joint = zero.inverse() * by * zero * s.joint_transform(&q, 0);
    s.set_position(&mut q, 0, &joint.translation.vector);
    s.set_rotation(&mut q, 0, &joint.rotation);
    q
}

/// RMS turn of the joints from one pose to another, rad.
fn turned(clip: &Clip, a: &[f64], b: &[f64]) -> f64 {
    let s = &clip.skeleton;
    let turns: Vec<f64> = (0..s.links().len())
        .filter(|l| !matches!(s.links()[*l].joint, Joint::Fixed | Joint::Prismatic(_)))
        .map(|l| log(&(s.rotation(a, l) * s.rotation(b, l).inverse())).norm_squared())
        .collect();
    (turns.iter().sum::<f64>() / turns.len().max(1) as f64).sqrt()
}

/// The turn about the vertical whose cosine and sine are as `along` to `across`; none where both are zero.
fn yaw(along: f64, across: f64) -> Quat {
    let whole = (along * along + across * across).sqrt();
    // half of the angle, without a difference of near numbers
    let (w, y) =
        if along < 0.0 { (across.abs(), (whole - along).copysign(across)) } else { (whole + along, across) };
    if w != 0.0 || y != 0.0 {
        Quat::new_normalize(nalgebra::Quaternion::new(w, 0.0, y, 0.0))
    } else {
        Quat::identity()
    }
}

/// The points of a body about every frame.
struct Clouds {
    /// Points frame by frame, m.
    points: Vec<Vec<Vec3>>,
    /// Frames on either side of an end.
    side: usize,
}

impl Clouds {
    fn new(clip: &Clip) -> Self {
        let s = &clip.skeleton;
        let mut k = Kinematics::new(s, clip.pose(0));
        let of_frame = |f: usize| {
            k.update(s, clip.pose(f));
            let ends = s.links().iter().enumerate().filter_map(|(l, link)| Some((l, link.end?)));
            (0..s.links().len()).map(|l| k.origin(l)).chain(ends.map(|(l, end)| k.point(l, &end))).collect()
        };
        Self { points: (0..clip.frames()).map(of_frame).collect(), side: side(clip.rate_hz) }
    }

    /// Frames that are compared about an end.
    fn about(&self, end: usize) -> impl Iterator<Item = &Vec<Vec3>> {
        (0..=2 * SIDE).map(move |i| &self.points[end - self.side + i * self.side / SIDE])
    }

    /// What lays the body about frame `a` best on that about `b`, turning about the vertical and moving along the ground; and the RMS
    /// distance that is left, m.
    fn apart(&self, a: usize, b: usize) -> (Transform, f64) {
        let pairs = || self.about(a).zip(self.about(b)).flat_map(|(p, q)| p.iter().zip(q));
        let n = pairs().count().max(1) as f64;
        let (sum_p, sum_q) = pairs().fold((Vec3::zeros(), Vec3::zeros()), |(x, y), (p, q)| (x + p, y + q));
        let (mid_p, mid_q) = (sum_p / n, sum_q / n);
        let (mut along, mut across, mut all) = (0.0, 0.0, 0.0);
        for (p, q) in pairs() {
            let (x, y) = (p - mid_p, q - mid_q);
            along += x.x * y.x + x.z * y.z;
            across += x.z * y.x - x.x * y.z;
            all += x.xz().norm_squared() + y.xz().norm_squared() + (p.y - q.y).powi(2);
        }
        let left = (all - 2.0 * (along * along + across * across).sqrt()).max(0.0);
        let turn = yaw(along, across);
        let by = mid_q - turn * mid_p;
        let step = Transform::from_parts(Vec3::new(by.x, 0.0, by.z).into(), turn);
        (step, (left / n).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;
    use std::sync::Arc;

    use super::*;
    use crate::rotation::exp;
    use crate::{Link, Skeleton};

    /// A body that swings two arms and goes along an arc: `noise` keeps cycles from being alike.
    fn walk(seconds: f64, period_s: f64, noise: f64) -> Clip {
        let arm = |name: &str, x: f64| Link {
            end: Some(Vec3::new(0.0, -0.5, 0.0)),
            ..Link::new(name, Some(0), Vec3::new(x, 0.0, 0.0), Joint::Spherical)
        };
        let links = vec![Link::new("hips", None, Vec3::zeros(), Joint::Free), arm("l", 0.2), arm("r", -0.2)];
        let s = Arc::new(Skeleton::new(links).unwrap());
        let (rate, mut data) = (100.0, Vec::new());
        for f in 0..=(seconds * rate) as usize {
            let t = f as f64 / rate;
            let mut q = s.zero_pose();
            let heading = 0.2 * t;
            let at = Vec3::new(
                5.0 * (1.0 - heading.cos()),
                1.0 + 0.02 * (2.0 * TAU * t / period_s).sin(),
                5.0 * heading.sin(),
            );
            s.set_position(&mut q, 0, &at);
            s.set_rotation(&mut q, 0, &exp(&(Vec3::y() * heading)));
            let swing = 0.5 * (TAU * t / period_s).sin() + noise * (3.1 * t + 5.0 * t * t).sin();
            s.set_rotation(&mut q, 1, &exp(&(Vec3::x() * swing)));
            s.set_rotation(&mut q, 2, &exp(&(Vec3::x() * -swing)));
            data.extend(q);
        }
        Clip::new(s, rate, data)
    }

    /// A period is found to the frame, and repeating it gives the motion that goes on: the circle of 5 m is closed to 1e-9 m after
    /// 60 s.
    #[test]
    fn a_walk_that_repeats_goes_on() {
        let (short, long) = (walk(3.0, 1.1, 0.0), walk(60.0, 1.1, 0.0));
        let cycle = Cycle::find(&short).unwrap();
        assert_eq!((cycle.to - cycle.from) % 110, 0, "{cycle}");
        assert!(cycle.seam_m < 1e-6 && cycle.seam_rad < 1e-6, "{cycle}");
        let turn = log(&cycle.step.rotation).y;
        let seconds = (cycle.to - cycle.from) as f64 / short.rate_hz;
        assert!((turn - 0.2 * seconds).abs() < 1e-9, "{turn}");
        let on = cycle.repeat(&short, 60.0).unwrap();
        assert_eq!(on.frames(), long.frames());
        let apart = on.data().iter().zip(long.data()).map(|(a, b)| (a - b).abs());
        // a quaternion and its opposite are one turn
        let flipped = on.data().iter().zip(long.data()).map(|(a, b)| (a + b).abs());
        let worst = apart.zip(flipped).map(|(a, b)| a.min(b)).fold(0.0, f64::max);
        println!("{cycle}: {worst:.1e}");
        assert!(worst < 1e-6, "{worst}");
    }

    /// Over a seam nothing jumps: velocities change no more than in the clip itself and over the blend.
    #[test]
    fn seams_do_not_jump() {
        let clip = walk(4.0, 1.1, 0.02);
        let cycle = Cycle::find(&clip).unwrap();
        assert!(cycle.seam_m > 1e-5, "{cycle}");
        let on = cycle.repeat(&clip, 12.0).unwrap();
        let jump = |clip: &Clip| {
            let (mut a, mut b) = (vec![0.0; clip.skeleton.nv()], vec![0.0; clip.skeleton.nv()]);
            let mut worst = 0.0_f64;
            for f in 2..clip.frames() {
                let s = &clip.skeleton;
                s.difference(clip.pose(f - 2), clip.pose(f - 1), 0.01, &mut a);
                s.difference(clip.pose(f - 1), clip.pose(f), 0.01, &mut b);
                worst = a.iter().zip(&b).map(|(x, y)| (x - y).abs()).fold(worst, f64::max);
            }
            worst
        };
        let (was, is) = (jump(&clip), jump(&on));
        println!("{cycle}: {was:.3} {is:.3} rad/s per frame");
        // the blend adds at most 6 / (2 × SEAM_S)² of the seam per second and frame
        let blend = 6.0 * 4.0 * cycle.seam_rad / (2.0 * SEAM_S).powi(2) * 0.01;
        assert!(is < was + blend, "{was} {is} {blend}");
    }

    /// What does not repeat, what is too short and what is held is refused with numbers.
    #[test]
    fn what_does_not_repeat_is_refused() {
        let once = walk(2.0, 9.0, 0.0);
        assert!(matches!(Cycle::find(&once), Err(CycleError::Unlike { .. })), "{:?}", Cycle::find(&once));
        assert!(matches!(Cycle::find(&walk(0.3, 0.2, 0.0)), Err(CycleError::Short { .. })));
        let clip = walk(3.0, 1.1, 0.0);
        let cycle = Cycle::find(&clip).unwrap();
        assert!(matches!(cycle.repeat(&clip, 2.0), Err(CycleError::Shorter { .. })));
        let links = vec![Link::new("base", None, Vec3::zeros(), Joint::Spherical)];
        let s = Arc::new(Skeleton::new(links).unwrap());
        let still = [1.0, 0.0, 0.0, 0.0].repeat(100);
        assert_eq!(Cycle::find(&Clip::new(s, 100.0, still)), Err(CycleError::Rooted));
    }

    /// Turns of all quadrants, and none of nothing.
    #[test]
    fn turns_about_the_vertical() {
        for deg in [-180.0_f64, -135.0, -90.0, -1e-6, 0.0, 45.0, 90.0, 179.0] {
            let angle = deg.to_radians();
            let turn = yaw(2.0 * angle.cos(), 2.0 * angle.sin());
            assert!((turn * Vec3::z() - Vec3::new(angle.sin(), 0.0, angle.cos())).norm() < 1e-12, "{deg}");
        }
        assert_eq!(yaw(0.0, 0.0), Quat::identity());
    }
}
