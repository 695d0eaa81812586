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

mod ankle;
mod hip;
mod settings;
mod weight;

use dynamics::{Model, State};
use motion::Vec3;
use motion::ik::IkError;
use motion::plant::{Plant, plant};
use motion::rotation::log;
use motion::skeleton::vec_at;
use motion::support::{Vec2, ground};

pub use settings::BalanceSettings;

use hip::Hip;
use weight::Line;

use crate::antagonist::SetPoints;
use crate::support::{Foot, clamp_inside, polygon, shared_wrenches, shares};
use crate::{Drive, Rest, rest_of};

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
    state: State,
    tau: Vec<f64>,
    goal: Vec<f64>,
    ahead: Vec<f64>,
    still: Vec<f64>,
    hip: Hip,
    leant: Vec<f64>,
    accel: Vec<f64>,
    tau0: Vec<f64>,
    base: State,
    before: Option<Vec2>,
    rose: Option<f64>,
}

impl Balance {
    /// A balance over `feet`, planted at `plants` (same order).
    pub fn new(model: &Model, settings: BalanceSettings, feet: Vec<Foot>, plants: Vec<Plant>) -> Self {
        Self {
            settings,
            feet,
            plants,
            integral: Vec2::zeros(),
            hip: Hip::new(model, &mut State::new(model)),
            leant: model.skeleton.zero_pose(),
            accel: vec![0.0; model.nv()],
            tau0: vec![0.0; model.nv()],
            base: State::new(model),
            before: None,
            rose: None,
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
        self.base.update(model, goal_q, goal_v);
        let asked = ground(&(self.base.momentum(model).linear / model.mass));
        self.base.update(model, goal_q, &self.still);
        let wanted = self.base.com(model);

        self.state.update(model, q, v);
        let momentum = self.state.momentum(model);
        let support = polygon(&self.feet, model, &self.state);
        let com = momentum.com;
        let floor = self.plants.iter().map(|p| p.world_from_end.translation.y).fold(f64::INFINITY, f64::min);
        let g = model.gravity.norm();
        let omega = (g / (com.y - floor).max(0.2)).sqrt();
        let error = ground(&com) - ground(&wanted);
        let rate = ground(&(momentum.linear / model.mass)) / omega;
        let force = (Vec3::y() * lift - model.gravity) * model.mass;
        let mut force = if force.y > 0.0 { force } else { Vec3::zeros() };

        // what the goal does not ask for
        let stray = error + rate - asked * (s.x1 / omega);
        // hip strategy
        if self.hip.inertia == Vec2::zeros() {
            self.measure_inertia(model, goal_q, ground(&wanted))?;
            self.state.update(model, q, v);
        }
        let capture = ground(&com) + rate;
        let mut hip_pressure = capture;
        if s.hip && force.y > 0.0 {
            let want = capture + stray * s.hip_gain;
            let inside = |p| clamp_inside(&support, p, s.margin_m);
            hip_pressure = self.hip.step(&s, want, inside, force.y, dt);
        }
        let leans = !self.hip.rests();
        let acts = self.hip.activity();

        self.integral += error * (s.shift_rate * dt);
        self.integral = limit(self.integral, s.shift_limit_m);
        let shift = limit(-(error * s.shift + rate * s.shift_damping) - self.integral, s.shift_limit_m);
        let shift = if s.ankle { shift } else { Vec2::zeros() };
        let centers: Vec<Vec3> = self.feet.iter().map(|f| f.center(model, &self.state)).collect();
        let line =
            if s.weight_shift { Line::between(&self.feet, &centers, model, &self.state) } else { None };
        // quiet standing is left to the springs: it fades in with the capture point's error along the line
        let fade = line.as_ref().map_or(0.0, |l| s.fade(l.along.dot(&stray)));
        let line = line.filter(|_| fade > 0.0);
        let along = |x: Vec2| line.as_ref().map_or(Vec2::zeros(), |l| l.part(x)) * fade;
        let across = |x: Vec2| (x - line.as_ref().map_or(Vec2::zeros(), |l| l.part(x)) * fade) * acts;
        let mut lean_root = Vec2::zeros();
        if leans {
            lean_root = self.leaning(model, self.hip.lean, goal_q, ground(&wanted))?;
            self.goal.copy_from_slice(&self.leant);
        }
        let root = skeleton.position(&self.goal, 0);
        let gone = along(ground(&(skeleton.position(q, 0) - root))) * s.weight_yield
            + Vec2::zeros();
        let shift = shift - along(shift) * s.weight_yield + gone;
        let root = root + Vec3::new(shift.x, 0.0, shift.y);
        skeleton.set_position(&mut self.goal, 0, &root);
        plant(skeleton, &mut self.goal, &self.plants)?;
        let speed = ground(&vec_at(v, 0));
        let going = along(speed) * (s.weight_yield * AHEAD);
        self.ahead.copy_from_slice(&self.goal);
        if line.is_some() || leans {
            let mut going = going;
            if leans {
                let to = self.leaning(model, self.hip.lean + self.hip.rate * AHEAD, goal_q, ground(&wanted))?;
                going += (to - lean_root) - along(to - lean_root) * s.weight_yield;
                let mut ahead = std::mem::take(&mut self.ahead);
                ahead.copy_from_slice(&self.leant);
                self.ahead = ahead;
            }
            skeleton.set_position(&mut self.ahead, 0, &(root + Vec3::new(going.x, 0.0, going.y)));
            plant(skeleton, &mut self.ahead, &self.plants)?;
        }
        self.accel.fill(0.0);
        let measured = self.before.map_or(Vec2::zeros(), |b| (speed - b) / dt);
        self.before = Some(speed);
        let wants = line.is_some() || leans;
        let mut unforeseen = Vec2::zeros();
        if wants {
            self.leaning(model, self.hip.lean + self.hip.push * AHEAD, goal_q, ground(&wanted))?;
            let mut later = self.leant.clone();
            self.leaning(model, self.hip.lean, goal_q, ground(&wanted))?;
            let foreseen = ground(&(skeleton.position(&later, 0) - skeleton.position(&self.leant, 0))) / AHEAD;
            let extra = measured - foreseen;
            unforeseen = (along(extra) + across(extra)) * s.x3;
            let p = skeleton.position(&later, 0) + Vec3::new(unforeseen.x, 0.0, unforeseen.y) * AHEAD;
            skeleton.set_position(&mut later, 0, &p);
            plant(skeleton, &mut later, &self.plants)?;
            skeleton.difference(&self.leant, &later, AHEAD, &mut self.accel);
        }
        let measured = unforeseen;
        let mut here = self.goal.clone();
        if wants && s.x6 > 0.0 {
            let at = skeleton.q_at(0);
            here[at..at + 7].copy_from_slice(&q[at..at + 7]);
            plant(skeleton, &mut here, &self.plants)?;
        }
        let lifted = momentum.linear.y;
        let up = self.rose.map_or(0.0, |b| (lifted - b) / dt);
        self.rose = Some(lifted);

        // the legs carry the body as it stands
        let pressure = ground(&com)
            + error * s.pressure
            + rate * s.pressure_damping
            + along(error) * (s.weight - s.pressure)
            + along(rate) * (s.weight_damping - s.pressure_damping);
        let pressure = pressure + (hip_pressure - pressure) * acts;
        let pressure = if s.ankle { pressure } else { ground(&com) };
        let pressure = clamp_inside(&support, pressure, s.margin_m);
        let fall = ground(&com) - pressure;
        let thrust = (along(fall) + across(fall)) * (force.y * omega * omega / g);
        let turn = self.hip.moment() * (omega * omega / g * s.x2);
        let thrust = thrust - turn;
        if std::env::var("SHOW").is_ok() {
            eprintln!(
                "H {:.4} {:.4} {:.4} {:.4} {:.4} {:.4} {:.4} {:.4} {:.4} {:.4} {:.4} {:.4} {:.2} {:.4}",
                line.as_ref().map_or(stray.x, |l| l.along.dot(&stray)), stray.norm(), error.x, error.y, rate.x, rate.y, self.hip.lean.x, self.hip.lean.y, self.hip.rate.x,
                self.hip.rate.y, pressure.x, pressure.y, acts, fade
            );
        }
        let side = (fall * (force.y * omega * omega / g) - self.hip.moment() * (omega * omega / g)) * s.x4;
        force += Vec3::new(thrust.x, 0.0, thrust.y);
        self.state.update(model, q, &self.still);
        let sharing = line.as_ref().map_or(pressure, |l| l.sharing(pressure));
        let shares = shares(&centers, pressure + (sharing - pressure) * fade);
        let loads = shared_wrenches(&self.feet, &centers, &shares, pressure, force);
        self.state.inverse_dynamics(model, &self.still, &self.still, &loads, &mut self.tau0);
        self.state.inverse_dynamics(model, &self.still, &self.accel, &loads, &mut self.tau);

        if leans {
            // the spine: its drive turned with the lean, with the load of leaning
            let mut grav0 = self.still.clone();
            let mut grav1 = self.still.clone();
            self.base.inverse_dynamics(model, &self.still, &self.still, &[], &mut grav0);
            let mut spine_accel = self.accel.clone();
            spine_accel[0] -= measured.x * 1.0;
            spine_accel[2] -= measured.y * 1.0;
            let mut spine_tau = self.still.clone();
            self.state.inverse_dynamics(model, &self.still, &spine_accel, &loads, &mut spine_tau);
            let mut leant = State::new(model);
            leant.update(model, &self.goal, &self.still);
            leant.inverse_dynamics(model, &self.still, &self.still, &[], &mut grav1);
            for &body in &self.hip.spine {
                let b = &model.bodies[body];
                let drive = &mut drives[body];
                let Rest::Ball { target, shift } = drive.rest else { continue };
                let (Rest::Ball { target: from, .. }, Rest::Ball { target: to, .. }, Rest::Ball { target: next, .. }) =
                    (rest_of(model, body, goal_q), rest_of(model, body, &self.goal), rest_of(model, body, &self.ahead))
                else {
                    continue;
                };
                let turn = to * from.inverse();
                let rate = log(&(next * to.inverse())) / AHEAD;
                let extra = vec_at(&spine_tau, b.v_at) - vec_at(&self.tau0, b.v_at) + vec_at(&grav1, b.v_at)
                    - vec_at(&grav0, b.v_at);
                let load = -(turn * shift) * drive.stiffness - extra - rate * drive.damping;
                drive.rest = set_points[body].rest(&Rest::ball(turn * target), load, drive.stiffness);
            }
        }

        let load = force + Vec3::y() * ((up - model.mass * lift) * s.x5.clamp(0.0, 1.0)).clamp(-0.5 * force.y, 0.5 * force.y);
        for (f, foot) in self.feet.iter().enumerate() {
            let even = shares[f] * self.feet.len() as f64;
            let part = 1.0 + fade * (1.0 - s.least_share) * (even - 1.0);
            for link in [foot.limb.upper, foot.limb.lower, foot.limb.end] {
                let body = model.body_of[link].0;
                let b = &model.bodies[body];
                let LegMuscle { mut stiffness, mut damping } = muscles[body];
                if let (Some(x), true) = (s.ankle_mgh, link == foot.limb.end) {
                    let set = x * model.mass * g * g / (omega * omega) / self.feet.len() as f64;
                    damping *= (set / stiffness).sqrt();
                    stiffness = set;
                }
                let (stiffness, damping) = (stiffness * part, damping * part);
                let target = rest_of(model, body, &self.goal);
                let free = fade * s.x6 * (1.0 - even / 0.5).max(0.0);
                let target = target.blend(&rest_of(model, body, &here), free);
                let mut rate = dynamics::rnea::joint_force(&b.joint, goal_v, b.v_at);
                if line.is_some() || leans {
                    rate += rate_between(&rest_of(model, body, &self.goal), &rest_of(model, body, &self.ahead));
                }
                let rate = rate * damping;
                let load = -dynamics::rnea::joint_force(&b.joint, &self.tau, b.v_at) - rate;
                drives[body] =
                    Drive { stiffness, damping, rest: set_points[body].rest(&target, load, stiffness) };
            }
            let ankle = model.body_of[foot.limb.end].0;
            self.limit_ankle(model, ankle, foot, load * shares[f], side * shares[f], q, v, &mut drives[ankle]);
        }
        Ok(())
    }

    /// Moment of the whole body's momentum per lean rate.
    fn measure_inertia(&mut self, model: &Model, goal_q: &[f64], over: Vec2) -> Result<(), IkError> {
        for k in 0..2 {
            let mut lean = Vec2::zeros();
            lean[k] = AHEAD;
            self.leaning(model, lean, goal_q, over)?;
            let to = self.leant.clone();
            self.leaning(model, -lean, goal_q, over)?;
            model.skeleton.difference(&self.leant, &to, 2.0 * AHEAD, &mut self.accel);
            let rate = std::mem::take(&mut self.accel);
            self.state.update(model, goal_q, &rate);
            self.accel = rate;
            let spin = self.state.momentum(model).angular;
            lean[k] = 1.0;
            self.hip.inertia[k] = spin.dot(&hip::axis(lean));
        }
        Ok(())
    }

    /// The goal leant by `lean` into `self.leant`, its root moved so that the centre of mass stays over
    /// `over`; returns that move, m.
    fn leaning(&mut self, model: &Model, lean: Vec2, goal_q: &[f64], over: Vec2) -> Result<Vec2, IkError> {
        let mut moved = Vec2::zeros();
        let mut pose = std::mem::take(&mut self.leant);
        for _ in 0..3 {
            pose.copy_from_slice(goal_q);
            self.hip.offset(model, &self.base, &mut pose, lean, self.settings.hip_pelvis);
            let p = model.skeleton.position(&pose, 0) + Vec3::new(moved.x, 0.0, moved.y);
            model.skeleton.set_position(&mut pose, 0, &p);
            plant(&model.skeleton, &mut pose, &self.plants)?;
            self.state.update(model, &pose, &self.still);
            moved += over - ground(&self.state.com(model));
        }
        self.leant = pose;
        Ok(moved)
    }
}

/// Time by which the pelvis is moved on to find the joint rates of its path, s.
const AHEAD: f64 = 1e-4;

/// Rate that leads from one rest to another in [`AHEAD`] seconds, zero frame.
fn rate_between(from: &Rest, to: &Rest) -> Vec3 {
    match (from, to) {
        (Rest::Scalar(a), Rest::Scalar(b)) => Vec3::x() * ((b - a) / AHEAD),
        (Rest::Ball { target: a, .. }, Rest::Ball { target: b, .. }) => log(&(b * a.inverse())) / AHEAD,
        _ => Vec3::zeros(),
    }
}

fn limit(x: Vec2, length: f64) -> Vec2 {
    let n = x.norm();
    if n > length { x * (length / n) } else { x }
}
