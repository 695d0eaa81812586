//! The numbers of a run, as `report.json` gives them.
//!
//! In: a [`Take`] and, unless only previewed, its [`Outcome`]. Out: a [`Report`] that
//! serialises to JSON. Every unit is in its field's name. The schema is documented in `docs/REPORT.md`:
//! fields are only ever added.

use motion::metrics;
use motion::stance::StanceSpan;
use serde::Serialize;
use sim::Outcome;

use crate::Take;
use crate::analysis::{AnalysisInput, AnalysisSettings};
use crate::ignored::Ignored;
use crate::limited::Limited;
use crate::perform::{Performed, PerformedSpan};
use crate::possible::Shifted;
use crate::results::analysis_report::AnalysisReport;
use crate::results::disturbance_report::DisturbanceReport;
pub use crate::results::dynamic_report::DynamicReport;
use crate::results::feet::{FeetReport, feet};
use crate::results::subject_report::{CharacterReport, ClipReport};

/// All numbers of a run.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Name of the scene or clip.
    pub scene: String,
    /// Frames of the clips written.
    pub frames: usize,
    /// Frames per second of the clips written.
    pub rate_hz: f64,
    /// Length, s.
    pub duration_s: f64,
    /// How the clip was read; absent for a scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clip: Option<ClipReport>,
    /// Whether the clip as captured is physically plausible, as `analyze` says; absent for a scene and an edited clip.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plausibility: Option<PlausibilityReport>,
    /// The body.
    pub character: CharacterReport,
    /// The motion asked for.
    pub kinematic: KinematicReport,
    /// What disturbs the performer.
    pub disturbances: DisturbanceReport,
    /// The motion performed; absent after `--kinematic`, and where a clip is performed in parts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dynamic: Option<DynamicReport>,
    /// Where the feet of a clip stand and step; absent for a scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spans: Option<Vec<SpanReport>>,
    /// Edits that wrote the same field of the same element.
    pub edit_conflicts: usize,
    /// Files written, by what they hold; paths relative to the report.
    pub files: std::collections::BTreeMap<String, String>,
}

/// Whether a clip is physically plausible: the main numbers of its analysis.
#[derive(Clone, Debug, Serialize)]
pub struct PlausibilityReport {
    /// `good`, `acceptable` or `poor`.
    pub grade: String,
    /// In words.
    pub text: String,
    /// Largest travel of a point of a sole while it is down, mm.
    pub slip_mm_max: Option<f64>,
    /// Share of the frames with the centre of pressure outside the soles, 0 to 1.
    pub outside_soles_share: f64,
    /// Share of the frames without contact, 0 to 1.
    pub flight_share: f64,
}

impl PlausibilityReport {
    /// Of a captured clip; `None` for other motions, and where it cannot be analysed.
    fn new(take: &Take) -> Option<Self> {
        if !take.is_captured() {
            return None;
        }
        let input = AnalysisInput::of(take.clone(), take.files.first().cloned().unwrap_or_default());
        let analysis = input.analyze(&AnalysisSettings::default()).ok()?;
        let r = AnalysisReport::new(&input, &analysis);
        Some(Self {
            text: r.verdict(),
            slip_mm_max: r.ground.feet.map(|f| f.slip_mm_max),
            outside_soles_share: r.support.share,
            flight_share: r.flight.share,
            grade: r.plausible,
        })
    }
}

/// A part of a clip that stands, or in which feet step.
#[derive(Clone, Debug, Serialize)]
pub struct SpanReport {
    /// Begin, s.
    pub from_s: f64,
    /// End, s: the time of its last frame.
    pub to_s: f64,
    /// Whether all feet stand throughout.
    pub stands: bool,
    /// Legs that step in it.
    pub stepping: Vec<String>,
    /// Folder of its files, relative to the report; null unless it was performed by itself.
    pub folder: Option<String>,
    /// The motion performed; null unless it was performed by itself.
    pub dynamic: Option<DynamicReport>,
}

impl SpanReport {
    /// All spans of a stage, with those performed by themselves; none for a scene.
    pub(crate) fn all(take: &Take, performed: &[PerformedSpan]) -> Option<Vec<Self>> {
        let stance = take.asked.stance.as_ref()?;
        let legs = take.body.character.leg_soles();
        let rate = take.asked.clip.rate_hz;
        let of = |(i, span): (usize, &StanceSpan)| {
            let place = performed.iter().position(|p| p.span == i);
            Self {
                from_s: span.frames.start as f64 / rate,
                to_s: span.frames.end.saturating_sub(1) as f64 / rate,
                stands: span.stands,
                stepping: span.stepping.iter().map(|&s| legs[s].1.name.clone()).collect(),
                folder: place.map(span_folder),
                dynamic: place.map(|k| DynamicReport::new(&performed[k].take, &performed[k].outcome)),
            }
        };
        Some(stance.spans.iter().enumerate().map(of).collect())
    }
}

/// Folder of the `k`th standing span, counted from 0.
pub fn span_folder(k: usize) -> String {
    format!("span_{}", k + 1)
}

