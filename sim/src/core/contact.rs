//! Contacts: the points that touch the ground in a substep, and what is asked of each.
//!
//! In: poses, the ground and how it turns, the forces of the last substep. Out: a [`Contact`] per point near the ground, with
//! its rows in the twist of its body.
//!
//! A point at depth d (m, positive inside) has normal velocity u_n and impulse λ_n with `0 ≤ λ_n ⊥ u_n + b + γ λ_n ≥ 0`:
//!
//! | law | b | γ |
//! |---|---|---|
//! | stiff, apart | −d/dt: it may come as near as the ground | 0 |
//! | stiff, inside | −min(β (d − slop)/dt, [`PUSH_OUT`]) | 0 |
//! | spring k, damper c | −d k/(c + dt k) | 1/(dt (c + dt k)) |
//!
//! The last is an implicit spring and damper, `λ_n = dt (k (d − dt u_n) − c u_n)`. Friction is Coulomb's on the disc, `|λ_t| ≤ μ λ_n`.

use dynamics::State;
use motion::{Floor, Vec3};

use super::shapes::{Group, Point};

/// Points nearer to the ground than this take part, m.
const MARGIN: f64 = 0.02;
/// Depth that is left alone, m: a point at rest stays in touch.
const SLOP: f64 = 2e-5;
/// Fraction of the depth that is taken back per substep.
const BETA: f64 = 0.2;
/// Fastest push out of the ground, m/s.
const PUSH_OUT: f64 = 2.0;

/// How the normal direction yields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Yield {
    /// Not at all.
    Stiff,
    /// A spring and a damper at each point, of fixed numbers: N/m, N·s/m.
    Compliant { stiffness: f64, damping: f64 },
    /// A spring and a damper per apparent mass: ω (rad/s), ζ.
    Frequency { omega: f64, zeta: f64 },
}

/// A point that touches or may touch within the substep.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Contact {
    /// Index of the point.
    pub point: usize,
    /// Its body, as an index into the touching bodies.
    pub slot: usize,
    /// Rows from the body's twist (velocity of its origin, angular velocity; world) to normal and two tangents.
    pub rows: [[f64; 6]; 3],
    /// Velocity of the ground along the same, m/s; in the normal entry less b.
    pub ground: [f64; 3],
    /// Velocity at which a stiff point is pushed out of the ground, m/s.
    pub out: f64,
    /// γ, m/s per N·s.
    pub yielding: f64,
    /// 1/(W_nn + γ), kg.
    pub mass_n: f64,
    /// Inverse of the tangential block of W: 11, 12, 22, kg.
    pub mass_t: [f64; 3],
    /// Least eigenvalue of that inverse, kg.
    pub slow: f64,
    /// Apparent mass over all directions, 3/trace W, kg.
    pub mass: f64,
    /// Depth, m.
    pub depth: f64,
    /// Where, world, m.
    pub at: Vec3,
}

/// The ground in a substep.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ground {
    /// As it lies at the start of the substep.
    pub floor: Floor,
    /// Its angular velocity, rad/s.
    pub rate: Vec3,
    /// Normal and two tangents.
    pub axes: [Vec3; 3],
}

impl Ground {
    pub fn new(floor: Floor, rate: Vec3) -> Self {
        let up = floor.up;
        // tangents turn with the normal as little as possible: along the images of the level axes
        let turn = floor.turn();
        Self { floor, rate, axes: [up, turn * Vec3::x(), turn * Vec3::z()] }
    }

    /// An impulse along its axes, world.
    pub fn world(&self, impulse: &[f64; 3]) -> Vec3 {
        self.axes[0] * impulse[0] + self.axes[1] * impulse[1] + self.axes[2] * impulse[2]
    }
}

