//! Long clips, a stretch at a time: cost and memory grow as the length does.
//!
//! In: a problem's setting, a clip, the degrees of freedom that move. Out: the clip moved. Two functions act together
//! only within 16 spacings, but the band of many degrees of freedom over many minutes fills a memory, and one damping
//! for all of it waits for the worst second. So a clip is cut into stretches of [`LENGTH_S`]; each is solved with
//! [`OVERLAP_S`] (8 spacings at least) of what follows, where the functions of the next one are still missing: there
//! the next one begins with what was found and solves it again. What was kept of earlier ones stays. A clip shorter than both is one stretch.

use motion::Clip;

use super::basis::{Active, Basis, REACH};
use super::descent::{Scratch, descend};
use super::problem::{Problem, Setting, Stretch};
use crate::RetargetError;

/// Time whose functions are kept of a stretch, s.
pub const LENGTH_S: f64 = 8.0;
/// Time beyond them that is solved along, s.
pub const OVERLAP_S: f64 = 1.5;

/// Moves `clip` to the least cost; returns the most steps that a stretch took.
///
/// * `moving`: which of the degrees of freedom move in a stretch; none leaves it as it is
pub(super) fn solve(
    setting: Setting,
    clip: &mut Clip,
    dofs: &[usize],
    forces: bool,
    moving: &dyn Fn(&Stretch) -> Vec<usize>,
) -> Result<usize, RetargetError> {
    let (rate, d) = (clip.rate_hz, dofs.len());
    let basis = Basis::new(clip.duration_s(), setting.options.spacing_s);
    let functions = |seconds: f64| (seconds / setting.options.spacing_s).ceil() as usize;
    let (length, overlap) = (functions(LENGTH_S).max(1), functions(OVERLAP_S).max(REACH));
    let mut w = vec![0.0; basis.len() * d];
    let mut scratch = Scratch::default();
    let (mut from, mut steps) = (0, 0);
    while from < basis.len() {
        let rest = basis.len() - from;
        let (kept, solved) = if rest <= length + overlap { (rest, rest) } else { (length, length + overlap) };
        let stretch = stretch(&basis, from..from + solved, clip.frames(), rate);
        let moving = moving(&stretch);
        if !moving.is_empty() {
            let columns: Vec<usize> =
                moving.iter().map(|m| dofs.iter().position(|d| d == m).expect("one of all")).collect();
            let mut problem = Problem::new(setting, clip, stretch, (&basis, &w), (dofs, moving), forces);
            let (found, taken) = descend(&mut problem, setting.options.iterations, &mut scratch)?;
            for (function, row) in found.chunks_exact(columns.len()).enumerate() {
                columns.iter().zip(row).for_each(|(c, x)| w[(from + function) * d + c] = *x);
            }
            steps = steps.max(taken);
        }
        from += kept;
    }
    displace(clip, &basis, &w, dofs);
    Ok(steps)
}

/// The frames that functions move.
fn stretch(basis: &Basis, functions: std::ops::Range<usize>, frames: usize, rate_hz: f64) -> Stretch {
    let reach_s = basis.middle_s(REACH) - basis.middle_s(0);
    let first = (basis.middle_s(functions.start) - reach_s) * rate_hz;
    let last = (basis.middle_s(functions.end - 1) + reach_s) * rate_hz;
    let counted = (first.ceil().max(0.0) as usize)..(last.floor() as usize + 1).min(frames);
    let around = counted.start.saturating_sub(2)..(counted.end + 2).min(frames);
    Stretch { counted, frames: around, functions }
}

/// Moves every frame by the sum of its functions.
fn displace(clip: &mut Clip, basis: &Basis, w: &[f64], dofs: &[usize]) {
    let (skeleton, d) = (clip.skeleton.clone(), dofs.len());
    let (mut active, all) = (Active::default(), 0..basis.len());
    let mut v = vec![0.0; skeleton.nv()];
    for i in 0..clip.frames() {
        basis.at(i as f64 / clip.rate_hz, &all, &mut active);
        for (j, &dof) in dofs.iter().enumerate() {
            let terms = active.phi.iter().enumerate();
            v[dof] = terms.map(|(l, phi)| phi[0] * w[(active.first + l) * d + j]).sum();
        }
        skeleton.integrate(clip.pose_mut(i), &v, 1.0);
    }
}
