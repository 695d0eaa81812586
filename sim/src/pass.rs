//! The dynamic pass: a motion performed by a body with muscles.
//!
//! In: a [`Pass`] (controller setup, world settings, root mode, pushes, carried masses). Out: an [`Outcome`]: the
//! trace, where joints sagged, whether, when and how the body fell or the run diverged. One control step per row
//! of the goal.

use std::sync::Arc;
use std::time::Instant;

use controllers::assist::{Assist, Budget};
use controllers::stops::STIFFNESS_RATIO;
use controllers::{Controller, LegTension, Sagging, Setup};
use dynamics::fall::{self, Fall};
use dynamics::{Carrying, Character, ContactSample, Disturbed, RootMode, State, Trace, Wrench};
use motion::ik::IkError;
use motion::{Joint, Vec3};
use thiserror::Error;

use crate::Engine;
use crate::ground::{Ground, Tilt};
use crate::load::Load;
use crate::world::{ContactLaw, World, WorldError, WorldSettings};

/// Why a pass cannot start or go on.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PassError {
    /// Of the engine.
    #[error(transparent)]
    World(#[from] WorldError),
    /// Of the legs' inverse kinematics.
    #[error(transparent)]
    Ik(#[from] IkError),
}

/// A push from outside during a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Push {
    /// Link pushed.
    pub link: usize,
    /// Point in the link's frame, m.
    pub at: Vec3,
    /// Force, world, N.
    pub force: Vec3,
    /// When it begins, s.
    pub start_s: f64,
    /// How long it lasts, s.
    pub duration_s: f64,
}

/// Everything a run needs.
pub struct Pass {
    /// The controller's setup; its goal fixes the control rate and the length.
    pub setup: Setup,
    /// Engine substeps per control step; `None` takes two, or more until ω₀ dt/2 ≤ 0.1 in every joint.
    pub substeps: Option<usize>,
    /// What holds a free root; a root with a joint of its own has that, and runs as `Free`.
    pub root: RootMode,
    /// Ground plane, if any.
    pub ground: Option<Ground>,
    /// Turns of the ground, in order of time.
    pub tilts: Vec<Tilt>,
    /// Pushes from outside.
    pub pushes: Vec<Push>,
    /// Masses carried.
    pub carried: Vec<Carrying>,
}

/// What came of a run.
pub struct Outcome {
    /// Everything recorded, up to the end or to where the run diverged.
    pub trace: Trace,
    /// Joints that sagged.
    pub sagging: Vec<Sagging>,
    /// When the body fell, s.
    pub fell_s: Option<f64>,
    /// How it fell: which margins were lost, in order.
    pub fall: Option<Fall>,
    /// Tension of the stance legs, where it is not what was asked.
    pub leg_tension: Vec<LegTension>,
    /// Why the run stopped early.
    pub diverged: Option<WorldError>,
    /// Largest ω₀ dt/2 added to a damping ratio by implicit integration, and the link.
    pub added_damping: (f64, usize),
    /// Stiffness scale of the run per actuated joint: link, K₁ at T = 1 and K_least over the poses, N·m/rad.
    pub stiffness: Vec<(usize, f64, f64)>,
}

/// The largest ω₀ dt/2 a default run accepts.
const ADDED_DAMPING: f64 = 0.1;

impl Pass {
    /// Runs the pass; `progress` is called with the fraction done.
    ///
    /// # Errors
    /// [`PassError`] when the body cannot be built or its legs not be solved. A divergence is an outcome,
    /// not an error: its trace is kept.
    pub fn run(self, progress: &mut dyn FnMut(f64)) -> Result<Outcome, PassError> {
        let mut run = self.start()?;
        while run.step()? {
            if run.row() % 16 == 0 {
                progress(run.row() as f64 / run.rows() as f64);
            }
        }
        progress(1.0);
        Ok(run.finish())
    }

    /// Prepares the run: plans the muscles, builds the world, records the first row.
    ///
    /// # Errors
    /// [`PassError`] when the body cannot be built or its legs not be solved.
    pub fn start(self) -> Result<Run, PassError> {
        self.start_in(World::new)
    }

