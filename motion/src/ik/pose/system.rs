//! The linear systems of [`pose`](super): Newton's matrix of points hung on a tree, assembled, factored and solved.
//!
//! In: point masses and forces of links, joint axes, constraint rows. Out: the step, and the multipliers of the constraints.
//!
//! Points `x` of weight m with force f (the gradient of their cost) are summed up from the leaves to the root, as the composite
//! bodies of Featherstone's algorithm are, so that any number of points costs one pass:
//!
//! ```text
//! M = Σ m     C = Σ m x     I = Σ m x xᵀ     F = Σ f     G = Σ f xᵀ        over all links that a joint carries
//! ```
//!
//! A degree of freedom moves them at `s(x) = v + ω × x`. With `p = M v + ω × C`, `L = C × v + (tr I − I) ω` and
//! `T = v × F + Gᵀ ω − tr(G) ω` the second derivatives are, for `a` that carries `b`,
//!
//! ```text
//! K_ab = v_a·p_b + ω_a·L_b      (Gauss–Newton: the mass matrix of the points)
//!      + ω_a·T_b                 (the forces turn with the points; symmetric part within one ball)
//! ```
//!
//! *Storage.* Degrees of freedom couple only where one carries the other. A row holds the degrees of freedom that carry its own,
//! itself last; those of a carrier are a prefix of it, so the factorisation `K = Lᵀ L` from the last row to the first fills
//! nothing in and works on rows that lie side by side (Featherstone, Rigid Body Dynamics Algorithms, 2008, §6.5).
//!
//! Units: m, rad; lengths are taken from a base near the body, so that a body far from the origin loses no digits.

use nalgebra::Matrix3;

use crate::ik::axes::{Axis, JointAxes};
use crate::{Skeleton, Vec3};

/// Compliance of hard constraints, m² per unit of cost: at forces of about 1 (a drag that misses by a metre) a constraint
/// gives way by 1e-8 m, and constraints that contradict each other have an answer.
pub const COMPLIANCE: f64 = 1e-8;

/// Sums over points. See the module header.
#[derive(Clone, Copy, Debug)]
struct Composite {
    mass: f64,
    first: Vec3,
    second: Matrix3<f64>,
    force: Vec3,
    moment: Matrix3<f64>,
}

impl Composite {
    const NONE: Self = Self {
        mass: 0.0,
        first: Vec3::new(0.0, 0.0, 0.0),
        second: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        force: Vec3::new(0.0, 0.0, 0.0),
        moment: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    };

    fn add(&mut self, other: &Self) {
        self.mass += other.mass;
        self.first += other.first;
        self.second += other.second;
        self.force += other.force;
        self.moment += other.moment;
    }
}

/// How one degree of freedom moves and what resists.
#[derive(Clone, Copy, Debug, Default)]
struct Motion {
    v: Vec3,
    w: Vec3,
    /// p and L of its Gauss–Newton part, T of the forces.
    linear: Vec3,
    angular: Vec3,
    turning: Vec3,
}

/// The system and its memory. See the module header.
#[derive(Clone, Debug)]
pub struct System {
    /// Link of each degree of freedom.
    link: Vec<usize>,
    /// Degrees of freedom that carry each, itself last, one list after the other; where each begins.
    carriers: Vec<usize>,
    begins: Vec<usize>,
    /// Parent of each link.
    parent: Vec<Option<usize>>,
    composites: Vec<Composite>,
    moves: Vec<Motion>,
    base: Vec3,
    /// Rows of K, then of its factor, as `carriers` lists them.
    rows: Vec<f64>,
    /// Gradient of the cost (`nv`).
    pub gradient: Vec<f64>,
    /// Added to the diagonal (`nv`) and within balls: limits.
    pub stiff: Vec<f64>,
    /// Whether a degree of freedom is held as it is.
    pub locked: Vec<bool>,
    /// Constraint rows J, `constraints × nv`, and L⁻ᵀ Jᵀ of the last factor.
    pub jacobian: Vec<f64>,
    half: Vec<f64>,
    /// How much each constraint is missed, m or rad.
    pub missed: Vec<f64>,
    /// Multipliers λ of the constraints.
    pub multipliers: Vec<f64>,
    /// Compliance δ of each: a constraint is met when it is missed by δ λ.
    pub compliance: Vec<f64>,
    /// The factor of the constraints' own matrix, and a right-hand side.
    schur: Vec<f64>,
    right: Vec<f64>,
    /// The step (`nv`).
    pub step: Vec<f64>,
}

