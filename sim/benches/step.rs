//! The price of a step: control, simulation and recording against bare rapier, same body, same run.
//!
//! `cargo bench -p sim` first prints the ratio that the project promises (whole ≤ 1.3 × bare, and at
//! least 5 × real time at 240 Hz with one substep), from blocks of both kinds taken in turn in this one
//! process. The least of many short blocks is what the processor takes when nobody interrupts it, so that
//! wall time serves as processor time. Criterion's own numbers follow.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use bodies::Character;
use bodies::anthropometry::human::human;
use controllers::{BalanceSettings, Drive, GainBlend, Goal, Setup, rest_of};
use criterion::{Criterion, criterion_group};
use dynamics::RootMode;
use motion::{Clip, Floor, Plant, Script, Tracks, Vec3};
use sim::{Engine, EngineEntry, EngineSettings, Pass, Rapier, Run};

const RATE_HZ: f64 = 240.0;
/// Steps per block: some 10 ms.
const BLOCK: usize = 24;
/// Blocks of each kind.
const BLOCKS: usize = 100;
const GRAVITY: Vec3 = Vec3::new(0.0, -9.81, 0.0);
const GROUND: Floor = Floor::level(0.0, 0.8);

/// The body standing with fixed drives: nothing but the engine.
fn bare(c: &Character) -> (Rapier, Vec<Drive>) {
    let settings = EngineSettings {
        rate_hz: RATE_HZ,
        substeps: 1,
        gravity: GRAVITY,
        ground: Some(GROUND),
        pinned: false,
        contact: Default::default(),
        props: Default::default(),
        self_collision: false,
    };
    let still = vec![0.0; c.skeleton.nv()];
    let world = Rapier::new(c, settings, &c.rest, &still).unwrap();
    let drives = (0..world.model.bodies.len())
        .map(|i| Drive { stiffness: 5000.0, damping: 200.0, rest: rest_of(&world.model, i, &c.rest) })
        .collect();
    (world, drives)
}

/// The same body standing under the whole control step, recorded; a script balances on transitions, a
/// clip tracks with feed-forward as well.
fn whole(c: &Arc<Character>, scripted: bool) -> Run {
    let s = &c.skeleton;
    let steps = 2 * BLOCK * (BLOCKS + 2);
    let clip = Clip::new(s.clone(), RATE_HZ, c.rest.repeat(steps));
    let script = Script { properties: Default::default(), actions: Vec::new(), inserts: Vec::new() };
    let tracks: Tracks = script.build(s, &c.rest).unwrap();
    let setup = Setup {
        character: c.clone(),
        gravity: GRAVITY,
        goal: Goal::new(&clip, RATE_HZ),
        tracks: scripted.then_some(tracks),
        dense: Default::default(),
        tension: 1.0,
        plants: c.legs().map(|l| Plant::here(s, &c.rest, l)).collect(),
        ground_m: None,
        contacts: motion::ContactPlan::default(),
        balance: BalanceSettings::default(),
        blend: GainBlend::RestAngle,
    };
    let pass = Pass {
        setup,
        reactive: Vec::new(),
        substeps: Some(1),
        root: RootMode::Free,
        ground: Some(GROUND),
        pushes: Vec::new(),
        tilts: Vec::new(),
        props: Vec::new(),
        self_collision: false,
        carried: Vec::new(),
        past_fall: false,
        foresight: None,
        soles: Default::default(),
    };
    pass.start(&EngineEntry::default()).unwrap()
}

/// Least time per step of blocks of each work, taken in turn, s.
fn least(works: &mut [&mut dyn FnMut()]) -> Vec<f64> {
    let mut best = vec![f64::INFINITY; works.len()];
    for block in 0..BLOCKS + 2 {
        for (work, best) in works.iter_mut().zip(&mut best) {
            let start = Instant::now();
            for _ in 0..BLOCK {
                work();
            }
            if block >= 2 {
                *best = best.min(start.elapsed().as_secs_f64() / BLOCK as f64);
            }
        }
    }
    best
}

fn ratio() {
    let c = Arc::new(human().0);
    let (mut world, drives) = bare(&c);
    let (mut script, mut clip) = (whole(&c, true), whole(&c, false));
    let times = least(&mut [
        &mut || {
            world.set_drives(black_box(&drives));
            world.step().unwrap();
        },
        &mut || assert!(script.step().unwrap()),
        &mut || assert!(clip.step().unwrap()),
    ]);
    assert!(world.q()[1] > 0.8, "the bare body has fallen");
    let trace = script.finish().trace;
    assert!(trace.pose(trace.rows() - 1)[1] > 0.8, "the body has fallen");
    let mut touching = Vec::new();
    world.contacts(&mut touching);
    let own = trace.contacts.iter().filter(|c| c.row == trace.rows() - 1).count();
    println!("contact points: {} bare, {own} whole", touching.len());
    println!("{} degrees of freedom, {RATE_HZ} Hz, one substep; least of {BLOCKS} blocks", c.skeleton.nv());
    println!("bare rapier   {:6.1} µs", times[0] * 1e6);
    for (name, t) in [("whole, script", times[1]), ("whole, clip", times[2])] {
        let (ratio, realtime) = (t / times[0], 1.0 / (t * RATE_HZ));
        println!("{name:13} {:6.1} µs = {ratio:.3} × bare, {realtime:.1} × real time", t * 1e6);
    }
}

fn steps(criterion: &mut Criterion) {
    let c = Arc::new(human().0);
    let (mut world, drives) = bare(&c);
    criterion.bench_function("bare", |b| {
        b.iter(|| {
            world.set_drives(black_box(&drives));
            world.step().unwrap();
        });
    });
    let mut run = whole(&c, true);
    criterion.bench_function("whole", |b| {
        b.iter(|| {
            if !run.step().unwrap() {
                run = whole(&c, true);
            }
        });
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = steps
}

fn main() {
    ratio();
    // `cargo test --benches` asks for `--test`: the ratio is then all there is to see
    if std::env::args().any(|a| a == "--bench") {
        benches();
        Criterion::default().configure_from_args().final_summary();
    }
}
