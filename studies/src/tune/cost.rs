//! The cost of a set of parameters: how a body does in the scene, and how it takes a few fixed pushes.
//!
//! In: a [`Take`], a [`TuneSpec`]. Out: per [`Tunable`] a [`Sample`]: the weighted sum of the terms
//!
//! | term | is, per run | scale |
//! |---|---|---|
//! | fall | 0 to 0.5 survived, by how near to failing; 0.6 to 1 not back in the end; 1 to 2 lost, by how soon | – |
//! | tracking | RMS angle of the joints above the stance legs against what was asked | 5° |
//! | effort | RMS of the muscle torques of all joints together | 0.25 m g h |
//! | overshoot | how far the centre of mass swings back beyond where it was, over the distance to the edge | 0.2 |
//! | smoothness | RMS jerk of the centre of mass, in steps of 1/30 s | g ω₀ / 4 |
//!
//! each the mean over the runs. All terms but `fall` are x/(1 + x) of their number over its scale, so that ½ is ordinary
//! and 1 the worst; a run that was lost counts as 1.
//!
//! A pushed run is one push for 0.1 s at the centre of mass, as in [`crate::push`], with an impulse that is a given part of
//! the physical limit. Limit, support and homes are those of the pose *asked for*: they are the same for every
//! candidate, and no run is spent on finding them. A run is lost, and stops, when the body falls, when a sole moved more
//! than 1 cm, or when the capture point is 15 cm outside the support: nothing stands up from there.
//!
//! How near to failing: the mean of (farthest sole / 1 cm), (centre of mass in the end / 2 cm) and the part of the margin
//! of the capture point that was used up. How soon: half by the time left when it was lost, half by how far outside
//! (of 10 cm) the capture point was. So a body that falls late costs less than one that falls at once.
//!
//! World frame, SI.

use controllers::{Parameter, Tunable};
use dynamics::{Model, Push, RootMode, State};
use motion::metrics::{joint_errors, joint_rms_deg};
use motion::support::{Support, Vec2, ground};
use motion::{Kinematics, Limb, Sole, Vec3};
use rayon::prelude::*;
use sim::{EngineEntry, PassError, Run};

use super::search::{Objective, Sample};
use super::{TuneError, TuneSpec};
use crate::level_ground::LevelGround;
use crate::push::{COM_AWAY_M, FOOT_MOVED_M, carrier, direction, limit_ns, to_edge};
use takes::Take;

/// Length of a push, s.
const PUSH_S: f64 = 0.1;
/// A capture point farther outside the support never comes back, m.
const BEYOND_M: f64 = 0.15;

/// A run that is costed.
struct Probe {
    /// The push; `None` for the scene as it is.
    push: Option<Push>,
    /// Horizontal unit vector of the push.
    way: Vec2,
    /// Row from which the run is watched.
    from: usize,
    /// Its last row.
    to: usize,
    /// Where the soles' middles are to stay, m.
    home: Vec<Vec3>,
    support: Support,
    /// Centre of mass of the pose asked for when the watch begins and when it ends, m.
    com: [Vec3; 2],
    /// Distance from the centre of mass to the edge (in the way of the push, or nearest), m.
    edge_m: f64,
    omega: f64,
}

/// What is minimised: see the module header.
pub struct Cost {
    take: Take,
    /// Where runs are simulated.
    engine: EngineEntry,
    base: Tunable,
    parameters: Vec<&'static Parameter>,
    weights: [f64; 5],
    probes: Vec<Probe>,
    /// Soles that are planted.
    soles: Vec<Sole>,
    /// Links of the stance legs.
    legs: Vec<usize>,
    /// m g h, N·m.
    load: f64,
    g: f64,
}

