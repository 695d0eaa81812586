//! `propagate`: the loop from a first pair to a correction, and what it refuses.

use std::fs;
use std::path::PathBuf;

use crate::place::Place;

/// A clip of subject 16.
fn walk(name: &str) -> String {
    support::shared(&format!("mocap/bvh/{name}.bvh")).to_str().unwrap().to_owned()
}

/// A clip with `deg` more on the X channel of a joint in the frames from `from` on, every `keep`-th frame kept.
fn bent(
    place: &Place,
    clip: &str,
    joint: &str,
    deg: f64,
    frames: std::ops::Range<usize>,
    to: &str,
) -> PathBuf {
    let text = fs::read_to_string(clip).unwrap();
    let (head, motion) = text.split_once("MOTION").unwrap();
    let mut channels = Vec::new();
    let mut at = String::new();
    for line in head.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            ["ROOT" | "JOINT", name, ..] => at = (*name).to_owned(),
            ["CHANNELS", _, rest @ ..] => channels.extend(rest.iter().map(|c| (at.clone(), (*c).to_owned()))),
            _ => {}
        }
    }
    let column = channels.iter().position(|(j, c)| j == joint && c == "Xrotation").unwrap();
    let mut lines: Vec<String> = motion.trim().lines().map(str::to_owned).collect();
    for (f, line) in lines.iter_mut().skip(2).enumerate().filter(|(f, _)| frames.contains(f)) {
        let mut values: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
        let value: f64 = values[column].parse().unwrap_or_else(|e| panic!("frame {f}: {e}"));
        values[column] = format!("{:.6}", value + deg);
        *line = values.join(" ");
    }
    let path = place.at(to);
    fs::write(&path, format!("{head}MOTION\n{}\n", lines.join("\n"))).unwrap();
    path
}

const ALL: std::ops::Range<usize> = 0..usize::MAX;

