//! The way of a link whose points rest on the ground in their phases.
//!
//! In: the paths of the contact points of one link as the motion has them, and their phases. Out: paths of the same points,
//! as rigid as the link, that stand still in their phases, and in between go from place to place as smoothly as they
//! can. Units m and s; ground at height 0.
//!
//! Unknown for every frame i are the shift u_i of the points' centre m_i and a turn R_i about it (one point alone only
//! shifts), so that point c with the source x̄_c is at `x_c = m + u + R (x̄_c − m)`, corrected by `Δ_c = x_c − x̄_c`. Of
//! these, by Gauss–Newton,
//!
//! ```text
//! min Σ_c ∫ τ⁶ |d³Δ_c/dt³|² + ((R − 1)(x̄_c − m))_y²
//!           + ρ τ² |dΔ_c/dt|² + |Δ_c|²        in flight
//!           + |x_c − p_c|², horizontally      in a phase, p_c: the source's mean there     dt
//! ```
//!
//! with `x_c` at rest on the ground in its phases, and in flight not lower than a step has to lift, `h (4s(1 − s))³` over the
//! flight with h = [`CLEAR`] times its length (it starts and ends at rest too), both by penalties. Where the points then rest on
//! the average they are held in a second round: rest alone, from one frame to the next, is soft over hundreds of frames
//! (7 mm of slip were seen).
//!
//! What is smooth is the correction, not the motion: a take-off keeps the jerk that it has. A flight shorter than some τ is
//! corrected by the curve of least jerk, a quintic; in a longer one the point comes back to the source within some τ of
//! either end. The tilt of the link is the source's where only its heading has to differ: a foot whose toes rest
//! while the source turns by a right angle would otherwise stand on them.
//!
//! *Softness.* τ is [`QUICK_S`] and rises up to [`SOFT_S`] around those ends of phases where the path would be jerked more than it
//! may; there the motion's own jerk is left out of Δ by degrees, so that in the end it is the path itself that is
//! smooth. What is softer strays farther from the source in flight, by some v τ where its speed at the end is v; and phases
//! shorter than τ give way to steps.
//!
//! Because the points move as one body, a heel that flies while its ball rests turns about the ball, and nothing jumps when
//! the other of the two comes to rest. With a path of its own for each point the goals of a turning foot do not fit the foot:
//! up to 90 mm were measured, and the pose jumped at the touchdown.

use motion::{Quat, Vec3};

use super::peak_near;
use crate::phase::{Path, PhaseFrames};
use crate::refine::band::Band;

/// Time in which a correction comes and goes, τ, s.
const QUICK_S: f64 = 0.06;
/// The same at most, where the path would be jerked.
const SOFT_S: f64 = 0.12;
/// How much softer at once.
const SOFTER: f64 = 1.42;
/// Time on either side of a jerked end that becomes softer, s.
const AROUND_S: f64 = 0.4;
/// Weight of the correction's rate, ρ.
const RATE: f64 = 1.0;
/// Weight of rest in a phase at [`REST_HZ`]. It grows with the fourth power of the rate: steps from frame to frame and their
/// third differences shrink, and a weight that stays lets points creep (0.06 mm at 30 Hz, 0.94 mm at 120 Hz).
const REST: f64 = 1e7;
/// Rate at which [`REST`] is that.
const REST_HZ: f64 = 30.0;
/// Weight of what is below the ground, or too low, in flight.
const FLOOR: f64 = 1e3;
/// Height of a step over its length: lower it would be dragged along the ground.
const CLEAR: f64 = 0.12;
/// The most that has to be cleared, m: what the toes of a walking human do.
const CLEAR_MOST_M: f64 = 0.012;
/// Least stiffness of a turn: a turn about the line of all points moves none of them.
const IDLE: f64 = 1e-6;
/// Most Gauss–Newton steps.
const STEPS: usize = 20;
/// A step below this, m or rad, is the last: while places are looked for, and when they are kept.
const STILL: [f64; 2] = [1e-5, 1e-6];
/// Farthest turn in a step, rad.
const TURN: f64 = 0.5;

