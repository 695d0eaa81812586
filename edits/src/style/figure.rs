//! The figure that styles are written in: a tree of bones that stands in its zero pose and faces +Z, all joints balls.
//!
//! In: skeletons and clips. Out: a [`Figure`], and the [`Postures`] of a clip on it: how far every link is turned away
//! from the zero pose, seen from a body that faces +Z at the origin, and what was taken away to see it so (the way
//! over the ground and the heading).
//!
//! Turns from the zero pose do not depend on how a skeleton's frames are turned, so clips of one file format and
//! another, of subjects and of scripts, meet here. *Other proportions*: a bone keeps its direction in the world
//! (turns are corrected by the smallest rotation between the zero poses' bones), and heights scale with the legs.
//! *Other names* are matched letter by letter without case, punctuation and name spaces, then by a table the caller
//! gives.
//!
//! Symbols: `G` turn of a link from the zero pose; `h` heading, rad about +Y; units m.

use std::collections::BTreeMap;

use motion::rotation::{between, exp, swing_twist};
use motion::smooth::whittaker::{Whittaker, lambda};
use motion::{Clip, Joint, Kinematics, LimbKind, Quat, Skeleton, Transform, Vec3};

use super::error::StyleError;

/// The heading is that of the body below this frequency, Hz: the pelvis turns to and fro with every step.
const HEADING_HZ: f64 = 0.3;
/// Bones shorter than this have no direction, m.
const SHORTEST: f64 = 1e-4;

/// A link of a figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Bone {
    /// Its name.
    pub name: String,
    /// Its parent; `None` of the root.
    pub parent: Option<usize>,
    /// From the parent's origin to its own in the zero pose, m.
    pub offset: Vec3,
    /// From its origin to its end in the zero pose, m; of bones without children.
    pub end: Option<Vec3>,
}

/// A tree of bones in a zero pose that faces +Z. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Root first, parents before their children.
    pub bones: Vec<Bone>,
    /// Height of the root over the lowest bone in the zero pose, m: what heights scale with.
    pub leg_m: f64,
}

impl Figure {
    /// The figure of a skeleton.
    pub fn of(skeleton: &Skeleton) -> Self {
        let zero = Zero::of(skeleton);
        let origin = |i: usize| zero.place(i);
        let bones: Vec<Bone> = skeleton
            .links()
            .iter()
            .enumerate()
            .map(|(i, link)| {
                let leaf = !skeleton.links().iter().any(|l| l.parent == Some(i));
                Bone {
                    name: link.name.clone(),
                    parent: link.parent,
                    offset: link.parent.map_or(Vec3::zeros(), |p| origin(i) - origin(p)),
                    end: link
                        .end
                        .filter(|_| leaf)
                        .map(|e| zero.turned(i, &e))
                        .filter(|e| e.norm() > SHORTEST),
                }
            })
            .collect();
        let lowest = (0..bones.len()).map(|i| origin(i).y).fold(f64::INFINITY, f64::min);
        Figure { leg_m: (origin(0).y - lowest).max(SHORTEST), bones }
    }

    /// Its bones as a skeleton: a free root and balls.
    pub fn skeleton(&self) -> Skeleton {
        let links = self.bones.iter().map(|b| {
            let joint = if b.parent.is_none() { Joint::Free } else { Joint::Spherical };
            let mut link = motion::Link::new(b.name.clone(), b.parent, b.offset, joint);
            link.end = b.end;
            link
        });
        Skeleton::new(links.collect()).expect("a figure is a tree of named bones")
    }

    /// Direction of a bone in the zero pose: to its children's middle, or to its end; `None` without either.
    pub fn direction(&self, bone: usize) -> Option<Vec3> {
        let children: Vec<&Bone> = self.bones.iter().filter(|b| b.parent == Some(bone)).collect();
        let sum = match children.len() {
            0 => self.bones[bone].end?,
            _ => children.iter().map(|b| b.offset).sum(),
        };
        (sum.norm() > SHORTEST).then(|| sum.normalize())
    }

