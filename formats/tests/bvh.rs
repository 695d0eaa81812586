//! BVH: what the files in the wild mean, that nothing breaks the reader, that writing loses nothing.
//!
//! Files come from `../shared`; their truth is in the README beside them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use formats::bvh::{
    Axis, Bvh, Channel, Chosen, ImportError, ImportOptions, TPoseRule, WriteError, WriteOptions, import,
    read_file, write, write_file,
};
use motion::rotation::{exp, log};
use motion::{Clip, EulerOrder, Joint, Kinematics, Link, Quat, Skeleton, Transform, Vec3};
use nalgebra::{Matrix3, Rotation3, Translation3};
use proptest::prelude::*;
use support::shared;

fn bytes(path: &str) -> Vec<u8> {
    let path = shared(path);
    std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn files(folder: &str) -> Vec<PathBuf> {
    support::files(&shared(folder), "bvh")
}

fn parse(text: &str) -> Result<Bvh, String> {
    Bvh::parse(text.as_bytes()).map_err(|e| e.to_string())
}

fn load(path: &str) -> (Clip, formats::bvh::ImportReport) {
    read_file(&shared(path), &ImportOptions::default()).unwrap()
}

/// World transforms by the definition in the format's header: 3×3 matrices, another road than `Kinematics`.
fn world(bvh: &Bvh, frame: &[f64]) -> Vec<(Matrix3<f64>, Vec3)> {
    let mut world: Vec<(Matrix3<f64>, Vec3)> = Vec::new();
    for joint in &bvh.joints {
        let (mut r, mut t) = (Matrix3::identity(), Vec3::from(joint.offset));
        for (k, channel) in joint.channels.iter().enumerate() {
            let value = frame[joint.channels_at + k];
            match *channel {
                Channel::Position(axis) => t[axis] = value,
                Channel::Rotation(axis) => {
                    let turn = Vec3::ith(axis, value.to_radians());
                    r *= Rotation3::from_scaled_axis(turn).matrix();
                }
            }
        }
        let (up, from) = joint.parent.map_or((Matrix3::identity(), Vec3::zeros()), |p| world[p]);
        world.push((up * r, from + up * t));
    }
    world
}

/// Largest difference of joint rotations (deg) and of world positions (m) between two clips.
fn residue(a: &Clip, b: &Clip) -> (f64, f64) {
    assert_eq!(a.frames(), b.frames());
    let (mut turn, mut apart) = (0.0f64, 0.0f64);
    for frame in 0..a.frames() {
        let (ka, kb) =
            (Kinematics::new(&a.skeleton, a.pose(frame)), Kinematics::new(&b.skeleton, b.pose(frame)));
        for (i, link) in a.skeleton.links().iter().enumerate() {
            let j = b.skeleton.link(&link.name).unwrap();
            let ra = a.skeleton.rotation(a.pose(frame), i);
            let rb = b.skeleton.rotation(b.pose(frame), j);
            turn = turn.max(log(&(ra * rb.inverse())).norm().to_degrees());
            apart = apart.max((ka.origin(i) - kb.origin(j)).norm());
        }
    }
    (turn, apart)
}

#[test]
fn slow_a_clip_written_and_read_is_the_same_clip() {
    let paths = files("mocap/bvh");
    assert_eq!(paths.len(), 37);
    let (mut turn, mut apart) = (0.0f64, 0.0f64);
    let (mut turn_other, mut apart_other) = (0.0f64, 0.0f64);
    for path in paths {
        let (clip, _) = read_file(&path, &ImportOptions::default()).unwrap();
        let text = write(&clip, &WriteOptions::default()).unwrap();
        let options = ImportOptions { metres_per_unit: Some(0.01), up: Some(Axis::Y), ..Default::default() };
        let (back, report) = import(&parse(&text).unwrap(), &options).unwrap();
        assert_eq!(back.rate_hz, clip.rate_hz, "{}", report.rate);
        assert_eq!(back.skeleton.links().len(), clip.skeleton.links().len());
        let (t, a) = residue(&clip, &back);
        (turn, apart) = (turn.max(t), apart.max(a));
        // Seen at worst: 1.1e-13° and 2.9e-8 m. The files' own angles have fewer digits and the same order,
        // so they come back as they were; offsets are rounded to 1e-8 m.
        assert!(t < 1e-4, "{}: {t}°", path.display());
        assert!(a < 1e-5, "{}: {a} m", path.display());
        let other = WriteOptions { order: EulerOrder::YZX, ..Default::default() };
        let (back, _) = import(&parse(&write(&clip, &other).unwrap()).unwrap(), &options).unwrap();
        let (t, a) = residue(&clip, &back);
        (turn_other, apart_other) = (turn_other.max(t), apart_other.max(a));
        assert!(t < 2e-6, "{}: {t}°", path.display()); // 1.1e-6° seen, six decimals
        assert!(a < 1e-6, "{}: {a} m", path.display());
    }
    println!("worst: {turn:.1e}°, {apart:.1e} m; in another order {turn_other:.1e}°, {apart_other:.1e} m");
}

#[test]
fn every_euler_order_writes_the_same_motion() {
    let (clip, _) = load("bvh-zoo/bvhtoolbox_walk01.bvh");
    for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]].map(EulerOrder) {
        let text = write(&clip, &WriteOptions { order, metres_per_unit: 1.0, decimals: 9 }).unwrap();
        let options = ImportOptions { metres_per_unit: Some(1.0), ..Default::default() };
        let (back, _) = import(&parse(&text).unwrap(), &options).unwrap();
        let (turn, apart) = residue(&clip, &back); // 1.0e-9°, 3.1e-10 m seen
        assert!(turn < 1e-8 && apart < 1e-8, "{order:?}: {turn}°, {apart} m");
    }
}

