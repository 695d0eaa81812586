//! Skeletons: a tree of links, each hung on its parent by one joint.
//!
//! In: names, parents, offsets, joints. Out: a checked tree with the layout of pose and velocity
//! vectors. No mass and no shapes (those are a character's, in `dynamics`).
//!
//! # Layout of a pose `q` and of a velocity `v`
//!
//! Links are stored parents first; each owns a contiguous slice:
//!
//! | joint | `q` | `v` |
//! |---|---|---|
//! | `Free` | position (3, m), quaternion `w x y z` (4) | linear (3, m/s), angular (3, rad/s) |
//! | `Spherical` | quaternion `w x y z` (4) | angular (3, rad/s) |
//! | `Revolute` | angle (1, rad) | rate (1, rad/s) |
//! | `Prismatic` | distance (1, m) | rate (1, m/s) |
//! | `Fixed` | – | – |
//!
//! All vectors of `v` are expressed in the joint's zero frame (the parent's axes turned by
//! [`Link::parent_from_zero`]), not in the moving link: `R(t + dt) = exp(ω dt) R(t)`.
//! Several joints between two links are a chain through links without mass.

use std::collections::BTreeMap;

use nalgebra::{Quaternion, Translation3};
use thiserror::Error;

use crate::Transform;
use crate::names::{self, Word};
use crate::rotation::{Quat, Vec3, exp, log, swing_twist};

/// How a link may move against its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Joint {
    /// Six degrees of freedom.
    Free,
    /// A ball joint: three degrees of freedom, a unit quaternion.
    Spherical,
    /// A hinge about a unit axis of the zero frame.
    Revolute(Vec3),
    /// A slide along a unit axis of the zero frame.
    Prismatic(Vec3),
    /// Welded.
    Fixed,
}

impl Joint {
    /// Numbers this joint takes in a pose vector.
    pub fn nq(&self) -> usize {
        match self {
            Joint::Free => 7,
            Joint::Spherical => 4,
            Joint::Revolute(_) | Joint::Prismatic(_) => 1,
            Joint::Fixed => 0,
        }
    }

    /// Degrees of freedom: numbers this joint takes in a velocity vector.
    pub fn nv(&self) -> usize {
        match self {
            Joint::Free => 6,
            Joint::Spherical => 3,
            Joint::Revolute(_) | Joint::Prismatic(_) => 1,
            Joint::Fixed => 0,
        }
    }
}

/// A closed interval, `lo < hi`; rad or m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Lower end.
    pub lo: f64,
    /// Upper end.
    pub hi: f64,
}

impl Range {
    /// The interval from `lo` to `hi`.
    pub fn new(lo: f64, hi: f64) -> Self {
        Self { lo, hi }
    }

    /// `x` moved to the nearest point of the interval.
    pub fn clamp(&self, x: f64) -> f64 {
        x.clamp(self.lo, self.hi)
    }

    /// Whether `x` lies inside, ends included.
    pub fn contains(&self, x: f64) -> bool {
        x >= self.lo && x <= self.hi
    }
}

/// Limits of a ball joint in anatomical coordinates: two swings and a twist.
///
/// With `R = swing · twist` about `axes[2]` (the bone), the coordinates are
/// `φ = (log(swing)·axes[0], log(swing)·axes[1], twist angle)`, rad. The axes are orthonormal vectors
/// of the zero frame. Swing-twist, because limits on rotation-vector components depend on the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallLimits {
    /// First swing axis, second swing axis, twist axis: orthonormal, zero frame.
    pub axes: [Vec3; 3],
    /// Allowed interval of each coordinate, rad, inside (−π, π).
    pub ranges: [Range; 3],
}

impl BallLimits {
    /// Anatomical coordinates φ of a rotation, rad.
    pub fn coords(&self, q: &Quat) -> Vec3 {
        let (swing, twist) = swing_twist(q, &self.axes[2]);
        let s = log(&swing);
        Vec3::new(s.dot(&self.axes[0]), s.dot(&self.axes[1]), log(&twist).dot(&self.axes[2]))
    }

