//! Left and right of a skeleton: which link mirrors which.
//!
//! In: a [`Skeleton`]. Out: a [`Symmetry`]: the lateral direction of the zero pose, the partner of every link, and clips
//! mirrored. Found from the geometry of the zero pose alone; names do not matter.
//!
//! A skeleton is symmetric if a reflection through a vertical plane takes the zero pose of the tree to itself: links of the
//! trunk to themselves, those of a limb to those of its partner, within [`TOLERANCE`] of the body's size. The mirrored
//! rotation of a link is that of its partner reflected: with `W` the rotation of a link away from the zero
//! pose, in world axes, and `M` the reflection, `W′ = M W M`; rotation vectors keep their lateral part and turn the
//! others round.
//!
//! Units and frames: m; world of the zero pose, y up.

use std::sync::Arc;

use nalgebra::Point3;
use thiserror::Error;

use crate::rotation::{Quat, Vec3, exp, log};
use crate::{Clip, Joint, Kinematics, Skeleton};

/// Farthest that the reflection of a link may lie from its partner, in parts of the body's size ([`size_m`]).
pub const TOLERANCE: f64 = 0.05;

/// Why a skeleton has no left and right.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SymmetryError {
    /// No two branches are alike.
    #[error("no two limbs of the skeleton are alike: it has no left and right")]
    NoPair,
    /// The best plane leaves a link without a partner.
    #[error(
        "the zero pose is not symmetric: `{link}` has no partner within {:.0} % of the body's size ({:.0} mm)",
        100.0 * TOLERANCE, 1e3 * .within_m
    )]
    NoPartner {
        /// The link.
        link: String,
        /// What is allowed, m.
        within_m: f64,
    },
}

/// Left and right of a skeleton. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Symmetry {
    /// Normal of the plane of symmetry in the zero pose: unit, horizontal; points to the body's left if the body faces
    /// `lateral × up`, which geometry alone cannot tell.
    pub lateral: Vec3,
    /// For every link, the one that mirrors it; its own index on the plane. An involution.
    pub partner: Vec<usize>,
}

/// Size of a skeleton, m: the largest sum of bone lengths from the root to a link or to the end of one.
pub fn size_m(skeleton: &Skeleton) -> f64 {
    let mut far = vec![0.0_f64; skeleton.links().len()];
    let mut size: f64 = 0.0;
    for (i, link) in skeleton.links().iter().enumerate() {
        if let Some(p) = link.parent {
            far[i] = far[p] + link.parent_from_zero.translation.vector.norm();
        }
        size = size.max(far[i] + link.end.map_or(0.0, |e| e.norm()));
    }
    size
}

impl Symmetry {
    /// Finds the symmetry of a skeleton.
    ///
    /// # Errors
    /// [`SymmetryError`]: a body without paired limbs, or whose zero pose is not symmetric.
    pub fn of(skeleton: &Skeleton) -> Result<Self, SymmetryError> {
        let zero = Zero::of(skeleton);
        let n = skeleton.links().len();
        let mut lines: Vec<Vec3> = Vec::new();
        for a in 0..n {
            for b in a + 1..n {
                let siblings = skeleton.links()[a].parent == skeleton.links()[b].parent;
                let between = zero.at[b] - zero.at[a];
                let level = Vec3::new(between.x, 0.0, between.z);
                if siblings && zero.alike(a, b) && level.norm() > TOLERANCE * zero.size_m {
                    lines.push(level.normalize());
                } else if siblings && zero.alike(a, b) {
                    // branches that begin at one point part further out
                    lines.extend(zero.parting(a, b));
                }
            }
        }
        let mut best: Option<(usize, f64, Vec<usize>, Vec3)> = None;
        let mut lonely = None;
        for line in lines {
            match zero.matched(&line) {
                Ok((paired, error, partner)) => {
                    let better = best.as_ref().is_none_or(|(most, least, ..)| {
                        paired > *most || (paired == *most && error < *least)
                    });
                    if better {
                        best = Some((paired, error, partner, line));
                    }
                }
                Err(link) => lonely = lonely.or(Some(link)),
            }
        }
        match (best, lonely) {
            (Some((_, _, partner, line)), _) => {
                // the mean over all pairs, turned to where most of it lies along +x (or +z)
                let mut lateral = Vec3::zeros();
                for (i, &p) in partner.iter().enumerate() {
                    let d = zero.at[i] - zero.at[p];
                    let d = Vec3::new(d.x, 0.0, d.z);
                    lateral += if d.dot(&line) < 0.0 { -d } else { d };
                }
                let lateral = lateral.normalize();
                let leading = if lateral.x.abs() >= lateral.z.abs() { lateral.x } else { lateral.z };
                Ok(Self { lateral: lateral * leading.signum(), partner })
            }
            (None, Some(link)) => Err(SymmetryError::NoPartner {
                link: skeleton.links()[link].name.clone(),
                within_m: TOLERANCE * zero.size_m,
            }),
            (None, None) => Err(SymmetryError::NoPair),
        }
    }

