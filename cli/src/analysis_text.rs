//! What `analyze` says at the end: is this motion physically plausible, and where not.

use std::fmt::Write;
use std::path::Path;

use takes::results::analysis_report::{AnalysisReport, FrameSpan};
use takes::results::number;
use takes::results::write::PLOTS;
use takes::{AnalysisInput, AnalysisSource};

use crate::summary::line;

/// Joints named.
const JOINTS: usize = 5;
/// Spans named.
const SPANS: usize = 4;

/// The summary of an analysis whose files are in `dir`.
pub fn of(input: &AnalysisInput, r: &AnalysisReport, dir: &Path) -> String {
    let mut out = String::new();
    // writing to a String cannot fail
    let _ = write(&mut out, input, r, dir);
    out
}

fn write(out: &mut String, input: &AnalysisInput, r: &AnalysisReport, dir: &Path) -> std::fmt::Result {
    writeln!(out, "{}: {}", r.name, r.verdict())?;
    line(
        out,
        r.source,
        format!("{}: {:.2} s, {} frames at {} Hz", r.name, r.duration_s, r.frames, number(r.rate_hz)),
    )?;
    let c = &r.character;
    line(
        out,
        "body",
        format!("{}: {} links, {} degrees of freedom, {:.1} kg", c.name, c.links, c.dof, c.mass_kg),
    )?;
    if let AnalysisSource::Clip(source) = &input.source {
        for (i, text) in
            source.import.as_ref().map(ToString::to_string).unwrap_or_default().lines().enumerate()
        {
            line(out, if i == 0 { "read" } else { "" }, text)?;
        }
        if let Some(body) = &source.body {
            let all = body.to_string();
            line(out, "guessed", all.lines().next().unwrap_or_default())?;
            line(out, "", "`contrapposto inspect` lists masses and limits; --body gives others")?;
        }
    }
    smoothing(out, r)?;
    ends(out, r)?;
    residual(out, r)?;
    let q = &r.required;
    line(
        out,
        "required",
        format!(
            "vertical {} % of body weight mean, {} % peak at {:.2} s, {} % least; horizontal {} % at most",
            percent(q.vertical_mean_percent_bw),
            percent(q.vertical_peak_percent_bw),
            q.vertical_peak_at_s,
            percent(q.vertical_least_percent_bw),
            percent(q.horizontal_peak_percent_bw)
        ),
    )?;
    ground(out, r)?;
    for (i, j) in r.joints.iter().take(JOINTS).enumerate() {
        let unit = if j.kind == "force" { "N" } else { "N·m" };
        let text = format!(
            "{}: peak {:.1} {unit} ({:.2} {unit}/kg) at {:.2} s, RMS {:.1} {unit}, noise {:.2} {unit}",
            j.joint, j.peak_nm, j.peak_nm_kg, j.peak_at_s, j.rms_nm, j.noise_nm
        );
        line(out, if i == 0 { "hardest" } else { "" }, text)?;
    }
    files(out, r, dir)
}

fn ends(out: &mut String, r: &AnalysisReport) -> std::fmt::Result {
    let e = &r.ends;
    if e.too_short {
        let text = "TOO SHORT to be graded: its ends, 0.05 s each, leave less than 0.1 s; the numbers below are of all frames";
        return line(out, "ends", text);
    }
    if e.left_out_s == 0.0 {
        return Ok(());
    }
    let mut text = format!("the first and last {:.2} s are not graded", e.left_out_s);
    if let (Some(first), Some(inside)) = (e.first_frame_error_n, e.inside_error_n) {
        text +=
            &format!(": cut there, forces are off by {first:.0} N RMS, {inside:.0} N where grading begins");
    }
    line(out, "ends", text)
}

fn smoothing(out: &mut String, r: &AnalysisReport) -> std::fmt::Result {
    let s = &r.smoothing;
    let text = s.cutoff_hz.map_or_else(|| "none".to_owned(), |hz| format!("at {hz:.1} Hz"));
    let moved = match s.smoothed {
        true => format!("; moved joints {:.2}° RMS, links {:.1} mm", s.joint_rms_deg, s.position_rms_mm),
        false => String::new(),
    };
    line(out, "smoothing", format!("{text}{moved}"))?;
    if !s.smoothed {
        return line(out, "noise", "not estimated: nothing was smoothed");
    }
    let text = format!(
        "torques {:.2} N·m (median joint), {:.2} N·m at most ({}); force {:.1} N, moment {:.1} N·m per axis",
        s.torque_noise_nm_median,
        s.torque_noise_nm_max,
        s.torque_noise_joint,
        s.force_noise_n,
        s.moment_noise_nm
    );
    line(out, "noise", text)
}

