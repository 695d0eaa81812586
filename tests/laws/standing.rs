//! Captured clips on their own feet: nothing but muscles and contacts where the performer stands, and where they
//! step nobody is asked to stand.

use std::path::Path;

use dynamics::RootMode;
use scenes::Overrides;
use scenes::overrides::RootChoice;
use takes::results::report::DynamicReport;
use takes::{Ask, Engines, Outcome, Progress, Report, Take};

use super::stage::mocap;

fn open(file: &Path, span_s: Option<(f64, f64)>) -> Take {
    let overrides = Overrides { root: Some(RootChoice::Free), span_s, ..Overrides::default() };
    takes::open(file, &Ask { overrides, ..Ask::default() }).unwrap()
}

/// It stands to the end by itself: no wrench on the root, its momentum balanced by gravity and contacts, its upper
/// body on the motion asked for, and the body still over its feet.
fn stands(name: &str, take: &Take, outcome: &Outcome) {
    let d: DynamicReport = Report::of(take, Some(outcome), &[]).dynamic.unwrap();
    let t = &outcome.trace;
    assert!(d.fell_at_s.is_none() && d.diverged.is_none(), "{name}: {:?} {:?}", d.fell_at_s, d.diverged);
    assert_eq!(t.root, RootMode::Free);
    assert!(t.root_wrench.iter().all(|x| *x == 0.0));
    println!(
        "{name}: {:.2} s, upper body {:.2}°, links {:.1} mm, residual {:.3} %, slip {:.1} mm",
        take.asked.clip.duration_s(),
        d.upper_body_rms_deg,
        d.position_rms_mm,
        d.root.residual_force_rms_percent_bw.unwrap(),
        d.feet.unwrap().slip_mm_max
    );
    assert!(d.upper_body_rms_deg <= 5.0, "{name}: {}°", d.upper_body_rms_deg); // 0.2 seen
    assert!(d.position_rms_mm <= 30.0, "{name}: {} mm", d.position_rms_mm); // 6 seen
    let residual = d.root.residual_force_rms_percent_bw.unwrap();
    assert!(residual <= 0.5, "{name}: {residual}"); // 0.17 seen
    assert!(d.feet.unwrap().slip_mm_max <= 20.0, "{name}: {} mm", d.feet.unwrap().slip_mm_max); // 8 seen
}

/// Drinking, and two calibration stances: one of them on feet far apart, one crouching.
#[test]
fn slow_standing_clips_stand_free() {
    for name in ["14_37", "127_01", "135_08"] {
        let take = open(&mocap(&format!("{name}.bvh")), None);
        assert!(!take.asked.plants.is_empty() && !take.stands_in_parts());
        let outcome = take.outcome(&Engines::default(), &mut |_| {}).unwrap();
        stands(name, &take, &outcome);
    }
}

/// Someone directs traffic and steps now and then: every standing span stands by itself.
#[test]
fn slow_every_standing_span_of_a_clip_that_steps_stands_free() {
    let take = open(&mocap("14_24.bvh"), None);
    assert!(take.stands_in_parts());
    let stance = take.asked.stance.clone().unwrap();
    let rate = take.asked.clip.rate_hz;
    assert!(stance.spans.windows(2).all(|w| w[0].frames.end == w[1].frames.start));
    assert_eq!(stance.spans.last().unwrap().frames.end, take.asked.clip.frames());
    let standing: f64 = stance.standing().map(|s| s.frames.len() as f64 / rate).sum();
    assert!(standing > 15.0, "{standing} s"); // 15.9 of 30.8 seen
    let performed = take.perform(&Engines::default(), &Progress::silent()).unwrap();
    assert_eq!(performed.spans().len(), stance.standing().count());
    for p in performed.spans() {
        let frames = &stance.spans[p.span].frames;
        stands(&format!("14_24 from {:.2} s", frames.start as f64 / rate), &p.take, &p.outcome);
    }
}

/// Walks and runs stand nowhere; a clip that begins standing and walks off stands until it does.
#[test]
fn steps_are_not_asked_to_stand() {
    for name in ["02_01", "09_01", "16_16", "16_35", "104_41_zombie", "49_07"] {
        let take = open(&mocap(&format!("{name}.bvh")), None);
        let stance = take.asked.stance.clone().unwrap();
        let stands: f64 = stance.standing().map(|s| s.frames.len() as f64 / take.asked.clip.rate_hz).sum();
        let part = stands / take.asked.clip.duration_s();
        assert!(part < 0.2, "{name} stands for {stands} s"); // 15 % of the zombie, who waits before he walks
    }
    let stance = open(&mocap("127_04.bvh"), None).asked.stance.unwrap();
    assert_eq!(stance.spans.iter().map(|s| s.stands).collect::<Vec<_>>(), [true, false]);
}

/// A part of a clip is that part: its frames, and its feet as they are in it.
#[test]
fn a_span_is_cut_from_its_clip() {
    let whole = open(&mocap("14_24.bvh"), None);
    let cut = open(&mocap("14_24.bvh"), Some((8.0, 10.0)));
    assert_eq!(cut.asked.clip.frames(), 241);
    assert!(!cut.asked.plants.is_empty(), "it stands from 8 to 10 s");
    assert_eq!(cut.unedited.pose(0), whole.asked.clip.pose(960));
    assert_eq!(cut.clip_source().unwrap().clip.frames(), 241);
}
