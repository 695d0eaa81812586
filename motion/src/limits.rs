//! The way of a joint back into its range of motion.
//!
//! In: a joint with limits, a pose. Out: what takes the joint to the nearest allowed value; `None` where it is within its
//! limits or has none. Hinges: rad, slides: m, in `.x`. A ball has the way in two coordinates, which differ where it is far
//! out, because swing and twist do not add up as rotation vectors do:
//!
//! | | of a ball | used for |
//! |---|---|---|
//! | [`coordinate_correction`] | `clamp(φ) − φ` in the anatomical coordinates φ of [`BallLimits`](crate::BallLimits), rad | potentials in φ: the torque of a stop |
//! | [`tangent_correction`] | `log(R' R⁻¹)`, R' the rotation at `clamp(φ)`: a rotation vector in the zero frame, rad | poses: `q ⊕ correction` is within the limits |

use crate::skeleton::{Joint, Limits, Skeleton, quat_at};
use crate::{Vec3, rotation};

/// Rotation vectors shorter than this are rounding, rad.
const ROUNDING_RAD: f64 = 1e-9;

/// Step of the differences of [`tangent_correction_slopes`], rad or m.
const STEP: f64 = 1e-6;

/// The way back in the joint's own coordinates, `clamp(φ) − φ`. See the module header.
///
/// * `q`, `q_at`: the pose, and where the joint's value starts in it
pub fn coordinate_correction(joint: &Joint, limits: Option<&Limits>, q: &[f64], q_at: usize) -> Option<Vec3> {
    match (joint, limits?) {
        (Joint::Revolute(_) | Joint::Prismatic(_), Limits::Axis(range)) => {
            let x = q[q_at];
            (!range.contains(x)).then(|| Vec3::x() * (range.clamp(x) - x))
        }
        (Joint::Spherical, Limits::Ball(limits)) => {
            let phi = limits.coords(&quat_at(q, q_at));
            let back = Vec3::from_fn(|i, _| limits.ranges[i].clamp(phi[i]) - phi[i]);
            (back != Vec3::zeros()).then_some(back)
        }
        _ => None,
    }
}

/// The way back of the joint of `link` in the tangent of the pose, as [`Skeleton::integrate`] takes it. See the module
/// header.
pub fn tangent_correction(skeleton: &Skeleton, q: &[f64], link: usize) -> Option<Vec3> {
    let (l, at) = (&skeleton.links()[link], skeleton.q_at(link));
    match (&l.limits, l.joint) {
        (Some(Limits::Ball(b)), Joint::Spherical) => {
            let r = quat_at(q, at);
            let clamped = b.clamp(&r);
            // clamping rounds: a rotation at its limits can come back a few ulps away, which is no direction to go
            Some(rotation::log(&(clamped * r.inverse()))).filter(|e| e.norm() > ROUNDING_RAD)
        }
        _ => coordinate_correction(&l.joint, l.limits.as_ref(), q, at),
    }
}

