//! Soles that yield: pads under heel and ball, and toes that bend.
//!
//! In: a [`Character`] whose feet are boxes on flat soles, and [`Soles`]. Out: [`OnSoles`]: the same body with the box of every foot cut in
//! parts that move a little against the foot, each a link at the end of the skeleton. A pad slides along the normal of the sole, toes turn
//! about a hinge across the foot. What holds them are springs of fixed numbers (N/m, N·s/m), not muscles.
//!
//! Everything else keeps its place: the links, degrees of freedom, sites and limbs of the character come first, at the same indices, so that a
//! pose of the character is the beginning of a pose of the body on its soles. The parts are for engines; motions, controllers and files know
//! the character.
//!
//! ```text
//!            |‾‾‾‾‾‾‾‾‾‾‾‾ foot ‾‾‾‾‾‾‾‾‾‾|        box of the foot, length 1
//!            |  heel  |      |    ball    |        without toes: heel 0 to 0.35, ball 0.55 to 1
//!            |  heel  |      |  ball  |toe|        with toes: ball up to the hinge, which is where the rig's is
//! ```

mod foot;

use motion::skeleton::SkeletonError;
use motion::{Joint, Limits, Link, Quat, Range, Shape, Skeleton, Vec3};
use nalgebra::Matrix3;
use std::sync::Arc;
use thiserror::Error;

use foot::{Foot, HINGES};

use crate::character::{Body, Character, CharacterError, JointClass};
use crate::mass::fuse;

/// A spring and a damper under a part of a sole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pad {
    /// Stiffness, N/m.
    pub stiffness_n_m: f64,
    /// Damping, N·s/m.
    pub damping_n_s_m: f64,
    /// How far it gives way before its tissue is compact, m.
    pub travel_m: f64,
    /// Stiffness beyond that, N/m.
    pub compact_n_m: f64,
}

/// The pads of a foot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pads {
    /// Under the heel.
    pub heel: Pad,
    /// Under the ball.
    pub ball: Pad,
}

/// Toes that bend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Toes {
    /// Stiffness of the hinge, N·m/rad.
    pub stiffness_nm_rad: f64,
    /// Damping of the hinge, N·m·s/rad.
    pub damping_nm_s_rad: f64,
}

/// What the soles of a body do under load. The default is a rigid sole with toes welded to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Soles {
    /// Pads; `None` is rigid.
    pub pads: Option<Pads>,
    /// Toes; `None` is welded.
    pub toes: Option<Toes>,
}

impl Default for Pads {
    /// Feet of adults under loads of walking: `docs/WALKING.md` has the sources.
    fn default() -> Self {
        Self {
            heel: Pad { stiffness_n_m: 5e4, damping_n_s_m: 800.0, travel_m: 0.0113, compact_n_m: 2e5 },
            ball: Pad { stiffness_n_m: 1.1e5, damping_n_s_m: 1760.0, travel_m: 0.01, compact_n_m: 2e5 },
        }
    }
}

impl Default for Toes {
    /// Of walking adults: `docs/WALKING.md` has the sources.
    fn default() -> Self {
        Self { stiffness_nm_rad: 30.0, damping_nm_s_rad: 0.5 }
    }
}

impl Pads {
    /// How far the pads of two feet give way under a body of a weight (N) that stands on them, m: so far they hang below a rigid sole when nothing
    /// presses them, and who stands has the height of one on rigid soles.
    pub fn sag_m(&self, weight_n: f64) -> f64 {
        0.5 * weight_n / (self.heel.stiffness_n_m + self.ball.stiffness_n_m)
    }
}

impl Soles {
    /// Whether nothing of them moves.
    pub fn are_rigid(&self) -> bool {
        self.pads.is_none() && self.toes.is_none()
    }
}

