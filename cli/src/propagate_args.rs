//! The command line of `propagate`.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use studies::propagate::{Contacts, ExampleMethod};

use crate::common_args::number;
use crate::words::word;

/// Arguments of `propagate`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct PropagateArgs {
    /// What to do with the project.
    #[command(subcommand)]
    pub step: Step,
}

const EXAMPLES: &str = "\
A project is a folder of plain files: pairs (pairs/NAME.ron with its two clips), how the edit is learned (project.ron), and
the model (model.edit). Removing pairs/NAME.ron undoes the step that made it.

Examples:
  contrapposto propagate new lean --source walk.bvh --target walk-leaning.bvh
  contrapposto propagate train lean
  contrapposto propagate apply lean other-walk.bvh other-leaning.bvh
  contrapposto propagate apply lean walk.bvh tall-leaning.bvh --onto tall.bvh   on a body of other proportions
  contrapposto propagate export lean turn.bvh turn-to-correct.bvh    edit some frames of it in Blender, then
  contrapposto propagate correct lean turn.bvh --from turn-edited.bvh
  contrapposto propagate status lean turn.bvh                        what to key next

Frame n of a target is frame n of its source, edited. A clip may also be a scene (.ron): its motion. In a scene: edits: [ByExample(model: \"lean/model.edit\")].
docs/BY_EXAMPLE.md has the method and its numbers.";

/// A step of the loop.
#[derive(Debug, Subcommand)]
pub enum Step {
    /// Make a project with a first pair
    New(PairArgs),
    /// Add a pair to a project
    Add(PairArgs),
    /// Learn the edit of all pairs; writes model.edit
    Train(TrainArgs),
    /// Apply the edit to a clip
    Apply(ApplyArgs),
    /// Write what the edit makes of a clip frame by frame, to be corrected in another program
    Export(ExportArgs),
    /// Find the frames that were changed in such a clip, add them as a pair, and learn again
    Correct(CorrectArgs),
    /// Say what the project holds, where the model is unsure, and which examples contradict each other
    Status(StatusArgs),
}

/// A pair.
#[derive(Debug, Args)]
pub struct PairArgs {
    /// Folder of the project
    #[arg(value_name = "PROJECT")]
    pub project: PathBuf,
    /// The motion before
    #[arg(long, value_name = "CLIP")]
    pub source: PathBuf,
    /// The same frames, edited
    #[arg(long, value_name = "CLIP")]
    pub target: PathBuf,
    /// Name of the pair [default: that of the target's file]
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
    /// Only this part is an example, s; may be given several times
    #[arg(long = "span", value_name = "FROM,TO", value_parser = span, allow_negative_numbers = true)]
    pub spans: Vec<(f64, f64)>,
    /// Keeps this pair apart from pairs of other contexts
    #[arg(long, value_name = "LABEL")]
    pub context: Option<String>,
}

/// How to learn.
#[derive(Debug, Args)]
pub struct TrainArgs {
    /// Folder of the project
    #[arg(value_name = "PROJECT")]
    pub project: PathBuf,
    /// What predicts [default: what project.ron says]
    #[arg(long, value_name = "gp|mls|nearest")]
    pub estimator: Option<ExampleMethod>,
    /// Learn only pairs of this context, and of none
    #[arg(long, value_name = "LABEL")]
    pub context: Option<String>,
    /// Print the numbers as JSON
    #[arg(long)]
    pub json: bool,
}

/// How much, and where.
#[derive(Debug, Args)]
pub struct PlaceArgs {
    /// How much of the edit: 0 is nothing, 1 what was taught
    #[arg(long, default_value = "1", value_parser = amount, allow_negative_numbers = true)]
    pub amount: f64,
    /// Whether feet that stand keep standing [default: as it was taught]
    #[arg(long, value_parser = word::<Contacts>())]
    pub contacts: Option<Contacts>,
    /// Only these joints or body parts
    #[arg(long, value_name = "PART,…", value_delimiter = ',')]
    pub parts: Vec<String>,
    /// Only this time, s
    #[arg(long, value_name = "FROM,TO", value_parser = span, allow_negative_numbers = true)]
    pub span: Option<(f64, f64)>,
    /// Put the result on this body of other proportions: a clip of it, or a character file with the same joints
    #[arg(long, value_name = "CLIP|BODY.ron")]
    pub onto: Option<PathBuf>,
}

/// What to apply to what.
#[derive(Debug, Args)]
pub struct ApplyArgs {
    /// Folder of the project, or a file .edit
    #[arg(value_name = "PROJECT|MODEL.edit")]
    pub model: PathBuf,
    /// The clip
    #[arg(value_name = "CLIP")]
    pub clip: PathBuf,
    /// File to write: .bvh or .glb
    #[arg(value_name = "OUT")]
    pub output: PathBuf,
    /// Where the edit applies.
    #[command(flatten)]
    pub place: PlaceArgs,
    /// Replace OUT if it exists
    #[arg(long)]
    pub force: bool,
    /// Print what was done as JSON
    #[arg(long)]
    pub json: bool,
}

/// What to export.
#[derive(Debug, Args)]
pub struct ExportArgs {
    /// Folder of the project, or a file .edit
    #[arg(value_name = "PROJECT|MODEL.edit")]
    pub model: PathBuf,
    /// The clip
    #[arg(value_name = "CLIP")]
    pub clip: PathBuf,
    /// File to write: .bvh or .glb
    #[arg(value_name = "OUT")]
    pub output: PathBuf,
    /// Replace OUT if it exists
    #[arg(long)]
    pub force: bool,
}

/// What was corrected.
#[derive(Debug, Args)]
pub struct CorrectArgs {
    /// Folder of the project
    #[arg(value_name = "PROJECT")]
    pub project: PathBuf,
    /// The clip that was exported
    #[arg(value_name = "CLIP")]
    pub clip: PathBuf,
    /// What was exported, with frames changed
    #[arg(long, value_name = "EDITED")]
    pub from: PathBuf,
    /// Name of the pair [default: that of the edited file]
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
    /// Fades the correction into the frames around it over this time, s
    #[arg(long, value_name = "S", default_value = "0.1", value_parser = blend, allow_negative_numbers = true)]
    pub blend: f64,
    /// Keeps this correction apart from pairs of other contexts
    #[arg(long, value_name = "LABEL")]
    pub context: Option<String>,
    /// Add the pair, but leave the model as it is
    #[arg(long)]
    pub no_train: bool,
    /// Print the changes found as JSON
    #[arg(long)]
    pub json: bool,
}

/// What to ask.
#[derive(Debug, Args)]
pub struct StatusArgs {
    /// Folder of the project
    #[arg(value_name = "PROJECT")]
    pub project: PathBuf,
    /// Clips whose frames to key next are wanted
    #[arg(value_name = "CLIP")]
    pub clips: Vec<PathBuf>,
    /// How many frames to name for each clip
    #[arg(long, value_name = "N", default_value = "5")]
    pub next: usize,
    /// Examples contradict each other from this difference on, degrees
    #[arg(long, value_name = "DEG", default_value = "10", value_parser = angle, allow_negative_numbers = true)]
    pub contradiction: f64,
    /// Print it as JSON
    #[arg(long)]
    pub json: bool,
}

fn span(text: &str) -> Result<(f64, f64), String> {
    let fault = || "allowed: two times in seconds, such as 0.5,2".to_owned();
    let (from, to) = text.split_once(',').ok_or_else(fault)?;
    let time = |t: &str| t.trim().parse::<f64>().ok().filter(|t| t.is_finite()).ok_or_else(fault);
    let (from, to) = (time(from)?, time(to)?);
    if from < to { Ok((from, to)) } else { Err("allowed: the first time before the second".into()) }
}

fn amount(text: &str) -> Result<f64, String> {
    number(text, 0.0, 1.5, "")
}

fn blend(text: &str) -> Result<f64, String> {
    number(text, 0.0, 5.0, " s")
}

fn angle(text: &str) -> Result<f64, String> {
    number(text, 0.1, 180.0, "°")
}
