//! What a step costs as bodies grow: the core and rapier, drawn.
//!
//! In: a folder. Out: a line per body of 8 to 120 links, and `growth.svg` and `growth.png` in the folder: least times of many short
//! blocks, both engines in turn, over degrees of freedom.
//!
//! ```sh
//! cargo run --release -p studies --example growth -- docs/pictures
//! ```

use std::path::PathBuf;
use std::time::Instant;

use bodies::Character;
use controllers::{Drive, rest_of};
use motion::Floor;
use plots::panel::{Key, Panel, Series, Stroke, page};
use plots::style::{BLUE, SOFT, VERMILION};
use sim::{Core, Engine, EngineSettings, Rapier};

#[path = "../../sim/benches/bush/mod.rs"]
mod bush;

const LINKS: [usize; 5] = [8, 22, 40, 60, 120];
/// Steps per block.
const BLOCK: usize = 24;
/// Blocks of the core, of which every fourth is followed by one of rapier.
const BLOCKS: usize = 200;

fn settings() -> EngineSettings {
    EngineSettings::free(240.0, 1, Some(Floor::level(0.0, 0.8)))
}

/// Least times of a step in the core and in rapier, s.
fn least(c: &Character) -> Result<[f64; 2], Box<dyn std::error::Error>> {
    let still = vec![0.0; c.skeleton.nv()];
    let mut engines: [Box<dyn Engine>; 2] = [
        Box::new(Core::new(c, settings(), &c.rest, &still)?),
        Box::new(Rapier::new(c, settings(), &c.rest, &still)?),
    ];
    let mut best = [f64::INFINITY; 2];
    for block in 0..BLOCKS {
        for (i, (engine, best)) in engines.iter_mut().zip(&mut best).enumerate() {
            if i == 1 && block % 4 > 0 {
                continue;
            }
            let model = engine.model();
            let hold = |b: usize| Drive { stiffness: 200.0, damping: 10.0, rest: rest_of(model, b, &c.rest) };
            let drives: Vec<Drive> = (0..model.bodies.len()).map(hold).collect();
            let start = Instant::now();
            for _ in 0..BLOCK {
                engine.set_drives(&drives);
                engine.step()?;
            }
            *best = best.min(start.elapsed().as_secs_f64() / BLOCK as f64);
        }
    }
    Ok(best)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("name a folder for the picture")?);
    let mut rows = Vec::new();
    for links in LINKS {
        let c = bush::bush(links);
        let (n, [core, rapier]) = (c.skeleton.nv(), least(&c)?);
        println!(
            "{links:4} links, {n:4} degrees of freedom: core {:6.2} µs, {:.3} µs each; rapier {:8.1} µs",
            core * 1e6,
            core * 1e6 / n as f64,
            rapier * 1e6
        );
        rows.push((links, n as f64, core * 1e6, rapier * 1e3));
    }
    let panel = |title: &str, unit: &str, color, of: fn(&(usize, f64, f64, f64)) -> f64| {
        let at = |r: &(usize, f64, f64, f64)| [r.1, of(r)];
        let line = |points, color, stroke| Series { points, color, width: 1.7, stroke };
        let first = rows[0];
        let slope = of(&first) / first.1;
        let end = rows[rows.len() - 1].1;
        Panel {
            title: title.into(),
            x_label: "degrees of freedom".into(),
            y_label: unit.into(),
            series: vec![
                line(vec![[0.0, 0.0], [end, slope * end]], SOFT, Stroke::Dashed),
                line(rows.iter().map(at).collect(), color, Stroke::Solid),
            ],
            dots: rows.iter().map(|r| (at(r), 3.0, color)).collect(),
            labels: rows.iter().map(|r| (at(r), format!("{} links", r.0), SOFT)).collect(),
            ..Panel::default()
        }
    };
    let panels =
        [panel("the core", "µs a step", BLUE, |r| r.2), panel("rapier", "ms a step", VERMILION, |r| r.3)];
    let keys = [
        Key::line("core", BLUE),
        Key::line("rapier", VERMILION),
        Key::dashed("in proportion to the smallest body", SOFT),
    ];
    let note = "bushes of branches of five links that stand, 240 Hz, one substep; least of many blocks";
    let picture = page("What a step costs as bodies grow", note, &keys, &panels, 2, 900.0, 300.0);
    std::fs::create_dir_all(&folder)?;
    picture.save(&folder, "growth")?;
    Ok(())
}
