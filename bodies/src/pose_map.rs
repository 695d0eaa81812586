//! Poses between a clip's skeleton and a character's.
//!
//! In: two skeletons with the same links in the same order. Of the character's, some joints may be welded, its zero
//! frames may be turned (a file's zero pose need not stand), and its root may be a link below the clip's root: then
//! the links above it and what else hangs on them are the clip's alone. Out: poses and clips of one for the other.
//!
//! - A welded joint of the character stays where its zero frame has it; on the way back it keeps the clip's values.
//! - A turned zero frame: with `Z` the rotation from the clip's zero frame to the character's, the joint's
//!   rotations are `R_clip = Z R_character`.
//! - A root below the clip's: it moves as its link does in the world. On the way back the last free joint at or above
//!   it carries the motion, and the others keep the clip's values.
//!
//! A file format may know balls only: one that turns about the axis of the character's hinge in every frame, within
//! [`OFF_AXIS_RAD`], is that hinge ([`PoseMap::of_clip`]).

use std::ops::Range;
use std::sync::Arc;

use motion::skeleton::quat_at;
use motion::{Clip, Joint, Limits, Link, Quat, Skeleton, Transform, Vec3, rotation};
use thiserror::Error;

/// Farthest turn of a ball away from a hinge's axis with which it still is that hinge, rad: what rounding to a tenth of a
/// degree leaves.
pub const OFF_AXIS_RAD: f64 = 0.002;

