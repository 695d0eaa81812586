//! What a program sees of the elements of a script: `fn elements(script, params)`.
//!
//! In: tracks, the elements selected. Out: the tracks as the program left them. What it is handed are `script`, `pose`, `track` and
//! `element`, named places in one copy of the tracks; writing to an element writes there. Numbers that are not finite and times
//! below zero are refused where they are written. Elements keep their places while the program runs; they are put in order of
//! time afterwards.

use std::collections::BTreeMap;
use std::sync::{Arc, RwLock};

use edits::succession::{Direction, moving, ranks_in_pose};
use edits::{Selection, Selector, poses};
use motion::names::nearest;
use motion::{Curve, Dof, Element, Label, Skeleton, Tracks};
use rhai::{Array, Dynamic, Engine, ImmutableString};

use crate::error::refuse;
use crate::shared::{Shared, read, write};
use crate::values::{self, Answer, number, within};

/// What a program works on.
struct Work {
    tracks: Tracks,
    /// Before the program wrote anything: depths and poses are of these.
    before: Tracks,
    selection: Selection,
    /// Track and place in it of every element, in order of tracks and time.
    places: Vec<(usize, usize)>,
    selected: Vec<bool>,
    /// A number for each element, the program's own.
    marks: Vec<f64>,
    /// Names of DOFs, by [`Dof::all`].
    names: Vec<ImmutableString>,
    found: Option<Found>,
    notes: Vec<String>,
}

/// What is looked for once, when a program asks.
struct Found {
    by_label: BTreeMap<String, usize>,
    /// Selected elements of each pose, in order of time.
    poses: Vec<Vec<usize>>,
    /// Depth and height of the joint among those that its pose moves.
    ranks: Vec<[i64; 2]>,
}

impl Work {
    fn new(tracks: &Tracks, selection: &Selection) -> Self {
        let counts = tracks.tracks.iter().map(|t| t.elements.len());
        let places = counts.enumerate().flat_map(|(t, n)| (0..n).map(move |e| (t, e))).collect();
        let selected: Vec<bool> = tracks.elements().map(|(_, e)| selection.contains(&e.label)).collect();
        let skeleton = &tracks.skeleton;
        let names = Dof::all(skeleton).iter().map(|d| d.name(skeleton).into()).collect();
        Self {
            before: tracks.clone(),
            tracks: tracks.clone(),
            selection: selection.clone(),
            marks: vec![0.0; selected.len()],
            places,
            selected,
            names,
            found: None,
            notes: Vec::new(),
        }
    }

    fn skeleton(&self) -> &Skeleton {
        &self.tracks.skeleton
    }

    fn element(&self, at: usize) -> (Dof, &Element) {
        let (track, place) = self.places[at];
        let track = &self.tracks.tracks[track];
        (track.dof, &track.elements[place])
    }

    fn element_mut(&mut self, at: usize) -> (Dof, &mut Element) {
        let (track, place) = self.places[at];
        let track = &mut self.tracks.tracks[track];
        (track.dof, &mut track.elements[place])
    }

    fn label(&self, l: &Label) -> String {
        l.with_dof(&self.names[l.dof])
    }

    fn found(&mut self) -> &Found {
        if self.found.is_none() {
            let all: Vec<Label> = self.before.elements().map(|(_, e)| e.label.clone()).collect();
            let index: BTreeMap<&Label, usize> = all.iter().enumerate().map(|(i, l)| (l, i)).collect();
            let moves = moving(&self.before);
            let mut ranks = vec![[0, 0]; all.len()];
            let mut of_poses = Vec::new();
            for group in poses::groups(&self.before, &self.selection) {
                let [out, back] = [Direction::Forward, Direction::Reverse]
                    .map(|d| ranks_in_pose(&self.before.skeleton, &group, &moves, d));
                let mut pose = Vec::new();
                for (k, (_, e)) in group.elements.iter().enumerate() {
                    let at = index[&e.label];
                    ranks[at] = [out[k] as i64, back[k] as i64];
                    pose.push(at);
                }
                of_poses.push(pose);
            }
            let by_label = all.iter().enumerate().map(|(i, l)| (self.label(l), i)).collect();
            self.found = Some(Found { by_label, poses: of_poses, ranks });
        }
        self.found.as_ref().expect("made above")
    }
}

/// `script`: everything.
#[derive(Clone)]
pub(crate) struct ScriptHandle(Shared<Work>);

