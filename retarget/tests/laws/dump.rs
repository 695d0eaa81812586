use retarget::contacts::{adjust, phases, point_paths};
use retarget::global_transform::{global_transform, in_local_frame};
use retarget::{ContactOptions, GlobalOptions};

use crate::bodies::{mocap, puppet, same_angles, scaled};

#[test]
#[ignore]
fn dump() {
    let (performer, human) = mocap("16_21");
    let puppet = puppet(scaled(&performer.character, 1.0, 1.0));
    let local = in_local_frame(&same_angles(&human, &puppet.character, 1.0), &puppet.features.root);
    let (moved, _) = global_transform(&performer, &human, &puppet, &local, &GlobalOptions::default());
    let found = phases::find(&performer, &human, &puppet, &ContactOptions::default()).unwrap();
    for p in &found {
        println!("{} {:.0} {:.0}", p.point, p.from_s * 30.0, p.to_s * 30.0);
    }
    let (held, _) = adjust(&puppet, &moved, &found).unwrap();
    let (a, b) = (point_paths(&puppet, &moved), point_paths(&puppet, &held));
    for c in 0..4 {
        for i in 0..human.frames() {
            println!(
                "{c} {i:3} {:.4} -> {:.4}  dx {:.4} {:.4}",
                a[c][i].y,
                b[c][i].y,
                b[c][i].x - a[c][i].x,
                b[c][i].z - a[c][i].z
            );
        }
    }
}
