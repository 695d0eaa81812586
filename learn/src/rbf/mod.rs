//! Gaussian process regression of examples: an isotropic radial basis function and noise, three numbers shared by all targets.
//!
//! k(x, x') = σ_f² exp(−|x − x'|²/(2 l²)) + σ_n² δ (IAF09 §4.3). The prior mean is zero: targets are differences, and far from the
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
//! **Groups.** Where input coordinates are in groups ([`Examples::with_groups`]) each group has a length of its own (automatic relevance determination; Neal,
//! Bayesian Learning for Neural Networks, 1996), learned with the others from the same start: r²/l² is Σ r_g²/l_g². An edit that follows the speed of a body
//! and not its pose is then a function of the speed. A length may be up to ten diameters: what does not matter is not looked at. Novelty
//! ([`Batch::novelty`]) stays the distance in all coordinates, so that what is new in any way is known as new.
//!
//! **Neighbours in time.** Frames of a motion one after the other share what no function of the inputs explains (a step that is a little faster than it looks), and the
//! likelihood, which takes what is left for noise of each alone, makes a rule of it: the more frames, the more. Where examples have moments
//! ([`Examples::with_moments`]) and some are nearer in time than a fifth of what is one event (0.1 s of 0.5 s in an edit), a second kernel is learned from those that are not, and taken where it halves the squared error of
//! examples left out with all that are the same event ([`RbfRegression::leave_event_out`]). Neither is always better: from few frames a
//! rule with a kink looks smooth and free of noise.
//!
//! **What is not learned.** Targets that are all zero (root mean square below 10⁻⁹): the likelihood has no bound as both
//! variances go to 0. The kernel is then the start with s² = 1, the mean is zero everywhere, the variance small near the examples. Inputs
//! all at one place, one example among them: nothing tells l. The kernel is the start with l a tenth of the input's
//! distance from zero (1 if that is zero): the mean of the targets there, slightly shrunk, and nothing farther away.
//!
//! **Many examples.** Beyond [`RbfOptions::exact_up_to`], images counted, the kernel is learned from 2,000 of them (or as many as that), runs of
//! neighbours evenly spread, and all enter through inducing points, each the farthest from those before (DTC; Quiñonero-Candela and
//! Rasmussen, JMLR 2005): O(N M²). What it costs, in standard deviations of the targets, of 1,500 examples and images
//! (`cargo run --release -p learn --example inducing`): the RMS error of unseen frames, 0.022 as they are, is 0.024 with 1,000 points,
//! 0.029 with 750, 0.045 with 400, 0.10 with 100; variances are 1.15, 1.4, 3.1 and 23 times as large, so what is lost is told. A kernel
//! learned from 2,000 of the 3,000 makes 0.029 of the 0.029, from 500 0.037.
//!
//! IAF09: Ikemoto, Arikan, Forsyth. Generalizing motion edits with Gaussian processes. ACM TOG 28(1), 2009.

mod evidence;
mod grow;
mod half;
mod leave_out;
mod predict;
mod targets;

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use crate::cloud::{Cloud, Extent};
use crate::dense::dot;
use crate::descend::{Watch, Watched};
use crate::error::FitError;
use crate::examples::{Examples, GROUPS};
use crate::gplvm::Learning;
use evidence::{Evidence, Range, Ranges};
use half::{Half, exact, through};
pub use leave_out::Residuals;
pub use predict::Batch;
use targets::Targets;

/// Root mean square of targets below which they count as zero.
const ZERO: f64 = 1e-9;
/// Least σ_n²/s².
const NOISE: (f64, f64) = (1e-7, 10.0);
/// Range of σ_f²/s².
const SIGNAL: (f64, f64) = (1e-6, 1e3);
/// Least l over the diameter.
const LENGTH: f64 = 1e-3;
/// Largest length of a group over the diameter.
const GROUP_LENGTH: f64 = 10.0;
/// Most examples, images counted, that a kernel is learned from when there are many.
const LEARN_FROM: usize = 2000;
/// Neighbours in each run of examples that a kernel is learned from when there are many.
const RUN: usize = 20;
/// Examples nearer in time than this part of what is one event share what the rule leaves over.
const SHARED: f64 = 0.2;
/// Part of the squared error that is left where the kernel of fewer examples is taken: they know less, and small gains are chance.
const BETTER: f64 = 0.5;
/// Part of s² that is noise at the start.
const START_NOISE: f64 = 0.01;

