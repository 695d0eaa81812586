//! Laws of scripts and tracks: start values, superseding, labels, inheritance, refusals.

use std::sync::Arc;

use motion::rotation::{exp, log};
use motion::script::{Action, Cycle, Insert, Pose, PoseValue, Properties, Script, ScriptError};
use motion::{Curve, Dof, Joint, Link, Quat, Skeleton, Tracks, Value, Vec3};

/// Free pelvis, ball spine, hinge elbow, welded hand: no number is zero or one by accident.
fn skeleton() -> Arc<Skeleton> {
    let x = Vec3::x();
    Arc::new(
        Skeleton::new(vec![
            Link::new("pelvis", None, Vec3::new(0.0, 0.9, 0.1), Joint::Free),
            Link::new("spine", Some(0), Vec3::new(0.0, 0.2, -0.05), Joint::Spherical),
            Link::new("elbow_r", Some(1), Vec3::new(-0.3, 0.3, 0.0), Joint::Revolute(x)),
            Link::new("hand_r", Some(2), Vec3::new(-0.25, 0.0, 0.02), Joint::Fixed),
        ])
        .unwrap(),
    )
}

fn base(s: &Skeleton) -> Vec<f64> {
    let mut q = s.zero_pose();
    s.set_position(&mut q, 0, &Vec3::new(0.1, 0.95, -0.2));
    s.set_rotation(&mut q, 1, &turn(0.1, -0.2, 0.05));
    q[s.q_at(2)] = 0.3;
    q
}

fn turn(x: f64, y: f64, z: f64) -> Quat {
    exp(&Vec3::new(x, y, z))
}

fn timed(duration_s: f64, hold_s: f64, values: Vec<PoseValue>) -> Pose {
    let properties =
        Properties { duration_s: Some(duration_s), hold_s: Some(hold_s), ..Properties::default() };
    Pose { properties, values }
}

fn action(name: &str, start_s: f64, poses: Vec<Pose>, repetitions: usize) -> Action {
    let cycles = vec![Cycle { repetitions, poses, ..Cycle::default() }];
    Action { name: name.into(), start_s, cycles, ..Action::default() }
}

fn build(actions: Vec<Action>) -> Result<Tracks, ScriptError> {
    let s = skeleton();
    Script { actions, ..Script::default() }.build(&s, &base(&s))
}

fn elbow(tracks: &Tracks, t: f64) -> f64 {
    tracks.value_at(Dof::Axis(2), t).scalar().unwrap()
}

#[test]
fn dofs_have_one_order_and_names() {
    let s = skeleton();
    let names: Vec<String> = Dof::all(&s).iter().map(|d| d.name(&s)).collect();
    assert_eq!(names, ["pelvis_x", "pelvis_y", "pelvis_z", "pelvis", "spine", "elbow_r"]);
    for (i, dof) in Dof::all(&s).into_iter().enumerate() {
        assert_eq!(Dof::find(&s, &dof.name(&s)), Some(dof));
        assert_eq!(dof.index(&s), Some(i));
    }
    assert_eq!(Dof::find(&s, "hand_r"), None);
    assert_eq!(Dof::find(&s, "spine_x"), None);
}

#[test]
fn before_the_first_element_and_after_the_last_nothing_moves() {
    let s = skeleton();
    let pose = timed(0.5, 0.2, vec![PoseValue::scalar("elbow_r", 1.2)]);
    let tracks = build(vec![action("reach", 0.4, vec![pose], 1)]).unwrap();
    let mut q = vec![0.0; s.nq()];
    tracks.pose_at(0.399, &mut q);
    assert_eq!(q, base(&s));
    assert_eq!(elbow(&tracks, 0.9), 1.2);
    assert_eq!(elbow(&tracks, 100.0), 1.2);
    assert!((elbow(&tracks, 0.65) - 0.75).abs() < 1e-15); // half-way at half time
    assert!((tracks.duration_s - 1.1).abs() < 1e-15);
}

