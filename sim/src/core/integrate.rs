//! A substep: velocities by backward Euler under springs, gravity, wrenches and contacts, then the pose, then the momentum.
//!
//! In: the state of a [`Core`], the ground of the substep. Out: the state after it. See the module header of [`super`] for the equation.
//!
//! Contacts are solved at the velocities that the momentum correction leaves: where a correction would move a loaded contact by more
//! than [`FELT`], it is put in before the contacts instead, and the substep solved again. Where that does not converge (a hard impact on a
//! light limb, whose joints then turn by a large angle per substep) the substep is taken in two halves, and these again, down to
//! 2^-[`HALVINGS`].
//!
//! Bias and inertia of a substep are those of its start: where a joint turns far within it, or where the body comes out of it with more energy
//! than went in, it is taken in halves too, down to 2^-8 (`sound`). A body that gains energy there as well has diverged.

use motion::rotation::exp;
use motion::{Floor, Vec3};

use super::contact::Ground;
use super::momentum::{Rigid, Whole};
use super::solve::Solved;
use super::{Core, Effort};
use crate::Impulse;
use crate::ledger::LOOSE;

/// Velocity of a loaded contact that a correction may leave, m/s.
const FELT: f64 = 1e-6;
/// Corrections put in before the contacts of one substep.
const REPEATS: usize = 8;
/// A correction that is not smaller than the one before by this factor does not converge.
const CONTRACTION: f64 = 0.25;
/// How often a substep is halved.
const HALVINGS: usize = 5;
/// Change of a velocity in a substep that is half believed to go on, rad/s or m/s.
const SMOOTH: f64 = 0.3;
/// Residual of the contacts at which their solution ends, over m g dt.
const TARGET: f64 = 1e-7;
/// The same of a rough substep.
const ROUGH: f64 = 1e-3;

impl Core {
    /// Advances by `dt` seconds, `begin` seconds after the control step began. `self.state` is of the present pose and velocity, before
    /// and after.
    ///
    /// # Errors
    /// A degree of freedom whose inertia is not positive, which only a diverged state has.
    pub(super) fn advance(&mut self, begin: f64, dt: f64, halvings: usize) -> Result<(), usize> {
        let ground = self.settings.ground.map(|floor| {
            let turn = exp(&(self.ground_rate * begin));
            Ground::new(Floor { up: turn * floor.up, ..floor }, self.ground_rate)
        });
        if self.substep(dt, ground.as_ref(), halvings)? {
            return Ok(());
        }
        self.ledger.halved += 1;
        self.advance(begin, 0.5 * dt, halvings + 1)?;
        self.advance(begin + 0.5 * dt, 0.5 * dt, halvings + 1)
    }

    /// A substep; `false`, with the state as it was, where it should be halved and may be.
    fn substep(&mut self, dt: f64, ground: Option<&Ground>, halvings: usize) -> Result<bool, usize> {
        let may_halve = halvings < HALVINGS;
        let (n, held) = (self.model.nv(), self.held());
        let settles = held == 0 && self.free_root();
        let exact = self.effort == Effort::Exact;
        let start = Whole::of(&self.model, &self.state);
        self.expect(dt);
        self.state.update_velocity(&self.model, &self.expected);
        self.state.bias(&self.model, &self.expected, &mut self.force);
        for f in &mut self.force {
            *f = -*f;
        }
        for w in &self.wrenches {
            self.state.add_wrench(&self.model, w, &mut self.force);
        }
        for i in 0..n {
            let (k, d) = (self.stiffness[i], self.damping[i]);
            self.change[i] = dt * (self.force[i] + k * self.rest[i] - (d + dt * k) * self.v[i]);
        }
        let (stiffness, damping) = (&self.stiffness, &self.damping);
        let of = (&self.model, &mut self.state);
        self.factor.load(&self.tree, of, |i| dt * (damping[i] + dt * stiffness[i]));
        if held > 0 {
            let path = self.path.unwrap_or_else(|| std::array::from_fn(|k| self.v[k]));
            for k in 0..held {
                self.change[k] = path[k] - self.v[k];
            }
            for i in held..n {
                // every chain begins with the root
                let row = self.factor.row(&self.tree, i);
                for k in 0..held {
                    self.change[i] -= row[k] * self.change[k];
                }
            }
        }
        self.factor.factor(&self.tree, held)?;
        // a held part moves as given: it does not enter the rows of L, which leave it out
        let given: [f64; 6] = std::array::from_fn(|k| if held > 0 { self.change[k] } else { 0.0 });
        self.factor.solve_inward(&self.tree, &mut self.change, held);
        self.change[..held].fill(0.0);
        self.factor.solve_outward(&self.tree, &mut self.change, held);
        self.change[..held].copy_from_slice(&given[..held]);
        for ((free, v), change) in self.free.iter_mut().zip(&self.v).zip(&self.change) {
            *free = v + change;
        }
        self.before.copy_from_slice(&self.q);
        self.before_v.copy_from_slice(&self.v);
        self.find_contacts(dt, ground, held);
        let outside = self.outside(dt, &start);
        let mut fed = Impulse::default();
        let mut least = f64::INFINITY;
        for repeat in 0.. {
            self.solve_contacts(dt, held);
            self.q.copy_from_slice(&self.before);
            self.model.skeleton.integrate(&mut self.q, &self.v, dt);
            self.state.update(&self.model, &self.q, &self.v);
            if !settles {
                break;
            }
            let now = Whole::of(&self.model, &self.state);
            let rigid = now.rigid(self.model.mass);
            let missing = self.missing(&start, &outside, &now);
            let (shift, spin) = rigid.motion(&missing.moved(&(now.com - start.com)));
            let slip = self.slip(&now.com, &shift, &spin);
            if slip > FELT && (repeat == REPEATS || slip > CONTRACTION * least) && may_halve && exact {
                self.back();
                return Ok(false);
            }
            if exact && slip > FELT && repeat < REPEATS && slip <= CONTRACTION * least {
                least = slip;
                // put in before the contacts, which answer to it
                fed += missing;
                self.ledger.resolved += u64::from(repeat == 0);
                self.feed(&missing, &start);
                continue;
            }
            self.settle(&now, &shift, &spin);
            if !self.is_sound(dt, &start, held, halvings)? {
                self.back();
                return Ok(false);
            }
            self.ledger.worst_slip = self.ledger.worst_slip.max(slip);
            self.account(&(fed + missing), &start, (&now, &rigid));
            self.finish(dt);
            return Ok(true);
        }
        if !self.is_sound(dt, &start, held, halvings)? {
            self.back();
            return Ok(false);
        }
        self.finish(dt);
        Ok(true)
    }

