//! Balance: a reactive movement property that keeps the centre of mass over the feet \[NF03 §4.2\].
//!
//! It reads the simulated state every step and writes the drives of the stance legs, and of the spine while it leans:
//!
//! 1. *Pelvis shift* (ankles and hips): the legs' goals are solved for a root moved against the error
//!    of the centre of mass, `Δ = −(p e + d ė/ω₀) − i ∫e`, ω₀ = √(g/h), e = c − c*.
//! 2. *Support load*: the legs carry the body as it is now. RNEA at the simulated pose with the ground
//!    reaction at a centre of pressure `c + g_p e + g_d ė/ω₀`, clamped inside the soles, split between the
//!    feet (see [`crate::support`]). Both together are the ankle strategy.
//! 3. *Weight shift* between two feet, for what goes along the line between them (unit n). Two legs and a
//!    pelvis are a parallelogram there: its springs and dampers would pull an unloaded foot along. So the
//!    legs let the pelvis go (their goals and rates take on its own way along n) and answer through the
//!    ground alone: centre of pressure `c + g_p e + g_d ė/ω₀` with gains of its own, and with it the
//!    horizontal force m ω₀² (c − p) that points to the centre of mass, so that the trunk is not turned.
//!    Pressure moves under both soles and between the feet in proportion, so that both come to their ends
//!    together; stiffness and damping follow the load. The legs' own inertia is fed forward with the acceleration
//!    the pelvis has: left out, it takes 40 mm from the pressure of a push to the side.
//! 4. *Hip strategy*: where the pressure asked for lies beyond the support, the trunk leans as a flywheel. The goals lean with
//!    it, the pelvis moved so that the centre of mass stays; the ground takes the horizontal force −L̇/h.
//! 5. *Ankle limit*: the torque of each ankle is limited so that its own centre of pressure stays
//!    inside its sole; a stiff ankle would tip the foot.
//!
//! Feet that lie flat tell how the ground lies, which may turn: the legs' goals are over the feet as they stand.
//!
//! A goal that moves through its own dynamics (a captured clip) comes with a [`Feed`], see [`Balance::follow`]: errors
//! and their rates are then to the moving goal, the force and the lead of its centre of pressure over its centre of
//! mass are added, and the feet share the load by the pressures of their corners ([`pressed_wrenches`]), which reach
//! the corners of the support where an equal offset of both feet leaves one sole too soon.
//!
//! In: state, contacts, goal pose, feet. Out: drives of the legs and the spine. No clock and no engine; its memory is the integral,
//! the lean, how far the answers to pushes are awake and the pelvis' last velocity. World frame.

mod ankle;
mod hip;
mod settings;
mod soles;
mod weight;

use dynamics::rnea::joint_force;
use dynamics::{ContactSample, Model, State};
use motion::Vec3;
use motion::ik::IkError;
use motion::plant::{Plant, plant};
use motion::rotation::log;
use motion::skeleton::vec_at;
use motion::support::{Vec2, ground};

use crate::antagonist::SetPoints;
use crate::reactive::{AHEAD, Moment, Reactive, rate_between};
use crate::support::{Foot, clamp_inside, polygon, pressed_wrenches, shared_wrenches, shares};
use crate::{Drive, Feed, Rest, rest_of};

use hip::Hip;
pub use settings::{BalanceSettings, Strategy, StrategyError};
use soles::Soles;
use weight::{Line, Wake};

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
    soles: Soles,
    integral: Vec2,
    feed: Option<Feed>,
    /// What wakes the weight shift, and the hip strategy.
    wake: [Wake; 2],
    hip: Hip,
    /// Velocity of the pelvis a step ago, m/s.
    before: Option<Vec2>,
    /// Kinematics as simulated, as asked for, and of whatever pose is tried.
    now: State,
    asked: State,
    tried: State,
    goal: Vec<f64>,
    ahead: Vec<f64>,
    leant: Vec<f64>,
    later: Vec<f64>,
    still: Vec<f64>,
    accel: Vec<f64>,
    tau: Vec<f64>,
    /// Spine: loads of the pose asked for, of the pose leant to, and without and with the lean's acceleration.
    loads: [Vec<f64>; 4],
}

