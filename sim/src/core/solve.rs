//! Contact impulses: projected Gauss–Seidel sweeps and a Newton finish, to a residual that is measured.
//!
//! In: contacts, G and the twists without them ([`Response`]). Out: the impulses λ (N·s; normal and two
//! tangents) with `0 ≤ λ_n ⊥ u_n ≥ 0` and friction that opposes slip on the disc `|λ_t| ≤ μ λ_n`.
//!
//! What is solved is measured by the natural map of the cone problem (De Saxcé, Feng 1998): with ũ = u + μ |u_t| n and the projection
//! Π on the friction cone, `r = ‖λ − Π(λ − ρ ũ)‖` over all contacts, ρ the apparent mass of each point. It is zero at solutions and
//! nowhere else.
//!
//! Sweeps and Newton steps work on the twists and wrenches of the touching bodies, six numbers each, however many points a body touches
//! with: a sweep over a standing human costs 0.3 µs.

use super::contact::{Contact, dot6};
use super::friction::{disc, residual};
use super::newton::Newton;
use super::response::{Response, Twist};

/// Rounds of sweeps, each with a Newton finish.
const ROUNDS: usize = 16;

/// In so many rounds the residual has to halve.
const PATIENCE: usize = 4;

/// σ of the proximal steps of a finish, one after another: where the residual is over a thousandfold the tolerance, and where it is near.
const SIGMAS: [[f64; 5]; 2] = [[1e6, 1e4, 1e1, 1e2, 1e4], [1e4, 1e6, 1e1, 1e2, 1e4]];

/// What a solution cost and how good it is.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Solved {
    pub sweeps: usize,
    pub steps: usize,
    /// Residual, N·s.
    pub residual: f64,
}

/// Impulses under way. See the module header.
#[derive(Clone, Debug)]
pub(super) struct Solver {
    /// λ, one per contact: normal, two tangents.
    pub impulses: Vec<[f64; 3]>,
    /// Wrench of the impulses on each touching body.
    pub wrenches: Vec<Twist>,
    /// Twists with the impulses.
    pub twists: Vec<Twist>,
    /// Velocities of the points with the impulses.
    velocities: Vec<[f64; 3]>,
    newton: Newton,
}

impl Solver {
    pub fn new(points: usize, bodies: usize) -> Self {
        Self {
            impulses: Vec::with_capacity(points),
            wrenches: Vec::with_capacity(bodies),
            twists: Vec::with_capacity(bodies),
            velocities: Vec::with_capacity(points),
            newton: Newton::new(points, bodies),
        }
    }

    #[cfg(test)]
    pub fn spoil(&mut self) {
        for scratch in [&mut self.impulses, &mut self.velocities] {
            scratch.fill([f64::NAN; 3]);
        }
        self.wrenches.fill([f64::NAN; 6]);
        self.twists.fill([f64::NAN; 6]);
    }

    /// Solves from the impulses as they are to a residual of `tolerance` (N·s) if it can.
    pub fn solve(&mut self, contacts: &[Contact], response: &Response, tolerance: f64) -> Solved {
        let bodies = response.bodies();
        self.wrenches.resize(bodies, [0.0; 6]);
        self.twists.resize(bodies, [0.0; 6]);
        self.update(contacts, response);
        let mut effort = Solved { residual: self.residual(contacts), ..Solved::default() };
        // near a solution Newton's step lands on it; far away sweeps find out who touches, sticks and slides
        let mut sweeps = if effort.residual < 1e4 * tolerance { 0 } else { 3 };
        let mut before = f64::INFINITY;
        for round in 0..ROUNDS {
            if effort.residual <= tolerance {
                break;
            }
            if round % PATIENCE == 0 {
                if effort.residual > 0.5 * before {
                    break;
                }
                before = effort.residual;
            }
            for _ in 0..sweeps {
                self.sweep(contacts, response);
            }
            effort.sweeps += sweeps;
            if sweeps > 0 {
                self.update(contacts, response);
                effort.residual = self.residual(contacts);
            }
            self.finish(contacts, response, tolerance, &mut effort);
            sweeps = (2 * sweeps).clamp(4, 32);
        }
        effort
    }

