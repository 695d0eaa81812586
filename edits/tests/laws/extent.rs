//! Extent: arms against the body, hands against the shoulders.

use edits::extent_shoulder::arm_down;
use edits::poses::groups;
use edits::{EditLog, ExtentReach, ExtentShoulder, Selector, TrackEdit};
use motion::{Dof, Kinematics, Tracks, Vec3};

use crate::body::{action, apply, ball, build, cycle, dance, dof, element, hinge, names, pose, scalar};

const ARM_R: [&str; 1] = ["arm_r"];

/// Hand minus shoulder in the chest's frame, in each selected pose of an arm.
fn hands(tracks: &Tracks, selector: &Selector, arm: &str) -> Vec<Vec3> {
    let s = &tracks.skeleton;
    let limb = s.limb(arm).unwrap();
    let chest = s.link("spine2").unwrap();
    let moves = [Dof::Rotation(limb.upper), Dof::Axis(limb.lower)];
    groups(tracks, &selector.select(tracks).unwrap())
        .iter()
        .filter(|g| moves.iter().any(|d| g.element(*d).is_some()))
        .map(|g| {
            let k = Kinematics::new(s, &g.goal(tracks));
            k.world[chest].rotation.inverse() * (k.origin(limb.end) - k.origin(limb.upper))
        })
        .collect()
}

fn mean(hands: &[Vec3]) -> f64 {
    hands.iter().map(|h| h.norm()).sum::<f64>() / hands.len() as f64
}

/// The mean distance scales by s, the offsets and directions stay. 1e-15 seen.
#[test]
fn reach_scales_the_mean_distance() {
    for s in [0.7, 0.9, 1.05] {
        let mut tracks = dance();
        let selector = Selector::label("wave_0");
        let before = hands(&tracks, &selector, "arm_r");
        let log = apply(&ExtentReach::new(s), &mut tracks, &selector);
        assert!(log.clamped().is_empty());
        let after = hands(&tracks, &selector, "arm_r");
        assert_eq!(after.len(), 6);
        assert!((mean(&after) / mean(&before) - s).abs() < 1e-12);
        for (a, b) in after.iter().zip(&before) {
            assert!(((a.norm() - mean(&after)) - (b.norm() - mean(&before))).abs() < 1e-12);
            assert!((a.normalize() - b.normalize()).norm() < 1e-12);
        }
    }
}

/// The elbow stays in the plane of shoulder, elbow and hand it was in.
#[test]
fn reach_keeps_the_swivel() {
    let plane = |tracks: &Tracks| {
        let s = &tracks.skeleton;
        let limb = s.limb("arm_r").unwrap();
        let g = groups(tracks, &Selector::label("wave_0_0").select(tracks).unwrap());
        let k = Kinematics::new(s, &g[0].goal(tracks));
        let (a, b, c) = (k.origin(limb.upper), k.origin(limb.lower), k.origin(limb.end));
        (b - a).cross(&(c - b)).normalize()
    };
    let mut tracks = dance();
    let before = plane(&tracks);
    apply(&ExtentReach::new(0.8), &mut tracks, &Selector::label("wave_0"));
    assert!((plane(&tracks) - before).norm() < 1e-12);
}

/// Cut to full stretch and to the elbow's limit, and said to be.
#[test]
fn reach_is_cut_to_what_the_arm_can() {
    let selector = Selector::label("wave_0");
    for (s, cut) in
        [(3.0, 0.56), (0.01, (0.3_f64.powi(2) + 0.26_f64.powi(2) + 2.0 * 0.3 * 0.26 * 2.5_f64.cos()).sqrt())]
    {
        let mut tracks = dance();
        let log = apply(&ExtentReach::new(s), &mut tracks, &selector);
        assert_eq!(log.clamped().len(), 6);
        for hand in hands(&tracks, &selector, "arm_r") {
            assert!((hand.norm() - cut).abs() < 1e-9, "{s}: {}", hand.norm());
        }
        for (d, e) in tracks.elements() {
            if d == dof(&tracks, "elbow_r") {
                assert!((0.0..=2.5).contains(&scalar(&e.end)));
            }
        }
    }
}

