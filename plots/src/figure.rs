//! Figures: a page as a list of marks, written as SVG and PNG by the same drawing code.
//!
//! In: marks in page pixels, x right, y down. Out: files. One function, generic over the plotters
//! backend, draws both; it works at four times the page's resolution, because backends take whole
//! pixels: the SVG maps that back by its `viewBox`, the PNG is averaged down, in bands of rows on all cores (`raster`).
//! Same marks, same bytes.

use std::io;
use std::path::{Path, PathBuf};

use plotters::backend::{DrawingBackend, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontTransform, RGBColor, ShapeStyle, TextStyle};
use thiserror::Error;

use crate::raster::Band;
use crate::style::{self, Color};

/// A point of the page, px.
pub type Px = [f64; 2];

/// Subpixels per pixel of the page.
const FINE: f64 = 4.0;
/// Rows of the page that are drawn at once, px: a band of subpixels fits the cache of a core.
const BAND: usize = 32;
/// How far drawing may reach beyond a mark, px.
const SLACK: f64 = 1.0;
/// Longest side of a page, px.
const MOST_SIDE: f64 = 16_384.0;
/// Largest page, px: all of it at [`FINE`] would be some 400 MB.
const MOST_AREA: f64 = 8e6;
/// Farthest from the page's corner that anything is drawn, px: backends walk over every pixel of a line, seen or not.
const FARTHEST: f64 = 1e5;

/// Which end of a text its position is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// Its beginning.
    Start,
    /// Its middle.
    Middle,
    /// Its end.
    End,
}

/// One thing drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    /// A filled polygon.
    Fill {
        /// Corners.
        points: Vec<Px>,
        /// Colour.
        color: Color,
    },
    /// A line through points.
    Line {
        /// Points.
        points: Vec<Px>,
        /// Colour.
        color: Color,
        /// Width, px.
        width: f64,
    },
    /// A text.
    Text {
        /// What it says.
        text: String,
        /// Where, on its baseline.
        at: Px,
        /// Em, px.
        size: f64,
        /// Colour.
        color: Color,
        /// What `at` is.
        anchor: Anchor,
        /// Whether it reads upwards.
        upward: bool,
    },
}

/// Why a figure was not written.
#[derive(Debug, Error)]
pub enum FigureError {
    /// The file system said no.
    #[error("cannot write {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What it said.
        source: io::Error,
    },
    /// A page larger than any that is drawn.
    #[error(
        "the figure would be {width} × {height} px; allowed: up to {MOST_SIDE} px a side and {MOST_AREA} px in all"
    )]
    Size {
        /// Width, px.
        width: f64,
        /// Height, px.
        height: f64,
    },
    /// The drawing or encoding failed.
    #[error("cannot draw {path}: {reason}")]
    Draw {
        /// The file.
        path: PathBuf,
        /// What the backend said.
        reason: String,
    },
}

/// A page with marks on it. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Width, px.
    pub width: f64,
    /// Height, px.
    pub height: f64,
    /// In order of drawing.
    pub marks: Vec<Mark>,
}

impl Figure {
    /// An empty page; sizes are rounded up to whole pixels.
    pub fn new(width: f64, height: f64) -> Self {
        Self { width: width.ceil(), height: height.ceil(), marks: Vec::new() }
    }

    /// Adds a filled polygon; one with a point that is not finite is nothing.
    pub fn fill(&mut self, points: Vec<Px>, color: Color) {
        if points.iter().all(is_finite) {
            self.marks.push(Mark::Fill { points, color });
        }
    }

    /// Adds a filled rectangle.
    pub fn rectangle(&mut self, [x, y]: Px, [w, h]: Px, color: Color) {
        self.fill(vec![[x, y], [x + w, y], [x + w, y + h], [x, y + h]], color);
    }

    /// Adds a disc.
    pub fn disc(&mut self, [x, y]: Px, radius: f64, color: Color) {
        let corner = |i: u32| {
            let (s, c) = (f64::from(i) * std::f64::consts::TAU / 20.0).sin_cos();
            [x + radius * c, y + radius * s]
        };
        self.fill((0..20).map(corner).collect(), color);
    }

    /// Adds a line; points that are not finite break it, fewer than two are nothing.
    pub fn line(&mut self, points: Vec<Px>, color: Color, width: f64) {
        if points.iter().all(is_finite) {
            if points.len() > 1 {
                self.marks.push(Mark::Line { points, color, width });
            }
            return;
        }
        for run in points.split(|p| !is_finite(p)) {
            self.line(run.to_vec(), color, width);
        }
    }

