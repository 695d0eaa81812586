//! Small models of our own against what MuJoCo makes of them (`golden/models.json`, `golden/make_models_golden.py`).

use std::path::{Path, PathBuf};

use dynamics::import::{ImportOptions, Imported, open};
use motion::Limits;
use serde_json::Value;

mod mujoco;
use mujoco::{body_errors, mass_matrix_error, numbers, tau_error, vector, whole_errors};

fn models() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/models"))
}

fn table() -> Value {
    let text = std::fs::read_to_string(models().join("../golden/models.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn read(path: &Path) -> Imported {
    open(path, &ImportOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn each(mut f: impl FnMut(&str, &Imported, &Value)) {
    let table = table();
    let all = table["models"].as_object().unwrap();
    assert_eq!(all.len(), 5);
    for (name, reference) in all {
        f(name, &read(&models().join(name)), reference);
    }
}

/// Inverse dynamics, mass matrix and centre of mass in random states.
#[test]
fn dynamics_are_mujocos() {
    each(|name, imported, reference| {
        let (tau, m) = (tau_error(imported, reference), mass_matrix_error(imported, reference));
        assert!(tau < 1e-12 && m < 1e-12, "{name}: τ {tau}, M {m}"); // 4e-15 seen
        let [com, _] = whole_errors(imported, reference);
        assert!(com < 1e-13, "{name}: {com}"); // 3e-16 seen
    });
}

/// Masses and inertias: partial sizes, `fromto`, classes, explicit inertias, groups, total mass.
#[test]
fn bodies_are_mujocos() {
    each(|name, imported, reference| {
        let [mass, com, inertia] = body_errors(imported, reference, name.ends_with("urdf"));
        assert!(mass < 1e-12 && com < 1e-12 && inertia < 1e-12, "{name}: {mass} {com} {inertia}"); // 3e-15 seen
    });
}

/// Rest pose, limits and gravity.
#[test]
fn references_limits_and_gravity_are_mujocos() {
    each(|name, imported, reference| {
        for (a, b) in imported.character.rest.iter().zip(numbers(&reference["qpos0"])) {
            assert!((a - b).abs() < 1e-15, "{name}: {a} {b}");
        }
        let gravity = imported.ours_from_file * vector(&reference["gravity"]);
        assert!((gravity - imported.gravity).amax() < 1e-14, "{name}: {gravity}");
        assert_eq!((imported.gravity.x, imported.gravity.z), (0.0, 0.0));
        for (ours, theirs) in imported.joints.iter().zip(reference["joints"].as_array().unwrap()) {
            let limits = match imported.character.skeleton.links()[ours.link].limits {
                Some(Limits::Axis(r)) => Some((r.lo, r.hi)),
                _ => None,
            };
            assert_eq!(limits.is_some(), theirs["limited"].as_bool().unwrap(), "{name}: {}", ours.name);
            if let Some((lo, hi)) = limits {
                let range = numbers(&theirs["range"]);
                assert!((lo - range[0]).abs() + (hi - range[1]).abs() < 1e-15, "{name}: {}", ours.name);
            }
        }
    });
}
