//! Mapping a pose: the latent point that best explains it, YAH10 (5).
//!
//! Minimises F(x) = |y − ȳ(x)|²/(2σ²(x)) + (D/2) ln σ²(x) + (λ/2)|x|² over x, with posterior mean ȳ = Wᵀw
//! and variance σ² = k(x, x) − |w|² of the input space, w = L⁻¹k(x) (`posterior`); λ is 1 with the prior X ~
//! N(0, I), 0 without. Poses are held in the N coordinates of the span of the key poses; what a pose has
//! beyond that span cannot be explained and is a constant in |y − ȳ|².
//!
//! Quasi-Newton steps (BFGS) that start from the inverse of the exact second derivatives and look at them
//! again every few steps: the curvatures of 30 latent directions differ a thousandfold and change with σ² on
//! the way. Two starts: the previous answer, and the latent point of the nearest key pose, whose search ends
//! early when it comes to where the first one ended. No allocation after [`Search::new`].

use crate::dense::{axpy, cholesky, distance_squared, dot, gram_of_lower, invert_lower, matvec};
use crate::posterior::Posterior;

/// Steps of one search.
const STEPS: usize = 100;
/// Steps between two looks at the second derivatives.
const REFRESH: usize = 12;
/// Longest step, in units of the RMS distance of the key poses from the origin of the latent space. Near a
/// key pose the variance is a thousandth of what it is where nothing is known; a longer step can end out
/// there, on a plain where everything is explained by ignorance.
const REACH: f64 = 0.4;
/// Answers closer than this, in kernel lengths, are no jump: every key pose makes a dimple of its own in the
/// variance, some √(noise/θ1) wide, and a path may fall in and out of it without anyone seeing.
const VISIBLE: f64 = 0.02;
/// Expected gain of a further step, in nats, at which a search ends: a step of 10⁻⁵ posterior standard
/// deviations.
const ENOUGH: f64 = 1e-10;

/// Workspace of the mapping of one pose after another.
#[derive(Clone, Debug)]
pub(crate) struct Search {
    n: usize,
    q: usize,
    /// Coordinates of a pose, D.
    dim: f64,
    /// Longest step.
    reach: f64,
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
    trial: Vec<f64>,
    gradient: Vec<f64>,
    trial_gradient: Vec<f64>,
    direction: Vec<f64>,
    turned: Vec<f64>,
    h: Vec<f64>,
    fisher: Vec<f64>,
    hessian: Vec<f64>,
    /// Factor of ∂²F/∂x² about `answer`.
    metric: Vec<f64>,
    slopes: Vec<f64>,
    jacobian: Vec<f64>,
    phi: Vec<f64>,
    k: Vec<f64>,
    w: Vec<f64>,
    by_w: Vec<f64>,
    by_k: Vec<f64>,
    /// y − ȳ(x) in the span of the key poses.
    pub residual: Vec<f64>,
}

