//! The loop of `propagate` where it goes wrong or is ended: contexts, bad pairs, killed runs; scenes as clips, another body.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::place::Place;

/// A trunk with two arms and two legs, in BVH of centimetres; `longer` stretches the legs.
fn hierarchy(longer: f64) -> String {
    let joint = |depth: usize, name: &str, at: [f64; 3], inside: &str| {
        let tab = "  ".repeat(depth);
        let [x, y, z] = at;
        format!(
            "{tab}JOINT {name}\n{tab}{{\n{tab}  OFFSET {x} {y} {z}\n{tab}  CHANNELS 3 Zrotation Xrotation Yrotation\n{inside}{tab}}}\n"
        )
    };
    let end = |depth: usize, at: [f64; 3]| {
        let tab = "  ".repeat(depth);
        format!("{tab}End Site\n{tab}{{\n{tab}  OFFSET {} {} {}\n{tab}}}\n", at[0], at[1], at[2])
    };
    let arm = |side: &str, x: f64| {
        let fore = joint(3, &format!("{side}ForeArm"), [28.0 * x, 0.0, 0.0], &end(4, [25.0 * x, 0.0, 0.0]));
        joint(2, &format!("{side}Arm"), [20.0 * x, 30.0, 0.0], &fore)
    };
    let leg = |side: &str, x: f64| {
        let foot = joint(3, &format!("{side}Foot"), [0.0, -45.0 * longer, 0.0], &end(4, [0.0, 0.0, 12.0]));
        let shin = joint(2, &format!("{side}Leg"), [0.0, -45.0 * longer, 0.0], &foot);
        joint(1, &format!("{side}UpLeg"), [10.0 * x, 0.0, 0.0], &shin)
    };
    let head = joint(2, "Head", [0.0, 45.0, 0.0], &end(3, [0.0, 20.0, 0.0]));
    let trunk = joint(1, "Spine", [0.0, 15.0, 0.0], &(head + &arm("Left", 1.0) + &arm("Right", -1.0)));
    format!(
        "HIERARCHY\nROOT Hips\n{{\n  OFFSET 0 0 0\n  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n{}{}{}}}\n",
        trunk,
        leg("Left", 1.0),
        leg("Right", -1.0)
    )
}

/// Joints in the order of the channels, three each after the root's place.
const JOINTS: [&str; 13] = [
    "Hips",
    "Spine",
    "Head",
    "LeftArm",
    "LeftForeArm",
    "RightArm",
    "RightForeArm",
    "LeftUpLeg",
    "LeftLeg",
    "LeftFoot",
    "RightUpLeg",
    "RightLeg",
    "RightFoot",
];

/// A clip at 30 Hz: the body walks, `change` alters the angles (Z, X, Y of each joint, degrees) of every frame.
fn clip(place: &Place, name: &str, frames: usize, longer: f64, change: impl Fn(usize, &mut [f64])) -> String {
    let mut text = format!("{}MOTION\nFrames: {frames}\nFrame Time: 0.0333333\n", hierarchy(longer));
    for f in 0..frames {
        let t = f as f64 / 30.0;
        let swing = (6.0 * t).sin();
        let mut angles = vec![0.0; 3 * JOINTS.len()];
        let mut set =
            |joint: &str, x: f64| angles[3 * JOINTS.iter().position(|j| *j == joint).unwrap() + 1] = x;
        set("LeftUpLeg", 25.0 * swing);
        set("RightUpLeg", -25.0 * swing);
        set("LeftLeg", 20.0 - 20.0 * swing);
        set("RightLeg", 20.0 + 20.0 * swing);
        set("LeftArm", -20.0 * swing);
        set("RightArm", 20.0 * swing);
        change(f, &mut angles);
        let _ = write!(text, "0 {:.4} {:.4}", 90.0 * longer + 2.0 * (12.0 * t).cos(), 120.0 * t);
        for a in &angles {
            let _ = write!(text, " {a:.5}");
        }
        text.push('\n');
    }
    place.write(name, &text);
    name.to_owned()
}

/// Turns a joint about X by so many degrees more.
fn by(joint: &str, deg: f64) -> impl Fn(usize, &mut [f64]) {
    let at = 3 * JOINTS.iter().position(|j| *j == joint).unwrap() + 1;
    move |_, angles| angles[at] += deg
}

fn plain(_: usize, _: &mut [f64]) {}

