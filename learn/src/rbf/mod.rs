//! Gaussian process regression of examples: an isotropic radial basis function and noise, three numbers shared by all targets.
//!
//! k(x, x') = σ_f² exp(−|x − x'|²/(2 l²)) + σ_n² δ [IAF09 §4.3]. The prior mean is zero: targets are differences, and far from the
//! examples nothing is changed. One kernel for all target coordinates, so one factorisation serves all; with a mirror
//! two of half the size ([`crate::examples`]).
//!
//! **Learning.** (σ_f², l, σ_n²) maximise the marginal likelihood by L-BFGS over their logarithms. It starts at
//! σ_f² = s², σ_n² = s²/100, l = the median distance of the inputs, with s² the mean square of the targets: IAF09's 0, 0, ln √0.01 in
//! the units of the data. Ranges: σ_f² from 10⁻⁶ to 10³ s²; σ_n² from 10⁻⁷ to 10 s²; l from 1/1000 of the
//! diameter of the examples (largest distance between two of them or their images) to the diameter. Without an upper bound of l
//! a rule that is the same everywhere has a likelihood that grows with l without an end, and the edit would be
//! carried to whatever motion comes.
//!
//! **What is not learned.** Targets that are all zero (root mean square below 10⁻⁹): the likelihood has no bound as both
//! variances go to 0. The kernel is then the start with s² = 1, the mean is zero everywhere, the variance small near the examples. Inputs
//! all at one place, one example among them: nothing tells l. The kernel is the start with l a tenth of the input's
//! distance from zero (1 if that is zero): the mean of the targets there, slightly shrunk, and nothing farther away.
//!
//! **Many examples.** Beyond [`RbfOptions::exact_up_to`], images counted, the kernel is learned from an even choice of that many and
//! all examples enter through inducing points, the farthest of each other (DTC): O(N M²).
//!
//! [IAF09] Ikemoto, Arikan, Forsyth. Generalizing motion edits with Gaussian processes. ACM TOG 28(1), 2009.

mod evidence;
mod half;

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::blocked::{Factor, multiply, transposed, view};
use crate::cloud::{CHUNK, Cloud, Extent, Squared};
use crate::dense::dot;
use crate::descend::descend;
use crate::error::{FitError, InputError};
use crate::examples::Examples;
use crate::gplvm::Learning;
use crate::parity::Parity;
use crate::regressor::{Prediction, Scratch};
use evidence::{Evidence, Range};
use half::{Half, Sign, Sparse};

/// Root mean square of targets below which they count as zero.
const ZERO: f64 = 1e-9;
/// Least σ_n²/s².
const NOISE: (f64, f64) = (1e-7, 10.0);
/// Range of σ_f²/s².
const SIGNAL: (f64, f64) = (1e-6, 1e3);
/// Least l over the diameter.
const LENGTH: f64 = 1e-3;
/// Part of s² that is noise at the start.
const START_NOISE: f64 = 0.01;
/// Between inducing points the diagonal has this part of σ_f² more: they have no noise of their own.
const JITTER: f64 = 1e-10;

/// The three numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RbfKernel {
    /// σ_f², squared units of the targets.
    pub signal_variance: f64,
    /// l, units of the inputs.
    pub length: f64,
    /// σ_n², squared units of the targets.
    pub noise_variance: f64,
}

impl RbfKernel {
    fn check(&self) -> Result<(), FitError> {
        for (name, value) in [
            ("signal_variance", self.signal_variance),
            ("length", self.length),
            ("noise_variance", self.noise_variance),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(FitError::Setting { name, value, allowed: "positive".into() });
            }
        }
        Ok(())
    }

    /// Turns a squared distance into σ_f² exp(−r²/(2 l²)).
    fn of(&self, squared: &mut [f64]) {
        let scale = -0.5 / self.length.powi(2);
        squared.iter_mut().for_each(|v| *v = self.signal_variance * (scale * *v).exp());
    }
}

/// How a kernel is learned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RbfOptions {
    /// L-BFGS iterations, at most; 0 keeps the start.
    pub iterations: usize,
    /// Takes the mean of the targets away first and adds it to every prediction: far from the examples the mean returns
    /// instead of zero. For targets that are no differences.
    pub centre: bool,
    /// This kernel, not learned.
    pub kernel: Option<RbfKernel>,
    /// Most examples, images counted, that are taken as they are; more enter through inducing points.
    pub exact_up_to: usize,
    /// Inducing points, images not counted.
    pub inducing: usize,
}

