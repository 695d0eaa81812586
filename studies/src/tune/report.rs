//! The numbers of a tuning, as JSON.
//!
//! In: samples, the best, push maps before and after. Out: a [`TuneReport`]; units are in the names or beside the
//! numbers.

use std::collections::BTreeMap;

use controllers::Parameter;
use motion::names::Word;
use serde::Serialize;

use super::search::{Sample, Search};
use crate::push::PushMap;
use scenes::tune_spec::TERMS;

/// The numbers of a tuning. `docs/TUNE.md` is the guide.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TuneReport {
    /// Name of the scene.
    pub scene: String,
    /// Name of the solver.
    pub solver: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// `scene` or `random`.
    pub start: &'static str,
    /// Points costed.
    pub evaluations: usize,
    /// Runs simulated for each.
    pub runs: usize,
    /// The cost of the scene as it was.
    pub before: CostReport,
    /// The cost of the best point.
    pub after: CostReport,
    /// Engine in which points were costed.
    pub engine: String,
    /// The same two costs in a second engine; null where none was asked.
    pub confirmed: Option<ConfirmedCosts>,
    /// What changed, by parameter in the order of the table.
    pub parameters: Vec<ParameterReport>,
    /// The full push map before and after; null where none was asked for or a body does not stand.
    pub push_map: Option<MapReport>,
    /// Why there is no push map, or none after; null where there is.
    pub push_map_missing: Option<String>,
    /// Files written, by what they hold; paths relative to the report.
    pub files: BTreeMap<String, String>,
}

/// Costs in a second engine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ConfirmedCosts {
    /// The second engine.
    pub engine: String,
    /// The cost of the scene as it was.
    pub before: CostReport,
    /// The cost of the best point.
    pub after: CostReport,
}

/// One cost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CostReport {
    /// The weighted sum.
    pub cost: f64,
    /// The terms, unweighted.
    pub terms: BTreeMap<&'static str, f64>,
    /// Runs survived.
    pub survived: usize,
}

impl CostReport {
    /// Of a sample.
    pub fn of(s: &Sample) -> Self {
        let terms = TERMS.into_iter().zip(s.terms.iter().copied()).collect();
        Self { cost: s.cost, terms, survived: s.survived }
    }
}

/// One parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterReport {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its value in the scene.
    pub was: f64,
    /// Its best value found.
    pub is: f64,
    /// Least value searched.
    pub from: f64,
    /// Largest value searched.
    pub to: f64,
}

/// Push maps before and after, in short.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MapReport {
    /// Mean of survived over limit before.
    pub mean_ratio_before: f64,
    /// The same after; null if the body does not stand by itself.
    pub mean_ratio_after: Option<f64>,
    /// Least of survived over limit before.
    pub min_ratio_before: f64,
    /// The same after.
    pub min_ratio_after: Option<f64>,
    /// Mean after over mean before.
    pub after_over_before: Option<f64>,
    /// Directions, degrees.
    pub deg: Vec<f64>,
    /// Survived before, N·s.
    pub survived_ns_before: Vec<f64>,
    /// Survived after, N·s.
    pub survived_ns_after: Option<Vec<f64>>,
}

impl MapReport {
    /// Of two maps of the same directions.
    pub fn of(before: &PushMap, after: Option<&PushMap>) -> Self {
        let survived = |m: &PushMap| m.directions.iter().map(|d| d.survived_ns).collect();
        Self {
            mean_ratio_before: before.mean_ratio,
            mean_ratio_after: after.map(|m| m.mean_ratio),
            min_ratio_before: before.min_ratio,
            min_ratio_after: after.map(|m| m.min_ratio),
            after_over_before: after.map(|m| m.mean_ratio / before.mean_ratio),
            deg: before.directions.iter().map(|d| d.deg).collect(),
            survived_ns_before: survived(before),
            survived_ns_after: after.map(survived),
        }
    }
}

impl TuneReport {
    /// From what was found; files are added by who writes them.
    pub fn new(
        (scene, engine): (&str, &str),
        how: &Search,
        parameters: &[&'static Parameter],
        (evaluations, runs): (usize, usize),
        before: &Sample,
        after: &Sample,
    ) -> Self {
        let change = |(i, p): (usize, &&'static Parameter)| ParameterReport {
            name: p.name,
            unit: p.unit,
            was: before.values[i],
            is: after.values[i],
            from: p.lo,
            to: p.hi,
        };
        Self {
            scene: scene.into(),
            solver: how.solver.word().into(),
            seed: how.seed,
            start: how.start_name().word(),
            evaluations,
            runs,
            before: CostReport::of(before),
            after: CostReport::of(after),
            engine: engine.into(),
            confirmed: None,
            parameters: parameters.iter().enumerate().map(change).collect(),
            push_map: None,
            push_map_missing: None,
            files: BTreeMap::new(),
        }
    }

    /// As JSON, ended by a newline.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("numbers and text") + "\n"
    }
}
