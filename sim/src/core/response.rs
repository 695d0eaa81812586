//! Response: how the touching bodies answer to impulses, in the space of their twists.
//!
//! In: a [`Factor`] of the tree, poses. Out: `Y = L⁻ᵀ Jᵀ` for the twist of each [`Slot`], along its chain, and `G = Yᵀ Y`, the
//! twist of every slot per unit wrench on every other (`6 × 6` blocks): the Delassus operator before it meets points and
//! directions. Two bodies share the beginning of their chains and nothing else, so a block of G is a sum over that.
//!
//! A twist is the velocity of a body's origin and its angular velocity, world axes; a wrench is the same dual. That of a body against another
//! is J of the first less J of the second at the same point: what moves both alike falls out, and a wrench on it pushes one as it pulls
//! the other. Its chain is that of the first body, then what the second has of its own. Nothing allocates while no more slots touch than
//! [`Response::new`] reserves for: all bodies, and [`PAIRS`] pairs.

use dynamics::{Model, State};
use motion::Vec3;

use super::contact::{apply, dot6};
use super::factor::Factor;
use super::find::Slot;
use super::shapes::Shapes;
use super::tree::Tree;

/// A vector per direction of a twist.
pub(super) type Twist = [f64; 6];

/// Pairs of bodies that may touch each other at once without memory being asked for.
const PAIRS: usize = 12;

/// Y, G and the twists before contact. See the module header.
#[derive(Clone, Debug)]
pub(super) struct Response {
    /// Y of all touching bodies, one after another.
    y: Vec<Twist>,
    /// Its degrees of freedom.
    dofs: Vec<usize>,
    /// Where that of each begins.
    at: Vec<usize>,
    /// Position of each degree of freedom in the slot at hand.
    position: Vec<usize>,
    /// Blocks of G, by columns: `g[a * n + b]` is the twist of a per wrench on b.
    pub g: Vec<[Twist; 6]>,
    /// Twists without contact impulses.
    pub free: Vec<Twist>,
}

impl Response {
    pub fn new(tree: &Tree, shapes: &Shapes, dofs: usize) -> Self {
        let pairs = shapes.pairs.len().min(PAIRS);
        let rows = shapes.groups.iter().map(|g| tree.moving(g.body).len()).sum::<usize>() + pairs * dofs;
        let n = shapes.groups.len() + pairs;
        Self {
            y: Vec::with_capacity(rows),
            dofs: Vec::with_capacity(rows),
            position: vec![usize::MAX; dofs],
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
        slots: &[Slot],
        v: &[f64],
        from: usize,
    ) {
        self.y.clear();
        self.dofs.clear();
        self.at.clear();
        self.free.clear();
        for slot in slots {
            let chain = tree.moving(slot.body);
            let start = self.y.len();
            self.at.push(start);
            self.dofs.extend_from_slice(chain);
            self.y.resize(start + chain.len(), [0.0; 6]);
            let origin = state.bodies[slot.body].origin();
            jacobian((model, state), slot.body, &origin, &mut self.y[start..]);
            if let Some(other) = slot.other {
                let theirs = tree.moving(other);
                let shared = chain.iter().zip(theirs).take_while(|(x, y)| x == y).count();
                // what moves both alike moves neither against the other
                self.y[start..start + shared].fill([0.0; 6]);
                // the whole chain first; what is shared is taken out again
                let end = self.y.len();
                self.y.resize(end + theirs.len(), [0.0; 6]);
                jacobian((model, state), other, &origin, &mut self.y[end..]);
                self.y.drain(end..end + shared);
                for x in self.y[end..].iter_mut().flatten() {
                    *x = -*x;
                }
                self.dofs.extend_from_slice(&theirs[shared..]);
            }
            let mut twist = [0.0; 6];
            for (column, &dof) in self.y[start..].iter().zip(&self.dofs[start..]) {
                for (t, c) in twist.iter_mut().zip(column) {
                    *t += c * v[dof];
                }
            }
            self.free.push(twist);
            let (own, rest) = self.y[start..].split_at_mut(chain.len());
            if let Some(other) = slot.other {
                factor.solve_branch(tree, tree.moving(other), own, rest, from);
            }
            factor.solve_chain(tree, chain, own, from);
        }
        self.at.push(self.y.len());
        let n = slots.len();
        self.g.clear();
        self.g.resize(n * n, [[0.0; 6]; 6]);
        for a in 0..n {
            let pair = slots[a].other.is_some();
            if pair {
                for (i, &dof) in self.dofs[self.at[a]..self.at[a + 1]].iter().enumerate() {
                    self.position[dof] = i;
                }
            }
            for b in 0..=a {
                let (of_a, of_b) =
                    (&self.dofs[self.at[a]..self.at[a + 1]], &self.dofs[self.at[b]..self.at[b + 1]]);
                let (y_a, y_b) = (&self.y[self.at[a]..self.at[a + 1]], &self.y[self.at[b]..self.at[b + 1]]);
                let mut block = [[0.0; 6]; 6];
                if pair {
                    for (&dof, y) in of_b.iter().zip(y_b) {
                        if dof >= from && self.position[dof] != usize::MAX {
                            outer(&mut block, &y_a[self.position[dof]], y);
                        }
                    }
                } else {
                    let shared = of_a.iter().zip(of_b).take_while(|(x, y)| x == y).count();
                    let rows = from.min(shared)..shared;
                    for (ya, yb) in y_a[rows.clone()].iter().zip(&y_b[rows]) {
                        outer(&mut block, ya, yb);
                    }
                }
                self.g[a * n + b] = block;
                if a != b {
                    let transposed: [Twist; 6] =
                        std::array::from_fn(|i| std::array::from_fn(|j| block[j][i]));
                    self.g[b * n + a] = transposed;
                }
            }
            if pair {
                self.position.fill(usize::MAX);
            }
        }
    }

    /// How many slots there are.
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
    pub fn add_free(&mut self, z: &[f64]) {
        for (slot, free) in self.free.iter_mut().enumerate() {
            let rows = self.at[slot]..self.at[slot + 1];
            for (row, &dof) in self.y[rows.clone()].iter().zip(&self.dofs[rows]) {
                for (t, x) in free.iter_mut().zip(row) {
                    *t += x * z[dof];
                }
            }
        }
    }

    /// `z ← Y w`, by degree of freedom: velocities are then `L⁻¹ z`.
    pub fn gather(&self, wrenches: &[Twist], z: &mut [f64]) {
        z.fill(0.0);
        for (slot, wrench) in wrenches.iter().enumerate() {
            let rows = self.at[slot]..self.at[slot + 1];
            for (row, &dof) in self.y[rows.clone()].iter().zip(&self.dofs[rows]) {
                z[dof] += dot6(row, wrench);
            }
        }
    }
}

/// Columns of the twist that the degrees of freedom of a body's chain give the point of it at `origin`.
fn jacobian((model, state): (&Model, &State), body: usize, origin: &Vec3, columns: &mut [Twist]) {
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
}

#[inline(always)]
fn outer(block: &mut [Twist; 6], ya: &Twist, yb: &Twist) {
    for (column, yb) in block.iter_mut().zip(yb) {
        for (entry, ya) in column.iter_mut().zip(ya) {
            *entry += ya * yb;
        }
    }
}
