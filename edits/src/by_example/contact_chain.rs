//! Corrections of a blended edit as poses, and the axes that they move points about.
//!
//! In: the source, the blended result, its differences ([`super::outputs`]) and for every frame a correction. Out: the
//! pose with the correction, transforms of the links concerned, and for every number of the correction the axis that it turns about or
//! slides along (∂point/∂number, exact).
//!
//! A correction has, for each frame, in this order:
//!
//! | numbers | meaning | added to |
//! |---|---|---|
//! | lean, 3 | in the rotation vector of the root's tilt, rad | the tilt's difference |
//! | height | sizes | the height's difference |
//! | turn | about the vertical, rad | the heading |
//! | x, z | of the root, world axes, sizes | its place |
//! | joints | as in the differences: rad, sizes | those of the joints between the root and a contact |
//!
//! What the place of the edit does not allow is left out, and so are joints that are between the root and no contact. Heading
//! and place are those of the frame itself, where differences have steps.

use motion::ik::Axis;
use motion::rotation::{Quat, Vec3, exp, exp_rate};
use motion::{Clip, Joint, Kinematics, Skeleton};
use nalgebra::DMatrix;

use super::Rig;
use super::outputs::{self, Allowed, Smooth};
use super::rig::Moves;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Ball,
    Axis,
    Lean,
    Height,
    Turn,
    Ground,
}

impl Kind {
    fn width(self) -> usize {
        match self {
            Self::Ball | Self::Lean => 3,
            Self::Ground => 2,
            Self::Axis | Self::Height | Self::Turn => 1,
        }
    }
}

/// What a number of a correction belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Owner {
    Joint,
    /// The root's lean and height.
    Root,
    /// The root's heading and place, of which differences have steps.
    Path,
}

/// Some numbers of a correction.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Mover {
    kind: Kind,
    link: usize,
    /// Its number among the rig's joints; 0 of what the root does.
    joint: usize,
    /// First of its numbers.
    at: usize,
    /// First of its columns in the differences; none of those that differences have as steps.
    column: usize,
}

/// What corrections move. See the module header.
#[derive(Clone, Debug)]
pub(super) struct Chain<'a> {
    rig: &'a Rig,
    source: &'a Clip,
    free: &'a Clip,
    differences: &'a DMatrix<f64>,
    smooth: Smooth,
    movers: Vec<Mover>,
    /// Links whose transforms are needed, parents first.
    links: Vec<usize>,
    /// Numbers of a frame.
    pub(super) width: usize,
}

impl<'a> Chain<'a> {
    /// The chain from the root to the links `ends`. `free` is the result without contacts: `source` with `differences`.
    pub(super) fn new(
        rig: &'a Rig,
        source: &'a Clip,
        free: &'a Clip,
        differences: &'a DMatrix<f64>,
        allowed: &Allowed,
        ends: &[usize],
    ) -> Self {
        let s = rig.skeleton();
        let mut needed = vec![false; s.links().len()];
        ends.iter().flat_map(|&end| s.ancestors(end)).for_each(|l| needed[l] = true);
        needed[0] = true;
        let mut chain = Self {
            rig,
            source,
            free,
            differences,
            smooth: Smooth::of(rig, source),
            movers: Vec::new(),
            links: (0..needed.len()).filter(|&l| needed[l]).collect(),
            width: 0,
        };
        let root = outputs::root_columns(rig);
        for (may, kind, column) in [
            (allowed.tilt, Kind::Lean, root.tilt),
            (allowed.height, Kind::Height, root.height),
            (allowed.steps, Kind::Turn, 0),
            (allowed.steps, Kind::Ground, 0),
        ] {
            if may {
                chain.push(kind, (0, 0), column);
            }
        }
        let mut column = 0;
        for (joint, (&(link, moves), &may)) in rig.joints().iter().zip(&allowed.joints).enumerate() {
            let kind = match (moves, s.links()[link].joint) {
                (Moves::Ball, Joint::Spherical | Joint::Free | Joint::Revolute(_)) => Some(Kind::Ball),
                (Moves::Axis, Joint::Revolute(_) | Joint::Prismatic(_)) => Some(Kind::Axis),
                _ => None,
            };
            if let Some(kind) = kind.filter(|_| may && needed[link]) {
                chain.push(kind, (link, joint), column);
            }
            column += moves.width();
        }
        chain
    }

    fn push(&mut self, kind: Kind, (link, joint): (usize, usize), column: usize) {
        self.movers.push(Mover { kind, link, joint, at: self.width, column });
        self.width += kind.width();
    }

    fn skeleton(&self) -> &Skeleton {
        self.rig.skeleton()
    }

    /// For each number what it belongs to.
    pub(super) fn owners(&self) -> Vec<Owner> {
        let owner = |m: &Mover| match m.kind {
            Kind::Turn | Kind::Ground => Owner::Path,
            Kind::Lean | Kind::Height => Owner::Root,
            Kind::Ball | Kind::Axis => Owner::Joint,
        };
        self.movers.iter().flat_map(|m| std::iter::repeat_n(owner(m), m.kind.width())).collect()
    }

    /// The numbers that move a link.
    pub(super) fn moving(&self, link: usize) -> Vec<usize> {
        let carries = |m: &&Mover| self.skeleton().ancestors(link).any(|l| l == m.link);
        self.movers.iter().filter(carries).flat_map(|m| m.at..m.at + m.kind.width()).collect()
    }

