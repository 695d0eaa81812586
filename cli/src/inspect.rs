//! `inspect`: what is in a scene, a character, a clip or a physics model, as text or JSON.

use std::fmt::Write;
use std::path::Path;

use takes::character_file;
use takes::inspect::{
    BodyInspection, ClipInspection, ElementInspection, Inspection, LinkInspection, ModelInspection,
    SceneInspection, inspect,
};
use takes::results::folder::{Overwrite, write_file};
use takes::results::number;

use crate::args::InspectArgs;
use crate::failure::Failure;
use crate::output;

/// Runs the command.
///
/// # Errors
/// Bad input, a body that cannot be written.
pub fn run(args: &InspectArgs) -> Result<(), Failure> {
    let path = args.input.display();
    let is_clip = formats::table::is_clip(&args.input);
    let option = args.clip.given().or(args.write_body.as_ref().map(|_| "--write-body"));
    if let Some(option) = option.filter(|_| !is_clip) {
        return Err(Failure::Input(format!("{option} is for clips (.bvh), not for {path}")));
    }
    let (found, body) = inspect(&args.input, &args.clip.import()).map_err(Failure::input)?;
    let mut text = if args.json {
        output::to_json(&found)?
    } else {
        // writing to a String cannot fail
        let mut text = String::new();
        let _ = match &found {
            Inspection::Scene(scene) => write_scene(&mut text, scene),
            Inspection::Character(body) => write_body(&mut text, body),
            Inspection::Clip(clip) => write_clip(&mut text, clip, &args.input),
            Inspection::Model(model) => write_model(&mut text, model),
        };
        text
    };
    if let Some(file) = &args.write_body {
        let Some(body) = body else {
            let why = match found {
                Inspection::Clip(clip) => clip.no_body.unwrap_or_default(),
                _ => String::new(),
            };
            return Err(Failure::Input(format!("{path}: no body to write: {why}")));
        };
        let name = args.input.file_name().unwrap_or_default().to_string_lossy();
        let comment = format!(
            "A body guessed for {name}. Lengths in metres, masses in kilograms, angles in degrees.\nUse: contrapposto render {name} --body this-file.ron"
        );
        let overwrite = if args.force { Overwrite::Allow } else { Overwrite::Refuse };
        let text_of_body = character_file::write(&body, &comment);
        write_file(file, text_of_body.as_bytes(), overwrite, std::slice::from_ref(&args.input))?;
        if !args.json {
            let _ = writeln!(text, "\nbody written to {}", file.display());
        }
    }
    output::print(&text)
}

fn write_body(out: &mut String, b: &BodyInspection) -> std::fmt::Result {
    let mass = b.mass_kg.map_or_else(String::new, |m| format!(", {m:.2} kg"));
    writeln!(
        out,
        "{}: {} links, {} degrees of freedom{mass}, {:.3} m high",
        b.name,
        b.links.len(),
        b.dof,
        b.height_m
    )?;
    let width =
        b.links.iter().map(|l| l.name.chars().count() + 2 * l.depth.min(20)).max().unwrap_or(0).max(4);
    let head =
        format!("  {:<width$}  {:<6} {:>3}  {:>8}  limits, degrees", "link", "joint", "dof", "mass, kg");
    writeln!(out, "{}", head.trim_end())?;
    for l in &b.links {
        let name = format!("{}{}", "  ".repeat(l.depth.min(20)), l.name);
        let mass = l.mass_kg.map_or_else(|| "-".into(), |m| format!("{m:.3}"));
        let text = format!("  {name:<width$}  {:<6} {:>3}  {mass:>8}  {}", l.joint, l.dof, limits(l));
        writeln!(out, "{}", text.trim_end())?;
    }
    let limbs: Vec<String> = b.limbs.iter().map(|(name, l)| format!("{name} ({})", l.join(", "))).collect();
    if !limbs.is_empty() {
        writeln!(out, "limbs: {}", limbs.join("; "))?;
    }
    let parts = b.parts.iter().filter(|(name, _)| !b.limbs.contains_key(*name));
    let parts: Vec<String> = parts.map(|(name, p)| format!("{name} ({})", p.join(", "))).collect();
    if !parts.is_empty() {
        writeln!(out, "parts: {}", parts.join("; "))?;
    }
    if !b.contacts.is_empty() {
        writeln!(out, "contact points: {}", b.contacts.join(", "))?;
    }
    Ok(())
}

fn write_model(out: &mut String, m: &ModelInspection) -> std::fmt::Result {
    write_body(out, &m.body)?;
    let [x, y, z] = m.gravity_m_s2;
    let ground = m.ground_m.map_or_else(|| "no ground".into(), |h| format!("ground at y = {h:.3} m"));
    writeln!(out, "{}, Y up: gravity {x} {y} {z} m/s², {ground}", m.format)?;
    if m.dynamics_only {
        writeln!(out, "not read, and makes forces: {}", m.forces_left_out)?;
        writeln!(
            out,
            "  convert and crosscheck leave it out with --dynamics-only, and refuse the file without"
        )?;
    }
    if !m.looks_left_out.is_empty() {
        writeln!(out, "not read, makes no forces: {}", m.looks_left_out)?;
    }
    const SHOWN: usize = 20;
    m.left_out.iter().take(SHOWN).try_for_each(|item| writeln!(out, "left out: {item}"))?;
    match m.left_out.len().saturating_sub(SHOWN) {
        0 => Ok(()),
        more => writeln!(out, "and {more} more (--json lists all)"),
    }
}

