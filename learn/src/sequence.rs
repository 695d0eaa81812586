//! A model run over a sequence of frames, and how smooth the path it takes is.

use nalgebra::DMatrix;

use crate::error::InputError;
use crate::regressor::{Jump, Prediction, Regressor, Scratch};

/// Maps frame after frame; each starts from the one before. No allocation after the first.
pub struct Mapper<'m, R: ?Sized> {
    model: &'m R,
    scratch: Scratch,
    out: Prediction,
}

impl<'m, R: Regressor + ?Sized> Mapper<'m, R> {
    /// Before the first frame.
    pub fn new(model: &'m R) -> Self {
        Mapper { model, scratch: Scratch::new(), out: Prediction::default() }
    }

    /// Maps the next frame (D_Y).
    ///
    /// # Errors
    /// A wrong number of coordinates, or one that is not finite; the mapper stays where it was.
    pub fn map(&mut self, input: &[f64]) -> Result<&Prediction, InputError> {
        self.model.predict(input, &mut self.scratch, &mut self.out)?;
        Ok(&self.out)
    }

    /// Latent point of the last frame; `None` for models without latent space.
    pub fn latent(&self) -> Option<&[f64]> {
        self.scratch.latent()
    }

    /// Whether the last frame left the basin of the one before.
    pub fn jump(&self) -> Option<Jump> {
        self.scratch.jump()
    }

    /// Forgets the previous frame: a new sequence starts.
    pub fn forget(&mut self) {
        self.scratch.forget();
    }

    /// What it writes into.
    pub fn scratch(&self) -> &Scratch {
        &self.scratch
    }
}

/// A sequence of frames mapped.
#[derive(Clone, Debug, PartialEq)]
pub struct Mapped {
    /// F × D_Z, in the units of the outputs.
    pub means: DMatrix<f64>,
    /// Variance of every coordinate, per frame.
    pub variance: Vec<f64>,
    /// Per frame, 0 to 1.
    pub confidence: Vec<f64>,
    /// Per frame; above 1 the model extrapolates.
    pub novelty: Vec<f64>,
    /// F × q for models with a latent space.
    pub latents: Option<DMatrix<f64>>,
    /// Frames at which the mapping left the basin it was in.
    pub jumps: Vec<(usize, Jump)>,
}

/// Maps the rows of `frames` (F × D_Y) one after the other.
///
/// # Errors
/// As [`Mapper::map`].
pub fn map_frames<R: Regressor + ?Sized>(model: &R, frames: &DMatrix<f64>) -> Result<Mapped, InputError> {
    let f = frames.nrows();
    let mut mapper = Mapper::new(model);
    let mut input = vec![0.0; frames.ncols()];
    let mut means = DMatrix::zeros(f, model.pairs().output_dim());
    let (mut variance, mut confidence, mut novelty) = (Vec::new(), Vec::new(), Vec::new());
    let (mut latents, mut jumps) = (Vec::new(), Vec::new());
    for i in 0..f {
        input.iter_mut().zip(frames.row(i).iter()).for_each(|(a, b)| *a = *b);
        let out = mapper.map(&input)?;
        means.row_mut(i).iter_mut().zip(&out.mean).for_each(|(a, b)| *a = *b);
        variance.push(out.variance);
        confidence.push(out.confidence);
        novelty.push(out.novelty);
        latents.extend_from_slice(mapper.latent().unwrap_or_default());
        jumps.extend(mapper.jump().map(|j| (i, j)));
    }
    let q = latents.len().checked_div(f).unwrap_or(0);
    let latents = (q > 0).then(|| DMatrix::from_row_slice(f, q, &latents));
    Ok(Mapped { means, variance, confidence, novelty, latents, jumps })
}

/// How smooth a path is: the second criterion of YAH10 §6.2 for the latent dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathShape {
    /// RMS distance from the mean of the path, in its units.
    pub extent: f64,
    /// RMS third derivative, units/s³.
    pub jerk: f64,
    /// `jerk`/`extent`, 1/s³: comparable between latent spaces of other sizes and dimensions.
    pub relative_jerk: f64,
    /// Largest step from frame to frame over the median step; a jump shows here.
    pub worst_step: f64,
}

/// Measures the rows of `path` (F × q, at least four) sampled at `rate_hz`. `None` for shorter paths and
/// such that do not move.
pub fn path_shape(path: &DMatrix<f64>, rate_hz: f64) -> Option<PathShape> {
    let (f, q) = path.shape();
    if f < 4 || q == 0 {
        return None;
    }
    let mean = path.row_mean();
    let about = |i: usize| (path.row(i) - &mean).norm_squared();
    let extent = ((0..f).map(about).sum::<f64>() / f as f64).sqrt();
    let third = |i: usize| {
        (path.row(i + 3) - path.row(i + 2) * 3.0 + path.row(i + 1) * 3.0 - path.row(i)).norm_squared()
    };
    let jerk = ((0..f - 3).map(third).sum::<f64>() / (f - 3) as f64).sqrt() * rate_hz.powi(3);
    let mut steps: Vec<f64> = (1..f).map(|i| (path.row(i) - path.row(i - 1)).norm()).collect();
    steps.sort_by(f64::total_cmp);
    let (median, worst) = (steps[steps.len() / 2], steps[steps.len() - 1]);
    (extent > 0.0 && median > 0.0).then(|| PathShape {
        extent,
        jerk,
        relative_jerk: jerk / extent,
        worst_step: worst / median,
    })
}
