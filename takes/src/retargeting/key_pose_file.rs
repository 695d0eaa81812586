//! Key poses as RON: frames of performances paired with poses of a character.
//!
//! In: a file that names performances (scenes or BVH clips, relative to it) and, for a moment of each, the pose
//! of the character in degrees. Out: checked [`KeyPoses`]. A joint that a pose does not name is as at rest. The
//! character is put on the ground: its lowest contact point is at height 0, or `flight_m` above.
//!
//! ```ron
//! KeyPoses(
//!     performances: { "anger": "../performances/anger.ron" },
//!     poses: [
//!         Pose(of: "anger", at_s: 2.4, set_deg: { "lower": -50, "upper": 120, "shade": (-40, 0, 10) }),
//!     ],
//! )
//! ```

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use bodies::Character;
use formats::bvh::ImportOptions;
use motion::{Joint, Kinematics};
use retarget::key_poses::{KeyPose, KeyPoses};
use retarget::{Puppet, RetargetError};
use serde::Deserialize;

use crate::opening::Opening;

use super::{Performance, RetargetingError};
use scenes::angle::{deg_from_quat, quat_from_deg};
use scenes::{Angle, SceneError, Source};

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "KeyPoses")]
struct KeyPosesRon {
    performances: BTreeMap<String, String>,
    poses: Vec<PoseRon>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Pose")]
struct PoseRon {
    of: String,
    at_s: f64,
    #[serde(default)]
    flight_m: f64,
    #[serde(default)]
    set_deg: BTreeMap<String, Angle>,
}

/// A file of key poses, read.
#[derive(Clone, Debug)]
pub struct KeyPoseFile {
    /// The pairs.
    pub key_poses: KeyPoses,
    /// For each pair its performance and moment, s.
    pub moments: Vec<(String, f64)>,
    /// The performances by name.
    pub performances: BTreeMap<String, Performance>,
    /// The file.
    pub path: PathBuf,
}

/// Highest jump of a key pose, m.
const HIGHEST: f64 = 10.0;
/// Angle by which a pose may lie beyond a joint limit and be taken as on it: what rounding to a tenth of a degree
/// on three axes makes of an angle, rad.
const SLACK: f64 = 0.0026;

/// As [`KeyPoseFile::open`], because of other files.
pub(crate) fn read(path: &Path, puppet: &Puppet, by: &Opening) -> Result<KeyPoseFile, RetargetingError> {
    let source = Source::read(path)?;
    let opening = &by.within(path)?;
    let ron: KeyPosesRon = source.parse()?;
    let mut performances = BTreeMap::new();
    for (name, file) in &ron.performances {
        let at = format!("performances{{\"{name}\"}}");
        if !ron.poses.iter().any(|p| p.of == *name) {
            continue;
        }
        let beside = source.beside(&at, "performance", file)?;
        let mut performance = Performance::opened_by(opening, &beside, None, &ImportOptions::default())
            .map_err(|e| source.error(&at, format!("performance `{name}`: {e}")))?;
        performance.make_counterparts(puppet);
        performances.insert(name.clone(), performance);
    }
    let reader = Reader { source: &source, character: &puppet.character, performances: &performances };
    let mut key_poses = KeyPoses::default();
    let mut names = HashMap::new();
    for (i, ron_pose) in ron.poses.iter().enumerate() {
        let mut pair = reader.pair(i, ron_pose, &ron.performances)?;
        let first = *names.entry(pair.name.clone()).or_insert(i);
        if first != i {
            pair.name += &format!(" (pose {})", i + 1); // the same moment: told apart by the checks below
        }
        key_poses.pairs.push(pair);
    }
    key_poses.check(puppet).map_err(|e| place(&source, &key_poses, &ron, e))?;
    let moments = ron.poses.iter().map(|p| (p.of.clone(), p.at_s)).collect();
    Ok(KeyPoseFile { key_poses, moments, performances, path: path.into() })
}

/// A fault of the pairs as a whole, at the pair that has it.
fn place(source: &Source, pairs: &KeyPoses, ron: &KeyPosesRon, e: RetargetError) -> RetargetingError {
    let of = |name: &str| pairs.pairs.iter().position(|p| p.name == name);
    let at = match &e {
        RetargetError::Duplicate { second, .. } | RetargetError::Contradiction { second, .. } => {
            of(second).map(|i| format!("poses[{i}]"))
        }
        RetargetError::MarkersMissing { whose, .. } => {
            of(whose).map(|i| format!("performances{{\"{}\"}}", ron.poses[i].of))
        }
        RetargetError::TooFewKeyPoses { .. } => Some("poses".into()),
        _ => None,
    };
    source.error(&at.unwrap_or_default(), e.to_string()).into()
}

struct Reader<'a> {
    source: &'a Source,
    character: &'a Character,
    performances: &'a BTreeMap<String, Performance>,
}

