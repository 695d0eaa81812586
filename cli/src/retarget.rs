//! `retarget`: a human motion on a character of any shape, to a folder of clips, report and figures.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use motion::Clip;
use motion::format::{self, bvh, glb};
use scenes::retarget::{Options, Retargeted};
use scenes::retargeting::{
    self, Actor, Performance, RetargetReport, RetargetingError, Session, compare, contact_file, study,
};

use crate::args::RetargetArgs;
use crate::failure::Failure;
use crate::output::{self, Output};
use crate::progress::Progress;
use crate::retarget_figures as figures;
use crate::summary::{line, number};

/// Metres in one unit of the BVH files written: centimetres.
const UNIT: f64 = 0.01;

/// Runs the command.
///
/// # Errors
/// Bad input, a motion that cannot be mapped, files that cannot be written.
pub fn run(args: &RetargetArgs) -> Result<(), Failure> {
    let is_scene = args.input.extension().is_some_and(|e| e.eq_ignore_ascii_case("ron"));
    let option = args.clip.given().or(args.body.as_ref().map(|_| "--body"));
    if let Some(option) = option.filter(|_| is_scene) {
        let path = args.input.display();
        return Err(Failure::Input(format!("{option} is for clips (.bvh); {path} is a scene")));
    }
    if !args.guess.is_empty() {
        return guess(args);
    }
    let mut progress = Progress::new();
    progress.part("reading");
    let performance = performance(args)?;
    let session = Session::of(performance, &args.to, args.keyposes.as_deref()).map_err(failure)?;
    let name = format!("{}-{}", session.performance.name, session.actor.file.character.name);
    let dir = args.out.clone().unwrap_or_else(|| Path::new("out").join(&name));
    Output::check(&dir)?;

    if args.sheet {
        return sheet(&session, &dir);
    }
    progress.part("mapping");
    let mut options = Options {
        model: args.model.model(),
        stop_after: args.stop_after.stage(),
        rate_hz: args.rate,
        sway: !args.no_sway,
        ..Options::default()
    };
    options.global.size = args.size_ratio;
    options.refine.dofs = args.refine.0.clone();
    if let Some(path) = &args.contacts {
        options.contact.phases = Some(session.contacts(path).map_err(failure)?);
    }
    let mapping = session.learn(&options).map_err(failure)?;
    let done = session.run(&mapping, &options).map_err(failure)?;
    let suggested = match args.suggest_keyposes {
        Some(n) => session.suggest(&mapping, &done, n).map_err(failure)?,
        None => Vec::new(),
    };
    let mut report = RetargetReport::new(&session, options.model, &done, suggested);
    if args.compare {
        progress.part("comparing");
        report.models = compare::compare(&session, &options).map_err(failure)?;
    }
    if args.study {
        progress.part("studying");
        report.study = Some(study::study(&session, &done.human).map_err(failure)?);
    }

    progress.part("writing");
    let output = Output::replacing(&dir, ours())?;
    let mut folder = Folder { dir: output.dir().to_owned(), report: &mut report };
    folder.write(&session, &done, &name)?;
    if !args.no_plots {
        progress.part("drawing");
        let plots = folder.dir.join(output::PLOTS);
        std::fs::create_dir(&plots).map_err(|e| Failure::Run(format!("cannot write plots: {e}")))?;
        let drawn = folder.report.clone();
        figures::draw(&session, &drawn, &done, &mut |stem, figure, share| {
            figure.save(&plots, stem).map_err(Failure::run)?;
            for kind in ["svg", "png"] {
                folder.add(&format!("{stem}_{kind}"), &format!("{}/{stem}.{kind}", output::PLOTS));
            }
            progress.at(share);
            Ok(())
        })?;
    }
    folder.add("report_json", "report.json");
    let json = report.to_json();
    format::write(&output.dir().join("report.json"), json.as_bytes()).map_err(Failure::run)?;
    output.finish()?;
    drop(progress);
    output::print(&if args.json { json } else { summary(&report, &dir) })
}

/// The human motion.
fn performance(args: &RetargetArgs) -> Result<Performance, Failure> {
    Performance::with_body(&args.input, args.body.as_deref(), &args.clip.import()).map_err(failure)
}

