//! `convert`.

use crate::place::Place;

#[test]
fn a_clip_to_bvh_and_glb() {
    let place = Place::new();
    let clip = place.clip("", "");
    let clip = clip.to_str().unwrap();
    let done = place.run(&["convert", clip, "slow.bvh", "--rate", "15", "--out-units", "1"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    for word in ["units: 0.01 m (guessed", "up: Y", "rate: 30 Hz", "wrote slow.bvh", "units of 1 m"] {
        assert!(done.stdout.contains(word), "`{word}` is not in\n{}", done.stdout);
    }
    let text = std::fs::read_to_string(place.at("slow.bvh")).unwrap();
    assert!(text.contains("Frame Time: 0.0666666"), "{text:.2000}");
    let done = place.run(&["convert", "slow.bvh", "slow.glb"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(done.stdout.contains("units: 1 m (guessed"), "{}", done.stdout);
    let glb = gltf::Gltf::open(place.at("slow.glb")).unwrap();
    assert_eq!(glb.meshes().count(), 1);
    assert_eq!(glb.animations().count(), 1);
}

/// A scene's kinematic motion, with its body.
#[test]
fn a_scene_to_glb() {
    let place = Place::new();
    let scene = place.scene("", "");
    let done = place.run(&["convert", scene.to_str().unwrap(), "bow.glb"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let glb = gltf::Gltf::open(place.at("bow.glb")).unwrap();
    assert!(glb.nodes().any(|n| n.name() == Some("elbow_r")));
}

/// A file that cannot be written is a failed run; an earlier one stays.
#[test]
fn a_closed_folder() {
    let place = Place::new();
    let clip = place.clip("", "");
    let done = place.run(&["convert", clip.to_str().unwrap(), "missing/folder/x.bvh"]);
    assert_eq!(done.code, 1);
    assert!(done.stderr.contains("cannot write missing/folder/x.bvh"), "{}", done.stderr);
}

/// Every guess of a clip gives way to an option: rate, T-pose, offsets, glitches, units, up.
#[test]
fn options_overrule_what_is_guessed() {
    let place = Place::new();
    let lying = support::shared("cases/clips/lying.bvh");
    let lying = lying.to_str().unwrap();
    let convert = |options: &[&str]| {
        let mut words = vec!["convert", lying, "out.bvh", "--force"];
        words.extend(options);
        let done = place.run(&words);
        assert_eq!(done.code, 0, "{}", done.stderr);
        (done.stdout, std::fs::read_to_string(place.at("out.bvh")).unwrap())
    };
    let (said, text) = convert(&["--fps", "50", "--units", "0.02", "--up", "z"]);
    assert!(text.contains("Frame Time: 0.02\n"), "{text:.2000}");
    for word in ["rate: 50 Hz (stated", "units: 0.02 m (stated", "up: Z (stated)"] {
        assert!(said.contains(word), "`{word}` is not in\n{said}");
    }
    let (said, text) = convert(&["--drop-t-pose", "--repair", "--offsets", "Hold"]);
    assert!(text.contains("Frames: 59\n") && said.contains("dropped as stated"), "{said}");
    let (said, _) = convert(&[]);
    assert!(said.contains("up: Y (unsure"), "{said}");
    let refused = place.run(&["convert", lying, "x.bvh", "--offsets", "hald"]);
    assert_eq!(refused.code, 2);
    assert!(refused.stderr.contains("hold"), "{}", refused.stderr);
    let refused = place.run(&["convert", lying, "x.bvh", "--drop-t-pose", "--keep-t-pose"]);
    assert_eq!(refused.code, 2);
}

/// What another rate wrote is that rate when it is read again, also below ten frames a second.
#[test]
fn low_rates_come_back() {
    let place = Place::new();
    let lying = support::shared("cases/clips/lying.bvh");
    for hz in ["5", "1", "0.5"] {
        let done = place.run(&["convert", lying.to_str().unwrap(), "slow.bvh", "--rate", hz, "--force"]);
        if hz == "0.5" {
            assert_eq!(done.code, 2); // below what is written
            continue;
        }
        let back = place.run(&["inspect", "slow.bvh"]);
        assert!(back.stdout.contains(&format!("rate: {hz} Hz")), "{}", back.stdout);
    }
}

/// A clip with an edit in the words of a scene; faults are told at their place, and nothing is written then.
#[test]
fn a_clip_is_edited() {
    let place = Place::new();
    let walk = support::shared("mocap/bvh/16_35.bvh");
    let walk = walk.to_str().unwrap();
    let done =
        place.run(&["convert", walk, "calm.bvh", "--edit", "Amplitude(factor: 0.5, parts: [\"arm_r\"])"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    for words in ["amplitude (edit 0)", "keys per second and joint", "wrote calm.bvh"] {
        assert!(done.stdout.contains(words), "`{words}` is not in\n{}", done.stdout);
    }
    for (input, output, edit, words) in [
        (walk, "other.bvh", "Amplitude(fctor: 0.5)", "--edit:1:11"),
        (walk, "other.xml", "Amplitude(factor: 0.5)", "--edit is for motion"),
        ("bow", "other.bvh", "Amplitude(factor: 0.5)", "--edit is for clips"),
    ] {
        let done = place.run(&["convert", input, output, "--edit", edit]);
        assert_eq!(done.code, 2, "{}", done.stderr);
        assert!(done.stderr.contains(words) && !place.at(output).exists(), "{words}: {}", done.stderr);
    }
    let done = place.run(&["render", "bow", "--kinematic", "--edit", "Amplitude(factor: 0.5)"]);
    assert!(done.code == 2 && done.stderr.contains("--edit is for clips"), "{}", done.stderr);
}

/// The key poses of a clip as a scene that renders; what is there already is not replaced.
#[test]
fn a_clip_is_blocked() {
    let place = Place::new();
    let walk = support::shared("mocap/bvh/16_35.bvh");
    let convert = ["convert", walk.to_str().unwrap(), "run.ron", "--blocking"];
    let done = place.run(&convert);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(done.stdout.contains("key poses in 1.34 s"), "{}", done.stdout);
    let text = std::fs::read_to_string(place.at("run.ron")).unwrap();
    assert!(text.contains("character: \"run-character.ron\"") && text.contains("set_deg"), "{text}");
    let again = place.run(&convert);
    assert!(again.code == 2 && again.stderr.contains("exists"), "{}", again.stderr);
    let done = place.run(&["render", "run.ron", "--kinematic", "--no-plots"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let done = place.run(&["convert", "run.ron", "again.ron", "--blocking"]);
    assert!(done.code == 2 && done.stderr.contains("--blocking is for clips"), "{}", done.stderr);
}
