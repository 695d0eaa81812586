//! `style`: the file of components, motions with style, and every fault of the input.

use crate::place::Place;

fn mocap(name: &str) -> String {
    let path = support::shared(&format!("mocap/bvh/{name}.bvh"));
    path.canonicalize().unwrap().display().to_string()
}

/// Components are written with their words and figures, and go into a motion that was not decomposed; the same command writes the
/// same bytes.
#[test]
fn slow_components_are_written_and_transferred() {
    let place = Place::new();
    let (walk, sneak, other) = (mocap("16_16"), mocap("17_03"), mocap("02_01"));
    let done = place.run(&["style", "decompose", &walk, &sneak, "--out", "set"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(
        done.stdout.contains("separates 1.00") && done.stdout.contains("headings are taken away"),
        "{}",
        done.stdout
    );
    let file = place.at("set/16_16-17_03.style");
    let bytes = std::fs::read(&file).unwrap();
    for plot in ["components", "principal", "activations"] {
        assert!(place.at(&format!("set/plots/{plot}.png")).is_file(), "{plot}");
    }
    assert_eq!(place.run(&["style", "decompose", &walk, &sneak, "--out", "set"]).code, 0);
    assert_eq!(std::fs::read(&file).unwrap(), bytes);
    let set = file.display().to_string();
    let args = [
        "style",
        "transfer",
        "--from",
        &set,
        "--to",
        &other,
        "--amount",
        "0.8",
        "--no-plots",
        "--out",
        "out",
    ];
    let done = place.run(&args);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(
        done.stdout.contains("is brought onto the bones of 16_16") && done.stdout.contains("aligned on"),
        "{}",
        done.stdout
    );
    assert!(place.at("out/kinematic.bvh").is_file());
    let done = place.run(&["style", "try", &other, &set, "--out", "tried"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let done =
        place.run(&["style", "blend", "--from", &set, "--to", &walk, "--amounts", "0,1", "--out", "blend"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(place.at("blend/continuum-1.bvh").is_file() && place.at("blend/plots/continuum.png").is_file());
}

/// Times that belong together are given by a person; what has to run much faster than it did, and a warp that is extreme, are said.
#[test]
fn gestures_are_aligned_by_anchors() {
    let place = Place::new();
    let (walk, sneak) = (mocap("16_16"), mocap("17_03"));
    let run = |anchors: &[&str]| {
        let mut args =
            vec!["style", "transfer", "--from", &sneak, "--to", &walk, "--no-plots", "--out", "out"];
        anchors.iter().for_each(|a| args.extend(["--anchor", a]));
        place.run(&args)
    };
    let done = run(&["0=0", "4=3.6"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(done.stdout.contains("aligned on 2 anchors"), "{}", done.stdout);
    assert!(!done.stdout.contains("stiff") && !done.stdout.contains("extreme"), "{}", done.stdout);
    let done = run(&["0=0", "1=0.4", "2=3.2", "4=3.6"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(done.stdout.contains("the warp is extreme"), "{}", done.stdout);
    let done = run(&["0=0", "4.2=7.5"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(done.stdout.contains("what was easy becomes stiff"), "{}", done.stdout);
    for wrong in [&["0=0"][..], &["1=0", "0.5=2"], &["0=2", "1=1"]] {
        let done = run(wrong);
        assert_eq!(done.code, 2, "{wrong:?}: {}", done.stdout);
    }
}

/// Faults are named and leave with code 2.
#[test]
fn style_refuses_what_it_cannot_do() {
    let place = Place::new();
    let (walk, sneak) = (mocap("16_16"), mocap("17_03"));
    let none = place.write("none.style", "no zip").display().to_string();
    for (args, why) in [
        (vec!["transfer", "--from", &sneak, "--to", &walk, "--amount", "2"], "0 to 1.5"),
        (
            vec!["transfer", "--from", &sneak, "--to", &walk, "--components", "9"],
            "there is no component 9; allowed: 1 to",
        ),
        (vec!["transfer", "--from", &none, "--to", &walk], "not an .npz"),
        (
            vec!["transfer", "--from", &sneak, "--to", &walk, "--align", "LeftUpLge"],
            "did you mean `LeftUpLeg`?",
        ),
        (vec!["decompose", &walk, &sneak, "--merge", "7"], "there is no component 7"),
        (vec!["decompose", &walk, "nothing.bvh"], "nothing.bvh"),
    ] {
        let mut all = vec!["style"];
        all.extend(args);
        let done = place.run(&all);
        assert_eq!(done.code, 2, "{all:?}: {}", done.stdout);
        assert!(done.stderr.contains(why), "{all:?}: {}", done.stderr);
    }
}

/// Without styles all that ship are tried; named ones go as files do; an unknown name is no file.
#[test]
fn styles_that_ship_are_tried_on_a_walk() {
    let place = Place::new();
    let walk = support::scene("performances/walk.ron").canonicalize().unwrap().display().to_string();
    let done = place.run(&["style", "try", &walk, "--out", "all"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    // the walk itself, and five styles
    assert!(place.at("all/styles-5.bvh").is_file() && !place.at("all/styles-6.bvh").exists());
    let strip = std::fs::read_to_string(place.at("all/plots/styles.svg")).unwrap();
    for name in ["tired", "proud", "sneaky", "limping", "childish"] {
        assert!(strip.contains(name), "{name}");
    }
    let done =
        place.run(&["style", "transfer", "--from", "tired", "--to", &walk, "--no-plots", "--out", "one"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(done.stdout.contains("of walk-tired by 1"), "{}", done.stdout);
    let done = place.run(&["style", "try", &walk, "tyred"]);
    assert_eq!(done.code, 2, "{}", done.stdout);
    assert!(done.stderr.contains("tyred"), "{}", done.stderr);
}
