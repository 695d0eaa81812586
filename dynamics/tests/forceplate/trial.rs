//! Reader of `forceplate-trial/1` files: bodies, poses, measured forces and reference series.

use std::sync::Arc;

use bodies::{Body, Character, JointClass};
use dynamics::analysis::{Contact, SOFT_TISSUE};
use dynamics::{Analysis, AnalysisOptions, FloorChoice, analyze};
use motion::smooth::Smoothing;
use motion::{Clip, Joint, Link, Site, Skeleton, Vec3};
use nalgebra::Matrix3;
use serde_json::Value;

/// Which poses of a file.
#[derive(Clone, Copy, PartialEq)]
pub enum Poses {
    Raw,
    Filtered,
}

impl Poses {
    fn name(self) -> &'static str {
        match self {
            Poses::Raw => "raw",
            Poses::Filtered => "filtered",
        }
    }
}

/// A file and the character built from it.
#[derive(Clone)]
pub struct Trial {
    json: Arc<Value>,
    pub character: Character,
    pub rate_hz: f64,
    /// Frames that count.
    pub valid: Vec<usize>,
    gravity: Vec3,
}

/// Series of the file's reference, `frames`.
pub struct Reference {
    pub force: Vec<Vec3>,
    pub moment: Vec<Vec3>,
    pub com: Vec<Vec3>,
}

impl Trial {
    /// Reads a file of `shared/forceplate`.
    pub fn load(name: &str) -> Self {
        let path = support::shared(&format!("forceplate/{name}.json"));
        let text = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let json: Value = serde_json::from_slice(&text).unwrap();
        assert_eq!(json["schema"], "forceplate-trial/1");
        let rate_hz = number(&json["rate_hz"]);
        // the first and last two frames of a recording are never counted
        let marks: Vec<bool> = list(&json["valid"]).iter().map(|v| number(v) == 1.0).collect();
        let valid = (2..marks.len() - 2).filter(|&k| marks[k]).collect();
        let gravity = vector(&json["frame"]["gravity"]);
        let character = character(name, list(&json["bodies"]));
        Self { json: Arc::new(json), character, rate_hz, valid, gravity }
    }

    /// Body weight, N.
    pub fn weight(&self) -> f64 {
        self.character.mass() * self.gravity.norm()
    }

    /// The motion of the free bodies.
    pub fn clip(&self, poses: Poses) -> Clip {
        let table = list(&self.json[format!("poses_{}", poses.name())]);
        let q = table.iter().flat_map(list).flat_map(list).map(number).collect();
        let mut clip = Clip::new(self.character.skeleton.clone(), self.rate_hz, q);
        for k in 0..clip.frames() {
            for link in 1..self.character.skeleton.links().len() {
                // written to eight digits
                let r = motion::Quat::new_normalize(*self.character.skeleton.rotation(clip.pose(k), link));
                self.character.skeleton.set_rotation(clip.pose_mut(k), link, &r);
            }
        }
        clip
    }

    /// Inverse dynamics by the public road.
    pub fn analysis(&self, poses: Poses, smoothing: Smoothing) -> Analysis {
        self.analysis_assuming(poses, smoothing, SOFT_TISSUE)
    }

    /// The same with another least density of noise, m/√Hz.
    pub fn analysis_assuming(&self, poses: Poses, smoothing: Smoothing, soft_tissue: f64) -> Analysis {
        let gravity = self.gravity;
        let options = AnalysisOptions {
            smoothing,
            soft_tissue,
            gravity,
            ground: FloorChoice::None,
            ..Default::default()
        };
        analyze(&self.character, &self.clip(poses), &options).unwrap()
    }

