//! The sum that contacts and blend make together, its derivatives and its minimum.
//!
//! In: contacts as frames with goals, the chain that moves them, the form of the blend. Out: the correction that is least in
//! E of [the module above](super), whose symbols are used here.

use std::ops::Range;

use motion::ik::Axis;
use motion::rotation::{Vec3, log, log_moment};
use motion::{Clip, Kinematics, Skeleton, smoothstep};

use super::{Blended, FAR_M, LEVER_M, MOST_STEPS, SLOW_HZ, STIFFNESS, Standing};
use crate::by_example::block_band::BlockBand;
use crate::by_example::contact_chain::Chain;
use crate::by_example::solve::{Band, Form};

/// A step that promises to lower E by less than this share is the last.
const ENOUGH: f64 = 1e-3;
/// Most shares of a step that are tried.
const MOST_TRIALS: usize = 6;
/// Shares that differ by less than this are the same.
const NEAR: f64 = 0.1;
/// A leg that is so straight, distance over length, reaches a place less and less, and not at all.
const STRAIGHT: (f64, f64) = (0.95, 0.99);
/// Added to the diagonal, as a share of the weight of contacts: a path that nothing holds stays where it is.
const RIDGE: f64 = 1e-12;
/// A point that is where it should be to this is not moved, m.
const THERE_M: f64 = 1e-10;

/// E, its derivatives and its minimum. Corrections are flat: rows of the edited frames, `chain.width` each.
pub(super) struct Problem<'a> {
    pub(super) chain: Chain<'a>,
    pub(super) frames: Range<usize>,
    pub(super) standing: Vec<Standing>,
    /// For each contact the numbers that move it.
    moving: Vec<Vec<usize>>,
    /// For each edited frame the contacts with a weight in it.
    active: Vec<Vec<usize>>,
    /// A of joints, of the root's lean and height, and A_p, of the edited frames.
    bands: [Band; 3],
    /// Which of them a number has.
    band_of: Vec<usize>,
    /// w/ℓ².
    weight: f64,
    q: Vec<f64>,
    k: Kinematics,
}

impl<'a> Problem<'a> {
    pub(super) fn new(
        source: &'a Clip,
        blended: &Blended<'a>,
        form: &Form,
        frames: Range<usize>,
        standing: Vec<Standing>,
    ) -> Self {
        let s = &source.skeleton;
        let ends: Vec<usize> = standing.iter().map(|s| s.link).collect();
        let Blended { rig, clip, differences, allowed } = *blended;
        let chain = Chain::new(rig, source, clip, differences, allowed, &ends);
        let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len().max(1) as f64;
        let slow = (std::f64::consts::TAU * SLOW_HZ).powi(4);
        let w = STIFFNESS * (mean(&form.configuration) + slow * mean(&form.acceleration));
        let cut = |band: Band| Band {
            main: band.main[frames.clone()].to_vec(),
            first: band.first[frames.clone()].to_vec(),
            second: band.second[frames.clone()].to_vec(),
        };
        let ridge = RIDGE * w;
        let firm = firm(&chain, clip, form, &standing, &frames);
        let mut bands = [cut(form.band()), cut(firm.band()), cut(path(&firm))];
        bands[2].main.iter_mut().for_each(|x| *x += ridge);
        let mut active = vec![Vec::new(); frames.len()];
        for (i, one) in standing.iter().enumerate() {
            for f in one.frames().filter(|f| frames.contains(f) && one.weights[f - one.first] > 0.0) {
                active[f - frames.start].push(i);
            }
        }
        Self {
            moving: ends.iter().map(|&l| chain.moving(l)).collect(),
            band_of: chain.owners().iter().map(|o| *o as usize).collect(),
            chain,
            frames,
            active,
            standing,
            bands,
            weight: w / (rig.size_m * rig.size_m),
            q: vec![0.0; s.nq()],
            k: Kinematics::new(s, &s.zero_pose()),
        }
    }

