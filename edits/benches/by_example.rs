//! The blend of edits by example: 10,000 frames of 62 coordinates, at most 0.15 µs for each frame and coordinate.
//!
//! The peer solves systems of the same shape, one factorisation for each coordinate: `solveh_banded` in `../shared/bench/b7_banded.py`. Compare
//! only numbers measured beside each other on one machine.

use std::hint::black_box;

use criterion::Criterion;
use edits::by_example::solve::{Evidence, blend};
use nalgebra::DMatrix;

const FRAMES: usize = 10_000;
const COORDINATES: usize = 62;

fn evidence(phase: f64, scale: f64) -> Evidence {
    let mean =
        DMatrix::from_fn(FRAMES, COORDINATES, |f, c| scale * (0.01 * f as f64 + c as f64 + phase).sin());
    let variance: Vec<f64> = (0..FRAMES).map(|f| 0.2 + (0.03 * f as f64 + phase).sin().powi(2)).collect();
    Evidence::new(mean, &variance, 1.3, 1.0, 1.0)
}

fn main() {
    let (configuration, acceleration) = (evidence(0.0, 1.0), evidence(1.0, 20.0));
    let mut criterion = Criterion::default().configure_from_args().sample_size(20);
    criterion.bench_function("blend 10000 frames x 62 coordinates", |b| {
        b.iter(|| blend(black_box(&configuration), black_box(&acceleration), 1.0 / 30.0));
    });
    criterion.final_summary();
}