/// Finds the contacts of a substep; forces of points that are not among them are forgotten.
pub(super) fn find(
    (points, groups): (&[Point], &[Group]),
    state: &State,
    ground: &Ground,
    (dt, yields): (f64, Yield),
    forces: &mut [[f64; 3]],
    (contacts, touching): (&mut Vec<Contact>, &mut Vec<usize>),
) {
    contacts.clear();
    touching.clear();
    let (up, pivot) = (ground.floor.up, ground.floor.pivot());
    // a spring acts where it is pressed, not before
    let margin = if yields == Yield::Stiff { MARGIN } else { 0.0 };
    for group in groups {
        let s = &state.bodies[group.body];
        let height = (s.origin() - pivot).dot(&up);
        if height > group.reach + margin {
            forces[group.from..group.to].fill([0.0; 3]);
            continue;
        }
        let slot = touching.len();
        let found = contacts.len();
        for point in group.from..group.to {
            let p = &points[point];
            let arm = s.rotation * p.at - up * p.radius;
            let depth = -(height + arm.dot(&up));
            if depth < -margin {
                forces[point] = [0.0; 3];
                continue;
            }
            let at = s.origin() + arm;
            let moving = ground.rate.cross(&(at - pivot));
            let mut c = Contact { point, slot, depth, at, ..Contact::default() };
            for (k, axis) in ground.axes.iter().enumerate() {
                let m = arm.cross(axis);
                c.rows[k] = [axis.x, axis.y, axis.z, m.x, m.y, m.z];
                c.ground[k] = moving.dot(axis);
            }
            if yields == Yield::Stiff {
                let inside = BETA * (depth - SLOP).max(0.0) / dt;
                c.out = inside.min(PUSH_OUT);
                c.ground[0] += if depth > 0.0 { c.out } else { depth / dt };
            }
            contacts.push(c);
        }
        if contacts.len() > found {
            touching.push(group.body);
        }
    }
}

impl Contact {
    /// What depends on how the body answers to impulses: apparent masses, b and γ of springs.
    ///
    /// * `response`: twist of the body per unit wrench on it
    pub fn weigh(&mut self, response: &[[f64; 6]; 6], dt: f64, yields: Yield) {
        let w: [[f64; 6]; 3] = self.rows.map(|row| apply(response, &row));
        let entry = |i: usize, j: usize| dot6(&self.rows[i], &w[j]);
        let nn = entry(0, 0);
        let (a, b, d) = (entry(1, 1), entry(1, 2), entry(2, 2));
        let spring = match yields {
            Yield::Stiff => None,
            Yield::Compliant { stiffness, damping } => Some((stiffness, damping)),
            Yield::Frequency { omega, zeta } => Some((omega * omega / nn, 2.0 * zeta * omega / nn)),
        };
        self.yielding = 0.0;
        if let Some((k, c)) = spring {
            let sum = c + dt * k;
            self.yielding = 1.0 / (dt * sum);
            self.ground[0] += self.depth * k / sum;
        }
        // a direction that nothing can move keeps the inverse finite
        let least = 1e-12 * (nn + a + d) + 1e-300;
        self.mass_n = 1.0 / (nn + self.yielding + least);
        let (a, d) = (a + least, d + least);
        let det = a * d - b * b;
        self.mass_t = [d / det, -b / det, a / det];
        self.slow = 2.0 / (a + d + ((a - d) * (a - d) + 4.0 * b * b).sqrt());
        self.mass = 3.0 / (nn + a + d);
    }

    /// Velocity of the point against the ground, b included, for the twist of its body, m/s.
    #[inline(always)]
    pub fn velocity(&self, twist: &[f64; 6]) -> [f64; 3] {
        let [n, t1, t2] = &self.rows;
        let [gn, g1, g2] = &self.ground;
        [dot6(n, twist) - gn, dot6(t1, twist) - g1, dot6(t2, twist) - g2]
    }

    /// Adds an impulse at the point to the wrench on its body.
    #[inline(always)]
    pub fn push(&self, impulse: &[f64; 3], wrench: &mut [f64; 6]) {
        for (row, x) in self.rows.iter().zip(impulse) {
            for (w, r) in wrench.iter_mut().zip(row) {
                *w += x * r;
            }
        }
    }
}

#[inline(always)]
pub(super) fn dot6(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    // two chains of additions that do not wait for each other
    (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) + (a[3] * b[3] + a[4] * b[4] + a[5] * b[5])
}

/// Matrix (by columns) times vector.
#[inline(always)]
pub(super) fn apply(m: &[[f64; 6]; 6], x: &[f64; 6]) -> [f64; 6] {
    let mut out = [0.0; 6];
    for (column, x) in m.iter().zip(x) {
        for (o, c) in out.iter_mut().zip(column) {
            *o += c * x;
        }
    }
    out
}
