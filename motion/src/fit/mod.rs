//! Fits: a sampled motion as transition elements, within a tolerance.
//!
//! In: a clip and a [`Tolerance`]. Out: a [`Fit`]: [`Tracks`] whose pose at every frame is within the tolerance of the clip's, with
//! what it took and what is left. So movement properties of scripts have something to act on where there is no script.
//!
//! All joints of a limb have their keys at the same times, and so have those of the trunk ([`mod@groups`]): each key is a pose. Its
//! label has the group as its action: `arm_r_0_12` is the twelfth pose of the right arm. A first element of no duration places each
//! DOF; DOFs that keep still have none. From a key each group goes to the furthest frame that transitions still reach
//! within the tolerance: keys are dense where the motion turns, and sparse where it does not.
//!
//! Units: the tolerance is in degrees (hinges, balls, the root's rotation) and millimetres (slides, the way of the root), maxima over
//! all frames.

pub mod blocking;
pub mod groups;
pub mod segment;

use std::fmt;
use std::sync::Arc;

use thiserror::Error;

use crate::{Clip, Curve, Dof, Element, Joint, Kinematics, Label, Skeleton, Timing, Track, Tracks, Value};

use groups::{Group, groups};
use segment::Way;

/// How far a fit may be from the clip at any frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Rotations, degrees.
    pub deg: f64,
    /// Slides and the way of the root, mm.
    pub mm: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { deg: 2.0, mm: 10.0 }
    }
}

/// Why a clip is not fitted.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum FitError {
    /// A tolerance that nothing meets.
    #[error("`fit` is (deg: {deg}, mm: {mm}); allowed: both above 0 and finite")]
    Tolerance {
        /// As found, degrees.
        deg: f64,
        /// As found, mm.
        mm: f64,
    },
    /// A clip too short.
    #[error("the clip has {0} frames; a fit needs at least 2")]
    Short(usize),
}

impl Tolerance {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`FitError::Tolerance`].
    pub fn check(&self) -> Result<(), FitError> {
        let good = |x: f64| x.is_finite() && x > 0.0;
        let Self { deg, mm } = *self;
        if good(deg) && good(mm) { Ok(()) } else { Err(FitError::Tolerance { deg, mm }) }
    }

    /// Of a DOF, rad or m.
    fn of(&self, skeleton: &Skeleton, dof: Dof) -> f64 {
        if is_length(skeleton, dof) { 1e-3 * self.mm } else { self.deg.to_radians() }
    }
}

/// Whether values of the DOF are lengths.
fn is_length(skeleton: &Skeleton, dof: Dof) -> bool {
    match dof {
        Dof::Coordinate(..) => true,
        Dof::Axis(link) => matches!(skeleton.links()[link].joint, Joint::Prismatic(_)),
        Dof::Rotation(_) => false,
    }
}

/// DOFs that leave their first value by less than this share of the tolerance keep still.
const STILL: f64 = 0.05;
/// Keys are found for this share of the tolerance, so that rounding does not exceed it.
const WITHIN: f64 = 0.999;

/// What is left between a fit and its clip.
#[derive(Clone, Debug, PartialEq)]
pub struct Residue {
    /// Of what: a link.
    pub link: String,
    /// How much, degrees or mm.
    pub amount: f64,
    /// When, s.
    pub at_s: f64,
}

/// What a fit took, and what is left. Printed as a person reads it.
#[derive(Clone, Debug, PartialEq)]
pub struct FitReport {
    /// Key poses of each group, with the group's name.
    pub keys: Vec<(String, usize)>,
    /// Joints that move; the root is one.
    pub joints: usize,
    /// Keys of a joint that moves, for each second: the mean over these joints.
    pub keys_per_s: f64,
    /// The largest angle left.
    pub turned: Option<Residue>,
    /// The furthest way left of the root or a slide.
    pub moved: Option<Residue>,
    /// How far a link is from its place at most, all errors of its chain together, mm.
    pub place_mm: f64,
}

