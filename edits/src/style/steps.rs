//! Steps are content: feet go the base's way while style carries the body over them (SCF06 §4.6, foot plants by IK).
//!
//! In: a base with its contacts, and the same clip with style. Out: the styled clip with the feet brought by two-bone IK to
//!
//! * the base's place and turn while they stand, and wherever they pass the ground within 3 cm,
//! * the base's way over the ground in the air as well: steps are as long as they were and land where they landed,
//! * a height in the air between the base's and the style's, so that knees are lifted as the style lifts them and thighs keep their
//!   rhythm; and the style's turn, high over the ground. What the style raises or sinks a *standing* foot by is nobody's step: it is
//!   taken away, in the air as it goes from the one stand to the next. A foot comes lower than the base's only where it stays clear of
//!   the ground and the leg is long enough.
//!
//! Points of a sole that are near the ground are near it in the base too, and move as they did there: slip is the base's. Knees
//! bend in the base's plane, and legs keep their limits ([`super::knees`]); what cannot be kept is said.

use motion::ik::{IkError, reach_range};
use motion::rotation::slerp;
use motion::{Clip, ContactPlan, Kinematics, LimbKind, Skeleton, Transform, Vec3, smoothstep};

use super::knees;
use crate::feet::{Feet, Goals, Leg, STRAIGHTEST, of_limb, unless_there, worlds};

/// Below this height over where it stands a foot is the base's, m.
const CLEAR_M: f64 = 0.03;
/// From there up to so much more, m, its turn becomes the style's.
const TURN_M: f64 = 0.12;
/// Share of the style's lift that a foot in the air takes: with more, thighs of a base that shuffles lose their rhythm.
const LIFT: f64 = 1.0 / 3.0;
/// Limits that are left by less are not spoken of, degrees.
const BEYOND_DEG: f64 = 0.5;
/// The root is lowered no faster than this frequency, Hz: slower than steps, so that a body that bounces goes on bouncing.
const LOWER_HZ: f64 = 0.8;

/// Points of a foot: its sites, origins and ends of its links, in the frames of their links, m.
fn points(s: &Skeleton, end: usize) -> Vec<(usize, Vec3)> {
    let of_foot = |link: usize| link == end || s.ancestors(link).any(|l| l == end);
    let links = (0..s.links().len()).filter(|l| of_foot(*l));
    let mut all: Vec<(usize, Vec3)> = links
        .flat_map(|l| std::iter::once((l, Vec3::zeros())).chain(s.links()[l].end.map(|e| (l, e))))
        .collect();
    all.extend(s.sites().iter().filter(|site| of_foot(site.link)).map(|site| (site.link, site.at)));
    all
}

/// Frames of the stands of a leg, first and last, in order; those that overlap are one.
fn stands(clip: &Clip, contacts: &ContactPlan, leg: &Leg) -> Vec<(usize, usize)> {
    let last = clip.frames() - 1;
    let frame = |t: f64| ((t * clip.rate_hz).round().max(0.0) as usize).min(last);
    let mut all: Vec<(usize, usize)> = of_limb(&clip.skeleton, contacts, &leg.limb)
        .map(|c| (frame(c.from_s), frame(c.to_s)))
        .filter(|(from, to)| from <= to)
        .collect();
    all.sort_unstable();
    let mut out: Vec<(usize, usize)> = Vec::new();
    for (from, to) in all {
        match out.last_mut() {
            Some(before) if from <= before.1 + 1 => before.1 = before.1.max(to),
            _ => out.push((from, to)),
        }
    }
    out
}

/// A value frame by frame: that of `of` in stands, from the end of the one to the beginning of the next in the air between, and
/// that of the nearest stand before the first and after the last.
fn between_stands(stands: &[(usize, usize)], frames: usize, of: impl Fn(usize) -> f64) -> Vec<f64> {
    (0..frames)
        .map(|f| {
            let next = stands.partition_point(|s| s.1 < f);
            match (next.checked_sub(1).map(|i| stands[i].1), stands.get(next).map(|s| s.0)) {
                (_, Some(from)) if f >= from => of(f),
                (Some(a), Some(b)) => {
                    let s = smoothstep((f - a) as f64 / (b - a) as f64);
                    of(a) * (1.0 - s) + of(b) * s
                }
                (None, Some(b)) => of(b),
                (Some(a), None) => of(a),
                (None, None) => 0.0,
            }
        })
        .collect()
}

/// How far the lowest point of a foot is over where it stands, frame by frame, m.
fn clearance(base: &[Kinematics], s: &Skeleton, leg: &Leg, stands: &[(usize, usize)]) -> Vec<f64> {
    let mut out = vec![f64::INFINITY; base.len()];
    for (link, at) in points(s, leg.limb.end) {
        let heights: Vec<f64> = base.iter().map(|k| k.point(link, &at).y).collect();
        let lowest = |f: usize| {
            let of = |s: &(usize, usize)| heights[s.0..=s.1].iter().copied().fold(f64::INFINITY, f64::min);
            stands.iter().find(|s| s.0 <= f && f <= s.1).map_or(heights[f], of)
        };
        let level = between_stands(stands, base.len(), lowest);
        for ((out, h), level) in out.iter_mut().zip(&heights).zip(level) {
            *out = out.min(h - level);
        }
    }
    out
}

