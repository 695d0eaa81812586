//! Scenes that step on their own feet: each keeps them, near the motion asked for, on feet that hold.

use dynamics::{RootMode, Walked};
use takes::{Ask, Engines};

/// Nothing holds the root; stances slip by less than 10 mm and joints are within 6° RMS of the motion made possible.
#[test]
fn slow_every_scene_that_steps_keeps_its_feet() {
    let all = support::files(&support::root().join("scenes/steps"), "ron");
    assert!(all.len() >= 4, "{all:?}");
    for path in all {
        let take = takes::open(&path, &Ask::default()).unwrap();
        assert_eq!(take.conditions.physics.root, RootMode::Free);
        assert!(take.scripted_steps() && take.looks_ahead(), "{}", take.name);
        let out = take.outcome(&Engines::default(), &mut |_| {}).unwrap();
        let walked = Walked::of(&out.trace, out.trace.rows());
        let slip_mm = walked.slip_mm_max();
        println!(
            "{}: {}; links {:.0} mm, joints {:.1}°, slip {slip_mm:.0} mm",
            take.name, out.verdict, walked.links_mm, walked.joints_deg
        );
        assert_eq!(walked.lost, None, "{}", take.name);
        assert!(out.trace.root_wrench.iter().all(|x| *x == 0.0), "{}", take.name);
        assert!(slip_mm < 10.0, "{}: {slip_mm}", take.name);
        assert!(walked.joints_deg < 6.0, "{}: {}", take.name, walked.joints_deg);
    }
}
