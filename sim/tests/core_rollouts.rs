//! Laws of snapshots and rollouts of the core: what was saved comes back to the bit, on any number of threads, without allocation.

mod solids;

use std::sync::Arc;

use bodies::anthropometry::human::human;
use bodies::{Body, Carried, Character};
use controllers::{Drive, Rest, rest_of};
use dynamics::Wrench;
use motion::{Floor, Joint, Link, Quat, Shape, Vec3};
use sim::core::{Snapshot, rollouts};
use sim::{ContactForce, ContactLaw, Core, Engine, EngineSettings};
use solids::character;

fn settings(substeps: usize) -> EngineSettings {
    EngineSettings {
        rate_hz: 240.0,
        substeps,
        gravity: Vec3::new(0.0, -9.81, 0.0),
        ground: Some(Floor::level(0.0, 0.8).turning()),
        pinned: false,
        contact: ContactLaw::Stiff,
        props: Default::default(),
        self_collision: false,
    }
}

fn standing() -> (Arc<Character>, Core, Vec<Drive>) {
    let c = Arc::new(human().0);
    let mut core = Core::new(&c, settings(2), &c.rest, &vec![0.0; c.skeleton.nv()]).unwrap();
    core.set_stops(&vec![500.0; core.model.bodies.len()]);
    let drives = (0..core.model.bodies.len())
        .map(|i| Drive { stiffness: 400.0, damping: 40.0, rest: rest_of(&core.model, i, &c.rest) })
        .collect();
    (c, core, drives)
}

/// Drives, a push, tilting ground, and a load that is put down: everything a run may bring.
fn stir(core: &mut Core, drives: &[Drive], step: usize) {
    core.set_drives(drives);
    if step % 7 == 3 {
        let point = Vec3::new(0.1, 1.2, 0.0);
        core.add_wrench(&Wrench { link: 1, point, force: Vec3::new(60.0, 0.0, 20.0), moment: Vec3::zeros() });
    }
    let tilt = 0.0005 * step as f64;
    core.turn_ground(&Vec3::new(tilt.sin(), tilt.cos(), 0.0));
}

fn bits(core: &Core) -> Vec<u64> {
    let mut forces: Vec<ContactForce> = Vec::new();
    core.contacts(&mut forces);
    let forces =
        forces.iter().flat_map(|c| c.force.iter().chain(c.point.iter()).copied().collect::<Vec<_>>());
    core.q().iter().chain(core.v()).copied().chain(forces).map(f64::to_bits).collect()
}

/// A run goes on from a snapshot as it went on before, in a core whose memory is full of what other runs left there.
#[test]
fn a_run_goes_on_from_a_snapshot_to_the_bit() {
    let (c, mut core, drives) = standing();
    let loaded = c.carrying([&Carried::solid_box(5, 8.0, Vec3::zeros(), Vec3::repeat(0.2))]);
    core.set_masses(&loaded).unwrap();
    for step in 0..40 {
        stir(&mut core, &drives, step);
        core.step().unwrap();
    }
    // with a wrench and a turn of the ground that wait
    stir(&mut core, &drives, 3);
    let saved = core.snapshot();
    let go_on = |core: &mut Core| {
        core.step().unwrap();
        (0..40)
            .map(|step| (stir(core, &drives, step), core.step().unwrap(), bits(core)).2)
            .collect::<Vec<_>>()
    };
    let first = go_on(&mut core);
    core.set_masses(&c).unwrap();
    core.set_stops(&vec![0.0; core.model.bodies.len()]);
    core.restore(&saved);
    assert!(go_on(&mut core) == first);
    // a clone, and another core that fell over in between
    let mut other = core.clone();
    for _ in 0..200 {
        // stops without damping would make energy of being set once a step
        other.set_drives(&vec![Drive { stiffness: 0.0, damping: 2.0, rest: Rest::None }; drives.len()]);
        other.step().unwrap();
    }
    other.restore(&saved);
    assert!(go_on(&mut other) == first);
    let mut copy = other.snapshot();
    core.restore(&saved);
    core.save(&mut copy);
    other.restore(&copy);
    assert!(go_on(&mut other) == first);
}

