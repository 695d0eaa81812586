//! Rigid-body quantities at random states: no time, no contact.
//!
//! In: a model here and the same model in MuJoCo, a seed. Out: checks of masses, frames, mass matrix, bias,
//! gravity load, inverse dynamics, centre of mass, momenta and energies, each the worst over all states. Both
//! sides computed apart: these agree to rounding.
//!
//! States: hinges within ±π, slides within ±1 m, balls and free rotations uniform, |v| ≤ 10, |v̇| ≤ 100 per
//! coordinate, none zero. Contacts, limits, springs, dampers, actuators, friction losses, equalities and rotor
//! inertias are off in MuJoCo.

use dynamics::{Model, State};
use formats::mujoco_layout::Layout;
use motion::rotation::exp;
use motion::{Joint, Quat, Vec3};
use nalgebra::DMatrix;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use serde_json::json;

use crate::bridge::{Bridge, BridgeError, ModelInfo, expect};
use crate::check::{Check, Worst};

/// What MuJoCo leaves out of a model here.
pub const OFF: [&str; 8] =
    ["constraint", "equality", "frictionloss", "limit", "contact", "spring", "damper", "actuation"];

/// Largest relative error allowed: rounding of two different summations.
pub const ROUNDING: f64 = 1e-10;

/// Largest speed of a coordinate, rad/s or m/s.
const SPEED: f64 = 10.0;
/// Largest acceleration of a coordinate, rad/s² or m/s².
const ACCELERATION: f64 = 100.0;

/// A model on both sides.
pub struct Pair<'a> {
    /// Ours.
    pub model: &'a Model,
    /// MuJoCo's.
    pub info: &'a ModelInfo,
    /// Between them.
    pub layout: &'a Layout,
    /// Links whose joints MuJoCo has, in its order.
    pub joints: &'a [usize],
    /// Rotation that takes vectors of the file's world to ours.
    pub ours_from_file: Quat,
}

/// Compares `states` random states.
///
/// # Errors
/// Of the bridge.
pub fn compare(
    pair: &Pair<'_>,
    bridge: &mut Bridge,
    seed: u64,
    states: usize,
) -> Result<Vec<Check>, BridgeError> {
    let mut checks = tree(pair);
    let (model, layout) = (pair.model, pair.layout);
    let nv = layout.ours().1;
    let mut random = Random(Pcg64::seed_from_u64(seed));
    let width = layout.nq + 2 * layout.nv;
    let (mut ours, mut request) = (Vec::new(), vec![0.0; states * width]);
    for row in request.chunks_exact_mut(width) {
        let (q, v, vd) = random.state(model);
        let (their_q, rest) = row.split_at_mut(layout.nq);
        let (their_v, their_vd) = rest.split_at_mut(layout.nv);
        layout.pose(&q, their_q);
        layout.tangent(&q, &v, their_v);
        layout.tangent(&q, &vd, their_vd);
        ours.push((q, v, vd));
    }
    let (_, answer) = bridge.call(&json!({"op": "dynamics"}), &request)?;
    let n = layout.nv;
    let width = 3 * n + n * n + 11;
    expect(&answer, states * width)?;

    let mut state = State::new(model);
    let mut mass = DMatrix::zeros(nv, nv);
    let (mut tau, mut theirs) = (vec![0.0; nv], vec![0.0; n]);
    let mut worst: [Worst; 9] = std::array::from_fn(|_| Worst::new());
    let to_file = pair.ours_from_file.inverse();
    let joint = joint_of_column(pair);
    for (s, ((q, v, vd), row)) in ours.iter().zip(answer.chunks_exact(width)).enumerate() {
        let place = |k: usize| format!("`{}`, state {s}", joint[k]);
        state.update(model, q, v);
        state.inverse_dynamics(model, v, vd, &[], &mut tau);
        layout.tangent(q, &tau, &mut theirs);
        worst[0].see(&theirs, &row[..n], 0.0, place);
        state.bias(model, v, &mut tau);
        layout.tangent(q, &tau, &mut theirs);
        worst[1].see(&theirs, &row[n..2 * n], 0.0, place);
        let moved = &row[2 * n..];
        state.mass_matrix(model, &mut mass);
        let in_theirs = congruence(pair, q, &mass);
        worst[3].see(in_theirs.as_slice(), &moved[n..n + n * n], 0.0, |k| {
            format!("`{}` and `{}`, state {s}", joint[k % n], joint[k / n])
        });
        state.gravity_load(model, &mut tau);
        layout.tangent(q, &tau, &mut theirs);
        worst[2].see(&theirs, &moved[..n], 1e-9, place);
        let rest = &moved[n + n * n..];
        let m = state.momentum(model);
        let (kinetic, potential) = state.energy(model);
        let whole = |_: usize| format!("state {s}");
        let file = |x: Vec3| (to_file * x).as_slice().to_vec();
        worst[4].see(&file(m.com), &rest[..3], 1e-3, whole);
        worst[5].see(&file(m.linear), &rest[3..6], 0.0, whole);
        worst[6].see(&file(m.angular), &rest[6..9], 0.0, whole);
        worst[7].see(&[kinetic], &rest[9..10], 0.0, whole);
        worst[8].see(&[potential], &rest[10..11], 1.0, whole);
    }
    let names = [
        ("inverse dynamics", "N·m"),
        ("bias forces", "N·m"),
        ("gravity load", "N·m"),
        ("mass matrix", "kg·m²"),
        ("centre of mass", "m"),
        ("linear momentum", "N·s"),
        ("angular momentum", "N·m·s"),
        ("kinetic energy", "J"),
        ("potential energy", "J"),
    ];
    checks.extend(worst.into_iter().zip(names).map(|(w, (name, unit))| w.check(name, unit, ROUNDING)));
    Ok(checks)
}

