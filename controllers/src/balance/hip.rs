//! Hip strategy: the trunk as a flywheel, beyond what the ankles can do.
//!
//! A body whose centre of pressure p is on the edge of its support can still be pushed back by a change of
//! its angular momentum: m h c̈ = m g (c − p) − L̇ about a horizontal axis. The trunk leans *towards* where
//! the body falls, the hips go the other way.
//!
//! Symbols: θ lean of the chest against the pose asked for (rad; a vector of the ground plane that points
//! where it leans), I moment of the whole body's momentum per lean rate (kg·m²), ω_r frequency of the return
//! (rad/s). The centre of pressure wanted, p*, comes from the capture point. Leaning back by
//! α = −ω_r² θ − 2 ω_r θ̇ needs the pressure p* − I α/(m g) on the ground; what the support cannot give of it
//! is left to the trunk:
//!
//! ```text
//! p = inside(p* − I α/(m g)),   θ̈ = (p* − p) m g / I
//! ```
//!
//! bounded in torque and by a stroke it brakes for in time.
//!
//! J. Pratt et al. Capture point: a step toward humanoid push recovery. Humanoids 2006.

use dynamics::{Model, State};
use motion::Vec3;
use motion::rotation::exp;
use motion::support::Vec2;

use super::BalanceSettings;

/// The lean of the trunk. See the module header.
#[derive(Clone, Debug)]
pub(super) struct Hip {
    /// Bodies of the spine, from the pelvis up.
    pub spine: Vec<usize>,
    /// θ, rad.
    pub lean: Vec2,
    /// θ̇, rad/s.
    pub rate: Vec2,
    /// θ̈, rad/s².
    pub push: Vec2,
    /// I to the side and fore and aft, kg·m².
    pub inertia: Vec2,
}

/// A trunk link carries at least this part of the body's mass.
const TRUNK: f64 = 0.25;

impl Hip {
    pub fn new(model: &Model, state: &mut State) -> Self {
        state.update(model, &model.skeleton.zero_pose(), &vec![0.0; model.nv()]);
        let carried = state.composites(model);
        let spine = (1..model.bodies.len())
            .filter(|&i| carried[i].0 > TRUNK * model.mass && model.bodies[i].joint.nv() == 3)
            .collect();
        Self { spine, lean: Vec2::zeros(), rate: Vec2::zeros(), push: Vec2::zeros(), inertia: Vec2::zeros() }
    }

    /// Whether the trunk is where it is asked to be.
    pub fn rests(&self) -> bool {
        self.lean == Vec2::zeros() && self.rate == Vec2::zeros() && self.push == Vec2::zeros()
    }

    /// How much of the strategy acts, 0 to 1.
    pub fn activity(&self) -> f64 {
        let t = ((self.lean.norm() + 0.05 * self.rate.norm()) / 0.1).min(1.0);
        t * t * (3.0 - 2.0 * t)
    }

    /// I θ̈, N·m.
    pub fn moment(&self) -> Vec2 {
        self.push.component_mul(&self.inertia)
    }

    /// One step of the flywheel; returns the centre of pressure p.
    pub fn step(
        &mut self,
        s: &BalanceSettings,
        wanted: Vec2,
        inside: impl Fn(Vec2) -> Vec2,
        weight: f64,
        dt: f64,
    ) -> Vec2 {
        let w = s.hip_return;
        let back = -self.lean * (w * w) - self.rate * (2.0 * w);
        let pressure = inside(wanted - back.component_mul(&self.inertia) / weight);
        let most = Vec2::new(s.hip_side_nm, s.hip_torque_nm).component_div(&self.inertia);
        let bounded = |x: Vec2| x / x.component_div(&most).norm().max(1.0);
        let mut push = bounded(((wanted - pressure) * weight).component_div(&self.inertia));
        // brake in time: θ̇²/2a before the stroke ends
        let speed = self.rate.norm();
        if speed > 1e-6 {
            let way = self.rate / speed;
            let brake = s.hip_brake / way.component_div(&most).norm();
            let ends = self.lean + way * (speed * speed / (2.0 * brake) + speed * s.hip_delay);
            if ends.norm() > s.hip_stroke_rad && self.rate.dot(&ends) > 0.0 {
                push = -way * brake.min(speed / dt);
            }
        }
        if self.rests() && push.norm() < 1e-3 {
            self.push = Vec2::zeros();
            return pressure;
        }
        self.push += (push - self.push) * -(-dt / s.hip_delay).exp_m1();
        self.rate += self.push * dt;
        self.lean += self.rate * dt;
        pressure
    }

    /// Leans the pose `q` by `lean`, the pelvis by the part `share` of it; `zero` has the goal's kinematics.
    pub fn offset(&self, model: &Model, zero: &State, q: &mut [f64], lean: Vec2, share: [f64; 2]) {
        // (y × lean) turns towards it; z: fore and aft, x: to the side
        let n = self.spine.len().max(1) as f64;
        let pelvis = Vec2::new(lean.x * share[0], lean.y * share[1]);
        let each = (lean - pelvis) / n;
        let mut turn = |body: usize, by: Vec2| {
            let link = model.bodies[body].link;
            let local = zero.bodies[body].zero.transpose() * axis(by);
            let r = exp(&local) * model.skeleton.rotation(q, link);
            model.skeleton.set_rotation(q, link, &r);
        };
        turn(0, pelvis);
        for &b in &self.spine {
            turn(b, each);
        }
    }
}

/// Rotation vector, world, of a lean.
pub(super) fn axis(lean: Vec2) -> Vec3 {
    Vec3::new(lean.y, 0.0, -lean.x)
}
