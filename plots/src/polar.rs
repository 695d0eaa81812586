//! Push-recovery map: the impulse survived in every direction, against the physical limit.
//!
//! In: [`Spoke`]s. Out: a [`Figure`], the body seen from above, its front up and its left on the left. Rings are
//! N·s; the percentage outside is survived over limit.

use crate::clear::crossed;
use crate::figure::{Anchor, Figure, Px};
use crate::panel::{Key, header, number, step};
use crate::style::{self, LABEL, MARGIN, SMALL, THIN};

/// One direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spoke {
    /// Where the push goes, degrees: 0 forward, 90 left, 180 back, 270 right.
    pub deg: f64,
    /// Impulse survived, N·s.
    pub survived: f64,
    /// Physical limit, N·s.
    pub limit: f64,
}

/// Width of the page, px.
const WIDTH: f64 = 680.0;
/// Radius of the outermost ring, px.
const RADIUS: f64 = 235.0;
/// From the outermost ring to the middle of the percentages, and to that of the names, px.
const OUT: [f64; 2] = [24.0, 54.0];
/// More spokes than this are drawn without their percentages.
const MOST_LABELLED: usize = 36;
/// The four directions with a name.
const NAMES: [(f64, &str); 4] = [(0.0, "forward"), (90.0, "left"), (180.0, "back"), (270.0, "right")];

/// Draws a map; `note` stands under the title.
pub fn push_map(spokes: &[Spoke], note: &str) -> Figure {
    push_map_over(spokes, &[], note)
}

/// Draws a map over an earlier one of the same directions: `before` is what was survived then, N·s.
pub fn push_map_over(spokes: &[Spoke], before: &[f64], note: &str) -> Figure {
    let mut keys = vec![
        Key::line("survived", style::BLUE),
        Key::dashed("limit of moving the centre of pressure alone", style::VERMILION),
    ];
    if !before.is_empty() {
        keys.insert(1, Key::line("survived before", style::REFERENCE));
    }
    let title = "Largest push survived without a step, N·s";
    let top = header(&mut Figure::new(WIDTH, 100.0), title, note, &keys);
    let middle = [WIDTH / 2.0, top + OUT[1] + LABEL + RADIUS];
    let mut figure = Figure::new(WIDTH, middle[1] + RADIUS + OUT[1] + LABEL + 0.6 * MARGIN);
    header(&mut figure, title, note, &keys);

    let values = spokes.iter().flat_map(|s| [s.survived, s.limit]).chain(before.iter().copied());
    let values = values.filter(|x| x.is_finite());
    let most = values.fold(0.0, f64::max);
    let most = if most > 0.0 { most } else { 1.0 };
    let ring = step(1.02 * most, 6.0, false);
    let rings = (1.02 * most / ring).ceil().max(1.0);
    let scale = RADIUS / (rings * ring);
    let at = |deg: f64, px: f64| -> Px {
        let (s, c) = deg.to_radians().sin_cos();
        [middle[0] - px * s, middle[1] - px * c]
    };
    let round = |value: f64| (0..=180).map(|i| at(2.0 * f64::from(i), value * scale)).collect::<Vec<_>>();

    let closed = |of: &dyn Fn(&Spoke) -> f64| -> Vec<Px> {
        let mut points: Vec<Px> = spokes.iter().map(|s| at(s.deg, of(s) * scale)).collect();
        points.extend(points.first().copied());
        points
    };
    let (survived, limit) = (closed(&|s| s.survived), closed(&|s| s.limit));
    let outline = survived.clone();
    if spokes.len() > 2 {
        figure.fill(survived[..spokes.len()].to_vec(), style::BLUE.mix(style::WHITE, 0.88));
    }
    for i in 1..=rings as usize {
        figure.line(round(i as f64 * ring), style::GRID, THIN);
    }
    figure.line(round(rings * ring), style::FRAME, THIN);
    for s in spokes {
        figure.line(vec![middle, at(s.deg, RADIUS)], style::GRID, THIN);
    }
    if spokes.len() > 2 && before.len() == spokes.len() {
        let mut points: Vec<Px> = spokes.iter().zip(before).map(|(s, b)| at(s.deg, b * scale)).collect();
        points.extend(points.first().copied());
        figure.line(points, style::REFERENCE, 2.0);
    }
    if spokes.len() > 2 {
        figure.dashed(&limit, style::VERMILION, style::LINE, [6.0, 4.0]);
        figure.line(survived, style::BLUE, 2.0);
    }
    for s in spokes {
        figure.disc(at(s.deg, s.limit * scale), 2.4, style::VERMILION);
        figure.disc(at(s.deg, s.survived * scale), 3.4, style::BLUE);
    }

    // in the middle between two spokes (percentages are written at the ends of spokes), to the right of forward or next to
    // there, where fewest of the numbers meet a line
    let ring_label = |deg: f64, i: usize| {
        let text = number(i as f64 * ring, ring);
        let [x, y] = at(deg, i as f64 * ring * scale);
        let (w, h) = (style::text_width(&text, SMALL) + 4.0, SMALL + 1.0);
        (text, [x, y], [w, h])
    };
    let meets = |deg: f64| {
        let met = |i: &usize| {
            let (_, [x, y], [w, h]) = ring_label(deg, *i);
            let rect = [x - w / 2.0, y - h / 2.0, x + w / 2.0, y + h / 2.0];
            spokes.len() > 2 && [&outline, &limit].into_iter().any(|line| crossed(&rect, line))
        };
        (1..=rings as usize).filter(met).count()
    };
    let gaps = spokes.len().max(4);
    let asides = (0..gaps).map(|k| -180.0 * (2 * k + 1) as f64 / gaps as f64);
    let aside = asides.min_by_key(|deg| meets(*deg)).unwrap_or_default();
    for i in 1..=rings as usize {
        let (text, [x, y], [w, h]) = ring_label(aside, i);
        figure.rectangle([x - w / 2.0, y - h / 2.0], [w, h], style::WHITE);
        figure.text(text, [x, y + 0.36 * SMALL], SMALL, style::SOFT, Anchor::Middle);
    }
    let mut label = |deg: f64, out: f64, text: String, size: f64, color| {
        let [x, y] = at(deg, RADIUS + out);
        figure.text(text, [x, y + 0.36 * size], size, color, Anchor::Middle);
    };
    if spokes.len() <= MOST_LABELLED {
        for s in spokes.iter().filter(|s| s.limit > 0.0 && s.survived.is_finite()) {
            let percent = format!("{:.0} %", 100.0 * (s.survived / s.limit));
            label(s.deg, OUT[0], percent, SMALL, style::SOFT);
        }
    }
    for (deg, name) in NAMES {
        // names at the sides are wider than high: they begin farther out
        let out = if deg % 180.0 == 0.0 { OUT[1] - 6.0 } else { OUT[1] + 14.0 };
        label(deg, out, name.into(), LABEL, style::INK);
    }
    figure
}
