//! Motions put on the characters that ship: contacts hold, forces come to match, tails swing.

use formats::bvh::ImportOptions;
use motion::Clip;
use retarget::features::RootFrame;
use retarget::global_transform::headings;
use retarget::{Options, PipelineStage, RefineDofs, Retargeted};
use takes::retargeting::Session;

/// Performances that ship; any other name is a captured clip's.
const PERFORMANCES: [&str; 8] =
    ["anger", "dance", "disgust", "fear", "happiness", "sadness", "surprise", "walk"];

fn session(performance: &str, character: &str) -> Session {
    let path = if PERFORMANCES.contains(&performance) {
        support::scene(&format!("performances/{performance}.ron"))
    } else {
        support::shared(&format!("mocap/bvh/{performance}.bvh"))
    };
    let to = support::scene(&format!("characters/{character}.ron"));
    Session::open(&path, &to, None, &ImportOptions::default()).unwrap()
}

fn run(session: &Session, options: &Options) -> Retargeted {
    session.run(&session.learn(options).unwrap(), options).unwrap()
}

fn fell(before: &[f64], after: &[f64]) -> f64 {
    1.0 - after.iter().sum::<f64>() / before.iter().sum::<f64>()
}

/// After contact adjustment nothing slips or sinks in; after refinement the vertical forces match, by millimetres of
/// the root. (`cargo run --release -p studies --example retargeting` prints all performances and three captured clips.)
#[test]
fn slow_contacts_hold_and_vertical_forces_match() {
    for character in ["lamp", "penguin", "squirrel"] {
        for performance in ["anger", "dance", "disgust", "fear", "16_21"] {
            let options = Options { rate_hz: Some(30.0), ..Options::default() };
            let done = run(&session(performance, character), &options);
            let (c, r) = (done.contact.unwrap(), done.refinement.unwrap());
            let vertical = fell(&r.before[1..2], &r.after[1..2]);
            println!("{character} {performance}: {c:?}, vertical −{:.1} %", 100.0 * vertical);
            assert!(c.slip_m <= 1e-3, "{character} {performance}"); // 0.02 mm seen
            assert!(c.penetration_m <= 5e-3, "{character} {performance}"); // 0.1 mm seen
            assert!(vertical >= 0.8, "{character} {performance}: {vertical}"); // 96 % seen
            assert!(r.root_median_m <= 0.02, "{character} {performance}"); // 1.5 mm seen
            assert!(r.slip_m <= 2e-3, "{character} {performance}: {}", r.slip_m);
        }
    }
}

/// Steps are no more jerked than the motion is, of every performance on every character, and of captured clips that no key
/// pose was made from.
#[test]
fn slow_steps_do_not_jump() {
    let clips = [
        "anger",
        "dance",
        "disgust",
        "fear",
        "happiness",
        "sadness",
        "surprise",
        "16_21",
        "14_24",
        "05_03",
        "02_01",
        "127_31",
    ];
    let (mut worst, mut jerked) = ((0.0f64, String::new()), Vec::new());
    for character in ["lamp", "penguin", "squirrel"] {
        for performance in clips {
            let options =
                Options { rate_hz: Some(30.0), stop_after: PipelineStage::Contact, ..Options::default() };
            let c = run(&session(performance, character), &options).contact.unwrap();
            assert!(c.slip_m <= 1e-3, "{character} {performance}: {c:?}"); // 0.02 mm seen
            assert!(c.penetration_m <= 5e-3, "{character} {performance}: {c:?}"); // 2.1 mm seen
            if c.jerk_ratio > 1.2 {
                jerked.push(format!("{character} {performance}: {:.2}", c.jerk_ratio));
            }
            if c.jerk_ratio > worst.0 {
                worst = (c.jerk_ratio, format!("{character} {performance}"));
            }
        }
    }
    println!("at most {worst:?}"); // 1.13 seen
    assert!(jerked.is_empty(), "{jerked:?}");
}

