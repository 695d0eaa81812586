//! A learned edit against what an artist would do instead, on known rules.
//!
//! In: clips to learn on, clips not seen, a rule, a number of frames. Out: the error of each [`Way`] on the clips not seen.
//!
//! | way | frames keyed by the artist |
//! |---|---|
//! | `Gp`, `Mls` | so many frames of the training clips; none of the clips not seen |
//! | `Nearest` | the same; the difference of the nearest frame, without blend |
//! | `Linear` | the same; one linear filter from features to differences (ridge regression): a time-invariant linear model of matched clips |
//! | `Keys` | so many frames *in the clips not seen themselves*, spread evenly, interpolated |
//!
//! Errors are rotations from the truth: RMS over frames and over joints that the rule moves, and over those it does not, in degrees.

use std::sync::Arc;

use edits::by_example::features::{Features, Recognised};
use edits::by_example::outputs::{self, Allowed};
use edits::by_example::rows::choose_axes;
use edits::by_example::{Axes, ByExample, ExampleEdit, ExampleOptions, Pair, Rig};
use edits::{Motion, Where};
use learn::ExampleMethod;
use motion::Clip;
use motion::rotation::log;
use nalgebra::DMatrix;

use super::PropagateError;

/// How differences of an unseen clip are found. See the module header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Gaussian process regression, blended.
    Gp,
    /// Moving least squares, blended.
    Mls,
    /// The nearest frame.
    Nearest,
    /// A linear filter.
    Linear,
    /// Keys in the unseen clip.
    Keys,
}

impl Way {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Gp, Self::Mls, Self::Nearest, Self::Linear, Self::Keys];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gp => "GP",
            Self::Mls => "MLS",
            Self::Nearest => "nearest",
            Self::Linear => "linear",
            Self::Keys => "keyed there",
        }
    }
}

/// How far a result is from the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RuleError {
    /// RMS over the joints that the rule moves, degrees.
    pub edited_deg: f64,
    /// RMS over the others, degrees.
    pub others_deg: f64,
    /// RMS of the relative error of the rate of time, %.
    pub rate_percent: f64,
    /// Largest difference of times, s.
    pub drift_s: f64,
}

/// Sums of squares, to be taken together over clips.
#[derive(Default)]
struct Sums {
    edited: (f64, usize),
    others: (f64, usize),
    rate: (f64, usize),
    drift_s: f64,
}

/// A frame of one of the training pairs: (pair, frame).
type Taught = (usize, usize);

/// `count` frames spread evenly over all pairs; all of them at most.
pub fn spread(pairs: &[Pair], count: usize, rate_hz: f64) -> Vec<Taught> {
    let all: Vec<Taught> = pairs
        .iter()
        .enumerate()
        .flat_map(|(p, pair)| {
            let stride = (pair.source.rate_hz / rate_hz).round().max(1.0) as usize;
            (0..pair.source.frames()).step_by(stride).map(move |f| (p, f))
        })
        .collect();
    let n = count.min(all.len());
    (0..n).map(|i| all[((i as f64 + 0.5) * all.len() as f64 / n as f64) as usize]).collect()
}

/// The pairs with only these frames as examples.
pub fn taught(pairs: &[Pair], frames: &[Taught]) -> Vec<Pair> {
    pairs
        .iter()
        .enumerate()
        .map(|(p, pair)| {
            let at = |f: usize| f as f64 / pair.source.rate_hz;
            let spans_s = frames.iter().filter(|(q, _)| *q == p).map(|(_, f)| (at(*f), at(*f))).collect();
            Pair { spans_s, ..pair.clone() }
        })
        .filter(|pair| !pair.spans_s.is_empty())
        .collect()
}

