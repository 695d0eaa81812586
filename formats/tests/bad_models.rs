//! Bad models: every fault has its words, and ends in the place where it is.

use std::path::Path;

use formats::model::{ImportOptions, open};

/// What the importer says about a file, its folder cut from all paths.
fn complaint(folder: &Path, name: &str, dynamics_only: bool) -> String {
    let message = match open(&folder.join(name), &ImportOptions { dynamics_only }) {
        Ok(_) => panic!("{name} was accepted"),
        Err(e) => e.to_string(),
    };
    message.replace(&format!("{}/", folder.display()), "")
}

/// `«` marks the place expected; the message must be `words`, then that place.
fn check(file: &str, text: &str, words: &str) {
    let folder = tempfile::tempdir().unwrap();
    let at = text.find('«').unwrap_or_else(|| panic!("no place marked in {text}"));
    let line = text[..at].matches('\n').count() + 1;
    let column = text[..at].chars().rev().take_while(|&c| c != '\n').count() + 1;
    std::fs::write(folder.path().join(file), text.replace('«', "")).unwrap();
    let message = complaint(folder.path(), file, true);
    assert_eq!(message, format!("{words}\n  --> {file}:{line}:{column}"), "{text}");
}

/// An MJCF whose world holds a sound body and `body`.
fn world(body: &str, words: &str) {
    let text = format!(
        "<mujoco>\n  <default><default class=\"arm\"/></default>\n  <worldbody>\n    {body}\n    <body><joint/><geom size=\"1\"/></body>\n  </worldbody>\n</mujoco>"
    );
    check("m.xml", &text, words);
}

/// An MJCF with `section` before a sound world.
fn section(section: &str, words: &str) {
    let text = format!(
        "<mujoco>\n{section}\n<worldbody><body><joint/><geom size=\"1\"/></body></worldbody>\n</mujoco>"
    );
    check("m.xml", &text, words);
}

/// A URDF with `content`, and two sound links `a` and `b`.
fn robot(content: &str, words: &str) {
    const INERTIAL: &str = "<inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial>";
    let text = format!(
        "<robot name=\"r\">\n  <link name=\"a\">{INERTIAL}</link>\n  <link name=\"b\">{INERTIAL}</link>\n  {content}\n</robot>"
    );
    check("r.urdf", &text, words);
}

#[test]
fn xml_that_is_none() {
    check(
        "m.xml",
        "<mujoco>\n  <worldbody>\n  «</mujoco>",
        "not XML: expected 'worldbody' tag, not 'mujoco'",
    );
    check(
        "m.xml",
        "<mujoco>\n  <worldbody/>\n  «broken -->\n</mujoco>",
        "text `broken -->` inside <mujoco>; only elements and comments are allowed",
    );
    check("m.xml", "«<robots/>", "the root element is <robots>; expected <mujoco> or <robot>");
    let deep = format!(
        "<mujoco><worldbody>{}«{}",
        "<body>".repeat(399),
        "<body>".repeat(5) + &"</body>".repeat(404) + "</worldbody></mujoco>"
    );
    check("m.xml", &deep, "elements are nested more than 400 deep");
}

/// Nesting is bounded, also through includes, and what is allowed is read.
#[test]
fn depth_is_bounded() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let nested = |n: usize, inside: &str| {
        let body = "<body pos=\"0.1 0 0\"><joint/><geom size=\"0.1\"/>";
        format!("{}{inside}{}", body.repeat(n), "</body>".repeat(n))
    };
    let file = |inside: &str| format!("<mujoco><worldbody>{inside}</worldbody></mujoco>");
    write("deep.xml", &file(&nested(398, "")));
    assert_eq!(open(&folder.path().join("deep.xml"), &ImportOptions::default()).unwrap().joints.len(), 398);
    write("a.xml", &file(&nested(300, "<include file=\"b.xml\"/>")));
    write("b.xml", &format!("<mujoco>{}</mujoco>", nested(300, "")));
    let message = complaint(folder.path(), "a.xml", true);
    assert!(message.starts_with("elements are nested more than 400 deep\n  --> b.xml:1:"), "{message}");
    write("abyss.xml", &"<mujoco>".repeat(200_000));
    complaint(folder.path(), "abyss.xml", true);
    write("abyss.xml", &("<mujoco>".repeat(200_000) + &"</mujoco>".repeat(200_000)));
    let message = complaint(folder.path(), "abyss.xml", true);
    assert!(message.starts_with("elements are nested more than 400 deep\n"), "{message}");
}