    /// The rotation with the given anatomical coordinates, rad.
    pub fn rotation(&self, phi: &Vec3) -> Quat {
        exp(&(self.axes[0] * phi[0] + self.axes[1] * phi[1])) * exp(&(self.axes[2] * phi[2]))
    }

    /// Nearest allowed rotation, coordinate by coordinate; `q` itself, to the bit, when it is allowed.
    pub fn clamp(&self, q: &Quat) -> Quat {
        let phi = self.coords(q);
        if (0..3).all(|i| self.ranges[i].contains(phi[i])) {
            return *q;
        }
        self.rotation(&Vec3::from_fn(|i, _| self.ranges[i].clamp(phi[i])))
    }
}

/// Range of motion of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limits {
    /// Of a hinge (rad) or a slide (m).
    Axis(Range),
    /// Of a ball joint.
    Ball(BallLimits),
}

/// A link and the joint that hangs it on its parent.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Unique name.
    pub name: String,
    /// Index of the parent, smaller than the link's own; `None` for the root.
    pub parent: Option<usize>,
    /// The joint's zero frame in the parent's frame: where the link is when its joint value is zero.
    pub parent_from_zero: Transform,
    /// How the link moves.
    pub joint: Joint,
    /// Range of motion; `None` is unlimited.
    pub limits: Option<Limits>,
    /// Where a drawn bone without children ends, in the link's frame, m (a BVH `End Site`).
    pub end: Option<Vec3>,
}

impl Link {
    /// A link whose zero frame is only translated by `offset` (m) from its parent's.
    pub fn new(name: impl Into<String>, parent: Option<usize>, offset: Vec3, joint: Joint) -> Self {
        Self {
            name: name.into(),
            parent,
            parent_from_zero: Transform::from_parts(Translation3::from(offset), Quat::identity()),
            joint,
            limits: None,
            end: None,
        }
    }
}

/// A named point on a link.
#[derive(Clone, Debug, PartialEq)]
pub struct Site {
    /// Unique name.
    pub name: String,
    /// The link it is fixed to.
    pub link: usize,
    /// Position in the link's frame, m.
    pub at: Vec3,
}

/// What a limb is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LimbKind {
    /// Shoulder, elbow, hand.
    Arm,
    /// Hip, knee, foot.
    Leg,
}

impl Word for LimbKind {
    const KIND: &'static str = "kind of limb";
    const WORDS: &'static [(Self, &'static str, &'static str)] =
        &[(Self::Arm, "arm", "Shoulder, elbow, hand"), (Self::Leg, "leg", "Hip, knee, foot")];
}

/// A two-bone limb: the links of its upper bone, lower bone and end (hand or foot).
#[derive(Clone, Debug, PartialEq)]
pub struct Limb {
    /// Name, such as `arm_r` or `leg_l`.
    pub name: String,
    /// Arm or leg.
    pub kind: LimbKind,
    /// Upper arm or thigh; its joint is the shoulder or hip.
    pub upper: usize,
    /// Forearm or shin; its joint is the elbow or knee.
    pub lower: usize,
    /// Hand or foot; its joint is the wrist or ankle.
    pub end: usize,
}

impl Limb {
    /// Its links, from the body outward.
    pub fn links(&self) -> [usize; 3] {
        [self.upper, self.lower, self.end]
    }
}

/// Longest way from a link to its parent or its end, m: far below what single precision holds, so that every format can.
pub const FARTHEST: f64 = 1e9;