impl Default for RbfOptions {
    fn default() -> Self {
        RbfOptions { iterations: 100, centre: false, kernel: None, exact_up_to: 3000, inducing: 750 }
    }
}

/// Targets in even and odd coordinates.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Targets {
    parity: Parity,
    /// Taken away from the targets: even coordinates, then odd ones (zero).
    centre: Vec<f64>,
    pub parts: Vec<Part>,
}

/// The targets of one half.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Part {
    pub sign: Sign,
    pub first: usize,
    pub columns: usize,
    /// N × columns, row-major.
    pub values: Vec<f64>,
}

impl Targets {
    fn of(examples: &Examples, centre: bool) -> Self {
        let y = examples.targets();
        let (n, d) = y.shape();
        let parity = Parity::of(examples.mirror().map(|m| m.output.as_slice()), d);
        let mut mean = vec![0.0; d];
        if centre {
            let mut row = vec![0.0; d];
            for i in 0..n {
                parity.enter(|k| y[(i, k)], &mut row);
                mean[..parity.even].iter_mut().zip(&row).for_each(|(m, v)| *m += v / n as f64);
            }
        }
        Targets::about(examples, parity, mean)
    }

    /// About a centre that is known.
    fn about(examples: &Examples, parity: Parity, centre: Vec<f64>) -> Self {
        let y = examples.targets();
        let (n, d) = y.shape();
        let even = parity.even;
        let part = |sign, first, columns| Part { sign, first, columns, values: vec![0.0; n * columns] };
        let mut parts = if examples.mirror().is_some() {
            vec![part(Sign::Even, 0, even), part(Sign::Odd, even, d - even)]
        } else {
            vec![part(Sign::Only, 0, d)]
        };
        let mut row = vec![0.0; d];
        for i in 0..n {
            parity.enter(|k| y[(i, k)], &mut row);
            row.iter_mut().zip(&centre).for_each(|(v, c)| *v -= c);
            for p in &mut parts {
                p.values[i * p.columns..(i + 1) * p.columns]
                    .copy_from_slice(&row[p.first..p.first + p.columns]);
            }
        }
        Targets { parity, centre, parts }
    }

    /// Coordinates D_y.
    pub fn dimension(&self) -> usize {
        self.parity.len()
    }

    /// Mean square of all values.
    fn mean_square(&self) -> f64 {
        let (sum, count) = self.parts.iter().fold((0.0, 0), |(s, c), p| {
            (s + p.values.iter().map(|v| v * v).sum::<f64>(), c + p.values.len())
        });
        sum / count as f64
    }
}

/// Predictions for many inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// F × D_y.
    pub mean: DMatrix<f64>,
    /// Variance of every coordinate of a target about the mean, noise included, squared units of the targets; one an input.
    pub variance: Vec<f64>,
    /// Distance to the nearest example (or image) over the spacing of the examples: above 1, 99 % of the examples are nearer to
    /// each other than this input is to any. Neighbours in time and repetitions do not count for the spacing
    /// ([`Examples::with_moments`]).
    pub novelty: Vec<f64>,
    /// From 0, nothing is known, to 1.
    pub confidence: Vec<f64>,
}

impl Batch {
    pub(crate) fn empty(rows: usize, columns: usize) -> Self {
        Batch {
            mean: DMatrix::zeros(rows, columns),
            variance: vec![0.0; rows],
            novelty: vec![0.0; rows],
            confidence: vec![0.0; rows],
        }
    }
}

/// What each example would be predicted to be from the others.
#[derive(Clone, Debug, PartialEq)]
pub struct LeaveOneOut {
    /// N × D_y: target less the prediction without the example and its image.
    pub residual: DMatrix<f64>,
    /// Variance of that prediction, noise included.
    pub variance: Vec<f64>,
}

/// A fitted regression.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Stored", into = "Stored")]
pub struct RbfRegression {
    examples: Examples,
    options: RbfOptions,
    kernel: RbfKernel,
    learning: Learning,
    log_likelihood: f64,
    cloud: Cloud,
    extent: Extent,
    /// Inducing points; none if the examples are taken as they are.
    inducing: Option<Inducing>,
    targets: Targets,
    halves: Vec<Half>,
}