impl fmt::Display for FitReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "fitted by {:.1} keys per second and joint ({} joints)", self.keys_per_s, self.joints)?;
        if let Some(r) = &self.turned {
            write!(f, ", within {:.2}° ({} at {:.2} s)", r.amount, r.link, r.at_s)?;
        }
        if let Some(r) = &self.moved {
            write!(f, ", {:.1} mm ({})", r.amount, r.link)?;
        }
        write!(f, "; places of links within {:.0} mm", self.place_mm)
    }
}

/// A clip as transition elements. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The elements; the base pose is the first frame, tension 1.
    pub tracks: Tracks,
    /// What it took, and what is left.
    pub report: FitReport,
}

/// The DOFs of a group with their values, frame by frame.
struct Path {
    dof: Dof,
    values: Vec<Value>,
    tolerance: f64,
}

impl Fit {
    /// Fits a clip.
    ///
    /// # Errors
    /// See [`FitError`].
    pub fn of(clip: &Clip, tolerance: &Tolerance) -> Result<Self, FitError> {
        tolerance.check()?;
        if clip.frames() < 2 {
            return Err(FitError::Short(clip.frames()));
        }
        let mut tracks = Tracks::new(clip.skeleton.clone(), clip.pose(0).to_vec());
        tracks.duration_s = clip.duration_s();
        let mut keys = Vec::new();
        for group in groups(&clip.skeleton) {
            let paths = paths(clip, &group, tolerance);
            if paths.is_empty() {
                continue;
            }
            let frames = key_frames(&paths, clip.frames());
            keys.push((group.name.clone(), frames.len()));
            let curves = |path: &Path, from: usize, to: usize| Way::new(&path.values[from..=to]).bezier();
            write(&mut tracks, clip, &group, &paths, &frames, curves);
        }
        let report = FitReport::of(clip, &tracks, keys);
        Ok(Self { tracks, report })
    }
}

/// The DOFs of a group that move.
fn paths(clip: &Clip, group: &Group, tolerance: &Tolerance) -> Vec<Path> {
    let s = &clip.skeleton;
    let all = Dof::all(s).into_iter().filter(|dof| group.links.contains(&dof.link()));
    let path = |dof: Dof| {
        let values = (0..clip.frames()).map(|f| dof.read(s, clip.pose(f))).collect();
        Path { dof, values, tolerance: WITHIN * tolerance.of(s, dof) }
    };
    let moves = |p: &Path| p.values.iter().any(|v| v.distance(&p.values[0]) > STILL * p.tolerance);
    all.map(path).filter(moves).collect()
}

/// Whether transitions from frame `from` to frame `to` keep the tolerance at all frames between.
fn holds(paths: &[Path], from: usize, to: usize) -> bool {
    // the coordinates of a link are one way
    let mut apart = vec![0.0; to - from + 1];
    for (i, path) in paths.iter().enumerate() {
        let way = Way::new(&path.values[from..=to]);
        let curve = way.bezier();
        let coordinate = matches!(path.dof, Dof::Coordinate(..));
        if !coordinate || i == 0 || !matches!(paths[i - 1].dof, Dof::Coordinate(..)) {
            apart.fill(0.0);
        }
        for (f, squared) in apart.iter_mut().enumerate() {
            let e = way.error(&curve, f);
            *squared = if coordinate { *squared + e * e } else { e * e };
            if *squared > path.tolerance * path.tolerance {
                return false;
            }
        }
    }
    true
}

/// Frames of the keys of a group, the first and the last of the clip among them.
fn key_frames(paths: &[Path], frames: usize) -> Vec<usize> {
    let mut keys = vec![0];
    let mut from = 0;
    while from + 1 < frames {
        let most = frames - 1 - from;
        // further and further until it fails, then between
        let (mut good, mut bad) = (1, most + 1);
        while good < most && good < bad {
            let next = (2 * good).min(most);
            if holds(paths, from, from + next) {
                good = next;
            } else {
                bad = next;
                break;
            }
        }
        while bad - good > 1 && good < most {
            let middle = good.midpoint(bad);
            if holds(paths, from, from + middle) { good = middle } else { bad = middle }
        }
        from += good;
        keys.push(from);
    }
    keys
}

