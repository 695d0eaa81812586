//! The smoother of a clip: least third differences, a strength read from the clip itself.
//!
//! In: a [`Clip`] and a [`Smoothing`]. Out: the smoothed clip, its [`Derivatives`], and a [`SmoothReport`]:
//! the cut-off that was chosen, the noise that was found, and what is left of it in the accelerations. No
//! mass: who needs forces chooses the strength on the path of the centre of mass (`dynamics::analysis`).
//!
//! *Smoother.* Penalised least squares ([`whittaker`]): `Σ |q − z|² + λ Σ |Δ³z|²`, so that accelerations are
//! as smooth as λ asks for. One λ for the whole clip: with one linear response for all joints a planted foot
//! stays planted, because what hip, knee and ankle cancel is scaled alike. The ends are free (no third
//! differences beyond them): a parabola passes unchanged and nothing rings; noise of the accelerations is
//! 2.4 times that of the middle in the last frame and has come down half a period of the cut-off inside.
//!
//! *Rotations.* With increments `ω_k = log(R_{k+1} R_k⁻¹)` the path in the tangent space is their running sum,
//! Δ³ of it is Δ²ω, and the smoothed rotation is `S_k = exp(ε_k) R_k`. A second Gauss–Newton step, about
//! S, removes what the first one's linearisation left. No reference orientation enters: the result turns with
//! the whole motion, and a constant angular acceleration is not touched.
//!
//! *Derivatives.* v and v̇ are those of the smoothed path: [`Derivatives::central`].
//!
//! *Strength.* See [`strength`].

mod fft;
pub mod strength;
pub mod whittaker;

use crate::{Clip, Derivatives, Joint, Skeleton};

pub use strength::Strength;
use whittaker::{Whittaker, lambda, response, third_differences};

/// Metres that one radian of a joint counts for when lengths and angles choose one strength together.
const LEVER: f64 = 0.25;
/// Gauss–Newton steps for rotations.
const STEPS: usize = 2;

/// How strongly a clip is smoothed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Smoothing {
    /// Strength chosen from the clip itself.
    #[default]
    Auto,
    /// A stated strength: the frequency at which half of the amplitude passes, Hz.
    CutoffHz(f64),
    /// None: for motion without noise, such as simulated one.
    Off,
}

/// What a smoother chose and what noise it found.
#[derive(Clone, Debug, PartialEq)]
pub struct SmoothReport {
    /// Frequency at which half of the amplitude passes, Hz, for the whole clip; infinite where nothing was
    /// smoothed.
    pub cutoff_hz: f64,
    /// How it was chosen.
    pub strength: Strength,
    /// Noise of the given poses, standard deviation per degree of freedom (`nv`), m or rad, from the upper
    /// end of the band; zero where nothing was smoothed.
    pub noise: Vec<f64>,
    /// What is left of it in the accelerations (`nv`), m/s² or rad/s².
    pub acceleration_noise: Vec<f64>,
}

/// A smoothed clip with its derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct Smoothed {
    /// The smoothed motion, same frames and rate.
    pub clip: Clip,
    /// Its velocities and accelerations.
    pub derivatives: Derivatives,
    /// Strength and noise.
    pub report: SmoothReport,
    /// Accelerations that are noise only, as large as what is left of it, `(frames − 3) × nv`: the upper end
    /// of what was taken away, scaled. Unlike the report's standard deviations it keeps what the degrees
    /// of freedom have to do with each other. Empty where nothing was smoothed.
    pub noise_sample: Vec<f64>,
}

/// Smooths a clip. See the module header.
///
/// [`Smoothing::Auto`] chooses on the paths of all degrees of freedom, a radian counting as 0.25 m.
///
/// # Panics
/// If a stated cut-off is NaN.
pub fn smooth(clip: &Clip, smoothing: Smoothing) -> Smoothed {
    let strength = match smoothing {
        Smoothing::Off => Strength::at(f64::INFINITY),
        Smoothing::CutoffHz(hz) => Strength::at(hz),
        Smoothing::Auto => {
            let (mut paths, nv) = (tangent_paths(clip), clip.skeleton.nv());
            let scale = levers(&clip.skeleton);
            for row in paths.chunks_exact_mut(nv.max(1)) {
                row.iter_mut().zip(&scale).for_each(|(x, s)| *x *= s);
            }
            Strength::of(&paths, nv, clip.rate_hz, 0.0)
        }
    };
    smooth_at(clip, strength)
}

/// Smooths a clip with a given strength.
///
/// Nothing is smoothed at an infinite cut-off or one at or above half the rate. The lowest there is is the
/// rate / 600 (λ ≈ 1e12: below, rounding would decide); lower ones are raised to it, and the report says so.
///
/// # Panics
/// If the cut-off is NaN.
pub fn smooth_at(clip: &Clip, strength: Strength) -> Smoothed {
    let (frames, nv) = (clip.frames(), clip.skeleton.nv());
    assert!(!strength.cutoff_hz.is_nan(), "the cut-off is NaN");
    let hz = strength.cutoff_hz.max(clip.rate_hz / 600.0);
    let strength = Strength { cutoff_hz: hz, ..strength };
    let mut out = clip.clone();
    let (mut noise, mut acceleration_noise) = (vec![0.0; nv], vec![0.0; nv]);
    let mut noise_sample = Vec::new();
    let smoothed = hz < 0.5 * clip.rate_hz && frames > 3;
    if smoothed {
        let lambda = lambda(hz, clip.rate_hz);
        out = smoothed_path(clip, lambda, STEPS);
        let rate = clip.rate_hz;
        let left = variance(&strength, rate, |hz| response(lambda, hz, rate) * curvature(hz / rate));
        noise_sample = upper_noise(clip, &out, &strength, lambda);
        for row in noise_sample.chunks_exact(nv.max(1)) {
            noise.iter_mut().zip(row).for_each(|(s, x)| *s += x * x / (frames - 3) as f64);
        }
        let to_acceleration = left.sqrt() * rate * rate;
        noise_sample.iter_mut().for_each(|x| *x *= to_acceleration);
        for (size, acceleration) in noise.iter_mut().zip(&mut acceleration_noise) {
            *size = size.sqrt();
            *acceleration = *size * to_acceleration;
        }
    }
    let derivatives = Derivatives::central(&out);
    let cutoff_hz = if smoothed { hz } else { f64::INFINITY };
    Smoothed {
        clip: out,
        derivatives,
        report: SmoothReport { cutoff_hz, strength, noise, acceleration_noise },
        noise_sample,
    }
}

