//! Geometry of a [`Bvh`]: where its joints are in a frame, and which of them are head and feet.
//!
//! In: a file. Out: rotations and positions, file axes and units.

use motion::rotation::{Quat, Vec3};

use super::{Bvh, BvhJoint, Channel};

/// The product of a joint's rotation channels, left to right.
pub fn rotation(joint: &BvhJoint, values: &[f64]) -> Quat {
    let mut product = Quat::identity();
    for (channel, &value) in joint.channels.iter().zip(values) {
        if let Channel::Rotation(axis) = *channel {
            let (sin, cos) = (0.5 * value.to_radians()).sin_cos();
            let mut q = [0.0; 3];
            q[axis] = sin;
            product *= Quat::new_unchecked(nalgebra::Quaternion::new(cos, q[0], q[1], q[2]));
        }
    }
    product
}

/// A joint's origin in its parent's frame, file units: position channels replace the offset.
pub fn origin(joint: &BvhJoint, values: &[f64]) -> Vec3 {
    let mut at = Vec3::from(joint.offset);
    for (channel, &value) in joint.channels.iter().zip(values) {
        if let Channel::Position(axis) = *channel {
            at[axis] = value;
        }
    }
    at
}

/// The values of a joint in a frame.
pub fn of_joint<'a>(joint: &BvhJoint, frame: &'a [f64]) -> &'a [f64] {
    &frame[joint.channels_at..joint.channels_at + joint.channels.len()]
}

/// World rotations and origins of the joints in a frame; with `None` all channels are zero, and
/// positions offsets.
pub fn world(bvh: &Bvh, frame: Option<&[f64]>) -> Vec<(Quat, Vec3)> {
    let mut world: Vec<(Quat, Vec3)> = Vec::with_capacity(bvh.joints.len());
    for joint in &bvh.joints {
        let (turn, at) = match frame {
            Some(frame) => {
                let values = of_joint(joint, frame);
                (rotation(joint, values), origin(joint, values))
            }
            None => (Quat::identity(), Vec3::from(joint.offset)),
        };
        let (up, from) = joint.parent.map_or((Quat::identity(), Vec3::zeros()), |p| world[p]);
        world.push((up * turn, from + up * at));
    }
    world
}

/// The head and the feet (or ankles), by name.
pub struct Landmarks {
    /// The first joint called head.
    pub head: usize,
    /// Of each leg the first joint called foot or ankle.
    pub feet: Vec<usize>,
}

impl Landmarks {
    /// `None` without a head or without feet.
    pub fn find(bvh: &Bvh) -> Option<Self> {
        let names: Vec<String> = bvh.joints.iter().map(|j| j.name.to_lowercase()).collect();
        let head = names.iter().position(|n| n.contains("head"))?;
        let is_foot = |n: &str| n.contains("foot") || n.contains("ankle");
        // In each leg the first one: a `FootEnd` hangs on a foot.
        let mut below = vec![false; names.len()];
        let mut feet = Vec::new();
        for (i, joint) in bvh.joints.iter().enumerate() {
            let inherited = joint.parent.is_some_and(|p| below[p]);
            below[i] = inherited || is_foot(&names[i]);
            if below[i] && !inherited {
                feet.push(i);
            }
        }
        (!feet.is_empty()).then_some(Self { head, feet })
    }

    /// From the mean of the feet to the head, unit length (zero if they coincide).
    pub fn feet_to_head(&self, world: &[(Quat, Vec3)]) -> Vec3 {
        let feet: Vec3 = self.feet.iter().map(|&f| world[f].1).sum::<Vec3>() / self.feet.len() as f64;
        (world[self.head].1 - feet).try_normalize(1e-12).unwrap_or_else(Vec3::zeros)
    }
}
