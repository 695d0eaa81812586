//! A cross-check as a folder: table, page, traces of all engines, figures.

use std::path::{Path, PathBuf};

use formats::trace_npz;
use takes::results::figures::Draw;
use takes::results::folder::{Earlier, Folder, Plan};
use takes::results::write::{Undrawn, draw};
use takes::{Progress, WriteError};

use crate::{CrossCheck, report};

/// What a cross-check leaves in its folder; [`Folder::check`] with it finds out before the engines run. `reads`: files that are never
/// replaced.
pub fn plan(reads: &[PathBuf]) -> Plan<'_> {
    let planned = &["crosscheck.json", "crosscheck.txt", "crosscheck.html"];
    Plan { command: "crosscheck", planned, reads, earlier: Earlier::Remove }
}

/// Writes everything into `dir`: the table and the traces first, then page and figures.
///
/// # Errors
/// [`WriteError`]. Figures that cannot be drawn are returned.
pub fn write(
    cross: &CrossCheck,
    dir: &Path,
    reads: &[PathBuf],
    progress: &Progress<'_>,
) -> Result<Vec<Undrawn>, WriteError> {
    let mut folder = Folder::begin(dir, &plan(reads))?;
    for (what, name, text) in [
        ("crosscheck_json", "crosscheck.json", report::json(cross)),
        ("crosscheck_txt", "crosscheck.txt", report::text(cross)),
    ] {
        folder.add(what, name)?;
        folder.write(name, text.as_bytes())?;
    }
    if let Some(scene) = &cross.scene {
        folder.top().make("mujoco")?;
        folder.top().make("core")?;
        for (what, name, trace) in [
            ("trace_npz", "trace.npz", &scene.ours),
            ("mujoco_npz", "mujoco/trace.npz", &scene.theirs),
            ("core_npz", "core/trace.npz", &scene.core),
        ] {
            let path = folder.add(what, name)?;
            trace_npz::save(trace, &path).map_err(|e| WriteError::file(name, e))?;
        }
    }
    folder.commit()?;
    let drawn = report::figures(cross);
    let figures: Vec<Draw<'_>> = (drawn.iter())
        .map(|(stem, figure)| -> Draw<'_> { (stem, Box::new(|| Ok(figure.clone()))) })
        .collect();
    let undrawn = draw(&mut folder.top(), &figures, progress)?;
    let page = report::html(cross).map_err(|e| WriteError::file("crosscheck.html", e))?;
    folder.add("crosscheck_html", "crosscheck.html")?;
    folder.write("crosscheck.html", page.as_bytes())?;
    folder.commit()?;
    Ok(undrawn)
}
