//! Rotations: logarithm and exponential, swing and twist, Euler angles in any order.
//!
//! In and out: unit quaternions, rotation vectors (axis × angle, rad), Euler angles (rad).
//! `R = exp(r)` turns by `|r|` about `r`; products read right to left, as matrices do.

use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};

/// A 3-vector: a position, direction or rotation vector.
pub type Vec3 = Vector3<f64>;
/// A unit quaternion.
pub type Quat = UnitQuaternion<f64>;

/// Rotation vector of `q`, rad, with length at most π.
///
/// Accurate to rounding near the identity, where `acos`-based forms lose half the digits.
pub fn log(q: &Quat) -> Vec3 {
    let v = q.imag();
    let (s, w) = (v.norm(), q.w);
    let (s_signed, w_abs) = if w < 0.0 { (-1.0, -w) } else { (1.0, w) };
    // angle / sin(angle/2) → 2 as the angle → 0
    let scale = if s > 1e-9 { 2.0 * s.atan2(w_abs) / s } else { 2.0 / w_abs };
    v * (scale * s_signed)
}

/// Quaternion that turns by `|r|` rad about `r`.
pub fn exp(r: &Vec3) -> Quat {
    let angle = r.norm();
    // sin(angle/2)/angle, by series where the quotient would lose digits
    let k = if angle > 1e-4 { (0.5 * angle).sin() / angle } else { 0.5 - angle * angle / 48.0 };
    let v = r * k;
    Quat::new_normalize(Quaternion::new((0.5 * angle).cos(), v.x, v.y, v.z))
}

/// Angular velocity of `exp(r)` while `r` changes at `rate`: ω = J(r) ṙ, J the left Jacobian of SO(3).
///
/// J(r) = 1 + (1 − cos θ)/θ² [r×] + (θ − sin θ)/θ³ [r×]², θ = |r|. In the frame that `exp(r)` turns in.
pub fn exp_rate(r: &Vec3, rate: &Vec3) -> Vec3 {
    let t2 = r.norm_squared();
    let t = t2.sqrt();
    // series where the quotients would lose digits
    let (a, b) = if t > 1e-3 {
        ((1.0 - t.cos()) / t2, (t - t.sin()) / (t2 * t))
    } else {
        (0.5 - t2 / 24.0, 1.0 / 6.0 - t2 / 120.0)
    };
    let turned = r.cross(rate);
    rate + turned * a + r.cross(&turned) * b
}

/// Moment on `exp(r)` that does the work of the generalised force `f` on `r`: J(r)⁻ᵀ f, see [`exp_rate`].
///
/// J⁻ᵀ = 1 + ½ [r×] + (1/θ² − cot(θ/2)/(2θ)) [r×]²; regular for θ < 2π.
pub fn log_moment(r: &Vec3, f: &Vec3) -> Vec3 {
    let t2 = r.norm_squared();
    let t = t2.sqrt();
    // its series in t²/(2π)², to rounding, where the quotients would lose digits
    let b = if t > 0.3 {
        1.0 / t2 - 0.5 / (t * (0.5 * t).tan())
    } else {
        let rest = 1.0 / 1_209_600.0 + t2 * (1.0 / 47_900_160.0 + t2 * (691.0 / 1_307_674_368_000.0));
        1.0 / 12.0 + t2 * (1.0 / 720.0 + t2 * (1.0 / 30_240.0 + t2 * rest))
    };
    let turned = r.cross(f);
    f + turned * 0.5 + r.cross(&turned) * b
}

/// Rotation from `a` to `b` at the fraction `s`, along the shorter arc; extrapolates outside [0, 1].
///
/// `s = 0` returns `a` and `s = 1` returns `b` to rounding.
pub fn slerp(a: &Quat, b: &Quat, s: f64) -> Quat {
    exp(&(log(&(b * a.inverse())) * s)) * a
}

