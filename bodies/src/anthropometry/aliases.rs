//! Joint names to anatomical roles.
//!
//! In: the names and the tree of a skeleton. Out: one [`Role`] per link ([`Anatomy`]), or the list of
//! what could not be found. Case, separators and namespace prefixes (`mixamorig:`, `Bip01 `) do not
//! matter; left and right are read from `Left…`, `L…`, `…_l`, ` L `. Known rigs: CMU, Mixamo, Rokoko,
//! Xsens (MVN), Daz, 3ds Max, Unreal, and the classic `Collar/Shoulder/Elbow/Wrist`,
//! `Hip/Knee/Ankle`.
//!
//! Names find the limbs and the head. Spine, neck and collar bones are found from the tree: rigs
//! agree on where they are, not on what they are called. Limbs without known names are not guessed from
//! the tree: lengths do not tell a collar bone from an upper arm (CMU: collar bone 0.21 m, upper arm
//! 0.27 m, forearm 0.19 m), and a body hung on the wrong joint is worse than a refusal.

use motion::{Joint, Skeleton};
use thiserror::Error;

use super::names::{Word, read_name};
pub use super::side::Side;
use crate::JointClass;

/// What a link is in the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Role {
    /// The root.
    Pelvis,
    /// Between pelvis and the base of the neck; the last one is the chest and carries the arms.
    Spine,
    /// Between chest and head.
    Neck,
    /// The head.
    Head,
    /// Collar bone.
    Clavicle(Side),
    /// Upper arm; its joint is the shoulder.
    UpperArm(Side),
    /// Forearm; its joint is the elbow.
    Forearm(Side),
    /// Hand; its joint is the wrist.
    Hand(Side),
    /// Anything beyond the wrist.
    Finger(Side),
    /// Thigh; its joint is the hip.
    Thigh(Side),
    /// Shin; its joint is the knee.
    Shin(Side),
    /// Foot; its joint is the ankle.
    Foot(Side),
    /// Anything beyond the ankle.
    Toe(Side),
    /// A link that only places another one (CMU `LHipJoint`, twist bones).
    Helper,
    /// Eyes, jaws, props, tails.
    Other,
}

impl Role {
    /// What the joint of such a link is.
    pub fn class(self) -> JointClass {
        match self {
            Role::Pelvis => JointClass::Root,
            Role::Spine => JointClass::Spine,
            Role::Neck | Role::Head => JointClass::Neck,
            Role::Clavicle(_) => JointClass::Clavicle,
            Role::UpperArm(_) => JointClass::Shoulder,
            Role::Forearm(_) => JointClass::Elbow,
            Role::Hand(_) => JointClass::Wrist,
            Role::Thigh(_) => JointClass::Hip,
            Role::Shin(_) => JointClass::Knee,
            Role::Foot(_) => JointClass::Ankle,
            Role::Finger(_) | Role::Toe(_) | Role::Helper | Role::Other => JointClass::Other,
        }
    }

    /// Whether links of this role are welded to their parents in a guessed body.
    pub fn is_welded(self) -> bool {
        matches!(self, Role::Finger(_) | Role::Toe(_) | Role::Helper | Role::Other)
    }

    /// The side of a limb's link.
    pub fn side(self) -> Option<Side> {
        match self {
            Role::Clavicle(s)
            | Role::UpperArm(s)
            | Role::Forearm(s)
            | Role::Hand(s)
            | Role::Finger(s)
            | Role::Thigh(s)
            | Role::Shin(s)
            | Role::Foot(s)
            | Role::Toe(s) => Some(s),
            _ => None,
        }
    }
}

impl std::fmt::Display for Role {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let word = match self {
            Role::Pelvis => "pelvis",
            Role::Spine => "spine",
            Role::Neck => "neck",
            Role::Head => "head",
            Role::Clavicle(_) => "clavicle",
            Role::UpperArm(_) => "upper arm",
            Role::Forearm(_) => "forearm",
            Role::Hand(_) => "hand",
            Role::Finger(_) => "finger",
            Role::Thigh(_) => "thigh",
            Role::Shin(_) => "shin",
            Role::Foot(_) => "foot",
            Role::Toe(_) => "toe",
            Role::Helper => "helper",
            Role::Other => "other",
        };
        match self.side() {
            Some(Side::Left) => f.pad(&format!("left {word}")),
            Some(Side::Right) => f.pad(&format!("right {word}")),
            None => f.pad(word),
        }
    }
}

