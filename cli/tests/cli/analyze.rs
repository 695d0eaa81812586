//! `analyze` from end to end.

use std::collections::BTreeSet;

use crate::place::Place;
use crate::report::paths;

fn number(v: &serde_json::Value, path: &str) -> f64 {
    let found = path.split('.').fold(v, |v, key| &v[key]);
    found.as_f64().unwrap_or_else(|| panic!("{path} in {v:#}"))
}

const FILES: [&str; 5] = ["analysis.csv", "analysis.npz", "ground_forces.mot", "report.json", "torques.mot"];

/// A standing clip: files, a summary that answers, numbers that agree with the body's weight.
#[test]
fn slow_a_clip() {
    let place = Place::new();
    let clip = place.clip("", "");
    let done = place.run(&["analyze", clip.to_str().unwrap()]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    for word in ["plausible", "smoothing", "residual", "required", "friction", "support", "hardest", "N·m/kg"]
    {
        assert!(done.stdout.contains(word), "`{word}` is not in\n{}", done.stdout);
    }
    let names = place.names("out/clip-analysis");
    let tables: Vec<&String> = names.iter().filter(|n| !n.starts_with("plots/")).collect();
    assert_eq!(tables, FILES);
    assert_eq!(names.len() - tables.len(), 16);
    let r = place.report("out/clip-analysis");
    for file in r["files"].as_object().unwrap().values() {
        assert!(place.at("out/clip-analysis").join(file.as_str().unwrap()).is_file(), "{file}");
    }
    assert_eq!(r["files"].as_object().unwrap().len(), names.len());
    assert_eq!(r["source"], "clip");
    // it starts and ends at rest
    assert!((number(&r, "required.vertical_mean_percent_bw") - 100.0).abs() < 5.0, "{r:#}");
    let joints = r["joints"].as_array().unwrap();
    let peaks: Vec<f64> = joints.iter().map(|j| number(j, "peak_nm")).collect();
    assert!(peaks.windows(2).all(|p| p[0] >= p[1]) && peaks[0] > 1.0, "{peaks:?}");
    let csv = std::fs::read_to_string(place.at("out/clip-analysis/analysis.csv")).unwrap();
    assert_eq!(csv.lines().count() as f64, number(&r, "frames") + 1.0);
}

/// Where there is no ground none is found: feet have no depth under it, and every frame is in flight.
#[test]
fn a_run_without_ground_has_none() {
    let place = Place::new();
    let ron = "Scene(character: \"characters/human.ron\", rate_hz: 60, settle_s: 0.3, world: (ground: None))";
    place.scene("", "");
    let scene = place.write("falls.ron", ron);
    let done = place.run(&["render", scene.to_str().unwrap(), "--no-plots", "--out", "run"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(done.stdout.contains("no ground under its feet"), "{}", done.stdout);
    let run = place.report("run");
    assert!(run["kinematic"]["feet"].is_null() && run["dynamic"]["feet"].is_null(), "{run:#}");
    for input in ["run", "falls.ron"] {
        let done = place.run(&["analyze", input, "--no-plots", "--json", "--out", "a"]);
        assert_eq!((done.code, done.stderr.as_str()), (0, ""));
        let r: serde_json::Value = serde_json::from_str(&done.stdout).unwrap();
        assert!(r["ground"]["height_m"].is_null() && r["ground"]["feet"].is_null(), "{input}: {r:#}");
        assert_eq!(number(&r, "flight.share"), 1.0, "{input}: {r:#}");
    }
}

/// What a run recorded is plausible: its forces come from joints and ground alone. Inverse dynamics finds
/// the torques that the muscles gave.
#[test]
fn a_run_is_plausible() {
    let place = Place::new();
    let scene = place.scene("", "");
    let done = place.run(&["render", scene.to_str().unwrap(), "--no-plots", "--out", "run"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let done = place.run(&["analyze", "run", "--no-plots", "--json", "--out", "a"]);
    assert_eq!((done.code, done.stderr.as_str()), (0, ""));
    assert_eq!(done.stdout.as_bytes(), std::fs::read(place.at("a/report.json")).unwrap());
    let r: serde_json::Value = serde_json::from_str(&done.stdout).unwrap();
    assert_eq!((&r["source"], &r["plausible"]), (&"trace".into(), &"good".into()), "{r:#}");
    assert_eq!(r["smoothing"]["smoothed"], false);
    assert_eq!(number(&r, "friction.frames") + number(&r, "flight.frames"), 0.0);
    // a clip of the same motion is not recorded by an engine: its scene says the same of its ground
    let scene = report_of(&place, &["scene.ron"]);
    assert_eq!(scene["source"], "scene");
    assert_eq!(number(&scene, "ground.height_m"), number(&r, "ground.height_m"));
}

fn report_of(place: &Place, args: &[&str]) -> serde_json::Value {
    let done = place.run(&[&["analyze", "--no-plots", "--json", "--out", "b"], args].concat());
    assert_eq!((done.code, done.stderr.as_str()), (0, ""));
    serde_json::from_str(&done.stdout).unwrap()
}

/// Options change what they say they change.
#[test]
fn options() {
    let place = Place::new();
    let clip = place.clip("", "");
    let clip = clip.to_str().unwrap();
    let r = report_of(&place, &[clip, "--smooth", "3", "--friction", "0.0001"]);
    assert_eq!(number(&r, "smoothing.cutoff_hz"), 3.0);
    assert_eq!(number(&r, "friction.coefficient"), 0.0001);
    assert!(number(&r, "friction.frames") > 0.0, "nothing leans on ice: {r:#}");
    let off = report_of(&place, &[clip, "--smooth", "off"]);
    assert_eq!(off["smoothing"]["cutoff_hz"], serde_json::Value::Null);
    assert_eq!(number(&off, "smoothing.position_rms_mm"), 0.0);
    assert!(number(&off, "friction.frames") < number(&r, "friction.frames"));
    // the body written is the body guessed
    assert_eq!(place.run(&["inspect", clip, "--write-body", "body.ron"]).code, 0);
    let body = report_of(&place, &[clip, "--smooth", "off", "--body", "body.ron"]);
    let (a, b) = (number(&off, "required.vertical_mean_n"), number(&body, "required.vertical_mean_n"));
    assert!((a / b - 1.0).abs() < 1e-3, "{a} {b}"); // masses are written with few digits
    let done = place.run(&["analyze", clip, "--format", "csv", "--no-plots", "--out", "c"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert_eq!(place.names("c"), ["analysis.csv", "report.json"]);
}

/// Same input, same bytes; a new analysis replaces the old one and leaves other files.
#[test]
fn slow_the_same_bytes() {
    let place = Place::new();
    let clip = place.clip("", "");
    let run = |out: &str, more: &[&str]| {
        let done = place.run(&[&["analyze", clip.to_str().unwrap(), "--out", out], more].concat());
        assert_eq!(done.code, 0, "{}", done.stderr);
    };
    run("a", &[]);
    run("b", &[]);
    assert!(place.files("a") == place.files("b"));
    place.write("b/notes.txt", "mine");
    run("b", &["--no-plots", "--format", "npz"]);
    assert_eq!(place.names("b"), ["analysis.npz", "notes.txt", "report.json"]);
}

/// Bad input: exit code 2, words, and the earlier analysis untouched.
#[test]
fn bad_input() {
    let place = Place::new();
    let clip = place.clip("", "");
    let clip = clip.to_str().unwrap();
    place.earlier_run("out/clip-analysis", &["report.json"]);
    place.write("one.bvh", &{
        let text = std::fs::read_to_string(clip).unwrap();
        let (head, motion) = text.split_once("MOTION").unwrap();
        let rows: Vec<&str> = motion.lines().skip(1).collect();
        let rows = [&["Frames: 2"], &rows[1..4]].concat().join("\n");
        format!("{head}MOTION\n{rows}\n")
    });
    let before = place.files("");
    for (args, words) in [
        (&["missing.bvh"][..], &["cannot read", "missing.bvh"][..]),
        (&["walk.fbx"], &["walk.fbx", ".bvh"]),
        (&["one.bvh"], &["2 frames", "at least 3"]),
        (&["characters"], &["no trace.npz"]),
        (&[clip, "--friction", "-1"], &["allowed: 0 to 10"]),
        (&[clip, "--smooth", "0"], &["auto, off, or 0.1 to 1000 Hz"]),
        (&[clip, "--format", "xls"], &["xls", "csv", "mot", "npz"]),
        (&[clip, "--body", "nobody.ron"], &["cannot read", "nobody.ron"]),
        (&["scene.ron", "--units", "0.01"], &["--units is for clips", "scene.ron"]),
    ] {
        let done = place.run(&[&["analyze"], args].concat());
        assert_eq!((done.code, done.stdout.as_str()), (2, ""), "{args:?}: {}", done.stderr);
        for word in words {
            assert!(done.stderr.contains(word), "`{word}` is not in\n{}", done.stderr);
        }
        assert!(place.files("") == before, "{args:?}: files changed");
    }
    let file = place.write("a-file", "earlier");
    let done = place.run(&["analyze", clip, "--out", "a-file"]);
    assert_eq!(done.code, 2, "{}", done.stderr);
    assert!(done.stderr.contains("it is a file, not a folder; allowed"), "{}", done.stderr);
    assert_eq!(std::fs::read_to_string(file).unwrap(), "earlier");
}

/// `docs/ANALYSIS.md` names every field of the report, and no other.
#[test]
fn the_document_names_every_field() {
    let place = Place::new();
    let clip = place.clip("", "");
    let mut fields = BTreeSet::new();
    paths(&report_of(&place, &[clip.to_str().unwrap(), "--friction", "0.001"]), "", &mut fields);
    let document = std::fs::read_to_string(support::root().join("docs/ANALYSIS.md")).unwrap();
    let named: BTreeSet<String> = document
        .lines()
        .filter_map(|line| line.strip_prefix("| `")?.split_once('`'))
        .map(|(path, _)| path.to_owned())
        .collect();
    let spans = |of: &BTreeSet<String>| -> BTreeSet<String> {
        // spans of every kind have the same fields; a list may be empty
        of.iter().map(|f| f.split(".spans[]").next().unwrap_or(f).to_owned()).collect()
    };
    let (fields, named) = (spans(&fields), spans(&named));
    let (missing, stale): (Vec<_>, Vec<_>) =
        (fields.difference(&named).collect(), named.difference(&fields).collect());
    assert!(missing.is_empty(), "not in docs/ANALYSIS.md: {missing:?}");
    assert!(stale.is_empty(), "in docs/ANALYSIS.md, not in a report: {stale:?}");
}
