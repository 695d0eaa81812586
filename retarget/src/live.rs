//! Live puppeteering: mapping, global transform and contact adjustment, one frame in, one frame out.
//!
//! In: human poses as they come, at a constant rate. Out: the character's pose for each, before the next one comes: no
//! frame is waited for. What a clip can look ahead for is done causally here:
//!
//! - momentum: between the frame before and this one, as in [`global_transform`](mod@crate::global_transform); the
//!   heading leaks towards the human's with the time constant 1/(2π f) of [`GlobalOptions::drift_hz`];
//! - contacts: a point is down from the frame in which its human counterparts are; its place is where it is then, on
//!   the floor. What separates it from there, in position and rate, dies out over [`LAND_S`], and after lift-off what
//!   separates it from its own path over [`LEAVE_S`], by the quintic below. Points of one link that land one after the
//!   other keep their distances:
//!   `x₀ (1 − s)³(1 + 3s + 6s²) + ẋ₀ T s(1 − s)³(1 + 3s)`: position and rate never jump.
//! - own floors of the human points, which a clip tells as a whole: given by [`Live::on_floors`], from a recording of a few
//!   steps ([`own_floors`](crate::contacts::phases::own_floors)); without it the ground.
//!
//! [`GlobalOptions::drift_hz`]: crate::GlobalOptions::drift_hz

use dynamics::{Model, State};
use motion::{Kinematics, Quat, Transform, Vec3};

use crate::contacts::ik::ContactIk;
use crate::contacts::phases::{LEAVE, groups, in_contact};
use crate::fit::place_root;
use crate::global_transform::Scale;
use crate::mapping::{MappedFrame, Mapper};
use crate::phase::PhaseFrames;
use crate::{Follow, Mapping, Options, Performer, Puppet, RetargetError};

/// Time in which a point that lands comes to rest, s.
pub const LAND_S: f64 = 0.1;
/// Time in which a point that leaves returns to its own path, s.
pub const LEAVE_S: f64 = 0.3;
/// Depth that a flying point approaches but never reaches, m.
const FLOOR_M: f64 = 0.004;

/// The character now.
#[derive(Clone, Copy, Debug)]
pub struct LiveFrame<'a> {
    /// The pose, world (`nq` of the puppet).
    pub pose: &'a [f64],
    /// What the mapping says of it.
    pub mapped: MappedFrame,
    /// Which of the puppet's contact points rest.
    pub down: &'a [bool],
}

/// A body's mass and momentum, frame after frame.
struct Momentum {
    model: Model,
    state: State,
    before: Vec<f64>,
    q: Vec<f64>,
    v: Vec<f64>,
    com: Vec3,
}

impl Momentum {
    fn new(character: &bodies::Character) -> Self {
        let model = Model::new(character, Vec3::zeros());
        let s = &character.skeleton;
        Self {
            state: State::new(&model),
            before: Vec::new(),
            q: vec![0.0; s.nq()],
            v: vec![0.0; s.nv()],
            com: Vec3::zeros(),
            model,
        }
    }

    /// The centre of mass now and its way since the frame before; angular momentum and inertia about the vertical
    /// through it, halfway.
    fn advance(&mut self, pose: &[f64], dt: f64) -> (Vec3, Vec3, f64, f64) {
        let skeleton = self.model.skeleton.clone();
        if self.before.is_empty() {
            self.before.extend_from_slice(pose);
        }
        skeleton.interpolate(&self.before, pose, 0.5, &mut self.q);
        skeleton.difference(&self.before, pose, dt, &mut self.v);
        self.state.update(&self.model, &self.q, &self.v);
        let spin = self.state.momentum(&self.model).angular.y;
        let inertia = self.state.composites(&self.model)[0].2[(1, 1)];
        self.state.update_pose(&self.model, &self.before);
        let last = self.state.com(&self.model);
        self.state.update_pose(&self.model, pose);
        self.com = self.state.com(&self.model);
        self.before.copy_from_slice(pose);
        (self.com, self.com - last, spin, inertia)
    }
}

/// A contact point of the puppet.
#[derive(Clone, Debug)]
struct Point {
    link: usize,
    at: Vec3,
    follow: Follow,
    groups: Vec<Vec<usize>>,
    place: Vec3,
    /// Distance from where it should be, and its rate, at the last change; seconds since.
    offset: Vec3,
    rate: Vec3,
    since_s: f64,
    /// Own path and goal of the frame before.
    own: Vec3,
    goal: Vec3,
}

