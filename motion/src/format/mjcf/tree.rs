//! Sections and bodies of an MJCF, from the expanded tree.
//!
//! In: the root element without includes. Out: a [`ModelFile`]. Settings of `compiler` and `option` hold for
//! the whole file wherever they stand, and the last one wins; defaults are read before bodies.

use std::path::{Path, PathBuf};

use nalgebra::{Matrix3, Translation3};

use super::defaults::Classes;
use super::orientation::{Angles, orientation};
use super::schema;
use crate::format::attributes::Reader;
use crate::format::model_file::{
    Effect, FileBody, FileGeom, FileInertial, FileJoint, FileJointKind, FileShape, FileSite, Format, LeftOut,
    ModelFault, ModelFile, ModelFileError, Weight,
};
use crate::format::vocabulary::{self, Fate, Part, Word};
use crate::format::xml::{Element, Place};
use crate::rotation::{Vec3, between};
use crate::{Range, Transform};

/// Where inertia comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum FromGeoms {
    Never,
    Always,
    Auto,
}

/// Settings of `<compiler>`.
struct Compiler {
    angles: Angles,
    auto_limits: bool,
    from_geoms: FromGeoms,
    groups: [f64; 2],
    total_mass: Option<f64>,
    mesh_folder: PathBuf,
    strip_path: bool,
}

struct Tree {
    compiler: Compiler,
    classes: Classes,
    bodies: Vec<FileBody>,
    left_out: Vec<LeftOut>,
}

/// Reads the tree; `stem` is the name of a model that has none.
pub fn read(root: &Element, stem: &str) -> Result<ModelFile, ModelFileError> {
    let mut left_out = Vec::new();
    vocabulary::attributes(root, schema::MUJOCO, "mujoco", &mut left_out)?;
    for section in &root.children {
        vocabulary::judge(section, "mujoco", schema::SECTIONS, &mut left_out)?;
    }
    let compiler = compiler(root, &mut left_out)?;
    let gravity = gravity(root, &mut left_out)?;
    let mut classes = Classes::new();
    for section in root.children_named("default") {
        vocabulary::attributes(section, schema::DEFAULT, "default", &mut left_out)?;
        classes.add(section, &mut |setting, class| {
            if vocabulary::judge(setting, "default", schema::SETTINGS_IN_DEFAULT, &mut left_out)? {
                let title = format!("default class `{class}`, {}", setting.name);
                vocabulary::attributes(setting, words(&setting.name), &title, &mut left_out)?;
            } else if let Some(last) = left_out.last_mut() {
                last.what = format!("default class `{class}`, {}", setting.name);
            }
            Ok(())
        })?;
    }
    let mut tree = Tree { compiler, classes, bodies: Vec::new(), left_out };
    for section in &root.children {
        match section.name.as_str() {
            "compiler" | "option" | "default" | "worldbody" | "size" | "statistic" => {}
            name => tree.section(section, schema::section_parts(name))?,
        }
    }
    tree.world(root)?;
    unique(&tree.bodies)?;
    Ok(ModelFile {
        format: Format::Mjcf,
        name: root.value("model").map_or_else(|| stem.to_owned(), str::to_owned),
        gravity,
        total_mass: tree.compiler.total_mass,
        bodies: tree.bodies,
        left_out: tree.left_out,
    })
}

fn words(element: &str) -> &'static [Word] {
    match element {
        "geom" => schema::GEOM,
        "joint" => schema::JOINT,
        "site" => schema::SITE,
        _ => &[],
    }
}

