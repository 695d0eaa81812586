//! The command line: words, ranges, help.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use motion::format::bvh::{Axis, ImportOptions};
use motion::smooth::Smoothing;
use scenes::StudyOptions;
use scenes::overrides::{Overrides, RATES, RootChoice, SUBSTEPS, Strategy, TENSIONS};
use scenes::push::PushSettings;
use scenes::retarget::{MappingModel, Stage};
use scenes::{Patch, SceneError};

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
  contrapposto convert walk.bvh walk.glb      change the format only

Exit codes: 0 done (also when the body fell), 1 the run failed, 2 something is wrong with the input.";

pub use crate::tune_args::TuneArgs;

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Perform a scene or a clip and write clips, trace, report and plots
    Render(RenderArgs),
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
    /// Write a clip, the kinematic motion of a scene, or a body in another format
    Convert(ConvertArgs),
}

/// What is known about a BVH file; what is not said is guessed and printed.
#[derive(Clone, Debug, Default, Args)]
pub struct ClipArgs {
    /// Metres in one unit of the BVH file (0.01 for centimetres); guessed if not given
    #[arg(long, value_name = "METRES_PER_UNIT", value_parser = length, allow_negative_numbers = true)]
    pub units: Option<f64>,
    /// Vertical axis of the BVH file; guessed if not given
    #[arg(long, value_enum)]
    pub up: Option<Up>,
    /// Leave out a first frame that is an inserted T-pose
    #[arg(long)]
    pub drop_t_pose: bool,
}

/// A vertical axis.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Up {
    /// Y up, as Contrapposto has it.
    Y,
    /// Z up; the clip is turned.
    Z,
}

impl ClipArgs {
    /// The same as the importer takes it.
    pub fn import(&self) -> ImportOptions {
        ImportOptions {
            metres_per_unit: self.units,
            up: self.up.map(|up| match up {
                Up::Y => Axis::Y,
                Up::Z => Axis::Z,
            }),
            drop_t_pose: self.drop_t_pose,
        }
    }

    /// The first of these options that was given.
    pub fn given(&self) -> Option<&'static str> {
        let given = [
            ("--units", self.units.is_some()),
            ("--up", self.up.is_some()),
            ("--drop-t-pose", self.drop_t_pose),
        ];
        given.into_iter().find(|(_, is)| *is).map(|(name, _)| name)
    }
}

/// What of muscles and simulation may differ from the file's.
#[derive(Debug, Args)]
pub struct PhysicsArgs {
    /// Patch of tension and balance, as `tune` writes it
    #[arg(long, value_name = "FILE.ron")]
    pub patch: Option<PathBuf>,
    /// Factor on every tension: 1 leaves them, 2 is twice as stiff
    #[arg(long, value_name = "X", value_parser = tension, allow_negative_numbers = true)]
    pub tension: Option<f64>,
    /// Control steps per second of the simulation [default: the scene's, 240; near 240 for a clip]
    #[arg(long, value_name = "HZ", value_parser = rate, allow_negative_numbers = true)]
    pub rate: Option<f64>,
    /// Engine substeps per control step [default: as many as the stiffest joint needs, at least 2]
    #[arg(long, value_name = "N", value_parser = substeps, allow_negative_numbers = true)]
    pub substeps: Option<usize>,
    /// Strategies of balance to switch off: ankle, hip, weight
    #[arg(long, value_name = "STRATEGY", value_delimiter = ',')]
    pub without: Vec<Strategy>,
}

impl PhysicsArgs {
    /// The same as the stage takes it.
    ///
    /// # Errors
    /// A patch that makes no sense.
    pub fn overrides(&self) -> Result<Overrides, SceneError> {
        Ok(Overrides {
            patch: patch(self.patch.as_deref())?,
            tension: self.tension,
            rate_hz: self.rate,
            substeps: self.substeps,
            without: self.without.clone(),
            ..Overrides::default()
        })
    }
}

