//! Momentum control: joint accelerations and muscle torques that give the body a wrench of the ground.
//!
//! What the ground has to give, a force F through a point p of the ground, fixes the rate of momentum, linear and
//! angular. Of all accelerations v̇ that have it and leave the soles where they stand, the one nearest to a posture task:
//!
//! ```text
//! min Σ w_i (v̇_i − v̇*_i)²   with   (M v̇ + c)_root = wrench of F in p,   J v̇ + J̇ v = −2 ω_s ẋ − f ω_s² (x − x_0)
//! ```
//!
//! - v̇* leads every joint back to the pose asked for, critically damped.
//! - The wrench has no moment about the vertical: a sole pressed at its edge turns about it.
//! - Knees stay over the feet as they are in the pose asked for: hip and foot leave a leg free to turn about the line
//!   between them, and a leg that turned there would take the moment about the vertical that the trunk asks for.
//! - A foot goes back to its place x_0 only as far as it is free of load (f from 0 to 1): friction holds the other.
//! - Constraints are tasks of the same least squares with the weight [`FIRM`], not exact: a stretched leg could raise the
//!   body only at an infinite rate of its knee, and an exact constraint would ask for that. The vertical force has little
//!   weight, so that straight legs may lower the body.
//!
//! What the solution asks of the ground is shared by the pressures of the soles' corners ([`pressed_wrenches`]): every
//! foot's own centre lies inside its sole, and none pulls. Torques are those of inverse dynamics.
//!
//! Drives are set so that they give these torques at the state foreseen for the *end of the step*, `v + v̇ dt` and
//! `q ⊕ (v + v̇ dt) dt`: their stiffness and damping then correct towards that motion; set at its start they would resist it.
//!
//! In: a state, a goal, what the ground shall give. Out: accelerations, drives. Symbols: `M` mass matrix, `c` bias, `J`
//! Jacobian of a sole, `x` its place and turn, `ω_s` its natural frequency, `w` weights. World frame; `v̇` in the layout of [`motion::skeleton`].
//!
//! A. Macchietto, V. Zordan, C. Shelton. Momentum control for balance. SIGGRAPH 2009. S.-H. Lee, A. Goswami. A
//! momentum-based balance controller for humanoid robots on non-level and non-stationary ground. Autonomous Robots 2012.

use dynamics::rnea::joint_force;
use dynamics::{Model, State};
use motion::ik::swivel;
use motion::plant::Plant;
use motion::rotation::log;
use motion::skeleton::{quat_at, vec_at};
use motion::support::Vec2;
use motion::{Joint, Vec3};
use nalgebra::{Cholesky, DMatrix, DVector};

use crate::reactive::ControlStep;
use crate::support::{Foot, pressed_wrenches, shared_wrenches};
use crate::{Drive, rest_of};

/// Weight of constraints, over a posture task of weight 1.
const FIRM: f64 = 1e4;
/// Weight of the vertical force.
const SOFT: f64 = 1.0;
/// Weights of the posture task: place of the root (m/s²), its turn, spine and knees, and arms where they may swing (rad/s²).
const PLACE: f64 = 1e-4;
const POSTURE: f64 = 1.0;
const ARM: f64 = 0.3;
/// Weight of hips and ankles, whose angles follow from the root and the soles almost entirely.
const LEG: f64 = 1e-2;
/// Weight of knees that stay over their feet, and the natural frequency of their way back, rad/s.
const KNEE: f64 = 100.0;
const KNEE_RAD_S: f64 = 12.0;
/// Length by which moments are compared with forces, and turns with displacements, m.
const LENGTH: f64 = 0.3;
/// Natural frequencies of the way back of joints, of a sole, and of the height, rad/s.
const JOINT_RAD_S: f64 = 6.0;
const SOLE_RAD_S: f64 = 20.0;
const HEIGHT_RAD_S: f64 = 4.0;
/// A foot with this share of the load stays where friction holds it.
const HELD: f64 = 0.1;

/// The reaction of the ground that is asked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    /// Force, N; its vertical part where height and weight leave the choice.
    pub force: Vec3,
    /// Centre of pressure, m.
    pub pressure: Vec2,
    /// How far the centre of mass is above what is asked, m, and how fast it rises, m/s.
    pub above: f64,
    pub rise: f64,
}

