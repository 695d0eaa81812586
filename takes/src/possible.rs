//! A sampled script made possible: joints within their limits, feet where they are planted, the body over its feet.
//!
//! Under a pinned root the root goes where the script says, and the legs follow. So they do where a free body steps (`takes::steps`;
//! `takes::stepping` brings its weight over them). A body that stands on its feet is balanced:
//!
//! 1. The pelvis shifts so that the centre of mass stays where it is at rest.
//! 2. A key of the root's horizontal position ([`Dof::Coordinate`] x, z) goes before that: it is the pelvis's position relative
//!    to rest. From one to the other the pelvis goes along the curve of the key; a key at rest gives the coordinate back to the
//!    balance.
//! 3. Where the motion would then ask for a centre of pressure outside the soles, the root gives way
//!    (`controllers::admissible`).
//!
//! In: a sampled script, its tracks. Out: a [`Finished`]. Units: m, s; world frame, ground plane (x, z).

use controllers::admissible::{admit, outside};
use controllers::posture::settle;
use controllers::support::Foot;
use dynamics::conditions::RootMode;
use dynamics::{Model, State};
use motion::ik::IkError;
use motion::plant::{Plant, plant};
use motion::support::{Vec2, ground};
use motion::{Clip, Derivatives, Dof, TimeMap, Tracks, Transform, Vec3};
use nalgebra::Point3;
use scenes::SceneError;
use scenes::scene::{Scene, ScriptSpec};

use crate::keyed::{keyed, share};
use crate::limited::{Limited, within_limits};
use crate::steps::Steps;

/// The centre of pressure asked for stays this far inside the soles, m: limbs at natural tension swing past what is asked, and
/// the balance needs room on both sides. With 3 cm a deep bend over its toes falls.
const MARGIN_M: f64 = 0.05;
/// Changes of the pressure faster than this are those of curves, which muscles round off, s.
const SUDDEN_S: f64 = 0.3;
/// A root moved by less counts as where it was, m.
const MOVED_M: f64 = 2e-3;
/// A centre of pressure left outside the soles by less is within rounding of the root's way, m.
const LEFT_M: f64 = 5e-3;

/// A sampled motion that a body may try. See the module header.
pub(crate) struct Finished {
    pub(crate) clip: Clip,
    /// Fraction of the frames that joint limits changed.
    pub(crate) clamped: f64,
    /// Joints that limits changed.
    pub(crate) limited: Vec<Limited>,
    /// How far the root of each frame is below what was asked, m.
    pub(crate) lowered_m: Vec<f64>,
    /// How the root gave way.
    pub(crate) shifted: Option<Shifted>,
}

/// A root that gave way so that feet can carry the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shifted {
    /// The furthest, m.
    pub by_m: f64,
    /// First moment, s.
    pub from_s: f64,
    /// Last moment, s.
    pub to_s: f64,
    /// From when on, and by how much at most, the centre of pressure is outside the soles all the same: s, m.
    pub outside: Option<(f64, f64)>,
}

impl std::fmt::Display for Shifted {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { by_m, from_s, to_s, outside } = self;
        write!(f, "pelvis moved by up to {:.0} mm, {from_s:.1}–{to_s:.1} s", 1e3 * by_m)?;
        match outside {
            None => write!(f, ": as asked, the soles could not carry it"),
            Some((at_s, by_m)) => {
                let by = 1e3 * by_m;
                write!(
                    f,
                    "; from {at_s:.1} s it asks for a centre of pressure up to {by:.0} mm outside the soles all the same"
                )
            }
        }
    }
}

/// Makes the clips of a script possible.
pub(crate) struct Sampler<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) script: &'a ScriptSpec,
    pub(crate) plants: &'a [Plant],
    /// From level ground to the scene's.
    pub(crate) onto: Transform,
    /// How it steps with a free root; `None` where it stands.
    pub(crate) steps: Option<&'a Steps>,
}

