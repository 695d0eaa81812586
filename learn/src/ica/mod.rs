//! Independent component analysis by FastICA \[HO97, H99\]: what several channels do together, told apart by being as
//! independent as a rotation can make it.
//!
//! In: observations (rows) of several channels. Out: x = E{x} + A u with `u` of unit variance, uncorrelated and as far
//! from Gaussian as they get; the columns of the mixing matrix A = V Λ^½ Wᵀ say what one unit of a component does to
//! the channels. V, Λ are the first principal components ([`whiten`]), W is a rotation of the whitened data z:
//!
//! ```text
//! w ← E{g(wᵀz) z} − E{g′(wᵀz)} w      for each row w of W      (fixed point of negentropy, H99 eq. 20)
//! W ← (W Wᵀ)^−½ W                      symmetric: all rows together
//! w ← w − Σ_earlier (wᵀw_j) w_j, |w|=1  deflation: one after the other
//! ```
//!
//! until no row turns by more than `1 − |cos| < tolerance`. Components come in order of the variance they explain, each
//! with the sign that makes the largest entry of its column of A positive: order and sign are not determined by
//! independence.
//!
//! *Several starts* ([`fit`]). A fixed point depends on the start W₀. Several seeded starts are run and compared: how
//! well a component is found again is the mean over the other starts of the largest |correlation|
//! ([`Ica::agreement`]). The start on which the others agree best is kept. Gaussian mixtures have no independent
//! directions, and are seen by it.
//!
//! \[HO97\] Hyvärinen, Oja. A fast fixed-point algorithm for independent component analysis. Neural Computation 1997.
//! \[H99\] Hyvärinen. Fast and robust fixed-point algorithms for independent component analysis. IEEE TNN 1999.

mod fixed_point;
#[cfg(test)]
mod tests;
mod whiten;

use nalgebra::{DMatrix, DVector};

pub use fixed_point::{Contrast, Fixed, Method, fixed_point};
pub use whiten::{Count, IcaError, Whitening, whiten};

/// How components are looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IcaOptions {
    /// How many.
    pub count: Count,
    /// All at once, or one after the other.
    pub method: Method,
    /// The nonlinearity.
    pub contrast: Contrast,
    /// Most steps from one start.
    pub most_steps: usize,
    /// A start has converged when no row has 1 − |cos| of its last turn above this.
    pub tolerance: f64,
    /// Starts that are compared, at least 1.
    pub starts: usize,
    /// Seed of the first start; the next ones count on from it.
    pub seed: u64,
}

impl Default for IcaOptions {
    /// Components of 95 % of the variance, symmetric, tanh, 8 starts of 200 steps to 1e-6.
    fn default() -> Self {
        IcaOptions {
            count: Count::Share(0.95),
            method: Method::Symmetric,
            contrast: Contrast::Tanh,
            most_steps: 200,
            tolerance: 1e-6,
            starts: 8,
            seed: 0,
        }
    }
}

/// Components found again by the other starts with less than this |correlation| are not stable.
pub const STABLE: f64 = 0.95;

/// A decomposition. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Ica {
    /// Mean and principal components.
    pub whitening: Whitening,
    /// W, k × k, a rotation; rows are components.
    pub rotation: DMatrix<f64>,
    /// W₀, k × k: the start that is kept.
    pub start: DMatrix<f64>,
    /// A, channels × k.
    pub mixing: DMatrix<f64>,
    /// u, observations × k.
    pub activations: DMatrix<f64>,
    /// For each component how well other starts find it again, 0 to 1; 1 where there was one start.
    pub agreement: Vec<f64>,
    /// Whether the start that is kept has converged.
    pub converged: bool,
    /// Steps of the start that is kept (deflation: of its slowest component).
    pub steps: usize,
    /// Largest 1 − |cos| of its last step.
    pub last_turn: f64,
    /// Starts that have converged, of how many.
    pub converged_starts: (usize, usize),
}

impl Ica {
    /// Number of components.
    pub fn components(&self) -> usize {
        self.rotation.nrows()
    }

    /// Components that other starts do not find again ([`STABLE`]).
    pub fn unstable(&self) -> Vec<usize> {
        (0..self.components()).filter(|i| self.agreement[*i] < STABLE).collect()
    }

