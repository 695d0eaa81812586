//! Engines by name: an engine of another kind, registered here, performs a pass end to end.
//!
//! It is kinematic: its state is what the drives aim at, without mass and force. That a pass knows nothing of the engine
//! it runs in shows in the trace, which must then be the motion asked for.

mod solids;

use std::sync::Arc;

use bodies::{Body, Character};
use controllers::{BalanceSettings, Drive, GainBlend, Goal, Plan, Rest, Setup};
use dynamics::{Model, RootMode, State, Wrench};
use motion::metrics::joint_errors;
use motion::rotation::exp;
use motion::script::{Action, Cycle, Pose, PoseValue, Properties, Script};
use motion::{Joint, Link, Shape, Vec3};
use nalgebra::Matrix3;
use sim::{
    ContactForce, Engine, EngineEntry, EngineError, EngineSettings, Engines, Outcome, Pass, PassError,
};
use solids::character;

/// A body that is at once where its drives rest.
struct Kinematic {
    model: Model,
    settings: EngineSettings,
    q: Vec<f64>,
    v: Vec<f64>,
    next: Vec<f64>,
    stops: Vec<f64>,
}

impl Kinematic {
    fn build(
        character: &Character,
        settings: EngineSettings,
        q: &[f64],
        v: &[f64],
    ) -> Result<Box<dyn Engine>, EngineError> {
        if settings.ground.is_some() {
            return Err(EngineError::Failed("a kinematic body touches no ground".into()));
        }
        let model = Model::new(character, settings.gravity);
        let stops = vec![0.0; model.bodies.len()];
        Ok(Box::new(Self { model, settings, q: q.to_vec(), v: v.to_vec(), next: q.to_vec(), stops }))
    }
}

impl Engine for Kinematic {
    fn name(&self) -> &str {
        "kinematic"
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
    }

    fn stops(&self) -> &[f64] {
        &self.stops
    }

    fn set_masses(&mut self, character: &Character) -> Result<(), EngineError> {
        self.model = Model::new(character, self.settings.gravity);
        Ok(())
    }

    fn set_drives(&mut self, drives: &[Drive]) {
        for (b, drive) in self.model.bodies.iter().zip(drives) {
            match drive.rest {
                Rest::Scalar(x) => self.next[b.q_at] = x,
                Rest::Ball { target, .. } => {
                    self.model.skeleton.set_rotation(&mut self.next, b.link, &target)
                }
                Rest::None => {}
            }
        }
    }

    fn move_root(&mut self, _: &State, q_next: &[f64]) {
        self.next[..7].copy_from_slice(&q_next[..7]);
    }

    fn turn_ground(&mut self, _: &Vec3) {}

    fn add_wrench(&mut self, _: &Wrench) {}

    fn step(&mut self) -> Result<(), EngineError> {
        self.model.skeleton.difference(&self.q, &self.next, 1.0 / self.settings.rate_hz, &mut self.v);
        self.q.copy_from_slice(&self.next);
        Ok(())
    }

    fn contacts(&self, _: &mut Vec<ContactForce>) {}
}

fn engines() -> Engines {
    let mut all = Engines::default();
    all.add(EngineEntry::new(
        "kinematic",
        "no masses and no forces: drives are reached at once",
        Kinematic::build,
    ));
    all
}

/// An arm on a free root: a ball and a hinge.
fn arm() -> Arc<Character> {
    let links = vec![
        Link::new("root", None, Vec3::zeros(), Joint::Free),
        Link::new("shoulder", Some(0), Vec3::new(0.2, 0.3, 0.0), Joint::Spherical),
        Link::new("elbow", Some(1), Vec3::new(0.3, 0.0, 0.0), Joint::Revolute(Vec3::y())),
    ];
    let rod = |mass: f64| Body {
        mass,
        com: Vec3::new(0.1, 0.0, 0.02),
        inertia: Matrix3::from_diagonal(&Vec3::new(0.02, 0.03, 0.025)) * mass,
        shapes: vec![Shape::Sphere { center: Vec3::zeros(), radius: 0.05 }],
    };
    Arc::new(character(links, vec![rod(5.0), rod(2.0), rod(1.0)]))
}

