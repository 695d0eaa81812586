//! `tune`: a scene to a patch of tension and balance, a page of plots, and every point costed.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use motion::format;
use motion::format::bvh::ImportOptions;
use scenes::push::{self, PushMap, PushSettings};
use scenes::tune::spec::named;
use scenes::tune::{self, Cost, Sample, Search, Slice, SolverKind, TuneError, TuneReport, TuneSpec, journal};
use scenes::{Overrides, Patch, Stage, patch};

use crate::args::TuneArgs;
use crate::failure::Failure;
use crate::output::{self, Output};
use crate::progress::Progress;
use crate::tune_args::StartChoice;
use crate::{sweep, tune_page};

/// Every point costed: the state of the search.
const SAMPLES: &str = "samples.csv";

/// Runs the command.
///
/// # Errors
/// Bad input, files that cannot be written.
pub fn run(args: &TuneArgs) -> Result<(), Failure> {
    if args.list {
        return output::print(&tune_page::list());
    }
    let input = args.input.as_deref().unwrap_or(Path::new(""));
    if !input.extension().is_some_and(|e| e.eq_ignore_ascii_case("ron")) {
        return Err(Failure::Input(format!(
            "{}: allowed: a scene (.ron) of a body that stands",
            input.display()
        )));
    }
    let patch = crate::args::patch(args.patch.as_deref()).map_err(Failure::input)?;
    let overrides = Overrides { patch, ..Overrides::default() };
    let stage =
        scenes::open_with(input, None, &ImportOptions::default(), &overrides).map_err(Failure::input)?;
    if !args.merge.is_empty() {
        return sweep::merge(args, &stage);
    }
    if !args.sweep.is_empty() {
        return sweep::run(args, &stage);
    }
    search(args, &stage)
}

/// What a search found.
pub struct Found {
    /// The scene as it was.
    pub before: Sample,
    /// The best point.
    pub after: Sample,
    /// All points.
    pub samples: Vec<Sample>,
    /// Costs along the parameters.
    pub slices: Vec<Slice>,
    /// Push maps, before and after.
    pub maps: Option<(PushMap, Option<PushMap>)>,
    /// Why one of them is missing.
    pub missing: Option<String>,
}

fn search(args: &TuneArgs, stage: &Stage) -> Result<(), Failure> {
    let mut spec = stage.tune.clone();
    if !args.parameters.is_empty() {
        spec.parameters = named(&args.parameters, |_, name| {
            let known = tune::parameters().iter().map(|p| p.name);
            Failure::Input(format!("unknown parameter `{name}`{}", motion::names::hint(name, known)))
        })?;
    }
    let cost = Cost::new(stage, &spec).map_err(failure)?;
    let t = stage.tunable();
    let n = spec.parameters.len();
    let scene: Vec<f64> = spec.parameters.iter().map(|p| p.part(p.get(&t))).collect();
    let from_scene = args.start == StartChoice::Scene;
    let how = Search {
        solver: args.solver.kind(),
        seed: args.seed,
        evaluations: args.evaluations,
        start: from_scene.then_some(scene),
        step: if from_scene { 0.15 } else { 0.3 },
    };
    let dir = args.out.clone().unwrap_or_else(|| Path::new("out").join(format!("{}-tune", stage.name)));
    Output::check(&dir)?;
    std::fs::create_dir_all(&dir)
        .map_err(|e| Failure::run(format!("cannot write into {}: {e}", dir.display())))?;
    let path = dir.join(SAMPLES);
    let identity = tune::identity(stage, &spec, &how);
    let known = if args.fresh { Vec::new() } else { known(&path, &identity, &spec)? };
    if !args.json {
        let goes_on =
            if known.is_empty() { String::new() } else { format!("; {} points are known", known.len()) };
        eprintln!("searching {n} parameters with {}, seed {}{goes_on}", how.solver.name(), how.seed);
    }

    let mut progress = Progress::new();
    progress.part("searching");
    let mut keep = |samples: &[Sample]| {
        progress.at(samples.len() as f64 / args.evaluations as f64);
        let text = journal::table(&identity, &spec.parameters, samples);
        format::write(&path, text.as_bytes()).map_err(|e| e.to_string())
    };
    let samples = tune::search(&cost, n, &how, known, &mut keep).map_err(Failure::run)?;
    let best = tune::best(&samples).ok_or_else(|| Failure::run("no point was costed"))?.clone();
    let before = cost.evaluate(&t);
    let bar = Mutex::new(progress);
    let part = |what: &'static str| {
        if let Ok(mut bar) = bar.lock() {
            bar.part(what);
        }
    };
    let tell = |fraction: f64| {
        if let Ok(mut bar) = bar.lock() {
            bar.at(fraction);
        }
    };
    let mut slices = Vec::new();
    if args.slices > 0 && !args.no_plots {
        part("slicing");
        slices = tune::slices(&cost, &spec.parameters, &best, args.slices, &tell);
    }
    let (mut maps, mut missing) = (None, None);
    if args.directions > 0 {
        let settings = PushSettings { directions: args.directions, ..PushSettings::default() };
        part("map before");
        // a body that does not stand by itself has no map: a result here, not a failure
        match push::map(stage, settings, &tell) {
            Err(e) => missing = Some(format!("before: {e}")),
            Ok(before) => {
                part("map after");
                let mut tuned = stage.clone();
                tuned.set_tunable(&cost.with_values(&best.values));
                let after = push::map(&tuned, settings, &tell);
                missing = after.as_ref().err().map(|e| format!("after: {e}"));
                maps = Some((before, after.ok()));
            }
        }
    }
    let found = Found { before, after: best, samples, slices, maps, missing };
    let report = write(args, stage, &spec, &how, &cost, &found, &dir)?;
    drop(bar);
    output::print(&if args.json { report.to_json() } else { tune_page::summary(&report, &dir) })
}

