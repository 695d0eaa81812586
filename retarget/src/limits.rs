//! How far a joint is beyond its range.

use motion::skeleton::Limits;
use motion::{Joint, Skeleton, Vec3, rotation};

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
            (c != r).then(|| rotation::log(&(c * r.inverse())))
        }
        _ => None,
    }
}