fn done(place: &Place, words: &[&str]) -> String {
    let done = place.run(words);
    assert_eq!(done.code, 0, "{words:?}\n{}", done.stderr);
    done.stdout
}

fn refused(place: &Place, words: &[&str], said: &str) {
    let done = place.run(words);
    assert_eq!(done.code, 2, "{words:?}\n{}{}", done.stdout, done.stderr);
    assert!(done.stderr.contains(said), "`{said}` is not in\n{}", done.stderr);
}

/// How far a joint was turned by `apply`, degrees; 0 of one that was not.
fn turned(said: &str, joint: &str) -> f64 {
    let report: serde_json::Value = serde_json::from_str(said).unwrap();
    let joints = report["joints"].as_array().unwrap();
    joints.iter().find(|j| j[0] == joint).map_or(0.0, |j| j[1].as_f64().unwrap())
}

/// Two pairs that contradict each other are named, and kept apart by their contexts: each is learned by itself, with what has no context.
#[test]
fn contexts_keep_contradicting_pairs_apart() {
    let place = Place::new();
    let source = clip(&place, "walk.bvh", 120, 1.0, plain);
    let bow = clip(&place, "bow.bvh", 120, 1.0, by("Spine", 20.0));
    let back = clip(&place, "back.bvh", 120, 1.0, by("Spine", -20.0));
    // another motion: both arms are held out
    let held = |_: usize, angles: &mut [f64]| (angles[9], angles[15]) = (60.0, -60.0);
    let short = clip(&place, "short.bvh", 60, 1.0, held);
    let head = clip(&place, "head.bvh", 60, 1.0, move |f, angles| {
        held(f, angles);
        by("Head", 10.0)(f, angles);
    });
    let add = |verb: &str, target: &str, context: &str| {
        done(
            &place,
            &["propagate", verb, "p", "--source", &source, "--target", target, "--context", context],
        );
    };
    add("new", &bow, "sad");
    add("add", &back, "proud");
    // without a context both are averaged, which `status` names
    done(&place, &["propagate", "train", "p"]);
    let said = done(&place, &["propagate", "status", "p"]);
    assert!(
        said.contains("of context proud, sad") && said.contains("are alike and 40° apart at Spine"),
        "{said}"
    );
    assert!(!said.contains("pairs were added or removed"), "{said}");
    let of = |context: &str, degrees: f64| {
        done(&place, &["propagate", "train", "p", "--context", context]);
        let said = done(&place, &["propagate", "apply", "p", &source, "out.bvh", "--force", "--json"]);
        let spine = turned(&said, "Spine");
        assert!((spine - degrees).abs() < 1.0, "{context}: {spine}°");
        let said = done(&place, &["propagate", "status", "p"]);
        assert!(said.contains(&format!("of context {context}\n")), "{said}");
        assert!(!said.contains("are alike") && !said.contains("pairs were added or removed"), "{said}");
    };
    of("sad", 20.0);
    of("proud", 20.0);
    refused(
        &place,
        &["propagate", "train", "p", "--context", "prod"],
        "no pair has the context `prod`; there are `proud`, `sad`",
    );
    // a pair without a context belongs to all
    done(&place, &["propagate", "add", "p", "--source", &short, "--target", &head]);
    let said = done(&place, &["propagate", "status", "p"]);
    assert!(said.contains("pairs were added or removed since"), "{said}");
    done(&place, &["propagate", "train", "p", "--context", "sad"]);
    for (clip, head, spine) in [(&short, 10.0, 0.0), (&source, 0.0, 20.0)] {
        let said = done(&place, &["propagate", "apply", "p", clip, "out.bvh", "--force", "--json"]);
        let found = (turned(&said, "Head"), turned(&said, "Spine"));
        assert!((found.0 - head).abs() < 2.0 && (found.1 - spine).abs() < 2.0, "{clip}: {found:?}");
    }
    // a correction of another context does not touch the model of this one
    let model = fs::read(place.at("p/model.edit")).unwrap();
    done(&place, &["propagate", "export", "p", &source, "export.bvh"]);
    let text = fs::read_to_string(place.at("export.bvh")).unwrap();
    place.write("edited.bvh", &last_column_more(&text, 20..40));
    let words = ["propagate", "correct", "p", &source, "--from", "edited.bvh", "--context", "proud"];
    let said = done(&place, &words);
    assert!(said.contains("the model is of context sad: it stays as it is"), "{said}");
    assert_eq!(fs::read(place.at("p/model.edit")).unwrap(), model);
    assert!(place.at("p/pairs/edited.ron").exists());
}

