//! Disturbances in three engines: what is pushed over in one falls in the others, what is carried weighs the same.
//!
//! MuJoCo's Python environment is made on the first run.

use bodies::Carried;
use controllers::Drive;
use crosscheck::bridge::{Bridge, Shared};
use crosscheck::ground;
use crosscheck::mujoco::{Integration, Mujoco};
use crosscheck::{Check, environment, push};
use motion::Vec3;
use sim::{Engine, EngineSettings};
use studies::push::PushSettings;
use takes::{Ask, Input, Take};

fn bridge() -> Shared {
    let python = environment::prepare(&mut |_| {}).unwrap();
    Bridge::start(&python).unwrap().shared()
}

/// A standing human with these fields in its scene.
fn scene(fields: &str) -> Take {
    let ron = format!("Scene(character: \"characters/human.ron\", rate_hz: 60, {fields})");
    takes::open(Input::Text { ron, base: support::root().join("scenes") }, &Ask::default())
        .unwrap_or_else(|e| panic!("{e}"))
}

fn failed(checks: &[Check]) -> Vec<String> {
    let words = |c: &Check| format!("{}: {} and {} {} ({})", c.quantity, c.ours, c.mujoco, c.unit, c.at);
    checks.iter().filter(|c| !c.pass).map(words).collect()
}

/// A push that is too hard ends in a fall in all engines, told by the same story.
#[test]
fn slow_a_fall_is_a_fall_in_all() {
    let take = scene(
        "settle_s: 2, pushes: [Push(link: \"pelvis\", impulse_ns: 70, towards_deg: 180, start_s: 0.3)]",
    );
    let run = ground::scene(&bridge(), &take, &mut |_| {}).unwrap();
    let verdict = &run.checks[0];
    println!("{}", verdict.at);
    assert_eq!((verdict.ours, verdict.mujoco, verdict.pass), (0.0, 0.0, true), "{}", verdict.at);
    let stories = [&run.ours, &run.theirs, &run.core].map(|t| dynamics::fall::of(t).unwrap());
    let causes = stories.each_ref().map(|f| f.cause().unwrap());
    for other in &causes[1..] {
        assert_eq!(causes[0].margin, other.margin, "{stories:?}");
        assert!((causes[0].time_s - other.time_s).abs() < 0.05, "{stories:?}");
    }
}

/// A slope and a crate that comes and goes: the same forces in all.
#[test]
fn slow_a_slope_and_a_crate_weigh_the_same_in_all() {
    let take = scene(
        "settle_s: 1.8, world: (ground: Plane(friction: 0.8, tilt_deg: 4, towards_deg: 20)),
        carried: [Carried(link: \"chest\", mass_kg: 5, at_m: (0.05, 0, 0.2), from_s: 0.8, to_s: 1.3)]",
    );
    let run = ground::scene(&bridge(), &take, &mut |_| {}).unwrap();
    assert_eq!(failed(&run.checks), [""; 0]);
    // m g with the crate and without, at the ends of the two spans
    for trace in [&run.ours, &run.theirs, &run.core] {
        let sums = trace.contact_sums();
        for (s, mass) in [(1.28, 80.0), (1.78, 75.0)] {
            let row = (s * trace.rate_hz) as usize;
            let mean = sums[row - 12..row].iter().map(|f| f.y).sum::<f64>() / 12.0;
            let error = mean / (mass * 9.81) - 1.0;
            println!("{s} s: {:.2e}", error);
            assert!(error.abs() < 0.01, "{s} s: {mean} N");
        }
    }
}

/// Ground that tilts under the feet: the same forces and the same verdict in all.
#[test]
fn slow_a_seesaw_is_one_in_all() {
    let take = scene(
        "settle_s: 2.4, world: (ground: Plane(friction: 0.8, tilts: [
            Tilt(start_s: 0.3, duration_s: 0.7, tilt_deg: 5, towards_deg: 30),
            Tilt(start_s: 1.2, duration_s: 0.7)]))",
    );
    let run = ground::scene(&bridge(), &take, &mut |_| {}).unwrap();
    assert_eq!(failed(&run.checks), [""; 0]);
    // the soles of all ride on the ground
    let sole = take.body.character.skeleton.sites()[take.body.character.contacts[0]].clone();
    for trace in [&run.ours, &run.theirs, &run.core] {
        let row = (1.1 * trace.rate_hz) as usize;
        let k = motion::Kinematics::new(&take.body.character.skeleton, trace.pose(row));
        let p = k.point(sole.link, &sole.at);
        println!(
            "{:.3} mm over the ground, {:.1} mm over where it was",
            1e3 * trace.height(row, &p),
            1e3 * p.y
        );
        assert!(trace.height(row, &p).abs() < 1e-3 && p.y.abs() > 5e-3, "{p:?}");
    }
}

/// A mass handed over in flight: MuJoCo's body is from then on one built with it.
#[test]
fn slow_a_body_that_is_given_a_mass_is_one_with_it() {
    let human = bodies::anthropometry::human::human().0;
    let settings = EngineSettings {
        rate_hz: 240.0,
        substeps: 1,
        gravity: Vec3::new(0.0, -9.81, 0.0),
        ground: None,
        pinned: false,
        contact: Default::default(),
        props: Default::default(),
        self_collision: false,
    };
    let v: Vec<f64> = (0..human.skeleton.nv()).map(|i| 0.5 * (i as f64 * 2.3).cos()).collect();
    for name in ["wrist_r", "pelvis"] {
        let link = human.skeleton.link(name).unwrap();
        let load = Carried::solid_box(link, 5.0, Vec3::new(0.1, -0.2, 0.15), Vec3::new(0.3, 0.2, 0.1));
        let heavy = human.carrying([&load]);
        let build = |c: &bodies::Character| {
            let integration = Integration::reference(2);
            Mujoco::new(bridge(), &integration, c, settings.clone(), &human.rest, &v).unwrap()
        };
        let (mut given, mut built, mut light) = (build(&human), build(&heavy), build(&human));
        given.set_masses(&heavy).unwrap();
        let limp = vec![Drive::NONE; given.model().bodies.len()];
        for _ in 0..24 {
            for world in [&mut given, &mut built, &mut light] {
                world.set_drives(&limp);
                world.step().unwrap();
            }
        }
        let apart =
            |a: &Mujoco, b: &Mujoco| a.v().iter().zip(b.v()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{name}: {:.1e}, without {:.1e}", apart(&given, &built), apart(&given, &light));
        assert!(apart(&given, &built) < 1e-9, "{name}: {}", apart(&given, &built));
        assert!(apart(&given, &light) > 1e-3, "{name}");
    }
}

/// Pushes forward and back, coarse: all engines find the same border within the tolerance of the demand.
#[test]
fn slow_push_maps_agree() {
    let settings =
        PushSettings { directions: 2, tolerance: 0.08, at_s: 0.5, after_s: 2.0, ..PushSettings::default() };
    let maps = push::compare(&scene("settle_s: 1"), settings, &crosscheck::engine(|_| {}), &|_| {}).unwrap();
    let engines = [&maps.core, &maps.ours, &maps.theirs].map(|m| (m.engine.as_str(), m.mean_ratio));
    println!("{engines:?}");
    assert_eq!(engines.map(|e| e.0), ["core", "rapier", "mujoco"]);
    assert!(maps.check.pass, "{:?}", maps.check);
}
