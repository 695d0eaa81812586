//! Controller: a motion asked for, turned into drives for every joint, step by step.
//!
//! Three kinds of joints:
//! - *transitions* (scripts): gains for the end pose of each element, known when it becomes active, are run
//!   to along its curve; joints that hold still are re-balanced for the pose the others are going to;
//! - *tracked* (clips, and legs solved by IK): every step the load is
//!   τ_e = −[ID(q*, q̇*, q̈*) + k_d q̇*], the same antagonists with feed-forward inside;
//! - *stance legs*: driven by [`Balance`].
//!
//! In: a [`Setup`], then the state every step. Out: drives, and where the body sags. No engine; time is the
//! row of the goal. DESIGN §4.

use std::sync::Arc;

use dynamics::{Carrying, Character, ContactSample, Model, State};
use motion::ik::IkError;
use motion::plant::Plant;
use motion::{Dof, Limits, Range, Tracks, Value, Vec3};

use crate::antagonist::SetPoints;
use crate::balance::{Balance, BalanceSettings, LegMuscle};
use crate::feed::{self, Feed};
use crate::reactive::{Moment, Reactive};
use crate::support::{Foot, polygon, wrenches};
use crate::tension::{Need, StanceLeg, TensionScale, needs};
use crate::transition::{GainBlend, Transition};
use crate::{Drive, Goal, Rest, rest_of};

/// What a controller is made from.
pub struct Setup {
    /// The body.
    pub character: Arc<Character>,
    /// Gravity, world, m/s².
    pub gravity: Vec3,
    /// The motion asked for, limits applied, at the control rate.
    pub goal: Goal,
    /// The transition elements behind the goal; `None` for a clip.
    pub tracks: Option<Tracks>,
    /// Factor on every tension.
    pub tension: f64,
    /// Feet that stand throughout; empty when the root is pinned.
    pub plants: Vec<Plant>,
    /// Height of the ground that carries the body, m; `None` when the root is pinned or hangs in the air.
    pub ground_m: Option<f64>,
    /// Parameters of the balance property.
    pub balance: BalanceSettings,
    /// What transitions interpolate.
    pub blend: GainBlend,
    /// Reactive properties beside the balance, in the order they act.
    pub reactive: Vec<Box<dyn Reactive>>,
}

/// A joint whose muscles are too slack for what they were asked to hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Sagging {
    /// Link of the joint.
    pub link: usize,
    /// When it begins, s.
    pub time_s: f64,
    /// How long it lasts, s; zero for a pose.
    pub lasts_s: f64,
    /// Stiffness given, N·m/rad.
    pub tension: f64,
    /// Least stiffness needed at the worst moment, N·m/rad.
    pub least: f64,
}

/// Tension of a joint of a stance leg that is not what was asked.
#[derive(Clone, Debug, PartialEq)]
pub struct LegTension {
    /// Link of the joint.
    pub link: usize,
    /// Tension asked for, 1 is natural.
    pub asked: f64,
    /// Tension used: what was asked, within the range in which legs stand.
    pub used: f64,
    /// Stiffness of tension 1, N·m/rad.
    pub natural: f64,
}

#[expect(clippy::large_enum_variant, reason = "one per joint, most are transitions")]
enum Muscle {
    None,
    Transition(Transition),
    Tracked { stiffness: f64, damping: f64 },
    Leg,
}

struct Change {
    body: usize,
    to: Drive,
    end_s: f64,
    curve: motion::Curve,
}

struct Event {
    at_s: f64,
    changes: Vec<Change>,
}

/// A foot of the goal stands when its lowest corner is this near the ground, m, …
const NEAR: f64 = 0.03;
/// … and its middle this slow, m/s.
const SLOW: f64 = 0.5;

