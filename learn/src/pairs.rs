//! Checked pairs of vectors, and a space of vectors brought to unit variance.
//!
//! Everything that learns here starts from [`Pairs`], so bad data has one set of words. Vectors are the
//! rows of the matrices given, as in the papers; inside they are stored as columns, contiguous.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::dense::distance_squared;
use crate::error::{FitError, InputError, Side};

/// Inputs closer than this are one input, in units of the RMS radius of all of them.
const SAME: f64 = 1e-6;
/// Inputs closer than this must have outputs closer than [`ANSWER`]: beyond, the map would need a slope of more
/// than ten times the range of the data.
const CLOSE: f64 = 1e-2;
/// See [`CLOSE`]; in units of the RMS radius of the outputs.
const ANSWER: f64 = 1e-1;

/// Pairs of an input and an output vector that a map can be learned from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Stored")]
pub struct Pairs {
    /// D_Y × N: one input a column.
    inputs: DMatrix<f64>,
    /// D_Z × N: one output a column.
    outputs: DMatrix<f64>,
}

#[derive(Deserialize)]
#[serde(rename = "Pairs", deny_unknown_fields)]
struct Stored {
    inputs: DMatrix<f64>,
    outputs: DMatrix<f64>,
}

impl TryFrom<Stored> for Pairs {
    type Error = FitError;

    fn try_from(s: Stored) -> Result<Self, FitError> {
        Pairs::from_columns(s.inputs, s.outputs)
    }
}

impl Pairs {
    /// Checks the rows of `inputs` (N × D_Y) against those of `outputs` (N × D_Z); any units, one unit a side.
    ///
    /// # Errors
    /// Numbers that do not match, values that are not finite, sides without spread, fewer than two pairs,
    /// the same pair twice, two answers to one input.
    pub fn new(inputs: &DMatrix<f64>, outputs: &DMatrix<f64>) -> Result<Self, FitError> {
        Pairs::from_columns(inputs.transpose(), outputs.transpose())
    }

    fn from_columns(inputs: DMatrix<f64>, outputs: DMatrix<f64>) -> Result<Self, FitError> {
        if inputs.ncols() != outputs.ncols() {
            return Err(FitError::Unpaired { inputs: inputs.ncols(), outputs: outputs.ncols() });
        }
        for (side, m) in [(Side::Input, &inputs), (Side::Output, &outputs)] {
            if m.nrows() == 0 {
                return Err(FitError::Empty { side });
            }
            if let Some(i) = m.as_slice().iter().position(|v| !v.is_finite()) {
                let (pair, coordinate) = (i / m.nrows(), i % m.nrows());
                return Err(FitError::NotFinite { side, pair, coordinate, value: m[i] });
            }
        }
        let pairs = Pairs { inputs, outputs };
        pairs.at_least(2)?;
        pairs.check_distinct()?;
        Ok(pairs)
    }

    /// Looks at every two pairs.
    fn check_distinct(&self) -> Result<(), FitError> {
        let radius = |m: &DMatrix<f64>, side| {
            let r = (Space::of(m).scale.powi(2) * m.nrows() as f64).sqrt();
            if r > 0.0 && r.is_finite() { Ok(r) } else { Err(FitError::NoSpread { side }) }
        };
        let (ry, rz) = (radius(&self.inputs, Side::Input)?, radius(&self.outputs, Side::Output)?);
        for second in 0..self.len() {
            for first in 0..second {
                let apart = |m: &DMatrix<f64>, r: f64| {
                    distance_squared(column(m, first), column(m, second)).sqrt() / r
                };
                let input_distance = apart(&self.inputs, ry);
                if input_distance >= CLOSE {
                    continue;
                }
                let output_distance = apart(&self.outputs, rz);
                if output_distance > ANSWER {
                    return Err(FitError::Contradiction { first, second, input_distance, output_distance });
                }
                if input_distance < SAME {
                    return Err(FitError::Duplicate { first, second, input_distance });
                }
            }
        }
        Ok(())
    }

    /// Number of pairs N.
    pub fn len(&self) -> usize {
        self.inputs.ncols()
    }

    /// Never: there are at least two pairs.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Coordinates of an input, D_Y.
    pub fn input_dim(&self) -> usize {
        self.inputs.nrows()
    }

    /// Coordinates of an output, D_Z.
    pub fn output_dim(&self) -> usize {
        self.outputs.nrows()
    }

    /// Input `i`, D_Y long.
    pub fn input(&self, i: usize) -> &[f64] {
        column(&self.inputs, i)
    }

