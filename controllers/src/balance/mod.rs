//! Balance: a reactive movement property that keeps the centre of mass over the feet \[NF03 §4.2\].
//!
//! It reads the simulated state every step and writes the drives of the stance legs, and under a push those of the spine.
//!
//! *Standing* answers the sway that the motion itself causes:
//!
//! 1. *Pelvis shift* (ankles and hips): the legs' goals are solved for a root moved against the error
//!    of the centre of mass, `Δ = −(p e + d ė/ω₀) − i ∫e`, ω₀ = √(g/h), e = c − c*.
//! 2. *Support load*: the legs carry the body as it is now. RNEA at the simulated pose with the ground
//!    reaction at a centre of pressure `c + g_p e + g_d ė/ω₀`, clamped inside the soles, split between the
//!    feet (see [`crate::support`]).
//! 3. *Ankle limit*: the torque of each ankle is limited so that its own centre of pressure stays
//!    inside its sole; a stiff ankle would tip the foot.
//!
//! *Catching* answers pushes. It starts when the error of the capture point ξ = c + ċ/ω₀ grows fast (`wake`); while it
//! acts, the accelerations of the whole body below the neck are solved together (`momentum`):
//!
//! 1. *Ankle strategy*: the pressure goes beyond the capture point, `p = inside(ξ + t ξ̇ + k (ξ − c*))`.
//! 2. *Weight shift*: of the support that is `inside`, all soles together; without it only where each foot keeps its part.
//! 3. *Hip strategy*: what that cannot catch is left to a moment of the trunk (`hip`).
//! 4. *Force*: `F = (m g (c − p) − L̇)/h` through p. Leg and trunk accelerations, foot loads and torques follow from it.
//!
//! Ground that turns is estimated from feet that lie flat (`soles`): the legs' goals are over the feet as they stand.
//!
//! A goal that moves through its own dynamics (a captured clip) comes with a [`crate::Feed`] ([`ControlStep::feed`]): errors
//! and their rates are then to the moving goal, the force and the lead of its centre of pressure over its centre of
//! mass are added, and the feet share the load by the pressures of their corners ([`pressed_wrenches`]), which reach
//! the corners of the support where an equal offset of both feet leaves one sole too soon.
//!
//! In: state, contacts, goal pose, feet. Out: drives of the legs, the spine, and the arms where they may swing. No clock and
//! no engine; its memory is the integral, the moment of the trunk, the feet's loads and the level of the answer to
//! pushes. World frame.

mod ankle;
mod hip;
mod momentum;
mod settings;
mod soles;
mod wake;

use dynamics::digest::{self, Digest};
use dynamics::rnea::joint_force;
use dynamics::{Model, State};
use motion::ik::IkError;
use motion::plant::{Plant, plant};
use motion::rotation::log;
use motion::support::{Support, Vec2, ground};
use motion::{Joint, LimbKind, Vec3};

use crate::reactive::{ControlStep, Impedance, Reactive, ReactiveError};
use crate::support::{Foot, clamp_inside, polygon, pressed_wrenches, shared_wrenches, shares};
use crate::{Drive, rest_of};

use hip::{Hip, Lean, TrunkStep};
use momentum::{Stance, Wanted, WholeBody};
pub use settings::{BalanceSettings, Strategy};
use soles::Soles;
use wake::Wake;

/// The balance property. See the module header.
#[derive(Clone, Debug)]
pub struct Balance {
    settings: BalanceSettings,
    feet: Vec<Foot>,
    plants: Vec<Plant>,
    soles: Soles,
    integral: Vec2,
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
#[derive(Clone, Copy, Debug)]
struct Sway {
    com: Vec3,
    /// e = c − c*.
    error: Vec2,
    /// ċ/ω₀.
    rate: Vec2,
    /// Error of the capture point against that of the goal.
    stray: Vec2,
    omega: f64,
    /// How far the centre of mass is above what is asked, m, and how fast it rises, m/s.
    above: f64,
    rise: f64,
}

/// What a step must provide.
#[derive(Clone, Copy, Debug)]
struct Demand {
    sway: Sway,
    /// Force of the ground that the goal needs, N.
    force: Vec3,
    /// How much of the answer to pushes acts, 0 to 1.
    level: f64,
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

