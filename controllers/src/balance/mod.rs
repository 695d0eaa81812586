//! Balance: a reactive movement property that keeps the centre of mass over the feet \[NF03 §4.2\].
//!
//! It reads the simulated state every step and writes the drives of the stance legs, and under a push those of the spine.
//!
//! *Standing* serves what the motion itself stirs up:
//!
//! 1. *Pelvis shift* (ankles and hips): the legs' goals are solved for a root moved against the error
//!    of the centre of mass, `Δ = −(p e + d ė/ω₀) − i ∫e`, ω₀ = √(g/h), e = c − c*.
//! 2. *Support load*: the legs carry the body as it is now. RNEA at the simulated pose with the ground
//!    reaction at a centre of pressure `c + g_p e + g_d ė/ω₀`, clamped inside the soles, split between the
//!    feet (see [`crate::support`]).
//! 3. *Ankle limit*: the torque of each ankle is limited so that its own centre of pressure stays
//!    inside its sole; a stiff ankle would tip the foot.
//!
//! *Catching* serves pushes. It wakes by how fast the capture point ξ = c + ċ/ω₀ runs off (`wake`), and while it is awake
//! the whole body below the neck moves as one (`momentum`):
//!
//! 1. *Ankle strategy*: the pressure goes beyond the capture point, `p = inside(ξ + t ξ̇ + k (ξ − c*))`.
//! 2. *Weight shift*: of the support that is `inside`, all soles together; without it only where each foot keeps its part.
//! 3. *Hip strategy*: what that cannot catch is left to a moment of the trunk (`hip`).
//! 4. *Force*: `F = (m g (c − p) − L̇)/h` through p. Leg and trunk accelerations, foot loads and torques follow from it.
//!
//! Feet that lie flat tell how the ground lies, which may turn: the legs' goals are over the feet as they stand.
//!
//! A goal that moves through its own dynamics (a captured clip) comes with a [`Feed`], see [`Balance::follow`]: errors
//! and their rates are then to the moving goal, the force and the lead of its centre of pressure over its centre of
//! mass are added, and the feet share the load by the pressures of their corners ([`pressed_wrenches`]), which reach
//! the corners of the support where an equal offset of both feet leaves one sole too soon.
//!
//! In: state, contacts, goal pose, feet. Out: drives of the legs, the spine, and the arms where they may swing. No clock and
//! no engine; its memory is the integral, the moment of the trunk, the feet's loads and how far the answer to pushes is
//! awake. World frame.

mod ankle;
mod hip;
mod momentum;
mod settings;
mod soles;
mod wake;

use dynamics::rnea::joint_force;
use dynamics::{ContactSample, Model, State};
use motion::ik::IkError;
use motion::plant::{Plant, plant};
use motion::rotation::log;
use motion::support::{Support, Vec2, ground};
use motion::{Joint, LimbKind, Vec3};

use crate::antagonist::SetPoints;
use crate::reactive::{Moment, Reactive};
use crate::support::{Foot, clamp_inside, polygon, pressed_wrenches, shared_wrenches, shares};
use crate::{Drive, Feed, rest_of};

use hip::{Hip, Lean};
use momentum::{Wanted, WholeBody};
pub use settings::{BalanceSettings, Strategy, StrategyError};
use soles::Soles;
use wake::Wake;

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
    wake: Wake,
    hip: Hip,
    body: WholeBody,
    /// Kinematics as simulated, as asked for, and of whatever pose is tried.
    now: State,
    asked: State,
    tried: State,
    goal: Vec<f64>,
    still: Vec<f64>,
    tau: Vec<f64>,
}

/// How the body sways, on the ground plane, m.
struct Sway {
    com: Vec3,
    /// e = c − c*.
    error: Vec2,
    /// ċ/ω₀.
    rate: Vec2,
    /// Error of the capture point, what the goal's own way asks for left out.
    stray: Vec2,
    omega: f64,
    /// How far the centre of mass is above what is asked, m, and how fast it rises, m/s.
    above: f64,
    rise: f64,
}

