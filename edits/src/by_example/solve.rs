//! The blend of all predictions: the sequence of differences that agrees best with them (IAF09, 12).
//!
//! In: predictions of a configuration model (differences `μ` with variances `σ²`) and of an acceleration model (their second
//! derivatives `μ_a`, `σ_a²`) for every frame, and the four weights. Out: the differences `D`, one column for each coordinate, that minimise
//!
//! ```text
//! Σ  w_lk |D − μ|²/σ² + w_rk |D|² σ²/σ_f⁴ + w_la |L D − μ_a|²/σ_a² + w_ra |L D|² σ_a²/σ_fa⁴
//! ```
//!
//! `L` is the second difference, `(D₋ − 2 D + D₊)/h²`, of every frame but the first and the last. D is the difference to the source, so that
//! both source terms have target zero. All coordinates share the variances, so one pentadiagonal matrix, factored
//! once (`A = U D Uᵀ` by columns, without pivots: it is positive definite), serves every coordinate: O(frames).
//!
//! Units: `h` s; D in the units of the outputs; weights without unit.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// What the terms of accelerations count if nothing else is said. Errors of neighbouring frames are alike, and twice integrated they grow with the square of
/// the time: an acceleration that is a little wrong through a whole transition (mostly: zero, and sure of it) would blur it. At this weight they
/// hold back what trembles, and leave transitions alone.
pub const ACCELERATION: f64 = 0.001;

/// How much each of the four terms counts (IAF09 §4.3). See the guide in `docs/BY_EXAMPLE.md`: which to turn when.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Weights {
    /// w_lk: learned configuration.
    pub configuration: f64,
    /// w_rk: the source's configuration, where the model is unsure.
    pub source: f64,
    /// w_la: learned acceleration.
    pub acceleration: f64,
    /// w_ra: the source's acceleration, where the model is unsure.
    pub source_acceleration: f64,
}

impl Default for Weights {
    fn default() -> Self {
        Self {
            configuration: 1.0,
            source: 1.0,
            acceleration: ACCELERATION,
            source_acceleration: ACCELERATION,
        }
    }
}

/// Least variance over σ_f²; Gaussian processes are never as sure (10⁻¹⁰).
pub const SUREST: f64 = 1e-12;

/// What one model says of every frame, for the blend.
#[derive(Clone, Debug, PartialEq)]
pub struct Evidence {
    /// Means: frames × coordinates.
    pub mean: DMatrix<f64>,
    /// Weight of the mean of each frame: `w_l/σ²`.
    pub learned: Vec<f64>,
    /// Weight of zero, the source: `w_r σ²/σ_f⁴`.
    pub source: Vec<f64>,
}

impl Evidence {
    /// The weights of a frame from its variance and the model's prior variance `signal` = σ_f². A variance counts as at least [`SUREST`] of that: examples that a
    /// model fits without a remainder have none.
    pub fn new(mean: DMatrix<f64>, variance: &[f64], signal: f64, learned: f64, source: f64) -> Self {
        Self {
            mean,
            learned: variance.iter().map(|v| learned / v.max(SUREST * signal)).collect(),
            source: variance.iter().map(|v| source * v / (signal * signal)).collect(),
        }
    }
}

/// The quadratic form of the blend, `A` of one coordinate: what a departure C from the blended answer costs is `Cᵀ A C`.
#[derive(Clone, Debug, PartialEq)]
pub struct Form {
    /// Weight of D of each frame: both terms of configurations.
    pub configuration: Vec<f64>,
    /// Weight of L D of each frame: both terms of accelerations. Those of the first and the last frame do not count.
    pub acceleration: Vec<f64>,
    /// Time between frames, s.
    pub step_s: f64,
    /// How much more coordinates of the root weigh where contacts are kept; the blend itself does not know it.
    pub root: f64,
}

impl Form {
    /// Of the two evidences of a [`blend`], all coordinates alike.
    pub fn of(configuration: &Evidence, acceleration: &Evidence, step_s: f64) -> Self {
        let all = |e: &Evidence| e.learned.iter().zip(&e.source).map(|(l, s)| l + s).collect();
        Self { configuration: all(configuration), acceleration: all(acceleration), step_s, root: 1.0 }
    }

