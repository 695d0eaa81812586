//! Edits of tracks on clips, through a fit.

use std::f64::consts::TAU;

use edits::succession::{Direction, ranks};
use edits::tension::Steps;
use edits::{
    Amount, Amplitude, ClipEdit, EditError, EditLog, Edited, ExtentReach, ExtentShoulder, Motion, OnFit,
    Parameter, Succession, Tension, TrackEdit, Where,
};
use motion::rotation::{exp, log};
use motion::{Clip, Contact, ContactPlan, Dof, Fit, Kinematics, LimbKind, Tolerance, Vec3};

use crate::body::{base, skeleton};

const RATE_HZ: f64 = 100.0;

/// Six seconds on both feet: every joint above the hips swings in its own way, the arms with a tremor that no fit within 2° sees.
fn swing() -> Motion {
    let s = skeleton();
    let mut q = Vec::new();
    for frame in 0..=600 {
        let t = f64::from(frame) / RATE_HZ;
        let mut pose = base(&s);
        for (link, l) in s.links().iter().enumerate() {
            let f = link as f64;
            let wave = |hz: f64, phase: f64| (TAU * hz * t + phase).sin();
            let size = match l.name.as_str() {
                n if n.starts_with("shoulder") => 0.5,
                n if n.starts_with("wrist") => 0.3,
                n if n.starts_with("spine") || n.starts_with("neck") || n.starts_with("clavicle") => 0.12,
                _ => continue,
            };
            let tremor = 0.003 * wave(15.0, f);
            let r = Vec3::new(wave(0.7, f), 0.6 * wave(1.1, 2.0 * f), 0.4 * wave(0.5, 3.0 * f)) * size
                + Vec3::new(tremor, 0.0, 0.0);
            let there = exp(&r) * s.rotation(&pose, link);
            s.set_rotation(&mut pose, link, &there);
        }
        for (name, phase) in [("elbow_l", 0.0), ("elbow_r", 1.0)] {
            let at = s.q_at(s.link(name).unwrap());
            pose[at] = 0.9 + 0.5 * (TAU * 0.8 * t + phase).sin();
        }
        q.extend(pose);
    }
    let foot = |point: &str| Contact { point: point.into(), from_s: 0.0, to_s: 6.0, world_from_point: None };
    let contacts = ContactPlan::new(vec![foot("leg_l"), foot("leg_r")]).unwrap();
    Motion { contacts, ..Motion::of(Clip::new(s, RATE_HZ, q)) }
}

fn on(edit: impl TrackEdit + Send + Sync + 'static, motion: &Motion, at: &Where) -> Edited {
    OnFit::new(edit).apply(motion, at, &mut EditLog::default()).unwrap()
}

fn arms(motion: &Motion) -> Vec<usize> {
    let limbs = motion.clip.skeleton.limbs().iter().filter(|l| l.kind == LimbKind::Arm);
    limbs.flat_map(|l| [l.upper, l.lower, l.end]).collect()
}

/// An edit that changes nothing returns the clip to the bit, however coarse the fit.
#[test]
fn identity_to_the_bit() {
    let motion = swing();
    let all: Vec<Box<dyn TrackEdit + Send + Sync>> = vec![
        Box::new(Succession::forward(0.0)),
        Box::new(Succession::reverse(0.0)),
        Box::new(Amplitude::new(1.0)),
        Box::new(Amplitude::about(1.0, motion.clip.skeleton.zero_pose())),
        Box::new(ExtentShoulder::new(1.0)),
        Box::new(ExtentReach::new(1.0)),
    ];
    for edit in all {
        let name = edit.name();
        let fit = Tolerance { deg: 8.0, mm: 50.0 };
        let mut log = EditLog::default();
        let edited = OnFit { edit, fit }.apply(&motion, &Where::default(), &mut log).unwrap();
        assert!(edited == Edited::unchanged(&motion), "{name}");
        assert!(log.clip_changes().is_empty(), "{name}: {log}");
    }
}

