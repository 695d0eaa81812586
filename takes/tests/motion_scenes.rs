//! Scenes whose motion is not a script: every word is honoured or refused at its line, whatever the source.

use std::path::Path;

use formats::bvh;
use motion::Clip;
use takes::{Ask, Input, Take, TakeError};

/// Writes a clip, two seconds of bending an elbow on both feet, and a body for it.
fn write_clip(dir: &Path) {
    let human = bodies::anthropometry::human::human().0;
    let elbow = human.skeleton.link("elbow_r").expect("an elbow");
    let at = human.skeleton.q_at(elbow);
    let mut clip = Clip::new(human.skeleton.clone(), 60.0, human.rest.repeat(121));
    for frame in 0..121 {
        let phase = std::f64::consts::TAU * frame as f64 / 120.0;
        clip.pose_mut(frame)[at] = 0.6 * (1.0 - phase.cos());
    }
    let path = dir.join("bend.bvh");
    bvh::write_file(&path, &clip, &bvh::WriteOptions::default()).expect("a clip");
    let (_, body) = takes::inspect::inspect(&path, &bvh::ImportOptions::default()).expect("a clip");
    let body = takes::character_file::write(&body.expect("a body"), "The bender.");
    std::fs::write(dir.join("body.ron"), body).expect("a file");
}

/// The take of a scene of a body that performs the clip, with more words.
fn of_clip(dir: &Path, words: &str) -> Result<Take, TakeError> {
    write_clip(dir);
    let ron = format!("Scene(\n character: \"body.ron\",\n motion: Clip(\"bend.bvh\"),\n{words}\n)");
    takes::open(Input::Text { ron, base: dir.to_owned() }, &Ask::default())
}

/// The take of a scene of the lamp that is put an angry human on, with more words.
fn of_human(words: &str) -> Result<Take, TakeError> {
    let (lamp, anger) = (support::scene("characters/lamp.ron"), support::scene("performances/anger.ron"));
    let ron = format!("Scene(\n character: {lamp:?},\n motion: Retarget(of: {anger:?}),\n{words}\n)");
    takes::open(Input::Text { ron, base: support::scene("") }, &Ask::default())
}

#[test]
fn words_that_are_of_scripts_are_refused_at_their_line() {
    let dir = tempfile::tempdir().unwrap();
    for (word, value) in [
        ("planted", "[\"leg_r\"]"),
        ("settle_s", "2"),
        ("properties", "(tension: 9)"),
        ("footwork", "[Step(limb: \"leg_r\", start_s: 0.5, to_m: (0.1, 0))]"),
    ] {
        let words = format!(" {word}: {value},");
        for refused in [of_clip(dir.path(), &words).err(), of_human(&words).err()] {
            let said = refused.unwrap_or_else(|| panic!("{word} is taken")).to_string();
            assert!(said.contains(word) && said.contains("scene.ron:4:"), "{word}: {said}");
        }
    }
}

