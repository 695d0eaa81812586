//! Levenberg–Marquardt steps to the weights of a stretch that cost least.
//!
//! In: a problem, most steps. Out: weights, steps taken. A step h solves `(A + λ M) h = −g`, A and g the normal matrix and the
//! gradient; λ falls where the cost does as predicted and grows where it does not (Nielsen 1999).
//!
//! *Metric.* `M = `[`DIAGONAL_SHARE`]` · diag A + Σ (unit · stiffness)² JᵀJ` over the contact points, J their Jacobians. What is not
//! linear about the cost is the ground: a point that leaves or enters it. With diag A alone a root that moves while its legs
//! keep the feet in place is held back as if the feet moved, since each of the degrees of freedom alone would move
//! them: walks took 40 steps and ended at three times the cost. Without forces M is diag A.
//!
//! *Chords first* ([`GroundSlope::Chord`]), as long as they lead down: they reach a ground that is too far away to exert a force,
//! and stop at the depth that carries the body. From there steps by the slopes of the cost itself go on.
//!
//! *Limits* of joints that a step runs beyond are added to its equations, and it is solved again
//! ([`Problem::add_foreseen_limits`]): damping instead would slow down everything else along with the joint at its limit.
//!
//! *Enough.* Half a cost a frame is what a slip of 1 mm costs. A step is idle where less than [`ENOUGH`] of that, or of the
//! cost, was predicted of it. (The gain itself does not tell: a step that goes too far can gain as little.) One idle step is
//! the last where damping is small, otherwise two in a row.
//!
//! Nielsen. Damping parameter in Marquardt's method. IMM-REP-1999-05, Technical University of Denmark.

use super::band::Band;
use super::basis::NEAR;
use super::physics::GroundSlope;
use super::problem::Problem;
use crate::RetargetError;

/// Share of a cost that is not worth a step.
const ENOUGH: f64 = 3e-3;
/// Share of what was predicted that a step has to gain. One that gains less has gone beyond where its linear equations hold,
/// and is taken only if one with more damping gains less.
const LEAST_GAIN: f64 = 0.25;
/// Damping to begin with.
const FIRST_DAMPING: f64 = 1e-2;
/// Damping below which a step is as good as undamped.
const UNDAMPED: f64 = 1e-3;
/// Damping at which steps are given up: by chords, and by slopes.
const MOST_DAMPING: [f64; 2] = [1e2, 1e6];
/// How often the limits that a step ran beyond are added to it, before damping grows.
const FORESIGHT_ROUNDS: usize = 2;
/// Share of diag A in the metric.
const DIAGONAL_SHARE: f64 = 0.3;

/// Memory of the descent: normal matrix, its factor, metric.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    normal: Band,
    factor: Band,
    metric: Band,
}

/// Damping, and by how much it grows where a step fails. See the module header.
struct Damping {
    now: f64,
    growth: f64,
}

impl Damping {
    const fn new() -> Self {
        Self { now: FIRST_DAMPING, growth: 4.0 }
    }

    /// After a step that gained this share of what was predicted.
    fn gained(&mut self, ratio: f64) {
        let factor = 1.0 - (2.0 * ratio - 1.0).powi(3);
        *self = Self { now: (self.now * factor.clamp(0.1, 2.0)).max(1e-9), ..Self::new() };
    }

    fn failed(&mut self) {
        self.now *= self.growth;
        self.growth *= 2.0;
    }
}

