//! Characters as files: what is written is read back, and every fault is named at its place.

use std::path::Path;

use bodies::Character;
use bodies::anthropometry::human::human;
use scenes::character_file::{human_text, parse, read, write};
use scenes::{SceneError, Source};

fn human_path() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("characters/human.ron")
}

/// The committed figure is what its maker makes.
#[test]
fn human_ron_is_made_by_its_maker() {
    let committed = std::fs::read_to_string(human_path()).unwrap();
    assert!(
        committed == human_text(),
        "run: cargo run --release -p scenes --example make_human > scenes/characters/human.ron"
    );
}

/// Largest difference between two characters of the same structure.
fn difference(a: &Character, b: &Character) -> f64 {
    let mut d: f64 = 0.0;
    let mut see = |x: f64, y: f64| d = d.max((x - y).abs());
    for (x, y) in a.bodies.iter().zip(&b.bodies) {
        see(x.mass, y.mass);
        (x.com - y.com).iter().for_each(|&e| see(e, 0.0));
        (x.inertia - y.inertia).iter().for_each(|&e| see(e, 0.0));
        assert_eq!(x.shapes.len(), y.shapes.len());
    }
    a.rest.iter().zip(&b.rest).for_each(|(&x, &y)| see(x, y));
    for (x, y) in a.skeleton.links().iter().zip(b.skeleton.links()) {
        assert_eq!((&x.name, x.parent, x.limits.is_some()), (&y.name, y.parent, y.limits.is_some()));
        see((x.parent_from_zero.inverse() * y.parent_from_zero).translation.vector.norm(), 0.0);
        see((x.parent_from_zero.inverse() * y.parent_from_zero).rotation.angle(), 0.0);
    }
    for (x, y) in a.skeleton.sites().iter().zip(b.skeleton.sites()) {
        assert_eq!((&x.name, x.link), (&y.name, y.link));
        see((x.at - y.at).norm(), 0.0);
    }
    assert_eq!(a.skeleton.limbs(), b.skeleton.limbs());
    assert_eq!(a.skeleton.parts(), b.skeleton.parts());
    assert_eq!((&a.contacts, &a.classes, &a.name), (&b.contacts, &b.classes, &b.name));
    d
}

#[test]
fn writing_and_reading_is_the_identity_to_the_digits_written() {
    let (made, _) = human();
    let back = read(&human_path()).unwrap();
    let d = difference(&made, &back);
    assert!(d < 1e-6, "{d}"); // 5e-7 seen
    assert!((back.mass() - 75.0).abs() < 1e-6, "{}", back.mass());
    let text = write(&back, "");
    let again = parse(&Source::new("again.ron", text.clone())).unwrap();
    assert_eq!(write(&again, ""), text);
}

const SMALL: &str = r#"Character(
    name: "rod",
    links: [
        Link(
            name: "base", joint: Free, class: Root,
            mass_kg: 1, inertia_kg_m2: (1, 1, 1, 0, 0, 0),
        ),
        Link(
            name: "arm", parent: "base", joint: Hinge(1, 0, 0), class: Other,
            limits_deg: Hinge(-10, 90),
            mass_kg: 1, inertia_kg_m2: (1, 1, 1, 0, 0, 0),
            shapes: [Capsule(a_m: (0, 0, 0), b_m: (0, 1, 0), radius_m: 0.1)],
        ),
    ],
    sites: [Site(name: "tip", link: "arm", at_m: (0, 1, 0))],
    contacts: ["tip"],
    parts: {"all": ["base", "arm"]},
    rest: (root_m: (0, 1, 0), joints_deg: {"arm": 30}),
)
"#;

fn fault(from: &str, to: &str) -> SceneError {
    assert!(SMALL.contains(from), "{from}");
    parse(&Source::new("rod.ron", SMALL.replacen(from, to, 1))).unwrap_err()
}

#[test]
fn the_small_character_is_right() {
    let c = parse(&Source::new("rod.ron", SMALL)).unwrap();
    assert_eq!(c.skeleton.nv(), 7);
    assert!((c.rest[7] - 30f64.to_radians()).abs() < 1e-15);
}

