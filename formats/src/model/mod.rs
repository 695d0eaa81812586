//! Characters from physics models: MJCF and URDF.
//!
//! In: a file. Out: [`Imported`]: a [`Character`] whose joint values are those of the file, gravity, and a
//! list of all that was left out. Parsing is `formats`'s; here masses and inertias are computed,
//! checked, and frames are turned to ours.
//!
//! | file | holds |
//! |---|---|
//! | `solid` | mass and inertia of geoms |
//! | `mass` | mass and inertia of bodies, and whether they are physical |
//! | `build` | links, joints, shapes |
//!
//! # Frames
//!
//! Our world is Y up. The file's up is opposite to its gravity (z without gravity); the smallest rotation
//! `ours_from_file` that makes it y is the zero frame of the root link, so that **joint values stay
//! those of the file**: a free joint's position and quaternion are along the file's world axes, reference
//! values (`ref`) are in the zero frames.
//!
//! A link's frame has its body's axes and its origin at the body's last joint, so that a joint turns the link
//! about its own origin; centres of mass, shapes and sites are moved accordingly. Several joints of one body are
//! a chain of massless links named after the joints; the last link has the body's name.
//!
//! The root is the top-level body itself if it is the only one and free; otherwise the world (MJCF) or the
//! root link (URDF), welded.
//!
//! # What is left out
//!
//! With `dynamics_only` off, a file with anything that makes forces and is not read (actuators, sensors,
//! tendons, equalities, contact parameters, damping …) is refused with the list of it; with it on, those things
//! are listed in [`Imported::left_out`]. What has no force (look, scenery, solver settings) is listed in both cases.
//! Mass matrix and bias forces are complete either way, but for rotor inertia (`armature`), which is listed.

mod build;
mod mass;
pub mod solid;

use std::path::Path;

use crate::model_file::{Effect, Format, LeftOut, ModelFault, ModelFile, ModelFileError};
use crate::place::Place;
use crate::{mjcf, urdf, xml};
use motion::names::echo;
use motion::{Floor, Quat, SkeletonError, Vec3};
use thiserror::Error;

use crate::mujoco_layout::{JointThere, Layout};
use bodies::{Character, CharacterError};

/// What an import may leave out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ImportOptions {
    /// Leave out and list what makes forces and is not read, instead of refusing the file.
    pub dynamics_only: bool,
}

/// A joint of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedJoint {
    /// Name in the file; the link's if it has none.
    pub name: String,
    /// The link it moves.
    pub link: usize,
    /// Rotor inertia, which the character does not have, kg·m² or kg.
    pub armature: f64,
}

impl Imported {
    /// The map between our vectors and MuJoCo's of the same file.
    pub fn layout(&self) -> Layout {
        let (mut q, mut v) = (0, 0);
        let mut joints = Vec::new();
        for joint in &self.joints {
            joints.push(JointThere { link: joint.link, q, v });
            let kind = &self.character.skeleton.links()[joint.link].joint;
            (q, v) = (q + kind.nq(), v + kind.nv());
        }
        Layout::in_file_axes(&self.character.skeleton, &joints, q, v)
    }
}

/// A model file as a character. See the module header.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The body. Its rest pose is the key frame `rest`, or else the pose of the file (MuJoCo's `qpos0`).
    pub character: Character,
    /// Moving joints in the order of the file's tree, depth first: that of MuJoCo's `qpos`.
    pub joints: Vec<ImportedJoint>,
    /// Link of every body of the file, in its order, the base first; `None` for a world that is no link.
    pub bodies: Vec<Option<usize>>,
    /// Format of the file.
    pub format: Format,
    /// Gravity in our world, m/s².
    pub gravity: Vec3,
    /// The plane of the file's world on which a body can stand.
    pub ground: Option<Floor>,
    /// Rotation that takes vectors of the file's world to ours.
    pub ours_from_file: Quat,
    /// What the file has and the character has not.
    pub left_out: Vec<LeftOut>,
}

