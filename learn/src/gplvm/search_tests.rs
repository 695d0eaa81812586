use super::*;
use crate::fixture::{matrix, stream};
use crate::kernel::Kernel;
use crate::likelihood::squared_distances;

struct Case {
    side: Posterior,
    latents: Vec<f64>,
    search: Search,
}

fn case(seed: u64, beta: f64) -> Case {
    let mut rng = stream(seed);
    let (n, q, rank) = (12, 5, 8);
    let kernel = Kernel { theta1: 1.5, theta2: 0.15, theta3: 0.02, beta };
    let latents = matrix(q, n, &mut rng).as_slice().to_vec();
    let mut r2 = vec![0.0; n * n];
    squared_distances(&latents, q, &mut r2);
    let side = Posterior::new(kernel, &r2, n, matrix(rank, n, &mut rng).as_slice()).unwrap();
    let mut search = Search::new(n, q, rank, 20);
    search.pose.copy_from_slice(matrix(rank, 1, &mut rng).as_slice());
    search.beyond = 0.3;
    search.trial.copy_from_slice(matrix(q, 1, &mut rng).as_slice());
    Case { side, latents, search }
}

/// ∂F/∂x against central differences, with and without prior.
#[test]
fn gradient_matches_differences() {
    let mut worst: f64 = 0.0;
    for seed in 0..5 {
        for lambda in [0.0, 1.0] {
            let Case { side, latents, mut search } = case(seed, 50.0);
            search.evaluate(&side, &latents, lambda);
            let (gradient, x) = (search.trial_gradient.clone(), search.trial.clone());
            for a in 0..x.len() {
                let h = 1e-5;
                let mut at = |sign: f64| {
                    search.trial.copy_from_slice(&x);
                    search.trial[a] += sign * h;
                    search.evaluate(&side, &latents, lambda)
                };
                let numeric = (at(1.0) - at(-1.0)) / (2.0 * h);
                worst = worst.max((gradient[a] - numeric).abs() / gradient[a].abs().max(1.0));
            }
        }
    }
    println!("worst {worst:.1e}");
    assert!(worst < 1e-6, "{worst:.1e}"); // 2e-9 seen
}

/// The first curvature is the inverse of the Fisher information: JᵀJ/σ² + D/(2σ⁴)∇σ²∇σ²ᵀ + λI by differences.
#[test]
fn curvature_is_fisher_information() {
    let Case { side, latents, mut search } = case(3, 50.0);
    let (q, rank) = (search.q, search.pose.len());
    search.point.copy_from_slice(&search.trial.clone());
    search.start_curvature(&side, &latents, 1.0);
    let h = search.h.clone();
    let x = search.point.clone();
    let v = search.moments(&side, &latents);
    let step = 1e-5;
    let mut slopes = Vec::new();
    for a in 0..q {
        let mut at = |sign: f64| {
            search.trial.copy_from_slice(&x);
            search.trial[a] += sign * step;
            let v = search.moments(&side, &latents);
            (v, search.residual.clone())
        };
        let (up, down) = (at(1.0), at(-1.0));
        let mean: Vec<f64> = (0..rank).map(|k| (down.1[k] - up.1[k]) / (2.0 * step)).collect();
        slopes.push(((up.0 - down.0) / (2.0 * step), mean));
    }
    let fisher = nalgebra::DMatrix::from_fn(q, q, |a, b| {
        let (a, b, same) = (&slopes[a], &slopes[b], if a == b { 1.0 } else { 0.0 });
        dot(&a.1, &b.1) / v + 0.5 * 20.0 / (v * v) * a.0 * b.0 + same
    });
    let product = fisher * nalgebra::DMatrix::from_row_slice(q, q, &h);
    let error = (product - nalgebra::DMatrix::identity(q, q)).amax();
    assert!(error < 1e-6, "{error:.1e}"); // 3e-10 seen
}

/// A search ends where no direction helps: the gradient there vanishes on the scale of the start's.
#[test]
fn a_search_ends_in_a_minimum() {
    for seed in 0..20 {
        let Case { side, latents, mut search } = case(seed, 1e4);
        search.trial.copy_from_slice(&latents[..search.q]);
        search.evaluate(&side, &latents, 1.0);
        let start = dot(&search.trial_gradient, &search.trial_gradient).sqrt();
        search.run(&side, &latents, 0, 1.0);
        search.trial.copy_from_slice(&search.answer);
        let value = search.evaluate(&side, &latents, 1.0);
        let end = dot(&search.trial_gradient, &search.trial_gradient).sqrt();
        assert!(
            end < 1e-4 * start.max(1.0),
            "seed {seed}: {start} to {end} in {} steps, {value}",
            search.steps
        );
        assert!(search.steps < STEPS, "seed {seed}");
    }
}
