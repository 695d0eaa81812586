//! A clip posed by dragging: one pose corrected, blended into its neighbours, moved in time; as a file or a folder of results.
//!
//! In: a clip (any format that is read) or the motion a scene asks for, a [`PoseOrder`]. Out: [`Posed`]: the clip edited by
//! [`edits::PoseDelta`] and [`edits::TimeDelta`], and a report of what moved by how much, what was met, and what could not be reached.
//!
//! A clip keeps all joints of its file, under their names; a body is not needed, so none is guessed, and limits are those that
//! the file has (a scene's character; motion capture has none).

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bodies::{Body, Character, JointClass};
use edits::{ClipChange, ClipEdit, EditError, EditLog, Motion, PoseChange, PoseDelta, TimeDelta, Where};
use formats::bvh::{ImportOptions, ImportReport};
use formats::{ClipFileError, glb};
use motion::{Clip, Kinematics, Shape, Vec3};
use nalgebra::Matrix3;
use plots::{StripOptions, StripRow, View, film_strip_with};
use serde_json::{Value, json};

pub use edits::pose_delta::BLEND_S;
pub use edits::{Met, PoseAnswer, PoseRequest};

use crate::results::figures::Draw;
use crate::results::folder::{Earlier, Folder, FolderError, Plan};
use crate::results::write::{Undrawn, WriteError, write_bvh, write_report};
use crate::{Ask, Progress, TakeError};

/// A joint that turned or moved by less was not touched, degrees and mm.
const NOTHING: f64 = 1e-6;

/// A dragged point within this of its place was reached, mm.
const REACHED_MM: f64 = 10.0;

/// Which pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Moment {
    /// A frame, counted from 0.
    Frame(usize),
    /// A time, s.
    Time(f64),
}

/// What is done to a clip.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseOrder {
    /// Which pose.
    pub at: Moment,
    /// What it shall be; nothing dragged leaves it.
    pub request: PoseRequest,
    /// How long changes are blended in and out, s.
    pub blend_s: f64,
    /// From when to when the change is whole, s.
    pub block_s: Option<(f64, f64)>,
    /// When the pose shall come, s.
    pub to_s: Option<f64>,
}

/// A clip to be posed.
#[derive(Clone, Debug)]
pub struct PoseSource {
    /// Its name, for output folders.
    pub name: String,
    /// The clip.
    pub clip: Clip,
    /// Solids to show.
    pub solids: Vec<(usize, Shape)>,
    /// A colour of each link; may be empty.
    pub colors: Vec<Option<[u8; 3]>>,
    /// What was read and guessed of a clip's file.
    pub import: Option<ImportReport>,
    /// Metres per unit of its file.
    pub metres_per_unit: f64,
    /// Files it was made of.
    pub files: Vec<PathBuf>,
}

/// A clip that was posed.
#[derive(Clone, Debug)]
pub struct Posed {
    /// The clip edited.
    pub clip: Clip,
    /// When the pose was, s, and where it is now.
    pub at_s: f64,
    /// See [`Posed::at_s`].
    pub to_s: f64,
    /// What came of the dragging; `None` where nothing was dragged.
    pub answer: Option<PoseAnswer>,
    /// Joints of the pose that moved: name, degrees turned against the parent, mm moved in the world; most turned first.
    pub joints: Vec<(String, f64, f64)>,
    /// What the edits changed over time.
    pub changes: Vec<ClipChange>,
    /// Remarks of the edits.
    pub notes: Vec<String>,
}

