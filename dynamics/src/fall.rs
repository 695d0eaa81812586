//! Falls: whether a body fell, when, and which margin of balance was lost first.
//!
//! In: a [`Trace`] of a body whose root is not pinned. Out: a [`Fall`]. A fall is an outcome of a run like any
//! other; this is the story of it, from what the trace recorded and nothing else.
//!
//! *Fallen*: load or height outside the contact plan. Something that the motion asked for does not bring to the ground
//! carries more than [`CARRIES_N`]; or the body stands on the ground with its root lower than [`LOW`] of what was asked.
//! Feet may always carry. So may a point of a link that comes within [`NEAR_M`] of the ground in the motion asked for, then or in
//! the [`NEAR_S`] before: knees that kneel, hands of a cartwheel, the back of a sleeper. The same of props: what the motion asked for
//! brings near the prop that it touches may lean on it. What links do to each other is no load. A body in the air has not fallen yet.
//!
//! *Margins*, each with what losing it means. A margin counts as lost at the beginning of the last span of time in
//! which it is gone without a break longer than [`BREAK_S`] and which lasts until the fall; what came back is not a
//! cause. Only feet that stand in the first row count, only joints of legs and trunk.
//!
//! | margin | lost when |
//! |---|---|
//! | capture point | c + ċ/ω₀, ω₀ = √(g/h), is outside the support |
//! | centre of mass | c is outside the support |
//! | foot slipped | the middle of a sole is [`SLIPPED_M`] farther from its place on the ground than asked, and asked to stay |
//! | foot lifted | the lowest corner of a sole is [`LIFTED_M`] higher over the ground than asked |
//! | joint limit | the stop of a joint acts with more than [`STOP_NM`] |
//! | slack muscle | one of a joint's two springs would have to push: the other alone cannot hold the load |
//!
//! The support is the hull of the soles that are not lifted, seen from above (of all if all are).

use std::fmt;

use motion::skeleton::vec_at;
use motion::support::ground;
use motion::{Joint, Kinematics, Sole, Vec3};

use crate::trigger::{self, Trigger};
use crate::{Against, ContactSample, Model, RootMode, Trace};
use bodies::JointClass;

/// A link other than a foot that carries more than this has fallen on the ground, N.
pub const CARRIES_N: f64 = 20.0;
/// What comes this near to the ground in the motion asked for may carry load, m: a limb that touches has turned about its own
/// axis by its thickness. ...
pub const NEAR_M: f64 = 0.15;
/// ... until this much later, s: muscles lag.
pub const NEAR_S: f64 = 0.25;
/// Part of the root's height over the ground asked for below which the body has fallen.
pub const LOW: f64 = 0.6;
/// And by so much it has to be lower, m: the root of a lamp is its plate.
pub const LOWER_M: f64 = 0.05;
/// A margin back for longer than this was not lost for good, s.
pub const BREAK_S: f64 = 0.1;
/// A sole this much farther from its place than asked has slipped, m.
pub const SLIPPED_M: f64 = 0.01;
/// A sole this much higher than asked is lifted, m.
pub const LIFTED_M: f64 = 0.005;
/// A stop that acts with more is a joint at its limit, N·m.
pub const STOP_NM: f64 = 5.0;
/// A sole nearer to the ground than this in the first row stands, m.
const STANDS_M: f64 = 0.03;

/// A margin of balance. See the module header.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Margin {
    /// The capture point left the support.
    CapturePoint,
    /// The centre of mass left the support.
    CenterOfMass,
    /// A foot slipped.
    FootSlipped,
    /// A foot lifted.
    FootLifted,
    /// A joint came to the end of its range.
    JointLimit,
    /// A joint's muscles went slack.
    SlackMuscle,
}

impl Margin {
    /// As reports name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::CapturePoint => "capture point",
            Self::CenterOfMass => "centre of mass",
            Self::FootSlipped => "foot slipped",
            Self::FootLifted => "foot lifted",
            Self::JointLimit => "joint limit",
            Self::SlackMuscle => "slack muscle",
        }
    }
}

/// A margin that was lost and did not come back.
#[derive(Clone, Debug, PartialEq)]
pub struct Loss {
    /// Which.
    pub margin: Margin,
    /// When, s.
    pub time_s: f64,
    /// The leg of the foot, or the link of the joint.
    pub part: Option<String>,
}

impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let part = self.part.as_deref().unwrap_or("a joint");
        match self.margin {
            Margin::CapturePoint => write!(f, "the capture point left the support")?,
            Margin::CenterOfMass => write!(f, "the centre of mass left the support")?,
            Margin::FootSlipped => write!(f, "the foot of {part} slipped")?,
            Margin::FootLifted => write!(f, "the foot of {part} lifted")?,
            Margin::JointLimit => write!(f, "{part} came to the end of its range")?,
            Margin::SlackMuscle => write!(f, "a muscle of {part} went slack")?,
        }
        write!(f, " at {:.2} s", self.time_s)
    }
}