/// What is wrong with a skeleton.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SkeletonError {
    /// No link at all.
    #[error("a skeleton needs at least one link")]
    Empty,
    /// Two links (or two sites) of one name.
    #[error("the name `{0}` is used twice; names must be unique")]
    DuplicateName(String),
    /// A parent that does not come before its child, or a second root.
    #[error(
        "link `{link}` has parent {parent:?}: parents come before their children, and only the first link is a root"
    )]
    Order {
        /// The link.
        link: String,
        /// Its parent index.
        parent: Option<usize>,
    },
    /// A name that not every format can hold.
    #[error("{}", names::brief(.0))]
    Name(String),
    /// A number that is NaN or infinite.
    #[error("link `{0}` has a number that is not finite")]
    NotFinite(String),
    /// A length that not every format can hold.
    #[error("link `{link}` has a length of {length_m:e} m; it must be at most {FARTHEST:e} m")]
    Far {
        /// The link.
        link: String,
        /// Length found, m.
        length_m: f64,
    },
    /// A joint axis that is not a unit vector.
    #[error("the joint axis of `{link}` has length {length}; it must be 1")]
    Axis {
        /// The link.
        link: String,
        /// Length found.
        length: f64,
    },
    /// Limits that are reversed, empty or of the wrong kind.
    #[error(
        "the limits of `{link}` run from {lo_deg}° to {hi_deg}°; the lower must be below the upper, both within ±{bound_deg}°"
    )]
    Limits {
        /// The link.
        link: String,
        /// Lower end, degrees.
        lo_deg: f64,
        /// Upper end, degrees.
        hi_deg: f64,
        /// Largest allowed magnitude, degrees.
        bound_deg: f64,
    },
    /// Limits that do not fit the joint.
    #[error(
        "the limits of `{0}` do not fit its joint: a hinge or slide takes one range, a ball takes two swings and a twist"
    )]
    LimitKind(String),
    /// A site or limb that names a missing link.
    #[error("`{0}` names a link that does not exist")]
    Reference(String),
}

/// A checked tree of links with its layout. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Skeleton {
    links: Vec<Link>,
    sites: Vec<Site>,
    limbs: Vec<Limb>,
    parts: BTreeMap<String, Vec<usize>>,
    q_at: Vec<usize>,
    v_at: Vec<usize>,
    nq: usize,
    nv: usize,
}

impl Skeleton {
    /// Checks the tree and computes its layout.
    ///
    /// # Errors
    /// See [`SkeletonError`]; the first fault found is reported.
    pub fn new(links: Vec<Link>) -> Result<Self, SkeletonError> {
        if links.is_empty() {
            return Err(SkeletonError::Empty);
        }
        let mut names = std::collections::HashSet::new();
        for (i, link) in links.iter().enumerate() {
            if !names.insert(link.name.as_str()) {
                return Err(SkeletonError::DuplicateName(link.name.clone()));
            }
            if link.parent.is_none() != (i == 0) || link.parent.is_some_and(|p| p >= i) {
                return Err(SkeletonError::Order { link: link.name.clone(), parent: link.parent });
            }
            check_link(link)?;
        }
        let (mut q_at, mut v_at) = (Vec::new(), Vec::new());
        let (mut nq, mut nv) = (0, 0);
        for link in &links {
            q_at.push(nq);
            v_at.push(nv);
            nq += link.joint.nq();
            nv += link.joint.nv();
        }
        Ok(Self { links, sites: Vec::new(), limbs: Vec::new(), parts: BTreeMap::new(), q_at, v_at, nq, nv })
    }

    /// Adds named points.
    ///
    /// # Errors
    /// A duplicate name or a missing link.
    pub fn with_sites(mut self, sites: Vec<Site>) -> Result<Self, SkeletonError> {
        let mut names = std::collections::HashSet::new();
        for site in &sites {
            check_name(&site.name)?;
            if site.link >= self.links.len() {
                return Err(SkeletonError::Reference(site.name.clone()));
            }
            if !names.insert(site.name.as_str()) {
                return Err(SkeletonError::DuplicateName(site.name.clone()));
            }
        }
        self.sites = sites;
        Ok(self)
    }

