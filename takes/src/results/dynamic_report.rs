//! The numbers of a motion performed, as `report.json` gives them under `dynamic`.
//!
//! In: a [`Take`] and its [`Outcome`]. Out: a [`DynamicReport`]. Every unit is in its field's name; forces and moments are in
//! the world frame, moments about the root's origin.

use bodies::JointClass;
use dynamics::{Against, RootMode, Trace};
use motion::Vec3;
use motion::metrics::{self, JointError};
use motion::names::Word;
use serde::Serialize;
use sim::Outcome;

use crate::Take;
use crate::results::disturbance_report::{FallReport, LegTensionReport};
use crate::results::feet::{FeetReport, feet};
use crate::results::foresight_report::ForesightReport;
use crate::results::gaze_report::GazeReport;
use crate::results::root_report::RootWrench;
use crate::results::soles_report::SolesReport;
use crate::results::touch_report::{TouchReport, touched};
use crate::results::verdict_report::VerdictReport;

/// The motion performed.
#[derive(Clone, Debug, Serialize)]
pub struct DynamicReport {
    /// How it was performed.
    pub verdict: VerdictReport,
    /// Time of the last step that counts, s: the end, the fall, or where the run stopped.
    pub performed_s: f64,
    /// Control steps per second, Hz.
    pub rate_hz: f64,
    /// Engine substeps per control step.
    pub substeps: usize,
    /// What the soles did under load; absent of rigid ones with toes welded to them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub soles: Option<SolesReport>,
    /// Factor on every tension.
    pub tension: f64,
    /// Simulated time over wall time.
    pub realtime_factor: f64,
    /// Whether the body fell.
    pub fell: bool,
    /// When, s.
    pub fell_at_s: Option<f64>,
    /// How, if it did.
    pub fall: Option<FallReport>,
    /// Why the run stopped early, if it did.
    pub diverged: Option<String>,
    /// RMS angle to the motion asked for, over all joints but wrists, degrees.
    pub joint_rms_deg: f64,
    /// The same without the joints of the legs, degrees.
    pub upper_body_rms_deg: f64,
    /// The joints furthest from what was asked, worst first.
    pub worst_joints: Vec<JointErrorReport>,
    /// RMS distance of the links' origins to the motion asked for, mm.
    pub position_rms_mm: f64,
    /// Damping ratio every joint is given.
    pub damping_ratio: f64,
    /// Largest ω₀ dt/2 that implicit integration adds to it.
    pub added_damping_ratio: f64,
    /// Stiffness of every joint at tension 1 and the least it needs.
    pub stiffness: Vec<StiffnessReport>,
    /// Least distance of the centre of mass inside the support, mm (negative outside); absent when
    /// nothing stands.
    pub support_margin_mm_min: Option<f64>,
    /// What held the root.
    pub root: RootReport,
    /// Foot numbers; null without ground.
    pub feet: Option<FeetReport>,
    /// Contact forces; all zero without ground.
    pub contact: ContactForceReport,
    /// Joints too slack for what they had to hold.
    pub sagging: Vec<SaggingReport>,
    /// Joints of stance legs whose tension is not what was asked: raised because less does not stand, or lowered
    /// because the soles cannot pass on more.
    pub leg_tension: Vec<LegTensionReport>,
    /// How far the eyes missed what they were to look at.
    pub gazes: Vec<GazeReport>,
    /// What programs of the user did as reactive properties, a line for each joint.
    pub reactive: Vec<String>,
    /// What foresight did and how the body walked; absent where it was not asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub foresight: Option<ForesightReport>,
    /// What the engine did beyond the equations of motion; absent of engines that do not count.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub engine: Option<EngineReport>,
}

/// What an engine did beyond the equations of motion, over the whole run.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct EngineReport {
    /// RMS of the force that its corrections of the root amount to, N.
    pub root_correction_rms_n: f64,
    /// That over body weight, %; null without weight.
    pub root_correction_rms_percent_bw: Option<f64>,
    /// Work of the corrections, J.
    pub root_correction_j: f64,
    /// Work of pushing points out of the ground, J.
    pub push_out_j: f64,
    /// Work of friction against the ground, J.
    pub friction_j: f64,
    /// Solutions of contacts.
    pub contact_solutions: u64,
    /// Those whose residual exceeds 1e-6 m g dt.
    pub above_1e6: u64,
    /// Those whose residual exceeds 1e-3 m g dt: not solved.
    pub unsolved: u64,
    /// Largest residual over m g dt.
    pub worst_residual: f64,
    /// Substeps taken in halves.
    pub halved: u64,
}

