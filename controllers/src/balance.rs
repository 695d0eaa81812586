//! Balance: a reactive movement property that keeps the centre of mass over the feet \[NF03 §4.2\].
//!
//! It reads the simulated state every step and writes the drives of the stance legs:
//!
//! 1. *Pelvis shift* (ankles and hips): the legs' goals are solved for a root moved against the error
//!    of the centre of mass, `Δ = −(p e + d ė/ω₀) − i ∫e`, ω₀ = √(g/h), e = c − c*.
//! 2. *Support load*: the legs carry the body as it is now. RNEA at the simulated pose with the ground
//!    reaction at a centre of pressure `c + g_p e + g_d ė/ω₀`, clamped inside the soles, split between the
//!    feet (see [`crate::support`]).
//! 3. *Weight shift* between two feet, for what goes along the line between them (unit n). Two legs and a
//!    pelvis are a parallelogram there: its springs and dampers would pull an unloaded foot along. So the
//!    legs let the pelvis go (their goals and rates take on its own way along n) and answer through the
//!    ground alone: centre of pressure `c + g_p e + g_d ė/ω₀` with gains of its own, and with it the
//!    horizontal force m ω₀² (c − p) that points to the centre of mass, so that the trunk is not turned.
//!    Pressure moves under both soles and between the feet in proportion, so that both come to their ends
//!    together; stiffness and damping follow the load.
//! 4. *Ankle limit*: the torque of each ankle is limited so that its own centre of pressure stays
//!    inside its sole; a stiff ankle would tip the foot.
//!
//! In: state, goal pose, feet. Out: drives of the legs. No clock and no engine; the integral is its only
//! memory. World frame.

use dynamics::{Model, State};
use motion::Vec3;
use motion::ik::IkError;
use motion::plant::{Plant, plant};
use motion::skeleton::{quat_at, vec_at};
use motion::support::{Support, Vec2, ground};

use crate::antagonist::SetPoints;
use crate::reactive::{AHEAD, Moment, Reactive, rate_between};
use crate::support::{Foot, clamp_inside, polygon, shared_wrenches, shares};
use crate::{Drive, Rest, rest_of};

/// Parameters of the balance property.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BalanceSettings {
    /// Pelvis shift per centre-of-mass error, m/m; higher pulls back harder, too high sways.
    pub shift: f64,
    /// Pelvis shift per centre-of-mass velocity over ω₀, m/m; higher damps sway.
    pub shift_damping: f64,
    /// Rate at which a lasting error is removed, 1/s; higher removes it sooner, too high sways.
    pub shift_rate: f64,
    /// Largest pelvis shift, m.
    pub shift_limit_m: f64,
    /// Centre-of-pressure shift per centre-of-mass error, m/m; above 0 pushes the body back.
    pub pressure: f64,
    /// Centre-of-pressure shift per velocity over ω₀, m/m; 1 follows the capture point.
    pub pressure_damping: f64,
    /// The centre of pressure stays this far inside the soles, m.
    pub margin_m: f64,
    /// Weight shift between two feet against errors along the line between them. Off, the legs answer them
    /// like any other, and pushes to the side drag the foot that lost its load.
    pub weight_shift: bool,
    /// Speed of the capture point's error along the line between the feet at which the weight shift wakes, m/s;
    /// lower answers to what the motion itself stirs up (a wild twist: 0.3), higher to hard pushes only.
    pub weight_from_m_s: f64,
    /// Speed at which it acts whole, m/s; nearer to [`Self::weight_from_m_s`] is more abrupt.
    pub weight_full_m_s: f64,
    /// Awake it stays until the capture point's error along the line is below this, m; higher leaves the rest
    /// of the way to the springs.
    pub weight_rest_m: f64,
    /// Centre-of-pressure shift per centre-of-mass error along the line between the feet, m/m, with
    /// [`Self::weight_shift`]; higher returns sooner, too high lifts the foot that is left.
    pub weight: f64,
    /// The same per velocity over ω₀, m/m; 1 holds the capture point where it is, more brings it back.
    pub weight_damping: f64,
    /// How far the legs let the pelvis go along the line between the feet instead of pulling it back with
    /// their springs, in [0, 1], with [`Self::weight_shift`]; lower drags the unloaded foot sooner.
    pub weight_yield: f64,
    /// Least part of its evenly shared stiffness and damping a leg keeps when its foot is unloaded, in
    /// [0, 1], with [`Self::weight_shift`]; lower leaves it limp, 1 does not shift them.
    pub least_share: f64,
}

