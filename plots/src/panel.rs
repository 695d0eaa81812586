//! Panels and pages: axes with ticks and units, curves, legends, a title and a note, small multiples.
//!
//! In: series in data units. Out: a [`Figure`]. Legends stand above the panels, never on the data;
//! margins are measured from the labels, so nothing is clipped.

use crate::clear::{Rect, word_beside};
use crate::figure::{Anchor, Figure, Px};
use crate::style::{self, Color, LABEL, MARGIN, SMALL, THIN, TITLE};

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// Unbroken.
    Solid,
    /// In strokes.
    Dashed,
}

/// A curve; points that are not finite break it.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Points in data units.
    pub points: Vec<[f64; 2]>,
    /// Colour.
    pub color: Color,
    /// Width, px.
    pub width: f64,
    /// Solid or dashed.
    pub stroke: Stroke,
}

/// Time of the rows of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Rows per second, Hz.
    pub rate_hz: f64,
    /// Time of the first row, s.
    pub start_s: f64,
}

impl Clock {
    /// Time of a row, s.
    pub fn at(&self, row: usize) -> f64 {
        self.start_s + row as f64 / self.rate_hz
    }
}

impl Series {
    /// A solid curve over time, one value per row.
    pub fn over_time(clock: Clock, values: impl IntoIterator<Item = f64>, color: Color) -> Self {
        let points = values.into_iter().enumerate().map(|(i, y)| [clock.at(i), y]).collect();
        Self { points, color, width: style::LINE, stroke: Stroke::Solid }
    }

    /// The same, dashed.
    pub fn dashed(mut self) -> Self {
        self.stroke = Stroke::Dashed;
        self
    }

    /// The same, of another width, px.
    pub fn wide(mut self, width: f64) -> Self {
        self.width = width;
        self
    }
}

/// A horizontal reference line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guide {
    /// Height in data units.
    pub y: f64,
    /// Colour.
    pub color: Color,
    /// Solid or dashed.
    pub stroke: Stroke,
    /// Whether the axis grows to show it.
    pub always: bool,
}

/// A vertical reference line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerticalGuide {
    /// Where on the horizontal axis, data units; not drawn beyond its ends.
    pub x: f64,
    /// Colour.
    pub color: Color,
    /// Solid or dashed.
    pub stroke: Stroke,
}

/// One pair of axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// Stands above the frame.
    pub title: String,
    /// Under the horizontal axis, with its unit.
    pub x_label: String,
    /// Beside the vertical axis, with its unit.
    pub y_label: String,
    /// Areas under the curves, data units.
    pub areas: Vec<(Vec<[f64; 2]>, Color)>,
    /// Curves, in order of drawing.
    pub series: Vec<Series>,
    /// Horizontal references.
    pub guides: Vec<Guide>,
    /// Points drawn as discs, px radius.
    pub dots: Vec<([f64; 2], f64, Color)>,
    /// Words beside points, where no curve runs through them.
    pub labels: Vec<([f64; 2], String, Color)>,
    /// Least height of the vertical axis, data units, so that noise stays small.
    pub least_span: f64,
    /// Vertical references: the time of a fall and of its causes.
    pub vertical_guides: Vec<VerticalGuide>,
    /// One unit is as long on both axes.
    pub equal: bool,
    /// Steps of the vertical axis are parts of a circle.
    pub degrees: bool,
    /// Names of the curves in their colours, on the right of the title.
    pub tags: Vec<(String, Color)>,
    /// Bars under the horizontal axis, the first on top: times in which something holds.
    pub bars: Vec<Bar>,
    /// Horizontal bands behind the curves, as far as the axis reaches.
    pub bands: Vec<Band>,
    /// The vertical axis goes no higher, whatever the curves do; they are cut there.
    pub ceiling: Option<f64>,
    /// Stands in the middle of an empty frame: why there is nothing to see.
    pub message: String,
}

/// Times in which something holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// First and last moment of each, data units; not drawn beyond the ends of the axis.
    pub spans: Vec<[f64; 2]>,
    /// Colour; a legend says what it means.
    pub color: Color,
}

/// Height of a bar and of the gap over it, px.
const BAR: f64 = 4.0;
const BAR_GAP: f64 = 2.0;

