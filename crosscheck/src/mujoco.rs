//! MuJoCo as an engine of the dynamic pass.
//!
//! In: a character, the settings of the pass, how MuJoCo is to integrate. Out: an [`Engine`]: controllers see
//! MuJoCo's own state, so a balance that is closed over rapier is closed over MuJoCo too.
//!
//! Hinges and slides are driven by native antagonists (controls k_L, k_H, k_d), balls by the law of
//! [`controllers::drive`] written again in the control callback; damping is MuJoCo's own (implicit where the
//! integrator is). Drives are held over a control step, their torques are not: they follow the state in
//! every substep and take. A pinned root is driven with the accelerations of its path.

use bodies::Character;
use controllers::antagonist::{SetPoints, axis_set_points};
use controllers::{Drive, Rest};
use dynamics::{Against, Model, State, Wrench};
use formats::mjcf::{self, MjcfOptions};
use formats::mujoco_layout::Layout;
use motion::rotation::log;
use motion::skeleton::{quat_at, vec_at};
use motion::{Floor, Joint, Limits, Vec3};
use serde_json::json;
use sim::{ContactForce, Engine, EngineError, EngineSettings};

use crate::bridge::{BridgeError, Shared, Source, lock};

/// The name by which it is chosen.
pub const NAME: &str = "mujoco";

/// Numbers of a contact in an answer: body, point, force, depth, what it is against.
const CONTACT: usize = 9;

/// How MuJoCo integrates and how its contacts yield.
#[derive(Clone, Debug, PartialEq)]
pub struct Integration {
    /// `rk4`, `implicitfast` or `euler`.
    pub integrator: &'static str,
    /// MuJoCo's steps per control step.
    pub substeps: usize,
    /// `solref` of all geoms: time constant (s) and damping ratio, or minus stiffness (1/s²) and minus damping
    /// (1/s) per apparent mass; MuJoCo's default if `None`.
    pub solref: Option<[f64; 2]>,
    /// `solimp` of all geoms; MuJoCo's default if `None`.
    pub solimp: Option<[f64; 5]>,
}

impl Integration {
    /// Fourth order, for motion without contacts.
    pub fn reference(substeps: usize) -> Self {
        Self { integrator: "rk4", substeps, solref: None, solimp: None }
    }
}

/// A body in MuJoCo.
pub struct Mujoco {
    bridge: Shared,
    layout: Layout,
    model: Model,
    settings: EngineSettings,
    hinges: Vec<usize>,
    balls: Vec<usize>,
    set_points: Vec<SetPoints>,
    /// Index of each link's body there.
    body_there: Vec<f64>,
    /// Link of each body there; the world's is meaningless.
    link_of: Vec<usize>,
    stops: Vec<f64>,
    request: Vec<f64>,
    root: [f64; 6],
    /// Angular velocity of the ground in the next step, world, rad/s.
    rate: Vec3,
    /// Where the ground faces after it.
    next_up: Vec3,
    wrenches: Vec<f64>,
    touching: Vec<f64>,
    q: Vec<f64>,
    v: Vec<f64>,
    q_there: Vec<f64>,
    steps: usize,
}

impl Mujoco {
    /// Builds the body at the pose `q` with the velocity `v`.
    ///
    /// # Errors
    /// [`EngineError::Failed`]: no MJCF for the character, or MuJoCo's refusal.
    pub fn new(
        bridge: Shared,
        integration: &Integration,
        character: &Character,
        settings: EngineSettings,
        q: &[f64],
        v: &[f64],
    ) -> Result<Self, EngineError> {
        let model = Model::new(character, settings.gravity);
        let links = character.skeleton.links();
        let driven =
            |i: usize| model.bodies[i].parent.is_some() || !matches!(model.bodies[i].joint, Joint::Free);
        let of_kind = |f: fn(&Joint) -> bool| -> Vec<usize> {
            (0..model.bodies.len()).filter(|&i| driven(i) && f(&model.bodies[i].joint)).collect()
        };
        let hinges = of_kind(|j| matches!(j, Joint::Revolute(_) | Joint::Prismatic(_)));
        let balls = of_kind(|j| matches!(j, Joint::Spherical));
        let set_points: Vec<SetPoints> =
            model.bodies.iter().map(|b| SetPoints::of(&b.joint, links[b.link].limits.as_ref())).collect();
        let antagonists = axis_set_points(&character.skeleton);
        let options = MjcfOptions {
            gravity: settings.gravity,
            ground: settings.ground,
            antagonists,
            props: settings.props.to_vec(),
            self_collision: settings.self_collision,
            ..MjcfOptions::default()
        };
        let file = mjcf::write(character, &options).map_err(|e| EngineError::Failed(e.to_string()))?;
        // joint limits are off: the stops of the pass replace them
        let info = lock(&bridge).load(&Source::Text(&file.text), &["limit"], true).map_err(engine)?;
        let places = info.places(&character.skeleton, &file.joints).map_err(engine)?;
        let layout = Layout::new(&character.skeleton, &places, info.nq, info.nv);
        let name = |link: usize| links[link].name.as_str();
        let there = |link: usize| info.bodies.iter().position(|b| b.name == name(link));
        let mut built = Self {
            body_there: (0..links.len()).map(|l| there(l).map_or(-1.0, |b| b as f64)).collect(),
            link_of: info.bodies.iter().map(|b| character.skeleton.link(&b.name).unwrap_or(0)).collect(),
            stops: vec![0.0; model.bodies.len()],
            request: Vec::new(),
            root: [0.0; 6],
            rate: Vec3::zeros(),
            next_up: settings.ground.map_or(Vec3::y(), |g| g.up),
            wrenches: Vec::new(),
            touching: Vec::new(),
            q: q.to_vec(),
            v: v.to_vec(),
            q_there: vec![0.0; info.nq],
            steps: 0,
            bridge,
            layout,
            model,
            settings,
            hinges,
            balls,
            set_points,
        };
        built.begin(integration)?;
        built.set_drives(&vec![Drive::NONE; built.model.bodies.len()]);
        Ok(built)
    }

