//! Succession, amplitude and reach on captured clips.
//!
//! Inputs: `../shared/mocap`; the lamp of the library.

use motion::{Dof, Fit, Joint, Tolerance};
use studies::on_fit::{Halved, OFFSET_S, REACH, lags, measure};
use takes::{Ask, Input, Take, open};

/// On a walk: each arm joint comes late by offset × depth, within a frame; half the amplitude halves its range; hands come nearer as
/// asked; and feet slip no more.
#[test]
fn a_walk_takes_the_edits_of_scripts() {
    let walk = measure(&support::shared("mocap/bvh/16_16.bvh")).unwrap();
    assert_eq!(walk.lags.len(), 6, "{walk}");
    for l in &walk.lags {
        assert!((l.found - l.asked).abs() <= 1.0, "{l:?}"); // 0.4 seen
    }
    assert!(walk.lags.iter().all(|l| l.asked > 20.0), "{walk}");
    assert!(!walk.halved.is_empty() && walk.halved.iter().all(Halved::holds), "{:?}", walk.halved); // 1.3 degrees seen
    for share in &walk.reach {
        assert!((share / REACH - 1.0).abs() <= 0.01, "{share}"); // 0.1 % seen
    }
    let [was, after @ ..] = walk.slip_mm;
    assert!(after.iter().all(|mm| *mm <= was + 2.0), "{:?}", walk.slip_mm); // the same seen
}

/// Every clip is fitted within 2 degrees and 10 mm; the median clip with 18 keys per second and joint or less.
#[test]
fn slow_every_clip_is_fitted() {
    let folder = support::shared("mocap/bvh");
    let mut keys = Vec::new();
    for file in std::fs::read_dir(folder).unwrap() {
        let path = file.unwrap().path();
        let take = open(&path, &Ask::default()).unwrap();
        let report = Fit::of(&take.asked.clip, &Tolerance::default()).unwrap().report;
        let amount = |r: &Option<motion::fit::Residue>| r.as_ref().map_or(0.0, |r| r.amount);
        let (deg, mm) = (amount(&report.turned), amount(&report.moved));
        assert!(deg <= 2.0 && mm <= 10.0, "{}: {report}", take.name);
        keys.push(report.keys_per_s);
    }
    keys.sort_by(f64::total_cmp);
    let median = keys[keys.len() / 2];
    assert!(keys.len() >= 37 && median <= 18.0, "{median}"); // 8.3 seen
}

/// A human motion on a lamp takes a succession: the shade comes late by its depth along the arm of the lamp.
#[test]
fn slow_a_lamp_takes_a_succession() {
    let lamp = |edits: &str| -> Take {
        let (body, anger) = (support::scene("characters/lamp.ron"), support::scene("performances/anger.ron"));
        let ron = format!("Scene(character: {body:?}, motion: Retarget(of: {anger:?}), {edits})");
        open(Input::Text { ron, base: support::scene("") }, &Ask::default()).unwrap_or_else(|e| panic!("{e}"))
    };
    let plain = lamp("");
    let late = lamp(&format!("edits: [Succession(offset_s: {OFFSET_S})]"));
    let s = &plain.asked.clip.skeleton;
    let joints: Vec<usize> = (1..s.links().len())
        .filter(|l| s.links()[*l].joint != Joint::Fixed && Dof::of_link(s, *l).is_some())
        .collect();
    let all = lags(&plain.asked.clip, &late.asked.clip, &joints);
    println!("{all:?} {}", late.log);
    assert!(all.iter().any(|l| l.asked > 5.0), "{all:?}");
    for l in &all {
        assert!((l.found - l.asked).abs() <= 1.0, "{l:?}");
    }
}