/// Frames that a third difference joins.
const JOINED: usize = 4;
/// Coefficients of a third difference.
const THIRD: [f64; JOINED] = [-1.0, 3.0, -3.0, 1.0];

/// One link's points over a clip. See the module header.
pub(super) struct Planted<'a> {
    sources: Vec<&'a Path>,
    /// For each point and frame the place of the phase it is in.
    rest: Vec<Vec<Option<Rest>>>,
    /// For each point and frame the height to be cleared.
    clear: Vec<Vec<f64>>,
    centre: Vec<Vec3>,
    shift: Vec<Vec3>,
    turn: Vec<Quat>,
    /// τ in every frame, s.
    softness: Vec<f64>,
    /// Unknowns of a frame.
    dofs: usize,
    /// Whether places are looked for; afterwards they are kept.
    searching: bool,
    rate_hz: f64,
}

/// A frame in a phase.
#[derive(Clone, Copy, Debug)]
struct Rest {
    place: Vec3,
    /// Whether the next frame belongs to the same phase.
    on: bool,
}

impl<'a> Planted<'a> {
    /// * `sources`, `spans`: of each point, in the same order; at least one point and one frame
    pub(super) fn new(sources: Vec<&'a Path>, spans: &[&[PhaseFrames]], rate_hz: f64) -> Self {
        let frames = sources[0].len();
        let n = sources.len() as f64;
        let rest = sources.iter().zip(spans).map(|(path, spans)| {
            let mut rest = vec![None; frames];
            for s in *spans {
                let place = mean(&path[s.first..=s.last]);
                for (i, r) in rest.iter_mut().enumerate().take(s.last + 1).skip(s.first) {
                    *r = Some(Rest { place, on: i < s.last });
                }
            }
            rest
        });
        let clear = sources.iter().zip(spans).map(|(path, spans)| {
            let mut clear = vec![0.0; frames];
            for w in spans.windows(2) {
                let way = mean(&path[w[1].first..=w[1].last]) - mean(&path[w[0].first..=w[0].last]);
                let (from, to) = (w[0].last, w[1].first);
                for (i, y) in clear.iter_mut().enumerate().take(to).skip(from + 1) {
                    let s = (i - from) as f64 / (to - from) as f64;
                    *y = (CLEAR * way.xz().norm()).min(CLEAR_MOST_M) * (4.0 * s * (1.0 - s)).powi(3);
                }
            }
            clear
        });
        Self {
            clear: clear.collect(),
            rest: rest.collect(),
            centre: (0..frames).map(|i| sources.iter().map(|p| p[i]).sum::<Vec3>() / n).collect(),
            shift: vec![Vec3::zeros(); frames],
            turn: vec![Quat::identity(); frames],
            softness: vec![QUICK_S; frames],
            dofs: if sources.len() > 1 { 6 } else { 3 },
            searching: true,
            sources,
            rate_hz,
        }
    }

    /// The paths, jerked no more than `allowed` near the ends of phases (third difference, m) if they can be.
    pub(super) fn solve(mut self, spans: &[&[PhaseFrames]], allowed: f64) -> Vec<Path> {
        let mut found = self.settle();
        while self.soften(&found, spans, allowed) {
            found = self.settle();
        }
        self.searching = false;
        for ((rest, path), spans) in self.rest.iter_mut().zip(&found).zip(spans) {
            for s in *spans {
                let place = mean(&path[s.first..=s.last]);
                rest[s.first..=s.last].iter_mut().flatten().for_each(|r| r.place = place);
            }
        }
        self.settle()
    }

