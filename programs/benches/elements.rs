//! A program that edits the elements of a script: 10,000 of them in at most 50 ms.
//!
//! `cargo bench -p programs --bench elements` prints the time of a whole edit: the program read, every element handed to it, three of its
//! fields read and two written, the log kept. Beside it the built-in succession and the same written as a program.

use std::collections::BTreeMap;
use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use edits::{EditLog, Selector, Succession, TrackEdit};
use motion::script::{Action, Cycle, Pose, PoseValue, Script};
use motion::{Joint, Link, Skeleton, Tracks, Vec3};
use programs::Program;

const LINKS: usize = 20;
const POSES: usize = 500;

/// A chain of hinges that moves all of them in every pose.
fn tracks() -> Tracks {
    let link =
        |i: usize| Link::new(format!("j{i}"), i.checked_sub(1), Vec3::y() * 0.1, Joint::Revolute(Vec3::x()));
    let chain = Arc::new(Skeleton::new((0..LINKS).map(link).collect()).unwrap());
    let value = |p: usize, i: usize| PoseValue::scalar(format!("j{i}"), 0.01 * ((p * 7 + i) % 50) as f64);
    let pose = |p: usize| Pose { values: (0..LINKS).map(|i| value(p, i)).collect(), ..Pose::default() };
    let cycle = Cycle { poses: (0..POSES).map(pose).collect(), ..Cycle::default() };
    let action = Action { name: "wave".into(), cycles: vec![cycle], ..Action::default() };
    Script { actions: vec![action], ..Script::default() }.build(&chain, &chain.zero_pose()).unwrap()
}

fn read(text: &str) -> Program {
    Program::read(Path::new("bench.rhai"), text, &BTreeMap::new()).unwrap()
}

const SHAKE: &str = "
fn params() { #{ amount_deg: 2.0, seed: 1 } }
fn elements(script, params) {
    for e in script {
        let by = params.amount_deg * noise(params.seed, 3.0 * e.start_s);
        e.end_deg += by * e.duration_s;
        e.start_s += 0.01 * sin(e.start_s);
    }
}";

fn edits(c: &mut Criterion) {
    let tracks = tracks();
    let n = tracks.elements().count();
    assert_eq!(n, 10_000);
    let selection = Selector::default().select(&tracks).unwrap();
    let mut group = c.benchmark_group("10,000 elements");
    group.throughput(Throughput::Elements(n as u64)).sample_size(20);
    let mut run = |name: &str, edit: &dyn Fn() -> Box<dyn TrackEdit>| {
        group.bench_function(name, |b| {
            b.iter(|| {
                let mut tracks = tracks.clone();
                edit().apply(&mut tracks, &selection, &mut EditLog::default()).unwrap();
                black_box(tracks.duration_s)
            })
        });
    };
    run("program", &|| Box::new(read(SHAKE)));
    run("succession as a program", &|| Box::new(read(include_str!("../../scenes/programs/succession.rhai"))));
    run("succession", &|| Box::new(Succession::forward(0.1)));
    group.finish();
}

criterion_group!(benches, edits);
criterion_main!(benches);
