//! A symmetric block-pentadiagonal matrix whose off-diagonal blocks are diagonal, and its factors.
//!
//! In: for every frame a dense block on the diagonal, and the diagonals of the blocks `(f + 1, f)` and `(f + 2, f)`: unknowns of a frame
//! are coupled with each other, and over time each with itself. Out: the solution of linear equations.
//!
//! *Factors* `A = L D Lᵀ` by blocks, L unit lower, `Dᶠ` dense. With `P = D⁻¹` and `S` the diagonal block `(f + 2, f)`,
//!
//! ```text
//! Bᶠ = A(f+1, f) − Sᶠ⁻¹ Wᶠ⁻¹ᵀ      Wᶠ = L(f+1, f) = Bᶠ Pᶠ      L(f+2, f) = Sᶠ Pᶠ
//! Dᶠ = A(f, f) − Wᶠ⁻¹ Bᶠ⁻¹ᵀ − Sᶠ⁻² Pᶠ⁻² Sᶠ⁻²
//! ```
//!
//! (superscripts are frames), so that two products of blocks and one inverse a frame do, and `L(f+2, f)` need not be stored.
//! No pivots: A must be positive definite. O(frames × n³) time, `2 n² + 2 n` numbers of memory a frame.

use nalgebra::{DMatrixView, DMatrixViewMut, DVectorView, DVectorViewMut};

/// The matrix; after [`BlockBand::factor`] its factors. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockBand {
    n: usize,
    frames: usize,
    /// Blocks `(f, f)`, column by column; then P.
    main: Vec<f64>,
    /// W.
    lower: Vec<f64>,
    /// Diagonals of the blocks `(f + 1, f)`.
    first: Vec<f64>,
    /// Diagonals of the blocks `(f + 2, f)`.
    second: Vec<f64>,
    scratch: Scratch,
}

#[derive(Clone, Debug, PartialEq)]
struct Scratch {
    below: Vec<f64>,
    turned: Vec<f64>,
    inverse: Vec<f64>,
    vector: Vec<f64>,
}

/// A block is not positive definite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotPositive {
    /// Its frame.
    pub frame: usize,
}

impl BlockBand {
    /// A matrix of zeros: `frames` blocks of `n × n` on the diagonal.
    pub fn zeros(n: usize, frames: usize) -> Self {
        let square = || vec![0.0; n * n];
        let scratch = Scratch { below: square(), turned: square(), inverse: square(), vector: vec![0.0; n] };
        let (blocks, diagonals) = (n * n * frames, n * frames);
        Self {
            n,
            frames,
            main: vec![0.0; blocks],
            lower: vec![0.0; blocks],
            first: vec![0.0; diagonals],
            second: vec![0.0; diagonals],
            scratch,
        }
    }

    /// Sets everything to zero again, without giving memory back.
    pub fn clear(&mut self) {
        for part in [&mut self.main, &mut self.first, &mut self.second] {
            part.fill(0.0);
        }
    }

    /// The block `(f, f)`, `n × n`, column by column; both triangles count.
    pub fn block_mut(&mut self, f: usize) -> &mut [f64] {
        let size = self.n * self.n;
        &mut self.main[f * size..][..size]
    }

    /// Entry `i` of the diagonals of the blocks `(f, f)`, `(f + 1, f)` and `(f + 2, f)` becomes more; the latter two
    /// where there are such blocks.
    pub fn add(&mut self, f: usize, i: usize, more: [f64; 3]) {
        let n = self.n;
        self.main[f * n * n + i * (n + 1)] += more[0];
        self.first[f * n + i] += more[1];
        self.second[f * n + i] += more[2];
    }

    /// Numbers that it holds in memory.
    pub fn len(&self) -> usize {
        self.main.len() + self.lower.len() + self.first.len() + self.second.len()
    }

