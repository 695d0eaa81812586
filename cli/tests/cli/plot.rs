//! `plot` from end to end.

use takes::results::folder::manifest::MANIFEST;

use crate::place::{Done, Place};

const EACH: [&str; 9] =
    ["angles", "com", "contact", "energy", "gains", "momentum", "residual", "strip", "torque"];

/// A folder `run` with the trace of the short bow.
fn run(place: &Place) {
    let scene = place.scene("", "");
    let done = place.run(&["render", scene.to_str().unwrap(), "--no-plots", "--out", "run"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
}

fn json(done: &Done) -> serde_json::Value {
    assert_eq!((done.code, done.stderr.as_str()), (0, ""));
    serde_json::from_str(&done.stdout).unwrap()
}

fn number(v: &serde_json::Value, path: &str) -> f64 {
    let found = path.split('.').fold(v, |v, key| &v[key]);
    found.as_f64().unwrap_or_else(|| panic!("{path} in {v:#}"))
}

/// All figures beside the trace, from the folder or the file, the same bytes each time; what the run left
/// stays.
#[test]
fn slow_all_figures_of_a_run() {
    let place = Place::new();
    run(&place);
    let before = place.files("run");
    let done = place.run(&["plot", "run"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let expected: Vec<String> =
        EACH.iter().flat_map(|w| ["png", "svg"].map(|kind| format!("{w}.{kind}"))).collect();
    let figures = |folder: &str| {
        let plots = |name: String| name.strip_prefix("plots/").map(str::to_owned);
        place.names(folder).into_iter().filter_map(plots).collect::<Vec<String>>()
    };
    assert_eq!(figures("run"), expected);
    for (name, bytes) in before.iter().filter(|(name, _)| name != MANIFEST) {
        assert!(std::fs::read(place.at("run").join(name)).unwrap() == *bytes, "{name} changed");
    }
    for what in EACH {
        assert!(done.stdout.contains(&format!("run/plots/{what}.svg")), "{}", done.stdout);
    }
    let done = place.run(&["plot", "run/trace.npz", "--out", "again"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert_eq!(place.names("again"), expected);
    for name in &expected {
        let [a, b] = ["run/plots", "again"].map(|folder| std::fs::read(place.at(folder).join(name)).unwrap());
        assert!(a == b, "{name} differs");
    }
}

/// The numbers on the figures: what was measured is what the motion requires, in total and per foot.
#[test]
fn numbers_as_json() {
    let place = Place::new();
    run(&place);
    let v = json(&place.run(&["plot", "run", "--what", "contact,residual", "--json"]));
    assert_eq!((&v["name"], &v["source"]), (&"run".into(), &"trace".into()));
    let figures = v["figures"].as_array().unwrap();
    let whats: Vec<_> = figures.iter().map(|f| f["what"].as_str().unwrap()).collect();
    assert_eq!(whats, ["contact", "residual"]);
    for file in figures.iter().flat_map(|f| f["files"].as_array().unwrap()) {
        assert!(place.at(file.as_str().unwrap()).is_file(), "{file}");
    }
    let contact = &figures[0]["numbers"];
    assert_eq!(contact["reference"], "measured");
    assert!((number(contact, "weight_n") - 75.0 * 9.81).abs() < 0.5);
    // N; 2.7 of 736 seen in this half second, most of it while the body settles in the first rows
    assert!(number(contact, "rms_difference_n.required.total.vertical") < 8.0, "{contact:#}");
    for part in ["total", "leg_l", "leg_r"] {
        for witness in ["required", "penalty"] {
            number(contact, &format!("rms_difference_n.{witness}.{part}.horizontal"));
        }
    }
    let residual = &figures[1]["numbers"];
    assert_eq!(residual["grade"], "good");
    // the report of the run gives the same number
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(place.at("run/report.json")).unwrap()).unwrap();
    let (here, there) =
        (number(residual, "force_peak_n"), number(&report, "dynamic.root.residual_force_peak_n"));
    assert!((here - there).abs() < 1e-9 * there.max(1.0), "{here} {there}");
}

/// A second run beside the first, as a cross-check leaves it, is laid over it; also by `--mujoco`.
#[test]
fn mujoco_beside_the_trace() {
    let place = Place::new();
    run(&place);
    std::fs::create_dir(place.at("run/mujoco")).unwrap();
    std::fs::copy(place.at("run/trace.npz"), place.at("run/mujoco/trace.npz")).unwrap();
    std::fs::copy(place.at("run/trace.npz"), place.at("other.npz")).unwrap();
    let args = ["plot", "run", "--what", "contact", "--json", "--out", "a.svg", "--force"];
    let rms =
        |v: &serde_json::Value| number(&v["figures"][0]["numbers"], "rms_difference_n.mujoco.total.vertical");
    assert_eq!(rms(&json(&place.run(&args))), 0.0);
    assert!(std::fs::read_to_string(place.at("a.svg")).unwrap().contains("MuJoCo"));
    std::fs::remove_dir_all(place.at("run/mujoco")).unwrap();
    let v = json(&place.run(&args));
    assert!(v["figures"][0]["numbers"]["rms_difference_n"].get("mujoco").is_none());
    assert_eq!(rms(&json(&place.run(&[&args[..], &["--mujoco", "other.npz"]].concat()))), 0.0);
}

/// One file, chosen joints, feet and a span; clips and scenes too.
#[test]
fn selections() {
    let place = Place::new();
    run(&place);
    let done = place.run(&["plot", "run", "--what", "torque", "--joints", "knee_l", "--out", "f/knee.png"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert_eq!(place.files("f").len(), 1, "one file, and nothing beside it");
    assert!(place.at("f/knee.png").exists());
    let svg = |args: &[&str]| {
        let done = place.run(&[&["plot", "run", "--out", "x.svg", "--force", "--what"], args].concat());
        assert_eq!(done.code, 0, "{}", done.stderr);
        std::fs::read_to_string(place.at("x.svg")).unwrap()
    };
    let knee = svg(&["torque", "--joints", "knee_l"]);
    assert!(knee.contains("knee_l") && !knee.contains("knee_r"));
    let one = svg(&["contact", "--feet", "leg_l"]);
    assert!(one.contains("leg_l") && !one.contains("leg_r"));
    let whole = svg(&["energy"]);
    assert!(whole != svg(&["energy", "--from-s", "0.1", "--to-s", "0.3"]));
    for input in [place.clip("", ""), place.scene("", "")] {
        let stem = input.file_stem().unwrap().to_str().unwrap().to_owned();
        let v = json(&place.run(&["plot", input.to_str().unwrap(), "--what", "all", "--json"]));
        assert_eq!(v["figures"].as_array().unwrap().len(), EACH.len() - 1);
        assert!(v["left_out"][0].as_str().unwrap().contains("gains"), "{v:#}");
        assert_eq!(place.files(&format!("out/{stem}/plots")).len(), 2 * (EACH.len() - 1));
    }
}

/// From where a strip is drawn: every word and an angle give a picture of their own, the same as that of the word's angle, for
/// `plot` as for `render`; what is neither is refused with all of them.
#[test]
fn views_of_a_strip() {
    let place = Place::new();
    let scene = place.scene("", "");
    let scene = scene.to_str().unwrap();
    let done = place.run(&["render", scene, "--no-plots", "--out", "run"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let strip = |view: &str| {
        let done =
            place.run(&["plot", "run", "--what", "strip", "--view", view, "--out", "x.svg", "--force"]);
        assert_eq!(done.code, 0, "{view}: {}", done.stderr);
        std::fs::read_to_string(place.at("x.svg")).unwrap()
    };
    let [front, side, between, other] = ["front", "side", "three-quarter", "-20"].map(strip);
    let all = [&front, &side, &between, &other];
    for (i, a) in all.iter().enumerate() {
        assert!(all[..i].iter().all(|b| a != b), "view {i} looks like another");
    }
    assert!(front == strip("0") && side == strip("90") && between == strip("38"));
    let drawn = |view: &str| {
        let done = place.run(&["render", scene, "--kinematic", "--view", view, "--out", "drawn"]);
        assert_eq!(done.code, 0, "{view}: {}", done.stderr);
        std::fs::read_to_string(place.at("drawn/plots/strip_edited.svg")).unwrap()
    };
    assert!(drawn("front") == drawn("0") && drawn("front") != drawn("side"));
    for command in ["plot", "render"] {
        let input = if command == "plot" { "run" } else { scene };
        let done = place.run(&[command, input, "--view", "above"]);
        assert_eq!(done.code, 2);
        for words in ["`above` is no view", "front, side, three-quarter, or degrees from -360 to 360"] {
            assert!(done.stderr.contains(words), "{words}: {}", done.stderr);
        }
    }
}

/// A lamp in its colours: `plot` draws it from the trace as `render` drew it.
#[test]
fn a_strip_keeps_the_colors_of_the_character() {
    let place = Place::new();
    let lamp = std::fs::read_to_string(support::scene("characters/lamp.ron")).unwrap();
    place.write("characters/lamp.ron", &lamp);
    let scene = r#"Scene(character: "characters/lamp.ron", rate_hz: 60, root: Pinned, settle_s: 0.1)"#;
    place.write("lamp.ron", scene);
    let done = place.run(&["render", "lamp.ron", "--out", "run"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let fills = |svg: &str| {
        let text = std::fs::read_to_string(place.at(svg)).unwrap();
        let colors = text.split("fill=\"#").skip(1).filter_map(|rest| rest.get(..6).map(str::to_owned));
        colors.collect::<std::collections::BTreeSet<String>>()
    };
    let drawn = fills("run/plots/strip_dynamic.svg");
    let done = place.run(&["plot", "run", "--what", "strip", "--out", "strip.svg"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    // 61 shades; a body without colours has those of its sides
    assert!(drawn.len() > 20 && fills("strip.svg") == drawn, "{drawn:?}");
    let gray = lamp.lines().filter(|line| !line.trim_start().starts_with("color:")).collect::<Vec<_>>();
    let gray: String = gray.join("\n");
    let mut plain = gray.clone();
    while let Some(at) = plain.find("color: \"#") {
        plain.replace_range(at..at + "color: \"#000000\",".len(), "");
    }
    place.write("characters/lamp.ron", &plain);
    let done = place.run(&["render", "lamp.ron", "--out", "gray"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(fills("gray/plots/strip_dynamic.svg") != drawn);
}

/// Without weight there is no share of it, and no ground holds anything: every figure of such a run is drawn, with numbers.
#[test]
fn a_run_without_gravity_is_drawn() {
    let place = Place::new();
    place.write("characters/human.ron", &crate::place::human());
    let scene = std::fs::read_to_string(support::shared("cases/scenes/zero_g.ron")).unwrap();
    place.write("zero_g.ron", &scene);
    let done = place.run(&["render", "zero_g.ron", "--out", "run", "--no-plots"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let done = place.run(&["plot", "run", "--json"]);
    let v = json(&done);
    assert!(v["figures"].as_array().unwrap().len() >= EACH.len() - 1, "{v:#}");
    for (name, bytes) in place.files("run/plots") {
        let text = String::from_utf8_lossy(&bytes);
        assert!(!name.ends_with(".svg") || !(text.contains("NaN") || text.contains("inf")), "{name}");
    }
    let done = place.run(&["analyze", "run", "--no-plots", "--json", "--out", "analysis"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(!done.stdout.contains("NaN"));
}

#[track_caller]
fn refused(place: &Place, args: &[&str], words: &[&str]) {
    let before = place.files("");
    let done = place.run(&[&["plot"], args].concat());
    assert_eq!(done.code, 2, "{args:?}: {}{}", done.stdout, done.stderr);
    assert_eq!(done.stdout, "");
    for word in words {
        assert!(done.stderr.contains(word), "`{word}` is not in\n{}", done.stderr);
    }
    assert!(!done.stderr.contains("panicked"), "{}", done.stderr);
    assert!(place.files("") == before, "{args:?}: files changed");
}

/// What was found, what is allowed, where; nothing is written.
#[test]
fn bad_input() {
    let place = Place::new();
    run(&place);
    let clip = place.clip("", "");
    let clip = clip.to_str().unwrap();
    refused(&place, &["missing.npz"], &["missing.npz", "cannot read"]);
    refused(&place, &["characters"], &["no trace.npz in this folder", "contrapposto render"]);
    refused(&place, &["scene.fbx"], &["scene.fbx", ".npz", ".bvh", ".ron"]);
    refused(&place, &["run", "--what", "forces"], &["forces", "contact", "residual"]);
    refused(&place, &["run", "--what", "contact,com", "--out", "a.svg"], &["a.svg", "2 figures", "a folder"]);
    refused(&place, &["run", "--what", "com", "--out", "a.pdf"], &["a.pdf", ".svg, .png"]);
    refused(&place, &["run", "--from-s", "9"], &["--from-s is 9 s", "allowed: 0 to 0.6"]);
    refused(&place, &["run", "--from-s", "0.4", "--to-s", "0.2"], &["--from-s is 0.4 s", "must be less"]);
    refused(&place, &["run", "--joints", "knee"], &["no joint `knee`", "knee_"]);
    refused(&place, &["run", "--feet", "leg_x"], &["no foot `leg_x`", "did you mean `leg_"]);
    refused(&place, &["run", "--body", "characters/human.ron"], &["--body is for clips", "run"]);
    refused(&place, &["run", "--sink-mm", "0"], &["0.01 to 100 mm"]);
    refused(&place, &["run", "--smooth", "hard"], &["auto, off, or 0.1 to 1000 Hz"]);
    refused(&place, &[clip, "--what", "gains"], &["--what gains", "contrapposto render"]);
    refused(&place, &[clip, "--mujoco", "run/trace.npz"], &["--mujoco is for traces"]);

    let whole = std::fs::read(place.at("run/trace.npz")).unwrap();
    std::fs::write(place.at("cut.npz"), &whole[..whole.len() / 2]).unwrap();
    refused(&place, &["cut.npz"], &["cut.npz", "not an .npz"]);
    let mut flipped = whole.clone();
    let name = flipped.windows(9).position(|w| w == b"torque.np").unwrap();
    flipped[name + 200] ^= 0x10;
    std::fs::write(place.at("flipped.npz"), &flipped).unwrap();
    refused(&place, &["flipped.npz"], &["flipped.npz", "`torque`"]);
    std::fs::write(place.at("clip.npz"), std::fs::read(clip).unwrap()).unwrap();
    refused(&place, &["clip.npz"], &["clip.npz", "zip of .npy arrays"]);
    refused(&place, &["run", "--mujoco", "clip.npz"], &["clip.npz", "zip of .npy arrays"]);
    // of another body
    assert_eq!(place.run(&["render", clip, "--no-plots", "--out", "other"]).code, 0);
    refused(
        &place,
        &["run", "--mujoco", "other/trace.npz"],
        &["other/trace.npz", "19 links", "kg", "allowed", "75.00 kg"],
    );
}

/// A folder that cannot be written to: exit code 1, or 2 if it is a file; earlier figures whole.
#[test]
fn a_locked_door() {
    let place = Place::new();
    run(&place);
    place.write("a-file", "earlier");
    let before = place.files("");
    for (out, code) in
        [("a-file", 2), ("a-file/below", 1), ("/proc/nowhere/out", 1), ("/proc/nowhere/out.svg", 1)]
    {
        let done = place.run(&["plot", "run", "--what", "com", "--out", out]);
        assert_eq!(done.code, code, "{out}: {}", done.stderr);
        assert!(done.stderr.starts_with("error: cannot write"), "{}", done.stderr);
    }
    assert!(place.files("") == before);
}

/// A run that diverged leaves NaN; what can be drawn is drawn, and the figure says what cannot.
#[test]
fn slow_a_run_that_diverged() {
    let place = Place::new();
    let push = "settle_s: 0.2, pushes: [Push(link: \"wrist_r\", impulse_ns: (1e6, 0, 0), start_s: 0.1)]";
    let scene = place.scene("settle_s: 0.2", push);
    assert_eq!(place.run(&["render", scene.to_str().unwrap(), "--no-plots", "--out", "run"]).code, 1);
    let done = place.run(&["plot", "run"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert_eq!(place.files("run/plots").len(), 2 * EACH.len());
}
