//! Scripts that step with a free root: feet that lift, travel and stand again.
//!
//! In: a checked scene, its script, the tracks it is performed of. Out: [`Steps`]: what stands when ([`Steps::contacts`]), and the motion
//! asked for ([`Steps::pose`]), whose weight [`crate::stepping`] brings over the feet afterwards. `None` of a script that stands still.
//!
//! A script steps in two ways.
//!
//! 1. *Footwork*: `Step` and `Jump` say when a foot leaves the ground and where it lands.
//! 2. *Keys on a leg*: a key on hip, knee or ankle lifts that foot from its start until a key has brought every keyed joint of the leg back to
//!    rest; then it stands where it stood. One that is never brought back stays in the air. Where a key rules, the joints are where it says;
//!    on the way there and back the foot goes from where it stands to where the key has it, along the key's curve, up before it travels.
//!
//! The root goes with the feet: by the mean of their ways and turns, where no key of the script rules it. All legs that end in soles take
//! part, whether `planted` names them or not; limbs that do not (hands) stay planted.
//!
//! Units: m, s, rad; world frame, y up.

use bodies::Character;
use dynamics::conditions::RootMode;
use motion::ik::{IkError, solve_two_bone_oriented};
use motion::plant::{Knee, Plant, plant};
use motion::rotation::{exp, log};
use motion::{
    Clip, Contact, ContactPlan, Curve, Dof, Kinematics, Limb, LimbKind, Quat, Skeleton, Track, Tracks,
    Transform, Vec3,
};
use scenes::scene::footwork::Footwork;
use scenes::scene::{Scene, ScriptSpec};

use crate::keyed::{keyed, share};

/// A script that steps. See the module header.
pub(crate) struct Steps {
    skeleton: std::sync::Arc<Skeleton>,
    footwork: Footwork,
    /// Its feet at rest, and planted limbs that are none.
    plants: Vec<Plant>,
    /// Position of the root at rest, m.
    home: Vec3,
    /// Moments between which each plant is in the air because of keys, s.
    lifted: Vec<Vec<(f64, f64)>>,
}

impl Steps {
    /// How a script of a free body on level ground steps; `None` where it does not. `plants`: what the script plants; `rate_hz`: its frames.
    pub(crate) fn of(
        scene: &Scene,
        script: &ScriptSpec,
        tracks: &Tracks,
        plants: &[Plant],
        rate_hz: f64,
    ) -> Option<Self> {
        let (character, c) = (&scene.character, &scene.conditions);
        let level = c.physics.ground.is_some_and(|g| g.stays_level()) && c.tilts.is_empty();
        if c.physics.root != RootMode::Free || !level || !plants.iter().any(|p| is_leg(&p.limb)) {
            return None;
        }
        let skeleton = character.skeleton.clone();
        let mut plants = plants.to_vec();
        // footwork counts the plants of the script: others come behind them
        for (limb, _) in character.leg_soles() {
            if plants.iter().all(|p| p.limb != *limb) {
                plants.push(Plant { knee: Knee::Follows, ..Plant::here(&skeleton, &character.rest, limb) });
            }
        }
        let lifted: Vec<Vec<(f64, f64)>> =
            plants.iter().map(|p| lifts(tracks, &p.limb, character, rate_hz)).collect();
        if script.footwork.is_still() && lifted.iter().all(Vec::is_empty) {
            return None;
        }
        let home = skeleton.position(&character.rest, 0);
        Some(Self { skeleton, footwork: script.footwork.clone(), plants, home, lifted })
    }

    /// The limbs that take part.
    pub(crate) fn plants(&self) -> &[Plant] {
        &self.plants
    }

    /// What stands when and where, until `end_s` (s).
    pub(crate) fn contacts(&self, end_s: f64) -> ContactPlan {
        contacts(&self.footwork, &self.plants, &self.lifted, end_s)
    }

    /// Poses the frames of `clip`, sampled of `tracks` at `moments` (s); returns how far the root of each is below what was asked, m. `before`: of a clip
    /// that was posed and then changed, what was asked of it before.
    ///
    /// # Errors
    /// Legs that two-bone IK cannot solve.
    pub(crate) fn pose(
        &self,
        clip: &mut Clip,
        before: Option<&Clip>,
        tracks: &Tracks,
        moments: &[f64],
    ) -> Result<Vec<f64>, IkError> {
        let skeleton = &*self.skeleton;
        let rules = [0, 2].map(|axis| keyed(tracks, Dof::Coordinate(0, axis)));
        let legs: Vec<Vec<Track>> = self.plants.iter().map(|p| keys(tracks, &p.limb)).collect();
        let mut lowered_m = vec![0.0; clip.frames()];
        for (f, t_s) in moments.iter().enumerate() {
            let q = clip.pose_mut(f);
            let (plants, height) = self.footwork.at(*t_s, &self.plants);
            let mut asked = before.map_or(skeleton.position(q, 0), |clip| skeleton.position(clip.pose(f), 0));
            let (by, turn) = self.gone(&plants, *t_s);
            asked.y += height;
            if before.is_none() {
                let free = rules.each_ref().map(|k| 1.0 - k.as_ref().map_or(0.0, |k| share(k, *t_s)));
                asked += Vec3::new(free[0] * by.x, 0.0, free[1] * by.z);
                skeleton.set_position(q, 0, &asked);
                let heading = Quat::from_axis_angle(&Vec3::y_axis(), turn) * skeleton.rotation(q, 0);
                skeleton.set_rotation(q, 0, &heading);
            }
            let raised: Vec<f64> =
                legs.iter().map(|of| of.iter().map(|k| share(k, *t_s)).fold(0.0, f64::max)).collect();
            let standing: Vec<Plant> =
                plants.iter().zip(&raised).filter(|(_, s)| **s == 0.0).map(|(p, _)| p.clone()).collect();
            plant(skeleton, q, &standing)?;
            lowered_m[f] = asked.y - skeleton.position(q, 0).y;
            if before.is_some() {
                continue;
            }
            for (p, s) in plants.iter().zip(&raised).filter(|(_, s)| **s > 0.0) {
                let keyed = Kinematics::new(skeleton, q).world[p.limb.end];
                let at = lifted(&p.world_from_end, &keyed, *s);
                solve_two_bone_oriented(skeleton, q, &p.limb, &at)?;
            }
        }
        Ok(lowered_m)
    }

