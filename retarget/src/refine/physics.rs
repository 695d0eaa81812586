//! Force mismatch of one frame, and its slopes.
//!
//! In: pose, velocity, acceleration, and where the points in contact are anchored. Out: the residual
//! `[F − F̂; (N − N̂)/ℓ]` of (12): what the motion needs from outside less what the penalty ground gives, both about
//! the root's origin, along the axes of its zero frame, and its derivatives by pose, velocity, acceleration.
//!
//! F, N: [`dynamics::rnea`], slopes by [`InverseDerivatives`]. F̂, N̂: [`Penalty`] at every contact point; a point in
//! a contact phase pulls back to its anchor, any other only brakes. With point p on a chain of axes j and
//! `c_j(p)` the velocity of p at unit rate of j, turning axis k moves
//!
//! ```text
//! δp = c_k(p)    δṗ = a_k × Σ_{j outboard} c_j(p) v_j + (Σ_{j not outboard} a_j v_j) × c_k(p)
//! ```
//!
//! *The ground made linear* ([`GroundSlope`]). On a point above the ground the force hardly depends on its
//! height, and where one just touches the slope is half of the ground's stiffness: a step by the tangent goes nowhere or twice
//! too deep. The chord goes through the force now
//! and the one wanted, a point's share of what the ground gives too little or too much, at the height where the law gives
//! that ([`Penalty::rest_height`]).
//!
//! *Displaced poses.* The refinement adds δ(t) in the tangent of the pose, so a rate is `v + δ̇ + δ × v` and an
//! acceleration `v̇ + δ̈ + 2… `: to first order, for three axes that turn together,
//! `ω' = ω + δ̇ + δ × ω`, `ω̇' = ω̇ + δ̈ + δ̇ × ω + δ × ω̇`. The slopes given are those by δ, δ̇ and δ̈.

use dynamics::penalty::Penalty;
use dynamics::{InverseDerivatives, Model, State};
use motion::skeleton::vec_at;
use motion::{Joint, Kinematics, Vec3};
use nalgebra::{DMatrix, Vector6};

use crate::Puppet;
use motion::ik::JointAxes;

/// Forces of one frame, world axes for those of the ground.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forces {
    /// `[F − F̂; N − N̂]`, N and N·m, zero frame of the root.
    pub residual: Vector6<f64>,
    /// Force the motion needs from outside, gravity included, world, N.
    pub required: Vec3,
    /// Force the ground gives, world, N.
    pub given: Vec3,
}

/// A contact point as the refinement sees it.
#[derive(Clone, Copy, Debug)]
struct Point {
    link: usize,
    at: Vec3,
}

/// Slopes by δ, δ̇ and δ̈, `9 × nv` each: of the residual, then of the required force along the axes of the root's zero
/// frame.
#[derive(Clone, Debug)]
pub struct Slopes {
    /// By δ, δ̇, δ̈.
    pub by: [DMatrix<f64>; 3],
}

/// How the law of the ground is made linear. See the module header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GroundSlope {
    /// By its slope.
    Tangent,
    /// By the chord to the force that is wanted.
    Chord,
}

/// Points below this height take part in carrying a body of which none is in a phase, m.
const NEAR_M: f64 = 0.03;

/// Evaluates forces, with their memory. See the module header.
pub struct Physics {
    model: Model,
    state: State,
    derivatives: InverseDerivatives,
    penalty: Penalty,
    points: Vec<Point>,
    k: Kinematics,
    axes: JointAxes,
    /// First and one past the last degree of freedom of the rotation each turning one belongs to.
    group: Vec<(usize, usize)>,
    tau: Vec<f64>,
    stiffness: Vec<f64>,
}

/// Where the points are anchored in one frame: `[x, z]`, or nothing outside a phase.
pub type Anchors<'a> = &'a [Option<[f64; 2]>];

