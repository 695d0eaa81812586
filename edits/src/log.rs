//! The edit log: which edit last wrote each element, where edits conflict, and what edits of clips changed.
//!
//! Edits run in the order declared and a later one wins. The log is kept by [`TrackEdit::apply`] and
//! [`ClipEdit::apply`], which compare the tracks or the clip before and after, so no edit can forget to report and an
//! edit that changes nothing writes nothing. Two edits that wrote the same field of the same element conflict in the sense
//! that their order matters; the log lists it, it is no error.
//!
//! [`TrackEdit::apply`]: crate::TrackEdit::apply
//! [`ClipEdit::apply`]: crate::ClipEdit::apply

use std::collections::BTreeMap;
use std::fmt;

use motion::{Dof, Element, Label, Skeleton, Tracks};

use crate::ClipChange;

/// A field of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Field {
    /// The element itself: made by the edit.
    Created,
    /// Start time.
    Start,
    /// Duration.
    Duration,
    /// Hold.
    Hold,
    /// End value.
    End,
    /// Transition curve.
    Curve,
    /// Tension.
    Tension,
}

impl fmt::Display for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Created => "created",
            Self::Start => "start",
            Self::Duration => "duration",
            Self::Hold => "hold",
            Self::End => "end",
            Self::Curve => "curve",
            Self::Tension => "tension",
        })
    }
}

/// One field that several edits wrote; the last one holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Conflict {
    /// The element.
    pub label: Label,
    /// The field.
    pub field: Field,
    /// Indices of the edits, in order.
    pub edits: Vec<usize>,
}

/// What was written to one element.
#[derive(Clone, Debug, PartialEq)]
struct Writes {
    /// Its label with the DOF's name.
    name: String,
    /// The edits that wrote each field, in order; fields in order.
    fields: Vec<(Field, Vec<usize>)>,
}

impl Writes {
    fn add(&mut self, field: Field, edit: usize) {
        match self.fields.binary_search_by_key(&field, |f| f.0) {
            Ok(at) => self.fields[at].1.push(edit),
            Err(at) => self.fields.insert(at, (field, vec![edit])),
        }
    }
}

/// What the edits did. See the module header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EditLog {
    edits: Vec<&'static str>,
    writes: BTreeMap<Label, Writes>,
    base_tension: BTreeMap<String, Vec<usize>>,
    clamped: Vec<(usize, Label)>,
    clip_changes: Vec<ClipChange>,
    notes: Vec<(usize, String)>,
}

impl EditLog {
    /// Names of the edits applied so far, in order; other answers give indices into it.
    pub fn edits(&self) -> &[&'static str] {
        &self.edits
    }

    /// The edit that last wrote any field of an element: its index and name.
    pub fn last_writer(&self, label: &Label) -> Option<(usize, &'static str)> {
        let last = self.writes.get(label)?.fields.iter().filter_map(|(_, w)| w.last().copied()).max()?;
        Some((last, self.edits[last]))
    }

    /// The fields of an element that were written, each with the edit that last did.
    pub fn fields(&self, label: &Label) -> impl Iterator<Item = (Field, usize)> {
        let fields = self.writes.get(label).into_iter().flat_map(|w| &w.fields);
        fields.filter_map(|(field, edits)| Some((*field, *edits.last()?)))
    }

    /// All elements written by the edit of this index, in order.
    pub fn written_by(&self, edit: usize) -> Vec<&Label> {
        let wrote = |writes: &Writes| writes.fields.iter().any(|(_, w)| w.contains(&edit));
        self.writes.iter().filter(|(_, writes)| wrote(writes)).map(|(label, _)| label).collect()
    }

    /// Fields that more than one edit wrote.
    pub fn conflicts(&self) -> Vec<Conflict> {
        let mut found = Vec::new();
        for (label, writes) in &self.writes {
            for (field, edits) in &writes.fields {
                if edits.len() > 1 {
                    found.push(Conflict { label: label.clone(), field: *field, edits: edits.clone() });
                }
            }
        }
        found
    }

    /// Elements whose new value was cut by a joint limit or by reach, each with the edit.
    pub fn clamped(&self) -> &[(usize, Label)] {
        &self.clamped
    }

    /// What each clip edit changed, and what it noted, a line each.
    pub fn clip_lines(&self) -> Vec<String> {
        let edit = |i: usize| format!("{} (edit {i})", self.edits[i]);
        let changes = self.clip_changes.iter().map(|c| format!("{}: {c}", edit(c.edit)));
        changes.chain(self.notes.iter().map(|(i, note)| format!("{}: {note}", edit(*i)))).collect()
    }

    /// What edits of clips changed, in order; an edit that changed nothing is not among them.
    pub fn clip_changes(&self) -> &[ClipChange] {
        &self.clip_changes
    }

