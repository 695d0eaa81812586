//! Figures of a motion put on another body: paths in latent space, momentum, ground force, confidence, a table of
//! models.
//!
//! In: plain numbers. Out: pages after \[YAH10, Fig. 6, 8, 9\]. Units: m, s, N, N·s.
//!
//! \[YAH10\] Yamane, Ariki, Hodgins. Animating Non-Humanoid Characters with Human Motion Data, SCA 2010.

use motion::Vec3;

use crate::columns::{TIME, WIDTH, empty_page, rms, short};
use crate::figure::{Anchor, Figure};
use crate::gains::zero;
use crate::panel::{Clock, Guide, Key, Panel, Sample, Series, Stroke, header, page};
use crate::style::{
    BLUE, Color, GREEN, GRID, INK, LABEL, MARGIN, PURPLE, REFERENCE, SOFT, THIN, VERMILION, WHITE,
};

/// A path through a latent space of some dimension, projected on its first two.
#[derive(Clone, Debug, PartialEq)]
pub struct LatentPath {
    /// Dimensions of the space.
    pub dimensions: usize,
    /// Where every frame is.
    pub frames: Vec<[f64; 2]>,
    /// Key poses of the same performance.
    pub own_keys: Vec<[f64; 2]>,
    /// Key poses of others.
    pub other_keys: Vec<[f64; 2]>,
    /// Jerk of the path over the space's spread, all dimensions (stated under the panel).
    pub jerk: f64,
    /// Frames that went to another basin.
    pub jumps: usize,
}

/// The path of one motion in latent spaces of several dimensions, side by side.
pub fn latent_paths(paths: &[LatentPath], note: &str) -> Figure {
    let title = "Path through the latent space";
    if paths.is_empty() {
        return empty_page(title, note, "this model has no latent space");
    }
    let panel = |p: &LatentPath| {
        let path = Series { points: p.frames.clone(), color: BLUE, width: 1.0, stroke: Stroke::Solid };
        let dots = |of: &[[f64; 2]], radius: f64, color| -> Vec<_> {
            of.iter().map(|&x| (x, radius, color)).collect()
        };
        Panel {
            title: format!("{} dimensions · jerk {} · {} jumps", p.dimensions, short(p.jerk), p.jumps),
            x_label: "first latent coordinate".into(),
            y_label: "second".into(),
            series: vec![path],
            dots: [
                dots(&p.frames, 1.4, BLUE),
                dots(&p.other_keys, 3.6, VERMILION),
                dots(&p.own_keys, 4.6, GREEN),
            ]
            .concat(),
            equal: true,
            ..Panel::default()
        }
    };
    let panels: Vec<Panel> = paths.iter().map(panel).collect();
    let keys = [
        Key::line("frames of the motion", BLUE),
        Key::dot("key poses of this performance", GREEN),
        Key::dot("key poses of others", VERMILION),
    ];
    page(title, note, &keys, &panels, panels.len().min(3), WIDTH, 420.0)
}

/// The criteria for the latent dimension at one dimension \[YAH10, §6.2\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Criteria {
    /// Dimensions of the latent space.
    pub dimensions: usize,
    /// RMS error at key poses learned, degrees.
    pub learned_deg: f64,
    /// RMS error at key poses left out one by one, degrees.
    pub left_out_deg: f64,
    /// Jerk of the latent path over its extent, 1/s³.
    pub jerk_s3: f64,
    /// As `learned_deg`, latent points searched.
    pub search_learned_deg: f64,
    /// As `jerk_s3`, latent points searched.
    pub search_jerk_s3: f64,
}

/// A number of a row, and the colour of its curve.
type Curve = (fn(&Criteria) -> f64, Color);

/// Error at the key poses and jerk of the latent path against the dimension of the latent space.
pub fn dimension_criteria(rows: &[Criteria], note: &str) -> Figure {
    let title = "How many latent dimensions";
    if rows.is_empty() {
        return empty_page(title, note, "no dimension was looked at");
    }
    let panel = |title: &str, y_label: &str, curves: &[Curve]| {
        let points = |of: fn(&Criteria) -> f64| -> Vec<[f64; 2]> {
            rows.iter().map(|r| [r.dimensions as f64, of(r)]).collect()
        };
        let line =
            |&(of, color): &Curve| Series { points: points(of), color, width: 1.6, stroke: Stroke::Solid };
        Panel {
            title: title.into(),
            x_label: "latent dimensions".into(),
            y_label: y_label.into(),
            series: curves.iter().map(line).collect(),
            dots: curves
                .iter()
                .flat_map(|&(of, c)| points(of).into_iter().map(move |x| (x, 3.4, c)))
                .collect(),
            guides: vec![zero(true)],
            ..Panel::default()
        }
    };
    let panels = [
        panel(
            "Error at the key poses",
            "° RMS",
            &[(|r| r.left_out_deg, GREEN), (|r| r.learned_deg, BLUE), (|r| r.search_learned_deg, VERMILION)],
        ),
        panel(
            "Jerk of the latent path over its extent",
            "thousands /s³",
            &[(|r| 1e-3 * r.jerk_s3, BLUE), (|r| 1e-3 * r.search_jerk_s3, VERMILION)],
        ),
    ];
    let keys = [
        Key::line("learned", BLUE),
        Key::line("left out one by one", GREEN),
        Key::line("learned, latent points searched as in the paper", VERMILION),
    ];
    page(title, note, &keys, &panels, 2, WIDTH, 340.0)
}