/// A performance as it happens. See the module header.
pub struct Live<'m> {
    mapper: Mapper<'m>,
    performer: &'m Performer,
    puppet: &'m Puppet,
    scale: Scale,
    leak: f64,
    dt: f64,
    thresholds: [f64; 2],
    /// Own floor of each human contact point, m.
    floors: Vec<f64>,
    human: Momentum,
    own: Momentum,
    human_k: Kinematics,
    own_k: Kinematics,
    human_points: Vec<Vec3>,
    human_down: Vec<bool>,
    points: Vec<Point>,
    down: Vec<bool>,
    goals: Vec<Vec3>,
    ik: ContactIk,
    local: Vec<f64>,
    world: Vec<f64>,
    pose: Vec<f64>,
    heading: f64,
    course: f64,
    yaw: f64,
    com: Vec3,
    frames: usize,
}

impl<'m> Live<'m> {
    /// Before the first frame of a performance at `rate_hz`; of the options, those of the global transform and of
    /// contacts count (phases by hand do not).
    ///
    /// # Errors
    /// A performer without the mapping's feature points or the counterparts of contact points; a rate that is
    /// not positive.
    pub fn new(
        mapping: &'m Mapping,
        performer: &'m Performer,
        puppet: &'m Puppet,
        rate_hz: f64,
        options: &Options,
    ) -> Result<Self, RetargetError> {
        mapping.fits(performer)?;
        if !(rate_hz > 0.0 && rate_hz.is_finite()) {
            let (name, allowed) = ("the frame rate (Hz)", "positive numbers");
            return Err(RetargetError::Option { name, value: rate_hz, allowed });
        }
        let sites = puppet.character.skeleton.sites();
        let zero = Vec3::zeros();
        let point = |c: &crate::ContactPoint| {
            Ok(Point {
                link: sites[c.site].link,
                at: sites[c.site].at,
                follow: c.follow,
                groups: groups(performer, puppet, c)?,
                place: zero,
                offset: zero,
                rate: zero,
                since_s: f64::INFINITY,
                own: zero,
                goal: zero,
            })
        };
        let points: Vec<Point> = puppet.contacts.iter().map(point).collect::<Result<_, RetargetError>>()?;
        let size = performer.features.unit_m;
        let contacts = performer.character.contacts.len();
        let rest = &puppet.character.rest;
        let always = vec![vec![PhaseFrames { first: 0, last: 0 }]; points.len()];
        Ok(Self {
            mapper: mapping.mapper(performer),
            scale: Scale::new(performer, puppet, options.global.size),
            leak: 1.0 - (-std::f64::consts::TAU * options.global.drift_hz / rate_hz).exp(),
            dt: 1.0 / rate_hz,
            thresholds: [options.contact.height_m * size, options.contact.speed_m_s * size],
            floors: vec![0.0; contacts],
            human: Momentum::new(&performer.character),
            own: Momentum::new(&puppet.character),
            human_k: Kinematics::new(&performer.character.skeleton, &performer.character.rest),
            own_k: Kinematics::new(&puppet.character.skeleton, rest),
            human_points: vec![zero; contacts],
            human_down: vec![false; contacts],
            down: vec![false; points.len()],
            goals: vec![zero; points.len()],
            ik: ContactIk::new(puppet, &always),
            points,
            local: rest.clone(),
            world: rest.clone(),
            pose: rest.clone(),
            heading: 0.0,
            course: 0.0,
            yaw: 0.0,
            com: zero,
            frames: 0,
            performer,
            puppet,
        })
    }

    /// With own floors of the performer's contact points, m above the ground; those that are missing are 0.
    #[must_use]
    pub fn on_floors(mut self, floors: &[f64]) -> Self {
        self.floors.iter_mut().zip(floors).for_each(|(own, given)| *own = *given);
        self
    }

