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

/// `m`, column-major `n × n`, with the place where rows and columns of one joint go.
struct Target<'a> {
    m: &'a mut [f64],
    n: usize,
}

impl Target<'_> {
    /// Entries (a, k…k+W) and their mirror images.
    #[inline(always)]
    fn row<const N: usize, const W: usize>(&mut self, a: usize, k: usize, value: &SVector<f64, N>) {
        let at = a * self.n + k;
        self.m[at..at + W].copy_from_slice(&value.as_slice()[..W]);
        for c in 0..W {
            self.m[(k + c) * self.n + a] = value[c];
        }
    }

    /// Rows a, a+1, a+2 at columns k…k+W, and their mirror images.
    #[inline(always)]
    fn rows<const N: usize, const W: usize>(&mut self, a: usize, k: usize, f: &Axes<N>) {
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

    /// The block of the joint of `b` against W axes that start at column k.
    #[inline(always)]
    fn block<const N: usize, const W: usize>(
        &mut self,
        b: &MovingBody,
        s: &BodyState,
        k: usize,
        p: &Axes<N>,
        l: &Axes<N>,
    ) {
        let at = b.v_at;
        match b.joint {
            // a root whose zero frame is the world's
            Joint::Free if b.parent.is_none() && b.turned.is_none() => {
                self.rows::<N, W>(at, k, p);
                self.rows::<N, W>(at + 3, k, l);
            }
            Joint::Free => {
                self.rows::<N, W>(at, k, &along_columns(&s.zero, p));
                self.rows::<N, W>(at + 3, k, &along_columns(&s.zero, l));
            }
            Joint::Spherical => self.rows::<N, W>(at, k, &along_columns(&s.zero, l)),
            Joint::Revolute(_) => self.row::<N, W>(at, k, &along(&s.axis, l)),
            Joint::Prismatic(_) => self.row::<N, W>(at, k, &along(&s.axis, p)),
            Joint::Fixed => {}
        }
    }

    /// Blocks of W axes of `body`, from column k, against the body's joint and all inboard.
    fn column<const N: usize, const W: usize>(
        &mut self,
        model: &Model,
        states: &[BodyState],
        body: usize,
        k: usize,
        f: &Momenta<N>,
    ) {
        let own = &states[body];
        self.block::<N, W>(&model.bodies[body], own, k, &f.p, &f.l);
        let mut up = model.bodies[body].parent;
        while let Some(p) = up {
            let (b, s) = (&model.bodies[p], &states[p]);
            self.block::<N, W>(b, s, k, &f.p, &f.angular_about(&(own.origin() - s.origin())));
            up = b.parent;
        }
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
        let mut target = Target { m: m.as_mut_slice(), n };
        target.m.fill(0.0);
        for ((c, b), s) in self.carried.iter_mut().zip(&model.bodies).zip(&self.bodies) {
            *c = Composite::of(b.mass, &s.inertia, &s.to_com);
        }
        let states = &self.bodies;
        for (i, b) in model.bodies.iter().enumerate().rev() {
            let (s, carried) = (&states[i], self.carried[i]);
            let at = b.v_at;
            match b.joint {
                Joint::Free => {
                    let axes = lanes(&s.zero);
                    target.column::<4, 3>(model, states, i, at, &carried.sliding(&axes));
                    target.column::<4, 3>(model, states, i, at + 3, &carried.turning(&axes));
                }
                Joint::Spherical => {
                    target.column::<4, 3>(model, states, i, at, &carried.turning(&lanes(&s.zero)));
                }
                Joint::Revolute(_) => {
                    target.column::<1, 1>(model, states, i, at, &carried.turning(&single(&s.axis)));
                }
                Joint::Prismatic(_) => {
                    target.column::<1, 1>(model, states, i, at, &carried.sliding(&single(&s.axis)));
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
