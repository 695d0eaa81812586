//! A drag of a body of 31 balls: at most 200 µs is asked for.
//!
//! `cargo bench -p motion --bench pose`. Each call moves a wrist by 10 mm along a way of 1.6 m and back, both ankles pinned, and starts
//! from the last pose, as dragging with a mouse does; what is timed is one call.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use motion::ik::pose::{Handle, Poser, Rules};
use motion::{Kinematics, Vec3};

#[path = "../tests/human/mod.rs"]
mod human;

fn drags(c: &mut Criterion) {
    let s = human::skeleton();
    let start = human::standing(&s);
    let k = Kinematics::new(&s, &start);
    let link = |name: &str| s.link(name).unwrap();
    let pins = ["ankle_l", "ankle_r"].map(|name| Handle::pin(link(name), k.origin(link(name))));
    let wrist = k.origin(link("wrist_r"));
    for (name, pinned, way) in [
        ("free, within reach", false, Vec3::new(0.1, 0.4, 0.4)),
        ("ankles pinned, within reach", true, Vec3::new(0.1, 0.4, 0.4)),
        ("ankles pinned, out of reach", true, Vec3::new(-0.8, 1.0, 0.9)),
    ] {
        let mut poser = Poser::new(&s);
        poser.begin(&start, Rules::default()).unwrap();
        let (mut q, mut at, mut by) = (start.clone(), 0.0, 0.01 / way.norm());
        c.bench_function(name, |b| {
            b.iter(|| {
                at += by;
                if !(0.0..=1.0).contains(&at) {
                    by = -by;
                }
                let drag = Handle::drag(link("wrist_r"), wrist + way * at);
                let handles = [drag, pins[0], pins[1]];
                poser.drag(&handles[..if pinned { 3 } else { 1 }], black_box(&mut q)).unwrap()
            });
        });
    }
}

criterion_group!(benches, drags);
criterion_main!(benches);