#[derive(Clone, Debug, PartialEq)]
struct Inducing {
    cloud: Cloud,
    /// Largest distance of an example from the nearest of them.
    reach: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "RbfRegression", deny_unknown_fields)]
struct Stored {
    examples: Examples,
    options: RbfOptions,
    kernel: RbfKernel,
    learning: Learning,
}

impl From<RbfRegression> for Stored {
    fn from(m: RbfRegression) -> Self {
        Stored { examples: m.examples, options: m.options, kernel: m.kernel, learning: m.learning }
    }
}

impl TryFrom<Stored> for RbfRegression {
    type Error = FitError;

    fn try_from(s: Stored) -> Result<Self, FitError> {
        s.kernel.check()?;
        RbfRegression::with_kernel(s.examples, s.options, s.kernel, s.learning)
    }
}

impl RbfRegression {
    /// Learns a kernel from examples.
    ///
    /// # Errors
    /// Settings out of range; a kernel matrix that does not factor.
    pub fn fit(examples: &Examples, options: &RbfOptions) -> Result<Self, FitError> {
        if options.inducing == 0 {
            let allowed = "at least 1".into();
            return Err(FitError::Setting { name: "inducing", value: 0.0, allowed });
        }
        let (kernel, learning) = match options.kernel {
            Some(kernel) => {
                kernel.check()?;
                (kernel, unlearned("the kernel was given"))
            }
            None if examples.effective() <= options.exact_up_to => learn(examples, options)?,
            None => {
                let most = options.exact_up_to.max(2) * examples.len() / examples.effective();
                let most = most.max(1);
                let keep: Vec<usize> = (0..most).map(|i| i * examples.len() / most).collect();
                learn(&examples.subset(&keep)?, options)?
            }
        };
        RbfRegression::with_kernel(examples.clone(), options.clone(), kernel, learning)
    }

    fn with_kernel(
        examples: Examples,
        options: RbfOptions,
        kernel: RbfKernel,
        learning: Learning,
    ) -> Result<Self, FitError> {
        let cloud = Cloud::of(&examples);
        let extent = cloud.extent(&examples);
        let targets = Targets::of(&examples, options.centre);
        let inducing = (examples.effective() > options.exact_up_to).then(|| {
            let (chosen, reach) = cloud.farthest(options.inducing);
            Inducing { cloud: cloud.subset(&chosen), reach }
        });
        let halves = match &inducing {
            None => exact(&cloud, &targets, &kernel)?,
            Some(inducing) => through(&inducing.cloud, &cloud, &targets, &kernel)?,
        };
        let mut model = RbfRegression {
            examples,
            options,
            kernel,
            learning,
            log_likelihood: 0.0,
            cloud,
            extent,
            inducing,
            targets,
            halves,
        };
        model.log_likelihood = model.likelihood();
        Ok(model)
    }

    /// The examples it was fitted to.
    pub fn examples(&self) -> &Examples {
        &self.examples
    }

    /// The kernel.
    pub fn kernel(&self) -> RbfKernel {
        self.kernel
    }

    /// σ_n², squared units of the targets.
    pub fn noise(&self) -> f64 {
        self.kernel.noise_variance
    }

    /// How it was fitted.
    pub fn options(&self) -> &RbfOptions {
        &self.options
    }

    /// How learning went.
    pub fn learning(&self) -> &Learning {
        &self.learning
    }

    /// Number of inducing points; `None` if the examples are taken as they are.
    pub fn inducing(&self) -> Option<usize> {
        self.inducing.as_ref().map(|i| i.cloud.len())
    }

    /// ln p(targets | inputs), images counted as examples of their own; with inducing points that of the approximation.
    pub fn log_likelihood(&self) -> f64 {
        self.log_likelihood
    }

    /// Largest distance between two examples or images, units of the inputs: the upper bound of the length.
    pub fn diameter(&self) -> f64 {
        self.extent.diameter
    }

    /// The distance that is novelty 1, units of the inputs.
    pub fn spacing(&self) -> f64 {
        self.extent.spacing
    }

    /// What kernels are taken to.
    fn basis(&self) -> &Cloud {
        self.inducing.as_ref().map_or(&self.cloud, |i| &i.cloud)
    }

