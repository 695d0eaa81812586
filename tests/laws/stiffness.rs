//! What a push measures: doubled tension is doubled stiffness, gravity adds its own, and the pose stays.
//!
//! One joint is free, its neighbours and the root are welded, or the root is pinned. A steady moment δτ turns it by δ; three of them give
//! the compliance matrix, whose inverse is the measured stiffness, N·m/rad along the zero frame.

use std::sync::Arc;

use bodies::Character;
use dynamics::{Model, Push, RootMode, State};
use motion::rotation::log;
use motion::skeleton::quat_at;
use motion::{Joint, Vec3};
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::bodies::{human, locked, poses, rods};
use super::stage::{gravity, hold, hold_at, run};

/// Where a limb comes to rest does not depend on the step.
const RATE_HZ: f64 = 60.0;
/// How long a limb gets to come to rest, s.
const SETTLE_S: f64 = 20.0;
/// Turn a push asks for, rad: small enough to be linear, large against rounding.
const TURN: f64 = 0.005;
/// Arm of a push, m.
const ARM: f64 = 0.3;

/// A joint in rest under its tension.
struct Held {
    /// K = k_lo + k_hi, N·m/rad.
    tension: f64,
    /// How far it rests from its target, rad.
    shift: f64,
    /// Stiffness that pushes measure, `nv × nv`, N·m/rad.
    measured: DMatrix<f64>,
}

/// Holds and pushes the one joint of `c`.
fn measure(c: &Arc<Character>, gravity: Vec3, tension: f64) -> Held {
    let model = Model::new(c, gravity);
    let mut state = State::new(&model);
    state.update(&model, &c.rest, &vec![0.0; model.nv()]);
    let body = 1;
    let b = &model.bodies[body];
    let zero = state.bodies[body].zero;
    let axes: Vec<Vec3> = match b.joint {
        Joint::Revolute(axis) => vec![zero * axis],
        _ => (0..3).map(|k| zero.column(k).into_owned()).collect(),
    };
    let turn = |from: &[f64], to: &[f64]| -> Vec3 {
        match b.joint {
            Joint::Revolute(_) => Vec3::x() * (to[b.q_at] - from[b.q_at]),
            _ => log(&(quat_at(to, b.q_at) * quat_at(from, b.q_at).inverse())),
        }
    };
    let rest = |push: Option<Push>| {
        let mut pass = hold_at(c, gravity, tension, SETTLE_S, RATE_HZ);
        pass.root = RootMode::Pinned; // a welded one needs no pin
        pass.pushes.extend(push);
        let trace = run(pass).trace;
        let last = trace.rows() - 1;
        let nv = model.nv();
        let moving = trace.v[last * nv..].iter().fold(0.0_f64, |a, v| a.max(v.abs()));
        assert!(moving < 1e-6, "still moving at {moving} rad/s");
        (trace.pose(last).to_vec(), trace.k_lo[last * nv + b.v_at] + trace.k_hi[last * nv + b.v_at])
    };
    let (q, k) = rest(None);
    let n = axes.len();
    let mut compliance = DMatrix::zeros(n, n);
    for (j, axis) in axes.iter().enumerate() {
        let helper = if axis.x.abs() < 0.7 { Vec3::x() } else { Vec3::y() };
        let arm = axis.cross(&helper).normalize() * ARM;
        let torque = TURN * k;
        let force = axis.cross(&arm) * (torque / (ARM * ARM)); // arm × force = torque · axis
        let at = state.bodies[body].world.rotation.inverse() * arm;
        let push = |sign: f64| Push {
            link: b.link,
            at,
            force: force * sign,
            start_s: 0.0,
            duration_s: 2.0 * SETTLE_S,
        };
        let (plus, _) = rest(Some(push(1.0)));
        let (minus, _) = rest(Some(push(-1.0)));
        let deflection = turn(&minus, &plus) / (2.0 * torque);
        for i in 0..n {
            compliance[(i, j)] = deflection[i];
        }
    }
    let measured = compliance.try_inverse().unwrap();
    Held { tension: k, shift: turn(&c.rest, &q).norm(), measured }
}

/// The largest difference between two matrices against the smallest stiffness in `b`.
fn difference(a: &DMatrix<f64>, b: &DMatrix<f64>) -> f64 {
    let least = b.clone().symmetric_eigenvalues().min();
    (a - b).amax() / least
}

/// Joints of the figure that are pushed.
const JOINTS: [&str; 8] =
    ["neck", "abdomen", "shoulder_l", "elbow_r", "wrist_l", "hip_l", "knee_l", "ankle_r"];

