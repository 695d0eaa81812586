//! Model and scratch: a character compiled for dynamics, and the memory its algorithms reuse.
//!
//! In: a [`Character`]. Out: an immutable [`Model`] of moving bodies (links welded by `Fixed` joints are
//! fused into the body that carries them) and a [`State`] of world-frame kinematics that RNEA, the mass
//! matrix, momentum and energy share. Nothing here allocates after construction.
//!
//! Everything is expressed along world axes at the bodies' own origins: the spatial algebra of
//! Featherstone (Rigid Body Dynamics Algorithms, 2008) written out in 3-vectors. `q` and `v` follow
//! [`motion::skeleton`]: velocities are along the axes of each joint's zero frame.

use std::sync::Arc;

use motion::skeleton::{quat_at, vec_at};
use motion::{Joint, Quat, Skeleton, Transform, Vec3};
use nalgebra::{Matrix3, Quaternion};

use crate::composite::Composite;
use bodies::Character;
use bodies::mass::fuse;

/// One moving body: a link and every link welded to it.
#[derive(Clone, Debug)]
pub struct MovingBody {
    /// The link whose joint moves it.
    pub link: usize,
    /// The body that carries it.
    pub parent: Option<usize>,
    /// Zero frame of its joint in the parent body's frame.
    pub parent_from_zero: Transform,
    /// Rotation of the zero frame in the parent body's frame; `None` where it is the identity.
    pub(crate) turned: Option<Matrix3<f64>>,
    /// Its joint.
    pub joint: Joint,
    /// Start of its joint value in `q`.
    pub q_at: usize,
    /// Start of its joint velocity in `v`.
    pub v_at: usize,
    /// Fused mass, kg.
    pub mass: f64,
    /// Fused centre of mass in the body's frame (that of its link), m.
    pub com: Vec3,
    /// Fused inertia about `com`, body axes, kg·m².
    pub inertia: Matrix3<f64>,
}

/// A character compiled for dynamics. See the module header.
#[derive(Clone, Debug)]
pub struct Model {
    /// Layout of `q` and `v`.
    pub skeleton: Arc<Skeleton>,
    /// Moving bodies, parents first.
    pub bodies: Vec<MovingBody>,
    /// For every link: the body it belongs to, and the link's frame in that body's frame.
    pub body_of: Vec<(usize, Transform)>,
    /// Total mass, kg.
    pub mass: f64,
    /// Gravity, world, m/s².
    pub gravity: Vec3,
}

impl Model {
    /// Compiles a character; `gravity` in m/s², world.
    ///
    /// A root welded to the world stays a body of its own, without degrees of freedom.
    pub fn new(character: &Character, gravity: Vec3) -> Self {
        let skeleton = character.skeleton.clone();
        let mut bodies: Vec<MovingBody> = Vec::new();
        let mut body_of: Vec<(usize, Transform)> = Vec::new();
        for (i, link) in skeleton.links().iter().enumerate() {
            let source = &character.bodies[i];
            let (parent, parent_from_zero) = match link.parent {
                Some(p) => {
                    let (body, body_from_link) = body_of[p];
                    (Some(body), body_from_link * link.parent_from_zero)
                }
                None => (None, link.parent_from_zero),
            };
            if let (Joint::Fixed, Some(p)) = (link.joint, parent) {
                let com = (parent_from_zero * nalgebra::Point3::from(source.com)).coords;
                let r = parent_from_zero.rotation.to_rotation_matrix();
                let inertia = r.matrix() * source.inertia * r.matrix().transpose();
                let b = &mut bodies[p];
                (b.mass, b.com, b.inertia) = fuse((b.mass, b.com, b.inertia), (source.mass, com, inertia));
                body_of.push((p, parent_from_zero));
                continue;
            }
            body_of.push((bodies.len(), Transform::identity()));
            bodies.push(MovingBody {
                link: i,
                parent,
                parent_from_zero,
                turned: turned(&parent_from_zero),
                joint: link.joint,
                q_at: skeleton.q_at(i),
                v_at: skeleton.v_at(i),
                mass: source.mass,
                com: source.com,
                inertia: source.inertia,
            });
        }
        let mass = bodies.iter().map(|b| b.mass).sum();
        Self { skeleton, bodies, body_of, mass, gravity }
    }

    /// Degrees of freedom.
    pub fn nv(&self) -> usize {
        self.skeleton.nv()
    }

    /// Whether `ancestor` carries `body` (or is it).
    pub fn carries(&self, ancestor: usize, body: usize) -> bool {
        let mut up = Some(body);
        while let Some(b) = up {
            if b == ancestor {
                return true;
            }
            up = self.bodies[b].parent;
        }
        false
    }
}

fn turned(t: &Transform) -> Option<Matrix3<f64>> {
    (t.rotation != motion::Quat::identity()).then(|| *t.rotation.to_rotation_matrix().matrix())
}