    /// `clip` with left and right exchanged, reflected through the vertical plane through the world's origin with the normal
    /// [`Symmetry::lateral`].
    ///
    /// # Panics
    /// If the symmetry is of a skeleton with another number of links.
    pub fn mirrored(&self, clip: &Clip) -> Clip {
        let s: &Arc<Skeleton> = &clip.skeleton;
        assert_eq!(self.partner.len(), s.links().len(), "symmetry of another skeleton");
        let zero = Kinematics::new(s, &s.zero_pose());
        // from each joint's zero frame to the world of the zero pose
        let world_from_zero: Vec<Quat> = zero.world.iter().map(|w| w.rotation).collect();
        let mut q = Vec::with_capacity(clip.data().len());
        for frame in 0..clip.frames() {
            let from = clip.pose(frame);
            let mut to = s.zero_pose();
            for (i, link) in s.links().iter().enumerate() {
                let mirror = self.partner[i];
                let (own, theirs) = (world_from_zero[i], world_from_zero[mirror]);
                match (link.joint, s.links()[mirror].joint) {
                    (Joint::Free | Joint::Spherical, Joint::Free | Joint::Spherical) => {
                        let turn = own * log(&s.rotation(from, i));
                        let turn = theirs.inverse() * self.turned(&turn);
                        s.set_rotation(&mut to, mirror, &exp(&turn));
                        if link.joint == Joint::Free {
                            let (zero, back) = (link.parent_from_zero, s.links()[mirror].parent_from_zero);
                            let p = zero * Point3::from(s.position(from, i));
                            let p = back.inverse() * Point3::from(self.moved(&p.coords));
                            s.set_position(&mut to, mirror, &p.coords);
                        }
                    }
                    (Joint::Revolute(a), Joint::Revolute(b)) => {
                        let sign = self.turned(&(own * a)).dot(&(theirs * b)).signum();
                        to[s.q_at(mirror)] = sign * from[s.q_at(i)];
                    }
                    (Joint::Prismatic(a), Joint::Prismatic(b)) => {
                        let sign = self.moved(&(own * a)).dot(&(theirs * b)).signum();
                        to[s.q_at(mirror)] = sign * from[s.q_at(i)];
                    }
                    _ => {}
                }
            }
            q.extend(to);
        }
        Clip::new(s.clone(), clip.rate_hz, q)
    }

    /// A position or direction reflected.
    pub fn moved(&self, p: &Vec3) -> Vec3 {
        p - self.lateral * (2.0 * p.dot(&self.lateral))
    }

    /// A rotation vector reflected.
    pub fn turned(&self, w: &Vec3) -> Vec3 {
        -self.moved(w)
    }
}

/// The zero pose of a skeleton, for the search.
struct Zero<'a> {
    skeleton: &'a Skeleton,
    /// Where every link is, from the root, m.
    at: Vec<Vec3>,
    children: Vec<Vec<usize>>,
    size_m: f64,
}

impl<'a> Zero<'a> {
    fn of(skeleton: &'a Skeleton) -> Self {
        let k = Kinematics::new(skeleton, &skeleton.zero_pose());
        let root = k.origin(0);
        let at = (0..skeleton.links().len()).map(|i| k.origin(i) - root).collect();
        let mut children = vec![Vec::new(); skeleton.links().len()];
        for (i, link) in skeleton.links().iter().enumerate() {
            if let Some(p) = link.parent {
                children[p].push(i);
            }
        }
        Self { skeleton, at, children, size_m: size_m(skeleton) }
    }

