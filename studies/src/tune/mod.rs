//! Tuning: parameters of tension and balance chosen by a search over a cost the scene declares.
//!
//! ```text
//! Take, TuneSpec ─→ Cost ─→ search ─→ samples ─→ best ─→ slices, maps before and after ─→ patch, report
//!                       └──→ sweep: a grid, split over jobs
//! ```
//!
//! | module | holds |
//! |---|---|
//! | [`cost`] | the terms, the runs |
//! | [`search`](mod@search) | the walk of a solver, resumable |
//! | [`cmaes`] | CMA-ES as a solver of argmin |
//! | [`point`] | points of the unit cube |
//! | [`journal`] | samples as CSV |
//! | [`digest`](mod@digest) | what names the input of a tuning |
//! | [`sweep`], [`sweep_results`] | grids, shards, merging; their table and figure |
//! | [`report`], [`page`] | the numbers of a tuning; its figures and its page |
//! | [`session`] | a tuning from beginning to end |
//!
//! Same scene, same seed: same samples, on any number of threads, in one go or resumed. `docs/TUNE.md` is the guide.

pub mod cmaes;
pub mod cost;
pub mod digest;
pub mod journal;
pub mod page;
pub mod point;
pub mod report;
pub mod search;
pub mod search_result;
pub mod session;
pub mod sweep;
pub mod sweep_results;

use controllers::Parameter;
use dynamics::digest::Digest;
use motion::names::Word;
use rayon::prelude::*;

pub use cost::Cost;
pub use digest::digest;
pub use report::TuneReport;
pub use scenes::tune_spec::{FixedPush, MOST_PUSHES, TERMS, TuneSpec, named};
pub use search::{Objective, Sample, Search, SearchStart, SolverKind, search};
pub use search_result::SearchResult;
pub use session::{Session, SessionError};
pub use sweep::{Axis, Grid, Shard, SweepError};

use takes::Take;

/// Why nothing is tuned.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TuneError {
    /// A body that something else than its feet holds.
    #[error(
        "{scene}: {what}; tuning needs a free root, ground that stays, gravity downwards, and planted feet"
    )]
    Held {
        /// The scene.
        scene: String,
        /// What is in the way.
        what: String,
    },
    /// A cost without a run.
    #[error("{scene}: its `tune` section has neither pushes nor its own run, so there is nothing to cost")]
    Nothing {
        /// The scene.
        scene: String,
    },
    /// A state on disk that is another search's.
    #[error(
        "{path} is of another run\n  found:  {found}\n  needed: {needed}\n  help: --fresh begins anew, --out takes another folder"
    )]
    Other {
        /// The file.
        path: String,
        /// What its first line says.
        found: String,
        /// What it should say.
        needed: String,
    },
    /// A state that cannot be read or written.
    #[error("{path}: {why}")]
    File {
        /// The file.
        path: String,
        /// What is wrong.
        why: String,
    },
}

impl TuneError {
    /// Whether the fault lies in the input rather than in the run.
    pub fn is_input(&self) -> bool {
        !matches!(self, Self::File { .. })
    }
}

/// What names a search, but for its length: the first line of its samples.
pub fn identity(take: &Take, spec: &TuneSpec, how: &Search) -> String {
    let start = match &how.start {
        None => SearchStart::Random.word().into(),
        Some(u) => {
            let mut d = Digest::default();
            d.list(u, |d, x| d.number(*x));
            d.hex()
        }
    };
    format!(
        "contrapposto tune of {}: solver={} seed={} start={start} step={} input={}",
        take.name,
        how.solver.word(),
        how.seed,
        how.step,
        digest(take, spec)
    )
}

/// One parameter varied about the best point.
#[derive(Clone, Debug, PartialEq)]
pub struct Slice {
    /// The parameter.
    pub parameter: &'static Parameter,
    /// Value and cost, by value.
    pub points: Vec<(f64, f64)>,
}

/// Costs along every axis through the best values: `points` values a parameter, evenly over its range, and the best.
pub fn slices(
    cost: &Cost,
    parameters: &[&'static Parameter],
    best: &Sample,
    points: usize,
    progress: &(dyn Fn(f64) + Sync),
) -> Vec<Slice> {
    let jobs: Vec<(usize, usize)> =
        (0..parameters.len()).flat_map(|p| (0..points).map(move |k| (p, k))).collect();
    let done = std::sync::atomic::AtomicUsize::new(0);
    let costs: Vec<(f64, f64)> = jobs
        .par_iter()
        .with_max_len(1)
        .map(|&(p, k)| {
            let value = parameters[p].at(k as f64 / (points - 1).max(1) as f64);
            let mut values = best.values.clone();
            values[p] = value;
            let sample = cost.evaluate(&cost.with_values(&values));
            let n = 1 + done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            progress(n as f64 / jobs.len() as f64);
            (value, sample.cost)
        })
        .collect();
    parameters
        .iter()
        .enumerate()
        .map(|(p, parameter)| {
            let mut line = costs[p * points..(p + 1) * points].to_vec();
            line.push((best.values[p], best.cost));
            line.sort_by(|a, b| a.0.total_cmp(&b.0));
            line.dedup_by(|a, b| a.0 == b.0);
            Slice { parameter, points: line }
        })
        .collect()
}

/// All parameters there are.
pub fn parameters() -> &'static [Parameter] {
    controllers::PARAMETERS
}

/// What a parameter is and what turning it does; empty for a name that is none.
pub fn meaning(name: &str) -> &'static str {
    controllers::parameter(name).map_or("", |p| p.meaning)
}

/// The best of some samples: least cost, the first of equals.
pub fn best(samples: &[Sample]) -> Option<&Sample> {
    samples.iter().min_by(|a, b| a.cost.total_cmp(&b.cost))
}
