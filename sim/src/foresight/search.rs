//! Search: a tree of rollouts, window by window, of which the better ones go on.
//!
//! In: a state, the plan of the last search, what is known beforehand. Out: knots of offsets for the windows to come.
//!
//! From every state kept, samples of the next knot are drawn about the last plan and run in the core to the end of the window. Half of
//! those that go on are the best, half are spread over the better part, so that what costs now and pays later is not lost (Liu et al.,
//! Sampling-based contact-rich motion control, SIGGRAPH 2010). Of the leaves, the best, the mean weighted by exp(−cost) (Williams et al.,
//! Information theoretic MPC, ICRA 2017), and the last plan are run once more as they would be performed; the cheapest is the plan.

use rayon::prelude::*;

use super::Settings;
use super::ahead::Rows;
use super::beside::Beside;
use super::channels::{Channel, shift};
use super::cost::{Cost, Gathered};
use super::random::Stream;
use super::spline::{Knot, between};
use crate::core::{Core, Snapshot};
use crate::{ContactForce, Engine};
use controllers::Drive;

/// Cost of a rollout that diverged.
const LOST: f64 = 1e9;
/// Part of the samples of a window, the better ones, over which half of what goes on is spread.
const SPREAD: f64 = 0.4;
/// How a window's end counts against the mean so far, when it is decided what goes on.
const NOW: f64 = 0.8;
/// How often the last window counts.
const END: f64 = 4.0;
/// The middle of a window counts as much as its end times this.
const MIDDLE: f64 = 0.5;
/// Deviations of samples take turns at these multiples.
const WIDTHS: [f64; 4] = [1.6, 1.0, 0.6, 0.3];

/// What a search runs in. Everything is allocated once.
pub(super) struct Search {
    core: Core,
    samples: Vec<Sample>,
    beam: Vec<Node>,
    /// Per window: knots of what went on, and from which of the window before.
    kept: Vec<Vec<(Knot, usize)>>,
    order: Vec<usize>,
}

struct Sample {
    state: Snapshot,
    knot: Knot,
    parent: usize,
    total: f64,
    cost: f64,
}

struct Node {
    state: Snapshot,
    knot: Knot,
    total: f64,
    cost: f64,
}

/// What a search looks at.
pub(super) struct Question<'a> {
    pub(super) settings: &'a Settings,
    pub(super) channels: &'a [Channel],
    pub(super) cost: &'a Cost,
    pub(super) rows: &'a Rows,
    /// The last row that is over.
    pub(super) row: usize,
    /// Rows per window.
    pub(super) window: usize,
    /// Number of the window: part of the seeds.
    pub(super) number: u64,
    /// Factor on the deviations of all channels.
    pub(super) width: f64,
    /// What acts beside the plan.
    pub(super) beside: &'a Beside,
    /// Offsets now.
    pub(super) from: &'a Knot,
    /// What the last search would do from now on, one knot per window.
    pub(super) last: &'a [Knot],
}

/// What a worker needs beside a core.
#[derive(Default)]
struct Scratch {
    drives: Vec<Drive>,
    offsets: Vec<f64>,
    contacts: Vec<ContactForce>,
}

