//! [`Bvh`] to [`Clip`]: metres, radians, Y up, one link per joint.
//!
//! | channels of a joint | becomes |
//! |---|---|
//! | any, the root | `Free`; its OFFSET stays only where no position channel replaces it |
//! | positions that move | `Free`; zero at OFFSET. A single one and no rotation: `Prismatic` |
//! | positions that do not move | as without them, with the constant position for OFFSET |
//! | two or three rotations | `Spherical` |
//! | one rotation | `Revolute` |
//! | none | `Fixed` |
//!
//! A file with Z up is turned by −90° about X, (x, y, z) → (x, z, −y). If its zero pose stands along Z
//! too, all axes are renamed so and the zero pose stands along Y afterwards; if its zero pose already
//! stands along Y and only its root turns it to Z, the root alone is turned back. Either way world
//! positions are the same.
//!
//! Quaternions of neighbouring frames lie in one hemisphere, so their components are continuous.

use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

use nalgebra::Quaternion;
use thiserror::Error;

use super::guess::{self, Axis, FrameRate, Units, UpAxis};
use super::{Bvh, Channel};
use motion::rotation::{Quat, Vec3};
use motion::skeleton::FARTHEST;
use motion::{Clip, Joint, Link, Skeleton, SkeletonError};

/// Positions that vary less than this (m) do not move.
const STILL_M: f64 = 1e-6;

/// What is known about a file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImportOptions {
    /// Metres per file unit; `None` guesses.
    pub metres_per_unit: Option<f64>,
    /// Vertical axis; `None` guesses.
    pub up: Option<Axis>,
    /// Whether a first frame that is an inserted T-pose is left out.
    pub drop_t_pose: bool,
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
    /// Whether the first frame is an inserted T-pose: `Some(true)` if it was dropped, `Some(false)` if kept.
    pub t_pose_dropped: Option<bool>,
    /// Anything else worth knowing, a line each.
    pub notes: Vec<String>,
}

impl fmt::Display for ImportReport {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}\n{}\n{}", self.units, self.up, self.rate)?;
        match self.t_pose_dropped {
            Some(true) => write!(f, "\nfirst frame: an inserted T-pose, dropped")?,
            Some(false) => write!(f, "\nfirst frame: an inserted T-pose, kept")?,
            None => {}
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
    let units = guess::units(bvh, options.metres_per_unit);
    let (up, rest_stands) = guess::up(bvh, options.up);
    let t_pose = guess::t_pose(bvh);
    let first = usize::from(t_pose && options.drop_t_pose);
    let mut report = ImportReport {
        units,
        up,
        rate: guess::rate(bvh),
        t_pose_dropped: t_pose.then_some(options.drop_t_pose),
        notes: Vec::new(),
    };
    let frame = Frame {
        metres: report.units.metres_per_unit,
        turn_all: report.up.axis == Axis::Z && rest_stands,
        turn_root: report.up.axis == Axis::Z && !rest_stands,
    };
    let links = links(bvh, &frame, first, &mut report.notes);
    let skeleton = Arc::new(Skeleton::new(links)?);
    let q = poses(bvh, &skeleton, &frame, first)?;
    Ok((Clip::new(skeleton, report.rate.rate_hz, q), report))
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

fn links(bvh: &Bvh, frame: &Frame, first: usize, notes: &mut Vec<String>) -> Vec<Link> {
    let mut names = Names::default();
    let (mut still, mut renamed) = (Vec::new(), Vec::new());
    let mut links = Vec::with_capacity(bvh.joints.len());
    for (j, joint) in bvh.joints.iter().enumerate() {
        let mut positions = Vec::new();
        let mut rotations = Vec::new();
        for (k, channel) in joint.channels.iter().enumerate() {
            match *channel {
                Channel::Position(axis) => positions.push((axis, joint.channels_at + k)),
                Channel::Rotation(axis) => rotations.push(axis),
            }
        }
        let moves = positions.iter().any(|&(_, at)| {
            let values = (first..bvh.frames).map(|f| bvh.frame(f)[at]);
            let (lo, hi) =
                values.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)));
            (hi - lo) * frame.metres > STILL_M
        });
        let unit = |axis: usize| frame.direction(Vec3::ith(axis, 1.0));
        let mut offset = Vec3::from(joint.offset);
        let kind = if joint.parent.is_none() {
            offset = Vec3::zeros();
            Joint::Free
        } else if moves {
            match (positions.as_slice(), rotations.len()) {
                (&[(axis, _)], 0) => Joint::Prismatic(unit(axis)),
                _ => Joint::Free,
            }
        } else {
            if !positions.is_empty() {
                offset = guess::origin(joint, guess::of_joint(joint, bvh.frame(first)));
                still.push(joint.name.as_str());
            }
            match *rotations.as_slice() {
                [] => Joint::Fixed,
                [axis] => Joint::Revolute(unit(axis)),
                _ => Joint::Spherical,
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
            notes.push(format!(
                "`{}` has {} end sites, the first is kept",
                bvh.joints[j].name,
                joint.ends.len()
            ));
        }
    }
    if !still.is_empty() {
        let shown = still.iter().take(3).copied().collect::<Vec<_>>().join(", ");
        let more = if still.len() > 3 { ", …" } else { "" };
        notes.push(format!(
            "positions that do not move are taken as offsets: {} joints ({shown}{more})",
            still.len()
        ));
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
            let values = guess::of_joint(joint, bvh.frame(first + i));
            let kind = skeleton.links()[j].joint;
            let at = skeleton.q_at(j);
            let root = joint.parent.is_none();
            if matches!(kind, Joint::Free | Joint::Spherical) {
                let mut r = guess::rotation(joint, values);
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
                    skeleton.set_position(pose, j, &frame.root_position(guess::origin(joint, values)));
                }
                Joint::Free => {
                    let moved = guess::origin(joint, values) - Vec3::from(joint.offset);
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
