//! Speed of the stages on a walk, one core: mapping and live by the frame, refinement by the length of the clip, the
//! whole pipeline on 7 minutes at 30 Hz.
//!
//! The performer and its puppet are the 31 joints and 62 degrees of freedom of a CMU skeleton: heavier than any of
//! the project's characters.

#[path = "../tests/laws/bodies.rs"]
#[allow(dead_code)]
mod bodies;

use std::hint::black_box;
use std::time::Duration;

use bodies::{key_poses, mocap, puppet, same_angles, scaled};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use motion::{Clip, Smoothing};
use retarget::contacts::{adjust, phases};
use retarget::mapping::map_clip;
use retarget::refine::refine;
use retarget::{Live, Mapping, Options, SizeRatio, run_with};

/// A clip there and back until it is as long as asked.
fn repeated(clip: &Clip, seconds: f64) -> Clip {
    let (n, frames) = (clip.frames(), (seconds * clip.rate_hz) as usize);
    let at = |i: usize| {
        let k = i % (2 * n - 2);
        if k < n { k } else { 2 * n - 2 - k }
    };
    let q = (0..frames).flat_map(|i| clip.pose(at(i)).to_vec()).collect();
    Clip::new(clip.skeleton.clone(), clip.rate_hz, q)
}

fn stages(c: &mut Criterion) {
    let (performer, human) = mocap("16_21");
    let puppet = puppet(scaled(&performer.character, 0.5, 1.0));
    let keys = key_poses(&performer, &human, &puppet, 0.5, 3);
    let mut options = Options { smoothing: Smoothing::Off, ground_m: Some(0.0), ..Options::default() };
    options.global.size = SizeRatio::Fixed(0.5);
    let mapping = Mapping::learn(&puppet, &keys, options.model, &options.gplvm).unwrap();

    let mut group = c.benchmark_group("frames");
    group.throughput(Throughput::Elements(human.frames() as u64));
    group.bench_function("mapping", |b| {
        b.iter(|| map_clip(&mapping, &performer, black_box(&human), &puppet).unwrap())
    });
    group.bench_function("live", |b| {
        b.iter(|| {
            let mut live = Live::new(&mapping, &performer, &puppet, human.rate_hz, &options).unwrap();
            for i in 0..human.frames() {
                black_box(live.step(human.pose(i)).unwrap());
            }
        })
    });
    group.finish();

    let mut group = c.benchmark_group("refinement");
    group.sample_size(10).warm_up_time(Duration::from_millis(1)).measurement_time(Duration::from_millis(1));
    for seconds in [10.0, 100.0, 1000.0] {
        let long = repeated(&human, seconds);
        let own = same_angles(&long, &puppet.character, 0.5);
        let found = phases::find(&performer, &long, &puppet, &options.contact).unwrap();
        let (held, _) = adjust(&puppet, &own, &found).unwrap();
        let variance = vec![4e-4; long.frames()];
        let mut refinement = options.refine.clone();
        refinement.collisions = false;
        // as many steps for every length
        refinement.iterations = 5;
        group.throughput(Throughput::Elements(long.frames() as u64));
        group.bench_function(BenchmarkId::from_parameter(seconds), |b| {
            b.iter(|| refine(&puppet, &held, &found, &variance, &options.world, &refinement).unwrap())
        });
    }
    group.finish();

    let mut group = c.benchmark_group("pipeline");
    group.sample_size(10).warm_up_time(Duration::from_millis(1)).measurement_time(Duration::from_millis(1));
    let long = repeated(&human, 420.0);
    group.bench_function("7 min at 30 Hz", |b| {
        b.iter(|| run_with(&mapping, &long, &performer, &puppet, &options).unwrap())
    });
    group.finish();
}

criterion_group!(benches, stages);
criterion_main!(benches);
