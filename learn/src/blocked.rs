//! Dense kernels for hundreds to thousands of rows: products in blocks, by the `gemm` of nalgebra.
//!
//! Matrices are row-major slices. A factor L (L Lᵀ = A) keeps the inverses of its diagonal blocks, so that solving is
//! products only. The order of all sums depends on sizes alone. [`crate::dense`] is the same for key poses, where
//! loops without packing are faster, and factors the diagonal blocks here.

use nalgebra::{Dyn, MatrixView, MatrixViewMut};

use crate::dense::{cholesky_from, invert_lower};

/// Rows of a block.
const BLOCK: usize = 64;
/// Columns of a strip when a triangle is multiplied.
const STRIP: usize = 128;

/// Up to this size `gemm` is a loop over columns, which has no business with row-major matrices.
const SMALL: usize = 5;

/// A matrix with any strides.
pub type View<'a> = MatrixView<'a, f64, Dyn, Dyn, Dyn, Dyn>;

/// A row-major matrix with `stride` numbers from row to row.
pub fn view(data: &[f64], rows: usize, columns: usize, stride: usize) -> View<'_> {
    View::from_slice_with_strides_generic(data, Dyn(rows), Dyn(columns), Dyn(stride), Dyn(1))
}

/// The transpose of a row-major matrix of `rows` × `columns`.
pub fn transposed(data: &[f64], rows: usize, columns: usize, stride: usize) -> View<'_> {
    View::from_slice_with_strides_generic(data, Dyn(columns), Dyn(rows), Dyn(1), Dyn(stride))
}

/// `out` = α a b + β `out`, row-major with `stride`.
pub fn multiply(out: &mut [f64], stride: usize, alpha: f64, a: &View<'_>, b: &View<'_>, beta: f64) {
    let (rows, inner, columns) = (a.nrows(), a.ncols(), b.ncols());
    if rows == 0 || columns == 0 {
        return;
    }
    if rows.min(inner).min(columns) <= SMALL {
        for i in 0..rows {
            for j in 0..columns {
                let sum: f64 = (0..inner).map(|k| a[(i, k)] * b[(k, j)]).sum();
                let o = &mut out[i * stride + j];
                *o = alpha * sum + if beta == 0.0 { 0.0 } else { beta * *o };
            }
        }
        return;
    }
    let mut out: MatrixViewMut<'_, f64, Dyn, Dyn, Dyn, Dyn> =
        MatrixViewMut::from_slice_with_strides_generic(out, Dyn(rows), Dyn(columns), Dyn(stride), Dyn(1));
    out.gemm(alpha, a, b, beta);
}

/// The lower factor L of a symmetric positive definite matrix.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Factor {
    n: usize,
    /// Row-major n × n; what lies above the diagonal is not read.
    l: Vec<f64>,
    /// Inverses of the diagonal blocks, each row-major.
    blocks: Vec<f64>,
}

impl Factor {
    /// Of the lower triangle of the row-major n × n matrix that `fill` writes; `None` if it is not positive definite.
    pub fn of(a: Vec<f64>, n: usize) -> Option<Factor> {
        let mut factor = Factor { n, l: a, blocks: Vec::new() };
        factor.factor_from(0).then_some(factor)
    }

    /// Of the lower triangle that `fill` writes into the memory of this one; `false` if it is not positive definite.
    pub fn renew(&mut self, n: usize, fill: impl FnOnce(&mut [f64])) -> bool {
        self.n = n;
        self.l.resize(n * n, 0.0);
        fill(&mut self.l);
        self.factor_from(0)
    }

    /// Of the matrix with `more` rows below: row-major, each as long as the whole is then. The rows there are stay.
    pub fn extended(&self, rows: &[f64], more: usize) -> Option<Factor> {
        let n = self.n + more;
        let mut l = vec![0.0; n * n];
        for (to, from) in l.chunks_exact_mut(n).zip(self.l.chunks_exact(self.n.max(1))) {
            to[..self.n].copy_from_slice(from);
        }
        l[self.n * n..].copy_from_slice(rows);
        let mut factor = Factor { n, l, blocks: self.blocks.clone() };
        factor.factor_from(self.n).then_some(factor)
    }

    /// Rows of the matrix.
    pub fn len(&self) -> usize {
        self.n
    }

