//! Words of `tune`.

use std::path::PathBuf;

use clap::Args;
use motion::names::Word;
use studies::tune::{Axis, SearchStart, Shard, SolverKind};

use takes::ENGINE;

use crate::common_args::{searcher_help, whole};
use crate::words::word;

/// Arguments of `tune`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct TuneArgs {
    /// Scene (.ron, or a name of the library) of a body that stands free; its `tune` section says what is searched and what it costs
    #[arg(value_name = "SCENE", required_unless_present = "list")]
    pub input: Option<PathBuf>,
    /// Who searches: cma-es for many parameters and costs that jump, nelder-mead for a few
    #[arg(long, value_name = "SOLVER", value_parser = word::<SolverKind>(), default_value = SolverKind::default().word())]
    pub solver: SolverKind,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", default_value_t = 1, conflicts_with_all = ["sweep", "merge"])]
    pub seed: u64,
    /// Where the search starts: at the scene's values, or anywhere in the ranges (by the seed)
    #[arg(long, value_parser = word::<SearchStart>(), default_value = SearchStart::default().word())]
    pub start: SearchStart,
    /// Points costed; the generation under way is finished
    #[arg(long, value_name = "N", default_value_t = 250, value_parser = evaluations)]
    pub evaluations: usize,
    /// Parameters searched, separated by commas [default: the scene's, or all; see --list]
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub parameters: Vec<String>,
    /// Cost a grid instead: NAME=FROM..TO:N; may be given several times
    #[arg(long, value_name = "AXIS", conflicts_with_all = ["solver", "start", "evaluations", "parameters"])]
    pub sweep: Vec<String>,
    /// Of a sweep only the i-th of n parts, from 1: one job of an array
    #[arg(long, value_name = "i/n", requires = "sweep", conflicts_with = "merge")]
    pub shard: Option<String>,
    /// Merge the tables of a sweep's jobs into one
    #[arg(long, value_name = "FILE.csv", num_args = 1.., conflicts_with_all = ["sweep", "solver", "start", "evaluations", "parameters"])]
    pub merge: Vec<PathBuf>,
    /// Print the parameters there are: unit, default, range, and what turning them does
    #[arg(long, exclusive = true)]
    pub list: bool,
    /// Patch of tension and balance to start from
    #[arg(long, value_name = "FILE.ron")]
    pub patch: Option<PathBuf>,
    /// Engine that searches.
    #[arg(long, value_name = "ENGINE", help = searcher_help())]
    pub engine: Option<String>,
    /// Engine that costs the scene as it was and the best point once more; `none` leaves it out
    #[arg(long, value_name = "ENGINE", default_value = ENGINE)]
    pub confirm: String,
    /// Forget what an earlier run left in the folder instead of going on with it
    #[arg(long, conflicts_with = "merge")]
    pub fresh: bool,
    /// Points of each cost slice; 0 draws none [default: 7]
    #[arg(long, value_name = "N", value_parser = slices, conflicts_with_all = ["sweep", "merge"])]
    pub slices: Option<usize>,
    /// Directions of the push maps before and after; 0 makes none
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = directions, conflicts_with_all = ["sweep", "merge"])]
    pub directions: usize,
    /// Folder to write into [default: out/NAME-tune, out/NAME-sweep]
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Draw nothing
    #[arg(long)]
    pub no_plots: bool,
    /// Print the report as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

const EXAMPLES: &str = "\
Examples:
  contrapposto tune scenes/stand.ron                        improve what the scene has
  contrapposto tune scenes/stand.ron --start random --seed 7
  contrapposto tune scenes/stand.ron --parameters catch_gain,hip_stroke_deg --solver nelder-mead
  contrapposto push scenes/stand.ron --patch out/stand-tune/patch.ron
  contrapposto tune --list
  contrapposto tune scenes/stand.ron --sweep shift=0..1.2:7 --sweep tension=0.5..2:4
  contrapposto tune scenes/stand.ron --sweep shift=0..1.2:100 --shard $SLURM_ARRAY_TASK_ID/8 --out out/job-$SLURM_ARRAY_TASK_ID
  contrapposto tune scenes/stand.ron --merge out/job-*/sweep.csv

A search that was stopped goes on where it was when the same command is run again: all points costed are in
samples.csv, written after every generation.

Files written into DIR:
  patch.ron       parameters, old and new: --patch FILE, or `patch: \"FILE\"` in a scene
  tune.html       page of plots: cost over the search, cost along each parameter, before and after
  samples.csv     every point costed (sweep.csv for a sweep)
  report.json     the numbers, see docs/TUNE.md
  plots/          the figures, each as .svg and .png

Same scene and seed, same bytes, on any number of threads (RAYON_NUM_THREADS).
Exit codes: 0 done, 1 the run failed, 2 something is wrong with the input.";

impl TuneArgs {
    /// Axes and shard of a sweep.
    ///
    /// # Errors
    /// The first that makes no sense.
    pub fn grid(&self) -> Result<(Vec<Axis>, Shard), studies::tune::SweepError> {
        let axes = self.sweep.iter().map(|t| t.parse()).collect::<Result<_, _>>()?;
        let shard = self.shard.as_deref().map_or(Ok(Shard::WHOLE), str::parse)?;
        Ok((axes, shard))
    }
}

fn evaluations(text: &str) -> Result<usize, String> {
    whole(text, 1, 1_000_000)
}

fn slices(text: &str) -> Result<usize, String> {
    match whole(text, 0, 201) {
        Ok(1) => Err("allowed: 0, or a whole number from 2 to 201".into()),
        other => other,
    }
}

fn directions(text: &str) -> Result<usize, String> {
    whole(text, 0, 360)
}
