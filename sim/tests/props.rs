//! Laws of props and of self-collision, in the core and in rapier: a prop carries what stands on it, friction on a ramp is Coulomb's, links
//! push each other equally and the whole not at all.

mod brick;
mod solids;

use std::f64::consts::FRAC_PI_2;

use bodies::{Body, Carried, Character, Prop};
use brick::{HALF, MASS, solid_box};
use controllers::{Drive, Rest};
use dynamics::{Against, Model, State};
use motion::{Floor, Joint, Link, Shape, Vec3};
use sim::{ContactForce, Core, Engine, EngineSettings, Rapier};
use solids::character;

const G: f64 = 9.81;

fn settings(props: Vec<Prop>, ground: Option<Floor>) -> EngineSettings {
    EngineSettings {
        rate_hz: 240.0,
        substeps: 2,
        gravity: Vec3::new(0.0, -G, 0.0),
        ground,
        pinned: false,
        contact: Default::default(),
        props: props.into(),
        self_collision: false,
    }
}

fn engines(c: &Character, settings: &EngineSettings, q: &[f64], v: &[f64]) -> [Box<dyn Engine>; 2] {
    [
        Box::new(Core::new(c, settings.clone(), q, v).unwrap()),
        Box::new(Rapier::new(c, settings.clone(), q, v).unwrap()),
    ]
}

fn contacts(engine: &dyn Engine) -> Vec<ContactForce> {
    let mut all = Vec::new();
    engine.contacts(&mut all);
    all
}

/// The box of the tests with its lower face on a plane through `on`, whose normal is `prop`'s upward direction.
fn laid(c: &Character, prop: &Prop, on: Vec3) -> Vec<f64> {
    let mut q = c.rest.clone();
    c.skeleton.set_position(&mut q, 0, &(on + prop.up() * HALF[1]));
    let r = prop.place.rotation;
    q[3..7].copy_from_slice(&[r.w, r.i, r.j, r.k]);
    q
}

/// A box dropped on a box rests at its height and is carried with its weight, by the prop and not by the ground below.
#[test]
fn a_box_rests_on_a_box() {
    let c = solid_box();
    let prop = Prop::upright("table", Vec3::new(0.1, 0.0, 0.0), Vec3::new(0.6, 0.4, 0.7), 0.3, 0.8);
    let s = settings(vec![prop], Some(Floor::level(0.0, 0.8)));
    let mut q = c.rest.clone();
    c.skeleton.set_position(&mut q, 0, &Vec3::new(0.0, 0.4 + HALF[1] + 0.05, 0.0));
    for mut engine in engines(&c, &s, &q, &[0.0; 6]) {
        for _ in 0..480 {
            engine.step().unwrap();
        }
        let all = contacts(engine.as_ref());
        let force: Vec3 = all.iter().map(|c| c.force).sum();
        let (height, name) = (engine.q()[1] - 0.4 - HALF[1], engine.name());
        println!(
            "{name}: {} contacts, {height:.1e} m over its rest, {:.1e} N too much",
            all.len(),
            force.y - MASS * G
        );
        assert!(all.iter().all(|c| c.against == Against::Prop(0)), "{name}: {all:?}");
        assert!(height.abs() < 2e-4, "{name}: {height}"); // 2e-5 m in the core, 3e-6 in rapier
        assert!((force - Vec3::y() * (MASS * G)).norm() < 1e-3 * MASS * G, "{name}: {force:?}");
        assert!(engine.v().iter().all(|v| v.abs() < 1e-3), "{name}: {:?}", engine.v());
    }
}

