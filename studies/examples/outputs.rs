//! What is learned of a target: its difference to the source, or itself as in IAF09; prints the table of `docs/BY_EXAMPLE.md`.
//!
//! `cargo run --release -p studies --example outputs -- [FRAMES]`: frames taught (320). Clips: subject 16 of `../shared/mocap`. Errors in
//! degrees RMS of the edited joints and of the others; of timing % RMS of the rate and the largest drift in ms.

use std::error::Error;

use edits::by_example::{ExampleOptions, Outputs, Pair};
use formats::bvh::ImportOptions;
use motion::Clip;
use studies::propagate::compare::{Way, error};
use studies::propagate::rules::{Rule, pair};

const TRAINING: [&str; 5] = ["16_16", "16_20", "16_21", "16_30", "16_33"];
const UNSEEN: [&str; 2] = ["16_13", "16_18"];
const RUN: &str = "16_35";

fn main() -> Result<(), Box<dyn Error>> {
    let frames = std::env::args().nth(1).map_or(Ok(320), |a| a.parse())?;
    let open = |name: &str| -> Result<Clip, Box<dyn Error>> {
        let path = support::shared(&format!("mocap/bvh/{name}.bvh"));
        Ok(formats::open_clip(&path, &ImportOptions::default())?.0)
    };
    let same = |names: &[&str]| -> Result<Vec<Pair>, Box<dyn Error>> {
        names.iter().map(|name| Ok(Pair::new(*name, open(name)?, open(name)?))).collect()
    };
    let ruled = |names: &[&str], rule| -> Result<Vec<Pair>, Box<dyn Error>> {
        names.iter().map(|name| Ok(pair(rule, name, &open(name)?)?)).collect()
    };
    let mut tasks = vec![
        ("identity, walks".to_string(), same(&TRAINING)?, same(&UNSEEN)?),
        ("identity, run".to_string(), same(&TRAINING)?, same(&[RUN])?),
    ];
    for rule in Rule::ALL {
        tasks.push((rule.name().into(), ruled(&TRAINING, rule)?, ruled(&UNSEEN, rule)?));
    }
    println!("{frames} frames; edited ° / others ° (rate %, drift ms)");
    println!("{:>20} {:>28} {:>28} {:>28}", "", "differences", "poses, gate", "poses as printed");
    for (name, training, unseen) in tasks {
        print!("{name:>20}");
        for (outputs, gate) in [(Outputs::Differences, true), (Outputs::Poses, true), (Outputs::Poses, false)]
        {
            let options = ExampleOptions { outputs, gate, ..ExampleOptions::default() };
            let e = error(Way::Gp, &training, &unseen, frames, &options)?;
            let angles = format!("{:.2} / {:.2}", e.edited_deg, e.others_deg);
            let times = format!("{:.1} %, {:.0} ms", e.rate_percent, 1e3 * e.drift_s);
            print!(" {angles:>13} {times:>14}");
        }
        println!();
    }
    Ok(())
}
