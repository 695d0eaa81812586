//! Factor: `H = M + dt D + dt² K = Lᵀ L` on the sparsity of the tree, and solutions of it.
//!
//! In: a pose, whose mass matrix is written where it is factored, diagonals of damping and stiffness, a time step. Out: L, lower triangular, packed by a [`Tree`]:
//! from the tips inward, so that no entry appears that the tree has not (Featherstone 2008, §6.5, Table 6.3). Joints are
//! eliminated whole: the rows of a ball change each row inboard of them in one pass.
//!
//! Nothing here allocates after construction. Units: those of the mass matrix.

use dynamics::{Model, State};

use super::tree::{FOUR, Tree};

/// L. See the module header.
#[derive(Clone, Debug)]
pub(super) struct Factor {
    /// Rows of L, packed; diagonals are replaced by their inverses in `inverse`.
    rows: Vec<f64>,
    /// 1/Lₖₖ.
    inverse: Vec<f64>,
}

impl Factor {
    pub fn new(tree: &Tree, n: usize) -> Self {
        Self { rows: vec![0.0; tree.entries()], inverse: vec![0.0; n] }
    }

    #[cfg(test)]
    pub fn spoil(&mut self) {
        self.rows.fill(f64::NAN);
        self.inverse.fill(f64::NAN);
    }

    /// Takes `M + diag(added)`, M of the pose in `state`.
    pub fn load(&mut self, tree: &Tree, (model, state): (&Model, &mut State), added: impl Fn(usize) -> f64) {
        state.mass_rows(model, (&tree.at, &tree.depth), &mut self.rows);
        for block in &tree.blocks {
            for own in 0..block.width {
                let (k, depth) = (block.first + own, block.depth + own);
                let end = (depth + 1).next_multiple_of(FOUR);
                let row = &mut self.rows[tree.at(k)..][..end];
                row[depth] += added(k);
                row[depth + 1..].fill(0.0);
            }
        }
    }

    /// Row k as it is: of M before [`factor`](Self::factor), of L after it.
    pub fn row(&self, tree: &Tree, k: usize) -> &[f64] {
        &self.rows[tree.at(k)..]
    }

