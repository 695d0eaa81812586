//! Goals: the motion asked for, sampled at the control rate with its velocities and accelerations.
//!
//! In: a clip at any rate. Out: one row per control step. Poses are clamped to the joint limits
//! beforehand by whoever makes the clip.

use std::sync::Arc;

use motion::rotation::{exp, log, log_moment};
use motion::skeleton::{quat_at, vec_at};
use motion::{Clip, Derivatives, Joint, Skeleton};

/// Window over which a goal is differentiated, s.
///
/// Two frames each side at 60 Hz, four at 120 Hz: passes human motion (below about 8 Hz), damps the
/// noise of markers.
pub const WINDOW_S: f64 = 1.0 / 15.0;

/// A motion at the control rate.
#[derive(Clone, Debug)]
pub struct Goal {
    /// Whose motion.
    pub skeleton: Arc<Skeleton>,
    /// Control steps per second, Hz.
    pub rate_hz: f64,
    /// Poses, `rows × nq`.
    pub q: Vec<f64>,
    /// Velocities, `rows × nv`.
    pub v: Vec<f64>,
    /// Accelerations, `rows × nv`.
    pub vd: Vec<f64>,
}

impl Goal {
    /// Samples `clip` at `rate_hz`: poses by a cubic through the frames, derivatives fitted at the clip's own
    /// rate and interpolated.
    ///
    /// Between two frames velocity changes steadily. A slerp would keep it and jump at every frame: a
    /// pinned root would hammer on the body at the rate of the clip.
    pub fn new(clip: &Clip, rate_hz: f64) -> Self {
        let s = &clip.skeleton;
        let (nq, nv) = (s.nq(), s.nv());
        let d = Derivatives::new(clip, WINDOW_S);
        let rows = (clip.duration_s() * rate_hz + 1e-9).floor() as usize + 1;
        let mut goal = Self {
            skeleton: s.clone(),
            rate_hz,
            q: vec![0.0; rows * nq],
            v: vec![0.0; rows * nv],
            vd: vec![0.0; rows * nv],
        };
        let last = clip.frames() - 1;
        let slopes = slopes(clip);
        for row in 0..rows {
            let x = (row as f64 / rate_hz * clip.rate_hz).min(last as f64);
            // frame times are not exact in binary: within 1e-9 of a frame is that frame, to the bit
            let x = if (x - x.round()).abs() < 1e-9 { x.round() } else { x };
            let (i, f) = (x.floor() as usize, x.fract());
            let q = &mut goal.q[row * nq..(row + 1) * nq];
            q.copy_from_slice(clip.pose(i));
            if f > 0.0 {
                cubic(clip, i, f, &slopes, q);
            }
            let j = (i + 1).min(last);
            for k in 0..nv {
                let blend = |a: &[f64]| a[i * nv + k] * (1.0 - f) + a[j * nv + k] * f;
                goal.v[row * nv + k] = blend(&d.v);
                goal.vd[row * nv + k] = blend(&d.vd);
            }
        }
        goal
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.q.len() / self.skeleton.nq()
    }

    /// Pose of a row; the last row holds beyond the end.
    pub fn pose(&self, row: usize) -> &[f64] {
        let (row, n) = (row.min(self.rows() - 1), self.skeleton.nq());
        &self.q[row * n..(row + 1) * n]
    }

    /// Velocity of a row.
    pub fn velocity(&self, row: usize) -> &[f64] {
        let (row, n) = (row.min(self.rows() - 1), self.skeleton.nv());
        &self.v[row * n..(row + 1) * n]
    }

    /// Acceleration of a row.
    pub fn acceleration(&self, row: usize) -> &[f64] {
        let (row, n) = (row.min(self.rows() - 1), self.skeleton.nv());
        &self.vd[row * n..(row + 1) * n]
    }

    /// Pose at a time, s.
    pub fn pose_at(&self, t_s: f64) -> &[f64] {
        self.pose((t_s * self.rate_hz).round().max(0.0) as usize)
    }
}

/// Velocity at every frame per frame: the mean of the steps to its neighbours (`frames × nv`).
fn slopes(clip: &Clip) -> Vec<f64> {
    let (frames, nv) = (clip.frames(), clip.skeleton.nv());
    let mut out = vec![0.0; frames * nv];
    let mut step = vec![0.0; nv];
    for i in 1..frames {
        clip.skeleton.difference(clip.pose(i - 1), clip.pose(i), 1.0, &mut step);
        for frame in [i - 1, i] {
            // the ends have one neighbour
            let share = if frame == 0 || frame == frames - 1 { 1.0 } else { 0.5 };
            for k in 0..nv {
                out[frame * nv + k] += step[k] * share;
            }
        }
    }
    out
}

