//! Bad input: exit code 2, one block that says what was found, what is allowed and where; earlier
//! output stays as it was.

use std::path::Path;

use crate::place::{Place, human};

/// Renders and expects a refusal with these words.
#[track_caller]
fn refused(place: &Place, input: &Path, options: &[&str], words: &[&str]) {
    place.refused(&[&["render", input.to_str().unwrap()], options].concat(), words);
}

#[track_caller]
fn bad_scene(from: &str, to: &str, words: &[&str]) {
    let place = Place::new();
    let scene = place.scene(from, to);
    refused(&place, &scene, &[], words);
}

#[track_caller]
fn bad_character(from: &str, to: &str, words: &[&str]) {
    let place = Place::new();
    let scene = place.scene_with_character(from, to);
    refused(&place, &scene, &[], words);
}

#[track_caller]
fn bad_clip(from: &str, to: &str, words: &[&str]) {
    let place = Place::new();
    let clip = place.clip(from, to);
    refused(&place, &clip, &[], words);
}

#[test]
fn files_that_are_not_there() {
    let place = Place::new();
    for name in ["missing.ron", "missing.bvh"] {
        refused(&place, Path::new(name), &[], &["cannot read", name]);
    }
    bad_scene(
        "characters/human.ron",
        "characters/nobody.ron",
        &["nobody.ron", "does not exist", "scene.ron:2:"],
    );
    let clip = place.clip("", "");
    refused(&place, &clip, &["--body", "nobody.ron"], &["cannot read", "nobody.ron"]);
}

#[test]
fn files_of_another_kind() {
    let place = Place::new();
    let path = place.write("walk.fbx", "Kaydara");
    refused(&place, &path, &[], &["walk.fbx", ".ron", ".bvh"]);
    let path = place.write("bvh.ron", "HIERARCHY\nROOT Hips\n");
    refused(&place, &path, &[], &["Scene", "bvh.ron:1:1"]);
    let path = place.write("ron.bvh", "Scene()");
    refused(&place, &path, &[], &["HIERARCHY", "ron.bvh:1:1"]);
    let path = place.at("folder.bvh");
    std::fs::create_dir(&path).unwrap();
    refused(&place, &path, &[], &["folder.bvh"]);
}

#[test]
fn a_joint_that_does_not_exist_is_met_with_the_nearest_name() {
    let words = ["unknown joint `elbw_r`", "did you mean `elbow_r`?", "scene.ron:8:17"];
    bad_scene("\"elbow_r\": 20", "\"elbw_r\": 20", &words);
    bad_scene("parts: [\"elbow_r\"]", "parts: [\"elbw_r\"]", &["elbw_r", "elbow_r", "scene.ron:14:"]);
    bad_scene("Amplitude(on: \"bow\"", "Amplitude(on: \"bwo\"", &["bwo", "bow", "scene.ron:14:"]);
}

#[test]
fn unknown_fields_and_wrong_types() {
    bad_scene(
        "rate_hz: 60",
        "rate: 60",
        &["unknown field `rate` of `Scene`; did you mean `rate_hz`?", "scene.ron:3:"],
    );
    bad_scene("rate_hz: 60", "rate_hz: \"fast\"", &["Expected float", "`\"fast\"`", "scene.ron:3:14"]);
    bad_scene(
        "Succession(",
        "Sucession(",
        &["unknown word `Sucession` of", "did you mean `Succession`?", "scene.ron:13:"],
    );
    bad_scene(
        "offset_s: 0.05",
        "ofset_s: 0.05",
        &["unknown field `ofset_s` of `Succession`; did you mean `offset_s`?"],
    );
    bad_scene(
        "hold_s: 0.1",
        "holds: 0.1",
        &["unknown field `holds` of `Pose`; did you mean `hold_s`?", "scene.ron:6:"],
    );
    bad_scene("root: Free", "root: Loose", &["`Loose`", "`Free`", "scene.ron:17:"]);
    bad_scene("\"elbow_r\": 20", "\"elbow_r\": (1, 2, 3)", &["elbow_r", "scene.ron:8:"]);
}

