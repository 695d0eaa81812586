//! Recorder: a trace, filled row by row while a pass runs.
//!
//! In: the state, the engine and the controller after each step, and what acted from outside during it. Out: the
//! [`Trace`]. The engine knows nothing of it: contact forces get their row here. World frame, SI.

use std::sync::Arc;

use bodies::Character;
use controllers::{Controller, Rest};
use dynamics::{ContactSample, Disturbed, Momentum, RootMode, State, Trace, Wrench};
use motion::Vec3;

use crate::{ContactForce, Engine, EngineSettings, Impulse};

/// Fills a trace row by row.
pub(crate) struct Recorder {
    pub(crate) trace: Trace,
    /// Contacts of the last row.
    pub(crate) contacts: Vec<ContactSample>,
    /// Those of the engine's last step, before they get their row.
    forces: Vec<ContactForce>,
    /// Whether wrenches from outside are recorded.
    pub(crate) disturbed: bool,
}

/// What acted from outside during a step.
#[derive(Default)]
pub(crate) struct Outside {
    /// Wrench of an assist.
    pub(crate) held: Option<Wrench>,
    /// Points (world, m) and forces (N) of pushes.
    pub(crate) pushes: Vec<(Vec3, Vec3)>,
    /// Rate of the linear momentum of masses added or removed, N.
    pub(crate) force: Vec3,
    /// Rate of their angular momentum about the centre of mass, N·m.
    pub(crate) moment: Vec3,
}

/// A step that is over.
pub(crate) struct Stepped<'a> {
    /// Its row in the trace; 0 is the start, before any step.
    pub(crate) row: usize,
    /// Kinematics of the engine's pose and velocity.
    pub(crate) state: &'a State,
    pub(crate) engine: &'a dyn Engine,
    pub(crate) controller: &'a Controller,
    pub(crate) outside: Outside,
}

impl Recorder {
    pub(crate) fn new(
        character: &Arc<Character>,
        settings: &EngineSettings,
        root: RootMode,
        controller: &Controller,
    ) -> Self {
        let ground = settings.ground;
        let (rows, nq) = (controller.goal().rows(), character.skeleton.nq());
        let (nv, links) = (controller.model().nv(), character.bodies.len());
        let room = |columns: usize| Vec::with_capacity(rows * columns);
        let trace = Trace {
            character: character.clone(),
            rate_hz: settings.rate_hz,
            substeps: settings.substeps,
            root,
            ground_m: ground.map(|g| g.height_m),
            gravity: settings.gravity,
            q: room(nq),
            v: room(nv),
            target: room(nq),
            torque: room(nv),
            stop_torque: room(nv),
            k_lo: room(nv),
            k_hi: room(nv),
            kd: room(nv),
            contacts: Vec::new(),
            root_wrench: room(6),
            com: room(3),
            momentum: room(6),
            link_com: room(3 * links),
            disturbed: Disturbed {
                ground_up: vec![ground.map_or(Vec3::y(), |g| g.up)],
                props: settings.props.to_vec(),
                ..Disturbed::default()
            },
            energy: room(2),
            plan: motion::ContactPlan::default(),
            colors: Vec::new(),
            wall_s: 0.0,
        };
        Self { trace, contacts: Vec::new(), forces: Vec::new(), disturbed: false }
    }

