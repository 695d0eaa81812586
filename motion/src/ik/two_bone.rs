//! Inverse kinematics of two-bone limbs: an arm or leg to a target.
//!
//! In: a pose, a [`Limb`] and where its end should be. Out: the same pose with the limb's two (or three)
//! joints changed, and whether the target was reached. Closed form, no iteration, no memory.
//!
//! With `a` from shoulder to elbow in the frame of the upper link, `b` from elbow to hand in the frame
//! of the lower link, `R₀` the elbow's zero frame in the upper link and `R` the elbow's rotation, the hand is
//! at `h = a + R₀ R b`. Only the elbow changes its distance `|h|`:
//!
//! - a hinge about `n`: `|h|² = |a|² + |b|² + 2 a'·b∥ + 2 (A cos θ + B sin θ)`, `a' = R₀ᵀa`,
//!   `A = a'·b⊥`, `B = a'·(n × b)`, solved for `θ`;
//! - a ball bends in the plane it is bent in: the angle between `a'` and `R b` by the law of cosines.
//!
//! The upper joint (a ball) then turns by the smallest rotations that bring the hand first back to its
//! old direction, in the limb's plane, and then to the target's: so the swivel is kept.
//!
//! A hinge stays within its limits and bends to the side where they leave more room, so that a
//! straight knee knows its way. A straight ball bends as a body does: knees forward, elbows back. Limits of
//! the upper and the end joint, and of a ball elbow, are the caller's business. Near full
//! stretch the bend grows as the square root of the distance missing; that is geometry, not noise.
//!
//! Offsets are general: bones need not lie along axes, links between those of the limb keep their
//! values.

use std::f64::consts::TAU;

use nalgebra::Point3;
use thiserror::Error;

use super::chain::{self, world_from_zero};
use crate::Transform;
use crate::rotation::{Quat, Vec3, between, exp};
use crate::skeleton::{Joint, Limb, LimbKind, Limits, Range, Skeleton};

/// How a solution ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reach {
    /// The end is at the target.
    Reached,
    /// The target is out of reach; the end is as near as the elbow allows, in its direction.
    Clamped {
        /// Distance left to the target, m.
        residue_m: f64,
    },
}

/// Why a limb cannot be solved.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum IkError {
    /// The links do not hang on one another.
    #[error("limb `{0}`: its links do not hang on one another, upper, lower, end")]
    Chain(String),
    /// A joint of the wrong kind.
    #[error("limb `{limb}`: the joint of `{link}` must be {allowed}")]
    Joint {
        /// The limb.
        limb: String,
        /// The link whose joint does not fit.
        link: String,
        /// What fits.
        allowed: &'static str,
    },
    /// A target that is not finite.
    #[error("limb `{0}`: the target is not finite")]
    NotFinite(String),
}

/// Residues below this count as reached, m.
const REACHED_M: f64 = 1e-9;
/// Bends below this lean towards the natural side, rad.
const STRAIGHT: f64 = 0.02;

/// The limb in one pose. Symbols as in the module header.
struct Geometry {
    /// Zero frame of the upper joint in the world.
    world_from_zero: Transform,
    a: Vec3,
    b: Vec3,
    r0: Quat,
    bend: Bend,
}

/// The elbow.
enum Bend {
    /// Axis, limits, current angle.
    Hinge(Vec3, Option<Range>, f64),
    /// Current rotation, and the direction a straight forearm bends to, zero frame.
    Ball(Quat, Vec3),
}

impl Geometry {
    fn new(skeleton: &Skeleton, q: &[f64], limb: &Limb) -> Result<Self, IkError> {
        let links = skeleton.links();
        let kind = |link: usize, allowed| IkError::Joint {
            limb: limb.name.clone(),
            link: links[link].name.clone(),
            allowed,
        };
        let broken = || IkError::Chain(limb.name.clone());
        if links[limb.upper].joint != Joint::Spherical {
            return Err(kind(limb.upper, "a ball"));
        }
        let parent = links[limb.lower].parent.ok_or_else(broken)?;
        let to_zero = chain::between(skeleton, q, limb.upper, parent).ok_or_else(broken)?
            * links[limb.lower].parent_from_zero;
        let b = chain::between(skeleton, q, limb.lower, limb.end).ok_or_else(broken)?.translation.vector;
        if limb.lower == limb.end {
            return Err(broken());
        }
        let bend = match links[limb.lower].joint {
            Joint::Revolute(axis) => {
                let range = match links[limb.lower].limits {
                    Some(Limits::Axis(range)) => Some(range),
                    _ => None,
                };
                Bend::Hinge(axis, range, q[skeleton.q_at(limb.lower)])
            }
            Joint::Spherical => {
                // in the zero pose the character faces +Z
                let zero = chain::rotation_in_zero_pose(skeleton, limb.lower);
                let (to, other) = match limb.kind {
                    LimbKind::Leg => (-Vec3::z(), Vec3::y()),
                    LimbKind::Arm => (Vec3::z(), Vec3::y()),
                };
                let along = (zero * b).cross(&to).norm() < 0.1 * b.norm();
                Bend::Ball(skeleton.rotation(q, limb.lower), zero.inverse() * if along { other } else { to })
            }
            _ => return Err(kind(limb.lower, "a hinge or a ball")),
        };
        Ok(Self {
            world_from_zero: world_from_zero(skeleton, q, limb.upper),
            a: to_zero.translation.vector,
            b,
            r0: to_zero.rotation,
            bend,
        })
    }