/// Once lateness has come, a joint is where it was offset × depth before, to the bit where that is a frame: its detail goes with it.
#[test]
fn succession_delays_each_joint_by_its_depth() {
    let motion = swing();
    let s = &motion.clip.skeleton;
    let edited = on(Succession::forward(0.05), &motion, &Where::default());
    // legs and root stand, so that they are left out and count for no depth
    let moved: Vec<bool> = (0..s.links().len())
        .map(|l| {
            Dof::of_link(s, l).is_some_and(|d| {
                d.read(s, motion.clip.pose(0)).distance(&d.read(s, motion.clip.pose(33))) > 0.0
            })
        })
        .collect();
    let depth = ranks(s, &moved, Direction::Forward);
    assert_eq!(depth[s.link("wrist_r").unwrap()], 5);
    let mut worst = 0.0_f64;
    for link in (0..s.links().len()).filter(|l| moved[*l]) {
        let dof = Dof::of_link(s, link).unwrap();
        for frame in 200..=600 {
            let before = dof.read(s, motion.clip.pose(frame - 5 * depth[link]));
            worst = worst.max(before.distance(&dof.read(s, edited.clip.pose(frame))));
        }
    }
    assert!(worst < 1e-9, "{worst:e} rad"); // 1e-15 seen
}

/// Lateness comes and goes smoothly: no joint turns faster than 1.6 times its peak, and outside the span nothing changes.
#[test]
fn succession_begins_and_ends_smoothly() {
    let motion = swing();
    let s = &motion.clip.skeleton;
    let at = Where::span(1.0, 5.0);
    let edited = on(Succession::forward(0.05), &motion, &at);
    let speed = |clip: &Clip, link: usize, f: usize| {
        let dof = Dof::of_link(s, link).unwrap();
        dof.read(s, clip.pose(f)).distance(&dof.read(s, clip.pose(f + 1))) * RATE_HZ
    };
    for link in arms(&motion) {
        let peak = |clip: &Clip| (0..600).map(|f| speed(clip, link, f)).fold(0.0, f64::max);
        let share = peak(&edited.clip) / peak(&motion.clip);
        assert!(share < 1.61, "{}: {share}", s.links()[link].name);
    }
    for frame in (0..=100).chain(500..=600) {
        assert_eq!(edited.clip.pose(frame), motion.clip.pose(frame), "{frame}");
    }
}

/// Half the amplitude: half the angle from the mean of every joint above the hips, but for half of what the fit left.
#[test]
fn amplitude_scales_about_the_mean() {
    let motion = swing();
    let s = &motion.clip.skeleton;
    let edited = on(Amplitude::new(0.5), &motion, &Where::default());
    for link in arms(&motion).into_iter().filter(|l| Dof::of_link(s, *l).is_some_and(|d| d.is_rotation())) {
        let range = |clip: &Clip| {
            let all: Vec<_> = (0..=600).step_by(5).map(|f| s.rotation(clip.pose(f), link)).collect();
            let far =
                |a: &motion::Quat| all.iter().map(|b| log(&(a * b.inverse())).norm()).fold(0.0, f64::max);
            all.iter().map(far).fold(0.0, f64::max)
        };
        let (half, whole) = (range(&edited.clip), range(&motion.clip));
        let off = (half - 0.5 * whole).abs().to_degrees();
        let allowed = (0.05 * 0.5 * whole.to_degrees()).max(2.0);
        assert!(off < allowed, "{}: {off}° of {}°", s.links()[link].name, whole.to_degrees()); // 0.9° seen
    }
}

/// What the fit leaves out stays: the tremor is as large after as before.
#[test]
fn detail_is_kept() {
    let motion = swing();
    let s = &motion.clip.skeleton;
    let edited = on(Amplitude::new(0.5), &motion, &Where::default());
    let link = s.link("shoulder_r").unwrap();
    // fourth differences of the rotation vector see a tremor of 15 Hz and little else
    let tremor = |clip: &Clip| {
        let at = |f: usize| log(&s.rotation(clip.pose(f), link)).x;
        let of = |f: usize| at(f + 6) - 4.0 * at(f + 3) + 6.0 * at(f) - 4.0 * at(f - 3) + at(f - 6);
        ((6..595).map(|f| of(f).powi(2)).sum::<f64>() / 589.0).sqrt()
    };
    let share = tremor(&edited.clip) / tremor(&motion.clip);
    assert!((0.8..1.2).contains(&share), "{share}");
}