/// Arguments of `render`.
#[derive(Debug, Args)]
#[command(after_help = RENDER_EXAMPLES)]
pub struct RenderArgs {
    /// Scene (.ron) or motion-capture clip (.bvh)
    #[arg(value_name = "SCENE.ron|CLIP.bvh")]
    pub input: PathBuf,
    /// Folder to write into; earlier output there is replaced when all is complete [default: out/NAME]
    #[arg(long, value_name = "DIR")]
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
    #[arg(long, value_name = "FROM..TO", value_parser = scenes::overrides::span)]
    pub span: Option<(f64, f64)>,
    /// Leave out the edits of the scene
    #[arg(long)]
    pub no_edits: bool,
    /// Write the motion asked for, without physics
    #[arg(long)]
    pub kinematic: bool,
    /// Muscles and simulation.
    #[command(flatten)]
    pub physics: PhysicsArgs,
    /// Draw nothing
    #[arg(long)]
    pub no_plots: bool,
    /// Print the report as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
    /// Character file for a clip, instead of a guessed body
    #[arg(long, value_name = "FILE.ron")]
    pub body: Option<PathBuf>,
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
  contrapposto render gestures.bvh --root free
  contrapposto render gestures.bvh --root free --span 2.5..7
  contrapposto render walk.bvh --units 0.01 --up y --tension 4
  contrapposto inspect walk.bvh --write-body body.ron && contrapposto render walk.bvh --body body.ron

Files written into DIR:
  kinematic.bvh   the motion asked for: edited, within joint limits, feet planted
  dynamic.bvh     the motion performed
  dynamic.glb     the same with a body of capsules, for any 3-D tool (kinematic.glb with --kinematic)
  trace.npz       every torque, gain and contact force, for numpy
  report.json     the numbers, see docs/REPORT.md
  plots/          figures, each as .svg and .png
  span_1/, ...    a clip that also steps, with a free root: these files of every standing span instead
With --pareto, into out/NAME-pareto: report.json and plots/pareto, see docs/ROOT.md.

With a free root a clip is performed where its feet stand; where they step it is not, and that is said. --root pinned or
assisted performs it whole.

BVH files are written in the unit of the BVH read, in centimetres for scenes; Y is up.
Same input, same bytes; only `realtime_factor` in report.json is of the clock.";

impl RenderArgs {
    /// Numbers of the dynamic pass that differ from the file's.
    ///
    /// # Errors
    /// A patch that makes no sense.
    pub fn overrides(&self) -> Result<Overrides, SceneError> {
        let root = self.fidelity.map(RootChoice::Fidelity).or(self.root);
        Ok(Overrides { root, span_s: self.span, ..self.physics.overrides()? })
    }
}

/// Arguments of `inspect`.
#[derive(Debug, Args)]
#[command(after_help = INSPECT_EXAMPLES)]
pub struct InspectArgs {
    /// Scene or character (.ron), or clip (.bvh)
    #[arg(value_name = "FILE")]
    pub input: PathBuf,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
    /// Write the body guessed for a clip as a character file, to edit and give to `render --body`
    #[arg(long, value_name = "FILE.ron")]
    pub write_body: Option<PathBuf>,
    /// How to read a clip.
    #[command(flatten)]
    pub clip: ClipArgs,
}

const INSPECT_EXAMPLES: &str = "\
Examples:
  contrapposto inspect scenes/bow.ron
  contrapposto inspect scenes/characters/human.ron
  contrapposto inspect walk.bvh --write-body body.ron
  contrapposto inspect scenes/bow.ron --json";

/// The statistical model of `retarget`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ModelChoice {
    /// Shared Gaussian-process latent-variable model
    #[default]
    Gplvm,
    /// Gaussian-process regression
    Gp,
    /// Principal components and a linear map
    Pca,
    /// Mean of the three nearest key poses
    Nn3,
    /// Mean of the ten nearest key poses
    Nn10,
}

impl ModelChoice {
    /// The same as the pipeline takes it.
    pub fn model(self) -> MappingModel {
        match self {
            Self::Gplvm => MappingModel::Gplvm,
            Self::Gp => MappingModel::Gp,
            Self::Pca => MappingModel::Pca,
            Self::Nn3 => MappingModel::Nn3,
            Self::Nn10 => MappingModel::Nn10,
        }
    }
}

/// A stage of `retarget`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum StopAfter {
    /// Poses, in place
    Map,
    /// Travel and turning, by momentum
    Global,
    /// Contact points held on the ground
    Contact,
    /// Forces that a ground can give
    #[default]
    Refine,
}

impl StopAfter {
    /// The same as the pipeline takes it.
    pub fn stage(self) -> Stage {
        match self {
            Self::Map => Stage::Map,
            Self::Global => Stage::Global,
            Self::Contact => Stage::Contact,
            Self::Refine => Stage::Refine,
        }
    }
}

