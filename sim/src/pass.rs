//! The dynamic pass: a motion performed by a body with muscles.
//!
//! In: a [`Pass`] (controller setup, ground, root mode, pushes, carried masses) and the engine to perform it in. Out: an
//! [`Outcome`]: the trace, where joints sagged, whether, when and how the body fell or the run diverged. One control
//! step per row of the goal.

use std::borrow::Cow;
use std::time::Instant;

use bodies::{Prop, Soles};
use controllers::assist::{Assist, Budget};
use controllers::stops::STIFFNESS_RATIO;
use controllers::{Controller, LegTension, Plan, Reactive, ReactiveError, Sagging, Setup};
use dynamics::fall::{self, Fall};
use dynamics::verdict::{self, Verdict};
use dynamics::{Carrying, Push, RootMode, State, Trace, Wrench};
use motion::{Floor, Joint, Tilt, Vec3};
use thiserror::Error;

use crate::core::{Overlap, overlap};
use crate::foresight::{Foreseen, Foresight, ForesightError, Subject, Used};
use crate::load::Load;
use crate::recorder::{Outside, Recorder, Stepped};
use crate::{ContactLaw, Engine, EngineEntry, EngineError, EngineSettings, Ledger};

/// Why a pass cannot start or go on.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PassError {
    /// Of the engine.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// Of a reactive property, the balance among them.
    #[error(transparent)]
    Reactive(#[from] ReactiveError),
    /// Of foresight.
    #[error(transparent)]
    Foresight(#[from] ForesightError),
    /// A body that begins inside a prop.
    #[error(
        "the first pose stands in prop `{}`: `{}` is {:.0} mm deep in it (at most {:.0} mm); move the prop or the body",
        .0.prop, .0.link, 1e3 * .0.depth_m, 1e3 * DEEPEST_M
    )]
    Overlap(Overlap),
}

/// A body that stands deeper in a prop than this is not performed, m: it would be thrown out.
pub const DEEPEST_M: f64 = 0.02;

/// Everything a run needs.
pub struct Pass {
    /// The controller's setup; its goal fixes the control rate and the length.
    pub setup: Setup,
    /// Reactive properties beside the balance, in the order they act.
    pub reactive: Vec<Box<dyn Reactive>>,
    /// Engine substeps per control step; `None` takes the engine's own number, or two, or more until ω₀ dt/2 ≤ 0.1
    /// in every joint.
    pub substeps: Option<usize>,
    /// What holds a free root; a root with a joint of its own has that, and runs as `Free`.
    pub root: RootMode,
    /// Ground plane, if any.
    pub ground: Option<Floor>,
    /// Turns of the ground, in order of time.
    pub tilts: Vec<Tilt>,
    /// Boxes and ramps fixed in the world.
    pub props: Vec<Prop>,
    /// Whether links touch each other.
    pub self_collision: bool,
    /// Pushes from outside.
    pub pushes: Vec<Push>,
    /// Masses carried.
    pub carried: Vec<Carrying>,
    /// Goes on after a fall: muscles and assist let go ([`Controller::let_go`]), and the body comes to rest. Otherwise the run
    /// ends with the fall: what comes after it was not performed.
    pub past_fall: bool,
    /// Looks ahead where nothing else keeps a free body on its feet; `None` leaves it to muscles and contacts.
    pub foresight: Option<Foreseen>,
    /// What the soles do under load.
    pub soles: Soles,
}

/// What came of a run.
pub struct Outcome {
    /// Everything recorded, up to the end, or to where the body fell or the run diverged.
    pub trace: Trace,
    /// Joints that sagged.
    pub sagging: Vec<Sagging>,
    /// When the body fell, s.
    pub fell_s: Option<f64>,
    /// How it fell: which margins were lost, in order.
    pub fall: Option<Fall>,
    /// How the motion was performed.
    pub verdict: Verdict,
    /// What reactive properties did, a line each.
    pub reactive: Vec<String>,
    /// Tension of the stance legs, where it is not what was asked.
    pub leg_tension: Vec<LegTension>,
    /// Why the run stopped early.
    pub diverged: Option<EngineError>,
    /// What the engine did beyond the equations of motion; `None` of an engine that does not count.
    pub ledger: Option<Ledger>,
    /// What foresight did; `None` where it was not asked, or slept.
    pub foresight: Option<Used>,
    /// Largest ω₀ dt/2 added to a damping ratio by implicit integration, and the link.
    pub added_damping: (f64, usize),
    /// Stiffness scale of the run per actuated joint: link, K₁ at T = 1 and K_least over the poses, N·m/rad.
    pub stiffness: Vec<(usize, f64, f64)>,
}

impl Outcome {
    /// What was performed: the trace up to the fall, that row included.
    pub fn performed(&self) -> Cow<'_, Trace> {
        match &self.fall {
            Some(fall) => Cow::Owned(self.trace.cut(0..verdict::performed_rows(&self.trace, fall))),
            None => Cow::Borrowed(&self.trace),
        }
    }
}

