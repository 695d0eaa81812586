//! What names a style, and what is content, in numbers of a clip.
//!
//! Legs and arms are those of the body's limbs; forward is left hip × up. All means are over the frames.

use bodies::Character;
use motion::metrics::feet;
use motion::{Clip, Kinematics, Limb, LimbKind, Vec3};
use takes::Take;

/// A number that names a style.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Lean of the line from the hips to the shoulders, forward, degrees.
    TrunkPitch,
    /// Height of the elbows over the hips, cm.
    ElbowHeight,
    /// Bend of the elbows, degrees.
    ElbowBend,
    /// Highest forward lift of a thigh from hanging (95 % of the frames are below), degrees.
    KneeLift,
    /// Angle of the arms (shoulder to hand) forward from hanging, degrees.
    ArmsForward,
    /// Standard deviation of that angle, degrees.
    ArmSwing,
    /// Standard deviation of the height of the hips, mm.
    Bounce,
    /// Height of the hands over the hips, cm.
    HandHeight,
}

/// A frame seen from its own heading.
struct Frame {
    k: Kinematics,
    forward: Vec3,
    hips: Vec3,
    shoulders: Vec3,
}

fn limbs(clip: &Clip, kind: LimbKind) -> Vec<&Limb> {
    clip.skeleton.limbs().iter().filter(|l| l.kind == kind).collect()
}

fn middle(k: &Kinematics, all: &[&Limb]) -> Vec3 {
    all.iter().map(|l| k.origin(l.upper)).sum::<Vec3>() / all.len().max(1) as f64
}

fn frames(clip: &Clip) -> Vec<Frame> {
    let (legs, arms) = (limbs(clip, LimbKind::Leg), limbs(clip, LimbKind::Arm));
    let side = |letter: &str| legs.iter().find(|l| l.name.ends_with(letter));
    (0..clip.frames())
        .map(|f| {
            let k = Kinematics::new(&clip.skeleton, clip.pose(f));
            let across = match (side("_l"), side("_r")) {
                (Some(l), Some(r)) => k.origin(l.upper) - k.origin(r.upper),
                _ => k.world[0].rotation * Vec3::x(),
            };
            let forward = Vec3::new(across.x, 0.0, across.z).cross(&Vec3::y()).normalize();
            Frame { forward, hips: middle(&k, &legs), shoulders: middle(&k, &arms), k }
        })
        .collect()
}

/// Angle of a hanging line forward from straight down, degrees.
fn forward_deg(line: &Vec3, forward: &Vec3) -> f64 {
    line.dot(forward).atan2(-line.y).to_degrees()
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len().max(1) as f64
}

fn deviation(x: &[f64]) -> f64 {
    let m = mean(x);
    mean(&x.iter().map(|v| (v - m).powi(2)).collect::<Vec<_>>()).sqrt()
}

fn quantile(x: &[f64], share: f64) -> f64 {
    let mut sorted = x.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[((sorted.len() - 1) as f64 * share).round() as usize]
}

impl Measure {
    /// What it is called.
    pub fn word(self) -> &'static str {
        match self {
            Measure::TrunkPitch => "trunk pitch °",
            Measure::ElbowHeight => "elbows over hips cm",
            Measure::ElbowBend => "elbow bend °",
            Measure::KneeLift => "knee lift °",
            Measure::ArmsForward => "arms forward °",
            Measure::ArmSwing => "arm swing °",
            Measure::Bounce => "bounce mm",
            Measure::HandHeight => "hands over hips cm",
        }
    }

    /// Of the motion asked of a take.
    pub fn of(self, take: &Take) -> f64 {
        let clip = &take.asked.clip;
        let frames = frames(clip);
        let (legs, arms) = (limbs(clip, LimbKind::Leg), limbs(clip, LimbKind::Arm));
        let each = |limbs: &[&Limb], f: &dyn Fn(&Frame, &Limb) -> f64| -> Vec<Vec<f64>> {
            limbs.iter().map(|l| frames.iter().map(|x| f(x, l)).collect()).collect()
        };
        let over_limbs = |all: Vec<Vec<f64>>, f: &dyn Fn(&[f64]) -> f64| {
            mean(&all.iter().map(|x| f(x)).collect::<Vec<_>>())
        };
        let arm = |x: &Frame, l: &Limb| forward_deg(&(x.k.origin(l.end) - x.k.origin(l.upper)), &x.forward);
        let height = |x: &Frame, link: usize| 100.0 * (x.k.origin(link).y - x.hips.y);
        match self {
            Measure::TrunkPitch => {
                let lean = |x: &Frame| {
                    let up = x.shoulders - x.hips;
                    up.dot(&x.forward).atan2(up.y).to_degrees()
                };
                mean(&frames.iter().map(lean).collect::<Vec<_>>())
            }
            Measure::ElbowHeight => over_limbs(each(&arms, &|x, l| height(x, l.lower)), &mean),
            Measure::HandHeight => over_limbs(each(&arms, &|x, l| height(x, l.end)), &mean),
            Measure::ElbowBend => {
                let bend = |x: &Frame, l: &Limb| {
                    let (a, b) =
                        (x.k.origin(l.lower) - x.k.origin(l.upper), x.k.origin(l.end) - x.k.origin(l.lower));
                    a.angle(&b).to_degrees()
                };
                over_limbs(each(&arms, &bend), &mean)
            }
            Measure::KneeLift => {
                let thigh = |x: &Frame, l: &Limb| {
                    forward_deg(&(x.k.origin(l.lower) - x.k.origin(l.upper)), &x.forward)
                };
                over_limbs(each(&legs, &thigh), &|x| quantile(x, 0.95))
            }
            Measure::ArmsForward => over_limbs(each(&arms, &arm), &mean),
            Measure::ArmSwing => over_limbs(each(&arms, &arm), &deviation),
            Measure::Bounce => 1000.0 * deviation(&frames.iter().map(|x| x.hips.y).collect::<Vec<_>>()),
        }
    }
}