impl Reader<'_> {
    fn pair(
        &self,
        i: usize,
        ron: &PoseRon,
        known: &BTreeMap<String, String>,
    ) -> Result<KeyPose, RetargetingError> {
        let name = format!("{} at {} s", ron.of, ron.at_s);
        let place = |field: &str| format!("poses[{i}].{field}");
        let Some(performance) = self.performances.get(&ron.of) else {
            let known = known.keys().map(String::as_str);
            return Err(self
                .source
                .unknown(&place("of"), "performance", &ron.of, " in a key pose", known)
                .into());
        };
        let clip = &performance.clip;
        let frame = (ron.at_s * clip.rate_hz).round();
        if !(frame >= 0.0 && frame < clip.frames() as f64) {
            let e = format!(
                "`{}` has no frame at {} s; its {} frames at {} Hz run from 0 to {:.3} s",
                ron.of,
                ron.at_s,
                clip.frames(),
                clip.rate_hz,
                clip.duration_s()
            );
            return Err(self.source.error(&place("at_s"), e).into());
        }
        if !(0.0..=HIGHEST).contains(&ron.flight_m) {
            let e = format!("flight_m is {}; allowed: 0 to {HIGHEST} m above the ground", ron.flight_m);
            return Err(self.source.error(&place("flight_m"), e).into());
        }
        let pose = self.pose(i, ron)?;
        let (performer, ground) = (&performance.performer, performance.ground_m);
        KeyPose::of_frame(&name, &ron.of, performer, clip, frame as usize, ground, pose)
            .map_err(|e| self.source.error(&place("of"), e.to_string()).into())
    }

    /// The character's pose, on the ground.
    fn pose(&self, i: usize, ron: &PoseRon) -> Result<Vec<f64>, SceneError> {
        let skeleton = &self.character.skeleton;
        let mut q = self.character.rest.clone();
        for (name, angle) in &ron.set_deg {
            let at = format!("poses[{i}].set_deg{{\"{name}\"}}");
            let joints = skeleton.links().iter().filter(|l| l.joint != Joint::Fixed);
            let names = joints.map(|l| l.name.as_str());
            let link = skeleton
                .link(name)
                .filter(|&l| skeleton.links()[l].joint != Joint::Fixed)
                .ok_or_else(|| self.source.unknown(&at, "joint", name, " in a key pose", names))?;
            let numbers: &[f64] = match angle {
                Angle::One(x) => &[*x],
                Angle::Ball(xyz) => xyz,
            };
            if !numbers.iter().all(|x| x.is_finite()) {
                return Err(self.source.error(&at, format!("the angle of `{name}` is not finite")));
            }
            match (angle, skeleton.links()[link].joint) {
                (Angle::One(x), Joint::Revolute(_)) => q[skeleton.q_at(link)] = x.to_radians(),
                (Angle::One(x), Joint::Prismatic(_)) => q[skeleton.q_at(link)] = *x,
                (Angle::Ball(xyz), Joint::Free | Joint::Spherical) => {
                    skeleton.set_rotation(&mut q, link, &quat_from_deg(*xyz));
                }
                (_, joint) => {
                    let wants = match joint {
                        Joint::Revolute(_) => "one angle in degrees",
                        Joint::Prismatic(_) => "one distance in metres",
                        _ => "(x, y, z) in degrees",
                    };
                    let e = format!("the value of `{name}` does not fit its joint, which takes {wants}");
                    return Err(self.source.error(&at, e));
                }
            }
            self.within_limits(&at, link, &mut q)?;
        }
        stand(self.character, &mut q, ron.flight_m);
        Ok(q)
    }

    fn within_limits(&self, at: &str, link: usize, q: &mut [f64]) -> Result<(), SceneError> {
        let skeleton = &self.character.skeleton;
        let asked = q.to_vec();
        skeleton.clamp_to_limits(q);
        let (found, nearest) = match skeleton.links()[link].joint {
            Joint::Spherical => {
                let (a, b) = (skeleton.rotation(&asked, link), skeleton.rotation(q, link));
                if a.angle_to(&b) <= SLACK {
                    return Ok(());
                }
                let text = |r| {
                    let [x, y, z] = deg_from_quat(r);
                    format!("({x:.1}, {y:.1}, {z:.1})°")
                };
                (text(&a), text(&b))
            }
            Joint::Revolute(_) => {
                let (a, b) = (asked[skeleton.q_at(link)], q[skeleton.q_at(link)]);
                if (a - b).abs() <= SLACK {
                    return Ok(());
                }
                (format!("{:.1}°", a.to_degrees()), format!("{:.1}°", b.to_degrees()))
            }
            _ => return Ok(()),
        };
        let name = &skeleton.links()[link].name;
        Err(self
            .source
            .error(at, format!("`{name}` at {found} is beyond its limits; the nearest allowed is {nearest}")))
    }
}

