//! Training and prediction: the two regressions of an edit.
//!
//! In: [`Pair`]s. Out: an [`ExampleEdit`], and from it, for a clip, an [`Answer`]: the blended differences of every frame with how sure
//! they are.
//!
//! *Configuration*: from x^(k) to the differences of [`super::outputs`] (or, with [`Outputs::Poses`], to the target itself). *Acceleration*: from x^(a) to their second derivatives by time,
//! of the frames of the pair, from parabolas over 0.125 s. Speeds and rates of configurations are means over the same time. Hyperparameters are shared over all outputs: three of accelerations; of configurations two variances and a length for each group of
//! features ([`super::features`]).
//!
//! *Axes*: differences of balls are written in the joints' own axes or in their parents', whichever makes the examples agree better
//! ([`choose_axes`]).
//!
//! *Novelty*: the distance of a frame's x^(k) to the nearest example, over the 99th percentile of the distances that the examples
//! have to each other (`learn`). [`gates`] take the blended differences back where it nears 1. They act on the result of the blend: inside
//! it, the accelerations learned of a constant edit (zero, and sure of it) would carry the edit on through whatever is new.
//!
//! Symbols as in [`super::solve`].

use std::ops::ControlFlow;

use learn::{Batch, ExampleModel, Examples, FitError, RbfKernel};
use motion::Clip;
use nalgebra::DMatrix;

use super::features::{Features, configuration_groups, configuration_width};
use super::options::ExampleOptions;
use super::rig::{Rig, RigFile};
use super::rows::{ExampleFrame, Rows, choose_axes};
use super::solve::{Evidence, Form, SUREST, blend};
use super::{ExampleError, Outputs, Pair, outputs, poses};

/// Novelty up to which differences are kept whole, and from which on nothing is left of them.
pub const GATE: (f64, f64) = (0.8, 1.04);

/// Share of the differences that is kept at a novelty: 1 up to the first of [`GATE`], 0 from the second on, smooth between.
pub fn gate(novelty: f64) -> f64 {
    1.0 - motion::smoothstep((novelty - GATE.0) / (GATE.1 - GATE.0))
}

/// Share of the differences that is kept at each frame of a clip: at most [`gate`] of its novelty, and smooth in time.
///
/// The least gate within 0.125 s of each frame, averaged with raised-cosine weights over the same time: every one of the
/// averaged values has the frame within its reach, so that none is above its gate.
pub fn gates(novelty: &[f64], rate_hz: f64) -> Vec<f64> {
    let half = (super::features::APART_S * rate_hz).round() as usize;
    let n = novelty.len();
    let around = |f: usize| f.saturating_sub(half)..(f + half + 1).min(n);
    let own: Vec<f64> = novelty.iter().map(|v| gate(*v)).collect();
    let least: Vec<f64> = (0..n).map(|f| own[around(f)].iter().copied().fold(1.0, f64::min)).collect();
    let weight =
        |f: usize, g: usize| 1.0 + (std::f64::consts::PI * g.abs_diff(f) as f64 / (half + 1) as f64).cos();
    (0..n)
        .map(|f| {
            let (sum, all) =
                around(f).fold((0.0, 0.0), |(s, a), g| (s + weight(f, g) * least[g], a + weight(f, g)));
            sum / all
        })
        .collect()
}

/// A learned edit. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct ExampleEdit {
    /// The rig it was taught on.
    pub rig: RigFile,
    /// How it was learned.
    pub options: ExampleOptions,
    /// Names of the pairs.
    pub pairs: Vec<String>,
    /// Where each example came from.
    pub frames: Vec<ExampleFrame>,
    /// Whether examples are mirrored.
    pub mirrored: bool,
    /// From x^(k) to differences.
    pub configuration: ExampleModel,
    /// From x^(a) to their second derivatives.
    pub acceleration: ExampleModel,
}

/// What one of the two models was taught, and the kernel it learned: all that is stored of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Taught {
    /// The examples.
    pub examples: Examples,
    /// The kernel of a Gaussian process.
    pub kernel: Option<RbfKernel>,
}

/// How far learning is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Learning {
    /// Which of the two models: `configurations`, then `accelerations`.
    pub model: &'static str,
    /// How often its likelihood was evaluated.
    pub evaluations: usize,
    /// Most iterations of its two searches; each needs one evaluation, seldom two. They usually end before.
    pub of: usize,
}

