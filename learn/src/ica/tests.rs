//! Laws of decompositions, and sources that are known.

use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::{Contrast, Count, IcaError, IcaOptions, Method, fit, fixed_point, whiten};

/// Three motions of joint groups at 60 Hz: a saw (flat), a square wave (two-valued) and rare pulses (long tails).
fn sources(frames: usize) -> DMatrix<f64> {
    DMatrix::from_fn(frames, 3, |i, k| {
        let t = i as f64 / 60.0;
        match k {
            0 => 2.0 * (0.83 * t).fract() - 1.0,
            1 => (std::f64::consts::TAU * 0.31 * t).sin().signum(),
            _ => (std::f64::consts::TAU * 0.47 * t).sin().powi(9),
        }
    })
}

fn mixed(frames: usize, channels: usize) -> DMatrix<f64> {
    let mut rng = Pcg64::seed_from_u64(4);
    let mix = DMatrix::from_fn(3, channels, |_, _| rng.random_range(-1.0..1.0));
    let offset = DMatrix::from_fn(1, channels, |_, c| c as f64);
    sources(frames) * mix + DMatrix::from_element(frames, 1, 1.0) * offset
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let (ma, mb) = (a.iter().sum::<f64>() / n, b.iter().sum::<f64>() / n);
    let dot = |f: &dyn Fn(usize) -> f64| (0..a.len()).map(f).sum::<f64>();
    dot(&|i| (a[i] - ma) * (b[i] - mb))
        / (dot(&|i| (a[i] - ma).powi(2)) * dot(&|i| (b[i] - mb).powi(2))).sqrt()
}

/// What was mixed is found again, by every method and nonlinearity, up to order and sign.
#[test]
fn mixed_sources_are_recovered() {
    let s = sources(1800);
    let x = mixed(1800, 30);
    let mut worst: f64 = 1.0;
    for method in [Method::Symmetric, Method::Deflation] {
        for contrast in [Contrast::Tanh, Contrast::Cube, Contrast::Exp] {
            let options = IcaOptions { count: Count::Number(3), method, contrast, ..IcaOptions::default() };
            let ica = fit(&x, &options).unwrap();
            assert!(
                ica.converged && ica.unstable().is_empty(),
                "{method:?} {contrast:?}: {:?}",
                ica.agreement
            );
            for k in 0..3 {
                let found = (0..3)
                    .map(|i| correlation(s.column(k).as_slice(), ica.activations.column(i).as_slice()).abs())
                    .fold(0.0, f64::max);
                assert!(found >= 0.99, "{method:?} {contrast:?}, source {k}: {found}");
                worst = worst.min(found);
            }
        }
    }
    println!("least |correlation| {worst:.5}"); // 0.99938 seen
}

/// Mean, mixing matrix and activations are the data, when every direction is kept.
#[test]
fn all_components_are_the_data() {
    let x = mixed(400, 12);
    let ica = fit(&x, &IcaOptions { count: Count::Number(3), ..IcaOptions::default() }).unwrap();
    let mean = DMatrix::from_fn(400, 12, |_, c| ica.whitening.mean[c]);
    let again = mean + &ica.activations * ica.mixing.transpose();
    let off = (again - &x).amax();
    assert!(off < 1e-9, "{off}"); // 4e-14 seen
    let shares: f64 = (0..3).map(|k| ica.share(k)).sum();
    assert!((shares - 1.0).abs() < 1e-12, "{shares}");
    let covariance = ica.activations.transpose() * &ica.activations / 400.0;
    let off = (covariance - DMatrix::identity(3, 3)).amax();
    assert!(off < 1e-10, "{off}"); // 3e-14 seen
    let off = (ica.project(&x) - &ica.activations).amax();
    assert!(off < 1e-10, "{off}"); // 0 seen
}

