//! The flat lists of a URDF: links and joints, in the order of the file.
//!
//! In: the root element. Out: [`Robot`]; every word read, listed or refused, names not yet resolved.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use nalgebra::{Matrix3, Quaternion, Translation3};

use crate::attributes::Reader;
use crate::model_file::{
    Effect, FileGeom, FileInertial, FileShape, LeftOut, ModelFault, ModelFileError, Weight,
};
use crate::place::Place;
use crate::vocabulary::{
    Fate::{self, Listed, Never, Taken},
    Part, Use, Word, attributes, judge, text,
};
use crate::xml::{Attribute, Element};
use motion::floor::FRICTION;
use motion::rotation::{EulerOrder, Quat, Vec3};
use motion::{Range, Transform};

/// A URDF as it is written.
pub struct Robot {
    pub name: String,
    pub links: Vec<RobotLink>,
    pub joints: Vec<RobotJoint>,
    pub left_out: Vec<LeftOut>,
    pub place: Place,
}

/// A `<link>`.
pub struct RobotLink {
    pub name: String,
    pub inertial: Option<FileInertial>,
    pub geoms: Vec<FileGeom>,
    pub place: Place,
}

/// What a `<joint>` lets move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RobotJointKind {
    Fixed,
    Hinge,
    Slide,
    Floating,
}

/// A `<joint>`.
pub struct RobotJoint {
    pub name: String,
    pub kind: RobotJointKind,
    pub origin: Transform,
    pub parent: Attribute,
    pub child: Attribute,
    pub axis: Vec3,
    pub range: Option<Range>,
    pub damping: f64,
    pub place: Place,
}

const NONE: &[Word] = &[];
const ROBOT: &[Word] = &[("name", Use::Read), ("version", Use::Look("version"))];
const LINK: &[Word] = &[("name", Use::Read), ("type", Use::Look("a word of an old format"))];
const JOINT: &[Word] =
    &[("name", Use::Read), ("type", Use::Read), ("dont_collapse", Use::Look("for another program"))];
const ORIGIN: &[Word] = &[("xyz", Use::Read), ("rpy", Use::Read), ("quat_xyzw", Use::Read)];
const INERTIA: &[Word] = &[
    ("ixx", Use::Read),
    ("ixy", Use::Read),
    ("ixz", Use::Read),
    ("iyy", Use::Read),
    ("iyz", Use::Read),
    ("izz", Use::Read),
];
const RATING: Use = Use::Look("ratings of the motor");
const LIMIT: &[Word] = &[
    ("lower", Use::Read),
    ("upper", Use::Read),
    ("effort", RATING),
    ("velocity", RATING),
    ("acceleration", RATING),
    ("deceleration", RATING),
    ("jerk", RATING),
    ("command_effort", RATING),
    ("current", RATING),
    ("gear_velocity", RATING),
];
const PASSIVE: Use = Use::Nonzero("passive forces");
const DYNAMICS: &[Word] = &[
    ("damping", PASSIVE),
    ("friction", PASSIVE),
    ("D", PASSIVE),
    ("K", PASSIVE),
    ("mu_coulomb", PASSIVE),
    ("mu_viscous", PASSIVE),
    ("spring_reference", PASSIVE),
    ("spring_stiffness", PASSIVE),
];

const FOREIGN: Fate = Listed(Effect::Physics, "not part of URDF");
const OTHERS: Fate = Listed(Effect::Look, "for another program");
const ROBOT_PARTS: &[Part] = &[
    ("link", Taken),
    ("joint", Taken),
    ("material", Listed(Effect::Look, "look")),
    ("transmission", Listed(Effect::Look, "how a motor is attached")),
    ("sensor", Listed(Effect::Look, "sensor: it measures and exerts no force")),
    ("gazebo", OTHERS),
    ("mujoco", OTHERS),
    ("ros2_control", OTHERS),
    ("plugin", OTHERS),
    ("group", OTHERS),
    ("disable_collisions", OTHERS),
    ("loop_joint", Never("bodies in a ring are not read; a robot is a tree")),
];
const LINK_PARTS: &[Part] = &[
    ("inertial", Taken),
    ("visual", Listed(Effect::Look, "look")),
    ("collision", Taken),
    ("sensor", Listed(Effect::Look, "sensor: it measures and exerts no force")),
    ("gazebo", OTHERS),
    ("self_filter", OTHERS),
    ("kinematic", OTHERS),
    ("origin", Listed(Effect::Look, "a link has no origin but that of its joint")),
    ("collision_checking", FOREIGN),
    ("self_collision_checking", FOREIGN),
    ("contact", FOREIGN),
    ("surface", OTHERS),
    ("gravity", OTHERS),
    ("self_collide", OTHERS),
    ("audio", FOREIGN),
];
const SOLID_PARTS: &[Part] = &[
    ("origin", Taken),
    ("geometry", Taken),
    ("material", Listed(Effect::Look, "look")),
    ("verbose", Listed(Effect::Look, "a word of an old format")),
    ("contact_coefficients", Listed(Effect::Physics, "contact parameters")),
];
const INERTIAL_PARTS: &[Part] = &[("origin", Taken), ("mass", Taken), ("inertia", Taken)];
const GEOMETRY_PARTS: &[Part] =
    &[("box", Taken), ("cylinder", Taken), ("sphere", Taken), ("capsule", Taken), ("mesh", Taken)];