/// What a model says of a clip, one row or entry a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Blended differences, columns as in [`super::outputs`].
    pub differences: DMatrix<f64>,
    /// What the configuration model alone predicts.
    pub predicted: DMatrix<f64>,
    /// Standard deviation of that, in the units of its columns.
    pub unsure: Vec<f64>,
    /// How new each frame is: see the module header.
    pub novelty: Vec<f64>,
    /// Share of the blend kept for novelty: [`gates`].
    pub kept: Vec<f64>,
    /// What a departure from `differences` costs.
    pub form: Form,
}

impl ExampleEdit {
    /// Learns the edit of the pairs.
    ///
    /// # Errors
    /// Pairs that do not go together, bodies of another rig than the first pair's, examples that nothing can be fitted to.
    pub fn learn(pairs: &[Pair], options: &ExampleOptions) -> Result<Self, ExampleError> {
        Self::learn_watched(pairs, options, &|_| ControlFlow::Continue(()))
    }

    /// As [`ExampleEdit::learn`], watched: who watches is told how far it is, before each evaluation of a likelihood, and may end it. What is
    /// learned does not depend on being watched.
    ///
    /// # Errors
    /// As [`ExampleEdit::learn`]; [`ExampleError::Cancelled`].
    pub fn learn_watched(
        pairs: &[Pair],
        options: &ExampleOptions,
        watch: &(dyn Fn(Learning) -> ControlFlow<()> + Sync),
    ) -> Result<Self, ExampleError> {
        options.check()?;
        let first = pairs.first().ok_or(ExampleError::NoPairs)?;
        let axes = choose_axes(pairs, options)?;
        let rig = Rig::of(&first.source.skeleton)?.with_axes(axes);
        let file = rig.file().clone();
        let rows = Rows::of(&file, pairs, 0, options)?;
        let mirrored = options.mirror && rig.is_symmetric();
        let [configuration, acceleration] = rows.examples(&rig, mirrored)?;
        let settings = learn::ExampleOptions::default();
        let learned = |model: &'static str, examples: &Examples| {
            let told = |evaluations| watch(Learning { model, evaluations, of: 2 * settings.gp.iterations });
            ExampleModel::fit_watched(options.estimator, examples, &settings, &told).map_err(|source| {
                match source {
                    FitError::Cancelled { evaluations } => ExampleError::Cancelled { model, evaluations },
                    source => ExampleError::Fit { model, source },
                }
            })
        };
        Ok(Self {
            rig: file,
            options: options.clone(),
            pairs: pairs.iter().map(|p| p.name.clone()).collect(),
            frames: rows.frames,
            mirrored,
            configuration: learned("configurations", &configuration)?,
            acceleration: learned("accelerations", &acceleration)?,
        })
    }

    /// What the models of configurations and of accelerations were taught.
    pub fn taught(&self) -> [Taught; 2] {
        [&self.configuration, &self.acceleration]
            .map(|m| Taught { examples: m.examples().clone(), kernel: m.as_gp().map(|gp| gp.kernel()) })
    }

    /// The edit of which this is stored: kernels are taken as they are, factors are made again.
    ///
    /// # Errors
    /// Examples that do not fit the rig or each other, kernels that are none.
    pub fn stored(
        rig: RigFile,
        options: ExampleOptions,
        pairs: Vec<String>,
        frames: Vec<ExampleFrame>,
        taught: [Taught; 2],
    ) -> Result<Self, ExampleError> {
        options.check()?;
        let width: usize = rig.joints.iter().map(|(_, m)| m.width()).sum::<usize>() + outputs::ROOT;
        let points = rig.points.len();
        let sizes = [configuration_width(points), 3 * points];
        let fault = |what: String| Err(ExampleError::Stored { what });
        for (of, size) in taught.iter().zip(sizes) {
            let found = (of.examples.len(), of.examples.inputs().ncols(), of.examples.targets().ncols());
            let needed = (frames.len(), size, width);
            if found != needed {
                return fault(format!("examples × inputs × outputs are {found:?}; the rig needs {needed:?}"));
            }
        }
        if let Some(f) = frames.iter().find(|f| f.pair >= pairs.len()) {
            return fault(format!("an example of pair {}; there are {}", f.pair, pairs.len()));
        }
        let [mut configuration, acceleration] = taught;
        configuration.examples = configuration
            .examples
            .with_groups(configuration_groups(points))
            .map_err(|source| ExampleError::Fit { model: "configurations", source })?;
        let taught = [configuration, acceleration];
        let mirrored = taught.iter().all(|t| t.examples.mirror().is_some());
        let again = |model, of: &Taught| {
            let mut settings = learn::ExampleOptions::default();
            settings.gp.kernel = of.kernel;
            ExampleModel::fit(options.estimator, &of.examples, &settings)
                .map_err(|source| ExampleError::Fit { model, source })
        };
        let (configuration, acceleration) =
            (again("configurations", &taught[0])?, again("accelerations", &taught[1])?);
        Ok(Self { rig, options, pairs, frames, mirrored, configuration, acceleration })
    }

    /// The same edit with more pairs: hyperparameters stay, factors grow.
    ///
    /// # Errors
    /// As [`ExampleEdit::learn`].
    pub fn grow(&mut self, pairs: &[Pair]) -> Result<(), ExampleError> {
        let Some(first) = pairs.first() else { return Ok(()) };
        let rig = Rig::find(&self.rig, &first.source.skeleton)?;
        let rows = Rows::of(&self.rig, pairs, self.pairs.len(), &self.options)?;
        let [configuration, acceleration] = rows.examples(&rig, self.mirrored)?;
        let grown = |model, of: &mut ExampleModel, more: &Examples| {
            of.grow(more).map_err(|source| ExampleError::Fit { model, source })
        };
        grown("configurations", &mut self.configuration, &configuration)?;
        grown("accelerations", &mut self.acceleration, &acceleration)?;
        self.pairs.extend(pairs.iter().map(|p| p.name.clone()));
        self.frames.extend(rows.frames);
        Ok(())
    }

    /// What the edit makes of a clip.
    ///
    /// # Errors
    /// A clip of another rig.
    pub fn answer(&self, clip: &Clip) -> Result<Answer, ExampleError> {
        let rig = Rig::find(&self.rig, &clip.skeleton)?;
        self.answer_of(&rig, clip)
    }

    /// As [`ExampleEdit::answer`], with the clip's rig.
    pub(super) fn answer_of(&self, rig: &Rig, clip: &Clip) -> Result<Answer, ExampleError> {
        let frames: Vec<usize> = (0..clip.frames()).collect();
        let features = Features::of(rig, clip, &frames, self.options.recognised());
        let predict = |model: &ExampleModel, inputs: &DMatrix<f64>| {
            model.predict_batch(inputs).map_err(|source| ExampleError::Input { frame: 0, source })
        };
        let mut k = predict(&self.configuration, &features.configuration)?;
        let mut a = predict(&self.acceleration, &features.acceleration)?;
        let step_s = 1.0 / clip.rate_hz;
        let mut signals = [&self.configuration, &self.acceleration].map(signal);
        // accelerations as sure as that would leave nothing of the configurations to rounding
        signals[1] = signals[1].max(CALM * signals[0]);
        for (a, k) in a.variance.iter_mut().zip(&k.variance) {
            *a = a.max(CALM * k.max(SUREST * signals[0]));
        }
        // of poses, the blend finds what is to be added to those of the source
        let source = (self.options.outputs == Outputs::Poses).then(|| poses::of(rig, clip, None));
        if let Some(source) = &source {
            k.mean -= source;
            a.mean -= poses::accelerations(source, step_s);
            signals = [1.0; 2];
        }
        let to_differences = |d: DMatrix<f64>| match &source {
            Some(source) => poses::differences(rig, clip, source, &(d + source)),
            None => d,
        };
        let kept = if self.options.gate { gates(&k.novelty, clip.rate_hz) } else { vec![1.0; frames.len()] };
        let predicted = to_differences(k.mean.clone());
        let w = &self.options.weights;
        let unsure = k.variance.iter().map(|v| v.sqrt()).collect();
        let novelty = k.novelty.clone();
        let evidence = |of: Batch, signal, learned, source| {
            Evidence::new(of.mean, &of.variance, signal, learned, source)
        };
        let configuration = evidence(k, signals[0], w.configuration, w.source);
        let acceleration = evidence(a, signals[1], w.acceleration, w.source_acceleration);
        let mut differences = to_differences(blend(&configuration, &acceleration, step_s));
        for (f, g) in kept.iter().enumerate() {
            differences.row_mut(f).scale_mut(*g);
        }
        let root = self.options.root_weight;
        let form = Form { root, ..Form::of(&configuration, &acceleration, step_s) }.firm();
        Ok(Answer { differences, predicted, unsure, novelty, kept, form })
    }
}

/// σ_f² of a model; the mean square of its targets where it has no kernel.
fn signal(model: &ExampleModel) -> f64 {
    let of = match model.as_gp() {
        Some(gp) => gp.kernel().signal_variance,
        None => model.examples().targets().norm_squared() / model.examples().targets().len() as f64,
    };
    of.max(LEAST_SIGNAL)
}

/// Least variance of accelerations over that of configurations, 1/s⁴.
const CALM: f64 = 1e-6;

/// Of targets that are all zero, squared units.
const LEAST_SIGNAL: f64 = 1e-18;
