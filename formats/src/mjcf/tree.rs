//! Sections and settings of an MJCF, from the expanded tree.
//!
//! In: the root element without includes. Out: a [`ModelFile`]. Settings of `compiler` and `option` hold for
//! the whole file wherever they stand, and the last one wins; defaults are read before bodies.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::defaults::Classes;
use super::include;
use super::orientation::Angles;
use super::schema;
use crate::attributes::Reader;
use crate::model_file::{Effect, FileBody, Format, LeftOut, ModelFault, ModelFile, ModelFileError};
use crate::place::Place;
use crate::vocabulary::{self, Fate, Part, Word};
use crate::xml::Element;
use motion::rotation::Vec3;

/// Where inertia comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FromGeoms {
    Never,
    Always,
    Auto,
}

/// Settings of `<compiler>`.
pub struct Compiler {
    pub angles: Angles,
    pub auto_limits: bool,
    pub from_geoms: FromGeoms,
    pub groups: [f64; 2],
    pub total_mass: Option<f64>,
    pub mesh_folder: PathBuf,
    pub strip_path: bool,
}

/// A file while it is read.
pub struct Tree {
    pub main: Arc<PathBuf>,
    pub compiler: Compiler,
    pub classes: Classes,
    pub bodies: Vec<FileBody>,
    pub rest: Option<(Vec<f64>, Place)>,
    pub left_out: Vec<LeftOut>,
}

/// Reads the tree; `stem` is the name of a model that has none.
pub fn read(root: &Element, stem: &str) -> Result<ModelFile, ModelFileError> {
    let mut left_out = Vec::new();
    vocabulary::attributes(root, schema::MUJOCO, "mujoco", &mut left_out)?;
    vocabulary::text(root, &mut left_out)?;
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
    let (main, bodies) = (root.place.file.clone(), Vec::new());
    let mut tree = Tree { main, compiler, classes, bodies, rest: None, left_out };
    for section in &root.children {
        match section.name.as_str() {
            "compiler" | "option" | "default" | "worldbody" | "size" | "statistic" | "visual" | "custom"
            | "sensor" => {}
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
        rest: tree.rest,
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

/// Gravity of a file that has no word for it, file axes (Z up), m/s²: the default of MuJoCo.
const GRAVITY: Vec3 = Vec3::new(0.0, 0.0, -9.81);

fn gravity(root: &Element, left_out: &mut Vec<LeftOut>) -> Result<Vec3, ModelFileError> {
    let mut gravity = GRAVITY;
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
    /// A key frame: that called `rest` is the rest pose, others are listed.
    fn key(&mut self, key: &Element) -> Result<(), ModelFileError> {
        if key.value("name") == Some("rest") {
            vocabulary::attributes(key, schema::KEY, &key.title(), &mut self.left_out)?;
            let q = Reader::new(key).numbers("qpos")?;
            self.rest = q.map(|q| (q, key.attribute("qpos").map_or(&key.place, |a| &a.place).clone()));
            return Ok(());
        }
        self.left_out.push(LeftOut {
            what: key.title(),
            reason: "state to start from",
            effect: Effect::Look,
            missing: None,
            place: key.place.clone(),
        });
        Ok(())
    }

    /// A section nothing but meshes and a key frame is read of: its items are listed.
    fn section(&mut self, section: &Element, parts: &'static [Part]) -> Result<(), ModelFileError> {
        for child in &section.children {
            if vocabulary::judge(child, &section.name, parts, &mut self.left_out)? {
                match child.name.as_str() {
                    "key" => self.key(child)?,
                    _ => self.mesh(child),
                }
            }
        }
        Ok(())
    }

    /// A mesh: listed, and whether its file is there.
    fn mesh(&mut self, mesh: &Element) {
        let missing = mesh.attribute("file").and_then(|file| {
            let name = Path::new(&file.value);
            let name = if self.compiler.strip_path { Path::new(name.file_name()?) } else { name };
            let name = self.compiler.mesh_folder.join(name);
            match include::find(&self.main, &file.place.file, &name) {
                Some(_) => None,
                None => Some(self.main.parent().unwrap_or(Path::new("")).join(name)),
            }
        });
        self.left_out.push(LeftOut {
            what: mesh.title(),
            reason: "mesh",
            effect: Effect::Physics,
            missing,
            place: mesh.place.clone(),
        });
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
