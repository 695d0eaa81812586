//! The paper's outputs: the target itself (IAF09 §4.5), and how it is blended as printed.
//!
//! In: a clip of a rig. Out: one row of numbers a frame, columns as in [`super::outputs`], of the clip instead of a difference: `log R` of
//! joints and `log T` of the lean in body axes of the zero pose, angles of hinges, ways of slides and height in sizes, speeds and turn;
//! and back: from numbers of a source and of a target the differences between them.
//!
//! *Blend* (IAF09, 12; §4.3: `(Σ_rk)⁻¹ = Σ_lk`). Y minimises, with j the numbers of the source,
//!
//! ```text
//! Σ  w_lk |Y − μ|²/σ² + w_rk |Y − j|² σ² + w_la |L Y − μ_a|²/σ_a² + w_ra |L Y − L j|² σ_a²
//! ```
//!
//! With `Y = j + D` that is the sum of [`super::solve`] for D, with means `μ − j` and `μ_a − L j` and signals of 1: the weights as
//! printed mix units. Rotation vectors are no longer than π, in all clips alike: joints about half a turn from the zero pose jump.
//!
//! IAF09: Ikemoto, Arikan, Forsyth. Generalizing motion edits with Gaussian processes. ACM TOG 28(1), 2009.

use motion::Clip;
use motion::names::Word;
use motion::rotation::{exp, log};
use nalgebra::DMatrix;

use super::Rig;
use super::outputs::{self, HEIGHT, Smooth, TILT, TIME};
use super::rig::Moves;

/// What is learned of a target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outputs {
    /// How it differs from its source: the prior mean is the source.
    #[default]
    Differences,
    /// The target itself, blended with the weights that the paper prints. See [the module](self).
    Poses,
}

impl Word for Outputs {
    const KIND: &'static str = "what is learned of a target";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Differences, "differences", "how it differs from its source"),
        (Self::Poses, "poses", "the target itself, blended with the weights that the paper prints"),
    ];
}

/// Numbers of all frames of a clip; `times_s` are the times of the frames, those of its rate where there are none.
pub fn of(rig: &Rig, clip: &Clip, times_s: Option<&[f64]>) -> DMatrix<f64> {
    let (frames, s) = (clip.frames(), rig.skeleton());
    let mut out = DMatrix::zeros(frames, outputs::width(rig));
    let root = outputs::joints_width(rig);
    let path = outputs::Path::of(rig, clip);
    for f in 0..frames {
        let q = clip.pose(f);
        let mut column = 0;
        for &(link, moves) in rig.joints() {
            match moves {
                Moves::Ball => {
                    let turn = rig.axes_from_link(link) * log(&s.rotation(q, link));
                    outputs::write3(&mut out, f, column, &turn);
                }
                Moves::Axis => out[(f, column)] = outputs::axis(rig, q, link),
            }
            column += moves.width();
        }
        outputs::write3(&mut out, f, root + TILT, &log(&path.tilts[f]));
        out[(f, root + HEIGHT)] = path.places[f].y / rig.size_m;
        if frames > 1 {
            let rates = path.rates(f.min(frames - 2), clip.rate_hz);
            for (c, of) in outputs::rates(rig).zip([rates.x / rig.size_m, rates.z / rig.size_m, rates.y]) {
                out[(f, c)] = of;
            }
        }
    }
    if let Some(times) = times_s {
        for f in 0..frames {
            out[(f, root + TIME)] = outputs::log_step(times, f, clip.rate_hz);
        }
    }
    out
}

/// Differences of a target with the numbers `target` to the clip `source`, whose numbers are `numbers`; columns as in [`super::outputs`].
pub fn differences(rig: &Rig, source: &Clip, numbers: &DMatrix<f64>, target: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = target - numbers;
    let smooth = Smooth::of(rig, source);
    let tilt = outputs::root_columns(rig).tilt;
    for f in 0..out.nrows() {
        let both = |column: usize| [numbers, target].map(|m| exp(&outputs::read3(m, f, column)));
        let mut column = 0;
        for (joint, &(link, moves)) in rig.joints().iter().enumerate() {
            if moves == Moves::Ball {
                let axes = rig.axes_from_link(link);
                let [from, to] = both(column);
                let turn = axes.inverse() * log(&(to * from.inverse()));
                let turn = axes * (smooth.at(f, joint).inverse() * turn);
                outputs::write3(&mut out, f, column, &turn);
            }
            column += moves.width();
        }
        let [from, to] = both(tilt);
        outputs::write3(&mut out, f, tilt, &log(&(from.inverse() * to)));
    }
    outputs::continue_all(rig, &mut out);
    out
}

/// Second differences by time, as [`super::solve`] has them: those of the first and the last frame are zero.
pub(super) fn accelerations(numbers: &DMatrix<f64>, step_s: f64) -> DMatrix<f64> {
    let last = numbers.nrows().saturating_sub(1);
    DMatrix::from_fn(numbers.nrows(), numbers.ncols(), |f, c| {
        if f == 0 || f >= last {
            return 0.0;
        }
        (numbers[(f - 1, c)] - 2.0 * numbers[(f, c)] + numbers[(f + 1, c)]) / (step_s * step_s)
    })
}