    /// Output `i`, D_Z long.
    pub fn output(&self, i: usize) -> &[f64] {
        column(&self.outputs, i)
    }

    /// Inputs, one a column (D_Y × N).
    pub(crate) fn inputs(&self) -> &DMatrix<f64> {
        &self.inputs
    }

    /// Outputs, one a column (D_Z × N).
    pub(crate) fn outputs(&self) -> &DMatrix<f64> {
        &self.outputs
    }

    /// The pairs with these numbers, in this order.
    ///
    /// # Errors
    /// As [`Pairs::new`]; a number beyond the pairs is [`FitError::Setting`].
    pub fn subset(&self, keep: &[usize]) -> Result<Self, FitError> {
        if let Some(&i) = keep.iter().find(|&&i| i >= self.len()) {
            let allowed = format!("below {}", self.len());
            return Err(FitError::Setting { name: "pair", value: i as f64, allowed });
        }
        Pairs::from_columns(self.inputs.select_columns(keep), self.outputs.select_columns(keep))
    }

    /// Complains if there are fewer than `least`.
    pub(crate) fn at_least(&self, least: usize) -> Result<(), FitError> {
        if self.len() < least { Err(FitError::TooFew { found: self.len(), least }) } else { Ok(()) }
    }
}

/// Column `i` of a matrix as a slice.
pub(crate) fn column(m: &DMatrix<f64>, i: usize) -> &[f64] {
    let d = m.nrows();
    &m.as_slice()[i * d..(i + 1) * d]
}

/// A side of the pairs, centred and divided by one number: (v − mean)/scale has unit variance, averaged over
/// coordinates.
///
/// One scale for all coordinates: a marker that hardly moves stays one that hardly moves.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Space {
    /// D.
    pub mean: Vec<f64>,
    /// Root of the mean variance of the coordinates; unit of the side.
    pub scale: f64,
    /// D × N, without unit.
    pub points: DMatrix<f64>,
}

impl Space {
    /// Of the columns of `m`.
    pub fn of(m: &DMatrix<f64>) -> Self {
        let (d, n) = m.shape();
        let mut mean = vec![0.0; d];
        for i in 0..n {
            for (a, v) in mean.iter_mut().zip(column(m, i)) {
                *a += v / n as f64;
            }
        }
        let mut points = m.clone();
        for i in 0..n {
            for k in 0..d {
                points[(k, i)] -= mean[k];
            }
        }
        let scale = (points.as_slice().iter().map(|v| v * v).sum::<f64>() / (n * d) as f64).sqrt();
        if scale > 0.0 {
            points /= scale;
        }
        Space { mean, scale, points }
    }

    /// Writes (v − mean)/scale.
    ///
    /// # Errors
    /// A wrong number of coordinates, or one that is not finite.
    pub fn enter(&self, v: &[f64], out: &mut [f64]) -> Result<(), InputError> {
        if v.len() != self.mean.len() {
            return Err(InputError::Dimension { found: v.len(), expected: self.mean.len() });
        }
        for (coordinate, (&value, (o, m))) in v.iter().zip(out.iter_mut().zip(&self.mean)).enumerate() {
            if !value.is_finite() {
                return Err(InputError::NotFinite { coordinate, value });
            }
            *o = (value - m) / self.scale;
        }
        Ok(())
    }
}

/// How the inputs cover their space: when is a new one beyond them?
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Coverage {
    /// The largest distance from an input to its nearest neighbour, scaled units.
    pub gap: f64,
}

impl Coverage {
    /// Of the columns of `points`.
    pub fn of(points: &DMatrix<f64>) -> Self {
        let n = points.ncols();
        let nearest = |i: usize| {
            (0..n)
                .filter(|&j| j != i)
                .map(|j| distance_squared(column(points, i), column(points, j)))
                .fold(f64::INFINITY, f64::min)
        };
        Coverage { gap: (0..n).map(nearest).fold(0.0, f64::max).sqrt() }
    }

    /// Writes squared distances from `v` to the columns of `points`; returns the nearest and its distance
    /// over the gap.
    pub fn novelty(&self, points: &DMatrix<f64>, v: &[f64], squared: &mut [f64]) -> (usize, f64) {
        let mut best = 0;
        for (i, r) in squared.iter_mut().enumerate() {
            *r = distance_squared(v, column(points, i));
        }
        for i in 1..squared.len() {
            if squared[i] < squared[best] {
                best = i;
            }
        }
        (best, squared[best].sqrt() / self.gap)
    }
}
