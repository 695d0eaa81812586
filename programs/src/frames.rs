//! What a program sees of a sampled motion: `fn clip(clip, params)`.
//!
//! In: a clip, the span and the degrees of freedom that the edit may change. Out: the clip as the program left it, and anchors of
//! time if it gave any. What a program is handed are `clip`, `frame` and `joint`, named places in one copy of the clip; writing to a
//! joint writes there, and everything that is read afterwards is of what was written. What lies outside the span or the parts of the edit can
//! be read, not written.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Arc, RwLock};

use edits::ClipPlace;
use motion::names::hint;
use motion::{Clip, Dof, Joint, Kinematics, Skeleton, Value, Vec3};
use rhai::{Array, Dynamic, Engine, ImmutableString};

use crate::error::refuse;
use crate::shared::{Shared, read, write};
use crate::values::{self, Answer, finite, list, three};

/// What a program works on.
struct Work {
    clip: Clip,
    place: ClipPlace,
    /// Frames of the span.
    span: Range<usize>,
    dofs: BTreeMap<String, Dof>,
    /// World transforms of a frame, until something is written to it.
    world: Option<(usize, Kinematics)>,
    anchors: Vec<(f64, f64)>,
    notes: Vec<String>,
}

impl Work {
    fn skeleton(&self) -> &Skeleton {
        &self.clip.skeleton
    }

    /// The DOF of a joint's name; with `coordinates` also those of the root.
    fn dof(&self, name: &str) -> Answer<Dof> {
        match self.dofs.get(name) {
            Some(dof) => Ok(*dof),
            None => refuse(format!(
                "there is no joint `{name}`{}",
                hint(name, self.dofs.keys().map(String::as_str))
            )),
        }
    }

    fn frame(&self, at: i64) -> Answer<usize> {
        match usize::try_from(at).ok().filter(|f| *f < self.clip.frames()) {
            Some(frame) => Ok(frame),
            None => refuse(format!("the clip has {} frames, counted from 0; found {at}", self.clip.frames())),
        }
    }

    fn read(&self, frame: usize, dof: Dof) -> Value {
        dof.read(self.skeleton(), self.clip.pose(frame))
    }

    fn write(&mut self, frame: usize, dof: Dof, value: &Value) -> Answer<()> {
        if !self.span.contains(&frame) {
            let t_s = frame as f64 / self.clip.rate_hz;
            let (from_s, to_s) = (self.place.from_s, self.place.to_s);
            return refuse(format!(
                "frame {frame} is at {t_s:.3} s, outside the span of the edit, {from_s:.3} s to {to_s:.3} s"
            ));
        }
        if !self.place.allows(dof) {
            let name = dof.name(self.skeleton());
            return refuse(format!(
                "{name} is not among the `parts` of the edit: {}",
                self.place.parts.join(", ")
            ));
        }
        let skeleton = self.clip.skeleton.clone();
        dof.write(&skeleton, self.clip.pose_mut(frame), value);
        if self.world.as_ref().is_some_and(|w| w.0 == frame) {
            self.world = None;
        }
        Ok(())
    }

    fn world(&mut self, frame: usize) -> &Kinematics {
        let skeleton = self.clip.skeleton.clone();
        let clip = &self.clip;
        let (of, world) =
            self.world.get_or_insert_with(|| (frame, Kinematics::new(&skeleton, clip.pose(frame))));
        if *of != frame {
            world.update(&skeleton, clip.pose(frame));
            *of = frame;
        }
        world
    }

    fn time_s(&self, frame: usize) -> f64 {
        frame as f64 / self.clip.rate_hz
    }

    /// 0 at an end of the span within the clip, 1 from `blend_s` inside it on.
    fn fade(&self, frame: usize, blend_s: f64) -> f64 {
        let (t_s, end_s) = (self.time_s(frame), self.clip.duration_s());
        let (from_s, to_s) = (self.place.from_s, self.place.to_s);
        let rise = |inside_s: f64| motion::smoothstep((inside_s / blend_s.max(1e-9)).clamp(0.0, 1.0));
        let begins = if from_s > 0.0 { rise(t_s - from_s) } else { 1.0 };
        let ends = if to_s < end_s { rise(to_s - t_s) } else { 1.0 };
        begins * ends
    }
}

/// `clip`: the whole.
#[derive(Clone)]
pub(crate) struct ClipHandle(Shared<Work>);

