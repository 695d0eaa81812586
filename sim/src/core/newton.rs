//! Newton: the finish of a contact solution, in the twists of the touching bodies.
//!
//! In: contacts, impulses λ₀ near a solution. Out: better impulses. A step of the proximal point method: with ρ = σ times the apparent mass
//! of each point, find twists u with `u = u_free + G Σ Wᵀ λ(u)` and `λ(u) = Π(λ₀ − ρ W u)`, Π the projection on `λ_n ≥ 0` and on the
//! disc `|λ_t| ≤ μ λ_n`: Alart and Curnier's equations (Comput. Methods Appl. Mech. Eng. 92, 1991), which hold with λ₀ where λ₀ solves the
//! contacts. Their error falls by some 1/σ per step, and what redundant points share, which no equation fixes, stays near λ₀.
//!
//! The twists are found by Newton's method on a piecewise smooth equation, with six unknowns per loaded body however many points it touches
//! with: `(1 + G Σ Wᵀ A W) δu = u_free + G Σ Wᵀ λ(u) − u`, A = −∂λ/∂(W u), 3 × 3 for each point.

use super::contact::{Contact, apply};
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

/// What a point is asked at u.
#[derive(Clone, Copy, Debug, Default)]
struct Asked {
    /// W u.
    velocity: [f64; 3],
    /// A.
    slope: [[f64; 3]; 3],
}

/// Part of the disc of friction within which a point sticks.
const INSIDE: f64 = 1.0 - 1e-6;

/// The memory of a step, and what it leaves: impulses, their wrenches and twists.
#[derive(Clone, Debug)]
pub(super) struct Newton {
    /// λ(u).
    pub impulses: Vec<[f64; 3]>,
    /// Σ Wᵀ λ(u) of each body.
    pub wrenches: Vec<Twist>,
    /// `u_free + G Σ Wᵀ λ(u)`.
    pub twists: Vec<Twist>,
    /// Bodies with a point that is not open: only their twists matter.
    loaded: Vec<usize>,
    /// `6 n × 6 n` over loaded bodies, by rows of n sixes.
    matrix: Vec<Twist>,
    right: Vec<f64>,
    /// δu.
    change: Vec<Twist>,
    /// `Σ Wᵀ A W` of each body, by rows.
    stiffness: Vec<[Twist; 6]>,
    /// u under way, and where a step begins.
    tried: Vec<Twist>,
    from: Vec<Twist>,
    /// Of each point at u.
    asked: Vec<Asked>,
    /// `W twists` of each point: its velocity under λ(u).
    answers: Vec<[f64; 3]>,
    /// λ₀.
    start: Vec<[f64; 3]>,
}

impl Newton {
    pub fn new(points: usize, bodies: usize) -> Self {
        let n = bodies.min(BODIES);
        Self {
            impulses: Vec::with_capacity(points),
            wrenches: Vec::with_capacity(bodies),
            twists: Vec::with_capacity(bodies),
            loaded: Vec::with_capacity(bodies),
            matrix: Vec::with_capacity(6 * n * n),
            right: Vec::with_capacity(6 * n),
            change: Vec::with_capacity(bodies),
            stiffness: Vec::with_capacity(bodies),
            tried: Vec::with_capacity(bodies),
            from: Vec::with_capacity(bodies),
            asked: Vec::with_capacity(points),
            answers: Vec::with_capacity(points),
            start: Vec::with_capacity(points),
        }
    }

