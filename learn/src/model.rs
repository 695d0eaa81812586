//! Any of the five models behind one type: what a command line names and a file stores.
//!
//! What is stored is what was learned; everything that follows from it is computed again, the same to the bit. RON
//! keeps every bit of a number; JSON only with `serde_json`'s `float_roundtrip`.

use std::fmt;
use std::str::FromStr;

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::error::{FitError, InputError};
use crate::gp::GpRegression;
use crate::gplvm::{GplvmOptions, SharedGplvm};
use crate::nearest::Nearest;
use crate::pairs::Pairs;
use crate::pca::PcaLinear;
use crate::regressor::{PosteriorCovariance, Prediction, Regressor, Scratch};

/// A way to learn a map from pairs, by the name it has on a command line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Shared GPLVM.
    #[default]
    Gplvm,
    /// GP regression.
    Gp,
    /// PCA and a linear map.
    Pca,
    /// Three nearest neighbours.
    Nn3,
    /// Ten nearest neighbours.
    Nn10,
}

impl Method {
    /// All of them, the paper's own first.
    pub const ALL: [Method; 5] = [Method::Gplvm, Method::Gp, Method::Pca, Method::Nn3, Method::Nn10];

    /// `gplvm`, `gp`, `pca`, `nn3`, `nn10`.
    pub const fn name(self) -> &'static str {
        match self {
            Method::Gplvm => "gplvm",
            Method::Gp => "gp",
            Method::Pca => "pca",
            Method::Nn3 => "nn3",
            Method::Nn10 => "nn10",
        }
    }

    /// Pairs it needs at least.
    pub fn least_pairs(self) -> usize {
        match self {
            Method::Gplvm | Method::Nn3 => 3,
            Method::Gp | Method::Pca => 2,
            Method::Nn10 => 10,
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Not the name of a method.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown model `{found}`; known are gplvm, gp, pca, nn3, nn10")]
pub struct UnknownMethod {
    /// What was given.
    pub found: String,
}

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(s: &str) -> Result<Self, UnknownMethod> {
        let found = || UnknownMethod { found: s.into() };
        Method::ALL.into_iter().find(|m| m.name() == s).ok_or_else(found)
    }
}

/// A fitted model of any kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Model {
    /// Shared GPLVM.
    Gplvm(Box<SharedGplvm>),
    /// GP regression.
    Gp(Box<GpRegression>),
    /// PCA and a linear map.
    Pca(Box<PcaLinear>),
    /// Nearest neighbours.
    Nearest(Box<Nearest>),
}

impl Model {
    /// Fits `method` with its default settings; `gplvm` are those of the shared GPLVM, which the others do
    /// not need.
    ///
    /// # Errors
    /// Fewer pairs than [`Method::least_pairs`], and what the model itself says.
    pub fn fit(method: Method, pairs: &Pairs, gplvm: &GplvmOptions) -> Result<Self, FitError> {
        pairs.at_least(method.least_pairs())?;
        Ok(match method {
            Method::Gplvm => Model::Gplvm(Box::new(SharedGplvm::fit(pairs, gplvm)?)),
            Method::Gp => Model::Gp(Box::new(GpRegression::fit(pairs)?)),
            Method::Pca => Model::Pca(Box::new(PcaLinear::fit(pairs, None)?)),
            Method::Nn3 => Model::Nearest(Box::new(Nearest::fit(pairs, 3)?)),
            Method::Nn10 => Model::Nearest(Box::new(Nearest::fit(pairs, 10)?)),
        })
    }

    fn inner(&self) -> &dyn Regressor {
        match self {
            Model::Gplvm(m) => m.as_ref(),
            Model::Gp(m) => m.as_ref(),
            Model::Pca(m) => m.as_ref(),
            Model::Nearest(m) => m.as_ref(),
        }
    }

    /// The shared GPLVM, if it is one.
    pub fn as_gplvm(&self) -> Option<&SharedGplvm> {
        if let Model::Gplvm(m) = self { Some(m) } else { None }
    }
}

impl Regressor for Model {
    fn pairs(&self) -> &Pairs {
        self.inner().pairs()
    }

    fn predict(&self, input: &[f64], scratch: &mut Scratch, out: &mut Prediction) -> Result<(), InputError> {
        self.inner().predict(input, scratch, out)
    }

    fn posterior_covariance(&self, frames: &DMatrix<f64>) -> Result<PosteriorCovariance, InputError> {
        self.inner().posterior_covariance(frames)
    }
}
