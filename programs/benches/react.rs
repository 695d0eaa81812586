//! A reactive program at 240 Hz: at most 20 % of the pass that it is in.
//!
//! `cargo bench -p programs --bench react` prints the least time of many short blocks of steps of a standing human in rapier, without and
//! with each program that ships, taken in turn in one process. Time is that of the processor for this thread where the system tells it
//! (Linux), so that other work on the machine does not count. Criterion's own numbers are of one step with the program.

use std::collections::BTreeMap;
use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use bodies::anthropometry::human::human;
use controllers::{BalanceSettings, GainBlend, Goal, Reactive, Setup};
use criterion::{Criterion, criterion_group};
use dynamics::RootMode;
use motion::{Clip, Floor, Plant, Script, Vec3};
use programs::{Program, Reaction};
use sim::{EngineEntry, Pass, Run};

const RATE_HZ: f64 = 240.0;
/// Steps per block: some 10 ms.
const BLOCK: usize = 24;
const BLOCKS: usize = 100;

const SHIPPED: [(&str, &str); 2] = [
    ("tremor", include_str!("../../scenes/programs/tremor.rhai")),
    ("flinch", include_str!("../../scenes/programs/flinch.rhai")),
];

fn reaction(text: &str) -> Reaction {
    // flinching all the time
    let text = text.replace("since_s: -1.0", "since_s: 0.0").replace("hold_s: 0.5", "hold_s: 1e6");
    Reaction::new(Program::read(Path::new("bench.rhai"), &text, &BTreeMap::new()).unwrap()).unwrap()
}

fn standing(reactive: Vec<Box<dyn Reactive>>) -> Run {
    let c = Arc::new(human().0);
    let s = &c.skeleton;
    let clip = Clip::new(s.clone(), RATE_HZ, c.rest.repeat(2 * BLOCK * (BLOCKS + 2)));
    let pass = Pass {
        setup: Setup {
            character: c.clone(),
            gravity: Vec3::new(0.0, -9.81, 0.0),
            goal: Goal::new(&clip, RATE_HZ),
            tracks: Some(Script::default().build(s, &c.rest).unwrap()),
            dense: Default::default(),
            tension: 1.0,
            plants: c.legs().map(|l| Plant::here(s, &c.rest, l)).collect(),
            ground_m: None,
            contacts: motion::ContactPlan::default(),
            balance: BalanceSettings::default(),
            blend: GainBlend::RestAngle,
        },
        reactive,
        substeps: None,
        root: RootMode::Free,
        ground: Some(Floor::level(0.0, 0.8)),
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

/// Time that the processor has spent on this thread, s; `None` where the system does not tell.
fn on_processor_s() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split(' ').next()?.parse::<f64>().ok().map(|ns| ns * 1e-9)
}

/// Prints the price of each program.
fn shares() {
    let mut runs = vec![("without", standing(Vec::new()))];
    for (name, text) in SHIPPED {
        runs.push((name, standing(vec![Box::new(reaction(text))])));
    }
    let mut best = vec![f64::INFINITY; runs.len()];
    for block in 0..BLOCKS + 2 {
        for ((_, run), best) in runs.iter_mut().zip(&mut best) {
            let (start, began) = (Instant::now(), on_processor_s());
            for _ in 0..BLOCK {
                assert!(run.step().unwrap());
            }
            if block >= 2 {
                let took = match (began, on_processor_s()) {
                    (Some(began), Some(now)) => now - began,
                    _ => start.elapsed().as_secs_f64(),
                };
                *best = best.min(took / BLOCK as f64);
            }
        }
    }
    println!("standing human, {RATE_HZ} Hz, rapier; least of {BLOCKS} blocks of {BLOCK} steps");
    for ((name, _), t) in runs.iter().zip(&best) {
        let share = 100.0 * (t - best[0]) / best[0];
        println!("{name:8} {:6.1} µs a step, {share:+5.1} %", t * 1e6);
    }
}

fn calls(c: &mut Criterion) {
    for (name, text) in SHIPPED {
        let mut run = standing(vec![Box::new(reaction(text))]);
        for _ in 0..10 {
            run.step().unwrap();
        }
        c.bench_function(&format!("step with {name}"), |b| b.iter(|| black_box(run.step().unwrap())));
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10).measurement_time(std::time::Duration::from_secs(1));
    targets = calls
}

fn main() {
    shares();
    benches();
    Criterion::default().configure_from_args().final_summary();
}