#[test]
fn words_that_mjcf_does_not_have() {
    world("«<boddy/>", "unknown element <boddy> in <worldbody>; did you mean `body`?");
    world("<body><geom «sise=\"1\"/></body>", "unknown attribute `sise` of <geom>; did you mean `size`?");
    section("«<actuators/>", "unknown element <actuators> in <mujoco>; did you mean `actuator`?");
    section("<tendon>«<fixxed/></tendon>", "unknown element <fixxed> in <tendon>; did you mean `fixed`?");
    section(
        "<compiler «angel=\"degree\"/>",
        "unknown attribute `angel` of <compiler>; did you mean `angle`?",
    );
    section(
        "<compiler «angle=\"degrees\"/>",
        "unknown word `degrees` for `angle` of compiler; did you mean `degree`?",
    );
    section("<option>«<flags/></option>", "unknown element <flags> in <option>; did you mean `flag`?");
    section(
        "<default><default class=\"x\"><geom «densty=\"3\"/></default></default>",
        "unknown attribute `densty` of <geom>; did you mean `density`?",
    );
    world(
        "<body><geom size=\"1\" «type=\"ball\"/></body>",
        "unknown word `ball` for `type` of geom; there are: sphere, capsule, cylinder, box, ellipsoid, plane, hfield, mesh, sdf",
    );
}

#[test]
fn numbers_that_are_none() {
    world("<body «pos=\"0 O 1\"/>", "`O` in `pos` of body is not a finite number");
    world("<body name=\"x\" «pos=\"0 nan 1\"/>", "`nan` in `pos` of body `x` is not a finite number");
    world("<body «pos=\"0 1\"/>", "`pos` of body has 2 numbers; it takes 3");
    world("<body «quat=\"0 0 0 0\"/>", "`quat` of body is 0 0 0 0; it must be a quaternion, not all zeros");
    world(
        "<body quat=\"1 0 0 0\" «euler=\"0 0 0\"/>",
        "<body> has quat and euler; only one of them is allowed",
    );
    world(
        "<body><joint «axis=\"0 0 0\"/></body>",
        "`axis` of joint is 0 0 0; it must be a direction, not all zeros",
    );
    world(
        "<body><joint «range=\"30 -30\"/></body>",
        "`range` of joint is 30 -30; it must be two numbers, the lower first",
    );
    world("<body><joint name=\"k\" «limited=\"true\"/></body>", "joint `k` needs `range`, as it is limited");
    world("<body><geom name=\"g\" «size=\"-1\"/></body>", "`size` of geom `g` is -1; it must be positive");
    world("<body><geom type=\"box\" name=\"g\" «size=\"1 1\"/></body>", "geom `g`, a box, needs 3 sizes");
    world("<body><geom size=\"1\" «mass=\"-1\"/></body>", "`mass` of geom is -1; it must be 0 or more");
    world(
        "<body><geom type=\"capsule\" size=\"1\" «fromto=\"1 2 3 1 2 3\"/></body>",
        "`fromto` of geom is 1 2 3 1 2 3; it must be two different points",
    );
    world(
        "<body><geom type=\"capsule\" size=\"1\" pos=\"1 0 0\" «fromto=\"0 0 0 1 2 3\"/></body>",
        "<geom> has fromto and pos; only one of them is allowed",
    );
    section(
        "<compiler «eulerseq=\"xyw\"/>",
        "`eulerseq` of compiler is xyw; it must be three letters of xyz (axes that turn along) or XYZ (fixed axes)",
    );
}

