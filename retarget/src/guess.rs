//! A first guess for a new key pose: root, face and limbs as the human has them.
//!
//! In: a human pose and a puppet. Out: a pose of the puppet to start from. What animators always do first when they
//! make a key pose \[YAH10, §7\] is done here: the root is turned as the human's pelvis, the face looks where
//! the human's looks, limbs reach where the human's reach. What the pose *means* is left to the animator.
//!
//! All of it is told by points, in the local frames of the two roots, and solved at once by [`JointFit`] from the
//! rest pose, joint limits kept:
//!
//! - the eyes, displaced from rest as the human's, in the ratio `s` of the eyes' heights at rest, with two points
//!   before and above them that turn as the human's head;
//! - contact points, displaced as the mean of the human points they follow, times `s`; a root that touches the
//!   ground itself (a lamp's plate) stands as these say, any other is turned and moved as the pelvis;
//! - then, from where the shoulders have come to be, the ends of arms: the human's way from shoulder to wrist in
//!   the ratio of the arms' lengths.
//!
//! \[YAH10\] Yamane, Ariki, Hodgins. Animating Non-Humanoid Characters with Human Motion Data, SCA 2010.

use bodies::JointClass;
use bodies::anthropometry::Anatomy;
use motion::{Joint, Kinematics, LimbKind, Limits, Quat, Site, Transform, Vec3};

use crate::fit::JointFit;
use crate::{Features, Performer, Puppet, RetargetError};

/// Distance of the points around the eyes and the root from their middle, in heights of the eyes.
const ARM: f64 = 0.25;

/// Bends of hinges from which the search starts, rad: the answer that misses least counts, the first of equals.
const BENDS: [f64; 3] = [0.3, 0.8, 1.6];

/// A pose of the puppet for the human pose `human` (`nq` of the performer); it stands where it stands at rest.
///
/// # Errors
/// A performer or puppet without the site `eyes`; a performer that is not human.
pub fn guess(performer: &Performer, human: &[f64], puppet: &Puppet) -> Result<Vec<f64>, RetargetError> {
    let skeleton = &puppet.character.skeleton;
    let eyes = skeleton.site("eyes").ok_or_else(|| RetargetError::marker("eyes", skeleton))?;
    let human = HumanPose::human(performer, human)?;
    let mut q = puppet.character.rest.clone();
    let at_rest = LocalPose::new(&puppet.features, Kinematics::new(skeleton, &q));
    let eye = at_rest.point(eyes.link, &eyes.at);
    let scale = eye.y / human.eyes[0].y.max(1e-6);
    let arm = ARM * eye.y;
    let mut goals = PointGoals::default();

    let looks = at_rest.turn(eyes.link);
    goals.add_frame(
        eyes.link,
        &eyes.at,
        eye + scale * (human.eyes[1] - human.eyes[0]),
        human.head * looks,
        arm,
    );
    let mut grounded = false;
    for contact in &puppet.contacts {
        let site = &skeleton.sites()[contact.site];
        if skeleton.limbs().iter().any(|l| l.kind == LimbKind::Arm && l.end == site.link) {
            continue;
        }
        if let Some(moved) = human.moved(&contact.human) {
            grounded |= site.link == 0;
            goals.add(site.link, site.at, at_rest.point(site.link, &site.at) + scale * moved);
        }
    }
    if !grounded {
        let origin = at_rest.point(0, &Vec3::zeros());
        let turn = human.pelvis * at_rest.turn(0);
        goals.add_frame(0, &Vec3::zeros(), origin + scale * human.pelvis_moved, turn, arm);
    }
    let mut least = f64::INFINITY;
    for by in BENDS {
        let mut from = puppet.character.rest.clone();
        bend(&mut from, puppet, by);
        let missed = goals.solve(puppet, &mut from);
        if missed < least {
            (q, least) = (from, missed);
        }
    }

    let now = LocalPose::new(&puppet.features, Kinematics::new(skeleton, &q));
    for (shoulder, end, at) in arms(puppet) {
        let side = usize::from(at_rest.point(shoulder, &Vec3::zeros()).x < 0.0);
        let length = (at_rest.point(end, &at) - at_rest.point(shoulder, &Vec3::zeros())).norm();
        let full = length.max(arm_length(puppet, shoulder));
        goals.add(end, at, now.point(shoulder, &Vec3::zeros()) + human.reach[side] * full);
    }
    goals.solve(puppet, &mut q);
    let home = skeleton.position(&puppet.character.rest, 0);
    let height = skeleton.position(&q, 0).y;
    skeleton.set_position(&mut q, 0, &Vec3::new(home.x, height, home.z));
    Ok(q)
}

