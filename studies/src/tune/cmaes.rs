//! CMA-ES: evolution with an adapted covariance matrix, as a solver of argmin.
//!
//! In: a cost over points of any dimension, a start, a step, a seed. Out: a distribution N(m, σ²C) that has moved to
//! where costs are low. λ points a generation, costed together; ranks only, so that a cost may jump.
//!
//! Symbols: `n` dimension, `lambda` points a generation, `mu` of them kept with weights `w`, `mean` m, `sigma` σ,
//! `c` C = B D² Bᵀ, `path_s` and `path_c` evolution paths. Numbered equations are those of the tutorial.
//!
//! Our own because argmin has none, and because the crate that has (basin) costs the mean by itself between two
//! generations, which leaves the other cores idle, and would be a second framework beside argmin.
//!
//! N. Hansen. The CMA Evolution Strategy: A Tutorial. arXiv 1604.00772, 2016.

use argmin::core::{
    CostFunction, Error, IterState, KV, Problem, Solver, TerminationReason, TerminationStatus,
};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use super::point::Point;

/// The state of argmin that both solvers share.
pub type Iteration = IterState<Point, (), (), (), (), f64>;

/// The solver. See the module header.
#[derive(Clone, Debug)]
pub struct CmaEs {
    lambda: usize,
    w: Vec<f64>,
    mu_eff: f64,
    c_s: f64,
    d_s: f64,
    c_c: f64,
    c_1: f64,
    c_mu: f64,
    /// E‖N(0, I)‖.
    chi: f64,
    mean: DVector<f64>,
    sigma: f64,
    c: DMatrix<f64>,
    b: DMatrix<f64>,
    d: DVector<f64>,
    path_s: DVector<f64>,
    path_c: DVector<f64>,
    generation: i32,
    random: Normal,
    tolerance: f64,
}

impl CmaEs {
    /// A search from `mean` with the step `sigma`; it ends when no axis of the distribution is longer than
    /// `tolerance`.
    ///
    /// Strategy parameters are the defaults of the tutorial (table 1, without negative weights).
    pub fn new(mean: &[f64], sigma: f64, seed: u64, tolerance: f64) -> Self {
        let n = mean.len() as f64;
        let lambda = population(mean.len());
        let mu = lambda / 2;
        let raw: Vec<f64> = (1..=mu).map(|i| (0.5 * (lambda as f64 + 1.0)).ln() - (i as f64).ln()).collect();
        let sum: f64 = raw.iter().sum();
        let w: Vec<f64> = raw.iter().map(|x| x / sum).collect();
        let mu_eff = 1.0 / w.iter().map(|x| x * x).sum::<f64>();
        let c_s = (mu_eff + 2.0) / (n + mu_eff + 5.0);
        let c_1 = 2.0 / ((n + 1.3).powi(2) + mu_eff);
        let dimensions = mean.len();
        Self {
            lambda,
            w,
            mu_eff,
            c_s,
            d_s: 1.0 + 2.0 * (((mu_eff - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + c_s,
            c_c: (4.0 + mu_eff / n) / (n + 4.0 + 2.0 * mu_eff / n),
            c_1,
            c_mu: (1.0 - c_1).min(2.0 * (mu_eff - 2.0 + 1.0 / mu_eff) / ((n + 2.0).powi(2) + mu_eff)),
            chi: n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)),
            mean: DVector::from_column_slice(mean),
            sigma,
            c: DMatrix::identity(dimensions, dimensions),
            b: DMatrix::identity(dimensions, dimensions),
            d: DVector::from_element(dimensions, 1.0),
            path_s: DVector::zeros(dimensions),
            path_c: DVector::zeros(dimensions),
            generation: 0,
            random: Normal::new(seed),
            tolerance,
        }
    }

    /// One generation: sample, cost, move (equations 38 to 47).
    fn evolve(
        &mut self,
        cost: impl FnOnce(&[Point]) -> Result<Vec<f64>, Error>,
    ) -> Result<(Point, f64), Error> {
        let n = self.mean.len();
        let steps: Vec<DVector<f64>> = (0..self.lambda)
            .map(|_| {
                let z = DVector::from_fn(n, |_, _| self.random.next());
                &self.b * self.d.component_mul(&z)
            })
            .collect();
        let points: Vec<Point> =
            steps.iter().map(|y| Point((&self.mean + y * self.sigma).as_slice().to_vec())).collect();
        let costs = cost(&points)?;
        let mut order: Vec<usize> = (0..self.lambda).collect();
        // equal costs keep their order; NaN sorts last
        order.sort_by(|&i, &j| costs[i].total_cmp(&costs[j]));

        self.generation += 1;
        let mut y = DVector::zeros(n);
        for (w, &i) in self.w.iter().zip(&order) {
            y.axpy(*w, &steps[i], 1.0);
        }
        self.mean.axpy(self.sigma, &y, 1.0);
        let (c_s, c_c) = (self.c_s, self.c_c);
        let whitened = &self.b * (self.b.transpose() * &y).component_div(&self.d); // C^−½ y
        self.path_s = &self.path_s * (1.0 - c_s) + whitened * (c_s * (2.0 - c_s) * self.mu_eff).sqrt();
        let length = self.path_s.norm();
        let settled = (1.0 - (1.0 - c_s).powi(2 * self.generation)).sqrt();
        let h = length / settled < (1.4 + 2.0 / (n as f64 + 1.0)) * self.chi;
        let h = f64::from(u8::from(h));
        self.path_c = &self.path_c * (1.0 - c_c) + &y * (h * (c_c * (2.0 - c_c) * self.mu_eff).sqrt());
        let kept = 1.0 - self.c_1 - self.c_mu + (1.0 - h) * self.c_1 * c_c * (2.0 - c_c);
        self.c *= kept;
        self.c.ger(self.c_1, &self.path_c, &self.path_c, 1.0);
        for (w, &i) in self.w.iter().zip(&order) {
            self.c.ger(self.c_mu * w, &steps[i], &steps[i], 1.0);
        }
        self.sigma *= ((c_s / self.d_s) * (length / self.chi - 1.0)).exp();
        // rounding makes C slightly asymmetric and can make a vanished eigenvalue slightly negative
        let eigen = SymmetricEigen::new((&self.c + self.c.transpose()) * 0.5);
        let least = 1e-14 * eigen.eigenvalues.max();
        self.d = eigen.eigenvalues.map(|x| x.max(least).sqrt());
        self.b = eigen.eigenvectors;
        let best = order[0];
        Ok((points[best].clone(), costs[best]))
    }
}

/// Points a generation in `n` dimensions: 4 + ⌊3 ln n⌋.
pub fn population(n: usize) -> usize {
    4 + (3.0 * (n as f64).ln()).floor() as usize
}

impl<O: CostFunction<Param = Point, Output = f64>> Solver<O, Iteration> for CmaEs {
    fn name(&self) -> &str {
        "CMA-ES"
    }

