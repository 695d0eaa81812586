//! One call of a drag: Newton steps from the last pose, each followed by a step back onto the pins.

use super::system::{COMPLIANCE, System};
use super::{Handle, Hold, MOST_TURN, Posed, Poser, Weld, limits, turn};
use crate::ik::axes::Axis;
use crate::rotation::log;
use crate::{Kinematics, Vec3};

/// Most Newton steps of one call, and most trials of a step.
const MOST_STEPS: usize = 4;
const MOST_TRIES: usize = 8;

/// Most times that a step is solved for again because it ends beyond limits.
const MOST_ROUNDS: usize = 4;

/// Largest entry of one step, rad or m.
const FARTHEST: f64 = 0.15;

/// A body whose step would be smaller than this everywhere, rad or m, rests.
const STILL: f64 = 1e-5;

/// Most steps back onto the constraints after each step, and the miss, m or rad, that needs none.
const MOST_RESTORED: usize = 3;
const NEARLY_MET: f64 = 1e-8;

/// The same at the end of a call, where pins have to hold.
const MOST_POLISHED: usize = 5;
const MET: f64 = 1e-8;

/// Factor on the viscosity after a step that did not lower the merit.
const FIRMER: f64 = 16.0;

/// Stiffness of limits, 1/rad² or 1/m²: joints stay within 1e-8 rad of them under the pull of a drag.
const LIMIT: f64 = 1e8;

impl Poser {
    pub(super) fn solve(&mut self, handles: &[Handle], q: &mut [f64]) -> Posed {
        let s = self.skeleton.clone();
        self.before.copy_from_slice(q);
        self.constrain(handles);
        self.shift(handles);
        self.k.update(&s, q);
        let (mut left, mut moved, mut still, mut steps) = (MOST_TURN, false, false, 0);
        let mut trial = std::mem::take(&mut self.trial);
        let (mut damping, mut tries) = (self.viscosity, 0);
        let mut merit = 0.0;
        let mut fresh = true;
        while steps < MOST_STEPS && tries < MOST_TRIES && left > 0.0 {
            if fresh {
                self.assemble(handles, q);
                merit = self.merit(handles, q);
            }
            tries += 1;
            let mut forces = true;
            let factored = self.system.factor(true, damping) || {
                damping *= FIRMER;
                forces = self.system.factor(true, damping);
                forces || self.system.factor(false, damping)
            };
            if !(factored && self.system.factor_constraints()) {
                break;
            }
            self.multipliers.clone_from(&self.system.multipliers);
            let (mut largest, mut share);
            let mut round = 0;
            loop {
                self.system.newton();
                largest = self.system.step.iter().fold(0.0f64, |m, x| m.max(x.abs()));
                share = (FARTHEST.min(left) / largest).min(1.0);
                trial.copy_from_slice(q);
                s.integrate(&mut trial, &self.system.step, share);
                round += 1;
                let again = round < MOST_ROUNDS && self.hold_back(q, &trial);
                if !(again && self.system.factor(forces, damping) && self.system.factor_constraints()) {
                    break;
                }
                self.system.multipliers.clone_from(&self.multipliers);
            }
            self.k.update(&s, &trial);
            self.restore(handles, &mut trial);
            let lower = self.merit(handles, &trial) <= merit;
            if largest < STILL {
                still = true;
            } else if lower {
                q.copy_from_slice(&trial);
                (steps, moved, fresh) = (steps + 1, true, true);
                left -= share * largest;
                damping = (damping / FIRMER).max(self.viscosity);
                continue;
            }
            // back to the pose before the trial
            self.system.multipliers.clone_from(&self.multipliers);
            self.k.update(&s, q);
            if still {
                break;
            }
            self.assemble(handles, q);
            fresh = false;
            damping *= FIRMER;
        }
        self.trial = trial;
        if moved {
            self.clamp(q);
        }
        moved |= self.polish(handles, q);
        if moved {
            self.kept.fill(false);
            for h in handles.iter().filter(|h| h.at != Vec3::zeros()) {
                self.kept[h.link] = true;
            }
            let seen = turn::Sight { seen: &self.seen, kept: &self.kept, joined: &self.joined };
            turn::least(&s, &seen, &self.before, &self.k, &mut self.turned, q);
            self.k.update(&s, q);
        }
        self.misses.clear();
        self.misses.extend(handles.iter().map(|h| (self.k.point(h.link, &h.at) - h.place).norm()));
        Posed { steps, still }
    }

