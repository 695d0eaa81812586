//! Each level of selection touches exactly the labels it names.

use edits::{Amount, EditError, Parameter, Place, Selector, Tension};

use crate::body::{apply, dance, names};

/// Selects, doubles the tension there, and checks both the selection and what the edit touched.
fn touches(selector: &Selector, expected: &[&str]) {
    let mut tracks = dance();
    let before = tracks.clone();
    let selection = selector.select(&tracks).unwrap();
    assert_eq!(names(&tracks, selection.labels()), expected, "{selector:?}");
    let log = apply(&Tension { amount: Amount::Factor(Parameter::Constant(2.0)) }, &mut tracks, selector);
    for ((_, new), (_, old)) in tracks.elements().zip(before.elements()) {
        let name = new.label.named(&tracks.skeleton);
        let factor = if expected.contains(&name.as_str()) { 2.0 } else { 1.0 };
        assert_eq!(new.tension, old.tension * factor, "{name}");
    }
    assert_eq!(names(&tracks, log.written_by(0)), expected);
}

const BOW_1: [&str; 6] = [
    "bow_0_0_elbow_l",
    "bow_0_0_knee_l",
    "bow_0_0_pelvis_y",
    "bow_0_0_shoulder_l",
    "bow_0_0_spine1",
    "bow_0_0_spine2",
];
const BOW_2: [&str; 5] =
    ["bow_0_1_elbow_l", "bow_0_1_pelvis_y", "bow_0_1_shoulder_l", "bow_0_1_spine1", "bow_0_1_spine2"];
const WAVE_CYCLE: [&str; 12] = [
    "wave_0_0_elbow_r_0",
    "wave_0_0_elbow_r_1",
    "wave_0_0_elbow_r_2",
    "wave_0_0_shoulder_r_0",
    "wave_0_0_shoulder_r_1",
    "wave_0_0_shoulder_r_2",
    "wave_0_1_elbow_r_0",
    "wave_0_1_elbow_r_1",
    "wave_0_1_elbow_r_2",
    "wave_0_1_shoulder_r_0",
    "wave_0_1_shoulder_r_1",
    "wave_0_1_shoulder_r_2",
];

fn wave() -> String {
    "wave".into()
}

#[test]
fn script() {
    let mut all = [BOW_1.as_slice(), &BOW_2, &["nod_0_0_neck"], &WAVE_CYCLE].concat();
    all.push("wave_1_0_shoulder_r");
    touches(&Selector::default(), &all);
}

#[test]
fn action_and_set() {
    let bow = [BOW_1.as_slice(), &BOW_2].concat();
    touches(&Selector::at(Place::Action("bow".into())), &bow);
    touches(&Selector::label("bow"), &bow);
    let set = [&bow, ["nod_0_0_neck"].as_slice()].concat();
    touches(&Selector::at(Place::Actions(vec!["nod".into(), "bow".into()])), &set);
}

#[test]
fn cycle_and_repetition() {
    touches(&Selector::at(Place::Cycle { action: wave(), cycle: 0 }), &WAVE_CYCLE);
    touches(&Selector::label("wave_0"), &WAVE_CYCLE);
    touches(&Selector::label("wave_1"), &["wave_1_0_shoulder_r"]);
    touches(
        &Selector::at(Place::Repetition { action: wave(), cycle: 0, repetition: 1 }),
        &["wave_0_0_elbow_r_1", "wave_0_0_shoulder_r_1", "wave_0_1_elbow_r_1", "wave_0_1_shoulder_r_1"],
    );
}

#[test]
fn pose() {
    let at = |repetition| Selector::at(Place::Pose { action: wave(), cycle: 0, pose: 1, repetition });
    touches(&at(None), &WAVE_CYCLE[6..]);
    touches(&at(Some(2)), &["wave_0_1_elbow_r_2", "wave_0_1_shoulder_r_2"]);
    touches(&Selector::label("bow_0_1"), &BOW_2);
}

#[test]
fn element() {
    touches(&Selector::label("bow_0_1_spine2"), &["bow_0_1_spine2"]);
    // DOFs: pelvis x y z, pelvis, spine1, spine2, neck, then the left arm: clavicle 7, shoulder 8, elbow 9
    touches(&Selector::label("bow_0_1_9"), &["bow_0_1_elbow_l"]);
    touches(&Selector::label("wave_0_1_elbow_r"), &WAVE_CYCLE[6..9]);
    touches(&Selector::label("wave_0_1_elbow_r_2"), &["wave_0_1_elbow_r_2"]);
    touches(&Selector::label("wave_0_1_13_2"), &["wave_0_1_elbow_r_2"]);
    touches(&Selector::label("nod_0_0_neck"), &["nod_0_0_neck"]);
}

#[test]
fn body_parts_links_and_dofs() {
    touches(&Selector::label("bow_0_0").of(["trunk"]), &["bow_0_0_spine1", "bow_0_0_spine2"]);
    touches(&Selector::label("bow").of(["elbow_l"]), &["bow_0_0_elbow_l", "bow_0_1_elbow_l"]);
    touches(
        &Selector::label("bow").of(["pelvis_y", "knee_l"]),
        &["bow_0_0_knee_l", "bow_0_0_pelvis_y", "bow_0_1_pelvis_y"],
    );
    touches(&Selector::label("bow").of(["arm_r"]), &[]);
}

#[test]
fn unknown_names_are_answered_with_the_nearest_and_all() {
    let tracks = dance();
    let words = |s: Selector| s.select(&tracks).unwrap_err().to_string();
    assert_eq!(
        words(Selector::at(Place::Action("wvae".into()))),
        "unknown action `wvae`; did you mean `wave`? There are: bow, wave, nod"
    );
    assert_eq!(
        words(Selector::at(Place::Action("somersault".into()))),
        "unknown action `somersault`; there are: bow, wave, nod"
    );
    let part = words(Selector::default().of(["arm_x"]));
    assert!(
        part.starts_with("unknown body part `arm_x`; did you mean `arm_l`? There are: arm_l, arm_r"),
        "{part}"
    );
    let label = words(Selector::label("bow_0_1_spin2"));
    assert!(label.starts_with("unknown label `bow_0_1_spin2`; did you mean `bow_0_1_spine2`?"), "{label}");
    assert_eq!(
        words(Selector::at(Place::Pose { action: wave(), cycle: 0, pose: 2, repetition: None })),
        "cycle 0 of action \"wave\" has no pose 2; it has 2, counted from 0"
    );
    let far = Place::Repetition { action: wave(), cycle: 0, repetition: 3 };
    assert!(matches!(Selector::at(far).select(&tracks), Err(EditError::Index { exist: 3, .. })));
    assert!(
        words(Selector::at(Place::Cycle { action: wave(), cycle: 7 })).contains("has no cycle 7; it has 2")
    );
}