fn compiler(root: &Element, left_out: &mut Vec<LeftOut>) -> Result<Compiler, ModelFileError> {
    let mut c = Compiler {
        angles: Angles { unit: std::f64::consts::PI / 180.0, sequence: [(0, false), (1, false), (2, false)] },
        auto_limits: true,
        from_geoms: FromGeoms::Auto,
        groups: [0.0, 5.0],
        total_mass: None,
        mesh_folder: PathBuf::new(),
        strip_path: false,
    };
    let (mut assets, mut meshes) = (PathBuf::new(), None);
    for element in root.children_named("compiler") {
        vocabulary::attributes(element, schema::COMPILER, "compiler", left_out)?;
        for child in &element.children {
            vocabulary::judge(
                child,
                "compiler",
                &[("lengthrange", Fate::Listed(Effect::Physics, "actuator"))],
                left_out,
            )?;
        }
        let r = Reader::new(element);
        if let Some(word) = r.word("angle", &["degree", "radian"])? {
            c.angles.unit = if word == 0 { std::f64::consts::PI / 180.0 } else { 1.0 };
        }
        if let Some(1) = r.word("coordinate", &["local", "global"])? {
            let reason = "MuJoCo itself gave it up; use local coordinates";
            return Err(r.fault(
                "coordinate",
                ModelFault::Unsupported { what: "coordinate=\"global\"".into(), reason },
            ));
        }
        if let Some(attribute) = r.get("eulerseq") {
            let axes: Vec<(usize, bool)> = attribute
                .value
                .chars()
                .filter_map(|ch| Some(("xyz".find(ch.to_ascii_lowercase())?, ch.is_ascii_uppercase())))
                .collect();
            c.angles.sequence = match <[_; 3]>::try_from(axes) {
                Ok(sequence) if attribute.value.len() == 3 => sequence,
                _ => {
                    let allowed = "three letters of xyz (axes that turn along) or XYZ (fixed axes)";
                    return Err(r.bounds("eulerseq", allowed));
                }
            };
        }
        if let Some(word) = r.word("inertiafromgeom", &["false", "true", "auto"])? {
            c.from_geoms = [FromGeoms::Never, FromGeoms::Always, FromGeoms::Auto][word];
        }
        c.auto_limits = r.flag("autolimits")?.unwrap_or(c.auto_limits);
        c.strip_path = r.flag("strippath")?.unwrap_or(c.strip_path);
        c.groups = r.array("inertiagrouprange")?.unwrap_or(c.groups);
        if let Some(mass) = r.number("settotalmass")? {
            c.total_mass = (mass > 0.0).then_some(mass); // MuJoCo: −1 leaves masses as they are
        }
        r.flag("fusestatic")?;
        r.flag("discardvisual")?;
        if let Some(folder) = r.get("assetdir") {
            assets = PathBuf::from(&folder.value);
        }
        if let Some(folder) = r.get("meshdir") {
            meshes = Some(PathBuf::from(&folder.value));
        }
    }
    c.mesh_folder = meshes.unwrap_or(assets);
    Ok(c)
}

fn gravity(root: &Element, left_out: &mut Vec<LeftOut>) -> Result<Vec3, ModelFileError> {
    let mut gravity = Vec3::new(0.0, 0.0, -9.81);
    let mut on = true;
    for element in root.children_named("option") {
        vocabulary::attributes(element, schema::OPTION, "option", left_out)?;
        gravity = Reader::new(element).vector("gravity")?.unwrap_or(gravity);
        for child in &element.children {
            vocabulary::judge(child, "option", &[("flag", Fate::Taken)], left_out)?;
            vocabulary::attributes(child, schema::FLAG, "flag", left_out)?;
            let r = Reader::new(child);
            on = r.word("gravity", &["disable", "enable"])?.map_or(on, |i| i == 1);
        }
    }
    Ok(if on { gravity } else { Vec3::zeros() })
}

impl Tree {
    /// A section nothing but meshes is read of: its items are listed.
    fn section(&mut self, section: &Element, parts: &'static [Part]) -> Result<(), ModelFileError> {
        for child in &section.children {
            if vocabulary::judge(child, &section.name, parts, &mut self.left_out)? {
                self.mesh(child);
            } else if let Some(item) = self.left_out.last_mut() {
                item.what = format!("{}: {}", section.name, child.title());
            }
        }
        Ok(())
    }

    /// A mesh: listed, and whether its file is there.
    fn mesh(&mut self, mesh: &Element) {
        let missing = mesh.attribute("file").and_then(|file| {
            let name = Path::new(&file.value);
            let name = if self.compiler.strip_path { Path::new(name.file_name()?) } else { name };
            let beside = file.place.file.parent().unwrap_or(Path::new(""));
            let path = beside.join(&self.compiler.mesh_folder).join(name);
            (!path.is_file()).then_some(path)
        });
        self.left_out.push(LeftOut {
            what: format!("asset: {}", mesh.title()),
            reason: "mesh",
            effect: Effect::Physics,
            missing,
            place: mesh.place.clone(),
        });
    }

