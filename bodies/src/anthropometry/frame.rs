//! The anatomical neutral pose of a skeleton: upright, arms hanging, legs straight down, feet forward.
//!
//! A file's zero pose is a T, an A, splayed thighs or anything else. Limits, masses and contact
//! points are stated for the neutral pose, so here it is found: from the zero pose, or from a
//! standing *reference* pose where the zero pose is not one, each limb bone is turned by the smallest
//! rotation that makes it hang. The trunk stays as the reference has it. Feet go with their shins, but stay as they
//! lie flat where they are lowest in the motion, if the reference is a posed frame: someone who stands has flat feet,
//! whatever the legs lean. A posed frame may also have a leg or an arm turned about itself: the axes about which knees
//! and elbows bend in the motion lie across the body in the neutral pose. [`Posed`] has both.
//!
//! Symbols: `left`, `up`, `front` unit vectors of the body in the world (up is +Y); a link's *bone*
//! is the vector from its joint to the next one along the body.

use motion::rotation::{between, exp, swing_twist};
use motion::{Clip, Kinematics, Quat, Skeleton, Vec3};

use super::aliases::{Anatomy, Role, Side};
use super::error::GuessError;
use super::segments::Table;

/// A skeleton in its neutral pose. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Neutral {
    /// World rotation of each link.
    pub rotation: Vec<Quat>,
    /// World position of each link's origin, m.
    pub origin: Vec<Vec3>,
    /// Bone of each link in its own frame, m; zero where there is none.
    pub bone: Vec<Vec3>,
    /// The character's left, horizontal.
    pub left: Vec3,
    /// The character's front, horizontal.
    pub front: Vec3,
    /// Stature that the legs suggest, m: they are the most reliable bones of a rig.
    pub leg_stature: f64,
}

/// What a motion says of limbs whose zero pose says nothing; left, then right.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Posed {
    /// Axes about which the elbows bend, unit vectors in the frames of the upper arms; `None` where they hardly do.
    pub arms: [Option<Vec3>; 2],
    /// Axes about which the knees bend, in the frames of the thighs.
    pub legs: [Option<Vec3>; 2],
    /// World rotations of the feet where they are lowest.
    pub feet: [Option<Quat>; 2],
}

/// Of each leg, left, then right, the foot and the links on it.
pub(super) fn feet_with_toes(skeleton: &Skeleton, anatomy: &Anatomy) -> [Vec<usize>; 2] {
    let links = skeleton.links();
    anatomy
        .legs
        .map(|[.., foot]| (0..links.len()).filter(|&i| i == foot || links[i].parent == Some(foot)).collect())
}

/// Least mean sine of a bend that has an axis: 5°.
const LEAST_BEND: f64 = 0.087;

impl Posed {
    /// Of a clip. Axes are the mean of upper bone × lower bone, each of unit length; a foot is lowest where its ankle and what
    /// hangs on it are. Of long clips about a thousand frames are looked at.
    pub fn of(clip: &Clip, anatomy: &Anatomy) -> Self {
        let frames = (0..clip.frames()).step_by(clip.frames().div_ceil(1000).max(1));
        let mut k = Kinematics::new(&clip.skeleton, &clip.skeleton.zero_pose());
        let limbs = [anatomy.arms, anatomy.legs];
        let (mut sums, mut count) = ([[Vec3::zeros(); 2]; 2], 0.0);
        let toes = feet_with_toes(&clip.skeleton, anatomy);
        let mut lowest = [(f64::INFINITY, None); 2];
        for frame in frames {
            k.update(&clip.skeleton, clip.pose(frame));
            count += 1.0;
            for ((lowest, toes), [.., foot]) in lowest.iter_mut().zip(&toes).zip(&anatomy.legs) {
                let height = toes.iter().map(|&i| k.origin(i).y).sum::<f64>();
                if height < lowest.0 {
                    *lowest = (height, Some(k.world[*foot].rotation));
                }
            }
            for (sums, limbs) in sums.iter_mut().zip(&limbs) {
                for (sum, [a, b, c]) in sums.iter_mut().zip(limbs) {
                    let bone = |from: usize, to: usize| {
                        (k.origin(to) - k.origin(from)).try_normalize(1e-9).unwrap_or_default()
                    };
                    *sum += k.world[*a].rotation.inverse() * bone(*a, *b).cross(&bone(*b, *c));
                }
            }
        }
        let axis = |sum: Vec3| Some(sum.normalize()).filter(|_| sum.norm() > LEAST_BEND * count);
        Self { arms: sums[0].map(axis), legs: sums[1].map(axis), feet: lowest.map(|l| l.1) }
    }

    fn bend_of(&self, anatomy: &Anatomy, link: usize) -> Option<Vec3> {
        let of = |limbs: &[[usize; 3]; 2], axes: &[Option<Vec3>; 2]| {
            (0..2).find(|&side| limbs[side][0] == link).and_then(|side| axes[side])
        };
        of(&anatomy.arms, &self.arms).or_else(|| of(&anatomy.legs, &self.legs))
    }
}