/// Writes the elements of a group that has keys at these frames.
fn write(
    tracks: &mut Tracks,
    clip: &Clip,
    group: &Group,
    paths: &[Path],
    frames: &[usize],
    curve: impl Fn(&Path, usize, usize) -> Curve,
) {
    let all = Dof::all(&clip.skeleton);
    let action: Arc<str> = group.name.as_str().into();
    let time = |f: usize| f as f64 / clip.rate_hz;
    for path in paths {
        let Some(dof) = all.iter().position(|d| *d == path.dof) else { continue };
        let element = |pose: usize, start_s: f64, end_s: f64, end: Value, curve: Curve| Element {
            label: Label { action: action.clone(), cycle: 0, repetition: None, pose, dof },
            start_s,
            duration_s: lasting(start_s, end_s),
            hold_s: 0.0,
            end,
            curve,
            tension: 1.0,
            timing: Timing::default(),
        };
        let mut elements = vec![element(0, 0.0, 0.0, path.values[0], Curve::Linear)];
        for (k, pair) in frames.windows(2).enumerate() {
            let (from, to) = (pair[0], pair[1]);
            let curve = curve(path, from, to);
            elements.push(element(k + 1, time(from), time(to), path.values[to], curve));
        }
        if let Some(track) = tracks.track_mut(path.dof) {
            *track = Track { dof: path.dof, elements };
        }
    }
}

/// A duration with which what starts at `start_s` has arrived at `end_s`, not a rounding error later: then the next element would
/// supersede it.
pub fn lasting(start_s: f64, end_s: f64) -> f64 {
    let mut duration_s = (end_s - start_s).max(0.0);
    while duration_s > 0.0 && start_s + duration_s > end_s {
        duration_s = duration_s.next_down();
    }
    duration_s
}

impl FitReport {
    /// Compares tracks with the clip, frame by frame.
    fn of(clip: &Clip, tracks: &Tracks, keys: Vec<(String, usize)>) -> Self {
        let s = &clip.skeleton;
        let mut of_link: Vec<usize> = vec![0; s.links().len()];
        for track in &tracks.tracks {
            let keys = &mut of_link[track.dof.link()];
            *keys = (*keys).max(track.elements.len());
        }
        let joints = of_link.iter().filter(|keys| **keys > 0).count();
        let all: usize = of_link.iter().sum();
        let mut report = Self {
            keys,
            joints,
            keys_per_s: all as f64 / joints.max(1) as f64 / clip.duration_s(),
            turned: None,
            moved: None,
            place_mm: 0.0,
        };
        let mut q = vec![0.0; s.nq()];
        let (mut fitted, mut given) = (Kinematics::new(s, clip.pose(0)), Kinematics::new(s, clip.pose(0)));
        let dofs = Dof::all(s);
        for f in 0..clip.frames() {
            let at_s = f as f64 / clip.rate_hz;
            tracks.pose_at(at_s, &mut q);
            let mut way = vec![0.0_f64; s.links().len()];
            for dof in &dofs {
                let error = dof.read(s, &q).distance(&dof.read(s, clip.pose(f)));
                if is_length(s, *dof) {
                    way[dof.link()] = way[dof.link()].hypot(error);
                } else {
                    larger(&mut report.turned, s, dof.link(), error.to_degrees(), at_s);
                }
            }
            for (link, way) in way.iter().enumerate() {
                larger(&mut report.moved, s, link, 1e3 * way, at_s);
            }
            fitted.update(s, &q);
            given.update(s, clip.pose(f));
            for link in 0..s.links().len() {
                let off = (fitted.origin(link) - given.origin(link)).norm();
                report.place_mm = report.place_mm.max(1e3 * off);
            }
        }
        report
    }
}

fn larger(residue: &mut Option<Residue>, s: &Skeleton, link: usize, amount: f64, at_s: f64) {
    if amount > residue.as_ref().map_or(0.0, |r| r.amount) {
        *residue = Some(Residue { link: s.links()[link].name.clone(), amount, at_s });
    }
}
