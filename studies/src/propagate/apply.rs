//! A learned edit used on a clip: how much, where, on which body, and a changed span first.
//!
//! In: an edit, a clip, a [`Use`]. Out: what [`ByExample`] does. Where contacts are kept, the feet are those of the body that is guessed
//! for the clip.

use std::path::Path;
use std::sync::Arc;

use edits::by_example::edit::Applied;
use edits::by_example::{ByExample, Contacts, ExampleEdit, Onto, Part, part};
use edits::{Motion, Where};
use motion::{Clip, Limb};

use super::PropagateError;
use super::project::open;

/// How an edit is used on a clip.
#[derive(Clone, Debug, PartialEq)]
pub struct Use {
    /// How much of it; 1 is what was taught.
    pub amount: f64,
    /// Whether what stands keeps standing; `None`: as it was taught.
    pub contacts: Option<Contacts>,
    /// Where.
    pub at: Where,
    /// The body the result is on, if that is another than the clip's.
    pub onto: Option<Onto>,
}

impl Default for Use {
    fn default() -> Self {
        Self { amount: 1.0, contacts: None, at: Where::default(), onto: None }
    }
}

/// The edit applied to a clip.
///
/// # Errors
/// A clip of another rig, a place or a body that it does not have; contacts to be kept of a clip in which nobody with feet moves.
pub fn apply(edit: &Arc<ExampleEdit>, clip: &Clip, how: &Use) -> Result<Applied, PropagateError> {
    let (edit, motion) = used(edit, clip, how)?;
    let place = how.at.in_clip(&motion).map_err(PropagateError::Edit)?;
    Ok(edit.run(&motion, &place)?)
}

/// What [`apply`] makes of the frames from `span_s.0` to `span_s.1`, before the rest is done: see [`edits::by_example::part`].
///
/// # Errors
/// As [`apply`]; a span without frames.
pub fn first(
    edit: &Arc<ExampleEdit>,
    clip: &Clip,
    how: &Use,
    span_s: (f64, f64),
) -> Result<Part, PropagateError> {
    let (edit, motion) = used(edit, clip, how)?;
    let place = how.at.in_clip(&motion).map_err(PropagateError::Edit)?;
    Ok(part::first(&edit, &motion, &place, span_s)?)
}

/// The clip edit and the motion it acts on.
fn used(edit: &Arc<ExampleEdit>, clip: &Clip, how: &Use) -> Result<(ByExample, Motion), PropagateError> {
    let whole = ByExample::new(edit.clone());
    let contacts = how.contacts.unwrap_or(whole.contacts);
    let edit = ByExample { amount: how.amount, contacts, onto: how.onto.clone(), ..whole };
    let motion = Motion::of(clip.clone());
    Ok(match (contacts, &how.onto) {
        (Contacts::Free, _) => (edit, motion),
        (Contacts::Keep, None) => (edit, footed(clip)?),
        (Contacts::Keep, Some(body)) => {
            // the feet are those of the body that the result is on
            let theirs = footed(&body.place(&motion)?.clip)?;
            let onto = Some(Onto { skeleton: theirs.clip.skeleton.clone() });
            (ByExample { onto, ..edit }, Motion { contacts: theirs.contacts, ..motion })
        }
    })
}

/// The body of a file: a clip of it, or a character.
///
/// # Errors
/// Files that hold neither.
pub fn body(path: &Path) -> Result<Onto, PropagateError> {
    if !takes::is_ron(path) {
        return Ok(Onto { skeleton: open(path)?.skeleton });
    }
    let character =
        takes::character_file::read(path).map_err(|e| PropagateError::Scene(Box::new(e.into())))?;
    Ok(Onto { skeleton: character.skeleton })
}

/// A clip with the steps of its feet: of the body that is guessed for it, whose legs it gets.
fn footed(clip: &Clip) -> Result<Motion, PropagateError> {
    let feet = |what: String| PropagateError::Feet { what };
    let guessed = bodies::guess_body_of_clip(clip, &bodies::BodyOptions::default());
    let (character, _) = guessed.map_err(|e| feet(e.to_string()))?;
    let map = bodies::PoseMap::of_clip(clip, &character.skeleton).map_err(|e| feet(e.to_string()))?;
    let on_body = map.clip_to_character(clip, &character.skeleton);
    let (contacts, floor_m) = takes::standing::contacts(&character, &on_body);
    let theirs = |link: usize| clip.skeleton.link(&character.skeleton.links()[link].name);
    let limbs = character.skeleton.limbs().iter().filter_map(|l| {
        let (upper, lower, end) = (theirs(l.upper)?, theirs(l.lower)?, theirs(l.end)?);
        Some(Limb { name: l.name.clone(), kind: l.kind, upper, lower, end })
    });
    let skeleton = clip.skeleton.as_ref().clone().with_limbs(limbs.collect());
    let skeleton = skeleton.map_err(|e| feet(e.to_string()))?;
    let clip = Clip::new(Arc::new(skeleton), clip.rate_hz, clip.data().to_vec());
    Ok(Motion { contacts, floor_m, ..Motion::of(clip) })
}
