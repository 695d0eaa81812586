//! Laws of the world: what goes in comes out, and nothing pushes from nowhere.

mod solids;
mod tree;

use controllers::{Drive, Rest};
use dynamics::{Model, State};
use motion::{Floor, Joint, Link, Shape, Vec3};
use nalgebra::{DMatrix, DVector};
use sim::{Engine, EngineSettings, Rapier};
use solids::character;
use tree::{body, carries_its_limbs, start, tree};

fn settings(rate_hz: f64, substeps: usize) -> EngineSettings {
    EngineSettings::free(rate_hz, substeps, None)
}

/// What is put in is read back, root offset and turned frames included.
#[test]
fn state_round_trips() {
    let c = tree();
    let (q, v) = start(&c);
    let mut world = Rapier::new(&c, settings(1e6, 1), &q, &v).unwrap();
    world.step().unwrap(); // 1 µs: the state has hardly moved
    for (a, b) in world.q().iter().zip(&q) {
        assert!((a - b).abs() < 1e-5, "{a} {b}");
    }
    for (a, b) in world.v().iter().zip(&v) {
        assert!((a - b).abs() < 1e-4, "{a} {b}");
    }
}

/// The engine's acceleration is ours: forward dynamics by RNEA and the mass matrix, one tiny step.
#[test]
fn one_step_agrees_with_forward_dynamics() {
    let c = tree();
    let (q, v) = start(&c);
    let dt = 1e-6;
    let mut world = Rapier::new(&c, settings(1.0 / dt, 1), &q, &v).unwrap();
    world.step().unwrap();
    let model = Model::new(&c, Vec3::new(0.0, -9.81, 0.0));
    let mut state = State::new(&model);
    state.update(&model, &q, &v);
    let n = model.nv();
    let (mut m, mut bias) = (DMatrix::zeros(n, n), vec![0.0; n]);
    state.mass_matrix(&model, &mut m);
    state.inverse_dynamics(&model, &v, &vec![0.0; n], &[], &mut bias);
    let expected = -m.cholesky().unwrap().solve(&DVector::from_vec(bias));
    for k in 0..n {
        let engine = (world.v()[k] - v[k]) / dt;
        // O(dt) of the engine's implicit terms: 3e-4 seen on accelerations of order 10
        assert!((engine - expected[k]).abs() < 1e-2, "dof {k}: {engine} {}", expected[k]);
    }
}

/// A pinned root lands on its path, and the limbs feel its acceleration: the joint accelerations are
/// those of our forward dynamics with the root's acceleration prescribed.
#[test]
fn a_pinned_root_carries_its_limbs() {
    let c = tree();
    let (q, v) = start(&c);
    let dt = 1e-6;
    let mut world =
        Rapier::new(&c, EngineSettings { pinned: true, ..settings(1.0 / dt, 1) }, &q, &v).unwrap();
    carries_its_limbs(&mut world, &c, (&q, &v), dt);
}

/// In flight without gravity, momentum drifts by the integrator's first-order error only: a quarter
/// of the step, about a quarter of the drift.
#[test]
fn momentum_is_conserved_to_first_order() {
    let c = tree();
    let (q, v) = start(&c);
    let drift = |rate: f64| {
        let mut s = settings(rate, 1);
        s.gravity = Vec3::zeros();
        let mut world = Rapier::new(&c, s.clone(), &q, &v).unwrap();
        let mut state = State::new(&world.model);
        state.update(&world.model, world.q(), world.v());
        let before = state.momentum(&world.model);
        for _ in 0..rate as usize {
            world.step().unwrap();
        }
        state.update(&world.model, world.q(), world.v());
        let after = state.momentum(&world.model);
        ((after.linear - before.linear).norm(), (after.angular - before.angular).norm())
    };
    let (coarse, fine) = (drift(500.0), drift(2000.0));
    eprintln!("drift {coarse:?} {fine:?}");
    assert!(fine.0 < 0.4 * coarse.0 && fine.1 < 0.4 * coarse.1);
}

/// A box dropped on the ground comes to rest, carried by its weight.
#[test]
fn the_ground_carries_the_weight() {
    let half = Vec3::new(0.1, 0.1, 0.1);
    let shape = Shape::Box { center: Vec3::zeros(), half, rotation: motion::Quat::identity() };
    let links = vec![
        Link::new("box", None, Vec3::zeros(), Joint::Free),
        Link::new("rod", Some(0), Vec3::new(0.0, 0.1, 0.0), Joint::Revolute(Vec3::x())),
    ];
    let c = character(
        links,
        vec![body(5.0, Vec3::zeros(), vec![shape]), body(1.0, Vec3::new(0.0, 0.1, 0.0), vec![])],
    );
    let mut s = settings(240.0, 2);
    s.ground = Some(Floor::level(0.5, 0.8));
    let mut q = c.skeleton.zero_pose();
    q[1] = 0.605;
    let v = vec![0.0; c.skeleton.nv()];
    let mut world = Rapier::new(&c, s.clone(), &q, &v).unwrap();
    let hold = Drive { stiffness: 50.0, damping: 1.0, rest: Rest::Scalar(0.0) };
    for _ in 0..480 {
        world.set_drives(&[Drive::NONE, hold]);
        world.step().unwrap();
    }
    let force = world.contact_sum();
    assert!((force.y - 6.0 * 9.81).abs() < 1e-6, "{force}"); // 1e-9 seen
    assert!(force.x.abs() < 1e-6 && force.z.abs() < 1e-6);
}

