//! The log knows who wrote what last, where edits conflict, and a failed edit leaves no trace.

use edits::{
    Amount, Amplitude, EditError, EditLog, ExtentReach, Field, Selection, Selector, Succession, Tension,
    TrackEdit,
};
use motion::{Tracks, Value};

use crate::body::{dance, element};

/// Applies edits as a scene does.
fn run(edits: &[(Box<dyn TrackEdit>, Selector)]) -> (Tracks, EditLog) {
    let (mut tracks, mut log) = (dance(), EditLog::default());
    for (edit, selector) in edits {
        let selection = selector.select(&tracks).unwrap();
        edit.apply(&mut tracks, &selection, &mut log).unwrap();
    }
    (tracks, log)
}

#[test]
fn the_last_writer_of_each_element_is_known() {
    let (tracks, log) = run(&[
        (Box::new(Amplitude::new(1.3)), Selector::label("wave_0")),
        (Box::new(Succession::forward(0.05)), Selector::label("wave")),
        (Box::new(Tension { amount: Amount::Factor(2.0.into()) }), Selector::label("bow_0_0").of(["trunk"])),
        (Box::new(ExtentReach::new(0.9)), Selector::label("wave_1")),
    ]);
    assert_eq!(log.edits(), ["amplitude", "succession", "tension", "extent_reach"]);
    let label = |name| &element(&tracks, name).label;
    assert_eq!(log.last_writer(label("wave_0_0_elbow_r_0")), Some((1, "succession")));
    let fields: Vec<_> = log.fields(label("wave_0_0_elbow_r_0")).collect();
    assert_eq!(fields, [(Field::Start, 1), (Field::End, 0)]);
    assert_eq!(log.last_writer(label("bow_0_0_spine1")), Some((2, "tension")));
    assert_eq!(log.last_writer(label("wave_1_0_elbow_r")), Some((3, "extent_reach")));
    assert_eq!(log.last_writer(label("nod_0_0_neck")), None);
    let text = log.to_string();
    assert!(text.contains("wave_0_0_elbow_r_0: start by succession (edit 1) +"), "{text}");
    assert!(text.contains(", end by amplitude (edit 0) "), "{text}");
    assert!(text.contains("wave_1_0_elbow_r: created by extent_reach (edit 3)\n"), "{text}");
    assert!(log.conflicts().is_empty());
}

#[test]
fn fields_changed_more_than_once_are_listed_in_order() {
    let absolute = |x: f64| Box::new(Tension { amount: Amount::Absolute(x.into()) });
    let (tracks, log) = run(&[
        (absolute(3.0), Selector::label("bow").of(["trunk"])),
        (Box::new(Amplitude::new(1.2)), Selector::label("bow")),
        (absolute(0.5), Selector::label("bow_0_1_spine2")),
    ]);
    let conflicts = log.conflicts();
    assert_eq!(conflicts.len(), 1);
    assert_eq!((conflicts[0].field, &conflicts[0].edits[..]), (Field::Tension, &[0, 2][..]));
    assert_eq!(element(&tracks, "bow_0_1_spine2").tension, 0.5);
    let all = "tension by tension (edit 0) × 3.000, then tension (edit 2) × ";
    assert!(log.to_string().contains(all), "{log}");
    let line = "bow_0_1_spine2: tension changed by tension (edit 0), then tension (edit 2)\n";
    assert!(log.to_string().contains(line), "{log}");
}

/// An edit of a user, which fails half-way.
struct Broken;

impl TrackEdit for Broken {
    fn name(&self) -> &'static str {
        "broken"
    }

    fn change(&self, tracks: &mut Tracks, _: &Selection, log: &mut EditLog) -> Result<(), EditError> {
        for (_, e) in tracks.elements_mut() {
            if matches!(e.end, Value::Scalar(_)) {
                e.end = Value::Scalar(f64::NAN);
            }
        }
        log.note("soon gone");
        Ok(())
    }
}

#[test]
fn a_failed_edit_leaves_no_trace() {
    let (mut tracks, mut log) = run(&[(Box::new(Amplitude::new(1.3)), Selector::label("wave_0"))]);
    let before = (tracks.clone(), log.clone());
    let all = Selector::default().select(&tracks).unwrap();
    let error = Broken.apply(&mut tracks, &all, &mut log).unwrap_err();
    assert_eq!(
        error.to_string(),
        "broken: the result for bow_0_0_pelvis_y is not finite, or takes negative time"
    );
    assert_eq!((tracks, log), before);
}
