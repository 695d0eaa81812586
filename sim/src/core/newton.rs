//! Newton: the finish of a contact solution, in the twists of the touching bodies.
//!
//! In: contacts, impulses λ and twists near a solution. Out: better impulses. Every point is open, sticks or slides by the signs of
//! Alart and Curnier's equations `λ_n = max(0, λ_n − ρ u_n)`, `λ_t = Π_disc(λ_t − ρ u_t)` (Comput. Methods Appl. Mech. Eng. 92, 1991),
//! whose slope there gives `δλ = g − A W δu` with 3 × 3 matrices A. With the change of the twists `δu = G Σ Wᵀ δλ` this is
//! one linear system of six unknowns per touching body, `(1 + G Σ Wᵀ A W) δu = G Σ Wᵀ g`.
//!
//! Where points stick (and where any is pressed, along its normal) the equation is `u = 0`, which redundant points cannot tell apart.
//! It is taken as `δλ = −σ (u + δu)` with σ [`STIFF`] times the apparent mass: the step of a proximal point method, which leaves
//! alone what redundant points share.

use super::contact::{Contact, apply};
use super::response::{Response, Twist};
use super::solve::disc;

/// σ over the apparent mass.
const STIFF: f64 = 1e7;
/// More loaded bodies than this are left to the sweeps: the system is dense.
const BODIES: usize = 20;

/// The memory of a step.
#[derive(Clone, Debug)]
pub(super) struct Newton {
    /// Bodies with a point that is not open: only their twists matter.
    loaded: Vec<usize>,
    /// `6 n × 6 n`, by rows.
    matrix: Vec<f64>,
    right: Vec<f64>,
    /// `Σ Wᵀ A W` of each body, by rows.
    stiffness: Vec<[Twist; 6]>,
    /// `Σ Wᵀ g`.
    push: Vec<Twist>,
    /// A and g of each contact.
    laws: Vec<([[f64; 3]; 3], [f64; 3])>,
    /// δλ.
    changes: Vec<[f64; 3]>,
}

impl Newton {
    pub fn new(points: usize, bodies: usize) -> Self {
        let n = bodies.min(BODIES);
        Self {
            loaded: Vec::with_capacity(bodies),
            matrix: Vec::with_capacity(36 * n * n),
            right: Vec::with_capacity(6 * n),
            stiffness: Vec::with_capacity(bodies),
            push: Vec::with_capacity(bodies),
            laws: Vec::with_capacity(points),
            changes: Vec::with_capacity(points),
        }
    }

    /// Finds the step at the impulses; `false` where the system has no solution or is too large.
    pub fn step(
        &mut self,
        (contacts, response, friction): (&[Contact], &Response, f64),
        twists: &[Twist],
        impulses: &[[f64; 3]],
    ) -> bool {
        let n = response.bodies();
        self.laws.clear();
        self.stiffness.clear();
        self.stiffness.resize(n, [[0.0; 6]; 6]);
        self.push.clear();
        self.push.resize(n, [0.0; 6]);
        self.loaded.clear();
        for (c, impulse) in contacts.iter().zip(impulses) {
            let (a, g) = law(c, &c.velocity(&twists[c.slot]), impulse, friction);
            c.push(&g, &mut self.push[c.slot]);
            self.laws.push((a, g));
            if a[0][0] == 0.0 {
                continue;
            }
            if self.loaded.last() != Some(&c.slot) {
                self.loaded.push(c.slot);
            }
            let s = &mut self.stiffness[c.slot];
            for (i, row) in c.rows.iter().enumerate() {
                let mut mixed = [0.0; 6];
                for (x, r) in a[i].iter().zip(&c.rows) {
                    if *x != 0.0 {
                        for (m, r) in mixed.iter_mut().zip(r) {
                            *m += x * r;
                        }
                    }
                }
                for (s, r) in s.iter_mut().zip(row) {
                    for (s, m) in s.iter_mut().zip(&mixed) {
                        *s += r * m;
                    }
                }
            }
        }
        if self.loaded.len() > BODIES {
            return false;
        }
        let loaded = self.loaded.len();
        let size = 6 * loaded;
        self.matrix.clear();
        self.matrix.resize(size * size, 0.0);
        self.right.clear();
        self.right.resize(size, 0.0);
        for (i, &a) in self.loaded.iter().enumerate() {
            for (j, &b) in self.loaded.iter().enumerate() {
                let (g, s) = (&response.g[a * n + b], &self.stiffness[b]);
                for (column, s) in g.iter().zip(s) {
                    for (k, x) in column.iter().enumerate() {
                        let row = &mut self.matrix[(6 * i + k) * size + 6 * j..][..6];
                        for (m, s) in row.iter_mut().zip(s) {
                            *m += x * s;
                        }
                    }
                }
            }
            for (b, push) in self.push.iter().enumerate() {
                for (right, change) in self.right[6 * i..].iter_mut().zip(apply(&response.g[a * n + b], push))
                {
                    *right += change;
                }
            }
            for k in 0..6 {
                self.matrix[(6 * i + k) * (size + 1)] += 1.0;
            }
        }
        if !solve(&mut self.matrix, &mut self.right) {
            return false;
        }
        self.changes.clear();
        let mut at = 0;
        for (c, (a, g)) in contacts.iter().zip(&self.laws) {
            if a[0][0] == 0.0 {
                self.changes.push(*g);
                continue;
            }
            // contacts are in order of their bodies
            while self.loaded[at] != c.slot {
                at += 1;
            }
            let change = &self.right[6 * at..6 * at + 6];
            let du = c.rows.map(|row| row.iter().zip(change).map(|(r, x)| r * x).sum::<f64>());
            self.changes
                .push([0, 1, 2].map(|k| g[k] - (a[k][0] * du[0] + a[k][1] * du[1] + a[k][2] * du[2])));
        }
        true
    }

