//! Decomposing motion and warping it in time.
//!
//! `cargo bench -p learn --bench decompose` times with criterion. With a folder, `cargo bench -p learn --bench decompose
//! -- DIR`, it writes the inputs there (`ica.f64`: 2000 × 93, `dtw_a.f64`, `dtw_b.f64`: 1000 × 1; row by row,
//! little-endian) and prints one JSON line of CPU seconds; `peers/run.sh` runs that and scikit-learn and dtaidistance in
//! turns. Compare only numbers of one such run.

use std::hint::black_box;
use std::path::Path;

use criterion::Criterion;
use learn::dtw::{Limits, Series, align};
use learn::ica::{Count, IcaOptions, fit};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Frames (rows) of six quasi-periodic signals mixed into channels, with some curvature and noise.
fn motion(frames: usize, channels: usize, noise: f64, seed: u64) -> DMatrix<f64> {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut uniform = move |lo: f64, hi: f64| rng.random_range(lo..hi);
    let mut normal = {
        let mut rng = Pcg64::seed_from_u64(seed + 1);
        move || (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>()
    };
    let mut signals = DMatrix::zeros(frames, 6);
    for l in 0..6 {
        let (f, g) = (uniform(0.3, 2.0), uniform(1.0, 4.0));
        let (p, q) = (uniform(0.0, 6.0), uniform(0.0, 6.0));
        let mut drift = 0.0;
        for i in 0..frames {
            let t = i as f64 / 60.0 * std::f64::consts::TAU;
            drift += normal();
            signals[(i, l)] =
                (f * t + p).sin() + 0.4 * (g * t + q).sin().powi(3) + 0.2 * drift / (frames as f64).sqrt();
        }
    }
    let mix = DMatrix::from_fn(6, channels, |l, _| normal() * 0.8_f64.powi(l as i32));
    let bend = DMatrix::from_fn(6, channels, |_, _| normal());
    &signals * mix
        + (&signals * bend).map(|v| 0.3 * v.tanh())
        + DMatrix::from_fn(frames, channels, |_, _| noise * normal())
}

/// A signal of 1,000 frames, and the same retimed.
fn series() -> (Vec<f64>, Vec<f64>) {
    let m = motion(2000, 1, 1e-2, 5);
    let mut rng = Pcg64::seed_from_u64(9);
    let mut at = 0.0;
    let times: Vec<f64> = (0..1000)
        .map(|_| {
            at += 0.4 + rng.random_range(0.0..1.0);
            at
        })
        .collect();
    let b = times.iter().map(|t| m[((t / at * 1200.0) as usize).min(1999)]).collect();
    (m.iter().take(1000).copied().collect(), b)
}

fn options(starts: usize) -> IcaOptions {
    IcaOptions { count: Count::Number(5), tolerance: 1e-4, most_steps: 500, starts, ..IcaOptions::default() }
}

#[cfg(unix)]
fn cpu_s() -> f64 {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    t.tv_sec as f64 + 1e-9 * t.tv_nsec as f64
}

#[cfg(unix)]
fn least(mut f: impl FnMut(), times: usize) -> f64 {
    (0..times)
        .map(|_| {
            let began = cpu_s();
            f();
            cpu_s() - began
        })
        .fold(f64::INFINITY, f64::min)
}

#[cfg(unix)]
fn one_run(dir: &Path, x: &DMatrix<f64>, a: &[f64], b: &[f64]) {
    let write = |name: &str, values: &mut dyn Iterator<Item = f64>| {
        let bytes: Vec<u8> = values.flat_map(f64::to_le_bytes).collect();
        std::fs::write(dir.join(name), bytes).expect("the folder is writable");
    };
    write("ica.f64", &mut x.transpose().iter().copied());
    write("dtw_a.f64", &mut a.iter().copied());
    write("dtw_b.f64", &mut b.iter().copied());
    let ica = least(|| drop(black_box(fit(x, &options(1)))), 10);
    let several = least(|| drop(black_box(fit(x, &options(8)))), 5);
    let found = fit(x, &options(1)).expect("it has five components");
    let path = |limits| least(|| drop(black_box(align(Series::one(a), Series::one(b), limits))), 10);
    let free = path(Limits::default());
    let banded = path(Limits { band: Some(100), ..Limits::default() });
    let limited = path(Limits { wait: Some(2), ..Limits::default() });
    let distance = align(Series::one(a), Series::one(b), Limits::default()).expect("a path").distance();
    println!(
        "{{\"engine\":\"contrapposto\",\"ica_s\":{ica},\"ica_8_starts_s\":{several},\"steps\":{},\"dtw_s\":{free},\"dtw_band_s\":{banded},\"dtw_wait_s\":{limited},\"distance\":{distance}}}",
        found.steps
    );
}

fn main() {
    let x = motion(2000, 93, 1e-3, 17);
    let (a, b) = series();
    let folder = std::env::args().skip(1).find(|arg| !arg.starts_with("--"));
    if let Some(folder) = folder.filter(|f| Path::new(f).is_dir()) {
        #[cfg(unix)]
        one_run(Path::new(&folder), &x, &a, &b);
        return;
    }
    let mut criterion = Criterion::default().configure_from_args();
    criterion
        .bench_function("ica, 2000 × 93 into 5, one start", |t| t.iter(|| fit(&x, &options(1)).unwrap()));
    criterion
        .bench_function("ica, 2000 × 93 into 5, eight starts", |t| t.iter(|| fit(&x, &options(8)).unwrap()));
    for (name, limits) in [
        ("free", Limits::default()),
        ("band of 10 %", Limits { band: Some(100), ..Limits::default() }),
        ("waits of 2", Limits { wait: Some(2), ..Limits::default() }),
    ] {
        criterion.bench_function(&format!("dtw path, 1000 × 1000, {name}"), |t| {
            t.iter(|| align(Series::one(&a), Series::one(&b), limits).unwrap());
        });
    }
    criterion.final_summary();
}
