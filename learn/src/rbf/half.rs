//! One Gaussian process of the examples: the only one without a mirror, else that of the even or of the odd targets.
//!
//! Its kernel is k(x, x') ± k(x, M x') over the examples without their images (see [`crate::parity`]). With K = L Lᵀ all goes
//! through w = L⁻¹ k(x), as in [`crate::posterior`]: mean wᵀ L⁻¹ Y; the variance loses |w|². With inducing points u (DTC; Quiñonero-Candela and
//! Rasmussen, A unifying view of sparse approximate Gaussian process regression, JMLR 2005) K is that of u, V = L⁻¹ K_ux,
//! B = I + V Vᵀ/σ_n² = L_B L_Bᵀ, w_B = L_B⁻¹ w: mean w_Bᵀ L_B⁻¹ V Y/σ_n²; the variance loses |w|² − |w_B|².

use crate::blocked::{Factor, multiply, transposed, view};
use crate::cloud::{Cloud, Squared};
use crate::dense::dot;
use crate::error::FitError;
use crate::parity::Sign;
use crate::rbf::targets::Targets;
use crate::rbf::{RbfKernel, not_definite};

/// Between inducing points the diagonal has this part of σ_f² more: they have no noise of their own.
const JITTER: f64 = 1e-10;

/// A half after its examples.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Half {
    pub sign: Sign,
    /// First of its coordinates among even and odd targets, and their number.
    pub first: usize,
    pub columns: usize,
    /// Of K and noise; of K between inducing points.
    pub factor: Factor,
    /// What the examples add to the inducing points.
    pub sparse: Option<Sparse>,
    /// What the mean is made with: rows as the factor, `columns` each.
    pub whitened: Vec<f64>,
}

/// Sums over examples, in the space whitened by the inducing points.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sparse {
    /// V Vᵀ, row-major M × M, lower triangle.
    gram: Vec<f64>,
    /// V Y, M × columns.
    product: Vec<f64>,
    /// Of I + V Vᵀ/σ_n².
    factor: Factor,
}

impl Half {
    /// Turns `k` (rows × m, row-major, of this half's kernel) into w, and w_B after it; returns both.
    pub fn whiten(&self, k: &mut [f64], m: usize, second: &mut Vec<f64>) {
        self.factor.solve_lower(k, m);
        if let Some(sparse) = &self.sparse {
            second.clear();
            second.extend_from_slice(k);
            sparse.factor.solve_lower(second, m);
        }
    }

    /// The same for one input, without allocating once `second` has had its size.
    pub fn whiten_one(&self, k: &mut [f64], second: &mut Vec<f64>) {
        self.factor.solve_one(k);
        if let Some(sparse) = &self.sparse {
            second.clear();
            second.extend_from_slice(k);
            sparse.factor.solve_one(second);
        }
    }

    /// Writes the mean (m × columns) of whitened kernels (rows × m), and adds what the variances (m) lose.
    pub fn answer(&self, w: &[f64], second: &[f64], m: usize, mean: &mut Vec<f64>, known: &mut [f64]) {
        let n = self.factor.len();
        let last = if self.sparse.is_some() { second } else { w };
        mean.resize(m * self.columns, 0.0);
        let whitened = view(&self.whitened, n, self.columns, self.columns);
        multiply(mean, self.columns, 1.0, &transposed(last, n, m, m), &whitened, 0.0);
        for (i, row) in w.chunks_exact(m).enumerate() {
            if self.sparse.is_some() {
                let b = &second[i * m..(i + 1) * m];
                for (k, (a, b)) in known.iter_mut().zip(row.iter().zip(b)) {
                    *k += self.sign.share() * (a * a - b * b);
                }
            } else {
                known.iter_mut().zip(row).for_each(|(k, a)| *k += self.sign.share() * a * a);
            }
        }
    }

    /// The same for one input; allocates nothing.
    pub fn answer_one(&self, w: &[f64], second: &[f64], mean: &mut [f64]) -> f64 {
        let last = if self.sparse.is_some() { second } else { w };
        crate::dense::matvec_transposed(&self.whitened, last, mean);
        let back = if self.sparse.is_some() { dot(second, second) } else { 0.0 };
        self.sign.share() * (dot(w, w) - back)
    }
}

impl Sparse {
    /// Of V (M × examples, row-major) and targets (examples × columns).
    pub fn new(v: &[f64], m: usize, y: &[f64], columns: usize, kernel: &RbfKernel) -> Option<Self> {
        let mut sparse =
            Sparse { gram: vec![0.0; m * m], product: vec![0.0; m * columns], factor: Factor::default() };
        sparse.add(v, m, y, columns, kernel).then_some(sparse)
    }

