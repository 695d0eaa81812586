//! What scenes, contact phases, patches and overrides say is read to the very value, and every fault is told in words at its place.

use std::path::{Path, PathBuf};

use dynamics::RootMode;
use motion::{Contact, ContactPlan, Curve, Transform, Value, Vec3};
use retarget::contacts::Phase;
use retarget::{Puppet, SizeRatio};
use scenes::character_file::read_file;
use scenes::conditions::Clock;
use scenes::overrides::{Overrides, RootChoice, Strategy, span};
use scenes::scene::{Scene, parse, read};
use scenes::{Patch, SceneError, Source, contact_file};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

fn text(rest: &str) -> Result<Scene, SceneError> {
    let ron = format!("Scene(character: \"characters/human.ron\",\n{rest})");
    parse(Source::new(folder().join("test.ron"), ron.as_str()), "test".into())
}

fn scene(rest: &str) -> Scene {
    text(rest).unwrap_or_else(|e| panic!("{rest}: {e}"))
}

fn close(a: Vec3, b: [f64; 3]) {
    assert!((a - Vec3::from(b)).norm() < 1e-12, "{a:?}, expected {b:?}");
}

/// World, root, muscles: degrees become radians, shares of the weight newtons.
#[test]
fn conditions_have_the_values_of_the_text() {
    let s = scene(
        "rate_hz: 60, engine: \"mujoco\", physics: (rate_hz: 480, substeps: 3, tension: 1.5), balance: (ankle_stiffness: 0.8, arms: true, without: [Hip]),
         world: (gravity_m_s2: (0, -1.62, 0), ground: Plane(friction: 0.5, height_m: 0.25, tilt_deg: 10, towards_deg: 90,
            tilts: [Tilt(start_s: 1, duration_s: 0.5, tilt_deg: 5, towards_deg: 180, curve: EaseInOut), Tilt(start_s: 2, duration_s: 1, tilt_deg: 0)])),
         root: Assisted(force_n: 80, moment_nm: 20)",
    );
    let p = &s.conditions.physics;
    assert_eq!((s.rate_hz, p.rate_hz, p.substeps, p.tension), (Some(60.0), Some(480.0), Some(3), 1.5));
    assert_eq!(s.conditions.engine.as_deref(), Some("mujoco"));
    assert_eq!(p.root, RootMode::Assisted { force_n: 80.0, moment_nm: 20.0 });
    assert_eq!((p.balance.ankle_stiffness, p.balance.arms), (Some(0.8), true));
    close(p.gravity, [0.0, -1.62, 0.0]);
    let ground = p.ground.unwrap();
    assert_eq!((ground.friction, ground.height_m, s.conditions.height_given), (0.5, 0.25, true));
    // it falls to the left, +x: there its normal leans
    assert!((ground.up.angle(&Vec3::y()).to_degrees() - 10.0).abs() < 1e-9 && ground.up.x > 0.17);
    let tilts = &s.conditions.tilts;
    assert_eq!(tilts.len(), 2);
    assert!((tilts[0].value.tilt - 5f64.to_radians()).abs() < 1e-15);
    assert_eq!((tilts[0].value.start_s, tilts[0].value.curve), (1.0, Curve::EaseInOut));

    // fidelity 0.5: a quarter of the weight, tension doubled
    let s = scene("root: Fidelity(0.5)");
    let RootMode::Assisted { force_n, .. } = s.conditions.physics.root else { panic!("not assisted") };
    assert!((force_n / (0.25 * s.character.mass() * 9.81) - 1.0).abs() < 1e-3, "{force_n}");
    assert!((s.conditions.physics.tension - 2.0).abs() < 1e-12);
    assert_eq!(scene("root: Fidelity(0)").conditions.physics.root, RootMode::Free);
    assert_eq!(scene("world: (ground: None)").conditions.physics.ground, None);
}

