//! The command line: words, ranges, help.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use plots::View;
use studies::push::PushSettings;
use takes::foresight::Choice;
use takes::overrides::RootChoice;
use takes::{Ask, LookAhead, Overrides, SceneError};

use crate::common_args::{ClipArgs, engine_help, frame_rate, length, number, view_help, whole};
use crate::physics_args::{directions, tolerance};

/// Motion performed by a body with mass, muscles and contacts.
#[derive(Debug, Parser)]
#[command(name = "contrapposto", version, after_help = EXAMPLES, arg_required_else_help = true)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "\
Examples:
  contrapposto render scenes/bow.ron          write out/bow/: clips, trace, report, plots
  contrapposto render walk.bvh --root pinned  a body is made for the clip's skeleton
  contrapposto inspect scenes/bow.ron         what is in a scene, and what its edits did
  contrapposto analyze walk.bvh               is this motion physically plausible, and where not
  contrapposto plot out/bow --what contact    ground forces required, given, measured
  contrapposto crosscheck scenes/bow.ron      every force, ours and MuJoCo's
  contrapposto push scenes/stand.ron          how hard it can be pushed without falling
  contrapposto tune scenes/stand.ron          choose tension and balance by a search
  contrapposto retarget scenes/performances/anger.ron --to scenes/characters/lamp.ron
                                              the same anger, from a lamp
  contrapposto propagate new lean --source walk.bvh --target leaning.bvh
                                              learn an edit from examples
  contrapposto pose walk.bvh --frame 40 --drag RightHand=-0.4,1.6,0.3
                                              another pose there, blended in
  contrapposto style transfer --from sneak.bvh --to walk.bvh
                                              the walk, sneaking
  contrapposto convert walk.bvh walk.glb      change the format only
  contrapposto library                        scenes and characters that are inside the program
  contrapposto new first                      a folder with a scene to start from

A name of the library stands for its file, in any folder: contrapposto render bow.
A file of that name is meant before it.

Exit codes: 0 done (also when the body fell), 1 the run failed, 2 something is wrong with the input.";

pub use crate::analysis_args::{AnalyzeArgs, Pick, PlotArgs};
pub use crate::physics_args::{PhysicsArgs, patch};
pub use crate::pose_args::PoseArgs;
pub use crate::propagate_args::PropagateArgs;
pub use crate::push_args::PushArgs;
pub use crate::retarget_args::RetargetArgs;
pub use crate::style_args::StyleArgs;
pub use crate::tune_args::TuneArgs;

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Perform a scene or a clip and write clips, trace, report and plots
    Render(Box<RenderArgs>),
    /// Say what is in a scene, a character or a clip
    Inspect(InspectArgs),
    /// Draw figures of a trace or a clip
    Plot(PlotArgs),
    /// Say what forces a clip needs, and whether it is physically plausible
    Analyze(AnalyzeArgs),
    /// Compare every number about force with MuJoCo
    Crosscheck(CrosscheckArgs),
    /// Say how hard a standing body can be pushed, in every direction
    Push(PushArgs),
    /// Choose tension and balance parameters by a search over a cost the scene declares
    Tune(TuneArgs),
    /// Put a human motion on a character of any shape
    Retarget(RetargetArgs),
    /// Learn an edit from a few edited seconds and apply it to other motion
    Propagate(PropagateArgs),
    /// Correct a pose of a clip by dragging its joints, and the frames around it with it
    Pose(PoseArgs),
    /// Take two motions apart into style components, and put them into others
    Style(StyleArgs),
    /// Write a clip, the kinematic motion of a scene, or a body in another format
    Convert(ConvertArgs),
    /// List the scenes, characters and key poses inside the program, or print one
    Library(LibraryArgs),
    /// Write a starter project: a scene, its character, how to go on
    New(NewArgs),
}

