//! Bodies of an MJCF: joints, inertias, geoms, sites.
//!
//! In: `<worldbody>`. Out: bodies in depth-first order, everything in the frame of its body, angles in radians;
//! a `<frame>` is worked into what stands in it.

use nalgebra::{Matrix3, Point3, Translation3};

use super::orientation::orientation;
use super::schema;
use super::tree::{FromGeoms, Tree};
use crate::attributes::Reader;
use crate::model_file::{
    Effect, FileBody, FileGeom, FileInertial, FileJoint, FileJointKind, FileShape, FileSite, LeftOut,
    ModelFault, ModelFileError, Weight,
};
use crate::place::Place;
use crate::vocabulary;
use crate::xml::Element;
use motion::rotation::{Vec3, between};
use motion::{Range, Transform};

impl Tree {
    /// The world and all its bodies.
    pub(super) fn world(&mut self, root: &Element) -> Result<(), ModelFileError> {
        let place = root.children_named("worldbody").next().map_or(&root.place, |w| &w.place).clone();
        self.bodies.push(FileBody {
            name: Some("world".into()),
            parent: None,
            pose: Transform::identity(),
            joints: Vec::new(),
            inertial: None,
            geoms_first: false,
            geoms: Vec::new(),
            sites: Vec::new(),
            place,
        });
        for section in root.children_named("worldbody") {
            vocabulary::attributes(section, &[], "worldbody", &mut self.left_out)?;
            self.content(section, 0, 0, &Transform::identity())?;
        }
        Ok(())
    }

    fn body(
        &mut self,
        element: &Element,
        parent: usize,
        class: usize,
        frame: &Transform,
    ) -> Result<(), ModelFileError> {
        vocabulary::attributes(element, schema::BODY, &element.title(), &mut self.left_out)?;
        let pose = frame * self.pose(&Reader::new(element))?;
        let class = self.childclass(element, class)?;
        let at = self.bodies.len();
        self.bodies.push(FileBody {
            name: name(element),
            parent: Some(parent),
            pose,
            joints: Vec::new(),
            inertial: None,
            geoms_first: self.compiler.from_geoms == FromGeoms::Always,
            geoms: Vec::new(),
            sites: Vec::new(),
            place: element.place.clone(),
        });
        self.content(element, at, class, &Transform::identity())?;
        let body = &self.bodies[at];
        if let Some(free) = body.joints.iter().find(|j| j.kind == FileJointKind::Free)
            && (parent != 0 || body.joints.len() > 1)
        {
            return Err(ModelFileError::Model { fault: ModelFault::FreeJoint, place: free.place.clone() });
        }
        Ok(())
    }

    /// Children of the body `at`, in a `<frame>` of it or directly; `frame` is its pose in the body.
    fn content(
        &mut self,
        element: &Element,
        at: usize,
        class: usize,
        frame: &Transform,
    ) -> Result<(), ModelFileError> {
        let parts = if element.name == "frame" { schema::IN_FRAME } else { schema::IN_BODY };
        for child in &element.children {
            if !vocabulary::judge(child, &element.name, parts, &mut self.left_out)? {
                continue;
            }
            let unexpected = |what: &str, reason| {
                let fault = ModelFault::Unsupported { what: format!("{what} in <worldbody>"), reason };
                Err(ModelFileError::Model { fault, place: child.place.clone() })
            };
            match child.name.as_str() {
                "body" => self.body(child, at, class, frame)?,
                "frame" => {
                    vocabulary::attributes(child, schema::FRAME, "frame", &mut self.left_out)?;
                    let inner = frame * self.pose(&Reader::new(child))?;
                    self.content(child, at, self.childclass(child, class)?, &inner)?;
                }
                "joint" | "freejoint" if at == 0 => {
                    return unexpected(
                        &format!("<{}>", child.name),
                        "the world does not move; put it in a <body>",
                    );
                }
                "inertial" if at == 0 => return unexpected("<inertial>", "the world has no mass"),
                "joint" => {
                    vocabulary::attributes(child, schema::JOINT, &child.title(), &mut self.left_out)?;
                    let attributes = self.classes.resolve(child, class)?;
                    let mut joint = self.joint(&Reader::with(child, &attributes))?;
                    joint.pos = (frame * Point3::from(joint.pos)).coords;
                    joint.axis = frame.rotation * joint.axis;
                    self.bodies[at].joints.push(joint);
                }
                "freejoint" => {
                    vocabulary::attributes(child, schema::FREEJOINT, &child.title(), &mut self.left_out)?;
                    let joint = free(name(child), &child.place);
                    self.bodies[at].joints.push(joint);
                }
                "inertial" => {
                    vocabulary::attributes(child, schema::INERTIAL, "inertial", &mut self.left_out)?;
                    let inertial = self.inertial(&Reader::new(child))?;
                    if element.children_named("inertial").count() > 1 {
                        let (element, parent) = ("inertial".into(), element.title());
                        let fault = ModelFault::Twice { element, parent };
                        return Err(ModelFileError::Model { fault, place: child.place.clone() });
                    }
                    self.bodies[at].inertial = Some(inertial);
                }
                "geom" => {
                    let mut unread = Vec::new(); // scenery is listed whole
                    vocabulary::attributes(child, schema::GEOM, &child.title(), &mut unread)?;
                    if at > 0 {
                        self.left_out.append(&mut unread);
                    }
                    let attributes = self.classes.resolve(child, class)?;
                    let mut geom = self.geom(&Reader::with(child, &attributes), at == 0)?;
                    geom.pose = frame * geom.pose;
                    self.bodies[at].geoms.push(geom);
                }
                _ => self.site(child, at, class, frame)?,
            }
        }
        Ok(())
    }

