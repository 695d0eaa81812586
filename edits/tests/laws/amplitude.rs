//! Amplitude scales ranges by the formulas of the module, within limits.

use edits::{Amplitude, EditError, EditLog, Parameter, Selector, TrackEdit};
use motion::{Tracks, Value};

use crate::body::{
    action, apply, ball, base, build, cycle, dance, dof, element, hinge, pose, scalar, skeleton, turn,
};

/// Elbow ends of an action with one pose for each angle.
fn elbow(angles: &[f64]) -> Tracks {
    let poses = angles.iter().map(|a| pose(0.3, 0.1, vec![hinge("elbow_r", *a)])).collect();
    build(vec![action("a", 0.0, vec![cycle(1, poses)])])
}

fn ends(tracks: &Tracks) -> Vec<f64> {
    tracks.elements().map(|(_, e)| scalar(&e.end)).collect()
}

fn near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    let worst = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-14, "{found:?}, expected {expected:?}");
}

/// (… x, y, x, y …) scales by a about the average, except at the two ends of the sequence.
#[test]
fn alternating_poses_scale_exactly() {
    for a in [0.25, 0.8, 1.5] {
        let (x, y) = (1.4, 0.8);
        let mut tracks = elbow(&[x, y, x, y, x, y]);
        apply(&Amplitude::new(a), &mut tracks, &Selector::default());
        let m = 0.5 * (x + y);
        let (x1, y1) = (m + a * (x - m), m + a * (y - m));
        // the first is also pulled from the base, 0.3
        let first = x + (a - 1.0) * (2.0 * x - 0.3 - y) / 4.0;
        near(&ends(&tracks), &[first, y1, x1, y1, x1, y1]);
    }
}

#[test]
fn evenly_monotone_interior_stays_and_the_last_goes_half() {
    let mut tracks = elbow(&[0.6, 0.9, 1.2, 1.5]);
    apply(&Amplitude::new(2.0), &mut tracks, &Selector::default());
    near(&ends(&tracks), &[0.6, 0.9, 1.2, 1.65]);
}

/// Documented, not wished: midpoints move, so a and 1/a do not cancel. About a reference they do.
#[test]
fn a_then_its_inverse() {
    let mut tracks = elbow(&[1.4, 0.8, 1.1]);
    apply(&Amplitude::new(0.5), &mut tracks, &Selector::default());
    // by hand: 1.4 − ½(1.4 − (0.85 + 1.1)/2), 0.8 − ½(0.8 − (1.1 + 0.95)/2), 1.1 − ½(1.1 − 0.8)/2
    near(&ends(&tracks), &[1.1875, 0.9125, 1.025]);
    apply(&Amplitude::new(2.0), &mut tracks, &Selector::default());
    near(&ends(&tracks), &[1.478125, 0.815625, 1.08125]);

    let mut tracks = dance();
    let reference = base(&tracks.skeleton);
    let before = tracks.clone();
    apply(&Amplitude::about(0.4, reference.clone()), &mut tracks, &Selector::default());
    apply(&Amplitude::about(2.5, reference), &mut tracks, &Selector::default());
    for ((_, a), (_, b)) in tracks.elements().zip(before.elements()) {
        assert!(a.end.distance(&b.end) < 1e-14, "{}", a.label);
    }
}

#[test]
fn a_reference_pose_is_the_centre() {
    let mut tracks = dance();
    let mut reference = skeleton().zero_pose();
    let s = skeleton();
    reference[s.q_at(s.link("elbow_r").unwrap())] = 1.0;
    apply(&Amplitude::about(0.3, reference), &mut tracks, &Selector::default());
    assert!((scalar(&element(&tracks, "wave_0_0_elbow_r_1").end) - (1.0 + 0.3 * 0.5)).abs() < 1e-15);
    let spine = element(&tracks, "bow_0_0_spine1").end;
    assert!(spine.distance(&Value::Rotation(turn(0.15, 0.0, 0.0))) < 1e-15);
}

/// The first element moves only if it places the body without a transition.
#[test]
fn the_start_moves_only_if_it_is_selected() {
    let mut tracks = build(vec![action(
        "a",
        0.0,
        vec![cycle(
            1,
            vec![pose(0.0, 0.2, vec![hinge("elbow_r", 0.5)]), pose(0.4, 0.0, vec![hinge("elbow_r", 1.3)])],
        )],
    )]);
    let mut outside = tracks.clone();
    apply(&Amplitude::new(1.5), &mut tracks, &Selector::default());
    near(&ends(&tracks), &[0.3, 1.5]); // about 0.9
    apply(&Amplitude::new(1.5), &mut outside, &Selector::label("a_0_1"));
    near(&ends(&outside), &[0.5, 1.5]);
}