/// The error of one way on the unseen pairs after being taught `count` frames.
///
/// # Errors
/// Pairs that do not go together.
pub fn error(
    way: Way,
    training: &[Pair],
    unseen: &[Pair],
    count: usize,
    options: &ExampleOptions,
) -> Result<RuleError, PropagateError> {
    let frames = spread(training, count, 1e9);
    let taught = taught(training, &frames);
    let mut sums = Sums::default();
    let edit = match way {
        Way::Gp | Way::Mls | Way::Nearest => {
            let estimator = match way {
                Way::Gp => ExampleMethod::Gp,
                Way::Mls => ExampleMethod::Mls,
                _ => ExampleMethod::Nearest,
            };
            Some(Arc::new(ExampleEdit::learn(&taught, &ExampleOptions { estimator, ..options.clone() })?))
        }
        Way::Linear | Way::Keys => None,
    };
    let linear = if way == Way::Linear { Some(Linear::learn(&taught, options)?) } else { None };
    let total: usize = unseen.iter().map(|p| p.source.frames()).sum();
    for pair in unseen {
        let rig = Rig::of(&pair.source.skeleton)?;
        let (result, times) = match (way, &edit, &linear) {
            (Way::Gp | Way::Mls, Some(edit), _) => {
                let motion = Motion::of(pair.source.clone());
                let place = Where::default().in_clip(&motion).map_err(PropagateError::Edit)?;
                let done = ByExample::new(edit.clone()).run(&motion, &place)?;
                let times = (0..pair.source.frames())
                    .map(|f| done.edited.times.at(f as f64 / pair.source.rate_hz))
                    .collect();
                (done.untimed, times)
            }
            (Way::Nearest, Some(edit), _) => {
                let answer = edit.answer(&pair.source)?;
                applied(&rig.with_axes(edit.rig.axes), &pair.source, &answer.predicted)
            }
            (_, _, Some(linear)) => {
                let rig = rig.with_axes(linear.axes);
                applied(&rig, &pair.source, &linear.predict(&rig, &pair.source))
            }
            _ => {
                let share = count as f64 * pair.source.frames() as f64 / total as f64;
                applied(&rig, &pair.source, &keyed(&rig, pair, share.round().max(2.0) as usize))
            }
        };
        sums.add(pair, &result, &times);
    }
    Ok(sums.finish())
}

/// A source with differences, and its times.
fn applied(rig: &Rig, source: &Clip, d: &DMatrix<f64>) -> (Clip, Vec<f64>) {
    let allowed =
        Allowed { joints: vec![true; rig.joints().len()], tilt: true, height: true, steps: true, time: true };
    let clip = outputs::add(rig, source, d, &allowed, &source.skeleton, rig.size_m);
    let column = outputs::time_column(rig);
    let times = outputs::elapsed((0..d.nrows()).map(|f| d[(f, column)]), 1.0 / source.rate_hz);
    (clip, times)
}

/// Differences keyed at `keys` frames of the pair itself, interpolated between them.
fn keyed(rig: &Rig, pair: &Pair, keys: usize) -> DMatrix<f64> {
    let truth = outputs::differences((rig, &pair.source), (rig, &pair.target), pair.times_s.as_deref());
    let last = truth.nrows() - 1;
    let keys = keys.clamp(2, last + 1);
    DMatrix::from_fn(truth.nrows(), truth.ncols(), |f, c| {
        let x = f as f64 * (keys - 1) as f64 / last as f64;
        let (k, u) = (x.floor(), x - x.floor());
        let at = |k: f64| truth[((k * last as f64 / (keys - 1) as f64).round() as usize, c)];
        if u == 0.0 { at(k) } else { at(k) * (1.0 - u) + at(k + 1.0) * u }
    })
}

/// Ridge regression from features (configuration and acceleration) to differences.
struct Linear {
    mean: Vec<f64>,
    weights: DMatrix<f64>,
    recognised: Recognised,
    axes: Axes,
}

/// Ridge, as a share of the mean of the diagonal.
const RIDGE: f64 = 1e-4;

impl Linear {
    fn rows(rig: &Rig, clip: &Clip, frames: &[usize], recognised: Recognised) -> DMatrix<f64> {
        let f = Features::of(rig, clip, frames, recognised);
        let (a, b) = (f.configuration.ncols(), f.acceleration.ncols());
        DMatrix::from_fn(frames.len(), a + b + 1, |r, c| match c {
            c if c < a => f.configuration[(r, c)],
            // accelerations in units in which they are about as large as places
            c if c < a + b => 0.02 * f.acceleration[(r, c - a)],
            _ => 1.0,
        })
    }