/// Why a skeleton is not recognised as human-like.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum AnatomyError {
    /// Parts no name stands for.
    #[error(
        "not a human-like skeleton: found no joint for {}; the joints are {}. Name them like CMU, Mixamo, Xsens, Daz or Unreal rigs do, or give a character file",
        .missing.join(", "), list(.joints)
    )]
    Missing {
        /// What was not found.
        missing: Vec<String>,
        /// The joint names of the skeleton.
        joints: Vec<String>,
    },
    /// Two joints for one part.
    #[error("`{first}` and `{second}` both look like the {role}; rename one, or give a character file")]
    Ambiguous {
        /// The part.
        role: String,
        /// One joint.
        first: String,
        /// Another joint.
        second: String,
    },
    /// A limb whose joints do not hang on one another.
    #[error(
        "`{below}` ({below_role}) does not hang below `{above}` ({above_role}); rename the joints, or give a character file"
    )]
    Chain {
        /// The joint expected above.
        above: String,
        /// Its part.
        above_role: String,
        /// The joint expected below.
        below: String,
        /// Its part.
        below_role: String,
    },
    /// The hips are not where the skeleton starts.
    #[error(
        "the legs meet at `{pelvis}`, but the root is `{root}`, elsewhere; the root of a human-like skeleton is its pelvis"
    )]
    Root {
        /// Where the legs meet.
        pelvis: String,
        /// The root.
        root: String,
    },
}

fn list(names: &[String]) -> String {
    let shown: Vec<_> = names.iter().take(12).map(|n| format!("`{n}`")).collect();
    let more = names.len().saturating_sub(12);
    if more > 0 { format!("{} and {more} more", shown.join(", ")) } else { shown.join(", ") }
}

/// The roles of a human-like skeleton.
#[derive(Clone, Debug, PartialEq)]
pub struct Anatomy {
    /// One per link.
    pub roles: Vec<Role>,
    /// From the first link above the pelvis to the chest, at least one.
    pub spine: Vec<usize>,
    /// From the first link above the chest to the one below the head; may be empty.
    pub neck: Vec<usize>,
    /// The head.
    pub head: usize,
    /// Upper arm, forearm, hand: left, then right.
    pub arms: [[usize; 3]; 2],
    /// The collar bone next to the upper arm: left, then right.
    pub clavicles: [Option<usize>; 2],
    /// Thigh, shin, foot: left, then right.
    pub legs: [[usize; 3]; 2],
}

/// What the names say: side and word of every link, and the links of arms, legs and head.
struct Named {
    read: Vec<(Option<Side>, Option<Word>)>,
    arms: [[usize; 3]; 2],
    legs: [[usize; 3]; 2],
    head: usize,
}

impl Named {
    fn of(skeleton: &Skeleton) -> Result<Self, AnatomyError> {
        let links = skeleton.links();
        let read: Vec<_> = links.iter().map(|l| read_name(&l.name)).collect();
        let under = |i: usize, top: usize| path_up(skeleton, i).contains(&top);
        let mut missing = Vec::new();

        // The uppermost link that carries the name; deeper ones of the same name are twist bones.
        let mut find = |words: &[Word], side: Option<Side>, what: String| -> Result<usize, AnatomyError> {
            let all: Vec<_> = (0..links.len())
                .filter(|&i| read[i].0 == side && read[i].1.is_some_and(|w| words.contains(&w)))
                .collect();
            let Some(&first) = all.first() else {
                missing.push(what);
                return Ok(usize::MAX);
            };
            match all.iter().find(|&&i| !under(i, first)) {
                Some(&second) => Err(AnatomyError::Ambiguous {
                    role: what,
                    first: links[first].name.clone(),
                    second: links[second].name.clone(),
                }),
                None => Ok(first),
            }
        };
        let mut arms = [[0; 3]; 2];
        let mut legs = [[0; 3]; 2];
        for (k, side) in Side::BOTH.into_iter().enumerate() {
            let s = Some(side);
            let named = |w: Word| read.contains(&(s, Some(w)));
            let upper = if named(Word::UpperArm) { Word::UpperArm } else { Word::Shoulder };
            let thigh = if named(Word::Thigh) { Word::Thigh } else { Word::Hip };
            arms[k] = [
                find(&[upper], s, Role::UpperArm(side).to_string())?,
                find(&[Word::Forearm], s, Role::Forearm(side).to_string())?,
                find(&[Word::Hand], s, Role::Hand(side).to_string())?,
            ];
            legs[k] = [
                find(&[thigh], s, Role::Thigh(side).to_string())?,
                find(&[Word::Shin], s, Role::Shin(side).to_string())?,
                find(&[Word::Foot], s, Role::Foot(side).to_string())?,
            ];
        }
        let head = find(&[Word::Head], None, "head".into())?;
        if !missing.is_empty() {
            let joints = links.iter().map(|l| l.name.clone()).collect();
            return Err(AnatomyError::Missing { missing, joints });
        }
        for (k, side) in Side::BOTH.into_iter().enumerate() {
            let arm = [Role::UpperArm(side), Role::Forearm(side), Role::Hand(side)];
            let leg = [Role::Thigh(side), Role::Shin(side), Role::Foot(side)];
            for (chain, roles) in [(arms[k], arm), (legs[k], leg)] {
                for i in 0..2 {
                    if !under(chain[i + 1], chain[i]) {
                        return Err(AnatomyError::Chain {
                            above: links[chain[i]].name.clone(),
                            above_role: roles[i].to_string(),
                            below: links[chain[i + 1]].name.clone(),
                            below_role: roles[i + 1].to_string(),
                        });
                    }
                }
            }
        }
        Ok(Self { read, arms, legs, head })
    }
}

