//! Hip strategy: the trunk as a flywheel, for what the ankles cannot do.
//!
//! A body whose centre of pressure p is at the edge of its support can still be pushed back by a change of its
//! angular momentum L about the centre of mass: m h c̈ = m g (c − p) − L̇ in any vertical plane. The trunk leans *towards*
//! where the body falls; pelvis and legs go the other way.
//!
//! Symbols, vectors of the ground plane that point where the trunk leans: θ lean of the chest against the pose asked for
//! (rad), I momentum per lean rate (kg·m², fore and aft and to the side), ω_r natural frequency of the way back (rad/s), ξ the
//! capture point, b how far it is beyond what the support catches. The moment has three parts:
//!
//! ```text
//! L̇ = k b m g                                         lean: the support cannot catch it alone
//!   + s (ξ' − inside(ξ' − I α/(m g))) m g             way back α = −ω_r² θ − 2 ω_r θ̇, ξ' = inside(ξ)
//!   − I θ̇²/(2 (θ_max − θ))                            brake, from where the stroke could just still end
//! ```
//!
//! The way back needs room for the pressure, of which it takes the part s. A lean thus begins as hard as it may, coasts while
//! the support brings the body back, and is stopped as late as its stroke allows: every moment counts for the capture
//! point e^{−ω₀ t} as much as at the beginning, and stopping costs what starting gave. Its size is bounded (an ellipse), and
//! it lags a little. θ and θ̇ are those of the simulated body.
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

/// Inputs of one control step.
#[derive(Clone, Copy, Debug)]
pub(super) struct TrunkStep {
    /// ξ, m.
    pub caught: Vec2,
    /// b, m.
    pub beyond: Vec2,
    /// m g, N.
    pub weight: f64,
    pub lean: Lean,
    /// Length of the step, s.
    pub dt: f64,
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

    /// One control step; `inside` keeps a pressure in the support.
    pub fn step(&mut self, s: &BalanceSettings, inside: impl Fn(Vec2) -> Vec2, now: &TrunkStep) {
        let TrunkStep { caught, beyond, weight, lean: Lean { lean, rate }, dt } = *now;
        let Some(inertia) = self.inertia else { return };
        let w = s.hip_return_rad_s;
        let back = -lean * (w * w) - rate * (2.0 * w);
        let from = inside(caught);
        let room = from - inside(from - back.component_mul(&inertia) / weight);
        let most = Vec2::new(s.hip_side_moment_nm, s.hip_moment_nm);
        let needed = if s.hip { beyond * s.hip_gain } else { Vec2::zeros() };
        let moment = (needed + room * s.hip_share) * weight;
        let mut push = (moment / moment.component_div(&most).norm().max(1.0)).component_div(&inertia);
        let speed = rate.norm();
        if speed > 0.0 {
            let way = rate / speed;
            let most = 1.0 / way.component_mul(&inertia).component_div(&most).norm();
            // x: stroke left in the direction of the lean rate, |lean + way x| = stroke
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A trunk whose lean follows the commanded acceleration exactly, and its lean.
    fn hip() -> (Hip, Lean) {
        let inertia = Some(Vec2::new(4.0, 5.0));
        (Hip { spine: vec![1], push: Vec2::zeros(), inertia }, Lean::default())
    }

    /// A point of pressure at most `edge` from the middle.
    fn within(edge: f64) -> impl Fn(Vec2) -> Vec2 {
        move |p: Vec2| p / (p.norm() / edge).max(1.0)
    }

    /// Inside the support the trunk stays; beyond, it leans where the body falls, about its stroke far and within
    /// its moment, and comes back once there is room.
    #[test]
    fn the_trunk_leans_only_beyond_the_support() {
        let s = BalanceSettings::default();
        for way in [Vec2::new(0.0, 1.0), Vec2::new(1.0, 0.0), Vec2::new(-0.6, -0.8)] {
            for rate_hz in [120.0, 240.0, 480.0] {
                let ((mut hip, mut lean), dt) = (hip(), 1.0 / rate_hz);
                let mut run = |caught: f64, seconds: f64| {
                    let mut most: f64 = 0.0;
                    for _ in 0..(seconds * rate_hz) as usize {
                        let caught = way * caught;
                        let beyond = caught - within(0.1)(caught);
                        hip.step(&s, within(0.1), &TrunkStep { caught, beyond, weight: 700.0, lean, dt });
                        lean.rate += hip.push * dt;
                        lean.lean += lean.rate * dt;
                        most = most.max(lean.lean.dot(&way));
                        let bound = Vec2::new(s.hip_side_moment_nm, s.hip_moment_nm);
                        let m = hip.moment().component_div(&bound).norm();
                        assert!(m < 1.0 + 1e-9, "{m}");
                    }
                    (most, lean.lean.norm())
                };
                assert_eq!(run(0.099, 1.0), (0.0, 0.0));
                let (most, _) = run(0.3, 1.0);
                // it overshoots because the moment acts at full size up to the brake: 1.24 strokes seen at 120 Hz
                let stroke = s.hip_stroke_rad;
                assert!(most > 0.9 * stroke && most < 1.3 * stroke, "{way:?}, {rate_hz} Hz: {most}");
                // 3e-3 rad seen after 12 s
                let (_, left) = run(0.0, 20.0);
                assert!(left < 0.01, "{way:?}, {rate_hz} Hz: {left}");
            }
        }
    }

    /// Switched off, it never leans by itself, but still comes back.
    #[test]
    fn without_it_the_trunk_only_comes_back() {
        let s = BalanceSettings { hip: false, ..BalanceSettings::default() };
        let (mut hip, mut lean) = hip();
        let pushed = TrunkStep { caught: Vec2::x(), beyond: Vec2::x(), weight: 700.0, lean, dt: 0.01 };
        hip.step(&s, within(0.1), &pushed);
        assert_eq!(hip.push, Vec2::zeros());
        lean.lean = Vec2::x() * 0.3;
        hip.step(
            &s,
            within(0.1),
            &TrunkStep { caught: Vec2::zeros(), beyond: Vec2::zeros(), lean, ..pushed },
        );
        assert!(hip.push.x < 0.0 && hip.push.y == 0.0, "{:?}", hip.push);
    }
}