/// Height of so many bars, px.
pub(crate) fn bars_height(count: usize) -> f64 {
    count as f64 * (BAR + BAR_GAP)
}

/// Draws bars under the point at `at`, over a width of so many px: `across` says where a moment is, from 0 to 1.
pub(crate) fn draw_bars(figure: &mut Figure, bars: &[Bar], at: Px, width: f64, across: impl Fn(f64) -> f64) {
    for (i, bar) in bars.iter().enumerate() {
        let y = at[1] + bars_height(i) + BAR_GAP;
        for [from, to] in &bar.spans {
            let (from, to) = (across(*from).clamp(0.0, 1.0), across(*to).clamp(0.0, 1.0));
            if from < to {
                figure.rectangle([at[0] + from * width, y], [(to - from) * width, BAR], bar.color);
            }
        }
    }
}

/// A range of values with a meaning.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// Lower end, data units.
    pub from: f64,
    /// Upper end; may be infinite.
    pub to: f64,
    /// Colour; a legend says what it means.
    pub color: Color,
}

/// One line of a legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// What it means.
    pub label: String,
    /// Colour.
    pub color: Color,
    /// How it is drawn.
    pub sample: Sample,
}

/// What a legend shows before a label.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sample {
    /// A line.
    Line(Stroke),
    /// An area.
    Area,
    /// A dot.
    Dot,
}

impl Key {
    /// A solid line.
    pub fn line(label: &str, color: Color) -> Self {
        Self { label: label.into(), color, sample: Sample::Line(Stroke::Solid) }
    }

    /// A dashed line.
    pub fn dashed(label: &str, color: Color) -> Self {
        Self { label: label.into(), color, sample: Sample::Line(Stroke::Dashed) }
    }

    /// An area.
    pub fn area(label: &str, color: Color) -> Self {
        Self { label: label.into(), color, sample: Sample::Area }
    }

    /// A dot.
    pub fn dot(label: &str, color: Color) -> Self {
        Self { label: label.into(), color, sample: Sample::Dot }
    }
}

/// Draws title, note and legend at the top of a page and returns the height they take.
///
/// A note too long for the page is broken at spaces.
pub(crate) fn header(figure: &mut Figure, title: &str, note: &str, keys: &[Key]) -> f64 {
    let width = figure.width - 2.0 * MARGIN;
    let mut y = MARGIN + TITLE * 0.8;
    figure.text(fit(title, TITLE, width), [MARGIN, y], TITLE, style::INK, Anchor::Start);
    for line in wrap(note, LABEL, width) {
        y += LABEL * 1.6;
        figure.text(line, [MARGIN, y], LABEL, style::SOFT, Anchor::Start);
    }
    if !keys.is_empty() {
        y += LABEL * 1.9;
        let mut x = MARGIN;
        for key in keys {
            let advance = 34.0 + style::text_width(&key.label, LABEL) + 22.0;
            if x > MARGIN && x + advance - 22.0 > figure.width - MARGIN {
                (x, y) = (MARGIN, y + LABEL * 1.6);
            }
            let middle = y - 0.36 * LABEL;
            let line = [[x, middle], [x + 27.0, middle]];
            match key.sample {
                Sample::Line(Stroke::Solid) => figure.line(line.to_vec(), key.color, 2.2),
                Sample::Line(Stroke::Dashed) => figure.dashed(&line, key.color, 2.2, [6.0, 4.0]),
                Sample::Area => figure.rectangle([x + 2.0, middle - 6.0], [23.0, 12.0], key.color),
                Sample::Dot => figure.disc([x + 13.0, middle], 4.5, key.color),
            }
            figure.text(key.label.as_str(), [x + 34.0, y], LABEL, style::INK, Anchor::Start);
            x += advance;
        }
    }
    y + LABEL * 1.2
}

