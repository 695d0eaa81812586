//! Mapping a pose: the latent point that best explains it, [YAH10] (5).
//!
//! Minimises F(x) = |y − ȳ(x)|²/(2σ²(x)) + (D/2) ln σ²(x) + (λ/2)|x|² over x, with posterior mean ȳ = Wᵀw and variance
//! σ² = k(x, x) − |w|² of the input space, w = L⁻¹k(x) (`posterior`); λ is 1 with the prior X ~ N(0, I), 0 without. Poses
//! are held in the N coordinates of the span of the key poses; what a pose has beyond that span cannot be explained
//! and is a constant in |y − ȳ|².
//!
//! Quasi-Newton steps (BFGS) that start from the Fisher information at the start,
//! I = JᵀJ/σ² + D/(2σ⁴) ∇σ²∇σ²ᵀ + λI, J = ∂ȳ/∂x: without it 30 latent directions whose curvatures
//! differ a thousandfold take a hundred steps, with it about ten. No allocation after [`Search::new`].

use crate::dense::{axpy, cholesky, distance_squared, dot, gram_of_lower, invert_lower, matvec};
use crate::posterior::Posterior;

/// Steps of one search.
const STEPS: usize = 100;
/// Expected gain of a further step, in nats, at which a search ends: a step of 10⁻⁵ posterior standard deviations.
const ENOUGH: f64 = 1e-10;

/// Workspace of the mapping of one pose after another.
#[derive(Clone, Debug)]
pub(crate) struct Search {
    n: usize,
    q: usize,
    /// Coordinates of a pose, D.
    dim: f64,
    /// Longest step.
    pub reach: f64,
    /// Coordinates of the pose in the span of the key poses.
    pub pose: Vec<f64>,
    /// Squared distance of the pose from that span.
    pub beyond: f64,
    /// Answer to the last pose.
    pub answer: Vec<f64>,
    /// Whether there is one.
    pub warm: bool,
    /// What the last pose took: BFGS steps over both starts.
    pub steps: usize,
    pub point: Vec<f64>,
    other: Vec<f64>,
    trial: Vec<f64>,
    gradient: Vec<f64>,
    trial_gradient: Vec<f64>,
    direction: Vec<f64>,
    turned: Vec<f64>,
    h: Vec<f64>,
    fisher: Vec<f64>,
    k_slopes: Vec<f64>,
    jacobian: Vec<f64>,
    phi: Vec<f64>,
    k: Vec<f64>,
    w: Vec<f64>,
    by_w: Vec<f64>,
    by_k: Vec<f64>,
    /// y − ȳ(x) in the span of the key poses.
    pub residual: Vec<f64>,
}

/// Value at the best point found from a start.
#[derive(Clone, Copy, Debug)]
struct Found {
    value: f64,
    steps: usize,
}

/// The mapping left the basin it was in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Leap {
    /// Distance between the two answers, in kernel lengths.
    pub lengths: f64,
    /// How much likelier the new answer is, nats.
    pub gain: f64,
}

impl Search {
    pub fn new(n: usize, q: usize, rank: usize, dim: usize) -> Self {
        let v = |len: usize| vec![0.0; len];
        Search {
            n,
            q,
            dim: dim as f64,
            reach: f64::INFINITY,
            pose: v(rank),
            beyond: 0.0,
            answer: v(q),
            warm: false,
            steps: 0,
            point: v(q),
            other: v(q),
            trial: v(q),
            gradient: v(q),
            trial_gradient: v(q),
            direction: v(q),
            turned: v(q),
            h: v(q * q),
            fisher: v(q * q),
            k_slopes: v(n * q),
            jacobian: v(q * rank),
            phi: v(n),
            k: v(n),
            w: v(n),
            by_w: v(n),
            by_k: v(n),
            residual: v(rank),
        }
    }

    /// Whether the workspace is that of a model of these sizes.
    pub fn fits(&self, n: usize, q: usize, rank: usize) -> bool {
        (self.n, self.q, self.pose.len()) == (n, q, rank)
    }

