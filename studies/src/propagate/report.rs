//! What is said of learning, of applying, and of a project.
//!
//! In: models, results, projects. Out: numbers for machines ([`serde`]) and text for people ([`fmt::Display`]).
//! Units: s, degrees.

use std::fmt;

use edits::by_example::edit::Applied;
use edits::by_example::{ExampleEdit, contradictions, key_next};
use motion::{Clip, Dof};
use serde::Serialize;

use super::PropagateError;
use super::project::Project;

/// What was learned.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Learned {
    /// Pairs taught.
    pub pairs: usize,
    /// Examples, without their mirror images.
    pub examples: usize,
    /// Whether each counts a second time, mirrored.
    pub mirrored: bool,
    /// What predicts.
    pub estimator: String,
    /// Of the two Gaussian processes: signal and noise (standard deviations), length.
    pub kernels: Vec<KernelReport>,
}

/// One kernel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KernelReport {
    /// `configuration` or `acceleration`.
    pub model: &'static str,
    /// σ_f, in units of the outputs.
    pub signal: f64,
    /// σ_n.
    pub noise: f64,
    /// l, in units of the inputs.
    pub length: f64,
    /// Largest distance of two examples, in units of the inputs: the bound of the length.
    pub diameter: f64,
    /// Whether the targets are all zero, so that there was nothing to learn.
    pub signal_is_prior: bool,
    /// Iterations of the search for them; 0 for a stored model.
    pub iterations: usize,
    /// Inducing points that all examples enter through, images not counted; `None` where they are taken as they are.
    pub through: Option<usize>,
}

/// What was learned by a model.
pub fn learned(edit: &ExampleEdit) -> Learned {
    let kernels = [("configuration", &edit.configuration), ("acceleration", &edit.acceleration)]
        .into_iter()
        .filter_map(|(model, of)| {
            let gp = of.as_gp()?;
            let k = gp.kernel();
            Some(KernelReport {
                model,
                signal: k.signal_variance.sqrt(),
                noise: k.noise_variance.sqrt(),
                length: k.length,
                diameter: gp.diameter(),
                signal_is_prior: of.examples().targets().amax() < 1e-6,
                iterations: gp.learning().iterations,
                through: gp.inducing(),
            })
        })
        .collect();
    Learned {
        pairs: edit.pairs.len(),
        examples: edit.frames.len(),
        mirrored: edit.mirrored,
        estimator: edit.options.estimator.to_string(),
        kernels,
    }
}

impl fmt::Display for Learned {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let twice = if self.mirrored {
            ", each also mirrored"
        } else {
            "; the body has no left and right, or mirroring is off"
        };
        writeln!(f, "learned from {} pairs: {} examples{twice}", self.pairs, self.examples)?;
        if let Some(points) = self.kernels.iter().find_map(|k| k.through) {
            writeln!(
                f,
                "so many are approximated: kernels are learned from at most 2000 examples and images, all enter through {points} inducing points"
            )?;
        }
        for k in &self.kernels {
            let bound = if k.length > 0.999 * k.diameter { ", its bound" } else { "" };
            if k.signal_is_prior {
                writeln!(f, "{}: nothing to learn, the differences do not bend", k.model)?;
                continue;
            }
            let steps =
                if k.iterations > 0 { format!(", {} iterations", k.iterations) } else { String::new() };
            writeln!(
                f,
                "{}: signal {:.3e}, noise {:.3e}, length {:.3} (examples are at most {:.3} apart{bound}){steps}",
                k.model, k.signal, k.noise, k.length, k.diameter
            )?;
        }
        Ok(())
    }
}

/// What an edit did to a clip.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AppliedReport {
    /// Length before and after, s.
    pub lengths_s: (f64, f64),
    /// Joints that move, farthest first, with the largest turn, degrees, and when, s.
    pub joints: Vec<(String, f64, f64)>,
    /// Share of the frames, %, that are unlike the examples: the edit gives way there.
    pub unlike_percent: f64,
    /// Frames in which joint limits hold the edit back.
    pub limited_frames: usize,
    /// Joints that cannot do all that was taught.
    pub lost: Vec<String>,
    /// Where contacts are kept: how many, and the farthest that one misses its place, mm.
    pub contacts: Option<(usize, f64)>,
}

