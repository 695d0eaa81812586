//! Scripts that step with a free root: what stands when, where feet are, and that the body keeps them.

use dynamics::Walked;
use dynamics::conditions::RootMode;
use motion::{Kinematics, Vec3};
use sim::Engines;
use sim::foresight::{Foreseen, Settings};
use takes::{Ask, Input, LookAhead, Take, open};

fn scene(body: &str, ask: &Ask) -> Result<Take, takes::TakeError> {
    let ron = format!(
        "// Steps by itself.\nScene(character: \"library:characters/human.ron\", properties: (curve: EaseInOut), {body})"
    );
    open(Input::Text { ron, base: std::env::temp_dir() }, ask)
}

fn taken(body: &str) -> Take {
    scene(body, &Ask::default()).unwrap_or_else(|e| panic!("{e}"))
}

const KNEE: &str = "script: [Action(name: \"up\", start_s: 0.6, cycles: [Cycle(poses: [
    Pose(duration_s: 0.4, hold_s: 0.2, set_deg: { \"hip_r\": (-50, 0, 0), \"knee_r\": 90 }),
    Pose(duration_s: 0.4, rest: [\"hip_r\", \"knee_r\"]),
])])], settle_s: 0.4, root: Free";
const STEP: &str = "footwork: [Step(limb: \"leg_r\", start_s: 0.6, duration_s: 0.4, to_m: (0, 0.25)),
    Step(limb: \"leg_l\", start_s: 1.3, duration_s: 0.4, to_m: (0, 0.25), turn_deg: 10)], settle_s: 2, root: Free";

fn spans(take: &Take, leg: &str) -> Vec<(f64, f64)> {
    take.asked.contacts.of(leg).map(|c| (c.from_s, c.to_s)).collect()
}

/// Horizontal distance of an ankle from where it is in the first frame, m.
fn gone(take: &Take, leg: &str, f: usize) -> Vec3 {
    let clip = &take.asked.clip;
    let end = clip.skeleton.limb(leg).unwrap().end;
    let at = |f: usize| Kinematics::new(&clip.skeleton, clip.pose(f)).origin(end);
    let by = at(f) - at(0);
    Vec3::new(by.x, 0.0, by.z)
}

/// A leg is in the air from the start of its first key until keys have brought it back to rest; it then stands where it stood. A key that
/// is not brought back leaves it in the air, and one on a leg that `planted` does not name counts as well.
#[test]
fn keys_lift_a_planted_leg() {
    let take = taken(KNEE);
    assert!(take.scripted_steps() && take.looks_ahead() && take.asked.plants.is_empty());
    assert!(take.asked.ignored.is_empty(), "{:?}", take.asked.ignored);
    let end_s = take.asked.clip.duration_s();
    assert_eq!(spans(&take, "leg_l"), [(0.0, end_s)]);
    let right = spans(&take, "leg_r");
    assert_eq!(right.len(), 2, "{right:?}");
    let frame = 1.0 / take.asked.clip.rate_hz;
    assert!((right[0].1 - 0.6).abs() <= frame && (right[1].0 - 1.6).abs() <= frame, "{right:?}");
    let last = take.asked.clip.frames() - 1;
    let back = gone(&take, "leg_r", last).norm();
    assert!(back < 1e-3, "{back}"); // 0.1 mm seen
    let clip = &take.asked.clip;
    let knee = clip.skeleton.link("knee_r").unwrap();
    let bent = clip.pose(130)[clip.skeleton.q_at(knee)].to_degrees();
    assert!((bent - 90.0).abs() < 12.0, "{bent}");

    let never = taken(&KNEE.replace("Pose(duration_s: 0.4, rest: [\"hip_r\", \"knee_r\"]),", ""));
    assert_eq!(spans(&never, "leg_r").len(), 1);
    let named = taken(&format!("{KNEE}, planted: [\"leg_l\"]"));
    assert_eq!(spans(&named, "leg_r"), right);
}

/// Footwork of a free root: feet stand where the script puts them, the root goes along, and the weight is over the foot that stands before the
/// other leaves.
#[test]
fn footwork_needs_no_pin() {
    let take = taken(STEP);
    assert_eq!(spans(&take, "leg_r").len(), 2);
    let last = take.asked.clip.frames() - 1;
    for leg in ["leg_l", "leg_r"] {
        let by = gone(&take, leg, last);
        assert!((by.z - 0.25).abs() < 5e-3, "{leg}: {by}"); // 1 mm seen
    }
    let clip = &take.asked.clip;
    let root = clip.skeleton.position(clip.pose(last), 0) - clip.skeleton.position(clip.pose(0), 0);
    assert!((root.z - 0.25).abs() < 0.03, "{root}");
    let possible = take.made_possible().unwrap().1.unwrap();
    let inside = possible.measures.inside_after.unwrap();
    assert!(inside > 0.98, "{inside}");
    assert!(take.asked.stepping.iter().any(|line| line.contains("to leg_l")), "{:?}", take.asked.stepping);
}

/// The root turns with the feet, all the way round and on: headings are counted, not read off rotations.
#[test]
fn the_root_turns_with_its_feet() {
    let steps = (0..8).flat_map(|i| {
        let one = |leg: &str, later_s: f64| {
            let (start_s, turn_deg) = (0.5 + f64::from(i) + later_s, 60.0 * f64::from(i + 1));
            format!("Step(limb: \"{leg}\", start_s: {start_s}, duration_s: 0.4, turn_deg: {turn_deg})")
        };
        [one("leg_l", 0.0), one("leg_r", 0.5)]
    });
    let steps: Vec<String> = steps.collect();
    let take = taken(&format!("footwork: [{}], settle_s: 9.5, root: Free", steps.join(", ")));
    let clip = &take.asked.clip;
    let heading = |f: usize| clip.skeleton.rotation(clip.pose(f), 0);
    let (mut turned, mut fastest) = (0.0, 0.0_f64);
    for f in 1..clip.frames() {
        let by = motion::rotation::log(&(heading(f) * heading(f - 1).inverse())).y.to_degrees();
        turned += by;
        fastest = fastest.max(by.abs());
    }
    // 480.0° and 1.4° a frame seen
    assert!((turned - 480.0).abs() < 1.0 && fastest < 3.0, "{turned}°, {fastest}° a frame");
}

/// Both keep their feet in a body that nothing holds, upper body by transitions; whoever is told not to look ahead does not.
#[test]
fn slow_scripts_keep_their_feet() {
    let quick = || LookAhead::As(Foreseen::Search(Settings { rollouts: 120, ..Settings::default() }));
    for body in [KNEE, STEP] {
        let take = scene(body, &Ask { foresight: quick(), ..Ask::default() }).unwrap();
        assert!(take.asked.tracks.is_some());
        let outcome = take.outcome(&Engines::default(), &mut |_| {}).unwrap();
        let rows = outcome.trace.rows();
        let walked = Walked::of(&outcome.trace, rows);
        println!("{walked:?}");
        assert_eq!(walked.lost, None);
        assert!(walked.links_mm < 40.0, "{}", walked.links_mm); // 12 and 18 mm seen
        assert!(outcome.trace.root_wrench.iter().all(|x| *x == 0.0));
    }
    let blind = scene(STEP, &Ask { foresight: LookAhead::Off, ..Ask::default() }).unwrap();
    assert!(!blind.looks_ahead() && blind.conditions.foresight.is_none());
}

/// What stands still is as it was: its feet are planted, and the balance has it. An assisted root cannot step.
#[test]
fn who_stands_is_balanced() {
    let still = taken(
        "script: [Action(name: \"nod\", cycles: [Cycle(poses: [Pose(set_deg: { \"head\": (20, 0, 0) })])])], root: Free",
    );
    assert!(!still.scripted_steps() && still.asked.plants.len() == 2 && still.conditions.foresight.is_none());
    assert_eq!(still.conditions.physics.root, RootMode::Free);
    let assisted = STEP.replace("root: Free", "root: Assisted(force_n: 80, moment_nm: 50)");
    let e = scene(&assisted, &Ask::default()).err().unwrap().to_string();
    assert!(e.contains("footwork needs `root: Free` or `root: Pinned`"), "{e}");
    for world in ["(ground: None)", "(ground: Plane(friction: 0.8, tilt_deg: 5))"] {
        let e = scene(&format!("{STEP}, world: {world}"), &Ask::default()).err().unwrap().to_string();
        assert!(e.contains("needs legs that are planted on level ground"), "{world}: {e}");
    }
}