    /// Starts at key pose `nearest` and at the previous answer; keeps the likelier in `answer`. Says if that left
    /// the previous answer's basin.
    pub fn run(&mut self, side: &Posterior, latents: &[f64], nearest: usize, lambda: f64) -> Option<Leap> {
        let q = self.q;
        self.point.copy_from_slice(&latents[nearest * q..(nearest + 1) * q]);
        let fresh = self.descend(side, latents, lambda);
        self.steps = fresh.steps;
        let mut leap = None;
        if self.warm {
            self.other.copy_from_slice(&self.point);
            self.point.copy_from_slice(&self.answer);
            let kept = self.descend(side, latents, lambda);
            self.steps += kept.steps;
            let gain = kept.value - fresh.value;
            let lengths = distance_squared(&self.point, &self.other).sqrt() * side.kernel.theta2.sqrt();
            // Two starts of one basin end at one point but for the last digits; the previous answer stays then.
            if gain > 1e-6 && lengths > 1e-3 {
                leap = Some(Leap { lengths, gain });
                self.point.copy_from_slice(&self.other);
            }
        }
        self.answer.copy_from_slice(&self.point);
        self.warm = true;
        // `residual` is that of the last trial so far.
        self.trial.copy_from_slice(&self.answer);
        self.moments(side, latents);
        leap
    }

    /// Minimises from `point`, ends there.
    fn descend(&mut self, side: &Posterior, latents: &[f64], lambda: f64) -> Found {
        let q = self.q;
        self.trial.copy_from_slice(&self.point);
        let mut value = self.evaluate(side, latents, lambda);
        self.gradient.copy_from_slice(&self.trial_gradient);
        self.start_curvature(side, latents, lambda);
        let mut steps = 0;
        while steps < STEPS {
            matvec(&self.h, &self.gradient, &mut self.direction);
            let slope = -dot(&self.gradient, &self.direction);
            // Also ends when the curvature has lost its sign to rounding, or at NaN.
            if !(-slope > 2.0 * ENOUGH) {
                break;
            }
            steps += 1;
            let Some((next, step)) = self.line(side, latents, lambda, value, slope) else { break };
            value = next;
            // s = −step·H g, y = g' − g; H ← H + (1 + yᵀHy/sᵀy) s sᵀ/sᵀy − (H y sᵀ + s yᵀH)/sᵀy.
            for i in 0..q {
                self.point[i] = self.trial[i];
                self.direction[i] *= -step;
                let g = self.trial_gradient[i];
                self.trial_gradient[i] = g - self.gradient[i];
                self.gradient[i] = g;
            }
            let (s, y) = (&self.direction, &self.trial_gradient);
            let sy = dot(s, y);
            if sy > 1e-12 * (dot(s, s) * dot(y, y)).sqrt() {
                matvec(&self.h, y, &mut self.turned);
                let along = (1.0 + dot(y, &self.turned) / sy) / sy;
                for i in 0..q {
                    let row = &mut self.h[i * q..(i + 1) * q];
                    axpy(along * s[i] - self.turned[i] / sy, s, row);
                    axpy(-s[i] / sy, &self.turned, row);
                }
            }
        }
        Found { value, steps }
    }

    /// A step along −H g that keeps a part of the promised decrease; leaves point and gradient in `trial`.
    fn line(
        &mut self,
        side: &Posterior,
        latents: &[f64],
        lambda: f64,
        value: f64,
        slope: f64,
    ) -> Option<(f64, f64)> {
        let length = dot(&self.direction, &self.direction).sqrt();
        let mut step = (self.reach / length).min(1.0);
        for _ in 0..30 {
            for i in 0..self.q {
                self.trial[i] = self.point[i] - step * self.direction[i];
            }
            let next = self.evaluate(side, latents, lambda);
            if next <= value + 1e-4 * step * slope {
                return Some((next, step));
            }
            // Minimum of the parabola through value, slope and the new value, not too near either end.
            let parabola = -0.5 * slope * step * step / (next - value - slope * step);
            step = if parabola.is_finite() { parabola.clamp(0.1 * step, 0.5 * step) } else { 0.1 * step };
        }
        None
    }

