//! Small dense normal equations: Cholesky factorisation in place.
//!
//! Row-major, lower triangle used; nothing allocates.

/// Inner product, in eight sums side by side so that the processor can do several at once.
#[inline]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
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

/// Factors `a = L Lᵀ` (`n × n`, lower triangle) in place and solves `a x = b` into `b`.
///
/// Returns whether `a` was positive definite; otherwise `b` is left unusable.
pub(crate) fn solve(a: &mut [f64], n: usize, b: &mut [f64]) -> bool {
    for i in 0..n {
        for j in 0..=i {
            let (head, tail) = a.split_at(i * n);
            let row = &tail[..n];
            let other = if j < i { &head[j * n..j * n + n] } else { row };
            let x = row[j] - dot(&row[..j], &other[..j]);
            if i == j {
                if !(x > 0.0 && x.is_finite()) {
                    return false;
                }
                a[i * n + i] = x.sqrt();
            } else {
                a[i * n + j] = x / other[j];
            }
        }
    }
    for i in 0..n {
        b[i] = (b[i] - dot(&a[i * n..i * n + i], &b[..i])) / a[i * n + i];
    }
    for i in (0..n).rev() {
        b[i] /= a[i * n + i];
        let x = b[i];
        let (row, before) = (&a[i * n..i * n + i], &mut b[..i]);
        row.iter().zip(before).for_each(|(l, y)| *y -= l * x);
    }
    true
}

#[cfg(test)]
mod tests {
    #[test]
    fn solves_what_it_was_given() {
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
        assert!(super::solve(&mut a, n, &mut b));
        for i in 0..n {
            assert!((b[i] - x[i]).abs() < 1e-10, "{b:?}"); // 1e-13 seen
        }
        assert!(!super::solve(&mut [-1.0], 1, &mut [1.0]));
    }
}
