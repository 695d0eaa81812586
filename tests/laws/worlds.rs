//! Any world: without weight, without ground, with the ground elsewhere. The verdict is true, and nothing breaks.

use dynamics::Trace;
use dynamics::verdict::{Airborne, Ending, Grade};
use motion::Vec3;
use takes::{Ask, Engines, Input, Outcome, Report, Take};

fn open(world: &str) -> Take {
    let ron =
        format!("Scene(character: \"characters/human.ron\", rate_hz: 60, settle_s: 1, world: ({world}))");
    let input = Input::Text { ron, base: support::root().join("scenes") };
    takes::open(input, &Ask::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn perform(world: &str) -> (Take, Outcome) {
    let take = open(world);
    let out = take.outcome(&Engines::default(), &mut |_| {}).unwrap();
    assert!(out.diverged.is_none(), "{world}: {:?}", out.diverged);
    (take, out)
}

fn acceleration(t: &Trace) -> Vec3 {
    let at = |row: usize| motion::skeleton::vec_at(&t.momentum, 6 * row);
    let last = t.rows() - 1;
    let first = last / 2;
    (at(last) - at(first)) * t.rate_hz / ((last - first) as f64 * t.character.mass())
}

/// A body that nothing presses on a ground flies as Galileo says, whichever way gravity points, and the verdict says why.
#[test]
fn slow_what_does_not_stand_is_in_flight() {
    let plane = "ground: Plane(friction: 0.8)";
    let deep = "ground: Plane(friction: 0.8, height_m: -20)";
    for (gravity, ground) in [
        ((0.0, 0.0, 0.0), plane),
        ((0.0, 9.81, 0.0), plane),
        ((9.81, 0.0, 0.0), plane),
        ((0.0, -9.81, 0.0), "ground: None"),
        ((0.0, 0.0, 0.0), "ground: None"),
        ((0.0, -9.81, 0.0), deep),
    ] {
        let world = format!("gravity_m_s2: {gravity:?}, {ground}");
        let (take, out) = perform(&world);
        let g = Vec3::new(gravity.0, gravity.1, gravity.2);
        let error = (acceleration(&out.trace) - g).norm();
        println!("{world}: {}; off by {error:.1e} m/s²", out.verdict);
        assert!(error < 0.02, "{world}: {error} m/s²"); // 4e-3 seen
        let Ending::InFlight(flight) = &out.verdict.ending else { panic!("{world}: {}", out.verdict) };
        assert!(flight.from_s < 0.2, "{world}: {flight:?}");
        match flight.why {
            Airborne::NoGround => assert_eq!(take.conditions.physics.ground, None),
            Airborne::NoWeight => assert!(g.y >= 0.0),
            Airborne::Above(m) => assert!((m - (20.0 - 4.9)).abs() < 0.3, "{m} m"),
        }
        // a posture in the air is kept by muscles alone
        let d = Report::of(&take, Some(&out), &[]).dynamic.unwrap();
        assert_eq!(d.verdict.grade, Grade::InFlight.name());
        // 9° seen where sideways gravity drags the soles over the ground
        assert!(d.joint_rms_deg < 12.0, "{world}: {}°", d.joint_rms_deg);
        // without a ground there is no depth under it, here as in an analysis of what was performed
        assert_eq!(d.feet.is_some(), take.conditions.physics.ground.is_some(), "{world}");
        let weightless = g.norm() == 0.0;
        assert_eq!(d.root.residual_force_rms_percent_bw.is_none(), weightless, "{world}");
        assert_eq!(d.contact.vertical_end_percent_bw.is_none(), weightless, "{world}");
    }
}

/// Less gravity is gravity: on the Moon the body stands. What lands from a height has fallen, and is told that it began there.
#[test]
fn slow_other_grounds_are_judged_as_they_are() {
    let (_, moon) = perform("gravity_m_s2: (0, -1.62, 0)");
    assert_eq!(moon.verdict.grade(), Grade::AsAsked, "{}", moon.verdict);
    let (_, dropped) = perform("ground: Plane(friction: 0.8, height_m: -2)");
    let fall = dropped.fall.as_ref().unwrap_or_else(|| panic!("{}", dropped.verdict));
    // √(2·2/9.81) s until the soles arrive
    assert!(fall.time_s > 0.6 && fall.time_s < 0.8, "{}", fall.time_s);
    assert!(
        dropped.verdict.to_string().contains("its soles begin 2.00 m above the ground"),
        "{}",
        dropped.verdict
    );
}

/// A body without legs on a free root, which nothing balances: it rests on its foot, or its fall says that it has none to catch itself.
#[test]
fn slow_a_body_without_legs_says_why_it_falls() {
    let lamp = |pose: &str| {
        let ron = format!(
            "Scene(character: \"characters/lamp.ron\", rate_hz: 60, planted: [], settle_s: 1.5, {pose})"
        );
        let input = Input::Text { ron, base: support::root().join("scenes") };
        let take = takes::open(input, &Ask::default()).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(take.body.character.legs().count(), 0);
        take.outcome(&Engines::default(), &mut |_| {}).unwrap().verdict
    };
    // left alone it stands on its base, as in MuJoCo
    let verdict = lamp("");
    println!("{verdict}");
    assert_eq!(verdict.grade(), Grade::AsAsked, "{verdict}");
    assert!(matches!(&verdict.ending, Ending::Rests(links) if links.as_slice() == ["base"]), "{verdict}");
    let verdict = lamp("pushes: [Push(link: \"shade\", impulse_ns: 20, towards_deg: 0, start_s: 0.2)]");
    println!("{verdict}");
    assert_eq!(verdict.grade(), Grade::Fell, "{verdict}");
    assert!(verdict.to_string().contains("it has no legs to stand on"), "{verdict}");
}
