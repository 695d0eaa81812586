//! Blocking: a clip as a script of a few key poses, which a person goes on with.
//!
//! In: the take of a clip. Out: two texts, a scene and the character it is of, and what was done in words. The scene has one
//! action of poses ([`motion::fit::blocking`]) with their times in comments; a pose sets what is not where the last one
//! put it. No foot is planted: legs are keyed like all else, and slide between keys until somebody plants them.

use std::fmt::Write;

use bodies::Character;
use motion::fit::blocking::{Blocking, KeyPose, LEAST_S};
use motion::metrics::{joint_errors, joint_rms_deg, position_rms_mm};
use motion::script::{Action, Cycle, Pose, PoseValue, Properties, Script};
use motion::{Clip, Dof, Joint, Skeleton, Value};
use scenes::angle::deg_from_quat;
use scenes::character_file;

use crate::Take;

/// A value that is nearer to the one before is not written, rad or m.
const SAME: f64 = 2e-3;

/// A clip as key poses.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockedScene {
    /// The scene's file.
    pub scene: String,
    /// The file of its character, beside it.
    pub character: String,
    /// Key poses, the first frame among them.
    pub poses: usize,
    /// Length, s.
    pub duration_s: f64,
    /// RMS angle of the joints between the script and the clip, degrees.
    pub rms_deg: f64,
    /// RMS distance of the links, mm.
    pub rms_mm: f64,
}

/// Why a clip has no blocking.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BlockingError {
    /// Two joints of one name, or the like: a script that cannot be.
    #[error(transparent)]
    Script(#[from] motion::ScriptError),
}

/// Blocks the motion asked of a take. `character` is the name of the file of the character, beside that of the scene; `from` says
/// where the motion came from.
///
/// # Errors
/// [`BlockingError`].
pub fn block(take: &Take, character: &str, from: &str) -> Result<BlockedScene, BlockingError> {
    let (clip, body) = (&take.asked.clip, take.character());
    let blocking = Blocking::of(clip);
    let poses = poses(clip, body, &blocking.keys);
    let script = Script {
        actions: vec![Action {
            name: "motion".into(),
            cycles: vec![Cycle { poses: poses.clone(), ..Cycle::default() }],
            ..Action::default()
        }],
        ..Script::default()
    };
    let tracks = script.build(&clip.skeleton, &body.rest)?;
    let played = tracks.sample(clip.rate_hz);
    let errors = joint_errors(&played, clip);
    Ok(BlockedScene {
        scene: text(take, character, from, &blocking.keys, &poses),
        character: character_file::write(body, &format!("The body of {from}.")),
        poses: blocking.keys.len(),
        duration_s: clip.duration_s(),
        rms_deg: joint_rms_deg(&errors),
        rms_mm: position_rms_mm(&played, clip),
    })
}

/// The poses, with numbers as they are written.
fn poses(clip: &Clip, body: &Character, keys: &[KeyPose]) -> Vec<Pose> {
    let s = &clip.skeleton;
    let mut now = body.rest.clone();
    let mut before_s = 0.0;
    let pose = |key: &KeyPose| {
        let at_s = key.frame as f64 / clip.rate_hz;
        let mut values = Vec::new();
        for dof in Dof::all(s) {
            let value = rounded(s, body, dof, &dof.read(s, clip.pose(key.frame)));
            if value.distance(&dof.read(s, &now)) > SAME {
                dof.write(s, &mut now, &value);
                values.push(PoseValue { dof: dof.name(s), value, properties: Properties::default() });
            }
        }
        let duration_s = thousandths(at_s) - thousandths(before_s);
        before_s = at_s;
        let properties =
            Properties { curve: Some(key.curve), duration_s: Some(duration_s), ..Properties::default() };
        Pose { properties, values }
    };
    keys.iter().map(pose).collect()
}

fn thousandths(x: f64) -> f64 {
    (1e3 * x).round() / 1e3
}

