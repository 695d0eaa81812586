//! A 10-s clip at 120 Hz of the human, analysed without writing: at most 50 ms is asked for.
//!
//! `cargo bench -p dynamics --bench analysis`

use std::hint::black_box;

use bodies::anthropometry::human::human;
use criterion::{Criterion, criterion_group, criterion_main};
use dynamics::{AnalysisOptions, analyze};
use motion::rotation::{Vec3, exp};
use motion::smooth::{Smoothing, smooth};
use motion::{Clip, Joint};

/// The human sways: every ball and hinge on its own slow sines, with a little noise.
fn clip(character: &bodies::Character) -> Clip {
    let s = &character.skeleton;
    let rate = 120.0;
    let mut q = Vec::new();
    for k in 0..1200 {
        let t = f64::from(k) / rate;
        let mut pose = character.rest.clone();
        let wave = |i: usize, a: usize| {
            let p = (7 * i + 3 * a) as f64;
            0.05 * (t * (1.0 + 0.3 * p.sin()) + p).sin() + 1e-4 * (t * 9999.7 + p * 1.3).sin()
        };
        for (i, link) in s.links().iter().enumerate() {
            let turn = exp(&Vec3::new(wave(i, 0), wave(i, 1), wave(i, 2)));
            match link.joint {
                Joint::Free | Joint::Spherical => {
                    let r = turn * s.rotation(&pose, i);
                    s.set_rotation(&mut pose, i, &r);
                }
                Joint::Revolute(_) | Joint::Prismatic(_) => pose[s.q_at(i)] += wave(i, 0),
                Joint::Fixed => {}
            }
        }
        q.extend(pose);
    }
    Clip::new(s.clone(), rate, q)
}

fn analysis(c: &mut Criterion) {
    let (character, _) = human();
    let clip = clip(&character);
    assert_eq!(clip.frames(), 1200);
    let options = AnalysisOptions::default();
    c.bench_function("analyze, 10 s at 120 Hz", |b| {
        b.iter(|| analyze(&character, black_box(&clip), &options).unwrap());
    });
    c.bench_function("smooth, cut-off given", |b| {
        b.iter(|| smooth(black_box(&clip), Smoothing::CutoffHz(6.0)));
    });
    c.bench_function("smooth, cut-off chosen", |b| b.iter(|| smooth(black_box(&clip), Smoothing::Auto)));
}

criterion_group!(benches, analysis);
criterion_main!(benches);