/// The motion asked for.
#[derive(Clone, Debug, Serialize)]
pub struct KinematicReport {
    /// Foot numbers; null without ground.
    pub feet: Option<FeetReport>,
    /// RMS jerk of the links' origins, m/s³.
    pub jerk_rms_m_s3: f64,
    /// Jerk relative to the unedited motion.
    pub jerk_ratio: f64,
    /// Share of frames that joint limits changed.
    pub clamped_frames: f64,
    /// Keys of the script that do not act.
    pub ignored: Vec<IgnoredReport>,
    /// Joints that their limits changed, the furthest first.
    pub limited: Vec<LimitedReport>,
    /// What each clip edit changed, and what it noted.
    pub edited: Vec<String>,
    /// How the root gave way so that the feet can carry the body; null where it did not have to.
    pub shifted: Option<ShiftedReport>,
    /// What of a motion that steps was made possible, and what could not be, a sentence each.
    pub stepping: Vec<String>,
}

/// An axis of a joint that its limit changed.
#[derive(Clone, Debug, Serialize)]
pub struct LimitedReport {
    /// The joint.
    pub joint: String,
    /// `swing 1`, `swing 2` or `twist` of a ball; null for hinges and slides.
    pub axis: Option<&'static str>,
    /// The furthest asked, degrees (mm for slides).
    pub asked: f64,
    /// The limit, degrees (mm).
    pub limit: f64,
    /// First and last moment of each span, s.
    pub spans_s: Vec<[f64; 2]>,
    /// The whole sentence.
    pub text: String,
}

impl LimitedReport {
    fn new(l: &Limited) -> Self {
        let unit = if l.slides { 1e3 } else { 1f64.to_degrees() };
        Self {
            joint: l.joint.clone(),
            axis: l.axis,
            asked: l.asked * unit,
            limit: l.limit * unit,
            spans_s: l.spans_s.iter().map(|&(from_s, to_s)| [from_s, to_s]).collect(),
            text: l.to_string(),
        }
    }
}

/// A root that gave way so that the feet can carry the body.
#[derive(Clone, Debug, Serialize)]
pub struct ShiftedReport {
    /// The furthest, mm.
    pub by_mm: f64,
    /// First moment, s.
    pub from_s: f64,
    /// Last moment, s.
    pub to_s: f64,
    /// From when on the motion still asks for a centre of pressure outside the soles, s; null where it does not.
    pub outside_from_s: Option<f64>,
    /// By how much at most, mm.
    pub outside_mm: Option<f64>,
    /// The whole sentence.
    pub text: String,
}

impl ShiftedReport {
    fn new(s: &Shifted) -> Self {
        Self {
            by_mm: 1e3 * s.by_m,
            from_s: s.from_s,
            to_s: s.to_s,
            outside_from_s: s.outside.map(|(at_s, _)| at_s),
            outside_mm: s.outside.map(|(_, by_m)| 1e3 * by_m),
            text: s.to_string(),
        }
    }
}

/// Keys of a script that do not act, for one reason.
#[derive(Clone, Debug, Serialize)]
pub struct IgnoredReport {
    /// Joints and coordinates.
    pub keys: Vec<String>,
    /// Labels of the poses that set them.
    pub poses: Vec<String>,
    /// The whole sentence.
    pub text: String,
}

impl IgnoredReport {
    fn new(ignored: &Ignored) -> Self {
        Self { keys: ignored.keys.clone(), poses: ignored.poses.clone(), text: ignored.to_string() }
    }
}

impl Report {
    /// Numbers of a take and what came of it.
    pub fn new(performed: &Performed) -> Self {
        Self::of(&performed.take, performed.outcome(), performed.spans())
    }

    /// Numbers of a take, of its outcome where it was performed whole, of its spans where they were each by themselves.
    pub fn of(take: &Take, outcome: Option<&Outcome>, performed: &[PerformedSpan]) -> Self {
        let c = &take.body.character;
        let plain_jerk = metrics::jerk_rms(&take.unedited);
        let jerk = metrics::jerk_rms(&take.asked.clip);
        Self {
            scene: take.name.clone(),
            frames: take.asked.clip.frames(),
            rate_hz: take.asked.clip.rate_hz,
            duration_s: take.asked.clip.duration_s(),
            clip: take.clip_source().and_then(ClipReport::new),
            plausibility: PlausibilityReport::new(take),
            character: CharacterReport {
                name: c.name.clone(),
                links: c.skeleton.links().len(),
                dof: c.skeleton.nv(),
                mass_kg: c.mass(),
            },
            kinematic: KinematicReport {
                feet: feet(take, &take.asked.clip).map(FeetReport::from),
                jerk_rms_m_s3: jerk,
                jerk_ratio: if plain_jerk > 0.0 { jerk / plain_jerk } else { 1.0 },
                clamped_frames: take.asked.clamped,
                ignored: take.asked.ignored.iter().map(IgnoredReport::new).collect(),
                limited: take.asked.limited.iter().map(LimitedReport::new).collect(),
                edited: take.log.clip_lines(),
                shifted: take.asked.shifted.as_ref().map(ShiftedReport::new),
                stepping: take.asked.stepping.clone(),
            },
            disturbances: DisturbanceReport::new(take),
            dynamic: outcome.map(|o| DynamicReport::new(take, o)),
            spans: SpanReport::all(take, performed),
            edit_conflicts: take.log.conflicts().len(),
            files: std::collections::BTreeMap::new(),
        }
    }

    /// The report as indented JSON with a final newline.
    pub fn to_json(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).expect("a report has no maps with odd keys");
        text.push('\n');
        text
    }
}
