//! Stops: what ligaments do beyond a joint's range of motion.
//!
//! In: limits and a pose. Out: the torque that leads back to the nearest allowed value, per stiffness, along the joint's
//! zero frame. Zero inside the range. The potential is ½ k |φ − clamp(φ)|² in the joint's own coordinate, for balls
//! the anatomical ones (swing and twist): conservative, and it does not depend on the path, as limits on
//! rotation-vector components do.
//!
//! This is a torque, the slope of that potential. The rotation that takes a pose back to its limits
//! ([`motion::limits::tangent_correction`]) is another vector; `clamp(φ) − φ` is what both start from.

use motion::limits::coordinate_correction;
use motion::skeleton::quat_at;
use motion::{Joint, Limits, Vec3};

use crate::antagonist::anatomical;

/// Stiffness of a stop over K₁ of its joint: as stiff as a braced muscle, four times the natural one.
pub const STIFFNESS_RATIO: f64 = 4.0;

/// Torque over stiffness that leads back into the range: rad (m for slides); in `.x` for hinges and
/// slides. `None` inside the range and for joints without limits.
pub fn restoring_torque(joint: &Joint, limits: Option<&Limits>, q: &[f64], q_at: usize) -> Option<Vec3> {
    let back = coordinate_correction(joint, limits, q, q_at)?;
    match limits? {
        Limits::Axis(_) => Some(back),
        Limits::Ball(limits) => {
            // ω = A φ̇, so the torque of a force f on φ is A⁻ᵀ f
            let (_, axes) = anatomical(limits, &quat_at(q, q_at));
            axes.transpose().try_inverse().map(|inverse| inverse * back)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motion::rotation::{exp, log};
    use motion::{BallLimits, Quat, Range};

    fn limits() -> BallLimits {
        let ranges = [Range::new(-0.4, 0.8), Range::new(-0.3, 0.5), Range::new(-0.6, 0.2)];
        BallLimits { axes: [Vec3::x(), Vec3::z(), -Vec3::y()], ranges }
    }

    fn pose(r: &Quat) -> [f64; 4] {
        [r.w, r.i, r.j, r.k]
    }

    /// Nothing inside; outside, the torque is minus the slope of the potential in every direction.
    #[test]
    fn the_torque_is_the_slope_of_a_potential() {
        let b = limits();
        let all = Limits::Ball(b);
        let inside = b.rotation(&Vec3::new(0.3, -0.1, 0.1));
        assert_eq!(restoring_torque(&Joint::Spherical, Some(&all), &pose(&inside), 0), None);
        let potential = |r: &Quat| {
            let phi = b.coords(r);
            0.5 * Vec3::from_fn(|i, _| b.ranges[i].clamp(phi[i]) - phi[i]).norm_squared()
        };
        for phi in [Vec3::new(1.1, 0.1, 0.0), Vec3::new(-0.7, 0.9, 0.5), Vec3::new(0.2, 0.2, -1.2)] {
            let r = b.rotation(&phi);
            let torque = restoring_torque(&Joint::Spherical, Some(&all), &pose(&r), 0).unwrap();
            for e in [Vec3::x(), Vec3::y(), Vec3::z()] {
                let h = 1e-6;
                let slope = (potential(&(exp(&(e * h)) * r)) - potential(&(exp(&(e * -h)) * r))) / (2.0 * h);
                assert!((torque.dot(&e) + slope).abs() < 1e-8, "{} {slope}", torque.dot(&e));
            }
            assert!(log(&r).norm() > 0.5);
        }
    }

    #[test]
    fn hinges_go_back_to_the_nearer_end() {
        let range = Limits::Axis(Range::new(0.0, 2.0));
        let joint = Joint::Revolute(Vec3::y());
        assert_eq!(restoring_torque(&joint, Some(&range), &[1.0], 0), None);
        assert_eq!(restoring_torque(&joint, Some(&range), &[2.5], 0), Some(Vec3::new(-0.5, 0.0, 0.0)));
        assert_eq!(restoring_torque(&joint, None, &[9.0], 0), None);
    }
}
