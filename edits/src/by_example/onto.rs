//! A motion on a body of other proportions: the same links and joints, other bone lengths.
//!
//! In: a motion, the skeleton of the other body. Out: the motion on it. Angles of joints are kept as they are; the root's way over the ground
//! and its height over the floor grow by the ratio of the legs ([`leg_m`]), so that a foot that stands goes on standing where legs grow as a
//! whole. Slides grow by the ratio of sizes. What hips or feet of other proportions do to a foot is not taken back.
//!
//! Units: m.

use std::sync::Arc;

use motion::symmetry::size_m;
use motion::{Joint, Kinematics, Skeleton, Vec3};
use nalgebra::DMatrix;

use super::outputs::{self, Allowed};
use super::{ExampleError, Rig};
use crate::Motion;

/// Zero frames of joints may be turned this far against each other and count as the same, rad.
const SAME_FRAME_RAD: f64 = 1e-6;
/// A root lower over the lowest point of the zero pose than this part of the size has no legs under it.
const LEGS: f64 = 0.2;

/// Another body, and how much longer its legs are.
#[derive(Clone, Debug, PartialEq)]
pub struct Onto {
    /// Its skeleton: the links and joints of the motion's, in their order.
    pub skeleton: Arc<Skeleton>,
}

/// Height of the root over the lowest point of the zero pose, m: how long legs are; `None` of a body without legs under its root.
pub fn leg_m(skeleton: &Skeleton) -> Option<f64> {
    let height = {
        let k = Kinematics::new(skeleton, &skeleton.zero_pose());
        k.origin(0).y - lowest(skeleton, &k)
    };
    (height > LEGS * size_m(skeleton)).then_some(height)
}

/// Height of the lowest joint or end of a bone, m.
fn lowest(skeleton: &Skeleton, k: &Kinematics) -> f64 {
    let links = skeleton.links().iter().enumerate();
    let points = links.flat_map(|(i, link)| [Some(k.origin(i)), link.end.map(|e| k.point(i, &e))]);
    points.flatten().map(|p| p.y).fold(f64::INFINITY, f64::min)
}

impl Onto {
    /// How much longer the legs are than those of `other`; the ratio of sizes where one of them has none.
    pub fn ratio(&self, other: &Skeleton) -> f64 {
        match (leg_m(&self.skeleton), leg_m(other)) {
            (Some(to), Some(from)) => to / from,
            _ => size_m(&self.skeleton) / size_m(other),
        }
    }

    /// The motion on this body; contacts and times stay. Heights grow over its floor, or over its lowest point where no floor is known.
    ///
    /// # Errors
    /// [`ExampleError::OtherRig`]: other links or joints; what [`Rig::of`] refuses.
    pub fn place(&self, motion: &Motion) -> Result<Motion, ExampleError> {
        let (from, to) = (&motion.clip.skeleton, &self.skeleton);
        same_joints(from, to)?;
        let rig = Rig::of(from)?;
        Rig::find(rig.file(), to)?;
        let ratio = self.ratio(from);
        let none = DMatrix::zeros(motion.clip.frames(), outputs::width(&rig));
        let nothing = Allowed {
            joints: vec![false; rig.joints().len()],
            tilt: false,
            height: false,
            steps: false,
            time: false,
        };
        let mut clip = outputs::add(&rig, &motion.clip, &none, &nothing, to, ratio * rig.size_m);
        let floor = motion.floor_m.unwrap_or_else(|| {
            let mut k = Kinematics::new(from, motion.clip.pose(0));
            (0..motion.clip.frames())
                .map(|f| {
                    k.update(from, motion.clip.pose(f));
                    lowest(from, &k)
                })
                .fold(f64::INFINITY, f64::min)
        });
        let up = to.links()[0].parent_from_zero.rotation.inverse() * Vec3::y() * (floor * (1.0 - ratio));
        let larger = size_m(to) / size_m(from);
        let slides: Vec<usize> = (to.links().iter().enumerate())
            .filter(|(_, l)| matches!(l.joint, Joint::Prismatic(_)))
            .map(|(i, _)| to.q_at(i))
            .collect();
        for f in 0..clip.frames() {
            let q = clip.pose_mut(f);
            let at = to.position(q, 0) + up;
            to.set_position(q, 0, &at);
            slides.iter().for_each(|&i| q[i] *= larger);
        }
        Ok(Motion { clip, seen: None, ..motion.clone() })
    }
}

/// Whether poses of one skeleton are poses of the other.
fn same_joints(from: &Skeleton, to: &Skeleton) -> Result<(), ExampleError> {
    let fault = |what: String| Err(ExampleError::OtherRig { what });
    let (a, b) = (from.links(), to.links());
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        if a.name != b.name {
            return fault(format!("link {i} of the body is `{}`, that of the clip `{}`", b.name, a.name));
        }
        let turned = a.parent_from_zero.rotation.angle_to(&b.parent_from_zero.rotation);
        if a.joint != b.joint || a.parent != b.parent || turned > SAME_FRAME_RAD {
            return fault(format!("the joint `{}` of the body is another than that of the clip", b.name));
        }
    }
    if a.len() != b.len() {
        return fault(format!("the body has {} links, the clip {}", b.len(), a.len()));
    }
    Ok(())
}
