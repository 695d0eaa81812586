//! Contact phases and adjustment.

use retarget::contacts::{adjust, phases};
use retarget::global_transform::{global_transform, in_local_frame};
use retarget::{ContactOptions, GlobalOptions, SizeRatio};

use crate::bodies::{mocap, puppet, same_angles, scaled};

/// Slip, depth and jerk of what is held.
#[test]
fn points_stay_where_they_touch() {
    let mut worst: f64 = 0.0;
    for (clip, size, legs) in [
        ("16_21", 1.0, 1.0),
        ("16_21", 0.5, 0.85),
        ("14_37", 0.7, 1.0),
        ("127_01", 1.0, 0.8),
        ("16_03", 0.6, 0.7),
    ] {
        let (performer, human) = mocap(clip);
        let puppet = puppet(scaled(&performer.character, size, legs));
        let local = in_local_frame(&same_angles(&human, &puppet.character, size), &puppet.features.root);
        // steps as long as the legs make them: the paper's ratio knows nothing of legs
        let options = GlobalOptions { size: SizeRatio::Fixed(size * legs), ..GlobalOptions::default() };
        let (moved, _) = global_transform(&performer, &human, &puppet, &local, &options);
        let found = phases::find(&performer, &human, &puppet, &ContactOptions::default()).unwrap();
        let (held, report) = adjust(&puppet, &moved, &found).unwrap();
        let share: f64 = found.iter().map(|p| p.to_s - p.from_s).sum::<f64>()
            / (human.duration_s() * puppet.contacts.len() as f64);
        println!(
            "{clip} × {size}, legs × {legs}: {} phases, {share:.2} of the time, {report:?}",
            found.len()
        );
        assert_eq!(held.frames(), human.frames());
        assert!(report.slip_m <= 1e-3, "{report:?}"); // 0.2 mm seen
        assert!(report.penetration_m <= 5e-3, "{report:?}"); // 2.2 mm seen
        worst = worst.max(report.jerk_ratio);
    }
    assert!(worst <= 1.2, "{worst}"); // 1.15 seen
}
