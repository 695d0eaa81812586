//! A program reads and writes frames; what it writes is measured and logged like any edit of clips.

use edits::{Argument, ClipEdit, EditError, EditLog, Edited, Motion, Where};
use motion::{Clip, Kinematics};

use crate::body::{base, skeleton};
use crate::{program, read};

/// Two seconds of standing still at 60 Hz.
fn still() -> Motion {
    let s = skeleton();
    let q = base(&s);
    Motion::of(Clip::new(s, 60.0, q.repeat(121)))
}

fn edited(text: &str, at: &Where) -> Result<(Edited, EditLog), EditError> {
    let mut log = EditLog::default();
    let edited = program(text).apply(&still(), at, &mut log)?;
    Ok((edited, log))
}

/// A hinge, a ball and the root change by what was asked, within the span only; the log measures it.
#[test]
fn frames_are_changed_within_the_span() {
    let text = r#"
        fn clip(clip, params) {
            for frame in clip {
                let w = frame.fade(0.25);
                frame["elbow_r"].angle_deg += 12 * w;
                frame["neck"].turn_deg([0, 20 * w, 0]);
                let at = frame.root_m;
                at[1] += 0.03 * w;
                frame.root_m = at;
            }
            clip.note(`${clip.first} to ${clip.last} of ${clip.frames}`);
        }"#;
    let (after, log) = edited(text, &Where::span(0.5, 1.5)).unwrap();
    let before = still().clip;
    let change = &log.clip_changes()[0];
    assert!(change.from_s > 0.5 && change.to_s < 1.5, "{change}");
    let turned = change.turned.as_ref().unwrap();
    assert!(turned.link == "neck" && (turned.amount - 20.0).abs() < 1e-9, "{change}"); // 1e-14 seen
    assert!((change.moved.as_ref().unwrap().amount - 30.0).abs() < 1e-9);
    assert_eq!(change.joints, ["pelvis", "neck", "elbow_r"]);
    assert_eq!(after.clip.pose(30), before.pose(30));
    assert!(log.to_string().contains("30 to 90 of 121"), "{log}");
}

/// Places are those of the pose as written so far: two roads to one number.
#[test]
fn places_follow_what_is_written() {
    let text = r#"
        fn params() { #{ want: [0.0] } }
        fn clip(clip, params) {
            let frame = clip[7];
            let before = frame.place_m("wrist_r");
            frame["elbow_r"].angle_deg = 80;
            let after = frame.place_m("wrist_r");
            frame["neck"].turn_deg([0, length([after[0] - before[0], after[1] - before[1], after[2] - before[2]]), 0]);
        }"#;
    let after = edited(text, &Where::default()).unwrap().0.clip;
    let s = after.skeleton.clone();
    let wrist = s.link("wrist_r").unwrap();
    let place = |q: &[f64]| Kinematics::new(&s, q).origin(wrist);
    let moved_m = (place(after.pose(7)) - place(after.pose(6))).norm();
    let neck = s.link("neck").unwrap();
    let turned_deg =
        (s.rotation(after.pose(7), neck) * s.rotation(after.pose(6), neck).inverse()).angle().to_degrees();
    assert!(moved_m > 0.1 && (turned_deg - moved_m).abs() < 1e-9, "{turned_deg} {moved_m}");
}

/// What is outside the place of the edit is read and not written; names are checked; retiming is that of `Warp`.
#[test]
fn places_of_the_edit_are_kept() {
    let fault = |body: &str, at: &Where| {
        let text = format!("fn clip(clip, params) {{\n    {body}\n}}");
        edited(&text, at).unwrap_err().to_string()
    };
    let span = Where::span(0.5, 1.0);
    let said = fault("clip[0][\"neck\"].turn_deg([1, 0, 0]);", &span);
    assert!(
        said.contains("frame 0 is at 0.000 s, outside the span of the edit, 0.500 s to 1.000 s"),
        "{said}"
    );
    let said = fault("for f in clip { f[\"neck\"].turn_deg([1, 0, 0]); }", &Where::default().of(["elbow_r"]));
    assert!(
        said.contains("neck is not among the `parts` of the edit: elbow_r") && said.contains("mine.rhai:2:"),
        "{said}"
    );
    let said = fault("clip[0][\"nek\"];", &span);
    assert!(said.contains("there is no joint `nek`; did you mean `neck`?"), "{said}");
    let said = fault("clip[0][\"elbow_r\"].angle_deg = 0.0 / 0.0;", &Where::default());
    assert!(said.contains("angle_deg is NaN; allowed: a finite number"), "{said}");
    let said = fault("clip[900];", &span);
    assert!(said.contains("the clip has 121 frames, counted from 0; found 900"), "{said}");

    let late = "fn clip(clip, params) { clip.retime([[0, 0], [1, 1.5], [2, 2.5]]); }";
    let (after, log) = edited(late, &Where::default()).unwrap();
    assert!((after.clip.duration_s() - 2.5).abs() < 1e-9 && log.clip_changes()[0].slopes.is_some());
}

/// The example that ships, on a body with other joints than it names.
#[test]
fn breathing_says_what_the_body_lacks() {
    let text = include_str!("../../../scenes/programs/breathing.rhai");
    let own = read(text, &[("breath_s", Argument::Number(2.0))]).unwrap();
    let said = own.apply(&still(), &Where::default(), &mut EditLog::default()).unwrap_err().to_string();
    assert!(said.contains("there is no joint `abdomen`") && said.contains("mine.rhai:"), "{said}");
}