/// Arguments of `render`.
#[derive(Debug, Args)]
#[command(after_help = RENDER_EXAMPLES)]
pub struct RenderArgs {
    /// Scene (.ron, or a name of the library) or motion-capture clip (.bvh)
    #[arg(value_name = "SCENE.ron|CLIP.bvh")]
    pub input: PathBuf,
    /// Folder to write into; earlier output there is replaced when all is complete [default: out/NAME]
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// What holds the root: free, pinned, assisted (10 % of body weight, 50 N·m) or
    /// assisted:FORCE_N,MOMENT_NM [default: the scene's; pinned for a clip]
    #[arg(long, value_name = "ROOT")]
    pub root: Option<RootChoice>,
    /// Assist the root by this much, from 0 (free) to 1: a budget of X² of the body weight, and of the moment of that
    /// force at the root's height; more follows closer with more help from outside, see docs/ROOT.md
    #[arg(long, value_name = "X", value_parser = fidelity, allow_negative_numbers = true, conflicts_with = "root")]
    pub fidelity: Option<f64>,
    /// Perform it at several fidelities (separated by commas) and draw tracking error against root wrench
    #[arg(
        long,
        value_name = "X,X,...",
        value_parser = fidelity,
        value_delimiter = ',',
        num_args = 0..=1,
        conflicts_with_all = ["root", "fidelity", "kinematic"]
    )]
    pub pareto: Option<Vec<f64>>,
    /// Perform this part of a clip only, in seconds
    #[arg(long, value_name = "FROM..TO", value_parser = takes::overrides::span)]
    pub span: Option<(f64, f64)>,
    /// Have a clip go on for so long, s, by repeating the cycle of it (such as a stride) whose ends are most alike; see docs/WALKING.md
    #[arg(long = "loop", value_name = "SECONDS", value_parser = takes::overrides::loop_s, allow_negative_numbers = true)]
    pub loop_s: Option<f64>,
    /// Go on after a fall, muscles letting go, until the body rests; otherwise the run ends with the fall
    #[arg(long, conflicts_with_all = ["kinematic", "pareto"])]
    pub past_fall: bool,
    /// Look ahead, so that a body with a free root keeps its feet where they step: off, on, draft or SECONDS,ROLLOUTS; see
    /// docs/WALKING.md [default: on for scripts that step, off for clips and retargeted motion]
    #[arg(long, value_name = "FORESIGHT", conflicts_with_all = ["kinematic", "pareto", "fidelity"])]
    pub foresight: Option<Choice>,
    /// Perform the offsets that an earlier run with --foresight chose (its foresight.npz), without searching again
    #[arg(long, value_name = "FORESIGHT.npz", conflicts_with_all = ["foresight", "kinematic", "pareto", "fidelity"])]
    pub replay: Option<PathBuf>,
    /// Leave out the edits of the scene
    #[arg(long)]
    pub no_edits: bool,
    /// Edit a clip first, in the words of a scene: 'Succession(offset_s: 0.08)'; may be given several times
    #[arg(long, value_name = "EDIT", conflicts_with = "no_edits")]
    pub edit: Vec<String>,
    /// Push a body, as a scene has it: '(link: "chest", impulse_ns: 20, towards_deg: 90, start_s: 1.5)'; may be given several times
    #[arg(long = "push", value_name = "PUSH", conflicts_with = "kinematic")]
    pub pushes: Vec<String>,
    /// Write the motion asked for, without physics
    #[arg(long)]
    pub kinematic: bool,
    /// Muscles and simulation.
    #[command(flatten)]
    pub physics: PhysicsArgs,
    /// Engine that simulates.
    #[arg(long, value_name = "ENGINE", help = engine_help())]
    pub engine: Option<String>,
    /// From where film strips are seen.
    #[arg(long, value_name = "VIEW", allow_negative_numbers = true, conflicts_with_all = ["no_plots", "pareto"], help = view_help())]
    pub view: Option<View>,
    /// Draw nothing
    #[arg(long)]
    pub no_plots: bool,
    /// Print the report as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
    /// Character file for a clip, instead of a guessed body
    #[arg(long, value_name = "FILE.ron")]
    pub body: Option<PathBuf>,
    /// What stands when in a clip, and where: the contacts.ron of an earlier run, edited [default: found by height and speed]
    #[arg(long, value_name = "FILE.ron")]
    pub contacts: Option<PathBuf>,
    /// How to read a clip.
    #[command(flatten)]
    pub clip: ClipArgs,
}

