//! `tune`: a scene to a patch of tension and balance, a page of plots, and every point costed.

use std::path::Path;

use motion::names::Word;
use studies::tune::{self, Search, SearchStart, Session, TERMS, TuneReport, page};
use takes::{Ask, Overrides, Take};

use crate::args::TuneArgs;
use crate::engines::{confirming, engines};
use crate::failure::Failure;
use crate::output;
use crate::progress::progress;
use crate::sweep;

/// Runs the command.
///
/// # Errors
/// Bad input, files that cannot be written.
pub fn run(args: &TuneArgs) -> Result<(), Failure> {
    if args.list {
        return output::print(&page::list());
    }
    let input = args.input.as_deref().unwrap_or(Path::new(""));
    if !takes::is_ron(input) {
        return Err(Failure::Input(format!(
            "{}: allowed: a scene (.ron) of a body that stands",
            input.display()
        )));
    }
    let patch = crate::args::patch(args.patch.as_deref()).map_err(Failure::input)?;
    let overrides = Overrides { patch, ..Overrides::default() };
    let ask = Ask { overrides, engine: args.engine.clone(), ..Ask::default() };
    let take = takes::open(input, &ask)?;
    if !args.merge.is_empty() {
        return sweep::merge(args, &take);
    }
    if !args.sweep.is_empty() {
        return sweep::run(args, &take);
    }
    search(args, &take)
}

/// Points of each cost slice, unless the person says how many.
const SLICES: usize = 7;

fn search(args: &TuneArgs, take: &Take) -> Result<(), Failure> {
    if args.no_plots && args.slices.is_some_and(|n| n > 0) {
        return Err(Failure::Input(
            "--slices are figures, and --no-plots draws none; allowed: one of them".into(),
        ));
    }
    let mut spec = take.tune.clone();
    if !args.parameters.is_empty() {
        spec.parameters = tune::named(&args.parameters, |_, name| {
            let known = tune::parameters().iter().map(|p| p.name);
            Failure::Input(format!("unknown parameter `{name}`{}", motion::names::hint(name, known)))
        })?;
    }
    let t = take.tunable();
    let n = spec.parameters.len();
    let scene: Vec<f64> = spec.parameters.iter().map(|p| p.part(p.get(&t))).collect();
    let from_scene = args.start == SearchStart::Scene;
    let search = Search {
        solver: args.solver,
        seed: args.seed,
        evaluations: args.evaluations,
        start: from_scene.then_some(scene),
        step: if from_scene { 0.15 } else { 0.3 },
    };
    let dir = output::folder(args.out.as_deref(), &format!("{}-tune", take.name));
    let reads: Vec<_> = take.files.iter().chain(&args.patch).cloned().collect();
    Session::check(&dir, &reads)?;
    let (solver, seed) = (search.solver.word(), search.seed);
    let session = Session {
        spec,
        search,
        slices: args.slices.unwrap_or(SLICES),
        directions: args.directions,
        figures: !args.no_plots,
        fresh: args.fresh,
    };
    let mut announce = |known: usize| {
        if !args.json {
            let goes_on = if known == 0 { String::new() } else { format!("; {known} points are known") };
            eprintln!("searching {n} parameters with {solver}, seed {seed}{goes_on}");
        }
    };
    let engines = engines();
    let engine = take.searcher(&engines)?;
    let second = confirming(&engines, &args.confirm, engine)?;
    let progress = progress();
    let (report, undrawn) = session.run(take, engine, second, &dir, &mut announce, &progress)?;
    drop(progress);
    output::print(&if args.json { report.to_json() } else { summary(&report, &dir) })?;
    output::undrawn(&undrawn, &dir)
}

/// The summary on standard output.
fn summary(report: &TuneReport, dir: &Path) -> String {
    let mut text = format!("{}: {}\n\n", report.scene, page::verdict(report));
    text += "  parameter               before      after  range\n";
    for p in &report.parameters {
        text += &format!(
            "  {:<18} {:>11} {:>10}  {} to {} {}\n",
            p.name,
            number(p.was),
            number(p.is),
            p.from,
            p.to,
            p.unit
        );
    }
    let second = |text: &str| report.confirmed.as_ref().map_or_else(String::new, |_| format!("  {text:>21}"));
    let engine = report.confirmed.as_ref().map_or("", |c| c.engine.as_str());
    text += &format!(
        "\n  term                    before      after{}\n",
        second(&format!("in {engine}: before  after"))
    );
    for name in TERMS {
        let (a, b) = (report.before.terms[name], report.after.terms[name]);
        let both = report.confirmed.as_ref().map_or_else(String::new, |c| {
            format!("{}  {}", number(c.before.terms[name]), number(c.after.terms[name]))
        });
        let row = format!("  {name:<18} {:>11} {:>10}{}", number(a), number(b), second(&both));
        text += &format!("{}\n", row.trim_end());
    }
    text += &format!(
        "\n  {}, seed {}, start {}, {} points of {} runs each\n",
        page::solver_title(&report.solver),
        report.seed,
        report.start,
        report.evaluations,
        report.runs
    );
    let files: Vec<String> = report.files.values().map(|f| dir.join(f).display().to_string()).collect();
    text + &format!("  files      {}\n", files.join("\n             "))
}

fn number(x: f64) -> String {
    format!("{x:.4}")
}
