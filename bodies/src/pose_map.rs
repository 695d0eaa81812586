//! Poses between a clip's skeleton and a character's.
//!
//! In: two skeletons with the same links at the same indices, of which the second has some joints
//! welded. Out: poses and clips of one for the other. A welded joint of the character stays where the
//! clip has it at zero; on the way back it keeps the clip's values.
//!
//! A file format may know balls only: one that turns about the axis of the character's hinge in every frame, within
//! [`OFF_AXIS_RAD`], is that hinge ([`PoseMap::of_clip`]).

use std::ops::Range;
use std::sync::Arc;

use motion::skeleton::quat_at;
use motion::{Clip, Joint, Limits, Link, Quat, Skeleton, Vec3, rotation};
use thiserror::Error;

/// Farthest turn of a ball away from a hinge's axis with which it still is that hinge, rad: what rounding to a tenth of a
/// degree leaves.
pub const OFF_AXIS_RAD: f64 = 0.002;

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
    /// A ball that turns about more than the axis of the character's hinge.
    #[error(
        "`{link}` is a ball in the clip and a hinge in the character, and turns {:.1}° away from the hinge's axis at {at_s:.3} s; allowed: {:.1}°",
        .off_rad.to_degrees(),
        OFF_AXIS_RAD.to_degrees()
    )]
    OffAxis {
        /// The link.
        link: String,
        /// Moment of its farthest turn away from the axis, s.
        at_s: f64,
        /// That turn, rad.
        off_rad: f64,
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
#[derive(Clone, Debug, PartialEq)]
pub struct PoseMap {
    /// Slices of the clip's pose and starts in the character's.
    pieces: Vec<(Range<usize>, usize)>,
    /// Balls of the clip that are hinges of the character.
    hinges: Vec<Hinge>,
    nq: [usize; 2],
}

/// A ball of a clip that turns about one axis.
#[derive(Clone, Debug, PartialEq)]
struct Hinge {
    link: usize,
    /// Where its value starts in the clip's pose and in the character's.
    at: [usize; 2],
    axis: Vec3,
    /// Angle next to which values are given: the middle of the hinge's range, rad.
    middle: f64,
}

impl Hinge {
    fn angle(&self, clip: &[f64], near: f64) -> f64 {
        let (_, twist) = rotation::swing_twist(&quat_at(clip, self.at[0]), &self.axis);
        let x = rotation::log(&twist).dot(&self.axis);
        x + std::f64::consts::TAU * ((near - x) / std::f64::consts::TAU).round()
    }

    fn off_axis(&self, clip: &[f64]) -> f64 {
        let (swing, _) = rotation::swing_twist(&quat_at(clip, self.at[0]), &self.axis);
        rotation::log(&swing).norm()
    }
}

impl PoseMap {
    /// A map from the skeleton of a clip to that of a character: the same joints, or welded ones.
    ///
    /// # Errors
    /// See [`PoseMapError`].
    pub fn new(clip: &Skeleton, character: &Skeleton) -> Result<Self, PoseMapError> {
        Self::of_skeletons(clip, character, false)
    }

    /// A map from a clip to a character, whose hinges may be balls of the clip that turn about one axis.
    ///
    /// # Errors
    /// As [`PoseMap::new`]; a ball that turns about more than its hinge's axis.
    pub fn of_clip(clip: &Clip, character: &Skeleton) -> Result<Self, PoseMapError> {
        let map = Self::of_skeletons(&clip.skeleton, character, true)?;
        for hinge in &map.hinges {
            let off = (0..clip.frames()).map(|i| (hinge.off_axis(clip.pose(i)), i));
            if let Some((off_rad, frame)) = off.max_by(|a, b| a.0.total_cmp(&b.0))
                && off_rad > OFF_AXIS_RAD
            {
                let (link, at_s) = (character.links()[hinge.link].name.clone(), frame as f64 / clip.rate_hz);
                return Err(PoseMapError::OffAxis { link, at_s, off_rad });
            }
        }
        Ok(map)
    }

    fn of_skeletons(clip: &Skeleton, character: &Skeleton, balls: bool) -> Result<Self, PoseMapError> {
        let (a, b) = (clip.links(), character.links());
        if a.len() != b.len() {
            return Err(PoseMapError::Count { clip: a.len(), character: b.len() });
        }
        let (mut pieces, mut hinges) = (Vec::new(), Vec::new());
        for i in 0..a.len() {
            let same_joint = a[i].joint == b[i].joint;
            let axis = match (a[i].joint, b[i].joint) {
                (Joint::Spherical, Joint::Revolute(axis)) if balls => Some(axis),
                _ => None,
            };
            if a[i].name != b[i].name
                || a[i].parent != b[i].parent
                || !(same_joint || axis.is_some() || b[i].joint == Joint::Fixed)
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
            if let Some(axis) = axis {
                let middle = match &b[i].limits {
                    Some(Limits::Axis(range)) => 0.5 * (range.lo + range.hi),
                    _ => 0.0,
                };
                hinges.push(Hinge { link: i, at: [clip.q_at(i), character.q_at(i)], axis, middle });
            }
        }
        Ok(Self { pieces, hinges, nq: [clip.nq(), character.nq()] })
    }

    /// The character's pose of a clip's pose.
    pub fn to_character(&self, clip: &[f64], character: &mut [f64]) {
        for (from, to) in &self.pieces {
            character[*to..to + from.len()].copy_from_slice(&clip[from.clone()]);
        }
        for hinge in &self.hinges {
            character[hinge.at[1]] = hinge.angle(clip, hinge.middle);
        }
    }

    /// Writes the character's pose into the clip's; joints that are welded in the character stay.
    pub fn to_clip(&self, character: &[f64], clip: &mut [f64]) {
        for (to, from) in &self.pieces {
            clip[to.clone()].copy_from_slice(&character[*from..from + to.len()]);
        }
        for hinge in &self.hinges {
            let turn: Quat = rotation::exp(&(hinge.axis * character[hinge.at[1]]));
            clip[hinge.at[0]..hinge.at[0] + 4].copy_from_slice(&[turn.w, turn.i, turn.j, turn.k]);
        }
    }

    /// A whole clip for the character.
    pub fn clip_to_character(&self, clip: &Clip, character: &Arc<Skeleton>) -> Clip {
        let mut q = vec![0.0; clip.frames() * self.nq[1]];
        let mut before: Vec<f64> = self.hinges.iter().map(|h| h.middle).collect();
        for (i, out) in q.chunks_exact_mut(self.nq[1]).enumerate() {
            self.to_character(clip.pose(i), out);
            // a hinge that turns on and on does not jump by a turn
            for (hinge, before) in self.hinges.iter().zip(&mut before) {
                *before = hinge.angle(clip.pose(i), *before);
                out[hinge.at[1]] = *before;
            }
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

    /// A ball that turns about one axis is the character's hinge, there and back, over more than half a turn and within the
    /// hinge's range; one that turns away from the axis is refused by name and moment.
    #[test]
    fn a_ball_about_one_axis_is_a_hinge() {
        let axis = Vec3::new(0.6, 0.0, 0.8);
        let links = |arm: Joint| {
            let mut arm = Link::new("arm", Some(0), Vec3::x(), arm);
            if let Joint::Revolute(_) = arm.joint {
                arm.limits = Some(Limits::Axis(motion::Range::new(-0.5, 5.0)));
            }
            vec![Link::new("hips", None, Vec3::zeros(), Joint::Free), arm]
        };
        let ball = Arc::new(Skeleton::new(links(Joint::Spherical)).unwrap());
        let hinge = Arc::new(Skeleton::new(links(Joint::Revolute(axis))).unwrap());
        let angles: Vec<f64> = (0..50).map(|i| 0.1 * f64::from(i)).collect();
        let pose = |angle: &f64| {
            let mut q = ball.zero_pose();
            ball.set_rotation(&mut q, 1, &rotation::exp(&(axis * *angle)));
            q
        };
        let mut clip = Clip::new(ball.clone(), 10.0, angles.iter().flat_map(pose).collect());
        assert!(matches!(PoseMap::new(&ball, &hinge), Err(PoseMapError::Link { index: 1, .. })));
        let map = PoseMap::of_clip(&clip, &hinge).unwrap();
        let own = map.clip_to_character(&clip, &hinge);
        for (i, angle) in angles.iter().enumerate() {
            assert!((own.pose(i)[hinge.q_at(1)] - angle).abs() < 1e-12, "{i}"); // 1e-15 seen
            let mut one = hinge.zero_pose();
            map.to_character(clip.pose(i), &mut one);
            assert!((one[hinge.q_at(1)] - angle).abs() < 1e-12, "{i}");
        }
        let back = map.clip_to_source(&own, &clip);
        for i in 0..clip.frames() {
            let off = ball.rotation(back.pose(i), 1).angle_to(&ball.rotation(clip.pose(i), 1));
            assert!(off < 1e-7, "{i}: {off}"); // 1e-8 seen: the angle between nearly equal rotations
        }
        let away = rotation::exp(&(Vec3::y() * 0.02));
        let turned = away * ball.rotation(clip.pose(7), 1);
        ball.set_rotation(clip.pose_mut(7), 1, &turned);
        let refused = PoseMap::of_clip(&clip, &hinge).unwrap_err().to_string();
        assert!(
            refused.contains("`arm`") && refused.contains("0.700 s") && refused.contains("1.1°"),
            "{refused}"
        );
    }
}