/// A lean of 15° is learned from two walks, applied to a third within 1°, corrected, and undone by removing a file.
#[test]
fn an_edit_goes_around_its_loop() {
    let place = Place::new();
    let done = |words: &[&str]| {
        let done = place.run(words);
        assert_eq!(done.code, 0, "{words:?}\n{}", done.stderr);
        done.stdout
    };
    bent(&place, &walk("16_16"), "LowerBack", 15.0, ALL, "lean16.bvh");
    bent(&place, &walk("16_30"), "LowerBack", 15.0, ALL, "lean30.bvh");
    let said = done(&["propagate", "new", "lean", "--source", &walk("16_16"), "--target", "lean16.bvh"]);
    assert!(said.contains("LowerBack 15.0"), "{said}");
    done(&[
        "propagate",
        "add",
        "lean",
        "--source",
        &walk("16_30"),
        "--target",
        "lean30.bvh",
        "--name",
        "fast",
    ]);
    let said = done(&["propagate", "train", "lean"]);
    assert!(said.contains("learned from 2 pairs: 195 examples, each also mirrored"), "{said}");
    let unseen = walk("16_21");
    let said = done(&["propagate", "apply", "lean", &unseen, "out.bvh", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&said).unwrap();
    let turned = &report["joints"][0];
    assert_eq!(turned[0], "LowerBack");
    assert!((turned[1].as_f64().unwrap() - 15.0).abs() < 1.0, "{report}"); // 15.1 seen
    assert_eq!(report["joints"].as_array().unwrap().len(), 1, "{report}");

    // half of it, only from 1 s on: before, the clip is what it was
    done(&["propagate", "apply", "lean", &unseen, "half.bvh", "--amount", "0.5", "--span", "1,2.5"]);
    done(&["convert", &unseen, "plain.bvh", "--out-units", "0.01"]);
    let frame = |file: &str, n: usize| {
        let text = fs::read_to_string(place.at(file)).unwrap();
        text.lines().skip_while(|l| !l.starts_with("Frame Time")).nth(n + 1).unwrap().to_owned()
    };
    assert_eq!(frame("half.bvh", 60), frame("plain.bvh", 60));
    assert_ne!(frame("half.bvh", 200), frame("plain.bvh", 200));

    // thirty frames corrected outside become a pair
    done(&["propagate", "export", "lean", &unseen, "export.bvh"]);
    let exported = place.at("export.bvh").to_str().unwrap().to_owned();
    bent(&place, &exported, "Head", 20.0, 100..130, "edited.bvh");
    let said = done(&["propagate", "correct", "lean", &unseen, "--from", "edited.bvh"]);
    assert!(said.contains("frames 100 to 129") && said.contains("Head 20.0"), "{said}");
    let said = done(&["propagate", "apply", "lean", &unseen, "again.bvh"]);
    assert!(said.contains("Head"), "{said}");
    let said = done(&["propagate", "status", "lean", &unseen]);
    assert!(said.contains("pair edited: 312 frames") && said.contains("frames to key next"), "{said}");

    fs::remove_file(place.at("lean/pairs/edited.ron")).unwrap();
    let said = done(&["propagate", "status", "lean"]);
    assert!(said.contains("pairs were added or removed since"), "{said}");
    done(&["propagate", "train", "lean"]);
    done(&["propagate", "apply", "lean", &unseen, "third.bvh"]);
    assert_eq!(fs::read(place.at("third.bvh")).unwrap(), fs::read(place.at("out.bvh")).unwrap());
}

/// What cannot be learned from is said, with exit code 2, and leaves nothing behind.
#[test]
fn what_is_no_pair_is_refused() {
    let place = Place::new();
    let refused = |words: &[&str], said: &str| {
        let done = place.run(words);
        assert_eq!(done.code, 2, "{words:?}\n{}{}", done.stdout, done.stderr);
        assert!(done.stderr.contains(said), "`{said}` is not in\n{}", done.stderr);
    };
    let (a, b) = (walk("16_16"), walk("16_21"));
    refused(
        &["propagate", "new", "p", "--source", &a, "--target", &b],
        "the source has 510 frames at 120 Hz and the target 312 at 120 Hz",
    );
    refused(
        &["propagate", "new", "p", "--source", &a, "--target", &a, "--span", "9,12"],
        "the span 9 s to 12 s has no frames",
    );
    assert!(!place.at("p").exists());
    let lamp = place.clip("", "").to_str().unwrap().to_owned();
    refused(&["propagate", "train", "p"], "no project here; `contrapposto propagate new` makes one");
    let done = place.run(&["propagate", "new", "p", "--source", &a, "--target", &a]);
    assert!(done.code == 0 && done.stdout.contains("teaches to change nothing"), "{}", done.stderr);
    refused(&["propagate", "new", "p", "--source", &a, "--target", &a], "is there already");
    refused(&["propagate", "apply", "p", &b, "x.bvh"], "nothing was learned yet");
    assert_eq!(place.run(&["propagate", "train", "p"]).code, 0);
    refused(
        &["propagate", "apply", "p", &lamp, "x.bvh"],
        "the skeleton is not one that this edit was taught on",
    );
    refused(&["propagate", "apply", "p", &b, "x.foo"], "cannot write this; allowed:");
    refused(&["propagate", "apply", "p", &b, "x.bvh", "--amount", "7"], "allowed: 0 to 1.5");
    refused(&["propagate", "apply", "p", &b, "x.bvh", "--parts", "Hed"], "did you mean `Head`?");
    refused(&["propagate", "correct", "p", &b, "--from", &b], "no frame of the edited clip differs");
    refused(&["propagate", "correct", "p", &b, "--from", &a], "the edited clip has 510 frames");
    fs::write(place.at("p/model.edit"), "mine").unwrap();
    refused(&["propagate", "train", "p"], "model.edit");
    assert_eq!(fs::read_to_string(place.at("p/model.edit")).unwrap(), "mine");
    // an edit of nothing changes nothing, to the bit
    fs::remove_file(place.at("p/model.edit")).unwrap();
    assert_eq!(place.run(&["propagate", "train", "p"]).code, 0);
    assert_eq!(place.run(&["propagate", "apply", "p", &b, "same.bvh"]).code, 0);
    assert_eq!(place.run(&["convert", &b, "plain.bvh", "--out-units", "0.01"]).code, 0);
    assert_eq!(fs::read(place.at("same.bvh")).unwrap(), fs::read(place.at("plain.bvh")).unwrap());
}

/// A scene takes a learned edit by its file, and says where a file is none.
#[test]
fn a_scene_performs_a_learned_edit() {
    let place = Place::new();
    let a = walk("16_16");
    bent(&place, &a, "LowerBack", 15.0, ALL, "lean16.bvh");
    for words in [
        vec!["propagate", "new", "lean", "--source", &a, "--target", "lean16.bvh"],
        vec!["propagate", "train", "lean"],
        vec!["inspect", &a, "--write-body", "body.ron"],
    ] {
        let done = place.run(&words);
        assert_eq!(done.code, 0, "{}", done.stderr);
    }
    fs::copy(&a, place.at("walk.bvh")).unwrap();
    let scene = |model: &str| {
        let text = format!(
            "Scene(character: \"body.ron\", motion: Clip(\"walk.bvh\"), root: Pinned,\n\
             edits: [ByExample(model: \"{model}\", amount: 1)])\n"
        );
        fs::write(place.at("scene.ron"), text).unwrap();
        place.run(&["render", "scene.ron", "--kinematic", "--no-plots", "--out", "out"])
    };
    let done = scene("lean/model.edit");
    assert_eq!(done.code, 0, "{}", done.stderr);
    let report = fs::read_to_string(place.at("out/report.json")).unwrap();
    assert!(report.contains("LowerBack"), "{report}");
    let done = scene("lean/project.ron");
    assert_eq!(done.code, 2);
    assert!(
        done.stderr.contains("scene.ron:2:") && done.stderr.contains("lean/project.ron"),
        "{}",
        done.stderr
    );
    let done = scene("lean/none.edit");
    assert_eq!(done.code, 2);
    assert!(done.stderr.contains("none.edit"), "{}", done.stderr);
}
