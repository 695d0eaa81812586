//! Stepping: what is done to a motion before a free body performs it with foresight.
//!
//! In: a [`Take`] whose clip steps, whose root is free and which is asked to look ahead. Out: the same, its motion smoothed as inverse dynamics
//! smooths it (`dynamics::analysis`): noise of markers is no motion, and muscles that follow it shake. Joint limits are kept. Feet are left
//! where they are: what a body makes of them is the affair of [`sim::foresight`].

use dynamics::analysis::{AnalysisOptions, strength};
use dynamics::conditions::RootMode;
use dynamics::{Model, State};
use motion::smooth::smooth_at;

use crate::limited::within_limits;
use crate::take::{Source, Take};

impl Take {
    /// Whether it is performed by looking ahead: a clip or a retargeted motion over ground, its root free, that no planted feet carry
    /// from beginning to end, and that is asked to.
    pub fn steps_freely(&self) -> bool {
        let c = &self.conditions;
        let sampled = matches!(self.source, Source::Clip(_) | Source::Retarget(_));
        let free = c.physics.root == RootMode::Free && c.physics.ground.is_some();
        c.foresight.is_some() && free && sampled && self.asked.plants.is_empty()
    }

    /// Smooths the motion of a take that steps freely; others stay as they are.
    pub(crate) fn ready_to_step(mut self) -> Self {
        if !self.steps_freely() {
            return self;
        }
        let model = Model::new(&self.body.character, self.conditions.physics.gravity);
        let clip = &self.asked.clip;
        let strength = strength(&model, &mut State::new(&model), clip, &AnalysisOptions::default());
        (self.asked.clip, _, _) = within_limits(smooth_at(clip, strength).clip);
        self
    }
}
