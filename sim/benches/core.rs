//! The price of a step of the core: the standing human against rapier, and bodies of 8 to 120 links.
//!
//! `cargo bench -p sim --bench core` first prints least times of many short blocks, all kinds taken in turn in this one process: the least of
//! many is what the processor takes when nobody interrupts it. A block sets the drives and steps, as a pass does. Criterion's own numbers
//! follow.

use std::hint::black_box;
use std::time::Instant;

use bodies::anthropometry::human::human;
use bodies::{Body, Character, JointClass};
use controllers::{Drive, rest_of};
use criterion::{Criterion, criterion_group};
use motion::{Floor, Joint, Link, Quat, Shape, Skeleton, Vec3};
use nalgebra::Matrix3;
use sim::{Core, Engine, EngineSettings, Rapier};

const RATE_HZ: f64 = 240.0;
/// Steps per block.
const BLOCK: usize = 24;
/// Blocks of each kind.
const BLOCKS: usize = 200;

fn settings(substeps: usize) -> EngineSettings {
    EngineSettings {
        rate_hz: RATE_HZ,
        substeps,
        gravity: Vec3::new(0.0, -9.81, 0.0),
        ground: Some(Floor::level(0.0, 0.8)),
        pinned: false,
        contact: Default::default(),
        props: Default::default(),
        self_collision: false,
    }
}

/// Drives that hold the rest pose, stiff enough to stand.
fn hold(engine: &dyn Engine, rest: &[f64], stiffness: f64, damping: f64) -> Vec<Drive> {
    let model = engine.model();
    let drive = |i: usize| Drive { stiffness, damping, rest: rest_of(model, i, rest) };
    (0..model.bodies.len()).map(drive).collect()
}

/// A bush: a root of two feet, and from it branches of balls and hinges, five links long.
fn bush(links: usize) -> Character {
    let mut all = vec![Link::new("root", None, Vec3::zeros(), Joint::Free)];
    let half = Vec3::new(0.06, 0.02, 0.12);
    let foot = |x: f64| Shape::Box { center: Vec3::new(x, 0.02, 0.0), half, rotation: Quat::identity() };
    let body = |mass: f64, shapes: Vec<Shape>| Body {
        mass,
        com: Vec3::new(0.0, 0.1, 0.0),
        inertia: Matrix3::from_diagonal(&Vec3::new(0.01, 0.01, 0.008)) * mass,
        shapes,
    };
    let mut bodies = vec![body(40.0, vec![foot(-0.15), foot(0.15)])];
    for i in 1..links {
        let (branch, at) = ((i - 1) / 5, (i - 1) % 5);
        let parent = if at == 0 { 0 } else { i - 1 };
        let angle = branch as f64 * 0.7;
        let offset =
            if at == 0 { Vec3::new(0.1 * angle.sin(), 0.3, 0.1 * angle.cos()) } else { Vec3::y() * 0.12 };
        let joint = if at % 2 == 0 { Joint::Spherical } else { Joint::Revolute(Vec3::x()) };
        all.push(Link::new(format!("link{i}"), Some(parent), offset, joint));
        bodies.push(body(1.0, vec![Shape::Sphere { center: Vec3::zeros(), radius: 0.04 }]));
    }
    let skeleton = std::sync::Arc::new(Skeleton::new(all).unwrap());
    Character {
        name: "bush".into(),
        classes: vec![JointClass::Other; links],
        rest: skeleton.zero_pose(),
        skeleton,
        bodies,
        contacts: vec![],
    }
    .check()
    .unwrap()
}

fn core(c: &Character, substeps: usize) -> Core {
    Core::new(c, settings(substeps), &c.rest, &vec![0.0; c.skeleton.nv()]).unwrap()
}

fn rapier(c: &Character, substeps: usize) -> Rapier {
    Rapier::new(c, settings(substeps), &c.rest, &vec![0.0; c.skeleton.nv()]).unwrap()
}

