//! Captured walks that are pushed in mid-walk, performed free: in which directions they recover and rejoin their motion.
//!
//! In: clips, how hard and when to push. Out: a line per clip and direction, from the walk's heading: 0 forward, 90 left.
//!
//! ```sh
//! cargo run --release -p takes --example pushed_in_mid_walk -- --at 1.5 ../shared/mocap/bvh/16_16.bvh
//! ```
//!
//! The push is a constant horizontal force over 0.1 s at the centre of mass of the chest: the link that carries both arms. *Recovers*: keeps its
//! feet to the end (`dynamics::walked`) and is back within 2 s of the push's end: its links stay within 60 mm RMS of where the motion has them from
//! then on. Link centres, in the world: the path counts.

mod common;

use bodies::Character;
use common::{Failed, Options};
use dynamics::{Push, Rejoined, Walked};
use motion::skeleton::vec_at;
use motion::{LimbKind, Vec3};
use sim::Engines;
use takes::{Take, open};

/// How long it is pushed, s.
const PUSH_S: f64 = 0.1;
/// Within what distance of its links' centres it is back, m.
const NEAR_M: f64 = 0.06;
/// Within what time, s.
const SOON_S: f64 = 2.0;
/// The way over so much time before and after the push is the walk's heading, s.
const HEADING_S: f64 = 0.25;
/// Directions.
const DIRECTIONS: usize = 8;

/// The link that carries both arms; the root of a body without arms.
fn chest(character: &Character) -> usize {
    let skeleton = &character.skeleton;
    let mut arms = skeleton.limbs().iter().filter(|l| l.kind == LimbKind::Arm);
    let Some(first) = arms.next() else { return 0 };
    let above = |link: usize| skeleton.ancestors(link).skip(1).collect::<Vec<_>>();
    let others: Vec<Vec<usize>> = arms.map(|arm| above(arm.upper)).collect();
    above(first.upper).into_iter().find(|l| others.iter().all(|o| o.contains(l))).unwrap_or(0)
}

/// Where the walk goes around a time, rad about +Y from +Z; 0 of one that goes nowhere.
fn heading(take: &Take, at_s: f64) -> f64 {
    let clip = &take.asked.clip;
    let frame = |t: f64| ((t * clip.rate_hz).round().max(0.0) as usize).min(clip.frames() - 1);
    let at = |t: f64| vec_at(clip.pose(frame(t)), 0);
    let way = at(at_s + HEADING_S) - at(at_s - HEADING_S);
    way.x.atan2(way.z)
}

fn main() -> Result<(), Failed> {
    let (mut impulse, mut at_s, mut directions): (f64, f64, Vec<f64>) = (20.0, 1.5, Vec::new());
    let options = Options::read(Some(2), |word, words| {
        match word {
            "--impulse" => impulse = words.value(word)?,
            "--at" => at_s = words.value(word)?,
            "--directions" => directions = words.values(word)?,
            _ => return Ok(false),
        }
        Ok(true)
    })?;
    if directions.is_empty() {
        directions = (0..DIRECTIONS).map(|k| k as f64 * 360.0 / DIRECTIONS as f64).collect();
    }
    for (file, &seed) in options.files.iter().flat_map(|f| options.seeds.iter().map(move |s| (f, s))) {
        let take = open(file, &options.ask(seed))?;
        let character = take.character().clone();
        let link = chest(&character);
        let ahead = heading(&take, at_s);
        println!(
            "{}: {impulse} N·s over {PUSH_S} s at `{}` from {at_s} s on, seed {seed}",
            file.file_stem().unwrap_or_default().to_string_lossy(),
            character.skeleton.links()[link].name
        );
        let mut recovered = 0;
        for &deg in &directions {
            let (sin, cos) = (ahead + deg.to_radians()).sin_cos();
            let way = Vec3::new(sin, 0.0, cos);
            let mut pushed = take.clone();
            pushed.conditions.pushes.push(Push {
                link,
                at: character.bodies[link].com,
                force: way * (impulse / PUSH_S),
                start_s: at_s,
                duration_s: PUSH_S,
            });
            let trace = pushed.outcome(&Engines::default(), &mut |_| {})?.trace;
            let rows = (take.asked.clip.duration_s() * trace.rate_hz) as usize;
            let walked = Walked::of(&trace, rows);
            let over_s = at_s + PUSH_S;
            let seen = Rejoined::of(&trace, at_s, NEAR_M);
            let after = seen.back_s.map(|t| (t - over_s).max(0.0));
            let back = walked.lost.is_none() && after.is_some_and(|s| s <= SOON_S);
            recovered += usize::from(back);
            println!(
                "  {deg:>5.0}°  {}  thrown {:>4.0} mm at {:.2} s  {}  {}",
                if back { "recovers" } else { "does not" },
                1e3 * seen.furthest_m,
                seen.furthest_s,
                after.map_or("not back".to_owned(), |s| format!("back {s:.2} s after the push")),
                walked.lost.map_or("kept its feet".to_owned(), |(t, loss)| format!("{t:.2} s: {loss}")),
            );
        }
        println!("  recovers in {recovered} of {}", directions.len());
    }
    Ok(())
}
