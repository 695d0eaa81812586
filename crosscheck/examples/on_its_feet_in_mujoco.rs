//! Captured clips performed free in MuJoCo: which keep their feet.
//!
//! In: clips, or folders of clips (those that stand from beginning to end are left out), and how to perform. Out: a line per clip and seed as it is
//! performed, as a row of a table, and how many clips keep their feet with every seed. Foresight is that of every engine, closed loop on MuJoCo's state.
//!
//! ```sh
//! cargo run --release -p crosscheck --example on_its_feet_in_mujoco -- ../shared/mocap/bvh
//! ```

#[path = "../../takes/examples/common/mod.rs"]
mod common;

use common::{Failed, Options};
use dynamics::Walked;
use takes::open;

fn main() -> Result<(), Failed> {
    let options = Options::read(None, |_, _| Ok(false))?;
    let mujoco = crosscheck::engine(|note| eprintln!("{note}"));
    println!(
        "| clip | seed | kept its feet | links, mm | joints | slip, mm | peak | unexplained | offsets |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut kept = 0;
    for file in &options.files {
        let mut stands = true;
        for &seed in &options.seeds {
            let take = open(file, &options.ask(seed))?;
            let pass = take.pass();
            let (rows, seconds) = (pass.setup.goal.rows(), take.asked.clip.duration_s());
            let outcome = pass.run(&mujoco, &mut |_| {})?;
            let walked = Walked::of(&outcome.trace, rows);
            stands &= walked.lost.is_none();
            let longest = walked.slip_mm_max();
            println!(
                "| {} | {seed} | {:.2} of {seconds:.2} s{} | {:.0} | {:.1}° | {:.0} ({longest:.0}) | {:.2} | {:.2} % | {:.1}° |",
                take.name,
                walked.kept_s,
                walked.lost.as_ref().map_or(String::new(), |(t, loss)| format!(", {t:.2} s: {loss}")),
                walked.links_mm,
                walked.joints_deg,
                walked.slip_mm(),
                walked.peak,
                walked.unexplained,
                outcome.foresight.map_or(0.0, |f| f.offset_rms().to_degrees()),
            );
        }
        kept += usize::from(stands);
    }
    println!("{kept} of {} keep their feet in MuJoCo", options.files.len());
    Ok(())
}