    /// The same with soles, drawn by hand: the files hold no geometry of the feet. Corners in m along the
    /// body's axes (x forward, z right), at the height of the body's origin, which lies on the sole.
    pub fn analysis_on_soles(&self, poses: Poses, smoothing: Smoothing, ground_velocity: Vec3) -> Analysis {
        let mut character = self.character.clone();
        let mut sites = Vec::new();
        for (body, corners) in [
            ("calcn", [(-0.01, -0.03), (-0.01, 0.03), (0.17, -0.045), (0.17, 0.045)]),
            ("toes", [(0.0, -0.045), (0.0, 0.045), (0.06, -0.03), (0.06, 0.03)]),
        ] {
            for side in ["r", "l"] {
                let link = character.skeleton.link(&format!("{body}_{side}")).unwrap();
                for (i, (x, z)) in corners.iter().enumerate() {
                    sites.push(Site { name: format!("{body}_{side}_{i}"), link, at: Vec3::new(*x, 0.0, *z) });
                }
            }
        }
        character.contacts = (0..sites.len()).collect();
        let skeleton = (*character.skeleton).clone().with_sites(sites).unwrap();
        character.skeleton = Arc::new(skeleton);
        let contact = Contact { ground_velocity, ..Default::default() };
        let options = AnalysisOptions { smoothing, gravity: self.gravity, contact, ..Default::default() };
        analyze(&character, &self.clip(poses), &options).unwrap()
    }

    /// Measured force (N) and centre of pressure (m) of one foot, `right` or `left`.
    pub fn foot(&self, name: &str) -> (Vec<Vec3>, Vec<Vec3>) {
        let feet = list(&self.json["measured"]["feet"]);
        let foot = feet.iter().find(|f| f["name"] == name).unwrap();
        let rows = |key: &str| list(&foot[key]).iter().map(vector).collect();
        (rows("force"), rows("cop"))
    }

    /// Total measured force (N) and its moment about the world's origin (N·m) per frame.
    pub fn measured(&self, filtered: bool) -> (Vec<Vec3>, Vec<Vec3>) {
        let feet = list(&self.json[if filtered { "measured_filtered" } else { "measured" }]["feet"]);
        let frames = list(&feet[0]["force"]).len();
        let (mut force, mut moment) = (vec![Vec3::zeros(); frames], vec![Vec3::zeros(); frames]);
        for foot in feet {
            for k in 0..frames {
                let f = vector(&foot["force"][k]);
                force[k] += f;
                moment[k] += vector(&foot["cop"][k]).cross(&f) + vector(&foot["free_moment"][k]);
            }
        }
        (force, moment)
    }

    /// What OpenSim computes from the same poses.
    pub fn reference(&self, poses: Poses) -> Reference {
        let r = &self.json["reference"][poses.name()];
        let rows = |name: &str| list(&r[name]).iter().map(vector).collect();
        Reference { force: rows("required_force"), moment: rows("required_moment_com"), com: rows("com") }
    }
}

fn character(name: &str, bodies: &[Value]) -> Character {
    let mut links = vec![Link::new("world", None, Vec3::zeros(), Joint::Fixed)];
    let still = Body { mass: 0.0, com: Vec3::zeros(), inertia: Matrix3::zeros(), shapes: Vec::new() };
    let mut masses = vec![still];
    for b in bodies {
        links.push(Link::new(b["name"].as_str().unwrap(), Some(0), Vec3::zeros(), Joint::Free));
        let i: Vec<f64> = list(&b["inertia"]).iter().map(number).collect();
        masses.push(Body {
            mass: number(&b["mass"]),
            com: vector(&b["com"]),
            inertia: Matrix3::new(i[0], i[3], i[4], i[3], i[1], i[5], i[4], i[5], i[2]),
            shapes: Vec::new(),
        });
    }
    let skeleton = Arc::new(Skeleton::new(links).unwrap());
    let rest = skeleton.zero_pose();
    let classes = vec![JointClass::Other; masses.len()];
    Character { name: name.into(), skeleton, bodies: masses, classes, contacts: Vec::new(), rest }
}

fn list(v: &Value) -> &Vec<Value> {
    v.as_array().unwrap()
}

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap()
}

fn vector(v: &Value) -> Vec3 {
    Vec3::new(number(&v[0]), number(&v[1]), number(&v[2]))
}