/// What a program left.
pub(crate) struct Left {
    pub(crate) clip: Clip,
    pub(crate) anchors: Vec<(f64, f64)>,
    pub(crate) notes: Vec<String>,
}

impl ClipHandle {
    /// The clip, and where it may be changed.
    pub(crate) fn new(clip: &Clip, place: &ClipPlace) -> Self {
        let s = &clip.skeleton;
        let dofs = Dof::all(s).into_iter().map(|d| (d.name(s), d)).collect();
        let covered: Vec<usize> =
            (0..clip.frames()).filter(|&f| place.covers(f as f64 / clip.rate_hz)).collect();
        let span = covered.first().map_or(0..0, |&first| first..first + covered.len());
        let (clip, place) = (clip.clone(), place.clone());
        Self(Arc::new(RwLock::new(Work {
            clip,
            place,
            span,
            dofs,
            world: None,
            anchors: Vec::new(),
            notes: Vec::new(),
        })))
    }

    /// The clip as it is now. Leaves an empty one behind.
    pub(crate) fn take(&self) -> Left {
        let mut work = write(&self.0);
        let empty = Clip::new(work.clip.skeleton.clone(), work.clip.rate_hz, Vec::new());
        Left {
            clip: std::mem::replace(&mut work.clip, empty),
            anchors: std::mem::take(&mut work.anchors),
            notes: std::mem::take(&mut work.notes),
        }
    }
}

/// `frame`.
#[derive(Clone)]
pub(crate) struct FrameHandle(Shared<Work>, usize);

/// `joint`: one degree of freedom in one frame.
#[derive(Clone)]
pub(crate) struct JointHandle(Shared<Work>, usize, Dof);

/// The frames of the span.
pub(crate) struct Frames(Shared<Work>, Range<usize>);

impl Iterator for Frames {
    type Item = FrameHandle;

    fn next(&mut self) -> Option<FrameHandle> {
        Some(FrameHandle(self.0.clone(), self.1.next()?))
    }
}

impl IntoIterator for ClipHandle {
    type Item = FrameHandle;
    type IntoIter = Frames;

    fn into_iter(self) -> Frames {
        let span = read(&self.0).span.clone();
        Frames(self.0, span)
    }
}

/// Names of the joints of some links, in order.
fn joints<'a>(s: &'a Skeleton, links: impl Iterator<Item = usize> + 'a) -> Array {
    let moves = links.filter(|&l| !matches!(s.links()[l].joint, Joint::Fixed));
    moves.map(|l| Dynamic::from(ImmutableString::from(s.links()[l].name.as_str()))).collect()
}

/// The joints of a body part, a link, or of the whole body for an empty text.
pub(crate) fn joints_of(s: &Skeleton, part: &str) -> Answer<Array> {
    if part.is_empty() {
        return Ok(joints(s, 0..s.links().len()));
    }
    if let Some(links) = s.parts().get(part) {
        return Ok(joints(s, links.iter().copied()));
    }
    match s.link(part) {
        Some(link) => Ok(joints(s, std::iter::once(link))),
        None => {
            let known = s.parts().keys().map(String::as_str).chain(s.links().iter().map(|l| l.name.as_str()));
            refuse(format!("there is no body part or joint `{part}`{}", hint(part, known)))
        }
    }
}

/// Where a link or a site is, given the transforms of all links.
pub(crate) fn place(s: &Skeleton, name: &str) -> Answer<(usize, Vec3)> {
    if let Some(link) = s.link(name) {
        return Ok((link, Vec3::zeros()));
    }
    match s.site(name) {
        Some(site) => Ok((site.link, site.at)),
        None => {
            let known =
                s.links().iter().map(|l| l.name.as_str()).chain(s.sites().iter().map(|s| s.name.as_str()));
            refuse(format!("there is no link or site `{name}`{}", hint(name, known)))
        }
    }
}