impl Cost {
    /// Prepares the runs.
    ///
    /// # Errors
    /// [`TuneError::Held`] for a body that does not stand on its feet by itself.
    pub fn new(take: &Take, spec: &TuneSpec, engine: &EngineEntry) -> Result<Self, TuneError> {
        let held = |what: &str| TuneError::Held { scene: take.name.clone(), what: what.into() };
        let mut take = take.clone();
        let base = take.tunable();
        if let Some(rate_hz) = spec.rate_hz {
            take.conditions.physics.rate_hz = Some(rate_hz);
        }
        if let Some(substeps) = spec.substeps {
            take.conditions.physics.substeps = Some(substeps);
        }
        let physics = take.conditions.physics;
        if physics.root != RootMode::Free {
            return Err(held("its root is held"));
        }
        let LevelGround { height_m: floor, gravity_m_s2: g } =
            LevelGround::of(&take.conditions).map_err(held)?;
        let character = take.body.character.clone();
        let model = Model::new(&character, physics.gravity);
        let planted = |leg: &Limb| take.asked.plants.iter().any(|p| p.limb == *leg);
        let feet = character.leg_soles().into_iter().filter(|(leg, _)| planted(leg));
        let (legs, soles): (Vec<[usize; 3]>, Vec<Sole>) =
            feet.map(|(leg, sole)| ([leg.upper, leg.lower, leg.end], sole)).unzip();
        if soles.is_empty() {
            return Err(held("no foot with a sole is planted"));
        }

        let rate = take.control_rate_hz();
        let row = |s: f64| (s * rate).round().max(1.0) as usize;
        let length = take.asked.clip.duration_s();
        let (at, steps) = (row(spec.push_at_s), row(PUSH_S));
        let end = at + steps + row(spec.after_s);
        let take = if spec.pushes.is_empty() { take } else { take.held_until(end as f64 / rate) };
        let goal = take.pass().setup.goal;
        let mut state = State::new(&model);
        let still = vec![0.0; model.nv()];
        let mut com = |row: usize| {
            state.update(&model, goal.pose(row), &still);
            state.com(&model)
        };
        let mut probe = |from: usize, to: usize, push: Option<(f64, f64)>| {
            let from_com = com(from);
            let k = Kinematics::new(&character.skeleton, goal.pose(from));
            let support = Sole::support(&soles, &k);
            let omega = (g / (from_com.y - floor).max(0.05)).sqrt();
            let mut made = Probe {
                push: None,
                way: Vec2::zeros(),
                from,
                to,
                home: soles.iter().map(|s| s.center(&k)).collect(),
                edge_m: support.margin(&ground(&from_com)),
                com: [from_com, com(to)],
                support,
                omega,
            };
            if let Some((deg, of_limit)) = push {
                made.way = ground(&direction(deg));
                made.edge_m = to_edge(&made.support, &ground(&from_com), &made.way).unwrap_or(0.0);
                let push_s = steps as f64 / rate;
                let impulse = of_limit * limit_ns(character.mass(), omega, made.edge_m, push_s);
                let link = carrier(&character, &k, &from_com);
                made.push = Some(Push {
                    link,
                    at: k.world[link].inverse().transform_point(&from_com.into()).coords,
                    force: direction(deg) * (impulse / push_s),
                    start_s: from as f64 / rate,
                    duration_s: push_s,
                });
            }
            made
        };
        let mut probes = Vec::new();
        if spec.own_run {
            probes.push(probe(0, (row(length)).min(goal.rows() - 1), None));
        }
        for push in &spec.pushes {
            probes.push(probe(at, end.min(goal.rows() - 1), Some((push.deg, push.of_limit))));
        }
        if probes.is_empty() {
            return Err(TuneError::Nothing { scene: take.name.clone() });
        }
        if probes.iter().any(|p| p.edge_m < 1e-3) {
            return Err(held("the centre of mass of a pose asked for is not over the feet"));
        }
        let height = probes[0].com[0].y - floor;
        Ok(Self {
            base,
            parameters: spec.parameters.clone(),
            weights: spec.weights,
            load: character.mass() * g * height,
            g,
            probes,
            soles,
            legs: legs.concat(),
            take,
            engine: engine.clone(),
        })
    }

    /// Name of the engine in which runs are simulated.
    pub fn engine(&self) -> &str {
        self.engine.name()
    }

    /// Runs that are costed.
    pub fn runs(&self) -> usize {
        self.probes.len()
    }

    /// The settings at a point of the unit cube.
    pub fn tunable(&self, u: &[f64]) -> Tunable {
        let mut t = self.base;
        for (p, u) in self.parameters.iter().zip(u) {
            p.set(&mut t, p.at(*u));
        }
        t
    }

    /// The settings with these values of the parameters searched.
    pub fn with_values(&self, values: &[f64]) -> Tunable {
        let mut t = self.base;
        for (p, x) in self.parameters.iter().zip(values) {
            p.set(&mut t, *x);
        }
        t
    }