const JOINT_PARTS: &[Part] = &[
    ("origin", Taken),
    ("parent", Taken),
    ("child", Taken),
    ("axis", Taken),
    ("limit", Taken),
    ("dynamics", Taken),
    ("calibration", Listed(Effect::Look, "calibration of a sensor")),
    ("safety_controller", Listed(Effect::Look, "settings of a controller")),
    ("joint_properties", Taken),
    ("mimic", Listed(Effect::Physics, "a joint that follows another one")),
];

/// Reads the lists.
pub fn robot(root: &Element) -> Result<Robot, ModelFileError> {
    if root.name != "robot" {
        let fault = ModelFault::Root { found: root.name.clone(), expected: "robot" };
        return Err(ModelFileError::Model { fault, place: root.place.clone() });
    }
    let mut robot = Robot {
        name: root.value("name").unwrap_or("robot").to_owned(),
        links: Vec::new(),
        joints: Vec::new(),
        left_out: Vec::new(),
        place: root.place.clone(),
    };
    attributes(root, ROBOT, "robot", &mut robot.left_out)?;
    text(root, &mut robot.left_out)?;
    let (mut links, mut joints) = (HashSet::new(), HashSet::new());
    for child in &root.children {
        if child.name.starts_with("xacro:") {
            let what = format!("<{}>", child.name);
            let reason = "expand the file first: `xacro model.urdf.xacro > model.urdf`";
            let fault = ModelFault::Unsupported { what, reason };
            return Err(ModelFileError::Model { fault, place: child.place.clone() });
        }
        if !part(child, "robot", ROBOT_PARTS, &mut robot.left_out)? {
            continue;
        }
        if child.name == "link" {
            let link = link(child, &mut robot.left_out)?;
            unique("link", &link.name, &mut links, child)?;
            robot.links.push(link);
        } else {
            let joint = joint(child, &mut robot.left_out)?;
            unique("joint", &joint.name, &mut joints, child)?;
            robot.joints.push(joint);
        }
    }
    Ok(robot)
}

/// Looks a child up as [`judge`] does; an element of another name space is another program's and is listed.
fn part(
    child: &Element,
    parent: &str,
    parts: &'static [Part],
    left_out: &mut Vec<LeftOut>,
) -> Result<bool, ModelFileError> {
    let fault = match child.name.as_str() {
        "drake:joint" => "it moves a link in a way that URDF has no word for",
        name if name.contains(':') => {
            left_out.push(LeftOut {
                what: child.title(),
                reason: "an extension of another program",
                effect: Effect::Physics,
                missing: None,
                place: child.place.clone(),
            });
            return Ok(false);
        }
        _ => return judge(child, parent, parts, left_out),
    };
    let fault = ModelFault::Unsupported { what: format!("<{}>", child.name), reason: fault };
    Err(ModelFileError::Model { fault, place: child.place.clone() })
}

fn unique(
    kind: &'static str,
    name: &str,
    earlier: &mut HashSet<String>,
    element: &Element,
) -> Result<(), ModelFileError> {
    if earlier.insert(name.to_owned()) {
        return Ok(());
    }
    let fault = ModelFault::DuplicateName { kind, name: name.to_owned() };
    Err(ModelFileError::Model { fault, place: element.place.clone() })
}

