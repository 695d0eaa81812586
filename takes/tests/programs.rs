//! Programs of the user in scenes: the examples that ship, and what is wrong at its place.

use std::path::{Path, PathBuf};

use sim::Engines;
use takes::{Ask, Input, Progress, Take, open};

fn scene(name: &str) -> PathBuf {
    support::root().join("scenes").join(format!("{name}.ron"))
}

fn take(name: &str) -> Take {
    open(scene(name).as_path(), &Ask::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// A scene of the human, with a program beside it.
fn of(program: &str, rest: &str) -> Result<Take, String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mine.rhai"), program).unwrap();
    let ron = format!(
        r#"Scene(
    character: "library:characters/human.ron",
    script: [Action(name: "nod", cycles: [Cycle(poses: [Pose(duration_s: 0.2, set_deg: {{"elbow_r": 20}})])])],
    {rest}
    settle_s: 0.1,
)"#
    );
    let base = folder.path().to_owned();
    open(Input::Text { ron, base }, &Ask::default()).map_err(|e| e.to_string())
}

/// Edits are in the log with their file, and move what they are for.
#[test]
fn examples_open_and_are_logged() {
    let take = take("hips-lead");
    let log = take.log.to_string();
    assert!(log.contains("start by program (edit 0)") && log.contains("hips-lead.rhai"), "{log}");
    // the hand arrives after the pelvis, which it did not before
    let tracks = take.asked.tracks.as_ref().unwrap();
    let arrives = |name: &str| {
        let found = tracks.elements().find(|(_, e)| e.label.named(&tracks.skeleton) == name);
        found.unwrap_or_else(|| panic!("{name}")).1.arrives_s()
    };
    assert!(arrives("turn_0_0_wrist_r_0") - arrives("turn_0_0_pelvis_0") > 0.3);

    let breathing = self::take("breathing");
    let change = &breathing.log.clip_changes()[0];
    let chest = change.turned.as_ref().unwrap();
    assert!(chest.link == "chest" && chest.amount > 7.0 && chest.amount < 12.0, "{change}");
    assert_eq!(self::take("tremor").conditions.programs.len(), 1);
}

/// Faults are in the program's file, parameters in the scene.
#[test]
fn faults_are_where_they_are() {
    let elements = "fn elements(script, params) {\n  for e in script { e.start_s = 0.0 / 0.0; }\n}";
    let react = "fn params() { #{ amount: 1.0 } }\nfn react(body, params) { }";
    for (program, rest, message, place) in [
        (elements, "edits: [Program(file: \"mine.rhai\")],", "start_s is NaN", "mine.rhai:2:"),
        (
            react,
            "reactive: [Program(file: \"mine.rhai\", params: {\"amout\": 2})],",
            "has no parameter `amout`; did you mean `amount`?",
            "scene.ron:4:",
        ),
        (react, "edits: [Program(file: \"mine.rhai\")],", "found neither", "scene.ron:4:"),
        (
            elements,
            "reactive: [Program(file: \"mine.rhai\")],",
            "needs `fn react(body, params)`",
            "mine.rhai:1:1",
        ),
        (
            elements,
            "edits: [Warp(times_s: [(0, 0), (0.1, 0.15)]), Program(file: \"mine.rhai\")],",
            "`warp` before it",
            "scene.ron:4:",
        ),
        (elements, "edits: [Program(file: \"other.rhai\")],", "other.rhai", "scene.ron:4:"),
        (elements, "edits: [Program(file: \"mine.rhai\", on: \"nodd\")],", "nodd", "scene.ron:4:"),
    ] {
        let said = of(program, rest).map(|_| ()).unwrap_err();
        assert!(said.contains(message) && said.contains(place), "{rest}: {said}");
    }
}

/// A program that fails while the body moves ends the run as bad input, at its line; one that writes turns goals.
#[test]
fn reactions_act_and_fail_in_the_pass() {
    let perform = |program: &str| {
        let take = of(program, "root: Pinned, reactive: [Program(file: \"mine.rhai\")],").unwrap();
        take.perform(&Engines::default(), &Progress::silent())
    };
    let failed = perform(
        "fn react(body, params) {\n  if body.time_s > 0.1 { body[\"neck\"].tension = 0.0 / 0.0; }\n}",
    );
    let error = failed.err().unwrap();
    assert!(error.is_input() && error.to_string().contains("mine.rhai:2:"), "{error}");
    let done = perform("fn react(body, params) { body[\"elbow_l\"].turn_deg = 25; }").unwrap();
    let outcome = done.outcome().unwrap();
    assert!(outcome.reactive[0].contains("elbow_l turned by at most 25.00°"), "{:?}", outcome.reactive);
}

/// The same bytes on any number of threads.
#[test]
fn threads_do_not_matter() {
    let bits = || {
        let take = of(
            "fn memory() { #{ n: 0 } }\nfn react(body, params) { this.n += 1; body[\"neck\"].turn_deg = [0, 20 * noise(this.n, 9 * body.time_s) * sin(body.com_m[1]), 0]; }",
            "root: Pinned, reactive: [Program(file: \"mine.rhai\")],",
        );
        let done = take.unwrap().perform(&Engines::default(), &Progress::silent()).unwrap();
        let trace = &done.outcome().unwrap().trace;
        (0..trace.rows())
            .flat_map(|row| trace.pose(row).iter().map(|x| x.to_bits()).collect::<Vec<_>>())
            .collect::<Vec<u64>>()
    };
    let one = bits();
    let several: Vec<_> = std::thread::scope(|s| {
        let runs: Vec<_> = (0..3).map(|_| s.spawn(bits)).collect();
        runs.into_iter().map(|r| r.join().unwrap()).collect()
    });
    assert!(several.iter().all(|other| *other == one));
    assert!(one.len() > 1000);
}

/// Every program that ships is read, and says what it does.
#[test]
fn programs_that_ship_are_read() {
    for entry in scenes::library::entries().filter(|e| e.folder() == "programs") {
        let program = programs::Program::read(Path::new(entry.name()), entry.text(), &Default::default());
        assert!(!program.unwrap_or_else(|e| panic!("{e}")).parameters().is_empty(), "{}", entry.name());
    }
}
