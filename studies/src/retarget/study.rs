//! How good is a set of key poses, and what would make it better?
//!
//! In: a [`Session`]. Out: a [`Study`]: whether like human poses have like character poses, the criteria for the latent
//! dimension \[YAH10, §6.2\], what becomes of this performance without its own key poses, and whether suggested key
//! poses teach more than random ones. Errors are RMS angles over all joints but the root, degrees. Seeds are fixed:
//! same input, same numbers.
//!
//! \[YAH10\] Yamane, Ariki, Hodgins. Animating Non-Humanoid Characters with Human Motion Data, SCA 2010.

use motion::Clip;
use motion::metrics::{joint_errors, joint_rms_deg};
use motion::names::Word;
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64;
use retarget::mapping::map_clip;
use retarget::{GplvmOptions, Locate, MappingModel, Options, RetargetError};
use serde::Serialize;

use super::compare::{Latent, allowed, error_deg, latent_paths, learn_from, left_out_deg};
use takes::retargeting::{RetargetingError, Session};

/// Dimensions looked at.
const DIMENSIONS: [usize; 6] = [2, 5, 10, 15, 20, 30];
/// Draws of the experiment with suggestions.
const SEEDS: u64 = 20;
/// Key poses added there.
const ADDED: usize = 5;

/// What a study finds.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    /// Whether like human poses have like character poses.
    pub agreement: Agreement,
    /// A row for each dimension of the latent space.
    pub dimensions: Vec<DimensionRow>,
    /// The path of the motion through each.
    #[serde(skip)]
    pub paths: Vec<Latent>,
    /// This performance without its own key poses; `None` if it has none, or no others are left.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dropped: Option<Dropped>,
    /// Suggested key poses against random ones; `None` with fewer than 20 pairs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub suggestions: Option<Suggestions>,
}

/// Whether like human poses have like character poses: what any model can hope for.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Agreement {
    /// Spearman's rank correlation of the distances between two human poses and between their character poses, over
    /// all pairs of pairs.
    pub rank_correlation: f64,
    /// RMS difference of a character pose from that of the most similar *human* pose, degrees.
    pub of_nearest_human_deg: f64,
    /// RMS difference of a character pose from the most similar other one: no model that answers with one of the
    /// others can do better, degrees.
    pub of_nearest_character_deg: f64,
    /// Least difference between two character poses, degrees.
    pub least_deg: f64,
}

/// The criteria at one dimension of the latent space.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct DimensionRow {
    /// Dimensions.
    pub dimensions: usize,
    /// RMS error at the key poses learned, degrees.
    pub learned_deg: f64,
    /// RMS error at key poses left out one by one, degrees.
    pub left_out_deg: f64,
    /// Jerk of the latent path over its extent, 1/s³.
    pub jerk_s3: f64,
    /// The same with latent points searched as in the paper: error at the key poses learned, degrees.
    pub search_learned_deg: f64,
    /// With latent points searched: jerk of the path over its extent, 1/s³.
    pub search_jerk_s3: f64,
    /// With latent points searched: frames at which the answer jumped.
    pub search_jumps: usize,
}

/// A performance without its own key poses.
#[derive(Clone, Debug, Serialize)]
pub struct Dropped {
    /// Key poses dropped.
    pub key_poses: usize,
    /// Key poses left.
    pub left: usize,
    /// RMS error at the dropped key poses for each model, degrees.
    pub error_deg: Vec<(&'static str, f64)>,
    /// RMS difference between the motion mapped with and without them, over all frames, degrees.
    pub from_full_deg: f64,
    /// The spread of the motion mapped with them, which `from_full_deg` is to be seen against: RMS difference of
    /// poses half the motion apart, over √2, degrees.
    pub extent_deg: f64,
    /// The motion mapped with all key poses and without its own.
    #[serde(skip)]
    pub clips: [Clip; 2],
}

/// Whether suggested key poses teach more than random ones: 40 % of the pairs are known at first; five of the others
/// are added; the error is that at all others, and at those of them that neither way added.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Suggestions {
    /// Draws.
    pub seeds: u64,
    /// Median error before, at all pairs not known at first, degrees.
    pub before_deg: f64,
    /// Median by which five random poses lower it, degrees.
    pub random_gain_deg: f64,
    /// Median by which five suggested poses lower it, degrees.
    pub suggested_gain_deg: f64,
    /// The same at poses that neither added: random.
    pub random_gain_elsewhere_deg: f64,
    /// The same at poses that neither added: suggested.
    pub suggested_gain_elsewhere_deg: f64,
}

