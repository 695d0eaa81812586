//! A warping path and what follows from it: a partner for every frame, and how hard time is bent.

/// A chain of pairs (frame of a, frame of b); both never go back, and at least one goes on.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    pub(super) pairs: Vec<(usize, usize)>,
    pub(super) cost: f64,
    pub(super) frames: (usize, usize),
}

impl Path {
    /// The pairs, first to last.
    pub fn pairs(&self) -> &[(usize, usize)] {
        &self.pairs
    }

    /// Sum of the squared differences along the path.
    pub fn cost(&self) -> f64 {
        self.cost
    }

    /// Root of [`Path::cost`], as dtaidistance and tslearn have it.
    pub fn distance(&self) -> f64 {
        self.cost.sqrt()
    }

    /// For every frame of a, its frame of b: the mean of its partners, so in between where b goes faster, and
    /// never falling. Loose frames at the ends go on at one frame per frame, and stop at the ends of b.
    pub fn partners_of_a(&self) -> Vec<f64> {
        partners(self.pairs.iter().copied(), self.frames)
    }

    /// For every frame of b, its frame of a.
    pub fn partners_of_b(&self) -> Vec<f64> {
        partners(self.pairs.iter().map(|p| (p.1, p.0)), (self.frames.1, self.frames.0))
    }

    /// The path of the exchanged series.
    pub fn exchanged(&self) -> Path {
        Path {
            pairs: self.pairs.iter().map(|p| (p.1, p.0)).collect(),
            cost: self.cost,
            frames: (self.frames.1, self.frames.0),
        }
    }

    /// Longest waits in steps: of a for b, and of b for a.
    pub fn longest_waits(&self) -> (usize, usize) {
        let (mut longest, mut now) = ((0, 0), (0, 0));
        for w in self.pairs.windows(2) {
            now.0 = if w[1].0 == w[0].0 { now.0 + 1 } else { 0 };
            now.1 = if w[1].1 == w[0].1 { now.1 + 1 } else { 0 };
            longest = (longest.0.max(now.0), longest.1.max(now.1));
        }
        longest
    }
}

fn partners(pairs: impl Iterator<Item = (usize, usize)>, (frames, others): (usize, usize)) -> Vec<f64> {
    let mut sums = vec![(0.0, 0usize); frames];
    for (i, j) in pairs {
        sums[i].0 += j as f64;
        sums[i].1 += 1;
    }
    let matched = |s: &(f64, usize)| s.1 > 0;
    let first = sums.iter().position(matched).expect("a path has a pair");
    let last = sums.iter().rposition(matched).expect("a path has a pair");
    let mean = |i: usize| sums[i].0 / sums[i].1 as f64;
    let end = (others - 1) as f64;
    (0..frames)
        .map(|i| match i {
            i if i < first => (mean(first) - (first - i) as f64).max(0.0),
            i if i > last => (mean(last) + (i - last) as f64).min(end),
            i => mean(i),
        })
        .collect()
}
