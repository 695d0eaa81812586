//! `docs/REPORT.md` names every field of the report.

use std::collections::BTreeSet;

use crate::place::Place;

/// Paths of all fields of a value: `dynamic.root.mode`, `dynamic.sagging[].joint`.
pub fn paths(value: &serde_json::Value, at: &str, found: &mut BTreeSet<String>) {
    match value {
        serde_json::Value::Object(fields) if at != "files" => {
            for (name, value) in fields {
                let path = if at.is_empty() { name.clone() } else { format!("{at}.{name}") };
                paths(value, &path, found);
            }
        }
        serde_json::Value::Array(items) if !items.is_empty() => {
            items.iter().for_each(|item| paths(item, &format!("{at}[]"), found));
        }
        serde_json::Value::Array(_) => {
            found.insert(format!("{at}[]"));
        }
        _ => {
            found.insert(at.to_owned());
        }
    }
}

/// Both ways: no field without its line in the document, no line without its field. The slack scene
/// sags, is pushed over with a load in its hand, so that lists are not empty; the clip has what only clips have.
#[test]
fn slow_the_document_names_every_field() {
    let place = Place::new();
    let mut fields = BTreeSet::new();
    let clip = place.clip("", "");
    let scene = place.scene(
        "settle_s: 0.2",
        "settle_s: 1.5, physics: (tension: 0.05),
        world: (ground: Plane(friction: 0.8, tilts: [Tilt(start_s: 0.1, duration_s: 0.5, tilt_deg: 2)])),
        reactive: [Gaze(at_m: (0, 1, 3))],
        carried: [Carried(link: \"wrist_r\", mass_kg: 1)],
        pushes: [Push(link: \"chest\", impulse_ns: (0, 0, 400), start_s: 0.1)]",
    );
    // an assisted root has a budget
    let walk = support::shared("mocap/bvh/16_16.bvh");
    // a walk that looks ahead says what it foresaw
    let ahead = ["--foresight", "0.1,10", "--span", "0..0.3"];
    for (input, root, more) in [
        (scene.clone(), "free", &[][..]),
        (scene, "assisted", &[]),
        (clip, "pinned", &[]),
        (walk, "free", &ahead),
    ] {
        let done = place.render(&input, &[&["--json", "--root", root], more].concat());
        assert_eq!(done.code, 0, "{}", done.stderr);
        let report: serde_json::Value = serde_json::from_str(&done.stdout).unwrap();
        paths(&report, "", &mut fields);
    }
    // empty lists of the clip's run
    for list in [
        "dynamic.sagging[]",
        "dynamic.verdict.reasons[]",
        "dynamic.leg_tension[]",
        "dynamic.gazes[]",
        "disturbances.pushes[]",
        "disturbances.ground_tilts[]",
        "disturbances.carried[]",
    ] {
        fields.remove(list);
    }
    let document = std::fs::read_to_string(support::root().join("docs/REPORT.md")).unwrap();
    let named: BTreeSet<String> = document
        .lines()
        .filter_map(|line| line.strip_prefix("| `")?.split_once('`'))
        .map(|(path, _)| path.to_owned())
        .collect();
    let (missing, stale): (Vec<_>, Vec<_>) =
        (fields.difference(&named).collect(), named.difference(&fields).collect());
    assert!(missing.is_empty(), "not in docs/REPORT.md: {missing:?}");
    assert!(stale.is_empty(), "in docs/REPORT.md, not in a report: {stale:?}");
}