/// Masses, centres of mass, joint positions and axes in the reference pose: what a wrong file shows first.
fn tree(pair: &Pair<'_>) -> Vec<Check> {
    let (model, info) = (pair.model, pair.info);
    let skeleton = &model.skeleton;
    let mut q = skeleton.zero_pose();
    pair.layout.pose_back(&info.qpos0, &mut q);
    let mut state = State::new(model);
    state.update(model, &q, &vec![0.0; model.nv()]);
    let to_file = pair.ours_from_file.inverse();
    let mut mass = Worst::new();
    let mut com = Worst::new();
    // fused bodies here, theirs summed: welded links may be anywhere in either tree
    let mut sums = vec![(0.0, Vec3::zeros()); model.bodies.len()];
    for (body, at) in info.bodies.iter().zip(&info.coms) {
        if let Some(link) = skeleton.link(&body.name) {
            let sum = &mut sums[model.body_of[link].0];
            sum.0 += body.mass;
            sum.1 += at * body.mass;
        }
    }
    let name = |i: usize| format!("`{}`", skeleton.links()[model.bodies[i].link].name);
    let total = model.mass;
    for (i, (b, (sum, moment))) in model.bodies.iter().zip(&sums).enumerate() {
        // the base of a welded tree moves nothing
        if b.mass == 0.0 && *sum == 0.0 || b.joint.nv() == 0 {
            continue;
        }
        mass.see(&[b.mass], &[*sum], 1e-9 * total, |_| name(i));
        com.see((to_file * state.bodies[i].com).as_slice(), (moment / *sum).as_slice(), 1.0, |_| name(i));
    }
    let (mut anchor, mut axis) = (Worst::new(), Worst::new());
    for (k, &link) in pair.joints.iter().enumerate() {
        let l = &skeleton.links()[link];
        let place = |_: usize| format!("`{}`", l.name);
        let (Joint::Revolute(along) | Joint::Prismatic(along)) = l.joint else { continue };
        let body = &state.bodies[model.body_of[link].0];
        let there = to_file * (body.zero * along);
        axis.see(there.as_slice(), info.axes[k].as_slice(), 1.0, place);
        if matches!(l.joint, Joint::Revolute(_)) {
            // any point of the axis will do
            let apart = to_file * body.world.translation.vector - info.anchors[k];
            let off = apart - there * apart.dot(&there);
            anchor.see(off.as_slice(), &[0.0; 3], 1.0, place);
        }
    }
    vec![
        mass.check("masses", "kg", ROUNDING),
        com.check("centres of mass of the bodies", "m", ROUNDING),
        anchor.check("positions of the joints", "m", ROUNDING),
        axis.check("axes of the joints", "", ROUNDING),
    ]
}

