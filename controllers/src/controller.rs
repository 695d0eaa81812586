//! Controller: a plan, stepped: the simulated state to a drive for every joint.
//!
//! Three kinds of joints:
//! - *transitions* (scripts): gains for the end pose of each element, known when it becomes active, are run
//!   to along its curve; joints that hold still are balanced anew for the pose the others are going to;
//! - *tracked* (clips, legs solved by IK, transitions whose timing is led): every step the load is
//!   τ_e = −[ID(q*, q̇*, q̈*) + k_d q̇*], the same antagonists with feed-forward inside;
//! - *stance legs*: driven by [`Balance`].
//!
//! In: a [`Plan`], then the state every step. Out: drives, and where the body sags. No engine; time is the
//! row of the goal. DESIGN §4.

use dynamics::digest::Digest;
use dynamics::{ContactSample, Model, State};
use motion::Vec3;

use crate::balance::Balance;
use crate::feed;
use crate::plan::{JointControl, Plan, Sagging};
use crate::reactive::{ControlStep, Impedance, Reactive, ReactiveError};
use crate::support::{Foot, polygon, shared_wrenches, shares, within_allowance, wrenches};
use crate::{Drive, Goal, Rest, rest_of};

/// A foot of the goal stands when its lowest corner is this near the ground, m, …
const NEAR: f64 = 0.03;
/// … and its middle this slow, m/s.
const SLOW: f64 = 0.5;

/// Turns a planned motion into drives. See the module header.
pub struct Controller {
    plan: Plan,
    /// Which of the plan's models the body is now.
    model_now: usize,
    /// Which of the plan's redirections is next.
    next_redirection: usize,
    joints: Vec<JointControl>,
    balance: Option<Balance>,
    reactive: Vec<Box<dyn Reactive>>,
    /// Of the last step.
    contacts: Vec<ContactSample>,
    drives: Vec<Drive>,
    /// Spans in which tracked joints sagged, that are over.
    past_sagging: Vec<Sagging>,
    /// Spans that are not, per body.
    open_sagging: Vec<Option<Sagging>>,
    state: State,
    tau: Vec<f64>,
}

impl Controller {
    /// Makes a plan ready to be stepped; `reactive` properties act after the balance, in their order.
    pub fn new(plan: Plan, reactive: Vec<Box<dyn Reactive>>) -> Self {
        let model = &plan.models[0].model;
        let balance =
            plan.planted.as_ref().map(|p| Balance::new(model, p.settings, p.feet.clone(), p.plants.clone()));
        Self {
            model_now: 0,
            next_redirection: 0,
            joints: plan.joints.clone(),
            balance,
            reactive,
            contacts: Vec::new(),
            drives: vec![Drive::NONE; model.bodies.len()],
            past_sagging: Vec::new(),
            open_sagging: vec![None; model.bodies.len()],
            state: State::new(model),
            tau: vec![0.0; model.nv()],
            plan,
        }
    }

    /// Makes a plan ready to be stepped without any answer to the state: no balance, no reactive property. Its drives depend on the row
    /// alone; stance legs have none.
    pub fn unanswering(mut plan: Plan) -> Self {
        plan.planted = None;
        Self::new(plan, Vec::new())
    }

    /// Adds what names its reactive properties beside the balance to a digest.
    pub fn identify_reactive(&self, digest: &mut Digest) {
        digest.list(&self.reactive, |d, property| property.identify(d));
    }

    /// What is stepped.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Whether the balance property holds planted legs.
    pub fn balances(&self) -> bool {
        self.balance.is_some()
    }

    /// The motion asked for.
    pub fn goal(&self) -> &Goal {
        &self.plan.goal
    }

    /// The body, compiled, with what it is known to carry now.
    pub fn model(&self) -> &Model {
        &self.plan.models[self.model_now].model
    }

    /// Joints that sag, in order of time.
    pub fn sagging(&self) -> Vec<Sagging> {
        let mut all = self.plan.sagging.clone();
        all.extend(self.past_sagging.iter().cloned());
        all.extend(self.open_sagging.iter().flatten().cloned());
        all.sort_by(|a, b| a.time_s.total_cmp(&b.time_s).then(a.link.cmp(&b.link)));
        all
    }

    /// What reactive properties did, a line each.
    pub fn reactive_lines(&self) -> Vec<String> {
        self.reactive.iter().flat_map(|property| property.lines()).collect()
    }

    /// Drives of the last step.
    pub fn drives(&self) -> &[Drive] {
        &self.drives
    }