/// The text of a BVH with 15° more in the last channel of some frames.
fn last_column_more(text: &str, frames: std::ops::Range<usize>) -> String {
    let (head, motion) = text.split_once("Frame Time").unwrap();
    let mut lines: Vec<String> = motion.lines().map(str::to_owned).collect();
    for f in frames {
        let line = &mut lines[1 + f];
        let (rest, last) = line.trim_end().rsplit_once(' ').unwrap();
        *line = format!("{rest} {:.6}", last.parse::<f64>().unwrap() + 15.0);
    }
    format!("{head}Frame Time{}\n", lines.join("\n"))
}

/// A correction is blended into the frames beside it, and into no others.
#[test]
fn a_correction_is_blended_into_its_neighbours() {
    let place = Place::new();
    let source = clip(&place, "walk.bvh", 90, 1.0, plain);
    let bow = clip(&place, "bow.bvh", 90, 1.0, by("Spine", 10.0));
    done(&place, &["propagate", "new", "p", "--source", &source, "--target", &bow]);
    done(&place, &["propagate", "train", "p"]);
    done(&place, &["propagate", "export", "p", &source, "export.bvh"]);
    done(&place, &["propagate", "export", "p", &source, "export.glb"]);
    assert_eq!(&fs::read(place.at("export.glb")).unwrap()[..4], b"glTF");
    let text = fs::read_to_string(place.at("export.bvh")).unwrap();
    place.write("edited.bvh", &last_column_more(&text, 40..50));
    done(
        &place,
        &["propagate", "correct", "p", &source, "--from", "edited.bvh", "--blend", "0.2", "--no-train"],
    );
    let last = |file: &str| -> Vec<f64> {
        let text = fs::read_to_string(place.at(file)).unwrap();
        let frames = text.lines().skip_while(|l| !l.starts_with("Frame Time")).skip(1);
        frames.map(|l| l.split_whitespace().last().unwrap().parse().unwrap()).collect()
    };
    let (before, after) = (last("export.bvh"), last("p/pairs/edited.target.bvh"));
    for (f, (a, b)) in before.iter().zip(&after).enumerate() {
        // 0.2 s are six frames
        let away = if f < 40 { 40 - f } else { f.saturating_sub(49) };
        let share = (1.0 - away as f64 / 7.0).max(0.0);
        assert!((b - a - 15.0 * share).abs() < 1e-3, "frame {f}: {a} {b}");
    }
    let pair = fs::read_to_string(place.at("p/pairs/edited.ron")).unwrap();
    assert!(pair.contains("1.1333") && pair.contains("1.8333"), "{pair}"); // frames 34 to 55
    // what was done is undone by removing the file
    fs::remove_file(place.at("p/pairs/edited.ron")).unwrap();
    let said = done(&place, &["propagate", "status", "p"]);
    assert!(!said.contains("edited") && !said.contains("pairs were added"), "{said}");
    refused(
        &place,
        &["propagate", "correct", "p", &source, "--from", "export.glb"],
        "cannot read a clip from this",
    );
}

