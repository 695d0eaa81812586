//! Spans of rows in which a value is beyond a limit.

use std::ops::Range;

/// A span of rows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Span {
    /// Its rows.
    pub rows: Range<usize>,
    /// Largest value in it.
    pub largest: f64,
}

/// All spans of at least `long` rows (at least one) in which every value is beyond `limit`, in order.
pub(crate) fn beyond(values: &[f64], limit: f64, long: usize) -> impl Iterator<Item = Span> {
    let mut row = 0;
    values.chunk_by(move |a, b| (*a > limit) == (*b > limit)).filter_map(move |run| {
        let rows = row..row + run.len();
        row = rows.end;
        let largest = run.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (largest > limit && run.len() >= long).then_some(Span { rows, largest })
    })
}