    /// The velocity that the bias is of: where the last acceleration leads in a substep. With it the momentum that a substep loses to the change of
    /// the inertia is of third order in smooth motion instead of second. What came of an impact does not go on.
    fn expect(&mut self, dt: f64) {
        let most = self.trend.iter().fold(0.0, |m: f64, a| m.max((dt * a).abs()));
        let part = dt / (1.0 + (most / SMOOTH).powi(2));
        for ((e, v), a) in self.expected.iter_mut().zip(&self.v).zip(&self.trend) {
            *e = v + part * a;
        }
    }

    /// Takes pose and velocity back to the start of the substep.
    fn back(&mut self) {
        self.q.copy_from_slice(&self.before);
        self.v.copy_from_slice(&self.before_v);
        self.state.update(&self.model, &self.q, &self.v);
    }

    /// Keeps what a substep leaves for the next one.
    fn finish(&mut self, dt: f64) {
        for (rest, v) in self.rest.iter_mut().zip(&self.v) {
            *rest -= dt * v;
        }
        for ((a, v), before) in self.trend.iter_mut().zip(&self.v).zip(&self.before_v) {
            *a = (v - before) / dt;
        }
        self.finish_contacts(dt);
    }

    fn find_contacts(&mut self, dt: f64, ground: Option<&Ground>, held: usize) {
        self.finder.find(
            &self.shapes,
            &self.state,
            ground,
            (dt, self.yields),
            &mut self.forces,
            (&mut self.contacts, &mut self.slots),
        );
        if self.contacts.is_empty() {
            return;
        }
        let body = (&self.model, &self.tree, &self.state);
        self.response.prepare(body, &self.factor, &self.slots, &self.free, held);
        let n = self.response.bodies();
        self.solver.impulses.clear();
        for c in &mut self.contacts {
            c.weigh(&self.response.g[c.slot * (n + 1)], dt, self.yields);
            self.solver.impulses.push(self.forces[c.point].map(|f| f * dt));
        }
    }

    /// Velocities with contacts, from those without.
    fn solve_contacts(&mut self, dt: f64, held: usize) {
        self.v.copy_from_slice(&self.free);
        self.unsolved = false;
        if self.contacts.is_empty() {
            return;
        }
        let weight = self.weight() * dt;
        let target = weight * if self.effort == Effort::Exact { TARGET } else { ROUGH };
        let mut effort = self.solver.solve(&self.contacts, &self.response, target);
        if effort.residual > LOOSE * weight && self.contacts.iter().any(|c| c.out > 0.0) {
            // points that cannot all be pushed out at once (a body that is wedged, a joint inside the ground) come no deeper
            for (c, impulse) in self.contacts.iter_mut().zip(&mut self.solver.impulses) {
                c.ground[0] -= c.out;
                c.out = 0.0;
                *impulse = self.forces[c.point].map(|f| f * dt);
            }
            self.ledger.wedged += 1;
            let again = self.solver.solve(&self.contacts, &self.response, target);
            effort = Solved {
                sweeps: effort.sweeps + again.sweeps,
                steps: effort.steps + again.steps,
                residual: again.residual,
            };
        }
        self.unsolved = effort.residual.is_nan() || effort.residual > LOOSE * weight;
        self.ledger.solved(effort.sweeps, effort.steps, effort.residual / weight);
        self.response.gather(&self.solver.wrenches, &mut self.change);
        self.factor.solve_outward(&self.tree, &mut self.change, held);
        for (v, change) in self.v.iter_mut().zip(&self.change).skip(held) {
            *v += change;
        }
    }