    /// Remarks of the edits, each with the edit.
    pub fn notes(&self) -> &[(usize, String)] {
        &self.notes
    }

    /// For edits: reports that the new value of an element was cut by a limit.
    pub fn clamp(&mut self, label: &Label) {
        self.clamped.push((self.current(), label.clone()));
    }

    /// For edits: a remark for the reader.
    pub fn note(&mut self, text: impl Into<String>) {
        self.notes.push((self.current(), text.into()));
    }

    /// Index of the edit begun last.
    pub(crate) fn current(&self) -> usize {
        self.edits.len().saturating_sub(1)
    }

    pub(crate) fn begin(&mut self, name: &'static str) {
        self.edits.push(name);
    }

    /// Forgets the edit begun last, because it failed.
    pub(crate) fn abandon(&mut self) {
        let edit = self.current();
        self.clamped.retain(|(e, _)| *e != edit);
        self.notes.retain(|(e, _)| *e != edit);
        self.edits.pop();
    }

    /// Records what the edit begun last changed in a clip.
    pub(crate) fn record_clip(&mut self, change: Option<ClipChange>) {
        self.clip_changes.extend(change);
    }

    /// Records every difference between the tracks before and after the edit begun last.
    pub(crate) fn record(&mut self, before: &Tracks, after: &Tracks) {
        let edit = self.current();
        let skeleton = &after.skeleton;
        let dofs: Vec<String> = Dof::all(skeleton).iter().map(|d| d.name(skeleton)).collect();
        // most edits leave elements in their places; labels are looked up only where one did not
        let mut by_label: Option<BTreeMap<&Label, &Element>> = None;
        let mut old = before.elements().map(|(_, e)| e);
        for (_, e) in after.elements() {
            let was = old.next().filter(|o| o.label == e.label).or_else(|| {
                let all = || before.elements().map(|(_, e)| (&e.label, e)).collect();
                by_label.get_or_insert_with(all).get(&e.label).copied()
            });
            let mut fields =
                was.map_or_else(|| vec![Field::Created], |o| differing(o, e)).into_iter().peekable();
            if fields.peek().is_none() {
                continue;
            }
            let writes = self.writes.entry(e.label.clone()).or_insert_with(|| {
                let name = dofs.get(e.label.dof).map_or_else(|| e.label.to_string(), |d| e.label.with_dof(d));
                Writes { name, fields: Vec::new() }
            });
            fields.for_each(|field| writes.add(field, edit));
        }
        let links = after.skeleton.links().iter();
        for (link, (a, b)) in links.zip(before.base_tension.iter().zip(&after.base_tension)) {
            if a.to_bits() != b.to_bits() {
                self.base_tension.entry(link.name.clone()).or_default().push(edit);
            }
        }
    }

    /// The label of an element as text with the DOF's name.
    pub fn name(&self, label: &Label, skeleton: &Skeleton) -> String {
        self.writes.get(label).map_or_else(|| label.named(skeleton), |w| w.name.clone())
    }
}

fn differing(a: &Element, b: &Element) -> Vec<Field> {
    [
        (Field::Start, a.start_s != b.start_s),
        (Field::Duration, a.duration_s != b.duration_s),
        (Field::Hold, a.hold_s != b.hold_s),
        (Field::End, a.end != b.end),
        (Field::Curve, a.curve != b.curve),
        (Field::Tension, a.tension != b.tension),
    ]
    .into_iter()
    .filter_map(|(field, changed)| changed.then_some(field))
    .collect()
}

/// One line per element written, then base tensions, clamped elements, conflicts, changes of clips and remarks.
impl fmt::Display for EditLog {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let edit = |i: usize| format!("{} (edit {i})", self.edits[i]);
        let text =
            |label: &Label| self.writes.get(label).map_or_else(|| label.to_string(), |w| w.name.clone());
        for (label, writes) in &self.writes {
            let fields: Vec<String> = writes
                .fields
                .iter()
                .filter_map(|(field, w)| Some(format!("{field} by {}", edit(*w.last()?))))
                .collect();
            writeln!(f, "{}: {}", text(label), fields.join(", "))?;
        }
        for (link, w) in &self.base_tension {
            if let Some(&last) = w.last() {
                writeln!(f, "{link}: base tension by {}", edit(last))?;
            }
        }
        for (i, label) in &self.clamped {
            writeln!(f, "{}: cut by a limit in {}", text(label), edit(*i))?;
        }
        for c in self.conflicts() {
            let edits: Vec<String> = c.edits.iter().map(|&i| edit(i)).collect();
            writeln!(f, "{}: {} changed by {}", text(&c.label), c.field, edits.join(", then "))?;
        }
        for line in self.clip_lines() {
            writeln!(f, "{line}")?;
        }
        Ok(())
    }
}