impl System {
    /// Memory for a skeleton.
    pub fn new(skeleton: &Skeleton, axes: &JointAxes) -> Self {
        let n = skeleton.nv();
        let (mut link, mut carriers, mut begins) = (Vec::new(), Vec::new(), vec![0]);
        for (i, l) in skeleton.links().iter().enumerate() {
            for d in skeleton.v_at(i)..skeleton.v_at(i) + l.joint.nv() {
                link.push(i);
                carriers.extend(axes.chain[i].iter().take_while(|&&c| c <= d));
                begins.push(carriers.len());
            }
        }
        Self {
            rows: vec![0.0; carriers.len()],
            parent: skeleton.links().iter().map(|l| l.parent).collect(),
            composites: vec![Composite::NONE; skeleton.links().len()],
            moves: vec![Motion::default(); n],
            base: Vec3::zeros(),
            gradient: vec![0.0; n],
            stiff: vec![0.0; carriers.len()],
            locked: vec![false; n],
            jacobian: Vec::new(),
            half: Vec::new(),
            missed: Vec::new(),
            multipliers: Vec::new(),
            compliance: Vec::new(),
            schur: Vec::new(),
            right: Vec::new(),
            step: vec![0.0; n],
            link,
            carriers,
            begins,
        }
    }

    /// Memory for this many constraints; multipliers are kept.
    pub fn constrain(&mut self, count: usize) {
        let n = self.gradient.len();
        self.jacobian.resize(count * n, 0.0);
        self.half.resize(count * n, 0.0);
        self.missed.resize(count, 0.0);
        self.compliance.resize(count, COMPLIANCE);
        self.schur.resize(count * count, 0.0);
        self.right.resize(count, 0.0);
        self.multipliers.resize(count, 0.0);
    }

    /// Forgets all points; lengths are from `base` on (world, m).
    pub fn clear(&mut self, base: Vec3) {
        self.composites.fill(Composite::NONE);
        self.stiff.fill(0.0);
        self.base = base;
    }

    /// Adds a point of a link: its place (world, m), its weight and the gradient of its cost.
    #[inline]
    pub fn add(&mut self, link: usize, place: &Vec3, weight: f64, force: &Vec3) {
        let (c, x) = (&mut self.composites[link], place - self.base);
        c.mass += weight;
        c.first += x * weight;
        c.second += x * x.transpose() * weight;
        c.force += force;
        c.moment += force * x.transpose();
    }

    /// Adds to the second derivative by the degrees of freedom `a ≤ b` of one joint.
    pub fn stiffen(&mut self, a: usize, b: usize, by: f64) {
        let end = self.begins[b + 1] - 1;
        self.stiff[end - (b - a)] += by;
    }

    /// Makes a row of the constraints zero.
    pub fn clear_row(&mut self, row: usize) {
        let n = self.gradient.len();
        self.jacobian[row * n..(row + 1) * n].fill(0.0);
    }

    /// Adds to three rows of the constraints, from `row` on, what a degree of freedom does to them.
    pub fn column(&mut self, row: usize, dof: usize, by: &Vec3, sign: f64) {
        let n = self.gradient.len();
        if !self.locked[dof] {
            (0..3).for_each(|r| self.jacobian[(row + r) * n + dof] += sign * by[r]);
        }
    }

    /// Adds to the gradient what the multipliers of these rows pull.
    pub fn pull(&mut self, row: usize, count: usize) {
        let n = self.gradient.len();
        for r in row..row + count {
            let x = self.multipliers[r];
            let along = &self.jacobian[r * n..(r + 1) * n];
            self.gradient.iter_mut().zip(along).for_each(|(g, j)| *g += x * j);
        }
    }

