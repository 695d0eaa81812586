//! Succession spreads start times along the body and keeps each track in order.

use edits::succession::ranks;
use edits::{Direction, EditError, EditLog, Parameter, Selector, Succession, TrackEdit};
use motion::{Joint, Link, Skeleton, Tracks, Vec3};

use crate::body::{action, apply, ball, build, cycle, dance, dof, element, hinge, pose};

/// The paper's bow in small: everything from spine to wrists and a leg, in two poses over rest.
fn bow() -> Tracks {
    let all = |a: f64| {
        let mut v = vec![
            hinge("pelvis_y", 0.95 - 0.05 * a),
            hinge("knee_l", 0.1 * a),
            hinge("elbow_r", 1.0 + 0.3 * a),
        ];
        for name in ["spine1", "spine2", "neck", "clavicle_l", "clavicle_r", "shoulder_r", "wrist_r", "hip_l"]
        {
            v.push(ball(name, 0.3 * a, 0.1, 0.0));
        }
        v
    };
    build(vec![action("bow", 0.5, vec![cycle(1, vec![pose(1.0, 0.2, all(1.0)), pose(1.0, 0.0, all(-0.5))])])])
}

fn shift(before: &Tracks, after: &Tracks, name: &str) -> f64 {
    element(after, name).start_s - element(before, name).start_s
}

const FORWARD: [(&str, f64); 11] = [
    ("pelvis_y", 0.0),
    ("spine1", 0.0),
    ("spine2", 1.0),
    ("neck", 2.0),
    ("clavicle_l", 2.0),
    ("clavicle_r", 2.0),
    ("shoulder_r", 3.0),
    ("elbow_r", 4.0),
    ("wrist_r", 5.0),
    ("hip_l", 0.0),
    ("knee_l", 1.0),
];

/// start' − start = t × depth; one offset per pose, as in the paper.
#[test]
fn forward_runs_from_the_hip_with_an_offset_for_each_pose() {
    let before = bow();
    let mut tracks = before.clone();
    apply(&Succession::forward(Parameter::PerPose(vec![0.2, 0.3])), &mut tracks, &Selector::default());
    for (name, depth) in FORWARD {
        for (p, t) in [(0, 0.2), (1, 0.3)] {
            let s = shift(&before, &tracks, &format!("bow_0_{p}_{name}"));
            assert!((s - t * depth).abs() < 1e-12, "{name} in pose {p}: {s}");
        }
    }
    assert!((tracks.duration_s - (before.duration_s + 5.0 * 0.3)).abs() < 1e-12);
}

#[test]
fn reverse_runs_from_the_extremities() {
    let before = bow();
    let mut tracks = before.clone();
    apply(&Succession::reverse(0.1), &mut tracks, &Selector::label("bow_0_0"));
    let height = [
        ("wrist_r", 0.0),
        ("elbow_r", 1.0),
        ("shoulder_r", 2.0),
        ("clavicle_r", 3.0),
        ("clavicle_l", 0.0), // no moved joint beyond it
        ("neck", 0.0),
        ("spine2", 4.0),
        ("spine1", 5.0),
        ("pelvis_y", 5.0), // with the first spine joint, as forward
        ("knee_l", 0.0),
        ("hip_l", 1.0),
    ];
    for (name, h) in height {
        let s = shift(&before, &tracks, &format!("bow_0_0_{name}"));
        assert!((s - 0.1 * h).abs() < 1e-12, "{name}: {s}");
        assert_eq!(shift(&before, &tracks, &format!("bow_0_1_{name}")), 0.0);
    }
}

/// Joints that are unselected, welded, without length or only hold their place do not count.
#[test]
fn only_selected_moved_joints_count() {
    let before = bow();
    let mut tracks = before.clone();
    let parts = ["spine1", "shoulder_r", "wrist_r"];
    apply(&Succession::forward(0.1), &mut tracks, &Selector::label("bow_0_0").of(parts));
    for (name, depth) in [("spine1", 0.0), ("shoulder_r", 1.0), ("wrist_r", 2.0), ("elbow_r", 0.0)] {
        assert!((shift(&before, &tracks, &format!("bow_0_0_{name}")) - 0.1 * depth).abs() < 1e-12, "{name}");
    }
    // spine2 is set to where it is: it moves with its depth, but the shoulder does not wait for it
    let values =
        vec![ball("spine1", 0.4, 0.0, 0.0), ball("spine2", 0.0, 0.0, 0.0), ball("shoulder_r", 0.1, 0.2, 0.3)];
    let mut tracks = build(vec![action("a", 0.0, vec![cycle(1, vec![pose(1.0, 0.0, values)])])]);
    apply(&Succession::forward(0.1), &mut tracks, &Selector::default());
    for (name, start) in [("spine1", 0.0), ("spine2", 0.1), ("shoulder_r", 0.1)] {
        assert_eq!(element(&tracks, &format!("a_0_0_{name}")).start_s, start);
    }
}