    fn turn(&self, f: usize, m: &Mover) -> Vec3 {
        Vec3::from_fn(|i, _| self.differences[(f, m.column + i)])
    }

    /// Writes the pose of frame `f` with the correction `c` (`width`); the blended one, to the bit, where `c` is zero.
    pub(super) fn pose(&self, f: usize, c: &[f64], q: &mut [f64]) {
        let s = self.skeleton();
        q.copy_from_slice(self.free.pose(f));
        let (mut lean, mut yaw, mut way) = (None, 0.0, Vec3::zeros());
        for m in &self.movers {
            let own = &c[m.at..m.at + m.kind.width()];
            if own.iter().all(|x| *x == 0.0) {
                continue;
            }
            match (m.kind, s.links()[m.link].joint) {
                (Kind::Ball, Joint::Revolute(axis)) => {
                    let own = self.rig.axes_from_link(m.link).inverse() * Vec3::from_column_slice(own);
                    q[s.q_at(m.link)] += own.dot(&axis);
                }
                (Kind::Ball, _) => {
                    let turn = self.turn(f, m) + Vec3::from_column_slice(own);
                    let turn = self.rig.axes_from_link(m.link).inverse() * turn;
                    let source = s.rotation(self.source.pose(f), m.link);
                    let r = self.smooth.turned(f, m.joint, &source, &turn);
                    s.set_rotation(q, m.link, &r);
                }
                (Kind::Axis, Joint::Prismatic(_)) => q[s.q_at(m.link)] += own[0] * self.rig.size_m,
                (Kind::Axis, _) => q[s.q_at(m.link)] += own[0],
                (Kind::Lean, _) => lean = Some((self.turn(f, m), Vec3::from_column_slice(own))),
                (Kind::Height, _) => way.y = own[0] * self.rig.size_m,
                (Kind::Turn, _) => yaw = own[0],
                (Kind::Ground, _) => {
                    (way.x, way.z) = (own[0] * self.rig.size_m, own[1] * self.rig.size_m);
                }
            }
        }
        let world_from_zero = s.links()[0].parent_from_zero.rotation;
        if lean.is_some() || yaw != 0.0 {
            let mut world = world_from_zero * s.rotation(q, 0);
            if let Some((was, more)) = lean {
                let axes = self.rig.axes_from_link(0);
                world = world * axes.inverse() * exp(&-was) * exp(&(was + more)) * axes;
            }
            world = Quat::from_axis_angle(&Vec3::y_axis(), yaw) * world;
            s.set_rotation(q, 0, &(world_from_zero.inverse() * world));
        }
        if way != Vec3::zeros() {
            let at = s.position(q, 0) + world_from_zero.inverse() * way;
            s.set_position(q, 0, &at);
        }
    }

    /// Transforms of the links concerned in the pose `q`.
    pub(super) fn update(&self, q: &[f64], k: &mut Kinematics) {
        let s = self.skeleton();
        for &i in &self.links {
            let link = &s.links()[i];
            let local = link.parent_from_zero * s.joint_transform(q, i);
            k.world[i] = link.parent.map_or(local, |p| k.world[p] * local);
        }
    }

    /// The axis of each number of the correction `c` of frame `f`, whose pose `k` is of.
    pub(super) fn axes(&self, f: usize, c: &[f64], k: &Kinematics, out: &mut [Axis]) {
        let s = self.skeleton();
        let none = Vec3::zeros();
        for m in &self.movers {
            let origin = k.origin(m.link);
            let world = k.world[m.link].rotation;
            let out = &mut out[m.at..m.at + m.kind.width()];
            let slide = |linear: Vec3| Axis { linear: linear * self.rig.size_m, angular: none, origin };
            match (m.kind, s.links()[m.link].joint) {
                (Kind::Ball, Joint::Revolute(axis)) => {
                    let share = self.rig.axes_from_link(m.link) * axis;
                    for (i, out) in out.iter_mut().enumerate() {
                        *out = Axis { linear: none, angular: world * axis * share[i], origin };
                    }
                }
                (Kind::Ball | Kind::Lean, _) => {
                    let turn = self.turn(f, m) + Vec3::from_column_slice(&c[m.at..m.at + 3]);
                    // the root's lean comes before the change from body axes to its own, a joint's turn after: the same
                    let axes = self.rig.axes_from_link(m.link).inverse();
                    let turn = axes * turn;
                    let before = match m.kind {
                        Kind::Lean => world * exp(&-turn),
                        _ => {
                            let source = s.rotation(self.source.pose(f), m.link);
                            let smooth = self.smooth.at(f, m.joint);
                            world * source.inverse() * smooth * exp(&-turn)
                        }
                    };
                    for (i, out) in out.iter_mut().enumerate() {
                        let mut unit = none;
                        unit[i] = 1.0;
                        let angular = before * exp_rate(&turn, &(axes * unit));
                        *out = Axis { linear: none, angular, origin };
                    }
                }
                (Kind::Axis, Joint::Prismatic(axis)) => out[0] = slide(world * axis),
                (Kind::Axis, Joint::Revolute(axis)) => {
                    out[0] = Axis { linear: none, angular: world * axis, origin };
                }
                (Kind::Axis, _) => out[0] = Axis::default(),
                (Kind::Height, _) => out[0] = slide(Vec3::y()),
                (Kind::Turn, _) => out[0] = Axis { linear: none, angular: Vec3::y(), origin },
                (Kind::Ground, _) => (out[0], out[1]) = (slide(Vec3::x()), slide(Vec3::z())),
            }
        }
    }
}
