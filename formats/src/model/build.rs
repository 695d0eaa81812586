//! Links, joints, shapes and sites from the bodies of a model file.
//!
//! In: a [`ModelFile`]. Out: [`Imported`], before the decision whether what was left out is acceptable.
//! Frames: see the header of [`super`].

use std::collections::HashSet;
use std::sync::Arc;

use crate::limits::BODIES;
use crate::model_file::{
    Effect, FileGeom, FileJoint, FileJointKind, FileShape, Format, LeftOut, ModelFault, ModelFile,
    ModelFileError,
};
use crate::place::Place;
use motion::rotation::{between, exp};
use motion::{Floor, Joint, Limits, Link, Quat, Shape, Site, Skeleton, Transform, Vec3};
use nalgebra::{Point3, Translation3};

use super::mass::{MassOf, check_axes, masses, title};
use super::{ImportError, Imported, ImportedJoint};
use bodies::{Body, Character, JointClass};

/// Greatest limit a skeleton takes, rad or m.
const LIMIT_BOUND: f64 = 1e4;

struct Builder<'a> {
    file: &'a ModelFile,
    masses: Vec<MassOf>,
    names: HashSet<String>,
    links: Vec<Link>,
    bodies: Vec<Body>,
    sites: Vec<Site>,
    joints: Vec<ImportedJoint>,
    /// Per joint: its body and its place among the body's joints.
    origin: Vec<(usize, usize)>,
    /// Rest values of the joints so far.
    rest: Vec<f64>,
    left_out: Vec<LeftOut>,
    /// Per body: its link and the position of the link's origin in the body's frame.
    link_of: Vec<Option<(usize, Vec3)>>,
}

/// Builds the character. Nothing is refused for having been left out.
pub fn build(file: &ModelFile) -> Result<Imported, ImportError> {
    let (up, gravity) = match file.gravity.norm() {
        g if g > 0.0 => (-file.gravity, Vec3::new(0.0, -g, 0.0)),
        _ => (Vec3::z(), Vec3::zeros()),
    };
    let ours_from_file = between(&up, &Vec3::y());
    let scenery = file.format == Format::Mjcf;
    let tops: Vec<usize> = (0..file.bodies.len()).filter(|&i| file.bodies[i].parent == Some(0)).collect();
    let place = file.bodies[0].place.clone();
    let mut moving = 0;
    for body in &file.bodies {
        moving += 1 + body.joints.len();
        if moving > BODIES {
            let fault = ModelFault::TooMany { what: "bodies and joints", limit: BODIES };
            return Err(ModelFileError::Model { fault, place: body.place.clone() }.into());
        }
    }
    if scenery && tops.is_empty() {
        return Err(ImportError::Empty { place });
    }
    let free_root = scenery
        && tops.len() == 1
        && file.bodies[tops[0]].joints.first().is_some_and(|j| j.kind == FileJointKind::Free);
    let mut left_out = file.left_out.clone();
    let mut b = Builder {
        file,
        masses: masses(file, !scenery, &mut left_out)?,
        names: HashSet::new(),
        links: Vec::new(),
        bodies: Vec::new(),
        sites: Vec::new(),
        joints: Vec::new(),
        origin: Vec::new(),
        rest: Vec::new(),
        left_out,
        link_of: vec![None; file.bodies.len()],
    };
    // names of the file come first, so that made-up ones give way
    b.names.extend(file.bodies.iter().filter_map(|body| body.name.clone()));
    b.base(scenery, free_root);
    for at in 1..file.bodies.len() {
        b.body(at);
    }
    // the world's axes are the zero frame of the root
    let turn = Transform::from_parts(Translation3::identity(), ours_from_file);
    b.links[0].parent_from_zero = turn * b.links[0].parent_from_zero;
    let classes =
        (0..b.links.len()).map(|i| if i == 0 { JointClass::Root } else { JointClass::Other }).collect();
    let (rest, ground) = (b.rest()?, ground(file, &ours_from_file));
    let skeleton = Skeleton::new(b.links)
        .and_then(|s| s.with_sites(b.sites))
        .map_err(|source| ImportError::Skeleton { source, place: place.clone() })?;
    let character = Character {
        name: file.name.clone(),
        skeleton: Arc::new(skeleton),
        bodies: b.bodies,
        classes,
        contacts: Vec::new(),
        rest,
    };
    check_axes(file, &character, &b.joints, &b.origin)?;
    let character = character.check().map_err(|source| ImportError::Character { source, place })?;
    Ok(Imported {
        character,
        joints: b.joints,
        bodies: b.link_of.iter().map(|at| at.map(|(link, _)| link)).collect(),
        format: file.format,
        gravity,
        ground,
        ours_from_file,
        left_out: b.left_out,
    })
}

