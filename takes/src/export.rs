//! The body of a scene, a character or a clip as MJCF.
//!
//! In: a file. Out: text for MuJoCo, with the ground of the scene and an antagonist per hinge and slide.

use std::path::Path;

use bodies::{Character, Prop};
use controllers::antagonist::axis_set_points;
use dynamics::conditions::GRAVITY;
use formats::bvh;
use formats::mjcf::{self, MjcfError, MjcfOptions};
use formats::model::{ImportError, ImportOptions};
use motion::floor::FRICTION;
use motion::{Floor, Vec3};
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
    /// Height of the ground under the world's origin, m, if there is one.
    pub ground_m: Option<f64>,
    /// What a physics model had and this has not.
    pub left_out: Vec<String>,
}

/// Writes the body in `path` as MJCF, in the pose in which it stands there: of a scene, or of the body guessed for a clip, at the
/// start of its motion, with its gravity and ground; of a character in its rest pose, with the Earth's gravity and ground under its
/// lowest solid; of a physics model in its own, with what it has. There, `dynamics_only` leaves out and lists what rigid-body dynamics
/// has not.
///
/// # Errors
/// [`ExportError`].
pub fn mjcf(path: &Path, clip: &bvh::ImportOptions, dynamics_only: bool) -> Result<BodyMjcf, ExportError> {
    let path = &library::resolve(path, &[Kind::Scene, Kind::Character]).map_err(TakeError::from)?;
    let body = match path {
        _ if formats::table::is_model(path) => Body::of_model(path, dynamics_only)?,
        _ => match is_ron(path).then(|| character_in(path)).transpose().map_err(TakeError::from)?.flatten() {
            Some(character) => Body::of_character(character),
            None => Body::of_take(path, clip)?,
        },
    };
    let antagonists = axis_set_points(&body.character.skeleton);
    let count = antagonists.len();
    let options = MjcfOptions {
        gravity: body.gravity,
        ground: body.ground,
        props: body.props,
        self_collision: body.self_collision,
        antagonists,
        pose: Some(body.pose),
        joint_names: body.joint_names,
    };
    let file = mjcf::write(&body.character, &options)?;
    Ok(BodyMjcf {
        links: body.character.bodies.len(),
        mass_kg: body.character.mass(),
        joints: file.joints.len(),
        antagonists: count,
        ground_m: body.ground.map(|g| g.height_m),
        left_out: body.left_out,
        text: file.text,
    })
}

/// A body where it stands.
struct Body {
    character: Character,
    gravity: Vec3,
    ground: Option<Floor>,
    pose: Vec<f64>,
    joint_names: Vec<(usize, String)>,
    left_out: Vec<String>,
    props: Vec<Prop>,
    self_collision: bool,
}

impl Body {
    fn of_model(path: &Path, dynamics_only: bool) -> Result<Self, ExportError> {
        let read = formats::open_model(path, &ImportOptions { dynamics_only })?;
        Ok(Self {
            gravity: read.gravity,
            ground: read.ground,
            pose: read.character.rest.clone(),
            joint_names: read.joints.iter().map(|j| (j.link, j.name.clone())).collect(),
            left_out: read.left_out.iter().map(ToString::to_string).collect(),
            character: read.character,
            props: Vec::new(),
            self_collision: false,
        })
    }

    fn of_character(character: Character) -> Self {
        let pose = character.rest.clone();
        let lowest = character.extent(&pose, &Vec3::y()).map_or(0.0, |[low, _]| low);
        // within a micrometre of the height that files are written for
        let height_m = if lowest.abs() < 1e-6 { 0.0 } else { lowest };
        let ground = Some(Floor::level(height_m, FRICTION));
        Self {
            character,
            gravity: GRAVITY,
            ground,
            pose,
            joint_names: Vec::new(),
            left_out: Vec::new(),
            props: Vec::new(),
            self_collision: false,
        }
    }

    fn of_take(path: &Path, clip: &bvh::ImportOptions) -> Result<Self, ExportError> {
        let take = open(path, &Ask { import: *clip, ..Ask::default() })?;
        let physics = &take.conditions.physics;
        // the body as it is at the start: what comes later is not in a file without time
        let carried = take.conditions.carried.iter().filter(|c| c.at(0.0)).map(|c| &c.what);
        Ok(Self {
            character: take.body.character.carrying(carried),
            gravity: physics.gravity,
            ground: physics.ground,
            pose: take.asked.clip.pose(0).to_vec(),
            joint_names: Vec::new(),
            left_out: Vec::new(),
            props: take.conditions.props.clone(),
            self_collision: take.conditions.self_collision,
        })
    }
}
