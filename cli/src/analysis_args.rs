//! The command lines of `plot` and `analyze`.

use std::path::PathBuf;

use clap::Args;
use motion::names::Word;
use motion::smooth::Smoothing;
use plots::View;
use takes::AnalysisSettings;
use takes::results::analysis_figures::AnalysisFigure;
use takes::results::analysis_write::Table;

use crate::common_args::{ClipArgs, number, view_help};
use crate::words::word;

/// A figure of `plot`, or all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pick {
    /// This one.
    One(AnalysisFigure),
    /// All that there are.
    All,
}

fn pick(text: &str) -> Result<Pick, String> {
    if text.eq_ignore_ascii_case("all") {
        return Ok(Pick::All);
    }
    AnalysisFigure::find(text).map(Pick::One).map_err(|e| e.to_string())
}

/// What `--what` takes.
fn figures_help() -> String {
    let each = AnalysisFigure::WORDS.iter().map(|w| format!("\n{:<9} {}", w.1, w.2));
    format!(
        "What to draw; several, separated by commas [default: all]{}\nall       All of them that there are",
        each.collect::<String>()
    )
}

/// Options of inverse dynamics.
#[derive(Clone, Debug, Default, Args)]
pub struct DynamicsArgs {
    /// Character file for a clip, instead of a guessed body
    #[arg(long, value_name = "FILE.ron")]
    pub body: Option<PathBuf>,
    /// Coefficient of friction of the ground [default: the scene's, 0.8 else]
    #[arg(long, value_name = "MU", value_parser = friction, allow_negative_numbers = true)]
    pub friction: Option<f64>,
    /// Smooth the motion before it is differentiated: a cut-off in Hz, auto, or off
    /// [default: auto for clips and runs with a pinned root, else off]
    #[arg(long, value_name = "HZ|auto|off", value_parser = smoothing, allow_negative_numbers = true)]
    pub smooth: Option<Smoothing>,
    /// Depth at which a body would stand in the penalty model's ground, mm
    #[arg(long, value_name = "MM", value_parser = sink, default_value = "1.5", allow_negative_numbers = true)]
    pub sink_mm: f64,
}

impl DynamicsArgs {
    /// The same as an analysis takes it.
    pub fn options(&self) -> AnalysisSettings {
        AnalysisSettings { smoothing: self.smooth, friction: self.friction }
    }
}

/// Arguments of `plot`.
#[derive(Debug, Args)]
#[command(after_help = PLOT_EXAMPLES)]
pub struct PlotArgs {
    /// trace.npz, the folder of a run, a clip (.bvh) or a scene (.ron, or a name of the library)
    #[arg(value_name = "TRACE|CLIP")]
    pub input: PathBuf,
    /// What to draw.
    #[arg(long, value_name = "FIGURE", value_parser = pick, value_delimiter = ',', default_value = "all", help = figures_help(), hide_default_value = true)]
    pub what: Vec<Pick>,
    /// A file (.svg or .png) for one figure, or a folder [default: plots/ beside the trace,
    /// out/NAME/plots for a clip]
    #[arg(long, value_name = "F.svg|F.png|DIR")]
    pub out: Option<PathBuf>,
    /// First moment drawn, s
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub from_s: Option<f64>,
    /// Last moment drawn, s
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub to_s: Option<f64>,
    /// Only these feet in `contact`, by leg or link
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub feet: Vec<String>,
    /// Only these joints in `torque`, `gains` and `angles`, by link
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub joints: Vec<String>,
    /// From where film strips are seen.
    #[arg(long, value_name = "VIEW", allow_negative_numbers = true, help = view_help())]
    pub view: Option<View>,
    /// Replace a file of --out if it exists
    #[arg(long)]
    pub force: bool,
    /// MuJoCo's trace of the same run [default: mujoco/trace.npz beside the trace, where there is one]
    #[arg(long, value_name = "TRACE.npz")]
    pub mujoco: Option<PathBuf>,
    /// Print the numbers on the figures as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
    /// Inverse dynamics.
    #[command(flatten)]
    pub dynamics: DynamicsArgs,
    /// How to read a clip.
    #[command(flatten)]
    pub clip: ClipArgs,
}

const PLOT_EXAMPLES: &str = "\
Examples:
  contrapposto plot out/bow                                all figures, into out/bow/plots/
  contrapposto plot out/bow --what contact,residual
  contrapposto plot out/bow/trace.npz --what torque --joints knee_l,knee_r --out knees.svg
  contrapposto plot out/bow --what contact --mujoco mujoco.npz --from-s 1 --to-s 3
  contrapposto plot walk.bvh --what contact,com --smooth 6

Required forces come from inverse dynamics of the motion; those given from penalty contact at the soles;
those measured from the trace. See docs/ANALYSIS.md.";

/// Arguments of `analyze`.
#[derive(Debug, Args)]
#[command(after_help = ANALYZE_EXAMPLES)]
pub struct AnalyzeArgs {
    /// Clip (.bvh), scene (.ron, or a name of the library), trace.npz or the folder of a run
    #[arg(value_name = "CLIP")]
    pub input: PathBuf,
    /// Folder to write into; an earlier analysis there is replaced when all is complete
    /// [default: out/NAME-analysis]
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Files to write, separated by commas
    #[arg(long, value_name = "FORMAT", value_parser = word::<Table>(), value_delimiter = ',', default_value = "csv,mot,npz")]
    pub format: Vec<Table>,
    /// From where the film strip is seen.
    #[arg(long, value_name = "VIEW", allow_negative_numbers = true, conflicts_with = "no_plots", help = view_help())]
    pub view: Option<View>,
    /// Draw nothing
    #[arg(long)]
    pub no_plots: bool,
    /// Print the report as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
    /// Inverse dynamics.
    #[command(flatten)]
    pub dynamics: DynamicsArgs,
    /// How to read a clip.
    #[command(flatten)]
    pub clip: ClipArgs,
}

const ANALYZE_EXAMPLES: &str = "\
Examples:
  contrapposto analyze walk.bvh
  contrapposto analyze walk.bvh --body body.ron --smooth 6 --friction 0.6
  contrapposto analyze out/bow --out check/bow --format csv --no-plots
  contrapposto analyze walk.bvh --json | jq .residual

Files written into DIR:
  analysis.csv        everything per frame: forces, torques, centre of pressure, angles (degrees)
  torques.mot         joint forces, ground_forces.mot: ground reactions, for OpenSim
  analysis.npz        the same for numpy (SI, radians)
  report.json         the numbers, see docs/ANALYSIS.md
  plots/              figures, each as .svg and .png

Same input, same bytes.";

fn friction(text: &str) -> Result<f64, String> {
    number(text, 0.0, 10.0, "")
}

fn sink(text: &str) -> Result<f64, String> {
    number(text, 0.01, 100.0, " mm")
}

fn smoothing(text: &str) -> Result<Smoothing, String> {
    match text {
        "auto" => Ok(Smoothing::Auto),
        "off" => Ok(Smoothing::Off),
        _ => match text.parse() {
            Ok(hz) if (0.1..=1000.0).contains(&hz) => Ok(Smoothing::CutoffHz(hz)),
            _ => Err("allowed: auto, off, or 0.1 to 1000 Hz".into()),
        },
    }
}