/// How the body sways, on the ground plane, m.
struct Sway {
    com: Vec3,
    /// Where the centre of mass should be.
    over: Vec2,
    /// e = c − c*.
    error: Vec2,
    /// ċ/ω₀.
    rate: Vec2,
    /// Error of the capture point, what the goal's own way asks for left out.
    stray: Vec2,
    omega: f64,
}

impl Balance {
    /// A balance over `feet`, planted at `plants` (same order).
    pub fn new(model: &Model, settings: BalanceSettings, feet: Vec<Foot>, plants: Vec<Plant>) -> Self {
        let pose = || model.skeleton.zero_pose();
        let rates = || vec![0.0; model.nv()];
        let mut tried = State::new(model);
        Self {
            settings,
            soles: Soles::new(&feet, &plants),
            feet,
            plants,
            integral: Vec2::zeros(),
            feed: None,
            wake: [Wake::default(); 2],
            hip: Hip::new(model, &mut tried),
            before: None,
            now: State::new(model),
            asked: State::new(model),
            tried,
            goal: pose(),
            ahead: pose(),
            leant: pose(),
            later: pose(),
            still: rates(),
            accel: rates(),
            tau: rates(),
            loads: [rates(), rates(), rates(), rates()],
        }
    }

    /// What the goal's own motion needs of the ground in the next step; `None` for a goal that stands still or
    /// moves slowly. Errors are then those to the moving goal.
    pub fn follow(&mut self, feed: Option<Feed>) {
        self.feed = feed;
    }

    /// Takes in how the soles pressed in the last step: where they lie flat, they tell how the ground lies.
    fn feel(&mut self, model: &Model, q: &[f64], touching: &[ContactSample]) {
        if touching.is_empty() {
            return;
        }
        self.now.update(model, q, &self.still);
        self.soles.feel(&self.feet, model, &self.now, touching);
        self.soles.plants(&mut self.plants);
    }

    /// Bodies of the legs it drives: thigh, shin, foot of each foot.
    pub fn bodies(&self, model: &Model) -> Vec<usize> {
        self.feet
            .iter()
            .flat_map(|f| [f.limb.upper, f.limb.lower, f.limb.end].map(|l| model.body_of[l].0))
            .collect()
    }

    /// Writes the drives of the stance legs for the next step of `dt` seconds, and turns those of the spine by the lean.
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
        let Sway { com, over, error, rate, stray, omega } = self.sway(model, (q, v), (goal_q, goal_v));
        let support = polygon(&self.feet, model, &self.now);
        let centers: Vec<Vec3> = self.feet.iter().map(|f| f.center(model, &self.now)).collect();
        let force = (Vec3::y() * lift - model.gravity) * model.mass;
        let force = self.feed.map_or(force, |f| f.force);
        let lead = self.feed.map_or(Vec2::zeros(), |f| f.lead);
        let mut force = if force.y > 0.0 { force } else { Vec3::zeros() };
        let per_height = omega * omega / model.gravity.norm(); // 1/h

        let mut hip_pressure = None;
        if s.hip && force.y > 0.0 {
            if self.hip.inertia.is_none() {
                self.hip.inertia = Some(self.lean_inertia(model, goal_q, over)?);
            }
            let sudden = self.wake[1].update(&s, stray, dt);
            let wanted = ground(&com) + lead + rate + stray * (s.hip_gain * sudden);
            let inside = |p| clamp_inside(&support, p, s.margin_m);
            hip_pressure = Some(self.hip.step(&s, wanted, inside, force.y, dt));
        }
        let leans = !self.hip.rests();
        let acts = self.hip.activity();