    /// Origins of all bones for their turns, the root at the origin, m.
    pub fn places(&self, turns: &[Quat]) -> Vec<Vec3> {
        let mut places: Vec<Vec3> = Vec::with_capacity(self.bones.len());
        for b in &self.bones {
            places.push(b.parent.map_or(Vec3::zeros(), |p| places[p] + turns[p] * b.offset));
        }
        places
    }

    /// The upper bones of the legs: those that hang in the zero pose, are long, and are on no such bone themselves.
    pub fn thighs(&self) -> Vec<usize> {
        let places = self.places(&vec![Quat::identity(); self.bones.len()]);
        let hangs = |b: usize| {
            let children = self.bones.iter().filter(|c| c.parent == Some(b));
            let length = children.map(|c| c.offset.norm()).fold(0.0, f64::max);
            let down = self.direction(b).is_some_and(|d| d.y < -0.7);
            down && length > 0.25 * self.leg_m && places[b].y < 0.1 * self.leg_m
        };
        (0..self.bones.len())
            .filter(|b| hangs(*b) && self.bones[*b].parent.is_some_and(|p| !hangs(p)))
            .collect()
    }

    /// A bone by name.
    pub fn bone(&self, name: &str) -> Option<usize> {
        self.bones.iter().position(|b| b.name == name)
    }
}

/// A skeleton's zero pose, turned to face +Z with its root at the origin.
struct Zero {
    k: Kinematics,
    /// Turns the zero pose's facing to +Z.
    back: Quat,
}

impl Zero {
    fn of(skeleton: &Skeleton) -> Self {
        let k = Kinematics::new(skeleton, &skeleton.zero_pose());
        let facing = Facing::of(skeleton).yaw(&k);
        Zero { back: exp(&(Vec3::y() * -facing)), k }
    }

    fn place(&self, link: usize) -> Vec3 {
        self.back * (self.k.origin(link) - self.k.origin(0))
    }

    fn turned(&self, link: usize, at: &Vec3) -> Vec3 {
        self.back * (self.k.world[link].rotation * at)
    }
}

/// What a skeleton's heading is read from.
enum Facing {
    /// The line from the right hip to the left: its links.
    Hips(usize, usize),
    /// The root's own +Z.
    Root,
}

impl Facing {
    fn of(skeleton: &Skeleton) -> Self {
        let legs: Vec<_> = skeleton.limbs().iter().filter(|l| l.kind == LimbKind::Leg).collect();
        let side = |letter: &str| legs.iter().find(|l| l.name.ends_with(letter)).map(|l| l.upper);
        match (side("_l"), side("_r")) {
            (Some(left), Some(right)) => Facing::Hips(left, right),
            _ => Facing::Root,
        }
    }

    /// Turn about +Y from +Z, rad.
    fn yaw(&self, k: &Kinematics) -> f64 {
        match self {
            Facing::Hips(left, right) => {
                let across = k.origin(*left) - k.origin(*right);
                // left × up is forward
                (-across.z).atan2(across.x)
            }
            Facing::Root => {
                let forward = k.world[0].rotation * Vec3::z();
                forward.x.atan2(forward.z)
            }
        }
    }
}

/// Which links of a skeleton are which bones of a figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Match {
    /// For each bone its link.
    pub link: Vec<Option<usize>>,
    /// For each bone, the smallest turn from the skeleton's bone in the zero pose to the figure's.
    correction: Vec<Quat>,
    /// The skeleton's legs over the figure's.
    pub size: f64,
    /// Bones that no link matches: they keep their place on their parents.
    pub missing: Vec<String>,
    /// What was matched by other than its very name, `figure = clip`.
    pub renamed: Vec<(String, String)>,
    /// Largest correction, rad.
    pub largest_turn: f64,
}

