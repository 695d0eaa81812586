//! Stepping: the motion of a take made possible before it is performed (`controllers::stepping`).
//!
//! In: a [`Take`] whose feet stand and step as its contacts say. Out: what is possible of it: the plan and the clip, the same
//! for scripts, clips and retargeted characters.

use controllers::stepping::{Measures, Possible, possible};
use dynamics::conditions::RootMode;
use motion::ik::IkError;
use motion::{Floor, Vec3};

use crate::Take;
use crate::standing::contacts;

impl Take {
    /// The motion asked for, made possible where it steps: (plan, clip) and what was changed. A take of planted feet is
    /// possible already and comes back as it is. `None` without level ground or without legs that end in soles.
    ///
    /// # Errors
    /// Legs that two-bone IK cannot solve.
    pub fn possible(&self) -> Result<Option<Possible>, IkError> {
        let asked = &self.asked;
        let physics = &self.conditions.physics;
        let character = &self.body.character;
        let Some(floor) = physics.ground else { return Ok(None) };
        if !self.stands_level() {
            return Ok(None);
        }
        if !asked.plants.is_empty() {
            let (plan, clip, ground_m) = (asked.contacts.clone(), asked.clip.clone(), floor.height_m);
            let shift = vec![Vec3::zeros(); clip.frames()];
            let (shifts, unmet, measures) = (Vec::new(), Vec::new(), Measures::default());
            return Ok(Some(Possible { plan, clip, ground_m, shift, shifts, unmet, measures }));
        }
        // a height that was given is the stance's; one that was found is that of the soles
        let given_height = asked.stance.as_ref().is_some_and(|s| s.ground_m == floor.height_m);
        let found = contacts(character, &asked.clip).1.filter(|_| !given_height);
        let ground = (found.unwrap_or(floor.height_m), floor.friction);
        let given = asked.contacts_given;
        possible(character, &asked.clip, &asked.contacts, given, ground, physics.gravity).map(Some)
    }

    /// Whether it is a captured motion on its own feet that is performed whole, and steps.
    pub fn steps_free(&self) -> bool {
        self.conditions.physics.root == RootMode::Free
            && self.clip_source().is_some()
            && self.asked.plants.is_empty()
            && self.stands_level()
            && !self.stands_in_parts()
    }

    /// Whether it has level ground, and legs that end in soles.
    fn stands_level(&self) -> bool {
        let level = |floor: Floor| floor.up == Vec3::y() && !floor.turns;
        let level = self.conditions.physics.ground.is_some_and(level) && self.conditions.tilts.is_empty();
        level && !self.body.character.leg_soles().is_empty()
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
            let said = possible.iter().flat_map(Possible::words);
            take.asked.stepping = said.collect();
            if let Some(floor) = &mut take.conditions.physics.ground {
                floor.height_m = *ground_m;
            }
        }
        Ok((take, possible))
    }
}