impl EngineReport {
    fn new(l: &sim::Ledger, rate_hz: f64, weight: f64) -> Self {
        let rms = l.correction_rms_n(rate_hz);
        Self {
            root_correction_rms_n: rms,
            root_correction_rms_percent_bw: percent(rms, weight),
            root_correction_j: l.correction_j,
            push_out_j: l.push_out_j,
            friction_j: l.friction_j,
            contact_solutions: l.touching,
            above_1e6: l.above_tight,
            unsolved: l.above_loose,
            worst_residual: l.worst_residual,
            halved: l.halved,
        }
    }
}

/// Stiffness of one joint.
#[derive(Clone, Debug, Serialize)]
pub struct StiffnessReport {
    /// Its name.
    pub joint: String,
    /// K₁: stiffness at tension 1, relaxed and natural, N·m/rad.
    pub natural_nm_rad: f64,
    /// Largest least stiffness over the poses of the scene, N·m/rad.
    pub least_nm_rad: f64,
}

/// How far one joint was from what was asked.
#[derive(Clone, Debug, Serialize)]
pub struct JointErrorReport {
    /// Its name.
    pub joint: String,
    /// RMS angle, degrees.
    pub rms_deg: f64,
    /// Largest angle, degrees.
    pub peak_deg: f64,
}

/// What held the root.
#[derive(Clone, Debug, Serialize)]
pub struct RootReport {
    /// `free`, `assisted` or `pinned`: [`dynamics::RootName`].
    pub mode: &'static str,
    /// Cut-off at which the motion of a pinned clip was smoothed for these numbers, Hz; null: as recorded.
    pub smoothed_at_hz: Option<f64>,
    /// Largest force that neither gravity nor contacts explain, N: of the assist, of the pin, or when free the
    /// error of the integrator.
    pub residual_force_peak_n: f64,
    /// RMS of that force, N.
    pub residual_force_rms_n: f64,
    /// Largest moment of that kind about the root's origin, N·m.
    pub residual_moment_peak_nm: f64,
    /// RMS of that moment, N·m.
    pub residual_moment_rms_nm: f64,
    /// Integral of that force's magnitude, N·s.
    pub impulse_ns: f64,
    /// Integral of that moment's magnitude, N·m·s.
    pub moment_impulse_nms: f64,
    /// RMS force over body weight, %; null without weight.
    pub residual_force_rms_percent_bw: Option<f64>,
    /// Peak force over body weight, %; null without weight.
    pub residual_force_peak_percent_bw: Option<f64>,
    /// The budget of an assisted root; null for others.
    pub budget: Option<BudgetReport>,
}

/// The budget of an assisted root.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct BudgetReport {
    /// Largest force allowed, N.
    pub force_n: f64,
    /// That over body weight, %; null without weight.
    pub force_percent_bw: Option<f64>,
    /// Largest moment allowed, N·m.
    pub moment_nm: f64,
    /// Share of the time at the force's limit, 0 to 1.
    pub force_at_limit: f64,
    /// Share of the time at the moment's limit, 0 to 1.
    pub moment_at_limit: f64,
}

/// Contact forces.
#[derive(Clone, Debug, Serialize)]
pub struct ContactForceReport {
    /// Mean vertical force, N.
    pub vertical_mean_n: f64,
    /// Mean vertical force over the last half second, % of the weight of the body and what it then carries; null without
    /// weight.
    pub vertical_end_percent_bw: Option<f64>,
    /// Largest vertical force, N.
    pub vertical_peak_n: f64,
    /// Largest ratio of friction to normal force at a foot carrying more than 5 % of body weight.
    pub friction_used_max: f64,
    /// What else than the ground was touched: props, and links by links; left out where nothing was.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub touched: Vec<TouchReport>,
}

/// A joint too slack for what it had to hold.
#[derive(Clone, Debug, Serialize)]
pub struct SaggingReport {
    /// The joint.
    pub joint: String,
    /// When it begins, s.
    pub time_s: f64,
    /// How long it lasts, s; 0 for an end pose.
    pub lasts_s: f64,
    /// Stiffness given, N·m/rad.
    pub tension_nm_rad: f64,
    /// Stiffness needed, N·m/rad.
    pub least_nm_rad: f64,
}

/// Joints listed as worst.
const WORST: usize = 5;
/// Slack shorter than this in a clip is not listed, s.
const BRIEF: f64 = 0.1;

