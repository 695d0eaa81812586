//! Physics models as files have them: one plain tree for MJCF and URDF.
//!
//! In: what [`mjcf`](super::mjcf) and [`urdf`](super::urdf) read. Out: [`ModelFile`], with defaults,
//! angles and orientations resolved, but nothing interpreted: no inertia is computed from geoms, nothing
//! is turned to our axes, and all that was not taken is in [`ModelFile::left_out`] with its place. What
//! becomes of those items is the importer's decision (`crate::model`).
//!
//! Metres, kilograms, radians, in the axes of the file. A body's pose is in its parent's frame; joints,
//! inertials, geoms and sites are in the body's frame.

use std::fmt;
use std::path::PathBuf;

use nalgebra::Matrix3;
use thiserror::Error;

use super::FileError;
use super::place::Place;
use motion::names::{brief, echo, hint};
use motion::{Range, Transform, Vec3};

/// A model file: a tree of bodies, and what was not taken from the file.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelFile {
    /// Format it was read from.
    pub format: Format,
    /// Name of the model; the file's stem if it gives none.
    pub name: String,
    /// Gravity, file axes, m/s².
    pub gravity: Vec3,
    /// What all bodies together shall weigh, kg: masses and inertias are scaled to it.
    pub total_mass: Option<f64>,
    /// Bodies in depth-first order, parents first. The first is the fixed base: the `world` of an MJCF,
    /// the root link of a URDF; it has no joints.
    pub bodies: Vec<FileBody>,
    /// Values of all joints in the rest pose, in the order of the file, and where they stand; the pose the file draws if `None`.
    pub rest: Option<(Vec<f64>, Place)>,
    /// What was found and not taken, in the order it was found.
    pub left_out: Vec<LeftOut>,
}

/// Format of a model file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// MuJoCo's; the base is the world, its geoms are scenery.
    Mjcf,
    /// That of ROS; the base is the root link.
    Urdf,
}

/// A rigid body and how it hangs on its parent.
#[derive(Clone, Debug, PartialEq)]
pub struct FileBody {
    /// Name, if it has one.
    pub name: Option<String>,
    /// Index of the parent; `None` for the base only.
    pub parent: Option<usize>,
    /// `parent_from_body` when all joints are at their reference.
    pub pose: Transform,
    /// Joints to the parent, outermost first; none for a welded body.
    pub joints: Vec<FileJoint>,
    /// Mass and inertia as written; `None` if they are to be taken from `geoms`.
    pub inertial: Option<FileInertial>,
    /// Whether the geoms' mass and inertia come before `inertial`, which then counts only where they weigh nothing.
    pub geoms_first: bool,
    /// Solids.
    pub geoms: Vec<FileGeom>,
    /// Named points.
    pub sites: Vec<FileSite>,
    /// Where it begins.
    pub place: Place,
}

/// What a joint lets move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileJointKind {
    /// All six directions; only of a body that hangs on the base, and alone.
    Free,
    /// Three rotations.
    Ball,
    /// Rotation about an axis.
    Hinge,
    /// Translation along an axis.
    Slide,
}

/// A joint of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct FileJoint {
    /// Name, if it has one.
    pub name: Option<String>,
    /// Kind.
    pub kind: FileJointKind,
    /// Anchor, m.
    pub pos: Vec3,
    /// Unit axis of a hinge or slide.
    pub axis: Vec3,
    /// Range of motion, rad or m, in joint values (those of `reference` included).
    pub range: Option<Range>,
    /// Joint value in the pose in which the file draws the body, rad or m.
    pub reference: f64,
    /// Rotor inertia added to the diagonal of the mass matrix, kg·m² or kg.
    pub armature: f64,
    /// Damping, N·m·s/rad or N·s/m.
    pub damping: f64,
    /// Spring stiffness, N·m/rad or N/m.
    pub stiffness: f64,
    /// Where it begins.
    pub place: Place,
}

/// Mass and inertia as written.
#[derive(Clone, Debug, PartialEq)]
pub struct FileInertial {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass, and the axes of `inertia`, in the body's frame.
    pub pose: Transform,
    /// Inertia about the centre of mass, kg·m².
    pub inertia: Matrix3<f64>,
    /// Where it begins.
    pub place: Place,
}

/// A solid's shape and size, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FileShape {
    /// Ball.
    Sphere {
        /// Radius.
        radius: f64,
    },
    /// Cylinder along z with a half ball at each end.
    Capsule {
        /// Radius.
        radius: f64,
        /// Half length of the cylinder.
        half: f64,
    },
    /// Cylinder along z.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Half length.
        half: f64,
    },
    /// Box.
    Box {
        /// Half edges.
        half: Vec3,
    },
    /// Ellipsoid.
    Ellipsoid {
        /// Half axes.
        half: Vec3,
    },
    /// A half space below its own z = 0; only on the base.
    Plane,
    /// A height field; only on the base.
    HeightField,
    /// A mesh; its vertices are not read.
    Mesh,
}

