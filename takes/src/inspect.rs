//! What is in a file, as plain data that serialises.
//!
//! In: a scene, a character, a clip or a physics model. Out: an [`Inspection`]: names, degrees of freedom, limits and
//! masses of a body; actions, elements and edits of a scene; units, axes and length of a clip. Degrees,
//! metres, kilograms, seconds, each in its field's name.

use std::collections::BTreeMap;
use std::path::Path;

use bodies::anthropometry::{BodyOptions, BodyReport, guess_body_of_clip};
use bodies::{Character, JointClass};
use formats::bvh::{ImportOptions, ImportReport};
use formats::model::{self, Imported};
use formats::model_file::{Effect, Format as ModelFormat};
use motion::names::Word;
use motion::{Clip, Dof, Joint, Kinematics, Limits, Range, Skeleton, Tracks, Value};
use serde::Serialize;

use crate::ask::is_ron;
use crate::results::subject_report::DecidedReport;
use crate::script::{USUAL_FRAMES_HZ, edited_tracks};
use crate::user_programs::{edit_program, reactions};
use crate::{Ask, TakeError};
use edits::EditLog;
use programs::{Entry, Program};
use scenes::angle::deg_from_quat;
use scenes::library::{self, Kind};
use scenes::scene::{self, EditKind, Scene};
use scenes::{SceneError, Source, character_file};

/// What is in a file.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Inspection {
    /// Of a scene.
    Scene(SceneInspection),
    /// Of a character.
    Character(BodyInspection),
    /// Of a clip.
    Clip(ClipInspection),
    /// Of a physics model.
    Model(ModelInspection),
}

/// A body, or a bare skeleton.
#[derive(Clone, Debug, Serialize)]
pub struct BodyInspection {
    /// Its name.
    pub name: String,
    /// Degrees of freedom, root included.
    pub dof: usize,
    /// Mass, kg; `None` of a bare skeleton.
    pub mass_kg: Option<f64>,
    /// Height in the rest (or zero) pose, m: over solids, or over joints of a bare skeleton.
    pub height_m: f64,
    /// Links, parents first.
    pub links: Vec<LinkInspection>,
    /// Points that may touch the ground.
    pub contacts: Vec<String>,
    /// Two-bone limbs: name, and the links of upper bone, lower bone, end.
    pub limbs: BTreeMap<String, [String; 3]>,
    /// Body parts that edits may name, each with its links.
    pub parts: BTreeMap<String, Vec<String>>,
}

/// A physics model: what is read of it, and what is not.
#[derive(Clone, Debug, Serialize)]
pub struct ModelInspection {
    /// `MJCF` or `URDF`.
    pub format: &'static str,
    /// The body.
    pub body: BodyInspection,
    /// Gravity, Y up, m/s².
    pub gravity_m_s2: [f64; 3],
    /// Height of the ground, m; null if the model has none.
    pub ground_m: Option<f64>,
    /// Whether commands that take models need `--dynamics-only`: something that makes forces is not read.
    pub dynamics_only: bool,
    /// What is not read and makes forces, by reason with how often.
    pub forces_left_out: String,
    /// What is not read and makes none, by reason with how often.
    pub looks_left_out: String,
    /// What is not read, item by item with its place.
    pub left_out: Vec<String>,
}

/// A link and its joint.
#[derive(Clone, Debug, Serialize)]
pub struct LinkInspection {
    /// Its name.
    pub name: String,
    /// The link it hangs on.
    pub parent: Option<String>,
    /// Links between it and the root, itself included; 0 for the root.
    pub depth: usize,
    /// `free`, `ball`, `hinge`, `slide` or `fixed`.
    pub joint: &'static str,
    /// Degrees of freedom of the joint.
    pub dof: usize,
    /// What the joint is in the body; `None` of a bare skeleton.
    pub class: Option<String>,
    /// Mass, kg; `None` of a bare skeleton.
    pub mass_kg: Option<f64>,
    /// Limits in degrees: `hinge`, or `swing_1`, `swing_2` and `twist`.
    pub limits_deg: BTreeMap<&'static str, [f64; 2]>,
    /// Limits of a slide, m.
    pub limits_m: Option<[f64; 2]>,
}