/// A name without case, punctuation and name space.
fn plain(name: &str) -> String {
    let own = name.rsplit(':').next().unwrap_or(name);
    own.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

impl Match {
    /// Finds the bones of a figure in a skeleton. `names`: figure's name to the skeleton's, where they differ.
    ///
    /// # Errors
    /// [`StyleError::Skeletons`] when fewer than half of the bones, or not the root, are found.
    pub fn of(
        figure: &Figure,
        skeleton: &Skeleton,
        names: &BTreeMap<String, String>,
    ) -> Result<Self, StyleError> {
        let links = skeleton.links();
        let own = Figure::of(skeleton);
        let mut renamed = Vec::new();
        let link: Vec<Option<usize>> = figure
            .bones
            .iter()
            .enumerate()
            .map(|(i, bone)| {
                let found = skeleton
                    .link(&bone.name)
                    .or_else(|| names.get(&bone.name).and_then(|n| skeleton.link(n)))
                    .or_else(|| {
                        let wanted = plain(&bone.name);
                        let mut same = (0..links.len()).filter(|l| plain(&links[*l].name) == wanted);
                        same.next().filter(|_| same.next().is_none())
                    })
                    .or((i == 0).then_some(0));
                if let Some(l) = found.filter(|l| links[*l].name != bone.name) {
                    renamed.push((bone.name.clone(), links[l].name.clone()));
                }
                found
            })
            .collect();
        let missing: Vec<String> = figure
            .bones
            .iter()
            .zip(&link)
            .filter(|(_, l)| l.is_none())
            .map(|(b, _)| b.name.clone())
            .collect();
        if 2 * missing.len() > figure.bones.len() {
            return Err(StyleError::Skeletons {
                found: figure.bones.len() - missing.len(),
                bones: figure.bones.len(),
                missing: missing.join(", "),
                links: links.iter().map(|l| l.name.as_str()).collect::<Vec<_>>().join(", "),
            });
        }
        let correction: Vec<Quat> = link
            .iter()
            .enumerate()
            .map(|(i, l)| match l.map(|l| (own.direction(l), figure.direction(i))) {
                Some((Some(a), Some(b))) if i > 0 && (a - b).norm() > 1e-12 => between(&a, &b),
                _ => Quat::identity(),
            })
            .collect();
        let largest_turn = correction.iter().map(Quat::angle).fold(0.0, f64::max);
        let size = if own.bones == figure.bones { 1.0 } else { own.leg_m / figure.leg_m };
        Ok(Match { link, correction, size, missing, renamed, largest_turn })
    }

    /// Whether nothing has to be said of it.
    pub fn is_same(&self) -> bool {
        self.missing.is_empty() && self.renamed.is_empty() && self.size == 1.0 && self.largest_turn == 0.0
    }
}

/// A clip as its figure sees it. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Postures {
    /// Hz.
    pub rate_hz: f64,
    /// Turns of all bones, frame by frame.
    pub turns: Vec<Vec<Quat>>,
    /// Height of the root over the floor, in the figure's size, m.
    pub height: Vec<f64>,
    /// Heading, rad, continuous.
    pub heading: Vec<f64>,
}

