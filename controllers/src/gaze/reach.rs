//! How far neck and trunk take the eyes: which way they look where the point itself is out of reach.
//!
//! Directions are azimuth (about the trunk's own vertical, positive to the left) and elevation. The neck turns as far as the
//! limits of its joints add up to, the trunk by a share of those of the spine, once the neck has used most of its own. The
//! trunk's turn is counted from where the body as asked would face, so it does not chase itself.
//!
//! A point that passes behind the back stays on the side where it was until it is [`BEHIND`] beyond; then the gaze crosses to
//! the other side within [`CROSS_S`]. So the direction never jumps.
//!
//! In: a pose, the pose asked for, a point. Out: an [`Aim`]. Angles in rad.

use std::f64::consts::{PI, TAU};

use bodies::{Character, JointClass};
use dynamics::{Model, State};
use motion::{BallLimits, Joint, Kinematics, Limits, Quat, Vec3, smoothstep};

/// Which way to look.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aim {
    /// Direction that the neck can reach, world, unit; `None` where it can reach the point.
    pub direction: Option<Vec3>,
    /// Turn of the trunk about [`Aim::up`], rad.
    pub trunk: f64,
    /// Vertical of the trunk, world, unit.
    pub up: Vec3,
}

/// A ball of the spine.
#[derive(Clone, Debug)]
pub(super) struct Spine {
    pub body: usize,
    pub limits: Option<BallLimits>,
}

/// What is known of a chain's range, and where it looked last. See the module header.
#[derive(Clone, Debug)]
pub(super) struct Reach {
    /// Body that carries the neck.
    base: usize,
    /// World at rest in that body's frame.
    base_from_rest: Quat,
    /// Turn and nod of the neck to either side.
    neck: [f64; 2],
    /// Turn of the trunk to either side.
    trunk: f64,
    /// What turns the trunk.
    pub spine: Vec<Spine>,
    memory: Memory,
}

#[derive(Clone, Copy, Debug, Default)]
struct Memory {
    /// Azimuth of the point, from the trunk as asked; it may pass half a turn.
    azimuth: Option<f64>,
    /// Turns of neck and trunk.
    turns: [f64; 2],
    /// When it began to cross to the other side, s, and the turns that are left of the side it came from.
    crossing: Option<(f64, [f64; 2])>,
}

/// The part of the neck's range that it takes at most, so that it does not run into its ligaments.
const NECK: f64 = 0.95;
/// The part of the neck's turn from which on the trunk goes along.
const ALONE: f64 = 0.7;
/// A point this far beyond the middle of the back changes sides.
const BEHIND: f64 = 0.5;
/// How long the gaze takes to the other side, s.
const CROSS_S: f64 = 1.0;
/// A point steeper than this above or below has no azimuth of its own.
const STEEP: f64 = 0.05;

impl Reach {
    /// The range of the balls `chain` (links) of a body, and of its spine by `share` of its own.
    pub fn new(character: &Character, model: &Model, chain: &[usize], share: f64) -> Self {
        let links = character.skeleton.links();
        let ball = |link: usize| match &links[link].limits {
            Some(Limits::Ball(b)) => Some(*b),
            _ => None,
        };
        // least of both sides, of all joints together
        let sum = |links: &[usize], axis: usize| {
            let one = |&l: &usize| ball(l).map_or(PI, |b| b.ranges[axis].hi.min(-b.ranges[axis].lo).max(0.0));
            links.iter().map(one).sum::<f64>().min(PI)
        };
        let first = chain.first().copied();
        let above: Vec<usize> = first
            .and_then(|l| links[l].parent)
            .into_iter()
            .flat_map(|p| character.skeleton.ancestors(p))
            .collect();
        let turns =
            |&l: &usize| character.classes[l] == JointClass::Spine && links[l].joint == Joint::Spherical;
        let spine: Vec<usize> = above.iter().copied().filter(|l| share > 0.0 && turns(l)).collect();
        let base = above.first().map_or(0, |&l| model.body_of[l].0);
        let rest = Kinematics::new(&character.skeleton, &character.rest);
        Self {
            base,
            base_from_rest: rest.world[model.bodies[base].link].rotation.inverse(),
            neck: [NECK * sum(chain, 2), sum(chain, 0)],
            trunk: share * sum(&spine, 2),
            spine: spine.iter().map(|&l| Spine { body: model.body_of[l].0, limits: ball(l) }).collect(),
            memory: Memory::default(),
        }
    }

    /// Forgets where it looked.
    pub fn forget(&mut self) {
        self.memory = Memory::default();
    }