    /// Adds examples.
    pub fn add(&mut self, v: &[f64], m: usize, y: &[f64], columns: usize, kernel: &RbfKernel) -> bool {
        let count = v.len() / m;
        let v_view = view(v, m, count, count);
        multiply(&mut self.gram, m, 1.0, &v_view, &transposed(v, m, count, count), 1.0);
        multiply(&mut self.product, columns, 1.0, &v_view, &view(y, count, columns, columns), 1.0);
        let (gram, noise) = (&self.gram, kernel.noise_variance);
        self.factor.renew(m, |l| {
            l.copy_from_slice(gram);
            l.iter_mut().for_each(|v| *v /= noise);
            l.iter_mut().step_by(m + 1).for_each(|v| *v += 1.0);
        })
    }

    /// ln |B|.
    pub fn ln_det(&self) -> f64 {
        self.factor.ln_det()
    }

    /// L_B⁻¹ V Y/σ_n².
    pub fn whitened(&self, columns: usize, kernel: &RbfKernel) -> Vec<f64> {
        let mut out: Vec<f64> = self.product.iter().map(|v| v / kernel.noise_variance).collect();
        self.factor.solve_lower(&mut out, columns);
        out
    }
}

/// The kernel of a half from those to points and images.
pub(crate) fn join(sign: Sign, k: &Squared, out: &mut Vec<f64>) {
    out.clear();
    match sign {
        Sign::Only => out.extend_from_slice(&k.own),
        sign => out.extend(k.own.iter().zip(&k.image).map(|(a, b)| sign.join(*a, *b))),
    }
}

/// Halves of examples taken as they are.
pub(crate) fn exact(cloud: &Cloud, targets: &Targets, kernel: &RbfKernel) -> Result<Vec<Half>, FitError> {
    let n = cloud.len();
    let mut squared = Squared::default();
    cloud.squared(cloud.points(), n, &mut squared);
    squared.own.iter_mut().step_by(n + 1).for_each(|v| *v = 0.0);
    kernel.of(&mut squared.own);
    kernel.of(&mut squared.image);
    let mut k = Vec::new();
    let mut halves = Vec::new();
    for part in &targets.parts {
        join(part.sign, &squared, &mut k);
        k.iter_mut().step_by(n + 1).for_each(|v| *v += kernel.noise_variance);
        let factor = Factor::of(k.clone(), n).ok_or_else(|| not_definite(kernel))?;
        let mut whitened = part.values.clone();
        factor.solve_lower(&mut whitened, part.columns);
        halves.push(Half {
            sign: part.sign,
            first: part.first,
            columns: part.columns,
            factor,
            sparse: None,
            whitened,
        });
    }
    Ok(halves)
}

/// Halves of examples seen through inducing points.
pub(crate) fn through(
    inducing: &Cloud,
    cloud: &Cloud,
    targets: &Targets,
    kernel: &RbfKernel,
) -> Result<Vec<Half>, FitError> {
    let (m, n) = (inducing.len(), cloud.len());
    let (mut own, mut cross) = (Squared::default(), Squared::default());
    inducing.squared(inducing.points(), m, &mut own);
    own.own.iter_mut().step_by(m + 1).for_each(|v| *v = 0.0);
    inducing.squared(cloud.points(), n, &mut cross);
    for k in [&mut own, &mut cross] {
        kernel.of(&mut k.own);
        kernel.of(&mut k.image);
    }
    let mut halves = Vec::new();
    let (mut k, mut v) = (Vec::new(), Vec::new());
    for part in &targets.parts {
        join(part.sign, &own, &mut k);
        k.iter_mut().step_by(m + 1).for_each(|v| *v += JITTER * kernel.signal_variance);
        let factor = Factor::of(k.clone(), m).ok_or_else(|| not_definite(kernel))?;
        join(part.sign, &cross, &mut v);
        factor.solve_lower(&mut v, n);
        let sparse =
            Sparse::new(&v, m, &part.values, part.columns, kernel).ok_or_else(|| not_definite(kernel))?;
        let whitened = sparse.whitened(part.columns, kernel);
        halves.push(Half {
            sign: part.sign,
            first: part.first,
            columns: part.columns,
            factor,
            sparse: Some(sparse),
            whitened,
        });
    }
    Ok(halves)
}
