//! URDF, the robot description of ROS: links with inertias, joints between them.
//!
//! In: a file. Out: a [`ModelFile`] whose base is the root link, welded to the world as the file has it;
//! bodies in depth-first order, children in the order of their joints. Angles are radians, up is z, gravity is
//! 9.81 m/s² down: the format has no word for them.
//!
//! | file | holds |
//! |---|---|
//! | `parse` | the two flat lists of links and joints |
//! | `tree` | the tree they make |
//!
//! # What is read
//!
//! `link` with `inertial` (a link without has no mass, whatever its geometry), `collision` of sphere, cylinder,
//! box and capsule; `joint` of type `revolute`, `continuous`, `prismatic`, `fixed`, `floating`; their origins, axes and ranges.
//!
//! # What is listed
//!
//! As *look*: `visual`, `material`, names of collisions, `safety_controller`, `calibration`.
//! As *physics*: `dynamics` (damping, friction), effort and velocity limits, `transmission`, `gazebo`, `sensor`, meshes,
//! and elements that are not URDF but known from the field: `collision_checking`, `disable_collisions`.
//!
//! # What is refused in any case
//!
//! `mimic` (it takes away a degree of freedom), `planar` joints, `xacro` that was not expanded.
//!
//! Source: wiki.ros.org/urdf/XML.

mod parse;
mod tree;

use std::path::Path;

use super::model_file::{ModelFile, ModelFileError};

/// Reads a URDF file.
///
/// # Errors
/// See [`ModelFault`](super::model_file::ModelFault); every message ends in file, line and column.
pub fn read_file(path: &Path) -> Result<ModelFile, ModelFileError> {
    let root = super::xml::read(path)?;
    tree::read(parse::robot(&root)?)
}
