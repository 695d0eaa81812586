use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::*;
use crate::fixture::{matrix, stream};

/// K of (1), entry by entry.
fn k_matrix(kernel: &Kernel, x: &DMatrix<f64>) -> DMatrix<f64> {
    let n = x.nrows();
    DMatrix::from_fn(n, n, |i, j| {
        let r2 = (x.row(i) - x.row(j)).norm_squared();
        let delta = if i == j { 1.0 / kernel.beta } else { 0.0 };
        kernel.theta1 * (-kernel.theta2 / 2.0 * r2).exp() + kernel.theta3 + delta
    })
}

fn rows(x: &DMatrix<f64>) -> Vec<f64> {
    x.transpose().as_slice().to_vec()
}

fn kernels() -> [Kernel; 3] {
    [
        Kernel { theta1: 1.3, theta2: 0.2, theta3: 0.05, beta: 80.0 },
        Kernel { theta1: 0.02, theta2: 3.0, theta3: 2.0, beta: 9.0 },
        Kernel { theta1: 40.0, theta2: 0.01, theta3: 1e-4, beta: 1e5 },
    ]
}

/// Two roads: −Σ_k ln N(y_k; 0, K) column by column with K taken apart by its eigenvalues.
#[test]
fn likelihood_is_that_of_a_multivariate_normal() {
    let mut rng = stream(1);
    for (n, d) in [(4, 7), (9, 3), (25, 60)] {
        let x = matrix(n, 3, &mut rng);
        let y = matrix(n, d, &mut rng);
        let view = View::new(&y.transpose());
        let mut r2 = vec![0.0; n * n];
        squared_distances(&rows(&x), 3, &mut r2);
        for kernel in kernels() {
            let (value, _) = view.evaluate(&kernel, &r2, None, &mut Work::new(n)).unwrap();
            let e = SymmetricEigen::new(k_matrix(&kernel, &x));
            let mut expected = 0.0;
            for k in 0..d {
                let c: DVector<f64> = e.eigenvectors.tr_mul(&y.column(k));
                for i in 0..n {
                    let v = e.eigenvalues[i];
                    expected += 0.5 * (c[i] * c[i] / v + v.ln() + (2.0 * std::f64::consts::PI).ln());
                }
            }
            let error = (value - expected).abs() / expected.abs().max(1.0); // 6e-11 seen, at beta 1e5
            assert!(error < 1e-9, "{n} × {d}, {kernel:?}: {value} against {expected}");
        }
    }
}

/// One number by hand: one observation of one coordinate.
#[test]
fn one_observation_is_a_normal_density() {
    let kernel = Kernel { theta1: 1.0, theta2: 1.0, theta3: 0.5, beta: 2.0 };
    let view = View::new(&DMatrix::from_element(1, 1, 1.5));
    let (value, _) = view.evaluate(&kernel, &[0.0], None, &mut Work::new(1)).unwrap();
    // N(1.5; 0, 2): ½ (1.5²/2 + ln 2 + ln 2π) = 1.8280121…
    assert!((value - 1.828_012_123_484_645_4).abs() < 1e-14, "{value}");
}

/// Derivatives by the four parameters and by every squared distance, against central differences.
#[test]
fn derivatives_match_differences() {
    let mut rng = stream(2);
    let (n, d) = (11, 17);
    let x = matrix(n, 4, &mut rng);
    let view = View::new(&matrix(d, n, &mut rng));
    let mut r2 = vec![0.0; n * n];
    squared_distances(&rows(&x), 4, &mut r2);
    let mut work = Work::new(n);
    let mut worst: f64 = 0.0;
    // Not the third: differences of a likelihood of 10⁵ do not show six digits of a slope of one.
    let kernels =
        [kernels()[0], kernels()[1], Kernel { theta1: 4.0, theta2: 0.1, theta3: 0.01, beta: 200.0 }];
    for kernel in kernels {
        let mut by_r2 = vec![0.0; n * n];
        let (_, by) = view.evaluate(&kernel, &r2, Some(&mut by_r2), &mut work).unwrap();
        let theta = [kernel.theta1, kernel.theta2, kernel.theta3, kernel.noise()];
        for k in 0..PARAMETERS {
            let h = 1e-5 * theta[k];
            let at = |sign: f64| {
                let mut t = theta;
                t[k] += sign * h;
                let moved = Kernel { theta1: t[0], theta2: t[1], theta3: t[2], beta: 1.0 / t[3] };
                view.evaluate(&moved, &r2, None, &mut Work::new(n)).unwrap().0
            };
            // By ln θ, so that all have one unit.
            let (exact, numeric) = (by[k] * theta[k], (at(1.0) - at(-1.0)) / (2.0 * h) * theta[k]);
            worst = worst.max((exact - numeric).abs() / exact.abs().max(1.0));
        }
        for (i, j) in [(1, 0), (5, 2), (10, 9), (7, 0)] {
            let h = 1e-5;
            let at = |sign: f64| {
                let mut r = r2.clone();
                r[i * n + j] += sign * h;
                view.evaluate(&kernel, &r, None, &mut Work::new(n)).unwrap().0
            };
            let (exact, numeric) = (by_r2[i * n + j], (at(1.0) - at(-1.0)) / (2.0 * h));
            worst = worst.max((exact - numeric).abs() / exact.abs().max(1.0));
        }
    }
    assert!(worst < 1e-6, "{worst:.1e}"); // 4e-7 seen: rounding of the differences
}

/// The cost does not see the number of coordinates, and neither does the value: rotating observations
/// changes nothing.
#[test]
fn likelihood_ignores_a_rotation_of_the_observations() {
    let mut rng = stream(3);
    let (n, d) = (8, 30);
    let x = matrix(n, 3, &mut rng);
    let y = matrix(d, n, &mut rng);
    let turn = matrix(d, d, &mut rng).qr().q();
    let mut r2 = vec![0.0; n * n];
    squared_distances(&rows(&x), 3, &mut r2);
    let kernel = kernels()[0];
    let value = |y: &DMatrix<f64>| View::new(y).evaluate(&kernel, &r2, None, &mut Work::new(n)).unwrap().0;
    let (a, b) = (value(&y), value(&(turn * &y)));
    assert!((a - b).abs() < 1e-10 * a.abs(), "{a} {b}"); // 1e-14 seen
}
