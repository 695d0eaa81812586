//! Between our vectors and MuJoCo's.
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

use crate::bridge::ModelInfo;

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

/// The map between a skeleton's vectors and a loaded model's.
#[derive(Clone, Debug)]
pub struct Layout {
    entries: Vec<Entry>,
    /// Length of MuJoCo's poses.
    pub nq: usize,
    /// Length of MuJoCo's velocities.
    pub nv: usize,
    ours: (usize, usize),
}

/// Two models that do not have the same joints.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LayoutError {
    /// Another number of joints.
    #[error("ours has {ours} moving joints, MuJoCo's {theirs}")]
    Count {
        /// Joints here.
        ours: usize,
        /// Joints there.
        theirs: usize,
    },
    /// Another kind of joint.
    #[error("the joint `{name}` is a {theirs} in MuJoCo and not in ours")]
    Kind {
        /// Name there.
        name: String,
        /// Kind there.
        theirs: String,
    },
}

impl Layout {
    /// The map from the joints of `links`, in MuJoCo's order, to those of `info`.
    ///
    /// Poses of a free joint are taken to the world through its zero frame; with `file_axes` they stay in the
    /// axes of the file, for models whose zero frames turn the file's world into ours.
    ///
    /// # Errors
    /// [`LayoutError`].
    pub fn new(
        skeleton: &Skeleton,
        links: &[usize],
        info: &ModelInfo,
        file_axes: bool,
    ) -> Result<Self, LayoutError> {
        if links.len() != info.joints.len() {
            return Err(LayoutError::Count { ours: links.len(), theirs: info.joints.len() });
        }
        let mut entries = Vec::new();
        for (&link, there) in links.iter().zip(&info.joints) {
            let l = &skeleton.links()[link];
            let kind = match l.joint {
                Joint::Free => "free",
                Joint::Spherical => "ball",
                Joint::Revolute(_) => "hinge",
                Joint::Prismatic(_) => "slide",
                Joint::Fixed => "weld",
            };
            if kind != there.kind {
                return Err(LayoutError::Kind { name: there.name.clone(), theirs: there.kind.clone() });
            }
            entries.push(Entry {
                joint: l.joint,
                q: skeleton.q_at(link),
                v: skeleton.v_at(link),
                their_q: there.q,
                their_v: there.v,
                zero: if file_axes { Transform::identity() } else { world_from_zero(skeleton, link) },
            });
        }
        Ok(Self { entries, nq: info.nq, nv: info.nv, ours: (skeleton.nq(), skeleton.nv()) })
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
    let mut out = Transform::identity();
    let mut up = Some(link);
    while let Some(l) = up {
        let link = &skeleton.links()[l];
        out = link.parent_from_zero * out;
        up = link.parent;
    }
    out
}

fn unit(x: &[f64], at: usize) -> Quat {
    Quat::new_normalize(nalgebra::Quaternion::new(x[at], x[at + 1], x[at + 2], x[at + 3]))
}

fn store(to: &mut [f64], r: &Quat) {
    to.copy_from_slice(&[r.w, r.i, r.j, r.k]);
}
