//! Characters: a skeleton with mass, inertia, shapes, contact points and a rest pose.
//!
//! In: one [`Body`] per link. Out: a checked [`Character`]. Units: kg, m, kg·m²; inertia about the
//! body's own centre of mass, along the link's axes.

use std::sync::Arc;

use motion::names::Word;
use motion::support::{Vec2, ground};
use motion::{Joint, Kinematics, Limb, LimbKind, Shape, Skeleton, Sole, Support, Vec3};
use nalgebra::Matrix3;
use thiserror::Error;

/// Mass and shape of one link.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Mass, kg; zero only for a welded link, or one that chains several joints between two bodies.
    pub mass: f64,
    /// Centre of mass in the link's frame, m.
    pub com: Vec3,
    /// Rotational inertia about the centre of mass, link axes, kg·m².
    pub inertia: Matrix3<f64>,
    /// Solids that are drawn, exported and collide with the ground.
    pub shapes: Vec<Shape>,
}

/// What a joint is in the body; selects its natural frequency and its balance strategy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum JointClass {
    /// The root's own joint.
    Root,
    /// Between pelvis and chest.
    Spine,
    /// Neck and head.
    Neck,
    /// Collar bone against the chest.
    Clavicle,
    /// Upper arm.
    Shoulder,
    /// Forearm.
    Elbow,
    /// Hand.
    Wrist,
    /// Thigh.
    Hip,
    /// Shin.
    Knee,
    /// Foot.
    Ankle,
    /// Anything else: tails, ears, lamps.
    Other,
}

impl Word for JointClass {
    const KIND: &'static str = "class of joint";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Root, "root", "The root's own joint"),
        (Self::Spine, "spine", "Between pelvis and chest"),
        (Self::Neck, "neck", "Neck and head"),
        (Self::Clavicle, "clavicle", "Collar bone against the chest"),
        (Self::Shoulder, "shoulder", "Upper arm"),
        (Self::Elbow, "elbow", "Forearm"),
        (Self::Wrist, "wrist", "Hand"),
        (Self::Hip, "hip", "Thigh"),
        (Self::Knee, "knee", "Shin"),
        (Self::Ankle, "ankle", "Foot"),
        (Self::Other, "other", "Anything else: tails, ears, lamps"),
    ];
}

/// What is wrong with a character.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum CharacterError {
    /// Not one body per link.
    #[error("{bodies} bodies for {links} links; each link needs one")]
    Count {
        /// Bodies given.
        bodies: usize,
        /// Links of the skeleton.
        links: usize,
    },
    /// A mass that is zero, negative or not finite where it must be positive.
    #[error("link `{link}` has a mass of {mass} kg; it must be positive and finite")]
    Mass {
        /// The link.
        link: String,
        /// Mass found, kg.
        mass: f64,
    },
    /// An inertia that no solid can have.
    #[error(
        "link `{link}` has principal inertias {principal:?} kg·m²; each must be positive and at most the sum of the other two"
    )]
    Inertia {
        /// The link.
        link: String,
        /// Principal values, kg·m².
        principal: [f64; 3],
    },
    /// A rest pose of the wrong length.
    #[error("the rest pose has {found} numbers, the skeleton needs {needed}")]
    Rest {
        /// Length found.
        found: usize,
        /// Length needed.
        needed: usize,
    },
    /// A contact that names a missing site.
    #[error("contact point {0} does not exist among the sites")]
    Contact(usize),
}

/// A body that can be simulated. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Character {
    /// Name.
    pub name: String,
    /// Links and joints. Links without motion of their own are `Fixed`.
    pub skeleton: Arc<Skeleton>,
    /// One per link.
    pub bodies: Vec<Body>,
    /// One per link: what its joint is.
    pub classes: Vec<JointClass>,
    /// Indices into the skeleton's sites: points that may touch the ground (corners of the soles).
    pub contacts: Vec<usize>,
    /// Pose of rest: standing, arms hanging. Length `nq`.
    pub rest: Vec<f64>,
}