/// Lengths are relative to rest in a scene.
fn rest(s: &Skeleton, body: &Character, dof: Dof) -> f64 {
    dof.read(s, &body.rest).scalar().unwrap_or(0.0)
}

/// Angles to a tenth of a degree, lengths to a millimetre.
fn rounded(s: &Skeleton, body: &Character, dof: Dof, value: &Value) -> Value {
    match value {
        Value::Rotation(r) => {
            Value::Rotation(scenes::angle::quat_from_deg(deg_from_quat(r).map(|x| (10.0 * x).round() / 10.0)))
        }
        Value::Scalar(x) if is_hinge(s, dof) => {
            Value::Scalar(((10.0 * x.to_degrees()).round() / 10.0).to_radians())
        }
        Value::Scalar(x) => Value::Scalar(rest(s, body, dof) + thousandths(x - rest(s, body, dof))),
    }
}

fn is_hinge(s: &Skeleton, dof: Dof) -> bool {
    matches!(dof, Dof::Axis(link) if matches!(s.links()[link].joint, Joint::Revolute(_)))
}

/// A number without needless digits.
fn short(x: f64, digits: usize) -> String {
    let text = format!("{x:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.into() }
}

fn text(take: &Take, character: &str, from: &str, keys: &[KeyPose], poses: &[Pose]) -> String {
    let (clip, body) = (&take.asked.clip, take.character());
    let s = &clip.skeleton;
    let mut out = String::new();
    // writing into a String cannot fail
    let _ = write!(
        out,
        "// Blocking of {from}: {} key poses in {:.2} s, never nearer than {LEAST_S} s. Edit them, add others, plant feet.
// Angles are degrees, (x, y, z) of balls; lengths are metres beside the rest pose. `contrapposto inspect` lists all joints.
Scene(
    character: {character:?},
    rate_hz: {},
    root: Pinned, // legs are keyed; with feet planted it may be Free
    planted: [],
    settle_s: 0,
    script: [
        Action(name: \"motion\", cycles: [Cycle(poses: [
",
        keys.len(),
        clip.duration_s(),
        short(clip.rate_hz.clamp(1.0, 1000.0), 6),
    );
    for (key, pose) in keys.iter().zip(poses) {
        let p = &pose.properties;
        let at_s = key.frame as f64 / clip.rate_hz;
        let _ = writeln!(out, "            // {at_s:.3} s");
        let _ = write!(out, "            Pose(duration_s: {}", short(p.duration_s.unwrap_or(0.0), 3));
        if let Some(curve) = p.curve.filter(|_| key.frame > 0) {
            let _ = write!(out, ", curve: {curve}");
        }
        let (mut degrees, mut metres) = (Vec::new(), Vec::new());
        for v in &pose.values {
            match (&v.value, Dof::find(s, &v.dof)) {
                (Value::Rotation(r), _) => {
                    let [x, y, z] = deg_from_quat(r).map(|x| short(x, 1));
                    degrees.push(format!("{:?}: ({x}, {y}, {z})", v.dof));
                }
                (Value::Scalar(x), Some(dof)) if is_hinge(s, dof) => {
                    degrees.push(format!("{:?}: {}", v.dof, short(x.to_degrees(), 1)));
                }
                (Value::Scalar(x), Some(dof)) => {
                    metres.push(format!("{:?}: {}", v.dof, short(x - rest(s, body, dof), 3)));
                }
                (Value::Scalar(_), None) => {}
            }
        }
        for (field, values) in [("set_m", metres), ("set_deg", degrees)] {
            if values.is_empty() {
                continue;
            }
            let _ = write!(out, ",\n                {field}: {{");
            for line in values.chunks(4) {
                let _ = write!(out, "\n                    {},", line.join(", "));
            }
            out += "\n                }";
        }
        out += "),\n";
    }
    out += "        ])]),\n    ],\n)\n";
    out
}
