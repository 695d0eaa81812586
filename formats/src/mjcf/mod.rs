//! MJCF, the XML of MuJoCo: bodies, joints, geoms and inertias, with defaults, includes and angles resolved.
//!
//! In: a file. Out: a [`ModelFile`], joint order and joint values those of
//! MuJoCo's `qpos`. Every element and attribute is read, listed as left out, or an error; none is skipped.
//!
//! | file | holds |
//! |---|---|
//! | `include` | `<include>` expanded, circles refused |
//! | `schema` | the words of MJCF, and which of them are read |
//! | `defaults` | `<default>` classes |
//! | `orientation` | quaternions, Euler angles, axes |
//! | `tree` | compiler, option, sections |
//! | `body` | bodies, joints, inertias, geoms, sites |
//!
//! # What is read
//!
//! `compiler` (`angle`, `eulerseq`, `autolimits`, `inertiafromgeom`, `inertiagrouprange`, `settotalmass`, `meshdir`, `assetdir`;
//! `fusestatic` and `discardvisual` change nothing that is kept), `option gravity`, `default` classes with
//! `class` and `childclass`, `frame`, `body` with any orientation attribute, `joint`, `freejoint`, `inertial`, `geom`
//! (sphere, capsule, cylinder, box, ellipsoid, and on the world plane and height field) with `fromto`, `site`.
//! A `size` with fewer numbers than its default keeps the rest of the default; the orientation or the
//! default that comes last wins; a `fromto` wins over an orientation and excludes a position: as MuJoCo 4 has it.
//!
//! # What is listed
//!
//! As *look*: lights, cameras, materials, textures, colours, `visual`, `statistic`, `size`, `custom`, scenery
//! (geoms of the world), solver and time-step settings of MuJoCo, how a site is drawn.
//! As *physics*: actuators, sensors, tendons, equalities, contact pairs and parameters, key frames,
//! damping, stiffness, armature, friction loss, limits of ball joints, meshes.
//!
//! # What is refused in any case
//!
//! What would change bodies, masses or the meaning of joint values: `replicate`, `attach`,
//! `composite`, `flexcomp`, `flex`, plugins, `coordinate="global"`, `alignfree`, `balanceinertia`, `boundmass`,
//! `boundinertia`, `shellinertia`, `passthrough`, geoms fitted to meshes.
//!
//! Source: MuJoCo's XML reference, and its own schema (`mj_printSchema`, 4.0.0).

mod body;
mod defaults;
mod include;
mod orientation;
mod schema;
mod tree;
mod write;

use std::path::Path;

pub use write::{Mjcf, MjcfError, MjcfOptions, write};

use super::model_file::{ModelFault, ModelFile, ModelFileError};
use super::xml::Element;

/// Reads an MJCF file and all it includes.
///
/// # Errors
/// See [`ModelFault`]; every message ends in file, line and column.
pub fn read_file(path: &Path) -> Result<ModelFile, ModelFileError> {
    read(path, super::xml::read(path)?)
}

/// The model of an MJCF whose root element was read from `path`.
///
/// # Errors
/// See [`read_file`].
pub(crate) fn read(path: &Path, root: Element) -> Result<ModelFile, ModelFileError> {
    if root.name != "mujoco" {
        let fault = ModelFault::Root { found: root.name, expected: "mujoco" };
        return Err(ModelFileError::Model { fault, place: root.place });
    }
    let root = include::read(path, root)?;
    let stem = path.file_stem().map_or_else(|| "model".into(), |s| s.to_string_lossy().into_owned());
    tree::read(&root, &stem)
}
