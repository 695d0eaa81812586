//! The trade between fidelity and help: the same motion under assists of growing budget.
//!
//! In: a [`Take`] (its own tension, before any fidelity) and fidelities. Out: a [`Pareto`]: per fidelity what the assist did and how far the motion
//! performed is from the one asked for. Each run is by itself: the same on any number of threads.
//!
//! A point is *efficient* if no other that stands needs less force (RMS) and follows as closely.

pub mod results;

use std::collections::BTreeMap;
use std::sync::Mutex;

use rayon::prelude::*;
use serde::Serialize;
use sim::{EngineEntry, PassError};

use dynamics::RootMode;
use takes::Take;
use takes::results::report::{DynamicReport, Report};
use takes::results::verdict_report::VerdictReport;

/// Fidelities of a curve that asks for none.
pub const FIDELITIES: [f64; 10] = [0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.55, 0.75, 1.0];

/// One run.
#[derive(Clone, Debug, Serialize)]
pub struct ParetoPoint {
    /// From 0 (free) to 1.
    pub fidelity: f64,
    /// Largest force allowed, N.
    pub force_budget_n: f64,
    /// Largest moment allowed, N·m.
    pub moment_budget_nm: f64,
    /// RMS of the assist's force, N; zero when free.
    pub force_rms_n: f64,
    /// That over body weight, %; null without weight.
    pub force_rms_percent_bw: Option<f64>,
    /// Its peak, N.
    pub force_peak_n: f64,
    /// That over body weight, %; null without weight.
    pub force_peak_percent_bw: Option<f64>,
    /// RMS of its moment, N·m.
    pub moment_rms_nm: f64,
    /// Peak of its moment, N·m.
    pub moment_peak_nm: f64,
    /// Integral of its force's magnitude, N·s.
    pub impulse_ns: f64,
    /// RMS distance of the links' origins to the motion asked for, mm.
    pub position_rms_mm: f64,
    /// RMS angle to the motion asked for, over all joints but wrists, degrees.
    pub joint_rms_deg: f64,
    /// How it was performed.
    pub verdict: VerdictReport,
    /// When the body fell, s; null if it stands.
    pub fell_at_s: Option<f64>,
    /// Why the run stopped early; null if it did not.
    pub diverged: Option<String>,
    /// Whether no other point that stands needs less force and follows as closely.
    pub efficient: bool,
}

impl ParetoPoint {
    /// Whether the body stands to the end.
    pub fn stands(&self) -> bool {
        self.fell_at_s.is_none() && self.diverged.is_none()
    }

    fn new(fidelity: f64, root: RootMode, d: &DynamicReport) -> Self {
        let (force_budget_n, moment_budget_nm) = match root {
            RootMode::Assisted { force_n, moment_nm } => (force_n, moment_nm),
            RootMode::Free | RootMode::Pinned => (0.0, 0.0),
        };
        // a free root's residual is the error of the integrator: no help
        let help = |x: f64| if root == RootMode::Free { 0.0 } else { x };
        let r = &d.root;
        Self {
            fidelity,
            force_budget_n,
            moment_budget_nm,
            force_rms_n: help(r.residual_force_rms_n),
            force_rms_percent_bw: r.residual_force_rms_percent_bw.map(help),
            force_peak_n: help(r.residual_force_peak_n),
            force_peak_percent_bw: r.residual_force_peak_percent_bw.map(help),
            moment_rms_nm: help(r.residual_moment_rms_nm),
            moment_peak_nm: help(r.residual_moment_peak_nm),
            impulse_ns: help(r.impulse_ns),
            position_rms_mm: d.position_rms_mm,
            joint_rms_deg: d.joint_rms_deg,
            verdict: d.verdict.clone(),
            fell_at_s: d.fell_at_s,
            diverged: d.diverged.clone(),
            efficient: false,
        }
    }
}

/// A curve, as `report.json` has it.
#[derive(Clone, Debug, Serialize)]
pub struct Pareto {
    /// Name of the scene or clip.
    pub scene: String,
    /// Mass of the body, kg.
    pub mass_kg: f64,
    /// Body weight, N.
    pub weight_n: f64,
    /// One run per fidelity, ascending.
    pub points: Vec<ParetoPoint>,
    /// Files written, by what they hold.
    pub files: BTreeMap<String, String>,
}

impl Pareto {
    /// The curve as indented JSON with a final newline.
    pub fn to_json(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).expect("a curve has no maps with odd keys");
        text.push('\n');
        text
    }
}

/// Performs a take at every fidelity (from 0 to 1; in any order, doubles once); `progress` gets the fraction done.
///
/// # Errors
/// [`PassError`] when a pass cannot start.
pub fn pareto(
    take: &Take,
    fidelities: &[f64],
    engine: &EngineEntry,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Pareto, PassError> {
    let mut fidelities = fidelities.to_vec();
    fidelities.sort_by(f64::total_cmp);
    fidelities.dedup();
    let done = Mutex::new(vec![0.0; fidelities.len()]);
    let run = |(i, &f): (usize, &f64)| {
        let take = take.with_fidelity(f);
        let root = take.conditions.physics.root;
        let outcome = take.pass().run(engine, &mut |x| {
            if let Ok(mut done) = done.lock() {
                done[i] = x / fidelities.len() as f64;
                progress(done.iter().sum());
            }
        })?;
        let report = Report::of(&take, Some(&outcome), &[]);
        let dynamic = report.dynamic.expect("a report of an outcome has its numbers");
        Ok(ParetoPoint::new(f, root, &dynamic))
    };
    let points: Result<Vec<ParetoPoint>, PassError> = fidelities.par_iter().enumerate().map(run).collect();
    let mut points = points?;
    mark_efficient(&mut points);
    Ok(Pareto {
        scene: take.name.clone(),
        mass_kg: take.body.character.mass(),
        weight_n: take.body.character.mass() * take.conditions.physics.gravity.norm(),
        points,
        files: BTreeMap::new(),
    })
}

/// Marks the points that no other dominates.
fn mark_efficient(points: &mut [ParetoPoint]) {
    let numbers: Vec<Option<(f64, f64)>> =
        points.iter().map(|p| p.stands().then_some((p.force_rms_n, p.position_rms_mm))).collect();
    for (i, p) in points.iter_mut().enumerate() {
        let Some((force, error)) = numbers[i] else { continue };
        let better = |&(f, e): &(f64, f64)| f <= force && e <= error && (f < force || e < error);
        p.efficient = !numbers.iter().flatten().any(better);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(force: f64, error: f64, fell: Option<f64>) -> ParetoPoint {
        ParetoPoint {
            fidelity: 0.0,
            force_budget_n: 0.0,
            moment_budget_nm: 0.0,
            force_rms_n: force,
            force_rms_percent_bw: Some(0.0),
            force_peak_n: 0.0,
            force_peak_percent_bw: Some(0.0),
            moment_rms_nm: 0.0,
            moment_peak_nm: 0.0,
            impulse_ns: 0.0,
            position_rms_mm: error,
            joint_rms_deg: 0.0,
            verdict: VerdictReport { grade: "", text: String::new(), reasons: Vec::new() },
            fell_at_s: fell,
            diverged: None,
            efficient: false,
        }
    }

    /// A point is efficient unless another that stands is as good in both and better in one.
    #[test]
    fn dominated_points_are_not_efficient() {
        let mut points =
            [point(0.0, 9.0, Some(1.0)), point(1.0, 5.0, None), point(2.0, 6.0, None), point(3.0, 1.0, None)];
        mark_efficient(&mut points);
        assert_eq!(points.map(|p| p.efficient), [false, true, false, true]);
    }
}
