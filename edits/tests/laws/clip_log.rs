//! The log of clip edits: what changed is found by comparing, and a failed edit leaves no trace.

use edits::{
    Amplitude, ClipEdit, ClipPlace, EditError, EditLog, Edited, Motion, Selector, TrackEdit, Warp, Where,
};
use motion::rotation::exp;
use motion::{Clip, TimeMap, Vec3};

use crate::clip_body::{RATE_HZ, WALK, danced, edited, refused};

/// Turns the spine and bends the right elbow in the span, moves the root in one frame of it.
struct Nudge;

impl ClipEdit for Nudge {
    fn name(&self) -> &'static str {
        "nudge"
    }

    fn change(&self, motion: &Motion, at: &ClipPlace, _: &mut EditLog) -> Result<Edited, EditError> {
        let mut edited = Edited::unchanged(motion);
        let s = motion.clip.skeleton.clone();
        let (spine, elbow) = (s.link("spine1").unwrap(), s.link("elbow_r").unwrap());
        for f in (0..motion.clip.frames()).filter(|f| at.covers(*f as f64 / RATE_HZ)) {
            let q = edited.clip.pose_mut(f);
            let turned = exp(&Vec3::new(0.0, 0.1, 0.0)) * s.rotation(q, spine);
            s.set_rotation(q, spine, &turned);
            q[s.q_at(elbow)] += 0.05;
            if f == 60 {
                let p = s.position(q, 0) + Vec3::new(0.003, 0.0, 0.004);
                s.set_position(q, 0, &p);
            }
        }
        Ok(edited)
    }
}

#[test]
fn the_log_says_when_which_joints_and_how_much() {
    let (_, log) = edited(&Nudge, &danced(), &Where::span(1.0, 1.5));
    let change = &log.clip_changes()[0];
    assert_eq!((change.edit, change.from_s, change.to_s), (0, 1.0, 1.5));
    assert_eq!(change.joints, ["pelvis", "spine1", "elbow_r"]);
    let (turned, moved) = (change.turned.as_ref().unwrap(), change.moved.as_ref().unwrap());
    assert!(turned.link == "spine1" && (turned.amount - 0.1_f64.to_degrees()).abs() < 1e-9);
    assert!(moved.link == "pelvis" && (moved.amount - 5.0).abs() < 1e-9 && moved.at_s == 1.2);
    assert_eq!((change.slopes, change.lengths_s), (None, (2.8, 2.8)));
    assert_eq!(
        log.to_string(),
        "nudge (edit 0): 1.000 s to 1.500 s: pelvis, spine1, elbow_r; at most 5.73° at spine1; pelvis moved by at most 5.0 mm\n\
         nudge (edit 0): at most pelvis 5.0 mm, spine1 5.73°, elbow_r 2.86°\n"
    );
}

/// A retiming moves no joint; track edits and clip edits are counted together, and conflicts are those of tracks.
#[test]
fn one_log_for_both_kinds() {
    let mut dance = danced();
    let mut log = EditLog::default();
    let mut tracks = (**dance.tracks.as_ref().unwrap()).clone();
    for _ in 0..2 {
        let all = Selector::label("bow_0_0_spine1").select(&tracks).unwrap();
        Amplitude::new(1.2).apply(&mut tracks, &all, &mut log).unwrap();
    }
    dance.clip = tracks.sample(RATE_HZ);
    let warp = Warp { anchors: vec![(0.0, 0.0), (2.8, 4.2)] };
    warp.apply(&dance, &Where::default(), &mut log).unwrap();
    assert_eq!(log.edits(), ["amplitude", "amplitude", "warp"]);
    assert_eq!(log.conflicts().len(), 1);
    let text = log.to_string();
    let line = "warp (edit 2): 0.000 s to 4.200 s: no joint; time has slopes 1.500 to 1.500, 2.800 s became 4.200 s\n";
    assert!(text.contains(line), "{text}");
}

/// Edits of a user that give what no clip can be.
enum Broken {
    Rate,
    Length,
    Numbers,
    Half,
}

impl ClipEdit for Broken {
    fn name(&self) -> &'static str {
        "broken"
    }

    fn change(&self, motion: &Motion, _: &ClipPlace, log: &mut EditLog) -> Result<Edited, EditError> {
        log.note("soon gone");
        let mut edited = Edited::unchanged(motion);
        let (s, q) = (motion.clip.skeleton.clone(), motion.clip.data().to_vec());
        match self {
            Self::Rate => edited.clip = Clip::new(s, 25.0, q),
            Self::Length => edited.times = TimeMap::new(&[(1.0, 1.0), (2.0, 2.5)]).unwrap(),
            Self::Numbers => edited.clip.pose_mut(30)[s.q_at(1)] = f64::NAN,
            Self::Half => return Err(EditError::Knots(3)),
        }
        Ok(edited)
    }
}

#[test]
fn a_failed_edit_leaves_no_trace() {
    let words = |edit: Broken| refused(&edit, &WALK, &Where::default());
    assert_eq!(words(Broken::Rate), "broken: the clip it gives has 25 Hz; allowed: 50 Hz, as before");
    assert_eq!(words(Broken::Length), "broken: the clip it gives has 201 frames; its times give 226");
    assert_eq!(
        words(Broken::Numbers),
        "broken: the clip it gives is not finite, or no rotation, at 0.600 s: foot_l"
    );
    assert_eq!(words(Broken::Half), EditError::Knots(3).to_string());
    let (_, mut log) = edited(&Nudge, &danced(), &Where::default());
    let before = log.clone();
    Broken::Half.apply(&WALK, &Where::default(), &mut log).unwrap_err();
    assert_eq!(log, before);
}
