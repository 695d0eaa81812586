//! Whittaker–Henderson smoothing with a penalty on third differences.
//!
//! In: sampled paths and a strength λ. Out: the paths z that minimise `Σ |y − z|² + λ Σ |Δ³z|²`, so
//! `(1 + λ D₃ᵀD₃) z = y`: seven diagonals, factored once as L·diag·Lᵀ for all paths. O(frames). Parabolas pass
//! unchanged. A sine of frequency f keeps `1/(1 + λ (2 sin(π f/rate))⁶)` of its amplitude, without delay.
//!
//! Whittaker, On a new method of graduation, 1923; Henderson 1924; Eilers, A perfect smoother, 2003.

/// Coefficients of the third difference.
const THIRD: [f64; 4] = [-1.0, 3.0, -3.0, 1.0];

/// λ whose response is one half at `cutoff_hz`.
pub fn lambda(cutoff_hz: f64, rate_hz: f64) -> f64 {
    (2.0 * (std::f64::consts::PI * cutoff_hz / rate_hz).sin()).powi(-6)
}

/// Share of the amplitude that passes at `hz`.
pub fn response(lambda: f64, hz: f64, rate_hz: f64) -> f64 {
    1.0 / (1.0 + lambda * (2.0 * (std::f64::consts::PI * hz / rate_hz).sin()).powi(6))
}

/// The factored smoother of one length and strength.
pub struct Whittaker {
    lambda: f64,
    /// Rows of L below the diagonal: L[k][j] multiplies k − 1 − j.
    lower: Vec<[f64; 3]>,
    diagonal: Vec<f64>,
}

impl Whittaker {
    /// For `frames` samples; fewer than four are not changed.
    pub fn new(frames: usize, lambda: f64) -> Self {
        let mut band = vec![[1.0, 0.0, 0.0, 0.0]; frames]; // band[k][j] = A[k][k − j]
        for at in 0..frames.saturating_sub(3) {
            for (i, a) in THIRD.iter().enumerate() {
                for (j, b) in THIRD[..=i].iter().enumerate() {
                    band[at + i][i - j] += lambda * a * b;
                }
            }
        }
        let (mut lower, mut diagonal) = (vec![[0.0; 3]; frames], vec![1.0; frames]);
        for k in 0..frames {
            let mut row = [0.0; 3];
            for j in (1..=3.min(k)).rev() {
                // A[k][k−j] = Σ L[k][i] d[i] L[k−j][i] over the columns i ≤ k−j
                let mut x = band[k][j];
                for i in j + 1..=3.min(k) {
                    x -= row[i - 1] * diagonal[k - i] * lower[k - j][i - j - 1];
                }
                row[j - 1] = x / diagonal[k - j];
            }
            let used: f64 = (1..=3.min(k)).map(|j| row[j - 1] * row[j - 1] * diagonal[k - j]).sum();
            diagonal[k] = band[k][0] - used;
            lower[k] = row;
        }
        Self { lambda, lower, diagonal }
    }

    /// What smoothing adds to paths `p` that lie `d` beside the data: the ε that minimises
    /// `Σ |d − ε|² + λ Σ |Δ³(p + ε)|²`.
    ///
    /// * `third`: third differences Δ³p, `(frames − 3) × columns`
    /// * `d`: data less path, `frames × columns`; replaced by ε
    ///
    /// `ε = A⁻¹ (d − λ D₃ᵀ Δ³p)`: a path without third differences is its own answer, to the bit.
    pub fn correct(&self, third: &[f64], d: &mut [f64], columns: usize) {
        for (at, row) in third.chunks_exact(columns).enumerate() {
            for (i, c) in THIRD.iter().enumerate() {
                let to = &mut d[(at + i) * columns..(at + i + 1) * columns];
                for (x, t) in to.iter_mut().zip(row) {
                    *x -= self.lambda * c * t;
                }
            }
        }
        self.solve(d, columns);
    }

    /// `A⁻¹ x` for every column, in place.
    fn solve(&self, x: &mut [f64], columns: usize) {
        let frames = self.diagonal.len();
        for k in 0..frames {
            let (done, rest) = x.split_at_mut(k * columns);
            for j in 1..=3.min(k) {
                let l = self.lower[k][j - 1];
                let from = &done[(k - j) * columns..(k - j + 1) * columns];
                for (a, b) in rest[..columns].iter_mut().zip(from) {
                    *a -= l * b;
                }
            }
        }
        for k in (0..frames).rev() {
            let (now, rest) = x[k * columns..].split_at_mut(columns);
            for a in now.iter_mut() {
                *a /= self.diagonal[k];
            }
            for j in 1..=3.min(frames - 1 - k) {
                let l = self.lower[k + j][j - 1];
                for (a, b) in now.iter_mut().zip(&rest[(j - 1) * columns..j * columns]) {
                    *a -= l * b;
                }
            }
        }
    }

    /// The smoothed paths, `frames × columns`.
    pub fn smooth(&self, y: &[f64], columns: usize) -> Vec<f64> {
        let mut correction = vec![0.0; y.len()];
        self.correct(&third_differences(y, columns), &mut correction, columns);
        correction.iter().zip(y).map(|(e, y)| y + e).collect()
    }
}

/// Δ³ of the columns of a table, `(frames − 3) × columns`.
pub fn third_differences(y: &[f64], columns: usize) -> Vec<f64> {
    let n = y.len().saturating_sub(3 * columns);
    (0..n)
        .map(|i| {
            let at = |k: usize| y[i + k * columns];
            (at(3) - at(0)) - 3.0 * (at(2) - at(1))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    /// Two roads to one number: the band solution against the dense normal equations.
    #[test]
    fn band_solution_is_the_dense_one() {
        for (n, lambda) in [(1, 3.0), (3, 3.0), (4, 3.0), (7, 0.2), (40, 1e4)] {
            let d = DMatrix::from_fn(usize::max(n, 3) - 3, n, |i, j| {
                if (i..i + 4).contains(&j) { THIRD[j - i] } else { 0.0 }
            });
            let a = DMatrix::identity(n, n) + d.transpose() * d * lambda;
            let y = DMatrix::from_fn(2, n, |c, k| ((c + 1) as f64 * k as f64 * 0.7).sin()); // columns = 2
            let z = Whittaker::new(n, lambda).smooth(y.as_slice(), 2);
            let dense = a.lu().solve(&y.transpose()).unwrap();
            for k in 0..n {
                for c in 0..2 {
                    let error = z[2 * k + c] - dense[(k, c)];
                    assert!(error.abs() < 1e-10, "{n} {lambda}: {error}"); // 3e-12 seen
                }
            }
        }
    }

    /// Half of the amplitude passes at the cut-off; the middle of a long sine shows it.
    #[test]
    fn half_passes_at_the_cutoff() {
        let (rate, hz, n) = (100.0, 5.0, 2000);
        let y: Vec<f64> = (0..n).map(|k| (std::f64::consts::TAU * hz * k as f64 / rate).sin()).collect();
        let z = Whittaker::new(n, lambda(hz, rate)).smooth(&y, 1);
        for k in 800..1200 {
            let error = z[k] - 0.5 * y[k];
            assert!(error.abs() < 1e-9, "{k}: {error}"); // 1e-12 seen
        }
        assert!((response(lambda(hz, rate), hz, rate) - 0.5).abs() < 1e-15);
    }
}