/// A page of panels in `columns`, row by row, each `panel_height` px high inside its frame.
pub fn page(
    title: &str,
    note: &str,
    keys: &[Key],
    panels: &[Panel],
    columns: usize,
    width: f64,
    panel_height: f64,
) -> Figure {
    let columns = columns.clamp(1, panels.len().max(1));
    let rows = panels.len().div_ceil(columns);
    // Header height depends on wrapping only, so it is measured on a page that is thrown away.
    let top = header(&mut Figure::new(width, 100.0), title, note, keys);
    let scales: Vec<Scale> = panels.iter().map(|p| Scale::of(p, panel_height)).collect();
    let left = |column: usize| {
        let of_column = (column..panels.len()).step_by(columns);
        let ticks = of_column.clone().map(|i| scales[i].label_width()).fold(0.0, f64::max);
        let labelled = of_column.into_iter().any(|i| !panels[i].y_label.is_empty());
        ticks + 8.0 + if labelled { LABEL * 1.7 } else { 0.0 }
    };
    let lefts: Vec<f64> = (0..columns).map(left).collect();
    let gap = 20.0;
    let free = width - 2.0 * MARGIN - lefts.iter().sum::<f64>() - gap * (columns - 1) as f64 - 8.0;
    let panel_width = (free / columns as f64).max(40.0);
    let above = LABEL * 1.7;
    let row_height = |row: usize| {
        let labelled = panels[row * columns..].iter().take(columns).any(|p| !p.x_label.is_empty());
        let bars = panels[row * columns..].iter().take(columns).map(|p| p.bars.len()).max().unwrap_or(0);
        above + panel_height + bars_height(bars) + SMALL * 1.7 + if labelled { LABEL * 1.6 } else { 2.0 }
    };
    let height = top + (0..rows).map(row_height).sum::<f64>() + MARGIN * 0.6;
    let mut figure = Figure::new(width, height);
    header(&mut figure, title, note, keys);
    let mut y = top;
    for row in 0..rows {
        let mut x = MARGIN;
        for column in 0..columns {
            x += lefts[column];
            if let Some(panel) = panels.get(row * columns + column) {
                let frame = Frame { at: [x, y + above], size: [panel_width, panel_height] };
                panel.draw(&mut figure, frame, lefts[column]);
            }
            x += panel_width + gap;
        }
        y += row_height(row);
    }
    figure
}

/// Draws one panel, labels included, into the rectangle at `at` of `size`.
pub(crate) fn place(figure: &mut Figure, panel: &Panel, at: Px, size: Px) {
    let below = bars_height(panel.bars.len())
        + SMALL * 1.7
        + if panel.x_label.is_empty() { 2.0 } else { LABEL * 1.6 };
    let above = LABEL * 1.7;
    let height = (size[1] - above - below).max(40.0);
    let labelled = !panel.y_label.is_empty();
    // an equal axis grows after its ticks are measured: leave room for a minus sign and three digits
    let ticks = Scale::of(panel, height).label_width().max(if panel.equal { 34.0 } else { 0.0 });
    let left = ticks + 8.0 + if labelled { LABEL * 1.7 } else { 0.0 };
    let width = (size[0] - left - 8.0).max(40.0);
    panel.draw(figure, Frame { at: [at[0] + left, at[1] + above], size: [width, height] }, left);
}

#[derive(Clone, Copy)]
struct Frame {
    at: Px,
    size: Px,
}

/// Ranges and ticks of a panel's vertical axis.
struct Scale {
    y: [f64; 2],
    ticks: Vec<f64>,
    step: f64,
}

impl Scale {
    fn of(panel: &Panel, height: f64) -> Self {
        let curves = panel.series.iter().flat_map(|s| &s.points).chain(panel.areas.iter().flat_map(|a| &a.0));
        let values = curves.map(|p| p[1]).chain(panel.dots.iter().map(|d| d.0[1]));
        let guides = panel.guides.iter().filter(|g| g.always).map(|g| g.y);
        let values = values.map(|y| panel.ceiling.map_or(y, |most| y.min(most)));
        let y = span(values.chain(guides), panel.least_span.max(1e-9));
        let step = step(y[1] - y[0], (height / 42.0).max(2.0), panel.degrees);
        Self { y, ticks: ticks(y, step), step }
    }

    fn label_width(&self) -> f64 {
        self.ticks.iter().map(|t| style::text_width(&number(*t, self.step), SMALL)).fold(0.0, f64::max)
    }
}