        self.integral += error * (s.shift_rate * dt);
        self.integral = limit(self.integral, s.shift_limit_m);
        let shift = limit(-(error * s.shift + rate * s.shift_damping) - self.integral, s.shift_limit_m);
        let shift = if s.ankle { shift } else { Vec2::zeros() };
        let line = if s.weight_shift { Line::between(&self.feet, &centers, model, &self.now) } else { None };
        // what the motion itself stirs up is left to the springs
        let fade = line.as_ref().map_or(0.0, |l| self.wake[0].update(&s, l.part(stray), dt));
        let line = line.filter(|_| fade > 0.0);
        let along = |x: Vec2| line.as_ref().map_or(Vec2::zeros(), |l| l.part(x)) * fade;
        let reacts = line.is_some() || leans;

        // where the legs go: the goal, leant, over the feet, shifted, along the line wherever the pelvis goes
        self.goal.copy_from_slice(goal_q);
        let mut moved = Vec2::zeros();
        if leans {
            moved = self.lean(model, self.hip.lean, goal_q, over)?;
            self.goal.copy_from_slice(&self.leant);
        }
        let root = skeleton.position(&self.goal, 0);
        let gone = along(ground(&(skeleton.position(q, 0) - root)) - shift) * s.weight_yield;
        let shift = shift + gone;
        let root = root + Vec3::new(shift.x, 0.0, shift.y);
        skeleton.set_position(&mut self.goal, 0, &root);
        plant(skeleton, &mut self.goal, &self.plants)?;
        // and how fast
        let speed = ground(&vec_at(v, 0));
        self.ahead.copy_from_slice(&self.goal);
        if reacts {
            let asked = if self.feed.is_some() { ground(&vec_at(goal_v, 0)) } else { Vec2::zeros() };
            let mut going = along(speed - asked) * (s.weight_yield * AHEAD);
            if leans {
                let on = self.lean(model, self.hip.lean + self.hip.rate * AHEAD, goal_q, over)? - moved;
                going += on - along(on) * s.weight_yield;
                self.ahead.copy_from_slice(&self.leant);
            }
            skeleton.set_position(&mut self.ahead, 0, &(root + Vec3::new(going.x, 0.0, going.y)));
            plant(skeleton, &mut self.ahead, &self.plants)?;
        }
        // and with what acceleration: that of the lean, and what else the pelvis has
        let measured = self.before.map_or(Vec2::zeros(), |before| (speed - before) / dt);
        self.before = Some(speed);
        self.accel.fill(0.0);
        let mut unforeseen = Vec2::zeros();
        if reacts {
            self.lean(model, self.hip.lean + self.hip.push * AHEAD, goal_q, over)?;
            self.later.copy_from_slice(&self.leant);
            self.lean(model, self.hip.lean, goal_q, over)?;
            let from = skeleton.position(&self.leant, 0);
            let foreseen = ground(&(skeleton.position(&self.later, 0) - from)) / AHEAD;
            let extra = measured - foreseen;
            unforeseen =
                along(extra) + (extra - line.as_ref().map_or(Vec2::zeros(), |l| l.part(extra)) * fade) * acts;
            let p = skeleton.position(&self.later, 0) + Vec3::new(unforeseen.x, 0.0, unforeseen.y) * AHEAD;
            skeleton.set_position(&mut self.later, 0, &p);
            plant(skeleton, &mut self.later, &self.plants)?;
            skeleton.difference(&self.leant, &self.later, AHEAD, &mut self.accel);
        }

