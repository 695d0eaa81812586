//! Verdicts: how a motion was performed, in words and with numbers.
//!
//! In: the [`Trace`] of a run. Out: a [`Verdict`]: how it ended ([`Ending`]), and each [`Reason`] why it was not performed as
//! asked. Summary, report and studies say what is here and judge nothing by themselves.
//!
//! Only what was performed counts: the rows up to the fall. A reason has its number and the limit that it broke:
//!
//! | reason | broken when | why this limit |
//! |---|---|---|
//! | feet slid | a point of a sole that is down travels [`SLID_M`] farther than in the motion asked for | a still foot of captured motion creeps by 1 to 3 mm; 5 mm are seen in a figure that fills the picture |
//! | left the ground | a sole is [`fall::LIFTED_M`] higher than asked, or no foot bears load, for [`AIRBORNE_S`], where the motion asks for a foot on the ground | shorter is the play of a contact solver |
//! | landed hard | the ground pushes with [`HARD_BW`] body weights over [`HARD_S`] | walking takes 1.1 to 1.5, running 2 to 3 |
//! | joints at their stops | a joint is pressed against the end of its range ([`fall::STOP_NM`]) for [`STOP_S`] in all | a touch in passing limits nothing |
//! | far from asked | links are [`FAR_M`] RMS from where they were asked to be | a hand's breadth: another pose |
//! | momentum unexplained | of a free root, a force over [`UNEXPLAINED_S`] beyond [`UNEXPLAINED`] of the largest ground force and [`UNEXPLAINED_N`] | \[HUS15\]: beyond, a simulation explains nothing |
//! | keys ignored | keys of the script cannot act; the composer of the take knows which | – |
//!
//! \[HUS15\] Hicks, Uchida, Seth et al. Is my model good enough? Best practices for verification and validation of
//! musculoskeletal models and simulations of movement. J. Biomech. Eng. 137(2), 2015: residual forces up to 5 % of the peak
//! of the net external force.

use std::fmt;

use motion::metrics;
use motion::{Joint, Kinematics, Sole, Vec3};

use crate::conditions::LEAST_GRAVITY;
use crate::fall::{self, Fall};
use crate::feet::{self, lowest};
use crate::{Model, RootMode, RootName, Trace};

/// Travel of a standing foot beyond that asked for, m.
pub const SLID_M: f64 = 0.005;
/// Time off the ground, s.
pub const AIRBORNE_S: f64 = 0.05;
/// Ground force, body weights.
pub const HARD_BW: f64 = 3.0;
/// Time over which it is averaged, s: shorter peaks are of the contact law, not of the body.
pub const HARD_S: f64 = 0.02;
/// Time at the end of a range, s.
pub const STOP_S: f64 = 0.1;
/// RMS distance of the links, m.
pub const FAR_M: f64 = 0.1;
/// Unexplained force over the largest ground force.
pub const UNEXPLAINED: f64 = 0.05;
/// Time over which it is averaged, s: an error of one step that the next takes back moves nothing.
pub const UNEXPLAINED_S: f64 = 0.05;
/// Unexplained force that is always allowed, N: what is good for OpenSim.
pub const UNEXPLAINED_N: f64 = 10.0;
/// A verdict in one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grade {
    /// It did what was asked.
    AsAsked,
    /// It came to the end, but: see the reasons.
    But,
    /// It ends in the air.
    InFlight,
    /// It fell.
    Fell,
    /// The simulation failed.
    Failed,
}

impl Grade {
    /// As reports name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::AsAsked => "as asked",
            Self::But => "stands, but",
            Self::InFlight => "in flight",
            Self::Fell => "fell",
            Self::Failed => "failed",
        }
    }
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ending {
    /// On its feet.
    Stands,
    /// A body without legs, its root free: on these links, by name.
    Rests(Vec<String>),
    /// Its root was held: assisted or pinned.
    Held(RootName),
    /// Its root has a joint of its own to the world.
    Mounted,
    /// In the air.
    InFlight(Flight),
    /// On the ground.
    Fell(Fall),
    /// The simulation stopped: why.
    Failed(String),
}

/// A run that ends in the air.
#[derive(Clone, Debug, PartialEq)]
pub struct Flight {
    /// Since when nothing touches, s.
    pub from_s: f64,
    /// Why it does not stand.
    pub why: Airborne,
}

/// Why a body is in the air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Airborne {
    /// There is no ground.
    NoGround,
    /// Gravity does not press it on the ground.
    NoWeight,
    /// Its lowest contact point is so far above the ground, m.
    Above(f64),
}