/// Pushes in both forms, masses and gazes.
#[test]
fn disturbances_have_the_values_of_the_text() {
    let s = scene(
        "pushes: [Push(link: \"chest\", impulse_ns: 5, towards_deg: 90, start_s: 1, duration_s: 0.1), Push(link: \"head\", at_m: (0, 0.1, 0), impulse_ns: (0, -2, 4.5), start_s: 2, clock: World)],
         carried: [Carried(link: \"wrist_r\", mass_kg: 3, at_m: (0, -0.1, 0), size_m: (0, 0, 0), from_s: 0.5, to_s: 2, known: false)],
         reactive: [Gaze(at_m: (1, 1.5, 2), from_s: 0.5, to_s: 1.5, joints: [\"neck\", \"head\"], trunk: 0.25), Gaze(at_m: (0, 1, 3))]",
    );
    let c = &s.conditions;
    let skeleton = &s.character.skeleton;
    close(c.pushes[0].value.force, [50.0, 0.0, 0.0]);
    assert_eq!(Some(c.pushes[0].value.link), skeleton.link("chest"));
    let second = &c.pushes[1];
    close(second.value.force * second.value.duration_s, [0.0, -2.0, 4.5]);
    close(second.value.at, [0.0, 0.1, 0.0]);
    assert_eq!(second.clock, Clock::World);
    let carried = &c.carried[0].value;
    assert_eq!((carried.from_s, carried.to_s, carried.known), (0.5, 2.0, false));
    let gaze = c.gazes[0].value.settings();
    close(gaze.target, [1.0, 1.5, 2.0]);
    assert_eq!((gaze.from_s, gaze.to_s, gaze.trunk), (0.5, 1.5, 0.25));
    assert_eq!(c.gazes[1].value.settings().to_s, f64::INFINITY);
}

/// Actions, poses and inserts: angles in radians, lengths relative to rest, properties where they were said.
#[test]
fn scripts_have_the_values_of_the_text() {
    let s = scene(
        "properties: (tension: 2), settle_s: 0.5, planted: [\"leg_l\"],
         script: [Action(name: \"a\", start_s: 0.5, duration_s: 0.4, cycles: [Cycle(repetitions: 3, hold_s: 0.1, poses: [
            Pose(set_deg: { \"elbow_r\": 90, \"head\": (0, 30, 0) }, set_m: { \"pelvis_y\": -0.1 }, rest: [\"knee_l\"], elements: { \"elbow_r\": (curve: Bezier(0.2, 0, 0.4, 1)) })])])],
         inserts: [Insert(name: \"i\", start_s: 2, set_deg: { \"elbow_l\": 45 }, tension: 3)]",
    );
    let spec = s.motion.script().unwrap();
    assert!(spec.moves() && s.motion.describe() == "script" && s.motion.files().is_empty());
    assert_eq!((spec.settle_s, spec.planted.len(), spec.script.properties.tension), (0.5, 1, Some(2.0)));
    let action = &spec.script.actions[0];
    assert_eq!(
        (action.start_s, action.properties.duration_s, action.cycles[0].repetitions),
        (0.5, Some(0.4), 3)
    );
    let values = &action.cycles[0].poses[0].values;
    let of = |name: &str| values.iter().find(|v| v.dof == name).unwrap_or_else(|| panic!("{name}"));
    let Value::Scalar(elbow) = of("elbow_r").value else { panic!("a hinge") };
    assert!((elbow - 90f64.to_radians()).abs() < 1e-15);
    assert_eq!(of("elbow_r").properties.curve, Some(Curve::Bezier(0.2, 0.0, 0.4, 1.0)));
    let Value::Rotation(head) = of("head").value else { panic!("a ball") };
    assert!((head.angle().to_degrees() - 30.0).abs() < 1e-9);
    let rest = s.character.rest[s.character.skeleton.q_at(0) + 1];
    let Value::Scalar(height) = of("pelvis_y").value else { panic!("a length") };
    assert!((height - (rest - 0.1)).abs() < 1e-12);
    assert_eq!(values.len(), 4);
    let insert = &spec.script.inserts[0];
    assert_eq!((insert.start_s, insert.value.properties.tension), (2.0, Some(3.0)));
}

/// Steps and jumps, edits of every kind of parameter, and motions that are files.
#[test]
fn the_rest_of_a_scene_has_the_values_of_the_text() {
    let s = scene(
        "root: Pinned, footwork: [Step(limb: \"leg_r\", start_s: 1, duration_s: 0.5, to_m: (0.1, 0.2), turn_deg: 30, lift_m: 0.05), Jump(start_s: 2, duration_s: 0.4, point_deg: 20, tuck_m: 0.03)]",
    );
    let work = &s.motion.script().unwrap().footwork;
    let (step, jump) = (&work.steps[0], &work.jumps[0]);
    assert_eq!((step.start_s, step.duration_s, step.to, step.lift), (1.0, 0.5, [0.1, 0.2], 0.05));
    assert!(
        (step.turn - 30f64.to_radians()).abs() < 1e-15 && (jump.point - 20f64.to_radians()).abs() < 1e-15
    );
    assert!(!work.is_still() && work.jumps.len() == 1);

    let script = "script: [Action(name: \"a\", cycles: [Cycle(poses: [Pose(duration_s: 1, set_deg: { \"elbow_r\": 90 })])])]";
    let s = scene(&format!(
        "{script}, edits: [Amplitude(on: \"a\", factor: [1, 0.5]), Tension(on: \"a\", factor: (over_time_s: [(0, 1), (1, 2)])), Tension(on: \"a\", absolute: (over_repetition: [(0, 1)])),
          ExtentReach(on: \"a\", factor: 1), ExtentShoulder(on: \"a\", extent: 0.5), Warp(times_s: [(0, 0), (1, 2)]),
          Pin(point: \"wrist_r\", point_m: (-0.1, 0, 0), at: Link(\"pelvis\", (0.1, 0, 0.1)), from_s: 0.5, to_s: 1), Pin(point: \"gaze\", at: Asked, from_s: 0, to_s: 1, blend_s: 0)]"
    ));
    let names: Vec<&str> = s.edits.iter().map(|e| e.kind.name()).collect();
    assert_eq!(names.len(), 8);
    assert_eq!(names[6..], ["pin", "pin"]);
    assert!(names[0].contains("mplitude") && names[5].contains("arp"), "{names:?}");
    assert_eq!(s.edits[0].place.on, ["a"]);

    let s = scene("motion: Retarget(of: \"performances/fear.ron\", size: Fixed(0.5))");
    assert!(s.motion.describe().starts_with("retargeted ") && s.motion.script().is_none());
    let scenes::SceneSource::Retarget(spec) = &s.motion else { panic!("no retargeting") };
    assert_eq!(spec.options.global.size, SizeRatio::Fixed(0.5));
    assert!(s.files.iter().any(|f| f.ends_with("fear.ron")));
}

/// Every scene, performance and case is read or refused with words.
#[test]
fn the_scenes_of_the_library_are_read() {
    let mut count = 0;
    for entry in std::fs::read_dir(folder()).unwrap().map(|e| e.unwrap().path()) {
        if entry.extension().is_some_and(|e| e == "ron") {
            let s = read(&entry).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(s.name, entry.file_stem().unwrap().to_string_lossy());
            count += 1;
        }
    }
    assert!(count > 10, "{count}");
}

/// A value that makes no sense is refused with what it is, what is allowed and where.
#[test]
fn scenes_are_refused_with_words() {
    let pose = |p: &str| {
        format!("script: [Action(name: \"a\", cycles: [Cycle(poses: [Pose(duration_s: 1, {p})])])]")
    };
    let action = |a: &str| format!("script: [Action(name: \"a\", {a}, cycles: [])]");
    let tilt = |t: &str| format!("world: (ground: Plane(friction: 0.8, tilts: [{t}]))");
    let push = |p: &str| format!("pushes: [Push(link: \"chest\", start_s: 0, {p})]");
    let carried = |c: &str| format!("carried: [Carried({c})]");
    let gaze = |g: &str| format!("reactive: [Gaze({g})]");
    let cases: Vec<(String, &str)> = vec![
        ("rate_hz: 0".into(), "rate_hz is 0 Hz; allowed: 1 to 1000 Hz"),
        ("strip: (figures: 1)".into(), "1 figures; allowed: 2 to 40"),
        ("engine: \" \"".into(), "the name of the engine is empty"),
        ("physics: (rate_hz: 1)".into(), "rate_hz is 1 Hz; allowed:"),
        ("physics: (substeps: 65)".into(), "65 substeps; allowed: 1 to 64"),
        ("physics: (tension: 0)".into(), "tension is 0 (1 = natural); allowed:"),
        ("root: Assisted(force_n: -1, moment_nm: 0)".into(), "force_n is -1 N; allowed: 0 to 1000000 N"),
        ("root: Fidelity(2)".into(), "root is 2; allowed: 0 to 1"),
        ("root: Pined".into(), "did you mean `Pinned`?"),
        ("world: (gravity_m_s2: (0, inf, 0))".into(), "a number that is not finite"),
        ("world: (ground: Plane(friction: 3))".into(), "friction is 3; allowed: 0 to 2"),
        ("world: (ground: Plane(friction: 0.8, tilt_deg: 45))".into(), "tilt_deg is 45 °; allowed: 0 to 30 °"),
        ("balance: (ankle_stiffness: 100)".into(), "ankle_stiffness is 100 m g h; allowed: 0.05 to 20"),
        (format!("root: Pinned, {}", tilt("Tilt(start_s: 0, duration_s: 1, tilt_deg: 5)")), "tilts under a pinned root"),
        (
            tilt("Tilt(start_s: 1, duration_s: 1, tilt_deg: 5), Tilt(start_s: 1.5, duration_s: 1, tilt_deg: 5)"),
            "begins at 1.5 s; allowed: from 2 s on",
        ),
        (tilt("Tilt(start_s: 0, duration_s: 0, tilt_deg: 5)"), "duration_s is 0 s; allowed: 0.05 to 3600 s"),
        (
            tilt("Tilt(start_s: 0, duration_s: 1, tilt_deg: 5, curve: Bezier(2, 0, 0, 1))"),
            "a Bezier handle is out of range",
        ),
        ("pushes: [Push(link: \"chst\", impulse_ns: (0, 0, 1), start_s: 0)]".into(), "unknown link `chst` in a push; did you mean `chest`?"),
        (push("impulse_ns: 5"), "impulse_ns is 5 N·s without a direction"),
        (push("impulse_ns: 5.5"), "impulse_ns is 5.5 N·s without a direction"),
        (push("impulse_ns: -5, towards_deg: 0"), "impulse_ns is -5 N·s; allowed: 0 to"),
        (push("impulse_ns: (1, 2, 3), towards_deg: 0"), "impulse_ns has a direction of its own"),
        (push("impulse_ns: (1, 2)"), "a number of N·s beside towards_deg, or (x, y, z)"),
        (push("impulse_ns: (1, 2, 3, 4)"), "a number of N·s beside towards_deg, or (x, y, z)"),
        (push("impulse_ns: \"hard\""), "a number of N·s beside towards_deg, or (x, y, z)"),
        (push("impulse_ns: (1e9, 0, 0)"), "impulse_ns is 1000000000 N·s; allowed: -10000000 to"),
        (push("impulse_ns: (1, 0, 0), at_m: (0, 11, 0)"), "at_m is 11 m; allowed: -10 to 10 m"),
        (carried("link: \"hand\", mass_kg: 1"), "unknown link `hand` in a Carried"),
        (carried("link: \"wrist_r\", mass_kg: 0"), "mass_kg is 0 kg; allowed: 0.001 to 1000 kg"),
        (carried("link: \"wrist_r\", mass_kg: 1, size_m: (0, 0, -1)"), "size_m is -1 m; allowed: 0 to 10 m"),
        (carried("link: \"wrist_r\", mass_kg: 1, from_s: 2, to_s: 1"), "to_s is 1 s; allowed: later than from_s, 2 s"),
        (gaze("at_m: (0, 0, 1e6)"), "at_m is 1000000 m; allowed: -10000 to 10000 m"),
        (gaze("at_m: (0, 0, 1), from_s: 2, to_s: 2"), "to_s is 2 s; allowed: later than from_s, 2 s"),
        (gaze("at_m: (0, 0, 1), joints: [\"nek\"]"), "unknown link `nek` in a Gaze; did you mean `neck`?"),
        (gaze("at_m: (0, 0, 1), eyes: \"nose\""), "nose"),
        (gaze("at_m: (0, 0, 1), joints: [\"elbow_r\"]"), "elbow_r"),
        (gaze("at_m: (0, 0, 1), joints: []"), "joint"),
        ("planted: [\"leg_x\"]".into(), "unknown limb `leg_x` in planted"),
        ("settle_s: -1".into(), "settle_s is -1 s; allowed: 0 to 3600 s"),
        ("script: [Action(name: \"\", cycles: [])]".into(), "name"),
        ("script: [Action(name: \"a\", cycles: []), Action(name: \"a\", cycles: [])]".into(), "two actions are called `a`"),
        (action("start_s: -1"), "start_s is -1 s; allowed: 0 to 86400 s"),
        (action("tension: 0"), "tension is 0 (1 = natural); allowed: 0.001 to 1000"),
        (action("duration_s: -1"), "duration_s is -1 s; allowed: 0 to 86400 s"),
        (action("curve: Bezier(0, 0, 2, 1)"), "a Bezier handle is out of range"),
        (
            "script: [Action(name: \"a\", cycles: [Cycle(repetitions: 0, poses: [])])]".into(),
            "0 repetitions; allowed: 1 to 10000",
        ),
        (pose("set_deg: { \"elbw_r\": 1 }"), "unknown joint `elbw_r` in a pose of \"a\"; did you mean `elbow_r`?"),
        (pose("set_deg: { \"elbow_r\": 4000 }"), "`elbow_r` is 4000°; allowed: -3600 to 3600"),
        (pose("set_deg: { \"elbow_r\": (1, 2, 3) }"), "`elbow_r` is a hinge in a pose of \"a\": it takes one number of degrees"),
        (pose("set_deg: { \"head\": 4 }"), "`head` is a ball joint in a pose of \"a\": it takes (x, y, z) in degrees"),
        (pose("set_deg: { \"pelvis_y\": 4 }"), "`pelvis_y` is a length in a pose of \"a\": set it in set_m"),
        (pose("set_m: { \"elbow_r\": 4 }"), "`elbow_r` is an angle in a pose of \"a\": set it in set_deg"),
        (pose("set_m: { \"pelvis_y\": 4000 }"), "allowed: -1000 to 1000 m"),
        (pose("set_deg: { \"elbow_r\": 4 }, rest: [\"elbow_r\"]"), "`elbow_r` is set twice in a pose of \"a\""),
        (
            pose("set_deg: { \"elbow_r\": 4 }, elements: { \"elbow_l\": (hold_s: 1) }"),
            "unknown element `elbow_l` in a pose of \"a\"; did you mean `elbow_r`?",
        ),
        (
            "root: Assisted(force_n: 80, moment_nm: 50), footwork: [Jump(start_s: 1, duration_s: 0.4)]".into(),
            "footwork needs `root: Free` or `root: Pinned`",
        ),
        (
            "root: Pinned, footwork: [Step(limb: \"leg_q\", start_s: 1, duration_s: 0.4, to_m: (0, 0))]".into(),
            "unknown planted limb `leg_q` in a step",
        ),
        (
            "root: Pinned, footwork: [Step(limb: \"leg_l\", start_s: 1, duration_s: 0.4, to_m: (0, 0)), Step(limb: \"leg_l\", start_s: 1.2, duration_s: 0.4, to_m: (0, 0))]".into(),
            "`leg_l` starts a step at 1.2 s, but its last one ends at 1.400 s",
        ),
        (format!("{}, edits: [Tension(on: \"a\")]", pose("set_deg: { \"elbow_r\": 4 }")), "either `factor` or `absolute`"),
        (
            format!("{}, edits: [Amplitude(on: \"a\", factor: 1, fit: (deg: 0))]", pose("set_deg: { \"elbow_r\": 4 }")),
            "`fit` is (deg: 0, mm: 10); allowed: both above 0 and finite",
        ),
        (
            format!("{}, edits: [Amplitude(on: \"a\", factor: 1, fit: (dg: 2))]", pose("set_deg: { \"elbow_r\": 4 }")),
            "unknown field `dg` of `fit`",
        ),
        (
            format!("{}, edits: [Tension(span_s: (0, 1), factor: 2)]", pose("set_deg: { \"elbow_r\": 4 }")),
            "the tension of a script is that of its elements",
        ),
        (
            format!("{}, edits: [Pin(point: \"gaze\", at: World(0, 1, 2), from_s: 0, to_s: 1), Warp(times_s: [(0, 0), (1, 2)])]", pose("set_deg: { \"elbow_r\": 4 }")),
            "the edit `warp` comes after the pin of `gaze`; allowed: pins last",
        ),
        (
            format!("{}, edits: [Pin(point: \"gaze\", at: Nowhere, from_s: 0, to_s: 1)]", pose("set_deg: { \"elbow_r\": 4 }")),
            "Nowhere",
        ),
        (
            format!("{}, edits: [Amplitude(on: \"a\", factor: (over_tme_s: []))]", pose("set_deg: { \"elbow_r\": 4 }")),
            "over_t",
        ),
        (
            format!("{}, edits: [Amplitude(on: \"a\", factor: \"much\")]", pose("set_deg: { \"elbow_r\": 4 }")),
            "a number, [a, list, over, poses]",
        ),
        ("motion: Clip(\"no-such.bvh\")".into(), "no-such.bvh"),
        ("motion: Retarget(of: \"performances/fear.ron\", size: Fixed(-1))".into(), "the size ratio is -1; allowed: positive numbers"),
        ("patch: \"no-such.ron\"".into(), "no-such.ron"),
        ("tune: (parameters: [\"wieght\"])".into(), "wieght"),
    ];
    let mut wrong = Vec::new();
    for (ron, words) in &cases {
        match text(ron) {
            Ok(_) => wrong.push(format!("{ron}\n  was read; expected: {words}")),
            Err(e) => {
                let e = e.to_string();
                if !e.contains(words) || !e.contains("test.ron:") {
                    wrong.push(format!("{ron}\n  said: {e}\n  expected: {words}, at its place in test.ron"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn lamp() -> Puppet {
    let file = read_file(&folder().join("characters/lamp.ron")).unwrap_or_else(|e| panic!("{e}"));
    Puppet::new(file.character, file.follows).unwrap_or_else(|e| panic!("{e}"))
}

/// Phases that were written are read back to a tenth of a millisecond; faults are told at their place.
#[test]
fn contacts_are_read_and_refused() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("contacts.ron");
    let lamp = lamp();
    let read = |text: &str| {
        std::fs::write(&path, text).unwrap();
        contact_file::read(&path, &lamp, 2.0)
    };
    let phase = |point: &str, from_s, to_s| Phase { point: point.into(), from_s, to_s };
    let phases =
        [phase("base_back", 0.0, 0.12345), phase("base_front", 0.5, 1.0), phase("base_front", 1.25, 2.0)];
    let text = contact_file::text(&lamp, &phases);
    assert!(text.contains("\"base_left\": [],"), "{text}");
    let back = read(&text).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(back, [phase("base_back", 0.0, 0.1235), phases[1].clone(), phases[2].clone()]);
    // the end of a motion is rounded in the file
    assert_eq!(read("(points: {\"base_left\": [(0, 2.0005)]})").unwrap().len(), 1);

    let fault = |text: &str| read(text).expect_err(text).to_string();
    for (text, words) in [
        ("(points: {\"base_lft\": []})", "unknown contact point `base_lft`; did you mean `base_left`?"),
        ("(points: {\"eyes\": []})", "unknown contact point `eyes`"),
        (
            "(points: {\"base_left\": [(1, 0.5)]})",
            "a contact from 1 to 0.5 s; allowed: 0 to 2.000 s, the earlier time first",
        ),
        ("(points: {\"base_left\": [(0, 2.1)]})", "a contact from 0 to 2.1 s"),
        ("(points: {\"base_left\": [(-1, 1)]})", "a contact from -1 to 1 s"),
        (
            "(points: {\"base_left\": [(0, 1), (1, 2)]})",
            "a contact from 1 s on; the one before ends at 1 s: join them",
        ),
        ("(points: {}, more: 1)", "more"),
    ] {
        let said = fault(text);
        assert!(said.contains(words) && said.contains("contacts.ron:1:"), "{text}: {said}");
    }
    assert!(contact_file::read(&dir.path().join("none.ron"), &lamp, 1.0).is_err());
}

/// A plan with places is read back to a tenth of a millimetre and a thousandth of a degree; places that are not one for each contact,
/// or of steps that find their own, are refused.
#[test]
fn plans_with_places_are_read_and_refused() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("contacts.ron");
    let place = Transform::from_parts(
        Vec3::new(0.123_456, -0.02, 1.5).into(),
        motion::rotation::quat_from_deg([2.0, 33.3333, -1.0]),
    );
    let contact =
        |from_s, to_s, world_from_point| Contact { point: "leg_l".into(), from_s, to_s, world_from_point };
    let plan =
        ContactPlan::new(vec![contact(0.0, 0.5, Some(place)), contact(0.75, 1.0, Some(place))]).unwrap();
    let names = ["leg_l", "leg_r"];
    std::fs::write(&path, contact_file::plan_text(&names, &plan)).unwrap();
    let back = contact_file::read_plan(&path, &names, 1.0).unwrap_or_else(|e| panic!("{e}"));
    for (a, b) in plan.contacts().iter().zip(back.contacts()) {
        assert_eq!((&a.point, a.from_s, a.to_s), (&b.point, b.from_s, b.to_s));
        let (a, b) = (a.world_from_point.unwrap(), b.world_from_point.unwrap());
        assert!((a.translation.vector - b.translation.vector).norm() < 1e-4);
        assert!(a.rotation.angle_to(&b.rotation) < 1e-5);
    }
    let at = "At(at_m: (0, 0, 0), rotation_deg: (0, 0, 0))";
    for (text, words) in [
        (format!("(points: {{\"leg_l\": [(0, 1)]}}, places: {{\"leg_l\": [{at}, {at}]}})"), "2 places; allowed: one for each of the 1"),
        (format!("(points: {{}}, places: {{\"leg_x\": [{at}]}})"), "unknown contact point `leg_x`"),
        ("(points: {\"leg_l\": [(0, 1)]}, places: {\"leg_l\": [At(at_m: (0, inf, 0), rotation_deg: (0, 0, 0))]})".into(), "not finite"),
    ] {
        std::fs::write(&path, &text).unwrap();
        let said = contact_file::read_plan(&path, &names, 1.0).expect_err(&text).to_string();
        assert!(said.contains(words) && said.contains("contacts.ron:1:"), "{text}: {said}");
    }
    std::fs::write(
        &path,
        format!("(points: {{\"base_left\": [(0, 1)]}}, places: {{\"base_left\": [{at}]}})"),
    )
    .unwrap();
    let said = contact_file::read(&path, &lamp(), 2.0).expect_err("places of a puppet").to_string();
    assert!(said.contains("allowed: no places"), "{said}");
}

/// A patch in a file changes the numbers it names and no other; a scene takes it, then the command line.
#[test]
fn patches_and_overrides_change_what_they_name() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("patch.ron");
    std::fs::write(&path, "Patch(set: {\"catch_gain\": (is: 1.25)})").unwrap();
    let patch = Patch::read(&path).unwrap_or_else(|e| panic!("{e}"));
    let plain = scene("").conditions.physics;
    let mut physics = plain;
    patch.apply(&mut physics);
    assert_ne!(physics.balance, plain.balance);
    assert_eq!(physics.tension, plain.tension);
    assert!(Patch::read(&dir.path().join("none.ron")).is_err());
    let s = scene(&format!("patch: {:?}", path.to_str().unwrap()));
    assert_eq!(s.conditions.physics.balance, physics.balance);
    assert!(s.files.iter().any(|f| f.ends_with("patch.ron")));

    let human = s.character;
    let weight = human.mass() * plain.gravity.norm();
    let with = |o: Overrides| {
        let mut p = plain;
        o.apply(&mut p, &human);
        p
    };
    let o = with(Overrides {
        patch: Some(patch),
        root: Some(RootChoice::Assisted(None)),
        tension: Some(1e9),
        rate_hz: Some(480.0),
        substeps: Some(4),
        without: vec![Strategy::Hip],
        past_fall: true,
        ..Overrides::default()
    });
    assert_eq!(o.root, RootMode::Assisted { force_n: 0.1 * weight, moment_nm: 50.0 });
    assert_eq!((o.rate_hz, o.substeps, o.past_fall), (Some(480.0), Some(4), true));
    assert_eq!(o.tension, *scenes::overrides::TENSIONS.end());
    assert_eq!(o.balance, physics.balance.without(Strategy::Hip));
    let root = |choice| with(Overrides { root: Some(choice), ..Overrides::default() }).root;
    assert_eq!((root(RootChoice::Free), root(RootChoice::Pinned)), (RootMode::Free, RootMode::Pinned));
    let given = RootMode::Assisted { force_n: 5.0, moment_nm: 6.0 };
    assert_eq!(root(RootChoice::Assisted(Some((5.0, 6.0)))), given);
    let RootMode::Assisted { force_n, .. } = root(RootChoice::Fidelity(1.0)) else { panic!("not assisted") };
    assert!((force_n - weight).abs() < 1e-9);
    assert_eq!(with(Overrides::default()), plain);

    assert_eq!(span("2.5..7"), Ok((2.5, 7.0)));
    for bad in ["", "7..2", "1..1", "a..b", "-1..2", "1"] {
        assert!(span(bad).expect_err(bad).contains("FROM..TO in seconds"), "{bad}");
    }
}