#[test]
fn classes_nobody_defined() {
    world("<body «childclass=\"amr\"/>", "unknown default class `amr`; did you mean `arm`?");
    world("<body><joint «class=\"leg\"/></body>", "unknown default class `leg`; there are: main, arm");
    section(
        "<default><default class=\"x\"/><default «class=\"x\"/></default>",
        "default class `x` is defined twice",
    );
    section("<default>«<default/></default>", "default needs `class`, as it stands inside another <default>");
}

#[test]
fn masses_no_solid_has() {
    let inertial = |at: &str, numbers: &str, words: &str| {
        world(&format!("<body name=\"b\"><joint/>{at}<inertial pos=\"0 0 0\" {numbers}/></body>"), words);
    };
    inertial("«", "mass=\"-2\" diaginertia=\"1 1 1\"", "body `b` has a mass of -2 kg; it must be positive");
    inertial("«", "mass=\"0\" diaginertia=\"1 1 1\"", "body `b` has a mass of 0 kg; it must be positive");
    inertial(
        "«",
        "mass=\"2\" diaginertia=\"1 0 1\"",
        "body `b` has principal inertias [0.0, 1.0, 1.0] kg·m²; each must be positive",
    );
    inertial(
        "«",
        "mass=\"2\" diaginertia=\"1 2 4\"",
        "body `b` has principal inertias [1.0, 2.0, 4.0] kg·m²; the greatest must be at most the sum of the other two",
    );
    inertial("«", "mass=\"2\"", "inertial needs `diaginertia` or `fullinertia`");
    inertial("«", "diaginertia=\"1 2 2\"", "inertial needs `mass`");
}

#[test]
fn subtrees_without_inertia() {
    world(
        "<body name=\"b\">«<joint name=\"j\"/></body>",
        "joint `j` moves a subtree without inertia about its axis; give body `b` mass",
    );
    // mass further out does not help where the outer joint turns about the same axis
    world(
        "<body name=\"b\">«<joint name=\"j\" axis=\"1 2 3\"/><body pos=\"2 4 6\"><joint axis=\"1 2 3\"/><geom size=\"1\"/></body></body>",
        "joint `j` moves a subtree without inertia about its axis; give body `b` mass",
    );
    world(
        "<body name=\"b\">«<freejoint name=\"j\"/><geom size=\"1\" mass=\"0\"/></body>",
        "joint `j` moves a subtree without inertia about its axis; give body `b` mass",
    );
    robot(
        "<link name=\"c\"/><joint name=\"ab\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint>\n  «<joint name=\"bc\" type=\"continuous\"><parent link=\"b\"/><child link=\"c\"/></joint>",
        "joint `bc` moves a subtree without inertia about its axis; give body `c` mass",
    );
}

/// Massless bodies between joints about other axes are sound.
#[test]
fn massless_bodies_between_joints_are_sound() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.xml");
    let text = "<mujoco><worldbody><body><joint/><body pos=\"0.1 0 0\"><joint axis=\"1 0 0\"/><geom size=\"0.1\" pos=\"0 0.3 0\"/></body></body></worldbody></mujoco>";
    std::fs::write(&path, text).unwrap();
    let imported = open(&path, &ImportOptions::default()).unwrap();
    assert_eq!(imported.joints.len(), 2);
}

