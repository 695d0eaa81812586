//! What the pipeline returns: the clip, the clip after each stage, and the numbers of each stage.

use motion::{Clip, Vec3};

use crate::bounds::StepReport;
use crate::options::PipelineStage;
use crate::phase::Phase;

/// A motion on a new body. One entry per frame in every vector.
#[derive(Clone, Debug, PartialEq)]
pub struct Retargeted {
    /// The result: the last stage's clip.
    pub clip: Clip,
    /// The clip after every stage that ran, in order: the columns of \[YAH10, Fig. 7\].
    pub stages: Vec<(PipelineStage, Clip)>,
    /// The human motion as it was used: on the performer's skeleton, resampled, smoothed, ground at 0.
    pub human: Clip,
    /// How sure the mapping is.
    pub mapping: MappingReport,
    /// Momentum, scaled human and character; `None` if stopped before.
    pub momentum: Option<MomentumReport>,
    /// Contact phases of the character's points; empty if stopped before.
    pub phases: Vec<Phase>,
    /// Numbers of the contact adjustment; `None` if stopped before.
    pub contact: Option<ContactReport>,
    /// How far parts swayed; `None` if none could or should, or if stopped before.
    pub sway: Option<SwayReport>,
    /// Numbers of the refinement; `None` if stopped before.
    pub refinement: Option<RefinementReport>,
    /// How far each stage went from the one before, of those that are held to bounds.
    pub steps: Vec<StepReport>,
    /// Parts of phases in which the character's points do not rest although the human's do: they could not be kept.
    pub gave_way: Vec<Phase>,
    /// The human's flights, and what became of them.
    pub flights: Vec<FlightReport>,
}

/// A flight of the human on the character.
#[derive(Clone, Debug, PartialEq)]
pub struct FlightReport {
    /// From, s.
    pub from_s: f64,
    /// To, s.
    pub to_s: f64,
    /// Greatest height of the human's lowest contact point, scaled by the statures, m.
    pub scaled_m: f64,
    /// Of the character's after each stage that ran, m.
    pub heights_m: Vec<(PipelineStage, f64)>,
}

/// How sure the mapping is, frame by frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MappingReport {
    /// Variance of a coordinate of a feature point, m²: (4); zero for models that know none.
    pub variance: Vec<f64>,
    /// 1 where the model is as sure as at a key pose, 0 where it knows nothing.
    pub confidence: Vec<f64>,
    /// Whether the model says that it extrapolates.
    pub extrapolates: Vec<bool>,
    /// Latent coordinates; empty for models without.
    pub latent: Vec<Vec<f64>>,
    /// Those of the key poses, as learned; empty for models without.
    pub key_latent: Vec<Vec<f64>>,
    /// Frames at which the latent answer jumped to another basin.
    pub jumps: Vec<usize>,
    /// RMS distance of the fitted body's feature points from the predicted ones, m.
    pub fit_rms_m: Vec<f64>,
}

/// Linear and angular momentum before and after.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MomentumReport {
    /// Mass ratio, character to human.
    pub mass_ratio: f64,
    /// Size ratio along X (width), Y (height), Z (depth) of the local frame.
    pub size_ratio: Vec3,
    /// Inertia ratio about X, Y, Z.
    pub inertia_ratio: Vec3,
    /// Scaled human linear momentum between frames, world, N·s; one fewer than frames.
    pub human: Vec<Vec3>,
    /// The character's, N·s.
    pub character: Vec<Vec3>,
    /// Scaled human angular momentum about the vertical through the centre of mass, N·m·s.
    pub human_spin: Vec<f64>,
    /// The character's, N·m·s.
    pub character_spin: Vec<f64>,
    /// RMS of the horizontal mismatch over the RMS of the scaled human's.
    pub relative_rms: f64,
}

/// What remains of slip, penetration and jerk at the contacts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactReport {
    /// Farthest horizontal way of a point from its place within a phase, m.
    pub slip_m: f64,
    /// Deepest penetration of a contact point, m.
    pub penetration_m: f64,
    /// Largest third difference near phase ends over that of the mapped motion, both of the contact points.
    pub jerk_ratio: f64,
}

/// How far parts that follow by dynamics left their keyed poses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SwayReport {
    /// Joints that sway.
    pub links: usize,
    /// Farthest turn of a joint from its keyed pose, rad.
    pub most_rad: f64,
}

/// Force mismatch and what it cost.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RefinementReport {
    /// `Z_p` per component before, `[F_x, F_y, F_z, N_x, N_y, N_z]`, with moments over the stated length, N²
    /// summed over frames.
    pub before: [f64; 6],
    /// After.
    pub after: [f64; 6],
    /// Length by which moments are divided, m.
    pub length_m: f64,
    /// Weight of the body under the gravity that was reckoned with, N.
    pub weight_n: f64,
    /// Force that the motion requires from outside before, world, N.
    pub required_before: Vec<Vec3>,
    /// Force of the contact model before, world, N.
    pub contact_before: Vec<Vec3>,
    /// Required force after, world, N.
    pub required_after: Vec<Vec3>,
    /// Force of the contact model after, world, N.
    pub contact_after: Vec<Vec3>,
    /// Median displacement of the root, m.
    pub root_median_m: f64,
    /// Largest displacement of the root, m.
    pub root_largest_m: f64,
    /// Slip as in [`ContactReport`], m.
    pub slip_m: f64,
    /// Frames where the required horizontal force leaves the friction cone while a point is in contact.
    pub cone_before: Vec<usize>,
    /// The same after.
    pub cone_after: Vec<usize>,
    /// Deepest penetration of body and body or body and scene, before and after, m.
    pub collision_m: [f64; 2],
    /// Levenberg–Marquardt steps taken, of the stretch with most.
    pub iterations: usize,
}
