//! Laws of the core: what goes in comes out, nothing pushes from nowhere, friction is Coulomb's.

mod brick;
mod solids;
mod tree;

use bodies::Body;
use bodies::anthropometry::human::human;
use brick::{HALF, MASS, solid_box};
use controllers::{Drive, Rest};
use dynamics::{Model, State};
use motion::rotation::exp;
use motion::{Floor, Joint, Link, Quat, Shape, Vec3};
use nalgebra::Matrix3;
use sim::{ContactForce, ContactLaw, Core, Engine, EngineSettings, Ledger};
use solids::character;
use tree::{body, carries_its_limbs, start, tree};

const G: f64 = 9.81;

fn settings(rate_hz: f64, substeps: usize, ground: Option<Floor>) -> EngineSettings {
    EngineSettings::free(rate_hz, substeps, ground)
}

fn ledger(core: &Core) -> Ledger {
    *core.ledger().unwrap()
}

fn energy(core: &Core) -> f64 {
    let mut state = State::new(&core.model);
    state.update(&core.model, core.q(), core.v());
    let (kinetic, potential) = state.energy(&core.model);
    kinetic + potential
}

/// Linear momentum, and angular momentum about the world's origin.
fn momentum(core: &Core) -> (Vec3, Vec3) {
    let mut state = State::new(&core.model);
    state.update(&core.model, core.q(), core.v());
    let m = state.momentum(&core.model);
    (m.linear, m.about(&Vec3::zeros()))
}

fn contacts(core: &Core) -> Vec<ContactForce> {
    let mut all = Vec::new();
    core.contacts(&mut all);
    all
}

fn force(core: &Core) -> Vec3 {
    contacts(core).iter().map(|c| c.force).sum()
}

/// A box that lies flat on a floor.
fn lying(ground: Floor, rate_hz: f64, contact: ContactLaw, velocity: Vec3) -> Core {
    let c = solid_box();
    let mut q = c.rest.clone();
    c.skeleton.set_position(&mut q, 0, &(ground.pivot() + ground.up * HALF[1]));
    let r = ground.turn();
    q[3..7].copy_from_slice(&[r.w, r.i, r.j, r.k]);
    let v = [velocity.x, velocity.y, velocity.z, 0.0, 0.0, 0.0];
    Core::new(&c, EngineSettings { contact, ..settings(rate_hz, 1, Some(ground)) }, &q, &v).unwrap()
}

/// Forward is the inverse of inverse: the velocity change of one tiny step, put into inverse dynamics, needs no forces.
#[test]
fn forward_is_the_inverse_of_inverse() {
    let c = tree();
    let (q, v) = start(&c);
    let dt = 1e-7;
    let mut core = Core::new(&c, settings(1.0 / dt, 1, None), &q, &v).unwrap();
    core.step().unwrap();
    let vd: Vec<f64> = core.v().iter().zip(&v).map(|(a, b)| (a - b) / dt).collect();
    let model = Model::new(&c, Vec3::new(0.0, -G, 0.0));
    let mut state = State::new(&model);
    state.update(&model, &q, &v);
    let mut tau = vec![0.0; model.nv()];
    state.inverse_dynamics(&model, &v, &vd, &[], &mut tau);
    let worst = tau.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
    println!("left over {worst:.1e} N, N·m");
    assert!(worst < 1e-4, "{tau:?}"); // 6e-6 seen, of order dt
}

/// A pinned root lands on its path, and the limbs feel its acceleration.
#[test]
fn a_pinned_root_carries_its_limbs() {
    let c = tree();
    let (q, v) = start(&c);
    let dt = 1e-6;
    let mut core =
        Core::new(&c, EngineSettings { pinned: true, ..settings(1.0 / dt, 1, None) }, &q, &v).unwrap();
    carries_its_limbs(&mut core, &c, (&q, &v), dt);
}

