//! Static mapping: a character's pose for each human pose, frame by frame \[YAH10, §4\].
//!
//! In: key poses, then human poses one after the other. Out: character poses in their local frame, and how sure the
//! model is. A regressor of `learn` maps feature points to feature points; [`JointFit`] makes joint angles of them,
//! starting from the frame before. Where that fits suddenly worse, a fit from the points alone is tried too, and kept
//! only if it is far better, because it can turn the body over from one frame to the next.
//!
//! \[YAH10\] Yamane, Ariki, Hodgins. Animating Non-Humanoid Characters with Human Motion Data, SCA 2010.

use learn::{GplvmOptions, Model, Pairs};
use motion::{Clip, Kinematics};

use crate::fit::{Fit, JointFit};
use crate::global_transform::has_free_root;
use crate::options::MappingModel;
use crate::result::MappingReport;
use crate::{KeyPoses, Performer, Puppet, RetargetError};

/// A fit this many times worse than the one before is tried afresh, …
const WORSE: f64 = 2.0;
/// … if it is worse than this, m; …
const WORSE_M: f64 = 0.001;
/// … and the other is kept if it is better by this factor.
const BETTER: f64 = 0.5;

/// A mapping learned from key poses.
#[derive(Clone, Debug)]
pub struct Mapping {
    /// The statistical model.
    pub model: Model,
    fit: JointFit,
    /// Names of the human feature points it was learned from.
    points: Vec<String>,
    /// The character's poses it was learned from (`nq` each).
    pub poses: Vec<Vec<f64>>,
}

/// One frame mapped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MappedFrame {
    /// Variance of a coordinate of a feature point, m².
    pub variance: f64,
    /// 1 is sure, 0 knows nothing.
    pub confidence: f64,
    /// Whether the human pose is farther from all key poses than these are from one another.
    pub extrapolates: bool,
    /// Whether the latent answer jumped.
    pub jumped: bool,
    /// How well a body fits the predicted points.
    pub fit: Fit,
}

impl Mapping {
    /// Learns from checked key poses; `gplvm` are the settings of the shared GPLVM, which other models do not need.
    ///
    /// # Errors
    /// What [`KeyPoses::check`] finds, a puppet whose root is not free, what the model says.
    pub fn learn(
        puppet: &Puppet,
        key_poses: &KeyPoses,
        model: MappingModel,
        gplvm: &GplvmOptions,
    ) -> Result<Self, RetargetError> {
        if !has_free_root(&puppet.character) {
            let (character, link) =
                (puppet.character.name.clone(), puppet.character.skeleton.links()[0].name.clone());
            return Err(RetargetError::Root { character, link });
        }
        key_poses.check(puppet)?;
        let (y, z) = key_poses.observations(puppet);
        let fault = |e: learn::FitError| RetargetError::Learn(e.to_string());
        let pairs = Pairs::new(&y, &z).map_err(fault)?;
        let model = Model::fit(model.method(), &pairs, gplvm).map_err(fault)?;
        let names = key_poses.pairs[0].performer.features.points.iter().map(|p| p.name.clone()).collect();
        let poses = key_poses.pairs.iter().map(|p| p.character.clone()).collect();
        let fit = JointFit::new(&puppet.character.skeleton, &puppet.features);
        Ok(Self { model, fit, points: names, poses })
    }

    /// Checks that a performer has the feature points that the key poses have.
    ///
    /// # Errors
    /// Those that are missing; or the same points in another order.
    pub fn fits(&self, performer: &Performer) -> Result<(), RetargetError> {
        let own: Vec<&str> = performer.features.points.iter().map(|p| p.name.as_str()).collect();
        if own == self.points {
            return Ok(());
        }
        let missing: Vec<String> =
            self.points.iter().filter(|n| !own.contains(&n.as_str())).cloned().collect();
        let whose = performer.character.name.clone();
        Err(RetargetError::MarkersMissing {
            whose,
            missing: if missing.is_empty() { self.points.clone() } else { missing },
        })
    }

