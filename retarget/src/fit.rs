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
//! *Solution.* Levenberg–Marquardt on `Σ |p_i(q) − z_i|² + s² Σ |excess over limits|² + Σ (ρ_l/σ)² |q_l − q′_l|²`, then
//! what little excess is left is clamped. The last term holds the joint of a link l to the frame before, q′, where its
//! points say little: they are no better than ρ_l, their RMS distance in that frame's fit, and a joint seldom turns by
//! more than σ a frame. Points between key poses that differ much (a tail curled up and a tail straight) fall together in one
//! place, and without it the last links of a chain turn over from one frame to the next. The root has three degrees of freedom here, height, roll and pitch: place and heading are
//! zero in the local frame by definition.

use std::sync::Arc;

use motion::{Joint, Kinematics, Quat, Skeleton, Vec3, rotation};
use nalgebra::{Matrix3, Rotation3};

use crate::axes::{Axes, Axis};
use crate::cholesky;
use crate::features::Features;
use crate::limits::way_back;

/// Most steps for one frame.
const STEPS: usize = 40;
/// A step that lowers the cost by less than this share is the last.
const ENOUGH: f64 = 1e-6;
/// Weight of a radian beyond a limit against the points, in radii of the body.
const LIMIT: f64 = 10.0;

/// How a fit ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// RMS distance of the points, m.
    pub rms_m: f64,
    /// Steps taken.
    pub steps: usize,
}

/// Turn of a joint from frame to frame, σ, rad.
const TURN: f64 = 0.5;

/// The fit of one body, and its memory. See the module header.
#[derive(Clone, Debug)]
pub struct JointFit {
    skeleton: Arc<Skeleton>,
    features: Features,
    limit: f64,
    k: Kinematics,
    axes: Axes,
    /// Unknowns: root height, roll, pitch, then every other degree of freedom.
    unknowns: Vec<Axis>,
    /// For each link, the unknowns that move it.
    chain: Vec<Vec<usize>>,
    normal: Vec<f64>,
    factor: Vec<f64>,
    gradient: Vec<f64>,
    step: Vec<f64>,
    v: Vec<f64>,
    trial: Vec<f64>,
    /// The frame before, and (ρ_l/σ)² of its fit for every degree of freedom.
    before: Vec<f64>,
    hold: Vec<f64>,
    held: Vec<f64>,
}

/// First unknown that is not the root's.
const ROOT: usize = 3;

impl JointFit {
    /// A fit for a skeleton whose root is free, by these points (in metres).
    pub fn new(skeleton: &Arc<Skeleton>, features: &Features) -> Self {
        let axes = Axes::new(skeleton);
        let n = skeleton.nv() - 6 + ROOT;
        let chain: Vec<Vec<usize>> = axes
            .chain
            .iter()
            .map(|c| (0..ROOT).chain(c.iter().filter(|&&d| d >= 6).map(|d| d - 6 + ROOT)).collect())
            .collect();
        let zero = skeleton.zero_pose();
        let k = Kinematics::new(skeleton, &zero);
        let radius =
            features.points.iter().map(|p| (k.point(p.link, &p.at) - k.origin(0)).norm()).fold(0.0, f64::max);
        Self {
            limit: LIMIT * radius,
            k,
            axes,
            unknowns: vec![Axis::default(); n],
            chain,
            normal: vec![0.0; n * n],
            factor: vec![0.0; n * n],
            gradient: vec![0.0; n],
            step: vec![0.0; n],
            v: vec![0.0; skeleton.nv()],
            trial: zero.clone(),
            before: zero,
            hold: vec![0.0; skeleton.nv()],
            held: vec![0.0; skeleton.nv()],
            skeleton: skeleton.clone(),
            features: features.clone(),
        }
    }

