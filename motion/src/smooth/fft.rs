//! The discrete Fourier transform of a power-of-two length.
//!
//! In and out: complex numbers as `[re, im]`, in place. Radix two, decimation in time (Cooley, Tukey 1965).

/// Twiddle factors of one length.
pub struct Fft {
    turns: Vec<[f64; 2]>,
}

impl Fft {
    /// For `n` numbers, a power of two.
    pub fn new(n: usize) -> Self {
        debug_assert!(n.is_power_of_two());
        let turn = |k: usize| {
            let (s, c) = (-std::f64::consts::TAU * k as f64 / n as f64).sin_cos();
            [c, s]
        };
        Self { turns: (0..n / 2).map(turn).collect() }
    }

    /// `X_k = Σ_j x_j exp(−2πi jk/n)`, in place.
    pub fn forward(&self, x: &mut [[f64; 2]]) {
        let n = x.len();
        if n < 2 {
            return;
        }
        let shift = usize::BITS - n.trailing_zeros();
        for i in 0..n {
            let j = i.reverse_bits() >> shift;
            if i < j {
                x.swap(i, j);
            }
        }
        let mut half = 1;
        while half < n {
            let stride = n / (2 * half);
            for block in x.chunks_exact_mut(2 * half) {
                let (low, high) = block.split_at_mut(half);
                for (k, (a, b)) in low.iter_mut().zip(high).enumerate() {
                    let [c, s] = self.turns[k * stride];
                    let t = [b[0] * c - b[1] * s, b[0] * s + b[1] * c];
                    *b = [a[0] - t[0], a[1] - t[1]];
                    *a = [a[0] + t[0], a[1] + t[1]];
                }
            }
            half *= 2;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the sum that defines it.
    #[test]
    fn transform_is_its_definition() {
        for n in [1usize, 2, 8, 64] {
            let x: Vec<[f64; 2]> =
                (0..n).map(|i| [(i as f64 * 1.7).sin(), (i as f64 * 0.3).cos() - 0.2]).collect();
            let mut y = x.clone();
            Fft::new(n).forward(&mut y);
            for (k, yk) in y.iter().enumerate() {
                let mut sum = [0.0, 0.0];
                for (j, xj) in x.iter().enumerate() {
                    let (s, c) = (-std::f64::consts::TAU * (j * k) as f64 / n as f64).sin_cos();
                    sum[0] += xj[0] * c - xj[1] * s;
                    sum[1] += xj[0] * s + xj[1] * c;
                }
                let error = (sum[0] - yk[0]).hypot(sum[1] - yk[1]);
                assert!(error < 1e-12, "{n} {k}: {error}"); // 5e-14 seen
            }
        }
    }
}
