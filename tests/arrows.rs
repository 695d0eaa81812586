//! The arrows of the architecture (DESIGN §2), from `cargo metadata`.
//!
//! A crate uses only what its row of the table allows, always from rows above its own; only `sim` names
//! rapier, only `plots` plotters, only `programs` rhai, and all share one nalgebra.

use std::collections::BTreeMap;

use cargo_metadata::{Metadata, MetadataCommand, Package};

/// The folders of the workspace that a folder may use, of those above it.
enum May {
    /// These.
    Use(&'static [&'static str]),
    /// All but these.
    UseAllBut(&'static [&'static str]),
}
use May::{Use, UseAllBut};

/// Folder, row, and what it may use.
const TABLE: [(&str, usize, May); 20] = [
    ("motion", 0, Use(&[])),
    ("learn", 0, Use(&[])),
    ("bodies", 1, Use(&["motion"])),
    ("edits", 1, Use(&["motion", "learn"])),
    ("dynamics", 2, Use(&["motion", "bodies"])),
    ("formats", 3, Use(&["motion", "bodies", "dynamics", "learn", "edits"])),
    ("controllers", 3, Use(&["motion", "bodies", "dynamics"])),
    ("retarget", 3, Use(&["motion", "learn", "bodies", "dynamics"])),
    ("plots", 3, Use(&["motion", "bodies", "dynamics"])),
    ("programs", 4, Use(&["motion", "edits", "dynamics", "controllers"])),
    ("sim", 4, Use(&["motion", "bodies", "dynamics", "controllers"])),
    ("scenes", 5, Use(&["motion", "bodies", "dynamics", "edits", "controllers", "retarget"])),
    ("takes", 6, UseAllBut(&[])),
    ("studies", 7, UseAllBut(&[])),
    ("crosscheck", 8, UseAllBut(&["learn", "edits", "retarget", "programs"])),
    ("cli", 9, DOOR),
    ("studio", 9, DOOR),
    ("python", 9, DOOR),
    ("readers", 10, Use(&["takes", "studies", "scenes", "controllers", "formats", "motion"])),
    ("tests", 10, UseAllBut(&["studio", "python"])),
];
const DOOR: May = Use(&["crosscheck", "studies", "takes", "plots", "formats", "motion"]);
/// What the tests, examples and benches of a crate may use besides: development dependencies.
const FOR_TESTS: [(&str, &[&str]); 2] = [("retarget", &["formats"]), ("programs", &["bodies", "sim"])];
/// What the tests of every crate may use, and nothing else: where data lie. It uses none of them.
const SUPPORT: &str = "support";
/// A crate that is for tests alone, and so may use [`SUPPORT`] outside its own.
const READERS: &str = "readers";

/// The members of the workspace, without their dependencies: nothing has to be downloaded to read them.
fn metadata() -> Metadata {
    MetadataCommand::new()
        .manifest_path(concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml"))
        .no_deps()
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

/// Folders a member names as dependencies, and whether only its tests and benches use them.
fn used(package: &Package) -> Vec<(String, bool)> {
    let folder = |d: &cargo_metadata::Dependency| d.path.as_ref().map(|p| p.file_name().unwrap().to_string());
    let used = |d: &cargo_metadata::Dependency| {
        Some((folder(d)?, d.kind == cargo_metadata::DependencyKind::Development))
    };
    package.dependencies.iter().filter_map(used).collect()
}

/// What the table has against `folder` using `other`; `None` when nothing.
fn fault(folder: &str, other: &str) -> Option<String> {
    let row = |name: &str| TABLE.iter().find(|(f, _, _)| *f == name);
    let Some((_, own, allowed)) = row(folder) else { return Some(format!("`{folder}` has no row")) };
    let Some((_, below, _)) = row(other) else { return Some(format!("`{other}` has no row")) };
    let may = match allowed {
        Use(these) => these.contains(&other),
        UseAllBut(these) => !these.contains(&other),
    };
    if !may {
        return Some(format!("`{folder}` may not use `{other}`"));
    }
    (below >= own).then(|| format!("`{other}` is not above `{folder}` in the table"))
}

#[test]
fn arrows_point_down() {
    let metadata = metadata();
    let members = members(&metadata);
    assert!(members.len() >= 9, "{:?}", members.keys());
    let (mut arrows, mut faults) = (0, Vec::new());
    for (folder, package) in &members {
        if folder == SUPPORT {
            assert_eq!(used(package), []);
            continue;
        }
        assert!(TABLE.iter().any(|(f, _, _)| f == folder), "`{folder}` has no row");
        for (other, for_tests) in used(package) {
            let granted = FOR_TESTS.iter().any(|(f, may)| f == folder && may.contains(&other.as_str()));
            let support = other == SUPPORT && (for_tests || folder == READERS);
            if !(for_tests && granted || support) {
                faults.extend(fault(folder, &other));
            }
            arrows += 1;
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(arrows >= 60, "{arrows}: paths are not read");
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
    assert_eq!(users("parry"), ["sim"]);
    assert_eq!(users("plotters"), ["plots"]);
    assert_eq!(users("rhai"), ["programs"]);
}

/// Vectors of different nalgebras are different types. The lock file names every package once a version.
#[test]
fn there_is_one_nalgebra() {
    let lock = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.lock")).unwrap();
    assert_eq!(lock.lines().filter(|l| *l == "name = \"nalgebra\"").count(), 1);
}