    /// The same with the terms of accelerations as much larger as [`ACCELERATION`] makes them smaller: a correction that nothing was learned of has to come and go
    /// smoothly.
    pub fn firm(mut self) -> Self {
        self.acceleration.iter_mut().for_each(|w| *w /= ACCELERATION);
        self
    }

    /// As a matrix.
    pub fn band(&self) -> Band {
        let frames = self.configuration.len();
        let mut band = Band::zeros(frames);
        band.main.copy_from_slice(&self.configuration);
        self.bend(&mut band);
        band
    }

    /// Adds the terms of accelerations.
    pub(super) fn bend(&self, band: &mut Band) {
        let row = self.second_difference();
        for f in 1..band.main.len().saturating_sub(1) {
            let all = self.acceleration[f];
            for (i, a) in row.iter().enumerate() {
                band.main[f - 1 + i] += all * a * a;
            }
            band.first[f - 1] += all * row[0] * row[1];
            band.first[f] += all * row[1] * row[2];
            band.second[f - 1] += all * row[0] * row[2];
        }
    }

    /// A row of L.
    fn second_difference(&self) -> [f64; 3] {
        let h2 = self.step_s * self.step_s;
        [1.0 / h2, -2.0 / h2, 1.0 / h2]
    }
}

/// Blends the predictions; `step_s` is the time between frames. See the module header.
///
/// # Panics
/// If the two evidences do not have the same frames and coordinates.
pub fn blend(configuration: &Evidence, acceleration: &Evidence, step_s: f64) -> DMatrix<f64> {
    let (frames, width) = configuration.mean.shape();
    assert_eq!(acceleration.mean.shape(), (frames, width), "frames × coordinates of the two models");
    let form = Form::of(configuration, acceleration, step_s);
    let mut band = form.band();
    let mut out = configuration.mean.clone();
    band.factor();
    let h2 = step_s * step_s;
    let inner: Vec<f64> = acceleration.learned.iter().map(|w| w / h2).collect();
    for (mut column, bends) in out.column_iter_mut().zip(acceleration.mean.column_iter()) {
        let (column, bends) = (column.as_mut_slice(), bends.as_slice());
        column.iter_mut().zip(&configuration.learned).for_each(|(x, w)| *x *= w);
        // Lᵀ W μ_a
        for f in 1..frames.saturating_sub(1) {
            let pull = inner[f] * bends[f];
            column[f - 1] += pull;
            column[f] -= 2.0 * pull;
            column[f + 1] += pull;
        }
        band.solve(column);
    }
    out
}

/// A symmetric pentadiagonal matrix, and its factors.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// Diagonal; after [`Band::factor`] the pivots.
    pub main: Vec<f64>,
    /// Entries `(i, i + 1)`; after factoring those of the unit lower factor.
    pub first: Vec<f64>,
    /// Entries `(i, i + 2)`.
    pub second: Vec<f64>,
}

impl Band {
    /// A matrix of zeros, `n × n`.
    pub fn zeros(n: usize) -> Self {
        Self { main: vec![0.0; n], first: vec![0.0; n], second: vec![0.0; n] }
    }

    /// Factors `A = L D Lᵀ` in place. A must be positive definite.
    pub fn factor(&mut self) {
        let n = self.main.len();
        for i in 0..n {
            // L(i, i−2) and L(i, i−1), stored where the upper entries were
            if i >= 2 {
                self.second[i - 2] /= self.main[i - 2];
            }
            if i >= 1 {
                let below =
                    if i >= 2 { self.second[i - 2] * self.first[i - 2] * self.main[i - 2] } else { 0.0 };
                self.first[i - 1] = (self.first[i - 1] - below) / self.main[i - 1];
            }
            let mut pivot = self.main[i];
            if i >= 1 {
                pivot -= self.first[i - 1].powi(2) * self.main[i - 1];
            }
            if i >= 2 {
                pivot -= self.second[i - 2].powi(2) * self.main[i - 2];
            }
            self.main[i] = pivot;
        }
    }

