//! Style put into a motion: reconstruction and all that is mended afterwards, 2 × 1,000 frames of 93 channels: at most 50 ms.
//!
//! Two gaits of a body of 26 bones, whose 31 points (bones and ends) are the 93 channels, in 5 components; each takes the style of the
//! other. `cargo bench -p edits --bench style` times `transfer`, both ways: alignment, reconstruction, low-pass, bone lengths, feet by IK;
//! and the decomposition with its eight starts.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use edits::Motion;
use edits::style::{Example, StyleOptions, StyleSet, Transfer, transfer};
use learn::ica::{Count, IcaOptions};
use motion::rotation::exp;
use motion::{Clip, Contact, ContactPlan, Joint, Limb, LimbKind, Link, Skeleton, Vec3};

const RATE_HZ: f64 = 120.0;
const FRAMES: usize = 1000;

fn body() -> Arc<Skeleton> {
    let mut links = vec![Link::new("hips", None, Vec3::zeros(), Joint::Free)];
    let mut hang = |name: String, parent: usize, at: Vec3, end: Option<Vec3>| {
        let mut link = Link::new(name, Some(parent), at, Joint::Spherical);
        link.end = end;
        links.push(link);
        links.len() - 1
    };
    let mut spine = vec![0];
    for i in 0..3 {
        spine.push(hang(format!("spine_{i}"), spine[i], Vec3::y() * 0.12, None));
    }
    let neck = hang("neck".into(), spine[3], Vec3::y() * 0.15, None);
    hang("head".into(), neck, Vec3::y() * 0.1, Some(Vec3::y() * 0.18));
    let mut limbs = Vec::new();
    for (side, x) in [("l", 1.0), ("r", -1.0)] {
        let part = |name: &str| format!("{name}_{side}");
        let clavicle = hang(part("clavicle"), spine[3], Vec3::new(0.03 * x, 0.1, 0.0), None);
        let arm = hang(part("arm"), clavicle, Vec3::new(0.15 * x, 0.0, 0.0), None);
        let forearm = hang(part("forearm"), arm, Vec3::y() * -0.28, None);
        let hand = hang(part("hand"), forearm, Vec3::y() * -0.24, None);
        hang(part("fingers"), hand, Vec3::y() * -0.08, Some(Vec3::y() * -0.07));
        let hip = hang(part("hip"), 0, Vec3::new(0.02 * x, -0.02, 0.0), None);
        let thigh = hang(part("thigh"), hip, Vec3::new(0.07 * x, -0.05, 0.0), None);
        let shin = hang(part("shin"), thigh, Vec3::y() * -0.43, None);
        let foot = hang(part("foot"), shin, Vec3::y() * -0.42, None);
        hang(part("toes"), foot, Vec3::new(0.0, -0.06, 0.13), Some(Vec3::z() * 0.07));
        let leg = Limb { name: part("leg"), kind: LimbKind::Leg, upper: thigh, lower: shin, end: foot };
        limbs.push(leg);
    }
    Arc::new(Skeleton::new(links).and_then(|s| s.with_limbs(limbs)).expect("a skeleton"))
}

/// A gait of strides of `stride_s`, leaning and crouching by so many radians.
fn gait(s: &Arc<Skeleton>, stride_s: f64, lean: f64, crouch: f64) -> Motion {
    let link = |name: &str| s.link(name).expect("a link of the body");
    let mut q = Vec::new();
    for f in 0..FRAMES {
        let phase = TAU * f as f64 / RATE_HZ / stride_s;
        let mut pose = s.zero_pose();
        s.set_position(&mut pose, 0, &Vec3::new(0.02 * phase.sin(), 0.95 - 0.4 * crouch, 0.008 * f as f64));
        s.set_rotation(&mut pose, link("spine_0"), &exp(&Vec3::new(lean, 0.05 * phase.sin(), 0.0)));
        s.set_rotation(&mut pose, link("neck"), &exp(&Vec3::new(-0.5 * lean, 0.0, 0.03 * phase.cos())));
        for (side, p) in [("l", phase), ("r", phase + 0.5 * TAU)] {
            let mut turn =
                |name: &str, by: Vec3| s.set_rotation(&mut pose, link(&format!("{name}_{side}")), &exp(&by));
            let pitch = -0.4 * p.sin() - crouch;
            let bend = 0.15 + 2.0 * crouch + 0.5 * (p + 0.6).cos().max(0.0);
            turn("thigh", Vec3::x() * pitch);
            turn("shin", Vec3::x() * bend);
            turn("foot", Vec3::x() * (-pitch - bend));
            turn("arm", Vec3::new(0.4 * p.sin(), 0.0, 0.1 + 0.1 * (2.0 * p).cos()));
            turn("forearm", Vec3::x() * (-0.3 - lean - 0.2 * p.sin()));
        }
        q.extend(pose);
    }
    let mut contacts = Vec::new();
    for (limb, part) in s.limbs().iter().zip([0.25, 0.75]) {
        let mut from_s = part * stride_s;
        while from_s + 0.6 * stride_s < FRAMES as f64 / RATE_HZ {
            let point = limb.name.clone();
            contacts.push(Contact { point, from_s, to_s: from_s + 0.6 * stride_s, world_from_point: None });
            from_s += stride_s;
        }
    }
    let contacts = ContactPlan::new(contacts).expect("a plan");
    Motion { contacts, floor_m: Some(0.0), ..Motion::of(Clip::new(s.clone(), RATE_HZ, q)) }
}

fn bench(c: &mut Criterion) {
    let s = body();
    let both = [gait(&s, 1.1, 0.05, 0.02), gait(&s, 1.7, 0.5, 0.35)];
    let none = BTreeMap::new();
    let example = |name, motion: &Motion| Example {
        name,
        clip: Box::leak(Box::new(motion.clip.clone())),
        floor_m: 0.0,
        names: Box::leak(Box::new(BTreeMap::new())),
    };
    let examples = [example("walk", &both[0]), example("sneak", &both[1])];
    let ica = IcaOptions { count: Count::Number(5), ..IcaOptions::default() };
    let options = StyleOptions { ica, ..StyleOptions::default() };
    let set = StyleSet::of(examples[0], examples[1], &options).expect("components");
    assert_eq!((set.mean.len(), set.frames), (93, [FRAMES; 2]));
    let all: Vec<usize> = (0..set.components()).collect();
    let mut group = c.benchmark_group("style");
    group.sample_size(20).throughput(Throughput::Elements(2 * FRAMES as u64));
    group.bench_function("transfer, 2 × 1000 frames × 93 channels", |b| {
        b.iter(|| {
            for (base, donor) in [(0, 1), (1, 0)] {
                let how = Transfer::of(&set, donor, 1.0).only(&all, 1.0);
                let motion = black_box(&both[base]);
                let span = (0.0, motion.clip.duration_s());
                black_box(transfer(&set, motion, &how, span, &none).expect("a motion with style"));
            }
        });
    });
    group.bench_function("decomposition into 5, eight starts", |b| {
        b.iter(|| StyleSet::of(black_box(examples[0]), examples[1], &options).expect("components"));
    });
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
