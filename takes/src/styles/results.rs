//! What a decomposition leaves: a `.style` file and its figures.

use std::path::{Path, PathBuf};

use edits::style::StyleSet;
use formats::bvh::{self, WriteOptions};
use formats::style_file;

use super::figures::{BODY_HEIGHT, activation_plot, contact_sheet, side_by_side};
use crate::results::folder::{Earlier, Folder, Plan};
use crate::results::write::save_figure;
use crate::{Take, WriteError};

/// The name of the file of components of two clips.
pub fn file_name(set: &StyleSet) -> String {
    format!("{}-{}.style", set.names[0], set.names[1])
}

fn planned(set: &StyleSet) -> Vec<String> {
    let plots = ["components", "principal", "activations"];
    let figures = plots.iter().flat_map(|stem| ["svg", "png"].map(|kind| format!("plots/{stem}.{kind}")));
    std::iter::once(file_name(set)).chain(figures).collect()
}

/// Writes a set into a folder, with contact sheets of its components and of the principal ones beside them.
///
/// * `take`: of the first clip
/// * `reads`: files that were read, never replaced
///
/// # Errors
/// Of the folder and the figures.
pub fn write(
    dir: &Path,
    take: &Take,
    set: &StyleSet,
    principal: &StyleSet,
    reads: &[PathBuf],
) -> Result<PathBuf, WriteError> {
    let planned = planned(set);
    let planned: Vec<&str> = planned.iter().map(String::as_str).collect();
    let plan = Plan { command: "style", planned: &planned, reads, earlier: Earlier::Remove };
    let mut folder = Folder::begin(dir, &plan)?;
    folder.add("style", &file_name(set))?;
    folder.write(&file_name(set), &style_file::bytes(set))?;
    let [a, b] = &set.names;
    let title = format!("Independent components of {a} and {b}");
    save_figure(&mut folder.top(), "components", &contact_sheet(take, set, &title, BODY_HEIGHT))?;
    let title = format!("Principal components of {a} and {b}, beside which the independent ones stand");
    save_figure(&mut folder.top(), "principal", &contact_sheet(take, principal, &title, BODY_HEIGHT))?;
    save_figure(&mut folder.top(), "activations", &activation_plot(set))?;
    folder.commit()?;
    Ok(dir.join(file_name(set)))
}

/// Writes takes as clips, numbered from 0, and one film strip of them all; the names of the files.
///
/// # Errors
/// Of the folder and the figure.
pub fn write_rows(
    dir: &Path,
    rows: &[(String, Take)],
    title: &str,
    stem: &str,
    reads: &[PathBuf],
) -> Result<Vec<String>, WriteError> {
    let clips: Vec<String> = (0..rows.len()).map(|i| format!("{stem}-{i}.bvh")).collect();
    let figures = ["svg", "png"].map(|kind| format!("plots/{stem}.{kind}"));
    let planned: Vec<&str> = clips.iter().chain(&figures).map(String::as_str).collect();
    let plan = Plan { command: "style", planned: &planned, reads, earlier: Earlier::Remove };
    let mut folder = Folder::begin(dir, &plan)?;
    for (i, (name, (_, take))) in clips.iter().zip(rows).enumerate() {
        folder.add(&format!("{stem}_{i}_bvh"), name)?;
        let options = WriteOptions { metres_per_unit: take.metres_per_unit(), ..WriteOptions::default() };
        let text = bvh::write(&take.for_files(&take.asked.clip), &options);
        let text = text.map_err(|e| WriteError::file(name, e))?;
        folder.write(name, text.as_bytes())?;
    }
    let shown: Vec<(String, &Take)> = rows.iter().map(|(label, take)| (label.clone(), take)).collect();
    let note = "each row is the same motion; the way over the ground is that of the base";
    if let Some(figure) = side_by_side(&shown, title, note, 10) {
        save_figure(&mut folder.top(), stem, &figure)?;
    }
    folder.commit()?;
    Ok(clips.into_iter().chain(figures).collect())
}