        // the legs carry the body as it stands
        let pressure = ground(&com)
            + lead
            + error * s.pressure
            + rate * s.pressure_damping
            + along(error) * (s.weight - s.pressure)
            + along(rate) * (s.weight_damping - s.pressure_damping);
        let pressure = hip_pressure.map_or(pressure, |p| pressure + (p - pressure) * acts);
        let pressure = if s.ankle { pressure } else { ground(&com) + lead };
        let pressure = clamp_inside(&support, pressure, s.margin_m);
        let fall = ground(&com) + lead - pressure;
        let pointed =
            along(fall) + (fall - line.as_ref().map_or(Vec2::zeros(), |l| l.part(fall)) * fade) * acts;
        let thrust = (pointed * force.y - self.hip.moment()) * per_height;
        force += Vec3::new(thrust.x, 0.0, thrust.y);
        self.now.update(model, q, &self.still);
        let (shares, loads) = if self.feed.is_some() {
            pressed_wrenches(&self.feet, model, &self.now, pressure, force)
        } else {
            let sharing = line.as_ref().map_or(pressure, |l| l.sharing(pressure));
            let shares = shares(&centers, pressure + (sharing - pressure) * fade);
            let loads = shared_wrenches(&self.feet, &centers, &shares, pressure, force);
            (shares, loads)
        };
        self.now.inverse_dynamics(model, &self.still, &self.accel, &loads, &mut self.tau);
        if leans {
            self.lean_spine(model, set_points, goal_q, unforeseen, drives);
        }

