//! `render` from end to end.

use std::process::Command;

use takes::results::folder::manifest::{MANIFEST, Manifest};

use crate::place::{Done, Place};

/// A file's numbers by a path such as `dynamic.root.mode`.
fn field<'a>(report: &'a serde_json::Value, path: &str) -> &'a serde_json::Value {
    path.split('.').fold(report, |v, key| v.get(key).unwrap_or_else(|| panic!("no {path} in the report")))
}

/// The first scene a newcomer renders: files, numbers, and forces that explain the motion.
#[test]
fn slow_the_bow() {
    let place = Place::new();
    let bow = support::scene("bow.ron").canonicalize().unwrap();
    let done = place.render(&bow, &[]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(done.stdout.contains("root") && done.stdout.contains("free"), "{}", done.stdout);
    assert_eq!(
        place.names("out"),
        ["contacts.ron", "dynamic.bvh", "dynamic.glb", "kinematic.bvh", "report.json", "trace.npz"]
    );

    let r = place.report("out");
    for path in [
        "scene",
        "frames",
        "rate_hz",
        "duration_s",
        "character.links",
        "character.dof",
        "character.mass_kg",
        "kinematic.feet.slip_mm_max",
        "dynamic.realtime_factor",
        "dynamic.fell",
        "dynamic.joint_rms_deg",
        "dynamic.root.mode",
        "dynamic.root.residual_force_peak_n",
        "dynamic.root.residual_force_rms_n",
        "dynamic.root.residual_moment_peak_nm",
        "dynamic.root.impulse_ns",
        "dynamic.feet.slip_mm_max",
        "dynamic.feet.penetration_mm_max",
        "dynamic.feet.float_mm_max",
        "dynamic.contact.vertical_mean_n",
        "dynamic.sagging",
        "files",
    ] {
        field(&r, path);
    }
    assert_eq!(field(&r, "dynamic.root.mode"), "free");
    assert_eq!(field(&r, "dynamic.fell"), false);
    let weight = field(&r, "dynamic.contact.vertical_end_percent_bw").as_f64().unwrap();
    assert!((weight - 100.0).abs() < 0.5, "{weight} % of body weight at the end"); // 100.00 seen
    for file in field(&r, "files").as_object().unwrap().values() {
        assert!(place.at("out").join(file.as_str().unwrap()).is_file(), "{file}");
    }

    // another road: the balance of momentum from the trace, by a program that shares no code
    if let Some(mut python) = support::python("the momentum balance of the bow", &[]) {
        let script = support::root().join("tests/momentum_balance.py");
        let limits = ["--max-rms", "0.5", "--max-weight-error", "0.5"];
        let balance = python.arg(script).arg(place.at("out/trace.npz")).args(limits).output();
        let balance = Done::of(&balance.unwrap());
        assert_eq!(balance.code, 0, "{}{}", balance.stdout, balance.stderr); // 0.16 % RMS seen
    }

    // the GLB is valid and holds the whole motion
    let glb = gltf::Gltf::open(place.at("out/dynamic.glb")).unwrap();
    let blob = glb.blob.clone().unwrap();
    let links = field(&r, "character.links").as_u64().unwrap() as usize;
    assert_eq!(glb.skins().next().unwrap().joints().count(), links);
    let animation = glb.animations().next().unwrap();
    let channel = animation.channels().next().unwrap();
    let reader = channel.reader(|_| Some(&blob));
    let times: Vec<f32> = reader.read_inputs().unwrap().collect();
    assert_eq!(times.len(), field(&r, "frames").as_u64().unwrap() as usize);
}

/// Without its edits a scene is the script alone; a clip has none to leave out.
#[test]
fn without_edits() {
    let place = Place::new();
    let bow = support::scene("bow.ron").canonicalize().unwrap();
    let mut jerk = Vec::new();
    for args in [&["--kinematic"][..], &["--kinematic", "--no-edits"]] {
        let done = place.render(&bow, args);
        assert_eq!(done.code, 0, "{}", done.stderr);
        jerk.push(field(&place.report("out"), "kinematic.jerk_ratio").as_f64().unwrap());
    }
    assert!(jerk[0] < 0.9 && jerk[1] == 1.0, "{jerk:?}");
    let clip = place.clip("", "");
    let done = place.render(&clip, &["--no-edits"]);
    assert_eq!(done.code, 2);
    assert!(done.stderr.contains("--no-edits is for scenes"), "{}", done.stderr);
}

/// Same input, same bytes: from another folder, locale and number of threads; but for the clock.
#[test]
fn slow_the_same_bytes_everywhere() {
    let (here, there) = (Place::new(), Place::new());
    let scene = here.scene("", "");
    let drawn = here.run(&["render", scene.to_str().unwrap(), "--out", "out"]);
    assert_eq!(drawn.code, 0, "{}", drawn.stderr);
    let done = Command::new(env!("CARGO_BIN_EXE_contrapposto"))
        .args(["render", "scene.ron", "--out"])
        .arg(there.at("deep/er/out"))
        .current_dir(scene.parent().unwrap())
        .env("LC_ALL", "de_DE.UTF-8")
        .env("LANG", "tr_TR.UTF-8")
        .env("RAYON_NUM_THREADS", "1")
        .env("TZ", "Asia/Tokyo")
        .output()
        .unwrap();
    assert_eq!(Done::of(&done).code, 0);
    assert_eq!(here.names("out"), there.names("deep/er/out"));
    let (a, b) = (here.files("out"), there.files("deep/er/out"));
    assert_eq!(a.len(), b.len());
    let figures: Vec<&str> = a.iter().filter_map(|(name, _)| name.strip_suffix(".png")).collect();
    assert_eq!(
        figures,
        [
            "plots/center_of_mass",
            "plots/contact_forces",
            "plots/gains_and_torques",
            "plots/joint_angles",
            "plots/momentum_residual",
            "plots/strip_dynamic",
            "plots/strip_edited",
        ]
    );
    for ((name, a), (other, b)) in a.iter().zip(&b) {
        assert_eq!(name, other);
        if name == MANIFEST {
            // the report has the clock's number, and the manifest a digest of the report
            let timeless = |place: &Place, folder: &str| {
                let (mut manifest, _) = Manifest::read(&place.at(folder)).unwrap().unwrap();
                manifest.files.remove("report.json").unwrap();
                manifest
            };
            assert_eq!(timeless(&here, "out"), timeless(&there, "deep/er/out"));
        } else if name == "report.json" {
            let timeless = |bytes: &[u8]| {
                let text = String::from_utf8(bytes.to_vec()).unwrap();
                let lines: Vec<String> =
                    text.lines().filter(|l| !l.contains("\"realtime_factor\"")).map(str::to_owned).collect();
                assert_eq!(lines.len() + 1, text.lines().count());
                lines
            };
            assert_eq!(timeless(a), timeless(b));
        } else {
            assert!(a == b, "{name} differs");
        }
    }
}

/// Only the motion asked for; what an earlier run left that would now lie goes, other files stay.
#[test]
fn slow_kinematic_output_replaces_dynamic_output() {
    let place = Place::new();
    let scene = place.scene("", "");
    assert_eq!(place.run(&["render", scene.to_str().unwrap(), "--out", "out"]).code, 0);
    assert!(place.at("out/plots/strip_dynamic.svg").exists());
    place.write("out/notes.txt", "mine");
    place.write("out/plots/mine.svg", "mine");
    let done = place.render(&scene, &["--kinematic"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert_eq!(
        place.names("out"),
        ["contacts.ron", "kinematic.bvh", "kinematic.glb", "notes.txt", "plots/mine.svg", "report.json"]
    );
    assert!(place.report("out").get("dynamic").is_none());
    assert!(gltf::Gltf::open(place.at("out/kinematic.glb")).is_ok());
}

/// `--json` prints the report, and nothing else.
#[test]
fn json_on_standard_output_is_the_report() {
    let place = Place::new();
    let done =
        place.render(&place.scene("", ""), &["--json", "--tension", "3", "--rate", "300", "--substeps", "1"]);
    assert_eq!((done.code, done.stderr.as_str()), (0, ""));
    assert_eq!(done.stdout.as_bytes(), std::fs::read(place.at("out/report.json")).unwrap());
    let r: serde_json::Value = serde_json::from_str(&done.stdout).unwrap();
    assert_eq!(field(&r, "dynamic.tension"), 3.0);
    assert_eq!(field(&r, "dynamic.rate_hz"), 300.0);
    assert_eq!(field(&r, "dynamic.substeps"), 1);
    assert_eq!(field(&r, "edit_conflicts"), 1);
}

/// A folder that cannot be written to is found out before the simulation, and nothing is left behind.
#[test]
fn a_locked_door() {
    let place = Place::new();
    let scene = place.scene("", "");
    let file = place.write("a-file", "earlier");
    // what was named is wrong: 2; it is right, and the machine refuses: 1
    for (out, code) in [("a-file", 2), ("a-file/below", 1), ("/proc/nowhere/out", 1)] {
        let done = place.run(&["render", scene.to_str().unwrap(), "--out", out]);
        assert_eq!(done.code, code, "{out}: {}", done.stderr);
        assert!(
            done.stderr.starts_with("error: cannot write") && done.stderr.contains(out),
            "{}",
            done.stderr
        );
    }
    assert_eq!(std::fs::read_to_string(file).unwrap(), "earlier");
    let names: Vec<String> = place.files("").into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["a-file", "characters/human.ron", "scene.ron"]);
}

/// A run that diverges fails, says where, and leaves what it recorded.
/// A body that falls for 80 s: everything is there, and the film strip has an ordinary size.
#[test]
fn slow_a_fall_of_kilometres_is_drawn() {
    let place = Place::new();
    let text = std::fs::read_to_string(support::shared("cases/scenes/freefall_80.ron")).unwrap();
    let scene = place.write("fall.ron", &text.replace("characters/", "library:characters/"));
    let done = place.run(&["render", scene.to_str().unwrap(), "--out", "out"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let names = place.names("out");
    for name in ["trace.npz", "report.json", "plots/strip_dynamic.png", "plots/strip_dynamic.svg"] {
        assert!(names.iter().any(|n| n == name), "{name}: {names:?}");
    }
    let svg = std::fs::read_to_string(place.at("out/plots/strip_dynamic.svg")).unwrap();
    assert!(svg.contains("80.00 s, 31 km lower"), "the last figure does not say how far it is");
    let png = std::fs::read(place.at("out/plots/strip_dynamic.png")).unwrap();
    let height = u32::from_be_bytes(png[20..24].try_into().unwrap());
    assert!(height < 1200, "{height} px");
}

/// Numbers are rounded wherever a person reads them: a clip of a crooked frame time, in summaries and on figures.
#[test]
fn slow_numbers_are_rounded() {
    let place = Place::new();
    let clip = place.clip("Frame Time: 0.03333333333333333", "Frame Time: 0.041708");
    let clip = clip.to_str().unwrap();
    let mut said = Vec::new();
    for args in [
        &["render", clip, "--out", "out"][..],
        &["inspect", clip],
        &["analyze", clip, "--out", "analysis"],
        &["plot", "out", "--force"],
        &["convert", clip, "again.glb"],
    ] {
        let done = place.run(args);
        assert_eq!(done.code, 0, "{args:?}: {}", done.stderr);
        said.push((args.join(" "), done.stdout));
    }
    for (name, bytes) in place.files("").into_iter().filter(|(name, _)| name.ends_with(".svg")) {
        // the texts of a figure, not the coordinates of its lines
        let svg = String::from_utf8(bytes).unwrap();
        let texts = svg.split("<text").skip(1).map(|t| {
            let t = t.split_once('>').unwrap().1;
            t.split("</text").next().unwrap().trim().to_owned()
        });
        said.push((name, texts.collect::<Vec<_>>().join("\n")));
    }
    for (what, text) in said {
        let words = text.split(|c: char| !c.is_ascii_digit() && c != '.');
        let long = words.filter(|w| {
            w.split_once('.').is_some_and(|(_, digits)| digits.len() > 6 && !digits.contains('.'))
        });
        assert_eq!(long.collect::<Vec<_>>(), Vec::<&str>::new(), "{what}:\n{text}");
    }
}

#[test]
fn slow_a_run_that_diverges() {
    let place = Place::new();
    let push = "settle_s: 0.2, pushes: [Push(link: \"wrist_r\", impulse_ns: (1e6, 0, 0), start_s: 0.1)]";
    let scene = place.scene("settle_s: 0.2", push);
    // with figures: they must bear a short trace
    let done = place.run(&["render", scene.to_str().unwrap(), "--out", "out"]);
    assert_eq!(done.code, 1, "{}", done.stdout);
    for word in ["diverged at step", " s), first seen at `", "is in out"] {
        assert!(done.stderr.contains(word), "{}", done.stderr);
    }
    assert!(done.stdout.contains("FAILED"), "{}", done.stdout);
    let r = place.report("out");
    assert!(field(&r, "dynamic.diverged").as_str().unwrap().contains("diverged"));
    assert_eq!(place.names("out").len(), 6 + 14);
}

/// A fall is no failure, but it is not kept quiet.
#[test]
fn slow_a_body_that_falls() {
    let place = Place::new();
    let push = "settle_s: 1.5, pushes: [Push(link: \"chest\", impulse_ns: (0, 0, 400), start_s: 0.1)]";
    let done = place.render(&place.scene("settle_s: 0.2", push), &[]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(done.stdout.contains("THE BODY FELL at"), "{}", done.stdout);
    assert!(done.stdout.contains("the capture point left the support at 0."), "{}", done.stdout);
    let r = place.report("out");
    assert_eq!(field(&r, "dynamic.fell"), true);
    assert_eq!(field(&r, "dynamic.fall.cause"), "capture point");
    assert_eq!(field(&r, "dynamic.fall.at_s"), field(&r, "dynamic.fell_at_s"));
    assert_eq!(field(&r, "disturbances.pushes")[0]["link"], "chest");
    // the figures mark both moments
    let done = place.run(&["render", "scene.ron", "--out", "drawn"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    for figure in ["contact_forces", "center_of_mass", "joint_angles"] {
        let svg = std::fs::read_to_string(place.at(&format!("drawn/plots/{figure}.svg"))).unwrap();
        assert!(svg.contains("the body has fallen") && svg.contains("the capture point left"), "{figure}");
    }
}

/// Legs whose tension is kept where they stand say so.
#[test]
fn legs_that_were_asked_for_less() {
    let place = Place::new();
    let done = place.render(&place.scene("", ""), &["--tension", "0.25"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(done.stdout.contains("tension RAISED from 0.25 to 0.6 (+140 %)"), "{}", done.stdout);
    let legs = field(&place.report("out"), "dynamic.leg_tension").clone();
    assert_eq!(legs.as_array().unwrap().len(), 6);
    assert_eq!((&legs[0]["asked"], &legs[0]["used"]), (&0.25.into(), &0.6.into()));
}

/// A clip gets a body; what was guessed is printed; files are written in the clip's own unit.
#[test]
fn a_clip() {
    let place = Place::new();
    let clip = place.clip("", "");
    let (inches, clip) = (place.at("inches.bvh"), clip.to_str().unwrap());
    let converted = place.run(&["convert", clip, inches.to_str().unwrap(), "--out-units", "0.0254"]);
    assert_eq!(converted.code, 0, "{}", converted.stderr);
    let done = place.render(&inches, &[]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    for word in ["pinned", "units: 0.0254 m (guessed", "up: Y (guessed", "stature", "left thigh"] {
        assert!(done.stdout.contains(word), "`{word}` is not in\n{}", done.stdout);
    }
    let offsets = |path: std::path::PathBuf| -> Vec<String> {
        let text = std::fs::read_to_string(path).unwrap();
        text.lines().filter(|l| l.contains("OFFSET")).map(str::to_owned).collect()
    };
    assert_eq!(offsets(inches.clone()), offsets(place.at("out/dynamic.bvh")));
    assert_eq!(offsets(inches.clone()), offsets(place.at("out/kinematic.bvh")));
    let r = place.report("out");
    assert_eq!(field(&r, "dynamic.root.mode"), "pinned");
    let stated =
        place.render(&inches, &["--units", "0.0254", "--up", "y", "--drop-t-pose", "--root", "free"]);
    assert_eq!(stated.code, 0, "{}", stated.stderr);
    assert!(stated.stdout.contains("units: 0.0254 m (stated"), "{}", stated.stdout);
    assert!(stated.stdout.contains("up: Y (stated"), "{}", stated.stdout);
    assert_eq!(field(&place.report("out"), "dynamic.root.mode"), "free");
}

/// A clip that stands, then walks off: its standing span is performed free, in a folder of its own; the rest is named
/// and is not. A later run without spans takes the folder away.
#[test]
fn slow_a_clip_that_steps() {
    let place = Place::new();
    let clip = support::shared("mocap/bvh/127_04.bvh");
    let done = place.render(&clip, &["--root", "free"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    for word in ["its standing span performed", "the body stands", "steps: leg_l, leg_r; not performed"] {
        assert!(done.stdout.contains(word), "`{word}` is not in\n{}", done.stdout);
    }
    let whole = place.report("out");
    let spans = field(&whole, "spans").as_array().unwrap();
    assert_eq!(spans.len(), 2);
    assert_eq!((spans[0]["folder"].as_str(), spans[1]["folder"].as_str()), (Some("span_1"), None));
    assert_eq!(spans[0]["dynamic"]["fell"], false);
    assert!(whole.get("dynamic").is_none());
    let part = place.report("out/span_1");
    assert_eq!(field(&part, "dynamic.root.mode"), "free");
    assert!(place.at("out/span_1/dynamic.bvh").exists() && !place.at("out/dynamic.bvh").exists());

    // the standing part alone is an ordinary run; beyond the clip there is none
    let done = place.render(&clip, &["--root", "free", "--span", "0..1.4"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(place.at("out/dynamic.bvh").exists() && !place.at("out/span_1").exists());
    let done = place.render(&clip, &["--span", "1..9"]);
    assert_eq!(done.code, 2);
    assert!(done.stderr.contains("no span 1..9 s; the clip lasts 3.7"), "{}", done.stderr);
}

/// Fidelities side by side: a table, JSON, a figure.
#[test]
fn a_pareto_curve() {
    let place = Place::new();
    let scene = place.scene("", "");
    let done = place.run(&["render", scene.to_str().unwrap(), "--pareto", "0.4,0", "--out", "out", "--json"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let curve: serde_json::Value = serde_json::from_str(&done.stdout).unwrap();
    assert_eq!(curve, place.report("out"));
    let fidelities: Vec<_> =
        curve["points"].as_array().unwrap().iter().map(|p| p["fidelity"].as_f64()).collect();
    assert_eq!(fidelities, [Some(0.0), Some(0.4)]);
    assert!(place.at("out/plots/pareto.svg").exists() && place.at("out/plots/pareto.png").exists());
}

/// The body that `inspect` writes performs the clip as the guessed one does.
#[test]
fn a_clip_with_its_written_body() {
    let place = Place::new();
    let clip = place.clip("", "");
    assert_eq!(place.render(&clip, &[]).code, 0);
    let guessed = place.report("out");
    let done = place.run(&["inspect", clip.to_str().unwrap(), "--write-body", "body.ron"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let done = place.render(&clip, &["--body", "body.ron"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let written = place.report("out");
    assert_eq!(field(&guessed, "character.dof"), field(&written, "character.dof"));
    let rms = |r: &serde_json::Value| field(r, "dynamic.joint_rms_deg").as_f64().unwrap();
    assert!((rms(&guessed) - rms(&written)).abs() < 1e-3, "{} {}", rms(&guessed), rms(&written));
}

/// What was guessed of soles gives way to a body that a person has edited: on shorter soles the motion no longer stands.
#[test]
fn a_clip_with_an_edited_body() {
    let place = Place::new();
    let clip = place.clip("", "");
    let done = place.run(&["inspect", clip.to_str().unwrap(), "--write-body", "body.ron"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let soles = |text: &str| -> Vec<String> {
        let of = text.lines().filter(|l| l.contains("Site(name: \"ball_"));
        of.map(|l| l.split("at_m: (").nth(1).unwrap().split(')').next().unwrap().to_owned()).collect()
    };
    let written = std::fs::read_to_string(place.at("body.ron")).unwrap();
    let mut edited = written.clone();
    let found = soles(&written);
    assert_eq!(found.len(), 4, "{found:?}");
    // the soles end 16 cm further back: there is nothing under the toes
    for at in &found {
        let mut numbers: Vec<f64> = at.split(", ").map(|x| x.parse().unwrap()).collect();
        numbers[2] -= 0.16;
        let now = numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
        edited = edited.replace(at, &now);
    }
    place.write("body.ron", &edited);
    let outside_mm = |body: &[&str]| {
        let clip = clip.to_str().unwrap();
        let done = place.run(&[&["analyze", clip, "--no-plots", "--json"], body].concat());
        assert_eq!(done.code, 0, "{}", done.stderr);
        let report: serde_json::Value = serde_json::from_str(&done.stdout).unwrap();
        field(&report, "support.worst_mm").as_f64().unwrap()
    };
    let (guessed, stated) = (outside_mm(&[]), outside_mm(&["--body", "body.ron"]));
    assert!(stated > guessed + 5.0, "the centre of pressure is {guessed} and {stated} mm outside the soles");
}
