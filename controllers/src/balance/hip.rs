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
use motion::rotation::exp;
use motion::support::Vec2;
use motion::{Vec3, smoothstep};

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
    /// I, kg·m²; `None` until it is measured.
    pub inertia: Option<Vec2>,
}

/// A body of the spine carries at least this part of the body's mass: the neck does not.
const TRUNK: f64 = 0.25;
/// A lean, rad, or rate that leads to it within [`SOON`], with which the strategy acts whole.
const WHOLE: f64 = 0.1;
const SOON: f64 = 0.05;
/// A moment that starts no lean, N·m.
const NOTHING: f64 = 1e-3;
/// A lean and rate at which the trunk is back, rad and rad/s.
const BACK: f64 = 1e-5;

impl Hip {
    /// A trunk at rest; `state` is scratch.
    pub fn new(model: &Model, state: &mut State) -> Self {
        state.update(model, &model.skeleton.zero_pose(), &vec![0.0; model.nv()]);
        let carried = state.composites(model);
        let in_spine = |&i: &usize| {
            carried[i].0 > TRUNK * model.mass && model.bodies[i].joint == motion::Joint::Spherical
        };
        let spine = (1..model.bodies.len()).filter(in_spine).collect();
        Self { spine, lean: Vec2::zeros(), rate: Vec2::zeros(), push: Vec2::zeros(), inertia: None }
    }

    /// Whether the trunk is where it is asked to be.
    pub fn rests(&self) -> bool {
        [self.lean, self.rate, self.push].iter().all(|x| *x == Vec2::zeros())
    }

    /// How much of the strategy acts, 0 to 1.
    pub fn activity(&self) -> f64 {
        smoothstep((self.lean.norm() + SOON * self.rate.norm()) / WHOLE)
    }

    /// L̇ of the lean, N·m.
    pub fn moment(&self) -> Vec2 {
        self.inertia.map_or(Vec2::zeros(), |i| self.push.component_mul(&i))
    }

    /// One step of `dt` seconds; returns the pressure p, m.
    ///
    /// `wanted`: p*, m. `inside` keeps a pressure in the support. `weight`: N.
    pub fn step(
        &mut self,
        s: &BalanceSettings,
        wanted: Vec2,
        inside: impl Fn(Vec2) -> Vec2,
        weight: f64,
        dt: f64,
    ) -> Vec2 {
        let Some(inertia) = self.inertia else { return inside(wanted) };
        let w = s.hip_return_rad_s;
        let back = -self.lean * (w * w) - self.rate * (2.0 * w);
        let pressure = inside(wanted - back.component_mul(&inertia) / weight);
        let most = Vec2::new(s.hip_side_moment_nm, s.hip_moment_nm);
        let moment = (wanted - pressure) * weight;
        let mut push = (moment / moment.component_div(&most).norm().max(1.0)).component_div(&inertia);
        let speed = self.rate.norm();
        if speed > 0.0 {
            let way = self.rate / speed;
            let brake = s.hip_brake / way.component_mul(&inertia).component_div(&most).norm();
            let ends = self.lean + way * (speed * speed / (2.0 * brake) + speed * s.hip_lag_s);
            if ends.norm() > s.hip_stroke_rad && self.rate.dot(&ends) > 0.0 {
                push = -way * brake.min(speed / dt);
            }
        }
        if self.lean.norm() < BACK && speed < BACK && push.component_mul(&inertia).norm() < NOTHING {
            (self.lean, self.rate, self.push) = (Vec2::zeros(), Vec2::zeros(), Vec2::zeros());
            return pressure;
        }
        self.push += (push - self.push) * -(-dt / s.hip_lag_s).exp_m1();
        self.rate += self.push * dt;
        self.lean += self.rate * dt;
        pressure
    }

    /// Leans the goal's pose `q` by `lean`; `goal` has its kinematics. `pelvis`: its part fore and aft.
    pub fn offset(&self, model: &Model, goal: &State, q: &mut [f64], lean: Vec2, pelvis: f64) {
        let root = Vec2::new(0.0, lean.y * pelvis);
        let each = (lean - root) / self.spine.len().max(1) as f64;
        // one world axis for all: turned by it, an outer joint's axis stays what it was
        let mut turn = |body: usize, by: Vec2| {
            let link = model.bodies[body].link;
            let local = goal.bodies[body].zero.transpose() * axis(by);
            let r = exp(&local) * model.skeleton.rotation(q, link);
            model.skeleton.set_rotation(q, link, &r);
        };
        turn(0, root);
        self.spine.iter().for_each(|&b| turn(b, each));
    }
}

/// Rotation vector, world, of a lean: up × lean.
pub(super) fn axis(lean: Vec2) -> Vec3 {
    Vec3::new(lean.y, 0.0, -lean.x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hip() -> Hip {
        let inertia = Some(Vec2::new(4.0, 5.0));
        Hip { spine: vec![1], lean: Vec2::zeros(), rate: Vec2::zeros(), push: Vec2::zeros(), inertia }
    }

    /// A point of pressure at most `edge` from the middle.
    fn within(edge: f64) -> impl Fn(Vec2) -> Vec2 {
        move |p: Vec2| p / (p.norm() / edge).max(1.0)
    }

    /// Inside the support the trunk stays; beyond, it leans where the body falls, about its stroke far, within its
    /// moment, and comes back once there is room.
    #[test]
    fn the_trunk_leans_only_beyond_the_support() {
        let s = BalanceSettings::default();
        for way in [Vec2::new(0.0, 1.0), Vec2::new(1.0, 0.0), Vec2::new(-0.6, -0.8)] {
            for rate_hz in [120.0, 240.0, 480.0] {
                let (mut hip, dt) = (hip(), 1.0 / rate_hz);
                let run = |hip: &mut Hip, wanted: f64, seconds: f64| {
                    let mut most: f64 = 0.0;
                    for _ in 0..(seconds * rate_hz) as usize {
                        hip.step(&s, way * wanted, within(0.1), 700.0, dt);
                        most = most.max(hip.lean.dot(&way));
                        let m = hip.moment().component_div(&Vec2::new(s.hip_side_moment_nm, s.hip_moment_nm));
                        assert!(m.norm() < 1.0 + 1e-9, "{m:?}");
                    }
                    most
                };
                run(&mut hip, 0.099, 1.0);
                assert!(hip.rests());
                let most = run(&mut hip, 0.6, 1.0);
                // asked for six times what the support gives, it creeps on: 1.15 to 1.26 strokes seen
                assert!(most > 0.8 * s.hip_stroke_rad && most < 1.3 * s.hip_stroke_rad, "{way:?}: {most}");
                assert!(hip.activity() == 1.0);
                run(&mut hip, 0.0, 12.0);
                assert!(hip.rests(), "{hip:?}");
            }
        }
    }

    /// Two roads: the moment given is what the pressure wanted lies beyond the pressure given, times the weight.
    #[test]
    fn pressure_and_moment_share_what_is_wanted() {
        let s = BalanceSettings { hip_lag_s: 1e-9, ..BalanceSettings::default() };
        let mut hip = hip();
        for k in 0..40 {
            let wanted = Vec2::new(0.0, 0.1 + 0.001 * f64::from(k));
            let p = hip.step(&s, wanted, within(0.1), 700.0, 1.0 / 240.0);
            let error = ((wanted - p) * 700.0 - hip.moment()).norm();
            assert!(error < 1e-9, "{k}: {error}"); // 1e-14 seen
        }
    }
}
