//! The table of dynamic programming, by antidiagonals.
//!
//! Cell (i, j) of the frames is (i + 1, j + 1) here, on the antidiagonal k = i + j + 2; row and column 0 are
//! where a path may start from: (0, 0), and (0, j), (i, 0) up to the loose frames (any j for a piece). With waits limited to w,
//!
//! ```text
//! D(i, j) = min  D(i−1−s, j−1) + Σ_{t ≤ s} c(i−t, j),   s = 0 … w   (b waits s steps)
//!                D(i−1, j−1−s) + Σ_{t ≤ s} c(i, j−t)                (a waits s steps)
//! ```
//!
//! and without a limit D(i, j) = c(i, j) + min(D(i−1, j−1), D(i−1, j), D(i, j−1)), which is the same for w ≥ the
//! number of frames: costs are not negative, so that two waits with a corner between are never cheaper than
//! the diagonal.

use super::{DtwError, LONGEST_WAIT, Limits, MOST_CELLS, Path, Series};

/// Cells of the band on every antidiagonal: rows `lo..=hi`, from `offset` on in the table.
struct Span {
    lo: usize,
    hi: usize,
    offset: usize,
}

/// One value per row of an antidiagonal, with infinity around what is in the band.
type Diagonal = Vec<f64>;

struct Costs {
    /// Channel by channel.
    a: Vec<f64>,
    /// Channel by channel, last frame first: along an antidiagonal both series are read forwards.
    b: Vec<f64>,
    m: usize,
    n: usize,
    channels: usize,
}

impl Costs {
    fn new(a: Series, b: Series) -> Self {
        let (m, n, channels) = (a.frames(), b.frames(), a.channels);
        let planar = |s: Series, frame: &dyn Fn(usize) -> usize, frames: usize| -> Vec<f64> {
            (0..channels)
                .flat_map(|c| (0..frames).map(move |i| (c, i)))
                .map(|(c, i)| s.values[frame(i) * channels + c])
                .collect()
        };
        Costs { a: planar(a, &|i| i, m), b: planar(b, &|j| n - 1 - j, n), m, n, channels }
    }

    /// The two series along rows `lo..=hi` of antidiagonal k, for a channel.
    fn along(&self, k: usize, span: &Span, channel: usize) -> (&[f64], &[f64]) {
        let count = span.hi + 1 - span.lo;
        // row i has frame i − 1 of a and frame k − i − 1 of b
        let a = channel * self.m + span.lo - 1;
        let b = channel * self.n + self.n + span.lo - k;
        (&self.a[a..a + count], &self.b[b..b + count])
    }

    /// c of rows `lo..=hi` of antidiagonal k.
    fn fill(&self, k: usize, span: &Span, out: &mut [f64]) {
        let (a, b) = self.along(k, span, 0);
        for ((o, x), y) in out.iter_mut().zip(a).zip(b) {
            *o = (x - y) * (x - y);
        }
        for channel in 1..self.channels {
            let (a, b) = self.along(k, span, channel);
            for ((o, x), y) in out.iter_mut().zip(a).zip(b) {
                *o += (x - y) * (x - y);
            }
        }
    }
}

/// The rows of every antidiagonal 0 to m + n that are inside the band.
fn spans(m: usize, n: usize, band: Option<usize>) -> (Vec<Span>, usize) {
    let (x, y) = (1.0 / (m - 1).max(1) as f64, 1.0 / (n - 1).max(1) as f64);
    // a share of the whole time; the tolerance keeps cells on the edge whatever the rounding
    let width = band.map(|w| w as f64 * x.min(y) + 0.5 * x.max(y) + 1e-9);
    let mut offset = 0;
    let spans = (0..=m + n)
        .map(|k| {
            let (mut lo, mut hi) = (k.saturating_sub(n).max(1), (k.max(1) - 1).min(m));
            if let (Some(w), true) = (width, k >= 2) {
                // |(i − 1) x − (k − i − 1) y| ≤ w
                let middle = (x + (k - 1) as f64 * y) / (x + y);
                lo = lo.max((middle - w / (x + y)).ceil().max(0.0) as usize);
                hi = hi.min((middle + w / (x + y)).floor().max(0.0) as usize);
            }
            let span = Span { lo, hi, offset };
            offset += (hi + 1).saturating_sub(lo);
            span
        })
        .collect();
    (spans, offset)
}