/// The comparison sees a swapped axis.
#[test]
fn a_swapped_axis_is_seen() {
    let (clip, _) = load("bvh-zoo/bvhtoolbox_walk01.bvh");
    let text = write(&clip, &WriteOptions::default()).unwrap();
    let swapped = text.replace("Zrotation Yrotation", "Yrotation Zrotation");
    let options = ImportOptions { metres_per_unit: Some(0.01), ..Default::default() };
    let (back, _) = import(&parse(&swapped).unwrap(), &options).unwrap();
    let (turn, apart) = residue(&clip, &back);
    assert!(turn > 10.0 && apart > 0.1, "{turn}°, {apart} m");
}

/// Import against the definition evaluated with matrices, on every real file.
#[test]
fn world_positions_are_those_of_the_definition() {
    for folder in ["bvh-zoo", "mocap/cgspeed", "mocap/bvh"] {
        for path in files(folder) {
            let bvh = Bvh::parse(&std::fs::read(&path).unwrap()).unwrap();
            let options = ImportOptions { t_pose: Some(TPoseRule::Keep), ..Default::default() };
            let (clip, report) = import(&bvh, &options).unwrap();
            let scale = report.units.metres_per_unit;
            for frame in (0..bvh.frames).step_by(1 + bvh.frames / 20) {
                let ours = Kinematics::new(&clip.skeleton, clip.pose(frame));
                for (i, (_, at)) in world(&bvh, bvh.frame(frame)).iter().enumerate() {
                    let at = if report.up.axis == Axis::Z { Vec3::new(at.x, at.z, -at.y) } else { *at };
                    let error = (ours.origin(i) - at * scale).norm();
                    // 2.7e-15 m seen
                    assert!(error < 1e-12, "{} {frame} {i}: {error}", path.display());
                }
            }
        }
    }
}

#[test]
fn angles_written_do_not_jump() {
    for path in files("mocap/bvh") {
        let (clip, _) = read_file(&path, &ImportOptions::default()).unwrap();
        let bvh = parse(&write(&clip, &WriteOptions::default()).unwrap()).unwrap();
        for frame in 1..bvh.frames {
            for (a, b) in bvh.frame(frame - 1).iter().zip(bvh.frame(frame)) {
                assert!((a - b).abs() < 200.0, "{} frame {frame}: {a} to {b}", path.display());
            }
        }
    }
}