/// World-frame kinematics of one body.
#[derive(Clone, Copy, Debug)]
pub struct BodyState {
    /// `world_from_body`.
    pub world: Transform,
    /// Rotation of the body in the world: that of `world`, as a matrix.
    pub rotation: Matrix3<f64>,
    /// Rotation of the joint's zero frame in the world: the axes of `v`.
    pub zero: Matrix3<f64>,
    /// Centre of mass, world, m.
    pub com: Vec3,
    /// Inertia about the centre of mass, world axes, kg·m².
    pub inertia: Matrix3<f64>,
    /// Angular velocity, world, rad/s.
    pub omega: Vec3,
    /// Velocity of the body's origin, world, m/s.
    pub velocity: Vec3,
    /// Axis of a hinge or slide, world.
    pub(crate) axis: Vec3,
    /// From the parent body's origin to this body's, world, m.
    pub(crate) arm: Vec3,
    /// From the body's origin to its centre of mass, world, m.
    pub(crate) to_com: Vec3,
}

impl BodyState {
    /// Position of the body's origin, world, m.
    pub fn origin(&self) -> Vec3 {
        self.world.translation.vector
    }

    /// Linear and angular motion of the joint, `S v`, world axes.
    #[inline(always)]
    pub(crate) fn joint_motion(&self, b: &MovingBody, v: &[f64]) -> (Vec3, Vec3) {
        let none = Vec3::zeros();
        match b.joint {
            Joint::Free => (self.zero * vec_at(v, b.v_at), self.zero * vec_at(v, b.v_at + 3)),
            Joint::Spherical => (none, self.zero * vec_at(v, b.v_at)),
            Joint::Revolute(_) => (none, self.axis * v[b.v_at]),
            Joint::Prismatic(_) => (self.axis * v[b.v_at], none),
            Joint::Fixed => (none, none),
        }
    }

    /// Writes the joint's share of a force and a moment about the body's origin, `Sᵀ f`, into `out`.
    #[inline(always)]
    pub(crate) fn project(&self, b: &MovingBody, force: &Vec3, moment: &Vec3, out: &mut [f64]) {
        let at = b.v_at;
        match b.joint {
            Joint::Free => {
                let out = &mut out[at..at + 6];
                out[..3].copy_from_slice(self.zero.tr_mul(force).as_slice());
                out[3..].copy_from_slice(self.zero.tr_mul(moment).as_slice());
            }
            Joint::Spherical => out[at..at + 3].copy_from_slice(self.zero.tr_mul(moment).as_slice()),
            Joint::Revolute(_) => out[at] = self.axis.dot(moment),
            Joint::Prismatic(_) => out[at] = self.axis.dot(force),
            Joint::Fixed => {}
        }
    }
}

/// Force and moment about a body's origin, and the accelerations they came from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flow {
    pub alpha: Vec3,
    pub accel: Vec3,
    pub force: Vec3,
    pub moment: Vec3,
}

impl Flow {
    pub(crate) fn zero() -> Self {
        let o = Vec3::zeros();
        Self { alpha: o, accel: o, force: o, moment: o }
    }
}

/// Kinematics of all bodies of a model in one state, and scratch for the algorithms.
#[derive(Clone, Debug)]
pub struct State {
    /// One per body.
    pub bodies: Vec<BodyState>,
    pub(crate) flow: Vec<Flow>,
    pub(crate) composite: Vec<(f64, Vec3, Matrix3<f64>)>,
    pub(crate) carried: Vec<Composite>,
}

impl State {
    /// Memory for `model`, at the zero pose and at rest.
    pub fn new(model: &Model) -> Self {
        let n = model.bodies.len();
        let body = BodyState {
            world: Transform::identity(),
            rotation: Matrix3::identity(),
            zero: Matrix3::identity(),
            com: Vec3::zeros(),
            inertia: Matrix3::zeros(),
            omega: Vec3::zeros(),
            velocity: Vec3::zeros(),
            axis: Vec3::zeros(),
            arm: Vec3::zeros(),
            to_com: Vec3::zeros(),
        };
        let mut state = Self {
            bodies: vec![body; n],
            flow: vec![Flow::zero(); n],
            composite: vec![(0.0, Vec3::zeros(), Matrix3::zeros()); n],
            carried: vec![Composite::default(); n],
        };
        state.update(model, &model.skeleton.zero_pose(), &vec![0.0; model.nv()]);
        state
    }

    /// Recomputes positions and velocities for the pose `q` (`nq`) and velocity `v` (`nv`).
    ///
    /// [`State::update_pose`], then Featherstone 2008, (5.7): velocities outward.
    pub fn update(&mut self, model: &Model, q: &[f64], v: &[f64]) {
        self.update_pose(model, q);
        self.update_velocity(model, v);
    }

