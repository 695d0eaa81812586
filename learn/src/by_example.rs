//! Any model of examples behind one type and the same verbs: `fit`, `predict`, `predict_batch`, `grow`.
//!
//! What is stored is what was learned; factors are made again when it is read. A model that has grown is then that of
//! all its examples at the same kernel: equal to rounding.

use std::fmt;
use std::ops::ControlFlow;
use std::str::FromStr;

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::dense::distance_squared;
use crate::descend::Watch;
use crate::error::{FitError, InputError};
use crate::examples::Examples;
use crate::known::{Known, each};
use crate::mls::{MlsOptions, MovingLeastSquares};
use crate::nearest::weigh;
use crate::rbf::{Batch, RbfOptions, RbfRegression};
use crate::regressor::{Prediction, Scratch};

/// A way to learn from examples, by its name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum ExampleMethod {
    /// Gaussian process regression.
    #[default]
    Gp,
    /// Moving least squares.
    Mls,
    /// Nearest examples.
    Nearest,
}

impl ExampleMethod {
    /// All of them.
    pub const ALL: [ExampleMethod; 3] = [ExampleMethod::Gp, ExampleMethod::Mls, ExampleMethod::Nearest];

    /// `gp`, `mls`, `nearest`.
    pub const fn name(self) -> &'static str {
        match self {
            ExampleMethod::Gp => "gp",
            ExampleMethod::Mls => "mls",
            ExampleMethod::Nearest => "nearest",
        }
    }
}

impl fmt::Display for ExampleMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Not the name of a way to learn from examples.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown model of examples `{found}`; known are gp, mls, nearest")]
pub struct UnknownExampleMethod {
    /// What was given.
    pub found: String,
}

impl FromStr for ExampleMethod {
    type Err = UnknownExampleMethod;

    fn from_str(s: &str) -> Result<Self, UnknownExampleMethod> {
        let found = || UnknownExampleMethod { found: s.into() };
        ExampleMethod::ALL.into_iter().find(|m| m.name() == s).ok_or_else(found)
    }
}

/// Settings of all of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ExampleOptions {
    /// Of Gaussian process regression.
    pub gp: RbfOptions,
    /// Of moving least squares.
    pub mls: MlsOptions,
    /// Examples and images that [`NearestExamples`] interpolates between.
    pub neighbours: usize,
}

impl Default for ExampleOptions {
    fn default() -> Self {
        ExampleOptions { gp: RbfOptions::default(), mls: MlsOptions::default(), neighbours: 1 }
    }
}

/// A fitted model of examples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum ExampleModel {
    /// Gaussian process regression.
    Gp(Box<RbfRegression>),
    /// Moving least squares.
    Mls(Box<MovingLeastSquares>),
    /// Nearest examples.
    Nearest(Box<NearestExamples>),
}

impl ExampleModel {
    /// Fits `method`.
    ///
    /// # Errors
    /// What the model itself says.
    pub fn fit(
        method: ExampleMethod,
        examples: &Examples,
        options: &ExampleOptions,
    ) -> Result<Self, FitError> {
        ExampleModel::fit_watched(method, examples, options, &|_| ControlFlow::Continue(()))
    }

    /// As [`ExampleModel::fit`], watched: see [`RbfRegression::fit_watched`]. Models that learn nothing are not watched.
    ///
    /// # Errors
    /// As [`ExampleModel::fit`]; [`FitError::Cancelled`].
    pub fn fit_watched(
        method: ExampleMethod,
        examples: &Examples,
        options: &ExampleOptions,
        watch: &Watch<'_>,
    ) -> Result<Self, FitError> {
        Ok(match method {
            ExampleMethod::Gp => {
                ExampleModel::Gp(Box::new(RbfRegression::fit_watched(examples, &options.gp, watch)?))
            }
            ExampleMethod::Mls => {
                ExampleModel::Mls(Box::new(MovingLeastSquares::fit(examples, &options.mls)?))
            }
            ExampleMethod::Nearest => {
                ExampleModel::Nearest(Box::new(NearestExamples::fit(examples, options.neighbours)?))
            }
        })
    }

    /// Which it is.
    pub fn method(&self) -> ExampleMethod {
        match self {
            ExampleModel::Gp(_) => ExampleMethod::Gp,
            ExampleModel::Mls(_) => ExampleMethod::Mls,
            ExampleModel::Nearest(_) => ExampleMethod::Nearest,
        }
    }

    /// The Gaussian process, if it is one.
    pub fn as_gp(&self) -> Option<&RbfRegression> {
        if let ExampleModel::Gp(m) = self { Some(m) } else { None }
    }

    /// The examples.
    pub fn examples(&self) -> &Examples {
        match self {
            ExampleModel::Gp(m) => m.examples(),
            ExampleModel::Mls(m) => m.examples(),
            ExampleModel::Nearest(m) => m.examples(),
        }
    }