/// What the READMEs of the two collections say: metres per unit, up axis, rate.
#[test]
fn guesses_agree_with_the_known_truth() {
    let cmu = 2.54 / 45.0;
    let zoo: [(&str, Option<f64>, Option<Axis>, f64); 15] = [
        ("animateddrawings_cmu1_jumping_jacks", Some(cmu), Some(Axis::Y), 30.0),
        // The drawings' bodies are of 46 and 42 units: about 0.037 m each, which is no unit in use.
        ("animateddrawings_fair1_dab", None, Some(Axis::Z), 30.0),
        ("animateddrawings_fair1_wave_hello", None, Some(Axis::Z), 120000.0 / 1001.0),
        ("animateddrawings_fair1_zombie", None, Some(Axis::Z), 30.0),
        ("animateddrawings_rokoko_jesse_dance", Some(0.01), Some(Axis::Y), 100.0),
        ("bvhtoolbox_walk01", Some(0.01), Some(Axis::Y), 24.0),
        ("fairmotion_pfnn_hierarchy", Some(1.0), Some(Axis::Y), 30.0),
        ("fairmotion_sinusoidal", None, None, 60.0),
        ("pybvh_bvh_example", Some(0.0254), Some(Axis::Z), 30.0),
        ("pybvh_bvh_test2", Some(0.01), Some(Axis::Y), 120.0),
        ("pybvh_bvh_test3", Some(0.0254), Some(Axis::Z), 120.0),
        ("pybvh_full_precision_frame_time", None, None, 23.976),
        ("pybvh_rotation_first_root", None, None, 25.0),
        ("pybvh_standard_skeleton", Some(0.0254), Some(Axis::Z), 120.0),
        ("pymo_AV_8Walk", Some(0.0254), Some(Axis::Y), 120.0),
    ];
    for (name, units, up, rate_hz) in zoo {
        let (clip, report) = load(&format!("bvh-zoo/{name}.bvh"));
        println!("{name}\n{report}\n");
        assert_eq!(clip.rate_hz, rate_hz, "{name}");
        assert_eq!(report.t_pose, None, "{name}");
        match units {
            Some(units) => {
                assert!((report.units.metres_per_unit / units - 1.0).abs() < 1e-12, "{name}: {report}");
                assert_eq!(report.units.chosen, Chosen::Guessed, "{name}");
            }
            None => assert_eq!(report.units.chosen, Chosen::Unsure, "{name}"),
        }
        match up {
            Some(axis) => assert_eq!((report.up.axis, report.up.chosen), (axis, Chosen::Guessed), "{name}"),
            None => assert_eq!(report.up.chosen, Chosen::Unsure, "{name}"),
        }
    }
    for path in files("mocap/bvh").into_iter().chain(files("mocap/cgspeed")) {
        let (clip, report) = read_file(&path, &ImportOptions::default()).unwrap();
        let units = if path.ends_with("60_10_daz.bvh") { 0.01 } else { cmu };
        assert_eq!(report.units.metres_per_unit, units, "{}: {report}", path.display());
        assert_eq!(
            (report.up.axis, report.up.chosen),
            (Axis::Y, Chosen::Guessed),
            "{}: {report}",
            path.display()
        );
        assert_eq!(clip.rate_hz, 120.0);
    }
}

/// The standing figures of Z-up files stand along Y afterwards, in their zero pose too.
#[test]
fn z_up_becomes_y_up() {
    for name in
        ["animateddrawings_fair1_zombie", "pybvh_bvh_example", "pybvh_bvh_test3", "pybvh_standard_skeleton"]
    {
        let (clip, _) = load(&format!("bvh-zoo/{name}.bvh"));
        let skeleton = &clip.skeleton;
        let (head, foot) = (skeleton.link("Head").unwrap(), skeleton.link("LeftFoot").unwrap());
        let zero = skeleton.zero_pose();
        for q in [clip.pose(0), clip.pose(clip.frames() / 2), &zero[..]] {
            let k = Kinematics::new(skeleton, q);
            let up = (k.origin(head) - k.origin(foot)).normalize();
            assert!(up.y > 0.9, "{name}: {up}");
        }
    }
}

