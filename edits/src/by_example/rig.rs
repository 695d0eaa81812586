//! A skeleton as edits by example see it: named points, named joints, a heading, left and right.
//!
//! In: a skeleton. Out: a [`Rig`]: what features are made of and what is predicted, in a frame of the body that does not
//! depend on where it is and which way it faces; and a [`RigFile`], what a model remembers of the rig it was taught on,
//! so that it finds the same points and joints by their names in another skeleton of the same kind.
//!
//! Frames. *Body axes*: y up, x the lateral direction of the zero pose (world x where the body has no left and right). A
//! link's rotation away from the zero pose is `W`, in body axes; the *heading* of a pose is the part of the root's `W` about y
//! (swing and twist). The *heading frame* has its origin at the root and is turned by the heading only.
//!
//! Units: m; lengths of features are in parts of the body's size ([`motion::symmetry::size_m`]), so that a tall and a
//! small person of the same rig are alike.

use std::sync::Arc;

use motion::rotation::{Quat, Vec3, swing_twist};
use motion::symmetry::{Symmetry, size_m};
use motion::{Clip, Joint, Kinematics, Skeleton};
use serde::{Deserialize, Serialize};

use super::ExampleError;

/// Bones of the zero pose may point this far apart in two skeletons that are one rig, rad.
pub const SAME_ZERO_RAD: f64 = 0.35;

/// What moves at one joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Moves {
    /// A ball: three numbers, the rotation vector of the difference in body axes.
    Ball,
    /// A hinge (rad) or a slide (in parts of the size): one number.
    Axis,
}

impl Moves {
    /// Numbers it takes.
    pub fn width(self) -> usize {
        match self {
            Self::Ball => 3,
            Self::Axis => 1,
        }
    }
}

/// In which axes the difference of a ball is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Axes {
    /// The joint's own, means over 0.125 s: an edit that goes with the limb.
    #[default]
    Joint,
    /// Those of the link before it: an edit that the pose of the limb does not turn.
    Parent,
}

/// A point of the body whose place is a feature.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointName {
    /// Its link.
    pub link: String,
    /// Whether it is the link's end (of a bone without children), or its joint.
    pub end: bool,
    /// Where it is from its parent point in the zero pose, body axes, in parts of the size.
    pub from_parent: [f64; 3],
}

/// What a model remembers of the rig it was taught on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigFile {
    /// The points of the features, in their order.
    pub points: Vec<PointName>,
    /// The joints predicted, in their order.
    pub joints: Vec<(String, Moves)>,
    /// Size of the skeleton taught on, m.
    pub size_m: f64,
    /// In which axes differences are.
    pub axes: Axes,
}

#[derive(Clone, Debug, PartialEq)]
struct Point {
    link: usize,
    /// In the link's frame, m.
    at: Vec3,
}

/// A skeleton with the points and joints of a model. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    skeleton: Arc<Skeleton>,
    /// Size, m.
    pub size_m: f64,
    /// From world to body axes, of the zero pose.
    axes_from_world: Quat,
    /// From each link's frame to body axes, of the zero pose.
    zero: Vec<Quat>,
    points: Vec<Point>,
    joints: Vec<(usize, Moves)>,
    file: RigFile,
    /// Partner of every point and of every joint; `None` without left and right.
    mirror: Option<(Vec<usize>, Vec<usize>)>,
}

/// Signed permutation: entry `i` of the mirrored vector is `sign ×` entry `index`.
pub type Signed = Vec<(usize, f64)>;

impl Rig {
    /// The rig of a skeleton: all its joints, and all points that move.
    ///
    /// # Errors
    /// [`ExampleError::NothingMoves`]; [`ExampleError::Root`]: a root that cannot move.
    pub fn of(skeleton: &Arc<Skeleton>) -> Result<Self, ExampleError> {
        Self::build(skeleton, None)
    }

    /// The rig of a model, found in another skeleton by the names of its points and joints.
    ///
    /// # Errors
    /// [`ExampleError::OtherRig`]: a point or joint that is not there, or bones that point elsewhere in the zero pose.
    pub fn find(file: &RigFile, skeleton: &Arc<Skeleton>) -> Result<Self, ExampleError> {
        Self::build(skeleton, Some(file))
    }