/// The search from the key pose ended in a likelier minimum than that from the previous answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BasinChange {
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
            trial: v(q),
            gradient: v(q),
            trial_gradient: v(q),
            direction: v(q),
            turned: v(q),
            h: v(q * q),
            fisher: v(q * q),
            hessian: v(q * q),
            metric: v(q * q),
            slopes: v(n * q),
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

    /// Starts at the previous answer and at key pose `nearest`; keeps the likelier in `answer`. Says if that
    /// left the previous answer's basin.
    pub fn run(
        &mut self,
        side: &Posterior,
        latents: &[f64],
        nearest: usize,
        lambda: f64,
    ) -> Option<BasinChange> {
        let q = self.q;
        self.steps = 0;
        self.reach = REACH * (dot(latents, latents) / self.n as f64).sqrt();
        let mut kept = None;
        if self.warm {
            self.point.copy_from_slice(&self.answer);
            kept = self.descend(side, latents, lambda, false);
            self.answer.copy_from_slice(&self.point);
            std::mem::swap(&mut self.metric, &mut self.hessian);
        }
        self.point.copy_from_slice(&latents[nearest * q..(nearest + 1) * q]);
        let fresh = self.descend(side, latents, lambda, kept.is_some());
        let mut change = None;
        match (kept, fresh) {
            (Some(kept), Some(fresh)) => {
                let gain = kept - fresh;
                let lengths = distance_squared(&self.point, &self.answer).sqrt() * side.kernel.theta2.sqrt();
                // a smaller gain is rounding: both searches ended in the same minimum
                if gain > 1e-6 {
                    self.answer.copy_from_slice(&self.point);
                    change = (lengths > VISIBLE).then_some(BasinChange { lengths, gain });
                }
            }
            (None, Some(_)) => self.answer.copy_from_slice(&self.point),
            // The search from the key pose came into the basin of the previous answer.
            (_, None) => {}
        }
        self.warm = true;
        // `residual` is still that of the last trial point: evaluate it at the answer
        self.trial.copy_from_slice(&self.answer);
        self.moments(side, latents);
        change
    }

    /// Whether `point` is within a tenth of a standard deviation of `answer`, by the curvature there.
    fn reached_answer(&self) -> bool {
        let q = self.q;
        // |Lᵀ(x − x̂)|² with L Lᵀ = ∂²F/∂x².
        let mut sum = 0.0;
        for a in 0..q {
            let mut s = 0.0;
            for b in a..q {
                s += self.metric[b * q + a] * (self.point[b] - self.answer[b]);
            }
            sum += s * s;
            if sum > 1e-2 {
                return false;
            }
        }
        true
    }

    /// Minimises from `point`, ends there; returns F. With `beside` it stops when it comes to `answer`: `None`.
    fn descend(&mut self, side: &Posterior, latents: &[f64], lambda: f64, beside: bool) -> Option<f64> {
        let q = self.q;
        self.trial.copy_from_slice(&self.point);
        let mut value = self.evaluate(side, latents, lambda);
        self.gradient.copy_from_slice(&self.trial_gradient);
        self.curvature(side, latents, lambda);
        // steps since the second derivatives were computed
        let mut age = 0;
        let mut steps = 0;
        while steps < STEPS {
            matvec(&self.h, &self.gradient, &mut self.direction);
            let slope = -dot(&self.gradient, &self.direction);
            // true also where rounding has made the slope positive
            let done = -slope <= 2.0 * ENOUGH;
            let old = age == REFRESH;
            let moved = if done || old { None } else { self.line(side, latents, lambda, value, slope) };
            if age > 0 && moved.is_none() {
                // the step failed with second derivatives from earlier steps: compute them here before giving up
                age = 0;
                self.curvature(side, latents, lambda);
                continue;
            }
            let Some((next, step)) = moved else { break };
            age += 1;
            steps += 1;
            self.steps += 1;
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
            if beside && self.reached_answer() {
                return None;
            }
        }
        Some(value)
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

    /// H = (∂²F/∂x²)⁻¹ at `point`; where that is not positive definite, the inverse of the Fisher information.
    fn curvature(&mut self, side: &Posterior, latents: &[f64], lambda: f64) {
        let (n, q, rank) = (self.n, self.q, self.pose.len());
        self.trial.copy_from_slice(&self.point);
        self.evaluate(side, latents, lambda);
        let v = side.left(&self.w) + side.kernel.noise();
        let misfit = dot(&self.residual, &self.residual) + self.beyond;
        let shrink = misfit / (v * v) - self.dim / v;
        self.hessian.fill(0.0);
        // Σ_i ∂F/∂k_i ∂²k_i/∂x², ∂²k_i/∂x² = θ2 φ_i (θ2 δδᵀ − I), δ = x − x_i; and ∂k/∂x (N × q).
        let mut bend = 0.0;
        for (i, x) in latents.chunks_exact(q).enumerate() {
            let slope = side.kernel.theta2 * self.phi[i];
            let delta = &mut self.slopes[i * q..(i + 1) * q];
            delta.iter_mut().zip(self.trial.iter().zip(x)).for_each(|(d, (t, x))| *d = t - x);
            let pull = slope * self.by_k[i];
            bend += pull;
            add_square(pull * side.kernel.theta2, delta, &mut self.hessian);
            delta.iter_mut().for_each(|d| *d *= -slope);
        }
        // ∂w/∂x = L⁻¹ ∂k/∂x in place from the last row up; J = Wᵀ ∂w/∂x as rows of `jacobian` (q × rank);
        // `turned`: −½ ∇σ² = (∂w/∂x)ᵀ w.
        self.jacobian.fill(0.0);
        self.turned.fill(0.0);
        for i in (0..n).rev() {
            side.whiten_row(i, &mut self.slopes, q);
            let slopes = &self.slopes[i * q..(i + 1) * q];
            axpy(self.w[i], slopes, &mut self.turned);
            add_square(shrink, slopes, &mut self.hessian);
            let answer = &side.whitened[i * rank..(i + 1) * rank];
            for (s, row) in slopes.iter().zip(self.jacobian.chunks_exact_mut(rank)) {
                axpy(*s, answer, row);
            }
        }
        matvec(&self.jacobian, &self.residual, &mut self.direction);
        let (fit, volume) = (&self.direction, &self.turned);
        let along = 4.0 * misfit / (v * v * v) - 2.0 * self.dim / (v * v);
        let mut trace = 0.0;
        for a in 0..q {
            let row = &self.jacobian[a * rank..(a + 1) * rank];
            for b in 0..=a {
                let mean = dot(row, &self.jacobian[b * rank..(b + 1) * rank]) / v;
                self.fisher[a * q + b] = mean + 2.0 * self.dim / (v * v) * volume[a] * volume[b];
                self.hessian[a * q + b] += mean - 2.0 / (v * v) * (fit[a] * volume[b] + volume[a] * fit[b])
                    + along * volume[a] * volume[b];
            }
            trace += self.fisher[a * q + a];
        }
        // Without the prior, directions nothing depends on would have no curvature.
        let ridge = lambda.max(1e-6 * (1.0 + trace / q as f64));
        for a in 0..q {
            self.fisher[a * q + a] += ridge;
            self.hessian[a * q + a] += ridge - bend;
        }
        if !cholesky(&mut self.hessian, q) {
            cholesky(&mut self.fisher, q);
            self.hessian.copy_from_slice(&self.fisher);
        }
        invert_lower(&self.hessian, q, &mut self.fisher);
        gram_of_lower(&self.fisher, q, &mut self.h);
    }
}

/// Adds c a aᵀ to the lower triangle of `m`.
fn add_square(c: f64, a: &[f64], m: &mut [f64]) {
    for (i, row) in m.chunks_exact_mut(a.len()).enumerate() {
        axpy(c * a[i], &a[..=i], &mut row[..=i]);
    }
}

#[cfg(test)]
#[path = "search_tests.rs"]
mod tests;