#[test]
fn things_that_would_change_the_model() {
    world(
        "<body>«<composite/></body>",
        "<composite> is not supported: it makes bodies while MuJoCo compiles; let MuJoCo save the compiled model (`compile model.xml out.xml`)",
    );
    world(
        "<body><joint «type=\"free\"/><joint/></body>"
            .replace('«', "")
            .replace("<joint type", "«<joint type")
            .as_str(),
        "a free joint must be the only joint of a body of the world",
    );
    world(
        "«<joint/>",
        "<joint> in <worldbody> is not supported: the world does not move; put it in a <body>",
    );
    world(
        "<body name=\"m\"><joint/>«<geom type=\"mesh\" mesh=\"x\"/></body>",
        "the inertia of body `m` would come from a mesh, and meshes are not read; give it <inertial>",
    );
    world(
        "<body><geom «type=\"plane\" size=\"1 1 1\"/></body>",
        "a plane on a body is not supported: it has no mass and no end; only geoms of the world may be one",
    );
    section(
        "<compiler «balanceinertia=\"true\"/>",
        "balanceinertia=\"true\" of <compiler> is not supported: inertias are taken as they are; write physical ones",
    );
    section(
        "<compiler «coordinate=\"global\"/>",
        "coordinate=\"global\" is not supported: MuJoCo itself gave it up; use local coordinates",
    );
    section(
        "<extension>«<plugin plugin=\"x\"/></extension>",
        "<plugin> is not supported: plugins are not read",
    );
    section("<deformable>«<flex/></deformable>", "<flex> is not supported: soft bodies are not read");
    world(
        "<body name=\"x\"><geom size=\"1\"/></body>«<body name=\"x\"><geom size=\"1\"/></body>",
        "the body name `x` is used twice; names must be unique",
    );
    check("m.xml", "<mujoco>«<worldbody/></mujoco>", "the model has no body");
}

#[test]
fn includes_that_lead_nowhere() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("a.xml", "<mujoco>\n  <include file=\"b.xml\"/>\n</mujoco>");
    write("b.xml", "<mujoco><include file=\"a.xml\"/></mujoco>");
    let loops = "the includes go round in a circle: a.xml → b.xml → a.xml\n  --> b.xml:1:9";
    assert_eq!(complaint(folder.path(), "a.xml", true), loops);
    write("c.xml", "<mujoco>\n  <include file=\"nowhere.xml\"/>\n</mujoco>");
    let missing = "the included file nowhere.xml does not exist\n  --> c.xml:2:3";
    assert_eq!(complaint(folder.path(), "c.xml", true), missing);
    write("d.xml", "<mujoco/>");
    write("e.xml", "<mujoco><include file=\"d.xml\"/>\n<include file=\"d.xml\"/></mujoco>");
    let twice = "d.xml is included a second time; a file can be included once\n  --> e.xml:2:1";
    assert_eq!(complaint(folder.path(), "e.xml", true), twice);
    write("f.xml", "<mujoco><include/></mujoco>");
    assert_eq!(complaint(folder.path(), "f.xml", true), "include needs `file`\n  --> f.xml:1:9");
    assert!(complaint(folder.path(), "no.xml", true).starts_with("cannot read no.xml: "));
}

/// A name is looked for beside the main file first, then beside the file that has it.
#[test]
fn included_names_are_found_as_mujoco_finds_them() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let sized = |size: &str| format!("<mujoco><default><geom size=\"{size}\"/></default></mujoco>");
    write(
        "m.xml",
        "<mujoco><include file=\"sub/a.xml\"/><worldbody><body><joint/><geom/></body></worldbody></mujoco>",
    );
    write("sub/a.xml", "<mujoco><include file=\"b.xml\"/></mujoco>");
    let mass = || open(&folder.path().join("m.xml"), &ImportOptions::default()).unwrap().character.mass();
    let ball = |r: f64| 4000.0 / 3.0 * std::f64::consts::PI * r * r * r;
    write("sub/b.xml", &sized("0.5"));
    assert!((mass() / ball(0.5) - 1.0).abs() < 1e-14);
    write("b.xml", &sized("0.25"));
    assert!((mass() / ball(0.25) - 1.0).abs() < 1e-14);
}

#[test]
fn meshes_that_are_missing() {
    let folder = tempfile::tempdir().unwrap();
    let text = "<mujoco>\n<compiler meshdir=\"parts\"/>\n<asset><mesh file=\"leg.stl\"/></asset>\n<worldbody><body><joint/><geom size=\"1\"/></body></worldbody></mujoco>";
    std::fs::write(folder.path().join("m.xml"), text).unwrap();
    let missing = "the mesh file parts/leg.stl does not exist\n  --> m.xml:3:8";
    assert_eq!(complaint(folder.path(), "m.xml", false), missing);
    std::fs::create_dir(folder.path().join("parts")).unwrap();
    std::fs::write(folder.path().join("parts/leg.stl"), "solid").unwrap();
    let unread = "`m` (2 links, 1 degrees of freedom, 4188.79 kg) can be read, but not what makes forces in it: mesh (1); --dynamics-only leaves it out and lists it, `contrapposto inspect` shows what is read\nmesh (mesh)\n  --> m.xml:3:8";
    assert_eq!(complaint(folder.path(), "m.xml", false), unread);
}