/// Up in the world.
pub const UP: Vec3 = Vec3::new(0.0, 1.0, 0.0);

impl Neutral {
    /// Finds the neutral pose.
    ///
    /// * `reference`: a standing pose; the arms may be anywhere, the legs within 50° of vertical
    /// * `posed`: what the motion says, where the reference is a frame of one rather than the zero pose
    ///
    /// # Errors
    /// `NotStanding` if the reference is not a standing pose, `Size` if legs or trunk have no length
    /// or the figure is below 0.2 m or above 4 m.
    pub fn new(
        skeleton: &Skeleton,
        anatomy: &Anatomy,
        reference: &[f64],
        posed: Option<&Posed>,
        table: &Table,
    ) -> Result<Self, GuessError> {
        let k = Kinematics::new(skeleton, reference);
        let mid = |pair: [usize; 2]| (k.origin(pair[0]) + k.origin(pair[1])) * 0.5;
        let column = |row: usize| [anatomy.legs[0][row], anatomy.legs[1][row]];
        let (hips, ankles) = (mid(column(0)), mid(column(2)));
        let shoulders = mid([anatomy.arms[0][0], anatomy.arms[1][0]]);
        let leg_length = |side: usize| -> f64 {
            let [a, b, c] = anatomy.legs[side].map(|i| k.origin(i));
            (b - a).norm() + (c - b).norm()
        };
        let proportion = (table.thigh.length + table.shank.length) / table.stature;
        let leg_stature = 0.5 * (leg_length(0) + leg_length(1)) / proportion;
        if !(0.2..=4.0).contains(&leg_stature) || (shoulders - hips).norm() < 0.05 * leg_stature {
            return Err(GuessError::Size { stature: leg_stature });
        }
        let check = |what: &'static str, d: Vec3, least: Vec3, limit_deg: f64| {
            let angle_deg = d.angle(&least).to_degrees();
            if angle_deg <= limit_deg {
                Ok(())
            } else {
                let pose = if posed.is_some() { "straightest frame" } else { "zero pose" };
                Err(GuessError::NotStanding { pose, what, angle_deg, limit_deg })
            }
        };
        check("trunk", shoulders - hips, UP, 40.0)?;
        check("legs", ankles - hips, -UP, 40.0)?;
        for leg in anatomy.legs {
            check("thigh", k.origin(leg[1]) - k.origin(leg[0]), -UP, 50.0)?;
            check("shin", k.origin(leg[2]) - k.origin(leg[1]), -UP, 60.0)?;
        }
        let mut column = vec![0];
        column.extend(anatomy.spine.iter().chain(&anatomy.neck));
        column.push(anatomy.head);
        for pair in column.windows(2) {
            let bone = k.origin(pair[1]) - k.origin(pair[0]);
            if bone.norm() > 0.02 * leg_stature {
                check("spine", bone, UP, 75.0)?;
            }
        }
        let across = k.origin(anatomy.legs[0][0]) - k.origin(anatomy.legs[1][0]);
        let flat = Vec3::new(across.x, 0.0, across.z);
        if flat.norm() < 1e-3 * leg_stature {
            return Err(GuessError::Size { stature: leg_stature });
        }
        let left = flat.normalize();

        let mut n = Self {
            rotation: Vec::new(),
            origin: Vec::new(),
            bone: bones(skeleton, anatomy, &k, leg_stature),
            left,
            front: left.cross(&UP),
            leg_stature,
        };
        n.turn_limbs_down(skeleton, anatomy, &k, posed);
        Ok(n)
    }

    /// Turns every limb bone down, parents first.
    fn turn_limbs_down(
        &mut self,
        skeleton: &Skeleton,
        anatomy: &Anatomy,
        k: &Kinematics,
        posed: Option<&Posed>,
    ) {
        let mut from_reference: Vec<Quat> = Vec::new();
        for (i, link) in skeleton.links().iter().enumerate() {
            let mut d = link.parent.map_or(Quat::identity(), |p| from_reference[p]);
            let hangs = matches!(
                anatomy.roles[i],
                Role::Thigh(_) | Role::Shin(_) | Role::UpperArm(_) | Role::Forearm(_)
            );
            if let (Some(posed), Role::Foot(side)) = (posed, anatomy.roles[i]) {
                let was = k.world[i].rotation;
                let heading = swing_twist(&d, &UP).1 * was;
                let flat = posed.feet[usize::from(side == Side::Right)].unwrap_or(was);
                d = turn_about_up(&(flat * self.bone[i]), &(heading * self.bone[i])) * flat * was.inverse();
            }
            if hangs && self.bone[i].norm() > 0.0 {
                let now = d * (k.world[i].rotation * self.bone[i]);
                d = between(&now, &-UP) * d;
                if let Some(axis) = posed.and_then(|posed| posed.bend_of(anatomy, i)) {
                    // elbows bend about the right of a hanging arm, knees about the left
                    let across = match anatomy.roles[i] {
                        Role::UpperArm(_) => -self.left,
                        _ => self.left,
                    };
                    let now = d * (k.world[i].rotation * axis);
                    d = turn_about_up(&now, &across) * d;
                }
            }
            from_reference.push(d);
            self.rotation.push(d * k.world[i].rotation);
            let at = match link.parent {
                Some(p) => self.origin[p] + self.rotation[p] * link.parent_from_zero.translation.vector,
                None => k.origin(i),
            };
            self.origin.push(at);
        }
    }

    /// Bone of a link in the world, m.
    pub fn bone_in_world(&self, link: usize) -> Vec3 {
        self.rotation[link] * self.bone[link]
    }

    /// A world point in the frame of a link, m.
    pub fn to_link(&self, link: usize, at: &Vec3) -> Vec3 {
        self.rotation[link].inverse() * (at - self.origin[link])
    }

    /// A point given by left, up, front coordinates relative to a world point.
    pub fn offset(&self, from: &Vec3, left: f64, up: f64, front: f64) -> Vec3 {
        from + self.left * left + UP * up + self.front * front
    }

    /// Rotation that takes the world's axes to left, up, front of the body.
    pub fn heading(&self) -> Quat {
        let m = nalgebra::Matrix3::from_columns(&[self.left, UP, self.front]);
        Quat::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(m))
    }

    /// Mean world position of two links, m.
    pub fn middle(&self, a: usize, b: usize) -> Vec3 {
        (self.origin[a] + self.origin[b]) * 0.5
    }
}

