//! Marginal likelihood of examples over the logarithms of its numbers, with its gradient.
//!
//! −ln p(Y | X) = Σ over halves of ½ c tr(Yᵀ K⁻¹ Y) + ½ D (ln|K| + N ln 2π), with D all target coordinates and c = 2 for
//! examples with images (even targets are √2 Y after the change of coordinates), else 1. G = ½ (D K⁻¹ − c α αᵀ), α = K⁻¹ Y; the
//! derivative by a logarithm is the sum of G ∘ ∂K, and ∂K by ln σ_f², ln l, ln σ_n² is K_f, K_f ∘ r²/l², σ_n² I; by ln l of a group
//! K_f ∘ r_g²/l_g².
//!
//! One exponential for each two points and one for each point and image serve both halves, values and derivatives.

use crate::blocked::{Factor, gram_of_lower_less};
use crate::cloud::{Cloud, Squared};
use crate::dense::dot;
use crate::descend::Objective;
use crate::error::FitError;
use crate::examples::Examples;
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
    pub const fn new(from: f64, to: f64) -> Self {
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

/// Ranges of the logarithms; all lengths have one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ranges {
    pub signal: Range,
    pub length: Range,
    pub noise: Range,
}

/// What is minimised.
pub(crate) struct Evidence<'a> {
    targets: &'a Targets,
    /// Squared distances in each group of coordinates, N × N, own and to images.
    squared: Vec<Squared>,
    /// Their sums in units of the lengths, where there is more than one; lower triangle.
    sum: Squared,
    n: usize,
    ranges: Ranges,
    own: Vec<f64>,
    image: Vec<f64>,
    factor: Factor,
    inverse: Vec<f64>,
    alpha: Vec<f64>,
    /// G of each half.
    slopes: [Vec<f64>; 2],
}