fn failure(e: TuneError) -> Failure {
    if e.is_input() { Failure::input(e) } else { Failure::run(e) }
}

/// Samples an interrupted run of the same search left.
fn known(path: &Path, identity: &str, spec: &TuneSpec) -> Result<Vec<Sample>, Failure> {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(e) => return Err(Failure::run(format!("cannot read {}: {e}", path.display()))),
    };
    let shown = path.display().to_string();
    let table = journal::read(&text).map_err(|why| {
        Failure::Input(format!("{shown}: {why}\n  help: --fresh begins anew, --out takes another folder"))
    })?;
    if table.identity != identity || table.head != journal::head(&spec.parameters) {
        let e = TuneError::Other { path: shown, found: table.identity, needed: identity.into() };
        return Err(Failure::input(e));
    }
    Ok(table.samples.into_iter().map(|(_, s)| s).collect())
}

/// Writes everything but the samples, which are there.
fn write(
    args: &TuneArgs,
    stage: &Stage,
    spec: &TuneSpec,
    how: &Search,
    cost: &Cost,
    found: &Found,
    dir: &Path,
) -> Result<TuneReport, Failure> {
    let counts = (found.samples.len(), cost.runs());
    let mut report = TuneReport::new(&stage.name, how, &spec.parameters, counts, &found.before, &found.after);
    report.push_map = found.maps.as_ref().map(|(a, b)| tune::report::MapReport::of(a, b.as_ref()));
    report.push_map_missing.clone_from(&found.missing);
    let output = Output::replacing(dir, ours())?;
    let mut add = |what: &str, file: &str| {
        report.files.insert(what.into(), file.into());
    };
    add("samples_csv", SAMPLES);
    add("patch_ron", "patch.ron");
    add("report_json", "report.json");
    let changes = spec.parameters.iter().enumerate().map(|(i, parameter)| patch::Change {
        parameter,
        was: Some(found.before.values[i]),
        is: found.after.values[i],
    });
    let patch = Patch { changes: changes.collect() };
    let comment = format!(
        "contrapposto tune of {}: {}, seed {}, {} points; cost {:.4} before, {:.4} after.\nApply it with --patch, or `patch: \"patch.ron\"` in the scene.",
        stage.name,
        how.solver.name(),
        how.seed,
        found.samples.len(),
        found.before.cost,
        found.after.cost
    );
    let put = |name: &str, text: &str| {
        format::write(&output.dir().join(name), text.as_bytes()).map_err(Failure::run)
    };
    put("patch.ron", &patch.to_ron(&comment))?;
    if !args.no_plots {
        let plots = output.dir().join(output::PLOTS);
        std::fs::create_dir(&plots)
            .map_err(|e| Failure::run(format!("cannot write {}: {e}", output::PLOTS)))?;
        let figures = tune_page::figures(stage, found);
        for (stem, figure) in &figures {
            figure.save(&plots, stem).map_err(Failure::run)?;
            for kind in ["svg", "png"] {
                add(&format!("{stem}_{kind}"), &format!("{}/{stem}.{kind}", output::PLOTS));
            }
        }
        add("page_html", "tune.html");
        put("tune.html", &tune_page::html(&report, &figures).map_err(Failure::run)?)?;
    }
    put("report.json", &report.to_json())?;
    output.finish()?;
    Ok(report)
}

/// Every file a tuning may leave, relative to its folder, but the samples.
fn ours() -> Vec<PathBuf> {
    let figures = tune_page::STEMS
        .iter()
        .flat_map(|stem| ["svg", "png"].map(|kind| Path::new(output::PLOTS).join(format!("{stem}.{kind}"))));
    figures.chain(["patch.ron", "tune.html", "report.json"].map(PathBuf::from)).collect()
}

/// How a solver is called in text.
pub fn solver_word(kind: &str) -> &str {
    if kind == SolverKind::CmaEs.name() { "CMA-ES" } else { "Nelder-Mead" }
}