    /// A constraint for every handle and weld; multipliers are those of the last call, if it had the same handles.
    fn constrain(&mut self, handles: &[Handle]) {
        let same = |(a, b): (&Handle, &Handle)| a.link == b.link && a.at == b.at && a.hold == b.hold;
        if self.last.len() != handles.len() || !self.last.iter().zip(handles).all(same) {
            self.system.multipliers.clear();
        }
        self.last.clear();
        self.last.extend_from_slice(handles);
        let rows = 3 * handles.len();
        self.system.constrain(rows + 6 * self.welds.len());
        self.system.compliance.fill(COMPLIANCE);
        for (h, row) in handles.iter().zip(self.system.compliance.chunks_exact_mut(3)) {
            if let Hold::Dragged(weight) = h.hold {
                row.fill(1.0 / weight);
            }
        }
    }

    /// Moves the goals of anchors with the nearest handle above them.
    fn shift(&mut self, handles: &[Handle]) {
        self.shifts.fill((Vec3::zeros(), 0));
        for h in handles {
            let (sum, count) = &mut self.shifts[h.link];
            *sum += h.place - self.first.point(h.link, &h.at);
            *count += 1;
        }
        for (i, link) in self.skeleton.links().iter().enumerate() {
            let (sum, count) = self.shifts[i];
            self.shifts[i] = match (count, link.parent) {
                (0, Some(p)) => self.shifts[p],
                (0, None) => (Vec3::zeros(), 1),
                _ => (sum / count as f64, 1),
            };
        }
        for a in &mut self.anchors {
            a.to = a.was + self.shifts[a.link].0;
        }
    }

    /// The equations at `q`, which `k` is of.
    fn assemble(&mut self, handles: &[Handle], q: &[f64]) {
        let s = &self.skeleton;
        self.axes.update(s, &self.k);
        let system = &mut self.system;
        system.clear(self.k.origin(0));
        for a in &self.anchors {
            let x = self.k.point(a.link, &a.at);
            system.add(a.link, &x, a.weight, &((x - a.to) * a.weight));
        }
        misses(&self.k, &self.welds, handles, &mut system.missed);
        let mut row = 0;
        for h in handles {
            let x = self.k.point(h.link, &h.at);
            let m = &system.multipliers[row..row + 3];
            let pull = Vec3::new(m[0], m[1], m[2]);
            system.add(h.link, &x, 0.0, &pull);
            for r in 0..3 {
                system.clear_row(row + r);
            }
            for &d in &self.axes.chain[h.link] {
                system.column(row, d, &self.axes.all[d].column(&x), 1.0);
            }
            row += 3;
        }
        system.gather(&self.axes.all);
        for w in &self.welds {
            let x = self.k.origin(w.second);
            for r in 0..6 {
                system.clear_row(row + r);
            }
            for (link, sign) in [(w.second, 1.0), (w.first, -1.0)] {
                for &d in &self.axes.chain[link] {
                    let axis: &Axis = &self.axes.all[d];
                    system.column(row, d, &axis.column(&x), sign);
                    system.column(row + 3, d, &axis.angular, sign);
                }
            }
            system.pull(row, 6);
            row += 6;
        }
        for (i, ranges) in self.ranges.iter().enumerate() {
            let Some(ranges) = ranges else { continue };
            let excess = limits::excess(s, q, i, ranges);
            for c in (0..3).filter(|&c| limits::is_beyond(excess[c])) {
                let out = limits::slope(s, q, i, c) * excess[c].signum();
                limit(system, s.v_at(i), s.links()[i].joint.nv(), &out, excess[c].abs());
            }
        }
    }

    /// E, with what constraints and limits are missed by, at more than the price of their multipliers.
    fn merit(&mut self, handles: &[Handle], q: &[f64]) -> f64 {
        let square = |a: &super::Anchor| a.weight * (self.k.point(a.link, &a.at) - a.to).norm_squared();
        let anchors: f64 = self.anchors.iter().map(square).sum();
        misses(&self.k, &self.welds, handles, &mut self.system.missed);
        let system = &self.system;
        let hard = |i: &usize| system.compliance[*i] == COMPLIANCE;
        let all = 0..system.missed.len();
        let soft: f64 =
            all.clone().filter(|i| !hard(i)).map(|i| system.missed[i].powi(2) / system.compliance[i]).sum();
        let missed: f64 = all.clone().filter(hard).map(|i| system.missed[i].abs()).sum();
        let price = all.filter(hard).fold(1.0f64, |m, i| m.max(system.multipliers[i].abs()));
        let ranges = self.ranges.iter().enumerate();
        let out: f64 = ranges
            .filter_map(|(i, r)| Some(limits::excess(&self.skeleton, q, i, r.as_ref()?)))
            .map(|e| e.iter().map(|x| x.abs()).sum::<f64>())
            .sum();
        0.5 * (anchors + soft) + 2.0 * price * missed + 2.0 * out
    }

