//! What `render` says at the end: did it work, is it any good, where is it.

use std::fmt::Write;
use std::path::Path;

use motion::names::Word;
use takes::overrides::RootName;
use takes::results::disturbance_report::{DisturbanceReport, LegTensionReport};
use takes::results::dynamic_report::{DynamicReport, StiffnessReport};
use takes::results::feet::FeetReport;
use takes::results::foresight_report::ForesightReport;
use takes::results::number;
use takes::results::write::PLOTS;
use takes::{Report, RootMode, Take};

/// Mean ground force below which nothing is said of the ground, N.
const LEAST_N: f64 = 0.1;
/// A gaze that never came nearer to its point is out of reach, degrees.
const OUT_OF_REACH_DEG: f64 = 5.0;
/// Lines of a list that are printed; `report.json` has all.
const LISTED: usize = 5;

/// The summary of a run whose files are in `dir`.
pub fn of(take: &Take, report: &Report, dir: &Path) -> String {
    let mut out = String::new();
    // writing to a String cannot fail
    let _ = write(&mut out, take, report, dir);
    out
}

fn write(out: &mut String, take: &Take, report: &Report, dir: &Path) -> std::fmt::Result {
    writeln!(out, "{}", verdict(report))?;
    let c = &report.character;
    line(
        out,
        "scene",
        format!(
            "{}: {:.2} s, {} frames at {} Hz",
            report.scene,
            report.duration_s,
            report.frames,
            number(report.rate_hz)
        ),
    )?;
    line(
        out,
        "body",
        format!("{}: {} links, {} degrees of freedom, {:.1} kg", c.name, c.links, c.dof, c.mass_kg),
    )?;
    if let Some(source) = take.clip_source() {
        let read = source.import.as_ref().map(ToString::to_string).unwrap_or_default();
        for (i, text) in read.lines().enumerate() {
            line(out, if i == 0 { "clip" } else { "" }, text)?;
        }
        if let Some(cycle) = &source.cycle {
            line(out, "looped", cycle.to_string())?;
        }
        if let Some(body) = &source.body {
            for (i, text) in body.to_string().lines().enumerate() {
                line(out, if i == 0 { "guessed" } else { "" }, text)?;
            }
        }
    }
    if let Some(p) = &report.plausibility {
        line(out, "captured", &p.text)?;
    }
    let k = &report.kinematic;
    line(out, "asked for", feet(k.feet.as_ref()))?;
    if k.clamped_frames > 0.0 {
        line(out, "", format!("joint limits changed {:.0} % of the frames", 100.0 * k.clamped_frames))?;
    }
    for (i, ignored) in k.ignored.iter().enumerate() {
        line(out, if i == 0 { "IGNORED" } else { "" }, &ignored.text)?;
    }
    first_of(out, "LIMITED", k.limited.iter().map(|l| &l.text))?;
    first_of(out, "edited", k.edited.iter())?;
    if let Some(shifted) = &k.shifted {
        line(out, "moved", &shifted.text)?;
    }
    first_of(out, "steps", k.stepping.iter())?;
    if report.edit_conflicts > 0 {
        let text = format!(
            "{} fields of elements changed by more than one edit, each on what the one before left (`contrapposto inspect` lists them)",
            report.edit_conflicts
        );
        line(out, "edits", text)?;
    }
    disturbed(out, &report.disturbances)?;
    if let Some(d) = &report.dynamic {
        performed(out, d)?;
    }
    if take.conditions.physics.root != RootMode::Pinned {
        spans(out, report)?;
    }
    let (figures, mut files): (Vec<&String>, Vec<&String>) =
        report.files.values().partition(|name| name.starts_with(PLOTS));
    let figures = figures.iter().filter(|name| name.ends_with(".svg")).count();
    let plots = format!("{PLOTS}/ ({figures} figures, each as .svg and .png)");
    if figures > 0 {
        files.push(&plots);
    }
    for (i, name) in files.iter().enumerate() {
        line(out, if i == 0 { "files" } else { "" }, dir.join(name).display().to_string())?;
    }
    Ok(())
}

