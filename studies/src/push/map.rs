//! What a push map holds: per direction what was survived, the whole in short, and what a second engine says of it.

use std::collections::BTreeMap;

use serde::Serialize;

/// The map of a body. Every unit is in its field's name; `docs/PUSH.md` is the guide.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PushMap {
    /// Name of the scene.
    pub scene: String,
    /// Engine that simulated it: `core`, `rapier`, `mujoco`.
    pub engine: String,
    /// One per direction, by angle.
    pub directions: Vec<PushDirection>,
    /// Mean of survived over limit.
    pub mean_ratio: f64,
    /// Least of survived over limit.
    pub min_ratio: f64,
    /// Largest difference between a direction and its mirror image, in percent of their mean; null if no two
    /// directions mirror each other.
    pub symmetry_error_percent: Option<f64>,
    /// Mass of the body, kg.
    pub mass_kg: f64,
    /// Height of the settled centre of mass above the ground, m.
    pub com_height_m: f64,
    /// Natural frequency √(g/h), rad/s.
    pub omega_rad_s: f64,
    /// When the push begins, s.
    pub push_at_s: f64,
    /// How long it lasts, s.
    pub push_s: f64,
    /// Link it acts on.
    pub push_link: String,
    /// Part of itself within which an impulse survived is known, in percent.
    pub tolerance_percent: f64,
    /// What a second engine says of the borders found; null where none was asked.
    pub confirmed: Option<Confirmation>,
    /// Files written, by what they hold; paths relative to the report.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub files: BTreeMap<String, String>,
}

/// One direction of a map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PushDirection {
    /// Where the push goes: 0 forward, 90 left, 180 back, 270 right, degrees.
    pub deg: f64,
    /// Largest impulse survived, N·s.
    pub survived_ns: f64,
    /// Physical limit of an upright body, N·s.
    pub limit_ns: f64,
    /// Survived over limit.
    pub ratio: f64,
    /// Least impulse that failed, N·s.
    pub failed_ns: f64,
    /// How it failed: `fell`, `foot moved`, `not back`, `diverged`.
    pub lost: &'static str,
    /// Distance from the centre of mass to the support's edge, m.
    pub edge_m: f64,
    /// Pushes simulated.
    pub pushes: usize,
}

/// What a second engine says of a map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Confirmation {
    /// The second engine.
    pub engine: String,
    /// How far inside and outside of the border its pushes are, in percent of the impulse.
    pub within_percent: f64,
    /// Directions whose border lies between its two pushes.
    pub confirmed: usize,
    /// One per direction of the map, in its order.
    pub directions: Vec<ConfirmedDirection>,
}

/// One direction in the second engine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ConfirmedDirection {
    /// Where the push goes, degrees.
    pub deg: f64,
    /// The push inside of the border, N·s: less than what the map survives.
    pub inside_ns: f64,
    /// How it ended: `survived`, `fell`, `foot moved`, `not back`, `diverged`.
    pub inside: &'static str,
    /// The push outside of the border, N·s: more than what failed in the map.
    pub outside_ns: f64,
    /// How it ended.
    pub outside: &'static str,
    /// Whether the first was survived and the second was not.
    pub confirmed: bool,
}

impl PushMap {
    /// As JSON, ended by a newline.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("numbers and text") + "\n"
    }
}

/// Largest |a − b| / mean(a, b) over mirrored pairs of evenly spaced directions.
pub(super) fn symmetry_error(directions: &[PushDirection]) -> Option<f64> {
    let n = directions.len();
    (1..n.div_ceil(2))
        .map(|i| {
            let (a, b) = (directions[i].survived_ns, directions[n - i].survived_ns);
            if a == b { 0.0 } else { (a - b).abs() / (0.5 * (a + b)) }
        })
        .max_by(f64::total_cmp)
}
