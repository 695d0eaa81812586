//! Track edits on clips, measured: what a fit takes, and what comes of succession, amplitude and reach.
//!
//! In: a clip. Out: a [`Measured`], which prints as a row under [`HEADING`]. Lags are those at which the speed of a joint after the
//! edit is most like that before it (cross-correlation over whole frames); ranges are the largest angle between two frames of a joint;
//! reach is the mean distance from shoulder to hand.

use std::fmt;
use std::path::Path;

use edits::succession::{Direction, ranks};
use motion::metrics::{feet, jerk_rms};
use motion::rotation::log;
use motion::{Clip, Dof, Fit, FitReport, Joint, Kinematics, LimbKind, Quat, Tolerance};
use takes::{Ask, Take, TakeError, open};

/// The offset of the succession measured, s.
pub const OFFSET_S: f64 = 0.08;
/// The factor of the reach measured.
pub const REACH: f64 = 0.8;
/// Joints that turn by less have no speed to find a lag in, rad.
const SWINGS: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// Joints that turn by less do not count as moving, rad.
const MOVES: f64 = 0.5 * std::f64::consts::PI / 180.0;

/// A joint of an arm after a succession.
#[derive(Clone, Debug, PartialEq)]
pub struct Lag {
    /// The joint.
    pub joint: String,
    /// Offset × depth, frames.
    pub asked: f64,
    /// The lag found, frames.
    pub found: f64,
    /// The correlation there.
    pub correlation: f64,
}

/// A joint of an arm at half the amplitude.
#[derive(Clone, Debug, PartialEq)]
pub struct Halved {
    /// The joint.
    pub joint: String,
    /// The range before, degrees.
    pub before_deg: f64,
    /// The range after, degrees.
    pub after_deg: f64,
}

impl Halved {
    /// How far it is from a half, degrees.
    pub fn off_deg(&self) -> f64 {
        (self.after_deg - 0.5 * self.before_deg).abs()
    }

    /// Whether that is within 5 % of the half, or 2°.
    pub fn holds(&self) -> bool {
        self.off_deg() <= (0.05 * 0.5 * self.before_deg).max(2.0)
    }
}

/// What came of the edits of one clip.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// The clip.
    pub name: String,
    /// Its length, s.
    pub duration_s: f64,
    /// What the fit took and left.
    pub fit: FitReport,
    /// The arms after the succession, joints that swing by 10° or more.
    pub lags: Vec<Lag>,
    /// The arms at half the amplitude.
    pub halved: Vec<Halved>,
    /// Mean distance of each hand after [`REACH`], as a share of what it was.
    pub reach: Vec<f64>,
    /// Farthest slip of a foot that is down, mm: of the clip, then after succession, amplitude and reach.
    pub slip_mm: [f64; 4],
    /// RMS jerk after each of the three, as a share of the clip's.
    pub jerk: [f64; 3],
}

/// The heading of the table whose rows are [`Measured`].
pub const HEADING: &str = "| clip | s | keys | residue | lag off, frames | half off | reach | slip mm | jerk |\n|---|---|---|---|---|---|---|---|---|\n";

impl fmt::Display for Measured {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let amount = |r: &Option<motion::fit::Residue>| r.as_ref().map_or(0.0, |r| r.amount);
        let (turned, moved) = (amount(&self.fit.turned), amount(&self.fit.moved));
        let (off, least) = self.lags.iter().fold((0.0_f64, 1.0_f64), |(off, least), l| {
            (off.max((l.found - l.asked).abs()), least.min(l.correlation))
        });
        let half = self.halved.iter().map(Halved::off_deg).fold(0.0, f64::max);
        let held = self.halved.iter().filter(|h| h.holds()).count();
        let shares = |x: &[f64]| x.iter().map(|x| format!("{x:.3}")).collect::<Vec<_>>().join(", ");
        let slips: Vec<String> = self.slip_mm.iter().map(|x| format!("{x:.0}")).collect();
        let jerks: Vec<String> = self.jerk.iter().map(|x| format!("{x:.2}")).collect();
        write!(
            f,
            "| {} | {:.1} | {:.1} | {turned:.2}°, {moved:.1} mm | {off:.1} of {} joints, r ≥ {least:.2} | {half:.1}°, {held} of {} hold | {} | {} | {} |",
            self.name,
            self.duration_s,
            self.fit.keys_per_s,
            self.lags.len(),
            self.halved.len(),
            shares(&self.reach),
            slips.join(", "),
            jerks.join(", "),
        )
    }
}

/// Opens a clip with an edit.
///
/// # Errors
/// Of the clip and of the edit.
pub fn edited(path: &Path, edit: &str) -> Result<Take, TakeError> {
    open(path, &Ask { edits: vec![edit.into()], ..Ask::default() })
}

