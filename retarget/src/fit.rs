//! Joint angles from predicted feature points.
//!
//! In: local positions of the feature points of one pose. Out: the pose whose own points are nearest to them,
//! in least squares, within the joint limits. The points that a mapping predicts are no rigid body: they
//! shrink between key poses, so all joints are fitted at once.
//!
//! *Start.* From the frame before; where that ends much worse than it was, and for the first frame, from the
//! points themselves: the three markers of each link give its orientation (Kabsch), its joint takes the part
//! it can.
//!
//! *Solution.* Levenberg–Marquardt ([`motion::ik::whole_body`]) on
//! `Σ |p_i(q) − z_i|² + s² Σ |way beyond limits|² + Σ (ρ_l/σ)² |q_l − q′_l|²`, then what little is left beyond the limits is
//! clamped. The last term holds the joint of a link l to the frame before, q′, where its
//! points say little: they are no better than ρ_l, their RMS distance in that frame's fit, and a joint seldom turns by
//! more than σ a frame. Points between key poses that differ much (a tail curled up and a tail straight) fall together in one
//! place, and without it the last links of a chain turn over from one frame to the next. The root has three degrees of
//! freedom here, height, roll and pitch: place and heading are zero in the local frame by definition.

use std::sync::Arc;

use motion::ik::{Goal, Method, Point, Problem, Unknowns, WholeBody};
use motion::{Joint, Kinematics, Quat, Skeleton, Vec3, rotation};
use nalgebra::{Matrix3, Rotation3};

use crate::features::Features;

/// Most steps for one frame, and the share of the cost that makes a step the last.
const METHOD: Method = Method::LevenbergMarquardt { most_steps: 40, enough: 1e-6 };
/// Weight of a radian beyond a limit against the points, in radii of the body.
const LIMIT: f64 = 10.0;
/// Turn of a joint from frame to frame, σ, rad.
const TURN: f64 = 0.5;

/// How a fit ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// RMS distance of the points, m.
    pub rms_m: f64,
    /// Steps taken.
    pub steps: usize,
}

/// The fit of one body, and its memory. See the module header.
#[derive(Clone, Debug)]
pub struct JointFit {
    skeleton: Arc<Skeleton>,
    features: Features,
    solver: WholeBody,
    /// s², m²/rad².
    limit_weight: f64,
    /// The feature points, in the order of the features.
    points: Vec<Point>,
    k: Kinematics,
    /// The frame before, and (ρ_l/σ)² of its fit for every degree of freedom.
    before: Vec<f64>,
    weights: Vec<f64>,
}

impl JointFit {
    /// A fit for a skeleton whose root is free, by these points (in metres).
    pub fn new(skeleton: &Arc<Skeleton>, features: &Features) -> Self {
        let zero = skeleton.zero_pose();
        let k = Kinematics::new(skeleton, &zero);
        let radius =
            features.points.iter().map(|p| (k.point(p.link, &p.at) - k.origin(0)).norm()).fold(0.0, f64::max);
        let limit = LIMIT * radius;
        let point = |p: &motion::Site| Point { link: p.link, at: p.at, goal: None, on_floor: false };
        Self {
            limit_weight: limit * limit,
            k,
            solver: WholeBody::new(skeleton, Unknowns::HeightRollPitch),
            points: features.points.iter().map(point).collect(),
            before: zero,
            weights: vec![0.0; skeleton.nv()],
            skeleton: skeleton.clone(),
            features: features.clone(),
        }
    }

    /// Moves `q` (`nq`) to the pose nearest to the points `z` (`3 × points`, local frame).
    ///
    /// The start is `q`; pass `fresh` where it is not near.
    pub fn solve(&mut self, z: &[f64], q: &mut [f64], fresh: bool) -> Fit {
        if fresh {
            self.pose_of_points(z, q);
            self.weights.fill(0.0);
        }
        let root = self.features.root;
        // place and heading are zero in the local frame
        let stand =
            |s: &Skeleton, q: &mut [f64]| place_root(s, q, |world| root.local(world, 0.0).inverse() * world);
        stand(&self.skeleton, q);
        self.before.copy_from_slice(q);
        for (point, z) in self.points.iter_mut().zip(z.chunks_exact(3)) {
            point.goal = Some(Goal { place: Vec3::new(z[0], z[1], z[2]), weight: 1.0, along: None });
        }
        let problem = Problem {
            points: &self.points,
            reference: &self.before,
            weights: &self.weights,
            limit_weight: self.limit_weight,
            floor: None,
        };
        let steps = self.solver.solve(&problem, METHOD, q, &stand);
        if self.skeleton.clamp_to_limits(q) {
            stand(&self.skeleton, q);
        }
        self.k.update(&self.skeleton, q);
        let points = self.features.points.len().max(1);
        let square: f64 = self.distances(z).map(|(_, r)| r.norm_squared()).sum();
        Fit { rms_m: (square / points as f64).sqrt(), steps }
    }

