//! Regularised kernel canonical correlation analysis: directions in two spaces that move together.
//!
//! With centred RBF kernel matrices K_y, K_z (N × N; width: the median distance) and R = K (K + κ tr(K)
//! I)⁻¹, the pairs of directions are the singular vectors u, v of R_y R_z, their correlations the singular
//! values. Without regularisation (κ → 0) R is the identity on centred vectors, and every data set,
//! independent ones too, comes out with correlations of 1; κ says how much of the variance of a space is
//! taken for detail nothing can be learned from.
//!
//! Akaho. A kernel method for canonical correlation analysis. IMPS 2001.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::error::FitError;
use crate::likelihood::{median_squared, squared_distances};
use crate::pairs::{Pairs, Space};

/// Default κ. On the rule of `examples/criteria.rs` a tenth of it makes the error on unseen poses half as
/// large again; ten times as much is no worse with key poses well spread, and up to twice as bad with key
/// poses drawn at random.
pub const KAPPA: f64 = 0.1;

/// Pairs of directions in two spaces, the most correlated first.
#[derive(Clone, Debug, PartialEq)]
pub struct KernelCca {
    /// Regularised correlations, falling, in [0, 1].
    pub correlations: Vec<f64>,
    /// √N R_y u: the input side of every pair, N × directions. A direction that carries much of the variance
    /// has standard deviation 1, a faint one less.
    pub inputs: DMatrix<f64>,
    /// √N R_z v: the output side.
    pub outputs: DMatrix<f64>,
}

impl KernelCca {
    /// Finds `directions` pairs of directions, at most N − 1, with regularisation `kappa` > 0.
    ///
    /// # Errors
    /// `kappa` not positive, more directions than N − 1.
    pub fn fit(pairs: &Pairs, directions: usize, kappa: f64) -> Result<Self, FitError> {
        check_directions(directions, pairs.len())?;
        if !(kappa > 0.0 && kappa.is_finite()) {
            return Err(FitError::Setting { name: "kappa", value: kappa, allowed: "above 0".into() });
        }
        let (y, z) = (Filter::of(pairs.inputs(), kappa), Filter::of(pairs.outputs(), kappa));
        let n = pairs.len();
        // R_y R_z in the eigenbases of the two sides.
        let core =
            DMatrix::from_diagonal(&y.gain) * y.basis.tr_mul(&z.basis) * DMatrix::from_diagonal(&z.gain);
        let svd = core.svd(true, true);
        let (Some(p), Some(qt)) = (svd.u, svd.v_t) else { unreachable!("both were asked for") };
        let order = falling(svd.singular_values.as_slice());
        let mut inputs = DMatrix::zeros(n, directions);
        let mut outputs = DMatrix::zeros(n, directions);
        let root = (n as f64).sqrt();
        for (k, &i) in order.iter().take(directions).enumerate() {
            let mut f = &y.basis * y.gain.component_mul(&p.column(i)) * root;
            let mut g = &z.basis * z.gain.component_mul(&qt.row(i).transpose()) * root;
            // The sign is free: the largest entry is positive, so that rounding does not choose it.
            if f[f.icamax()] < 0.0 {
                f.neg_mut();
                g.neg_mut();
            }
            inputs.set_column(k, &f);
            outputs.set_column(k, &g);
        }
        let correlations = order.iter().take(directions).map(|&i| svd.singular_values[i].min(1.0)).collect();
        Ok(KernelCca { correlations, inputs, outputs })
    }

    /// Where the two sides meet: their mean, N × directions.
    pub fn shared(&self) -> DMatrix<f64> {
        (&self.inputs + &self.outputs) * 0.5
    }
}

/// Complains unless 1 ≤ `directions` ≤ n − 1.
pub(crate) fn check_directions(directions: usize, n: usize) -> Result<(), FitError> {
    if directions == 0 || directions >= n {
        let allowed = format!("from 1 to {} ({n} pairs)", n - 1);
        return Err(FitError::Setting { name: "dimension", value: directions as f64, allowed });
    }
    Ok(())
}

/// K (K + κ tr(K) I)⁻¹ of one side: eigenvectors and gains.
struct Filter {
    basis: DMatrix<f64>,
    gain: DVector<f64>,
}

impl Filter {
    fn of(columns: &DMatrix<f64>, kappa: f64) -> Self {
        let space = Space::of(columns);
        let (d, n) = columns.shape();
        let mut r2 = vec![0.0; n * n];
        squared_distances(space.points.as_slice(), d, &mut r2);
        let width = median_squared(&r2, n);
        let mut k = DMatrix::from_fn(n, n, |i, j| {
            let (i, j) = (i.max(j), i.min(j));
            if i == j { 1.0 } else { (-0.5 * r2[i * n + j] / width).exp() }
        });
        centre(&mut k);
        let (values, basis) = eigen(k);
        let shift = kappa * values.iter().map(|v| v.max(0.0)).sum::<f64>();
        let gain = values.map(|v| v.max(0.0) / (v.max(0.0) + shift));
        Filter { basis, gain }
    }
}

/// Subtracts the means of rows and columns of a symmetric matrix.
pub(crate) fn centre(k: &mut DMatrix<f64>) {
    let n = k.nrows();
    let mean: Vec<f64> = (0..n).map(|j| k.column(j).sum() / n as f64).collect();
    let all = mean.iter().sum::<f64>() / n as f64;
    for j in 0..n {
        for i in 0..n {
            k[(i, j)] += all - mean[i] - mean[j];
        }
    }
}

/// Eigenvalues, falling, and eigenvectors of a symmetric matrix.
pub(crate) fn eigen(k: DMatrix<f64>) -> (DVector<f64>, DMatrix<f64>) {
    let e = SymmetricEigen::new(k);
    let order = falling(e.eigenvalues.as_slice());
    let values = DVector::from_iterator(order.len(), order.iter().map(|&i| e.eigenvalues[i]));
    let mut basis = DMatrix::zeros(order.len(), order.len());
    for (k, &i) in order.iter().enumerate() {
        let v = e.eigenvectors.column(i);
        let sign = if v[v.icamax()] < 0.0 { -1.0 } else { 1.0 };
        basis.set_column(k, &(v * sign));
    }
    (values, basis)
}

fn falling(v: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..v.len()).collect();
    order.sort_by(|&a, &b| v[b].total_cmp(&v[a]));
    order
}