/// Turns a goal into drives. See the module header.
pub struct Controller {
    /// The body, compiled.
    pub model: Model,
    /// Set points per body.
    pub set_points: Vec<SetPoints>,
    /// Stiffness scale of the scene.
    pub scale: TensionScale,
    /// Stiffness of every body's joint at tension 1 times the setup's factor, and its damping.
    legs: Vec<LegMuscle>,
    goal: Goal,
    muscles: Vec<Muscle>,
    events: Vec<Event>,
    next_event: usize,
    balance: Option<Balance>,
    reactive: Vec<Box<dyn Reactive>>,
    leg_tension: Vec<LegTension>,
    /// The body with what it is known to carry, from a time (s) on; the first from the beginning.
    models: Vec<(f64, Model)>,
    feet: Vec<Foot>,
    /// Ground under feet that come and go; `None` where balance or a pin carries the body.
    ground_m: Option<f64>,
    /// Contacts of the last step.
    touching: Vec<ContactSample>,
    drives: Vec<Drive>,
    sagging: Vec<Sagging>,
    slack: Vec<Option<Sagging>>,
    blend: GainBlend,
    state: State,
    tau: Vec<f64>,
    lift: Vec<f64>,
    /// What a clip needs of the ground under planted feet, per row; empty for scripts.
    feeds: Vec<Option<Feed>>,
    /// Least stiffness for stability per body, at the rows planned for; for clips.
    stability: Vec<(usize, Vec<f64>)>,
}

/// Tension of stance legs is kept in this range: below they would not stand (T = 0.5 just does), above an
/// ankle answers a small error with more torque than the sole can pass on.
const LEG_TENSION: Range = Range { lo: 0.6, hi: 2.0 };

impl Controller {
    /// Plans the whole motion: scale, events, loads of all end poses.
    ///
    /// # Errors
    /// Planted limbs that two-bone IK cannot solve.
    pub fn new(setup: Setup) -> Result<Self, IkError> {
        Self::carrying(setup, &[])
    }

    /// [`Controller::new`] of a body that knows what it will carry, and when: loads of all poses count it.
    ///
    /// # Errors
    /// As [`Controller::new`].
    pub fn carrying(setup: Setup, known: &[Carrying]) -> Result<Self, IkError> {
        let character = &setup.character;
        let models = models(character, setup.gravity, known);
        let model = models[0].1.clone();
        let links = character.skeleton.links();
        let set_points: Vec<SetPoints> =
            model.bodies.iter().map(|b| SetPoints::of(&b.joint, links[b.link].limits.as_ref())).collect();
        let feet: Vec<Foot> = Foot::of(character, &model);
        let planted: Vec<Foot> =
            setup.plants.iter().filter_map(|p| feet.iter().find(|f| f.limb == p.limb).cloned()).collect();
        let balance = (!planted.is_empty())
            .then(|| Balance::new(&model, setup.balance, planted.clone(), setup.plants.clone()));
        // feet that stand share the body; of feet that come and go each may have to carry all of it
        let (carrying, share) = match (planted.len(), setup.ground_m) {
            (0, Some(_)) => (feet.clone(), 1.0),
            (n, _) => (planted, 1.0 / n.max(1) as f64),
        };
        let stance = carrying.iter().map(|f| StanceLeg::new(&model, &f.limb, share)).collect();
        let mut planner =
            Planner { models: &models, set_points: &set_points, stance, carrying, cache: Vec::new() };
        let mut times: Vec<f64> = match &setup.tracks {
            Some(t) => t.elements().flat_map(|(_, e)| [e.start_s, e.arrives_s()]).collect(),
            None => Vec::new(),
        };
        if times.is_empty() {
            // a clip: enough poses to know the loads, not more than a simulation takes
            let n = (setup.goal.rows() as f64 / setup.goal.rate_hz / 0.2).ceil().clamp(1.0, 100.0);
            let length = (setup.goal.rows() - 1) as f64 / setup.goal.rate_hz;
            times = (0..=n as usize).map(|i| length * i as f64 / n).collect();
        }
        times.push(0.0);
        times.extend(models.iter().skip(1).map(|(at_s, _)| *at_s));
        for t in times {
            planner.at(&setup.goal, t);
        }
        let poses: Vec<Vec<Need>> = planner.cache.iter().map(|(_, n)| n.clone()).collect();
        let scale = TensionScale::new(&model, &character.classes, &planner.stance, &poses);

        let in_leg: Vec<usize> = match &balance {
            Some(b) => b.bodies(&model),
            None => Vec::new(),
        };
        let mut leg_tension = Vec::new();
        let legs = (0..model.bodies.len())
            .map(|i| {
                let tension = match &setup.tracks {
                    Some(t) => setup.tension * t.base_tension[model.bodies[i].link],
                    None => setup.tension,
                };
                let asked = tension;
                let tension =
                    if in_leg.contains(&i) { tension.clamp(LEG_TENSION.lo, LEG_TENSION.hi) } else { tension };
                if tension != asked {
                    let (link, natural) = (model.bodies[i].link, scale.k1[i]);
                    leg_tension.push(LegTension { link, asked, used: tension, natural });
                }
                let stiffness = tension * scale.k1[i];
                LegMuscle { stiffness, damping: TensionScale::damping(stiffness, scale.inertia[i]) }
            })
            .collect();
        let mut controller = Self {
            muscles: Vec::new(),
            events: Vec::new(),
            next_event: 0,
            ground_m: if balance.is_none() { setup.ground_m } else { None },
            balance,
            reactive: setup.reactive,
            leg_tension,
            models: models.clone(),
            feet,
            touching: Vec::new(),
            drives: vec![Drive::NONE; model.bodies.len()],
            sagging: Vec::new(),
            slack: vec![None; model.bodies.len()],
            blend: setup.blend,
            state: State::new(&model),
            tau: vec![0.0; model.nv()],
            lift: Vec::new(),
            feeds: Vec::new(),
            stability: Vec::new(),
            legs,
            goal: setup.goal,
            scale,
            set_points: set_points.clone(),
            model: model.clone(),
        };
        controller.plan(setup.tracks.as_ref(), setup.tension, &in_leg, &mut planner);
        controller.lift = controller.vertical_acceleration();
        if let (true, None, Some(ground_m)) = (controller.balances(), &setup.tracks, setup.ground_m) {
            controller.feeds = feed::feeds(&controller.model, &controller.goal, ground_m);
        }
        Ok(controller)
    }