/// A later element starts from where the DOF is, not from where it was going.
#[test]
fn superseding_continues_from_the_state() {
    let a = action("up", 0.0, vec![timed(1.0, 0.5, vec![PoseValue::scalar("elbow_r", 1.3)])], 1);
    let b = action("down", 0.5, vec![timed(1.0, 0.0, vec![PoseValue::scalar("elbow_r", -0.7)])], 1);
    let c = action("again", 0.6, vec![timed(0.2, 0.0, vec![PoseValue::scalar("elbow_r", 0.9)])], 1);
    let tracks = build(vec![c, a, b]).unwrap();
    let m = |u| Curve::EaseInOut.at(u);
    let at_half = 0.3 + m(0.5) * 1.0;
    let at_06 = at_half + m(0.1) * (-0.7 - at_half);
    let at_07 = at_06 + m(0.5) * (0.9 - at_06);
    assert!((elbow(&tracks, 0.7) - at_07).abs() < 1e-14);
    for t in [0.5, 0.6] {
        let jump = elbow(&tracks, t + 1e-9) - elbow(&tracks, t - 1e-9);
        assert!(jump.abs() < 1e-7, "{t}: {jump}");
    }
    let overlaps = tracks.overlaps();
    assert_eq!(overlaps.len(), 2);
    assert_eq!((&*overlaps[0].earlier.action, &*overlaps[0].later.action), ("up", "down"));
    assert!((overlaps[0].cut_s - 0.5).abs() < 1e-12);
}

/// Two roads to one number: exact evaluation, and carrying the state forward element by element.
#[test]
fn recursion_equals_carrying_the_state_forward() {
    let mut actions = Vec::new();
    for i in 0..40 {
        let f = f64::from(i);
        let values = vec![
            PoseValue::scalar("elbow_r", (f * 1.7).sin()),
            PoseValue::rotation("spine", turn(0.8 * (f * 0.9).sin(), 0.5 * (f * 2.3).cos(), 0.1 * f / 40.0)),
        ];
        let mut pose = timed(0.05 + 0.4 * (f * 0.37).sin().abs(), 0.02, values);
        pose.properties.curve = Some([Curve::Overshoot, Curve::Linear, Curve::EaseIn][i as usize % 3]);
        actions.push(action(&format!("a{i}"), 0.11 * f, vec![pose], 1));
    }
    let tracks = build(actions).unwrap();
    for track in &tracks.tracks {
        let mut state = track.dof.read(&tracks.skeleton, &tracks.base);
        for (i, e) in track.elements.iter().enumerate() {
            assert!(
                track.start_value(i, &track.dof.read(&tracks.skeleton, &tracks.base)).distance(&state)
                    < 1e-13
            );
            let until = track.elements.get(i + 1).map_or(e.ends_s(), |next| next.start_s);
            let before = tracks.value_at(track.dof, until - 1e-12);
            state = e.value_at(until, &state);
            assert!(before.distance(&state) < 1e-9);
        }
    }
}

