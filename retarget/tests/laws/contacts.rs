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
