//! Balanced posture: the pelvis moves so that the centre of mass stays over the feet.
//!
//! In: a pose with its upper body set and feet planted, and where the centre of mass should be over
//! the ground. Out: the same pose with the root shifted in the horizontal plane and the legs solved. Used
//! for the kinematic preview of a standing scene and, every step, for the goals of the legs.

use dynamics::{Model, State};
use motion::Vec3;
use motion::ik::IkError;
use motion::plant::{Plant, plant};
use motion::support::{Vec2, ground};

/// Shifts the root of `q` until its centre of mass projects to `target` (x, z, m), feet planted.
///
/// Fixed-point iteration: moving the root moves all but the feet, so a few rounds reach 0.1 mm.
/// Returns the distance left, m.
///
/// # Errors
/// Limbs that two-bone IK cannot solve.
pub fn settle(
    model: &Model,
    state: &mut State,
    q: &mut [f64],
    plants: &[Plant],
    target: Vec2,
) -> Result<f64, IkError> {
    let skeleton = &model.skeleton;
    let still = vec![0.0; model.nv()];
    let mut left = f64::INFINITY;
    for _ in 0..8 {
        plant(skeleton, q, plants)?;
        state.update(model, q, &still);
        let error = target - ground(&state.com(model));
        left = error.norm();
        if left < 1e-4 {
            break;
        }
        let p = skeleton.position(q, 0) + Vec3::new(error.x, 0.0, error.y);
        skeleton.set_position(q, 0, &p);
    }
    Ok(left)
}
