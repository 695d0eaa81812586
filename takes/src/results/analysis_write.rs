//! An analysis as a folder: tables, report, figures; and figures alone, beside a run.
//!
//! In: a motion and its analysis, a folder. Out: files, and the report that names them.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use dynamics::Analysis;
use formats::analysis;
use motion::names::Word;
use serde_json::{Value, json};

use super::analysis_figures::{AnalysisFigure, Drawing, DrawingError};
use super::figures::Draw;
use super::folder::{Earlier, Folder, FolderError, Overwrite, Plan, write_file};
use super::write::{PLOTS, Undrawn, WriteError, Written, write_report};
use crate::{AnalysisInput, AnalysisReport, Progress};

/// A form in which an analysis is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Table {
    /// Everything, one row per frame; angles in degrees.
    Csv,
    /// OpenSim motion files of joint torques and ground reactions.
    Mot,
    /// Numpy arrays, SI and radians.
    Npz,
}

impl Word for Table {
    const KIND: &'static str = "format";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Csv, "csv", "Everything, one row per frame; angles in degrees"),
        (Self::Mot, "mot", "OpenSim motion files of joint torques and ground reactions"),
        (Self::Npz, "npz", "Numpy arrays, SI and radians"),
    ];
}

impl Table {
    /// Its files: names and bytes.
    fn files(self, a: &Analysis) -> Result<Vec<(&'static str, Vec<u8>)>, WriteError> {
        Ok(match self {
            Self::Csv => vec![("analysis.csv", analysis::csv(a).into_bytes())],
            Self::Mot => vec![
                ("torques.mot", analysis::torques_mot(a).into_bytes()),
                ("ground_forces.mot", analysis::ground_forces_mot(a).into_bytes()),
            ],
            Self::Npz => {
                let mut out = Cursor::new(Vec::new());
                analysis::write_npz(a, &mut out).map_err(|e| WriteError::file("analysis.npz", e))?;
                vec![("analysis.npz", out.into_inner())]
            }
        })
    }
}

/// What of an analysis is written.
#[derive(Clone, Debug)]
pub struct AnalysisWhat {
    /// Tables.
    pub tables: Vec<Table>,
    /// Depth at which the body would rest in the penalty ground of the figures, m; `None` draws nothing.
    pub sink_m: Option<f64>,
    /// Files beside those of the motion that were read, and so are never replaced.
    pub reads: Vec<PathBuf>,
}