impl Character {
    /// Checks that the parts fit together and that masses and inertias are physical.
    ///
    /// # Errors
    /// See [`CharacterError`]. A massless link is allowed if its joint moves and some link it carries
    /// has mass; so is a welded one, whose mass is its parent's, or the world's if it is the root.
    pub fn check(self) -> Result<Self, CharacterError> {
        let links = self.skeleton.links();
        if self.bodies.len() != links.len() || self.classes.len() != links.len() {
            return Err(CharacterError::Count { bodies: self.bodies.len(), links: links.len() });
        }
        if self.rest.len() != self.skeleton.nq() {
            return Err(CharacterError::Rest { found: self.rest.len(), needed: self.skeleton.nq() });
        }
        if let Some(&bad) = self.contacts.iter().find(|&&c| c >= self.skeleton.sites().len()) {
            return Err(CharacterError::Contact(bad));
        }
        let carries = self.carries_mass();
        for (i, body) in self.bodies.iter().enumerate() {
            let link = &links[i].name;
            let welded = links[i].joint == Joint::Fixed;
            let massless = body.mass == 0.0 && body.inertia == Matrix3::zeros();
            if massless && (welded || carries[i]) {
                continue;
            }
            let positive = body.mass > 0.0 && body.mass.is_finite();
            if !positive || !body.com.iter().all(|x| x.is_finite()) {
                return Err(CharacterError::Mass { link: link.clone(), mass: body.mass });
            }
            let symmetric = (body.inertia + body.inertia.transpose()) * 0.5;
            let mut p: [f64; 3] = symmetric.symmetric_eigenvalues().into();
            p.sort_by(f64::total_cmp);
            // equality holds for a flat plate; 1e-9 is rounding of written files
            let physical = p[0] > 0.0 && p[2] <= (p[0] + p[1]) * (1.0 + 1e-9);
            if !physical || !symmetric.iter().all(|x| x.is_finite()) {
                return Err(CharacterError::Inertia { link: link.clone(), principal: p });
            }
        }
        Ok(self)
    }

    /// How far all solids reach along a unit vector of the world in the pose `q`, m: the least and the greatest coordinate.
    /// `None` without solids.
    pub fn extent(&self, q: &[f64], along: &Vec3) -> Option<[f64; 2]> {
        let k = Kinematics::new(&self.skeleton, q);
        let mut out: Option<[f64; 2]> = None;
        for (world, body) in k.world.iter().zip(&self.bodies) {
            for shape in &body.shapes {
                let (low, high) = (-shape.reach(world, &-along), shape.reach(world, along));
                out = Some(out.map_or([low, high], |[a, b]| [a.min(low), b.max(high)]));
            }
        }
        out
    }

    /// Total mass, kg.
    pub fn mass(&self) -> f64 {
        self.bodies.iter().map(|b| b.mass).sum()
    }

    /// The legs, each with its hip, knee and foot.
    pub fn legs(&self) -> impl Iterator<Item = &Limb> {
        self.skeleton.limbs().iter().filter(|l| l.kind == LimbKind::Leg)
    }

    /// The soles: contact points grouped by the body that carries them, in the order of each one's first point. A link and
    /// the links welded to it are one body. A leg that ends in the body gives the sole its name and link; a body without
    /// one (a hand, the base of a lamp) has those of the link of its first point.
    pub fn soles(&self) -> Vec<Sole> {
        let mut soles: Vec<Sole> = Vec::new();
        let mut bodies: Vec<usize> = Vec::new();
        for &c in &self.contacts {
            let site = &self.skeleton.sites()[c];
            let body = self.skeleton.welded_to(site.link);
            let corner = (site.link, site.at);
            if let Some(i) = bodies.iter().position(|b| *b == body) {
                soles[i].corners.push(corner);
                continue;
            }
            let leg = self.legs().find(|l| self.skeleton.welded_to(l.end) == body);
            let link = leg.map_or(site.link, |l| l.end);
            let name = leg.map_or(&self.skeleton.links()[link].name, |l| &l.name).clone();
            bodies.push(body);
            soles.push(Sole { name, link, corners: vec![corner] });
        }
        soles
    }

    /// The soles, with points along their edges beside the corners, no farther apart than `spacing` (m).
    ///
    /// A sole presses with its edges, not with its corners alone: a foot whose heel is up stands on the part of its sole
    /// that is still near the ground, and with toes that are welded to it on its ball, the tips being under the ground.
    /// Edges are those of the hull of the corners, seen from above in the rest pose.
    pub fn edged_soles(&self, spacing: f64) -> Vec<Sole> {
        let k = Kinematics::new(&self.skeleton, &self.rest);
        let mut soles = self.soles();
        for sole in &mut soles {
            let places: Vec<Vec3> = sole.points(&k).collect();
            let hull = Support::of(&places);
            let corner = |p: &Vec2| {
                let off = |at: &Vec3| (ground(at) - p).norm();
                places.iter().copied().min_by(|a, b| off(a).total_cmp(&off(b)))
            };
            let around: Vec<Vec3> = hull.corners().iter().filter_map(corner).collect();
            // a segment has one edge, not one there and one back
            let edges = if around.len() > 2 { around.len() } else { around.len().saturating_sub(1) };
            let back = k.world[sole.link].inverse();
            for i in 0..edges {
                let (a, b) = (around[i], around[(i + 1) % around.len()]);
                let parts = ((b - a).norm() / spacing).ceil().max(1.0) as usize;
                sole.corners.extend((1..parts).map(|j| {
                    let p = a + (b - a) * (j as f64 / parts as f64);
                    (sole.link, back.transform_point(&p.into()).coords)
                }));
            }
        }
        soles
    }

