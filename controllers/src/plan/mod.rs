//! Plan: everything about a motion that is known before the first step.
//!
//! In: a [`Setup`], and what the body will carry. Out: a [`Plan`], complete when it is made: the stiffness scale of the
//! scene, the loads of its poses, for scripts every redirection of every joint, for clips what the moving goal needs of
//! the ground. [`crate::Controller`] steps it. No state, no engine; time is the row of the goal. DESIGN §4.
//!
//! | file | holds |
//! |---|---|
//! | `needs` | what holding the goal's poses takes |
//! | [`dense`] | joints of a script performed as a dense clip |
//! | `script` | the transitions of a script: start, redirections, where they sag |

pub mod dense;
mod needs;
mod script;

use std::sync::Arc;

use bodies::Character;
use dynamics::conditions::LEAST_GRAVITY;
use dynamics::{Carrying, Model, State};
use motion::plant::Plant;
use motion::{ContactPlan, Range, Tracks, Vec3};

use crate::antagonist::SetPoints;
use crate::balance::{BalanceSettings, leg_bodies};
use crate::feed::{self, Feed};
use crate::reactive::Impedance;
use crate::shift::allowance;
use crate::support::Foot;
use crate::tension::{Need, StanceLeg, TensionScale};
use crate::transition::{GainBlend, Transition};
use crate::{Goal, Rest, rest_of};

use dense::Dense;
use needs::PoseNeeds;
pub(crate) use script::Redirection;
use script::ScriptPlanner;

/// What a plan is made from.
#[derive(Clone)]
pub struct Setup {
    /// The body.
    pub character: Arc<Character>,
    /// Gravity, world, m/s².
    pub gravity: Vec3,
    /// The motion asked for, limits applied, at the control rate.
    pub goal: Goal,
    /// The transition elements behind the goal; `None` for a clip.
    pub tracks: Option<Tracks>,
    /// Joints of `tracks` that an edit of the sampled motion changed: they follow the goal as those of a clip do. Without
    /// tracks: tension over time of the joints named.
    pub dense: Dense,
    /// Factor on every tension.
    pub tension: f64,
    /// Feet that stand throughout; empty when the root is pinned.
    pub plants: Vec<Plant>,
    /// Height of the ground that carries the body, m; `None` when the root is pinned or hangs in the air.
    pub ground_m: Option<f64>,
    /// Which feet stand when, each named by its leg, in a motion that is performed by looking ahead: the load of the ground is fed
    /// forward to these. Empty: to the feet that are near the ground and slow.
    pub contacts: ContactPlan,
    /// Parameters of the balance property.
    pub balance: BalanceSettings,
    /// What transitions interpolate.
    pub blend: GainBlend,
}

/// A joint whose muscles are too slack for what they were asked to hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Sagging {
    /// Link of the joint.
    pub link: usize,
    /// When it begins, s.
    pub time_s: f64,
    /// How long it lasts, s; zero for a pose.
    pub lasts_s: f64,
    /// Stiffness given, N·m/rad.
    pub tension: f64,
    /// Least stiffness needed at the worst moment, N·m/rad.
    pub least: f64,
}

/// Tension of a joint of a stance leg that is not what was asked.
#[derive(Clone, Debug, PartialEq)]
pub struct LegTension {
    /// Link of the joint.
    pub link: usize,
    /// Tension asked for, 1 is natural.
    pub asked: f64,
    /// Tension used: what was asked, within the range in which legs stand.
    pub used: f64,
    /// Stiffness of tension 1, N·m/rad.
    pub natural: f64,
}

/// How a joint is driven.
#[expect(clippy::large_enum_variant, reason = "one per joint, most are transitions")]
#[derive(Clone, Debug)]
pub(crate) enum JointControl {
    /// A free root, a weld.
    Unactuated,
    /// Along the elements of a script.
    Transition(Transition),
    /// By feed-forward of the goal, every step.
    Tracked,
    /// By the balance property.
    StanceLeg,
}

/// The body with what it is known to carry, from a time on.
#[derive(Clone, Debug)]
pub(crate) struct ModelFrom {
    pub(crate) from_s: f64,
    pub(crate) model: Model,
}

