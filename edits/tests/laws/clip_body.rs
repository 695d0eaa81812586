//! A walker with a floor and a script beside it, to try clip edits on.

use std::sync::{Arc, LazyLock};

use edits::{ClipEdit, EditLog, Edited, Motion, Where};
use motion::{Clip, Contact, ContactPlan, Joint, Kinematics, Link, Skeleton, Transform, Vec3, smoothstep};

use crate::body::dance;

/// Frames per second of all clips here.
pub const RATE_HZ: f64 = 50.0;

/// One step takes this long, s: a foot swings for one and stands for the next.
const STEP_S: f64 = 0.5;

/// Where the root (0), the left (1) or the right foot (2) of the walker is along z at `t` seconds, m.
fn along(what: usize, t: f64) -> f64 {
    let step = |k: f64| 0.6 * k + 0.3 * f64::from(what == 1) - 0.05;
    match what {
        0 => 0.6 * t,
        // the left foot swings in even steps, the right in odd ones
        foot => {
            let steps = t / STEP_S + f64::from(foot == 2);
            let k = (0.5 * steps).floor();
            step(k) + 0.6 * smoothstep((steps - 2.0 * k).min(1.0))
        }
    }
}

/// A root that walks at constant speed and two feet on slides, one of which stands at any time: 4 s. The feet stand
/// to rounding; contacts say when and where.
pub static WALK: LazyLock<Motion> = LazyLock::new(|| {
    let slide = Joint::Prismatic(Vec3::z());
    let links = vec![
        Link::new("pelvis", None, Vec3::zeros(), Joint::Free),
        Link::new("foot_l", Some(0), Vec3::new(0.1, -0.9, 0.0), slide),
        Link::new("foot_r", Some(0), Vec3::new(-0.1, -0.9, 0.0), slide),
    ];
    let s = Arc::new(Skeleton::new(links).unwrap());
    let mut q = Vec::new();
    for i in 0..=200 {
        let t = f64::from(i) / RATE_HZ;
        let mut pose = s.zero_pose();
        s.set_position(&mut pose, 0, &Vec3::new(0.0, 0.95, along(0, t)));
        for foot in [1, 2] {
            pose[s.q_at(foot)] = along(foot, t) - along(0, t);
        }
        q.extend(pose);
    }
    let mut contacts = Vec::new();
    for (foot, name, x) in [(1, "foot_l", 0.1), (2, "foot_r", -0.1)] {
        for k in (0..4).map(f64::from) {
            let from_s = (2.0 * k + f64::from(foot == 1)) * STEP_S;
            let world_from_point = Some(Transform::translation(x, 0.05, along(foot, from_s)));
            contacts.push(Contact { point: name.into(), from_s, to_s: from_s + STEP_S, world_from_point });
        }
    }
    let contacts = ContactPlan::new(contacts).unwrap();
    Motion { contacts, floor_m: Some(0.05), ..Motion::of(Clip::new(s, RATE_HZ, q)) }
});

/// The dance sampled, with its script beside it.
pub fn danced() -> Motion {
    let tracks = dance();
    Motion { tracks: Some(Arc::new(tracks.clone())), ..Motion::of(tracks.sample(RATE_HZ)) }
}

/// Applies an edit to everything at a place.
pub fn edited(edit: &dyn ClipEdit, motion: &Motion, at: &Where) -> (Edited, EditLog) {
    let mut log = EditLog::default();
    let edited = edit.apply(motion, at, &mut log).unwrap();
    (edited, log)
}

/// The words of a refusal; the log stays as it was.
pub fn refused(edit: &dyn ClipEdit, motion: &Motion, at: &Where) -> String {
    let mut log = EditLog::default();
    let words = edit.apply(motion, at, &mut log).unwrap_err().to_string();
    assert_eq!(log, EditLog::default());
    words
}

/// Furthest way of a point from where its contacts say that it stands, over the frames of each contact, m.
pub fn strays(clip: &Clip, plan: &ContactPlan) -> f64 {
    let mut worst = 0.0_f64;
    for frame in 0..clip.frames() {
        let k = Kinematics::new(&clip.skeleton, clip.pose(frame));
        for c in plan.at(frame as f64 / clip.rate_hz) {
            let link = clip.skeleton.link(&c.point).unwrap();
            worst = worst.max((k.origin(link) - c.world_from_point.unwrap().translation.vector).norm());
        }
    }
    worst
}

/// Largest difference between two clips over the frames of the first, rad or m.
pub fn apart(a: &Clip, b: &Clip) -> f64 {
    let mut v = vec![0.0; a.skeleton.nv()];
    let mut worst = 0.0_f64;
    for f in 0..a.frames() {
        a.skeleton.difference(a.pose(f), b.pose(f), 1.0, &mut v);
        worst = v.iter().fold(worst, |m, x| m.max(x.abs()));
    }
    worst
}
