//! Verdicts on motions that were made without knowing of them: what is said of each is what happened.

use std::path::{Path, PathBuf};

use dynamics::verdict::{Grade, Verdict};
use takes::{Ask, Engines, Input, LookAhead, Take};

/// A scene of `../shared/cases`, as if it lay among the project's.
fn case(name: &str) -> Take {
    open(name, &text(name), &Ask::default())
}

fn text(name: &str) -> String {
    let path: PathBuf = support::shared("cases/scenes").join(name);
    std::fs::read_to_string(&path).unwrap()
}

fn open(name: &str, ron: &str, ask: &Ask) -> Take {
    let base: &Path = &support::root().join("scenes");
    takes::open(Input::Text { ron: ron.into(), base: base.to_owned() }, ask)
        .unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn verdict(name: &str) -> Verdict {
    let take = case(name);
    let out = take.outcome(&Engines::default(), &mut |_| {}).unwrap();
    let verdict = take.verdict(&out);
    println!("{name}: {verdict}");
    verdict
}

fn has(verdict: &Verdict, reason: &str) -> bool {
    verdict.reasons.iter().any(|r| r.name() == reason)
}

/// A wave and a bow are performed as asked. Whoever slides, hops or lands hard is told so, with a number beyond its limit.
#[test]
fn slow_verdicts_are_graded() {
    let good = verdict("wave_bow.ron");
    assert_eq!(good.grade(), Grade::AsAsked, "{good}");
    assert_eq!(good.to_string(), "performed as asked, the body stands");
    // feet of an assisted root stay, whatever keys say
    let ron = "Scene(character: \"characters/human.ron\", root: Assisted(force_n: 80, moment_nm: 50), settle_s: 0.3, script: [Action(
        name: \"kick\", cycles: [Cycle(poses: [Pose(set_deg: { \"hip_r\": (-40, 0, 0) })])])])";
    let kick = open("kick", ron, &Ask::default());
    let kick = kick.verdict(&kick.outcome(&Engines::default(), &mut |_| {}).unwrap());
    assert_eq!(kick.grade(), Grade::But, "{kick}");
    assert!(has(&kick, "keys ignored") && kick.to_string().contains("planted"), "{kick}");
    let hops = verdict("push_door.ron");
    assert_eq!(hops.grade(), Grade::But, "{hops}");
    // 19 mm of slip, 0.10 s in the air, 3.5 × body weight seen
    for name in ["feet slid", "left the ground", "landed hard"] {
        assert!(has(&hops, name), "{name}: {hops}");
    }
    for reason in &hops.reasons {
        assert!(reason.value > reason.limit, "{reason:?}");
    }
}

/// Eyes that cannot see what they are turned to have not done as asked, though everything else was; the miss is measured.
#[test]
fn slow_a_gaze_that_misses_is_told() {
    let behind = verdict("gaze_behind.ron");
    assert_eq!(behind.grade(), Grade::But, "{behind}");
    let missed = behind.reasons.iter().find(|r| r.name() == "gaze missed").expect("a reason");
    // 57° seen: the point is 56° beyond neck and trunk
    assert!(missed.value > 45.0 && missed.value < 75.0, "{behind}");
    assert!(behind.to_string().contains("its gaze missed (0, 1.5, -2) m by"), "{behind}");
    // a gaze within reach is as asked
    let greet = takes::open(support::scene("greet.ron"), &Ask::default()).unwrap();
    let out = greet.outcome(&Engines::default(), &mut |_| {}).unwrap();
    assert_eq!(greet.verdict(&out).grade(), Grade::AsAsked, "{}", greet.verdict(&out));
}

/// A foot that the motion moves has not slipped: a body that stands on one leg without looking ahead falls of something else.
#[test]
fn slow_a_moved_foot_is_no_cause_of_a_fall() {
    let path = support::root().join("scenes/steps/tree.ron");
    let take = takes::open(path, &Ask { foresight: LookAhead::Off, ..Ask::default() }).unwrap();
    let out = take.outcome(&Engines::default(), &mut |_| {}).unwrap();
    let fall = out.fall.as_ref().expect("a fall");
    println!("tree: {fall}");
    let cause = fall.cause().expect("a cause");
    assert_ne!(cause.margin, dynamics::fall::Margin::FootSlipped, "{fall}");
    assert!(cause.time_s > 1.0, "{fall}"); // stands for a second and more
}

/// A push that topples is named as what made the body fall; so is a motion that asks for the impossible.
#[test]
fn slow_a_fall_names_what_brought_it() {
    let pushed = verdict("fall20.ron");
    assert_eq!(pushed.grade(), Grade::Fell);
    assert!(pushed.to_string().contains("it is pushed by 60.0 N·s from 0.50 s"), "{pushed}");
    assert!(!has(&pushed, "momentum unexplained"), "{pushed}");
    // a trunk that bends by 70° over legs that stay: no balance holds that
    let ron = "Scene(character: \"characters/human.ron\", script: [Action(name: \"lean\", start_s: 0.5, cycles: [Cycle(poses: [
        Pose(duration_s: 0.3, hold_s: 1.0, set_deg: { \"pelvis\": (80, 0, 0), \"abdomen\": (40, 0, 0), \"chest\": (40, 0, 0) }, set_m: { \"pelvis_z\": 0.4 })])])])";
    let input = Input::Text { ron: ron.into(), base: support::root().join("scenes") };
    let take = takes::open(input, &Ask::default()).unwrap();
    let out = take.outcome(&Engines::default(), &mut |_| {}).unwrap();
    let said = out.verdict.to_string();
    println!("lean: {said}");
    assert_eq!(out.verdict.grade(), Grade::Fell, "{said}");
    assert!(said.contains("asks for the centre of pressure"), "{said}");
}