/// A fall. See the module header.
#[derive(Clone, Debug, PartialEq)]
pub struct Fall {
    /// When load or height was outside the contact plan, s.
    pub time_s: f64,
    /// Margins lost for good before it, in order of loss.
    pub losses: Vec<Loss>,
    /// What the motion or the world brought before it, in order of time.
    pub triggers: Vec<Trigger>,
}

impl Fall {
    /// The margin lost first.
    pub fn cause(&self) -> Option<&Loss> {
        self.losses.first()
    }

    /// When the first margin was lost, s; of a fall without one, the fall.
    pub fn first_s(&self) -> f64 {
        self.cause().map_or(self.time_s, |l| l.time_s)
    }
}

impl fmt::Display for Fall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "falls at {:.2} s", self.time_s)?;
        self.cause().map_or(Ok(()), |cause| write!(f, " after {cause}"))
    }
}

/// Whether the body has fallen in a row of a trace. See the module header.
pub fn fallen(trace: &Trace, model: &Model, row: usize) -> bool {
    let Some(ground) = trace.ground_m else { return false };
    let here: Vec<&ContactSample> = trace.contacts_in(row).iter().filter(|c| c.against.is_world()).collect();
    if here.iter().all(|c| c.force.norm() == 0.0) {
        return false; // in the air
    }
    let feet: Vec<usize> = trace.character.legs().map(|l| model.body_of[l.end].0).collect();
    let outside = |c: &&ContactSample| {
        c.force.norm() > CARRIES_N && !feet.contains(&model.body_of[c.link].0) && !is_asked(trace, row, c)
    };
    if here.into_iter().any(|c| outside(&c)) {
        return true;
    }
    if !matches!(model.bodies[0].joint, Joint::Free) {
        return false;
    }
    let height = |q: &[f64]| model.skeleton.position(q, 0).y - ground;
    let (now, asked) = (height(trace.pose(row)), height(trace.target_pose(row)));
    now < LOW * asked && now < asked - LOWER_M
}

/// Whether the motion asked for brings the point of a link that touches near the ground, about the time of a row.
pub(crate) fn is_asked(trace: &Trace, row: usize, contact: &ContactSample) -> bool {
    const LOOKS: usize = 5;
    let skeleton = &trace.character.skeleton;
    let mut k = Kinematics::new(skeleton, trace.pose(row));
    let at = k.world[contact.link].inverse().transform_point(&contact.point.into()).coords;
    (0..LOOKS).any(|look| {
        let back = (NEAR_S * trace.rate_hz * look as f64 / (LOOKS - 1) as f64).round() as usize;
        k.update(skeleton, trace.target_pose(row.saturating_sub(back)));
        let asked = k.point(contact.link, &at);
        let away = match contact.against {
            Against::Prop(i) => trace.disturbed.props.get(i).map_or(f64::INFINITY, |p| p.distance(&asked)),
            // the motion asked for was made for the floor of row 0
            Against::Ground | Against::Link(_) => trace.height(0, &asked),
        };
        away < NEAR_M
    })
}

/// The fall of a trace, if its body fell.
pub fn of(trace: &Trace) -> Option<Fall> {
    if trace.root == RootMode::Pinned || trace.ground_m.is_none() {
        return None;
    }
    let model = Model::new(&trace.character, trace.gravity);
    let row = (1..trace.rows()).find(|&row| fallen(trace, &model, row))?;
    Some(at_row(trace, &model, row))
}

/// The fall that happened in a row: the margins lost before it.
pub fn at_row(trace: &Trace, model: &Model, row: usize) -> Fall {
    let mut search = Search::new(trace, model, row);
    for back in (1..=row).rev() {
        if !search.examine(back) {
            break;
        }
    }
    Fall {
        time_s: row as f64 / trace.rate_hz,
        losses: search.losses(),
        triggers: trigger::before(trace, model, row),
    }
}

/// A margin while rows are looked at from the fall backwards.
struct Watch {
    margin: Margin,
    link: Option<usize>,
    /// Earliest row in which it is gone; `None` if not yet.
    since: Option<usize>,
    /// Rows in which it is there, since then.
    there: usize,
    done: bool,
}

impl Watch {
    fn of(margin: Margin, link: Option<usize>) -> Self {
        Self { margin, link, since: None, there: 0, done: false }
    }

    fn update(&mut self, row: usize, gone: bool, most: usize) {
        if self.done {
            return;
        }
        if gone {
            (self.since, self.there) = (Some(row), 0);
        } else {
            self.there += 1;
            self.done = self.there > most;
        }
    }
}

/// A sole that stands in the first row, and its middle there: in the run and in what was asked, world, m.
struct StandingSole {
    sole: Sole,
    home: Vec3,
    asked_home: Vec3,
}

struct Search<'a> {
    trace: &'a Trace,
    model: &'a Model,
    soles: Vec<StandingSole>,
    joints: Vec<usize>,
    watches: Vec<Watch>,
    most: usize,
    k: Kinematics,
    asked: Kinematics,
}

