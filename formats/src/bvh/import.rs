//! [`Bvh`] to [`Clip`]: metres, radians, Y up, one link per joint.
//!
//! | channels of a joint | becomes |
//! |---|---|
//! | any, the root | `Free`; its OFFSET stays only where no position channel replaces it |
//! | positions that slide | `Free`; zero at OFFSET. A single one and no rotation: `Prismatic` |
//! | positions that do not move, or are held | as without them, with their mean for OFFSET: see `offsets` |
//! | two or three rotations | `Spherical` |
//! | one rotation | `Revolute` |
//! | none | `Fixed` |
//!
//! A file with Z up is turned by −90° about X, (x, y, z) → (x, z, −y). If its zero pose stands along Z
//! too, all axes are renamed so and the zero pose stands along Y afterwards; if its zero pose already
//! stands along Y and only its root turns it to Z, the root alone is turned back. Either way world
//! positions are the same.
//!
//! Quaternions of neighbouring frames lie in one hemisphere, so their components are continuous. So is the angle of
//! a single rotation channel: where its values stay within one turn, steps of more than half a turn (160° to −180°)
//! are the shorter way round.

use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

use nalgebra::Quaternion;
use thiserror::Error;

use super::glitches::{self, Glitches};
use super::guess::{self, Units};
use super::offsets::{OffsetRule, Offsets, Positions, offsets};
use super::pose::{of_joint, origin, rotation};
use super::rate::{FrameRate, rate};
use super::t_pose::{TPose, TPoseRule, first_frame};
use super::up::{Axis, UpAxis, up};
use super::{Bvh, Channel};
use motion::rotation::{Quat, Vec3};
use motion::skeleton::FARTHEST;
use motion::{Clip, Joint, Link, Skeleton, SkeletonError};

/// What is known about a file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImportOptions {
    /// Metres per file unit; `None` guesses.
    pub metres_per_unit: Option<f64>,
    /// Vertical axis; `None` guesses.
    pub up: Option<Axis>,
    /// Frames per second, Hz; `None` reads the frame time.
    pub rate_hz: Option<f64>,
    /// What is done with the first frame; `None` looks whether it is an inserted T-pose.
    pub t_pose: Option<TPoseRule>,
    /// Whether frames in which a joint jumps are interpolated.
    pub repair: bool,
    /// What is done with joint offsets that move; `None` holds what moves little.
    pub offsets: Option<OffsetRule>,
}

/// How a file was taken. `Display` prints it, one line for each answer.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportReport {
    /// Unit of length.
    pub units: Units,
    /// Vertical axis.
    pub up: UpAxis,
    /// Frame rate.
    pub rate: FrameRate,
    /// The first frame, where it is an inserted T-pose or was dropped.
    pub t_pose: Option<TPose>,
    /// Joints whose offsets move.
    pub offsets: Offsets,
    /// Joints that jump.
    pub glitches: Glitches,
    /// Anything else worth knowing, a line each.
    pub notes: Vec<String>,
}

impl fmt::Display for ImportReport {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}\n{}\n{}", self.units, self.up, self.rate)?;
        if let Some(t_pose) = &self.t_pose {
            write!(f, "\n{t_pose}")?;
        }
        let [offsets, glitches] = [self.offsets.to_string(), self.glitches.to_string()];
        for note in offsets.lines().chain(glitches.lines()) {
            write!(f, "\n{note}")?;
        }
        for note in &self.notes {
            write!(f, "\n{note}")?;
        }
        Ok(())
    }
}

/// Why a BVH file has no clip.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ImportError {
    /// `Frames: 0`.
    #[error("the file has no frames; a clip needs at least one")]
    NoFrames,
    /// A stated unit that is no length.
    #[error("{0} metres per unit; expected a positive number")]
    Units(f64),
    /// A stated rate that is none.
    #[error("{0} frames per second; expected a positive number")]
    Rate(f64),
    /// A number too large for metres.
    #[error("frame {frame} of `{joint}` is beyond {FARTHEST:e} m")]
    Overflow {
        /// Frame, from 0.
        frame: usize,
        /// The joint.
        joint: String,
    },
    /// The hierarchy is no skeleton.
    #[error(transparent)]
    Skeleton(#[from] SkeletonError),
}