/// The plane of the world on which a body can stand: the highest under the origin, if there are several.
fn ground(file: &ModelFile, ours_from_file: &Quat) -> Option<Floor> {
    let planes = file.bodies[0].geoms.iter().filter(|g| g.shape == FileShape::Plane && g.collides);
    let floors = planes.filter_map(|g| {
        let up = ours_from_file * (g.pose.rotation * Vec3::z());
        let at = ours_from_file * g.pose.translation.vector;
        // a turn and back leaves some roundings of a level plane
        let up = if (up - Vec3::y()).norm() < 1e-12 { Vec3::y() } else { up };
        (up.y > 0.1).then(|| Floor { up, ..Floor::level(at.dot(&up) / up.y, g.friction) })
    });
    floors.max_by(|a, b| a.height_m.total_cmp(&b.height_m))
}

impl Builder<'_> {
    /// The rest pose: that of the file's own, or what it says.
    fn rest(&self) -> Result<Vec<f64>, ImportError> {
        let Some((given, place)) = &self.file.rest else { return Ok(self.rest.clone()) };
        let fault = |fault| Err(ModelFileError::Model { fault, place: place.clone() }.into());
        let attribute = || "`qpos` of key `rest`".to_owned();
        if given.len() != self.rest.len() {
            let (found, needed) = (given.len(), format!("{}, those of all joints", self.rest.len()));
            return fault(ModelFault::NumberCount { attribute: attribute(), found, needed });
        }
        let (mut q, mut at) = (given.clone(), 0);
        for joint in &self.joints {
            let kind = self.links[joint.link].joint;
            if let Joint::Free | Joint::Spherical = kind {
                let turn = at + kind.nq() - 4;
                let r = nalgebra::Vector4::from_column_slice(&q[turn..turn + 4]);
                if r.norm() < 1e-10 {
                    let allowed = "values of which each quaternion has a length";
                    return fault(ModelFault::OutOfBounds {
                        attribute: attribute(),
                        found: "zero".into(),
                        allowed,
                    });
                }
                // one written to be read back stays what it is, to the bit
                if (r.norm() - 1.0).abs() > 1e-12 {
                    q[turn..turn + 4].copy_from_slice(r.normalize().as_slice());
                }
            }
            at += kind.nq();
        }
        Ok(q)
    }

    /// The base: scenery is listed, a root link is a link.
    fn base(&mut self, scenery: bool, free_root: bool) {
        let file = self.file;
        let base = &file.bodies[0];
        if scenery {
            for geom in &base.geoms {
                self.leave_out_appearance(&geom_title(geom), "scenery", &geom.place);
            }
        }
        if free_root {
            for site in &base.sites {
                self.leave_out_appearance(&format!("site `{}`", site.name), "scenery", &site.place);
            }
            return;
        }
        self.names.remove("world"); // the base's own name
        let name = title(file, 0);
        self.names.insert(name.clone());
        self.links.push(Link::new(name, None, Vec3::zeros(), Joint::Fixed));
        self.link_of[0] = Some((0, Vec3::zeros()));
        self.fill(0, 0, Vec3::zeros(), !scenery);
    }

    /// A body: one link per joint, one if it is welded.
    fn body(&mut self, at: usize) {
        let file = self.file;
        let body = &file.bodies[at];
        let parent = body.parent.and_then(|p| self.link_of[p]);
        // where the body is drawn, in the parent link's frame
        let shift = parent.map_or(Vec3::zeros(), |(_, origin)| origin);
        let pose = Transform::from_parts(
            Translation3::from(body.pose.translation.vector - shift),
            body.pose.rotation,
        );
        let mut parent = parent.map(|(link, _)| link);
        let name = match &body.name {
            Some(name) => name.clone(),
            None => self.unused(format!("body{at}")),
        };
        let (mut anchor, mut frame) = (Vec3::zeros(), pose);
        if body.joints.is_empty() {
            self.push(name, parent, pose, Joint::Fixed);
        } else {
            for (k, joint) in body.joints.iter().enumerate() {
                let zero = frame * Translation3::from(joint.pos - anchor) * reference(joint);
                let zero = if joint.kind == FileJointKind::Free { Transform::identity() } else { zero };
                let last = k + 1 == body.joints.len();
                let link_name = match (&joint.name, last) {
                    (_, true) => name.clone(),
                    (Some(name), false) => self.unused(name.clone()),
                    (None, false) => self.unused(format!("{name}_joint{k}")),
                };
                let link = self.push(link_name.clone(), parent, zero, kind(joint));
                self.joint(at, k, joint, link, link_name, &body.pose);
                (parent, anchor, frame) = (Some(link), joint.pos, Transform::identity());
                if !last {
                    self.bodies.push(massless());
                }
            }
        }
        let link = self.links.len() - 1;
        self.link_of[at] = Some((link, anchor));
        self.fill(at, link, anchor, true);
    }

    fn push(&mut self, name: String, parent: Option<usize>, zero: Transform, joint: Joint) -> usize {
        let mut link = Link::new(name, parent, Vec3::zeros(), joint);
        link.parent_from_zero = zero;
        self.links.push(link);
        self.links.len() - 1
    }

    /// Records a joint: its name, limits and rest value.
    fn joint(
        &mut self,
        at: usize,
        k: usize,
        joint: &FileJoint,
        link: usize,
        fallback: String,
        pose: &Transform,
    ) {
        self.joints.push(ImportedJoint {
            name: joint.name.clone().unwrap_or(fallback),
            link,
            armature: joint.armature,
        });
        self.origin.push((at, k));
        if let Some(range) = joint.range {
            if range.lo >= -LIMIT_BOUND && range.hi <= LIMIT_BOUND {
                self.links[link].limits = Some(Limits::Axis(range));
            } else {
                let what = format!("joint `{}`: range", self.joints[self.joints.len() - 1].name);
                self.leave_out_appearance(&what, "a range beyond ±1e4 rad or m", &joint.place);
            }
        }
        let r = pose.rotation;
        match joint.kind {
            FileJointKind::Free => {
                self.rest.extend(pose.translation.vector.iter());
                self.rest.extend([r.w, r.i, r.j, r.k]);
            }
            FileJointKind::Ball => self.rest.extend([1.0, 0.0, 0.0, 0.0]),
            FileJointKind::Hinge | FileJointKind::Slide => self.rest.push(joint.reference),
        }
    }

    /// Gives a link the mass, shapes and sites of a body; `anchor` is the link's origin in the body's frame.
    fn fill(&mut self, at: usize, link: usize, anchor: Vec3, shapes: bool) {
        let body = &self.file.bodies[at];
        let (mass, com, inertia) = self.masses[at];
        let com = if mass > 0.0 { com - anchor } else { Vec3::zeros() };
        let mut filled = Body { mass, com, inertia, shapes: Vec::new() };
        if shapes {
            for geom in &body.geoms {
                match shape(geom, &anchor) {
                    Some(shape) if geom.collides => filled.shapes.push(shape),
                    Some(_) => self.leave_out_appearance(
                        &geom_title(geom),
                        "collides with nothing, not drawn",
                        &geom.place,
                    ),
                    None if geom.shape == FileShape::Mesh => self.left_out.push(LeftOut {
                        what: geom_title(geom),
                        reason: "mesh",
                        effect: Effect::Physics,
                        missing: None,
                        place: geom.place.clone(),
                    }),
                    None => {
                        let what = format!("{} ({})", geom_title(geom), geom.shape.word());
                        self.leave_out_appearance(&what, "weighed, not drawn", &geom.place);
                    }
                }
            }
        }
        self.bodies.push(filled);
        for site in &body.sites {
            self.sites.push(Site { name: site.name.clone(), link, at: site.pos - anchor });
        }
    }

    fn leave_out_appearance(&mut self, what: &str, reason: &'static str, place: &Place) {
        self.left_out.push(LeftOut {
            what: what.to_owned(),
            reason,
            effect: Effect::Look,
            missing: None,
            place: place.clone(),
        });
    }

    /// `wanted`, or with a number behind it if that name is taken.
    fn unused(&mut self, wanted: String) -> String {
        let mut name = wanted.clone();
        let mut n = 2;
        while !self.names.insert(name.clone()) {
            name = format!("{wanted}_{n}");
            n += 1;
        }
        name
    }
}

