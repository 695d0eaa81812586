//! Levenberg–Marquardt steps to the weights of a stretch that cost least.
//!
//! In: a problem, most steps. Out: weights, steps taken. A step h solves `(A + λ M) h = −g`, A and g the normal matrix and the
//! gradient; λ falls where the cost does as predicted and grows where it does not (Nielsen 1999).
//!
//! *Metric.* `M = `[`EVERY`]` · diag A + Σ (unit · stiffness)² JᵀJ` over the contact points, J their Jacobians. What is not
//! linear about the cost is the ground: a point that leaves or enters it. With diag A alone a root that moves while its legs
//! keep the feet in place is held back as if the feet moved, since each of the degrees of freedom alone would move
//! them: walks took 40 steps and ended at three times the cost. Without forces M is diag A.
//!
//! *Chords first* ([`Ground::Chord`]), as long as they lead down: they reach a ground that is too far to be felt, and stop at the
//! depth that carries. What they find is then a start for the slopes of the cost itself.
//!
//! *Limits* of joints that a step runs beyond are added to its equations, and it is solved again ([`Problem::foresee`]): damping that
//! keeps one knee from its limit keeps everything else from moving.
//!
//! *Enough.* Half a cost a frame is what a slip of 1 mm costs. A step counts for nothing where less than [`ENOUGH`] of that, or of
//! the cost, was predicted of it: what is gained says nothing, a step too far may gain as little. Of steps that damping
//! holds back two must count for nothing.
//!
//! Nielsen. Damping parameter in Marquardt's method. IMM-REP-1999-05, Technical University of Denmark.

use super::band::Band;
use super::basis::NEAR;
use super::physics::Ground;
use super::problem::Problem;
use crate::RetargetError;

/// Share of a cost that is not worth a step.
const ENOUGH: f64 = 3e-3;
/// Share of what was predicted that a step has to gain: one that gains less has left what its equations know of.
const LEAST: f64 = 0.25;
/// Damping to begin with.
const BEGIN: f64 = 1e-2;
/// Damping that does not hold a step back.
const FREE: f64 = 1e-3;
/// Damping beyond which nothing is gained by a chord, and by anything.
const MOST: [f64; 2] = [1e2, 1e6];
/// How often the limits that a step ran beyond are added to it, before damping grows.
const FORESEEN: usize = 2;
/// Share of diag A in the metric.
const EVERY: f64 = 0.3;

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
        Self { now: BEGIN, growth: 4.0 }
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
    let every = if forces { EVERY } else { 1.0 };
    let mut ground = if forces { Ground::Chord } else { Ground::Tangent };
    let (mut w, mut gradient) = (problem.begin(), vec![0.0; n]);
    let mut clip = problem.displaced(&w);
    let mut cost = problem.cost(&clip, &w);
    let (mut damping, mut steps, mut idle) = (Damping::new(), 0, 0);
    while steps < most_steps {
        problem.linearise((&clip, &w), ground, normal, metric, &mut gradient);
        add_every(metric, every, normal);
        let enough = ENOUGH * cost.min(0.5 * frames as f64);
        let (mut foreseen, mut beyond) = (0, 0.0);
        let done = loop {
            let mut step: Vec<f64> = gradient.iter().map(|g| -g).collect();
            factor.clone_from(normal);
            factor.add(damping.now, metric);
            // overlapping functions are nearly dependent: rounding may need more damping
            if let Err(row) = factor.solve(&mut step) {
                damping.failed();
                if damping.now > MOST[1] {
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
            if lower < cost - LEAST * predicted.max(0.0) {
                idle = if nothing { idle + 1 } else { 0 };
                let last = idle == 2 || (idle == 1 && damping.now < FREE);
                damping.gained((cost - lower) / predicted);
                (w, clip, cost) = (tried, moved, lower);
                steps += 1;
                break last;
            }
            let most = if ground == Ground::Chord { MOST[0] } else { MOST[1] };
            if nothing || damping.now > most {
                break true;
            }
            if forces && foreseen < FORESEEN {
                foreseen += 1;
                let more = problem.foresee(&moved, &step, normal, &mut gradient);
                beyond += more;
                if more > 0.0 {
                    continue;
                }
            }
            if beyond > 0.0 {
                // they were no help, and pull
                problem.linearise((&clip, &w), ground, normal, metric, &mut gradient);
                add_every(metric, every, normal);
                (foreseen, beyond) = (FORESEEN, 0.0);
            }
            damping.failed();
        };
        if done && ground == Ground::Tangent {
            break;
        }
        if done {
            (ground, damping, idle) = (Ground::Tangent, Damping::new(), 0);
        }
    }
    Ok((w, steps))
}

/// Adds a share of the diagonal of `A` to the metric.
fn add_every(metric: &mut Band, every: f64, normal: &mut Band) {
    for i in 0..normal.len() {
        *metric.at(i, i) += every * *normal.at(i, i);
    }
}
