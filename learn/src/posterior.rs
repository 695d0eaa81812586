//! A Gaussian process after its observations: mean and variance anywhere.
//!
//! With K = L Lᵀ everything goes through w = L⁻¹k(x): mean Wᵀw with W = L⁻¹Y, variance k(x, x) − |w|², and
//! K⁻¹k = L⁻ᵀw. The textbook's K⁻¹ would square the error: at a condition number of 10⁶ it loses the variance
//! altogether.

use crate::dense::{axpy, cholesky, dot, invert_lower, matvec_transposed};
use crate::error::FitError;
use crate::kernel::Kernel;
use crate::likelihood::not_definite;

/// Kernel, points' factor and whitened observations.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Posterior {
    pub kernel: Kernel,
    n: usize,
    /// L⁻¹, N × N lower.
    l_inverse: Vec<f64>,
    /// W = L⁻¹ Y, N × columns.
    pub whitened: Vec<f64>,
}

impl Posterior {
    /// Of points with squared distances `r2` (lower triangle of row-major N × N) and observations `y` (N ×
    /// columns, row-major; may have no columns).
    pub fn new(kernel: Kernel, r2: &[f64], n: usize, y: &[f64]) -> Result<Self, FitError> {
        let mut l = r2.to_vec();
        for i in 0..n {
            for v in &mut l[i * n..i * n + i] {
                *v = kernel.theta1 * (-0.5 * kernel.theta2 * *v).exp() + kernel.theta3;
            }
            l[i * n + i] = kernel.at_zero();
        }
        Posterior::of_covariance(kernel, l, n, y)
    }

    /// Of points with covariance `l` (lower triangle of row-major N × N), whatever it is made of.
    pub fn of_covariance(kernel: Kernel, mut l: Vec<f64>, n: usize, y: &[f64]) -> Result<Self, FitError> {
        if !cholesky(&mut l, n) {
            return Err(not_definite(&kernel));
        }
        let mut l_inverse = vec![0.0; n * n];
        invert_lower(&l, n, &mut l_inverse);
        let columns = y.len() / n;
        let mut whitened = vec![0.0; y.len()];
        if columns > 0 {
            for (i, row) in whitened.chunks_exact_mut(columns).enumerate() {
                for k in 0..=i {
                    axpy(l_inverse[i * n + k], &y[k * columns..(k + 1) * columns], row);
                }
            }
        }
        Ok(Posterior { kernel, n, l_inverse, whitened })
    }

    /// Turns squared distances to the points into k(x), without noise.
    pub fn kernel_in_place(&self, squared: &mut [f64]) {
        for v in squared {
            *v = self.kernel.theta1 * (-0.5 * self.kernel.theta2 * *v).exp() + self.kernel.theta3;
        }
    }

    /// w = L⁻¹ k.
    pub fn whiten(&self, k: &[f64], w: &mut [f64]) {
        for (i, w) in w.iter_mut().enumerate() {
            *w = dot(&self.l_inverse[i * self.n..i * self.n + i + 1], &k[..=i]);
        }
    }

    /// Row `i` of L⁻¹ a in place of row `i` of `a` (N × m).
    pub fn whiten_row(&self, i: usize, a: &mut [f64], m: usize) {
        let (above, row) = a.split_at_mut(i * m);
        let row = &mut row[..m];
        let l = &self.l_inverse[i * self.n..i * self.n + i + 1];
        row.iter_mut().for_each(|v| *v *= l[i]);
        for (l, a) in l.iter().zip(above.chunks_exact(m)) {
            axpy(*l, a, row);
        }
    }

    /// L⁻ᵀ g.
    pub fn unwhiten(&self, g: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for (i, g) in g.iter().enumerate() {
            axpy(*g, &self.l_inverse[i * self.n..i * self.n + i + 1], &mut out[..=i]);
        }
    }

    /// Mean Wᵀ w.
    pub fn mean(&self, w: &[f64], mean: &mut [f64]) {
        matvec_transposed(&self.whitened, w, mean);
    }

    /// Variance the observations leave, without noise.
    pub fn left(&self, w: &[f64]) -> f64 {
        (self.kernel.theta1 + self.kernel.theta3 - dot(w, w)).max(0.0)
    }
}
