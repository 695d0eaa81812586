//! `tune` from end to end, small.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::place::{Done, Place, human, replaced};

const STAND: &str = r#"Scene(
    character: "characters/human.ron",
    rate_hz: 60,
    root: Free,
    settle_s: 1.0,
    tune: (
        parameters: ["pressure", "tension"],
        pushes: [(deg: 0, of_limit: 0.9), (deg: 90, of_limit: 0.5)],
        push_at_s: 0.1, after_s: 0.4, rate_hz: 120, substeps: 1,
    ),
)"#;

fn place() -> Place {
    let place = Place::new();
    place.write("characters/human.ron", &human());
    place.write("stand.ron", STAND);
    place
}

fn tune(place: &Place, args: &[&str]) -> Done {
    let mut all = vec!["tune", "stand.ron", "--directions", "0"];
    all.extend(args);
    place.run(&all)
}

fn text(place: &Place, name: &str) -> String {
    std::fs::read_to_string(place.at(name)).unwrap()
}

/// A patch, a page, every point, a report; the patch applies.
#[test]
fn slow_a_scene_is_tuned() {
    let place = place();
    let done = tune(&place, &["--evaluations", "10", "--slices", "2", "--seed", "5"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(done.stderr.contains("seed 5"), "{}", done.stderr);
    for words in [
        "stand: The cost in core is ",
        "rapier ",
        "pressure",
        "tension",
        "tracking",
        "seed 5, start scene",
        "tune.html",
    ] {
        assert!(done.stdout.contains(words), "{words}: {}", done.stdout);
    }
    let mut expected = vec!["patch.ron", "report.json", "samples.csv", "tune.html"];
    let figures: Vec<String> = ["convergence", "slices", "terms"]
        .iter()
        .flat_map(|f| ["png", "svg"].map(|kind| format!("plots/{f}.{kind}")))
        .collect();
    expected.splice(1..1, figures.iter().map(String::as_str));
    assert_eq!(place.names("out/stand-tune"), expected);
    let v: serde_json::Value = serde_json::from_str(&text(&place, "out/stand-tune/report.json")).unwrap();
    let number =
        |path: &str| v.pointer(path).and_then(serde_json::Value::as_f64).unwrap_or_else(|| panic!("{path}"));
    // the search began at the scene's values: it cannot end worse
    assert!(number("/after/cost") <= number("/before/cost"), "{v}");
    assert_eq!(v["parameters"][0]["name"], "pressure");
    assert_eq!(number("/parameters/0/was"), 0.3);
    let rows = text(&place, "out/stand-tune/samples.csv").lines().count() - 2;
    assert_eq!(number("/evaluations") as usize, rows);

    // the patch, beside the scene and in it
    let patched = replaced(STAND, "root: Free", "root: Free, patch: \"out/stand-tune/patch.ron\"");
    place.write("patched.ron", &patched);
    let report = |args: &[&str]| {
        let mut all = vec!["render", "--no-plots", "--json", "--out", "r"];
        all.extend(args);
        let done = place.run(&all);
        assert_eq!(done.code, 0, "{}", done.stderr);
        let mut v: serde_json::Value = serde_json::from_str(&done.stdout).unwrap();
        for clock in ["scene", "name"] {
            v[clock] = serde_json::Value::Null;
        }
        v["dynamic"]["realtime_factor"] = serde_json::Value::Null;
        v
    };
    let a = report(&["stand.ron", "--patch", "out/stand-tune/patch.ron"]);
    assert_eq!(a, report(&["patched.ron"]));
    if number("/parameters/0/is") != 0.3 {
        assert_ne!(a, report(&["stand.ron"]));
    }
}

/// Killed half-way, on another number of threads, a search ends with the same bytes; another search in the same
/// folder is refused.
#[test]
fn slow_a_killed_search_goes_on() {
    let place = place();
    let args = ["--evaluations", "20", "--slices", "0", "--no-plots", "--start", "random"];
    let whole = tune(&place, &[&args[..], &["--out", "whole"]].concat());
    assert_eq!(whole.code, 0, "{}", whole.stderr);

    let samples = place.at("cut/samples.csv");
    let mut child = Command::new(env!("CARGO_BIN_EXE_contrapposto"))
        .args(["tune", "stand.ron", "--directions", "0", "--out", "cut"])
        .args(args)
        .env("RAYON_NUM_THREADS", "1")
        .current_dir(place.at("."))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while !samples.exists() && begun.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(5));
    }
    let _ = child.kill();
    child.wait().unwrap();
    let known = std::fs::read_to_string(&samples).unwrap();
    assert!(text(&place, "whole/samples.csv").starts_with(&known), "{known}");
    let rest = tune(&place, &[&args[..], &["--out", "cut"]].concat());
    assert_eq!(rest.code, 0, "{}", rest.stderr);
    assert!(rest.stderr.contains("points are known"), "{}", rest.stderr);
    for file in ["samples.csv", "patch.ron", "report.json"] {
        assert_eq!(text(&place, &format!("whole/{file}")), text(&place, &format!("cut/{file}")), "{file}");
    }

    // a cost that nobody computed is not believed, nor searched on from
    let written = text(&place, "cut/samples.csv");
    let row = written.lines().nth(2).unwrap().to_owned();
    let cost = row.split(',').nth(1).unwrap();
    place.write("cut/samples.csv", &written.replacen(cost, "0.000001", 1));
    let edited = tune(&place, &[&args[..], &["--out", "cut"]].concat());
    assert_eq!(edited.code, 2, "{}", edited.stderr);
    for words in ["samples.csv", "changed"] {
        assert!(edited.stderr.contains(words), "{words}: {}", edited.stderr);
    }
    place.write("cut/samples.csv", &written);

    let before = place.files("cut");
    let other = tune(&place, &[&args[..], &["--out", "cut", "--seed", "2"]].concat());
    assert_eq!(other.code, 2);
    for words in ["is of another run", "seed=1", "seed=2", "--fresh"] {
        assert!(other.stderr.contains(words), "{words}: {}", other.stderr);
    }
    assert!(place.files("cut") == before);
}