/// Name of the joint each of MuJoCo's velocities belongs to.
fn joint_of_column(pair: &Pair<'_>) -> Vec<String> {
    let mut names = vec![String::new(); pair.layout.nv];
    for (joint, &link) in pair.info.joints.iter().zip(pair.joints) {
        let l = &pair.model.skeleton.links()[link];
        for name in &mut names[joint.v..joint.v + l.joint.nv()] {
            *name = l.name.clone();
        }
    }
    names
}

/// Our mass matrix in MuJoCo's coordinates: columns and rows turned like velocities.
fn congruence(pair: &Pair<'_>, q: &[f64], mass: &DMatrix<f64>) -> DMatrix<f64> {
    let (layout, nv) = (pair.layout, mass.nrows());
    let mut half = DMatrix::zeros(layout.nv, nv);
    let mut column = vec![0.0; layout.nv];
    let plain: Vec<f64> = mass.as_slice().to_vec();
    for k in 0..nv {
        layout.tangent(q, &plain[k * nv..(k + 1) * nv], &mut column);
        half.column_mut(k).copy_from_slice(&column);
    }
    let half = half.transpose();
    let mut whole = DMatrix::zeros(layout.nv, layout.nv);
    for k in 0..layout.nv {
        layout.tangent(q, half.column(k).into_owned().as_slice(), &mut column);
        whole.column_mut(k).copy_from_slice(&column);
    }
    whole
}

struct Random(Pcg64);

impl Random {
    /// Uniform in (−1, 1), never zero.
    fn next(&mut self) -> f64 {
        loop {
            // 53 random bits
            let x = (self.0.next_u64() >> 11) as f64 / (1u64 << 52) as f64 - 1.0;
            if x.abs() > 1e-6 {
                return x;
            }
        }
    }

    fn vec(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }

    /// A rotation: a direction inside a ball, turned about by up to π.
    fn rotation(&mut self) -> Quat {
        loop {
            let axis = self.vec();
            if (0.01..1.0).contains(&axis.norm()) {
                return exp(&(axis.normalize() * (std::f64::consts::PI * self.next())));
            }
        }
    }

    fn state(&mut self, model: &Model) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let skeleton = &model.skeleton;
        let mut q = skeleton.zero_pose();
        for (i, link) in skeleton.links().iter().enumerate() {
            match link.joint {
                Joint::Free => {
                    skeleton.set_position(&mut q, i, &(self.vec() * 2.0));
                    skeleton.set_rotation(&mut q, i, &self.rotation());
                }
                Joint::Spherical => skeleton.set_rotation(&mut q, i, &self.rotation()),
                Joint::Revolute(_) => q[skeleton.q_at(i)] = std::f64::consts::PI * self.next(),
                Joint::Prismatic(_) => q[skeleton.q_at(i)] = self.next(),
                Joint::Fixed => {}
            }
        }
        let v = (0..skeleton.nv()).map(|_| SPEED * self.next()).collect();
        let vd = (0..skeleton.nv()).map(|_| ACCELERATION * self.next()).collect();
        (q, v, vd)
    }
}
