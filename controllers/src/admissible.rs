//! An admissible path: a motion on planted feet whose ground reaction stays inside its soles.
//!
//! Captured motion on a guessed body asks now and then for a centre of pressure beyond the soles, by the noise of
//! its accelerations or the error of its masses. No controller can follow that and stand. With the inverted
//! pendulum of constant height h, `c̈ = ω² (c − p_c)`, ω² = g/h, the centre of mass c that belongs to a wanted
//! pressure path follows from `c − c̈/ω² = p_c` with both ends held: a linear boundary-value problem that has no
//! growing solutions, tridiagonal in time. Here `p_c = c − c̈/ω² + (clamp(p) − p)`: the path asked for, moved by no
//! more than what brings its centre of pressure p inside. Where nothing is outside, nothing moves.
//!
//! In: a clip on planted feet, smooth enough to differentiate. Out: the same with the root moved horizontally and the
//! legs solved. World frame, ground plane `(x, z)`.

use dynamics::{Model, State};
use motion::ik::IkError;
use motion::plant::Plant;
use motion::support::{Vec2, ground};
use motion::{Clip, Derivatives};

use crate::feed::pressure;
use crate::posture::settle;
use crate::support::{Foot, clamp_inside, polygon};

/// Moves the root of `clip` so that its centre of pressure on the ground at height `ground_m` stays `margin` (m)
/// inside the soles of `feet`, which stand at `plants`.
///
/// Returns how far the centre of mass was moved at most, m.
///
/// # Errors
/// Legs that two-bone IK cannot solve.
pub fn admit(
    model: &Model,
    clip: &mut Clip,
    feet: &[Foot],
    plants: &[Plant],
    ground_m: f64,
    margin: f64,
) -> Result<f64, IkError> {
    let (frames, nv) = (clip.frames(), model.nv());
    let d = Derivatives::central(clip);
    let mut state = State::new(model);
    let mut tau = vec![0.0; nv];
    let (mut outside, mut com) = (Vec::with_capacity(frames), Vec::with_capacity(frames));
    let mut height = 0.0;
    for f in 0..frames {
        let (v, vd) = (&d.v[f * nv..(f + 1) * nv], &d.vd[f * nv..(f + 1) * nv]);
        state.update(model, clip.pose(f), v);
        state.inverse_dynamics(model, v, vd, &[], &mut tau);
        let c = state.com(model);
        height += (c.y - ground_m) / frames as f64;
        let support = polygon(feet, model, &state);
        let beyond = pressure(&state, &tau, ground_m)
            .map_or(Vec2::zeros(), |(_, p)| clamp_inside(&support, p, margin) - p);
        outside.push(beyond);
        com.push(ground(&c));
    }
    // (1 + 2a) x_i − a (x_{i−1} + x_{i+1}) = outside_i, ends held
    let a = height.max(0.2) / model.gravity.norm().max(1e-9) * clip.rate_hz * clip.rate_hz;
    let moves = solve(&outside, a);
    let furthest = moves.iter().map(|m| m.norm()).fold(0.0, f64::max);
    for f in 0..frames {
        settle(model, &mut state, clip.pose_mut(f), plants, com[f] + moves[f])?;
    }
    Ok(furthest)
}

/// Solves `(1 + 2a) x_i − a (x_{i−1} + x_{i+1}) = b_i` with `x = 0` at both ends (Thomas).
fn solve(b: &[Vec2], a: f64) -> Vec<Vec2> {
    let n = b.len();
    let mut x = vec![Vec2::zeros(); n];
    if n < 3 {
        return x;
    }
    let mut upper = vec![0.0; n];
    for i in 1..n - 1 {
        let pivot = 1.0 + 2.0 * a - a * upper[i - 1];
        upper[i] = a / pivot;
        x[i] = (b[i] + x[i - 1] * a) / pivot;
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

    /// A path that is admissible stays to the bit; the solution satisfies its equation.
    #[test]
    fn the_correction_solves_its_equation() {
        let b: Vec<Vec2> = (0..50).map(|i| Vec2::new((f64::from(i) * 0.3).sin(), f64::from(i % 7))).collect();
        let a = 37.0;
        let x = solve(&b, a);
        assert_eq!((x[0], x[49]), (Vec2::zeros(), Vec2::zeros()));
        for i in 1..49 {
            let residue = x[i] * (1.0 + 2.0 * a) - (x[i - 1] + x[i + 1]) * a - b[i];
            assert!(residue.norm() < 1e-11, "{i}: {residue}"); // 1e-13 seen
        }
        assert_eq!(solve(&[Vec2::zeros(); 9], a), [Vec2::zeros(); 9]);
    }
}