/// How far the style lifts a foot in the air, m, from how far it raises it there over what it does to it standing; `room` below the
/// base's foot, and `down` as far as the leg reaches, at most 0.
fn lifted(by: f64, room: f64, down: f64) -> f64 {
    if by >= 0.0 {
        return LIFT * by;
    }
    if room <= 0.0 {
        return 0.0;
    }
    (-room * (1.0 - (by / room).exp())).max(down)
}

/// Brings the feet of a styled clip to their steps. See the module header. Limbs other than legs that the contacts name are held as
/// [`Feet::hold`] holds them.
///
/// # Errors
/// Legs that IK cannot solve.
pub(super) fn keep(base: &Clip, contacts: &ContactPlan, styled: &mut Clip) -> Result<Vec<String>, IkError> {
    let s = base.skeleton.clone();
    let (was, is) = (worlds(base), worlds(styled));
    let feet = Feet::of(base, contacts, &was);
    let mut goals: Goals = feet.goals(&is);
    let mut rooms: Vec<Vec<f64>> = vec![Vec::new(); goals.len()];
    let legs = feet.legs.iter().zip(&mut goals).zip(&mut rooms);
    for ((leg, goals), rooms) in legs.filter(|x| x.0.0.limb.kind == LimbKind::Leg) {
        let stands = stands(base, contacts, leg);
        let clear = clearance(&was, &s, leg, &stands);
        let foot = |all: &[Kinematics], f: usize| all[f].world[leg.limb.end];
        let raised: Vec<f64> =
            (0..base.frames()).map(|f| foot(&is, f).translation.y - foot(&was, f).translation.y).collect();
        let level = between_stands(&stands, base.frames(), |f| raised[f]);
        for (f, goal) in goals.iter_mut().enumerate() {
            let (from, to) = (foot(&was, f), foot(&is, f));
            let room = (clear[f] - CLEAR_M).max(0.0);
            rooms.push(room);
            let reach = STRAIGHTEST * reach_range(&s, base.pose(f), &leg.limb)?.1;
            let hip = is[f].origin(leg.limb.upper) - from.translation.vector;
            let across = hip.x.hypot(hip.z).min(reach);
            let down = (hip.y - (reach * reach - across * across).sqrt()).min(0.0);
            let at = from.translation.vector + Vec3::y() * lifted(raised[f] - level[f], room, down);
            let turn = slerp(&from.rotation, &to.rotation, smoothstep((room / TURN_M).min(1.0)));
            *goal = unless_there(&to, &Transform::from_parts(at.into(), turn));
        }
        knees::as_before(styled, leg, goals, base, [&was, &is]);
    }
    let mut notes = feet.bring(styled, &goals, LOWER_HZ)?;
    let legs = feet.legs.iter().zip(&goals).zip(&rooms);
    for ((leg, goals), rooms) in legs.filter(|x| x.0.0.limb.kind == LimbKind::Leg) {
        knees::in_plane(styled, leg, goals, base, &was);
        let mut worst = (0.0, 0);
        for f in (0..base.frames()).filter(|f| goals[*f].is_some()) {
            let (before, q) = (base.pose(f), styled.pose_mut(f));
            if rooms[f] > 0.0 {
                knees::ankle_within(&s, leg, before, q);
            }
            let by = knees::beyond_deg(&s, leg, before, q);
            if by > worst.0 {
                worst = (by, f);
            }
        }
        if worst.0 > BEYOND_DEG {
            let (name, at_s) = (&leg.limb.name, worst.1 as f64 / base.rate_hz);
            notes.push(format!(
                "{name} goes where it went only beyond its limits, by up to {:.0}° at {at_s:.2} s",
                worst.0
            ));
        }
    }
    Ok(notes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of stands are kept, those of the air go from one to the next, those outside are the nearest stand's.
    #[test]
    fn values_of_stands_go_over_in_the_air() {
        let of = |f: usize| f as f64;
        let all = between_stands(&[(2, 3), (7, 8)], 11, of);
        assert_eq!((all[0], all[2], all[3], all[5], all[7], all[10]), (2.0, 2.0, 3.0, 5.0, 7.0, 8.0));
        assert!(all.windows(2).all(|w| w[0] <= w[1]), "{all:?}");
        assert_eq!(between_stands(&[], 2, of), [0.0, 0.0]);
    }

    /// A foot is lifted by a share of the style's lift, and lowered no further than there is room and leg.
    #[test]
    fn feet_are_lifted_by_a_third_and_stay_clear() {
        assert_eq!(lifted(0.3, 0.0, 0.0), LIFT * 0.3);
        assert_eq!(lifted(-0.2, 0.0, -1.0), 0.0);
        let by = lifted(-0.2, 0.1, -1.0);
        assert!(by < -0.08 && by > -0.1, "{by}");
        assert_eq!(lifted(-0.2, 0.1, -0.02), -0.02);
        let little = lifted(-1e-6, 0.1, -1.0);
        assert!((little / -1e-6 - 1.0).abs() < 1e-4, "{little}");
    }
}
