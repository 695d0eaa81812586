//! The least rotation that takes bones where they point now: from a solved pose to the one a user sees.
//!
//! Positions of joints say nothing about the twist of a bone between two balls. In: the pose before a drag, and one that has
//! the joints where they have to be. Out: the pose with the same joint positions in which every such bone was turned, against
//! its parent, by the smallest rotation that points it where it points: about an axis normal to it, so that its twist is the one
//! it had (IAF09, §5, Fig. 5). Links whose orientation can be seen from positions keep the one they have.

use crate::rotation::{Quat, between};
use crate::skeleton::{Joint, Skeleton};
use crate::{Kinematics, Vec3};

/// A bone shorter than this has no direction, m.
const NO_BONE_M: f64 = 1e-9;

/// What positions say of a link's orientation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seen {
    /// All of it, or its joint is no ball: kept in the world.
    Whole,
    /// The direction of one bone, in the link's frame; m.
    Bone(Vec3),
    /// Nothing: kept against its parent.
    Nothing,
}

/// What positions say of each link. See [`Seen`].
///
/// * `whole`: links whose orientation in the world matters for other reasons
/// * `joined`: links that do not move against their parent
pub fn seen(skeleton: &Skeleton, whole: &[bool], joined: &[bool]) -> Vec<Seen> {
    let links = skeleton.links();
    let mut out = vec![Seen::Nothing; links.len()];
    for (i, link) in links.iter().enumerate() {
        let mut children = (i + 1..links.len()).filter(|&c| links[c].parent == Some(i));
        let (first, second) = (children.next(), children.next());
        let bone = match (first, second) {
            (None, _) => link.end,
            (Some(c), None) if matches!(links[c].joint, Joint::Spherical) && !joined[c] => {
                Some(links[c].parent_from_zero.translation.vector)
            }
            _ => None,
        };
        out[i] = match bone.filter(|b| b.norm() > NO_BONE_M) {
            _ if whole[i] || !matches!(link.joint, Joint::Spherical) => Seen::Whole,
            Some(bone) => Seen::Bone(bone),
            None if first.is_none() => Seen::Nothing,
            None => Seen::Whole,
        };
    }
    out
}

/// What is known of the links of a drag.
#[derive(Clone, Copy, Debug)]
pub struct Sight<'a> {
    /// What positions say.
    pub seen: &'a [Seen],
    /// Links whose orientation a handle off their joint shows.
    pub kept: &'a [bool],
    /// Links that do not move against their parent.
    pub joined: &'a [bool],
}

/// Turns the pose `q`, which `k` is of, back by what no position shows; `turned` is memory (one per link).
///
/// * `before`: the pose before
pub fn least(
    skeleton: &Skeleton,
    sight: &Sight,
    before: &[f64],
    k: &Kinematics,
    turned: &mut [Quat],
    q: &mut [f64],
) {
    for (i, link) in skeleton.links().iter().enumerate() {
        let parent = link.parent.map_or(Quat::identity(), |p| turned[p]);
        let zero = parent * link.parent_from_zero.rotation;
        let ball = matches!(link.joint, Joint::Spherical) && !sight.joined[i];
        let seen = if sight.kept[i] { Seen::Whole } else { sight.seen[i] };
        turned[i] = match seen {
            _ if !ball => zero * skeleton.rotation(q, i),
            Seen::Nothing => zero * skeleton.rotation(q, i),
            Seen::Whole => {
                // to the bit as it was where nothing above it turned
                let same = link.parent.is_none_or(|p| turned[p] == k.world[p].rotation);
                if !same {
                    skeleton.set_rotation(
                        q,
                        i,
                        &Quat::new_normalize((zero.inverse() * k.world[i].rotation).into_inner()),
                    );
                }
                k.world[i].rotation
            }
            Seen::Bone(bone) => {
                let r = skeleton.rotation(before, i);
                let wanted = zero.inverse() * (k.world[i].rotation * bone);
                let r = Quat::new_normalize((between(&(r * bone), &wanted) * r).into_inner());
                skeleton.set_rotation(q, i, &r);
                zero * r
            }
        };
    }
}
