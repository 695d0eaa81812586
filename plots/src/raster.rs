//! The pixels of a page: a plotters backend that draws a band of rows at four times the page's resolution.
//!
//! In: the calls of plotters' drawing. Out: RGB, averaged down. A band fits a cache, is drawn without regard to others, and is filled row by row;
//! plotters' own bitmap sweeps polygons through sorted lists of edges, on a page of a hundred megabytes.

use std::convert::Infallible;

use plotters_backend::{BackendColor, BackendCoord, BackendStyle, DrawingBackend, DrawingErrorKind};

/// What drawing returns: it cannot fail.
type Drawn = Result<(), DrawingErrorKind<Infallible>>;

/// Some rows of a page, in subpixels.
pub(crate) struct Band {
    /// Of the whole page, subpixels.
    size: (u32, u32),
    /// First row.
    top: i32,
    rows: i32,
    /// 0x00BBGGRR, row by row.
    pixels: Vec<u32>,
    /// Where the edges of a polygon cross each of its rows here: how many, and the first two.
    crossings: Vec<(u32, [f64; 2])>,
    /// Where they cross one row, if there are more.
    many: Vec<f64>,
}

impl Band {
    /// Without rows, of a page of so many subpixels.
    pub fn new(size: (u32, u32)) -> Self {
        Self { size, top: 0, rows: 0, pixels: Vec::new(), crossings: Vec::new(), many: Vec::new() }
    }

    /// Goes to other rows, black.
    pub fn start(&mut self, top: i32, rows: i32) {
        (self.top, self.rows) = (top, rows);
        self.pixels.clear();
        self.pixels.resize(self.size.0 as usize * rows as usize, 0);
    }

    /// Writes the means of `step` × `step` subpixels (at most 16 × 16), RGB, row by row.
    pub fn average(&self, step: usize, out: &mut [u8]) {
        let stride = self.size.0 as usize;
        let n = (step * step) as u32;
        // red and blue in one number, green in the other
        let mut sums = vec![(0_u32, 0_u32); stride / step];
        for (row, out) in
            self.pixels.chunks_exact(step * stride).zip(out.chunks_exact_mut(3 * (stride / step)))
        {
            sums.fill((0, 0));
            for line in row.chunks_exact(stride) {
                for ((red_blue, green), fine) in sums.iter_mut().zip(line.chunks_exact(step)) {
                    for p in fine {
                        *red_blue += p & 0x00ff_00ff;
                        *green += (p >> 8) & 0xff;
                    }
                }
            }
            for (out, (red_blue, green)) in out.chunks_exact_mut(3).zip(&sums) {
                let mean = |sum: u32| ((sum + n / 2) / n) as u8;
                out.copy_from_slice(&[mean(red_blue & 0xffff), mean(*green), mean(red_blue >> 16)]);
            }
        }
    }

    /// The columns `from..=to` of a row, as far as they are here.
    fn row(&mut self, y: i32, from: i32, to: i32) -> Option<&mut [u32]> {
        let line = y - self.top;
        let (from, to) = (from.max(0), to.min(self.size.0 as i32 - 1));
        if !(0..self.rows).contains(&line) || from > to {
            return None;
        }
        let start = line as usize * self.size.0 as usize;
        Some(&mut self.pixels[start + from as usize..=start + to as usize])
    }

    /// Fills the columns `from..=to` of a row.
    fn span(&mut self, y: i32, from: i32, to: i32, color: BackendColor) {
        let Some(row) = self.row(y, from, to) else { return };
        let (r, g, b) = color.rgb;
        if color.alpha >= 1.0 {
            row.fill(u32::from_le_bytes([r, g, b, 0]));
        } else if color.alpha > 0.0 {
            let share = (256.0 * color.alpha).round() as i32;
            for p in row {
                let mut rgb = p.to_le_bytes();
                for (old, new) in rgb.iter_mut().zip([r, g, b]) {
                    let was = i32::from(*old);
                    *old = (was + (((i32::from(new) - was) * share) >> 8)) as u8;
                }
                *p = u32::from_le_bytes(rgb);
            }
        }
    }

    /// Fills a row from `x0` to `x1`, the subpixels at its ends by their share.
    fn between(&mut self, y: i32, x0: f64, x1: f64, color: BackendColor) {
        let (first, last) = (x0.ceil() as i32, x1.floor() as i32);
        let part = |alpha: f64| BackendColor { alpha: alpha * color.alpha, ..color };
        if first > last {
            self.span(y, last, last, part(x1 - x0));
            return;
        }
        self.span(y, first, last, color);
        if f64::from(first) > x0 {
            self.span(y, first - 1, first - 1, part(f64::from(first) - x0));
        }
        if x1 > f64::from(last) {
            self.span(y, last + 1, last + 1, part(x1 - f64::from(last)));
        }
    }