impl Physics {
    /// For a puppet under gravity, standing on this ground.
    pub fn new(puppet: &Puppet, penalty: Penalty, gravity: Vec3) -> Self {
        let c = &puppet.character;
        let model = Model::new(c, gravity);
        let sites = c.skeleton.sites();
        let mut group = vec![(0, 0); c.skeleton.nv()];
        for (i, link) in c.skeleton.links().iter().enumerate() {
            let v = c.skeleton.v_at(i);
            let (from, to) = match link.joint {
                Joint::Free => (v + 3, v + 6),
                _ => (v, v + link.joint.nv()),
            };
            group[v..v + link.joint.nv()].fill((v, v + link.joint.nv()));
            group[from..to].fill((from, to));
            if link.joint == Joint::Free {
                group[v..v + 3].fill((v, v + 3));
            }
        }
        Self {
            state: State::new(&model),
            derivatives: InverseDerivatives::new(&model),
            penalty,
            points: puppet
                .contacts
                .iter()
                .map(|p| Point { link: sites[p.site].link, at: sites[p.site].at })
                .collect(),
            k: Kinematics::new(&c.skeleton, &c.rest),
            axes: JointAxes::new(&c.skeleton),
            group,
            tau: vec![0.0; c.skeleton.nv()],
            stiffness: vec![0.0; puppet.contacts.len()],
            model,
        }
    }

    /// Forces at a pose, velocity and acceleration.
    pub fn forces(&mut self, q: &[f64], v: &[f64], vd: &[f64], anchors: Anchors) -> Forces {
        let skeleton = self.model.skeleton.clone();
        self.state.update(&self.model, q, v);
        self.state.inverse_dynamics(&self.model, v, vd, &[], &mut self.tau);
        self.k.update(&skeleton, q);
        self.axes.update(&skeleton, &self.k);
        let zero = skeleton.links()[0].parent_from_zero.rotation;
        let mut out = Forces {
            residual: Vector6::from_column_slice(&self.tau[..6]),
            required: zero * vec_at(&self.tau, 0),
            given: Vec3::zeros(),
        };
        let origin = self.k.origin(0);
        for (point, anchor) in self.points.iter().zip(anchors) {
            let p = self.k.point(point.link, &point.at);
            let rate = self.rate(point.link, &p, v);
            let slip = anchor.map_or([0.0; 2], |a| [p.x - a[0], p.z - a[1]]);
            let f = self.penalty.force(p.y, rate.y, slip, [rate.x, rate.z]);
            out.given += f;
            let (force, moment) = (zero.inverse() * f, zero.inverse() * (p - origin).cross(&f));
            for i in 0..3 {
                out.residual[i] -= force[i];
                out.residual[3 + i] -= moment[i];
            }
        }
        out
    }

    /// Velocity of a point of a link, world, m/s.
    fn rate(&self, link: usize, p: &Vec3, v: &[f64]) -> Vec3 {
        self.axes.chain[link].iter().map(|&j| self.axes.all[j].column(p) * v[j]).sum()
    }

    /// Stiffness of the ground under each point as [`Physics::slopes`] took it last, N/m.
    pub fn stiffness(&self) -> &[f64] {
        &self.stiffness
    }

    /// Slope of a point's normal force by its height, by the chord to a force that is `more` (N) larger; never steeper than
    /// the ground is (of a force that damping has a part in, the height says little).
    fn chord(&self, z: f64, normal: f64, more: f64) -> Option<f64> {
        let wanted = (normal + more).max(0.5 * self.penalty.f_0);
        let (rise, way) = (wanted - normal, self.penalty.rest_height(wanted) - z);
        (rise.abs() > 0.01 * self.penalty.f_0 && way * rise < 0.0)
            .then(|| (rise / way).max(-self.penalty.k_p))
    }

