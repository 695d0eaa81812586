//! The joint likelihood of the shared GPLVM, YAH10 (2), and its gradient.
//!
//! F = −ln P(Y|X, Φ_Y) − ln P(Z|X, Φ_Z) + ½ |X|² + (N q/2) ln 2π + Σ ln φ, with X ~ N(0, I) and p(Φ) ∝ Π 1/φ.
//!
//! Unknowns: X row by row (N × q), then four numbers per kernel (`kernel`). Both spaces share the distances
//! of X and one matrix of pair weights ω_ij = ∂F/∂|x_i − x_j|², so the cost is O(N³ + N² q), whatever the
//! dimensions of Y and Z: ∂F/∂x_i = 2 Σ_j ω_ij (x_i − x_j) + x_i.

use crate::dense::{axpy, dot, mirror};
use crate::descend::Objective;
use crate::error::FitError;
use crate::kernel::{Kernel, PARAMETERS, box_penalty};
use crate::likelihood::{View, Work, squared_distances};

/// The two views and what an evaluation writes into.
pub(crate) struct Joint {
    n: usize,
    q: usize,
    views: [View; 2],
    work: Work,
    r2: Vec<f64>,
    weights: Vec<f64>,
}

impl Joint {
    pub fn new(views: [View; 2], n: usize, q: usize) -> Self {
        Joint { n, q, views, work: Work::new(n), r2: vec![0.0; n * n], weights: vec![0.0; n * n] }
    }

    /// Unknowns: N q + 8.
    #[cfg(test)]
    pub fn unknowns(&self) -> usize {
        self.n * self.q + 2 * PARAMETERS
    }

    /// Packs latents (row by row) and kernels.
    pub fn pack(&self, x: &[f64], kernels: &[Kernel; 2]) -> Vec<f64> {
        let mut p = x.to_vec();
        kernels.iter().for_each(|k| p.extend(k.parameters()));
        p
    }

    /// Kernel of view `v` in the unknowns.
    pub fn kernel(&self, p: &[f64], v: usize) -> Kernel {
        Kernel::from_parameters(&p[self.n * self.q + v * PARAMETERS..][..PARAMETERS])
    }
}

impl Objective for Joint {
    fn evaluate(&mut self, p: &[f64], gradient: &mut [f64]) -> Result<f64, FitError> {
        let (n, q) = (self.n, self.q);
        let x = &p[..n * q];
        squared_distances(x, q, &mut self.r2);
        self.weights.fill(0.0);
        let mut value = 0.5 * dot(x, x) + 0.5 * (n * q) as f64 * (2.0 * std::f64::consts::PI).ln();
        for v in 0..2 {
            let kernel = self.kernel(p, v);
            let (l, mut by) =
                self.views[v].evaluate(&kernel, &self.r2, Some(&mut self.weights), &mut self.work)?;
            let (prior, by_prior) = kernel.minus_ln_prior();
            value += l + prior;
            by.iter_mut().zip(by_prior).for_each(|(a, b)| *a += b);
            let at = n * q + v * PARAMETERS..n * q + (v + 1) * PARAMETERS;
            gradient[at.clone()].copy_from_slice(&kernel.chain(&by));
            value += box_penalty(&p[at.clone()], &mut gradient[at]);
        }
        mirror(&mut self.weights, n);
        for i in 0..n {
            let row = &self.weights[i * n..(i + 1) * n];
            let g = &mut gradient[i * q..(i + 1) * q];
            let own = 2.0 * (row.iter().sum::<f64>() - row[i]) + 1.0;
            g.iter_mut().zip(&x[i * q..(i + 1) * q]).for_each(|(g, x)| *g = own * x);
            for j in (0..n).filter(|&j| j != i) {
                axpy(-2.0 * row[j], &x[j * q..(j + 1) * q], g);
            }
        }
        Ok(value)
    }
}

#[cfg(test)]
#[path = "objective_tests.rs"]
mod tests;