    /// Which way to look at `t_s` from `eyes` to `target` (world) in the pose that `state` is updated to, when `goal_q` is
    /// asked; `step` where this is the control step's own moment, not one foreseen.
    pub fn aim(
        &mut self,
        model: &Model,
        state: &mut State,
        (pose, goal_q): (&[f64], &[f64]),
        (eyes, target): (Vec3, Vec3),
        t_s: f64,
        step: bool,
    ) -> Aim {
        state.update_pose(model, goal_q);
        let turn = |state: &State, body: usize| state.bodies[body].world.rotation;
        let root_from_base = turn(state, 0).inverse() * turn(state, self.base);
        state.update_pose(model, pose);
        let asked = turn(state, 0) * root_from_base * self.base_from_rest;
        let now = turn(state, self.base) * self.base_from_rest;
        let way = target - eyes;
        let mut memory = self.memory;
        let (azimuth, _) = angles(&asked, &way, memory.azimuth.unwrap_or(0.0));
        let over = azimuth.abs() > PI + BEHIND;
        let azimuth = if over { azimuth - TAU.copysign(azimuth) } else { azimuth };
        let [most, nod] = self.neck;
        let trunk = (azimuth.abs() - ALONE * most).clamp(0.0, self.trunk).copysign(azimuth);
        let (in_base, up) = angles(&now, &way, azimuth - trunk);
        let (neck, nodding) = (in_base.clamp(-most, most), up.clamp(-nod, nod));
        if over {
            memory.crossing = Some((t_s, [memory.turns[0] - neck, memory.turns[1] - trunk]));
        }
        let left = memory.crossing.map_or(0.0, |(from_s, _)| 1.0 - smoothstep((t_s - from_s) / CROSS_S));
        let still = memory.crossing.map_or([0.0; 2], |(_, from)| from.map(|x| x * left));
        let turns = [neck + still[0], trunk + still[1]];
        if step {
            memory.azimuth = Some(azimuth);
            memory.turns = turns;
            memory.crossing = memory.crossing.filter(|_| left > 0.0);
            self.memory = memory;
        }
        let within = left == 0.0 && neck == in_base && nodding == up;
        let (sin, cos) = turns[0].sin_cos();
        let local = Vec3::new(sin * nodding.cos(), nodding.sin(), cos * nodding.cos());
        Aim { direction: (!within).then(|| now * local), trunk: turns[1], up: asked * Vec3::y() }
    }
}

/// Azimuth and elevation of `way` in a frame that faces +Z, +Y up; the azimuth is the one nearest to `near`.
fn angles(frame: &Quat, way: &Vec3, near: f64) -> (f64, f64) {
    let d = frame.inverse() * way;
    let across = d.x.hypot(d.z);
    let azimuth = if across > STEEP * d.norm() { d.x.atan2(d.z) } else { near };
    (azimuth + TAU * ((near - azimuth) / TAU).round(), d.y.atan2(across))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A point that circles a body that stands still: neck and trunk go as far as they can, keep their side until the
    /// point is well past the back, and never jump.
    #[test]
    fn a_gaze_never_jumps() {
        let (c, _) = bodies::anthropometry::human::human();
        let model = Model::new(&c, Vec3::y() * -9.81);
        let chain = ["neck", "head"].map(|l| c.skeleton.link(l).unwrap());
        let eyes = Vec3::new(0.0, 1.6, 0.1);
        let mut state = State::new(&model);
        let mut reach = Reach::new(&c, &model, &chain, 0.5);
        let most = reach.neck[0] + reach.trunk;
        assert!((100.0..140.0).contains(&most.to_degrees()), "{most}");
        let (dt, mut before, mut furthest) = (1.0 / 240.0, None::<(f64, f64)>, 0.0f64);
        for i in 0..6000 {
            let t = f64::from(i) * dt;
            let at = 0.8 * t; // rad: three times around
            let target = eyes + Vec3::new(at.sin(), 0.1, at.cos()) * 2.0;
            let aim = reach.aim(&model, &mut state, (&c.rest, &c.rest), (eyes, target), t, true);
            let looks = aim.direction.unwrap_or((target - eyes).normalize());
            let neck = looks.x.atan2(looks.z);
            assert!(neck.abs() <= reach.neck[0] + 1e-9 && aim.trunk.abs() <= reach.trunk + 1e-9, "{t}");
            if let Some((neck_was, trunk_was)) = before {
                // 3.5 rad/s seen, as it crosses; a jump to the other side would be 600
                let rate = (neck - neck_was).abs().max((aim.trunk - trunk_was).abs()) / dt;
                assert!(rate < 6.0, "{t}: {rate} rad/s");
            }
            before = Some((neck, aim.trunk));
            furthest = furthest.max(neck.abs() + aim.trunk.abs());
        }
        assert!((furthest - most).abs() < 1e-6, "{furthest} {most}");
    }
}