    /// [`Pass::start`] in another engine: `build` is given the body, the settings, the first pose and velocity.
    ///
    /// # Errors
    /// As [`Pass::start`], and what `build` finds wrong.
    pub fn start_in<E: Engine>(
        self,
        build: impl FnOnce(&Character, WorldSettings, &[f64], &[f64]) -> Result<E, WorldError>,
    ) -> Result<Run<E>, PassError> {
        let character = self.setup.character.clone();
        let gravity = self.setup.gravity;
        let scripted = self.setup.tracks.is_some();
        let free_root = matches!(character.skeleton.links()[0].joint, Joint::Free);
        let root = if free_root { self.root } else { RootMode::Free };
        let known: Vec<Carrying> = self.carried.iter().filter(|c| c.known).cloned().collect();
        let controller = Controller::carrying(self.setup, &known)?;
        let rate_hz = controller.goal().rate_hz;
        let substeps = self.substeps.unwrap_or_else(|| {
            let needed = controller.added_damping(1.0 / rate_hz).0 / ADDED_DAMPING;
            (needed.ceil() as usize).clamp(2, 32)
        });
        let pinned = root == RootMode::Pinned;
        let settings = WorldSettings {
            rate_hz,
            substeps,
            gravity,
            ground: self.ground.map(|g| if self.tilts.is_empty() { g } else { g.turning() }),
            pinned,
            contact: ContactLaw::Stiff,
        };
        let q = controller.goal().pose(0).to_vec();
        // scripts start from rest, clips in the middle of a motion
        let v =
            if scripted { vec![0.0; controller.model.nv()] } else { controller.goal().velocity(0).to_vec() };
        let started = Instant::now();
        let load = Load::new(character.clone(), self.carried, rate_hz, controller.goal().rows());
        let mut world = build(&load.character(), settings, &q, &v)?;
        let stops: Vec<f64> = controller.scale.k1.iter().map(|k| k * STIFFNESS_RATIO).collect();
        world.set_stops(&stops);
        let mut state = State::new(world.model());
        state.update(world.model(), world.q(), world.v());
        let mut recorder = Recorder::new(&character, &settings, root, &controller);
        let disturbed = &mut recorder.trace.disturbed;
        disturbed.carried = load.handed();
        recorder.disturbed = !self.pushes.is_empty() || load.changes();
        recorder.record(&state, &world, &controller, 0, Outside::default());
        let assist = match root {
            RootMode::Assisted { force_n, moment_nm } => {
                Some(Assist::new(&controller.model, Budget { force_n, moment_nm }))
            }
            RootMode::Free | RootMode::Pinned => None,
        };
        Ok(Run {
            controller,
            world,
            recorder,
            state,
            root,
            assist,
            ground: settings.ground,
            tilts: self.tilts,
            pushes: self.pushes,
            load,
            row: 0,
            fell_s: None,
            diverged: None,
            started,
        })
    }
}

/// A pass under way.
pub struct Run<E: Engine = World> {
    controller: Controller,
    world: E,
    recorder: Recorder,
    state: State,
    root: RootMode,
    assist: Option<Assist>,
    /// As it begins.
    ground: Option<Ground>,
    tilts: Vec<Tilt>,
    pushes: Vec<Push>,
    load: Load,
    row: usize,
    fell_s: Option<f64>,
    diverged: Option<WorldError>,
    started: Instant,
}

impl<E: Engine> Run<E> {
    /// Last row recorded.
    pub fn row(&self) -> usize {
        self.row
    }

    /// Rows the whole run will have.
    pub fn rows(&self) -> usize {
        self.controller.goal().rows()
    }

    /// Everything recorded so far.
    pub fn trace(&self) -> &Trace {
        &self.recorder.trace
    }

    /// When the body fell, s; `None` if it has not yet.
    pub fn fell_s(&self) -> Option<f64> {
        self.fell_s
    }

    /// Why the run stopped early, if it did.
    pub fn diverged(&self) -> Option<&WorldError> {
        self.diverged.as_ref()
    }

