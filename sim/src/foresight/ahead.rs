//! What is known beforehand: drives of the steps to come, and what the motion asked for does in them.
//!
//! In: a plan. Out: for every row up to the horizon the drives that the plan gives without any answer to the state, and an [`Asked`]: places
//! and momenta of the motion asked for. Rows are worked out once, and kept while they are within the horizon.

use bodies::soles::Part;
use controllers::{Controller, Drive, Goal, Plan};
use dynamics::{Model, State};
use motion::skeleton::quat_at;
use motion::{Quat, Vec3};

use super::error::ForesightError;

/// What the motion asked for does in a row. World, SI.
#[derive(Clone, Debug, Default)]
pub(super) struct Asked {
    /// Centre of mass, m.
    pub com: Vec3,
    /// Its velocity, m/s.
    pub velocity: Vec3,
    /// Angular momentum about it, N·m·s.
    pub spin: Vec3,
    /// Centres of mass of the bodies that may stand, m.
    pub supports: Vec<Vec3>,
}

/// Rows to come, known up to the horizon.
pub(super) struct Rows {
    goal: Goal,
    root_at: usize,
    /// Drives and motion of row `r` at `r % len`.
    drives: Vec<Vec<Drive>>,
    asked: Vec<Asked>,
}

impl Rows {
    /// Rows of the motion.
    pub(super) fn count(&self) -> usize {
        self.goal.rows()
    }

    /// Drives of the step that ends at `row`.
    pub(super) fn drives(&self, row: usize) -> &[Drive] {
        &self.drives[row % self.drives.len()]
    }

    /// What is asked in `row`.
    pub(super) fn asked(&self, row: usize) -> &Asked {
        &self.asked[row % self.asked.len()]
    }

    /// The pose asked for in `row`.
    pub(super) fn pose(&self, row: usize) -> &[f64] {
        self.goal.pose(row)
    }

    /// Direction of the root asked for in `row`.
    pub(super) fn root(&self, row: usize) -> Quat {
        quat_at(self.pose(row), self.root_at)
    }
}

/// Works out the rows to come. See the module header.
pub(super) struct Ahead {
    controller: Controller,
    model: Model,
    state: State,
    supports: Vec<usize>,
    /// The last row known.
    known: usize,
    rows: Rows,
}

impl Ahead {
    /// Memory for `rows` rows from now on; `parts` of the soles have the same drives in all of them, after those of the joints.
    pub(super) fn new(plan: &Plan, model: &Model, supports: Vec<usize>, rows: usize, parts: &[Part]) -> Self {
        let joints = std::iter::repeat_n(Drive::NONE, model.bodies.len());
        let drives: Vec<Drive> = joints.chain(parts.iter().map(crate::soles::drive)).collect();
        let mut ahead = Self {
            controller: Controller::unanswering(plan.clone()),
            state: State::new(model),
            supports,
            known: 0,
            rows: Rows {
                goal: plan.goal.clone(),
                root_at: model.bodies[0].q_at + 3,
                drives: vec![drives; rows + 1],
                asked: vec![Asked::default(); rows + 1],
            },
            model: model.clone(),
        };
        ahead.ask(0);
        ahead
    }

    /// The rows that are known.
    pub(super) fn rows(&self) -> &Rows {
        &self.rows
    }

    /// Makes the rows up to `row` known.
    ///
    /// # Errors
    /// Of the controller.
    pub(super) fn reach(&mut self, row: usize) -> Result<(), ForesightError> {
        while self.known < row {
            self.known += 1;
            let row = self.known;
            let Self { controller, rows, .. } = self;
            let goal = &rows.goal;
            let drives = controller.step(row, goal.pose(row - 1), goal.velocity(row - 1))?;
            let at = row % rows.drives.len();
            rows.drives[at][..drives.len()].copy_from_slice(drives);
            self.ask(row);
        }
        Ok(())
    }

    /// What the motion asked for does in `row`.
    fn ask(&mut self, row: usize) {
        let Self { model, state, supports, rows, .. } = self;
        let goal = &rows.goal;
        state.update(model, goal.pose(row), goal.velocity(row));
        let m = state.momentum(model);
        let at = row % rows.asked.len();
        rows.asked[at] = Asked {
            com: m.com,
            velocity: m.linear / model.mass,
            spin: m.angular,
            supports: supports.iter().map(|&b| state.bodies[b].com).collect(),
        };
    }
}
