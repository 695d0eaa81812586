//! How good is a model on pairs it has not seen?

use nalgebra::DMatrix;

use crate::error::{FitError, InputError};
use crate::gplvm::GplvmOptions;
use crate::model::{Method, Model};
use crate::pairs::Pairs;
use crate::regressor::{Prediction, Regressor, Scratch};

/// A pair left out and what was predicted for it.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// Which pair.
    pub pair: usize,
    /// Prediction by a model fitted without its group.
    pub prediction: Prediction,
    /// RMS error over the coordinates, in the units of the outputs.
    pub rms: f64,
}

/// Why cross-validation stopped.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ValidationError {
    /// What is left when a group is out cannot be learned from.
    #[error("without group {group}: {source}")]
    Fit {
        /// The group.
        group: usize,
        /// What is wrong.
        source: FitError,
    },
    /// A pair cannot be predicted.
    #[error(transparent)]
    Input(#[from] InputError),
}

/// Fits `method` without each of `groups` of pairs in turn and predicts the group; one pair a group is
/// leave-one-out, one performance a group leave-one-performance-out.
///
/// # Errors
/// A group without which there is too little to learn from, a number beyond the pairs.
pub fn leave_out(
    pairs: &Pairs,
    method: Method,
    options: &GplvmOptions,
    groups: &[Vec<usize>],
) -> Result<Vec<LeftOut>, ValidationError> {
    let mut all = Vec::new();
    for (group, out) in groups.iter().enumerate() {
        if let Some(&frame) = out.iter().find(|&&i| i >= pairs.len()) {
            return Err(InputError::Frame { frame, frames: pairs.len() }.into());
        }
        let keep: Vec<usize> = (0..pairs.len()).filter(|i| !out.contains(i)).collect();
        let fit = |source| ValidationError::Fit { group, source };
        let rest = pairs.subset(&keep).map_err(fit)?;
        let mut options = options.clone();
        options.dimension = options.dimension.map(|q| q.min(keep.len().saturating_sub(1)));
        let model = Model::fit(method, &rest, &options).map_err(fit)?;
        for &pair in out {
            // Each pair from its own nearest key pose: pairs left out are no sequence.
            let (mut scratch, mut prediction) = (Scratch::new(), Prediction::default());
            model.predict(pairs.input(pair), &mut scratch, &mut prediction)?;
            let rms = rms(&prediction.mean, pairs.output(pair));
            all.push(LeftOut { pair, prediction, rms });
        }
    }
    Ok(all)
}

/// RMS error of a model over the coordinates of given pairs (rows: F × D_Y, F × D_Z), each mapped by itself;
/// in the units of the outputs; zero of no pairs.
///
/// # Errors
/// As [`Regressor::predict`].
pub fn rms_error<R: Regressor + ?Sized>(
    model: &R,
    inputs: &DMatrix<f64>,
    outputs: &DMatrix<f64>,
) -> Result<f64, InputError> {
    let (mut scratch, mut out) = (Scratch::new(), Prediction::default());
    let mut sum = 0.0;
    for i in 0..inputs.nrows() {
        scratch.forget();
        let input: Vec<f64> = inputs.row(i).iter().copied().collect();
        let output: Vec<f64> = outputs.row(i).iter().copied().collect();
        model.predict(&input, &mut scratch, &mut out)?;
        sum += rms(&out.mean, &output).powi(2);
    }
    Ok((sum / inputs.nrows().max(1) as f64).sqrt())
}

/// RMS error at the pairs the model was fitted to, in the units of the outputs: the first criterion of YAH10
/// §6.2.
///
/// # Errors
/// None for a fitted model.
pub fn key_pose_error<R: Regressor + ?Sized>(model: &R) -> Result<f64, InputError> {
    let pairs = model.pairs();
    rms_error(model, &pairs.inputs().transpose(), &pairs.outputs().transpose())
}

/// Root of the mean squared difference.
fn rms(a: &[f64], b: &[f64]) -> f64 {
    (crate::dense::distance_squared(a, b) / b.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_of_nothing_is_zero() {
        assert_eq!(
            (rms(&[], &[]), rms(&[0.0; 3], &[0.0; 3]), rms(&[3.0, 4.0], &[0.0; 2])),
            (0.0, 0.0, 12.5f64.sqrt())
        );
    }
}
