//! Words of muscles and simulation, and of push maps: what several commands take.

use std::path::PathBuf;

use clap::Args;
use takes::overrides::{RATES, SUBSTEPS, SoleName, Strategy, TENSIONS, ToesName, props};
use takes::{Overrides, Patch, SceneError};

use crate::common_args::{number, whole};
use crate::words::word;

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
    /// Engine substeps per control step [default: as many as the stiffest joint needs, at least 2; MuJoCo: 8]
    #[arg(long, value_name = "N", value_parser = substeps, allow_negative_numbers = true)]
    pub substeps: Option<usize>,
    /// Strategies of balance to switch off
    #[arg(long, value_name = "STRATEGY", value_parser = word::<Strategy>(), value_delimiter = ',')]
    pub without: Vec<Strategy>,
    /// Box or ramp fixed in the world, as a scene has it: 'Box(at_m: (0, 0, 0.5), size_m: (0.4, 0.2, 0.3))'; may be repeated
    #[arg(long = "prop", value_name = "PROP", value_parser = prop)]
    pub props: Vec<String>,
    /// Let links touch each other
    #[arg(long)]
    pub self_collision: bool,
    /// What the soles are, see docs/WALKING.md [default: the scene's; pads with --foresight, else rigid]
    #[arg(long, value_name = "SOLES", value_parser = word::<SoleName>())]
    pub soles: Option<SoleName>,
    /// What the toes do, see docs/WALKING.md [default: the scene's; welded]
    #[arg(long, value_name = "TOES", value_parser = word::<ToesName>())]
    pub toes: Option<ToesName>,
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
            props: props(&self.props)?,
            self_collision: self.self_collision,
            soles: self.soles,
            toes: self.toes,
            ..Overrides::default()
        })
    }
}

/// The patch of a file, if one is given.
///
/// # Errors
/// A patch that makes no sense.
pub fn patch(path: Option<&std::path::Path>) -> Result<Option<Patch>, SceneError> {
    path.map(Patch::read).transpose()
}

/// A factor on tensions.
pub fn tension(text: &str) -> Result<f64, String> {
    number(text, *TENSIONS.start(), *TENSIONS.end(), "")
}

fn rate(text: &str) -> Result<f64, String> {
    number(text, *RATES.start(), *RATES.end(), " Hz")
}

/// Directions of a push map.
pub fn directions(text: &str) -> Result<usize, String> {
    whole(text, 1, 360)
}

/// How closely its impulses are searched.
pub fn tolerance(text: &str) -> Result<f64, String> {
    number(text, 0.01, 50.0, " %")
}

fn substeps(text: &str) -> Result<usize, String> {
    whole(text, *SUBSTEPS.start(), *SUBSTEPS.end())
}

fn prop(text: &str) -> Result<String, String> {
    props(&[text.to_owned()]).map(|_| text.to_owned()).map_err(|e| e.to_string())
}
