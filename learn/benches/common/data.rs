//! Data that benches learn from.

use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Frames (rows) of ten quasi-periodic signals mixed into `channels`, with some curvature and noise: the
/// recipe of the project's peer benchmarks.
pub fn motion(frames: usize, channels: usize, seed: u64) -> DMatrix<f64> {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut normal = move || (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
    let mut signals = DMatrix::zeros(frames, 10);
    for l in 0..10 {
        let (f, g) = (1.15 + 0.5 * normal(), 2.5 + 0.8 * normal());
        let (p, q) = (3.0 * normal(), 3.0 * normal());
        let mut drift = 0.0;
        for i in 0..frames {
            let t = i as f64 / 60.0 * std::f64::consts::TAU;
            drift += normal();
            signals[(i, l)] =
                (f * t + p).sin() + 0.4 * (g * t + q).sin().powi(3) + 0.2 * drift / (frames as f64).sqrt();
        }
    }
    let mix = DMatrix::from_fn(10, channels, |l, _| normal() * 0.8_f64.powi(l as i32));
    let bend = DMatrix::from_fn(10, channels, |_, _| normal());
    let noise = DMatrix::from_fn(frames, channels, |_, _| 1e-2 * normal());
    &signals * mix + (&signals * bend).map(|v| 0.3 * v.tanh()) + noise
}