    /// Predicts the rows of `inputs` (F × D_x). A row's answer does not depend on the other rows, to the bit; it is that
    /// of [`RbfRegression::predict`] to rounding.
    ///
    /// # Errors
    /// A wrong number of coordinates, or one that is not finite.
    pub fn predict_batch(&self, inputs: &DMatrix<f64>) -> Result<Batch, InputError> {
        let (rows, d) = (inputs.nrows(), self.targets.dimension());
        let mut out = Batch::empty(rows, d);
        let (mut row, mut x) = (Vec::new(), Vec::new());
        let (mut squared, mut near) = (Squared::default(), Squared::default());
        let (mut k, mut second, mut mean) = (Vec::new(), Vec::new(), Vec::new());
        let (mut parts, mut back) = (vec![0.0; CHUNK * d], vec![0.0; d]);
        let dim = self.cloud.dim();
        for from in (0..rows).step_by(CHUNK) {
            let count = self.cloud.enter_chunk(inputs, from, &mut row, &mut x)?;
            self.basis().squared(&x, CHUNK, &mut squared);
            let distances = if self.inducing.is_some() {
                self.cloud.squared(&x, CHUNK, &mut near);
                &near
            } else {
                &squared
            };
            for i in 0..count {
                let nearest = self.cloud.nearest(distances, i, CHUNK, &x[i * dim..(i + 1) * dim]);
                out.novelty[from + i] = nearest / self.extent.spacing;
            }
            self.kernel.of(&mut squared.own);
            self.kernel.of(&mut squared.image);
            let mut known = [0.0; CHUNK];
            for half in &self.halves {
                join(half.sign, &squared, &mut k);
                half.whiten(&mut k, CHUNK, &mut second);
                half.answer(&k, &second, CHUNK, &mut mean, &mut known);
                for (p, m) in parts.chunks_exact_mut(d).zip(mean.chunks_exact(half.columns.max(1))) {
                    p[half.first..half.first + half.columns].copy_from_slice(&m[..half.columns]);
                }
            }
            for i in 0..count {
                self.leave(&mut parts[i * d..(i + 1) * d], &mut back);
                for (k, v) in back.iter().enumerate() {
                    out.mean[(from + i, k)] = *v;
                }
                (out.variance[from + i], out.confidence[from + i]) = self.doubt(known[i]);
            }
        }
        Ok(out)
    }

    /// Predicts one input (D_x) into `out`; allocates nothing once `scratch` and `out` have been used with this model.
    ///
    /// # Errors
    /// As [`RbfRegression::predict_batch`].
    pub fn predict(
        &self,
        input: &[f64],
        scratch: &mut Scratch,
        out: &mut Prediction,
    ) -> Result<(), InputError> {
        let (n, d) = (self.basis().len(), self.targets.dimension());
        scratch.input.resize(self.cloud.dim(), 0.0);
        self.cloud.enter(input, &mut scratch.input)?;
        let images = if self.cloud.mirrored() { 2 } else { 1 };
        let all = self.cloud.len();
        scratch.squared.resize(images * all.max(n), 0.0);
        let (own, image) = scratch.squared.split_at_mut(all);
        self.cloud.squared_one(&scratch.input, own, image);
        let least =
            own.iter().chain(image.iter().take((images - 1) * all)).fold(f64::INFINITY, |a, v| a.min(*v));
        out.novelty = least.sqrt() / self.extent.spacing;
        let (own, image) = scratch.squared[..images * n].split_at_mut(n);
        if let Some(inducing) = &self.inducing {
            inducing.cloud.squared_one(&scratch.input, own, image);
        }
        self.kernel.of(own);
        self.kernel.of(image);
        scratch.parts.resize(d, 0.0);
        let mut known = 0.0;
        for half in &self.halves {
            scratch.k.clear();
            match half.sign {
                Sign::Only => scratch.k.extend_from_slice(own),
                sign => scratch.k.extend(own.iter().zip(image.iter()).map(|(a, b)| sign.join(*a, *b))),
            }
            half.whiten_one(&mut scratch.k, &mut scratch.w);
            let mean = &mut scratch.parts[half.first..half.first + half.columns];
            known += half.answer_one(&scratch.k, &scratch.w, mean);
        }
        out.mean.resize(d, 0.0);
        self.leave(&mut scratch.parts, &mut out.mean);
        (out.variance, out.confidence) = self.doubt(known);
        Ok(())
    }