/// Why a body cannot have such soles.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SolesError {
    /// No leg that ends in a sole.
    #[error("`{0}` has no leg that ends in a sole; soles that yield need feet")]
    NoFeet(String),
    /// Contact points that are no flat sole.
    #[error(
        "the contact points of `{foot}` make no flat sole: {found}; pads and toes need three or more in a plane"
    )]
    NotFlat {
        /// The leg.
        foot: String,
        /// What they are.
        found: String,
    },
    /// What stands on the sole is not one box.
    #[error("{found} of `{foot}` reach its sole; pads and toes need a foot that stands on one box")]
    NotABox {
        /// The leg.
        foot: String,
        /// What does.
        found: String,
    },
    /// No joint of toes where toes have one.
    #[error(
        "`{foot}` has no toes to bend: no welded link of it begins between {from:.0} and {to:.0} % of its length from the heel",
        from = 100.0 * HINGES.lo,
        to = 100.0 * HINGES.hi
    )]
    NoToes {
        /// The leg.
        foot: String,
    },
    /// A number that no spring has.
    #[error("{what} of {found}; allowed: finite and above 0")]
    Number {
        /// Which.
        what: &'static str,
        /// Found.
        found: f64,
    },
    /// A foot too light or too small to give up the mass of its parts.
    #[error("a foot cannot be cut into its parts: {0}")]
    Parts(#[from] CharacterError),
    /// Links that have the names of its parts.
    #[error("a foot cannot be cut into its parts: {0}")]
    Links(#[from] SkeletonError),
}

/// A part of a sole.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its link in [`OnSoles::character`].
    pub link: usize,
    /// The link of the foot.
    pub foot: usize,
    /// Stiffness of its joint, N/m or N·m/rad.
    pub stiffness: f64,
    /// Damping of its joint, N·s/m or N·m·s/rad.
    pub damping: f64,
    /// Where its spring rests, m or rad.
    pub rest: f64,
    /// Stiffness of the stops of its joint, beside that of its spring, N/m or N·m/rad.
    pub stop: f64,
    /// The lower corners of its outer edge (the rear one of the heel, else the front one), in the frame of its link, m.
    pub edge: [Vec3; 2],
}

/// A body on soles that yield. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct OnSoles {
    /// The body with its parts.
    pub character: Character,
    /// The parts, in the order of their links.
    pub parts: Vec<Part>,
    /// Weight of the body, N.
    weight_n: f64,
}

/// Standard gravity, m/s²: what tissue has grown under.
const GRAVITY: f64 = 9.80665;
/// Where the heel pad ends and the ball pad begins, from the heel, parts of the length of the box.
const HEEL_TO: f64 = 0.35;
/// See [`HEEL_TO`].
const BALL_FROM: f64 = 0.55;
/// Mass of a pad over that of its foot: fat and skin under it, some 50 cm³.
const PAD_MASS: f64 = 0.05;
/// Mass of toes over that of their foot.
const TOES_MASS: f64 = 0.08;
/// Height of the hinge of toes, and half the height of toes, over the height of the box.
const HINGE_HEIGHT: f64 = 0.4;
/// How far toes bend down and up, rad.
const TOES_BEND: Range = Range { lo: -0.3, hi: 1.2 };
/// Stiffness of the stops of toes over that of their spring.
const TOES_STOP: f64 = 3.0;

impl OnSoles {
    /// The body on its soles.
    ///
    /// # Errors
    /// [`SolesError`]: feet that are not boxes, numbers that no spring has.
    pub fn new(character: &Character, soles: &Soles) -> Result<Self, SolesError> {
        soles.check()?;
        let weight_n = GRAVITY * character.mass();
        let mut made = Self { character: character.clone(), parts: Vec::new(), weight_n };
        if soles.are_rigid() {
            return Ok(made);
        }
        let feet = character.leg_soles();
        if feet.is_empty() {
            return Err(SolesError::NoFeet(character.name.clone()));
        }
        let mut links = character.skeleton.links().to_vec();
        for (limb, sole) in feet {
            let foot = Foot::of(character, &sole)?;
            // of two legs that end in one foot the first has its parts
            if made.parts.iter().any(|part| part.foot == foot.link) {
                continue;
            }
            let hinge = match soles.toes {
                Some(toes) => Some((
                    toes,
                    foot.toes_at(character).ok_or_else(|| SolesError::NoToes { foot: limb.name.clone() })?,
                )),
                None => None,
            };
            made.cut(&mut links, &limb.name, &foot, soles.pads.as_ref(), hinge);
        }
        let source = &character.skeleton;
        let skeleton = Skeleton::new(links)?
            .with_sites(source.sites().to_vec())?
            .with_limbs(source.limbs().to_vec())?
            .with_parts(source.parts().clone())?;
        made.character.skeleton = Arc::new(skeleton);
        made.character.rest.resize(made.character.skeleton.nq(), 0.0);
        made.character = made.character.check()?;
        Ok(made)
    }

    /// The same body, its parts touching with the corners of their outer edges alone: what stands flat stands on the same polygon, at half the
    /// price. For searches; between links that touch each other, corners would be bodies of their own.
    pub fn on_edges(mut self) -> Self {
        for part in &self.parts {
            let point = |at: &Vec3| Shape::Sphere { center: *at, radius: 0.0 };
            self.character.bodies[part.link].shapes = part.edge.iter().map(point).collect();
        }
        self
    }

