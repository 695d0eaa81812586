//! Maps learned from pairs of vectors: plain matrices in, plain matrices out. Knows no bodies.
//!
//! In: [`Pairs`] of an input and an output vector each (rows of two matrices, any unit). Out: a model that
//! predicts the output for a new input, with a variance, a confidence, and whether it extrapolates. All
//! models of pairs are [`Regressor`]s and are fixed once fitted; [`Scratch`] is what a prediction writes into.
//!
//! | module | holds |
//! |---|---|
//! | [`pairs`] | checked pairs |
//! | [`regressor`] | what every model can do: predict, with variance; the covariance of what it does not know |
//! | [`gplvm`] | shared Gaussian process latent variable model of YAH10 |
//! | [`gp`] | Gaussian process regression |
//! | [`examples`] | examples of an edit, with mirror images and where they are from |
//! | [`by_example`] | any model of examples by its name |
//! | [`rbf`] | GP regression of many examples; grows; inducing points |
//! | [`mls`] | moving least squares |
//! | [`pca`] | principal components and a linear map |
//! | [`nearest`] | interpolation of nearest neighbours |
//! | [`model`] | any of these by name, and as stored |
//! | [`sequence`] | frames mapped one after the other; how smooth a latent path is |
//! | [`mod@suggest`] | which frames to key next |
//! | [`validate`] | errors on pairs left out |
//! | [`kcca`] | kernel canonical correlation analysis |
//! | [`kernel`] | the kernel of the Gaussian processes |
//! | [`dtw`] | dynamic time warping: which frame of one series belongs to which of another |
//! | [`ica`] | principal and independent components of many channels (FastICA) |
//! | [`error`] | what can be wrong |
//!
//! ```
//! use learn::{GplvmOptions, Mapper, Method, Model, Pairs};
//! use nalgebra::DMatrix;
//!
//! // Twelve poses of a joint at t/10 rad; a lamp whose two angles answer with sines.
//! let human = DMatrix::from_fn(12, 2, |i, k| 0.1 * i as f64 * if k == 0 { 1.0 } else { -0.5 });
//! let lamp = DMatrix::from_fn(12, 2, |i, k| (0.1 * i as f64 + k as f64).sin());
//! let model = Model::fit(Method::Gplvm, &Pairs::new(&human, &lamp)?, &GplvmOptions::default())?;
//! let mut mapper = Mapper::new(&model);
//! let pose = mapper.map(&[0.55, -0.275])?;
//! assert!((pose.mean[0] - 0.55_f64.sin()).abs() < 0.01);
//! assert!(pose.confidence > 0.99 && !pose.extrapolates());
//! assert!(mapper.map(&[3.0, 3.0])?.extrapolates());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Examples of an edit, predicted where there are none:
//!
//! ```
//! use learn::{ExampleMethod, ExampleModel, ExampleOptions, Examples};
//! use nalgebra::DMatrix;
//!
//! // An edit that adds half a knee's angle to the spine; forty frames, one coordinate each.
//! let knee = DMatrix::from_fn(40, 1, |i, _| (0.3 * i as f64).sin());
//! let examples = Examples::new(knee.clone(), knee * 0.5, None)?;
//! let model = ExampleModel::fit(ExampleMethod::Gp, &examples, &ExampleOptions::default())?;
//! let batch = model.predict_batch(&DMatrix::from_row_slice(2, 1, &[0.25, 40.0]))?;
//! assert!((batch.mean[(0, 0)] - 0.125).abs() < 1e-3 && batch.novelty[0] < 1.0);
//! assert!(batch.mean[(1, 0)].abs() < 1e-3 && batch.novelty[1] > 10.0); // nothing is known there: no edit
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! YAH10: Yamane, Ariki, Hodgins. Animating non-humanoid characters with human motion data. SCA 2010.

mod blocked;
pub mod by_example;
mod cloud;
mod cover;
mod dense;
mod descend;
pub mod dtw;
pub mod error;
pub mod examples;
#[cfg(test)]
mod fixture;
pub mod gp;
pub mod gplvm;
pub mod ica;
pub mod kcca;
pub mod kernel;
mod known;
mod likelihood;
pub mod mls;
pub mod model;
pub mod nearest;
pub mod pairs;
mod parity;
pub mod pca;
mod posterior;
pub mod rbf;
pub mod regressor;
pub mod sequence;
pub mod suggest;
pub mod validate;

pub use by_example::{ExampleMethod, ExampleModel, ExampleOptions, NearestExamples};
pub use descend::Watch;
pub use error::{FitError, InputError};
pub use examples::{Examples, Mirror, Moment};
pub use gp::GpRegression;
pub use gplvm::{GplvmOptions, Learning, Locate, SharedGplvm, Start};
pub use kcca::KernelCca;
pub use kernel::Kernel;
pub use mls::{MlsOptions, MovingLeastSquares};
pub use model::{Method, Model, UnknownMethod};
pub use nearest::Nearest;
pub use pairs::Pairs;
pub use pca::PcaLinear;
pub use rbf::{Batch, RbfKernel, RbfOptions, RbfRegression, Residuals};
pub use regressor::{Jump, PosteriorCovariance, Prediction, Regressor, Scratch};
pub use sequence::{Mapped, Mapper, PathShape, map_frames, path_shape};
pub use suggest::{Suggestion, suggest};
pub use validate::{LeftOut, key_pose_error, leave_out, rms_error};
