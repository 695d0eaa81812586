//! The noise floor of inverse dynamics: what noise of the accelerations makes of forces and torques.
//!
//! In: the acceleration noise that the smoother left, per degree of freedom. Out: standard deviations.
//! Linear: `σ²(τ_i) = Σ_j M_ij² σ²(v̇_j)`, averaged over frames spread evenly through the clip. Noise of
//! position and velocity is left out (smaller by the time scale of the motion over that of the noise),
//! and the degrees of freedom are taken as independent.

use motion::{Clip, Joint};
use nalgebra::DMatrix;

use crate::{Model, State};

/// Frames at which the mass matrix is taken.
const SAMPLES: usize = 32;

/// Standard deviations of forces that are noise only.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NoiseFloor {
    /// Of each entry of `tau` (`nv`, N or N·m).
    pub tau: Vec<f64>,
    /// Of the required force, world axes, N; zero for a root that is not free.
    pub force: [f64; 3],
    /// Of the required moment about the root's origin, N·m; zero for a root that is not free.
    pub moment: [f64; 3],
}

impl NoiseFloor {
    /// Of a clip whose accelerations carry noise of the standard deviations `vd_noise` (`nv`).
    pub fn of(model: &Model, state: &mut State, clip: &Clip, vd_noise: &[f64]) -> Self {
        let nv = model.nv();
        let mut m = DMatrix::zeros(nv, nv);
        let mut variance = vec![0.0; nv];
        let rest = vec![0.0; nv];
        let count = clip.frames().min(SAMPLES);
        for s in 0..count {
            let frame = s * (clip.frames() - 1) / (count - 1).max(1);
            state.update(model, clip.pose(frame), &rest);
            state.mass_matrix(model, &mut m);
            for j in 0..nv {
                let v2 = vd_noise[j] * vd_noise[j];
                for i in 0..nv {
                    variance[i] += m[(i, j)] * m[(i, j)] * v2;
                }
            }
        }
        let tau: Vec<f64> = variance.iter().map(|x| (x / count.max(1) as f64).sqrt()).collect();
        let mut out = Self { tau, ..Self::default() };
        if model.bodies[0].joint == Joint::Free {
            out.force.copy_from_slice(&out.tau[..3]);
            out.moment.copy_from_slice(&out.tau[3..6]);
        }
        out
    }
}
