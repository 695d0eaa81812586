//! The table of a cross-check: as text, as a page with figures, as JSON.
//!
//! In: a [`CrossCheck`]. Out: text and figures; nothing is written to disk here. The JSON is
//! `{"name", "mujoco", "seed", "states", "failed", "checks": [{"quantity", "ours", "mujoco", "abs_error",
//! "rel_error", "threshold", "measure", "unit", "at", "core", "pass", "reason"}], "nothing", "left_out"}`.

use std::fmt::Write;

use motion::skeleton::quat_at;
use motion::{Clip, Joint};
use plots::Figure;
use plots::panel::{Clock, Key, Panel, Series, page};
use plots::style;
use serde_json::json;

use crate::box_contact::LandingRun;
use crate::check::{Check, Measure};
use crate::forward::{ForwardRun, RATES_HZ};
use crate::ground::SceneRun;
use crate::subject::CrossCheck;

/// A number with as many digits as it takes to see the difference, within 10 characters.
fn short(x: f64) -> String {
    match x.abs() {
        0.0 => "0".into(),
        a if !(1e-3..1e6).contains(&a) => format!("{x:.3e}"),
        a if a >= 100.0 => format!("{x:.3}"),
        _ => format!("{x:.5}"),
    }
}

/// A threshold, as short as it can be.
fn allowed(x: f64) -> String {
    if x < 1e-3 { format!("{x:e}") } else { format!("{x}") }
}

fn kind(check: &Check) -> &'static str {
    match check.measure {
        Measure::Relative => "rel",
        Measure::Absolute => "abs",
    }
}

/// The checks of equations (ours and MuJoCo's), and those of engines (core, rapier, MuJoCo), each with the names of its columns of numbers.
fn tables(cross: &CrossCheck) -> [(&'static [&'static str], Vec<&Check>); 2] {
    let (engines, equations) = cross.checks.iter().partition(|c: &&Check| c.core.is_some());
    [(&["ours", "MuJoCo"], equations), (&["core", "rapier", "MuJoCo"], engines)]
}

/// Its numbers, in the order of the columns of its table.
fn numbers(check: &Check) -> Vec<f64> {
    check.core.iter().map(|c| c.value).chain([check.ours, check.mujoco]).collect()
}

/// The error of the pair that is farthest apart, and the pairs that are too far.
fn apart(check: &Check) -> String {
    let pairs = match (check.differ().as_slice(), check.farthest().0) {
        (differ @ [_, ..], _) if check.core.is_some() => format!(": {}", differ.join("; ")),
        _ => String::new(),
    };
    format!("{:.1e} {}{pairs}", check.farthest().1, kind(check))
}

/// The table as text: one line per check, reasons below it.
pub fn text(cross: &CrossCheck) -> String {
    let mut out = String::new();
    for (columns, checks) in tables(cross) {
        if !checks.is_empty() {
            if !out.is_empty() {
                out.push('\n');
            }
            out += &table(columns, &checks);
        }
    }
    for item in &cross.nothing {
        let _ = writeln!(out, "nothing to compare: {item}");
    }
    for item in &cross.left_out {
        let _ = writeln!(out, "left out: {item}");
    }
    out
}

fn table(columns: &[&str], checks: &[&Check]) -> String {
    let head =
        ["", "quantity"].into_iter().chain(columns.iter().copied()).chain(["error", "allowed", "where"]);
    let mut rows: Vec<Vec<String>> = vec![head.map(str::to_owned).collect()];
    for c in checks {
        let unit = if c.unit.is_empty() { String::new() } else { format!(" {}", c.unit) };
        let mut row = vec![if c.pass { "ok".into() } else { "FAIL".into() }, c.quantity.clone()];
        row.extend(numbers(c).into_iter().map(|x| short(x) + &unit));
        row.extend([apart(c), allowed(c.threshold), c.at.clone()]);
        rows.push(row);
    }
    let width = |k: usize| rows.iter().map(|r| r[k].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..rows[0].len() - 1).map(width).collect();
    let mut out = String::new();
    for (i, row) in rows.iter().enumerate() {
        let mut line = String::new();
        for (k, cell) in row.iter().enumerate() {
            let pad = widths.get(k).map_or(0, |w| w - cell.chars().count());
            let _ = write!(line, "{cell}{:pad$}  ", "");
        }
        let _ = writeln!(out, "{}", line.trim_end());
        if let Some(reason) = i.checked_sub(1).and_then(|i| checks[i].reason.as_deref()) {
            let _ = writeln!(out, "      because {reason}");
        }
    }
    out
}

/// The table as JSON.
pub fn json(cross: &CrossCheck) -> String {
    let value = json!({
        "name": cross.name,
        "mujoco": cross.mujoco,
        "seed": cross.seed,
        "states": cross.states,
        "failed": cross.failed(),
        "checks": cross.checks,
        "nothing": cross.nothing,
        "left_out": cross.left_out,
    });
    serde_json::to_string_pretty(&value).expect("plain data") + "\n"
}