    /// Adds a line in strokes of `on` px with gaps of `off` px, measured along the line; points that are
    /// not finite break it.
    ///
    /// Strokes and gaps are at least 0.5 px: shorter ones would not be seen.
    pub fn dashed(&mut self, points: &[Px], color: Color, width: f64, [on, off]: [f64; 2]) {
        for run in points.split(|p| !is_finite(p)) {
            self.dashed_run(run, color, width, [on.max(0.5), off.max(0.5)]);
        }
    }

    fn dashed_run(&mut self, points: &[Px], color: Color, width: f64, [on, off]: [f64; 2]) {
        let Some(&first) = points.first() else { return };
        let (mut stroke, mut drawing, mut left) = (vec![first], true, on);
        for pair in points.windows(2) {
            let (mut a, b) = (pair[0], pair[1]);
            loop {
                let length = (b[0] - a[0]).hypot(b[1] - a[1]);
                if length <= left {
                    left -= length;
                    stroke.push(b);
                    break;
                }
                let s = left / length;
                a = [a[0] + (b[0] - a[0]) * s, a[1] + (b[1] - a[1]) * s];
                stroke.push(a);
                let done = std::mem::replace(&mut stroke, vec![a]);
                if drawing {
                    self.line(done, color, width);
                }
                drawing = !drawing;
                left = if drawing { on } else { off };
            }
        }
        if drawing {
            self.line(stroke, color, width);
        }
    }

    /// Adds a text whose baseline starts, is centred or ends at `at`.
    pub fn text(&mut self, text: impl Into<String>, at: Px, size: f64, color: Color, anchor: Anchor) {
        let text = text.into();
        self.marks.push(Mark::Text { text, at, size, color, anchor, upward: false });
    }

    /// Adds a text that reads upwards, centred on `at`.
    pub fn upward(&mut self, text: impl Into<String>, at: Px, size: f64, color: Color) {
        let (text, anchor) = (text.into(), Anchor::Middle);
        self.marks.push(Mark::Text { text, at, size, color, anchor, upward: true });
    }

    /// Rectangle `[left, top, right, bottom]` that a mark covers, px; texts by their em and measured width.
    pub fn bounds(mark: &Mark) -> [f64; 4] {
        match mark {
            Mark::Fill { points, .. } => bounds_of(points, 0.0),
            Mark::Line { points, width, .. } => bounds_of(points, width / 2.0),
            Mark::Text { text, at, size, anchor, upward, .. } => {
                let width = style::text_width(text, *size);
                let start = match anchor {
                    Anchor::Start => 0.0,
                    Anchor::Middle => -width / 2.0,
                    Anchor::End => -width,
                };
                let (up, down) = (0.76 * size, 0.24 * size);
                if *upward {
                    [at[0] - up, at[1] - start - width, at[0] + down, at[1] - start]
                } else {
                    [at[0] + start, at[1] - up, at[0] + start + width, at[1] + down]
                }
            }
        }
    }

    /// Refuses a page that is too large, or has no size at all.
    fn check(&self) -> Result<(), FigureError> {
        let (width, height) = (self.width, self.height);
        let within = |x: f64| (1.0..=MOST_SIDE).contains(&x);
        match within(width) && within(height) && width * height <= MOST_AREA {
            true => Ok(()),
            false => Err(FigureError::Size { width, height }),
        }
    }

    /// The page as an SVG document.
    ///
    /// # Errors
    /// `Size`; `Draw`, if the backend fails.
    pub fn svg(&self) -> Result<String, FigureError> {
        self.check()?;
        let fine = self.fine_size();
        let mut text = String::new();
        let mut backend = SVGBackend::with_string(&mut text, fine);
        let medium = Medium { baseline: 0.76, native_lines: true };
        let everything = [f64::NEG_INFINITY, f64::INFINITY];
        self.draw(&mut backend, medium, self.marks.iter(), everything)
            .map_err(|e| draw_error(Path::new("svg"), e))?;
        drop(backend);
        let size = |w: f64, h: f64| format!("width=\"{w}\" height=\"{h}\"");
        let (from, to) = (size(f64::from(fine.0), f64::from(fine.1)), size(self.width, self.height));
        Ok(text.replacen(&from, &to, 1))
    }

