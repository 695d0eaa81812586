//! What models that keep all their examples share: distances to examples and images, targets by parity, rows one by one.
//!
//! In: [`Examples`]. Out: [`Known`], entered by an input.

use nalgebra::DMatrix;

use crate::cloud::{Cloud, Extent};
use crate::dense::distance_squared;
use crate::error::{FitError, InputError};
use crate::examples::Examples;
use crate::parity::Parity;
use crate::rbf::Batch;
use crate::regressor::{Prediction, Scratch};

/// Examples with the distances to them, for models that keep all of them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Known {
    pub examples: Examples,
    cloud: Cloud,
    pub extent: Extent,
    pub parity: Parity,
    /// N × D_y, row-major, in even and odd coordinates.
    targets: Vec<f64>,
    /// Of all targets.
    pub mean_square: f64,
}

impl Known {
    pub fn of(examples: &Examples) -> Self {
        let cloud = Cloud::of(examples);
        let extent = cloud.extent(examples);
        let y = examples.targets();
        let (n, d) = y.shape();
        let parity = Parity::of(examples.mirror().map(|m| m.output.as_slice()), d);
        let mut targets = vec![0.0; n * d];
        for (i, row) in targets.chunks_exact_mut(d).enumerate() {
            parity.enter(|k| y[(i, k)], row);
        }
        let mean_square = crate::dense::dot(&targets, &targets) / targets.len() as f64;
        Known { examples: examples.clone(), cloud, extent, parity, targets, mean_square }
    }

    pub fn grow(&mut self, more: &Examples) -> Result<(), FitError> {
        *self = Known::of(&self.examples.and(more)?);
        Ok(())
    }

    /// Target coordinates.
    pub fn dimension(&self) -> usize {
        self.parity.len()
    }

    /// Enters `input` into `scratch` with its squared distances to all examples and then to all images; returns the
    /// number of the nearest.
    pub fn enter(&self, input: &[f64], scratch: &mut Scratch) -> Result<usize, InputError> {
        let n = self.cloud.len();
        scratch.input.resize(self.cloud.dim(), 0.0);
        self.cloud.enter(input, &mut scratch.input)?;
        scratch.squared.resize(if self.cloud.mirrored() { 2 * n } else { n }, 0.0);
        let (own, image) = scratch.squared.split_at_mut(n);
        self.cloud.squared_one(&scratch.input, own, image);
        let all = &scratch.squared;
        Ok((1..all.len()).fold(0, |b, i| if all[i] < all[b] { i } else { b }))
    }

    /// Writes input `i` (images after all examples), entered.
    pub fn input(&self, i: usize, out: &mut [f64]) {
        let n = self.cloud.len();
        out.copy_from_slice(self.cloud.point(i % n));
        if i >= n {
            out[self.cloud.even()..].iter_mut().for_each(|v| *v = -*v);
        }
    }

    /// Writes target `i` (images after all examples) in even and odd coordinates.
    pub fn target(&self, i: usize, out: &mut [f64]) {
        let (n, d) = (self.cloud.len(), self.dimension());
        out.copy_from_slice(&self.targets[(i % n) * d..(i % n + 1) * d]);
        if i >= n {
            out[self.parity.even..].iter_mut().for_each(|v| *v = -*v);
        }
    }
}

impl Examples {
    /// Mean square over examples of the distance from a target to that of the most alike example or image of another event
    /// ([`Examples::with_moments`]): what nearest neighbours miss, squared units of all target coordinates together. 0 where there is no other event.
    pub fn disagreement(&self) -> f64 {
        let known = Known::of(self);
        let (n, d) = (self.len(), known.dimension());
        let (mut scratch, mut input) = (Scratch::new(), Vec::new());
        let (mut own, mut other) = (vec![0.0; d], vec![0.0; d]);
        let (mut sum, mut count) = (0.0, 0_usize);
        for i in 0..n {
            input.clear();
            input.extend(self.inputs().row(i).iter());
            if known.enter(&input, &mut scratch).is_err() {
                continue; // examples are finite and of one length
            }
            let all = &scratch.squared;
            let apart = (0..all.len()).filter(|j| !self.same_event(i, j % n));
            let Some(j) = apart.min_by(|a, b| all[*a].total_cmp(&all[*b])) else { continue };
            known.target(i, &mut own);
            known.target(j, &mut other);
            sum += distance_squared(&own, &other);
            count += 1;
        }
        if count == 0 { 0.0 } else { sum / count as f64 }
    }
}

/// Predicts the rows of `inputs` one by one.
pub(crate) fn each(
    inputs: &DMatrix<f64>,
    dimension: usize,
    predict: impl Fn(&[f64], &mut Scratch, &mut Prediction) -> Result<(), InputError>,
) -> Result<Batch, InputError> {
    let mut batch = Batch::empty(inputs.nrows(), dimension);
    let (mut scratch, mut out) = (Scratch::new(), Prediction::default());
    let mut input = Vec::new();
    for i in 0..inputs.nrows() {
        input.clear();
        input.extend(inputs.row(i).iter());
        predict(&input, &mut scratch, &mut out)?;
        out.mean.iter().enumerate().for_each(|(k, v)| batch.mean[(i, k)] = *v);
        (batch.variance[i], batch.novelty[i], batch.confidence[i]) =
            (out.variance, out.novelty, out.confidence);
    }
    Ok(batch)
}
