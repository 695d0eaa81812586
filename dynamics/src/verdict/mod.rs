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
//! | left the ground | a sole is [`LIFTED_M`](crate::fall::LIFTED_M) higher than asked, or no foot bears load, for [`AIRBORNE_S`], where the motion asks for a foot on the ground | shorter is the play of a contact solver |
//! | landed hard | the ground pushes with [`HARD_BW`] body weights over [`HARD_S`] | walking takes 1.1 to 1.5, running 2 to 3 |
//! | joints at their stops | a joint is pressed against the end of its range ([`STOP_NM`](crate::fall::STOP_NM)) for [`STOP_S`] in all | a touch in passing limits nothing |
//! | far from asked | links are [`FAR_M`] RMS from where they were asked to be | a hand's breadth: another pose |
//! | momentum unexplained | of a free root, a force over [`UNEXPLAINED_S`] beyond [`UNEXPLAINED`] of the largest ground force and [`UNEXPLAINED_N`] | \[HUS15\]: beyond, a simulation explains nothing |
//! | gaze missed | eyes that are turned to a point miss it by [`GAZE_DEG`] RMS; the composer of the take measures it | eyes turn that far in a head without being seen to; farther, the body looks elsewhere |
//! | keys ignored | keys of the script cannot act; the composer of the take knows which | – |
//!
//! \[HUS15\] Hicks, Uchida, Seth et al. Is my model good enough? Best practices for verification and validation of
//! musculoskeletal models and simulations of movement. J. Biomech. Eng. 137(2), 2015: residual forces up to 5 % of the peak
//! of the net external force.

use std::fmt;

use crate::fall::Fall;
use crate::{Model, RootName, Trace};

mod judge;

pub use judge::performed_rows;

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
/// Angle between the line of sight and the point looked at, RMS, degrees.
pub const GAZE_DEG: f64 = 10.0;
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
    /// The eyes missed a point that they were turned to, degrees RMS: the point, world, m.
    GazeMissed([f64; 3]),
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

    /// A gaze at a point (world, m) that missed it by `rms_deg`, furthest at `at_s`; `None` if it did not.
    pub fn gaze(at_m: [f64; 3], rms_deg: f64, at_s: Option<f64>) -> Option<Self> {
        let what = What::GazeMissed(at_m);
        (rms_deg > GAZE_DEG).then_some(Self { what, value: rms_deg, limit: GAZE_DEG, at_s })
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
            What::GazeMissed(_) => "gaze missed",
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
            What::GazeMissed(_) => "°",
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
            What::GazeMissed([a, b, c]) => {
                write!(f, "its gaze missed ({a}, {b}, {c}) m by {x:.0}° RMS, most")
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
    /// Of the trace of a run and its fall ([`crate::fall::of`]); `failed` says why the simulation stopped, if it did.
    pub fn of(trace: &Trace, fall: Option<Fall>, failed: Option<String>) -> Self {
        let model = Model::new(&trace.character, trace.gravity);
        let performed = fall.as_ref().map(|f| trace.cut(0..performed_rows(trace, f)));
        let t = performed.as_ref().unwrap_or(trace);
        let ending = match (failed, fall) {
            (Some(why), _) => Ending::Failed(why),
            (None, Some(fall)) => Ending::Fell(fall),
            (None, None) => judge::ending(t, &model),
        };
        let in_flight = matches!(ending, Ending::InFlight(_));
        Self { reasons: judge::reasons(t, &model, in_flight), ending }
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