    /// Whether it holds none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Factors in place.
    ///
    /// # Errors
    /// [`NotPositive`]: the matrix is not positive definite.
    pub fn factor(&mut self) -> Result<(), NotPositive> {
        let (n, size) = (self.n, self.n * self.n);
        let Scratch { below, turned, inverse, .. } = &mut self.scratch;
        for f in 0..self.frames {
            let (done, ahead) = self.main.split_at_mut((f + 1) * size);
            let p = &mut done[f * size..];
            if !invert(p, inverse, n) {
                return Err(NotPositive { frame: f });
            }
            if f + 1 == self.frames {
                break;
            }
            // B, and its transpose
            below.fill(0.0);
            if f > 0 {
                let (w, s) = (&self.lower[(f - 1) * size..][..size], &self.second[(f - 1) * n..][..n]);
                for i in 0..n {
                    for j in 0..n {
                        below[j * n + i] = -s[i] * w[i * n + j];
                    }
                }
            }
            for i in 0..n {
                below[i * (n + 1)] += self.first[f * n + i];
            }
            for i in 0..n {
                for j in 0..n {
                    turned[i * n + j] = below[j * n + i];
                }
            }
            let mut w = DMatrixViewMut::from_slice(&mut self.lower[f * size..][..size], n, n);
            w.gemm(1.0, &DMatrixView::from_slice(below, n, n), &DMatrixView::from_slice(p, n, n), 0.0);
            DMatrixViewMut::from_slice(&mut ahead[..size], n, n).gemm(
                -1.0,
                &w,
                &DMatrixView::from_slice(turned, n, n),
                1.0,
            );
            if f + 2 < self.frames {
                let s = &self.second[f * n..][..n];
                for (j, column) in ahead[size..2 * size].chunks_exact_mut(n).enumerate() {
                    for ((a, p), si) in column.iter_mut().zip(&p[j * n..]).zip(s) {
                        *a -= si * p * s[j];
                    }
                }
            }
        }
        Ok(())
    }

    /// Solves `A x = b` into `b` (frame after frame, `n` each), after [`BlockBand::factor`].
    pub fn solve(&mut self, b: &mut [f64]) {
        let (n, size) = (self.n, self.n * self.n);
        let block = |of: &'_ [f64], f: usize| -> std::ops::Range<usize> {
            debug_assert!(of.len() >= (f + 1) * size);
            f * size..(f + 1) * size
        };
        let vector = &mut self.scratch.vector;
        for f in 0..self.frames {
            let (now, ahead) = b[f * n..].split_at_mut(n);
            let p = DMatrixView::from_slice(&self.main[block(&self.main, f)], n, n);
            if f + 1 < self.frames {
                let w = DMatrixView::from_slice(&self.lower[block(&self.lower, f)], n, n);
                let mut next = DVectorViewMut::from_slice(&mut ahead[..n], n);
                next.gemv(-1.0, &w, &DVectorView::from_slice(now, n), 1.0);
            }
            DVectorViewMut::from_slice(vector, n).gemv(1.0, &p, &DVectorView::from_slice(now, n), 0.0);
            now.copy_from_slice(vector);
            if f + 2 < self.frames {
                let s = &self.second[f * n..][..n];
                for ((x, z), s) in ahead[n..2 * n].iter_mut().zip(now.iter()).zip(s) {
                    *x -= s * z;
                }
            }
        }
        for f in (0..self.frames.saturating_sub(1)).rev() {
            let (now, ahead) = b[f * n..].split_at_mut(n);
            let mut now = DVectorViewMut::from_slice(now, n);
            let w = DMatrixView::from_slice(&self.lower[block(&self.lower, f)], n, n);
            now.gemv_tr(-1.0, &w, &DVectorView::from_slice(&ahead[..n], n), 1.0);
            if f + 2 < self.frames {
                let s = &self.second[f * n..][..n];
                for ((v, x), s) in vector.iter_mut().zip(&ahead[n..2 * n]).zip(s) {
                    *v = s * x;
                }
                let p = DMatrixView::from_slice(&self.main[block(&self.main, f)], n, n);
                now.gemv(-1.0, &p, &DVectorView::from_slice(vector, n), 1.0);
            }
        }
    }
}

