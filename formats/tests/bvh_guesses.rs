//! What the reader of BVH guesses is right on both sides of its thresholds, is said, and gives way to a statement.
//!
//! Inputs: `../shared/cases/clips` and variants of them made here.

use formats::bvh::{
    Axis, Bvh, Channel, Chosen, ImportOptions, OffsetRule, WriteOptions, import, read_file, write,
};
use motion::{Clip, Joint, Kinematics};
use support::shared;

fn file(name: &str) -> Bvh {
    let path = shared(&format!("cases/clips/{name}.bvh"));
    Bvh::parse(&std::fs::read(&path).unwrap()).unwrap_or_else(|e| panic!("{e}"))
}

/// The clip of six channels for every joint, its offsets trembling `times` as far: 1 is some 0.02 mm.
fn six(times: f64) -> Bvh {
    let mut bvh = file("six_jitter_001cm");
    for joint in bvh.joints.clone().iter().filter(|j| j.parent.is_some()) {
        for (k, channel) in joint.channels.iter().enumerate() {
            let Channel::Position(axis) = *channel else { continue };
            for frame in 0..bvh.frames {
                let value = &mut bvh.motion[frame * bvh.channels + joint.channels_at + k];
                *value = joint.offset[axis] + times * (*value - joint.offset[axis]);
            }
        }
    }
    bvh
}