/// Without gravity, what a push measures is the tension itself: twice the one, twice the other.
#[test]
fn slow_doubled_tension_doubles_the_measured_stiffness() {
    let figure = human();
    let mut bodies = vec![
        ("hinge".to_string(), rods(1, Joint::Revolute(Vec3::z()), Vec3::x())),
        ("ball".to_string(), rods(1, Joint::Spherical, Vec3::x())),
    ];
    for (pose, q) in poses(&figure) {
        for name in JOINTS {
            let link = figure.skeleton.link(name).unwrap();
            bodies.push((format!("{name} {pose}"), locked(&figure, &q, &[link])));
        }
    }
    let mut worst: f64 = 0.0;
    for (name, body) in bodies {
        let body = Arc::new(body);
        let once = measure(&body, Vec3::zeros(), 1.0);
        let twice = measure(&body, Vec3::zeros(), 2.0);
        assert!((twice.tension / once.tension - 2.0).abs() < 1e-12, "{name}");
        let error = difference(&twice.measured, &(&once.measured * 2.0));
        worst = worst.max(error);
        // 2e-10 seen
        assert!(error < 0.01, "{name}: {error:.2e} {} {}", once.measured, twice.measured);
        assert!(once.shift < 1e-9, "{name}: {}", once.shift);
    }
    println!("doubling: worst {worst:.1e}");
}

/// Under gravity a push measures K − ∂τ_e/∂θ = K + ∂²V/∂θ², and the limb rests where it was told.
#[test]
fn slow_gravity_adds_its_own_stiffness_and_moves_nothing() {
    let figure = human();
    let mut bodies = Vec::new();
    for (pose, q) in poses(&figure) {
        for name in JOINTS {
            let link = figure.skeleton.link(name).unwrap();
            bodies.push((format!("{name} {pose}"), locked(&figure, &q, &[link])));
            bodies.push((format!("{name} {pose}, root pinned"), locked(&figure, &q, &[0, link])));
        }
    }
    for degrees in [0.0_f64, 35.0, 90.0, 150.0] {
        let mut hinge = rods(1, Joint::Revolute(Vec3::z()), -Vec3::y());
        hinge.rest = vec![degrees.to_radians()];
        bodies.push((format!("hinge {degrees}"), hinge));
        let mut ball = rods(1, Joint::Spherical, -Vec3::y());
        let turn = motion::rotation::exp(&(Vec3::new(0.6, 0.0, 0.8) * degrees.to_radians()));
        let skeleton = ball.skeleton.clone();
        skeleton.set_rotation(&mut ball.rest, 1, &turn);
        bodies.push((format!("ball {degrees}"), ball));
    }
    let check = |(name, body): (String, Character)| {
        let (mut worst, mut farthest) = (0.0_f64, 0.0_f64);
        let body = Arc::new(body);
        let model = Model::new(&body, gravity());
        let mut state = State::new(&model);
        state.update(&model, &body.rest, &vec![0.0; model.nv()]);
        let mut all = DMatrix::zeros(model.nv(), model.nv());
        state.gravity_stiffness(&model, &mut all);
        let (at, n) = (model.bodies[1].v_at, model.bodies[1].joint.nv());
        let curvature = all.view((at, at), (n, n)).into_owned();
        let setup = hold(&body, gravity(), 1.0, 0.1).setup;
        let scale = controllers::Plan::new(setup, &[]).scale;
        let (least, k1) = (scale.least[1], scale.k1[1]);
        for k in [1.501 * least, 0.5 * k1, k1, 4.0 * k1] {
            if k < 1.5 * least || k < 0.1 * k1 {
                continue;
            }
            let held = measure(&body, gravity(), k / k1);
            assert!((held.tension / k - 1.0).abs() < 1e-12);
            let expected = DMatrix::identity(n, n) * k + &curvature;
            let error = difference(&held.measured, &expected);
            let at = format!("{name}, K = {k:.2} N·m/rad = {:.2} K_least", k / least);
            assert!(error < 0.02, "{at}: {error:.2e}"); // 4e-4 seen
            assert!(held.shift.to_degrees() < 0.5, "{at}: {:.2e}°", held.shift.to_degrees()); // 1e-13 seen
            worst = worst.max(error);
            farthest = farthest.max(held.shift.to_degrees());
        }
        (worst, farthest)
    };
    let found: Vec<(f64, f64)> = bodies.into_par_iter().map(check).collect();
    let (worst, farthest) = found.iter().fold((0.0_f64, 0.0_f64), |a, b| (a.0.max(b.0), a.1.max(b.1)));
    println!("gravity: worst {worst:.1e}, farthest {farthest:.1e}°");
}