    fn begin(&mut self, integration: &Integration) -> Result<(), EngineError> {
        let links = self.model.skeleton.links();
        let link = |i: &usize| &links[self.model.bodies[*i].link];
        let hinge = |i: &usize| match &link(i).limits {
            Some(Limits::Axis(r)) => json!({"joint": link(i).name, "range": [r.lo, r.hi]}),
            _ => json!({"joint": link(i).name}),
        };
        let ball = |i: &usize| match &link(i).limits {
            Some(Limits::Ball(b)) => json!({
                "joint": link(i).name,
                "axes": b.axes.iter().flat_map(|a| [a.x, a.y, a.z]).collect::<Vec<_>>(),
                "ranges": b.ranges.iter().flat_map(|r| [r.lo, r.hi]).collect::<Vec<_>>(),
            }),
            _ => json!({"joint": link(i).name}),
        };
        let request = json!({
            "op": "simulate",
            "integrator": integration.integrator,
            "substeps": integration.substeps,
            "timestep_s": 1.0 / (self.settings.rate_hz * integration.substeps as f64),
            "solref": integration.solref,
            "solimp": integration.solimp,
            "pinned": self.pinned(),
            "ground": self.turning().map(|g| turned(&g)),
            "hinges": self.hinges.iter().map(hinge).collect::<Vec<_>>(),
            "balls": self.balls.iter().map(ball).collect::<Vec<_>>(),
        });
        let mut start = vec![0.0; self.layout.nq + self.layout.nv];
        let (q, v) = start.split_at_mut(self.layout.nq);
        self.layout.pose(&self.q, q);
        self.layout.tangent(&self.q, &self.v, v);
        lock(&self.bridge).call(&request, &start).map_err(engine)?;
        Ok(())
    }

    /// The ground, if it may turn.
    fn turning(&self) -> Option<Floor> {
        self.settings.ground.filter(|g| g.turns)
    }

    fn pinned(&self) -> bool {
        self.settings.pinned && matches!(self.model.bodies[0].joint, Joint::Free)
    }
}

/// The turn of the ground from its level zero pose.
fn turned(ground: &Floor) -> [f64; 4] {
    let r = ground.turn();
    [r.w, r.i, r.j, r.k]
}

fn engine(e: BridgeError) -> EngineError {
    EngineError::Failed(e.to_string())
}

impl Engine for Mujoco {
    fn name(&self) -> &str {
        NAME
    }

    fn model(&self) -> &Model {
        &self.model
    }

    fn q(&self) -> &[f64] {
        &self.q
    }

    fn v(&self) -> &[f64] {
        &self.v
    }

    fn set_stops(&mut self, stiffness: &[f64]) {
        self.stops = stiffness.to_vec();
        let numbers: Vec<f64> = self.hinges.iter().chain(&self.balls).map(|&i| stiffness[i]).collect();
        // a process that ended is reported by the next step
        let _ = lock(&self.bridge).call(&json!({"op": "stops"}), &numbers);
    }

    fn stops(&self) -> &[f64] {
        &self.stops
    }

    fn set_masses(&mut self, character: &Character) -> Result<(), EngineError> {
        let mut numbers = Vec::new();
        for (link, body) in character.bodies.iter().enumerate().filter(|(_, b)| b.mass > 0.0) {
            numbers.extend([self.body_there[link], body.mass]);
            numbers.extend_from_slice(body.com.as_slice());
            numbers.extend_from_slice(body.inertia.as_slice());
        }
        lock(&self.bridge).call(&json!({"op": "masses"}), &numbers).map_err(engine)?;
        self.model = Model::new(character, self.settings.gravity);
        Ok(())
    }

