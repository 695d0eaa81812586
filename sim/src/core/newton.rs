//! Newton: the finish of a contact solution, in the twists of the touching bodies.
//!
//! In: contacts, impulses λ₀ near a solution. Out: better impulses. A step of the proximal point method: with ρ = σ times the apparent mass
//! of each point, find twists u with `u = u_free + G Σ Wᵀ λ(u)` and `λ(u) = Π(λ₀ − ρ W u)`, Π the projection on `λ_n ≥ 0` and on the
//! disc `|λ_t| ≤ μ λ_n`: Alart and Curnier's equations (Comput. Methods Appl. Mech. Eng. 92, 1991), which hold with λ₀ where λ₀ solves the
//! contacts. Their error falls by some 1/σ per step, and what redundant points share, which no equation fixes, stays near λ₀.
//!
//! The twists are found by Newton's method on a piecewise smooth equation, with six unknowns per loaded body however many points it touches
//! with: `(1 + G Σ Wᵀ A W) δu = u_free + G Σ Wᵀ λ(u) − u`, A = −∂λ/∂(W u), 3 × 3 for each point.

use super::contact::{Contact, apply, dot6};
use super::friction::{disc, length, residual};
use super::response::{Response, Twist};

/// More loaded bodies than this are left to the sweeps: the system is dense.
const BODIES: usize = 20;
/// Newton steps of a proximal step.
const STEPS: usize = 6;
/// Parts of a Newton step that are tried, in this order, until one helps.
const PARTS: [f64; 4] = [1.0, 0.3, 0.1, 0.02];
/// Error of the impulses at which a proximal step ends, over the tolerance of the solution.
const CONVERGED: f64 = 0.1;

/// The memory of a step.
#[derive(Clone, Debug)]
pub(super) struct Newton {
    /// Bodies with a point that is not open: only their twists matter.
    loaded: Vec<usize>,
    /// `6 n × 6 n` over loaded bodies, by rows.
    matrix: Vec<f64>,
    right: Vec<f64>,
    /// δu.
    change: Vec<Twist>,
    /// `Σ Wᵀ A W` of each body, by rows.
    stiffness: Vec<[Twist; 6]>,
    /// Σ Wᵀ λ(u) of each body.
    wrenches: Vec<Twist>,
    /// `u_free + G Σ Wᵀ λ(u)`.
    answer: Vec<Twist>,
    /// u under way, and where a step begins.
    twists: Vec<Twist>,
    from: Vec<Twist>,
    /// λ(u).
    impulses: Vec<[f64; 3]>,
    /// λ₀.
    start: Vec<[f64; 3]>,
}

impl Newton {
    pub fn new(points: usize, bodies: usize) -> Self {
        let n = bodies.min(BODIES);
        Self {
            loaded: Vec::with_capacity(bodies),
            matrix: Vec::with_capacity(36 * n * n),
            right: Vec::with_capacity(6 * n),
            change: Vec::with_capacity(bodies),
            stiffness: Vec::with_capacity(bodies),
            wrenches: Vec::with_capacity(bodies),
            answer: Vec::with_capacity(bodies),
            twists: Vec::with_capacity(bodies),
            from: Vec::with_capacity(bodies),
            impulses: Vec::with_capacity(points),
            start: Vec::with_capacity(points),
        }
    }

    /// Takes a proximal step from impulses and their twists; returns the Newton steps it took.
    pub fn step(
        &mut self,
        (contacts, response): (&[Contact], &Response),
        (sigma, tolerance): (f64, f64),
        twists: &[Twist],
        impulses: &mut [[f64; 3]],
    ) -> usize {
        self.start.clear();
        self.start.extend_from_slice(impulses);
        self.twists.clear();
        self.twists.extend_from_slice(twists);
        let problem = (contacts, response);
        let mut error = self.error(problem, sigma);
        let goal = CONVERGED * tolerance / sigma;
        for step in 0..STEPS {
            if error <= goal {
                return step;
            }
            if !self.direction(problem, sigma) {
                return step;
            }
            self.from.clone_from(&self.twists);
            let mut best = (f64::INFINITY, 0.0);
            for part in PARTS {
                self.move_by(part);
                let now = self.error(problem, sigma);
                if now < best.0 {
                    best = (now, part);
                }
                if now < error {
                    break;
                }
            }
            // where no part helps, the best of them leads to another set of points that stick, slide or are open
            if best.0 >= error {
                self.move_by(best.1);
                self.error(problem, sigma);
            }
            // so near the end of what the arithmetic resolves a step that does not gain much gains nothing
            let stalls = best.0 > 0.1 * error && error <= 100.0 * goal;
            error = best.0;
            impulses.copy_from_slice(&self.impulses);
            if stalls || residual(contacts, impulses, &self.answer) <= tolerance {
                return step + 1;
            }
        }
        STEPS
    }

