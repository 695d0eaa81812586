//! Principal components, scaled to unit variance: what is left for a rotation to tell apart.
//!
//! In: observations (rows) of channels. Out: mean, the first k eigenvectors V (columns) and eigenvalues Λ of the
//! covariance (1/n); z = Λ^−½ Vᵀ (x − E{x}), x ≈ E{x} + V Λ^½ z.

use nalgebra::{DMatrix, DVector};

use crate::kcca::eigen;

/// Eigenvalues below this share of the largest are rounding of the covariance.
const RANK: f64 = 1e-12;
/// Singular values below this share of the largest are rounding of the data.
const EXACT_RANK: f64 = 1e-13;

/// Variances, directions and rank by singular values of the data: all directions that are more than its rounding, where the
/// eigenvalues of the covariance would lose those below 1e-6 of the largest deviation.
fn exact(centred: &DMatrix<f64>) -> (DVector<f64>, DMatrix<f64>, usize) {
    let n = centred.nrows();
    let r = if n > centred.ncols() { centred.clone().qr().r() } else { centred.clone() };
    let svd = r.svd(false, true);
    let v = svd.v_t.expect("asked for").transpose();
    let rank = svd.singular_values.iter().filter(|s| **s > EXACT_RANK * svd.singular_values[0]).count();
    (svd.singular_values.map(|s| s * s / n as f64), v, rank)
}

/// How many components.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Count {
    /// As many, 1 or more.
    Number(usize),
    /// The fewest that explain at least this share of the variance, above 0 and at most 1; 1 is every direction.
    Share(f64),
}

/// Why observations cannot be decomposed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum IcaError {
    /// Too few observations.
    #[error("{found} observations, at least {least} are needed")]
    TooFew {
        /// Observations given.
        found: usize,
        /// Observations needed.
        least: usize,
    },
    /// NaN or infinite.
    #[error("observation {observation}, channel {channel} is {value}")]
    NotFinite {
        /// Which observation, counted from 0.
        observation: usize,
        /// Which channel, counted from 0.
        channel: usize,
        /// What is there.
        value: f64,
    },
    /// Nothing varies.
    #[error("all {channels} channels stand still: there is nothing to tell apart")]
    NoSpread {
        /// Channels.
        channels: usize,
    },
    /// More components than independent directions.
    #[error("{asked} components, but the data varies in {rank} directions only: ask for at most {rank}")]
    Rank {
        /// Components asked for.
        asked: usize,
        /// Directions in which the data varies.
        rank: usize,
    },
    /// A setting outside its range.
    #[error("{name} = {value}: must be {allowed}")]
    Setting {
        /// Which.
        name: &'static str,
        /// What was given.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Start values that are no square matrix of independent rows.
    #[error("a start has {rows} × {columns} numbers; {needed} × {needed} of full rank are needed")]
    Start {
        /// Rows given.
        rows: usize,
        /// Columns given.
        columns: usize,
        /// Components.
        needed: usize,
    },
}

/// Mean and principal components of observations. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Whitening {
    /// E{x}, one for each channel.
    pub mean: DVector<f64>,
    /// V, channels × k: orthonormal columns.
    pub directions: DMatrix<f64>,
    /// Λ, variance along each direction, falling.
    pub variances: DVector<f64>,
    /// Sum of the variances of all channels.
    pub total_variance: f64,
}

impl Whitening {
    /// z of observations (rows), observations × k.
    pub fn apply(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        let mut z = x * &self.directions;
        let shift = self.directions.tr_mul(&self.mean);
        for (k, mut column) in z.column_iter_mut().enumerate() {
            let scale = 1.0 / self.variances[k].sqrt();
            column.apply(|v| *v = (*v - shift[k]) * scale);
        }
        z
    }

    /// V Λ^½, channels × k.
    pub fn dewhitening(&self) -> DMatrix<f64> {
        let mut d = self.directions.clone();
        for (k, mut column) in d.column_iter_mut().enumerate() {
            column *= self.variances[k].sqrt();
        }
        d
    }

    /// Share of the variance of all channels along the directions kept.
    pub fn explained(&self) -> f64 {
        self.variances.sum() / self.total_variance
    }
}

/// Mean and first principal components of observations (rows).
///
/// # Errors
/// See [`IcaError`]. Each direction has the sign that makes its largest entry positive.
pub fn whiten(x: &DMatrix<f64>, count: Count) -> Result<Whitening, IcaError> {
    let (n, channels) = x.shape();
    if n < 2 || channels == 0 {
        return Err(IcaError::TooFew { found: if channels == 0 { 0 } else { n }, least: 2 });
    }
    if let Some(at) = x.iter().position(|v| !v.is_finite()) {
        return Err(IcaError::NotFinite { observation: at % n, channel: at / n, value: x[at] });
    }
    let mean = DVector::from_iterator(channels, x.column_iter().map(|c| c.mean()));
    let mut centred = x.clone();
    for (k, mut column) in centred.column_iter_mut().enumerate() {
        column.add_scalar_mut(-mean[k]);
    }
    let total_variance = centred.norm_squared() / n as f64;
    // what rounding of the mean alone leaves
    let rounding = mean.norm_squared() * (f64::EPSILON * 8.0).powi(2);
    if total_variance <= rounding {
        return Err(IcaError::NoSpread { channels });
    }
    let (values, vectors, rank) = match count {
        Count::Share(1.0) => exact(&centred),
        _ => {
            let (values, vectors) = eigen((centred.transpose() * &centred) / n as f64);
            let rank = values.iter().take(n - 1).filter(|v| **v > RANK * values[0]).count();
            (values, vectors, rank)
        }
    };
    let k = match count {
        Count::Share(1.0) => rank,
        Count::Number(0) => {
            return Err(IcaError::Setting { name: "components", value: 0.0, allowed: "1 or more" });
        }
        Count::Number(asked) if asked > rank => return Err(IcaError::Rank { asked, rank }),
        Count::Number(asked) => asked,
        Count::Share(share) if share > 0.0 && share <= 1.0 => {
            let mut sum = 0.0;
            let enough = values.iter().take(rank).position(|v| {
                sum += v;
                sum >= share * total_variance
            });
            enough.map_or(rank, |i| i + 1)
        }
        Count::Share(value) => {
            return Err(IcaError::Setting { name: "variance", value, allowed: "above 0 and at most 1" });
        }
    };
    let mut directions = vectors.columns(0, k).into_owned();
    for mut column in directions.column_iter_mut() {
        if column[column.iamax()] < 0.0 {
            column.neg_mut();
        }
    }
    Ok(Whitening { mean, directions, variances: values.rows(0, k).into_owned(), total_variance })
}
