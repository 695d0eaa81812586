//! What a take leaves: reports, figures, files.
//!
//! | module | holds |
//! |---|---|
//! | [`report`], [`dynamic_report`] | the numbers of a run, those of the motion performed |
//! | [`verdict_report`] | how it was performed, in words and with numbers |
//! | [`mod@write`] | a performed take as a folder |
//! | [`disturbance_report`] | disturbances and falls, as reports give them |
//! | [`gaze_report`] | how far gazes missed |
//! | [`foresight_report`] | what foresight did, and how the body walked |
//! | [`soles_report`] | what the soles were |
//! | [`touch_report`] | what else than the ground was touched |
//! | [`analysis_report`], [`analysis_figures`], [`analysis_write`] | the numbers of an analysis, its figures, its folder |
//! | [`feet`] | how feet moved over the ground |
//! | [`figures`] | which figures a run has |
//! | [`folder`] | the output folder: all files or none, nothing foreign replaced, nothing left by Ctrl-C |

pub mod analysis_figures;
pub mod analysis_report;
pub mod analysis_write;
pub mod disturbance_report;
pub mod dynamic_report;
pub mod feet;
pub mod figures;
pub mod folder;
pub mod foresight_report;
pub mod gaze_report;
pub mod report;
mod root_report;
pub mod soles_report;
pub mod subject_report;
pub mod touch_report;
pub mod verdict_report;
pub mod write;

/// A number as short as it may be: three digits after the point at most.
pub fn number(x: f64) -> String {
    let text = format!("{x:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
