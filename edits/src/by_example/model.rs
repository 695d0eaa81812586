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

use learn::{Batch, ExampleMethod, ExampleModel, Examples, FitError, Mirror, Moment, RbfKernel};
use motion::Clip;
use motion::derivatives::parabola;
use motion::names::Word;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::features::{
    Features, Orientation, PATH_WEIGHT, Recognised, configuration_groups, configuration_width,
    mirror_acceleration, mirror_configuration,
};
use super::rig::{Axes, Rig, RigFile};
use super::solve::{Evidence, Form, SUREST, Weights, blend};
use super::{Contacts, ExampleError, Outputs, Pair, outputs, poses};

/// Neighbours in time do not tell how dense examples lie: those closer than this, ms.
pub const APART_MS: u32 = 500;

/// Novelty up to which differences are kept whole, and from which on nothing is left of them.
pub const GATE: (f64, f64) = (0.8, 1.04);

/// [`ExampleOptions::root_weight`] if nothing else is said: 94 % of a root lowered by 5 cm are kept.
pub const ROOT_WEIGHT: f64 = 1000.0;

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

/// How an edit is learned and applied.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ExampleOptions {
    /// What predicts.
    pub estimator: ExampleMethod,
    /// What is learned of a target: its difference to the source, or itself as in the paper ([`poses`]).
    #[serde(with = "word")]
    pub outputs: Outputs,
    /// What is removed of the root's orientation in features.
    #[serde(with = "word")]
    pub orientation: Orientation,
    /// How much the root's way over half a second counts in features; 0 as in the paper ([`Recognised`]).
    pub path_weight: f64,
    /// Weights of the blend.
    pub weights: Weights,
    /// Most examples a second of a clip, Hz: frames between them say the same.
    pub examples_hz: f64,
    /// Counts every example a second time with left and right exchanged, where the body has both.
    pub mirror: bool,
    /// Takes differences back where frames are new ([`gates`]).
    pub gate: bool,
    /// Whether what stands keeps standing.
    #[serde(with = "word")]
    pub contacts: Contacts,
    /// Where contacts are kept, how much more the root's part of the edit weighs than that of the joints, where legs reach the ground
    /// from it: at 1, as in the blend, raising the root costs less than bending two legs, and an edit of the root alone is taken back ([`super::contacts`]).
    pub root_weight: f64,
}

impl Default for ExampleOptions {
    fn default() -> Self {
        Self {
            estimator: ExampleMethod::default(),
            outputs: Outputs::default(),
            orientation: Orientation::default(),
            path_weight: PATH_WEIGHT,
            weights: Weights::default(),
            examples_hz: 30.0,
            mirror: true,
            gate: true,
            contacts: Contacts::default(),
            root_weight: ROOT_WEIGHT,
        }
    }
}

impl ExampleOptions {
    /// What features are made of.
    pub fn recognised(&self) -> Recognised {
        Recognised { orientation: self.orientation, path_weight: self.path_weight }
    }
}

mod word {
    use super::Word;
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub fn serialize<W: Word, S: Serializer>(w: &W, s: S) -> Result<S::Ok, S::Error> {
        s.serialize_str(w.word())
    }

    pub fn deserialize<'de, W: Word, D: Deserializer<'de>>(d: D) -> Result<W, D::Error> {
        W::find(&String::deserialize(d)?).map_err(D::Error::custom)
    }
}

/// Where an example came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExampleFrame {
    /// Which pair.
    pub pair: usize,
    /// Which frame of it.
    pub frame: usize,
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
    /// Most iterations of the search; each needs one evaluation, seldom two. It usually ends before.
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