    /// Row `i` of `A x`, before [`Band::factor`]; `x` may be one of several interleaved vectors.
    pub fn times(&self, i: usize, x: impl Fn(usize) -> f64) -> f64 {
        let n = self.main.len();
        let mut sum = self.main[i] * x(i);
        for (off, apart) in [(&self.first, 1), (&self.second, 2)] {
            if i >= apart {
                sum += off[i - apart] * x(i - apart);
            }
            if i + apart < n {
                sum += off[i] * x(i + apart);
            }
        }
        sum
    }

    /// Solves `A x = b` into `b`, after [`Band::factor`].
    pub fn solve(&self, b: &mut [f64]) {
        let n = self.main.len();
        for i in 1..n {
            let two = if i >= 2 { self.second[i - 2] * b[i - 2] } else { 0.0 };
            b[i] -= self.first[i - 1] * b[i - 1] + two;
        }
        for (x, pivot) in b.iter_mut().zip(&self.main) {
            *x /= pivot;
        }
        for i in (0..n.saturating_sub(1)).rev() {
            let two = if i + 2 < n { self.second[i] * b[i + 2] } else { 0.0 };
            b[i] -= self.first[i] * b[i + 1] + two;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn evidence(frames: usize, width: usize, seed: f64) -> Evidence {
        let mean = DMatrix::from_fn(frames, width, |f, c| (seed + 0.7 * f as f64 + c as f64).sin());
        let variance: Vec<f64> = (0..frames).map(|f| 0.2 + (0.3 * f as f64 + seed).sin().powi(2)).collect();
        Evidence::new(mean, &variance, 1.3, 1.0, 0.7)
    }

    /// The banded solve is the minimum of the sum that the header writes down, found with a full matrix.
    #[test]
    fn the_blend_is_the_minimum() {
        for frames in [1, 2, 3, 4, 40] {
            let (k, mut a) = (evidence(frames, 3, 0.1), evidence(frames, 3, 2.0));
            a.mean *= 50.0;
            let h = 1.0 / 30.0;
            let x = blend(&k, &a, h);
            let mut l = DMatrix::zeros(frames, frames);
            for f in 1..frames.saturating_sub(1) {
                for (i, v) in [1.0, -2.0, 1.0].iter().enumerate() {
                    l[(f, f - 1 + i)] = v / (h * h);
                }
            }
            let inner = |v: &Vec<f64>| {
                DMatrix::from_diagonal(&nalgebra::DVector::from_fn(frames, |i, _| {
                    if i == 0 || i + 1 >= frames { 0.0 } else { v[i] }
                }))
            };
            let diagonal = |v: &Vec<f64>| DMatrix::from_diagonal(&nalgebra::DVector::from_vec(v.clone()));
            let matrix = diagonal(&k.learned)
                + diagonal(&k.source)
                + l.transpose() * (inner(&a.learned) + inner(&a.source)) * &l;
            let right = diagonal(&k.learned) * &k.mean + l.transpose() * inner(&a.learned) * &a.mean;
            let full = matrix.cholesky().unwrap().solve(&right);
            assert!((&x - &full).amax() < 1e-8 * full.amax(), "{frames}"); // 2e-11 seen
        }
    }

    /// Sure predictions are kept, unsure ones give way to the source; nothing predicted is nothing changed.
    #[test]
    fn weights_do_what_they_say() {
        let mean = DMatrix::from_element(30, 1, 0.4);
        let still = |v: f64| Evidence::new(DMatrix::zeros(30, 1), &[v; 30], 1.0, 1.0, 1.0);
        let sure = blend(&Evidence::new(mean.clone(), &[1e-4; 30], 1.0, 1.0, 1.0), &still(1e-2), 0.01);
        assert!((sure[(15, 0)] - 0.4).abs() < 1e-6, "{}", sure[(15, 0)]); // 4e-9 seen
        let unsure = blend(&Evidence::new(mean, &[1.0; 30], 1.0, 1.0, 1.0), &still(1.0), 0.01);
        // differences of curvature are weighed 1e8 times as much
        assert!((unsure[(15, 0)] - 0.2).abs() < 1e-6, "{}", unsure[(15, 0)]); // 1e-8 seen
        let none = Evidence::new(DMatrix::zeros(30, 1), &[0.1; 30], 1.0, 1.0, 1.0);
        assert!(blend(&none, &still(1e-2), 0.01).iter().all(|x| *x == 0.0));
    }
}