/// Names that a file we write could not hold; the terminal sees no control characters.
#[test]
fn names_that_cannot_be_written() {
    for (name, words) in [
        ("", "a name is empty"),
        ("bow\\u{0}", "`bow\\u{0}` has a control character"),
        ("two\\nlines", "`two\\nlines` has a control character"),
        (" bow", "begins or ends with a blank"),
        (&"x".repeat(5000), "has 5000 characters; allowed: 1 to 128"),
    ] {
        bad_scene("name: \"bow\"", &format!("name: \"{name}\""), &[words, "scene.ron:5:"]);
        bad_character("name: \"chest\"", &format!("name: \"{name}\""), &[words, "characters/human.ron:"]);
    }
}

/// An edit of two places of which one has none of its parts: that place, and what it moves.
#[test]
fn a_place_without_the_parts_is_named() {
    bad_scene(
        "Amplitude(on: \"bow\", parts: [\"elbow_r\"], factor: 1.1)",
        "Tension(on: \"bow\", parts: [\"ankle_l\"], factor: 2)",
        &["`bow` has no element of `ankle_l`; it moves `chest`, `elbow_r`", "scene.ron:15:"],
    );
}

/// What a scene says of a script beside a motion of its own is refused whole.
#[test]
fn words_of_a_script_beside_a_motion() {
    let place = Place::new();
    let text = std::fs::read_to_string(support::shared("cases/scenes/mdrop.ron")).unwrap();
    let text = text
        .replace("characters/lamp.ron", "library:characters/lamp.ron")
        .replace("performances/", "library:performances/");
    let scene = place.write("mdrop.ron", &text);
    refused(&place, &scene, &[], &["`planted`, `settle_s`, `properties` are of a script", "mdrop.ron:2:"]);
    let text = text.replace("settle_s: 50, properties: (tension: 9), planted: [],", "");
    let scene = place.write("mdrop.ron", &text);
    refused(&place, &scene, &[], &["begins at 9999 s", "before the motion ends, at 13.939 s"]);
}

/// A scene that begins with a byte order mark.
#[test]
fn a_byte_order_mark_is_no_fault() {
    let place = Place::new();
    let text = std::fs::read_to_string(support::shared("cases/scenes/bom.ron")).unwrap();
    assert!(text.starts_with('\u{feff}'));
    let scene = place.write("bom.ron", &text.replace("characters/", "library:characters/"));
    let done = place.run(&["inspect", scene.to_str().unwrap()]);
    assert_eq!(done.code, 0, "{}", done.stderr);
}

#[test]
fn numbers_out_of_range() {
    bad_scene(
        "duration_s: 0.3",
        "duration_s: -0.3",
        &["duration_s is -0.3 s", "allowed: 0 to", "scene.ron:6:30"],
    );
    bad_scene("hold_s: 0.1", "hold_s: NaN", &["hold_s is NaN", "allowed", "scene.ron:6:"]);
    bad_scene("\"elbow_r\": 20", "\"elbow_r\": NaN", &["NaN", "allowed", "scene.ron:8:"]);
    bad_scene("(12, 0, 0)", "(12, inf, 0)", &["inf", "allowed", "scene.ron:7:"]);
    bad_scene("offset_s: 0.05", "offset_s: -1", &["offset_s is -1", "allowed", "scene.ron:13:"]);
    bad_scene("factor: 1.2", "factor: 0", &["factor is 0", "allowed", "scene.ron:14:"]);
    bad_scene("rate_hz: 60", "rate_hz: 0", &["rate_hz is 0 Hz", "allowed: 1 to 1000", "scene.ron:3:"]);
}

