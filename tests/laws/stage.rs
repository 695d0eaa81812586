//! Passes the laws run: a pose to hold, a script to perform, a clip to follow.

use std::path::PathBuf;
use std::sync::Arc;

use bodies::Character;
use controllers::{BalanceSettings, GainBlend, Goal, Setup};
use dynamics::{Model, RootMode, State};
use motion::script::{Action, Cycle, Pose, PoseValue, Properties};
use motion::{Clip, Curve, EulerOrder, Floor, Plant, Script, Tracks, Vec3};
use sim::{EngineEntry, Outcome, Pass};

/// Control rate of a run that does not say otherwise, Hz.
pub const RATE_HZ: f64 = 240.0;

/// Gravity of the earth, m/s².
pub fn gravity() -> Vec3 {
    Vec3::y() * -9.81
}

/// Holds the rest pose of `c` for `seconds`; nothing holds the root, there is no ground.
pub fn hold(c: &Arc<Character>, gravity: Vec3, tension: f64, seconds: f64) -> Pass {
    hold_at(c, gravity, tension, seconds, RATE_HZ)
}

/// The same at another rate.
pub fn hold_at(c: &Arc<Character>, gravity: Vec3, tension: f64, seconds: f64, rate_hz: f64) -> Pass {
    let frames = (seconds * rate_hz).round() as usize + 1;
    let clip = Clip::new(c.skeleton.clone(), rate_hz, c.rest.repeat(frames));
    follow(c, &clip, gravity, tension, rate_hz)
}

/// Follows `clip` with one substep; nothing holds the root, there is no ground.
pub fn follow(c: &Arc<Character>, clip: &Clip, gravity: Vec3, tension: f64, rate_hz: f64) -> Pass {
    let setup = Setup {
        character: c.clone(),
        gravity,
        goal: Goal::new(clip, rate_hz),
        tracks: None,
        dense: Default::default(),
        tension,
        plants: Vec::new(),
        ground_m: None,
        contacts: motion::ContactPlan::default(),
        balance: BalanceSettings::default(),
        blend: GainBlend::RestAngle,
    };
    Pass {
        setup,
        reactive: Vec::new(),
        substeps: Some(1),
        root: RootMode::Free,
        ground: None,
        tilts: Vec::new(),
        props: Vec::new(),
        self_collision: false,
        pushes: Vec::new(),
        carried: Vec::new(),
        past_fall: false,
        foresight: None,
        soles: Default::default(),
    }
}

/// Runs a pass to its end.
pub fn run(pass: Pass) -> Outcome {
    let out = pass.run(&EngineEntry::default(), &mut |_| {}).unwrap();
    assert!(out.diverged.is_none(), "{:?}", out.diverged);
    out
}

/// A bow with gestures: 0.5 s of standing, down, up with a turn, standing.
pub fn bow(c: &Character) -> Tracks {
    let ball = |x: f64, y: f64, z: f64| {
        EulerOrder::YZX.to_quat(&Vec3::new(y.to_radians(), z.to_radians(), x.to_radians()))
    };
    let rot = |name: &str, x: f64, y: f64, z: f64| PoseValue::rotation(name, ball(x, y, z));
    let none = Properties::default;
    let down = vec![
        rot("pelvis", 30.0, 0.0, 0.0),
        rot("abdomen", 15.0, 0.0, 0.0),
        rot("chest", 15.0, 0.0, 0.0),
        rot("neck", 15.0, 0.0, 0.0),
        rot("shoulder_r", 0.0, 60.0, 70.0),
        rot("shoulder_l", 0.0, 20.0, -80.0),
    ];
    let up = vec![
        rot("pelvis", 0.0, -10.0, 0.0),
        rot("abdomen", -5.0, -10.0, 0.0),
        rot("chest", -5.0, -15.0, 0.0),
        rot("neck", -10.0, -15.0, 0.0),
        rot("shoulder_r", 0.0, 40.0, -50.0),
        rot("shoulder_l", 0.0, 0.0, -78.0),
        PoseValue::scalar("elbow_r", 15.0_f64.to_radians()),
    ];
    let poses = [down, up].map(|values| Pose { properties: none(), values }).to_vec();
    let action = Action {
        name: "bow".into(),
        start_s: 0.5,
        properties: Properties {
            duration_s: Some(1.0),
            hold_s: Some(0.3),
            curve: Some(Curve::EaseInOut),
            ..none()
        },
        cycles: vec![Cycle { repetitions: 1, properties: none(), poses }],
    };
    let script = Script { properties: none(), actions: vec![action], inserts: Vec::new() };
    let mut tracks = script.build(&c.skeleton, &c.rest).unwrap();
    tracks.duration_s += 2.5;
    tracks
}

/// The figure performs `tracks`, standing freely on its feet or with its root pinned.
pub fn perform(c: &Arc<Character>, tracks: &Tracks, root: RootMode, rate_hz: f64, substeps: usize) -> Pass {
    let s = &c.skeleton;
    let model = Model::new(c, gravity());
    let mut state = State::new(&model);
    state.update(&model, &c.rest, &vec![0.0; model.nv()]);
    let over = motion::support::ground(&state.com(&model));
    let plants: Vec<Plant> = c.legs().map(|l| Plant::here(s, &c.rest, l)).collect();
    let mut clip = tracks.sample(rate_hz);
    for f in 0..clip.frames() {
        let q = clip.pose_mut(f);
        s.clamp_to_limits(q);
        controllers::posture::settle(&model, &mut state, q, &plants, over).unwrap();
    }
    let pinned = root == RootMode::Pinned;
    let setup = Setup {
        character: c.clone(),
        gravity: gravity(),
        goal: Goal::new(&clip, rate_hz),
        tracks: Some(tracks.clone()),
        dense: Default::default(),
        tension: 1.0,
        plants: if pinned { Vec::new() } else { plants },
        ground_m: None,
        contacts: motion::ContactPlan::default(),
        balance: BalanceSettings::default(),
        blend: GainBlend::RestAngle,
    };
    let ground = (!pinned).then_some(Floor::level(0.0, 0.8));
    Pass {
        setup,
        reactive: Vec::new(),
        substeps: Some(substeps),
        root,
        ground,
        tilts: Vec::new(),
        props: Vec::new(),
        self_collision: false,
        pushes: Vec::new(),
        carried: Vec::new(),
        past_fall: false,
        foresight: None,
        soles: Default::default(),
    }
}

/// A file of the motion-capture data beside the repository.
pub fn mocap(name: &str) -> PathBuf {
    support::shared(&format!("mocap/bvh/{name}"))
}

/// A body guessed for a clip, and the clip as that body can perform it.
pub fn performer(file: &std::path::Path) -> (Arc<Character>, Clip) {
    let (clip, _) = formats::bvh::read_file(file, &Default::default()).unwrap();
    let (c, _) = bodies::guess_body(&clip.skeleton, &Default::default()).unwrap();
    let map = bodies::PoseMap::new(&clip.skeleton, &c.skeleton).unwrap();
    let mut target = map.clip_to_character(&clip, &c.skeleton);
    for f in 0..target.frames() {
        c.skeleton.clamp_to_limits(target.pose_mut(f));
    }
    (Arc::new(c), target)
}