/// What an edit did to `clip`.
pub fn applied(clip: &Clip, done: &Applied) -> AppliedReport {
    let s = &clip.skeleton;
    let mut joints: Vec<(String, f64, f64)> = Vec::new();
    for dof in Dof::all(s).into_iter().filter(|d| !matches!(d, Dof::Coordinate(..))) {
        let (mut most, mut at) = (0.0, 0.0);
        for frame in 0..clip.frames() {
            let apart = dof.read(s, clip.pose(frame)).distance(&dof.read(s, done.untimed.pose(frame)));
            if apart > most {
                (most, at) = (apart, frame as f64 / clip.rate_hz);
            }
        }
        if most > 1e-4 {
            joints.push((s.links()[dof.link()].name.clone(), most.to_degrees(), at));
        }
    }
    joints.sort_by(|a, b| b.1.total_cmp(&a.1));
    let unlike = done.answer.kept.iter().filter(|k| **k < 0.5).count();
    AppliedReport {
        lengths_s: (clip.duration_s(), done.edited.clip.duration_s()),
        joints,
        unlike_percent: 100.0 * unlike as f64 / done.answer.kept.len() as f64,
        limited_frames: done.limited,
        lost: done.lost.clone(),
        contacts: done.kept.as_ref().map(|(kept, misses)| {
            (kept.plan.contacts().len(), misses.iter().map(|m| 1e3 * m.most_m).fold(0.0, f64::max))
        }),
    }
}

impl fmt::Display for AppliedReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (before, after) = self.lengths_s;
        write!(f, "edited {before:.2} s")?;
        if (before - after).abs() > 1e-9 {
            write!(f, ", now {after:.2} s")?;
        }
        match self.joints.as_slice() {
            [] => writeln!(f, ": no joint moves")?,
            joints => {
                let far = |(name, deg, at): &(String, f64, f64)| format!("{name} {deg:.1}° at {at:.2} s");
                let first: Vec<String> = joints.iter().take(5).map(far).collect();
                let more =
                    if joints.len() > 5 { format!(" and {} more", joints.len() - 5) } else { String::new() };
                writeln!(f, "; joints moved by at most: {}{more}", first.join(", "))?;
            }
        }
        if self.unlike_percent > 0.0 {
            let percent = self.unlike_percent;
            writeln!(
                f,
                "{percent:.0} % of the frames are unlike the examples: the edit gives way to the source there"
            )?;
        }
        if self.limited_frames > 0 {
            writeln!(f, "joint limits hold the edit back in {} frames", self.limited_frames)?;
        }
        if let Some((count, mm)) = self.contacts {
            writeln!(f, "{count} contacts kept, missed by at most {mm:.1} mm")?;
        }
        if !self.lost.is_empty() {
            writeln!(f, "joints that cannot do all that was taught: {}", self.lost.join(", "))?;
        }
        Ok(())
    }
}

/// Times of the frames of a result, s; `None` where timing was not edited.
pub fn times(clip: &Clip, done: &Applied) -> Option<Vec<f64>> {
    let at = |f: usize| done.edited.times.at(f as f64 / clip.rate_hz);
    (!done.edited.times.is_identity()).then(|| (0..clip.frames()).map(at).collect())
}

/// What is asked of a project.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// Frames to key next, for each clip.
    pub next: usize,
    /// Examples contradict each other from this difference on, rad.
    pub contradiction_rad: f64,
}

/// What a project holds, and what it lacks.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Status {
    /// Name, frames, length (s) and context of every pair.
    pub pairs: Vec<(String, usize, f64, Option<String>)>,
    /// What was learned; nothing before training.
    pub learned: Option<Learned>,
    /// Whether the model is of the pairs that are there, or of those of one context.
    pub current: bool,
    /// Contexts of the pairs that it was taught.
    pub contexts: Vec<String>,
    /// Examples that contradict each other, the farthest apart first.
    pub contradictions: Vec<Contradicting>,
    /// For every clip: how unlike the examples it is.
    pub clips: Vec<ClipStatus>,
}

