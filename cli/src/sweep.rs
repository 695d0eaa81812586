//! `tune --sweep` and `tune --merge`: a grid of costs, in one go or in parts.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use motion::format;
use plots::CostSlice;
use scenes::Stage;
use scenes::tune::{self, Cost, Grid, Sample, SweepError, journal, sweep};

use crate::args::TuneArgs;
use crate::failure::Failure;
use crate::output::{self, Output};
use crate::progress::Progress;

/// The table of samples.
const TABLE: &str = "sweep.csv";
/// The figure's stem.
const FIGURE: &str = "sweep";

fn failure(e: SweepError) -> Failure {
    match e {
        SweepError::File { .. } => Failure::run(e),
        _ => Failure::input(e),
    }
}

fn folder(args: &TuneArgs, stage: &Stage) -> Result<PathBuf, Failure> {
    let dir = args.out.clone().unwrap_or_else(|| Path::new("out").join(format!("{}-sweep", stage.name)));
    Output::check(&dir)?;
    std::fs::create_dir_all(&dir)
        .map_err(|e| Failure::run(format!("cannot write into {}: {e}", dir.display())))?;
    Ok(dir)
}

/// Costs a grid or a shard of it.
///
/// # Errors
/// Bad input, files that cannot be written.
pub fn run(args: &TuneArgs, stage: &Stage) -> Result<(), Failure> {
    let (axes, shard) = args.grid().map_err(failure)?;
    let grid = Grid::new(axes).map_err(failure)?;
    let cost = Cost::new(stage, &stage.tune).map_err(|e| match e.is_input() {
        true => Failure::input(e),
        false => Failure::run(e),
    })?;
    let identity = grid.identity(&stage.name, &tune::digest(stage, &stage.tune));
    let dir = folder(args, stage)?;
    let path = dir.join(TABLE);
    if args.fresh && path.exists() {
        std::fs::remove_file(&path)
            .map_err(|e| Failure::run(format!("cannot remove {}: {e}", path.display())))?;
    }
    let mut progress = Progress::new();
    progress.part("sweeping");
    let made = sweep::run(&cost, &grid, shard, &identity, &path, &mut |x| progress.at(x)).map_err(failure)?;
    drop(progress);
    let table = sweep::read(&path, Some(&identity)).map_err(failure)?;
    let all: BTreeMap<usize, Sample> = table.samples.into_iter().collect();
    let missing = shard.samples(grid.len()).filter(|i| !all.contains_key(i)).count();
    let said = format!(
        "{}: {made} samples costed, {} of {} in the table{}\n",
        stage.name,
        all.len(),
        grid.len(),
        if missing == 0 { String::new() } else { format!(", {missing} of this shard missing") }
    );
    finish(args, &dir, &table.head, &all, said)
}

/// Merges tables.
///
/// # Errors
/// Tables that do not belong together, files that cannot be read or written.
pub fn merge(args: &TuneArgs, stage: &Stage) -> Result<(), Failure> {
    let (table, all) = sweep::merge(&args.merge).map_err(|e| match e {
        // the files are the input here
        SweepError::File { .. } => Failure::input(e),
        e => failure(e),
    })?;
    let digest = tune::digest(stage, &stage.tune);
    if !table.identity.ends_with(&format!("input={digest}")) {
        return Err(Failure::Input(format!(
            "the tables are of another scene than {}, or of an earlier state of it\n  found:  {}\n  needed: … input={digest}",
            stage.name, table.identity
        )));
    }
    let dir = folder(args, stage)?;
    let mut text = format!("# {}\n{}\n", table.identity, table.head);
    for (i, s) in &all {
        text += &(journal::line(*i, s) + "\n");
    }
    format::write(&dir.join(TABLE), text.as_bytes()).map_err(Failure::run)?;
    let expected = sweep::samples_of(&table.identity);
    let said = match expected {
        Some(n) if n > all.len() => {
            format!("{}: {} of {n} samples; {} are missing\n", stage.name, all.len(), n - all.len())
        }
        _ => format!("{}: all {} samples\n", stage.name, all.len()),
    };
    finish(args, &dir, &table.head, &all, said)
}

/// Figure and summary of what the table holds.
fn finish(
    args: &TuneArgs,
    dir: &Path,
    head: &str,
    all: &BTreeMap<usize, Sample>,
    mut said: String,
) -> Result<(), Failure> {
    let names: Vec<&str> = journal::parameters_of(head);
    let best = all.iter().min_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
    let mut files = vec![dir.join(TABLE)];
    if !args.no_plots && !all.is_empty() {
        let plots = dir.join(output::PLOTS);
        std::fs::create_dir_all(&plots)
            .map_err(|e| Failure::run(format!("cannot write {}: {e}", output::PLOTS)))?;
        let slices: Vec<CostSlice> =
            names.iter().enumerate().map(|(k, name)| slice(k, name, all, best)).collect();
        let note = format!("{} samples of a grid.", all.len());
        let figure = plots::cost_slices(&slices, "Cost along each axis of the sweep", &note);
        files.extend(figure.save(&plots, FIGURE).map_err(Failure::run)?);
    }
    if let Some((index, s)) = best {
        let values: Vec<String> = names.iter().zip(&s.values).map(|(n, x)| format!("{n} = {x}")).collect();
        said += &format!("  least cost {:.4} at {} (sample {index})\n", s.cost, values.join(", "));
    }
    let files: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
    said += &format!("  files      {}\n", files.join("\n             "));
    if !args.json {
        return output::print(&said);
    }
    let samples: Vec<serde_json::Value> = all
        .iter()
        .map(|(i, s)| {
            let values: BTreeMap<&str, f64> = names.iter().copied().zip(s.values.iter().copied()).collect();
            let terms: BTreeMap<&str, f64> = tune::TERMS.into_iter().zip(s.terms.iter().copied()).collect();
            serde_json::json!({ "index": i, "cost": s.cost, "terms": terms, "survived": s.survived, "values": values })
        })
        .collect();
    let json = serde_json::json!({ "best": best.map(|(i, _)| i), "samples": samples });
    output::print(&(serde_json::to_string_pretty(&json).map_err(Failure::run)? + "\n"))
}

/// One axis: all samples, and the least cost at each of its values.
fn slice(k: usize, name: &str, all: &BTreeMap<usize, Sample>, best: Option<(&usize, &Sample)>) -> CostSlice {
    let cloud: Vec<[f64; 2]> = all.values().map(|s| [s.values[k], s.cost]).collect();
    let mut points = cloud.clone();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup_by(|b, a| a[0] == b[0]);
    CostSlice {
        name: name.into(),
        unit: tune::parameters().iter().find(|p| p.name == name).map_or("", |p| p.unit).into(),
        points,
        cloud,
        was: None,
        is: best.map(|(_, s)| [s.values[k], s.cost]),
    }
}