    /// The page as pixels, RGB, row by row from the top.
    ///
    /// # Errors
    /// `Size`; `Draw`, if the backend fails.
    pub fn pixels(&self) -> Result<Vec<u8>, FigureError> {
        self.check()?;
        let step = FINE as usize;
        let (width, height) = (self.width as usize, self.height as usize);
        // plotters puts the baseline half a font size below the top
        let medium = Medium { baseline: 0.5 * style::EM, native_lines: false };
        let reaches: Vec<[f64; 2]> = self.marks.iter().map(reach).collect();
        let mut out = vec![0; width * height * 3];
        let mut bands: Vec<(usize, &mut [u8])> = out.chunks_mut(width * 3 * BAND).enumerate().collect();
        let threads = std::thread::available_parallelism().map_or(1, usize::from).min(bands.len().max(1));
        let mut shares: Vec<Vec<(usize, &mut [u8])>> = (0..threads).map(|_| Vec::new()).collect();
        for (i, band) in bands.drain(..).enumerate() {
            shares[i % threads].push(band);
        }
        let draw = |share: Vec<(usize, &mut [u8])>| -> Result<(), String> {
            let mut band = Band::new(self.fine_size());
            for (i, out) in share {
                let (top, rows) = (i * BAND, out.len() / (width * 3));
                band.start((top * step) as i32, (rows * step) as i32);
                let seen = [top as f64, (top + rows) as f64];
                let marks = self.marks.iter().zip(&reaches);
                let marks = marks.filter(|(_, r)| r[0] <= seen[1] && r[1] >= seen[0]).map(|(m, _)| m);
                self.draw(&mut band, medium, marks, seen)?;
                band.average(step, out);
            }
            Ok(())
        };
        let drawn: Result<(), String> = std::thread::scope(|scope| {
            let others: Vec<_> = shares.drain(1..).map(|share| scope.spawn(|| draw(share))).collect();
            let own = shares.pop().map_or(Ok(()), draw);
            others.into_iter().fold(own, |all, other| {
                all.and(other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            })
        });
        drawn.map_err(|e| draw_error(Path::new("png"), e))?;
        Ok(out)
    }

    /// Writes `<stem>.svg` and `<stem>.png` into `dir`, under temporary names first, and returns both paths.
    ///
    /// # Errors
    /// `Io`, `Size` or `Draw`; earlier files stay whole.
    pub fn save(&self, dir: &Path, stem: &str) -> Result<[PathBuf; 2], FigureError> {
        let paths = ["svg", "png"].map(|kind| dir.join(format!("{stem}.{kind}")));
        self.save_svg(&paths[0])?;
        self.save_png(&paths[1])?;
        Ok(paths)
    }

    /// Writes the figure as SVG, under a temporary name first.
    ///
    /// # Errors
    /// `Io`, `Size` or `Draw`; an earlier file stays whole.
    pub fn save_svg(&self, path: &Path) -> Result<(), FigureError> {
        let temporary = temporary(path);
        let written = std::fs::write(&temporary, self.svg()?);
        let io = |source| FigureError::Io { path: path.to_owned(), source };
        replace(&temporary, path, written.map_err(io))
    }

    /// The figure as the bytes of a PNG file.
    ///
    /// # Errors
    /// `Size`, or `Draw` if the backend or the encoder fails.
    pub fn png(&self) -> Result<Vec<u8>, FigureError> {
        let pixels = self.pixels()?;
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let written = encoder.write_header().and_then(|mut image| {
            image.write_image_data(&pixels)?;
            image.finish()
        });
        written.map_err(|e| draw_error(Path::new("png"), e))?;
        Ok(bytes)
    }

    /// Writes the figure as PNG, under a temporary name first.
    ///
    /// # Errors
    /// `Io`, `Size` or `Draw`; an earlier file stays whole.
    pub fn save_png(&self, path: &Path) -> Result<(), FigureError> {
        let temporary = temporary(path);
        let written = std::fs::write(&temporary, self.png()?);
        let io = |source| FigureError::Io { path: path.to_owned(), source };
        replace(&temporary, path, written.map_err(io))
    }

    fn fine_size(&self) -> (u32, u32) {
        ((self.width * FINE) as u32, (self.height * FINE) as u32)
    }

    /// Draws marks on a white page; of long lines only what the rows `seen`, px, may show.
    fn draw<'m, B: DrawingBackend>(
        &self,
        backend: &mut B,
        medium: Medium,
        marks: impl Iterator<Item = &'m Mark>,
        seen: [f64; 2],
    ) -> Result<(), String> {
        let (w, h) = self.fine_size();
        backend.ensure_prepared().map_err(error_text)?;
        backend.draw_rect((0, 0), (w as i32, h as i32), &rgb(style::WHITE), true).map_err(error_text)?;
        for mark in marks {
            match mark {
                Mark::Fill { points, color } => {
                    backend.fill_polygon(points.iter().map(fine), &rgb(*color)).map_err(error_text)?;
                }
                Mark::Line { points, color, width } if medium.native_lines => {
                    let style = ShapeStyle::from(&rgb(*color)).stroke_width((width * FINE).round() as u32);
                    backend.draw_path(points.iter().map(fine), &style).map_err(error_text)?;
                }
                Mark::Line { points, color, width } => thick(backend, points, *color, *width, seen)?,
                Mark::Text { text, at, size, color, anchor, upward } => {
                    let h_pos = match anchor {
                        Anchor::Start => HPos::Left,
                        Anchor::Middle => HPos::Center,
                        Anchor::End => HPos::Right,
                    };
                    let mut font = style::font(size * FINE);
                    let mut top = *at;
                    if *upward {
                        font = font.transform(FontTransform::Rotate270);
                        top[0] -= medium.baseline * size;
                    } else {
                        top[1] -= medium.baseline * size;
                    }
                    let ink = rgb(*color);
                    let style = TextStyle::from(font).color(&ink).pos(Pos::new(h_pos, VPos::Top));
                    backend.draw_text(text, &style, fine(&top)).map_err(error_text)?;
                }
            }
        }
        backend.present().map_err(error_text)
    }
}