/// Bends all hinges but those of arms into their range, as far as `by`, rad: along a straight leg nothing moves a hip
/// down to first order, and a knee that is started straight is pressed against its stop. Elbows hang bent, and what
/// is asked of arms does not say how they swivel.
fn bend(q: &mut [f64], puppet: &Puppet, by: f64) {
    let skeleton = &puppet.character.skeleton;
    let arms: Vec<usize> =
        skeleton.limbs().iter().filter(|l| l.kind == LimbKind::Arm).map(|l| l.upper).collect();
    for (i, link) in skeleton.links().iter().enumerate() {
        if skeleton.ancestors(i).any(|l| arms.contains(&l)) {
            continue;
        }
        if let (Joint::Revolute(_), Some(Limits::Axis(range))) = (link.joint, &link.limits) {
            let angle = &mut q[skeleton.q_at(i)];
            *angle += (0.5 * (range.lo + range.hi) - *angle).clamp(-by, by);
        }
    }
}

/// Each arm's shoulder, and its end: a link and a point on it.
fn arms(puppet: &Puppet) -> Vec<(usize, usize, Vec3)> {
    let (skeleton, classes) = (&puppet.character.skeleton, &puppet.character.classes);
    let limbs = skeleton.limbs().iter().filter(|l| l.kind == LimbKind::Arm);
    let mut found: Vec<_> = limbs.map(|l| (l.upper, l.end, Vec3::zeros())).collect();
    for (i, link) in skeleton.links().iter().enumerate() {
        // a wing or flipper: a shoulder without elbow and hand
        if let Some(end) = link.end.filter(|_| classes[i] == JointClass::Shoulder) {
            found.push((i, i, end));
        }
    }
    found
}

/// Length of the outstretched arm that hangs on a shoulder, m; 0 for one of a single link.
fn arm_length(puppet: &Puppet, shoulder: usize) -> f64 {
    let links = puppet.character.skeleton.links();
    let bone = |link: usize| links[link].parent_from_zero.translation.vector.norm();
    let limb = puppet.character.skeleton.limbs().iter().find(|l| l.upper == shoulder);
    limb.map_or(0.0, |l| bone(l.lower) + bone(l.end))
}

/// A posed body in its root's local frame.
struct LocalPose {
    k: Kinematics,
    local: Transform,
}

impl LocalPose {
    fn new(features: &Features, k: Kinematics) -> Self {
        Self { local: features.root.local(&k.world[0], 0.0).inverse(), k }
    }

    fn point(&self, link: usize, at: &Vec3) -> Vec3 {
        (self.local * nalgebra::Point3::from(self.k.point(link, at))).coords
    }

    fn turn(&self, link: usize) -> Quat {
        self.local.rotation * self.k.world[link].rotation
    }
}

/// What of a human pose is matched; displacements and turns are from rest, in the local frame.
struct HumanPose {
    /// At rest, and now.
    eyes: [Vec3; 2],
    head: Quat,
    pelvis: Quat,
    pelvis_moved: Vec3,
    /// Left and right: shoulder to wrist, in lengths of the arm.
    reach: [Vec3; 2],
    /// Contact points and how they moved.
    contacts: Vec<(String, Vec3)>,
}