/// A scene.
#[derive(Clone, Debug, Serialize)]
pub struct SceneInspection {
    /// Its name.
    pub name: String,
    /// The body.
    pub body: BodyInspection,
    /// Where its motion comes from: `script`, or a file.
    pub motion: String,
    /// Frames per second of the clips written, Hz; null: those of the file.
    pub rate_hz: Option<f64>,
    /// Length, still time included, s; null for a motion from a file, which is not opened here.
    pub duration_s: Option<f64>,
    /// `free`, `assisted` or `pinned`.
    pub root: &'static str,
    /// Limbs whose ends stay planted.
    pub planted: Vec<String>,
    /// Actions in order.
    pub actions: Vec<ActionInspection>,
    /// Elements after all edits, track by track.
    pub elements: Vec<ElementInspection>,
    /// Names of the edits, one for each application, in order.
    pub edits: Vec<String>,
    /// Programs of the user among the edits and the reactive properties.
    pub programs: Vec<ProgramInspection>,
    /// Fields of elements that several edits changed, each on what the one before left.
    pub conflicts: Vec<ConflictInspection>,
    /// Elements that a later one of the same joint cuts short.
    pub overlaps: Vec<OverlapInspection>,
    /// What the edits did, in words, one line for each element written.
    pub log: Vec<String>,
}

/// A program of the user.
#[derive(Clone, Debug, Serialize)]
pub struct ProgramInspection {
    /// Its file.
    pub file: String,
    /// What it does: `elements`, `clip` or `react`.
    pub does: &'static str,
    /// Its parameters with their values.
    pub params: BTreeMap<String, String>,
}

/// An action.
#[derive(Clone, Debug, Serialize)]
pub struct ActionInspection {
    /// Its name, the first part of its elements' labels.
    pub name: String,
    /// When it starts as written, s.
    pub start_s: f64,
    /// Poses and repetitions of each cycle.
    pub cycles: Vec<CycleInspection>,
}

/// A cycle.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct CycleInspection {
    /// Number of poses.
    pub poses: usize,
    /// How often they run.
    pub repetitions: usize,
}

/// An element.
#[derive(Clone, Debug, Serialize)]
pub struct ElementInspection {
    /// Its label: action, cycle, pose, joint, and the repetition if there is one.
    pub label: String,
    /// The joint or coordinate it moves.
    pub dof: String,
    /// When it becomes active, s.
    pub start_s: f64,
    /// Transition time, s.
    pub duration_s: f64,
    /// Hold time, s.
    pub hold_s: f64,
    /// End value in degrees: one angle, or three of a ball joint.
    pub end_deg: Option<Vec<f64>>,
    /// End value of a slide or coordinate, m.
    pub end_m: Option<f64>,
    /// Transition curve.
    pub curve: String,
    /// Tension, 1 = natural.
    pub tension: f64,
    /// The edit that last wrote it.
    pub edited_by: Option<String>,
}

/// A field that several edits wrote.
#[derive(Clone, Debug, Serialize)]
pub struct ConflictInspection {
    /// The element.
    pub label: String,
    /// The field.
    pub field: String,
    /// The edits, in order.
    pub edits: Vec<String>,
}

/// An element cut short.
#[derive(Clone, Debug, Serialize)]
pub struct OverlapInspection {
    /// The element cut short.
    pub earlier: String,
    /// The element that took over.
    pub later: String,
    /// When, s.
    pub at_s: f64,
    /// Transition time lost, s; 0 if only hold was.
    pub cut_s: f64,
}