    fn world(&mut self, root: &Element) -> Result<(), ModelFileError> {
        let place = root.children_named("worldbody").next().map_or(&root.place, |w| &w.place).clone();
        self.bodies.push(FileBody {
            name: Some("world".into()),
            parent: None,
            pose: Transform::identity(),
            joints: Vec::new(),
            inertial: None,
            geoms: Vec::new(),
            sites: Vec::new(),
            place,
        });
        for section in root.children_named("worldbody") {
            vocabulary::attributes(section, &[], "worldbody", &mut self.left_out)?;
            self.content(section, 0, 0)?;
        }
        Ok(())
    }

    fn body(&mut self, element: &Element, parent: usize, class: usize) -> Result<(), ModelFileError> {
        vocabulary::attributes(element, schema::BODY, &element.title(), &mut self.left_out)?;
        let r = Reader::new(element);
        let pose = Transform::from_parts(
            Translation3::from(r.vector("pos")?.unwrap_or_default()),
            orientation(&r, &self.compiler.angles)?,
        );
        let class = match element.attribute("childclass") {
            Some(name) => self.classes.find(name)?,
            None => class,
        };
        let at = self.bodies.len();
        self.bodies.push(FileBody {
            name: name(element),
            parent: Some(parent),
            pose,
            joints: Vec::new(),
            inertial: None,
            geoms: Vec::new(),
            sites: Vec::new(),
            place: element.place.clone(),
        });
        self.content(element, at, class)?;
        let body = &self.bodies[at];
        if let Some(free) = body.joints.iter().find(|j| j.kind == FileJointKind::Free)
            && (parent != 0 || body.joints.len() > 1)
        {
            return Err(ModelFileError::Model { fault: ModelFault::FreeJoint, place: free.place.clone() });
        }
        Ok(())
    }

    /// Children of the body `at`.
    fn content(&mut self, element: &Element, at: usize, class: usize) -> Result<(), ModelFileError> {
        for child in &element.children {
            if !vocabulary::judge(child, &element.name, schema::IN_BODY, &mut self.left_out)? {
                continue;
            }
            let unexpected = |what: &str, reason| {
                let fault = ModelFault::Unsupported { what: format!("{what} in <worldbody>"), reason };
                Err(ModelFileError::Model { fault, place: child.place.clone() })
            };
            match child.name.as_str() {
                "body" => self.body(child, at, class)?,
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
                    let joint = self.joint(&Reader::with(child, &attributes))?;
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
                    if self.compiler.from_geoms != FromGeoms::Always {
                        self.bodies[at].inertial = Some(inertial);
                    }
                }
                "geom" => {
                    let mut unread = Vec::new(); // scenery is listed whole
                    vocabulary::attributes(child, schema::GEOM, &child.title(), &mut unread)?;
                    if at > 0 {
                        self.left_out.append(&mut unread);
                    }
                    let attributes = self.classes.resolve(child, class)?;
                    let geom = self.geom(&Reader::with(child, &attributes), at == 0)?;
                    self.bodies[at].geoms.push(geom);
                }
                _ => self.site(child, at, class)?,
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

    fn site(&mut self, element: &Element, at: usize, class: usize) -> Result<(), ModelFileError> {
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

/// Names must be unique among bodies, among joints and among sites.
fn unique(bodies: &[FileBody]) -> Result<(), ModelFileError> {
    let mut seen = std::collections::HashSet::new();
    let mut check = |kind: &'static str, name: &str, place: &Place| {
        if seen.insert((kind, name.to_owned())) {
            return Ok(());
        }
        let fault = ModelFault::DuplicateName { kind, name: name.to_owned() };
        Err(ModelFileError::Model { fault, place: place.clone() })
    };
    for body in bodies {
        if let Some(name) = &body.name {
            check("body", name, &body.place)?;
        }
        for joint in &body.joints {
            if let Some(name) = &joint.name {
                check("joint", name, &joint.place)?;
            }
        }
        for site in &body.sites {
            check("site", &site.name, &site.place)?;
        }
    }
    Ok(())
}
