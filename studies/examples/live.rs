//! Puppeteering: a performance given to a character frame by frame, as it would come from a capture suit.
//!
//! In: a performance or clip, a character, frames per second (60). Out: what a frame took; the motion as BVH, to see what a
//! puppeteer would have seen.
//!
//! ```sh
//! cargo run --release -p studies --example live -- scenes/performances/walk.ron scenes/characters/penguin.ron 60
//! ```

use std::path::{Path, PathBuf};
use std::time::Instant;

use formats::bvh::{self, ImportOptions};
use motion::{Clip, Smoothing};
use retarget::contacts::phases::own_floors;
use retarget::{Live, Options, prepare};
use takes::retargeting::Session;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let asked: Vec<String> = std::env::args().skip(1).collect();
    let path = |at: usize, usual: &str| asked.get(at).map_or_else(|| support::scene(usual), PathBuf::from);
    let (performance, character) = (path(0, "performances/walk.ron"), path(1, "characters/penguin.ron"));
    let rate_hz: f64 = asked.get(2).map_or(Ok(60.0), |x| x.parse())?;

    let session = Session::open(&performance, &character, None, &ImportOptions::default())?;
    let (p, puppet) = (&session.performance, &session.actor.puppet);
    let options = Options::default();
    let mapping = session.learn(&options)?;
    // what the suit would send
    let human = prepare(&p.clip, &p.performer, Some(rate_hz), Smoothing::Auto, Some(p.ground_m))?;

    let floors = own_floors(&p.performer, &human, &options.contact);
    let mut live = Live::new(&mapping, &p.performer, puppet, rate_hz, &options)?.on_floors(&floors);
    let (mut poses, mut took_ms) = (Vec::new(), Vec::new());
    for i in 0..human.frames() {
        let start = Instant::now();
        let frame = live.step(human.pose(i))?;
        took_ms.push(1e3 * start.elapsed().as_secs_f64());
        poses.extend_from_slice(frame.pose);
    }
    took_ms.sort_by(f64::total_cmp);
    let mean = took_ms.iter().sum::<f64>() / took_ms.len() as f64;
    println!(
        "{} for the {}: {} frames at {rate_hz} Hz; {mean:.2} ms a frame, half below {:.2} ms, the slowest {:.2} ms of {:.2} ms",
        p.name,
        session.actor.file.character.name,
        human.frames(),
        took_ms[took_ms.len() / 2],
        took_ms[took_ms.len() - 1],
        1e3 / rate_hz
    );
    let file = Path::new("out").join(format!("{}-{}-live.bvh", p.name, session.actor.file.character.name));
    std::fs::create_dir_all("out")?;
    let clip = Clip::new(puppet.character.skeleton.clone(), rate_hz, poses);
    bvh::write_file(&file, &clip, &bvh::WriteOptions::default())?;
    println!("wrote {}", file.display());
    Ok(())
}
