//! Coulomb's friction on the disc: projections, and how far impulses are from its law.
//!
//! In: impulses and relative velocities at contacts. Out: numbers. Units: N·s, m/s.

use super::contact::Contact;

/// The natural map's residual of impulses and the velocities they make, N·s.
pub(super) fn residual(contacts: &[Contact], impulses: &[[f64; 3]], velocities: &[[f64; 3]]) -> f64 {
    let mut sum = 0.0;
    for ((c, l), u) in contacts.iter().zip(impulses).zip(velocities) {
        let slip = length(u[1], u[2]);
        let u_n = u[0] + c.yielding * l[0] + c.friction * slip;
        let onto = cone([l[0] - c.mass * u_n, l[1] - c.mass * u[1], l[2] - c.mass * u[2]], c.friction);
        sum += (0..3).map(|k| (l[k] - onto[k]) * (l[k] - onto[k])).sum::<f64>();
    }
    sum.sqrt()
}

/// √(x² + y²) of numbers far from the ends of their range.
#[inline(always)]
pub(super) fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// Projection on a disc.
#[inline(always)]
pub(super) fn disc(x: f64, y: f64, radius: f64) -> (f64, f64) {
    let square = x * x + y * y;
    if square <= radius * radius {
        return (x, y);
    }
    let scale = radius / square.sqrt();
    (x * scale, y * scale)
}

/// Projection on the friction cone `|x_t| ≤ μ x_n`.
pub(super) fn cone(x: [f64; 3], friction: f64) -> [f64; 3] {
    let t = length(x[1], x[2]);
    if t <= friction * x[0] {
        return x;
    }
    if friction * t <= -x[0] {
        return [0.0; 3];
    }
    let n = (x[0] + friction * t) / (1.0 + friction * friction);
    let scale = friction * n / t;
    [n, x[1] * scale, x[2] * scale]
}