impl<'a> Evidence<'a> {
    pub fn new(cloud: &Cloud, examples: &Examples, targets: &'a Targets, ranges: Ranges) -> Self {
        let n = cloud.len();
        let distances = |cloud: &Cloud| {
            let mut squared = Squared::default();
            cloud.squared(cloud.points(), n, &mut squared);
            squared
        };
        let groups = examples.groups().filter(|_| examples.group_count() > 1);
        let squared: Vec<Squared> = match groups {
            None => vec![distances(cloud)],
            Some(groups) => (0..examples.group_count())
                .map(|g| {
                    let keep = cloud.carry(|i| groups[i] == g);
                    if keep.contains(&true) { distances(&cloud.within(&keep)) } else { Squared::none(cloud) }
                })
                .collect(),
        };
        let sum = if squared.len() > 1 { Squared::none(cloud) } else { Squared::default() };
        Evidence {
            targets,
            squared,
            sum,
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

    /// Range of the logarithm with this number: σ_f², lengths, σ_n².
    fn range(&self, k: usize) -> Range {
        match k {
            0 => self.ranges.signal,
            k if k <= self.squared.len() => self.ranges.length,
            _ => self.ranges.noise,
        }
    }

    /// The kernel at the optimiser's numbers.
    pub fn kernel(&self, p: &[f64]) -> RbfKernel {
        let at = |k: usize| self.range(k).leave(p[k]).0.exp();
        let groups = self.squared.len();
        let lengths: Vec<f64> = (1..=groups).map(at).collect();
        let length = lengths.iter().copied().fold(f64::INFINITY, f64::min);
        let mut kernel = RbfKernel::isotropic(at(0), length, at(groups + 1));
        if groups > 1 {
            kernel.weights.iter_mut().zip(&lengths).for_each(|(w, l)| *w = length / l);
        }
        kernel
    }

    /// Length of a group.
    fn length(kernel: &RbfKernel, group: usize) -> f64 {
        kernel.length / kernel.weights[group]
    }

    /// The optimiser's numbers of a kernel.
    pub fn parameters(&self, kernel: &RbfKernel) -> Vec<f64> {
        let lengths = (0..self.squared.len()).map(|g| Self::length(kernel, g));
        std::iter::once(kernel.signal_variance)
            .chain(lengths)
            .chain([kernel.noise_variance])
            .enumerate()
            .map(|(k, v)| self.range(k).enter(v.ln()))
            .collect()
    }

    /// Sums the squared distances of all groups in units of their lengths.
    fn add_groups(&mut self, kernel: &RbfKernel) {
        let n = self.n;
        for (g, of) in self.squared.iter().enumerate() {
            let weight = Self::length(kernel, g).powi(-2);
            for (sum, part) in [(&mut self.sum.own, &of.own), (&mut self.sum.image, &of.image)] {
                for i in 0..part.len() / n {
                    let row = i * n..i * n + i + 1;
                    let sum = sum[row.clone()].iter_mut().zip(&part[row]);
                    if g == 0 {
                        sum.for_each(|(s, r)| *s = weight * r);
                    } else {
                        sum.for_each(|(s, r)| *s += weight * r);
                    }
                }
            }
        }
    }

    /// −ln p and its derivatives by ln σ_f², the logarithms of all lengths, ln σ_n².
    pub fn at(&mut self, kernel: &RbfKernel, with_gradient: bool) -> Result<(f64, Vec<f64>), FitError> {
        let n = self.n;
        let mirrored = !self.image.is_empty();
        let (squared, scale) = if self.squared.len() > 1 {
            self.add_groups(kernel);
            (&self.sum, -0.5)
        } else {
            (&self.squared[0], -0.5 / kernel.length.powi(2))
        };
        for i in 0..n {
            let row = i * n..i * n + i + 1;
            for (e, r) in self.own[row.clone()].iter_mut().zip(&squared.own[row.clone()]) {
                *e = kernel.signal_variance * (scale * r).exp();
            }
            self.own[i * n + i] = kernel.signal_variance;
            if mirrored {
                for (e, r) in self.image[row.clone()].iter_mut().zip(&squared.image[row]) {
                    *e = kernel.signal_variance * (scale * r).exp();
                }
            }
        }
        let all = self.targets.dimension() as f64;
        let mut value = 0.0;
        let mut by = vec![0.0; 2 + self.squared.len()];
        let last = by.len() - 1;
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
            by[last] += kernel.noise_variance * (0..n).map(|i| g[i * n + i]).sum::<f64>();
        }
        if with_gradient {
            self.sum_slopes(kernel, &mut by);
        }
        Ok((value, by))
    }

    /// Sums of G ∘ K_f, and of G ∘ K_f ∘ r²/l² of each group, over the symmetric matrices. G of the halves becomes G ∘ K_f of points and of
    /// images.
    fn sum_slopes(&mut self, kernel: &RbfKernel, by: &mut [f64]) {
        let n = self.n;
        let [first, second] = &mut self.slopes;
        let mut signal = 0.0;
        for i in 0..n {
            let (row, diagonal) = (i * n..i * n + i, i * n + i);
            let (g, own) = (&mut first[row.start..=diagonal], &self.own[row.start..=diagonal]);
            if self.image.is_empty() {
                g.iter_mut().zip(own).for_each(|(g, k)| *g *= k);
                signal += 2.0 * g[..i].iter().sum::<f64>() + g[i];
                continue;
            }
            let (h, image) = (&mut second[row.start..=diagonal], &self.image[row.start..=diagonal]);
            let mut sum = 0.0;
            for k in 0..=i {
                let (a, b) = ((g[k] + h[k]) * own[k], (g[k] - h[k]) * image[k]);
                (g[k], h[k]) = (a, b);
                sum += a + b;
            }
            signal += 2.0 * sum - (g[i] + h[i]);
        }
        by[0] = signal;
        for (group, of) in self.squared.iter().enumerate() {
            let mut length = 0.0;
            for i in 0..n {
                let row = i * n..i * n + i;
                length += 2.0 * dot(&first[row.clone()], &of.own[row.clone()]);
                if !self.image.is_empty() {
                    let diagonal = i * n + i;
                    length += 2.0 * dot(&second[row.clone()], &of.image[row])
                        + second[diagonal] * of.image[diagonal];
                }
            }
            by[1 + group] = length / Self::length(kernel, group).powi(2);
        }
    }
}

impl Objective for Evidence<'_> {
    fn evaluate(&mut self, p: &[f64], gradient: &mut [f64]) -> Result<f64, FitError> {
        let kernel = self.kernel(p);
        let (value, by) = self.at(&kernel, true)?;
        for (k, (g, by)) in gradient.iter_mut().zip(&by).enumerate() {
            *g = by * self.range(k).leave(p[k]).1;
        }
        Ok(value)
    }
}
