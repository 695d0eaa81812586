//! Rigid-body quantities at random states: no time, no contact.
//!
//! In: a model here and the same model in MuJoCo, a seed. Out: checks of masses, frames, mass matrix, bias,
//! gravity load, inverse dynamics, centre of mass, momenta and energies, each the worst over all states. Both
//! sides computed apart: these agree to rounding.
//!
//! States: hinges within ±π, slides within ±1 m, balls and free rotations uniform, |v| ≤ 10, |v̇| ≤ 100 per
//! coordinate, none zero. Contacts, limits, springs, dampers, actuators, friction losses, equalities and rotor
//! inertias are off in MuJoCo.
//!
//! Errors are relative to the largest entry of the state, or to the size of what the numbers are sums of where that is
//! greater (`Sizes`): a momentum that cancels has the rounding of its parts.

use dynamics::{Model, Momentum, State};
use formats::mujoco_layout::Layout;
use motion::rotation::exp;
use motion::{Joint, Quat, Vec3};
use nalgebra::DMatrix;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use serde_json::json;

use crate::bridge::{Bridge, BridgeError, ModelInfo, expect};
use crate::check::{Check, Worst, ratio};

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

/// What came of it.
#[derive(Clone, Debug, Default)]
pub struct Compared {
    /// The checks.
    pub checks: Vec<Check>,
    /// Quantities of which the model has none, with the reason.
    pub nothing: Vec<String>,
}

impl Compared {
    fn put(&mut self, worst: Worst, quantity: &str, unit: &str, none: &str) {
        match worst.check(quantity, unit, ROUNDING) {
            Some(check) => self.checks.push(check),
            None => self.nothing.push(format!("{quantity}: {none}")),
        }
    }
}

/// Most degrees of freedom compared: a mass matrix per state.
pub const LARGEST: usize = 1000;
/// Numbers asked of MuJoCo at once.
const BATCH: usize = 1 << 22;

/// Compares `states` random states.
///
/// # Errors
/// Of the bridge.
pub fn compare(
    pair: &Pair<'_>,
    bridge: &mut Bridge,
    seed: u64,
    states: usize,
) -> Result<Compared, BridgeError> {
    let mut out = Compared::default();
    let (model, layout) = (pair.model, pair.layout);
    if model.nv() == 0 {
        out.nothing.push("everything: the model has no degrees of freedom".into());
        return Ok(out);
    }
    tree(pair, &mut out);
    let mut random = Random(Pcg64::seed_from_u64(seed));
    let mut worst = States::default();
    let n = layout.nv;
    let width = 3 * n + n * n + 11;
    let batch = (BATCH / width).max(1);
    let mut first = 0;
    while first < states {
        let count = batch.min(states - first);
        let (mut ours, mut request) = (Vec::new(), vec![0.0; count * (layout.nq + 2 * n)]);
        for row in request.chunks_exact_mut(layout.nq + 2 * n) {
            let (q, v, vd) = random.state(model);
            let (their_q, rest) = row.split_at_mut(layout.nq);
            let (their_v, their_vd) = rest.split_at_mut(n);
            layout.pose(&q, their_q);
            layout.tangent(&q, &v, their_v);
            layout.tangent(&q, &vd, their_vd);
            ours.push((q, v, vd));
        }
        let (_, answer) = bridge.call(&json!({"op": "dynamics"}), &request)?;
        expect(&answer, count * width)?;
        worst.see(pair, first, &ours, &answer);
        first += count;
    }
    worst.into_checks(&mut out);
    Ok(out)
}

/// The worst of every quantity over the states so far.
#[derive(Default)]
struct States([Worst; 9]);

/// Part of what a sum is made of below which the rounding of the parts counts, not of the sum.
const CANCELLED: f64 = 1e-3;

