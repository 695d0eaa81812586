//! Edits by example on known rules, beside what an artist would do instead: prints the table of `docs/BY_EXAMPLE.md`.
//!
//! `cargo run --release -p studies --example rules -- [FRAMES...] [--path-weight W] [--no-gate] [--out DIR]`: frames taught (10 20 40 80 160 320); with a folder, the
//! learning curves are written there (`learning_curves.svg`, `.png`). Clips: subject 16 of `../shared/mocap`.

use std::error::Error;
use std::path::Path;

use edits::by_example::{ExampleOptions, Pair};
use formats::bvh::ImportOptions;
use plots::learning::{LearningPanel, learning_curves};
use studies::propagate::compare::{Way, error};
use studies::propagate::rules::{Rule, pair};

/// Taught on.
const TRAINING: [&str; 5] = ["16_16", "16_20", "16_21", "16_30", "16_33"];
/// Not seen.
const UNSEEN: [&str; 2] = ["16_13", "16_18"];

fn main() -> Result<(), Box<dyn Error>> {
    let (mut counts, mut out): (Vec<usize>, Option<String>) = (Vec::new(), None);
    let mut options = ExampleOptions::default();
    let mut arguments = std::env::args().skip(1);
    while let Some(a) = arguments.next() {
        match a.as_str() {
            "--path-weight" => {
                options.path_weight = arguments.next().ok_or("--path-weight needs a number")?.parse()?;
            }
            "--no-gate" => options.gate = false,
            "--out" => out = Some(arguments.next().ok_or("--out needs a folder")?),
            count => {
                counts.push(count.parse().map_err(|e| format!("`{count}` is no number of frames: {e}"))?)
            }
        }
    }
    let counts = if counts.is_empty() { vec![10, 20, 40, 80, 160, 320] } else { counts };
    let pairs = |names: &[&str], rule| -> Result<Vec<Pair>, Box<dyn Error>> {
        names
            .iter()
            .map(|name| {
                let (clip, _) = formats::open_clip(
                    &support::shared(&format!("mocap/bvh/{name}.bvh")),
                    &ImportOptions::default(),
                )?;
                Ok(pair(rule, name, &clip)?)
            })
            .collect()
    };
    println!("taught on {}; not seen: {}", TRAINING.join(", "), UNSEEN.join(", "));
    let mut panels = Vec::new();
    for rule in Rule::ALL {
        let mut curves = vec![Vec::new(); Way::ALL.len()];
        let (training, unseen) = (pairs(&TRAINING, rule)?, pairs(&UNSEEN, rule)?);
        println!("\n{}", rule.name());
        println!(
            "{:>8} {:>14} {:>10} {:>10} {:>8} {:>9}",
            "frames", "way", "edited °", "others °", "rate %", "drift ms"
        );
        for &count in &counts {
            for (curve, way) in curves.iter_mut().zip(Way::ALL) {
                let e = error(way, &training, &unseen, count, &options)?;
                let shown = if rule == Rule::Timing { e.rate_percent } else { e.edited_deg };
                curve.push([count as f64, shown]);
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
        let (y_label, bar) = match rule {
            Rule::Timing => ("rate of time, % RMS", Some(5.0)),
            Rule::Lean | Rule::SpineByKnee | Rule::LeanBySpeed => ("edited joints, ° RMS", Some(2.0)),
            _ => ("edited joints, ° RMS", None),
        };
        panels.push(LearningPanel { title: rule.name().into(), y_label: y_label.into(), curves, bar });
    }
    if let Some(out) = out {
        let out = Path::new(&out);
        std::fs::create_dir_all(out)?;
        let ways = Way::ALL.map(|w| (w.name(), w == Way::Keys));
        let note = format!(
            "{} not seen, {} taught on; “keyed there” has as many keys in the clips not seen themselves, all others none",
            UNSEEN.join(", "),
            TRAINING.join(", ")
        );
        let figure =
            learning_curves(&panels, &ways, "frames keyed", "Known edits, learned from few frames", &note);
        for path in figure.save(out, "learning_curves")? {
            println!("{}", path.display());
        }
    }
    Ok(())
}
