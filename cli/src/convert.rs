//! `convert`: a clip, the kinematic motion of a scene, or a body to another format.

use std::path::PathBuf;

use formats::glb;
use formats::table::{ClipOut, endings};
use motion::Clip;
use takes::results::folder::{check_file, write_file};
use takes::{Ask, Take};

use crate::args::ConvertArgs;
use crate::failure::Failure;
use crate::output;

/// Runs the command.
///
/// # Errors
/// Bad input, a file that cannot be written.
pub fn run(args: &ConvertArgs) -> Result<(), Failure> {
    if args.blocking {
        return blocking(args);
    }
    let format = formats::format_of(&args.output);
    if format.is_some_and(|format| format.writes_body) {
        return body(args);
    }
    if args.dynamics_only {
        let kinds = endings(|format| format.writes_body);
        return Err(Failure::Input(format!(
            "--dynamics-only is for physics models; they are written as {kinds}"
        )));
    }
    let Some((format, write)) = format.and_then(|format| Some((format, format.write_clip?))) else {
        let (path, kinds) = (args.output.display(), endings(|f| f.write_clip.is_some() || f.writes_body));
        return Err(Failure::Input(format!("{path}: cannot write this; allowed: {kinds}")));
    };
    if args.out_units.is_some() && !format.units {
        let ending = format.endings[0];
        return Err(Failure::Input(format!(
            "--out-units is for {}; a .{ending} is in metres by definition",
            endings(|f| f.units)
        )));
    }
    let mut text = String::new();
    let mut reads = vec![args.input.clone()];
    check(args, &reads)?;
    let is_clip = formats::table::is_clip(&args.input);
    if !args.edit.is_empty() && !is_clip {
        let path = args.input.display();
        return Err(Failure::Input(format!(
            "--edit is for clips (.bvh); {path} is none, a scene has its own `edits`"
        )));
    }
    let is_taken = !args.edit.is_empty() || args.loop_s.is_some();
    let (clip, solids, colors, unit) = if is_clip && is_taken {
        let take = takes::open(args.input.as_path(), &ask(args))?;
        reads.extend(take.files.iter().cloned());
        text += &looped(&take);
        text += &edits_said(&take);
        let clip = take.for_files(&take.asked.clip);
        let solids = glb::bones(&clip.skeleton);
        (clip, solids, Vec::new(), take.metres_per_unit())
    } else if is_clip {
        let read = formats::open_clip(&args.input, &args.clip.import());
        let (clip, report) = read.map_err(Failure::input)?;
        text += &format!("{report}\n");
        let solids = glb::bones(&clip.skeleton);
        (clip, solids, Vec::new(), report.units.metres_per_unit)
    } else {
        if let Some(option) = args.clip.given() {
            let path = args.input.display();
            return Err(Failure::Input(format!("{option} is for clips (.bvh); {path} is none")));
        }
        let take = takes::open(args.input.as_path(), &Ask { loop_s: args.loop_s, ..Ask::default() })?;
        text += &looped(&take);
        reads.extend(take.files.iter().cloned());
        let unit = take.metres_per_unit();
        (take.asked.clip, take.body.solids(), take.body.colors, unit)
    };
    text = format!("read {}: {}\n{text}", args.input.display(), describe(&clip));
    let clip = args.rate.map_or_else(|| clip.clone(), |rate| clip.resample(rate));
    let name = args.input.file_stem().unwrap_or_default().to_string_lossy();
    let metres_per_unit = if format.units { args.out_units.unwrap_or(unit) } else { 1.0 };
    let out = ClipOut { clip: &clip, solids: &solids, colors: &colors, name: &name, metres_per_unit };
    put(args, &write(&out).map_err(Failure::run)?, &reads)?;
    let written = if format.units { format!("units of {metres_per_unit} m") } else { "metres".to_owned() };
    text += &format!("wrote {}: {}, {written}, Y up\n", args.output.display(), describe(&clip));
    output::print(&text)
}

/// What is asked beside the file.
fn ask(args: &ConvertArgs) -> Ask {
    Ask { import: args.clip.import(), edits: args.edit.clone(), loop_s: args.loop_s, ..Ask::default() }
}

/// What of a clip was repeated.
fn looped(take: &Take) -> String {
    let cycle = take.clip_source().and_then(|source| source.cycle.as_ref());
    cycle.map_or_else(String::new, |cycle| format!("looped: {cycle}\n"))
}