    /// Row `i` of L, to its diagonal.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.l[i * self.n..i * self.n + i + 1]
    }

    /// ln |A|.
    pub fn ln_det(&self) -> f64 {
        2.0 * (0..self.n).map(|i| self.l[i * self.n + i].ln()).sum::<f64>()
    }

    /// Column block by column block; rows before `from` hold L.
    fn factor_from(&mut self, from: usize) -> bool {
        let n = self.n;
        self.blocks.resize(n.div_ceil(BLOCK) * BLOCK * BLOCK, 0.0);
        let mut panel = Vec::new();
        let mut block = Vec::new();
        for j in (0..n).step_by(BLOCK) {
            let end = (j + BLOCK).min(n);
            let width = end - j;
            let start = j.max(from);
            if start >= n {
                break;
            }
            // A[start.., j..end] −= L[start.., ..j] L[j..end, ..j]ᵀ
            if j > 0 {
                let rows = n - start;
                panel.resize(rows * width, 0.0);
                let below = view(&self.l[start * n..], rows, j, n);
                let across = transposed(&self.l[j * n..], width, j, n);
                multiply(&mut panel, width, 1.0, &below, &across, 0.0);
                for (i, p) in panel.chunks_exact(width).enumerate() {
                    let row = (start + i) * n;
                    self.l[row + j..row + end].iter_mut().zip(p).for_each(|(a, p)| *a -= p);
                }
            }
            if start < end {
                block.resize(width * width, 0.0);
                for (i, b) in block.chunks_exact_mut(width).enumerate() {
                    b.copy_from_slice(&self.l[(j + i) * n + j..(j + i) * n + end]);
                }
                if !cholesky_from(&mut block, width, start - j) {
                    return false;
                }
                for (i, b) in block.chunks_exact(width).enumerate() {
                    self.l[(j + i) * n + j..(j + i) * n + end].copy_from_slice(b);
                }
                let inverse = &mut self.blocks[j * BLOCK..j * BLOCK + width * width];
                invert_lower(&block, width, inverse);
            }
            // L[below, j..end] = A[below, j..end] L_jj⁻ᵀ
            let first = end.max(from);
            let rows = n - first;
            if rows > 0 {
                panel.resize(rows * width, 0.0);
                let inverse = &self.blocks[j * BLOCK..j * BLOCK + width * width];
                let below = view(&self.l[first * n + j..], rows, width, n);
                multiply(&mut panel, width, 1.0, &below, &transposed(inverse, width, width, width), 0.0);
                for (i, p) in panel.chunks_exact(width).enumerate() {
                    let row = (first + i) * n;
                    self.l[row + j..row + end].copy_from_slice(p);
                }
            }
        }
        true
    }

    fn block(&self, j: usize) -> (usize, &[f64]) {
        let width = (j + BLOCK).min(self.n) - j;
        (width, &self.blocks[j * BLOCK..j * BLOCK + width * width])
    }

    /// L⁻¹ b in place of `b` (n × m, row-major).
    pub fn solve_lower(&self, b: &mut [f64], m: usize) {
        self.solve_lower_from(b, m, 0);
    }

    /// The same when the rows before `from` hold the answer; only whole blocks are skipped.
    pub fn solve_lower_from(&self, b: &mut [f64], m: usize, from: usize) {
        let (n, mut copy) = (self.n, Vec::new());
        if m == 0 {
            return;
        }
        for j in (0..n).step_by(BLOCK) {
            let (width, inverse) = self.block(j);
            if j + width <= from {
                continue;
            }
            let skip = from.saturating_sub(j);
            let rows = width - skip;
            let (above, rest) = b.split_at_mut((j + skip) * m);
            let here = &mut rest[..rows * m];
            multiply(here, m, -1.0, &view(&self.l[(j + skip) * n..], rows, j, n), &view(above, j, m, m), 1.0);
            if skip == 0 {
                copy.clear();
                copy.extend_from_slice(here);
                multiply(here, m, 1.0, &view(inverse, width, width, width), &view(&copy, width, m, m), 0.0);
            } else {
                for i in j + skip..j + width {
                    let l = self.row(i);
                    let (above, row) = b.split_at_mut(i * m);
                    let row = &mut row[..m];
                    for k in j..i {
                        crate::dense::axpy(-l[k], &above[k * m..(k + 1) * m], row);
                    }
                    row.iter_mut().for_each(|v| *v /= l[i]);
                }
            }
        }
    }

    /// L⁻ᵀ b in place of `b` (n × m, row-major).
    pub fn solve_upper(&self, b: &mut [f64], m: usize) {
        let (n, mut copy) = (self.n, Vec::new());
        if m == 0 {
            return;
        }
        for j in (0..n).step_by(BLOCK).rev() {
            let (width, inverse) = self.block(j);
            let end = j + width;
            let (head, below) = b.split_at_mut(end * m);
            let here = &mut head[j * m..];
            if end < n {
                let l = transposed(&self.l[end * n + j..], n - end, width, n);
                multiply(here, m, -1.0, &l, &view(below, n - end, m, m), 1.0);
            }
            copy.clear();
            copy.extend_from_slice(here);
            multiply(here, m, 1.0, &transposed(inverse, width, width, width), &view(&copy, width, m, m), 0.0);
        }
    }

    /// L⁻¹ b in place of one column; allocates nothing.
    pub fn solve_one(&self, b: &mut [f64]) {
        for i in 0..self.n {
            let l = self.row(i);
            b[i] = (b[i] - crate::dense::dot(&l[..i], &b[..i])) / l[i];
        }
    }

    /// Writes L⁻¹ (n × n, row-major, zero above the diagonal).
    pub fn invert(&self, out: &mut Vec<f64>) {
        let n = self.n;
        out.clear();
        out.resize(n * n, 0.0);
        let mut product = Vec::new();
        for i in (0..n).step_by(BLOCK) {
            let (width, inverse) = self.block(i);
            let (done, rest) = out.split_at_mut(i * n);
            // X[i, ..i] = −L_ii⁻¹ L[i, ..i] X[..i, ..i], strip by strip of the lower triangular X.
            product.clear();
            product.resize(width * i, 0.0);
            for s in (0..i).step_by(STRIP) {
                let end = (s + STRIP).min(i);
                let l = view(&self.l[i * n + s..], width, i - s, n);
                let x = view(&done[s * n + s..], i - s, end - s, n);
                multiply(&mut product[s..], i, 1.0, &l, &x, 0.0);
            }
            if i > 0 {
                let product = view(&product, width, i, i);
                multiply(rest, n, -1.0, &view(inverse, width, width, width), &product, 0.0);
            }
            for (k, row) in inverse.chunks_exact(width).enumerate() {
                rest[k * n + i..k * n + i + width].copy_from_slice(row);
            }
        }
    }
}

