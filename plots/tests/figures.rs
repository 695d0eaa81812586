//! Figures of a sample body: nothing clipped, units on every axis, the same bytes twice, and no trace so
//! odd that a figure breaks.

mod drawn;
mod sample;

use std::path::{Path, PathBuf};

use dynamics::{AnalysisOptions, FloorChoice, GroundForces, RootMode, Trace, analyze};
use motion::Vec3;
use motion::smooth::Smoothing;
use plots::figure::Mark;
use plots::{
    Excerpt, Figure, ForceSource, ForceSourceKind, Spoke, StripOptions, StripRow, View, contact_overlay,
    film_strip_with, graded_residual, push_map, style,
};

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
        ("momenta", plots::momenta(trace, note)),
        ("joint_torques", plots::joint_torques(trace, &[], note)),
        ("energies", plots::energies(trace, note)),
        ("residual", {
            let clock = Excerpt::whole(trace).clock();
            graded_residual(&trace.residual(), clock, 735.0, "what the pin did", note)
        }),
        ("contact", contact_overlay(&sources(trace), 735.0, note)),
    ]
}

/// What the trace measured, its motion requires and penalty contact gives; the latter two where they can
/// be told.
fn sources(trace: &Trace) -> Vec<ForceSource> {
    let source = |kind, forces| ForceSource { kind, label: format!("{kind:?}"), forces };
    let mut out = vec![source(ForceSourceKind::Measured, GroundForces::measured(trace))];
    let ground = trace.ground_m.map_or(FloorChoice::None, FloorChoice::At);
    let options = AnalysisOptions { smoothing: Smoothing::Off, ground, ..AnalysisOptions::default() };
    if let Ok(a) = analyze(&trace.character, &trace.clip(), &options) {
        out.push(source(ForceSourceKind::Required, GroundForces::required(&a)));
        if let Some((given, _)) = GroundForces::given(&trace.character, &a, 0.0015).unwrap() {
            out.push(source(ForceSourceKind::Given, given));
        }
    }
    // another engine, another rate
    let mut other = GroundForces::measured(trace);
    other.rate_hz *= 0.5;
    out.push(source(ForceSourceKind::Mujoco, other));
    out
}

fn strip(count: usize) -> Figure {
    let character = sample::human();
    let (plain, edited) = (sample::bow(&character, 0.0), sample::bow(&character, 0.2));
    let rows = [StripRow::new("unedited", &plain), StripRow::new("edited", &edited)];
    let options = StripOptions { count, view: View::degrees(-50.0).unwrap(), ..StripOptions::default() };
    film_strip_with(&rows, &character, "bow: succession", &options)
}

/// A map of some directions, three times the limit at most, in one of them nothing known.
fn spokes(count: usize) -> Vec<Spoke> {
    let of = |i: usize| {
        let deg = 360.0 * i as f64 / count as f64;
        let limit = 40.0 + 10.0 * (2.0 * deg.to_radians()).sin().abs();
        let survived = if i == 5 { f64::NAN } else { limit * (0.2 + 2.8 * deg / 360.0) };
        Spoke { deg, survived, limit }
    };
    (0..count).map(of).collect()
}

/// A newton-second is as long in every direction; forward is up, left on the left.
#[test]
fn a_map_is_to_scale() {
    let blue = |spokes: &[Spoke]| -> Vec<[f64; 4]> {
        let marks = push_map(spokes, "").marks;
        let discs = marks.into_iter().filter(
            |m| matches!(m, Mark::Fill { points, color } if points.len() == 20 && *color == style::BLUE),
        );
        discs.map(|m| Figure::bounds(&m)).collect()
    };
    let spokes: Vec<Spoke> = [(0.0, 20.0), (90.0, 40.0), (180.0, 30.0), (270.0, 10.0)]
        .map(|(deg, survived)| Spoke { deg, survived, limit: 25.0 })
        .to_vec();
    let at: Vec<[f64; 2]> =
        blue(&spokes).iter().map(|b| [0.5 * (b[0] + b[2]), 0.5 * (b[1] + b[3])]).collect();
    let [forward, left, back, right] = at[..] else { panic!("{at:?}") };
    assert!(forward[1] < back[1] && left[0] < right[0], "{at:?}");
    let (across, along) = (right[0] - left[0], back[1] - forward[1]);
    // both are 50 N·s
    assert!((across - along).abs() < 1e-6 && across > 200.0, "{at:?}");
    assert!((left[1] - right[1]).abs() < 1e-6 && (forward[0] - back[0]).abs() < 1e-6, "{at:?}");
    let center = [forward[0], left[1]];
    assert!(((center[0] - left[0]) / across - 0.8).abs() < 1e-6, "{at:?}");
    assert!(((center[1] - forward[1]) / along - 0.4).abs() < 1e-6, "{at:?}");
}

