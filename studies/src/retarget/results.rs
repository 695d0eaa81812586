//! A motion on a character as a folder: clips, contact phases, report, figures.

use std::path::{Path, PathBuf};

use retarget::Retargeted;
use scenes::contact_file;
use takes::results::folder::{Earlier, Folder, Plan};
use takes::results::write::{Undrawn, write_bvh, write_figure, write_glb, write_report};
use takes::retargeting::Session;
use takes::{Progress, WriteError};

use super::{StudiedReport, figures};

/// Metres in one unit of the BVH files written: centimetres.
const UNIT: f64 = 0.01;

/// What a retargeted motion leaves in its folder; [`takes::results::folder::Folder::check`] with it finds out before the motion is mapped. `reads`: files that
/// are never replaced.
pub fn plan(reads: &[PathBuf]) -> Plan<'_> {
    let planned = &["retargeted.bvh", "retargeted.glb", "human.bvh", "contacts.ron", "report.json"];
    Plan { command: "retarget", planned, reads, earlier: Earlier::Remove }
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
        write_glb(&mut folder.top(), "retargeted", &done.clip, &session.body(), &name)
    };
    let drawn = report.clone();
    let figures = if draw { figures::figures(session, &drawn, done) } else { Vec::new() };
    let mut text = |files| {
        report.run.files = files;
        report.to_json()
    };
    write_report(dir, &plan(reads), &mut data, &figures, &mut text, progress)
}

/// Draws all key poses beside the human poses they stand for into `plots/key_poses` of `dir`; the files written.
///
/// # Errors
/// Of the folder and of the figure.
pub fn write_sheet(session: &Session, dir: &Path) -> Result<Vec<PathBuf>, WriteError> {
    write_figure(dir, "retarget --sheet", "key_poses", &figures::key_poses(session))
}