fn disturbed(out: &mut String, d: &DisturbanceReport) -> std::fmt::Result {
    let mut lines = Vec::new();
    if let (Some(tilt), Some(friction)) = (d.ground_tilt_deg, d.ground_friction)
        && tilt > 0.0
    {
        lines.push(format!("ground tilted by {}°, friction {}", number(tilt), number(friction)));
    }
    lines.extend(d.ground_tilts.iter().map(|t| {
        let (from, to) = (t.start_s, t.start_s + t.duration_s);
        let way =
            if t.tilt_deg > 0.0 { format!(" towards {}°", number(t.towards_deg)) } else { String::new() };
        format!("ground tilts to {}°{way} from {from:.2} to {to:.2} s", number(t.tilt_deg))
    }));
    lines.extend(d.pushes.iter().map(|p| {
        let size = p.impulse_ns.iter().map(|x| x * x).sum::<f64>().sqrt();
        format!("{} is pushed by {size:.1} N·s at {:.2} s for {} s", p.link, p.start_s, number(p.duration_s))
    }));
    lines.extend(d.carried.iter().map(|c| {
        let to = c.to_s.map_or(String::new(), |t| format!(" to {t:.2} s"));
        let known = if c.known { "known" } else { "a surprise" };
        format!("{} carries {} kg from {:.2} s{to}: {known}", c.link, number(c.mass_kg), c.from_s)
    }));
    for (i, text) in lines.iter().enumerate() {
        line(out, if i == 0 { "disturbed" } else { "" }, text)?;
    }
    Ok(())
}

fn verdict(report: &Report) -> String {
    let name = &report.scene;
    match &report.dynamic {
        None => parts(report).unwrap_or_else(|| format!("{name}: the motion asked for; no physics")),
        Some(d) => format!("{name}: {}", d.verdict.text),
    }
}

/// The verdict on a clip performed in parts.
fn parts(report: &Report) -> Option<String> {
    let name = &report.scene;
    let runs: Vec<&DynamicReport> =
        report.spans.iter().flatten().filter_map(|span| span.dynamic.as_ref()).collect();
    let failed = runs.iter().filter(|d| d.diverged.is_some()).count();
    let fell = runs.iter().filter(|d| d.fell).count();
    let n = runs.len();
    let spans = if n == 1 { "its standing span" } else { "standing spans" };
    match (n, failed, fell) {
        (0, ..) => None,
        (_, 0, 0) => {
            let but = runs.iter().filter(|d| !d.verdict.reasons.is_empty()).count();
            let how = match (but, n) {
                (0, 1) => format!("{spans} performed as asked"),
                (0, _) => format!("{n} {spans} performed as asked"),
                (_, 1) => format!("{spans} performed, but not as asked"),
                _ => format!("{n} {spans} performed, {but} not as asked"),
            };
            Some(format!("{name}: {how}; where it steps it is not"))
        }
        (_, 0, _) => Some(format!("{name}: THE BODY FELL in {fell} of {n} {spans}")),
        _ => Some(format!("{name}: FAILED in {failed} of {n} {spans}")),
    }
}