/// Makes the values of this module known to the language.
pub(crate) fn register(e: &mut Engine) {
    e.register_type_with_name::<ClipHandle>("clip")
        .register_type_with_name::<FrameHandle>("frame")
        .register_type_with_name::<JointHandle>("joint of a frame")
        .register_iterator::<ClipHandle>();
    e.register_get("frames", |c: &mut ClipHandle| read(&c.0).clip.frames() as i64)
        .register_get("rate_hz", |c: &mut ClipHandle| read(&c.0).clip.rate_hz)
        .register_get("duration_s", |c: &mut ClipHandle| read(&c.0).clip.duration_s())
        .register_get("first", |c: &mut ClipHandle| read(&c.0).span.start as i64)
        .register_get("last", |c: &mut ClipHandle| read(&c.0).span.end as i64 - 1)
        .register_indexer_get(|c: &mut ClipHandle, at: i64| -> Answer<FrameHandle> {
            let frame = read(&c.0).frame(at)?;
            Ok(FrameHandle(c.0.clone(), frame))
        })
        .register_fn("joints", |c: &mut ClipHandle, part: &str| joints_of(read(&c.0).skeleton(), part))
        .register_fn("retime", |c: &mut ClipHandle, anchors: Array| -> Answer<()> {
            let mut all = Vec::new();
            for anchor in &anchors {
                let pair = anchor.as_array_ref().ok().map(|a| a.to_vec()).unwrap_or_default();
                let [from, to] = &pair[..] else {
                    return refuse("`retime` takes a list of pairs, [[from_s, to_s], …]");
                };
                all.push((finite("from_s", from)?, finite("to_s", to)?));
            }
            write(&c.0).anchors = all;
            Ok(())
        })
        .register_fn("note", |c: &mut ClipHandle, text: &str| write(&c.0).notes.push(text.into()));
    e.register_get("index", |f: &mut FrameHandle| f.1 as i64)
        .register_get("time_s", |f: &mut FrameHandle| read(&f.0).time_s(f.1))
        .register_fn("fade", |f: &mut FrameHandle, blend_s: Dynamic| -> Answer<f64> {
            Ok(read(&f.0).fade(f.1, finite("fade", &blend_s)?))
        })
        .register_indexer_get(|f: &mut FrameHandle, name: &str| -> Answer<JointHandle> {
            let dof = read(&f.0).dof(name)?;
            Ok(JointHandle(f.0.clone(), f.1, dof))
        })
        .register_fn("place_m", |f: &mut FrameHandle, name: &str| -> Answer<Dynamic> {
            let mut work = write(&f.0);
            let (link, at) = place(work.skeleton(), name)?;
            Ok(list(work.world(f.1).point(link, &at).into()))
        })
        .register_get_set(
            "root_m",
            |f: &mut FrameHandle| -> Dynamic {
                let work = read(&f.0);
                list(work.skeleton().position(work.clip.pose(f.1), 0).into())
            },
            |f: &mut FrameHandle, new: Dynamic| -> Answer<()> {
                let new = three("root_m", &new)?;
                let mut work = write(&f.0);
                if !matches!(work.skeleton().links()[0].joint, Joint::Free) {
                    return refuse("`root_m`: the root of this body does not move freely");
                }
                (0..3).try_for_each(|k| work.write(f.1, Dof::Coordinate(0, k), &Value::Scalar(new[k])))
            },
        );
    e.register_get_set(
        "angle_deg",
        |j: &mut JointHandle| -> Answer<Dynamic> {
            let work = read(&j.0);
            values::deg(work.skeleton(), j.2, &work.read(j.1, j.2), "angle_deg")
        },
        |j: &mut JointHandle, new: Dynamic| -> Answer<()> {
            let mut work = write(&j.0);
            let value = values::from_deg(work.skeleton(), j.2, &work.read(j.1, j.2), &new, "angle_deg")?;
            work.write(j.1, j.2, &value)
        },
    )
    .register_get_set(
        "way_m",
        |j: &mut JointHandle| -> Answer<Dynamic> {
            let work = read(&j.0);
            values::way(work.skeleton(), j.2, &work.read(j.1, j.2), "way_m").map(Dynamic::from_float)
        },
        |j: &mut JointHandle, new: Dynamic| -> Answer<()> {
            let mut work = write(&j.0);
            let value = values::from_way(work.skeleton(), j.2, &new, "way_m")?;
            work.write(j.1, j.2, &value)
        },
    )
    .register_fn("turn_deg", |j: &mut JointHandle, by: Dynamic| -> Answer<()> {
        let mut work = write(&j.0);
        let by = values::turn(work.skeleton(), j.2, &by, "turn_deg")?;
        let value = values::turned(&work.read(j.1, j.2), &by);
        work.write(j.1, j.2, &value)
    });
}