    /// Drives of the last step, to be changed before an engine gets them.
    pub fn drives_mut(&mut self) -> &mut [Drive] {
        &mut self.drives
    }

    /// Takes in the contacts of the last step, which reactive properties see in the next one.
    pub fn observe_contacts(&mut self, contacts: &[ContactSample]) {
        self.contacts.clear();
        // what links do to each other bears no load
        self.contacts.extend(contacts.iter().filter(|c| c.against.is_world()));
    }

    /// Drives for the step that ends at `row`, from the simulated state `q`, `v` at its start.
    ///
    /// # Errors
    /// Planted limbs that two-bone IK cannot solve; programs of the user that fail.
    pub fn step(&mut self, row: usize, q: &[f64], v: &[f64]) -> Result<&[Drive], ReactiveError> {
        let dt = 1.0 / self.plan.goal.rate_hz;
        let t = row as f64 * dt;
        self.carry(t);
        self.redirect(t);
        let level = |plan: &Plan, i: usize| match &self.joints[i] {
            JointControl::Tracked => 1.0,
            JointControl::Transition(_) => plan.dense_level(plan.models[0].model.bodies[i].link, row),
            JointControl::Unactuated | JointControl::StanceLeg => 0.0,
        };
        let levels: Vec<f64> = (0..self.joints.len()).map(|i| level(&self.plan, i)).collect();
        if levels.iter().any(|level| *level > 0.0) {
            self.feed_forward(row);
        }
        for (i, level) in levels.into_iter().enumerate() {
            match &self.joints[i] {
                JointControl::Transition(m) if level > 0.0 => {
                    let loose = m.at(t);
                    self.drives[i] = loose.blend(&self.track(i, row), level);
                }
                JointControl::Transition(m) => {
                    self.drives[i] = m.at(t);
                    self.past_sagging.extend(self.open_sagging[i].take());
                }
                JointControl::Tracked => self.drives[i] = self.track(i, row),
                JointControl::Unactuated | JointControl::StanceLeg => {}
            }
        }
        let plan = &self.plan;
        let step = ControlStep {
            model: &plan.models[self.model_now].model,
            set_points: &plan.set_points,
            impedances: &plan.impedances,
            q,
            v,
            contacts: &self.contacts,
            goal_q: plan.goal.pose(row),
            goal_v: plan.goal.velocity(row),
            lift: plan.lift[row.min(plan.lift.len() - 1)],
            feed: plan.feeds.get(row).copied().flatten(),
            time_s: t,
            dt,
        };
        if let Some(balance) = &mut self.balance {
            balance.react(&step, &mut self.drives)?;
        }
        for property in &mut self.reactive {
            property.react(&step, &mut self.drives)?;
        }
        Ok(&self.drives)
    }

    /// Drives of a body that has given up: no stiffness, and the damping that its joints have at their tension. Muscles
    /// only take energy out: the body comes to rest where it lies.
    ///
    /// * `row`: the step ends there
    /// * `q`: the simulated pose at its start
    pub fn let_go(&mut self, row: usize, q: &[f64]) -> &[Drive] {
        self.carry(row as f64 / self.plan.goal.rate_hz);
        let model = &self.plan.models[self.model_now].model;
        for (i, drive) in self.drives.iter_mut().enumerate() {
            *drive = match rest_of(model, i, q) {
                Rest::None => Drive::NONE,
                rest => Drive { stiffness: 0.0, damping: self.plan.impedances[i].damping, rest },
            };
        }
        &self.drives
    }

    /// Takes the model of what is carried at `t`, s.
    fn carry(&mut self, t: f64) {
        while self.plan.models.get(self.model_now + 1).is_some_and(|m| m.from_s < t - 1e-9) {
            self.model_now += 1;
        }
    }

    /// Redirects the transitions whose new elements have become active at `t`, s.
    fn redirect(&mut self, t: f64) {
        while let Some(now) = self.plan.redirections.get(self.next_redirection).filter(|r| r.at_s < t - 1e-9)
        {
            for c in &now.changes {
                if let JointControl::Transition(m) = &mut self.joints[c.body] {
                    *m = m.redirect(c.to, now.at_s, c.end_s, c.curve, self.plan.blend);
                }
            }
            self.next_redirection += 1;
        }
    }