/// The pelvis of a human-like skeleton whose root is another link above it: a reference at the floor, a root bone, a mover.
///
/// `None` where the root is the pelvis (also with a link stacked on it), where names say nothing, and where legs and
/// arms part above the pelvis. A link above it counts where the pelvis lies elsewhere or moves against it.
pub fn pelvis_below_root(skeleton: &Skeleton) -> Option<usize> {
    let Named { arms, legs, .. } = Named::of(skeleton).ok()?;
    let pelvis = common_ancestor(skeleton, legs[0][0], legs[1][0]);
    let chest = common_ancestor(skeleton, arms[0][0], arms[1][0]);
    let trunk = chest != pelvis && path_up(skeleton, chest).contains(&pelvis);
    let apart = distance_from_root(skeleton, pelvis) > STACKED_M;
    let moves = path_up(skeleton, pelvis)
        .iter()
        .any(|&i| i != 0 && matches!(skeleton.links()[i].joint, Joint::Free | Joint::Prismatic(_)));
    (pelvis != 0 && trunk && (apart || moves)).then_some(pelvis)
}

/// Links farther from the root than this are not stacked on it, m.
const STACKED_M: f64 = 0.02;

/// Length of the offsets from the root to a link, m.
fn distance_from_root(skeleton: &Skeleton, link: usize) -> f64 {
    let links = path_up(skeleton, link);
    let offset = |&i: &usize| skeleton.links()[i].parent_from_zero.translation.vector.norm();
    links.iter().filter(|&&i| i != 0).map(offset).sum()
}

impl Anatomy {
    /// Finds the roles of all links.
    ///
    /// # Errors
    /// See [`AnatomyError`].
    pub fn of(skeleton: &Skeleton) -> Result<Self, AnatomyError> {
        let Named { read, arms, legs, head } = Named::of(skeleton)?;
        Self::from_chains(skeleton, &read, arms, legs, head)
    }

