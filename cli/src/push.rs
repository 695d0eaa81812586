//! `push`: a standing scene to its push-recovery map: table, JSON, polar figure.

use std::path::Path;

use studies::push::{self, PushMap, results};
use takes::Ask;
use takes::results::folder::Folder;

use crate::args::PushArgs;
use crate::engines::{confirming, engines};
use crate::failure::Failure;
use crate::output;
use crate::progress::progress;

/// Runs the command.
///
/// # Errors
/// Bad input, a body that does not stand, files that cannot be written.
pub fn run(args: &PushArgs) -> Result<(), Failure> {
    let progress = progress();
    let overrides = args.physics.overrides().map_err(Failure::input)?;
    let ask = Ask { overrides, engine: args.engine.clone(), ..Ask::default() };
    let take = takes::open(args.input.as_path(), &ask)?;
    let dir = output::folder(args.out.as_deref(), &format!("{}-push", take.name));
    Folder::check(&dir, &results::plan(&take.files))?;
    let engines = engines();
    let engine = take.searcher(&engines)?;
    let second = confirming(&engines, &args.confirm, engine)?;
    progress.part("pushing");
    let mut map = push::map(&take, args.settings(), engine, &|x| progress.at(x))?;
    if let Some(second) = second {
        progress.part("confirming");
        map.confirmed = Some(push::confirm(&map, &take, args.settings(), second, &|x| progress.at(x))?);
    }
    let undrawn = map.write(&dir, !args.no_plots, &take.files, &progress)?;
    drop(progress);
    output::print(&if args.json { map.to_json() } else { summary(&map, &dir) })?;
    output::undrawn(&undrawn, &dir)
}

/// The word for a direction, if it has one.
fn word(deg: f64) -> &'static str {
    match deg {
        0.0 => "forward",
        90.0 => "left",
        180.0 => "back",
        270.0 => "right",
        _ => "",
    }
}

fn summary(map: &PushMap, dir: &Path) -> String {
    let mut text = format!(
        "{}: survives in {} {:.0} % of the physical limit on average, {:.0} % at least",
        map.scene,
        map.engine,
        100.0 * map.mean_ratio,
        100.0 * map.min_ratio
    );
    if let Some(c) = &map.confirmed {
        text += &format!(
            "; {} confirms {} of {} directions within {} %",
            c.engine,
            c.confirmed,
            c.directions.len(),
            c.within_percent
        );
    }
    let second =
        map.confirmed.as_ref().map_or_else(String::new, |c| format!("   {}: inside, outside", c.engine));
    text += &format!("\n\n  direction         survived      limit   ratio  then       {second}\n");
    for (i, d) in map.directions.iter().enumerate() {
        let row = format!(
            "  {:>6.1}° {:<8} {:>6.2} N·s {:>6.2} N·s {:>5.0} %  {:<11}",
            d.deg,
            word(d.deg),
            d.survived_ns,
            d.limit_ns,
            100.0 * d.ratio,
            d.lost
        );
        let c = map.confirmed.as_ref().map(|c| &c.directions[i]);
        let second = c.map_or_else(String::new, |c| {
            format!("{:.2} N·s {}, {:.2} N·s {}", c.inside_ns, c.inside, c.outside_ns, c.outside)
        });
        text += &format!("{}\n", format!("{row}   {second}").trim_end());
    }
    text += "\n";
    if let Some(e) = map.symmetry_error_percent {
        text += &format!("  left/right differ by {e:.1} % at most; ");
    } else {
        text += "  ";
    }
    text += &format!(
        "{:.1} kg, centre of mass {:.3} m high, pushed for {:.3} s at {}; impulses known to {} %\n",
        map.mass_kg, map.com_height_m, map.push_s, map.push_link, map.tolerance_percent
    );
    let files: Vec<String> = map.files.values().map(|f| dir.join(f).display().to_string()).collect();
    text + &format!("  files      {}\n", files.join("\n             "))
}
