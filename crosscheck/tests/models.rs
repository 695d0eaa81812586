//! Verdicts on models that have little to compare, or names of our own: small files, each of which once failed wrongly.

use std::path::{Path, PathBuf};

use crosscheck::{CrossCheck, Options, run};

fn case(name: &str) -> PathBuf {
    support::shared(&format!("cases/models/{name}"))
}

fn check(path: &Path, states: usize, seed: u64) -> CrossCheck {
    let options = Options { dynamics_only: true, states, seed, ..Options::default() };
    run(path, &options, &mut |_| {}).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn passes(path: &Path, states: usize, seed: u64) -> CrossCheck {
    let cross = check(path, states, seed);
    let table = crosscheck::report::text(&cross);
    assert_eq!(cross.failed(), 0, "{}, seed {seed}:\n{table}", path.display());
    assert!(!cross.checks.is_empty() && cross.checks.iter().all(|c| !c.at.is_empty()), "{table}");
    cross
}

const CASES: [&str; 9] = [
    "prism.urdf",
    "unnamed.xml",
    "slide_arm.xml",
    "mujoco_tag.urdf",
    "refroot.xml",
    "grouprange.xml",
    "gazebo_text.urdf",
    "transmission_text.urdf",
    "zero_sphere.urdf",
];

/// Quantities that are zero on both sides, bodies without names, rotor inertia on a slide, a URDF with words for MuJoCo.
#[test]
fn slow_the_cases_agree_over_many_states_and_over_one() {
    for name in CASES {
        passes(&case(name), 1000, 1);
        for seed in 2..6 {
            passes(&case(name), 1, seed);
        }
    }
}

/// What a model has none of is said, and is no success.
#[test]
fn slow_what_there_is_none_of_is_said() {
    let prism = passes(&case("prism.urdf"), 20, 1);
    assert_eq!(prism.nothing, ["positions of the joints: no joint is a hinge"]);
    let crate_ = check(&case("single_link.urdf"), 20, 1);
    assert_eq!((crate_.checks.len(), crate_.failed()), (0, 0));
    assert_eq!(crate_.nothing, ["everything: the model has no degrees of freedom"]);
    let said = "nothing to compare: everything: the model has no degrees of freedom\n";
    assert_eq!(crosscheck::report::text(&crate_), said);
    assert!(crosscheck::report::html(&crate_).unwrap().contains("<b>nothing to compare</b>"));
}

/// A body without a name has one of ours, even where another body of the file is called so; `ground` is a name as any other.
#[test]
fn slow_names_of_ours_do_not_hide_bodies() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("names.xml");
    let text = r#"<mujoco><compiler fusestatic="true"/><worldbody>
        <body name="body4" pos="0 0 1"><freejoint/><geom size=".1"/>
          <body pos=".3 0 0"><joint axis="0 1 0"/><geom size=".05" pos=".1 0 0"/>
            <frame pos="0 .1 0"><body><geom size=".04" pos="0 .1 0"/></body></frame>
            <body pos=".2 0 .1"><joint name="knee" axis="0 0 1"/><geom size=".06" pos=".1 .1 0"/></body>
          </body>
          <body name="ground" pos="-.3 0 0"><joint axis="1 0 0"/><geom size=".07" pos="0 .1 0"/></body>
        </body></worldbody></mujoco>"#;
    std::fs::write(&path, text).unwrap();
    let cross = passes(&path, 100, 1);
    assert_eq!(cross.checks.len(), 13);
}

/// And the comparison still fails where one body is heavier.
#[test]
fn slow_another_mass_of_a_body_without_a_name_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("heavier.xml");
    let text = std::fs::read_to_string(case("unnamed.xml")).unwrap();
    std::fs::write(&path, text.replace("size=\".1\"", "size=\".1001\"")).unwrap();
    let options = Options { states: 20, against: Some(path), ..Options::default() };
    let cross = run(&case("unnamed.xml"), &options, &mut |_| {}).unwrap();
    let found = cross.checks.iter().find(|c| !c.pass).unwrap();
    assert_eq!((found.quantity.as_str(), found.at.as_str()), ("masses", "`body1`"));
}