/// The mean distance of the hands scales, within 1 %.
#[test]
fn reach_scales_the_mean_distance() {
    let motion = swing();
    let s = &motion.clip.skeleton;
    for factor in [0.8, 0.9] {
        let edited = on(ExtentReach::new(factor), &motion, &Where::default());
        for limb in s.limbs().iter().filter(|l| l.kind == LimbKind::Arm) {
            let mean = |clip: &Clip| {
                let of = |f: usize| {
                    let k = Kinematics::new(s, clip.pose(f));
                    (k.origin(limb.end) - k.origin(limb.upper)).norm()
                };
                (0..=600).map(of).sum::<f64>() / 601.0
            };
            let share = mean(&edited.clip) / mean(&motion.clip);
            assert!((share - factor).abs() < 0.01 * factor, "{} × {factor}: {share}", limb.name); // 0.4 % seen
        }
    }
}

/// The root and legs that stand are left alone to the bit; named they move, and feet stand where they stood all the same.
#[test]
fn feet_stand_where_they_stood() {
    let mut motion = swing();
    let s = motion.clip.skeleton.clone();
    // the pelvis sways over the standing feet
    let before = motion.clip.clone();
    for frame in 0..=600 {
        let q = motion.clip.pose_mut(frame);
        let t = frame as f64 / RATE_HZ;
        let feet: Vec<motion::Plant> = s
            .limbs()
            .iter()
            .filter(|l| l.kind == LimbKind::Leg)
            .map(|l| motion::Plant::here(&s, before.pose(0), l))
            .collect();
        let p =
            s.position(q, 0) + Vec3::new(0.04 * (TAU * 0.6 * t).sin(), -0.05, 0.02 * (TAU * 0.9 * t).sin());
        s.set_position(q, 0, &p);
        motion::plant::plant(&s, q, &feet).unwrap();
    }
    let feet: Vec<usize> = s.limbs().iter().filter(|l| l.kind == LimbKind::Leg).map(|l| l.end).collect();
    let legs: Vec<usize> = s
        .limbs()
        .iter()
        .filter(|l| l.kind == LimbKind::Leg)
        .flat_map(|l| [l.upper, l.lower, l.end])
        .collect();
    let off = |edited: &Edited| {
        let mut worst = 0.0_f64;
        for f in 0..=600 {
            let (a, b) = (Kinematics::new(&s, motion.clip.pose(f)), Kinematics::new(&s, edited.clip.pose(f)));
            worst = feet.iter().map(|l| (a.origin(*l) - b.origin(*l)).norm()).fold(worst, f64::max);
        }
        worst
    };
    let edited = on(Amplitude::new(0.5), &motion, &Where::default());
    for dof in Dof::all(&s).into_iter().filter(|d| d.link() == 0 || legs.contains(&d.link())) {
        for f in 0..=600 {
            assert_eq!(dof.read(&s, motion.clip.pose(f)), dof.read(&s, edited.clip.pose(f)));
        }
    }
    assert_eq!(off(&edited), 0.0);
    let named = on(Amplitude::new(1.5), &motion, &Where::default().of(["pelvis_x", "pelvis_z"]));
    let most = |clip: &Clip| (0..=600).map(|f| s.position(clip.pose(f), 0).x).fold(f64::MIN, f64::max);
    assert!(most(&named.clip) > most(&motion.clip) + 0.015, "the sway is larger");
    assert!(off(&named) < 1e-6, "{:e} m", off(&named)); // 2e-16 seen
}