const RENDER_EXAMPLES: &str = "\
Examples:
  contrapposto render scenes/bow.ron
  contrapposto render scenes/bow.ron --tension 0.5 --out out/slack
  contrapposto render scenes/bow.ron --root assisted:80,50
  contrapposto render scenes/bow.ron --kinematic
  contrapposto render scenes/bow.ron --fidelity 0.3
  contrapposto render scenes/bow.ron --pareto
  contrapposto render scenes/bow.ron --without ankle --past-fall
  contrapposto render walk.bvh --edit 'Succession(offset_s: 0.08)' --edit 'Tension(parts: [\"arm_r\"], factor: 0.5)'
  contrapposto render gestures.bvh --root free
  contrapposto render gestures.bvh --root free --span 2.5..7
  contrapposto render walk.bvh --root free --tension 2 --foresight on
  contrapposto render walk.bvh --root free --tension 2 --foresight on --loop 20
  contrapposto render walk.bvh --root free --tension 2 --foresight on --push '(link: \"Spine1\", impulse_ns: 20, towards_deg: 90, start_s: 1.5)'
  contrapposto render walk.bvh --root free --tension 2 --replay out/walk/foresight.npz --out out/again
  contrapposto render walk.bvh --units 0.01 --up y --tension 4
  contrapposto inspect walk.bvh --write-body body.ron && contrapposto render walk.bvh --body body.ron

Files written into DIR:
  kinematic.bvh   the motion asked for: edited, within joint limits, feet planted
  dynamic.bvh     the motion performed
  dynamic.glb     the same with a body of capsules, for any 3-D tool (kinematic.glb with --kinematic)
  trace.npz       every torque, gain and contact force, for numpy
  foresight.npz   with --foresight: the offsets that it chose, for --replay
  report.json     the numbers, see docs/REPORT.md
  plots/          figures, each as .svg and .png
  span_1/, ...    a clip that also steps, with a free root: these files of every standing span instead
With --pareto, into out/NAME-pareto: report.json and plots/pareto, see docs/ROOT.md.

With a free root a clip is performed where its feet stand; where they step it is not, and the summary says so. --foresight on
performs it whole on its own feet, --root pinned or assisted with help from outside.

BVH files are written in the unit of the BVH read, in centimetres for scenes; Y is up.
Same input, same bytes; only `realtime_factor` in report.json is of the clock.";

impl RenderArgs {
    /// Numbers of the dynamic pass that differ from the file's.
    ///
    /// # Errors
    /// A patch that makes no sense.
    pub fn overrides(&self) -> Result<Overrides, SceneError> {
        let root = self.fidelity.map(RootChoice::Fidelity).or(self.root);
        let past_fall = self.past_fall;
        Ok(Overrides { root, span_s: self.span, past_fall, ..self.physics.overrides()? })
    }

    /// What is asked beside the file.
    ///
    /// # Errors
    /// A patch that makes no sense.
    pub fn ask(&self) -> Result<Ask, SceneError> {
        Ok(Ask {
            overrides: self.overrides()?,
            engine: self.engine.clone(),
            body: self.body.clone(),
            import: self.clip.import(),
            loop_s: self.loop_s,
            edits: self.edit.clone(),
            pushes: self.pushes.clone(),
            contacts: self.contacts.clone(),
            no_edits: self.no_edits,
            foresight: self.foresight.map_or(LookAhead::Usual, LookAhead::from),
        })
    }

    /// Files that are read beside those that the input names.
    pub fn reads(&self) -> Vec<PathBuf> {
        let given = self.body.iter().chain(&self.physics.patch).chain(&self.contacts).chain(&self.replay);
        [&self.input].into_iter().chain(given).cloned().collect()
    }
}

/// Arguments of `inspect`.
#[derive(Debug, Args)]
#[command(after_help = INSPECT_EXAMPLES)]
pub struct InspectArgs {
    /// Scene or character (.ron, or a name of the library), clip (.bvh), or physics model (MJCF .xml, .urdf)
    #[arg(value_name = "FILE")]
    pub input: PathBuf,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
    /// Write the body guessed for a clip as a character file, to edit and give to `render --body`
    #[arg(long, value_name = "FILE.ron")]
    pub write_body: Option<PathBuf>,
    /// Replace the file of --write-body if it exists
    #[arg(long, requires = "write_body")]
    pub force: bool,
    /// How to read a clip.
    #[command(flatten)]
    pub clip: ClipArgs,
}