/// Arguments of `retarget`.
#[derive(Debug, Args)]
#[command(after_help = RETARGET_EXAMPLES)]
pub struct RetargetArgs {
    /// Human motion: a scene of a human figure (.ron) or a motion-capture clip (.bvh)
    #[arg(value_name = "PERFORMANCE.ron|CLIP.bvh")]
    pub input: PathBuf,
    /// Character file of the body that gets it
    #[arg(long, value_name = "CHARACTER.ron")]
    pub to: PathBuf,
    /// Key poses to learn from [default: keyposes/NAME.ron beside the folder of the character]
    #[arg(long, value_name = "FILE.ron")]
    pub keyposes: Option<PathBuf>,
    /// How poses are mapped
    #[arg(long, value_enum, default_value_t)]
    pub model: ModelChoice,
    /// The last stage
    #[arg(long, value_enum, default_value_t)]
    pub stop_after: StopAfter,
    /// Frames per second to work at and to write [default: the motion's]
    #[arg(long, value_name = "HZ", value_parser = frame_rate, allow_negative_numbers = true)]
    pub rate: Option<f64>,
    /// Name the N moments whose poses the model is least sure of
    #[arg(long, value_name = "N", value_parser = suggestions)]
    pub suggest_keyposes: Option<usize>,
    /// Run all five models and table their errors at the key poses
    #[arg(long)]
    pub compare: bool,
    /// Print first guesses for key poses at these moments, s, as lines for a file of key poses, and do nothing else
    #[arg(long, value_name = "S", value_delimiter = ',', allow_negative_numbers = true)]
    pub guess: Vec<f64>,
    /// Draw all key poses beside the human poses they stand for, into DIR/plots, and do nothing else
    #[arg(long, conflicts_with = "guess")]
    pub sheet: bool,
    /// Folder to write into; earlier output there is replaced when all is complete
    /// [default: out/PERFORMANCE-CHARACTER]
    #[arg(long, value_name = "DIR")]
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
  contrapposto retarget walk.bvh --to scenes/characters/penguin.ron --rate 30
  contrapposto retarget scenes/performances/fear.ron --to scenes/characters/squirrel.ron --model nn3 --stop-after map
  contrapposto retarget walk.bvh --to scenes/characters/lamp.ron --suggest-keyposes 5
  contrapposto retarget scenes/performances/fear.ron --to scenes/characters/lamp.ron --guess 1.5,7

Files written into DIR:
  retargeted.bvh      the motion on the character
  retargeted.glb      the same with its body, for any 3-D tool
  human.bvh           the human motion as it was used
  report.json         the numbers, see docs/RETARGET.md
  plots/              film strip of all stages, confidence, latent path, momentum, forces

Give the result a dynamic pass with
  contrapposto render DIR/retargeted.bvh --body CHARACTER.ron --units 0.01 --up y

Same input, same bytes.";

/// Arguments of `crosscheck`.
#[derive(Debug, Args)]
#[command(after_help = CROSSCHECK_EXAMPLES)]
pub struct CrosscheckArgs {
    /// Scene or character (.ron), clip (.bvh), or physics model (MJCF .xml, .urdf)
    #[arg(value_name = "SCENE|MODEL")]
    pub input: PathBuf,
    /// Folder to write into; earlier output there is replaced when all is complete
    /// [default: out/NAME-crosscheck]
    #[arg(long, value_name = "DIR")]
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
    /// Compare the push-recovery maps of both engines too (a scene that stands; takes minutes)
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
  contrapposto crosscheck scenes/reach.ron --states-only --states 5000 --seed 7
  contrapposto crosscheck humanoid.xml --dynamics-only
  contrapposto crosscheck humanoid.xml --dynamics-only --against heavier.xml
  contrapposto crosscheck scenes/characters/human.ron --inject 'mass:chest*1.01'

MuJoCo runs in a Python environment of its own, made on the first run in the user's cache folder (Python 3.10 or
newer with venv and pip, and the network, are needed once) and reused after. CONTRAPPOSTO_PYTHON names another
Python, CONTRAPPOSTO_CACHE another folder.

Files written into DIR:
  crosscheck.html   the table with overlay plots
  crosscheck.json   the table for machines, see docs/CROSSCHECK.md
  crosscheck.txt    the table as text
  trace.npz, mujoco/trace.npz   a standing scene in both engines: contrapposto plot DIR --what contact
  plots/            the figures, each as .svg and .png

Exit codes: 0 all checks pass, 1 a check fails or an engine does, 2 something is wrong with the input.";

/// An engine that can simulate pushes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EngineArg {
    /// The engine of every other command
    Rapier,
    /// The engine of the cross-check, controllers closed over its own state; much slower
    Mujoco,
}

