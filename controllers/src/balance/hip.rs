//! Hip strategy: the trunk as a flywheel, for what the ankles cannot do.
//!
//! A body whose centre of pressure p is at the edge of its support can still be pushed back by a change of its
//! angular momentum L about the centre of mass: m h c̈ = m g (c − p) − L̇ in any vertical plane. The trunk leans *towards*
//! where the body falls; pelvis and legs go the other way.
//!
//! Symbols, vectors of the ground plane that point where the trunk leans: θ lean of the chest against the pose asked for
//! (rad), I momentum per lean rate (kg·m², fore and aft and to the side), ω_r natural frequency of the way back (rad/s), p* the
//! pressure that the capture point asks for. The way back α = −ω_r² θ − 2 ω_r θ̇ needs the pressure p* − I α/(m g);
//! what the support cannot give of it is left to the trunk:
//!
//! ```text
//! p = inside(p* − I α/(m g)),   I θ̈ = (p* − p) m g
//! ```
//!
//! With room under the feet this is the way back itself, at the edge a push. Its moment is bounded and lags a little; before
//! the stroke ends it brakes, at a distance of θ̇²/2θ̈.
//!
//! J. Pratt, J. Carff, S. Drakunov, A. Goswami. Capture point: a step toward humanoid push recovery. Humanoids 2006.

use dynamics::{Model, State};
use motion::Vec3;
use motion::support::Vec2;

use super::BalanceSettings;

/// The hip strategy of a trunk. See the module header.
#[derive(Clone, Debug)]
pub(super) struct Hip {
    /// Bodies of the spine, from the pelvis up.
    pub spine: Vec<usize>,
    /// θ̈, rad/s².
    pub push: Vec2,
    /// I, kg·m²; `None` until it is measured.
    pub inertia: Option<Vec2>,
}

/// A body of the spine carries at least this part of the body's mass: the neck does not.
const TRUNK: f64 = 0.25;

/// Lean of the trunk and its rate, rad and rad/s.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lean {
    pub lean: Vec2,
    pub rate: Vec2,
}

impl Hip {
    /// A trunk at rest; `state` is scratch.
    pub fn new(model: &Model, state: &mut State) -> Self {
        state.update(model, &model.skeleton.zero_pose(), &vec![0.0; model.nv()]);
        let carried = state.composites(model);
        let in_spine = |&i: &usize| {
            carried[i].0 > TRUNK * model.mass && model.bodies[i].joint == motion::Joint::Spherical
        };
        let spine = (1..model.bodies.len()).filter(in_spine).collect();
        Self { spine, push: Vec2::zeros(), inertia: None }
    }

    /// L̇ of the lean, N·m.
    pub fn moment(&self) -> Vec2 {
        self.inertia.map_or(Vec2::zeros(), |i| self.push.component_mul(&i))
    }

    /// One step of `dt` seconds.
    ///
    /// `caught`: capture point ξ, m. `beyond`: how far it is beyond what the support can catch, m. `inside` keeps a
    /// pressure in the support. `weight`: N.
    #[expect(clippy::too_many_arguments, reason = "a step's inputs, each used once")]
    pub fn step(
        &mut self,
        s: &BalanceSettings,
        caught: Vec2,
        beyond: Vec2,
        inside: impl Fn(Vec2) -> Vec2,
        weight: f64,
        Lean { lean, rate }: Lean,
        dt: f64,
    ) {
        let Some(inertia) = self.inertia else { return };
        let w = s.hip_return_rad_s;
        let back = -lean * (w * w) - rate * (2.0 * w);
        let from = inside(caught);
        let room = from - inside(from - back.component_mul(&inertia) / weight);
        let most = Vec2::new(s.hip_side_moment_nm, s.hip_moment_nm);
        let moment = (if s.hip { beyond * s.hip_gain } else { Vec2::zeros() } + room * s.hip_share) * weight;
        let mut push = (moment / moment.component_div(&most).norm().max(1.0)).component_div(&inertia);
        let speed = rate.norm();
        if speed > 0.0 {
            let way = rate / speed;
            let most = 1.0 / way.component_mul(&inertia).component_div(&most).norm();
            // what is left of the stroke along the way: |lean + way x| = stroke
            let along = lean.dot(&way);
            let left =
                (s.hip_stroke_rad.powi(2) - lean.norm_squared() + along * along).max(0.0).sqrt() - along;
            let needed = speed * speed / (2.0 * (left - speed * s.hip_lag_s).max(1e-3));
            if needed > s.hip_brake * most {
                let brake = needed.min(most).min(speed / dt);
                push -= way * (push.dot(&way) + brake).max(0.0);
            }
        }
        self.push += (push - self.push) * -(-dt / s.hip_lag_s).exp_m1();
    }
}

/// Rotation vector, world, of a lean: up × lean.
pub(super) fn axis(lean: Vec2) -> Vec3 {
    Vec3::new(lean.y, 0.0, -lean.x)
}
