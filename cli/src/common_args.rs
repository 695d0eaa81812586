//! Words of the command line that several commands have, and numbers in ranges.

use clap::Args;
use formats::bvh::{Axis, ImportOptions, OffsetRule, TPoseRule};
use motion::names::Word;
use plots::ViewName;

use takes::{ENGINE, SEARCH_ENGINE};

use crate::engines;
use crate::words::word;

/// What is known about a BVH file; what is not said is guessed and printed.
#[derive(Clone, Debug, Default, Args)]
pub struct ClipArgs {
    /// Metres in one unit of the BVH file (0.01 for centimetres); guessed if not given
    #[arg(long, value_name = "METRES_PER_UNIT", value_parser = length, allow_negative_numbers = true)]
    pub units: Option<f64>,
    /// Vertical axis of the BVH file; guessed if not given
    #[arg(long, value_parser = word::<Axis>())]
    pub up: Option<Axis>,
    /// Frames per second of the BVH file; read from its frame time if not given
    #[arg(long, value_name = "HZ", value_parser = frame_rate, allow_negative_numbers = true)]
    pub fps: Option<f64>,
    /// Leave out the first frame, an inserted T-pose; done unasked only where the jump after it is impossible
    #[arg(long)]
    pub drop_t_pose: bool,
    /// Keep the first frame, even if the jump after it is impossible
    #[arg(long, conflicts_with = "drop_t_pose")]
    pub keep_t_pose: bool,
    /// Interpolate the frames in which a joint jumps as no muscle could make it
    #[arg(long)]
    pub repair: bool,
    /// What becomes of joint offsets that move; if not given, small movements are held and larger ones kept
    #[arg(long, value_parser = word::<OffsetRule>())]
    pub offsets: Option<OffsetRule>,
}

impl ClipArgs {
    /// The same as the importer takes it.
    pub fn import(&self) -> ImportOptions {
        let t_pose = match (self.drop_t_pose, self.keep_t_pose) {
            (true, _) => Some(TPoseRule::Drop),
            (_, true) => Some(TPoseRule::Keep),
            _ => None,
        };
        ImportOptions {
            metres_per_unit: self.units,
            up: self.up,
            rate_hz: self.fps,
            t_pose,
            repair: self.repair,
            offsets: self.offsets,
        }
    }

    /// The first of these options that was given.
    pub fn given(&self) -> Option<&'static str> {
        let given = [
            ("--units", self.units.is_some()),
            ("--up", self.up.is_some()),
            ("--fps", self.fps.is_some()),
            ("--drop-t-pose", self.drop_t_pose),
            ("--keep-t-pose", self.keep_t_pose),
            ("--repair", self.repair),
            ("--offsets", self.offsets.is_some()),
        ];
        given.into_iter().find(|(_, is)| *is).map(|(name, _)| name)
    }
}

/// What `--view` takes.
pub fn view_help() -> String {
    let names: Vec<&str> = ViewName::WORDS.iter().map(|w| w.1).collect();
    let names = names.join(", ");
    format!(
        "From where film strips are seen: {names}, or degrees, 0 the front and 90 the left [default: the scene's, {}]",
        ViewName::default().word()
    )
}

/// What `--engine` takes.
pub fn engine_help() -> String {
    format!("Engine that simulates: {} [default: the scene's, {ENGINE}]", engines::help())
}

/// What `--engine` of a command that searches takes.
pub fn searcher_help() -> String {
    format!("Engine that searches: {} [default: the scene's, {SEARCH_ENGINE}]", engines::help())
}

/// A number in a range.
pub fn number(text: &str, lo: f64, hi: f64, unit: &str) -> Result<f64, String> {
    let x: f64 = text.parse().map_err(|_| format!("not a number; allowed: {lo} to {hi}{unit}"))?;
    if (lo..=hi).contains(&x) { Ok(x) } else { Err(format!("allowed: {lo} to {hi}{unit}")) }
}

/// A length, m.
pub fn length(text: &str) -> Result<f64, String> {
    number(text, 1e-6, 1e3, " m")
}

/// Frames per second.
pub fn frame_rate(text: &str) -> Result<f64, String> {
    number(text, 1.0, 1e3, " Hz")
}

/// A whole number in a range.
pub fn whole(text: &str, lo: usize, hi: usize) -> Result<usize, String> {
    let n = text.parse().ok().filter(|n| (lo..=hi).contains(n));
    n.ok_or_else(|| format!("allowed: a whole number from {lo} to {hi}"))
}