fn missing(element: &Element, needed: &'static str) -> ModelFileError {
    let fault = ModelFault::Missing { element: element.title(), needed };
    ModelFileError::Model { fault, place: element.place.clone() }
}

fn name(element: &Element) -> Result<String, ModelFileError> {
    let name = element.value("name").filter(|n| !n.is_empty());
    name.map(str::to_owned).ok_or_else(|| missing(element, "a `name`"))
}

/// The only child of this name.
fn only<'a>(element: &'a Element, child: &'a str) -> Result<Option<&'a Element>, ModelFileError> {
    let mut all = element.children_named(child);
    let first = all.next();
    match all.next() {
        None => Ok(first),
        Some(second) => {
            let fault = ModelFault::Twice { element: child.to_owned(), parent: element.title() };
            Err(ModelFileError::Model { fault, place: second.place.clone() })
        }
    }
}

/// Checks an element that has only attributes.
fn leaf(
    element: &Element,
    words: &'static [Word],
    left_out: &mut Vec<LeftOut>,
) -> Result<(), ModelFileError> {
    attributes(element, words, &element.name, left_out)?;
    for child in &element.children {
        judge(child, &element.name, &[], left_out)?;
    }
    Ok(())
}

/// `<origin>` of an element: roll, pitch and yaw turn about fixed x, y, z, so R = Rz Ry Rx.
fn origin(element: &Element, left_out: &mut Vec<LeftOut>) -> Result<Transform, ModelFileError> {
    let Some(origin) = only(element, "origin")? else { return Ok(Transform::identity()) };
    leaf(origin, ORIGIN, left_out)?;
    let r = Reader::new(origin);
    let at = r.vector("xyz")?.unwrap_or_default();
    let turn = match (r.vector("rpy")?, r.array::<4>("quat_xyzw")?) {
        (Some(_), Some(_)) => {
            let attributes = vec!["rpy", "quat_xyzw"];
            return Err(r.fault("quat_xyzw", ModelFault::Exclusive { element: "origin".into(), attributes }));
        }
        (Some(rpy), None) => EulerOrder::ZYX.to_quat(&Vec3::new(rpy.z, rpy.y, rpy.x)),
        (None, Some([x, y, z, w])) => {
            let q = Quaternion::new(w, x, y, z);
            if q.norm() < 1e-10 || !q.norm().is_finite() {
                return Err(r.bounds("quat_xyzw", "a quaternion, not all zeros"));
            }
            Quat::new_normalize(q)
        }
        (None, None) => Quat::identity(),
    };
    Ok(Transform::from_parts(Translation3::from(at), turn))
}

fn link(element: &Element, left_out: &mut Vec<LeftOut>) -> Result<RobotLink, ModelFileError> {
    attributes(element, LINK, &element.title(), left_out)?;
    let name = name(element)?;
    let mut geoms = Vec::new();
    for child in &element.children {
        let listed = left_out.len();
        if part(child, "link", LINK_PARTS, left_out)? {
            if child.name == "collision" {
                geoms.extend(collision(child, &name, left_out)?);
            }
        } else {
            left_out[listed].what = format!("link `{name}`: {}", child.title());
        }
    }
    let inertial = only(element, "inertial")?.map(|i| inertial(i, left_out)).transpose()?;
    Ok(RobotLink { name, inertial, geoms, place: element.place.clone() })
}

fn inertial(element: &Element, left_out: &mut Vec<LeftOut>) -> Result<FileInertial, ModelFileError> {
    attributes(element, NONE, "inertial", left_out)?;
    for child in &element.children {
        judge(child, "inertial", INERTIAL_PARTS, left_out)?;
    }
    let pose = origin(element, left_out)?;
    let mass = only(element, "mass")?.ok_or_else(|| missing(element, "<mass>"))?;
    leaf(mass, &[("value", Use::Read)], left_out)?;
    let kilograms = Reader::new(mass).number("value")?.ok_or_else(|| missing(mass, "`value`"))?;
    let inertia = only(element, "inertia")?.ok_or_else(|| missing(element, "<inertia>"))?;
    leaf(inertia, INERTIA, left_out)?;
    let r = Reader::new(inertia);
    let diagonal = |name: &str| -> Result<f64, ModelFileError> {
        r.number(name)?.ok_or_else(|| missing(inertia, "`ixx`, `iyy` and `izz`"))
    };
    let product = |name: &str| r.number(name).map(Option::unwrap_or_default);
    let (xx, yy, zz) = (diagonal("ixx")?, diagonal("iyy")?, diagonal("izz")?);
    let (xy, xz, yz) = (product("ixy")?, product("ixz")?, product("iyz")?);
    let matrix = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    Ok(FileInertial { mass: kilograms, pose, inertia: matrix, place: element.place.clone() })
}

