//! Joint axes of a posed skeleton in the world: the columns of every point's Jacobian.
//!
//! In: a skeleton and its kinematics. Out: for each degree of freedom the direction it slides along or turns
//! about, and where; the degrees of freedom that carry each link. One column in the layout of
//! [`motion::skeleton`]: `∂p/∂q_k = linear_k + angular_k × (p − origin_k)`.

use motion::{Joint, Kinematics, Skeleton, Vec3};

/// One degree of freedom in the world.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Axis {
    pub linear: Vec3,
    pub angular: Vec3,
    pub origin: Vec3,
}

impl Axis {
    /// Velocity of a point at unit rate.
    #[inline]
    pub fn column(&self, p: &Vec3) -> Vec3 {
        self.linear + self.angular.cross(&(p - self.origin))
    }
}

/// All axes of one pose. See the module header.
#[derive(Clone, Debug)]
pub(crate) struct Axes {
    /// One per degree of freedom.
    pub all: Vec<Axis>,
    /// For each link, the degrees of freedom that carry it, in ascending order.
    pub chain: Vec<Vec<usize>>,
}

impl Axes {
    pub fn new(skeleton: &Skeleton) -> Self {
        let mut chain: Vec<Vec<usize>> = Vec::new();
        for (i, link) in skeleton.links().iter().enumerate() {
            let mut own = link.parent.map_or(Vec::new(), |p| chain[p].clone());
            own.extend(skeleton.v_at(i)..skeleton.v_at(i) + link.joint.nv());
            chain.push(own);
        }
        Self { all: vec![Axis::default(); skeleton.nv()], chain }
    }

    pub fn update(&mut self, skeleton: &Skeleton, k: &Kinematics) {
        let none = Vec3::zeros();
        for (i, link) in skeleton.links().iter().enumerate() {
            let turn = match link.parent {
                Some(p) => k.world[p].rotation * link.parent_from_zero.rotation,
                None => link.parent_from_zero.rotation,
            };
            let (at, origin) = (skeleton.v_at(i), k.origin(i));
            let axes = [Vec3::x(), Vec3::y(), Vec3::z()].map(|e| turn * e);
            match link.joint {
                Joint::Free => {
                    for (j, &e) in axes.iter().enumerate() {
                        self.all[at + j] = Axis { linear: e, angular: none, origin };
                        self.all[at + 3 + j] = Axis { linear: none, angular: e, origin };
                    }
                }
                Joint::Spherical => {
                    for (j, &e) in axes.iter().enumerate() {
                        self.all[at + j] = Axis { linear: none, angular: e, origin };
                    }
                }
                Joint::Revolute(a) => self.all[at] = Axis { linear: none, angular: turn * a, origin },
                Joint::Prismatic(a) => self.all[at] = Axis { linear: turn * a, angular: none, origin },
                Joint::Fixed => {}
            }
        }
    }
}