/// A pose that sets only the shoulder gets an elbow, with the shoulder's timing.
#[test]
fn reach_makes_what_a_pose_lacks() {
    let mut tracks = dance();
    let log = apply(&ExtentReach::new(0.8), &mut tracks, &Selector::label("wave_1"));
    assert_eq!(names(&tracks, log.written_by(0)), ["wave_1_0_elbow_r", "wave_1_0_shoulder_r"]);
    let (made, model) = (element(&tracks, "wave_1_0_elbow_r"), element(&tracks, "wave_1_0_shoulder_r"));
    assert_eq!((made.start_s, made.duration_s, made.hold_s), (model.start_s, model.duration_s, model.hold_s));
    assert_eq!((made.curve, made.tension), (model.curve, model.tension));
    let track = tracks.track(dof(&tracks, "elbow_r")).unwrap();
    assert!(track.elements.windows(2).all(|w| w[0].start_s <= w[1].start_s));
    // the other arm, unselected places and half an arm stay
    let mut tracks = dance();
    let log = apply(&ExtentReach::new(0.8), &mut tracks, &Selector::label("wave_0").of(["elbow_r"]));
    assert_eq!(tracks, dance());
    assert_eq!(log.notes().len(), 6);
}

/// Between hanging and the pose on one arc: the angle from hanging scales by x; elbows stay.
#[test]
fn shoulder_extent_scales_the_angle_from_hanging() {
    for x in [ExtentShoulder::NEAR, 0.8, 1.2] {
        let mut tracks = dance();
        let before = tracks.clone();
        let log = apply(&ExtentShoulder::new(x), &mut tracks, &Selector::label("wave_0").of(ARM_R));
        assert!(log.clamped().is_empty());
        let limb = before.skeleton.limb("arm_r").unwrap();
        let all = Selector::default().select(&before).unwrap();
        let mut seen = 0;
        for g in groups(&before, &all).iter().filter(|g| &*g.label().action == "wave" && g.label().cycle == 0)
        {
            let down = motion::Value::Rotation(arm_down(&before.skeleton, &g.goal(&before), limb).unwrap());
            let old = g.element(Dof::Rotation(limb.upper)).unwrap();
            let new = tracks.element(&old.label).unwrap();
            assert!((new.end.distance(&down) - x * old.end.distance(&down)).abs() < 1e-12);
            seen += 1;
        }
        assert_eq!(seen, 6);
        for ((_, a), (d, b)) in tracks.elements().zip(before.elements()) {
            assert_eq!(a.end == b.end, d != Dof::Rotation(limb.upper) || b.label.cycle == 1);
        }
    }
}

/// At extent 0 the straight arm hangs along the chest, however the chest and the collar bone are turned.
#[test]
fn hanging_arms_point_down_the_chest() {
    let values = vec![
        ball("spine1", 0.6, 0.2, 0.0),
        ball("clavicle_r", 0.1, 0.2, 0.2),
        ball("shoulder_r", 0.2, 0.5, 0.3),
        hinge("elbow_r", 0.0),
    ];
    let mut tracks = build(vec![action("a", 0.0, vec![cycle(1, vec![pose(1.0, 0.0, values)])])]);
    apply(&ExtentShoulder::new(0.0), &mut tracks, &Selector::default());
    let hand = hands(&tracks, &Selector::default(), "arm_r")[0];
    assert!((hand.normalize() + Vec3::y()).norm() < 1e-12, "{hand}"); // the chest's own −Y
    let shoulder = element(&tracks, "a_0_0_shoulder_r").end.rotation().unwrap();
    let (_, twist) = motion::rotation::swing_twist(&shoulder, &-Vec3::x());
    assert!(motion::rotation::log(&twist).norm() < 1e-12);
}

/// An arm raised half-way: near brings the hand to the body, far takes it out; mid is as it is.
#[test]
fn presets_are_ordered() {
    let away = |x: f64| {
        let values = vec![ball("shoulder_r", 0.0, 0.0, 0.7), hinge("elbow_r", 0.2)];
        let mut tracks = build(vec![action("a", 0.0, vec![cycle(1, vec![pose(1.0, 0.0, values)])])]);
        apply(&ExtentShoulder::new(x), &mut tracks, &Selector::default());
        let hand = hands(&tracks, &Selector::default(), "arm_r")[0];
        hand.x.hypot(hand.z)
    };
    let [near, mid, far] = [ExtentShoulder::NEAR, ExtentShoulder::MID, ExtentShoulder::FAR].map(away);
    assert!(near < mid - 0.1 && mid < far - 0.05, "{near} {mid} {far}");
    assert_eq!(ExtentShoulder::MID, 1.0);
}

#[test]
fn bad_extents_are_refused() {
    let mut tracks = dance();
    let all = Selector::default().select(&tracks).unwrap();
    let edits: [Box<dyn TrackEdit>; 4] = [
        Box::new(ExtentShoulder::new(-0.1)),
        Box::new(ExtentShoulder::new(f64::NAN)),
        Box::new(ExtentReach::new(0.0)),
        Box::new(ExtentReach::new(f64::INFINITY)),
    ];
    for edit in edits {
        assert!(edit.apply(&mut tracks, &all, &mut EditLog::default()).is_err());
        assert_eq!(tracks, dance());
    }
}