/// Feet that stand throughout, and where.
#[derive(Clone, Debug)]
pub(crate) struct Planted {
    pub(crate) settings: BalanceSettings,
    pub(crate) feet: Vec<Foot>,
    pub(crate) plants: Vec<Plant>,
}

/// A motion, planned. See the module header.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The motion asked for.
    pub goal: Goal,
    /// Set points per body.
    pub set_points: Vec<SetPoints>,
    /// Stiffness scale of the scene.
    pub scale: TensionScale,
    /// Stiffness and damping of every body's joint at the tension asked for; of stance legs at that used.
    pub impedances: Vec<Impedance>,
    /// Joints of stance legs whose tension is not what was asked.
    pub leg_tension: Vec<LegTension>,
    /// Feet of the character, standing or not.
    pub feet: Vec<Foot>,
    /// In order of time; the first from the beginning.
    pub(crate) models: Vec<ModelFrom>,
    /// Feet under the balance property; `None` where nothing is planted.
    pub(crate) planted: Option<Planted>,
    /// How every body's joint is driven at the start.
    pub(crate) joints: Vec<JointControl>,
    /// Redirections of transitions, in order of time.
    pub(crate) redirections: Vec<Redirection>,
    pub(crate) blend: GainBlend,
    /// Where transitions end too slack, in order of time.
    pub(crate) sagging: Vec<Sagging>,
    /// Ground under feet that come and go; `None` where balance or a pin carries the body.
    pub(crate) ground_m: Option<f64>,
    /// The most of the load that each foot takes in every row, by the contacts planned; empty without a plan.
    pub(crate) bears: Vec<Vec<f64>>,
    /// Vertical acceleration of the goal's centre of mass per row, m/s².
    pub(crate) lift: Vec<f64>,
    /// Tension over time of joints performed as a dense clip.
    dense: Dense,
    /// What a clip needs of the ground under planted feet, per row; empty for scripts.
    pub(crate) feeds: Vec<Option<Feed>>,
    /// Least stiffness for stability per body, at the rows planned for; for clips.
    stability: Vec<(usize, Vec<f64>)>,
}

/// Tension of stance legs is kept in this range: below they would not stand (T = 0.5 just does), above an
/// ankle answers a small error with more torque than the sole can pass on.
const LEG_TENSION: Range = Range { lo: 0.6, hi: 2.0 };

