//! Who takes part: the performer whose motion is given, and the puppet that gets it.
//!
//! Both are a [`Character`] with [`Features`]; the puppet also says whose contact each of its contact points
//! follows, because bodies of other topology have no feet to compare.

use std::sync::Arc;

use bodies::{BodyOptions, Character, guess_body_of_clip};
use motion::Clip;

use crate::RetargetError;
use crate::features::Features;

/// A human body and the points that tell its pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Performer {
    /// The body. Its contact points are what contact phases are read from.
    pub character: Character,
    /// Feature points, of which the mapping sees the positions.
    pub features: Features,
}

impl Performer {
    /// A performer with the anatomical feature points, see [`Features::anatomical`].
    ///
    /// # Errors
    /// A skeleton that is not human-like by its names.
    pub fn new(character: Character) -> Result<Self, RetargetError> {
        let features = Features::anatomical(&character)?;
        Ok(Self { character, features })
    }

    /// A performer for the skeleton of any human clip: the body is guessed.
    ///
    /// # Errors
    /// As [`guess_body_of_clip`], and as [`Performer::new`].
    pub fn of_clip(clip: &Clip) -> Result<Self, RetargetError> {
        let (character, _) = guess_body_of_clip(clip, &BodyOptions::default())?;
        Self::new(character)
    }
}

/// When a contact point is on the ground, told by several human ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Follow {
    /// While at least one of its human counterparts is: a foot that follows heel and ball.
    #[default]
    Any,
    /// Only while all of them are: a base that follows both feet, and so hops where a human walks.
    All,
}

/// A point of the puppet that may touch the ground, and whose contact it follows.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactPoint {
    /// Index into the skeleton's sites.
    pub site: usize,
    /// Human counterparts: sites among the performer's contacts (such as `heel_l_in`); a name without its
    /// last part stands for all that start with it (`heel_l`, `ball_r`).
    pub human: Vec<String>,
    /// How several counterparts are taken together.
    pub follow: Follow,
}

/// A part that follows by dynamics.
#[derive(Clone, Debug, PartialEq)]
pub struct Sway {
    /// Its links; their joints are springs.
    pub links: Vec<usize>,
    /// Frequency of a joint alone, Hz.
    pub frequency_hz: f64,
    /// Damping ratio of a joint alone.
    pub damping_ratio: f64,
}

/// The body that gets the motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Puppet {
    /// The body.
    pub character: Arc<Character>,
    /// Feature points: three virtual markers for every link that moves, see [`Features::virtual_markers`].
    pub features: Features,
    /// Its contact points.
    pub contacts: Vec<ContactPoint>,
    /// Parts that can follow by dynamics; none unless they are put here.
    pub sways: Vec<Sway>,
}

impl Puppet {
    /// A puppet with three virtual markers a link and a root frame read from its rest pose.
    ///
    /// # Errors
    /// No contact point, or none that follows; a contact point without a counterpart, or whose site does not exist.
    pub fn new(character: Character, contacts: Vec<ContactPoint>) -> Result<Self, RetargetError> {
        let features = Features::virtual_markers(&character);
        if contacts.is_empty() {
            let site = |&i: &usize| character.skeleton.sites()[i].name.clone();
            let points: Vec<String> = character.contacts.iter().map(site).collect();
            let character = character.name;
            return Err(match points.is_empty() {
                true => RetargetError::NoContactPoint { character },
                false => RetargetError::NothingFollows { character, points },
            });
        }
        let sites = character.skeleton.sites();
        for c in &contacts {
            let Some(site) = sites.get(c.site) else {
                return Err(RetargetError::ContactSite { site: c.site, sites: sites.len() });
            };
            if c.human.is_empty() {
                return Err(RetargetError::NoCounterpart { site: site.name.clone() });
            }
        }
        Ok(Self { character: Arc::new(character), features, contacts, sways: Vec::new() })
    }
}