    /// From even and odd target coordinates to the targets' own.
    fn leave(&self, parts: &mut [f64], out: &mut [f64]) {
        parts.iter_mut().zip(&self.targets.centre).for_each(|(p, c)| *p += c);
        self.targets.parity.leave(parts, out);
    }

    /// Variance with noise, and confidence.
    fn doubt(&self, known: f64) -> (f64, f64) {
        let signal = self.kernel.signal_variance;
        let left = (signal - known).clamp(0.0, signal);
        (left + self.kernel.noise_variance, 1.0 - left / signal)
    }

    /// Adds examples at the same kernel, by more rows of the factors: O(N²) for each, nothing is learned again. The centre
    /// of targets ([`RbfOptions::centre`]) stays. With inducing points, examples farther from them than any was before
    /// make them be chosen again.
    ///
    /// # Errors
    /// As [`Examples::and`]; a kernel matrix that does not factor. The model is then what it was.
    pub fn grow(&mut self, more: &Examples) -> Result<(), FitError> {
        let examples = self.examples.and(more)?;
        let was = self.cloud.len();
        if self.inducing.is_none() && examples.effective() > self.options.exact_up_to {
            *self = RbfRegression::with_kernel(
                examples,
                self.options.clone(),
                self.kernel,
                self.learning.clone(),
            )?;
            return Ok(());
        }
        let cloud = self.cloud.and(more);
        let added = cloud.subset(&(was..cloud.len()).collect::<Vec<_>>());
        let new = Targets::about(more, self.targets.parity.clone(), self.targets.centre.clone());
        let mut targets = self.targets.clone();
        for (t, n) in targets.parts.iter_mut().zip(&new.parts) {
            t.values.extend_from_slice(&n.values);
        }
        let halves = match &self.inducing {
            None => self.more_rows(&cloud, &added, &new)?,
            Some(inducing) => {
                let mut squared = Squared::default();
                inducing.cloud.squared(added.points(), added.len(), &mut squared);
                let far = (0..added.len()).any(|i| {
                    let p = added.point(i);
                    inducing.cloud.nearest(&squared, i, added.len(), p)
                        > inducing.reach.max(1e-9 * self.extent.diameter)
                });
                if far {
                    *self = RbfRegression::with_kernel(
                        examples,
                        self.options.clone(),
                        self.kernel,
                        self.learning.clone(),
                    )?;
                    return Ok(());
                }
                self.more_sums(&squared, &new)?
            }
        };
        self.extent = cloud.extent(&examples);
        (self.examples, self.cloud, self.targets, self.halves) = (examples, cloud, targets, halves);
        self.log_likelihood = self.likelihood();
        Ok(())
    }

    /// Residuals at the examples, each predicted from the others at the same kernel, in closed form: α_i/[K⁻¹]_ii, variance
    /// 1/[K⁻¹]_ii (Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, (5.12)). An example and its image
    /// are left out together, by their even and odd parts. The centre of targets is not taken again. With inducing points,
    /// those of the approximation. O(N³).
    pub fn leave_one_out(&self) -> LeaveOneOut {
        let (n, d) = (self.cloud.len(), self.targets.dimension());
        let mut parts = vec![0.0; n * d];
        let mut variance = vec![0.0; n];
        let mut cross = Squared::default();
        if let Some(inducing) = &self.inducing {
            inducing.cloud.squared(self.cloud.points(), n, &mut cross);
            self.kernel.of(&mut cross.own);
            self.kernel.of(&mut cross.image);
        }
        let mut v = Vec::new();
        for (half, part) in self.halves.iter().zip(&self.targets.parts) {
            let columns = half.columns;
            let mut alpha;
            let mut diagonal = vec![0.0; n];
            if half.sparse.is_some() {
                // (VᵀV + σ² I)⁻¹ = (I − Vᵀ B⁻¹ V/σ²)/σ²
                let (m, noise) = (half.factor.len(), self.kernel.noise_variance);
                let mut second = Vec::new();
                join(half.sign, &cross, &mut v);
                half.whiten(&mut v, n, &mut second);
                alpha = part.values.clone();
                let whitened = view(&half.whitened, m, columns, columns);
                multiply(&mut alpha, columns, -1.0, &transposed(&second, m, n, n), &whitened, 1.0);
                alpha.iter_mut().for_each(|a| *a /= noise);
                for row in second.chunks_exact(n) {
                    diagonal.iter_mut().zip(row).for_each(|(d, v)| *d += v * v);
                }
                diagonal.iter_mut().for_each(|d| *d = (1.0 - *d / noise) / noise);
            } else {
                alpha = half.whitened.clone();
                half.factor.solve_upper(&mut alpha, columns);
                half.factor.invert(&mut v);
                for row in v.chunks_exact(n) {
                    diagonal.iter_mut().zip(row).for_each(|(d, v)| *d += v * v);
                }
            }
            for i in 0..n {
                variance[i] += half.sign.share() / diagonal[i];
                for k in 0..columns {
                    parts[i * d + half.first + k] = alpha[i * columns + k] / diagonal[i];
                }
            }
        }
        let mut residual = DMatrix::zeros(n, d);
        let mut row = vec![0.0; d];
        for (i, part) in parts.chunks_exact(d).enumerate() {
            self.targets.parity.leave(part, &mut row);
            row.iter().enumerate().for_each(|(k, v)| residual[(i, k)] = *v);
        }
        LeaveOneOut { residual, variance }
    }

