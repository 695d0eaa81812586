//! Models of the zoo against MuJoCo's own inverse dynamics (`shared/models/reference_inverse_dynamics.json`).

use std::path::PathBuf;

use dynamics::import::{ImportOptions, Imported, mujoco_layout, open};
use dynamics::{Model, State};

use serde_json::Value;

const MODELS: [&str; 6] = [
    "dm_control/humanoid.xml",
    "dm_control/humanoid_CMU.xml",
    "dm_control/quadruped.xml",
    "dm_control/walker.xml",
    "dm_control/manipulator.xml",
    "pinocchio/simple_humanoid.urdf",
];

fn shared() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/models"))
}

fn table() -> Value {
    let text = std::fs::read_to_string(shared().join("reference_inverse_dynamics.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn zoo(name: &str) -> Imported {
    open(&shared().join(name), &ImportOptions { dynamics_only: true }).unwrap_or_else(|e| panic!("{e}"))
}

/// Worst `max|Δτ| / max|τ|` over the states of the table.
fn tau_error(imported: &Imported, reference: &Value) -> f64 {
    let model = Model::new(&imported.character, imported.gravity);
    let mut state = State::new(&model);
    let mut worst = 0.0_f64;
    for s in reference["states"].as_array().unwrap() {
        let (qpos, qvel, qacc) = (numbers(&s["qpos"]), numbers(&s["qvel"]), numbers(&s["qacc"]));
        let (q, v, vd) = mujoco_layout::to_ours(imported, &qpos, &qvel, &qacc);
        let mut tau = vec![0.0; model.nv()];
        state.update(&model, &q, &v);
        state.inverse_dynamics(&model, &v, &vd, &[], &mut tau);
        let ours = mujoco_layout::tau_to_mujoco(imported, &q, &tau);
        let theirs = numbers(&s["tau"]);
        let scale = theirs.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let error = ours.iter().zip(&theirs).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
        worst = worst.max(error / scale);
    }
    worst
}

/// τ = M v̇ + c agrees with MuJoCo at every state of every model.
#[test]
fn inverse_dynamics_is_mujocos() {
    let table = table();
    for name in MODELS {
        let imported = zoo(name);
        let error = tau_error(&imported, &table["models"][name]);
        println!("{name}: {error:e}");
        assert!(error <= 1e-10, "{name}: {error}");
    }
}
