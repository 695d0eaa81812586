//! BVH: bytes to values, bytes to clip, clip to bytes, on 9 MB of 31 joints, 96 channels, 4 decimals.
//!
//! `cargo bench -p motion --bench bvh`; with `BVH_OUT=FILE` set, the input is also written there, so that
//! another reader can be timed on it.

use std::fmt::Write;
use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use formats::bvh::{Bvh, ImportOptions, WriteOptions, import, write};

const JOINTS: usize = 31;
const FRAMES: usize = 11_500;

/// A chain of limbs with smooth channels of a few hertz.
fn text() -> String {
    let mut out = String::from("HIERARCHY\nROOT Hips\n{\n  OFFSET 0.0000 0.0000 0.0000\n");
    out += "  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n";
    for j in 1..JOINTS {
        let _ = write!(out, "  JOINT Joint{j}\n  {{\n    OFFSET {:.4} 3.0000 0.5000\n", 1.5 * (j % 5) as f64);
        out += "    CHANNELS 3 Zrotation Xrotation Yrotation\n";
        if j % 6 == 0 || j == JOINTS - 1 {
            out += "    End Site\n    {\n      OFFSET 0.0000 2.0000 0.0000\n    }\n";
            let open = if j % 6 == 0 { 6 } else { j % 6 };
            out += &"  }\n".repeat(open);
        }
    }
    let _ = write!(out, "}}\nMOTION\nFrames: {FRAMES}\nFrame Time: 0.016667\n");
    for frame in 0..FRAMES {
        for c in 0..6 + 3 * (JOINTS - 1) {
            let t = frame as f64 / 60.0;
            let x = c as f64;
            let value = 25.0 * (1.3 * t + x).sin()
                + 12.0 * ((2.0 + 0.1 * x) * t).cos()
                + 3.0 * (7.7 * t + x * x).sin();
            let _ = write!(out, "{}{value:.4}", if c == 0 { "" } else { " " });
        }
        out.push('\n');
    }
    out
}

fn bvh(c: &mut Criterion) {
    let text = text();
    if let Ok(path) = std::env::var("BVH_OUT") {
        std::fs::write(path, &text).expect("BVH_OUT can be written");
    }
    let parsed = Bvh::parse(text.as_bytes()).expect("the input is BVH");
    let clip = import(&parsed, &ImportOptions::default()).expect("the input is a clip").0;
    let mut group = c.benchmark_group("bvh");
    group.throughput(Throughput::Bytes(text.len() as u64)).sample_size(20);
    group.bench_function("parse", |b| b.iter(|| Bvh::parse(black_box(text.as_bytes()))));
    group.bench_function("import", |b| b.iter(|| import(black_box(&parsed), &ImportOptions::default())));
    group.bench_function("write", |b| b.iter(|| write(black_box(&clip), &WriteOptions::default())));
    group.finish();
}

criterion_group!(benches, bvh);
criterion_main!(benches);