    /// Updates where the feet stand from the contacts of the last step, where they turned with the ground.
    fn observe_contacts(&mut self, step: &ControlStep<'_>) {
        if step.contacts.is_empty() {
            return;
        }
        self.now.update(step.model, step.q, &self.still);
        self.soles.observe_contacts(&self.feet, step.model, &self.now, step.contacts);
        self.soles.plants(&mut self.plants);
    }

    /// Standing: the pelvis shifted against the error, legs that carry the body as it stands.
    fn stand(
        &mut self,
        step: &ControlStep<'_>,
        demand: &Demand,
        drives: &mut [Drive],
    ) -> Result<(), IkError> {
        let s = self.settings;
        let model = step.model;
        let skeleton = &model.skeleton;
        let Demand { sway: Sway { com, error, rate, omega, .. }, force, level } = *demand;
        let lead = step.feed.map_or(Vec2::zeros(), |f| f.lead);
        let per_height = omega * omega / model.gravity.norm(); // 1/h
        let support = polygon(&self.feet, model, &self.now);

        self.integral += error * (s.shift_rate * step.dt * (1.0 - level));
        self.integral = self.integral.cap_magnitude(s.shift_limit_m);
        let shift = -(error * s.shift + rate * s.shift_damping) - self.integral;
        let shift = shift.cap_magnitude(s.shift_limit_m);
        let shift = if s.ankle { shift } else { Vec2::zeros() };
        // goals of the legs: the pose asked for on the feet as they stand, its root shifted
        self.goal.copy_from_slice(step.goal_q);
        let root = skeleton.position(&self.goal, 0) + Vec3::new(shift.x, 0.0, shift.y);
        skeleton.set_position(&mut self.goal, 0, &root);
        plant(skeleton, &mut self.goal, &self.plants)?;

        // loads of the legs: those of the body as it stands now
        let pressure = ground(&com) + lead + error * s.pressure + rate * s.pressure_damping;
        let pressure = if s.ankle { pressure } else { ground(&com) + lead };
        let pressure = clamp_inside(&support, pressure, s.margin_m);
        self.now.update(model, step.q, &self.still);
        let (shares, loads) = if step.feed.is_some() {
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
                let Impedance { mut stiffness, mut damping } = step.impedances[body];
                if let Some(all) = ankle.filter(|_| link == foot.limb.end) {
                    let set = all / self.feet.len() as f64;
                    damping *= (set / stiffness).sqrt(); // the damping ratio stays
                    stiffness = set;
                }
                // without the ankle strategy the ankle has no goal of its own: its rest follows the simulated pose
                let follows = !s.ankle && link == foot.limb.end;
                let target = rest_of(model, body, if follows { step.q } else { &self.goal });
                let rate = joint_force(&b.joint, step.goal_v, b.v_at) * damping;
                let load = -joint_force(&b.joint, &self.tau, b.v_at) - rate;
                let rest = step.set_points[body].rest(&target, load, stiffness);
                drives[body] = Drive { stiffness, damping, rest };
            }
            self.limit_ankle(step, foot, force.y * shares[f], &mut drives[foot.body]);
        }
        Ok(())
    }

