//! Laws of pins: held, limits kept, what stands stands, nothing else outside the blends, both of two at once, misses said, refusals.

use std::sync::Arc;

use edits::{ClipEdit, EditLog, Edited, Motion, Pin, PinAt, Pins, PoseChange, PoseDelta, Where};
use motion::rotation::exp;
use motion::skeleton::LimbKind;
use motion::{Clip, Contact, ContactPlan, Joint, Kinematics, Limb, Limits, Link, Range, Skeleton, Vec3};

const RATE_HZ: f64 = 50.0;

/// A pelvis on a leg that stands, a chest, two arms whose elbows are hinges with limits, a head with eyes; 3 s, the chest turns.
fn body() -> Motion {
    let ball = Joint::Spherical;
    let mut links = vec![
        Link::new("pelvis", None, Vec3::zeros(), Joint::Free),
        Link::new("hip", Some(0), Vec3::zeros(), ball),
        Link::new("knee", Some(1), Vec3::new(0.0, -0.4, 0.01), Joint::Revolute(Vec3::x())),
        Link::new("ankle", Some(2), Vec3::new(0.0, -0.4, -0.01), ball),
        Link::new("chest", Some(0), Vec3::new(0.0, 0.3, 0.0), ball),
        Link::new("shoulder_l", Some(4), Vec3::new(0.2, 0.2, 0.0), ball),
        Link::new("elbow_l", Some(5), Vec3::new(0.3, 0.0, 0.0), Joint::Revolute(-Vec3::y())),
        Link::new("wrist_l", Some(6), Vec3::new(0.25, 0.0, 0.0), ball),
        Link::new("shoulder_r", Some(4), Vec3::new(-0.2, 0.2, 0.0), ball),
        Link::new("elbow_r", Some(8), Vec3::new(-0.3, 0.0, 0.0), Joint::Revolute(Vec3::y())),
        Link::new("wrist_r", Some(9), Vec3::new(-0.25, 0.0, 0.0), ball),
        Link::new("head", Some(4), Vec3::new(0.0, 0.3, 0.0), ball),
    ];
    for elbow in [6, 9] {
        links[elbow].limits = Some(Limits::Axis(Range::new(0.0, 2.5)));
    }
    links[11].end = Some(Vec3::y() * 0.2);
    let leg = Limb { name: "leg".into(), kind: LimbKind::Leg, upper: 1, lower: 2, end: 3 };
    let eyes = motion::Site { name: "eyes".into(), link: 11, at: Vec3::new(0.0, 0.1, 0.1) };
    let s = Skeleton::new(links).unwrap().with_limbs(vec![leg]).unwrap().with_sites(vec![eyes]).unwrap();
    let s = Arc::new(s);
    let mut q = Vec::new();
    for i in 0..=150 {
        let t = f64::from(i) / RATE_HZ;
        let mut pose = s.zero_pose();
        s.set_position(&mut pose, 0, &Vec3::new(0.0, 0.75, 0.0));
        pose[s.q_at(2)] = 0.5;
        s.set_rotation(&mut pose, 4, &exp(&Vec3::new(0.2, 0.5 * (2.0 * t).sin(), 0.0)));
        for elbow in [6, 9] {
            pose[s.q_at(elbow)] = 0.8;
        }
        q.extend(pose);
    }
    let stands = Contact { point: "leg".into(), from_s: 0.0, to_s: 3.0, world_from_point: None };
    let contacts = ContactPlan::new(vec![stands]).unwrap();
    Motion { contacts, ..Motion::of(Clip::new(s, RATE_HZ, q)) }
}

fn pin(point: &str, at: PinAt) -> Pin {
    Pin { point: point.into(), point_m: [0.0; 3], at, from_s: 1.0, to_s: 2.0, blend_s: 0.4 }
}

fn held(pins: Vec<Pin>, motion: &Motion) -> (Edited, EditLog) {
    let mut log = EditLog::default();
    let edited = Pins { pins }.apply(motion, &Where::default(), &mut log).unwrap();
    (edited, log)
}

fn place(clip: &Clip, f: usize, link: &str) -> Vec3 {
    Kinematics::new(&clip.skeleton, clip.pose(f)).origin(clip.skeleton.link(link).unwrap())
}

/// The largest over the frames of the span.
fn worst(of: impl Fn(usize) -> f64) -> f64 {
    (50..=100).map(of).fold(0.0, f64::max)
}

#[test]
fn two_hands_are_held_while_the_chest_turns() {
    let motion = body();
    let (l, r) = (Vec3::new(0.3, 1.1, 0.4), Vec3::new(-0.3, 1.1, 0.4));
    let (edited, log) =
        held(vec![pin("wrist_l", PinAt::World(l.into())), pin("wrist_r", PinAt::World(r.into()))], &motion);
    let clip = &edited.clip;
    let s = &clip.skeleton;
    let miss = worst(|f| (place(clip, f, "wrist_l") - l).norm().max((place(clip, f, "wrist_r") - r).norm()));
    assert!(miss < 1e-5, "{miss}"); // 1e-7 seen
    for f in 0..clip.frames() {
        let foot = (place(clip, f, "ankle") - place(&motion.clip, f, "ankle")).norm();
        assert!(foot < 1e-5, "{f}: {foot}"); // 1e-8 seen
        for elbow in [6, 9] {
            let x = clip.pose(f)[s.q_at(elbow)];
            assert!((-1e-9..=2.5 + 1e-9).contains(&x), "{f}: {x}");
        }
    }
    for f in (0..=30).chain(120..=150) {
        assert_eq!(clip.pose(f), motion.clip.pose(f), "{f}");
    }
    let text = log.to_string();
    assert!(text.contains("wrist_l held from 1.000 s to 2.000 s within"), "{text}");
}

