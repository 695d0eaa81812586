//! Contacts of a clip: which sole is on the ground from when to when, and where.
//!
//! In: a clip and the soles of its feet. Out: its [`ContactPlan`], each contact named by its sole, and the height of the
//! ground. This is the one place where contacts of captured motion are found; scripts have theirs written.
//!
//! A sole is down while a corner of it is lower than [`LOW_M`] over the ground and slower than [`SLOW_M_S`], however short.
//! (What [`crate::stance`] calls standing lasts longer: both feet, a second and a half.) The ground is where the lowest
//! corners of one frame in ten lie, or below.
//!
//! Units: m, s; world frame, y up.

use std::ops::Range;

use crate::stance::place;
use crate::{Clip, Contact, ContactPlan, Kinematics, Skeleton, Sole, Vec3};

/// A corner is down below this height over the lowest that soles usually are, m, ...
pub const LOW_M: f64 = 0.035;
/// ... and below this speed, m/s.
pub const SLOW_M_S: f64 = 0.5;
/// A sole lies flat while its middle is less than this higher than where it is lowest, m.
const FLAT_M: f64 = 0.01;
/// Speeds are taken over this time, s.
const OVER_S: f64 = 0.05;
/// Shorter contacts and shorter gaps are none, s.
const LEAST_S: f64 = 0.05;

/// Contacts of the soles, named by them, with the flat place that each has on the ground; and the height of the ground, m,
/// `None` without soles.
///
/// # Panics
/// If the clip is not of the skeleton that the soles belong to.
pub fn contacts(clip: &Clip, soles: &[Sole]) -> (ContactPlan, Option<f64>) {
    let frames = clip.frames();
    let corners = corner_paths(clip, soles);
    let mut lows: Vec<f64> =
        (0..frames).filter_map(|f| corners.iter().flatten().map(|c| c[f].y).min_by(f64::total_cmp)).collect();
    if lows.is_empty() {
        return (ContactPlan::default(), None);
    }
    lows.sort_by(f64::total_cmp);
    let ground = lows[lows.len() / 10];
    let half = ((0.5 * OVER_S * clip.rate_hz).round() as usize).max(1);
    let least = (LEAST_S * clip.rate_hz).ceil() as usize;
    let mut contacts = Vec::new();
    for (sole, corners) in soles.iter().zip(&corners) {
        let down = |f: usize| {
            let (a, b) = (f.saturating_sub(half), (f + half).min(frames - 1));
            let seconds = (b - a) as f64 / clip.rate_hz;
            corners.iter().any(|c| c[f].y < ground + LOW_M && (c[b] - c[a]).norm() < SLOW_M_S * seconds)
        };
        let mut spans: Vec<Range<usize>> = Vec::new();
        for f in (0..frames).filter(|f| down(*f)) {
            match spans.last_mut() {
                Some(last) if f <= last.end + least => last.end = f + 1,
                _ => spans.push(f..f + 1),
            }
        }
        for span in spans.into_iter().filter(|s| s.len() > least) {
            let time = |f: usize| f as f64 / clip.rate_hz;
            contacts.push(Contact {
                point: sole.name.clone(),
                from_s: time(span.start),
                to_s: time(span.end - 1),
                world_from_point: Some(place(clip, sole, flat_part(corners, span), ground)),
            });
        }
    }
    // spans of a sole are apart by more than a gap
    (ContactPlan::new(contacts).unwrap_or_default(), Some(ground))
}

/// The plan with the flat place that its soles have in `clip` where it says none, at height `ground_m`.
pub fn placed(plan: &ContactPlan, clip: &Clip, soles: &[Sole], ground_m: f64) -> ContactPlan {
    let corners = corner_paths(clip, soles);
    let filled = |c: &Contact| {
        let found = soles.iter().position(|s| s.name == c.point).and_then(|s| {
            let flat = flat_part(&corners[s], c.frames(clip.rate_hz, clip.frames()));
            (!flat.is_empty()).then(|| place(clip, &soles[s], flat, ground_m))
        });
        Contact { world_from_point: c.world_from_point.or(found), ..c.clone() }
    };
    // times are those of a plan
    ContactPlan::new(plan.contacts().iter().map(filled).collect()).unwrap_or_else(|_| plan.clone())
}

