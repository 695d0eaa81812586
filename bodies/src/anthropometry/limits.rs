//! Ranges of motion, in the joint coordinates of any skeleton.
//!
//! In: roles and the neutral pose. Out: [`motion::Limits`] relative to the file's zero pose.
//!
//! The published ranges are means of healthy people moving slowly: \[BA79\] (109 men and boys, active,
//! goniometer) for the limbs, \[AAOS\] for the spine, \[Inm44\] for the collar bone. Dancers, acrobats and
//! marker noise exceed them, so each has an *allowance* which is added at both ends; for the limits
//! shape what the body is asked to do, and clamping a real motion is worse than allowing a bit much.
//!
//! The neck is a column: what its joints share is a choice, [`NeckShare`].
//!
//! # Coordinates
//!
//! Ranges are stated for the left side as swing about two axes and twist about the bone
//! ([`motion::BallLimits`]) from a *centre*: the neutral pose, or for shoulders the arm straight
//! sideways, palm down. The right side is the mirror image: coordinates about `left` stay, those about
//! `up`, `front` and the bone change sign. The axes are right-handed: where they would not be, the
//! second one is turned round with its range. A skeleton whose zero pose is the centre gets the ranges as
//! they stand; any other gets the smallest box that holds them about its own zero.
//! A body read from a standing frame of the motion has its zero at the centres ([`center_rotation`]): its file's zero
//! pose says nothing.
//!
//! \[BA79\] D. C. Boone, S. P. Azen. Normal range of motion of joints in male subjects. J. Bone Joint
//! Surg. 61-A, 756–759, 1979.
//! \[AAOS\] American Academy of Orthopaedic Surgeons. Joint motion: method of measuring and recording. 1965.
//! \[WP90\] A. A. White, M. M. Panjabi. Clinical biomechanics of the spine. 2nd ed., Lippincott, 1990.
//! \[Inm44\] V. T. Inman, J. B. Saunders, L. C. Abbott. Observations on the function of the shoulder
//! joint. J. Bone Joint Surg. 26, 1–30, 1944.

use std::f64::consts::PI;

use motion::rotation::{exp, log};
use motion::{BallLimits, Joint, Limits, Quat, Range, Skeleton, Vec3};

use super::aliases::{Anatomy, Role, Side};
use super::frame::{Neutral, UP};

/// How the joints of the neck and the head share the cervical range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NeckShare {
    /// As rigs use them: one joint may do most of the work, or bend against the next, so each gets more than its part.
    #[default]
    Rig,
    /// As the vertebrae do, the head's joint at the base of the skull (C0 to C2), the neck's joints below it (C2 to T1):
    /// together they turn as far as a neck.
    Vertebrae,
}

/// Part of the cervical range that C0 to C2 have: bending forward and back, to the side, turning. Of the representative
/// ranges of \[WP90\] from the skull down to T1, degrees: 25 20 · 10 15 20 20 17 9; 5 5 · 10 11 11 8 7 4;
/// 5 40 · 3 7 7 7 6 2.
pub const SKULL_SHARE: [f64; 3] = [45.0 / 136.0, 10.0 / 61.0, 45.0 / 77.0];

/// Range of one coordinate, degrees, left side: published ends and what is added to each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rom {
    /// Published lower and upper end.
    pub published: [f64; 2],
    /// Added at both ends.
    pub allowance: f64,
}

const fn rom(lo: f64, hi: f64, allowance: f64) -> Rom {
    Rom { published: [lo, hi], allowance }
}

impl Rom {
    fn widened(self, share: f64) -> [f64; 2] {
        [(self.published[0] - self.allowance) * share, (self.published[1] + self.allowance) * share]
    }
}

/// Part of a column's range that each of its `n` joints gets in a rig. Not an even one: rigs let one joint do most of the
/// work (CMU's lower back bends 67° in 127_31) or bend against the next (its two neck joints).
fn rig_share(n: usize) -> f64 {
    if n > 1 { (1.25 / n as f64).max(0.7) } else { 1.0 }
}

