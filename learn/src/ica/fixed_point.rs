//! The fixed points of negentropy: a rotation of whitened data, from a start.

use nalgebra::{DMatrix, RowDVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::{IcaError, IcaOptions};

/// All components at once, or one after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// All rows take a step, then are made orthogonal together: no component comes first.
    Symmetric,
    /// A row is brought to its end before the next begins: errors of the first are passed on.
    Deflation,
}

/// The nonlinearity g, the derivative of the function G whose mean tells how far from Gaussian a component is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contrast {
    /// g = tanh u: the usual one.
    Tanh,
    /// g = u³ (kurtosis): fast, and led by outliers.
    Cube,
    /// g = u exp(−u²/2): for components with long tails.
    Exp,
}

impl Method {
    /// All, with their names.
    pub const NAMES: [(Self, &'static str); 2] =
        [(Self::Symmetric, "symmetric"), (Self::Deflation, "deflation")];
}

impl Contrast {
    /// All, with their names.
    pub const NAMES: [(Self, &'static str); 3] =
        [(Self::Tanh, "tanh"), (Self::Cube, "cube"), (Self::Exp, "exp")];

    /// g and g′.
    fn at(self, u: f64) -> (f64, f64) {
        match self {
            Contrast::Tanh => {
                let t = u.tanh();
                (t, 1.0 - t * t)
            }
            Contrast::Cube => (u * u * u, 3.0 * u * u),
            Contrast::Exp => {
                let e = (-0.5 * u * u).exp();
                (u * e, (1.0 - u * u) * e)
            }
        }
    }
}

/// Where a start ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Fixed {
    /// W, k × k, orthonormal rows.
    pub rotation: DMatrix<f64>,
    /// Whether every row came to rest.
    pub converged: bool,
    /// Steps taken (deflation: by the slowest row).
    pub steps: usize,
    /// Largest 1 − |cos| of the last step.
    pub last_turn: f64,
}

/// A start of standard normal numbers, k × k.
pub fn start(k: usize, seed: u64) -> DMatrix<f64> {
    let mut rng = Pcg64::seed_from_u64(seed);
    // Box and Muller
    let mut normal = || {
        let (u, v): (f64, f64) = (rng.random_range(f64::MIN_POSITIVE..1.0), rng.random_range(0.0..1.0));
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    };
    DMatrix::from_fn(k, k, |_, _| normal())
}

/// Turns whitened data until its rows are as far from Gaussian as they get.
///
/// * `z`: k × observations, zero mean, unit covariance (1/n)
/// * `start`: k × k, of full rank; rows need not be orthogonal
/// * of `options`: method, contrast, `most_steps`, `tolerance`
///
/// # Errors
/// A start of another size or without full rank; settings out of range.
pub fn fixed_point(z: &DMatrix<f64>, start: &DMatrix<f64>, options: &IcaOptions) -> Result<Fixed, IcaError> {
    let k = z.nrows();
    let bad = IcaError::Start { rows: start.nrows(), columns: start.ncols(), needed: k };
    if start.shape() != (k, k) || start.iter().any(|v| !v.is_finite()) {
        return Err(bad);
    }
    if options.most_steps == 0 {
        return Err(IcaError::Setting { name: "most_steps", value: 0.0, allowed: "1 or more" });
    }
    if !(options.tolerance > 0.0 && options.tolerance < 1.0) {
        let value = options.tolerance;
        return Err(IcaError::Setting { name: "tolerance", value, allowed: "above 0 and below 1" });
    }
    match options.method {
        Method::Symmetric => symmetric(z, start, options).ok_or(bad),
        Method::Deflation => deflation(z, start, options).ok_or(bad),
    }
}

/// Lengths below this share are rounding: the rows of a start depend on each other.
const DEPENDENT: f64 = 1e-10;

/// (W Wᵀ)^−½ W, the nearest matrix with orthonormal rows.
fn orthonormal(w: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let eigen = (w * w.transpose()).symmetric_eigen();
    let most = eigen.eigenvalues.max();
    if eigen.eigenvalues.min() <= DEPENDENT * most {
        return None;
    }
    let root = eigen.eigenvalues.map(|v| 1.0 / v.sqrt());
    Some(&eigen.eigenvectors * DMatrix::from_diagonal(&root) * eigen.eigenvectors.transpose() * w)
}

fn symmetric(z: &DMatrix<f64>, start: &DMatrix<f64>, options: &IcaOptions) -> Option<Fixed> {
    let (k, n) = z.shape();
    let mut w = orthonormal(start)?;
    let mut slopes = vec![0.0; k];
    let mut last_turn = f64::INFINITY;
    // observations are rows here, so that a component is contiguous
    let data = z.transpose();
    let mut u = DMatrix::zeros(n, k);
    for step in 1..=options.most_steps {
        u.gemm(1.0, &data, &w.transpose(), 0.0);
        for (i, mut column) in u.column_iter_mut().enumerate() {
            let mut slope = 0.0;
            for v in column.iter_mut() {
                let (g, derivative) = options.contrast.at(*v);
                slope += derivative;
                *v = g;
            }
            slopes[i] = slope / n as f64;
        }
        let mut next = (z * &u).transpose() / n as f64;
        for i in 0..k {
            for j in 0..k {
                next[(i, j)] -= slopes[i] * w[(i, j)];
            }
        }
        // a step that ends in dependent rows cannot go on: the start is as good as lost
        let next = orthonormal(&next)?;
        last_turn = (0..k).map(|i| (next.row(i).dot(&w.row(i)).abs() - 1.0).abs()).fold(0.0, f64::max);
        w = next;
        if last_turn < options.tolerance {
            return Some(Fixed { rotation: w, converged: true, steps: step, last_turn });
        }
    }
    Some(Fixed { rotation: w, converged: false, steps: options.most_steps, last_turn })
}

fn deflation(z: &DMatrix<f64>, start: &DMatrix<f64>, options: &IcaOptions) -> Option<Fixed> {
    let (k, n) = z.shape();
    let mut done = Fixed { rotation: DMatrix::zeros(k, k), converged: true, steps: 0, last_turn: 0.0 };
    for i in 0..k {
        let free = |w: RowDVector<f64>, w_before: &DMatrix<f64>| {
            let length = w.norm();
            let mut w = w;
            for j in 0..i {
                let along = w.dot(&w_before.row(j));
                w -= w_before.row(j) * along;
            }
            let left = w.norm();
            (left > DEPENDENT * length).then(|| w / left)
        };
        // as scikit-learn: a start is scaled, not made orthogonal to the rows that are done
        let first = start.row(i).into_owned();
        let mut w = &first / first.norm();
        if !w.iter().all(|v| v.is_finite()) {
            return None;
        }
        let (mut turn, mut steps, mut rests) = (f64::INFINITY, 0, false);
        while steps < options.most_steps && !rests {
            let mut u = &w * z;
            let mut slope = 0.0;
            for v in u.iter_mut() {
                let (g, derivative) = options.contrast.at(*v);
                slope += derivative;
                *v = g;
            }
            let next = free((u * z.transpose() - &w * slope) / n as f64, &done.rotation)?;
            turn = (next.dot(&w).abs() - 1.0).abs();
            w = next;
            steps += 1;
            rests = turn < options.tolerance;
        }
        done.converged &= rests;
        done.steps = done.steps.max(steps);
        done.last_turn = done.last_turn.max(turn);
        done.rotation.set_row(i, &w);
    }
    Some(done)
}
