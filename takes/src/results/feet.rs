//! How feet moved over the ground, level or tilted.
//!
//! In: a clip of a take's body, and where the ground turned its trace. Out: slip, skating, penetration and float, as
//! [`motion::metrics::feet`] measures them. On tilted ground the clip is measured as it looks where the ground is level.

use dynamics::Trace;
use motion::metrics::{self, FeetMetrics};
use motion::skeleton::quat_at;
use motion::{Clip, Floor, Joint, Vec3};
use nalgebra::Point3;
use serde::Serialize;

use crate::Take;
use crate::script::onto;

/// How feet moved over the ground, see [`metrics::FeetMetrics`].
#[derive(Clone, Copy, Debug, Serialize)]
#[expect(missing_docs, reason = "documented at FeetMetrics")]
pub struct FeetReport {
    pub slip_mm_max: f64,
    pub skate_mm_s: f64,
    pub penetration_mm_max: f64,
    pub float_mm_max: f64,
}

impl From<FeetMetrics> for FeetReport {
    fn from(m: FeetMetrics) -> Self {
        Self {
            slip_mm_max: m.slip_mm_max,
            skate_mm_s: m.skate_mm_s,
            penetration_mm_max: m.penetration_mm_max,
            float_mm_max: m.float_mm_max,
        }
    }
}

/// How the feet moved over the ground: as it begins, or as a trace of the clip's rate has it.
pub(crate) fn feet(take: &Take, clip: &Clip, trace: Option<&Trace>) -> FeetMetrics {
    let c = &take.body.character;
    let sites: Vec<_> = c.contacts.iter().map(|&i| &c.skeleton.sites()[i]).collect();
    let Some(ground) = take.conditions.physics.ground else { return metrics::feet(clip, &sites, 0.0) };
    let up = |frame: usize| trace.map_or(ground.up, |t| t.ground_up(frame));
    if ground.up == Vec3::y() && !trace.is_some_and(Trace::ground_turns) {
        return metrics::feet(clip, &sites, ground.height_m);
    }
    let levelled = levelled(clip, |frame| Floor { up: up(frame), ..ground });
    metrics::feet(&levelled, &sites, ground.height_m)
}

/// A clip as it looks where tilted ground, given for every frame, is level.
pub(crate) fn levelled(clip: &Clip, ground: impl Fn(usize) -> Floor) -> Clip {
    let skeleton = &clip.skeleton;
    let mut out = clip.clone();
    if !matches!(skeleton.links()[0].joint, Joint::Free) {
        return out;
    }
    let at = skeleton.q_at(0) + 3;
    for f in 0..out.frames() {
        let back = onto(&ground(f)).inverse();
        let q = out.pose_mut(f);
        let p = back * Point3::from(skeleton.position(q, 0));
        skeleton.set_position(q, 0, &p.coords);
        let r = back.rotation * quat_at(q, at);
        q[at..at + 4].copy_from_slice(&[r.w, r.i, r.j, r.k]);
    }
    out
}
