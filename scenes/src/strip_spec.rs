//! How film strips of a scene are drawn.

use serde::Deserialize;

/// How film strips are drawn.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "strip", default)]
pub struct StripSpec {
    /// Number of figures in a row.
    pub figures: usize,
    /// First moment shown, s.
    pub from_s: f64,
    /// Last moment shown, s; by default the end.
    pub to_s: Option<f64>,
    /// From where it is seen, degrees: 0 the front, 90 the left; by default between both (38).
    pub yaw_deg: Option<f64>,
}

impl Default for StripSpec {
    fn default() -> Self {
        Self { figures: 9, from_s: 0.0, to_s: None, yaw_deg: None }
    }
}
