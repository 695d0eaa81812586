//! A motion on a character as a folder: clips, contact phases, report, figures.

use std::path::{Path, PathBuf};

use formats::glb;
use retarget::Retargeted;
use scenes::contact_file;
use takes::results::folder::{Earlier, Folder, Plan};
use takes::results::write::{PLOTS, Undrawn, write_bvh, write_report};
use takes::retargeting::Session;
use takes::{Progress, WriteError};

use super::{StudiedReport, figures};

/// Metres in one unit of the BVH files written: centimetres.
const UNIT: f64 = 0.01;

fn planned() -> Vec<String> {
    ["retargeted.bvh", "retargeted.glb", "human.bvh", "contacts.ron", "report.json"]
        .map(str::to_owned)
        .to_vec()
}

fn plan<'a>(planned: &'a [String], reads: &'a [PathBuf]) -> Plan<'a> {
    Plan { command: "retarget", planned, reads, earlier: Earlier::Remove }
}

/// Checks, before the motion is mapped, that it can be written into `dir`. `reads`: files that are never replaced.
///
/// # Errors
/// A folder that cannot be written to; a file in it that is not ours, or was read.
pub fn check(dir: &Path, reads: &[PathBuf]) -> Result<(), WriteError> {
    Ok(Folder::check(dir, &plan(&planned(), reads))?)
}

/// Writes everything into `dir`, and names the files in the report.
///
/// # Errors
/// [`WriteError`]. Figures that cannot be drawn are returned.
pub fn write(
    session: &Session,
    done: &Retargeted,
    report: &mut StudiedReport,
    dir: &Path,
    draw: bool,
    reads: &[PathBuf],
    progress: &Progress<'_>,
) -> Result<Vec<Undrawn>, WriteError> {
    let name = session.name();
    let mut data = |folder: &mut Folder| {
        write_bvh(&mut folder.top(), "retargeted", &done.clip, UNIT)?;
        write_bvh(&mut folder.top(), "human", &done.human, UNIT)?;
        if done.contact.is_some() {
            folder.add("contacts_ron", "contacts.ron")?;
            let text = contact_file::text(&session.actor.puppet, &done.phases);
            folder.write("contacts.ron", text.as_bytes())?;
        }
        let path = folder.add("retargeted_glb", "retargeted.glb")?;
        let body = session.body();
        glb::write_file(&path, &done.clip, &body.solids(), &body.colors, &name)
            .map_err(|e| WriteError::file("retargeted.glb", e))
    };
    let drawn = report.clone();
    let figures = if draw { figures::figures(session, &drawn, done) } else { Vec::new() };
    let mut text = |files| {
        report.run.files = files;
        report.to_json()
    };
    write_report(dir, &plan(&planned(), reads), &mut data, &figures, &mut text, progress)
}

/// Draws all key poses beside the human poses they stand for into `plots/key_poses` of `dir`; the files written.
///
/// # Errors
/// Of the folder and of the figure.
pub fn write_sheet(session: &Session, dir: &Path) -> Result<Vec<PathBuf>, WriteError> {
    let names = ["svg", "png"].map(|kind| format!("{PLOTS}/key_poses.{kind}"));
    let plan = Plan { command: "retarget --sheet", planned: &names, reads: &[], earlier: Earlier::Keep };
    let mut folder = Folder::begin(dir, &plan)?;
    let place = folder.top().make(PLOTS)?;
    let saved = figures::key_poses(session).save(&place, "key_poses");
    saved.map_err(|e| WriteError::file(&names[0], e))?;
    for (kind, name) in ["svg", "png"].iter().zip(&names) {
        folder.add(&format!("key_poses_{kind}"), name)?;
    }
    folder.commit()?;
    Ok(names.iter().map(|name| dir.join(name)).collect())
}
