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
    /// Largest vertical force asked for within [`NEAR_S`] of every row, in weights, 1 at least.
    crest: Vec<f64>,
    /// Per body that may stand and row, whether it stands by the plan of contacts; empty without a plan.
    stands: Vec<Vec<bool>>,
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

    /// The largest vertical force that the motion asked for needs around `row`, in weights, 1 at least.
    pub(super) fn crest(&self, row: usize) -> f64 {
        self.crest[row.min(self.crest.len() - 1)]
    }

    /// Whether the body `support` of those that may stand does so in `row` by the plan of contacts.
    pub(super) fn stands(&self, support: usize, row: usize) -> bool {
        self.stands.get(support).and_then(|of| of.get(row)).copied().unwrap_or(false)
    }

    /// Direction of the root asked for in `row`.
    pub(super) fn root(&self, row: usize) -> Quat {
        quat_at(self.pose(row), self.root_at)
    }
}

/// A force is asked for while one as large is within this time, s: a foot may land a little earlier or later.
const NEAR_S: f64 = 0.03;
/// Forces are means over this time, s.
const FORCE_S: f64 = 0.02;

/// Largest vertical force of a goal around every row, in weights. See [`Rows::crest`].
fn crests(model: &Model, goal: &Goal) -> Vec<f64> {
    let rows = goal.rows();
    let weight = model.gravity.norm();
    if weight <= 0.0 {
        return vec![1.0; rows];
    }
    let up = -model.gravity / weight;
    let mut state = State::new(model);
    let speeds: Vec<f64> = (0..rows)
        .map(|row| {
            state.update(model, goal.pose(row), goal.velocity(row));
            state.momentum(model).linear.dot(&up) / model.mass
        })
        .collect();
    let half = ((0.5 * FORCE_S * goal.rate_hz).round() as usize).max(1);
    let force = |row: usize| {
        let (a, b) = (row.saturating_sub(half), (row + half).min(rows - 1));
        1.0 + (speeds[b] - speeds[a]) * goal.rate_hz / ((b - a).max(1) as f64 * weight)
    };
    let forces: Vec<f64> = (0..rows).map(force).collect();
    let near = (NEAR_S * goal.rate_hz).round() as usize;
    let crest = |row: usize| {
        let around = &forces[row.saturating_sub(near)..(row + near + 1).min(rows)];
        around.iter().copied().fold(1.0, f64::max)
    };
    (0..rows).map(crest).collect()
}

/// Per support and row, whether it stands by the plan of contacts; empty without one.
fn standing(plan: &Plan, supports: &[usize]) -> Vec<Vec<bool>> {
    if plan.bears().is_empty() {
        return Vec::new();
    }
    let of = |support: &usize| {
        let mut all = vec![false; plan.goal.rows()];
        for (_, bears) in plan.feet.iter().zip(plan.bears()).filter(|(foot, _)| foot.body == *support) {
            all.iter_mut().zip(bears).for_each(|(stands, most)| *stands |= *most > 0.0);
        }
        all
    };
    supports.iter().map(of).collect()
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
        let stands = standing(plan, &supports);
        let mut ahead = Self {
            controller: Controller::unanswering(plan.clone()),
            state: State::new(model),
            supports,
            known: 0,
            rows: Rows {
                crest: crests(model, &plan.goal),
                stands,
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