impl FileShape {
    /// Word for messages.
    pub fn word(&self) -> &'static str {
        match self {
            FileShape::Sphere { .. } => "sphere",
            FileShape::Capsule { .. } => "capsule",
            FileShape::Cylinder { .. } => "cylinder",
            FileShape::Box { .. } => "box",
            FileShape::Ellipsoid { .. } => "ellipsoid",
            FileShape::Plane => "plane",
            FileShape::HeightField => "height field",
            FileShape::Mesh => "mesh",
        }
    }
}

/// A solid fixed to a body.
#[derive(Clone, Debug, PartialEq)]
pub struct FileGeom {
    /// Name, if it has one.
    pub name: Option<String>,
    /// Shape and size.
    pub shape: FileShape,
    /// `body_from_geom`.
    pub pose: Transform,
    /// What it weighs.
    pub weight: Weight,
    /// Whether the body's mass and inertia take it in, where they are taken from geoms.
    pub counts: bool,
    /// Whether it collides with anything.
    pub collides: bool,
    /// Coulomb friction coefficient.
    pub friction: f64,
    /// Where it begins.
    pub place: Place,
}

/// What a solid weighs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weight {
    /// Mass, kg.
    Mass(f64),
    /// Density, kg/m³.
    Density(f64),
}

/// A named point on a body.
#[derive(Clone, Debug, PartialEq)]
pub struct FileSite {
    /// Name.
    pub name: String,
    /// Position, m.
    pub pos: Vec3,
    /// Where it begins.
    pub place: Place,
}

/// What leaving a thing out changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Nothing that moves: look, scenery, settings of another program, names of things not drawn.
    Look,
    /// Forces: contact parameters, actuators, sensors, tendons, equalities, damping, springs.
    Physics,
}

/// A thing of the file that the model does not have.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// The element, and its attributes if only those are left out: ``geom `foot`: condim, friction``.
    pub what: String,
    /// What it is, in one or two words.
    pub reason: &'static str,
    /// Whether forces depend on it.
    pub effect: Effect,
    /// The mesh file it names, if that does not exist.
    pub missing: Option<PathBuf>,
    /// Where it stands.
    pub place: Place,
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})\n  --> {}", self.what, self.reason, self.place)
    }
}

/// Why a file is not a model.
#[derive(Debug, Error)]
pub enum ModelFileError {
    /// A file that could not be read.
    #[error(transparent)]
    File(FileError),
    /// A fault at a place.
    #[error("{fault}\n  --> {place}")]
    Model {
        /// What was found and what is allowed.
        fault: ModelFault,
        /// Where.
        place: Place,
    },
}

impl ModelFileError {
    /// The fault, if it is one in the text.
    pub fn fault(&self) -> Option<&ModelFault> {
        match self {
            ModelFileError::File(_) => None,
            ModelFileError::Model { fault, .. } => Some(fault),
        }
    }
}

/// A path that a file names.
fn shown(path: &std::path::Path) -> String {
    echo(&path.display().to_string())
}

/// A circle of files, the middle of a long one left out.
fn chained(chain: &[String]) -> String {
    const ENDS: usize = 4;
    match chain.len() {
        n if n > 2 * ENDS => {
            format!(
                "{} → {} more → {}",
                chain[..ENDS].join(" → "),
                n - 2 * ENDS,
                chain[n - ENDS..].join(" → ")
            )
        }
        _ => chain.join(" → "),
    }
}