impl Question<'_> {
    /// First and last row of a window; empty past the end of the motion.
    fn span(&self, window: usize) -> (usize, usize) {
        let end = self.rows.count() - 1;
        let at = |w: usize| (self.row + w * self.window).min(end);
        (at(window), at(window + 1))
    }

    /// Runs a window in a core that is in its first state; its cost.
    fn run(&self, core: &mut Core, s: &mut Scratch, window: usize, from: &Knot, to: &Knot) -> f64 {
        let (first, last) = self.span(window);
        let stride = self.settings.stride.max(1);
        let mut gathered = Gathered::default();
        let mut middle = 0.0;
        let mut row = first;
        s.offsets.resize(self.channels.len(), 0.0);
        while row < last {
            let next = (row + stride).min(last);
            let phase = (next - first) as f64 / self.window as f64;
            between(from, to, phase, &mut s.offsets);
            s.drives.clear();
            s.drives.extend_from_slice(self.rows.drives(next));
            self.beside.shift(&mut s.drives);
            shift(self.channels, &s.offsets, &mut s.drives);
            core.set_drives(&s.drives);
            self.beside.push(core, row, stride);
            if core.step().is_err() {
                return LOST;
            }
            self.cost.gather(core, self.rows.crest(next), &mut s.contacts, &mut gathered);
            if row < (first + last) / 2 && next >= (first + last) / 2 {
                middle = self.cost.of(core, self.rows, next);
            }
            row = next;
        }
        let cost = self.cost.of(core, self.rows, last)
            + MIDDLE * middle
            + self.cost.of_way(&gathered, self.channels, from, to);
        if cost.is_finite() { cost.min(LOST) } else { LOST }
    }
}

impl Search {
    pub(super) fn new(core: Core, settings: &Settings, channels: usize) -> Self {
        let state = core.snapshot();
        let sample =
            || Sample { state: state.clone(), knot: Knot::zero(channels), parent: 0, total: 0.0, cost: 0.0 };
        let node = || Node { state: state.clone(), knot: Knot::zero(channels), total: 0.0, cost: 0.0 };
        Self {
            samples: (0..settings.rollouts).map(|_| sample()).collect(),
            beam: (0..settings.kept()).map(|_| node()).collect(),
            kept: Vec::new(),
            order: Vec::new(),
            core,
        }
    }

    /// The core that rollouts are copies of.
    pub(super) fn core(&mut self) -> &mut Core {
        &mut self.core
    }

    /// Knots for the windows to come, and their cost. `self.core` is in the present state.
    pub(super) fn plan(&mut self, question: &Question<'_>) -> (Vec<Knot>, f64) {
        let windows = (0..question.settings.windows()).take_while(|&w| {
            let (first, last) = question.span(w);
            first < last
        });
        let windows = windows.count();
        let start = self.core.snapshot();
        let mut width = 1;
        self.beam[0].state.clone_from(&start);
        self.beam[0].knot.clone_from(question.from);
        (self.beam[0].total, self.beam[0].cost) = (0.0, 0.0);
        self.kept.clear();
        for w in 0..windows {
            self.draw(question, w, width);
            width = self.choose(w);
        }
        if windows == 0 {
            return (Vec::new(), 0.0);
        }
        let leaves: Vec<f64> = self.beam[..width].iter().map(|n| n.total + (END - 1.0) * n.cost).collect();
        let mut candidates = vec![self.path(best(&leaves))];
        candidates.push(self.mean(&leaves, question.from));
        let mut last: Vec<Knot> = question.last.iter().take(windows).cloned().collect();
        if last.len() == windows {
            reach(question.from, &mut last);
            candidates.push(last);
        }
        let core = &self.core;
        let costs: Vec<f64> = candidates
            .par_iter()
            .map(|knots| {
                let (mut core, mut scratch) = (core.clone(), Scratch::default());
                core.restore(&start);
                let (mut total, mut end, mut from) = (0.0, 0.0, question.from);
                for (w, to) in knots.iter().enumerate() {
                    end = question.run(&mut core, &mut scratch, w, from, to);
                    total += end;
                    if end >= LOST {
                        return LOST * windows as f64;
                    }
                    from = to;
                }
                total + (END - 1.0) * end
            })
            .collect();
        let chosen = best(&costs);
        (candidates.swap_remove(chosen), costs[chosen] / (windows as f64 + END - 1.0))
    }