impl Panel {
    fn draw(&self, figure: &mut Figure, frame: Frame, left: f64) {
        let mut scale = Scale::of(self, frame.size[1]);
        let curves = self.series.iter().flat_map(|s| &s.points).chain(self.areas.iter().flat_map(|a| &a.0));
        let mut x = limits(curves.map(|p| p[0]).chain(self.dots.iter().map(|d| d.0[0])));
        if self.equal {
            x = span(x.into_iter(), 1e-9);
            let per_px = ((x[1] - x[0]) / frame.size[0]).max((scale.y[1] - scale.y[0]) / frame.size[1]);
            x = grow(x, per_px * frame.size[0]);
            let y = grow(scale.y, per_px * frame.size[1]);
            let step = step(y[1] - y[0], frame.size[1] / 42.0, false);
            scale = Scale { y, ticks: ticks(y, step), step };
        }
        let [w, h] = frame.size;
        let px = |p: &[f64; 2]| -> Px {
            [
                frame.at[0] + (p[0] - x[0]) / (x[1] - x[0]) * w,
                frame.at[1] + h - (p[1] - scale.y[0]) / (scale.y[1] - scale.y[0]) * h,
            ]
        };
        let (right, bottom) = (frame.at[0] + w, frame.at[1] + h);
        let barred = bars_height(self.bars.len());
        let across = |t: f64| (t - x[0]) / (x[1] - x[0]);
        draw_bars(figure, &self.bars, [frame.at[0], bottom], w, across);

        let empty = !self.message.is_empty();
        for band in self.bands.iter().filter(|_| !empty) {
            let (from, to) = (band.from.max(scale.y[0]), band.to.min(scale.y[1]));
            if from < to {
                let (low, high) = (px(&[0.0, from])[1], px(&[0.0, to])[1]);
                figure.rectangle([frame.at[0], high], [w, low - high], band.color);
            }
        }
        for &t in scale.ticks.iter().filter(|_| !empty) {
            let y = px(&[0.0, t])[1];
            figure.line(vec![[frame.at[0], y], [right, y]], style::GRID, THIN);
            let at = [frame.at[0] - 6.0, y + 0.36 * SMALL];
            figure.text(number(t, scale.step), at, SMALL, style::SOFT, Anchor::End);
        }
        let x_step = step(x[1] - x[0], (w / 80.0).clamp(2.0, 10.0), false);
        for t in ticks(x, x_step).into_iter().filter(|_| !empty) {
            let at = px(&[t, 0.0])[0];
            figure.line(vec![[at, frame.at[1]], [at, bottom]], style::GRID, THIN);
            let label = [at, bottom + barred + SMALL * 1.4];
            figure.text(number(t, x_step), label, SMALL, style::SOFT, Anchor::Middle);
        }
        for (area, color) in &self.areas {
            figure.fill(area.iter().map(px).collect(), *color);
        }
        for guide in &self.guides {
            if guide.y < scale.y[0] || guide.y > scale.y[1] {
                continue;
            }
            let y = px(&[0.0, guide.y])[1];
            let line = [[frame.at[0], y], [right, y]];
            match guide.stroke {
                Stroke::Solid => figure.line(line.to_vec(), guide.color, THIN),
                Stroke::Dashed => figure.dashed(&line, guide.color, 1.2, [7.0, 4.0]),
            }
        }
        for guide in self.vertical_guides.iter().filter(|m| !empty && m.x >= x[0] && m.x <= x[1]) {
            let at = px(&[guide.x, 0.0])[0];
            let line = [[at, frame.at[1]], [at, bottom]];
            match guide.stroke {
                Stroke::Solid => figure.line(line.to_vec(), guide.color, 1.4),
                Stroke::Dashed => figure.dashed(&line, guide.color, 1.4, [5.0, 3.5]),
            }
        }
        let mut lines = Vec::new();
        for series in &self.series {
            let cut;
            let points = match self.ceiling {
                Some(_) => {
                    cut = below(&series.points, scale.y[1]);
                    &cut
                }
                None => &series.points,
            };
            for run in points.split(|p| !p[0].is_finite() || !p[1].is_finite()) {
                let points = simplify(&thin(run.iter().map(px).collect()), FLAT);
                if !self.labels.is_empty() {
                    lines.push(points.clone());
                }
                match series.stroke {
                    Stroke::Solid => figure.line(points, series.color, series.width),
                    Stroke::Dashed => figure.dashed(&points, series.color, series.width, [5.0, 3.5]),
                }
            }
        }
        for (at, radius, color) in &self.dots {
            figure.disc(px(at), *radius, *color);
        }
        let [l, t] = frame.at;
        let dot = |(at, radius, _): &([f64; 2], f64, Color)| {
            let [x, y] = px(at);
            [x - radius, y - radius, x + radius, y + radius]
        };
        let mut taken: Vec<Rect> = self.dots.iter().map(dot).collect();
        for (at, text, color) in &self.labels {
            word_beside(figure, (px(at), text, *color), &[l, t, right, bottom], &lines, &mut taken);
        }
        let corners = vec![[l, t], [right, t], [right, bottom], [l, bottom], [l, t]];
        figure.line(corners, style::FRAME, THIN);

        let mut end = right;
        for (tag, color) in self.tags.iter().rev() {
            figure.text(tag.as_str(), [end, t - 6.0], SMALL, color.mix(style::INK, 0.15), Anchor::End);
            end -= style::text_width(tag, SMALL) + 9.0;
        }
        let title = fit(&self.title, LABEL, end - l);
        figure.text(title, [l, t - 6.0], LABEL, style::INK, Anchor::Start);
        if !self.message.is_empty() {
            let lines = wrap(&self.message, LABEL, w - 24.0);
            let first = t + 0.5 * h - 0.8 * LABEL * (lines.len() as f64 - 1.0) + 0.36 * LABEL;
            for (i, line) in lines.into_iter().enumerate() {
                let at = [l + 0.5 * w, first + 1.6 * LABEL * i as f64];
                figure.text(line, at, LABEL, style::SOFT, Anchor::Middle);
            }
            // a panel with a message has no data: no ticks, which would suggest a scale
            return;
        }
        if !self.x_label.is_empty() {
            let at = [l + w / 2.0, bottom + barred + SMALL * 1.7 + LABEL];
            figure.text(self.x_label.as_str(), at, LABEL, style::INK, Anchor::Middle);
        }
        if !self.y_label.is_empty() {
            let at = [l - left + LABEL * 0.9, t + h / 2.0];
            figure.upward(self.y_label.as_str(), at, LABEL, style::INK);
        }
    }
}

