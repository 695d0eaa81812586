//! The price of a step of the core: the standing human against rapier, and bodies of 8 to 120 links.
//!
//! `cargo bench -p sim --bench core` first prints least times of many short blocks, all kinds taken in turn in this one process: the least of
//! many is what the processor takes when nobody interrupts it. A block sets the drives and steps, as a pass does. Criterion's own numbers
//! follow.

use std::hint::black_box;
use std::time::Instant;

use bodies::Character;
use bodies::anthropometry::human::human;
use controllers::{Drive, rest_of};
use criterion::{Criterion, criterion_group};
use motion::Floor;
use sim::{Core, Engine, EngineSettings, Rapier};

mod bush;

use bush::bush;

const RATE_HZ: f64 = 240.0;
/// Steps per block.
const BLOCK: usize = 24;
/// Blocks of each kind.
const BLOCKS: usize = 200;

fn settings(substeps: usize) -> EngineSettings {
    EngineSettings::free(RATE_HZ, substeps, Some(Floor::level(0.0, 0.8)))
}

/// Drives that hold the rest pose, stiff enough to stand.
fn hold(engine: &dyn Engine, rest: &[f64], stiffness: f64, damping: f64) -> Vec<Drive> {
    let model = engine.model();
    let drive = |i: usize| Drive { stiffness, damping, rest: rest_of(model, i, rest) };
    (0..model.bodies.len()).map(drive).collect()
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