/// Parts of the range of its kind that a joint gets.
fn part(anatomy: &Anatomy, role: Role, neck: NeckShare) -> [f64; 3] {
    let joints = anatomy.neck.len();
    match (role, neck) {
        (Role::Spine, _) => [rig_share(anatomy.spine.len()); 3],
        (Role::Neck | Role::Head, NeckShare::Rig) => [rig_share(joints + 1); 3],
        (Role::Neck, NeckShare::Vertebrae) => SKULL_SHARE.map(|skull| (1.0 - skull) / joints as f64),
        (Role::Head, NeckShare::Vertebrae) if joints > 0 => SKULL_SHARE,
        _ => [1.0; 3],
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Axis {
    Left,
    Up,
    Front,
}

/// How a kind of joint may move, left side: two swings and the twist.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ball {
    /// Direction of the bone at the centre.
    bone: Bone,
    axes: [Axis; 2],
    ranges: [Rom; 3],
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Bone {
    /// As the neutral pose has it.
    Own,
    /// Sideways: the arm lifted by 90°.
    Sideways,
    /// Forward, whatever the bone: the foot.
    Front,
}

/// Hinge flexion of elbow and knee, degrees: \[BA79\] 142.9 and 142.5, with an allowance.
pub const HINGE_DEG: [f64; 2] = [0.0, 150.0];

fn ball(role: Role) -> Option<Ball> {
    use Axis::{Front, Left, Up};
    Some(match role {
        // + about left bends forward; [AAOS] thoracic and lumbar spine together
        Role::Spine => Ball {
            bone: Bone::Own,
            axes: [Left, Front],
            ranges: [rom(-25.0, 80.0, 30.0), rom(-35.0, 35.0, 20.0), rom(-45.0, 45.0, 20.0)],
        },
        // [AAOS] cervical spine; neck joints and head share it
        Role::Neck | Role::Head => Ball {
            bone: Bone::Own,
            axes: [Left, Front],
            ranges: [rom(-45.0, 45.0, 35.0), rom(-45.0, 45.0, 20.0), rom(-60.0, 60.0, 25.0)],
        },
        // [Inm44]: protraction −, retraction + about up; elevation + about front; rotation about the bone
        Role::Clavicle(_) => Ball {
            bone: Bone::Own,
            axes: [Up, Front],
            ranges: [rom(-15.0, 15.0, 20.0), rom(-10.0, 40.0, 15.0), rom(-20.0, 50.0, 15.0)],
        },
        // [BA79] horizontal flexion 140.7 (−) and extension 45.4 about up; abduction 184.0 is 94.0 above
        // sideways, hanging is 90 below it; external (−) 103.7 and internal 68.8 rotation
        Role::UpperArm(_) => Ball {
            bone: Bone::Sideways,
            axes: [Up, Front],
            ranges: [rom(-140.7, 45.4, 35.0), rom(-90.0, 94.0, 45.0), rom(-103.7, 68.8, 50.0)],
        },
        // flexion 142.9 (−) about left; supination 82.1 (−) and pronation 75.8 about the bone. A rig's elbow
        // axis is turned about the upper arm by what its zero pose happened to be (CMU: 30°), so that
        // flexion shows about front too
        Role::Forearm(_) => Ball {
            bone: Bone::Own,
            axes: [Left, Front],
            ranges: [rom(-142.9, 0.6, 20.0), rom(0.0, 0.0, 85.0), rom(-82.1, 75.8, 30.0)],
        },
        // radial 21.5 (−) and ulnar 36.0 deviation about left; flexion 76.4 (−), extension 74.9 about front
        Role::Hand(_) => Ball {
            bone: Bone::Own,
            axes: [Left, Front],
            ranges: [rom(-21.5, 36.0, 20.0), rom(-76.4, 74.9, 20.0), rom(-82.1, 75.8, 65.0)],
        },
        // flexion 122.3 (−), extension 9.8 about left; adduction 26.9 (−), abduction 45.9 about front;
        // external (−) 47.2, internal 47.3 rotation
        Role::Thigh(_) => Ball {
            bone: Bone::Own,
            axes: [Left, Front],
            ranges: [rom(-122.3, 9.8, 35.0), rom(-26.9, 45.9, 45.0), rom(-47.2, 47.3, 30.0)],
        },
        // flexion 142.5 (+); a rig's knee axis is never quite the anatomical one
        Role::Shin(_) => Ball {
            bone: Bone::Own,
            axes: [Left, Front],
            ranges: [rom(0.0, 142.5, 15.0), rom(0.0, 0.0, 25.0), rom(-10.0, 10.0, 25.0)],
        },
        // dorsiflexion 12.6 (−), plantar flexion 56.2 about left; inversion 36.8 (−), eversion 20.7 about front
        Role::Foot(_) => Ball {
            bone: Bone::Front,
            axes: [Left, Up],
            ranges: [rom(-12.6, 56.2, 40.0), rom(-10.0, 10.0, 50.0), rom(-36.8, 20.7, 20.0)],
        },
        Role::Pelvis | Role::Finger(_) | Role::Toe(_) | Role::Helper | Role::Other => return None,
    })
}

/// Limits of the joint of `link`, relative to the skeleton's zero pose; `None` for joints without a
/// published range (root, helpers) and for slides.
pub fn joint_limits(
    skeleton: &Skeleton,
    anatomy: &Anatomy,
    neutral: &Neutral,
    neck: NeckShare,
    link: usize,
) -> Option<Limits> {
    let role = anatomy.roles[link];
    match skeleton.links()[link].joint {
        Joint::Spherical => Some(Limits::Ball(ball_limits(skeleton, anatomy, neutral, neck, link)?)),
        Joint::Revolute(axis) => {
            let bends = match role {
                Role::Forearm(_) => -neutral.left,
                Role::Shin(_) => neutral.left,
                _ => return None,
            };
            let world = zero_in_neutral(skeleton, neutral, link) * axis;
            let sign = world.dot(&bends).signum();
            let [lo, hi] = HINGE_DEG.map(f64::to_radians);
            let q0 = neutral_angle(skeleton, neutral, link, &axis);
            Some(Limits::Axis(if sign > 0.0 {
                Range::new(q0 + lo, q0 + hi)
            } else {
                Range::new(q0 - hi, q0 - lo)
            }))
        }
        _ => None,
    }
}

/// Rotation of a ball joint at the centre of its ranges; `None` for joints without a published range.
pub fn center_rotation(
    skeleton: &Skeleton,
    anatomy: &Anatomy,
    neutral: &Neutral,
    link: usize,
) -> Option<Quat> {
    let role = anatomy.roles[link];
    let center = center_in_world(ball(role)?, role, neutral, link);
    Some(zero_in_neutral(skeleton, neutral, link).inverse() * center)
}

fn center_in_world(kind: Ball, role: Role, neutral: &Neutral, link: usize) -> Quat {
    let lift = match (kind.bone, role.side()) {
        (Bone::Sideways, Some(side)) => exp(&(neutral.front * (side.sign() * 0.5 * PI))),
        _ => Quat::identity(),
    };
    lift * neutral.rotation[link]
}

/// World rotation of the joint's zero frame while the parent is in its neutral pose.
fn zero_in_neutral(skeleton: &Skeleton, neutral: &Neutral, link: usize) -> Quat {
    let l = &skeleton.links()[link];
    l.parent.map_or(Quat::identity(), |p| neutral.rotation[p]) * l.parent_from_zero.rotation
}

/// Joint rotation in the neutral pose.
pub fn neutral_rotation(skeleton: &Skeleton, neutral: &Neutral, link: usize) -> Quat {
    zero_in_neutral(skeleton, neutral, link).inverse() * neutral.rotation[link]
}

fn neutral_angle(skeleton: &Skeleton, neutral: &Neutral, link: usize, axis: &Vec3) -> f64 {
    log(&neutral_rotation(skeleton, neutral, link)).dot(axis)
}

fn ball_limits(
    skeleton: &Skeleton,
    anatomy: &Anatomy,
    neutral: &Neutral,
    neck: NeckShare,
    link: usize,
) -> Option<BallLimits> {
    let role = anatomy.roles[link];
    let kind = ball(role)?;
    let mirror = role.side() == Some(Side::Right);
    let part = part(anatomy, role, neck);
    let mut ranges: [[f64; 2]; 3] = std::array::from_fn(|k| {
        let r = kind.ranges[k].widened(part[k]).map(f64::to_radians);
        let flips = mirror && (k == 2 || kind.axes[k] != Axis::Left);
        if flips { [-r[1], -r[0]] } else { r }
    });

    // The centre: world rotation of the link, and its bone and axes there.
    let center = center_in_world(kind, role, neutral, link);
    let own = center * neutral.bone[link];
    let bone = match kind.bone {
        Bone::Front => neutral.front,
        _ if own.norm() > 1e-6 => own.normalize(),
        _ => UP,
    };
    let world = |a: Axis| match a {
        Axis::Left => neutral.left,
        Axis::Up => UP,
        Axis::Front => neutral.front,
    };
    // Gram–Schmidt against the bone, which is only nearly normal to the body's axes.
    let a0 = world(kind.axes[0]);
    let a0 = (a0 - bone * a0.dot(&bone)).normalize();
    let a1 = world(kind.axes[1]);
    let mut a1 = (a1 - bone * a1.dot(&bone) - a0 * a1.dot(&a0)).normalize();
    // Right-handed, so that the axes are also the columns of a rotation.
    if a0.cross(&a1).dot(&bone) < 0.0 {
        a1 = -a1;
        ranges[1] = [-ranges[1][1], -ranges[1][0]];
    }

    let to_zero = zero_in_neutral(skeleton, neutral, link).inverse();
    let q_center = to_zero * center;
    let about_center = BallLimits {
        axes: [a0, a1, bone].map(|a| to_zero * a),
        ranges: ranges.map(|r| Range::new(r[0].max(-BOUND), r[1].min(BOUND))),
    };
    Some(about_zero(&about_center, &q_center))
}

/// Ranges end short of ±π, where swing and twist are not unique.
const BOUND: f64 = 179.0 * PI / 180.0;

/// The limits `r` allows for `q · center⁻¹`, as a box of coordinates of `q`.
///
/// The axes are carried back by the centre, so that the bone stays the bone. Exact for a centre that
/// is the identity, else the smallest box that holds the allowed rotations of a polar grid:
/// swings from within an ellipse in each quadrant, since no joint takes both swings to their ends.
fn about_zero(r: &BallLimits, center: &Quat) -> BallLimits {
    let mut out = BallLimits { axes: r.axes.map(|a| center.inverse() * a), ranges: r.ranges };
    if log(center).norm() < 1e-9 {
        return out;
    }
    const TURNS: i32 = 48;
    const RINGS: i32 = 8;
    let mut lo = Vec3::repeat(f64::INFINITY);
    let mut hi = -lo;
    let scaled = |r: &Range, x: f64| if x > 0.0 { x * r.hi } else { -x * r.lo };
    for turn in 0..TURNS {
        let (sin, cos) = (2.0 * PI * f64::from(turn) / f64::from(TURNS)).sin_cos();
        for ring in 0..=RINGS {
            let radius = f64::from(ring) / f64::from(RINGS);
            let (x, y) = (scaled(&r.ranges[0], radius * cos), scaled(&r.ranges[1], radius * sin));
            for twist in [r.ranges[2].lo, 0.5 * (r.ranges[2].lo + r.ranges[2].hi), r.ranges[2].hi] {
                let phi = out.coords(&(r.rotation(&Vec3::new(x, y, twist)) * center));
                lo = lo.inf(&phi);
                hi = hi.sup(&phi);
            }
        }
    }
    for k in 0..3 {
        // A range that crosses half a turn has no ends: that coordinate is free.
        let wraps = lo[k] < -BOUND || hi[k] > BOUND;
        out.ranges[k] = if wraps { Range::new(-PI, PI) } else { Range::new(lo[k], hi[k]) };
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::anthropometry::human::human;

    fn turns() -> impl Iterator<Item = Quat> {
        (0..4000).map(|i| {
            let f = f64::from(i);
            let axis = Vec3::new((f * 1.37).sin(), (f * 0.71).cos(), (f * 2.13).sin());
            exp(&(axis.normalize() * (f * 0.618).fract() * 3.1))
        })
    }

    /// Right is the mirror image of left: a rotation is allowed on one side exactly if its mirror image is
    /// on the other.
    #[test]
    fn sides_are_mirror_images() {
        let (c, _) = human();
        for name in ["clavicle", "shoulder", "wrist", "hip", "ankle"] {
            let of = |side: &str| match c.skeleton.links()
                [c.skeleton.link(&format!("{name}_{side}")).unwrap()]
            .limits
            {
                Some(Limits::Ball(b)) => b,
                _ => panic!("{name}"),
            };
            let (left, right) = (of("l"), of("r"));
            let (mut inside, mut outside) = (0, 0);
            for q in turns() {
                // reflection in x = 0 keeps the x of an axial vector and turns y and z round
                let m = Quat::new_unchecked(nalgebra::Quaternion::new(q.w, q.i, -q.j, -q.k));
                let allowed = left.clamp(&q) == q;
                assert_eq!(allowed, right.clamp(&m) == m, "{name} {q:?}");
                *(if allowed { &mut inside } else { &mut outside }) += 1;
            }
            assert!(inside > 20 && outside > 100, "{name}: {inside} {outside}");
        }
    }

    /// Named movements of the figure, degrees about world axes from the zero pose: the published range is
    /// allowed, well beyond it is not.
    #[test]
    fn published_movements_are_allowed() {
        let (c, _) = human();
        let (x, y, z) = (Vec3::x(), Vec3::y(), Vec3::z());
        for (joint, axis, allowed, forbidden) in [
            ("hip_l", -x, 122.3, 170.0), // flexion
            ("hip_l", x, 9.8, 60.0),     // extension
            ("hip_l", z, 45.9, 110.0),   // abduction
            ("hip_r", -z, 45.9, 110.0),
            ("ankle_l", x, 56.2, 110.0),      // plantar flexion
            ("ankle_l", -x, 12.6, 60.0),      // dorsiflexion
            ("ankle_l", -z, 36.8, 70.0),      // inversion
            ("shoulder_l", -y, 140.7, 178.0), // horizontal flexion
            ("shoulder_r", y, 140.7, 178.0),
            ("shoulder_l", z, 84.0, 150.0),   // abduction beyond sideways
            ("shoulder_l", -z, 90.0, 150.0),  // hanging
            ("shoulder_l", x, 68.8, 150.0),   // internal rotation
            ("shoulder_l", -x, 103.7, 170.0), // external rotation
            ("wrist_l", -z, 76.4, 120.0),     // flexion
            ("head", y, 49.0, 60.0),          // turning: 45 of 77 parts of 85
            ("neck", y, 35.0, 45.0),
            ("chest", x, 60.0, 100.0), // bending forward
        ] {
            let i = c.skeleton.link(joint).unwrap();
            let Some(Limits::Ball(b)) = c.skeleton.links()[i].limits else { panic!("{joint}") };
            let passes = |deg: f64| {
                let q = exp(&(axis * deg.to_radians()));
                b.clamp(&q) == q
            };
            assert!(passes(allowed), "{joint} {axis:?} {allowed}");
            assert!(!passes(forbidden), "{joint} {axis:?} {forbidden}");
        }
    }

    /// Neck and head of the figure turn as far as a neck, not twice as far: their ranges add up to the published one with
    /// its allowance. A rig's joints get more.
    #[test]
    fn neck_and_head_share_one_range() {
        let (c, _) = human();
        let of = |name: &str| match c.skeleton.links()[c.skeleton.link(name).unwrap()].limits {
            Some(Limits::Ball(b)) => b.ranges.map(|r| [r.lo.to_degrees(), r.hi.to_degrees()]),
            _ => panic!("{name}"),
        };
        let (neck, head) = (of("neck"), of("head"));
        println!("neck {neck:.1?}, head {head:.1?}");
        for (k, whole) in [80.0, 65.0, 85.0].into_iter().enumerate() {
            for (side, sign) in [(0, -1.0), (1, 1.0)] {
                let both = neck[k][side] + head[k][side];
                assert!((both - sign * whole).abs() < 1e-9, "{k}: {both}");
            }
        }
        assert!(
            head[2][1] > neck[2][1] && head[1][1] < neck[1][1],
            "turning is the skull's, bending the neck's"
        );
        assert!(2.0 * rig_share(2) > 1.0);
    }

    /// About another zero, every rotation the limits allow is still allowed.
    #[test]
    fn moving_the_zero_forbids_nothing() {
        let limits = BallLimits {
            axes: [Vec3::x(), Vec3::z(), -Vec3::y()],
            ranges: [Range::new(-2.1, 0.7), Range::new(-0.9, 1.2), Range::new(-0.8, 0.8)],
        };
        for center in [Vec3::z() * 0.35, Vec3::new(0.3, 0.5, -0.4), Vec3::x() * -1.2] {
            let center = exp(&center);
            let moved = about_zero(&limits, &center);
            for i in 0..500 {
                let f = f64::from(i);
                // inside the ellipse of swings, twist anywhere
                let (r, a) = ((f * 0.618).fract().sqrt() * 0.98, f * 2.4);
                let pick = |r: &Range, u: f64| if u > 0.0 { u * r.hi } else { -u * r.lo };
                let phi = Vec3::new(
                    pick(&limits.ranges[0], r * a.cos()),
                    pick(&limits.ranges[1], r * a.sin()),
                    pick(&limits.ranges[2], (f * 0.37).fract() * 1.96 - 0.98),
                );
                let q = limits.rotation(&phi) * center;
                assert!(moved.clamp(&q).angle_to(&q) < 1e-6, "{phi:?} about {center:?}");
            }
        }
    }
}
