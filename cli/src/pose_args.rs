//! The command line of `pose`.

use std::path::PathBuf;

use clap::{ArgGroup, Args};
use plots::View;
use takes::posing::BLEND_S;

use crate::common_args::{ClipArgs, view_help};

/// Arguments of `pose`.
#[derive(Debug, Args)]
#[command(after_help = POSE_EXAMPLES, group = ArgGroup::new("moment").required(true).args(["frame", "at"]))]
pub struct PoseArgs {
    /// Clip (.bvh), or scene (.ron, or a name of the library) whose motion is posed
    #[arg(value_name = "CLIP.bvh|SCENE.ron")]
    pub input: PathBuf,
    /// The pose, as a frame counted from 0
    #[arg(long, value_name = "N")]
    pub frame: Option<usize>,
    /// The pose, as a time in seconds
    #[arg(long, visible_alias = "at-s", value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    pub at: Option<f64>,
    /// Drag a joint (or a site) to a place: metres in the world, Y up. May be given several times
    #[arg(long, value_name = "JOINT=X,Y,Z", value_parser = drag)]
    pub drag: Vec<(String, [f64; 3])>,
    /// Keep joints (or sites) exactly where they are. May be given several times
    #[arg(long, value_name = "JOINT,...", value_delimiter = ',')]
    pub pin: Vec<String>,
    /// How firmly a joint goes where it is dragged, or stays where it was; 1 if not given, 0 follows freely
    #[arg(long, value_name = "JOINT=W", value_parser = weight)]
    pub weight: Vec<(String, f64)>,
    /// Joints that move as one rigid piece. May be given several times
    #[arg(long, value_name = "JOINT,JOINT,...", value_parser = group)]
    pub group: Vec<Group>,
    /// Keep the limits of the joints; a joint that is beyond them goes no further
    #[arg(long)]
    pub limits: bool,
    /// How long the change is blended in before the pose and out after it, seconds
    #[arg(long, value_name = "S", value_parser = seconds, default_value_t = BLEND_S, allow_negative_numbers = true)]
    pub blend_s: f64,
    /// Keep the change whole over this part of the clip, in seconds; blended before and after it
    #[arg(long, visible_alias = "block-s", value_name = "FROM,TO", value_parser = block, allow_negative_numbers = true)]
    pub block: Option<(f64, f64)>,
    /// Drag the pose in time: what was at the moment comes at this one, seconds
    #[arg(long, visible_alias = "to", value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    pub to_s: Option<f64>,
    /// Clip to write (.bvh, .glb), or folder for clip, report and film strip [default: out/NAME-pose]
    #[arg(short, long, value_name = "FILE|DIR")]
    pub out: Option<PathBuf>,
    /// Replace the clip to write if it exists
    #[arg(long)]
    pub force: bool,
    /// From where the film strip is seen.
    #[arg(long, value_name = "VIEW", allow_negative_numbers = true, conflicts_with = "no_plots", help = view_help())]
    pub view: Option<View>,
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

/// Joints that move as one piece.
#[derive(Clone, Debug)]
pub struct Group(pub Vec<String>);

const POSE_EXAMPLES: &str = "\
Examples:
  contrapposto pose walk.bvh --frame 40 --drag RightHand=-0.4,1.6,0.3 --pin LeftFoot,RightFoot
  contrapposto pose walk.bvh --at 1.2 --drag Head=0.1,1.3,0.5 --weight Hips=20 --blend-s 0.5 -o lean.bvh
  contrapposto pose walk.bvh --frame 40 --drag RightHand=-0.4,1.6,0.3 --group RightArm,RightForeArm,RightHand
  contrapposto pose greet --at 1 --drag wrist_r=-0.5,1.5,0.3 --limits --block 0.8,1.4
  contrapposto pose walk.bvh --at 1.2 --to-s 1.3 --blend-s 0.4
  contrapposto inspect walk.bvh               the names of the joints

X, Y, Z are metres in the world, Y up, whatever the unit and up axis of the file; a report has where each joint was. A joint's place is
where it hangs on its parent.

Bones keep their lengths and pins their places exactly; what cannot be reached is approached, and the report says what is left. Joints that
are neither dragged nor pinned stay as near to where they were as they can, what hangs on a dragged joint goes with it, and twist is kept.
Files written into DIR:
  pose.bvh          the clip
  report.json       what moved by how much, what is left
  plots/strip_pose  before and after, as .svg and .png

docs/POSE.md has the definitions. Scenes have the same words: edits: [PoseDelta(at_s: 1.2, drag: {...}, ...)], TimeDelta.";

fn finite(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().map_err(|_| format!("`{text}` is not a number"))?;
    if number.is_finite() { Ok(number) } else { Err(format!("`{text}` is not finite")) }
}

fn seconds(text: &str) -> Result<f64, String> {
    let s = finite(text)?;
    if s >= 0.0 { Ok(s) } else { Err(format!("{s} s is below 0")) }
}

fn named(text: &str) -> Result<(String, &str), String> {
    let (name, rest) =
        text.rsplit_once('=').ok_or("a joint, =, and numbers, such as wrist_r=-0.4,1.6,0.3")?;
    if name.is_empty() { Err("no joint before the =".into()) } else { Ok((name.to_owned(), rest)) }
}

fn drag(text: &str) -> Result<(String, [f64; 3]), String> {
    let (name, place) = named(text)?;
    let numbers = place.split(',').map(finite).collect::<Result<Vec<_>, _>>()?;
    let count = numbers.len();
    let place =
        numbers.try_into().map_err(|_| format!("{count} numbers; a place is X,Y,Z in metres, Y up"))?;
    Ok((name, place))
}

fn weight(text: &str) -> Result<(String, f64), String> {
    let (name, weight) = named(text)?;
    let weight = finite(weight)?;
    if weight >= 0.0 { Ok((name, weight)) } else { Err(format!("{weight} is below 0")) }
}

fn group(text: &str) -> Result<Group, String> {
    let names: Vec<String> = text.split(',').map(|name| name.trim().to_owned()).collect();
    if names.iter().any(String::is_empty) { Err("a name is empty".into()) } else { Ok(Group(names)) }
}

fn block(text: &str) -> Result<(f64, f64), String> {
    let (from, to) = text.split_once(',').ok_or("two times in seconds, such as 0.8,1.4")?;
    let (from, to) = (seconds(from)?, seconds(to)?);
    if from <= to { Ok((from, to)) } else { Err(format!("{from} s is after {to} s")) }
}
