//! Derivatives of inverse dynamics: ∂τ/∂q, ∂τ/∂v and ∂τ/∂v̇ = M, analytic.
//!
//! In: a [`Model`], its [`State`] at (q, v), accelerations `v̇`, outside wrenches. Out: three `nv × nv`
//! matrices; entry (i, k) is ∂τᵢ over the k-th variable. `∂q` is along the tangent of
//! [`motion::Skeleton::integrate`], q ⊕ δ: for balls and free joints R ← exp(δ) R in the zero frame,
//! with the components of `v` and `v̇` kept. Wrenches stay where they are in the world: neither their
//! point nor their force follows the body.
//!
//! # Method
//!
//! The chain rule through the Newton–Euler recursion with spatial vectors in one inertial frame, as in
//! \[CM18\] and \[SRW22\]; what follows differs from them where a joint has several axes, because our axes
//! stand still under the joint's own motion. World axes, moments about the root's origin. A free joint is
//! a slide along three axes with a ball at its end; λ is the joint inboard.
//!
//! `V = V_λ + S v`, `A = A_λ + S v̇ + V_λ × S v`, `F = I A + V ×* I V`, `τ = Sᵀ F^c`; `^c` sums over all
//! that is carried. Turning axis k moves all it carries rigidly, except that its own joint's axes and
//! what is inboard stay. Hence for every body it carries
//!
//! ```text
//! δV = S_k × V + b_k                    b_k = V_k × S_k
//! δA = S_k × A + b_k × V + c_k          c_k = A_k × S_k − b_k × V_k
//! δF = S_k ×* F + I c_k + B b_k         B x = I (x × V) + x ×* I V + V ×* I x
//! ```
//!
//! and for a change of rate `δV = S_k`, `δA = S_k × V + d_k`, `δF = I d_k + B S_k` with
//! `d_k = (V_λ + V_k) × S_k`. With outside wrenches W, for i inboard of k or of its joint, and for i
//! outboard of k:
//!
//! ```text
//! ∂τᵢ/∂q_k = Sᵢ·(S_k ×* F^c_k + I^c_k c_k + B^c_k b_k)   |   (I^cᵢ Sᵢ)·c_k + (B^cᵢᵀ Sᵢ)·b_k − S_k·(Sᵢ ×* W^cᵢ)
//! ∂τᵢ/∂v_k = Sᵢ·(I^c_k d_k + B^c_k S_k)                  |   (I^cᵢ Sᵢ)·d_k + (B^cᵢᵀ Sᵢ)·S_k
//! ∂τᵢ/∂v̇_k = Sᵢ·I^c_k S_k                                |   the same, mirrored
//! ```
//!
//! By Jacobi's identity B has but two blocks: `B (x; y) = (N x; 2 x × p)`, p the linear momentum and
//! `N = [w×]J − J[w×] − [h×][u×] − [u×][h×] − [(Jw + h × u)×]` for V = (w; u), J the inertia about the
//! point, h = m c.
//!
//! \[CM18\] Carpentier, Mansard. Analytical Derivatives of Rigid Body Dynamics Algorithms, RSS 2018.
//! \[SRW22\] Singh, Russell, Wensing. Efficient Analytical Derivatives of Rigid-Body Dynamics using
//! Spatial Vector Algebra, RA-L 2022.

use std::ops::{Add, AddAssign};

use motion::{Joint, Vec3};
use nalgebra::{DMatrix, Matrix3};

use crate::model::for_each_axis;
use crate::{Model, State, Wrench};
use bodies::mass::point_inertia;

/// A spatial vector: a motion (angular; linear) or a force (moment; force), about one fixed point.
#[derive(Clone, Copy, Debug, Default)]
struct Spatial {
    turn: Vec3,
    line: Vec3,
}

impl Spatial {
    fn new(turn: Vec3, line: Vec3) -> Self {
        Self { turn, line }
    }

    fn scaled(&self, s: f64) -> Self {
        Self::new(self.turn * s, self.line * s)
    }

    /// Motion × motion.
    fn cross(&self, m: &Self) -> Self {
        Self::new(self.turn.cross(&m.turn), self.turn.cross(&m.line) + self.line.cross(&m.turn))
    }

    /// Motion ×* force.
    fn cross_force(&self, f: &Self) -> Self {
        Self::new(self.turn.cross(&f.turn) + self.line.cross(&f.line), self.turn.cross(&f.line))
    }