/// Why an analysis cannot be written or drawn.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisWriteError {
    /// Of the figures.
    #[error(transparent)]
    Drawing(#[from] DrawingError),
    /// Of the files.
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl From<FolderError> for AnalysisWriteError {
    fn from(e: FolderError) -> Self {
        Self::Write(e.into())
    }
}

impl AnalysisWriteError {
    /// Whether the fault lies in the input rather than in the run.
    pub fn is_input(&self) -> bool {
        match self {
            Self::Drawing(_) => true,
            Self::Write(e) => e.is_input(),
        }
    }
}

impl AnalysisInput {
    /// Writes an analysis of the motion into `dir`; an earlier one there is replaced when all is complete.
    ///
    /// # Errors
    /// [`AnalysisWriteError`]. Figures that cannot be drawn are no error: they are in [`Written::undrawn`].
    pub fn write(
        &self,
        analysis: &Analysis,
        dir: &Path,
        what: &AnalysisWhat,
        progress: &Progress<'_>,
    ) -> Result<Written<AnalysisReport>, AnalysisWriteError> {
        let mut tables = Vec::new();
        for table in &what.tables {
            tables.extend(table.files(analysis)?);
        }
        let reads: Vec<PathBuf> = what.reads.iter().chain([&self.path]).cloned().collect();
        let planned: Vec<&str> = tables.iter().map(|t| t.0).chain(["report.json"]).collect();
        let plan = Plan { command: "analyze", planned: &planned, reads: &reads, earlier: Earlier::Remove };
        let drawing = match what.sink_m {
            Some(sink_m) => Some(Drawing::new(self, Ok(analysis), sink_m, None)?),
            None => None,
        };
        let figures: Vec<Draw<'_>> = (drawing.iter())
            .flat_map(|d| AnalysisFigure::all().filter(|f| d.has(*f).is_ok()).map(move |f| (d, f)))
            .map(|(d, f)| -> Draw<'_> { (f.word(), Box::new(move || Ok(d.draw(f).0))) })
            .collect();
        let mut data = |folder: &mut Folder| {
            for (name, bytes) in &tables {
                folder.add(&name.replace('.', "_"), name)?;
                folder.write(name, bytes)?;
            }
            Ok(())
        };
        let mut report = AnalysisReport::new(self, analysis);
        let mut text = |files| {
            report.files = files;
            report.to_json()
        };
        let undrawn = write_report(dir, &plan, &mut data, &figures, &mut text, progress)?;
        Ok(Written { report, undrawn })
    }
}

/// Where figures of a run or an analysis go.
#[derive(Clone, Debug, PartialEq)]
pub enum FigurePlace {
    /// The figures of a run's own folder: `plots` in it.
    Beside(PathBuf),
    /// A folder of figures.
    Folder(PathBuf),
    /// One file, by its ending (.svg or .png).
    File(PathBuf),
}

/// A figure that was written.
#[derive(Clone, Debug)]
pub struct DrawnFigure {
    /// Which.
    pub figure: AnalysisFigure,
    /// Its files.
    pub files: Vec<PathBuf>,
    /// The numbers on it.
    pub numbers: Value,
}

/// Draws figures and writes them; those that cannot be drawn are returned beside those that were.
///
/// # Errors
/// Of the files.
pub fn write_figures(
    drawing: &Drawing<'_>,
    figures: &[AnalysisFigure],
    place: &FigurePlace,
    overwrite: Overwrite,
    reads: &[PathBuf],
    progress: &Progress<'_>,
) -> Result<(Vec<DrawnFigure>, Vec<Undrawn>), WriteError> {
    let mut drawn = Vec::new();
    let (dir, sub) = match place {
        FigurePlace::Beside(dir) => (dir, PLOTS),
        FigurePlace::Folder(dir) => (dir, ""),
        FigurePlace::File(path) => {
            for figure in figures {
                let (picture, numbers) = drawing.draw(*figure);
                let svg = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("svg"));
                let fault = |e| WriteError::file(&path.display().to_string(), e);
                let bytes = if svg { picture.svg().map(String::into_bytes) } else { picture.png() };
                if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
                    std::fs::create_dir_all(folder)
                        .map_err(|e| WriteError::file(&folder.display().to_string(), e))?;
                }
                write_file(path, &bytes.map_err(fault)?, overwrite, reads)?;
                drawn.push(DrawnFigure { figure: *figure, files: vec![path.clone()], numbers });
            }
            return Ok((drawn, Vec::new()));
        }
    };
    let names = |figure: &AnalysisFigure| {
        ["svg", "png"].map(|kind| {
            let name = format!("{}.{kind}", figure.word());
            if sub.is_empty() { name } else { format!("{sub}/{name}") }
        })
    };
    let all: Vec<String> = figures.iter().flat_map(names).collect();
    let planned: Vec<&str> = all.iter().map(String::as_str).collect();
    let plan = Plan { command: "plot", planned: &planned, reads, earlier: Earlier::Keep };
    let mut folder = Folder::begin(dir, &plan)?;
    let mut undrawn = Vec::new();
    for (i, figure) in figures.iter().enumerate() {
        let staging = if sub.is_empty() { folder.top().make("")? } else { folder.top().make(sub)? };
        let (picture, numbers) = drawing.draw(*figure);
        match picture.save(&staging, figure.word()) {
            Ok(_) => {
                for (kind, name) in ["svg", "png"].iter().zip(names(figure)) {
                    folder.add(&format!("{}_{kind}", figure.word()), &name)?;
                }
                let files = names(figure).iter().map(|n| dir.join(n)).collect();
                drawn.push(DrawnFigure { figure: *figure, files, numbers });
            }
            Err(e) => undrawn.push(Undrawn { stem: figure.word().into(), why: e.to_string() }),
        }
        progress.at((i + 1) as f64 / figures.len() as f64);
    }
    folder.commit()?;
    Ok((drawn, undrawn))
}

/// What was drawn, for machines.
pub fn figures_json(input: &AnalysisInput, drawn: &[DrawnFigure], left_out: &[String]) -> Value {
    let of = |f: &DrawnFigure| {
        let files: Vec<String> = f.files.iter().map(|p| p.display().to_string()).collect();
        json!({ "what": f.figure.word(), "files": files, "numbers": f.numbers })
    };
    json!({
        "name": input.name,
        "source": input.source.name(),
        "figures": drawn.iter().map(of).collect::<Vec<_>>(),
        "left_out": left_out,
    })
}