    fn joint(&mut self, r: &Reader) -> Result<FileJoint, ModelFileError> {
        use FileJointKind::{Ball, Free, Hinge, Slide};
        let kind = r.word("type", &["hinge", "slide", "ball", "free"])?.unwrap_or(0);
        let kind = [Hinge, Slide, Ball, Free][kind];
        let unit = if kind == Slide { 1.0 } else { self.compiler.angles.unit };
        let axis = r.direction("axis")?.unwrap_or(Vec3::z());
        let pos = r.vector("pos")?.unwrap_or_default();
        let reference = r.number("ref")?.unwrap_or(0.0) * unit;
        let range = self.range(r, kind)?.map(|[lo, hi]| Range::new(lo * unit, hi * unit));
        let scalar = matches!(kind, Hinge | Slide);
        if let Some(range) = range.filter(|_| kind == Ball) {
            self.left_out.push(LeftOut {
                what: format!("{}: range, a cone of {:.6}°", r.title, range.hi.to_degrees()),
                reason: "limit of a ball joint",
                effect: Effect::Physics,
                missing: None,
                place: r.get("range").map_or(r.place, |a| &a.place).clone(),
            });
        }
        Ok(FileJoint {
            name: r.get("name").map(|a| a.value.clone()).filter(|n| !n.is_empty()),
            kind,
            pos: if kind == Free { Vec3::zeros() } else { pos },
            axis,
            range: range.filter(|_| scalar),
            reference: if scalar { reference } else { 0.0 },
            armature: r.number("armature")?.unwrap_or(0.0),
            damping: r.number("damping")?.unwrap_or(0.0),
            stiffness: r.number("stiffness")?.unwrap_or(0.0),
            place: r.place.clone(),
        })
    }

    /// The range of a limited joint, in units of the file.
    fn range(&self, r: &Reader, kind: FileJointKind) -> Result<Option<[f64; 2]>, ModelFileError> {
        let limited = r.word("limited", &["false", "true", "auto"])?.unwrap_or(2);
        let range = r.array::<2>("range")?;
        if kind == FileJointKind::Free || limited == 0 {
            return Ok(None);
        }
        match range {
            None if limited == 1 => Err(r.fault(
                "limited",
                ModelFault::Missing { element: r.title.clone(), needed: "`range`, as it is limited" },
            )),
            None | Some([0.0, 0.0]) if limited == 2 => Ok(None),
            Some(_) if limited == 2 && !self.compiler.auto_limits => Err(r.fault(
                "range",
                ModelFault::Missing {
                    element: r.title.clone(),
                    needed: "`limited`, as it has a range and autolimits is off",
                },
            )),
            Some([lo, hi]) if lo < hi => Ok(range),
            _ => Err(r.bounds("range", "two numbers, the lower first")),
        }
    }