impl Default for BalanceSettings {
    fn default() -> Self {
        Self {
            shift: 0.4,
            shift_damping: 0.3,
            shift_rate: 0.5,
            shift_limit_m: 0.08,
            pressure: 0.3,
            pressure_damping: 0.8,
            margin_m: 0.01,
            weight_shift: true,
            weight_from_m_s: 0.4,
            weight_full_m_s: 0.5,
            weight_rest_m: 0.01,
            weight: 1.5,
            weight_damping: 2.5,
            weight_yield: 1.0,
            least_share: 0.25,
        }
    }
}

/// What a balance step needs to know of one leg's muscles.
#[derive(Clone, Copy, Debug)]
pub struct LegMuscle {
    /// Stiffness, N·m/rad.
    pub stiffness: f64,
    /// Damping, N·m·s/rad.
    pub damping: f64,
}

/// The balance property. See the module header.
#[derive(Clone, Debug)]
pub struct Balance {
    settings: BalanceSettings,
    feet: Vec<Foot>,
    plants: Vec<Plant>,
    integral: Vec2,
    wake: Wake,
    state: State,
    tau: Vec<f64>,
    goal: Vec<f64>,
    ahead: Vec<f64>,
    still: Vec<f64>,
}

impl Balance {
    /// A balance over `feet`, planted at `plants` (same order).
    pub fn new(model: &Model, settings: BalanceSettings, feet: Vec<Foot>, plants: Vec<Plant>) -> Self {
        Self {
            settings,
            feet,
            plants,
            integral: Vec2::zeros(),
            wake: Wake::default(),
            state: State::new(model),
            tau: vec![0.0; model.nv()],
            goal: model.skeleton.zero_pose(),
            ahead: model.skeleton.zero_pose(),
            still: vec![0.0; model.nv()],
        }
    }

    /// Bodies of the legs it drives: thigh, shin, foot of each foot.
    pub fn bodies(&self, model: &Model) -> Vec<usize> {
        self.feet
            .iter()
            .flat_map(|f| [f.limb.upper, f.limb.lower, f.limb.end].map(|l| model.body_of[l].0))
            .collect()
    }