    /// The legs whose feet have a sole, each with its sole, in the order of the legs.
    pub fn leg_soles(&self) -> Vec<(&Limb, Sole)> {
        let soles = self.soles();
        let of = |leg: &Limb| {
            let body = self.skeleton.welded_to(leg.end);
            let sole = soles.iter().find(|s| self.skeleton.welded_to(s.link) == body)?;
            // of two legs that end in one body each has it
            Some(Sole { name: leg.name.clone(), link: leg.end, corners: sole.corners.clone() })
        };
        self.legs().filter_map(|leg| Some((leg, of(leg)?))).collect()
    }

    /// Whether each link moves others that have mass.
    fn carries_mass(&self) -> Vec<bool> {
        let links = self.skeleton.links();
        let mut carries = vec![false; links.len()];
        for i in (1..links.len()).rev() {
            if let Some(parent) = links[i].parent {
                carries[parent] |= carries[i] || self.bodies[i].mass > 0.0;
            }
        }
        carries.iter().zip(links).map(|(&c, link)| c && link.joint.nv() > 0).collect()
    }
}

#[cfg(test)]
mod tests {
    use motion::Link;

    use super::*;
    use crate::anthropometry::human::human;

    /// Contact points on toes that are welded to a foot belong to its sole; a hand has one of its own, which is no leg's.
    #[test]
    fn soles_are_those_of_bodies() {
        let (human, _) = human();
        let legs: Vec<String> = human.legs().map(|l| l.name.clone()).collect();
        // along the edges: the corners first, none farther from the next than asked, all on the outline
        for (plain, edged) in human.soles().iter().zip(human.edged_soles(0.04)) {
            let k = Kinematics::new(&human.skeleton, &human.rest);
            assert_eq!(edged.corners[..4], plain.corners[..]);
            let hull = Support::of(&plain.points(&k).collect::<Vec<_>>());
            let points: Vec<Vec3> = edged.points(&k).collect();
            assert!(points.iter().all(|p| hull.margin(&ground(p)).abs() < 1e-9));
            for (i, p) in points.iter().enumerate() {
                let others = points.iter().enumerate().filter(|(j, _)| *j != i);
                let nearest = others.map(|(_, o)| (o - p).norm()).fold(f64::INFINITY, f64::min);
                assert!(nearest < 0.04 + 1e-9 && nearest > 0.01, "{nearest}");
            }
        }
        let mut links: Vec<Link> = human.skeleton.links().to_vec();
        let foot = human.legs().next().unwrap().end;
        let hand = human.skeleton.link("wrist_r").unwrap();
        links.push(Link::new("tip", Some(foot), Vec3::z() * 0.1, Joint::Fixed));
        let mut sites = human.skeleton.sites().to_vec();
        let tip = links.len() - 1;
        sites.push(motion::Site { name: "palm".into(), link: hand, at: Vec3::zeros() });
        sites.push(motion::Site { name: "tip".into(), link: tip, at: Vec3::x() * 0.01 });
        let skeleton = Skeleton::new(links).unwrap().with_sites(sites).unwrap();
        let skeleton = skeleton.with_limbs(human.skeleton.limbs().to_vec()).unwrap();
        let n = skeleton.sites().len();
        let contacts = [human.contacts.clone(), vec![n - 2, n - 1]].concat();
        let c = Character { skeleton: Arc::new(skeleton), contacts, ..human };
        let soles = c.soles();
        let found: Vec<(&str, usize)> = soles.iter().map(|s| (s.name.as_str(), s.corners.len())).collect();
        assert_eq!(found, [(legs[0].as_str(), 5), (legs[1].as_str(), 4), ("wrist_r", 1)]);
        assert_eq!(soles[0].corners[4], (tip, Vec3::x() * 0.01));
        let of_legs: Vec<Sole> = c.leg_soles().into_iter().map(|(_, s)| s).collect();
        assert_eq!(of_legs, soles[..2]);
    }
}