/// Arguments of `push`.
#[derive(Debug, Args)]
#[command(after_help = PUSH_EXAMPLES)]
pub struct PushArgs {
    /// Scene (.ron) of a body that stands free
    #[arg(value_name = "SCENE")]
    pub input: PathBuf,
    /// Directions, evenly spaced, from forward on
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = directions)]
    pub directions: usize,
    /// How closely the impulses are searched, in percent of themselves
    #[arg(long, value_name = "PERCENT", default_value_t = 1.0, value_parser = tolerance, allow_negative_numbers = true)]
    pub tolerance: f64,
    /// When the push begins, s: the body must have settled
    #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = push_time, allow_negative_numbers = true)]
    pub at: f64,
    /// Folder to write into; an earlier map there is replaced when all is complete
    /// [default: out/NAME-push]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Muscles and simulation.
    #[command(flatten)]
    pub physics: PhysicsArgs,
    /// Engine that simulates the pushes
    #[arg(long, value_enum, default_value_t = EngineArg::Rapier)]
    pub engine: EngineArg,
    /// Draw nothing
    #[arg(long)]
    pub no_plots: bool,
    /// Print the map as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

const PUSH_EXAMPLES: &str = "\
Examples:
  contrapposto push scenes/stand.ron
  contrapposto push scenes/stand.ron --directions 4 --tolerance 5
  contrapposto push scenes/stand.ron --tension 2 --out out/stiff
  contrapposto push scenes/stand.ron --engine mujoco --directions 8 --tolerance 4
  contrapposto push scenes/stand.ron --without hip,weight --out out/ankles
  contrapposto push scenes/stand.ron --json | jq .mean_ratio

A push is a constant horizontal force over 0.1 s at the body's centre of mass. It is survived if no foot moves more
than 1 cm, the body does not fall, and 5 s later the centre of mass is back within 2 cm. The limit is that of an
upright body that only moves its centre of pressure; see docs/PUSH.md.

Files written into DIR:
  report.json       the map, see docs/PUSH.md
  plots/push.svg    survived against limit, seen from above (and push.png)

Same input, same bytes, on any number of threads (RAYON_NUM_THREADS).
Exit codes: 0 done, 1 the body does not stand or the run failed, 2 something is wrong with the input.";

impl PushArgs {
    /// The same as the map takes it.
    pub fn settings(&self) -> PushSettings {
        PushSettings {
            directions: self.directions,
            tolerance: 0.01 * self.tolerance,
            at_s: self.at,
            ..PushSettings::default()
        }
    }
}

/// Arguments of `convert`.
#[derive(Debug, Args)]
#[command(after_help = CONVERT_EXAMPLES)]
pub struct ConvertArgs {
    /// Clip (.bvh), scene or character (.ron), or, to write a body, physics model (MJCF .xml, .urdf)
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// File to write: .bvh, .glb, or .xml for the body as MJCF
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
    /// How to read a clip.
    #[command(flatten)]
    pub clip: ClipArgs,
}

const CONVERT_EXAMPLES: &str = "\
Examples:
  contrapposto convert walk.bvh walk.glb
  contrapposto convert walk.bvh walk-30.bvh --rate 30 --out-units 0.01
  contrapposto convert z-up.bvh y-up.bvh --up z --drop-t-pose
  contrapposto convert scenes/bow.ron bow.glb
  contrapposto convert scenes/characters/human.ron human.xml

A body written as MJCF (.xml) is Y up, in metres and radians, with the ground as a plane and two springs and a
damper per hinge as actuators (controls k_lo, k_hi, k_d); a clip's body is the one guessed for it.";

/// A figure of `plot`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum What {
    /// Ground forces per foot and in total: required, given, measured, MuJoCo's
    Contact,
    /// Residual force and moment, graded
    Residual,
    /// Linear and angular momentum
    Momentum,
    /// Centre of mass and centre of pressure over the support
    Com,
    /// Torques of the hardest joints
    Torque,
    /// Gains and torques of the muscles (traces only)
    Gains,
    /// Joint angles asked for and performed
    Angles,
    /// Energies and power
    Energy,
    /// Film strip
    Strip,
    /// All of them that there are
    All,
}

impl What {
    /// Every figure, in order.
    pub const EACH: [What; 9] = [
        What::Contact,
        What::Residual,
        What::Momentum,
        What::Com,
        What::Torque,
        What::Gains,
        What::Angles,
        What::Energy,
        What::Strip,
    ];

