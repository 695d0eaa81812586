//! `convert`: a clip, the kinematic motion of a scene, or a body to another format.

use std::path::Path;

use motion::Clip;
use motion::format::{bvh, glb};
use scenes::{Overrides, StageError};

use crate::args::ConvertArgs;
use crate::failure::Failure;
use crate::output;

/// Runs the command.
///
/// # Errors
/// Bad input, a file that cannot be written.
pub fn run(args: &ConvertArgs) -> Result<(), Failure> {
    let kind = extension(&args.output);
    if args.dynamics_only && kind != "xml" {
        return Err(Failure::Input("--dynamics-only is for physics models; they are written as .xml".into()));
    }
    match kind.as_str() {
        "bvh" | "glb" => {}
        "xml" => return body(args),
        _ => {
            let path = args.output.display();
            return Err(Failure::Input(format!("{path}: cannot write this; allowed: .bvh, .glb, .xml")));
        }
    }
    if args.out_units.is_some() && kind == "glb" {
        return Err(Failure::Input("--out-units is for .bvh; a .glb is in metres by definition".into()));
    }
    let mut said = String::new();
    let (clip, solids, colors, unit) = match extension(&args.input).as_str() {
        "bvh" => {
            let (clip, report) = bvh::read_file(&args.input, &args.clip.import()).map_err(Failure::input)?;
            said += &format!("{report}\n");
            let solids = glb::bones(&clip.skeleton);
            (clip, solids, Vec::new(), report.units.metres_per_unit)
        }
        "ron" => {
            if let Some(option) = args.clip.given() {
                let path = args.input.display();
                return Err(Failure::Input(format!("{option} is for clips (.bvh); {path} is a scene")));
            }
            let stage = scenes::open_with(&args.input, None, &args.clip.import(), &Overrides::default())
                .map_err(Failure::input)?;
            (stage.kinematic.clone(), stage.solids(), stage.colors.clone(), stage.metres_per_unit())
        }
        _ => return Err(Failure::input(StageError::Kind(args.input.display().to_string()))),
    };
    said = format!("read {}: {}\n{said}", args.input.display(), describe(&clip));
    let clip = args.rate.map_or_else(|| clip.clone(), |rate| clip.resample(rate));
    let name = args.input.file_stem().unwrap_or_default().to_string_lossy();
    let written = if kind == "glb" {
        glb::write_file(&args.output, &clip, &solids, &colors, &name).map_err(Failure::run)?;
        "metres".to_owned()
    } else {
        let metres_per_unit = args.out_units.unwrap_or(unit);
        let options = bvh::WriteOptions { metres_per_unit, ..Default::default() };
        bvh::write_file(&args.output, &clip, &options).map_err(Failure::run)?;
        format!("units of {metres_per_unit} m")
    };
    said += &format!("wrote {}: {}, {written}, Y up\n", args.output.display(), describe(&clip));
    output::print(&said)
}

/// The body of a file as MJCF.
fn body(args: &ConvertArgs) -> Result<(), Failure> {
    for (option, given) in [("--rate", args.rate.is_some()), ("--out-units", args.out_units.is_some())] {
        if given {
            return Err(Failure::Input(format!("{option} is for motion; an .xml holds a body")));
        }
    }
    let made =
        scenes::export::mjcf(&args.input, &args.clip.import(), args.dynamics_only).map_err(Failure::input)?;
    motion::format::write(&args.output, made.text.as_bytes()).map_err(Failure::run)?;
    let (from, to) = (args.input.display(), args.output.display());
    let left: String = made.left_out.iter().map(|item| format!("left out: {item}\n")).collect();
    output::print(&format!(
        "{left}read {from}: {} links, {:.2} kg\nwrote {to}: MJCF, {} joints, {} antagonists, metres, radians, Y up\n",
        made.links, made.mass_kg, made.joints, made.antagonists
    ))
}

fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

fn describe(clip: &Clip) -> String {
    let links = clip.skeleton.links().len();
    format!("{links} links, {} frames at {:.3} Hz, {:.2} s", clip.frames(), clip.rate_hz, clip.duration_s())
}
