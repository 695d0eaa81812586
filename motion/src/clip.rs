//! Clips: uniformly sampled motion of one skeleton, the one coin every stage takes and gives.
//!
//! In: poses and a rate. Out: poses at any time, velocities and accelerations. Frames are stored in
//! one flat vector, `frames × nq`.

use std::sync::Arc;

use crate::Skeleton;

/// A uniformly sampled motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Clip {
    /// Whose motion it is.
    pub skeleton: Arc<Skeleton>,
    /// Frames per second, Hz.
    pub rate_hz: f64,
    q: Vec<f64>,
}

impl Clip {
    /// A clip of the poses in `q`, flat, `frames × nq`.
    ///
    /// # Panics
    /// If the length is not a multiple of `nq`, or the rate is not positive and finite.
    pub fn new(skeleton: Arc<Skeleton>, rate_hz: f64, q: Vec<f64>) -> Self {
        assert!(rate_hz > 0.0 && rate_hz.is_finite(), "rate {rate_hz} Hz");
        assert!(skeleton.nq() > 0 && q.len().is_multiple_of(skeleton.nq()), "{} numbers", q.len());
        Self { skeleton, rate_hz, q }
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.q.len() / self.skeleton.nq()
    }

    /// Time of the last frame, s (the first is at 0).
    pub fn duration_s(&self) -> f64 {
        self.frames().saturating_sub(1) as f64 / self.rate_hz
    }

    /// Pose of a frame, length `nq`.
    pub fn pose(&self, frame: usize) -> &[f64] {
        let n = self.skeleton.nq();
        &self.q[frame * n..(frame + 1) * n]
    }

    /// Pose of a frame, to be changed.
    pub fn pose_mut(&mut self, frame: usize) -> &mut [f64] {
        let n = self.skeleton.nq();
        &mut self.q[frame * n..(frame + 1) * n]
    }

    /// All poses, flat, `frames × nq`.
    pub fn data(&self) -> &[f64] {
        &self.q
    }

    /// Pose at a time (s), between frames by slerp; the ends hold outside the clip.
    pub fn sample(&self, t_s: f64, out: &mut [f64]) {
        let last = self.frames() - 1;
        let x = (t_s * self.rate_hz).clamp(0.0, last as f64);
        // Frame times are not exact in binary: within 1e-9 of a frame is that frame, to the bit.
        let near = x.round();
        if (x - near).abs() < 1e-9 {
            out.copy_from_slice(self.pose(near as usize));
            return;
        }
        let i = x.floor() as usize;
        self.skeleton.interpolate(self.pose(i), self.pose((i + 1).min(last)), x - i as f64, out);
    }

    /// The same motion at another rate; the last frame is at or before the original's end.
    pub fn resample(&self, rate_hz: f64) -> Self {
        let n = self.skeleton.nq();
        let frames = (self.duration_s() * rate_hz + 1e-9).floor() as usize + 1;
        let mut q = vec![0.0; frames * n];
        for (i, out) in q.chunks_exact_mut(n).enumerate() {
            self.sample(i as f64 / rate_hz, out);
        }
        Self::new(self.skeleton.clone(), rate_hz, q)
    }
}
