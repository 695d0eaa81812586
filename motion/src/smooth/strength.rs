//! How strongly to smooth: the cut-off that minimises the expected error of the second derivative.
//!
//! In: sampled paths and their rate. Out: a [`Strength`]. No file is told what it holds: signal and noise
//! are read from the paths' own spectrum P(f).
//!
//! 1. *Spectrum.* Third differences first (they whiten motion, whose spectrum falls by many orders, so that
//!    nothing leaks into the quiet end), then three sine tapers \[RS95\]; divided by |2 sin(π f/rate)|⁶ again.
//! 2. *Noise* N(f): a first-order autoregressive spectrum `σ²/|1 − ρ e^{−iω}|²` (ρ = 0 is white; marker noise
//!    after a solver is not), fitted to the upper end of the band by Whittle's likelihood. The fit reaches as
//!    far down as it describes the spectrum: its cumulated ratio P/N stays near a straight line
//!    (Kolmogorov–Smirnov), and its lowest bins do not stand out.
//! 3. *Cut-off.* With the response H of [`super::whittaker`], the expected error
//!    `Σ ω⁴ [(1 − H)² (P − N) + H² N]`: signal lost and noise let through, both as accelerations
//!    (Mallows' Cp for the second derivative).
//!
//! Noise that moves with the body (soft tissue over bone) looks like motion to any spectrum: for it a least
//! density of noise can be given, which counts only where there is measured noise at all.
//!
//! \[RS95\] Riedel, Sidorenko. Minimum bias multiple taper spectral estimation, IEEE Trans. Signal Proc. 43.

use std::f64::consts::PI;

use super::fft::Fft;
use super::whittaker::{lambda, response, third_differences};

/// Sine tapers.
const TAPERS: usize = 3;
/// Shortest paths whose spectrum is read, frames.
pub const LEAST_FRAMES: usize = 16;
/// Candidate cut-offs per octave.
const PER_OCTAVE: f64 = 24.0;
/// Lowest candidate, Hz, or one period per clip if that is higher.
const LOWEST_HZ: f64 = 0.5;
/// Highest candidate as a share of the rate: beyond, smoothing does nothing worth the name.
const HIGHEST: f64 = 0.45;
/// Density of noise below which a path was not recorded but computed or already smoothed, m/√Hz.
///
/// Optical recordings show 1e-6 to 3e-5 on the centre of mass; simulated and fitted motion below 1e-8.
const RECORDED: f64 = 3e-7;

/// Where the fit of the noise may start, as shares of half the rate.
const STARTS: [f64; 11] = [0.06, 0.08, 0.1, 0.12, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6];

/// A strength of smoothing and the noise it was chosen for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strength {
    /// Frequency at which half of the amplitude passes, Hz; infinite: nothing is smoothed.
    pub cutoff_hz: f64,
    /// Colour ρ of the noise, 0 (white) to 0.95.
    pub colour: f64,
    /// One-sided density of the measured noise in the middle of the band, unit of the paths per √Hz.
    pub density: f64,
    /// Least density that was assumed because the paths are a recording; zero if none was.
    pub assumed: f64,
}

impl Strength {
    /// A given cut-off, for white noise of unknown size.
    pub fn at(cutoff_hz: f64) -> Self {
        Self { cutoff_hz, colour: 0.0, density: 0.0, assumed: 0.0 }
    }

    /// Of paths (`frames × columns`, all in one unit) sampled at `rate_hz`; `least` is the least density
    /// of noise of a recording, unit/√Hz, zero for none.
    ///
    /// Paths of fewer than 16 frames are not smoothed.
    pub fn of(paths: &[f64], columns: usize, rate_hz: f64, least: f64) -> Self {
        if columns == 0 || paths.len() / columns < LEAST_FRAMES {
            return Self::at(f64::INFINITY);
        }
        let spectrum = Spectrum::of(paths, columns, rate_hz);
        let (noise, colour) = spectrum.noise();
        let to_density = (2.0 / rate_hz).sqrt();
        let density = noise[(noise.len() - 1) / 2].sqrt() * to_density;
        let assumed = if density > RECORDED { least } else { 0.0 };
        let floor = (assumed / to_density).powi(2);

        let frames = (paths.len() / columns) as f64;
        let lowest = LOWEST_HZ.max(rate_hz / frames);
        let highest = HIGHEST * rate_hz;
        let count = ((highest / lowest).log2() * PER_OCTAVE).ceil().max(1.0) as usize;
        let mut best = (f64::INFINITY, f64::INFINITY);
        for i in 0..=count {
            let hz = lowest * (highest / lowest).powf(i as f64 / count as f64);
            let error = spectrum.error(&noise, floor, lambda(hz, rate_hz));
            if error < best.0 {
                best = (error, if i == count { f64::INFINITY } else { hz });
            }
        }
        Self { cutoff_hz: best.1, colour, density, assumed }
    }

    /// Standard deviation of the noise that is left in the second derivative of a path with this noise, smoothed
    /// with this cut-off: unit of the paths per s².
    pub fn acceleration_noise(&self, rate_hz: f64) -> f64 {
        const BINS: usize = 512;
        let step = 0.5 * rate_hz / BINS as f64;
        let lambda = if self.cutoff_hz < 0.5 * rate_hz { lambda(self.cutoff_hz, rate_hz) } else { 0.0 };
        let middle = self.shape(0.25 * rate_hz, rate_hz);
        let power = (0..BINS).map(|i| {
            let hz = (i as f64 + 0.5) * step;
            let measured = self.density * self.density * self.shape(hz, rate_hz) / middle;
            let density = measured.max(self.assumed * self.assumed);
            let gain = response(lambda, hz, rate_hz) * super::curvature(hz / rate_hz);
            density * gain * gain * step
        });
        power.sum::<f64>().sqrt() * rate_hz * rate_hz
    }

