//! Gaussian process regression from inputs to outputs: one kernel for all output coordinates.
//!
//! Kernel (1) over the centred inputs, divided by one number; its four parameters maximise the likelihood of
//! the outputs. Mean z̄ = μ + Zᵀ K⁻¹ k(y), variance k(y, y) − kᵀ K⁻¹ k, noise included.

use serde::{Deserialize, Serialize};

use nalgebra::DMatrix;

use crate::cover::Cover;
use crate::descend::{Objective, descend};
use crate::error::{FitError, InputError};
use crate::gplvm::Learning;
use crate::kernel::{Kernel, box_penalty};
use crate::likelihood::{View, Work, median_squared, squared_distances};
use crate::pairs::{Pairs, Space};
use crate::regressor::{PosteriorCovariance, Prediction, Regressor, Scratch};

/// L-BFGS iterations, at most.
const ITERATIONS: usize = 100;

/// GP regression with the kernel of YAH10 (1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Stored", into = "Stored")]
pub struct GpRegression {
    pairs: Pairs,
    learning: Learning,
    cover: Cover,
    output: Space,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "GpRegression", deny_unknown_fields)]
struct Stored {
    pairs: Pairs,
    learning: Learning,
    kernel: Kernel,
}

impl From<GpRegression> for Stored {
    fn from(m: GpRegression) -> Self {
        Stored { pairs: m.pairs, learning: m.learning, kernel: m.cover.posterior.kernel }
    }
}

impl TryFrom<Stored> for GpRegression {
    type Error = FitError;

    fn try_from(s: Stored) -> Result<Self, FitError> {
        if !s.kernel.is_positive() {
            return Err(FitError::Stored {
                what: "kernel parameters that are not positive",
                found: 1,
                expected: 0,
            });
        }
        GpRegression::with_kernel(&s.pairs, s.kernel, s.learning)
    }
}

/// −ln P(outputs | inputs, Φ) over the parameters of the kernel.
pub(crate) struct Evidence {
    view: View,
    r2: Vec<f64>,
    work: Work,
}

impl Evidence {
    pub fn new(input: &Space, output: &Space) -> Self {
        let (d, n) = input.points.shape();
        let mut r2 = vec![0.0; n * n];
        squared_distances(input.points.as_slice(), d, &mut r2);
        Evidence { view: View::new(&output.points), r2, work: Work::new(n) }
    }

    /// Between the inputs, lower triangle of row-major N × N.
    pub fn squared_distances(&self) -> &[f64] {
        &self.r2
    }
}

impl Objective for Evidence {
    fn evaluate(&mut self, p: &[f64], gradient: &mut [f64]) -> Result<f64, FitError> {
        let kernel = Kernel::from_parameters(p);
        let (value, by) = self.view.evaluate(&kernel, &self.r2, None, &mut self.work)?;
        gradient.copy_from_slice(&kernel.chain(&by));
        Ok(value + box_penalty(p, gradient))
    }
}

impl GpRegression {
    /// Fits the kernel to at least two pairs.
    ///
    /// # Errors
    /// A likelihood that cannot be evaluated at the start.
    pub fn fit(pairs: &Pairs) -> Result<Self, FitError> {
        let (input, output) = (Space::of(pairs.inputs()), Space::of(pairs.outputs()));
        let mut evidence = Evidence::new(&input, &output);
        let median = median_squared(&evidence.r2, pairs.len());
        let d = descend(&mut evidence, Kernel::start(median).parameters().to_vec(), ITERATIONS)?;
        let learning = Learning {
            iterations: d.iterations,
            evaluations: d.evaluations,
            start: d.start_value,
            end: d.value,
            stopped: d.stopped,
        };
        GpRegression::with_kernel(pairs, Kernel::from_parameters(&d.point), learning)
    }

    fn with_kernel(pairs: &Pairs, kernel: Kernel, learning: Learning) -> Result<Self, FitError> {
        let output = Space::of(pairs.outputs());
        let cover = Cover::new(pairs.inputs(), kernel, output.points.as_slice())?;
        Ok(GpRegression { pairs: pairs.clone(), learning, cover, output })
    }

    /// The kernel, in units of the variances of inputs and outputs.
    pub fn kernel(&self) -> Kernel {
        self.cover.posterior.kernel
    }

    /// How fitting went.
    pub fn learning(&self) -> &Learning {
        &self.learning
    }
}

impl Regressor for GpRegression {
    fn pairs(&self) -> &Pairs {
        &self.pairs
    }

    fn predict(&self, input: &[f64], scratch: &mut Scratch, out: &mut Prediction) -> Result<(), InputError> {
        let (_, novelty, left) = self.cover.enter(input, scratch)?;
        out.mean.resize(self.pairs.output_dim(), 0.0);
        self.cover.posterior.mean(&scratch.w, &mut out.mean);
        for (v, m) in out.mean.iter_mut().zip(&self.output.mean) {
            *v = m + self.output.scale * *v;
        }
        out.variance = self.output.scale.powi(2) * (left + self.cover.posterior.kernel.noise());
        out.confidence = (1.0 - left).clamp(0.0, 1.0);
        out.novelty = novelty;
        Ok(())
    }

    fn posterior_covariance(&self, frames: &DMatrix<f64>) -> Result<PosteriorCovariance, InputError> {
        self.cover.posterior_covariance(frames)
    }
}