    /// ln p of the halves.
    fn likelihood(&self) -> f64 {
        let n = self.cloud.len() as f64;
        let mut value = 0.0;
        for (half, part) in self.halves.iter().zip(&self.targets.parts) {
            let whitened = dot(&half.whitened, &half.whitened);
            let (fit, ln_det) = match &half.sparse {
                None => (whitened, half.factor.ln_det()),
                Some(sparse) => {
                    let noise = self.kernel.noise_variance;
                    let all = dot(&part.values, &part.values) / noise;
                    (all - whitened, sparse.ln_det() + n * noise.ln())
                }
            };
            let each = ln_det + n * (2.0 * std::f64::consts::PI).ln();
            value -= 0.5 * fit / half.sign.share() + 0.5 * self.targets.dimension() as f64 * each;
        }
        value
    }

    fn more_rows(&self, cloud: &Cloud, added: &Cloud, new: &Targets) -> Result<Vec<Half>, FitError> {
        let (n, more) = (cloud.len(), added.len());
        let mut squared = Squared::default();
        // rows are the points added, columns all
        added.squared(cloud.points(), n, &mut squared);
        let was = n - more;
        for i in 0..more {
            squared.own[i * n + was + i] = 0.0;
        }
        self.kernel.of(&mut squared.own);
        self.kernel.of(&mut squared.image);
        let mut rows = Vec::new();
        let mut halves = Vec::new();
        for (half, part) in self.halves.iter().zip(&new.parts) {
            join(half.sign, &squared, &mut rows);
            for i in 0..more {
                rows[i * n + was + i] += self.kernel.noise_variance;
            }
            let factor = half.factor.extended(&rows, more).ok_or_else(|| not_definite(&self.kernel))?;
            let mut whitened = half.whitened.clone();
            whitened.extend_from_slice(&part.values);
            factor.solve_lower_from(&mut whitened, half.columns, was);
            halves.push(Half { factor, whitened, sparse: None, ..*half });
        }
        Ok(halves)
    }

    fn more_sums(&self, squared: &Squared, new: &Targets) -> Result<Vec<Half>, FitError> {
        let mut k = squared.clone();
        self.kernel.of(&mut k.own);
        self.kernel.of(&mut k.image);
        let mut halves = self.halves.clone();
        let mut v = Vec::new();
        for (half, part) in halves.iter_mut().zip(&new.parts) {
            let m = half.factor.len();
            join(half.sign, &k, &mut v);
            let count = v.len() / m;
            half.factor.solve_lower(&mut v, count);
            if let Some(sparse) = &mut half.sparse {
                if !sparse.add(&v, m, &part.values, half.columns, &self.kernel) {
                    return Err(not_definite(&self.kernel));
                }
                half.whitened = sparse.whitened(half.columns, &self.kernel);
            }
        }
        Ok(halves)
    }
}

/// The kernel of a half from those to points and images.
fn join(sign: Sign, k: &Squared, out: &mut Vec<f64>) {
    out.clear();
    match sign {
        Sign::Only => out.extend_from_slice(&k.own),
        sign => out.extend(k.own.iter().zip(&k.image).map(|(a, b)| sign.join(*a, *b))),
    }
}

fn unlearned(why: &str) -> Learning {
    Learning { iterations: 0, evaluations: 0, start: 0.0, end: 0.0, stopped: why.into() }
}

