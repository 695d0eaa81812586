//! Characters, performances and key poses: what ships holds what it promises, and every fault is named at its
//! place.

use std::sync::Arc;

use formats::bvh::ImportOptions;
use motion::{Joint, Kinematics, Skeleton};
use retarget::Puppet;
use support::scene;
use takes::retargeting::{self, Actor, KeyPoseFile, Performance};
use takes::{Ask, Take, open};

const CHARACTERS: [(&str, usize); 3] = [("lamp", 30), ("penguin", 33), ("squirrel", 50)];
const PERFORMANCES: [&str; 8] =
    ["anger", "disgust", "fear", "happiness", "sadness", "surprise", "dance", "walk"];

fn actor(name: &str) -> Actor {
    Actor::open(&scene(&format!("characters/{name}.ron"))).unwrap()
}

fn performance(name: &str) -> Take {
    open(scene(&format!("performances/{name}.ron")), &Ask::default()).unwrap()
}

/// Every character stands on its contact points, within its limits, and each point has a counterpart.
#[test]
fn characters_stand_at_rest() {
    for (name, _) in CHARACTERS {
        let c = actor(name).file.character;
        let k = Kinematics::new(&c.skeleton, &c.rest);
        let heights: Vec<f64> =
            (c.contacts.iter()).map(|&s| &c.skeleton.sites()[s]).map(|s| k.point(s.link, &s.at).y).collect();
        let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(lowest.abs() < 1e-3, "{name}: {lowest}"); // m; 3e-7 seen
        let mut q = c.rest.clone();
        c.skeleton.clamp_to_limits(&mut q);
        let off = q.iter().zip(&c.rest).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9, "{name}: {off}");
        let followed = actor(name).puppet.contacts.len();
        assert_eq!(followed, c.contacts.len(), "{name}");
    }
}

/// Mass follows from density: half of it is half of the mass, the centre stays.
#[test]
fn mass_is_density_times_volume() {
    let text = std::fs::read_to_string(scene("characters/lamp.ron")).unwrap();
    let parse = |text: &str| {
        scenes::character_file::parse(&scenes::Source::new("lamp.ron", text.to_owned())).unwrap()
    };
    let whole = parse(&text);
    let lead = parse(&text.replace("density_kg_m3: 2500", "density_kg_m3: 1250"));
    let base = whole.skeleton.link("base").unwrap();
    // a cone cut off: π h (R² + R r + r²)/3
    let volume = std::f64::consts::PI * 0.026 * (0.105f64.powi(2) + 0.105 * 0.09 + 0.09f64.powi(2)) / 3.0;
    assert!((whole.bodies[base].mass - 2500.0 * volume).abs() < 1e-12);
    assert!((lead.bodies[base].mass - 1250.0 * volume).abs() < 1e-12);
    assert_eq!(whole.bodies[base].com, lead.bodies[base].com);
}

/// Performances last 7 to 20 s, feet that stand do not slide, and no joint is bent beyond its limits.
#[test]
fn performances_are_whole() {
    for name in PERFORMANCES {
        let take = performance(name);
        let seconds = take.asked.clip.duration_s();
        assert!((7.0..=20.0).contains(&seconds), "{name}: {seconds} s");
        assert!(take.asked.clamped < 0.02, "{name}: {}", take.asked.clamped);
        let feet = takes::Report::of(&take, None, &[]).kinematic.feet.unwrap();
        assert!(feet.slip_mm_max < 8.0, "{name}: {} mm", feet.slip_mm_max); // 5.8 mm seen, at lift-off
        assert!(feet.penetration_mm_max < 1.0, "{name}: {} mm", feet.penetration_mm_max);
    }
}