/// The feet on the ground.
#[derive(Clone, Copy)]
pub(super) struct Stance<'a> {
    pub feet: &'a [Foot],
    /// Where they stand, in the same order.
    pub plants: &'a [Plant],
    /// Height of the ground, m.
    pub floor: f64,
    /// Whether each foot keeps the same share of the load.
    pub even_load: bool,
}

/// Memory of the momentum control. See the module header.
#[derive(Clone, Debug)]
pub(super) struct WholeBody {
    /// Bodies whose joints take part, with the weight of their posture task; the root first.
    parts: Vec<(usize, f64)>,
    /// Degrees of freedom that take part, in order.
    dofs: Vec<usize>,
    /// Where in `dofs` each degree of freedom is.
    column: Vec<Option<usize>>,
    mass: DMatrix<f64>,
    bias: Vec<f64>,
    row: Vec<f64>,
    /// Normal equations, lower triangle.
    hessian: DMatrix<f64>,
    gradient: DVector<f64>,
    /// v̇ (`nv`).
    pub accel: Vec<f64>,
    tau: Vec<f64>,
    later_q: Vec<f64>,
    later_v: Vec<f64>,
    drift: Vec<(Vec3, Vec3)>,
    /// Axis of each knee, in the frame of its shin.
    knees: Vec<Vec3>,
    /// Share of the load of each foot in the last step.
    shares: Vec<f64>,
}

impl WholeBody {
    /// Memory for the root, the legs of `feet`, the `spine` and upper `arms`.
    pub fn new(model: &Model, feet: &[Foot], spine: &[usize], arms: &[usize]) -> Self {
        let mut parts = vec![(0, POSTURE)];
        parts.extend(spine.iter().map(|&b| (b, POSTURE)));
        parts.extend(arms.iter().map(|&b| (b, ARM)));
        for f in feet {
            let leg = [(f.limb.upper, LEG), (f.limb.lower, POSTURE), (f.limb.end, LEG)];
            parts.extend(leg.map(|(link, weight)| (model.body_of[link].0, weight)));
        }
        let axes =
            |body: usize| model.bodies[body].v_at..model.bodies[body].v_at + model.bodies[body].joint.nv();
        let dofs: Vec<usize> = parts.iter().flat_map(|&(b, _)| axes(b)).collect();
        let mut column = vec![None; model.nv()];
        dofs.iter().enumerate().for_each(|(c, &dof)| column[dof] = Some(c));
        let n = dofs.len();
        let rates = || vec![0.0; model.nv()];
        Self {
            parts,
            dofs,
            column,
            mass: DMatrix::zeros(model.nv(), model.nv()),
            bias: rates(),
            row: vec![0.0; n],
            hessian: DMatrix::zeros(n, n),
            gradient: DVector::zeros(n),
            accel: rates(),
            tau: rates(),
            later_q: model.skeleton.zero_pose(),
            later_v: rates(),
            drift: Vec::new(),
            knees: feet.iter().map(|f| swivel::knee_axis(&model.skeleton, &f.limb)).collect(),
            shares: vec![1.0; feet.len()],
        }
    }

    /// Finds v̇; `state` is at the pose and velocity of `step`, `asked` at those of its goal.
    pub fn solve(
        &mut self,
        state: &mut State,
        asked: &State,
        step: &ControlStep<'_>,
        stance: &Stance<'_>,
        wanted: &Wanted,
    ) {
        self.hessian.fill(0.0);
        self.gradient.fill(0.0);
        self.posture(step);
        self.momentum(state, step, stance.floor, wanted);
        self.soles(state, step, stance);
        self.knees(state, asked, step, stance);
        // the posture tasks make the matrix positive definite; a smaller pivot is a rounding error
        let hessian = std::mem::take(&mut self.hessian);
        let factor = Cholesky::new_with_substitute(hessian, f64::MIN_POSITIVE).expect("a pivot of its own");
        factor.solve_mut(&mut self.gradient);
        self.hessian = factor.unpack_dirty();
        self.accel.fill(0.0);
        for (&dof, x) in self.dofs.iter().zip(self.gradient.iter()) {
            self.accel[dof] = *x;
        }
    }