/// Learns a kernel from all of `examples`.
fn learn(examples: &Examples, options: &RbfOptions) -> Result<(RbfKernel, Learning), FitError> {
    let cloud = Cloud::of(examples);
    let extent = cloud.extent(examples);
    let targets = Targets::of(examples, options.centre);
    let zero = targets.mean_square() < ZERO * ZERO;
    let square = if zero { 1.0 } else { targets.mean_square() };
    let start =
        RbfKernel { signal_variance: square, length: extent.median, noise_variance: START_NOISE * square };
    if zero {
        return Ok((start, unlearned("all targets are zero")));
    }
    if extent.diameter == 0.0 {
        return Ok((start, unlearned("all inputs are at one place")));
    }
    let ranges = [
        Range::new((SIGNAL.0 * square).ln(), (SIGNAL.1 * square).ln()),
        Range::new((LENGTH * extent.diameter).ln(), extent.diameter.ln()),
        Range::new((NOISE.0 * square).ln(), (NOISE.1 * square).ln()),
    ];
    let mut evidence = Evidence::new(&cloud, &targets, ranges);
    let from = evidence.parameters(&start);
    let d = descend(&mut evidence, from, options.iterations)?;
    let kernel = evidence.kernel(&d.point);
    let learning = Learning {
        iterations: d.iterations,
        evaluations: d.evaluations,
        start: d.start_value,
        end: d.value,
        stopped: d.stopped,
    };
    Ok((kernel, learning))
}

/// Halves of examples taken as they are.
fn exact(cloud: &Cloud, targets: &Targets, kernel: &RbfKernel) -> Result<Vec<Half>, FitError> {
    let n = cloud.len();
    let mut squared = Squared::default();
    cloud.squared(cloud.points(), n, &mut squared);
    squared.own.iter_mut().step_by(n + 1).for_each(|v| *v = 0.0);
    kernel.of(&mut squared.own);
    kernel.of(&mut squared.image);
    let mut k = Vec::new();
    let mut halves = Vec::new();
    for part in &targets.parts {
        join(part.sign, &squared, &mut k);
        k.iter_mut().step_by(n + 1).for_each(|v| *v += kernel.noise_variance);
        let factor = Factor::of(k.clone(), n).ok_or_else(|| not_definite(kernel))?;
        let mut whitened = part.values.clone();
        factor.solve_lower(&mut whitened, part.columns);
        halves.push(Half {
            sign: part.sign,
            first: part.first,
            columns: part.columns,
            factor,
            sparse: None,
            whitened,
        });
    }
    Ok(halves)
}

/// Halves of examples seen through inducing points.
fn through(
    inducing: &Cloud,
    cloud: &Cloud,
    targets: &Targets,
    kernel: &RbfKernel,
) -> Result<Vec<Half>, FitError> {
    let (m, n) = (inducing.len(), cloud.len());
    let (mut own, mut cross) = (Squared::default(), Squared::default());
    inducing.squared(inducing.points(), m, &mut own);
    own.own.iter_mut().step_by(m + 1).for_each(|v| *v = 0.0);
    inducing.squared(cloud.points(), n, &mut cross);
    for k in [&mut own, &mut cross] {
        kernel.of(&mut k.own);
        kernel.of(&mut k.image);
    }
    let mut halves = Vec::new();
    let (mut k, mut v) = (Vec::new(), Vec::new());
    for part in &targets.parts {
        join(part.sign, &own, &mut k);
        k.iter_mut().step_by(m + 1).for_each(|v| *v += JITTER * kernel.signal_variance);
        let factor = Factor::of(k.clone(), m).ok_or_else(|| not_definite(kernel))?;
        join(part.sign, &cross, &mut v);
        factor.solve_lower(&mut v, n);
        let sparse =
            Sparse::new(&v, m, &part.values, part.columns, kernel).ok_or_else(|| not_definite(kernel))?;
        let whitened = sparse.whitened(part.columns, kernel);
        halves.push(Half {
            sign: part.sign,
            first: part.first,
            columns: part.columns,
            factor,
            sparse: Some(sparse),
            whitened,
        });
    }
    Ok(halves)
}

/// The error of a kernel matrix that does not factor.
pub(crate) fn not_definite(kernel: &RbfKernel) -> FitError {
    FitError::Optimiser {
        iterations: 0,
        reason: format!("kernel matrix is not positive definite at {kernel:?}"),
    }
}