#[test]
fn words_about_the_body_and_the_world_reach_the_take() {
    let dir = tempfile::tempdir().unwrap();
    let words = |link: &str| {
        format!(
            " root: Free, rate_hz: 33, carried: [Carried(link: \"{link}\", mass_kg: 3, from_s: 0)],
 pushes: [Push(link: \"{link}\", impulse_ns: 1, towards_deg: 0, start_s: 0.5)],
 reactive: [Gaze(at_m: (0, 1, 2), from_s: 0.2)], physics: (tension: 2, rate_hz: 480),
 tune: (own_run: false),"
        )
    };
    let from_clip = of_clip(dir.path(), &words("chest")).unwrap();
    assert!(from_clip.clip_source().is_some() && from_clip.asked.tracks.is_none());
    let from_human =
        of_human(&words("shade").replace("reactive: [Gaze(at_m: (0, 1, 2), from_s: 0.2)], ", "")).unwrap();
    for (take, gazes) in [(from_clip, 1), (from_human, 0)] {
        let c = &take.conditions;
        assert_eq!((c.carried.len(), c.pushes.len(), c.gazes.len()), (1, 1, gazes));
        assert_eq!(take.asked.clip.rate_hz, 33.0);
        assert_eq!((c.physics.tension, take.control_rate_hz()), (2.0, 480.0));
        let pass = take.pass();
        assert_eq!((pass.carried.len(), pass.pushes.len(), pass.reactive.len()), (1, 1, gazes));
    }
}

#[test]
fn what_begins_after_the_motion_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let late = " root: Free, pushes: [Push(link: \"LINK\", impulse_ns: 1, towards_deg: 0, start_s: 9999)],";
    for refused in [
        of_clip(dir.path(), &late.replace("LINK", "chest")).err(),
        of_human(&late.replace("LINK", "shade")).err(),
    ] {
        let said = refused.expect("the motion is shorter").to_string();
        assert!(said.contains("9999") && said.contains("scene.ron:4:"), "{said}");
    }
}

/// The refinement weighs the body in the world of the scene: on the Moon another motion has the forces of the human's.
#[test]
fn slow_gravity_and_friction_of_the_world_reach_the_refinement() {
    let far = |a: &Take, b: &Take| {
        let pairs = a.asked.clip.data().iter().zip(b.asked.clip.data());
        pairs.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
    };
    let earth = of_human("").unwrap();
    let said = of_human(" world: (gravity_m_s2: (0, -9.81, 0)),").unwrap();
    let moon = of_human(" world: (gravity_m_s2: (0, -1.62, 0)),").unwrap();
    assert_eq!(far(&earth, &said), 0.0);
    assert!(far(&earth, &moon) > 1e-4, "{:e}", far(&earth, &moon));
    let slick = of_human(" world: (ground: Plane(friction: 0)),").expect_err("no friction, no penalty force");
    assert!(slick.to_string().contains("friction"), "{slick}");
}

/// What was at a time of the source comes at its image; what keeps the motion's clock with it, and the world's clock stays.
#[test]
fn a_warped_clip_takes_its_conditions_along() {
    let dir = tempfile::tempdir().unwrap();
    let words = |edits: &str| {
        format!(
            " root: Free, {edits}
 pushes: [
   Push(link: \"chest\", impulse_ns: 1, towards_deg: 0, start_s: 1),
   Push(link: \"chest\", impulse_ns: 1, towards_deg: 0, start_s: 1, clock: World),
 ],"
        )
    };
    let plain = of_clip(dir.path(), &words("")).unwrap();
    let warped = of_clip(dir.path(), &words("edits: [Warp(times_s: [(0, 0), (1, 1.5), (2, 3)])],")).unwrap();
    let starts = |take: &Take| take.conditions.pushes.iter().map(|p| p.start_s).collect::<Vec<_>>();
    assert_eq!(starts(&plain), [1.0, 1.0]);
    assert_eq!(starts(&warped), [1.5, 1.0]);
    assert!((warped.asked.clip.duration_s() - 3.0).abs() < 1e-9);
    let skeleton = &plain.asked.clip.skeleton;
    let (mut a, mut b) = (vec![0.0; skeleton.nq()], vec![0.0; skeleton.nq()]);
    let mut worst = 0.0_f64;
    for i in 0..=20 {
        let t_s = 0.1 * f64::from(i);
        plain.asked.clip.sample(t_s, &mut a);
        warped.asked.clip.sample(warped.asked.times.at(t_s), &mut b);
        worst = a.iter().zip(&b).fold(worst, |worst, (a, b)| worst.max((a - b).abs()));
    }
    assert!(worst < 2e-3, "{worst} rad or m"); // frames are 1/60 s apart
}

/// Ground that is tilted from the start is refused under every motion that was made for level ground.
#[test]
fn ground_tilted_from_the_start_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let words = " world: (ground: Plane(friction: 0.8, tilt_deg: 5)),";
    for refused in [of_clip(dir.path(), words).err(), of_human(words).err()] {
        let said = refused.expect("the ground is tilted").to_string();
        assert!(said.contains("level") && said.contains("scene.ron:4:"), "{said}");
    }
}

/// What we write of a character comes back onto it: the BVH knows balls only, the character has hinges. From the command
/// line's body and from a scene's; the pose differs by what the digits of the file leave.
#[test]
fn a_clip_of_a_character_comes_back_onto_it() {
    let dir = tempfile::tempdir().unwrap();
    for name in ["lamp", "penguin", "squirrel"] {
        let file = support::scene(&format!("characters/{name}.ron"));
        let character = takes::character_file::read_file(&file).unwrap().character;
        let s = character.skeleton.clone();
        let mut clip = Clip::new(s.clone(), 30.0, character.rest.repeat(31));
        let mut v = vec![0.0; s.nv()];
        for frame in 0..31 {
            let swing = (frame as f64 / 5.0).sin();
            v.iter_mut().enumerate().for_each(|(dof, v)| *v = 0.3 * swing * (1.0 + 0.1 * dof as f64).sin());
            s.integrate(clip.pose_mut(frame), &v, 1.0);
            s.clamp_to_limits(clip.pose_mut(frame));
        }
        let path = dir.path().join(format!("{name}.bvh"));
        bvh::write_file(&path, &clip, &bvh::WriteOptions::default()).expect("a clip");
        let import = bvh::ImportOptions {
            metres_per_unit: Some(bvh::WriteOptions::default().metres_per_unit),
            up: Some(bvh::Axis::Y),
            ..bvh::ImportOptions::default()
        };
        let ask = Ask { body: Some(file.clone()), import, ..Ask::default() };
        let given = takes::open(path.as_path(), &ask).unwrap_or_else(|e| panic!("{name}: {e}"));
        let ron = format!("Scene(\n character: {file:?},\n motion: Clip({path:?}),\n)");
        let in_scene = takes::open(Input::Text { ron, base: dir.path().to_owned() }, &Ask::default());
        for take in [given, in_scene.unwrap_or_else(|e| panic!("{name} in a scene: {e}"))] {
            let asked = &take.unedited;
            assert_eq!(asked.frames(), clip.frames());
            for frame in 0..clip.frames() {
                s.difference(clip.pose(frame), asked.pose(frame), 1.0, &mut v);
                let off = v.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
                assert!(off < 1e-5, "{name} frame {frame}: {off}"); // 2e-8 seen
            }
        }
    }
}