/// A T-pose that no motion could leave is dropped unasked; what the caller says holds.
#[test]
fn an_inserted_t_pose_is_dropped_unless_it_is_to_stay() {
    let read = |path: &Path, t_pose| {
        read_file(path, &ImportOptions { t_pose, ..Default::default() }).unwrap_or_else(|e| panic!("{e}"))
    };
    for path in files("mocap/cgspeed") {
        let (usual, report) = read(&path, None);
        let found = report.t_pose.unwrap();
        println!("{}: {found:?}", path.display());
        assert!(found.found && found.dropped == (found.jump > 20.0), "{}", path.display());
        let (kept, report) = read(&path, Some(TPoseRule::Keep));
        assert!(!report.t_pose.unwrap().dropped);
        let (dropped, report) = read(&path, Some(TPoseRule::Drop));
        assert!(report.t_pose.unwrap().dropped, "{}", path.display());
        assert_eq!(dropped.frames() + 1, kept.frames());
        assert_eq!(usual, if found.dropped { dropped.clone() } else { kept.clone() });
        let (a, b) = (dropped.pose(0), kept.pose(1)); // equal but for the signs of quaternions
        assert!(a.iter().zip(b).all(|(a, b)| a.abs() == b.abs()), "{}", path.display());
        assert!(report.to_string().contains("first frame: an inserted T-pose, dropped"));
    }
    for path in files("mocap/bvh") {
        let (clip, report) = read(&path, None);
        assert_eq!(report.t_pose, None, "{}", path.display());
        let (dropped, report) = read(&path, Some(TPoseRule::Drop));
        assert_eq!(dropped.frames() + 1, clip.frames());
        assert!(report.to_string().contains("first frame: no inserted T-pose, dropped as stated"));
    }
}

#[test]
fn a_statement_overrules_a_guess_and_is_reported() {
    let options = ImportOptions { metres_per_unit: Some(0.1), up: Some(Axis::Z), ..Default::default() };
    let (_, report) = read_file(&shared("mocap/bvh/02_01.bvh"), &options).unwrap();
    let text = report.to_string();
    assert_eq!(
        text,
        "units: 0.1 m (stated: the skeleton is 2.85 m tall)\nup: Z (stated)\nrate: 120 Hz (frame time 0.0083333 s, 120.0005 Hz, within the rounding of its digits)"
    );
    let (_, report) = load("mocap/bvh/02_01.bvh");
    let text = report.to_string();
    assert!(text.starts_with("units: 0.0564444 m (guessed: the skeleton is 1.6"), "{text}");
    assert!(text.contains("\nup: Y (guessed from the mean direction from feet to head, "), "{text}");
}

/// Verdict on each synthetic file: accepted with these values, or refused with these words.
#[test]
fn synthetic_files_have_the_stated_verdict() {
    let row = |s: f64| [0.1 * s, 10.0, 0.2 * s, 1.0 + 0.5 * s, 2.0 + 0.5 * s, 3.0 + 0.5 * s];
    let usual: Vec<f64> = [0.0, 1.0]
        .iter()
        .flat_map(|&s| row(s).into_iter().chain([4.0 + 0.5 * s, 5.0 + 0.5 * s, 6.0 + 0.5 * s]))
        .collect();
    let six = vec![
        0.0, 10.0, 0.0, 1.0, 2.0, 3.0, 0.0, 5.5, 0.0, 4.0, 5.0, 6.0, 0.1, 10.0, 0.2, 1.5, 2.5, 3.5, 0.2, 5.5,
        0.0, 4.5, 5.5, 6.5,
    ];
    let zero_channels: Vec<f64> = [row(0.0), row(1.0)].concat();
    let verdicts: [(&str, Result<&[f64], &str>); 20] = [
        ("bom_crlf", Ok(&usual)),
        (
            "count_too_high",
            Err(
                "5 frames of 9 values are stated, the file ends after 18 values (found 2 whole frames)\n  --> 21:1",
            ),
        ),
        (
            "count_too_low",
            Err("1 frames of 9 values are stated, more values follow (found 2 whole frames)\n  --> 20:1"),
        ),
        ("exponents_and_plus", Ok(&usual)),
        ("extra_whitespace", Ok(&usual)),
        ("frame_wrapped_lines", Ok(&usual)),
        ("lowercase_keywords", Ok(&usual)),
        (
            "missing_space_between_values",
            Err(
                "`0.0-1.0` is not a number; numbers are decimal and white space stands between them\n  --> 19:10",
            ),
        ),
        ("name_with_spaces_and_colon", Ok(&usual)),
        ("nan_and_inf", Err("`NaN` is not a finite number\n  --> 19:26")),
        ("no_final_newline", Ok(&usual)),
        ("no_motion_section", Err("found the end of the file, expected `MOTION`\n  --> 16:1")),
        ("old_mac_cr_only", Ok(&usual)),
        ("one_line", Ok(&usual)),
        ("six_channel_joints", Ok(&six)),
        (
            "two_roots",
            Err(
                "second root `Prop`; a file holds one ROOT: split this one into one file per tree\n  --> 16:1",
            ),
        ),
        (
            "unbalanced_braces",
            Err("found `MOTION`, expected `OFFSET`, `CHANNELS`, `JOINT`, `End Site` or `}`\n  --> 15:1"),
        ),
        ("zero_channel_joint", Ok(&zero_channels)),
        ("zero_frame_time", Err("Frame Time: `0` s; expected a number from 1e-6 to 1e6\n  --> 18:13")),
        ("zero_frames", Ok(&[])),
    ];
    assert_eq!(verdicts.len(), files("bvh-zoo/synthetic").len());
    for (name, verdict) in verdicts {
        let found = Bvh::parse(&bytes(&format!("bvh-zoo/synthetic/{name}.bvh")));
        match (found, verdict) {
            (Ok(bvh), Ok(values)) => {
                let error = bvh.motion.iter().zip(values).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert_eq!(bvh.motion.len(), values.len(), "{name}");
                assert!(error < 1e-15, "{name}: {error}");
                assert_eq!(bvh.joints.len(), 2, "{name}");
                assert_eq!(bvh.joints[1].ends, [[0.0, 4.0, 0.0]], "{name}");
                assert_eq!(bvh.frame_time_s, 0.0333333, "{name}");
            }
            (Err(error), Err(words)) => assert_eq!(error.to_string(), words, "{name}"),
            (found, _) => panic!("{name}: {found:?}"),
        }
    }
    let name = Bvh::parse(&bytes("bvh-zoo/synthetic/name_with_spaces_and_colon.bvh")).unwrap().joints[1]
        .name
        .clone();
    assert_eq!(name, "mixamorig:Upper Chest");
}

