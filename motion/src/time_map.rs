//! Time maps: when what happens in a motion happens in the retimed motion.
//!
//! In: anchors `(from_s, to_s)`: what was at `from_s` comes at `to_s`. Out: a strictly increasing map of the whole
//! time line, its inverse, its slope, and clips retimed by it.
//!
//! *Between anchors* the map is a cubic Hermite interpolant with one slope for each anchor. The slope of an inner
//! anchor is the weighted harmonic mean of the slopes of the two intervals beside it \[FB84\], which keeps the
//! interpolant monotone \[FC80\]: each interval lies between its anchors, and slopes are continuous, so velocities do
//! not jump where an anchor lies.
//!
//! *Outside the first and the last anchor* time is shifted: slope 1. What the slope of the first and the last anchor
//! itself is, says [`End`].
//!
//! *Slopes.* Slope 2 is twice as slow: what took 1 s takes 2 s, and velocities are halved. At every time slopes stay
//! within [`LEAST_SLOPE`] and [`MOST_SLOPE`], so that the inverse is as well conditioned as the map.
//!
//! Symbols: `h` length of an interval of `from_s` (s), `Δ` its mean slope, `d` slope at an anchor, `u` time since the
//! beginning of the interval (s).
//!
//! \[FC80\] Fritsch, Carlson. Monotone piecewise cubic interpolation. SIAM J. Numer. Anal. 17, 1980.
//! \[FB84\] Fritsch, Butland. A method for constructing local monotone piecewise cubic interpolants. SIAM J. Sci. Stat.
//! Comput. 5, 1984.

use thiserror::Error;

use crate::Clip;

/// The least slope of a map: 20 times as fast.
pub const LEAST_SLOPE: f64 = 0.05;
/// The largest slope of a map: 20 times as slow.
pub const MOST_SLOPE: f64 = 20.0;
/// Anchors are at least this far apart in both times, s.
pub const LEAST_STEP_S: f64 = 1e-6;

/// The slope of the first or last anchor is at most this many times the slope of its interval. At 3, the bound of
/// \[FC80\], the middle of an interval between two such anchors would stand still in the retimed motion.
const MOST_END: f64 = 2.0;

/// What the slope of the first or the last anchor is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// 1, as outside, where the motion goes on: slopes are continuous there too. An interval that runs more than
    /// twice as fast (`Δ < ½`) allows only `2Δ`, and the slope jumps from `2Δ` to 1.
    Joined,
    /// What the intervals beside it suggest (the three-point formula, within `Δ/2` and `2Δ`): for a map
    /// beyond whose anchor there is no motion. Two anchors with free ends are a line.
    Free,
}

/// Why anchors are no time map.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum TimeMapError {
    /// Fewer than two anchors.
    #[error("a time map has {0} anchors; it needs at least 2")]
    TooFew(usize),
    /// A time that is not finite.
    #[error("anchor {index} goes from {from_s} s to {to_s} s; both must be finite")]
    NotFinite {
        /// Which, counted from 0.
        index: usize,
        /// Time in the source motion, s.
        from_s: f64,
        /// Time in the retimed motion, s.
        to_s: f64,
    },
    /// An anchor that does not come after the one before.
    #[error(
        "anchor {index} goes from {from_s} s to {to_s} s, the one before from {before_from_s} s to {before_to_s} s; both times must increase by at least 0.000001 s"
    )]
    NotIncreasing {
        /// Which, counted from 0.
        index: usize,
        /// Its time in the source motion, s.
        from_s: f64,
        /// Its time in the retimed motion, s.
        to_s: f64,
        /// Time of the anchor before in the source motion, s.
        before_from_s: f64,
        /// Time of the anchor before in the retimed motion, s.
        before_to_s: f64,
    },
    /// A slope out of bounds.
    #[error(
        "between the anchors at {from_s} s and {until_s} s the time map has slope {slope:.3}; allowed: 0.05 (20 times as fast) to 20 (20 times as slow)"
    )]
    Slope {
        /// Beginning of the interval in the source motion, s.
        from_s: f64,
        /// Its end in the source motion, s.
        until_s: f64,
        /// The slope found furthest out of bounds.
        slope: f64,
    },
}