    /// Least and greatest distance the elbow allows, m.
    fn reach(&self) -> (f64, f64) {
        match &self.bend {
            Bend::Hinge(axis, range, _) => Hinge::new(self, axis).reach(range.as_ref()),
            Bend::Ball(..) => {
                let (a, b) = (self.a.norm(), self.b.norm());
                ((a - b).abs(), a + b)
            }
        }
    }

    /// Position of the hand in the frame of the upper link for a rotation of the elbow.
    fn hand(&self, elbow: &Quat) -> Vec3 {
        self.a + self.r0 * (elbow * self.b)
    }
}

/// `d² = c + 2m cos(θ − φ)`.
struct Hinge {
    c: f64,
    m: f64,
    phi: f64,
}

impl Hinge {
    fn new(g: &Geometry, axis: &Vec3) -> Self {
        let a = g.r0.inverse() * g.a;
        let along = axis * axis.dot(&g.b);
        let (x, y) = (a.dot(&(g.b - along)), a.dot(&axis.cross(&g.b)));
        Self {
            c: g.a.norm_squared() + g.b.norm_squared() + 2.0 * a.dot(&along),
            m: x.hypot(y),
            phi: y.atan2(x),
        }
    }

    fn distance(&self, theta: f64) -> f64 {
        (self.c + 2.0 * self.m * (theta - self.phi).cos()).max(0.0).sqrt()
    }

    fn reach(&self, range: Option<&Range>) -> (f64, f64) {
        let most = (self.c + 2.0 * self.m).max(0.0).sqrt();
        let least = (self.c - 2.0 * self.m).max(0.0).sqrt();
        let Some(range) = range else { return (least, most) };
        // an extremum counts if some turn of it lies within the limits
        let within = |at: f64| at + TAU * ((range.lo - at) / TAU).ceil() <= range.hi;
        let (x, y) = (self.distance(range.lo), self.distance(range.hi));
        let lo = if within(self.phi + TAU / 2.0) { least } else { x.min(y) };
        let hi = if within(self.phi) { most } else { x.max(y) };
        (lo, hi)
    }

    /// The angle at which the hand is at the distance `d`, or as near as limits allow.
    fn solve(&self, d: f64, range: Option<&Range>, now: f64) -> f64 {
        if self.m < 1e-12 {
            return now;
        }
        let alpha = ((d * d - self.c) / (2.0 * self.m)).clamp(-1.0, 1.0).acos();
        // the turn of x nearest to y
        let near = |x: f64, y: f64| x + TAU * ((y - x) / TAU).round();
        let Some(range) = range else {
            let (p, n) = (near(self.phi + alpha, now), near(self.phi - alpha, now));
            return if (p - now).abs() <= (n - now).abs() { p } else { n };
        };
        let middle = 0.5 * (range.lo + range.hi);
        // straight, seen from the middle of the range: the side of the middle has more room
        let straight = near(self.phi, middle);
        let roomy = if middle >= straight { straight + alpha } else { straight - alpha };
        let (first, second) = (near(roomy, middle), near(2.0 * straight - roomy, middle));
        let slack = 1e-12;
        for x in [first, second] {
            if x >= range.lo - slack && x <= range.hi + slack {
                return range.clamp(x);
            }
        }
        let miss = |x: f64| (self.distance(x) - d).abs();
        let ends = [range.clamp(first), range.clamp(second), range.lo, range.hi];
        ends.into_iter().min_by(|x, y| miss(*x).total_cmp(&miss(*y))).unwrap_or(now)
    }
}

