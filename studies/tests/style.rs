//! Style transfers on captured motion: what comes, what stays. `examples/style_transfers.rs` prints the whole table.

use std::collections::BTreeMap;
use std::sync::Arc;

use studies::style::measure;
use studies::style::measures::{Content, Measure};
use studies::style::pairs::PAIRS;
use takes::styles::style::{Representation, Transfer};
use takes::styles::{Find, styled};
use takes::{Ask, Input, Take};

fn find() -> Find {
    Find {
        count: None,
        variance: 0.95,
        representation: Representation::Positions,
        merge: Vec::new(),
        names: BTreeMap::new(),
    }
}

fn open(clip: &str) -> Take {
    takes::open(support::shared(&format!("mocap/{clip}")), &Ask::default()).unwrap()
}

/// Measures that do not close half of their gap, or not one way: `docs/STYLE_COMPONENTS.md` says why.
const NOT_REACHED: &[(&str, &[Measure])] = &[
    ("zombie, running", &[Measure::KneeLift]),
    ("walk, happy", &[Measure::Bounce]),
    ("happy walk, neutral", &[Measure::Bounce]),
    ("walk, dancing", &[Measure::ArmsForward]),
    ("dance, walking", &[Measure::ArmsForward]),
];

/// Styles come in all transfers of the paper but where it is said, and content stays in all: slip is at most 2 mm more among the rest.
#[test]
fn slow_styles_come_and_content_stays() {
    for pair in PAIRS {
        let (base, donor) = (open(pair.base), open(pair.donor));
        let outcome = measure(&base, &donor, pair.measures, &find(), pair.components).unwrap();
        let known = NOT_REACHED.iter().find(|k| k.0 == pair.name).map_or(&[][..], |k| k.1);
        for m in &outcome.moved {
            println!("{}: {} {:.0} % {:?}", pair.name, m.measure.word(), 100.0 * m.share(), m.values);
            assert!(m.comes() || known.contains(&m.measure), "{}: {m:?}", pair.name);
        }
        let lost = outcome.lost();
        assert!(lost.is_empty(), "{}: {lost:?}", pair.name);
        let [before, after] = outcome.content;
        assert!(after.slip_mm < before.slip_mm + 0.5, "{}: {after:?}", pair.name); // as much in all
    }
}

/// Components of one walk and a sneak go into the walk of somebody else, who was not decomposed.
#[test]
fn slow_a_clip_that_was_not_decomposed_takes_the_style() {
    let (walk, sneak, other) = (open("bvh/16_16.bvh"), open("bvh/17_03.bvh"), open("bvh/02_01.bvh"));
    let set = Arc::new(find().set(&walk, &sneak, false).unwrap());
    let take = styled(&other, &set, &Transfer::of(&set, 1, 1.0), &BTreeMap::new()).unwrap();
    let of = |m: Measure| [m.of(&other), m.of(&take), m.of(&sneak)];
    let [before, after, donor] = of(Measure::TrunkPitch);
    let (was, is) = (Content::of(&other, &other), Content::of(&take, &other));
    println!("trunk {before:.1}° → {after:.1}° ({donor:.1}°); {was:?} → {is:?}\n{}", take.log);
    assert!((after - before) / (donor - before) > 0.5);
    assert!((is.step_m / was.step_m - 1.0).abs() < 0.15 && (is.path_m / was.path_m - 1.0).abs() < 0.15);
    assert!(is.cadence_hz == was.cadence_hz && is.slip_mm < was.slip_mm + 2.0);
}

/// A scene names a file of components: half of the style, and an error at its place where it cannot be.
#[test]
fn slow_a_scene_has_the_style_of_a_file() {
    let (walk, sneak) = (open("bvh/16_16.bvh"), open("bvh/17_03.bvh"));
    let set = find().set(&walk, &sneak, false).unwrap();
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("sneak.style"), formats::style_file::bytes(&set)).unwrap();
    std::fs::write(dir.path().join("broken.style"), "no zip").unwrap();
    let body = walk.body.character.clone();
    let text = scenes::character_file::write(&body, "");
    std::fs::write(dir.path().join("body.ron"), text).unwrap();
    let clip = support::shared("mocap/bvh/16_16.bvh");
    let scene = |edit: &str| {
        let ron = format!(
            "Scene(character: \"body.ron\", motion: Clip({:?}), edits: [{edit}], root: Pinned)",
            clip.display().to_string()
        );
        takes::open(Input::Text { ron, base: dir.path().into() }, &Ask::default())
    };
    let take = scene("Style(components: \"sneak.style\", amount: 0.5)").unwrap();
    let [before, half, donor] = [&walk, &take, &sneak].map(|t| Measure::TrunkPitch.of(t));
    let share = (half - before) / (donor - before);
    assert!((0.35..0.65).contains(&share), "{share}");
    assert!(take.log.to_string().contains("aligned on how far"), "{}", take.log);
    assert!(take.files.iter().any(|f| f.ends_with("sneak.style")));
    let none = scene("Style(components: \"sneak.style\", amount: 0)").unwrap();
    let off = none.asked.clip.data().iter().zip(none.unedited.data()).map(|(a, b)| (a - b).abs());
    let off = off.fold(0.0, f64::max);
    assert!(off < 1e-9, "{off}");
    for (edit, why) in [
        ("Style(components: \"sneak.style\", amount: 2)", "an amount of 2; allowed: 0 to 1.5"),
        (
            "Style(components: \"sneak.style\", amount: 1, only: [9])",
            "there is no component 9; allowed: 1 to",
        ),
        (
            "Style(components: \"sneak.style\", amount: 1, from: \"17_30\")",
            "the set has no clip `17_30`; it is of 16_16 or 17_03",
        ),
        ("Style(components: \"sneak.style\", amount: 1, parts: [\"arm_l\"])", "applies to the whole body"),
        ("Style(components: \"broken.style\", amount: 1)", "not an .npz"),
        ("Style(components: \"none.style\", amount: 1)", "does not exist"),
        ("Style(components: \"sneak.style\", amount: 1, align: \"LeftUpLge\")", "did you mean `LeftUpLeg`?"),
    ] {
        let said = scene(edit).unwrap_err().to_string();
        assert!(said.contains(why) && said.contains("scene.ron:1:"), "{edit}: {said}");
    }
}
