//! The command line of `style`.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use motion::names::Word;
use takes::styles::library;
use takes::styles::style::{Representation, Timing};

use crate::words::word;

/// Arguments of `style`.
#[derive(Debug, Args)]
#[command(arg_required_else_help = true)]
pub struct StyleArgs {
    /// What to do.
    #[command(subcommand)]
    pub command: StyleCommand,
}

/// What to do with style.
#[derive(Debug, Subcommand)]
pub enum StyleCommand {
    /// Take two motions apart: a .style file, every component as a motion and in words
    Decompose(DecomposeArgs),
    /// Put the style of one motion into another
    Transfer(TransferArgs),
    /// The continuum from one motion to the style of another: a clip and a row of a film strip for each amount
    Blend(BlendArgs),
    /// One film strip of a motion with every style of a list on it
    Try(TryArgs),
}

/// How two motions are taken apart.
#[derive(Debug, Args)]
pub struct FindArgs {
    /// Number of components [default: as many as explain the variance]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u8).range(1..=40))]
    pub count: Option<u8>,
    /// Share of the variance that components explain, percent
    #[arg(long, value_name = "PERCENT", default_value_t = 95.0, value_parser = percent)]
    pub variance: f64,
    /// What is taken apart
    #[arg(long, value_parser = word::<Representation>(), default_value = Representation::default().word())]
    pub representation: Representation,
    /// Merge these components into one, numbers from 1
    #[arg(long, value_name = "1,3", value_delimiter = ',')]
    pub merge: Vec<usize>,
    /// A bone of the first motion and what the second calls it; repeat for more
    #[arg(long = "name", value_name = "FIRST=SECOND", value_parser = pair)]
    pub names: Vec<(String, String)>,
}

/// Arguments of `style decompose`.
#[derive(Debug, Args)]
pub struct DecomposeArgs {
    /// The first motion: a clip, a scene, or a name of the library; bones are its own
    pub a: PathBuf,
    /// The second motion
    pub b: PathBuf,
    /// How.
    #[command(flatten)]
    pub find: FindArgs,
    /// Folder of results [default: out/A-B-style]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// How a style is put into a motion.
#[derive(Debug, Args)]
pub struct PutArgs {
    /// Components that are transferred, numbers from 1 [default: those that tell the motions apart]
    #[arg(long, value_name = "1,3", value_delimiter = ',')]
    pub components: Vec<usize>,
    /// The bone whose swing is aligned [default: the one that repeats itself best]
    #[arg(long, value_name = "BONE")]
    pub align: Option<String>,
    /// Times that belong together, of the motion that is changed and of the donor, s; at least two; for gestures
    #[arg(long = "anchor", value_name = "TO_S=FROM_S", value_parser = times, conflicts_with = "align")]
    pub anchors: Vec<(f64, f64)>,
    /// Whose timing the result has
    #[arg(long, value_parser = word::<Timing>(), default_value = Timing::default().word())]
    pub timing: Timing,
}

/// Arguments of `style transfer`.
#[derive(Debug, Args)]
pub struct TransferArgs {
    /// The motion whose style it is, or a .style file
    #[arg(long, value_name = "MOTION|FILE.style")]
    pub from: PathBuf,
    /// The motion that gets it
    #[arg(long, value_name = "MOTION")]
    pub to: PathBuf,
    /// How much of it, 0 to 1.5
    #[arg(long, default_value_t = 1.0, value_parser = amount)]
    pub amount: f64,
    /// How it is put there.
    #[command(flatten)]
    pub put: PutArgs,
    /// How the components are found.
    #[command(flatten)]
    pub find: FindArgs,
    /// Folder of results [default: out/TO-like-FROM]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Leave out the figures
    #[arg(long)]
    pub no_plots: bool,
}

/// Arguments of `style blend`.
#[derive(Debug, Args)]
pub struct BlendArgs {
    /// The motion whose style it is, or a .style file
    #[arg(long, value_name = "MOTION|FILE.style")]
    pub from: PathBuf,
    /// The motion that gets it
    #[arg(long, value_name = "MOTION")]
    pub to: PathBuf,
    /// The amounts, 0 to 1.5 each
    #[arg(long, value_delimiter = ',', default_values_t = [0.0, 0.25, 0.5, 0.75, 1.0], value_parser = amount)]
    pub amounts: Vec<f64>,
    /// How it is put there.
    #[command(flatten)]
    pub put: PutArgs,
    /// How the components are found.
    #[command(flatten)]
    pub find: FindArgs,
    /// Folder of results [default: out/TO-to-FROM]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Arguments of `style try`.
#[derive(Debug, Args)]
pub struct TryArgs {
    /// The motion
    pub input: PathBuf,
    /// The styles: files, or names of those that ship (tired, proud, sneaky, limping, childish) [default: all that ship]
    #[arg(value_name = "STYLE")]
    pub styles: Vec<PathBuf>,
    /// How much of them, 0 to 1.5
    #[arg(long, default_value_t = 1.0, value_parser = amount)]
    pub amount: f64,
    /// How they are put there.
    #[command(flatten)]
    pub put: PutArgs,
    /// Folder of results [default: out/INPUT-styles]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Whether this is the name of a style that ships.
pub fn ships(from: &Path) -> bool {
    !from.exists() && from.to_str().is_some_and(|name| library::shipped(name).is_some())
}

impl StyleArgs {
    /// Files that may be names of the library; a style that ships is none.
    pub fn inputs(&mut self) -> Vec<&mut PathBuf> {
        let all = match &mut self.command {
            StyleCommand::Decompose(args) => vec![&mut args.a, &mut args.b],
            StyleCommand::Transfer(args) => vec![&mut args.from, &mut args.to],
            StyleCommand::Blend(args) => vec![&mut args.from, &mut args.to],
            StyleCommand::Try(args) => vec![&mut args.input],
        };
        all.into_iter().filter(|file| !ships(file)).collect()
    }
}

fn within(text: &str, lo: f64, hi: f64, what: &str) -> Result<f64, String> {
    let x: f64 = text.parse().map_err(|_| format!("allowed: {what}"))?;
    if x >= lo && x <= hi { Ok(x) } else { Err(format!("allowed: {what}")) }
}

fn amount(text: &str) -> Result<f64, String> {
    within(text, 0.0, 1.5, "0 to 1.5")
}

fn percent(text: &str) -> Result<f64, String> {
    within(text, 1.0, 100.0, "1 to 100")
}

fn pair(text: &str) -> Result<(String, String), String> {
    let (a, b) = text.split_once('=').ok_or("allowed: FIRST=SECOND")?;
    Ok((a.into(), b.into()))
}

fn times(text: &str) -> Result<(f64, f64), String> {
    let number = |x: &str| within(x, 0.0, 1e5, "two times in s, as 0.5=0.7");
    let (a, b) = text.split_once('=').ok_or("allowed: two times in s, as 0.5=0.7")?;
    Ok((number(a)?, number(b)?))
}