    /// Draws and runs the samples of a window from the first `width` states of the beam.
    fn draw(&mut self, question: &Question<'_>, w: usize, width: usize) {
        let (core, beam) = (&self.core, &self.beam[..width]);
        let seed = question.settings.seed;
        let number = question.number * question.settings.windows() as u64 + w as u64;
        let mean = question.last.get(w);
        self.samples.par_iter_mut().enumerate().for_each_init(
            || (core.clone(), Scratch::default()),
            |(core, scratch), (i, sample)| {
                let mut stream = Stream::new(seed, number, i as u64);
                sample.parent = i % width;
                let from = &beam[sample.parent];
                // the last plan itself goes on from every state
                let wide = if i < width { 0.0 } else { WIDTHS[(i / width) % WIDTHS.len()] };
                for (k, c) in question.channels.iter().enumerate() {
                    let mean = mean.map_or(0.0, |m| m.at[k]);
                    sample.knot.at[k] = mean + stream.normal() * c.deviation * wide * question.width;
                }
                sample.knot.reach(&from.knot);
                core.restore(&from.state);
                sample.cost = question.run(core, scratch, w, &from.knot, &sample.knot);
                sample.total = from.total + sample.cost;
                core.save(&mut sample.state);
            },
        );
    }

    /// Which samples of window `w` go on; how many.
    fn choose(&mut self, w: usize) -> usize {
        let samples = &mut self.samples;
        let key = |s: &Sample| NOW * s.cost + (1.0 - NOW) * s.total / (w + 1) as f64;
        self.order.clear();
        self.order.extend(0..samples.len());
        self.order.sort_by(|&a, &b| key(&samples[a]).total_cmp(&key(&samples[b])).then(a.cmp(&b)));
        let keep = self.beam.len().min(samples.len());
        let best = keep.div_ceil(2);
        let better = ((samples.len() as f64 * SPREAD) as usize).max(keep);
        let mut kept = Vec::with_capacity(keep);
        for k in 0..keep {
            let place = if k < best { k } else { best + (k - best) * (better - best) / (keep - best) };
            let sample = &mut samples[self.order[place]];
            let node = &mut self.beam[k];
            std::mem::swap(&mut node.state, &mut sample.state);
            node.knot.clone_from(&sample.knot);
            (node.total, node.cost) = (sample.total, sample.cost);
            kept.push((sample.knot.clone(), sample.parent));
        }
        self.kept.push(kept);
        keep
    }

    /// The knots that lead to a leaf.
    fn path(&self, leaf: usize) -> Vec<Knot> {
        let mut at = leaf;
        let mut path = Vec::with_capacity(self.kept.len());
        for kept in self.kept.iter().rev() {
            let (knot, parent) = &kept[at];
            path.push(knot.clone());
            at = *parent;
        }
        path.reverse();
        path
    }

    /// The mean of the ways to the leaves, weighted by exp(−cost): a leaf dearer by the distance from the best to the quartile has 1/e.
    fn mean(&self, costs: &[f64], from: &Knot) -> Vec<Knot> {
        let mut sorted = costs.to_vec();
        sorted.sort_by(f64::total_cmp);
        let scale = (sorted[sorted.len() / 4] - sorted[0]).max(1e-9);
        let mut mean = vec![Knot::zero(from.at.len()); self.kept.len()];
        let mut sum = 0.0;
        for (leaf, cost) in costs.iter().enumerate() {
            let weight = libm::exp(-(cost - sorted[0]) / scale);
            sum += weight;
            for (mean, knot) in mean.iter_mut().zip(self.path(leaf)) {
                for (mean, at) in mean.at.iter_mut().zip(&knot.at) {
                    *mean += weight * at;
                }
            }
        }
        for x in mean.iter_mut().flat_map(|m| &mut m.at) {
            *x /= sum;
        }
        reach(from, &mut mean);
        mean
    }
}

/// Slopes of knots that follow one another.
fn reach(from: &Knot, knots: &mut [Knot]) {
    let mut before = from;
    for knot in knots {
        knot.reach(before);
        before = knot;
    }
}

/// Index of the least; the first of several.
fn best(costs: &[f64]) -> usize {
    (0..costs.len()).min_by(|&a, &b| costs[a].total_cmp(&costs[b])).unwrap_or(0)
}