    /// Writes the drives of the stance legs for the next step of `dt` seconds.
    ///
    /// `q`, `v`: simulated state. `goal_q`, `goal_v`: pose and velocity asked for at the end of the step.
    /// `lift`: vertical acceleration of the goal's centre of mass, m/s². `muscles`: per body.
    ///
    /// # Errors
    /// Limbs that two-bone IK cannot solve.
    #[expect(clippy::too_many_arguments, reason = "a step's inputs, each used once")]
    pub fn update(
        &mut self,
        model: &Model,
        set_points: &[SetPoints],
        muscles: &[LegMuscle],
        (q, v): (&[f64], &[f64]),
        (goal_q, goal_v): (&[f64], &[f64]),
        lift: f64,
        dt: f64,
        drives: &mut [Drive],
    ) -> Result<(), IkError> {
        let s = self.settings;
        let skeleton = &model.skeleton;
        self.goal.copy_from_slice(goal_q);
        self.state.update(model, goal_q, &self.still);
        let wanted = self.state.com(model);

        self.state.update(model, q, v);
        let momentum = self.state.momentum(model);
        let support = polygon(&self.feet, model, &self.state);
        let com = momentum.com;
        let floor = self.plants.iter().map(|p| p.world_from_end.translation.y).fold(f64::INFINITY, f64::min);
        let g = model.gravity.norm();
        let omega = (g / (com.y - floor).max(0.2)).sqrt();
        let error = ground(&com) - ground(&wanted);
        let rate = ground(&(momentum.linear / model.mass)) / omega;

        self.integral += error * (s.shift_rate * dt);
        self.integral = limit(self.integral, s.shift_limit_m);
        let shift = limit(-(error * s.shift + rate * s.shift_damping) - self.integral, s.shift_limit_m);
        let centers: Vec<Vec3> = self.feet.iter().map(|f| f.center(model, &self.state)).collect();
        let line =
            if s.weight_shift { Line::between(&self.feet, &centers, model, &self.state) } else { None };
        // what the motion itself stirs up is left to the springs
        let fade = line.as_ref().map_or(0.0, |l| self.wake.update(&s, l.along.dot(&(error + rate)), dt));
        let line = line.filter(|_| fade > 0.0);
        let along = |x: Vec2| line.as_ref().map_or(Vec2::zeros(), |l| l.part(x)) * fade;
        let root = skeleton.position(goal_q, 0);
        let gone = along(ground(&(skeleton.position(q, 0) - root))) * s.weight_yield;
        let shift = shift - along(shift) * s.weight_yield + gone;
        let root = root + Vec3::new(shift.x, 0.0, shift.y);
        skeleton.set_position(&mut self.goal, 0, &root);
        plant(skeleton, &mut self.goal, &self.plants)?;
        let going = along(ground(&vec_at(v, 0))) * (s.weight_yield * AHEAD);
        self.ahead.copy_from_slice(&self.goal);
        if line.is_some() {
            skeleton.set_position(&mut self.ahead, 0, &(root + Vec3::new(going.x, 0.0, going.y)));
            plant(skeleton, &mut self.ahead, &self.plants)?;
        }

        // the legs carry the body as it stands
        let pressure = ground(&com)
            + error * s.pressure
            + rate * s.pressure_damping
            + along(error) * (s.weight - s.pressure)
            + along(rate) * (s.weight_damping - s.pressure_damping);
        let pressure = clamp_inside(&support, pressure, s.margin_m);
        let force = (Vec3::y() * lift - model.gravity) * model.mass;
        let mut force = if force.y > 0.0 { force } else { Vec3::zeros() };
        let thrust = along(ground(&com) - pressure) * (force.y * omega * omega / g);
        force += Vec3::new(thrust.x, 0.0, thrust.y);
        self.state.update(model, q, &self.still);
        let sharing = line.as_ref().map_or(pressure, |l| l.sharing(pressure));
        let shares = shares(&centers, pressure + (sharing - pressure) * fade);
        let loads = shared_wrenches(&self.feet, &centers, &shares, pressure, force);
        self.state.inverse_dynamics(model, &self.still, &self.still, &loads, &mut self.tau);

        for (f, foot) in self.feet.iter().enumerate() {
            let even = shares[f] * self.feet.len() as f64;
            let part = 1.0 + fade * (1.0 - s.least_share) * (even - 1.0);
            for link in [foot.limb.upper, foot.limb.lower, foot.limb.end] {
                let body = model.body_of[link].0;
                let b = &model.bodies[body];
                let LegMuscle { stiffness, damping } = muscles[body];
                let (stiffness, damping) = (stiffness * part, damping * part);
                let target = rest_of(model, body, &self.goal);
                let mut rate = dynamics::rnea::joint_force(&b.joint, goal_v, b.v_at);
                if line.is_some() {
                    rate += rate_between(&target, &rest_of(model, body, &self.ahead));
                }
                let rate = rate * damping;
                let load = -dynamics::rnea::joint_force(&b.joint, &self.tau, b.v_at) - rate;
                drives[body] =
                    Drive { stiffness, damping, rest: set_points[body].rest(&target, load, stiffness) };
            }
            let ankle = model.body_of[foot.limb.end].0;
            self.limit_ankle(model, ankle, foot, force.y * shares[f], q, v, &mut drives[ankle]);
        }
        Ok(())
    }

    /// Limits the ankle's torque so that the foot's own centre of pressure stays inside its sole.
    ///
    /// For a foot of little mass under a vertical force F, τ = −r × F ŷ: r_z = τ_x/F, r_x = −τ_z/F, with
    /// r from the ankle to the centre of pressure.
    #[expect(clippy::too_many_arguments, reason = "a step's inputs, each used once")]
    fn limit_ankle(
        &self,
        model: &Model,
        body: usize,
        foot: &Foot,
        force: f64,
        q: &[f64],
        v: &[f64],
        drive: &mut Drive,
    ) {
        let b = &model.bodies[body];
        let (Rest::Ball { .. }, true) = (drive.rest, force > 1.0) else { return };
        let now = quat_at(q, b.q_at);
        let omega = vec_at(v, b.v_at);
        let torque = drive.pull(&now) * drive.stiffness - omega * drive.damping;
        let zero = self.state.bodies[body].zero;
        let mut world = zero * torque;
        let ankle = ground(&self.state.bodies[body].world.translation.vector);
        let pressure = ankle + Vec2::new(-world.z / force, world.x / force);
        let corners = foot.corners_in_world(model, &self.state);
        let inside = clamp_inside(&Support::of(corners.iter()), pressure, self.settings.margin_m);
        if inside == pressure {
            return;
        }
        let r = inside - ankle;
        world.x = r.y * force;
        world.z = -r.x * force;
        let torque = zero.transpose() * world + omega * drive.damping;
        drive.rest = Rest::Ball { target: now, shift: torque / drive.stiffness };
    }
}

impl Reactive for Balance {
    fn react(&mut self, m: &Moment<'_>, drives: &mut [Drive]) -> Result<(), IkError> {
        let (state, goal) = ((m.q, m.v), (m.goal_q, m.goal_v));
        self.update(m.model, m.set_points, m.muscles, state, goal, m.lift, m.dt, drives)
    }
}