/// Studies the key poses of a session on its performance.
///
/// # Errors
/// As [`Session::learn`] and [`Session::run`].
pub fn study(session: &Session, human: &Clip) -> Result<Study, RetargetingError> {
    let fault = |e: RetargetError| session.fault(e);
    let (dimensions, paths) = dimensions(session, human)?;
    Ok(Study {
        agreement: agreement(session),
        dimensions,
        paths,
        dropped: dropped(session, human).map_err(fault)?,
        suggestions: suggestions(session).map_err(fault)?,
    })
}

/// A pose as a clip of one frame.
fn one(session: &Session, i: usize) -> Clip {
    let pose = session.key_poses.key_poses.pairs[i].character.clone();
    Clip::new(session.actor.puppet.character.skeleton.clone(), 1.0, pose)
}

fn agreement(session: &Session) -> Agreement {
    let (y, _) = session.key_poses.key_poses.observations(&session.actor.puppet);
    let n = y.nrows();
    let clips: Vec<Clip> = (0..n).map(|i| one(session, i)).collect();
    let (mut human, mut character) =
        (DMatrix::from_element(n, n, f64::INFINITY), DMatrix::from_element(n, n, f64::INFINITY));
    for i in 0..n {
        for j in 0..i {
            human[(i, j)] = (y.row(i) - y.row(j)).norm();
            character[(i, j)] = joint_rms_deg(&joint_errors(&clips[i], &clips[j]));
            human[(j, i)] = human[(i, j)];
            character[(j, i)] = character[(i, j)];
        }
    }
    let below = |m: &DMatrix<f64>| -> Vec<f64> {
        (0..n).flat_map(|i| (0..i).map(move |j| (i, j))).map(|at| m[at]).collect()
    };
    let nearest = |by: &DMatrix<f64>| {
        let sum: f64 = (0..n).map(|i| character[(i, by.column(i).imin())].powi(2)).sum();
        (sum / n as f64).sqrt()
    };
    Agreement {
        rank_correlation: correlation(&ranks(&below(&human)), &ranks(&below(&character))),
        of_nearest_human_deg: nearest(&human),
        of_nearest_character_deg: nearest(&character),
        least_deg: character.min(),
    }
}

/// Rank of every value, from 0; equal values share the mean of their ranks.
fn ranks(v: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..v.len()).collect();
    order.sort_by(|&a, &b| v[a].total_cmp(&v[b]));
    let mut ranks = vec![0.0; v.len()];
    let mut first = 0;
    for equal in order.chunk_by(|&a, &b| v[a] == v[b]) {
        let mean = first as f64 + 0.5 * (equal.len() - 1) as f64;
        equal.iter().for_each(|&i| ranks[i] = mean);
        first += equal.len();
    }
    ranks
}

/// Pearson's correlation; 0 without spread.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (ma, mb) = (mean(a), mean(b));
    let sum = |f: &dyn Fn(f64, f64) -> f64| a.iter().zip(b).map(|(a, b)| f(a - ma, b - mb)).sum::<f64>();
    let spread = (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt();
    if spread > 0.0 { sum(&|a, b| a * b) / spread } else { 0.0 }
}

fn dimensions(session: &Session, human: &Clip) -> Result<(Vec<DimensionRow>, Vec<Latent>), RetargetingError> {
    let n = session.key_poses.key_poses.pairs.len();
    let all: Vec<usize> = (0..n).collect();
    let one_by_one: Vec<Vec<usize>> = all.iter().map(|&i| vec![i]).collect();
    let by = |locate| GplvmOptions { locate, ..GplvmOptions::default() };
    let wanted = allowed(&DIMENSIONS, n);
    let back = latent_paths(session, human, &by(Locate::Back), &wanted)?;
    let search = latent_paths(session, human, &by(Locate::Posterior), &wanted)?;
    let row = |(i, &d): (usize, &usize)| -> Result<DimensionRow, RetargetError> {
        let options = |locate| Options {
            gplvm: GplvmOptions { dimension: Some(d), ..by(locate) },
            ..Options::default()
        };
        let learned = |locate| error_deg(session, &learn_from(session, &all, &options(locate))?, &all);
        // A fold has one pair less.
        let mut fold = options(Locate::Back);
        fold.gplvm.dimension = Some(d.min(n - 2));
        Ok(DimensionRow {
            dimensions: d,
            learned_deg: learned(Locate::Back)?,
            left_out_deg: left_out_deg(session, &fold, &one_by_one)?,
            jerk_s3: back[i].jerk,
            search_learned_deg: learned(Locate::Posterior)?,
            search_jerk_s3: search[i].jerk,
            search_jumps: search[i].jumps,
        })
    };
    let rows = wanted.iter().enumerate().map(|d| row(d).map_err(|e| session.fault(e)));
    let rows = rows.collect::<Result<_, _>>()?;
    Ok((rows, back))
}

