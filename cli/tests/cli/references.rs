//! Files that name each other in a circle: exit code 2, the circle named. Each was a stack overflow.

use std::path::Path;

use crate::place::Place;

/// A place with the library, so that the scenes of `cases` find what they refer to.
fn place(files: &[(&str, String)]) -> Place {
    let place = Place::new();
    for folder in ["characters", "keyposes", "performances"] {
        for path in support::files(&support::scene(folder), "ron") {
            let name = format!("{folder}/{}", path.file_name().unwrap().to_str().unwrap());
            place.write(&name, &std::fs::read_to_string(path).unwrap());
        }
    }
    files.iter().for_each(|(name, text)| drop(place.write(name, text)));
    place
}

fn case(name: &str) -> (&str, String) {
    (name, std::fs::read_to_string(support::shared(&format!("cases/scenes/{name}"))).unwrap())
}

#[track_caller]
fn circle(place: &Place, args: &[&str], chain: &[&str]) {
    let done = place.run(args);
    assert_eq!((done.code, done.stdout.as_str()), (2, ""), "{args:?}: {}", done.stderr);
    let file = chain[0];
    assert!(done.stderr.contains(&format!("{file}` refers to itself: ")), "{args:?}: {}", done.stderr);
    let named = done.stderr.split("refers to itself: ").nth(1).unwrap().lines().next().unwrap();
    let names: Vec<&str> =
        named.split(" → ").map(|p| Path::new(p).file_name().unwrap().to_str().unwrap()).collect();
    assert_eq!(names, chain, "{}", done.stderr);
    // the place is that of a reference
    assert!(done.stderr.contains(" --> "), "{}", done.stderr);
}

#[test]
fn scenes_that_name_each_other_are_refused() {
    let place = place(&[case("selfm.ron"), case("a2.ron"), case("b2.ron")]);
    for command in ["render", "analyze", "plot"] {
        circle(&place, &[command, "selfm.ron"], &["selfm.ron", "selfm.ron"]);
    }
    circle(&place, &["render", "a2.ron"], &["a2.ron", "b2.ron", "a2.ron"]);
    circle(&place, &["convert", "b2.ron", "x.bvh"], &["b2.ron", "a2.ron", "b2.ron"]);
    circle(&place, &["retarget", "a2.ron", "--to", "characters/lamp.ron"], &["a2.ron", "b2.ron", "a2.ron"]);
    // under another name it is the same file
    let text = case("selfm.ron").1.replace("selfm.ron", "../scenes/./selfm.ron");
    place.write(
        "scenes/selfm.ron",
        &text.replace("characters/", "../characters/").replace("keyposes/", "../keyposes/"),
    );
    let done = place.run(&["render", "scenes/selfm.ron"]);
    assert!(done.code == 2 && done.stderr.contains("refers to itself"), "{}", done.stderr);
}

/// Key poses whose performance is made with them; and the same from the command line.
#[test]
fn key_poses_that_name_a_motion_made_of_them_are_refused() {
    let poses: Vec<String> =
        (1..4).map(|i| format!("Pose(of: \"me\", at_s: 0.{i}, set_deg: {{}})")).collect();
    let poses = format!("KeyPoses(performances: {{\"me\": \"s.ron\"}}, poses: [{}])", poses.join(", "));
    let scene = "Scene(character: \"characters/lamp.ron\", root: Pinned,\n    motion: Retarget(of: \"performances/anger.ron\", keyposes: \"k.ron\"))";
    let place = place(&[("k.ron", poses), ("s.ron", scene.into())]);
    circle(&place, &["render", "s.ron"], &["s.ron", "k.ron", "s.ron"]);
    let retarget =
        ["retarget", "performances/anger.ron", "--to", "characters/lamp.ron", "--keyposes", "k.ron"];
    circle(&place, &retarget, &["k.ron", "s.ron", "k.ron"]);
}

/// A chain that ends is no circle, but has a longest length: every file of it is performed for the next.
#[test]
fn long_chains_are_refused_and_none_overflows() {
    let files: Vec<(String, String)> = (0..40)
        .map(|i| {
            let text = format!(
                "Scene(character: \"characters/lamp.ron\", motion: Retarget(of: \"{}.ron\"), root: Pinned)",
                i + 1
            );
            (format!("{i}.ron"), text)
        })
        .collect();
    let files: Vec<(&str, String)> = files.iter().map(|(name, text)| (name.as_str(), text.clone())).collect();
    let place = place(&files);
    let done = place.run(&["render", "0.ron"]);
    assert_eq!(done.code, 2, "{}", done.stderr);
    assert!(done.stderr.contains("allowed: up to 16 files in a row"), "{}", done.stderr);
}
