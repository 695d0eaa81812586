//! Edits of clips by text, as `--edit` gives them: through a fit, and tension over time.

use takes::{Ask, Input, Take, TakeError, open};

fn walk(edits: &[&str]) -> Result<Take, TakeError> {
    let edits = edits.iter().map(|e| (*e).to_owned()).collect();
    open(support::shared("mocap/bvh/16_16.bvh"), &Ask { edits, ..Ask::default() })
}

/// Edits that change nothing give the clip back to the bit; those that do are in the log in order.
#[test]
fn edits_are_applied_in_order() {
    let plain = walk(&[]).unwrap();
    let still =
        walk(&["Succession(offset_s: 0)", "Amplitude(factor: 1)", "ExtentShoulder(extent: 1)"]).unwrap();
    assert!(plain.asked.clip == still.asked.clip && still.log.clip_changes().is_empty());
    let both = walk(&[
        "Warp(times_s: [(0, 0), (2, 3)])",
        "Amplitude(factor: 0.5, span_s: (1, 4), parts: [\"arm_r\"])",
    ])
    .unwrap();
    assert_eq!(both.log.edits(), ["warp", "amplitude"]);
    assert!((both.asked.clip.duration_s() - plain.asked.clip.duration_s() - 1.0).abs() < 0.01);
    let change = &both.log.clip_changes()[1];
    assert!(change.from_s > 0.99 && change.to_s < 4.01, "{change}");
    let said = both.log.to_string();
    assert!(said.contains("keys per second and joint"), "{said}");
}

/// Faults are told at their line and column in the text given.
#[test]
fn faults_have_a_place() {
    for (edits, words) in [
        (&["Succession(ofset_s: 0.1)"][..], "--edit:1:12"),
        (&["Amplitude(factor: 1)", "Amplitud(factor: 1)"], "--edit (2):1:1"),
        (&["Amplitude(factor: 0.5, fit: (deg: -1))"], "--edit:1:29"),
        (&["Amplitude(\n  factor: \"much\")"], "--edit:2:"),
        (&["Amplitude(factor: [0.5, 1])"], "has a value for each pose or repetition"),
        (&["Amplitude(factor: 0.5, on: \"wave\")"], "this motion has none"),
        (&["ByExample(model: \"no.edit\")"], "--edit:1:18"),
        (&["Tension()"], "either `factor` or `absolute`"),
    ] {
        let e = walk(edits).expect_err(words).to_string();
        assert!(e.contains(words) && e.contains("--edit"), "{words}: {e}");
    }
}

/// Tension over time reaches the pass; a retiming takes it along; of legs that stand by themselves it is refused.
#[test]
fn tension_reaches_the_pass() {
    let take =
        walk(&["Tension(parts: [\"arm_r\"], factor: 4, span_s: (1, 2))", "Warp(times_s: [(0, 0), (2, 3)])"])
            .unwrap();
    let s = &take.character().skeleton;
    let elbow = s.limb("arm_r").unwrap().lower;
    let dense = take.pass().setup.dense;
    let joint = dense.joint(elbow).expect("a joint with a tension of its own");
    let ends: Vec<f64> = [1.0, 2.0].iter().map(|t| take.asked.times.at(*t)).collect();
    assert_eq!(joint.tension, [(0.0, 1.0), (ends[0], 4.0), (ends[1], 1.0)]);
    assert!(dense.joint(s.limb("arm_l").unwrap().lower).is_none());
    assert!(walk(&["Tension(parts: [\"leg_l\"], factor: 2)"]).is_ok(), "the root is pinned");
    let free = Ask {
        edits: vec!["Tension(parts: [\"leg_l\"], factor: 2)".into()],
        overrides: takes::Overrides { root: Some(takes::overrides::RootChoice::Free), ..Default::default() },
        ..Ask::default()
    };
    let e = open(support::shared("mocap/bvh/16_16.bvh"), &free).unwrap_err().to_string();
    assert!(e.contains("of legs that stand the balance decides"), "{e}");
}

/// After a clip edit, or with a span, an edit of a script acts on what was sampled.
#[test]
fn a_script_is_edited_in_any_order() {
    let with = |edits: &str| {
        let human = support::scene("characters/human.ron");
        let pose = |deg: f64| format!("Pose(duration_s: 0.5, set_deg: {{ \"elbow_r\": {deg} }})");
        let poses = [pose(90.0), pose(10.0)].join(", ");
        let script = format!("Action(name: \"a\", cycles: [Cycle(repetitions: 3, poses: [{poses}])])");
        let ron = format!("Scene(character: {human:?}, script: [{script}], edits: [{edits}])");
        open(Input::Text { ron, base: support::scene("") }, &Ask::default()).unwrap_or_else(|e| panic!("{e}"))
    };
    let take = with("Warp(times_s: [(0, 0), (1, 1.5)]), Amplitude(factor: 0.5)");
    assert_eq!(take.log.edits(), ["warp", "amplitude"]);
    assert!(take.log.clip_changes().iter().any(|c| take.log.edits()[c.edit] == "amplitude"));
    let spanned = with("Amplitude(factor: 0.5, span_s: (0, 1.5))");
    assert!(
        spanned
            .log
            .clip_changes()
            .iter()
            .any(|c| spanned.log.edits()[c.edit] == "amplitude" && c.to_s <= 1.5)
    );
}

/// A blocking is a scene that opens, with no more than four key poses a second, and plays near the clip.
#[test]
fn a_blocking_is_a_scene() {
    let take = walk(&[]).unwrap();
    let made = takes::blocking::block(&take, "walk-character.ron", "16_16.bvh").unwrap();
    assert!((made.poses - 1) as f64 <= 4.0 * made.duration_s, "{} poses", made.poses);
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("walk-character.ron"), &made.character).unwrap();
    let input = Input::Text { ron: made.scene.clone(), base: dir.path().to_owned() };
    let script = open(input, &Ask::default()).unwrap_or_else(|e| panic!("{e}\n{}", made.scene));
    assert!((script.asked.clip.duration_s() - made.duration_s).abs() < 0.01);
    let errors = motion::metrics::joint_errors(&script.asked.clip, &take.asked.clip);
    let rms = motion::metrics::joint_rms_deg(&errors);
    assert!(rms < made.rms_deg + 0.2 && made.rms_deg < 6.0, "{rms} {}", made.rms_deg);
}