    /// Adds the row of a step.
    pub(crate) fn record(&mut self, step: &Stepped<'_>) {
        let (state, engine) = (step.state, step.engine);
        let model = engine.model();
        let t = &mut self.trace;
        t.q.extend_from_slice(engine.q());
        t.v.extend_from_slice(engine.v());
        t.target.extend_from_slice(step.controller.goal().pose(step.row));
        record_joints(t, step);
        let m = engine.momentum(state);
        t.com.extend_from_slice(m.com.as_slice());
        t.momentum.extend_from_slice(m.linear.as_slice());
        t.momentum.extend_from_slice(m.angular.as_slice());
        let (kinetic, potential) = engine.energy(state);
        t.energy.extend_from_slice(&[kinetic, potential]);
        for (link, body) in t.character.bodies.iter().enumerate() {
            t.link_com.extend_from_slice(state.point(model, link, &body.com).as_slice());
        }
        self.contacts.clear();
        if step.row > 0 {
            self.forces.clear();
            engine.contacts(&mut self.forces);
            self.contacts.extend(self.forces.iter().map(|c| ContactSample {
                row: step.row,
                link: c.link,
                against: c.against,
                point: c.point,
                force: c.force,
                depth: c.depth,
            }));
        }
        let d = &mut self.trace.disturbed;
        for c in &d.carried {
            d.carried_com.extend_from_slice(state.point(model, c.what.link, &c.what.at).as_slice());
        }
        let root = state.bodies[0].world.translation.vector;
        if self.disturbed {
            let outside = &step.outside;
            let mut force = outside.force;
            let mut moment = outside.moment + (m.com - root).cross(&outside.force);
            for (point, push) in &outside.pushes {
                force += push;
                moment += (point - root).cross(push);
            }
            d.wrench.extend_from_slice(force.as_slice());
            d.wrench.extend_from_slice(moment.as_slice());
        }
        if let Some(ledger) = engine.ledger() {
            let first = step.row == 0;
            let correction = if first { Impulse::default() } else { ledger.root_correction.moved(&root) };
            d.root_correction.extend(correction.linear.iter().chain(correction.angular.iter()));
            d.root_correction.push(if first { 0.0 } else { ledger.root_correction_j });
        }
        let (force, moment) = match (self.trace.root, step.outside.held) {
            (RootMode::Pinned, _) if step.row > 0 => self.pin_wrench(step, &m),
            (_, Some(w)) => (w.force, w.moment),
            _ => (Vec3::zeros(), Vec3::zeros()),
        };
        let t = &mut self.trace;
        t.root_wrench.extend_from_slice(force.as_slice());
        t.root_wrench.extend_from_slice(moment.as_slice());
        t.contacts.extend_from_slice(&self.contacts);
    }

    /// Wrench of the pin about the root's origin: what neither gravity nor contacts nor pushes explain of the change of
    /// momentum. The row's momentum `m` is already in the trace.
    fn pin_wrench(&self, step: &Stepped<'_>, m: &Momentum) -> (Vec3, Vec3) {
        let (t, model, outside) = (&self.trace, step.engine.model(), &step.outside);
        let before = t.momentum.len() - 6;
        let root = step.state.bodies[0].world.translation.vector;
        let rate = t.rate_hz;
        let change = |k: usize| (t.momentum[before + k] - t.momentum[before - 6 + k]) * rate;
        let mut force = Vec3::new(change(0), change(1), change(2)) - t.gravity * model.mass - outside.force;
        let mut moment = Vec3::new(change(3), change(4), change(5)) - outside.moment;
        for (point, push) in &outside.pushes {
            force -= push;
            moment -= (point - m.com).cross(push);
        }
        for c in &self.contacts {
            force -= c.force;
            moment -= (c.point - m.com).cross(&c.force);
        }
        moment += (m.com - root).cross(&force);
        (force, moment)
    }
}

/// Torques and gains of the joints; zero for joints without muscles.
fn record_joints(t: &mut Trace, step: &Stepped<'_>) {
    let (engine, controller) = (step.engine, step.controller);
    let model = engine.model();
    let nv = model.nv();
    let at = t.torque.len();
    for column in [&mut t.torque, &mut t.stop_torque, &mut t.k_lo, &mut t.k_hi, &mut t.kd] {
        column.resize(at + nv, 0.0);
    }
    for (i, b) in model.bodies.iter().enumerate() {
        let drive = &controller.drives()[i];
        if drive.rest == Rest::None {
            continue;
        }
        let torque = drive.torque(b, engine.q(), engine.v());
        let stop = engine.stop_torque(i);
        let gains = controller.plan().set_points[i].gains(drive.stiffness, &drive.rest);
        for k in 0..b.joint.nv().min(3) {
            let cell = at + b.v_at + k;
            t.torque[cell] = torque[k];
            t.stop_torque[cell] = stop[k];
            (t.k_lo[cell], t.k_hi[cell]) = gains[k];
            t.kd[cell] = drive.damping;
        }
    }
}
