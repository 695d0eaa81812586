//! A program that is not the command line does everything that the commands do, with the crates alone.
//!
//! Each test is the thinnest such program: what a command is asked, done by calls, and its results found on disk.

use std::path::{Path, PathBuf};

use studies::{push, retarget as retargetings, tune};
use takes::results::analysis_write::{AnalysisWhat, Table};
use takes::{Ask, Engines, Progress, What};

/// Files that `dir` must hold.
fn holds(dir: &Path, files: &[&str]) {
    for file in files {
        assert!(dir.join(file).is_file(), "no {file} in {}", dir.display());
    }
}

fn folder() -> (tempfile::TempDir, PathBuf) {
    let temp = tempfile::tempdir().unwrap();
    let out = temp.path().join("out");
    (temp, out)
}

#[test]
fn slow_renders_and_analyzes() {
    let (_temp, out) = folder();
    let progress = Progress::silent();
    let take = takes::open(support::scene("bow.ron"), &Ask::default()).unwrap();
    let performed = take.perform(&Engines::default(), &progress).unwrap();
    let written = performed.write(&out, &What { figures: false, ..What::default() }, &progress).unwrap();
    assert!(written.undrawn.is_empty() && performed.diverged().is_none());
    holds(&out, &["dynamic.bvh", "dynamic.glb", "kinematic.bvh", "trace.npz", "report.json"]);

    let found = takes::analysis::open(&out, None, &formats::bvh::ImportOptions::default()).unwrap();
    let analysis = found.analyze(&Default::default()).unwrap();
    let what = AnalysisWhat { tables: vec![Table::Csv], sink_m: None, reads: vec![out.clone()] };
    let (_temp, forces) = folder();
    found.write(&analysis, &forces, &what, &progress).unwrap();
    holds(&forces, &["analysis.csv", "report.json"]);
}

#[test]
fn slow_pushes() {
    let (_temp, out) = folder();
    let take = takes::open(support::scene("stand.ron"), &Ask::default()).unwrap();
    let engines = Engines::default();
    let settings = push::PushSettings { directions: 2, tolerance: 0.5, ..Default::default() };
    let mut map = push::map(&take, settings, take.searcher(&engines).unwrap(), &|_| {}).unwrap();
    map.write(&out, false, &take.files, &Progress::silent()).unwrap();
    assert!(map.min_ratio > 0.0);
    holds(&out, &["report.json"]);
}

#[test]
fn slow_tunes() {
    let (_temp, out) = folder();
    let take = takes::open(support::scene("bow.ron"), &Ask::default()).unwrap();
    let engines = Engines::default();
    let mut spec = take.tune.clone();
    spec.parameters.truncate(2);
    let search = tune::Search {
        solver: tune::SolverKind::NelderMead,
        seed: 7,
        evaluations: 4,
        start: None,
        step: 0.3,
    };
    let session = tune::Session { spec, search, slices: 0, directions: 0, figures: false, fresh: true };
    let engine = take.engine(&engines).unwrap();
    let (report, _) = session.run(&take, engine, None, &out, &mut |_| {}, &Progress::silent()).unwrap();
    assert_eq!(report.parameters.len(), 2);
    holds(&out, &["report.json"]);
}

#[test]
fn retargets() {
    let (_temp, out) = folder();
    let import = formats::bvh::ImportOptions::default();
    let session = takes::retargeting::Session::open(
        &support::scene("performances/anger.ron"),
        &support::scene("characters/lamp.ron"),
        None,
        &import,
    )
    .unwrap();
    let options = retarget::Options { rate_hz: Some(30.0), ..Default::default() };
    let done = session.run(&session.learn(&options).unwrap(), &options).unwrap();
    let run = takes::retargeting::RetargetReport::new(&session, options.model, &done, Vec::new());
    let mut report = retargetings::StudiedReport { run, models: Vec::new(), study: None };
    let progress = Progress::silent();
    retargetings::results::write(&session, &done, &mut report, &out, false, &[], &progress).unwrap();
    holds(&out, &["retargeted.bvh", "retargeted.glb", "human.bvh", "report.json"]);
}

#[test]
fn crosschecks() {
    let (_temp, out) = folder();
    let options = crosscheck::Options { states: 5, states_only: true, ..Default::default() };
    let human = support::scene("characters/human.ron");
    let cross = crosscheck::run(&human, &options, &mut |_| {}).unwrap();
    assert!(!cross.checks.is_empty());
    assert_eq!(cross.failed(), 0);
    crosscheck::results::write(&cross, &out, &[human], &Progress::silent()).unwrap();
    holds(&out, &["crosscheck.html"]);
}
