//! Symmetric banded systems: assembly by rows and Cholesky factorisation, linear in length.
//!
//! In: a positive definite matrix whose entries farther than `width` from the diagonal are zero. Out: the
//! solution. Row `i` of the lower triangle is stored as the `width + 1` entries of columns `i − width ..= i`;
//! factoring takes `n · width²/2` multiplications.

use crate::cholesky::dot;

/// A symmetric banded matrix, lower triangle. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    n: usize,
    width: usize,
    rows: Vec<f64>,
}

impl Band {
    /// All zero: `n` rows, `width` sub-diagonals.
    pub fn zeros(n: usize, width: usize) -> Self {
        let width = width.min(n.saturating_sub(1));
        Self { n, width, rows: vec![0.0; n * (width + 1)] }
    }

    /// All zero again, of another size.
    pub fn reset(&mut self, n: usize, width: usize) {
        (self.n, self.width) = (n, width.min(n.saturating_sub(1)));
        self.rows.clear();
        self.rows.resize(n * (self.width + 1), 0.0);
    }

    /// Rows.
    pub fn len(&self) -> usize {
        self.n
    }

    /// Whether it has no rows.
    pub fn is_empty(&self) -> bool {
        self.n == 0
    }

    /// The entry at row `i`, column `j` ≤ `i`, to be changed.
    ///
    /// # Panics
    /// Above the diagonal or outside the band.
    pub fn at(&mut self, i: usize, j: usize) -> &mut f64 {
        assert!(j <= i && i - j <= self.width, "({i}, {j}) is outside the band");
        &mut self.rows[i * (self.width + 1) + self.width - (i - j)]
    }

    /// Entries of row `i` from column `j` on, `count` of them, none right of the diagonal.
    pub fn row_mut(&mut self, i: usize, j: usize, count: usize) -> &mut [f64] {
        let from = i * (self.width + 1) + self.width - (i - j);
        &mut self.rows[from..from + count]
    }

    /// The same values in all rows.
    pub fn fill(&mut self, x: f64) {
        self.rows.fill(x);
    }

    /// Solves `(A + damping · diag A) x = b` into `b`; `factor` is scratch of the same shape.
    ///
    /// # Errors
    /// The first row at which the matrix is found not to be positive definite.
    pub fn solve(&self, damping: f64, factor: &mut Band, b: &mut [f64]) -> Result<(), usize> {
        factor.n = self.n;
        factor.width = self.width;
        factor.rows.clear();
        factor.rows.extend_from_slice(&self.rows);
        let w = self.width;
        let stride = w + 1;
        for i in 0..self.n {
            let first = i.saturating_sub(w);
            let (head, tail) = factor.rows.split_at_mut(i * stride);
            let row = &mut tail[..stride];
            row[w] *= 1.0 + damping;
            for j in first..i {
                // columns that both rows have: from max(i, j) − width
                let shared = j - first;
                let other = &head[j * stride..(j + 1) * stride];
                let at = w - (i - j);
                let sum = dot(&row[at - shared..at], &other[w - shared..w]);
                row[at] = (row[at] - sum) / other[w];
            }
            let used = &row[w - (i - first)..w];
            let pivot = row[w] - dot(used, used);
            if !(pivot > 0.0 && pivot.is_finite()) {
                return Err(i);
            }
            row[w] = pivot.sqrt();
        }
        for i in 0..self.n {
            let first = i.saturating_sub(w);
            let row = &factor.rows[i * stride..(i + 1) * stride];
            b[i] = (b[i] - dot(&row[w - (i - first)..w], &b[first..i])) / row[w];
        }
        for i in (0..self.n).rev() {
            let first = i.saturating_sub(w);
            let row = &factor.rows[i * stride..(i + 1) * stride];
            b[i] /= row[w];
            let x = b[i];
            b[first..i].iter_mut().zip(&row[w - (i - first)..w]).for_each(|(y, l)| *y -= l * x);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A·x recovered from b = A·x, for a band and for a full matrix.
    #[test]
    fn solves_what_it_was_given() {
        for (n, w) in [(60, 7), (5, 9), (1, 0), (40, 1)] {
            let mut a = Band::zeros(n, w);
            let entry = |i: usize, j: usize| {
                if i == j { 2.0 * w as f64 + 1.0 } else { ((7 * i + 3 * j) % 5) as f64 / 2.5 - 0.8 }
            };
            let inside = |i: usize, j: usize| i.abs_diff(j) <= w;
            for i in 0..n {
                for j in i.saturating_sub(w)..=i {
                    *a.at(i, j) = entry(i, j);
                }
            }
            let x: Vec<f64> = (0..n).map(|i| (i as f64 * 0.7).sin()).collect();
            let value = |i: usize, j: usize| if inside(i, j) { entry(i.max(j), i.min(j)) } else { 0.0 };
            let mut b: Vec<f64> = (0..n).map(|i| (0..n).map(|j| value(i, j) * x[j]).sum()).collect();
            let mut scratch = Band::zeros(0, 0);
            a.solve(0.0, &mut scratch, &mut b).unwrap();
            let worst = b.iter().zip(&x).map(|(p, q)| (p - q).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-11, "{n} {w}: {worst}"); // 1e-14 seen
        }
    }

    #[test]
    fn an_indefinite_row_is_named() {
        let mut a = Band::zeros(3, 1);
        (0..3).for_each(|i| *a.at(i, i) = 1.0);
        *a.at(2, 1) = 2.0;
        assert_eq!(a.solve(0.0, &mut Band::zeros(0, 0), &mut [1.0; 3]), Err(2));
    }
}
