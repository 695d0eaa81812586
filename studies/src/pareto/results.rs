//! A trade-off curve as a folder: report and figure.

use std::path::{Path, PathBuf};

use plots::TradePoint;
use takes::results::figures::Draw;
use takes::results::folder::{Earlier, Plan};
use takes::results::write::{Undrawn, write_report};
use takes::{Progress, WriteError};

use super::Pareto;

/// The figure's stem.
const FIGURE: &str = "pareto";

/// What a curve leaves in its folder; [`takes::results::folder::Folder::check`] with it finds out before many runs.
/// `reads`: files that are never replaced.
pub fn plan(reads: &[PathBuf]) -> Plan<'_> {
    Plan { command: "render --pareto", planned: &["report.json"], reads, earlier: Earlier::Remove }
}

impl Pareto {
    /// Writes the curve and its figure into `dir`, and names the files in [`Pareto::files`].
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

fn figure(curve: &Pareto) -> plots::Figure {
    let points: Vec<TradePoint> = curve
        .points
        .iter()
        .map(|p| TradePoint {
            fidelity: p.fidelity,
            force_rms_percent: p.force_rms_percent_bw.unwrap_or(f64::NAN),
            force_peak_percent: p.force_peak_percent_bw.unwrap_or(f64::NAN),
            budget_percent: 100.0 * p.force_budget_n / curve.weight_n,
            error_mm: p.position_rms_mm,
            error_deg: p.joint_rms_deg,
            stands: p.stands(),
        })
        .collect();
    let note = format!(
        "{}: {:.1} kg. Fidelity x allows the root x² of the body weight ({:.0} N) in help from outside. Numbers at the \
         dots are fidelities.",
        curve.scene, curve.mass_kg, curve.weight_n
    );
    plots::trade_off(&points, &note)
}
