//! Ledger: what an engine did beyond the equations of motion, counted since it was built.
//!
//! In: substeps. Out: how hard contacts were to solve and how well they were, the momentum that corrections put in, and work that is not
//! physical. A number that is not counted is believed to be zero; these are not.

use motion::Vec3;

/// An impulse and its moment about a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impulse {
    /// N·s, world.
    pub linear: Vec3,
    /// N·m·s, world, about the point said where it is given.
    pub angular: Vec3,
}

impl Impulse {
    /// The same about a point that lies `by` from the present one.
    pub fn moved(&self, by: &Vec3) -> Self {
        Self { linear: self.linear, angular: self.angular - by.cross(&self.linear) }
    }
}

impl std::ops::AddAssign for Impulse {
    fn add_assign(&mut self, other: Self) {
        self.linear += other.linear;
        self.angular += other.angular;
    }
}

impl std::ops::Add for Impulse {
    type Output = Self;
    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

/// Residual of a contact solution at which it is good, over m g dt.
pub const TIGHT: f64 = 1e-6;
/// Residual beyond which it is no solution, over m g dt.
pub const LOOSE: f64 = 1e-3;

/// Counts and sums. See the module header.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger {
    /// Substeps.
    pub substeps: u64,
    /// Solutions of contacts: substeps with contacts, and those solved again.
    pub touching: u64,
    /// Gauss–Seidel sweeps.
    pub sweeps: u64,
    /// Newton steps.
    pub newton_steps: u64,
    /// Substeps whose contacts were solved again because the momentum correction changed their velocities.
    pub resolved: u64,
    /// Substeps taken in two halves.
    pub halved: u64,
    /// Solutions without pushing out, because points could not all be pushed out at once.
    pub wedged: u64,
    /// Solutions whose residual exceeds 1e-6 m g dt.
    pub above_tight: u64,
    /// Solutions whose residual exceeds 1e-3 m g dt: these are not solutions.
    pub above_loose: u64,
    /// Largest residual over m g dt.
    pub worst_residual: f64,
    /// Largest velocity that a correction left at a loaded contact, m/s.
    pub worst_slip: f64,
    /// Root corrections of the last control step; the moment about the world's origin.
    pub root_correction: Impulse,
    /// Their work, J.
    pub root_correction_j: f64,
    /// Sum of the squares of the linear parts per control step, (N·s)².
    pub correction_squared: f64,
    /// Control steps.
    pub steps: u64,
    /// Work of the corrections, J.
    pub correction_j: f64,
    /// Work of pushing points out of the ground, J.
    pub push_out_j: f64,
    /// Work of friction against the ground, J; not positive on ground at rest.
    pub friction_j: f64,
}

impl Ledger {
    /// Counts a solution of contacts.
    ///
    /// * `relative`: its residual over m g dt; not a number counts as no solution
    pub(crate) fn solved(&mut self, sweeps: usize, newton_steps: usize, relative: f64) {
        self.touching += 1;
        self.sweeps += sweeps as u64;
        self.newton_steps += newton_steps as u64;
        self.above_tight += u64::from(relative > TIGHT || relative.is_nan());
        self.above_loose += u64::from(relative > LOOSE || relative.is_nan());
        self.worst_residual = self.worst_residual.max(relative);
    }

    /// RMS over the control steps of the force that the root corrections amount to, N.
    pub fn correction_rms_n(&self, rate_hz: f64) -> f64 {
        (self.correction_squared / self.steps.max(1) as f64).sqrt() * rate_hz
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ledger_without_steps_is_zero() {
        assert_eq!(Ledger::default().correction_rms_n(240.0), 0.0);
    }
}