    /// Raises τ around ends that are jerked more than allowed; whether there are any where it could.
    fn soften(&mut self, points: &[Path], spans: &[&[PhaseFrames]], allowed: f64) -> bool {
        let around = (AROUND_S * self.rate_hz).round() as usize;
        let mut jerked = vec![false; self.softness.len()];
        for (path, spans) in points.iter().zip(spans) {
            let ends = spans.iter().flat_map(|s| [s.first, s.last]);
            for end in ends.filter(|&end| peak_near(path, end, self.rate_hz) > allowed) {
                let to = (end + around).min(jerked.len() - 1);
                jerked[end.saturating_sub(around)..=to].fill(true);
            }
        }
        let mut changed = false;
        for (tau, _) in
            self.softness.iter_mut().zip(&jerked).filter(|(tau, jerked)| **jerked && **tau < SOFT_S)
        {
            *tau = (*tau * SOFTER).min(SOFT_S);
            changed = true;
        }
        changed
    }

    /// Gauss–Newton from where the points are.
    fn settle(&mut self) -> Vec<Path> {
        let (frames, dofs) = (self.shift.len(), self.dofs);
        let mut normal = Band::zeros(frames, dofs, JOINED - 1);
        let mut step = vec![0.0; frames * dofs];
        let mut points = self.points();
        for _ in 0..STEPS {
            normal.fill(0.0);
            step.fill(0.0);
            for i in 0..frames {
                self.frame(i, &points).add_to(i, &mut normal, &mut step);
            }
            if normal.solve(&mut step).is_err() {
                break;
            }
            let largest = |of: &dyn Fn(usize) -> bool| {
                let those = step.iter().enumerate().filter(|(k, _)| of(k % dofs));
                those.fold(0.0f64, |m, (_, x)| m.max(x.abs()))
            };
            let share = (TURN / largest(&|d| d >= 3).max(1e-12)).min(1.0);
            let still = largest(&|_| true) < STILL[usize::from(!self.searching)];
            for (i, x) in step.chunks_exact(dofs).enumerate() {
                self.shift[i] += Vec3::new(x[0], x[1], x[2]) * share;
                if dofs > 3 {
                    let turn = Vec3::new(x[3], x[4], x[5]) * share;
                    self.turn[i] = Quat::from_scaled_axis(turn) * self.turn[i];
                }
            }
            points = self.points();
            if still {
                break;
            }
        }
        points
    }

    /// The points of all frames.
    fn points(&self) -> Vec<Path> {
        let path = |source: &&Path| {
            let at = |i: usize| self.centre[i] + self.shift[i] + self.turn[i] * (source[i] - self.centre[i]);
            (0..self.shift.len()).map(at).collect()
        };
        self.sources.iter().map(path).collect()
    }

    /// Terms of frame `i`, and of those that join it with the next ones.
    fn frame(&self, i: usize, points: &[Path]) -> Terms {
        let frames = self.shift.len();
        let mut terms = Terms::new(self.dofs, JOINED.min(frames - i));
        // all over τ⁶, with the third difference's weight where τ is least
        let quick = QUICK_S * self.rate_hz;
        let still = REST * (self.rate_hz / REST_HZ).powi(4);
        let soft = (QUICK_S / self.softness[i]).powi(6);
        let jerk = quick.powi(6);
        let rate = soft * RATE * (self.softness[i] * self.rate_hz).powi(2);
        (3..self.dofs).for_each(|d| terms.columns[d][d] += IDLE);
        for (c, path) in points.iter().enumerate() {
            let source = self.sources[c];
            let off = |k: usize| path[k] - source[k];
            let arm = |k: usize| path[k] - self.centre[k] - self.shift[k];
            let arms: [Vec3; JOINED] = std::array::from_fn(|a| arm((i + a).min(frames - 1)));
            if self.dofs > 3 {
                let tilt = (source[i] - self.centre[i]).y - arms[0].y;
                terms.tilt(&arms[0], soft, tilt);
            }
            if i + JOINED <= frames {
                let kept = (SOFT_S - self.softness[i]) / (SOFT_S - QUICK_S);
                let moved = |k: usize| path[k] - source[k] * kept;
                let way: Vec3 = THIRD.iter().enumerate().map(|(a, w)| moved(i + a) * *w).sum();
                (0..3).for_each(|axis| terms.row(&THIRD, &arms, axis, jerk, -way[axis]));
            }
            let rest = self.rest[c][i];
            let resting = rest.is_some_and(|r| r.on);
            if i + 1 < frames && (self.searching || !resting) {
                let way = if resting { path[i + 1] - path[i] } else { off(i + 1) - off(i) };
                let weight = if resting { still } else { rate };
                (0..3).for_each(|axis| terms.row(&[-1.0, 1.0], &arms, axis, weight, -way[axis]));
            }
            match rest {
                Some(r) => {
                    let firm = if self.searching { soft } else { still };
                    [0, 2].iter().for_each(|&a| terms.row(&[1.0], &arms, a, firm, r.place[a] - path[i][a]));
                    terms.row(&[1.0], &arms, 1, still, -path[i].y);
                }
                None => {
                    (0..3).for_each(|axis| terms.row(&[1.0], &arms, axis, soft, -off(i)[axis]));
                    let below = self.clear[c][i] - path[i].y;
                    if below > 0.0 {
                        terms.row(&[1.0], &arms, 1, FLOOR, below);
                    }
                }
            }
        }
        terms
    }
}

