//! `push` from end to end, coarse.

use crate::place::{Done, Place, human, replaced};

const STAND: &str = r#"Scene(character: "characters/human.ron", rate_hz: 60, root: Free, settle_s: 1.0)"#;

fn place() -> Place {
    let place = Place::new();
    place.write("characters/human.ron", &human());
    place.write("stand.ron", STAND);
    place
}

fn push(place: &Place, args: &[&str], threads: &str) -> Done {
    let mut all = vec!["push", "stand.ron", "--directions", "3", "--tolerance", "30", "--rate", "120"];
    all.extend(args);
    place.run_with(&all, &[("RAYON_NUM_THREADS", threads)])
}

/// Table, report and figure; the report is what `--json` prints, on any number of threads.
#[test]
fn slow_a_map_is_written() {
    let place = place();
    place.write("out/stand-push/notes.txt", "mine");
    let done = push(&place, &[], "2");
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(done.stdout.starts_with("stand: survives "), "{}", done.stdout);
    for words in ["0.0° forward", "120.0°", "240.0°", "left/right differ by", "at pelvis", "plots/push.svg"]
    {
        assert!(done.stdout.contains(words), "{words}: {}", done.stdout);
    }
    let expected = ["notes.txt", "plots/push.png", "plots/push.svg", "report.json"];
    assert_eq!(place.names("out/stand-push"), expected);
    let report = std::fs::read_to_string(place.at("out/stand-push/report.json")).unwrap();
    let v: serde_json::Value = serde_json::from_str(&report).unwrap();
    let directions = v["directions"].as_array().unwrap();
    assert_eq!(directions.len(), 3);
    for (d, deg) in directions.iter().zip([0.0, 120.0, 240.0]) {
        assert_eq!(d["deg"], deg);
        let number = |name: &str| d[name].as_f64().unwrap_or_else(|| panic!("{name}: {d}"));
        let (survived, limit) = (number("survived_ns"), number("limit_ns"));
        // 62 to 100 % of the limit seen at 1 %
        assert!(survived > 0.4 * limit && survived < 2.0 * limit, "{d}");
        assert!((number("ratio") - survived / limit).abs() < 1e-12, "{d}");
    }
    for name in ["mean_ratio", "min_ratio", "symmetry_error_percent"] {
        assert!(v[name].is_f64(), "{name}: {v}");
    }

    let again = push(&place, &["--json", "--no-plots", "--out", "again"], "1");
    assert_eq!((again.code, again.stderr.as_str()), (0, ""));
    let mut w: serde_json::Value = serde_json::from_str(&again.stdout).unwrap();
    assert_eq!(place.names("again"), ["report.json"]);
    assert_eq!(again.stdout.as_bytes(), std::fs::read(place.at("again/report.json")).unwrap());
    assert_eq!(w["files"].as_object().unwrap().len(), 1);
    w["files"] = v["files"].clone();
    assert_eq!(w, v);
}

/// Bad input exits 2, a body that does not stand 1; nothing is written.
#[test]
fn what_cannot_be_pushed_is_told() {
    let place = place();
    place.write("pinned.ron", &replaced(STAND, "root: Free", "root: Pinned"));
    let falls = r#"root: Free, pushes: [Push(link: "chest", impulse_ns: (0, 0, 150), start_s: 0.1)]"#;
    place.write("falls.ron", &replaced(STAND, "root: Free", falls));
    for (args, code, words) in [
        (vec!["pinned.ron"], 2, "its root is pinned"),
        (vec!["none.ron"], 2, "none.ron"),
        (vec!["stand.ron", "--directions", "0"], 2, "allowed: a whole number from 1 to 360"),
        (vec!["stand.ron", "--tolerance", "-1"], 2, "allowed: 0.01 to 50 %"),
        (vec!["falls.ron"], 1, "without any push of the map, the body falls"),
    ] {
        let mut all = vec!["push"];
        all.extend(args);
        let done = place.run(&all);
        assert_eq!(done.code, code, "{all:?}: {}", done.stderr);
        assert!(done.stderr.contains(words), "{all:?}: {}", done.stderr);
    }
    assert!(!place.at("out").exists());
}
