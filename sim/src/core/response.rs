//! Response: how the touching bodies answer to impulses, in the space of their twists.
//!
//! In: a [`Factor`] of the tree, poses. Out: `Y = L⁻ᵀ Jᵀ` for the twist of each touching body, along its chain, and `G = Yᵀ Y`, the
//! twist of every touching body per unit wrench on every other (`6 × 6` blocks): the Delassus operator before it meets points and
//! directions. Two bodies share the beginning of their chains and nothing else, so a block of G is a sum over that.
//!
//! A twist is the velocity of a body's origin and its angular velocity, world axes; a wrench is the same dual. Nothing allocates
//! once a substep with as many touching bodies has been seen by [`Response::new`], which reserves for all.

use dynamics::{Model, State};

use super::contact::{apply, dot6};
use super::factor::Factor;
use super::shapes::Group;
use super::tree::Tree;

/// A vector per direction of a twist.
pub(super) type Twist = [f64; 6];

/// Y, G and the twists before contact. See the module header.
#[derive(Clone, Debug)]
pub(super) struct Response {
    /// Y of all touching bodies, one after another.
    y: Vec<Twist>,
    /// Where that of each begins.
    at: Vec<usize>,
    /// Blocks of G, by columns: `g[a * n + b]` is the twist of a per wrench on b.
    pub g: Vec<[Twist; 6]>,
    /// Twists without contact impulses.
    pub free: Vec<Twist>,
}

impl Response {
    pub fn new(tree: &Tree, groups: &[Group]) -> Self {
        let rows = groups.iter().map(|g| tree.moving(g.body).len()).sum();
        let n = groups.len();
        Self {
            y: Vec::with_capacity(rows),
            at: Vec::with_capacity(n + 1),
            g: Vec::with_capacity(n * n),
            free: Vec::with_capacity(n),
        }
    }

    /// Prepares for the touching bodies.
    ///
    /// * `v`: velocities without contact impulses
    /// * `from`: first degree of freedom that impulses can change; those before move as given
    pub fn prepare(
        &mut self,
        (model, tree, state): (&Model, &Tree, &State),
        factor: &Factor,
        touching: &[usize],
        v: &[f64],
        from: usize,
    ) {
        self.y.clear();
        self.at.clear();
        self.free.clear();
        for &body in touching {
            let chain = tree.moving(body);
            let start = self.y.len();
            self.at.push(start);
            self.y.resize(start + chain.len(), [0.0; 6]);
            let origin = state.bodies[body].origin();
            let columns = &mut self.y[start..];
            // the chain ends with the axes of the body's own joint, and its parents come before it
            let mut end = columns.len();
            let mut up = Some(body);
            while let Some(i) = up {
                let b = &model.bodies[i];
                let arm = origin - state.bodies[i].origin();
                end -= b.joint.nv();
                state.joint_axes(model, i, |dof, linear, angular| {
                    let l = linear + angular.cross(&arm);
                    columns[end + dof - b.v_at] = [l.x, l.y, l.z, angular.x, angular.y, angular.z];
                });
                up = b.parent;
            }
            let mut twist = [0.0; 6];
            for (column, &dof) in columns.iter().zip(chain) {
                for (t, c) in twist.iter_mut().zip(column) {
                    *t += c * v[dof];
                }
            }
            self.free.push(twist);
            factor.solve_chain(tree, chain, columns, from);
        }
        self.at.push(self.y.len());
        let n = touching.len();
        self.g.clear();
        self.g.resize(n * n, [[0.0; 6]; 6]);
        for a in 0..n {
            for b in 0..=a {
                let (of_a, of_b) = (tree.moving(touching[a]), tree.moving(touching[b]));
                let shared = of_a.iter().zip(of_b).take_while(|(x, y)| x == y).count();
                let mut block = [[0.0; 6]; 6];
                let rows = self.y[self.at[a]..][from.min(shared)..shared]
                    .iter()
                    .zip(&self.y[self.at[b]..][from.min(shared)..shared]);
                for (ya, yb) in rows {
                    for (column, yb) in block.iter_mut().zip(yb) {
                        for (entry, ya) in column.iter_mut().zip(ya) {
                            *entry += ya * yb;
                        }
                    }
                }
                self.g[a * n + b] = block;
                if a != b {
                    let transposed: [Twist; 6] =
                        std::array::from_fn(|i| std::array::from_fn(|j| block[j][i]));
                    self.g[b * n + a] = transposed;
                }
            }
        }
    }

    /// How many bodies touch.
    pub fn bodies(&self) -> usize {
        self.free.len()
    }

    /// Twists under wrenches: `u = free + G w`.
    pub fn twists(&self, wrenches: &[Twist], twists: &mut [Twist]) {
        let n = self.free.len();
        twists.copy_from_slice(&self.free);
        for (a, twist) in twists.iter_mut().enumerate() {
            for (b, w) in wrenches.iter().enumerate() {
                let change = apply(&self.g[a * n + b], w);
                for (t, c) in twist.iter_mut().zip(&change) {
                    *t += c;
                }
            }
        }
    }

    /// Adds what a velocity change of the chains makes of the twists without contact, given as `z = L v` (by degree of freedom).
    pub fn add_free(&mut self, tree: &Tree, touching: &[usize], z: &[f64]) {
        for (slot, &body) in touching.iter().enumerate() {
            let y = &self.y[self.at[slot]..self.at[slot + 1]];
            for (row, &dof) in y.iter().zip(tree.moving(body)) {
                for (t, x) in self.free[slot].iter_mut().zip(row) {
                    *t += x * z[dof];
                }
            }
        }
    }

    /// `z ← Y w`, by degree of freedom: velocities are then `L⁻¹ z`.
    pub fn gather(&self, tree: &Tree, touching: &[usize], wrenches: &[Twist], z: &mut [f64]) {
        z.fill(0.0);
        for (slot, &body) in touching.iter().enumerate() {
            let y = &self.y[self.at[slot]..self.at[slot + 1]];
            for (row, &dof) in y.iter().zip(tree.moving(body)) {
                z[dof] += dot6(row, &wrenches[slot]);
            }
        }
    }
}