    /// Inverse dynamics of the goal in `row`, into `self.tau`, on the feet that stand in it.
    fn feed_forward(&mut self, row: usize) {
        let Self { plan, state, tau, .. } = self;
        let model = &plan.models[self.model_now].model;
        let (q, v, vd) = (plan.goal.pose(row), plan.goal.velocity(row), plan.goal.acceleration(row));
        state.update(model, q, v);
        state.inverse_dynamics(model, v, vd, &[], tau);
        let Some(ground_m) = plan.ground_m else { return };
        let support = if plan.bears.is_empty() {
            ground_reaction(&plan.feet, model, state, tau, ground_m)
        } else {
            planned_reaction(plan, row, model, state, tau, ground_m)
        };
        if !support.is_empty() {
            state.inverse_dynamics(model, v, vd, &support, tau);
        }
    }

    /// Drive of a tracked joint, the load of the goal fed forward.
    fn track(&mut self, body: usize, row: usize) -> Drive {
        let plan = &self.plan;
        let model = &plan.models[self.model_now].model;
        let b = &model.bodies[body];
        let tension = plan.tension_at(b.link, row);
        let Impedance { stiffness, damping } = plan.impedances[body];
        // damping goes with the root of stiffness
        let (mut stiffness, damping) = (stiffness * tension, damping * tension.sqrt());
        let rate = dynamics::rnea::joint_force(&b.joint, plan.goal.velocity(row), b.v_at);
        let load = -dynamics::rnea::joint_force(&b.joint, &self.tau, b.v_at) - rate * damping;
        let target = rest_of(model, body, plan.goal.pose(row));
        let least = plan.set_points[body].least(&target, load).max(plan.stability_need(body, row));
        if plan.tenses(b.link) {
            stiffness = stiffness.max(least);
        }
        let drive = Drive { stiffness, damping, rest: plan.set_points[body].rest(&target, load, stiffness) };
        let now = Sagging {
            link: b.link,
            time_s: row as f64 * (1.0 / plan.goal.rate_hz),
            lasts_s: 1.0 / plan.goal.rate_hz,
            tension: stiffness,
            least,
        };
        self.note_sagging(body, now);
        drive
    }

    /// Joins successive steps in which a joint sags into one span.
    fn note_sagging(&mut self, body: usize, now: Sagging) {
        let span = &mut self.open_sagging[body];
        if now.tension >= now.least {
            self.past_sagging.extend(span.take());
            return;
        }
        match span {
            Some(s) => {
                s.lasts_s += now.lasts_s;
                s.least = s.least.max(now.least);
            }
            None => *span = Some(now),
        }
    }
}

/// The root wrench that `tau` asks for, passed to the feet that stand in `row` by the plan, none of which takes more than its
/// allowance; see [`ground_reaction`].
fn planned_reaction(
    plan: &Plan,
    row: usize,
    model: &Model,
    state: &State,
    tau: &[f64],
    ground_m: f64,
) -> Vec<dynamics::Wrench> {
    let allowed = |i: usize| plan.bears[i].get(row).copied().unwrap_or(0.0);
    let (standing, most): (Vec<Foot>, Vec<f64>) = plan
        .feet
        .iter()
        .enumerate()
        .filter(|(i, _)| allowed(*i) > 0.0)
        .map(|(i, foot)| (foot.clone(), allowed(i)))
        .unzip();
    let Some((force, pressure)) = feed::pressure(state, tau, ground_m) else { return Vec::new() };
    if standing.is_empty() {
        return Vec::new();
    }
    let pressure = polygon(&standing, model, state).nearest(&pressure).unwrap_or(pressure);
    let centers: Vec<Vec3> = standing.iter().map(|f| f.center(model, state)).collect();
    let shares = within_allowance(&shares(&centers, pressure), &most);
    shared_wrenches(&standing, &centers, &shares, pressure, force)
}

/// The root wrench that `tau` asks for, passed to the feet that stand: its force at its centre of
/// pressure on the ground, moved inside the soles. Empty in flight.
fn ground_reaction(
    feet: &[Foot],
    model: &Model,
    state: &State,
    tau: &[f64],
    ground_m: f64,
) -> Vec<dynamics::Wrench> {
    let stands = |f: &&Foot| {
        let lowest = f.corners_in_world(model, state);
        let lowest = lowest.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
        lowest < ground_m + NEAR && f.speed(model, state) < SLOW
    };
    let standing: Vec<Foot> = feet.iter().filter(stands).cloned().collect();
    let Some((force, pressure)) = feed::pressure(state, tau, ground_m) else {
        return Vec::new();
    };
    if standing.is_empty() {
        return Vec::new();
    }
    let soles = polygon(&standing, model, state);
    let pressure = soles.nearest(&pressure).unwrap_or(pressure);
    wrenches(&standing, model, state, pressure, force)
}