    /// Every joint back to the pose asked for.
    fn posture(&mut self, step: &ControlStep<'_>) {
        let ControlStep { model, q, v, goal_q, goal_v, .. } = *step;
        let mut c = 0;
        for &(body, weight) in &self.parts {
            let b = &model.bodies[body];
            let turn = |at: usize| log(&(quat_at(goal_q, at) * quat_at(q, at).inverse()));
            let mut ask = |k: usize, weight: f64, error: f64| {
                let dof = b.v_at + k;
                let back = JOINT_RAD_S * JOINT_RAD_S * error + 2.0 * JOINT_RAD_S * (goal_v[dof] - v[dof]);
                self.hessian[(c, c)] += weight;
                self.gradient[c] += weight * back;
                c += 1;
            };
            match b.joint {
                Joint::Free => {
                    (0..3).for_each(|k| ask(k, PLACE, goal_q[b.q_at + k] - q[b.q_at + k]));
                    let e = turn(b.q_at + 3);
                    (0..3).for_each(|k| ask(3 + k, weight, e[k]));
                }
                Joint::Spherical => {
                    let e = turn(b.q_at);
                    (0..3).for_each(|k| ask(k, weight, e[k]));
                }
                Joint::Revolute(_) | Joint::Prismatic(_) => ask(0, weight, goal_q[b.q_at] - q[b.q_at]),
                Joint::Fixed => {}
            }
        }
    }

    /// The rate of momentum: the wrench of the ground about the centre of pressure, on ground of the height `floor`, m.
    fn momentum(&mut self, state: &mut State, step: &ControlStep<'_>, floor: f64, wanted: &Wanted) {
        let model = step.model;
        state.mass_matrix(model, &mut self.mass);
        state.bias(model, step.v, &mut self.bias);
        let zero = state.bodies[0].zero;
        let arm = state.bodies[0].origin() - Vec3::new(wanted.pressure.x, floor, wanted.pressure.y);
        let world = |x: &[f64]| {
            let force = zero * vec_at(x, 0);
            (force, zero * vec_at(x, 3) + arm.cross(&force))
        };
        let (force, moment) = world(&self.bias);
        let up = -HEIGHT_RAD_S * (HEIGHT_RAD_S * wanted.above + 2.0 * wanted.rise);
        let asked = wanted.force + Vec3::y() * (up * model.mass);
        let (linear, angular) = (model.mass, model.mass * LENGTH);
        for k in 0..3 {
            for (x, &dof) in self.row.iter_mut().zip(&self.dofs) {
                *x = world(self.mass.column(dof).as_slice()).0[k] / linear;
            }
            self.task(if k == 1 { SOFT } else { FIRM }, (asked[k] - force[k]) / linear);
            for (x, &dof) in self.row.iter_mut().zip(&self.dofs) {
                *x = world(self.mass.column(dof).as_slice()).1[k] / angular;
            }
            self.task(FIRM, -moment[k] / angular);
        }
    }

    /// Soles stay where they were planted.
    fn soles(&mut self, state: &mut State, step: &ControlStep<'_>, stance: &Stance<'_>) {
        let model = step.model;
        let drift = &mut self.drift;
        drift.clear();
        state.drifts(model, step.v, |_, linear, angular| drift.push((linear, angular)));
        for (f, (foot, plant)) in stance.feet.iter().zip(stance.plants).enumerate() {
            let free = (1.0 - self.shares[f] / HELD).clamp(0.0, 1.0);
            let (back, damp) = (SOLE_RAD_S * SOLE_RAD_S * free, 2.0 * SOLE_RAD_S);
            let body = foot.body;
            let s = &state.bodies[body];
            let at = s.origin();
            let away = at - plant.world_from_end.translation.vector;
            let turned = log(&(s.world.rotation * plant.world_from_end.rotation.inverse()));
            let linear = -away * back - s.velocity * damp - self.drift[body].0;
            let angular = -turned * back - s.omega * damp - self.drift[body].1;
            for k in 0..6 {
                self.row.fill(0.0);
                let (row, column) = (&mut self.row, &self.column);
                state.jacobian(model, body, &at, |dof, l, a| {
                    if let Some(c) = column[dof] {
                        row[c] = if k < 3 { l[k] } else { a[k - 3] * LENGTH };
                    }
                });
                self.task(FIRM, if k < 3 { linear[k] } else { angular[k - 3] * LENGTH });
            }
        }
    }

