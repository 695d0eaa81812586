//! Gaze: a reactive movement property that keeps the eyes on a point while the body moves.
//!
//! Each step the joints of a chain (neck, head) are solved so that the line of sight meets the point where the trunk
//! will be at the end of the step: from the pose asked for, each joint takes an equal share of the smallest rotation
//! that is left, within its limits. Their muscles keep the tension asked for; their rest follows the solved pose, with
//! the load of the head as the trunk carries it now (RNEA at the simulated state, with the measured accelerations) and
//! the damping of the way the neck has to go fed forward, so that even a relaxed neck does not lag.
//!
//! In: a body, a chain, a point of sight, a target. Out: drives of the chain, and of the spine where the trunk goes along. Out of
//! reach (behind the back) neck and trunk turn as far as they may, the limits are kept, and the line of sight misses: `reach`. Balls only: other joints of a chain are refused. World frame; the
//! target is fixed in the world.

mod reach;

use bodies::Character;
use dynamics::digest::{self, Digest};
use dynamics::rnea::joint_force;
use dynamics::{Model, State};
use motion::rotation::{between, exp, log, slerp};
use motion::{Joint, Limits, Quat, Vec3, smoothstep};
use thiserror::Error;

use crate::reactive::{
    AHEAD, ControlStep, FilteredAcceleration, Reactive, ReactiveError, in_zero_frame, rate_between, set_rate,
};
use crate::{Drive, Rest, rest_of};

use reach::{Aim, Reach};

/// What to look at, when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GazeSettings {
    /// The point, world, m.
    pub target: Vec3,
    /// When the gaze turns there, s.
    pub from_s: f64,
    /// When it turns away again, s; infinity for never.
    pub to_s: f64,
    /// How long it takes to turn there and away, s; shorter is more startled.
    pub blend_s: f64,
    /// Share of the spine's range by which the trunk goes along where the neck does not suffice, 0 to 1.
    pub trunk: f64,
}

/// Why a body cannot gaze.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum GazeError {
    /// The body has no such point.
    #[error("no site `{wanted}` to look from; sites: {known}")]
    Eyes {
        /// Name asked for.
        wanted: String,
        /// Names there are.
        known: String,
    },
    /// No joints between.
    #[error("no joints to turn the gaze with")]
    Empty,
    /// A joint that is no ball.
    #[error("joint `{0}` is not a ball")]
    NotABall(String),
    /// A joint that does not carry the eyes.
    #[error("joint `{link}` does not carry site `{eyes}`")]
    Apart {
        /// The joint.
        link: String,
        /// The site.
        eyes: String,
    },
}

/// The line of sight of a body: a point of a link and a direction fixed to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sight {
    /// The link.
    pub link: usize,
    /// The point between the eyes, in the link's frame, m.
    pub at: Vec3,
    /// Where they look, in the link's frame, unit: world +Z at rest.
    pub forward: Vec3,
}

impl Sight {
    /// The line of sight of site `eyes`, straight ahead (+Z) when the body stands at rest.
    ///
    /// # Errors
    /// [`GazeError::Eyes`] if there is no such site.
    pub fn of(character: &Character, eyes: &str) -> Result<Self, GazeError> {
        let s = &character.skeleton;
        let site = s.site(eyes).ok_or_else(|| GazeError::Eyes {
            wanted: eyes.into(),
            known: s.sites().iter().map(|s| s.name.as_str()).collect::<Vec<_>>().join(", "),
        })?;
        let rest = motion::Kinematics::new(s, &character.rest);
        let forward = rest.world[site.link].rotation.inverse() * Vec3::z();
        Ok(Self { link: site.link, at: site.at, forward })
    }

    /// Point and unit direction of the line of sight, world.
    pub fn line(&self, model: &Model, state: &State) -> (Vec3, Vec3) {
        let from = state.point(model, self.link, &self.at);
        let to = state.point(model, self.link, &(self.at + self.forward));
        (from, to - from)
    }

    /// Angle by which the line of sight misses `target`, rad.
    pub fn error(&self, model: &Model, state: &State, target: &Vec3) -> f64 {
        let (from, direction) = self.line(model, state);
        log(&between(&direction, &(target - from))).norm()
    }
}

/// The gaze property. See the module header.
#[derive(Clone, Debug)]
pub struct Gaze {
    settings: GazeSettings,
    sight: Sight,
    chain: Vec<Turning>,
    reach: Reach,
    state: State,
    measured: FilteredAcceleration,
    pose: Vec<f64>,
    goal: Vec<f64>,
    ahead: Vec<f64>,
    vd: Vec<f64>,
    tau: Vec<f64>,
}

