//! `render --pareto`: what a motion costs in help from outside, and what the help buys.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use motion::format;
use plots::TradePoint;
use scenes::overrides::RootChoice;
use scenes::pareto::{self, FIDELITIES, Pareto};

use crate::args::RenderArgs;
use crate::failure::Failure;
use crate::output::{self, Output};
use crate::progress::Progress;
use crate::summary::number;

/// The figure's stem.
const FIGURE: &str = "pareto";

/// Runs the curve; no fidelities are the default ones.
///
/// # Errors
/// Bad input, passes that cannot start, files that cannot be written.
pub fn run(args: &RenderArgs, fidelities: &[f64]) -> Result<(), Failure> {
    let mut progress = Progress::new();
    progress.part("staging");
    // not pinned: a clip that stands is staged on planted feet
    let overrides =
        scenes::Overrides { root: Some(RootChoice::Free), ..args.overrides().map_err(Failure::input)? };
    let stage = scenes::open_with(&args.input, args.body.as_deref(), &args.clip.import(), &overrides)
        .map_err(Failure::input)?;
    let stage = if args.no_edits { stage.without_edits() } else { stage };
    let dir = args.out.clone().unwrap_or_else(|| Path::new("out").join(format!("{}-pareto", stage.name)));
    Output::check(&dir)?;
    progress.part("performing");
    let bar = Mutex::new(progress);
    let tell = |done: f64| {
        if let Ok(mut bar) = bar.lock() {
            bar.at(done);
        }
    };
    let fidelities = if fidelities.is_empty() { &FIDELITIES[..] } else { fidelities };
    let mut curve = pareto::pareto(&stage, fidelities, &tell).map_err(Failure::run)?;

    let output = Output::replacing(&dir, ours())?;
    if !args.no_plots {
        let plots = output.dir().join(output::PLOTS);
        std::fs::create_dir(&plots)
            .map_err(|e| Failure::run(format!("cannot write {}: {e}", output::PLOTS)))?;
        figure(&curve).save(&plots, FIGURE).map_err(Failure::run)?;
        for kind in ["svg", "png"] {
            curve.files.insert(format!("{FIGURE}_{kind}"), format!("{}/{FIGURE}.{kind}", output::PLOTS));
        }
    }
    curve.files.insert("report_json".into(), "report.json".into());
    let json = curve.to_json();
    format::write(&output.dir().join("report.json"), json.as_bytes()).map_err(Failure::run)?;
    output.finish()?;
    drop(bar);
    output::print(&if args.json { json } else { summary(&curve, &dir) })
}

fn figure(curve: &Pareto) -> plots::Figure {
    let points: Vec<TradePoint> = curve
        .points
        .iter()
        .map(|p| TradePoint {
            fidelity: p.fidelity,
            force_rms_percent: p.force_rms_percent_bw,
            force_peak_percent: p.force_peak_percent_bw,
            budget_percent: 100.0 * p.force_budget_n / curve.weight_n.max(1e-12),
            error_mm: p.position_rms_mm,
            error_deg: p.joint_rms_deg,
            stands: p.stands(),
        })
        .collect();
    let note = format!(
        "{}: {:.1} kg. Fidelity x allows the root x² of the body weight ({:.0} N) in help from outside. Numbers at the \
         dots are fidelities.",
        curve.scene, curve.mass_kg, curve.weight_n
    );
    plots::trade_off(&points, &note)
}

fn summary(curve: &Pareto, dir: &Path) -> String {
    let mut text = String::new();
    // writing to a String cannot fail
    let _ = write(&mut text, curve, dir);
    text
}

fn write(out: &mut String, curve: &Pareto, dir: &Path) -> std::fmt::Result {
    let stand = curve.points.iter().filter(|p| p.stands());
    let first = stand.map(|p| p.fidelity).next();
    match first {
        Some(0.0) => {
            writeln!(out, "{}: stands free; help from outside only brings it closer\n", curve.scene)?
        }
        Some(f) => writeln!(out, "{}: stands from fidelity {} on\n", curve.scene, number(f))?,
        None => writeln!(out, "{}: THE BODY FELL at every fidelity\n", curve.scene)?,
    }
    writeln!(
        out,
        "  fidelity    budget    force RMS (of weight)      peak    moment RMS   links    joints  then"
    )?;
    for p in &curve.points {
        let then = match (&p.diverged, p.fell_at_s) {
            (Some(why), _) => format!("FAILED, {why}"),
            (None, Some(at)) => format!("fell at {at:.2} s"),
            (None, None) if p.efficient => "stands".into(),
            (None, None) => "stands, but less help follows closer".into(),
        };
        writeln!(
            out,
            "  {:>8} {:>7.1} N  {:>7.2} N   ({:>6.2} %) {:>9.1} N {:>9.2} N·m {:>5.0} mm {:>7.2}°  {then}",
            number(p.fidelity),
            p.force_budget_n,
            p.force_rms_n,
            p.force_rms_percent_bw,
            p.force_peak_n,
            p.moment_rms_nm,
            p.position_rms_mm,
            p.joint_rms_deg,
        )?;
    }
    let files: Vec<String> = curve.files.values().map(|f| dir.join(f).display().to_string()).collect();
    writeln!(out, "\n  files      {}", files.join("\n             "))
}

/// Every file a curve may leave, relative to its folder.
fn ours() -> Vec<PathBuf> {
    let figure = ["svg", "png"].map(|kind| Path::new(output::PLOTS).join(format!("{FIGURE}.{kind}")));
    figure.into_iter().chain([PathBuf::from("report.json")]).collect()
}
