//! The arrows of the architecture (DESIGN §2), from `cargo metadata`.
//!
//! A crate uses only what its row of the table allows, always from rows above its own; only `sim` names
//! rapier, only `plots` plotters, and all share one nalgebra.

use std::collections::BTreeMap;

use cargo_metadata::{Metadata, MetadataCommand, Package};

/// Folder, row, and the folders of the workspace it may use.
const TABLE: [(&str, usize, &[&str]); 14] = [
    ("motion", 0, &[]),
    ("learn", 0, &[]),
    ("dynamics", 1, &["motion"]),
    ("edits", 1, &["motion", "learn"]),
    ("controllers", 2, &["motion", "dynamics"]),
    ("retarget", 2, &["motion", "learn", "dynamics"]),
    ("plots", 2, &["motion", "dynamics"]),
    ("sim", 3, &["motion", "dynamics", "controllers"]),
    ("scenes", 4, ALL_BELOW_SCENES),
    ("crosscheck", 5, ALL_BELOW_CROSSCHECK),
    ("cli", 6, &["crosscheck", "scenes", "plots", "motion"]),
    ("studio", 6, &["scenes", "plots", "motion"]),
    ("python", 6, &["scenes", "plots", "motion"]),
    ("tests", 7, ALL_BELOW_TESTS),
];
const ALL_BELOW_SCENES: &[&str] =
    &["motion", "learn", "dynamics", "edits", "controllers", "retarget", "plots", "sim"];
const ALL_BELOW_CROSSCHECK: &[&str] =
    &["motion", "learn", "dynamics", "edits", "controllers", "retarget", "plots", "sim", "scenes"];
const ALL_BELOW_TESTS: &[&str] = &[
    "motion",
    "learn",
    "dynamics",
    "edits",
    "controllers",
    "retarget",
    "plots",
    "sim",
    "scenes",
    "crosscheck",
    "cli",
];

fn metadata() -> Metadata {
    MetadataCommand::new()
        .manifest_path(concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml"))
        .other_options(["--offline", "--locked"].map(String::from))
        .exec()
        .unwrap()
}

/// Members of the workspace by folder.
fn members(metadata: &Metadata) -> BTreeMap<String, &Package> {
    metadata
        .workspace_packages()
        .into_iter()
        .map(|p| (p.manifest_path.parent().unwrap().file_name().unwrap().to_string(), p))
        .collect()
}

/// Folders a member names as dependencies of any kind: normal, build or development.
fn used(package: &Package) -> Vec<String> {
    let path = |d: &cargo_metadata::Dependency| d.path.as_ref().map(|p| p.file_name().unwrap().to_string());
    package.dependencies.iter().filter_map(path).collect()
}

/// What the table has against `folder` using `other`; `None` when nothing.
fn fault(folder: &str, other: &str) -> Option<String> {
    let row = |name: &str| TABLE.iter().find(|(f, _, _)| *f == name);
    let Some((_, own, allowed)) = row(folder) else { return Some(format!("`{folder}` has no row")) };
    let Some((_, below, _)) = row(other) else { return Some(format!("`{other}` has no row")) };
    if !allowed.contains(&other) {
        return Some(format!("`{folder}` may not use `{other}`"));
    }
    (below >= own).then(|| format!("`{other}` is not above `{folder}` in the table"))
}

#[test]
fn arrows_point_down() {
    let metadata = metadata();
    let members = members(&metadata);
    assert!(members.len() >= 9, "{:?}", members.keys());
    let mut arrows = 0;
    for (folder, package) in &members {
        assert!(TABLE.iter().any(|(f, _, _)| f == folder), "`{folder}` has no row");
        for other in used(package) {
            assert_eq!(fault(folder, &other), None);
            arrows += 1;
        }
    }
    assert!(arrows >= 20, "{arrows}: paths are not read");
}

/// The check can fail: upwards, sideways and unknown.
#[test]
fn wrong_arrows_are_found() {
    for (from, to) in [("motion", "sim"), ("edits", "dynamics"), ("plots", "controllers"), ("sim", "physics")]
    {
        assert!(fault(from, to).is_some(), "{from} → {to}");
    }
    assert_eq!(fault("sim", "controllers"), None);
}

#[test]
fn engines_and_pictures_have_one_door() {
    let metadata = metadata();
    let users = |start: &str| -> Vec<String> {
        members(&metadata)
            .into_iter()
            .filter(|(_, p)| p.dependencies.iter().any(|d| d.name.starts_with(start)))
            .map(|(folder, _)| folder)
            .collect()
    };
    assert_eq!(users("rapier"), ["sim"]);
    assert_eq!(users("parry"), [""; 0]);
    assert_eq!(users("plotters"), ["plots"]);
}

/// Vectors of different nalgebras are different types.
#[test]
fn there_is_one_nalgebra() {
    let metadata = metadata();
    let versions: Vec<_> =
        metadata.packages.iter().filter(|p| p.name.as_str() == "nalgebra").map(|p| &p.version).collect();
    assert_eq!(versions.len(), 1, "{versions:?}");
}
