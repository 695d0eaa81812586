//! A tuning from beginning to end: searched, resumed, sliced, mapped before and after, written.
//!
//! In: a take, how to search. Out: a [`TuneReport`], and its folder: patch, page, samples, report, figures. Every point costed is on disk
//! after each generation: a search that was stopped goes on where it was.

use std::path::{Path, PathBuf};

use motion::names::Word;
use scenes::patch::{Change, Patch};
use sim::EngineEntry;
use takes::results::figures::Draw;
use takes::results::folder::{Earlier, Folder, FolderError, Plan};
use takes::results::write::{Undrawn, write_report};
use takes::{Progress, Take, WriteError};

use super::journal::Head;
use super::report::{ConfirmedCosts, CostReport, MapReport};
use super::{
    Cost, Sample, Search, SearchResult, TuneError, TuneReport, TuneSpec, best, identity, journal, page,
    search, slices,
};
use crate::push::{self, PushMap, PushSettings};

/// Every point costed: the state of the search.
pub const SAMPLES: &str = "samples.csv";

/// How a tuning is done.
#[derive(Clone, Debug)]
pub struct Session {
    /// What is searched and what is costed.
    pub spec: TuneSpec,
    /// The walk.
    pub search: Search,
    /// Points of each cost slice; 0 makes none.
    pub slices: usize,
    /// Directions of the push maps before and after; 0 makes none.
    pub directions: usize,
    /// Whether figures are drawn.
    pub figures: bool,
    /// Whether an earlier run's samples are forgotten.
    pub fresh: bool,
}

/// Why nothing was tuned.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// Of the scene or of the state on disk.
    #[error(transparent)]
    Tune(#[from] TuneError),
    /// Of the folder.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// An earlier state that is no table of samples.
    #[error("{path}: {why}\n  help: --fresh begins anew, --out takes another folder")]
    State {
        /// The file.
        path: String,
        /// What is wrong.
        why: String,
    },
    /// A state that cannot be read, or a search that failed.
    #[error("{0}")]
    Run(String),
}

impl From<FolderError> for SessionError {
    fn from(e: FolderError) -> Self {
        Self::Write(e.into())
    }
}

impl SessionError {
    /// Whether the fault lies in the input rather than in the run.
    pub fn is_input(&self) -> bool {
        match self {
            Self::Tune(e) => e.is_input(),
            Self::Write(e) => e.is_input(),
            Self::State { .. } => true,
            Self::Run(_) => false,
        }
    }
}

fn plan(reads: &[PathBuf], earlier: Earlier) -> Plan<'_> {
    Plan { command: "tune", planned: &["patch.ron", "tune.html", SAMPLES, "report.json"], reads, earlier }
}

/// The state of a search in a folder.
struct State {
    path: PathBuf,
    identity: String,
    folder: Folder,
}

impl State {
    fn open(dir: &Path, identity: String, reads: &[PathBuf]) -> Result<Self, SessionError> {
        let folder = Folder::begin(dir, &plan(reads, Earlier::Keep))?;
        Ok(Self { path: dir.join(SAMPLES), identity, folder })
    }

    /// Samples that an interrupted run of the same search left.
    fn known(&self, spec: &TuneSpec) -> Result<Vec<Sample>, SessionError> {
        let shown = self.path.display().to_string();
        let text = match std::fs::read_to_string(&self.path) {
            Ok(text) => text,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(e) => return Err(SessionError::Run(format!("cannot read {shown}: {e}"))),
        };
        let table = journal::read(&text).map_err(|why| SessionError::State { path: shown.clone(), why })?;
        let head = Head::new(&self.identity, &spec.parameters);
        if table.head != head {
            let (found, needed) = (table.head.identity, head.identity);
            return Err(TuneError::Other { path: shown, found, needed }.into());
        }
        Ok(table.samples.into_iter().map(|(_, s)| s).collect())
    }

    fn keep(&mut self, spec: &TuneSpec, samples: &[Sample]) -> Result<(), String> {
        let text = Head::new(&self.identity, &spec.parameters).table(samples.iter().enumerate());
        let mut put = || {
            self.folder.add("samples_csv", SAMPLES)?;
            self.folder.write(SAMPLES, text.as_bytes())?;
            self.folder.commit()
        };
        put().map_err(|e: FolderError| e.to_string())
    }
}

impl Session {
    /// Checks, before a long search, that its results can be written into `dir`. `reads`: files that are never replaced.
    ///
    /// # Errors
    /// A folder that cannot be written to; a file in it that is not ours, or was read.
    pub fn check(dir: &Path, reads: &[PathBuf]) -> Result<(), WriteError> {
        Ok(Folder::check(dir, &plan(reads, Earlier::Keep))?)
    }

