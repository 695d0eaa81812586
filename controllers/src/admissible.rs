//! An admissible path: a motion on planted feet whose ground reaction stays inside its soles.
//!
//! Captured motion on a guessed body asks now and then for a centre of pressure beyond the soles, by the noise of
//! its accelerations or the error of its masses. No controller can follow that and stand. With the inverted
//! pendulum of constant height h, `c̈ = ω² (c − p_c)`, ω² = g/h, the centre of mass c that belongs to a wanted
//! pressure path follows from `c − c̈/ω² = p_c` with both ends held: a linear boundary-value problem that has no
//! growing solutions, tridiagonal in time. Here `p_c = c − c̈/ω² + (clamp(p) − p)`: the path asked for, moved by no
//! more than what brings its centre of pressure p inside (in moments: where the soles carry less than the weight, by as much
//! less). Where nothing is outside, nothing moves.
//!
//! A body that steps is the same equation with other rows ([`Row`]): where the ground gives more or less than the weight, `hold`
//! is its share; in flight it is zero, and the path is what gravity makes of it. Both directions of time count, so a weight
//! shifts before a foot leaves. [`crate::shift`] makes these rows of a plan.
//!
//! In: a clip on planted feet, smooth enough to differentiate. Out: the same with the root moved horizontally and the
//! legs solved. World frame, ground plane `(x, z)`.

use dynamics::{Model, State};
use motion::ik::IkError;
use motion::plant::Plant;
use motion::support::{Vec2, ground};
use motion::{Clip, Derivatives, Vec3};

use crate::feed::pressure;
use crate::posture::settle;
use crate::support::{Foot, clamp_inside, polygon};

/// How far the centre of pressure of each frame must go to be `margin` (m) inside the soles of `feet` on the ground at height
/// `ground_m`, times the load of the soles over the weight: the moment that is missing over the weight. With the centre of mass
/// of each frame, m. `d`: derivatives of the clip.
pub fn outside(
    model: &Model,
    clip: &Clip,
    d: &Derivatives,
    feet: &[Foot],
    ground_m: f64,
    margin: f64,
) -> Vec<(Vec2, Vec3)> {
    let nv = model.nv();
    let weight = (model.mass * model.gravity.norm()).max(1e-9);
    let mut state = State::new(model);
    let mut tau = vec![0.0; nv];
    let mut one = |f: usize| {
        let (v, vd) = (&d.v[f * nv..(f + 1) * nv], &d.vd[f * nv..(f + 1) * nv]);
        state.update(model, clip.pose(f), v);
        state.inverse_dynamics(model, v, vd, &[], &mut tau);
        let support = polygon(feet, model, &state);
        let beyond = pressure(&state, &tau, ground_m)
            .map_or(Vec2::zeros(), |(force, p)| (clamp_inside(&support, p, margin) - p) * (force.y / weight));
        (beyond, state.com(model))
    };
    (0..clip.frames()).map(&mut one).collect()
}

/// Moves the root of `clip` so that its centre of pressure on the ground at height `ground_m` stays `margin` (m)
/// inside the soles of `feet`, which stand at `plants`. `d`: derivatives of the clip, which say how sudden a change of the
/// pressure counts.
///
/// Returns how far the centre of mass was moved in every frame, m.
///
/// # Errors
/// Legs that two-bone IK cannot solve.
pub fn admit(
    model: &Model,
    clip: &mut Clip,
    d: &Derivatives,
    feet: &[Foot],
    plants: &[Plant],
    ground_m: f64,
    margin: f64,
) -> Result<Vec<Vec2>, IkError> {
    let found = outside(model, clip, d, feet, ground_m, margin);
    let beyond: Vec<Vec2> = found.iter().map(|(beyond, _)| *beyond).collect();
    let height = found.iter().map(|(_, com)| com.y - ground_m).sum::<f64>() / found.len().max(1) as f64;
    // (1 + 2a) x_i − a (x_{i−1} + x_{i+1}) = beyond_i, ends held
    let a = height.max(0.2) / model.gravity.norm().max(1e-9) * clip.rate_hz * clip.rate_hz;
    let rows: Vec<Row> = beyond.iter().map(|&b| Row { hold: 1.0, a, b }).collect();
    let moves = solve(&rows);
    let mut state = State::new(model);
    for (f, (_, com)) in found.iter().enumerate() {
        settle(model, &mut state, clip.pose_mut(f), plants, ground(com) + moves[f])?;
    }
    Ok(moves)
}

/// A frame of the equation of a path: `(hold + 2a) x_i − a (x_{i−1} + x_{i+1}) = b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// How much a path away from the one asked for is brought back: the share of the weight that the ground bears, ≥ 0.
    pub hold: f64,
    /// Its bending: the square of a time in frames, > 0.
    pub a: f64,
    /// What the path is moved by, m.
    pub b: Vec2,
}

/// Solves the rows with `x = 0` at both ends (Thomas): in time and memory linear in their number. The matrix is an M-matrix, so
/// there is one solution, and it does not grow.
pub fn solve(rows: &[Row]) -> Vec<Vec2> {
    let n = rows.len();
    let mut x = vec![Vec2::zeros(); n];
    if n < 3 {
        return x;
    }
    let mut upper = vec![0.0; n];
    for i in 1..n - 1 {
        let Row { hold, a, b } = rows[i];
        let pivot = hold + 2.0 * a - a * upper[i - 1];
        upper[i] = a / pivot;
        x[i] = (b + x[i - 1] * a) / pivot;
    }
    for i in (1..n - 1).rev() {
        let next = x[i + 1];
        x[i] += next * upper[i];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A path that is admissible stays to the bit; the solution satisfies its equation, in flight and on the ground.
    #[test]
    fn the_correction_solves_its_equation() {
        for flight in [0..0, 20..33] {
            let row = |i: usize| {
                let f = i as f64;
                let hold = if flight.contains(&i) { 0.0 } else { 1.0 };
                Row { hold, a: 37.0, b: Vec2::new((f * 0.3).sin(), (i % 7) as f64) }
            };
            let rows: Vec<Row> = (0..50).map(row).collect();
            let x = solve(&rows);
            assert_eq!((x[0], x[49]), (Vec2::zeros(), Vec2::zeros()));
            for i in 1..49 {
                let Row { hold, a, b } = rows[i];
                let residue = x[i] * (hold + 2.0 * a) - (x[i - 1] + x[i + 1]) * a - b;
                assert!(residue.norm() < 1e-11, "{i}: {residue}"); // 2e-13 seen
            }
            let still: Vec<Row> = rows.iter().map(|r| Row { b: Vec2::zeros(), ..*r }).collect();
            assert!(solve(&still).iter().all(|x| *x == Vec2::zeros()));
        }
    }
}