/// Why two skeletons cannot be mapped.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PoseMapError {
    /// Different numbers of links.
    #[error(
        "the clip has {clip} links from `{root}` on and the character {character}; they must be the same"
    )]
    Count {
        /// The character's root.
        root: String,
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
        /// Index of the link in the clip.
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

/// Zero frames that differ by less are one, rad.
const SAME_FRAME: f64 = 1e-12;
/// Zero frames of a hinge differ by a turn about its axis, up to this, rad: characters are written with six decimals.
const SAME_AXIS: f64 = 1e-6;

fn set_quat(q: &mut [f64], r: &Quat) {
    q.copy_from_slice(&[r.w, r.i, r.j, r.k]);
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

/// How the values of one joint are carried over.
#[derive(Clone, Debug, PartialEq)]
enum Piece {
    /// As they are.
    Same,
    /// Rotations turned by Z, see the module header.
    Turned(Quat),
    /// Angles about the same axis, this much larger in the clip, rad.
    Ahead(f64),
}

/// The links of a clip from its root to the character's.
#[derive(Clone, Debug, PartialEq)]
struct Above {
    clip: Skeleton,
    /// From the clip's root to the character's root, both included.
    chain: Vec<usize>,
    /// Index in `chain` of the joint that carries the motion on the way back.
    carrier: usize,
}

impl Above {
    fn new(clip: &Skeleton, root: usize) -> Self {
        let mut chain: Vec<usize> = clip.ancestors(root).collect();
        chain.reverse();
        let free = |i: &usize| clip.links()[*i].joint == Joint::Free;
        let carrier = chain.iter().rposition(free).unwrap_or(0);
        Self { clip: clip.clone(), chain, carrier }
    }

    /// Transform over some of the chain's joints.
    fn over(&self, q: &[f64], links: &[usize]) -> Transform {
        let joint = |&i: &usize| self.clip.links()[i].parent_from_zero * self.clip.joint_transform(q, i);
        links.iter().map(joint).fold(Transform::identity(), |a, b| a * b)
    }

    fn world(&self, q: &[f64]) -> Transform {
        self.over(q, &self.chain)
    }

    /// Moves the carrier so that the end of the chain is at `world`.
    fn move_to(&self, world: &Transform, q: &mut [f64]) {
        let link = self.chain[self.carrier];
        let before = self.over(q, &self.chain[..self.carrier]) * self.clip.links()[link].parent_from_zero;
        let after = self.over(q, &self.chain[self.carrier + 1..]);
        let joint = before.inverse() * world * after.inverse();
        let was = self.clip.rotation(q, link);
        let near = joint.rotation.coords.dot(&was.coords) >= 0.0;
        let turn = if near { joint.rotation } else { Quat::new_unchecked(-joint.rotation.into_inner()) };
        self.clip.set_rotation(q, link, &turn);
        self.clip.set_position(q, link, &joint.translation.vector);
    }
}

/// Carries joint values between two layouts. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseMap {
    /// Slices of the clip's pose, starts in the character's, and what lies between.
    pieces: Vec<(Range<usize>, usize, Piece)>,
    /// Where the character's root is not the clip's: what is above it.
    above: Option<Above>,
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
    /// From the clip's zero frame to the character's.
    zero: Quat,
    /// Angle next to which values are given: the middle of the hinge's range, rad.
    middle: f64,
}

impl Hinge {
    fn ball(&self, clip: &[f64]) -> Quat {
        self.zero.inverse() * quat_at(clip, self.at[0])
    }

    fn angle(&self, clip: &[f64], near: f64) -> f64 {
        let (_, twist) = rotation::swing_twist(&self.ball(clip), &self.axis);
        let x = rotation::log(&twist).dot(&self.axis);
        x + std::f64::consts::TAU * ((near - x) / std::f64::consts::TAU).round()
    }

    fn off_axis(&self, clip: &[f64]) -> f64 {
        let (swing, _) = rotation::swing_twist(&self.ball(clip), &self.axis);
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
        let root = clip.link(&b[0].name).filter(|&i| i > 0 && b[0].joint == Joint::Free).unwrap_or(0);
        let below: Vec<usize> = (0..a.len()).filter(|&i| clip.ancestors(i).any(|up| up == root)).collect();
        if below.len() != b.len() {
            let root = a[root].name.clone();
            return Err(PoseMapError::Count { root, clip: below.len(), character: b.len() });
        }
        let (mut pieces, mut hinges) = (Vec::new(), Vec::new());
        for (j, &i) in below.iter().enumerate() {
            let folded = j == 0 && root > 0;
            let same_joint = a[i].joint == b[j].joint;
            let axis = match (a[i].joint, b[j].joint) {
                (Joint::Spherical, Joint::Revolute(axis)) if balls => Some(axis),
                _ => None,
            };
            let parent = a[i].parent.and_then(|p| below.binary_search(&p).ok());
            let fits = folded
                || parent == b[j].parent && (same_joint || axis.is_some() || b[j].joint == Joint::Fixed);
            let other = || PoseMapError::Link { index: i, clip: described(a, i), character: described(b, j) };
            if a[i].name != b[j].name || !fits {
                return Err(other());
            }
            let zero = a[i].parent_from_zero.rotation.inverse() * b[j].parent_from_zero.rotation;
            if same_joint && a[i].joint.nq() > 0 && !folded {
                let turn = rotation::log(&zero);
                let piece = match a[i].joint {
                    _ if turn.norm() < SAME_FRAME => Piece::Same,
                    Joint::Spherical => Piece::Turned(zero),
                    Joint::Revolute(axis) if turn.cross(&axis).norm() < SAME_AXIS => {
                        Piece::Ahead(turn.dot(&axis))
                    }
                    _ => return Err(other()),
                };
                let at = clip.q_at(i);
                pieces.push((at..at + a[i].joint.nq(), character.q_at(j), piece));
            }
            if let Some(axis) = axis {
                let middle = match &b[j].limits {
                    Some(Limits::Axis(range)) => 0.5 * (range.lo + range.hi),
                    _ => 0.0,
                };
                hinges.push(Hinge { link: j, at: [clip.q_at(i), character.q_at(j)], axis, zero, middle });
            }
        }
        let above = (root > 0).then(|| Above::new(clip, root));
        Ok(Self { pieces, above, hinges, nq: [clip.nq(), character.nq()] })
    }

    /// The character's pose of a clip's pose.
    pub fn to_character(&self, clip: &[f64], character: &mut [f64]) {
        for (from, to, piece) in &self.pieces {
            let out = &mut character[*to..to + from.len()];
            out.copy_from_slice(&clip[from.clone()]);
            match piece {
                Piece::Same => {}
                Piece::Turned(z) => set_quat(out, &(z.inverse() * quat_at(out, 0))),
                Piece::Ahead(angle) => out[0] -= angle,
            }
        }
        for hinge in &self.hinges {
            character[hinge.at[1]] = hinge.angle(clip, hinge.middle);
        }
        if let Some(above) = &self.above {
            let world = above.world(clip);
            character[..3].copy_from_slice(world.translation.vector.as_slice());
            set_quat(&mut character[3..7], &world.rotation);
        }
    }

    /// Writes the character's pose into the clip's; joints that are welded in the character stay.
    pub fn to_clip(&self, character: &[f64], clip: &mut [f64]) {
        for (to, from, piece) in &self.pieces {
            let out = &mut clip[to.clone()];
            out.copy_from_slice(&character[*from..from + to.len()]);
            match piece {
                Piece::Same => {}
                Piece::Turned(z) => set_quat(out, &(z * quat_at(out, 0))),
                Piece::Ahead(angle) => out[0] += angle,
            }
        }
        for hinge in &self.hinges {
            let turn = hinge.zero * rotation::exp(&(hinge.axis * character[hinge.at[1]]));
            set_quat(&mut clip[hinge.at[0]..hinge.at[0] + 4], &turn);
        }
        if let Some(above) = &self.above {
            let at = Vec3::from_column_slice(&character[..3]);
            let world = Transform::from_parts(at.into(), quat_at(character, 3));
            above.move_to(&world, clip);
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
    use motion::Kinematics;

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

    /// A pose whose values say nothing about one another, rotations normalised.
    fn any_pose(s: &Skeleton, seed: f64) -> Vec<f64> {
        let v: Vec<f64> = (0..s.nv()).map(|i| (seed + 1.7 * i as f64).sin()).collect();
        let mut q = s.zero_pose();
        s.integrate(&mut q, &v, 1.0);
        q
    }

    /// A root above the pelvis and a prop beside it are the clip's alone: points of the body are where the clip has them, and a
    /// pose that comes back moves the body there, with the least that can carry it.
    #[test]
    fn what_is_above_the_pelvis_is_folded_into_it() {
        for hips in [Joint::Free, Joint::Spherical] {
            let mut above = vec![
                Link::new("reference", None, Vec3::zeros(), Joint::Free),
                Link::new("prop", Some(0), Vec3::z(), Joint::Free),
                Link::new("hips", Some(0), Vec3::new(0.1, 0.9, 0.2), hips),
                Link::new("knee", Some(2), Vec3::y(), Joint::Revolute(Vec3::x())),
                Link::new("foot", Some(3), Vec3::y(), Joint::Spherical),
            ];
            let clip = Skeleton::new(above.clone()).unwrap();
            let mut links = above.split_off(2);
            links[0] = Link::new("hips", None, Vec3::zeros(), Joint::Free);
            (links[1].parent, links[2].parent) = (Some(0), Some(1));
            let body = Skeleton::new(links).unwrap();
            let map = PoseMap::new(&clip, &body).unwrap();
            let q = any_pose(&clip, 0.3);
            let mut on_body = body.zero_pose();
            map.to_character(&q, &mut on_body);
            let (a, b) = (Kinematics::new(&clip, &q), Kinematics::new(&body, &on_body));
            for (i, j) in [(2, 0), (3, 1), (4, 2)] {
                let apart = a.world[i].inverse() * b.world[j];
                let error = apart.translation.vector.norm() + apart.rotation.angle();
                assert!(error < 1e-7, "{i}: {error}"); // 3e-8 seen: an angle near zero
            }
            let mut back = q.clone();
            map.to_clip(&on_body, &mut back);
            assert!(q.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-12), "{q:?} {back:?}");
            // another pose: the body is there, the prop stays in its parent
            let there = any_pose(&body, 1.1);
            map.to_clip(&there, &mut back);
            let mut again = body.zero_pose();
            map.to_character(&back, &mut again);
            let same = |i: usize| {
                Kinematics::new(&body, &there).world[i].inverse() * Kinematics::new(&body, &again).world[i]
            };
            assert!(
                (0..3).all(|i| same(i).translation.vector.norm() < 1e-12 && same(i).rotation.angle() < 1e-7)
            );
            let prop = clip.q_at(1)..clip.q_at(1) + 7;
            assert_eq!(q[prop.clone()], back[prop]);
        }
    }

    /// Zero frames that are turned: the same points in the world, and the clip's values come back.
    #[test]
    fn turned_zero_frames_carry_the_same_pose() {
        let links = vec![
            Link::new("hips", None, Vec3::zeros(), Joint::Free),
            Link::new("arm", Some(0), Vec3::x(), Joint::Spherical),
            Link::new("hand", Some(1), Vec3::x(), Joint::Revolute(Vec3::z())),
        ];
        let clip = Skeleton::new(links.clone()).unwrap();
        let mut turned = links;
        turned[1].parent_from_zero.rotation = motion::rotation::exp(&Vec3::new(0.3, -1.2, 0.5));
        turned[2].parent_from_zero.rotation = motion::rotation::exp(&(Vec3::z() * 0.7));
        let body = Skeleton::new(turned.clone()).unwrap();
        let map = PoseMap::new(&clip, &body).unwrap();
        let q = any_pose(&clip, 0.3);
        let mut on_body = body.zero_pose();
        map.to_character(&q, &mut on_body);
        let (a, b) = (Kinematics::new(&clip, &q), Kinematics::new(&body, &on_body));
        for i in 0..3 {
            let apart = a.world[i].inverse() * b.world[i];
            assert!(apart.translation.vector.norm() < 1e-14 && apart.rotation.angle() < 1e-7, "{i}");
        }
        let mut back = clip.zero_pose();
        map.to_clip(&on_body, &mut back);
        assert!(q.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-14), "{q:?} {back:?}");
        // a hinge turned about another axis is another hinge
        turned[2].parent_from_zero.rotation = motion::rotation::exp(&(Vec3::x() * 0.7));
        let other = Skeleton::new(turned).unwrap();
        assert!(matches!(PoseMap::new(&clip, &other), Err(PoseMapError::Link { index: 2, .. })));
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
