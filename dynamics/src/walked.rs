//! Whether a body that steps kept its feet, and how it walked.
//!
//! In: a [`Trace`] of a body over ground. Out: a [`Walked`].
//!
//! *Kept its feet*, of every row: the root (of a body that stands on its root, as a lamp on its plate: the centre of mass) is at least [`HIGH`] of the
//! height asked for, turned by at most [`TILT_DEG`] from what is asked and
//! within [`PATH_M`] of it along the ground; nothing but what stands by the plan carries more than [`CARRIES`] of the weight; no wrench holds
//! the root. Feet stand by the plan, and what the motion asked for brings to the ground (`dynamics::fall`).
//!
//! *A stance* is a time in which a foot carries at least [`STANDS`] of the weight; its slip is the way of its loaded points over the ground,
//! weighted by their load. Stances shorter than [`LEAST_S`] are touches.

use std::fmt;

use motion::rotation::log;
use motion::skeleton::vec_at;
use motion::{Joint, Vec3};

use crate::{ContactSample, Model, State, Trace, fall};

/// Part of the root's height asked for that it keeps.
pub const HIGH: f64 = 0.8;
/// Largest turn of the root from what is asked, degrees.
pub const TILT_DEG: f64 = 45.0;
/// Largest distance along the ground from what is asked, m.
pub const PATH_M: f64 = 0.5;
/// Part of the weight beyond which a link that is not planned to stand carries.
pub const CARRIES: f64 = 0.05;
/// Part of the weight from which a foot stands.
pub const STANDS: f64 = 0.1;
/// Shortest stance, s.
pub const LEAST_S: f64 = 0.1;

/// Why a body did not keep its feet.
#[derive(Clone, Debug, PartialEq)]
pub enum Loss {
    /// Its root came too low: part of the height asked for.
    Low(f64),
    /// It turned: degrees from what is asked.
    Tilted(f64),
    /// It went elsewhere: m from what is asked.
    Away(f64),
    /// Something else carried it: the link, and the part of the weight.
    Carried(String, f64),
    /// It was held: N.
    Held(f64),
    /// The run ended before the motion.
    Ended,
}

impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Low(x) => write!(f, "root at {:.0} % of its height", 100.0 * x),
            Self::Tilted(x) => write!(f, "root tilted by {x:.0}°"),
            Self::Away(x) => write!(f, "{x:.2} m from its path"),
            Self::Carried(link, x) => write!(f, "`{link}` carries {:.0} % of the weight", 100.0 * x),
            Self::Held(x) => write!(f, "held by {x:.1} N"),
            Self::Ended => write!(f, "the run ended"),
        }
    }
}

/// How a body walked. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Walked {
    /// When and how it lost its feet; `None` if it kept them to the end.
    pub lost: Option<(f64, Loss)>,
    /// How long it kept them, s.
    pub kept_s: f64,
    /// RMS distance of link centres of mass from those asked for, while it kept its feet, mm.
    pub links_mm: f64,
    /// RMS turn of its joints from those asked for, degrees.
    pub joints_deg: f64,
    /// While it kept its feet: the largest distance of the root along the ground from where it is asked, m.
    pub away_m: f64,
    /// Length of the way that is asked of the root along the ground in that time, m.
    pub way_m: f64,
    /// Slip of every stance, mm, in order of their beginnings.
    pub slips_mm: Vec<f64>,
    /// RMS of the force that nothing explains, % of the weight.
    pub unexplained: f64,
    /// RMS acceleration of the joints, rad/s².
    pub acceleration: f64,
    /// Largest total vertical force over 20 ms, in weights.
    pub peak: f64,
}

impl Walked {
    /// The largest slip of a stance, mm; zero without any.
    pub fn slip_mm_max(&self) -> f64 {
        self.slips_mm.iter().fold(0.0, |a, b| a.max(*b))
    }