impl Sampler<'_> {
    /// Keeps joint limits, plants the feet, balances the body. `tracks` are those `clip` was sampled of, `times` leads from
    /// their time to the clip's.
    pub(crate) fn finish(
        &self,
        clip: Clip,
        tracks: &Tracks,
        times: &TimeMap,
    ) -> Result<Finished, SceneError> {
        let done = self.possible(clip, None, tracks, times);
        done.map_err(|e| self.scene.source.error("planted", e.to_string()))
    }

    /// The same of a clip that was finished, and then changed without moving what stands: `asked` is the clip as it was before, whose
    /// roots say what was asked of them.
    pub(crate) fn again(
        &self,
        clip: Clip,
        asked: &Clip,
        tracks: &Tracks,
        times: &TimeMap,
    ) -> Result<Finished, IkError> {
        self.possible(clip, Some(asked), tracks, times)
    }

    fn possible(
        &self,
        clip: Clip,
        before: Option<&Clip>,
        tracks: &Tracks,
        times: &TimeMap,
    ) -> Result<Finished, IkError> {
        let (frames, rate_hz) = (clip.frames(), clip.rate_hz);
        let (clip, clamped, limited) = within_limits(clip);
        let mut finished = Finished { clip, clamped, limited, lowered_m: vec![0.0; frames], shifted: None };
        if self.plants.is_empty() {
            return Ok(finished);
        }
        let script_s = (!times.is_identity()).then(|| times.inverse());
        let moments: Vec<f64> = (0..frames)
            .map(|f| f as f64 / rate_hz)
            .map(|t_s| script_s.as_ref().map_or(t_s, |map| map.at(t_s)))
            .collect();
        if self.scene.conditions.physics.root == RootMode::Pinned {
            self.follow(&mut finished, before, &moments)?;
        } else if let Some(steps) = self.steps {
            finished.lowered_m = steps.pose(&mut finished.clip, before, tracks, &moments)?;
        } else {
            self.balance(&mut finished, before, tracks, &moments)?;
        }
        Ok(finished)
    }

    /// Legs follow a root that goes where the script says.
    fn follow(&self, finished: &mut Finished, before: Option<&Clip>, moments: &[f64]) -> Result<(), IkError> {
        let skeleton = &self.scene.character.skeleton;
        for (f, t_s) in moments.iter().enumerate() {
            let q = finished.clip.pose_mut(f);
            let (plants, height) = self.script.footwork.at(*t_s, self.plants);
            let from = before.map_or(skeleton.position(q, 0), |clip| skeleton.position(clip.pose(f), 0));
            let asked = from + Vec3::y() * height;
            // what was finished is in the air already
            if height > 0.0 && before.is_none() {
                skeleton.set_position(q, 0, &asked);
            }
            plant(skeleton, q, &plants)?;
            finished.lowered_m[f] = asked.y - skeleton.position(q, 0).y;
        }
        Ok(())
    }

    /// The body over its feet.
    fn balance(
        &self,
        finished: &mut Finished,
        before: Option<&Clip>,
        tracks: &Tracks,
        moments: &[f64],
    ) -> Result<(), IkError> {
        let character = &self.scene.character;
        let skeleton = &character.skeleton;
        let physics = &self.scene.conditions.physics;
        let model = Model::new(character, physics.gravity);
        let mut state = State::new(&model);
        state.update(&model, &character.rest, &vec![0.0; model.nv()]);
        let floor = physics.ground.map_or(0.0, |g| g.height_m);
        let com = ground(&state.com(&model));
        let stance = ground(&(self.onto * Point3::new(com.x, floor, com.y)).coords);
        let home = ground(&skeleton.position(&character.rest, 0));
        let keyed = [0, 2].map(|axis| keyed(tracks, Dof::Coordinate(0, axis)));
        let mut balanced = vec![0.0; skeleton.nq()];
        for (f, t_s) in moments.iter().enumerate() {
            let q = finished.clip.pose_mut(f);
            let here = skeleton.position(q, 0);
            let asked = before.map_or(here, |clip| skeleton.position(clip.pose(f), 0));
            balanced.copy_from_slice(q);
            settle(&model, &mut state, &mut balanced, self.plants, stance)?;
            let rules = keyed.each_ref().map(|k| k.as_ref().map_or(0.0, |k| share(k, *t_s)));
            if rules == [0.0; 2] {
                q.copy_from_slice(&balanced);
            } else {
                let free = ground(&skeleton.position(&balanced, 0)) - home;
                let [x, z] = [0, 1].map(|k| (1.0 - rules[k]) * free[k]);
                skeleton.set_position(q, 0, &Vec3::new(asked.x + x, here.y, asked.z + z));
                plant(skeleton, q, self.plants)?;
            }
            finished.lowered_m[f] = asked.y - skeleton.position(q, 0).y;
        }
        let ground_m = physics.ground.map(|g| g.height_m);
        if let Some(ground_m) = ground_m {
            self.give_way(finished, &model, ground_m)?;
        }
        Ok(())
    }

    /// Moves the root where the soles could not carry the motion.
    fn give_way(&self, finished: &mut Finished, model: &Model, ground_m: f64) -> Result<(), IkError> {
        let feet: Vec<Foot> = Foot::of(&self.scene.character, model);
        let feet: Vec<Foot> =
            feet.into_iter().filter(|foot| self.plants.iter().any(|p| p.limb == foot.limb)).collect();
        if feet.is_empty() {
            return Ok(());
        }
        let mut clip = finished.clip.clone();
        let rate_hz = clip.rate_hz;
        let sudden = |clip: &Clip| Derivatives::new(clip, SUDDEN_S);
        let moves = admit(model, &mut clip, &sudden(&finished.clip), &feet, self.plants, ground_m, MARGIN_M)?;
        let moved = |m: &Vec2| m.norm() > MOVED_M;
        let (Some(first), Some(last)) = (moves.iter().position(moved), moves.iter().rposition(moved)) else {
            return Ok(());
        };
        let left: Vec<f64> = outside(model, &clip, &sudden(&clip), &feet, ground_m, 0.0)
            .iter()
            .map(|(beyond, _)| beyond.norm())
            .collect();
        let worst = left.iter().copied().fold(0.0, f64::max);
        let time = |frame: usize| frame as f64 / rate_hz;
        finished.shifted = Some(Shifted {
            by_m: moves.iter().map(|m| m.norm()).fold(0.0, f64::max),
            from_s: time(first),
            to_s: time(last),
            outside: left.iter().position(|by| *by > LEFT_M).map(|frame| (time(frame), worst)),
        });
        finished.clip = clip;
        Ok(())
    }
}
