//! The command line of `retarget`.

use std::path::PathBuf;

use clap::Args;
use motion::names::Word;
use takes::retarget::{MappingModel, PipelineStage, RefineDofs, SizeRatio, SizeRatioName};

use crate::common_args::{ClipArgs, frame_rate, whole};
use crate::words::word;

/// Arguments of `retarget`.
#[derive(Debug, Args)]
#[command(after_help = RETARGET_EXAMPLES)]
pub struct RetargetArgs {
    /// Human motion: a scene of a human figure (.ron, or a name of the library) or a motion-capture clip (.bvh)
    #[arg(value_name = "PERFORMANCE.ron|CLIP.bvh")]
    pub input: PathBuf,
    /// Character file of the body that gets it, or a name of the library
    #[arg(long, value_name = "CHARACTER.ron")]
    pub to: PathBuf,
    /// Key poses to learn from, a file or a name of the library [default: keyposes/NAME.ron beside the folder of the character]
    #[arg(long, value_name = "FILE.ron")]
    pub keyposes: Option<PathBuf>,
    /// Character file for a clip's own body, instead of a guessed one
    #[arg(long, value_name = "FILE.ron")]
    pub body: Option<PathBuf>,
    /// Contact phases: the contacts.ron of an earlier run, edited [default: found by speed and height]
    #[arg(long, value_name = "FILE.ron")]
    pub contacts: Option<PathBuf>,
    /// How poses are mapped
    #[arg(long, value_parser = word::<MappingModel>(), default_value = MappingModel::default().word())]
    pub model: MappingModel,
    /// The last stage
    #[arg(long, value_parser = word::<PipelineStage>(), default_value = PipelineStage::default().word())]
    pub stop_after: PipelineStage,
    /// How distances of travel scale: `stride` (the paper's ratio, but no longer than legs can step), `paper`, `uniform`
    /// (the mean of depth and width), or a number
    #[arg(long, value_name = "RATIO", default_value = SizeRatioName::Stride.word(), allow_negative_numbers = true)]
    pub size_ratio: SizeRatio,
    /// What the refinement may move: `height` of the root, `root`, `legs` (root and legs), or links by name
    #[arg(long, value_name = "height|root|legs|LINK,…", default_value = "height")]
    pub refine: RefineDofs,
    /// Leave parts that can follow by dynamics, such as a tail, where the key poses have them
    #[arg(long)]
    pub no_sway: bool,
    /// Frames per second to work at and to write [default: the motion's]
    #[arg(long, value_name = "HZ", value_parser = frame_rate, allow_negative_numbers = true)]
    pub rate: Option<f64>,
    /// Name the N moments whose poses the model is least sure of
    #[arg(long, value_name = "N", value_parser = suggestions)]
    pub suggest_keyposes: Option<usize>,
    /// Run all five models and table their errors at the key poses
    #[arg(long)]
    pub compare: bool,
    /// Measure the key poses: do like poses agree, how many latent dimensions, this motion without its own key
    /// poses, suggested against random key poses
    #[arg(long)]
    pub study: bool,
    /// Print first guesses for key poses at these moments, s, as lines for a file of key poses, and do nothing else
    #[arg(long, value_name = "S", value_delimiter = ',', allow_negative_numbers = true)]
    pub guess: Vec<f64>,
    /// Draw all key poses beside the human poses they stand for, into DIR/plots, and do nothing else
    #[arg(long, conflicts_with = "guess")]
    pub sheet: bool,
    /// Folder to write into; earlier output there is replaced when all is complete
    /// [default: out/PERFORMANCE-CHARACTER]
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Draw nothing
    #[arg(long)]
    pub no_plots: bool,
    /// Print the report as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
    /// How to read a clip.
    #[command(flatten)]
    pub clip: ClipArgs,
}

const RETARGET_EXAMPLES: &str = "\
Examples:
  contrapposto retarget scenes/performances/anger.ron --to scenes/characters/lamp.ron
  contrapposto retarget walk.bvh --to penguin --rate 30
  contrapposto retarget scenes/performances/fear.ron --to scenes/characters/squirrel.ron --model nn3 --stop-after map
  contrapposto retarget scenes/performances/dance.ron --to scenes/characters/penguin.ron --refine legs
  contrapposto retarget walk.bvh --to scenes/characters/squirrel.ron --size-ratio 0.2 --refine chest,spine --no-sway
  contrapposto retarget walk.bvh --to scenes/characters/penguin.ron --contacts out/walk-penguin/contacts.ron
  contrapposto retarget walk.bvh --to scenes/characters/lamp.ron --suggest-keyposes 5
  contrapposto retarget scenes/performances/fear.ron --to scenes/characters/lamp.ron --guess 1.5,7
  contrapposto retarget scenes/performances/happiness.ron --to scenes/characters/lamp.ron --stop-after map --compare --study

Files written into DIR:
  retargeted.bvh      the motion on the character
  retargeted.glb      the same with its body, for any 3-D tool
  human.bvh           the human motion as it was used
  contacts.ron        when each contact point stands, to edit and give to --contacts
  report.json         the numbers, see docs/RETARGET.md
  plots/              film strip of all stages, confidence, latent path, momentum, forces

Give the result a dynamic pass with
  contrapposto render DIR/retargeted.bvh --body CHARACTER.ron --units 0.01 --up y

Same input, same bytes.";

fn suggestions(text: &str) -> Result<usize, String> {
    whole(text, 1, 100)
}
