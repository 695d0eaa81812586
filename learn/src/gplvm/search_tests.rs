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
    assert!(worst < 1e-6, "{worst:.1e}"); // 4e-9 seen
}

/// The curvature is the inverse of the second derivatives, against differences of the gradient.
#[test]
fn curvature_matches_differences_of_the_gradient() {
    let mut definite = 0;
    for seed in 0..10 {
        let Case { side, latents, mut search } = case(seed, 50.0);
        let q = search.q;
        search.run(&side, &latents, 0, 1.0);
        let x = search.answer.clone();
        search.point.copy_from_slice(&x);
        search.curvature(&side, &latents, 1.0);
        let h = nalgebra::DMatrix::from_row_slice(q, q, &search.h);
        let mut second = nalgebra::DMatrix::zeros(q, q);
        for a in 0..q {
            let step = 1e-5;
            let mut at = |sign: f64| {
                search.trial.copy_from_slice(&x);
                search.trial[a] += sign * step;
                search.evaluate(&side, &latents, 1.0);
                nalgebra::DVector::from_column_slice(&search.trial_gradient)
            };
            let up = at(1.0);
            second.set_column(a, &((up - at(-1.0)) / (2.0 * step)));
        }
        if second.symmetric_eigenvalues().min() > 0.0 {
            definite += 1;
            let error = (second * h - nalgebra::DMatrix::identity(q, q)).amax();
            assert!(error < 1e-6, "seed {seed}: {error:.1e}"); // 2e-9 seen
        }
    }
    assert!(definite >= 5, "{definite}");
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