        let ankle = s.ankle_stiffness.map(|x| x * model.mass * model.gravity.norm() / per_height);
        for (f, foot) in self.feet.iter().enumerate() {
            let even = shares[f] * self.feet.len() as f64;
            let part = 1.0 + fade * (1.0 - s.least_share) * (even - 1.0);
            for link in [foot.limb.upper, foot.limb.lower, foot.limb.end] {
                let body = model.body_of[link].0;
                let b = &model.bodies[body];
                let LegMuscle { mut stiffness, mut damping } = muscles[body];
                if let Some(all) = ankle.filter(|_| link == foot.limb.end) {
                    let set = all / self.feet.len() as f64;
                    damping *= (set / stiffness).sqrt(); // the damping ratio stays
                    stiffness = set;
                }
                let (stiffness, damping) = (stiffness * part, damping * part);
                let lets_go = !s.ankle && link == foot.limb.end;
                let target = rest_of(model, body, if lets_go { q } else { &self.goal });
                let mut rate = joint_force(&b.joint, goal_v, b.v_at);
                if reacts && !lets_go {
                    rate += rate_between(&target, &rest_of(model, body, &self.ahead));
                }
                let rate = rate * damping;
                let load = -joint_force(&b.joint, &self.tau, b.v_at) - rate;
                drives[body] =
                    Drive { stiffness, damping, rest: set_points[body].rest(&target, load, stiffness) };
            }
            let ankle = model.body_of[foot.limb.end].0;
            self.limit_ankle(model, ankle, foot, force.y * shares[f], q, v, &mut drives[ankle]);
        }
        Ok(())
    }

    /// Reads the state and the goal: fills `now` and `asked`.
    fn sway(&mut self, model: &Model, (q, v): (&[f64], &[f64]), (goal_q, goal_v): (&[f64], &[f64])) -> Sway {
        self.asked.update(model, goal_q, goal_v);
        let asked = self.asked.momentum(model);
        self.asked.update(model, goal_q, &self.still);
        self.now.update(model, q, v);
        let momentum = self.now.momentum(model);
        let com = momentum.com;
        let floor = self.plants.iter().map(|p| p.world_from_end.translation.y).fold(f64::INFINITY, f64::min);
        let omega = (model.gravity.norm() / (com.y - floor).max(0.2)).sqrt();
        let over = ground(&asked.com);
        let error = ground(&com) - over;
        let rate = ground(&(momentum.linear / model.mass)) / omega;
        let stray = error + rate - ground(&(asked.linear / model.mass)) / omega;
        let rate = rate - self.feed.map_or(Vec2::zeros(), |f| f.rate) / omega;
        Sway { com, over, error, rate, stray, omega }
    }

    /// The goal leant by `lean` into `leant`, its root moved so that the centre of mass stays over `over`, feet planted; returns
    /// that move, m. A fixed number of rounds: it is differentiated.
    fn lean(&mut self, model: &Model, lean: Vec2, goal_q: &[f64], over: Vec2) -> Result<Vec2, IkError> {
        let mut moved = Vec2::zeros();
        for _ in 0..3 {
            self.leant.copy_from_slice(goal_q);
            self.hip.offset(model, &self.asked, &mut self.leant, lean, self.settings.hip_pelvis);
            let p = model.skeleton.position(&self.leant, 0) + Vec3::new(moved.x, 0.0, moved.y);
            model.skeleton.set_position(&mut self.leant, 0, &p);
            plant(&model.skeleton, &mut self.leant, &self.plants)?;
            self.tried.update(model, &self.leant, &self.still);
            moved += over - ground(&self.tried.com(model));
        }
        Ok(moved)
    }

    /// Angular momentum about the centre of mass per lean rate, to the side and fore and aft, kg·m².
    fn lean_inertia(&mut self, model: &Model, goal_q: &[f64], over: Vec2) -> Result<Vec2, IkError> {
        let mut inertia = Vec2::zeros();
        for k in 0..2 {
            let mut unit = Vec2::zeros();
            unit[k] = 1.0;
            self.lean(model, unit * AHEAD, goal_q, over)?;
            self.later.copy_from_slice(&self.leant);
            self.lean(model, unit * -AHEAD, goal_q, over)?;
            model.skeleton.difference(&self.leant, &self.later, 2.0 * AHEAD, &mut self.accel);
            self.tried.update(model, goal_q, &self.accel);
            inertia[k] = self.tried.momentum(model).angular.dot(&hip::axis(unit));
        }
        Ok(inertia)
    }

    /// Turns the drives of the spine by the lean, with what leaning adds to their load: gravity, the lean's acceleration
    /// and, against damping, its rate.
    fn lean_spine(
        &mut self,
        model: &Model,
        set_points: &[SetPoints],
        goal_q: &[f64],
        unforeseen: Vec2,
        drives: &mut [Drive],
    ) {
        let [plain, leant, rest, pushed] = &mut self.loads;
        self.asked.inverse_dynamics(model, &self.still, &self.still, &[], plain);
        self.tried.update(model, &self.goal, &self.still);
        self.tried.inverse_dynamics(model, &self.still, &self.still, &[], leant);
        self.now.inverse_dynamics(model, &self.still, &self.still, &[], rest);
        self.accel[0] -= unforeseen.x;
        self.accel[2] -= unforeseen.y;
        self.now.inverse_dynamics(model, &self.still, &self.accel, &[], pushed);
        for &body in &self.hip.spine {
            let at = model.bodies[body].v_at;
            let drive = &mut drives[body];
            let Rest::Ball { target, shift } = drive.rest else { continue };
            let [from, to, next] = [goal_q, &self.goal, &self.ahead]
                .map(|q| model.skeleton.rotation(q, model.bodies[body].link));
            let turn = to * from.inverse();
            let rate = log(&(next * to.inverse())) / AHEAD;
            let extra = vec_at(pushed, at) - vec_at(rest, at) + vec_at(leant, at) - vec_at(plain, at);
            let load = -(turn * shift) * drive.stiffness - extra - rate * drive.damping;
            drive.rest = set_points[body].rest(&Rest::ball(turn * target), load, drive.stiffness);
        }
    }
}

fn limit(x: Vec2, length: f64) -> Vec2 {
    let n = x.norm();
    if n > length { x * (length / n) } else { x }
}

impl Reactive for Balance {
    fn react(&mut self, m: &Moment<'_>, drives: &mut [Drive]) -> Result<(), IkError> {
        self.feel(m.model, m.q, m.touching);
        let (state, goal) = ((m.q, m.v), (m.goal_q, m.goal_v));
        self.update(m.model, m.set_points, m.muscles, state, goal, m.lift, m.dt, drives)
    }
}
