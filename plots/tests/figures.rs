//! Figures of a sample body: nothing clipped, units on every axis, the same bytes twice, and no trace so
//! odd that a figure breaks.

mod sample;

use std::path::{Path, PathBuf};

use dynamics::{RootMode, Trace};
use plots::{Figure, StripOptions, StripRow, film_strip_with};

fn directory(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("plots").join(name);
    std::fs::create_dir_all(&path).unwrap();
    path
}

fn of_trace(trace: &Trace) -> Vec<(&'static str, Figure)> {
    let note = "bow: tension 1, root free";
    vec![
        ("joint_angles", plots::joint_angles(trace, note)),
        ("gains_and_torques", plots::gains_and_torques(trace, note)),
        ("contact_forces", plots::contact_forces(trace, note)),
        ("center_of_mass", plots::center_of_mass(trace, note)),
        ("momentum_residual", plots::momentum_residual(trace, note)),
    ]
}

fn strip(count: usize) -> Figure {
    let character = sample::human();
    let (plain, edited) = (sample::bow(&character, 0.0), sample::bow(&character, 0.2));
    let rows = [StripRow { label: "unedited", clip: &plain }, StripRow { label: "edited", clip: &edited }];
    let options = StripOptions { count, yaw_deg: Some(-50.0), ..StripOptions::default() };
    film_strip_with(&rows, &character, "bow: succession", &options)
}

fn figures() -> Vec<(&'static str, Figure)> {
    let character = sample::human();
    let clip = sample::bow(&character, 0.2);
    let walk = sample::walk(&character);
    let walking = [StripRow { label: "walk", clip: &walk }];
    let mut all = of_trace(&sample::trace(&character, &clip));
    all.push(("strip", strip(8)));
    let options = StripOptions { count: 6, ..StripOptions::default() };
    all.push(("walk", film_strip_with(&walking, &character, "a motion that travels", &options)));
    all
}

/// Same input, same bytes, SVG and PNG.
#[test]
fn figures_are_the_same_twice() {
    let (a, b) = (directory("a"), directory("b"));
    for ((name, one), (_, two)) in figures().into_iter().zip(figures()) {
        let (one, two) = (one.save(&a, name).unwrap(), two.save(&b, name).unwrap());
        for (x, y) in one.iter().zip(&two) {
            let (x, y) = (std::fs::read(x).unwrap(), std::fs::read(y).unwrap());
            assert!(x == y && x.len() > 1000, "{name}");
        }
    }
}

/// Nothing lies outside the page: no label is clipped.
#[test]
fn nothing_is_clipped() {
    for (name, figure) in figures() {
        for mark in &figure.marks {
            let [left, top, right, bottom] = Figure::bounds(mark);
            let inside =
                left >= -1.0 && top >= -1.0 && right <= figure.width + 1.0 && bottom <= figure.height + 1.0;
            assert!(inside, "{name}: {:?} on {} x {}", Figure::bounds(mark), figure.width, figure.height);
        }
    }
}

/// Every tag that opens closes, and every plot says its units.
#[test]
fn svg_is_well_formed_and_has_units() {
    for (name, figure) in figures() {
        let svg = figure.svg().unwrap();
        assert!(svg.trim_end().ends_with("</svg>"), "{name}");
        let mut open = Vec::new();
        for tag in svg.split('<').skip(1) {
            let tag = &tag[..tag.find('>').unwrap_or_else(|| panic!("{name}: {tag}"))];
            let word = tag.trim_start_matches('/').split([' ', '\n', '/']).next().unwrap();
            match (tag.starts_with('/'), tag.ends_with('/') || tag.starts_with(['?', '!'])) {
                (true, _) => assert_eq!(open.pop(), Some(word), "{name}"),
                (_, false) => open.push(word),
                _ => {}
            }
        }
        assert!(open.is_empty(), "{name}: {open:?}");
        let units: &[&str] = match name {
            "joint_angles" => &["degrees", "time (s)", "performed", "asked for"],
            "gains_and_torques" => &["N·m/rad", "N·m", "time (s)"],
            "contact_forces" => &["body weight", "time (s)"],
            "center_of_mass" => &["cm", "mm", "time (s)"],
            "momentum_residual" => &["% of body weight", "time (s)"],
            "strip" => &["unedited", "edited", "0.00 s"],
            _ => &["walk"],
        };
        for unit in units {
            assert!(svg.contains(unit), "{name}: {unit}");
        }
    }
}

/// Short, pinned, airborne, groundless and broken traces draw something.
#[test]
fn odd_traces_do_not_break_a_figure() {
    let character = sample::human();
    let clip = sample::bow(&character, 0.0);
    let whole = sample::trace(&character, &clip);
    let mut short = sample::trace(
        &character,
        &motion::Clip::new(clip.skeleton.clone(), clip.rate_hz, clip.pose(0).to_vec()),
    );
    short.contacts.clear();
    let mut pinned = whole.clone();
    pinned.root = RootMode::Pinned;
    let mut airborne = whole.clone();
    airborne.contacts.clear();
    let mut groundless = airborne.clone();
    groundless.ground_m = None;
    let mut broken = whole.clone();
    let middle = broken.q.len() / 2;
    broken.q[middle..].fill(f64::NAN);
    broken.torque[100..].fill(f64::NAN);
    broken.momentum[60..].fill(f64::INFINITY);
    for trace in [short, pinned, airborne, groundless, broken] {
        for (name, figure) in of_trace(&trace) {
            assert!(figure.svg().unwrap().contains("</svg>"), "{name}");
        }
    }
}

/// Eleven figures fit a page, each with its time.
#[test]
fn strips_hold_eleven_figures() {
    let figure = strip(11);
    assert!(figure.width <= 1600.0 && figure.height > 300.0);
    let svg = figure.svg().unwrap();
    assert_eq!(svg.matches(" s\n").count().max(svg.matches(" s<").count()), 22, "eleven times in two rows");
}