/// The largest ω₀ dt/2 a default run accepts.
const ADDED_DAMPING: f64 = 0.1;

impl Pass {
    /// Runs the pass in `engine`; `progress` is called with the fraction done.
    ///
    /// # Errors
    /// [`PassError`] when the body cannot be built or its legs not be solved. A divergence is an outcome,
    /// not an error: its trace is kept.
    pub fn run(self, engine: &EngineEntry, progress: &mut dyn FnMut(f64)) -> Result<Outcome, PassError> {
        let mut run = self.start(engine)?;
        while run.step()? {
            if run.row() % 16 == 0 {
                progress(run.row() as f64 / run.rows() as f64);
            }
        }
        progress(1.0);
        Ok(run.finish())
    }

    /// Prepares the run: plans the muscles, builds the engine, records the first row.
    ///
    /// # Errors
    /// What the engine finds wrong with the body.
    pub fn start(self, engine: &EngineEntry) -> Result<Run, PassError> {
        let character = self.setup.character.clone();
        let gravity = self.setup.gravity;
        let scripted = self.setup.tracks.is_some();
        let free_root = matches!(character.skeleton.links()[0].joint, Joint::Free);
        let root = if free_root { self.root } else { RootMode::Free };
        let known: Vec<Carrying> = self.carried.iter().filter(|c| c.known).cloned().collect();
        let contacts = self.setup.contacts.clone();
        let plan = Plan::new(self.setup, &known);
        let rate_hz = plan.goal.rate_hz;
        let substeps = self.substeps.or(engine.substeps()).unwrap_or_else(|| {
            let needed = plan.added_damping(1.0 / rate_hz).0 / ADDED_DAMPING;
            (needed.ceil() as usize).clamp(2, 32)
        });
        let pinned = root == RootMode::Pinned;
        let settings = EngineSettings {
            rate_hz,
            substeps,
            gravity,
            ground: self.ground.map(|g| if self.tilts.is_empty() { g } else { g.turning() }),
            pinned,
            contact: ContactLaw::Stiff,
            props: self.props.into(),
            self_collision: self.self_collision,
        };
        let controller = Controller::new(plan, self.reactive);
        let goal = controller.goal();
        let q = goal.pose(0).to_vec();
        // scripts start from rest, clips in the middle of a motion
        let v = if scripted { vec![0.0; controller.model().nv()] } else { goal.velocity(0).to_vec() };
        let started = Instant::now();
        if let Some(found) = overlap(&character, &q, &settings.props).filter(|o| o.depth_m > DEEPEST_M) {
            return Err(PassError::Overlap(found));
        }
        let carried = self.carried.clone();
        let load = Load::new(character.clone(), self.carried, rate_hz, goal.rows());
        let engine =
            if self.soles.are_rigid() { engine.clone() } else { crate::soles::entry(engine, self.soles) };
        let mut engine = engine.build(&load.character(), settings.clone(), &q, &v)?;
        let stops: Vec<f64> = controller.plan().scale.k1.iter().map(|k| k * STIFFNESS_RATIO).collect();
        engine.set_stops(&stops);
        let foresight = match &self.foresight {
            Some(foreseen) if wakes(&controller, &settings, root) => {
                let known = known.iter().filter(|c| c.at(0.0)).map(|c| &c.what);
                let subject = Subject {
                    controller: &controller,
                    body: &character.carrying(known),
                    engine: settings.clone(),
                    name: engine.name(),
                    stops: &stops,
                    soles: &self.soles,
                    root,
                    pushes: &self.pushes,
                    carried: &carried,
                    tilts: &self.tilts,
                };
                Some(Foresight::new(foreseen, &subject)?)
            }
            _ => None,
        };
        let mut state = State::new(engine.model());
        state.update(engine.model(), engine.q(), engine.v());
        let mut recorder = Recorder::new(&character, &settings, root, &controller);
        recorder.trace.plan = contacts;
        let disturbed = &mut recorder.trace.disturbed;
        disturbed.carried = load.handed();
        recorder.disturbed = !self.pushes.is_empty() || load.changes();
        recorder.record(&Stepped {
            row: 0,
            state: &state,
            engine: engine.as_ref(),
            controller: &controller,
            outside: Outside::default(),
        });
        let assist = match root {
            RootMode::Assisted { force_n, moment_nm } => {
                Some(Assist::new(controller.model(), Budget { force_n, moment_nm }))
            }
            RootMode::Free | RootMode::Pinned => None,
        };
        Ok(Run {
            controller,
            engine,
            recorder,
            state,
            root,
            assist,
            ground: settings.ground,
            tilts: self.tilts,
            pushes: self.pushes,
            past_fall: self.past_fall,
            foresight,
            load,
            row: 0,
            fell_s: None,
            diverged: None,
            started,
        })
    }
}

/// Whether foresight has anything to do: a free body over ground that no balance property holds.
fn wakes(controller: &Controller, settings: &EngineSettings, root: RootMode) -> bool {
    let free = matches!(controller.model().bodies[0].joint, Joint::Free);
    free && root != RootMode::Pinned && settings.ground.is_some() && !controller.balances()
}