/// On a ramp steeper than atan μ a box slides with g (sin α − μ cos α), below that it stays, and the prop's own friction is what counts.
#[test]
fn friction_on_a_ramp_is_coulombs() {
    let c = solid_box();
    for (mu, rise) in [(0.4f64, 0.30f64), (0.4, 0.45), (0.2, 0.15), (0.2, 0.30)] {
        let prop = Prop::ramp("slope", Vec3::zeros(), (4.0, 1.0, 0.1), (rise, FRAC_PI_2), mu);
        let up_slope = Vec3::new(rise.cos(), rise.sin(), 0.0);
        let q = laid(&c, &prop, up_slope * 3.0);
        let s = settings(vec![prop], Some(Floor::level(-1.0, 0.8)));
        for mut engine in engines(&c, &s, &q, &[0.0; 6]) {
            for _ in 0..120 {
                engine.step().unwrap();
            }
            let speed = -Vec3::new(engine.v()[0], engine.v()[1], engine.v()[2]).dot(&up_slope);
            let expected = (0.5 * G * (rise.sin() - mu * rise.cos())).max(0.0);
            let name = engine.name();
            println!("{name}: μ {mu}, {rise} rad: {speed:.5} m/s, Coulomb {expected:.5}");
            // rapier's sweeps end where friction does not quite oppose slip: a tenth of it is missing, as on tilted ground
            let missing = if name == "core" { 1e-4 } else { 0.1 * 0.5 * G * mu * rise.cos() };
            let slides = expected > 0.0;
            assert!((speed > 0.1) == slides, "{name} {mu} {rise}: {speed}");
            assert!(
                (speed - expected).abs() < if slides { missing } else { 1e-4 },
                "{name} {mu} {rise}: {speed} {expected}"
            );
        }
    }
}

/// A trunk with two arms whose hands meet in front of it.
fn clapper(distance: f64) -> Character {
    let part = |mass: f64, at: Vec3, size: Vec3, shapes: Vec<Shape>| {
        let c = Carried::solid_box(0, mass, at, size);
        Body { mass, com: c.at, inertia: c.inertia, shapes }
    };
    let trunk = part(20.0, Vec3::zeros(), Vec3::new(0.4, 0.5, 0.2), vec![]);
    let arm = |side: f64| {
        let hand = |y: f64| Vec3::new(0.0, y, 0.5);
        // hands are upright capsules, parallel to each other; one arm is heavier
        let shapes = vec![Shape::Capsule { a: hand(-0.05), b: hand(0.05), radius: 0.03 }];
        part(2.0 + 0.5 * side, Vec3::new(0.0, 0.0, 0.25), Vec3::new(0.06, 0.08, 0.5), shapes)
    };
    let hinge =
        |name: &str, x: f64| Link::new(name, Some(0), Vec3::new(x, 0.1, 0.0), Joint::Revolute(Vec3::y()));
    let links = vec![
        Link::new("trunk", None, Vec3::zeros(), Joint::Free),
        hinge("hand_l", distance),
        hinge("hand_r", -distance),
    ];
    character(links, vec![trunk, arm(1.0), arm(-1.0)])
}

