//! `retarget`: a human motion on a character of any shape, to a folder of clips, report and figures.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use motion::names::Word;
use studies::retarget::{StudiedReport, compare, results, study};
use takes::results::folder::Folder;
use takes::results::number;
use takes::results::write::PLOTS;
use takes::retarget::{Options, PipelineStage};
use takes::retargeting::{self, Actor, Performance, RetargetReport, Session};

use crate::args::RetargetArgs;
use crate::failure::Failure;
use crate::output;
use crate::progress::progress;
use crate::summary::line;

/// Runs the command.
///
/// # Errors
/// Bad input, a motion that cannot be mapped, files that cannot be written.
pub fn run(args: &RetargetArgs) -> Result<(), Failure> {
    let is_scene = takes::is_ron(&args.input);
    let option = args.clip.given().or(args.body.as_ref().map(|_| "--body"));
    if let Some(option) = option.filter(|_| is_scene) {
        let path = args.input.display();
        return Err(Failure::Input(format!("{option} is for clips (.bvh); {path} is a scene")));
    }
    if !args.guess.is_empty() {
        return guess(args);
    }
    let progress = progress();
    progress.part("reading");
    let performance = performance(args)?;
    let session = Session::of(performance, &args.to, args.keyposes.as_deref())?;
    let dir = output::folder(args.out.as_deref(), &session.name());
    let reads = reads(args, &session);
    if args.sheet {
        let files = results::write_sheet(&session, &dir)?;
        return output::print(&files.iter().map(|f| format!("{}\n", f.display())).collect::<String>());
    }
    Folder::check(&dir, &results::plan(&dir, &reads))?;

    progress.part("mapping");
    let mut options = Options {
        model: args.model,
        stop_after: args.stop_after,
        rate_hz: args.rate,
        sway: !args.no_sway,
        ..Options::default()
    };
    options.global.size = args.size_ratio;
    options.refine.dofs = args.refine.clone();
    if let Some(path) = &args.contacts {
        options.contact.phases = Some(session.contacts(path)?);
    }
    let mapping = session.learn(&options)?;
    let done = session.run(&mapping, &options)?;
    let suggested = match args.suggest_keyposes {
        Some(n) => session.suggest(&mapping, &done, n)?,
        None => Vec::new(),
    };
    let run = RetargetReport::new(&session, options.model, &done, suggested);
    let mut report = StudiedReport { run, models: Vec::new(), study: None };
    if args.compare {
        progress.part("comparing");
        report.models = compare::compare(&session, &options)?;
    }
    if args.study {
        progress.part("studying");
        report.study = Some(study::study(&session, &done.human)?);
    }
    let undrawn = results::write(&session, &done, &mut report, &dir, !args.no_plots, &reads, &progress)?;
    drop(progress);
    output::print(&if args.json { report.to_json() } else { summary(&report, &dir) })?;
    output::undrawn(&undrawn, &dir)
}

/// Files that were read, and so are never replaced.
fn reads(args: &RetargetArgs, session: &Session) -> Vec<PathBuf> {
    let named = [&args.input, &args.to, &session.key_poses.path];
    let named = named.into_iter().chain(&args.body).chain(&args.contacts);
    named.cloned().collect()
}

/// The human motion.
fn performance(args: &RetargetArgs) -> Result<Performance, Failure> {
    Performance::with_body(&args.input, args.body.as_deref(), &args.clip.import()).map_err(Failure::from)
}

/// Prints first guesses.
fn guess(args: &RetargetArgs) -> Result<(), Failure> {
    let actor = Actor::open(&args.to)?;
    let performance = performance(args)?;
    let mut text = String::new();
    for &at_s in &args.guess {
        text += &retargeting::guess(&performance, &actor, at_s)?;
        text.push('\n');
    }
    output::print(&text)
}

fn summary(studied: &StudiedReport, dir: &Path) -> String {
    let mut out = String::new();
    // writing to a String cannot fail
    let _ = write(&mut out, studied, dir);
    out
}

