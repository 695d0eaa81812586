//! Marginal likelihood of examples over the three logarithms, with its gradient.
//!
//! −ln p(Y | X) = Σ over halves of ½ c tr(Yᵀ K⁻¹ Y) + ½ D (ln|K| + N ln 2π), with D all target coordinates and c = 2 for
//! examples with images (even targets are √2 Y after the change of coordinates), else 1. G = ½ (D K⁻¹ − c α αᵀ), α = K⁻¹ Y; the
//! derivative by a logarithm is the sum of G ∘ ∂K, and ∂K by ln σ_f², ln l, ln σ_n² is K_f, K_f ∘ r²/l², σ_n² I.
//!
//! One exponential for each two points and one for each point and image serve both halves, values and derivatives.

use crate::blocked::{Factor, gram_of_lower_less};
use crate::cloud::{Cloud, Squared};
use crate::dense::dot;
use crate::descend::Objective;
use crate::error::FitError;
use crate::parity::Sign;
use crate::rbf::RbfKernel;
use crate::rbf::targets::Targets;

/// Range of a logarithm, entered by a sine: the optimiser's number has no bounds, and its slope in the middle is one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Range {
    middle: f64,
    half: f64,
}

impl Range {
    /// From and to.
    pub fn new(from: f64, to: f64) -> Self {
        Range { middle: 0.5 * (from + to), half: 0.5 * (to - from) }
    }

    /// The logarithm at `u`, and its slope.
    fn leave(self, u: f64) -> (f64, f64) {
        if self.half <= 0.0 {
            return (self.middle, 0.0);
        }
        let a = u / self.half;
        (self.middle + self.half * a.sin(), a.cos())
    }

    /// The number of a logarithm; a little inside, since the slope at the bounds is zero.
    fn enter(self, value: f64) -> f64 {
        if self.half <= 0.0 {
            return 0.0;
        }
        let s = ((value - self.middle) / self.half).clamp(-0.99, 0.99);
        self.half * s.asin()
    }
}

/// What is minimised.
pub(crate) struct Evidence<'a> {
    targets: &'a Targets,
    /// Squared distances, N × N, own and to images.
    squared: Squared,
    n: usize,
    ranges: [Range; 3],
    own: Vec<f64>,
    image: Vec<f64>,
    factor: Factor,
    inverse: Vec<f64>,
    alpha: Vec<f64>,
    /// G of each half.
    slopes: [Vec<f64>; 2],
}

impl<'a> Evidence<'a> {
    pub fn new(cloud: &Cloud, targets: &'a Targets, ranges: [Range; 3]) -> Self {
        let n = cloud.len();
        let mut squared = Squared::default();
        cloud.squared(cloud.points(), n, &mut squared);
        Evidence {
            targets,
            squared,
            n,
            ranges,
            own: vec![0.0; n * n],
            image: vec![0.0; if cloud.mirrored() { n * n } else { 0 }],
            factor: Factor::default(),
            inverse: Vec::new(),
            alpha: Vec::new(),
            slopes: [Vec::new(), Vec::new()],
        }
    }

    /// The kernel at the optimiser's numbers.
    pub fn kernel(&self, p: &[f64]) -> RbfKernel {
        let at = |k: usize| self.ranges[k].leave(p[k]).0.exp();
        RbfKernel { signal_variance: at(0), length: at(1), noise_variance: at(2) }
    }

    /// The optimiser's numbers of a kernel.
    pub fn parameters(&self, kernel: &RbfKernel) -> Vec<f64> {
        let values = [kernel.signal_variance, kernel.length, kernel.noise_variance];
        self.ranges.iter().zip(values).map(|(r, v)| r.enter(v.ln())).collect()
    }

