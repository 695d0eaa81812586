//! Linear interpolation of the nearest key poses: the baseline NN of YAH10 §6.4.
//!
//! The N pairs whose inputs are nearest, weighted by 1/distance. The variance is that of those outputs about
//! their weighted mean, which is all that such a model knows.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::cover::Cover;
use crate::error::{FitError, InputError};
use crate::pairs::Pairs;
use crate::regressor::{PosteriorCovariance, Prediction, Regressor, Scratch};

/// The weighted mean of the outputs of the nearest inputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Stored", into = "Stored")]
pub struct Nearest {
    pairs: Pairs,
    neighbours: usize,
    cover: Cover,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Nearest", deny_unknown_fields)]
struct Stored {
    pairs: Pairs,
    neighbours: usize,
}

impl From<Nearest> for Stored {
    fn from(m: Nearest) -> Self {
        Stored { pairs: m.pairs, neighbours: m.neighbours }
    }
}

impl TryFrom<Stored> for Nearest {
    type Error = FitError;

    fn try_from(s: Stored) -> Result<Self, FitError> {
        Nearest::fit(&s.pairs, s.neighbours)
    }
}

impl Nearest {
    /// Interpolates between `neighbours` pairs, 1 to N.
    ///
    /// # Errors
    /// A number of neighbours out of range.
    pub fn fit(pairs: &Pairs, neighbours: usize) -> Result<Self, FitError> {
        if neighbours == 0 || neighbours > pairs.len() {
            let allowed = format!("from 1 to {}, the number of pairs", pairs.len());
            return Err(FitError::Setting { name: "neighbours", value: neighbours as f64, allowed });
        }
        let cover = Cover::as_wide_as_the_data(pairs.inputs())?;
        Ok(Nearest { pairs: pairs.clone(), neighbours, cover })
    }

    /// Pairs it interpolates between.
    pub fn neighbours(&self) -> usize {
        self.neighbours
    }
}

impl Regressor for Nearest {
    fn pairs(&self) -> &Pairs {
        &self.pairs
    }

    fn predict(&self, input: &[f64], scratch: &mut Scratch, out: &mut Prediction) -> Result<(), InputError> {
        let (nearest, novelty, left) = self.cover.enter(input, scratch)?;
        let Scratch { squared, k: weights, .. } = scratch;
        out.mean.resize(self.pairs.output_dim(), 0.0);
        out.mean.fill(0.0);
        weigh(squared, self.neighbours, nearest, weights);
        for (i, w) in weights.iter().enumerate().filter(|(_, w)| **w > 0.0) {
            out.mean.iter_mut().zip(self.pairs.output(i)).for_each(|(m, z)| *m += *w * z);
        }
        let spread = |i: usize| crate::dense::distance_squared(self.pairs.output(i), &out.mean);
        let about: f64 =
            weights.iter().enumerate().filter(|(_, w)| **w > 0.0).map(|(i, w)| w * spread(i)).sum();
        out.variance = about / self.pairs.output_dim() as f64;
        out.confidence = (1.0 - left).clamp(0.0, 1.0);
        out.novelty = novelty;
        Ok(())
    }

    fn posterior_covariance(&self, frames: &DMatrix<f64>) -> Result<PosteriorCovariance, InputError> {
        self.cover.posterior_covariance(frames)
    }
}

/// Writes the weights of all points by their squared distances: the inverse distance for the nearest `neighbours`, zero for
/// the others, sum one. A point at distance zero, `nearest`, has all.
pub(crate) fn weigh(squared: &[f64], neighbours: usize, nearest: usize, weights: &mut [f64]) {
    weights.fill(0.0);
    if squared[nearest] == 0.0 {
        weights[nearest] = 1.0;
        return;
    }
    // The nearest `neighbours` one by one; `weights` holds them, zero elsewhere.
    let mut total = 0.0;
    for _ in 0..neighbours {
        let mut next = None::<usize>;
        for i in 0..squared.len() {
            if weights[i] == 0.0 && next.is_none_or(|b| squared[i] < squared[b]) {
                next = Some(i);
            }
        }
        let Some(i) = next else { break };
        weights[i] = 1.0 / squared[i].sqrt();
        total += weights[i];
    }
    weights.iter_mut().filter(|w| **w > 0.0).for_each(|w| *w /= total);
}
