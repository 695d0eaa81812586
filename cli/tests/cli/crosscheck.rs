//! `crosscheck` from end to end, on models small enough to be quick.

use crate::place::{Done, Place};

/// A hinged rod over a free box, Z up.
const MODEL: &str = r#"<mujoco model="rod">
  <option gravity="0 0 -9.81"/>
  <worldbody>
    <body name="box" pos="0 0 1">
      <freejoint name="root"/>
      <geom type="box" size=".1 .2 .05" density="800"/>
      <body name="rod" pos=".1 0 .05">
        <joint name="hinge" type="hinge" axis="0 1 0"/>
        <geom type="capsule" fromto="0 0 0 .1 0 .4" size=".03" mass="1.5"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"#;

fn json(done: &Done) -> serde_json::Value {
    serde_json::from_str(&done.stdout).unwrap_or_else(|e| panic!("{e}: {} {}", done.stdout, done.stderr))
}

fn check(place: &Place, args: &[&str]) -> Done {
    let mut all = vec!["crosscheck", "rod.xml", "--states", "20"];
    all.extend(args);
    place.run(&all)
}

fn place() -> Place {
    let place = Place::new();
    place.write("rod.xml", MODEL);
    place
}

/// The table as text, page and JSON; each check with all of its fields; exit code 0.
#[test]
fn a_model_agrees() {
    let place = place();
    let done = check(&place, &[]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(done.stdout.starts_with("rod: all 13 checks against MuJoCo 4.0.0 pass"), "{}", done.stdout);
    assert!(done.stdout.contains("out/rod-crosscheck/crosscheck.html"), "{}", done.stdout);
    assert_eq!(place.names("out/rod-crosscheck"), ["crosscheck.html", "crosscheck.json", "crosscheck.txt"]);
    let done = check(&place, &["--json", "--seed", "3"]);
    assert_eq!((done.code, done.stderr.as_str()), (0, ""));
    let v = json(&done);
    assert_eq!((&v["failed"], &v["seed"], &v["states"]), (&0.into(), &3.into(), &20.into()));
    let checks = v["checks"].as_array().unwrap();
    assert_eq!(checks.len(), 13);
    for c in checks {
        for field in ["ours", "mujoco", "abs_error", "rel_error", "threshold"] {
            assert!(c[field].is_f64(), "{field} in {c}");
        }
        assert!(c["quantity"].is_string() && c["pass"].as_bool() == Some(true), "{c}");
        assert!(c.as_object().unwrap().contains_key("reason"));
    }
}

/// A fault from the command line: exit code 1, and the quantity is named with its place.
#[test]
fn slow_a_fault_is_named() {
    let place = place();
    for (fault, named) in [
        ("mass:rod*1.01", "masses (`rod`)"),
        ("com:rod+0,0.001,0", "centres of mass of the bodies (`rod`)"),
        ("axis:rod=1,0,0", "axes of the joints (`rod`)"),
    ] {
        let done = check(&place, &["--inject", fault]);
        assert_eq!(done.code, 1, "{fault}: {}", done.stdout);
        assert!(done.stderr.contains(named), "{fault}: {}", done.stderr);
        assert!(done.stderr.contains("inverse dynamics"), "{fault}: {}", done.stderr);
        assert!(done.stdout.contains("FAIL"), "{fault}: {}", done.stdout);
    }
}

/// The same through a second file.
#[test]
fn slow_a_changed_file_is_named() {
    let place = place();
    place.write("heavier.xml", &MODEL.replace("mass=\"1.5\"", "mass=\"1.515\""));
    let done = check(&place, &["--against", "heavier.xml"]);
    assert_eq!(done.code, 1, "{}", done.stdout);
    assert!(done.stderr.contains("masses (`rod`)"), "{}", done.stderr);
    place.write("moved.xml", &MODEL.replace("axis=\"0 1 0\"", "axis=\"0 0 1\""));
    let done = check(&place, &["--against", "moved.xml"]);
    assert!(done.stderr.contains("axes of the joints (`rod`)"), "{}", done.stderr);
}

/// Bad input is told where, exits 2, and leaves what was there.
#[test]
fn slow_bad_input_is_told() {
    let place = place();
    assert_eq!(check(&place, &[]).code, 0);
    let hinge = r#"<joint name="hinge" type="hinge" axis="0 1 0"/>"#;
    assert!(MODEL.contains(hinge));
    place.write("welded.xml", &MODEL.replace(hinge, ""));
    let before = place.files("out");
    for (args, words) in [
        (vec!["--inject", "mass:rd*1.01"], "unknown link `rd`; did you mean `rod`?"),
        (vec!["--inject", "mass:rod"], "`mass:rod` is no fault; allowed: mass:LINK*FACTOR"),
        (vec!["--inject", "axis:box=0,0,1"], "the joint of `box` has no axis to turn"),
        (vec!["--states", "0"], "allowed: a whole number from 1 to 100000"),
        (vec!["--against", "none.xml"], "none.xml"),
        (
            vec!["--against", "none.fbx"],
            "none.fbx: cannot compare this; allowed: a scene or character (.ron)",
        ),
        (vec!["--against", "welded.xml"], "ours has 2 moving joints, MuJoCo's 1"),
    ] {
        let args: Vec<&str> = args;
        let done = if args[0] == "--states" {
            place.run(&["crosscheck", "rod.xml", args[0], args[1]])
        } else {
            check(&place, &args)
        };
        assert_eq!(done.code, 2, "{args:?}: {}", done.stderr);
        assert!(done.stderr.contains(words), "{args:?}: {}", done.stderr);
    }
    let with = |from: &str, to: &str| place.write("bad.xml", &MODEL.replace(from, to));
    for (from, to, words) in [
        ("<freejoint name=\"root\"/>", "<freejoint name=\"root\"/><flea/>", "flea"),
        ("mass=\"1.5\"", "mass=\"-1.5\"", "-1.5"),
        ("</worldbody>", "</worldbody><actuator><motor name=\"m\"/></actuator>", "motor"),
        ("</worldbody>", "<include file=\"bad.xml\"/></worldbody>", "include"),
    ] {
        with(from, to);
        let done = place.run(&["crosscheck", "bad.xml"]);
        assert_eq!(done.code, 2, "{to}: {}", done.stderr);
        assert!(done.stderr.contains(words) && done.stderr.contains("bad.xml:"), "{to}: {}", done.stderr);
    }
    assert!(place.files("out") == before);
}

/// Without Python the message says what is needed and why.
#[test]
fn no_python_is_told() {
    let place = place();
    let nothing = [("CONTRAPPOSTO_PYTHON", "no-such-python"), ("CONTRAPPOSTO_CACHE", "empty-cache")];
    let done = place.run_with(&["crosscheck", "rod.xml"], &nothing);
    assert_eq!(done.code, 1, "{}", done.stderr);
    assert!(done.stderr.contains("no Python found: looked for no-such-python"), "{}", done.stderr);
    assert!(done.stderr.contains("CONTRAPPOSTO_PYTHON"), "{}", done.stderr);
    assert!(!place.at("out").exists());
}

/// The body of a character goes out as MJCF and comes back the same.
#[test]
fn mjcf_out_and_in_again() {
    let place = place();
    let done = place.run(&["convert", "rod.xml", "again.xml"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(done.stdout.contains("2 joints, 1 antagonists"), "{}", done.stdout);
    let done = place.run(&["crosscheck", "again.xml", "--dynamics-only", "--states", "20"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let done = place.run(&["convert", "rod.xml", "again.xml", "--rate", "30"]);
    assert_eq!(done.code, 2, "{}", done.stderr);
}

/// `inspect` answers for a model that others refuse, with what they would leave out; their refusal says it and offers the option.
#[test]
fn a_model_with_actuators_is_inspected_and_refused() {
    let place = place();
    let more = "</worldbody><actuator><motor name=\"m\" joint=\"hinge\"/></actuator>";
    place.write("driven.xml", &MODEL.replace("</worldbody>", more));
    let done = place.run(&["inspect", "driven.xml"]);
    assert_eq!((done.code, done.stderr.as_str()), (0, ""));
    for words in
        ["rod: 2 links, 7 degrees of freedom", "not read, and makes forces: actuator (1)", "driven.xml:12"]
    {
        assert!(done.stdout.contains(words), "`{words}` is not in\n{}", done.stdout);
    }
    let done = place.run(&["inspect", "driven.xml", "--json"]);
    let v = json(&done);
    assert_eq!((&v["kind"], &v["dynamics_only"]), (&"model".into(), &true.into()));
    let refused = place.run(&["convert", "driven.xml", "out.xml"]);
    assert_eq!(refused.code, 2, "{}", refused.stderr);
    for words in ["`rod` (2 links, 7 degrees of freedom", "actuator (1)", "--dynamics-only", "driven.xml:12"]
    {
        assert!(refused.stderr.contains(words), "`{words}` is not in\n{}", refused.stderr);
    }
    let done = place.run(&["convert", "driven.xml", "out.xml", "--dynamics-only"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
}