/// What of a curve lies at or below a height, broken where it leaves.
fn below(points: &[[f64; 2]], most: f64) -> Vec<[f64; 2]> {
    let mut out: Vec<[f64; 2]> = Vec::with_capacity(points.len());
    for (i, p) in points.iter().enumerate() {
        if let Some(before) = i.checked_sub(1).map(|j| points[j])
            && (before[1] > most) != (p[1] > most)
            && before[1].is_finite()
            && p[1].is_finite()
        {
            let s = (most - before[1]) / (p[1] - before[1]);
            out.push([before[0] + s * (p[0] - before[0]), most]);
        }
        out.push(if p[1] > most { [p[0], f64::NAN] } else { *p });
    }
    out
}

/// Least and greatest finite value; `[0, 1]` without any.
fn limits(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    for v in values.filter(|v| v.is_finite()) {
        range = [range[0].min(v), range[1].max(v)];
    }
    match range {
        [lo, hi] if lo > hi => [0.0, 1.0],
        [lo, hi] if lo == hi => [lo, lo + 1.0],
        range => range,
    }
}

/// Range of an axis: the values, 6 % of air, and at least `least`.
fn span(values: impl Iterator<Item = f64>, least: f64) -> [f64; 2] {
    let mut seen = [f64::INFINITY, f64::NEG_INFINITY];
    for v in values.filter(|v| v.is_finite()) {
        seen = [seen[0].min(v), seen[1].max(v)];
    }
    if seen[0] > seen[1] {
        return [0.0, least.max(1.0)];
    }
    let wanted = ((seen[1] - seen[0]) * 1.12).max(least);
    // a value of 1e9 that does not change still needs an axis with two ends
    grow(seen, wanted.max(seen[1].abs().max(seen[0].abs()) * 1e-9))
}

fn grow([lo, hi]: [f64; 2], size: f64) -> [f64; 2] {
    let (middle, half) = (0.5 * (lo + hi), 0.5 * size);
    [middle - half, middle + half]
}

