//! Moving least squares (IAF09 §4.4): a linear map fitted anew at every input, examples near it counting most.
//!
//! Weights are exp(−r²/(2 h²)). About the weighted means x̄, ȳ the map minimises Σ w |y_i − ȳ − Bᵀ(x_i − x̄)|² + λ |B|²; the paper
//! prints λ = 0, which is not determined when there are fewer examples near than coordinates. λ is a part of Σ w |x_i − x̄|². The examples
//! of the greatest weights count, [`MlsOptions::neighbours`] of them, images among them.
//!
//! Confidence is the mean of the three highest weights. The mean far from the examples is that of the nearest ones: only
//! variance and confidence say that it means nothing there. Variance is the mean square residual at the examples that
//! count, and the mean square of all targets times one less the confidence.
//!
//! IAF09: Ikemoto, Arikan, Forsyth. Generalizing motion edits with Gaussian processes. ACM TOG 28(1), 2009.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::dense::{axpy, cholesky, dot};
use crate::error::{FitError, InputError};
use crate::examples::Examples;
use crate::known::{Known, each};
use crate::rbf::Batch;
use crate::regressor::{Prediction, Scratch};

/// Weights whose mean is the confidence.
const HIGHEST: usize = 3;

/// How the map is fitted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MlsOptions {
    /// h, units of the inputs; the spacing of the examples if not given ([`Batch::novelty`]).
    pub width: Option<f64>,
    /// Examples and images that count, at most.
    pub neighbours: usize,
    /// λ over Σ w |x_i − x̄|²; positive.
    pub ridge: f64,
}

impl Default for MlsOptions {
    fn default() -> Self {
        MlsOptions { width: None, neighbours: 64, ridge: 1e-3 }
    }
}

/// Examples with a weight function.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Stored", into = "Stored")]
pub struct MovingLeastSquares {
    known: Known,
    options: MlsOptions,
    width: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "MovingLeastSquares", deny_unknown_fields)]
struct Stored {
    examples: Examples,
    options: MlsOptions,
    width: f64,
}

impl From<MovingLeastSquares> for Stored {
    fn from(m: MovingLeastSquares) -> Self {
        Stored { examples: m.known.examples, options: m.options, width: m.width }
    }
}

impl TryFrom<Stored> for MovingLeastSquares {
    type Error = FitError;

    fn try_from(s: Stored) -> Result<Self, FitError> {
        let at = MlsOptions { width: Some(s.width), ..s.options.clone() };
        Ok(MovingLeastSquares { options: s.options, ..MovingLeastSquares::fit(&s.examples, &at)? })
    }
}