fn dropped(session: &Session, human: &Clip) -> Result<Option<Dropped>, RetargetError> {
    let pairs = &session.key_poses.key_poses.pairs;
    let (out, keep): (Vec<usize>, Vec<usize>) =
        (0..pairs.len()).partition(|&i| pairs[i].group == session.performance.name);
    if out.is_empty() || keep.len() < MappingModel::Nn10.least_pairs() {
        return Ok(None);
    }
    let all: Vec<usize> = (0..pairs.len()).collect();
    let map = |keep: &[usize]| -> Result<Clip, RetargetError> {
        let mapping = learn_from(session, keep, &Options::default())?;
        Ok(map_clip(&mapping, &session.performance.performer, human, &session.actor.puppet)?.0)
    };
    let (full, without) = (map(&all)?, map(&keep)?);
    let mut error = Vec::new();
    for model in MappingModel::ALL {
        let mapping = learn_from(session, &keep, &Options { model, ..Options::default() })?;
        error.push((model.word(), error_deg(session, &mapping, &out)?));
    }
    // The squared difference of two unrelated poses is twice that from their mean.
    let turned: Vec<f64> = (0..full.frames())
        .flat_map(|f| full.pose((f + full.frames() / 2) % full.frames()).to_vec())
        .collect();
    let other = Clip::new(full.skeleton.clone(), full.rate_hz, turned);
    Ok(Some(Dropped {
        key_poses: out.len(),
        left: keep.len(),
        error_deg: error,
        from_full_deg: joint_rms_deg(&joint_errors(&full, &without)),
        extent_deg: joint_rms_deg(&joint_errors(&full, &other)) / std::f64::consts::SQRT_2,
        clips: [full, without],
    }))
}

fn suggestions(session: &Session) -> Result<Option<Suggestions>, RetargetError> {
    let (y, _) = session.key_poses.key_poses.observations(&session.actor.puppet);
    let n = y.nrows();
    if n < 20 {
        return Ok(None);
    }
    let options = Options::default();
    // before, then gains: random, suggested; elsewhere: random, suggested
    let mut all: [Vec<f64>; 5] = Default::default();
    for seed in 0..SEEDS {
        let mut order: Vec<usize> = (0..n).collect();
        order.shuffle(&mut Pcg64::seed_from_u64(seed));
        let (known, others) = order.split_at(2 * n / 5);
        let mapping = learn_from(session, known, &options)?;
        let named = mapping.suggest_among(&y.select_rows(others), ADDED)?;
        let suggested: Vec<usize> = named.into_iter().map(|i| others[i]).collect();
        let random = &others[..ADDED];
        let neither: Vec<usize> =
            others.iter().copied().filter(|i| !suggested.contains(i) && !random.contains(i)).collect();
        let before = [others, &neither].map(|which| error_deg(session, &mapping, which));
        let [before, before_elsewhere] = [before[0].clone()?, before[1].clone()?];
        all[0].push(before);
        for (k, added) in [random, &suggested].into_iter().enumerate() {
            let mapping = learn_from(session, &[known, added].concat(), &options)?;
            all[1 + k].push(before - error_deg(session, &mapping, others)?);
            all[3 + k].push(before_elsewhere - error_deg(session, &mapping, &neither)?);
        }
    }
    let [
        before_deg,
        random_gain_deg,
        suggested_gain_deg,
        random_gain_elsewhere_deg,
        suggested_gain_elsewhere_deg,
    ] = all.map(median);
    Ok(Some(Suggestions {
        seeds: SEEDS,
        before_deg,
        random_gain_deg,
        suggested_gain_deg,
        random_gain_elsewhere_deg,
        suggested_gain_elsewhere_deg,
    }))
}

fn median(mut v: Vec<f64>) -> f64 {
    v.sort_by(f64::total_cmp);
    let m = v.len() / 2;
    if v.len().is_multiple_of(2) { 0.5 * (v[m - 1] + v[m]) } else { v[m] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values that are all equal have no order to agree on; nothing has none either.
    #[test]
    fn there_is_no_correlation_where_nothing_differs() {
        let of = |a: &[f64], b: &[f64]| correlation(&ranks(a), &ranks(b));
        assert_eq!(of(&[], &[]), 0.0);
        assert_eq!(of(&[0.0; 4], &[0.0; 4]), 0.0);
        assert_eq!(of(&[0.0; 3], &[1.0, 2.0, 3.0]), 0.0);
        assert_eq!(ranks(&[2.0, 1.0, 2.0, 0.0]), [2.5, 1.0, 2.5, 0.0]);
        assert!((of(&[1.0, 5.0, 9.0], &[2.0, 3.0, 7.0]) - 1.0).abs() < 1e-12);
    }
}