/// A round step that cuts `span` into about `count` parts.
pub(crate) fn step(span: f64, count: f64, degrees: bool) -> f64 {
    let raw = span / count.max(1.0);
    let decade = 10f64.powf(raw.log10().floor());
    if degrees && (5.0..180.0).contains(&raw) {
        return [5.0, 10.0, 15.0, 30.0, 45.0, 90.0, 180.0].into_iter().find(|s| *s >= raw).unwrap_or(180.0);
    }
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * decade).find(|s| *s >= raw * 0.999).unwrap_or(10.0 * decade)
}

fn ticks([lo, hi]: [f64; 2], step: f64) -> Vec<f64> {
    let first = (lo / step - 1e-9).ceil() as i64;
    let last = (hi / step + 1e-9).floor() as i64;
    (first..=last.min(first.saturating_add(40))).map(|i| i as f64 * step).collect()
}

/// A tick's number with as many decimals as its step needs and a true minus sign.
pub(crate) fn number(value: f64, step: f64) -> String {
    let decimals = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_owned(),
        Some(rest) => format!("\u{2212}{rest}"),
        None => text,
    }
}

/// Keeps first, least, greatest and last of each half-pixel column of a curve that runs to the right:
/// it looks the same, and a long trace stays a small file.
fn thin(points: Vec<Px>) -> Vec<Px> {
    let to_right = points.windows(2).all(|p| p[1][0] >= p[0][0]);
    let width = points.last().map_or(0.0, |l| l[0] - points[0][0]);
    if !to_right || (points.len() as f64) < 8.0 * width {
        return points;
    }
    let column = |p: &Px| (p[0] * 2.0).floor() as i64;
    let mut out = Vec::new();
    for run in points.chunk_by(|a, b| column(a) == column(b)) {
        let by_y = |&i: &usize, &j: &usize| run[i][1].total_cmp(&run[j][1]);
        let least = (0..run.len()).min_by(by_y).unwrap_or(0);
        let greatest = (0..run.len()).max_by(by_y).unwrap_or(0);
        let mut keep = [0, least, greatest, run.len() - 1];
        keep.sort_unstable();
        let mut last = None;
        for i in keep {
            if last != Some(i) {
                out.push(run[i]);
            }
            last = Some(i);
        }
    }
    out
}

/// Distance within which a point on a straight stretch is left out, px; a quarter of a subpixel.
const FLAT: f64 = 0.06;

/// The polyline without the points that lie within `tolerance` of it (D. Douglas, T. Peucker, 1973).
fn simplify(points: &[Px], tolerance: f64) -> Vec<Px> {
    let mut keep = vec![false; points.len()];
    let mut open = Vec::new();
    if let Some(last) = points.len().checked_sub(1) {
        (keep[0], keep[last]) = (true, true);
        open.push((0, last));
    }
    while let Some((a, b)) = open.pop() {
        let (from, along) = (points[a], [points[b][0] - points[a][0], points[b][1] - points[a][1]]);
        let length2 = along[0] * along[0] + along[1] * along[1];
        let distance = |p: &Px| {
            let d = [p[0] - from[0], p[1] - from[1]];
            let s = if length2 > 0.0 {
                ((d[0] * along[0] + d[1] * along[1]) / length2).clamp(0.0, 1.0)
            } else {
                0.0
            };
            (d[0] - s * along[0]).hypot(d[1] - s * along[1])
        };
        let mut worst = (a, tolerance);
        for (i, p) in points.iter().enumerate().take(b).skip(a + 1) {
            let d = distance(p);
            if d > worst.1 {
                worst = (i, d);
            }
        }
        if worst.0 != a {
            keep[worst.0] = true;
            open.extend([(a, worst.0), (worst.0, b)]);
        }
    }
    points.iter().zip(&keep).filter(|(_, k)| **k).map(|(p, _)| *p).collect()
}

/// The text, or as much of it as fits with an ellipsis.
pub(crate) fn fit(text: &str, size: f64, width: f64) -> String {
    if style::text_width(text, size) <= width {
        return text.to_owned();
    }
    let mut kept: Vec<char> = text.chars().collect();
    while kept.pop().is_some() {
        let shorter: String = kept.iter().collect::<String>() + "…";
        if style::text_width(&shorter, size) <= width {
            return shorter;
        }
    }
    String::new()
}

fn wrap(text: &str, size: f64, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if style::text_width(&format!("{line} {word}"), size) <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}