    /// F and its gradient at `trial`.
    fn evaluate(&mut self, side: &Posterior, latents: &[f64], lambda: f64) -> f64 {
        let (q, rank) = (self.q, self.pose.len());
        let v = self.moments(side, latents);
        let misfit = dot(&self.residual, &self.residual) + self.beyond;
        // ∂F/∂w = −W(y − ȳ)/σ² + (|y − ȳ|²/σ⁴ − D/σ²) w; ∂F/∂k = L⁻ᵀ ∂F/∂w; ∂k_i/∂x = −θ2 φ_i (x − x_i).
        let shrink = misfit / (v * v) - self.dim / v;
        for ((g, w), row) in self.by_w.iter_mut().zip(&self.w).zip(side.whitened.chunks_exact(rank)) {
            *g = shrink * w - dot(row, &self.residual) / v;
        }
        side.unwhiten(&self.by_w, &mut self.by_k);
        let mut sum = 0.0;
        self.trial_gradient.fill(0.0);
        for (i, x) in latents.chunks_exact(q).enumerate() {
            let pull = side.kernel.theta2 * self.phi[i] * self.by_k[i];
            sum += pull;
            axpy(pull, x, &mut self.trial_gradient);
        }
        axpy(lambda - sum, &self.trial, &mut self.trial_gradient);
        0.5 * misfit / v + 0.5 * self.dim * v.ln() + 0.5 * lambda * dot(&self.trial, &self.trial)
    }

    /// φ, k, w, residual at `trial`; returns the variance.
    fn moments(&mut self, side: &Posterior, latents: &[f64]) -> f64 {
        let kernel = &side.kernel;
        for ((x, phi), k) in latents.chunks_exact(self.q).zip(&mut self.phi).zip(&mut self.k) {
            *phi = kernel.theta1 * (-0.5 * kernel.theta2 * distance_squared(&self.trial, x)).exp();
            *k = *phi + kernel.theta3;
        }
        side.whiten(&self.k, &mut self.w);
        side.mean(&self.w, &mut self.residual);
        for (r, y) in self.residual.iter_mut().zip(&self.pose) {
            *r = y - *r;
        }
        side.left(&self.w) + kernel.noise()
    }

    /// H = (Fisher information at `point`)⁻¹.
    fn start_curvature(&mut self, side: &Posterior, latents: &[f64], lambda: f64) {
        let (n, q, rank) = (self.n, self.q, self.pose.len());
        self.trial.copy_from_slice(&self.point);
        let v = self.moments(side, latents);
        // ∂w/∂x = L⁻¹ ∂k/∂x, N × q, then J = Wᵀ ∂w/∂x as rows of `jacobian` (q × rank); `turned`: ∇σ² = −2 wᵀ∂w/∂x.
        for (i, x) in latents.chunks_exact(q).enumerate() {
            let slope = -side.kernel.theta2 * self.phi[i];
            for a in 0..q {
                self.k_slopes[i * q + a] = slope * (self.trial[a] - x[a]);
            }
        }
        self.jacobian.fill(0.0);
        self.turned.fill(0.0);
        for i in (0..n).rev() {
            // In place from the last row up: row i needs only rows above it.
            side.whiten_row(i, &mut self.k_slopes, q);
            let slopes = &self.k_slopes[i * q..(i + 1) * q];
            axpy(-2.0 * self.w[i], slopes, &mut self.turned);
            let answer = &side.whitened[i * rank..(i + 1) * rank];
            for (s, row) in slopes.iter().zip(self.jacobian.chunks_exact_mut(rank)) {
                axpy(*s, answer, row);
            }
        }
        let mut trace = 0.0;
        for a in 0..q {
            for b in 0..=a {
                let (ja, jb) =
                    (&self.jacobian[a * rank..(a + 1) * rank], &self.jacobian[b * rank..(b + 1) * rank]);
                self.fisher[a * q + b] =
                    dot(ja, jb) / v + 0.5 * self.dim / (v * v) * self.turned[a] * self.turned[b];
            }
            trace += self.fisher[a * q + a];
        }
        // Without the prior, directions nothing depends on would have no curvature.
        let ridge = lambda.max(1e-6 * (1.0 + trace / q as f64));
        for a in 0..q {
            self.fisher[a * q + a] += ridge;
        }
        if cholesky(&mut self.fisher, q) {
            invert_lower(&self.fisher, q, &mut self.h);
            self.fisher.copy_from_slice(&self.h);
            gram_of_lower(&self.fisher, q, &mut self.h);
        } else {
            self.h.fill(0.0);
            for a in 0..q {
                self.h[a * q + a] = 1.0 / ridge;
            }
        }
    }
}

#[cfg(test)]
#[path = "search_tests.rs"]
mod tests;