/// Least time per step of blocks of each engine, taken in turn, s.
fn least(engines: &mut [(Box<dyn Engine>, Vec<Drive>)], blocks: usize) -> Vec<f64> {
    let mut best = vec![f64::INFINITY; engines.len()];
    for block in 0..blocks + 2 {
        for ((engine, drives), best) in engines.iter_mut().zip(&mut best) {
            let start = Instant::now();
            for _ in 0..BLOCK {
                engine.set_drives(black_box(drives));
                engine.step().unwrap();
            }
            if block >= 2 {
                *best = best.min(start.elapsed().as_secs_f64() / BLOCK as f64);
            }
        }
    }
    best
}

fn standing() {
    let c = human().0;
    let mut engines: Vec<(Box<dyn Engine>, Vec<Drive>)> = Vec::new();
    for substeps in [1, 2, 4] {
        for engine in [Box::new(core(&c, substeps)) as Box<dyn Engine>, Box::new(rapier(&c, substeps))] {
            let drives = hold(engine.as_ref(), &c.rest, 5000.0, 200.0);
            engines.push((engine, drives));
        }
    }
    let times = least(&mut engines, BLOCKS);
    println!(
        "standing human, {} degrees of freedom, {RATE_HZ} Hz; least of {BLOCKS} blocks",
        c.skeleton.nv()
    );
    for (i, substeps) in [1, 2, 4].into_iter().enumerate() {
        let (ours, theirs) = (times[2 * i] * 1e6, times[2 * i + 1] * 1e6);
        println!(
            "{substeps} substeps: core {ours:6.2} µs, rapier {theirs:7.1} µs, ratio {:.4}",
            ours / theirs
        );
    }
    for (engine, _) in &engines {
        assert!(engine.q()[1] > 0.8, "{} has fallen", engine.name());
    }
    let mut contacts = Vec::new();
    engines[0].0.contacts(&mut contacts);
    let l = engines[0].0.ledger().unwrap();
    println!(
        "{} contact points; {:.2} sweeps, {:.2} Newton steps a substep; worst residual {:.1e} m g dt, {} of {} above 1e-6",
        contacts.len(),
        l.sweeps as f64 / l.touching as f64,
        l.newton_steps as f64 / l.touching as f64,
        l.worst_residual,
        l.above_tight,
        l.touching
    );
}

fn growth() {
    println!("bushes of branches of five links, one substep");
    for links in [8, 22, 40, 60, 120] {
        let c = bush(links);
        let engine: Box<dyn Engine> = Box::new(core(&c, 1));
        let drives = hold(engine.as_ref(), &c.rest, 200.0, 10.0);
        let mut engines = vec![(engine, drives)];
        let time = least(&mut engines, BLOCKS)[0] * 1e6;
        let n = c.skeleton.nv();
        println!(
            "{links:4} links, {n:4} degrees of freedom: {time:7.2} µs, {:.3} µs per degree of freedom",
            time / n as f64
        );
    }
}

fn steps(criterion: &mut Criterion) {
    let c = human().0;
    for substeps in [1, 2] {
        let mut engine = core(&c, substeps);
        let drives = hold(&engine, &c.rest, 5000.0, 200.0);
        criterion.bench_function(&format!("core, {substeps} substeps"), |b| {
            b.iter(|| {
                engine.set_drives(black_box(&drives));
                engine.step().unwrap();
            });
        });
    }
    let mut engine = core(&c, 1);
    let mut saved = engine.snapshot();
    criterion.bench_function("save and restore", |b| {
        b.iter(|| {
            engine.save(&mut saved);
            engine.restore(black_box(&saved));
        });
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = steps
}

fn main() {
    standing();
    growth();
    // `cargo test --benches` asks for `--test`: the numbers are then all there is to see
    if std::env::args().any(|a| a == "--bench") {
        benches();
        Criterion::default().configure_from_args().final_summary();
    }
}