impl Balance {
    /// A balance over `feet`, planted at `plants` (same order).
    pub fn new(model: &Model, settings: BalanceSettings, feet: Vec<Foot>, plants: Vec<Plant>) -> Self {
        let mut tried = State::new(model);
        let hip = Hip::new(model, &mut tried);
        let limbs = model.skeleton.limbs().iter().filter(|l| settings.arms && l.kind == LimbKind::Arm);
        let arms: Vec<usize> = limbs.map(|l| model.body_of[l.upper].0).collect();
        Self {
            settings,
            soles: Soles::new(&feet, &plants),
            integral: Vec2::zeros(),
            feed: None,
            wake: Wake::default(),
            body: WholeBody::new(model, &feet, &hip.spine, &arms),
            hip,
            feet,
            plants,
            now: State::new(model),
            asked: State::new(model),
            tried,
            goal: model.skeleton.zero_pose(),
            still: vec![0.0; model.nv()],
            tau: vec![0.0; model.nv()],
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

    /// Writes the drives of the stance legs for the next step of `dt` seconds, and under a push those of spine and arms.
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
        let sway = self.sway(model, (q, v), (goal_q, goal_v));
        let force = (Vec3::y() * lift - model.gravity) * model.mass;
        let force = self.feed.map_or(force, |f| f.force);
        let force = if force.y > 0.0 { force } else { Vec3::zeros() };
        let free = matches!(model.bodies[0].joint, Joint::Free);
        let level = if free && force.y > 0.0 { self.wake.update(&s, sway.stray, dt) } else { 0.0 };
        self.stand(model, set_points, muscles, &sway, force, (q, v), (goal_q, goal_v), level, dt, drives)?;
        if level > 0.0 {
            self.catch(model, set_points, &sway, force, (q, v), (goal_q, goal_v), level, dt, drives);
        } else {
            self.hip.push = Vec2::zeros();
        }
        Ok(())
    }

    /// Standing: the pelvis shifted against the error, legs that carry the body as it stands.
    #[expect(clippy::too_many_arguments, reason = "a step's inputs, each used once")]
    fn stand(
        &mut self,
        model: &Model,
        set_points: &[SetPoints],
        muscles: &[LegMuscle],
        sway: &Sway,
        force: Vec3,
        (q, v): (&[f64], &[f64]),
        (goal_q, goal_v): (&[f64], &[f64]),
        level: f64,
        dt: f64,
        drives: &mut [Drive],
    ) -> Result<(), IkError> {
        let s = self.settings;
        let skeleton = &model.skeleton;
        let Sway { com, error, rate, omega, .. } = *sway;
        let lead = self.feed.map_or(Vec2::zeros(), |f| f.lead);
        let per_height = omega * omega / model.gravity.norm(); // 1/h
        let support = polygon(&self.feet, model, &self.now);

        self.integral += error * (s.shift_rate * dt * (1.0 - level));
        self.integral = self.integral.cap_magnitude(s.shift_limit_m);
        let shift = -(error * s.shift + rate * s.shift_damping) - self.integral;
        let shift = shift.cap_magnitude(s.shift_limit_m);
        let shift = if s.ankle { shift } else { Vec2::zeros() };
        // where the legs go: the goal over the feet, shifted
        self.goal.copy_from_slice(goal_q);
        let root = skeleton.position(&self.goal, 0) + Vec3::new(shift.x, 0.0, shift.y);
        skeleton.set_position(&mut self.goal, 0, &root);
        plant(skeleton, &mut self.goal, &self.plants)?;

        // the legs carry the body as it stands
        let pressure = ground(&com) + lead + error * s.pressure + rate * s.pressure_damping;
        let pressure = if s.ankle { pressure } else { ground(&com) + lead };
        let pressure = clamp_inside(&support, pressure, s.margin_m);
        self.now.update(model, q, &self.still);
        let (shares, loads) = if self.feed.is_some() {
            pressed_wrenches(&self.feet, model, &self.now, pressure, force)
        } else {
            let centers: Vec<Vec3> = self.feet.iter().map(|f| f.center(model, &self.now)).collect();
            let shares = shares(&centers, pressure);
            let loads = shared_wrenches(&self.feet, &centers, &shares, pressure, force);
            (shares, loads)
        };
        self.now.inverse_dynamics(model, &self.still, &self.still, &loads, &mut self.tau);

        let ankle = s.ankle_stiffness.map(|x| x * model.mass * model.gravity.norm() / per_height);
        for (f, foot) in self.feet.iter().enumerate() {
            for link in [foot.limb.upper, foot.limb.lower, foot.limb.end] {
                let body = model.body_of[link].0;
                let b = &model.bodies[body];
                let LegMuscle { mut stiffness, mut damping } = muscles[body];
                if let Some(all) = ankle.filter(|_| link == foot.limb.end) {
                    let set = all / self.feet.len() as f64;
                    damping *= (set / stiffness).sqrt(); // the damping ratio stays
                    stiffness = set;
                }
                let lets_go = !s.ankle && link == foot.limb.end;
                let target = rest_of(model, body, if lets_go { q } else { &self.goal });
                let rate = joint_force(&b.joint, goal_v, b.v_at) * damping;
                let load = -joint_force(&b.joint, &self.tau, b.v_at) - rate;
                drives[body] =
                    Drive { stiffness, damping, rest: set_points[body].rest(&target, load, stiffness) };
            }
            self.limit_ankle(model, foot, force.y * shares[f], q, v, &mut drives[foot.body]);
        }
        Ok(())
    }

    /// Catching: the whole body moves so that the ground pushes it back.
    #[expect(clippy::too_many_arguments, reason = "a step's inputs, each used once")]
    fn catch(
        &mut self,
        model: &Model,
        set_points: &[SetPoints],
        sway: &Sway,
        mut force: Vec3,
        (q, v): (&[f64], &[f64]),
        (goal_q, goal_v): (&[f64], &[f64]),
        level: f64,
        dt: f64,
        drives: &mut [Drive],
    ) {
        let s = self.settings;
        let lead = self.feed.map_or(Vec2::zeros(), |f| f.lead);
        let per_height = sway.omega * sway.omega / model.gravity.norm();
        self.now.update(model, q, v);
        let lean = self.leans(model, goal_q);
        let floor =
            self.feet.iter().map(|f| f.center(model, &self.now).y).sum::<f64>() / self.feet.len() as f64;
        let middle = ground(&sway.com) + lead;
        let support = if s.weight_shift {
            polygon(&self.feet, model, &self.now)
        } else {
            alike(&self.feet, model, &self.now)
        };
        let inside = |p| if s.ankle { clamp_inside(&support, p, s.catch_margin_m) } else { middle };
        let caught = middle + sway.rate;
        let soon = caught + self.wake.speed * s.catch_ahead_s;
        let beyond = soon - clamp_inside(&support, soon, s.catch_margin_m + s.hip_reserve_m);
        self.hip.step(&s, caught, beyond, inside, force.y, lean, dt);
        let wanted = soon + sway.stray * s.catch_gain;
        // a moment that brings the trunk back is the ground's to give; one that leans it comes on top
        let moment = self.hip.moment();
        let way = (wanted - middle).try_normalize(1e-9).unwrap_or_default();
        let pressure = inside(wanted - (moment - way * moment.dot(&way).max(0.0)) / force.y);
        // m h c̈ = F h = m g (c − p) − L̇
        let thrust = ((middle - pressure) * force.y - moment) * per_height;
        force += Vec3::new(thrust.x, 0.0, thrust.y);
        let wanted = Wanted { force, pressure, floor, above: sway.above, rise: sway.rise };
        let (state, goal) = ((q, v), (goal_q, goal_v));
        self.body.solve(model, &mut self.now, (&self.feet, &self.plants), &wanted, state, goal);
        let feet = (&self.feet[..], floor, !s.weight_shift);
        self.body.drive(model, &mut self.now, feet, set_points, state, dt, level, drives);
    }

    /// How the chest leans, against the pose asked for.
    fn leans(&mut self, model: &Model, goal_q: &[f64]) -> Lean {
        let Some(&chest) = self.hip.spine.last() else { return Lean::default() };
        if self.hip.inertia.is_none() {
            self.hip.inertia = Some(self.lean_inertia(model, goal_q));
        }
        let (now, asked) = (&self.now.bodies[chest], &self.asked.bodies[chest]);
        let turned = log(&(now.world.rotation * asked.world.rotation.inverse()));
        let lean = |r: Vec3| Vec2::new(-r.z, r.x);
        Lean { lean: lean(turned), rate: lean(now.omega - asked.omega) }
    }

    /// Reads the state and the goal: fills `now` and `asked`.
    fn sway(&mut self, model: &Model, (q, v): (&[f64], &[f64]), (goal_q, goal_v): (&[f64], &[f64])) -> Sway {
        self.asked.update(model, goal_q, goal_v);
        let asked = self.asked.momentum(model);
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
        let rise = (momentum.linear.y - asked.linear.y) / model.mass;
        Sway { com, error, rate, stray, omega, above: com.y - asked.com.y, rise }
    }

    /// Angular momentum about the centre of mass per lean rate of the chest, to the side and fore and aft, kg·m².
    fn lean_inertia(&mut self, model: &Model, goal_q: &[f64]) -> Vec2 {
        let mut inertia = Vec2::zeros();
        for k in 0..2 {
            let mut unit = Vec2::zeros();
            unit[k] = 1.0 / self.hip.spine.len() as f64;
            let mut rates = self.still.clone();
            for &b in &self.hip.spine {
                let local = self.asked.bodies[b].zero.transpose() * hip::axis(unit);
                rates[model.bodies[b].v_at..model.bodies[b].v_at + 3].copy_from_slice(local.as_slice());
            }
            self.tried.update(model, goal_q, &rates);
            unit[k] = 1.0;
            inertia[k] = self.tried.momentum(model).angular.dot(&hip::axis(unit));
        }
        inertia
    }
}

/// Where the pressure may be while each foot keeps its part of the load: the mean of points of all soles.
fn alike(feet: &[Foot], model: &Model, state: &State) -> Support {
    let mut sums = vec![Vec2::zeros()];
    for foot in feet {
        let corners = foot.corners_in_world(model, state);
        sums = sums.iter().flat_map(|sum| corners.iter().map(move |c| sum + ground(c))).collect();
    }
    Support::of_plane(sums.iter().map(|p| p / feet.len() as f64).collect())
}

impl Reactive for Balance {
    fn react(&mut self, m: &Moment<'_>, drives: &mut [Drive]) -> Result<(), IkError> {
        self.feel(m.model, m.q, m.touching);
        let (state, goal) = ((m.q, m.v), (m.goal_q, m.goal_v));
        self.update(m.model, m.set_points, m.muscles, state, goal, m.lift, m.dt, drives)
    }
}