fn read(bvh: &Bvh) -> (Clip, formats::bvh::ImportReport) {
    import(bvh, &ImportOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// Offsets that tremble are held at their mean, up to 2 cm of a person of 1.70 m; beyond they are slides. Said either way.
#[test]
fn offsets_that_tremble_are_held_and_said() {
    for (times, held) in [(0.1, true), (1.0, true), (50.0, true), (500.0, true), (2000.0, false)] {
        let bvh = six(times);
        let (clip, report) = read(&bvh);
        let text = report.to_string();
        let links = &clip.skeleton.links()[1..];
        let most =
            report.offsets.held.iter().chain(&report.offsets.slides).map(|m| m.by_m).fold(0.0, f64::max);
        println!("× {times}: {text}");
        if held {
            assert!(most <= 0.012 * report.units.height_m(), "{most}");
            assert!(links.iter().all(|l| l.joint == Joint::Spherical), "× {times}: {text}");
            assert!(
                text.contains("joint offsets move by up to") && text.contains("held at their mean"),
                "{text}"
            );
            assert!(report.offsets.slides.is_empty());
        } else {
            let slides = links.iter().filter(|l| l.joint == Joint::Free).count();
            assert!(slides > 0 && slides == report.offsets.slides.len(), "{text}");
            assert!(text.contains("joints slide by up to") && text.contains("cannot be performed"), "{text}");
        }
        // what the caller says holds
        let of = |rule| ImportOptions { offsets: Some(rule), ..Default::default() };
        let (hold, _) = import(&bvh, &of(OffsetRule::Hold)).unwrap();
        assert!(hold.skeleton.links()[1..].iter().all(|l| l.joint == Joint::Spherical));
        let (keep, _) = import(&bvh, &of(OffsetRule::Keep)).unwrap();
        assert!(keep.skeleton.links()[1..].iter().all(|l| l.joint == Joint::Free));
    }
}

/// Held at their mean, points are off by no more than the offsets on their way moved; kept, they are where the file has them.
#[test]
fn holding_moves_points_by_what_the_offsets_moved() {
    let bvh = six(500.0);
    let keep = ImportOptions { offsets: Some(OffsetRule::Keep), ..Default::default() };
    let ((held, report), (kept, _)) = (read(&bvh), import(&bvh, &keep).unwrap());
    for frame in 0..held.frames() {
        let (a, b) = (
            Kinematics::new(&held.skeleton, held.pose(frame)),
            Kinematics::new(&kept.skeleton, kept.pose(frame)),
        );
        for link in 0..held.skeleton.links().len() {
            let mut most = 0.0;
            let mut at = Some(link);
            while let Some(i) = at {
                let name = &held.skeleton.links()[i].name;
                most += report.offsets.held.iter().find(|m| m.joint == *name).map_or(0.0, |m| m.by_m);
                at = held.skeleton.links()[i].parent;
            }
            let apart = (a.origin(link) - b.origin(link)).norm();
            assert!(apart <= most + 1e-9, "{frame} {link}: {apart} of {most}");
        }
    }
}

/// What places the whole body is never held: a pelvis below another root sways by less than 2 cm.
#[test]
fn a_pelvis_below_the_root_is_never_held() {
    let mut bvh = file("extra_root");
    let hips = bvh.joints[1].clone();
    assert_eq!(hips.name, "Hips");
    for frame in 0..bvh.frames {
        bvh.motion[frame * bvh.channels + hips.channels_at] = 0.5 * (0.3 * frame as f64).sin(); // 5 mm
    }
    let (clip, report) = read(&bvh);
    assert_eq!(clip.skeleton.links()[1].joint, Joint::Free, "{report}");
    assert!(report.offsets.held.is_empty() && report.offsets.slides.is_empty(), "{report}");
}

/// Feet that are free of their shins are named, and the rest stays held.
#[test]
fn free_feet_are_named() {
    let (mut bvh, wide) = (six(1.0), six(3000.0));
    let feet: Vec<_> = bvh.joints.iter().filter(|j| j.name.ends_with("Foot")).cloned().collect();
    for foot in &feet {
        for frame in 0..bvh.frames {
            let row = frame * bvh.channels + foot.channels_at;
            bvh.motion[row..row + 3].copy_from_slice(&wide.motion[row..row + 3]);
        }
    }
    let (_, report) = read(&bvh);
    let slides: Vec<&str> = report.offsets.slides.iter().map(|m| m.joint.as_str()).collect();
    assert_eq!(slides, ["LeftFoot", "RightFoot"], "{report}");
    assert_eq!(report.offsets.slides[0].parent, "LeftLeg");
}

/// Frame times that say a plain rate are that rate, and our own low rates come back.
#[test]
fn slow_clips_keep_their_rate() {
    for (name, hz) in [("frame_time_1", 1.0), ("frame_time_0.2", 5.0)] {
        let (clip, report) = read(&file(name));
        assert_eq!(clip.rate_hz, hz, "{name}: {report}");
        let back = Bvh::parse(write(&clip, &WriteOptions::default()).unwrap().as_bytes()).unwrap();
        assert_eq!(read(&back).0.rate_hz, hz);
    }
    let options = ImportOptions { rate_hz: Some(125.0), ..Default::default() };
    let (clip, report) = read_file(&shared("mocap/bvh/02_01.bvh"), &options).unwrap();
    assert_eq!((clip.rate_hz, report.rate.chosen), (125.0, Chosen::Stated));
    for hz in [0.0, -1.0, f64::NAN] {
        let options = ImportOptions { rate_hz: Some(hz), ..Default::default() };
        let e = import(&file("lying"), &options).unwrap_err().to_string();
        assert!(e.contains("frames per second; expected a positive number"), "{e}");
    }
}

/// A joint of one rotation channel that goes round is resampled the short way round.
#[test]
fn one_channel_goes_round_when_resampled() {
    let (clip, report) = read(&file("one_channel_wrap"));
    assert!(report.to_string().contains("`arm` goes round"), "{report}");
    let at = clip.skeleton.q_at(1);
    let twice = clip.resample(2.0 * clip.rate_hz);
    for frame in 1..twice.frames() {
        let step = (twice.pose(frame)[at] - twice.pose(frame - 1)[at]).to_degrees();
        assert!((step - 10.0).abs() < 1e-9, "{frame}: {step}°"); // 1e-13 seen
    }
}

/// Steps of half a turn and less are left alone, and so are values that are continuous already.
#[test]
fn angles_are_unwrapped_only_where_they_go_round() {
    let of = |angles: &[f64]| {
        let rows: String = angles.iter().map(|a| format!("0 {a}\n")).collect();
        let text = format!(
            "HIERARCHY ROOT base {{ OFFSET 0 0 0 CHANNELS 1 Xrotation JOINT arm {{ OFFSET 0 1 0 CHANNELS 1 Yrotation
             End Site {{ OFFSET 1 0 0 }} }} }} MOTION Frames: {} Frame Time: 0.04 {rows}",
            angles.len()
        );
        let (clip, _) = read(&Bvh::parse(text.as_bytes()).unwrap());
        let at = clip.skeleton.q_at(1);
        (0..clip.frames()).map(|f| clip.pose(f)[at].to_degrees().round()).collect::<Vec<_>>()
    };
    assert_eq!(of(&[0.0, 180.0, 0.0]), [0.0, 180.0, 0.0]);
    assert_eq!(of(&[10.0, 179.0, -179.0, -10.0]), [10.0, 179.0, 181.0, 350.0]);
    assert_eq!(of(&[350.0, 10.0, 30.0]), [350.0, 370.0, 390.0]);
    assert_eq!(of(&[0.0, 200.0, 400.0, 600.0]), [0.0, 200.0, 400.0, 600.0]); // 200° a frame, as written
}

