//! A motion on a character as a folder: clips, contact phases, report, figures.

use std::path::{Path, PathBuf};

use retarget::Retargeted;
use scenes::contact_file;
use takes::results::folder::{Earlier, Folder, Plan, was_read};
use takes::results::write::{CONTACTS, Undrawn, write_bvh, write_figure, write_glb, write_report};
use takes::retargeting::Session;
use takes::{Progress, WriteError};

use super::{StudiedReport, figures};

/// Metres in one unit of the BVH files written: centimetres.
const UNIT: f64 = 0.01;

/// What a retargeted motion leaves in the folder `dir`; [`takes::results::folder::Folder::check`] with it finds out before the
/// motion is mapped. `reads`: files that are never replaced. Contact phases that were read from the folder itself are not written
/// again: the file is a person's, with comments.
pub fn plan<'a>(dir: &Path, reads: &'a [PathBuf]) -> Plan<'a> {
    const FILES: [&str; 5] = ["retargeted.bvh", "retargeted.glb", "human.bvh", "report.json", CONTACTS];
    let planned = if has_contacts(dir, reads) { &FILES[..4] } else { &FILES[..] };
    Plan { command: "retarget", planned, reads, earlier: Earlier::Remove }
}

/// Whether the contact phases were read from the folder they would be written into.
fn has_contacts(dir: &Path, reads: &[PathBuf]) -> bool {
    was_read(&dir.join(CONTACTS), reads)
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
        if done.contact.is_some() && !has_contacts(dir, reads) {
            folder.add("contacts_ron", CONTACTS)?;
            let text = contact_file::text(&session.actor.puppet, &done.phases);
            folder.write(CONTACTS, text.as_bytes())?;
        }
        write_glb(&mut folder.top(), "retargeted", &done.clip, &session.body(), &name)
    };
    let drawn = report.clone();
    let figures = if draw { figures::figures(session, &drawn, done) } else { Vec::new() };
    let mut text = |files| {
        report.run.files = files;
        report.to_json()
    };
    write_report(dir, &plan(dir, reads), &mut data, &figures, &mut text, progress)
}

/// Draws all key poses beside the human poses they stand for into `plots/key_poses` of `dir`; the files written.
///
/// # Errors
/// Of the folder and of the figure.
pub fn write_sheet(session: &Session, dir: &Path) -> Result<Vec<PathBuf>, WriteError> {
    write_figure(dir, "retarget --sheet", "key_poses", &figures::key_poses(session))
}
