//! A cross-check as a folder: table, page, traces of both engines, figures.

use std::path::{Path, PathBuf};

use formats::trace_npz;
use takes::WriteError;
use takes::results::folder::{Earlier, Folder, Plan};
use takes::results::write::PLOTS;

use crate::{CrossCheck, report};

fn plan<'a>(planned: &'a [String], reads: &'a [PathBuf]) -> Plan<'a> {
    Plan { command: "crosscheck", planned, reads, earlier: Earlier::Remove }
}

fn planned() -> Vec<String> {
    ["crosscheck.json", "crosscheck.txt", "crosscheck.html"].map(str::to_owned).to_vec()
}

/// Checks, before the engines run, that a cross-check can be written into `dir`. `reads`: files that are never replaced.
///
/// # Errors
/// A folder that cannot be written to; a file in it that is not ours, or was read.
pub fn check(dir: &Path, reads: &[PathBuf]) -> Result<(), WriteError> {
    Ok(Folder::check(dir, &plan(&planned(), reads))?)
}

/// Writes everything into `dir`: the table and the traces first, then page and figures.
///
/// # Errors
/// [`WriteError`].
pub fn write(cross: &CrossCheck, dir: &Path, reads: &[PathBuf]) -> Result<(), WriteError> {
    let planned = planned();
    let mut folder = Folder::begin(dir, &plan(&planned, reads))?;
    for (what, name, text) in [
        ("crosscheck_json", "crosscheck.json", report::json(cross)),
        ("crosscheck_txt", "crosscheck.txt", report::text(cross)),
    ] {
        folder.add(what, name)?;
        folder.write(name, text.as_bytes())?;
    }
    if let Some(scene) = &cross.scene {
        folder.top().make("mujoco")?;
        for (what, name, trace) in
            [("trace_npz", "trace.npz", &scene.ours), ("mujoco_npz", "mujoco/trace.npz", &scene.theirs)]
        {
            let path = folder.add(what, name)?;
            trace_npz::save(trace, &path).map_err(|e| WriteError::file(name, e))?;
        }
    }
    folder.commit()?;
    let figures = report::figures(cross);
    if !figures.is_empty() {
        let plots = folder.top().make(PLOTS)?;
        for (stem, figure) in figures {
            figure.save(&plots, stem).map_err(|e| WriteError::file(stem, e))?;
            for kind in ["svg", "png"] {
                folder.add(&format!("{stem}_{kind}"), &format!("{PLOTS}/{stem}.{kind}"))?;
            }
        }
    }
    let page = report::html(cross).map_err(|e| WriteError::file("crosscheck.html", e))?;
    folder.add("crosscheck_html", "crosscheck.html")?;
    folder.write("crosscheck.html", page.as_bytes())?;
    Ok(folder.commit()?)
}