    pub(super) fn row<'b>(&self, c: &'b [f64], row: usize) -> &'b [f64] {
        &c[row * self.chain.width..][..self.chain.width]
    }

    /// A C.
    fn times(&self, c: &[f64], out: &mut [f64]) {
        let n = self.chain.width;
        for row in 0..self.frames.len() {
            for i in 0..n {
                let band = &self.bands[self.band_of[i]];
                out[row * n + i] = band.times(row, |f| c[f * n + i]);
            }
        }
    }

    /// Transforms of an edited frame with its correction.
    fn pose(&mut self, row: usize, c: &[f64]) {
        let n = self.chain.width;
        self.chain.pose(self.frames.start + row, &c[row * n..][..n], &mut self.q);
        self.chain.update(&self.q, &mut self.k);
    }

    /// Where a contact is and how it is turned against its goal: m, rad.
    fn residual(&self, i: usize, f: usize) -> (Vec3, Vec3) {
        let one = &self.standing[i];
        let (goal, turned) = one.goal(f);
        let turn = self.k.world[one.link].rotation * turned.inverse();
        (self.k.point(one.link, &one.at) - goal, if one.turns { log(&turn) } else { Vec3::zeros() })
    }

    /// E.
    pub(super) fn cost(&mut self, c: &[f64]) -> f64 {
        let mut ac = vec![0.0; c.len()];
        self.times(c, &mut ac);
        let mut sum: f64 = c.iter().zip(&ac).map(|(c, a)| c * a).sum();
        for row in 0..self.frames.len() {
            if self.active[row].is_empty() {
                continue;
            }
            self.pose(row, c);
            let f = self.frames.start + row;
            for &i in &self.active[row] {
                let (x, turn) = self.residual(i, f);
                let w = self.weight * self.standing[i].weights[f - self.standing[i].first];
                sum += w * (x.norm_squared() + LEVER_M * LEVER_M * turn.norm_squared());
            }
        }
        0.5 * sum
    }

    /// The gradient of E, and its Gauss–Newton matrix into `matrix`.
    pub(super) fn derivatives(&mut self, c: &[f64], matrix: &mut BlockBand, gradient: &mut [f64]) {
        let n = self.chain.width;
        matrix.clear();
        self.times(c, gradient);
        let mut axes = vec![Axis::default(); n];
        let mut columns: Vec<[f64; 6]> = vec![[0.0; 6]; n];
        for row in 0..self.frames.len() {
            for i in 0..n {
                let band = &self.bands[self.band_of[i]];
                matrix.add(row, i, [band.main[row], band.first[row], band.second[row]]);
            }
            if self.active[row].is_empty() {
                continue;
            }
            let f = self.frames.start + row;
            self.pose(row, c);
            self.chain.axes(f, &c[row * n..][..n], &self.k, &mut axes);
            let block = matrix.block_mut(row);
            for &i in &self.active[row] {
                let one = &self.standing[i];
                let (x, turn) = self.residual(i, f);
                let w = self.weight * one.weights[f - one.first];
                let r = [x.x, x.y, x.z, LEVER_M * turn.x, LEVER_M * turn.y, LEVER_M * turn.z];
                let rows = if one.turns { 6 } else { 3 };
                let at = self.k.point(one.link, &one.at);
                let moving = &self.moving[i];
                for (column, &u) in columns.iter_mut().zip(moving) {
                    let way = axes[u].column(&at);
                    column[..3].copy_from_slice(way.as_slice());
                    if one.turns {
                        // of the logarithm: the inverse of the left Jacobian
                        let turning = log_moment(&-turn, &axes[u].angular) * LEVER_M;
                        column[3..].copy_from_slice(turning.as_slice());
                    }
                }
                for (a, &u) in moving.iter().enumerate() {
                    let dot = |other: &[f64; 6]| -> f64 {
                        columns[a][..rows].iter().zip(other).map(|(x, y)| x * y).sum()
                    };
                    gradient[row * n + u] += w * dot(&r);
                    for (column, &v) in columns.iter().zip(moving).take(a + 1) {
                        let more = w * dot(column);
                        block[u * n + v] += more;
                        if u != v {
                            block[v * n + u] += more;
                        }
                    }
                }
            }
        }
    }

    /// Moves the places that are not reached to where E is least; returns whether any was.
    fn replace(&mut self, c: &[f64]) -> bool {
        let mut sums = vec![(Vec3::zeros(), 0.0, 0.0); self.standing.len()];
        for row in 0..self.frames.len() {
            if self.active[row].is_empty() {
                continue;
            }
            self.pose(row, c);
            let f = self.frames.start + row;
            for &i in &self.active[row] {
                let w = self.standing[i].weights[f - self.standing[i].first];
                let (x, _) = self.residual(i, f);
                sums[i].0 += x * w;
                sums[i].1 += x.norm_squared() * w;
                sums[i].2 += w;
            }
        }
        let mut moved = false;
        for (one, (sum, square, weight)) in self.standing.iter_mut().zip(sums) {
            if !one.fixed && square > FAR_M * FAR_M * weight {
                one.way += Vec3::new(sum.x, 0.0, sum.z) / weight;
                moved = true;
            }
        }
        moved
    }

    /// Goes from `c` along −`step` into `trial`; returns by which share of it, and E there, which is not below `cost` if no share lowers it.
    /// The slope is −2 `promise`. From E at a share that was tried a parabola says where E is least: Gauss–Newton leaves out how a
    /// stretched leg stiffens, and goes too far.
    fn along(
        &mut self,
        c: &[f64],
        step: &[f64],
        trial: &mut Vec<f64>,
        cost: f64,
        promise: f64,
    ) -> (f64, f64) {
        let go = |share: f64, out: &mut [f64]| {
            out.iter_mut().zip(c).zip(step).for_each(|((t, c), s)| *t = c - share * s);
        };
        let mut best = (0.0, cost);
        let mut share = 1.0;
        let mut other = vec![0.0; c.len()];
        for _ in 0..MOST_TRIALS {
            go(share, &mut other);
            let found = self.cost(&other);
            let lowers = found < best.1;
            if lowers {
                best = (share, found);
                std::mem::swap(trial, &mut other);
            }
            let bend = found - cost + 2.0 * promise * share;
            let least = if bend > 0.0 { promise * share * share / bend } else { 2.0 * share };
            let near = (least / share - 1.0).abs() < NEAR;
            if best.0 > 0.0 && (!lowers || near) {
                break;
            }
            share = least.clamp(0.1 * share, 2.0 * share);
        }
        best
    }

    /// Minimises E from `c`; returns the number of steps, and whether the last was small.
    pub(super) fn minimise(&mut self, c: &mut Vec<f64>) -> (usize, bool) {
        let mut matrix = BlockBand::zeros(self.chain.width, self.frames.len());
        let mut step = vec![0.0; c.len()];
        let mut trial = c.clone();
        let mut cost = self.cost(c);
        let held: f64 = self.active.iter().map(|a| a.len() as f64).sum();
        if cost <= 0.5 * self.weight * held * THERE_M * THERE_M {
            return (0, true);
        }
        for steps in 0..MOST_STEPS {
            self.derivatives(c, &mut matrix, &mut step);
            let gradient = step.clone();
            if matrix.factor().is_err() {
                return (steps, false);
            }
            matrix.solve(&mut step);
            let promise = 0.5 * step.iter().zip(&gradient).map(|(s, g)| s * g).sum::<f64>();
            let (_, lower) = self.along(c, &step, &mut trial, cost, promise);
            if lower < cost {
                std::mem::swap(c, &mut trial);
            }
            let small = promise <= ENOUGH * cost;
            if small || lower >= cost {
                return (steps + 1, small);
            }
            cost = if self.replace(c) { self.cost(c) } else { lower };
        }
        (MOST_STEPS, false)
    }
}