/// Whether a path may end in row i, column j.
fn ends(i: usize, j: usize, m: usize, n: usize, limits: Limits) -> bool {
    (i == m && (limits.piece || j + limits.loose >= n)) || (j == n && i + limits.loose >= m)
}

pub(super) fn cheapest(a: Series, b: Series, limits: Limits) -> Result<Path, DtwError> {
    let (m, n) = (a.frames(), b.frames());
    let (spans, cells) = spans(m, n, limits.band);
    if cells > MOST_CELLS {
        return Err(DtwError::TooLong { a: m, b: n, cells });
    }
    let costs = Costs::new(a, b);
    let mut steps = Vec::with_capacity(cells);
    // a wait as long as a series is no limit; a step is a byte
    let wait = limits.wait.filter(|w| *w < m.max(n));
    let end = match wait {
        Some(wait) if wait > LONGEST_WAIT => return Err(DtwError::Wait { wait, frames: m.max(n) }),
        Some(wait) => limited(&costs, &spans, wait, limits, &mut steps),
        None => unlimited(&costs, &spans, limits, &mut steps),
    };
    if !end.cost.is_finite() {
        let Limits { band, loose, .. } = limits;
        return Err(DtwError::NoPath { a: m, b: n, wait: wait.unwrap_or(m.max(n)), loose, band });
    }
    let table = Table { spans: &spans, steps: &steps, by_waits: wait.is_some() };
    Ok(Path { pairs: table.trace(end.cell), cost: end.cost, frames: (m, n) })
}

/// Steps without a limit on waits. With one, a step is the diagonal and then `s` steps of a (`s`), or of b
/// (`LONGEST_WAIT + s`).
const BOTH: u8 = 0;
const ONLY_A: u8 = 1;
const ONLY_B: u8 = 2;

/// Infinity around the span, and what a path may start from.
fn borders(row: &mut [f64], k: usize, span: &Span, margin: usize, limits: Limits) {
    let last = row.len() - 1;
    if span.lo <= span.hi {
        row[span.lo.saturating_sub(margin)..span.lo].fill(f64::INFINITY);
        row[(span.hi + 1).min(last)..=(span.hi + margin).min(last)].fill(f64::INFINITY);
    } else {
        row.fill(f64::INFINITY);
    }
    starts(row, k, limits);
}

/// What a path may start from on antidiagonal k: the cells (0, k) and (k, 0).
fn starts(row: &mut [f64], k: usize, limits: Limits) {
    let start = |may: bool| if may { 0.0 } else { f64::INFINITY };
    if k < row.len() {
        row[k] = start(k <= limits.loose);
    }
    row[0] = start(limits.piece || k <= limits.loose);
}

struct End {
    cell: (usize, usize),
    cost: f64,
}

impl End {
    /// The cheaper of what was found and the ends on antidiagonal k; the later at equal costs.
    fn look(&mut self, row: &[f64], k: usize, span: &Span, costs: &Costs, limits: Limits) {
        for i in [costs.m, k.saturating_sub(costs.n)] {
            if i < span.lo || i > span.hi || !ends(i, k - i, costs.m, costs.n, limits) {
                continue;
            }
            if row[i] <= self.cost {
                *self = End { cell: (i, k - i), cost: row[i] };
            }
        }
    }
}

fn unlimited(costs: &Costs, spans: &[Span], limits: Limits, steps: &mut Vec<u8>) -> End {
    let rows = costs.m + 2;
    let mut before: Diagonal = vec![f64::INFINITY; rows];
    let mut last: Diagonal = vec![f64::INFINITY; rows];
    let mut now: Diagonal = vec![f64::INFINITY; rows];
    borders(&mut before, 0, &spans[0], 1, limits);
    borders(&mut last, 1, &spans[1], 1, limits);
    let mut best = End { cell: (0, 0), cost: f64::INFINITY };
    for (k, span) in spans.iter().enumerate().skip(2) {
        if span.lo <= span.hi {
            let (lo, hi) = (span.lo, span.hi);
            costs.fill(k, span, &mut now[lo..=hi]);
            let at = steps.len();
            steps.resize(at + hi + 1 - lo, BOTH);
            advance(
                &mut now[lo..=hi],
                &before[lo - 1..hi],
                &last[lo - 1..hi],
                &last[lo..=hi],
                &mut steps[at..],
            );
        }
        borders(&mut now, k, span, 1, limits);
        best.look(&now, k, span, costs, limits);
        std::mem::swap(&mut before, &mut last);
        std::mem::swap(&mut last, &mut now);
    }
    best
}

