//! What the two models are taught: the examples of pairs.
//!
//! In: [`Pair`]s. Out: features and targets of their example frames, those of configurations in groups ([`super::features`]), and the axes in which
//! differences are written ([`choose_axes`]). Speeds and rates of configurations are means over 0.125 s, accelerations come from parabolas
//! over the same time.

use learn::{Examples, Mirror, Moment};
use motion::derivatives::parabola;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::features::{APART_S, Features, configuration_groups, mirror_acceleration, mirror_configuration};
use super::options::ExampleOptions;
use super::rig::{Axes, Rig, RigFile, Signed};
use super::{ExampleError, Outputs, Pair, outputs, poses};

/// Neighbours in time do not tell how dense examples lie: those closer than this, ms.
pub const APART_MS: u32 = 500;

/// Where an example came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExampleFrame {
    /// Which pair.
    pub pair: usize,
    /// Which frame of it.
    pub frame: usize,
}

/// Inputs and targets of both models, one example a row.
pub(super) struct Rows {
    configuration: (Vec<f64>, Vec<f64>),
    acceleration: (Vec<f64>, Vec<f64>),
    moments: Vec<Moment>,
    /// Where they came from.
    pub(super) frames: Vec<ExampleFrame>,
}

impl Rows {
    /// The examples of all pairs; the first of them is pair number `first`.
    pub(super) fn of(
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
            let half = ((0.5 * APART_S * rate_hz).round() as usize).max(1);
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
    pub(super) fn examples(&self, rig: &Rig, mirrored: bool) -> Result<[Examples; 2], ExampleError> {
        let n = self.frames.len();
        let of = |rows: &(Vec<f64>, Vec<f64>), input: Option<Signed>, model| {
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
/// As [`super::ExampleEdit::learn`].
pub fn choose_axes(pairs: &[Pair], options: &ExampleOptions) -> Result<Axes, ExampleError> {
    options.check()?;
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