/// So they are at any frame rate: points that rest do not creep over more frames.
#[test]
fn slow_steps_do_not_depend_on_the_frame_rate() {
    for character in ["lamp", "penguin", "squirrel"] {
        let session = session("14_24", character);
        for rate_hz in [30.0, 60.0, 120.0] {
            let options =
                Options { rate_hz: Some(rate_hz), stop_after: PipelineStage::Contact, ..Options::default() };
            let c = run(&session, &options).contact.unwrap();
            println!("{character} at {rate_hz} Hz: {c:?}");
            assert!(c.slip_m <= 2e-4, "{character} at {rate_hz} Hz: {c:?}"); // 0.06 mm seen
            assert!(c.jerk_ratio <= 1.2, "{character} at {rate_hz} Hz: {c:?}"); // 1.09 seen
        }
    }
}

/// With root and legs (a lamp's arm is its leg) all six components match, and forces stay inside the friction cone.
#[test]
fn slow_root_and_legs_match_all_six_components() {
    let pairs = [("lamp", "fear"), ("lamp", "16_21"), ("penguin", "fear"), ("squirrel", "fear")];
    for (character, performance) in pairs {
        let mut options = Options { rate_hz: Some(30.0), ..Options::default() };
        options.refine.dofs = RefineDofs::RootAndLegs;
        let done = run(&session(performance, character), &options);
        let r = done.refinement.unwrap();
        let all = fell(&r.before, &r.after);
        println!(
            "{character} {performance}: −{:.1} %, cone {:?} → {:?}",
            100.0 * all,
            r.cone_before,
            r.cone_after
        );
        // 97 % seen; 77 % of a walk on the lamp, which hops, and whose stages are held to the speed of those before
        assert!(all >= 0.75, "{character} {performance}: {all}");
        assert!(r.root_median_m <= 0.02 && r.slip_m <= 2e-3, "{character} {performance}");
        // 3 to 9 before; 2 frames of the squirrel stay outside, where its stages are held to the speed of those before
        let most = if character == "squirrel" { 2 } else { 0 };
        assert!(r.cone_after.len() <= most, "{character} {performance}: {:?}", r.cone_after);
    }
}

/// A straight walk stays straight: on every character the path goes where the human's goes, and over a stride the body faces
/// along it. Within a stride it turns as the human's spin demands: a lamp, which has nothing that swings against its arm, by
/// 27°.
#[test]
fn slow_a_straight_walk_stays_straight() {
    for walk in ["walk", "16_21"] {
        for character in ["lamp", "penguin", "squirrel"] {
            let session = session(walk, character);
            let options =
                Options { rate_hz: Some(30.0), stop_after: PipelineStage::Global, ..Options::default() };
            let done = run(&session, &options);
            let course = |clip: &Clip| {
                let place = |i: usize| clip.skeleton.position(clip.pose(i), 0);
                let way = place(clip.frames() - 1) - place(0);
                way.x.atan2(way.z).to_degrees()
            };
            let straight = course(&done.human);
            let off = |clip: &Clip, root: &RootFrame| -> Vec<f64> {
                headings(clip, root).iter().map(|h| h.to_degrees() - straight).collect()
            };
            let human = off(&done.human, &session.performance.performer.features.root);
            let own = off(&done.clip, &session.actor.puppet.features.root);
            let most = |x: &[f64]| x.iter().map(|h| h.abs()).fold(0.0, f64::max);
            let strides: Vec<f64> =
                own.windows(STRIDE).map(|w| w.iter().sum::<f64>() / w.len() as f64).collect();
            let bend = (course(&done.clip) - straight).abs();
            println!(
                "{walk} {character}: course {bend:.2}°, facing {:.1}° over a stride, {:.1}° at most (human {:.1}°)",
                most(&strides),
                most(&own),
                most(&human)
            );
            assert!(bend < 10.0 && most(&strides) < 10.0, "{walk} {character}");
        }
    }
}

/// Frames of a stride of either walk, 1.1 s.
const STRIDE: usize = 33;

/// The tail swings, and comes to rest where the key poses put it; with the option off it follows them.
#[test]
fn slow_the_tail_follows_by_dynamics_or_by_key_poses() {
    let session = session("happiness", "squirrel");
    let options = Options { rate_hz: Some(30.0), ..Options::default() };
    let with = run(&session, &options);
    let without = run(&session, &Options { sway: false, ..options });
    assert_eq!(without.sway, None);
    let report = with.sway.unwrap();
    println!("{report:?}");
    assert_eq!(report.links, 5);
    assert!(report.most_rad > 0.05 && report.most_rad < 1.6, "{report:?}");
    assert_ne!(with.clip, without.clip);
}
