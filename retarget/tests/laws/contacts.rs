//! Contact phases and adjustment.

use crate::bodies::{Held, held};

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
        let Held { human, puppet, clip: held, phases, report } = held(clip, size, legs);
        let share: f64 = phases.iter().map(|p| p.to_s - p.from_s).sum::<f64>()
            / (human.duration_s() * puppet.contacts.len() as f64);
        println!(
            "{clip} × {size}, legs × {legs}: {} phases, {share:.2} of the time, {report:?}",
            phases.len()
        );
        assert_eq!(held.frames(), human.frames());
        assert!(report.slip_m <= 1e-3, "{report:?}"); // 0.2 mm seen
        assert!(report.penetration_m <= 5e-3, "{report:?}"); // 2.2 mm seen
        worst = worst.max(report.jerk_ratio);
    }
    assert!(worst <= 1.2, "{worst}"); // 1.15 seen
}

#[test]
fn zz_diag() {
    use retarget::contacts::{paths, phases as ph, point_paths};
    use retarget::global_transform::{global_transform, in_local_frame};
    let (performer, human) = crate::bodies::mocap("16_21");
    let puppet = crate::bodies::puppet(crate::bodies::scaled(&performer.character, 1.0, 1.0));
    let local =
        in_local_frame(&crate::bodies::same_angles(&human, &puppet.character, 1.0), &puppet.features.root);
    let options = retarget::GlobalOptions { size: retarget::SizeRatio::Fixed(1.0), ..Default::default() };
    let (moved, _) = global_transform(&performer, &human, &puppet, &local, &options);
    let found = ph::find(&performer, &human, &puppet, &retarget::ContactOptions::default()).unwrap();
    let spans = ph::spans(&puppet, &found, &moved).unwrap();
    let before = point_paths(&puppet, &moved);
    let goals = paths::held_paths(&puppet, &before, &spans, 30.0);
    let (held, _) = retarget::contacts::adjust(&puppet, &moved, &found).unwrap();
    let after = point_paths(&puppet, &held);
    for c in 0..before.len() {
        let s = &puppet.character.skeleton.sites()[puppet.contacts[c].site];
        println!(
            "{} {} {:?}",
            s.name,
            s.link,
            spans[c].iter().map(|s| (s.first, s.last)).collect::<Vec<_>>()
        );
    }
    let mut far = 0.0f64;
    for c in 0..before.len() {
        for i in 0..before[0].len() {
            let d = goals[c][i] - before[c][i];
            far = far.max(d.x.hypot(d.z));
        }
    }
    println!("FAR {:.0} mm", 1e3 * far);
}
