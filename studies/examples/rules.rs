//! Edits by example on known rules, beside what an artist would do instead: prints the table of `docs/BY_EXAMPLE.md`.
//!
//! `cargo run --release -p studies --example rules [FRAMES...]`: frames taught (10 20 40 80 160 320). Clips: subject 16 of `../shared/mocap`.

use std::error::Error;
use std::path::Path;

use edits::by_example::{ExampleOptions, Pair};
use formats::bvh::ImportOptions;
use studies::propagate::compare::{Way, error};
use studies::propagate::rules::{Rule, pair};

/// Taught on.
const TRAINING: [&str; 5] = ["16_16", "16_20", "16_21", "16_30", "16_33"];
/// Not seen.
const UNSEEN: [&str; 2] = ["16_13", "16_18"];

fn main() -> Result<(), Box<dyn Error>> {
    let counts: Vec<usize> = std::env::args().skip(1).map(|a| a.parse()).collect::<Result<_, _>>()?;
    let counts = if counts.is_empty() { vec![10, 20, 40, 80, 160, 320] } else { counts };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/mocap/bvh");
    let pairs = |names: &[&str], rule| -> Result<Vec<Pair>, Box<dyn Error>> {
        names
            .iter()
            .map(|name| {
                let (clip, _) =
                    formats::open_clip(&folder.join(format!("{name}.bvh")), &ImportOptions::default())?;
                Ok(pair(rule, name, &clip)?)
            })
            .collect()
    };
    println!("taught on {}; not seen: {}", TRAINING.join(", "), UNSEEN.join(", "));
    for rule in Rule::ALL {
        let (training, unseen) = (pairs(&TRAINING, rule)?, pairs(&UNSEEN, rule)?);
        println!("\n{}", rule.name());
        println!(
            "{:>8} {:>14} {:>10} {:>10} {:>8} {:>9}",
            "frames", "way", "edited °", "others °", "rate %", "drift ms"
        );
        for &count in &counts {
            for way in Way::ALL {
                let e = error(way, &training, &unseen, count, &ExampleOptions::default())?;
                println!(
                    "{count:>8} {:>14} {:>10.3} {:>10.3} {:>8.2} {:>9.1}",
                    way.name(),
                    e.edited_deg,
                    e.others_deg,
                    e.rate_percent,
                    1e3 * e.drift_s
                );
            }
        }
    }
    Ok(())
}
