//! Contacts: what is asked of a point that touches.
//!
//! In: where a point touches, how deep, against what. Out: a [`Contact`] with its rows in the twist of its slot: of its body, or of its body
//! against another one.
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

use motion::{Floor, Vec3};

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
    /// What moves it, as an index into the slots.
    pub slot: usize,
    /// Coulomb's coefficient.
    pub friction: f64,
    /// Whether both sides are of the body: its impulse is no outside impulse.
    pub inner: bool,
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
}

/// Normal and two tangents that turn with it as little as possible.
pub(super) fn axes(normal: Vec3) -> [Vec3; 3] {
    let turn = motion::rotation::between(&Vec3::y(), &normal);
    [normal, turn * Vec3::x(), turn * Vec3::z()]
}

impl Contact {
    /// A point at depth `depth` (m) at `at` on a body whose origin is `arm` behind it, both world, m.
    ///
    /// * `moving`: velocity of what it touches, m/s
    pub fn new(
        (point, slot): (usize, usize),
        (at, arm, depth): (Vec3, Vec3, f64),
        axes: &[Vec3; 3],
        moving: &Vec3,
        friction: f64,
        (dt, yields): (f64, Yield),
    ) -> Self {
        let mut c = Self { point, slot, depth, at, friction, ..Self::default() };
        for (k, axis) in axes.iter().enumerate() {
            let m = arm.cross(axis);
            c.rows[k] = [axis.x, axis.y, axis.z, m.x, m.y, m.z];
            c.ground[k] = moving.dot(axis);
        }
        if yields == Yield::Stiff {
            let inside = BETA * (depth - SLOP).max(0.0) / dt;
            c.out = inside.min(PUSH_OUT);
            c.ground[0] += if depth > 0.0 { c.out } else { depth / dt };
        }
        c
    }

    /// An impulse along its axes, world.
    pub fn world(&self, impulse: &[f64; 3]) -> Vec3 {
        let axis = |k: usize| Vec3::new(self.rows[k][0], self.rows[k][1], self.rows[k][2]);
        axis(0) * impulse[0] + axis(1) * impulse[1] + axis(2) * impulse[2]
    }

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
