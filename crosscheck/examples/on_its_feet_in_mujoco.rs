//! Captured clips performed free in MuJoCo: which keep their feet.
//!
//! In: clips. Out: a line per clip, and how many keep their feet. Foresight is that of every engine, closed loop on MuJoCo's state.
//!
//! ```sh
//! cargo run --release -p crosscheck --example on_its_feet_in_mujoco -- ../shared/mocap/bvh/{16_16,02_01,09_01}.bvh
//! ```

use std::path::PathBuf;

use dynamics::Walked;
use sim::foresight::{Foreseen, Settings};
use takes::overrides::RootChoice;
use takes::{Ask, Overrides, open};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut tension, mut settings) = (2.0, Settings::default());
    let mut files: Vec<PathBuf> = Vec::new();
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut value = || args.next().ok_or(format!("{arg} needs a value"));
        match arg.as_str() {
            "--tension" => tension = value()?.parse()?,
            "--seed" => settings.seed = value()?.parse()?,
            "--rollouts" => settings.rollouts = value()?.parse()?,
            _ => files.push(arg.into()),
        }
    }
    let mujoco = crosscheck::engine(|note| eprintln!("{note}"));
    let mut kept = 0;
    for file in &files {
        let overrides =
            Overrides { root: Some(RootChoice::Free), tension: Some(tension), ..Overrides::default() };
        let foresight = Some(Foreseen::Search(settings));
        let take = open(file, &Ask { overrides, foresight, ..Ask::default() })?;
        let pass = take.pass();
        let (rows, seconds) = (pass.setup.goal.rows(), take.asked.clip.duration_s());
        let outcome = pass.run(&mujoco, &mut |_| {})?;
        let walked = Walked::of(&outcome.trace, rows);
        kept += usize::from(walked.lost.is_none());
        println!(
            "{:<12} {:>5.2} of {seconds:>5.2} s  {:>4.0} mm  {:>4.1}°  slip {:>4.1} mm  peak {:>4.2}  unexplained {:>5.2} %  offsets {:>4.1}°  {}",
            file.file_stem().unwrap_or_default().to_string_lossy(),
            walked.kept_s,
            walked.links_mm,
            walked.joints_deg,
            walked.slip_mm(),
            walked.peak,
            walked.unexplained,
            outcome.foresight.map_or(0.0, |f| f.offset_rms().to_degrees()),
            walked.lost.map_or("kept".to_owned(), |(t, loss)| format!("{t:.2} s: {loss}")),
        );
    }
    println!("{kept} of {} keep their feet in MuJoCo", files.len());
    Ok(())
}
