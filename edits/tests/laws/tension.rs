//! Tension is written to elements, and to the base where nothing else would carry it.

use edits::{Amount, Parameter, Selector, Tension};

use crate::body::{apply, dance, element};

fn factor(p: impl Into<Parameter>) -> Tension {
    Tension { amount: Amount::Factor(p.into()) }
}

fn base_changed(tracks: &motion::Tracks) -> Vec<&str> {
    let links = tracks.skeleton.links().iter().zip(&tracks.base_tension);
    links.filter(|(_, t)| **t != 1.0).map(|(l, _)| l.name.as_str()).collect()
}

#[test]
fn the_whole_script_takes_the_base_along() {
    let mut tracks = dance();
    apply(&factor(3.0), &mut tracks, &Selector::default());
    assert!(tracks.elements().all(|(_, e)| e.tension == 3.0));
    // all but the welded fingers
    assert_eq!(base_changed(&tracks).len(), tracks.skeleton.links().len() - 2);
}

/// A tense arm is tense down to the wrist, which no element moves; the elbow keeps its base.
#[test]
fn a_named_part_takes_joints_that_never_move() {
    let mut tracks = dance();
    apply(&factor(4.0), &mut tracks, &Selector::label("wave").of(["arm_r"]));
    assert_eq!(base_changed(&tracks), ["wrist_r"]);
    assert_eq!(element(&tracks, "wave_0_1_elbow_r_2").tension, 4.0);
    let mut tracks = dance();
    apply(&factor(4.0), &mut tracks, &Selector::label("wave"));
    assert!(base_changed(&tracks).is_empty());
}

#[test]
fn absolute_values_replace_and_factors_multiply() {
    let mut tracks = dance();
    apply(&Tension { amount: Amount::Absolute(2.5.into()) }, &mut tracks, &Selector::label("bow"));
    apply(&factor(2.0), &mut tracks, &Selector::label("bow_0_1"));
    assert_eq!(element(&tracks, "bow_0_0_spine1").tension, 2.5);
    assert_eq!(element(&tracks, "bow_0_1_spine1").tension, 5.0);
    assert_eq!(element(&tracks, "nod_0_0_neck").tension, 1.0);
}

#[test]
fn tension_may_grow_over_time_or_rounds() {
    let mut tracks = dance();
    apply(&factor(Parameter::OverTime(vec![(0.5, 1.0), (2.5, 5.0)])), &mut tracks, &Selector::label("wave"));
    for name in ["wave_0_0_elbow_r_0", "wave_0_1_elbow_r_1", "wave_1_0_shoulder_r"] {
        let e = element(&tracks, name);
        assert!((e.tension - (1.0 + 2.0 * (e.start_s - 0.5))).abs() < 1e-14, "{name}");
    }
    let mut tracks = dance();
    apply(
        &factor(Parameter::OverRepetition(vec![(0.0, 1.0), (2.0, 2.0)])),
        &mut tracks,
        &Selector::label("wave_0"),
    );
    assert_eq!(element(&tracks, "wave_0_0_elbow_r_1").tension, 1.5);
}