    /// The settings with these parameters set, whether they are searched or not: names and values; a name that is none is passed over.
    pub fn with_named<'a>(&self, values: impl IntoIterator<Item = (&'a str, f64)>) -> Tunable {
        let mut t = self.base;
        for (name, x) in values {
            if let Some(p) = controllers::parameter(name) {
                p.set(&mut t, x);
            }
        }
        t
    }

    /// Costs one set of settings; runs go side by side.
    pub fn evaluate(&self, t: &Tunable) -> Sample {
        let take = self.take.with_tunable(t);
        let runs: Vec<([f64; 5], bool)> =
            self.probes.par_iter().with_max_len(1).map(|p| self.watch(&take, p)).collect();
        let n = runs.len() as f64;
        let terms: Vec<f64> = (0..5).map(|k| runs.iter().map(|r| r.0[k]).sum::<f64>() / n).collect();
        Sample {
            values: self.parameters.iter().map(|p| p.get(t)).collect(),
            cost: terms.iter().zip(&self.weights).map(|(t, w)| t * w).sum(),
            terms,
            survived: runs.iter().filter(|r| r.1).count(),
        }
    }

    /// One run: its terms, and whether it was survived. A run that cannot start counts as lost at its first row.
    fn watch(&self, take: &Take, probe: &Probe) -> ([f64; 5], bool) {
        self.run(take, probe).unwrap_or(([2.0, 1.0, 1.0, 1.0, 1.0], false))
    }

    fn run(&self, take: &Take, probe: &Probe) -> Result<([f64; 5], bool), PassError> {
        let mut pass = take.pass();
        pass.pushes.extend(probe.push.clone());
        let mut run = pass.start(&self.engine)?;
        let skeleton = &take.body.character.skeleton;
        let mut k = Kinematics::new(skeleton, run.trace().pose(0));
        let mass = take.body.character.mass();
        let (mut sole, mut least, mut back) = (0.0_f64, f64::INFINITY, 0.0_f64);
        let mut lost = None;
        while run.row() < probe.to && run.step()? {
            let row = run.row();
            if run.fell_s().is_some() {
                lost = Some(row);
                break;
            }
            if row <= probe.from {
                continue;
            }
            k.update(skeleton, run.trace().pose(row));
            let moved = self.soles.iter().zip(&probe.home).map(|(s, home)| (s.center(&k) - home).norm());
            sole = sole.max(moved.fold(0.0, f64::max));
            let (c, v) = center(&run, row, mass);
            least = least.min(probe.support.margin(&(c + v / probe.omega)));
            if probe.push.is_some() {
                back = back.max(-probe.way.dot(&(c - ground(&probe.com[0]))));
            }
            if sole > FOOT_MOVED_M || least < -BEYOND_M {
                lost = Some(row);
                break;
            }
        }
        if run.row() < probe.to {
            lost = lost.or(Some(run.row())); // diverged
        }
        if let Some(row) = lost {
            let length = (probe.to - probe.from) as f64;
            let early = 1.0 - (row.saturating_sub(probe.from)) as f64 / length;
            let outside = if least.is_finite() { (-least / 0.1).clamp(0.0, 1.0) } else { 1.0 };
            return Ok(([1.0 + 0.5 * early + 0.5 * outside, 1.0, 1.0, 1.0, 1.0], false));
        }
        let away = (run.trace().com_at(run.row()) - probe.com[1]).norm();
        let survived = away <= COM_AWAY_M;
        let used = (1.0 - least / probe.edge_m).clamp(0.0, 1.0);
        let fall = if survived {
            0.5 * (sole / FOOT_MOVED_M + away / COM_AWAY_M + used) / 3.0
        } else {
            0.6 + 0.4 * ((away - COM_AWAY_M) / 0.08).min(1.0)
        };
        let part = |x: f64| x / (1.0 + x);
        let tracking = self.tracking_deg(&run) / 5.0;
        let effort = effort(&run) / (0.25 * self.load);
        let overshoot = back / probe.edge_m / 0.2;
        let smoothness = jerk(&run, probe.from) / (0.25 * self.g * probe.omega);
        Ok(([fall, part(tracking), part(effort), part(overshoot), part(smoothness)], survived))
    }

    /// RMS over joints and rows of the angle between what was asked and done, degrees; stance legs left out: their
    /// angles are the balance's.
    fn tracking_deg(&self, run: &Run) -> f64 {
        let errors = joint_errors(&run.trace().target_clip(), &run.trace().clip());
        joint_rms_deg(errors.iter().filter(|e| !self.legs.contains(&e.link)))
    }
}

impl Objective for Cost {
    fn sample(&self, u: &[f64]) -> Sample {
        // the values as asked for: those converted from degrees to radians and back can differ in the last bit
        Sample { values: self.values(u), ..self.evaluate(&self.tunable(u)) }
    }

    fn values(&self, u: &[f64]) -> Vec<f64> {
        self.parameters.iter().zip(u).map(|(p, u)| p.at(*u)).collect()
    }
}

/// Centre of mass and its velocity over the ground, m and m/s.
fn center(run: &Run, row: usize, mass: f64) -> (Vec2, Vec2) {
    let t = run.trace();
    let momentum = &t.momentum[6 * row..];
    (ground(&t.com_at(row)), Vec2::new(momentum[0], momentum[2]) / mass)
}

/// RMS over the rows of the length of the muscle torques, N·m.
fn effort(run: &Run) -> f64 {
    let rows = run.row().max(1) as f64;
    (run.trace().torque.iter().map(|x| x * x).sum::<f64>() / rows).sqrt()
}

/// RMS jerk of the centre of mass from a row on, by third differences over 1/30 s, m/s³.
fn jerk(run: &Run, from: usize) -> f64 {
    let t = run.trace();
    let w = ((t.rate_hz / 30.0).round() as usize).max(1);
    let per = (t.rate_hz / w as f64).powi(3);
    let last = run.row();
    let mut sum = 0.0;
    let mut n = 0;
    for row in (from..(last + 1).saturating_sub(3 * w)).step_by(w) {
        let c = |i: usize| t.com_at(row + i * w);
        sum += ((c(3) - c(2) * 3.0 + c(1) * 3.0 - c(0)) * per).norm_squared();
        n += 1;
    }
    if n == 0 { 0.0 } else { (sum / f64::from(n)).sqrt() }
}
