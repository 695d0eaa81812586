//! Our rigid-body dynamics against MuJoCo's, and that the comparison can fail.
//!
//! MuJoCo's Python environment is made on the first run. Worst relative residues seen over 1,000 states per
//! model: inverse dynamics 6e-15, bias 1.3e-14, mass matrix 2.7e-15, angular momentum 4e-13.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bodies::{Body, Character, JointClass};
use crosscheck::{CrossCheck, Injection, Options, run};
use motion::rotation::exp;
use motion::{Joint, Link, Skeleton, Vec3};
use nalgebra::Matrix3;

fn shared(name: &str) -> PathBuf {
    support::shared(&format!("models/{name}"))
}

fn human() -> PathBuf {
    support::scene("characters/human.ron")
}

fn check(path: &Path, options: &Options) -> CrossCheck {
    run(path, options, &mut |_| {}).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn failed(cross: &CrossCheck) -> Vec<&str> {
    cross.checks.iter().filter(|c| !c.pass).map(|c| c.quantity.as_str()).collect()
}

fn agrees(path: &Path, options: &Options) {
    let cross = check(path, options);
    assert_eq!(failed(&cross), [""; 0], "{}", crosscheck::report::text(&cross));
    assert_eq!(cross.checks.len(), 13);
}

/// Every model of the zoo, read by us and by MuJoCo apart, and our own human through MJCF of our writing.
#[test]
fn slow_models_agree_to_rounding() {
    let zoo = ["humanoid", "humanoid_CMU", "quadruped", "walker", "manipulator"];
    let options = Options { dynamics_only: true, ..Options::default() };
    for name in zoo {
        agrees(&shared(&format!("dm_control/{name}.xml")), &options);
    }
    agrees(&shared("pinocchio/simple_humanoid.urdf"), &options);
    agrees(&human(), &options);
}

/// A chain welded to the world, turned everywhere, with two joints between two bodies.
fn chain() -> Character {
    let turned = |name: &str, parent: Option<usize>, at: [f64; 3], turn: [f64; 3], joint| {
        let mut link = Link::new(name, parent, Vec3::from(at), joint);
        link.parent_from_zero.rotation = exp(&Vec3::from(turn));
        link
    };
    let links = vec![
        turned("base", None, [0.1, 1.2, -0.3], [0.2, -0.4, 0.3], Joint::Fixed),
        turned("ball", Some(0), [0.0, -0.1, 0.05], [0.5, 0.1, -0.2], Joint::Spherical),
        turned(
            "first",
            Some(1),
            [0.1, -0.3, 0.0],
            [-0.3, 0.2, 0.6],
            Joint::Revolute(Vec3::new(0.6, 0.0, 0.8)),
        ),
        turned(
            "second",
            Some(2),
            [0.02, 0.03, -0.01],
            [0.1, 0.7, -0.4],
            Joint::Prismatic(Vec3::new(0.0, 0.8, 0.6)),
        ),
        turned("end", Some(3), [0.0, -0.25, 0.1], [0.4, -0.1, 0.2], Joint::Fixed),
    ];
    let body = |mass: f64, com: [f64; 3]| Body {
        mass,
        com: Vec3::from(com),
        inertia: Matrix3::new(0.03, 0.004, -0.002, 0.004, 0.02, 0.003, -0.002, 0.003, 0.025) * mass,
        shapes: vec![],
    };
    let skeleton = Arc::new(Skeleton::new(links).unwrap());
    Character {
        name: "chain".into(),
        bodies: vec![
            body(1.0, [0.0, 0.05, 0.0]),
            body(2.0, [0.03, -0.12, 0.01]),
            Body { mass: 0.0, inertia: Matrix3::zeros(), ..body(1.0, [0.0; 3]) },
            body(1.5, [0.01, -0.1, 0.04]),
            body(0.7, [-0.02, -0.06, 0.03]),
        ],
        classes: vec![JointClass::Other; 5],
        contacts: vec![],
        rest: skeleton.zero_pose(),
        skeleton,
    }
    .check()
    .unwrap()
}

/// A fixed chain of our own, as a character file.
#[test]
fn a_fixed_chain_agrees_to_rounding() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("chain.ron");
    std::fs::write(&path, scenes::character_file::write(&chain(), "a chain")).unwrap();
    agrees(&path, &Options::default());
}

/// Each fault put into our side is found, and the quantity that shows it is named with its place.
#[test]
fn slow_faults_are_found_and_named() {
    let faults = [
        ("mass:right_lower_arm*1.01", "masses", "`right_lower_arm`"),
        ("com:right_shin+0,0,0.001", "centres of mass of the bodies", "`right_shin`"),
        ("axis:right_shin=0,0,1", "axes of the joints", "`right_shin`"),
    ];
    let path = shared("dm_control/humanoid.xml");
    for (fault, quantity, place) in faults {
        let inject: Vec<Injection> = vec![fault.parse().unwrap()];
        let options = Options { dynamics_only: true, states: 20, inject, ..Options::default() };
        let cross = check(&path, &options);
        let names = failed(&cross);
        assert!(names.contains(&quantity), "{fault}: {names:?}");
        assert!(names.contains(&"inverse dynamics"), "{fault}: {names:?}");
        let found = cross.checks.iter().find(|c| c.quantity == quantity).unwrap();
        assert_eq!(found.at, place, "{fault}");
    }
}

/// The same through the file: MuJoCo is given a second version of the model.
#[test]
fn slow_a_changed_file_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(shared("dm_control/humanoid.xml")).unwrap();
    let changes = [
        (
            "name=\"head\" type=\"sphere\" size=\".09\"",
            "name=\"head\" type=\"sphere\" size=\".0903\"",
            "masses",
        ),
        (
            "joint name=\"right_knee\" pos=\"0 0 .02\"",
            "joint name=\"right_knee\" pos=\".001 0 .02\"",
            "positions of the joints",
        ),
    ];
    for (from, to, quantity) in changes {
        assert!(text.contains(from), "{from}");
        let include = shared("dm_control/common");
        let changed = text.replace(from, to).replace("./common", &include.display().to_string());
        let path = folder.path().join("changed.xml");
        std::fs::write(&path, changed).unwrap();
        let options = Options { dynamics_only: true, states: 20, against: Some(path), ..Options::default() };
        let cross = check(&shared("dm_control/humanoid.xml"), &options);
        assert!(failed(&cross).contains(&quantity), "{quantity}: {:?}", failed(&cross));
    }
}

/// The same seed gives the same table, to the digit.
#[test]
fn slow_the_same_seed_gives_the_same_table() {
    let options = Options { states: 50, seed: 7, ..Options::default() };
    let table = || crosscheck::report::json(&check(&human(), &options));
    assert_eq!(table(), table());
}