/// What is wrong with a model file.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ModelFault {
    /// Bytes that are not UTF-8.
    #[error("the file is not UTF-8 text from here on")]
    NotUtf8,
    /// Not well-formed XML.
    #[error("not XML: {}", echo(message))]
    Syntax {
        /// What the XML parser says.
        message: String,
    },
    /// Elements in elements in elements.
    #[error("elements are nested more than {limit} deep")]
    TooDeep {
        /// Depth allowed.
        limit: usize,
    },
    /// More of something than is read.
    #[error("more than {limit} {what}")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// How many are allowed.
        limit: usize,
    },
    /// Text between elements.
    #[error("text `{found}` inside <{element}>; only elements and comments are allowed")]
    Text {
        /// The element around it.
        element: String,
        /// The text, cut.
        found: String,
    },
    /// A root element of another format.
    #[error("the root element is <{}>; expected <{expected}>", echo(found))]
    Root {
        /// Name found.
        found: String,
        /// Name needed.
        expected: &'static str,
    },
    /// An element the format does not have there.
    #[error("unknown element <{}> in <{parent}>{}", echo(element), hint(element, allowed.iter().copied()))]
    UnknownElement {
        /// Name found.
        element: String,
        /// Element around it.
        parent: String,
        /// Names the format has there.
        allowed: Vec<&'static str>,
    },
    /// An attribute the element does not have.
    #[error("unknown attribute `{}` of <{element}>{}", echo(attribute), hint(attribute, allowed.iter().copied()))]
    UnknownAttribute {
        /// Name found.
        attribute: String,
        /// The element.
        element: String,
        /// Names the element has.
        allowed: Vec<&'static str>,
    },
    /// An attribute or child that must be there.
    #[error("{element} needs {needed}")]
    Missing {
        /// The element.
        element: String,
        /// What it needs.
        needed: &'static str,
    },
    /// An element that may stand only once.
    #[error("<{element}> stands twice in <{parent}>")]
    Twice {
        /// The element.
        element: String,
        /// Element around it.
        parent: String,
    },
    /// A value that is no number.
    #[error("`{}` in {attribute} is not a finite number", echo(found))]
    BadNumber {
        /// Word found.
        found: String,
        /// The attribute.
        attribute: String,
    },
    /// Too few or too many numbers.
    #[error("{attribute} has {found} numbers; it takes {needed}")]
    NumberCount {
        /// The attribute.
        attribute: String,
        /// Numbers found.
        found: usize,
        /// Numbers allowed.
        needed: String,
    },
    /// A value out of its bounds.
    #[error("{attribute} is {}; it must be {allowed}", echo(found))]
    OutOfBounds {
        /// The attribute.
        attribute: String,
        /// Value found.
        found: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A word that is none of those allowed.
    #[error("unknown word `{}` for {attribute}{}", echo(found), hint(found, allowed.iter().copied()))]
    BadWord {
        /// The attribute.
        attribute: String,
        /// Word found.
        found: String,
        /// Words allowed.
        allowed: Vec<&'static str>,
    },
    /// Attributes that exclude each other.
    #[error("<{element}> has {}; only one of them is allowed", attributes.join(" and "))]
    Exclusive {
        /// The element.
        element: String,
        /// Attributes found.
        attributes: Vec<&'static str>,
    },
    /// A default class nobody defined.
    #[error("unknown default class `{}`{}", echo(class), hint(class, known.iter().map(String::as_str)))]
    UnknownClass {
        /// Name found.
        class: String,
        /// Classes of the file.
        known: Vec<String>,
    },
    /// A default class defined twice, or without a name.
    #[error("default class `{}` {problem}", echo(class))]
    Class {
        /// Its name.
        class: String,
        /// What is wrong.
        problem: &'static str,
    },
    /// An included file that does not exist.
    #[error("the included file {} does not exist", shown(path))]
    IncludeMissing {
        /// The file.
        path: PathBuf,
    },
    /// A file that includes itself, directly or through others.
    #[error("the includes go round in a circle: {}", chained(chain))]
    IncludeLoop {
        /// The files, the first again at the end.
        chain: Vec<String>,
    },
    /// A file included more than once.
    #[error("{} is included a second time; a file can be included once", shown(path))]
    IncludeTwice {
        /// The file.
        path: PathBuf,
    },
    /// A mesh file that does not exist.
    #[error("the mesh file {} does not exist", shown(path))]
    MeshMissing {
        /// The file.
        path: PathBuf,
    },
    /// A name that not every format can hold.
    #[error("{}", brief(problem))]
    Name {
        /// What was found and what is allowed.
        problem: String,
    },
    /// Two things of one name.
    #[error("the {kind} name `{}` is used twice; names must be unique", echo(name))]
    DuplicateName {
        /// Body, joint or site.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// Something that would change the model and is not read.
    #[error("{} is not supported: {reason}", echo(what))]
    Unsupported {
        /// The element or attribute.
        what: String,
        /// Why, and what to do instead.
        reason: &'static str,
    },
    /// A free joint that is not alone on a top-level body.
    #[error("a free joint must be the only joint of a body of the world")]
    FreeJoint,
    /// A joint that names no link of the file.
    #[error("joint `{joint}` names the unknown link `{}`{}", echo(link), hint(link, known.iter().map(String::as_str)))]
    UnknownLink {
        /// The joint.
        joint: String,
        /// Name found.
        link: String,
        /// Links of the file.
        known: Vec<String>,
    },
    /// A link that two joints carry.
    #[error("link `{link}` is the child of two joints, `{first}` and `{second}`; a link has one parent")]
    TwoParents {
        /// The link.
        link: String,
        /// One joint.
        first: String,
        /// The other joint.
        second: String,
    },
    /// Links that carry each other.
    #[error("the joints go round in a circle: link `{link}` carries itself")]
    LinkLoop {
        /// A link of the circle.
        link: String,
    },
    /// More than one link that no joint carries.
    #[error("links `{first}` and `{second}` both have no parent; a robot is one tree with one root")]
    TwoRoots {
        /// One root.
        first: String,
        /// The other.
        second: String,
    },
}
