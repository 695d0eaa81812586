//! How well a component tells two clips apart.
//!
//! In: the activations of a component over the joined clip. Out: a [`Separation`]: by level, the probability that a
//! frame of one clip has a larger activation than a frame of the other, and by spread, the same for the distance
//! from the clip's own mean; both as |2 p − 1|, 0 (not at all) to 1 (every pair of frames). Ranks only (Mann and
//! Whitney), so that neither scale nor outliers matter.

/// How well a component tells two clips apart. See the module header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation {
    /// By level: posture.
    pub level: f64,
    /// By spread: rhythm.
    pub spread: f64,
}

impl Separation {
    /// The better of both.
    pub fn best(&self) -> f64 {
        self.level.max(self.spread)
    }

    /// Whether the clips differ in what the component is on average, rather than in how much it swings.
    pub fn is_posture(&self) -> bool {
        self.level >= self.spread
    }
}

/// Separates the first `first` values from the others.
pub fn separate(u: &[f64], first: usize) -> Separation {
    let (a, b) = u.split_at(first);
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len().max(1) as f64;
    let away = |x: &[f64]| -> Vec<f64> {
        let m = mean(x);
        x.iter().map(|v| (v - m).abs()).collect()
    };
    Separation { level: by_rank(a, b), spread: by_rank(&away(a), &away(b)) }
}

/// |2 p − 1| of the probability p that a value of `a` is above one of `b`; ties count half.
fn by_rank(a: &[f64], b: &[f64]) -> f64 {
    if a.is_empty() || b.is_empty() {
        return 0.0;
    }
    let mut all: Vec<(f64, bool)> =
        a.iter().map(|x| (*x, true)).chain(b.iter().map(|x| (*x, false))).collect();
    all.sort_by(|x, y| x.0.total_cmp(&y.0));
    let (mut ranks, mut at) = (0.0, 0);
    while at < all.len() {
        let end = at + all[at..].iter().take_while(|x| x.0 == all[at].0).count();
        let rank = 0.5 * (at + end - 1) as f64 + 1.0;
        ranks += rank * all[at..end].iter().filter(|x| x.1).count() as f64;
        at = end;
    }
    let (n, m) = (a.len() as f64, b.len() as f64);
    let p = (ranks - 0.5 * n * (n + 1.0)) / (n * m);
    (2.0 * p - 1.0).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By level, by spread, by neither.
    #[test]
    fn levels_and_spreads_are_told_apart() {
        let swing = |i: usize| (0.37 * i as f64).sin();
        let level: Vec<f64> = (0..600).map(|i| swing(i) + if i < 200 { 2.5 } else { 0.0 }).collect();
        let s = separate(&level, 200);
        assert!(s.level == 1.0 && s.spread < 0.1 && s.is_posture(), "{s:?}"); // 0.01 seen
        let spread: Vec<f64> = (0..600).map(|i| swing(i) * if i < 200 { 0.1 } else { 3.0 }).collect();
        let s = separate(&spread, 200);
        assert!(s.level < 0.1 && s.spread > 0.9 && !s.is_posture(), "{s:?}"); // 0.01, 0.98 seen
        assert_eq!(separate(&[1.0; 20], 7), Separation { level: 0.0, spread: 0.0 });
    }
}
