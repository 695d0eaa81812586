//! The numbers of a motion put on a character, as `report.json` gives them.
//!
//! In: a [`Session`] and what came out of it. Out: a [`RetargetReport`] that serialises to JSON. Every unit is in its
//! field's name; see `docs/RETARGET.md`. A number that a stage would have given is absent if it did not run.

use std::collections::BTreeMap;

use motion::names::Word;
use retarget::{MappingModel, PipelineStage, Retargeted};
use serde::Serialize;

use super::Session;
use super::stage_report::{self, FlightNumbers, PhaseNumbers, StageNumbers};

/// All numbers of a run.
#[derive(Clone, Debug, Serialize)]
pub struct RetargetReport {
    /// Name of the performance.
    pub performance: String,
    /// Name of the character.
    pub character: String,
    /// Key poses learned from.
    pub key_poses: usize,
    /// The model: `gplvm`, `gp`, `pca`, `nn3` or `nn10`.
    pub model: &'static str,
    /// The last stage that ran: `map`, `global`, `contact` or `refine`.
    pub stopped_after: &'static str,
    /// Frames of the result.
    pub frames: usize,
    /// Its frames per second.
    pub rate_hz: f64,
    /// Its length, s.
    pub duration_s: f64,
    /// What the mapping thinks of itself.
    pub mapping: MappingNumbers,
    /// Momentum, scaled human against character.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub momentum: Option<MomentumNumbers>,
    /// Contacts after their adjustment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact: Option<ContactNumbers>,
    /// Parts that followed by dynamics.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sway: Option<SwayNumbers>,
    /// Forces before and after the refinement.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refinement: Option<RefinementNumbers>,
    /// How far each stage went from the one before, of those that are held to bounds.
    pub stages: Vec<StageNumbers>,
    /// Flights of the human on the character; absent without.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub flights: Vec<FlightNumbers>,
    /// What a person should know: bounds that were reached, contacts that gave way, flights that fall.
    pub warnings: Vec<String>,
    /// Moments whose poses the model is least sure of, to be made next; in the order of their worth.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub suggested: Vec<Suggestion>,
    /// Files written, by what they hold; paths relative to the report.
    pub files: BTreeMap<String, String>,
}

/// What the mapping thinks of itself.
#[derive(Clone, Debug, Serialize)]
pub struct MappingNumbers {
    /// Dimensions of the latent space; 0 for models without.
    pub latent_dimensions: usize,
    /// Mean confidence: 1 is as sure as at a key pose, 0 knows nothing.
    pub confidence_mean: f64,
    /// The least sure frame's.
    pub confidence_least: f64,
    /// When that is, s.
    pub confidence_least_at_s: f64,
    /// Share of the frames at which the model says that it extrapolates.
    pub extrapolates: f64,
    /// Moments at which the latent answer jumped, s.
    pub jumps_at_s: Vec<f64>,
    /// Mean distance of the body's feature points from the predicted ones, mm.
    pub fit_mm_mean: f64,
    /// Greatest distance, mm.
    pub fit_mm_max: f64,
    /// Confidence of every frame.
    pub confidence: Vec<f64>,
}

/// Momentum, scaled human against character.
#[derive(Clone, Debug, Serialize)]
pub struct MomentumNumbers {
    /// Mass of the character over the human's.
    pub mass_ratio: f64,
    /// Size ratio along width, height and depth.
    pub size_ratio: [f64; 3],
    /// Inertia ratio about the same.
    pub inertia_ratio: [f64; 3],
    /// RMS mismatch of the horizontal momentum, % of the scaled human's RMS.
    pub mismatch_percent: f64,
}

/// Contacts after their adjustment.
#[derive(Clone, Debug, Serialize)]
pub struct ContactNumbers {
    /// Contact phases.
    pub phases: Vec<PhaseNumbers>,
    /// Parts of phases that could not be kept; absent without.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gave_way: Vec<PhaseNumbers>,
    /// Farthest way of a point within a phase, mm.
    pub slip_mm: f64,
    /// Deepest penetration of a contact point, mm.
    pub penetration_mm: f64,
    /// Jerk near phase ends over that of the mapped motion.
    pub jerk_ratio: f64,
}

/// Parts that followed by dynamics.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SwayNumbers {
    /// Joints that swayed.
    pub joints: usize,
    /// Farthest turn of one from its keyed pose, degrees.
    pub most_deg: f64,
}