/// What cannot be learned from is said; what is thin is learned as what it is.
#[test]
fn bad_pairs_are_refused_and_thin_ones_learned() {
    let place = Place::new();
    let new = |target: &str, source: &str| {
        let _ = fs::remove_dir_all(place.at("p"));
        ["propagate", "new", "p", "--source", source, "--target", target].map(str::to_owned)
    };
    let words = |all: &[String; 7]| -> Vec<String> { all.to_vec() };
    let say = |all: Vec<String>, said: &str| {
        let words: Vec<&str> = all.iter().map(String::as_str).collect();
        refused(&place, &words, said);
        assert!(!place.at("p").exists(), "a project of a bad pair");
    };
    let source = clip(&place, "walk.bvh", 60, 1.0, plain);
    // unequal length
    let short = clip(&place, "short.bvh", 59, 1.0, plain);
    say(words(&new(&short, &source)), "the source has 60 frames at 30 Hz and the target 59 at 30 Hz");
    // another skeleton
    let text = fs::read_to_string(place.at("walk.bvh")).unwrap();
    place.write("other.bvh", &text.replace("JOINT Head", "JOINT Kopf"));
    say(words(&new("other.bvh", &source)), "the skeleton is not one that this edit was taught on");
    // not a number
    place.write("nan.bvh", &text.replace(" 120.0000", " NaN").replacen(" 4.0000 ", " nan ", 1));
    say(words(&new("nan.bvh", &source)), "nan.bvh");
    // no frame
    let none = clip(&place, "none.bvh", 0, 1.0, plain);
    say(words(&new(&none, &none)), "none.bvh");
    // no pair
    let bow = clip(&place, "bow.bvh", 60, 1.0, by("Spine", 20.0));
    let run = |all: [String; 7]| {
        let words: Vec<&str> = all.iter().map(String::as_str).collect();
        done(&place, &words);
    };
    run(new(&bow, &source));
    fs::remove_file(place.at("p/pairs/bow.ron")).unwrap();
    refused(&place, &["propagate", "train", "p"], "there is no pair to learn from");
    refused(&place, &["propagate", "apply", "p", &source, "x.bvh"], "nothing was learned yet");
    // one frame: that pose gets the edit, whatever else does not
    let (one, one_bow) =
        (clip(&place, "one.bvh", 1, 1.0, plain), clip(&place, "one-bow.bvh", 1, 1.0, by("Spine", 20.0)));
    run(new(&one_bow, &one));
    let said = done(&place, &["propagate", "train", "p"]);
    assert!(said.contains("1 examples"), "{said}");
    let said = done(&place, &["propagate", "apply", "p", &one, "x.bvh", "--json"]);
    assert!(turned(&said, "Spine") > 15.0, "{said}");
    // all frames the same
    let still = |name: &str, deg: f64| {
        clip(&place, name, 40, 1.0, move |_, angles| {
            angles.fill(0.0);
            angles[4] = deg;
        })
    };
    let flat = |name: &str| {
        // the root stands too
        let text = fs::read_to_string(place.at(name)).unwrap();
        let (head, motion) = text.split_once("0.0333333\n").unwrap();
        let first = motion.lines().next().unwrap();
        place.write(name, &format!("{head}0.0333333\n{}", format!("{first}\n").repeat(40)));
    };
    let (still_source, still_bow) = (still("still.bvh", 0.0), still("still-bow.bvh", 20.0));
    flat("still.bvh");
    flat("still-bow.bvh");
    run(new(&still_bow, &still_source));
    done(&place, &["propagate", "train", "p"]);
    let said = done(&place, &["propagate", "apply", "p", &still_source, "y.bvh", "--json"]);
    assert!(turned(&said, "Spine") > 18.0, "{said}");
    let said = done(&place, &["propagate", "apply", "p", &source, "z.bvh", "--json"]);
    assert!(turned(&said, "Spine") < 1.0, "a walk is unlike a body that stands still\n{said}");
}

/// More than 3,000 examples are approximated, and it is said.
#[test]
fn huge_training_is_approximated_and_says_so() {
    let place = Place::new();
    let wander = |f: usize, angles: &mut [f64]| angles[3] += 10.0 * (0.013 * f as f64).sin();
    let source = clip(&place, "long.bvh", 1600, 1.0, wander);
    // an edit of nothing: the kernel is not searched for, which is what takes long
    done(&place, &["propagate", "new", "p", "--source", &source, "--target", &source]);
    let said = done(&place, &["propagate", "train", "p"]);
    assert!(
        said.contains("1600 examples, each also mirrored")
            && said.contains("all enter through 750 inducing points"),
        "{said}"
    );
    done(&place, &["propagate", "apply", "p", &source, "x.bvh"]);
}