const INSPECT_EXAMPLES: &str = "\
Examples:
  contrapposto inspect scenes/bow.ron
  contrapposto inspect scenes/characters/human.ron
  contrapposto inspect walk.bvh --write-body body.ron
  contrapposto inspect humanoid.xml
  contrapposto inspect scenes/bow.ron --json";

/// Arguments of `crosscheck`.
#[derive(Debug, Args)]
#[command(after_help = CROSSCHECK_EXAMPLES)]
pub struct CrosscheckArgs {
    /// Scene or character (.ron, or a name of the library), clip (.bvh), or physics model (MJCF .xml, .urdf)
    #[arg(value_name = "SCENE|MODEL")]
    pub input: PathBuf,
    /// Folder to write into; earlier output there is replaced when all is complete
    /// [default: out/NAME-crosscheck]
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print the table as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
    /// Random states compared
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = states)]
    pub states: usize,
    /// Seed of the random states
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Patch of tension and balance, as `tune` writes it
    #[arg(long, value_name = "FILE.ron")]
    pub patch: Option<PathBuf>,
    /// What holds the root, as in render; a clip with --root free that steps is performed on its own feet in three engines
    #[arg(long, value_name = "ROOT")]
    pub root: Option<RootChoice>,
    /// Factor on every tension: 1 leaves them, 2 is twice as stiff
    #[arg(long, value_name = "X", value_parser = crate::physics_args::tension, allow_negative_numbers = true)]
    pub tension: Option<f64>,
    /// How a clip with --root free that steps looks ahead: off, on, draft or SECONDS,ROLLOUTS
    #[arg(long, value_name = "FORESIGHT", default_value = "on", requires = "root")]
    pub foresight: Choice,
    /// Random states only: neither motion nor contact
    #[arg(long)]
    pub states_only: bool,
    /// List what a model file has and rigid-body dynamics has not (tendons, sensors, actuators, damping) instead
    /// of refusing the file
    #[arg(long)]
    pub dynamics_only: bool,
    /// Give MuJoCo this file instead: a second version of the same body
    #[arg(long, value_name = "FILE")]
    pub against: Option<PathBuf>,
    /// Put a fault into our side, to see it found: mass:LINK*FACTOR, com:LINK+X,Y,Z (m), axis:LINK=X,Y,Z;
    /// may be given several times
    #[arg(long, value_name = "FAULT")]
    pub inject: Vec<crosscheck::Injection>,
    /// Compare the push-recovery maps of all engines too (a scene that stands; takes minutes)
    #[arg(long)]
    pub push_map: bool,
    /// Directions of the push maps, evenly spaced, from forward on
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = directions, requires = "push_map")]
    pub directions: usize,
    /// How closely the impulses of the push maps are searched, in percent of themselves
    #[arg(long, value_name = "PERCENT", default_value_t = 4.0, value_parser = tolerance, allow_negative_numbers = true, requires = "push_map")]
    pub tolerance: f64,
}

impl CrosscheckArgs {
    /// How push maps are made.
    pub fn settings(&self) -> PushSettings {
        PushSettings {
            directions: self.directions,
            tolerance: 0.01 * self.tolerance,
            ..PushSettings::default()
        }
    }
}

const CROSSCHECK_EXAMPLES: &str = "\
Examples:
  contrapposto crosscheck scenes/bow.ron
  contrapposto crosscheck scenes/stand.ron --push-map --directions 4 --tolerance 5
  contrapposto crosscheck walk.bvh --root free --tension 2
  contrapposto crosscheck scenes/reach.ron --states-only --states 5000 --seed 7
  contrapposto crosscheck humanoid.xml --dynamics-only
  contrapposto crosscheck humanoid.xml --dynamics-only --against heavier.xml
  contrapposto crosscheck scenes/characters/human.ron --inject 'mass:chest*1.01'

MuJoCo runs in a Python environment of its own, made on the first run in the user's cache folder (Python 3.11 or
newer with venv and pip, and the network, are needed once) and reused after. CONTRAPPOSTO_PYTHON names another
Python, CONTRAPPOSTO_CACHE another folder.

Files written into DIR:
  crosscheck.html   the table with overlay plots
  crosscheck.json   the table for machines, see docs/CROSSCHECK.md
  crosscheck.txt    the table as text
  trace.npz, core/trace.npz, mujoco/trace.npz   a standing scene, or a clip that steps, in each engine: contrapposto plot DIR --what contact
  plots/            the figures, each as .svg and .png

