//! How feet moved over the ground, level or tilted.
//!
//! In: a clip of a take's body. Out: slip, skating, penetration and float, as [`motion::metrics::feet`] measures them; those of a
//! run are measured by [`dynamics::feet`]. On tilted ground the clip is measured as it looks where the ground is level.

use dynamics::RootMode;
use dynamics::analysis::Contact;
use dynamics::analysis::ground::height_under;
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

/// How the feet of a motion of a take's body move over its ground as it begins; `None` without ground.
pub(crate) fn feet(take: &Take, clip: &Clip) -> Option<FeetMetrics> {
    let c = &take.body.character;
    let sites: Vec<_> = c.contacts.iter().map(|&i| &c.skeleton.sites()[i]).collect();
    let ground = walked_on(take)?;
    if ground.up == Vec3::y() {
        return Some(metrics::feet(clip, &sites, ground.height_m));
    }
    Some(metrics::feet(&levelled(clip, |_| ground), &sites, ground.height_m))
}

/// The ground under the feet of a motion. That of a take is made to be stood on; a captured clip whose root is pinned touches
/// none, and its feet are measured over the ground on which it was captured, as an analysis finds it.
fn walked_on(take: &Take) -> Option<Floor> {
    let ground = take.conditions.physics.ground?;
    if !take.is_captured() || take.conditions.physics.root != RootMode::Pinned {
        return Some(ground);
    }
    let height = height_under(&take.body.character, &take.asked.clip, &Contact::default());
    Some(height.map_or(ground, |height_m| Floor { height_m, ..ground }))
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
