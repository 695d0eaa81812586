//! Marginal likelihood of one observation space, and all its derivatives.
//!
//! With N × N kernel matrix K and the D columns of the centred observations Y (N × D),
//!
//! L = ½ tr(K⁻¹ Y Yᵀ) + (D/2) ln|K| + (N D/2) ln 2π,  G = ∂L/∂K = ½ (D K⁻¹ − K⁻¹ Y Yᵀ K⁻¹).
//!
//! Y enters only through Y Yᵀ = C Cᵀ with C lower trapezoidal (N × min(N, D)), so an evaluation costs O(N³)
//! whatever D is. With K = L Lᵀ and W = L⁻¹ C (lower trapezoidal too), tr(K⁻¹ Y Yᵀ) = |W|² and G = ½ L⁻ᵀ (D
//! I − W Wᵀ) L⁻¹: every factor but the last product is triangular, 4/3 N³ multiplications in all.

use nalgebra::DMatrix;

use crate::dense::{axpy, cholesky, dot, invert_lower, mirror};
use crate::error::FitError;
use crate::kernel::{Kernel, PARAMETERS};

/// The observations of one space as the likelihood sees them.
#[derive(Clone, Debug)]
pub(crate) struct View {
    n: usize,
    /// D, times the weight.
    dim: f64,
    /// Columns of C.
    rank: usize,
    /// C, row-major N × rank.
    c: Vec<f64>,
}

/// What an evaluation writes into: allocated once.
#[derive(Clone, Debug)]
pub(crate) struct Work {
    /// exp(−θ2/2 r²), lower triangle.
    e: Vec<f64>,
    l: Vec<f64>,
    l_inverse: Vec<f64>,
    w: Vec<f64>,
    m: Vec<f64>,
    t: Vec<f64>,
    /// ∂L/∂K, lower triangle.
    pub g: Vec<f64>,
}

impl Work {
    pub fn new(n: usize) -> Self {
        let m = || vec![0.0; n * n];
        Work { e: m(), l: m(), l_inverse: m(), w: m(), m: m(), t: m(), g: m() }
    }
}

impl View {
    /// Of centred observations, one a column (D × N).
    pub fn new(points: &DMatrix<f64>) -> Self {
        View::weighted(points, 1.0)
    }

    /// The same, counted `weight` times: L is linear in D and Y Yᵀ.
    pub fn weighted(points: &DMatrix<f64>, weight: f64) -> Self {
        let (dim, n) = points.shape();
        // Y Yᵀ = Rᵀ R of the QR decomposition of Yᵀ; Rᵀ is C.
        let r = points.clone().qr().r();
        let rank = r.nrows();
        let mut c = vec![0.0; n * rank];
        for i in 0..n {
            for k in 0..rank.min(i + 1) {
                c[i * rank + k] = weight.sqrt() * r[(k, i)];
            }
        }
        View { n, dim: weight * dim as f64, rank, c }
    }

    /// Returns L and its derivatives by (θ1, θ2, θ3, β⁻¹) for squared distances `r2` (lower triangle, row-major
    /// N × N); adds ∂L/∂r²_ij of unordered pairs, i > j, to the lower triangle of `by_r2`.
    ///
    /// # Errors
    /// K is not positive definite.
    pub fn evaluate(
        &self,
        kernel: &Kernel,
        r2: &[f64],
        by_r2: Option<&mut [f64]>,
        work: &mut Work,
    ) -> Result<(f64, [f64; PARAMETERS]), FitError> {
        let (n, d) = (self.n, self.dim);
        let Work { e, l, l_inverse, w, m, t, g } = work;
        let diagonal = kernel.at_zero();
        for i in 0..n {
            let row = i * n;
            for j in row..row + i {
                e[j] = (-0.5 * kernel.theta2 * r2[j]).exp();
                l[j] = kernel.theta1 * e[j] + kernel.theta3;
            }
            e[row + i] = 1.0;
            l[row + i] = diagonal;
        }
        if !cholesky(l, n) {
            return Err(not_definite(kernel));
        }
        invert_lower(l, n, l_inverse);
        let ln_det: f64 = 2.0 * (0..n).map(|i| l[i * n + i].ln()).sum::<f64>();
        let fit = self.whiten(l_inverse, w);
        let value = 0.5 * fit + 0.5 * d * ln_det + 0.5 * d * n as f64 * (2.0 * std::f64::consts::PI).ln();

        // M = D I − W Wᵀ.
        let r = self.rank;
        for i in 0..n {
            for j in 0..=i {
                let k = r.min(j + 1);
                m[i * n + j] = -dot(&w[i * r..i * r + k], &w[j * r..j * r + k]);
            }
            m[i * n + i] += d;
        }
        mirror(m, n);
        // T = ½ M L⁻¹, then the lower triangle of G = L⁻ᵀ T.
        for i in 0..n {
            let row = &mut t[i * n..(i + 1) * n];
            row.fill(0.0);
            for k in 0..n {
                axpy(0.5 * m[i * n + k], &l_inverse[k * n..k * n + k + 1], row);
            }
        }
        for i in 0..n {
            let row = &mut g[i * n..i * n + i + 1];
            row.fill(0.0);
            for k in i..n {
                axpy(l_inverse[k * n + i], &t[k * n..k * n + i + 1], row);
            }
        }
        let by = derivatives(kernel, n, r2, e, g, by_r2);
        Ok((value, by))
    }

