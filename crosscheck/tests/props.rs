//! Props and self-collision in three engines: the core, rapier and MuJoCo see the same solids.
//!
//! MuJoCo's Python environment is made on the first run.

use bodies::anthropometry::human::human;
use bodies::{Body, Carried, Character, JointClass, Prop};
use controllers::{Drive, Rest, rest_of};
use dynamics::Against;
use motion::{Floor, Joint, Link, Quat, Shape, Skeleton, Vec3};
use sim::{ContactForce, Engine, EngineSettings, Engines};

const G: f64 = 9.81;

fn settings(props: Vec<Prop>, self_collision: bool) -> EngineSettings {
    EngineSettings {
        rate_hz: 240.0,
        substeps: 4,
        gravity: Vec3::new(0.0, -G, 0.0),
        ground: Some(Floor::level(0.0, 0.8)),
        pinned: false,
        contact: Default::default(),
        props: props.into(),
        self_collision,
    }
}

/// What each engine comes to: its pose, and its contacts.
fn run(
    c: &Character,
    s: &EngineSettings,
    q: &[f64],
    steps: usize,
    drives: &dyn Fn(&dyn Engine) -> Vec<Drive>,
) -> Vec<(String, Vec<f64>, Vec<ContactForce>)> {
    let mut engines = Engines::default();
    engines.add(crosscheck::engine(|_| {}));
    ["core", "rapier", "mujoco"]
        .into_iter()
        .map(|name| {
            let mut engine =
                engines.get(name).unwrap().build(c, s.clone(), q, &vec![0.0; c.skeleton.nv()]).unwrap();
            for _ in 0..steps {
                let drives = drives(engine.as_ref());
                engine.set_drives(&drives);
                engine.step().unwrap();
            }
            let mut contacts = Vec::new();
            engine.contacts(&mut contacts);
            (name.into(), engine.q().to_vec(), contacts)
        })
        .collect()
}

fn on(contacts: &[ContactForce], against: Against) -> Vec3 {
    contacts.iter().filter(|c| c.against == against).map(|c| c.force).sum()
}

/// The human stands on a box, one foot beside it would be in the air: all of its weight is on the prop.
#[test]
fn slow_three_engines_stand_on_a_box() {
    let c = human().0;
    let step = Prop::upright("step", Vec3::zeros(), Vec3::new(0.8, 0.3, 0.8), 0.2, 0.8);
    let mut q = c.rest.clone();
    let at = c.skeleton.position(&q, 0);
    c.skeleton.set_position(&mut q, 0, &(at + Vec3::y() * 0.3));
    let hold = |e: &dyn Engine| -> Vec<Drive> {
        let drive = |i| Drive { stiffness: 5000.0, damping: 200.0, rest: rest_of(e.model(), i, &c.rest) };
        (0..e.model().bodies.len()).map(drive).collect()
    };
    let weight = c.mass() * G;
    let all = run(&c, &settings(vec![step], true), &q, 480, &hold);
    for (name, q, contacts) in &all {
        let (force, ground) = (on(contacts, Against::Prop(0)), on(contacts, Against::Ground));
        println!("{name}: root {:?}, {force:?} N on the box", &q[..3]);
        assert_eq!(ground, Vec3::zeros(), "{name}");
        assert!((force - Vec3::y() * weight).norm() < 1e-3 * weight, "{name}: {force:?}, {weight} N");
        let apart = Vec3::new(q[0] - all[0].1[0], q[1] - all[0].1[1], q[2] - all[0].1[2]).norm();
        assert!(apart < 1e-3, "{name}: {apart} m from the core"); // MuJoCo's contacts yield by 0.1 mm
    }
}

/// A post with an arm.
fn leaner() -> Character {
    let part = |mass: f64, at: Vec3, size: Vec3, shapes: Vec<Shape>| {
        let c = Carried::solid_box(0, mass, at, size);
        Body { mass, com: c.at, inertia: c.inertia, shapes }
    };
    let half = Vec3::new(0.2, 0.25, 0.2);
    let post = Shape::Box { center: Vec3::zeros(), half, rotation: Quat::identity() };
    let arm = Shape::Capsule { a: Vec3::zeros(), b: Vec3::z() * 0.8, radius: 0.03 };
    let skeleton = Skeleton::new(vec![
        Link::new("post", None, Vec3::zeros(), Joint::Free),
        Link::new("arm", Some(0), Vec3::new(0.0, 0.3, 0.2), Joint::Revolute(Vec3::x())),
    ])
    .unwrap();
    Character {
        name: "leaner".into(),
        classes: vec![JointClass::Root, JointClass::Other],
        rest: skeleton.zero_pose(),
        skeleton: skeleton.into(),
        bodies: vec![
            part(40.0, Vec3::zeros(), half * 2.0, vec![post]),
            part(3.0, Vec3::z() * 0.4, Vec3::new(0.05, 0.05, 0.8), vec![arm]),
        ],
        contacts: vec![],
    }
    .check()
    .unwrap()
}

/// An arm falls on a ramp and leans there: the same angle, the same force. The ramp has no friction, or the force would be what it happened
/// to come to rest with: the post stands by friction, and between the two any part of it may be locked in.
#[test]
fn slow_three_engines_lean_on_a_ramp() {
    let c = leaner();
    let ramp = Prop::ramp("slope", Vec3::new(0.0, 0.1, 0.5), (1.0, 0.6, 0.1), (0.4, 0.0), 0.0);
    let mut q = c.rest.clone();
    c.skeleton.set_position(&mut q, 0, &Vec3::new(0.0, 0.25, 0.0));
    // it starts a little raised; a weak muscle slows the fall
    q[7] = -0.5;
    let drives =
        |_: &dyn Engine| vec![Drive::NONE, Drive { stiffness: 4.0, damping: 2.0, rest: Rest::Scalar(0.0) }];
    let all = run(&c, &settings(vec![ramp], false), &q, 720, &drives);
    let first = (all[0].1[7], on(&all[0].2, Against::Prop(0)));
    assert!(first.1.norm() > 5.0, "the arm does not lean: {first:?}");
    for (name, q, contacts) in &all {
        let force = on(contacts, Against::Prop(0));
        let links: Vec<usize> =
            contacts.iter().filter(|c| c.against == Against::Prop(0)).map(|c| c.link).collect();
        println!("{name}: arm at {:.5} rad, {force:?} N on the ramp, {} points", q[7], links.len());
        assert!(links.iter().all(|l| *l == 1), "{name}: {links:?}");
        assert!((q[7] - first.0).abs() < 1e-3, "{name}: {} rad, {} in the core", q[7], first.0);
        assert!((force - first.1).norm() < 0.01 * first.1.norm(), "{name}: {force:?} {first:?}");
    }
}