    /// Controls, simulates and records one step; `false` when the run is over.
    ///
    /// # Errors
    /// Legs that cannot be solved.
    pub fn step(&mut self) -> Result<bool, PassError> {
        if self.row + 1 >= self.rows() || self.diverged.is_some() {
            return Ok(false);
        }
        let row = self.row + 1;
        let Self { controller, world, state, .. } = self;
        let rate_hz = controller.goal().rate_hz;
        let mut outside = Outside::default();
        if self.load.step_to(row) {
            // what comes and goes does so at the velocity of its link: its momentum too
            let before = state.momentum(world.model());
            world.set_masses(&self.load.character())?;
            state.update(world.model(), world.q(), world.v());
            let after = state.momentum(world.model());
            outside.force += (after.linear - before.linear) * rate_hz;
            outside.moment += (after.angular - before.angular) * rate_hz;
        }
        controller.feel(&self.recorder.contacts);
        controller.step(row, world.q(), world.v())?;
        world.set_drives(controller.drives());
        let t = (row - 1) as f64 / rate_hz;
        for push in &self.pushes {
            if t >= push.start_s - 1e-9 && t < push.start_s + push.duration_s - 1e-9 {
                let point = state.point(&controller.model, push.link, &push.at);
                let moment = Vec3::zeros();
                world.add_wrench(&Wrench { link: push.link, point, force: push.force, moment });
                outside.pushes.push((point, push.force));
            }
        }
        match self.root {
            RootMode::Free => {}
            RootMode::Assisted { .. } => {
                if let Some(assist) = &mut self.assist {
                    let goal = controller.goal();
                    let to = (goal.pose(row), goal.velocity(row));
                    let w = assist.wrench(&controller.model, state, world.q(), to);
                    world.add_wrench(&w);
                    outside.held = Some(w);
                }
            }
            RootMode::Pinned => world.move_root(state, controller.goal().pose(row)),
        }
        if let (Some(ground), false) = (&self.ground, self.tilts.is_empty()) {
            let up = ground.at(&self.tilts, row as f64 / rate_hz).up;
            world.turn_ground(&up);
            self.recorder.trace.disturbed.ground_up.push(up);
        }
        if let Err(error) = world.step() {
            self.diverged = Some(error);
            self.recorder.trace.disturbed.ground_up.truncate(row);
            return Ok(false);
        }
        state.update(world.model(), world.q(), world.v());
        self.recorder.record(state, world, controller, row, outside);
        self.row = row;
        let pinned = self.root == RootMode::Pinned;
        if self.fell_s.is_none() && !pinned && fall::fallen(&self.recorder.trace, &self.controller.model, row)
        {
            self.fell_s = Some(row as f64 / rate_hz);
        }
        Ok(true)
    }

    /// Everything recorded so far.
    pub fn finish(self) -> Outcome {
        let mut trace = self.recorder.trace;
        trace.wall_s = self.started.elapsed().as_secs_f64();
        let controller = self.controller;
        let scale = &controller.scale;
        let stiffness = (0..controller.model.bodies.len())
            .filter(|&i| scale.k1[i] > 0.0)
            .map(|i| (controller.model.bodies[i].link, scale.k1[i], scale.least[i]))
            .collect();
        // of the first row: the story needs only what led to it
        let fall = self.fell_s.map(|t| {
            let row = (t * trace.rate_hz).round() as usize;
            fall::at_row(&trace, &controller.model, row)
        });
        let added = controller.added_damping(1.0 / (trace.rate_hz * trace.substeps as f64));
        Outcome {
            sagging: controller.sagging(),
            fell_s: self.fell_s,
            fall,
            leg_tension: controller.leg_tension().to_vec(),
            diverged: self.diverged,
            stiffness,
            added_damping: (added.0, controller.model.bodies[added.1].link),
            trace,
        }
    }
}

/// Fills a trace row by row.
struct Recorder {
    trace: Trace,
    /// Of the last row.
    contacts: Vec<ContactSample>,
    /// Whether wrenches from outside are recorded.
    disturbed: bool,
}

/// What acted from outside during a step.
#[derive(Default)]
struct Outside {
    /// Wrench of an assist.
    held: Option<Wrench>,
    /// Points (world, m) and forces (N) of pushes.
    pushes: Vec<(Vec3, Vec3)>,
    /// Rate of the momentum of what came or went, N.
    force: Vec3,
    /// Rate of its angular momentum about the centre of mass, N·m.
    moment: Vec3,
}

