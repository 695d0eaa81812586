//! The words of a scene file, as serde reads them; see `docs/SCENES.md` for the user's guide.
//!
//! In: RON. Out: plain structs with numbers as written (degrees, metres, seconds); [`crate::scene`] turns
//! them into a checked scene. Unknown fields are errors everywhere.
//!
//! | module | holds the words of |
//! |---|---|
//! | [`script`] | actions, cycles, poses, elements, footwork |
//! | [`motion`] | clips and retargeted motion |
//! | [`edits`] | edits |
//! | [`conditions`] | world, root, pushes, carried masses, reactive properties, physics, balance |
//! | [`tune`] | tuning |
//!
//! Values with names are read by the table of the type that has them, see [`word`].

pub mod conditions;
pub mod edits;
pub mod motion;
pub mod script;
pub mod tune;
pub mod word;

use serde::Deserialize;

use crate::StripSpec;

pub use conditions::*;
pub use edits::*;
pub use motion::*;
pub use script::*;
pub use tune::*;
pub use word::{Named, NamedWith};

/// A whole scene file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "Scene")]
pub struct SceneRon {
    /// Character file, relative to the scene file.
    pub character: String,
    /// Frames per second of the clips written; by default 120 for a script, else those of the motion.
    pub rate_hz: Option<f64>,
    /// Properties every action inherits.
    #[serde(default)]
    pub properties: PropertiesRon,
    /// Actions.
    #[serde(default)]
    pub script: Vec<ActionRon>,
    /// A motion that is not a script: a clip, or a human motion put on the character.
    pub motion: Option<MotionRon>,
    /// How long a clip goes on by repeating a cycle of itself, s.
    pub loop_s: Option<f64>,
    /// Single elements beside the actions.
    #[serde(default)]
    pub inserts: Vec<InsertRon>,
    /// Edits, in the order they are applied.
    #[serde(default)]
    pub edits: Vec<EditRon>,
    /// Still time after the last element of a script, s; by default 1.5.
    pub settle_s: Option<f64>,
    /// Limbs whose ends stay where they are at rest; by default every leg.
    pub planted: Option<Vec<String>>,
    /// Steps and jumps of the planted limbs, of a free or a pinned root.
    #[serde(default)]
    pub footwork: Vec<FootworkRon>,
    /// Gravity and ground.
    #[serde(default)]
    pub world: WorldRon,
    /// What holds the root in the dynamic pass.
    #[serde(default)]
    pub root: NamedWith<RootRon>,
    /// Numbers of the dynamic pass.
    #[serde(default)]
    pub physics: PhysicsRon,
    /// The balance of a standing body.
    #[serde(default)]
    pub balance: BalanceRon,
    /// Pushes from outside.
    #[serde(default)]
    pub pushes: Vec<PushRon>,
    /// Masses carried.
    #[serde(default)]
    pub carried: Vec<CarriedRon>,
    /// Reactive properties beside the balance.
    #[serde(default)]
    pub reactive: Vec<ReactiveRon>,
    /// Points of view and captions for the film strips.
    #[serde(default)]
    pub strip: StripSpec,
    /// Engine that performs it; by default rapier.
    pub engine: Option<String>,
    /// Patch of tension and balance, a file relative to the scene.
    pub patch: Option<String>,
    /// How `contrapposto tune` chooses tension and balance.
    pub tune: Option<TuneRon>,
}
