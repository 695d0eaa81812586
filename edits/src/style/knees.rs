//! The plane in which a knee bends.
//!
//! In: a clip before and after its feet were moved. Out: knees that point where those of the clip before point, seen from the
//! pelvis. A leg that is nearly straight, or bent the wrong way by a little, has no plane of its own: there it is the one in which the
//! leg bends over the whole clip, so that no knee flips.
//!
//! The same holds for the way in which a knee of three axes bends, seen from the thigh: IK bends it farther the way it is bent. One that
//! is stretched too far (3° of captured motion are enough) would be bent backwards, and the leg turned round to point it ahead.
//!
//! Limits: a leg is turned less where its hip or knee would leave them, and the turn of a foot off the ground gives where its ankle
//! would. What was beyond its limits before may stay so.

use motion::ik::swivel;
use motion::rotation::between;
use motion::{Clip, Dof, Joint, Kinematics, Limb, Skeleton, Transform, Value, Vec3};

use crate::feet::Leg;
use crate::poses::within_limits;

/// A knee this far from the line from hip to ankle has a plane of its own as much as that of the whole clip, m.
const BENT_M: f64 = 0.05;
/// Shorter offsets have no direction, m.
const NONE_M: f64 = 1e-6;
/// A knee that is bent by less than this, as a sine, has no way to bend of its own: 6°.
const STRAIGHT: f64 = 0.1;
/// A swivel within the limits is looked for so far on either side, rad, ...
const SEARCH: f64 = 60.0 * std::f64::consts::PI / 180.0;
/// ... in such steps, rad, ...
const STEP: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// ... the last of which is halved so often.
const HALVINGS: usize = 24;
/// Beyond a limit by less is rounding, rad.
const ROUNDING: f64 = 1e-7;

/// Where the knee is from the line from hip to ankle, and the direction of that line, world.
fn offset(k: &Kinematics, leg: &Leg) -> (Vec3, Vec3) {
    let hip = k.origin(leg.limb.upper);
    let axis = (k.origin(leg.limb.end) - hip).normalize();
    let knee = k.origin(leg.limb.lower) - hip;
    (knee - axis * knee.dot(&axis), axis)
}

/// Where the shin of a leg points across the thigh, and the direction of the thigh; in the frame of the thigh, as shares of lengths.
fn bend(k: &Kinematics, leg: &Leg) -> (Vec3, Vec3) {
    let knee = k.origin(leg.limb.lower);
    let own = k.world[leg.limb.upper].rotation.inverse();
    let thigh = own * (knee - k.origin(leg.limb.upper)).normalize();
    let shin = own * (k.origin(leg.limb.end) - knee).normalize();
    (shin - thigh * shin.dot(&thigh), thigh)
}

/// Directions that count by their lengths, as one; zero where there is none.
fn usual(all: impl Iterator<Item = Vec3>) -> Vec3 {
    all.map(|v| v * v.norm()).sum::<Vec3>().try_normalize(NONE_M * NONE_M).unwrap_or_default()
}

/// Where a shin points that bends the usual way: as it points, if it does so by [`STRAIGHT`].
fn the_usual_way(across: &Vec3, usual: &Vec3) -> Vec3 {
    let short = STRAIGHT - across.dot(usual);
    if short <= 0.0 { *across } else { across + usual * short }
}

/// Gives legs with a goal the turns that they had in `base` (`was`: its links; `is`: those of `clip`), from which IK starts: a leg that a style stretches
/// or breaks has nothing to start from. Knees of three axes that are bent the wrong way are bent the usual way.
pub(super) fn as_before(
    clip: &mut Clip,
    leg: &Leg,
    goals: &[Option<Transform>],
    base: &Clip,
    [was, is]: [&[Kinematics]; 2],
) {
    let s = clip.skeleton.clone();
    let (upper, lower) = (leg.limb.upper, leg.limb.lower);
    let turns = s.links()[lower].joint == Joint::Spherical;
    let way = usual(was.iter().map(|k| bend(k, leg).0));
    for f in (0..clip.frames()).filter(|f| goals[*f].is_some()) {
        let above = s.links()[upper].parent.map_or(motion::Quat::identity(), |p| is[f].world[p].rotation)
            * s.links()[upper].parent_from_zero.rotation;
        let turn = above.inverse() * was[f].world[upper].rotation;
        let q = clip.pose_mut(f);
        s.set_rotation(q, upper, &turn);
        let knee = s.q_at(lower)..s.q_at(lower) + s.links()[lower].joint.nq();
        q[knee.clone()].copy_from_slice(&base.pose(f)[knee]);
        let (across, thigh) = bend(&was[f], leg);
        let wanted = the_usual_way(&across, &way);
        if turns && wanted != across {
            let shin = across + thigh * (1.0 - across.norm_squared()).max(0.0).sqrt();
            let along = (1.0 - wanted.norm_squared()).max(0.0).sqrt();
            let by = between(&shin, &(wanted + thigh * along));
            // from the frame of the thigh into the joint's
            let zero = was[f].world[upper].rotation.inverse()
                * was[f].world[lower].rotation
                * s.rotation(base.pose(f), lower).inverse();
            s.set_rotation(q, lower, &(zero.inverse() * by * zero * s.rotation(base.pose(f), lower)));
        }
    }
}