/// A thrown box slides for v²/(2 μ g), stops, and stays.
#[test]
fn a_box_slides_and_stops_where_coulomb_says() {
    let (friction, speed) = (0.3, 2.0);
    for rate in [240.0, 960.0] {
        let way = Vec3::new(0.6, 0.0, 0.8);
        let mut core = lying(Floor::level(0.0, friction), rate, ContactLaw::Stiff, way * speed);
        let at = |core: &Core| Vec3::new(core.q()[0], 0.0, core.q()[2]);
        for _ in 0..rate as usize {
            core.step().unwrap();
        }
        let (there, expected) = (at(&core), speed * speed / (2.0 * friction * G));
        for _ in 0..rate as usize {
            core.step().unwrap();
        }
        let (length, aside, crept) =
            (there.dot(&way), (there - way * there.dot(&way)).norm(), (at(&core) - there).norm());
        println!("{rate} Hz: {length:.5} m of {expected:.5}, aside {aside:.1e}, crept {crept:.1e}");
        // velocities are those of the end of a step: v dt/2 short, 4.1 mm at 240 Hz
        assert!((length - expected + 0.5 * speed / rate).abs() < 2e-4, "{length} {expected}");
        assert!(aside < 1e-4 && crept < 1e-9, "{aside} {crept}");
        // friction took the energy
        let lost = 0.5 * MASS * speed * speed;
        assert!((ledger(&core).friction_j + lost).abs() < 0.01 * lost, "{} J", ledger(&core).friction_j);
    }
}

/// Below atan μ a box sticks, whichever way the slope faces; above it slides with g (sin α − μ cos α).
#[test]
fn a_slope_holds_below_the_friction_angle_and_lets_go_above() {
    let friction: f64 = 0.5;
    let limit = friction.atan();
    for towards in [0.0, 0.8, -2.5] {
        for part in [0.5, 0.98, 1.02, 1.5] {
            let tilt = limit * part;
            let ground = Floor::level(0.7, friction).tilted(tilt, towards);
            let mut core = lying(ground, 240.0, ContactLaw::Stiff, Vec3::zeros());
            for _ in 0..240 {
                core.step().unwrap();
            }
            let speed = Vec3::new(core.v()[0], core.v()[1], core.v()[2]).norm();
            let expected = G * (tilt.sin() - friction * tilt.cos()).max(0.0);
            println!("{part} of the limit, towards {towards}: {speed:.6} m/s, expected {expected:.6}");
            assert!((speed - expected).abs() < 1e-6, "{speed} {expected}");
            if part < 1.0 {
                assert!((force(&core) - Vec3::y() * (MASS * G)).norm() < 1e-5 * MASS * G);
            }
        }
    }
}

/// A box on twelve points, four of which would do, carries its weight and does not move; each substep is solved.
#[test]
fn a_redundantly_supported_box_rests() {
    let mut c = solid_box();
    let half = Vec3::from(HALF);
    // a second box with the same foot, and a ball that touches in the middle
    c.bodies[0].shapes.push(Shape::Box {
        center: Vec3::y() * -0.02,
        half: Vec3::new(0.1, 0.03, 0.1),
        rotation: Quat::identity(),
    });
    c.bodies[0].shapes.push(Shape::Sphere { center: Vec3::zeros(), radius: half.y });
    let mut q = c.rest.clone();
    q[1] = half.y;
    let mut core = Core::new(&c, settings(240.0, 2, Some(Floor::level(0.0, 0.8))), &q, &[0.0; 6]).unwrap();
    for _ in 0..480 {
        core.step().unwrap();
    }
    assert_eq!(contacts(&core).len(), 9);
    let moved = core.v().iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    println!("moves at {moved:.1e}, {} N, {:?}", force(&core), ledger(&core));
    assert!(moved < 1e-7, "{moved}"); // 7e-9 seen: a residual of 1e-7 m g dt
    assert!((force(&core) - Vec3::y() * (MASS * G)).norm() < 1e-6 * MASS * G);
    assert_eq!(ledger(&core).above_tight, 0);
}