/// What a reason is about.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// A foot travelled, mm: the link of its sole.
    FeetSlid(String),
    /// A foot was higher than asked, mm: its leg.
    FootLifted(String),
    /// No foot bore load, s.
    LeftGround,
    /// Ground force, body weights.
    LandedHard,
    /// A joint at the end of its range, s: its link, how many others, and the largest torque of its stop, N·m.
    AtStop {
        /// The joint.
        joint: String,
        /// Others beyond the limit.
        others: usize,
        /// Largest torque, N·m.
        torque_nm: f64,
    },
    /// RMS distance from the motion asked for, mm.
    FarFromAsked,
    /// Largest unexplained force, N.
    Unexplained,
    /// Keys that do not act: a sentence about each group; the value is their number.
    KeysIgnored(Vec<String>),
}

/// Why a motion was not performed as asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Reason {
    /// What it is about.
    pub what: What,
    /// Its number, in [`Reason::unit`].
    pub value: f64,
    /// The most that counts as asked.
    pub limit: f64,
    /// When, s; `None` of the whole run.
    pub at_s: Option<f64>,
}

impl Reason {
    /// Keys that do not act: a sentence about each group; `None` if there are none.
    pub fn ignored(sentences: Vec<String>) -> Option<Self> {
        let value = sentences.len() as f64;
        (value > 0.0).then_some(Self { what: What::KeysIgnored(sentences), value, limit: 0.0, at_s: None })
    }

    /// As reports name it.
    pub fn name(&self) -> &'static str {
        match self.what {
            What::FeetSlid(_) => "feet slid",
            What::FootLifted(_) | What::LeftGround => "left the ground",
            What::LandedHard => "landed hard",
            What::AtStop { .. } => "joints at their stops",
            What::FarFromAsked => "far from asked",
            What::Unexplained => "momentum unexplained",
            What::KeysIgnored(_) => "keys ignored",
        }
    }

    /// Unit of its number.
    pub fn unit(&self) -> &'static str {
        match self.what {
            What::FeetSlid(_) | What::FootLifted(_) | What::FarFromAsked => "mm",
            What::LeftGround | What::AtStop { .. } => "s",
            What::LandedHard => "body weights",
            What::Unexplained => "N",
            What::KeysIgnored(_) => "groups of keys",
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let x = self.value;
        match &self.what {
            What::FeetSlid(part) => write!(f, "{part} slid {x:.0} mm"),
            What::FootLifted(part) => write!(f, "the foot of {part} left the ground unasked, by {x:.0} mm"),
            What::LeftGround => write!(f, "it left the ground unasked for {x:.2} s"),
            What::LandedHard => write!(f, "it landed with {x:.1} × body weight"),
            What::AtStop { joint, others, torque_nm } => {
                write!(f, "{joint} was at the end of its range for {x:.1} s (up to {torque_nm:.0} N·m)")?;
                match others {
                    0 => Ok(()),
                    n => write!(f, ", and {n} more"),
                }
            }
            What::FarFromAsked => write!(f, "links were {x:.0} mm RMS from where they were asked to be"),
            What::Unexplained => {
                write!(f, "WARNING: {x:.0} N are unexplained, more than {:.0} N: do not trust it", self.limit)
            }
            What::KeysIgnored(sentences) => match &sentences[..] {
                [] => write!(f, "no keys are ignored"),
                [one] => write!(f, "{one}"),
                [first, more @ ..] => write!(f, "{first}; and {} more", more.len()),
            },
        }?;
        self.at_s.map_or(Ok(()), |t| write!(f, " at {t:.2} s"))
    }
}

/// How a motion was performed. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// How it ended.
    pub ending: Ending,
    /// Why it was not as asked, worst kind first.
    pub reasons: Vec<Reason>,
}

impl Verdict {
    /// Of the trace of a run and its fall ([`fall::of`]); `failed` says why the simulation stopped, if it did.
    pub fn of(trace: &Trace, fall: Option<Fall>, failed: Option<String>) -> Self {
        let model = Model::new(&trace.character, trace.gravity);
        let performed = fall.as_ref().map(|f| trace.cut(0..performed_rows(trace, f)));
        let t = performed.as_ref().unwrap_or(trace);
        let ending = match (failed, fall) {
            (Some(why), _) => Ending::Failed(why),
            (None, Some(fall)) => Ending::Fell(fall),
            (None, None) => ending(t, &model),
        };
        let in_flight = matches!(ending, Ending::InFlight(_));
        Self { reasons: reasons(t, &model, in_flight), ending }
    }