#[test]
fn robots_that_are_no_trees() {
    let joint = |name: &str, rest: &str| format!("<joint name=\"{name}\" type=\"continuous\">{rest}</joint>");
    let ends = |parent: &str, child: &str| format!("<parent {parent}/><child {child}/>");
    robot(
        &joint("j", &ends("link=\"a\"", "«link=\"c\"")),
        "joint `j` names the unknown link `c`; there are: a, b",
    );
    robot(
        &(joint("j", &ends("link=\"a\"", "link=\"b\"")) + &joint("k", &ends("link=\"a\"", "«link=\"b\""))),
        "link `b` is the child of two joints, `j` and `k`; a link has one parent",
    );
    robot("«<link name=\"a\"/>", "the link name `a` is used twice; names must be unique");
    robot(&joint("j", "«<parent/>"), "parent needs `link`");
    check("r.urdf", "«<robot name=\"r\"/>", "robot needs a <link>");
    check(
        "r.urdf",
        "<robot name=\"r\">\n<link name=\"a\"/>\n«<link name=\"b\"/></robot>",
        "links `a` and `b` both have no parent; a robot is one tree with one root",
    );
    check(
        "r.urdf",
        &format!(
            "<robot name=\"r\">«<link name=\"a\"/><link name=\"b\"/>{}{}</robot>",
            joint("j", &ends("link=\"a\"", "link=\"b\"")),
            joint("k", &ends("link=\"b\"", "link=\"a\""))
        ),
        "the joints go round in a circle: link `a` carries itself",
    );
}

#[test]
fn words_that_urdf_does_not_have() {
    let joint = |kind: &str, rest: &str| {
        format!("<joint name=\"j\" {kind}><parent link=\"a\"/><child link=\"b\"/>{rest}</joint>")
    };
    robot("«<lnik name=\"c\"/>", "unknown element <lnik> in <robot>; did you mean `link`?");
    robot(
        &joint("«type=\"planar\"", ""),
        "a planar joint is not supported: write two prismatic joints and a continuous one, with massless links between them",
    );
    robot(
        &joint("«type=\"hinge\"", ""),
        "unknown word `hinge` for `type` of joint `j`; there are: fixed, revolute, continuous, prismatic, floating, planar",
    );
    robot(
        &joint("type=\"continuous\"", "<mimc «joint=\"k\"/>").replace("<mimc «", "«<mimc "),
        "unknown element <mimc> in <joint>; did you mean `mimic`?",
    );
    robot(
        &joint("type=\"continuous\"", "<origin «xzy=\"0 0 0\"/>"),
        "unknown attribute `xzy` of <origin>; did you mean `xyz`?",
    );
    robot(
        &joint("type=\"revolute\"", "<limit «lower=\"1\" upper=\"0\"/>"),
        "`lower` of limit is 1; it must be at most `upper`",
    );
    robot(
        &format!("«{}", joint("type=\"revolute\"", "")),
        "joint `j` needs <limit>; a hinge without is `continuous`",
    );
    check(
        "r.urdf",
        "<robot name=\"r\" xmlns:xacro=\"x\">\n  «<xacro:include/></robot>",
        "<xacro:include> is not supported: expand the file first: `xacro model.urdf.xacro > model.urdf`",
    );
    check(
        "r.urdf",
        "<robot name=\"r\"><link name=\"a\">«<inertial><mass value=\"-1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial></link></robot>",
        "body `a` has a mass of -1 kg; it must be positive",
    );
}
