//! The edit log: which edits changed each element or joint, by how much, and where their order matters.
//!
//! Edits run in the order declared, each on what the one before left: they compose. The log is kept by [`TrackEdit::apply`] and
//! [`ClipEdit::apply`], which compare the tracks or the clip before and after, so no edit can forget to report and an
//! edit that changes nothing writes nothing. Two edits that wrote the same field of the same element conflict in the sense
//! that their order matters; the log lists it, it is no error.
//!
//! [`TrackEdit::apply`]: crate::TrackEdit::apply
//! [`ClipEdit::apply`]: crate::ClipEdit::apply

use std::collections::BTreeMap;
use std::fmt;

use motion::{Dof, Element, Joint, Label, Skeleton, Tracks, Value};

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

/// One field that several edits wrote, each on what the one before left.
#[derive(Clone, Debug, PartialEq)]
pub struct Conflict {
    /// The element.
    pub label: Label,
    /// The field.
    pub field: Field,
    /// Indices of the edits, in order.
    pub edits: Vec<usize>,
}

/// One edit of one field, and by how much, as people read it: `+0.200 s`, `12.0°`, `× 2.00`.
#[derive(Clone, Debug, PartialEq)]
struct Write {
    edit: usize,
    by: String,
}

/// What was written to one element.
#[derive(Clone, Debug, PartialEq)]
struct Writes {
    /// Its label with the DOF's name.
    name: String,
    /// The edits that wrote each field, in order; fields in order.
    fields: Vec<(Field, Vec<Write>)>,
}