/// Gauss–Newton on `Σ |log(R S⁻¹)|² + λ Σ |Δ²ω(S)|²`, from S = R; one step is exact for coordinates.
fn smoothed_path(clip: &Clip, lambda: f64, steps: usize) -> Clip {
    let (frames, nv) = (clip.frames(), clip.skeleton.nv());
    let filter = Whittaker::new(frames, lambda);
    let mut out = clip.clone();
    let mut shift = vec![0.0; frames * nv];
    for step in 0..steps {
        let third = second_differences(&increments(&out), nv);
        if step > 0 {
            for k in 0..frames {
                let row = &mut shift[k * nv..(k + 1) * nv];
                clip.skeleton.difference(out.pose(k), clip.pose(k), 1.0, row);
            }
        }
        filter.correct(&third, &mut shift, nv);
        for k in 0..frames {
            clip.skeleton.integrate(out.pose_mut(k), &shift[k * nv..(k + 1) * nv], 1.0);
        }
    }
    out
}

/// Paths of all degrees of freedom in their tangent spaces, `frames × nv`, from zero in the first frame:
/// coordinates, and running sums of the logarithms of a rotation's increments.
pub fn tangent_paths(clip: &Clip) -> Vec<f64> {
    let nv = clip.skeleton.nv();
    let steps = increments(clip);
    let mut out = vec![0.0; clip.frames() * nv];
    for i in nv..out.len() {
        out[i] = out[i - nv] + steps[i - nv];
    }
    out
}

/// Differences of neighbouring poses, `(frames − 1) × nv`.
fn increments(clip: &Clip) -> Vec<f64> {
    let nv = clip.skeleton.nv();
    let mut out = vec![0.0; clip.frames().saturating_sub(1) * nv];
    for (k, row) in out.chunks_exact_mut(nv.max(1)).enumerate() {
        clip.skeleton.difference(clip.pose(k), clip.pose(k + 1), 1.0, row);
    }
    out
}

fn second_differences(x: &[f64], columns: usize) -> Vec<f64> {
    let n = x.len().saturating_sub(2 * columns);
    (0..n).map(|i| (x[i + 2 * columns] - x[i + columns]) - (x[i + columns] - x[i])).collect()
}

/// Metres per unit of each degree of freedom.
fn levers(skeleton: &Skeleton) -> Vec<f64> {
    let of = |joint: &Joint| match joint {
        Joint::Free => vec![1.0, 1.0, 1.0, LEVER, LEVER, LEVER],
        Joint::Spherical => vec![LEVER; 3],
        Joint::Revolute(_) => vec![LEVER],
        Joint::Prismatic(_) => vec![1.0],
        Joint::Fixed => Vec::new(),
    };
    skeleton.links().iter().flat_map(|l| of(&l.joint)).collect()
}

/// A sample of the noise, `(frames − 3) × nv`, as large as the noise of the poses.
///
/// Third differences of what was taken away: they weigh the upper end of the band, where what was taken away
/// is noise only; the colour carries its size down to the rest of the band.
fn upper_noise(before: &Clip, after: &Clip, strength: &Strength, lambda: f64) -> Vec<f64> {
    let (frames, nv, rate) = (before.frames(), before.skeleton.nv(), before.rate_hz);
    let mut taken = vec![0.0; frames * nv];
    for (k, row) in taken.chunks_exact_mut(nv.max(1)).enumerate() {
        before.skeleton.difference(after.pose(k), before.pose(k), 1.0, row);
    }
    let mut sample = third_differences(&taken, nv);
    let gain = variance(strength, rate, |hz| {
        (1.0 - response(lambda, hz, rate)) * (2.0 * (std::f64::consts::PI * hz / rate).sin()).powi(3)
    });
    sample.iter_mut().for_each(|x| *x /= gain.sqrt());
    sample
}

/// Variance that a filter with the given response leaves of noise of unit variance.
fn variance(strength: &Strength, rate_hz: f64, response: impl Fn(f64) -> f64) -> f64 {
    const BINS: usize = 512;
    let (mut all, mut left) = (0.0, 0.0);
    for i in 0..BINS {
        let hz = (i as f64 + 0.5) / BINS as f64 * 0.5 * rate_hz;
        let power = strength.shape(hz, rate_hz);
        all += power;
        left += power * response(hz).powi(2);
    }
    left / all
}

/// Response of the five-point second difference at `x` cycles per frame.
fn curvature(x: f64) -> f64 {
    let w = std::f64::consts::TAU * x;
    (-2.0 * (2.0 * w).cos() + 32.0 * w.cos() - 30.0) / 12.0
}

#[cfg(test)]
mod tests;