    /// Legs do not turn about the line from ankle to hip, but with their feet: knees lie over them as in the goal.
    fn knees(&mut self, state: &State, asked: &State, step: &ControlStep<'_>, stance: &Stance<'_>) {
        let model = step.model;
        for (f, foot) in stance.feet.iter().enumerate() {
            let [upper, lower] = [foot.limb.upper, foot.limb.lower].map(|link| model.body_of[link].0);
            let (shin, sole) = (&state.bodies[lower], &state.bodies[foot.body]);
            let Some(line) = (state.bodies[upper].origin() - sole.origin()).try_normalize(1e-3) else {
                continue;
            };
            let turned = sole.world.rotation * asked.bodies[foot.body].world.rotation.inverse();
            // body and link frames differ by a constant, which both have
            let knee = model.body_of[foot.limb.lower].1.rotation * self.knees[f];
            let wanted = turned * (asked.bodies[lower].world.rotation * knee);
            let Some(off) = swivel::angle_about(&line, &(shin.world.rotation * knee), &wanted) else {
                continue;
            };
            let rate = line.dot(&(shin.omega - sole.omega));
            let back = KNEE_RAD_S * (KNEE_RAD_S * off - 2.0 * rate);
            self.row.fill(0.0);
            let (row, column) = (&mut self.row, &self.column);
            for (body, sign) in [(lower, 1.0), (foot.body, -1.0)] {
                state.jacobian(model, body, &sole.origin(), |dof, _, angular| {
                    if let Some(c) = column[dof] {
                        row[c] += sign * line.dot(&angular);
                    }
                });
            }
            let drift = line.dot(&(self.drift[lower].1 - self.drift[foot.body].1));
            self.task(KNEE, back - drift);
        }
    }

    /// Adds `weight` (row · v̇ − target)².
    fn task(&mut self, weight: f64, target: f64) {
        for (j, &y) in self.row.iter().enumerate() {
            let x = weight * y;
            if x != 0.0 {
                self.gradient[j] += x * target;
                for i in j..self.row.len() {
                    self.hessian[(i, j)] += x * self.row[i];
                }
            }
        }
    }