/// The line between two feet, on the ground.
struct Line {
    middle: Vec2,
    along: Vec2,
    /// Fraction of a shift of pressure that happens under each sole; the rest is weight that changes feet.
    rolling: f64,
}

impl Line {
    /// `None` unless there are two feet apart.
    fn between(feet: &[Foot], centers: &[Vec3], model: &Model, state: &State) -> Option<Self> {
        let [a, b] = centers else { return None };
        let (a, b) = (ground(a), ground(b));
        let half = 0.5 * (b - a).norm();
        let along = (b - a).try_normalize(1e-6)?;
        let reach = |foot: &Foot, center: Vec2| {
            let beyond = foot
                .corners
                .iter()
                .map(|(link, at)| (ground(&state.point(model, *link, at)) - center).dot(&along).abs());
            beyond.fold(0.0, f64::max)
        };
        let sole = 0.5 * (reach(&feet[0], a) + reach(&feet[1], b));
        Some(Self { middle: (a + b) * 0.5, along, rolling: sole / (sole + half) })
    }

    /// Part of `x` along the line.
    fn part(&self, x: Vec2) -> Vec2 {
        self.along * self.along.dot(&x)
    }

    /// The point whose distances share the weight for a centre of pressure `p`: both soles and the shares
    /// reach their ends together, so the foot that is left keeps weight as long as it can.
    fn sharing(&self, p: Vec2) -> Vec2 {
        p - self.part(p - self.middle) * self.rolling
    }
}

/// How much of the weight shift acts: a push tells itself from the motion asked for by how fast the capture
/// point runs off, ξ̇ = F/(m ω₀), long before by how far.
#[derive(Clone, Copy, Debug, Default)]
struct Wake {
    /// Error of the capture point, m, followed with the time constant [`SUDDEN`]; `None` before the first step.
    followed: Option<f64>,
    level: f64,
}

/// Time over which the speed of the capture point is taken, s.
const SUDDEN: f64 = 0.02;
/// Time constant with which the weight shift falls asleep, s.
const CALM: f64 = 0.3;

impl Wake {
    /// Level in 0 to 1 after a step of `dt` with the error `x`, m.
    fn update(&mut self, s: &BalanceSettings, x: f64, dt: f64) -> f64 {
        let followed = self.followed.get_or_insert(x);
        // in the steady state of a ramp this is its slope, at any step
        let gain = 1.0 - (-dt / SUDDEN).exp();
        let speed = (x - *followed) * (gain / dt);
        *followed += (x - *followed) * gain;
        let t = ((speed.abs() - s.weight_from_m_s) / (s.weight_full_m_s - s.weight_from_m_s)).clamp(0.0, 1.0);
        if x.abs() < s.weight_rest_m {
            self.level *= (-dt / CALM).exp();
            if self.level < 1e-3 {
                self.level = 0.0;
            }
        }
        self.level = self.level.max(t * t * (3.0 - 2.0 * t));
        self.level
    }
}

fn limit(x: Vec2, length: f64) -> Vec2 {
    let n = x.norm();
    if n > length { x * (length / n) } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Level after `seconds` of an error that grows by `speed` metres a second.
    fn after(speed: f64, seconds: f64, rate_hz: f64) -> (Wake, f64) {
        let mut wake = Wake::default();
        let mut level = 0.0;
        for k in 0..(seconds * rate_hz) as usize {
            level = wake.update(&BalanceSettings::default(), speed * k as f64 / rate_hz, 1.0 / rate_hz);
        }
        (wake, level)
    }

    /// What runs off slowly never wakes it, however far; what runs off fast does within 50 ms, at any rate; and it
    /// sleeps again once the error is gone.
    #[test]
    fn the_weight_shift_wakes_for_what_is_sudden() {
        let s = BalanceSettings::default();
        for rate_hz in [120.0, 240.0, 480.0] {
            assert_eq!(after(0.99 * s.weight_from_m_s, 1.0, rate_hz).1, 0.0);
            let (mut wake, level) = after(1.2 * s.weight_full_m_s, 0.05, rate_hz);
            assert_eq!(level, 1.0, "{rate_hz} Hz");
            for _ in 0..(10.0 * rate_hz) as usize {
                wake.update(&s, 2.0 * s.weight_rest_m, 1.0 / rate_hz);
            }
            assert_eq!(wake.level, 1.0, "awake while there is an error");
            for _ in 0..(3.0 * rate_hz) as usize {
                wake.update(&s, 0.0, 1.0 / rate_hz);
            }
            assert_eq!(wake.level, 0.0);
        }
    }
}