#[derive(Clone, Debug)]
struct Turning {
    body: usize,
    link: usize,
    limits: Option<motion::BallLimits>,
    /// Rate of the path a step ago, zero frame.
    rate: Option<Vec3>,
    /// Acceleration of the path, filtered with [`FILTER_S`], zero frame.
    acceleration: Vec3,
}

/// Time constant of the filter of accelerations, s: three control steps; without it the neck oscillates at the
/// control rate, at 40 ms the eyes lag twice as far.
const FILTER_S: f64 = 0.015;
/// Rounds over the chain; each leaves what limits or lever arms kept from it. Two suffice for a free neck.
const ROUNDS: usize = 6;

impl Gaze {
    /// A gaze of `character` from site `eyes` by the joints `links`, from the trunk outward.
    ///
    /// # Errors
    /// A site or joint that cannot do it.
    pub fn new(
        character: &Character,
        model: &Model,
        eyes: &str,
        links: &[usize],
        settings: GazeSettings,
    ) -> Result<Self, GazeError> {
        let sight = Sight::of(character, eyes)?;
        let all = character.skeleton.links();
        let eyes_body = model.body_of[sight.link].0;
        let chain = links.iter().map(|&link| {
            let body = model.body_of[link].0;
            if all[link].joint != Joint::Spherical {
                return Err(GazeError::NotABall(all[link].name.clone()));
            }
            if !model.carries(body, eyes_body) {
                return Err(GazeError::Apart { link: all[link].name.clone(), eyes: eyes.into() });
            }
            let limits = match &all[link].limits {
                Some(Limits::Ball(b)) => Some(*b),
                _ => None,
            };
            Ok(Turning { body, link, limits, rate: None, acceleration: Vec3::zeros() })
        });
        let chain = chain.collect::<Result<Vec<_>, _>>()?;
        if chain.is_empty() {
            return Err(GazeError::Empty);
        }
        let q = model.skeleton.zero_pose();
        Ok(Self {
            settings,
            sight,
            chain,
            reach: Reach::new(character, model, links, settings.trunk),
            state: State::new(model),
            measured: FilteredAcceleration::default(),
            pose: q.clone(),
            goal: q.clone(),
            ahead: q,
            vd: vec![0.0; model.nv()],
            tau: vec![0.0; model.nv()],
        })
    }

    /// What it looks at, when.
    pub fn settings(&self) -> &GazeSettings {
        &self.settings
    }

    /// The same gaze at other times, s.
    pub fn during(mut self, from_s: f64, to_s: f64) -> Self {
        (self.settings.from_s, self.settings.to_s) = (from_s, to_s);
        self
    }

    /// The links it turns, from the trunk outward.
    pub fn links(&self) -> impl Iterator<Item = usize> {
        self.chain.iter().map(|turning| turning.link)
    }

    /// Its line of sight.
    pub fn sight(&self) -> &Sight {
        &self.sight
    }

    /// How much of the gaze acts at `t` seconds: 0 to 1, smooth.
    pub fn weight(&self, t: f64) -> f64 {
        let s = &self.settings;
        let blend = s.blend_s.max(f64::MIN_POSITIVE);
        let away = if s.to_s.is_finite() { smoothstep((t - s.to_s) / blend) } else { 0.0 };
        smoothstep((t - s.from_s) / blend) * (1.0 - away)
    }

    /// Which way to look at the time `t_s`, in `pose`, when `goal` is asked.
    fn aim(&mut self, model: &Model, pose: &[f64], goal: &[f64], t_s: f64, step: bool) -> Aim {
        self.state.update_pose(model, pose);
        let (eyes, _) = self.sight.line(model, &self.state);
        let way = (eyes, self.settings.target);
        self.reach.aim(model, &mut self.state, (pose, goal), way, t_s, step)
    }

    /// Turns the chain in `pose` as `aim` says: the goal's joints, moved by `weight` of what is missing.
    fn solve(&mut self, model: &Model, pose: &mut [f64], goal: &[f64], aim: &Aim, weight: f64) {
        let skeleton = &model.skeleton;
        let asked: Vec<Quat> = self.chain.iter().map(|t| skeleton.rotation(goal, t.link)).collect();
        for (t, r) in self.chain.iter().zip(&asked) {
            skeleton.set_rotation(pose, t.link, r);
        }
        let n = self.chain.len();
        for _ in 0..ROUNDS {
            for (i, t) in self.chain.iter().enumerate() {
                self.state.update_pose(model, pose);
                let (from, direction) = self.sight.line(model, &self.state);
                let wanted = aim.direction.unwrap_or(self.settings.target - from);
                let missing = log(&between(&direction, &wanted));
                let turn = in_zero_frame(&self.state, t.body, &(missing / (n - i) as f64));
                let r = exp(&turn) * skeleton.rotation(pose, t.link);
                let r = t.limits.as_ref().map_or(r, |l| l.clamp(&r));
                skeleton.set_rotation(pose, t.link, &r);
            }
        }
        for (t, r) in self.chain.iter().zip(&asked) {
            let found = skeleton.rotation(pose, t.link);
            let r = slerp(r, &found, weight);
            skeleton.set_rotation(pose, t.link, &t.limits.as_ref().map_or(r, |l| l.clamp(&r)));
        }
    }
}

