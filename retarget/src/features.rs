//! Feature points: a pose as positions of points, seen from the root's local frame \[YAH10, §4.1\].
//!
//! In: a body and a pose. Out: a flat vector of positions, three numbers a point. The local frame has its
//! origin at the root's projection on the ground, its Y axis up, and its Z axis along the root's heading:
//! horizontal place and heading are taken out, height, roll and pitch stay in.
//!
//! The heading: the smallest rotation that makes the root's *up* vector vertical is applied to its *front*
//! vector; what comes out is horizontal. (The front vector projected on the ground would turn round when the
//! root leans over by more than 90°.) It is undefined only where the root stands on its head exactly.
//!
//! Human points come from the skeleton by anatomical role and from the sites a guessed body has (soles,
//! hand tips, eyes, crown), so that any human clip has the same ones, in the same order; positions are in units of the
//! performer's leg length times 0.9 m, so that performers of other size give the same numbers.
//!
//! \[YAH10\] Yamane, Ariki, Hodgins. Animating Non-Humanoid Characters with Human Motion Data, SCA 2010.

use bodies::Character;
use bodies::anthropometry::Anatomy;
use motion::rotation::between;
use motion::{Joint, Kinematics, Quat, Shape, Site, Skeleton, Transform, Vec3};

use crate::RetargetError;

/// Leg length that counts as no scaling, m: hip to ankle of the standard figure.
pub const LEG_M: f64 = 0.85925;

/// Front and up of the root, by which the local frame is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RootFrame {
    /// The root's front, a unit vector of its link frame.
    pub front: Vec3,
    /// The root's up, a unit vector of its link frame.
    pub up: Vec3,
}

impl RootFrame {
    /// The frame of a root that, in the pose `q`, stands upright and faces `front` (world, horizontal).
    pub fn of_pose(skeleton: &Skeleton, q: &[f64], front: &Vec3) -> Self {
        let link_from_world = Kinematics::new(skeleton, q).world[0].rotation.inverse();
        Self { front: link_from_world * front, up: link_from_world * Vec3::y() }
    }

    /// Heading of a root with this world rotation, rad about Y; 0 faces +Z.
    pub fn heading(&self, world_from_root: &Quat) -> f64 {
        let front = between(&(world_from_root * self.up), &Vec3::y()) * (world_from_root * self.front);
        front.x.atan2(front.z)
    }

    /// `world_from_local` of a root with this transform, over ground at the given height.
    pub fn local(&self, world_from_root: &Transform, ground_m: f64) -> Transform {
        let p = world_from_root.translation.vector;
        let turn = Quat::from_axis_angle(&Vec3::y_axis(), self.heading(&world_from_root.rotation));
        Transform::from_parts(Vec3::new(p.x, ground_m, p.z).into(), turn)
    }
}

/// The points of a body whose positions are its pose. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Features {
    /// The points.
    pub points: Vec<Site>,
    /// Front and up of the root.
    pub root: RootFrame,
    /// Length that counts as one, m.
    pub unit_m: f64,
}

impl Features {
    /// Points of a human by anatomical role: joints of trunk, head and limbs, and the sites that a guessed
    /// body has.
    ///
    /// # Errors
    /// A skeleton whose names are not human, or that lacks a site.
    pub fn anatomical(human: &Character) -> Result<Self, RetargetError> {
        let s = &human.skeleton;
        let anatomy = Anatomy::of(s)?;
        let chest = anatomy.spine[anatomy.spine.len() - 1];
        let mut points: Vec<Site> = Vec::new();
        let mut add = |name: String, link: usize, at: Vec3| points.push(Site { name, link, at });
        add("pelvis".into(), 0, Vec3::zeros());
        add("chest".into(), chest, Vec3::zeros());
        add("head".into(), anatomy.head, Vec3::zeros());
        for (side, letter) in ["l", "r"].into_iter().enumerate() {
            let arm = ["shoulder", "elbow", "wrist"].into_iter().zip(anatomy.arms[side]);
            let leg = ["hip", "knee", "ankle"].into_iter().zip(anatomy.legs[side]);
            for (joint, link) in arm.chain(leg) {
                add(format!("{joint}_{letter}"), link, Vec3::zeros());
            }
        }
        for name in ["eyes", "crown", "hand_tip_l", "hand_tip_r"] {
            let site = s.site(name).ok_or_else(|| RetargetError::marker(name, s))?;
            add(name.into(), site.link, site.at);
        }
        for &c in &human.contacts {
            let site = &s.sites()[c];
            add(site.name.clone(), site.link, site.at);
        }
        let k = Kinematics::new(s, &human.rest);
        let [l, r] = anatomy.legs;
        let left = k.origin(l[0]) - k.origin(r[0]);
        let front = Vec3::new(left.x, 0.0, left.z).normalize().cross(&Vec3::y());
        let bone = |a: usize, b: usize| (k.origin(a) - k.origin(b)).norm();
        let leg = 0.5 * [l, r].iter().map(|l| bone(l[0], l[1]) + bone(l[1], l[2])).sum::<f64>();
        Ok(Self { points, root: RootFrame::of_pose(s, &human.rest, &front), unit_m: leg / LEG_M })
    }