    fn inertial(&self, r: &Reader) -> Result<FileInertial, ModelFileError> {
        let missing = |needed| r.fault("", ModelFault::Missing { element: "inertial".into(), needed });
        let pos = r.vector("pos")?.ok_or_else(|| missing("`pos`"))?;
        let mass = r.number("mass")?.ok_or_else(|| missing("`mass`"))?;
        let inertia = match (r.array::<3>("diaginertia")?, r.array::<6>("fullinertia")?) {
            (Some(d), None) => Matrix3::from_diagonal(&Vec3::from(d)),
            (None, Some([xx, yy, zz, xy, xz, yz])) => Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
            (None, None) => return Err(missing("`diaginertia` or `fullinertia`")),
            (Some(_), Some(_)) => {
                let attributes = vec!["diaginertia", "fullinertia"];
                let fault = ModelFault::Exclusive { element: "inertial".into(), attributes };
                return Err(r.fault("fullinertia", fault));
            }
        };
        if r.get("fullinertia").is_some()
            && let Some(other) = super::defaults::ORIENTATIONS.into_iter().find(|o| r.get(o).is_some())
        {
            let attributes = vec!["fullinertia", other];
            return Err(r.fault(other, ModelFault::Exclusive { element: "inertial".into(), attributes }));
        }
        let pose = Transform::from_parts(Translation3::from(pos), orientation(r, &self.compiler.angles)?);
        Ok(FileInertial { mass, pose, inertia, place: r.place.clone() })
    }

    fn geom(&self, r: &Reader, on_world: bool) -> Result<FileGeom, ModelFileError> {
        const TYPES: [&str; 9] =
            ["sphere", "capsule", "cylinder", "box", "ellipsoid", "plane", "hfield", "mesh", "sdf"];
        let kind = TYPES[r.word("type", &TYPES)?.unwrap_or(0)];
        if let Some(mesh) = r.get("mesh").filter(|_| kind != "mesh") {
            let what = format!("{kind} fitted to mesh `{}`", mesh.value);
            let reason = "meshes are not read; write its size, pos and quat";
            return Err(r.fault("mesh", ModelFault::Unsupported { what, reason }));
        }
        if matches!(kind, "plane" | "hfield") && !on_world {
            let reason = "it has no mass and no end; only geoms of the world may be one";
            return Err(
                r.fault("type", ModelFault::Unsupported { what: format!("a {kind} on a body"), reason })
            );
        }
        let (mut pose, mut sizes) = (self.pose(r)?, r.numbers("size")?.unwrap_or_default());
        if sizes.len() > 3 {
            return Err(r.count("size", sizes.len(), "1 to 3".into()));
        }
        if let Some([a, b, c, d, e, f]) = r.array("fromto")? {
            let (from, to) = (Vec3::new(a, b, c), Vec3::new(d, e, f));
            if !matches!(kind, "capsule" | "cylinder" | "box" | "ellipsoid") {
                let reason = "`fromto` is for capsules, cylinders, boxes and ellipsoids";
                return Err(r.fault(
                    "fromto",
                    ModelFault::Unsupported { what: format!("a {kind} from here to there"), reason },
                ));
            }
            if pose.translation.vector != Vec3::zeros() {
                let attributes = vec!["fromto", "pos"];
                let fault = ModelFault::Exclusive { element: r.title.clone(), attributes };
                return Err(r.fault("fromto", fault));
            }
            let half = (from - to).norm() / 2.0;
            if half < 1e-10 || !half.is_finite() {
                return Err(r.bounds("fromto", "two different points"));
            }
            let middle = (from + to) / 2.0;
            pose = Transform::from_parts(Translation3::from(middle), between(&Vec3::z(), &(from - to)));
            let Some(&first) = sizes.first() else {
                return Err(
                    r.fault("size", ModelFault::Missing { element: r.title.clone(), needed: "`size`" })
                );
            };
            sizes = match kind {
                "box" | "ellipsoid" => vec![first, first, half],
                _ => vec![first, half],
            };
        }
        let shape = self.shape(r, kind, &sizes)?;
        let mass = r.number("mass")?;
        let density = r.number("density")?.unwrap_or(1000.0);
        for (name, value) in [("mass", mass.unwrap_or(0.0)), ("density", density)] {
            if value < 0.0 {
                return Err(r.bounds(name, "0 or more"));
            }
        }
        let group = r.number("group")?.unwrap_or(0.0);
        let [lo, hi] = self.compiler.groups;
        let bits = |name: &str| r.number(name).map(|n| n.unwrap_or(1.0) != 0.0);
        Ok(FileGeom {
            name: r.get("name").map(|a| a.value.clone()).filter(|n| !n.is_empty()),
            shape,
            pose,
            weight: mass.map_or(Weight::Density(density), Weight::Mass),
            counts: self.compiler.from_geoms != FromGeoms::Never && (lo..=hi).contains(&group),
            collides: bits("contype")? | bits("conaffinity")?,
            friction: r.numbers("friction")?.and_then(|f| f.first().copied()).unwrap_or(1.0),
            place: r.place.clone(),
        })
    }

