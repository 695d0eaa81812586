//! The body of a scene, a character or a clip as MJCF.
//!
//! In: a file. Out: text for MuJoCo, with the ground of the scene and an antagonist per hinge and slide.

use std::path::Path;

use controllers::antagonist::axis_set_points;
use dynamics::conditions::GRAVITY;
use formats::bvh;
use formats::mjcf::{self, MjcfError, MjcfOptions};
use formats::model::{ImportError, ImportOptions};
use motion::Floor;
use motion::floor::FRICTION;
use scenes::library::{self, Kind};

use crate::ask::is_ron;
use crate::{Ask, TakeError, character_in, open};

/// Why there is no MJCF.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// Of the file.
    #[error(transparent)]
    Take(#[from] TakeError),
    /// Of a physics model.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// Of the tree.
    #[error("no MJCF of this body: {0}")]
    Mjcf(#[from] MjcfError),
}

/// A body as MJCF.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyMjcf {
    /// The text.
    pub text: String,
    /// Links of the body.
    pub links: usize,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Moving joints.
    pub joints: usize,
    /// Hinges and slides with a pair of springs.
    pub antagonists: usize,
    /// What a physics model had and this has not.
    pub left_out: Vec<String>,
}

/// Writes the body in `path` as MJCF: of a scene with its gravity and ground; of a character, or of the body
/// guessed for a clip, with the Earth's gravity and a ground at the height 0 (of a clip: where its feet are). Of a physics model,
/// `dynamics_only` leaves out and lists what rigid-body dynamics has not.
///
/// # Errors
/// [`ExportError`].
pub fn mjcf(path: &Path, clip: &bvh::ImportOptions, dynamics_only: bool) -> Result<BodyMjcf, ExportError> {
    let path = &library::resolve(path, &[Kind::Scene, Kind::Character]).map_err(TakeError::from)?;
    let level = Floor::level(0.0, FRICTION);
    let mut left_out = Vec::new();
    let alone = match path {
        _ if formats::table::is_model(path) => {
            let read = formats::open_model(path, &ImportOptions { dynamics_only })?;
            left_out = read.left_out.iter().map(ToString::to_string).collect();
            Some((read.character, read.gravity, None))
        }
        _ if is_ron(path) => {
            character_in(path).map_err(TakeError::from)?.map(|character| (character, GRAVITY, Some(level)))
        }
        _ => None,
    };
    let (character, gravity, ground) = match alone {
        Some(found) => found,
        None => {
            let take = open(path, &Ask { import: *clip, ..Ask::default() })?;
            let ground = take.conditions.physics.ground;
            // the body as it is at the start: what comes later is not in a file without time
            let carried = take.conditions.carried.iter().filter(|c| c.at(0.0)).map(|c| &c.what);
            (take.body.character.carrying(carried), take.conditions.physics.gravity, ground)
        }
    };
    let antagonists = axis_set_points(&character.skeleton);
    let count = antagonists.len();
    let file = mjcf::write(&character, &MjcfOptions { gravity, ground, antagonists })?;
    Ok(BodyMjcf {
        links: character.bodies.len(),
        mass_kg: character.mass(),
        joints: file.joints.len(),
        antagonists: count,
        left_out,
        text: file.text,
    })
}