fn mean(points: &[Vec3]) -> Vec3 {
    points.iter().sum::<Vec3>() / points.len() as f64
}

/// Normal equations of a few frames in a row: lower triangle by columns, and right-hand side.
struct Terms {
    columns: [[f64; 6 * JOINED]; 6 * JOINED],
    right: [f64; 6 * JOINED],
    dofs: usize,
    frames: usize,
}

impl Terms {
    fn new(dofs: usize, frames: usize) -> Self {
        Self { columns: [[0.0; 6 * JOINED]; 6 * JOINED], right: [0.0; 6 * JOINED], dofs, frames }
    }

    /// Adds `weight (Σ_a coefficients_a · x(a) − missing)²` along an axis, of a point with `arms` from its centre.
    ///
    /// A shift du and a turn dr move the point by du + dr × arm, along the axis e by e·du + (arm × e)·dr.
    fn row(&mut self, coefficients: &[f64], arms: &[Vec3], axis: usize, weight: f64, missing: f64) {
        let mut row = [0.0; 6 * JOINED];
        let e = Vec3::ith(axis, 1.0);
        for (a, w) in coefficients.iter().enumerate() {
            let at = &mut row[a * self.dofs..(a + 1) * self.dofs];
            at[axis] = *w;
            if self.dofs > 3 {
                at[3..].copy_from_slice((arms[a].cross(&e) * *w).as_slice());
            }
        }
        self.add(&row[..coefficients.len() * self.dofs], weight, missing);
    }

    /// Adds `weight (height above the centre − missing)²` of a point of the first frame.
    fn tilt(&mut self, arm: &Vec3, weight: f64, missing: f64) {
        let turn = arm.cross(&Vec3::y());
        self.add(&[0.0, 0.0, 0.0, turn.x, turn.y, turn.z], weight, missing);
    }

    fn add(&mut self, row: &[f64], weight: f64, missing: f64) {
        for (j, y) in row.iter().enumerate().filter(|(_, y)| **y != 0.0) {
            let y = weight * y;
            self.right[j] += y * missing;
            self.columns[j][j..row.len()].iter_mut().zip(&row[j..]).for_each(|(n, x)| *n += x * y);
        }
    }

    /// Adds them to those of all frames, these starting at `first`.
    fn add_to(&self, first: usize, normal: &mut Band, right: &mut [f64]) {
        let (d, n) = (self.dofs, self.frames * self.dofs);
        right[first * d..].iter_mut().zip(&self.right[..n]).for_each(|(b, x)| *b += x);
        for (b, columns) in self.columns[..n].chunks_exact(d).enumerate() {
            for a in b..self.frames {
                for (into, column) in normal.block_mut(first + a, first + b).zip(columns) {
                    into.iter_mut().zip(&column[a * d..]).for_each(|(n, x)| *n += x);
                }
            }
        }
    }
}