impl ScriptHandle {
    /// The elements of `tracks`, of which some are selected.
    pub(crate) fn new(tracks: &Tracks, selection: &Selection) -> Self {
        Self(Arc::new(RwLock::new(Work::new(tracks, selection))))
    }

    /// The tracks as they are now, and what the program noted. Leaves empty tracks behind.
    pub(crate) fn take(&self) -> (Tracks, Vec<String>) {
        let mut work = write(&self.0);
        let empty = Tracks::new(work.tracks.skeleton.clone(), work.tracks.base.clone());
        (std::mem::replace(&mut work.tracks, empty), std::mem::take(&mut work.notes))
    }
}

/// `pose`: the selected elements of one pose of one repetition.
#[derive(Clone)]
pub(crate) struct PoseHandle(Shared<Work>, usize);

/// `track`: all elements of one degree of freedom.
#[derive(Clone)]
pub(crate) struct TrackHandle(Shared<Work>, usize);

/// `element`.
#[derive(Clone)]
pub(crate) struct ElementHandle(Shared<Work>, usize);

/// Elements, one after another.
pub(crate) struct Elements {
    work: Shared<Work>,
    of: Vec<usize>,
    next: usize,
}

impl Iterator for Elements {
    type Item = ElementHandle;

    fn next(&mut self) -> Option<ElementHandle> {
        let at = *self.of.get(self.next)?;
        self.next += 1;
        Some(ElementHandle(self.work.clone(), at))
    }
}

impl IntoIterator for ScriptHandle {
    type Item = ElementHandle;
    type IntoIter = Elements;

    fn into_iter(self) -> Elements {
        let of = read(&self.0).selected.iter().enumerate().filter(|(_, s)| **s).map(|(i, _)| i).collect();
        Elements { work: self.0, of, next: 0 }
    }
}

impl IntoIterator for PoseHandle {
    type Item = ElementHandle;
    type IntoIter = Elements;

    fn into_iter(self) -> Elements {
        let of = write(&self.0).found().poses[self.1].clone();
        Elements { work: self.0, of, next: 0 }
    }
}

impl IntoIterator for TrackHandle {
    type Item = ElementHandle;
    type IntoIter = Elements;

    fn into_iter(self) -> Elements {
        let of = track_places(&read(&self.0), self.1).collect();
        Elements { work: self.0, of, next: 0 }
    }
}

/// Numbers of the elements of a track.
fn track_places(work: &Work, track: usize) -> std::ops::Range<usize> {
    let first = work.places.partition_point(|p| p.0 < track);
    first..first + work.tracks.tracks[track].elements.len()
}

impl ElementHandle {
    fn get<T>(&self, f: impl FnOnce(&Work, Dof, &Element) -> T) -> T {
        let work = read(&self.0);
        let (dof, e) = work.element(self.1);
        f(&work, dof, e)
    }

    fn set(&self, f: impl FnOnce(&mut Element)) {
        f(write(&self.0).element_mut(self.1).1);
    }

    fn neighbour(&self, by: i64) -> Dynamic {
        let work = read(&self.0);
        let (track, place) = work.places[self.1];
        let there = place as i64 + by;
        let n = work.tracks.tracks[track].elements.len() as i64;
        if there < 0 || there >= n {
            return Dynamic::UNIT;
        }
        Dynamic::from(Self(self.0.clone(), (self.1 as i64 + by) as usize))
    }
}

fn curve_of(text: &str) -> Answer<Curve> {
    use motion::curve::CurveName;
    use motion::names::Word;
    let known: Vec<String> = CurveName::WORDS.iter().map(|(_, word, _)| (*word).to_owned()).collect();
    let name = CurveName::WORDS.iter().find(|(name, word, _)| *word == text || name.identifier() == text);
    match name.and_then(|(name, ..)| Curve::named(*name)) {
        Some(curve) => Ok(curve),
        None if name.is_some() => refuse("a Bezier is a list of its handles, [x1, y1, x2, y2]"),
        None => refuse(format!(
            "unknown curve `{text}`; there are: {}, or handles [x1, y1, x2, y2]",
            known.join(", ")
        )),
    }
}

