//! Selectors: what an edit applies to, from the whole script to one element.
//!
//! In: a [`Place`] in the script and body parts (both must hold). Out: a [`Selection`] of labels of one
//! set of tracks. A body part is a named set of links, a link, or one degree of freedom (`pelvis_y`).
//!
//! Labels as text: `wave` (action), `wave_0` (cycle), `wave_0_1` (pose, in all repetitions),
//! `wave_0_1_23` or `wave_0_1_elbow_r` (element, in all repetitions), `wave_0_1_23_2` or
//! `wave_0_1_elbow_r_2` (element of repetition 2). A repetition, or a pose of one repetition, has no text
//! of its own, because `wave_0_1_2` already is a DOF: name it by [`Place::Repetition`] and
//! [`Place::Pose`].

use std::collections::BTreeSet;

use motion::{Dof, Element, Label, Skeleton, Tracks};

use crate::EditError;

/// A place in the script.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Place {
    /// Everything.
    #[default]
    Script,
    /// One action (or the direct inserts of this name).
    Action(String),
    /// Several actions.
    Actions(Vec<String>),
    /// A cycle with all its repetitions.
    Cycle {
        /// Name of the action.
        action: String,
        /// Number of the cycle.
        cycle: usize,
    },
    /// One repetition of a cycle.
    Repetition {
        /// Name of the action.
        action: String,
        /// Number of the cycle.
        cycle: usize,
        /// Number of the repetition.
        repetition: usize,
    },
    /// A pose, in all repetitions or in one.
    Pose {
        /// Name of the action.
        action: String,
        /// Number of the cycle.
        cycle: usize,
        /// Number of the pose.
        pose: usize,
        /// Number of the repetition; `None` is all.
        repetition: Option<usize>,
    },
    /// A label as text. See the module header.
    Label(String),
}

/// A place in the script, intersected with body parts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selector {
    /// Where in the script.
    pub place: Place,
    /// Which body parts, links or DOFs; empty is the whole body.
    pub parts: Vec<String>,
}

/// What a selector found in one set of tracks.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    labels: BTreeSet<Label>,
    dofs: BTreeSet<Dof>,
    whole_script: bool,
    parts_named: bool,
}

impl Selection {
    /// The elements of some DOFs of tracks that nobody wrote, which `at` says by their element.
    pub(crate) fn of_fit(
        tracks: &Tracks,
        dofs: BTreeSet<Dof>,
        parts_named: bool,
        at: impl Fn(&Element) -> bool,
    ) -> Self {
        let elements = tracks.elements().filter(|(dof, e)| dofs.contains(dof) && at(e));
        let labels = elements.map(|(_, e)| e.label.clone()).collect();
        Self { labels, dofs, whole_script: false, parts_named }
    }

    /// The labels selected, in order.
    pub fn labels(&self) -> impl Iterator<Item = &Label> {
        self.labels.iter()
    }

    /// Whether an element is selected.
    pub fn contains(&self, label: &Label) -> bool {
        self.labels.contains(label)
    }

    /// Whether the body parts of the selector hold this DOF, so that an element of it may be created.
    pub fn allows(&self, dof: Dof) -> bool {
        self.dofs.contains(&dof)
    }

    /// Whether the place is the whole script.
    pub fn is_whole_script(&self) -> bool {
        self.whole_script
    }

    /// Whether body parts were named.
    pub fn names_parts(&self) -> bool {
        self.parts_named
    }

    /// Number of elements selected.
    pub fn len(&self) -> usize {
        self.labels.len()
    }

    /// Whether no element is selected.
    pub fn is_empty(&self) -> bool {
        self.labels.is_empty()
    }
}

impl Selector {
    /// Everything at a place.
    pub fn at(place: Place) -> Self {
        Self { place, parts: Vec::new() }
    }

    /// Everything under a label written as text.
    pub fn label(text: impl Into<String>) -> Self {
        Self::at(Place::Label(text.into()))
    }

    /// The same place, of these body parts only.
    pub fn of<S: Into<String>>(mut self, parts: impl IntoIterator<Item = S>) -> Self {
        self.parts = parts.into_iter().map(Into::into).collect();
        self
    }

    /// Finds the elements selected. A known place may still hold none of the parts named: then the
    /// selection is empty.
    ///
    /// # Errors
    /// Unknown actions, labels, parts, and numbers of cycles, poses and repetitions that do not exist.
    pub fn select(&self, tracks: &Tracks) -> Result<Selection, EditError> {
        let mut labels = self.place.labels(tracks)?;
        let mut dofs = parts_dofs(&tracks.skeleton, &self.parts)?;
        let all = Dof::all(&tracks.skeleton);
        labels.retain(|l| all.get(l.dof).is_some_and(|d| dofs.contains(d)));
        if self.place.is_element(tracks, &labels) {
            dofs.retain(|d| labels.iter().any(|l| all[l.dof] == *d));
        }
        Ok(Selection {
            labels,
            dofs,
            whole_script: self.place == Place::Script,
            parts_named: !self.parts.is_empty(),
        })
    }
}