    /// Slopes at the frame given last to [`Physics::forces`] (same arguments, which gave `forces`).
    pub fn slopes(
        &mut self,
        v: &[f64],
        vd: &[f64],
        anchors: Anchors,
        (forces, ground): (&Forces, GroundSlope),
        out: &mut Slopes,
    ) {
        let nv = v.len();
        self.derivatives.update(&self.model, &self.state, v, vd, &[]);
        let d = &self.derivatives;
        for (to, from) in out.by.iter_mut().zip([&d.q, &d.v, &d.vd]) {
            to.rows_mut(0, 6).copy_from(&from.rows(0, 6));
            to.rows_mut(6, 3).copy_from(&from.rows(0, 3));
        }
        let zero = self.model.skeleton.links()[0].parent_from_zero.rotation.inverse();
        let origin = self.k.origin(0);
        let at = |p: &Point| self.k.point(p.link, &p.at);
        let stands = anchors.iter().any(Option::is_some);
        let carries = |i: usize| if stands { anchors[i].is_some() } else { at(&self.points[i]).y < NEAR_M };
        let carriers: Vec<bool> = (0..self.points.len()).map(carries).collect();
        let more = (forces.required.y - forces.given.y) / carriers.iter().filter(|c| **c).count() as f64;
        for (i, (point, anchor)) in self.points.iter().zip(anchors).enumerate() {
            let chain = &self.axes.chain[point.link];
            let p = at(point);
            let rate = self.rate(point.link, &p, v);
            let slip = anchor.map_or([0.0; 2], |a| [p.x - a[0], p.z - a[1]]);
            let mut f = self.penalty.force_gradient(p.y, rate.y, slip, [rate.x, rate.z]);
            if ground == GroundSlope::Chord && carriers[i] && f.d_z.y < 0.0 {
                // friction follows the normal force
                if let Some(slope) = self.chord(p.y, f.force.y, more) {
                    f.d_z *= slope / f.d_z.y;
                }
            }
            self.stiffness[i] = -f.d_z.y;
            if f.force == Vec3::zeros() && f.d_z == Vec3::zeros() {
                continue;
            }
            // sums over the axes of the chain up to and including the group of k
            let (mut turning, mut inner, mut at) = (Vec3::zeros(), Vec3::zeros(), 0);
            for (n, &k) in chain.iter().enumerate() {
                while at < chain.len() && (at <= n || chain[at] < self.group[k].1) {
                    let axis = &self.axes.all[chain[at]];
                    turning += axis.angular * v[chain[at]];
                    inner += axis.column(&p) * v[chain[at]];
                    at += 1;
                }
                let axis = &self.axes.all[k];
                let column = axis.column(&p);
                let swing = axis.angular.cross(&(rate - inner)) + turning.cross(&column);
                // a point without an anchor has no slip that could change
                let drag = if anchor.is_some() { column } else { Vec3::zeros() };
                let of = |dp: &Vec3, slip: &Vec3, dv: &Vec3| {
                    f.d_z * dp.y
                        + f.d_zd * dv.y
                        + f.d_slip * nalgebra::Vector2::new(slip.x, slip.z)
                        + f.d_rate * nalgebra::Vector2::new(dv.x, dv.z)
                };
                let none = Vec3::zeros();
                let by_pose = of(&column, &drag, &swing);
                let by_rate = of(&none, &none, &column);
                // moments are about the root's origin, which moves along with the root's own slides
                let moved = if k < 3 { none } else { column };
                let moment = moved.cross(&f.force) + (p - origin).cross(&by_pose);
                put(&mut out.by[0], k, &(zero * by_pose), &(zero * moment));
                let moment = (p - origin).cross(&by_rate);
                put(&mut out.by[1], k, &(zero * by_rate), &(zero * moment));
            }
        }
        self.displace(v, vd, nv, out);
    }

    /// From slopes by `q, v, v̇` to slopes by `δ, δ̇, δ̈`, see the module header.
    fn displace(&self, v: &[f64], vd: &[f64], nv: usize, out: &mut Slopes) {
        for from in (0..nv).filter(|&k| self.group[k] == (k, k + 3)) {
            if self.axes.all[from].angular == Vec3::zeros() {
                continue;
            }
            let (w, wd) = (vec_at(v, from), vec_at(vd, from));
            for row in 0..9 {
                let of = |m: &DMatrix<f64>| Vec3::from_fn(|i, _| m[(row, from + i)]);
                let (by_v, by_a) = (of(&out.by[1]), of(&out.by[2]));
                // s·(e × w) = e·(w × s)
                let (pose, rate) = (w.cross(&by_v) + wd.cross(&by_a), w.cross(&by_a));
                for i in 0..3 {
                    out.by[0][(row, from + i)] += pose[i];
                    out.by[1][(row, from + i)] += rate[i];
                }
            }
        }
    }
}

impl Slopes {
    /// Zero, for `nv` degrees of freedom.
    pub fn new(nv: usize) -> Self {
        Self { by: std::array::from_fn(|_| DMatrix::zeros(9, nv)) }
    }
}

/// Takes a change of the ground's force and moment from a column of the residual.
fn put(m: &mut DMatrix<f64>, column: usize, force: &Vec3, moment: &Vec3) {
    for i in 0..3 {
        m[(i, column)] -= force[i];
        m[(3 + i, column)] -= moment[i];
    }
}