    /// Adds two-bone limbs, and a body part of each limb's name.
    ///
    /// # Errors
    /// A missing link.
    pub fn with_limbs(mut self, limbs: Vec<Limb>) -> Result<Self, SkeletonError> {
        for limb in &limbs {
            if limb.links().iter().any(|&l| l >= self.links.len()) {
                return Err(SkeletonError::Reference(limb.name.clone()));
            }
            self.parts.insert(limb.name.clone(), limb.links().to_vec());
        }
        self.limbs = limbs;
        Ok(self)
    }

    /// Adds named body parts: sets of links, in ascending order.
    ///
    /// # Errors
    /// A missing link.
    pub fn with_parts(mut self, parts: BTreeMap<String, Vec<usize>>) -> Result<Self, SkeletonError> {
        for (name, links) in parts {
            if links.iter().any(|&l| l >= self.links.len()) {
                return Err(SkeletonError::Reference(name));
            }
            self.parts.insert(name, links);
        }
        Ok(self)
    }

    /// The links, parents first.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// Named points.
    pub fn sites(&self) -> &[Site] {
        &self.sites
    }

    /// Two-bone limbs.
    pub fn limbs(&self) -> &[Limb] {
        &self.limbs
    }

    /// Body parts by name, each a set of links.
    pub fn parts(&self) -> &BTreeMap<String, Vec<usize>> {
        &self.parts
    }

    /// Length of a pose vector.
    pub fn nq(&self) -> usize {
        self.nq
    }

    /// Length of a velocity vector: the degrees of freedom, root included.
    pub fn nv(&self) -> usize {
        self.nv
    }

    /// Names of the entries of `v` (`nv`): the link's name, with `.tx`, `.rx` and the like where a joint has several degrees
    /// of freedom.
    pub fn dof_names(&self) -> Vec<String> {
        let several = |name: &str, axes: &[&str]| axes.iter().map(|a| format!("{name}.{a}")).collect();
        self.links
            .iter()
            .flat_map(|l| match l.joint {
                Joint::Free => several(&l.name, &["tx", "ty", "tz", "rx", "ry", "rz"]),
                Joint::Spherical => several(&l.name, &["rx", "ry", "rz"]),
                Joint::Revolute(_) | Joint::Prismatic(_) => vec![l.name.clone()],
                Joint::Fixed => Vec::new(),
            })
            .collect()
    }

    /// Where the joint value of `link` starts in a pose vector.
    pub fn q_at(&self, link: usize) -> usize {
        self.q_at[link]
    }

    /// Where the joint velocity of `link` starts in a velocity vector.
    pub fn v_at(&self, link: usize) -> usize {
        self.v_at[link]
    }

