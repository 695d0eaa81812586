//! Joint fitting.

use std::sync::Arc;

use motion::metrics;
use retarget::fit::JointFit;
use retarget::global_transform::in_local_frame;

use crate::bodies::{mocap, puppet, same_angles, scaled};

/// Feature points of a pose give the pose back, along a whole clip and from nothing.
#[test]
fn features_and_fit_are_inverse() {
    let (performer, human) = mocap("14_37");
    let puppet = puppet(scaled(&performer.character, 0.6, 1.0));
    let clip = same_angles(&human, &puppet.character, 0.6);
    let local = in_local_frame(&clip, &puppet.features.root);
    let skeleton: Arc<_> = puppet.character.skeleton.clone();
    let mut fit = JointFit::new(&skeleton, &puppet.features);
    let mut found = local.clone();
    let (mut q, mut steps) = (skeleton.zero_pose(), 0);
    for i in 0..local.frames() {
        let z = puppet.features.of_pose(&skeleton, clip.pose(i), 0.0);
        let end = fit.solve(&z, &mut q, i == 0);
        assert!(end.rms_m < 1e-6, "frame {i}: {end:?}"); // 1e-9 seen
        steps += end.steps;
        found.pose_mut(i).copy_from_slice(&q);
    }
    let rms = metrics::joint_rms_deg(&metrics::joint_errors(&local, &found));
    println!("{rms:.2e}° RMS, {:.1} steps a frame", steps as f64 / local.frames() as f64);
    assert!(rms < 1e-4, "{rms}");
}
