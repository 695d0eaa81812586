//! `inspect`.

use std::io::Read;
use std::process::{Command, Stdio};

use crate::place::Place;

fn json(place: &Place, path: &str) -> serde_json::Value {
    let done = place.run(&["inspect", path, "--json"]);
    assert_eq!((done.code, done.stderr.as_str()), (0, ""));
    serde_json::from_str(&done.stdout).unwrap()
}

#[test]
fn a_scene() {
    let place = Place::new();
    let scene = place.scene("", "");
    let scene = scene.to_str().unwrap();
    let done = place.run(&["inspect", scene]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    for word in [
        "bow from 0.00 s",
        "bow_0_0_elbow_r",
        "EaseInOut",
        "end by amplitude (edit 1) ",
        ", then amplitude (edit 2) ",
        "changed by amplitude (edit 1), then amplitude (edit 2)",
        "knee_l",
    ] {
        assert!(done.stdout.contains(word), "`{word}` is not in\n{}", done.stdout);
    }
    let v = json(&place, scene);
    assert_eq!(v["kind"], "scene");
    assert_eq!(v["elements"].as_array().unwrap().len(), 2);
    assert_eq!(v["conflicts"][0]["edits"].as_array().unwrap().len(), 2);
    assert_eq!(v["edits"], serde_json::json!(["succession", "amplitude", "amplitude"]));
}

#[test]
fn a_character() {
    let place = Place::new();
    let human = support::scene("characters/human.ron").canonicalize().unwrap();
    let v = json(&place, human.to_str().unwrap());
    assert_eq!(v["kind"], "character");
    let links = v["links"].as_array().unwrap();
    let masses: f64 = links.iter().map(|l| l["mass_kg"].as_f64().unwrap()).sum();
    assert!((masses - v["mass_kg"].as_f64().unwrap()).abs() < 1e-9);
    let dof: u64 = links.iter().map(|l| l["dof"].as_u64().unwrap()).sum();
    assert_eq!(Some(dof), v["dof"].as_u64());
    let elbow = links.iter().find(|l| l["name"] == "elbow_r").unwrap();
    assert_eq!(elbow["limits_deg"]["hinge"].as_array().unwrap().len(), 2);
    assert!((v["height_m"].as_f64().unwrap() - 1.75).abs() < 0.02); // 1.746 seen
}

#[test]
fn a_clip() {
    let place = Place::new();
    let clip = place.clip("", "");
    let v = json(&place, clip.to_str().unwrap());
    assert_eq!(v["kind"], "clip");
    assert_eq!((&v["units"], &v["up"], &v["rate_hz"]), (&"guessed".into(), &"Y".into(), &30.0.into()));
    assert!(v["body"]["mass_kg"].as_f64().unwrap() > 40.0);
    let done = place.run(&["inspect", clip.to_str().unwrap(), "--write-body", "body.ron"]);
    assert!(done.stdout.contains("body written to body.ron"), "{}", done.stdout);
    assert_eq!(json(&place, "body.ron")["kind"], "character");
}

/// `inspect … | head -1`: a reader that leaves early is no failure and no panic.
#[test]
fn a_reader_that_leaves() {
    let human = support::scene("characters/human.ron");
    let mut child = Command::new(env!("CARGO_BIN_EXE_contrapposto"))
        .args(["inspect", "--json"])
        .arg(human)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert_eq!((child.wait().unwrap().code(), said.as_str()), (Some(0), ""));
}

/// Every command explains itself, with examples.
#[test]
fn help() {
    let place = Place::new();
    for command in ["render", "inspect", "plot", "analyze", "convert"] {
        let done = place.run(&[command, "--help"]);
        assert_eq!(done.code, 0);
        assert!(done.stdout.contains("Examples:") && done.stdout.contains("contrapposto"), "{}", done.stdout);
    }
    let version = place.run(&["--version"]);
    assert_eq!((version.code, version.stdout.starts_with("contrapposto 0.")), (0, true));
}

/// What clip edits change is in the log too, joint by joint.
#[test]
fn a_scene_with_a_pin() {
    let place = Place::new();
    let v = json(&place, support::scene("bow-gaze.ron").to_str().unwrap());
    assert_eq!(v["edits"], serde_json::json!(["succession", "pin"]));
    let log: Vec<&str> = v["log"].as_array().unwrap().iter().filter_map(|l| l.as_str()).collect();
    for word in [
        "pin (edit 1): gaze held from 0.800 s to 3.800 s",
        "pin (edit 1): at most pelvis ",
        ": start by succession (edit 0) +",
    ] {
        assert!(log.iter().any(|l| l.contains(word)), "`{word}` is not in\n{}", log.join("\n"));
    }
}
