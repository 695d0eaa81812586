//! The standard figure: a man of 1.75 m and 75 kg with 19 links and 52 degrees of freedom.
//!
//! In: nothing. Out: a [`Character`], made by the same rules as any guessed body. `scenes` writes it to
//! `characters/human.ron`.
//!
//! Zero pose: standing upright, facing +Z, arms straight out sideways, palms down, legs vertical, soles
//! on height 0 when the pelvis is at [`PELVIS_HEIGHT`]; all zero frames parallel to the world. Links
//! are named after their joints. Elbows and knees are hinges; positive angles bend them.
//!
//! Lengths in statures are those of \[DC66\] as drawn in \[Win09, Fig. 4.1\] unless said otherwise.
//!
//! \[DC66\] R. Drillis, R. Contini. Body segment parameters. NYU Tech. Rep. 1166.03, 1966.
//! \[deL96\] P. de Leva, see [`segments`](super::segments).
//! \[Win09\] D. A. Winter. Biomechanics and motor control of human movement, 4th ed., Wiley, 2009.

use motion::{Joint, Link, Skeleton, Vec3};

use super::guess::{BodyOptions, BodyReport, guess_body};
use super::limits::NeckShare;
use super::segments::MALE;
use super::shapes::FLESH_UNDER_FOOT;
use crate::Character;

/// Stature, m.
pub const STATURE: f64 = 1.75;
/// Mass, kg.
pub const MASS: f64 = 75.0;
/// Height of the pelvis in the zero pose, m: the hips, at 0.530 statures.
pub const PELVIS_HEIGHT: f64 = 0.9275;

/// Link, parent, offset from the parent's joint (left, up, front; mm), joint; the left side of pairs.
///
/// Heights above the ground in statures [Win09]: ankle 0.039 (68 mm), knee 0.285 (499), hip 0.530 (928),
/// shoulder 0.818 (1432), crown 1. Upper arm and forearm, between joint centres, are those of \[deL96\]
/// (281.7 and 268.9 of 1741 mm: 283 and 270); the hand is 0.108 statures \[Win09\]. Chosen here, as no
/// table has them: joint centres of the shoulders at ±185 mm, 4 cm inside the outline (0.129
/// statures), and of the hips at ±87; the trunk bends at L5/S1, 104 above the hips, and T12/L1, another
/// 180; the neck at C7/T1, 530 above the hips, and the base of the skull, another 96.
const LINKS: [(&str, &str, [f64; 3], Kind); 12] = [
    ("pelvis", "", [0.0, 0.0, 0.0], Kind::Free),
    ("abdomen", "pelvis", [0.0, 104.0, -8.0], Kind::Ball),
    ("chest", "abdomen", [0.0, 180.0, -6.0], Kind::Ball),
    ("neck", "chest", [0.0, 246.0, -4.0], Kind::Ball),
    ("head", "neck", [0.0, 96.0, 18.0], Kind::Ball),
    ("clavicle", "chest", [22.0, 216.0, 8.0], Kind::Ball),
    ("shoulder", "clavicle", [163.0, 4.0, -12.0], Kind::Ball),
    ("elbow", "shoulder", [283.0, 0.0, 0.0], Kind::Elbow),
    ("wrist", "elbow", [270.0, 0.0, 0.0], Kind::Ball),
    ("hip", "pelvis", [87.0, 0.0, 0.0], Kind::Ball),
    ("knee", "hip", [0.0, -429.0, 0.0], Kind::Knee),
    ("ankle", "knee", [0.0, -430.25, 0.0], Kind::Ball),
];

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Free,
    Ball,
    Elbow,
    Knee,
}