impl HumanPose {
    fn human(performer: &Performer, q: &[f64]) -> Result<Self, RetargetError> {
        let body = &performer.character;
        let skeleton = &body.skeleton;
        let anatomy = Anatomy::of(skeleton)?;
        let eyes = skeleton.site("eyes").ok_or_else(|| RetargetError::marker("eyes", skeleton))?;
        let (rest, now) = (Kinematics::new(skeleton, &body.rest), Kinematics::new(skeleton, q));
        let poses = [LocalPose::new(&performer.features, rest), LocalPose::new(&performer.features, now)];
        let turned = |link: usize| poses[1].turn(link) * poses[0].turn(link).inverse();
        let reach = anatomy.arms.map(|[shoulder, elbow, wrist]| {
            let at = |link: usize| poses[1].point(link, &Vec3::zeros());
            let bones = (at(elbow) - at(shoulder)).norm() + (at(wrist) - at(elbow)).norm();
            (at(wrist) - at(shoulder)) / bones.max(1e-9)
        });
        let moved = |s: &Site| poses[1].point(s.link, &s.at) - poses[0].point(s.link, &s.at);
        let sites = body.contacts.iter().map(|&c| &skeleton.sites()[c]);
        Ok(Self {
            eyes: [0, 1].map(|i| poses[i].point(eyes.link, &eyes.at)),
            head: turned(anatomy.head),
            pelvis: turned(0),
            pelvis_moved: poses[1].point(0, &Vec3::zeros()) - poses[0].point(0, &Vec3::zeros()),
            reach,
            contacts: sites.map(|s| (s.name.clone(), moved(s))).collect(),
        })
    }

    /// Mean displacement of the contact points with these names or beginnings of names.
    fn moved(&self, names: &[String]) -> Option<Vec3> {
        let is = |contact: &str, name: &str| {
            contact == name || contact.strip_prefix(name).is_some_and(|rest| rest.starts_with('_'))
        };
        let found = self.contacts.iter().filter(|(c, _)| names.iter().any(|n| is(c, n)));
        let (count, sum) = found.fold((0, Vec3::zeros()), |(n, sum), (_, moved)| (n + 1, sum + moved));
        (count > 0).then(|| sum / f64::from(count))
    }
}

/// Points of the puppet and where they should be, in its local frame.
#[derive(Default)]
struct PointGoals {
    points: Vec<Site>,
    at: Vec<f64>,
}

impl PointGoals {
    fn add(&mut self, link: usize, point: Vec3, to: Vec3) {
        self.points.push(Site { name: String::new(), link, at: point });
        self.at.extend(to.iter());
    }

    /// A point and two more, `arm` (m) before and above it, of a link with the local rotation `turn`.
    fn add_frame(&mut self, link: usize, point: &Vec3, to: Vec3, turn: Quat, arm: f64) {
        self.add(link, *point, to);
        for axis in [Vec3::z() * arm, Vec3::y() * arm] {
            self.add(link, point + axis, to + turn * axis);
        }
    }

    /// Moves `q` to the goals; returns the RMS distance that is left, m.
    fn solve(&self, puppet: &Puppet, q: &mut [f64]) -> f64 {
        let features = Features { points: self.points.clone(), root: puppet.features.root, unit_m: 1.0 };
        JointFit::new(&puppet.character.skeleton, &features).solve(&self.at, q, false).rms_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ContactPoint, Follow};
    use bodies::anthropometry::human::human;

    fn pair() -> (Performer, Puppet) {
        let (body, _) = human();
        let contacts = body.contacts.iter().map(|&site| ContactPoint {
            site,
            human: vec![body.skeleton.sites()[site].name.clone()],
            follow: Follow::Any,
        });
        let puppet = Puppet::new(body.clone(), contacts.collect()).unwrap();
        (Performer::new(body).unwrap(), puppet)
    }

    /// From human to the same human at rest, the guess is the rest pose.
    #[test]
    fn rest_stays_rest() {
        let (performer, puppet) = pair();
        let q = guess(&performer, &performer.character.rest, &puppet).unwrap();
        let s = &puppet.character.skeleton;
        let (a, b) = (Kinematics::new(s, &q), Kinematics::new(s, &puppet.character.rest));
        let worst = (0..s.links().len()).map(|i| (a.origin(i) - b.origin(i)).norm()).fold(0.0, f64::max);
        assert!(worst < 0.02, "{worst}"); // m; 0.013 seen, the wrists: what is matched there is a direction
    }