/// The plan with contacts of soles for those of their corners: a sole that is not named itself stands while any site at a corner of it does.
/// Where its corners have places is forgotten: `placed` finds where it lies flat.
pub fn by_soles(plan: &ContactPlan, skeleton: &Skeleton, soles: &[Sole]) -> ContactPlan {
    let corner = |sole: &Sole, point: &str| {
        let site = skeleton.site(point);
        site.is_some_and(|s| sole.corners.iter().any(|(link, at)| *link == s.link && *at == s.at))
    };
    let mut contacts = plan.contacts().to_vec();
    for sole in soles.iter().filter(|sole| plan.of(&sole.name).next().is_none()) {
        let (of, others): (Vec<Contact>, Vec<Contact>) =
            contacts.into_iter().partition(|c| corner(sole, &c.point));
        contacts = others;
        let first = contacts.len();
        // in order of their start
        for c in of {
            match contacts[first..].last_mut().filter(|last| c.from_s <= last.to_s) {
                Some(last) => last.to_s = last.to_s.max(c.to_s),
                None => contacts.push(Contact { point: sole.name.clone(), world_from_point: None, ..c }),
            }
        }
    }
    // joined where they overlap
    ContactPlan::new(contacts).unwrap_or_else(|_| plan.clone())
}

/// The part of a contact in which the sole lies flattest: around the frame whose corners are lowest together, while their
/// middle is less than [`FLAT_M`] higher. `corners`: their paths.
pub(crate) fn flat_part(corners: &[Vec<Vec3>], span: Range<usize>) -> Range<usize> {
    let height = |f: usize| corners.iter().map(|c| c[f].y).sum::<f64>() / corners.len().max(1) as f64;
    let Some(lowest) = span.clone().min_by(|a, b| height(*a).total_cmp(&height(*b))) else { return span };
    let flat = |f: usize| height(f) < height(lowest) + FLAT_M;
    let from = (span.start..lowest).rev().take_while(|f| flat(*f)).last().unwrap_or(lowest);
    let to = (lowest..span.end).take_while(|f| flat(*f)).last().unwrap_or(lowest);
    from..to + 1
}

/// Paths of the corners: sole by sole, corner by corner, frame by frame.
pub(crate) fn corner_paths(clip: &Clip, soles: &[Sole]) -> Vec<Vec<Vec<Vec3>>> {
    let all: Vec<Kinematics> =
        (0..clip.frames()).map(|f| Kinematics::new(&clip.skeleton, clip.pose(f))).collect();
    let path = |(link, at): &(usize, Vec3)| all.iter().map(|k| k.point(*link, at)).collect();
    soles.iter().map(|sole| sole.corners.iter().map(path).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Joint, Link, Site};

    /// Heel and toe of a foot are one contact from the heel's first to the toe's last moment; what is no corner of a sole stays, and so
    /// does a sole that is named itself.
    #[test]
    fn corners_stand_for_their_sole() {
        let site = |name: &str, z: f64| Site { name: name.into(), link: 1, at: Vec3::z() * z };
        let links = vec![
            Link::new("hips", None, Vec3::zeros(), Joint::Free),
            Link::new("foot", Some(0), -Vec3::y(), Joint::Spherical),
        ];
        let skeleton =
            Skeleton::new(links).unwrap().with_sites(vec![site("heel", -0.1), site("toe", 0.2)]).unwrap();
        let sole =
            Sole { name: "leg".into(), link: 1, corners: vec![(1, Vec3::z() * -0.1), (1, Vec3::z() * 0.2)] };
        let of =
            |point: &str, from_s, to_s| Contact { point: point.into(), from_s, to_s, world_from_point: None };
        let others = [of("hand", 0.2, 0.4)];
        let feet = [of("heel", 0.0, 0.5), of("toe", 0.1, 0.7), of("heel", 1.0, 1.2), of("toe", 1.3, 1.5)];
        let plan = ContactPlan::new([&others[..], &feet].concat()).unwrap();
        let soles = [sole];
        let found = by_soles(&plan, &skeleton, &soles);
        let times: Vec<(f64, f64)> = found.of("leg").map(|c| (c.from_s, c.to_s)).collect();
        assert_eq!(times, [(0.0, 0.7), (1.0, 1.2), (1.3, 1.5)]);
        assert_eq!(found.points(), ["hand", "leg"]);
        let named = ContactPlan::new([&others[..], &[of("leg", 0.0, 1.0)], &feet].concat()).unwrap();
        assert_eq!(by_soles(&named, &skeleton, &soles), named);
        assert!(by_soles(&ContactPlan::default(), &skeleton, &soles).is_empty());
    }
}