/// Converts a file; what it does not say is guessed and reported.
///
/// # Errors
/// See [`ImportError`].
pub fn import(bvh: &Bvh, options: &ImportOptions) -> Result<(Clip, ImportReport), ImportError> {
    if bvh.frames == 0 {
        return Err(ImportError::NoFrames);
    }
    if let Some(unit) = options.metres_per_unit.filter(|u| !(u.is_finite() && *u > 0.0)) {
        return Err(ImportError::Units(unit));
    }
    if let Some(hz) = options.rate_hz.filter(|hz| !(hz.is_finite() && *hz > 0.0)) {
        return Err(ImportError::Rate(hz));
    }
    let units = guess::units(bvh, options.metres_per_unit);
    let (metres, height_m) = (units.metres_per_unit, units.height_m());
    let (up, rest_stands) = up(bvh, height_m / metres, options.up);
    let t_pose = first_frame(bvh, options.t_pose);
    let first = usize::from(t_pose.is_some_and(|t| t.dropped));
    let (positions, offsets) = offsets(bvh, first, metres, height_m, options.offsets);
    let mut report = ImportReport {
        units,
        up,
        rate: rate(bvh, options.rate_hz),
        t_pose,
        offsets,
        glitches: Glitches::default(),
        notes: Vec::new(),
    };
    let frame = Frame {
        metres,
        turn_all: report.up.axis == Axis::Z && rest_stands,
        turn_root: report.up.axis == Axis::Z && !rest_stands,
    };
    let links = links(bvh, &frame, &positions, &mut report.notes);
    let skeleton = Arc::new(Skeleton::new(links)?);
    let mut q = poses(bvh, &skeleton, &frame, first)?;
    unwrap_hinges(&skeleton, &mut q, &mut report.notes);
    let (clip, glitches) = glitches::find(Clip::new(skeleton, report.rate.rate_hz, q), options.repair);
    report.glitches = glitches;
    Ok((clip, report))
}

/// File axes and units to ours.
struct Frame {
    metres: f64,
    turn_all: bool,
    turn_root: bool,
}

impl Frame {
    /// A vector without its unit.
    fn direction(&self, v: Vec3) -> Vec3 {
        if self.turn_all { z_to_y(v) } else { v }
    }

    fn vector(&self, v: Vec3) -> Vec3 {
        self.direction(v) * self.metres
    }

    /// A rotation below the root.
    fn rotation(&self, r: Quat) -> Quat {
        if !self.turn_all {
            return r;
        }
        let v = z_to_y(r.imag());
        Quat::new_unchecked(Quaternion::new(r.w, v.x, v.y, v.z))
    }

    fn root_position(&self, v: Vec3) -> Vec3 {
        if self.turn_root { z_to_y(v) * self.metres } else { self.vector(v) }
    }

    fn root_rotation(&self, r: Quat) -> Quat {
        if self.turn_root {
            Quat::from_axis_angle(&Vec3::x_axis(), -std::f64::consts::FRAC_PI_2) * r
        } else {
            self.rotation(r)
        }
    }
}

fn z_to_y(v: Vec3) -> Vec3 {
    Vec3::new(v.x, v.z, -v.y)
}

fn links(bvh: &Bvh, frame: &Frame, positions: &[Positions], notes: &mut Vec<String>) -> Vec<Link> {
    let mut names = Names::default();
    let mut renamed = Vec::new();
    let mut links = Vec::with_capacity(bvh.joints.len());
    for (joint, positions) in bvh.joints.iter().zip(positions) {
        let of = |channel: &Channel| match *channel {
            Channel::Rotation(axis) => Some(axis),
            Channel::Position(_) => None,
        };
        let rotations: Vec<usize> = joint.channels.iter().filter_map(of).collect();
        let unit = |axis: usize| frame.direction(Vec3::ith(axis, 1.0));
        let mut offset = Vec3::from(joint.offset);
        let kind = match (joint.parent, positions) {
            (None, _) => {
                offset = Vec3::zeros();
                Joint::Free
            }
            (_, Positions::Slide) => match joint.channels[..] {
                [Channel::Position(axis)] => Joint::Prismatic(unit(axis)),
                _ => Joint::Free,
            },
            (_, Positions::Offset(_) | Positions::None) => {
                if let Positions::Offset(mean) = positions {
                    offset = *mean;
                }
                match *rotations.as_slice() {
                    [] => Joint::Fixed,
                    [axis] => Joint::Revolute(unit(axis)),
                    _ => Joint::Spherical,
                }
            }
        };
        let name = names.unique(&joint.name);
        if name != joint.name {
            renamed.push(format!("`{}` is now `{name}`", joint.name));
        }
        let mut link = Link::new(name, joint.parent, frame.vector(offset), kind);
        link.end = joint.ends.first().map(|&end| frame.vector(end.into()));
        links.push(link);
        if joint.ends.len() > 1 {
            notes.push(format!("`{}` has {} end sites, the first is kept", joint.name, joint.ends.len()));
        }
    }
    if !renamed.is_empty() {
        notes.push(format!("names used twice: {}", renamed.join(", ")));
    }
    links
}