/// Writes α LᵀL − β A Aᵀ into the lower triangle of `out`, of the lower triangular `l` (n × n) and `a` (n × m), all
/// row-major. What is above the diagonal is not meaningful.
pub fn gram_of_lower_less(
    l: &[f64],
    n: usize,
    alpha: f64,
    a: &[f64],
    m: usize,
    beta: f64,
    out: &mut Vec<f64>,
) {
    out.resize(n * n, 0.0);
    for i in (0..n).step_by(BLOCK) {
        let end = (i + BLOCK).min(n);
        let here = &mut out[i * n..];
        let left = transposed(&l[i * n + i..], n - i, end - i, n);
        multiply(here, n, alpha, &left, &view(&l[i * n..], n - i, end, n), 0.0);
        if m > 0 {
            let left = view(&a[i * m..], end - i, m, m);
            multiply(here, n, -beta, &left, &transposed(a, end, m, m), 1.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{matrix, stream};

    /// Products of all shapes, views of larger matrices and transposes among them, are the sums.
    #[test]
    fn products_are_the_sums() {
        let mut rng = stream(8);
        for (m, k, n) in [(1, 1, 1), (3, 9, 2), (7, 64, 6), (65, 6, 7), (20, 130, 70), (6, 6, 6), (1, 40, 64)]
        {
            let (a, b) = (matrix(m, k, &mut rng), matrix(k, n, &mut rng));
            let wanted = &a * &b;
            let rows = |x: &nalgebra::DMatrix<f64>| x.transpose().as_slice().to_vec();
            let mut out = vec![0.5; m * (n + 3)];
            multiply(&mut out, n + 3, 2.0, &view(&rows(&a), m, k, k), &view(&rows(&b), k, n, n), 1.0);
            let mut other = vec![f64::NAN; m * n];
            multiply(
                &mut other,
                n,
                1.0,
                &transposed(a.as_slice(), k, m, m),
                &transposed(b.as_slice(), n, k, k),
                0.0,
            );
            for i in 0..m {
                for j in 0..n {
                    let w = wanted[(i, j)];
                    assert!((out[i * (n + 3) + j] - 2.0 * w - 0.5).abs() < 1e-12, "{m} {k} {n}");
                    assert!((other[i * n + j] - w).abs() < 1e-12, "{m} {k} {n}");
                }
            }
        }
    }

    /// A covariance of `n` points on a line.
    fn covariance(n: usize) -> Vec<f64> {
        let at = |i: usize, j: usize| (-0.5 * ((i as f64 - j as f64) / 7.0).powi(2)).exp();
        (0..n * n).map(|i| at(i / n, i % n) + if i / n == i % n { 0.01 } else { 0.0 }).collect()
    }

    /// L Lᵀ is the matrix, L⁻¹ L one, solving below and above undoes multiplying, below one block and above.
    #[test]
    fn the_factor_is_one() {
        for n in [1, 5, 64, 65, 200] {
            let a = covariance(n);
            let factor = Factor::of(a.clone(), n).unwrap();
            for i in 0..n {
                for j in 0..=i {
                    let sum: f64 = (0..=j).map(|k| factor.row(i)[k] * factor.row(j)[k]).sum();
                    assert!((sum - a[i * n + j]).abs() < 1e-14, "{n}");
                }
            }
            let mut inverse = Vec::new();
            factor.invert(&mut inverse);
            let m = 7;
            let b = matrix(n, m, &mut stream(3)).transpose().as_slice().to_vec();
            let mut x = b.clone();
            factor.solve_lower(&mut x, m);
            let mut by_inverse = vec![0.0; n * m];
            multiply(&mut by_inverse, m, 1.0, &view(&inverse, n, n, n), &view(&b, n, m, m), 0.0);
            let mut one: Vec<f64> = b.iter().step_by(m).copied().collect();
            factor.solve_one(&mut one);
            for i in 0..n {
                assert!((x[i * m] - one[i]).abs() < 1e-11, "{n}");
                assert!((x[i * m] - by_inverse[i * m]).abs() < 1e-10, "{n}");
            }
            factor.solve_upper(&mut x, m);
            let mut back = vec![0.0; n * m];
            multiply(&mut back, m, 1.0, &view(&a, n, n, n), &view(&x, n, m, m), 0.0);
            let worst = back.iter().zip(&b).fold(0.0_f64, |w, (a, b)| w.max((a - b).abs()));
            assert!(worst < 1e-11, "{n}: {worst:e}");
            let mut gram = Vec::new();
            gram_of_lower_less(&inverse, n, 2.0, &b, m, 0.5, &mut gram);
            for i in 0..n {
                for j in 0..=i {
                    let known: f64 = (0..n).map(|k| 2.0 * inverse[k * n + i] * inverse[k * n + j]).sum();
                    let less: f64 = (0..m).map(|c| 0.5 * b[i * m + c] * b[j * m + c]).sum();
                    assert!((gram[i * n + j] - known + less).abs() < 1e-11 * known.abs().max(1.0), "{n}");
                }
            }
        }
    }

    /// A factor with rows added is that of the whole matrix, wherever blocks end, and so is what is solved with it.
    #[test]
    fn rows_added_are_rows_there_before() {
        let whole = 200;
        let a = covariance(whole);
        let wanted = Factor::of(a.clone(), whole).unwrap();
        let m = 6;
        let b = matrix(whole, m, &mut stream(5)).transpose().as_slice().to_vec();
        let mut solved = b.clone();
        wanted.solve_lower(&mut solved, m);
        for n in [1, 40, 64, 100, 128, 190] {
            let part: Vec<f64> = (0..n).flat_map(|i| a[i * whole..i * whole + n].to_vec()).collect();
            let few = Factor::of(part, n).unwrap();
            let grown = few.extended(&a[n * whole..], whole - n).unwrap();
            for i in 0..whole {
                for (x, y) in grown.row(i).iter().zip(wanted.row(i)) {
                    assert!((x - y).abs() < 1e-12, "{n}");
                }
            }
            let mut x = b[..n * m].to_vec();
            few.solve_lower(&mut x, m);
            x.extend_from_slice(&b[n * m..]);
            grown.solve_lower_from(&mut x, m, n);
            let worst = x.iter().zip(&solved).fold(0.0_f64, |w, (a, b)| w.max((a - b).abs()));
            assert!(worst < 1e-11, "{n}: {worst:e}");
        }
    }

    /// What is not positive definite is refused, in the first block, in a later one, in rows added, and with NaN.
    #[test]
    fn what_is_not_definite_is_refused() {
        for bad in [3, 150] {
            for value in [-1.0, f64::NAN] {
                let mut a = covariance(180);
                a[bad * 181] = value;
                assert!(Factor::of(a.clone(), 180).is_none());
                if bad > 100 {
                    let part: Vec<f64> = (0..100).flat_map(|i| a[i * 180..i * 180 + 100].to_vec()).collect();
                    assert!(Factor::of(part, 100).unwrap().extended(&a[100 * 180..], 80).is_none());
                }
            }
        }
    }
}