    /// Takes the parts of a foot out of its box.
    fn cut(
        &mut self,
        links: &mut Vec<Link>,
        name: &str,
        foot: &Foot,
        pads: Option<&Pads>,
        hinge: Option<(Toes, f64)>,
    ) {
        let end = hinge.map_or(1.0, |(_, at)| at);
        let whole = self.character.bodies[foot.link].mass;
        self.character.bodies[foot.link].shapes.remove(foot.shape);
        match pads {
            Some(pads) => {
                let rest = -pads.sag_m(self.weight_n);
                let ball_from = BALL_FROM.min(end - 0.1);
                for (word, pad, from, to, outward) in [
                    ("heel_pad", &pads.heel, 0.0, HEEL_TO, -1.0),
                    ("ball_pad", &pads.ball, ball_from, end, 1.0),
                ] {
                    let (center, half) = foot.slice(from, to, foot.height);
                    let body = solid(PAD_MASS * whole, &half, &foot.rotation);
                    let joint = Joint::Prismatic(foot.up);
                    let mut link = Link::new(format!("{word}_{name}"), Some(foot.link), center, joint);
                    link.limits = Some(Limits::Axis(Range::new(rest - pad.travel_m, rest + pad.travel_m)));
                    let (stiffness, damping) = (pad.stiffness_n_m, pad.damping_n_s_m);
                    let edge = foot.edge(&Vec3::zeros(), &half, outward);
                    let stop = (pad.compact_n_m - stiffness).max(0.0);
                    self.add(
                        links,
                        link,
                        body,
                        Part { link: 0, foot: foot.link, stiffness, damping, rest, stop, edge },
                    );
                }
            }
            // the rest of the box stays where it was
            None => {
                let (center, half) = foot.slice(0.0, end, foot.height);
                let rest = Shape::Box { center, half, rotation: foot.rotation };
                self.character.bodies[foot.link].shapes.push(rest);
            }
        }
        if let Some((toes, at)) = hinge {
            let (center, half) = foot.slice(at, 1.0, 2.0 * HINGE_HEIGHT * foot.height);
            let mut body = solid(TOES_MASS * whole, &half, &foot.rotation);
            let place = foot.heel + foot.front * (at * foot.length) + foot.up * (HINGE_HEIGHT * foot.height);
            body.com = center - place;
            if let Shape::Box { center, .. } = &mut body.shapes[0] {
                *center = body.com;
            }
            let edge = foot.edge(&body.com, &half, 1.0);
            // positive bends up
            let joint = Joint::Revolute(foot.front.cross(&foot.up));
            let mut link = Link::new(format!("toes_{name}"), Some(foot.link), place, joint);
            link.limits = Some(Limits::Axis(TOES_BEND));
            let (stiffness, damping) = (toes.stiffness_nm_rad, toes.damping_nm_s_rad);
            let (rest, stop) = (0.0, TOES_STOP * stiffness);
            self.add(
                links,
                link,
                body,
                Part { link: 0, foot: foot.link, stiffness, damping, rest, stop, edge },
            );
        }
    }

    /// Adds a link with its body, whose mass its foot gives up.
    fn add(&mut self, links: &mut Vec<Link>, link: Link, body: Body, part: Part) {
        let foot = &mut self.character.bodies[part.foot];
        let there = body.com + link.parent_from_zero.translation.vector;
        (foot.mass, foot.com, foot.inertia) =
            fuse((foot.mass, foot.com, foot.inertia), (-body.mass, there, -body.inertia));
        self.parts.push(Part { link: links.len(), ..part });
        links.push(link);
        self.character.bodies.push(body);
        self.character.classes.push(JointClass::Other);
    }
}

/// A box of even density about its centre, along the axes of its link.
fn solid(mass: f64, half: &Vec3, rotation: &Quat) -> Body {
    let s = half.component_mul(half) * (mass / 3.0);
    let own = Matrix3::from_diagonal(&Vec3::new(s.y + s.z, s.x + s.z, s.x + s.y));
    let r = rotation.to_rotation_matrix();
    let inertia = r.matrix() * own * r.matrix().transpose();
    let shapes = vec![Shape::Box { center: Vec3::zeros(), half: *half, rotation: *rotation }];
    Body { mass, com: Vec3::zeros(), inertia: (inertia + inertia.transpose()) * 0.5, shapes }
}