    /// The motion asked for.
    pub fn goal(&self) -> &Goal {
        &self.goal
    }

    /// Joints that sag, in order of time.
    pub fn sagging(&self) -> Vec<Sagging> {
        let mut all = self.sagging.clone();
        all.extend(self.slack.iter().flatten().cloned());
        all.sort_by(|a, b| a.time_s.total_cmp(&b.time_s).then(a.link.cmp(&b.link)));
        all
    }

    /// Joints of stance legs whose tension is not what was asked.
    pub fn leg_tension(&self) -> &[LegTension] {
        &self.leg_tension
    }

    /// Drives of the last step.
    pub fn drives(&self) -> &[Drive] {
        &self.drives
    }

    /// Whether the stance legs are under the balance property.
    pub fn balances(&self) -> bool {
        self.balance.is_some()
    }

    /// Largest ω₀ dt/2 over the joints for a substep of `dt` s, and its body: what implicit integration
    /// adds to the damping ratio.
    pub fn added_damping(&self, dt: f64) -> (f64, usize) {
        (0..self.model.bodies.len())
            .filter(|&i| self.scale.inertia[i] > 0.0)
            .map(|i| ((self.legs[i].stiffness / self.scale.inertia[i]).sqrt() * dt / 2.0, i))
            .fold((0.0, 0), |a, b| if b.0 > a.0 { b } else { a })
    }

    /// Takes in the contacts of the last step, as soles and skin feel them.
    pub fn feel(&mut self, touching: &[ContactSample]) {
        self.touching.clear();
        self.touching.extend_from_slice(touching);
    }

