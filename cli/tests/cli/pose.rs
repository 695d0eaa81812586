//! `pose`.

use crate::place::Place;

/// A real clip: the joints of CMU's files.
fn walk() -> String {
    support::shared("mocap/bvh/16_35.bvh").to_str().unwrap().to_owned()
}

/// The folder of results holds the clip, the report and the strip; what the report says is so in the clip.
#[test]
fn a_hand_is_dragged_and_feet_are_pinned() {
    let place = Place::new();
    let words = [
        "pose",
        &walk(),
        "--frame",
        "60",
        "--drag",
        "RightHand=-0.45,1.75,0",
        "--pin",
        "LeftFoot,RightFoot",
        "-o",
        "out",
    ];
    let done = place.run(&words);
    assert_eq!(done.code, 0, "{}", done.stderr);
    for word in [
        "dragged RightHand: from (",
        "to (-0.450, 1.750, 0.000) m",
        "pinned  LeftFoot",
        "RightForeArm",
        "wrote out",
    ] {
        assert!(done.stdout.contains(word), "`{word}` is not in\n{}", done.stdout);
    }
    for file in
        ["pose.bvh", "report.json", "plots/strip_pose.png", "plots/strip_pose.svg", ".contrapposto.json"]
    {
        assert!(place.at("out").join(file).is_file(), "{file}");
    }
    let report: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(place.at("out/report.json")).unwrap()).unwrap();
    assert!(report["bone_residue_m"].as_f64().unwrap() < 1e-9, "{report}");
    assert!(report["pin_residue_m"].as_f64().unwrap() < 1e-6, "{report}");
    assert_eq!(report["handles"][0]["reached"], true);
    // the hand of the clip that was written is there: asked again, nothing moves
    let words = [
        "pose",
        "out/pose.bvh",
        "--frame",
        "60",
        "--drag",
        "RightHand=-0.45,1.75,0",
        "--json",
        "-o",
        "again.bvh",
    ];
    let done = place.run(&words);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let report: serde_json::Value = serde_json::from_str(&done.stdout).unwrap();
    let from: Vec<f64> =
        report["handles"][0]["from_m"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    let off = [(from[0] + 0.45), (from[1] - 1.75), from[2]].iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!(off < 2e-3, "{from:?}");
    let again = place.run(&words);
    assert_eq!(again.code, 2, "an existing clip is kept");
    assert!(again.stderr.contains("again.bvh"), "{}", again.stderr);
}

/// What is out of reach is said, with what is left; a pose is dragged in time; a scene has limits.
#[test]
fn out_of_reach_in_time_and_within_limits() {
    let place = Place::new();
    let done = place.run(&[
        "pose",
        &walk(),
        "--at",
        "0.5",
        "--drag",
        "LeftHand=0.5,3,0.5",
        "--pin",
        "LeftFoot,RightFoot",
        "--no-plots",
        "-o",
        "far",
    ]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(done.stdout.contains("out of reach: LeftHand by 1"), "{}", done.stdout);
    let done =
        place.run(&["pose", &walk(), "--at", "0.5", "--to-s", "0.6", "--blend-s", "0.3", "-o", "late.bvh"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(
        done.stdout.contains("the pose at 0.5 s comes at 0.6 s") && done.stdout.contains("slopes"),
        "{}",
        done.stdout
    );
    let scene = place.scene("", "");
    let scene = scene.to_str().unwrap();
    let done = place.run(&[
        "pose",
        scene,
        "--at",
        "0.5",
        "--drag",
        "wrist_r=-0.4,1.2,0.3",
        "--limits",
        "--block",
        "0.3,0.6",
        "-o",
        "bow.glb",
    ]);
    assert_eq!(done.code, 0, "{}", done.stderr);
}

/// What is wrong is said, with the nearest name, and nothing is written.
#[test]
fn bad_requests() {
    let place = Place::new();
    let walk = walk();
    for (words, said) in [
        (
            &["--frame", "60", "--drag", "RightHnd=0,1,0"][..],
            "unknown joint `RightHnd`; did you mean `RightHand`?",
        ),
        (&["--frame", "60", "--drag", "RightHand=0,nan,0"], "`nan` is not finite"),
        (&["--frame", "60", "--drag", "RightHand=0,1"], "2 numbers; a place is X,Y,Z in metres, Y up"),
        (
            &["--frame", "162", "--drag", "RightHand=0,1,0"],
            "frame 162 is not in the clip; it has frames 0 to 161",
        ),
        (&["--at", "9", "--drag", "RightHand=0,1,0"], "9 s is not in the clip; it lasts from 0 s to 1.34"),
        (
            &["--frame", "60", "--drag", "RightHand=0,1,0", "--pin", "RightHand"],
            "`RightHand` is to be at two places",
        ),
        (
            &["--frame", "60"],
            "nothing is dragged; name a joint and where it goes, as x, y, z in m, world, Y up",
        ),
        (&["--drag", "RightHand=0,1,0"], "--frame"),
        (&["--frame", "60", "--drag", "RightHand=0,1,0", "--limits"], "no joint of this body has limits"),
        (&["--frame", "60", "--drag", "RightHand=0,1,0", "--weight", "Spine=-1"], "-1 is below 0"),
        (&["--frame", "60", "--drag", "RightHand=0,1,0", "--group", "Head"], "`Head` is a piece alone"),
        (&["--frame", "60", "--drag", "RightHand=0,1,0", "--block", "1,0.5"], "1 s is after 0.5 s"),
        (&["--frame", "60", "--drag", "RightHand=0,1,0", "-o", "x.xml"], "holds no motion that is written"),
    ] {
        let mut all = vec!["pose", &walk];
        all.extend(words);
        let done = place.run(&all);
        assert_eq!(done.code, 2, "{words:?}: {}{}", done.stdout, done.stderr);
        assert!(done.stderr.contains(said), "{words:?}: `{said}` is not in\n{}", done.stderr);
        assert!(!place.at("out").exists() && !place.at("x.xml").exists());
    }
}
