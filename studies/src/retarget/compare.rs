//! The five models side by side, on one motion and on the key poses.
//!
//! In: a [`Session`]. Out: a [`ModelRow`] for each model. The error at a key pose is the RMS over all joints but the
//! root of the angle between the pose that is mapped and the one that was made.

use motion::metrics::{joint_errors, joint_rms_deg};
use motion::names::Word;
use motion::{Clip, Skeleton};
use nalgebra::DMatrix;
use retarget::mapping::map_clip;
use retarget::{
    GplvmOptions, KeyPoses, Locate, Mapping, MappingModel, Options, PipelineStage, RetargetError, Retargeted,
};
use serde::Serialize;

use takes::retargeting::{RetargetingError, Session};

/// What one model does.
#[derive(Clone, Debug, Serialize)]
pub struct ModelRow {
    /// Its name.
    pub model: &'static str,
    /// RMS error at the key poses it has learned, degrees.
    pub learned_deg: f64,
    /// RMS error at key poses left out one by one, degrees.
    pub left_out_deg: f64,
    /// RMS error at the key poses of a performance when all of that performance are left out, degrees.
    pub performance_left_out_deg: f64,
    /// RMS third difference of the mapped joint angles over the human's, both per frame.
    pub jerk_ratio: f64,
    /// Force mismatch after the refinement, share of that before, %; `None` if the pipeline stopped earlier.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mismatch_left_percent: Option<f64>,
}

/// Runs all models; the shared GPLVM a second time with latent points searched as in the paper.
///
/// # Errors
/// As [`Session::learn`] and [`Session::run`].
pub fn compare(session: &Session, options: &Options) -> Result<Vec<ModelRow>, RetargetingError> {
    let one = |model: MappingModel| row(session, &Options { model, ..options.clone() }, model.word());
    let mut rows = MappingModel::ALL.iter().map(|&model| one(model)).collect::<Result<Vec<_>, _>>()?;
    let gplvm = GplvmOptions { locate: Locate::Posterior, ..options.gplvm.clone() };
    let searched = Options { model: MappingModel::Gplvm, gplvm, ..options.clone() };
    rows.push(row(session, &searched, "search")?);
    Ok(rows)
}

fn row(session: &Session, options: &Options, model: &'static str) -> Result<ModelRow, RetargetingError> {
    let fault = |e| session.fault(e);
    let mapping = session.learn(options)?;
    let done = session.run(&mapping, options)?;
    let pairs = &session.key_poses.key_poses;
    let all: Vec<usize> = (0..pairs.pairs.len()).collect();
    let one_by_one: Vec<Vec<usize>> = all.iter().map(|&i| vec![i]).collect();
    let mut groups: Vec<&str> = pairs.pairs.iter().map(|p| p.group.as_str()).collect();
    groups.sort_unstable();
    groups.dedup();
    let by_group: Vec<Vec<usize>> = (groups.iter())
        .map(|g| all.iter().copied().filter(|&i| pairs.pairs[i].group == *g).collect())
        .collect();
    let body = &session.performance.performer.character.skeleton;
    Ok(ModelRow {
        model,
        learned_deg: error_deg(session, &mapping, &all).map_err(fault)?,
        left_out_deg: left_out_deg(session, options, &one_by_one).map_err(fault)?,
        performance_left_out_deg: left_out_deg(session, options, &by_group).map_err(fault)?,
        jerk_ratio: jerk(&session.actor.puppet.character.skeleton, &done.stages[0].1)
            / jerk(body, &done.human).max(1e-300),
        mismatch_left_percent: (options.stop_after == PipelineStage::Refine)
            .then_some(done.refinement.as_ref())
            .flatten()
            .map(|r| 100.0 * r.after.iter().sum::<f64>() / r.before.iter().sum::<f64>().max(1e-300)),
    })
}

/// A mapping learned from some of the key poses only.
///
/// # Errors
/// As [`Mapping::learn`].
pub fn learn_from(session: &Session, keep: &[usize], options: &Options) -> Result<Mapping, RetargetError> {
    let pairs = &session.key_poses.key_poses.pairs;
    let seen = KeyPoses { pairs: keep.iter().map(|&i| pairs[i].clone()).collect() };
    Mapping::learn(&session.actor.puppet, &seen, options.model, &options.gplvm)
}

/// RMS error (degrees) at the pairs of each fold by a model that has not seen them.
///
/// # Errors
/// As [`Mapping::learn`].
pub fn left_out_deg(
    session: &Session,
    options: &Options,
    folds: &[Vec<usize>],
) -> Result<f64, RetargetError> {
    let (mut sum, mut count) = (0.0, 0.0);
    for fold in folds {
        let keep: Vec<usize> =
            (0..session.key_poses.key_poses.pairs.len()).filter(|i| !fold.contains(i)).collect();
        let mapping = learn_from(session, &keep, options)?;
        sum += error_deg(session, &mapping, fold)?.powi(2) * fold.len() as f64;
        count += fold.len() as f64;
    }
    Ok((sum / f64::max(count, 1.0)).sqrt())
}