    /// Newton steps from the impulses as they are; keeps the best seen. Where a whole step does not help, it is taken as far as the
    /// first pressed point opens: redundant points that cannot all touch leave one by one. Such steps may raise the residual on the way.
    fn finish(&mut self, contacts: &[Contact], response: &Response, tolerance: f64, effort: &mut Solved) {
        let [far, near] = SIGMAS;
        for sigma in if effort.residual > 1e3 * tolerance { far } else { near } {
            if effort.residual <= tolerance {
                break;
            }
            let problem = (contacts, response);
            let (steps, residual) =
                self.newton.step(problem, (sigma, tolerance), &self.twists, &self.impulses);
            effort.steps += steps;
            if let Some(residual) = residual.filter(|r| *r < effort.residual) {
                effort.residual = residual;
                // its last evaluation is of these impulses
                std::mem::swap(&mut self.impulses, &mut self.newton.impulses);
                std::mem::swap(&mut self.wrenches, &mut self.newton.wrenches);
                std::mem::swap(&mut self.twists, &mut self.newton.twists);
            }
        }
    }

    /// Wrenches and twists of the impulses, anew.
    fn update(&mut self, contacts: &[Contact], response: &Response) {
        self.wrenches.fill([0.0; 6]);
        for (c, impulse) in contacts.iter().zip(&self.impulses) {
            c.push(impulse, &mut self.wrenches[c.slot]);
        }
        response.twists(&self.wrenches, &mut self.twists);
    }

    /// One Gauss–Seidel sweep: every contact solves its own law, the others held; the normal first, then friction.
    fn sweep(&mut self, contacts: &[Contact], response: &Response) {
        let n = response.bodies();
        for (c, impulse) in contacts.iter().zip(&mut self.impulses) {
            let old = *impulse;
            let u = c.velocity(&self.twists[c.slot]);
            let normal = (old[0] - c.mass_n * (u[0] + c.yielding * old[0])).max(0.0);
            let change = normal - old[0];
            let own = &response.g[c.slot * n + c.slot];
            let (mut u1, mut u2) = (u[1], u[2]);
            if change != 0.0 {
                for (row, column) in c.rows[0].iter().zip(own) {
                    u1 += change * row * dot6(&c.rows[1], column);
                    u2 += change * row * dot6(&c.rows[2], column);
                }
            }
            let [m11, m12, m22] = c.mass_t;
            let radius = c.friction * normal;
            let (mut t1, mut t2) = (old[1] - (m11 * u1 + m12 * u2), old[2] - (m12 * u1 + m22 * u2));
            if t1 * t1 + t2 * t2 > radius * radius {
                // it slides, against its slip: of steps that do not solve the block exactly only those along u_t end where it does
                (t1, t2) = disc(old[1] - c.slow * u1, old[2] - c.slow * u2, radius);
            }
            *impulse = [normal, t1, t2];
            let by = [change, t1 - old[1], t2 - old[2]];
            if by == [0.0; 3] {
                continue;
            }
            let mut wrench = [0.0; 6];
            c.push(&by, &mut wrench);
            for (a, twist) in self.twists.iter_mut().enumerate() {
                for (column, w) in response.g[a * n + c.slot].iter().zip(&wrench) {
                    for (t, g) in twist.iter_mut().zip(column) {
                        *t += g * w;
                    }
                }
            }
        }
    }

    fn residual(&mut self, contacts: &[Contact]) -> f64 {
        self.velocities.clear();
        self.velocities.extend(contacts.iter().map(|c| c.velocity(&self.twists[c.slot])));
        residual(contacts, &self.impulses, &self.velocities)
    }
}
