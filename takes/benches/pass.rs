//! A dynamic pass of a whole scene: how many times as fast as the motion it is, in the core and in rapier.
//!
//! In: scenes of the repository. Out: the least of many passes in turn, everything that `render` does between the motion asked for and the
//! files counted: muscles, balance, steps, the recorder.
//!
//! ```sh
//! cargo bench -p takes --bench pass
//! ```

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use sim::Engines;
use takes::{Ask, open};

/// Passes in the core, and in rapier, which takes some ten times as long.
const PASSES: [usize; 2] = [30, 5];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let engines = Engines::default();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    for scene in ["bow", "reach", "wave", "stand"] {
        let (mut seconds, mut least, mut solved) = (0.0, [f64::INFINITY; 2], None);
        for ((engine, passes), least) in ["core", "rapier"].into_iter().zip(PASSES).zip(&mut least) {
            let take = open(
                scenes.join(format!("{scene}.ron")),
                &Ask { engine: Some(engine.into()), ..Ask::default() },
            )?;
            for _ in 0..passes {
                let start = Instant::now();
                let outcome = black_box(&take).outcome(&engines, &mut |_| {})?;
                *least = least.min(start.elapsed().as_secs_f64());
                if let Some(diverged) = outcome.diverged {
                    return Err(format!("{scene} in {engine}: {diverged}").into());
                }
                solved = solved.or(outcome.ledger);
                seconds = outcome.trace.rows().saturating_sub(1) as f64 / outcome.trace.rate_hz;
            }
        }
        println!(
            "{scene:<6} {seconds:5.2} s: core {:6.1} ms, {:4.0} × real time; rapier {:6.1} ms, {:4.1} × real time",
            1e3 * least[0],
            seconds / least[0],
            1e3 * least[1],
            seconds / least[1]
        );
        if let Some(l) = solved {
            let each = |count: u64| count as f64 / l.touching.max(1) as f64;
            println!(
                "       {} contact solutions of {:.2} sweeps and {:.2} Newton steps, {} above 1e-6 m g dt; {} of {} substeps solved again, {} halved",
                l.touching,
                each(l.sweeps),
                each(l.newton_steps),
                l.above_tight,
                l.resolved,
                l.substeps,
                l.halved
            );
        }
    }
    Ok(())
}