    fn build(skeleton: &Arc<Skeleton>, file: Option<&RigFile>) -> Result<Self, ExampleError> {
        let s = skeleton.as_ref();
        if s.links()[0].joint != Joint::Free {
            return Err(ExampleError::Root { link: s.links()[0].name.clone() });
        }
        let symmetry = Symmetry::of(s).ok();
        let lateral = symmetry.as_ref().map_or(Vec3::x(), |s| s.lateral);
        let axes_from_world = Quat::from_axis_angle(&Vec3::y_axis(), lateral.z.atan2(lateral.x));
        let k = Kinematics::new(s, &s.zero_pose());
        let zero: Vec<Quat> = k.world.iter().map(|w| axes_from_world * w.rotation).collect();
        let size = size_m(s);
        let mut rig = Self {
            skeleton: skeleton.clone(),
            size_m: size,
            axes_from_world,
            zero,
            points: Vec::new(),
            joints: Vec::new(),
            file: RigFile { points: Vec::new(), joints: Vec::new(), size_m: size, axes: Axes::default() },
            mirror: None,
        };
        let every = rig.everything(&k);
        rig.file = match file {
            None => every,
            Some(file) => {
                rig.agrees(file, &every)?;
                file.clone()
            }
        };
        let link = |name: &str| s.link(name).unwrap_or_default();
        rig.points = rig
            .file
            .points
            .iter()
            .map(|p| {
                let link = link(&p.link);
                let at = if p.end { s.links()[link].end.unwrap_or_default() } else { Vec3::zeros() };
                Point { link, at }
            })
            .collect();
        rig.joints = rig.file.joints.iter().map(|(name, moves)| (link(name), *moves)).collect();
        if rig.joints.is_empty() || rig.points.is_empty() {
            return Err(ExampleError::NothingMoves);
        }
        rig.mirror = symmetry.and_then(|s| rig.partners(&s));
        Ok(rig)
    }

    /// All points and joints of the skeleton.
    fn everything(&self, k: &Kinematics) -> RigFile {
        let s = &self.skeleton;
        let mut file =
            RigFile { points: Vec::new(), joints: Vec::new(), size_m: self.size_m, axes: Axes::default() };
        let small = 1e-6 * self.size_m;
        let named = |from: Vec3| (self.axes_from_world * from / self.size_m).into();
        for (i, link) in s.links().iter().enumerate().skip(1) {
            let parent = link.parent.unwrap_or_default();
            let from = k.origin(i) - k.origin(parent);
            if from.norm() > small || matches!(link.joint, Joint::Prismatic(_)) {
                let from_parent = named(from);
                file.points.push(PointName { link: link.name.clone(), end: false, from_parent });
            }
            if let Some(end) = link.end.filter(|e| e.norm() > small && link.joint != Joint::Fixed) {
                let from_parent = named(k.point(i, &end) - k.origin(i));
                file.points.push(PointName { link: link.name.clone(), end: true, from_parent });
            }
            match link.joint {
                Joint::Spherical | Joint::Free => file.joints.push((link.name.clone(), Moves::Ball)),
                Joint::Revolute(_) | Joint::Prismatic(_) => {
                    file.joints.push((link.name.clone(), Moves::Axis))
                }
                Joint::Fixed => {}
            }
        }
        file
    }

    /// Whether a skeleton with these points and joints is one that the model knows.
    fn agrees(&self, file: &RigFile, every: &RigFile) -> Result<(), ExampleError> {
        let fault = |what: String| Err(ExampleError::OtherRig { what });
        for p in &file.points {
            let found = every.points.iter().find(|q| q.link == p.link && q.end == p.end);
            let Some(found) = found else {
                // a welded end has no point of its own: where it is follows from its parent
                let named = self.skeleton.link(&p.link);
                if named.is_some_and(|i| !p.end || self.skeleton.links()[i].end.is_some()) {
                    continue;
                }
                let what = if p.end { "the end of the bone" } else { "the joint" };
                return fault(format!("it has no `{}` ({what})", p.link));
            };
            let (a, b) = (Vec3::from(p.from_parent), Vec3::from(found.from_parent));
            let apart = a.angle(&b);
            if a.norm() > 0.02 && b.norm() > 0.02 && apart > SAME_ZERO_RAD {
                return fault(format!(
                    "its bone to `{}` points {:.0}° elsewhere in the zero pose (allowed: {:.0}°)",
                    p.link,
                    apart.to_degrees(),
                    SAME_ZERO_RAD.to_degrees()
                ));
            }
        }
        for (name, moves) in &file.joints {
            let Some(i) = self.skeleton.link(name) else {
                return fault(format!("it has no joint `{name}`"));
            };
            let fits = match self.skeleton.links()[i].joint {
                Joint::Spherical | Joint::Free => *moves == Moves::Ball,
                Joint::Revolute(_) => true,
                Joint::Prismatic(_) => *moves == Moves::Axis,
                // welded: nothing to predict, and said when the edit is applied
                Joint::Fixed => true,
            };
            if !fits {
                return fault(format!("its joint `{name}` moves otherwise"));
            }
        }
        Ok(())
    }

    /// Partners of points and joints, where all of them have one.
    fn partners(&self, symmetry: &Symmetry) -> Option<(Vec<usize>, Vec<usize>)> {
        let point = |p: &Point| {
            let mirror = symmetry.partner[p.link];
            let end = p.at != Vec3::zeros();
            self.points.iter().position(|q| q.link == mirror && (q.at != Vec3::zeros()) == end)
        };
        let joint = |(link, moves): &(usize, Moves)| {
            let mirror = symmetry.partner[*link];
            self.joints.iter().position(|q| *q == (mirror, *moves))
        };
        let points: Option<Vec<usize>> = self.points.iter().map(point).collect();
        let joints: Option<Vec<usize>> = self.joints.iter().map(joint).collect();
        Some((points?, joints?))
    }