/// Rotation of a ball elbow at which the hand is at the distance `d`.
fn bend_ball(g: &Geometry, now: &Quat, natural: &Vec3, d: f64) -> Quat {
    let (la, lb) = (g.a.norm(), g.b.norm());
    if la < 1e-9 || lb < 1e-9 {
        return *now;
    }
    let along = g.r0.inverse() * g.a / la;
    let forearm = now * g.b / lb;
    let normal = |v: &Vec3| v - along * along.dot(v);
    let mut side = normal(&forearm);
    // A nearly straight forearm has no plane of its own: lean to the natural side, fading in.
    let lean = (STRAIGHT - side.norm()).max(0.0);
    if lean > 0.0 {
        side +=
            normal(natural).try_normalize(1e-9).unwrap_or_else(|| between(&Vec3::x(), &along) * Vec3::y())
                * lean;
    }
    let side = side.try_normalize(1e-12).unwrap_or_else(|| between(&Vec3::x(), &along) * Vec3::y());
    // law of cosines; γ = 0 is straight
    let cos = ((d * d - la * la - lb * lb) / (2.0 * la * lb)).clamp(-1.0, 1.0);
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    between(&forearm, &(along * cos + side * sin)) * now
}

/// Least and greatest distance from the upper joint to the end that the elbow allows, m.
///
/// A hinge counts with its limits; a ball bends fully.
///
/// # Errors
/// Links that are no chain, joints that do not fit.
pub fn reach_range(skeleton: &Skeleton, q: &[f64], limb: &Limb) -> Result<(f64, f64), IkError> {
    Ok(Geometry::new(skeleton, q, limb)?.reach())
}

/// Brings the origin of the limb's end link to `target` (m, world), changing the limb's upper and lower
/// joints in `q`; the swivel is kept.
///
/// A target out of reach is approached in its direction. At a target on the upper joint itself the
/// direction is kept.
///
/// # Errors
/// Links that are no chain, joints that do not fit, a target that is not finite.
pub fn solve_two_bone(
    skeleton: &Skeleton,
    q: &mut [f64],
    limb: &Limb,
    target: &Vec3,
) -> Result<Reach, IkError> {
    if !target.iter().all(|x| x.is_finite()) {
        return Err(IkError::NotFinite(limb.name.clone()));
    }
    let g = Geometry::new(skeleton, q, limb)?;
    let goal = g.world_from_zero.inverse_transform_point(&Point3::from(*target)).coords;
    let (least, most) = g.reach();
    let d = goal.norm().clamp(least, most);
    let (old, new) = match &g.bend {
        Bend::Hinge(axis, range, now) => {
            let theta = Hinge::new(&g, axis).solve(d, range.as_ref(), *now);
            q[skeleton.q_at(limb.lower)] = theta;
            (g.hand(&exp(&(axis * *now))), g.hand(&exp(&(axis * theta))))
        }
        Bend::Ball(now, natural) => {
            let elbow = bend_ball(&g, now, natural, d);
            skeleton.set_rotation(q, limb.lower, &elbow);
            (g.hand(now), g.hand(&elbow))
        }
    };
    let mut upper = skeleton.rotation(q, limb.upper);
    if new.norm() > 1e-9 {
        let mut toward = upper * new;
        if old.norm() > 1e-9 {
            toward = upper * old;
            upper *= between(&new, &old);
        }
        if goal.norm() > 1e-9 {
            upper = between(&toward, &goal) * upper;
        }
        skeleton.set_rotation(q, limb.upper, &Quat::new_normalize(upper.into_inner()));
    }
    let residue_m = (skeleton.rotation(q, limb.upper) * new - goal).norm();
    Ok(if residue_m <= REACHED_M { Reach::Reached } else { Reach::Clamped { residue_m } })
}

/// Brings the limb's end link to a position *and* orientation in the world: what a planted foot or a
/// hand on a table needs. The end's joint must be a ball; its limits are not enforced.
///
/// # Errors
/// As [`solve_two_bone`], and an end that is no ball.
pub fn solve_two_bone_oriented(
    skeleton: &Skeleton,
    q: &mut [f64],
    limb: &Limb,
    world_from_end: &Transform,
) -> Result<Reach, IkError> {
    let end = &skeleton.links()[limb.end];
    if end.joint != Joint::Spherical {
        let (limb, link) = (limb.name.clone(), end.name.clone());
        return Err(IkError::Joint { limb, link, allowed: "a ball to keep an orientation" });
    }
    let reach = solve_two_bone(skeleton, q, limb, &world_from_end.translation.vector)?;
    let zero = world_from_zero(skeleton, q, limb.end).rotation;
    let turn = zero.inverse() * world_from_end.rotation;
    skeleton.set_rotation(q, limb.end, &Quat::new_normalize(turn.into_inner()));
    Ok(reach)
}