Exit codes: 0 all checks pass, 1 a check fails or an engine does, 2 something is wrong with the input.";

/// Arguments of `convert`.
#[derive(Debug, Args)]
#[command(after_help = CONVERT_EXAMPLES)]
pub struct ConvertArgs {
    /// Clip (.bvh), scene or character (.ron, or a name of the library), or, to write a body, physics model (MJCF .xml, .urdf)
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// File to write: .bvh, .glb, .xml for the body as MJCF, or .ron with --blocking
    #[arg(value_name = "OUT")]
    pub output: PathBuf,
    /// Frames per second to resample to [default: the input's]
    #[arg(long, value_name = "HZ", value_parser = frame_rate, allow_negative_numbers = true)]
    pub rate: Option<f64>,
    /// Metres in one unit of a BVH written [default: the input's; 0.01 for a scene]
    #[arg(long, value_name = "METRES_PER_UNIT", value_parser = length, allow_negative_numbers = true)]
    pub out_units: Option<f64>,
    /// Leave out and list what a physics model has and rigid-body dynamics has not, instead of refusing it
    #[arg(long)]
    pub dynamics_only: bool,
    /// Edit a clip first, in the words of a scene: 'Amplitude(factor: 0.5)'; may be given several times
    #[arg(long, value_name = "EDIT")]
    pub edit: Vec<String>,
    /// Have a clip go on for so long, s, by repeating the cycle of it whose ends are most alike
    #[arg(long = "loop", value_name = "SECONDS", value_parser = takes::overrides::loop_s, allow_negative_numbers = true)]
    pub loop_s: Option<f64>,
    /// Write the key poses of a clip, no more than four a second, as a scene (.ron) to go on with, and its character beside it
    #[arg(long)]
    pub blocking: bool,
    /// Replace OUT if it exists
    #[arg(long)]
    pub force: bool,
    /// How to read a clip.
    #[command(flatten)]
    pub clip: ClipArgs,
}

const CONVERT_EXAMPLES: &str = "\
Examples:
  contrapposto convert walk.bvh walk.glb
  contrapposto convert walk.bvh walk-30.bvh --rate 30 --out-units 0.01
  contrapposto convert z-up.bvh y-up.bvh --up z --drop-t-pose
  contrapposto convert walk.bvh calm.bvh --edit 'Amplitude(factor: 0.5, parts: [\"arm_l\", \"arm_r\"])'
  contrapposto convert walk.bvh walk.ron --blocking
  contrapposto convert walk.bvh long.bvh --loop 60
  contrapposto convert scenes/bow.ron bow.glb
  contrapposto convert scenes/characters/human.ron human.xml

A body written as MJCF (.xml) is Y up, in metres and radians, with the ground as a plane and two springs and a
damper per hinge as actuators (controls k_lo, k_hi, k_d); a clip's body is the one guessed for it. It stands in its
rest pose, or that of the first frame: hinges by their `ref`, and all joints in the key frame `rest`.";

/// Arguments of `library`.
#[derive(Debug, Args)]
#[command(after_help = LIBRARY_EXAMPLES)]
pub struct LibraryArgs {
    /// Print this file instead of the list
    #[arg(value_name = "NAME")]
    pub name: Option<String>,
    /// Print the list, or the line of NAME, as JSON
    #[arg(long)]
    pub json: bool,
}

const LIBRARY_EXAMPLES: &str = "\
Examples:
  contrapposto library
  contrapposto library bow > mine.ron
  contrapposto library library:keyposes/lamp.ron

A name stands for its file wherever a command takes a scene, a character or key poses, unless a file of that name
exists. Inside a scene a file of the library is named by its location: character: \"library:characters/human.ron\".";

/// Arguments of `new`.
#[derive(Debug, Args)]
pub struct NewArgs {
    /// Folder to write into; it is made if it does not exist, and no file in it is replaced
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
}

fn fidelity(text: &str) -> Result<f64, String> {
    number(text, 0.0, 1.0, "")
}

fn states(text: &str) -> Result<usize, String> {
    whole(text, 1, 100_000)
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        super::Cli::command().debug_assert();
    }
}