    /// The rows of this band among some.
    fn within(&self, from: i32, to: i32) -> std::ops::RangeInclusive<i32> {
        from.max(self.top)..=to.min(self.top + self.rows - 1)
    }
}

impl DrawingBackend for Band {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Drawn {
        self.span(y, x, x, color);
        Ok(())
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Drawn {
        if from.0 != to.0 && from.1 != to.1 {
            return plotters_backend::rasterizer::draw_line(self, from, to, style);
        }
        for y in self.within(from.1.min(to.1), from.1.max(to.1)) {
            self.span(y, from.0.min(to.0), from.0.max(to.0), style.color());
        }
        Ok(())
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Drawn {
        if !fill {
            return plotters_backend::rasterizer::draw_rect(self, from, to, style, fill);
        }
        for y in self.within(from.1.min(to.1), from.1.max(to.1)) {
            self.span(y, from.0.min(to.0), from.0.max(to.0), style.color());
        }
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        center: BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Drawn {
        if !fill {
            return plotters_backend::rasterizer::draw_circle(self, center, radius, style, fill);
        }
        let r = radius as i32;
        for y in self.within(center.1 - r, center.1 + r) {
            let half = f64::from(r * r - (y - center.1).pow(2)).max(0.0).sqrt();
            self.between(y, f64::from(center.0) - half, f64::from(center.0) + half, style.color());
        }
        Ok(())
    }

    /// Even-odd, both ends of rows and of columns included, as plotters has it.
    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        corners: I,
        style: &S,
    ) -> Drawn {
        let corners: Vec<BackendCoord> = corners.into_iter().collect();
        let (Some(low), Some(high)) = (corners.iter().map(|c| c.1).min(), corners.iter().map(|c| c.1).max())
        else {
            return Ok(());
        };
        if low == high {
            let xs = || corners.iter().map(|c| c.0);
            let (Some(from), Some(to)) = (xs().min(), xs().max()) else { return Ok(()) };
            self.span(low, from, to, style.color());
            return Ok(());
        }
        let rows = self.within(low, high);
        let (from, to) = (*rows.start(), *rows.end());
        if from > to {
            return Ok(());
        }
        let (mut crossings, mut many) = (std::mem::take(&mut self.crossings), std::mem::take(&mut self.many));
        crossings.clear();
        crossings.resize((to - from + 1) as usize, (0, [0.0; 2]));
        for edge in edges(&corners, high) {
            for y in edge.first.max(from)..=edge.last.min(to) {
                let (count, at) = &mut crossings[(y - from) as usize];
                if let Some(at) = at.get_mut(*count as usize) {
                    *at = edge.at(y);
                }
                *count += 1;
            }
        }
        for (y, (count, [a, b])) in rows.zip(&crossings) {
            if *count <= 2 {
                if *count == 2 {
                    self.between(y, a.min(*b), a.max(*b), style.color());
                }
                continue;
            }
            many.clear();
            let crossing = |edge: &Edge| (edge.first..=edge.last).contains(&y);
            many.extend(edges(&corners, high).filter(crossing).map(|edge| edge.at(y)));
            many.sort_unstable_by(f64::total_cmp);
            for pair in many.chunks_exact(2) {
                self.between(y, pair[0], pair[1], style.color());
            }
        }
        (self.crossings, self.many) = (crossings, many);
        Ok(())
    }
}

/// An edge of a polygon, and the rows that it crosses.
struct Edge {
    upper: BackendCoord,
    slope: f64,
    first: i32,
    last: i32,
}

impl Edge {
    /// The column at which it crosses a row.
    fn at(&self, y: i32) -> f64 {
        f64::from(self.upper.0) + self.slope * f64::from(y - self.upper.1)
    }
}

/// The edges of a polygon that cross rows. Edges end before their last row, so that each corner counts once, but at the polygon's own last row, where all that
/// come there end.
fn edges(corners: &[BackendCoord], high: i32) -> impl Iterator<Item = Edge> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).filter(|(a, b)| a.1 != b.1).map(move |(&a, &b)| {
        let (upper, lower) = if a.1 < b.1 { (a, b) } else { (b, a) };
        let slope = f64::from(lower.0 - upper.0) / f64::from(lower.1 - upper.1);
        let last = if lower.1 == high { high } else { lower.1 - 1 };
        Edge { upper, slope, first: upper.1, last }
    })
}
