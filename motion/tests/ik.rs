//! Laws of two-bone inverse kinematics: the target is met, the rest is kept.

use motion::ik::{IkError, Reach, reach_range, solve_two_bone, solve_two_bone_oriented};
use motion::rotation::{between, exp, log};
use motion::{Joint, Kinematics, Limb, LimbKind, Limits, Link, Quat, Range, Skeleton, Transform, Vec3};

const HIP: usize = 1;
const KNEE: usize = 3;
const FOOT: usize = 4;

/// A leg with general offsets, a welded link in the thigh, turned zero frames; the knee as asked.
fn leg(knee: Joint, limits: Option<(f64, f64)>, straight: bool) -> (Skeleton, Limb) {
    let bow = if straight { Vec3::zeros() } else { Vec3::new(0.02, 0.0, 0.03) };
    let mut links = vec![
        Link::new("pelvis", None, Vec3::zeros(), Joint::Free),
        Link::new("thigh", Some(0), Vec3::new(0.09, -0.07, 0.01), Joint::Spherical),
        Link::new("twist", Some(1), Vec3::new(0.0, -0.2, 0.0) + bow, Joint::Fixed),
        Link::new("shin", Some(2), Vec3::new(0.0, -0.22, 0.0), knee),
        Link::new("foot", Some(3), Vec3::new(0.0, -0.41, 0.0) - bow * 0.5, Joint::Spherical),
    ];
    if !straight {
        links[1].parent_from_zero.rotation = exp(&Vec3::new(0.05, 0.3, -0.1));
        links[4].parent_from_zero.rotation = exp(&Vec3::new(-0.2, 0.1, 0.4));
    }
    links[3].limits = limits.map(|(lo, hi)| Limits::Axis(Range::new(lo, hi)));
    let limb = Limb { name: "leg_l".into(), kind: LimbKind::Leg, upper: HIP, lower: KNEE, end: FOOT };
    (Skeleton::new(links).unwrap(), limb)
}

fn hinge() -> Joint {
    Joint::Revolute(Vec3::x())
}

fn pose(s: &Skeleton, bend: f64) -> Vec<f64> {
    let mut q = s.zero_pose();
    s.set_position(&mut q, 0, &Vec3::new(0.3, 0.9, -0.2));
    s.set_rotation(&mut q, 0, &exp(&Vec3::new(0.1, 0.6, -0.05)));
    s.set_rotation(&mut q, HIP, &exp(&Vec3::new(-0.5 * bend, 0.1, 0.08)));
    match s.links()[KNEE].joint {
        Joint::Spherical => s.set_rotation(&mut q, KNEE, &exp(&Vec3::new(bend, 0.02 * bend, 0.0))),
        _ => q[s.q_at(KNEE)] = bend,
    }
    s.set_rotation(&mut q, FOOT, &exp(&Vec3::new(0.2, -0.1, 0.05)));
    q
}

fn foot(s: &Skeleton, q: &[f64]) -> Vec3 {
    Kinematics::new(s, q).origin(FOOT)
}

fn joints() -> [(Skeleton, Limb); 4] {
    [
        leg(hinge(), Some((0.0, 2.5)), false),
        leg(hinge(), None, false),
        leg(Joint::Spherical, None, false),
        leg(Joint::Revolute(Vec3::new(0.9, 0.3, -0.2).normalize()), None, false),
    ]
}

/// Targets all around within reach are met. 2e-15 m seen.
#[test]
fn reachable_targets_are_reached() {
    let mut worst = 0.0_f64;
    for (s, limb) in joints() {
        for i in 0..500 {
            let f = f64::from(i);
            let mut q = pose(&s, 0.3 + 0.9 * (f * 0.61).sin().abs());
            let (least, most) = reach_range(&s, &q, &limb).unwrap();
            let d = least + (most - least) * (0.01 + 0.98 * (f * 0.37).sin().abs());
            let towards = Vec3::new((f * 1.3).sin(), (f * 0.77).cos() - 0.4, (f * 2.1).sin()).normalize();
            let target = Kinematics::new(&s, &q).origin(HIP) + towards * d;
            assert_eq!(solve_two_bone(&s, &mut q, &limb, &target), Ok(Reach::Reached));
            worst = worst.max((foot(&s, &q) - target).norm());
        }
    }
    assert!(worst < 1e-9, "{worst}");
}