    /// In one word.
    pub fn grade(&self) -> Grade {
        match &self.ending {
            Ending::Failed(_) => Grade::Failed,
            Ending::Fell(_) => Grade::Fell,
            Ending::InFlight(_) => Grade::InFlight,
            _ if self.reasons.is_empty() => Grade::AsAsked,
            _ => Grade::But,
        }
    }
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stands => write!(f, "the body stands"),
            Self::Rests(links) => write!(f, "the body has no legs and rests on {}", links.join(", ")),
            Self::Held(root) => write!(f, "root {}", motion::names::Word::word(*root)),
            Self::Mounted => write!(f, "root mounted on the world"),
            Self::InFlight(Flight { from_s, why }) => {
                write!(f, "in flight from {from_s:.2} s: ")?;
                match why {
                    Airborne::NoGround => write!(f, "there is no ground"),
                    Airborne::NoWeight => write!(f, "no gravity presses it on the ground"),
                    Airborne::Above(m) => write!(f, "the ground is {m:.2} m below it"),
                }
            }
            Self::Fell(fall) => {
                write!(f, "THE BODY FELL at {:.2} s", fall.time_s)?;
                let cause = fall.cause().map(ToString::to_string);
                let all = cause.into_iter().chain(fall.triggers.iter().map(ToString::to_string));
                let all: Vec<String> = all.collect();
                if all.is_empty() { Ok(()) } else { write!(f, ": {}", all.join("; ")) }
            }
            Self::Failed(why) => write!(f, "FAILED, {why}"),
        }
    }
}

impl fmt::Display for Verdict {
    /// The whole headline.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.grade(), &self.ending) {
            (Grade::AsAsked, ending) => write!(f, "performed as asked, {ending}")?,
            (Grade::But, Ending::Held(_) | Ending::Mounted) => write!(f, "performed, {}", self.ending)?,
            (_, ending) => write!(f, "{ending}")?,
        }
        // of a fall its cause is said, not what a falling body does
        let fallen = matches!(self.ending, Ending::Fell(_) | Ending::Failed(_));
        let warns = |r: &&Reason| !fallen || matches!(r.what, What::Unexplained | What::KeysIgnored(_));
        for (i, reason) in self.reasons.iter().filter(warns).enumerate() {
            write!(f, "{}{reason}", if i == 0 { ", but " } else { "; " })?;
        }
        Ok(())
    }
}

/// Rows that were performed before a fall, that of the fall included.
pub fn performed_rows(trace: &Trace, fall: &Fall) -> usize {
    ((fall.time_s * trace.rate_hz).round() as usize + 1).clamp(1, trace.rows().max(1))
}

/// How a run ended that neither fell nor failed.
fn ending(t: &Trace, model: &Model) -> Ending {
    if !matches!(model.bodies[0].joint, Joint::Free) {
        return Ending::Mounted;
    }
    if t.root == RootMode::Pinned {
        return Ending::Held(RootName::Pinned);
    }
    let last = t.rows().saturating_sub(1);
    let touches = |c: &&crate::ContactSample| c.force.norm_squared() > 0.0;
    let touched = t.contacts.iter().rev().find(touches).map_or(0, |c| c.row);
    let airborne = (last - touched) as f64 / t.rate_hz;
    if airborne > AIRBORNE_S || (touched == 0 && last > 0) {
        let why = match t.ground_m {
            None => Airborne::NoGround,
            Some(_) if -t.gravity.y < LEAST_GRAVITY => Airborne::NoWeight,
            Some(_) => Airborne::Above(clearance(t, last)),
        };
        return Ending::InFlight(Flight { from_s: touched as f64 / t.rate_hz, why });
    }
    if t.root != RootMode::Free {
        return Ending::Held(t.root.name());
    }
    if t.character.leg_soles().is_empty() {
        let links = t.character.skeleton.links();
        let on = t.contacts.iter().filter(|c| c.row == touched && c.force.norm_squared() > 0.0);
        let mut names: Vec<String> = on.map(|c| links[c.link].name.clone()).collect();
        names.sort_unstable();
        names.dedup();
        return Ending::Rests(names);
    }
    Ending::Stands
}