/// Prints first guesses.
fn guess(args: &RetargetArgs) -> Result<(), Failure> {
    let actor = Actor::open(&args.to).map_err(failure)?;
    let performance = performance(args)?;
    let mut text = String::new();
    for &at_s in &args.guess {
        text += &retargeting::guess(&performance, &actor, at_s).map_err(failure)?;
        text.push('\n');
    }
    output::print(&text)
}

/// Draws the key poses.
fn sheet(session: &Session, dir: &Path) -> Result<(), Failure> {
    let plots = dir.join(output::PLOTS);
    std::fs::create_dir_all(&plots)
        .map_err(|e| Failure::Run(format!("cannot make {}: {e}", plots.display())))?;
    let files = figures::key_poses(session).save(&plots, "key_poses").map_err(Failure::run)?;
    output::print(&files.map(|f| format!("{}\n", f.display())).concat())
}

/// All faults of a request are of its input: nothing is random, and nothing outside is asked.
fn failure(e: RetargetingError) -> Failure {
    Failure::input(e)
}

/// Files of this command; those not written anew are removed.
fn ours() -> Vec<PathBuf> {
    let files =
        ["retargeted.bvh", "retargeted.glb", "human.bvh", "contacts.ron", "report.json"].map(PathBuf::from);
    let kinds =
        |stem: &str| ["svg", "png"].map(|kind| Path::new(output::PLOTS).join(format!("{stem}.{kind}")));
    files.into_iter().chain(figures::STEMS.iter().flat_map(|stem| kinds(stem))).collect()
}

struct Folder<'a> {
    dir: PathBuf,
    report: &'a mut RetargetReport,
}

impl Folder<'_> {
    fn add(&mut self, what: &str, name: &str) -> PathBuf {
        self.report.files.insert(what.into(), name.into());
        self.dir.join(name)
    }

    fn bvh(&mut self, stem: &str, clip: &Clip) -> Result<(), Failure> {
        let path = self.add(&format!("{stem}_bvh"), &format!("{stem}.bvh"));
        let options = bvh::WriteOptions { metres_per_unit: UNIT, ..Default::default() };
        bvh::write_file(&path, clip, &options).map_err(Failure::run)
    }

    fn write(&mut self, session: &Session, done: &Retargeted, name: &str) -> Result<(), Failure> {
        self.bvh("retargeted", &done.clip)?;
        self.bvh("human", &done.human)?;
        if done.contact.is_some() {
            let path = self.add("contacts_ron", "contacts.ron");
            let text = contact_file::text(&session.actor.puppet, &done.phases);
            format::write(&path, text.as_bytes()).map_err(Failure::run)?;
        }
        let path = self.add("retargeted_glb", "retargeted.glb");
        let stage = session.stage(done);
        glb::write_file(&path, &done.clip, &stage.solids(), &stage.colors, name).map_err(Failure::run)
    }
}

fn summary(r: &RetargetReport, dir: &Path) -> String {
    let mut out = String::new();
    // writing to a String cannot fail
    let _ = write(&mut out, r, dir);
    out
}

fn write(out: &mut String, r: &RetargetReport, dir: &Path) -> std::fmt::Result {
    let stages: String = match r.stopped_after {
        "refine" => "mapped, moved, put on the ground, refined".into(),
        stage => format!("stopped after {stage}"),
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
    for (i, s) in r.suggested.iter().enumerate() {
        let text = format!("{:.3} s, confidence {:.0} %", s.at_s, 100.0 * s.confidence);
        line(out, if i == 0 { "next pose" } else { "" }, text)?;
    }
    if !r.models.is_empty() {
        line(out, "models", "error at key poses: learned, left out one by one, left out by performance")?;
        for m in &r.models {
            let text = format!(
                "  {:<6} {:>5.1}°  {:>5.1}°  {:>5.1}°   jerk × {:.2}",
                m.model, m.learned_deg, m.left_out_deg, m.performance_left_out_deg, m.jerk_ratio
            );
            line(out, "", text)?;
        }
    }
    if let Some(s) = &r.study {
        write_study(out, s)?;
    }
    let mut files: Vec<&String> = r.files.values().filter(|f| !f.starts_with(output::PLOTS)).collect();
    let plots = format!("{}/", output::PLOTS);
    if r.files.values().any(|f| f.starts_with(output::PLOTS)) {
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