/// A training that is killed leaves the project as it was, or done; the next one goes through.
#[test]
fn a_killed_training_leaves_the_project_whole() {
    let place = Place::new();
    let source = clip(&place, "walk.bvh", 600, 1.0, |f, angles| angles[3] += 10.0 * (0.05 * f as f64).sin());
    let bow = clip(&place, "bow.bvh", 600, 1.0, |f, angles| {
        angles[3] += 10.0 * (0.05 * f as f64).sin();
        angles[4] += 10.0 + 5.0 * (6.0 * f as f64 / 30.0).sin();
    });
    done(&place, &["propagate", "new", "p", "--source", &source, "--target", &bow, "--span", "0,2"]);
    done(&place, &["propagate", "train", "p"]);
    let before = fs::read(place.at("p/model.edit")).unwrap();
    done(&place, &["propagate", "add", "p", "--source", &source, "--target", &bow, "--name", "all"]);
    let files = || {
        let mut names: Vec<String> = fs::read_dir(place.at("p/pairs"))
            .unwrap()
            .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    };
    let pairs = files();
    for (wait_ms, step) in [(20, "train"), (120, "train"), (400, "train"), (60, "apply")] {
        let words: &[&str] = if step == "train" {
            &["propagate", "train", "p"]
        } else {
            &["propagate", "apply", "p", &source, "out.bvh"]
        };
        let mut child = Command::new(env!("CARGO_BIN_EXE_contrapposto"))
            .args(words)
            .current_dir(place.at(""))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(wait_ms));
        let _ = child.kill();
        child.wait().unwrap();
        assert_eq!(files(), pairs);
        done(&place, &["propagate", "status", "p"]);
        assert!(
            !Path::new(&place.at("out.bvh")).exists()
                || fs::read_to_string(place.at("out.bvh")).unwrap().ends_with('\n')
        );
    }
    // what a killed process left beside the model is in nobody's way, and the model is the old one or the new
    let now = fs::read(place.at("p/model.edit")).unwrap();
    done(&place, &["propagate", "train", "p"]);
    let after = fs::read(place.at("p/model.edit")).unwrap();
    assert!(now == before || now == after, "a model that is neither");
    assert_ne!(before, after);
    // a pair whose writing was killed before its own file is no pair, and does not block its name
    fs::remove_file(place.at("p/pairs/all.ron")).unwrap();
    done(&place, &["propagate", "add", "p", "--source", &source, "--target", &bow, "--name", "all"]);
}

/// Scenes are clips too, and the result goes onto a body of other proportions.
#[test]
fn scenes_are_clips_and_results_go_onto_other_bodies() {
    let place = Place::new();
    let scenes = support::root().join("scenes");
    let at = |name: &str| scenes.join(name).to_str().unwrap().to_owned();
    let (source, target) = (at("propagate/setting-off.ron"), at("propagate/setting-off-arms-out.ron"));
    let said = done(
        &place,
        &["propagate", "new", "p", "--source", &source, "--target", &target, "--span", "0.1,2.55"],
    );
    assert!(said.contains("shoulder_l") && said.contains("shoulder_r"), "{said}");
    let said = done(&place, &["propagate", "train", "p"]);
    assert!(said.contains("74 examples, each also mirrored"), "{said}");
    let said = done(&place, &["propagate", "apply", "p", &source, "out.bvh", "--json"]);
    assert!(turned(&said, "shoulder_l") > 55.0, "{said}");

    // longer legs: the root is as much higher and goes as much farther, joints do the same
    let walk = clip(&place, "walk.bvh", 60, 1.0, plain);
    let bow = clip(&place, "bow.bvh", 60, 1.0, by("Spine", 20.0));
    let tall = clip(&place, "tall.bvh", 2, 1.15, plain);
    done(&place, &["propagate", "new", "q", "--source", &walk, "--target", &bow]);
    done(&place, &["propagate", "train", "q"]);
    done(&place, &["propagate", "apply", "q", &walk, "own.bvh"]);
    let said = done(&place, &["propagate", "apply", "q", &walk, "on-tall.bvh", "--onto", &tall, "--json"]);
    assert!((turned(&said, "Spine") - 20.0).abs() < 0.5, "{said}");
    let frames = |file: &str| -> Vec<Vec<f64>> {
        let text = fs::read_to_string(place.at(file)).unwrap();
        let lines = text.lines().skip_while(|l| !l.starts_with("Frame Time")).skip(1);
        lines.map(|l| l.split_whitespace().map(|x| x.parse().unwrap()).collect()).collect()
    };
    let (own, on_tall) = (frames("own.bvh"), frames("on-tall.bvh"));
    assert_eq!(own.len(), on_tall.len());
    for (a, b) in own.iter().zip(&on_tall) {
        let way = (b[2] - a[2] * 1.15).abs();
        assert!(way < 0.01, "{way} cm"); // centimetres
        for (x, y) in a[3..].iter().zip(&b[3..]) {
            assert!((x - y).abs() < 1e-3, "{x} {y}");
        }
    }
    let text = fs::read_to_string(place.at("on-tall.bvh")).unwrap();
    assert!(text.contains("-51.75"), "legs of 45 cm are 15 % longer");
    refused(
        &place,
        &["propagate", "apply", "q", &walk, "x.bvh", "--onto", &at("characters/lamp.ron")],
        "link 0 of the body is",
    );
    refused(&place, &["propagate", "apply", "q", &walk, "tall.bvh", "--onto", &tall, "--force"], "tall.bvh");
}
