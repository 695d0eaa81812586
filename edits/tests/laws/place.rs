//! Where edits apply: one value for both kinds, as selectors of tracks and as a span and DOFs of a clip.

use std::sync::Arc;

use edits::{Motion, Place, Selector, Where};
use motion::Dof;

use crate::body::{action, build, cycle, hinge, pose};
use crate::clip_body::{WALK, danced};

fn on(labels: &[&str], repetition: Option<usize>) -> Where {
    Where { on: labels.iter().map(|l| (*l).to_owned()).collect(), repetition, ..Where::default() }
}

#[test]
fn track_edits_get_a_selector_for_each_label() {
    assert_eq!(on(&[], None).selectors().unwrap(), [Selector::default()]);
    assert_eq!(on(&[""], None).selectors().unwrap(), [Selector::default()]);
    assert_eq!(
        on(&["wave", "bow_0_1"], None).of(["arm_r"]).selectors().unwrap(),
        [Selector::label("wave").of(["arm_r"]), Selector::label("bow_0_1").of(["arm_r"])]
    );
    let action = || "wave".to_owned();
    assert_eq!(
        on(&["wave_0", "wave_0_1"], Some(2)).selectors().unwrap(),
        [
            Selector::at(Place::Repetition { action: action(), cycle: 0, repetition: 2 }),
            Selector::at(Place::Pose { action: action(), cycle: 0, pose: 1, repetition: Some(2) })
        ]
    );
    let words = |place: Where| place.selectors().unwrap_err().to_string();
    let needs =
        "`repetition: 2` needs a cycle or a pose in `on`, such as \"twist_0\" or \"twist_0_1\"; found";
    assert_eq!(words(on(&["wave"], Some(2))), format!("{needs} \"wave\""));
    assert_eq!(words(on(&[], Some(2))), format!("{needs} \"\""));
    assert_eq!(
        words(Where::span(0.0, 1.0)),
        "`span_s` is of clip edits; a track edit applies to labels: use `on` and `repetition`"
    );
}

/// From the first start to the last end of the elements, holds included; parts do not narrow the time.
#[test]
fn labels_are_a_span_of_the_clip() {
    let dance = danced();
    let span = |place: Where| {
        let place = place.in_clip(&dance).unwrap();
        (place.from_s, place.to_s)
    };
    let tracks = crate::body::dance();
    let ends = |name: &str| {
        let all: Vec<_> =
            tracks.elements().filter(|(_, e)| e.label.named(&tracks.skeleton).starts_with(name)).collect();
        let from = all.iter().map(|(_, e)| e.start_s).fold(f64::INFINITY, f64::min);
        (from, all.iter().map(|(_, e)| e.ends_s()).fold(0.0, f64::max))
    };
    assert_eq!(span(Where::default()), (0.0, dance.clip.duration_s()));
    let wave = span(Where::label("wave")); // it ends with the clip, whose time is rounded
    assert!(wave.0 == 0.5 && (wave.1 - ends("wave").1).abs() < 1e-12, "{wave:?}");
    assert_eq!(span(Where::label("bow_0_1")), ends("bow_0_1"));
    assert_eq!(span(Where::label("bow_0_1").of(["neck"])), ends("bow_0_1"));
    assert_eq!(span(on(&["nod", "wave_1"], None)), (ends("nod").0, 2.8));
    let (second, wave) = (span(on(&["wave_0"], Some(1))), ends("wave_0"));
    assert!((second.0 - 1.1).abs() < 1e-12 && (second.1 - 1.7).abs() < 1e-12, "{second:?} in {wave:?}");
    // with a span: what both have in common
    let both = Where { span_s: Some((1.0, 1.5)), ..Where::label("wave_0") };
    assert_eq!(span(both), (1.0, 1.5));
    let both = Where { span_s: Some((0.0, 0.9)), ..Where::label("wave_0") };
    assert_eq!(span(both), (0.5, 0.9));
}

#[test]
fn parts_are_sets_of_dofs() {
    let dance = danced();
    let s = &dance.clip.skeleton;
    let names = |parts: &[&str]| -> Vec<String> {
        let place = Where::default().of(parts.iter().copied()).in_clip(&dance).unwrap();
        Dof::all(s).into_iter().filter(|d| place.allows(*d)).map(|d| d.name(s)).collect()
    };
    assert_eq!(names(&["trunk", "elbow_r"]), ["spine1", "spine2", "elbow_r"]);
    assert_eq!(names(&["pelvis_y"]), ["pelvis_y"]);
    assert_eq!(names(&["pelvis"]), ["pelvis_x", "pelvis_y", "pelvis_z", "pelvis"]);
    assert_eq!(names(&[]).len(), Dof::all(s).len());
}

#[test]
fn places_that_are_not_in_the_clip_are_refused() {
    let words = |place: Where| place.in_clip(&danced()).unwrap_err().to_string();
    let allowed = "allowed: the first below the second, both within 0 s to 2.800 s";
    assert_eq!(words(Where::span(1.0, 3.0)), format!("`span_s` is 1 s to 3 s; {allowed}"));
    assert_eq!(words(Where::span(2.0, 1.5)), format!("`span_s` is 2 s to 1.5 s; {allowed}"));
    assert_eq!(words(Where::span(-1.0, f64::NAN)), format!("`span_s` is -1 s to NaN s; {allowed}"));
    let apart = Where { span_s: Some((0.1, 0.4)), ..Where::label("wave") };
    let wave = "`on: \"wave\"` is 0.500 s to 2.800 s of the clip";
    assert_eq!(words(apart), format!("{wave}, which has nothing in common with 0.100 s to 0.400 s"));
    assert!(words(Where::label("wvae")).starts_with("unknown label `wvae`; did you mean `wave`?"));
    assert!(
        words(Where::default().of(["arm_x"])).starts_with("unknown body part `arm_x`; did you mean `arm_l`?")
    );
    // a pose of pauses has no elements
    let bend = pose(0.3, 0.0, vec![hinge("elbow_r", 1.0)]);
    let naps = build(vec![action("nap", 0.0, vec![cycle(2, vec![pose(0.5, 0.0, Vec::new()), bend])])]);
    let nap = Motion { tracks: Some(Arc::new(naps.clone())), ..Motion::of(naps.sample(50.0)) };
    assert_eq!(
        on(&["nap_0_0"], Some(0)).in_clip(&nap).unwrap_err().to_string(),
        "`on: \"nap_0_0\"` takes no time; a clip edit needs elements with a duration or a hold"
    );
    // half a frame beyond the end is the end
    assert_eq!(Where::span(1.0, 2.809).in_clip(&danced()).unwrap().to_s, 2.8);
    let none = Where::label("wave").in_clip(&WALK).unwrap_err().to_string();
    assert_eq!(
        none,
        "`on: \"wave\"` names labels of a script, and this motion has none; use `span_s: (from, to)` within 0 s to 4.000 s"
    );
    assert_eq!(on(&[""], None).in_clip(&WALK).unwrap(), Where::default().in_clip(&WALK).unwrap());
}