/// A clip.
#[derive(Clone, Debug, Serialize)]
pub struct ClipInspection {
    /// Frames.
    pub frames: usize,
    /// Frames per second, Hz.
    pub rate_hz: f64,
    /// Length, s.
    pub duration_s: f64,
    /// What its file does not say.
    #[serde(flatten)]
    pub decided: DecidedReport,
    /// What was read and guessed, in words.
    pub import: Vec<String>,
    /// Hierarchy: of the guessed body, or bare.
    pub body: BodyInspection,
    /// How the body was guessed, in words.
    pub guess: Vec<String>,
    /// Why no body could be guessed.
    pub no_body: Option<String>,
}

/// The character in a `.ron` file; `None` if it is a scene.
///
/// # Errors
/// A file that cannot be read, or a character that is wrong.
pub fn character_in(path: &Path) -> Result<Option<Character>, SceneError> {
    let source = Source::read(path)?;
    (source.first_word() == Some("Character")).then(|| character_file::parse(&source)).transpose()
}

/// Looks into a file: `.ron` (scene or character), a clip or a physics model. The character is the one a clip's body was
/// guessed to be, or the file's.
///
/// # Errors
/// [`TakeError`]: anything wrong with the file.
pub fn inspect(path: &Path, import: &ImportOptions) -> Result<(Inspection, Option<Character>), TakeError> {
    let path = &library::resolve(path, &[Kind::Scene, Kind::Character])?;
    match path {
        _ if is_ron(path) => {
            let source = Source::read(path)?;
            if source.first_word() == Some("Character") {
                let character = character_file::parse(&source)?;
                return Ok((Inspection::Character(body(&character)), Some(character)));
            }
            let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
            let scene = scene::parse(source, name)?;
            // what clip edits change is known once they have run
            let log = match scene.edits.iter().any(|e| !matches!(e.kind, EditKind::Track(_))) {
                true => Some(crate::open(path.clone(), &Ask { import: *import, ..Ask::default() })?.log),
                false => None,
            };
            Ok((Inspection::Scene(of_scene(&scene, log)?), None))
        }
        _ if formats::table::is_model(path) => {
            let read = formats::open_model(path, &model::ImportOptions { dynamics_only: true })?;
            let inspection = of_model(&read);
            Ok((Inspection::Model(inspection), Some(read.character)))
        }
        _ if formats::table::is_clip(path) => {
            let (clip, report) = formats::open_clip(path, import)?;
            let (character, guess, fault) = match guess_body_of_clip(&clip, &BodyOptions::default()) {
                Ok((character, guess)) => (Some(character), Some(guess), None),
                Err(e) => (None, None, Some(e.to_string())),
            };
            let inspection = of_clip(&clip, &report, character.as_ref(), guess.as_ref(), fault);
            Ok((Inspection::Clip(inspection), character))
        }
        _ => Err(TakeError::Kind(path.display().to_string())),
    }
}

fn of_model(read: &Imported) -> ModelInspection {
    let of = |effect| model::summary(read.left_out.iter().filter(|item| item.effect == effect));
    ModelInspection {
        format: match read.format {
            ModelFormat::Mjcf => "MJCF",
            ModelFormat::Urdf => "URDF",
        },
        body: body(&read.character),
        gravity_m_s2: read.gravity.into(),
        ground_m: read.ground.map(|g| g.height_m),
        dynamics_only: read.left_out.iter().any(|item| item.effect == Effect::Physics),
        forces_left_out: of(Effect::Physics),
        looks_left_out: of(Effect::Look),
        left_out: read.left_out.iter().map(ToString::to_string).collect(),
    }
}

/// A character.
pub fn body(c: &Character) -> BodyInspection {
    let mut out = skeleton(&c.name, &c.skeleton, &c.rest);
    if let Some([low, high]) = c.extent(&c.rest, &motion::Vec3::y()) {
        out.height_m = high - low;
    }
    out.mass_kg = Some(c.mass());
    for (i, link) in out.links.iter_mut().enumerate() {
        link.class = Some(c.classes[i].word().to_owned()).filter(|_| c.classes[i] != JointClass::Other);
        link.mass_kg = Some(c.bodies[i].mass);
    }
    out.contacts = c.contacts.iter().map(|&i| c.skeleton.sites()[i].name.clone()).collect();
    out
}