fn curve(value: &Dynamic) -> Answer<Curve> {
    if let Ok(text) = value.clone().into_immutable_string() {
        return curve_of(&text);
    }
    let handles: Vec<f64> = match value.as_array_ref() {
        Ok(list) => list.iter().filter_map(number).collect(),
        Err(_) => Vec::new(),
    };
    match handles[..] {
        [x1, y1, x2, y2]
            if handles.iter().all(|x| x.is_finite())
                && (0.0..=1.0).contains(&x1)
                && (0.0..=1.0).contains(&x2) =>
        {
            Ok(Curve::Bezier(x1, y1, x2, y2))
        }
        _ => refuse(format!(
            "`curve` takes a name or [x1, y1, x2, y2] with both x in 0 to 1; found {}",
            values::shown(value)
        )),
    }
}

/// Makes the values of this module known to the language.
pub(crate) fn register(e: &mut Engine) {
    e.register_type_with_name::<ScriptHandle>("script")
        .register_type_with_name::<PoseHandle>("pose")
        .register_type_with_name::<TrackHandle>("track")
        .register_type_with_name::<ElementHandle>("element")
        .register_iterator::<ScriptHandle>()
        .register_iterator::<PoseHandle>()
        .register_iterator::<TrackHandle>();
    register_script(e);
    register_element(e);
}

fn register_script(e: &mut Engine) {
    e.register_get("duration_s", |s: &mut ScriptHandle| read(&s.0).tracks.duration_s)
        .register_get("poses", |s: &mut ScriptHandle| -> Array {
            let n = write(&s.0).found().poses.len();
            (0..n).map(|i| Dynamic::from(PoseHandle(s.0.clone(), i))).collect()
        })
        .register_get("tracks", |s: &mut ScriptHandle| -> Array {
            let n = read(&s.0).tracks.tracks.len();
            (0..n).map(|i| Dynamic::from(TrackHandle(s.0.clone(), i))).collect()
        })
        .register_get("len", |s: &mut ScriptHandle| read(&s.0).selected.iter().filter(|x| **x).count() as i64)
        .register_indexer_get(|s: &mut ScriptHandle, label: &str| {
            let mut work = write(&s.0);
            let found = work.found();
            match found.by_label.get(label) {
                Some(at) => Ok(ElementHandle(s.0.clone(), *at)),
                None => {
                    let near = nearest(label, found.by_label.keys().map(String::as_str));
                    let near = near.map(|n| format!("; did you mean `{n}`?")).unwrap_or_default();
                    refuse(format!("there is no element with the label `{label}`{near}"))
                }
            }
        })
        .register_fn("under", |s: &mut ScriptHandle, label: &str| -> Answer<Array> {
            let work = read(&s.0);
            let selected = match Selector::label(label).select(&work.before) {
                Ok(selected) => selected,
                Err(e) => return refuse(e.to_string()),
            };
            let places = (0..work.places.len()).filter(|&i| selected.contains(&work.element(i).1.label));
            Ok(places.map(|i| Dynamic::from(ElementHandle(s.0.clone(), i))).collect())
        })
        .register_fn("note", |s: &mut ScriptHandle, text: &str| write(&s.0).notes.push(text.into()))
        .register_get("len", |t: &mut TrackHandle| read(&t.0).tracks.tracks[t.1].elements.len() as i64)
        .register_get("joint", |t: &mut TrackHandle| {
            let work = read(&t.0);
            work.tracks.tracks[t.1].dof.name(work.skeleton())
        })
        .register_indexer_get(|t: &mut TrackHandle, i: i64| {
            let work = read(&t.0);
            let places = track_places(&work, t.1);
            let at = usize::try_from(i).ok().map(|i| places.start + i).filter(|at| places.contains(at));
            match at {
                Some(at) => Ok(ElementHandle(t.0.clone(), at)),
                None => refuse(format!("the track has {} elements, counted from 0; found {i}", places.len())),
            }
        })
        .register_get("len", |p: &mut PoseHandle| write(&p.0).found().poses[p.1].len() as i64)
        .register_get("elements", |p: &mut PoseHandle| -> Array {
            let of = write(&p.0).found().poses[p.1].clone();
            of.into_iter().map(|at| Dynamic::from(ElementHandle(p.0.clone(), at))).collect()
        });
}

/// A number of an element: read, and written as a number of either kind.
macro_rules! field {
    ($e:expr, $name:literal, $field:ident, $lo:expr, $hi:expr) => {
        $e.register_get_set(
            $name,
            |e: &mut ElementHandle| -> f64 { e.get(|_, _, x| x.$field) },
            |e: &mut ElementHandle, x: f64| -> Answer<()> {
                let x = within($name, &Dynamic::from_float(x), $lo, $hi)?;
                e.set(|e| e.$field = x);
                Ok(())
            },
        );
        $e.register_set($name, |e: &mut ElementHandle, x: i64| -> Answer<()> {
            let x = within($name, &Dynamic::from_int(x), $lo, $hi)?;
            e.set(|e| e.$field = x);
            Ok(())
        });
    };
}