impl<'a> Search<'a> {
    fn new(trace: &'a Trace, model: &'a Model, fell: usize) -> Self {
        let c = &trace.character;
        let k = Kinematics::new(&c.skeleton, trace.pose(0));
        let asked = Kinematics::new(&c.skeleton, trace.target_pose(0));
        let stands = |sole: &Sole| sole.points(&k).any(|p| trace.height(0, &p) < STANDS_M);
        let standing = c.leg_soles().into_iter().map(|(_, sole)| sole).filter(stands);
        let soles: Vec<StandingSole> = standing
            .map(|sole| StandingSole { home: sole.center(&k), asked_home: sole.center(&asked), sole })
            .collect();
        let holds = |i: &usize| {
            use JointClass::{Ankle, Hip, Knee, Spine};
            matches!(c.classes[model.bodies[*i].link], Hip | Knee | Ankle | Spine)
        };
        let joints: Vec<usize> = (0..model.bodies.len()).filter(holds).collect();
        let mut watches = vec![Watch::of(Margin::CapturePoint, None), Watch::of(Margin::CenterOfMass, None)];
        for margin in [Margin::FootSlipped, Margin::FootLifted] {
            watches.extend(soles.iter().map(|s| Watch::of(margin, Some(s.sole.link))));
        }
        for margin in [Margin::JointLimit, Margin::SlackMuscle] {
            watches.extend(joints.iter().map(|&i| Watch::of(margin, Some(model.bodies[i].link))));
        }
        let most = ((BREAK_S * trace.rate_hz).round() as usize).clamp(1, fell.max(1));
        Self { trace, model, soles, joints, watches, most, k, asked }
    }

    /// Updates all margins with a row, going backwards from the fall; `false` when the beginning of each loss is known.
    fn examine(&mut self, row: usize) -> bool {
        let t = self.trace;
        let skeleton = &t.character.skeleton;
        self.k.update(skeleton, t.pose(row));
        self.asked.update(skeleton, t.target_pose(row));
        let (k, asked) = (&self.k, &self.asked);
        // the motion asked for was made for the floor of row 0: its heights are over that floor
        let lowest = |s: &StandingSole, k: &Kinematics, row: usize| {
            s.sole.points(k).map(|p| t.height(row, &p)).fold(f64::INFINITY, f64::min)
        };
        let slipped = |s: &StandingSole| {
            let gone = t.unturned(row, &s.sole.center(k)) - s.home;
            let was_to = s.sole.center(asked) - s.asked_home;
            // a foot that the motion moves is none that has to stay
            was_to.norm() < SLIPPED_M && ground(&(gone - was_to)).norm() > SLIPPED_M
        };
        let lifted: Vec<bool> =
            self.soles.iter().map(|s| lowest(s, k, row) > lowest(s, asked, 0).max(0.0) + LIFTED_M).collect();
        let all = lifted.iter().all(|l| *l);
        let standing = self.soles.iter().zip(&lifted).filter(|(_, lifted)| all || !**lifted);
        let support = Sole::support(standing.map(|(s, _)| &s.sole), k);
        let com = t.com_at(row);
        let omega = (t.gravity.norm() / t.height(row, &com).max(0.2)).sqrt();
        let velocity = vec_at(&t.momentum, 6 * row) / t.mass_at(row);
        let outside = |p: &Vec3| !support.is_empty() && !support.contains(&ground(p));
        let mut gone = vec![outside(&(com + velocity / omega)), outside(&com)];
        gone.extend(self.soles.iter().map(slipped));
        gone.extend(&lifted);
        let nv = skeleton.nv();
        let cells = |i: usize| {
            let b = &self.model.bodies[i];
            row * nv + b.v_at..row * nv + b.v_at + b.joint.nv().min(3)
        };
        gone.extend(
            self.joints
                .iter()
                .map(|&i| t.stop_torque[cells(i)].iter().map(|x| x * x).sum::<f64>().sqrt() > STOP_NM),
        );
        gone.extend(
            self.joints.iter().map(|&i| {
                cells(i).any(|c| t.k_lo[c].min(t.k_hi[c]) <= 0.0 && t.k_lo[c].max(t.k_hi[c]) > 0.0)
            }),
        );
        for (watch, gone) in self.watches.iter_mut().zip(gone) {
            watch.update(row, gone, self.most);
        }
        self.watches.iter().any(|w| !w.done)
    }

    /// The earliest loss of each margin, in order.
    fn losses(&self) -> Vec<Loss> {
        let links = self.trace.character.skeleton.links();
        let mut found: Vec<&Watch> = self.watches.iter().filter(|w| w.since.is_some()).collect();
        found.sort_by_key(|w| (w.since, w.margin));
        let mut losses: Vec<Loss> = Vec::new();
        for w in found {
            if losses.iter().all(|l| l.margin != w.margin) {
                losses.push(Loss {
                    margin: w.margin,
                    time_s: w.since.unwrap_or(0) as f64 / self.trace.rate_hz,
                    part: w.link.map(|l| {
                        let foot = matches!(w.margin, Margin::FootSlipped | Margin::FootLifted);
                        let leg = self.trace.character.legs().find(|leg| foot && leg.end == l);
                        leg.map_or_else(|| links[l].name.clone(), |leg| leg.name.clone())
                    }),
                });
            }
        }
        losses
    }
}
