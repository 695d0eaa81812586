//! Physics refinement.

use retarget::contacts::{adjust, phases};
use retarget::global_transform::{global_transform, in_local_frame};
use retarget::refine::refine;
use retarget::{ContactOptions, GlobalOptions, RefineDofs, RefineOptions};

use crate::bodies::{mocap, puppet, same_angles, scaled};

/// Force mismatch falls, the root hardly moves, contacts hold.
#[test]
fn forces_come_to_match() {
    for (clip, size, legs) in [("16_21", 0.6, 0.8), ("16_21", 1.0, 1.0)] {
        let (performer, human) = mocap(clip);
        let puppet = puppet(scaled(&performer.character, size, legs));
        let local = in_local_frame(&same_angles(&human, &puppet.character, size), &puppet.features.root);
        let (moved, _) = global_transform(&performer, &human, &puppet, &local, &GlobalOptions::default());
        let found = phases::find(&performer, &human, &puppet, &ContactOptions::default()).unwrap();
        let (held, _) = adjust(&puppet, &moved, &found).unwrap();
        let variance = vec![4e-4; human.frames()];
        for (dofs, spacing_s, k1, sink_m, collisions) in [
            (RefineDofs::RootHeight, 1.0 / 30.0, 1e-5, 0.0015, false),
            (RefineDofs::RootHeight, 1.0 / 30.0, 1e-5, 0.0015, true),
            (RefineDofs::RootAndLegs, 1.0 / 30.0, 1e-5, 0.0015, true),
        ] {
            let all = dofs == RefineDofs::RootAndLegs;
            let options =
                RefineOptions { dofs, spacing_s, k1, sink_m, collisions, ..RefineOptions::default() };
            let start = std::time::Instant::now();
            let (_, r) = refine(&puppet, &held, &found, &variance, &options).unwrap();
            if false && size == 1.0 {
                for i in 0..human.frames() {
                    println!(
                        "F {i} {:.0} {:.0} -> {:.0} {:.0}",
                        r.required_before[i].y,
                        r.contact_before[i].y,
                        r.required_after[i].y,
                        r.contact_after[i].y
                    );
                }
            }
            let fall = |c: usize| 100.0 * (1.0 - r.after[c] / r.before[c]);
            let sum = |x: &[f64; 6]| x.iter().sum::<f64>();
            println!(
                "{clip} × {size} all {all} h {spacing_s} k1 {k1} sink {sink_m}: falls {:?} all {:.1} %, root {:.1}/{:.1} mm, slip {:.2} mm, cone {} → {}, touch {:.1} → {:.1} mm, {} steps, {:.2} s",
                (0..6).map(|c| fall(c).round()).collect::<Vec<_>>(),
                100.0 * (1.0 - sum(&r.after) / sum(&r.before)),
                1e3 * r.root_median_m,
                1e3 * r.root_largest_m,
                1e3 * r.slip_m,
                r.cone_before.len(),
                r.cone_after.len(),
                1e3 * r.collision_m[0],
                1e3 * r.collision_m[1],
                r.iterations,
                start.elapsed().as_secs_f64()
            );
        }
    }
}