    /// Motion · force.
    fn dot(&self, f: &Self) -> f64 {
        self.turn.dot(&f.turn) + self.line.dot(&f.line)
    }
}

impl Add for Spatial {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self::new(self.turn + o.turn, self.line + o.line)
    }
}

impl AddAssign for Spatial {
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

/// Axes that move together and leave each other alone: those of a joint, a free joint giving two.
#[derive(Clone, Debug)]
struct Group {
    inboard: Option<usize>,
    /// First axis in `v`, and how many.
    at: usize,
    len: usize,
    /// Body at its outboard end; none between the slide and the ball of a free joint.
    body: Option<usize>,
}

/// What a group carries: inertia, B (see the module header), required force, outside wrench.
#[derive(Clone, Copy, Debug, Default)]
struct Load {
    mass: f64,
    first: Vec3,
    second: Matrix3<f64>,
    n: Matrix3<f64>,
    p: Vec3,
    force: Spatial,
    outside: Spatial,
}

impl Load {
    fn add(&mut self, o: &Self) {
        self.mass += o.mass;
        self.first += o.first;
        self.second += o.second;
        self.n += o.n;
        self.p += o.p;
        self.force += o.force;
        self.outside += o.outside;
    }

    /// I x.
    fn inertia(&self, x: &Spatial) -> Spatial {
        Spatial::new(
            self.second * x.turn + self.first.cross(&x.line),
            x.line * self.mass - self.first.cross(&x.turn),
        )
    }

    /// B x.
    fn b(&self, x: &Spatial) -> Spatial {
        Spatial::new(self.n * x.turn, x.turn.cross(&self.p) * 2.0)
    }

    /// Bᵀ x: its linear part is zero.
    fn b_transposed(&self, x: &Spatial) -> Vec3 {
        self.n.tr_mul(&x.turn) - x.line.cross(&self.p) * 2.0
    }
}

/// Vectors of one axis, named as in the module header.
#[derive(Clone, Copy, Debug, Default)]
struct Axis {
    s: Spatial,
    b: Spatial,
    c: Spatial,
    d: Spatial,
    /// I^c S, δF^c/δq, δF^c/δv.
    inertia: Spatial,
    by_q: Spatial,
    by_v: Spatial,
    /// (B^c)ᵀ S, and S ×* W^c.
    turned: Vec3,
    outside: Spatial,
}

/// The derivatives, and the memory to compute them. See the module header.
#[derive(Clone, Debug)]
pub struct InverseDerivatives {
    /// ∂τ/∂q, N or N·m per m or rad.
    pub q: DMatrix<f64>,
    /// ∂τ/∂v, N·s/m, N·m·s/rad and mixed.
    pub v: DMatrix<f64>,
    /// ∂τ/∂v̇: the mass matrix.
    pub vd: DMatrix<f64>,
    groups: Vec<Group>,
    /// Group whose outboard end is each body.
    group_of: Vec<usize>,
    velocity: Vec<Spatial>,
    acceleration: Vec<Spatial>,
    load: Vec<Load>,
    axes: Vec<Axis>,
}

impl InverseDerivatives {
    /// Memory for `model`; all zero.
    pub fn new(model: &Model) -> Self {
        let n = model.nv();
        let mut groups: Vec<Group> = Vec::new();
        let mut group_of = Vec::new();
        for (i, b) in model.bodies.iter().enumerate() {
            let mut inboard = b.parent.map(|p| group_of[p]);
            let (mut at, mut len) = (b.v_at, b.joint.nv());
            if b.joint == Joint::Free {
                groups.push(Group { inboard, at, len: 3, body: None });
                inboard = Some(groups.len() - 1);
                (at, len) = (at + 3, 3);
            }
            group_of.push(groups.len());
            groups.push(Group { inboard, at, len, body: Some(i) });
        }
        let zero = vec![Spatial::default(); groups.len()];
        Self {
            q: DMatrix::zeros(n, n),
            v: DMatrix::zeros(n, n),
            vd: DMatrix::zeros(n, n),
            load: vec![Load::default(); groups.len()],
            velocity: zero.clone(),
            acceleration: zero,
            axes: vec![Axis::default(); n],
            groups,
            group_of,
        }
    }

    /// Recomputes the three matrices at the state's pose, velocity `v`, acceleration `vd` (`nv` each).
    ///
    /// [`State::update`] (or `update_pose`) must have been called for the pose. Does not allocate.
    pub fn update(&mut self, model: &Model, state: &State, v: &[f64], vd: &[f64], wrenches: &[Wrench]) {
        let point = state.bodies[0].origin();
        self.outward(model, state, v, vd, &point);
        for w in wrenches {
            let group = self.group_of[model.body_of[w.link].0];
            self.load[group].outside += Spatial::new(w.moment_about(&point), w.force);
        }
        self.inward();
        self.fill();
    }

