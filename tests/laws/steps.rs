//! Convergence: half the step changes a run little, and half of that about half as much again.

use std::sync::Arc;

use dynamics::{RootMode, Trace};
use motion::Clip;
use motion::metrics::{joint_errors, joint_rms_deg};

use super::bodies::human;
use super::stage::{bow, follow, gravity, mocap, perform, performer, run};

/// Joint RMS between runs at 240 and 480 Hz, and at 480 and 960 Hz, degrees.
fn changes(run_at: impl Fn(f64) -> Trace) -> [f64; 2] {
    let clips = [240.0, 480.0, 960.0].map(|rate| run_at(rate).clip().resample(120.0));
    [0, 1].map(|i| joint_rms_deg(&joint_errors(&clips[i], &clips[i + 1])))
}

fn first_order(name: &str, changes: [f64; 2]) {
    let ratio = changes[1] / changes[0];
    println!("{name}: {:.4}° and {:.4}°, ratio {ratio:.2}", changes[0], changes[1]);
    assert!(changes[0] <= 0.5, "{name}: {}°", changes[0]);
    assert!((0.35..0.65).contains(&ratio), "{name}: ratio {ratio}");
}

#[test]
fn slow_a_pinned_script_converges() {
    let c = Arc::new(human());
    let tracks = bow(&c);
    first_order("pinned", changes(|rate| run(perform(&c, &tracks, RootMode::Pinned, rate, 1)).trace));
}

#[test]
fn slow_a_standing_script_converges() {
    let c = Arc::new(human());
    let tracks = bow(&c);
    for substeps in [1, 2] {
        let name = format!("free, {substeps} substeps");
        first_order(&name, changes(|rate| run(perform(&c, &tracks, RootMode::Free, rate, substeps)).trace));
    }
}

/// A recording keyed at 30 Hz is smooth at these steps; the raw one, at 120 Hz, has noise that 240 Hz
/// meets only twice a frame, so that its first halving gains more than half.
#[test]
fn slow_a_pinned_clip_converges() {
    for name in ["02_01.bvh", "49_07.bvh"] {
        let (c, clip) = performer(&mocap(name));
        let changes_of = |clip: &Clip| {
            changes(|rate| {
                let mut pass = follow(&c, clip, gravity(), 1.0, rate);
                pass.root = RootMode::Pinned;
                run(pass).trace
            })
        };
        first_order(name, changes_of(&clip.resample(30.0)));
        let raw = changes_of(&clip);
        println!("{name} raw: {:.4}° and {:.4}°", raw[0], raw[1]);
        assert!(raw[0] <= 0.5 && raw[1] < 0.65 * raw[0], "{name}: {raw:?}");
    }
}