/// What the edits of a take changed, a line each.
fn edits_said(take: &Take) -> String {
    take.log.clip_lines().iter().map(|line| format!("{line}\n")).collect()
}

/// The key poses of a clip as a scene, with its character beside it.
fn blocking(args: &ConvertArgs) -> Result<(), Failure> {
    let (from, to) = (args.input.display(), args.output.display());
    if !takes::is_ron(&args.output) {
        return Err(Failure::Input(format!("--blocking writes a scene; {to} is none; allowed: .ron")));
    }
    if !formats::table::is_clip(&args.input) {
        return Err(Failure::Input(format!("--blocking is for clips (.bvh); {from} is none")));
    }
    let given = [
        ("--rate", args.rate.is_some()),
        ("--out-units", args.out_units.is_some()),
        ("--dynamics-only", args.dynamics_only),
    ];
    if let Some((option, _)) = given.iter().find(|(_, given)| *given) {
        return Err(Failure::Input(format!("{option} does nothing with --blocking")));
    }
    let stem = args.output.file_stem().unwrap_or_default().to_string_lossy();
    let character = args.output.with_file_name(format!("{stem}-character.ron"));
    let reads = [args.input.clone()];
    let overwrite = output::overwrite(args.force);
    for path in [&character, &args.output] {
        check_file(path, overwrite, &reads)?;
    }
    let take = takes::open(args.input.as_path(), &ask(args))?;
    let name = character.file_name().unwrap_or_default().to_string_lossy();
    let source = args.input.file_name().unwrap_or_default().to_string_lossy();
    let made = takes::blocking::block(&take, &name, &source).map_err(Failure::run)?;
    for (path, text) in [(&character, &made.character), (&args.output, &made.scene)] {
        write_file(path, text.as_bytes(), overwrite, &take.files)?;
    }
    output::print(&format!(
        "{}read {from}: {}\nwrote {to}: {} key poses in {:.2} s ({:.1} a second), joints {:.1}\u{b0} RMS and links {:.0} mm RMS from the clip\nwrote {}: its character\ngo on with: contrapposto render {to} --kinematic\n",
        edits_said(&take),
        describe(&take.asked.clip),
        made.poses,
        made.duration_s,
        (made.poses - 1) as f64 / made.duration_s,
        made.rms_deg,
        made.rms_mm,
        character.display(),
    ))
}

/// The body of a file as MJCF.
fn body(args: &ConvertArgs) -> Result<(), Failure> {
    for (option, given) in [
        ("--rate", args.rate.is_some()),
        ("--out-units", args.out_units.is_some()),
        ("--edit", !args.edit.is_empty()),
        ("--loop", args.loop_s.is_some()),
    ] {
        if given {
            return Err(Failure::Input(format!("{option} is for motion; an .xml holds a body")));
        }
    }
    let reads = [args.input.clone()];
    check(args, &reads)?;
    let made =
        takes::export::mjcf(&args.input, &args.clip.import(), args.dynamics_only).map_err(Failure::input)?;
    put(args, made.text.as_bytes(), &reads)?;
    let (from, to) = (args.input.display(), args.output.display());
    let ground = match made.ground_m {
        Some(y) => format!("ground at y = {y:.3} m"),
        None => "no ground".to_owned(),
    };
    let left: String = made.left_out.iter().map(|item| format!("left out: {item}\n")).collect();
    output::print(&format!(
        "{left}read {from}: {} links, {:.2} kg\nwrote {to}: MJCF, {} joints, {} antagonists, {ground}, metres, radians, Y up\n",
        made.links, made.mass_kg, made.joints, made.antagonists
    ))
}

/// Checks that the output may be written, before anything is read.
fn check(args: &ConvertArgs, reads: &[PathBuf]) -> Result<(), Failure> {
    Ok(check_file(&args.output, output::overwrite(args.force), reads)?)
}

/// Writes the output, whole or not at all; never over a file that was read.
fn put(args: &ConvertArgs, bytes: &[u8], reads: &[PathBuf]) -> Result<(), Failure> {
    Ok(write_file(&args.output, bytes, output::overwrite(args.force), reads)?)
}

fn describe(clip: &Clip) -> String {
    let links = clip.skeleton.links().len();
    format!("{links} links, {} frames at {:.3} Hz, {:.2} s", clip.frames(), clip.rate_hz, clip.duration_s())
}