    /// Drives for the step that ends at `row`, from the simulated state `q`, `v` at its start.
    ///
    /// # Errors
    /// Planted limbs that two-bone IK cannot solve.
    pub fn step(&mut self, row: usize, q: &[f64], v: &[f64]) -> Result<&[Drive], IkError> {
        let dt = 1.0 / self.goal.rate_hz;
        let t = row as f64 * dt;
        while self.models.get(1).is_some_and(|(at_s, _)| *at_s < t - 1e-9) {
            self.models.remove(0);
            self.model = self.models[0].1.clone();
        }
        while self.events.get(self.next_event).is_some_and(|e| e.at_s < t - 1e-9) {
            let event = &self.events[self.next_event];
            for c in &event.changes {
                if let Muscle::Transition(now) = &mut self.muscles[c.body] {
                    *now = now.redirect(c.to, event.at_s, c.end_s, c.curve, self.blend);
                }
            }
            self.next_event += 1;
        }
        if self.muscles.iter().any(|m| matches!(m, Muscle::Tracked { .. })) {
            self.feed_forward(row);
        }
        for i in 0..self.muscles.len() {
            match &self.muscles[i] {
                Muscle::Transition(m) => self.drives[i] = m.at(t),
                &Muscle::Tracked { stiffness, damping } => {
                    self.drives[i] = self.tracked(i, row, stiffness, damping);
                }
                Muscle::None | Muscle::Leg => {}
            }
        }
        let moment = Moment {
            model: &self.model,
            set_points: &self.set_points,
            muscles: &self.legs,
            q,
            v,
            touching: &self.touching,
            goal_q: self.goal.pose(row),
            goal_v: self.goal.velocity(row),
            lift: self.lift[row.min(self.lift.len() - 1)],
            time_s: t,
            dt,
        };
        if let Some(balance) = &mut self.balance {
            balance.follow(self.feeds.get(row).copied().flatten());
            balance.react(&moment, &mut self.drives)?;
        }
        for property in &mut self.reactive {
            property.react(&moment, &mut self.drives)?;
        }
        Ok(&self.drives)
    }

    /// Inverse dynamics of the goal in `row`, into `self.tau`, on the feet that stand in it.
    fn feed_forward(&mut self, row: usize) {
        let (q, v, vd) = (self.goal.pose(row), self.goal.velocity(row), self.goal.acceleration(row));
        self.state.update(&self.model, q, v);
        self.state.inverse_dynamics(&self.model, v, vd, &[], &mut self.tau);
        let Some(ground_m) = self.ground_m else { return };
        let support = self.ground_reaction(ground_m);
        if !support.is_empty() {
            self.state.inverse_dynamics(&self.model, v, vd, &support, &mut self.tau);
        }
    }

    /// The root wrench that `self.tau` asks for, passed to the feet that stand: its force at its centre of
    /// pressure on the ground, moved inside the soles. Empty in flight.
    fn ground_reaction(&self, ground_m: f64) -> Vec<dynamics::Wrench> {
        let standing: Vec<Foot> = self
            .feet
            .iter()
            .filter(|f| {
                let lowest = f.corners_in_world(&self.model, &self.state);
                let lowest = lowest.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
                lowest < ground_m + NEAR && f.speed(&self.model, &self.state) < SLOW
            })
            .cloned()
            .collect();
        let Some((force, pressure)) = feed::pressure(&self.state, &self.tau, ground_m) else {
            return Vec::new();
        };
        if standing.is_empty() {
            return Vec::new();
        }
        let soles = polygon(&standing, &self.model, &self.state);
        let pressure = soles.nearest(&pressure).unwrap_or(pressure);
        wrenches(&standing, &self.model, &self.state, pressure, force)
    }

    fn tracked(&mut self, body: usize, row: usize, stiffness: f64, damping: f64) -> Drive {
        let b = &self.model.bodies[body];
        let rate = dynamics::rnea::joint_force(&b.joint, self.goal.velocity(row), b.v_at);
        let load = -dynamics::rnea::joint_force(&b.joint, &self.tau, b.v_at) - rate * damping;
        let target = rest_of(&self.model, body, self.goal.pose(row));
        let least = self.set_points[body].least(&target, load).max(self.stability_need(body, row));
        let dt = 1.0 / self.goal.rate_hz;
        self.note_slack(body, row as f64 * dt, dt, stiffness, least);
        Drive { stiffness, damping, rest: self.set_points[body].rest(&target, load, stiffness) }
    }

    /// Least stiffness for stability of a joint, at the planned pose before `row`.
    fn stability_need(&self, body: usize, row: usize) -> f64 {
        let at = self.stability.partition_point(|(r, _)| *r <= row);
        self.stability.get(at.saturating_sub(1)).map_or(0.0, |(_, least)| least[body])
    }

    /// Joins successive slack steps of a joint into one entry.
    fn note_slack(&mut self, body: usize, t: f64, dt: f64, tension: f64, least: f64) {
        let slack = &mut self.slack[body];
        if tension >= least {
            if let Some(s) = slack.take() {
                self.sagging.push(s);
            }
            return;
        }
        match slack {
            Some(s) => {
                s.lasts_s += dt;
                s.least = s.least.max(least);
            }
            None => {
                let link = self.model.bodies[body].link;
                *slack = Some(Sagging { link, time_s: t, lasts_s: dt, tension, least });
            }
        }
    }