    /// Predicts the rows of `inputs` (F × D_x).
    ///
    /// # Errors
    /// A wrong number of coordinates, or one that is not finite.
    pub fn predict_batch(&self, inputs: &DMatrix<f64>) -> Result<Batch, InputError> {
        match self {
            ExampleModel::Gp(m) => m.predict_batch(inputs),
            ExampleModel::Mls(m) => m.predict_batch(inputs),
            ExampleModel::Nearest(m) => m.predict_batch(inputs),
        }
    }

    /// Predicts one input (D_x) into `out`; allocates nothing once `scratch` and `out` have been used with this model.
    ///
    /// # Errors
    /// As [`ExampleModel::predict_batch`].
    pub fn predict(
        &self,
        input: &[f64],
        scratch: &mut Scratch,
        out: &mut Prediction,
    ) -> Result<(), InputError> {
        match self {
            ExampleModel::Gp(m) => m.predict(input, scratch, out),
            ExampleModel::Mls(m) => m.predict(input, scratch, out),
            ExampleModel::Nearest(m) => m.predict(input, scratch, out),
        }
    }

    /// Adds examples without learning again.
    ///
    /// # Errors
    /// As [`Examples::and`], and what the model itself says; it is then what it was.
    pub fn grow(&mut self, more: &Examples) -> Result<(), FitError> {
        match self {
            ExampleModel::Gp(m) => m.grow(more),
            ExampleModel::Mls(m) => m.grow(more),
            ExampleModel::Nearest(m) => m.grow(more),
        }
    }
}

/// The mean of the nearest examples (and images), weighted by inverse distances.
///
/// As [`crate::Nearest`], for examples instead of pairs. Confidence is exp(−½ novelty²), variance the spread of
/// the targets that count, and the mean square of all targets times one less the confidence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "StoredNearest", into = "StoredNearest")]
pub struct NearestExamples {
    known: Known,
    neighbours: usize,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "NearestExamples", deny_unknown_fields)]
struct StoredNearest {
    examples: Examples,
    neighbours: usize,
}

impl From<NearestExamples> for StoredNearest {
    fn from(m: NearestExamples) -> Self {
        StoredNearest { examples: m.known.examples, neighbours: m.neighbours }
    }
}

impl TryFrom<StoredNearest> for NearestExamples {
    type Error = FitError;

    fn try_from(s: StoredNearest) -> Result<Self, FitError> {
        NearestExamples::fit(&s.examples, s.neighbours)
    }
}

impl NearestExamples {
    /// Interpolates between `neighbours` examples and images.
    ///
    /// # Errors
    /// No neighbour, or more than there are.
    pub fn fit(examples: &Examples, neighbours: usize) -> Result<Self, FitError> {
        if neighbours == 0 || neighbours > examples.effective() {
            let allowed = format!("from 1 to {}, the number of examples and images", examples.effective());
            return Err(FitError::Setting { name: "neighbours", value: neighbours as f64, allowed });
        }
        Ok(NearestExamples { known: Known::of(examples), neighbours })
    }

    /// The examples.
    pub fn examples(&self) -> &Examples {
        &self.known.examples
    }

    /// Adds examples.
    ///
    /// # Errors
    /// As [`Examples::and`]; the model is then what it was.
    pub fn grow(&mut self, more: &Examples) -> Result<(), FitError> {
        self.known.grow(more)
    }

    /// Predicts the rows of `inputs` (F × D_x), each as [`NearestExamples::predict`].
    ///
    /// # Errors
    /// A wrong number of coordinates, or one that is not finite.
    pub fn predict_batch(&self, inputs: &DMatrix<f64>) -> Result<Batch, InputError> {
        each(inputs, self.known.dimension(), |input, scratch, out| self.predict(input, scratch, out))
    }

    /// Predicts one input (D_x) into `out`; allocates nothing once `scratch` and `out` have been used with this model.
    ///
    /// # Errors
    /// As [`NearestExamples::predict_batch`].
    pub fn predict(
        &self,
        input: &[f64],
        scratch: &mut Scratch,
        out: &mut Prediction,
    ) -> Result<(), InputError> {
        let known = &self.known;
        let nearest = known.enter(input, scratch)?;
        let Scratch { squared, k: weights, parts, more, .. } = scratch;
        weights.resize(squared.len(), 0.0);
        weigh(squared, self.neighbours, nearest, weights);
        let d = known.dimension();
        parts.clear();
        parts.resize(d, 0.0);
        more.resize(d, 0.0);
        let counting = || weights.iter().enumerate().filter(|(_, w)| **w > 0.0);
        for (i, w) in counting() {
            known.target(i, more);
            crate::dense::axpy(*w, more, parts);
        }
        let mut about = 0.0;
        for (i, w) in counting() {
            known.target(i, more);
            about += w * distance_squared(more, parts);
        }
        out.mean.resize(d, 0.0);
        known.parity.leave(parts, &mut out.mean);
        out.novelty = squared[nearest].sqrt() / known.extent.spacing;
        out.confidence = (-0.5 * out.novelty.powi(2)).exp();
        out.variance = about / d as f64 + (1.0 - out.confidence) * known.mean_square;
        Ok(())
    }
}
