//! Words of tuning: what is searched and what is costed.

use serde::Deserialize;

/// How a scene is tuned; see `docs/TUNE.md`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename = "tune", default)]
pub struct TuneRon {
    /// Names of the parameters searched; by default all.
    pub parameters: Option<Vec<String>>,
    /// Weights of the terms.
    pub weights: Option<WeightsRon>,
    /// Fixed pushes, at most eight.
    pub pushes: Option<Vec<FixedPushRon>>,
    /// When a push begins, s.
    pub push_at_s: Option<f64>,
    /// How long after it the body is watched, s.
    pub after_s: Option<f64>,
    /// Control steps per second of the runs costed; by default the scene's.
    pub rate_hz: Option<f64>,
    /// Engine substeps of the runs costed; by default the scene's.
    pub substeps: Option<usize>,
    /// Whether the scene without a fixed push is a run too; by default if it has a script.
    pub own_run: Option<bool>,
}

/// Weights of the terms of a cost.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename = "weights", default)]
#[expect(missing_docs, reason = "the terms of a cost, see docs/TUNE.md")]
pub struct WeightsRon {
    pub fall: Option<f64>,
    pub tracking: Option<f64>,
    pub effort: Option<f64>,
    pub overshoot: Option<f64>,
    pub smoothness: Option<f64>,
}

/// A push of a cost.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "push")]
pub struct FixedPushRon {
    /// Where it goes: 0 forward, 90 left, 180 back, 270 right, degrees.
    pub deg: f64,
    /// Its impulse, part of the physical limit in that direction.
    pub of_limit: f64,
}
