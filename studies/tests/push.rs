//! Push recovery: what is survived, what is not, and that the map is the body's.

use std::sync::Arc;

use dynamics::RootMode;
use scenes::scene;
use sim::EngineEntry;
use studies::push::{PushError, PushSettings, PushTest, Verdict, confirm, map};
use takes::open::of_scene;
use takes::{Ask, Take};

fn stand() -> scene::Scene {
    scene::read(&support::scene("stand.ron")).unwrap()
}

fn standing() -> Take {
    of_scene(stand(), &Ask::default()).unwrap()
}

/// The standard test, shortened and coarse.
fn quick(directions: usize) -> PushSettings {
    PushSettings { directions, tolerance: 0.1, at_s: 0.3, after_s: 2.5, ..PushSettings::default() }
}

/// No push is survived, the impulse found too; the one above it, harder ones and a blow are not.
#[test]
fn slow_what_is_found_is_the_border() {
    let test = PushTest::new(&standing(), quick(1), &EngineEntry::default()).unwrap();
    for deg in [0.0, 90.0] {
        assert_eq!(test.push(deg, 0.0).unwrap(), Verdict::Survived);
    }
    let found = test.search(90.0, &|_| {}).unwrap();
    assert!(found.survived_ns > 0.0 && found.failed_ns - found.survived_ns <= 0.1 * found.failed_ns);
    assert_eq!(test.push(90.0, found.survived_ns).unwrap(), Verdict::Survived);
    assert_eq!(test.push(90.0, found.failed_ns).unwrap().name(), found.lost);
    for harder in [1.2, 1.5, 2.0] {
        let verdict = test.push(90.0, harder * found.failed_ns).unwrap();
        assert_ne!(verdict, Verdict::Survived, "{harder}");
    }
    // the run stops at the end, not 2.5 s later
    match test.push(0.0, 200.0).unwrap() {
        Verdict::FootMoved(t) | Verdict::Fell(t) => assert!(t > 0.3 && t < 1.3, "{t}"),
        other => panic!("{other:?}"),
    }
}

/// A heavy left hand to the left is a heavy right hand to the right.
#[test]
fn slow_the_mirrored_body_has_the_mirrored_map() {
    let with_heavy = |hand: &str| {
        let mut scene = stand();
        let mut character = (*scene.character).clone();
        let link = character.skeleton.link(hand).unwrap();
        character.bodies[link].mass += 3.0;
        scene.character = Arc::new(character);
        PushTest::new(&of_scene(scene, &Ask::default()).unwrap(), quick(1), &EngineEntry::default()).unwrap()
    };
    let (left, right) = (with_heavy("wrist_l"), with_heavy("wrist_r"));
    for deg in [0.0, 45.0, 90.0, 130.0, 180.0, 270.0, 320.0] {
        let (a, b) = (left.limit_ns(deg), right.limit_ns(360.0 - deg));
        assert!((a / b - 1.0).abs() < 1e-3, "{deg}: {a} {b}"); // 6e-5 seen
    }
    // the bodies do differ: 1.17 seen
    assert!(left.limit_ns(270.0) / left.limit_ns(90.0) > 1.05);
    // 6e-5 seen
    let (a, b) = (left.search(45.0, &|_| {}).unwrap(), right.search(315.0, &|_| {}).unwrap());
    assert!((a.survived_ns / b.survived_ns - 1.0).abs() < 0.1, "{a:?} {b:?}");
}

#[test]
fn slow_threads_do_not_matter() {
    let take = standing();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let settings = PushSettings { tolerance: 0.3, ..quick(3) };
        pool.install(|| map(&take, settings, &EngineEntry::default(), &|_| {}).unwrap()).to_json()
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert!(one.contains("\"symmetry_error_percent\": "), "{one}");
}

/// A body held by something else than its feet, and one that falls by itself, have no map, and it is said why.
#[test]
fn a_body_that_does_not_stand_is_refused() {
    let why = |change: &dyn Fn(&mut Take)| {
        let mut take = standing();
        change(&mut take);
        map(&take, quick(1), &EngineEntry::default(), &|_| {}).unwrap_err()
    };
    type Change = fn(&mut Take);
    let held: [(Change, &str); 5] = [
        (|s| s.conditions.physics.root = RootMode::Pinned, "pinned"),
        (|s| s.conditions.physics.root = RootMode::Assisted { force_n: 1.0, moment_nm: 1.0 }, "assisted"),
        (|s| s.conditions.physics.ground = None, "ground"),
        (|s| s.asked.plants.clear(), "planted"),
        (|s| s.conditions.physics.gravity.x = 1.0, "gravity"),
    ];
    for (change, word) in held {
        let e = why(&change);
        assert!(e.is_input() && e.to_string().contains(word), "{e}");
    }
    let pushed_over: Change = |s| {
        s.conditions.pushes.push(dynamics::Push {
            link: 0,
            at: motion::Vec3::zeros(),
            force: motion::Vec3::z() * 1500.0,
            start_s: 0.0,
            duration_s: 0.1,
        });
    };
    let e = why(&pushed_over);
    assert!(matches!(e, PushError::Unsteady { .. }) && !e.is_input(), "{e}");
}

/// What is done is told on the way: a fraction that never falls, in many steps, up to all of it.
#[test]
fn slow_a_map_tells_how_far_it_is() {
    let told = std::sync::Mutex::new(Vec::new());
    let test = PushTest::new(&standing(), quick(2), &EngineEntry::default()).unwrap();
    test.map(&|fraction| told.lock().unwrap().push(fraction)).unwrap();
    let told = told.into_inner().unwrap();
    assert!(told.len() >= 8, "{told:?}");
    assert!(told.windows(2).all(|w| w[1] >= w[0]) && told[0] < 0.5, "{told:?}");
    assert_eq!(told.last(), Some(&1.0));
}

/// A border found in the core lies between two pushes of rapier; a border that is wrong by a quarter does not, and is said not to.
#[test]
fn slow_a_second_engine_confirms_what_is_right_and_nothing_else() {
    let settings = PushSettings { tolerance: 0.02, ..quick(2) };
    let take = standing();
    let (core, rapier) = (sim::core::engine(), EngineEntry::default());
    let mut found = map(&take, settings, &core, &|_| {}).unwrap();
    let right = confirm(&found, &take, settings, &rapier, &|_| {}).unwrap();
    assert_eq!(
        (right.engine.as_str(), right.confirmed, right.directions.len()),
        ("rapier", 2, 2),
        "{right:?}"
    );
    // a map that promises too much forward, and too little backward
    found.directions[0].survived_ns *= 1.25;
    found.directions[0].failed_ns *= 1.25;
    found.directions[1].survived_ns *= 0.75;
    found.directions[1].failed_ns *= 0.75;
    let wrong = confirm(&found, &take, settings, &rapier, &|_| {}).unwrap();
    assert_eq!(wrong.confirmed, 0, "{wrong:?}");
    assert_ne!(wrong.directions[0].inside, "survived");
    assert_eq!(wrong.directions[1].outside, "survived");
}
