//! Laws of poses dragged, and dragged in time: identity, blends, blocks, layers, contacts, refusals.

use edits::{Motion, PoseChange, PoseDelta, PoseRequest, TimeDelta, Where};
use motion::rotation::{self, exp};
use motion::{Clip, ContactPlan, Joint, Kinematics, Link, Skeleton, TimeMap, Vec3};
use std::sync::Arc;

use crate::clip_body::{RATE_HZ, WALK, danced, edited, refused};

/// A trunk with an arm of two bones that waves while it walks: 4 s.
fn waving() -> Motion {
    let ball = Joint::Spherical;
    let links = vec![
        Link::new("pelvis", None, Vec3::zeros(), Joint::Free),
        Link::new("chest", Some(0), Vec3::new(0.0, 0.4, 0.0), ball),
        Link::new("shoulder", Some(1), Vec3::new(-0.2, 0.2, 0.0), ball),
        Link::new("elbow", Some(2), Vec3::new(-0.3, 0.0, 0.02), ball),
        Link::new("wrist", Some(3), Vec3::new(-0.25, 0.0, 0.0), ball),
    ];
    let s = Arc::new(Skeleton::new(links).unwrap());
    let mut q = Vec::new();
    for i in 0..=200 {
        let t = f64::from(i) / RATE_HZ;
        let mut pose = s.zero_pose();
        s.set_position(&mut pose, 0, &Vec3::new(0.1, 0.9, t));
        s.set_rotation(&mut pose, 2, &exp(&Vec3::new(0.2, 0.1 * t, 0.4 * (3.0 * t).sin())));
        s.set_rotation(&mut pose, 3, &exp(&Vec3::new(0.0, -0.6, 0.2 * (5.0 * t).cos())));
        q.extend(pose);
    }
    Motion { contacts: WALK.contacts.clone(), ..Motion::of(Clip::new(s, RATE_HZ, q)) }
}

fn wrist(clip: &Clip, frame: usize) -> Vec3 {
    Kinematics::new(&clip.skeleton, clip.pose(frame)).origin(4)
}

/// The wrist dragged at 2 s, the pelvis pinned.
fn dragged(by: Vec3, blend_s: f64, block_s: Option<(f64, f64)>) -> PoseDelta {
    let to = wrist(&waving().clip, 100) + by;
    let drag = vec![("wrist".to_owned(), [to.x, to.y, to.z])];
    let request = PoseRequest { drag, pin: vec!["pelvis".into()], ..PoseRequest::default() };
    PoseDelta { at_s: 2.0, change: PoseChange::Asked(request), blend_s, block_s }
}

const BY: Vec3 = Vec3::new(0.1, 0.15, 0.1);

#[test]
fn nothing_asked_is_the_identity_to_the_bit() {
    for motion in [&waving(), &*WALK, &danced()] {
        let nv = motion.clip.skeleton.nv();
        let zero = PoseChange::Delta { delta: vec![0.0; nv], limits: true };
        let delta = PoseDelta { at_s: 1.0, change: zero, blend_s: 0.5, block_s: Some((0.5, 1.5)) };
        for (edited, log) in [
            edited(&delta, motion, &Where::default()),
            edited(&TimeDelta { at_s: 1.0, to_s: 1.0, blend_s: 0.3 }, motion, &Where::default()),
        ] {
            assert_eq!(format!("{:?}", edited.clip), format!("{:?}", motion.clip));
            assert_eq!((&edited.contacts, edited.times), (&motion.contacts, TimeMap::identity()));
            assert!(log.clip_changes().is_empty() && log.notes().is_empty());
        }
    }
    // a joint dragged to where it is
    let (motion, none) = (waving(), dragged(Vec3::zeros(), 0.3, None));
    let (edited, log) = edited(&none, &motion, &Where::default());
    assert_eq!(format!("{:?}", edited.clip), format!("{:?}", motion.clip));
    assert!(log.clip_changes().is_empty());
}

/// At its time the joint is where it was dragged; outside the blend nothing changes, to the bit; in it joints go over smoothly.
#[test]
fn a_pose_is_met_and_blended() {
    let motion = waving();
    let (edited, log) = edited(&dragged(BY, 0.4, None), &motion, &Where::default());
    let miss = (wrist(&edited.clip, 100) - wrist(&motion.clip, 100) - BY).norm();
    assert!(miss < 2e-3, "{miss}");
    let pelvis = |clip: &Clip| clip.skeleton.position(clip.pose(100), 0);
    assert!((pelvis(&edited.clip) - pelvis(&motion.clip)).norm() < 1e-6);
    let same = |f: usize| assert_eq!(edited.clip.pose(f), motion.clip.pose(f), "{f}");
    (0..=80).chain(120..=200).for_each(same);
    let s = &motion.clip.skeleton;
    let share = |f: usize| {
        let turn = |clip: &Clip| s.rotation(clip.pose(f), 2);
        rotation::log(&(turn(&edited.clip) * turn(&motion.clip).inverse())).norm()
    };
    let whole = share(100);
    for f in 81..100 {
        let u = (f as f64 - 80.0) / 20.0;
        let wanted = whole * u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u);
        assert!((share(f) - wanted).abs() < 1e-12 && (share(200 - f) - wanted).abs() < 1e-12, "{f}");
    }
    assert_eq!((edited.contacts, edited.times), (motion.contacts.clone(), TimeMap::identity()));
    let change = &log_change(&log);
    assert!(change.starts_with("1.620 s to 2.380 s"), "{change}");
}

