//! Symmetric block-banded systems: assembly by blocks and Cholesky factorisation, linear in length.
//!
//! In: a positive definite matrix of `size × size` blocks, zero where block row and column are more than `reach` apart.
//! Out: the solution. Factoring takes `n (reach · size)²` multiplications and as many additions for `n` rows.
//!
//! *Storage.* Block rows are taken together to panels of some `PANEL` rows. A panel holds its columns one after the
//! other, from the first that any of its rows needs up to its diagonal: what two panels have to do with each other is
//! then a product of two dense matrices, whose factors fit into the caches.
//!
//! *Factorisation* `A = L Lᵀ`, panel p by panel, tile (p, j) by tile:
//!
//! ```text
//! L_pj = (A_pj − Σ_{k<j} L_pk L_jkᵀ) L_jj⁻ᵀ      L_pp L_ppᵀ = A_pp − Σ_{k<p} L_pk L_pkᵀ
//! ```
//!
//! (Golub, Van Loan, Matrix Computations, §4.2.9 and §4.3.5.)

use nalgebra::{DMatrixView, DMatrixViewMut, Dyn};

use motion::linear::dot;

/// Most rows of a panel, unless a single block has more.
const PANEL: usize = 96;
/// Columns that are solved one by one, between products.
const STRIP: usize = 16;

/// A symmetric block-banded matrix, lower triangle. See the module header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Band {
    blocks: usize,
    size: usize,
    reach: usize,
    /// Block rows of a panel.
    together: usize,
    panels: Vec<f64>,
}

impl Band {
    /// All zero: `blocks` rows of blocks of `size × size`, of which each has `reach` to the left of its diagonal.
    pub fn zeros(blocks: usize, size: usize, reach: usize) -> Self {
        let mut out = Self::default();
        out.reset(blocks, size, reach);
        out
    }

    /// All zero again, of another shape.
    pub fn reset(&mut self, blocks: usize, size: usize, reach: usize) {
        let mut together = 1;
        while together < reach && 2 * together * size <= PANEL {
            together *= 2;
        }
        // whole tiles to the left
        let reach = reach.next_multiple_of(together);
        (self.blocks, self.size, self.reach, self.together) = (blocks, size, reach, together);
        let panels = blocks.div_ceil(together);
        self.panels.clear();
        self.panels.resize(panels * self.tile() * self.columns(), 0.0);
    }

    /// Rows.
    pub fn len(&self) -> usize {
        self.blocks * self.size
    }

    /// Whether it has no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Rows of a panel.
    fn tile(&self) -> usize {
        self.together * self.size
    }

    /// Columns that a panel stores.
    fn columns(&self) -> usize {
        (self.reach + self.together) * self.size
    }

    /// Column that panel `p` stores first; negative above the top of the matrix.
    fn first(&self, p: usize) -> isize {
        (p * self.tile()) as isize - (self.reach * self.size) as isize
    }

    /// Where the entry at row `i`, column `j` is.
    fn index(&self, i: usize, j: usize) -> usize {
        let (tile, p) = (self.tile(), i / self.tile());
        let column = (j as isize - self.first(p)) as usize;
        (p * self.columns() + column) * tile + i % tile
    }

    /// The entry at row `i`, column `j` ≤ `i`, to be changed.
    ///
    /// # Panics
    /// Above the diagonal or outside the band.
    pub fn at(&mut self, i: usize, j: usize) -> &mut f64 {
        let apart = (i / self.size).wrapping_sub(j / self.size);
        assert!(j <= i && i < self.len() && apart <= self.reach, "({i}, {j}) is outside the band");
        let at = self.index(i, j);
        &mut self.panels[at]
    }

    /// Columns of the block in block row `row` and block column `column` ≤ `row`, one after the other; of a diagonal block what is
    /// above the diagonal counts for nothing.
    pub fn block_mut(&mut self, row: usize, column: usize) -> impl Iterator<Item = &mut [f64]> {
        let (size, tile) = (self.size, self.tile());
        let from = self.index(row * size, column * size);
        let all = &mut self.panels[from..from + (size - 1) * tile + size];
        all.chunks_mut(tile).map(move |c| &mut c[..size])
    }

    /// The same values everywhere.
    pub fn fill(&mut self, x: f64) {
        self.panels.fill(x);
    }

    /// Adds `factor` times another of the same shape.
    pub fn add(&mut self, factor: f64, other: &Band) {
        assert_eq!(self.panels.len(), other.panels.len(), "bands of one shape");
        self.panels.iter_mut().zip(&other.panels).for_each(|(x, y)| *x += factor * y);
    }