    /// Steps back onto the constraints by the equations of the last step.
    fn restore(&mut self, handles: &[Handle], q: &mut [f64]) {
        for _ in 0..MOST_RESTORED {
            misses(&self.k, &self.welds, handles, &mut self.system.missed);
            if self.system.unmet(f64::INFINITY) < NEARLY_MET {
                return;
            }
            self.system.restore();
            let largest = self.system.step.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            // far from a place that cannot be reached the equations of the step before say little
            self.skeleton.integrate(q, &self.system.step, (FARTHEST / largest).min(1.0));
            self.k.update(&self.skeleton, q);
            if largest > FARTHEST {
                return;
            }
        }
    }

    /// Makes joints that a step would take beyond their limits end at them; returns whether there are any that did not already.
    ///
    /// * `trial`: where the step ends
    fn hold_back(&mut self, q: &[f64], trial: &[f64]) -> bool {
        let s = &self.skeleton;
        let mut any = false;
        for (i, ranges) in self.ranges.iter().enumerate() {
            let Some(ranges) = ranges else { continue };
            let (before, after) = (limits::excess(s, q, i, ranges), limits::excess(s, trial, i, ranges));
            for c in 0..3 {
                if limits::is_beyond(before[c]) || after[c].abs() <= limits::AT_LIMIT {
                    continue;
                }
                let (at, count, sign) = (s.v_at(i), s.links()[i].joint.nv(), after[c].signum());
                let bound = if sign > 0.0 { ranges[c].hi } else { ranges[c].lo };
                // as if it were beyond by what makes the step end at the limit
                let by = sign * (limits::coordinate(s, q, i, c) - bound);
                limit(&mut self.system, at, count, &(limits::slope(s, q, i, c) * sign), by);
                any = true;
            }
        }
        any
    }

    /// Takes what unfinished steps left beyond the limits back.
    fn clamp(&mut self, q: &mut [f64]) {
        let mut moved = false;
        for (i, ranges) in self.ranges.iter().enumerate() {
            let free = !self.system.locked.get(self.skeleton.v_at(i)).copied().unwrap_or(true);
            if let Some(ranges) = ranges.as_ref().filter(|_| free) {
                moved |= limits::clamp(&self.skeleton, q, i, ranges);
            }
        }
        if moved {
            self.k.update(&self.skeleton, q);
        }
    }

    /// Steps onto the pins by equations of their own, as long as that halves what they miss; returns whether `q` moved.
    fn polish(&mut self, handles: &[Handle], q: &mut [f64]) -> bool {
        let hard = 2.0 * COMPLIANCE;
        let (mut moved, mut trial) = (false, std::mem::take(&mut self.trial));
        misses(&self.k, &self.welds, handles, &mut self.system.missed);
        for _ in 0..MOST_POLISHED {
            let unmet = self.system.unmet(hard);
            if unmet < MET {
                break;
            }
            self.assemble(handles, q);
            if !(self.system.factor(false, self.viscosity) && self.system.factor_constraints()) {
                break;
            }
            self.system.restore();
            trial.copy_from_slice(q);
            self.skeleton.integrate(&mut trial, &self.system.step, 1.0);
            self.k.update(&self.skeleton, &trial);
            misses(&self.k, &self.welds, handles, &mut self.system.missed);
            if self.system.unmet(hard) > 0.5 * unmet {
                self.k.update(&self.skeleton, q);
                break;
            }
            q.copy_from_slice(&trial);
            moved = true;
        }
        self.trial = trial;
        moved
    }
}

/// What constraints are missed by, m and rad.
fn misses(k: &Kinematics, welds: &[Weld], handles: &[Handle], out: &mut [f64]) {
    let mut rows = out.chunks_exact_mut(3);
    let mut put = |x: Vec3| {
        if let Some(row) = rows.next() {
            row.copy_from_slice(x.as_slice());
        }
    };
    for h in handles {
        put(k.point(h.link, &h.at) - h.place);
    }
    for w in welds {
        let wanted = k.world[w.first] * w.first_from_second;
        put(k.origin(w.second) - wanted.translation.vector);
        put(log(&(k.world[w.second].rotation * wanted.rotation.inverse())));
    }
}

/// Adds a joint that is beyond its limit by `by` in the direction `out`.
fn limit(system: &mut System, at: usize, count: usize, out: &Vec3, by: f64) {
    for a in 0..count {
        if system.locked[at + a] {
            continue;
        }
        system.gradient[at + a] += LIMIT * by * out[a];
        for b in a..count {
            system.stiffen(at + a, at + b, LIMIT * out[a] * out[b]);
        }
    }
}
