//! Footwork: planted feet that step, and jumps.
//!
//! In: where feet stand at rest, the steps and jumps of a scene, a moment. Out: where the feet are planted
//! at that moment, and how far a jump has lifted the body. Kinematics only: what the pelvis does meanwhile is the
//! script's; legs follow by IK. World frame, m, s, rad; +x is the figure's left, +z its front at rest.
//!
//! A foot steps along a straight line with the least-jerk curve, its lift `h sin²(πu)`, so that it leaves
//! and meets the ground at no speed. It travels only while it is off the ground, between 8 % and 92 % of the step. A jump lifts feet and root alike by `½ g t (T − t)`: flight is ballistic
//! whatever the pose does.

use dynamics::conditions::RootMode;
use motion::plant::Plant;
use motion::rotation::exp;
use motion::{Curve, Transform, Vec3};

use super::Check;
use crate::SceneError;
use crate::schema::FootworkRon;

/// Share of a step at either end in which the foot is lifted or set down and does not travel.
const GROUND: f64 = 0.08;

/// One foot goes to another place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Index into the plants.
    pub plant: usize,
    /// When the foot leaves the ground, s.
    pub start_s: f64,
    /// How long it is in the air, s.
    pub duration_s: f64,
    /// Where it goes, left and front, relative to where it stands at rest, m.
    pub to: [f64; 2],
    /// Its heading there relative to rest, about the vertical, rad.
    pub turn: f64,
    /// Height of the step, m.
    pub lift: f64,
}

/// Both feet leave the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// When they leave it, s.
    pub start_s: f64,
    /// Time in the air, s; the height follows, `g T²/8`.
    pub duration_s: f64,
    /// How far the toes point down in mid-air, rad.
    pub point: f64,
    /// How far the feet are drawn up to the body in mid-air, m.
    pub tuck: f64,
}

/// Steps and jumps of a motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Footwork {
    /// Steps; those of one foot in order of time, none before the last has ended.
    pub steps: Vec<Step>,
    /// Jumps, in order of time.
    pub jumps: Vec<Jump>,
    /// Length of gravity, m/s².
    pub gravity: f64,
}

impl Footwork {
    /// Whether every foot stays where it is.
    pub fn is_still(&self) -> bool {
        self.steps.is_empty() && self.jumps.is_empty()
    }

    /// Where the feet `rest` are planted at `t` (s), and the height of the jump (m), already in them.
    pub fn at(&self, t: f64, rest: &[Plant]) -> (Vec<Plant>, f64) {
        let mut plants: Vec<Plant> = (rest.iter().enumerate()).map(|(i, p)| self.foot(i, p, t)).collect();
        let mut height = 0.0;
        for j in &self.jumps {
            let u = (t - j.start_s) / j.duration_s;
            if (0.0..=1.0).contains(&u) {
                let lift = 0.5 * self.gravity * j.duration_s * j.duration_s * u * (1.0 - u);
                let swell = (std::f64::consts::PI * u).sin().powi(2);
                height += lift;
                for p in &mut plants {
                    let at = &mut p.world_from_end;
                    let left = at.rotation * Vec3::x();
                    at.rotation = exp(&(left * (j.point * swell))) * at.rotation;
                    at.translation.vector.y += lift + j.tuck * swell;
                }
            }
        }
        (plants, height)
    }

    /// How far a plant is turned about the vertical from rest at `t` (s), rad: full turns count.
    pub fn turn(&self, plant: usize, t: f64) -> f64 {
        self.way(plant, t).1
    }

    fn foot(&self, plant: usize, rest: &Plant, t: f64) -> Plant {
        let (to, turn, lift) = self.way(plant, t);
        let at = &rest.world_from_end;
        let moved = at.translation.vector + Vec3::new(to[0], lift, to[1]);
        let rotation = exp(&(Vec3::y() * turn)) * at.rotation;
        Plant { world_from_end: Transform::from_parts(moved.into(), rotation), ..rest.clone() }
    }

    /// Of a plant at `t`: left and front from rest, m; turn, rad; lift, m.
    fn way(&self, plant: usize, t: f64) -> ([f64; 2], f64, f64) {
        let (mut to, mut turn, mut lift) = ([0.0; 2], 0.0, 0.0);
        for s in self.steps.iter().filter(|s| s.plant == plant && s.start_s <= t) {
            let u = ((t - s.start_s) / s.duration_s).min(1.0);
            let m = Curve::EaseInOut.at(((u - GROUND) / (1.0 - 2.0 * GROUND)).clamp(0.0, 1.0));
            to = [0, 1].map(|k| to[k] + m * (s.to[k] - to[k]));
            turn += m * (s.turn - turn);
            lift = if u < 1.0 { s.lift * (std::f64::consts::PI * u).sin().powi(2) } else { 0.0 };
        }
        (to, turn, lift)
    }
}

