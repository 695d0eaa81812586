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
//! As *look*, whatever they hold: `visual`, `material`, `sensor`, `transmission`, `safety_controller`, `calibration`, and what is
//! for other programs: `gazebo`, `ros2_control`, `mujoco`, `plugin`, `gravity` of a link.
//! As *physics*: `dynamics` (damping, friction), meshes to collide with, elements with a prefix (`drake:…`),
//! elements that are not URDF but known from the field (`collision_checking`, `contact`), and `mimic`: the joint is
//! read as one that moves by itself.
//!
//! # What is refused in any case
//!
//! `planar` joints, `xacro` that was not expanded.
//!
//! Source: wiki.ros.org/urdf/XML.

mod parse;
mod tree;

use std::path::Path;

use super::model_file::{ModelFile, ModelFileError};
use super::xml::Element;

/// Reads a URDF file.
///
/// # Errors
/// See [`ModelFault`](super::model_file::ModelFault); every message ends in file, line and column.
pub fn read_file(path: &Path) -> Result<ModelFile, ModelFileError> {
    read(&super::xml::read(path)?)
}

/// The model of a URDF's root element.
///
/// # Errors
/// See [`read_file`].
pub(crate) fn read(root: &Element) -> Result<ModelFile, ModelFileError> {
    tree::read(parse::robot(root)?)
}