    /// What a model remembers of it.
    pub fn file(&self) -> &RigFile {
        &self.file
    }

    /// In which axes differences are: the joints' own, unless the model says otherwise.
    pub fn axes(&self) -> Axes {
        self.file.axes
    }

    /// The same rig with differences in other axes.
    pub fn with_axes(mut self, axes: Axes) -> Self {
        self.file.axes = axes;
        self
    }

    /// The skeleton.
    pub fn skeleton(&self) -> &Arc<Skeleton> {
        &self.skeleton
    }

    /// Links of the joints predicted, with what moves there.
    pub fn joints(&self) -> &[(usize, Moves)] {
        &self.joints
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.points.len()
    }

    /// Whether the body has a left and a right.
    pub fn is_symmetric(&self) -> bool {
        self.mirror.is_some()
    }

    /// From a link's frame to body axes, of the zero pose.
    pub fn axes_from_link(&self, link: usize) -> Quat {
        self.zero[link]
    }

    /// Heading of a pose whose root has this world rotation: a rotation about y, world from heading frame.
    pub fn heading(&self, world_from_root: &Quat) -> Quat {
        swing_twist(&(world_from_root * self.zero[0].inverse()), &Vec3::y()).1
    }

    /// World places of the root and then of all points, `frames × (1 + points)`, m.
    pub fn places(&self, clip: &Clip) -> Vec<Vec3> {
        let mut k = Kinematics::new(&self.skeleton, clip.pose(0));
        let mut out = Vec::with_capacity(clip.frames() * (1 + self.points.len()));
        for frame in 0..clip.frames() {
            k.update(&self.skeleton, clip.pose(frame));
            out.push(k.origin(0));
            out.extend(self.points.iter().map(|p| k.point(p.link, &p.at)));
        }
        out
    }

    /// World rotations of the root, one a frame.
    pub fn root_rotations(&self, clip: &Clip) -> Vec<Quat> {
        let zero = self.skeleton.links()[0].parent_from_zero.rotation;
        (0..clip.frames()).map(|f| zero * self.skeleton.rotation(clip.pose(f), 0)).collect()
    }

    /// How positions of `count` groups of (root and points), or of points alone, are mirrored: x turns its sign.
    pub(super) fn mirror_points(&self, groups: &[bool]) -> Option<Signed> {
        let (points, _) = self.mirror.as_ref()?;
        let mut out = Signed::new();
        for with_root in groups {
            let at = out.len();
            let root = usize::from(*with_root);
            let order = (0..root).chain(points.iter().map(|p| p + root));
            for p in order {
                out.extend([(at + 3 * p, -1.0), (at + 3 * p + 1, 1.0), (at + 3 * p + 2, 1.0)]);
            }
        }
        Some(out)
    }

    /// How joint differences are mirrored: rotation vectors keep x and turn y and z round.
    pub(super) fn mirror_joints(&self) -> Option<Signed> {
        let (_, joints) = self.mirror.as_ref()?;
        let starts: Vec<usize> = self
            .joints
            .iter()
            .scan(0, |at, (_, moves)| {
                let start = *at;
                *at += moves.width();
                Some(start)
            })
            .collect();
        let mut out = Signed::new();
        for (j, &p) in joints.iter().enumerate() {
            let at = starts[p];
            match self.joints[j].1 {
                Moves::Ball => out.extend([(at, 1.0), (at + 1, -1.0), (at + 2, -1.0)]),
                Moves::Axis => out.push((at, self.axis_sign(self.joints[j].0, self.joints[p].0))),
            }
        }
        Some(out)
    }

    /// Whether a hinge or slide and its partner mirror each other with the same sign.
    fn axis_sign(&self, link: usize, partner: usize) -> f64 {
        let world = |i: usize, axis: Vec3| {
            let parent = self.skeleton.links()[i].parent_from_zero.rotation;
            let from_zero = self.zero[self.skeleton.links()[i].parent.unwrap_or_default()] * parent;
            from_zero * axis
        };
        let reflected = |v: Vec3| Vec3::new(-v.x, v.y, v.z);
        match (self.skeleton.links()[link].joint, self.skeleton.links()[partner].joint) {
            (Joint::Revolute(a), Joint::Revolute(b)) => {
                (-reflected(world(link, a))).dot(&world(partner, b)).signum()
            }
            (Joint::Prismatic(a), Joint::Prismatic(b)) => {
                reflected(world(link, a)).dot(&world(partner, b)).signum()
            }
            _ => 1.0,
        }
    }
}