#[test]
fn channels_decide_the_joint() {
    let (clip, report) = load("bvh-zoo/synthetic/six_channel_joints.bvh");
    assert_eq!(clip.skeleton.links()[1].joint, Joint::Free, "{report}");
    let (clip, _) = load("bvh-zoo/synthetic/zero_channel_joint.bvh");
    assert_eq!(clip.skeleton.links()[1].joint, Joint::Fixed);
    let text = "HIERARCHY ROOT a { OFFSET 0 1 0 CHANNELS 1 Yrotation
        JOINT hinge { OFFSET 0 0 2 CHANNELS 1 Xrotation }
        JOINT slide { OFFSET 0 0 2 CHANNELS 1 Zposition }
        JOINT ball { OFFSET 0 0 2 CHANNELS 2 Zrotation Xrotation }
        JOINT still { OFFSET 1 1 1 CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation }
        JOINT hinge { OFFSET 9 0 0 CHANNELS 0 } }
        MOTION Frames: 2 Frame Time: 0.0125
        0  10 5  20 30  4 5 6 0 0 0
        90 20 6  20 30  4 5 6 0 0 0";
    let options = ImportOptions { metres_per_unit: Some(1.0), up: Some(Axis::Y), ..Default::default() };
    let (clip, report) = import(&parse(text).unwrap(), &options).unwrap();
    let kinds: Vec<Joint> = clip.skeleton.links().iter().map(|l| l.joint).collect();
    use Joint::*;
    assert_eq!(kinds, [Free, Revolute(Vec3::x()), Prismatic(Vec3::z()), Spherical, Spherical, Fixed]);
    assert_eq!(clip.skeleton.links()[5].name, "hinge_2");
    assert_eq!(clip.rate_hz, 80.0);
    let k = Kinematics::new(&clip.skeleton, clip.pose(1)); // root turned by 90° about Y: z → x
    assert!((k.origin(2) - Vec3::new(6.0, 1.0, 0.0)).norm() < 1e-14);
    assert!((k.origin(4) - Vec3::new(6.0, 6.0, -4.0)).norm() < 1e-14);
    let text = report.to_string();
    assert!(text.contains("positions that do not move are taken as offsets: 1 joints (still)"), "{text}");
    assert!(text.contains("names used twice: `hinge` is now `hinge_2`"), "{text}");
}

