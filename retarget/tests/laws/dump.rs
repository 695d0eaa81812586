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
    let (moved, _) = global_transform(
        &performer,
        &human,
        &puppet,
        &local,
        &GlobalOptions { size: retarget::SizeRatio::Fixed(1.0), ..GlobalOptions::default() },
    );
    let found = phases::find(&performer, &human, &puppet, &ContactOptions::default()).unwrap();
    let spans = phases::spans(&puppet, &found, &moved).unwrap();
    let (held, _) = adjust(&puppet, &moved, &found).unwrap();
    let (a, b) = (point_paths(&puppet, &moved), point_paths(&puppet, &held));
    let goals = retarget::contacts::paths::held_paths(&puppet, &a, &spans, 30.0);
    println!("goals {:?}", retarget::contacts::report(&a, &goals, &spans, 30.0));
    println!("held {:?}", retarget::contacts::report(&a, &b, &spans, 30.0));
    let j = |p: &[motion::Vec3], i: usize| (p[i + 3] - (p[i + 2] - p[i + 1]) * 3.0 - p[i]).norm() * 27000.0;
    for i in 0..human.frames() - 3 {
        print!("{i:3}");
        for c in 0..8 {
            let on = spans[c].iter().any(|s| s.first <= i && i <= s.last);
            print!(
                " | {}{:5.0} {:5.0} {:5.0} {:3.0}",
                if on { '#' } else { ' ' },
                j(&a[c], i),
                j(&goals[c], i),
                j(&b[c], i),
                1e3 * (goals[c][i] - b[c][i]).norm()
            );
        }
        println!();
    }
}