/// A skeleton without mass, in the pose `q`.
pub fn skeleton(name: &str, s: &Skeleton, q: &[f64]) -> BodyInspection {
    let links = s.links();
    let mut depths: Vec<usize> = Vec::new();
    for link in links {
        depths.push(link.parent.map_or(0, |p| depths[p] + 1));
    }
    let k = Kinematics::new(s, q);
    let ends = links.iter().enumerate().flat_map(|(i, link)| {
        let origin = k.origin(i).y;
        [Some(origin), link.end.map(|e| k.point(i, &e).y)].into_iter().flatten().map(|y| (y, y))
    });
    BodyInspection {
        name: name.into(),
        dof: s.nv(),
        mass_kg: None,
        height_m: extent(ends).unwrap_or(0.0),
        links: links
            .iter()
            .zip(depths)
            .map(|(link, depth)| {
                let (limits_deg, limits_m) = limits(&link.joint, link.limits.as_ref());
                LinkInspection {
                    name: link.name.clone(),
                    parent: link.parent.map(|p| links[p].name.clone()),
                    depth,
                    joint: match link.joint {
                        Joint::Free => "free",
                        Joint::Spherical => "ball",
                        Joint::Revolute(_) => "hinge",
                        Joint::Prismatic(_) => "slide",
                        Joint::Fixed => "fixed",
                    },
                    dof: link.joint.nv(),
                    class: None,
                    mass_kg: None,
                    limits_deg,
                    limits_m,
                }
            })
            .collect(),
        contacts: Vec::new(),
        limbs: s.limbs().iter().map(|l| (l.name.clone(), l.links().map(|i| links[i].name.clone()))).collect(),
        parts: s
            .parts()
            .iter()
            .map(|(part, members)| (part.clone(), members.iter().map(|&i| links[i].name.clone()).collect()))
            .collect(),
    }
}

/// From the lowest to the highest of some intervals.
fn extent(intervals: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let (lo, hi) =
        intervals.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), (a, b)| (lo.min(a), hi.max(b)));
    Some(hi - lo).filter(|h| h.is_finite())
}

fn limits(joint: &Joint, limits: Option<&Limits>) -> (BTreeMap<&'static str, [f64; 2]>, Option<[f64; 2]>) {
    let deg = |r: &Range| [r.lo.to_degrees(), r.hi.to_degrees()];
    match limits {
        None => (BTreeMap::new(), None),
        Some(Limits::Axis(r)) if matches!(joint, Joint::Prismatic(_)) => {
            (BTreeMap::new(), Some([r.lo, r.hi]))
        }
        Some(Limits::Axis(r)) => (BTreeMap::from([("hinge", deg(r))]), None),
        Some(Limits::Ball(b)) => {
            let names = ["swing_1", "swing_2", "twist"];
            (names.into_iter().zip(&b.ranges).map(|(n, r)| (n, deg(r))).collect(), None)
        }
    }
}

