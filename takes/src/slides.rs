//! Joints that slide: why a clip is kept as a motion but not performed.
//!
//! In: a take. Out: the joints between whose links nothing holds. A joint that is free of its parent, and a slide of a body
//! guessed for a clip, move in the clip because a solver let them; no muscle makes it, and forces found for them would be
//! those of an invisible hand.

use motion::Joint;

use crate::Take;

/// Joints that slide.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "`{joint}` slides {by}against `{parent}`{others}: no muscle moves a joint so, forces of such a body mean nothing\n  help: `render --kinematic` writes the motion; --offsets hold keeps the offsets at their mean"
)]
pub struct Slides {
    /// The joint that slides farthest.
    joint: String,
    parent: String,
    by: String,
    others: String,
}

impl Slides {
    /// The joints of a take that slide; `None` if there are none.
    pub fn of(take: &Take) -> Option<Self> {
        let skeleton = &take.body.character.skeleton;
        let links = skeleton.links();
        let source = take.clip_source();
        let guessed = source.is_some_and(|s| s.body.is_some());
        let slides = |joint: &Joint| match joint {
            Joint::Free => true,
            Joint::Prismatic(_) => guessed,
            Joint::Spherical | Joint::Revolute(_) | Joint::Fixed => false,
        };
        let mut found: Vec<usize> = (1..links.len()).filter(|&i| slides(&links[i].joint)).collect();
        let moved = source.and_then(|s| s.import.as_ref()).map(|import| &import.offsets.slides);
        let by_m = |link: usize| moved?.iter().find(|m| m.joint == links[link].name).map(|m| m.by_m);
        found.sort_by(|&a, &b| by_m(b).unwrap_or(0.0).total_cmp(&by_m(a).unwrap_or(0.0)));
        let &worst = found.first()?;
        let parent = links[worst].parent.map_or_else(String::new, |p| links[p].name.clone());
        Some(Self {
            joint: links[worst].name.clone(),
            parent,
            by: by_m(worst).map_or_else(String::new, |m| format!("by up to {:.0} mm ", 1000.0 * m)),
            others: match found.len() - 1 {
                0 => String::new(),
                1 => " (and another joint slides)".into(),
                n => format!(" (and {n} other joints slide)"),
            },
        })
    }
}