impl Plan {
    /// Plans the whole motion of a body that knows what it will carry, and when: scale, redirections, loads of all poses.
    ///
    /// Where gravity does not press the body on the ground ([`LEAST_GRAVITY`]) nothing can stand: feet are then limbs as
    /// others are.
    pub fn new(mut setup: Setup, known: &[Carrying]) -> Self {
        if -setup.gravity.y < LEAST_GRAVITY {
            setup.plants.clear();
            setup.ground_m = None;
        }
        let character = &setup.character;
        let models = models(character, setup.gravity, known);
        let model = &models[0].model;
        let links = character.skeleton.links();
        let set_points: Vec<SetPoints> =
            model.bodies.iter().map(|b| SetPoints::of(&b.joint, links[b.link].limits.as_ref())).collect();
        let feet = Foot::of(character, model);
        let standing: Vec<Foot> =
            setup.plants.iter().filter_map(|p| feet.iter().find(|f| f.limb == p.limb).cloned()).collect();
        let in_leg = leg_bodies(&standing, model);
        // planted feet share the weight; feet that come and go may each have to carry all of it
        let (carrying, share) = match (standing.len(), setup.ground_m) {
            (0, Some(_)) => (feet.clone(), 1.0),
            (n, _) => (standing.clone(), 1.0 / n.max(1) as f64),
        };
        let stance: Vec<StanceLeg> = carrying.iter().map(|f| StanceLeg::new(model, &f.limb, share)).collect();
        let mut needs = PoseNeeds::new(&setup.goal, &models, &set_points, stance, carrying);
        for t in planned_times(&setup, &models) {
            needs.at(t);
        }
        let poses: Vec<Vec<Need>> = needs.rows().map(|(_, needs)| needs.to_vec()).collect();
        let scale = TensionScale::new(model, &character.classes, needs.stance(), &poses);
        let (impedances, leg_tension) = impedances(&setup, model, &scale, &in_leg);

        let mut joints: Vec<JointControl> = (0..model.bodies.len())
            .map(|i| match rest_of(model, i, setup.goal.pose(0)) {
                Rest::None => JointControl::Unactuated,
                _ if in_leg.contains(&i) => JointControl::StanceLeg,
                _ => JointControl::Tracked,
            })
            .collect();
        let (mut redirections, mut sagging, mut stability) = (Vec::new(), Vec::new(), Vec::new());
        let least_stability = |needs: &PoseNeeds| {
            let of = |needs: &[Need]| needs.iter().map(|n| n.least_stability).collect();
            let mut all: Vec<(usize, Vec<f64>)> = needs.rows().map(|(row, needs)| (row, of(needs))).collect();
            all.sort_by_key(|(row, _)| *row);
            all
        };
        match &setup.tracks {
            Some(tracks) => {
                if !setup.dense.joints.is_empty() {
                    stability = least_stability(&needs);
                }
                let scripted = ScriptPlanner {
                    tracks,
                    factor: setup.tension,
                    dense: &setup.dense,
                    goal: &setup.goal,
                    models: &models,
                    set_points: &set_points,
                    scale: &scale,
                    needs,
                    sagging: Vec::new(),
                };
                (redirections, sagging) = scripted.plan(&mut joints);
            }
            None => stability = least_stability(&needs),
        }
        let stands = !standing.is_empty();
        let planned = feet.iter().any(|foot| setup.contacts.of(&foot.limb.name).next().is_some());
        // a plan of other points says nothing about feet
        let bears = if !planned {
            Vec::new()
        } else {
            let (rate_hz, rows) = (setup.goal.rate_hz, setup.goal.rows());
            feet.iter().map(|foot| allowances(&setup.contacts, &foot.limb.name, rate_hz, rows)).collect()
        };
        let feeds = match (stands, &setup.tracks, setup.ground_m) {
            (true, None, Some(ground_m)) => feed::feeds(model, &setup.goal, ground_m),
            _ => Vec::new(),
        };
        let lift =
            if stands { vertical_acceleration(model, &setup.goal) } else { vec![0.0; setup.goal.rows()] };
        Self {
            set_points,
            scale,
            impedances,
            leg_tension,
            feet,
            planted: stands.then_some(Planted {
                settings: setup.balance,
                feet: standing,
                plants: setup.plants,
            }),
            joints,
            redirections,
            blend: setup.blend,
            sagging,
            ground_m: if stands { None } else { setup.ground_m },
            bears,
            lift,
            dense: setup.dense,
            feeds,
            stability,
            goal: setup.goal,
            models,
        }
    }

    /// The most of the load that each foot takes in every row, by the contacts planned, in the order of [`Self::feet`]; empty without
    /// a plan.
    pub fn bears(&self) -> &[Vec<f64>] {
        &self.bears
    }

    /// Largest ω₀ dt/2 over the joints for a substep of `dt` s, and its body: what implicit integration
    /// adds to the damping ratio.
    pub fn added_damping(&self, dt: f64) -> (f64, usize) {
        (0..self.impedances.len())
            .filter(|&i| self.scale.inertia[i] > 0.0)
            .map(|i| ((self.impedances[i].stiffness / self.scale.inertia[i]).sqrt() * dt / 2.0, i))
            .fold((0.0, 0), |a, b| if b.0 > a.0 { b } else { a })
    }

    /// Factor on the tension of a tracked joint at the time of `row`.
    pub(crate) fn tension_at(&self, link: usize, row: usize) -> f64 {
        let joint = self.dense.joint(link);
        joint.map_or(1.0, |joint| joint.tension_at(row as f64 / self.goal.rate_hz))
    }

    /// Whether the muscles of a tracked joint tense as much as the motion needs.
    pub(crate) fn tenses(&self, link: usize) -> bool {
        self.dense.joint(link).is_some_and(|joint| joint.tenses)
    }

    /// How much of the clip a joint of the script follows at the time of `row`, 0 to 1.
    pub(crate) fn dense_level(&self, link: usize, row: usize) -> f64 {
        self.dense.joint(link).map_or(0.0, |joint| joint.level_at(row as f64 / self.goal.rate_hz))
    }

