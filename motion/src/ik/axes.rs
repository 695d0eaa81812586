//! Joint axes of a posed skeleton in the world: the columns of the Jacobian of every point.
//!
//! In: a skeleton and its kinematics. Out: for each degree of freedom the direction it slides along or turns about, and
//! a point of that axis; for each link the degrees of freedom that move it. Degrees of freedom count as velocities do in
//! [`skeleton`](crate::skeleton): `∂p/∂δ_k = linear_k + angular_k × (p − origin_k)` for `q ⊕ δ`
//! ([`Skeleton::integrate`]). World axes; m and rad.
//!
//! These are the axes of a *skeleton*. The crate `dynamics` has those of its moving bodies, into which welded links are
//! merged, as rotation matrices that its recursions have at hand.

use crate::{Joint, Kinematics, Skeleton, Vec3};

/// The axis of one degree of freedom, world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Axis {
    /// Velocity of the origin at unit rate: the direction of a slide, 1; zero for turns.
    pub linear: Vec3,
    /// Angular velocity at unit rate: the axis of a turn, 1; zero for slides.
    pub angular: Vec3,
    /// A point of the axis: the joint's, m.
    pub origin: Vec3,
}

impl Axis {
    /// Velocity of the point `p` (world, m) at unit rate: m/s per rad/s, or per m/s.
    #[inline]
    pub fn column(&self, p: &Vec3) -> Vec3 {
        self.linear + self.angular.cross(&(p - self.origin))
    }
}

/// All axes of one pose. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct JointAxes {
    /// One per degree of freedom (`nv`).
    pub all: Vec<Axis>,
    /// For each link, the degrees of freedom that move it, in ascending order.
    pub chain: Vec<Vec<usize>>,
}

impl JointAxes {
    /// Memory for the axes of a skeleton; they are zero until [`JointAxes::update`].
    pub fn new(skeleton: &Skeleton) -> Self {
        let mut chain: Vec<Vec<usize>> = Vec::new();
        for (i, link) in skeleton.links().iter().enumerate() {
            let mut own = link.parent.map_or(Vec::new(), |p| chain[p].clone());
            own.extend(skeleton.v_at(i)..skeleton.v_at(i) + link.joint.nv());
            chain.push(own);
        }
        Self { all: vec![Axis::default(); skeleton.nv()], chain }
    }

    /// Takes the axes of the pose that `k` is of; does not allocate.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Link;
    use crate::rotation::exp;

    /// One joint of each kind on a chain, zero frames turned.
    fn skeleton() -> Skeleton {
        let slant = Vec3::new(0.6, -0.2, 0.3).normalize();
        let joints =
            [Joint::Free, Joint::Spherical, Joint::Fixed, Joint::Revolute(slant), Joint::Prismatic(slant)];
        let links = joints.iter().enumerate().map(|(i, joint)| {
            let at = Vec3::new(0.1, -0.3, 0.2) * (i as f64 + 1.0);
            let mut link = Link::new(format!("{i}"), i.checked_sub(1), at, *joint);
            link.parent_from_zero.rotation = exp(&Vec3::new(0.3, 0.2 * i as f64, -0.4));
            link
        });
        Skeleton::new(links.collect()).unwrap()
    }

    /// Columns are the slopes of a point by each degree of freedom; a wrong origin is noticed.
    #[test]
    fn columns_are_slopes_of_points() {
        let (s, h, at) = (skeleton(), 1e-6, Vec3::new(0.2, 0.5, -0.1));
        let mut q = s.zero_pose();
        let v: Vec<f64> = (0..s.nv()).map(|i| (1.3 * i as f64).sin()).collect();
        s.integrate(&mut q, &v, 0.7);
        let k = Kinematics::new(&s, &q);
        let mut axes = JointAxes::new(&s);
        axes.update(&s, &k);
        let last = s.links().len() - 1;
        assert_eq!(axes.chain[last], (0..s.nv()).collect::<Vec<_>>());
        for link in 0..=last {
            for dof in 0..s.nv() {
                let moved = |step: f64| {
                    let (mut to, mut v) = (q.clone(), vec![0.0; s.nv()]);
                    v[dof] = step;
                    s.integrate(&mut to, &v, 1.0);
                    Kinematics::new(&s, &to).point(link, &at)
                };
                let slope = (moved(h) - moved(-h)) / (2.0 * h);
                let axis = axes.all[dof];
                let moves = axes.chain[link].contains(&dof);
                let column = if moves { axis.column(&k.point(link, &at)) } else { Vec3::zeros() };
                assert!((column - slope).norm() < 1e-8, "{link} {dof}: {column} {slope}"); // 1.7e-9 seen
                if moves && axis.angular != Vec3::zeros() {
                    let off = Axis { origin: axis.origin + Vec3::new(0.01, 0.02, -0.03), ..axis };
                    assert!((off.column(&k.point(link, &at)) - slope).norm() > 1e-3);
                }
            }
        }
    }
}
