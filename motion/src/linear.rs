//! Small dense linear algebra: the inner product, and symmetric positive definite systems by Cholesky factorisation.
//!
//! In: row-major matrices of which the lower triangle counts. Out: solutions, in place; no memory is kept.
//!
//! The normal equations of a body couple only degrees of freedom of which one carries the other. Factored from the last
//! unknown to the first, `A = Lᵀ L` with parents before their children, L has the zeros of A, and only what is
//! not zero is worked on (Featherstone, Rigid Body Dynamics Algorithms, 2008, §6.5).
//!
//! The crate `learn` has its own kernels (`learn::dense`): it uses no other crate, its matrices are full, it factors
//! `A = L Lᵀ` and goes on to inverses and products, and its sums are added up in another order.

/// Inner product of the common length, in eight sums side by side so that the processor can do several at once.
#[inline]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (mut p, mut q) = (a.chunks_exact(8), b.chunks_exact(8));
    for (x, y) in p.by_ref().zip(q.by_ref()) {
        for i in 0..8 {
            sums[i] += x[i] * y[i];
        }
    }
    let rest: f64 = p.remainder().iter().zip(q.remainder()).map(|(x, y)| x * y).sum();
    sums.iter().sum::<f64>() + rest
}

/// Factors `a = Lᵀ L` (`n × n`, lower triangle) in place and solves `a x = b` into `b`.
///
/// Returns whether `a` was positive definite; if not, `a` and `b` are left half worked on.
pub fn solve_cholesky(a: &mut [f64], n: usize, b: &mut [f64]) -> bool {
    // the entries of a row that are not zero: column and value
    let (mut at, mut values) = (Vec::with_capacity(n), Vec::with_capacity(n));
    for k in (0..n).rev() {
        let (head, tail) = a.split_at_mut(k * n);
        let pivot = tail[k];
        if !(pivot > 0.0 && pivot.is_finite()) {
            return false;
        }
        let pivot = pivot.sqrt();
        tail[k] = pivot;
        b[k] /= pivot;
        at.clear();
        values.clear();
        for (i, x) in tail[..k].iter_mut().enumerate().filter(|(_, x)| **x != 0.0) {
            *x /= pivot;
            at.push(i);
            values.push(*x);
        }
        for (p, &i) in at.iter().enumerate() {
            let x = values[p];
            b[i] -= x * b[k];
            let row = &mut head[i * n..=i * n + i];
            at[..=p].iter().zip(&values).for_each(|(&j, y)| row[j] -= x * y);
        }
    }
    for k in 0..n {
        b[k] = (b[k] - dot(&a[k * n..k * n + k], &b[..k])) / a[k * n + k];
    }
    true
}

#[cfg(test)]
mod tests {
    /// The solution is the x that the right-hand side was made of; an indefinite matrix is refused.
    #[test]
    fn solutions_solve_their_systems() {
        let n = 7;
        let m = |i: usize, j: usize| ((3 * i + 5 * j) % 7) as f64 - 3.0;
        let mut a = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                a[i * n + j] = (0..n).map(|k| m(k, i) * m(k, j)).sum::<f64>() + f64::from(u8::from(i == j));
            }
        }
        let x: Vec<f64> = (0..n).map(|i| i as f64 - 2.5).collect();
        let mut b: Vec<f64> = (0..n).map(|i| (0..n).map(|j| a[i * n + j] * x[j]).sum()).collect();
        assert!(super::solve_cholesky(&mut a, n, &mut b));
        for i in 0..n {
            assert!((b[i] - x[i]).abs() < 1e-10, "{b:?}"); // 1e-13 seen
        }
        assert!(!super::solve_cholesky(&mut [-1.0], 1, &mut [1.0]));
    }

    /// Two branches on one trunk: the entry that couples the branches stays zero.
    #[test]
    fn branches_do_not_fill_in() {
        let mut a = [4.0, 0.0, 0.0, 1.0, 3.0, 0.0, 2.0, 0.0, 5.0];
        let mut b = [9.0, 7.0, 17.0];
        assert!(super::solve_cholesky(&mut a, 3, &mut b));
        assert_eq!(a[7], 0.0);
        // [4 1 2; 1 3 0; 2 0 5] x = b at x = (1, 2, 3) asks for b = (12, 7, 17); here b₀ = 9
        let x = b;
        let back = [4.0 * x[0] + x[1] + 2.0 * x[2], x[0] + 3.0 * x[1], 2.0 * x[0] + 5.0 * x[2]];
        for (p, q) in back.iter().zip([9.0, 7.0, 17.0]) {
            assert!((p - q).abs() < 1e-12, "{back:?}");
        }
    }
}