/// A strictly increasing map from the time of a motion to that of the retimed motion. See the module header.
///
/// # Examples
/// ```
/// use motion::TimeMap;
/// // the beat at 1 s comes half a second later; before 0 s and after 2 s nothing is stretched
/// let late = TimeMap::new(&[(0.0, 0.0), (1.0, 1.5), (2.0, 2.25)]).unwrap();
/// assert_eq!(late.at(1.0), 1.5);
/// assert_eq!(late.at(3.0), 3.25);
/// assert!((late.inverse().at(late.at(0.7)) - 0.7).abs() < 1e-14);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimeMap {
    /// Applied one after another; none is the identity.
    stages: Vec<Stage>,
}

/// One interpolant, or its inverse.
#[derive(Clone, Debug, PartialEq)]
struct Stage {
    knots: Vec<Knot>,
    inverted: bool,
}

/// An anchor with its slope.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Knot {
    from_s: f64,
    to_s: f64,
    slope: f64,
}

impl TimeMap {
    /// The map that changes no time, to the bit.
    pub fn identity() -> Self {
        Self::default()
    }

    /// The map through `anchors`, `(from_s, to_s)`, joined at both ends to what lies outside ([`End::Joined`]).
    ///
    /// Anchors that change no time give the identity.
    ///
    /// # Errors
    /// See [`TimeMapError`].
    pub fn new(anchors: &[(f64, f64)]) -> Result<Self, TimeMapError> {
        Self::with_ends(anchors, [End::Joined; 2])
    }

    /// As [`TimeMap::new`], with the rule for the slope of the first and of the last anchor.
    ///
    /// # Errors
    /// See [`TimeMapError`].
    pub fn with_ends(anchors: &[(f64, f64)], ends: [End; 2]) -> Result<Self, TimeMapError> {
        check(anchors)?;
        if anchors.iter().all(|(from, to)| from == to) {
            return Ok(Self::identity());
        }
        let knots: Vec<Knot> = anchors
            .iter()
            .zip(slopes(anchors, ends))
            .map(|(&(from_s, to_s), slope)| Knot { from_s, to_s, slope })
            .collect();
        for pair in knots.windows(2) {
            let (least, most) = Cubic::new(&pair[0], &pair[1]).slopes();
            let slope = if least < LEAST_SLOPE { least } else { most };
            if !(LEAST_SLOPE..=MOST_SLOPE).contains(&slope) {
                return Err(TimeMapError::Slope { from_s: pair[0].from_s, until_s: pair[1].from_s, slope });
            }
        }
        Ok(Self { stages: vec![Stage { knots, inverted: false }] })
    }

    /// Whether it is the identity.
    pub fn is_identity(&self) -> bool {
        self.stages.is_empty()
    }

    /// When, in the retimed motion, what was at `t_s` comes, s. Anchors are met to the bit.
    pub fn at(&self, t_s: f64) -> f64 {
        self.stages.iter().fold(t_s, |t, stage| stage.at(t))
    }

    /// Slope at `t_s`: retimed seconds for each second of the source, which is what velocities are divided by.
    ///
    /// Where slopes jump, at a first or last anchor, it is the slope between the anchors.
    pub fn rate(&self, t_s: f64) -> f64 {
        let step = |(t, rate): (f64, f64), stage: &Stage| (stage.at(t), rate * stage.slope(t));
        self.stages.iter().fold((t_s, 1.0), step).1
    }

    /// The map from the retimed motion back to the source.
    ///
    /// `inverse().at(at(t))` is `t` to rounding: within 3e-15 s for times up to 10 s and anchors whose slopes are
    /// ½ to 2, within 1e-13 s for all slopes allowed.
    pub fn inverse(&self) -> Self {
        let turned = |s: &Stage| Stage { knots: s.knots.clone(), inverted: !s.inverted };
        Self { stages: self.stages.iter().rev().map(turned).collect() }
    }

    /// This map and then `next`, exactly: `then(next).at(t)` is `next.at(at(t))`.
    ///
    /// Slopes multiply; the bounds hold for each map, not for their product.
    pub fn then(&self, next: &Self) -> Self {
        Self { stages: self.stages.iter().chain(&next.stages).cloned().collect() }
    }