impl Soles {
    /// Checks the numbers of the springs.
    ///
    /// # Errors
    /// [`SolesError::Number`].
    pub fn check(&self) -> Result<(), SolesError> {
        let positive = |what: &'static str, found: f64| {
            if found > 0.0 && found.is_finite() { Ok(()) } else { Err(SolesError::Number { what, found }) }
        };
        for pad in self.pads.iter().flat_map(|p| [&p.heel, &p.ball]) {
            positive("a stiffness (N/m)", pad.stiffness_n_m)?;
            positive("a damping (N·s/m)", pad.damping_n_s_m)?;
            positive("a travel (m)", pad.travel_m)?;
            positive("a stiffness of compact tissue (N/m)", pad.compact_n_m)?;
        }
        if let Some(toes) = &self.toes {
            positive("a stiffness of toes (N·m/rad)", toes.stiffness_nm_rad)?;
            positive("a damping of toes (N·m·s/rad)", toes.damping_nm_s_rad)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::anthropometry::human::human;

    /// Nothing of the character moves its place; mass, centre and inertia of the whole are what they were; the pads stand on the sole.
    #[test]
    fn a_body_on_its_soles_is_the_same_body() {
        let c = human().0;
        let on = OnSoles::new(&c, &Soles { pads: Some(Pads::default()), toes: None }).unwrap();
        let (n, nq) = (c.bodies.len(), c.skeleton.nq());
        assert_eq!(
            (on.parts.len(), on.character.bodies.len(), on.character.skeleton.nq()),
            (4, n + 4, nq + 4)
        );
        assert_eq!(on.character.rest[..nq], c.rest[..]);
        assert_eq!(on.character.skeleton.links()[..n], c.skeleton.links()[..]);
        assert_eq!(on.character.leg_soles().len(), 2);
        assert!((on.character.mass() - c.mass()).abs() < 1e-12 * c.mass());
        let whole = |c: &Character| {
            let k = motion::Kinematics::new(&c.skeleton, &c.rest);
            c.bodies.iter().zip(&k.world).fold((0.0, Vec3::zeros(), Matrix3::zeros()), |sum, (b, world)| {
                let r = world.rotation.to_rotation_matrix();
                let inertia = r.matrix() * b.inertia * r.matrix().transpose();
                fuse(sum, (b.mass, world.transform_point(&b.com.into()).coords, inertia))
            })
        };
        let (before, after) = (whole(&c), whole(&on.character));
        assert!((before.1 - after.1).norm() < 1e-12 && (before.2 - after.2).norm() < 1e-10); // 1e-15, 2e-14 seen
        // the sole is as low and as wide as it was
        let reach = |c: &Character, way: Vec3| c.extent(&c.rest, &way).unwrap();
        for way in [Vec3::y(), Vec3::z()] {
            let (a, b) = (reach(&c, way), reach(&on.character, way));
            assert!((a[0] - b[0]).abs() < 1e-12 && (a[1] - b[1]).abs() < 1e-12, "{a:?} {b:?}");
        }
        for part in &on.parts {
            let link = &on.character.skeleton.links()[part.link];
            assert_eq!(link.parent, Some(part.foot));
            let Joint::Prismatic(axis) = link.joint else { panic!("{link:?}") };
            let k = motion::Kinematics::new(&c.skeleton, &c.rest);
            assert!((k.world[part.foot].rotation * axis - Vec3::y()).norm() < 1e-6, "{axis}"); // feet are flat at rest
        }
        // the edges are the corners of the soles
        let k = motion::Kinematics::new(&on.character.skeleton, &on.character.rest);
        let edges = on.parts.iter().flat_map(|part| part.edge.map(|at| k.point(part.link, &at)));
        let corners: Vec<Vec3> = c.soles().iter().flat_map(|s| s.points(&k).collect::<Vec<_>>()).collect();
        for edge in edges {
            assert!(corners.iter().any(|corner| (corner - edge).norm() < 1e-9), "{edge} of {corners:?}");
        }
        // rigid soles are the character itself
        assert_eq!(OnSoles::new(&c, &Soles::default()).unwrap().character, c);
    }

    /// Feet that are no boxes, toes that the rig has not, numbers that no spring has: each is refused in its words.
    #[test]
    fn what_cannot_be_is_said() {
        let c = human().0;
        let pads = Some(Pads::default());
        let bent = Soles { pads, toes: Some(Toes::default()) };
        let error = |c: &Character, soles: &Soles| OnSoles::new(c, soles).unwrap_err().to_string();
        assert!(error(&c, &bent).contains("no toes to bend"), "{}", error(&c, &bent));
        let soft = Pad { stiffness_n_m: 0.0, ..Pads::default().heel };
        let bad = Soles { pads: Some(Pads { heel: soft, ..Pads::default() }), toes: None };
        assert_eq!(error(&c, &bad), "a stiffness (N/m) of 0; allowed: finite and above 0");
        let mut round = c.clone();
        let foot = c.legs().next().unwrap().end;
        round.bodies[foot].shapes = vec![Shape::Sphere { center: Vec3::zeros(), radius: 0.2 }];
        assert!(error(&round, &Soles { pads, toes: None }).contains("a shape that is no box"));
        let mut none = c.clone();
        none.contacts.clear();
        assert!(error(&none, &Soles { pads, toes: None }).contains("no leg that ends in a sole"));
    }
}