/// Disturbances that cannot be, or would never come, each at its place.
#[test]
fn disturbances_that_cannot_be() {
    let with = |field: &str, words: &[&str]| {
        let to = format!("settle_s: 0.2,\n    {field}");
        bad_scene("settle_s: 0.2", &to, words);
    };
    let push = |rest: &str| format!("pushes: [Push(link: \"chest\", {rest})]");
    for (field, words) in [
        (push("impulse_ns: 12, start_s: 0.1"), ["without a direction", "towards_deg"]),
        (
            push("impulse_ns: (0, 0, 9), towards_deg: 90, start_s: 0.1"),
            ["direction of its own", "one number"],
        ),
        (push("impulse_ns: -5, towards_deg: 90, start_s: 0.1"), ["impulse_ns is -5 N·s", "allowed: 0 to"]),
        (push("impulse_ns: (0, NaN, 0), start_s: 0.1"), ["impulse_ns is NaN", "allowed"]),
        (push("impulse_ns: (0, 1), start_s: 0.1"), ["(x, y, z)", "found 2 elements"]),
        (push("impulse_ns: 5, towards_deg: 0, start_s: 99"), ["begins at 99 s", "before the motion ends"]),
        (push("impulse_ns: 5, towards_deg: 0, start_s: 0, at_m: (0, 50, 0)"), ["at_m is 50 m", "-10 to 10"]),
        (push("impulse_ns: 5, towards_deg: 0, start_s: 0, body: 1"), ["`body`", "`link`"]),
    ] {
        with(&field, &[words[0], words[1], "scene.ron:"]);
    }
    let carried = |rest: &str| format!("carried: [Carried({rest})]");
    for (field, words) in [
        (carried("link: \"wrist\", mass_kg: 5"), ["unknown link `wrist`", "did you mean"]),
        (carried("link: \"wrist_r\", mass_kg: 0"), ["mass_kg is 0 kg", "allowed: 0.001 to 1000"]),
        (carried("link: \"wrist_r\", mass_kg: 5, size_m: (1, -1, 1)"), ["size_m is -1 m", "0 to 10"]),
        (
            carried("link: \"wrist_r\", mass_kg: 5, from_s: 0.3, to_s: 0.2"),
            ["to_s is 0.2 s", "later than from_s"],
        ),
        (carried("link: \"wrist_r\", mass_kg: 5, from_s: 99"), ["begins at 99 s", "settle_s"]),
        (carried("link: \"wrist_r\", mass_kg: 5, known: 1"), ["boolean", "found `1`"]),
    ] {
        with(&field, &[words[0], words[1]]);
    }
    let gaze = |rest: &str| format!("reactive: [Gaze(at_m: (0, 1, 3), {rest})]");
    for (field, words) in [
        (gaze("eyes: \"nose\""), ["no site `nose`", "sites: "]),
        (gaze("joints: [\"nek\"]"), ["unknown link `nek`", "did you mean `neck`"]),
        (gaze("joints: [\"elbow_l\"]"), ["`elbow_l`", "ball"]),
        (gaze("joints: [\"shoulder_l\"]"), ["`shoulder_l`", "does not carry site `eyes`"]),
        (gaze("joints: []"), ["no joints", "scene.ron:"]),
        (gaze("from_s: 2, to_s: 1"), ["to_s is 1 s", "later than from_s"]),
        (gaze("blend_s: -1"), ["blend_s is -1 s", "0 to 60"]),
    ] {
        with(&field, &[words[0], words[1]]);
    }
    for (tilt, words) in [
        ("tilt_deg: 45", ["tilt_deg is 45 °", "allowed: 0 to 30"]),
        ("tilt_deg: 5, towards_deg: 999", ["towards_deg is 999 °", "-360 to 360"]),
        ("friction: 0.2", ["`friction`", "duplicate"]),
        (
            "tilts: [Tilt(start_s: 0, duration_s: 0.1, tilt_deg: 50)]",
            ["tilt_deg is 50 °", "allowed: 0 to 30"],
        ),
        (
            "tilts: [Tilt(start_s: 0, duration_s: 0.1), Tilt(start_s: 0.05, duration_s: 1)]",
            ["begins at 0.05 s", "allowed: from 0.1 s on"],
        ),
        ("tilts: [Tilt(start_s: 99, duration_s: 1)]", ["begins at 99 s", "before the motion ends"]),
        ("tilts: [Tilt(start_s: 0)]", ["duration_s", "scene.ron:"]),
    ] {
        let to = format!("world: (ground: Plane(friction: 0.8, {tilt})), settle_s: 0.2");
        bad_scene("settle_s: 0.2", &to, &words);
    }
}

