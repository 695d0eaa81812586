//! The swivel of a leg: where its knee lies on the circle about the line from hip to ankle.
//!
//! A pelvis and a planted foot leave a leg this one freedom. A person's knee follows the foot: the shin turns in the
//! ankle and about itself by little, the thigh in the hip by much. The rule: with the knee's axis as the zero pose has it
//! over the foot, and as the zero pose has it under the pelvis, both about the line, the knee lies
//! `m tanh(s δ / m)` from the foot's towards the pelvis's, where δ is the angle between them, `s` = [`PELVIS_SHARE`] and
//! `m` = [`MOST_RAD`]. So it is near a share of δ where δ is small, never beyond `m`, and smooth between.
//!
//! In: a pose, a limb. Out: the angle that is missing, the pose with the leg turned; hip and foot stay where they are.
//! Units: rad, about the line from ankle to hip.

use super::chain;
use crate::{Joint, Limb, Quat, Skeleton, Vec3, rotation};

/// Share of the pelvis's turn over the foot that the knee goes along with, where that turn is small.
pub const PELVIS_SHARE: f64 = 0.3;
/// Furthest that the knee goes with the pelvis, rad (12°).
pub const MOST_RAD: f64 = 12.0 * std::f64::consts::PI / 180.0;

/// Axis of the knee in the frame of the lower link: that of its hinge; of a ball the one that points to the left in the
/// zero pose, about which legs bend.
pub fn knee_axis(skeleton: &Skeleton, limb: &Limb) -> Vec3 {
    match skeleton.links()[limb.lower].joint {
        Joint::Revolute(axis) => axis,
        _ => chain::rotation_in_zero_pose(skeleton, limb.lower).inverse() * Vec3::x(),
    }
}

/// Angle from `from` to `to` about `line`; `None` where one of them lies along it.
pub fn angle_about(line: &Vec3, from: &Vec3, to: &Vec3) -> Option<f64> {
    let across = |v: &Vec3| (v - line * line.dot(v)).try_normalize(1e-3);
    let (from, to) = (across(from)?, across(to)?);
    Some(line.dot(&from.cross(&to)).atan2(from.dot(&to)))
}

