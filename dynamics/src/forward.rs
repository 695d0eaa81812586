//! Forward dynamics: accelerations from generalised forces, `v̇ = M⁻¹ (τ + Σ Jᵀ w − c(q, v))`.
//!
//! In: a [`Model`], its [`State`] at (q, v), forces `τ`. Out: `v̇`. The mass matrix comes from
//! [`State::mass_matrix`], the bias `c` from [`State::bias`]; M is factored as `M = Lᵀ L`, L lower
//! triangular, from the last degree of freedom to the first (Featherstone 2008, §6.5). In
//! this order L is zero wherever M is zero by the tree: row k of L has entries only at the axes inboard
//! of axis k, so the work is Σ depth² and not nv³/6.
//!
//! All vectors are `nv`, layout of `v` ([`motion::skeleton`]), N, N·m, m/s², rad/s².

use nalgebra::DMatrix;
use thiserror::Error;

use crate::{Model, State, Wrench};

/// A direction in which the model has no inertia.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("degree of freedom {dof} moves no inertia (pivot {pivot:e}); its acceleration is not defined")]
pub struct NoInertia {
    /// Index in `v`.
    pub dof: usize,
    /// Pivot found, kg or kg·m²; not positive.
    pub pivot: f64,
}

/// Memory of forward dynamics for one model: mass matrix, factor, bias.
#[derive(Clone, Debug)]
pub struct ForwardDynamics {
    /// Nearest axis inboard of each axis; its own index for the first ones.
    inboard: Vec<usize>,
    /// L in the lower triangle after [`ForwardDynamics::factor`].
    factor: DMatrix<f64>,
    bias: Vec<f64>,
}

impl ForwardDynamics {
    /// Memory for `model`.
    pub fn new(model: &Model) -> Self {
        let n = model.nv();
        let mut inboard: Vec<usize> = (0..n).collect();
        for b in &model.bodies {
            let mut up = b.parent;
            let carrier = loop {
                match up {
                    Some(p) if model.bodies[p].joint.nv() == 0 => up = model.bodies[p].parent,
                    _ => break up,
                }
            };
            for k in 0..b.joint.nv() {
                let dof = b.v_at + k;
                inboard[dof] = match (k, carrier) {
                    (0, None) => dof,
                    (0, Some(p)) => model.bodies[p].v_at + model.bodies[p].joint.nv() - 1,
                    _ => dof - 1,
                };
            }
        }
        Self { inboard, factor: DMatrix::zeros(n, n), bias: vec![0.0; n] }
    }

    /// Accelerations `vd` under forces `tau` and outside wrenches.
    ///
    /// [`State::update`] must have been called for the pose and `v`. Does not allocate.
    ///
    /// # Errors
    /// [`NoInertia`] if an axis moves nothing.
    pub fn accelerations(
        &mut self,
        model: &Model,
        state: &mut State,
        v: &[f64],
        tau: &[f64],
        wrenches: &[Wrench],
        vd: &mut [f64],
    ) -> Result<(), NoInertia> {
        state.bias(model, v, &mut self.bias);
        for ((a, t), c) in vd.iter_mut().zip(tau).zip(&self.bias) {
            *a = t - c;
        }
        for w in wrenches {
            state.add_wrench(model, w, vd);
        }
        self.factor(model, state)?;
        self.solve(vd);
        Ok(())
    }

    /// Factors the mass matrix at the state's pose, `M = Lᵀ L`.
    ///
    /// # Errors
    /// [`NoInertia`] if an axis moves nothing.
    pub fn factor(&mut self, model: &Model, state: &mut State) -> Result<(), NoInertia> {
        state.mass_matrix(model, &mut self.factor);
        let (n, up) = (self.inboard.len(), &self.inboard);
        let l = self.factor.as_mut_slice();
        // the matrix is stored whole and by columns: column k of its upper triangle is row k of L, contiguous in memory
        for k in (0..n).rev() {
            let (inner, row) = l.split_at_mut(k * n);
            let row = &mut row[..=k];
            let pivot = row[k];
            if !(pivot > 0.0 && pivot.is_finite()) {
                return Err(NoInertia { dof: k, pivot });
            }
            row[k] = pivot.sqrt();
            let scale = 1.0 / row[k];
            let mut i = k;
            while up[i] != i {
                i = up[i];
                row[i] *= scale;
            }
            let mut i = k;
            while up[i] != i {
                i = up[i];
                let x = row[i];
                let target = &mut inner[i * n..i * n + i + 1];
                let mut j = i;
                loop {
                    target[j] -= x * row[j];
                    if up[j] == j {
                        break;
                    }
                    j = up[j];
                }
            }
        }
        Ok(())
    }

    /// Replaces `x` (`nv`) by `M⁻¹ x`, with the last factor.
    pub fn solve(&self, x: &mut [f64]) {
        let (n, up) = (self.inboard.len(), &self.inboard);
        let l = self.factor.as_slice();
        // Lᵀ y = x, tips first
        for k in (0..n).rev() {
            let row = &l[k * n..=k * n + k];
            x[k] /= row[k];
            let mut i = k;
            while up[i] != i {
                i = up[i];
                x[i] -= row[i] * x[k];
            }
        }
        // L z = y, root first
        for k in 0..n {
            let row = &l[k * n..=k * n + k];
            let mut sum = x[k];
            let mut i = k;
            while up[i] != i {
                i = up[i];
                sum -= row[i] * x[i];
            }
            x[k] = sum / row[k];
        }
    }
}