    /// Takes a proximal step from impulses and their twists; returns the Newton steps it took and, where it took any, the natural
    /// map's residual of the impulses that it leaves, N·s.
    pub fn step(
        &mut self,
        (contacts, response): (&[Contact], &Response),
        (sigma, tolerance): (f64, f64),
        twists: &[Twist],
        impulses: &[[f64; 3]],
    ) -> (usize, Option<f64>) {
        self.start.clear();
        self.start.extend_from_slice(impulses);
        self.tried.clear();
        self.tried.extend_from_slice(twists);
        let problem = (contacts, response);
        let goal = CONVERGED * tolerance / sigma;
        self.begin(problem, sigma);
        if !self.direction(problem) {
            return (0, None);
        }
        self.from.clone_from(&self.tried);
        self.move_by(1.0);
        let mut error = self.error(problem, sigma);
        let residual_now = residual(contacts, &self.impulses, &self.answers);
        let mut left = Some(residual_now);
        if residual_now <= tolerance {
            return (1, left);
        }
        for step in 1..STEPS {
            if error <= goal || !self.direction(problem) {
                return (step, left);
            }
            self.from.clone_from(&self.tried);
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
            let residual = residual(contacts, &self.impulses, &self.answers);
            left = Some(residual);
            if stalls || residual <= tolerance {
                return (step + 1, left);
            }
        }
        (STEPS, left)
    }

    /// Takes λ(u) as if nothing changed: points that stick do, those that slide slide on, each linear about where that is so.
    fn begin(&mut self, (contacts, response): (&[Contact], &Response), sigma: f64) {
        let n = response.bodies();
        self.asked.clear();
        self.wrenches.clear();
        self.wrenches.resize(n, [0.0; 6]);
        self.twists.resize(n, [0.0; 6]);
        for (c, l0) in contacts.iter().zip(&self.start) {
            let velocity = c.velocity(&self.tried[c.slot]);
            let about = if l0[0] <= 0.0 {
                velocity
            } else if length(l0[1], l0[2]) < INSIDE * c.friction * l0[0] {
                [0.0; 3]
            } else {
                [0.0, velocity[1], velocity[2]]
            };
            let (mut l, slope) = law(c, &about, l0, sigma);
            for (l, a) in l.iter_mut().zip(&slope) {
                *l -= (0..3).map(|k| a[k] * (velocity[k] - about[k])).sum::<f64>();
            }
            c.push(&l, &mut self.wrenches[c.slot]);
            self.asked.push(Asked { velocity, slope });
        }
        response.twists(&self.wrenches, &mut self.twists);
    }

    /// Evaluates λ(u), what it makes of the twists, and how far that is from u, times the apparent masses, N·s.
    fn error(&mut self, (contacts, response): (&[Contact], &Response), sigma: f64) -> f64 {
        let n = response.bodies();
        self.impulses.clear();
        self.asked.clear();
        self.answers.clear();
        self.wrenches.clear();
        self.wrenches.resize(n, [0.0; 6]);
        self.twists.resize(n, [0.0; 6]);
        for (c, l0) in contacts.iter().zip(&self.start) {
            let velocity = c.velocity(&self.tried[c.slot]);
            let (l, slope) = law(c, &velocity, l0, sigma);
            c.push(&l, &mut self.wrenches[c.slot]);
            self.impulses.push(l);
            self.asked.push(Asked { velocity, slope });
        }
        response.twists(&self.wrenches, &mut self.twists);
        let mut sum = 0.0;
        for (c, asked) in contacts.iter().zip(&self.asked) {
            let answer = c.velocity(&self.twists[c.slot]);
            let gap = |k: usize| c.mass * (answer[k] - asked.velocity[k]);
            let (x, y, z) = (gap(0), gap(1), gap(2));
            sum += x * x + y * y + z * z;
            self.answers.push(answer);
        }
        sum.sqrt()
    }

