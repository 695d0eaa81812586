//! Stepping: the motion of a take made possible before it is performed (`controllers::stepping`).
//!
//! In: a [`Take`] whose feet stand and step as its contacts say. Out: what is possible of it: the plan and the clip, the same
//! for scripts, clips and retargeted characters.

use controllers::stepping::{Measures, Possible, possible};
use motion::Vec3;
use motion::ik::IkError;

use crate::Take;
use crate::standing::contacts;

impl Take {
    /// The motion asked for, made possible where it steps: (plan, clip) and what was changed. A take of planted feet is
    /// possible already and comes back as it is. `None` without ground or without legs that end in soles.
    ///
    /// # Errors
    /// Legs that two-bone IK cannot solve.
    pub fn possible(&self) -> Result<Option<Possible>, IkError> {
        let asked = &self.asked;
        let physics = &self.conditions.physics;
        let character = &self.body.character;
        let Some(floor) = physics.ground else { return Ok(None) };
        if character.leg_soles().is_empty() {
            return Ok(None);
        }
        if !asked.plants.is_empty() {
            let (plan, clip, ground_m) = (asked.contacts.clone(), asked.clip.clone(), floor.height_m);
            let shift = vec![Vec3::zeros(); clip.frames()];
            let (shifts, unmet, measures) = (Vec::new(), Vec::new(), Measures::default());
            return Ok(Some(Possible { plan, clip, ground_m, shift, shifts, unmet, measures }));
        }
        let found = contacts(character, &asked.clip).1.unwrap_or(floor.height_m);
        let ground = (found, floor.friction);
        possible(character, &asked.clip, &asked.contacts, false, ground, physics.gravity).map(Some)
    }

    /// The same take, asked for what is possible; as it is where [`Take::possible`] has nothing to say.
    ///
    /// # Errors
    /// As [`Take::possible`].
    pub fn made_possible(&self) -> Result<(Self, Option<Possible>), IkError> {
        let possible = self.possible()?;
        let mut take = self.clone();
        if let Some(Possible { plan, clip, ground_m, .. }) = &possible {
            take.asked.clip = clip.clone();
            take.asked.contacts = plan.clone();
            if let Some(floor) = &mut take.conditions.physics.ground {
                floor.height_m = *ground_m;
            }
        }
        Ok((take, possible))
    }
}
