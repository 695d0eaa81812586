//! Mass matrix: the composite-rigid-body algorithm (Featherstone 2008, §6.2, Table 6.2), world axes.
//!
//! In: a [`Model`] and the pose in its [`State`]. Out: M(q), `nv × nv`, rows and columns in the layout
//! of `v` ([`motion::skeleton`]): symmetric, positive definite when every joint carries mass.
//!
//! From the tips inward, `I^c` of each body with all it carries; the spatial momentum `F = I^c S` of its
//! joint's axes at unit rate; and for the joint and every joint inboard, with motion subspace `S_a`,
//! `M = S_aᵀ F`. Nothing is rotated on the way: all is along world axes, and only the point about which
//! moments are taken moves, to the origin of each inboard body. Blocks of joints on different branches
//! are zero.

use motion::{Joint, Vec3};
use nalgebra::{DMatrix, Matrix3, SVector};

use crate::composite::{Axes, Composite, Momenta};
use crate::model::{BodyState, Model, MovingBody, State};

/// Where the blocks of M go.
trait Target {
    /// Row of one axis `a` of `body` at columns k…k+W.
    fn row<const N: usize, const W: usize>(
        &mut self,
        body: usize,
        a: usize,
        k: usize,
        value: &SVector<f64, N>,
    );

    /// Rows a, a+1, a+2 of `body` at columns k…k+W; `places`: a, and the first degree of freedom of `body`.
    fn rows<const N: usize, const W: usize>(
        &mut self,
        body: usize,
        places: (usize, usize),
        k: usize,
        f: &Axes<N>,
    );
}

/// `m`, column-major `n × n`: blocks and their mirror images.
struct Dense<'a> {
    m: &'a mut [f64],
    n: usize,
}

impl Target for Dense<'_> {
    #[inline(always)]
    fn row<const N: usize, const W: usize>(&mut self, _: usize, a: usize, k: usize, value: &SVector<f64, N>) {
        let at = a * self.n + k;
        self.m[at..at + W].copy_from_slice(&value.as_slice()[..W]);
        for c in 0..W {
            self.m[(k + c) * self.n + a] = value[c];
        }
    }

    #[inline(always)]
    fn rows<const N: usize, const W: usize>(
        &mut self,
        _: usize,
        (a, _): (usize, usize),
        k: usize,
        f: &Axes<N>,
    ) {
        let mut at = a * self.n + k;
        for row in f {
            self.m[at..at + W].copy_from_slice(&row.as_slice()[..W]);
            at += self.n;
        }
        let mut at = k * self.n + a;
        for c in 0..W {
            self.m[at..at + 3].copy_from_slice(&[f[0][c], f[1][c], f[2][c]]);
            at += self.n;
        }
    }
}

/// The lower triangle on the sparsity of the tree. See [`State::mass_rows`].
struct Packed<'a> {
    rows: &'a mut [f64],
    at: &'a [usize],
    depth: &'a [usize],
}

impl Target for Packed<'_> {
    #[inline(always)]
    fn row<const N: usize, const W: usize>(
        &mut self,
        body: usize,
        _: usize,
        k: usize,
        value: &SVector<f64, N>,
    ) {
        let depth = self.depth[body];
        for c in 0..W {
            self.rows[self.at[k + c] + depth] = value[c];
        }
    }

    #[inline(always)]
    fn rows<const N: usize, const W: usize>(
        &mut self,
        body: usize,
        (a, first): (usize, usize),
        k: usize,
        f: &Axes<N>,
    ) {
        let position = self.depth[body] + a - first;
        for c in 0..W {
            let values = [f[0][c], f[1][c], f[2][c]];
            // columns of the joint itself end at the diagonal
            let len = (k + c + 1).saturating_sub(a).min(3);
            let from = self.at[k + c] + position;
            if len == 3 {
                self.rows[from..from + 3].copy_from_slice(&values);
            } else {
                self.rows[from..from + len].copy_from_slice(&values[..len]);
            }
        }
    }
}

/// The block of the joint of `body` against W axes that start at column k.
#[inline(always)]
fn block<const N: usize, const W: usize>(
    target: &mut impl Target,
    (body, b, s): (usize, &MovingBody, &BodyState),
    k: usize,
    p: &Axes<N>,
    l: &Axes<N>,
) {
    let at = b.v_at;
    match b.joint {
        // a root whose zero frame is the world's
        Joint::Free if b.parent.is_none() && b.turned.is_none() => {
            target.rows::<N, W>(body, (at, at), k, p);
            target.rows::<N, W>(body, (at + 3, at), k, l);
        }
        Joint::Free => {
            target.rows::<N, W>(body, (at, at), k, &along_columns(&s.zero, p));
            target.rows::<N, W>(body, (at + 3, at), k, &along_columns(&s.zero, l));
        }
        Joint::Spherical => target.rows::<N, W>(body, (at, at), k, &along_columns(&s.zero, l)),
        Joint::Revolute(_) => target.row::<N, W>(body, at, k, &along(&s.axis, l)),
        Joint::Prismatic(_) => target.row::<N, W>(body, at, k, &along(&s.axis, p)),
        Joint::Fixed => {}
    }
}