    /// Whether two branches have the same shape and joints; links that nothing hangs on may differ in number.
    fn alike(&self, a: usize, b: usize) -> bool {
        let kind = |i: usize| std::mem::discriminant(&self.skeleton.links()[i].joint);
        let inner = |i: usize| self.children[i].iter().filter(|c| !self.children[**c].is_empty()).count();
        kind(a) == kind(b) && self.children[a].len() == self.children[b].len() && inner(a) == inner(b)
    }

    /// Horizontal direction between the first links of two branches that are apart.
    fn parting(&self, a: usize, b: usize) -> Option<Vec3> {
        let (a, b) = (*self.children[a].first()?, *self.children[b].first()?);
        let between = self.at[b] - self.at[a];
        let level = Vec3::new(between.x, 0.0, between.z);
        if level.norm() > TOLERANCE * self.size_m {
            return Some(level.normalize());
        }
        self.parting(a, b)
    }

    /// How far the reflection of one link lies from another, m.
    fn distance(&self, lateral: &Vec3, link: usize, other: usize) -> f64 {
        let p = self.at[link];
        (self.at[other] - (p - lateral * (2.0 * p.dot(lateral)))).norm()
    }

    /// The same, squared and summed over the two branches, children by their nearest: branches that begin at one point differ
    /// further out. Infinite where one has no counterpart.
    fn apart(&self, lateral: &Vec3, link: usize, other: usize) -> f64 {
        let mut left = self.children[other].clone();
        let mut sum = self.distance(lateral, link, other).powi(2);
        for &child in &self.children[link] {
            let costs = left.iter().enumerate().filter(|(_, c)| self.alike(child, **c));
            let costs = costs.map(|(i, &c)| (i, self.apart(lateral, child, c)));
            match costs.min_by(|a, b| a.1.total_cmp(&b.1)) {
                Some((i, cost)) => {
                    sum += cost;
                    left.remove(i);
                }
                None => return f64::INFINITY,
            }
        }
        sum
    }