/// Someone who lies along Z is not stood upright; someone upside down stays unsure.
#[test]
fn someone_who_lies_stays_lying() {
    let (clip, report) = read(&file("lying"));
    assert_eq!((report.up.axis, report.up.chosen), (Axis::Y, Chosen::Unsure), "{report}");
    let k = Kinematics::new(&clip.skeleton, clip.pose(0));
    let head = clip.skeleton.link("Head").unwrap();
    assert!(k.origin(head).y < 0.3, "{}", k.origin(head));
    let (_, report) = read(&file("upside"));
    assert_eq!(report.up.chosen, Chosen::Unsure, "{report}");
    // the same person lying half a metre higher may as well stand along Z: still unsure
    let mut high = file("lying");
    let y = high.joints[0].channels_at + 1;
    (0..high.frames).for_each(|f| high.motion[f * high.channels + y] += 50.0);
    assert_eq!(read(&high).1.up.chosen, Chosen::Unsure);
}

/// From both sides of its thresholds: a body of 1.25 to 2.15 m makes a unit sure.
#[test]
fn units_are_sure_for_people_only() {
    let scaled = |height: f64| {
        let mut bvh = file("lying");
        let factor = height / read(&bvh).1.units.height_m();
        for joint in &mut bvh.joints {
            joint.offset = joint.offset.map(|x| x * factor);
            joint.ends.iter_mut().for_each(|e| *e = e.map(|x| x * factor));
        }
        read(&bvh).1.units
    };
    for (height, chosen) in
        [(1.24, Chosen::Unsure), (1.26, Chosen::Guessed), (2.14, Chosen::Guessed), (2.16, Chosen::Unsure)]
    {
        let units = scaled(height);
        assert_eq!((units.metres_per_unit, units.chosen), (0.01, chosen), "{units}");
        assert!((units.height_m() - height).abs() < 1e-9);
    }
}

/// The walk 16_16 as a file, its trunk leaned forward by an angle in the zero pose: all that is not a leg is turned.
fn leaned(deg: f64) -> Bvh {
    let path = shared("mocap/bvh/16_16.bvh");
    let mut bvh = Bvh::parse(&std::fs::read(&path).unwrap()).unwrap_or_else(|e| panic!("{e}"));
    let turn = nalgebra::Rotation3::from_axis_angle(&nalgebra::Vector3::x_axis(), deg.to_radians());
    let of_leg: Vec<bool> = (0..bvh.joints.len())
        .map(|mut j| {
            loop {
                if bvh.joints[j].name.ends_with("HipJoint") {
                    return true;
                }
                match bvh.joints[j].parent {
                    Some(parent) => j = parent,
                    None => return false,
                }
            }
        })
        .collect();
    for (joint, leg) in bvh.joints.iter_mut().zip(of_leg) {
        if !leg && joint.parent.is_some() {
            let turned = turn * nalgebra::Vector3::from(joint.offset);
            joint.offset = turned.into();
        }
    }
    bvh
}

