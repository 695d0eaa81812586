//! A push map as a folder: report and polar figure.

use std::path::{Path, PathBuf};

use plots::Spoke;
use takes::results::figures::Draw;
use takes::results::folder::{Earlier, Plan};
use takes::results::write::{Undrawn, write_report};
use takes::{Progress, WriteError};

use super::PushMap;

/// The figure's stem.
const FIGURE: &str = "push";

/// What a push map leaves in its folder; [`takes::results::folder::Folder::check`] with it finds out before a long search.
/// `reads`: files that are never replaced.
pub fn plan(reads: &[PathBuf]) -> Plan<'_> {
    Plan { command: "push", planned: &["report.json"], reads, earlier: Earlier::Remove }
}

impl PushMap {
    /// Writes the map and its figure into `dir`, and names the files in [`PushMap::files`].
    ///
    /// # Errors
    /// [`WriteError`]. A figure that cannot be drawn is returned.
    pub fn write(
        &mut self,
        dir: &Path,
        figures: bool,
        reads: &[PathBuf],
        progress: &Progress<'_>,
    ) -> Result<Vec<Undrawn>, WriteError> {
        let picture = self.clone();
        let drawn: [Draw<'_>; 1] = [(FIGURE, Box::new(|| Ok(figure(&picture))))];
        let drawn = if figures { &drawn[..] } else { &[] };
        let mut report = |files| {
            self.files = files;
            self.to_json()
        };
        write_report(dir, &plan(reads), &mut |_| Ok(()), drawn, &mut report, progress)
    }
}

fn figure(map: &PushMap) -> plots::Figure {
    let spokes: Vec<Spoke> = map
        .directions
        .iter()
        .map(|d| Spoke { deg: d.deg, survived: d.survived_ns, limit: d.limit_ns })
        .collect();
    let note = format!(
        "{}: {:.1} kg, pushed for {:.3} s at its centre of mass, {:.2} m high ({}), simulated by {}. Survived without a step: {:.0} % of \
         the limit on average, {:.0} % at least.",
        map.scene,
        map.mass_kg,
        map.push_s,
        map.com_height_m,
        map.push_link,
        map.engine,
        100.0 * map.mean_ratio,
        100.0 * map.min_ratio
    );
    plots::push_map(&spokes, &note)
}
