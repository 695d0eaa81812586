//! Needs of the goal's poses: loads, least stiffness and effective inertia of every joint, computed once per pose.

use dynamics::State;

use super::ModelFrom;
use crate::Goal;
use crate::antagonist::SetPoints;
use crate::support::{Foot, wrenches};
use crate::tension::{Need, StanceLeg, needs};

/// Needs per row of the goal, computed when first asked for.
pub(super) struct PoseNeeds<'a> {
    goal: &'a Goal,
    models: &'a [ModelFrom],
    set_points: &'a [SetPoints],
    stance: Vec<StanceLeg>,
    /// Feet under the weight.
    carrying: Vec<Foot>,
    /// Row and needs per body, in the order asked for.
    cache: Vec<(usize, Vec<Need>)>,
}

impl<'a> PoseNeeds<'a> {
    pub(super) fn new(
        goal: &'a Goal,
        models: &'a [ModelFrom],
        set_points: &'a [SetPoints],
        stance: Vec<StanceLeg>,
        carrying: Vec<Foot>,
    ) -> Self {
        Self { goal, models, set_points, stance, carrying, cache: Vec::new() }
    }

    /// Legs that carry the body.
    pub(super) fn stance(&self) -> &[StanceLeg] {
        &self.stance
    }

    /// All computed so far, in the order asked for.
    pub(super) fn rows(&self) -> impl Iterator<Item = (usize, &[Need])> {
        self.cache.iter().map(|(row, needs)| (*row, needs.as_slice()))
    }

    /// Needs per body of the goal's pose at a time, s.
    pub(super) fn at(&mut self, t_s: f64) -> Vec<Need> {
        let row = ((t_s * self.goal.rate_hz).round().max(0.0) as usize).min(self.goal.rows() - 1);
        if let Some((_, needs)) = self.cache.iter().find(|(r, _)| *r == row) {
            return needs.clone();
        }
        let q = self.goal.pose(row);
        let after = self.models.partition_point(|m| m.from_s < t_s + 1e-9);
        let model = &self.models[after.max(1) - 1].model;
        let mut state = State::new(model);
        state.update(model, q, &vec![0.0; model.nv()]);
        let loads = if self.carrying.is_empty() {
            Vec::new()
        } else {
            let com = motion::support::ground(&state.com(model));
            wrenches(&self.carrying, model, &state, com, -model.gravity * model.mass)
        };
        let found = needs(model, self.set_points, q, &self.stance, &loads);
        self.cache.push((row, found.clone()));
        found
    }
}