    /// The largest miss of the constraints beyond what their compliance allows, m or rad.
    ///
    /// * `softest`: constraints of a compliance above this do not count
    pub fn unmet(&self, softest: f64) -> f64 {
        let all = self.missed.iter().zip(&self.compliance).zip(&self.multipliers);
        let counted = all.filter(|((_, d), _)| **d <= softest);
        counted.fold(0.0, |m, ((c, d), x)| m.max((c - d * x).abs()))
    }

    /// Sums up the points and takes the gradient; the matrix is then made by [`System::factor`].
    pub fn gather(&mut self, axes: &[Axis]) {
        for i in (1..self.composites.len()).rev() {
            let own = self.composites[i];
            if let Some(p) = self.parent[i] {
                self.composites[p].add(&own);
            }
        }
        for (d, axis) in axes.iter().enumerate() {
            let c = &self.composites[self.link[d]];
            let w = axis.angular;
            let v = axis.linear - w.cross(&(axis.origin - self.base));
            let g = &c.moment;
            let torque = Vec3::new(g[(2, 1)] - g[(1, 2)], g[(0, 2)] - g[(2, 0)], g[(1, 0)] - g[(0, 1)]);
            self.gradient[d] = if self.locked[d] { 0.0 } else { v.dot(&c.force) + w.dot(&torque) };
            self.moves[d] = Motion {
                v,
                w,
                linear: v * c.mass + w.cross(&c.first),
                angular: c.first.cross(&v) + w * c.second.trace() - c.second * w,
                turning: v.cross(&c.force) + g.transpose() * w - w * g.trace(),
            };
        }
    }

    /// Makes and factors K; returns whether it was positive definite.
    ///
    /// * `forces`: whether the forces count, or Gauss–Newton's part alone
    /// * `damping`: added to the diagonal
    pub fn factor(&mut self, forces: bool, damping: f64) -> bool {
        self.fill(forces, damping);
        self.decompose()
    }

    /// Makes K.
    fn fill(&mut self, forces: bool, damping: f64) {
        for b in 0..self.gradient.len() {
            let (from, to) = (self.begins[b], self.begins[b + 1]);
            let mb = self.moves[b];
            let carried = if forces { mb.angular + mb.turning } else { mb.angular };
            for k in from..to {
                let a = self.carriers[k];
                let ma = &self.moves[a];
                self.rows[k] = if self.locked[a] || self.locked[b] {
                    f64::from(u8::from(a == b))
                } else if self.link[a] != self.link[b] {
                    ma.v.dot(&mb.linear) + ma.w.dot(&carried)
                } else {
                    // within one joint: the position of a free link does not turn with it, and a ball is symmetric
                    let gn = ma.v.dot(&mb.linear) + ma.w.dot(&mb.angular);
                    let turn = 0.5 * (ma.w.dot(&mb.turning) + mb.w.dot(&ma.turning));
                    let both = ma.w != Vec3::zeros() && mb.w != Vec3::zeros();
                    gn + self.stiff[k]
                        + if forces && both { turn } else { 0.0 }
                        + if a == b { damping } else { 0.0 }
                };
            }
        }
    }

    /// K = Lᵀ L, in place.
    fn decompose(&mut self) -> bool {
        for d in (0..self.gradient.len()).rev() {
            let (head, tail) = self.rows.split_at_mut(self.begins[d]);
            let len = self.begins[d + 1] - self.begins[d];
            let row = &mut tail[..len];
            let pivot = row[len - 1];
            if !(pivot > 0.0 && pivot.is_finite()) {
                return false;
            }
            let pivot = pivot.sqrt();
            row[len - 1] = pivot;
            let inverse = 1.0 / pivot;
            row[..len - 1].iter_mut().for_each(|x| *x *= inverse);
            for k in 0..len - 1 {
                let x = row[k];
                if x != 0.0 {
                    let at = self.begins[self.carriers[self.begins[d] + k]];
                    head[at..=at + k].iter_mut().zip(&row[..=k]).for_each(|(r, y)| *r -= x * y);
                }
            }
        }
        true
    }