/// Where a clip stands and steps, and what came of the spans performed by themselves.
fn spans(out: &mut String, report: &Report) -> std::fmt::Result {
    let Some(spans) = &report.spans else { return Ok(()) };
    let alone = spans.len() == 1 && report.dynamic.is_some();
    for (i, span) in spans.iter().enumerate() {
        let text = match (&span.dynamic, span.stands) {
            (Some(d), _) => {
                let residual = percent(d.root.residual_force_rms_percent_bw);
                format!(
                    "{}; upper body {:.2}° RMS, links {:.0} mm, unexplained force {residual}, slip {:.0} mm",
                    d.verdict.text,
                    d.upper_body_rms_deg,
                    d.position_rms_mm,
                    d.feet.map_or(0.0, |f| f.slip_mm_max)
                )
            }
            (None, true) if alone => "stands throughout, feet planted".into(),
            (None, true) => "stands".into(),
            (None, false) if span.stepping.is_empty() => "too short to stand".into(),
            (None, false) if report.dynamic.is_some() => format!("steps: {}", span.stepping.join(", ")),
            (None, false) => format!("steps: {}; not performed", span.stepping.join(", ")),
        };
        let label = if i == 0 { "spans" } else { "" };
        line(out, label, format!("{:>6.2} ..{:>6.2} s  {text}", span.from_s, span.to_s))?;
    }
    let falls = report.dynamic.as_ref().is_some_and(|d| d.root.mode == RootName::Free.word());
    let foresight = report.dynamic.as_ref().is_some_and(|d| d.foresight.is_some());
    if falls && !foresight && !spans.iter().any(|s| s.stands) {
        line(
            out,
            "",
            "it stands nowhere, and a free root has no steps of its own: --foresight on looks ahead, --root assisted or pinned holds it",
        )?;
    }
    Ok(())
}