impl Reactive for Gaze {
    fn identify(&self, d: &mut Digest) {
        let GazeSettings { target, from_s, to_s, blend_s, trunk } = &self.settings;
        digest::vector(d, target);
        d.numbers([from_s, to_s, blend_s, trunk]);
        let links: Vec<usize> = self.links().collect();
        d.list(&links, |d, link| d.count(*link));
        d.count(self.sight.link);
        digest::vector(d, &self.sight.at);
        digest::vector(d, &self.sight.forward);
    }

    fn react(&mut self, step: &ControlStep<'_>, drives: &mut [Drive]) -> Result<(), ReactiveError> {
        self.measured.update(step.v, step.dt, FILTER_S);
        let weight = self.weight(step.time_s);
        if weight <= 0.0 {
            self.chain.iter_mut().for_each(|t| (t.rate, t.acceleration) = (None, Vec3::zeros()));
            self.reach.forget();
            return Ok(());
        }
        let skeleton = &step.model.skeleton;
        // where the trunk will be at the end of the step, and `AHEAD` seconds later
        let mut pose = std::mem::take(&mut self.pose);
        let mut ahead = std::mem::take(&mut self.ahead);
        let mut goal = std::mem::take(&mut self.goal);
        pose.copy_from_slice(step.q);
        skeleton.integrate(&mut pose, step.v, step.dt);
        ahead.copy_from_slice(&pose);
        skeleton.integrate(&mut ahead, step.v, AHEAD);
        goal.copy_from_slice(step.goal_q);
        skeleton.integrate(&mut goal, step.goal_v, AHEAD);
        let aim = self.aim(step.model, &pose, step.goal_q, step.time_s, true);
        self.solve(step.model, &mut pose, step.goal_q, &aim, weight);
        let soon_s = step.time_s + AHEAD;
        let soon = self.aim(step.model, &ahead, &goal, soon_s, false);
        self.solve(step.model, &mut ahead, &goal, &soon, self.weight(soon_s));

        // accelerations of the load: the trunk's as measured, those of the chain's joints as their path needs them
        self.vd.copy_from_slice(&self.measured.vd);
        for t in &mut self.chain {
            let joint = &step.model.bodies[t.body].joint;
            let rate =
                rate_between(&rest_of(step.model, t.body, &pose), &rest_of(step.model, t.body, &ahead));
            let wanted = t.rate.map_or(Vec3::zeros(), |before| (rate - before) / step.dt);
            t.acceleration += (wanted - t.acceleration) * (1.0 - (-step.dt / FILTER_S).exp());
            set_rate(joint, step.model.bodies[t.body].v_at, &t.acceleration, &mut self.vd);
            t.rate = Some(rate);
        }
        self.state.update(step.model, step.q, step.v);
        self.state.inverse_dynamics(step.model, step.v, &self.vd, &[], &mut self.tau);
        for t in &self.chain {
            let b = &step.model.bodies[t.body];
            let Drive { stiffness, damping, .. } = drives[t.body];
            let rate = t.rate.unwrap_or_else(Vec3::zeros);
            let load = -joint_force(&b.joint, &self.tau, b.v_at) - rate * damping;
            let target = Rest::ball(skeleton.rotation(&pose, t.link));
            let rest = step.set_points[t.body].rest(&target, load, stiffness);
            drives[t.body].rest = drives[t.body].rest.blend(&rest, weight);
        }
        let turn = aim.up * (aim.trunk * weight / self.reach.spine.len().max(1) as f64);
        for s in &self.reach.spine {
            if let Rest::Ball { target, .. } = &mut drives[s.body].rest {
                let turned = exp(&in_zero_frame(&self.state, s.body, &turn)) * *target;
                *target = s.limits.as_ref().map_or(turned, |l| l.clamp(&turned));
            }
        }
        (self.pose, self.ahead, self.goal) = (pose, ahead, goal);
        Ok(())
    }
}
