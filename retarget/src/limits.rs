//! How far a joint is beyond its range.

use motion::skeleton::Limits;
use motion::{Joint, Skeleton, Vec3, rotation};

/// Turns below this are rounding, rad.
const ROUNDING: f64 = 1e-9;

/// Step of differences, rad or m.
const STEP: f64 = 1e-6;

/// The way back to the limits of the joint of `link`: a rotation vector in its zero frame for a ball; in `.x` an angle or
/// a length for hinges and slides. `None` where the joint is within them.
pub(crate) fn way_back(skeleton: &Skeleton, q: &[f64], link: usize) -> Option<Vec3> {
    let (l, at) = (&skeleton.links()[link], skeleton.q_at(link));
    match (&l.limits, l.joint) {
        (Some(Limits::Axis(r)), Joint::Revolute(_) | Joint::Prismatic(_)) if !r.contains(q[at]) => {
            Some(Vec3::new(r.clamp(q[at]) - q[at], 0.0, 0.0))
        }
        (Some(Limits::Ball(b)), Joint::Spherical) => {
            let r = skeleton.rotation(q, link);
            let c = b.clamp(&r);
            // clamping rounds: what is within the limits comes back a few ulps away, or exactly, without a direction
            Some(rotation::log(&(c * r.inverse()))).filter(|e| e.norm() > ROUNDING)
        }
        _ => None,
    }
}

/// Slopes of the length of the way back by the tangent of the joint of `link`, one for each of its degrees of freedom.
///
/// Of a ball by differences: its limits are clamped as a swing and a twist, which do not lie on the shortest way back.
pub(crate) fn way_back_slopes(skeleton: &Skeleton, q: &[f64], link: usize) -> Vec<f64> {
    let (from, count) = (skeleton.v_at(link), skeleton.links()[link].joint.nv());
    let length = |dof: usize, step: f64| {
        let (mut posed, mut v) = (q.to_vec(), vec![0.0; skeleton.nv()]);
        v[from + dof] = step;
        skeleton.integrate(&mut posed, &v, 1.0);
        way_back(skeleton, &posed, link).map_or(0.0, |e| e.norm())
    };
    (0..count).map(|dof| (length(dof, STEP) - length(dof, -STEP)) / (2.0 * STEP)).collect()
}

#[cfg(test)]
mod tests {
    use motion::skeleton::{BallLimits, Range};
    use motion::{Link, Quat};

    use super::*;

    /// At and inside the limits there is no way back; outside it leads to them. Every way has a direction.
    #[test]
    fn rounding_has_no_direction() {
        let ranges = [Range::new(-0.5, 0.7), Range::new(-0.3, 0.4), Range::new(-0.9, 0.2)];
        let limits = BallLimits { axes: [Vec3::x(), Vec3::y(), Vec3::z()], ranges };
        let mut link = Link::new("neck", None, Vec3::zeros(), Joint::Spherical);
        link.limits = Some(Limits::Ball(limits));
        let skeleton = Skeleton::new(vec![link]).unwrap();
        let mut q = skeleton.zero_pose();
        let mut outside = 0;
        for i in 0..2000 {
            let x = f64::from(i);
            let r: Quat = rotation::exp(&(Vec3::new(x.sin(), (1.7 * x).cos(), (2.3 * x).sin()) * 0.8));
            skeleton.set_rotation(&mut q, 0, &r);
            if let Some(e) = way_back(&skeleton, &q, 0) {
                outside += 1;
                assert!(e.norm() > 0.0 && e.normalize().iter().all(|x| x.is_finite()));
                let back = rotation::exp(&e) * r;
                skeleton.set_rotation(&mut q, 0, &back);
                assert_eq!(way_back(&skeleton, &q, 0), None, "{i}");
            }
        }
        assert!((200..1900).contains(&outside), "{outside}");
    }
}
