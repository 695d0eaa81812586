//! Which frames to key next: those of largest posterior variance.
//!
//! A model gives the covariance of its errors between frames ([`PosteriorCovariance`]). Frames are named greedily, the
//! largest variance first: each one named is taken for keyed (the covariance is conditioned on it), so that five names
//! are five different poses and not five neighbours in time. No output is needed for that: the variance of a Gaussian process does not
//! depend on what it observes.

use nalgebra::DMatrix;

use crate::error::InputError;
use crate::regressor::{PosteriorCovariance, Regressor};

/// A frame worth keying.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Suggestion {
    /// Row of the frames.
    pub frame: usize,
    /// Expected squared error there when it is named, in units of the variance of the key outputs: the frames
    /// named before it are taken for keyed.
    pub variance: f64,
    /// Mean expected squared error over all frames once it is keyed too, same units.
    pub left: f64,
}

/// Names up to `count` rows of `frames` (F × D_Y), the least sure first.
///
/// # Errors
/// A wrong number of coordinates, or one that is not finite.
pub fn suggest<R: Regressor + ?Sized>(
    model: &R,
    frames: &DMatrix<f64>,
    count: usize,
) -> Result<Vec<Suggestion>, InputError> {
    let mut greedy = Greedy::new(model.posterior_covariance(frames)?);
    let mut named = Vec::new();
    for _ in 0..count.min(frames.nrows()) {
        let frame = greedy.most_uncertain();
        let variance = greedy.variance[frame].max(0.0);
        greedy.condition_on(frame);
        let left = greedy.variance.iter().map(|v| v.max(0.0)).sum::<f64>() / greedy.variance.len() as f64;
        named.push(Suggestion { frame, variance, left });
    }
    Ok(named)
}

struct Greedy {
    prior: PosteriorCovariance,
    /// Posterior variance of every frame.
    variance: Vec<f64>,
    /// One column per frame known: cov(·, frame)/√(cov(frame, frame) + noise), conditioned on those before.
    columns: Vec<Vec<f64>>,
    chosen: Vec<usize>,
}

impl Greedy {
    fn new(prior: PosteriorCovariance) -> Self {
        let variance = (0..prior.frames()).map(|f| prior.covariance(f, f)).collect();
        Greedy { prior, variance, columns: Vec::new(), chosen: Vec::new() }
    }

    fn covariance(&self, f: usize, g: usize) -> f64 {
        self.prior.covariance(f, g) - self.columns.iter().map(|c| c[f] * c[g]).sum::<f64>()
    }

    fn most_uncertain(&self) -> usize {
        let mut best = (0, f64::NEG_INFINITY);
        for (f, &v) in self.variance.iter().enumerate() {
            if v > best.1 && !self.chosen.contains(&f) {
                best = (f, v);
            }
        }
        best.0
    }

    fn condition_on(&mut self, g: usize) {
        let scale = 1.0 / (self.variance[g].max(0.0) + self.prior.noise).sqrt();
        let column: Vec<f64> = (0..self.variance.len()).map(|f| scale * self.covariance(f, g)).collect();
        self.variance.iter_mut().zip(&column).for_each(|(v, c)| *v -= c * c);
        self.columns.push(column);
        self.chosen.push(g);
    }
}