impl States {
    /// States from number `first` on: our pose, velocity and acceleration of each, and MuJoCo's answers.
    fn see(
        &mut self,
        pair: &Pair<'_>,
        first: usize,
        ours: &[(Vec<f64>, Vec<f64>, Vec<f64>)],
        answer: &[f64],
    ) {
        let (model, layout) = (pair.model, pair.layout);
        let (nv, n) = (model.nv(), layout.nv);
        let worst = &mut self.0;
        let mut state = State::new(model);
        let mut mass = DMatrix::zeros(nv, nv);
        let (mut tau, mut theirs) = (vec![0.0; nv], vec![0.0; n]);
        let to_file = pair.ours_from_file.inverse();
        let joint = joint_of_column(pair);
        for (k, ((q, v, vd), row)) in ours.iter().zip(answer.chunks_exact(3 * n + n * n + 11)).enumerate() {
            let s = first + k;
            let place = |k: usize| format!("`{}`, state {s}", joint[k]);
            state.update(model, q, v);
            state.inverse_dynamics(model, v, vd, &[], &mut tau);
            layout.tangent(q, &tau, &mut theirs);
            worst[0].see(&theirs, &row[..n], 0.0, place);
            // bias and gravity are parts of it
            let forces = CANCELLED * row[..n].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            state.bias(model, v, &mut tau);
            layout.tangent(q, &tau, &mut theirs);
            worst[1].see(&theirs, &row[n..2 * n], forces, place);
            let moved = &row[2 * n..];
            state.mass_matrix(model, &mut mass);
            let in_theirs = congruence(pair, q, &mass);
            worst[3].see(in_theirs.as_slice(), &moved[n..n + n * n], 0.0, |k| {
                format!("`{}` and `{}`, state {s}", joint[k % n], joint[k / n])
            });
            state.gravity_load(model, &mut tau);
            layout.tangent(q, &tau, &mut theirs);
            worst[2].see(&theirs, &moved[..n], forces, place);
            let rest = &moved[n + n * n..];
            let m = state.momentum(model);
            let (kinetic, potential) = state.energy(model);
            let sizes = Sizes::of(model, &state, &m, kinetic);
            let whole = |_: usize| format!("state {s}");
            let file = |x: Vec3| (to_file * x).as_slice().to_vec();
            worst[4].see(&file(m.com), &rest[..3], sizes.com, whole);
            worst[5].see(&file(m.linear), &rest[3..6], sizes.linear, whole);
            worst[6].see(&file(m.angular), &rest[6..9], sizes.angular, whole);
            worst[7].see(&[kinetic], &rest[9..10], 0.0, whole);
            worst[8].see(&[potential], &rest[10..11], sizes.potential, whole);
        }
    }

    fn into_checks(self, out: &mut Compared) {
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
        for (worst, (name, unit)) in self.0.into_iter().zip(names) {
            out.put(worst, name, unit, "no state");
        }
    }
}

/// How large what the numbers of a state are sums of is: their rounding is a part of this, even where the sums cancel.
struct Sizes {
    com: f64,
    linear: f64,
    angular: f64,
    potential: f64,
}

impl Sizes {
    /// With the kinetic energy T, mass m and J the trace of the inertia about the world's origin, |P| ≤ √(2 T m) and
    /// |L| ≤ √(2 T J).
    fn of(model: &Model, state: &State, momentum: &Momentum, kinetic: f64) -> Self {
        let (mut distance, mut height, mut inertia) = (0.0, 0.0, 0.0);
        for (b, s) in model.bodies.iter().zip(&state.bodies) {
            distance += b.mass * s.com.norm();
            height += b.mass * model.gravity.dot(&s.com).abs();
            inertia += s.inertia.trace() + b.mass * s.com.norm_squared();
        }
        let mass = model.mass;
        Self {
            com: ratio(distance, mass).max(momentum.com.norm()),
            linear: CANCELLED * (2.0 * kinetic * mass).sqrt(),
            angular: CANCELLED * (2.0 * kinetic * inertia).sqrt(),
            potential: height,
        }
    }
}

/// Masses, centres of mass, joint positions and axes in the reference pose: what a wrong file shows first.
fn tree(pair: &Pair<'_>, out: &mut Compared) {
    let (model, info) = (pair.model, pair.info);
    let skeleton = &model.skeleton;
    let mut q = skeleton.zero_pose();
    pair.layout.pose_back(&info.qpos0, &mut q);
    let mut state = State::new(model);
    state.update(model, &q, &vec![0.0; model.nv()]);
    let to_file = pair.ours_from_file.inverse();
    let (mut mass, mut com) = (Worst::default(), Worst::default());
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
        // a body without mass has no centre of mass; that it has mass on the other side is said above
        if b.mass > 0.0 && *sum > 0.0 {
            com.see((to_file * state.bodies[i].com).as_slice(), (moment / *sum).as_slice(), 1.0, |_| name(i));
        }
    }
    let (mut anchor, mut axis) = (Worst::default(), Worst::default());
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
    out.put(mass, "masses", "kg", "no body moves");
    out.put(com, "centres of mass of the bodies", "m", "no body moves");
    out.put(anchor, "positions of the joints", "m", "no joint is a hinge");
    out.put(axis, "axes of the joints", "", "no joint has an axis");
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