/// Counts that would fill the memory are refused before it is filled.
#[test]
fn slow_absurd_counts() {
    bad_scene("Cycle(", "Cycle(repetitions: 99999999, ", &["99999999 repetitions", "allowed: 1 to 10000"]);
    bad_scene("Cycle(", "Cycle(repetitions: -3, ", &["-3 repetitions", "allowed: 1 to 10000"]);
    bad_scene("Cycle(", "Cycle(repetitions: 1e30, ", &["scene.ron:5:"]);
    bad_scene("settle_s: 0.2", "settle_s: 3600", &["3600.", "240 Hz", "allowed: up to 2083 s"]);
    bad_scene("offset_s: 0.05", "offset_s: 1e300", &["1e300 s", "allowed"]);
    bad_scene("settle_s: 0.2", "settle_s: 0.2, strip: (figures: 100000)", &["100000 figures", "2 to 40"]);
    let place = Place::new();
    let scene = place.scene("settle_s: 0.2", "settle_s: 100");
    refused(&place, &scene, &["--rate", "20000"], &["20000 Hz", "allowed: up to 25 s"]);
}

#[test]
fn characters_that_cannot_be() {
    let place = "characters/human.ron:";
    bad_character(
        "limits_deg: Hinge(0, 150)",
        "limits_deg: Hinge(150, 0)",
        &["from 150° to 0°", "below", place],
    );
    let mass = human().split("mass_kg: ").nth(1).unwrap().split(',').next().unwrap().to_owned();
    for bad in ["0", "-1", "NaN"] {
        let words = ["`pelvis`", &format!("{bad} kg"), "positive", place];
        bad_character(&format!("mass_kg: {mass}"), &format!("mass_kg: {bad}"), &words);
    }
    bad_character("parent: \"pelvis\"", "parent: \"head\"", &["circle", "`head`", place]);
    bad_character("parent: \"pelvis\"", "parent: \"pelvs\"", &["`pelvs`", "did you mean `pelvis`?", place]);
    bad_character("joint: Free,", "joint: Free, rotation_deg: (0, 20, 0),", &["pelvis", "zero frame", place]);
}

#[test]
fn clips_that_cannot_be_read() {
    let place = Place::new();
    let whole = std::fs::read_to_string(place.clip("", "")).unwrap();
    let cut = place.write("cut.bvh", &whole[..whole.len() * 3 / 4]);
    refused(&place, &cut, &[], &["frames of", "the file ends after", "cut.bvh:"]);
    let cut = place.write("cut.bvh", &whole[..400]);
    refused(&place, &cut, &[], &["cut.bvh:"]);
    let empty = place.write("empty.bvh", "");
    refused(&place, &empty, &[], &["empty", "HIERARCHY", "empty.bvh:1:1"]);
    bad_clip("Frames: ", "Frames: 9999999999", &["values are stated", "clip.bvh:"]);
    bad_clip("Frames: ", "Frames: -", &["Frames: `-", "whole number", "clip.bvh:"]);
    bad_clip("Frame Time: 0", "Frame Time: -0", &["Frame Time", "expected", "clip.bvh:"]);
    bad_clip("OFFSET 0", "OFFSET NaN 0", &["NaN", "not a finite number", "clip.bvh:"]);
    bad_clip("CHANNELS 3", "CHANNELS 300", &["300", "0 to 6", "clip.bvh:"]);
}

/// A skeleton whose names say nothing has no body; the message says how to give one.
#[test]
fn a_clip_without_a_human() {
    let place = Place::new();
    let text = std::fs::read_to_string(place.clip("", "")).unwrap();
    let mut count = 0;
    let nameless: Vec<String> = text
        .lines()
        .map(|line| match line.trim_start().split_once(' ') {
            Some((word @ ("ROOT" | "JOINT"), _)) => {
                count += 1;
                format!("{word} thing_{count}")
            }
            _ => line.to_owned(),
        })
        .collect();
    let clip = place.write("lamp.bvh", &nameless.join("\n"));
    refused(&place, &clip, &[], &["lamp.bvh", "not a human-like skeleton", "--body"]);
    let body = support::scene("characters/human.ron");
    let two_axes = place.write("elbow.bvh", &elbow_about_two_axes(&text));
    let words =
        ["does not fit", "`elbow_l` is a ball in the clip and a hinge in the character", "turns 20.0° away"];
    refused(&place, &two_axes, &["--body", body.to_str().unwrap()], &words);
}