/// What differs between the backends.
#[derive(Clone, Copy)]
struct Medium {
    /// Height of the top anchor over the baseline, em.
    baseline: f64,
    /// Whether wide lines are drawn well by the backend itself.
    native_lines: bool,
}

/// A wide line as one quadrilateral per segment and a disc per bend: the outline plotters makes of a
/// whole dense curve crosses itself and leaves holes.
fn thick<B: DrawingBackend>(
    backend: &mut B,
    points: &[Px],
    color: Color,
    width: f64,
    seen: [f64; 2],
) -> Result<(), String> {
    let half = 0.5 * width;
    for (i, pair) in points.windows(2).enumerate() {
        let (a, b) = (pair[0], pair[1]);
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let length = dx.hypot(dy);
        let hidden = a[1].max(b[1]) + half + SLACK < seen[0] || a[1].min(b[1]) - half - SLACK > seen[1];
        if length == 0.0 || hidden {
            continue;
        }
        let n = [-dy / length * half, dx / length * half];
        let corners = [
            [a[0] + n[0], a[1] + n[1]],
            [b[0] + n[0], b[1] + n[1]],
            [b[0] - n[0], b[1] - n[1]],
            [a[0] - n[0], a[1] - n[1]],
        ];
        backend.fill_polygon(corners.iter().map(fine), &rgb(color)).map_err(error_text)?;
        if i > 0 && width > 1.0 {
            backend.draw_circle(fine(&a), (half * FINE) as u32, &rgb(color), true).map_err(error_text)?;
        }
    }
    Ok(())
}

/// Rows of the page that a mark may touch, px.
fn reach(mark: &Mark) -> [f64; 2] {
    let slack = match mark {
        // accents and long tails
        Mark::Text { size, .. } => *size,
        _ => SLACK,
    };
    let [_, top, _, bottom] = Figure::bounds(mark);
    [top - slack, bottom + slack]
}

fn is_finite(p: &Px) -> bool {
    p[0].is_finite() && p[1].is_finite()
}

fn fine(p: &Px) -> (i32, i32) {
    let fine = |x: f64| (x.clamp(-FARTHEST, FARTHEST) * FINE).round() as i32;
    (fine(p[0]), fine(p[1]))
}

fn rgb(c: Color) -> RGBColor {
    RGBColor(c.0, c.1, c.2)
}

fn bounds_of(points: &[Px], pad: f64) -> [f64; 4] {
    let mut b = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for p in points {
        b = [b[0].min(p[0] - pad), b[1].min(p[1] - pad), b[2].max(p[0] + pad), b[3].max(p[1] + pad)];
    }
    b
}

/// plotters does not name its error type in public, so errors travel as text.
fn error_text(e: impl std::fmt::Display) -> String {
    e.to_string()
}

/// A hidden name beside a file.
fn temporary(path: &Path) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let kind = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{stem}.tmp.{kind}"))
}

fn draw_error(path: &Path, e: impl std::fmt::Display) -> FigureError {
    FigureError::Draw { path: path.to_owned(), reason: e.to_string() }
}

fn replace(temporary: &Path, path: &Path, written: Result<(), FigureError>) -> Result<(), FigureError> {
    let done = written.and_then(|()| {
        std::fs::rename(temporary, path).map_err(|source| FigureError::Io { path: path.to_owned(), source })
    });
    if done.is_err() {
        let _ = std::fs::remove_file(temporary);
    }
    done
}