    /// W = L⁻¹ C; returns |W|².
    fn whiten(&self, l_inverse: &[f64], w: &mut [f64]) -> f64 {
        let (n, r) = (self.n, self.rank);
        let mut fit = 0.0;
        for i in 0..n {
            let row = &mut w[i * r..(i + 1) * r];
            row.fill(0.0);
            for k in 0..=i {
                axpy(l_inverse[i * n + k], &self.c[k * r..k * r + r.min(k + 1)], row);
            }
            fit += dot(row, row);
        }
        fit
    }
}

/// Sums G against ∂K.
fn derivatives(
    kernel: &Kernel,
    n: usize,
    r2: &[f64],
    e: &[f64],
    g: &[f64],
    by_r2: Option<&mut [f64]>,
) -> [f64; PARAMETERS] {
    let mut trace = 0.0;
    let (mut by1, mut by2, mut by3) = (0.0, 0.0, 0.0);
    let slope = -kernel.theta1 * kernel.theta2; // 2 · (−½ θ1 θ2): both halves of the symmetric matrix
    let mut by_r2 = by_r2;
    for i in 0..n {
        let row = i * n..i * n + i;
        let (g, e, r2) = (&g[row.clone()], &e[row.clone()], &r2[row.clone()]);
        by1 += dot(g, e);
        by3 += g.iter().sum::<f64>();
        match by_r2.as_deref_mut() {
            Some(out) => {
                for ((o, r), (g, e)) in out[row].iter_mut().zip(r2).zip(g.iter().zip(e)) {
                    let ge = g * e;
                    *o += slope * ge;
                    by2 += ge * r;
                }
            }
            None => by2 += r2.iter().zip(g.iter().zip(e)).map(|(r, (g, e))| g * e * r).sum::<f64>(),
        }
    }
    for i in 0..n {
        trace += g[i * n + i];
    }
    [2.0 * by1 + trace, -kernel.theta1 * by2, 2.0 * by3 + trace, trace]
}

/// The error of a kernel matrix that does not factor.
pub(crate) fn not_definite(kernel: &Kernel) -> FitError {
    FitError::Optimiser {
        iterations: 0,
        reason: format!("kernel matrix is not positive definite at {kernel:?}"),
    }
}

/// Squared distances of rows of length `q`, lower triangle of row-major N × N.
pub(crate) fn squared_distances(x: &[f64], q: usize, r2: &mut [f64]) {
    let n = x.len() / q;
    for i in 0..n {
        for j in 0..i {
            r2[i * n + j] = crate::dense::distance_squared(&x[i * q..(i + 1) * q], &x[j * q..(j + 1) * q]);
        }
    }
}

/// Median of the squared distances between different points.
pub(crate) fn median_squared(r2: &[f64], n: usize) -> f64 {
    let mut all: Vec<f64> = (1..n).flat_map(|i| r2[i * n..i * n + i].iter().copied()).collect();
    all.sort_by(f64::total_cmp);
    all[all.len() / 2]
}

#[cfg(test)]
#[path = "likelihood_tests.rs"]
mod tests;
