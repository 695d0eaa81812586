//! A Gaussian process over the inputs: what the pairs say about a new input before any model is asked.
//!
//! Plain GP regression is this with answers. Models without a variance of their own (PCA, nearest
//! neighbours) take their confidence from it, with a kernel as wide as the median distance of the inputs.

use nalgebra::DMatrix;

use crate::error::{FitError, InputError};
use crate::kernel::Kernel;
use crate::likelihood::{median_squared, squared_distances};
use crate::pairs::{Coverage, Space};
use crate::posterior::Posterior;
use crate::regressor::{Part, PosteriorCovariance, Scratch};

/// Inputs with a kernel over them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cover {
    pub space: Space,
    pub posterior: Posterior,
    coverage: Coverage,
}

impl Cover {
    /// Of inputs, one a column, and observations `y` there (N × columns, row-major), with the kernel given.
    pub fn new(inputs: &DMatrix<f64>, kernel: Kernel, y: &[f64]) -> Result<Self, FitError> {
        let (d, n) = inputs.shape();
        let space = Space::of(inputs);
        let mut r2 = vec![0.0; n * n];
        squared_distances(space.points.as_slice(), d, &mut r2);
        let posterior = Posterior::new(kernel, &r2, n, y)?;
        let coverage = Coverage::of(&space.points);
        Ok(Cover { space, posterior, coverage })
    }

    /// With a kernel as wide as the median distance, one hundredth noise, and no observations.
    pub fn as_wide_as_the_data(inputs: &DMatrix<f64>) -> Result<Self, FitError> {
        let (d, n) = inputs.shape();
        let mut r2 = vec![0.0; n * n];
        squared_distances(Space::of(inputs).points.as_slice(), d, &mut r2);
        Cover::new(inputs, Kernel { theta3: 1e-9, ..Kernel::start(median_squared(&r2, n)) }, &[])
    }

    /// Takes `input` into `scratch` with its squared distances and whitened kernel values; returns the
    /// nearest pair, the novelty, and the variance that the pairs leave, without noise.
    pub fn enter(&self, input: &[f64], scratch: &mut Scratch) -> Result<(usize, f64, f64), InputError> {
        scratch.fit(self.space.mean.len(), self.space.points.ncols());
        self.space.enter(input, &mut scratch.input)?;
        let (nearest, novelty) =
            self.coverage.novelty(&self.space.points, &scratch.input, &mut scratch.squared);
        scratch.k.copy_from_slice(&scratch.squared);
        self.posterior.kernel_in_place(&mut scratch.k);
        self.posterior.whiten(&scratch.k, &mut scratch.w);
        Ok((nearest, novelty, self.posterior.left(&scratch.w)))
    }

    /// Covariance of what the pairs leave open between the rows of `frames`.
    pub fn posterior_covariance(&self, frames: &DMatrix<f64>) -> Result<PosteriorCovariance, InputError> {
        let (mut scratch, mut input) = (Scratch::new(), vec![0.0; frames.ncols()]);
        let (mut points, mut known) = (Vec::new(), Vec::new());
        for i in 0..frames.nrows() {
            input.iter_mut().zip(frames.row(i).iter()).for_each(|(a, b)| *a = *b);
            self.enter(&input, &mut scratch)?;
            points.extend_from_slice(&scratch.input);
            known.extend_from_slice(&scratch.w);
        }
        let kernel = self.posterior.kernel;
        let part = Part { weight: 1.0, kernel, own: None, points, known };
        Ok(PosteriorCovariance {
            noise: kernel.noise(),
            parts: vec![part],
            unseen: Vec::new(),
            frames: frames.nrows(),
        })
    }
}