    /// `xᵀ A x`.
    pub fn quadratic(&self, x: &[f64]) -> f64 {
        let mut sum = 0.0;
        for p in 0..self.blocks.div_ceil(self.together) {
            let (from, rows) = (p * self.tile(), self.rows(p));
            for j in self.before(p).start * self.tile()..from + rows {
                let at = self.index(from, j);
                let column = &self.panels[at..at + rows];
                let below = (j + 1).saturating_sub(from);
                sum += 2.0 * x[j] * dot(&column[below..], &x[from + below..from + rows]);
                if below > 0 {
                    sum += column[below - 1] * x[j] * x[j];
                }
            }
        }
        sum
    }

    /// Solves `A x = b` into `b`; leaves the factor in place of the matrix.
    ///
    /// # Errors
    /// The first row at which the matrix is found not to be positive definite.
    pub fn solve(&mut self, b: &mut [f64]) -> Result<(), usize> {
        self.factor()?;
        self.substitute(b);
        Ok(())
    }

    /// Panels whose tiles reach into panel `p`, before it.
    fn before(&self, p: usize) -> std::ops::Range<usize> {
        p.saturating_sub(self.reach / self.together)..p
    }

    /// Rows that panel `p` has.
    fn rows(&self, p: usize) -> usize {
        self.tile().min(self.len() - p * self.tile())
    }

    /// `A = L Lᵀ` in place.
    fn factor(&mut self) -> Result<(), usize> {
        let (tile, columns) = (self.tile(), self.columns());
        for p in 0..self.blocks.div_ceil(self.together) {
            let (rows, before) = (self.rows(p), self.before(p));
            let offset = |q: usize, first: isize| ((q * tile) as isize - first) as usize;
            let (first, begin) = (self.first(p), before.start);
            let (head, rest) = self.panels.split_at_mut(p * columns * tile);
            let panel = &mut rest[..columns * tile];
            for j in before {
                let other = &head[j * columns * tile..(j + 1) * columns * tile];
                let of_j = (j * tile) as isize - (columns - tile) as isize;
                let left = &other[offset(begin, of_j) * tile..];
                let (done, open) = panel.split_at_mut(offset(j, first) * tile);
                let done = &done[offset(begin, first) * tile..];
                take_product(&mut open[..tile * tile], done, left, (rows, tile, (j - begin) * tile), tile);
                let corner = &other[(columns - tile) * tile..];
                divide(&mut open[..tile * tile], corner, rows, tile);
            }
            let (done, corner) = panel.split_at_mut((columns - tile) * tile);
            let done = &done[offset(begin, first) * tile..];
            take_product(corner, done, done, (rows, rows, (p - begin) * tile), tile);
            root(corner, rows, tile).map_err(|row| p * tile + row)?;
        }
        Ok(())
    }

    /// `b ← L⁻ᵀ L⁻¹ b`.
    fn substitute(&self, b: &mut [f64]) {
        let (tile, columns) = (self.tile(), self.columns());
        let count = self.blocks.div_ceil(self.together);
        let panel = |p: usize| &self.panels[p * columns * tile..(p + 1) * columns * tile];
        let begin = |p: usize| self.before(p).start * tile;
        let column = |p: usize, j: usize| {
            let at = (j as isize - self.first(p)) as usize * tile;
            &panel(p)[at..at + self.rows(p)]
        };
        for p in 0..count {
            let (known, own) = b.split_at_mut(p * tile);
            let own = &mut own[..self.rows(p)];
            for (j, x) in known.iter().enumerate().skip(begin(p)) {
                own.iter_mut().zip(column(p, j)).for_each(|(y, l)| *y -= l * x);
            }
            for c in 0..own.len() {
                let l = column(p, p * tile + c);
                own[c] /= l[c];
                let x = own[c];
                own[c + 1..].iter_mut().zip(&l[c + 1..]).for_each(|(y, l)| *y -= l * x);
            }
        }
        for p in (0..count).rev() {
            let (open, own) = b.split_at_mut(p * tile);
            let own = &mut own[..self.rows(p)];
            for c in (0..own.len()).rev() {
                let l = column(p, p * tile + c);
                own[c] = (own[c] - dot(&l[c + 1..], &own[c + 1..])) / l[c];
            }
            for (j, x) in open.iter_mut().enumerate().skip(begin(p)) {
                *x -= dot(column(p, j), own);
            }
        }
    }
}