/// Left, front and soles are read from a zero pose whose trunk leans by up to 40°; one that leans further is no figure, and neither is
/// a frame of a motion that leans with it.
#[test]
fn a_zero_pose_stands_up_to_its_threshold() {
    let lean = |clip: &Clip| {
        let s = &clip.skeleton;
        let k = Kinematics::new(s, &s.zero_pose());
        let at = |name: &str| k.origin(s.link(name).unwrap());
        let middle = |a: &str, b: &str| (at(a) + at(b)) * 0.5;
        let trunk = middle("LeftArm", "RightArm") - middle("LeftUpLeg", "RightUpLeg");
        trunk.angle(&motion::Vec3::y()).to_degrees()
    };
    let (mut below, mut above) = (0, 0);
    for tenth in 560..660 {
        let deg = 0.1 * f64::from(tenth);
        let found = lean(&read(&leaned(deg)).0);
        // two files within a quarter of a degree of the threshold
        if !(39.75..40.25).contains(&found) || (found < 40.0 && below > 0) || (found > 40.0 && above > 0) {
            continue;
        }
        let (clip, _) = read(&leaned(deg));
        let guessed = bodies::guess_body(&clip.skeleton, &bodies::BodyOptions::default());
        if found < 40.0 {
            below += 1;
            guessed.unwrap_or_else(|e| panic!("{found}°: {e}"));
        } else {
            above += 1;
            let words = guessed.map(|_| ()).unwrap_err().to_string();
            assert!(words.contains("the trunk of the zero pose leans 40° (at most 40°)"), "{words}");
            // the motion leans as well: no frame of it stands either
            let clip = bodies::guess_body_of_clip(&clip, &bodies::BodyOptions::default());
            let words = clip.map(|_| ()).unwrap_err().to_string();
            assert!(words.contains("the trunk of the straightest frame leans"), "{words}");
        }
    }
    assert_eq!((below, above), (1, 1));
}

/// A sole reaches to where the rig's toes end, if that is 0.09 to 0.115 statures ahead of the ankle, and to that end of the range
/// otherwise: toes of any length give a sole that a person could have.
#[test]
fn soles_reach_to_the_toes_of_a_person() {
    let path = shared("mocap/bvh/16_16.bvh");
    let mut reaches = Vec::new();
    for times in [0.2, 0.9, 1.0, 1.05, 3.0] {
        let mut bvh = Bvh::parse(&std::fs::read(&path).unwrap()).unwrap_or_else(|e| panic!("{e}"));
        for joint in bvh.joints.iter_mut().filter(|j| j.name.contains("ToeBase")) {
            joint.offset = joint.offset.map(|x| times * x);
        }
        let (clip, _) = read(&bvh);
        let (body, _) = bodies::guess_body(&clip.skeleton, &bodies::BodyOptions::default()).unwrap();
        let k = Kinematics::new(&body.skeleton, &body.rest);
        let point = |site: &str| {
            let s = body.skeleton.site(site).unwrap();
            k.point(s.link, &s.at)
        };
        let ankle = k.origin(body.skeleton.link("LeftFoot").unwrap());
        let ball = (point("ball_l_in") + point("ball_l_out")) * 0.5;
        reaches.push((ball - ankle).xz().norm());
    }
    println!("soles reach {reaches:.4?} m ahead of the ankles");
    assert!(reaches.is_sorted(), "{reaches:?}");
    // the ends of the range are the same for toes that hardly exist and for those three times as long
    let (least, most) = (reaches[0], reaches[4]);
    assert!((most / least - 0.115 / 0.09).abs() < 0.02, "{reaches:?}");
    assert!(reaches[2] > least && reaches[2] < most, "{reaches:?}");
}