    /// Sets up the muscles and, for scripts, every redirection they will get.
    fn plan(&mut self, tracks: Option<&Tracks>, factor: f64, in_leg: &[usize], planner: &mut Planner<'_>) {
        let n = self.model.bodies.len();
        let Some(tracks) = tracks else {
            let of = |needs: &[Need]| needs.iter().map(|n| n.least_stability).collect();
            self.stability = planner.cache.iter().map(|(row, needs)| (*row, of(needs))).collect();
            self.stability.sort_by_key(|(row, _)| *row);
            for i in 0..n {
                let LegMuscle { stiffness, damping } = self.legs[i];
                self.muscles.push(match rest_of(&self.model, i, self.goal.pose(0)) {
                    Rest::None => Muscle::None,
                    _ if in_leg.contains(&i) => Muscle::Leg,
                    _ => Muscle::Tracked { stiffness, damping },
                });
            }
            return;
        };
        let start = planner.at(&self.goal, 0.0);
        for i in 0..n {
            let muscle = match rest_of(&self.model, i, self.goal.pose(0)) {
                Rest::None => Muscle::None,
                _ if in_leg.contains(&i) => Muscle::Leg,
                target => {
                    let tension = factor * tracks.base_tension[self.model.bodies[i].link];
                    Muscle::Transition(Transition::still(self.hold(i, target, tension, &start[i], 0.0)))
                }
            };
            self.muscles.push(muscle);
        }
        let mut times: Vec<f64> = tracks.elements().map(|(_, e)| e.start_s).collect();
        times.extend(self.models.iter().skip(1).map(|(at_s, _)| *at_s));
        times.sort_by(f64::total_cmp);
        times.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        for at_s in times {
            let event = self.event(tracks, factor, at_s, planner);
            self.events.push(event);
        }
        self.sagging.sort_by(|a, b| a.time_s.total_cmp(&b.time_s).then(a.link.cmp(&b.link)));
    }

    /// What changes when the elements that start at `at_s` become active.
    fn event(&mut self, tracks: &Tracks, factor: f64, at_s: f64, planner: &mut Planner<'_>) -> Event {
        let starting: Vec<_> = tracks.elements().filter(|(_, e)| (e.start_s - at_s).abs() < 1e-9).collect();
        let horizon = starting.iter().map(|(_, e)| e.arrives_s()).fold(at_s, f64::max);
        // the curve of the longest newcomer shapes how the others brace
        let brace = starting
            .iter()
            .max_by(|a, b| a.1.arrives_s().total_cmp(&b.1.arrives_s()))
            .map_or(motion::Curve::EaseInOut, |(_, e)| e.curve);
        let mut changes = Vec::new();
        for body in 0..self.model.bodies.len() {
            if !matches!(self.muscles[body], Muscle::Transition(_)) {
                continue;
            }
            let link = self.model.bodies[body].link;
            let Some(dof) = Dof::of_link(&tracks.skeleton, link) else { continue };
            let own = starting.iter().rev().find(|(d, _)| *d == dof).map(|(_, e)| *e);
            if let Some(e) = own {
                let target = self.clamped(link, &e.end);
                let need = planner.at(&self.goal, e.arrives_s())[body];
                let to = self.hold(body, target, factor * e.tension, &need, e.arrives_s());
                changes.push(Change { body, to, end_s: e.arrives_s(), curve: e.curve });
                continue;
            }
            let track = tracks.track(dof);
            let moving = track
                .and_then(|t| t.active(at_s).map(|i| &t.elements[i]))
                .is_some_and(|e| e.arrives_s() > at_s);
            // what is handed over is held at once
            let handed = planner.models.iter().skip(1).any(|(t, _)| (t - at_s).abs() < 1e-9);
            if moving || (horizon <= at_s && !handed) {
                continue;
            }
            let target = self.clamped(link, &tracks.value_at(dof, at_s));
            let tension = factor * tracks.tension_at(link, at_s);
            let need = planner.at(&self.goal, horizon)[body];
            let to = self.hold(body, target, tension, &need, horizon);
            changes.push(Change { body, to, end_s: horizon, curve: brace });
        }
        Event { at_s, changes }
    }

