//! Transforms along one chain of links, without those of the rest of the body and without memory.
//!
//! Frames are those of [`Kinematics`](crate::Kinematics): `zero` is where a link's joint has it when its rotation is none.

use crate::Transform;
use crate::rotation::Quat;
use crate::skeleton::Skeleton;

/// Transform of `link` in the frame of its ancestor `from`; `None` if it is no ancestor.
pub(super) fn between(skeleton: &Skeleton, q: &[f64], from: usize, link: usize) -> Option<Transform> {
    let mut t = Transform::identity();
    let mut at = link;
    while at != from {
        let l = &skeleton.links()[at];
        t = l.parent_from_zero * skeleton.joint_transform(q, at) * t;
        at = l.parent?;
    }
    Some(t)
}

/// World transform of the zero frame of the joint of `link`.
pub(super) fn world_from_zero(skeleton: &Skeleton, q: &[f64], link: usize) -> Transform {
    let l = &skeleton.links()[link];
    match l.parent {
        None => l.parent_from_zero,
        Some(p) => world_from_link(skeleton, q, p) * l.parent_from_zero,
    }
}

/// World transform of `link`.
pub(super) fn world_from_link(skeleton: &Skeleton, q: &[f64], link: usize) -> Transform {
    world_from_zero(skeleton, q, link) * skeleton.joint_transform(q, link)
}

/// World rotation of `link` in the zero pose.
pub(super) fn rotation_in_zero_pose(skeleton: &Skeleton, link: usize) -> Quat {
    let l = &skeleton.links()[link];
    match l.parent {
        None => l.parent_from_zero.rotation,
        Some(p) => rotation_in_zero_pose(skeleton, p) * l.parent_from_zero.rotation,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Kinematics;
    use crate::rotation::{Vec3, exp};
    use crate::skeleton::{Joint, Link};

    /// Links of a chain are where all of the body's kinematics have them (below 1e-7: an angle near zero has half the digits).
    #[test]
    fn chains_agree_with_the_whole_body() {
        let mut links = vec![Link::new("root", None, Vec3::zeros(), Joint::Free)];
        for i in 0..4 {
            let joint = if i == 2 { Joint::Prismatic(Vec3::y_axis().into_inner()) } else { Joint::Spherical };
            let mut link = Link::new(format!("l{i}"), Some(i), Vec3::new(0.1, 0.3, -0.05 * i as f64), joint);
            link.parent_from_zero.rotation = exp(&Vec3::new(0.1 * i as f64, 0.2, -0.3));
            links.push(link);
        }
        let s = Skeleton::new(links).unwrap();
        let mut q = s.zero_pose();
        for l in [0, 1, 2, 4] {
            s.set_rotation(&mut q, l, &exp(&Vec3::new(0.3, -0.2 * l as f64, 0.5)));
        }
        s.set_position(&mut q, 0, &Vec3::new(1.0, 2.0, 3.0));
        q[s.q_at(3)] = 0.2;
        let k = Kinematics::new(&s, &q);
        let apart = |a: &Transform, b: &Transform| {
            (a.translation.vector - b.translation.vector).norm() + a.rotation.angle_to(&b.rotation)
        };
        for link in 0..s.links().len() {
            assert!(apart(&world_from_link(&s, &q, link), &k.world[link]) < 1e-7);
            let from = between(&s, &q, 0, link).unwrap();
            assert!(apart(&(k.world[0] * from), &k.world[link]) < 1e-7);
            let zero = Kinematics::new(&s, &s.zero_pose()).world[link].rotation;
            assert!(rotation_in_zero_pose(&s, link).angle_to(&zero) < 1e-7);
        }
        assert!(between(&s, &q, 4, 1).is_none());
    }
}