impl Writes {
    fn add(&mut self, field: Field, write: Write) {
        match self.fields.binary_search_by_key(&field, |f| f.0) {
            Ok(at) => self.fields[at].1.push(write),
            Err(at) => self.fields.insert(at, (field, vec![write])),
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
        let fields = &self.writes.get(label)?.fields;
        let last = fields.iter().filter_map(|(_, w)| Some(w.last()?.edit)).max()?;
        Some((last, self.edits[last]))
    }

    /// The fields of an element that were written, each with the edit that last did.
    pub fn fields(&self, label: &Label) -> impl Iterator<Item = (Field, usize)> {
        let fields = self.writes.get(label).into_iter().flat_map(|w| &w.fields);
        fields.filter_map(|(field, writes)| Some((*field, writes.last()?.edit)))
    }

    /// All elements written by the edit of this index, in order.
    pub fn written_by(&self, edit: usize) -> Vec<&Label> {
        let wrote = |writes: &Writes| writes.fields.iter().flat_map(|(_, w)| w).any(|w| w.edit == edit);
        self.writes.iter().filter(|(_, writes)| wrote(writes)).map(|(label, _)| label).collect()
    }

    /// Fields that more than one edit wrote.
    pub fn conflicts(&self) -> Vec<Conflict> {
        let mut found = Vec::new();
        for (label, element) in &self.writes {
            for (field, writes) in &element.fields {
                if writes.len() > 1 {
                    let edits = writes.iter().map(|w| w.edit).collect();
                    found.push(Conflict { label: label.clone(), field: *field, edits });
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

    /// A line for each joint that several edits of clips changed: in order, from when to when, by how much. Times are those of the clip
    /// after the edit.
    pub fn joint_lines(&self) -> Vec<String> {
        let mut of_joint: Vec<(&str, Vec<String>)> = Vec::new();
        for c in &self.clip_changes {
            for j in &c.of_joints {
                let edit = format!("{} (edit {})", self.edits[c.edit], c.edit);
                let by = format!("{edit} {:.3} s to {:.3} s at most {}", j.from_s, j.to_s, j.by());
                match of_joint.iter_mut().find(|(link, _)| *link == j.link) {
                    Some((_, all)) => all.push(by),
                    None => of_joint.push((&j.link, vec![by])),
                }
            }
        }
        let several = of_joint.iter().filter(|(_, all)| all.len() > 1);
        several.map(|(link, all)| format!("{link}: by {}", all.join(", then "))).collect()
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

    /// For edits: several remarks.
    pub(crate) fn note_all(&mut self, texts: impl IntoIterator<Item = String>) {
        texts.into_iter().for_each(|text| self.note(text));
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
        for (dof, e) in after.elements() {
            let was = old.next().filter(|o| o.label == e.label).or_else(|| {
                let all = || before.elements().map(|(_, e)| (&e.label, e)).collect();
                by_label.get_or_insert_with(all).get(&e.label).copied()
            });
            let metres = match dof {
                Dof::Coordinate(..) => true,
                Dof::Axis(link) => matches!(skeleton.links()[link].joint, Joint::Prismatic(_)),
                Dof::Rotation(_) => false,
            };
            let created = || vec![(Field::Created, String::new())];
            let fields = was.map_or_else(created, |o| differing(o, e, metres));
            if fields.is_empty() {
                continue;
            }
            let writes = self.writes.entry(e.label.clone()).or_insert_with(|| {
                let name = dofs.get(e.label.dof).map_or_else(|| e.label.to_string(), |d| e.label.with_dof(d));
                Writes { name, fields: Vec::new() }
            });
            fields.into_iter().for_each(|(field, by)| writes.add(field, Write { edit, by }));
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

/// The fields that differ, and by how much.
///
/// * `metres`: whether the end is a place
fn differing(a: &Element, b: &Element, metres: bool) -> Vec<(Field, String)> {
    let seconds = |a: f64, b: f64| format!("{:+.3} s", b - a);
    let end = match (&a.end, &b.end) {
        (Value::Scalar(x), Value::Scalar(y)) if metres => format!("{:+.1} mm", 1e3 * (y - x)),
        (Value::Scalar(x), Value::Scalar(y)) => format!("{:+.1}°", (y - x).to_degrees()),
        (x, y) => format!("{:.1}°", x.distance(y).to_degrees()),
    };
    let tension = match b.tension / a.tension {
        factor if factor.is_finite() => format!("× {factor:.3}"),
        _ => format!("from {} to {}", a.tension, b.tension),
    };
    [
        (Field::Start, a.start_s != b.start_s, seconds(a.start_s, b.start_s)),
        (Field::Duration, a.duration_s != b.duration_s, seconds(a.duration_s, b.duration_s)),
        (Field::Hold, a.hold_s != b.hold_s, seconds(a.hold_s, b.hold_s)),
        (Field::End, a.end != b.end, end),
        (Field::Curve, a.curve != b.curve, format!("from {} to {}", a.curve, b.curve)),
        (Field::Tension, a.tension != b.tension, tension),
    ]
    .into_iter()
    .filter_map(|(field, changed, by)| changed.then_some((field, by)))
    .collect()
}

/// One line per element written: its fields, each with the edits that changed it in order, and by how much; then base tensions, clamped
/// elements, conflicts, changes of clips, of joints that several edits of clips changed, and remarks.
impl fmt::Display for EditLog {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let edit = |i: usize| format!("{} (edit {i})", self.edits[i]);
        let text =
            |label: &Label| self.writes.get(label).map_or_else(|| label.to_string(), |w| w.name.clone());
        for (label, element) in &self.writes {
            let write = |w: &Write| format!("{} {}", edit(w.edit), w.by).trim_end().to_owned();
            let fields: Vec<String> = element
                .fields
                .iter()
                .map(|(field, writes)| {
                    let all: Vec<String> = writes.iter().map(write).collect();
                    format!("{field} by {}", all.join(", then "))
                })
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
        for c in &self.clip_changes {
            writeln!(f, "{}: {c}", edit(c.edit))?;
            if c.of_joints.len() > 1 {
                let all: Vec<String> = c.of_joints.iter().map(|j| format!("{} {}", j.link, j.by())).collect();
                writeln!(f, "{}: at most {}", edit(c.edit), all.join(", "))?;
            }
        }
        for line in self.joint_lines() {
            writeln!(f, "{line}")?;
        }
        for (i, note) in &self.notes {
            writeln!(f, "{}: {note}", edit(*i))?;
        }
        Ok(())
    }
}