/// A pass under way.
pub struct Run {
    controller: Controller,
    engine: Box<dyn Engine>,
    recorder: Recorder,
    state: State,
    root: RootMode,
    assist: Option<Assist>,
    /// As it begins.
    ground: Option<Floor>,
    tilts: Vec<Tilt>,
    pushes: Vec<Push>,
    past_fall: bool,
    foresight: Option<Foresight>,
    load: Load,
    row: usize,
    fell_s: Option<f64>,
    diverged: Option<EngineError>,
    started: Instant,
}

impl Run {
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
    pub fn diverged(&self) -> Option<&EngineError> {
        self.diverged.as_ref()
    }

    /// Controls, simulates and records one step; `false` when the run is over: at its end, where it diverged, and with the fall
    /// unless [`Pass::past_fall`].
    ///
    /// # Errors
    /// Legs that cannot be solved; programs of the user that fail.
    pub fn step(&mut self) -> Result<bool, PassError> {
        let fallen = self.fell_s.is_some();
        if self.row + 1 >= self.rows() || self.diverged.is_some() || (fallen && !self.past_fall) {
            return Ok(false);
        }
        let row = self.row + 1;
        let Self { controller, state, .. } = self;
        let engine = self.engine.as_mut();
        let rate_hz = controller.goal().rate_hz;
        let mut outside = Outside::default();
        if self.load.step_to(row) {
            // a mass added or removed has the velocity of its link, so the total momentum jumps
            let before = state.momentum(engine.model());
            engine.set_masses(&self.load.character())?;
            state.update(engine.model(), engine.q(), engine.v());
            let after = state.momentum(engine.model());
            outside.force += (after.linear - before.linear) * rate_hz;
            outside.moment += (after.angular - before.angular) * rate_hz;
        }
        if fallen {
            controller.let_go(row, engine.q());
        } else {
            controller.observe_contacts(&self.recorder.contacts);
            controller.step(row, engine.q(), engine.v())?;
            if let Some(foresight) = &mut self.foresight {
                foresight.act(row, engine, controller, &self.pushes)?;
            }
        }
        engine.set_drives(controller.drives());
        let t = (row - 1) as f64 / rate_hz;
        for push in &self.pushes {
            if push.acts(t) {
                let point = state.point(controller.model(), push.link, &push.at);
                let moment = Vec3::zeros();
                engine.add_wrench(&Wrench { link: push.link, point, force: push.force, moment });
                outside.pushes.push((point, push.force));
            }
        }
        match self.root {
            RootMode::Free => {}
            // who has fallen is not helped up
            RootMode::Assisted { .. } if fallen => {}
            RootMode::Assisted { .. } => {
                if let Some(assist) = &mut self.assist {
                    let goal = controller.goal();
                    let to = (goal.pose(row), goal.velocity(row));
                    let w = assist.wrench(controller.model(), state, engine.q(), to);
                    engine.add_wrench(&w);
                    outside.held = Some(w);
                }
            }
            RootMode::Pinned => engine.move_root(state, controller.goal().pose(row)),
        }
        if let (Some(ground), false) = (&self.ground, self.tilts.is_empty()) {
            let up = ground.at(&self.tilts, row as f64 / rate_hz).up;
            engine.turn_ground(&up);
            self.recorder.trace.disturbed.ground_up.push(up);
        }
        if let Err(error) = engine.step() {
            self.diverged = Some(error);
            self.recorder.trace.disturbed.ground_up.truncate(row);
            return Ok(false);
        }
        state.update(engine.model(), engine.q(), engine.v());
        self.recorder.record(&Stepped { row, state, engine, controller, outside });
        self.row = row;
        let pinned = self.root == RootMode::Pinned;
        if self.fell_s.is_none()
            && !pinned
            && fall::fallen(&self.recorder.trace, self.controller.model(), row)
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
        let (plan, bodies) = (controller.plan(), &controller.model().bodies);
        let scale = &plan.scale;
        let stiffness = (0..bodies.len())
            .filter(|&i| scale.k1[i] > 0.0)
            .map(|i| (bodies[i].link, scale.k1[i], scale.least[i]))
            .collect();
        // judged at the first row of the fall: what came after did not cause it
        let fall = self.fell_s.map(|t| {
            let row = (t * trace.rate_hz).round() as usize;
            fall::at_row(&trace, controller.model(), row)
        });
        let verdict = Verdict::of(&trace, fall.clone(), self.diverged.as_ref().map(ToString::to_string));
        let added = plan.added_damping(1.0 / (trace.rate_hz * trace.substeps as f64));
        Outcome {
            sagging: controller.sagging(),
            fell_s: self.fell_s,
            fall,
            verdict,
            reactive: controller.reactive_lines(),
            leg_tension: plan.leg_tension.clone(),
            diverged: self.diverged,
            ledger: self.engine.ledger().copied(),
            foresight: self.foresight.map(Foresight::used),
            stiffness,
            added_damping: (added.0, bodies[added.1].link),
            trace,
        }
    }
}