impl Check<'_> {
    /// Steps and jumps of a scene whose `planted` limbs stand.
    pub(crate) fn footwork(
        &self,
        ron: &[FootworkRon],
        planted: &[usize],
        root: RootMode,
        gravity: f64,
    ) -> Result<Footwork, SceneError> {
        let mut work = Footwork { gravity, ..Footwork::default() };
        if !ron.is_empty() && !matches!(root, RootMode::Pinned | RootMode::Free) {
            let e =
                "footwork needs `root: Free` or `root: Pinned`: an assisted root is held over feet that stay";
            return Err(self.source.error("footwork", e));
        }
        let names = || planted.iter().map(|&l| self.character.skeleton.limbs()[l].name.as_str());
        for (i, r) in ron.iter().enumerate() {
            let place = |field: &str| format!("footwork[{i}].{field}");
            let time = |field: &str, t: f64, least: f64| self.within(&place(field), t, least, 86_400.0, "s");
            match r {
                FootworkRon::Step { limb, start_s, duration_s, to_m, turn_deg, lift_m } => {
                    let plant = names().position(|n| n == limb).ok_or_else(|| {
                        self.source.unknown(&place("limb"), "planted limb", limb, " in a step", names())
                    })?;
                    let start_s = time("start_s", *start_s, 0.0)?;
                    let before = work.steps.iter().rev().find(|s: &&Step| s.plant == plant);
                    if let Some(s) = before.filter(|s| s.start_s + s.duration_s > start_s + 1e-9) {
                        let e = format!(
                            "`{limb}` starts a step at {start_s} s, but its last one ends at {:.3} s; steps of one limb follow one another",
                            s.start_s + s.duration_s
                        );
                        return Err(self.source.error(&place("start_s"), e));
                    }
                    work.steps.push(Step {
                        plant,
                        start_s,
                        duration_s: time("duration_s", *duration_s, 0.05)?,
                        to: [
                            self.within(&place("to_m[0]"), to_m.0, -1e3, 1e3, "m")?,
                            self.within(&place("to_m[1]"), to_m.1, -1e3, 1e3, "m")?,
                        ],
                        turn: self.within(&place("turn_deg"), *turn_deg, -3600.0, 3600.0, "°")?.to_radians(),
                        lift: self.within(&place("lift_m"), *lift_m, 0.0, 2.0, "m")?,
                    });
                }
                FootworkRon::Jump { start_s, duration_s, point_deg, tuck_m } => work.jumps.push(Jump {
                    start_s: time("start_s", *start_s, 0.0)?,
                    duration_s: self.within(&place("duration_s"), *duration_s, 0.05, 10.0, "s")?,
                    point: self.within(&place("point_deg"), *point_deg, -90.0, 90.0, "°")?.to_radians(),
                    tuck: self.within(&place("tuck_m"), *tuck_m, 0.0, 2.0, "m")?,
                }),
            }
        }
        Ok(work)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bodies::anthropometry::human::human;

    fn feet() -> Vec<Plant> {
        let (human, _) = human();
        human.legs().map(|l| Plant::here(&human.skeleton, &human.rest, l)).collect()
    }

    fn work() -> Footwork {
        Footwork {
            steps: vec![
                Step { plant: 0, start_s: 1.0, duration_s: 0.5, to: [0.1, 0.3], turn: 0.4, lift: 0.08 },
                Step { plant: 0, start_s: 2.0, duration_s: 0.5, to: [0.0, 0.0], turn: 0.0, lift: 0.08 },
            ],
            jumps: vec![Jump { start_s: 4.0, duration_s: 0.5, point: 0.6, tuck: 0.05 }],
            gravity: 9.81,
        }
    }

    /// Before, between and after steps feet are where the scene places them, to the bit at rest.
    #[test]
    fn feet_stand_between_steps() {
        let (work, rest) = (work(), feet());
        for t in [0.0, 1.0, 3.0, 4.0, 4.5, 9.0] {
            let (plants, height) = work.at(t, &rest);
            for (p, r) in plants.iter().zip(&rest) {
                let d = (p.world_from_end.translation.vector - r.world_from_end.translation.vector).norm();
                assert!(d < 1e-12 && height.abs() < 1e-12, "{t}: {d}, {height}");
            }
        }
        let (plants, _) = work.at(1.7, &rest);
        let moved = plants[0].world_from_end.translation.vector - rest[0].world_from_end.translation.vector;
        assert!((moved - Vec3::new(0.1, 0.0, 0.3)).norm() < 1e-12, "{moved}");
        assert_eq!(plants[1], rest[1]);
    }

    /// Flight falls with g: the second difference of the height is −g h².
    #[test]
    fn flight_is_ballistic() {
        let (work, rest) = (work(), feet());
        let height = |t: f64| work.at(t, &rest).1;
        let h = 1e-3;
        for t in [4.1, 4.2, 4.3, 4.4] {
            let a = (height(t + h) - 2.0 * height(t) + height(t - h)) / (h * h);
            assert!((a + 9.81).abs() < 1e-6, "{t}: {a}"); // 2e-10 seen
        }
    }
}