/// A skeleton with every joint kind, turned zero frames and a root that is no `Free`.
fn odd_clip() -> Clip {
    let turned = |parent: usize, offset: [f64; 3], turn: [f64; 3], joint: Joint, name: &str| {
        let mut link = Link::new(name, Some(parent), Vec3::zeros(), joint);
        link.parent_from_zero =
            Transform::from_parts(Translation3::from(Vec3::from(offset)), exp(&Vec3::from(turn)));
        link.end = Some(Vec3::new(0.1, 0.2, -0.05));
        link
    };
    let axis = Vec3::new(1.0, 2.0, -0.5).normalize();
    let mut root = turned(0, [0.3, 0.9, -0.2], [0.4, -0.3, 0.8], Joint::Revolute(axis), "root");
    root.parent = None;
    let links = vec![
        root,
        turned(0, [0.0, 0.5, 0.1], [1.0, 0.2, -0.4], Joint::Spherical, "ball"),
        turned(0, [0.2, 0.0, 0.1], [-0.3, 0.9, 0.1], Joint::Free, "free"),
        turned(1, [0.1, 0.4, 0.0], [0.2, 0.2, 2.0], Joint::Prismatic(axis), "slide"),
        turned(3, [0.0, 0.3, 0.2], [0.5, -1.2, 0.3], Joint::Fixed, "weld"),
        turned(4, [0.1, 0.1, 0.1], [0.0, 0.7, 0.0], Joint::Revolute(Vec3::z()), "hinge"),
        // depth first comes after its elder sister's children
        turned(2, [0.1, -0.1, 0.1], [0.1, 0.0, 0.2], Joint::Spherical, "tail"),
    ];
    let skeleton = Arc::new(Skeleton::new(links).unwrap());
    let mut q = Vec::new();
    for frame in 0..40 {
        let t = f64::from(frame) * 0.17;
        let mut pose = skeleton.zero_pose();
        for (i, link) in skeleton.links().iter().enumerate() {
            let at = skeleton.q_at(i);
            let turn = exp(&Vec3::new(t.sin(), 0.5 * t, (0.7 * t).cos()));
            match link.joint {
                Joint::Free => {
                    skeleton.set_position(&mut pose, i, &Vec3::new(t.sin(), 0.1 * t, 0.3));
                    skeleton.set_rotation(&mut pose, i, &turn);
                }
                Joint::Spherical => skeleton.set_rotation(&mut pose, i, &turn),
                Joint::Revolute(_) | Joint::Prismatic(_) => pose[at] = (t + i as f64).sin(),
                Joint::Fixed => {}
            }
        }
        q.extend(pose);
    }
    Clip::new(skeleton, 59.5, q)
}

#[test]
fn turned_zero_frames_keep_the_world() {
    let clip = odd_clip();
    let text =
        write(&clip, &WriteOptions { decimals: 12, metres_per_unit: 1.0, ..Default::default() }).unwrap();
    let options = ImportOptions { metres_per_unit: Some(1.0), up: Some(Axis::Y), ..Default::default() };
    let (back, _) = import(&parse(&text).unwrap(), &options).unwrap();
    assert_eq!(back.rate_hz, 59.5);
    // The constant that BVH cannot hold: the link's world rotation in the zero pose.
    let zero = Kinematics::new(&clip.skeleton, &clip.skeleton.zero_pose());
    let mut worst = 0.0f64;
    for frame in 0..clip.frames() {
        let a = Kinematics::new(&clip.skeleton, clip.pose(frame));
        let b = Kinematics::new(&back.skeleton, back.pose(frame));
        for (i, link) in clip.skeleton.links().iter().enumerate() {
            let j = back.skeleton.link(&link.name).unwrap();
            let expected: Quat = a.world[i].rotation * zero.world[i].rotation.inverse();
            worst = worst.max(log(&(expected * b.world[j].rotation.inverse())).norm());
            worst = worst.max((a.origin(i) - b.origin(j)).norm());
            let (end_a, end_b) = (link.end.unwrap(), back.skeleton.links()[j].end.unwrap());
            worst = worst.max((a.point(i, &end_a) - b.point(j, &end_b)).norm());
        }
    }
    assert!(worst < 1e-11, "{worst}"); // m or rad; 1.5e-12 seen, the text's twelve decimals
}