fn of_scene(scene: &Scene, whole: Option<EditLog>) -> Result<SceneInspection, TakeError> {
    let (script, motion) = (scene.motion.script(), scene.motion.describe());
    let (tracks, log) = match script {
        Some(script) => {
            let (_, tracks, log) = edited_tracks(scene, script)?;
            (tracks, log)
        }
        None => {
            (Tracks::new(scene.character.skeleton.clone(), scene.character.rest.clone()), EditLog::default())
        }
    };
    let log = whole.unwrap_or(log);
    let edits: Vec<String> = log.edits().iter().map(|e| (*e).to_owned()).collect();
    let mut programs = Vec::new();
    for e in &scene.edits {
        programs.extend(edit_program(&scene.source, e)?.map(|(program, does)| inspected(&program, does)));
    }
    programs.extend(reactions(scene)?.iter().map(|r| inspected(r.program(), Entry::React)));
    let name = |edit: usize| format!("{} (edit {edit})", log.edits()[edit]);
    let s = &scene.character.skeleton;
    let elements = tracks.elements().map(|(dof, e)| {
        let (end_deg, end_m) = end(s, dof, &e.end);
        ElementInspection {
            label: e.label.named(s),
            dof: dof.name(s),
            start_s: e.start_s,
            duration_s: e.duration_s,
            hold_s: e.hold_s,
            end_deg,
            end_m,
            curve: e.curve.to_string(),
            tension: e.tension,
            edited_by: log.last_writer(&e.label).map(|(i, _)| name(i)),
        }
    });
    Ok(SceneInspection {
        name: scene.name.clone(),
        body: body(&scene.character),
        motion,
        rate_hz: scene.rate_hz.or(script.map(|_| USUAL_FRAMES_HZ)),
        duration_s: script.map(|script| tracks.duration_s + script.settle_s),
        root: scene.conditions.physics.root.name().word(),
        planted: (script.iter().flat_map(|x| &x.planted)).map(|&l| s.limbs()[l].name.clone()).collect(),
        actions: (script.iter().flat_map(|x| &x.script.actions))
            .map(|a| ActionInspection {
                name: a.name.clone(),
                start_s: a.start_s,
                cycles: a
                    .cycles
                    .iter()
                    .map(|c| CycleInspection { poses: c.poses.len(), repetitions: c.repetitions })
                    .collect(),
            })
            .collect(),
        elements: elements.collect(),
        edits,
        programs,
        conflicts: log
            .conflicts()
            .iter()
            .map(|c| ConflictInspection {
                label: log.name(&c.label, s),
                field: c.field.to_string(),
                edits: c.edits.iter().map(|&i| name(i)).collect(),
            })
            .collect(),
        overlaps: overlaps(&tracks),
        log: log.to_string().lines().map(str::to_owned).collect(),
    })
}

fn inspected(program: &Program, does: Entry) -> ProgramInspection {
    ProgramInspection {
        file: program.file().display().to_string(),
        does: does.function().0,
        params: program.parameters().into_iter().collect(),
    }
}

fn overlaps(tracks: &Tracks) -> Vec<OverlapInspection> {
    let s = &tracks.skeleton;
    let found = tracks.overlaps();
    let overlaps = found.iter().map(|o| OverlapInspection {
        earlier: o.earlier.named(s),
        later: o.later.named(s),
        at_s: o.at_s,
        cut_s: o.cut_s,
    });
    overlaps.collect()
}

/// An end value in degrees or in metres.
fn end(s: &Skeleton, dof: Dof, value: &Value) -> (Option<Vec<f64>>, Option<f64>) {
    match (dof, value) {
        (_, Value::Rotation(r)) => (Some(deg_from_quat(r).to_vec()), None),
        (Dof::Axis(link), Value::Scalar(x)) if matches!(s.links()[link].joint, Joint::Revolute(_)) => {
            (Some(vec![x.to_degrees()]), None)
        }
        (_, Value::Scalar(x)) => (None, Some(*x)),
    }
}

fn of_clip(
    clip: &Clip,
    report: &ImportReport,
    character: Option<&Character>,
    guess: Option<&BodyReport>,
    no_body: Option<String>,
) -> ClipInspection {
    let lines = |text: String| text.lines().map(|l| l.trim_end().to_owned()).collect();
    ClipInspection {
        frames: clip.frames(),
        rate_hz: clip.rate_hz,
        duration_s: clip.duration_s(),
        decided: DecidedReport::new(report),
        import: lines(report.to_string()),
        body: character.map_or_else(|| skeleton("skeleton", &clip.skeleton, clip.pose(0)), body),
        guess: guess.map_or_else(Vec::new, |g| lines(g.to_string())),
        no_body,
    }
}