/// The skeleton of the figure, without limits and sites.
fn skeleton() -> Skeleton {
    let mut links: Vec<Link> = Vec::new();
    // Trunk and head first, then each limb whole: left arm, right arm, left leg, right leg.
    let trunk = LINKS[..5].iter().map(|l| (l, ""));
    let arms = ["_l", "_r"].into_iter().flat_map(|s| LINKS[5..9].iter().map(move |l| (l, s)));
    let legs = ["_l", "_r"].into_iter().flat_map(|s| LINKS[9..].iter().map(move |l| (l, s)));
    for (&(name, parent, mm, kind), side) in trunk.chain(arms).chain(legs) {
        let x = if side == "_r" { -1.0 } else { 1.0 };
        let at = Vec3::new(mm[0] * x, mm[1], mm[2]) / 1000.0;
        let up = links
            .iter()
            .position(|l| l.name == format!("{parent}{side}"))
            .or_else(|| links.iter().position(|l| l.name == parent));
        let joint = match kind {
            Kind::Free => Joint::Free,
            Kind::Ball => Joint::Spherical,
            Kind::Elbow => Joint::Revolute(Vec3::y() * -x), // the hand goes forward
            Kind::Knee => Joint::Revolute(Vec3::x()),       // the foot goes back
        };
        links.push(Link::new(format!("{name}{side}"), up, at, joint));
    }
    // The sole is guessed a little below the end of the foot: end it where that gives the ground.
    let leg = -(LINKS[10].2[1] + LINKS[11].2[1]) / 1000.0;
    let ankle = PELVIS_HEIGHT - leg;
    let leg_stature = leg / (MALE.thigh.length + MALE.shank.length) * MALE.stature;
    for link in &mut links {
        link.end = match link.name.as_str() {
            // crown at the stature: neck and skull base are at 0.9275 + 0.530 + 0.096 m
            "head" => Some(Vec3::new(0.0, STATURE - PELVIS_HEIGHT - 0.626, 0.0)),
            "wrist_l" => Some(Vec3::new(0.189, 0.0, 0.0)),
            "wrist_r" => Some(Vec3::new(-0.189, 0.0, 0.0)),
            "ankle_l" | "ankle_r" => Some(Vec3::new(0.0, FLESH_UNDER_FOOT * leg_stature - ankle, 0.193)),
            _ => None,
        };
    }
    Skeleton::new(links).expect("the table above is a tree")
}

/// The figure and the report of how it was made.
pub fn human() -> (Character, BodyReport) {
    let options = BodyOptions {
        name: Some("human".into()),
        mass_kg: Some(MASS),
        neck: NeckShare::Vertebrae,
        ..BodyOptions::default()
    };
    let (mut c, report) = guess_body(&skeleton(), &options).expect("the figure is human-like");
    // Written masses are whole tenths of a gram; the pelvis takes what rounding leaves of 75 kg.
    let mut rest = MASS;
    for body in c.bodies.iter_mut().skip(1) {
        body.mass = (body.mass * 1e4).round() / 1e4;
        rest -= body.mass;
    }
    c.bodies[0].mass = (rest * 1e4).round() / 1e4;
    (c, report)
}

#[cfg(test)]
mod tests {
    use motion::{Kinematics, Limits};
    use nalgebra::Matrix3;

    use super::*;

    /// The promises of the module header and of issue 2.
    #[test]
    fn the_figure_is_what_it_says() {
        let (c, report) = human();
        println!("{report}");
        assert!((c.mass() - MASS).abs() < 1e-9, "{}", c.mass());
        assert!((report.stature - STATURE).abs() < 1e-9, "{}", report.stature);
        assert_eq!((c.skeleton.links().len(), c.skeleton.nv()), (19, 52));
        assert!(c.skeleton.links().iter().all(|l| l.parent_from_zero.rotation.angle() == 0.0));

        let mut zero = c.skeleton.zero_pose();
        c.skeleton.set_position(&mut zero, 0, &(Vec3::y() * PELVIS_HEIGHT));
        let k = Kinematics::new(&c.skeleton, &zero);
        for &s in &c.contacts {
            let site = &c.skeleton.sites()[s];
            let p = k.point(site.link, &site.at);
            assert!(p.y.abs() < 1e-9, "{} is at {p:?}", site.name);
        }
        let crown = c.skeleton.site("crown").unwrap();
        assert!((k.point(crown.link, &crown.at).y - STATURE).abs() < 1e-9);
        let length = |end: &str| {
            let s = c.skeleton.site(end).unwrap();
            k.point(s.link, &s.at).z
        };
        assert!(length("ball_l_in") - length("heel_l_in") <= 0.27);
        let mut clamped = zero.clone();
        assert!(!c.skeleton.clamp_to_limits(&mut clamped), "the zero pose is within the limits");
    }

