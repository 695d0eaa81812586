//! Studies of a retargeting: its models side by side, its key poses.
//!
//! | module | holds |
//! |---|---|
//! | [`compare`] | the five models on one motion and on the key poses |
//! | [`figures`], [`results`] | which figures a run has; its folder |
//! | [`study`] | how good a set of key poses is, and what would make it better |

pub mod compare;
pub mod figures;
pub mod results;
pub mod study;

use serde::Serialize;
use takes::retargeting::RetargetReport;

use compare::ModelRow;
use study::Study;

/// The report of a retargeting with the studies that were asked for.
#[derive(Clone, Debug, Serialize)]
pub struct StudiedReport {
    /// The numbers of the run.
    #[serde(flatten)]
    pub run: RetargetReport,
    /// The five models side by side, and the shared GPLVM with latent points searched (`search`), if that was asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub models: Vec<ModelRow>,
    /// How good the key poses are, if that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub study: Option<Study>,
}

impl StudiedReport {
    /// As indented JSON with a final newline.
    pub fn to_json(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).expect("a report has no maps with odd keys");
        text.push('\n');
        text
    }
}