    /// Index of the link with this name.
    pub fn link(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|l| l.name == name)
    }

    /// A link and all that carry it, up to the root.
    pub fn ancestors(&self, link: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(link), |&l| self.links[l].parent)
    }

    /// The link that moves with `link` as one rigid body and is nearest to the root: itself unless it is `Fixed` to a parent.
    pub fn welded_to(&self, link: usize) -> usize {
        let mut at = link;
        while let (Joint::Fixed, Some(parent)) = (self.links[at].joint, self.links[at].parent) {
            at = parent;
        }
        at
    }

    /// The site with this name.
    pub fn site(&self, name: &str) -> Option<&Site> {
        self.sites.iter().find(|s| s.name == name)
    }

    /// The limb with this name.
    pub fn limb(&self, name: &str) -> Option<&Limb> {
        self.limbs.iter().find(|l| l.name == name)
    }

    /// Pose in which every joint value is zero.
    pub fn zero_pose(&self) -> Vec<f64> {
        let mut q = vec![0.0; self.nq];
        for (i, link) in self.links.iter().enumerate() {
            match link.joint {
                Joint::Free => q[self.q_at[i] + 3] = 1.0,
                Joint::Spherical => q[self.q_at[i]] = 1.0,
                _ => {}
            }
        }
        q
    }

    /// Rotation of a `Free` or `Spherical` joint in the pose `q`; identity-based angle for hinges.
    pub fn rotation(&self, q: &[f64], link: usize) -> Quat {
        let at = self.q_at[link];
        match self.links[link].joint {
            Joint::Free => quat_at(q, at + 3),
            Joint::Spherical => quat_at(q, at),
            Joint::Revolute(axis) => exp(&(axis * q[at])),
            Joint::Prismatic(_) | Joint::Fixed => Quat::identity(),
        }
    }

    /// Writes the rotation of a `Free` or `Spherical` joint into the pose `q`.
    ///
    /// # Panics
    /// For other joints.
    pub fn set_rotation(&self, q: &mut [f64], link: usize, r: &Quat) {
        let at = match self.links[link].joint {
            Joint::Free => self.q_at[link] + 3,
            Joint::Spherical => self.q_at[link],
            _ => panic!("{} has no rotation", self.links[link].name),
        };
        q[at..at + 4].copy_from_slice(&[r.w, r.i, r.j, r.k]);
    }

    /// Position of a `Free` joint in the pose `q`, m.
    pub fn position(&self, q: &[f64], link: usize) -> Vec3 {
        let at = self.q_at[link];
        Vec3::new(q[at], q[at + 1], q[at + 2])
    }

    /// Writes the position (m) of a `Free` joint into the pose `q`.
    pub fn set_position(&self, q: &mut [f64], link: usize, p: &Vec3) {
        let at = self.q_at[link];
        q[at..at + 3].copy_from_slice(p.as_slice());
    }

    /// Transform of the joint alone: `zero_from_link` in the pose `q`.
    pub fn joint_transform(&self, q: &[f64], link: usize) -> Transform {
        let at = self.q_at[link];
        let translation = match self.links[link].joint {
            Joint::Free => self.position(q, link),
            Joint::Prismatic(axis) => axis * q[at],
            _ => Vec3::zeros(),
        };
        Transform::from_parts(Translation3::from(translation), self.rotation(q, link))
    }

    /// Moves every limited joint of `q` to the nearest allowed value; returns whether any moved.
    pub fn clamp_to_limits(&self, q: &mut [f64]) -> bool {
        let mut moved = false;
        for (i, link) in self.links.iter().enumerate() {
            match (&link.limits, link.joint) {
                (Some(Limits::Axis(range)), Joint::Revolute(_) | Joint::Prismatic(_)) => {
                    let x = &mut q[self.q_at[i]];
                    if !range.contains(*x) {
                        *x = range.clamp(*x);
                        moved = true;
                    }
                }
                (Some(Limits::Ball(limits)), Joint::Spherical) => {
                    let r = self.rotation(q, i);
                    let c = limits.clamp(&r);
                    if c != r {
                        self.set_rotation(q, i, &c);
                        moved = true;
                    }
                }
                _ => {}
            }
        }
        moved
    }

    /// Velocity `v` that carries `q0` to `q1` in `dt` seconds: `q1 = q0 ⊕ v dt`.
    pub fn difference(&self, q0: &[f64], q1: &[f64], dt: f64, v: &mut [f64]) {
        for (i, link) in self.links.iter().enumerate() {
            let (a, b) = (self.q_at[i], self.v_at[i]);
            let turn = |from: usize| log(&(quat_at(q1, from) * quat_at(q0, from).inverse())) / dt;
            match link.joint {
                Joint::Free => {
                    for k in 0..3 {
                        v[b + k] = (q1[a + k] - q0[a + k]) / dt;
                    }
                    v[b + 3..b + 6].copy_from_slice(turn(a + 3).as_slice());
                }
                Joint::Spherical => v[b..b + 3].copy_from_slice(turn(a).as_slice()),
                Joint::Revolute(_) | Joint::Prismatic(_) => v[b] = (q1[a] - q0[a]) / dt,
                Joint::Fixed => {}
            }
        }
    }

    /// Moves the pose `q` by the velocity `v` for `dt` seconds, in place: `q ⊕ v dt`.
    pub fn integrate(&self, q: &mut [f64], v: &[f64], dt: f64) {
        for (i, link) in self.links.iter().enumerate() {
            let (a, b) = (self.q_at[i], self.v_at[i]);
            match link.joint {
                Joint::Free => {
                    for k in 0..3 {
                        q[a + k] += v[b + k] * dt;
                    }
                    let r = exp(&(vec_at(v, b + 3) * dt)) * quat_at(q, a + 3);
                    self.set_rotation(q, i, &r);
                }
                Joint::Spherical => {
                    let r = exp(&(vec_at(v, b) * dt)) * quat_at(q, a);
                    self.set_rotation(q, i, &r);
                }
                Joint::Revolute(_) | Joint::Prismatic(_) => q[a] += v[b] * dt,
                Joint::Fixed => {}
            }
        }
    }

    /// Pose between `q0` (s = 0) and `q1` (s = 1): linear for scalars, slerp for rotations.
    pub fn interpolate(&self, q0: &[f64], q1: &[f64], s: f64, out: &mut [f64]) {
        if s == 0.0 {
            out.copy_from_slice(q0);
            return;
        }
        for k in 0..self.nq {
            out[k] = q0[k] + (q1[k] - q0[k]) * s;
        }
        for (i, link) in self.links.iter().enumerate() {
            let at = match link.joint {
                Joint::Free => self.q_at[i] + 3,
                Joint::Spherical => self.q_at[i],
                _ => continue,
            };
            let r = crate::rotation::slerp(&quat_at(q0, at), &quat_at(q1, at), s);
            self.set_rotation(out, i, &r);
        }
    }
}

