//! Planted feet: legs follow the root so that feet stay where they stand.
//!
//! In: a pose whose root and upper body are set, and where each foot is planted. Out: the pose with hips,
//! knees and ankles solved, the root lowered where a leg would have to be longer than it is. Geometry
//! only; who shifts the root to keep balance is `controllers`.

use crate::ik::{IkError, Reach, reach_range, solve_two_bone_oriented, swivel};
use crate::skeleton::Joint;
use crate::{Kinematics, Limb, Skeleton, Transform, Vec3};

/// Where the middle joint of a held limb goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Knee {
    /// It keeps the swivel that the pose has: of captured motion, of arms.
    #[default]
    Kept,
    /// It follows the end and the link above the limb, as [`swivel`] says: of written motion.
    Follows,
}

/// A foot (or hand) held in place.
#[derive(Clone, Debug, PartialEq)]
pub struct Plant {
    /// The limb whose end is held.
    pub limb: Limb,
    /// Where: `world_from_end`.
    pub world_from_end: Transform,
    /// Where its middle joint goes.
    pub knee: Knee,
}

/// A leg is never pulled straighter than this fraction of its full length: 3.6° of knee flexion for
/// equal bones. At full stretch the knee's rate is unbounded.
pub const STRAIGHTEST: f64 = 0.9995;

impl Plant {
    /// Holds the end of `limb` where it is in the pose `q`.
    pub fn here(skeleton: &Skeleton, q: &[f64], limb: &Limb) -> Self {
        let kinematics = Kinematics::new(skeleton, q);
        Self { limb: limb.clone(), world_from_end: kinematics.world[limb.end], knee: Knee::Kept }
    }
}

/// Solves the planted limbs of `q`, lowering a free root first if a limb cannot reach.
///
/// Returns how far (m) the worst limb stays from its plant: zero to rounding unless the plants are too
/// far apart for the body.
///
/// # Errors
/// Limbs that two-bone IK cannot solve, see [`IkError`].
pub fn plant(skeleton: &Skeleton, q: &mut [f64], plants: &[Plant]) -> Result<f64, IkError> {
    if matches!(skeleton.links()[0].joint, Joint::Free) {
        let lower = shortfall(skeleton, q, plants)?;
        if lower > 0.0 {
            let p = skeleton.position(q, 0) - Vec3::y() * lower;
            skeleton.set_position(q, 0, &p);
        }
    }
    let mut worst: f64 = 0.0;
    for p in plants {
        if let Reach::Clamped { residue_m } =
            solve_two_bone_oriented(skeleton, q, &p.limb, &p.world_from_end)?
        {
            worst = worst.max(residue_m);
        }
        if p.knee == Knee::Follows {
            swivel::turn(skeleton, q, &p.limb, swivel::missing(skeleton, q, &p.limb));
        }
    }
    Ok(worst)
}

/// How far the root must come down so that every plant is within reach, m; zero if it need not.
///
/// # Errors
/// Limbs that two-bone IK cannot solve, see [`IkError`].
pub fn shortfall(skeleton: &Skeleton, q: &[f64], plants: &[Plant]) -> Result<f64, IkError> {
    let kinematics = Kinematics::new(skeleton, q);
    let mut lower: f64 = 0.0;
    for p in plants {
        let reach = reach_range(skeleton, q, &p.limb)?.1 * STRAIGHTEST;
        let hip = kinematics.origin(p.limb.upper);
        let from_plant = hip - p.world_from_end.translation.vector;
        let across = from_plant.x.hypot(from_plant.z);
        if from_plant.norm() > reach && across < reach {
            // |hip − δ y − plant| = reach
            lower = lower.max(from_plant.y - (reach * reach - across * across).sqrt());
        }
    }
    Ok(lower)
}
