//! The physical limit of a push, and directions.
//!
//! In: a support polygon, a mass, a natural frequency. Out: the impulse beyond which a body that only moves its
//! centre of pressure cannot stay.
//!
//! An inverted pendulum of height h and natural frequency ω₀ = √(g/h), at rest at the distance d from
//! the support's edge, whose centre of pressure jumps to the edge when the push begins. The capture point
//! ξ = c + ċ/ω₀ follows ξ̇ = ω₀(ξ − d) + F/(m ω₀); it is still at the edge when the push ends if
//!
//! ```text
//! J = F T = m ω₀ d · x / (1 − e^{−x}),   x = ω₀ T
//! ```
//!
//! (T. Koolen et al. Capturability-based analysis and control of legged locomotion, part 1. IJRR 31, 2012.) Only
//! moving the trunk or the arms, or stepping, can do more.

use motion::support::{Support, Vec2};

/// The limit of the module header, N·s: mass (kg), natural frequency ω₀ (rad/s), distance to the edge (m), length
/// of the push (s).
pub fn limit_ns(mass: f64, omega: f64, edge_m: f64, push_s: f64) -> f64 {
    let x = omega * push_s;
    let shape = if x > 0.0 { x / -(-x).exp_m1() } else { 1.0 };
    mass * omega * edge_m * shape
}

/// Distance from `p` to the edge of the support along `way` (a unit vector), m; `None` where `p` is outside.
pub fn to_edge(support: &Support, p: &Vec2, way: &Vec2) -> Option<f64> {
    if !support.contains(p) {
        return None;
    }
    let c = support.corners();
    let edges = (0..c.len()).map(|i| (c[i], c[(i + 1) % c.len()]));
    edges
        .filter_map(|(a, b)| {
            // the edge's line is left where its inside ends: n outward, n·(p + s·way − a) = 0
            let along = b - a;
            let n = Vec2::new(along.y, -along.x);
            let speed = n.dot(way);
            (speed > 0.0).then(|| n.dot(&(a - p)) / speed)
        })
        .min_by(f64::total_cmp)
}

#[cfg(test)]
mod tests {
    use super::*;
    use motion::Vec3;
    use motion::support::ground;
    use scenes::angle::direction;

    /// Whether an inverted pendulum at rest that puts its pressure on the edge at once is caught, integrated by
    /// RK4 to 4 s after the push.
    fn caught(mass: f64, omega: f64, edge: f64, push_s: f64, impulse: f64) -> bool {
        let steps = 2000;
        let (mut c, mut v) = (0.0, 0.0);
        let (pushed, after) = (impulse / push_s / mass, 0.0);
        for (push, length) in [(pushed, push_s), (after, 4.0)] {
            let dt = length / f64::from(steps);
            let a = |c: f64| omega * omega * (c - edge) + push;
            for _ in 0..steps {
                let (k1, l1) = (v, a(c));
                let (k2, l2) = (v + 0.5 * dt * l1, a(c + 0.5 * dt * k1));
                let (k3, l3) = (v + 0.5 * dt * l2, a(c + 0.5 * dt * k2));
                let (k4, l4) = (v + dt * l3, a(c + dt * k3));
                c += dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
                v += dt / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
            }
        }
        c < edge
    }

    /// Two roads to one number: the formula, and bisection over an integrated pendulum.
    #[test]
    fn the_limit_is_that_of_an_integrated_pendulum() {
        for (mass, height, edge, push_s) in
            [(75.0, 0.95, 0.12, 0.1), (30.0, 0.5, 0.05, 0.4), (120.0, 1.3, 0.2, 0.02)]
        {
            let omega = (9.81_f64 / height).sqrt();
            let (mut lo, mut hi) = (0.0, 10.0 * mass * omega * edge);
            for _ in 0..50 {
                let mid = 0.5 * (lo + hi);
                if caught(mass, omega, edge, push_s, mid) { lo = mid } else { hi = mid }
            }
            let error = limit_ns(mass, omega, edge, push_s) / lo - 1.0;
            assert!(error.abs() < 1e-6, "{error}"); // 5e-10 seen
        }
        // an impulse without duration: the classical m ω₀ d
        assert_eq!(limit_ns(70.0, 3.0, 0.1, 0.0), 21.0);
    }

    /// The point found lies on the boundary, and nothing before it does.
    #[test]
    fn the_edge_is_where_the_support_ends() {
        let corners = [(0.1, -0.05), (0.18, -0.06), (0.2, 0.2), (-0.2, 0.2), (-0.16, -0.07)];
        let support = Support::of_plane(corners.map(|(x, z)| Vec2::new(x, z)).to_vec());
        let p = Vec2::new(0.02, 0.05);
        for i in 0..32 {
            let way = ground(&direction(11.25 * f64::from(i)));
            let d = to_edge(&support, &p, &way).unwrap();
            assert!(support.margin(&(p + way * d)).abs() < 1e-12, "{i}");
            assert!(d > 0.0 && support.contains(&(p + way * (d - 1e-9))), "{i}");
        }
        assert_eq!(to_edge(&support, &Vec2::new(0.3, 0.0), &Vec2::new(1.0, 0.0)), None);
    }

    #[test]
    fn directions_turn_to_the_left() {
        for (deg, v) in [(0.0, Vec3::z()), (90.0, Vec3::x()), (180.0, -Vec3::z()), (270.0, -Vec3::x())] {
            assert!((direction(deg) - v).norm() < 1e-15, "{deg}");
        }
    }
}