/// Makes names unique: the second `Hand` is `Hand_2`.
#[derive(Default)]
struct Names(HashMap<String, usize>);

impl Names {
    fn unique(&mut self, name: &str) -> String {
        let mut count = self.0.get(name).copied().unwrap_or(0) + 1;
        let mut candidate = if count == 1 { name.to_owned() } else { format!("{name}_{count}") };
        while count > 1 && self.0.contains_key(&candidate) {
            count += 1;
            candidate = format!("{name}_{count}");
        }
        self.0.insert(name.to_owned(), count);
        self.0.entry(candidate.clone()).or_insert(1);
        candidate
    }
}

fn poses(bvh: &Bvh, skeleton: &Skeleton, frame: &Frame, first: usize) -> Result<Vec<f64>, ImportError> {
    let nq = skeleton.nq();
    let mut q = vec![0.0; (bvh.frames - first) * nq];
    let mut before: Vec<Quat> = vec![Quat::identity(); bvh.joints.len()];
    for (i, pose) in q.chunks_exact_mut(nq).enumerate() {
        for (j, joint) in bvh.joints.iter().enumerate() {
            let values = of_joint(joint, bvh.frame(first + i));
            let kind = skeleton.links()[j].joint;
            let at = skeleton.q_at(j);
            let root = joint.parent.is_none();
            if matches!(kind, Joint::Free | Joint::Spherical) {
                let mut r = rotation(joint, values);
                r.renormalize();
                r = if root { frame.root_rotation(r) } else { frame.rotation(r) };
                if r.coords.dot(&before[j].coords) < 0.0 {
                    r = Quat::new_unchecked(-r.into_inner());
                }
                before[j] = r;
                skeleton.set_rotation(pose, j, &r);
            }
            match kind {
                Joint::Free if root => {
                    skeleton.set_position(pose, j, &frame.root_position(origin(joint, values)));
                }
                Joint::Free => {
                    let moved = origin(joint, values) - Vec3::from(joint.offset);
                    skeleton.set_position(pose, j, &frame.vector(moved));
                }
                // The one position or rotation channel there is; its axis carries the turn to Y up.
                Joint::Prismatic(_) => {
                    if let [Channel::Position(axis)] = joint.channels[..] {
                        pose[at] = (values[0] - joint.offset[axis]) * frame.metres;
                    }
                }
                Joint::Revolute(_) => {
                    let k = joint.channels.iter().position(|c| matches!(c, Channel::Rotation(_)));
                    pose[at] = k.map_or(0.0, |k| values[k].to_radians());
                }
                Joint::Spherical | Joint::Fixed => {}
            }
            if !pose[at..at + kind.nq()].iter().all(|x| x.abs() <= FARTHEST) {
                return Err(ImportError::Overflow { frame: i, joint: joint.name.clone() });
            }
        }
    }
    Ok(q)
}

/// Makes the angles of hinges continuous; see the module header.
fn unwrap_hinges(skeleton: &Skeleton, q: &mut [f64], notes: &mut Vec<String>) {
    use std::f64::consts::TAU;
    let nq = skeleton.nq();
    for (link, l) in skeleton.links().iter().enumerate() {
        if !matches!(l.joint, Joint::Revolute(_)) {
            continue;
        }
        let at = skeleton.q_at(link);
        let angles = || q.chunks_exact(nq).map(|pose| pose[at]);
        let (lo, hi) =
            angles().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(x), hi.max(x)));
        // values that go beyond a turn are continuous already: they may well step by more than half a one
        if hi - lo > TAU * (1.0 + 1e-9) {
            continue;
        }
        let (mut before, mut turns, mut wraps) = (q[at], 0.0, 0);
        for pose in q.chunks_exact_mut(nq) {
            let step = (pose[at] - before) / TAU;
            // half a turn has no shorter way round
            let step = if step.abs() <= 0.5 + 1e-9 { 0.0 } else { step.round() };
            wraps += usize::from(step != 0.0);
            turns -= step;
            before = pose[at];
            pose[at] += TAU * turns;
        }
        if wraps > 0 {
            notes.push(format!("`{}` goes round: its angle is made continuous at {wraps} steps", l.name));
        }
    }
}