/// Inputs and targets of both models, one example a row.
struct Rows {
    configuration: (Vec<f64>, Vec<f64>),
    acceleration: (Vec<f64>, Vec<f64>),
    moments: Vec<Moment>,
    frames: Vec<ExampleFrame>,
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
        check(options)?;
        let first = pairs.first().ok_or(ExampleError::NoPairs)?;
        let axes = choose_axes(pairs, options)?;
        let rig = Rig::of(&first.source.skeleton)?.with_axes(axes);
        let file = rig.file().clone();
        let rows = Rows::of(&file, pairs, 0, options)?;
        let mirrored = options.mirror && rig.is_symmetric();
        let [configuration, acceleration] = rows.examples(&rig, mirrored)?;
        let settings = learn::ExampleOptions::default();
        let learned = |model: &'static str, examples: &Examples| {
            let told = |evaluations| watch(Learning { model, evaluations, of: settings.gp.iterations });
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
        check(&options)?;
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

fn check(options: &ExampleOptions) -> Result<(), ExampleError> {
    let w = &options.weights;
    let fault = |what, value, allowed| Err(ExampleError::Setting { what, value, allowed });
    if !(options.examples_hz.is_finite() && options.examples_hz > 0.0) {
        return fault("`examples_hz`", options.examples_hz, "above 0");
    }
    for (what, value) in [
        ("weight `configuration`", w.configuration),
        ("weight `source`", w.source),
        ("weight `acceleration`", w.acceleration),
        ("weight `source_acceleration`", w.source_acceleration),
    ] {
        if !(value.is_finite() && value >= 0.0) {
            return fault(what, value, "0 or more");
        }
    }
    if !(options.path_weight.is_finite() && options.path_weight >= 0.0) {
        return fault("`path_weight`", options.path_weight, "0 or more");
    }
    if !(options.root_weight.is_finite() && options.root_weight > 0.0) {
        return fault("`root_weight`", options.root_weight, "above 0");
    }
    if w.configuration + w.source <= 0.0 {
        return fault(
            "the sum of the weights `configuration` and `source`",
            0.0,
            "above 0: something must say where joints are",
        );
    }
    Ok(())
}

impl Rows {
    /// The examples of all pairs; the first of them is pair number `first`.
    fn of(
        file: &RigFile,
        pairs: &[Pair],
        first: usize,
        options: &ExampleOptions,
    ) -> Result<Self, ExampleError> {
        let mut rows = Self {
            configuration: (Vec::new(), Vec::new()),
            acceleration: (Vec::new(), Vec::new()),
            moments: Vec::new(),
            frames: Vec::new(),
        };
        for (i, pair) in pairs.iter().enumerate() {
            pair.check()?;
            let named = |e: ExampleError| match e {
                ExampleError::OtherRig { what } => {
                    ExampleError::OtherRig { what: format!("pair `{}`: {what}", pair.name) }
                }
                other => other,
            };
            let source = Rig::find(file, &pair.source.skeleton).map_err(named)?;
            let target = Rig::find(file, &pair.target.skeleton).map_err(named)?;
            let frames = pair.examples(options.examples_hz)?;
            let features = Features::of(&source, &pair.source, &frames, options.recognised());
            let (from, to, times) =
                ((&source, &pair.source), (&target, &pair.target), pair.times_s.as_deref());
            let d = match options.outputs {
                Outputs::Differences => outputs::differences(from, to, times),
                Outputs::Poses => poses::of(to.0, to.1, times),
            };
            let rate_hz = pair.source.rate_hz;
            let last = d.nrows() - 1;
            let half = ((0.5 * super::features::APART_S * rate_hz).round() as usize).max(1);
            for (row, &frame) in frames.iter().enumerate() {
                rows.configuration.0.extend(features.configuration.row(row).iter());
                let at = rows.configuration.1.len();
                rows.configuration.1.extend(d.row(frame).iter());
                rows.acceleration.0.extend(features.acceleration.row(row).iter());
                let (from, to) = (frame.saturating_sub(half), (frame + half).min(last));
                // the step of a single frame has the noise of two poses times the frame rate
                for c in outputs::rates(&source) {
                    let sum: f64 = (from..=to).map(|f| d[(f, c)]).sum();
                    rows.configuration.1[at + c] = sum / (to - from + 1) as f64;
                }
                let bends = parabola(from as i64 - frame as i64, to as i64 - frame as i64, rate_hz);
                let bend =
                    |c: usize| (from..=to).zip(&bends).map(|(f, (_, bend))| bend * d[(f, c)]).sum::<f64>();
                rows.acceleration.1.extend((0..d.ncols()).map(bend));
                let at_ms = (1e3 * frame as f64 / rate_hz).round() as u32;
                rows.moments.push(Moment { clip: (first + i) as u32, frame: at_ms });
                rows.frames.push(ExampleFrame { pair: first + i, frame });
            }
        }
        Ok(rows)
    }

    /// As examples of the two models.
    fn examples(&self, rig: &Rig, mirrored: bool) -> Result<[Examples; 2], ExampleError> {
        let n = self.frames.len();
        let of = |rows: &(Vec<f64>, Vec<f64>), input: Option<super::rig::Signed>, model| {
            let matrix = |v: &Vec<f64>| DMatrix::from_row_slice(n, v.len() / n.max(1), v);
            let mirror = match (mirrored, input, outputs::mirror(rig)) {
                (true, Some(input), Some(output)) => Some(Mirror { input, output }),
                _ => None,
            };
            Examples::new(matrix(&rows.0), matrix(&rows.1), mirror)
                .and_then(|e| e.with_moments(self.moments.clone(), APART_MS))
                .map_err(|source| ExampleError::Fit { model, source })
        };
        let grouped = |e: Examples| {
            e.with_groups(configuration_groups(rig.points()))
                .map_err(|source| ExampleError::Fit { model: "configurations", source })
        };
        Ok([
            grouped(of(&self.configuration, mirror_configuration(rig), "configurations")?)?,
            of(&self.acceleration, mirror_acceleration(rig), "accelerations")?,
        ])
    }
}

/// The axes in which the examples of the pairs agree better: in which a target is nearer to that of the most alike frame of another time
/// ([`Examples::disagreement`]). The joints' own where there is no difference.
///
/// # Errors
/// As [`ExampleEdit::learn`].
pub fn choose_axes(pairs: &[Pair], options: &ExampleOptions) -> Result<Axes, ExampleError> {
    check(options)?;
    let first = pairs.first().ok_or(ExampleError::NoPairs)?;
    if options.outputs == Outputs::Poses {
        return Ok(Axes::Joint);
    }
    let disagreement = |axes| {
        let rig = Rig::of(&first.source.skeleton)?.with_axes(axes);
        let rows = Rows::of(rig.file(), pairs, 0, options)?;
        let [configuration, _] = rows.examples(&rig, options.mirror && rig.is_symmetric())?;
        Ok::<f64, ExampleError>(configuration.disagreement())
    };
    let parent = disagreement(Axes::Parent)? < disagreement(Axes::Joint)?;
    Ok(if parent { Axes::Parent } else { Axes::Joint })
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