/// The dance leaves the ground, and falls as things fall: with g to 1 % of it.
#[test]
fn the_dance_jumps() {
    let take = performance("dance");
    let body = &take.body.character;
    let height = |f: usize| {
        let k = Kinematics::new(&body.skeleton, take.asked.clip.pose(f));
        let sites = body.contacts.iter().map(|&c| &body.skeleton.sites()[c]);
        sites.map(|s| k.point(s.link, &s.at).y).fold(f64::INFINITY, f64::min)
    };
    let highest = (0..take.asked.clip.frames()).map(height).fold(0.0, f64::max);
    assert!(highest > 0.2, "{highest}"); // m; 0.30 seen
}

/// Angle between two poses: RMS over all joints but the root's place, degrees.
fn apart_deg(s: &Skeleton, a: &[f64], b: &[f64]) -> f64 {
    let joints = s.links().iter().enumerate().filter(|(_, l)| l.joint != Joint::Fixed);
    let angles: Vec<f64> = joints
        .map(|(i, l)| match l.joint {
            Joint::Free | Joint::Spherical => s.rotation(a, i).angle_to(&s.rotation(b, i)),
            _ => (a[s.q_at(i)] - b[s.q_at(i)]).abs(),
        })
        .map(f64::to_degrees)
        .collect();
    (angles.iter().map(|x| x * x).sum::<f64>() / angles.len() as f64).sqrt()
}

/// As many pairs as the paper's Table 1 has at least, of all performances, no two of them alike.
#[test]
fn key_poses_are_many_and_different() {
    for (name, least) in CHARACTERS {
        let actor = actor(name);
        let file = KeyPoseFile::open(&actor.key_poses_beside(), &actor.puppet).unwrap();
        let pairs = &file.key_poses.pairs;
        assert!(pairs.len() >= least, "{name}: {}", pairs.len());
        for performance in PERFORMANCES {
            assert!(pairs.iter().any(|p| p.group == performance), "{name}: none of {performance}");
        }
        let skeleton = &actor.file.character.skeleton;
        for (i, p) in pairs.iter().enumerate() {
            for o in &pairs[..i] {
                let apart = apart_deg(skeleton, &p.character, &o.character);
                // 15.0° for all three seen at the nearest, to the rounding of written angles
                assert!(apart > 14.9, "{name}: {} and {} are {apart}° apart", p.name, o.name);
            }
        }
    }
}

/// A first guess is a pose within limits, on the ground where the human is, and says so in a line that can be
/// read back.
#[test]
fn guesses_can_be_read_back() {
    let fear = Performance::open(&scene("performances/fear.ron"), &ImportOptions::default()).unwrap();
    for (name, _) in CHARACTERS {
        let actor = actor(name);
        let lines: Vec<String> =
            [1.0, 3.5, 7.5].iter().map(|&t| retargeting::guess(&fear, &actor, t).unwrap()).collect();
        let text = format!(
            "KeyPoses(performances: {{\"fear\": \"{}\"}}, poses: [{}])",
            scene("performances/fear.ron").display(),
            lines.join("\n")
        );
        let file = tempfile::NamedTempFile::with_suffix(".ron").unwrap();
        std::fs::write(file.path(), text).unwrap();
        let read = KeyPoseFile::open(file.path(), &actor.puppet);
        assert_eq!(read.unwrap().key_poses.pairs.len(), 3, "{name}");
    }
}

/// What is said of a file of key poses with this body.
fn fault_in(body: &str, puppet: &Puppet) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("k.ron");
    let performances = scene("performances");
    let text = body.replace("../performances", &performances.display().to_string());
    std::fs::write(&path, text).unwrap();
    let e = KeyPoseFile::open(&path, puppet).unwrap_err().to_string();
    e.replace(&folder.path().display().to_string(), "").replace(&performances.display().to_string(), "P")
}

fn file_of(poses: &str) -> String {
    format!(
        "KeyPoses(\n  performances: {{ \"fear\": \"../performances/fear.ron\" }},\n  poses: [\n{poses}\n  ],\n)\n"
    )
}