#[test]
fn bad_options_and_values_are_refused() {
    let clip = odd_clip();
    let options = WriteOptions { metres_per_unit: 0.0, ..Default::default() };
    assert_eq!(write(&clip, &options), Err(WriteError::Units(0.0)));
    let options = WriteOptions { order: EulerOrder([0, 1, 0]), ..Default::default() };
    assert_eq!(write(&clip, &options), Err(WriteError::Order([0, 1, 0])));
    let mut broken = clip.clone();
    broken.pose_mut(3)[0] = f64::NAN;
    let error = write(&broken, &WriteOptions::default()).unwrap_err();
    assert_eq!(error.to_string(), "frame 3 of `root` is not finite");

    let bvh = Bvh::parse(&bytes("bvh-zoo/synthetic/zero_frames.bvh")).unwrap();
    assert_eq!(import(&bvh, &ImportOptions::default()).unwrap_err(), ImportError::NoFrames);
    let bvh = Bvh::parse(&bytes("bvh-zoo/synthetic/one_line.bvh")).unwrap();
    let options = ImportOptions { metres_per_unit: Some(f64::NAN), ..Default::default() };
    assert!(matches!(import(&bvh, &options), Err(ImportError::Units(_))));
}

const HEAD: &str = "HIERARCHY\nROOT a\n{\n OFFSET 0 0 0\n CHANNELS 1 Xrotation\n}\n";

#[test]
fn bad_text_is_refused_with_its_place() {
    let cases = [
        ("", "the file is empty; a BVH file starts with `HIERARCHY`\n  --> 1:1".to_owned()),
        (" \r\n\r\n", "the file is empty; a BVH file starts with `HIERARCHY`\n  --> 3:1".into()),
        ("{\"asset\": 1}", "found `{`, expected `HIERARCHY`\n  --> 1:1".into()),
        ("HIERARCHY\nROOT\n{", "`ROOT` has no name; a name follows it on the same line\n  --> 2:5".into()),
        (
            "HIERARCHY\nROOT a\n{\n OFFSET 0 0\n}",
            "`}` is not a number; numbers are decimal and white space stands between them\n  --> 5:1".into(),
        ),
        ("HIERARCHY\nROOT é{OFFSET 0 0 0 JOINT é{ x", "found `x`, expected `OFFSET`\n  --> 2:30".into()),
        ("HIERARCHY\nROOT a\n{\n OFFSET 0 0 0\n CHANNELS 9", "CHANNELS `9`; a joint has 0 to 6\n  --> 5:11".into()),
        (
            "HIERARCHY\nROOT a\n{\n OFFSET 0 0 0\n CHANNELS 1 Wrotation",
            "unknown channel `Wrotation`; allowed are Xposition Yposition Zposition Xrotation Yrotation Zrotation\n  --> 5:13"
                .into(),
        ),
        (
            "HIERARCHY ROOT a { OFFSET 0 0 0 } MOTION Frames: 9999999999999 Frame Time: 1",
            "no joint has a channel, so there is nothing to read from the frames\n  --> 1:35".into(),
        ),
        (
            &format!("{HEAD}MOTION\nFrames: 99999999999\nFrame Time: 0.01\n1\n2 3\n4"),
            "99999999999 frames of 1 values are stated, the file ends after 4 values (found 4 whole frames; line 11 has 2 values)\n  --> 12:2"
                .into(),
        ),
        (
            &format!("{HEAD}MOTION\nFrames: 99999999999999999999999\nFrame Time: 0.01\n1\n"),
            "Frames: `99999999999999999999999`; expected a whole number, 0 or more\n  --> 8:9".into(),
        ),
        (
            &format!("{HEAD}MOTION\nFrames: -1\nFrame Time: 0.01\n1\n"),
            "Frames: `-1`; expected a whole number, 0 or more\n  --> 8:9".into(),
        ),
        (
            &format!("{HEAD}MOTION\nFrames: 1\nFrame Time: nan\n1\n"),
            "Frame Time: `nan` s; expected a number from 1e-6 to 1e6\n  --> 9:13".into(),
        ),
        (
            &format!("{HEAD}MOTION\nFrames: 1\nFrame Time: 0.01\n1e999\n"),
            "`1e999` is not a finite number\n  --> 10:1".into(),
        ),
        (
            &format!("{HEAD}MOTION\nFrames: 1\nFrame Time: 0.01\n-2e12\n"),
            "`-2e12` is too large a number; allowed: up to 1e12 either way\n  --> 10:1".into(),
        ),
        (
            &format!("{HEAD}MOTION\nFrames: 1\nFrame Time: 0.01\n0,5\n"),
            "`0,5` is not a number; numbers are decimal and white space stands between them\n  --> 10:1".into(),
        ),
    ];
    for (text, words) in cases {
        assert_eq!(parse(text).unwrap_err(), words, "{text}");
    }
}

