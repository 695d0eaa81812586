//! Dynamic time warping: which frame of one series belongs to which of another \[SK83\].
//!
//! In: two series of frames with the same channels, in any unit (scale channels before, so that they count
//! alike). Out: the warping path, a chain of cells (i, j) from the first frames to the last that goes on by
//! (1, 1), (1, 0) or (0, 1) and has the least sum of
//!
//! ```text
//! c(i, j) = Σ_channels (a_i − b_j)²
//! ```
//!
//! Its root is the DTW distance of the literature. [`Limits`] keep a path plausible: a band around the
//! straight line between the ends (Sakoe-Chiba), a longest wait of one series for the other (slope), and
//! frames at the ends that may stay without a partner.
//!
//! Cells are worked on by antidiagonals, which do not depend on themselves: the compiler makes vector code of
//! them. Memory is one byte a cell in the band.
//!
//! \[SK83\] Sankoff, Kruskal. Time Warps, String Edits, and Macromolecules. Addison-Wesley 1983.
//! Sakoe, Chiba. Dynamic programming algorithm optimization for spoken word recognition. IEEE ASSP 1978.

mod path;
mod table;
#[cfg(test)]
mod tests;

pub use path::Path;

/// Most cells of a table: a byte each.
const MOST_CELLS: usize = 1 << 30;
/// Longest wait that can be a limit, in steps.
pub const LONGEST_WAIT: usize = 63;

/// Frames of a series, one after the other: frame i is `values[i * channels..][..channels]`.
#[derive(Clone, Copy, Debug)]
pub struct Series<'a> {
    /// Frames × channels.
    pub values: &'a [f64],
    /// Channels of a frame, at least 1.
    pub channels: usize,
}

impl<'a> Series<'a> {
    /// A series of one channel.
    pub fn one(values: &'a [f64]) -> Self {
        Series { values, channels: 1 }
    }

    fn frames(&self) -> usize {
        self.values.len() / self.channels
    }

    fn check(&self, name: &'static str) -> Result<(), DtwError> {
        if self.channels == 0 || self.values.is_empty() {
            return Err(DtwError::Empty { series: name });
        }
        if !self.values.len().is_multiple_of(self.channels) {
            return Err(DtwError::Ragged {
                series: name,
                values: self.values.len(),
                channels: self.channels,
            });
        }
        match self.values.iter().position(|v| !v.is_finite()) {
            Some(at) => Err(DtwError::NotFinite {
                series: name,
                frame: at / self.channels,
                channel: at % self.channels,
                value: self.values[at],
            }),
            None => Ok(()),
        }
    }
}

/// What a path may do. Without limits (the default) any monotone path from corner to corner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limits {
    /// Farthest from the straight line between the corners, in frames of the longer series; half a frame of
    /// the shorter one is added, so that 0 leaves the cells that the line passes. `None`: anywhere.
    pub band: Option<usize>,
    /// Most steps one series may wait while the other goes on, after which both go on together: local slopes
    /// stay between 1/(1 + wait) and 1 + wait. 0: both always go on; at most [`LONGEST_WAIT`], or as long as
    /// the longer series, which is none. `None`: any wait.
    pub wait: Option<usize>,
    /// Frames at either end of either series that may be without a partner, at no cost.
    pub loose: usize,
    /// Whether `a` is a piece of `b`: any number of frames at either end of `b` may be without a partner.
    pub piece: bool,
}

/// Why two series have no path.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DtwError {
    /// No frame or no channel.
    #[error("series {series} has no frames")]
    Empty {
        /// `a` or `b`.
        series: &'static str,
    },
    /// Values that do not fill frames.
    #[error("series {series} has {values} values, which do not fill frames of {channels} channels")]
    Ragged {
        /// `a` or `b`.
        series: &'static str,
        /// Its values.
        values: usize,
        /// Its channels.
        channels: usize,
    },
    /// NaN or infinite.
    #[error("series {series}, frame {frame}, channel {channel} is {value}")]
    NotFinite {
        /// `a` or `b`.
        series: &'static str,
        /// Which frame.
        frame: usize,
        /// Which channel.
        channel: usize,
        /// What is there.
        value: f64,
    },
    /// Series of different channels.
    #[error("series a has {a} channels, series b {b}: they are compared channel by channel")]
    Channels {
        /// Channels of a.
        a: usize,
        /// Channels of b.
        b: usize,
    },
    /// A table that is too large.
    #[error(
        "{a} by {b} frames are {cells} cells in the band, at most {MOST_CELLS} are worked on: narrow the band"
    )]
    TooLong {
        /// Frames of a.
        a: usize,
        /// Frames of b.
        b: usize,
        /// Cells.
        cells: usize,
    },
    /// A limit on waits that is too wide to be one.
    #[error(
        "a wait of at most {wait} steps: a limit is 0 to {LONGEST_WAIT}, or none ({frames} frames cannot wait longer)"
    )]
    Wait {
        /// The limit.
        wait: usize,
        /// Frames of the longer series.
        frames: usize,
    },
    /// No path keeps the limits.
    #[error("{a} and {b} frames cannot be matched with a wait of at most {wait} steps, {loose} loose frames at each end{}",
        .band.map_or(String::new(), |b| format!(" and a band of {b} frames")))]
    NoPath {
        /// Frames of a.
        a: usize,
        /// Frames of b.
        b: usize,
        /// The limit on waits.
        wait: usize,
        /// Loose frames.
        loose: usize,
        /// The band.
        band: Option<usize>,
    },
}

/// The cheapest path through two series under limits. Ties go to the step of both, then to that of `a`.
///
/// # Errors
/// Series that are empty, ragged, not finite, or of different channels; too many cells; limits that leave no
/// path.
///
/// # Examples
/// ```
/// use learn::dtw::{Limits, Series, align};
///
/// let slow: Vec<f64> = (0..100).map(|i| (0.1 * i as f64).sin()).collect();
/// let fast: Vec<f64> = (0..50).map(|i| (0.2 * i as f64).sin()).collect();
/// let path = align(Series::one(&slow), Series::one(&fast), Limits::default())?;
/// assert!((path.partners_of_a()[60] - 30.0).abs() <= 0.5);
/// # Ok::<(), learn::dtw::DtwError>(())
/// ```
pub fn align(a: Series, b: Series, limits: Limits) -> Result<Path, DtwError> {
    a.check("a")?;
    b.check("b")?;
    if a.channels != b.channels {
        return Err(DtwError::Channels { a: a.channels, b: b.channels });
    }
    table::cheapest(a, b, limits)
}