/// Moves the root up or down so that the lowest contact point is `height` above the ground at 0.
pub fn stand(character: &Character, q: &mut [f64], height: f64) {
    let skeleton = &character.skeleton;
    let k = Kinematics::new(skeleton, q);
    let sites = character.contacts.iter().map(|&c| &skeleton.sites()[c]);
    let lowest = sites.map(|s| k.point(s.link, &s.at).y).fold(f64::INFINITY, f64::min);
    if lowest.is_finite() {
        let mut p = skeleton.position(q, 0);
        p.y += height - lowest;
        skeleton.set_position(q, 0, &p);
    }
}

/// A pose as the line of a key-pose file that makes it, with all joints that differ from rest.
pub fn line(character: &Character, of: &str, at_s: f64, q: &[f64]) -> String {
    let skeleton = &character.skeleton;
    let number = |x: f64| {
        let text = format!("{x:.1}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        if text == "-0" { "0".to_owned() } else { text.to_owned() }
    };
    let mut joints = Vec::new();
    for (i, link) in skeleton.links().iter().enumerate() {
        let value = |q: &[f64]| match link.joint {
            Joint::Free | Joint::Spherical => {
                let [x, y, z] = deg_from_quat(&skeleton.rotation(q, i)).map(number);
                Some(format!("({x}, {y}, {z})"))
            }
            Joint::Revolute(_) => Some(number(q[skeleton.q_at(i)].to_degrees())),
            Joint::Prismatic(_) => Some(format!("{:.4}", q[skeleton.q_at(i)])),
            Joint::Fixed => None,
        };
        if let Some(text) = value(q).filter(|t| Some(t) != value(&character.rest).as_ref()) {
            joints.push(format!("\"{}\": {text}", link.name));
        }
    }
    let k = Kinematics::new(skeleton, q);
    let sites = character.contacts.iter().map(|&c| &skeleton.sites()[c]);
    let lowest = sites.map(|s| k.point(s.link, &s.at).y).fold(f64::INFINITY, f64::min);
    let flight = match lowest.is_finite() && lowest > 5e-3 {
        true => format!("flight_m: {lowest:.3}, "),
        false => String::new(),
    };
    format!("Pose(of: \"{of}\", at_s: {at_s}, {flight}set_deg: {{ {} }}),", joints.join(", "))
}