impl Recorder {
    fn new(
        character: &Arc<Character>,
        settings: &WorldSettings,
        root: RootMode,
        controller: &Controller,
    ) -> Self {
        let ground = settings.ground;
        let (rows, nq) = (controller.goal().rows(), character.skeleton.nq());
        let (nv, links) = (controller.model.nv(), character.bodies.len());
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
                ..Disturbed::default()
            },
            energy: room(2),
            wall_s: 0.0,
        };
        Self { trace, contacts: Vec::new(), disturbed: false }
    }

    fn record(
        &mut self,
        state: &State,
        world: &impl Engine,
        controller: &Controller,
        row: usize,
        outside: Outside,
    ) {
        let model = world.model();
        let t = &mut self.trace;
        let nv = model.nv();
        t.q.extend_from_slice(world.q());
        t.v.extend_from_slice(world.v());
        t.target.extend_from_slice(controller.goal().pose(row));
        let at = t.torque.len();
        for column in [&mut t.torque, &mut t.stop_torque, &mut t.k_lo, &mut t.k_hi, &mut t.kd] {
            column.resize(at + nv, 0.0);
        }
        for (i, b) in model.bodies.iter().enumerate() {
            let drive = &controller.drives()[i];
            let torque = drive.torque(&b.joint, world.q(), b.q_at, world.v(), b.v_at);
            let stop = world.stop_torque(i);
            let gains = controller.set_points[i].gains(drive.stiffness, &drive.rest);
            if drive.stiffness == 0.0 {
                continue;
            }
            for k in 0..b.joint.nv().min(3) {
                let cell = at + b.v_at + k;
                t.torque[cell] = torque[k];
                t.stop_torque[cell] = stop[k];
                (t.k_lo[cell], t.k_hi[cell]) = gains[k];
                t.kd[cell] = drive.damping;
            }
        }
        let m = state.momentum(model);
        t.com.extend_from_slice(m.com.as_slice());
        let before = t.momentum.len();
        t.momentum.extend_from_slice(m.linear.as_slice());
        t.momentum.extend_from_slice(m.angular.as_slice());
        let (kinetic, potential) = state.energy(model);
        t.energy.extend_from_slice(&[kinetic, potential]);
        for (link, body) in t.character.bodies.iter().enumerate() {
            t.link_com.extend_from_slice(state.point(model, link, &body.com).as_slice());
        }
        self.contacts.clear();
        if row > 0 {
            world.contacts(row, &mut self.contacts);
        }
        let root = state.bodies[0].world.translation.vector;
        let d = &mut t.disturbed;
        for c in &d.carried {
            d.carried_com.extend_from_slice(state.point(model, c.what.link, &c.what.at).as_slice());
        }
        if self.disturbed {
            let mut force = outside.force;
            let mut moment = outside.moment + (m.com - root).cross(&outside.force);
            for (point, push) in &outside.pushes {
                force += push;
                moment += (point - root).cross(push);
            }
            d.wrench.extend_from_slice(force.as_slice());
            d.wrench.extend_from_slice(moment.as_slice());
        }
        let mut wrench = [0.0; 6];
        match (t.root, outside.held) {
            (RootMode::Pinned, _) if row > 0 => {
                // what the pin did is what neither gravity nor contacts explain
                let rate = t.rate_hz;
                let change = |k: usize| (t.momentum[before + k] - t.momentum[before - 6 + k]) * rate;
                let mut force =
                    Vec3::new(change(0), change(1), change(2)) - t.gravity * model.mass - outside.force;
                let mut moment = Vec3::new(change(3), change(4), change(5)) - outside.moment;
                for (point, push) in &outside.pushes {
                    force -= push;
                    moment -= (point - m.com).cross(push);
                }
                for c in &self.contacts {
                    force -= c.force;
                    moment -= (c.point - m.com).cross(&c.force);
                }
                moment += (m.com - root).cross(&force); // about the root's origin
                wrench[..3].copy_from_slice(force.as_slice());
                wrench[3..].copy_from_slice(moment.as_slice());
            }
            (_, Some(w)) => {
                wrench[..3].copy_from_slice(w.force.as_slice());
                wrench[3..].copy_from_slice(w.moment.as_slice());
            }
            _ => {}
        }
        t.root_wrench.extend_from_slice(&wrench);
        t.contacts.extend_from_slice(&self.contacts);
    }
}