#[test]
fn file_errors_name_the_path() {
    let options = ImportOptions::default();
    let error = read_file(Path::new("no/such.bvh"), &options).unwrap_err().to_string();
    assert!(error.starts_with("cannot read no/such.bvh: "), "{error}");
    let path = shared("bvh-zoo/synthetic/nan_and_inf.bvh");
    let error = read_file(&path, &options).unwrap_err().to_string();
    assert_eq!(error, format!("`NaN` is not a finite number\n  --> {}:19:26", path.display()));

    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("out.bvh");
    write_file(&file, &odd_clip(), &WriteOptions::default()).unwrap();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1); // nothing temporary stays
    assert_eq!(read_file(&file, &options).unwrap().0.frames(), 40);
    let missing = folder.path().join("none/out.bvh");
    let error = write_file(&missing, &odd_clip(), &WriteOptions::default()).unwrap_err().to_string();
    assert!(error.contains("cannot write") && error.contains("out.bvh"), "{error}");
}

#[test]
fn deep_nesting_costs_no_stack() {
    let depth = 20_000;
    let mut text = String::from("HIERARCHY ROOT r { OFFSET 0 1 0 CHANNELS 1 Xrotation ");
    for i in 0..depth {
        text += &format!("JOINT j{i} {{ OFFSET 0 1 0 ");
    }
    text += &"}".repeat(depth + 1);
    text += " MOTION Frames: 1 Frame Time: 1 0";
    let (clip, _) = import(&parse(&text).unwrap(), &ImportOptions::default()).unwrap();
    assert_eq!(clip.skeleton.links().len(), depth + 1);
    assert!(write(&clip, &WriteOptions::default()).unwrap().len() > depth);
}

fn mutate(mut text: Vec<u8>, edits: &[(u8, u16, u8)]) -> Vec<u8> {
    const PIECES: [&str; 12] = [
        "{",
        "}",
        "JOINT",
        "End Site",
        "-",
        "1e308",
        "99999999999",
        "CHANNELS 6",
        "Frames:",
        "\r",
        "nan",
        ".5",
    ];
    for &(kind, at, value) in edits {
        let at = at as usize % text.len().max(1);
        match kind % 5 {
            0 if at < text.len() => text[at] = value,
            1 if at < text.len() => {
                text.remove(at);
            }
            2 => text.truncate(at),
            3 => drop(text.splice(at..at, PIECES[value as usize % PIECES.len()].bytes())),
            _ => {
                let end = (at + value as usize).min(text.len());
                let copy = text[at.min(end)..end].to_vec();
                drop(text.splice(at.min(end)..at.min(end), copy));
            }
        }
    }
    text
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Any bytes are read or refused; what is read is imported or refused, and then written.
    #[test]
    fn no_bytes_panic(which in 0usize..20, edits in prop::collection::vec(any::<(u8, u16, u8)>(), 1..8)) {
        let path = &files("bvh-zoo/synthetic")[which];
        let text = mutate(std::fs::read(path).unwrap(), &edits);
        match Bvh::parse(&text) {
            Ok(bvh) => {
                prop_assert_eq!(bvh.motion.len(), bvh.frames * bvh.channels);
                prop_assert!(bvh.motion.iter().all(|v| v.is_finite()));
                for up in [None, Some(Axis::Z)] {
                    let options = ImportOptions { up, t_pose: Some(TPoseRule::Drop), ..Default::default() };
                    if let Ok((clip, report)) = import(&bvh, &options) {
                        prop_assert!(clip.data().iter().all(|v| v.is_finite()));
                        prop_assert!(!report.to_string().is_empty());
                        let _ = write(&clip, &WriteOptions::default());
                    }
                }
            }
            Err(error) => {
                prop_assert!(error.line >= 1 && error.column >= 1);
                prop_assert!(error.to_string().len() < 400);
            }
        }
    }

    #[test]
    fn no_random_bytes_panic(text in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = Bvh::parse(&text);
    }
}