    /// `clip` retimed, at the same rate of frames.
    ///
    /// Times of the result are times of the map: it begins at 0 and ends with the first frame at or after
    /// `at(duration)`. Its last frame is the last pose of `clip` to the bit, and the first is the first where
    /// `at(0)` is 0; where `at(0)` is later the first pose is held until then, where it is earlier what
    /// comes before 0 is cut off. Poses between frames are those of [`Clip::sample`] (slerp), so a motion made much
    /// slower turns corners at the frames of the source.
    pub fn retime(&self, clip: &Clip) -> Clip {
        if self.is_identity() || clip.frames() == 0 {
            return clip.clone();
        }
        // 1e-9 of a frame, as in sampling tracks: rounding must not add a frame
        let last = (self.at(clip.duration_s()) * clip.rate_hz - 1e-9).ceil().max(0.0) as usize;
        let back = self.inverse();
        let n = clip.skeleton.nq();
        let mut q = vec![0.0; (last + 1) * n];
        for (i, pose) in q.chunks_exact_mut(n).enumerate().take(last) {
            clip.sample(back.at(i as f64 / clip.rate_hz), pose);
        }
        q[last * n..].copy_from_slice(clip.pose(clip.frames() - 1));
        Clip::new(clip.skeleton.clone(), clip.rate_hz, q)
    }
}

impl Stage {
    fn at(&self, t: f64) -> f64 {
        if self.inverted { self.backward(t) } else { self.forward(t) }
    }

    fn slope(&self, t: f64) -> f64 {
        if self.inverted { 1.0 / self.forward_slope(self.backward(t)) } else { self.forward_slope(t) }
    }

    /// The interval in which `t`, read by `of`, lies; `None` outside the anchors, which count as inside.
    fn interval(&self, t: f64, of: impl Fn(&Knot) -> f64) -> Option<Cubic> {
        let after = self.knots.partition_point(|k| of(k) <= t);
        let last = self.knots.len() - 1;
        let right = if after == last + 1 && t == of(&self.knots[last]) { last } else { after };
        (1..=last).contains(&right).then(|| Cubic::new(&self.knots[right - 1], &self.knots[right]))
    }

    /// The anchor from which times outside the anchors are shifted.
    fn outer(&self, t: f64, of: impl Fn(&Knot) -> f64) -> Knot {
        let last = self.knots.len() - 1;
        self.knots[if t < of(&self.knots[0]) { 0 } else { last }]
    }

    fn forward(&self, t: f64) -> f64 {
        match self.interval(t, |k| k.from_s) {
            Some(cubic) => cubic.at(t),
            None => {
                let k = self.outer(t, |k| k.from_s);
                t + (k.to_s - k.from_s)
            }
        }
    }

    fn backward(&self, t: f64) -> f64 {
        match self.interval(t, |k| k.to_s) {
            Some(cubic) => cubic.solve(t),
            None => {
                let k = self.outer(t, |k| k.to_s);
                t - (k.to_s - k.from_s)
            }
        }
    }

    fn forward_slope(&self, t: f64) -> f64 {
        self.interval(t, |k| k.from_s).map_or(1.0, |cubic| cubic.slope(t))
    }
}

/// The interpolant of one interval: `to + u (d₀ + u (c₂ + u c₃))`, `u = t − from`.
struct Cubic {
    a: Knot,
    b: Knot,
    h: f64,
    mean: f64,
    c3: f64,
}

impl Cubic {
    fn new(a: &Knot, b: &Knot) -> Self {
        let h = b.from_s - a.from_s;
        let mean = (b.to_s - a.to_s) / h;
        Self { a: *a, b: *b, h, mean, c3: (a.slope + b.slope - 2.0 * mean) / (h * h) }
    }

    /// `c₂` of the polynomial written from the end of slope `d`, whose other end has slope `other`.
    fn c2(&self, d: f64, other: f64) -> f64 {
        (3.0 * self.mean - 2.0 * d - other) / self.h
    }

    fn at(&self, t: f64) -> f64 {
        // from the nearer end, so that both are met to the bit
        let (a, b) = (&self.a, &self.b);
        let u = t - a.from_s;
        if u <= 0.5 * self.h {
            a.to_s + u * (a.slope + u * (self.c2(a.slope, b.slope) + u * self.c3))
        } else {
            let u = b.from_s - t;
            b.to_s - u * (b.slope + u * (self.c2(b.slope, a.slope) + u * self.c3))
        }
    }