    /// Moves `q` (`nq`) to the pose nearest to the points `z` (`3 × points`, local frame).
    ///
    /// The start is `q`; pass `fresh` where it is not near.
    pub fn solve(&mut self, z: &[f64], q: &mut [f64], fresh: bool) -> Fit {
        if fresh {
            self.start(z, q);
        }
        self.stand_in_local_frame(q);
        self.before.copy_from_slice(q);
        if fresh {
            self.hold.fill(0.0);
        }
        let mut cost = self.cost(z, q);
        let n = self.unknowns.len();
        let (mut damping, mut steps) = (1e-8, 0);
        'outer: while steps < STEPS {
            self.linearise(z, q);
            loop {
                self.factor.copy_from_slice(&self.normal);
                for i in 0..n {
                    self.factor[i * n + i] += damping * self.normal[i * n + i] + 1e-12;
                    self.step[i] = -self.gradient[i];
                }
                let solved = cholesky::solve(&mut self.factor, n, &mut self.step);
                let mut trial = std::mem::take(&mut self.trial);
                trial.copy_from_slice(q);
                if solved {
                    self.walk(&mut trial);
                }
                let lower = if solved { self.cost(z, &trial) } else { f64::INFINITY };
                self.trial = trial;
                if lower < cost {
                    q.copy_from_slice(&self.trial);
                    steps += 1;
                    let last = cost - lower < ENOUGH * cost;
                    (cost, damping) = (lower, (damping * 0.1).max(1e-12));
                    if last {
                        break 'outer;
                    }
                    break;
                }
                damping *= 10.0;
                if damping > 1e4 {
                    break 'outer;
                }
            }
        }
        if self.skeleton.clamp_to_limits(q) {
            self.stand_in_local_frame(q);
        }
        self.k.update(&self.skeleton, q);
        let points = self.features.points.len().max(1);
        let square: f64 = self.residuals(z).map(|(_, _, r)| r.norm_squared()).sum();
        Fit { rms_m: (square / points as f64).sqrt(), steps }
    }

    /// Takes the pose `q` for the frame before: the next [`JointFit::solve`] is held to it where `z` was no body's.
    pub fn keep(&mut self, z: &[f64], q: &[f64]) {
        self.k.update(&self.skeleton, q);
        let mut loose = vec![(0.0, 0.0_f64); self.skeleton.links().len()];
        for (link, _, r) in self.residuals(z) {
            loose[link].0 += r.norm_squared();
            loose[link].1 += 1.0;
        }
        for (link, (square, points)) in loose.into_iter().enumerate() {
            let at = self.skeleton.v_at(link);
            let dofs = self.skeleton.links()[link].joint.nv();
            self.hold[at..at + dofs].fill(square / points.max(1.0) / (TURN * TURN));
        }
    }

    /// Points of the current kinematics: link, position, distance from where they should be.
    fn residuals<'a>(&'a self, z: &'a [f64]) -> impl Iterator<Item = (usize, Vec3, Vec3)> + 'a {
        self.features.points.iter().zip(z.chunks_exact(3)).map(|(p, z)| {
            let at = self.k.point(p.link, &p.at);
            (p.link, at, at - Vec3::new(z[0], z[1], z[2]))
        })
    }

    fn cost(&mut self, z: &[f64], q: &[f64]) -> f64 {
        self.k.update(&self.skeleton, q);
        let points: f64 = self.residuals(z).map(|(_, _, r)| r.norm_squared()).sum();
        let links = 1..self.skeleton.links().len();
        let beyond: f64 =
            links.filter_map(|i| way_back(&self.skeleton, q, i)).map(|e| e.norm_squared()).sum();
        self.skeleton.difference(&self.before, q, 1.0, &mut self.held);
        let held: f64 = self.held.iter().zip(&self.hold).skip(6).map(|(x, h)| h * x * x).sum();
        points + self.limit * self.limit * beyond + held
    }

    /// Normal matrix and gradient at `q`; the kinematics are those of `q` afterwards.
    fn linearise(&mut self, z: &[f64], q: &[f64]) {
        self.k.update(&self.skeleton, q);
        self.axes.update(&self.skeleton, &self.k);
        let (none, origin) = (Vec3::zeros(), self.k.origin(0));
        self.unknowns[0] = Axis { linear: Vec3::y(), angular: none, origin };
        self.unknowns[1] = Axis { linear: none, angular: Vec3::x(), origin };
        self.unknowns[2] = Axis { linear: none, angular: Vec3::z(), origin };
        self.unknowns[ROOT..].copy_from_slice(&self.axes.all[6..]);
        let n = self.unknowns.len();
        let mut normal = std::mem::take(&mut self.normal);
        let mut gradient = std::mem::take(&mut self.gradient);
        normal.fill(0.0);
        gradient.fill(0.0);
        let mut columns = vec![Vec3::zeros(); n];
        for (link, p, r) in self.residuals(z) {
            let chain = &self.chain[link];
            for (a, &i) in chain.iter().enumerate() {
                let c = self.unknowns[i].column(&p);
                columns[a] = c;
                gradient[i] += c.dot(&r);
                for (b, &j) in chain[..=a].iter().enumerate() {
                    normal[i * n + j] += c.dot(&columns[b]);
                }
            }
        }
        let s2 = self.limit * self.limit;
        for link in 1..self.skeleton.links().len() {
            let Some(e) = way_back(&self.skeleton, q, link) else { continue };
            let at = self.skeleton.v_at(link) - 6 + ROOT;
            let (size, dofs) = (e.norm(), self.skeleton.links()[link].joint.nv());
            // only the way along the excess changes it: J = −ê êᵀ
            for a in 0..dofs {
                gradient[at + a] -= s2 * e[a];
                for b in 0..=a {
                    normal[(at + a) * n + at + b] += s2 * e[a] * e[b] / (size * size);
                }
            }
        }
        self.skeleton.difference(&self.before, q, 1.0, &mut self.held);
        for (i, (turned, hold)) in self.held.iter().zip(&self.hold).skip(6).enumerate() {
            gradient[ROOT + i] += hold * turned;
            normal[(ROOT + i) * n + ROOT + i] += hold;
        }
        (self.normal, self.gradient) = (normal, gradient);
    }

    /// `q` moved by the step.
    fn walk(&mut self, q: &mut [f64]) {
        let world_from_zero = self.skeleton.links()[0].parent_from_zero.rotation;
        let along = |v: Vec3| world_from_zero.inverse() * v;
        self.v[..3].copy_from_slice(along(Vec3::y() * self.step[0]).as_slice());
        self.v[3..6].copy_from_slice(along(Vec3::new(self.step[1], 0.0, self.step[2])).as_slice());
        self.v[6..].copy_from_slice(&self.step[ROOT..]);
        self.skeleton.integrate(q, &self.v, 1.0);
        self.stand_in_local_frame(q);
    }

    /// Takes out place and heading, which are zero in the local frame.
    fn stand_in_local_frame(&self, q: &mut [f64]) {
        place_root(&self.skeleton, q, |world| self.features.root.local(world, 0.0).inverse() * world);
    }

    /// A pose from the points alone: each link's orientation by Kabsch, parents first.
    fn start(&mut self, z: &[f64], q: &mut [f64]) {
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