/// A rod that falls with one end first: the end stops and the impulse is that of the two equations of a rod, P = m v/(1 + 3 cos²).
#[test]
fn a_rod_strikes_the_ground_with_its_impulse() {
    let (mass, length) = (3.0, 1.2);
    let inertia = mass * length * length / 12.0;
    let end = |s: f64| Shape::Sphere { center: Vec3::x() * (0.5 * length * s), radius: 0.0 };
    let rod = Body {
        mass,
        com: Vec3::zeros(),
        inertia: Matrix3::from_diagonal(&Vec3::new(1e-3, inertia, inertia)),
        shapes: vec![end(-1.0), end(1.0)],
    };
    let c = character(vec![Link::new("rod", None, Vec3::zeros(), Joint::Free)], vec![rod]);
    let angle: f64 = 0.5;
    let r = exp(&(Vec3::z() * angle));
    let mut q = c.rest.clone();
    q[1] = 0.5 * length * angle.sin();
    q[3..7].copy_from_slice(&[r.w, r.i, r.j, r.k]);
    let speed = 3.0;
    let rate = 1e5;
    // no gravity and no friction: nothing but the impact
    let s = EngineSettings { gravity: Vec3::zeros(), ..settings(rate, 1, Some(Floor::level(0.0, 0.0))) };
    let mut core = Core::new(&c, s, &q, &[0.0, -speed, 0.0, 0.0, 0.0, 0.0]).unwrap();
    core.step().unwrap();
    let arm = 0.5 * length * angle.cos();
    let expected = speed / (1.0 / mass + arm * arm / inertia);
    let impulse = force(&core).y / rate;
    println!("{impulse} N·s, expected {expected}");
    assert!((impulse - expected).abs() < 1e-4 * expected, "{impulse} {expected}");
    // 1 of the ledger's momentum, by another road: P/m up, P arm/I about z
    assert!((core.v()[1] - (expected / mass - speed)).abs() < 1e-3);
    assert!((core.v()[5] + expected * arm / inertia).abs() < 1e-3);
}

/// A load on springs of k N/m at n points sinks by m g/(n k).
#[test]
fn compliant_ground_sinks_by_its_stiffness() {
    for (stiffness, damping) in [(2e4, 400.0), (1e5, 0.0)] {
        let law = ContactLaw::Compliant { stiffness_n_m: stiffness, damping_n_s_m: damping };
        let mut core = lying(Floor::level(0.0, 0.8), 480.0, law, Vec3::zeros());
        for _ in 0..4800 {
            core.step().unwrap();
        }
        let (sink, expected) = (HALF[1] - core.q()[1], MASS * G / (4.0 * stiffness));
        println!("sinks {sink:.9} m, expected {expected:.9}");
        assert!((sink - expected).abs() < 1e-6 * expected, "{sink} {expected}"); // 1e-12 seen
    }
}

/// A limp human that tumbles on the ground, and the force and moment the ground gives it, per substep: nothing else changes its momentum.
#[test]
fn momentum_changes_by_outside_forces_only() {
    let c = human().0;
    let rate = 240.0;
    let mut q = c.rest.clone();
    let spin = Vec3::new(2.0, 1.0, -1.5);
    let r = exp(&(spin * 0.2));
    q[1] += 0.4;
    q[3..7].copy_from_slice(&[r.w, r.i, r.j, r.k]);
    let mut v = vec![0.0; c.skeleton.nv()];
    v[2] = 1.0;
    v[3..6].copy_from_slice(spin.as_slice());
    let mut core = Core::new(&c, settings(rate, 1, Some(Floor::level(0.0, 0.8))), &q, &v).unwrap();
    let limp = vec![Drive { stiffness: 1.0, damping: 2.0, rest: Rest::None }; core.model.bodies.len()];
    let mut state = State::new(&core.model);
    let (mass, mut worst, mut halved, mut links, mut gained) =
        (core.model.mass, [0.0_f64; 2], 0.0_f64, 0, 0.0_f64);
    let weight = mass * G / rate;
    let mut before_j = energy(&core);
    for _ in 0..480 {
        state.update(&core.model, core.q(), core.v());
        let com = state.com(&core.model);
        let (p, l) = momentum(&core);
        core.set_drives(&limp);
        let halvings = ledger(&core).halved;
        core.step().unwrap();
        let mut linear = Vec3::y() * -weight;
        let mut angular = com.cross(&linear);
        for c in contacts(&core) {
            linear += c.force / rate;
            angular += c.point.cross(&(c.force / rate));
        }
        links = links.max(contacts(&core).len());
        let (p1, l1) = momentum(&core);
        let scale = p.norm() + weight;
        worst[0] = worst[0].max((p1 - p - linear).norm() / scale);
        let turned = (l1 - l - angular).norm() / scale;
        // contacts on record are at the mean of their places, which moments of a step that was halved are not exactly about
        if ledger(&core).halved > halvings {
            halved = halved.max(turned);
        } else {
            worst[1] = worst[1].max(turned);
        }
        let now = energy(&core);
        gained += (now - before_j).max(0.0);
        before_j = now;
    }
    let ledger = ledger(&core);
    println!("residual {worst:?}, {halved:.1e} where halved, {links} points at once, gained {gained:.3} J");
    println!(
        "corrections {:.4} % of body weight RMS, {ledger:?}",
        100.0 * ledger.correction_rms_n(rate) / (mass * G)
    );
    assert!(links >= 10);
    assert!(worst[0] < 1e-12 && worst[1] < 1e-12 && halved < 1e-3, "{worst:?} {halved}");
    assert!(gained < 1e-9, "{gained} J");
}