    /// How far the feet have gone at `t_s` from where they stand at rest, m, and turned about the vertical, rad: means over the legs.
    fn gone(&self, plants: &[Plant], t_s: f64) -> (Vec3, f64) {
        let legs: Vec<usize> = (0..plants.len()).filter(|i| is_leg(&plants[*i].limb)).collect();
        let n = legs.len().max(1) as f64;
        let turn = legs.iter().map(|i| self.footwork.turn(*i, t_s)).sum::<f64>() / n;
        let mean =
            |of: &[Plant]| legs.iter().map(|i| of[*i].world_from_end.translation.vector).sum::<Vec3>() / n;
        let (rest, now) = (mean(&self.plants), mean(plants));
        // the root keeps its place over the middle of the feet as they turn
        let over = self.home - rest;
        (now - rest + exp(&(Vec3::y() * turn)) * over - over, turn)
    }
}

/// Where a foot is that keys rule by `s` (0 to 1): it leaves the ground before it travels, and stands over its place before it is set down.
fn lifted(stands: &Transform, keyed: &Transform, s: f64) -> Transform {
    let travels = Curve::EaseInOut.at(((s - GROUND) / (1.0 - GROUND)).clamp(0.0, 1.0));
    let (from, to) = (stands.translation.vector, keyed.translation.vector);
    let mut at = from + (to - from) * travels;
    at.y = from.y + (to.y - from.y) * s + CLEAR_M * (std::f64::consts::PI * s.clamp(0.0, 1.0)).sin().powi(2);
    let turn = exp(&(log(&(keyed.rotation * stands.rotation.inverse())) * travels));
    Transform::from_parts(at.into(), turn * stands.rotation)
}

/// Share of a key at which a foot that it lifts begins to travel.
const GROUND: f64 = 0.08;
/// What a foot is lifted higher by, on the way to its key and back, m: it does not drag over the ground.
const CLEAR_M: f64 = 0.03;

/// Whether it carries a body.
fn is_leg(limb: &Limb) -> bool {
    limb.kind == LimbKind::Leg
}

/// How much keys rule the joints of a limb, joint by joint.
fn keys(tracks: &Tracks, limb: &Limb) -> Vec<Track> {
    let of_limb = |dof: &Dof| match dof {
        Dof::Axis(link) | Dof::Rotation(link) => limb.links().contains(link),
        _ => false,
    };
    if !is_leg(limb) {
        return Vec::new();
    }
    tracks.tracks.iter().filter(|t| of_limb(&t.dof)).filter_map(|t| keyed(tracks, t.dof)).collect()
}

/// Spans in which keys have a leg in the air, s.
fn lifts(tracks: &Tracks, limb: &Limb, character: &Character, rate_hz: f64) -> Vec<(f64, f64)> {
    let keys = keys(tracks, limb);
    if keys.is_empty() || !character.leg_soles().iter().any(|(leg, _)| *leg == limb) {
        return Vec::new();
    }
    let frames = (tracks.duration_s * rate_hz).ceil() as usize + 1;
    let up = |f: usize| keys.iter().any(|k| share(k, f as f64 / rate_hz) > 0.0);
    let time = |f: usize| f as f64 / rate_hz;
    motion::runs(0..frames, up)
        .into_iter()
        .map(|run| {
            let to_s = if run.end < frames { time(run.end) } else { f64::INFINITY };
            (time(run.start.saturating_sub(1)), to_s)
        })
        .collect()
}

/// What stands when: `plants`, but while they step, jump or are `lifted` (spans of each plant, s), until `end_s`.
pub(crate) fn contacts(
    work: &Footwork,
    plants: &[Plant],
    lifted: &[Vec<(f64, f64)>],
    end_s: f64,
) -> ContactPlan {
    let mut all = Vec::new();
    for (i, plant) in plants.iter().enumerate() {
        let steps = work.steps.iter().filter(|s| s.plant == i).map(|s| (s.start_s, s.start_s + s.duration_s));
        let jumps = work.jumps.iter().map(|j| (j.start_s, j.start_s + j.duration_s));
        let keyed = lifted.get(i).into_iter().flatten().copied();
        let mut flights: Vec<(f64, f64)> = steps.chain(jumps).chain(keyed).filter(|f| f.0 < end_s).collect();
        flights.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut from_s = 0.0;
        let mut stand = |from_s: f64, to_s: f64| {
            if from_s <= to_s {
                let place = work.at(0.5 * (from_s + to_s), plants).0[i].world_from_end;
                let point = plant.limb.name.clone();
                all.push(Contact { point, from_s, to_s, world_from_point: Some(place) });
            }
        };
        for (leaves_s, lands_s) in flights {
            stand(from_s, leaves_s);
            from_s = lands_s.max(from_s);
        }
        stand(from_s, end_s);
    }
    // times come from a checked scene, sorted and apart
    ContactPlan::new(all).unwrap_or_default()
}
