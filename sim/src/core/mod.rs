//! The core: an articulated body in reduced coordinates, for where many steps are needed.
//!
//! In: a character, a state, one [`controllers::Drive`] per joint, outside wrenches. Out: the state after the step and
//! the forces at every contact, through [`Engine`]; its whole state as a [`Snapshot`], and [`rollouts()`] from many of them.
//!
//! | file | holds |
//! |---|---|
//! | `tree` | which degrees of freedom carry which, packed rows |
//! | `factor` | `M + dt D + dt² K = Lᵀ L` on the tree |
//! | `shapes` | what may touch: points, solids, pairs |
//! | `find` | what touches what |
//! | `contact` | the law of a point that touches |
//! | `friction` | Coulomb's law: projections, the residual |
//! | `response` | how the touching bodies answer to impulses |
//! | `solve` | contact impulses: sweeps |
//! | `newton` | their finish |
//! | `integrate` | a substep |
//! | `sound` | whether a substep may stand |
//! | `momentum` | what outside forces make of momentum |
//! | `step` | drives, root path, wrenches, the step: [`Engine`] |
//! | `snapshot` | save and restore |
//! | [`rollouts`](mod@rollouts) | many runs from many states |
//!
//! Backward Euler in velocities: with kinematics, mass matrix M and bias c of [`dynamics`] at the start of a substep,
//! `(M + dt D + dt² K) (v₁ − v₀) = dt (K e − (D + dt K) v₀ − c + Σ Jᵀ w) + Jᵀ λ`, e the distance of each spring from its rest,
//! which is re-based every control step, and `q₁ = q₀ ⊕ v₁ dt`. Method, traps and numbers are in `docs/CORE.md`.

mod contact;
mod factor;
mod find;
mod friction;
mod integrate;
mod momentum;
mod newton;
mod overlap;
mod response;
mod shapes;
mod snapshot;
mod solve;
mod sound;
mod step;
mod tree;

pub mod rollouts;

use bodies::Character;
use dynamics::{Model, State, Wrench};
use motion::{Joint, Vec3};

use crate::{ContactLaw, Engine, EngineEntry, EngineError, EngineSettings, Ledger};
use contact::{Contact, Yield};
use factor::Factor;
use find::{Finder, Slot};
use response::Response;
use shapes::Shapes;
use solve::Solver;
use tree::Tree;

pub use overlap::{Overlap, overlap};
pub use rollouts::rollouts;
pub use snapshot::Snapshot;

/// The name by which it is chosen.
pub const NAME: &str = "core";

/// The entry of the core in the table of [`crate::Engines`].
pub fn engine() -> EngineEntry {
    let description = "our own reduced-coordinate core, many times faster";
    EngineEntry::new(NAME, description, |character, settings, q, v| {
        Ok(Box::new(Core::new(character, settings, q, v)?) as Box<dyn Engine>)
    })
}

/// What happened to a place of contact over a control step.
#[derive(Clone, Copy, Debug, Default)]
struct Touch {
    /// N·s, world.
    impulse: Vec3,
    /// Places of the point weighted by its normal impulses, and the sum of these.
    place: Vec3,
    weight: f64,
    /// Depth in the last substep in which it touched, m.
    depth: f64,
    /// Whether it is among [`Core::touched`].
    touched: bool,
}

/// How exactly a substep is solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effort {
    /// Contacts to 1e-7 m g dt, at the velocities that the momentum correction leaves; hard impacts in shorter substeps.
    #[default]
    Exact,
    /// For searches: contacts to 1e-3 m g dt in one solution per substep. Half the price of a walking step.
    Rough,
}

/// An articulated body. See the module header.
#[derive(Clone, Debug)]
pub struct Core {
    /// The body, compiled.
    pub model: Model,
    /// What it was built for; the ground as it lies now.
    pub settings: EngineSettings,
    tree: Tree,
    shapes: Shapes,
    yields: Yield,
    /// Degrees of freedom that turn something, and the angle that one of each counts as.
    turning: Vec<(usize, f64)>,
    effort: Effort,

    // the state: what a snapshot holds
    q: Vec<f64>,
    v: Vec<f64>,
    /// Control steps taken.
    steps: usize,
    /// Stiffness of the stop of each body's joint, N·m/rad.
    stops: Vec<f64>,
    /// Springs per degree of freedom: K, D, and e, how far the rest is.
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    rest: Vec<f64>,
    /// Forces of the last substep at each point: where the next solution starts. N; normal, two tangents.
    forces: Vec<[f64; 3]>,
    /// Acceleration of the last substep.
    trend: Vec<f64>,
    /// Velocity of a pinned root on its path.
    path: Option<[f64; 6]>,
    /// Where the ground will face after the next step, and its angular velocity until then, rad/s.
    next_up: Vec3,
    ground_rate: Vec3,
    wrenches: Vec<Wrench>,

    // what a step overwrites
    state: State,
    factor: Factor,
    force: Vec<f64>,
    change: Vec<f64>,
    /// Velocities that the bias is of.
    expected: Vec<f64>,
    /// Velocities without contacts.
    free: Vec<f64>,
    /// Pose and velocity at the start of the substep.
    before: Vec<f64>,
    before_v: Vec<f64>,
    contacts: Vec<Contact>,
    slots: Vec<Slot>,
    finder: Finder,
    response: Response,
    solver: Solver,
    /// Whether the last contact solution is none.
    unsolved: bool,
    /// Energy from nothing in this control step, J.
    gained: f64,
    touches: Vec<Touch>,
    /// Places that touched in this control step, each once.
    touched: Vec<usize>,
    ledger: Ledger,
}

