//! How large a residual is, by the guideline OpenSim gives its users.
//!
//! Guideline ("Simulation with OpenSim – Best Practices", Residual Reduction Algorithm), for the
//! residual forces and moments of walking adults:
//!
//! | | good | limit |
//! |---|---|---|
//! | largest force, N | 10 | 25 |
//! | RMS force, N | 5 | 10 |
//! | largest moment, N·m | 50 | 75 |
//! | RMS moment, N·m | 30 | 50 |

use std::ops::Range;

use motion::Vec3;
use motion::skeleton::vec_at;

/// Verdict on a residual.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Grade {
    /// Within what the guideline calls good.
    #[default]
    Good,
    /// Within its limits.
    Acceptable,
    /// Beyond them.
    Poor,
}

impl Grade {
    /// Verdict on a `value` with the bounds of good and acceptable.
    pub fn of(value: f64, good: f64, limit: f64) -> Self {
        if value <= good {
            Grade::Good
        } else if value <= limit {
            Grade::Acceptable
        } else {
            Grade::Poor
        }
    }
}

impl std::fmt::Display for Grade {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Grade::Good => "good",
            Grade::Acceptable => "acceptable",
            Grade::Poor => "poor",
        })
    }
}

/// Bounds of good and acceptable for the largest residual force, N.
pub const FORCE_PEAK_N: [f64; 2] = [10.0, 25.0];
/// The same for its RMS, N.
pub const FORCE_RMS_N: [f64; 2] = [5.0, 10.0];
/// The same for the largest residual moment, N·m.
pub const MOMENT_PEAK_NM: [f64; 2] = [50.0, 75.0];
/// The same for its RMS, N·m.
pub const MOMENT_RMS_NM: [f64; 2] = [30.0, 50.0];

/// Size of a residual wrench over a clip, by its magnitude.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residual {
    /// Largest force, N.
    pub force_peak: f64,
    /// RMS force, N.
    pub force_rms: f64,
    /// Frame of the largest force.
    pub force_frame: usize,
    /// Largest moment about the root's origin, N·m.
    pub moment_peak: f64,
    /// RMS moment, N·m.
    pub moment_rms: f64,
    /// Frame of the largest moment.
    pub moment_frame: usize,
}

impl Residual {
    /// Of a table `frames × 6`: force, moment.
    pub fn of(wrench: &[f64]) -> Self {
        Self::over(wrench, 0..wrench.len() / 6)
    }

    /// Of some frames of such a table.
    pub fn over(wrench: &[f64], frames: Range<usize>) -> Self {
        let (force_peak, force_rms, force_frame) = size(wrench, &frames, 0);
        let (moment_peak, moment_rms, moment_frame) = size(wrench, &frames, 3);
        Self { force_peak, force_rms, force_frame, moment_peak, moment_rms, moment_frame }
    }

    /// Verdict on the largest force: the one the guideline is quoted for.
    pub fn force_grade(&self) -> Grade {
        Grade::of(self.force_peak, FORCE_PEAK_N[0], FORCE_PEAK_N[1])
    }

    /// Verdict on the largest moment.
    pub fn moment_grade(&self) -> Grade {
        Grade::of(self.moment_peak, MOMENT_PEAK_NM[0], MOMENT_PEAK_NM[1])
    }

    /// The worse of the four verdicts: peak and RMS, force and moment.
    pub fn grade(&self) -> Grade {
        let force_rms = Grade::of(self.force_rms, FORCE_RMS_N[0], FORCE_RMS_N[1]);
        let moment_rms = Grade::of(self.moment_rms, MOMENT_RMS_NM[0], MOMENT_RMS_NM[1]);
        self.force_grade().max(self.moment_grade()).max(force_rms).max(moment_rms)
    }
}

/// Peak, RMS and the frame of the peak of the 3-vectors at column `at` of a table of six columns, over some frames.
fn size(wrench: &[f64], frames: &Range<usize>, at: usize) -> (f64, f64, usize) {
    let (mut peak, mut sum, mut frame) = (0.0, 0.0, frames.start);
    for (k, row) in wrench.chunks_exact(6).enumerate().take(frames.end).skip(frames.start) {
        let x: Vec3 = vec_at(row, at);
        sum += x.norm_squared();
        if x.norm() > peak {
            (peak, frame) = (x.norm(), k);
        }
    }
    (peak, (sum / frames.len().max(1) as f64).sqrt(), frame)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_guideline_s_bounds_belong_to_the_better_side() {
        let residual = |f: f64, m: f64| Residual::of(&[0.0, f, 0.0, 0.0, 0.0, -m]);
        assert_eq!(residual(10.0, 50.0).force_grade(), Grade::Good);
        assert_eq!(residual(10.1, 50.0).force_grade(), Grade::Acceptable);
        assert_eq!(residual(25.1, 75.0).force_grade(), Grade::Poor);
        assert_eq!(residual(0.0, 75.0).moment_grade(), Grade::Acceptable);
        assert_eq!(residual(0.0, 75.1).moment_grade(), Grade::Poor);
        assert_eq!(residual(5.0, 30.0).grade(), Grade::Good);
        assert_eq!(residual(5.1, 30.0).grade(), Grade::Acceptable); // by its RMS
    }

    #[test]
    fn residuals_of_nothing_and_of_zeros_are_zero_and_good() {
        for wrench in [&[][..], &[0.0; 18]] {
            assert_eq!(Residual::of(wrench), Residual::default());
            assert_eq!(Residual::of(wrench).grade(), Grade::Good);
        }
    }

    #[test]
    fn peak_and_rms_have_known_values() {
        let r = Residual::of(&[3.0, 4.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 0.0, 0.0]);
        assert_eq!((r.force_peak, r.force_frame), (5.0, 0));
        assert_eq!((r.moment_peak, r.moment_frame), (2.0, 1));
        assert!((r.force_rms - 13f64.sqrt()).abs() < 1e-15);
        assert!((r.moment_rms - 2.5f64.sqrt()).abs() < 1e-15);
        // frames that are left out count neither for peaks nor for means
        let r = Residual::over(&[3.0, 4.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 0.0, 0.0], 1..2);
        assert_eq!((r.force_peak, r.force_frame, r.force_rms), (1.0, 1, 1.0));
    }
}