fn geom_title(geom: &FileGeom) -> String {
    geom.name.as_ref().map_or_else(|| "geom".to_owned(), |name| format!("geom `{name}`"))
}

fn massless() -> Body {
    Body { mass: 0.0, com: Vec3::zeros(), inertia: nalgebra::Matrix3::zeros(), shapes: Vec::new() }
}

fn kind(joint: &FileJoint) -> Joint {
    match joint.kind {
        FileJointKind::Free => Joint::Free,
        FileJointKind::Ball => Joint::Spherical,
        FileJointKind::Hinge => Joint::Revolute(joint.axis),
        FileJointKind::Slide => Joint::Prismatic(joint.axis),
    }
}

/// Zero frame from the frame at the reference value: the motion of −`reference`.
fn reference(joint: &FileJoint) -> Transform {
    match joint.kind {
        FileJointKind::Hinge if joint.reference != 0.0 => {
            Transform::from_parts(Translation3::identity(), exp(&(joint.axis * -joint.reference)))
        }
        FileJointKind::Slide => {
            Transform::from_parts(Translation3::from(joint.axis * -joint.reference), Quat::identity())
        }
        _ => Transform::identity(),
    }
}

/// The geom as one of our shapes in the link's frame.
fn shape(geom: &FileGeom, anchor: &Vec3) -> Option<Shape> {
    let center = geom.pose.translation.vector - anchor;
    let point = |z: f64| (geom.pose * Point3::new(0.0, 0.0, z)).coords - anchor;
    Some(match geom.shape {
        FileShape::Sphere { radius } => Shape::Sphere { center, radius },
        FileShape::Capsule { radius, half } => Shape::Capsule { a: point(-half), b: point(half), radius },
        FileShape::Box { half } => Shape::Box { center, half, rotation: geom.pose.rotation },
        _ => return None,
    })
}