    /// Measures a trace of a motion that has `rows` rows.
    ///
    /// A trace of a single row, or none, is one of a body that kept its feet for no time.
    pub fn of(trace: &Trace, rows: usize) -> Self {
        let model = Model::new(&trace.character, trace.gravity);
        let weight = model.mass * trace.gravity.norm();
        let mut feet: Vec<usize> = trace.character.legs().map(|l| model.body_of[l.end].0).collect();
        if feet.is_empty() {
            feet = trace.character.soles().iter().map(|s| model.body_of[s.link].0).collect();
        }
        let mut lost = None;
        let mut kept = 0;
        let mut state = State::new(&model);
        for row in 0..trace.rows() {
            if let Some(loss) = loss(trace, &model, &mut state, &feet, weight, row) {
                lost = Some((row as f64 / trace.rate_hz, loss));
                break;
            }
            kept = row;
        }
        if lost.is_none() && trace.rows() < rows {
            lost = Some((kept as f64 / trace.rate_hz, Loss::Ended));
        }
        let (links_mm, joints_deg) = differences(trace, &model, kept);
        let (away_m, way_m) = drift(trace, &model, kept);
        let mut walked = Self {
            lost,
            away_m,
            way_m,
            kept_s: kept as f64 / trace.rate_hz,
            links_mm,
            joints_deg,
            slips_mm: slips(trace, &model, &feet, weight, kept),
            unexplained: 0.0,
            acceleration: 0.0,
            peak: 0.0,
        };
        let of = |sum: f64, n: usize| (sum / n.max(1) as f64).sqrt();
        let force: f64 =
            trace.residual().chunks_exact(6).take(kept).map(|w| vec_at(w, 0).norm_squared()).sum();
        walked.unexplained = 100.0 * of(force, kept) / weight;
        let nv = model.nv();
        let joints = if matches!(model.bodies[0].joint, Joint::Free) { 6..nv } else { 0..nv };
        let mut sum = 0.0;
        for row in 1..=kept {
            for k in joints.clone() {
                sum += ((trace.v[row * nv + k] - trace.v[(row - 1) * nv + k]) * trace.rate_hz).powi(2);
            }
        }
        walked.acceleration = of(sum, kept * joints.len());
        let sums = trace.contact_sums();
        let width = ((0.02 * trace.rate_hz).round() as usize).max(1);
        let means = sums[..(kept + 1).min(sums.len())].windows(width);
        let means = means.map(|w| w.iter().map(|f| f.y).sum::<f64>() / width as f64);
        walked.peak = means.fold(0.0, f64::max) / weight;
        walked
    }

    /// Mean slip of a stance, mm; zero without stances.
    pub fn slip_mm(&self) -> f64 {
        self.slips_mm.iter().fold(0.0, |sum, x| sum + x) / self.slips_mm.len().max(1) as f64
    }
}

/// What is lost in a row; `state` is scratch.
fn loss(
    trace: &Trace,
    model: &Model,
    state: &mut State,
    feet: &[usize],
    weight: f64,
    row: usize,
) -> Option<Loss> {
    let held = vec_at(&trace.root_wrench, 6 * row).norm() + vec_at(&trace.root_wrench, 6 * row + 3).norm();
    if held > 0.0 {
        return Some(Loss::Held(held));
    }
    // what links do to each other holds nobody up
    let here = trace.contacts_in(row);
    let outside = || here.iter().filter(|c| c.against.is_world());
    for c in outside() {
        let body = model.body_of[c.link].0;
        let total: f64 = outside().filter(|o| model.body_of[o.link].0 == body).map(|o| o.force.norm()).sum();
        if total > CARRIES * weight && !feet.contains(&body) && !fall::is_asked(trace, row, c) {
            let name = trace.character.skeleton.links()[c.link].name.clone();
            return Some(Loss::Carried(name, total / weight));
        }
    }
    if !matches!(model.bodies[0].joint, Joint::Free) {
        return None;
    }
    let skeleton = &model.skeleton;
    let (q, goal) = (trace.pose(row), trace.target_pose(row));
    let (at, asked) = (skeleton.position(q, 0), skeleton.position(goal, 0));
    let [of, from] = if feet.contains(&0) {
        [q, goal].map(|q| {
            state.update_pose(model, q);
            state.com(model)
        })
    } else {
        [at, asked]
    };
    let high = trace.height(row, &of) / trace.height(0, &from).max(1e-9);
    if high < HIGH {
        return Some(Loss::Low(high));
    }
    let turn = log(&(skeleton.rotation(q, 0) * skeleton.rotation(goal, 0).inverse())).norm().to_degrees();
    if turn > TILT_DEG {
        return Some(Loss::Tilted(turn));
    }
    let away = (at - asked).xz().norm();
    (away > PATH_M).then_some(Loss::Away(away))
}