/// Angle by which the leg `limb` has to turn about the line from ankle to hip until its knee lies where the rule has it;
/// zero where the rule says nothing: no link above the limb, hip on the ankle, an axis along the line.
pub fn missing(skeleton: &Skeleton, q: &[f64], limb: &Limb) -> f64 {
    let Some(above) = skeleton.links()[limb.upper].parent else { return 0.0 };
    let axis = knee_axis(skeleton, limb);
    let zero = |link: usize| chain::rotation_in_zero_pose(skeleton, link);
    let now = |link: usize| chain::world_from_link(skeleton, q, link);
    let (upper, lower, end) = (now(limb.upper), now(limb.lower), now(limb.end));
    let line = upper.translation.vector - end.translation.vector;
    let Some(line) = line.try_normalize(1e-6) else { return 0.0 };
    let of_zero_pose = zero(limb.lower) * axis;
    let carried = |link: usize, now: &Quat| now * (zero(link).inverse() * of_zero_pose);
    let over_foot = carried(limb.end, &end.rotation);
    let found = (|| {
        let delta = angle_about(&line, &over_foot, &carried(above, &now(above).rotation))?;
        let along = angle_about(&line, &(lower.rotation * axis), &over_foot)?;
        Some(along + MOST_RAD * (PELVIS_SHARE * delta / MOST_RAD).tanh())
    })();
    // the shorter way
    found.map_or(0.0, |angle| {
        (angle + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI
    })
}

/// Turns the leg `limb` of `q` about the line from ankle to hip; its end keeps place and turn.
pub fn turn(skeleton: &Skeleton, q: &mut [f64], limb: &Limb, angle: f64) {
    let links = skeleton.links();
    let above = |link: usize| {
        links[link].parent.map_or(Quat::identity(), |p| chain::world_from_link(skeleton, q, p).rotation)
    };
    let (upper, end) =
        (chain::world_from_link(skeleton, q, limb.upper), chain::world_from_link(skeleton, q, limb.end));
    let line = upper.translation.vector - end.translation.vector;
    let Some(line) = line.try_normalize(1e-6) else { return };
    let by = rotation::exp(&(line * angle));
    let local = |zero: Quat, world: Quat| Quat::new_normalize((zero.inverse() * world).into_inner());
    let hip = above(limb.upper) * links[limb.upper].parent_from_zero.rotation;
    let ankle = by * above(limb.end) * links[limb.end].parent_from_zero.rotation;
    skeleton.set_rotation(q, limb.upper, &local(hip, by * upper.rotation));
    skeleton.set_rotation(q, limb.end, &local(ankle, end.rotation));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::{Knee, Plant, plant};
    use crate::rotation::exp;
    use crate::skeleton::LimbKind;
    use crate::{Kinematics, Link, Transform};

    /// A pelvis with one leg, thigh and shin 0.4 m, its knee a hinge to the left.
    fn leg() -> (Skeleton, Limb) {
        let links = vec![
            Link::new("pelvis", None, Vec3::zeros(), Joint::Free),
            Link::new("hip", Some(0), Vec3::new(0.1, 0.0, 0.0), Joint::Spherical),
            Link::new("knee", Some(1), Vec3::y() * -0.4, Joint::Revolute(Vec3::x())),
            Link::new("ankle", Some(2), Vec3::y() * -0.4, Joint::Spherical),
        ];
        let limb = Limb { name: "leg".into(), kind: LimbKind::Leg, upper: 1, lower: 2, end: 3 };
        (Skeleton::new(links).unwrap(), limb)
    }

    /// Wherever the pelvis goes and however it turns, the foot stays, and the knee lies over the foot, towards the pelvis by
    /// no more than the rule says.
    #[test]
    fn the_knee_follows_the_foot() {
        let (s, limb) = leg();
        let mut q = s.zero_pose();
        s.set_position(&mut q, 0, &Vec3::new(0.0, 0.8, 0.0));
        q[s.q_at(2)] = 0.3;
        let foot = Transform::from_parts(Vec3::new(0.1, 0.0, 0.0).into(), exp(&(Vec3::y() * 0.2)));
        let held = Plant { limb: limb.clone(), world_from_end: foot, knee: Knee::Follows };
        for i in 0..200 {
            let x = f64::from(i);
            let mut q = q.clone();
            let place = Vec3::new(0.1 * x.sin(), 0.6 + 0.1 * (1.3 * x).cos(), 0.1 * (1.7 * x).sin());
            s.set_position(&mut q, 0, &place);
            s.set_rotation(&mut q, 0, &exp(&(Vec3::y() * (2.1 * x).sin())));
            let residue = plant(&s, &mut q, std::slice::from_ref(&held)).unwrap();
            assert!(residue < 1e-9, "{i}: {residue}");
            let k = Kinematics::new(&s, &q);
            assert!((k.origin(3) - foot.translation.vector).norm() < 1e-9, "{i}");
            assert!(k.world[3].rotation.angle_to(&foot.rotation) < 1e-7, "{i}");
            assert!(missing(&s, &q, &limb).abs() < 1e-9, "{i}");
            let line = (k.origin(1) - k.origin(3)).normalize();
            let knee =
                angle_about(&line, &(k.world[3].rotation * Vec3::x()), &(k.world[2].rotation * Vec3::x()));
            assert!(knee.unwrap().abs() <= MOST_RAD, "{i}: {knee:?}");
            // a leg whose swivel is kept goes all the way with the pelvis
            let mut kept = q.clone();
            turn(&s, &mut kept, &limb, 0.5);
            assert!((missing(&s, &kept, &limb) + 0.5).abs() < 1e-9, "{i}");
        }
    }
}
