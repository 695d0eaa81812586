//! Between our vectors and MuJoCo's.
//!
//! In and out: poses, velocities, accelerations and generalised forces, flat. The numbers of a pose are the same
//! up to their order; rotations differ in the axes of their velocities:
//!
//! | joint | ours | MuJoCo's |
//! |---|---|---|
//! | free | pose in its zero frame; linear and angular velocity along the zero frame | pose in the world; linear along the world, angular along the moving body |
//! | ball | quaternion; angular velocity along the zero frame | the same quaternion; angular velocity along the moving body |
//! | hinge, slide | – | the same |
//!
//! With the joint's rotation R: ω_body = Rᵀ ω, and because Ṙᵀ ω = −Rᵀ ω × ω = 0 also ω̇_body = Rᵀ ω̇; torques as
//! velocities, so that power is the same number. The poses of the zero frame of a free joint do not move: it
//! hangs on the world.

use motion::skeleton::{quat_at, vec_at};
use motion::{Joint, Quat, Skeleton, Transform, Vec3};

/// A joint in both vectors.
#[derive(Clone, Copy, Debug)]
struct Entry {
    joint: Joint,
    q: usize,
    v: usize,
    their_q: usize,
    their_v: usize,
    zero: Transform,
}

/// The map between a skeleton's vectors and a model's in MuJoCo. See the module header.
#[derive(Clone, Debug)]
pub struct Layout {
    entries: Vec<Entry>,
    /// Length of MuJoCo's poses.
    pub nq: usize,
    /// Length of MuJoCo's velocities.
    pub nv: usize,
    ours: (usize, usize),
}

/// Where MuJoCo keeps a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JointThere {
    /// Our link, whose joint it is.
    pub link: usize,
    /// Start in `qpos`.
    pub q: usize,
    /// Start in `qvel`.
    pub v: usize,
}

impl Layout {
    /// The map for the moving joints of a skeleton, each at its place in MuJoCo's vectors of lengths `nq`, `nv`.
    ///
    /// Poses of a free joint are taken to the world through its zero frame.
    pub fn new(skeleton: &Skeleton, joints: &[JointThere], nq: usize, nv: usize) -> Self {
        Self::with_zero(skeleton, joints, (nq, nv), |link| world_from_zero(skeleton, link))
    }

    /// The map for the character of a model read from a file: poses of free joints stay in the axes of the file, into which the
    /// zero frames of its character are turned.
    pub fn in_file_axes(skeleton: &Skeleton, joints: &[JointThere], nq: usize, nv: usize) -> Self {
        Self::with_zero(skeleton, joints, (nq, nv), |_| Transform::identity())
    }

    fn with_zero(
        skeleton: &Skeleton,
        joints: &[JointThere],
        (nq, nv): (usize, usize),
        zero: impl Fn(usize) -> Transform,
    ) -> Self {
        let entry = |there: &JointThere| Entry {
            joint: skeleton.links()[there.link].joint,
            q: skeleton.q_at(there.link),
            v: skeleton.v_at(there.link),
            their_q: there.q,
            their_v: there.v,
            zero: zero(there.link),
        };
        let entries = joints.iter().map(entry).collect();
        Self { entries, nq, nv, ours: (skeleton.nq(), skeleton.nv()) }
    }

    /// Our pose as MuJoCo's.
    pub fn pose(&self, q: &[f64], out: &mut [f64]) {
        for e in &self.entries {
            let to = &mut out[e.their_q..];
            match e.joint {
                Joint::Free => {
                    let at = e.zero * Transform::from_parts(vec_at(q, e.q).into(), quat_at(q, e.q + 3));
                    to[..3].copy_from_slice(at.translation.vector.as_slice());
                    store(&mut to[3..7], &at.rotation);
                }
                Joint::Spherical => to[..4].copy_from_slice(&q[e.q..e.q + 4]),
                Joint::Revolute(_) | Joint::Prismatic(_) => to[0] = q[e.q],
                Joint::Fixed => {}
            }
        }
    }

    /// MuJoCo's pose as ours.
    pub fn pose_back(&self, theirs: &[f64], q: &mut [f64]) {
        for e in &self.entries {
            let from = &theirs[e.their_q..];
            match e.joint {
                Joint::Free => {
                    let at = Transform::from_parts(vec_at(from, 0).into(), unit(from, 3));
                    let at = e.zero.inverse() * at;
                    q[e.q..e.q + 3].copy_from_slice(at.translation.vector.as_slice());
                    store(&mut q[e.q + 3..e.q + 7], &at.rotation);
                }
                Joint::Spherical => store(&mut q[e.q..e.q + 4], &unit(from, 0)),
                Joint::Revolute(_) | Joint::Prismatic(_) => q[e.q] = from[0],
                Joint::Fixed => {}
            }
        }
    }

    /// Our velocities, accelerations or generalised forces as MuJoCo's, in our pose `q`.
    pub fn tangent(&self, q: &[f64], v: &[f64], out: &mut [f64]) {
        for e in &self.entries {
            let to = &mut out[e.their_v..];
            match e.joint {
                Joint::Free => {
                    let linear = e.zero.rotation * vec_at(v, e.v);
                    let angular = quat_at(q, e.q + 3).inverse() * vec_at(v, e.v + 3);
                    to[..3].copy_from_slice(linear.as_slice());
                    to[3..6].copy_from_slice(angular.as_slice());
                }
                Joint::Spherical => {
                    let angular = quat_at(q, e.q).inverse() * vec_at(v, e.v);
                    to[..3].copy_from_slice(angular.as_slice());
                }
                Joint::Revolute(_) | Joint::Prismatic(_) => to[0] = v[e.v],
                Joint::Fixed => {}
            }
        }
    }

    /// MuJoCo's velocities, accelerations or generalised forces as ours, in our pose `q`.
    pub fn tangent_back(&self, q: &[f64], theirs: &[f64], v: &mut [f64]) {
        for e in &self.entries {
            let from = &theirs[e.their_v..];
            match e.joint {
                Joint::Free => {
                    let linear = e.zero.rotation.inverse() * vec_at(from, 0);
                    let angular = quat_at(q, e.q + 3) * vec_at(from, 3);
                    v[e.v..e.v + 3].copy_from_slice(linear.as_slice());
                    v[e.v + 3..e.v + 6].copy_from_slice(angular.as_slice());
                }
                Joint::Spherical => {
                    let angular: Vec3 = quat_at(q, e.q) * vec_at(from, 0);
                    v[e.v..e.v + 3].copy_from_slice(angular.as_slice());
                }
                Joint::Revolute(_) | Joint::Prismatic(_) => v[e.v] = from[0],
                Joint::Fixed => {}
            }
        }
    }

    /// Lengths of our poses and velocities.
    pub fn ours(&self) -> (usize, usize) {
        self.ours
    }
}

/// Zero frame of a joint that hangs on the world, through welds only.
fn world_from_zero(skeleton: &Skeleton, link: usize) -> Transform {
    let frames = skeleton.ancestors(link).map(|l| skeleton.links()[l].parent_from_zero);
    frames.fold(Transform::identity(), |out, zero| zero * out)
}

fn unit(x: &[f64], at: usize) -> Quat {
    Quat::new_normalize(nalgebra::Quaternion::new(x[at], x[at + 1], x[at + 2], x[at + 3]))
}

fn store(to: &mut [f64], r: &Quat) {
    to.copy_from_slice(&[r.w, r.i, r.j, r.k]);
}