impl DynamicReport {
    /// Numbers of a take and what came of it.
    pub fn new(take: &Take, o: &Outcome) -> Self {
        let t = &*o.performed();
        let c = &take.body.character;
        let clip = &t.clip();
        let target = t.target_clip();
        let errors = metrics::joint_errors(clip, &target);
        let counted: Vec<&JointError> =
            errors.iter().filter(|e| c.classes[e.link] != JointClass::Wrist).collect();
        let mut worst = counted.clone();
        worst.sort_by(|a, b| b.rms_deg.total_cmp(&a.rms_deg));
        let simulated = o.trace.rows().saturating_sub(1) as f64 / t.rate_hz;
        let foresight = ForesightReport::new(take, o);
        Self {
            verdict: VerdictReport::new(&take.verdict(o), foresight.as_ref()),
            performed_s: t.rows().saturating_sub(1) as f64 / t.rate_hz,
            rate_hz: t.rate_hz,
            substeps: t.substeps,
            soles: Some(take.soles()).filter(|s| !s.are_rigid()).map(|s| SolesReport::new(&s)),
            tension: take.conditions.physics.tension,
            realtime_factor: simulated / t.wall_s.max(1e-9),
            fell: o.fell_s.is_some(),
            fell_at_s: o.fell_s,
            fall: o.fall.as_ref().map(FallReport::new),
            diverged: o.diverged.as_ref().map(ToString::to_string),
            joint_rms_deg: metrics::joint_rms_deg(counted.iter().copied()),
            upper_body_rms_deg: metrics::joint_rms_deg(
                counted.iter().copied().filter(|e| !c.legs().any(|l| l.links().contains(&e.link))),
            ),
            worst_joints: worst
                .iter()
                .take(WORST)
                .map(|e| JointErrorReport {
                    joint: c.skeleton.links()[e.link].name.clone(),
                    rms_deg: e.rms_deg,
                    peak_deg: e.peak_deg,
                })
                .collect(),
            position_rms_mm: metrics::position_rms_mm(clip, &target),
            damping_ratio: controllers::tension::DAMPING_RATIO,
            added_damping_ratio: o.added_damping.0,
            stiffness: o
                .stiffness
                .iter()
                .map(|&(link, natural, least)| StiffnessReport {
                    joint: c.skeleton.links()[link].name.clone(),
                    natural_nm_rad: natural,
                    least_nm_rad: least,
                })
                .collect(),
            support_margin_mm_min: support_margin(t),
            root: root(take, t, c.mass()),
            // a clip whose root is pinned touches no ground
            feet: t
                .ground_m
                .map_or_else(|| feet(take, clip), |_| Some(dynamics::feet::performed(t)))
                .map(FeetReport::from),
            contact: contact(t),
            sagging: sagging(take, o),
            leg_tension: o
                .leg_tension
                .iter()
                .map(|l| LegTensionReport {
                    joint: c.skeleton.links()[l.link].name.clone(),
                    asked: l.asked,
                    used: l.used,
                    asked_nm_rad: l.asked * l.natural,
                    used_nm_rad: l.used * l.natural,
                })
                .collect(),
            gazes: GazeReport::of(&take.conditions.gazes, t),
            reactive: o.reactive.clone(),
            foresight,
            engine: o.ledger.as_ref().map(|l| EngineReport::new(l, t.rate_hz, c.mass() * t.gravity.norm())),
        }
    }
}

fn sagging(take: &Take, o: &Outcome) -> Vec<SaggingReport> {
    let links = take.body.character.skeleton.links();
    let listed = o.sagging.iter().filter(|s| take.asked.tracks.is_some() || s.lasts_s >= BRIEF);
    listed
        .map(|s| SaggingReport {
            joint: links[s.link].name.clone(),
            time_s: s.time_s,
            lasts_s: s.lasts_s,
            tension_nm_rad: s.tension,
            least_nm_rad: s.least,
        })
        .collect()
}

/// Least margin of the centre of mass in the hull of the loaded contact points, mm.
fn support_margin(t: &Trace) -> Option<f64> {
    let mut least: Option<f64> = None;
    let mut i = 0;
    while i < t.contacts.len() {
        let row = t.contacts[i].row;
        let end = i + t.contacts[i..].iter().take_while(|c| c.row == row).count();
        let outside = t.contacts[i..end].iter().filter(|c| c.against.is_world());
        let points: Vec<Vec3> = outside.map(|c| c.point).collect();
        i = end;
        if points.is_empty() {
            continue;
        }
        let support = motion::Support::of(points.iter());
        let margin = 1e3 * support.margin(&motion::support::ground(&t.com_at(row)));
        least = Some(least.map_or(margin, |m| m.min(margin)));
    }
    least.filter(|m| m.is_finite())
}

