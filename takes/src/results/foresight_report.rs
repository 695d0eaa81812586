//! What foresight did and how the body walked, as `report.json` gives it under `dynamic.foresight`.
//!
//! In: an [`Outcome`]. Out: a [`ForesightReport`]; the definitions are those of [`dynamics::walked`].

use dynamics::Walked;
use serde::Serialize;
use sim::Outcome;

use crate::Take;

/// Foresight, and what came of it.
#[derive(Clone, Debug, Serialize)]
pub struct ForesightReport {
    /// Whether the offsets of an earlier run were performed again.
    pub replayed: bool,
    /// How far ahead it looked, s; null of a replay.
    pub horizon_s: Option<f64>,
    /// Rollouts of every window; null of a replay.
    pub rollouts: Option<usize>,
    /// Seed of the random numbers; null of a replay.
    pub seed: Option<u64>,
    /// Searches.
    pub searches: usize,
    /// Degrees of freedom whose targets were moved.
    pub channels: usize,
    /// RMS of the offsets of targets, degrees.
    pub offset_rms_deg: f64,
    /// The largest, degrees.
    pub offset_max_deg: f64,
    /// Whether the body kept its feet to the end.
    pub kept_feet: bool,
    /// How long it did, s.
    pub kept_s: f64,
    /// How it lost them, if it did.
    pub lost: Option<String>,
    /// While it kept its feet: RMS distance of link centres of mass from the motion asked for, mm.
    pub links_rms_mm: f64,
    /// The largest distance of the root along the ground from where it is asked, mm.
    pub away_mm: f64,
    /// Length of the way asked of the root along the ground, m.
    pub way_m: f64,
    /// Mean slip of a stance, mm.
    pub slip_mm: f64,
    /// Largest slip of a stance, mm.
    pub slip_mm_max: f64,
    /// Largest vertical force over 20 ms, body weights.
    pub peak_bw: f64,
    /// RMS of the force that nothing explains, % of body weight.
    pub unexplained_percent_bw: f64,
}

impl ForesightReport {
    /// How much foresight had to do, and how far the motion strayed, in words: what a verdict says of it.
    pub(crate) fn words(&self) -> String {
        let how = if self.replayed { "replayed: offsets moved" } else { "foresight moved" };
        format!(
            "{how} targets by {:.1}° RMS, links strayed {:.0} mm RMS",
            self.offset_rms_deg, self.links_rms_mm
        )
    }

    /// Of a run; `None` where foresight was not asked for or slept.
    pub(crate) fn new(take: &Take, outcome: &Outcome) -> Option<Self> {
        let used = outcome.foresight.as_ref()?;
        let rows = (take.asked.clip.duration_s() * outcome.trace.rate_hz + 1e-9).floor() as usize + 1;
        let walked = Walked::of(&outcome.trace, rows);
        Some(Self {
            replayed: used.settings.is_none(),
            horizon_s: used.settings.map(|s| s.horizon_s),
            rollouts: used.settings.map(|s| s.rollouts),
            seed: used.settings.map(|s| s.seed),
            searches: used.costs.len(),
            channels: used.channels.len(),
            offset_rms_deg: used.offset_rms().to_degrees(),
            offset_max_deg: used.offset_max().to_degrees(),
            kept_feet: walked.lost.is_none(),
            kept_s: walked.kept_s,
            lost: walked.lost.as_ref().map(|(_, loss)| loss.to_string()),
            links_rms_mm: walked.links_mm,
            away_mm: 1e3 * walked.away_m,
            way_m: walked.way_m,
            slip_mm: walked.slip_mm(),
            slip_mm_max: walked.slip_mm_max(),
            peak_bw: walked.peak,
            unexplained_percent_bw: walked.unexplained,
        })
    }
}
