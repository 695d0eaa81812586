//! Soundness: whether a substep may stand as it was taken.
//!
//! In: a core before and after a substep. Out: yes, or a wish for smaller ones, or that the body has diverged.
//!
//! Bias and inertia are taken from the start of a substep. That is good to second order in the angles that joints turn by; where a light limb
//! turns fast on a heavy one it makes energy. So no joint may turn by more than [`TURN`] in a substep, and where one turns by more than
//! [`LOOK`], or where contacts are not solved, kinetic energy may grow by what gravity, springs, wrenches and the ground gave, and by
//! a part [`GAIN`] of itself. Substeps are halved until that holds, at most [`FINEST`] times; a control step that gains more than
//! [`MOST`] then ends the run.

use super::Core;
use super::momentum::Whole;

/// How often a substep is halved for its energy.
pub(super) const FINEST: usize = 8;
/// A slide this far counts as a turn by one, m: the size of a small link.
pub(super) const SLIDE: f64 = 0.1;
/// Angle by which no joint should turn in a substep, rad.
const TURN: f64 = 0.3;
/// Angle from which on the energy of a substep is looked at, rad.
const LOOK: f64 = 0.02;
/// Part of the kinetic energy that a substep may gain, and its halves together.
const GAIN: f64 = 1e-4;
/// Part of it that a control step may gain.
const MOST: f64 = 1e-2;

impl Core {
    /// Whether a substep may stand; `false` asks for halves. See the module header.
    ///
    /// # Errors
    /// A degree of freedom of a body that has diverged: the fastest.
    pub(super) fn is_sound(
        &mut self,
        dt: f64,
        start: &Whole,
        held: usize,
        halvings: usize,
    ) -> Result<bool, usize> {
        let may_halve = halvings < FINEST;
        let (mut fastest, mut turn) = (0, 0.0);
        for &(dof, per_angle) in &self.turning {
            let angle = self.v[dof].abs() * dt * per_angle;
            if angle > turn || angle.is_nan() {
                (fastest, turn) = (dof, angle);
            }
        }
        let bad = |turn: f64| !turn.is_finite() || turn > TURN;
        if bad(turn) && may_halve {
            return Ok(false);
        }
        if !turn.is_finite() {
            return Err(fastest);
        }
        // what moves a held part gives energy that nobody counts
        let parts = f64::from(1_u32 << halvings);
        if held > 0 || (turn * parts < LOOK && !self.unsolved) {
            return Ok(true);
        }
        let (before, gained) = self.gain(dt, start);
        let nothing = self.weight() * 1e-9;
        if may_halve && gained > GAIN * before / parts + nothing {
            return Ok(false);
        }
        self.gained += gained.max(0.0);
        if self.gained > MOST * before + nothing { Err(fastest) } else { Ok(true) }
    }

    /// Kinetic energy before the substep, and what the body has of energy after it that nothing gave, J.
    fn gain(&self, dt: f64, start: &Whole) -> (f64, f64) {
        let n = self.model.nv();
        let before = start.kinetic;
        let (kinetic, _) = self.state.energy(&self.model);
        let mut given = self.model.mass * self.model.gravity.dot(&(self.state.com(&self.model) - start.com));
        for i in 0..n {
            let (rest, moved) = (self.rest[i], dt * self.v[i]);
            given += 0.5 * self.stiffness[i] * (2.0 * rest - moved) * moved;
        }
        for w in &self.wrenches {
            let s = &self.state.bodies[self.model.body_of[w.link].0];
            let velocity = s.velocity + s.omega.cross(&(w.point - s.origin()));
            given += dt * (w.force.dot(&velocity) + w.moment.dot(&s.omega)).abs();
        }
        for (c, l) in self.contacts.iter().zip(&self.solver.impulses) {
            // what ground that moves does, and what pushes out of it
            given += (l[0] * c.ground[0]).max(0.0) + (l[1] * c.ground[1] + l[2] * c.ground[2]).abs();
        }
        (before, kinetic - before - given)
    }
}