    /// Power spectrum of the noise at `hz`, to an unknown factor.
    pub(super) fn shape(&self, hz: f64, rate_hz: f64) -> f64 {
        shape(self.colour, 2.0 * PI * hz / rate_hz)
    }
}

fn shape(rho: f64, omega: f64) -> f64 {
    1.0 / (1.0 + rho * rho - 2.0 * rho * omega.cos())
}

/// Mean power per sample of some paths, per bin from above zero to half the rate.
struct Spectrum {
    rate_hz: f64,
    hz: Vec<f64>,
    power: Vec<f64>,
    /// Independent bins per bin: zero padding makes more bins than there are numbers.
    weight: f64,
}

impl Spectrum {
    fn of(paths: &[f64], columns: usize, rate_hz: f64) -> Self {
        let third = third_differences(paths, columns);
        let n = third.len() / columns;
        let size = n.next_power_of_two();
        let fft = Fft::new(size);
        let mut power = vec![0.0; size / 2];
        let mut x = vec![[0.0; 2]; size];
        for taper in 1..=TAPERS {
            let step = PI * taper as f64 / (n + 1) as f64;
            let window: Vec<f64> =
                (1..=n).map(|k| (2.0 / (n + 1) as f64).sqrt() * (step * k as f64).sin()).collect();
            for pair in (0..columns).step_by(2) {
                // two real columns in one complex transform: |X|² of both sums to the even part
                for (k, w) in window.iter().enumerate() {
                    let row = &third[k * columns..(k + 1) * columns];
                    x[k] = [row[pair] * w, row.get(pair + 1).map_or(0.0, |b| b * w)];
                }
                x[n..].fill([0.0; 2]);
                fft.forward(&mut x);
                for (k, p) in power.iter_mut().enumerate() {
                    let (a, b) = (x[k + 1], x[size - k - 1]);
                    *p += 0.5 * (a[0] * a[0] + a[1] * a[1] + b[0] * b[0] + b[1] * b[1]);
                }
            }
        }
        let hz: Vec<f64> = (1..=size / 2).map(|k| k as f64 * rate_hz / size as f64).collect();
        for (p, f) in power.iter_mut().zip(&hz) {
            *p /= (columns * TAPERS) as f64 * (2.0 * (PI * f / rate_hz).sin()).powi(6);
        }
        Self { rate_hz, hz, power, weight: n as f64 / size as f64 }
    }

    /// Power of the noise per bin, and its colour ρ.
    fn noise(&self) -> (Vec<f64>, f64) {
        let mut found = (Vec::new(), 0.0);
        for start in STARTS {
            let first = self.hz.partition_point(|f| *f <= start * 0.5 * self.rate_hz);
            let bins = self.hz.len() - first;
            let independent = bins as f64 * self.weight;
            if independent < 6.0 && found.0.is_empty() {
                found = self.fit(0);
            }
            if independent < 6.0 {
                break;
            }
            found = self.fit(first);
            let ratios: Vec<f64> = (first..self.hz.len()).map(|k| self.power[k] / found.0[k]).collect();
            let total: f64 = ratios.iter().sum();
            let (mut sum, mut worst) = (0.0, 0.0_f64);
            for (i, r) in ratios.iter().enumerate() {
                sum += r / total;
                worst = worst.max((sum - (i + 1) as f64 / bins as f64).abs());
            }
            let few = (bins / 20).max((3.0 / self.weight) as usize).min(bins);
            let low = ratios[..few].iter().sum::<f64>() / few as f64;
            let straight = worst < 0.5 / independent.sqrt();
            if straight && low < 1.0 + 1.5 / (few as f64 * self.weight).sqrt() {
                break;
            }
        }
        found
    }

    /// Autoregressive noise fitted to the bins from `first`: Whittle's likelihood over a grid of ρ.
    fn fit(&self, first: usize) -> (Vec<f64>, f64) {
        let omega = |k: usize| 2.0 * PI * self.hz[k] / self.rate_hz;
        let bins = self.hz.len() - first;
        let mut best = (f64::NEG_INFINITY, 0.0, 0.0);
        for step in 0..=19 {
            let rho = 0.05 * f64::from(step);
            let (mut variance, mut logs) = (0.0, 0.0);
            for k in first..self.hz.len() {
                let s = shape(rho, omega(k));
                variance += self.power[k] / s;
                logs += s.ln();
            }
            variance = (variance / bins as f64).max(f64::MIN_POSITIVE);
            let likelihood = -logs - bins as f64 * variance.ln();
            if likelihood > best.0 {
                best = (likelihood, variance, rho);
            }
        }
        let (_, variance, rho) = best;
        ((0..self.hz.len()).map(|k| variance * shape(rho, omega(k))).collect(), rho)
    }

    /// Expected error of the second derivative (arbitrary unit) at the strength λ, with noise of at least
    /// `floor` per bin.
    fn error(&self, noise: &[f64], floor: f64, lambda: f64) -> f64 {
        let mut sum = 0.0;
        for ((f, p), n) in self.hz.iter().zip(&self.power).zip(noise) {
            let h = response(lambda, *f, self.rate_hz);
            let curvature = (2.0 * (PI * f / self.rate_hz).sin()).powi(4);
            // measured noise is unbiased; an assumed floor may exceed all there is
            let (n, signal) = if floor > *n { (floor, (p - floor).max(0.0)) } else { (*n, p - n) };
            sum += curvature * ((1.0 - h).powi(2) * signal + h * h * n);
        }
        sum
    }
}
