//! Runs of frames: what lasts, from when to when.

use std::ops::Range;

/// Runs of those of `frames` that are `of` a kind, in order; no two of them touch.
///
/// # Examples
/// ```
/// assert_eq!(motion::runs(0..7, |f| f != 3 && f > 0), [1..3, 4..7]);
/// assert!(motion::runs(0..7, |_| false).is_empty());
/// ```
pub fn runs(frames: Range<usize>, of: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let mut out: Vec<Range<usize>> = Vec::new();
    for f in frames.filter(|f| of(*f)) {
        match out.last_mut().filter(|run| run.end == f) {
            Some(run) => run.end = f + 1,
            None => out.push(f..f + 1),
        }
    }
    out
}
