//! Small dense kernels, row-major: what one evaluation of a likelihood spends its time in.
//!
//! At the sizes of key poses (N = 30 … 120) a general matrix product loses to loops that know what is
//! triangular and what symmetric. All sums run in one fixed order, so results do not depend on the machine's
//! vector width or on threads.
//!
//! (`motion::linear` solves the sparse normal equations of bodies by another factorisation, A = Lᵀ L, with sums in another
//! order; this crate uses no other, and neither could take the other's place without changing results.)

/// Sum of products, in eight running sums.
#[inline]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let (a, b) = (&a[..n], &b[..n]);
    let (ca, cb) = (a.chunks_exact(8), b.chunks_exact(8));
    let tail: f64 = ca.remainder().iter().zip(cb.remainder()).map(|(x, y)| x * y).sum();
    let mut s = [0.0; 8];
    for (x, y) in ca.zip(cb) {
        for l in 0..8 {
            s[l] += x[l] * y[l];
        }
    }
    ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7])) + tail
}

/// `y += a x`.
#[inline]
pub fn axpy(a: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// |a − b|², in eight running sums.
#[inline]
pub fn distance_squared(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let (a, b) = (&a[..n], &b[..n]);
    let (ca, cb) = (a.chunks_exact(8), b.chunks_exact(8));
    let tail: f64 = ca.remainder().iter().zip(cb.remainder()).map(|(x, y)| (x - y) * (x - y)).sum();
    let mut s = [0.0; 8];
    for (x, y) in ca.zip(cb) {
        for l in 0..8 {
            s[l] += (x[l] - y[l]) * (x[l] - y[l]);
        }
    }
    ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7])) + tail
}

/// Overwrites the lower triangle of the symmetric `a` (n × n) by L with L Lᵀ = a; the upper triangle is left.
/// `false` if a pivot is not positive.
pub fn cholesky(a: &mut [f64], n: usize) -> bool {
    cholesky_from(a, n, 0)
}

/// The same when the rows before `first` hold L already.
pub fn cholesky_from(a: &mut [f64], n: usize, first: usize) -> bool {
    for i in first..n {
        let (above, row) = a.split_at_mut(i * n);
        let row = &mut row[..n];
        for j in 0..i {
            let other = &above[j * n..j * n + j + 1];
            row[j] = (row[j] - dot(&row[..j], &other[..j])) / other[j];
        }
        let pivot = row[i] - dot(&row[..i], &row[..i]);
        // Written so that NaN fails too.
        if !(pivot > 0.0 && pivot.is_finite()) {
            return false;
        }
        row[i] = pivot.sqrt();
    }
    true
}

/// Writes L⁻¹ of the lower triangle of `l`; the upper triangle of `inverse` is zero.
pub fn invert_lower(l: &[f64], n: usize, inverse: &mut [f64]) {
    for i in 0..n {
        let (done, row) = inverse.split_at_mut(i * n);
        let row = &mut row[..n];
        row.fill(0.0);
        // Row i of L⁻¹ is −(Σ_{k<i} L_ik · row k)/L_ii, and 1/L_ii on the diagonal.
        for k in 0..i {
            axpy(-l[i * n + k], &done[k * n..k * n + k + 1], row);
        }
        let scale = 1.0 / l[i * n + i];
        row[..i].iter_mut().for_each(|v| *v *= scale);
        row[i] = scale;
    }
}

/// Writes LᵀL of the lower triangle of `l`, both triangles: K⁻¹ when `l` is L⁻¹.
pub fn gram_of_lower(l: &[f64], n: usize, out: &mut [f64]) {
    out[..n * n].fill(0.0);
    for k in 0..n {
        let row = &l[k * n..k * n + k + 1];
        for i in 0..=k {
            axpy(row[i], &row[..=i], &mut out[i * n..i * n + i + 1]);
        }
    }
    mirror(out, n);
}

/// Copies the lower triangle to the upper.
pub fn mirror(a: &mut [f64], n: usize) {
    for i in 1..n {
        for j in 0..i {
            a[j * n + i] = a[i * n + j];
        }
    }
}

/// Writes a x of `a` (rows × columns).
pub fn matvec(a: &[f64], x: &[f64], out: &mut [f64]) {
    for (o, row) in out.iter_mut().zip(a.chunks_exact(x.len())) {
        *o = dot(row, x);
    }
}

/// Writes aᵀ x of `a` (rows × columns).
pub fn matvec_transposed(a: &[f64], x: &[f64], out: &mut [f64]) {
    out.fill(0.0);
    for (v, row) in x.iter().zip(a.chunks_exact(out.len())) {
        axpy(*v, row, out);
    }
}