/// Two hands pressed together: equal and opposite forces, by the torque of the muscles; nothing of them reaches the momentum of the whole.
#[test]
fn hands_push_each_other_equally() {
    let c = clapper(0.1);
    let mut s = settings(vec![], None);
    s.self_collision = true;
    // the law of the angular momentum is one of substeps
    s.substeps = 1;
    let mut q = c.rest.clone();
    c.skeleton.set_position(&mut q, 0, &Vec3::new(0.0, 1.0, 0.0));
    let v = [0.3, 0.0, -0.2, 0.1, 0.2, -0.1, 0.0, 0.0];
    let model = Model::new(&c, s.gravity);
    // each hand is asked to go where the other one is
    let rest = |turn: f64| Drive { stiffness: 40.0, damping: 4.0, rest: Rest::Scalar(turn) };
    let drives = [Drive::NONE, rest(-0.4), rest(0.4)];
    let momentum = |engine: &dyn Engine| {
        let mut state = State::new(&model);
        state.update(&model, engine.q(), engine.v());
        let m = state.momentum(&model);
        (m.linear, m.about(&Vec3::zeros()), m.com)
    };
    for mut engine in engines(&c, &s, &q, &v) {
        let name = engine.name().to_owned();
        let (dt, mut worst) = (1.0 / s.rate_hz, [0.0f64; 2]);
        let (mut touched, mut press) = (0, 0.0);
        for _ in 0..240 {
            let (p, l, com) = momentum(engine.as_ref());
            engine.set_drives(&drives);
            engine.step().unwrap();
            let (p1, l1, _) = momentum(engine.as_ref());
            let all = contacts(engine.as_ref());
            let pairs = all.chunks_exact(2);
            let across = motion::skeleton::quat_at(engine.q(), 3) * Vec3::x();
            assert!(pairs.remainder().is_empty());
            if name == "core" {
                let weight = s.gravity * (model.mass * dt);
                let scale = p.norm() + weight.norm();
                worst[0] = worst[0].max((p1 - p - weight).norm() / scale);
                let turn = l1 - l - com.cross(&weight);
                worst[1] = worst[1].max(turn.norm() / scale);
            }
            press = 0.0;
            for pair in all.chunks_exact(2) {
                let [a, b] = [&pair[0], &pair[1]];
                assert_eq!((a.force + b.force, a.point - b.point), (Vec3::zeros(), Vec3::zeros()));
                assert_eq!((a.against, b.against), (Against::Link(b.link), Against::Link(a.link)));
                touched += 1;
                press += a.force.dot(&across).abs();
            }
        }
        println!("{name}: {touched} pairs, at the end {press:.3} N; momentum per step off by {worst:?}");
        // each muscle's torque 40 N·m/rad × (0.4 − turn), at half a metre along the arm
        let turn = 0.5 * (engine.q()[8] - engine.q()[7]);
        let expected = 40.0 * (0.4 - turn) / (0.5 * turn.cos());
        assert!(touched > 200, "{name}: {touched}");
        assert!((press / expected - 1.0).abs() < 0.03, "{name}: {press} N, {expected} expected");
        assert!(worst[0] < 1e-12 && worst[1] < 1e-12, "{worst:?}");
    }
}

/// Without the switch hands pass through each other.
#[test]
fn self_collision_is_off_unless_asked_for() {
    let c = clapper(0.1);
    let s = settings(vec![], None);
    let rest = |turn: f64| Drive { stiffness: 40.0, damping: 4.0, rest: Rest::Scalar(turn) };
    let mut q = c.rest.clone();
    c.skeleton.set_position(&mut q, 0, &Vec3::new(0.0, 1.0, 0.0));
    for mut engine in engines(&c, &s, &q, &[0.0; 8]) {
        for _ in 0..240 {
            engine.set_drives(&[Drive::NONE, rest(-0.4), rest(0.4)]);
            engine.step().unwrap();
        }
        assert!(contacts(engine.as_ref()).is_empty());
        assert!(engine.q()[7] < -0.35 && engine.q()[8] > 0.35, "{}: {:?}", engine.name(), engine.q());
    }
}

/// A body that begins inside a prop is refused by name and depth; one that touches it is not.
#[test]
fn a_body_that_begins_in_a_prop_is_named() {
    let c = solid_box();
    let prop = Prop::upright("table", Vec3::zeros(), Vec3::new(2.0, 0.4, 2.0), 0.0, 0.8);
    let at = |height: f64| {
        let mut q = c.rest.clone();
        c.skeleton.set_position(&mut q, 0, &Vec3::new(0.0, height + HALF[1], 0.0));
        sim::core::overlap(&c, &q, std::slice::from_ref(&prop))
    };
    let deep = at(0.37).unwrap();
    assert_eq!((deep.link.as_str(), deep.prop.as_str()), (c.skeleton.links()[0].name.as_str(), "table"));
    assert!((deep.depth_m - 0.03).abs() < 1e-6, "{deep:?}"); // 1e-8 m
    assert!(at(0.4).is_none_or(|o| o.depth_m < 1e-6), "{:?}", at(0.4));
    assert_eq!(at(0.5), None);
    assert_eq!(sim::core::overlap(&c, &c.rest, &[]), None);
}