/// Height of the lowest point of the body over the ground, m.
fn clearance(t: &Trace, row: usize) -> f64 {
    let c = &t.character;
    let k = Kinematics::new(&c.skeleton, t.pose(row));
    let down = -t.ground_up(row);
    let solids = c.bodies.iter().zip(&k.world).flat_map(|(b, w)| b.shapes.iter().map(|s| -s.reach(w, &down)));
    let origin = t.height(row, &Vec3::zeros());
    let sites = c.contacts.iter().map(|&i| &c.skeleton.sites()[i]);
    let sites = sites.map(|s| t.height(row, &k.point(s.link, &s.at)));
    solids.map(|x| x + origin).chain(sites).fold(f64::INFINITY, f64::min)
}

fn reasons(t: &Trace, model: &Model, in_flight: bool) -> Vec<Reason> {
    let mut all: Vec<Reason> = Vec::new();
    all.extend(unexplained(t));
    if t.ground_m.is_some() && !in_flight {
        all.extend(feet_slid(t));
        if t.root != RootMode::Pinned {
            all.extend(left_ground(t));
        }
        all.extend(landed_hard(t));
    }
    all.extend(at_stops(t, model));
    if t.root != RootMode::Pinned && !in_flight {
        all.extend(far_from_asked(t));
    }
    all
}

fn unexplained(t: &Trace) -> Option<Reason> {
    if t.root != RootMode::Free {
        return None; // the wrench of a holder is no error
    }
    let residual: Vec<Vec3> = t.residual().chunks_exact(6).map(|w| Vec3::new(w[0], w[1], w[2])).collect();
    let width = ((UNEXPLAINED_S * t.rate_hz).round() as usize).clamp(1, residual.len().max(1));
    let means = residual.windows(width).map(|w| w.iter().sum::<Vec3>().norm() / width as f64);
    let (row, value) = largest(means)?;
    let ground = t.contact_sums().iter().map(|f| f.norm()).fold(0.0, f64::max);
    let weight = t.character.mass() * t.gravity.norm();
    let limit = (UNEXPLAINED * ground.max(weight)).max(UNEXPLAINED_N);
    let at_s = Some(row as f64 / t.rate_hz);
    (value > limit).then_some(Reason { what: What::Unexplained, value, limit, at_s })
}

fn feet_slid(t: &Trace) -> Option<Reason> {
    let (performed, asked) = (feet::performed(t), feet::asked(t));
    let limit = asked.slip_mm_max + 1e3 * SLID_M;
    let c = &t.character;
    let site = c.contacts.get(performed.slip_point).map(|&i| &c.skeleton.sites()[i])?;
    let part = c.skeleton.links()[site.link].name.clone();
    let at_s = Some(performed.slip_frame as f64 / t.rate_hz);
    let value = performed.slip_mm_max;
    (value > limit).then_some(Reason { what: What::FeetSlid(part), value, limit, at_s })
}

/// Soles that the motion asked for has on the ground, higher than asked; and no load on any foot.
fn left_ground(t: &Trace) -> Vec<Reason> {
    let c = &t.character;
    let soles: Vec<(String, Sole)> =
        c.leg_soles().into_iter().map(|(limb, sole)| (limb.name.clone(), sole)).collect();
    if soles.is_empty() {
        return Vec::new();
    }
    let rows = t.rows();
    let (mut now, mut asked) =
        (Kinematics::new(&c.skeleton, t.pose(0)), Kinematics::new(&c.skeleton, t.pose(0)));
    let mut lifted = vec![vec![0.0; rows]; soles.len()];
    let mut airborne = vec![0.0; rows];
    let sums = t.contact_sums();
    for row in 0..rows {
        now.update(&c.skeleton, t.pose(row));
        asked.update(&c.skeleton, t.target_pose(row));
        let mut stands = false;
        for (s, (_, sole)) in soles.iter().enumerate() {
            let wanted = lowest(t, 0, sole.points(&asked));
            if wanted < fall::LIFTED_M {
                stands = true;
                lifted[s][row] = lowest(t, row, sole.points(&now)) - wanted.max(0.0);
            }
        }
        // row 0 has no forces yet
        airborne[row] = f64::from(u8::from(stands && row > 0 && sums[row].norm_squared() == 0.0));
    }
    let long = (AIRBORNE_S * t.rate_hz).round().max(1.0) as usize;
    let mut out = Vec::new();
    if let Some((start, _, rows)) = worst_span(&airborne, 0.5, long) {
        let (value, at_s) = (rows as f64 / t.rate_hz, Some(start as f64 / t.rate_hz));
        out.push(Reason { what: What::LeftGround, value, limit: AIRBORNE_S, at_s });
    }
    let spans = lifted.iter().map(|heights| worst_span(heights, fall::LIFTED_M, long));
    let worst = spans.enumerate().filter_map(|(s, span)| Some((s, span?)));
    if let Some((s, (start, height, _))) = worst.max_by(|a, b| a.1.1.total_cmp(&b.1.1)) {
        out.push(Reason {
            what: What::FootLifted(soles[s].0.clone()),
            value: 1e3 * height,
            limit: 1e3 * fall::LIFTED_M,
            at_s: Some(start as f64 / t.rate_hz),
        });
    }
    out
}

