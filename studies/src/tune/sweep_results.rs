//! A sweep as a folder: the table of samples, and the cost along each axis.
//!
//! The table is the state of the sweep and is appended to by jobs that may run at once, so it is not part of a folder that is
//! replaced as a whole.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use plots::CostSlice;
use takes::WriteError;
use takes::results::write::write_figure;

use super::journal::Head;
use super::{Sample, parameters};

/// The table of samples.
pub const TABLE: &str = "sweep.csv";
/// The figure's stem.
const FIGURE: &str = "sweep";

/// The best of a table: its index and sample.
pub fn best(all: &BTreeMap<usize, Sample>) -> Option<(&usize, &Sample)> {
    all.iter().min_by(|a, b| a.1.cost.total_cmp(&b.1.cost))
}

/// Draws the cost along each axis into `plots` of `dir`; the files written.
///
/// # Errors
/// Of the folder and of the figure.
pub fn draw(dir: &Path, head: &Head, all: &BTreeMap<usize, Sample>) -> Result<Vec<PathBuf>, WriteError> {
    let best = best(all);
    let slices: Vec<CostSlice> =
        head.parameters().iter().enumerate().map(|(k, name)| slice(k, name, all, best)).collect();
    let note = format!("{} samples of a grid.", all.len());
    let figure = plots::cost_slices(&slices, "Cost along each axis of the sweep", &note);
    write_figure(dir, "tune --sweep", FIGURE, &figure)
}

/// One axis: all samples, and the least cost at each of its values.
fn slice(k: usize, name: &str, all: &BTreeMap<usize, Sample>, best: Option<(&usize, &Sample)>) -> CostSlice {
    let cloud: Vec<[f64; 2]> = all.values().map(|s| [s.values[k], s.cost]).collect();
    let mut points = cloud.clone();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup_by(|b, a| a[0] == b[0]);
    CostSlice {
        name: name.into(),
        unit: parameters().iter().find(|p| p.name == name).map_or("", |p| p.unit).into(),
        points,
        cloud,
        was: None,
        is: best.map(|(_, s)| [s.values[k], s.cost]),
    }
}
