//! Characters: a skeleton with mass, inertia, shapes, contact points and a rest pose.
//!
//! In: one [`Body`] per link. Out: a checked [`Character`]. Units: kg, m, kg·m²; inertia about the
//! body's own centre of mass, along the link's axes.

use std::sync::Arc;

use motion::{Joint, Limb, LimbKind, Shape, Skeleton, Vec3};
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
        for (i, body) in self.bodies.iter().enumerate() {
            let link = &links[i].name;
            let welded = links[i].joint == Joint::Fixed;
            let massless = body.mass == 0.0 && body.inertia == Matrix3::zeros();
            if massless && (welded || self.carries_mass(i)) {
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

    /// Total mass, kg.
    pub fn mass(&self) -> f64 {
        self.bodies.iter().map(|b| b.mass).sum()
    }

    /// The legs, each with its hip, knee and foot.
    pub fn legs(&self) -> impl Iterator<Item = &Limb> {
        self.skeleton.limbs().iter().filter(|l| l.kind == LimbKind::Leg)
    }

    fn carries_mass(&self, link: usize) -> bool {
        let links = self.skeleton.links();
        links[link].joint.nv() > 0
            && (link + 1..links.len())
                .any(|i| self.bodies[i].mass > 0.0 && self.skeleton.ancestors(i).any(|u| u == link))
    }
}
