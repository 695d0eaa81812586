//! Velocities and accelerations of a sampled clip.
//!
//! In: a [`Clip`]. Out: `v` and `v̇` of every frame, in the layout of [`crate::skeleton`]. The one place
//! where motion is differentiated; for forces the clip goes through [`mod@crate::smooth`] first.
//!
//! Around frame `k` the path is written in the tangent space of its pose, `δ(t) = log(q(t) q_k⁻¹)`
//! (quaternion logarithm for rotations), and a parabola is fitted to the frames of the window by least
//! squares (Savitzky–Golay): its slope and curvature at `k` are `v` and `v̇`, because there
//! `ω = δ̇` and `ω̇ = δ̈` exactly. Exact for constant acceleration; a wider window suppresses noise and
//! rounds off anything faster. At the ends the window is one-sided.
//!
//! For a path without noise, central differences in the same tangent space are sharper.

use crate::Clip;

/// Velocities (`frames × nv`) and accelerations (`frames × nv`) of a clip.
#[derive(Clone, Debug, PartialEq)]
pub struct Derivatives {
    /// Velocities, flat.
    pub v: Vec<f64>,
    /// Accelerations, flat.
    pub vd: Vec<f64>,
}

impl Derivatives {
    /// Fits parabolas over `window_s` seconds centred on each frame (at least one frame each side).
    ///
    /// A clip of one frame is at rest; of two frames, without acceleration.
    pub fn new(clip: &Clip, window_s: f64) -> Self {
        let (frames, nv) = (clip.frames(), clip.skeleton.nv());
        let half = ((0.5 * window_s * clip.rate_hz).round() as usize).max(1);
        let mut out = Self { v: vec![0.0; frames * nv], vd: vec![0.0; frames * nv] };
        let mut delta = vec![0.0; nv];
        for k in 0..frames {
            let (from, to) = (k.saturating_sub(half), (k + half).min(frames - 1));
            let weights = parabola(from as i64 - k as i64, to as i64 - k as i64, clip.rate_hz);
            let (v, vd) = (&mut out.v[k * nv..(k + 1) * nv], &mut out.vd[k * nv..(k + 1) * nv]);
            for (j, (slope, bend)) in (from..=to).zip(&weights) {
                clip.skeleton.difference(clip.pose(k), clip.pose(j), 1.0, &mut delta);
                for i in 0..nv {
                    v[i] += slope * delta[i];
                    vd[i] += bend * delta[i];
                }
            }
        }
        out
    }

    /// Five-point central differences, exact for quartics; near the ends three-point ones, exact for
    /// parabolas. Nothing is smoothed.
    pub fn central(clip: &Clip) -> Self {
        let (frames, nv, rate) = (clip.frames(), clip.skeleton.nv(), clip.rate_hz);
        let mut out = Self { v: vec![0.0; frames * nv], vd: vec![0.0; frames * nv] };
        let mut delta = vec![0.0; nv];
        for k in 0..frames {
            let (v, vd) = (&mut out.v[k * nv..(k + 1) * nv], &mut out.vd[k * nv..(k + 1) * nv]);
            for &(offset, slope, bend) in stencil(k, frames) {
                let at = k.wrapping_add_signed(offset);
                clip.skeleton.difference(clip.pose(k), clip.pose(at), 1.0, &mut delta);
                for i in 0..nv {
                    v[i] += slope * rate * delta[i];
                    vd[i] += bend * rate * rate * delta[i];
                }
            }
        }
        out
    }
}

type Stencil = &'static [(isize, f64, f64)];

/// Neighbours of a frame with their weights for slope and curvature, per frame; the frame's own is zero in
/// its tangent space.
fn stencil(k: usize, frames: usize) -> Stencil {
    const FIVE: Stencil = &[
        (-2, 1.0 / 12.0, -1.0 / 12.0),
        (-1, -8.0 / 12.0, 16.0 / 12.0),
        (1, 8.0 / 12.0, 16.0 / 12.0),
        (2, -1.0 / 12.0, -1.0 / 12.0),
    ];
    const THREE: Stencil = &[(-1, -0.5, 1.0), (1, 0.5, 1.0)];
    const FIRST: Stencil = &[(1, 2.0, -2.0), (2, -0.5, 1.0)];
    const LAST: Stencil = &[(-1, -2.0, -2.0), (-2, 0.5, 1.0)];
    match frames {
        0 | 1 => &[],
        2 if k == 0 => &[(1, 1.0, 0.0)],
        2 => &[(-1, -1.0, 0.0)],
        _ if k == 0 => FIRST,
        _ if k == frames - 1 => LAST,
        _ if k == 1 || k == frames - 2 => THREE,
        _ => FIVE,
    }
}