/// The span of at least `long` rows beyond `limit` in which the value is largest, longest of equals: first row, value, rows.
fn worst_span(values: &[f64], limit: f64, long: usize) -> Option<(usize, f64, usize)> {
    let mut best: Option<(usize, f64, usize)> = None;
    let mut row = 0;
    for run in values.chunk_by(|a, b| (*a > limit) == (*b > limit)) {
        let start = row;
        row += run.len();
        let largest = run.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let better = best.is_none_or(|(_, value, rows)| (largest, run.len()) > (value, rows));
        if largest > limit && run.len() >= long && better {
            best = Some((start, largest, run.len()));
        }
    }
    best
}

fn landed_hard(t: &Trace) -> Option<Reason> {
    let weight = t.character.mass() * t.gravity.norm();
    if weight <= 0.0 {
        return None;
    }
    let sums = t.contact_sums();
    let width = (HARD_S * t.rate_hz).round() as usize;
    let normals: Vec<f64> = sums.iter().enumerate().map(|(row, f)| f.dot(&t.ground_up(row))).collect();
    let width = width.clamp(1, normals.len().max(1));
    let means = normals.windows(width).map(|w| w.iter().sum::<f64>() / width as f64);
    let (row, force) = largest(means)?;
    let value = force / weight;
    let at_s = Some(row as f64 / t.rate_hz);
    (value > HARD_BW).then_some(Reason { what: What::LandedHard, value, limit: HARD_BW, at_s })
}

fn at_stops(t: &Trace, model: &Model) -> Option<Reason> {
    let nv = model.nv();
    let mut worst: Vec<(usize, usize, f64, usize)> = Vec::new(); // rows, first row, torque, link
    for b in &model.bodies {
        let (mut rows, mut first, mut torque) = (0, None, 0.0_f64);
        for row in 0..t.rows() {
            let at = row * nv + b.v_at;
            let x = t.stop_torque[at..at + b.joint.nv().min(3)].iter().map(|x| x * x).sum::<f64>().sqrt();
            if x > fall::STOP_NM {
                rows += 1;
                first = first.or(Some(row));
                torque = torque.max(x);
            }
        }
        if rows as f64 / t.rate_hz > STOP_S {
            worst.push((rows, first.unwrap_or(0), torque, b.link));
        }
    }
    worst.sort_by_key(|w| std::cmp::Reverse(w.0));
    let &(rows, first, torque_nm, link) = worst.first()?;
    let joint = t.character.skeleton.links()[link].name.clone();
    Some(Reason {
        what: What::AtStop { joint, others: worst.len() - 1, torque_nm },
        value: rows as f64 / t.rate_hz,
        limit: STOP_S,
        at_s: Some(first as f64 / t.rate_hz),
    })
}

fn far_from_asked(t: &Trace) -> Option<Reason> {
    let (value, limit) = (metrics::position_rms_mm(&t.clip(), &t.target_clip()), 1e3 * FAR_M);
    (value > limit).then_some(Reason { what: What::FarFromAsked, value, limit, at_s: None })
}

/// The largest of finite numbers and where it is; `None` of none.
fn largest(all: impl Iterator<Item = f64>) -> Option<(usize, f64)> {
    all.enumerate().filter(|x| x.1.is_finite()).max_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest excursion wins, not the longest; short ones do not count; nothing gives nothing.
    #[test]
    fn spans_are_judged_by_their_largest_value() {
        let x = [0.0, 2.0, 2.0, 2.0, 0.0, 9.0, 0.0, 3.0, 1.5, 0.0];
        assert_eq!(worst_span(&x, 1.0, 2), Some((7, 3.0, 2)));
        assert_eq!(worst_span(&x, 1.0, 1), Some((5, 9.0, 1)));
        assert_eq!(worst_span(&x, 1.0, 4), None);
        assert_eq!(worst_span(&[], 1.0, 1), None);
        assert_eq!(worst_span(&[0.0; 4], 0.0, 1), None);
        assert_eq!((largest([].into_iter()), largest([f64::NAN].into_iter())), (None, None));
    }
}
