//! Robots as people share them: frames with an inertia of no solid, welded to bodies that have one; words of old formats.

use bodies::mass::fuse;
use formats::model::{ImportOptions, Imported, open};
use motion::Vec3;
use nalgebra::{Matrix3, Vector3};

const LISTED: ImportOptions = ImportOptions { dynamics_only: true };

fn read(text: &str) -> Result<Imported, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("robot.urdf");
    std::fs::write(&path, text).unwrap();
    open(&path, &LISTED).map_err(|e| e.to_string())
}

fn link(name: &str, mass: f64, principal: [f64; 3]) -> String {
    let [x, y, z] = principal;
    format!(
        "<link name=\"{name}\"><inertial><mass value=\"{mass}\"/><inertia ixx=\"{x}\" iyy=\"{y}\" izz=\"{z}\"/></inertial></link>"
    )
}

fn joint(kind: &str, parent: &str, child: &str, xyz: &str) -> String {
    format!(
        "<joint name=\"{child}\" type=\"{kind}\"><origin xyz=\"{xyz}\" rpy=\"0 0 1.5707963267948966\"/><parent link=\"{parent}\"/><child link=\"{child}\"/></joint>"
    )
}

/// base – (hinge) – arm – (welded) – tip
fn arm(tip: &str) -> String {
    let arm = link("arm", 2.0, [0.02, 0.03, 0.04]);
    let (hinge, weld) =
        (joint("continuous", "base", "arm", "0 0 0"), joint("fixed", "arm", "tip", "0.3 0 0"));
    format!("<robot name=\"r\"><link name=\"base\"/>{arm}{tip}{hinge}{weld}</robot>")
}

/// A tip that is a point, a thin rod or a frame is weighed with the arm: mass, centre and inertia of both, by hand. The tip is
/// turned by 90° about z, so that its x is the arm's y.
#[test]
fn a_welded_frame_is_weighed_with_what_carries_it() {
    for (mass, principal) in
        [(0.5, [0.0, 0.0, 0.0]), (0.5, [0.0, 1e-3, 1e-3]), (0.1, [1e-6, 2e-3, 1e-6]), (0.0, [1e-6; 3])]
    {
        let robot = read(&arm(&link("tip", mass, principal))).unwrap();
        let [x, y, z] = principal;
        let tip = Matrix3::from_diagonal(&Vector3::new(y, x, z));
        let own = Matrix3::from_diagonal(&Vector3::new(0.02, 0.03, 0.04));
        let both = fuse((2.0, Vec3::zeros(), own), (mass, Vec3::new(0.3, 0.0, 0.0), tip));
        let (arm, welded) = (&robot.character.bodies[1], &robot.character.bodies[2]);
        assert_eq!((arm.mass, welded.mass), (2.0 + mass, 0.0));
        assert!(
            (arm.com - both.1).norm() < 1e-15 && (arm.inertia - both.2).norm() < 1e-15,
            "{mass}: {}",
            arm.inertia
        );
        let listed = robot.left_out.iter().filter(|item| item.what == "inertial of body `tip`").count();
        assert_eq!(listed, 1, "{:?}", robot.left_out);
    }
    // one that is a solid's keeps its own
    let robot = read(&arm(&link("tip", 0.5, [1e-3, 1e-3, 1e-3]))).unwrap();
    assert_eq!(robot.character.bodies[2].mass, 0.5);
}

/// What moves by itself has to be a solid: nothing is welded to it that would mend it, or the sum is no solid's either.
#[test]
fn what_moves_by_itself_is_a_solid() {
    let bad = arm(&link("tip", 0.5, [1e-3; 3])).replace("izz=\"0.04\"", "izz=\"9\"");
    let words = read(&bad).unwrap_err();
    assert!(words.contains("body `arm`") && words.contains("at most the sum of the other two"), "{words}");
    for (mass, words) in [("-1", "mass of -1 kg"), ("0", "moves a subtree without inertia")] {
        let text = arm("<link name=\"tip\"/>").replace("mass value=\"2\"", &format!("mass value=\"{mass}\""));
        let text = if mass == "0" {
            text.replace(&link("arm", 0.0, [0.02, 0.03, 0.04]), "<link name=\"arm\"/>")
        } else {
            text
        };
        let found = read(&text).unwrap_err();
        assert!(found.contains(words), "{found}");
    }
    let nothing =
        read(&arm("<link name=\"tip\"/>").replace("mass value=\"2\"", "mass value=\"0\"")).unwrap_err();
    assert!(nothing.contains("body `arm` has a mass of 0 kg"), "{nothing}");
}

/// A root link stands fast: nothing resists there, whatever inertia it says.
#[test]
fn a_root_that_never_moves_may_weigh_nothing() {
    for (mass, principal) in [(0.0, [1.0; 3]), (3.0, [0.0; 3]), (3.0, [1.0, 1.0, 9.0])] {
        let base = link("base", mass, principal);
        let robot = read(&arm("<link name=\"tip\"/>").replace("<link name=\"base\"/>", &base)).unwrap();
        assert_eq!(robot.character.mass(), 2.0);
        let reasons: Vec<&str> = robot.left_out.iter().map(|i| i.reason).collect();
        assert_eq!(reasons, ["no solid's; it never moves and weighs nothing here"]);
    }
}

/// A joint that follows another, the old word for damping, and blank lines before the declaration.
#[test]
fn words_of_shared_robots_are_read_or_listed() {
    let extra =
        "<mimic joint=\"k\" multiplier=\"2\"/><joint_properties damping=\"0.5\" friction=\"0.0\"/></joint>";
    let text = arm("<link name=\"tip\"/>").replacen("</joint>", extra, 1);
    let robot = read(&format!("\n\n  <?xml version=\"1.0\" ?>\n{text}")).unwrap();
    let listed: Vec<String> = robot.left_out.iter().map(|i| format!("{} ({})", i.what, i.reason)).collect();
    assert_eq!(
        listed,
        [
            "joint `arm`: mimic (a joint that follows another one)",
            "joint `arm`: joint_properties: damping (passive forces)"
        ]
    );
    assert_eq!(robot.joints.len(), 1);
    // places stay those of the file
    let fault = read("\n<?xml version=\"1.0\"?>\n<robot>\n  <lnik/></robot>").unwrap_err();
    assert!(fault.contains("robot.urdf:4:3"), "{fault}");
    // what makes forces is not left out unasked
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("robot.urdf");
    std::fs::write(&path, &text).unwrap();
    let refused = open(&path, &ImportOptions { dynamics_only: false }).unwrap_err().to_string();
    assert!(
        refused.contains("a joint that follows another one (1)") && refused.contains("--dynamics-only"),
        "{refused}"
    );
}

/// A lone link that never moves is a model, but no MJCF could hold it and be read again.
#[test]
fn a_lone_link_is_read_and_not_written() {
    let robot = read("<robot name=\"tray\"><link name=\"tray\"/></robot>").unwrap();
    let words = formats::mjcf::write(&robot.character, &Default::default()).unwrap_err().to_string();
    assert_eq!(
        words,
        "`tray` is one link without mass or shapes that never moves; an MJCF of it would hold no body"
    );
}
