//! `tune --sweep` and `tune --merge`: a grid of costs, in one go or in parts.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use studies::tune::journal::Head;
use studies::tune::sweep_results::{self, TABLE};
use studies::tune::{self, Cost, Grid, Sample, SweepError, sweep};
use takes::Take;
use takes::results::folder::{Overwrite, write_file};

use crate::args::TuneArgs;
use crate::engines::{confirming, engines};
use crate::failure::Failure;
use crate::output;
use crate::progress::progress;

fn folder(args: &TuneArgs, take: &Take) -> Result<PathBuf, Failure> {
    let dir = output::folder(args.out.as_deref(), &format!("{}-sweep", take.name));
    std::fs::create_dir_all(&dir)
        .map_err(|e| Failure::run(format!("cannot write into {}: {e}", dir.display())))?;
    Ok(dir)
}

/// Costs a grid or a shard of it.
///
/// # Errors
/// Bad input, files that cannot be written.
pub fn run(args: &TuneArgs, take: &Take) -> Result<(), Failure> {
    let (axes, shard) = args.grid()?;
    let grid = Grid::new(axes)?;
    let engines = engines();
    let engine = take.searcher(&engines)?;
    let cost = Cost::new(take, &take.tune, engine)?;
    let identity = grid.identity(&take.name, &tune::digest(take, &take.tune));
    let dir = folder(args, take)?;
    let path = dir.join(TABLE);
    if args.fresh {
        sweep::forget(&path)?;
    }
    let progress = progress();
    progress.part("sweeping");
    let made = sweep::run(&cost, &grid, shard, &identity, &path, &mut |x| progress.at(x))?;
    drop(progress);
    let table = sweep::read(&path, Some(&identity))?;
    let all: BTreeMap<usize, Sample> = table.samples.into_iter().collect();
    let missing = shard.samples(grid.len()).filter(|i| !all.contains_key(i)).count();
    let text = format!(
        "{}: {made} samples costed, {} of {} in the table{}\n",
        take.name,
        all.len(),
        grid.len(),
        if missing == 0 { String::new() } else { format!(", {missing} of this shard missing") }
    );
    finish(args, take, &dir, &table.head, &all, text, missing == 0)
}

/// A sample costed in a second engine: its name, and the cost there.
fn confirmed(
    args: &TuneArgs,
    take: &Take,
    head: &Head,
    sample: &Sample,
) -> Result<Option<(String, f64)>, Failure> {
    let engines = engines();
    let Some(second) = confirming(&engines, &args.confirm, take.searcher(&engines)?)? else {
        return Ok(None);
    };
    let cost = Cost::new(take, &take.tune, second)?;
    let tunable = cost.with_named(head.parameters().into_iter().zip(sample.values.iter().copied()));
    Ok(Some((second.name().to_owned(), cost.evaluate(&tunable).cost)))
}

/// Merges tables.
///
/// # Errors
/// Tables that do not belong together, files that cannot be read or written.
pub fn merge(args: &TuneArgs, take: &Take) -> Result<(), Failure> {
    let (table, all) = sweep::merge(&args.merge).map_err(|e| match e {
        // the tables to merge are the input, so an error of them is one of the input
        SweepError::File { .. } => Failure::input(e),
        e => e.into(),
    })?;
    let digest = tune::digest(take, &take.tune);
    if !table.head.identity.ends_with(&format!("input={digest}")) {
        return Err(Failure::Input(format!(
            "the tables are of another scene than {}, or of an earlier state of it\n  found:  {}\n  needed: … input={digest}",
            take.name, table.head.identity
        )));
    }
    let dir = folder(args, take)?;
    let path = dir.join(TABLE);
    sweep::check_replaceable(&path)?;
    let text = table.head.table(all.iter().map(|(i, s)| (*i, s)));
    write_file(&path, text.as_bytes(), Overwrite::Allow, &args.merge)?;
    let (text, whole) = match sweep::samples_of(&table.head.identity) {
        Some(n) if n > all.len() => {
            let missing = n - all.len();
            (format!("{}: {} of {n} samples; {missing} are missing\n", take.name, all.len()), false)
        }
        _ => (format!("{}: all {} samples\n", take.name, all.len()), true),
    };
    finish(args, take, &dir, &table.head, &all, text, whole)
}

/// Figure and summary of what the table holds; of a `whole` one the best sample is costed in a second engine.
fn finish(
    args: &TuneArgs,
    take: &Take,
    dir: &Path,
    head: &Head,
    all: &BTreeMap<usize, Sample>,
    mut text: String,
    whole: bool,
) -> Result<(), Failure> {
    let names = head.parameters();
    let best = sweep_results::best(all);
    let second = match best {
        Some((_, sample)) if whole => confirmed(args, take, head, sample)?,
        _ => None,
    };
    let mut files = vec![dir.join(TABLE)];
    if !args.no_plots && !all.is_empty() {
        files.extend(sweep_results::draw(dir, head, all)?);
    }
    if let Some((index, s)) = best {
        let values: Vec<String> = names.iter().zip(&s.values).map(|(n, x)| format!("{n} = {x}")).collect();
        text += &format!("  least cost {:.4} at {} (sample {index})\n", s.cost, values.join(", "));
        if let Some((engine, cost)) = &second {
            text += &format!("  the same point costs {cost:.4} in {engine}\n");
        }
    }
    let files: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
    text += &format!("  files      {}\n", files.join("\n             "));
    if !args.json {
        return output::print(&text);
    }
    let samples: Vec<serde_json::Value> = all
        .iter()
        .map(|(i, s)| {
            let values: BTreeMap<&str, f64> = names.iter().copied().zip(s.values.iter().copied()).collect();
            let terms: BTreeMap<&str, f64> = tune::TERMS.into_iter().zip(s.terms.iter().copied()).collect();
            serde_json::json!({ "index": i, "cost": s.cost, "terms": terms, "survived": s.survived, "values": values })
        })
        .collect();
    let json = serde_json::json!({ "best": best.map(|(i, _)| i), "confirmed": second.map(|(engine, cost)| serde_json::json!({ "engine": engine, "cost": cost })), "samples": samples });
    output::json(&json)
}
