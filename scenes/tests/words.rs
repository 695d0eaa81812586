//! Words: every name of every enumeration that a scene or a character may say is read where it may be said, whatever its case.

use std::fmt::Debug;

use bodies::JointClass;
use controllers::{GainBlend, Strategy};
use dynamics::RootName;
use edits::{Direction, Reference};
use motion::names::Word;
use motion::{CurveName, LimbKind, Timing};
use retarget::{MappingModel, PipelineStage, RefineDofs, RefineDofsName, SizeRatio, SizeRatioName};
use scenes::conditions::{Clock, GroundName, SoleName, ToesName};
use scenes::schema::{EditRon, GroundRon, MotionRon, RootRon, SceneRon, SolesRon, ToesRon};
use scenes::{Source, character_file};

/// Spellings of a name in RON, which has no hyphens in names.
fn spellings<W: Word>() -> Vec<(W, String)> {
    let names = W::WORDS.iter().map(|w| (w.0, w.1)).chain(W::ALIASES.iter().copied());
    let all = names.flat_map(|(value, name)| {
        [name.replace('-', "_"), name.replace('-', ""), value.identifier()].map(|text| (value, text))
    });
    all.collect()
}

fn scene(text: &str) -> SceneRon {
    let text = format!("Scene(character: \"human.ron\", {text})");
    Source::new("scene.ron", text.as_str()).parse().unwrap_or_else(|e| panic!("{text}: {e}"))
}

/// `within` has `WORD` where the name stands, with `data` behind it where it carries some.
fn check<W: Word + Debug>(within: &str, data: impl Fn(W) -> &'static str, read: impl Fn(SceneRon) -> W) {
    assert!(within.contains("WORD"));
    for (value, text) in spellings::<W>() {
        let whole = within.replace("WORD", &format!("{text}{}", data(value)));
        assert_eq!(read(scene(&whole)), value, "{whole}");
    }
}

fn none<W>(_: W) -> &'static str {
    ""
}

#[test]
fn a_scene_takes_every_word() {
    check::<Strategy>("balance: (without: [WORD])", none, |s| s.balance.without[0].0);
    check::<Timing>("properties: (timing: WORD)", none, |s| s.properties.timing.expect("a timing").0);
    check::<GainBlend>("physics: (blend: WORD)", none, |s| s.physics.blend.0);
    check::<Clock>("pushes: [Push(link: \"chest\", impulse_ns: 5, start_s: 0, clock: WORD)]", none, |s| {
        s.pushes[0].clock.0
    });
    let model = |s: SceneRon| match s.motion {
        Some(MotionRon::Retarget { model, stop_after, size, refine, .. }) => {
            (model, stop_after, size, refine)
        }
        _ => panic!("no motion"),
    };
    check::<MappingModel>("motion: Retarget(of: \"a\", model: WORD)", none, |s| model(s).0.0);
    check::<PipelineStage>("motion: Retarget(of: \"a\", stop_after: WORD)", none, |s| model(s).1.0);
    let fixed = |name| if name == SizeRatioName::Fixed { "(0.5)" } else { "" };
    check::<SizeRatioName>("motion: Retarget(of: \"a\", size: WORD)", fixed, |s| match model(s).2.0 {
        SizeRatio::Stride => SizeRatioName::Stride,
        SizeRatio::PerAxis => SizeRatioName::PerAxis,
        SizeRatio::Uniform => SizeRatioName::Uniform,
        SizeRatio::Fixed(_) => SizeRatioName::Fixed,
    });
    let links = |name| if name == RefineDofsName::Links { "([\"chest\"])" } else { "" };
    check::<RefineDofsName>("motion: Retarget(of: \"a\", refine: WORD)", links, |s| match model(s).3.0 {
        RefineDofs::RootHeight => RefineDofsName::RootHeight,
        RefineDofs::Root => RefineDofsName::Root,
        RefineDofs::RootAndLegs => RefineDofsName::RootAndLegs,
        RefineDofs::Links(_) => RefineDofsName::Links,
    });
    check::<Direction>("edits: [Succession(offset_s: 1, direction: WORD)]", none, |s| match s.edits[0] {
        EditRon::Succession { direction, .. } => direction.0,
        _ => panic!("another edit"),
    });
    check::<Reference>("edits: [Amplitude(factor: 1, reference: WORD)]", none, |s| match s.edits[0] {
        EditRon::Amplitude { reference, .. } => reference.0,
        _ => panic!("another edit"),
    });
    let handles = |name| if name == CurveName::Bezier { "(0.1, 0, 0.9, 1)" } else { "" };
    check::<CurveName>("properties: (curve: WORD)", handles, |s| s.properties.curve.unwrap().0.name());
    let budget = |name| match name {
        RootName::Assisted => "(force_n: 1, moment_nm: 2)",
        RootName::Fidelity => "(0.5)",
        RootName::Free | RootName::Pinned => "",
    };
    check::<RootName>("root: WORD", budget, |s| match s.root.0 {
        RootRon::Free => RootName::Free,
        RootRon::Assisted(_) => RootName::Assisted,
        RootRon::Pinned => RootName::Pinned,
        RootRon::Fidelity(_) => RootName::Fidelity,
    });
    let plane = |name| if name == GroundName::Plane { "(friction: 0.5)" } else { "" };
    check::<GroundName>("world: (ground: WORD)", plane, |s| match s.world.ground.0 {
        GroundRon::None => GroundName::None,
        GroundRon::Plane(_) => GroundName::Plane,
    });
    let pads = |name| if name == SoleName::Pads { "(heel: (travel_m: 0.01))" } else { "" };
    check::<SoleName>("physics: (soles: WORD)", pads, |s| match s.physics.soles.expect("soles").0 {
        SolesRon::Rigid => SoleName::Rigid,
        SolesRon::Pads(_) => SoleName::Pads,
    });
    let bend = |name| if name == ToesName::Bend { "()" } else { "" };
    check::<ToesName>("physics: (toes: WORD)", bend, |s| match s.physics.toes.expect("toes").0 {
        ToesRon::Welded => ToesName::Welded,
        ToesRon::Bend(_) => ToesName::Bend,
    });
}

