//! Factor: `H = M + dt D + dt² K = Lᵀ L` on the sparsity of the tree, and solutions of it.
//!
//! In: a mass matrix (`nv × nv`), diagonals of damping and stiffness, a time step. Out: L, lower triangular, packed by a [`Tree`]:
//! from the tips inward, so that no entry appears that the tree has not (Featherstone 2008, §6.5, Table 6.3). Joints are
//! eliminated whole: the rows of a ball change each row inboard of them in one pass.
//!
//! Nothing here allocates after construction. Units: those of the mass matrix.

use nalgebra::DMatrix;

use super::tree::Tree;

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

    /// Takes `m + diag(added)`.
    pub fn load(&mut self, tree: &Tree, m: &DMatrix<f64>, added: impl Fn(usize) -> f64) {
        let n = m.nrows();
        let m = m.as_slice();
        for block in &tree.blocks {
            let depth = block.depth;
            for k in block.first..block.first + block.width {
                let column = &m[k * n..(k + 1) * n];
                let own = k - block.first;
                let row = &mut self.rows[tree.at(k)..][..depth + own + 1];
                for run in tree.runs(block) {
                    row[run.position..run.position + run.len]
                        .copy_from_slice(&column[run.dof..run.dof + run.len]);
                }
                row[depth..].copy_from_slice(&column[block.first..=k]);
                row[depth + own] += added(k);
            }
        }
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
                    let row = &mut own[..depth + 1];
                    inverse[0] = pivot(row[depth]).ok_or(block.first)?;
                    scale(&mut row[..depth], inverse[0]);
                    for p in 0..depth {
                        let x = row[p];
                        let target = &mut inner[tree.at(chain[p])..][..p + 1];
                        for (t, a) in target.iter_mut().zip(&row[..p + 1]) {
                            *t -= x * a;
                        }
                    }
                }
                3 => {
                    let (r0, own) = own.split_at_mut(depth + 1);
                    let (r1, own) = own.split_at_mut(depth + 2);
                    let r2 = &mut own[..depth + 3];
                    inverse[2] = pivot(r2[depth + 2]).ok_or(block.first + 2)?;
                    scale(&mut r2[..depth + 2], inverse[2]);
                    let (x1, x0) = (r2[depth + 1], r2[depth]);
                    subtract(&mut r1[..depth + 2], x1, &r2[..depth + 2]);
                    inverse[1] = pivot(r1[depth + 1]).ok_or(block.first + 1)?;
                    scale(&mut r1[..depth + 1], inverse[1]);
                    let y0 = r1[depth];
                    for ((t, a), b) in r0[..depth + 1].iter_mut().zip(&r1[..depth + 1]).zip(&r2[..depth + 1])
                    {
                        *t -= y0 * a + x0 * b;
                    }
                    inverse[0] = pivot(r0[depth]).ok_or(block.first)?;
                    scale(&mut r0[..depth], inverse[0]);
                    // two rows inboard at a time: they read the same three rows
                    let mut p = 0;
                    while p + 1 < depth {
                        let (lower, upper) = inner.split_at_mut(tree.at(chain[p + 1]));
                        let upper = &mut upper[..p + 2];
                        let lower = &mut lower[tree.at(chain[p])..][..p + 1];
                        let (x, y, z) = (r0[p], r1[p], r2[p]);
                        let (s, t, u) = (r0[p + 1], r1[p + 1], r2[p + 1]);
                        let rows = r0[..p + 1].iter().zip(&r1[..p + 1]).zip(&r2[..p + 1]);
                        for ((l, m), ((a, b), c)) in lower.iter_mut().zip(upper.iter_mut()).zip(rows) {
                            *l -= x * a + y * b + z * c;
                            *m -= s * a + t * b + u * c;
                        }
                        upper[p + 1] -= s * s + t * t + u * u;
                        p += 2;
                    }
                    if p < depth {
                        let (x, y, z) = (r0[p], r1[p], r2[p]);
                        let target = &mut inner[tree.at(chain[p])..][..p + 1];
                        let rows = r0[..p + 1].iter().zip(&r1[..p + 1]).zip(&r2[..p + 1]);
                        for (t, ((a, b), c)) in target.iter_mut().zip(rows) {
                            *t -= x * a + y * b + z * c;
                        }
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
            for j in (0..block.width).rev() {
                let k = first + j;
                let row = &self.rows[tree.at(k)..][..depth + j];
                let y = x[k] * self.inverse[k];
                x[k] = y;
                subtract(&mut x[first..k], y, &row[depth..]);
                for run in tree.runs(block) {
                    subtract(
                        &mut x[run.dof..run.dof + run.len],
                        y,
                        &row[run.position..run.position + run.len],
                    );
                }
            }
        }
    }

    /// `x ← L⁻¹ x`, degrees of freedom from `from` on; those before are taken as solved already.
    pub fn solve_outward(&self, tree: &Tree, x: &mut [f64], from: usize) {
        for block in tree.blocks.iter().filter(|b| b.first >= from) {
            let (first, depth) = (block.first, block.depth);
            for j in 0..block.width {
                let k = first + j;
                let row = &self.rows[tree.at(k)..][..depth + j];
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
            factor.load(&tree, &m, added);
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
        factor.load(&tree, &DMatrix::identity(n, n), |k| if k == 7 { -1.0 } else { 0.0 });
        assert_eq!(factor.factor(&tree, 0), Err(7));
    }
}
