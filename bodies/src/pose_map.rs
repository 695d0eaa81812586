//! Poses between a clip's skeleton and a character's.
//!
//! In: two skeletons with the same links at the same indices, of which the second has some joints
//! welded. Out: poses and clips of one for the other. A welded joint of the character stays where the
//! clip has it at zero; on the way back it keeps the clip's values.

use std::ops::Range;
use std::sync::Arc;

use motion::{Clip, Joint, Link, Skeleton};
use thiserror::Error;

/// Why two skeletons cannot be mapped.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PoseMapError {
    /// Different numbers of links.
    #[error("the clip has {clip} links and the character {character}; they must be the same")]
    Count {
        /// Links of the clip.
        clip: usize,
        /// Links of the character.
        character: usize,
    },
    /// A link of another name or joint.
    #[error(
        "link {index} is {clip} in the clip and {character} in the character: name, parent and joint must agree, except that the character's may be welded"
    )]
    Link {
        /// Index of the link.
        index: usize,
        /// Name, joint and parent in the clip.
        clip: String,
        /// Name, joint and parent in the character.
        character: String,
    },
}

fn described(links: &[Link], i: usize) -> String {
    let joint = match links[i].joint {
        Joint::Free => "free",
        Joint::Spherical => "a ball",
        Joint::Revolute(_) => "a hinge",
        Joint::Prismatic(_) => "a slide",
        Joint::Fixed => "welded",
    };
    match links[i].parent {
        Some(p) => format!("`{}` ({joint} on `{}`)", links[i].name, links[p].name),
        None => format!("`{}` ({joint})", links[i].name),
    }
}

/// Copies joint values between two layouts. See the module header.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PoseMap {
    /// Slices of the clip's pose and starts in the character's.
    pieces: Vec<(Range<usize>, usize)>,
    nq: [usize; 2],
}

impl PoseMap {
    /// A map from the skeleton of a clip to that of a character.
    ///
    /// # Errors
    /// See [`PoseMapError`].
    pub fn new(clip: &Skeleton, character: &Skeleton) -> Result<Self, PoseMapError> {
        let (a, b) = (clip.links(), character.links());
        if a.len() != b.len() {
            return Err(PoseMapError::Count { clip: a.len(), character: b.len() });
        }
        let mut pieces = Vec::new();
        for i in 0..a.len() {
            let same_joint = a[i].joint == b[i].joint;
            if a[i].name != b[i].name
                || a[i].parent != b[i].parent
                || !(same_joint || b[i].joint == Joint::Fixed)
            {
                return Err(PoseMapError::Link {
                    index: i,
                    clip: described(a, i),
                    character: described(b, i),
                });
            }
            if same_joint && a[i].joint.nq() > 0 {
                let at = clip.q_at(i);
                pieces.push((at..at + a[i].joint.nq(), character.q_at(i)));
            }
        }
        Ok(Self { pieces, nq: [clip.nq(), character.nq()] })
    }

    /// The character's pose of a clip's pose.
    pub fn to_character(&self, clip: &[f64], character: &mut [f64]) {
        for (from, to) in &self.pieces {
            character[*to..to + from.len()].copy_from_slice(&clip[from.clone()]);
        }
    }

    /// Writes the character's pose into the clip's; joints that are welded in the character stay.
    pub fn to_clip(&self, character: &[f64], clip: &mut [f64]) {
        for (to, from) in &self.pieces {
            clip[to.clone()].copy_from_slice(&character[*from..from + to.len()]);
        }
    }

    /// A whole clip for the character.
    pub fn clip_to_character(&self, clip: &Clip, character: &Arc<Skeleton>) -> Clip {
        let mut q = vec![0.0; clip.frames() * self.nq[1]];
        for (i, out) in q.chunks_exact_mut(self.nq[1]).enumerate() {
            self.to_character(clip.pose(i), out);
        }
        Clip::new(character.clone(), clip.rate_hz, q)
    }

    /// A clip of the character for the skeleton of `source`, which gives the values of the welded
    /// joints (sampled at the times of `clip`).
    pub fn clip_to_source(&self, clip: &Clip, source: &Clip) -> Clip {
        let mut q = vec![0.0; clip.frames() * self.nq[0]];
        for (i, out) in q.chunks_exact_mut(self.nq[0]).enumerate() {
            source.sample(i as f64 / clip.rate_hz, out);
            self.to_clip(clip.pose(i), out);
        }
        Clip::new(source.skeleton.clone(), clip.rate_hz, q)
    }
}

#[cfg(test)]
mod tests {
    use motion::Vec3;

    use super::*;

    /// There and back is the identity on what moves, and leaves the rest alone.
    #[test]
    fn welded_joints_keep_the_clip_s_values() {
        let links = |hand: Joint| {
            vec![
                Link::new("hips", None, Vec3::zeros(), Joint::Free),
                Link::new("hand", Some(0), Vec3::x(), hand),
                Link::new("foot", Some(0), Vec3::y(), Joint::Revolute(Vec3::x())),
            ]
        };
        let clip = Skeleton::new(links(Joint::Spherical)).unwrap();
        let body = Skeleton::new(links(Joint::Fixed)).unwrap();
        let map = PoseMap::new(&clip, &body).unwrap();
        let from: Vec<f64> = (0..12).map(f64::from).collect();
        let mut to = vec![0.0; body.nq()];
        map.to_character(&from, &mut to);
        assert_eq!(to, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 11.0]);
        to.iter_mut().for_each(|x| *x += 0.5);
        let mut back = from.clone();
        map.to_clip(&to, &mut back);
        assert_eq!(back, [0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.0, 8.0, 9.0, 10.0, 11.5]);
        assert!(matches!(PoseMap::new(&body, &clip), Err(PoseMapError::Link { index: 1, .. })));
    }
}