/// Rollouts are the runs they stand for, on one thread and on many.
#[test]
fn rollouts_are_the_same_on_any_number_of_threads() {
    let (_, mut core, drives) = standing();
    let mut states: Vec<Snapshot> = Vec::new();
    for step in 0..24 {
        stir(&mut core, &drives, step);
        core.step().unwrap();
        states.push(core.snapshot());
    }
    let batch = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            rollouts(
                &core,
                &states,
                20,
                |run, step, core| stir(core, &drives, run + step),
                |run, core, ended| {
                    assert!(ended.is_none());
                    (run, bits(core))
                },
            )
        })
    };
    let (one, four) = (batch(1), batch(4));
    assert!(one == four);
    let mut alone = core.clone();
    for (run, state) in states.iter().enumerate() {
        alone.restore(state);
        for step in 0..20 {
            stir(&mut alone, &drives, run + step);
            alone.step().unwrap();
        }
        assert!(one[run] == (run, bits(&alone)), "run {run}");
    }
    // a thousand states of a human take less than 20 MB
    let bytes = 1000 * states[0].bytes();
    println!("{:.1} MB for a thousand states", bytes as f64 / 1e6);
    assert!(bytes < 20_000_000, "{bytes}");
}

/// A divergence is an error that names step and body, and rollouts hand it on.
#[test]
fn a_divergence_is_told_by_step_and_body() {
    let (_, mut core, drives) = standing();
    let state = core.snapshot();
    let wild = |core: &mut Core| {
        core.set_drives(&drives);
        core.add_wrench(&Wrench {
            link: 3,
            point: Vec3::zeros(),
            force: Vec3::repeat(1e9),
            moment: Vec3::repeat(1e9),
        });
    };
    wild(&mut core);
    let error = core.step().unwrap_err().to_string();
    println!("{error}");
    assert!(error.starts_with("the simulation diverged at step 1 (0.004 s), first seen at `"), "{error}");
    let ends =
        rollouts(&core, &[state], 5, |_, _, core| wild(core), |_, _, ended| ended.map(|e| e.to_string()));
    assert_eq!(ends, [Some(error)]);
}

/// A body that is its own mirror image and falls flat stays its own mirror image.
#[test]
fn a_symmetric_fall_stays_symmetric() {
    let half = Vec3::new(0.2, 0.05, 0.1);
    let arm = |side: f64, link: &str| {
        let (at, end) = (Vec3::new(0.2 * side, 0.0, 0.0), Vec3::new(0.3 * side, 0.0, 0.0));
        let body = Body {
            mass: 1.0,
            com: end * 0.5,
            inertia: nalgebra::Matrix3::from_diagonal(&Vec3::new(0.002, 0.02, 0.02)),
            shapes: vec![Shape::Capsule { a: Vec3::zeros(), b: end, radius: 0.03 }],
        };
        (Link::new(link, Some(0), at, Joint::Spherical), body)
    };
    let trunk = Carried::solid_box(0, 10.0, Vec3::zeros(), half * 2.0);
    let shapes = vec![Shape::Box { center: Vec3::zeros(), half, rotation: Quat::identity() }];
    let (left, left_body) = arm(1.0, "left");
    let (right, right_body) = arm(-1.0, "right");
    let c = character(
        vec![Link::new("trunk", None, Vec3::zeros(), Joint::Free), left, right],
        vec![Body { mass: trunk.mass, com: trunk.at, inertia: trunk.inertia, shapes }, left_body, right_body],
    );
    let mut q = c.skeleton.zero_pose();
    q[1] = 0.5;
    let mut v = vec![0.0; c.skeleton.nv()];
    v[2] = 0.7;
    let mut core = Core::new(&c, settings(2), &q, &v).unwrap();
    let drives: Vec<Drive> =
        (0..3).map(|i| Drive { stiffness: 20.0, damping: 1.0, rest: rest_of(&core.model, i, &q) }).collect();
    let (mut worst, mut swung) = (0.0_f64, 0.0_f64);
    for _ in 0..480 {
        core.set_drives(&drives);
        core.step().unwrap();
        let q = core.q();
        // mirrored in x: rotations keep x, turn over y and z
        let pairs = [(q[0], 0.0), (q[5], 0.0), (q[6], 0.0), (q[8], q[12]), (q[9], -q[13]), (q[10], -q[14])];
        worst = pairs.iter().fold(worst, |m, (a, b)| m.max((a - b).abs()));
        swung = swung.max(q[10].abs());
    }
    println!("{worst:.1e} from its mirror image; arms swung by {swung:.3}");
    assert!(swung > 0.02, "{swung}");
    assert!(worst < 1e-9, "{worst}");
}
