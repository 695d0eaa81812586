//! Random matrices for unit tests: one fixed stream per seed.

use nalgebra::DMatrix;
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64;

pub fn stream(seed: u64) -> Pcg64 {
    Pcg64::seed_from_u64(seed)
}

/// Sums of four uniforms, variance 1: near enough to normal.
pub fn matrix(rows: usize, columns: usize, rng: &mut impl Rng) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns, |_, _| {
        (0..4).map(|_| rng.random_range(-1.0..1.0)).sum::<f64>() * 0.75_f64.sqrt()
    })
}