    /// Solves for δu at u as last evaluated; `false` where the system is too large or singular.
    fn direction(&mut self, (contacts, response): (&[Contact], &Response)) -> bool {
        let n = response.bodies();
        self.stiffness.clear();
        self.stiffness.resize(n, [[0.0; 6]; 6]);
        self.loaded.clear();
        for (c, Asked { slope: a, .. }) in contacts.iter().zip(&self.asked) {
            if a[0][0] == 0.0 {
                continue;
            }
            if self.loaded.last() != Some(&c.slot) {
                self.loaded.push(c.slot);
            }
            let [n, t1, t2] = &c.rows;
            let mixed = |a: &[f64; 3]| -> Twist {
                std::array::from_fn(|k| a[0] * n[k] + a[1] * t1[k] + a[2] * t2[k])
            };
            // the normal impulse depends on the normal velocity alone
            let (x, y, z) = (n.map(|n| a[0][0] * n), mixed(&a[1]), mixed(&a[2]));
            for (r, row) in self.stiffness[c.slot].iter_mut().enumerate() {
                for k in 0..6 {
                    row[k] += n[r] * x[k] + t1[r] * y[k] + t2[r] * z[k];
                }
            }
        }
        let loaded = self.loaded.len();
        if loaded > BODIES {
            return false;
        }
        self.matrix.clear();
        self.right.clear();
        for &a in &self.loaded {
            for k in 0..6 {
                for &b in &self.loaded {
                    let (g, s) = (&response.g[a * n + b], &self.stiffness[b]);
                    let mut row = [0.0; 6];
                    row[k] = if a == b { 1.0 } else { 0.0 };
                    for (column, s) in g.iter().zip(s) {
                        for (m, s) in row.iter_mut().zip(s) {
                            *m += column[k] * s;
                        }
                    }
                    self.matrix.push(row);
                }
                self.right.push(self.twists[a][k] - self.tried[a][k]);
            }
        }
        if !solve(&mut self.matrix, &mut self.right) {
            return false;
        }
        // twists without load follow: δu = u_free + G Σ Wᵀ λ − u − G Σ Wᵀ A W δu
        self.change.clear();
        for (a, (answer, twist)) in self.twists.iter().zip(&self.tried).enumerate() {
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
        for ((twist, from), change) in self.tried.iter_mut().zip(&self.from).zip(&self.change) {
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

/// Solves `m x = b` in place by elimination with row pivots, m by rows of sixes; `false` if m is singular.
fn solve(m: &mut [Twist], b: &mut [f64]) -> bool {
    let n = b.len();
    let sixes = n / 6;
    for k in 0..n {
        // what lies left of the six that holds the pivot is zero
        let (first, lane) = (k / 6, k % 6);
        let (mut best, mut most) = (k, 0.0);
        for i in k..n {
            let size = m[i * sixes + first][lane].abs();
            if size > most {
                (best, most) = (i, size);
            }
        }
        if !(most > 0.0 && most.is_finite()) {
            return false;
        }
        let (upper, lower) = m.split_at_mut((k + 1) * sixes);
        let row = &mut upper[k * sixes + first..];
        if best != k {
            row.swap_with_slice(&mut lower[(best - k - 1) * sixes + first..(best - k) * sixes]);
            b.swap(k, best);
        }
        let inverse = 1.0 / row[0][lane];
        let own = b[k];
        for (below, b) in lower.chunks_exact_mut(sixes).zip(&mut b[k + 1..]) {
            let x = below[first][lane] * inverse;
            if x != 0.0 {
                for (below, row) in below[first..].iter_mut().zip(&*row) {
                    for (t, r) in below.iter_mut().zip(row) {
                        *t -= x * r;
                    }
                }
                *b -= x * own;
            }
        }
    }
    for k in (0..n).rev() {
        let (first, lane) = (k / 6, k % 6);
        let row = &m[k * sixes..(k + 1) * sixes];
        let mut sum: f64 = (lane + 1..6).map(|j| row[first][j] * b[6 * first + j]).sum();
        for (row, x) in row[first + 1..].iter().zip(b[6 * (first + 1)..].chunks_exact(6)) {
            sum += (row[0] * x[0] + row[1] * x[1] + row[2] * x[2])
                + (row[3] * x[3] + row[4] * x[4] + row[5] * x[5]);
        }
        b[k] = (b[k] - sum) / row[first][lane];
    }
    b.iter().all(|x| x.is_finite())
}
