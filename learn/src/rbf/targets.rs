//! Targets of examples in even and odd coordinates, about what is taken away.

use crate::examples::Examples;
use crate::parity::{Parity, Sign};

/// Targets in even and odd coordinates.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Targets {
    pub parity: Parity,
    /// Taken away from the targets: even coordinates, then odd ones (zero).
    pub centre: Vec<f64>,
    pub parts: Vec<Part>,
}

/// The targets of one half.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Part {
    pub sign: Sign,
    pub first: usize,
    pub columns: usize,
    /// N × columns, row-major.
    pub values: Vec<f64>,
}

impl Targets {
    pub fn of(examples: &Examples, centre: bool) -> Self {
        let y = examples.targets();
        let (n, d) = y.shape();
        let parity = Parity::of(examples.mirror().map(|m| m.output.as_slice()), d);
        let mut mean = vec![0.0; d];
        if centre {
            let mut row = vec![0.0; d];
            for i in 0..n {
                parity.enter(|k| y[(i, k)], &mut row);
                mean[..parity.even].iter_mut().zip(&row).for_each(|(m, v)| *m += v / n as f64);
            }
        }
        Targets::about(examples, parity, mean)
    }

    /// About a centre that is known.
    pub fn about(examples: &Examples, parity: Parity, centre: Vec<f64>) -> Self {
        let y = examples.targets();
        let (n, d) = y.shape();
        let even = parity.even;
        let part = |sign, first, columns| Part { sign, first, columns, values: vec![0.0; n * columns] };
        let mut parts = if examples.mirror().is_some() {
            vec![part(Sign::Even, 0, even), part(Sign::Odd, even, d - even)]
        } else {
            vec![part(Sign::Only, 0, d)]
        };
        let mut row = vec![0.0; d];
        for i in 0..n {
            parity.enter(|k| y[(i, k)], &mut row);
            row.iter_mut().zip(&centre).for_each(|(v, c)| *v -= c);
            for p in &mut parts {
                p.values[i * p.columns..(i + 1) * p.columns]
                    .copy_from_slice(&row[p.first..p.first + p.columns]);
            }
        }
        Targets { parity, centre, parts }
    }

    /// Coordinates D_y.
    pub fn dimension(&self) -> usize {
        self.parity.len()
    }

    /// Mean square of all values.
    pub fn mean_square(&self) -> f64 {
        let (sum, count) = self.parts.iter().fold((0.0, 0), |(s, c), p| {
            (s + p.values.iter().map(|v| v * v).sum::<f64>(), c + p.values.len())
        });
        sum / count as f64
    }
}