/// The three numbers, and how much groups of input coordinates count.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RbfKernel {
    /// σ_f², squared units of the targets.
    pub signal_variance: f64,
    /// l, units of the inputs.
    pub length: f64,
    /// σ_n², squared units of the targets.
    pub noise_variance: f64,
    /// How much a difference in each group of input coordinates counts: its length is `length` over its weight. 1 of the group that counts most, and
    /// of groups that there are not.
    pub weights: [f64; GROUPS],
}

impl RbfKernel {
    /// All coordinates count alike.
    pub const fn isotropic(signal_variance: f64, length: f64, noise_variance: f64) -> Self {
        RbfKernel { signal_variance, length, noise_variance, weights: [1.0; GROUPS] }
    }

    /// Scales of the entered coordinates of a cloud; `None` where all count alike.
    fn scales(&self, examples: &Examples, cloud: &Cloud) -> Option<Vec<f64>> {
        let groups = examples.groups()?;
        Some(cloud.carry(|i| self.weights[groups[i]])).filter(|s| s.iter().any(|s| *s != 1.0))
    }

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
        if let Some(&value) = self.weights.iter().find(|w| !(**w > 0.0 && **w <= 1.0)) {
            return Err(FitError::Setting { name: "weights", value, allowed: "above 0, at most 1".into() });
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
    /// Inducing points, images not counted. A frame by itself costs O(M²).
    pub inducing: usize,
}

impl Default for RbfOptions {
    fn default() -> Self {
        RbfOptions { iterations: 100, centre: false, kernel: None, exact_up_to: 3000, inducing: 750 }
    }
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
    /// What the kernel sees, where groups have weights.
    weighted: Option<Weighted>,
    extent: Extent,
    /// Inducing points; none if the examples are taken as they are.
    inducing: Option<Inducing>,
    targets: Targets,
    halves: Vec<Half>,
}

/// The examples in the metric of the kernel.
#[derive(Clone, Debug, PartialEq)]
struct Weighted {
    scales: Vec<f64>,
    cloud: Cloud,
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
        RbfRegression::fit_watched(examples, options, &|_| ControlFlow::Continue(()))
    }

