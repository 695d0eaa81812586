//! How far the gazes of a run missed their points, as reports give it.
//!
//! In: gazes, a trace. Out: a [`GazeReport`] for each: angles in degrees, times in s.

use controllers::Gaze;
use dynamics::{Model, State, Trace};
use serde::Serialize;

/// How far a gaze missed its point.
#[derive(Clone, Debug, Serialize)]
pub struct GazeReport {
    /// The point, world, m.
    pub at_m: [f64; 3],
    /// When the gaze turned there, s.
    pub from_s: f64,
    /// When it turned away, s; null for never.
    pub to_s: Option<f64>,
    /// Angle between line of sight and point while it was turned there: root mean square, degrees; null if it
    /// never was.
    pub rms_deg: Option<f64>,
    /// Largest, degrees.
    pub peak_deg: Option<f64>,
    /// When, s.
    pub peak_at_s: Option<f64>,
    /// Least, degrees: of a point out of reach, how far it stays out.
    pub least_deg: Option<f64>,
}

impl GazeReport {
    /// Measures the gazes of a scene in a trace.
    pub fn of(gazes: &[Gaze], trace: &Trace) -> Vec<Self> {
        let model = Model::new(&trace.character, trace.gravity);
        let mut state = State::new(&model);
        let mut one = |gaze: &Gaze| {
            let s = gaze.settings();
            let (mut sum, mut count, mut peak, mut least) = (0.0, 0.0, None, f64::INFINITY);
            for row in 0..trace.rows() {
                let t = row as f64 / trace.rate_hz;
                if gaze.weight(t) < 1.0 {
                    continue;
                }
                state.update_pose(&model, trace.pose(row));
                let error = gaze.sight().error(&model, &state, &s.target).to_degrees();
                sum += error * error;
                count += 1.0;
                least = least.min(error);
                if peak.is_none_or(|(worst, _)| error > worst) {
                    peak = Some((error, t));
                }
            }
            Self {
                at_m: s.target.into(),
                from_s: s.from_s,
                to_s: s.to_s.is_finite().then_some(s.to_s),
                rms_deg: peak.map(|_| f64::sqrt(sum / count)),
                peak_deg: peak.map(|p| p.0),
                peak_at_s: peak.map(|p| p.1),
                least_deg: peak.map(|_| least),
            }
        };
        gazes.iter().map(&mut one).collect()
    }
}