impl Postures {
    /// The postures of a clip. `floor_m`: height of its floor.
    pub fn of(clip: &Clip, figure: &Figure, matched: &Match, floor_m: f64) -> Self {
        let skeleton = &clip.skeleton;
        let facing = Facing::of(skeleton);
        let zero = Zero::of(skeleton);
        let mut k = Kinematics::new(skeleton, clip.pose(0));
        let mut yaws: Vec<f64> = Vec::with_capacity(clip.frames());
        let mut worlds: Vec<Vec<Transform>> = Vec::with_capacity(clip.frames());
        for f in 0..clip.frames() {
            k.update(skeleton, clip.pose(f));
            let yaw = facing.yaw(&k);
            let before = yaws.last().copied().unwrap_or(yaw);
            let turn = std::f64::consts::TAU;
            yaws.push(yaw + turn * ((before - yaw) / turn).round());
            worlds.push(k.world.clone());
        }
        let heading = if yaws.len() < 4 {
            yaws
        } else {
            let strength = lambda(HEADING_HZ.min(0.45 * clip.rate_hz), clip.rate_hz);
            Whittaker::new(yaws.len(), strength).smooth(&yaws, 1)
        };
        let mut turns = Vec::with_capacity(clip.frames());
        let mut height = Vec::with_capacity(clip.frames());
        for (world, h) in worlds.iter().zip(&heading) {
            let away = exp(&(Vec3::y() * -h));
            let mut frame: Vec<Quat> = Vec::with_capacity(figure.bones.len());
            for (i, bone) in figure.bones.iter().enumerate() {
                frame.push(match matched.link[i] {
                    // away · R · R_zero⁻¹ · back⁻¹, in the figure's zero pose
                    Some(l) => {
                        away * world[l].rotation
                            * zero.k.world[l].rotation.inverse()
                            * zero.back.inverse()
                            * matched.correction[i].inverse()
                    }
                    None => frame[bone.parent.expect("the root is matched")],
                });
            }
            turns.push(frame);
            height.push((world[0].translation.vector.y - floor_m) / matched.size);
        }
        Postures { rate_hz: clip.rate_hz, turns, height, heading }
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.turns.len()
    }

    /// The clip with these turns and heights in the place of its own; all else of it stays. Hinges take what turns
    /// about their axis.
    pub fn write(&self, clip: &mut Clip, matched: &Match, floor_m: f64) {
        let skeleton = clip.skeleton.clone();
        let zero = Zero::of(&skeleton);
        let mut bone_of = vec![None; skeleton.links().len()];
        for (bone, link) in matched.link.iter().enumerate() {
            if let Some(l) = link {
                bone_of[*l] = Some(bone);
            }
        }
        let mut world = vec![Quat::identity(); skeleton.links().len()];
        for f in 0..self.frames().min(clip.frames()) {
            let towards = exp(&(Vec3::y() * self.heading[f]));
            let q = clip.pose_mut(f);
            for (l, link) in skeleton.links().iter().enumerate() {
                let above =
                    link.parent.map_or(Quat::identity(), |p| world[p]) * link.parent_from_zero.rotation;
                if let Some(bone) = bone_of[l] {
                    let goal = towards
                        * self.turns[f][bone]
                        * matched.correction[bone]
                        * zero.back
                        * zero.k.world[l].rotation;
                    let local = Quat::new_normalize((above.inverse() * goal).into_inner());
                    match link.joint {
                        Joint::Free | Joint::Spherical => skeleton.set_rotation(q, l, &local),
                        Joint::Revolute(axis) => {
                            let (_, twist) = swing_twist(&local, &axis);
                            let angle = motion::rotation::log(&twist).dot(&axis);
                            let at = skeleton.q_at(l);
                            // an angle of whole turns stays where it was
                            let turn = std::f64::consts::TAU;
                            q[at] = angle + turn * ((q[at] - angle) / turn).round();
                        }
                        Joint::Prismatic(_) | Joint::Fixed => {}
                    }
                }
                if link.joint == Joint::Free && l == 0 {
                    let mut p = skeleton.position(q, 0);
                    p.y = self.height[f] * matched.size + floor_m - link.parent_from_zero.translation.y;
                    skeleton.set_position(q, 0, &p);
                }
                world[l] = above * skeleton.rotation(q, l);
            }
        }
    }

    /// A clip of the figure's own skeleton, over a floor at 0 m, heading +Z and in place.
    pub fn in_place(&self, figure: &Figure) -> Clip {
        let skeleton = std::sync::Arc::new(figure.skeleton());
        let same = Match::of(figure, &skeleton, &BTreeMap::new()).expect("its own bones");
        let zero = skeleton.zero_pose();
        let mut clip = Clip::new(skeleton, self.rate_hz, zero.repeat(self.frames()));
        let facing = Postures { heading: vec![0.0; self.frames()], ..self.clone() };
        facing.write(&mut clip, &same, 0.0);
        clip
    }
}