/// Why a file did not become a character.
#[derive(Debug, Error)]
pub enum ImportError {
    /// The file could not be read or is not a model.
    #[error(transparent)]
    File(#[from] ModelFileError),
    /// The file has things that make forces and are not read.
    #[error("{}", refusal(body, items))]
    Refused {
        /// The body that would be read: its name, joints and mass.
        body: String,
        /// All of them.
        items: Vec<LeftOut>,
    },
    /// A mesh that would have to be weighed.
    #[error(
        "the inertia of body `{body}` would come from a mesh, and meshes are not read; give it <inertial>\n  --> {place}"
    )]
    MeshMass {
        /// The body.
        body: String,
        /// The geom.
        place: Place,
    },
    /// A mass that is negative, zero beside an inertia, or not finite.
    #[error("body `{body}` has a mass of {mass} kg; it must be positive\n  --> {place}")]
    Mass {
        /// The body.
        body: String,
        /// Mass, kg.
        mass: f64,
        /// Where it is written.
        place: Place,
    },
    /// A principal inertia that is not positive.
    #[error("body `{body}` has principal inertias {principal:?} kg·m²; each must be positive\n  --> {place}")]
    Inertia {
        /// The body.
        body: String,
        /// Principal inertias, kg·m², ascending.
        principal: [f64; 3],
        /// Where it is written.
        place: Place,
    },
    /// Principal inertias that no solid has.
    #[error(
        "body `{body}` has principal inertias {principal:?} kg·m²; the greatest must be at most the sum of the other two\n  --> {place}"
    )]
    Triangle {
        /// The body.
        body: String,
        /// Principal inertias, kg·m², ascending.
        principal: [f64; 3],
        /// Where it is written.
        place: Place,
    },
    /// A joint that moves nothing that resists.
    #[error(
        "joint `{joint}` moves a subtree without inertia about its axis; give body `{body}` mass\n  --> {place}"
    )]
    NoInertia {
        /// The joint.
        joint: String,
        /// The body it belongs to.
        body: String,
        /// The joint's place.
        place: Place,
    },
    /// No body at all.
    #[error("the model has no body\n  --> {place}")]
    Empty {
        /// Where bodies would be.
        place: Place,
    },
    /// The tree does not fit our skeletons.
    #[error("{source}\n  --> {place}")]
    Skeleton {
        /// What does not fit.
        source: SkeletonError,
        /// The model.
        place: Place,
    },
    /// The bodies do not fit our characters.
    #[error("{source}\n  --> {place}")]
    Character {
        /// What does not fit.
        source: CharacterError,
        /// The model.
        place: Place,
    },
}

/// The refusal's text: what was read, what would be lost, how to go on, and the places.
fn refusal(body: &str, items: &[LeftOut]) -> String {
    const SHOWN: usize = 12;
    let them = if items.len() == 1 { "it" } else { "them" };
    let mut text = format!(
        "{body} can be read, but not what makes forces in it: {}; --dynamics-only leaves {them} out and lists {them}, `contrapposto inspect` shows what is read",
        summary(items),
    );
    for item in items.iter().take(SHOWN) {
        text += &format!("\n{item}");
    }
    if items.len() > SHOWN {
        text += &format!("\nand {} more", items.len() - SHOWN);
    }
    text
}

/// What is left out by reason, each with how often: `actuator (21), contact parameters (30)`.
pub fn summary<'a>(items: impl IntoIterator<Item = &'a LeftOut>) -> String {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for item in items {
        match counts.iter_mut().find(|(reason, _)| *reason == item.reason) {
            Some((_, count)) => *count += 1,
            None => counts.push((item.reason, 1)),
        }
    }
    counts.iter().map(|(reason, count)| format!("{reason} ({count})")).collect::<Vec<_>>().join(", ")
}

/// Reads a character from an MJCF (root element `mujoco`) or URDF (`robot`) file.
///
/// # Errors
/// See [`ImportError`]; every message ends in file, line and column.
pub fn open(path: &Path, options: &ImportOptions) -> Result<Imported, ImportError> {
    let root = xml::read(path)?;
    let file = match root.name.as_str() {
        "mujoco" => mjcf::read(path, root)?,
        "robot" => urdf::read(&root)?,
        _ => {
            let fault = ModelFault::Root { found: root.name, expected: "mujoco> or <robot" };
            return Err(ModelFileError::Model { fault, place: root.place }.into());
        }
    };
    import(&file, options)
}

/// Turns a parsed model into a character.
///
/// # Errors
/// See [`ImportError`].
pub fn import(file: &ModelFile, options: &ImportOptions) -> Result<Imported, ImportError> {
    let imported = build::build(file)?;
    if !options.dynamics_only {
        let refused = || imported.left_out.iter().filter(|item| item.effect == Effect::Physics);
        let all = imported.left_out.iter();
        if let Some((item, mesh)) = all.clone().find_map(|item| Some((item, item.missing.clone()?))) {
            let fault = ModelFault::MeshMissing { path: mesh };
            return Err(ModelFileError::Model { fault, place: item.place.clone() }.into());
        }
        let items: Vec<LeftOut> = refused().cloned().collect();
        if !items.is_empty() {
            let c = &imported.character;
            let (links, dof) = (c.skeleton.links().len(), c.skeleton.nv());
            let name = echo(&c.name);
            let body = format!("`{name}` ({links} links, {dof} degrees of freedom, {:.2} kg)", c.mass());
            return Err(ImportError::Refused { body, items });
        }
    }
    Ok(imported)
}
