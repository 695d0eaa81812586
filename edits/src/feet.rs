//! Feet that stand where they stood: planted by two-bone IK after an edit has changed what carries them.
//!
//! In: a clip before the change with its contacts. Out: the changed clip whose standing feet (and hands that stand) are where they
//! were, and come there and leave within 0.16 s. Where a leg would be too short the root comes down, smoothly.

use motion::ik::{IkError, Reach, reach_range, solve_two_bone_oriented};
use motion::rotation::slerp;
use motion::smooth::whittaker::{Whittaker, lambda};
use motion::{Clip, Contact, ContactPlan, Joint, Kinematics, Limb, Skeleton, Transform, Vec3, smoothstep};

/// A foot comes to its place, and leaves it, over this time, s.
pub(crate) const RAMP_S: f64 = 0.16;
/// Feet this near to their places are there, m: nothing is solved, so that what is unchanged stays so to the bit.
const THERE_M: f64 = 1e-9;
/// A leg is not pulled straighter than this fraction of its length, 14° of knee flexion for equal bones: near full stretch
/// the knee jerks. What was straighter in the base may stay so.
pub(crate) const STRAIGHTEST: f64 = 0.9925;
/// The root is lowered no faster than this frequency, Hz.
const LOWER_HZ: f64 = 2.5;

/// Where feet stood.
pub(crate) struct Feet {
    pub(crate) legs: Vec<Leg>,
}

/// A limb that stands.
pub(crate) struct Leg {
    pub(crate) limb: Limb,
    /// `world_from_foot`, frame by frame.
    place: Vec<Transform>,
    /// 1 while it stands, 0 while it steps.
    hold: Vec<f64>,
}

/// For each leg and each frame `world_from_foot`, where it is to be brought there.
pub(crate) type Goals = Vec<Vec<Option<Transform>>>;

/// Height of the lowest link of a clip, m.
pub(crate) fn lowest(clip: &Clip) -> f64 {
    let all = worlds(clip);
    all.iter().flat_map(|k| k.world.iter().map(|w| w.translation.vector.y)).fold(f64::INFINITY, f64::min)
}

/// The contacts of a limb, by its name or by a point of its end.
pub(crate) fn of_limb<'a>(
    s: &'a Skeleton,
    contacts: &'a ContactPlan,
    limb: &'a Limb,
) -> impl Iterator<Item = &'a Contact> {
    let on_end = move |point: &str| {
        let link = s.site(point).map(|site| site.link).or_else(|| s.link(point));
        link.is_some_and(|link| link == limb.end || s.ancestors(link).any(|l| l == limb.end))
    };
    contacts.contacts().iter().filter(move |c| c.point == limb.name || on_end(&c.point))
}

impl Feet {
    /// The limbs of a clip that the contacts name, by limb or by a point of the foot. `all`: its links ([`worlds`]).
    pub(crate) fn of(clip: &Clip, contacts: &ContactPlan, all: &[Kinematics]) -> Self {
        let s = &clip.skeleton;
        let legs = s
            .limbs()
            .iter()
            .filter_map(|limb| {
                let own: Vec<_> = of_limb(s, contacts, limb).collect();
                if own.is_empty() {
                    return None;
                }
                let hold = |f: usize| {
                    let t = f as f64 / clip.rate_hz;
                    own.iter()
                        .map(|c| {
                            let away = (c.from_s - t).max(t - c.to_s).max(0.0);
                            smoothstep((1.0 - away / RAMP_S).clamp(0.0, 1.0))
                        })
                        .fold(0.0, f64::max)
                };
                Some(Leg {
                    limb: limb.clone(),
                    place: all.iter().map(|k| k.world[limb.end]).collect(),
                    hold: (0..clip.frames()).map(hold).collect(),
                })
            })
            .collect();
        Feet { legs }
    }

    /// Whether no limb is known to stand.
    pub(crate) fn is_empty(&self) -> bool {
        self.legs.is_empty()
    }

    /// Holds the feet of the changed clip; says what could not be held.
    pub(crate) fn hold(&self, clip: &mut Clip) -> Result<Vec<String>, IkError> {
        let goals = self.goals(&worlds(clip));
        self.bring(clip, &goals, LOWER_HZ)
    }

    /// Where the feet of the changed clip are held.
    pub(crate) fn goals(&self, all: &[Kinematics]) -> Goals {
        self.legs
            .iter()
            .map(|leg| {
                all.iter()
                    .enumerate()
                    .map(|(f, k)| {
                        let (now, stood, w) = (k.world[leg.limb.end], leg.place[f], leg.hold[f]);
                        if w == 0.0 {
                            return None;
                        }
                        unless_there(&now, &stood)?;
                        let away = stood.translation.vector - now.translation.vector;
                        let at: Vec3 = now.translation.vector + away * w;
                        Some(Transform::from_parts(at.into(), slerp(&now.rotation, &stood.rotation, w)))
                    })
                    .collect()
            })
            .collect()
    }

