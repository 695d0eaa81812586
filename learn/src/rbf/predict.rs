//! Predictions: many inputs in chunks, and one without allocating.

use nalgebra::DMatrix;

use super::RbfRegression;
use super::half::join;
use crate::cloud::{CHUNK, Squared, scale};
use crate::error::InputError;
use crate::parity::Sign;
use crate::regressor::{Prediction, Scratch};

/// Predictions for many inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// F × D_y.
    pub mean: DMatrix<f64>,
    /// Variance of every coordinate of a target about the mean, noise included, squared units of the targets; one an input.
    pub variance: Vec<f64>,
    /// Distance to the nearest example (or image) over the spacing of the examples: above 1, 99 % of the examples are nearer to
    /// each other than this input is to any. Neighbours in time and repetitions do not count for the spacing
    /// ([`crate::Examples::with_moments`]).
    pub novelty: Vec<f64>,
    /// From 0, nothing is known, to 1. Of Gaussian processes 1 − (variance left, without noise)/σ_f²; the other models say in
    /// their own words.
    pub confidence: Vec<f64>,
}

impl Batch {
    pub(crate) fn empty(rows: usize, columns: usize) -> Self {
        Batch {
            mean: DMatrix::zeros(rows, columns),
            variance: vec![0.0; rows],
            novelty: vec![0.0; rows],
            confidence: vec![0.0; rows],
        }
    }
}

impl RbfRegression {
    /// Predicts the rows of `inputs` (F × D_x). A row's answer does not depend on the other rows, to the bit; it is that
    /// of [`RbfRegression::predict`] to rounding.
    ///
    /// # Errors
    /// A wrong number of coordinates, or one that is not finite.
    pub fn predict_batch(&self, inputs: &DMatrix<f64>) -> Result<Batch, InputError> {
        let (rows, d) = (inputs.nrows(), self.targets.dimension());
        let mut out = Batch::empty(rows, d);
        let (mut row, mut x, mut seen) = (Vec::new(), Vec::new(), Vec::new());
        let (mut squared, mut near) = (Squared::default(), Squared::default());
        let (mut k, mut second, mut mean) = (Vec::new(), Vec::new(), Vec::new());
        let (mut parts, mut back) = (vec![0.0; CHUNK * d], vec![0.0; d]);
        let dim = self.cloud.dim();
        for from in (0..rows).step_by(CHUNK) {
            let count = self.cloud.enter_chunk(inputs, from, &mut row, &mut x)?;
            if let Some(weighted) = &self.weighted {
                seen.clear();
                seen.extend_from_slice(&x);
                seen.chunks_exact_mut(dim).for_each(|x| scale(x, &weighted.scales));
                self.basis().squared(&seen, CHUNK, &mut squared);
            } else {
                self.basis().squared(&x, CHUNK, &mut squared);
            }
            let distances = if self.inducing.is_some() || self.weighted.is_some() {
                self.cloud.squared(&x, CHUNK, &mut near);
                &near
            } else {
                &squared
            };
            for i in 0..count {
                let nearest = self.cloud.nearest(distances, i, CHUNK, &x[i * dim..(i + 1) * dim]);
                out.novelty[from + i] = nearest / self.extent.spacing;
            }
            self.kernel.of(&mut squared.own);
            self.kernel.of(&mut squared.image);
            let mut known = [0.0; CHUNK];
            for half in &self.halves {
                join(half.sign, &squared, &mut k);
                half.whiten(&mut k, CHUNK, &mut second);
                half.answer(&k, &second, CHUNK, &mut mean, &mut known);
                for (p, m) in parts.chunks_exact_mut(d).zip(mean.chunks_exact(half.columns.max(1))) {
                    p[half.first..half.first + half.columns].copy_from_slice(&m[..half.columns]);
                }
            }
            for i in 0..count {
                self.leave(&mut parts[i * d..(i + 1) * d], &mut back);
                for (k, v) in back.iter().enumerate() {
                    out.mean[(from + i, k)] = *v;
                }
                (out.variance[from + i], out.confidence[from + i]) = self.doubt(known[i]);
            }
        }
        Ok(out)
    }

    /// Predicts one input (D_x) into `out`; allocates nothing once `scratch` and `out` have been used with this model.
    ///
    /// # Errors
    /// As [`RbfRegression::predict_batch`].
    pub fn predict(
        &self,
        input: &[f64],
        scratch: &mut Scratch,
        out: &mut Prediction,
    ) -> Result<(), InputError> {
        let (n, d) = (self.basis().len(), self.targets.dimension());
        scratch.input.resize(self.cloud.dim(), 0.0);
        self.cloud.enter(input, &mut scratch.input)?;
        let images = if self.cloud.mirrored() { 2 } else { 1 };
        let all = self.cloud.len();
        scratch.squared.resize(images * all.max(n), 0.0);
        let (own, image) = scratch.squared.split_at_mut(all);
        self.cloud.squared_one(&scratch.input, own, image);
        let least =
            own.iter().chain(image.iter().take((images - 1) * all)).fold(f64::INFINITY, |a, v| a.min(*v));
        out.novelty = least.sqrt() / self.extent.spacing;
        let (own, image) = scratch.squared[..images * n].split_at_mut(n);
        if let Some(weighted) = &self.weighted {
            scale(&mut scratch.input, &weighted.scales);
        }
        if self.inducing.is_some() || self.weighted.is_some() {
            self.basis().squared_one(&scratch.input, own, image);
        }
        self.kernel.of(own);
        self.kernel.of(image);
        scratch.parts.resize(d, 0.0);
        let mut known = 0.0;
        for half in &self.halves {
            scratch.k.clear();
            match half.sign {
                Sign::Only => scratch.k.extend_from_slice(own),
                sign => scratch.k.extend(own.iter().zip(image.iter()).map(|(a, b)| sign.join(*a, *b))),
            }
            half.whiten_one(&mut scratch.k, &mut scratch.w);
            let mean = &mut scratch.parts[half.first..half.first + half.columns];
            known += half.answer_one(&scratch.k, &scratch.w, mean);
        }
        out.mean.resize(d, 0.0);
        self.leave(&mut scratch.parts, &mut out.mean);
        (out.variance, out.confidence) = self.doubt(known);
        Ok(())
    }

    /// From even and odd target coordinates to the targets' own.
    fn leave(&self, parts: &mut [f64], out: &mut [f64]) {
        parts.iter_mut().zip(&self.targets.centre).for_each(|(p, c)| *p += c);
        self.targets.parity.leave(parts, out);
    }

    /// Variance with noise, and confidence.
    fn doubt(&self, known: f64) -> (f64, f64) {
        let signal = self.kernel.signal_variance;
        let left = (signal - known).clamp(0.0, signal);
        (left + self.kernel.noise_variance, 1.0 - left / signal)
    }
}