    /// Axes, velocities, accelerations; inertia, momentum and force of each body alone.
    fn outward(&mut self, model: &Model, state: &State, v: &[f64], vd: &[f64], point: &Vec3) {
        for (b, s) in model.bodies.iter().zip(&state.bodies) {
            let arm = s.origin() - point;
            for_each_axis(b, &s.zero, |k, linear, angular| {
                self.axes[k].s = Spatial::new(angular, linear + arm.cross(&angular));
            });
        }
        let rest = (Spatial::default(), Spatial::new(Vec3::zeros(), -model.gravity));
        for (g, group) in self.groups.iter().enumerate() {
            let (v_in, a_in) = group.inboard.map_or(rest, |p| (self.velocity[p], self.acceleration[p]));
            let (mut rate, mut push) = (Spatial::default(), Spatial::default());
            for k in group.at..group.at + group.len {
                rate += self.axes[k].s.scaled(v[k]);
                push += self.axes[k].s.scaled(vd[k]);
            }
            let (velocity, acceleration) = (v_in + rate, a_in + push + v_in.cross(&rate));
            (self.velocity[g], self.acceleration[g]) = (velocity, acceleration);
            self.load[g] = Load::default();
            let Some(body) = group.body else { continue };
            let (b, s) = (&model.bodies[body], &state.bodies[body]);
            let c = s.com - point;
            let load = &mut self.load[g];
            load.mass = b.mass;
            load.first = c * b.mass;
            load.second = s.inertia + point_inertia(b.mass, c);
            let momentum = load.inertia(&velocity);
            load.force = load.inertia(&acceleration) + velocity.cross_force(&momentum);
            load.p = momentum.line;
            let [w, u, h, l] =
                [velocity.turn, velocity.line, load.first, momentum.turn].map(|x| x.cross_matrix());
            load.n = w * load.second - load.second * w - h * u - u * h - l;
        }
    }

    /// Sums over what is carried, and the vectors of each axis.
    fn inward(&mut self) {
        for g in (0..self.groups.len()).rev() {
            let Group { inboard, at, len, .. } = self.groups[g];
            let load = self.load[g];
            let (velocity, acceleration) = (self.velocity[g], self.acceleration[g]);
            let v_in = inboard.map_or(Spatial::default(), |p| self.velocity[p]);
            for axis in &mut self.axes[at..at + len] {
                let s = axis.s;
                axis.b = velocity.cross(&s);
                axis.c = acceleration.cross(&s) + velocity.cross(&axis.b);
                axis.d = v_in.cross(&s) + axis.b;
                axis.inertia = load.inertia(&s);
                axis.by_q = s.cross_force(&load.force) + load.inertia(&axis.c) + load.b(&axis.b);
                axis.by_v = load.inertia(&axis.d) + load.b(&s);
                axis.turned = load.b_transposed(&s);
                axis.outside = s.cross_force(&load.outside);
            }
            if let Some(p) = inboard {
                self.load[p].add(&load);
            }
        }
    }

    /// Entries of all pairs of axes on one branch; the others are zero.
    fn fill(&mut self) {
        for m in [&mut self.q, &mut self.v, &mut self.vd] {
            m.fill(0.0);
        }
        for (g, group) in self.groups.iter().enumerate() {
            for k in group.at..group.at + group.len {
                let outer = &self.axes[k];
                let mut up = Some(g);
                while let Some(a) = up {
                    let Group { inboard, at, len, .. } = self.groups[a];
                    for i in at..at + len {
                        let inner = &self.axes[i];
                        self.q[(i, k)] = inner.s.dot(&outer.by_q);
                        self.v[(i, k)] = inner.s.dot(&outer.by_v);
                        self.vd[(i, k)] = inner.s.dot(&outer.inertia);
                        if a != g {
                            self.q[(k, i)] = inner.c.dot(&outer.inertia) + inner.b.turn.dot(&outer.turned)
                                - inner.s.dot(&outer.outside);
                            self.v[(k, i)] = inner.d.dot(&outer.inertia) + inner.s.turn.dot(&outer.turned);
                            self.vd[(k, i)] = self.vd[(i, k)];
                        }
                    }
                    up = inboard;
                }
            }
        }
    }
}