/// The target the foot is at already leaves the pose alone. 1e-15 rad seen.
#[test]
fn the_present_position_changes_nothing() {
    for (s, limb) in joints() {
        for bend in [0.3, 0.8, 1.7] {
            let before = pose(&s, bend);
            let mut q = before.clone();
            let target = foot(&s, &q);
            solve_two_bone(&s, &mut q, &limb, &target).unwrap();
            let change = q.iter().zip(&before).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(change < 1e-12, "{change}");
        }
    }
}

/// Moving the target along the line from the hip turns the knee within the plane of the leg.
#[test]
fn swivel_is_kept() {
    for knee in [hinge(), Joint::Spherical] {
        let (s, limb) = leg(knee, None, true);
        let normal = |q: &[f64]| {
            let k = Kinematics::new(&s, q);
            (k.origin(KNEE) - k.origin(HIP)).cross(&(k.origin(FOOT) - k.origin(KNEE))).normalize()
        };
        let before = pose(&s, 0.8);
        let hip = Kinematics::new(&s, &before).origin(HIP);
        for stretch in [0.5, 0.8, 1.05] {
            let mut q = before.clone();
            let target = hip + (foot(&s, &q) - hip) * stretch;
            solve_two_bone(&s, &mut q, &limb, &target).unwrap();
            assert!((normal(&q) - normal(&before)).norm() < 1e-9, "{stretch}");
        }
    }
}

#[test]
fn orientation_of_the_end_is_kept() {
    for (s, limb) in joints() {
        let mut q = pose(&s, 0.7);
        let world = Kinematics::new(&s, &q).world[FOOT];
        // the pelvis sinks and leans, the foot stays
        s.set_position(&mut q, 0, &Vec3::new(0.33, 0.86, -0.17));
        s.set_rotation(&mut q, 0, &exp(&Vec3::new(0.3, 0.5, 0.1)));
        assert_eq!(solve_two_bone_oriented(&s, &mut q, &limb, &world), Ok(Reach::Reached));
        let after = Kinematics::new(&s, &q).world[FOOT];
        assert!((after.translation.vector - world.translation.vector).norm() < 1e-12);
        assert!(log(&(after.rotation * world.rotation.inverse())).norm() < 1e-12);
    }
}

/// A straight leg that must shorten bends its knee forward, whether limits or anatomy say so.
#[test]
fn knees_bend_forward() {
    for (knee, limits) in
        [(hinge(), Some((0.0, 2.5))), (hinge(), Some((-0.2, 2.5))), (Joint::Spherical, None)]
    {
        let (s, limb) = leg(knee, limits, true);
        for bend in [0.0, 1e-9, -1e-3, 1e-3] {
            let mut q = s.zero_pose();
            match knee {
                Joint::Spherical => s.set_rotation(&mut q, KNEE, &exp(&Vec3::new(bend, 0.0, 0.0))),
                _ => q[s.q_at(KNEE)] = bend,
            }
            let target = foot(&s, &q) + Vec3::new(0.0, 0.1, 0.0);
            assert_eq!(solve_two_bone(&s, &mut q, &limb, &target), Ok(Reach::Reached));
            let k = Kinematics::new(&s, &q);
            assert!(k.origin(KNEE).z > k.origin(HIP).z + 0.1, "{knee:?} {bend}: {}", k.origin(KNEE));
        }
    }
}