    /// −ln p and its derivatives by ln σ_f², ln l, ln σ_n².
    pub fn at(&mut self, kernel: &RbfKernel, with_gradient: bool) -> Result<(f64, [f64; 3]), FitError> {
        let n = self.n;
        let scale = -0.5 / kernel.length.powi(2);
        let mirrored = !self.image.is_empty();
        for i in 0..n {
            let row = i * n..i * n + i + 1;
            for (e, r) in self.own[row.clone()].iter_mut().zip(&self.squared.own[row.clone()]) {
                *e = kernel.signal_variance * (scale * r).exp();
            }
            self.own[i * n + i] = kernel.signal_variance;
            if mirrored {
                for (e, r) in self.image[row.clone()].iter_mut().zip(&self.squared.image[row]) {
                    *e = kernel.signal_variance * (scale * r).exp();
                }
            }
        }
        let all = self.targets.dimension() as f64;
        let mut value = 0.0;
        let mut by = [0.0; 3];
        for (which, part) in self.targets.parts.iter().enumerate() {
            let (own, image, sign) = (&self.own, &self.image, part.sign);
            let fill = |k: &mut [f64]| {
                for i in 0..n {
                    let row = i * n..i * n + i + 1;
                    match sign {
                        Sign::Only => k[row.clone()].copy_from_slice(&own[row]),
                        _ => {
                            for (k, (a, b)) in
                                k[row.clone()].iter_mut().zip(own[row.clone()].iter().zip(&image[row]))
                            {
                                *k = sign.join(*a, *b);
                            }
                        }
                    }
                    k[i * n + i] += kernel.noise_variance;
                }
            };
            if !self.factor.renew(n, fill) {
                return Err(super::not_definite(kernel));
            }
            self.alpha.clear();
            self.alpha.extend_from_slice(&part.values);
            self.factor.solve_lower(&mut self.alpha, part.columns);
            let weight = 1.0 / part.sign.share();
            value += 0.5 * weight * dot(&self.alpha, &self.alpha)
                + 0.5 * all * (self.factor.ln_det() + n as f64 * (2.0 * std::f64::consts::PI).ln());
            if !with_gradient {
                continue;
            }
            self.factor.solve_upper(&mut self.alpha, part.columns);
            self.factor.invert(&mut self.inverse);
            let g = &mut self.slopes[which];
            gram_of_lower_less(&self.inverse, n, 0.5 * all, &self.alpha, part.columns, 0.5 * weight, g);
            by[2] += kernel.noise_variance * (0..n).map(|i| g[i * n + i]).sum::<f64>();
        }
        if with_gradient {
            self.sum_slopes(kernel, &mut by);
        }
        Ok((value, by))
    }

    /// Sums of G ∘ K_f and G ∘ K_f ∘ r²/l² over the symmetric matrices.
    fn sum_slopes(&self, kernel: &RbfKernel, by: &mut [f64; 3]) {
        let n = self.n;
        let (mut signal, mut length) = (0.0, 0.0);
        for i in 0..n {
            let row = i * n..i * n + i;
            let g = &self.slopes[0][row.clone()];
            let (own, r) = (&self.own[row.clone()], &self.squared.own[row.clone()]);
            let diagonal = i * n + i;
            if self.image.is_empty() {
                signal += 2.0 * dot(g, own) + self.slopes[0][diagonal] * self.own[diagonal];
                length += 2.0 * g.iter().zip(own.iter().zip(r)).map(|(g, (e, r))| g * e * r).sum::<f64>();
                continue;
            }
            let h = &self.slopes[1][row.clone()];
            let (image, s) = (&self.image[row.clone()], &self.squared.image[row]);
            let (mut a, mut b) = (0.0, 0.0);
            for k in 0..i {
                let own = (g[k] + h[k]) * own[k];
                let image = (g[k] - h[k]) * image[k];
                a += own + image;
                b += own * r[k] + image * s[k];
            }
            let (g, h) = (self.slopes[0][diagonal], self.slopes[1][diagonal]);
            let image = (g - h) * self.image[diagonal];
            signal += 2.0 * a + (g + h) * self.own[diagonal] + image;
            length += 2.0 * b + image * self.squared.image[diagonal];
        }
        by[0] = signal;
        by[1] = length / kernel.length.powi(2);
    }
}

impl Objective for Evidence<'_> {
    fn evaluate(&mut self, p: &[f64], gradient: &mut [f64]) -> Result<f64, FitError> {
        let kernel = self.kernel(p);
        let (value, by) = self.at(&kernel, true)?;
        for k in 0..3 {
            gradient[k] = by[k] * self.ranges[k].leave(p[k]).1;
        }
        Ok(value)
    }
}