    /// At rest: feet flat on the ground, centre of mass over the middle of the soles at a human height.
    #[test]
    fn rest_stands_in_balance() {
        let (c, report) = human();
        let k = Kinematics::new(&c.skeleton, &c.rest);
        let corners: Vec<Vec3> =
            c.contacts.iter().map(|&s| &c.skeleton.sites()[s]).map(|s| k.point(s.link, &s.at)).collect();
        for p in &corners {
            assert!(p.y.abs() < 1e-9, "{p:?}"); // 1e-16 seen
        }
        let middle = corners.iter().sum::<Vec3>() / corners.len() as f64;
        let com: Vec3 =
            c.bodies.iter().enumerate().map(|(i, b)| k.point(i, &b.com) * b.mass).sum::<Vec3>() / MASS;
        assert!((com - middle).x.abs() < 1e-6 && (com - middle).z.abs() < 1e-4, "{com:?} {middle:?}");
        assert!((0.55..0.58).contains(&report.com_height), "{}", report.com_height);
        let mut clamped = c.rest.clone();
        assert!(!c.skeleton.clamp_to_limits(&mut clamped), "rest is within the limits");
        let elbow = c.skeleton.link("elbow_l").unwrap();
        assert!((c.rest[c.skeleton.q_at(elbow)].to_degrees() - 10.0).abs() < 0.5);
        // Pitch inertia about the centre of mass: 10 to 15 kg·m² for a standing man.
        let mut inertia = Matrix3::zeros();
        for (i, b) in c.bodies.iter().enumerate() {
            let r = k.world[i].rotation.to_rotation_matrix();
            let d = k.point(i, &b.com) - com;
            inertia += r.matrix() * b.inertia * r.matrix().transpose();
            inertia += (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * b.mass;
        }
        println!("inertia about the centre of mass {inertia:.3} {:?}", c.rest);
        assert!((10.0..15.0).contains(&inertia[(0, 0)]), "{inertia}");
        assert!((0.8..2.0).contains(&inertia[(1, 1)]), "{inertia}");
    }

    /// Positive degrees bend elbows forward and knees backward, on both sides.
    #[test]
    fn hinges_bend_with_positive_angles() {
        let (c, _) = human();
        for (joint, end, toward) in [
            ("elbow_l", "wrist_l", Vec3::z()),
            ("elbow_r", "wrist_r", Vec3::z()),
            ("knee_l", "ankle_l", -Vec3::z()),
            ("knee_r", "ankle_r", -Vec3::z()),
        ] {
            let (j, e) = (c.skeleton.link(joint).unwrap(), c.skeleton.link(end).unwrap());
            let mut q = c.skeleton.zero_pose();
            q[c.skeleton.q_at(j)] = 0.5;
            let moved = Kinematics::new(&c.skeleton, &q).origin(e)
                - Kinematics::new(&c.skeleton, &c.skeleton.zero_pose()).origin(e);
            assert!(moved.dot(&toward) > 0.1, "{joint}: {moved:?}");
            let Some(Limits::Axis(range)) = c.skeleton.links()[j].limits else {
                panic!("{joint} has no range")
            };
            assert!(range.lo.abs() < 1e-9 && (range.hi.to_degrees() - 150.0).abs() < 1e-9, "{range:?}");
        }
    }
}