/// Degrees of freedom of joints, and the angle that one of each counts as.
fn turning(model: &Model) -> Vec<(usize, f64)> {
    let mut all = Vec::new();
    for b in &model.bodies {
        match b.joint {
            Joint::Free => all.extend((b.v_at + 3..b.v_at + 6).map(|dof| (dof, 1.0))),
            Joint::Spherical => all.extend((b.v_at..b.v_at + 3).map(|dof| (dof, 1.0))),
            Joint::Revolute(_) => all.push((b.v_at, 1.0)),
            Joint::Prismatic(_) => all.push((b.v_at, 1.0 / sound::SLIDE)),
            Joint::Fixed => {}
        }
    }
    all
}

impl Core {
    /// Builds the body at the pose `q` with the velocity `v`.
    ///
    /// # Errors
    /// [`EngineError::Failed`]: a joint that moves no inertia.
    pub fn new(
        character: &Character,
        settings: EngineSettings,
        q: &[f64],
        v: &[f64],
    ) -> Result<Self, EngineError> {
        let model = Model::new(character, settings.gravity);
        let (n, bodies) = (model.nv(), model.bodies.len());
        let tree = Tree::new(&model);
        let shapes = Shapes::new(character, &model, &settings);
        let (places, slots) = (shapes.places(), shapes.groups.len() + shapes.pairs.len());
        // no more than a few of all places touch at once
        let room = shapes.points.len() + (places - shapes.points.len()).min(200);
        let yields = match settings.contact {
            ContactLaw::Stiff => Yield::Stiff,
            ContactLaw::Spring { natural_frequency_hz, damping_ratio } => {
                Yield::Frequency { omega: std::f64::consts::TAU * natural_frequency_hz, zeta: damping_ratio }
            }
            ContactLaw::Compliant { stiffness_n_m, damping_n_s_m } => {
                Yield::Compliant { stiffness: stiffness_n_m, damping: damping_n_s_m }
            }
        };
        let mut core = Self {
            response: Response::new(&tree, &shapes, n),
            solver: Solver::new(room, slots),
            forces: vec![[0.0; 3]; places],
            unsolved: false,
            gained: 0.0,
            turning: turning(&model),
            touches: vec![Touch::default(); places],
            touched: Vec::with_capacity(places),
            contacts: Vec::with_capacity(room),
            slots: Vec::with_capacity(slots),
            finder: Finder::new(&shapes),
            state: State::new(&model),
            factor: Factor::new(&tree, n),
            force: vec![0.0; n],
            change: vec![0.0; n],
            free: vec![0.0; n],
            before: vec![0.0; q.len()],
            before_v: vec![0.0; n],
            q: q.to_vec(),
            v: v.to_vec(),
            steps: 0,
            stops: vec![0.0; bodies],
            stiffness: vec![0.0; n],
            damping: vec![0.0; n],
            rest: vec![0.0; n],
            trend: vec![0.0; n],
            expected: vec![0.0; n],
            path: None,
            next_up: settings.ground.map_or(Vec3::y(), |g| g.up),
            ground_rate: Vec3::zeros(),
            wrenches: Vec::with_capacity(8),
            ledger: Ledger::default(),
            model,
            settings,
            tree,
            shapes,
            yields,
            effort: Effort::Exact,
        };
        core.state.update(&core.model, &core.q, &core.v);
        core.factor.load(&core.tree, (&core.model, &mut core.state), |_| 0.0);
        core.factor.factor(&core.tree, core.held()).map_err(|dof| {
            EngineError::Failed(format!(
                "`{}` moves no inertia; its acceleration is not defined",
                core.joint_of(dof)
            ))
        })?;
        Ok(core)
    }

    /// Kinematics of the present pose and velocity.
    pub(crate) fn state(&self) -> &State {
        &self.state
    }

    /// Sets how exactly substeps are solved from now on; no part of a snapshot.
    pub fn set_effort(&mut self, effort: Effort) {
        self.effort = effort;
    }

    /// Puts the body at the pose `q` with the velocity `v`: contacts start from no forces, everything else stays.
    ///
    /// # Panics
    /// If these are of another body.
    pub fn place(&mut self, q: &[f64], v: &[f64]) {
        self.q.copy_from_slice(q);
        self.v.copy_from_slice(v);
        self.state.update(&self.model, &self.q, &self.v);
        self.forces.fill([0.0; 3]);
        self.forget_touches();
    }

    /// Forgets what touched in this control step.
    fn forget_touches(&mut self) {
        for place in self.touched.drain(..) {
            self.touches[place] = Touch::default();
        }
    }

    /// Degrees of freedom that move as given instead of by forces: those of a pinned root.
    fn held(&self) -> usize {
        if self.settings.pinned && self.free_root() { 6 } else { 0 }
    }

    fn free_root(&self) -> bool {
        matches!(self.model.bodies[0].joint, Joint::Free)
    }

    /// Name of the link whose joint has a degree of freedom.
    fn joint_of(&self, dof: usize) -> &str {
        let body = self.model.bodies.iter().rev().find(|b| b.v_at <= dof && b.joint.nv() > 0);
        &self.model.skeleton.links()[body.map_or(0, |b| b.link)].name
    }
}