    /// The character's pose for a human pose (`nq` of the performer, ground at height 0).
    ///
    /// # Errors
    /// A pose that is not finite.
    pub fn step(&mut self, human: &[f64]) -> Result<LiveFrame<'_>, RetargetError> {
        let mapped = self.mapper.map(human, &mut self.local)?;
        self.place(human);
        self.contacts(human);
        self.goals();
        // the goals of a link need not fit it: those that have landed outweigh those that are still landing
        let (goals, down, points) = (&self.goals, &self.down, &self.points);
        let rests = |c: usize| if down[c] && points[c].since_s >= LAND_S { 1.0 } else { 0.0 };
        self.ik.solve(&self.world, &|c| (goals[c], rests(c)), &mut self.pose);
        self.frames += 1;
        Ok(LiveFrame { pose: &self.pose, mapped, down: &self.down })
    }

    /// Puts the local pose where its momentum wants it.
    fn place(&mut self, human: &[f64]) {
        let s = &self.performer.character.skeleton;
        let root = s.links()[0].parent_from_zero * s.joint_transform(human, 0);
        let heading = self.performer.features.root.heading(&root.rotation);
        let (com, way, spin, _) = self.human.advance(human, self.dt);
        let (own_com, _, own_spin, own_inertia) = self.own.advance(&self.local, self.dt);
        if self.frames == 0 {
            (self.heading, self.course, self.yaw) = (heading, heading, heading);
            self.com = self.scale.velocity(heading, &com);
        } else {
            let turn = heading - self.heading;
            self.heading += turn - (turn / std::f64::consts::TAU).round() * std::f64::consts::TAU;
            self.course += self.leak * (self.heading - self.course);
            self.yaw += self.dt * (self.scale.inertia.y * spin - own_spin) / own_inertia;
            self.yaw += self.leak * (self.heading - self.yaw);
            self.com += self.scale.velocity(self.course, &way);
        }
        let turn = Quat::from_axis_angle(&Vec3::y_axis(), self.yaw);
        let at = self.com - turn * own_com;
        let world_from_local = Transform::from_parts(Vec3::new(at.x, 0.0, at.z).into(), turn);
        self.world.copy_from_slice(&self.local);
        place_root(&self.puppet.character.skeleton, &mut self.world, |r| world_from_local * r);
    }

    /// Which human points touch.
    fn contacts(&mut self, human: &[f64]) {
        let c = &self.performer.character;
        self.human_k.update(&c.skeleton, human);
        for (i, &site) in c.contacts.iter().enumerate() {
            let site = &c.skeleton.sites()[site];
            let p = self.human_k.point(site.link, &site.at);
            let first = self.frames == 0;
            let speed = if first { 0.0 } else { (p - self.human_points[i]).norm() / self.dt };
            let times = if self.human_down[i] { LEAVE } else { 1.0 };
            let height = p.y - self.floors[i];
            self.human_down[i] = height < times * self.thresholds[0] && speed < times * self.thresholds[1];
            self.human_points[i] = p;
        }
    }

    /// Where the puppet's points have to be.
    fn goals(&mut self) {
        self.own_k.update(&self.puppet.character.skeleton, &self.world);
        for i in 0..self.points.len() {
            let (earlier, later) = self.points.split_at_mut(i);
            let Some((p, later)) = later.split_first_mut() else { continue };
            let own = self.own_k.point(p.link, &p.at);
            let down = in_contact(p.follow, &p.groups, |c| self.human_down[c]);
            let first = self.frames == 0;
            p.since_s += self.dt;
            if down != self.down[i] || first {
                // rate of the goal as it went until now
                let ahead = remaining_offset(p, if self.down[i] { LAND_S } else { LEAVE_S });
                let base = if self.down[i] { p.place } else { own };
                let now = if first { own } else { base + ahead };
                let rate = if first { Vec3::zeros() } else { (now - p.goal) / self.dt };
                let own_rate = if first { Vec3::zeros() } else { (own - p.own) / self.dt };
                if down {
                    p.place = Vec3::new(now.x, 0.0, now.z);
                    let resting = earlier.iter().zip(&self.down).chain(later.iter().zip(&self.down[i + 1..]));
                    let siblings = resting.filter(|(o, down)| **down && o.link == p.link).map(|(o, _)| o);
                    let siblings: Vec<(Vec3, f64)> =
                        siblings.map(|o| (o.place, (o.at - p.at).norm())).collect();
                    p.place = at_distances(p.place, &siblings);
                    (p.offset, p.rate) = (now - p.place, rate);
                } else {
                    (p.offset, p.rate) = (now - own, rate - own_rate);
                }
                if first && !down {
                    (p.offset, p.rate) = (Vec3::zeros(), Vec3::zeros());
                }
                p.since_s = 0.0;
            }
            let base = if down { p.place } else { own };
            let mut goal = base + remaining_offset(p, if down { LAND_S } else { LEAVE_S });
            goal.y = above_floor(goal.y);
            (p.own, p.goal, self.goals[i], self.down[i]) = (own, goal, goal, down);
        }
    }
}

/// A place on the floor at the given distances from others, near `place`.
fn at_distances(mut place: Vec3, others: &[(Vec3, f64)]) -> Vec3 {
    for _ in 0..100 {
        for (other, length) in others {
            let way = place - other;
            if way.norm() > 1e-9 {
                place = other + way * (length / way.norm());
            }
        }
    }
    place
}

/// Height kept above −[`FLOOR_M`].
fn above_floor(y: f64) -> f64 {
    if y < 0.0 { y / (1.0 + (y / FLOOR_M).powi(2)).sqrt() } else { y }
}

/// What is left of a point's offset.
fn remaining_offset(p: &Point, over_s: f64) -> Vec3 {
    let s = p.since_s / over_s;
    if s >= 1.0 {
        return Vec3::zeros();
    }
    let c = (1.0 - s).powi(3);
    p.offset * (c * (1.0 + 3.0 * s + 6.0 * s * s)) + p.rate * (over_s * s * c * (1.0 + 3.0 * s))
}