fn write(out: &mut String, studied: &StudiedReport, dir: &Path) -> std::fmt::Result {
    let r = &studied.run;
    let stages = if r.stopped_after == PipelineStage::Refine.word() {
        "mapped, moved, put on the ground, refined".into()
    } else {
        format!("stopped after {}", r.stopped_after)
    };
    writeln!(out, "{} for the {}: {stages}", r.performance, r.character)?;
    let text = format!("{:.2} s, {} frames at {} Hz", r.duration_s, r.frames, number(r.rate_hz));
    line(out, "motion", text)?;
    let m = &r.mapping;
    let latent = match m.latent_dimensions {
        0 => String::new(),
        n => format!(", {n} latent dimensions"),
    };
    line(out, "model", format!("{} of {} key poses{latent}", r.model, r.key_poses))?;
    let mut text = format!(
        "{:.0} % on average, least {:.0} % at {:.2} s",
        100.0 * m.confidence_mean,
        100.0 * m.confidence_least,
        m.confidence_least_at_s
    );
    if m.extrapolates > 0.0 {
        let _ = write!(text, "; {:.0} % of the frames are extrapolated", 100.0 * m.extrapolates);
    }
    line(out, "confidence", text)?;
    if !m.jumps_at_s.is_empty() {
        let at: Vec<String> = m.jumps_at_s.iter().take(6).map(|t| format!("{t:.2} s")).collect();
        let text = format!("{} to another basin of the model: {}", m.jumps_at_s.len(), at.join(", "));
        line(out, "jumps", text)?;
    }
    line(out, "body", format!("fits the mapped points within {:.1} mm on average", m.fit_mm_mean))?;
    if let Some(p) = &r.momentum {
        line(
            out,
            "momentum",
            format!("horizontal within {:.2} % of the scaled human's", p.mismatch_percent),
        )?;
    }
    if let Some(c) = &r.contact {
        let none = if c.phases.is_empty() { ", nothing is held on the ground" } else { "" };
        let text = format!(
            "{} phases{none}; slip {:.1} mm, penetration {:.1} mm",
            c.phases.len(),
            c.slip_mm,
            c.penetration_mm
        );
        line(out, "contacts", text)?;
    }
    if let Some(s) = &r.sway {
        line(
            out,
            "sway",
            format!(
                "{} joints followed by dynamics, up to {:.0}° from their key poses",
                s.joints, s.most_deg
            ),
        )?;
    }
    if let Some(f) = &r.refinement {
        let text = format!(
            "vertical mismatch fell by {:.0} %, all of it by {:.0} %; root moved {:.1} mm (median), slip {:.1} mm",
            f.vertical_fell_percent, f.all_fell_percent, f.root_median_mm, f.slip_mm
        );
        line(out, "forces", text)?;
        let after = f.cone_after_at_s.len();
        if f.cone_frames_before + after > 0 {
            let text = format!("{} frames outside before, {after} after", f.cone_frames_before);
            line(out, "friction", text)?;
        }
    }
    for (i, warning) in r.warnings.iter().enumerate() {
        line(out, if i == 0 { "warning" } else { "" }, warning)?;
    }
    for (i, s) in r.suggested.iter().enumerate() {
        let text = format!("{:.3} s, confidence {:.0} %", s.at_s, 100.0 * s.confidence);
        line(out, if i == 0 { "next pose" } else { "" }, text)?;
    }
    if !studied.models.is_empty() {
        line(out, "models", "error at key poses: learned, left out one by one, left out by performance")?;
        for m in &studied.models {
            let text = format!(
                "  {:<6} {:>5.1}°  {:>5.1}°  {:>5.1}°   jerk × {:.2}",
                m.model, m.learned_deg, m.left_out_deg, m.performance_left_out_deg, m.jerk_ratio
            );
            line(out, "", text)?;
        }
    }
    if let Some(s) = &studied.study {
        write_study(out, s)?;
    }
    let mut files: Vec<&String> = r.files.values().filter(|f| !f.starts_with(PLOTS)).collect();
    let plots = format!("{}/", PLOTS);
    if r.files.values().any(|f| f.starts_with(PLOTS)) {
        files.push(&plots);
    }
    for (i, name) in files.iter().enumerate() {
        line(out, if i == 0 { "files" } else { "" }, dir.join(name).display().to_string())?;
    }
    Ok(())
}

fn write_study(out: &mut String, s: &study::Study) -> std::fmt::Result {
    let a = &s.agreement;
    let text = format!(
        "rank correlation of distances {:.2}; the nearest human's pose is {:.1}° off, the nearest of all {:.1}°",
        a.rank_correlation, a.of_nearest_human_deg, a.of_nearest_character_deg
    );
    line(out, "agreement", text)?;
    line(
        out,
        "dimensions",
        "error at key poses: learned, left out; jerk of the latent path (searched as in the paper)",
    )?;
    for d in &s.dimensions {
        let text = format!(
            "  {:<4} {:>5.1}°  {:>5.1}°   {:>5.0} /s³   (searched {:>5.1}°, {:>6.0} /s³, {} jumps)",
            d.dimensions,
            d.learned_deg,
            d.left_out_deg,
            d.jerk_s3,
            d.search_learned_deg,
            d.search_jerk_s3,
            d.search_jumps
        );
        line(out, "", text)?;
    }
    if let Some(d) = &s.dropped {
        let errors: Vec<String> = d.error_deg.iter().map(|(m, e)| format!("{m} {e:.1}°")).collect();
        let text = format!(
            "without its {} key poses ({} left) the motion differs by {:.1}° of {:.1}°; error at them: {}",
            d.key_poses,
            d.left,
            d.from_full_deg,
            d.extent_deg,
            errors.join(", ")
        );
        line(out, "dropped", text)?;
    }
    if let Some(g) = &s.suggestions {
        let text = format!(
            "five suggested poses lower {:.1}° by {:.1}°, five random ones by {:.1}° (elsewhere {:.1}°, {:.1}°)",
            g.before_deg,
            g.suggested_gain_deg,
            g.random_gain_deg,
            g.suggested_gain_elsewhere_deg,
            g.random_gain_elsewhere_deg
        );
        line(out, "suggesting", text)?;
    }
    Ok(())
}