/// Near full stretch a micrometre of target moves the joints by milliradians, not by a flip: the bend is
/// √(2Δ(l₁+l₂)/(l₁l₂)) and no more, below and beyond the limit of reach.
#[test]
fn nearly_straight_legs_are_steady() {
    for (knee, limits) in [(hinge(), Some((0.0, 2.5))), (hinge(), None), (Joint::Spherical, None)] {
        let (s, limb) = leg(knee, limits, true);
        let start = pose(&s, 0.01);
        let hip = Kinematics::new(&s, &start).origin(HIP);
        let towards = (foot(&s, &start) - hip).normalize();
        let (_, most) = reach_range(&s, &start, &limb).unwrap();
        let mut last: Option<Vec<f64>> = None;
        for i in -50..=50 {
            let mut q = start.clone();
            let wobble = Vec3::new(1e-6, 0.0, -1e-6) * f64::from(i % 3);
            solve_two_bone(&s, &mut q, &limb, &(hip + towards * (most + 1e-6 * f64::from(i)) + wobble))
                .unwrap();
            if let Some(last) = last {
                let change = q.iter().zip(&last).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                let bound = (2.0 * 1e-6 * 0.83 / (0.42 * 0.41_f64)).sqrt();
                assert!(change < 1.5 * bound, "{knee:?} step {i}: {change}"); // 3.3e-3 seen
            }
            last = Some(q);
        }
    }
}

#[test]
fn unreachable_targets_are_approached_and_said() {
    let (s, limb) = leg(hinge(), Some((0.0, 1.2)), true);
    let q0 = pose(&s, 0.4);
    let hip = Kinematics::new(&s, &q0).origin(HIP);
    let (least, most) = reach_range(&s, &q0, &limb).unwrap();
    assert!((most - 0.83).abs() < 1e-12);
    let at_limit = (0.42_f64.powi(2) + 0.41_f64.powi(2) + 2.0 * 0.42 * 0.41 * 1.2_f64.cos()).sqrt();
    assert!((least - at_limit).abs() < 1e-12);
    let towards = Vec3::new(0.2, -0.9, 0.3).normalize();
    for (d, bend) in [(most + 0.05, 0.0), (least - 0.05, 1.2), (0.0, 1.2)] {
        let mut q = q0.clone();
        let Ok(Reach::Clamped { residue_m }) = solve_two_bone(&s, &mut q, &limb, &(hip + towards * d)) else {
            panic!("{d}")
        };
        assert!((residue_m - (d - d.clamp(least, most)).abs()).abs() < 1e-9, "{residue_m}");
        assert!((q[s.q_at(KNEE)] - bend).abs() < 1e-7);
        if d > 0.0 {
            let direction = (foot(&s, &q) - hip).normalize();
            assert!(log(&between(&direction, &towards)).norm() < 1e-9);
        }
    }
}

#[test]
fn limbs_that_do_not_fit_are_refused() {
    let (s, limb) = leg(Joint::Fixed, None, true);
    let mut q = s.zero_pose();
    assert!(matches!(solve_two_bone(&s, &mut q, &limb, &Vec3::zeros()), Err(IkError::Joint { .. })));
    let (s, limb) = leg(hinge(), None, true);
    let mut q = s.zero_pose();
    let turned = Limb { upper: KNEE, lower: HIP, ..limb.clone() };
    assert!(solve_two_bone(&s, &mut q, &turned, &Vec3::zeros()).is_err());
    let nowhere = Vec3::new(f64::NAN, 0.0, 0.0);
    assert_eq!(solve_two_bone(&s, &mut q, &limb, &nowhere), Err(IkError::NotFinite("leg_l".into())));
    let at = Transform::from_parts(Vec3::new(0.1, 0.2, 0.0).into(), Quat::identity());
    let wrong = Limb { end: 2, ..limb };
    assert!(solve_two_bone_oriented(&s, &mut q, &wrong, &at).is_err());
}