/// Rotations about one axis are scalars in disguise; two roads to one number.
#[test]
fn rotations_follow_the_same_formula() {
    let angles = [0.5, -0.2, 0.4, 0.1];
    let rotations = angles.iter().map(|a| pose(0.3, 0.0, vec![ball("neck", 0.0, *a, 0.0)])).collect();
    let mut turned = build(vec![action("a", 0.0, vec![cycle(1, rotations)])]);
    let scalars = angles.iter().map(|a| pose(0.3, 0.0, vec![hinge("pelvis_z", *a + 0.05)])).collect();
    // base values: neck 0, pelvis_z −0.05
    let mut slid = build(vec![action("a", 0.0, vec![cycle(1, scalars)])]);
    for (_, e) in slid.elements_mut() {
        e.end = Value::Scalar(scalar(&e.end) - 0.1);
    }
    for tracks in [&mut turned, &mut slid] {
        apply(&Amplitude::new(1.7), tracks, &Selector::default());
    }
    for ((_, r), (_, x)) in turned.elements().zip(slid.elements()) {
        let expected = Value::Rotation(turn(0.0, scalar(&x.end) + 0.05, 0.0));
        assert!(r.end.distance(&expected) < 1e-14);
    }
}

#[test]
fn limits_hold_and_are_reported() {
    let mut tracks = elbow(&[2.2, 0.4, 2.2, 0.4]);
    let log = apply(&Amplitude::new(3.0), &mut tracks, &Selector::default());
    for x in ends(&tracks) {
        assert!((0.0..=2.5).contains(&x));
    }
    assert_eq!(log.clamped().len(), 4);
    let mut tracks = build(vec![action(
        "a",
        0.0,
        vec![cycle(
            1,
            vec![
                pose(0.3, 0.0, vec![ball("shoulder_r", 0.0, 1.5, 1.2)]),
                pose(0.3, 0.0, vec![ball("shoulder_r", 0.0, -1.5, -1.2)]),
            ],
        )],
    )]);
    apply(&Amplitude::new(1.8), &mut tracks, &Selector::default());
    let shoulder = tracks.skeleton.link("shoulder_r").unwrap();
    let Some(motion::Limits::Ball(limits)) = tracks.skeleton.links()[shoulder].limits else { panic!() };
    for (_, e) in tracks.elements() {
        let phi = limits.coords(&e.end.rotation().unwrap());
        for i in 0..3 {
            assert!(phi[i] >= limits.ranges[i].lo - 1e-12 && phi[i] <= limits.ranges[i].hi + 1e-12);
        }
    }
}

/// A crescendo: with the factor rising over repetitions each round goes further than the one before.
#[test]
fn a_factor_over_repetitions_grows() {
    let poses =
        || vec![pose(0.3, 0.0, vec![hinge("pelvis_x", 0.2)]), pose(0.3, 0.0, vec![hinge("pelvis_x", 0.0)])];
    let mut tracks = build(vec![action("twist", 0.0, vec![cycle(6, poses())])]);
    let factor = Parameter::OverRepetition(vec![(0.0, 0.5), (5.0, 2.0)]);
    apply(&Amplitude { factor, reference: None }, &mut tracks, &Selector::default());
    let track = tracks.track(dof(&tracks, "pelvis_x")).unwrap();
    let ends: Vec<f64> = track.elements.iter().map(|e| scalar(&e.end)).collect();
    let ranges: Vec<f64> = ends.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    assert!(ranges.windows(2).all(|w| w[1] > w[0]), "{ranges:?}");
    // both transitions about the first pose of round 3 have a = 0.5 + 3 · 0.3
    assert!((ends[6] - (0.1 + 1.4 * 0.1)).abs() < 1e-14, "{}", ends[6]);
}

#[test]
fn bad_parameters_are_refused_and_change_nothing() {
    let mut tracks = dance();
    let all = Selector::default().select(&tracks).unwrap();
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let mut log = EditLog::default();
        let error = Amplitude::new(bad).apply(&mut tracks, &all, &mut log).unwrap_err();
        assert!(matches!(error, EditError::Parameter { edit: "amplitude", .. }), "{error}");
        assert_eq!((&tracks, &log), (&dance(), &EditLog::default()));
    }
    let mut log = EditLog::default();
    let error = Amplitude::about(0.5, vec![0.0; 3]).apply(&mut tracks, &all, &mut log).unwrap_err();
    assert!(matches!(error, EditError::Reference { found: 3, .. }));
}
