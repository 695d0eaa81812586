//! Output never replaces or deletes what a run read, or what no run wrote.

use crate::place::Place;

/// Runs and expects a refusal with these words, exit code 2, and all files as they were.
#[track_caller]
fn refused(place: &Place, args: &[&str], words: &[&str]) {
    let before = place.files("");
    let done = place.run(args);
    assert_eq!((done.code, done.stdout.as_str()), (2, ""), "{args:?}: {}", done.stderr);
    for word in words {
        assert!(done.stderr.contains(word), "`{word}` is not in\n{}", done.stderr);
    }
    assert!(place.files("") == before, "{args:?}: files changed");
}

/// A clip that has the name of a result of an earlier kind lies in the output folder: it stays.
#[test]
fn a_clip_rendered_into_its_own_folder_stays() {
    let place = Place::new();
    let clip = place.clip("", "");
    std::fs::create_dir(place.at("d")).unwrap();
    std::fs::rename(clip, place.at("d/dynamic.bvh")).unwrap();
    let before = std::fs::read(place.at("d/dynamic.bvh")).unwrap();
    let done = place.run(&["render", "d/dynamic.bvh", "--kinematic", "--no-plots", "--out", "d"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert_eq!(
        place.names("d"),
        ["contacts.ron", "dynamic.bvh", "kinematic.bvh", "kinematic.glb", "report.json"]
    );
    assert!(std::fs::read(place.at("d/dynamic.bvh")).unwrap() == before);
    // performed, it would be replaced by its own performance
    refused(
        &place,
        &["render", "d/dynamic.bvh", "--no-plots", "--out", "d"],
        &["d/dynamic.bvh", "would be replaced", "input of this run"],
    );
}

/// Files of somebody else, and results that somebody changed, stand in the way of results of the same name only.
#[test]
fn files_of_others_are_not_replaced() {
    let place = Place::new();
    let scene = place.scene("", "");
    let render = ["render", scene.to_str().unwrap(), "--kinematic", "--no-plots", "--out", "out"];
    place.write("out/kinematic.bvh", "mine");
    refused(&place, &render, &["kinematic.bvh", "was not written by an earlier run", "--out"]);
    std::fs::remove_file(place.at("out/kinematic.bvh")).unwrap();
    place.write("out/walk.bvh", "mine");
    assert_eq!(place.run(&render).code, 0);
    assert_eq!(place.run(&render).code, 0, "its own results are replaced");
    assert_eq!(std::fs::read_to_string(place.at("out/walk.bvh")).unwrap(), "mine");
    place.write("out/report.json", "changed by hand");
    refused(&place, &render, &["report.json", "changed", "--out"]);
}

/// `convert`, `inspect --write-body` and `plot --out FILE` write one file: a new one, or one that may go.
#[test]
fn one_file_needs_leave_to_replace_another() {
    let place = Place::new();
    let clip = place.clip("", "");
    let clip = clip.to_str().unwrap();
    let done = place.run(&["render", clip, "--no-plots", "--out", "run"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let commands: [(&[&str], &str); 3] = [
        (&["convert", clip, "x.bvh"], "x.bvh"),
        (&["inspect", clip, "--write-body", "x.ron"], "x.ron"),
        (&["plot", "run", "--what", "com", "--out", "x.svg"], "x.svg"),
    ];
    for (args, file) in commands {
        place.write(file, "mine");
        refused(&place, args, &[file, "exists already", "--force"]);
        let done = place.run(&[args, &["--force"]].concat());
        assert_eq!(done.code, 0, "{args:?}: {}", done.stderr);
        assert_ne!(std::fs::read_to_string(place.at(file)).unwrap(), "mine", "{args:?}");
        std::fs::remove_file(place.at(file)).unwrap();
        assert_eq!(place.run(args).code, 0, "{args:?}: a new name");
    }
}

/// A symbolic link is neither followed nor replaced, whatever it leads to.
#[cfg(unix)]
#[test]
fn a_symbolic_link_is_not_replaced() {
    let place = Place::new();
    let clip = place.clip("", "");
    let clip = clip.to_str().unwrap();
    place.write("mine.bvh", "mine");
    for (link, to) in [("link.bvh", "mine.bvh"), ("self.bvh", "clip.bvh"), ("nowhere.bvh", "nothing.bvh")] {
        std::os::unix::fs::symlink(to, place.at(link)).unwrap();
        let done = place.run(&["convert", clip, link, "--force"]);
        assert_eq!(done.code, 2, "{link}: {}", done.stderr);
        assert!(done.stderr.contains(link), "{}", done.stderr);
        assert!(place.at(link).is_symlink(), "{link}");
    }
    assert_eq!(std::fs::read_to_string(place.at("mine.bvh")).unwrap(), "mine");
    assert!(!place.at("nothing.bvh").exists());
}

/// A trace of somebody else's: it stays, and stands in the way of one.
#[test]
fn a_foreign_trace_stays() {
    let place = Place::new();
    let scene = place.scene("", "");
    place.write("out/trace.npz", "mine");
    let render = ["render", scene.to_str().unwrap(), "--no-plots", "--out", "out"];
    refused(&place, &render, &["trace.npz", "was not written by an earlier run"]);
    let done = place.run(&[&render[..], &["--kinematic"]].concat());
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert_eq!(std::fs::read_to_string(place.at("out/trace.npz")).unwrap(), "mine");
}

/// Not even with `--force`: what is read is not written.
#[test]
fn an_input_is_never_replaced() {
    let place = Place::new();
    let clip = place.clip("", "");
    let clip = clip.to_str().unwrap();
    for args in [&["inspect", clip, "--write-body", clip][..], &["convert", clip, clip]] {
        refused(&place, &[args, &["--force"]].concat(), &["clip.bvh", "input"]);
    }
}