/// Linear momentum in the plane and spin about the vertical, scaled human over character.
///
/// * `human`, `character`: N·s, world, from frame to frame
/// * `human_spin`, `character_spin`: N·m·s
pub fn momentum_match(
    clock: Clock,
    [human, character]: [&[Vec3]; 2],
    [human_spin, character_spin]: [&[f64]; 2],
    note: &str,
) -> Figure {
    let title = "Momentum, scaled human against character";
    if human.is_empty() {
        return empty_page(title, note, "the motion was not moved: no momentum was matched");
    }
    let panel = |what: &str, unit: &str, a: Vec<f64>, b: Vec<f64>| {
        let off: Vec<Vec3> = a.iter().zip(&b).map(|(a, b)| Vec3::new(a - b, 0.0, 0.0)).collect();
        Panel {
            title: format!("{what} · mismatch {} {unit} RMS", short(rms(&off))),
            y_label: unit.into(),
            series: vec![
                Series::over_time(clock, b, VERMILION).wide(2.2),
                Series::over_time(clock, a, BLUE).dashed(),
            ],
            guides: vec![zero(true)],
            least_span: 1e-3,
            ..Panel::default()
        }
    };
    let along = |of: &[Vec3], axis: usize| of.iter().map(|v| v[axis]).collect::<Vec<_>>();
    let mut panels = vec![
        panel("forward (z)", "N·s", along(human, 2), along(character, 2)),
        panel("to the left (x)", "N·s", along(human, 0), along(character, 0)),
        panel("spin about the vertical", "N·m·s", human_spin.to_vec(), character_spin.to_vec()),
    ];
    if let Some(last) = panels.last_mut() {
        last.x_label = TIME.into();
    }
    let keys = [Key::dashed("scaled human", BLUE), Key::line("character", VERMILION)];
    page(title, note, &keys, &panels, 1, WIDTH, 170.0)
}

/// Vertical ground force required by the motion and given by the contact model, before and after the refinement.
///
/// Each pair is (required, given), world, N.
pub fn force_match(
    clock: Clock,
    before: [&[Vec3]; 2],
    after: [&[Vec3]; 2],
    weight: f64,
    note: &str,
) -> Figure {
    let title = "Vertical ground force, required and given";
    if before[0].is_empty() {
        return empty_page(title, note, "the motion was not refined: no forces were matched");
    }
    // both panels have one scale, or nothing could be compared
    let all = || before.iter().chain(&after).flat_map(|f| f.iter().map(|v| v.y)).filter(|y| y.is_finite());
    let (low, high) = (all().fold(0.0, f64::min), all().fold(weight, f64::max));
    let panel = |what: &str, [required, given]: [&[Vec3]; 2]| {
        let off: Vec<Vec3> =
            required.iter().zip(given).map(|(a, b)| Vec3::new(0.0, a.y - b.y, 0.0)).collect();
        let invisible = |y: f64| Guide { y, color: WHITE, stroke: Stroke::Solid, always: true };
        Panel {
            title: format!("{what} · mismatch {} N RMS", short(rms(&off))),
            x_label: TIME.into(),
            y_label: "N".into(),
            series: vec![
                Series::over_time(clock, given.iter().map(|v| v.y), VERMILION),
                Series::over_time(clock, required.iter().map(|v| v.y), BLUE).dashed(),
            ],
            guides: vec![
                invisible(low),
                invisible(high),
                zero(true),
                Guide { y: weight, color: REFERENCE, stroke: Stroke::Dashed, always: true },
            ],
            least_span: 0.1 * weight,
            ..Panel::default()
        }
    };
    let panels = [panel("before refinement", before), panel("after", after)];
    let keys = [
        Key::dashed("required: inverse dynamics", BLUE),
        Key::line("given: contact model", VERMILION),
        Key::dashed("body weight", REFERENCE),
    ];
    page(title, note, &keys, &panels, 2, WIDTH, 260.0)
}

/// What a mapping thinks of itself over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Confidence<'a> {
    /// 0 knows nothing, 1 is as sure as at a key pose; one per frame.
    pub confidence: &'a [f64],
    /// Whether it says that it extrapolates; one per frame.
    pub extrapolates: &'a [bool],
    /// Frames at which its answer jumped.
    pub jumps: &'a [usize],
    /// Moments of key poses in this motion, s.
    pub keys_at_s: &'a [f64],
    /// Moments suggested for new key poses, s.
    pub suggested_at_s: &'a [f64],
}