    /// Name of its files.
    pub fn stem(self) -> &'static str {
        match self {
            What::Contact => "contact",
            What::Residual => "residual",
            What::Momentum => "momentum",
            What::Com => "com",
            What::Torque => "torque",
            What::Gains => "gains",
            What::Angles => "angles",
            What::Energy => "energy",
            What::Strip => "strip",
            What::All => "all",
        }
    }
}

/// What inverse dynamics is told.
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
    /// The same as a study takes it.
    pub fn options(&self) -> StudyOptions {
        StudyOptions { smoothing: self.smooth, friction: self.friction }
    }
}

/// Arguments of `plot`.
#[derive(Debug, Args)]
#[command(after_help = PLOT_EXAMPLES)]
pub struct PlotArgs {
    /// trace.npz, the folder of a run, a clip (.bvh) or a scene (.ron)
    #[arg(value_name = "TRACE|CLIP")]
    pub input: PathBuf,
    /// What to draw; several, separated by commas
    #[arg(long, value_enum, value_delimiter = ',', default_value = "all")]
    pub what: Vec<What>,
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

/// A file of `analyze`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Everything, one row per frame; angles in degrees
    Csv,
    /// OpenSim motion files of joint torques and ground reactions
    Mot,
    /// Numpy arrays, SI and radians
    Npz,
}

/// Arguments of `analyze`.
#[derive(Debug, Args)]
#[command(after_help = ANALYZE_EXAMPLES)]
pub struct AnalyzeArgs {
    /// Clip (.bvh), scene (.ron), trace.npz or the folder of a run
    #[arg(value_name = "CLIP")]
    pub input: PathBuf,
    /// Folder to write into; an earlier analysis there is replaced when all is complete
    /// [default: out/NAME-analysis]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Files to write, separated by commas
    #[arg(long, value_enum, value_delimiter = ',', default_value = "csv,mot,npz")]
    pub format: Vec<Format>,
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

/// The patch of a file, if one is given.
///
/// # Errors
/// A patch that makes no sense.
pub fn patch(path: Option<&std::path::Path>) -> Result<Option<Patch>, SceneError> {
    path.map(Patch::read).transpose()
}

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

fn number(text: &str, lo: f64, hi: f64, unit: &str) -> Result<f64, String> {
    let x: f64 = text.parse().map_err(|_| format!("not a number; allowed: {lo} to {hi}{unit}"))?;
    if (lo..=hi).contains(&x) { Ok(x) } else { Err(format!("allowed: {lo} to {hi}{unit}")) }
}

fn length(text: &str) -> Result<f64, String> {
    number(text, 1e-6, 1e3, " m")
}

fn tension(text: &str) -> Result<f64, String> {
    number(text, *TENSIONS.start(), *TENSIONS.end(), "")
}

fn rate(text: &str) -> Result<f64, String> {
    number(text, *RATES.start(), *RATES.end(), " Hz")
}

fn fidelity(text: &str) -> Result<f64, String> {
    number(text, 0.0, 1.0, "")
}

fn frame_rate(text: &str) -> Result<f64, String> {
    number(text, 1.0, 1e3, " Hz")
}

fn states(text: &str) -> Result<usize, String> {
    let allowed = 1..=100_000;
    let n = text.parse().ok().filter(|n| allowed.contains(n));
    n.ok_or_else(|| format!("allowed: a whole number from {} to {}", allowed.start(), allowed.end()))
}

fn directions(text: &str) -> Result<usize, String> {
    let n = text.parse().ok().filter(|n| (1..=360).contains(n));
    n.ok_or_else(|| "allowed: a whole number from 1 to 360".into())
}

fn tolerance(text: &str) -> Result<f64, String> {
    number(text, 0.01, 50.0, " %")
}

fn push_time(text: &str) -> Result<f64, String> {
    number(text, 0.05, 600.0, " s")
}

fn suggestions(text: &str) -> Result<usize, String> {
    let n = text.parse().ok().filter(|n| (1..=100).contains(n));
    n.ok_or_else(|| "allowed: a whole number from 1 to 100".into())
}

fn substeps(text: &str) -> Result<usize, String> {
    let (lo, hi) = (SUBSTEPS.start(), SUBSTEPS.end());
    match text.parse() {
        Ok(n) if SUBSTEPS.contains(&n) => Ok(n),
        _ => Err(format!("allowed: a whole number from {lo} to {hi}")),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        super::Cli::command().debug_assert();
    }
}
