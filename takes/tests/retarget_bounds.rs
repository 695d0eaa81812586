//! What a retargeting promises of every clip, on clips that no key pose was made for: bounds, speeds, flights, frame rates.

use formats::bvh::ImportOptions;
use motion::{Clip, Kinematics};
use retarget::{Guard, Options, PipelineStage, Retargeted, flights, guard};
use takes::retargeting::RetargetReport;
use takes::retargeting::Session;

const CHARACTERS: [&str; 3] = ["lamp", "penguin", "squirrel"];

fn session(clip: &str, character: &str) -> Session {
    let path = support::shared(&format!("mocap/bvh/{clip}.bvh"));
    let to = support::scene(&format!("characters/{character}.ron"));
    Session::open(&path, &to, None, &ImportOptions::default()).unwrap()
}

fn run(session: &Session, rate_hz: f64) -> Retargeted {
    let options = Options { rate_hz: Some(rate_hz), ..Options::default() };
    session.run(&session.learn(&options).unwrap(), &options).unwrap()
}

/// The clip that came out of a stage.
fn stage(done: &Retargeted, stage: PipelineStage) -> &Clip {
    &done.stages.iter().find(|s| s.0 == stage).expect("it ran").1
}

/// Farthest that a joint turns between two clips, but for the root, rad; farthest that the root moves, m.
fn moved(a: &Clip, b: &Clip) -> [f64; 2] {
    let s = &a.skeleton;
    let (mut v, mut most) = (vec![0.0; s.nv()], [0.0f64; 2]);
    for i in 0..a.frames() {
        s.difference(a.pose(i), b.pose(i), 1.0, &mut v);
        let length = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        most[1] = most[1].max(length(&v[..3]));
        for l in 1..s.links().len() {
            most[0] = most[0].max(length(&v[s.v_at(l)..s.v_at(l) + s.links()[l].joint.nv()]));
        }
    }
    most
}

/// Boxing, a cartwheel, a standing jump, a dance, and a leap: every stage is within its bounds, flights stay flights, no link is
/// deeper in another than it was, and what gave way is said.
#[test]
fn slow_every_stage_keeps_its_bounds_on_clips_without_key_poses() {
    let mut gave_way = 0;
    for clip in ["02_05", "49_07", "16_02", "93_charleston1", "49_05"] {
        for character in CHARACTERS {
            let session = session(clip, character);
            let what = format!("{clip} on {character}");
            let options = Options { rate_hz: Some(120.0), ..Options::default() };
            let mapping = session.learn(&options).unwrap();
            let done = session.run(&mapping, &options).unwrap();
            for s in &done.steps {
                assert!(s.nearest_bound < 1.0 + 1e-9, "{what}: {s:?}");
                assert!(
                    s.speed <= s.bounds.speed && s.acceleration <= s.bounds.acceleration,
                    "{what}: {s:?}"
                );
            }
            // not only as reported
            let (global, contact) =
                (stage(&done, PipelineStage::Global), stage(&done, PipelineStage::Contact));
            let [joint, root] = moved(global, contact);
            let of_contact = &done.steps[0];
            assert!(
                joint < 60.1_f64.to_radians() && root < of_contact.root_bound_m + 1e-9,
                "{what}: {joint} {root}"
            );
            let puppet = &session.actor.puppet;
            let accepted = &mapping.poses;
            let guard = Guard::new(puppet, accepted, options.world.gravity_m_s2);
            let deepest = |clip: &Clip| guard.depths(clip).into_iter().fold(0.0, f64::max);
            let depths: Vec<f64> = done.stages.iter().map(|(_, clip)| deepest(clip)).collect();
            for pair in depths[1..].windows(2) {
                assert!(pair[1] <= pair[0] + 2.0 * guard::TOUCH_M, "{what}: {depths:?}");
            }
            for f in &done.flights {
                let mut before = f.scaled_m;
                for &(stage, height) in &f.heights_m[1..] {
                    let most = if stage == PipelineStage::Global {
                        f64::INFINITY
                    } else {
                        (2.0 - flights::KEPT) * before
                    };
                    let within = (flights::KEPT * before - 2e-3..=most + 2e-3).contains(&height);
                    assert!(within, "{what}: {stage:?} {f:?}");
                    before = height;
                }
            }
            assert_eq!(
                done.flights.is_empty(),
                !["16_02", "49_05"].contains(&clip),
                "{what}: {:?}",
                done.flights
            );
            let report = RetargetReport::new(&session, options.model, &done, Vec::new());
            println!("{what}: {:?}", report.warnings);
            let said = report.warnings.iter().any(|w| w.contains("gave way"));
            assert_eq!(said, !done.gave_way.is_empty(), "{what}");
            gave_way += usize::from(said);
        }
    }
    assert!(gave_way > 0, "a cartwheel's feet cannot all be kept");
}

/// The same motion at 30, 60 and 120 Hz: whatever is decided is decided once, so that nothing differs at the times that they share.
#[test]
fn slow_the_motion_does_not_depend_on_the_frame_rate() {
    for (clip, character) in [("16_02", "lamp"), ("93_charleston1", "squirrel"), ("49_07", "penguin")] {
        let session = session(clip, character);
        let of_rate: Vec<Retargeted> = [30.0, 60.0, 120.0].map(|rate| run(&session, rate)).into();
        let stature = Guard::new(&session.actor.puppet, &[], 9.81).stature_m();
        let finest = &of_rate[2].clip;
        for done in &of_rate[..2] {
            let times = (finest.rate_hz / done.clip.rate_hz).round() as usize;
            assert_eq!((finest.frames() - 1) / times + 1, done.clip.frames());
            let s = &finest.skeleton;
            let (mut a, mut b) = (Kinematics::new(s, finest.pose(0)), Kinematics::new(s, finest.pose(0)));
            let mut off = 0.0f64;
            for i in 0..done.clip.frames() {
                a.update(s, done.clip.pose(i));
                b.update(s, finest.pose(i * times));
                off = (0..s.links().len()).map(|l| (a.origin(l) - b.origin(l)).norm()).fold(off, f64::max);
            }
            println!("{clip} on {character} at {} Hz: {:.1e} m off", done.clip.rate_hz, off);
            assert!(off <= 0.02 * stature, "{clip} on {character}: {off}"); // 0 seen
        }
    }
}
