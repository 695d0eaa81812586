//! Bodies and clips that the laws are tried on.

use std::sync::Arc;

use bodies::{Body, Character};
use formats::bvh::{self, ImportOptions};
use motion::{Clip, Kinematics, Limits, Shape, Skeleton, Smoothing, Transform, Vec3};
use retarget::contacts::{Phase, adjust, phases};
use retarget::global_transform::{global_transform, in_local_frame};
use retarget::{
    ContactOptions, ContactPoint, ContactReport, Follow, GlobalOptions, KeyPose, KeyPoses, Performer, Puppet,
    SizeRatio,
};

/// A clip of `../shared/mocap`, at 30 Hz, smoothed, on the performer's skeleton with the ground at 0.
pub fn mocap(name: &str) -> (Performer, Clip) {
    let path = support::shared(&format!("mocap/bvh/{name}.bvh"));
    let options = ImportOptions { metres_per_unit: Some(0.0564444), ..ImportOptions::default() };
    let (clip, _) = bvh::read_file(&path, &options).unwrap();
    let performer = Performer::of_clip(&clip).unwrap();
    let human = retarget::prepare(&clip, &performer, Some(30.0), Smoothing::Auto, None).unwrap();
    (performer, human)
}

/// The same body at another size: lengths × `size`, masses × `size³`, with legs longer by `legs` more; no limits.
pub fn scaled(c: &Character, size: f64, legs: f64) -> Character {
    let s = &c.skeleton;
    let in_leg: Vec<f64> = (0..s.links().len())
        .map(|i| if c.legs().any(|l| under(s, i, l.upper) && i != l.upper) { size * legs } else { size })
        .collect();
    let links = s.links().iter().enumerate().map(|(i, l)| {
        let mut l = l.clone();
        l.parent_from_zero = Transform::from_parts(
            (l.parent_from_zero.translation.vector * in_leg[i]).into(),
            l.parent_from_zero.rotation,
        );
        l.end = l.end.map(|e| e * size);
        l.limits = None::<Limits>;
        l
    });
    let sites = s.sites().iter().cloned().map(|mut site| {
        site.at *= size;
        site
    });
    let skeleton = Skeleton::new(links.collect()).unwrap();
    let skeleton = skeleton.with_sites(sites.collect()).unwrap().with_limbs(s.limbs().to_vec()).unwrap();
    let shape = |x: &Shape| match *x {
        Shape::Capsule { a, b, radius } => Shape::Capsule { a: a * size, b: b * size, radius: radius * size },
        Shape::Box { center, half, rotation } => {
            Shape::Box { center: center * size, half: half * size, rotation }
        }
        Shape::Sphere { center, radius } => Shape::Sphere { center: center * size, radius: radius * size },
        Shape::Cone { .. } => panic!("a human has no cones"),
    };
    let body = |b: &Body| Body {
        mass: b.mass * size.powi(3),
        com: b.com * size,
        inertia: b.inertia * size.powi(5),
        shapes: b.shapes.iter().map(shape).collect(),
    };
    let mut rest = c.rest.clone();
    (0..3).for_each(|i| rest[s.q_at(0) + i] *= size);
    Character {
        name: format!("{} × {size}", c.name),
        skeleton: Arc::new(skeleton),
        bodies: c.bodies.iter().map(body).collect(),
        classes: c.classes.clone(),
        contacts: c.contacts.clone(),
        rest,
    }
    .check()
    .unwrap()
}

fn under(s: &Skeleton, link: usize, top: usize) -> bool {
    s.ancestors(link).any(|u| u == top)
}

/// A puppet whose contact points follow the human ones of the same name.
pub fn puppet(c: Character) -> Puppet {
    let contact = |&site: &usize| ContactPoint {
        site,
        human: vec![c.skeleton.sites()[site].name.clone()],
        follow: Follow::Any,
    };
    let contacts = c.contacts.iter().map(contact).collect();
    Puppet::new(c, contacts).unwrap()
}

/// The joint angles of a clip on a body of the same topology, the root's place times `size` and as high as feet on the
/// ground want it.
pub fn same_angles(clip: &Clip, c: &Character, size: f64) -> Clip {
    let (mut q, nq) = (clip.data().to_vec(), clip.skeleton.nq());
    let lowest = |s: &Skeleton, pose: &[f64]| {
        let k = Kinematics::new(s, pose);
        let height = |&i: &usize| k.point(s.sites()[i].link, &s.sites()[i].at).y;
        c.contacts.iter().map(height).fold(f64::INFINITY, f64::min)
    };
    let mut off = Vec::new();
    for pose in q.chunks_exact_mut(nq) {
        let human = lowest(&clip.skeleton, pose);
        let p: Vec3 = clip.skeleton.position(pose, 0) * size;
        clip.skeleton.set_position(pose, 0, &p);
        off.push(lowest(&c.skeleton, pose) - human * size);
    }
    off.sort_by(f64::total_cmp);
    let lower = off[off.len() / 2];
    q.chunks_exact_mut(nq).for_each(|pose| pose[c.skeleton.q_at(0) + 1] -= lower);
    Clip::new(c.skeleton.clone(), clip.rate_hz, q)
}

/// Every `step`-th frame of a clip paired with the same angles on the puppet.
pub fn key_poses(performer: &Performer, human: &Clip, puppet: &Puppet, size: f64, step: usize) -> KeyPoses {
    let own = same_angles(human, &puppet.character, size);
    let performer = Arc::new(performer.clone());
    let pair = |i: usize| {
        let name = format!("frame {i}");
        KeyPose::of_frame(&name, "clip", &performer, human, i, 0.0, own.pose(i).to_vec()).unwrap()
    };
    KeyPoses { pairs: (0..human.frames()).step_by(step).map(pair).collect() }
}

/// A clip with its contacts held on a body of other proportions, and the human clip behind it.
pub struct Held {
    pub human: Clip,
    pub puppet: Puppet,
    pub clip: Clip,
    pub phases: Vec<Phase>,
    pub report: ContactReport,
}

/// Puts a clip on a body scaled by `size` with legs longer by `legs` more, and its feet on the ground.
pub fn held(name: &str, size: f64, legs: f64) -> Held {
    let (performer, human) = mocap(name);
    let puppet = puppet(scaled(&performer.character, size, legs));
    let local = in_local_frame(&same_angles(&human, &puppet.character, size), &puppet.features.root);
    // steps as long as the legs make them: the paper's ratio knows nothing of legs
    let options = GlobalOptions { size: SizeRatio::Fixed(size * legs), ..GlobalOptions::default() };
    let (moved, _) = global_transform(&performer, &human, &puppet, &local, &options);
    let phases = phases::find(&performer, &human, &puppet, &ContactOptions::default()).unwrap();
    let (clip, report) = adjust(&puppet, &moved, &phases).unwrap();
    Held { human, puppet, clip, phases, report }
}

/// Moves the contact points of the left foot up by `by_m` (at rest).
pub fn raise_left_sole(character: &mut Character, by_m: f64) {
    let s = character.skeleton.clone();
    let rest = Kinematics::new(&s, &character.rest);
    let raised = s.sites().iter().cloned().map(|mut site| {
        if site.name.starts_with("ball_l") || site.name.starts_with("heel_l") {
            site.at += rest.world[site.link].rotation.inverse() * Vec3::new(0.0, by_m, 0.0);
        }
        site
    });
    character.skeleton = Arc::new(s.as_ref().clone().with_sites(raised.collect()).unwrap());
}