/// Jobs of an array, merged, are the whole sweep to the byte.
#[test]
fn shards_merge() {
    let place = place();
    let grid = ["--sweep", "pressure=0.1..0.5:3", "--no-plots"];
    let sweep = |more: &[&str]| {
        let mut all = vec!["tune", "stand.ron"];
        all.extend(grid);
        all.extend(more);
        let done = place.run(&all);
        assert_eq!(done.code, 0, "{}", done.stderr);
        done
    };
    let whole = sweep(&["--out", "whole"]);
    assert!(whole.stdout.contains("3 samples costed, 3 of 3"), "{}", whole.stdout);
    for i in ["1", "2"] {
        sweep(&["--out", &format!("job-{i}"), "--shard", &format!("{i}/2")]);
    }
    let merge = |files: &[&str]| {
        let mut all = vec!["tune", "stand.ron", "--out", "merged", "--merge"];
        all.extend(files);
        place.run(&all)
    };
    let part = merge(&["job-2/sweep.csv"]);
    assert!(part.code == 0 && part.stdout.contains("1 of 3 samples; 2 are missing"), "{}", part.stdout);
    let all = merge(&["job-2/sweep.csv", "job-1/sweep.csv"]);
    assert!(all.code == 0 && all.stdout.contains("all 3 samples"), "{} {}", all.stdout, all.stderr);
    assert!(place.at("merged/plots/sweep.png").exists());
    assert_eq!(text(&place, "merged/sweep.csv"), text(&place, "whole/sweep.csv"));
}

/// Bad input exits 2 and says what is allowed; nothing is written.
#[test]
fn bad_input_is_told() {
    let place = place();
    place.write("pinned.ron", &replaced(STAND, "root: Free", "root: Pinned"));
    place.write("bad.ron", "Patch(set: {\"pressur\": (is: 1)})");
    for (args, words) in [
        (vec!["stand.ron", "--parameters", "nonsense"], "there are: tension, shift,"),
        (vec!["stand.ron", "--parameters", "presure"], "did you mean `pressure`?"),
        (vec!["stand.ron", "--sweep", "presure=0..1:3"], "did you mean `pressure`?"),
        (vec!["stand.ron", "--sweep", "pressure=0.5..0.5:3"], "the range is empty"),
        (vec!["stand.ron", "--sweep", "pressure=0..1:3", "--shard", "4/3"], "i from 1 to n"),
        (vec!["stand.ron", "--sweep", "pressure=0..1:3", "--shard", "banana"], "`banana` is no shard"),
        (vec!["stand.ron", "--shard", "1/3"], "--sweep"),
        (vec!["stand.ron", "--merge", "none.csv", "--shard", "1/3"], "--shard"),
        (vec!["stand.ron", "--merge", "none.csv", "--fresh"], "--fresh"),
        (vec!["stand.ron", "--merge", "none.csv", "--seed", "2"], "--seed"),
        (vec!["stand.ron", "--sweep", "pressure=0..1:3", "--slices", "3"], "--slices"),
        (vec!["stand.ron", "--sweep", "pressure=0..1:3", "--directions", "3"], "--directions"),
        (vec!["stand.ron", "--no-plots", "--slices", "3"], "--slices"),
        (vec!["--list", "--json"], "--list"),
        (vec!["stand.ron", "--evaluations", "0"], "allowed: a whole number from 1"),
        (vec!["stand.ron", "--merge", "none.csv"], "none.csv"),
        (vec!["stand.ron", "--merge", "bad.ron"], "bad.ron: line 1"),
        (vec!["stand.ron", "--patch", "bad.ron"], "did you mean `pressure`?"),
        (vec!["pinned.ron"], "its root is held"),
        (vec!["clip.bvh"], "allowed: a scene (.ron)"),
    ] {
        let mut all = vec!["tune"];
        all.extend(args);
        let done = place.run(&all);
        assert_eq!(done.code, 2, "{all:?}: {}", done.stderr);
        assert!(done.stderr.contains(words), "{all:?}: {}", done.stderr);
        assert!(!done.stderr.contains("panicked"), "{}", done.stderr);
    }
    assert!(!place.at("out").exists());
    let list = place.run(&["tune", "--list"]);
    assert!(list.code == 0 && list.stdout.contains("hip_reserve_m"), "{}", list.stdout);
}