/// `to −= a bᵀ` of dense matrices stored by columns, `stride` apart: rows of a, rows of b, columns of both.
fn take_product(
    to: &mut [f64],
    a: &[f64],
    b: &[f64],
    (rows, columns, inner): (usize, usize, usize),
    stride: usize,
) {
    if rows == 0 || columns == 0 || inner == 0 {
        return;
    }
    let view = |x, r, c, by_row, by_column| {
        DMatrixView::from_slice_with_strides_generic(x, Dyn(r), Dyn(c), Dyn(by_row), Dyn(by_column))
    };
    let (a, b) = (view(a, rows, inner, 1, stride), view(b, inner, columns, stride, 1));
    let mut to =
        DMatrixViewMut::from_slice_with_strides_generic(to, Dyn(rows), Dyn(columns), Dyn(1), Dyn(stride));
    to.gemm(-1.0, &a, &b, 1.0);
}

/// `x ← x L⁻ᵀ` of a tile, whose corner L is.
fn divide(x: &mut [f64], corner: &[f64], rows: usize, tile: usize) {
    for from in (0..tile).step_by(STRIP) {
        let width = STRIP.min(tile - from);
        let (done, open) = x.split_at_mut(from * tile);
        take_product(open, done, &corner[from..], (rows, width, from), tile);
        for c in 0..width {
            let (done, open) = open.split_at_mut(c * tile);
            let own = &mut open[..rows];
            for (m, other) in done.chunks_exact(tile).enumerate() {
                let l = corner[(from + m) * tile + from + c];
                own.iter_mut().zip(other).for_each(|(y, x)| *y -= l * x);
            }
            let pivot = corner[(from + c) * tile + from + c];
            own.iter_mut().for_each(|y| *y /= pivot);
        }
    }
}

/// Cholesky factor of a corner, in place.
fn root(corner: &mut [f64], rows: usize, tile: usize) -> Result<(), usize> {
    for from in (0..rows).step_by(STRIP) {
        let width = STRIP.min(rows - from);
        let (done, open) = corner.split_at_mut(from * tile);
        let left = &done[from.min(done.len())..];
        take_product(&mut open[from..], left, left, (rows - from, width, from), tile);
        for c in 0..width {
            let i = from + c;
            let (done, open) = open.split_at_mut(c * tile);
            let own = &mut open[i..rows];
            for other in done.chunks_exact(tile) {
                let l = other[i];
                own.iter_mut().zip(&other[i..rows]).for_each(|(y, x)| *y -= l * x);
            }
            if !(own[0] > 0.0 && own[0].is_finite()) {
                return Err(i);
            }
            let pivot = own[0].sqrt();
            own.iter_mut().for_each(|y| *y /= pivot);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A·x recovered from b = A·x, where panels are one block, several, or more than the matrix has.
    #[test]
    fn solves_what_it_was_given() {
        for (blocks, size, reach) in
            [(60, 1, 7), (5, 1, 9), (1, 1, 0), (40, 1, 1), (23, 5, 16), (9, 40, 4), (7, 110, 2)]
        {
            let (n, mut a) = (blocks * size, Band::zeros(blocks, size, reach));
            let inside = |i: usize, j: usize| (i / size).abs_diff(j / size) <= reach;
            let entry = |i: usize, j: usize| {
                if i == j {
                    2.0 * (size * (reach + 1)) as f64
                } else {
                    ((7 * i + 3 * j) % 5) as f64 / 2.5 - 0.8
                }
            };
            for i in 0..n {
                for j in (0..=i).filter(|&j| inside(i, j)) {
                    *a.at(i, j) = entry(i, j);
                }
            }
            let x: Vec<f64> = (0..n).map(|i| (i as f64 * 0.7).sin()).collect();
            let value = |i: usize, j: usize| if inside(i, j) { entry(i.max(j), i.min(j)) } else { 0.0 };
            let mut b: Vec<f64> = (0..n).map(|i| (0..n).map(|j| value(i, j) * x[j]).sum()).collect();
            a.add(0.5, &a.clone());
            b.iter_mut().for_each(|b| *b *= 1.5);
            let square: f64 = x.iter().zip(&b).map(|(x, b)| x * b).sum();
            let error = (a.quadratic(&x) - square).abs() / square.max(1.0);
            assert!(error < 1e-12, "{blocks} {size} {reach}: {error}"); // 1e-15 seen
            a.solve(&mut b).unwrap();
            let worst = b.iter().zip(&x).map(|(p, q)| (p - q).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-11, "{blocks} {size} {reach}: {worst}"); // 1e-14 seen
        }
    }

    #[test]
    fn an_indefinite_row_is_named() {
        for row in [2, 40, 150] {
            let mut a = Band::zeros(200, 1, 1);
            (0..200).for_each(|i| *a.at(i, i) = 1.0);
            *a.at(row, row - 1) = 2.0;
            assert_eq!(a.solve(&mut [1.0; 200]), Err(row));
        }
    }
}