/// Slopes of the length of the [`tangent_correction`] of `link` by its joint's degrees of freedom, one for each.
///
/// For a ball by differences: its limits are clamped as swing and twist, so that moving along the correction is not the
/// fastest way to shorten it.
pub fn tangent_correction_slopes(skeleton: &Skeleton, q: &[f64], link: usize) -> Vec<f64> {
    let (from, count) = (skeleton.v_at(link), skeleton.links()[link].joint.nv());
    let length = |dof: usize, step: f64| {
        let (mut posed, mut v) = (q.to_vec(), vec![0.0; skeleton.nv()]);
        v[from + dof] = step;
        skeleton.integrate(&mut posed, &v, 1.0);
        tangent_correction(skeleton, &posed, link).map_or(0.0, |e| e.norm())
    };
    (0..count).map(|dof| (length(dof, STEP) - length(dof, -STEP)) / (2.0 * STEP)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::exp;
    use crate::{BallLimits, Link, Quat, Range};

    /// A ball, a hinge and a slide with limits.
    fn skeleton() -> Skeleton {
        let ranges = [Range::new(-0.5, 0.7), Range::new(-0.3, 0.4), Range::new(-0.9, 0.2)];
        let ball = BallLimits { axes: [Vec3::x(), Vec3::y(), Vec3::z()], ranges };
        let slant = Vec3::new(0.6, 0.0, 0.8);
        let mut links = vec![
            Link::new("neck", None, Vec3::zeros(), Joint::Spherical),
            Link::new("jaw", Some(0), Vec3::x(), Joint::Revolute(slant)),
            Link::new("tongue", Some(1), Vec3::x(), Joint::Prismatic(slant)),
        ];
        links[0].limits = Some(Limits::Ball(ball));
        links[1].limits = Some(Limits::Axis(Range::new(0.1, 0.6)));
        links[2].limits = Some(Limits::Axis(Range::new(-0.02, 0.05)));
        Skeleton::new(links).unwrap()
    }

    /// Within the limits there is no way back; outside it leads to the clamped value, and from there none is left.
    #[test]
    fn the_way_back_leads_to_the_limits() {
        let s = skeleton();
        let (mut q, mut outside) = (s.zero_pose(), [0; 3]);
        for i in 0..2000 {
            let x = f64::from(i);
            let r: Quat = exp(&(Vec3::new(x.sin(), (1.7 * x).cos(), (2.3 * x).sin()) * 0.8));
            s.set_rotation(&mut q, 0, &r);
            q[s.q_at(1)] = 0.3 + 0.6 * (1.1 * x).sin();
            q[s.q_at(2)] = 0.08 * (0.9 * x).cos();
            let mut clamped = q.clone();
            s.clamp_to_limits(&mut clamped);
            let mut v = vec![0.0; s.nv()];
            for link in 0..3 {
                let Some(e) = tangent_correction(&s, &q, link) else { continue };
                outside[link] += 1;
                assert!(e.norm() > 0.0 && e.normalize().iter().all(|x| x.is_finite()));
                let (at, count) = (s.v_at(link), s.links()[link].joint.nv());
                v[at..at + count].copy_from_slice(&e.as_slice()[..count]);
            }
            let mut back = q.clone();
            s.integrate(&mut back, &v, 1.0);
            let mut left = vec![0.0; s.nv()];
            s.difference(&back, &clamped, 1.0, &mut left);
            let worst = left.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            assert!(worst < 1e-9, "{i}: {worst}"); // 4e-16 seen
            s.clamp_to_limits(&mut back);
            assert!((0..3).all(|link| tangent_correction(&s, &back, link).is_none()), "{i}");
        }
        assert!(outside.iter().all(|n| (200..1900).contains(n)), "{outside:?}");
    }

    /// In anatomical coordinates the way back takes φ to the clamped φ; both ways agree on whether there is one, and for
    /// hinges and slides on how long it is.
    #[test]
    fn both_ways_back_agree_on_where_limits_are() {
        let s = skeleton();
        let Some(Limits::Ball(ball)) = &s.links()[0].limits else { panic!("a ball") };
        let mut q = s.zero_pose();
        let mut apart = 0.0f64;
        for i in 0..500 {
            let x = f64::from(i);
            s.set_rotation(&mut q, 0, &exp(&(Vec3::new(x.sin(), (1.7 * x).cos(), (2.3 * x).sin()) * 0.8)));
            q[s.q_at(1)] = 0.3 + 0.6 * (1.1 * x).sin();
            for link in 0..3 {
                let l = &s.links()[link];
                let own = coordinate_correction(&l.joint, l.limits.as_ref(), &q, s.q_at(link));
                let tangent = tangent_correction(&s, &q, link);
                assert_eq!(own.is_some(), tangent.is_some(), "{i}: {link}");
                let (Some(own), Some(tangent)) = (own, tangent) else { continue };
                if link > 0 {
                    assert_eq!(own, tangent);
                    continue;
                }
                let phi = ball.coords(&s.rotation(&q, 0)) + own;
                assert!((0..3).all(|k| (ball.ranges[k].clamp(phi[k]) - phi[k]).abs() < 1e-12), "{i}");
                apart = apart.max((own - tangent).norm());
            }
        }
        assert!(apart > 0.01, "{apart}"); // two different vectors
    }

    /// Slopes tell how the length of the way back changes with the joint: by ±1 with a hinge.
    #[test]
    fn slopes_are_those_of_the_length() {
        let s = skeleton();
        let mut q = s.zero_pose();
        q[s.q_at(1)] = 0.9;
        assert!((tangent_correction_slopes(&s, &q, 1)[0] - 1.0).abs() < 1e-9);
        q[s.q_at(1)] = -0.4;
        assert!((tangent_correction_slopes(&s, &q, 1)[0] + 1.0).abs() < 1e-9);
        s.set_rotation(&mut q, 0, &exp(&Vec3::new(1.0, 0.2, 0.5)));
        let slopes = tangent_correction_slopes(&s, &q, 0);
        let before = tangent_correction(&s, &q, 0).unwrap().norm();
        let way = [0.7e-4, -0.4e-4, 0.5e-4];
        let mut v = vec![0.0; s.nv()];
        v[..3].copy_from_slice(&way);
        s.integrate(&mut q, &v, 1.0);
        let told: f64 = slopes.iter().zip(way).map(|(a, b)| a * b).sum();
        let after = tangent_correction(&s, &q, 0).unwrap().norm();
        assert!((after - before - told).abs() < 1e-7, "{} {told}", after - before); // 5e-11 seen
    }
}