    /// Drive that holds `target` under a need at dimensionless `tension`; notes where it sags.
    fn hold(&mut self, body: usize, target: Rest, tension: f64, need: &Need, at_s: f64) -> Drive {
        let stiffness = tension * self.scale.k1[body];
        let least = need.least();
        if stiffness < least * (1.0 - 1e-9) {
            self.sagging.push(Sagging {
                link: self.model.bodies[body].link,
                time_s: at_s,
                lasts_s: 0.0,
                tension: stiffness,
                least,
            });
        }
        Drive {
            stiffness,
            damping: TensionScale::damping(stiffness, need.inertia),
            rest: self.set_points[body].rest(&target, need.load, stiffness),
        }
    }

    fn clamped(&self, link: usize, value: &Value) -> Rest {
        match (value, &self.model.skeleton.links()[link].limits) {
            (Value::Scalar(x), Some(Limits::Axis(r))) => Rest::Scalar(r.clamp(*x)),
            (Value::Scalar(x), _) => Rest::Scalar(*x),
            (Value::Rotation(r), Some(Limits::Ball(b))) => Rest::ball(b.clamp(r)),
            (Value::Rotation(r), _) => Rest::ball(*r),
        }
    }

    /// Vertical acceleration of the goal's centre of mass per row, m/s², for the support load.
    fn vertical_acceleration(&mut self) -> Vec<f64> {
        let rows = self.goal.rows();
        if self.balance.is_none() {
            return vec![0.0; rows];
        }
        let mut heights = Vec::with_capacity(rows);
        let still = vec![0.0; self.model.nv()];
        for row in 0..rows {
            self.state.update(&self.model, self.goal.pose(row), &still);
            heights.push(self.state.com(&self.model).y);
        }
        // central second difference over ± 1/30 s
        let w = ((self.goal.rate_hz / 30.0).round() as usize).max(1);
        let scale = (self.goal.rate_hz / w as f64).powi(2);
        (0..rows)
            .map(|r| {
                if r < w || r + w >= rows {
                    return 0.0;
                }
                (heights[r + w] - 2.0 * heights[r] + heights[r - w]) * scale
            })
            .collect()
    }

    /// Feet of the character, standing or not.
    pub fn feet(&self) -> &[Foot] {
        &self.feet
    }
}

/// The body with what it carries, from each time on at which that changes, s.
fn models(character: &Character, gravity: Vec3, known: &[Carrying]) -> Vec<(f64, Model)> {
    let mut times: Vec<f64> = known.iter().flat_map(|c| [c.from_s, c.to_s]).collect();
    times.retain(|t| *t > 1e-9 && t.is_finite());
    times.sort_by(f64::total_cmp);
    times.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    let with = |at_s: f64| {
        let carried = known.iter().filter(|c| c.at(at_s)).map(|c| &c.what);
        (at_s, Model::new(&character.carrying(carried), gravity))
    };
    std::iter::once(0.0).chain(times).map(with).collect()
}

/// Needs of the goal's poses, computed once per pose.
struct Planner<'a> {
    models: &'a [(f64, Model)],
    set_points: &'a [SetPoints],
    stance: Vec<StanceLeg>,
    carrying: Vec<Foot>,
    cache: Vec<(usize, Vec<Need>)>,
}

impl Planner<'_> {
    fn at(&mut self, goal: &Goal, t_s: f64) -> Vec<Need> {
        let row = ((t_s * goal.rate_hz).round().max(0.0) as usize).min(goal.rows() - 1);
        if let Some((_, needs)) = self.cache.iter().find(|(r, _)| *r == row) {
            return needs.clone();
        }
        let q = goal.pose(row);
        let after = self.models.partition_point(|(at_s, _)| *at_s < t_s + 1e-9);
        let model = &self.models[after.max(1) - 1].1;
        let mut state = State::new(model);
        state.update(model, q, &vec![0.0; model.nv()]);
        let loads = if self.carrying.is_empty() {
            Vec::new()
        } else {
            let com = motion::support::ground(&state.com(model));
            wrenches(&self.carrying, model, &state, com, -model.gravity * model.mass)
        };
        let found = needs(model, self.set_points, q, &self.stance, &loads);
        self.cache.push((row, found.clone()));
        found
    }
}
