//! The noise floor of inverse dynamics: what noise of the poses makes of forces and torques.
//!
//! In: what the smoother found and left. Out: standard deviations.
//!
//! *Torques.* The smoother's sample of noise goes through the mass matrix frame by frame,
//! `τ_k = M(q_k) n_k` (inverse dynamics without gravity and velocity), and the RMS over the clip is reported.
//! The sample keeps what degrees of freedom have to do with each other: where a solver lets the root and
//! the hips compensate, their torques do not add up as if they did not. Noise of position and velocity
//! is left out (smaller by the time scale of the motion over that of the noise).
//!
//! *Force.* The noise left in the acceleration of the centre of mass, times the mass: measured on the path
//! of the centre of mass itself, so that what cancels between joints does cancel, and with soft tissue.

use motion::smooth::Smoothed;
use motion::{Joint, Vec3};

use crate::{Model, State};

/// Standard deviations of forces that are noise only.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NoiseFloor {
    /// Of each entry of `tau` (`nv`, N or N·m); zero where nothing was smoothed.
    pub tau: Vec<f64>,
    /// Of each axis of the required force, N.
    pub force: f64,
    /// Of the required moment about the root's origin, along the root's zero frame, N·m; zero for a root
    /// that is not free.
    pub moment: [f64; 3],
}

/// Standard deviations of noise within which a centre of pressure may be anywhere.
const DEVIATIONS: f64 = 2.0;

impl NoiseFloor {
    /// Moment by which noise may move the centre of pressure of a body whose centre of mass is `height` (m) over the ground,
    /// N·m: over the vertical force it is the distance. Noise of the horizontal force acts at that height.
    pub fn pressure(&self, height: f64) -> f64 {
        DEVIATIONS * (self.force * height.max(0.0)).hypot(self.moment[0].max(self.moment[2]))
    }

    /// Of a smoothed clip; the report's strength must be that of the centre of mass.
    pub fn of(model: &Model, state: &mut State, smoothed: &Smoothed) -> Self {
        let nv = model.nv();
        let weightless = Model { gravity: Vec3::zeros(), ..model.clone() };
        let (mut sum, mut tau, rest) = (vec![0.0; nv], vec![0.0; nv], vec![0.0; nv]);
        let rows = smoothed.noise_sample.chunks_exact(nv.max(1));
        let count = rows.len().max(1) as f64;
        for (k, noise) in rows.enumerate() {
            // a third difference lies between frames k + 1 and k + 2
            state.update(&weightless, smoothed.clip.pose(k + 1), &rest);
            state.inverse_dynamics(&weightless, &rest, noise, &[], &mut tau);
            sum.iter_mut().zip(&tau).for_each(|(s, t)| *s += t * t);
        }
        let tau: Vec<f64> = sum.iter().map(|s| (s / count).sqrt()).collect();
        let strength = &smoothed.report.strength;
        let force = model.mass * strength.acceleration_noise(smoothed.clip.rate_hz);
        let mut out = Self { tau, force, moment: [0.0; 3] };
        if model.bodies[0].joint == Joint::Free {
            out.moment.copy_from_slice(&out.tau[3..6]);
        }
        out
    }
}
