//! Style components of two takes, and takes with style.
//!
//! In: takes of any source, files of components. Out: a [`StyleSet`] of two takes; a [`Take`] whose motion has components of
//! a set, with the log of what they changed; figures of both.
//!
//! ```text
//! take A, take B ─→ decompose ─→ StyleSet ─→ file.style, figures
//! take + StyleSet + Transfer ─→ styled ─→ Take
//! ```

pub mod figures;
pub mod library;
pub mod made;
pub mod results;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use edits::style::Representation;
use edits::style::{Example, On, Style, StyleError, StyleOptions, StyleSet, Transfer};
use edits::{ClipEdit, EditError, Motion, Where};
use formats::StyleFileError;
use formats::style_file;
use learn::ica::{Count, IcaOptions};
use scenes::scene::StyleSpec;

use crate::Take;
use crate::limited::within_limits;
use crate::standing;
use crate::standing::stance;

pub use edits::style;

/// Why there are no components, or no take with style.
#[derive(Debug, thiserror::Error)]
pub enum StylesError {
    /// Clips that cannot be decomposed, components that do not fit.
    #[error(transparent)]
    Style(#[from] StyleError),
    /// An edit that cannot be applied.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// A file that is no set of components.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: StyleFileError,
    },
}

/// Reads a file of components, or finds a style that ships by its name ([`library`]); a file of that name goes first.
///
/// # Errors
/// A file that is none, with its path.
pub fn open(path: &Path) -> Result<StyleSet, StylesError> {
    if let Some(shipped) = path.to_str().and_then(library::shipped).filter(|_| !path.exists()) {
        return shipped.set().map_err(|source| StylesError::File { path: path.to_owned(), source });
    }
    style_file::open(path).map_err(|source| StylesError::File { path: path.into(), source })
}

/// Height of the floor of a take, m.
fn floor_m(take: &Take) -> Option<f64> {
    let stands = take.asked.stance.as_ref().map(|s| s.ground_m);
    stands.or(take.conditions.physics.ground.map(|g| g.height_m))
}

/// The motion of a take as edits see it, with every contact of its feet.
fn motion(take: &Take) -> Motion {
    let (contacts, lowest_m) = standing::contacts(&take.body.character, &take.asked.clip);
    Motion { contacts, floor_m: floor_m(take).or(lowest_m), ..Motion::of(take.asked.clip.clone()) }
}

/// A take as an example of a style. `names`: see [`Example::names`].
fn example<'a>(take: &'a Take, names: &'a BTreeMap<String, String>) -> Example<'a> {
    let lowest = || standing::contacts(&take.body.character, &take.asked.clip).1;
    let floor_m = floor_m(take).or_else(lowest).unwrap_or(0.0);
    Example { name: &take.name, clip: &take.asked.clip, floor_m, names }
}

/// Decomposes the motions of two takes. `names`: links of the first and what the second calls them, where they differ.
///
/// # Errors
/// See [`StyleSet::of`].
pub fn decompose(
    a: &Take,
    b: &Take,
    names: &BTreeMap<String, String>,
    options: &StyleOptions,
) -> Result<StyleSet, StylesError> {
    let none = BTreeMap::new();
    let (one, two) = (example(a, &none), example(b, names));
    Ok(StyleSet::of(one, two, options)?)
}

/// How two takes are decomposed, as a person asks for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Find {
    /// Number of components; `None`: by variance.
    pub count: Option<usize>,
    /// Share of the variance that is enough, above 0 and at most 1.
    pub variance: f64,
    /// What is decomposed.
    pub representation: Representation,
    /// Components to be merged, numbers from 1.
    pub merge: Vec<usize>,
    /// Links of the first take and what the second calls them.
    pub names: BTreeMap<String, String>,
}

impl Find {
    /// The components of two takes; `principal`: those of variance alone, for comparison.
    ///
    /// # Errors
    /// As [`decompose`]; numbers to be merged that there are not.
    pub fn set(&self, a: &Take, b: &Take, principal: bool) -> Result<StyleSet, StylesError> {
        let count = self.count.map_or(Count::Share(self.variance), Count::Number);
        let ica = IcaOptions { count, ..IcaOptions::default() };
        let options = StyleOptions { representation: self.representation, ica, principal };
        let set = decompose(a, b, &self.names, &options)?;
        Ok(set.merged(&set.numbered(&self.merge)?))
    }
}

/// A take with components of a set. Its log has what they changed and what there is to say of it.
///
/// # Errors
/// Components and bones the set does not have, skeletons that cannot be matched.
pub fn styled(
    take: &Take,
    set: &Arc<StyleSet>,
    how: &Transfer,
    names: &BTreeMap<String, String>,
) -> Result<Take, StylesError> {
    let mut out = take.clone();
    let edit = Style { set: set.clone(), how: how.clone(), names: names.clone() };
    let motion = motion(take);
    let edited = edit.apply(&motion, &Where::default(), &mut out.log)?;
    let times = edited.times.clone();
    let (clip, clamped, limited) = within_limits(edited.clip);
    out.asked.clip = clip;
    (out.asked.clamped, out.asked.limited) = (clamped, limited);
    out.asked.contacts = edited.contacts;
    out.asked.tracks = None;
    out.asked.stance = Some(stance(&out.body.character, &out.asked.clip));
    if !times.is_identity() {
        out.asked.times = out.asked.times.then(&times);
        if let crate::Source::Clip(source) = &mut out.source {
            source.clip = times.retime(&source.clip);
        }
    }
    Ok(out)
}

/// The edit that a scene asks for.
///
/// # Errors
/// A file that is no set, components and clips it does not have.
pub(crate) fn of_spec(spec: &StyleSpec) -> Result<Style, StylesError> {
    let set = open(&spec.path)?;
    let donor = spec.from.as_ref().map_or(Ok(1), |name| set.clip_named(name))?;
    let mut how = Transfer::of(&set, donor, 0.0);
    let components: Vec<usize> = match &spec.only[..] {
        [] => how.components.iter().map(|c| c.0).collect(),
        only => set.numbered(only)?,
    };
    how.components = components.into_iter().map(|c| (c, spec.amount.clone())).collect();
    if let Some(bone) = &spec.align {
        how.on = On::Bone(bone.clone());
    }
    how.timing = spec.timing;
    Ok(Style { set: Arc::new(set), how, names: spec.names.clone() })
}
