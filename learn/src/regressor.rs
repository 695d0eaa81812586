//! What every model can do, whatever it is: predict, say how sure it is, and say what it does not know.
//!
//! A model is fixed once fitted; what a prediction needs to write into is a [`Scratch`], made once, so that
//! a frame costs no allocation and many threads can share a model. A scratch also remembers the previous
//! frame: models that search (the shared GPLVM) start from it.

use nalgebra::DMatrix;

use crate::dense::dot;
use crate::error::InputError;
use crate::gplvm::search::Search;
use crate::kernel::Kernel;
use crate::pairs::Pairs;

/// A map from inputs (D_Y) to outputs (D_Z), with how sure it is.
pub trait Regressor: Send + Sync {
    /// The pairs it was fitted to.
    fn pairs(&self) -> &Pairs;

    /// Predicts the output for `input` (D_Y, in the units of the pairs' inputs) into `out`; does not
    /// allocate when `scratch` and `out` have been used with this model before. A model that searches starts
    /// from the previous input of `scratch` too: call [`Scratch::forget`] where a sequence ends.
    ///
    /// # Errors
    /// A wrong number of coordinates, or one that is not finite.
    fn predict(&self, input: &[f64], scratch: &mut Scratch, out: &mut Prediction) -> Result<(), InputError>;

    /// Covariance of the model's errors between the rows of `frames` (F × D_Y), given its pairs.
    ///
    /// # Errors
    /// As [`Regressor::predict`].
    fn posterior_covariance(&self, frames: &DMatrix<f64>) -> Result<PosteriorCovariance, InputError>;
}

/// An answer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Prediction {
    /// D_Z, in the units of the pairs' outputs.
    pub mean: Vec<f64>,
    /// Variance of every coordinate of the output about `mean`, squared units: noise and what is not known.
    pub variance: f64,
    /// 1 − (mean squared error the model expects)/(variance of the key outputs), at least 0: 1 is sure, 0 is
    /// no better than the mean of all outputs. Of models of examples: as in [`crate::Batch::confidence`].
    pub confidence: f64,
    /// Distance of the input from the nearest of the pairs, divided by the widest gap among those: the
    /// largest distance from one of them to its nearest neighbour. Of models of examples: divided by their spacing
    /// ([`crate::Batch::novelty`]).
    pub novelty: f64,
}

impl Prediction {
    /// The input is farther from every pair than any pair is from the others.
    pub fn extrapolates(&self) -> bool {
        self.novelty > 1.0
    }
}

/// What predictions write into, and the memory of the previous frame.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    pub(crate) input: Vec<f64>,
    pub(crate) squared: Vec<f64>,
    pub(crate) k: Vec<f64>,
    pub(crate) w: Vec<f64>,
    pub(crate) parts: Vec<f64>,
    pub(crate) more: Vec<f64>,
    pub(crate) order: Vec<usize>,
    pub(crate) search: Option<Box<Search>>,
    pub(crate) jump: Option<Jump>,
}

/// The mapping did not continue where the previous frame was: two explanations of the poses compete.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// Distance between the old explanation, followed to this frame, and the new one, in lengths of the
    /// input kernel.
    pub lengths: f64,
    /// How much likelier the new one is, nats.
    pub gain: f64,
    /// The key pose whose latent point led there.
    pub key: usize,
}

impl Scratch {
    /// Empty: fits itself to the first model it is used with.
    pub fn new() -> Self {
        Self::default()
    }

    /// Forgets the previous frame: the next one starts afresh.
    pub fn forget(&mut self) {
        if let Some(s) = &mut self.search {
            s.warm = false;
        }
        self.jump = None;
    }

    /// Latent point of the last input; `None` for models without latent space.
    pub fn latent(&self) -> Option<&[f64]> {
        self.search.as_deref().filter(|s| s.warm).map(|s| s.answer.as_slice())
    }

    /// Whether the last prediction left the basin of the one before.
    pub fn jump(&self) -> Option<Jump> {
        self.jump
    }

    /// Search steps the last prediction took; 0 for models that do not search.
    pub fn steps(&self) -> usize {
        self.search.as_deref().map_or(0, |s| s.steps)
    }

    pub(crate) fn fit(&mut self, input_dim: usize, n: usize) {
        self.input.resize(input_dim, 0.0);
        self.squared.resize(n, 0.0);
        self.k.resize(n, 0.0);
        self.w.resize(n, 0.0);
    }
}

/// Covariance of a model's errors between frames, in units of the variance of the key outputs.
///
/// cov(f, g) = Σ weight (k(p_f, p_g) − w_f·w_g) + r_f·r_g over the Gaussian processes that stand between input and
/// output, with p the frames as the kernel sees them, w = L⁻¹k(p) what the pairs tell about them, r what the
/// model cannot see of an input at all: the part of it that no latent point explains.
#[derive(Clone, Debug)]
pub struct PosteriorCovariance {
    pub(crate) parts: Vec<Part>,
    /// F × r.
    pub(crate) unseen: Vec<f64>,
    /// Variance of the outputs' noise: what remains however many pairs there are.
    pub(crate) noise: f64,
    pub(crate) frames: usize,
}

/// Posterior covariance of one Gaussian process.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// Variance of the output for a unit of its variance.
    pub weight: f64,
    pub kernel: Kernel,
    /// 1/ℓ² of the noise, where it is a part that fades (`gplvm::back`).
    pub own: Option<f64>,
    /// F × p, row-major.
    pub points: Vec<f64>,
    /// F × N.
    pub known: Vec<f64>,
}

impl PosteriorCovariance {
    /// Frames F.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// cov(f, g).
    pub fn covariance(&self, f: usize, g: usize) -> f64 {
        let rows = |v: &'_ [f64]| -> [std::ops::Range<usize>; 2] {
            let w = v.len() / self.frames;
            [f, g].map(|i| i * w..(i + 1) * w)
        };
        let mut sum = 0.0;
        for part in &self.parts {
            let [a, b] = rows(&part.points);
            let r2 = crate::dense::distance_squared(&part.points[a], &part.points[b]);
            let kernel = &part.kernel;
            let k = match part.own {
                Some(own) => crate::gplvm::back::covariance(kernel, own, r2),
                None => kernel.theta1 * (-0.5 * kernel.theta2 * r2).exp() + kernel.theta3,
            };
            let [a, b] = rows(&part.known);
            sum += part.weight * (k - dot(&part.known[a], &part.known[b]));
        }
        let [a, b] = rows(&self.unseen);
        sum + dot(&self.unseen[a], &self.unseen[b])
    }
}
