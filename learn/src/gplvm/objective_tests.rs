use nalgebra::DMatrix;

use super::*;
use crate::fixture::{matrix, stream};

/// ∂F by every latent coordinate and every kernel parameter against central differences, at random places.
#[test]
fn gradient_matches_differences_in_every_block() {
    let mut rng = stream(11);
    let (n, q) = (9, 5);
    let mut worst = [0.0_f64; 3];
    for round in 0..5 {
        let views = [View::new(&matrix(20, n, &mut rng)), View::new(&matrix(7, n, &mut rng))];
        let mut joint = Joint::new(views, n, q);
        let mut p = matrix(joint.unknowns(), 1, &mut rng).as_slice().to_vec();
        if round == 0 {
            p[n * q..].copy_from_slice(&[0.0, -1.0, -40.0, -2.0, 10.0, 0.5, -3.0, 5.5]); // three at the walls
        }
        let mut gradient = vec![0.0; p.len()];
        joint.evaluate(&p, &mut gradient).unwrap();
        let mut ignored = gradient.clone();
        for k in 0..p.len() {
            let h = 1e-5;
            let mut at = |sign: f64| {
                let mut moved = p.clone();
                moved[k] += sign * h;
                joint.evaluate(&moved, &mut ignored).unwrap()
            };
            let numeric = (at(1.0) - at(-1.0)) / (2.0 * h);
            let block = if k < n * q { 0 } else { 1 + (k - n * q) / PARAMETERS };
            let error = (gradient[k] - numeric).abs() / gradient[k].abs().max(1.0);
            worst[block] = worst[block].max(error);
        }
    }
    // X, Φ_Y, Φ_Z: 6e-8, 2e-9, 3e-8 seen.
    assert!(worst.iter().all(|w| *w < 1e-6), "{worst:?}");
}

/// The check above can fail: a gradient that forgets the prior of X is found.
#[test]
fn a_gradient_without_the_prior_is_found() {
    let mut rng = stream(12);
    let (n, q) = (6, 2);
    let views = [View::new(&matrix(5, n, &mut rng)), View::new(&matrix(5, n, &mut rng))];
    let mut joint = Joint::new(views, n, q);
    let p = matrix(joint.unknowns(), 1, &mut rng).as_slice().to_vec();
    let mut gradient = vec![0.0; p.len()];
    joint.evaluate(&p, &mut gradient).unwrap();
    let h = 1e-5;
    let mut at = |sign: f64| {
        let mut moved = p.clone();
        moved[0] += sign * h;
        joint.evaluate(&moved, &mut vec![0.0; p.len()]).unwrap()
    };
    let numeric = (at(1.0) - at(-1.0)) / (2.0 * h);
    assert!((gradient[0] - p[0] - numeric).abs() > 1e-3);
}

/// F is the sum of its five parts.
#[test]
fn the_objective_is_the_sum_of_its_parts() {
    let mut rng = stream(13);
    let (n, q) = (7, 3);
    let (y, z) = (matrix(4, n, &mut rng), matrix(6, n, &mut rng));
    let mut joint = Joint::new([View::new(&y), View::new(&z)], n, q);
    let kernels = [
        Kernel { theta1: 0.7, theta2: 0.4, theta3: 0.1, beta: 30.0 },
        Kernel { theta1: 2.0, theta2: 1.4, theta3: 0.01, beta: 300.0 },
    ];
    let x = matrix(n, q, &mut rng);
    let p = joint.pack(x.transpose().as_slice(), &kernels);
    let value = joint.evaluate(&p, &mut vec![0.0; p.len()]).unwrap();
    let ln_two_pi = (2.0 * std::f64::consts::PI).ln();
    let mut expected: f64 = x.iter().map(|v| 0.5 * (v * v + ln_two_pi)).sum();
    for (kernel, y) in kernels.iter().zip([&y, &z]) {
        let k = DMatrix::from_fn(n, n, |i, j| {
            let r2 = (x.row(i) - x.row(j)).norm_squared();
            kernel.theta1 * (-0.5 * kernel.theta2 * r2).exp()
                + kernel.theta3
                + if i == j { kernel.noise() } else { 0.0 }
        });
        let inverse = k.clone().try_inverse().unwrap();
        let d = y.nrows() as f64;
        expected += 0.5 * (inverse * y.transpose() * y).trace()
            + 0.5 * d * k.determinant().ln()
            + 0.5 * d * n as f64 * ln_two_pi
            + (kernel.theta1 * kernel.theta2 * kernel.theta3 * kernel.beta).ln();
    }
    assert!((value - expected).abs() < 1e-9, "{value} against {expected}"); // 3e-13 seen
}
