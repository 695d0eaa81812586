//! The five models side by side, on one motion and on the key poses.
//!
//! In: a [`Session`]. Out: a [`ModelRow`] for each model. The error at a key pose is the RMS over all joints but the
//! root of the angle between the pose that is mapped and the one that was made.

use motion::{Joint, Skeleton};
use retarget::mapping::map_clip;
use retarget::{KeyPoses, Mapping, MappingModel, Options, RetargetError, Stage};
use serde::Serialize;

use super::{RetargetingError, Session};

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

/// Runs all models.
///
/// # Errors
/// As [`Session::learn`] and [`Session::run`].
pub fn compare(session: &Session, options: &Options) -> Result<Vec<ModelRow>, RetargetingError> {
    MappingModel::ALL.iter().map(|&model| row(session, &Options { model, ..options.clone() })).collect()
}

fn row(session: &Session, options: &Options) -> Result<ModelRow, RetargetingError> {
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
    let learned = errors(session, &mapping, pairs, &all).map_err(fault)?;
    let mapped = &done.stages[0].1;
    let body = &session.performance.performer.character.skeleton;
    Ok(ModelRow {
        model: options.model.name(),
        learned_deg: rms(&learned),
        left_out_deg: rms(&left_out(session, options, &one_by_one).map_err(fault)?),
        performance_left_out_deg: rms(&left_out(session, options, &by_group).map_err(fault)?),
        jerk_ratio: jerk(&session.actor.puppet.character.skeleton, mapped)
            / jerk(body, &done.human).max(1e-300),
        mismatch_left_percent: (options.stop_after == Stage::Refine)
            .then_some(done.refinement.as_ref())
            .flatten()
            .map(|r| 100.0 * r.after.iter().sum::<f64>() / r.before.iter().sum::<f64>().max(1e-300)),
    })
}

/// Errors of the pairs of each fold by a model that has not seen them.
fn left_out(session: &Session, options: &Options, folds: &[Vec<usize>]) -> Result<Vec<f64>, RetargetError> {
    let pairs = &session.key_poses.key_poses;
    let mut out = Vec::new();
    for fold in folds {
        let rest = pairs.pairs.iter().enumerate().filter(|(i, _)| !fold.contains(i)).map(|(_, p)| p.clone());
        let seen = KeyPoses { pairs: rest.collect() };
        let mapping = Mapping::learn(&session.actor.puppet, &seen, options.model, options.latent)?;
        out.extend(errors(session, &mapping, pairs, fold)?);
    }
    Ok(out)
}

/// RMS over the joints, rad, for each of these pairs.
fn errors(
    session: &Session,
    mapping: &Mapping,
    pairs: &KeyPoses,
    which: &[usize],
) -> Result<Vec<f64>, RetargetError> {
    let character = &session.actor.puppet.character;
    let mut out = Vec::new();
    for &i in which {
        let p = &pairs.pairs[i];
        let mut q = character.rest.clone();
        mapping.mapper(&p.performer).map(&p.human, &mut q)?;
        out.push(apart(&character.skeleton, &q, &p.character));
    }
    Ok(out)
}

/// RMS angle over all joints but the root, rad.
fn apart(skeleton: &Skeleton, a: &[f64], b: &[f64]) -> f64 {
    let angles: Vec<f64> = (skeleton.links().iter().enumerate().skip(1))
        .filter_map(|(i, l)| match l.joint {
            Joint::Free | Joint::Spherical => {
                Some(skeleton.rotation(a, i).angle_to(&skeleton.rotation(b, i)))
            }
            Joint::Revolute(_) => Some((a[skeleton.q_at(i)] - b[skeleton.q_at(i)]).abs()),
            Joint::Prismatic(_) | Joint::Fixed => None,
        })
        .collect();
    (angles.iter().map(|x| x * x).sum::<f64>() / angles.len().max(1) as f64).sqrt()
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64).sqrt().to_degrees()
}

/// RMS change of the change of the joints' steps, rad per frame cubed.
fn jerk(skeleton: &Skeleton, clip: &motion::Clip) -> f64 {
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
    /// RMS third difference of the path over its RMS distance from its mean.
    pub jerk: f64,
    /// Frames at which the answer jumped.
    pub jumps: usize,
}

/// RMS third difference of a path over its RMS distance from its mean; 0 for one that stays.
fn roughness(path: &[Vec<f64>]) -> f64 {
    let Some(first) = path.first() else { return 0.0 };
    let n = path.len() as f64;
    let mean: Vec<f64> = (0..first.len()).map(|d| path.iter().map(|x| x[d]).sum::<f64>() / n).collect();
    let spread: f64 = path.iter().flatten().zip(mean.iter().cycle()).map(|(x, m)| (x - m).powi(2)).sum();
    let third = |w: &[Vec<f64>], d: usize| w[3][d] - 3.0 * w[2][d] + 3.0 * w[1][d] - w[0][d];
    let bends: f64 =
        path.windows(4).map(|w| (0..first.len()).map(|d| third(w, d).powi(2)).sum::<f64>()).sum();
    if spread > 0.0 { (bends / (n - 3.0).max(1.0) / (spread / n)).sqrt() } else { 0.0 }
}

/// Maps the motion through latent spaces of these dimensions; those that the pairs do not allow are left out.
///
/// # Errors
/// As [`Mapping::learn`].
pub fn latent_paths(
    session: &Session,
    human: &motion::Clip,
    dimensions: &[usize],
) -> Result<Vec<Latent>, RetargetingError> {
    let (puppet, pairs) = (&session.actor.puppet, &session.key_poses.key_poses);
    let most = 30.min(pairs.pairs.len() - 1);
    let mut wanted: Vec<usize> = dimensions.iter().map(|&d| d.min(most)).collect();
    wanted.dedup();
    let path = |d: usize| -> Result<Latent, RetargetError> {
        let mapping = Mapping::learn(puppet, pairs, MappingModel::Gplvm, Some(d))?;
        let (_, report) = map_clip(&mapping, &session.performance.performer, human, puppet)?;
        let mut keys = Vec::new();
        for p in &pairs.pairs {
            let mut mapper = mapping.mapper(&p.performer);
            mapper.map(&p.human, &mut puppet.character.rest.clone())?;
            keys.extend(mapper.latent().map(<[f64]>::to_vec));
        }
        let jerk = roughness(&report.latent);
        Ok(Latent { dimensions: d, frames: report.latent, keys, jerk, jumps: report.jumps.len() })
    };
    wanted.into_iter().map(|d| path(d).map_err(|e| session.fault(e))).collect()
}