fn collision(
    element: &Element,
    link: &str,
    left_out: &mut Vec<LeftOut>,
) -> Result<Option<FileGeom>, ModelFileError> {
    match solid(element, link, left_out)? {
        Solid::Shape(shape, pose) => Ok(Some(FileGeom {
            name: element.value("name").map(str::to_owned),
            shape,
            pose,
            weight: Weight::Mass(0.0),
            counts: false,
            collides: true,
            friction: FRICTION,
            place: element.place.clone(),
        })),
        Solid::Mesh { missing } => {
            left_out.push(LeftOut {
                what: format!("link `{link}`: {}", element.title()),
                reason: if missing.is_some() { "mesh, and its file does not exist" } else { "mesh" },
                effect: Effect::Physics,
                missing,
                place: element.place.clone(),
            });
            Ok(None)
        }
    }
}

enum Solid {
    Shape(FileShape, Transform),
    Mesh { missing: Option<PathBuf> },
}

fn solid(element: &Element, link: &str, left_out: &mut Vec<LeftOut>) -> Result<Solid, ModelFileError> {
    attributes(element, &[("name", Use::Read), ("group", Use::Look("look"))], &element.name, left_out)?;
    for child in &element.children {
        let listed = left_out.len();
        if !part(child, &element.name, SOLID_PARTS, left_out)? {
            left_out[listed].what = format!("link `{link}`: {}", child.title());
        }
    }
    let pose = origin(element, left_out)?;
    let geometry = only(element, "geometry")?.ok_or_else(|| missing(element, "<geometry>"))?;
    attributes(geometry, &[("name", Use::Look("look"))], "geometry", left_out)?;
    for child in &geometry.children {
        judge(child, "geometry", GEOMETRY_PARTS, left_out)?;
    }
    let [shape] = geometry.children.as_slice() else {
        return Err(missing(geometry, "one shape: <box>, <cylinder>, <sphere>, <capsule> or <mesh>"));
    };
    let r = Reader::new(shape);
    let length = |name: &'static str, needed: &'static str| -> Result<f64, ModelFileError> {
        let x = r.number(name)?.ok_or_else(|| missing(shape, needed))?;
        if x > 0.0 { Ok(x) } else { Err(r.bounds(name, "positive")) }
    };
    let (radius, long) = (|| length("radius", "`radius`"), || length("length", "`length`"));
    const ROUND: &[Word] = &[("radius", Use::Read), ("length", Use::Read)];
    Ok(match shape.name.as_str() {
        "box" => {
            leaf(shape, &[("size", Use::Read)], left_out)?;
            let half = r.vector("size")?.ok_or_else(|| missing(shape, "`size`"))? / 2.0;
            if half.min() <= 0.0 {
                return Err(r.bounds("size", "positive"));
            }
            Solid::Shape(FileShape::Box { half }, pose)
        }
        "sphere" => {
            leaf(shape, &[("radius", Use::Read)], left_out)?;
            Solid::Shape(FileShape::Sphere { radius: radius()? }, pose)
        }
        "cylinder" => {
            leaf(shape, ROUND, left_out)?;
            Solid::Shape(FileShape::Cylinder { radius: radius()?, half: long()? / 2.0 }, pose)
        }
        "capsule" => {
            leaf(shape, ROUND, left_out)?;
            Solid::Shape(FileShape::Capsule { radius: radius()?, half: long()? / 2.0 }, pose)
        }
        _ => {
            leaf(shape, &[("filename", Use::Read), ("scale", Use::Read)], left_out)?;
            let file = shape.attribute("filename").ok_or_else(|| missing(shape, "`filename`"))?;
            Solid::Mesh { missing: missing_mesh(file) }
        }
    })
}