fn performed(out: &mut String, d: &DynamicReport) -> std::fmt::Result {
    let r = &d.root;
    let free = r.mode == RootName::Free.word();
    let held = match r.mode {
        mode if free => format!("{mode}: nothing but muscles and contacts"),
        mode => format!(
            "{mode}: force {:.1} N RMS ({}), {:.1} N peak ({}), {:.1} N·s in all",
            r.residual_force_rms_n,
            percent(r.residual_force_rms_percent_bw),
            r.residual_force_peak_n,
            percent(r.residual_force_peak_percent_bw),
            r.impulse_ns
        ),
    };
    line(out, "root", held)?;
    if let Some(hz) = r.smoothed_at_hz {
        let text = format!(
            "of the motion smoothed at {hz:.1} Hz, without its ends: a pin follows the noise of a capture too"
        );
        line(out, "", text)?;
    }
    if !free {
        let text = format!(
            "moment {:.1} N·m RMS, {:.1} N·m peak, {:.1} N·m·s in all",
            r.residual_moment_rms_nm, r.residual_moment_peak_nm, r.moment_impulse_nms
        );
        line(out, "", text)?;
    }
    if let Some(b) = &r.budget {
        let text = format!(
            "budget {:.1} N ({}), used up {:.0} % of the time; {:.1} N·m, used up {:.0} %",
            b.force_n,
            percent(b.force_percent_bw),
            100.0 * b.force_at_limit,
            b.moment_nm,
            100.0 * b.moment_at_limit
        );
        line(out, "", text)?;
    }
    if free {
        let text = format!(
            "unexplained force {:.2} N RMS ({}), {:.1} N peak",
            r.residual_force_rms_n,
            percent(r.residual_force_rms_percent_bw),
            r.residual_force_peak_n
        );
        line(out, "residual", text)?;
    }
    if let Some(e) = &d.engine {
        if free {
            let text = format!(
                "without corrections of the root {:.2} N RMS more ({}), {:.3} J in all",
                e.root_correction_rms_n,
                percent(e.root_correction_rms_percent_bw),
                e.root_correction_j
            );
            line(out, "", text)?;
        }
        if e.contact_solutions > 0 {
            let text = format!(
                "{} contact solutions, residual at most {:.0e} m g dt, {} not solved; pushed out of the ground by {:.3} J",
                e.contact_solutions, e.worst_residual, e.unsolved, e.push_out_j
            );
            line(out, "solver", text)?;
        }
    }
    let triggers = d.fall.iter().flat_map(|f| &f.triggers);
    for (i, trigger) in triggers.enumerate() {
        line(out, if i == 0 { "BECAUSE" } else { "" }, &trigger.text)?;
    }
    for (i, loss) in d.fall.iter().flat_map(|f| &f.losses).enumerate() {
        line(
            out,
            if i == 0 { "FELL" } else { "" },
            format!("{}{}", if i == 0 { "" } else { "then " }, loss.text),
        )?;
    }
    line(
        out,
        "muscles",
        format!(
            "tension {}, damping ratio {} (up to {:.2} with the integrator's)",
            number(d.tension),
            d.damping_ratio,
            d.damping_ratio + d.added_damping_ratio
        ),
    )?;
    let by_stiffness =
        |a: &&StiffnessReport, b: &&StiffnessReport| a.natural_nm_rad.total_cmp(&b.natural_nm_rad);
    let ends = (d.stiffness.iter().min_by(by_stiffness), d.stiffness.iter().max_by(by_stiffness));
    if let (Some(softest), Some(stiffest)) = ends {
        let text = format!(
            "tension 1 is {:.2} N·m/rad at {} to {:.0} N·m/rad at {}",
            softest.natural_nm_rad, softest.joint, stiffest.natural_nm_rad, stiffest.joint
        );
        line(out, "", text)?;
    }
    let of_legs =
        |l: &&LegTensionReport| d.leg_tension[0].asked == l.asked && d.leg_tension[0].used == l.used;
    if let Some(first) = d.leg_tension.first() {
        let (word, why) = if first.used > first.asked {
            ("RAISED", "they would not stand with less")
        } else {
            ("lowered", "the soles cannot pass on more")
        };
        let mut text = format!(
            "stance legs' tension {word} from {} to {} ({:+.0} %): {why}",
            number(first.asked),
            number(first.used),
            100.0 * (first.used / first.asked - 1.0)
        );
        if d.leg_tension.iter().filter(of_legs).count() < d.leg_tension.len() {
            text += "; each joint in report.json";
        }
        line(out, "", text)?;
    }
    for g in &d.gazes {
        let [x, y, z] = g.at_m;
        let missed = match (g.rms_deg, g.peak_deg, g.peak_at_s) {
            (Some(rms), Some(peak), Some(at)) => {
                let least = g.least_deg.unwrap_or(0.0);
                let out = if least > OUT_OF_REACH_DEG {
                    format!("OUT OF REACH of neck and trunk by {least:.0}° at best; ")
                } else {
                    String::new()
                };
                format!("{out}misses by {rms:.2}° RMS, {peak:.2}° at most, at {at:.2} s")
            }
            _ => "never got there".into(),
        };
        line(out, "gaze", format!("at ({}, {}, {}) m: {missed}", number(x), number(y), number(z)))?;
    }
    if let Some(f) = &d.foresight {
        foresight(out, f)?;
    }
    if let Some(soles) = &d.soles {
        line(out, "soles", soles.to_string())?;
    }
    const SHOWN: usize = 8;
    for (i, text) in d.reactive.iter().take(SHOWN).enumerate() {
        line(out, if i == 0 { "program" } else { "" }, text.clone())?;
    }
    if d.reactive.len() > SHOWN {
        line(out, "", format!("and {} more joints in report.json", d.reactive.len() - SHOWN))?;
    }
    line(
        out,
        "simulation",
        format!("{} Hz, {} substeps, {:.1} × real time", number(d.rate_hz), d.substeps, d.realtime_factor),
    )?;
    let worst: Vec<String> = d
        .worst_joints
        .iter()
        .map(|j| format!("{} {:.1}° (peak {:.0}°)", j.joint, j.rms_deg, j.peak_deg))
        .collect();
    line(
        out,
        "joints",
        format!(
            "{:.2}° RMS from the motion asked for ({:.2}° without the legs), links {:.0} mm",
            d.joint_rms_deg, d.upper_body_rms_deg, d.position_rms_mm
        ),
    )?;
    if !worst.is_empty() {
        line(out, "", format!("worst: {}", worst.join(", ")))?;
    }
    if d.contact.vertical_mean_n.abs() > LEAST_N {
        line(out, "feet", feet(d.feet.as_ref()))?;
        let c = &d.contact;
        let mut text = format!(
            "vertical {:.1} N mean, {:.1} N peak; {} at the end; friction used {:.2}",
            c.vertical_mean_n,
            c.vertical_peak_n,
            percent(c.vertical_end_percent_bw),
            c.friction_used_max
        );
        if let Some(margin) = d.support_margin_mm_min {
            let _ = write!(text, "; centre of mass at least {margin:.0} mm inside the support");
        }
        line(out, "ground", text)?;
    }
    let touched =
        d.contact.touched.iter().map(|c| {
            format!("{} on {} from {:.2} s, {:.0} N at most", c.link, c.against, c.from_s, c.peak_n)
        });
    first_of(out, "touched", touched)?;
    let sagging = d.sagging.iter().map(|s| {
        format!(
            "{} at {:.2} s: has {:.1} N·m/rad, needs {:.1}",
            s.joint, s.time_s, s.tension_nm_rad, s.least_nm_rad
        )
    });
    first_of(out, "SAGGING", sagging)
}