    fn shape(&self, r: &Reader, kind: &str, sizes: &[f64]) -> Result<FileShape, ModelFileError> {
        let needed = match kind {
            "sphere" => 1,
            "capsule" | "cylinder" => 2,
            "box" | "ellipsoid" => 3,
            _ => 0,
        };
        if sizes.len() < needed {
            let element = format!("{}, a {kind},", r.title);
            let needed = ["", "1 size", "2 sizes", "3 sizes"][needed];
            return Err(r.fault("size", ModelFault::Missing { element, needed }));
        }
        if sizes[..needed].iter().any(|&s| s <= 0.0) {
            return Err(r.bounds("size", "positive"));
        }
        let half = || Vec3::new(sizes[0], sizes[1], sizes[2]);
        Ok(match kind {
            "sphere" => FileShape::Sphere { radius: sizes[0] },
            "capsule" => FileShape::Capsule { radius: sizes[0], half: sizes[1] },
            "cylinder" => FileShape::Cylinder { radius: sizes[0], half: sizes[1] },
            "box" => FileShape::Box { half: half() },
            "ellipsoid" => FileShape::Ellipsoid { half: half() },
            "plane" => FileShape::Plane,
            "hfield" => FileShape::HeightField,
            _ => FileShape::Mesh,
        })
    }

    fn site(
        &mut self,
        element: &Element,
        at: usize,
        class: usize,
        frame: &Transform,
    ) -> Result<(), ModelFileError> {
        let mut unread = Vec::new();
        vocabulary::attributes(element, schema::SITE, &element.title(), &mut unread)?;
        let attributes = self.classes.resolve(element, class)?;
        let r = Reader::with(element, &attributes);
        orientation(&r, &self.compiler.angles)?;
        let pos = match r.array::<6>("fromto")? {
            Some([a, b, c, d, e, f]) => (Vec3::new(a, b, c) + Vec3::new(d, e, f)) / 2.0,
            None => r.vector("pos")?.unwrap_or_default(),
        };
        let place = element.place.clone();
        match name(element) {
            Some(name) => {
                let pos = (frame * Point3::from(pos)).coords;
                self.bodies[at].sites.push(FileSite { name, pos, place });
                self.left_out.append(&mut unread);
            }
            None => self.left_out.push(LeftOut {
                what: "site without a name".into(),
                reason: "look",
                effect: Effect::Look,
                missing: None,
                place,
            }),
        }
        Ok(())
    }

    fn pose(&self, r: &Reader) -> Result<Transform, ModelFileError> {
        let pos = r.vector("pos")?.unwrap_or_default();
        Ok(Transform::from_parts(Translation3::from(pos), orientation(r, &self.compiler.angles)?))
    }

    /// The class of elements inside `element` that name none.
    fn childclass(&self, element: &Element, class: usize) -> Result<usize, ModelFileError> {
        element.attribute("childclass").map_or(Ok(class), |name| self.classes.find(name))
    }
}

fn name(element: &Element) -> Option<String> {
    element.value("name").filter(|n| !n.is_empty()).map(str::to_owned)
}

fn free(name: Option<String>, place: &Place) -> FileJoint {
    FileJoint {
        name,
        kind: FileJointKind::Free,
        pos: Vec3::zeros(),
        axis: Vec3::z(),
        range: None,
        reference: 0.0,
        armature: 0.0,
        damping: 0.0,
        stiffness: 0.0,
        place: place.clone(),
    }
}