/// A chain that swings without friction drifts in energy by the first order of the step.
#[test]
fn a_swinging_chain_drifts_in_energy_to_first_order() {
    let mut links = vec![Link::new("base", None, Vec3::zeros(), Joint::Fixed)];
    let mut bodies = vec![body(1.0, Vec3::zeros(), vec![])];
    for i in 0..5 {
        let joint = if i % 2 == 0 { Joint::Spherical } else { Joint::Revolute(Vec3::z()) };
        links.push(Link::new(format!("link{i}"), Some(i), Vec3::new(0.3, 0.0, 0.0), joint));
        bodies.push(body(1.0, Vec3::new(0.15, 0.0, 0.02), vec![]));
    }
    let c = character(links, bodies);
    let v: Vec<f64> = (0..c.skeleton.nv()).map(|i| 0.5 * (i as f64 * 2.3).cos()).collect();
    let drift = |rate: f64| {
        let mut core = Core::new(&c, settings(rate, 1, None), &c.rest, &v).unwrap();
        let before = energy(&core);
        for _ in 0..(0.5 * rate) as usize {
            core.step().unwrap();
        }
        (energy(&core) - before).abs()
    };
    // above that a part of second order is as large and of the other sign
    let all: Vec<f64> = [4000.0, 8000.0, 16000.0, 32000.0].map(drift).to_vec();
    let orders: Vec<f64> = all.windows(2).map(|w| (w[0] / w[1]).log2()).collect();
    println!("drifts {all:?} J, orders {orders:?}");
    assert!(orders.iter().all(|o| (0.85..1.2).contains(o)), "{orders:?}");
}

/// A fast top under gravity precesses at about m g l/(I₃ ω) and nutates at I₃ ω/I₁.
#[test]
fn a_top_precesses_and_nutates() {
    let (mass, arm, spin) = (0.5, 0.06, 400.0);
    let (along, across) = (4e-4, 5e-4);
    let top = Body {
        mass,
        com: Vec3::y() * arm,
        inertia: Matrix3::from_diagonal(&Vec3::new(across, along, across)),
        shapes: vec![],
    };
    let links = vec![
        Link::new("base", None, Vec3::zeros(), Joint::Fixed),
        Link::new("top", Some(0), Vec3::zeros(), Joint::Spherical),
    ];
    let c = character(links, vec![body(1.0, Vec3::zeros(), vec![]), top]);
    let lean: f64 = 0.5;
    let r = exp(&(Vec3::z() * -lean));
    let mut q = c.rest.clone();
    q[0..4].copy_from_slice(&[r.w, r.i, r.j, r.k]);
    let axis = r * Vec3::y();
    let about = across + mass * arm * arm; // about the tip
    let rate = 40_000.0;
    let mut core = Core::new(&c, settings(rate, 1, None), &q, (axis * spin).as_slice()).unwrap();
    let (mut heading, mut last, mut tilts) = (0.0, 0.0_f64, Vec::new());
    let seconds = 1.0;
    for _ in 0..(seconds * rate) as usize {
        core.step().unwrap();
        let now = c.skeleton.rotation(core.q(), 1) * Vec3::y();
        let angle = (-now.z).atan2(now.x);
        let mut turn = angle - last;
        turn -= (turn / std::f64::consts::TAU).round() * std::f64::consts::TAU;
        heading += turn;
        last = angle;
        tilts.push(now.y.acos());
    }
    let precession = heading / seconds;
    // the slow root of (I₁ − I₃) cos θ Ω² − I₃ ω Ω + m g l = 0
    let (a, b) = ((about - along) * lean.cos(), along * spin);
    let expected = (b - (b * b - 4.0 * a * mass * G * arm).sqrt()) / (2.0 * a);
    let crossings = tilts.windows(3).filter(|w| w[0] < w[1] && w[1] >= w[2]).count();
    let nutation = along * spin / about / std::f64::consts::TAU;
    println!(
        "precesses at {precession:.4} rad/s, expected {expected:.4}; nutates at {crossings} Hz, expected {nutation:.2}"
    );
    assert!((precession - expected).abs() < 0.03 * expected);
    assert!((crossings as f64 - nutation).abs() < 1.0);
}