/// The form of the root's numbers: [`Form::root`] times the blend's in frames in which the legs reach the places of their contacts from
/// where the blend has the root; where they do not, the blend's own, so that the root gives way.
fn firm(
    chain: &Chain<'_>,
    blended: &Clip,
    form: &Form,
    standing: &[Standing],
    frames: &Range<usize>,
) -> Form {
    let mut share = vec![0.0_f64; form.configuration.len()];
    if form.root != 1.0 {
        let s = &blended.skeleton;
        let mut k = Kinematics::new(s, &s.zero_pose());
        let legs: Vec<(usize, f64)> = standing.iter().map(|one| reach(s, one)).collect();
        for f in frames.clone() {
            let standing = standing.iter().zip(&legs).filter(|(one, _)| one.inside.contains(&f));
            for (i, (one, (hip, length))) in standing.enumerate() {
                if i == 0 {
                    chain.update(blended.pose(f), &mut k);
                }
                let far = (one.goal(f).0 - k.origin(*hip)).norm() / length;
                share[f] = share[f].max(smoothstep((far - STRAIGHT.0) / (STRAIGHT.1 - STRAIGHT.0)));
            }
        }
    }
    let firmer = |of: &[f64]| of.iter().zip(&share).map(|(w, s)| w * form.root.powf(1.0 - s)).collect();
    Form {
        configuration: firmer(&form.configuration),
        acceleration: firmer(&form.acceleration),
        ..form.clone()
    }
}

/// The first link below the root on the way to a contact, and the length of the way from its origin to the point, m.
fn reach(s: &Skeleton, one: &Standing) -> (usize, f64) {
    let mut length = one.at.norm();
    let mut link = one.link;
    while let Some(parent) = s.links()[link].parent.filter(|&p| p != 0) {
        length += s.links()[link].parent_from_zero.translation.vector.norm();
        link = parent;
    }
    (link, length.max(f64::MIN_POSITIVE))
}

/// A_p: what the path's numbers cost. See the module header.
fn path(form: &Form) -> Band {
    let frames = form.configuration.len();
    let mut band = Band::zeros(frames);
    let h2 = form.step_s * form.step_s;
    for f in 1..frames {
        let w = form.configuration[f - 1] / h2;
        band.main[f - 1] += w;
        band.main[f] += w;
        band.first[f - 1] -= w;
    }
    form.bend(&mut band);
    band
}