    fn from_chains(
        skeleton: &Skeleton,
        read: &[(Option<Side>, Option<Word>)],
        arms: [[usize; 3]; 2],
        legs: [[usize; 3]; 2],
        head: usize,
    ) -> Result<Self, AnatomyError> {
        let links = skeleton.links();
        let mut roles = vec![Role::Other; links.len()];
        // Pelvis: where the legs meet. Links above it may only be stacked on the same point.
        let hips = common_ancestor(skeleton, legs[0][0], legs[1][0]);
        let far = distance_from_root(skeleton, hips);
        let chest = common_ancestor(skeleton, arms[0][0], arms[1][0]);
        if far > STACKED_M || chest == 0 {
            return Err(AnatomyError::Root { pelvis: links[hips].name.clone(), root: links[0].name.clone() });
        }
        roles[0] = Role::Pelvis;
        let down = |from: usize, to: usize| {
            let mut path = path_up(skeleton, to);
            path.truncate(path.iter().position(|&i| i == from).unwrap_or(path.len()));
            path.reverse();
            path // below `from`, down to and with `to`
        };
        let mut spine = down(0, chest);
        let neck_from = common_ancestor(skeleton, head, chest);
        let mut neck = down(neck_from, head);
        neck.pop();
        spine.retain(|&i| !is_stacked(skeleton, i));
        neck.retain(|&i| !path_up(skeleton, chest).contains(&i));
        spine.iter().for_each(|&i| roles[i] = Role::Spine);
        neck.iter().for_each(|&i| roles[i] = Role::Neck);
        roles[head] = Role::Head;
        let mut clavicles = [None; 2];
        for (k, side) in Side::BOTH.into_iter().enumerate() {
            let mut between = down(chest, arms[k][0]);
            between.pop();
            let named =
                between.iter().rev().find(|&&i| matches!(read[i].1, Some(Word::Clavicle | Word::Shoulder)));
            clavicles[k] = named.or(between.last()).copied();
            between.iter().for_each(|&i| roles[i] = Role::Helper);
            if let Some(c) = clavicles[k] {
                roles[c] = Role::Clavicle(side);
            }
            for i in 0..links.len() {
                let up = path_up(skeleton, i);
                if up.contains(&arms[k][2]) {
                    roles[i] = Role::Finger(side);
                } else if up.contains(&legs[k][2]) {
                    roles[i] = Role::Toe(side);
                } else if up.contains(&arms[k][0])
                    || up.contains(&legs[k][0])
                    || down(0, legs[k][0]).contains(&i)
                {
                    roles[i] = if i == 0 { Role::Pelvis } else { Role::Helper };
                }
            }
            for (i, role) in
                arms[k].into_iter().zip([Role::UpperArm(side), Role::Forearm(side), Role::Hand(side)])
            {
                roles[i] = role;
            }
            for (i, role) in legs[k].into_iter().zip([Role::Thigh(side), Role::Shin(side), Role::Foot(side)])
            {
                roles[i] = role;
            }
        }
        Ok(Self { roles, spine, neck, head, arms, clavicles, legs })
    }
}

/// A link that sits on its parent's origin although it is no branching point of its own: a Biped's
/// `Pelvis` under `Bip01`, which carries legs and spine alike.
fn is_stacked(skeleton: &Skeleton, link: usize) -> bool {
    let links = skeleton.links();
    let children = links.iter().filter(|l| l.parent == Some(link)).count();
    links[link].parent == Some(0)
        && children >= 3
        && links[link].parent_from_zero.translation.vector.norm() < 1e-6
}

/// The link itself, its parent, and so on to the root.
pub(crate) fn path_up(skeleton: &Skeleton, link: usize) -> Vec<usize> {
    let mut path = vec![link];
    while let Some(p) = skeleton.links()[path[path.len() - 1]].parent {
        path.push(p);
    }
    path
}