    fn set_drives(&mut self, drives: &[Drive]) {
        self.request.clear();
        for &i in &self.hinges {
            let d = &drives[i];
            // the pair's gains, which are those of its rest as long as that lies between the set points
            let (lo, hi) = self.set_points[i].gains(d.stiffness, &d.rest)[0];
            self.request.extend([lo, hi, d.damping]);
        }
        for &i in &self.balls {
            let d = &drives[i];
            self.request.extend([d.stiffness, d.damping]);
            match d.rest {
                Rest::Ball { target: r, shift: s } => {
                    self.request.extend([r.w, r.i, r.j, r.k, s.x, s.y, s.z]);
                }
                _ => self.request.extend([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
            }
        }
    }

    /// The root gets, at constant acceleration, the velocity that would carry it to `q_next` in one step. (The
    /// acceleration that reaches `q_next` exactly rings from step to step.) The path lags by half a step where
    /// it accelerates.
    fn move_root(&mut self, _: &State, q_next: &[f64]) {
        if !self.pinned() {
            return;
        }
        let b = &self.model.bodies[0];
        let rate = self.settings.rate_hz;
        let turn = log(&(quat_at(q_next, b.q_at + 3) * quat_at(&self.q, b.q_at + 3).inverse()));
        let linear = (vec_at(q_next, b.q_at) - vec_at(&self.q, b.q_at)) * rate - vec_at(&self.v, b.v_at);
        let angular = turn * rate - vec_at(&self.v, b.v_at + 3);
        for k in 0..3 {
            self.root[k] = linear[k] * rate;
            self.root[3 + k] = angular[k] * rate;
        }
    }

    fn turn_ground(&mut self, up: &Vec3) {
        let Some(ground) = self.turning() else { return };
        let next = Floor { up: *up, ..ground };
        self.rate = log(&(next.turn() * ground.turn().inverse())) * self.settings.rate_hz;
        self.next_up = *up;
    }

    fn add_wrench(&mut self, w: &Wrench) {
        self.wrenches.push(self.body_there[w.link]);
        for x in [w.point, w.force, w.moment] {
            self.wrenches.extend_from_slice(x.as_slice());
        }
    }

    fn step(&mut self) -> Result<(), EngineError> {
        // drives stay as they are until they are set anew
        let drives = self.request.len();
        self.request.extend(self.root);
        if let Some(ground) = self.turning() {
            // where it is, and how it turns through the step; MuJoCo's rates of balls are along the moving body
            let rate = ground.turn().inverse() * self.rate;
            self.request.extend(turned(&ground));
            self.request.extend(rate.iter());
        }
        self.request.append(&mut self.wrenches);
        let (head, answer) =
            lock(&self.bridge).call(&json!({"op": "step"}), &self.request).map_err(engine)?;
        self.request.truncate(drives);
        self.steps += 1;
        if let Some(ground) = &mut self.settings.ground {
            ground.up = self.next_up;
            self.rate = Vec3::zeros();
        }
        let (nq, nv) = (self.layout.nq, self.layout.nv);
        if answer.len() < nq + nv || !(answer.len() - nq - nv).is_multiple_of(CONTACT) {
            return Err(engine(BridgeError::Length { found: answer.len(), wanted: nq + nv }));
        }
        if head["bad"].as_bool() != Some(false) {
            return Err(EngineError::Diverged {
                step: self.steps,
                time_s: self.steps as f64 / self.settings.rate_hz,
                body: self.model.skeleton.links()[0].name.clone(),
            });
        }
        self.q_there.copy_from_slice(&answer[..nq]);
        self.layout.pose_back(&answer[..nq], &mut self.q);
        self.layout.tangent_back(&self.q, &answer[nq..nq + nv], &mut self.v);
        self.touching.clear();
        self.touching.extend_from_slice(&answer[nq + nv..]);
        Ok(())
    }

    fn contacts(&self, out: &mut Vec<ContactForce>) {
        let against = |code: f64| match code as i64 {
            -1 => Against::Ground,
            prop @ ..=-2 => Against::Prop((-2 - prop) as usize),
            body => Against::Link(self.link_of[body as usize]),
        };
        out.extend(self.touching.chunks_exact(CONTACT).map(|c| ContactForce {
            link: self.link_of[c[0] as usize],
            against: against(c[8]),
            point: Vec3::new(c[1], c[2], c[3]),
            force: Vec3::new(c[4], c[5], c[6]),
            depth: c[7],
        }));
    }
}