    fn next_iter(
        &mut self,
        problem: &mut Problem<O>,
        state: Iteration,
    ) -> Result<(Iteration, Option<KV>), Error> {
        let cost =
            |points: &[Point]| problem.bulk_problem("cost_count", points.len(), |p| p.bulk_cost(points));
        let (point, cost) = self.evolve(cost)?;
        Ok((state.param(point).cost(cost), None))
    }

    fn terminate(&mut self, _state: &Iteration) -> TerminationStatus {
        if self.sigma * self.d.max() < self.tolerance {
            return TerminationStatus::Terminated(TerminationReason::SolverConverged);
        }
        TerminationStatus::NotTerminated
    }
}

/// Normal numbers from a seed (Box and Muller), the same in every version.
#[derive(Clone, Debug)]
struct Normal {
    random: Pcg64,
    spare: Option<f64>,
}

impl Normal {
    fn new(seed: u64) -> Self {
        Self { random: Pcg64::seed_from_u64(seed), spare: None }
    }

    fn next(&mut self) -> f64 {
        if let Some(x) = self.spare.take() {
            return x;
        }
        let r = (-2.0 * uniform(&mut self.random).ln()).sqrt();
        let (sin, cos) = (std::f64::consts::TAU * uniform(&mut self.random)).sin_cos();
        self.spare = Some(r * sin);
        r * cos
    }
}

/// Uniform in (0, 1].
pub fn uniform(random: &mut Pcg64) -> f64 {
    // 53 random bits
    ((random.next_u64() >> 11) + 1) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean 0, variance 1, and the tails of a normal distribution.
    #[test]
    fn numbers_are_normal() {
        let mut normal = Normal::new(5);
        let n = 20_000;
        let x: Vec<f64> = (0..n).map(|_| normal.next()).collect();
        let mean = x.iter().sum::<f64>() / f64::from(n);
        let variance = x.iter().map(|x| x * x).sum::<f64>() / f64::from(n);
        let beyond = x.iter().filter(|x| x.abs() > 1.96).count() as f64 / f64::from(n);
        assert!(mean.abs() < 0.02 && (variance - 1.0).abs() < 0.03, "{mean} {variance}");
        assert!((beyond - 0.05).abs() < 0.005, "{beyond}");
    }
}
