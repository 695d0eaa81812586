//! The plane in which a knee bends.
//!
//! In: a clip before and after its feet were moved. Out: knees that point where those of the clip before point, seen from the
//! pelvis. A leg that is nearly straight, or bent the wrong way by a little, has no plane of its own: there it is the one in which the
//! leg bends over the whole clip, so that no knee flips.

use motion::rotation::exp;
use motion::{Clip, Kinematics, Transform, Vec3};

use crate::feet::Leg;

/// A knee this far from the line from hip to ankle has a plane of its own as much as that of the whole clip, m.
const BENT_M: f64 = 0.05;
/// Shorter offsets have no direction, m.
const NONE_M: f64 = 1e-6;

/// Where the knee is from the line from hip to ankle, and the direction of that line, world.
fn offset(k: &Kinematics, leg: &Leg) -> (Vec3, Vec3) {
    let hip = k.origin(leg.limb.upper);
    let axis = (k.origin(leg.limb.end) - hip).normalize();
    let knee = k.origin(leg.limb.lower) - hip;
    (knee - axis * knee.dot(&axis), axis)
}

/// Gives legs with a goal the turns that they had in `base` (`was`: its links), from which IK starts: a leg that a style stretches
/// or breaks has nothing to start from.
pub(super) fn as_before(
    clip: &mut Clip,
    leg: &Leg,
    goals: &[Option<Transform>],
    base: &Clip,
    was: &[Kinematics],
) {
    let s = clip.skeleton.clone();
    let (upper, lower) = (leg.limb.upper, leg.limb.lower);
    for f in (0..clip.frames()).filter(|f| goals[*f].is_some()) {
        let k = Kinematics::new(&s, clip.pose(f));
        let above = s.links()[upper].parent.map_or(motion::Quat::identity(), |p| k.world[p].rotation)
            * s.links()[upper].parent_from_zero.rotation;
        let turn = above.inverse() * was[f].world[upper].rotation;
        let q = clip.pose_mut(f);
        s.set_rotation(q, upper, &turn);
        let knee = s.q_at(lower)..s.q_at(lower) + s.links()[lower].joint.nq();
        q[knee.clone()].copy_from_slice(&base.pose(f)[knee]);
    }
}

/// Turns legs with a goal about the line from hip to ankle, so that knees point where those of `was` point; feet keep their place
/// and their turn.
pub(super) fn in_plane(clip: &mut Clip, leg: &Leg, goals: &[Option<Transform>], was: &[Kinematics]) {
    let s = clip.skeleton.clone();
    let own: Vec<Vec3> = was.iter().map(|k| k.world[0].rotation.inverse() * offset(k, leg).0).collect();
    // frames count by how far the knee is bent
    let usual: Vec3 = own.iter().map(|v| v * v.norm()).sum();
    let usual = usual.try_normalize(NONE_M * NONE_M).unwrap_or_default();
    for f in (0..was.len()).filter(|f| goals[*f].is_some()) {
        let k = Kinematics::new(&s, clip.pose(f));
        let (now, axis) = offset(&k, leg);
        // never against the usual way: between both there would be none
        let ahead = BENT_M + (-own[f].dot(&usual)).max(0.0);
        let wanted = k.world[0].rotation * (own[f] + usual * ahead);
        let wanted = wanted - axis * wanted.dot(&axis);
        if now.norm() < NONE_M || wanted.norm() < NONE_M {
            continue;
        }
        let angle = axis.dot(&now.cross(&wanted)).atan2(now.dot(&wanted));
        let (upper, end) = (leg.limb.upper, leg.limb.end);
        // the joint's own turn, of the whole leg about the line; the foot is turned back
        let local = |k: &Kinematics, link: usize| {
            let l = &s.links()[link];
            l.parent.map_or(motion::Quat::identity(), |p| k.world[p].rotation) * l.parent_from_zero.rotation
        };
        let turned = local(&k, upper).inverse() * exp(&(axis * angle)) * k.world[upper].rotation;
        s.set_rotation(clip.pose_mut(f), upper, &turned);
        let after = Kinematics::new(&s, clip.pose(f));
        let foot = local(&after, end).inverse() * k.world[end].rotation;
        s.set_rotation(clip.pose_mut(f), end, &foot);
    }
}