/// Turns legs with a goal about the line from hip to ankle, so that knees point where those of `base` (`was`: its links) point, as far
/// as the limits of hip and knee let them; feet keep their place and their turn.
pub(super) fn in_plane(
    clip: &mut Clip,
    leg: &Leg,
    goals: &[Option<Transform>],
    base: &Clip,
    was: &[Kinematics],
) {
    let s = clip.skeleton.clone();
    let own: Vec<Vec3> = was.iter().map(|k| k.world[0].rotation.inverse() * offset(k, leg).0).collect();
    // frames count by how far the knee is bent
    let usual = usual(own.iter().copied());
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
        // the swivel turns about the line from the ankle up
        let angle = -axis.dot(&now.cross(&wanted)).atan2(now.dot(&wanted));
        let angle = allowed(&s, &leg.limb, base.pose(f), clip.pose(f), angle);
        swivel::turn(&s, clip.pose_mut(f), &leg.limb, angle);
    }
}

/// How far a joint of three axes is beyond its limits, or beyond where it was before if that was farther, rad.
fn beyond(s: &Skeleton, link: usize, before: &[f64], q: &[f64]) -> f64 {
    let [was, is] = [before, q].map(|q| s.rotation(q, link));
    match within_limits(s, Dof::Rotation(link), &Value::Rotation(was), &Value::Rotation(is)) {
        (Value::Rotation(kept), true) => kept.angle_to(&is),
        _ => 0.0,
    }
}

/// The swivel nearest to `angle` at which hip and knee are within their limits; `angle` itself, if there is none within [`SEARCH`].
pub(super) fn allowed(s: &Skeleton, limb: &Limb, before: &[f64], q: &[f64], angle: f64) -> f64 {
    let joints = [limb.upper, limb.lower];
    let balls = joints.map(|l| s.links()[l].joint == Joint::Spherical && s.links()[l].limits.is_some());
    if balls == [false; 2] {
        return angle;
    }
    let mut turned = q.to_vec();
    let mut is_allowed = |a: f64| {
        turned.copy_from_slice(q);
        swivel::turn(s, &mut turned, limb, a);
        (0..2).all(|i| !balls[i] || beyond(s, joints[i], before, &turned) < ROUNDING)
    };
    if is_allowed(angle) {
        return angle;
    }
    let steps = (SEARCH / STEP) as usize;
    let around = (1..=steps).flat_map(|i| [1.0, -1.0].map(|side| (side, i as f64 * STEP)));
    for (side, by) in around {
        if is_allowed(angle + side * by) {
            // the edge lies within this step
            let (mut out, mut within) = (by - STEP, by);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (out + within);
                if is_allowed(angle + side * middle) { within = middle } else { out = middle }
            }
            return angle + side * within;
        }
    }
    angle
}

/// Keeps the ankle of a foot that is off the ground within its limits: there its turn gives.
pub(super) fn ankle_within(s: &Skeleton, leg: &Leg, before: &[f64], q: &mut [f64]) {
    let end = leg.limb.end;
    let [was, is] = [before, &*q].map(|q| s.rotation(q, end));
    if let (Value::Rotation(kept), true) =
        within_limits(s, Dof::Rotation(end), &Value::Rotation(was), &Value::Rotation(is))
    {
        s.set_rotation(q, end, &kept);
    }
}

/// How far a leg is beyond its limits, degrees.
pub(super) fn beyond_deg(s: &Skeleton, leg: &Leg, before: &[f64], q: &[f64]) -> f64 {
    let joints = [leg.limb.upper, leg.limb.lower, leg.limb.end];
    joints.map(|l| beyond(s, l, before, q)).into_iter().fold(0.0, f64::max).to_degrees()
}
