use retarget::contacts::{adjust, phases, point_paths};
use retarget::global_transform::{global_transform, in_local_frame};
use retarget::{ContactOptions, GlobalOptions};

use crate::bodies::{mocap, puppet, same_angles, scaled};

#[test]
#[ignore]
fn dump() {
    let (performer, human) = mocap("16_21");
    let puppet = puppet(scaled(&performer.character, 0.5, 0.6));
    let local = in_local_frame(&same_angles(&human, &puppet.character, 0.5), &puppet.features.root);
    let (moved, _) = global_transform(&performer, &human, &puppet, &local, &GlobalOptions::default());
    let found = phases::find(&performer, &human, &puppet, &ContactOptions::default()).unwrap();
    let spans = phases::spans(&puppet, &found, &moved).unwrap();
    let (held, _) = adjust(&puppet, &moved, &found).unwrap();
    let (a, b) = (point_paths(&puppet, &moved), point_paths(&puppet, &held));
    let _ = (a, b, spans);
    let solids = retarget::refine::solids::Solids::new(&puppet, &[]);
    let mut deepest = std::collections::BTreeMap::new();
    for i in 0..held.frames() {
        let mut out = Vec::new();
        solids.touches(&motion::Kinematics::new(&held.skeleton, held.pose(i)), &mut out);
        for t in out {
            let name = |l: usize| held.skeleton.links()[l].name.clone();
            let key = (name(t.first.0), t.second.map(|s| name(s.0)));
            let d: &mut f64 = deepest.entry(key).or_default();
            *d = d.max(t.depth_m);
        }
    }
    println!("{deepest:#.4?}");
}