fn root(take: &Take, t: &Trace, mass: f64) -> RootReport {
    let part = |w: &[f64], at| motion::skeleton::vec_at(w, at);
    let RootWrench { wrench, rate_hz, cutoff_hz } = RootWrench::of(take, t);
    let residual: Vec<(Vec3, Vec3)> = wrench.chunks_exact(6).map(|w| (part(w, 0), part(w, 3))).collect();
    // row 0 of a recorded wrench is the start: nothing has acted yet
    let n = residual.len().saturating_sub(usize::from(cutoff_hz.is_none())).max(1) as f64;
    let (force, moment): (Vec<f64>, Vec<f64>) = residual.iter().map(|(f, m)| (f.norm(), m.norm())).unzip();
    let rms = |x: &[f64]| (x.iter().map(|x| x * x).sum::<f64>() / n).sqrt();
    let peak = |x: &[f64]| x.iter().copied().fold(0.0, f64::max);
    let sum = |x: &[f64]| x.iter().sum::<f64>() / rate_hz;
    let percent = |x: f64| percent(x, mass * t.gravity.norm());
    let at_limit = |x: &[f64], most: f64| x.iter().filter(|x| **x >= most * (1.0 - 1e-9)).count() as f64 / n;
    let budget = match t.root {
        RootMode::Assisted { force_n, moment_nm } => Some(BudgetReport {
            force_n,
            force_percent_bw: percent(force_n),
            moment_nm,
            // row 0 is the start: nothing has acted yet
            force_at_limit: at_limit(&force[1.min(force.len())..], force_n),
            moment_at_limit: at_limit(&moment[1.min(moment.len())..], moment_nm),
        }),
        RootMode::Free | RootMode::Pinned => None,
    };
    RootReport {
        mode: t.root.name().word(),
        smoothed_at_hz: cutoff_hz,
        residual_force_peak_n: peak(&force),
        residual_force_rms_n: rms(&force),
        residual_moment_peak_nm: peak(&moment),
        residual_moment_rms_nm: rms(&moment),
        impulse_ns: sum(&force),
        moment_impulse_nms: sum(&moment),
        residual_force_rms_percent_bw: percent(rms(&force)),
        residual_force_peak_percent_bw: percent(peak(&force)),
        budget,
    }
}

/// A force over a weight, %; `None` without weight.
pub(crate) fn percent(force: f64, weight: f64) -> Option<f64> {
    (weight > 0.0).then(|| 100.0 * force / weight)
}

fn contact(t: &Trace) -> ContactForceReport {
    let sums = t.contact_sums();
    let weight = t.character.mass() * t.gravity.norm();
    let rows = sums.len();
    let mean = |s: &[Vec3]| s.iter().map(|f| f.y).sum::<f64>() / s.len().max(1) as f64;
    let last = ((0.5 * t.rate_hz) as usize).max(1).min(rows);
    let mut used: f64 = 0.0;
    let mut i = 0;
    while i < t.contacts.len() {
        let (row, link) = (t.contacts[i].row, t.contacts[i].link);
        let mut sum = Vec3::zeros();
        while i < t.contacts.len() && t.contacts[i].row == row && t.contacts[i].link == link {
            // a prop has a slope of its own
            if t.contacts[i].against == Against::Ground {
                sum += t.contacts[i].force;
            }
            i += 1;
        }
        let up = t.ground_up(row);
        let normal = sum.dot(&up);
        if weight > 0.0 && normal > 0.05 * weight {
            used = used.max((sum - up * normal).norm() / normal);
        }
    }
    ContactForceReport {
        // row 0 has no forces yet
        vertical_mean_n: mean(&sums[1.min(rows)..]),
        vertical_end_percent_bw: percent(
            mean(&sums[rows - last..]),
            t.mass_at(rows.saturating_sub(1)) * t.gravity.norm(),
        ),
        vertical_peak_n: sums.iter().map(|f| f.y).fold(0.0, f64::max),
        friction_used_max: used,
        touched: touched(t),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Ask, Engines};

    /// A run of one row, without weight or contact, has numbers: zeros, and null where a share of nothing is asked for.
    #[test]
    fn numbers_of_a_run_in_which_nothing_happened() {
        assert_eq!((percent(3.0, 0.0), percent(0.0, 0.0), percent(1.0, 4.0)), (None, None, Some(25.0)));
        let ron = "Scene(character: \"characters/human.ron\", rate_hz: 60, settle_s: 0.1,
            world: (gravity_m_s2: (0, 0, 0), ground: None))";
        let input = crate::Input::Text { ron: ron.into(), base: support::root().join("scenes") };
        let take = crate::open(input, &Ask::default()).unwrap();
        let mut out = take.outcome(&Engines::default(), &mut |_| {}).unwrap();
        for rows in [out.trace.rows(), 1] {
            out.trace = out.trace.cut(0..rows);
            let d = DynamicReport::new(&take, &out);
            let numbers = [
                d.joint_rms_deg,
                d.position_rms_mm,
                d.root.residual_force_rms_n,
                d.contact.vertical_mean_n,
                d.contact.friction_used_max,
            ];
            assert!(numbers.iter().all(|x| x.abs() < 1e-6), "{numbers:?}");
            assert_eq!((d.support_margin_mm_min, d.contact.vertical_end_percent_bw), (None, None));
            assert_eq!(
                (d.root.residual_force_rms_percent_bw, d.root.residual_force_peak_percent_bw),
                (None, None)
            );
        }
    }
}