/// Splits `q = swing · twist`, `twist` about the unit vector `axis`, `swing` about an axis normal to it.
///
/// At a swing of exactly π the twist is undefined; the identity is returned for it.
pub fn swing_twist(q: &Quat, axis: &Vec3) -> (Quat, Quat) {
    let along = axis * q.imag().dot(axis);
    let raw = Quaternion::new(q.w, along.x, along.y, along.z);
    let twist = if raw.norm_squared() > 1e-24 { Quat::new_normalize(raw) } else { Quat::identity() };
    (q * twist.inverse(), twist)
}

/// Smallest rotation that takes the direction of `from` to the direction of `to`.
///
/// Neither may be zero. For opposite directions any axis normal to `from` is as small; one is chosen
/// deterministically.
pub fn between(from: &Vec3, to: &Vec3) -> Quat {
    let (a, b) = (from.normalize(), to.normalize());
    // 1 + cos, without cancellation
    let w = 0.5 * (a + b).norm_squared();
    if w < 1e-12 {
        let helper = if a.x.abs() < 0.5 { Vec3::x() } else { Vec3::y() };
        return Quat::from_axis_angle(&Unit::new_normalize(a.cross(&helper)), std::f64::consts::PI);
    }
    // (1 + cos, sin·axis) ∥ (cos ½, sin ½·axis): exact to rounding, where acos would lose half the digits
    let v = a.cross(&b);
    Quat::new_normalize(Quaternion::new(w, v.x, v.y, v.z))
}

/// Order in which three axis rotations are multiplied: `Zyx` means `R = Rz · Ry · Rx`.
///
/// The letters are those of a BVH `CHANNELS` line read from left to right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct EulerOrder(pub [usize; 3]);

impl EulerOrder {
    /// `R = Ry · Rz · Rx`, in which scenes and characters give ball joints: twist or bend first, turn last.
    pub const YZX: Self = Self([1, 2, 0]);
    /// `R = Rz · Ry · Rx`, the order of the CMU files.
    pub const ZYX: Self = Self([2, 1, 0]);

    /// Rotation with `angles[i]` rad about the `i`-th axis of this order (leftmost factor first).
    pub fn to_quat(self, angles: &Vec3) -> Quat {
        let r = |i: usize| {
            let mut axis = Vec3::zeros();
            axis[self.0[i]] = 1.0;
            exp(&(axis * angles[i]))
        };
        r(0) * r(1) * r(2)
    }

    /// Angles (rad) in this order; the middle one in [−π/2, π/2], the others in (−π, π].
    ///
    /// In gimbal lock the first angle is set to zero.
    pub fn from_quat(self, q: &Quat) -> Vec3 {
        let m = q.to_rotation_matrix();
        let m = m.matrix();
        let [i, j, k] = self.0;
        // even permutations of (x, y, z) have sign +1
        let sign = if (j + 3 - i) % 3 == 1 { 1.0 } else { -1.0 };
        let s = (sign * m[(i, k)]).clamp(-1.0, 1.0);
        let c = m[(i, i)].hypot(m[(i, j)]);
        let middle = s.atan2(c);
        if c > 1e-9 {
            let first = (-sign * m[(j, k)]).atan2(m[(k, k)]);
            let last = (-sign * m[(i, j)]).atan2(m[(i, i)]);
            Vec3::new(first, middle, last)
        } else {
            let last = (sign * m[(j, i)]).atan2(m[(j, j)]);
            Vec3::new(0.0, middle, last)
        }
    }
}

/// Rotation with Euler angles `(x, y, z)` in degrees: the order in which people write balls, `R = Ry · Rz · Rx`.
pub fn quat_from_deg(xyz: [f64; 3]) -> Quat {
    let [x, y, z] = xyz.map(f64::to_radians);
    EulerOrder::YZX.to_quat(&Vec3::new(y, z, x))
}

