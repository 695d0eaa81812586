//! Residuals at the examples, each predicted from the others at the same kernel.
//!
//! With a set b of examples left out, the residuals there are [K⁻¹]_bb⁻¹ [K⁻¹ Y]_b and their covariance is [K⁻¹]_bb⁻¹
//! (Rasmussen and Williams, Gaussian Processes for Machine Learning, MIT Press 2006, (5.12) for one example). Images are left
//! out with their examples: even and odd parts are so apart. No factorisation is made again. With inducing points all this is of the
//! approximation, whose K⁻¹ is (I − Vᵀ B⁻¹ V/σ_n²)/σ_n²; the inducing points stay. A centre taken away
//! ([`crate::RbfOptions::centre`]) stays too.

use nalgebra::DMatrix;

use super::half::{Half, join};
use super::targets::Part;
use super::{RbfRegression, not_definite};
use crate::blocked::{gram_of_lower_less, multiply, transposed, view};
use crate::cloud::Squared;
use crate::dense::{axpy, cholesky, dot};
use crate::error::FitError;

/// How far each example is from what the others say.
#[derive(Clone, Debug, PartialEq)]
pub struct Residuals {
    /// N × D_y: target less prediction, units of the targets.
    pub residual: DMatrix<f64>,
    /// Variance of every coordinate of that prediction, noise included, squared units.
    pub variance: Vec<f64>,
}

/// K⁻¹ of a half and K⁻¹ Y.
struct Precision {
    n: usize,
    /// Lower triangle, row-major.
    matrix: Vec<f64>,
    alpha: Vec<f64>,
}

impl Precision {
    fn of(model: &RbfRegression, half: &Half, part: &Part, cross: &Squared) -> Self {
        let (n, columns) = (model.cloud.len(), half.columns);
        let (mut matrix, mut v, mut alpha) = (Vec::new(), Vec::new(), Vec::new());
        if half.sparse.is_some() {
            let (m, noise) = (half.factor.len(), model.kernel.noise_variance);
            let mut second = Vec::new();
            join(half.sign, cross, &mut v);
            half.whiten(&mut v, n, &mut second);
            alpha.extend_from_slice(&part.values);
            let whitened = view(&half.whitened, m, columns, columns);
            multiply(&mut alpha, columns, -1.0, &transposed(&second, m, n, n), &whitened, 1.0);
            alpha.iter_mut().for_each(|a| *a /= noise);
            matrix.resize(n * n, 0.0);
            let (left, right) = (transposed(&second, m, n, n), view(&second, m, n, n));
            multiply(&mut matrix, n, -1.0 / (noise * noise), &left, &right, 0.0);
            matrix.iter_mut().step_by(n + 1).for_each(|v| *v += 1.0 / noise);
        } else {
            alpha.extend_from_slice(&half.whitened);
            half.factor.solve_upper(&mut alpha, columns);
            half.factor.invert(&mut v);
            gram_of_lower_less(&v, n, 1.0, &[], 0, 0.0, &mut matrix);
        }
        Precision { n, matrix, alpha }
    }

    /// Writes [K⁻¹]_bb⁻¹ e_i of the examples `set`, `at` the place of i there.
    fn response(&self, set: &[usize], at: usize, z: &mut Vec<f64>, l: &mut Vec<f64>) -> bool {
        let m = set.len();
        l.clear();
        for (row, &i) in set.iter().enumerate() {
            l.extend(set[..=row].iter().map(|&j| self.matrix[i * self.n + j]));
            l.resize((row + 1) * m, 0.0);
        }
        z.clear();
        z.resize(m, 0.0);
        z[at] = 1.0;
        if !cholesky(l, m) {
            return false;
        }
        for i in 0..m {
            z[i] = (z[i] - dot(&l[i * m..i * m + i], &z[..i])) / l[i * m + i];
        }
        for i in (0..m).rev() {
            z[i] /= l[i * m + i];
            let (head, last) = z.split_at_mut(i);
            axpy(-last[0], &l[i * m..i * m + i], head);
        }
        true
    }
}

impl RbfRegression {
    /// Each example left out with its image, in turn. Where examples are frames of a motion the neighbours in time know the
    /// answer: [`RbfRegression::leave_event_out`] leaves them out as well. O(N³).
    ///
    /// # Errors
    /// K⁻¹ lost to rounding.
    pub fn leave_one_out(&self) -> Result<Residuals, FitError> {
        self.leave_out(|i| vec![i])
    }

    /// Each example left out with all that are the same event ([`crate::Examples::with_moments`]; without moments as
    /// [`RbfRegression::leave_one_out`]): the residual is to what examples at other times say. Large over its standard deviation
    /// (root of the variance), it contradicts them. O(N³).
    ///
    /// # Errors
    /// As [`RbfRegression::leave_one_out`].
    pub fn leave_event_out(&self) -> Result<Residuals, FitError> {
        let n = self.examples.len();
        self.leave_out(|i| (0..n).filter(|&j| self.examples.same_event(i, j)).collect())
    }

    fn leave_out(&self, set_of: impl Fn(usize) -> Vec<usize>) -> Result<Residuals, FitError> {
        let (n, d) = (self.cloud.len(), self.targets.dimension());
        let mut cross = Squared::default();
        if let Some(inducing) = &self.inducing {
            inducing.cloud.squared(self.seen().points(), n, &mut cross);
            self.kernel.of(&mut cross.own);
            self.kernel.of(&mut cross.image);
        }
        let mut parts = vec![0.0; n * d];
        let mut variance = vec![0.0; n];
        let (mut z, mut l) = (Vec::new(), Vec::new());
        let sets: Vec<Vec<usize>> = (0..n).map(set_of).collect();
        for (half, part) in self.halves.iter().zip(&self.targets.parts) {
            let precision = Precision::of(self, half, part, &cross);
            let columns = half.columns;
            for (i, set) in sets.iter().enumerate() {
                let at = set.iter().position(|&j| j == i).unwrap_or(0);
                if !precision.response(set, at, &mut z, &mut l) {
                    return Err(not_definite(&self.kernel));
                }
                variance[i] += half.sign.share() * z[at];
                let residual = &mut parts[i * d + half.first..i * d + half.first + columns];
                for (&j, z) in set.iter().zip(&z) {
                    axpy(*z, &precision.alpha[j * columns..(j + 1) * columns], residual);
                }
            }
        }
        let mut residual = DMatrix::zeros(n, d);
        let mut row = vec![0.0; d];
        for (i, part) in parts.chunks_exact(d).enumerate() {
            self.targets.parity.leave(part, &mut row);
            row.iter().enumerate().for_each(|(k, v)| residual[(i, k)] = *v);
        }
        Ok(Residuals { residual, variance })
    }
}
