//! Words of `push`.

use std::path::PathBuf;

use clap::Args;
use studies::push::PushSettings;
use takes::ENGINE;

use crate::common_args::{number, searcher_help};
use crate::physics_args::{PhysicsArgs, directions, tolerance};

/// Arguments of `push`.
#[derive(Debug, Args)]
#[command(after_help = PUSH_EXAMPLES)]
pub struct PushArgs {
    /// Scene (.ron, or a name of the library) of a body that stands free
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
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Muscles and simulation.
    #[command(flatten)]
    pub physics: PhysicsArgs,
    /// Engine that searches.
    #[arg(long, value_name = "ENGINE", help = searcher_help())]
    pub engine: Option<String>,
    /// Engine that pushes twice more in every direction, 3 % inside and 3 % outside of the border found; `none` leaves it out
    #[arg(long, value_name = "ENGINE", default_value = ENGINE)]
    pub confirm: String,
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
  contrapposto push scenes/stand.ron --confirm none               the search alone
  contrapposto push scenes/stand.ron --engine rapier              slower: every push in the engine that performs
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

fn push_time(text: &str) -> Result<f64, String> {
    number(text, 0.05, 600.0, " s")
}
