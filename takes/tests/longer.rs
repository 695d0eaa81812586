//! Motion that goes on, carries and is not human's: clips looped, loads in the plan of the weight, retargeted characters on their feet.

use sim::foresight::{Foreseen, Settings};
use takes::overrides::RootChoice;
use takes::{Ask, Input, LookAhead, Overrides, Take, TakeError, open};

fn free() -> Overrides {
    Overrides { root: Some(RootChoice::Free), ..Overrides::default() }
}

fn looped(seconds: f64) -> Result<Take, TakeError> {
    let ask = Ask { overrides: free(), loop_s: Some(seconds), ..Ask::default() };
    open(support::shared("mocap/bvh/16_16.bvh"), &ask)
}

/// A walk goes on: as long as asked, its steps as regular and as long as those of the capture, and the seams do not show in the motion of the
/// joints.
#[test]
fn a_captured_walk_goes_on() {
    let (take, clip) =
        (looped(12.0).unwrap(), open(support::shared("mocap/bvh/16_16.bvh"), &Ask::default()).unwrap());
    assert!((take.asked.clip.duration_s() - 12.0).abs() < 0.01);
    let source = take.clip_source().unwrap();
    let cycle = source.cycle.as_ref().unwrap();
    println!("{cycle}");
    let period = (cycle.to - cycle.from) as f64 / cycle.rate_hz;
    assert!((1.0..1.4).contains(&period) && cycle.seam_rad.to_degrees() < 4.0, "{cycle}");
    // one step of each leg in a cycle
    for leg in ["LeftLeg", "RightLeg", "leg_l", "leg_r"] {
        let steps: Vec<f64> = take.asked.contacts.of(leg).map(|c| c.from_s).collect();
        let regular = steps.windows(2).skip(2).all(|w| ((w[1] - w[0]) / period - 1.0).abs() < 0.1);
        assert!(steps.is_empty() || (steps.len() >= 9 && regular), "{leg}: {steps:?}");
    }
    assert!(take.asked.contacts.contacts().len() >= 18);
    let root = |t: &Take, f: usize| t.asked.clip.skeleton.position(t.asked.clip.pose(f), 0).xz();
    let speed = |t: &Take, from: usize, to: usize| (root(t, to) - root(t, from)).norm() / (to - from) as f64;
    let (was, is) = (speed(&clip, 60, 300), speed(&take, 60, 1400));
    assert!((is / was - 1.0).abs() < 0.1, "{was} {is}");
    let bend = |t: &Take| motion::metrics::jerk_rms(&t.asked.clip);
    println!("jerk {:.1}, captured {:.1}", bend(&take), bend(&clip));
    assert!(bend(&take) < 1.1 * bend(&clip));
    let refused = looped(2.0).map(|_| ()).unwrap_err().to_string();
    assert!(refused.contains("longer than the clip"), "{refused}");
}

/// A scene says it too; what is no clip refuses it.
#[test]
fn a_scene_says_how_long_its_clip_goes_on() {
    let dir = tempfile::tempdir().unwrap();
    let clip = support::shared("mocap/bvh/16_16.bvh");
    let (_, body) = takes::inspect::inspect(&clip, &Ask::default().import).unwrap();
    let body = takes::character_file::write(&body.unwrap(), "A walker.");
    std::fs::write(dir.path().join("body.ron"), body).unwrap();
    let scene = |words: &str, ask: &Ask| {
        let ron = format!("Scene(\n character: \"body.ron\",\n{words}\n)");
        open(Input::Text { ron, base: dir.path().into() }, ask)
    };
    let words = format!(" motion: Clip({clip:?}),\n loop_s: 8,");
    let take = scene(&words, &Ask::default()).unwrap();
    assert!((take.asked.clip.duration_s() - 8.0).abs() < 0.01);
    let longer = scene(&words, &Ask { loop_s: Some(9.0), ..Ask::default() }).unwrap();
    assert!((longer.asked.clip.duration_s() - 9.0).abs() < 0.01);
    let refused = scene(" loop_s: 8,", &Ask::default()).map(|_| ()).unwrap_err().to_string();
    assert!(refused.contains("scene.ron:3:") && refused.contains("only a clip"), "{refused}");
    let script = open(support::scene("bow.ron"), &Ask { loop_s: Some(9.0), ..Ask::default() });
    assert!(matches!(script, Err(TakeError::Loop { .. })));
}

/// A weight in the hand moves the pelvis to the other side before it is performed; one that nobody knows of does not.
#[test]
fn slow_a_known_load_shifts_the_weight() {
    let clip = support::shared("mocap/bvh/02_01.bvh");
    let of = |known: Option<bool>| {
        let mut take = open(&clip, &Ask { overrides: free(), ..Ask::default() }).unwrap();
        let link = take.character().skeleton.link("RightHand").unwrap();
        take.conditions.carried.extend(known.map(|known| dynamics::conditions::Carrying {
            what: bodies::Carried::solid_box(
                link,
                8.0,
                motion::Vec3::new(-0.1, 0.0, 0.0),
                motion::Vec3::zeros(),
            ),
            from_s: 0.0,
            to_s: f64::INFINITY,
            known,
        }));
        take.possible().unwrap().unwrap()
    };
    let (without, surprise, known) = (of(None), of(Some(false)), of(Some(true)));
    assert_eq!(without.clip, surprise.clip);
    let s = &known.clip.skeleton;
    let shift = |f: usize| s.position(known.clip.pose(f), 0) - s.position(without.clip.pose(f), 0);
    let mean: motion::Vec3 =
        (0..known.clip.frames()).map(shift).sum::<motion::Vec3>() / known.clip.frames() as f64;
    println!("pelvis {mean:.3?} m");
    // it walks along +Z: the right hand is at −X, so the pelvis goes to +X
    assert!((0.005..0.08).contains(&mean.x), "{mean}");
}

/// Contacts of a retargeted character are of its points; looking ahead, its soles stand, step by step, within reach of its legs; and the
/// file that is written gives the same motion back.
#[test]
fn slow_a_penguin_is_to_stand_on_its_soles() {
    let scene = support::scene("retargeted/penguin-walk.ron");
    let foresight = LookAhead::As(Foreseen::Search(Settings::default()));
    let ask = |contacts| Ask { overrides: free(), foresight: foresight.clone(), contacts, ..Ask::default() };
    let take = open(&scene, &ask(None)).unwrap();
    assert!(take.looks_ahead());
    assert_eq!(take.asked.contacts.points(), ["leg_l", "leg_r"]);
    for leg in ["leg_l", "leg_r"] {
        assert!(take.asked.contacts.of(leg).count() >= 4, "{leg}: {:?}", take.asked.contacts);
    }
    println!("{:#?}", take.asked.stepping);
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("contacts.ron");
    let names = take.contact_points();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    std::fs::write(&file, scenes::contact_file::plan_text(&names, &take.asked.contacts)).unwrap();
    let again = open(&scene, &ask(Some(file.clone()))).unwrap();
    assert!(again.asked.contacts_given);
    let apart = motion::metrics::position_rms_mm(&take.asked.clip, &again.asked.clip);
    println!("given back: {apart:.3} mm apart");
    assert!(apart < 2.0, "{apart}");
    let blind = Ask { contacts: Some(file), ..Ask::default() };
    assert!(matches!(open(&scene, &blind), Err(TakeError::Contacts { .. })));
}