fn residual(out: &mut String, r: &AnalysisReport) -> std::fmt::Result {
    let x = &r.residual;
    let text = format!(
        "force {}: peak {:.1} N ({} % of body weight) at {:.2} s, RMS {:.1} N ({} %); good is up to 10 N, limit 25 N",
        x.force_grade,
        x.force_peak_n,
        percent(x.force_peak_percent_bw),
        x.force_peak_at_s,
        x.force_rms_n,
        percent(x.force_rms_percent_bw)
    );
    line(out, "residual", text)?;
    let text = format!(
        "moment {}: peak {:.1} N·m at {:.2} s, RMS {:.1} N·m; good is up to 50 N·m, limit 75 N·m",
        x.moment_grade, x.moment_peak_nm, x.moment_peak_at_s, x.moment_rms_nm
    );
    line(out, "", text)
}

fn ground(out: &mut String, r: &AnalysisReport) -> std::fmt::Result {
    let Some(height) = r.ground.height_m else {
        return line(out, "ground", "none: all force from outside is residual");
    };
    let feet = r.ground.feet.as_ref().map_or_else(String::new, |f| {
        format!(
            "; feet slip {:.0} mm, sink {:.0} mm, float {:.0} mm at most; skate {:.0} mm/s",
            f.slip_mm_max,
            f.penetration_mm_max.max(0.0),
            f.float_mm_max.max(0.0),
            f.skate_mm_s
        )
    });
    line(out, "ground", format!("at {height:.3} m{feet}; jerk {:.0} m/s³ RMS", r.jerk_rms_m_s3))?;
    let f = &r.friction;
    let text = match f.frames {
        0 => format!("within the cone of {} throughout", number(f.coefficient)),
        n => {
            let worst = f.worst.map_or_else(
                || "the ground would have to pull".to_owned(),
                |w| format!("{w:.2} times what friction {} holds", number(f.coefficient)),
            );
            format!("{n} frames outside the cone, worst at {:.2} s: {worst}", f.worst_at_s.unwrap_or(0.0))
        }
    };
    line(out, "friction", text)?;
    spans(out, &f.spans)?;
    let s = &r.support;
    let text = match s.frames {
        0 => "centre of pressure inside the soles throughout".into(),
        n => format!(
            "{n} frames with the centre of pressure outside the soles, worst {:.0} mm at {:.2} s",
            s.worst_mm,
            s.worst_at_s.unwrap_or(0.0)
        ),
    };
    line(out, "support", text)?;
    spans(out, &s.spans)?;
    let f = &r.flight;
    if f.frames > 0 {
        let held = percent(f.held_up_percent_bw);
        let text = format!("{} frames without contact, held up by {held} % of body weight RMS", f.frames);
        line(out, "flight", text)?;
        spans(out, &f.spans)?;
        if let Some(hz) = r.smoothing.cutoff_hz {
            let text = format!(
                "smoothing at {hz:.1} Hz spreads take-off and landing over {:.2} s: forces unexplained there are partly its own",
                1.0 / hz
            );
            line(out, "", text)?;
        }
    }
    Ok(())
}

/// Where something happens, longest spans first, in order of time.
fn spans(out: &mut String, all: &[FrameSpan]) -> std::fmt::Result {
    if all.is_empty() {
        return Ok(());
    }
    let mut longest: Vec<&FrameSpan> = all.iter().collect();
    longest.sort_by_key(|s| std::cmp::Reverse(s.to_frame - s.from_frame));
    longest.truncate(SPANS);
    longest.sort_by_key(|s| s.from_frame);
    let one = |s: &&FrameSpan| {
        format!("{:.2} to {:.2} s (frames {} to {})", s.from_s, s.to_s, s.from_frame, s.to_frame)
    };
    let mut text = longest.iter().map(one).collect::<Vec<_>>().join(", ");
    if all.len() > SPANS {
        let _ = write!(text, " and {} shorter, see report.json", all.len() - SPANS);
    }
    line(out, "", text)
}

fn files(out: &mut String, r: &AnalysisReport, dir: &Path) -> std::fmt::Result {
    let (figures, mut files): (Vec<&String>, Vec<&String>) =
        r.files.values().partition(|name| name.starts_with(PLOTS));
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

fn percent(x: Option<f64>) -> String {
    x.map_or_else(|| "-".into(), |x| if x.abs() < 10.0 { format!("{x:.1}") } else { format!("{x:.0}") })
}