/// How much foresight had to do, and how the body walked.
fn foresight(out: &mut String, f: &ForesightReport) -> std::fmt::Result {
    let how = match (f.horizon_s, f.rollouts) {
        (Some(horizon_s), Some(n)) => {
            format!("{} searches of {n} rollouts over {} s", f.searches, number(horizon_s))
        }
        _ => "replayed".into(),
    };
    let offsets =
        format!("{how}: targets moved by {:.1}° RMS, {:.0}° at most", f.offset_rms_deg, f.offset_max_deg);
    line(out, "foresight", offsets)?;
    let kept = match &f.lost {
        None => "kept its feet".to_owned(),
        Some(lost) => format!("LOST ITS FEET at {:.2} s: {lost}", f.kept_s),
    };
    let text = format!(
        "{kept}; links {:.0} mm RMS from the motion asked for, at most {:.0} mm off its way of {:.2} m; a stance slips {:.0} mm (largest {:.0}); peak {:.1} body weights",
        f.links_rms_mm, f.away_mm, f.way_m, f.slip_mm, f.slip_mm_max, f.peak_bw
    );
    line(out, "", text)
}

/// A share of the body's weight.
fn percent(x: Option<f64>) -> String {
    x.map_or_else(
        || "there is no weight".into(),
        |x| {
            let digits = if x.abs() < 1.0 { 3 } else { 1 };
            format!("{x:.digits$} % of body weight")
        },
    )
}

fn feet(f: Option<&FeetReport>) -> String {
    let Some(f) = f else { return "no ground under its feet".into() };
    format!(
        "feet slip {:.1} mm, sink {:.1} mm, float {:.1} mm at most; skate {:.1} mm/s",
        f.slip_mm_max,
        f.penetration_mm_max.max(0.0),
        f.float_mm_max.max(0.0),
        f.skate_mm_s
    )
}

/// The first lines of a list, and how many more there are.
fn first_of(
    out: &mut String,
    what: &str,
    lines: impl ExactSizeIterator<Item = impl AsRef<str>>,
) -> std::fmt::Result {
    let more = lines.len().saturating_sub(LISTED);
    for (i, text) in lines.take(LISTED).enumerate() {
        line(out, if i == 0 { what } else { "" }, text)?;
    }
    if more > 0 {
        line(out, "", format!("and {more} more, see report.json"))?;
    }
    Ok(())
}

/// A line of a summary: what it is about, and what there is to say.
pub fn line(out: &mut String, what: &str, text: impl AsRef<str>) -> std::fmt::Result {
    writeln!(out, "  {what:<11}{}", text.as_ref())
}
