//! `pose`: one pose of a clip corrected by dragging, and the frames around it with it.

use formats::table::ClipOut;
use takes::posing::{Moment, PoseOrder, PoseRequest, PoseSource, Posed, check};
use takes::results::folder::{check_file, write_file};
use takes::results::number;

use crate::failure::Failure;
use crate::output;
use crate::pose_args::PoseArgs;
use crate::progress::progress;

/// Joints that the summary names.
const NAMED: usize = 12;

/// Runs the command.
///
/// # Errors
/// Bad input, files that cannot be written.
pub fn run(args: &PoseArgs) -> Result<(), Failure> {
    if let Some(option) = args.clip.given().filter(|_| !formats::table::is_clip(&args.input)) {
        let path = args.input.display();
        return Err(Failure::Input(format!("{option} is for clips (.bvh); {path} is none")));
    }
    let order = PoseOrder {
        at: args.frame.map_or(Moment::Time(args.at.unwrap_or_default()), Moment::Frame),
        request: PoseRequest {
            drag: args.drag.clone(),
            pin: args.pin.clone(),
            weight: args.weight.clone(),
            group: args.group.iter().map(|g| g.0.clone()).collect(),
            limits: args.limits,
        },
        blend_s: args.blend_s,
        block_s: args.block,
        to_s: args.to_s,
    };
    let format = args.out.as_ref().and_then(|path| formats::format_of(path));
    let source = PoseSource::open(&args.input, &args.clip.import()).map_err(Failure::input)?;
    let mut undrawn = Vec::new();
    let posed;
    let to = if let (Some(path), Some(format)) = (&args.out, format) {
        let Some(write) = format.write_clip else {
            let (path, name) = (path.display(), format.name);
            return Err(Failure::Input(format!(
                "{path}: {name} holds no motion that is written; allowed: .bvh, .glb, or a folder"
            )));
        };
        if args.view.is_some() {
            return Err(Failure::Input(
                "--view is for the film strip, which is drawn into a folder; found a file in --out".into(),
            ));
        }
        let overwrite = output::overwrite(args.force);
        check_file(path, overwrite, &source.files)?;
        posed = source.pose(&order).map_err(Failure::input)?;
        let unit = if format.units { source.metres_per_unit } else { 1.0 };
        let (clip, solids, colors, name) = (&posed.clip, &source.solids, &source.colors, &source.name);
        let bytes =
            write(&ClipOut { clip, solids, colors, name, metres_per_unit: unit }).map_err(Failure::run)?;
        write_file(path, &bytes, overwrite, &source.files)?;
        path.clone()
    } else {
        if args.force {
            return Err(Failure::Input("--force is for a clip to write (.bvh, .glb); a folder of results replaces what its last run wrote".into()));
        }
        let dir = output::folder(args.out.as_deref(), &format!("{}-pose", source.name));
        check(&dir, &source.files)?;
        posed = source.pose(&order).map_err(Failure::input)?;
        let progress = progress();
        undrawn = source.write(&posed, &order, &dir, args.view, !args.no_plots, &progress)?;
        dir
    };
    let text = if args.json {
        output::to_json(&source.report(&posed))?
    } else {
        summary(&source, &posed, &to.display().to_string())
    };
    output::print(&text)?;
    output::undrawn(&undrawn, &to)
}

fn summary(source: &PoseSource, posed: &Posed, to: &str) -> String {
    let mut text = source.import.as_ref().map_or_else(String::new, |import| format!("{import}\n"));
    text += &format!("{}: the pose at {} s", source.name, number(posed.at_s));
    if posed.to_s != posed.at_s {
        text += &format!(" comes at {} s", number(posed.to_s));
    }
    text += "\n";
    if let Some(answer) = &posed.answer {
        for m in &answer.met {
            let verb = if m.pinned { "pinned " } else { "dragged" };
            let place = |p: &[f64]| format!("({:.3}, {:.3}, {:.3})", p[0], p[1], p[2]);
            let left = if m.pinned {
                format!("{:.1e} m left", m.miss_m)
            } else {
                format!("{:.1} mm left", 1e3 * m.miss_m)
            };
            let (from, to) = (place(m.from.as_slice()), place(m.to.as_slice()));
            let way = if m.pinned { format!("at {from} m") } else { format!("from {from} to {to} m") };
            text += &format!("  {verb} {}: {way}, {left}\n", m.name);
        }
        let missed = answer.met.iter().filter(|m| !m.pinned && m.miss_m > 0.01);
        for m in missed {
            text += &format!("  out of reach: {} by {:.0} mm\n", m.name, 1e3 * m.miss_m);
        }
        text += &format!(
            "  bones changed by at most {:.1e} m; pins are met within {:.1e} m\n",
            answer.bone_residue_m,
            answer.pin_residue_m()
        );
        if !answer.still {
            text += "  the body had not come to rest: the same drag again would move it a little further\n";
        }
        if posed.joints.is_empty() {
            text += "  nothing moved\n";
        } else {
            text += &format!("  {} joints moved, the most turned:\n", posed.joints.len());
        }
        let width = posed.joints.iter().take(NAMED).map(|j| j.0.chars().count()).max().unwrap_or(0);
        for (name, turned, moved) in posed.joints.iter().take(NAMED) {
            text += &format!("    {name:<width$}  turned {turned:>6.2}°  moved {moved:>7.1} mm\n");
        }
    }
    for change in &posed.changes {
        text += &format!("  over time: {change}\n");
    }
    for note in &posed.notes {
        text += &format!("  note: {note}\n");
    }
    text + &format!("wrote {to}\n")
}