/// What means nothing on a clip is refused in words, and leaves no trace.
#[test]
fn what_means_nothing_is_refused() {
    let motion = swing();
    let said = |edit: Box<dyn TrackEdit + Send + Sync>, at: &Where| {
        let mut log = EditLog::default();
        let e = OnFit { edit, fit: Tolerance::default() }.apply(&motion, at, &mut log).unwrap_err();
        assert_eq!(log, EditLog::default());
        e.to_string()
    };
    let per_pose = || Parameter::PerPose(vec![0.5; 40]);
    let all = Where::default();
    for edit in [
        Box::new(Amplitude { factor: per_pose(), reference: None }) as Box<dyn TrackEdit + Send + Sync>,
        Box::new(Succession::forward(per_pose())),
        Box::new(ExtentReach::new(Parameter::OverRepetition(vec![(0.0, 1.0)]))),
        Box::new(ExtentShoulder::new(per_pose())),
    ] {
        let e = said(edit, &all);
        assert!(e.contains("a fitted clip has neither"), "{e}");
    }
    let e = said(Box::new(Amplitude::new(0.5)), &Where::default().of(["knee_l"]));
    assert!(e.contains("knee_l keep still in this clip"), "{e}");
    let e = said(Box::new(Amplitude::new(-1.0)), &all);
    assert!(e.contains("factor is -1"), "{e}");
    let e = said(Box::new(Amplitude::new(0.5)), &Where::label("wave"));
    assert!(e.contains("this motion has none"), "{e}");
    let e = said(Box::new(Tension { amount: Amount::Factor(2.0.into()) }), &all);
    assert!(e.contains("changes no pose"), "{e}");
    let rough = OnFit { edit: Box::new(Amplitude::new(0.5)), fit: Tolerance { deg: 0.0, mm: 1.0 } };
    let e = rough.apply(&motion, &all, &mut EditLog::default()).unwrap_err();
    assert!(matches!(e, EditError::Fit { .. }), "{e}");
}

/// A fit is within its tolerance at every frame; the log says so, and how many keys it took.
#[test]
fn the_fit_is_said() {
    let motion = swing();
    let mut log = EditLog::default();
    OnFit::new(Amplitude::new(0.5)).apply(&motion, &Where::default(), &mut log).unwrap();
    let fit = Fit::of(&motion.clip, &Tolerance::default()).unwrap();
    let said = fit.report.to_string();
    assert!(log.notes().iter().any(|(_, note)| *note == said), "{log}");
    assert!(log.notes().iter().any(|(_, note)| note.contains("left out") && note.contains("leg_l")), "{log}");
}

/// Tension of a clip is a function of time: factors multiply what is there, absolute values replace it, only in the span.
#[test]
fn tension_of_a_clip_is_over_time() {
    let motion = swing();
    let s = &motion.clip.skeleton;
    let elbow = s.link("elbow_r").unwrap();
    let mut steps = vec![Steps::new(); s.links().len()];
    let mut log = EditLog::default();
    let mut edit = |amount: Amount, at: Where, steps: &mut Vec<Steps>| {
        Tension { amount }.on_clip(&motion, &at, (&[], ""), steps, &mut log)
    };
    let at = |from_s, to_s| Where { span_s: Some((from_s, to_s)), ..Where::default().of(["elbow_r"]) };
    edit(Amount::Factor(2.0.into()), at(1.0, 3.0), &mut steps).unwrap();
    assert_eq!(steps[elbow], [(0.0, 1.0), (1.0, 2.0), (3.0, 1.0)]);
    edit(Amount::Factor(3.0.into()), at(2.0, 6.0), &mut steps).unwrap();
    assert_eq!(steps[elbow], [(0.0, 1.0), (1.0, 2.0), (2.0, 6.0), (3.0, 3.0)]);
    edit(Amount::Absolute(0.5.into()), at(0.0, 2.5), &mut steps).unwrap();
    assert_eq!(steps[elbow], [(0.0, 0.5), (2.5, 6.0), (3.0, 3.0)]);
    let ramp = Parameter::OverTime(vec![(4.0, 1.0), (5.0, 2.0)]);
    edit(Amount::Factor(ramp), at(4.0, 5.0), &mut steps).unwrap();
    let middle = steps[elbow].iter().rev().find(|step| step.0 <= 4.5).unwrap().1;
    assert!((middle - 4.5).abs() < 1e-9, "{middle}");
    assert_eq!(steps.iter().filter(|s| !s.is_empty()).count(), 1);
    let refused = edit(Amount::Factor(2.0.into()), Where::default().of(["pelvis"]), &mut steps);
    assert!(refused.unwrap_err().to_string().contains("no muscles"));
    let held = Tension { amount: Amount::Factor(2.0.into()) };
    let why = "the balance decides";
    let at = Where::default().of(["elbow_r"]);
    let refused = held.on_clip(&motion, &at, (&[elbow], why), &mut steps, &mut EditLog::default());
    assert!(refused.unwrap_err().to_string().contains("elbow_r: the balance decides"));
}