    /// The guess does not know the heading or the place of the human.
    #[test]
    fn heading_and_place_do_not_matter() {
        let (performer, puppet) = pair();
        let s = &performer.character.skeleton;
        let mut q = performer.character.rest.clone();
        let bent = motion::rotation::exp(&Vec3::new(0.6, 0.3, 0.0));
        s.set_rotation(&mut q, s.link("chest").unwrap(), &bent);
        let here = guess(&performer, &q, &puppet).unwrap();
        let turn = motion::rotation::exp(&(Vec3::y() * 2.1));
        let turned = turn * s.rotation(&q, 0);
        s.set_rotation(&mut q, 0, &turned);
        let moved = turn * s.position(&q, 0) + Vec3::new(3.0, 0.0, -7.0);
        s.set_position(&mut q, 0, &moved);
        let there = guess(&performer, &q, &puppet).unwrap();
        let worst = here.iter().zip(&there).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-6, "{worst}"); // 2e-9 seen
    }

    /// A human that crouches is the same human crouching, however deep: knees bend, feet stay, the pelvis comes down.
    #[test]
    fn a_crouch_is_a_crouch() {
        let (performer, puppet) = pair();
        let s = &performer.character.skeleton;
        let rest = Kinematics::new(s, &performer.character.rest);
        let turn = |x: f64| motion::rotation::exp(&(Vec3::x() * x.to_radians()));
        for (hip, knee, back) in [(-30.0, 50.0, 0.0), (-75.0, 110.0, 20.0), (-100.0, 130.0, 45.0)] {
            let mut q = performer.character.rest.clone();
            for side in ["l", "r"] {
                let link = |joint: &str| s.link(&format!("{joint}_{side}")).unwrap();
                s.set_rotation(&mut q, link("hip"), &turn(hip));
                q[s.q_at(link("knee"))] = f64::to_radians(knee);
                s.set_rotation(&mut q, link("ankle"), &turn(-hip - knee));
            }
            s.set_rotation(&mut q, s.link("chest").unwrap(), &turn(back));
            let foot = s.link("ankle_l").unwrap();
            let mut root = s.position(&q, 0);
            root.y += rest.origin(foot).y - Kinematics::new(s, &q).origin(foot).y;
            s.set_position(&mut q, 0, &root);
            let guessed = guess(&performer, &q, &puppet).unwrap();
            let (a, b) = (Kinematics::new(s, &guessed), Kinematics::new(s, &q));
            let off = |k: &Kinematics, name: &str| k.origin(s.link(name).unwrap()) - k.origin(0);
            for name in ["hip_l", "knee_l", "ankle_l", "knee_r", "ankle_r", "head"] {
                let apart = (off(&a, name) - off(&b, name)).norm();
                println!("knees at {knee}°: {name} {apart:.4} m");
                assert!(apart < 1e-3, "knees at {knee}°: {name}: {apart}");
            }
        }
    }

    /// The face looks where the human's looks.
    #[test]
    fn the_face_is_matched() {
        let (performer, puppet) = pair();
        let s = &performer.character.skeleton;
        let mut q = performer.character.rest.clone();
        for name in ["neck", "head"] {
            let turn = motion::rotation::exp(&Vec3::new(0.2, 0.4, 0.0));
            s.set_rotation(&mut q, s.link(name).unwrap(), &turn);
        }
        let guessed = guess(&performer, &q, &puppet).unwrap();
        let head = s.link("head").unwrap();
        let front = |q: &[f64]| Kinematics::new(s, q).world[head].rotation * Vec3::z();
        let angle = front(&q).angle(&front(&guessed)).to_degrees();
        assert!(angle < 1.0, "{angle}"); // 0.0° seen
    }
}