/// Forces before and after the refinement.
#[derive(Clone, Debug, Serialize)]
pub struct RefinementNumbers {
    /// Force mismatch `[Fx, Fy, Fz, Nx, Ny, Nz]` before, N², moments over `length_m`.
    pub mismatch_before_n2: [f64; 6],
    /// The same after.
    pub mismatch_after_n2: [f64; 6],
    /// By how much the vertical part fell, %.
    pub vertical_fell_percent: f64,
    /// By how much all of it fell, %.
    pub all_fell_percent: f64,
    /// Length by which moments are divided, m.
    pub length_m: f64,
    /// Median displacement of the root, mm.
    pub root_median_mm: f64,
    /// Largest displacement of the root, mm.
    pub root_largest_mm: f64,
    /// Slip of contact points, mm.
    pub slip_mm: f64,
    /// Frames outside the friction cone before.
    pub cone_frames_before: usize,
    /// Moments outside the friction cone after, s.
    pub cone_after_at_s: Vec<f64>,
    /// Deepest penetration of bodies before and after, mm.
    pub collision_mm: [f64; 2],
    /// Steps taken.
    pub iterations: usize,
}

/// A moment whose pose is worth making.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Suggestion {
    /// The moment, s.
    pub at_s: f64,
    /// The model's confidence there.
    pub confidence: f64,
}

fn fell(before: f64, after: f64) -> f64 {
    if before > 0.0 { 100.0 * (1.0 - after / before) } else { 0.0 }
}

impl RetargetReport {
    /// The numbers of a run with this model.
    pub fn new(
        session: &Session,
        model: MappingModel,
        done: &Retargeted,
        suggested: Vec<Suggestion>,
    ) -> Self {
        let clip = &done.clip;
        let at = |frame: usize| frame as f64 / clip.rate_hz;
        let stopped = done.stages.last().map_or(PipelineStage::Map, |s| s.0);
        Self {
            performance: session.performance.name.clone(),
            character: session.actor.file.character.name.clone(),
            key_poses: session.key_poses.key_poses.pairs.len(),
            model: model.word(),
            stopped_after: stopped.word(),
            frames: clip.frames(),
            rate_hz: clip.rate_hz,
            duration_s: clip.duration_s(),
            mapping: mapping(done),
            momentum: done.momentum.as_ref().map(|m| MomentumNumbers {
                mass_ratio: m.mass_ratio,
                size_ratio: m.size_ratio.into(),
                inertia_ratio: m.inertia_ratio.into(),
                mismatch_percent: 100.0 * m.relative_rms,
            }),
            contact: done.contact.as_ref().map(|c| ContactNumbers {
                phases: PhaseNumbers::of(&done.phases),
                gave_way: PhaseNumbers::of(&done.gave_way),
                slip_mm: 1e3 * c.slip_m,
                penetration_mm: 1e3 * c.penetration_m,
                jerk_ratio: c.jerk_ratio,
            }),
            sway: done.sway.map(|s| SwayNumbers { joints: s.links, most_deg: s.most_rad.to_degrees() }),
            refinement: done.refinement.as_ref().map(|r| RefinementNumbers {
                mismatch_before_n2: r.before,
                mismatch_after_n2: r.after,
                vertical_fell_percent: fell(r.before[1], r.after[1]),
                all_fell_percent: fell(r.before.iter().sum(), r.after.iter().sum()),
                length_m: r.length_m,
                root_median_mm: 1e3 * r.root_median_m,
                root_largest_mm: 1e3 * r.root_largest_m,
                slip_mm: 1e3 * r.slip_m,
                cone_frames_before: r.cone_before.len(),
                cone_after_at_s: r.cone_after.iter().map(|&f| at(f)).collect(),
                collision_mm: r.collision_m.map(|m| 1e3 * m),
                iterations: r.iterations,
            }),
            stages: stage_report::stages(done),
            flights: stage_report::flights(done),
            warnings: stage_report::warnings(done),
            suggested,
            files: BTreeMap::new(),
        }
    }

    /// As JSON.
    ///
    /// # Panics
    /// Never: the type has no keys that are not text.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("a report is JSON") + "\n"
    }
}

fn mapping(done: &Retargeted) -> MappingNumbers {
    let m = &done.mapping;
    let frames = m.confidence.len().max(1) as f64;
    let least = (m.confidence.iter().enumerate()).min_by(|a, b| a.1.total_cmp(b.1)).map(|(i, &c)| (i, c));
    let at = |frame: usize| frame as f64 / done.clip.rate_hz;
    MappingNumbers {
        latent_dimensions: m.latent.first().map_or(0, Vec::len),
        confidence_mean: m.confidence.iter().sum::<f64>() / frames,
        confidence_least: least.map_or(0.0, |l| l.1),
        confidence_least_at_s: least.map_or(0.0, |l| at(l.0)),
        extrapolates: m.extrapolates.iter().filter(|&&e| e).count() as f64 / frames,
        jumps_at_s: m.jumps.iter().map(|&f| at(f)).collect(),
        fit_mm_mean: 1e3 * m.fit_rms_m.iter().sum::<f64>() / frames,
        fit_mm_max: 1e3 * m.fit_rms_m.iter().fold(0.0, |a: f64, &b| a.max(b)),
        confidence: m.confidence.clone(),
    }
}