/// Confidence over time: a curve, and under it a strip that is pale where the model is unsure.
pub fn confidence_strip(clock: Clock, of: &Confidence, note: &str) -> Figure {
    let title = "Confidence of the mapping";
    if of.confidence.is_empty() {
        return empty_page(title, note, "this model does not know how sure it is");
    }
    let tint = |c: f64| VERMILION.mix(GREEN, c.clamp(0.0, 1.0)).mix(WHITE, 0.25);
    let frames = of.confidence.len();
    // not one polygon per frame: at most a few hundred steps
    let stride = frames.div_ceil(400);
    let half = 0.5 / clock.rate_hz;
    let areas = (0..frames).step_by(stride).map(|i| {
        let end = (i + stride).min(frames);
        let mean = of.confidence[i..end].iter().sum::<f64>() / (end - i) as f64;
        let (from, to) = (clock.at(i) - half, clock.at(end - 1) + half);
        (vec![[from, 0.0], [to, 0.0], [to, mean], [from, mean]], tint(mean))
    });
    let dots =
        |times: &[f64], y: f64, color| -> Vec<_> { times.iter().map(|&t| ([t, y], 4.2, color)).collect() };
    let jumps: Vec<f64> = of.jumps.iter().map(|&f| clock.at(f)).collect();
    let unsure: Vec<f64> =
        (0..frames).filter(|&i| of.extrapolates.get(i) == Some(&true)).map(|i| clock.at(i)).collect();
    let extrapolated = (unsure.iter()).map(|&t| ([t, 0.02], 1.6, PURPLE));
    let panel = Panel {
        title: format!(
            "mean {:.0} % · extrapolates at {:.0} % of the frames",
            100.0 * of.confidence.iter().sum::<f64>() / frames as f64,
            100.0 * unsure.len() as f64 / frames as f64
        ),
        x_label: TIME.into(),
        y_label: "confidence".into(),
        areas: areas.collect(),
        series: vec![Series::over_time(clock, of.confidence.iter().copied(), INK)],
        guides: [0.0, 1.0].map(|y| Guide { y, color: GRID, stroke: Stroke::Solid, always: true }).to_vec(),
        dots: [
            extrapolated.collect(),
            dots(of.keys_at_s, 1.0, GREEN),
            dots(&jumps, 0.5, VERMILION),
            dots(of.suggested_at_s, 0.0, BLUE),
        ]
        .concat(),
        ..Panel::default()
    };
    let mut keys = vec![Key { label: "confidence".into(), color: INK, sample: Sample::Line(Stroke::Solid) }];
    for (given, label, color) in [
        (!of.keys_at_s.is_empty(), "key poses of this motion", GREEN),
        (!unsure.is_empty(), "extrapolated", PURPLE),
        (!jumps.is_empty(), "jumps to another basin", VERMILION),
        (!of.suggested_at_s.is_empty(), "suggested key poses", BLUE),
    ] {
        if given {
            keys.push(Key::dot(label, color));
        }
    }
    page(title, note, &keys, &[panel], 1, WIDTH, 190.0)
}

/// A table: names of rows, names of columns, cells as text. The best cell of a column may be marked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Title.
    pub title: String,
    /// Heads of the columns after the first.
    pub columns: Vec<String>,
    /// A name and a cell for each column.
    pub rows: Vec<(String, Vec<String>)>,
    /// For each column the row that is best.
    pub best: Vec<Option<usize>>,
}

/// Draws a table.
pub fn table(of: &Table, note: &str) -> Figure {
    const ROW: f64 = 30.0;
    let top = header(&mut Figure::new(WIDTH, 100.0), &of.title, note, &[]) + 8.0;
    let mut figure = Figure::new(WIDTH, top + ROW * (of.rows.len() + 1) as f64 + MARGIN);
    header(&mut figure, &of.title, note, &[]);
    let first = 0.16 * (WIDTH - 2.0 * MARGIN);
    let step = (WIDTH - 2.0 * MARGIN - first) / of.columns.len().max(1) as f64;
    let right = |column: usize| MARGIN + first + step * (column + 1) as f64 - 12.0;
    let line = |row: usize| top + ROW * row as f64;
    for (c, name) in of.columns.iter().enumerate() {
        figure.text(name.as_str(), [right(c), line(0) + 20.0], LABEL, SOFT, Anchor::End);
    }
    for (r, (name, cells)) in of.rows.iter().enumerate() {
        let y = line(r + 1);
        figure.line(vec![[MARGIN, y], [WIDTH - MARGIN, y]], GRID, THIN);
        figure.text(name.as_str(), [MARGIN + 6.0, y + 20.0], LABEL + 1.0, INK, Anchor::Start);
        for (c, cell) in cells.iter().enumerate().take(of.columns.len()) {
            let best = of.best.get(c).copied().flatten() == Some(r);
            let color = if best { GREEN } else { INK };
            figure.text(cell.as_str(), [right(c), y + 20.0], LABEL + 1.0, color, Anchor::End);
        }
    }
    figure
}