/// Blocks of W axes of `body`, from column k, against the body's joint and all inboard.
fn column<const N: usize, const W: usize>(
    target: &mut impl Target,
    (model, states): (&Model, &[BodyState]),
    body: usize,
    k: usize,
    f: &Momenta<N>,
) {
    let own = &states[body];
    block::<N, W>(target, (body, &model.bodies[body], own), k, &f.p, &f.l);
    let mut up = model.bodies[body].parent;
    while let Some(p) = up {
        let (b, s) = (&model.bodies[p], &states[p]);
        block::<N, W>(target, (p, b, s), k, &f.p, &f.angular_about(&(own.origin() - s.origin())));
        up = b.parent;
    }
}

impl State {
    /// Mass matrix (`nv × nv`), both triangles.
    ///
    /// `vᵀ M v / 2` is the kinetic energy. Needs [`State::update_pose`] (or `update`); does not allocate.
    ///
    /// # Panics
    /// If `m` is not `nv × nv`.
    pub fn mass_matrix(&mut self, model: &Model, m: &mut DMatrix<f64>) {
        let n = model.nv();
        assert_eq!(m.shape(), (n, n), "the mass matrix is nv × nv");
        let m = m.as_mut_slice();
        m.fill(0.0);
        self.composite_rigid_bodies(model, &mut Dense { m, n });
    }

    /// The lower triangle of the mass matrix on the sparsity of the tree, into `rows`: row k has entries at the degrees of freedom inboard
    /// of k alone, root first, and its own last (Featherstone 2008, §6.5).
    ///
    /// Nothing else of `rows` is written. Needs [`State::update_pose`] (or `update`); does not allocate.
    ///
    /// * `at`: where row k begins, for every degree of freedom
    /// * `depth`: how many degrees of freedom lie inboard of the joint, for every body
    ///
    /// # Panics
    /// If `rows`, `at` or `depth` are too short.
    pub fn mass_rows(&mut self, model: &Model, (at, depth): (&[usize], &[usize]), rows: &mut [f64]) {
        self.composite_rigid_bodies(model, &mut Packed { rows, at, depth });
    }

    #[inline(always)]
    fn composite_rigid_bodies(&mut self, model: &Model, target: &mut impl Target) {
        for ((c, b), s) in self.carried.iter_mut().zip(&model.bodies).zip(&self.bodies) {
            *c = Composite::of(b.mass, &s.inertia, &s.to_com);
        }
        let states = &self.bodies;
        let tree = (model, states.as_slice());
        for (i, b) in model.bodies.iter().enumerate().rev() {
            let (s, carried) = (&states[i], self.carried[i]);
            let at = b.v_at;
            match b.joint {
                Joint::Free => {
                    let axes = lanes(&s.zero);
                    column::<4, 3>(target, tree, i, at, &carried.sliding(&axes));
                    column::<4, 3>(target, tree, i, at + 3, &carried.turning(&axes));
                }
                Joint::Spherical => column::<4, 3>(target, tree, i, at, &carried.turning(&lanes(&s.zero))),
                Joint::Revolute(_) => column::<1, 1>(target, tree, i, at, &carried.turning(&single(&s.axis))),
                Joint::Prismatic(_) => {
                    column::<1, 1>(target, tree, i, at, &carried.sliding(&single(&s.axis)))
                }
                Joint::Fixed => {}
            }
            if let Some(p) = b.parent {
                let shifted = carried.about(&s.arm);
                self.carried[p].add(&shifted);
            }
        }
    }
}

/// Components of N vectors along one axis.
#[inline(always)]
fn along<const N: usize>(axis: &Vec3, f: &Axes<N>) -> SVector<f64, N> {
    f[0] * axis.x + f[1] * axis.y + f[2] * axis.z
}

/// Components of N vectors along the columns of a rotation.
#[inline(always)]
fn along_columns<const N: usize>(zero: &Matrix3<f64>, f: &Axes<N>) -> Axes<N> {
    let column = |c: usize| f[0] * zero[(0, c)] + f[1] * zero[(1, c)] + f[2] * zero[(2, c)];
    [column(0), column(1), column(2)]
}

#[inline(always)]
fn lanes(zero: &Matrix3<f64>) -> Axes<4> {
    let row = |r: usize| SVector::<f64, 4>::new(zero[(r, 0)], zero[(r, 1)], zero[(r, 2)], 0.0);
    [row(0), row(1), row(2)]
}

#[inline(always)]
fn single(axis: &Vec3) -> Axes<1> {
    [SVector::<f64, 1>::new(axis.x), SVector::<f64, 1>::new(axis.y), SVector::<f64, 1>::new(axis.z)]
}
