//! The zoo against MuJoCo's own inverse dynamics (`shared/models/reference_inverse_dynamics.json`).

use std::path::{Path, PathBuf};

use formats::model::{ImportOptions, Imported, open};
use motion::{Joint, Limits};
use serde_json::Value;

mod mujoco;
use mujoco::{body_errors, numbers, tau_error, whole_errors};

const MODELS: [&str; 6] = [
    "dm_control/humanoid.xml",
    "dm_control/humanoid_CMU.xml",
    "dm_control/quadruped.xml",
    "dm_control/walker.xml",
    "dm_control/manipulator.xml",
    "pinocchio/simple_humanoid.urdf",
];
const BARE: ImportOptions = ImportOptions { dynamics_only: true };

fn shared() -> PathBuf {
    support::shared("models")
}

fn table() -> Value {
    let text = std::fs::read_to_string(shared().join("reference_inverse_dynamics.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn zoo(name: &str) -> Imported {
    open(&shared().join(name), &BARE).unwrap_or_else(|e| panic!("{e}"))
}

/// Masses, centres of mass and inertias are those MuJoCo compiles.
#[test]
fn bodies_are_mujocos() {
    let table = table();
    for name in MODELS {
        let reference = &table["models"][name];
        let imported = zoo(name);
        let [mass, com, inertia] = body_errors(&imported, reference, name.ends_with("urdf"));
        assert!(mass < 1e-13 && com < 1e-13 && inertia < 1e-13, "{name}: {mass} {com} {inertia}"); // 1e-15 seen
        if !name.ends_with("urdf") {
            // MuJoCo forgets the mass of a URDF's welded root link
            let total = reference["total_mass"].as_f64().unwrap();
            assert!((imported.character.mass() - total).abs() < 1e-9 * total, "{name}"); // 1e-15 seen
        }
    }
}

/// Same number of coordinates, same joints in the same order, same gravity.
#[test]
fn joints_are_mujocos() {
    let table = table();
    for name in MODELS {
        let reference = &table["models"][name];
        let imported = zoo(name);
        let skeleton = &imported.character.skeleton;
        assert_eq!(Some(skeleton.nq() as u64), reference["nq"].as_u64(), "{name}");
        assert_eq!(Some(skeleton.nv() as u64), reference["nv"].as_u64(), "{name}");
        let theirs = reference["joints"].as_array().unwrap();
        assert_eq!(imported.joints.len(), theirs.len(), "{name}");
        for (ours, theirs) in imported.joints.iter().zip(theirs) {
            assert_eq!(ours.name, theirs["name"].as_str().unwrap(), "{name}");
            assert_eq!(Some(skeleton.q_at(ours.link) as u64), theirs["qposadr"].as_u64(), "{name}");
            assert_eq!(Some(skeleton.v_at(ours.link) as u64), theirs["dofadr"].as_u64(), "{name}");
        }
        assert_eq!(imported.gravity, motion::Vec3::new(0.0, -9.81, 0.0), "{name}");
        // state 0 of the table is at qpos0, our rest pose
        let rest = numbers(&reference["states"][0]["qpos"]);
        let error = imported.character.rest.iter().zip(&rest).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 1e-15, "{name}: {error}");
    }
}

/// τ = M v̇ + c, centre of mass and trace of M agree with MuJoCo at every state of every model.
#[test]
fn inverse_dynamics_is_mujocos() {
    let table = table();
    for name in MODELS {
        let reference = &table["models"][name];
        let imported = zoo(name);
        let error = tau_error(&imported, reference);
        assert!(error <= 1e-10, "{name}: {error}"); // 1.5e-15 seen
        let [com, trace] = whole_errors(&imported, reference);
        assert!(trace < 1e-12, "{name}: {trace}"); // 1.4e-15 seen
        assert!(name.ends_with("urdf") || com < 1e-12, "{name}: {com}"); // 7e-16 seen
    }
}

/// Velocities and forces go to MuJoCo's conventions and back, and exchange the same power in both.
#[test]
fn conventions_invert_and_keep_power() {
    let table = table();
    for name in MODELS {
        let layout = zoo(name).layout();
        for s in table["models"][name]["states"].as_array().unwrap() {
            let (qpos, v_m, tau_m) = (numbers(&s["qpos"]), numbers(&s["qvel"]), numbers(&s["tau"]));
            let q = mujoco::pose(&layout, &qpos);
            let v = mujoco::ours(&layout, &q, &v_m);
            let tau = mujoco::ours(&layout, &q, &tau_m);
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let scale = dot(&tau_m, &tau_m).sqrt() * dot(&v_m, &v_m).sqrt() + 1e-300;
            assert!((dot(&tau, &v) - dot(&tau_m, &v_m)).abs() <= 1e-14 * scale, "{name}"); // 3e-16 seen
            for (x, y) in mujoco::theirs(&layout, &q, &v).iter().zip(&v_m) {
                assert!((x - y).abs() < 1e-13, "{name}");
            }
            for (x, y) in mujoco::theirs(&layout, &q, &tau).iter().zip(&tau_m) {
                assert!((x - y).abs() < 1e-14 * scale.max(1e4), "{name}");
            }
        }
    }
}

/// The ranges of the file, in radians; unlimited joints have none.
#[test]
fn ranges_are_limits() {
    let imported = zoo("dm_control/humanoid.xml");
    let skeleton = &imported.character.skeleton;
    let degrees = |name: &str| match skeleton.links()
        [imported.joints.iter().find(|j| j.name == name).unwrap().link]
        .limits
    {
        Some(Limits::Axis(r)) => Some((r.lo.to_degrees().round(), r.hi.to_degrees().round())),
        _ => None,
    };
    assert_eq!(degrees("right_knee"), Some((-160.0, 2.0)));
    assert_eq!(degrees("abdomen_y"), Some((-75.0, 30.0)));
    assert_eq!(degrees("root"), None);
    let manipulator = zoo("dm_control/manipulator.xml");
    assert!(
        manipulator.character.skeleton.links().iter().any(|l| l.name == "upper_arm" && l.limits.is_none())
    );
    assert!(manipulator.character.skeleton.links()[0].joint == Joint::Fixed);
}

/// Shapes and sites are where the file has them: a body of one solid has its centre of mass at the solid's
/// centre, and a site at a joint's anchor is at the link's origin.
#[test]
fn shapes_and_sites_are_in_the_links_frames() {
    use motion::Shape::{Box, Capsule, Sphere};
    let imported = zoo("dm_control/humanoid.xml");
    let mut seen = 0;
    for body in &imported.character.bodies {
        let [shape] = body.shapes.as_slice() else { continue };
        let centre = match shape {
            Capsule { a, b, .. } => (a + b) / 2.0,
            Box { center, .. } | Sphere { center, .. } => *center,
            motion::Shape::Cone { .. } => panic!("the file has no cones"),
        };
        assert!((centre - body.com).norm() < 1e-15);
        seen += 1;
    }
    assert_eq!(seen, 13); // all but torso and feet, which have two capsules each
    let knee = imported.character.skeleton.site("right_knee").unwrap();
    assert_eq!(imported.character.skeleton.links()[knee.link].name, "right_shin");
    assert!(knee.at.norm() < 1e-15);
}

/// Negative controls: a mass, an axis, a centre of mass that are wrong by little are far outside the tolerance.
#[test]
fn wrong_models_are_found_out() {
    let table = table();
    let reference = &table["models"]["dm_control/humanoid.xml"];
    let text = std::fs::read_to_string(shared().join("dm_control/humanoid.xml")).unwrap();
    // the includes bring only look
    let text: String = text.lines().filter(|l| !l.contains("<include")).map(|l| format!("{l}\n")).collect();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.xml");
    let error = |from: &str, to: &str| {
        assert_eq!(text.matches(from).count(), 1, "{from}");
        std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
        tau_error(&open(&path, &BARE).unwrap_or_else(|e| panic!("{e}")), reference)
    };
    let same = error("<mujoco model=\"humanoid\">", "<mujoco model=\"humanoid\">");
    assert!(same <= 1e-10, "{same}");
    let mass =
        error("geom name=\"head\" type=\"sphere\"", "geom name=\"head\" density=\"1010\" type=\"sphere\"");
    assert!(mass > 1e-5, "1 % of the head's mass: {mass}"); // 8e-4 seen
    let axis =
        error("joint name=\"right_elbow\" axis=\"0 -1 1\"", "joint name=\"right_elbow\" axis=\"0 1 -1\"");
    assert!(axis > 1e-3, "swapped axis: {axis}"); // 0.013 seen
    let com =
        error("geom name=\"head\" type=\"sphere\"", "geom name=\"head\" pos=\"0.001 0 0\" type=\"sphere\"");
    assert!(com > 1e-6, "head shifted by 1 mm: {com}"); // 7e-5 seen
}

/// Without `dynamics_only` the zoo is refused, and the message names what and where.
#[test]
fn what_makes_forces_is_refused_by_name() {
    let path = shared().join("dm_control/quadruped.xml");
    let message = open(&path, &ImportOptions::default()).unwrap_err().to_string();
    let file = path.display();
    let first = "default class `main`, geom: solimp, solref (contact parameters)";
    assert!(message.contains(&format!("{first}\n  --> {file}:19:11")), "{message}");
    let mesh = shared().join("pinocchio/simple_humanoid.urdf");
    assert_eq!(
        open(&mesh, &ImportOptions::default()).unwrap_err().to_string(),
        format!(
            "the mesh file package://simple_humanoid_description/box.stl does not exist\n  --> {}:20:5",
            mesh.display()
        )
    );
}

/// With `dynamics_only` every item is listed with its place: nothing of the file goes missing.
#[test]
fn what_is_left_out_is_listed_item_by_item() {
    let imported = zoo("dm_control/quadruped.xml");
    let count = |reason: &str| imported.left_out.iter().filter(|i| i.reason == reason).count();
    // 12 fixed tendons, 4 equalities, 12 actuators and 4 default classes of them; sensors as a whole
    assert_eq!(count("tendon"), 12);
    assert_eq!(count("equality constraint"), 4 + 1);
    assert_eq!(count("sensors: they measure and exert no force"), 1);
    assert_eq!(count("actuator"), 12 + 4);
    let text: Vec<String> = imported.left_out.iter().map(|i| i.to_string()).collect();
    let file = shared().join("dm_control/quadruped.xml");
    let has = |s: &str| text.iter().any(|t| t == &s.replace("FILE", &file.display().to_string()));
    assert!(has("fixed `coupling_front_left` (tendon)\n  --> FILE:209:5"), "{text:#?}");
    let file = Path::new("materials.xml");
    assert!(imported.left_out.iter().any(|i| i.what == "material `grid`" && i.place.file.ends_with(file)));
    let urdf = zoo("pinocchio/simple_humanoid.urdf");
    for what in ["link `WAIST_LINK0`: collision `box`", "link `WAIST_LINK0`: collision_checking"] {
        assert!(urdf.left_out.iter().any(|i| i.what == what), "{what}");
    }
}