/// A ball that swings and spins into its limits, and a hinge thrown at its end, are turned back by their
/// stops; without stops both go far beyond. The energy never grows.
#[test]
fn stops_turn_joints_back_at_the_ends_of_their_range() {
    use motion::{BallLimits, Limits, Range};
    let mut links = vec![
        Link::new("base", None, Vec3::zeros(), Joint::Fixed),
        Link::new("ball", Some(0), Vec3::zeros(), Joint::Spherical),
        Link::new("hinge", Some(0), Vec3::new(1.0, 0.0, 0.0), Joint::Revolute(Vec3::x())),
    ];
    let range = Range::new(-0.4, 0.4);
    let axes = [Vec3::x(), Vec3::z(), Vec3::y()];
    let swing_and_twist = BallLimits { axes, ranges: [range; 3] };
    links[1].limits = Some(Limits::Ball(swing_and_twist));
    links[2].limits = Some(Limits::Axis(range));
    let rod = || body(1.0, Vec3::new(0.0, 0.2, 0.0), vec![]);
    let c = character(links, vec![body(1.0, Vec3::zeros(), vec![]), rod(), rod()]);
    let mut s = settings(480.0, 2);
    s.gravity = Vec3::zeros();
    let q = c.skeleton.zero_pose();
    let v = vec![0.8, 3.0, 0.6, 2.0];
    let run = |stops: f64| {
        let mut world = Rapier::new(&c, s.clone(), &q, &v).unwrap();
        world.set_stops(&[stops; 3]);
        let mut state = State::new(&world.model);
        let (mut furthest, mut most): (f64, f64) = (0.0, 0.0);
        let slack = Drive { stiffness: 1e-9, damping: 0.0, rest: Rest::ball(motion::Quat::identity()) };
        let hinge = Drive { rest: Rest::Scalar(0.0), ..slack };
        for _ in 0..960 {
            world.set_drives(&[Drive::NONE, slack, hinge]);
            world.step().unwrap();
            let r = c.skeleton.rotation(world.q(), 1);
            furthest = furthest.max(swing_and_twist.coords(&r).amax()).max(world.q()[4].abs());
            state.update(&world.model, world.q(), world.v());
            most = most.max(state.energy(&world.model).0);
        }
        state.update(&world.model, &q, &v);
        (furthest, most, state.energy(&world.model).0)
    };
    let (furthest, most, start) = run(200.0);
    eprintln!("furthest {furthest} rad, energy {most} of {start} J");
    assert!(furthest < 0.5, "{furthest} rad"); // 0.45 seen
    assert!(most <= start * (1.0 + 1e-6), "{most} J from {start} J");
    assert!(run(0.0).0 > 1.0, "without stops they go on");
}

/// A cone that is set on its flat end stays there, whichever end it is: the end is touched all round.
#[test]
fn a_cone_rests_on_its_base() {
    let (low, high) = (0.05, 0.4);
    for (radius_a, radius_b) in [(0.1, 0.03), (0.06, 0.12)] {
        let (a, b) = (Vec3::zeros(), Vec3::new(0.0, high, 0.0));
        let shape = Shape::Cone { a, b, radius_a, radius_b };
        let com = Vec3::new(0.0, low, 0.0);
        let inertia = nalgebra::Matrix3::from_diagonal(&Vec3::new(0.05, 0.02, 0.05));
        let part = bodies::Body { mass: 5.0, com, inertia, shapes: vec![shape] };
        let c = character(vec![Link::new("cone", None, Vec3::zeros(), Joint::Free)], vec![part]);
        let q = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
        let settings = EngineSettings { ground: Some(Floor::level(0.0, 0.8)), ..settings(240.0, 2) };
        let mut world = Rapier::new(&c, settings, &q, &[0.0; 6]).unwrap();
        for _ in 0..720 {
            world.step().unwrap();
        }
        let [x, y, z, w, ..] = world.q()[..4] else { unreachable!() };
        let tilt_deg = 2.0 * w.abs().min(1.0).acos().to_degrees();
        println!("radius {radius_a} m: moved to {x:.5} {y:.5} {z:.5} m, tilted by {tilt_deg:.3}°");
        // 0.02° and 0.3 mm seen
        assert!(tilt_deg < 0.2 && x.hypot(z) < 2e-3 && y.abs() < 2e-3, "{:?}", world.q());
    }
}