/// The inverse of a positive definite matrix, in place; false if it is not one. `x`: memory of the same size.
fn invert(a: &mut [f64], x: &mut [f64], n: usize) -> bool {
    // Cholesky, lower triangle
    for j in 0..n {
        let (left, right) = a.split_at_mut((j + 1) * n);
        let column = &mut left[j * n..];
        if !(column[j] > 0.0 && column[j].is_finite()) {
            return false;
        }
        let pivot = 1.0 / column[j].sqrt();
        column[j..].iter_mut().for_each(|v| *v *= pivot);
        for k in j + 1..n {
            let factor = column[k];
            let at = (k - j - 1) * n;
            for (v, c) in right[at + k..at + n].iter_mut().zip(&column[k..]) {
                *v -= factor * c;
            }
        }
    }
    // X = L⁻¹, column by column
    x.fill(0.0);
    for j in 0..n {
        let column = &mut x[j * n..(j + 1) * n];
        column[j] = 1.0;
        for k in j..n {
            let l = &a[k * n..(k + 1) * n];
            column[k] /= l[k];
            let factor = column[k];
            for (v, l) in column[k + 1..].iter_mut().zip(&l[k + 1..]) {
                *v -= factor * l;
            }
        }
    }
    // its rows, as columns of a
    for k in 0..n {
        for j in 0..=k {
            a[k * n + j] = x[j * n + k];
        }
    }
    // Xᵀ X
    x.fill(0.0);
    for k in 0..n {
        let row = &a[k * n..=k * n + k];
        for (j, factor) in row.iter().enumerate() {
            for (v, r) in x[j * n..=j * n + j].iter_mut().zip(row) {
                *v += factor * r;
            }
        }
    }
    for j in 0..n {
        for i in 0..=j {
            a[j * n + i] = x[j * n + i];
            a[i * n + j] = x[j * n + i];
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    /// A band and the same matrix in full: squares of couplings over three frames, and a dense block each.
    fn example(n: usize, frames: usize) -> (BlockBand, DMatrix<f64>) {
        let mut band = BlockBand::zeros(n, frames);
        let mut full = DMatrix::zeros(n * frames, n * frames);
        let wave = |a: usize, b: usize| (0.7 * a as f64 + 1.9 * b as f64 + 0.3).sin();
        for f in 0..frames {
            let half = DMatrix::from_fn(n, 3, |i, k| 5.0 * wave(i + f, k));
            let dense = &half * half.transpose() + DMatrix::identity(n, n) * 0.1;
            for j in 0..n {
                for i in 0..n {
                    band.block_mut(f)[j * n + i] += dense[(i, j)];
                    full[(f * n + i, f * n + j)] += dense[(i, j)];
                }
            }
            for i in 0..n {
                let row = [1.0, -2.0, 1.0 + 0.1 * wave(i, f)];
                let there = row.len().min(frames - f);
                for a in 0..there {
                    let mut more = [0.0; 3];
                    for b in a..there {
                        more[b - a] = row[a] * row[b];
                        full[((f + b) * n + i, (f + a) * n + i)] += row[a] * row[b];
                        if a != b {
                            full[((f + a) * n + i, (f + b) * n + i)] += row[a] * row[b];
                        }
                    }
                    band.add(f + a, i, more);
                }
            }
        }
        (band, full)
    }

    #[test]
    fn the_solution_is_that_of_the_full_matrix() {
        for (n, frames) in [(1, 1), (1, 9), (4, 1), (4, 2), (4, 3), (7, 20)] {
            let (mut band, full) = example(n, frames);
            let b = DVector::from_fn(n * frames, |i, _| (1.3 * i as f64).cos());
            let expected = full.cholesky().unwrap().solve(&b);
            band.factor().unwrap();
            let mut x = b.as_slice().to_vec();
            band.solve(&mut x);
            let apart = (&DVector::from_vec(x) - &expected).amax();
            assert!(apart < 1e-9 * expected.amax(), "{n} {frames}: {apart:e}");
        }
    }

    #[test]
    fn what_is_not_positive_is_refused() {
        let (mut band, _) = example(3, 5);
        band.add(2, 1, [-1e3, 0.0, 0.0]);
        assert_eq!(band.factor(), Err(NotPositive { frame: 2 }));
    }

    /// Ten times the frames hold ten times the numbers: 2 n² + 2 n each.
    #[test]
    fn memory_grows_with_frames_alone() {
        assert_eq!(BlockBand::zeros(30, 100).len(), 100 * (2 * 900 + 60));
        assert_eq!(BlockBand::zeros(30, 1000).len(), 1000 * (2 * 900 + 60));
    }
}