/// Two examples that are alike and ask for different things.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contradicting {
    /// Pair and frame of both.
    pub frames: [(String, usize); 2],
    /// Whether the second is meant with left and right exchanged.
    pub mirrored: bool,
    /// The joint at which they are farthest apart.
    pub joint: String,
    /// How far there, degrees.
    pub apart_deg: f64,
}

/// How sure a model is of a clip.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClipStatus {
    /// The clip.
    pub clip: String,
    /// Share of the frames that are unlike the examples, %.
    pub unlike_percent: f64,
    /// Frames to key next, most wanted first: frame, time (s), novelty (above 1: unlike all examples).
    pub key_next: Vec<(usize, f64, f64)>,
}

/// What a project holds, and which frames of `clips` to key next.
///
/// # Errors
/// Pairs or a model that cannot be read, clips of another rig.
pub fn status(project: &Project, clips: &[(String, Clip)], asked: &Asked) -> Result<Status, PropagateError> {
    let pairs = project.pairs(None)?;
    let model = project.model().exists().then(|| super::project::model(project.dir())).transpose()?;
    let mut all = Vec::new();
    if let Some(edit) = &model {
        for (name, clip) in clips {
            let answer = edit.answer(clip)?;
            let next = key_next(&answer, clip.rate_hz, asked.next)
                .into_iter()
                .map(|k| (k.frame, k.frame as f64 / clip.rate_hz, answer.novelty[k.frame]))
                .collect();
            let unlike = answer.kept.iter().filter(|k| **k < 0.5).count();
            all.push(ClipStatus {
                clip: name.clone(),
                unlike_percent: 100.0 * unlike as f64 / clip.frames() as f64,
                key_next: next,
            });
        }
    } else if !clips.is_empty() {
        return Err(PropagateError::Untrained { path: project.dir().into() });
    }
    let mut found = Vec::new();
    if let Some(edit) = &model {
        for c in contradictions(edit, asked.contradiction_rad)? {
            found.push(Contradicting {
                frames: c.frames.map(|e| (edit.pairs[e.pair].clone(), e.frame)),
                mirrored: c.mirrored,
                joint: c.joint,
                apart_deg: c.apart_rad.to_degrees(),
            });
        }
    }
    let current = model.as_ref().map(|m| project.is_current(m)).transpose()?.unwrap_or(false);
    let contexts = model.as_ref().map(|m| project.contexts(m)).transpose()?.unwrap_or_default();
    Ok(Status {
        pairs: pairs
            .iter()
            .map(|p| (p.name.clone(), p.source.frames(), p.source.duration_s(), p.context.clone()))
            .collect(),
        learned: model.as_ref().map(learned),
        current,
        contexts: contexts.into_iter().collect(),
        contradictions: found,
        clips: all,
    })
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, frames, length_s, context) in &self.pairs {
            let context = context.as_ref().map_or(String::new(), |c| format!(", context {c}"));
            writeln!(f, "pair {name}: {frames} frames, {length_s:.2} s{context}")?;
        }
        match &self.learned {
            None => writeln!(f, "nothing was learned yet")?,
            Some(learned) => {
                write!(f, "{learned}")?;
                if !self.contexts.is_empty() {
                    writeln!(f, "of context {}", self.contexts.join(", "))?;
                }
                if !self.current {
                    writeln!(f, "pairs were added or removed since: `propagate train` learns again")?;
                }
            }
        }
        for c in &self.contradictions {
            let [(a, i), (b, j)] = &c.frames;
            let mirrored = if c.mirrored { " mirrored" } else { "" };
            writeln!(
                f,
                "frame {i} of {a} and frame {j} of {b}{mirrored} are alike and {:.0}° apart at {}",
                c.apart_deg, c.joint
            )?;
        }
        for clip in &self.clips {
            writeln!(f, "{}: {:.0} % of the frames are unlike the examples", clip.clip, clip.unlike_percent)?;
            let next: Vec<String> = clip
                .key_next
                .iter()
                .map(|(frame, at_s, novelty)| format!("{frame} ({at_s:.2} s, novelty {novelty:.2})"))
                .collect();
            if !next.is_empty() {
                writeln!(f, "  frames to key next: {}", next.join(", "))?;
            }
        }
        Ok(())
    }
}