    /// m g, N; with standard gravity where there is none.
    pub(super) fn weight(&self) -> f64 {
        let g = self.settings.gravity.norm();
        self.model.mass * if g > 0.0 { g } else { 9.81 }
    }

    /// Impulse of gravity and wrenches about the centre of mass at the start of the substep.
    fn outside(&self, dt: f64, start: &Whole) -> Impulse {
        let mut sum = Impulse { linear: self.model.gravity * (self.model.mass * dt), angular: Vec3::zeros() };
        for w in &self.wrenches {
            sum += Impulse { linear: w.force * dt, angular: w.moment_about(&start.com) * dt };
        }
        sum
    }

    /// What the outside impulses make of the momentum at the start, less the momentum now; about the centre of mass at the start.
    fn missing(&self, start: &Whole, outside: &Impulse, now: &Whole) -> Impulse {
        let mut sum = *outside;
        for (c, impulse) in self.contacts.iter().zip(&self.solver.impulses).filter(|(c, _)| !c.inner) {
            let linear = c.world(impulse);
            sum += Impulse { linear, angular: (c.at - start.com).cross(&linear) };
        }
        Impulse {
            linear: start.linear + sum.linear - now.linear,
            angular: start.angular + sum.angular - now.about(&start.com),
        }
    }

    /// Largest velocity of a loaded contact with the world when the body moves as one, m/s.
    fn slip(&self, com: &Vec3, shift: &Vec3, spin: &Vec3) -> f64 {
        let loaded = self.contacts.iter().zip(&self.solver.impulses).filter(|(c, l)| !c.inner && l[0] > 0.0);
        loaded.map(|(c, _)| (shift + spin.cross(&(c.at - com))).norm_squared()).fold(0.0, f64::max).sqrt()
    }

    /// Adds an impulse on the root (about the centre of mass at the start) to the velocities without contacts.
    fn feed(&mut self, impulse: &Impulse, start: &Whole) {
        let b = &self.model.bodies[0];
        // the pose has moved on: the root's place at the start is in `before`
        let zero = b.parent_from_zero;
        let origin = zero.translation.vector + zero.rotation * motion::skeleton::vec_at(&self.before, b.q_at);
        let about = impulse.moved(&(origin - start.com));
        let (linear, angular) =
            (zero.rotation.inverse() * about.linear, zero.rotation.inverse() * about.angular);
        self.change.fill(0.0);
        self.change[..3].copy_from_slice(linear.as_slice());
        self.change[3..6].copy_from_slice(angular.as_slice());
        self.factor.solve_inward(&self.tree, &mut self.change, 0);
        if !self.contacts.is_empty() {
            self.response.add_free(&self.change);
        }
        self.factor.solve_outward(&self.tree, &mut self.change, 0);
        for (free, change) in self.free.iter_mut().zip(&self.change) {
            *free += change;
        }
    }

    /// Moves the whole body as one: the root's velocity changes, no joint's does.
    fn settle(&mut self, now: &Whole, shift: &Vec3, spin: &Vec3) {
        let s = &self.state.bodies[0];
        let linear = s.zero.tr_mul(&(shift + spin.cross(&(s.origin() - now.com))));
        let angular = s.zero.tr_mul(spin);
        for k in 0..3 {
            self.v[k] += linear[k];
            self.v[3 + k] += angular[k];
        }
        self.state.update_velocity(&self.model, &self.v);
    }

    fn account(&mut self, correction: &Impulse, start: &Whole, (now, rigid): (&Whole, &Rigid)) {
        let (shift, spin) = rigid.motion(&Impulse { linear: now.linear, angular: now.angular });
        let l = &mut self.ledger;
        l.root_correction += correction.moved(&-start.com);
        let work = correction.linear.dot(&shift) + correction.angular.dot(&spin);
        l.root_correction_j += work;
        l.correction_j += work;
    }

    /// Keeps the impulses for the next substep and for [`contacts`](crate::Engine::contacts).
    fn finish_contacts(&mut self, dt: f64) {
        self.ledger.substeps += 1;
        for (c, impulse) in self.contacts.iter().zip(&self.solver.impulses) {
            self.forces[c.point] = impulse.map(|x| x / dt);
            let touch = &mut self.touches[c.point];
            if !touch.touched {
                touch.touched = true;
                self.touched.push(c.point);
            }
            touch.impulse += c.world(impulse);
            touch.place += c.at * impulse[0];
            touch.weight += impulse[0];
            touch.depth = c.depth;
            let u = c.velocity(&self.solver.twists[c.slot]);
            self.ledger.friction_j += impulse[1] * u[1] + impulse[2] * u[2];
            self.ledger.push_out_j += impulse[0] * c.out;
        }
    }
}