/// Each fault: what stands in the file, its place, and words of the message.
#[test]
fn every_fault_is_named_at_its_place() {
    for (from, to, place, words) in [
        (
            "parent: \"base\"",
            "parent: \"bse\"",
            (9, 34),
            "unknown parent `bse` in Link \"arm\"; did you mean `base`?",
        ),
        ("parent: \"base\"", "parent: \"arm\"", (9, 34), "the parents form a circle: `arm` → `arm`"),
        (
            "name: \"base\", ",
            "name: \"base\", parent: \"arm\", ",
            (5, 35),
            "the parents form a circle: `base` → `arm` → `base`",
        ),
        ("parent: \"base\", ", "", (8, 9), "`arm` has no parent, but `base` is the root already"),
        ("name: \"arm\"", "name: \"base\"", (9, 19), "two links are called `base`"),
        ("Hinge(-10, 90)", "Hinge(90, -10)", (10, 25), "the limits of `arm` run from 90° to -10°"),
        ("Hinge(-10, 90)", "Hinge(NaN, 90)", (10, 25), "run from NaN°"),
        (
            "Hinge(-10, 90)",
            "Ball(axes: ((1,0,0),(0,1,0),(0,0,1)), swing_1: (0,1), swing_2: (0,1), twist: (0,1))",
            (10, 25),
            "do not fit its joint",
        ),
        ("mass_kg: 1, ", "mass_kg: 0, ", (6, 22), "link `base` has a mass of 0 kg; it must be positive"),
        ("mass_kg: 1, ", "mass_kg: -2.5, ", (6, 22), "a mass of -2.5 kg"),
        ("mass_kg: 1, ", "mass_kg: NaN, ", (6, 22), "a mass of NaN kg"),
        ("(1, 1, 1, 0, 0, 0)", "(1, 1, 5, 0, 0, 0)", (6, 40), "at most the sum of the other two"),
        ("(1, 1, 1, 0, 0, 0)", "(1, 1, inf, 0, 0, 0)", (6, 40), "not finite"),
        ("Hinge(1, 0, 0)", "Hinge(0, 0, 0)", (9, 49), "the joint axis of `arm` is zero"),
        (
            "link: \"arm\"",
            "link: \"amr\"",
            (15, 37),
            "unknown link `amr` in Site \"tip\"; did you mean `arm`?",
        ),
        (
            "contacts: [\"tip\"]",
            "contacts: [\"top\"]",
            (16, 16),
            "unknown site `top` in contacts; did you mean `tip`?",
        ),
        ("[\"base\", \"arm\"]", "[\"base\", \"leg\"]", (17, 29), "unknown link `leg` in part \"all\""),
        (
            "{\"arm\": 30}",
            "{\"elbow_r\": 30}",
            (18, 44),
            "unknown joint `elbow_r` in rest; known are `base`, `arm`",
        ),
        ("{\"arm\": 30}", "{\"arm\": (1, 2, 3)}", (18, 44), "which takes one angle in degrees"),
        ("radius_m: 0.1", "radius_m: 0", (12, 72), "a radius_m of 0 m; sizes must be positive"),
        ("at_m: (0, 1, 0)", "at_m: (0, NaN, 0)", (15, 54), "NaN is not a finite number"),
        ("mass_kg: 1, ", "mas_kg: 1, ", (6, 13), "unknown field `mas_kg` of `Link`; did you mean `mass_kg`?"),
        ("joint: Free", "joint: Fre", (5, 34), "unknown word `Fre` of `joint`; did you mean `Free`?"),
        ("mass_kg: 1, ", "mass_kg: \"one\", ", (6, 22), "Expected float"),
    ] {
        let e = fault(from, to);
        assert!(e.message.contains(words), "{to}\n{e}\nwanted: {words}");
        assert_eq!(e.place, Some(place), "{to}\n{e}");
        assert!(e.to_string().contains("\n  --> rod.ron:"), "{e}");
    }
}

#[test]
fn absurd_counts_are_refused() {
    let link = "Link(name: \"a\", joint: Free, class: Root),";
    let text = format!("Character(name: \"many\", links: [{}])", link.repeat(100_000));
    let e = parse(&Source::new("many.ron", text)).unwrap_err();
    assert!(e.message.contains("100000 links; a character has at most 2000"), "{e}");
}

#[test]
fn broken_files_are_refused() {
    assert!(read(Path::new("/nowhere/rod.ron")).unwrap_err().to_string().contains("cannot read the file"));
    for n in 0..SMALL.trim_end().len() {
        let cut = parse(&Source::new("cut.ron", &SMALL[..n]));
        assert!(cut.unwrap_err().place.is_some(), "{n}");
    }
}