/// The quaternion stored `w x y z` at `at`, taken as it is (poses hold unit quaternions).
pub fn quat_at(q: &[f64], at: usize) -> Quat {
    Quat::new_unchecked(Quaternion::new(q[at], q[at + 1], q[at + 2], q[at + 3]))
}

/// The 3-vector stored at `at`.
pub fn vec_at(v: &[f64], at: usize) -> Vec3 {
    Vec3::new(v[at], v[at + 1], v[at + 2])
}

fn check_name(name: &str) -> Result<(), SkeletonError> {
    names::check(name).map_err(SkeletonError::Name)
}

fn check_link(link: &Link) -> Result<(), SkeletonError> {
    check_name(&link.name)?;
    let t = &link.parent_from_zero;
    let end = link.end.unwrap_or_default();
    let numbers = t.translation.vector.iter().chain(t.rotation.coords.iter()).chain(end.iter());
    if !numbers.copied().all(f64::is_finite) {
        return Err(SkeletonError::NotFinite(link.name.clone()));
    }
    let length_m = t.translation.vector.amax().max(end.amax());
    if length_m > FARTHEST {
        return Err(SkeletonError::Far { link: link.name.clone(), length_m });
    }
    if let Joint::Revolute(axis) | Joint::Prismatic(axis) = link.joint {
        let length = axis.norm();
        if (length - 1.0).abs() > 1e-9 || !length.is_finite() {
            return Err(SkeletonError::Axis { link: link.name.clone(), length });
        }
    }
    let check = |r: &Range, bound: f64| {
        if r.lo < r.hi && r.lo >= -bound && r.hi <= bound {
            Ok(())
        } else {
            Err(SkeletonError::Limits {
                link: link.name.clone(),
                lo_deg: r.lo.to_degrees(),
                hi_deg: r.hi.to_degrees(),
                bound_deg: bound.to_degrees(),
            })
        }
    };
    match (&link.limits, link.joint) {
        (None, _) => Ok(()),
        (Some(Limits::Axis(r)), Joint::Revolute(_) | Joint::Prismatic(_)) => check(r, 1e4),
        (Some(Limits::Ball(b)), Joint::Spherical) => {
            b.ranges.iter().try_for_each(|r| check(r, std::f64::consts::PI))
        }
        _ => Err(SkeletonError::LimitKind(link.name.clone())),
    }
}