    fn slope(&self, t: f64) -> f64 {
        let (a, b) = (&self.a, &self.b);
        let u = t - a.from_s;
        if u <= 0.5 * self.h {
            a.slope + u * (2.0 * self.c2(a.slope, b.slope) + 3.0 * u * self.c3)
        } else {
            let u = b.from_s - t;
            b.slope + u * (2.0 * self.c2(b.slope, a.slope) + 3.0 * u * self.c3)
        }
    }

    /// Least and largest slope of the interval.
    fn slopes(&self) -> (f64, f64) {
        let (d0, d1) = (self.a.slope, self.b.slope);
        let (mut least, mut most) = (d0.min(d1), d0.max(d1));
        // where the second derivative vanishes
        let u = -self.c2(d0, d1) / (3.0 * self.c3);
        if u > 0.0 && u < self.h {
            let s = self.slope(self.a.from_s + u);
            (least, most) = (least.min(s), most.max(s));
        }
        (least, most)
    }

    /// The time of the source that maps to `to`: Newton's method, kept in its bracket by bisection.
    fn solve(&self, to: f64) -> f64 {
        let (mut lo, mut hi) = (self.a.from_s, self.b.from_s);
        if to == self.a.to_s {
            return lo;
        }
        if to == self.b.to_s {
            return hi;
        }
        let mut t = lo + (to - self.a.to_s) / self.mean;
        // converges in six steps at most slopes; 64 halvings exhaust the digits of any bracket
        for _ in 0..64 {
            let miss = self.at(t) - to;
            if miss == 0.0 {
                break;
            }
            if miss > 0.0 {
                hi = hi.min(t)
            } else {
                lo = lo.max(t)
            }
            let newton = t - miss / self.slope(t);
            let next = if newton > lo && newton < hi { newton } else { 0.5 * (lo + hi) };
            if next == t || hi - lo <= f64::EPSILON * hi.abs().max(lo.abs()) {
                break;
            }
            t = next;
        }
        t
    }
}

fn check(anchors: &[(f64, f64)]) -> Result<(), TimeMapError> {
    if anchors.len() < 2 {
        return Err(TimeMapError::TooFew(anchors.len()));
    }
    if let Some(index) = anchors.iter().position(|(from, to)| !from.is_finite() || !to.is_finite()) {
        let (from_s, to_s) = anchors[index];
        return Err(TimeMapError::NotFinite { index, from_s, to_s });
    }
    for (i, pair) in anchors.windows(2).enumerate() {
        let ((before_from_s, before_to_s), (from_s, to_s)) = (pair[0], pair[1]);
        if from_s - before_from_s < LEAST_STEP_S || to_s - before_to_s < LEAST_STEP_S {
            return Err(TimeMapError::NotIncreasing {
                index: i + 1,
                from_s,
                to_s,
                before_from_s,
                before_to_s,
            });
        }
    }
    Ok(())
}

/// The slope of every anchor.
fn slopes(anchors: &[(f64, f64)], ends: [End; 2]) -> Vec<f64> {
    let h: Vec<f64> = anchors.windows(2).map(|w| w[1].0 - w[0].0).collect();
    let mean: Vec<f64> = anchors.windows(2).zip(&h).map(|(w, h)| (w[1].1 - w[0].1) / h).collect();
    let last = h.len();
    let end = |rule: End, near: usize, next: Option<usize>| match rule {
        End::Joined => f64::min(1.0, MOST_END * mean[near]),
        End::Free => next.map_or(mean[near], |next| {
            let (h0, h1) = (h[near], h[next]);
            let three_point = ((2.0 * h0 + h1) * mean[near] - h0 * mean[next]) / (h0 + h1);
            three_point.clamp(mean[near] / MOST_END, MOST_END * mean[near])
        }),
    };
    let inner = |i: usize| {
        let (w0, w1) = (2.0 * h[i] + h[i - 1], h[i] + 2.0 * h[i - 1]);
        (w0 + w1) / (w0 / mean[i - 1] + w1 / mean[i])
    };
    let mut all = vec![end(ends[0], 0, (last > 1).then_some(1))];
    all.extend((1..last).map(inner));
    all.push(end(ends[1], last - 1, last.checked_sub(2)));
    all
}
