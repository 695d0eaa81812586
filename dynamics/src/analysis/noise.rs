//! The noise floor of inverse dynamics: what noise of the poses makes of forces and torques.
//!
//! In: what the smoother found and left. Out: standard deviations.
//!
//! *Torques.* The noise left in each degree of freedom's acceleration goes through the mass matrix:
//! `σ²(τ_i) = Σ_j M_ij² σ²(v̇_j)`, averaged over frames spread evenly through the clip. Noise of position
//! and velocity is left out (smaller by the time scale of the motion over that of the noise). The degrees
//! of freedom are taken as independent; where a solver has made them compensate each other, and for soft
//! tissue, which no spectrum shows, the true floor differs.
//!
//! *Force.* The noise left in the acceleration of the centre of mass, times the mass: measured on the path
//! of the centre of mass itself, so that what cancels between joints does cancel, and with soft tissue.

use motion::smooth::SmoothReport;
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
    /// Of each axis of the required force, N.
    pub force: f64,
    /// Of the required moment about the root's origin, along the root's zero frame, N·m; zero for a root
    /// that is not free.
    pub moment: [f64; 3],
}

impl NoiseFloor {
    /// Of a smoothed clip; the report's strength must be that of the centre of mass.
    pub fn of(model: &Model, state: &mut State, clip: &Clip, report: &SmoothReport) -> Self {
        let vd_noise = &report.acceleration_noise;
        let nv = model.nv();
        let mut m = DMatrix::zeros(nv, nv);
        let mut variance = vec![0.0; nv];
        let count = clip.frames().min(SAMPLES);
        for s in 0..count {
            let frame = s * (clip.frames() - 1) / (count - 1).max(1);
            state.update_pose(model, clip.pose(frame));
            state.mass_matrix(model, &mut m);
            for j in 0..nv {
                let v2 = vd_noise[j] * vd_noise[j];
                for i in 0..nv {
                    variance[i] += m[(i, j)] * m[(i, j)] * v2;
                }
            }
        }
        let tau: Vec<f64> = variance.iter().map(|x| (x / count.max(1) as f64).sqrt()).collect();
        let force = model.mass * report.strength.acceleration_noise(clip.rate_hz);
        let mut out = Self { tau, force, moment: [0.0; 3] };
        if model.bodies[0].joint == Joint::Free {
            out.moment.copy_from_slice(&out.tau[3..6]);
        }
        out
    }
}
