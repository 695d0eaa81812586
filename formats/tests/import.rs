//! Small models of our own against what MuJoCo makes of them (`golden/models.json`, `golden/make_models_golden.py`).

use std::path::{Path, PathBuf};

use bodies::Character;
use dynamics::{Model, State};
use formats::mjcf;
use formats::model::{ImportOptions, Imported, open};
use motion::{Joint, Limits, Skeleton, Vec3};
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
    assert_eq!(all.len(), 6);
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

/// A character written as MJCF and read again is the same body: names, masses, mass matrix, inverse dynamics.
#[test]
fn what_is_written_is_read_again() {
    let (human, _) = bodies::anthropometry::human::human();
    let gravity = Vec3::new(0.0, -9.81, 0.0);
    let text = mjcf::write(&human, &mjcf::MjcfOptions { gravity, ..Default::default() }).unwrap().text;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("human.xml");
    std::fs::write(&path, text).unwrap();
    let back = open(&path, &ImportOptions { dynamics_only: true }).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(back.gravity, gravity);
    let (a, b) = (&human.skeleton, &back.character.skeleton);
    assert_eq!(a.nv(), b.nv());
    // the file's order is depth first, ours need not be
    let link = |i: usize| b.link(&a.links()[i].name).unwrap();
    let (mut q, mut v, mut vd) = (human.rest.clone(), vec![0.0; a.nv()], vec![0.0; a.nv()]);
    for i in 0..a.nv() {
        v[i] = 3.0 * (1.3 * i as f64 + 0.4).sin();
        vd[i] = 20.0 * (0.7 * i as f64 + 0.2).cos();
    }
    a.integrate(&mut q, &v, 0.2);
    let sorted = |x: &[f64], at: &dyn Fn(&Skeleton, usize) -> usize, n: &dyn Fn(&Joint) -> usize| {
        let mut out = vec![0.0; x.len()];
        for i in 0..a.links().len() {
            let (from, to) = (at(a, i), at(b, link(i)));
            let n = n(&a.links()[i].joint);
            out[to..to + n].copy_from_slice(&x[from..from + n]);
        }
        out
    };
    let rates = |x: &[f64]| sorted(x, &|s, i| s.v_at(i), &|j| j.nv());
    let torques = |character: &Character, q: &[f64], v: &[f64], vd: &[f64]| {
        let model = Model::new(character, gravity);
        let mut state = State::new(&model);
        let mut tau = vec![0.0; v.len()];
        state.update(&model, q, v);
        state.inverse_dynamics(&model, v, vd, &[], &mut tau);
        tau
    };
    let ours = rates(&torques(&human, &q, &v, &vd));
    let q = sorted(&q, &|s, i| s.q_at(i), &|j| j.nq());
    let theirs = torques(&back.character, &q, &rates(&v), &rates(&vd));
    let scale = ours.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    for (x, y) in ours.iter().zip(&theirs) {
        assert!((x - y).abs() < 1e-13 * scale, "{x} {y}"); // 0 seen: every number is written to be read back
    }
    for (i, body) in human.bodies.iter().enumerate() {
        assert_eq!(body.shapes.len(), back.character.bodies[link(i)].shapes.len(), "{}", a.links()[i].name);
    }
}
