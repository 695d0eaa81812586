//! Laws of a fall: every newton that stops a body is on record.

use std::collections::BTreeSet;

use controllers::{Drive, Rest};
use dynamics::{Model, State};
use motion::rotation::exp;
use motion::{Floor, Vec3};
use sim::{Engine, EngineSettings, Rapier};

const G: f64 = 9.81;

/// What came of a limp human that was thrown on the ground.
#[derive(Debug)]
struct Tumble {
    /// RMS over 2 s of d(momentum)/dt − m g − Σ contacts, over body weight.
    unexplained: f64,
    /// The same of the moment about the centre of mass, over body weight times a metre.
    unexplained_moment: f64,
    /// How far the centre of mass is from where the momenta on record carry it, m.
    astray: f64,
    /// Sum of all rises of the energy, J.
    gained: f64,
    /// Links that touched the ground.
    links: usize,
}

fn tumble(spin: Vec3, ground: Floor) -> Tumble {
    let (human, _) = bodies::anthropometry::human::human();
    let (gravity, rate_hz, steps) = (Vec3::y() * -G, 240.0, 480);
    let settings = EngineSettings {
        rate_hz,
        substeps: 2,
        gravity,
        ground: Some(ground),
        pinned: false,
        contact: Default::default(),
        props: Default::default(),
        self_collision: false,
    };
    let mut q = human.rest.clone();
    let r = exp(&(spin * 0.2));
    q[3..7].copy_from_slice(&[r.w, r.i, r.j, r.k]);
    q[1] += 0.4;
    let mut v = vec![0.0; human.skeleton.nv()];
    v[2] = 1.0;
    v[3..6].copy_from_slice(spin.as_slice());
    let mut world = Rapier::new(&human, settings, &q, &v).unwrap();
    let model = Model::new(&human, gravity);
    let limp = vec![Drive { stiffness: 1.0, damping: 2.0, rest: Rest::None }; model.bodies.len()];
    let mut state = State::new(&model);
    state.update(&model, world.q(), world.v());
    let mut before = state.momentum(&model);
    let (mut force_squares, mut moment_squares, mut gained) = (0.0, 0.0, 0.0);
    let (mut carried, mut energy) = (before.com, f64::INFINITY);
    let mut links = BTreeSet::new();
    for _ in 0..steps {
        world.set_drives(&limp);
        world.step().unwrap();
        state.update(&model, world.q(), world.v());
        let after = state.momentum(&model);
        let mut touching = Vec::new();
        world.contacts(&mut touching);
        links.extend(touching.iter().map(|c| c.link));
        let mut force = (after.linear - before.linear) * rate_hz - gravity * model.mass;
        let mut moment = (after.angular - before.angular) * rate_hz;
        for c in &touching {
            force -= c.force;
            moment -= (c.point - after.com).cross(&c.force);
        }
        force_squares += force.norm_squared();
        moment_squares += moment.norm_squared();
        let (kinetic, potential) = state.energy(&model);
        gained += (kinetic + potential - energy).max(0.0);
        energy = kinetic + potential;
        carried += after.linear / (model.mass * rate_hz);
        before = after;
    }
    let rms = |squares: f64| (squares / steps as f64).sqrt() / (model.mass * G);
    Tumble {
        unexplained: rms(force_squares),
        unexplained_moment: rms(moment_squares),
        astray: (before.com - carried).norm(),
        gained,
        links: links.len(),
    }
}

/// The body moves as its momentum says, however it tumbles, the recorded contacts explain how that changes but for what
/// the engine's integration makes of itself at an impact, and no energy comes of it.
#[test]
fn slow_an_impact_is_explained() {
    for (spin, ground) in [
        (Vec3::new(3.0, 0.0, 0.0), Floor::level(0.0, 0.8)),
        (Vec3::new(0.0, 0.5, -3.0), Floor::level(0.0, 0.8)),
        (Vec3::new(-4.0, 1.0, 1.0), Floor::level(-0.2, 0.3).tilted(0.2, 0.7)),
    ] {
        let t = tumble(spin, ground);
        println!("{spin:?}: {t:?}");
        assert!(t.links > 10, "{t:?}"); // 16 to 18 seen
        assert!(t.unexplained < 0.35, "{t:?}"); // 0.26 seen, at any step: integration
        assert!(t.unexplained_moment < 0.1, "{t:?}"); // 0.05 seen: points move during a step
        assert!(t.astray < 0.01, "{t:?}"); // 1.5 to 3.5 mm seen
        assert!(t.gained < 0.3, "{t:?}"); // 0.12 J seen of 500 J
    }
}