    /// Least stiffness for stability of a joint, at the planned pose before `row`.
    pub(crate) fn stability_need(&self, body: usize, row: usize) -> f64 {
        let at = self.stability.partition_point(|(r, _)| *r <= row);
        self.stability.get(at.saturating_sub(1)).map_or(0.0, |(_, least)| least[body])
    }
}

/// The most of the load that a foot takes in every row.
fn allowances(contacts: &ContactPlan, foot: &str, rate_hz: f64, rows: usize) -> Vec<f64> {
    let mut all = vec![0.0; rows];
    for contact in contacts.of(foot) {
        let span = contact.frames(rate_hz, rows);
        span.clone().for_each(|row| all[row] = allowance(&span, row, rate_hz, rows));
    }
    all
}

/// Times of the poses whose loads make the scale, s.
fn planned_times(setup: &Setup, models: &[ModelFrom]) -> Vec<f64> {
    let mut times: Vec<f64> = match &setup.tracks {
        Some(t) => t.elements().flat_map(|(_, e)| [e.start_s, e.arrives_s()]).collect(),
        None => Vec::new(),
    };
    if times.is_empty() {
        // a clip: a pose every 0.2 s, at most 100, so that planning takes less time than the simulation
        let n = (setup.goal.rows() as f64 / setup.goal.rate_hz / 0.2).ceil().clamp(1.0, 100.0);
        let length = (setup.goal.rows() - 1) as f64 / setup.goal.rate_hz;
        times = (0..=n as usize).map(|i| length * i as f64 / n).collect();
    }
    times.push(0.0);
    times.extend(models.iter().skip(1).map(|m| m.from_s));
    times
}

/// Impedance per body, and where that of a stance leg (a body of `in_leg`) is not of the tension asked for.
fn impedances(
    setup: &Setup,
    model: &Model,
    scale: &TensionScale,
    in_leg: &[usize],
) -> (Vec<Impedance>, Vec<LegTension>) {
    let mut leg_tension = Vec::new();
    let of = |(i, b): (usize, &dynamics::MovingBody)| {
        let asked = match &setup.tracks {
            // what is dense has its tension over time, the one before any element included
            Some(t) if in_leg.contains(&i) || setup.dense.joint(b.link).is_none() => {
                setup.tension * t.base_tension[b.link]
            }
            Some(_) | None => setup.tension,
        };
        let used = if in_leg.contains(&i) { asked.clamp(LEG_TENSION.lo, LEG_TENSION.hi) } else { asked };
        if used != asked {
            leg_tension.push(LegTension { link: b.link, asked, used, natural: scale.k1[i] });
        }
        let stiffness = used * scale.k1[i];
        Impedance { stiffness, damping: TensionScale::damping(stiffness, scale.inertia[i]) }
    };
    let all = model.bodies.iter().enumerate().map(of).collect();
    (all, leg_tension)
}

/// Vertical acceleration of the goal's centre of mass per row, m/s²: central second differences over ± 1/30 s, zero at
/// the ends.
fn vertical_acceleration(model: &Model, goal: &Goal) -> Vec<f64> {
    let rows = goal.rows();
    let still = vec![0.0; model.nv()];
    let mut state = State::new(model);
    let heights: Vec<f64> = (0..rows)
        .map(|row| {
            state.update(model, goal.pose(row), &still);
            state.com(model).y
        })
        .collect();
    let w = ((goal.rate_hz / 30.0).round() as usize).max(1);
    let scale = (goal.rate_hz / w as f64).powi(2);
    (0..rows)
        .map(|r| {
            if r < w || r + w >= rows {
                return 0.0;
            }
            (heights[r + w] - 2.0 * heights[r] + heights[r - w]) * scale
        })
        .collect()
}

/// The body with what it carries, from each time on at which that changes, s.
fn models(character: &Character, gravity: Vec3, known: &[Carrying]) -> Vec<ModelFrom> {
    let mut times: Vec<f64> = known.iter().flat_map(|c| [c.from_s, c.to_s]).collect();
    times.retain(|t| *t > 1e-9 && t.is_finite());
    times.sort_by(f64::total_cmp);
    times.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    let with = |from_s: f64| {
        let carried = known.iter().filter(|c| c.at(from_s)).map(|c| &c.what);
        ModelFrom { from_s, model: Model::new(&character.carrying(carried), gravity) }
    };
    std::iter::once(0.0).chain(times).map(with).collect()
}