    /// Searches, and writes everything into `dir`. `known` is called with the
    /// number of points that an earlier run left. Points are costed in `engine`; `confirm` costs the scene as it was and the best
    /// point once more.
    ///
    /// # Errors
    /// [`SessionError`]. Figures that cannot be drawn are returned.
    pub fn run(
        &self,
        take: &Take,
        engine: &EngineEntry,
        confirm: Option<&EngineEntry>,
        dir: &Path,
        known: &mut dyn FnMut(usize),
        progress: &Progress<'_>,
    ) -> Result<(TuneReport, Vec<Undrawn>), SessionError> {
        let Self { spec, search: how, .. } = self;
        let cost = Cost::new(take, spec, engine)?;
        let mut state = State::open(dir, identity(take, spec, how), &take.files)?;
        let before = if self.fresh { Vec::new() } else { state.known(spec)? };
        known(before.len());
        progress.part("searching");
        let mut keep = |samples: &[Sample]| {
            // the last generation may go beyond what was asked for
            progress.at((samples.len() as f64 / how.evaluations as f64).min(1.0));
            state.keep(spec, samples)
        };
        let n = spec.parameters.len();
        let samples =
            search(&cost, n, how, before, &mut keep).map_err(|e| SessionError::Run(e.to_string()))?;
        let after = best(&samples).ok_or_else(|| SessionError::Run("no point was costed".into()))?.clone();
        let before = cost.evaluate(&take.tunable());
        let mut lines = Vec::new();
        if self.slices > 0 && self.figures {
            progress.part("slicing");
            lines = slices(&cost, &spec.parameters, &after, self.slices, &|x| progress.at(x));
        }
        let (maps, missing) = self.maps(take, engine, &cost, &after, progress);
        let confirmed = match confirm {
            None => None,
            Some(engine) => Some((engine.name().to_owned(), self.confirmed(take, engine, &after, progress)?)),
        };
        let result = SearchResult { before, after, confirmed, samples, slices: lines, maps, missing };
        drop(state);
        self.write(take, &cost, &result, dir, progress)
    }

    /// The scene as it was and the best point, costed in another engine.
    fn confirmed(
        &self,
        take: &Take,
        engine: &EngineEntry,
        best: &Sample,
        progress: &Progress<'_>,
    ) -> Result<[Sample; 2], TuneError> {
        progress.part("confirming");
        let cost = Cost::new(take, &self.spec, engine)?;
        let before = cost.evaluate(&take.tunable());
        progress.at(0.5);
        Ok([before, cost.evaluate(&cost.with_values(&best.values))])
    }

    /// Push maps of the take as it was and as it is tuned. A body that does not stand by itself has no map: a result here,
    /// not a failure.
    fn maps(
        &self,
        take: &Take,
        engine: &EngineEntry,
        cost: &Cost,
        best: &Sample,
        progress: &Progress<'_>,
    ) -> (Option<(PushMap, Option<PushMap>)>, Option<String>) {
        if self.directions == 0 {
            return (None, None);
        }
        let settings = PushSettings { directions: self.directions, ..PushSettings::default() };
        progress.part("map before");
        match push::map(take, settings, engine, &|x| progress.at(x)) {
            Err(e) => (None, Some(format!("before: {e}"))),
            Ok(before) => {
                progress.part("map after");
                let tuned = take.with_tunable(&cost.with_values(&best.values));
                let after = push::map(&tuned, settings, engine, &|x| progress.at(x));
                let missing = after.as_ref().err().map(|e| format!("after: {e}"));
                (Some((before, after.ok())), missing)
            }
        }
    }

    fn write(
        &self,
        take: &Take,
        cost: &Cost,
        result: &SearchResult,
        dir: &Path,
        progress: &Progress<'_>,
    ) -> Result<(TuneReport, Vec<Undrawn>), SessionError> {
        let Self { spec, search: how, .. } = self;
        let counts = (result.samples.len(), cost.runs());
        let mut report = TuneReport::new(
            (&take.name, cost.engine()),
            how,
            &spec.parameters,
            counts,
            &result.before,
            &result.after,
        );
        report.confirmed = (result.confirmed.as_ref()).map(|(engine, [before, after])| ConfirmedCosts {
            engine: engine.clone(),
            before: CostReport::of(before),
            after: CostReport::of(after),
        });
        report.push_map = result.maps.as_ref().map(|(a, b)| MapReport::of(a, b.as_ref()));
        report.push_map_missing.clone_from(&result.missing);
        let drawn = if self.figures { page::figures(take, result) } else { Vec::new() };
        let head = Head::new(&identity(take, spec, how), &spec.parameters);
        let samples = head.table(result.samples.iter().enumerate());
        let page = match drawn.is_empty() {
            true => None,
            false => Some(page::html(&report, &drawn).map_err(|e| WriteError::file("tune.html", e))?),
        };
        let mut data = |folder: &mut Folder| {
            let put = |folder: &mut Folder, what: &str, name: &str, text: &str| {
                folder.add(what, name)?;
                folder.write(name, text.as_bytes())
            };
            put(folder, "samples_csv", SAMPLES, &samples)?;
            put(folder, "patch_ron", "patch.ron", &self.patch(take, result))?;
            if let Some(page) = &page {
                put(folder, "page_html", "tune.html", page)?;
            }
            Ok(())
        };
        let figures: Vec<Draw<'_>> = (drawn.iter())
            .map(|(stem, figure)| -> Draw<'_> { (stem, Box::new(|| Ok(figure.clone()))) })
            .collect();
        let mut text = |files| {
            report.files = files;
            report.to_json()
        };
        let plan = plan(&take.files, Earlier::Remove);
        let undrawn = write_report(dir, &plan, &mut data, &figures, &mut text, progress)?;
        Ok((report, undrawn))
    }

    /// The patch that makes the scene what was found.
    fn patch(&self, take: &Take, result: &SearchResult) -> String {
        let changes = self.spec.parameters.iter().enumerate().map(|(i, parameter)| Change {
            parameter,
            was: Some(result.before.values[i]),
            is: result.after.values[i],
        });
        let patch = Patch { changes: changes.collect() };
        let comment = format!(
            "contrapposto tune of {}: {}, seed {}, {} points; cost {:.4} before, {:.4} after.\nApply it with --patch, or `patch: \"patch.ron\"` in the scene.",
            take.name,
            self.search.solver.word(),
            self.search.seed,
            result.samples.len(),
            result.before.cost,
            result.after.cost
        );
        patch.to_ron(&comment)
    }
}