/// Moves `q` from frame `i` of the clip to the fraction `f` of the way to the next.
///
/// Hermite's cubic with the slopes of both ends; rotations in exponential coordinates about frame `i`,
/// where δ̇ = J(δ)⁻¹ ω at the far end.
fn cubic(clip: &Clip, i: usize, f: f64, slopes: &[f64], q: &mut [f64]) {
    let s = &clip.skeleton;
    let nv = s.nv();
    let (from, to) = (clip.pose(i), clip.pose(i + 1));
    let (v0, v1) = (&slopes[i * nv..(i + 1) * nv], &slopes[(i + 1) * nv..(i + 2) * nv]);
    let f2 = f * f;
    let (a, b, c) = (f2 * (3.0 - 2.0 * f), f * (1.0 - f) * (1.0 - f), f2 * (f - 1.0));
    let turn = |at: usize, v_at: usize| {
        let delta = log(&(quat_at(to, at) * quat_at(from, at).inverse()));
        let arrives = log_moment(&-delta, &vec_at(v1, v_at)); // J(δ)⁻¹ = J(−δ)⁻ᵀ
        exp(&(delta * a + vec_at(v0, v_at) * b + arrives * c)) * quat_at(from, at)
    };
    for (link, l) in s.links().iter().enumerate() {
        let (at, v_at) = (s.q_at(link), s.v_at(link));
        let mut slide = |k: usize| {
            q[at + k] = from[at + k] + (to[at + k] - from[at + k]) * a + v0[v_at + k] * b + v1[v_at + k] * c;
        };
        match l.joint {
            Joint::Free => {
                (0..3).for_each(slide);
                s.set_rotation(q, link, &turn(at + 3, v_at + 3));
            }
            Joint::Spherical => s.set_rotation(q, link, &turn(at, v_at)),
            Joint::Revolute(_) | Joint::Prismatic(_) => slide(0),
            Joint::Fixed => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use motion::{Link, Vec3};

    use super::*;

    /// A free body that slides and tumbles unevenly, and a hinge.
    fn clip(rate_hz: f64) -> Clip {
        let hinge = Joint::Revolute(Vec3::x());
        let links = vec![
            Link::new("root", None, Vec3::zeros(), Joint::Free),
            Link::new("arm", Some(0), Vec3::y(), Joint::Spherical),
            Link::new("hand", Some(1), Vec3::y(), hinge),
        ];
        let skeleton = Arc::new(Skeleton::new(links).unwrap());
        let mut q = Vec::new();
        for i in 0..=rate_hz as usize {
            let t = i as f64 / rate_hz;
            let mut pose = skeleton.zero_pose();
            skeleton.set_position(&mut pose, 0, &Vec3::new(t, t * t, (3.0 * t).sin()));
            let turn = exp(&(Vec3::new((4.0 * t).sin(), t, 2.0 * t * t)));
            skeleton.set_rotation(&mut pose, 0, &turn);
            skeleton.set_rotation(&mut pose, 1, &turn.inverse());
            pose[skeleton.q_at(2)] = (5.0 * t).cos();
            q.extend(pose);
        }
        Clip::new(skeleton, rate_hz, q)
    }

    /// Frames are kept to the bit, and between them the cubic is near the motion that was sampled.
    #[test]
    fn a_goal_passes_through_its_frames() {
        let (coarse, fine) = (clip(30.0), clip(240.0));
        let goal = Goal::new(&coarse, 240.0);
        assert_eq!(goal.rows(), fine.frames());
        let mut v = vec![0.0; coarse.skeleton.nv()];
        for f in 0..coarse.frames() {
            assert_eq!(goal.pose(8 * f), coarse.pose(f));
        }
        // away from the ends, where a frame has two neighbours
        for row in 8..goal.rows() - 8 {
            coarse.skeleton.difference(fine.pose(row), goal.pose(row), 1.0, &mut v);
            let error = v.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
            assert!(error < 2e-4, "row {row}: {error}"); // 1e-4 seen; a slerp is 3e-3 off
        }
    }

    /// Velocity does not jump at a frame of the clip: the goal's steps differ no more there than between.
    #[test]
    fn velocity_is_continuous_at_the_frames() {
        let goal = Goal::new(&clip(30.0), 960.0);
        let s = &goal.skeleton;
        let step = |row: usize| {
            let mut v = vec![0.0; s.nv()];
            s.difference(goal.pose(row), goal.pose(row + 1), 1.0 / 960.0, &mut v);
            v
        };
        for row in 32..goal.rows() - 33 {
            let (a, b) = (step(row - 1), step(row));
            for k in 0..s.nv() {
                // 30 rad/s² is the motion's own; slerp jumps by 1 rad/s at a frame
                assert!((a[k] - b[k]).abs() < 0.1, "row {row}, {k}: {} {}", a[k], b[k]);
            }
        }
    }
}