    /// Factors the matrix of the constraints, S = J K⁻¹ Jᵀ + δ.
    pub fn factor_constraints(&mut self) -> bool {
        let (n, m) = (self.gradient.len(), self.missed.len());
        self.half.copy_from_slice(&self.jacobian);
        for r in 0..m {
            up(&self.rows, &self.carriers, &self.begins, &mut self.half[r * n..(r + 1) * n]);
        }
        for i in 0..m {
            for j in 0..=i {
                let (a, b) = (&self.half[i * n..(i + 1) * n], &self.half[j * n..(j + 1) * n]);
                self.schur[i * m + j] =
                    crate::linear::dot(a, b) + if i == j { self.compliance[i] } else { 0.0 };
            }
        }
        // S = C Cᵀ, row by row
        for i in 0..m {
            for j in 0..=i {
                let (a, b) = (&self.schur[i * m..i * m + j], &self.schur[j * m..j * m + j]);
                let rest = self.schur[i * m + j] - crate::linear::dot(a, b);
                if i == j {
                    if !(rest > 0.0 && rest.is_finite()) {
                        return false;
                    }
                    self.schur[i * m + i] = rest.sqrt();
                } else {
                    self.schur[i * m + j] = rest / self.schur[j * m + j];
                }
            }
        }
        true
    }

    /// Newton's step of the whole problem into `step`; adds to the multipliers.
    ///
    /// `K d + Jᵀ Δλ = −gradient`, `J d = −missed + δ (λ + Δλ)`.
    pub fn newton(&mut self) {
        for (s, g) in self.step.iter_mut().zip(&self.gradient) {
            *s = -g;
        }
        up(&self.rows, &self.carriers, &self.begins, &mut self.step);
        self.meet(true);
        down(&self.rows, &self.carriers, &self.begins, &mut self.step);
    }

    /// The least step, in the metric K, that meets the constraints as now `missed`, into `step`; multipliers stay.
    pub fn restore(&mut self) {
        self.step.fill(0.0);
        self.meet(false);
        down(&self.rows, &self.carriers, &self.begins, &mut self.step);
    }

    /// Takes what the constraints ask for off the half-solved step.
    fn meet(&mut self, learn: bool) {
        let (n, m) = (self.gradient.len(), self.missed.len());
        for i in 0..m {
            let along = crate::linear::dot(&self.half[i * n..(i + 1) * n], &self.step);
            self.right[i] = self.missed[i] - self.compliance[i] * self.multipliers[i] + along;
        }
        for i in 0..m {
            let known = crate::linear::dot(&self.schur[i * m..i * m + i], &self.right[..i]);
            self.right[i] = (self.right[i] - known) / self.schur[i * m + i];
        }
        for i in (0..m).rev() {
            let known: f64 = (i + 1..m).map(|j| self.schur[j * m + i] * self.right[j]).sum();
            self.right[i] = (self.right[i] - known) / self.schur[i * m + i];
        }
        for i in 0..m {
            let x = self.right[i];
            let half = &self.half[i * n..(i + 1) * n];
            self.step.iter_mut().zip(half).for_each(|(s, y)| *s -= x * y);
            if learn {
                self.multipliers[i] += x;
            }
        }
    }
}

/// `x ← L⁻ᵀ x`: from the last row to the first.
fn up(rows: &[f64], carriers: &[usize], begins: &[usize], x: &mut [f64]) {
    for d in (0..x.len()).rev() {
        if x[d] == 0.0 {
            continue;
        }
        let (from, last) = (begins[d], begins[d + 1] - 1);
        let own = x[d] / rows[last];
        x[d] = own;
        for k in from..last {
            x[carriers[k]] -= rows[k] * own;
        }
    }
}