    fn learn(pairs: &[Pair], options: &ExampleOptions) -> Result<Self, PropagateError> {
        let (mut x, mut y): (Vec<DMatrix<f64>>, Vec<DMatrix<f64>>) = (Vec::new(), Vec::new());
        let axes = choose_axes(pairs, options)?;
        for pair in pairs {
            let rig = Rig::of(&pair.source.skeleton)?.with_axes(axes);
            let frames = pair.examples(1e9)?;
            x.push(Self::rows(&rig, &pair.source, &frames, options.recognised()));
            let d = outputs::differences((&rig, &pair.source), (&rig, &pair.target), pair.times_s.as_deref());
            y.push(DMatrix::from_fn(frames.len(), d.ncols(), |r, c| d[(frames[r], c)]));
        }
        let stack = |m: &[DMatrix<f64>]| {
            let rows: Vec<_> = m.iter().flat_map(|m| m.row_iter().map(|r| r.into_owned())).collect();
            DMatrix::from_rows(&rows)
        };
        let (x, y) = (stack(&x), stack(&y));
        // y = mean + K α with K = x xᵀ: as many unknowns as frames
        let mean: Vec<f64> = x.column_iter().map(|c| c.mean()).collect();
        let centred = DMatrix::from_fn(x.nrows(), x.ncols(), |r, c| {
            x[(r, c)] - if c + 1 == x.ncols() { 0.0 } else { mean[c] }
        });
        let mut gram = &centred * centred.transpose();
        let ridge = RIDGE * gram.trace() / gram.nrows() as f64;
        for i in 0..gram.nrows() {
            gram[(i, i)] += ridge;
        }
        let alpha = gram.cholesky().map(|c| c.solve(&y)).expect("a ridge makes it definite");
        Ok(Self { mean, weights: centred.transpose() * alpha, recognised: options.recognised(), axes })
    }

    fn predict(&self, rig: &Rig, clip: &Clip) -> DMatrix<f64> {
        let frames: Vec<usize> = (0..clip.frames()).collect();
        let mut x = Self::rows(rig, clip, &frames, self.recognised);
        let last = x.ncols() - 1;
        for c in 0..last {
            x.column_mut(c).add_scalar_mut(-self.mean[c]);
        }
        x * &self.weights
    }
}

impl Sums {
    fn add(&mut self, pair: &Pair, result: &Clip, times: &[f64]) {
        let s = &pair.source.skeleton;
        let turned = |a: &Clip, b: &Clip, f: usize, link: usize| {
            let (p, q) = (s.rotation(a.pose(f), link), s.rotation(b.pose(f), link));
            log(&(p.inverse() * q)).norm()
        };
        for link in 0..s.links().len() {
            let moved = (0..pair.source.frames()).any(|f| turned(&pair.source, &pair.target, f, link) > 1e-9);
            let sum: f64 =
                (0..pair.source.frames()).map(|f| turned(result, &pair.target, f, link).powi(2)).sum();
            let of = if moved { &mut self.edited } else { &mut self.others };
            of.0 += sum;
            of.1 += pair.source.frames();
        }
        let Some(truth) = &pair.times_s else { return };
        for f in 1..truth.len() {
            let ratio = (times[f] - times[f - 1]) / (truth[f] - truth[f - 1]);
            self.rate.0 += (ratio - 1.0).powi(2);
            self.rate.1 += 1;
            self.drift_s = self.drift_s.max((times[f] - truth[f]).abs());
        }
    }

    fn finish(self) -> RuleError {
        let rms = |(sum, n): (f64, usize)| if n == 0 { 0.0 } else { (sum / n as f64).sqrt() };
        RuleError {
            edited_deg: rms(self.edited).to_degrees(),
            others_deg: rms(self.others).to_degrees(),
            rate_percent: 100.0 * rms(self.rate),
            drift_s: self.drift_s,
        }
    }
}