impl MovingLeastSquares {
    /// Of examples.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn fit(examples: &Examples, options: &MlsOptions) -> Result<Self, FitError> {
        let refuse =
            |name, value, allowed: &str| Err(FitError::Setting { name, value, allowed: allowed.to_string() });
        let known = Known::of(examples);
        let width = options.width.unwrap_or(known.extent.spacing);
        if !(width.is_finite() && width > 0.0) {
            return refuse("width", width, "positive");
        }
        if options.neighbours == 0 {
            return refuse("neighbours", 0.0, "at least 1");
        }
        if !(options.ridge.is_finite() && options.ridge > 0.0) {
            return refuse("ridge", options.ridge, "positive");
        }
        Ok(MovingLeastSquares { known, options: options.clone(), width })
    }

    /// The examples.
    pub fn examples(&self) -> &Examples {
        &self.known.examples
    }

    /// h, units of the inputs.
    pub fn width(&self) -> f64 {
        self.width
    }

    /// Adds examples; h stays.
    ///
    /// # Errors
    /// As [`Examples::and`]; the model is then what it was.
    pub fn grow(&mut self, more: &Examples) -> Result<(), FitError> {
        self.known.grow(more)
    }

    /// Predicts the rows of `inputs` (F × D_x), each as [`MovingLeastSquares::predict`].
    ///
    /// # Errors
    /// A wrong number of coordinates, or one that is not finite.
    pub fn predict_batch(&self, inputs: &DMatrix<f64>) -> Result<Batch, InputError> {
        each(inputs, self.known.dimension(), |input, scratch, out| self.predict(input, scratch, out))
    }

    /// Predicts one input (D_x) into `out`; allocates nothing once `scratch` and `out` have been used with this model.
    ///
    /// # Errors
    /// As [`MovingLeastSquares::predict_batch`].
    pub fn predict(
        &self,
        input: &[f64],
        scratch: &mut Scratch,
        out: &mut Prediction,
    ) -> Result<(), InputError> {
        let known = &self.known;
        let nearest = known.enter(input, scratch)?;
        let Scratch { input: x, squared, k: z, w: gram, parts, more, order, .. } = scratch;
        let (dx, dy) = (x.len(), known.dimension());
        let least = squared[nearest];
        out.novelty = least.sqrt() / known.extent.spacing;

        let count = self.options.neighbours.min(squared.len());
        order.clear();
        order.extend(0..squared.len());
        let by = |a: &usize, b: &usize| squared[*a].total_cmp(&squared[*b]).then(a.cmp(b));
        if count < order.len() {
            order.select_nth_unstable_by(count, by);
            order.truncate(count);
        }
        order.sort_unstable_by(by);
        let scale = -0.5 / self.width.powi(2);
        let highest = HIGHEST.min(count);
        out.confidence =
            order[..highest].iter().map(|&i| (scale * squared[i]).exp()).sum::<f64>() / highest as f64;

        // Weights over the largest, so that none is lost far away; rows √w (x_i − x̄) in `z`, √w (y_i − ȳ) in `more`.
        let weight = |i: usize| (scale * (squared[i] - least)).exp();
        let total: f64 = order.iter().map(|&i| weight(i)).sum();
        z.clear();
        z.resize((count + 1) * dx, 0.0);
        more.clear();
        more.resize((count + 1) * dy, 0.0);
        let (mean_x, z) = z.split_at_mut(dx);
        let (mean_y, r) = more.split_at_mut(dy);
        for (row, (&i, r)) in z.chunks_exact_mut(dx).zip(order.iter().zip(r.chunks_exact_mut(dy))) {
            known.input(i, row);
            known.target(i, r);
            axpy(weight(i) / total, row, mean_x);
            axpy(weight(i) / total, r, mean_y);
        }
        let mut trace = 0.0;
        for (row, (&i, r)) in z.chunks_exact_mut(dx).zip(order.iter().zip(r.chunks_exact_mut(dy))) {
            let root = weight(i).sqrt();
            row.iter_mut().zip(mean_x.iter()).for_each(|(v, m)| *v = root * (*v - m));
            r.iter_mut().zip(mean_y.iter()).for_each(|(v, m)| *v = root * (*v - m));
            trace += dot(row, row);
        }
        parts.clear();
        parts.extend_from_slice(mean_y);
        let lambda = self.options.ridge * trace;
        let mut left = dot(r, r);
        if lambda > 0.0 {
            gram.clear();
            gram.resize(count * count, 0.0);
            for i in 0..count {
                for j in 0..=i {
                    gram[i * count + j] = dot(&z[i * dx..(i + 1) * dx], &z[j * dx..(j + 1) * dx]);
                }
                gram[i * count + i] += lambda;
            }
            if cholesky(gram, count) {
                solve(gram, count, r, dy);
                // residual at the examples: λ (G + λ I)⁻¹ R
                left = lambda * lambda * dot(r, r);
                for (row, a) in z.chunks_exact(dx).zip(r.chunks_exact(dy)) {
                    let k: f64 =
                        row.iter().zip(x.iter().zip(mean_x.iter())).map(|(z, (x, m))| z * (x - m)).sum();
                    axpy(k, a, parts);
                }
            }
        }
        out.mean.resize(dy, 0.0);
        known.parity.leave(parts, &mut out.mean);
        out.variance = left / (total * dy as f64) + (1.0 - out.confidence) * known.mean_square;
        Ok(())
    }
}

/// (L Lᵀ)⁻¹ b in place of `b` (n × m) by L of [`cholesky`].
fn solve(l: &[f64], n: usize, b: &mut [f64], m: usize) {
    for i in 0..n {
        let (above, row) = b.split_at_mut(i * m);
        let row = &mut row[..m];
        for (k, a) in above.chunks_exact(m).enumerate() {
            axpy(-l[i * n + k], a, row);
        }
        row.iter_mut().for_each(|v| *v /= l[i * n + i]);
    }
    for i in (0..n).rev() {
        let (head, below) = b.split_at_mut((i + 1) * m);
        let row = &mut head[i * m..];
        for (k, a) in below.chunks_exact(m).enumerate() {
            axpy(-l[(i + 1 + k) * n + i], a, row);
        }
        row.iter_mut().for_each(|v| *v /= l[i * n + i]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dense::distance_squared;

    /// Solving is the inverse of multiplying.
    #[test]
    fn the_solution_solves() {
        let a = [4.0, 0.0, 0.0, 1.0, 3.0, 0.0, -0.5, 0.2, 2.0];
        let x = [1.0, 2.0, -1.0, 0.5, 3.0, -2.0];
        let full = |i: usize, j: usize| if i >= j { a[3 * i + j] } else { a[3 * j + i] };
        let mut b = [0.0; 6];
        for i in 0..3 {
            for c in 0..2 {
                b[2 * i + c] = (0..3).map(|j| full(i, j) * x[2 * j + c]).sum();
            }
        }
        let mut l = a;
        assert!(cholesky(&mut l, 3));
        solve(&l, 3, &mut b, 2);
        assert!(distance_squared(&b, &x) < 1e-28, "{b:?}");
    }
}
