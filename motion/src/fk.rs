//! Forward kinematics: joint values to world transforms.
//!
//! In: a [`Skeleton`] and a pose vector. Out: `world_from_link` of every link. Allocates only when
//! built; [`Kinematics::update`] reuses its memory.

use crate::rotation::Vec3;
use crate::{Skeleton, Transform};

/// World transforms of all links of one pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Kinematics {
    /// `world_from_link`, in the order of the skeleton's links.
    pub world: Vec<Transform>,
}

impl Kinematics {
    /// Transforms of `skeleton` in the pose `q` (length `nq`).
    pub fn new(skeleton: &Skeleton, q: &[f64]) -> Self {
        let mut k = Self { world: vec![Transform::identity(); skeleton.links().len()] };
        k.update(skeleton, q);
        k
    }

    /// Recomputes the transforms for the pose `q` (length `nq`).
    pub fn update(&mut self, skeleton: &Skeleton, q: &[f64]) {
        for (i, link) in skeleton.links().iter().enumerate() {
            let local = link.parent_from_zero * skeleton.joint_transform(q, i);
            self.world[i] = match link.parent {
                Some(p) => self.world[p] * local,
                None => local,
            };
        }
    }

    /// World position of the point `at` (m, link frame) of `link`.
    pub fn point(&self, link: usize, at: &Vec3) -> Vec3 {
        (self.world[link] * nalgebra::Point3::from(*at)).coords
    }

    /// World position of the origin of `link`, m.
    pub fn origin(&self, link: usize) -> Vec3 {
        self.world[link].translation.vector
    }
}
