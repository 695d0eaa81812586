//! `push`: a standing scene to its push-recovery map: table, JSON, polar figure.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use motion::format;
use motion::format::bvh::ImportOptions;
use plots::Spoke;
use scenes::push::{self, PushError, PushMap};

use crate::args::{EngineArg, PushArgs};
use crate::failure::Failure;
use crate::output::{self, Output};
use crate::progress::Progress;

/// The figure's stem.
const FIGURE: &str = "push";

/// Runs the command.
///
/// # Errors
/// Bad input, a body that does not stand, files that cannot be written.
pub fn run(args: &PushArgs) -> Result<(), Failure> {
    let mut progress = Progress::new();
    let stage = scenes::open_with(
        &args.input,
        None,
        &ImportOptions::default(),
        &args.physics.overrides().map_err(Failure::input)?,
    )
    .map_err(Failure::input)?;
    let dir = args.out.clone().unwrap_or_else(|| Path::new("out").join(format!("{}-push", stage.name)));
    Output::check(&dir)?;
    progress.part("pushing");
    let bar = Mutex::new(progress);
    let tell = |fraction: f64| {
        if let Ok(mut bar) = bar.lock() {
            bar.at(fraction);
        }
    };
    let mut map = match args.engine {
        EngineArg::Rapier => push::map(&stage, args.settings(), &tell).map_err(failure)?,
        EngineArg::Mujoco => {
            let mut say = |text: &str| eprintln!("{text}");
            crosscheck::push::map(&stage, args.settings(), &mut say, &tell)
                .map_err(|e| if e.is_input() { Failure::input(e) } else { Failure::run(e) })?
        }
    };

    let output = Output::replacing(&dir, ours())?;
    if !args.no_plots {
        let plots = output.dir().join(output::PLOTS);
        std::fs::create_dir(&plots)
            .map_err(|e| Failure::run(format!("cannot write {}: {e}", output::PLOTS)))?;
        figure(&map).save(&plots, FIGURE).map_err(Failure::run)?;
        for kind in ["svg", "png"] {
            map.files.insert(format!("{FIGURE}_{kind}"), format!("{}/{FIGURE}.{kind}", output::PLOTS));
        }
    }
    map.files.insert("report_json".into(), "report.json".into());
    let json = map.to_json();
    format::write(&output.dir().join("report.json"), json.as_bytes()).map_err(Failure::run)?;
    output.finish()?;
    drop(bar);
    output::print(&if args.json { json } else { summary(&map, &dir) })
}

fn failure(e: PushError) -> Failure {
    if e.is_input() { Failure::input(e) } else { Failure::run(e) }
}

fn figure(map: &PushMap) -> plots::Figure {
    let spokes: Vec<Spoke> = map
        .directions
        .iter()
        .map(|d| Spoke { deg: d.deg, survived: d.survived_ns, limit: d.limit_ns })
        .collect();
    let note = format!(
        "{}: {:.1} kg, pushed for {:.3} s at its centre of mass, {:.2} m high ({}), simulated by {}. Survived without a step: {:.0} % of \
         the limit on average, {:.0} % at least.",
        map.scene,
        map.mass_kg,
        map.push_s,
        map.com_height_m,
        map.push_link,
        map.engine,
        100.0 * map.mean_ratio,
        100.0 * map.min_ratio
    );
    plots::push_map(&spokes, &note)
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
    let engine = if map.engine == "rapier" { String::new() } else { format!(" in {}", map.engine) };
    let mut text = format!(
        "{}: survives{engine} {:.0} % of the physical limit on average, {:.0} % at least\n\n",
        map.scene,
        100.0 * map.mean_ratio,
        100.0 * map.min_ratio
    );
    text += "  direction         survived      limit   ratio  then\n";
    for d in &map.directions {
        text += &format!(
            "  {:>6.1}° {:<8} {:>6.2} N·s {:>6.2} N·s {:>5.0} %  {}\n",
            d.deg,
            word(d.deg),
            d.survived_ns,
            d.limit_ns,
            100.0 * d.ratio,
            d.lost
        );
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

/// Every file a map may leave, relative to its folder.
fn ours() -> Vec<PathBuf> {
    let figure = ["svg", "png"].map(|kind| Path::new(output::PLOTS).join(format!("{FIGURE}.{kind}")));
    figure.into_iter().chain([PathBuf::from("report.json")]).collect()
}
