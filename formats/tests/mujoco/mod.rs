//! Comparison of an imported model with what MuJoCo made of the same file.
//!
//! Tables have, per model: `bodies` and `joints` as compiled, and `states` with `qpos qvel qacc tau`, in MuJoCo's
//! conventions.

#![allow(dead_code)] // each test file uses its part

use dynamics::{Model, State};
use formats::model::Imported;
use formats::mujoco_layout::Layout;
use motion::{Joint, Quat, Vec3};
use nalgebra::{DMatrix, Matrix3, Quaternion};
use serde_json::Value;

pub fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

pub fn vector(v: &Value) -> Vec3 {
    Vec3::from_column_slice(&numbers(v))
}

/// MuJoCo's pose as ours.
pub fn pose(layout: &Layout, qpos: &[f64]) -> Vec<f64> {
    let mut q = vec![0.0; layout.ours().0];
    layout.pose_back(qpos, &mut q);
    q
}

/// MuJoCo's velocity, acceleration or force as ours.
pub fn ours(layout: &Layout, q: &[f64], theirs: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; layout.ours().1];
    layout.tangent_back(q, theirs, &mut out);
    out
}

/// Our velocity, acceleration or force as MuJoCo's.
pub fn theirs(layout: &Layout, q: &[f64], ours: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; layout.nv];
    layout.tangent(q, ours, &mut out);
    out
}

fn largest(x: impl IntoIterator<Item = f64>) -> f64 {
    x.into_iter().fold(0.0, |m, x| if x.is_nan() { f64::NAN } else { m.max(x.abs()) })
}

/// Worst `max|Δτ| / max|τ|` over the states.
pub fn tau_error(imported: &Imported, reference: &Value) -> f64 {
    let layout = imported.layout();
    let model = Model::new(&imported.character, imported.gravity);
    let mut state = State::new(&model);
    let errors = reference["states"].as_array().unwrap().iter().map(|s| {
        let (qpos, qvel, qacc) = (numbers(&s["qpos"]), numbers(&s["qvel"]), numbers(&s["qacc"]));
        let q = pose(&layout, &qpos);
        let (v, vd) = (ours(&layout, &q, &qvel), ours(&layout, &q, &qacc));
        let mut tau = vec![0.0; model.nv()];
        state.update(&model, &q, &v);
        state.inverse_dynamics(&model, &v, &vd, &[], &mut tau);
        let found = theirs(&layout, &q, &tau);
        let expected = numbers(&s["tau"]);
        largest(found.iter().zip(&expected).map(|(a, b)| a - b)) / largest(expected)
    });
    largest(errors)
}

/// Worst `max|ΔM| / max|M|` over the states, `M` along MuJoCo's axes.
pub fn mass_matrix_error(imported: &Imported, reference: &Value) -> f64 {
    let layout = imported.layout();
    let model = Model::new(&imported.character, imported.gravity);
    let mut state = State::new(&model);
    let n = model.nv();
    let mut m = DMatrix::zeros(n, n);
    let errors = reference["states"].as_array().unwrap().iter().map(|s| {
        let q = pose(&layout, &numbers(&s["qpos"]));
        state.update(&model, &q, &vec![0.0; n]);
        state.mass_matrix(&model, &mut m);
        let expected: Vec<Vec<f64>> = s["mass_matrix"].as_array().unwrap().iter().map(numbers).collect();
        let mut error = 0.0_f64;
        for k in 0..n {
            let mut unit = vec![0.0; n];
            unit[k] = 1.0;
            let column = &m * DMatrix::from_vec(n, 1, ours(&layout, &q, &unit));
            let found = theirs(&layout, &q, column.as_slice());
            error = error.max(largest((0..n).map(|i| found[i] - expected[i][k])));
        }
        error / largest(expected.into_iter().flatten())
    });
    largest(errors)
}

/// Worst relative error of the masses, absolute of the centres of mass (m), and relative of the inertias.
///
/// `fused`: MuJoCo has fused welded bodies into those that carry them, and forgotten their names.
pub fn body_errors(imported: &Imported, reference: &Value, fused: bool) -> [f64; 3] {
    let skeleton = &imported.character.skeleton;
    let model = Model::new(&imported.character, imported.gravity);
    let joints = reference["joints"].as_array().unwrap();
    let mut worst = [0.0_f64; 3];
    for (i, body) in reference["bodies"].as_array().unwrap().iter().enumerate().skip(1) {
        let link = skeleton.link(body["name"].as_str().unwrap()).unwrap_or_else(|| panic!("{body}"));
        let (mass, com, inertia) = if fused {
            let b = model.bodies.iter().find(|b| b.link == link).unwrap();
            (b.mass, b.com, b.inertia)
        } else {
            let b = &imported.character.bodies[link];
            (b.mass, b.com, b.inertia)
        };
        // our origin is the last joint's anchor
        let mut origin = Vec3::zeros();
        if let Some(last) = joints.iter().rfind(|j| j["body"].as_u64() == Some(i as u64))
            && skeleton.links()[link].joint != Joint::Free
        {
            origin = vector(&last["pos"]);
        }
        let [w, x, y, z] = numbers(&body["iquat_wxyz"]).try_into().unwrap();
        let r = Quat::new_normalize(Quaternion::new(w, x, y, z)).to_rotation_matrix();
        let diagonal = Matrix3::from_diagonal(&vector(&body["inertia_diag"]));
        let theirs = r.matrix() * diagonal * r.matrix().transpose();
        let their_mass = body["mass"].as_f64().unwrap();
        if their_mass == 0.0 {
            assert_eq!(mass, 0.0, "{}", body["name"]);
            continue;
        }
        let errors = [
            (mass - their_mass).abs() / their_mass,
            (com - (vector(&body["ipos"]) - origin)).amax(),
            (inertia - theirs).amax() / theirs.amax(),
        ];
        for (w, e) in worst.iter_mut().zip(errors) {
            *w = largest([*w, e]);
        }
    }
    worst
}

/// Worst error of the centre of mass of the whole model, m, and relative of the trace of the mass matrix.
pub fn whole_errors(imported: &Imported, reference: &Value) -> [f64; 2] {
    let layout = imported.layout();
    let model = Model::new(&imported.character, imported.gravity);
    let mut state = State::new(&model);
    let mut m = DMatrix::zeros(model.nv(), model.nv());
    let mut worst = [0.0_f64; 2];
    for s in reference["states"].as_array().unwrap() {
        let q = pose(&layout, &numbers(&s["qpos"]));
        state.update(&model, &q, &vec![0.0; model.nv()]);
        let com = imported.ours_from_file * vector(&s["com"]);
        worst[0] = largest([worst[0], (state.com(&model) - com).amax()]);
        if let Some(trace) = s["trace_M"].as_f64() {
            state.mass_matrix(&model, &mut m);
            worst[1] = largest([worst[1], (m.trace() - trace) / trace]);
        }
    }
    worst
}