#[test]
fn a_hand_is_held_on_a_link_that_moves_and_eyes_on_a_point() {
    let motion = body();
    let on = Vec3::new(0.1, 0.0, 0.15);
    let mark = Vec3::new(0.5, 1.0, 2.0);
    let pins =
        vec![pin("wrist_r", PinAt::Link("chest".into(), on.into())), pin("gaze", PinAt::World(mark.into()))];
    let (edited, _) = held(pins, &motion);
    let clip = &edited.clip;
    let k = |f: usize| Kinematics::new(&clip.skeleton, clip.pose(f));
    let miss = worst(|f| (place(clip, f, "wrist_r") - k(f).point(4, &on)).norm());
    assert!(miss < 1e-5, "{miss}");
    let off = worst(|f| {
        let way = mark - k(f).point(11, &Vec3::new(0.0, 0.1, 0.1));
        let sight = k(f).world[11].rotation * Vec3::z();
        sight.cross(&way).norm().atan2(sight.dot(&way)).to_degrees()
    });
    assert!(off < 0.01, "{off}");
}

/// `Asked` gives back the way the hand had before an edit that moved it.
#[test]
fn a_hand_goes_where_it_was_asked_before_other_edits() {
    let motion = body();
    let s = motion.clip.skeleton.clone();
    let mut delta = vec![0.0; s.nv()];
    delta[s.v_at(4)] = 0.3;
    let lean = PoseDelta {
        at_s: 1.5,
        change: PoseChange::Delta { delta, limits: false },
        blend_s: 0.3,
        block_s: Some((0.5, 2.5)),
    };
    let mut log = EditLog::default();
    let leaned = lean.apply(&motion, &Where::default(), &mut log).unwrap();
    let was = |f: usize| place(&motion.clip, f, "wrist_l");
    assert!(worst(|f| (place(&leaned.clip, f, "wrist_l") - was(f)).norm()) > 0.05);
    let unedited = Some(Arc::new(motion.clip.clone()));
    let leaned = Motion { unedited, ..motion.clone() }.with(leaned);
    let edited = Pins { pins: vec![pin("wrist_l", PinAt::Asked)] }
        .apply(&leaned, &Where::default(), &mut log)
        .unwrap();
    let miss = worst(|f| (place(&edited.clip, f, "wrist_l") - was(f)).norm());
    assert!(miss < 1e-5, "{miss}");
    // the log names both edits of the chest, in order, with how much
    let line = log.joint_lines().into_iter().find(|l| l.starts_with("chest: ")).unwrap();
    assert!(
        line.contains("by pose-delta (edit 0) 0.220 s to 2.780 s at most 17.19°, then pin (edit 1) "),
        "{line}"
    );
}

/// Out of reach the hand goes as far as it can, the foot stays, and the log says by how much it misses.
#[test]
fn what_cannot_be_reached_is_said() {
    let motion = body();
    let far = Vec3::new(0.0, 1.2, 3.0);
    let (edited, log) = held(vec![pin("wrist_r", PinAt::World(far.into()))], &motion);
    let miss = worst(|f| (place(&edited.clip, f, "wrist_r") - far).norm());
    assert!(miss > 1.0 && miss < 2.6, "{miss}");
    let foot = worst(|f| (place(&edited.clip, f, "ankle") - place(&motion.clip, f, "ankle")).norm());
    assert!(foot < 1e-3, "{foot}");
    let text = log.to_string();
    let said = format!("wrist_r cannot be held: it misses by up to {:.1} mm", 1e3 * miss);
    assert!(text.contains(&said) && text.contains("beyond 1 mm from 1.000 s to 2.000 s"), "{said}: {text}");
}

#[test]
fn what_makes_no_sense_is_refused() {
    let motion = body();
    let refused = |pins: Vec<Pin>, at: Where| {
        Pins { pins }.apply(&motion, &at, &mut EditLog::default()).unwrap_err().to_string()
    };
    let world = || PinAt::World([0.0; 3]);
    for (pins, said) in [
        (vec![pin("wrist", world())], "did you mean"),
        (vec![pin("wrist_r", PinAt::Link("elbow".into(), [0.0; 3]))], "unknown link `elbow`"),
        (vec![pin("chest", PinAt::Link("wrist_r".into(), [0.0; 3]))], "`chest` cannot be held on `wrist_r`"),
        (vec![pin("wrist_r", PinAt::World([f64::NAN, 0.0, 0.0]))], "a coordinate is NaN for `wrist_r`"),
        (vec![pin("wrist_r", world()), pin("wrist_r", PinAt::Asked)], "`wrist_r` has two pins at 1.000 s"),
        (vec![Pin { to_s: 9.0, ..pin("wrist_r", world()) }], "to_s"),
        (vec![Pin { from_s: 2.0, to_s: 1.0, ..pin("wrist_r", world()) }], "no earlier than `from_s`"),
        (vec![Pin { blend_s: -1.0, ..pin("wrist_r", world()) }], "`blend_s` is -1"),
        (vec![Pin { point_m: [0.1, 0.0, 0.0], ..pin("gaze", world()) }], "only points of links"),
    ] {
        let error = refused(pins, Where::default());
        assert!(error.contains(said), "{said}: {error}");
    }
    let error = refused(vec![pin("wrist_r", world())], Where::default().of(["chest"]));
    assert!(error.contains("`parts` are chest"), "{error}");
}
