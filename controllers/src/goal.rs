//! Goals: the motion asked for, sampled at the control rate with its velocities and accelerations.
//!
//! In: a clip at any rate. Out: one row per control step. Poses are clamped to the joint limits
//! beforehand by whoever makes the clip.

use std::sync::Arc;

use motion::{Clip, Derivatives, Skeleton};

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
    /// Samples `clip` at `rate_hz`: poses by slerp, derivatives fitted at the clip's own rate and
    /// interpolated.
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
        for row in 0..rows {
            let t = row as f64 / rate_hz;
            clip.sample(t, &mut goal.q[row * nq..(row + 1) * nq]);
            let x = (t * clip.rate_hz).min(last as f64);
            let (i, f) = (x.floor() as usize, x.fract());
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