/// The deepest link that carries both.
fn common_ancestor(skeleton: &Skeleton, a: usize, b: usize) -> usize {
    let up = path_up(skeleton, b);
    path_up(skeleton, a).into_iter().find(|i| up.contains(i)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A figure with the names of a rig: trunk from the pelvis to the head, then one side's collar bone, upper
    /// arm, forearm, hand, thigh, shin, foot, toe with `?` for the side.
    fn figure(trunk: &[&str], side: [&str; 8], sides: [&str; 2]) -> Skeleton {
        use motion::{Joint, Link, Vec3};
        let mut links = vec![Link::new(trunk[0], None, Vec3::zeros(), Joint::Free)];
        let step = 0.75 / (trunk.len() - 1) as f64;
        for (i, name) in trunk.iter().enumerate().skip(1) {
            links.push(Link::new(*name, Some(i - 1), Vec3::y() * step, Joint::Spherical));
        }
        let chest = trunk.len() - 3;
        for (k, letter) in sides.iter().enumerate() {
            let x = if k == 0 { 1.0 } else { -1.0 };
            let at = [
                Vec3::new(0.03 * x, 0.1, 0.0),
                Vec3::x() * (0.15 * x),
                Vec3::x() * (0.28 * x),
                Vec3::x() * (0.26 * x),
                Vec3::x() * (0.09 * x),
                Vec3::y() * -0.43,
                Vec3::y() * -0.43,
                Vec3::new(0.0, -0.05, 0.15),
            ];
            for (j, name) in side.iter().enumerate() {
                let parent = match j {
                    0 => chest,
                    4 => 0,
                    _ => links.len() - 1,
                };
                links.push(Link::new(name.replace('?', letter), Some(parent), at[j], Joint::Spherical));
            }
        }
        Skeleton::new(links).unwrap()
    }

    /// Whole figures of the rigs in use get their roles and a body.
    #[test]
    fn rigs_get_a_body() {
        let mixamo = ["Hips", "Spine", "Spine1", "Spine2", "Neck", "Head"].map(|n| format!("mixamorig:{n}"));
        let mixamo: Vec<&str> = mixamo.iter().map(String::as_str).collect();
        let rigs = [
            figure(
                &mixamo,
                ["Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "ToeBase"]
                    .map(|n| Box::leak(format!("mixamorig:?{n}").into_boxed_str()) as &str),
                ["Left", "Right"],
            ),
            figure(
                &["Pelvis", "L5", "L3", "T12", "T8", "Neck", "Head"],
                ["?T4", "?UpperArm", "?ForeArm", "?Hand", "?UpperLeg", "?LowerLeg", "?Foot", "?Toe"],
                ["Left", "Right"],
            ),
            figure(
                &["pelvis", "spine_01", "spine_02", "spine_03", "neck_01", "head"],
                ["clavicle_?", "upperarm_?", "lowerarm_?", "hand_?", "thigh_?", "calf_?", "foot_?", "ball_?"],
                ["l", "r"],
            ),
            figure(
                &["Bip01", "Bip01 Spine", "Bip01 Spine1", "Bip01 Neck", "Bip01 Head"],
                [
                    "Bip01 ? Clavicle",
                    "Bip01 ? UpperArm",
                    "Bip01 ? Forearm",
                    "Bip01 ? Hand",
                    "Bip01 ? Thigh",
                    "Bip01 ? Calf",
                    "Bip01 ? Foot",
                    "Bip01 ? Toe0",
                ],
                ["L", "R"],
            ),
            figure(
                &["Hips", "Chest", "Chest2", "Neck", "Head"],
                ["?Collar", "?Shoulder", "?Elbow", "?Wrist", "?Hip", "?Knee", "?Ankle", "?Toe"],
                ["Left", "Right"],
            ),
            figure(
                &["hip", "abdomen", "chest", "neck", "head"],
                ["?Collar", "?Shldr", "?ForeArm", "?Hand", "?Thigh", "?Shin", "?Foot", "?Toe"],
                ["l", "r"],
            ),
        ];
        for rig in &rigs {
            let a = Anatomy::of(rig).unwrap_or_else(|e| panic!("{e}"));
            let trunk = rig.links().len() - 16;
            assert_eq!(a.roles[0], Role::Pelvis);
            assert_eq!(
                (a.spine.len(), a.neck.len(), a.head),
                (trunk - 3, 1, trunk - 1),
                "{}",
                rig.links()[0].name
            );
            for (k, side) in Side::BOTH.into_iter().enumerate() {
                let want = [
                    Role::Clavicle(side),
                    Role::UpperArm(side),
                    Role::Forearm(side),
                    Role::Hand(side),
                    Role::Thigh(side),
                    Role::Shin(side),
                    Role::Foot(side),
                    Role::Toe(side),
                ];
                assert_eq!(a.roles[trunk + 8 * k..trunk + 8 * (k + 1)], want);
            }
            let (_, report) = crate::guess_body(rig, &crate::BodyOptions::default()).unwrap();
            assert!((1.4..2.0).contains(&report.stature), "{report}");
        }
    }

    #[test]
    fn what_is_missing_or_doubtful_is_named() {
        let names = ["?Collar", "?Shoulder", "?Elbow", "?Wrist", "?Hip", "?Knee", "?Ankle", "?Toe"];
        let trunk = ["Hips", "Chest", "Chest2", "Neck", "Head"];
        let renamed = |from: &str, to: &str| {
            let mut links = figure(&trunk, names, ["Left", "Right"]).links().to_vec();
            links.iter_mut().filter(|l| l.name == from).for_each(|l| l.name = to.into());
            Anatomy::of(&Skeleton::new(links).unwrap()).unwrap_err().to_string()
        };
        let e = renamed("LeftKnee", "Bend");
        assert!(e.contains("found no joint for left shin;") && e.contains("`Bend`"), "{e}");
        let e = renamed("RightKnee", "LeftShin");
        assert!(e.contains("`LeftKnee` and `LeftShin` both look like the left shin"), "{e}");
    }
}
