//! Principal components of both spaces and a linear map between them: the linear baseline of YAH10 §6.4.
//!
//! Inputs and outputs are projected on their first components (30, at most N − 1), the map between the
//! scores is least squares. With N − 1 components it passes through every pair; its variance is that of
//! leave-one-out residuals, which does not call that perfect: for hat matrix H, e_i = (z − Hz)_i/(1 − h_ii),
//! and where the map interpolates, e_i = (G z)_i/G_ii with G the pseudo-inverse of the centred Gram matrix
//! (Dubrule).
//!
//! Dubrule. Cross validation of kriging in a unique neighborhood. Math. Geology 1983.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::cover::Cover;
use crate::dense::{matvec, matvec_transposed};
use crate::error::{FitError, InputError};
use crate::kcca::{check_directions, eigen};
use crate::pairs::{Pairs, Space};
use crate::regressor::{PosteriorCovariance, Prediction, Regressor, Scratch};

/// Components of the paper.
const COMPONENTS: usize = 30;
/// Eigenvalues below this share of the largest are rounding.
const RANK: f64 = 1e-10;

/// PCA of both spaces and a linear map between the components.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Stored", into = "Stored")]
pub struct PcaLinear {
    pairs: Pairs,
    asked: Option<usize>,
    cover: Cover,
    output: Space,
    components: usize,
    /// V_y, components × D_Y: input directions as rows.
    directions: Vec<f64>,
    /// Components × D_Z: what a unit along a direction does to the output.
    map: Vec<f64>,
    /// N/λ of every direction: 1/variance of the scores.
    precision: Vec<f64>,
    /// Mean squared leave-one-out residual, in units of the outputs' variance.
    residual: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "PcaLinear", deny_unknown_fields)]
struct Stored {
    pairs: Pairs,
    components: Option<usize>,
}

impl From<PcaLinear> for Stored {
    fn from(m: PcaLinear) -> Self {
        Stored { pairs: m.pairs, components: m.asked }
    }
}

impl TryFrom<Stored> for PcaLinear {
    type Error = FitError;

    fn try_from(s: Stored) -> Result<Self, FitError> {
        PcaLinear::fit(&s.pairs, s.components)
    }
}

impl PcaLinear {
    /// Fits with `components` of both spaces, 1 to N − 1; `None`: min(30, N − 1). Directions along which
    /// nothing varies are left out.
    ///
    /// # Errors
    /// A number of components out of range.
    pub fn fit(pairs: &Pairs, components: Option<usize>) -> Result<Self, FitError> {
        let n = pairs.len();
        let most = components.unwrap_or(COMPONENTS.min(n - 1));
        check_directions(most, n)?;
        let cover = Cover::as_wide_as_the_data(pairs.inputs())?;
        let output = Space::of(pairs.outputs());
        let y = &cover.space.points;
        let (values, u) = eigen(y.tr_mul(y));
        let full = rank(values.as_slice(), n - 1);
        let r = most.min(full);
        // The outputs on their own first components: Z U_z U_zᵀ.
        let (z_values, uz) = eigen(output.points.tr_mul(&output.points));
        let rz = most.min(rank(z_values.as_slice(), n - 1));
        let uz = uz.columns(0, rz);
        let z = (&output.points * uz) * uz.transpose();
        // V = Y U Λ^−½; map = Λ^−½ Uᵀ Zᵀ.
        let mut directions = Vec::new();
        let mut map = Vec::new();
        for k in 0..r {
            let unit = 1.0 / values[k].sqrt();
            directions.extend((y * u.column(k) * unit).iter());
            map.extend((&z * u.column(k) * unit).iter());
        }
        let ur = u.columns(0, r);
        let residual = if r == n - 1 {
            let inverse = ur * DMatrix::from_diagonal(&values.rows(0, r).map(|v| 1.0 / v)) * ur.transpose();
            mean_square(&(&z * &inverse), |i| inverse[(i, i)])
        } else {
            let hat = ur * ur.transpose();
            mean_square(&(&z - &z * &hat), |i| 1.0 - 1.0 / n as f64 - hat[(i, i)])
        };
        let precision = values.rows(0, r).iter().map(|v| n as f64 / v).collect();
        Ok(PcaLinear {
            pairs: pairs.clone(),
            asked: components,
            cover,
            output,
            components: r,
            directions,
            map,
            precision,
            residual,
        })
    }

    /// Components in use.
    pub fn components(&self) -> usize {
        self.components
    }
}

/// Eigenvalues that are not rounding, at most `most`; at least one.
fn rank(values: &[f64], most: usize) -> usize {
    values.iter().take(most).filter(|v| **v > RANK * values[0]).count().max(1)
}

/// Mean over coordinates and columns i of (column i of `e` / `scale(i)`)².
fn mean_square(e: &DMatrix<f64>, scale: impl Fn(usize) -> f64) -> f64 {
    // a pair that no other shares a direction with has leverage 1: both its scale and its residual are 0
    let sum: f64 = (0..e.ncols()).map(|i| e.column(i).norm_squared() / scale(i).max(1e-9).powi(2)).sum();
    sum / e.len() as f64
}

impl Regressor for PcaLinear {
    fn pairs(&self) -> &Pairs {
        &self.pairs
    }

    fn predict(&self, input: &[f64], scratch: &mut Scratch, out: &mut Prediction) -> Result<(), InputError> {
        let (_, novelty, left) = self.cover.enter(input, scratch)?;
        let n = self.pairs.len() as f64;
        let scores = &mut scratch.w[..self.components];
        matvec(&self.directions, &scratch.input, scores);
        out.mean.resize(self.pairs.output_dim(), 0.0);
        matvec_transposed(&self.map, scores, &mut out.mean);
        for (v, m) in out.mean.iter_mut().zip(&self.output.mean) {
            *v = m + self.output.scale * *v;
        }
        // the mean leverage of the components, not their sum: with N − 1 components, which leave no degree of freedom,
        // the sum would make every variance N times too large
        let leverage: f64 = scores.iter().zip(&self.precision).map(|(s, p)| s * s * p).sum();
        out.variance =
            self.output.scale.powi(2) * self.residual * (1.0 + leverage / (n * self.components as f64));
        out.confidence = (1.0 - left).clamp(0.0, 1.0);
        out.novelty = novelty;
        Ok(())
    }

    fn posterior_covariance(&self, frames: &DMatrix<f64>) -> Result<PosteriorCovariance, InputError> {
        self.cover.posterior_covariance(frames)
    }
}