/// `x ← L⁻¹ x`: from the first row to the last.
fn down(rows: &[f64], carriers: &[usize], begins: &[usize], x: &mut [f64]) {
    for d in 0..x.len() {
        let (from, last) = (begins[d], begins[d + 1] - 1);
        let known: f64 = (from..last).map(|k| rows[k] * x[carriers[k]]).sum();
        x[d] = (x[d] - known) / rows[last];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::exp;
    use crate::{Joint, Kinematics, Link};

    /// A free root with two branches, a joint of each kind, zero frames turned.
    fn skeleton() -> Skeleton {
        let slant = Vec3::new(0.6, -0.2, 0.3).normalize();
        let (ball, hinge, slide) = (Joint::Spherical, Joint::Revolute(slant), Joint::Prismatic(slant));
        let joints = [
            (Joint::Free, None),
            (ball, Some(0)),
            (hinge, Some(1)),
            (ball, Some(2)),
            (slide, Some(0)),
            (ball, Some(4)),
        ];
        let links = joints.iter().enumerate().map(|(i, (joint, parent))| {
            let x = i as f64;
            let mut link = Link::new(format!("{i}"), *parent, Vec3::new(0.1, -0.3 + 0.1 * x, 0.2), *joint);
            link.parent_from_zero.rotation = exp(&Vec3::new(0.3, 0.2 * x, -0.4));
            link
        });
        Skeleton::new(links.collect()).unwrap()
    }

    /// Gradient and matrix are the slopes of the cost; without the forces the matrix is another one.
    #[test]
    fn derivatives_are_those_of_the_cost() {
        let s = skeleton();
        let mut q = s.zero_pose();
        s.set_position(&mut q, 0, &Vec3::new(3.0, 1.0, -2.0));
        let v: Vec<f64> = (0..s.nv()).map(|i| (1.3 * i as f64).sin()).collect();
        s.integrate(&mut q, &v, 0.7);
        let points: Vec<(usize, Vec3, Vec3, f64)> = (0..s.links().len())
            .map(|i| {
                (i, Vec3::new(0.1, 0.2, -0.1), Vec3::new(3.0 + 0.3 * i as f64, 0.4, -1.5), 1.0 + i as f64)
            })
            .collect();
        let cost = |q: &[f64]| -> f64 {
            let k = Kinematics::new(&s, q);
            points.iter().map(|(l, at, to, w)| 0.5 * w * (k.point(*l, at) - to).norm_squared()).sum()
        };
        let moved = |steps: &[(usize, f64)]| {
            let (mut to, mut v) = (q.clone(), vec![0.0; s.nv()]);
            steps.iter().for_each(|(d, by)| v[*d] += by);
            s.integrate(&mut to, &v, 1.0);
            cost(&to)
        };
        let mut axes = JointAxes::new(&s);
        let k = Kinematics::new(&s, &q);
        axes.update(&s, &k);
        let mut system = System::new(&s, &axes);
        system.clear(k.origin(0));
        for (l, at, to, w) in &points {
            let x = k.point(*l, at);
            system.add(*l, &x, *w, &((x - to) * *w));
        }
        system.gather(&axes.all);
        let (h, mut apart) = (1e-4, 0.0f64);
        for b in 0..s.nv() {
            let slope = (moved(&[(b, h)]) - moved(&[(b, -h)])) / (2.0 * h);
            assert!((slope - system.gradient[b]).abs() < 1e-6, "{b}: {slope}"); // 2e-8 seen
            for forces in [true, false] {
                system.fill(forces, 0.0);
                for k in system.begins[b]..system.begins[b + 1] {
                    let a = system.carriers[k];
                    let at = |x: f64, y: f64| moved(&[(a, x * h), (b, y * h)]);
                    let mixed =
                        (at(1.0, 1.0) - at(1.0, -1.0) - at(-1.0, 1.0) + at(-1.0, -1.0)) / (4.0 * h * h);
                    let error = (mixed - system.rows[k]).abs();
                    if forces {
                        assert!(error < 1e-5, "{a} {b}: {mixed} {}", system.rows[k]); // 4e-7 seen
                    } else {
                        apart = apart.max(error);
                    }
                }
            }
        }
        assert!(apart > 1.0, "{apart}");
    }
}