/// Largest distance of the root along the ground from where it is asked, and the length of the way asked for, rows 0 to `kept`, m; zeros of
/// a root that does not move freely.
fn drift(trace: &Trace, model: &Model, kept: usize) -> (f64, f64) {
    if !matches!(model.bodies[0].joint, Joint::Free) || trace.rows() == 0 {
        return (0.0, 0.0);
    }
    let at = |q: &[f64]| model.skeleton.position(q, 0).xz();
    let mut before = at(trace.target_pose(0));
    let (mut away, mut way) = (0.0_f64, 0.0);
    for row in 0..=kept {
        let asked = at(trace.target_pose(row));
        way += (asked - before).norm();
        away = away.max((at(trace.pose(row)) - asked).norm());
        before = asked;
    }
    (away, way)
}

/// RMS distance of link centres (mm) and turn of joints (degrees) from what is asked, rows 1 to `kept`.
fn differences(trace: &Trace, model: &Model, kept: usize) -> (f64, f64) {
    let c = &trace.character;
    let still = vec![0.0; model.nv()];
    let mut state = State::new(model);
    let massive: Vec<usize> = (0..c.bodies.len()).filter(|&l| c.bodies[l].mass > 0.0).collect();
    let (mut links, mut joints, mut n) = (0.0, 0.0, 0);
    let mut turn = vec![0.0; model.nv()];
    for row in 1..=kept {
        state.update(model, trace.target_pose(row), &still);
        for &l in &massive {
            links += apart(trace, model, &state, row, l).norm_squared();
            n += 1;
        }
        c.skeleton.difference(trace.target_pose(row), trace.pose(row), 1.0, &mut turn);
        joints += turn.iter().skip(6).map(|x| x * x).sum::<f64>();
    }
    let of = |sum: f64, n: usize| (sum / n.max(1) as f64).sqrt();
    let jointed = model.bodies.iter().skip(1).filter(|b| b.joint.nv() > 0).count();
    (1e3 * of(links, n), of(joints, kept * jointed).to_degrees())
}

/// Where the centre of mass of a link is in `row`, from where it is in `asked`, m.
pub(crate) fn apart(trace: &Trace, model: &Model, asked: &State, row: usize, link: usize) -> Vec3 {
    let bodies = &trace.character.bodies;
    vec_at(&trace.link_com, 3 * (row * bodies.len() + link)) - asked.point(model, link, &bodies[link].com)
}

/// Slip of every stance, mm.
fn slips(trace: &Trace, model: &Model, feet: &[usize], weight: f64, kept: usize) -> Vec<f64> {
    let mut state = State::new(model);
    // per foot: since when it stands and how far it slid
    let mut now: Vec<Option<(usize, f64)>> = vec![None; feet.len()];
    let mut all: Vec<(usize, f64)> = Vec::new();
    let least = (LEAST_S * trace.rate_hz).round() as usize;
    let nv = model.nv();
    for row in 0..=kept.min(trace.rows().saturating_sub(1)) {
        let contacts = trace.contacts_in(row);
        state.update(model, trace.pose(row), &trace.v[row * nv..(row + 1) * nv]);
        for (foot, now) in feet.iter().zip(&mut now) {
            let (mut load, mut way) = (0.0, Vec3::zeros());
            let of_foot = |c: &&ContactSample| c.against.is_world() && model.body_of[c.link].0 == *foot;
            for c in contacts.iter().filter(of_foot) {
                let b = &state.bodies[*foot];
                let velocity = b.velocity + b.omega.cross(&(c.point - b.origin()));
                load += c.force.y.max(0.0);
                way += Vec3::new(velocity.x, 0.0, velocity.z) * c.force.y.max(0.0);
            }
            if load >= STANDS * weight {
                let (_, slid) = now.get_or_insert((row, 0.0));
                *slid += way.norm() / load / trace.rate_hz;
            } else if let Some((since, slid)) = now.take().filter(|(since, _)| row - since >= least) {
                all.push((since, slid));
            }
        }
    }
    all.extend(now.into_iter().flatten().filter(|(since, _)| kept - since >= least));
    all.sort_by_key(|(since, _)| *since);
    all.into_iter().map(|(_, slid)| 1e3 * slid).collect()
}