#[test]
fn faults_of_key_poses_are_named_at_their_place() {
    let lamp = actor("lamp").puppet;
    let three = "    Pose(of: \"fear\", at_s: 1),\n    Pose(of: \"fear\", at_s: 3),\n    Pose(of: \"fear\", at_s: 7.5),";
    let cases = [
        (
            file_of("    Pose(of: \"fear\", at_s: 1),\n    Pose(of: \"fear\", at_s: 3),"),
            "2 key poses; at least 3 are needed to learn a mapping\n  --> /k.ron:3:10",
        ),
        (
            file_of(&format!("{three}\n    Pose(of: \"fear\", at_s: 3),")),
            "key poses `fear at 3 s` and `fear at 3 s (pose 4)` are the same pair; leave one out\n  --> /k.ron:7:5",
        ),
        (
            file_of(&three.replace("7.5", "75")),
            "`fear` has no frame at 75 s; its 886 frames at 60 Hz run from 0 to 14.750 s\n  --> /k.ron:6:28",
        ),
        (
            file_of(&three.replace("(of: \"fear\", at_s: 3)", "(of: \"feer\", at_s: 3)")),
            "unknown performance `feer` in a key pose; did you mean `fear`?\n  --> /k.ron:5:14",
        ),
        (
            file_of(&three.replace("at_s: 3)", "at_s: 3, set_deg: { \"lover\": 3 })")),
            "unknown joint `lover` in a key pose; did you mean `lower`?\n  --> /k.ron:5:42",
        ),
        (
            file_of(&three.replace("at_s: 3)", "at_s: 3, set_deg: { \"lower\": 120 })")),
            "`lower` at 120.0° is beyond its limits; the nearest allowed is 80.0°\n  --> /k.ron:5:42",
        ),
        (
            file_of(&three.replace("at_s: 3)", "at_s: 3, set_deg: { \"lower\": (1, 2, 3) })")),
            "the value of `lower` does not fit its joint, which takes one angle in degrees\n  --> /k.ron:5:42",
        ),
        (
            file_of(&three.replace("at_s: 3)", "at_s: 3, flight_m: -1)")),
            "flight_m is -1; allowed: 0 to 10 m above the ground\n  --> /k.ron:5:41",
        ),
        (
            file_of(three).replace("fear.ron", "joy.ron"),
            "the performance `P/joy.ron` does not exist\n  --> /k.ron:2:19\n  help: the path is relative to this file",
        ),
    ];
    for (text, said) in cases {
        assert_eq!(fault_in(&text, &lamp), said);
    }
    let other = format!("{three}\n    Pose(of: \"fear\", at_s: 3, set_deg: {{ \"lower\": 40 }}),");
    let said = fault_in(&file_of(&other), &lamp);
    assert!(
        said.starts_with("key poses `fear at 3 s` and `fear at 3 s (pose 4)` have the same human pose but")
            && said.ends_with("--> /k.ron:7:5"),
        "{said}"
    );
}

/// A performance must be a human's; a character must stand on something that follows a human's feet.
#[test]
fn unfit_bodies_are_told() {
    let lamp = actor("lamp");
    let no_contacts = Puppet::new(lamp.file.character.clone(), Vec::new()).unwrap_err().to_string();
    assert!(no_contacts.starts_with("none of the 4 contact points of `lamp` (base_front,"), "{no_contacts}");
    assert!(no_contacts.contains("follows: { \"base_front\": "), "{no_contacts}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lamp-scene.ron");
    let character = scene("characters/lamp.ron");
    std::fs::write(&path, format!("Scene(character: \"{}\")", character.display())).unwrap();
    let e = Performance::open(&path, &ImportOptions::default()).unwrap_err().to_string();
    assert!(e.contains("lamp-scene.ron"), "{e}");
    // the body of one character cannot take the poses of another
    let penguin = Arc::new(actor("penguin"));
    let e = KeyPoseFile::open(&lamp.key_poses_beside(), &penguin.puppet).unwrap_err().to_string();
    assert!(e.starts_with("unknown joint `lower` in a key pose") && e.contains("lamp.ron:"), "{e}");
}