/// The DOFs of these body parts, links and DOFs; all where none is named.
pub(crate) fn parts_dofs(s: &Skeleton, parts: &[String]) -> Result<BTreeSet<Dof>, EditError> {
    let all = Dof::all(s);
    if parts.is_empty() {
        return Ok(all.into_iter().collect());
    }
    let mut found = BTreeSet::new();
    for part in parts {
        if let Some(links) = s.parts().get(part) {
            found.extend(all.iter().filter(|d| links.contains(&d.link())));
        } else if let Some(link) = s.link(part) {
            found.extend(all.iter().filter(|d| d.link() == link));
        } else if let Some(dof) = Dof::find(s, part) {
            found.insert(dof);
        } else {
            let links = s.links().iter().map(|l| l.name.as_str());
            let known = s.parts().keys().map(String::as_str).chain(links);
            return Err(EditError::unknown("body part", part, known));
        }
    }
    Ok(found)
}

impl Place {
    fn labels(&self, tracks: &Tracks) -> Result<BTreeSet<Label>, EditError> {
        match self {
            Self::Script => Ok(collect(tracks, |_| true)),
            Self::Action(name) => action(tracks, name),
            Self::Actions(names) => {
                let mut all = BTreeSet::new();
                for name in names {
                    all.extend(action(tracks, name)?);
                }
                Ok(all)
            }
            Self::Cycle { action, cycle } => in_cycle(tracks, action, *cycle),
            Self::Repetition { action, cycle, repetition } => {
                in_repetition(in_cycle(tracks, action, *cycle)?, action, *cycle, *repetition)
            }
            Self::Pose { action, cycle, pose, repetition } => {
                let mut found = in_cycle(tracks, action, *cycle)?;
                if let Some(r) = repetition {
                    found = in_repetition(found, action, *cycle, *r)?;
                }
                let place = format!("cycle {cycle} of action \"{action}\"");
                narrow(found, place, "pose", *pose, |l| l.pose)
            }
            Self::Label(text) => labelled(tracks, text),
        }
    }

    /// Whether the place is finer than a pose.
    fn is_element(&self, tracks: &Tracks, labels: &BTreeSet<Label>) -> bool {
        let Self::Label(text) = self else { return false };
        labels.iter().any(|l| element_texts(tracks, l).any(|t| t == *text))
    }
}

fn collect(tracks: &Tracks, keep: impl Fn(&Label) -> bool) -> BTreeSet<Label> {
    tracks.elements().map(|(_, e)| &e.label).filter(|l| keep(l)).cloned().collect()
}

/// Names of all actions, in order of their first element.
fn action_names(tracks: &Tracks) -> Vec<String> {
    let mut all: Vec<&Element> = tracks.elements().map(|(_, e)| e).collect();
    all.sort_by(|a, b| a.start_s.total_cmp(&b.start_s).then_with(|| a.label.cmp(&b.label)));
    let mut names: Vec<String> = Vec::new();
    for e in all {
        if !names.iter().any(|n| **n == *e.label.action) {
            names.push(e.label.action.to_string());
        }
    }
    names
}

fn action(tracks: &Tracks, name: &str) -> Result<BTreeSet<Label>, EditError> {
    let found = collect(tracks, |l| *l.action == *name);
    if found.is_empty() {
        let names = action_names(tracks);
        return Err(EditError::unknown("action", name, names.iter().map(String::as_str)));
    }
    Ok(found)
}

/// Keeps the labels whose number `of` is `wanted`.
fn narrow(
    mut labels: BTreeSet<Label>,
    place: String,
    what: &'static str,
    wanted: usize,
    of: impl Fn(&Label) -> usize,
) -> Result<BTreeSet<Label>, EditError> {
    let exist = labels.iter().map(&of).max().map_or(0, |m| m + 1);
    labels.retain(|l| of(l) == wanted);
    // a pose of pauses exists without elements
    if labels.is_empty() && wanted >= exist {
        return Err(EditError::Index { place, what, found: wanted, exist });
    }
    Ok(labels)
}

fn in_cycle(tracks: &Tracks, name: &str, cycle: usize) -> Result<BTreeSet<Label>, EditError> {
    narrow(action(tracks, name)?, format!("action \"{name}\""), "cycle", cycle, |l| l.cycle)
}

fn in_repetition(
    labels: BTreeSet<Label>,
    action: &str,
    cycle: usize,
    repetition: usize,
) -> Result<BTreeSet<Label>, EditError> {
    let place = format!("cycle {cycle} of action \"{action}\"");
    narrow(labels, place, "repetition", repetition, Label::round)
}

/// The texts that name the element of `l`, with and without its repetition, by index and by name.
fn element_texts<'a>(tracks: &'a Tracks, l: &'a Label) -> impl Iterator<Item = String> + 'a {
    let bare = Label { repetition: None, ..l.clone() };
    let full = l.repetition.map(|_| l.clone());
    [Some(bare), full].into_iter().flatten().flat_map(|l| [l.to_string(), l.named(&tracks.skeleton)])
}

fn labelled(tracks: &Tracks, text: &str) -> Result<BTreeSet<Label>, EditError> {
    // coarser readings first; they cannot collide with finer ones of the same action
    let texts = |l: &Label| {
        let mut t = vec![l.action.to_string(), format!("{}_{}", l.action, l.cycle)];
        t.push(format!("{}_{}_{}", l.action, l.cycle, l.pose));
        t.extend(element_texts(tracks, l));
        t
    };
    let found = collect(tracks, |l| texts(l).iter().any(|t| t == text));
    if !found.is_empty() {
        return Ok(found);
    }
    let mut seen = BTreeSet::new();
    let mut known: Vec<String> = action_names(tracks);
    for (_, e) in tracks.elements() {
        known.extend(texts(&e.label));
    }
    known.retain(|t| seen.insert(t.clone()));
    Err(EditError::unknown("label", text, known.iter().map(String::as_str)))
}