fn figures() -> Vec<(&'static str, Figure)> {
    let character = sample::human();
    let clip = sample::bow(&character, 0.2);
    let walk = sample::walk(&character);
    let walking = [StripRow::new("walk", &walk)];
    let mut all = of_trace(&sample::trace(&character, &clip));
    all.push(("strip", strip(8)));
    let options = StripOptions { count: 6, ..StripOptions::default() };
    all.push(("walk", film_strip_with(&walking, &character, "a motion that travels", &options)));
    let slope = [Vec3::new(0.0, 1.0, 0.2).normalize()];
    let tilted = [StripRow::new("walk", &walk).on(&slope)];
    all.push(("slope", film_strip_with(&tilted, &character, "on a slope", &options)));
    all.push(("push", push_map(&spokes(16), "stand: pushed at its centre of mass")));
    all.push(("push_one", push_map(&spokes(1), "")));
    all.push(("push_many", push_map(&spokes(120), &"a long note ".repeat(30))));
    all
}

/// Same input, same bytes, SVG and PNG.
#[test]
fn slow_figures_are_the_same_twice() {
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
            "momenta" => &["N·s", "N·m·s", "time (s)"],
            "joint_torques" => &["N·m/kg", "N·m", "time (s)"],
            "energies" => &["J", "W", "time (s)"],
            "residual" => &["Residual:", "good: up to 10 N, 50 N·m", "time (s)"],
            "contact" => &["total · vertical", "RMS", "body weight", "leg_l", "time (s)"],
            "push" => &["N·s", "20 %", "forward", "left", "back", "right", "stand"],
            "push_one" => &["N·s", "forward", "20 %"],
            "push_many" => &["N·s", "back"],
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

/// A span keeps its clock: the axis of time starts where the span does, and shows nothing outside it.
#[test]
fn spans_keep_their_clock() {
    let character = sample::human();
    let trace = sample::trace(&character, &sample::bow(&character, 0.0));
    let span = Excerpt::between(&trace, 2.0, 3.0);
    assert_eq!((span.rows(), span.clock().at(0), span.clock().at(120)), (121, 2.0, 3.0));
    assert!(span.contacts.iter().all(|c| c.row < 121) && span.contacts.len() == 8 * 121);
    let ticks = |figure: &Figure| -> Vec<String> {
        figure
            .marks
            .iter()
            .filter_map(|m| match m {
                plots::figure::Mark::Text { text, .. } => Some(text.clone()),
                _ => None,
            })
            .filter(|t| t.parse::<f64>().is_ok())
            .collect()
    };
    let seen = ticks(&plots::momenta(&span, ""));
    assert!(seen.iter().any(|t| t == "2.5") && !seen.iter().any(|t| t == "0.5"), "{seen:?}");
    // whole, empty and reversed spans are still figures
    for (from, to) in [(-1.0, 99.0), (2.0, 2.0), (3.0, 1.0), (99.0, 100.0)] {
        assert!(Excerpt::between(&trace, from, to).rows() > 0, "{from} {to}");
    }
}

/// The verdict is the guideline's: 10 and 25 N, 50 and 75 N·m.
#[test]
fn residuals_are_graded() {
    let clock = plots::panel::Clock { rate_hz: 100.0, start_s: 0.0 };
    for (force, moment, verdict) in [
        (3.0, 20.0, "Residual: good"),
        (12.0, 20.0, "Residual: acceptable"),
        (3.0, 80.0, "Residual: poor"),
        (26.0, 0.0, "Residual: poor"),
    ] {
        let mut wrench = vec![0.0; 600];
        wrench[301] = force;
        wrench[305] = -moment;
        let svg = graded_residual(&wrench, clock, 735.0, "", "").svg().unwrap();
        assert!(svg.contains(verdict), "{force} N, {moment} N·m: {verdict}");
    }
    let svg = graded_residual(&[f64::NAN; 6], clock, 735.0, "", "").svg().unwrap();
    assert!(svg.contains("no row with finite numbers"));
}

/// A foot captured too low for a moment weighs tons in penalty contact: its curve is cut, the others stay readable. One that is so
/// throughout says nothing: it is left out, and the note says so.
#[test]
fn penalty_off_the_scale_is_cut_and_said() {
    let character = sample::human();
    let trace = sample::trace(&character, &sample::bow(&character, 0.0));
    let mut told = sources(&trace);
    let given = told.iter_mut().find(|w| w.kind == ForceSourceKind::Given).unwrap();
    given.forces.total[40] *= 5.0;
    let figure = contact_overlay(&told, 735.0, "");
    assert!(figure.svg().unwrap().contains("penalty off scale"));
    for mark in &figure.marks {
        let [left, top, right, bottom] = Figure::bounds(mark);
        assert!(left >= -1.0 && top >= -1.0 && right <= figure.width + 1.0 && bottom <= figure.height + 1.0);
    }
    let plain = contact_overlay(&sources(&trace), 735.0, "").svg().unwrap();
    assert!(!plain.contains("off scale") && !plain.contains("is not drawn"));
    let given = told.iter_mut().find(|w| w.kind == ForceSourceKind::Given).unwrap();
    given.forces.total.iter_mut().for_each(|f| *f *= 50.0);
    let text = contact_overlay(&told, 735.0, "").svg().unwrap();
    assert!(text.contains("% of body weight) and is not drawn") && !text.contains("off scale"));
}

/// A body that falls for a minute and one that is at the edge of the world: the strip has the size of any other, and says how
/// far it is.
#[test]
fn a_strip_of_a_long_fall_is_bounded_and_says_how_far() {
    let character = sample::human();
    let bow = sample::bow(&character, 0.0);
    let whole = film_strip_with(&[StripRow::new("bow", &bow)], &character, "", &StripOptions::default());
    for (lowest, words) in [(-17_658.0, "18 km lower"), (-31.4, "31.4 m lower"), (1e12, "1e9 km higher")] {
        let mut clip = bow.clone();
        let end = clip.duration_s();
        for f in 0..clip.frames() {
            let s = f as f64 / clip.rate_hz / end;
            clip.pose_mut(f)[1] += lowest * s * s;
        }
        let figure =
            film_strip_with(&[StripRow::new("fall", &clip)], &character, "", &StripOptions::default());
        assert!(figure.height < whole.height + 100.0, "{lowest}: {} px", figure.height);
        let says = |m: &Mark| matches!(m, Mark::Text { text, .. } if text.ends_with(words));
        assert!(figure.marks.iter().any(says), "{lowest}: {words}");
        assert!(figure.pixels().is_ok() && figure.svg().is_ok());
    }
}

/// A page beyond all measure is an error, not a panic and not all memory; what lies far outside a page costs no time.
#[test]
fn a_page_too_large_is_refused() {
    for (width, height) in [(1600.0, 1e6), (1e9, 1e9), (f64::NAN, 100.0), (1600.0, 0.0), (4000.0, 4000.0)] {
        let figure = Figure::new(width, height);
        assert!(figure.pixels().is_err() && figure.svg().is_err(), "{width} × {height}");
    }
    let mut figure = Figure::new(100.0, 100.0);
    figure.fill(vec![[-1e18, -1e18], [1e18, -1e18], [0.0, 1e18]], style::BLUE);
    figure.line(vec![[-1e18, 50.0], [1e18, 50.0]], style::BLUE, 2.0);
    assert!(figure.pixels().is_ok());
}