    /// Takes the pose `q` for the frame before: the next [`JointFit::solve`] is held to it as far as the points `z` of a link
    /// fit no rigid body.
    pub fn keep(&mut self, z: &[f64], q: &[f64]) {
        self.k.update(&self.skeleton, q);
        let mut of_link = vec![(0.0, 0.0_f64); self.skeleton.links().len()];
        for (link, r) in self.distances(z) {
            of_link[link].0 += r.norm_squared();
            of_link[link].1 += 1.0;
        }
        for (link, (square, points)) in of_link.into_iter().enumerate() {
            let at = self.skeleton.v_at(link);
            let dofs = self.skeleton.links()[link].joint.nv();
            self.weights[at..at + dofs].fill(square / points.max(1.0) / (TURN * TURN));
        }
    }

    /// Points of the current kinematics: their link, and how far they are from where they should be.
    fn distances<'a>(&'a self, z: &'a [f64]) -> impl Iterator<Item = (usize, Vec3)> + 'a {
        let goals = z.chunks_exact(3).map(|z| Vec3::new(z[0], z[1], z[2]));
        self.features.points.iter().zip(goals).map(|(p, z)| (p.link, self.k.point(p.link, &p.at) - z))
    }

    /// A pose from the points alone: each link's orientation by Kabsch, parents first.
    fn pose_of_points(&mut self, z: &[f64], q: &mut [f64]) {
        let links = self.skeleton.links().len();
        for link in 0..links {
            let own: Vec<(Vec3, Vec3)> = self
                .features
                .points
                .iter()
                .zip(z.chunks_exact(3))
                .filter(|(p, _)| p.link == link)
                .map(|(p, z)| (p.at, Vec3::new(z[0], z[1], z[2])))
                .collect();
            if own.len() < 3 {
                continue;
            }
            let (turn, origin) = kabsch(&own);
            self.k.update(&self.skeleton, q);
            let l = &self.skeleton.links()[link];
            match (l.joint, l.parent) {
                (Joint::Free, _) => {
                    place_root(&self.skeleton, q, |_| motion::Transform::from_parts(origin.into(), turn));
                }
                (Joint::Spherical, Some(p)) => {
                    let zero = self.k.world[p].rotation * l.parent_from_zero.rotation;
                    self.skeleton.set_rotation(q, link, &(zero.inverse() * turn));
                }
                (Joint::Revolute(axis), Some(p)) => {
                    let zero = self.k.world[p].rotation * l.parent_from_zero.rotation;
                    let (_, twist) = rotation::swing_twist(&(zero.inverse() * turn), &axis);
                    q[self.skeleton.q_at(link)] = rotation::log(&twist).dot(&axis);
                }
                (Joint::Prismatic(axis), Some(p)) => {
                    let zero = self.k.world[p] * l.parent_from_zero;
                    q[self.skeleton.q_at(link)] =
                        (zero.inverse() * nalgebra::Point3::from(origin)).coords.dot(&axis);
                }
                _ => {}
            }
        }
        self.skeleton.clamp_to_limits(q);
    }
}

/// Replaces the world transform of a free root.
pub(crate) fn place_root(
    skeleton: &Skeleton,
    q: &mut [f64],
    to: impl FnOnce(&motion::Transform) -> motion::Transform,
) {
    let zero = skeleton.links()[0].parent_from_zero;
    let joint = zero.inverse() * to(&(zero * skeleton.joint_transform(q, 0)));
    skeleton.set_position(q, 0, &joint.translation.vector);
    skeleton.set_rotation(q, 0, &joint.rotation);
}

/// Rotation and origin of the body frame that carry `(in body, in world)` pairs best onto each other.
fn kabsch(pairs: &[(Vec3, Vec3)]) -> (Quat, Vec3) {
    let n = pairs.len() as f64;
    let a: Vec3 = pairs.iter().map(|p| p.0).sum::<Vec3>() / n;
    let b: Vec3 = pairs.iter().map(|p| p.1).sum::<Vec3>() / n;
    let cross: Matrix3<f64> = pairs.iter().map(|p| (p.1 - b) * (p.0 - a).transpose()).sum();
    let svd = cross.svd(true, true);
    let (Some(u), Some(vt)) = (svd.u, svd.v_t) else { return (Quat::identity(), b - a) };
    // three markers span a plane: the least singular value is 0, and its sign decides for a rotation
    let sign = (u * vt).determinant().signum();
    let r = u * Matrix3::from_diagonal(&Vec3::new(1.0, 1.0, sign)) * vt;
    let turn = Quat::from_rotation_matrix(&Rotation3::from_matrix_unchecked(r));
    (turn, b - turn * a)
}
