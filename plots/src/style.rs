//! One look for all figures: colours, sizes, line widths, the typeface.
//!
//! Lengths are page pixels (1/96 inch in the SVG). Colours are those of Okabe and Ito, told apart with
//! every common colour blindness; meaning is never carried by red against green.
//!
//! M. Okabe, K. Ito. Color Universal Design, 2008.

use std::sync::LazyLock;

use plotters::style::{FontDesc, FontFamily, FontStyle, register_font};

/// An opaque colour, sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Color(pub u8, pub u8, pub u8);

impl Color {
    /// This colour with the share `t` (0 to 1) of `other`.
    pub fn mix(self, other: Color, t: f64) -> Color {
        let m = |a: u8, b: u8| (f64::from(a) + (f64::from(b) - f64::from(a)) * t).round() as u8;
        Color(m(self.0, other.0), m(self.1, other.1), m(self.2, other.2))
    }
}

/// Paper.
pub const WHITE: Color = Color(255, 255, 255);
/// Titles and labels.
pub const INK: Color = Color(38, 42, 48);
/// Notes, tick labels, times.
pub const SOFT: Color = Color(98, 105, 115);
/// Frames of panels.
pub const FRAME: Color = Color(176, 182, 190);
/// Grid lines.
pub const GRID: Color = Color(229, 232, 236);
/// Limits and references.
pub const REFERENCE: Color = Color(150, 150, 150);
/// First of a set: x, lower spring, left.
pub const BLUE: Color = Color(0, 114, 178);
/// Second of a set: y, upper spring, right.
pub const VERMILION: Color = Color(213, 94, 0);
/// Third of a set: z.
pub const GREEN: Color = Color(0, 158, 115);
/// Fourth of a set.
pub const PURPLE: Color = Color(170, 85, 140);

/// Width of data lines.
pub const LINE: f64 = 1.7;
/// Width of references, frames and the grid.
pub const THIN: f64 = 0.8;
/// Size of titles.
pub const TITLE: f64 = 20.0;
/// Size of labels and legends.
pub const LABEL: f64 = 13.0;
/// Size of tick labels and notes in panels.
pub const SMALL: f64 = 11.5;
/// White space around a page.
pub const MARGIN: f64 = 28.0;

/// The families an SVG asks for; a PNG is drawn with the embedded DejaVu Sans, whose widths Verdana shares.
pub(crate) const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";

/// plotters asks for sizes 1.24 times the em.
pub(crate) const EM: f64 = 1.24;

static FONT: LazyLock<bool> = LazyLock::new(|| {
    let bytes = include_bytes!("../assets/DejaVuSans.ttf");
    register_font(FAMILY, FontStyle::Normal, bytes).is_ok()
});

/// The embedded typeface at an em of `size` pixels.
pub(crate) fn font(size: f64) -> FontDesc<'static> {
    assert!(*FONT, "the embedded font is damaged");
    FontDesc::new(FontFamily::Name(FAMILY), size * EM, FontStyle::Normal)
}

/// Width of a text at an em of `size` pixels.
pub fn text_width(text: &str, size: f64) -> f64 {
    // measured large, because plotters rounds to whole pixels
    let big = 64.0;
    font(big).layout_box(text).map_or(0.0, |(_, (x, _))| f64::from(x) * size / big)
}