    /// As [`RbfRegression::fit`], watched: who watches is told how often the likelihood was evaluated, and may end it. What is learned does not
    /// depend on being watched.
    ///
    /// # Errors
    /// As [`RbfRegression::fit`]; [`FitError::Cancelled`].
    pub fn fit_watched(
        examples: &Examples,
        options: &RbfOptions,
        watch: &Watch<'_>,
    ) -> Result<Self, FitError> {
        if options.inducing == 0 {
            let allowed = "at least 1".into();
            return Err(FitError::Setting { name: "inducing", value: 0.0, allowed });
        }
        let (kernel, learning) = match options.kernel {
            Some(kernel) => {
                kernel.check()?;
                (kernel, unlearned("the kernel was given"))
            }
            None if examples.effective() <= options.exact_up_to => choose(examples, options, watch)?,
            None => {
                let images = examples.effective() / examples.len();
                let most = (options.exact_up_to.min(LEARN_FROM) / images).max(1);
                let keep = runs(examples.len(), most);
                choose(&examples.subset(&keep)?, options, watch)?
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
        let weighted =
            kernel.scales(&examples, &cloud).map(|scales| Weighted { cloud: cloud.scaled(&scales), scales });
        let seen = weighted.as_ref().map_or(&cloud, |w| &w.cloud);
        let inducing = (examples.effective() > options.exact_up_to).then(|| {
            let (chosen, reach) = seen.farthest(options.inducing);
            Inducing { cloud: seen.subset(&chosen), reach }
        });
        let halves = match &inducing {
            None => exact(seen, &targets, &kernel)?,
            Some(inducing) => through(&inducing.cloud, seen, &targets, &kernel)?,
        };
        let mut model = RbfRegression {
            examples,
            options,
            kernel,
            learning,
            log_likelihood: 0.0,
            cloud,
            weighted,
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
        self.inducing.as_ref().map_or(self.seen(), |i| &i.cloud)
    }

    /// All examples as the kernel sees them.
    fn seen(&self) -> &Cloud {
        self.weighted.as_ref().map_or(&self.cloud, |w| &w.cloud)
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
}

/// At most `most` of `all` numbers: runs of neighbours, evenly spread. Examples are mostly frames one after the other, and
/// without neighbours noise cannot be told from what changes fast.
fn runs(all: usize, most: usize) -> Vec<usize> {
    let count = (most / RUN).max(1);
    let length = most.div_ceil(count).min(most);
    let starts = (0..count).map(|i| i * (all - length) / (count - 1).max(1));
    let mut keep: Vec<usize> = starts.flat_map(|s| s..s + length).collect();
    keep.sort_unstable();
    keep.dedup();
    keep.truncate(most);
    keep
}

/// The kernel of `examples`: learned from all of them, or from those [`SHARED`] of an event apart where it foretells other events clearly better.
fn choose(
    examples: &Examples,
    options: &RbfOptions,
    watch: &Watch<'_>,
) -> Result<(RbfKernel, Learning), FitError> {
    let (all, of_all) = learn(examples, options, watch)?;
    let keep = examples.apart(SHARED);
    if keep.len() == examples.len() || of_all.evaluations == 0 {
        return Ok((all, of_all));
    }
    let later = |evaluations: usize| watch(of_all.evaluations + evaluations);
    let (few, of_few) = learn(&examples.subset(&keep)?, options, &later)?;
    let foretold = |kernel| {
        let as_they_are = RbfOptions { exact_up_to: usize::MAX, ..options.clone() };
        let given = unlearned("the kernel was given");
        let model = RbfRegression::with_kernel(examples.clone(), as_they_are, kernel, given)?;
        Ok::<f64, FitError>(model.leave_event_out()?.residual.norm_squared())
    };
    Ok(if foretold(few)? < BETTER * foretold(all)? { (few, of_few) } else { (all, of_all) })
}

fn unlearned(why: &str) -> Learning {
    Learning { iterations: 0, evaluations: 0, start: 0.0, end: 0.0, stopped: why.into() }
}

/// Learns a kernel from all of `examples`.
fn learn(
    examples: &Examples,
    options: &RbfOptions,
    watch: &Watch<'_>,
) -> Result<(RbfKernel, Learning), FitError> {
    let cloud = Cloud::of(examples);
    let extent = cloud.extent(examples);
    let targets = Targets::of(examples, options.centre);
    let zero = targets.mean_square() < ZERO * ZERO;
    let square = if zero { 1.0 } else { targets.mean_square() };
    let start = RbfKernel::isotropic(square, extent.median, START_NOISE * square);
    if zero {
        return Ok((start, unlearned("all targets are zero")));
    }
    if extent.diameter == 0.0 {
        return Ok((start, unlearned("all inputs are at one place")));
    }
    let longest = if examples.group_count() > 1 { GROUP_LENGTH } else { 1.0 } * extent.diameter;
    let ranges = Ranges {
        signal: Range::new((SIGNAL.0 * square).ln(), (SIGNAL.1 * square).ln()),
        length: Range::new((LENGTH * extent.diameter).ln(), longest.ln()),
        noise: Range::new((NOISE.0 * square).ln(), (NOISE.1 * square).ln()),
    };
    let mut evidence = Evidence::new(&cloud, examples, &targets, ranges);
    let from = evidence.parameters(&start);
    let d = Watched::new(&mut evidence, watch).descend(from, options.iterations)?;
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

/// The error of a kernel matrix that does not factor.
pub(crate) fn not_definite(kernel: &RbfKernel) -> FitError {
    FitError::Optimiser {
        iterations: 0,
        reason: format!("kernel matrix is not positive definite at {kernel:?}"),
    }
}

#[cfg(test)]
#[path = "sklearn_tests.rs"]
mod tests;
