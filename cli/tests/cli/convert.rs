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