    /// Three virtual markers on every link that moves, and the root frame of the rest pose facing +Z.
    ///
    /// They stand on the link's own axes, as far from its origin as its shapes reach (at least 20 mm): a
    /// turn of the link then counts by how far its flesh moves. A welded link has none.
    pub fn virtual_markers(character: &Character) -> Self {
        let s = &character.skeleton;
        let mut points = Vec::new();
        for (i, link) in s.links().iter().enumerate() {
            if link.joint == Joint::Fixed && i > 0 {
                continue;
            }
            let arm = reach(&character.bodies[i].shapes).max(0.02);
            for (axis, letter) in [(Vec3::x(), 'x'), (Vec3::y(), 'y'), (Vec3::z(), 'z')] {
                points.push(Site { name: format!("{}_{letter}", link.name), link: i, at: axis * arm });
            }
        }
        Self { points, root: RootFrame::of_pose(s, &character.rest, &Vec3::z()), unit_m: 1.0 }
    }

    /// Points by name: a site, or a link for its origin.
    ///
    /// # Errors
    /// A name that is neither; the root frame's vectors are taken as given.
    pub fn named(skeleton: &Skeleton, names: &[&str], root: RootFrame) -> Result<Self, RetargetError> {
        let find = |name: &&str| {
            let site = skeleton.site(name).cloned();
            let link = || skeleton.link(name);
            site.or_else(|| Some(Site { name: name.to_string(), link: link()?, at: Vec3::zeros() }))
                .ok_or_else(|| RetargetError::marker(name, skeleton))
        };
        Ok(Self { points: names.iter().map(find).collect::<Result<_, _>>()?, root, unit_m: 1.0 })
    }

    /// Length of a feature vector.
    pub fn len(&self) -> usize {
        3 * self.points.len()
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Local positions of the points of a posed skeleton, in units of `unit_m`, into `out` (`len`).
    pub fn read(&self, k: &Kinematics, ground_m: f64, out: &mut [f64]) {
        let local_from_world = self.root.local(&k.world[0], ground_m).inverse();
        for (p, o) in self.points.iter().zip(out.chunks_exact_mut(3)) {
            let at = local_from_world * nalgebra::Point3::from(k.point(p.link, &p.at));
            o.copy_from_slice((at.coords / self.unit_m).as_slice());
        }
    }

    /// The feature vector of a pose.
    pub fn of_pose(&self, skeleton: &Skeleton, q: &[f64], ground_m: f64) -> Vec<f64> {
        let mut out = vec![0.0; self.len()];
        self.read(&Kinematics::new(skeleton, q), ground_m, &mut out);
        out
    }
}

/// Farthest point of the shapes from the link's origin, m.
fn reach(shapes: &[Shape]) -> f64 {
    let far = |s: &Shape| match *s {
        Shape::Capsule { a, b, radius } => a.norm().max(b.norm()) + radius,
        Shape::Box { center, half, .. } => center.norm() + half.norm(),
        Shape::Sphere { center, radius } => center.norm() + radius,
        Shape::Cone { .. } => s.rims().iter().map(|p| p.norm()).fold(0.0, f64::max),
    };
    shapes.iter().map(far).fold(0.0, f64::max)
}