/// One antidiagonal: `now` holds c and becomes D; no cell of it depends on another.
fn advance(now: &mut [f64], both: &[f64], only_a: &[f64], only_b: &[f64], steps: &mut [u8]) {
    let count = now.len();
    let (both, only_a, only_b, steps) =
        (&both[..count], &only_a[..count], &only_b[..count], &mut steps[..count]);
    for i in 0..count {
        let (d, a, b) = (both[i], only_a[i], only_b[i]);
        let side = if b < a { b } else { a };
        let side_step = if b < a { ONLY_B } else { ONLY_A };
        now[i] += if side < d { side } else { d };
        steps[i] = if side < d { side_step } else { BOTH };
    }
}

fn limited(costs: &Costs, spans: &[Span], wait: usize, limits: Limits, steps: &mut Vec<u8>) -> End {
    let rows = costs.m + 2;
    let kept = wait + 3;
    let mut totals: Vec<Diagonal> = vec![vec![f64::INFINITY; rows]; kept];
    let mut own: Vec<Diagonal> = vec![vec![f64::INFINITY; rows]; kept];
    let empty = Span { lo: 1, hi: 0, offset: 0 };
    borders(&mut totals[0], 0, &empty, 0, limits);
    borders(&mut totals[1], 1, &empty, 0, limits);
    let mut best = End { cell: (0, 0), cost: f64::INFINITY };
    let mut now: Diagonal = vec![f64::INFINITY; rows];
    for (k, span) in spans.iter().enumerate().skip(2) {
        let slot = k % kept;
        now.fill(f64::INFINITY);
        own[slot].fill(f64::INFINITY);
        if span.lo <= span.hi {
            costs.fill(k, span, &mut own[slot][span.lo..=span.hi]);
            for i in span.lo..=span.hi {
                let (mut down, mut right) = (0.0, 0.0);
                let (mut least, mut step) = (f64::INFINITY, 0);
                for s in 0..=wait {
                    // s steps of a, or of b, after the diagonal; at s = 0 both are the diagonal alone
                    let before = (k + 2 * kept - 2 - s) % kept;
                    let c = &own[(k + kept - s) % kept];
                    if i > s {
                        down += c[i - s];
                        let total = totals[before][i - 1 - s] + down;
                        if total < least {
                            (least, step) = (total, s);
                        }
                    }
                    if k - i > s {
                        right += c[i];
                        let total = totals[before][i - 1] + right;
                        if total < least {
                            (least, step) = (total, s + LONGEST_WAIT);
                        }
                    }
                }
                now[i] = least;
                steps.push(step as u8);
            }
        }
        starts(&mut now, k, limits);
        best.look(&now, k, span, costs, limits);
        std::mem::swap(&mut totals[slot], &mut now);
    }
    best
}

struct Table<'a> {
    spans: &'a [Span],
    steps: &'a [u8],
    by_waits: bool,
}

impl Table<'_> {
    /// The path back from its end to where it started, in frames, first to last.
    fn trace(&self, (mut i, mut j): (usize, usize)) -> Vec<(usize, usize)> {
        let mut pairs = Vec::new();
        while i > 0 && j > 0 {
            pairs.push((i - 1, j - 1));
            let span = &self.spans[i + j];
            let step = self.steps[span.offset + i - span.lo];
            if !self.by_waits {
                i -= usize::from(step != ONLY_B);
                j -= usize::from(step != ONLY_A);
                continue;
            }
            let step = step as usize;
            let (of_a, of_b) = if step <= LONGEST_WAIT { (step, 0) } else { (0, step - LONGEST_WAIT) };
            pairs.extend((1..=of_a).map(|t| (i - 1 - t, j - 1)));
            pairs.extend((1..=of_b).map(|t| (i - 1, j - 1 - t)));
            (i, j) = (i - 1 - of_a, j - 1 - of_b);
        }
        pairs.reverse();
        pairs
    }
}
