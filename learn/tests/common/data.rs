//! Small data sets for tests: one fixed stream per seed.

use learn::Pairs;
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Uniform in −1 … 1.
pub fn uniform(rows: usize, columns: usize, seed: u64) -> DMatrix<f64> {
    let mut rng = Pcg64::seed_from_u64(seed);
    DMatrix::from_fn(rows, columns, |_, _| rng.random_range(-1.0..1.0))
}

/// Three causes, nine input coordinates, six output coordinates; smooth and nonlinear.
pub fn curved(causes: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
    let n = causes.nrows();
    let y = DMatrix::from_fn(n, 9, |i, k| {
        let c = causes.row(i);
        (c[k % 3] + 0.3 * c[(k + 1) % 3] * k as f64 / 9.0).sin() + 0.2 * c[(k + 2) % 3]
    });
    let z = DMatrix::from_fn(n, 6, |i, k| {
        let c = causes.row(i);
        (1.2 * c[k % 3]).sin() + 0.5 * c[(k + 1) % 3] * c[(k + 2) % 3] * if k < 3 { 1.0 } else { -1.0 }
    });
    (y, z)
}

/// Twenty-five such pairs.
pub fn curved_pairs() -> Pairs {
    let (y, z) = curved(&uniform(25, 3, 4));
    Pairs::new(&y, &z).unwrap()
}

/// A path of `frames` inside the cube of causes.
pub fn path(frames: usize) -> DMatrix<f64> {
    DMatrix::from_fn(frames, 3, |i, k| 0.7 * (0.05 * i as f64 * (1.0 + 0.3 * k as f64) + k as f64).sin())
}
