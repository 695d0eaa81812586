//! Articulated inertia: what resists each axis while the joints it carries are left free (Featherstone 2008, §7.2).
//!
//! In: a [`Model`] and the pose in its [`State`]. Out: per degree of freedom the pivot of M = Lᵀ D L (§8.5) and the diagonal of M,
//! kg or kg·m², without the mass matrix: the work is linear in the number of bodies.
//!
//! From the tips inward, with the inertia `A` of a body and all it carries about its origin (angular parts first, world axes) and
//! the motion `S` of an axis at unit rate: D = Sᵀ A S, then A ← A − (A S)(A S)ᵀ / D, and at last A as seen from the origin of the body
//! that carries it.

use motion::Vec3;
use nalgebra::{Matrix3, Matrix6, Vector6};

use bodies::mass::point_inertia;

use crate::model::{Model, State, for_each_axis};

/// Inertia of an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisInertia {
    /// With the joints further out left free: the pivot of M = Lᵀ D L; zero or less where nothing resists, and then the axes
    /// further in have no meaning.
    pub free: f64,
    /// With the joints further out held: the diagonal of M.
    pub held: f64,
}

/// The inertia of every axis at the state's pose, layout of `v`.
pub fn axis_inertias(model: &Model, state: &State) -> Vec<AxisInertia> {
    let mut out = vec![AxisInertia::default(); model.nv()];
    let mut free = vec![Matrix6::zeros(); model.bodies.len()];
    let mut held = free.clone();
    for (i, b) in model.bodies.iter().enumerate().rev() {
        let s = &state.bodies[i];
        let own = rigid(b.mass, &s.inertia, &s.to_com);
        (free[i], held[i]) = (free[i] + own, held[i] + own);
        let mut axes: Vec<(usize, Vector6<f64>)> = Vec::with_capacity(6);
        for_each_axis(b, &s.zero, |dof, linear, angular| axes.push((dof, stacked(&angular, &linear))));
        for (dof, axis) in axes.into_iter().rev() {
            let momentum = free[i] * axis;
            let pivot = axis.dot(&momentum);
            out[dof] = AxisInertia { free: pivot, held: axis.dot(&(held[i] * axis)) };
            if pivot > 0.0 {
                free[i] -= momentum * momentum.transpose() / pivot;
            }
        }
        if let Some(p) = b.parent {
            let shift = seen_at(&s.arm);
            let moved = |a: &Matrix6<f64>| shift.transpose() * a * shift;
            let (f, h) = (moved(&free[i]), moved(&held[i]));
            (free[p], held[p]) = (free[p] + f, held[p] + h);
        }
    }
    out
}

fn stacked(angular: &Vec3, linear: &Vec3) -> Vector6<f64> {
    Vector6::new(angular.x, angular.y, angular.z, linear.x, linear.y, linear.z)
}

/// A rigid body about a point from which its centre of mass is seen at `c`.
fn rigid(mass: f64, inertia: &Matrix3<f64>, c: &Vec3) -> Matrix6<f64> {
    let first = c.cross_matrix() * mass;
    let mut out = Matrix6::zeros();
    out.fixed_view_mut::<3, 3>(0, 0).copy_from(&(inertia + point_inertia(mass, *c)));
    out.fixed_view_mut::<3, 3>(0, 3).copy_from(&first);
    out.fixed_view_mut::<3, 3>(3, 0).copy_from(&first.transpose());
    out.fixed_view_mut::<3, 3>(3, 3).copy_from(&(Matrix3::identity() * mass));
    out
}

/// A motion about one origin as that about another, seen from it at `r`: v + ω × r.
fn seen_at(r: &Vec3) -> Matrix6<f64> {
    let mut out = Matrix6::identity();
    out.fixed_view_mut::<3, 3>(3, 0).copy_from(&-r.cross_matrix());
    out
}

#[cfg(test)]
mod tests {
    use bodies::anthropometry::human::human;
    use nalgebra::DMatrix;

    use super::*;

    /// Pivots and diagonal of the mass matrix, by elimination in the matrix itself: balls, hinges and a free root.
    #[test]
    fn they_are_pivots_and_diagonal_of_the_mass_matrix() {
        let human = human().0;
        let model = Model::new(&human, Vec3::zeros());
        let n = model.nv();
        let mut q = human.rest.clone();
        let turn: Vec<f64> = (0..n).map(|i| (1.3 * i as f64).sin()).collect();
        human.skeleton.integrate(&mut q, &turn, 1.0);
        let mut state = State::new(&model);
        state.update_pose(&model, &q);
        let found = axis_inertias(&model, &state);
        let mut m = DMatrix::zeros(n, n);
        state.mass_matrix(&model, &mut m);
        for k in 0..n {
            let error = (found[k].held / m[(k, k)] - 1.0).abs();
            assert!(error < 1e-12, "axis {k}: {error}"); // 8e-15 seen
        }
        for k in (0..n).rev() {
            let error = (found[k].free / m[(k, k)] - 1.0).abs();
            assert!(error < 1e-9, "axis {k}: {error}"); // 2e-12 seen
            for i in 0..k {
                let factor = m[(i, k)] / m[(k, k)];
                for j in 0..k {
                    m[(i, j)] -= factor * m[(k, j)];
                }
            }
        }
    }
}