    /// u of other observations (rows).
    pub fn project(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        self.whitening.apply(x) * self.rotation.transpose()
    }

    /// Share of the variance of all channels that a component explains, 0 to 1.
    pub fn share(&self, component: usize) -> f64 {
        self.mixing.column(component).norm_squared() / self.whitening.total_variance
    }
}

/// Decomposes observations (rows) of channels (columns).
///
/// # Errors
/// Fewer than two observations, numbers that are not finite, channels that all stand still, more components than
/// the data has, settings out of range.
///
/// # Examples
/// ```
/// use learn::ica::{Count, IcaOptions, fit};
/// use nalgebra::DMatrix;
///
/// // A saw and a square wave, mixed into three channels.
/// let sources = DMatrix::from_fn(600, 2, |i, k| {
///     let t = i as f64 / 50.0;
///     if k == 0 { t.fract() } else { (0.37 * t).fract().round() }
/// });
/// let mixed = &sources * DMatrix::from_row_slice(2, 3, &[1.0, 0.5, -0.3, 0.7, -1.0, 0.2]);
/// let ica = fit(&mixed, &IcaOptions { count: Count::Number(2), ..IcaOptions::default() })?;
/// assert!(ica.converged && ica.unstable().is_empty());
/// # Ok::<(), learn::ica::IcaError>(())
/// ```
pub fn fit(x: &DMatrix<f64>, options: &IcaOptions) -> Result<Ica, IcaError> {
    if options.starts == 0 {
        return Err(IcaError::Setting { name: "starts", value: 0.0, allowed: "1 or more" });
    }
    let whitening = whiten(x, options.count)?;
    let z = whitening.apply(x).transpose();
    let k = z.nrows();
    let mut found = Vec::with_capacity(options.starts);
    for start in 0..options.starts as u64 {
        found.push(fixed_point(&z, &fixed_point::start(k, options.seed.wrapping_add(start)), options)?);
    }
    let agreement = |s: usize| -> Vec<f64> {
        let others: Vec<&Fixed> = (0..found.len()).filter(|o| *o != s).map(|o| &found[o]).collect();
        (0..k)
            .map(|i| {
                // u has unit covariance, so that correlations are cosines of the rows
                let again = |o: &&Fixed| (&o.rotation * found[s].rotation.row(i).transpose()).amax();
                if others.is_empty() {
                    1.0
                } else {
                    others.iter().map(again).sum::<f64>() / others.len() as f64
                }
            })
            .collect()
    };
    let all: Vec<Vec<f64>> = (0..found.len()).map(agreement).collect();
    // a start that has converged before one that has not; then the one that others agree on; then the first
    let worth = |s: usize| (usize::from(found[s].converged), all[s].iter().sum::<f64>());
    let best = (1..found.len()).fold(0, |b, s| if worth(s) > worth(b) { s } else { b });
    let kept = &found[best];

    let mixing = whitening.dewhitening() * kept.rotation.transpose();
    let mut order: Vec<usize> = (0..k).collect();
    order.sort_by(|a, b| mixing.column(*b).norm_squared().total_cmp(&mixing.column(*a).norm_squared()));
    let sign = |i: usize| {
        let column = mixing.column(i);
        if column[column.iamax()] < 0.0 { -1.0 } else { 1.0 }
    };
    let rotation = DMatrix::from_fn(k, k, |r, c| sign(order[r]) * kept.rotation[(order[r], c)]);
    let activations = z.transpose() * rotation.transpose();
    let signs = DVector::from_fn(k, |i, _| sign(order[i]));
    let mixing = DMatrix::from_fn(mixing.nrows(), k, |r, c| signs[c] * mixing[(r, order[c])]);
    Ok(Ica {
        start: fixed_point::start(k, options.seed.wrapping_add(best as u64)),
        agreement: order.iter().map(|i| all[best][*i]).collect(),
        converged: kept.converged,
        steps: kept.steps,
        last_turn: kept.last_turn,
        converged_starts: (found.iter().filter(|f| f.converged).count(), found.len()),
        whitening,
        rotation,
        mixing,
        activations,
    })
}
