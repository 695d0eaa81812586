//! Stepping: the motion of a take made possible before it is performed (`controllers::stepping`).
//!
//! In: a [`Take`] whose feet stand and step as its contacts say. Out: what is possible of it: the plan and the clip, the same
//! for scripts, clips and retargeted characters.

use bodies::Character;
use controllers::stepping::{Level, Measures, Possible, possible};
use dynamics::Model;
use dynamics::analysis::smoothed;
use dynamics::conditions::RootMode;
use motion::contacts::by_soles;
use motion::ik::IkError;
use motion::{Sole, Vec3};

use crate::limited::within_limits;
use crate::standing::contacts;
use crate::take::{Source, Take};

impl Take {
    /// The motion asked for, made possible where it steps: (plan, clip) and what was changed. A take of planted feet is
    /// possible already and comes back as it is. `None` without level ground or without legs that end in soles.
    ///
    /// # Errors
    /// Legs that two-bone IK cannot solve.
    pub fn possible(&self) -> Result<Option<Possible>, IkError> {
        let asked = &self.asked;
        let physics = &self.conditions.physics;
        let character = self.loaded();
        let Some(floor) = physics.ground else { return Ok(None) };
        if !self.stands_level() {
            return Ok(None);
        }
        if !asked.plants.is_empty() {
            let (plan, clip, ground_m) = (asked.contacts.clone(), asked.clip.clone(), floor.height_m);
            let shift = vec![Vec3::zeros(); clip.frames()];
            let (shifts, unmet, measures) = (Vec::new(), Vec::new(), Measures::default());
            return Ok(Some(Possible {
                plan,
                clip,
                ground_m,
                shift,
                shifts,
                unmet,
                measures,
                likeness: None,
            }));
        }
        // a height that was given is the stance's; one that was found is that of the soles
        let scripted = self.is_scripted();
        let given_height = scripted || asked.stance.as_ref().is_some_and(|s| s.ground_m == floor.height_m);
        let found = contacts(&character, &asked.clip).1.filter(|_| !given_height);
        let retargeted = matches!(self.source, Source::Retarget(_));
        let level = Level {
            height_m: found.unwrap_or(floor.height_m),
            friction: floor.friction,
            // a retargeted motion was made for its ground
            found: found.is_some() && !retargeted,
        };
        // contacts of a capture are found, and give way to forces; those of a script or a retargeted motion are what it was made with
        let given = asked.contacts_given || retargeted || scripted;
        // characters that are not human have their contacts by points
        let soles: Vec<Sole> = character.leg_soles().into_iter().map(|(_, sole)| sole).collect();
        let plan = by_soles(&asked.contacts, &character.skeleton, &soles);
        possible(&character, &asked.clip, &plan, given, level, physics.gravity).map(Some)
    }

    /// The body with what it carries all the time and knows of: a weight in the hand shifts the centre of mass that feet bear.
    fn loaded(&self) -> Character {
        let end_s = self.asked.clip.duration_s();
        let loads = self.conditions.carried.iter().filter(|c| c.known && c.at(0.0) && c.to_s >= end_s);
        self.body.character.carrying(loads.map(|c| &c.what))
    }

    /// Whether it is performed by looking ahead: a motion over ground, its root free, that no planted feet carry from beginning to end, and
    /// that is asked to.
    pub fn looks_ahead(&self) -> bool {
        let c = &self.conditions;
        let sampled = matches!(self.source, Source::Clip(_) | Source::Retarget(_));
        let free = c.physics.root == RootMode::Free && c.physics.ground.is_some();
        let steps = sampled && self.asked.plants.is_empty() || self.scripted_steps();
        c.foresight.is_some() && free && steps
    }

    /// Whether it is a script whose feet lift with a free root: it looks ahead unless it is told not to.
    pub fn scripted_steps(&self) -> bool {
        let free = self.conditions.physics.root == RootMode::Free;
        self.is_scripted() && free && self.asked.plants.is_empty() && !self.asked.contacts.is_empty()
    }

    /// The motion of a take that looks ahead, or of a script that steps, made possible, or, where [`Take::possible`] has nothing to say of a capture, smoothed as inverse
    /// dynamics smooths it: noise of markers is no motion, and muscles that follow it shake. Other takes, and retargeted characters
    /// without soles, whose motion has no noise and was refined already, stay as they are.
    ///
    /// # Errors
    /// Legs that two-bone IK cannot solve.
    pub(crate) fn ready_to_step(mut self) -> Result<Self, IkError> {
        if !self.looks_ahead() && !self.scripted_steps() {
            return Ok(self);
        }
        if let (take, Some(_)) = self.made_possible()? {
            return Ok(take);
        }
        if self.clip_source().is_some() {
            let model = Model::new(&self.body.character, self.conditions.physics.gravity);
            (self.asked.clip, _, _) = within_limits(smoothed(&model, &self.asked.clip));
        }
        Ok(self)
    }

    /// Whether it is a captured motion on its own feet that is performed whole, and steps, without looking ahead.
    pub fn steps_blind(&self) -> bool {
        self.conditions.physics.root == RootMode::Free
            && self.conditions.foresight.is_none()
            && self.clip_source().is_some()
            && self.asked.plants.is_empty()
            && self.stands_level()
            && !self.stands_in_parts()
    }

    /// Whether it has level ground, and legs that end in soles.
    fn stands_level(&self) -> bool {
        let c = &self.conditions;
        let level = c.physics.ground.is_some_and(|g| g.stays_level()) && c.tilts.is_empty();
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
