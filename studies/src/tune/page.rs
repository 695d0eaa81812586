//! What `tune` shows: figures, the page, the summary, the list of parameters.

use super::{TERMS, TuneReport};
use motion::names::Word;
use plots::{CostSlice, Figure, FigureError, Spoke};
use takes::Take;

use super::{SearchResult, SolverKind};

/// The figures of a search.
pub fn figures(take: &Take, result: &SearchResult) -> Vec<(&'static str, Figure)> {
    let costs: Vec<f64> = result.samples.iter().map(|s| s.cost).collect();
    let note = format!(
        "{}: {} points, cost {:.4} before, {:.4} after.",
        take.name,
        costs.len(),
        result.before.cost,
        result.after.cost
    );
    let mut all = vec![("convergence", plots::convergence(&costs, result.before.cost, &note))];
    if !result.slices.is_empty() {
        let slice = |(i, s): (usize, &super::Slice)| CostSlice {
            name: s.parameter.name.into(),
            unit: s.parameter.unit.into(),
            points: s.points.iter().map(|p| [p.0, p.1]).collect(),
            cloud: Vec::new(),
            was: Some(result.before.values[i]),
            is: Some([result.after.values[i], result.after.cost]),
        };
        let slices: Vec<CostSlice> = result.slices.iter().enumerate().map(slice).collect();
        let note = "One parameter moved over its range, all others at their best. A flat curve does not matter here; \
                    a best value at a cliff is fragile.";
        all.push(("slices", plots::cost_slices(&slices, "Cost along each parameter", note)));
    }
    let terms: Vec<plots::TermPair> = TERMS
        .iter()
        .enumerate()
        .map(|(k, name)| ((*name).to_owned(), result.before.terms[k], result.after.terms[k]))
        .collect();
    let note = format!(
        "Unweighted means over the runs; lower is better. Runs survived: {} before, {} after.",
        result.before.survived, result.after.survived
    );
    all.push(("terms", plots::terms_before_after(&terms, &note)));
    if let Some((before, Some(after))) = &result.maps {
        let spoke =
            |d: &crate::push::PushDirection| Spoke { deg: d.deg, survived: d.survived_ns, limit: d.limit_ns };
        let spokes: Vec<Spoke> = after.directions.iter().map(spoke).collect();
        let earlier: Vec<f64> = before.directions.iter().map(|d| d.survived_ns).collect();
        let note = format!(
            "{}: survived over limit {:.1} % on average before, {:.1} % after; least {:.1} % and {:.1} %.",
            take.name,
            100.0 * before.mean_ratio,
            100.0 * after.mean_ratio,
            100.0 * before.min_ratio,
            100.0 * after.min_ratio
        );
        all.push(("push", plots::push_map_over(&spokes, &earlier, &note)));
    }
    all
}

fn number(x: f64) -> String {
    format!("{x:.4}")
}

/// The page.
///
/// # Errors
/// Figures that cannot be drawn.
pub fn html(report: &TuneReport, figures: &[(&str, Figure)]) -> Result<String, FigureError> {
    let rows: String = report
        .parameters
        .iter()
        .map(|p| {
            format!(
                "<tr><td>{}<td>{}<td>{}<td>{}<td>{} to {}<td>{}</tr>\n",
                p.name,
                p.unit,
                number(p.was),
                number(p.is),
                p.from,
                p.to,
                super::meaning(p.name)
            )
        })
        .collect();
    let pictures = figures
        .iter()
        .map(|(_, figure)| Ok(format!("<figure>{}</figure>\n", figure.svg()?)))
        .collect::<Result<String, FigureError>>()?;
    let escape = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;");
    let verdict = escape(&verdict(report));
    let scene = escape(&report.scene);
    Ok(format!(
        "<!doctype html>
<html lang=en><meta charset=utf-8><meta name=viewport content=\"width=device-width\">
<title>{scene}: tuning</title>
<style>
body {{ font: 15px/1.45 system-ui, sans-serif; color: #262a30; max-width: 1060px; margin: 2em auto; padding: 0 1em }}
table {{ border-collapse: collapse; width: 100% }}
td, th {{ text-align: left; padding: .3em .7em; border-bottom: 1px solid #e1e4e8; vertical-align: top }}
td:nth-child(n+2) {{ font-variant-numeric: tabular-nums; white-space: nowrap }} td:last-child {{ color: #626973; font-size: 13px; white-space: normal }}
figure {{ margin: 2em 0 }} svg {{ max-width: 100%; height: auto }}
</style>
<h1>{scene}: tuning</h1>
<p><b>{verdict}</b> {}, seed {}, {} points of {} runs each.</p>
{pictures}<table><tr><th>parameter<th>unit<th>before<th>after<th>range<th>what it does</tr>
{rows}</table>
</html>
",
        solver_title(&report.solver),
        report.seed,
        report.evaluations,
        report.runs
    ))
}

/// One sentence: is it any good.
pub fn verdict(report: &TuneReport) -> String {
    let (a, b) = (report.before.cost, report.after.cost);
    let better = if b < a { "lower" } else { "not lower" };
    let mut text = format!("The cost in {} is {better}: {a:.4} before, {b:.4} after.", report.engine);
    if let Some(c) = &report.confirmed {
        let (a, b) = (c.before.cost, c.after.cost);
        let word = if b < a { "confirms it" } else { "does not confirm it" };
        text += &format!(" {} {word}: {a:.4} before, {b:.4} after.", c.engine);
    }
    if let Some(map) = &report.push_map
        && let (Some(after), Some(part)) = (map.mean_ratio_after, map.after_over_before)
    {
        text += &format!(
            " Pushes survived in {}: {:.1} % of the limit before, {:.1} % after ({:.1} % of before).",
            report.engine,
            100.0 * map.mean_ratio_before,
            100.0 * after,
            100.0 * part
        );
        return text;
    }
    let (a, b) = (report.before.survived, report.after.survived);
    text += &format!(" Runs survived: {a} before and {b} after, of {}.", report.runs);
    if let Some(why) = &report.push_map_missing {
        text += &format!(" No push map {why}.");
    }
    text
}

/// The table of parameters.
pub fn list() -> String {
    let mut text = String::from("parameter          default  range             unit  what it does\n");
    for p in super::parameters() {
        let range = format!("{} to {}", p.lo, p.hi);
        text += &format!("{:<17} {:>8}  {:<16}  {:<4}  {}\n", p.name, p.default(), range, p.unit, p.meaning);
    }
    text
}

/// How a solver is called in text.
pub fn solver_title(word: &str) -> &str {
    if word == SolverKind::CmaEs.word() { "CMA-ES" } else { "Nelder-Mead" }
}