    /// Catching: the whole body accelerates so that the ground pushes it back.
    fn catch(&mut self, step: &ControlStep<'_>, demand: &Demand, drives: &mut [Drive]) {
        let s = self.settings;
        let model = step.model;
        let Demand { sway, mut force, level } = *demand;
        let lead = step.feed.map_or(Vec2::zeros(), |f| f.lead);
        let per_height = sway.omega * sway.omega / model.gravity.norm();
        self.now.update(model, step.q, step.v);
        let lean = self.leans(step);
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
        let trunk = TrunkStep { caught, beyond, weight: force.y, lean, dt: step.dt };
        self.hip.step(&s, inside, &trunk);
        let wanted = soon + sway.stray * s.catch_gain;
        // the ground gives the moment that brings the trunk back, so it takes part of the pressure's room; the moment
        // that leans the trunk adds to what the pressure does
        let moment = self.hip.moment();
        let way = (wanted - middle).try_normalize(1e-9).unwrap_or_default();
        let pressure = inside(wanted - (moment - way * moment.dot(&way).max(0.0)) / force.y);
        // m h c̈ = F h = m g (c − p) − L̇
        let thrust = ((middle - pressure) * force.y - moment) * per_height;
        force += Vec3::new(thrust.x, 0.0, thrust.y);
        let wanted = Wanted { force, pressure, above: sway.above, rise: sway.rise };
        let stance = Stance { feet: &self.feet, plants: &self.plants, floor, even_load: !s.weight_shift };
        self.body.solve(&mut self.now, &self.asked, step, &stance, &wanted);
        self.body.drive(&mut self.now, step, &stance, level, drives);
    }

    /// How the chest leans, against the pose asked for.
    fn leans(&mut self, step: &ControlStep<'_>) -> Lean {
        let Some(&chest) = self.hip.spine.last() else { return Lean::default() };
        if self.hip.inertia.is_none() {
            self.hip.inertia = Some(self.lean_inertia(step.model, step.goal_q));
        }
        let (now, asked) = (&self.now.bodies[chest], &self.asked.bodies[chest]);
        let turned = log(&(now.world.rotation * asked.world.rotation.inverse()));
        let lean = |r: Vec3| Vec2::new(-r.z, r.x);
        Lean { lean: lean(turned), rate: lean(now.omega - asked.omega) }
    }

    /// Reads the state and the goal: fills `now` and `asked`.
    fn sway(&mut self, step: &ControlStep<'_>) -> Sway {
        let model = step.model;
        self.asked.update(model, step.goal_q, step.goal_v);
        let asked = self.asked.momentum(model);
        self.now.update(model, step.q, step.v);
        let momentum = self.now.momentum(model);
        let com = momentum.com;
        let floor = self.plants.iter().map(|p| p.world_from_end.translation.y).fold(f64::INFINITY, f64::min);
        let omega = (model.gravity.norm() / (com.y - floor).max(0.2)).sqrt();
        let over = ground(&asked.com);
        let error = ground(&com) - over;
        let rate = ground(&(momentum.linear / model.mass)) / omega;
        let stray = error + rate - ground(&(asked.linear / model.mass)) / omega;
        let rate = rate - step.feed.map_or(Vec2::zeros(), |f| f.rate) / omega;
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
    fn identify(&self, d: &mut Digest) {
        self.settings.identify(d);
        d.list(&self.plants, digest::plant);
    }

    /// Writes the drives of the stance legs, and under a push those of spine and arms.
    fn react(&mut self, step: &ControlStep<'_>, drives: &mut [Drive]) -> Result<(), ReactiveError> {
        self.observe_contacts(step);
        let model = step.model;
        let sway = self.sway(step);
        let force = (Vec3::y() * step.lift - model.gravity) * model.mass;
        let force = step.feed.map_or(force, |f| f.force);
        let force = if force.y > 0.0 { force } else { Vec3::zeros() };
        let free = matches!(model.bodies[0].joint, Joint::Free);
        let level =
            if free && force.y > 0.0 { self.wake.update(&self.settings, sway.stray, step.dt) } else { 0.0 };
        let demand = Demand { sway, force, level };
        self.stand(step, &demand, drives)?;
        if level > 0.0 {
            self.catch(step, &demand, drives);
        } else {
            self.hip.push = Vec2::zeros();
        }
        Ok(())
    }
}

/// Bodies of the legs of `feet`: thigh, shin, foot of each.
pub(crate) fn leg_bodies(feet: &[Foot], model: &Model) -> Vec<usize> {
    let links = feet.iter().flat_map(|f| [f.limb.upper, f.limb.lower, f.limb.end]);
    links.map(|l| model.body_of[l].0).collect()
}