/// The arm raised and lowered by a script, without gravity, its root pinned: no load moves a rest away from its target.
fn wave() -> Pass {
    let c = arm();
    let pose = |shoulder: Vec3, elbow: f64, duration_s: f64| Pose {
        properties: Properties { duration_s: Some(duration_s), ..Properties::default() },
        values: vec![PoseValue::rotation("shoulder", exp(&shoulder)), PoseValue::scalar("elbow", elbow)],
    };
    let poses = vec![pose(Vec3::new(0.2, 0.0, 1.1), 0.8, 0.5), pose(Vec3::new(-0.3, 0.4, -0.2), -0.4, 0.7)];
    let cycles = vec![Cycle { repetitions: 2, properties: Properties::default(), poses }];
    let action = Action { name: "wave".into(), start_s: 0.1, properties: Properties::default(), cycles };
    let script = Script { properties: Properties::default(), actions: vec![action], inserts: Vec::new() };
    let tracks = script.build(&c.skeleton, &c.rest).unwrap();
    let setup = Setup {
        gravity: Vec3::zeros(),
        goal: Goal::new(&tracks.sample(240.0), 240.0),
        tracks: Some(tracks),
        dense: Default::default(),
        tension: 1.0,
        plants: Vec::new(),
        ground_m: None,
        contacts: motion::ContactPlan::default(),
        balance: BalanceSettings::default(),
        blend: GainBlend::RestAngle,
        character: c,
    };
    Pass {
        setup,
        reactive: Vec::new(),
        substeps: None,
        root: RootMode::Pinned,
        ground: None,
        tilts: Vec::new(),
        props: Vec::new(),
        self_collision: false,
        pushes: Vec::new(),
        carried: Vec::new(),
        past_fall: false,
        foresight: None,
        soles: Default::default(),
    }
}

/// Largest RMS of a joint against the motion asked for, degrees.
fn astray_deg(out: &Outcome) -> f64 {
    let errors = joint_errors(&out.trace.target_clip(), &out.trace.clip());
    errors.iter().map(|e| e.rms_deg).fold(0.0, f64::max)
}

/// The same pass in both engines: the kinematic one reaches what was asked, masses and muscles do not quite.
#[test]
fn an_engine_is_chosen_by_name() {
    let engines = engines();
    let run = |name: &str| wave().run(engines.get(name).unwrap(), &mut |_| {}).unwrap();
    let (exact, muscles) = (run("kinematic"), run("rapier"));
    let rows = Plan::new(wave().setup, &[]).goal.rows();
    for out in [&exact, &muscles] {
        assert_eq!(out.trace.rows(), rows);
        assert_eq!(out.diverged, None);
    }
    println!("{:.1e}° and {:.2}°", astray_deg(&exact), astray_deg(&muscles));
    assert!(astray_deg(&exact) < 1e-6, "{}", astray_deg(&exact));
    assert!(astray_deg(&muscles) > 0.1, "{}", astray_deg(&muscles));
    // the momentum on record is that of the state, whoever made it
    let last = 6 * (rows / 3);
    let momentum = &exact.trace.momentum[last..last + 3];
    assert!(momentum.iter().any(|p| p.abs() > 1e-3), "{momentum:?}");
}

/// What an engine cannot do is said before the first step, in its words.
#[test]
fn an_engine_refuses_in_its_own_words() {
    let mut pass = wave();
    pass.ground = Some(motion::Floor::level(0.0, 0.8));
    let refused = pass.start(engines().get("kinematic").unwrap()).err();
    assert_eq!(
        refused,
        Some(PassError::Engine(EngineError::Failed("a kinematic body touches no ground".into())))
    );
}

/// A name that no engine has is answered with the nearest one and all there are.
#[test]
fn an_unknown_engine_is_answered_with_the_nearest() {
    let words = |name: &str| engines().get(name).unwrap_err().to_string();
    assert_eq!(
        words("kinmatic"),
        "unknown engine `kinmatic`; did you mean `kinematic`? (allowed: rapier, core, kinematic)"
    );
    assert_eq!(words("physx"), "unknown engine `physx` (allowed: rapier, core, kinematic)");
}