/// Weights of the samples `from..=to` (in frames) for slope and curvature at 0 of the fitted parabola.
pub fn parabola(from: i64, to: i64, rate_hz: f64) -> Vec<(f64, f64)> {
    let n = (to - from + 1) as usize;
    let t = |j: usize| (from + j as i64) as f64 / rate_hz;
    if n < 3 {
        let (a, b) = (t(0), t(n - 1));
        let slope = if n == 2 { 1.0 / (b - a) } else { 0.0 };
        return (0..n).map(|j| (if j == 0 { -slope } else { slope }, 0.0)).collect();
    }
    // normal equations of the monomials 1, t, t²
    let rows = |j: usize| nalgebra::Vector3::new(1.0, t(j), t(j) * t(j));
    let normal: nalgebra::Matrix3<f64> = (0..n).map(|j| rows(j) * rows(j).transpose()).sum();
    let inverse = normal.try_inverse().unwrap_or_default();
    (0..n)
        .map(|j| {
            let c = inverse * rows(j);
            (c[1], 2.0 * c[2])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::exp;
    use crate::{Joint, Link, Skeleton, Vec3};
    use std::sync::Arc;

    fn skeleton() -> Arc<Skeleton> {
        let ball = Link::new("ball", Some(0), Vec3::y(), Joint::Spherical);
        let hinge = Link::new("hinge", Some(1), Vec3::y(), Joint::Revolute(Vec3::x()));
        let root = Link::new("root", None, Vec3::zeros(), Joint::Free);
        Arc::new(Skeleton::new(vec![root, ball, hinge]).unwrap())
    }

    /// A ball that spins ever faster about a fixed axis, a root in free fall: exact, at the ends too.
    #[test]
    fn constant_acceleration_is_exact() {
        let s = skeleton();
        let rate = 100.0;
        let axis = Vec3::new(1.0, 2.0, -1.0).normalize();
        let mut q = Vec::new();
        for k in 0..40 {
            let t = k as f64 / rate;
            let mut pose = s.zero_pose();
            s.set_position(&mut pose, 0, &Vec3::new(t, 2.0 - 4.9 * t * t, 0.0));
            s.set_rotation(&mut pose, 1, &exp(&(axis * (0.5 * t + 3.0 * t * t))));
            pose[s.q_at(2)] = 1.0 - t * t;
            q.extend(pose);
        }
        let d = Derivatives::new(&Clip::new(s.clone(), rate, q), 0.08);
        for k in [0, 1, 20, 38, 39] {
            let t = k as f64 / rate;
            let (v, vd) = (&d.v[k * 10..], &d.vd[k * 10..]);
            assert!((v[1] + 9.8 * t).abs() < 1e-9 && (vd[1] + 9.8).abs() < 1e-8);
            for i in 0..3 {
                assert!((v[6 + i] - axis[i] * (0.5 + 6.0 * t)).abs() < 1e-9);
                assert!((vd[6 + i] - axis[i] * 6.0).abs() < 1e-7);
            }
            assert!((v[9] + 2.0 * t).abs() < 1e-9 && (vd[9] + 2.0).abs() < 1e-8);
        }
    }

    /// Velocity carries one frame to the next: integrate ∘ differentiate to second order.
    #[test]
    fn velocity_carries_frame_to_frame() {
        let s = skeleton();
        let error = |rate: f64| {
            let mut q = Vec::new();
            for k in 0..200 {
                let t = k as f64 / rate;
                let mut pose = s.zero_pose();
                let r = Vec3::new((2.0 * t).sin(), (3.0 * t).cos(), t.sin());
                s.set_rotation(&mut pose, 1, &exp(&r));
                q.extend(pose);
            }
            let clip = Clip::new(s.clone(), rate, q);
            let d = Derivatives::new(&clip, 2.1 / rate);
            let mut pose = clip.pose(49).to_vec();
            s.integrate(&mut pose, &d.v[50 * 10..51 * 10], 2.0 / rate);
            (s.rotation(&pose, 1).inverse() * s.rotation(clip.pose(51), 1)).angle()
        };
        assert!(error(100.0) < 1e-4 && error(200.0) < error(100.0) / 3.0);
    }
}
