//! Reactive properties of a scene: checked, and what came of them.
//!
//! In: `reactive: […]` of a scene file, a trace. Out: properties ready to be handed to a pass; how far a gaze missed.
//! Balance has its own words (`physics`, patches).

use controllers::{Gaze, GazeError, GazeSettings};
use dynamics::{Character, JointClass, Model, State, Trace};
use motion::Vec3;
use serde::Serialize;

use crate::SceneError;
use crate::scene::Check;
use crate::schema::ReactiveRon;

impl Check<'_> {
    /// Gazes.
    pub(crate) fn gazes(&self, ron: &[ReactiveRon]) -> Result<Vec<Gaze>, SceneError> {
        let one = |(i, r): (usize, &ReactiveRon)| {
            let ReactiveRon::Gaze { at_m, from_s, to_s, blend_s, eyes, joints } = r;
            let at = format!("reactive[{i}]");
            for x in [at_m.0, at_m.1, at_m.2] {
                self.within(&format!("{at}.at_m"), x, -1e4, 1e4, "m")?;
            }
            let from_s = self.within(&format!("{at}.from_s"), *from_s, 0.0, 86_400.0, "s")?;
            let to_s = match to_s {
                Some(to_s) if *to_s > from_s => *to_s,
                Some(to_s) => {
                    let message = format!("to_s is {to_s} s; allowed: later than from_s, {from_s} s");
                    return Err(self.source.error(&format!("{at}.to_s"), message));
                }
                None => f64::INFINITY,
            };
            let blend_s = self.within(&format!("{at}.blend_s"), *blend_s, 0.0, 60.0, "s")?;
            let target = Vec3::new(at_m.0, at_m.1, at_m.2);
            let settings = GazeSettings { target, from_s, to_s, blend_s };
            let links = match joints {
                None => neck(self.character, eyes),
                Some(names) => {
                    let mut links = Vec::new();
                    for (k, name) in names.iter().enumerate() {
                        links.push(self.link(&format!("{at}.joints[{k}]"), name, " in a Gaze")?);
                    }
                    links.sort_unstable();
                    links.dedup();
                    links
                }
            };
            let model = Model::new(self.character, Vec3::zeros());
            Gaze::new(self.character, &model, eyes, &links, settings).map_err(|e| {
                let field = match &e {
                    GazeError::Eyes { .. } => "eyes",
                    GazeError::Empty | GazeError::NotABall(_) | GazeError::Apart { .. } => "joints",
                };
                self.source.error(&format!("{at}.{field}"), e.to_string())
            })
        };
        ron.iter().enumerate().map(one).collect()
    }
}

/// Joints of the neck that carry a site, from the trunk outward; empty if there is no such site.
fn neck(character: &Character, eyes: &str) -> Vec<usize> {
    let skeleton = &character.skeleton;
    let up = skeleton.site(eyes).into_iter().flat_map(|s| skeleton.ancestors(s.link));
    let mut links: Vec<usize> = up.filter(|&l| character.classes[l] == JointClass::Neck).collect();
    links.reverse();
    links
}

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
}

impl GazeReport {
    /// Measures the gazes of a scene in a trace.
    pub fn of(gazes: &[Gaze], trace: &Trace) -> Vec<Self> {
        let model = Model::new(&trace.character, trace.gravity);
        let mut state = State::new(&model);
        let mut one = |gaze: &Gaze| {
            let s = gaze.settings();
            let (mut sum, mut count, mut peak) = (0.0, 0.0, None);
            for row in 0..trace.rows() {
                let t = row as f64 / trace.rate_hz;
                if gaze.weight(t) < 1.0 {
                    continue;
                }
                state.update_pose(&model, trace.pose(row));
                let error = gaze.sight().error(&model, &state, &s.target).to_degrees();
                sum += error * error;
                count += 1.0;
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
            }
        };
        gazes.iter().map(&mut one).collect()
    }
}