    /// Rests of the drives that give v̇ over the step, blended into `drives` by `level`; stiffness and damping stay. `state`
    /// is at the pose and velocity of `step`.
    pub fn drive(
        &mut self,
        state: &mut State,
        step: &ControlStep<'_>,
        stance: &Stance<'_>,
        level: f64,
        drives: &mut [Drive],
    ) {
        let ControlStep { model, q, v, dt, .. } = *step;
        let feet = stance.feet;
        state.inverse_dynamics(model, v, &self.accel, &[], &mut self.tau);
        let zero = state.bodies[0].zero;
        let force = zero * vec_at(&self.tau, 0);
        let arm = state.bodies[0].origin() - Vec3::y() * stance.floor;
        let moment = zero * vec_at(&self.tau, 3) + arm.cross(&force);
        if force.y > 0.0 {
            let at = Vec2::new(moment.z, -moment.x) / force.y;
            let (shares, mut loads) = if stance.even_load {
                let centers: Vec<Vec3> = feet.iter().map(|f| f.center(model, state)).collect();
                let shares = vec![1.0 / feet.len() as f64; feet.len()];
                let loads = shared_wrenches(feet, &centers, &shares, at, force);
                (shares, loads)
            } else {
                pressed_wrenches(feet, model, state, at, force)
            };
            let about = moment - Vec3::new(at.x, 0.0, at.y).cross(&force);
            loads.iter_mut().zip(&shares).for_each(|(w, share)| w.moment += Vec3::y() * (about.y * share));
            state.inverse_dynamics(model, v, &self.accel, &loads, &mut self.tau);
            self.shares = shares;
        }
        self.later_v.copy_from_slice(v);
        self.later_v.iter_mut().zip(&self.accel).for_each(|(v, a)| *v += a * dt);
        self.later_q.copy_from_slice(q);
        model.skeleton.integrate(&mut self.later_q, &self.later_v, dt);
        for &(body, _) in &self.parts[1..] {
            let b = &model.bodies[body];
            let drive = &mut drives[body];
            let load = -joint_force(&b.joint, &self.tau, b.v_at)
                - joint_force(&b.joint, &self.later_v, b.v_at) * drive.damping;
            let target = rest_of(model, body, &self.later_q);
            let rest = step.set_points[body].rest(&target, load, drive.stiffness);
            drive.rest = drive.rest.blend(&rest, level);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use bodies::Character;
    use motion::support::ground;

    use super::*;

    struct Standing {
        character: Arc<Character>,
        model: Model,
        state: State,
        feet: Vec<Foot>,
        plants: Vec<Plant>,
        body: WholeBody,
    }

    fn standing() -> Standing {
        let character = Arc::new(bodies::anthropometry::human::human().0);
        let model = Model::new(&character, Vec3::new(0.0, -9.81, 0.0));
        let feet = Foot::of(&character, &model);
        let plants =
            feet.iter().map(|f| Plant::here(&character.skeleton, &character.rest, &f.limb)).collect();
        let spine: Vec<usize> =
            ["abdomen", "chest"].map(|n| model.body_of[character.skeleton.link(n).unwrap()].0).to_vec();
        let body = WholeBody::new(&model, &feet, &spine, &[]);
        let state = State::new(&model);
        Standing { character, model, state, feet, plants, body }
    }

    /// Whatever force through whatever point of the support is asked for: the root needs no other wrench, the soles
    /// stay, and the loads of the feet are theirs to give.
    #[test]
    fn the_ground_gives_what_is_asked_and_soles_stay() {
        let Standing { character, model, mut state, feet, plants, mut body } = standing();
        let rest = &character.rest;
        let still = vec![0.0; model.nv()];
        state.update(&model, rest, &still);
        let floor = feet[0].center(&model, &state).y;
        let com = state.com(&model);
        let weight = model.mass * 9.81;
        let step = ControlStep {
            model: &model,
            set_points: &[],
            impedances: &[],
            q: rest,
            v: &still,
            contacts: &[],
            goal_q: rest,
            goal_v: &still,
            lift: 0.0,
            feed: None,
            time_s: 0.0,
            dt: 1.0 / 240.0,
        };
        let stance = Stance { feet: &feet, plants: &plants, floor, even_load: false };
        for (x, z) in [(0.0, 0.0), (0.12, 0.0), (-0.12, 0.08), (0.05, -0.06)] {
            let pressure = ground(&com) + Vec2::new(x, z);
            let force = Vec3::new(-0.8 * x * weight, weight, -0.8 * z * weight);
            let wanted = Wanted { force, pressure, above: 0.0, rise: 0.0 };
            let asked = state.clone();
            body.solve(&mut state, &asked, &step, &stance, &wanted);
            let mut tau = still.clone();
            state.inverse_dynamics(&model, &still, &body.accel, &[], &mut tau);
            let root = vec_at(&tau, 0);
            let about = state.bodies[0].origin() - Vec3::new(pressure.x, floor, pressure.y);
            let moment = vec_at(&tau, 3) + about.cross(&root);
            let off = (root - force).component_mul(&Vec3::new(1.0, 0.0, 1.0)).norm();
            assert!(off < 0.002 * weight, "{x} {z}: {off} N"); // constraints are weights
            assert!(moment.norm() < 0.002 * weight, "{x} {z}: {moment}");
            for foot in &feet {
                let mut moved = (Vec3::zeros(), Vec3::zeros());
                let at = state.bodies[foot.body].origin();
                state.jacobian(&model, foot.body, &at, |dof, l, a| {
                    moved.0 += l * body.accel[dof];
                    moved.1 += a * body.accel[dof];
                });
                assert!(moved.0.norm() < 0.05 && moved.1.norm() < 0.2, "{x} {z}: {moved:?}");
            }
        }
    }
}