#[test]
fn poses_and_cycles_are_serial_and_repeat() {
    let poses = vec![
        timed(0.3, 0.1, vec![PoseValue::scalar("elbow_r", 1.0), PoseValue::scalar("pelvis_y", 0.9)]),
        timed(0.2, 0.0, vec![PoseValue::scalar("elbow_r", -1.0)]),
    ];
    let mut a = action("wave", 0.5, poses, 3);
    a.cycles.push(Cycle {
        poses: vec![timed(0.4, 0.0, vec![PoseValue::scalar("elbow_r", 0.0)])],
        ..Cycle::default()
    });
    let tracks = build(vec![a]).unwrap();
    let elbow = tracks.track(Dof::Axis(2)).unwrap();
    let starts: Vec<f64> = elbow.elements.iter().map(|e| e.start_s).collect();
    let expected = [0.5, 0.9, 1.1, 1.5, 1.7, 2.1, 2.3];
    assert_eq!(starts.len(), expected.len());
    assert!(starts.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{starts:?}");
    let labels: Vec<String> = elbow.elements.iter().map(|e| e.label.to_string()).collect();
    assert_eq!(labels[..2], ["wave_0_0_5_0", "wave_0_1_5_0"]);
    assert_eq!(labels[5..], ["wave_0_1_5_2", "wave_1_0_5"]);
    assert_eq!(elbow.elements[5].label.named(&tracks.skeleton), "wave_0_1_elbow_r_2");
    assert!(tracks.overlaps().is_empty());
}

#[test]
fn properties_flow_down_and_the_innermost_wins() {
    let mut inner = PoseValue::scalar("elbow_r", 1.0);
    inner.properties.curve = Some(Curve::Linear);
    let pose = Pose {
        properties: Properties { tension: Some(3.0), ..Properties::default() },
        values: vec![inner, PoseValue::scalar("pelvis_y", 0.9)],
    };
    let mut a = action("wave", 0.0, vec![pose], 1);
    a.cycles[0].properties.duration_s = Some(0.7);
    a.properties = Properties {
        curve: Some(Curve::EaseIn),
        tension: Some(2.0),
        duration_s: Some(9.0),
        ..Properties::default()
    };
    let s = skeleton();
    let properties = Properties { hold_s: Some(0.25), ..Properties::default() };
    let tracks = Script { properties, actions: vec![a], inserts: vec![] }.build(&s, &base(&s)).unwrap();
    let got: Vec<_> = tracks.elements().map(|(_, e)| (e.curve, e.tension, e.duration_s, e.hold_s)).collect();
    assert_eq!(got, [(Curve::EaseIn, 3.0, 0.7, 0.25), (Curve::Linear, 3.0, 0.7, 0.25)]);
}

#[test]
fn a_pause_takes_its_time() {
    let poses = vec![
        timed(0.25, 0.5, vec![]),
        timed(0.5, 0.0, vec![PoseValue::scalar("elbow_r", 1.0)]),
        timed(0.0, 1.0, vec![]),
    ];
    let tracks = build(vec![action("wait", 0.0, poses, 1)]).unwrap();
    assert_eq!(elbow(&tracks, 0.75), 0.3);
    assert_eq!(elbow(&tracks, 1.25), 1.0);
    assert_eq!(tracks.duration_s, 2.25);
}

#[test]
fn rotations_run_along_the_shorter_arc_and_overshoot() {
    let (goal, other_sign) = (turn(0.9, 0.3, -0.2), turn(0.9, 0.3, -0.2).into_inner());
    let other_sign = Quat::new_unchecked(-other_sign);
    for end in [goal, other_sign] {
        let mut pose = timed(1.0, 0.0, vec![PoseValue::rotation("spine", end)]);
        pose.properties.curve = Some(Curve::Overshoot);
        let tracks = build(vec![action("a", 0.0, vec![pose], 1)]).unwrap();
        let start = turn(0.1, -0.2, 0.05);
        let at = |t| tracks.value_at(Dof::Rotation(1), t).rotation().unwrap();
        let whole = log(&(goal * start.inverse()));
        let s = Curve::Overshoot.at(0.77);
        assert!(s > 1.1);
        assert!((log(&(at(0.77) * start.inverse())) - whole * s).norm() < 1e-13);
        assert!(Value::Rotation(at(1.0)).distance(&Value::Rotation(goal)) < 1e-15);
    }
}

#[test]
fn inserts_and_zero_durations_jump() {
    let s = skeleton();
    let mut value = PoseValue::scalar("elbow_r", 1.1);
    value.properties.duration_s = Some(0.0);
    let inserts = vec![Insert { name: "snap".into(), start_s: 0.5, value }];
    let tracks = Script { inserts, ..Script::default() }.build(&s, &base(&s)).unwrap();
    assert_eq!((elbow(&tracks, 0.5 - 1e-12), elbow(&tracks, 0.5)), (0.3, 1.1));
    let clip = tracks.sample(10.0);
    assert_eq!(clip.frames(), 6);
    assert_eq!(clip.pose(5)[s.q_at(2)], 1.1);
}

/// The rate of progress is the derivative of progress. 1e-9 seen.
#[test]
fn progress_rate_is_the_derivative() {
    let pose = timed(0.8, 0.3, vec![PoseValue::scalar("elbow_r", 1.2)]);
    let tracks = build(vec![action("a", 0.2, vec![pose], 1)]).unwrap();
    let e = &tracks.tracks[0].elements[0];
    for i in 0..100 {
        let (t, h) = (0.0151 * f64::from(i), 1e-6);
        let d = (e.progress(t + h) - e.progress(t - h)) / (2.0 * h);
        assert!((d - e.progress_rate(t)).abs() < 1e-6, "{t}");
    }
}

#[test]
fn tension_is_that_of_the_governing_element() {
    let mut pose = timed(0.5, 0.0, vec![PoseValue::scalar("elbow_r", 1.2)]);
    pose.properties.tension = Some(4.0);
    let mut tracks = build(vec![action("a", 0.2, vec![pose], 1)]).unwrap();
    tracks.base_tension[2] = 0.5;
    assert_eq!(
        (tracks.tension_at(2, 0.1), tracks.tension_at(2, 0.2), tracks.tension_at(2, 9.0)),
        (0.5, 4.0, 4.0)
    );
    assert_eq!(tracks.tension_at(3, 0.0), 1.0);
}

#[test]
fn refusals_say_what_and_where() {
    let one = |v: PoseValue| build(vec![action("reach", 0.0, vec![timed(0.5, 0.0, vec![v])], 1)]);
    let words = |r: Result<Tracks, ScriptError>| r.unwrap_err().to_string();
    let place = "pose 0 of cycle 0 of action \"reach\"";
    assert_eq!(
        words(one(PoseValue::scalar("elbw_r", 1.0))),
        format!("unknown joint `elbw_r` in {place}; did you mean `elbow_r`?")
    );
    assert_eq!(
        words(one(PoseValue::scalar("spine", 1.0))),
        format!("`spine` in {place} takes a rotation, found one number")
    );
    assert_eq!(
        words(one(PoseValue::scalar("hand_r", 1.0))),
        format!("`hand_r` in {place} is welded to its parent and cannot move")
    );
    assert!(words(one(PoseValue::scalar("elbow_r", f64::NAN))).contains("a finite number"));
    let bad = Quat::new_unchecked(nalgebra::Quaternion::new(1.0, 1.0, 0.0, 0.0));
    assert!(words(one(PoseValue::rotation("spine", bad))).contains("length 1"));
    let timed_bad = |d, h| words(build(vec![action("a", 0.0, vec![timed(d, h, vec![])], 1)]));
    assert!(timed_bad(-0.1, 0.0).starts_with("duration_s is -0.1 in pose 0"));
    assert!(timed_bad(0.1, -2.0).starts_with("hold_s is -2 in pose 0"));
    assert!(timed_bad(f64::NAN, 0.0).contains("NaN"));
    assert!(words(build(vec![action("a", f64::INFINITY, vec![], 1)])).starts_with("start_s is inf"));
    for n in [0, 10_001, usize::MAX] {
        assert!(words(build(vec![action("a", 0.0, vec![], n)])).contains("allowed: 1 to 10000"));
    }
    let two = vec![PoseValue::scalar("elbow_r", 1.0), PoseValue::scalar("elbow_r", 2.0)];
    assert!(words(build(vec![action("a", 0.0, vec![timed(0.1, 0.0, two)], 1)])).contains("set twice"));
    let same = || action("a", 0.0, vec![], 1);
    assert!(words(build(vec![same(), same()])).contains("`a` is used twice"));
    let s = skeleton();
    assert!(matches!(
        Script::default().build(&s, &[0.0; 3]),
        Err(ScriptError::Base { found: 3, needed: 12 })
    ));
    let mut curve = timed(0.1, 0.0, vec![PoseValue::scalar("elbow_r", 1.0)]);
    curve.properties.curve = Some(Curve::Bezier(1.5, 0.0, 0.5, 1.0));
    assert!(words(build(vec![action("a", 0.0, vec![curve], 1)])).contains("Bezier handle is 1.5"));
    let mut slack = timed(0.1, 0.0, vec![PoseValue::scalar("elbow_r", 1.0)]);
    slack.properties.tension = Some(0.0);
    assert!(words(build(vec![action("a", 0.0, vec![slack], 1)])).contains("tension is 0"));
}

/// Timing is inherited from the script to the element; of each two levels the inner one wins, and where none says it, it is loose.
#[test]
fn timing_is_of_the_innermost_level_that_says_it() {
    use motion::Timing;
    let s = skeleton();
    // which of script, action, cycle, pose, element say what
    let built = |said: [Option<Timing>; 5]| {
        let [top, a, c, p, e] = said.map(|timing| Properties { timing, ..Properties::default() });
        let value = PoseValue { properties: e, ..PoseValue::scalar("elbow_r", 0.5) };
        let pose = Pose { properties: p, values: vec![value] };
        let cycle = Cycle { repetitions: 1, properties: c, poses: vec![pose] };
        let act = Action { name: "act".into(), start_s: 0.0, properties: a, cycles: vec![cycle] };
        let script = Script { properties: top, actions: vec![act], inserts: Vec::new() };
        let tracks = script.build(&s, &base(&s)).unwrap();
        tracks.elements().map(|(_, e)| e.timing).collect::<Vec<_>>()
    };
    assert_eq!(built([None; 5]), [Timing::Loose]);
    let others: Vec<Timing> =
        <Timing as motion::names::Word>::WORDS.iter().map(|w| w.0).filter(|t| *t != Timing::Loose).collect();
    assert!(!others.is_empty());
    for other in others {
        for inner in 0..5 {
            let mut said = [None; 5];
            said[inner] = Some(other);
            assert_eq!(built(said), [other], "level {inner} alone");
            for outer in 0..inner {
                let mut both = said;
                both[outer] = Some(Timing::Loose);
                assert_eq!(built(both), [other], "level {inner} within {outer}");
                (both[outer], both[inner]) = (Some(other), Some(Timing::Loose));
                assert_eq!(built(both), [Timing::Loose], "level {inner} within {outer}");
            }
        }
    }
}