/// Angle of each thigh forward from hanging, degrees, leg by leg.
pub fn thigh_angles(clip: &Clip) -> Vec<Vec<f64>> {
    let frames = frames(clip);
    let thigh = |l: &&Limb| {
        let angle = |x: &Frame| forward_deg(&(x.k.origin(l.lower) - x.k.origin(l.upper)), &x.forward);
        frames.iter().map(angle).collect()
    };
    limbs(clip, LimbKind::Leg).iter().map(thigh).collect()
}

/// Correlation of two series, over the shorter.
pub fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let (a, b) = (&a[..n], &b[..n]);
    let (ma, mb) = (mean(a), mean(b));
    let sum = |f: &dyn Fn(usize) -> f64| (0..n).map(f).sum::<f64>();
    sum(&|i| (a[i] - ma) * (b[i] - mb))
        / (sum(&|i| (a[i] - ma).powi(2)) * sum(&|i| (b[i] - mb).powi(2))).sqrt()
}

/// Largest difference between distances of links from their parents in two clips, m.
pub fn bones(a: &Clip, b: &Clip) -> f64 {
    let lengths = |clip: &Clip, f: usize| -> Vec<f64> {
        let k = Kinematics::new(&clip.skeleton, clip.pose(f));
        let links = clip.skeleton.links().iter().enumerate();
        links.filter_map(|(i, l)| Some((k.origin(i) - k.origin(l.parent?)).norm())).collect()
    };
    let first = lengths(a, 0);
    (0..b.frames())
        .flat_map(|f| lengths(b, f).into_iter().zip(&first).map(|(x, y)| (x - y).abs()).collect::<Vec<_>>())
        .fold(0.0, f64::max)
}

/// What a motion is, apart from its style.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Content {
    /// Widest distance between the feet along the heading (95 % of the frames are below), m.
    pub step_m: f64,
    /// Steps in a second: how often the left foot passes the right one.
    pub cadence_hz: f64,
    /// Way of the hips over the ground, m.
    pub path_m: f64,
    /// Farthest slip of a foot that is down, mm.
    pub slip_mm: f64,
}

impl Content {
    /// Of the motion asked of a take, over the floor of `base`.
    pub fn of(take: &Take, base: &Take) -> Self {
        let clip = &take.asked.clip;
        let legs = limbs(clip, LimbKind::Leg);
        let frames = frames(clip);
        let apart: Vec<f64> = match legs[..] {
            [a, b] => {
                frames.iter().map(|x| (x.k.origin(a.end) - x.k.origin(b.end)).dot(&x.forward)).collect()
            }
            _ => vec![0.0; frames.len()],
        };
        let passes = apart.windows(2).filter(|w| (w[0] < 0.0) != (w[1] < 0.0)).count();
        let way = |w: &[Frame]| (w[1].hips.x - w[0].hips.x).hypot(w[1].hips.z - w[0].hips.z);
        let character: &Character = &take.body.character;
        let sites: Vec<_> = character.contacts.iter().map(|&c| &character.skeleton.sites()[c]).collect();
        let ground_m = base.asked.stance.as_ref().map_or(0.0, |s| s.ground_m);
        Content {
            step_m: quantile(&apart.iter().map(|x| x.abs()).collect::<Vec<_>>(), 0.95),
            cadence_hz: passes as f64 / clip.duration_s(),
            path_m: frames.windows(2).map(way).sum(),
            slip_mm: feet(clip, &sites, ground_m).slip_mm_max,
        }
    }
}