/// Why a clip cannot be posed.
#[derive(Debug, thiserror::Error)]
pub enum PosingError {
    /// Of its file.
    #[error(transparent)]
    ClipFile(#[from] ClipFileError),
    /// Of its scene.
    #[error(transparent)]
    Take(#[from] TakeError),
    /// A frame that does not exist.
    #[error("frame {frame} is not in the clip; it has frames 0 to {last}")]
    Frame {
        /// As asked.
        frame: usize,
        /// The last.
        last: usize,
    },
    /// A time that is not in the clip.
    #[error("{at_s} s is not in the clip; it lasts from 0 s to {end_s:.3} s")]
    Time {
        /// As asked, s.
        at_s: f64,
        /// Length, s.
        end_s: f64,
    },
    /// Of what is asked.
    #[error(transparent)]
    Edit(#[from] EditError),
}

impl PoseSource {
    /// Opens a clip, or the motion that a scene asks for.
    ///
    /// # Errors
    /// Files that cannot be read.
    pub fn open(path: &Path, import: &ImportOptions) -> Result<Self, PosingError> {
        if formats::table::is_clip(path) {
            let (clip, report) = formats::open_clip(path, import)?;
            return Ok(Self {
                name: path.file_stem().map_or_else(|| "clip".into(), |s| s.to_string_lossy().into_owned()),
                solids: glb::bones(&clip.skeleton),
                colors: Vec::new(),
                metres_per_unit: report.units.metres_per_unit,
                import: Some(report),
                files: vec![path.to_owned()],
                clip,
            });
        }
        let take = crate::open(path, &Ask::default())?;
        Ok(Self {
            name: take.name.clone(),
            solids: take.body.solids(),
            colors: take.body.colors.clone(),
            import: None,
            metres_per_unit: take.metres_per_unit(),
            files: take.files.clone(),
            clip: take.asked.clip,
        })
    }

    /// Poses the clip.
    ///
    /// # Errors
    /// [`PosingError`]; all are faults of what is asked.
    pub fn pose(&self, order: &PoseOrder) -> Result<Posed, PosingError> {
        let (clip, s) = (&self.clip, &self.clip.skeleton);
        let last = clip.frames() - 1;
        let at_s = match order.at {
            Moment::Frame(frame) if frame > last => return Err(PosingError::Frame { frame, last }),
            Moment::Frame(frame) => frame as f64 / clip.rate_hz,
            Moment::Time(at_s) if !(at_s >= 0.0 && at_s <= clip.duration_s() + 0.5 / clip.rate_hz) => {
                return Err(PosingError::Time { at_s, end_s: clip.duration_s() });
            }
            Moment::Time(at_s) => at_s,
        };
        let (mut motion, mut log) = (Motion::of(clip.clone()), EditLog::default());
        let mut before = vec![0.0; s.nq()];
        clip.sample(at_s, &mut before);
        let only_moved = order.request.drag.is_empty() && order.to_s.is_some();
        let mut answer = None;
        if !only_moved {
            let asked = order.request.solve("pose", s, &before)?;
            let change = PoseChange::Delta { delta: asked.delta.clone(), limits: order.request.limits };
            let edit = PoseDelta { at_s, change, blend_s: order.blend_s, block_s: order.block_s };
            let edited = edit.apply(&motion, &Where::default(), &mut log)?;
            motion = motion.with(edited);
            answer = Some(asked);
        } else if let Some(name) = order.request.pin.first() {
            let edit = "pose";
            return Err(EditError::OnlyDragged { edit, name: name.clone() }.into());
        }
        let to_s = order.to_s.unwrap_or(at_s);
        if order.to_s.is_some() {
            let edit = TimeDelta { at_s, to_s, blend_s: order.blend_s };
            let edited = edit.apply(&motion, &Where::default(), &mut log)?;
            motion = motion.with(edited);
        }
        let after = answer.as_ref().map_or(before.as_slice(), |a| a.pose.as_slice());
        Ok(Posed {
            joints: moved(clip, &before, after),
            clip: motion.clip,
            at_s,
            to_s,
            answer,
            changes: log.clip_changes().to_vec(),
            notes: log.notes().iter().map(|(_, text)| text.clone()).collect(),
        })
    }

    /// Writes a folder: the clip as BVH, the report, a film strip of before and after.
    ///
    /// # Errors
    /// Of the files; figures that cannot be drawn are no error.
    pub fn write(
        &self,
        posed: &Posed,
        order: &PoseOrder,
        dir: &Path,
        view: Option<View>,
        draw: bool,
        progress: &Progress<'_>,
    ) -> Result<Vec<Undrawn>, WriteError> {
        let figure = || {
            let character = drawn(&self.clip, &self.solids);
            let rows = [StripRow::new("before", &self.clip), StripRow::new("after", &posed.clip)];
            let (from_s, to_s) = order.block_s.unwrap_or((posed.at_s, posed.at_s));
            let room = order.blend_s.max(0.1);
            let options = StripOptions {
                count: 9,
                from_s: (from_s.min(posed.to_s) - room).max(0.0),
                to_s: Some((to_s.max(posed.to_s) + room).min(self.clip.duration_s())),
                view: view.unwrap_or_default(),
                colors: self.colors.clone(),
                ..StripOptions::default()
            };
            Ok(film_strip_with(&rows, &character, &self.note(posed), &options))
        };
        let figures: Vec<Draw<'_>> = if draw { vec![("strip_pose", Box::new(figure))] } else { Vec::new() };
        let mut data =
            |folder: &mut Folder| write_bvh(&mut folder.top(), "pose", &posed.clip, self.metres_per_unit);
        let mut text = |files| {
            let mut report = self.report(posed);
            report["files"] = json!(files);
            format!("{report:#}\n")
        };
        write_report(dir, &plan(&self.files), &mut data, &figures, &mut text, progress)
    }

    fn note(&self, posed: &Posed) -> String {
        let met = posed.answer.iter().flat_map(|a| &a.met);
        let named = |pinned| -> Vec<&str> {
            met.clone().filter(|m| m.pinned == pinned).map(|m| m.name.as_str()).collect()
        };
        let list = |what: &str, names: Vec<&str>| {
            if names.is_empty() { String::new() } else { format!(", {} {what}", names.join(", ")) }
        };
        let moved =
            if posed.to_s == posed.at_s { String::new() } else { format!(", moved to {:.3} s", posed.to_s) };
        let (dragged, pinned) = (list("dragged", named(false)), list("pinned", named(true)));
        format!("{} at {:.3} s{dragged}{pinned}{moved}", self.name, posed.at_s)
    }

    /// The report, as `report.json` and `--json` have it.
    pub fn report(&self, posed: &Posed) -> Value {
        let met = posed.answer.iter().flat_map(|a| &a.met).map(|m| {
            json!({
                "joint": m.name,
                "hold": if m.pinned { "pinned" } else { "dragged" },
                "from_m": rounded(m.from.as_slice(), 6),
                "to_m": rounded(m.to.as_slice(), 6),
                "miss_mm": 1e3 * m.miss_m,
                "reached": 1e3 * m.miss_m <= if m.pinned { 1e-3 } else { REACHED_MM },
            })
        });
        let joints = posed.joints.iter().map(|(joint, turned, moved)| {
            json!({"joint": joint, "turned_deg": rounded(&[*turned], 6)[0], "moved_mm": rounded(&[*moved], 6)[0]})
        });
        json!({
            "command": "pose",
            "name": self.name,
            "at_s": posed.at_s,
            "to_s": posed.to_s,
            "frames": posed.clip.frames(),
            "rate_hz": posed.clip.rate_hz,
            "handles": met.collect::<Vec<_>>(),
            "joints": joints.collect::<Vec<_>>(),
            "bone_residue_m": posed.answer.as_ref().map(|a| a.bone_residue_m),
            "pin_residue_m": posed.answer.as_ref().map(PoseAnswer::pin_residue_m),
            "at_rest": posed.answer.as_ref().map(|a| a.still),
            "changed": posed.changes.iter().map(ToString::to_string).collect::<Vec<_>>(),
            "notes": posed.notes,
        })
    }
}

/// What a folder of `pose` holds.
///
/// # Errors
/// If it cannot be written.
pub fn check(dir: &Path, reads: &[PathBuf]) -> Result<(), FolderError> {
    Folder::check(dir, &plan(reads))
}

fn plan(reads: &[PathBuf]) -> Plan<'_> {
    Plan { command: "pose", planned: &["pose.bvh", "report.json"], reads, earlier: Earlier::Remove }
}

fn rounded(values: &[f64], digits: i32) -> Vec<f64> {
    let unit = 10f64.powi(digits);
    values.iter().map(|x| (x * unit).round() / unit + 0.0).collect()
}

/// What is drawn of a clip: its solids on its own joints.
fn drawn(clip: &Clip, solids: &[(usize, Shape)]) -> Character {
    let s = clip.skeleton.clone();
    let shapes = |link| solids.iter().filter(|(l, _)| *l == link).map(|(_, shape)| *shape).collect();
    let bodies = (0..s.links().len()).map(|link| Body {
        mass: 0.0,
        com: Vec3::zeros(),
        inertia: Matrix3::zeros(),
        shapes: shapes(link),
    });
    Character {
        name: "clip".into(),
        bodies: bodies.collect(),
        classes: vec![JointClass::Other; s.links().len()],
        contacts: Vec::new(),
        rest: s.zero_pose(),
        skeleton: Arc::clone(&s),
    }
}

/// Joints that differ between two poses, the most turned first.
fn moved(clip: &Clip, before: &[f64], after: &[f64]) -> Vec<(String, f64, f64)> {
    let s = &clip.skeleton;
    let (a, b) = (Kinematics::new(s, before), Kinematics::new(s, after));
    let mut v = vec![0.0; s.nv()];
    s.difference(before, after, 1.0, &mut v);
    let mut all: Vec<(String, f64, f64)> = (0..s.links().len())
        .map(|i| {
            let link = &s.links()[i];
            let at = s.v_at(i);
            let turn = match link.joint {
                motion::Joint::Free => &v[at + 3..at + 6],
                motion::Joint::Prismatic(_) => &[],
                _ => &v[at..at + link.joint.nv()],
            };
            let turned = turn.iter().map(|x| x * x).fold(0.0, |sum, x| sum + x).sqrt().to_degrees();
            (link.name.clone(), turned, 1e3 * (a.origin(i) - b.origin(i)).norm())
        })
        .filter(|(_, turned, moved)| *turned > NOTHING || *moved > NOTHING)
        .collect();
    all.sort_by(|x, y| y.1.total_cmp(&x.1));
    all
}
