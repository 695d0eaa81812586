//! What a person should look at: examples that contradict each other, and frames to key next.
//!
//! In: a learned edit, or its answer for a clip. Out: pairs of examples that are neighbours in features and far apart in what they
//! ask for, with the frames on both sides (the failure of IAF09, Fig. 7, which an average would hide); and the frames of
//! a clip that would teach most.
//!
//! Units: rad; distances of features in spacings of the examples, as novelty is.

use learn::Mirror;
use nalgebra::DMatrix;

use super::model::Answer;
use super::rows::ExampleFrame;
use super::{ExampleEdit, ExampleError, outputs};

/// Differences at neighbours that are this far apart at a joint contradict each other, rad: 10°.
pub const LEAST_APART_RAD: f64 = 10.0 * std::f64::consts::PI / 180.0;

/// Examples are neighbours up to this distance, in spacings (`learn`: the 99th percentile of the distances of examples to the nearest one of
/// another time). A walk at 30 Hz moves farther than that from one example to the next.
pub const NEIGHBOUR: f64 = 0.15;

/// Frames to key next are this far apart at least, s.
pub const KEYS_APART_S: f64 = 0.5;

/// Two examples that contradict each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Contradiction {
    /// The frames on both sides.
    pub frames: [ExampleFrame; 2],
    /// Whether the second is meant with left and right exchanged.
    pub mirrored: bool,
    /// The joint at which they are farthest apart.
    pub joint: String,
    /// How far there, rad.
    pub apart_rad: f64,
    /// Distance of their features, in spacings.
    pub distance: f64,
}

/// The examples of an edit that contradict each other, the farthest apart first: for each example the nearest other (or its mirror
/// image) within [`NEIGHBOUR`] whose differences are `least_apart_rad` or more away at a joint or in the lean of the root. Each pair is
/// named once. A slide counts in sizes of the body.
///
/// # Errors
/// Examples that the model refuses to be asked about.
pub fn contradictions(edit: &ExampleEdit, least_apart_rad: f64) -> Result<Vec<Contradiction>, ExampleError> {
    let examples = edit.configuration.examples();
    let (x, y) = (examples.inputs().transpose(), examples.targets().transpose());
    let image = examples.mirror().map(|m| (mirrored(&m.input, &x), mirrored(&m.output, &y)));
    let spacing = spacing(edit, &x, image.as_ref().map(|(x, _)| x))?;
    let columns = outputs::named_columns(&edit.rig, "the root");
    let mut found: Vec<Contradiction> = Vec::new();
    for i in 0..x.ncols() {
        let mut nearest: Option<(usize, bool, f64, usize, f64)> = None;
        let sides = [Some((&x, &y)), image.as_ref().map(|(x, y)| (x, y))];
        for (mirrored, side) in [false, true].into_iter().zip(sides) {
            let Some((inputs, targets)) = side else { continue };
            for j in 0..x.ncols() {
                let distance = (x.column(i) - inputs.column(j)).norm() / spacing;
                if (i == j && !mirrored) || distance > nearest.map_or(NEIGHBOUR, |n| n.2) {
                    continue;
                }
                let apart = columns.iter().enumerate().map(|(k, (c, _))| {
                    let d = targets.column(j).rows(c.start, c.len()) - y.column(i).rows(c.start, c.len());
                    (k, d.norm())
                });
                let Some((joint, apart)) = apart.max_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
                if apart >= least_apart_rad {
                    nearest = Some((j, mirrored, distance, joint, apart));
                }
            }
        }
        let Some((j, mirrored, distance, joint, apart_rad)) = nearest else { continue };
        let frames = [edit.frames[i.min(j)], edit.frames[i.max(j)]];
        if found.iter().all(|c| c.frames != frames) {
            found.push(Contradiction {
                frames,
                mirrored,
                joint: columns[joint].1.clone(),
                apart_rad,
                distance,
            });
        }
    }
    found.sort_by(|a, b| b.apart_rad.total_cmp(&a.apart_rad));
    Ok(found)
}

/// The spacing of the examples, units of the features: a distance over its novelty.
fn spacing(edit: &ExampleEdit, x: &DMatrix<f64>, image: Option<&DMatrix<f64>>) -> Result<f64, ExampleError> {
    let far = x.column(0) * 2.0 + nalgebra::DVector::from_element(x.nrows(), 1.0);
    let least = x
        .column_iter()
        .chain(image.iter().flat_map(|x| x.column_iter()))
        .map(|c| (c - &far).norm())
        .fold(f64::INFINITY, f64::min);
    let batch = edit
        .configuration
        .predict_batch(&DMatrix::from_row_slice(1, far.len(), far.as_slice()))
        .map_err(|source| ExampleError::Input { frame: 0, source })?;
    Ok(least / batch.novelty[0])
}

/// All columns mirrored.
fn mirrored(map: &[(usize, f64)], of: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = of.clone();
    for (from, mut to) in of.column_iter().zip(out.column_iter_mut()) {
        Mirror::apply(map, from.as_slice(), to.as_mut_slice());
    }
    out
}

/// A frame that would teach much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyNext {
    /// Which frame of the clip.
    pub frame: usize,
    /// Standard deviation of the prediction over its mean in this clip, times novelty: both where the regression does not know and where no
    /// example is near.
    pub score: f64,
}

/// The frames of a clip to key next, at most `count`, the best first, [`KEYS_APART_S`] apart; from the clip's answer and rate.
pub fn key_next(answer: &Answer, rate_hz: f64, count: usize) -> Vec<KeyNext> {
    let mean = answer.unsure.iter().sum::<f64>() / answer.unsure.len().max(1) as f64;
    let score =
        |f: usize| if mean > 0.0 { answer.unsure[f] / mean * answer.novelty[f] } else { answer.novelty[f] };
    let mut order: Vec<KeyNext> =
        (0..answer.novelty.len()).map(|frame| KeyNext { frame, score: score(frame) }).collect();
    order.sort_by(|a, b| b.score.total_cmp(&a.score).then(a.frame.cmp(&b.frame)));
    let apart = (KEYS_APART_S * rate_hz).ceil() as usize;
    let mut keys: Vec<KeyNext> = Vec::new();
    for k in order {
        if keys.len() == count {
            break;
        }
        if keys.iter().all(|o| o.frame.abs_diff(k.frame) >= apart) {
            keys.push(k);
        }
    }
    keys
}