/// Where a mesh file would be, if it is nowhere to be found.
///
/// `package://name/rest` is looked for as `rest` and as `name/rest` beside the file and in the folders above it.
fn missing_mesh(file: &Attribute) -> Option<PathBuf> {
    let folder = file.place.file.parent().unwrap_or(Path::new(""));
    let value = file.value.strip_prefix("file://").unwrap_or(&file.value);
    let Some(inside) = value.strip_prefix("package://").or_else(|| value.strip_prefix("model://")) else {
        let path = folder.join(value);
        return (!path.is_file()).then_some(path);
    };
    let rest = inside.split_once('/').map_or(inside, |(_, rest)| rest);
    let found = folder.ancestors().any(|f| f.join(rest).is_file() || f.join(inside).is_file());
    (!found).then(|| PathBuf::from(&file.value))
}

fn joint(element: &Element, left_out: &mut Vec<LeftOut>) -> Result<RobotJoint, ModelFileError> {
    attributes(element, JOINT, &element.title(), left_out)?;
    let name = name(element)?;
    for child in &element.children {
        let listed = left_out.len();
        if !part(child, "joint", JOINT_PARTS, left_out)? {
            left_out[listed].what = format!("joint `{name}`: {}", child.title());
        }
    }
    let r = Reader::new(element);
    const TYPES: [&str; 6] = ["fixed", "revolute", "continuous", "prismatic", "floating", "planar"];
    let kind = TYPES[r.word("type", &TYPES)?.ok_or_else(|| missing(element, "a `type`"))?];
    if kind == "planar" {
        let reason = "write two prismatic joints and a continuous one, with massless links between them";
        return Err(r.fault("type", ModelFault::Unsupported { what: "a planar joint".into(), reason }));
    }
    let origin = origin(element, left_out)?;
    let end = |tag: &'static str, needed: &'static str| -> Result<Attribute, ModelFileError> {
        let end = only(element, tag)?.ok_or_else(|| missing(element, needed))?;
        end.attribute("link").cloned().ok_or_else(|| missing(end, "`link`"))
    };
    let (parent, child) = (end("parent", "<parent>")?, end("child", "<child>")?);
    for tag in ["parent", "child"] {
        if let Some(end) = only(element, tag)? {
            leaf(end, &[("link", Use::Read)], left_out)?;
        }
    }
    let axis = match only(element, "axis")? {
        Some(axis) => {
            leaf(axis, &[("xyz", Use::Read)], left_out)?;
            let r = Reader::new(axis);
            if matches!(kind, "fixed" | "floating") { None } else { r.direction("xyz")? }
        }
        None => None,
    };
    let mut range = None;
    match only(element, "limit")? {
        Some(limit) => {
            let listed = left_out.len();
            leaf(limit, LIMIT, left_out)?;
            left_out[listed..]
                .iter_mut()
                .for_each(|item| item.what = format!("joint `{name}`: {}", item.what));
            let r = Reader::new(limit);
            let end = |name: &str| r.number(name).map(Option::unwrap_or_default);
            let (lo, hi) = (end("lower")?, end("upper")?);
            if matches!(kind, "revolute" | "prismatic") {
                if lo > hi {
                    return Err(r.bounds("lower", "at most `upper`"));
                }
                if lo < hi {
                    range = Some(Range::new(lo, hi));
                } else {
                    left_out.push(LeftOut {
                        what: format!("joint `{name}`: limit"),
                        reason: "a range without width, taken as no limit",
                        effect: Effect::Physics,
                        missing: None,
                        place: limit.place.clone(),
                    });
                }
            }
        }
        None if matches!(kind, "revolute" | "prismatic") => {
            return Err(missing(element, "<limit>; a hinge without is `continuous`"));
        }
        None => {}
    }
    let mut damping = 0.0;
    // the second is the word of an old format for the first
    for tag in ["dynamics", "joint_properties"] {
        let Some(dynamics) = only(element, tag)? else { continue };
        let listed = left_out.len();
        leaf(dynamics, DYNAMICS, left_out)?;
        left_out[listed..].iter_mut().for_each(|item| item.what = format!("joint `{name}`: {}", item.what));
        damping = Reader::new(dynamics).number("damping")?.unwrap_or(damping);
    }
    let kind = match kind {
        "fixed" => RobotJointKind::Fixed,
        "prismatic" => RobotJointKind::Slide,
        "floating" => RobotJointKind::Floating,
        _ => RobotJointKind::Hinge,
    };
    let axis = axis.unwrap_or(Vec3::x());
    Ok(RobotJoint { name, kind, origin, parent, child, axis, range, damping, place: element.place.clone() })
}