    /// Latent points of the key poses, as learned; none of models without latent space.
    pub fn key_latent(&self) -> Vec<Vec<f64>> {
        let Model::Gplvm(model) = &self.model else { return Vec::new() };
        model.latents().row_iter().map(|point| point.iter().copied().collect()).collect()
    }

    /// Before the first frame of a sequence.
    pub fn mapper<'m>(&'m self, performer: &'m Performer) -> Mapper<'m> {
        let skeleton = &performer.character.skeleton;
        Mapper {
            inner: learn::Mapper::new(&self.model),
            performer,
            k: Kinematics::new(skeleton, &skeleton.zero_pose()),
            features: vec![0.0; performer.features.len()],
            fit: self.fit.clone(),
            other: Vec::new(),
            before_m: None,
        }
    }
}

/// Maps frame after frame, each starting from the one before.
pub struct Mapper<'m> {
    inner: learn::Mapper<'m, Model>,
    performer: &'m Performer,
    k: Kinematics,
    features: Vec<f64>,
    fit: JointFit,
    other: Vec<f64>,
    before_m: Option<f64>,
}

impl Mapper<'_> {
    /// Maps a human pose (`nq` of the performer, ground at 0) to a pose of the puppet in its local frame, `q`,
    /// which should hold the previous frame's.
    ///
    /// # Errors
    /// A pose that is not finite.
    pub fn map(&mut self, human: &[f64], q: &mut [f64]) -> Result<MappedFrame, RetargetError> {
        self.k.update(&self.performer.character.skeleton, human);
        self.performer.features.read(&self.k, 0.0, &mut self.features);
        let out = self.inner.map(&self.features).map_err(|e| RetargetError::Learn(e.to_string()))?;
        let mut fit = self.fit.solve(&out.mean, q, self.before_m.is_none());
        if self.before_m.is_some_and(|b| fit.rms_m > WORSE * b && fit.rms_m > WORSE_M) {
            self.other.clear();
            self.other.extend_from_slice(q);
            let again = self.fit.solve(&out.mean, &mut self.other, true);
            if again.rms_m < BETTER * fit.rms_m {
                q.copy_from_slice(&self.other);
                fit = again;
            }
        }
        self.fit.keep(&out.mean, q);
        self.before_m = Some(fit.rms_m);
        Ok(MappedFrame {
            variance: out.variance,
            confidence: out.confidence,
            extrapolates: out.extrapolates(),
            jumped: self.inner.jump().is_some(),
            fit,
        })
    }

    /// Latent point of the last frame; `None` for models without latent space.
    pub fn latent(&self) -> Option<&[f64]> {
        self.inner.latent()
    }
}

/// Maps a prepared human clip; the result is in the puppet's local frame.
///
/// # Errors
/// As [`Mapping::fits`] and [`Mapper::map`].
pub fn map_clip(
    mapping: &Mapping,
    performer: &Performer,
    human: &Clip,
    puppet: &Puppet,
) -> Result<(Clip, MappingReport), RetargetError> {
    mapping.fits(performer)?;
    let skeleton = &puppet.character.skeleton;
    let mut mapper = mapping.mapper(performer);
    let (mut q, mut all) = (puppet.character.rest.clone(), Vec::new());
    let mut report = MappingReport { key_latent: mapping.key_latent(), ..MappingReport::default() };
    for i in 0..human.frames() {
        let frame = mapper.map(human.pose(i), &mut q)?;
        all.extend_from_slice(&q);
        report.variance.push(frame.variance);
        report.confidence.push(frame.confidence);
        report.extrapolates.push(frame.extrapolates);
        report.fit_rms_m.push(frame.fit.rms_m);
        if frame.jumped {
            report.jumps.push(i);
        }
        report.latent.extend(mapper.latent().map(<[f64]>::to_vec));
    }
    Ok((Clip::new(skeleton.clone(), human.rate_hz, all), report))
}