/// What the writer writes is what the reader reads, for every class of joint and kind of limb.
#[test]
fn a_character_takes_every_word() {
    let character = character_file::parse(&Source::new("human.ron", character_file::human_text())).unwrap();
    for (class, text) in spellings::<JointClass>() {
        let mut changed = character.clone();
        changed.classes[1] = class;
        let written = character_file::write(&changed, "");
        let own = format!("class: {}", class.identifier());
        assert!(written.contains(&own), "{own}");
        let read =
            character_file::parse(&Source::new("a.ron", written.replace(&own, &format!("class: {text}"))));
        assert_eq!(read.unwrap().classes, changed.classes, "{text}");
    }
    let text = character_file::write(&character, "");
    for (kind, spelling) in spellings::<LimbKind>() {
        let own = format!("kind: {}", kind.identifier());
        let read =
            character_file::parse(&Source::new("a.ron", text.replace(&own, &format!("kind: {spelling}"))));
        let kinds = |c: &bodies::Character| c.skeleton.limbs().iter().map(|l| l.kind).collect::<Vec<_>>();
        assert_eq!(kinds(&read.unwrap()), kinds(&character), "{spelling}");
    }
}

/// A table names every value once, and no name or other spelling has two meanings.
#[test]
fn names_have_one_meaning() {
    fn one<W: Word + Debug>() {
        for (value, text) in spellings::<W>() {
            assert_eq!(W::find(&text), Ok(value), "{}", W::KIND);
        }
        for &(value, name, about) in W::WORDS {
            assert_eq!(value.word(), name);
            assert!(name == name.to_lowercase() && !about.is_empty(), "{name}");
        }
    }
    one::<Strategy>();
    one::<GainBlend>();
    one::<Clock>();
    one::<MappingModel>();
    one::<PipelineStage>();
    one::<SizeRatioName>();
    one::<RefineDofsName>();
    one::<Direction>();
    one::<Reference>();
    one::<CurveName>();
    one::<RootName>();
    one::<GroundName>();
    one::<JointClass>();
    one::<LimbKind>();
}

/// A timing may stand at every level of a script and at an insert, and is read there and nowhere else.
#[test]
fn every_level_of_a_script_takes_a_timing() {
    let within = |action: &str, cycle: &str, pose: &str, element: &str, insert: &str| {
        format!(
            "script: [(name: \"a\", {action} cycles: [({cycle} poses: [({pose} set_deg: {{\"x\": 1}}, elements: {{\"x\": ({element})}})])])], \
             inserts: [(name: \"b\", start_s: 0, {insert} set_deg: {{\"x\": 1}})]"
        )
    };
    let read = |s: &SceneRon| {
        let (action, insert) = (&s.script[0], &s.inserts[0]);
        let cycle = &action.cycles[0];
        let pose = &cycle.poses[0];
        [action.timing, cycle.timing, pose.timing, pose.elements["x"].timing, insert.timing]
            .map(|t| t.map(|t| t.0))
    };
    for level in 0..5 {
        for (value, word) in spellings::<Timing>() {
            let mut at = [""; 5];
            let text = format!("timing: {word},");
            at[level] = &text;
            let mut asked = [None; 5];
            asked[level] = Some(value);
            let [a, c, p, e, i] = at;
            let text = within(a, c, p, e, i);
            assert_eq!(read(&scene(&text)), asked, "{text}");
        }
    }
}