    /// Recomputes velocities for the velocity `v` (`nv`) in the pose of the last update; positions stay as they are.
    pub fn update_velocity(&mut self, model: &Model, v: &[f64]) {
        for (i, b) in model.bodies.iter().enumerate() {
            let s = &self.bodies[i];
            let (linear, angular) = s.joint_motion(b, v);
            let (omega, velocity) = match b.parent {
                Some(p) => {
                    let p = &self.bodies[p];
                    (p.omega + angular, p.velocity + p.omega.cross(&s.arm) + linear)
                }
                None => (angular, linear),
            };
            let s = &mut self.bodies[i];
            (s.omega, s.velocity) = (omega, velocity);
        }
    }

    /// Recomputes positions for the pose `q` (`nq`); velocities stay as they were.
    ///
    /// Enough for what depends on the pose alone: mass matrix, centre of mass, composites, gravity.
    pub fn update_pose(&mut self, model: &Model, q: &[f64]) {
        for (i, b) in model.bodies.iter().enumerate() {
            let offset = b.parent_from_zero.translation.vector;
            let (turn, rotation, mut arm, base) = match b.parent {
                Some(p) => {
                    let p = &self.bodies[p];
                    (p.world.rotation, p.rotation, p.rotation * offset, p.origin())
                }
                None => (Quat::identity(), Matrix3::identity(), offset, Vec3::zeros()),
            };
            let (zero, turn) = match &b.turned {
                Some(turned) => (rotation * turned, turn * b.parent_from_zero.rotation),
                None => (rotation, turn),
            };
            let s = &mut self.bodies[i];
            let turn = match b.joint {
                Joint::Free => {
                    arm += zero * vec_at(q, b.q_at);
                    turn * quat_at(q, b.q_at + 3)
                }
                Joint::Spherical => turn * quat_at(q, b.q_at),
                Joint::Revolute(axis) => {
                    s.axis = zero * axis;
                    let (sin, cos) = (0.5 * q[b.q_at]).sin_cos();
                    turn * Quat::new_unchecked(Quaternion::from_parts(cos, axis * sin))
                }
                Joint::Prismatic(axis) => {
                    s.axis = zero * axis;
                    arm += s.axis * q[b.q_at];
                    turn
                }
                Joint::Fixed => turn,
            };
            s.zero = zero;
            s.rotation = *turn.to_rotation_matrix().matrix();
            s.arm = arm;
            s.world = Transform::from_parts((base + arm).into(), turn);
            s.to_com = s.rotation * b.com;
            s.com = s.world.translation.vector + s.to_com;
            s.inertia = turned_inertia(&s.rotation, &b.inertia);
        }
    }

    /// Velocity of a body's centre of mass, world, m/s.
    pub fn com_velocity(&self, body: usize) -> Vec3 {
        let s = &self.bodies[body];
        s.velocity + s.omega.cross(&(s.com - s.world.translation.vector))
    }

    /// World position of a point given in a link's frame, m.
    pub fn point(&self, model: &Model, link: usize, at: &Vec3) -> Vec3 {
        let (body, body_from_link) = model.body_of[link];
        (self.bodies[body].world * body_from_link * nalgebra::Point3::from(*at)).coords
    }

    /// World velocity of a point that moves with a link, m/s.
    pub fn point_velocity(&self, model: &Model, link: usize, at: &Vec3) -> Vec3 {
        let s = &self.bodies[model.body_of[link].0];
        let arm = self.point(model, link, at) - s.world.translation.vector;
        s.velocity + s.omega.cross(&arm)
    }
}

/// R I Rᵀ for a symmetric I: six entries, mirrored.
#[inline(always)]
fn turned_inertia(r: &Matrix3<f64>, inertia: &Matrix3<f64>) -> Matrix3<f64> {
    let half = r * inertia;
    let entry =
        |i: usize, j: usize| half[(i, 0)] * r[(j, 0)] + half[(i, 1)] * r[(j, 1)] + half[(i, 2)] * r[(j, 2)];
    let (xy, xz, yz) = (entry(0, 1), entry(0, 2), entry(1, 2));
    Matrix3::new(entry(0, 0), xy, xz, xy, entry(1, 1), yz, xz, yz, entry(2, 2))
}

/// Columns of a joint's motion subspace along world axes: calls `f(dof, linear, angular)` for each.
pub(crate) fn for_each_axis(body: &MovingBody, zero: &Matrix3<f64>, mut f: impl FnMut(usize, Vec3, Vec3)) {
    let none = Vec3::zeros();
    let at = body.v_at;
    let column = |k: usize| zero.column(k).into_owned();
    match &body.joint {
        Joint::Free => {
            for k in 0..3 {
                f(at + k, column(k), none);
            }
            for k in 0..3 {
                f(at + 3 + k, none, column(k));
            }
        }
        Joint::Spherical => {
            for k in 0..3 {
                f(at + k, none, column(k));
            }
        }
        Joint::Revolute(axis) => f(at, none, zero * axis),
        Joint::Prismatic(axis) => f(at, zero * axis, none),
        Joint::Fixed => {}
    }
}
