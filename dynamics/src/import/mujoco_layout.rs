//! Poses, velocities, accelerations and forces between MuJoCo's conventions and ours.
//!
//! In and out: flat vectors of an [`Imported`] model. MuJoCo's `qpos` and ours hold the same numbers: joints in
//! the order of [`Imported::joints`], free joints as position and quaternion `w x y z`. Velocities differ in
//! the axes of rotations only:
//!
//! | joint | MuJoCo's `qvel` | our `v` |
//! |---|---|---|
//! | free | linear: file's world axes; angular ω_b: **body** axes | both along the zero frame (the file's world axes) |
//! | ball | ω_b: **child's** axes | along the zero frame (the parent's axes) |
//! | hinge, slide | rate | rate |
//!
//! With R the joint's rotation, ω = R ω_b. Since ω × ω = 0, accelerations turn the same way, ω̇ = R ω̇_b; and
//! forces by the transpose, τ_b = Rᵀ τ, so that power τ·ω is one number. MuJoCo's inertia matrix is
//! `M_b = Tᵀ M T` with `T` the block-diagonal of these rotations.

use motion::{Joint, Quat, Skeleton, Vec3};

use super::Imported;

/// Pose, velocity and acceleration of MuJoCo (`qpos`, `qvel`, `qacc`) in our conventions.
///
/// Quaternions are made unit length.
///
/// # Panics
/// If a vector has not the model's `nq` or `nv` numbers.
pub fn to_ours(model: &Imported, qpos: &[f64], qvel: &[f64], qacc: &[f64]) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let q = q_to_ours(model, qpos);
    let (v, vd) = (rates_to_ours(model, &q, qvel), rates_to_ours(model, &q, qacc));
    (q, v, vd)
}

/// Pose of MuJoCo (`qpos`, `nq`) as ours: quaternions made unit length, otherwise the same numbers.
///
/// # Panics
/// If `qpos` has not `nq` numbers.
pub fn q_to_ours(model: &Imported, qpos: &[f64]) -> Vec<f64> {
    let s = &model.character.skeleton;
    assert_eq!(qpos.len(), s.nq(), "length of qpos");
    let mut q = qpos.to_vec();
    for at in rotations(s).map(|(_, at, _)| at) {
        let length = q[at..at + 4].iter().map(|x| x * x).sum::<f64>().sqrt();
        q[at..at + 4].iter_mut().for_each(|x| *x /= length);
    }
    q
}

/// Velocity or acceleration of MuJoCo in our conventions, at our pose `q`.
///
/// # Panics
/// If a vector has not the model's `nq` or `nv` numbers.
pub fn rates_to_ours(model: &Imported, q: &[f64], rates: &[f64]) -> Vec<f64> {
    turned(model, q, rates, |r, x| r * x)
}

/// Velocity or acceleration of ours in MuJoCo's conventions, at our pose `q`.
///
/// # Panics
/// If a vector has not the model's `nq` or `nv` numbers.
pub fn rates_to_mujoco(model: &Imported, q: &[f64], rates: &[f64]) -> Vec<f64> {
    turned(model, q, rates, |r, x| r.inverse() * x)
}

/// Generalised forces of ours in MuJoCo's conventions (`qfrc_…`), at our pose `q`.
///
/// # Panics
/// If a vector has not the model's `nq` or `nv` numbers.
pub fn tau_to_mujoco(model: &Imported, q: &[f64], tau: &[f64]) -> Vec<f64> {
    turned(model, q, tau, |r, x| r.inverse() * x)
}

/// Generalised forces of MuJoCo in our conventions, at our pose `q`.
///
/// # Panics
/// If a vector has not the model's `nq` or `nv` numbers.
pub fn tau_to_ours(model: &Imported, q: &[f64], tau: &[f64]) -> Vec<f64> {
    turned(model, q, tau, |r, x| r * x)
}

fn turned(model: &Imported, q: &[f64], x: &[f64], turn: impl Fn(&Quat, Vec3) -> Vec3) -> Vec<f64> {
    let s = &model.character.skeleton;
    assert_eq!(q.len(), s.nq(), "length of q");
    assert_eq!(x.len(), s.nv(), "length of a velocity or force");
    let mut out = x.to_vec();
    for (link, _, at) in rotations(s) {
        let y = turn(&s.rotation(q, link), Vec3::new(x[at], x[at + 1], x[at + 2]));
        out[at..at + 3].copy_from_slice(y.as_slice());
    }
    out
}

/// Links with a quaternion, where it starts in `q`, and where its angular rates start in `v`.
fn rotations(s: &Skeleton) -> impl Iterator<Item = (usize, usize, usize)> {
    s.links().iter().enumerate().filter_map(|(i, link)| match link.joint {
        Joint::Free => Some((i, s.q_at(i) + 3, s.v_at(i) + 3)),
        Joint::Spherical => Some((i, s.q_at(i), s.v_at(i))),
        _ => None,
    })
}