/// A clip of the human, in BVH, whose left elbow turns 20° about another axis than its hinge's in the last frame.
fn elbow_about_two_axes(text: &str) -> String {
    let count = |line: &str| -> usize {
        let mut words = line.split_whitespace();
        if words.next() == Some("CHANNELS") { words.next().unwrap().parse().unwrap() } else { 0 }
    };
    let before = text.lines().take_while(|line| !line.contains("JOINT elbow_l"));
    let column: usize = before.map(count).sum();
    let (frames, last) = text.trim_end().rsplit_once('\n').unwrap();
    let mut values: Vec<&str> = last.split_whitespace().collect();
    values[column] = "20"; // Zrotation; the hinge turns about Y
    format!("{frames}\n{}\n", values.join(" "))
}

#[test]
fn arguments_out_of_range() {
    let place = Place::new();
    let scene = place.scene("", "");
    let cases: [(&[&str], &[&str]); 17] = [
        (&["--root", "loose"], &["--root", "loose", "free, pinned, assisted"]),
        (&["--root", "assisted:80"], &["assisted:FORCE_N,MOMENT_NM"]),
        (&["--tension", "0"], &["--tension", "allowed: 0.001 to 1000"]),
        (&["--tension", "NaN"], &["--tension", "allowed"]),
        (&["--tension", "stiff"], &["stiff", "not a number"]),
        (&["--rate", "1"], &["--rate", "allowed: 30 to 20000 Hz"]),
        (&["--substeps", "0"], &["--substeps", "1 to 64"]),
        (&["--substeps", "-3"], &["--substeps", "1 to 64"]),
        (&["--units", "0"], &["--units", "allowed"]),
        (&["--up", "x"], &["--up", "y, z"]),
        (&["--units", "0.01"], &["--units is for clips"]),
        (&["--body", "characters/human.ron"], &["--body is for clips"]),
        (&["--fidelity", "1.5"], &["--fidelity", "allowed: 0 to 1"]),
        (&["--pareto", "0,2"], &["--pareto", "allowed: 0 to 1"]),
        (&["--fidelity", "0.5", "--root", "free"], &["--fidelity", "--root", "cannot be used with"]),
        (&["--span", "3..1"], &["--span", "FROM..TO in seconds"]),
        (&["--span", "1..3"], &["--span is for clips"]),
    ];
    for (options, words) in cases {
        refused(&place, &scene, options, words);
    }
    assert_eq!(place.run(&["perform"]).code, 2);
    assert_eq!(place.run(&[]).code, 2);
}

/// The other commands refuse bad input alike.
#[test]
fn inspect_and_convert_refuse_too() {
    let place = Place::new();
    let scene = place.scene("\"elbow_r\": 20", "\"elbw_r\": 20");
    let scene = scene.to_str().unwrap();
    for args in [vec!["inspect", scene], vec!["convert", scene, "x.bvh"], vec!["inspect", "missing.bvh"]] {
        let done = place.run(&args);
        assert_eq!(done.code, 2, "{args:?}");
        assert!(done.stdout.is_empty() && done.stderr.starts_with("error: "), "{}", done.stderr);
    }
    let clip = place.clip("", "");
    let clip = clip.to_str().unwrap();
    for (args, word) in [
        (vec!["convert", clip, "x.fbx"], "allowed: .bvh, .glb"),
        (vec!["convert", clip, "x.glb", "--out-units", "1"], "--out-units"),
        (vec!["convert", clip, "x.bvh", "--rate", "0"], "allowed: 1 to 1000 Hz"),
        (vec!["inspect", clip, "--units", "tall"], "not a number"),
    ] {
        let done = place.run(&args);
        assert_eq!(done.code, 2, "{args:?}");
        assert!(done.stderr.contains(word), "{}", done.stderr);
    }
    assert!(!place.at("x.bvh").exists() && !place.at("x.glb").exists() && !place.at("x.fbx").exists());
}