/// The turn about the vertical that gives one vector the heading of another.
fn turn_about_up(from: &Vec3, to: &Vec3) -> Quat {
    let flat = |v: &Vec3| Vec3::new(v.x, 0.0, v.z);
    let (from, to) = (flat(from), flat(to));
    exp(&(UP * from.cross(&to).dot(&UP).atan2(from.dot(&to))))
}

/// The bone of each link with a role, in its own frame.
fn bones(skeleton: &Skeleton, anatomy: &Anatomy, k: &Kinematics, stature: f64) -> Vec<Vec3> {
    let links = skeleton.links();
    let mut bone = vec![Vec3::zeros(); links.len()];
    let mut join = |from: usize, to: usize| {
        bone[from] = k.world[from].rotation.inverse() * (k.origin(to) - k.origin(from));
    };
    let mut column = vec![0];
    column.extend(&anatomy.spine);
    column.extend(&anatomy.neck);
    column.push(anatomy.head);
    column.windows(2).for_each(|w| join(w[0], w[1]));
    for side in 0..2 {
        for chain in [anatomy.arms[side], anatomy.legs[side]] {
            chain.windows(2).for_each(|w| join(w[0], w[1]));
        }
        if let Some(c) = anatomy.clavicles[side] {
            join(c, anatomy.arms[side][0]);
        }
    }
    for side in 0..2 {
        let hand = anatomy.arms[side][2];
        let forearm = k.origin(hand) - k.origin(anatomy.arms[side][1]);
        // the tip that is furthest along the forearm: not the thumb's
        let ahead = k.world[hand].rotation.inverse() * forearm;
        let fingers = far_tip(skeleton, k, hand, |p| p.dot(&ahead));
        let along = k.world[hand].rotation * fingers.filter(|f| f.norm() > 0.02 * stature).unwrap_or(ahead);
        // [Win09] gives the hand 0.108 of the stature; only the direction is taken from the rig
        bone[hand] = k.world[hand].rotation.inverse() * along.normalize() * (0.108 * stature);
        let foot = anatomy.legs[side][2];
        bone[foot] = far_tip(skeleton, k, foot, |p| p.norm()).unwrap_or_default();
    }
    let head = anatomy.head;
    // Many rigs (CMU) end the head at the forehead: that is no crown.
    let crown = links[head]
        .end
        .map(|e| k.world[head].rotation * e)
        .filter(|e| (0.085..0.2).contains(&(e.y / stature)));
    bone[head] = k.world[head].rotation.inverse() * crown.unwrap_or(UP * (0.105 * stature));
    bone
}

/// The point of the link and all it carries that is furthest by a measure, in the link's frame.
fn far_tip(skeleton: &Skeleton, k: &Kinematics, link: usize, by: impl Fn(&Vec3) -> f64) -> Option<Vec3> {
    let points = carried_points(skeleton, k, link);
    points.into_iter().max_by(|a, b| by(a).total_cmp(&by(b))).filter(|p| p.norm() > 0.0)
}

/// Joints and ends of everything a link carries, in its frame.
pub fn carried_points(skeleton: &Skeleton, k: &Kinematics, link: usize) -> Vec<Vec3> {
    let links = skeleton.links();
    let mut inside = vec![false; links.len()];
    let mut points = Vec::new();
    for i in link..links.len() {
        inside[i] = i == link || links[i].parent.is_some_and(|p| inside[p]);
        if !inside[i] {
            continue;
        }
        if i != link {
            points.push(k.origin(i));
        }
        points.extend(links[i].end.map(|e| k.point(i, &e)));
    }
    points.iter().map(|p| k.world[link].rotation.inverse() * (p - k.origin(link))).collect()
}
