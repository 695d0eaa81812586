//! Whether a body that was thrown off its motion came back to it.
//!
//! In: a [`Trace`], when something threw it, how near counts. Out: a [`Rejoined`]. The distance is that of all links' centres of mass from where the
//! motion asked for has them, RMS over the links, in the world: joints and path count.

use crate::walked::apart;
use crate::{Model, State, Trace};

/// How far a body was thrown off its motion, and when it was back. See the module header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rejoined {
    /// The furthest distance after the throw, m.
    pub furthest_m: f64,
    /// When, s.
    pub furthest_s: f64,
    /// From when on it stays within the distance that counts as near, to the end of the trace, s; `None` if it is not back by then.
    pub back_s: Option<f64>,
}

impl Rejoined {
    /// Looks at the rows from `from_s` on; `near_m` is what counts as back. A trace that ends before has been nowhere, and is not back.
    pub fn of(trace: &Trace, from_s: f64, near_m: f64) -> Self {
        let model = Model::new(&trace.character, trace.gravity);
        let mut state = State::new(&model);
        let first = ((from_s * trace.rate_hz).round() as usize).min(trace.rows());
        let mut seen = Self { furthest_m: 0.0, furthest_s: from_s, back_s: None };
        for row in first..trace.rows() {
            let apart_m = links_apart(trace, &model, &mut state, row);
            let t = row as f64 / trace.rate_hz;
            if apart_m > seen.furthest_m {
                (seen.furthest_m, seen.furthest_s) = (apart_m, t);
            }
            seen.back_s = if apart_m <= near_m { seen.back_s.or(Some(t)) } else { None };
        }
        seen
    }
}

/// Distance of link centres from those asked for in a row, over all links with mass, m; zero of a body without any.
fn links_apart(trace: &Trace, model: &Model, state: &mut State, row: usize) -> f64 {
    state.update_pose(model, trace.target_pose(row));
    let bodies = &trace.character.bodies;
    let massive = (0..bodies.len()).filter(|&l| bodies[l].mass > 0.0);
    let squares: Vec<f64> = massive.map(|l| apart(trace, model, state, row, l).norm_squared()).collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}