    /// Number of paired links, sum of squared distances and partners under the reflection; the link without one.
    fn matched(&self, lateral: &Vec3) -> Result<(usize, f64, Vec<usize>), usize> {
        let n = self.at.len();
        let mut partner = vec![usize::MAX; n];
        partner[0] = 0;
        let (mut paired, mut error) = (0, 0.0);
        for link in 0..n {
            let theirs = partner[link];
            for &child in &self.children[link] {
                if partner[child] != usize::MAX {
                    continue;
                }
                let free = self.children[theirs]
                    .iter()
                    .copied()
                    .filter(|&c| partner[c] == usize::MAX && self.alike(child, c))
                    .map(|c| (c, self.apart(lateral, child, c)));
                let Some((nearest, _)) = free.min_by(|a, b| a.1.total_cmp(&b.1)) else {
                    return Err(child);
                };
                let distance = self.distance(lateral, child, nearest);
                if distance > TOLERANCE * self.size_m {
                    return Err(child);
                }
                (partner[child], partner[nearest]) = (nearest, child);
                paired += 2 * usize::from(nearest != child);
                error += distance.powi(2);
            }
        }
        if paired == 0 { Err(0) } else { Ok((paired, error, partner)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Link;

    /// A trunk that turns its zero frames, with two arms of two links and a hinge; `shift` moves one hand.
    fn body(shift: f64) -> Arc<Skeleton> {
        let mut links = vec![Link::new("root", None, Vec3::zeros(), Joint::Free)];
        links.push(Link::new("chest", Some(0), Vec3::new(0.02, 0.5, 0.0), Joint::Spherical));
        for (name, side) in [("a", 1.0), ("b", -1.0)] {
            let at = links.len();
            let mut arm = Link::new(name, Some(1), Vec3::new(0.0, 0.1, side * 0.2), Joint::Spherical);
            arm.parent_from_zero.rotation = exp(&Vec3::new(0.3 * side, 0.4 * side, 0.5));
            // the forearm hangs where the mirrored one does, whatever the zero frame
            let hang = arm.parent_from_zero.rotation.inverse() * Vec3::new(0.02, -0.3, 0.0);
            let axis = arm.parent_from_zero.rotation.inverse() * Vec3::new(0.0, 0.0, side);
            links.push(arm);
            let x = if side > 0.0 { shift } else { 0.0 };
            links.push(Link::new(
                format!("{name}2"),
                Some(at),
                hang + Vec3::new(x, 0.0, 0.0),
                Joint::Revolute(axis),
            ));
        }
        Arc::new(Skeleton::new(links).unwrap())
    }

    fn moving(s: &Arc<Skeleton>) -> Clip {
        let mut q = Vec::new();
        for f in 0..5 {
            let mut pose = s.zero_pose();
            let v: Vec<f64> = (0..s.nv()).map(|i| (1.3 * i as f64 + 0.2 * f as f64).sin()).collect();
            s.integrate(&mut pose, &v, 1.0);
            q.extend(pose);
        }
        Clip::new(s.clone(), 30.0, q)
    }

    /// Where every link is in the mirrored clip is the reflection of where its partner was.
    #[test]
    fn positions_are_reflected() {
        let s = body(0.0);
        let symmetry = Symmetry::of(&s).unwrap();
        assert_eq!(symmetry.partner, [0, 1, 4, 5, 2, 3]);
        assert!((symmetry.lateral - Vec3::z()).norm() < 1e-12);
        let clip = moving(&s);
        let mirrored = symmetry.mirrored(&clip);
        for f in 0..clip.frames() {
            let (a, b) = (Kinematics::new(&s, clip.pose(f)), Kinematics::new(&s, mirrored.pose(f)));
            for (i, &p) in symmetry.partner.iter().enumerate() {
                let off = (symmetry.moved(&a.origin(i)) - b.origin(p)).norm();
                assert!(off < 1e-12, "frame {f}, link {i}: {off}"); // 4e-16 seen
            }
        }
    }

    #[test]
    fn mirrored_twice_is_the_clip() {
        let s = body(0.0);
        let symmetry = Symmetry::of(&s).unwrap();
        let clip = moving(&s);
        let back = symmetry.mirrored(&symmetry.mirrored(&clip));
        for f in 0..clip.frames() {
            let mut v = vec![0.0; s.nv()];
            s.difference(clip.pose(f), back.pose(f), 1.0, &mut v);
            assert!(v.iter().all(|x| x.abs() < 1e-12), "{v:?}"); // 8e-16 seen
        }
    }

    /// Thighs that hang on two hip joints at one point, as in many captured skeletons, are told apart by where they end.
    #[test]
    fn branches_that_begin_at_one_point_are_paired() {
        let mut links = vec![Link::new("hips", None, Vec3::zeros(), Joint::Free)];
        for (name, side) in [("l", 1.0), ("r", -1.0)] {
            let at = links.len();
            links.push(Link::new(format!("{name}_joint"), Some(0), Vec3::zeros(), Joint::Fixed));
            let hip = Vec3::new(0.1 * side, -0.1, 0.02);
            links.push(Link::new(format!("{name}_thigh"), Some(at), hip, Joint::Spherical));
        }
        let symmetry = Symmetry::of(&Skeleton::new(links).unwrap()).unwrap();
        assert_eq!(symmetry.partner, [0, 3, 4, 1, 2]);
        assert!((symmetry.lateral - Vec3::x()).norm() < 1e-12);
    }

    /// A hand that is 4 cm off is the same body still; 10 cm of 0.9 m are too much, and so is one arm.
    #[test]
    fn what_is_not_symmetric_is_refused() {
        assert!(Symmetry::of(&body(0.04)).is_ok());
        let e = Symmetry::of(&body(0.1)).unwrap_err().to_string();
        assert!(e.contains("no partner within 5 %"), "{e}");
        let links = vec![
            Link::new("root", None, Vec3::zeros(), Joint::Free),
            Link::new("arm", Some(0), Vec3::x(), Joint::Spherical),
        ];
        assert_eq!(Symmetry::of(&Skeleton::new(links).unwrap()), Err(SymmetryError::NoPair));
    }
}
