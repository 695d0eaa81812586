//! A program reads and writes elements; what it writes is logged like any edit.

use edits::{Argument, EditError, EditLog, Selector, Succession, TrackEdit};
use motion::{Tracks, Value};

use crate::body::dance;
use crate::{program, read};

/// Applies a text to the dance.
fn edited(text: &str, on: &str) -> Result<(Tracks, EditLog), EditError> {
    let mut tracks = dance();
    let mut log = EditLog::default();
    let selector = if on.is_empty() { Selector::default() } else { Selector::label(on) };
    let selection = selector.select(&tracks)?;
    program(text).apply(&mut tracks, &selection, &mut log)?;
    Ok((tracks, log))
}

fn fault(body: &str) -> String {
    edited(&format!("fn elements(script, params) {{\n    {body}\n}}"), "").unwrap_err().to_string()
}

/// The built-in succession, and the same in thirty lines of the language: the same bytes.
#[test]
fn succession_written_again_is_the_same() {
    let text = include_str!("../../../scenes/programs/succession.rhai");
    let code = text.lines().filter(|l| !l.trim_start().starts_with("//") && !l.is_empty()).count();
    assert!(code <= 30, "{code} lines");
    for (reverse, on, offset_s) in
        [(false, "", 0.07), (true, "", 0.07), (false, "bow", 0.3), (true, "wave", 0.31)]
    {
        let arguments = [("offset_s", Argument::Number(offset_s)), ("reverse", Argument::Flag(reverse))];
        let own = read(text, &arguments).unwrap();
        let built_in = if reverse { Succession::reverse(offset_s) } else { Succession::forward(offset_s) };
        let before = dance();
        let selector = if on.is_empty() { Selector::default() } else { Selector::label(on) };
        let Ok(selection) = selector.select(&before) else { continue };
        let (mut a, mut b) = (before.clone(), before.clone());
        built_in.apply(&mut a, &selection, &mut EditLog::default()).unwrap();
        own.apply(&mut b, &selection, &mut EditLog::default()).unwrap();
        assert_ne!(a, before, "{on}: nothing to compare");
        assert_eq!(a, b, "{on}");
        let bits = |t: &Tracks| t.sample(120.0).data().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&a), bits(&b), "{on}");
    }
}

/// Every field is read and written; the log names the fields, with the file of the program.
#[test]
fn fields_are_read_and_written() {
    let text = r#"
        fn elements(script, params) {
            for e in script {
                e.start_s += 0.25; e.duration_s = e.duration_s * 2; e.hold_s = 1; e.tension *= 3;
                e.curve = if e.curve == "Linear" { "ease-in" } else { [0.1, 0.2, 0.3, 1] };
            }
            script.note(`${script.len} of ${script.tracks.len} tracks`);
        }"#;
    let before = dance();
    let (after, log) = edited(text, "").unwrap();
    for ((_, a), (_, b)) in before.elements().zip(after.elements()) {
        assert_eq!(
            (a.start_s + 0.25, a.duration_s * 2.0, 1.0, a.tension * 3.0),
            (b.start_s, b.duration_s, b.hold_s, b.tension)
        );
        assert_eq!(a.end, b.end);
        assert_ne!(a.curve, b.curve);
    }
    assert!((after.duration_s - before.duration_s).abs() > 0.1);
    let words = log.to_string();
    for field in [
        "start by program (edit 0)",
        "duration by program",
        "curve by program",
        "tension by program",
        "mine.rhai",
    ] {
        assert!(words.contains(field), "{field}: {words}");
    }
    assert!(
        words.contains(&format!("{} of {} tracks", before.elements().count(), before.tracks.len())),
        "{words}"
    );
}

/// Ends are in degrees, those of balls as scenes write them; a value written back unchanged is unchanged to the bit.
#[test]
fn ends_are_in_degrees() {
    let same = "fn elements(script, params) { for e in script { if e.joint.ends_with(\"_y\") { e.end_m = e.end_m; } else { e.end_deg = e.end_deg; } } }";
    let (after, log) = edited(same, "").unwrap();
    assert_eq!(after, dance());
    assert_eq!(log.written_by(0).len(), 0);
    let turned = "fn elements(script, params) { for e in script { if type_of(e.end_deg) == \"f64\" { e.end_deg += 10; } else { e.turn_deg([0, 0, 20]); } } }";
    let balls = edited(turned, "wave").unwrap().0;
    for ((dof, a), (_, b)) in dance().elements().zip(balls.elements()) {
        if *a.label.action != *"wave" {
            assert_eq!(a, b);
            continue;
        }
        let moved = a.end.distance(&b.end).to_degrees();
        let wanted = if matches!(a.end, Value::Scalar(_)) { 10.0 } else { 20.0 };
        assert!((moved - wanted).abs() < 1e-9, "{dof:?}: {moved}"); // 1e-14 seen
    }
}

/// What is wrong is said with line and column of the user's file, and the tracks stay as they were.
#[test]
fn faults_have_their_place() {
    for (body, message, place) in [
        (
            "for e in script { e.start_s = 0.0 / 0.0; }",
            "start_s is NaN; allowed: a finite number",
            "mine.rhai:2:25",
        ),
        ("let e = script[\"wavy_0_1\"];", "there is no element with the label `wavy_0_1`", "mine.rhai:2:"),
        ("script.under(\"wavy\");", "unknown label `wavy`", "mine.rhai:2:12"),
        ("for e in script { e.duration_s = -1; }", "duration_s is -1; allowed: 0 or more", "mine.rhai:2:25"),
        ("for e in script { e.end_m = 1; }", "is a", "mine.rhai:2:"),
        ("for e in script { e.start = 1; }", "No writable property 'start'", "mine.rhai:2:"),
        ("for e in script { e.curve = \"eas\"; }", "unknown curve `eas`", "mine.rhai:2:"),
        ("let x = params.amount;", "amount", "mine.rhai:2:"),
        ("let x = wobble(3);", "wobble", "mine.rhai:2:"),
    ] {
        let said = fault(body);
        assert!(said.contains(message) && said.contains(place), "{body}: {said}");
    }
}