/// Overlay plots, each with the stem of its file.
pub fn figures(cross: &CrossCheck) -> Vec<(&'static str, Figure)> {
    let mut out = Vec::new();
    if let Some(forward) = &cross.forward {
        out.push(("motion", motion_figure(&cross.name, forward)));
    }
    if let Some(landing) = &cross.landing {
        out.push(("landing", landing_figure(landing)));
    }
    if let Some(scene) = &cross.scene {
        out.push(("contact", scene_figure(&cross.name, scene)));
    }
    out
}

/// The page: verdict, table, figures.
///
/// # Errors
/// Of a figure.
pub fn html(cross: &CrossCheck) -> Result<String, plots::FigureError> {
    let verdict = match (cross.failed(), cross.checks.len()) {
        (0, 0) => "nothing to compare".to_owned(),
        (0, all) => format!("all {all} checks pass"),
        (failed, all) => format!("{failed} of {all} checks fail"),
    };
    let mut rows = String::new();
    for (columns, checks) in tables(cross) {
        if checks.is_empty() {
            continue;
        }
        let head: String = columns.iter().map(|c| format!("<th>{c}</th>")).collect();
        let _ = writeln!(
            rows,
            "<table><tr><th></th><th>quantity</th>{head}<th>error</th><th>allowed</th><th>where</th></tr>"
        );
        for c in checks {
            let class = if c.pass { "ok" } else { "fail" };
            let reason = c.reason.as_deref().map(|r| format!("<div class=reason>{}</div>", escape(r)));
            let cells: String = numbers(c)
                .into_iter()
                .map(|x| format!("<td>{} {}</td>", short(x), escape(&c.unit)))
                .collect();
            let _ = writeln!(
                rows,
                "<tr class={class}><td>{class}</td><td>{}{}</td>{cells}<td>{}</td><td>{} {}</td><td>{}</td></tr>",
                escape(&c.quantity),
                reason.unwrap_or_default(),
                escape(&apart(c)),
                allowed(c.threshold),
                kind(c),
                escape(&c.at),
            );
            debug_assert!(c.farthest().1.is_finite() || !c.pass);
        }
        rows += "</table>\n";
    }
    let mut pictures = String::new();
    for (stem, figure) in figures(cross) {
        let _ = writeln!(pictures, "<figure id={stem}>{}</figure>", inline(&figure.svg()?));
    }
    let nothing: String = cross.nothing.iter().map(|l| format!("<li>{}</li>", escape(l))).collect();
    let nothing =
        if nothing.is_empty() { nothing } else { format!("<h2>Nothing to compare</h2><ul>{nothing}</ul>") };
    let left: String = cross.left_out.iter().map(|l| format!("<li>{}</li>", escape(l))).collect();
    let left = if left.is_empty() { left } else { format!("<h2>Left out of the file</h2><ul>{left}</ul>") };
    let name = escape(&cross.name);
    Ok(format!(
        "<!doctype html>
<html lang=en><meta charset=utf-8><meta name=viewport content=\"width=device-width\">
<title>{name}: cross-check with MuJoCo</title>
<style>
body {{ font: 15px/1.45 system-ui, sans-serif; color: #262a30; max-width: 1500px; margin: 2em auto; padding: 0 1em }}
table {{ border-collapse: collapse; width: 100%; margin: 1.5em 0 }}
td, th {{ text-align: left; padding: .3em .7em; border-bottom: 1px solid #e1e4e8; vertical-align: top }}
td:nth-child(n+3):nth-child(-n+7) {{ font-variant-numeric: tabular-nums; white-space: nowrap }}
.ok td:first-child {{ color: #009e73 }} .fail td {{ background: #fdeee6 }} .fail td:first-child {{ color: #d55e00; font-weight: bold }}
.reason {{ color: #626973; font-size: 13px; max-width: 46em }}
figure {{ margin: 2em 0 }} svg {{ width: 100%; height: auto }}
</style>
<h1>{name}: cross-check with MuJoCo {}</h1>
<p><b>{verdict}</b>. {} random states, seed {}.</p>
{rows}{nothing}
{left}
{pictures}</html>
",
        cross.mujoco, cross.states, cross.seed
    ))
}

/// An SVG document as an element of a page.
fn inline(svg: &str) -> &str {
    svg.find("<svg").map_or(svg, |at| &svg[at..])
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

const WIDTH: f64 = 1500.0;

fn clock(rate_hz: f64) -> Clock {
    Clock { rate_hz, start_s: 0.0 }
}

fn keys() -> [Key; 3] {
    [
        Key::line("core", style::GREEN),
        Key::line("rapier", style::BLUE),
        Key::dashed("MuJoCo", style::VERMILION),
    ]
}

/// Rapier's curve, MuJoCo's and the core's; the widest lies below.
fn all_engines(rate_hz: f64, [ours, theirs, core]: [Vec<f64>; 3]) -> Vec<Series> {
    vec![
        Series::over_time(clock(rate_hz), core, style::GREEN).wide(4.5),
        Series::over_time(clock(rate_hz), ours, style::BLUE).wide(2.4),
        Series::over_time(clock(rate_hz), theirs, style::VERMILION).dashed(),
    ]
}

fn motion_figure(name: &str, run: &ForwardRun) -> Figure {
    let [ours, theirs, core] = &run.clips;
    let frames = ours.frames().min(theirs.frames()).min(core.frames());
    let angle = |clip: &Clip, f: usize| {
        let link = run.link;
        let (q, at) = (clip.pose(f), clip.skeleton.q_at(link));
        match clip.skeleton.links()[link].joint {
            Joint::Spherical => quat_at(q, at).angle().to_degrees(),
            _ => q[at].to_degrees(),
        }
    };
    let apart = |ours: &Clip, f: usize| {
        let at = ours.skeleton.q_at(run.link);
        let (a, b) = (ours.pose(f), theirs.pose(f));
        match ours.skeleton.links()[run.link].joint {
            Joint::Spherical => quat_at(a, at).angle_to(&quat_at(b, at)).to_degrees(),
            _ => (a[at] - b[at]).abs().to_degrees(),
        }
    };
    let joint = &ours.skeleton.links()[run.link].name;
    let rate = ours.rate_hz;
    let all = |clip: &Clip| (0..frames).map(|f| angle(clip, f)).collect();
    let orders: Vec<String> = (RATES_HZ.iter().zip(run.errors_deg).zip(run.core_deg))
        .map(|((r, e), c)| format!("{e:.4}° and {c:.4}° at {r:.0} Hz"))
        .collect();
    let panels = [
        Panel {
            title: format!("{joint}: angle from its zero pose, the joint that differs most"),
            y_label: "angle (°)".into(),
            series: all_engines(rate, [all(ours), all(theirs), all(core)]),
            ..Panel::default()
        },
        Panel {
            title: "the angle to MuJoCo's".into(),
            x_label: "time (s)".into(),
            y_label: "angle (°)".into(),
            series: vec![
                Series::over_time(clock(rate), (0..frames).map(|f| apart(core, f)), style::GREEN).wide(4.5),
                Series::over_time(clock(rate), (0..frames).map(|f| apart(ours, f)), style::BLUE).wide(2.4),
            ],
            ..Panel::default()
        },
    ];
    let note =
        format!("{name}, root pinned, no ground · joint RMS of rapier and the core {}", orders.join(", "));
    page("Motion without contact", &note, &keys(), &panels, 1, WIDTH, 230.0)
}

fn landing_figure(run: &LandingRun) -> Figure {
    let panels = [Panel {
        title: "vertical force on a box of 12 kg dropped from 5 cm onto springs".into(),
        x_label: "time (s)".into(),
        y_label: "force (N)".into(),
        series: all_engines(run.rate_hz, run.force.clone()),
        ..Panel::default()
    }];
    page("Landing at matched compliance", "", &keys(), &panels, 1, WIDTH, 280.0)
}

fn scene_figure(name: &str, run: &SceneRun) -> Figure {
    let rate = run.ours.rate_hz;
    let total = |t: &dynamics::Trace| -> Vec<f64> {
        // the first row is the start: nothing has pushed yet
        t.contact_sums().iter().enumerate().map(|(k, f)| if k == 0 { f64::NAN } else { f.y }).collect()
    };
    let of_leg = |t: &dynamics::Trace, end: usize| {
        let mut sums = vec![0.0; t.rows()];
        sums[0] = f64::NAN;
        let body = |l: usize| t.character.skeleton.links()[l].parent;
        for c in &t.contacts {
            if c.link == end || body(c.link) == Some(end) {
                sums[c.row] += c.force.y;
            }
        }
        sums
    };
    let mut panels = vec![Panel {
        title: "vertical ground force, in total".into(),
        y_label: "force (N)".into(),
        series: all_engines(rate, [total(&run.ours), total(&run.theirs), total(&run.core)]),
        ..Panel::default()
    }];
    let character = run.ours.character.clone();
    for leg in character.legs() {
        panels.push(Panel {
            title: format!("of {}", leg.name),
            y_label: "force (N)".into(),
            series: all_engines(rate, [&run.ours, &run.theirs, &run.core].map(|t| of_leg(t, leg.end))),
            ..Panel::default()
        });
    }
    if let Some(last) = panels.last_mut() {
        last.x_label = "time (s)".into();
    }
    let note = format!("{name}: controllers closed over each engine's own state, each from its own rest");
    page("Ground forces in three engines", &note, &keys(), &panels, 1, WIDTH, 200.0)
}
