//! Contacts kept inside the blend of an edit by example: at most 15 µs per frame and degree of freedom.
//!
//! Legs of four ball joints each, as motion capture has them: 31 numbers a frame. `cargo bench -p edits --bench contacts` prints the time
//! of a whole clip, and elements per second: one element is one number of one frame, so 15 µs are 66.7 thousand elements per second. The
//! two lengths show that time is proportional to frames.

use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use edits::Motion;
use edits::by_example::contacts::{Blended, keep};
use edits::by_example::outputs::{self, Allowed};
use edits::by_example::solve::Form;
use edits::by_example::{ExampleOptions, Rig};
use motion::rotation::exp;
use motion::{Clip, Contact, ContactPlan, Joint, Limb, LimbKind, Link, Skeleton, Vec3};
use nalgebra::DMatrix;

const RATE_HZ: f64 = 120.0;

fn body() -> Arc<Skeleton> {
    let mut links = vec![Link::new("hips", None, Vec3::zeros(), Joint::Free)];
    let mut limbs = Vec::new();
    for (side, x) in [("l", 0.09), ("r", -0.09)] {
        let first = links.len();
        for (i, (name, at)) in [
            ("hip_joint", Vec3::zeros()),
            ("up_leg", Vec3::new(x, -0.1, 0.0)),
            ("leg", Vec3::y() * -0.43),
            ("foot", Vec3::y() * -0.42),
        ]
        .into_iter()
        .enumerate()
        {
            let parent = if i == 0 { 0 } else { links.len() - 1 };
            links.push(Link::new(format!("{name}_{side}"), Some(parent), at, Joint::Spherical));
        }
        let (name, kind) = (format!("leg_{side}"), LimbKind::Leg);
        limbs.push(Limb { name, kind, upper: first + 1, lower: first + 2, end: first + 3 });
    }
    Arc::new(Skeleton::new(links).and_then(|s| s.with_limbs(limbs)).expect("a skeleton"))
}

/// Walking in place, a foot standing at any time.
fn motion(frames: usize) -> Motion {
    let s = body();
    let mut q = Vec::new();
    for f in 0..frames {
        let phase = std::f64::consts::TAU * f as f64 / RATE_HZ;
        let mut pose = s.zero_pose();
        s.set_position(&mut pose, 0, &Vec3::new(0.02 * phase.sin(), 0.93, 0.0));
        for (limb, side) in s.limbs().iter().zip([1.0, -1.0]) {
            let bend = 0.3 + 0.2 * side * phase.sin();
            for (link, turn) in [(limb.upper, -bend), (limb.lower, 2.0 * bend), (limb.end, -bend)] {
                s.set_rotation(&mut pose, link, &exp(&(Vec3::x() * turn)));
            }
        }
        q.extend(pose);
    }
    let mut contacts = Vec::new();
    for (limb, start) in s.limbs().iter().zip([0.0, 0.5]) {
        let mut from_s = start;
        while from_s + 0.6 < frames as f64 / RATE_HZ {
            let point = limb.name.clone();
            contacts.push(Contact { point, from_s, to_s: from_s + 0.6, world_from_point: None });
            from_s += 1.0;
        }
    }
    let contacts = ContactPlan::new(contacts).expect("a plan");
    Motion { contacts, ..Motion::of(Clip::new(s, RATE_HZ, q)) }
}

fn bench(c: &mut Criterion) {
    let mut group = c.benchmark_group("contacts");
    group.sample_size(10);
    let firm = ExampleOptions::default().root_weight;
    // everything, the root out of reach of its legs, in the weights of the blend; and lower by a sixth of a leg, with the default
    for (what, frames, root, height) in [
        ("raised", 600, 1.0, None),
        ("raised", 3600, 1.0, None),
        ("lowered", 600, firm, Some(-0.08)),
        ("lowered", 3600, firm, Some(-0.08)),
        ("raised, firm", 600, firm, None),
    ] {
        let motion = motion(frames);
        let clip = &motion.clip;
        let rig = Rig::of(&clip.skeleton).expect("a rig");
        let allowed = Allowed {
            joints: vec![true; rig.joints().len()],
            tilt: true,
            height: true,
            steps: true,
            time: false,
        };
        let width = outputs::width(&rig);
        let differences = DMatrix::from_fn(frames, width, |f, c| {
            let other = 0.1 + 0.05 * (0.03 * f as f64 + c as f64).sin();
            // the root's numbers are the last eight, its height the fourth of them
            height.filter(|_| c + 5 == width).unwrap_or(other)
        });
        let free = outputs::add(&rig, clip, &differences, &allowed, &clip.skeleton, rig.size_m);
        let blended = Blended { rig: &rig, clip: &free, differences: &differences, allowed: &allowed };
        let form = Form {
            configuration: vec![1e3; frames],
            acceleration: vec![0.1; frames],
            step_s: 1.0 / RATE_HZ,
            root,
        };
        let span = (0.0, clip.duration_s());
        let (kept_clip, kept) = keep(&motion, &blended, &form, span);
        let miss_m = kept.misses(&kept_clip).iter().map(|m| m.most_m).fold(0.0, f64::max);
        println!(
            "{what}: {frames} frames of {} numbers, {} steps, settled: {}, miss {:.3} mm",
            kept.width,
            kept.steps,
            kept.settled,
            1e3 * miss_m
        );
        group.throughput(Throughput::Elements((frames * kept.width) as u64));
        group.bench_function(format!("{what}, {frames} frames"), |b| {
            b.iter(|| keep(black_box(&motion), &blended, &form, span));
        });
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