/// The least tension of an element; below it a joint has no muscles.
const LEAST_TENSION: f64 = 1e-6;

fn register_element(e: &mut Engine) {
    field!(e, "start_s", start_s, -f64::MAX, f64::MAX);
    field!(e, "duration_s", duration_s, 0.0, f64::MAX);
    field!(e, "hold_s", hold_s, 0.0, f64::MAX);
    field!(e, "tension", tension, LEAST_TENSION, f64::MAX);
    e.register_get("arrives_s", |e: &mut ElementHandle| e.get(|_, _, x| x.arrives_s()))
        .register_get("ends_s", |e: &mut ElementHandle| e.get(|_, _, x| x.ends_s()))
        .register_get("label", |e: &mut ElementHandle| -> ImmutableString {
            e.get(|w, _, x| w.label(&x.label).into())
        })
        .register_get("action", |e: &mut ElementHandle| -> ImmutableString {
            e.get(|_, _, x| (*x.label.action).into())
        })
        .register_get("cycle", |e: &mut ElementHandle| e.get(|_, _, x| x.label.cycle as i64))
        .register_get("pose", |e: &mut ElementHandle| e.get(|_, _, x| x.label.pose as i64))
        .register_get("repetition", |e: &mut ElementHandle| e.get(|_, _, x| x.label.round() as i64))
        .register_get("joint", |e: &mut ElementHandle| -> ImmutableString {
            e.get(|w, _, x| w.names[x.label.dof].clone())
        })
        .register_get("selected", |e: &mut ElementHandle| read(&e.0).selected[e.1])
        .register_get_set(
            "mark",
            |e: &mut ElementHandle| read(&e.0).marks[e.1],
            |e: &mut ElementHandle, x: f64| write(&e.0).marks[e.1] = x,
        )
        .register_set("mark", |e: &mut ElementHandle, x: i64| write(&e.0).marks[e.1] = x as f64)
        .register_get("depth", |e: &mut ElementHandle| write(&e.0).found().ranks[e.1][0])
        .register_get("height", |e: &mut ElementHandle| write(&e.0).found().ranks[e.1][1])
        .register_get("next", |e: &mut ElementHandle| e.neighbour(1))
        .register_get("previous", |e: &mut ElementHandle| e.neighbour(-1))
        .register_get_set(
            "end_deg",
            |e: &mut ElementHandle| e.get(|w, dof, x| values::deg(w.skeleton(), dof, &x.end, "end_deg")),
            |e: &mut ElementHandle, new: Dynamic| -> Answer<()> {
                let end = e.get(|w, dof, x| values::from_deg(w.skeleton(), dof, &x.end, &new, "end_deg"))?;
                e.set(|e| e.end = end);
                Ok(())
            },
        )
        .register_get_set(
            "end_m",
            |e: &mut ElementHandle| {
                e.get(|w, dof, x| values::way(w.skeleton(), dof, &x.end, "end_m").map(Dynamic::from_float))
            },
            |e: &mut ElementHandle, new: Dynamic| -> Answer<()> {
                let end = e.get(|w, dof, _| values::from_way(w.skeleton(), dof, &new, "end_m"))?;
                e.set(|e| e.end = end);
                Ok(())
            },
        )
        .register_fn("turn_deg", |e: &mut ElementHandle, by: Dynamic| -> Answer<()> {
            let by = e.get(|w, dof, _| values::turn(w.skeleton(), dof, &by, "turn_deg"))?;
            e.set(|e| e.end = values::turned(&e.end, &by));
            Ok(())
        })
        .register_get_set(
            "curve",
            |e: &mut ElementHandle| -> Dynamic {
                e.get(|_, _, x| match x.curve {
                    Curve::Bezier(a, b, c, d) => {
                        Dynamic::from_array([a, b, c, d].map(Dynamic::from_float).to_vec())
                    }
                    named => named.to_string().into(),
                })
            },
            |e: &mut ElementHandle, new: Dynamic| -> Answer<()> {
                let curve = curve(&new)?;
                e.set(|e| e.curve = curve);
                Ok(())
            },
        );
}