/// Euler angles `(x, y, z)` of a rotation, degrees.
pub fn deg_from_quat(q: &Quat) -> [f64; 3] {
    let a = EulerOrder::YZX.from_quat(q);
    [a[2], a[0], a[1]].map(f64::to_degrees)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples() -> Vec<Quat> {
        let mut out = vec![Quat::identity()];
        for i in 0..200 {
            let f = f64::from(i);
            let axis = Vec3::new((f * 1.3).sin(), (f * 0.7).cos(), (f * 2.1).sin()).normalize();
            out.push(exp(&(axis * (f / 200.0 * 3.1))));
        }
        out
    }

    #[test]
    fn log_inverts_exp() {
        for q in samples() {
            let r = log(&q);
            assert!(exp(&r).angle_to(&q) < 1e-7); // acos in angle_to limits this to 2e-8
            assert!((exp(&r).coords - q.coords).norm() < 1e-14);
        }
        let tiny = Vec3::new(1e-12, -2e-12, 3e-13);
        assert!((log(&exp(&tiny)) - tiny).norm() < 1e-26);
    }

    /// The rate of the exponential is its difference quotient; moments and rates exchange equal power.
    #[test]
    fn exp_rate_is_a_derivative_and_log_moment_its_dual() {
        let (rate, f) = (Vec3::new(0.4, -1.1, 0.7), Vec3::new(-2.0, 0.3, 1.2));
        for q in samples().iter().chain([&exp(&Vec3::new(3e-4, -5e-4, 2e-4))]) {
            let r = log(q);
            let h = 1e-6;
            let step = log(&(exp(&(r + rate * h)) * exp(&(r - rate * h)).inverse())) / (2.0 * h);
            let omega = exp_rate(&r, &rate);
            assert!((step - omega).norm() < 1e-8, "{r:?}"); // 4e-10 seen
            let error = log_moment(&r, &f).dot(&omega) - f.dot(&rate);
            assert!(error.abs() < 1e-12, "{r:?}: {error}"); // 7e-15 seen
        }
    }

    #[test]
    fn swing_and_twist_recompose() {
        let axis = Vec3::new(1.0, 2.0, -0.5).normalize();
        for q in samples() {
            let (swing, twist) = swing_twist(&q, &axis);
            assert!((swing * twist).rotation_to(&q).angle() < 1e-7);
            assert!(log(&swing).dot(&axis).abs() < 1e-12);
            assert!(log(&twist).cross(&axis).norm() < 1e-12);
        }
    }

    #[test]
    fn every_euler_order_round_trips() {
        for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            let order = EulerOrder(order);
            for q in samples() {
                let back = order.to_quat(&order.from_quat(&q));
                assert!(log(&(back * q.inverse())).norm() < 1e-12, "{order:?}");
            }
            for lock in [1.0, -1.0] {
                let q = order.to_quat(&Vec3::new(0.4, lock * std::f64::consts::FRAC_PI_2, 0.3));
                let back = order.to_quat(&order.from_quat(&q));
                assert!(log(&(back * q.inverse())).norm() < 1e-7, "{order:?}");
            }
        }
    }

    /// Rotating `from` gives the direction of `to`, also for tiny turns and nearly opposite vectors.
    #[test]
    fn between_takes_one_direction_to_the_other() {
        let from = Vec3::new(0.3, -0.8, 0.2);
        for turn in [1e-12, 1e-8, 1e-3, 1.0, 3.0, std::f64::consts::PI - 1e-4, std::f64::consts::PI] {
            let to = exp(&(Vec3::new(0.2, 0.0, -0.3).normalize() * turn)) * from * 2.0;
            let error = (between(&from, &to) * from.normalize() - to.normalize()).norm();
            assert!(error < 1e-14, "{turn}: {error}"); // 4e-16 seen
        }
    }

    #[test]
    fn slerp_hits_its_ends_and_extrapolates() {
        let (a, b) = (exp(&Vec3::new(0.1, 0.2, 0.3)), exp(&Vec3::new(-0.4, 1.0, 0.2)));
        assert!(log(&(slerp(&a, &b, 1.0) * b.inverse())).norm() < 1e-14);
        assert_eq!(slerp(&a, &b, 0.0).coords, a.coords);
        let twice = slerp(&a, &b, 2.0);
        assert!(log(&(slerp(&a, &twice, 0.5) * b.inverse())).norm() < 1e-14);
    }
}