/// A hip of three hinges at one place is one joint; a dummy at the root's place is the first of its branch.
#[test]
fn joints_at_one_place_count_once() {
    let (x, zero) = (Joint::Revolute(Vec3::x()), Vec3::zeros());
    let s = Skeleton::new(vec![
        Link::new("hips", None, zero, Joint::Free),
        Link::new("hip_x", Some(0), Vec3::new(0.1, 0.0, 0.0), x),
        Link::new("hip_y", Some(1), zero, Joint::Revolute(Vec3::y())),
        Link::new("hip_z", Some(2), zero, Joint::Revolute(Vec3::z())),
        Link::new("knee", Some(3), Vec3::new(0.0, -0.4, 0.0), x),
        Link::new("shell", Some(4), Vec3::new(0.0, -0.2, 0.0), Joint::Fixed),
        Link::new("ankle", Some(5), Vec3::new(0.0, -0.2, 0.0), x),
        Link::new("low_back", Some(0), zero, Joint::Spherical),
        Link::new("spine", Some(7), Vec3::new(0.0, 0.1, 0.0), Joint::Spherical),
    ])
    .unwrap();
    assert_eq!(ranks(&s, &[true; 9], Direction::Forward), [0, 0, 0, 0, 1, 2, 2, 0, 1]);
    assert_eq!(ranks(&s, &[true; 9], Direction::Reverse), [2, 2, 2, 2, 1, 1, 0, 1, 0]);
    // one of the three is enough to count
    let moved = [false, false, true, false, true, false, false, false, true];
    assert_eq!(ranks(&s, &moved, Direction::Forward)[4], 1);
    assert_eq!(ranks(&s, &moved, Direction::Forward)[8], 0);
}

/// Holds shrink before transitions are superseded, and no element starts after its successor.
#[test]
fn elements_of_a_dof_stay_serial() {
    let before = bow();
    for t in [0.02, 0.05, 0.3, 1.0] {
        let mut tracks = before.clone();
        apply(&Succession::forward(t), &mut tracks, &Selector::label("bow_0_0"));
        for (track, old) in tracks.tracks.iter().zip(&before.tracks) {
            let (e, o) = (&track.elements, &old.elements);
            let labels = |e: &[motion::Element]| e.iter().map(|e| e.label.clone()).collect::<Vec<_>>();
            assert_eq!(labels(e), labels(o));
            assert!(e[0].start_s <= e[1].start_s);
            assert_eq!(e[1].start_s, o[1].start_s);
            let room = e[1].start_s - e[0].arrives_s();
            assert!((e[0].hold_s - room.clamp(0.0, 0.2)).abs() < 1e-12);
        }
    }
    // 1 s × depth 5 is past the second pose: the wrist's first element is superseded at once, and said to be
    let mut tracks = before.clone();
    let log = apply(&Succession::forward(1.0), &mut tracks, &Selector::label("bow_0_0"));
    assert_eq!(element(&tracks, "bow_0_0_wrist_r").start_s, element(&tracks, "bow_0_1_wrist_r").start_s);
    assert!(log.notes().iter().any(|(_, n)| n.starts_with("bow_0_0_wrist_r ")));
    let t = tracks.track(dof(&tracks, "wrist_r")).unwrap();
    assert_eq!(t.active(t.elements[1].start_s), Some(1));
}

/// Measured on the motion itself: the times of greatest speed spread by t per joint.
#[test]
fn peak_speeds_spread_from_spine_to_wrist() {
    let peak = |tracks: &Tracks, name: &str| {
        let d = dof(tracks, name);
        let speed = |i: i32| {
            let t = 0.001 * f64::from(i);
            tracks.value_at(d, t + 5e-4).distance(&tracks.value_at(d, t - 5e-4))
        };
        (0..3000).max_by(|a, b| speed(*a).total_cmp(&speed(*b))).map(|i| 0.001 * f64::from(i)).unwrap()
    };
    let one = || {
        let values = vec![
            ball("spine1", 0.4, 0.1, 0.0),
            ball("spine2", 0.3, 0.0, 0.0),
            ball("shoulder_r", 0.1, 0.2, 0.3),
        ];
        build(vec![action("a", 0.1, vec![cycle(1, vec![pose(1.0, 0.0, values)])])])
    };
    let mut tracks = one();
    apply(&Succession::forward(0.2), &mut tracks, &Selector::default());
    assert!((peak(&one(), "shoulder_r") - peak(&one(), "spine1")).abs() < 0.01);
    assert!((peak(&tracks, "shoulder_r") - peak(&tracks, "spine1") - 0.4).abs() < 0.01);
}

#[test]
fn negative_offsets_and_short_lists_are_refused() {
    let mut tracks = dance();
    let all = Selector::default().select(&tracks).unwrap();
    let mut refuse = |edit: Succession| edit.apply(&mut tracks, &all, &mut EditLog::default()).unwrap_err();
    assert_eq!(
        refuse(Succession::forward(-0.1)).to_string(),
        "succession: offset_s is -0.1; allowed: 0 s or more"
    );
    let short = refuse(Succession::reverse(Parameter::PerPose(vec![0.1, 0.2])));
    assert_eq!(short, EditError::PerPose { edit: "succession", given: 2, needed: 6 });
}