/// RMS error (degrees) of a mapping at these pairs.
///
/// # Errors
/// As [`retarget::mapping::Mapper::map`].
pub fn error_deg(session: &Session, mapping: &Mapping, which: &[usize]) -> Result<f64, RetargetError> {
    let character = &session.actor.puppet.character;
    let (mut mapped, mut made) = (Vec::new(), Vec::new());
    for &i in which {
        let p = &session.key_poses.key_poses.pairs[i];
        let mut q = character.rest.clone();
        mapping.mapper(&p.performer).map(&p.human, &mut q)?;
        mapped.extend(q);
        made.extend_from_slice(&p.character);
    }
    let clip = |poses| Clip::new(character.skeleton.clone(), 1.0, poses);
    Ok(joint_rms_deg(&joint_errors(&clip(mapped), &clip(made))))
}

/// RMS change of the change of the joints' steps, rad per frame cubed.
fn jerk(skeleton: &Skeleton, clip: &Clip) -> f64 {
    let (frames, nv) = (clip.frames(), skeleton.nv());
    if frames < 4 || nv <= 6 {
        return 0.0;
    }
    let steps: Vec<Vec<f64>> = (1..frames)
        .map(|f| {
            let mut step = vec![0.0; nv];
            skeleton.difference(clip.pose(f - 1), clip.pose(f), 1.0, &mut step);
            step
        })
        .collect();
    let bends = steps.windows(3).flat_map(|s| (6..nv).map(|d| s[2][d] - 2.0 * s[1][d] + s[0][d]));
    (bends.map(|x| x * x).sum::<f64>() / ((frames - 3) * (nv - 6)) as f64).sqrt()
}

/// The path of the motion in a latent space of other dimension, and the key poses in it.
#[derive(Clone, Debug)]
pub struct Latent {
    /// Dimensions.
    pub dimensions: usize,
    /// Every frame.
    pub frames: Vec<Vec<f64>>,
    /// Every key pose.
    pub keys: Vec<Vec<f64>>,
    /// Jerk of the path over its extent, 1/s³ ([`learn::PathShape`]); 0 for a path that stays.
    pub jerk: f64,
    /// Frames at which the answer jumped.
    pub jumps: usize,
}

/// The path of a motion through the latent space that it was mapped by; `None` of a model without.
pub fn latent_path(done: &Retargeted) -> Option<Latent> {
    let m = &done.mapping;
    let dimensions = m.latent.first()?.len();
    Some(Latent {
        dimensions,
        jerk: path_jerk(&m.latent, dimensions, done.human.rate_hz),
        frames: m.latent.clone(),
        keys: m.key_latent.clone(),
        jumps: m.jumps.len(),
    })
}

/// Jerk of a latent path over its extent, 1/s³; 0 for a path that stays.
fn path_jerk(path: &[Vec<f64>], dimensions: usize, rate_hz: f64) -> f64 {
    let points = DMatrix::from_fn(path.len(), dimensions, |i, k| path[i][k]);
    learn::path_shape(&points, rate_hz).map_or(0.0, |s| s.relative_jerk)
}

/// Maps the motion through latent spaces of these dimensions; those that the pairs do not allow are left out.
///
/// # Errors
/// As [`Mapping::learn`].
pub fn latent_paths(
    session: &Session,
    human: &Clip,
    gplvm: &GplvmOptions,
    dimensions: &[usize],
) -> Result<Vec<Latent>, RetargetingError> {
    let (puppet, pairs) = (&session.actor.puppet, &session.key_poses.key_poses);
    let path = |d: usize| -> Result<Latent, RetargetError> {
        let gplvm = GplvmOptions { dimension: Some(d), ..gplvm.clone() };
        let mapping = Mapping::learn(puppet, pairs, MappingModel::Gplvm, &gplvm)?;
        let (_, report) = map_clip(&mapping, &session.performance.performer, human, puppet)?;
        let mut keys = Vec::new();
        for p in &pairs.pairs {
            let mut mapper = mapping.mapper(&p.performer);
            mapper.map(&p.human, &mut puppet.character.rest.clone())?;
            keys.extend(mapper.latent().map(<[f64]>::to_vec));
        }
        let jerk = path_jerk(&report.latent, d, human.rate_hz);
        Ok(Latent { dimensions: d, frames: report.latent, keys, jerk, jumps: report.jumps.len() })
    };
    allowed(dimensions, pairs.pairs.len())
        .into_iter()
        .map(|d| path(d).map_err(|e| session.fault(e)))
        .collect()
}

/// These dimensions of a latent space, none above min(30, N − 1) for N pairs.
pub fn allowed(dimensions: &[usize], pairs: usize) -> Vec<usize> {
    let mut wanted: Vec<usize> = dimensions.iter().map(|&d| d.min(30).min(pairs - 1)).collect();
    wanted.dedup();
    wanted
}