    /// Evaluates λ(u), what it makes of the twists, and how far that is from u, times the apparent masses, N·s.
    fn error(&mut self, (contacts, response): (&[Contact], &Response), sigma: f64) -> f64 {
        let n = response.bodies();
        self.impulses.clear();
        self.wrenches.clear();
        self.wrenches.resize(n, [0.0; 6]);
        self.answer.resize(n, [0.0; 6]);
        for (c, l0) in contacts.iter().zip(&self.start) {
            let (l, _) = law(c, &c.velocity(&self.twists[c.slot]), l0, sigma);
            c.push(&l, &mut self.wrenches[c.slot]);
            self.impulses.push(l);
        }
        response.twists(&self.wrenches, &mut self.answer);
        let mut sum = 0.0;
        for c in contacts {
            let gap: Twist = std::array::from_fn(|k| self.answer[c.slot][k] - self.twists[c.slot][k]);
            for row in &c.rows {
                sum += (c.mass * dot6(row, &gap)).powi(2);
            }
        }
        sum.sqrt()
    }

    /// Solves for δu at u, into `right`; `false` where the system is too large or singular.
    fn direction(&mut self, (contacts, response): (&[Contact], &Response), sigma: f64) -> bool {
        let n = response.bodies();
        self.stiffness.clear();
        self.stiffness.resize(n, [[0.0; 6]; 6]);
        self.loaded.clear();
        for (c, l0) in contacts.iter().zip(&self.start) {
            let (_, a) = law(c, &c.velocity(&self.twists[c.slot]), l0, sigma);
            if a[0][0] == 0.0 {
                continue;
            }
            if self.loaded.last() != Some(&c.slot) {
                self.loaded.push(c.slot);
            }
            let s = &mut self.stiffness[c.slot];
            for (row, a) in c.rows.iter().zip(&a) {
                let mixed: Twist =
                    std::array::from_fn(|k| a[0] * c.rows[0][k] + a[1] * c.rows[1][k] + a[2] * c.rows[2][k]);
                for (s, r) in s.iter_mut().zip(row) {
                    for (s, m) in s.iter_mut().zip(&mixed) {
                        *s += r * m;
                    }
                }
            }
        }
        let loaded = self.loaded.len();
        if loaded > BODIES {
            return false;
        }
        let size = 6 * loaded;
        self.matrix.clear();
        self.matrix.resize(size * size, 0.0);
        self.right.clear();
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
            for k in 0..6 {
                self.matrix[(6 * i + k) * (size + 1)] += 1.0;
                self.right.push(self.answer[a][k] - self.twists[a][k]);
            }
        }
        if !solve(&mut self.matrix, &mut self.right) {
            return false;
        }
        // twists without load follow: δu = u_free + G Σ Wᵀ λ − u − G Σ Wᵀ A W δu
        self.change.clear();
        for (a, (answer, twist)) in self.answer.iter().zip(&self.twists).enumerate() {
            self.change.push(std::array::from_fn(|k| answer[k] - twist[k]));
            if let Ok(i) = self.loaded.binary_search(&a) {
                self.change[a].copy_from_slice(&self.right[6 * i..6 * i + 6]);
                continue;
            }
            for (i, &b) in self.loaded.iter().enumerate() {
                let du = &self.right[6 * i..6 * i + 6];
                let push: Twist =
                    std::array::from_fn(|k| (0..6).map(|j| self.stiffness[b][k][j] * du[j]).sum());
                for (x, y) in self.change[a].iter_mut().zip(apply(&response.g[a * n + b], &push)) {
                    *x -= y;
                }
            }
        }
        true
    }

    /// Twists a part of the step away from where it begins.
    fn move_by(&mut self, part: f64) {
        for ((twist, from), change) in self.twists.iter_mut().zip(&self.from).zip(&self.change) {
            *twist = std::array::from_fn(|k| from[k] + part * change[k]);
        }
    }
}

/// λ(u) and A of one contact. See the module header.
fn law(c: &Contact, u: &[f64; 3], l0: &[f64; 3], sigma: f64) -> ([f64; 3], [[f64; 3]; 3]) {
    let mut a = [[0.0; 3]; 3];
    let stiff = sigma * c.mass;
    // λ_n = λ₀ − ρ (u_n + γ λ_n)
    let along = stiff / (1.0 + stiff * c.yielding);
    let normal = (l0[0] - stiff * u[0]) / (1.0 + stiff * c.yielding);
    if normal <= 0.0 {
        return ([0.0; 3], a);
    }
    a[0][0] = along;
    let radius = c.friction * normal;
    if radius <= 0.0 {
        return ([normal, 0.0, 0.0], a);
    }
    let (x, y) = (l0[1] - stiff * u[1], l0[2] - stiff * u[2]);
    let long = length(x, y);
    if long <= radius {
        a[1][1] = stiff;
        a[2][2] = stiff;
        return ([normal, x, y], a);
    }
    // λ_t = μ λ_n d with d = (λ₀ − ρ u)/|·|: it follows the load, and across d it turns with the slip
    let d = [x / long, y / long];
    let across = stiff * radius / long;
    for i in 0..2 {
        a[1 + i][0] = c.friction * along * d[i];
        for j in 0..2 {
            let identity = if i == j { 1.0 } else { 0.0 };
            a[1 + i][1 + j] = across * (identity - d[i] * d[j]);
        }
    }
    let (t1, t2) = disc(x, y, radius);
    ([normal, t1, t2], a)
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