/// The weights of a stretch that cost least, and the steps taken.
pub(super) fn descend(
    problem: &mut Problem,
    most_steps: usize,
    scratch: &mut Scratch,
) -> Result<(Vec<f64>, usize), RetargetError> {
    let (functions, dofs, frames) = problem.shape();
    let Scratch { normal, factor, metric } = scratch;
    normal.reset(functions, dofs, 2 * NEAR);
    metric.reset(functions, dofs, 2 * NEAR);
    let n = functions * dofs;
    let forces = problem.has_forces();
    let share = if forces { DIAGONAL_SHARE } else { 1.0 };
    let mut ground = if forces { GroundSlope::Chord } else { GroundSlope::Tangent };
    let (mut w, mut gradient) = (problem.begin(), vec![0.0; n]);
    let mut clip = problem.displaced(&w);
    let mut cost = problem.cost(&clip, &w);
    let (mut damping, mut steps, mut idle) = (Damping::new(), 0, 0);
    while steps < most_steps {
        problem.linearise((&clip, &w), ground, normal, metric, &mut gradient);
        add_diagonal(metric, share, normal);
        let enough = ENOUGH * cost.min(0.5 * frames);
        let (mut foreseen, mut beyond, mut small) = (0, 0.0, None);
        let done = loop {
            let mut step: Vec<f64> = gradient.iter().map(|g| -g).collect();
            factor.clone_from(normal);
            factor.add(damping.now, metric);
            // overlapping functions are nearly dependent: rounding can make the matrix indefinite, damping mends that
            if let Err(row) = factor.solve(&mut step) {
                damping.failed();
                if damping.now > MOST_DAMPING[1] {
                    return Err(RetargetError::Singular { row });
                }
                continue;
            }
            // −gᵀh − ½ hᵀA h with A h = −g − λ M h
            let along: f64 = step.iter().zip(&gradient).map(|(h, g)| h * g).sum();
            let predicted = 0.5 * (damping.now * metric.quadratic(&step) - along) - beyond;
            let nothing = predicted < enough && beyond == 0.0;
            let tried: Vec<f64> = w.iter().zip(&step).map(|(a, b)| a + b).collect();
            let moved = problem.displaced(&tried);
            let lower = problem.cost(&moved, &tried);
            if lower < cost - LEAST_GAIN * predicted.max(0.0) {
                idle = if nothing { idle + 1 } else { 0 };
                let last = idle == 2 || (idle == 1 && damping.now < UNDAMPED);
                damping.gained((cost - lower) / predicted);
                (w, clip, cost) = (tried, moved, lower);
                steps += 1;
                break last;
            }
            let most = if ground == GroundSlope::Chord { MOST_DAMPING[0] } else { MOST_DAMPING[1] };
            let last = nothing || damping.now > most;
            // where bodies touch the cost has kinks and its slopes tell little: more damping does not help
            let better = small.as_ref().is_none_or(|(_, _, least)| lower < *least);
            if !better || (last && small.is_some()) {
                (w, clip, cost) = small.expect("there is one");
                damping.growth = Damping::new().growth;
                (steps, idle) = (steps + 1, 0);
                break false;
            }
            if last {
                break true;
            }
            if lower < cost {
                small = Some((tried, moved.clone(), lower));
            }
            if forces && foreseen < FORESIGHT_ROUNDS {
                foreseen += 1;
                let more = problem.add_foreseen_limits(&moved, &step, normal, &mut gradient);
                beyond += more;
                if more > 0.0 {
                    continue;
                }
            }
            if beyond > 0.0 {
                // the foreseen limits did not lower the cost, and bias the step: take them out again
                problem.linearise((&clip, &w), ground, normal, metric, &mut gradient);
                add_diagonal(metric, share, normal);
                (foreseen, beyond) = (FORESIGHT_ROUNDS, 0.0);
            }
            damping.failed();
        };
        if done && ground == GroundSlope::Tangent {
            break;
        }
        if done {
            (ground, damping, idle) = (GroundSlope::Tangent, Damping::new(), 0);
        }
    }
    Ok((w, steps))
}

/// Adds a share of the diagonal of `A` to the metric.
fn add_diagonal(metric: &mut Band, share: f64, normal: &mut Band) {
    for i in 0..normal.len() {
        *metric.at(i, i) += share * *normal.at(i, i);
    }
}