    /// Factors what was loaded, blocks that begin at `from` or later.
    ///
    /// # Errors
    /// A degree of freedom whose pivot is not positive.
    pub fn factor(&mut self, tree: &Tree, from: usize) -> Result<(), usize> {
        for block in tree.blocks.iter().rev().take_while(|b| b.first >= from) {
            let at = tree.at(block.first);
            let (inner, own) = self.rows.split_at_mut(at);
            let depth = block.depth;
            let chain = tree.chain(block.first);
            let inverse = &mut self.inverse[block.first..block.first + block.width];
            match block.width {
                1 => {
                    let row = &mut own[..fours(depth + 1)];
                    inverse[0] = pivot(row[depth]).ok_or(block.first)?;
                    scale(&mut row[..depth], inverse[0]);
                    for (p, &k) in chain[..depth].iter().enumerate() {
                        let end = fours(p + 1);
                        let target = &mut inner[tree.at(k)..][..end];
                        subtract_fours(target, row[p], &row[..end]);
                    }
                }
                3 => {
                    let (r0, own) = own.split_at_mut(fours(depth + 1));
                    let (r1, own) = own.split_at_mut(fours(depth + 2));
                    let r2 = &mut own[..fours(depth + 3)];
                    // the joint's own 3 × 3, then the rows in one pass
                    let (a22, a21, a20) = (r2[depth + 2], r2[depth + 1], r2[depth]);
                    let i2 = pivot(a22).ok_or(block.first + 2)?;
                    let (x1, x0) = (a21 * i2, a20 * i2);
                    let (a11, a10) = (r1[depth + 1] - x1 * x1, r1[depth] - x1 * x0);
                    let i1 = pivot(a11).ok_or(block.first + 1)?;
                    let y0 = a10 * i1;
                    let i0 = pivot(r0[depth] - (y0 * y0 + x0 * x0)).ok_or(block.first)?;
                    inverse.copy_from_slice(&[i0, i1, i2]);
                    let [a, b, c] = [&mut *r0, &mut *r1, &mut *r2].map(|r| r.as_chunks_mut::<FOUR>().0);
                    for ((a, b), c) in a.iter_mut().zip(b).zip(c).take(depth.div_ceil(FOUR)) {
                        let z = c.map(|c| c * i2);
                        let y: [f64; FOUR] = std::array::from_fn(|k| (b[k] - x1 * z[k]) * i1);
                        *a = std::array::from_fn(|k| (a[k] - (y0 * y[k] + x0 * z[k])) * i0);
                        (*b, *c) = (y, z);
                    }
                    // fours at the end of a pass reach into what the joint has of its own
                    r1[depth] = y0;
                    (r2[depth], r2[depth + 1]) = (x0, x1);
                    // two rows inboard at a time, which are as long as each other in fours: they read the same three rows
                    let (pairs, last) = chain[..depth].as_chunks::<2>();
                    for (i, &[k, l]) in pairs.iter().enumerate() {
                        let p = 2 * i;
                        let end = fours(p + 1);
                        let (lower, upper) = inner.split_at_mut(tree.at(l));
                        let targets = [&mut lower[tree.at(k)..][..end], &mut upper[..end]];
                        let by = [[r0[p], r1[p], r2[p]], [r0[p + 1], r1[p + 1], r2[p + 1]]];
                        subtract_three(targets, by, [&r0[..end], &r1[..end], &r2[..end]]);
                    }
                    if let Some(&k) = last.first() {
                        let (p, end) = (depth - 1, fours(depth));
                        let target = &mut inner[tree.at(k)..][..end];
                        subtract_fours(target, r0[p], &r0[..end]);
                        subtract_fours(target, r1[p], &r1[..end]);
                        subtract_fours(target, r2[p], &r2[..end]);
                    }
                }
                width => {
                    for j in (0..width).rev() {
                        let (before, rest) = own.split_at_mut(tree.at(block.first + j) - at);
                        let row = &mut rest[..depth + j + 1];
                        inverse[j] = pivot(row[depth + j]).ok_or(block.first + j)?;
                        scale(&mut row[..depth + j], inverse[j]);
                        for i in 0..j {
                            let target = &mut before[tree.at(block.first + i) - at..][..depth + i + 1];
                            subtract(target, row[depth + i], &row[..depth + i + 1]);
                        }
                        for p in 0..depth {
                            subtract(&mut inner[tree.at(chain[p])..][..p + 1], row[p], &row[..p + 1]);
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// `x ← L⁻ᵀ x`, degrees of freedom from `from` on.
    pub fn solve_inward(&self, tree: &Tree, x: &mut [f64], from: usize) {
        for block in tree.blocks.iter().rev().take_while(|b| b.first >= from) {
            let (first, depth) = (block.first, block.depth);
            let row = |j: usize| &self.rows[tree.at(first + j)..][..depth + j];
            for j in (0..block.width).rev() {
                let k = first + j;
                let y = x[k] * self.inverse[k];
                x[k] = y;
                subtract(&mut x[first..k], y, &row(j)[depth..]);
            }
            if block.width == 3 {
                let (r0, r1, r2) = (row(0), row(1), row(2));
                let [y0, y1, y2] = [x[first], x[first + 1], x[first + 2]];
                for run in tree.runs(block) {
                    let at = run.position..run.position + run.len;
                    let rows = r0[at.clone()].iter().zip(&r1[at.clone()]).zip(&r2[at]);
                    for (t, ((a, b), c)) in x[run.dof..run.dof + run.len].iter_mut().zip(rows) {
                        *t -= y0 * a + y1 * b + y2 * c;
                    }
                }
            } else {
                for j in 0..block.width {
                    for run in tree.runs(block) {
                        let y = x[first + j];
                        let at = run.position..run.position + run.len;
                        subtract(&mut x[run.dof..run.dof + run.len], y, &row(j)[at]);
                    }
                }
            }
        }
    }

    /// `x ← L⁻¹ x`, degrees of freedom from `from` on; those before are taken as solved already.
    pub fn solve_outward(&self, tree: &Tree, x: &mut [f64], from: usize) {
        for block in tree.blocks.iter().filter(|b| b.first >= from) {
            let (first, depth) = (block.first, block.depth);
            let row = |j: usize| &self.rows[tree.at(first + j)..][..depth + j];
            if block.width == 3 {
                let (r0, r1, r2) = (row(0), row(1), row(2));
                let mut sums = [[0.0; 2]; 3];
                for run in tree.runs(block) {
                    let at = run.position..run.position + run.len;
                    let (a, b, c) = (&r0[at.clone()], &r1[at.clone()], &r2[at]);
                    dots(&x[run.dof..run.dof + run.len], [a, b, c], &mut sums);
                }
                let [s0, s1, s2] = sums.map(|[even, odd]| even + odd);
                let [i0, i1, i2] = [self.inverse[first], self.inverse[first + 1], self.inverse[first + 2]];
                let x0 = (x[first] - s0) * i0;
                let x1 = (x[first + 1] - s1 - r1[depth] * x0) * i1;
                let x2 = (x[first + 2] - s2 - r2[depth] * x0 - r2[depth + 1] * x1) * i2;
                x[first..first + 3].copy_from_slice(&[x0, x1, x2]);
                continue;
            }
            for j in 0..block.width {
                let k = first + j;
                let row = row(j);
                let mut sum = x[k];
                for run in tree.runs(block) {
                    sum -= dot(&x[run.dof..run.dof + run.len], &row[run.position..run.position + run.len]);
                }
                sum -= dot(&x[first..k], &row[depth..]);
                x[k] = sum * self.inverse[k];
            }
        }
    }

    /// `y ← L⁻ᵀ y` for six columns given along the chain of one body, positions from `from` on; those before become zero.
    pub fn solve_chain(&self, tree: &Tree, chain: &[usize], y: &mut [[f64; 6]], from: usize) {
        for p in (from..chain.len()).rev() {
            let k = chain[p];
            let row = &self.rows[tree.at(k)..][..p];
            let (inner, own) = y.split_at_mut(p);
            let own = &mut own[0];
            for x in own.iter_mut() {
                *x *= self.inverse[k];
            }
            for (target, r) in inner[from..].iter_mut().zip(&row[from..]) {
                for (t, x) in target.iter_mut().zip(own.iter()) {
                    *t -= r * x;
                }
            }
        }
        y[..from.min(chain.len())].fill([0.0; 6]);
    }
    /// The part of [`solve_chain`](Self::solve_chain) that a second branch has of its own: six columns along the end `rest` of a chain
    /// whose beginning is that of `shared`, which it changes.
    pub fn solve_branch(
        &self,
        tree: &Tree,
        chain: &[usize],
        shared: &mut [[f64; 6]],
        rest: &mut [[f64; 6]],
        from: usize,
    ) {
        let begin = chain.len() - rest.len();
        for p in (begin.max(from)..chain.len()).rev() {
            let k = chain[p];
            let row = &self.rows[tree.at(k)..][..p];
            let (inner, own) = rest.split_at_mut(p - begin);
            let own = &mut own[0];
            for x in own.iter_mut() {
                *x *= self.inverse[k];
            }
            let targets =
                shared[..begin].iter_mut().zip(row).skip(from).chain(inner.iter_mut().zip(&row[begin..]));
            for (target, r) in targets {
                for (t, x) in target.iter_mut().zip(own.iter()) {
                    *t -= r * x;
                }
            }
        }
    }
}

#[inline(always)]
fn pivot(x: f64) -> Option<f64> {
    (x > 0.0 && x.is_finite()).then(|| 1.0 / x.sqrt())
}

#[inline(always)]
fn scale(row: &mut [f64], by: f64) {
    for x in row {
        *x *= by;
    }
}

#[inline(always)]
fn subtract(target: &mut [f64], x: f64, row: &[f64]) {
    for (t, a) in target.iter_mut().zip(row) {
        *t -= x * a;
    }
}

/// The length of a row of `len` entries.
#[inline(always)]
fn fours(len: usize) -> usize {
    len.next_multiple_of(FOUR)
}

/// [`subtract`] by whole fours.
#[inline(always)]
fn subtract_fours(target: &mut [f64], x: f64, row: &[f64]) {
    let (target, row) = (target.as_chunks_mut::<FOUR>().0, row.as_chunks::<FOUR>().0);
    for (t, a) in target.iter_mut().zip(row) {
        *t = std::array::from_fn(|k| t[k] - x * a[k]);
    }
}

/// Three rows from two at once.
#[inline(always)]
fn subtract_three(targets: [&mut [f64]; 2], [f, g]: [[f64; 3]; 2], rows: [&[f64]; 3]) {
    let [a, b, c] = rows.map(|row| row.as_chunks::<FOUR>().0);
    let [s, t] = targets.map(|row| row.as_chunks_mut::<FOUR>().0);
    for ((s, t), ((a, b), c)) in s.iter_mut().zip(t).zip(a.iter().zip(b).zip(c)) {
        *s = std::array::from_fn(|k| s[k] - (f[0] * a[k] + f[1] * b[k] + f[2] * c[k]));
        *t = std::array::from_fn(|k| t[k] - (g[0] * a[k] + g[1] * b[k] + g[2] * c[k]));
    }
}

/// Adds `x · row` of three rows to sums over even and odd entries.
#[inline(always)]
fn dots(x: &[f64], rows: [&[f64]; 3], sums: &mut [[f64; 2]; 3]) {
    let (pairs, last) = x.as_chunks::<2>();
    let [a, b, c] = rows.map(|row| row.as_chunks::<2>().0);
    for (x, ((a, b), c)) in pairs.iter().zip(a.iter().zip(b).zip(c)) {
        for k in 0..2 {
            sums[0][k] += x[k] * a[k];
            sums[1][k] += x[k] * b[k];
            sums[2][k] += x[k] * c[k];
        }
    }
    if let Some(x) = last.first() {
        for (sum, row) in sums.iter_mut().zip(rows) {
            sum[0] += x * row[row.len() - 1];
        }
    }
}

#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    // two sums that do not wait for each other
    let (pa, pb) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = pa.remainder().iter().zip(pb.remainder()).map(|(a, b)| a * b).sum();
    let (mut even, mut odd) = (0.0, 0.0);
    for (a, b) in pa.zip(pb) {
        even += a[0] * b[0] + a[2] * b[2];
        odd += a[1] * b[1] + a[3] * b[3];
    }
    even + odd + rest
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use bodies::anthropometry::human::human;
    use dynamics::{Model, State};
    use motion::Vec3;
    use nalgebra::{DMatrix, DVector};

    use super::*;

    /// Solutions of the sparse factor are those of a dense Cholesky factor, with and without the root.
    #[test]
    fn the_sparse_factor_solves_as_a_dense_one() {
        let c = Arc::new(human().0);
        let model = Model::new(&c, Vec3::new(0.0, -9.81, 0.0));
        let (n, tree) = (model.nv(), Tree::new(&model));
        let mut q = c.rest.clone();
        let turn: Vec<f64> = (0..n).map(|i| 0.3 * (i as f64 * 1.7).sin()).collect();
        c.skeleton.integrate(&mut q, &turn, 1.0);
        let mut state = State::new(&model);
        state.update(&model, &q, &turn);
        let mut m = DMatrix::zeros(n, n);
        state.mass_matrix(&model, &mut m);
        let added = |k: usize| if k < 6 { 0.0 } else { 0.01 * k as f64 };
        let mut dense = m.clone();
        for k in 0..n {
            dense[(k, k)] += added(k);
        }
        let right = DVector::from_fn(n, |i, _| (i as f64 * 0.9).cos());
        for from in [0, 6] {
            let mut factor = Factor::new(&tree, n);
            factor.load(&tree, (&model, &mut state), added);
            factor.factor(&tree, from).unwrap();
            let mut x = right.as_slice().to_vec();
            factor.solve_inward(&tree, &mut x, from);
            x[..from].fill(0.0);
            factor.solve_outward(&tree, &mut x, from);
            let part = dense.view((from, from), (n - from, n - from)).into_owned();
            let expected = part.cholesky().unwrap().solve(&right.rows(from, n - from).into_owned());
            for k in from..n {
                let error = x[k] - expected[k - from];
                assert!(error.abs() < 1e-9 * (1.0 + expected[k - from].abs()), "{from} {k}: {error}"); // 1e-12 seen
            }
        }
    }

    /// A degree of freedom that moves nothing is named.
    #[test]
    fn a_pivot_that_is_not_positive_is_named() {
        let c = human().0;
        let model = Model::new(&c, Vec3::zeros());
        let (n, tree) = (model.nv(), Tree::new(&model));
        let mut factor = Factor::new(&tree, n);
        factor.load(&tree, (&model, &mut State::new(&model)), |k| if k == 7 { -1e3 } else { 0.0 });
        assert_eq!(factor.factor(&tree, 0), Err(7));
    }
}