    /// Brings the feet to their goals, the root lowered where a leg would be too short, no faster than `lower_hz`; says what could not be
    /// reached.
    pub(crate) fn bring(
        &self,
        clip: &mut Clip,
        goals: &Goals,
        lower_hz: f64,
    ) -> Result<Vec<String>, IkError> {
        if self.legs.is_empty() {
            return Ok(vec!["nothing is known of contacts: feet are not held".into()]);
        }
        let s = clip.skeleton.clone();
        let lowered = self.lower(clip, goals, lower_hz)?;
        let mut worst: (f64, &str, usize) = (0.0, "", 0);
        for (leg, goals) in self.legs.iter().zip(goals) {
            for (f, goal) in goals.iter().enumerate() {
                let Some(goal) = goal else { continue };
                if let Reach::Clamped { residue_m } =
                    solve_two_bone_oriented(&s, clip.pose_mut(f), &leg.limb, goal)?
                    && residue_m > worst.0
                {
                    worst = (residue_m, &leg.limb.name, f);
                }
            }
        }
        let mut notes = Vec::new();
        if lowered > 0.002 {
            notes.push(format!("the root comes down by up to {:.0} mm, so that legs reach", 1e3 * lowered));
        }
        if worst.0 > 0.002 {
            let at_s = worst.2 as f64 / clip.rate_hz;
            notes.push(format!(
                "{} misses its place by up to {:.0} mm at {at_s:.2} s",
                worst.1,
                1e3 * worst.0
            ));
        }
        Ok(notes)
    }

    /// Lowers a free root where a leg would be too short; how far at most, m.
    fn lower(&self, clip: &mut Clip, goals: &Goals, lower_hz: f64) -> Result<f64, IkError> {
        let s = clip.skeleton.clone();
        if !matches!(s.links()[0].joint, Joint::Free) {
            return Ok(0.0);
        }
        let frames = clip.frames();
        let mut need = vec![0.0_f64; frames];
        let mut k = Kinematics::new(&s, &s.zero_pose());
        for (f, need) in need.iter_mut().enumerate() {
            let asked = || self.legs.iter().zip(goals).filter_map(|(leg, goals)| Some((leg, goals[f]?)));
            if asked().next().is_none() {
                continue;
            }
            k.update(&s, clip.pose(f));
            for (leg, goal) in asked() {
                let reach = reach_range(&s, clip.pose(f), &leg.limb)?.1 * STRAIGHTEST;
                let from = k.origin(leg.limb.upper) - goal.translation.vector;
                let across = from.x.hypot(from.z);
                if from.norm() > reach && across < reach {
                    *need = need.max(from.y - (reach * reach - across * across).sqrt());
                }
            }
        }
        let most = need.iter().copied().fold(0.0, f64::max);
        if most == 0.0 {
            return Ok(0.0);
        }
        // as low as needed within the time that smoothing takes, then smooth: never less than needed but by a little
        let reach = (0.5 / lower_hz * 0.5 * clip.rate_hz).round() as usize;
        let widest: Vec<f64> = (0..frames)
            .map(|f| {
                need[f.saturating_sub(reach)..(f + reach + 1).min(frames)].iter().copied().fold(0.0, f64::max)
            })
            .collect();
        let smooth = if frames < 4 {
            widest
        } else {
            let strength = lambda(lower_hz.min(0.45 * clip.rate_hz), clip.rate_hz);
            Whittaker::new(frames, strength).smooth(&widest, 1)
        };
        let mut lowered: f64 = 0.0;
        for (f, by) in smooth.iter().enumerate() {
            let by = by.max(0.0);
            let q = clip.pose_mut(f);
            let p = s.position(q, 0) - Vec3::y() * by;
            s.set_position(q, 0, &p);
            lowered = lowered.max(by);
        }
        Ok(lowered)
    }
}

/// A goal, unless the foot is there.
pub(crate) fn unless_there(now: &Transform, goal: &Transform) -> Option<Transform> {
    let away = (goal.translation.vector - now.translation.vector).norm();
    (away >= THERE_M || goal.rotation.angle_to(&now.rotation) >= THERE_M).then_some(*goal)
}

/// Origins of the links of a clip, for measures: frame by frame, m.
pub(crate) fn worlds(clip: &Clip) -> Vec<Kinematics> {
    (0..clip.frames()).map(|f| Kinematics::new(&clip.skeleton, clip.pose(f))).collect()
}