fn limits(l: &LinkInspection) -> String {
    if let Some([lo, hi]) = l.limits_m {
        return format!("{lo:.3} to {hi:.3} m");
    }
    let one = |[lo, hi]: &[f64; 2]| format!("{lo:.0} to {hi:.0}");
    match l.limits_deg.get("hinge") {
        Some(range) => one(range),
        None => {
            let all: Vec<String> =
                l.limits_deg.iter().map(|(name, r)| format!("{name} {}", one(r))).collect();
            all.join(", ")
        }
    }
}

fn write_clip(out: &mut String, c: &ClipInspection, path: &Path) -> std::fmt::Result {
    writeln!(out, "{}: {} frames at {:.3} Hz, {:.2} s", path.display(), c.frames, c.rate_hz, c.duration_s)?;
    c.import.iter().try_for_each(|l| writeln!(out, "{l}"))?;
    writeln!(out)?;
    match &c.no_body {
        Some(why) => writeln!(out, "no body: {why}")?,
        // the table below has the masses again
        None => c.guess.iter().filter(|l| !l.ends_with(" kg")).try_for_each(|l| writeln!(out, "{l}"))?,
    }
    writeln!(out)?;
    write_body(out, &c.body)
}

fn write_scene(out: &mut String, s: &SceneInspection) -> std::fmt::Result {
    let length = s.duration_s.map_or_else(|| s.motion.clone(), |x| format!("{x:.2} s"));
    let rate = s.rate_hz.map_or_else(|| "the motion's rate".into(), |x| format!("{} Hz", number(x)));
    writeln!(out, "{}: {length} at {rate}, root {}", s.name, s.root)?;
    if !s.planted.is_empty() {
        writeln!(out, "planted: {}", s.planted.join(", "))?;
    }
    writeln!(out, "\nactions")?;
    for a in &s.actions {
        let cycles = a.cycles.iter().map(|c| match c.repetitions {
            1 => format!("{} poses", c.poses),
            n => format!("{} poses × {n}", c.poses),
        });
        let cycles: Vec<String> = cycles.collect();
        writeln!(out, "  {} from {:.2} s: {}", a.name, a.start_s, cycles.join(", then "))?;
    }
    writeln!(out)?;
    write_elements(out, &s.elements)?;
    for p in &s.programs {
        let params: Vec<String> = p.params.iter().map(|(name, value)| format!("{name}: {value}")).collect();
        let params = if params.is_empty() { "no parameters".into() } else { params.join(", ") };
        writeln!(out, "\nprogram {} (fn {}): {params}", p.file, p.does)?;
    }
    if !s.edits.is_empty() {
        let edits: Vec<String> = s.edits.iter().enumerate().map(|(i, e)| format!("{i} {e}")).collect();
        writeln!(out, "\nedits, in order: {}", edits.join(", "))?;
        s.log.iter().try_for_each(|l| writeln!(out, "  {l}"))?;
    }
    if !s.overlaps.is_empty() {
        writeln!(out, "\noverlaps: the later element takes over")?;
    }
    for o in &s.overlaps {
        let lost = if o.cut_s > 0.0 { format!("{:.3} s of its transition", o.cut_s) } else { "hold".into() };
        writeln!(out, "  {} loses {lost} to {} at {:.3} s", o.earlier, o.later, o.at_s)?;
    }
    writeln!(out)?;
    write_body(out, &s.body)
}

fn write_elements(out: &mut String, elements: &[ElementInspection]) -> std::fmt::Result {
    let width = elements.iter().map(|e| e.label.chars().count()).max().unwrap_or(0).max(7);
    let curve = elements.iter().map(|e| e.curve.chars().count()).max().unwrap_or(0).max(5);
    writeln!(
        out,
        "{:<width$}  start, s  duration, s  hold, s  tension  {:<curve$}  end, degrees or m",
        "element", "curve"
    )?;
    for e in elements {
        let end = match (&e.end_deg, e.end_m) {
            // + 0.0 takes the sign off a zero
            (Some(deg), _) => {
                let angle = |x: &f64| format!("{:.1}", (x * 10.0).round() / 10.0 + 0.0);
                deg.iter().map(angle).collect::<Vec<_>>().join(", ")
            }
            (None, Some(m)) => format!("{m:.3} m"),
            (None, None) => String::new(),
        };
        let edited = e.edited_by.as_ref().map_or_else(String::new, |by| format!("  by {by}"));
        writeln!(
            out,
            "{:<width$}  {:>8.3}  {:>11.3}  {:>7.3}  {:>7.2}  {:<curve$}  {end}{edited}",
            e.label, e.start_s, e.duration_s, e.hold_s, e.tension, e.curve
        )?;
    }
    Ok(())
}