    /// Takes a part of the step found, and leaves the impulses inside the friction cones; `false` if that is the whole step already.
    pub fn apply(&self, part: Part, friction: f64, impulses: &mut [[f64; 3]]) -> bool {
        let mut length = if let Part::Fraction(x) = part { x } else { 1.0 };
        let mut opens = usize::MAX;
        if part == Part::ToFirstOpening {
            for (i, (l, d)) in impulses.iter().zip(&self.changes).enumerate() {
                // an open point does not count: it is not there to leave
                if l[0] > 0.0 && l[0] + length * d[0] < 0.0 {
                    length = -l[0] / d[0];
                    opens = i;
                }
            }
            if opens == usize::MAX {
                return false;
            }
        }
        for (i, (l, d)) in impulses.iter_mut().zip(&self.changes).enumerate() {
            for k in 0..3 {
                l[k] += length * d[k];
            }
            l[0] = if i == opens { 0.0 } else { l[0].max(0.0) };
            (l[1], l[2]) = disc(l[1], l[2], friction * l[0]);
        }
        true
    }
}

/// How much of a step is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Part {
    Whole,
    /// Until the first of the pressed points opens.
    ToFirstOpening,
    Fraction(f64),
}

/// A and g of one contact. See the module header.
fn law(c: &Contact, u: &[f64; 3], l: &[f64; 3], friction: f64) -> ([[f64; 3]; 3], [f64; 3]) {
    let mut a = [[0.0; 3]; 3];
    let u_n = u[0] + c.yielding * l[0];
    let normal = l[0] - c.mass * u_n;
    if normal <= 0.0 {
        return (a, [-l[0], -l[1], -l[2]]);
    }
    // δλ_n = −σ (u_n + δu_n + γ δλ_n)
    let stiff = STIFF * c.mass;
    let along = stiff / (1.0 + stiff * c.yielding);
    a[0][0] = along;
    let g_n = -along * u_n;
    let (x, y) = (l[1] - c.mass * u[1], l[2] - c.mass * u[2]);
    let length = x.hypot(y);
    let radius = friction * normal;
    if radius <= 0.0 {
        return (a, [g_n, -l[1], -l[2]]);
    }
    if length <= radius {
        a[1][1] = stiff;
        a[2][2] = stiff;
        return (a, [g_n, -stiff * u[1], -stiff * u[2]]);
    }
    // λ_t = μ λ_n d with d = (λ_t − ρ u_t)/|·|; across d it turns with the slip, c = μ λ_n/|·| < 1
    let d = [x / length, y / length];
    let ratio = (friction * l[0].max(0.0) / length).min(1.0 - 1e-9);
    let across = ratio * c.mass / (1.0 - ratio);
    let f = [l[1] - friction * l[0] * d[0], l[2] - friction * l[0] * d[1]];
    let f_along = f[0] * d[0] + f[1] * d[1];
    let mut g = [g_n, 0.0, 0.0];
    for i in 0..2 {
        g[1 + i] = friction * g_n * d[i] - f_along * d[i] - (f[i] - f_along * d[i]) / (1.0 - ratio);
        a[1 + i][0] = friction * along * d[i];
        for j in 0..2 {
            let identity = if i == j { 1.0 } else { 0.0 };
            a[1 + i][1 + j] = across * (identity - d[i] * d[j]);
        }
    }
    (a, g)
}

/// Solves `m x = b` in place by elimination with row pivots; `false` if m is singular.
fn solve(m: &mut [f64], b: &mut [f64]) -> bool {
    let n = b.len();
    for k in 0..n {
        let mut best = k;
        for i in k + 1..n {
            if m[i * n + k].abs() > m[best * n + k].abs() {
                best = i;
            }
        }
        let pivot = m[best * n + k];
        if !(pivot.abs() > 0.0 && pivot.is_finite()) {
            return false;
        }
        if best != k {
            let (upper, lower) = m.split_at_mut(best * n);
            upper[k * n + k..k * n + n].swap_with_slice(&mut lower[k..n]);
            b.swap(k, best);
        }
        let inverse = 1.0 / pivot;
        let (upper, lower) = m.split_at_mut((k + 1) * n);
        let row = &upper[k * n + k + 1..];
        for (i, below) in lower.chunks_exact_mut(n).enumerate() {
            let x = below[k] * inverse;
            if x != 0.0 {
                for (t, r) in below[k + 1..].iter_mut().zip(row) {
                    *t -= x * r;
                }
                b[k + 1 + i] -= x * b[k];
            }
        }
    }
    for k in (0..n).rev() {
        let row = &m[k * n..(k + 1) * n];
        let sum: f64 = row[k + 1..].iter().zip(&b[k + 1..]).map(|(a, x)| a * x).sum();
        b[k] = (b[k] - sum) / row[k];
    }
    b.iter().all(|x| x.is_finite())
}