/// Measures the edits of one clip.
///
/// # Errors
/// Of the clip and of the edits.
pub fn measure(path: &Path) -> Result<Measured, TakeError> {
    let plain = open(path, &Ask::default())?;
    let clip = &plain.asked.clip;
    let s = &clip.skeleton;
    let arms: Vec<_> = s.limbs().iter().filter(|l| l.kind == LimbKind::Arm).collect();
    let names: Vec<String> = arms.iter().map(|l| format!("{:?}", l.name)).collect();
    let late = edited(path, &format!("Succession(offset_s: {OFFSET_S})"))?;
    let half = edited(path, &format!("Amplitude(factor: 0.5, parts: [{}])", names.join(", ")))?;
    let near = edited(path, &format!("ExtentReach(factor: {REACH})"))?;
    let joints: Vec<usize> = arms.iter().flat_map(|l| l.links()).collect();
    let moves = |l: usize| s.links()[l].joint != Joint::Fixed && range(clip, l) > MOVES;
    let joints = || joints.iter().copied().filter(|l| moves(*l));
    let lag = |l: &usize| range(clip, *l) > SWINGS;
    let name = |l: usize| s.links()[l].name.clone();
    let halve = |l: usize| Halved {
        joint: name(l),
        before_deg: range(clip, l).to_degrees(),
        after_deg: range(&half.asked.clip, l).to_degrees(),
    };
    let reach_of = |l: &&motion::Limb| reach(&near.asked.clip, l) / reach(clip, l);
    let fit = Fit::of(clip, &Tolerance::default());
    let all = [&late, &half, &near];
    Ok(Measured {
        name: plain.name.clone(),
        duration_s: clip.duration_s(),
        // a take has two frames or more
        fit: fit.map(|fit| fit.report).unwrap_or_else(|e| unreachable!("{e}")),
        lags: lags(clip, &late.asked.clip, &joints().filter(lag).collect::<Vec<_>>()),
        halved: joints().map(halve).collect(),
        reach: arms.iter().map(reach_of).collect(),
        slip_mm: [&plain, all[0], all[1], all[2]].map(slip),
        jerk: all.map(|take| jerk_rms(&take.asked.clip) / jerk_rms(clip)),
    })
}

/// Lags of joints after a forward succession with [`OFFSET_S`] over all that moves.
pub fn lags(before: &Clip, after: &Clip, joints: &[usize]) -> Vec<Lag> {
    let s = &before.skeleton;
    let moved = |l: usize| s.links()[l].joint != Joint::Fixed && range(before, l) > MOVES;
    let depth = ranks(s, &(0..s.links().len()).map(moved).collect::<Vec<_>>(), Direction::Forward);
    let of = |&l: &usize| {
        let asked = OFFSET_S * depth[l] as f64 * before.rate_hz;
        let most = ((2.0 * asked).ceil() as usize).min(before.frames() / 2);
        let (found, correlation) = lag(&speeds(before, l), &speeds(after, l), most);
        Lag { joint: s.links()[l].name.clone(), asked, found, correlation }
    };
    joints.iter().map(of).collect()
}

/// Speeds of a joint, rad/s, from frame to frame.
fn speeds(clip: &Clip, link: usize) -> Vec<f64> {
    let s = &clip.skeleton;
    let Some(dof) = Dof::of_link(s, link) else { return Vec::new() };
    let at = |f: usize| dof.read(s, clip.pose(f));
    (1..clip.frames()).map(|f| at(f - 1).distance(&at(f)) * clip.rate_hz).collect()
}

/// The lag of up to `most` frames at which `late` is most like `early`, and the correlation there.
fn lag(early: &[f64], late: &[f64], most: usize) -> (f64, f64) {
    let correlation = |lag: usize| {
        let n = early.len() - lag;
        let (a, b) = (&early[..n], &late[lag..]);
        let mean = |x: &[f64]| x.iter().sum::<f64>() / n as f64;
        let (ma, mb) = (mean(a), mean(b));
        let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
        for (x, y) in a.iter().zip(b) {
            ab += (x - ma) * (y - mb);
            aa += (x - ma) * (x - ma);
            bb += (y - mb) * (y - mb);
        }
        ab / (aa * bb).sqrt()
    };
    let all = (0..=most).map(|l| (l as f64, correlation(l)));
    all.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
}

/// The largest angle between two frames of a joint, rad. Every fourth frame is looked at.
fn range(clip: &Clip, link: usize) -> f64 {
    let s = &clip.skeleton;
    let all: Vec<Quat> = (0..clip.frames()).step_by(4).map(|f| s.rotation(clip.pose(f), link)).collect();
    let far = |a: &Quat| all.iter().map(|b| log(&(a * b.inverse())).norm()).fold(0.0, f64::max);
    all.iter().map(far).fold(0.0, f64::max)
}

/// Mean distance of a hand from its shoulder, m.
fn reach(clip: &Clip, limb: &motion::Limb) -> f64 {
    let of = |f: usize| {
        let k = Kinematics::new(&clip.skeleton, clip.pose(f));
        (k.origin(limb.end) - k.origin(limb.upper)).norm()
    };
    (0..clip.frames()).map(of).sum::<f64>() / clip.frames() as f64
}

/// Farthest slip of a foot that is down, mm.
fn slip(take: &Take) -> f64 {
    let c = take.character();
    let sites: Vec<_> = c.contacts.iter().map(|&i| &c.skeleton.sites()[i]).collect();
    let ground_m = take.asked.stance.as_ref().map_or(0.0, |s| s.ground_m);
    feet(&take.asked.clip, &sites, ground_m).slip_mm_max
}