fn log_change(log: &edits::EditLog) -> String {
    log.clip_changes()[0].to_string()
}

/// Over a block every frame is changed by the same rotations; a span makes blends shorter; parts keep their joints.
#[test]
fn blocks_spans_and_parts() {
    let motion = waving();
    let s = motion.clip.skeleton.clone();
    let (blocked, _) = edited(&dragged(BY, 0.2, Some((1.6, 2.6))), &motion, &Where::default());
    let turn = |clip: &Clip, f: usize, link: usize| {
        rotation::log(&(s.rotation(clip.pose(f), link) * s.rotation(motion.clip.pose(f), link).inverse()))
    };
    for f in 80..=130 {
        for link in 1..4 {
            let apart = (turn(&blocked.clip, f, link) - turn(&blocked.clip, 100, link)).norm();
            assert!(apart < 1e-12, "{f} {link}: {apart}");
        }
    }
    let (bounded, _) = edited(&dragged(BY, 0.8, None), &motion, &Where::span(1.9, 2.2));
    let changed: Vec<usize> = (0..=200).filter(|&f| bounded.clip.pose(f) != motion.clip.pose(f)).collect();
    assert_eq!((changed[0], changed[changed.len() - 1]), (96, 109));
    let (part, _) = edited(&dragged(BY, 0.3, None), &motion, &Where::default().of(["elbow"]));
    assert_eq!(s.rotation(part.clip.pose(100), 2), s.rotation(motion.clip.pose(100), 2));
    assert!(turn(&part.clip, 100, 3).norm() > 0.01);
}

/// y(t) = x(t + k(t)): the pose comes when it was dragged to, the length stays, contacts follow; a second layer takes it back.
#[test]
fn a_pose_is_dragged_in_time() {
    let motion = waving();
    let later = TimeDelta { at_s: 2.0, to_s: 2.2, blend_s: 0.6 };
    let (edited_once, log) = edited(&later, &motion, &Where::default());
    assert_eq!(edited_once.clip.frames(), motion.clip.frames());
    let apart = edited_once.clip.pose(110).iter().zip(motion.clip.pose(100)).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-12);
    let same = |f: usize| assert_eq!(edited_once.clip.pose(f), motion.clip.pose(f), "{f}");
    (0..=70).chain(130..=200).for_each(same);
    let moved: ContactPlan = motion.contacts.retimed(&edited_once.times);
    assert_eq!(edited_once.contacts, moved);
    assert_ne!(moved, motion.contacts);
    assert!(log.clip_changes()[0].slopes.is_some() && log.clip_changes()[0].joints.is_empty());
    let once = motion.clone().with(edited_once);
    let (back, _) = edited(&TimeDelta { at_s: 2.2, to_s: 2.0, blend_s: 0.6 }, &once, &Where::default());
    assert!((wrist(&back.clip, 100) - wrist(&motion.clip, 100)).norm() < 1e-12);
}

#[test]
fn refusals() {
    let motion = waving();
    let at = Where::default();
    let request = |drag: &[(&str, [f64; 3])], pin: &[&str]| PoseRequest {
        drag: drag.iter().map(|(n, p)| ((*n).to_owned(), *p)).collect(),
        pin: pin.iter().map(|n| (*n).to_owned()).collect(),
        ..PoseRequest::default()
    };
    let pose =
        |request| PoseDelta { at_s: 2.0, change: PoseChange::Asked(request), blend_s: 0.3, block_s: None };
    let words = |request| refused(&pose(request), &motion, &at);
    assert_eq!(
        words(request(&[], &["wrist"])),
        "pose-delta: nothing is dragged; name a joint and where it goes, as x, y, z in m, world, Y up"
    );
    assert!(
        words(request(&[("wrst", [0.0; 3])], &[])).starts_with("unknown joint `wrst`; did you mean `wrist`?")
    );
    assert_eq!(
        words(request(&[("wrist", [f64::NAN, 0.0, 0.0])], &[])),
        "pose-delta: a place of `wrist` is not finite"
    );
    assert!(words(request(&[("wrist", [9.0; 3])], &["wrist"])).contains("`wrist` is to be at two places"));
    let limits = PoseRequest { limits: true, ..request(&[("wrist", [0.0; 3])], &[]) };
    assert!(words(limits).contains("no joint of this body has limits"));
    let alone = PoseRequest { group: vec![vec!["elbow".into()]], ..request(&[("wrist", [0.0; 3])], &[]) };
    assert!(words(alone).contains("`elbow` is a piece alone"));
    let late = PoseDelta { at_s: 4.5, ..dragged(BY, 0.3, None) };
    assert_eq!(refused(&late, &motion, &at), "pose-delta: `at_s` is 4.5 s; allowed: 0.000 s to 4.000 s");
    assert!(
        refused(&dragged(BY, -1.0, None), &motion, &at)
            .contains("`blend_s` is -1; allowed: finite, 0 or more")
    );
    let short = TimeDelta { at_s: 2.0, to_s: 2.5, blend_s: 0.4 };
    assert_eq!(
        refused(&short, &motion, &at),
        "time-delta: the pose moves by 0.500 s, and has 0.400 s to do it in; `blend_s` must leave more room than it moves"
    );
}