/// Gaussian data has no independent directions: starts do not agree, and that is said.
#[test]
fn gaussian_data_is_unstable() {
    let mut rng = Pcg64::seed_from_u64(11);
    let mut normal = move || (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
    let x = DMatrix::from_fn(4000, 5, |_, _| normal());
    let ica = fit(&x, &IcaOptions { count: Count::Number(5), ..IcaOptions::default() }).unwrap();
    println!("{:?}", ica.agreement);
    assert!(ica.unstable().len() >= 2, "{:?}", ica.agreement);
}

/// The same seed gives the same bits; another seed the same components of what has some.
#[test]
fn seeds_change_nothing_that_is_stable() {
    let x = mixed(900, 20);
    let of = |seed| fit(&x, &IcaOptions { count: Count::Number(3), seed, ..IcaOptions::default() }).unwrap();
    assert_eq!(of(7), of(7));
    let off = (of(7).activations - of(1000).activations).amax();
    assert!(off < 1e-3, "{off}"); // 3e-6 seen; order and sign are fixed
}

/// Counts by share of variance: the fewest that are enough.
#[test]
fn the_fewest_components_that_explain_enough() {
    // variances 8, 2, 1 of orthogonal channels
    let x = DMatrix::from_fn(64, 3, |i, k| {
        let sign = if (i >> k) & 1 == 0 { 1.0 } else { -1.0 };
        sign * [8.0_f64, 2.0, 1.0][k].sqrt()
    });
    for (share, k) in [(0.5, 1), (0.72, 1), (0.73, 2), (0.9, 2), (0.95, 3), (1.0, 3)] {
        assert_eq!(whiten(&x, Count::Share(share)).unwrap().variances.len(), k, "{share}");
    }
}

/// A start that is stopped early says so.
#[test]
fn a_start_that_is_stopped_has_not_converged() {
    let x = mixed(900, 20);
    for method in [Method::Symmetric, Method::Deflation] {
        let options = IcaOptions { count: Count::Number(3), most_steps: 1, method, ..IcaOptions::default() };
        let ica = fit(&x, &options).unwrap();
        assert!(!ica.converged && ica.last_turn > options.tolerance && ica.converged_starts == (0, 8));
    }
}

/// What cannot be decomposed says why.
#[test]
fn bad_data_is_refused() {
    let options = IcaOptions::default();
    let x = mixed(200, 6);
    let said = |x: &DMatrix<f64>, o: &IcaOptions| fit(x, o).unwrap_err().to_string();
    assert_eq!(said(&x.rows(0, 1).into_owned(), &options), "1 observations, at least 2 are needed");
    let still = DMatrix::from_element(20, 4, 0.1);
    assert_eq!(said(&still, &options), "all 4 channels stand still: there is nothing to tell apart");
    let of = |count| IcaOptions { count, ..options };
    assert_eq!(
        said(&x, &of(Count::Number(5))),
        "5 components, but the data varies in 3 directions only: ask for at most 3"
    );
    assert_eq!(said(&x, &of(Count::Share(1.5))), "variance = 1.5: must be above 0 and at most 1");
    assert_eq!(said(&x, &of(Count::Number(0))), "components = 0: must be 1 or more");
    let mut nan = x.clone();
    nan[(3, 2)] = f64::NAN;
    assert_eq!(said(&nan, &options), "observation 3, channel 2 is NaN");
    let z = whiten(&x, Count::Number(3)).unwrap().apply(&x).transpose();
    let flat = DMatrix::from_element(3, 3, 1.0);
    assert_eq!(fixed_point(&z, &flat, &options), Err(IcaError::Start { rows: 3, columns: 3, needed: 3 }));
}

/// A channel that stands still takes part in nothing.
#[test]
fn a_still_channel_is_moved_by_no_component() {
    let mut x = mixed(300, 8);
    x.column_mut(5).fill(1.7);
    let ica = fit(&x, &IcaOptions { count: Count::Number(3), ..IcaOptions::default() }).unwrap();
    let moved = ica.mixing.row(5).amax();
    assert!(moved < 1e-12, "{moved}"); // 1e-16 seen
}
