//! When each foot of a motion is on the ground: what a clip edit has to leave where it is.
//!
//! In: a body and its clip. Out: for each leg the times in which a corner of its sole is low and slow, however short. (What
//! `motion::stance` calls standing lasts longer: both feet, a second and a half.)

use bodies::Character;
use motion::{Clip, Contact, ContactPlan, Kinematics, Vec3};

/// A corner is down below this height over the lowest that soles usually are, m, ...
const LOW_M: f64 = 0.035;
/// ... and below this speed, m/s.
const SLOW_M_S: f64 = 0.5;
/// Speeds are taken over this time, s.
const OVER_S: f64 = 0.05;
/// Shorter contacts and shorter gaps are none, s.
const LEAST_S: f64 = 0.05;

/// Contacts of the legs, named by their limbs, and the height of the ground, m; `None` for a body without soles.
///
/// # Panics
/// If the clip is not of the body's skeleton.
pub fn of(character: &Character, clip: &Clip) -> (ContactPlan, Option<f64>) {
    assert_eq!(clip.skeleton.nq(), character.skeleton.nq(), "clip of another skeleton");
    let soles = character.leg_soles();
    let all: Vec<Kinematics> =
        (0..clip.frames()).map(|f| Kinematics::new(&clip.skeleton, clip.pose(f))).collect();
    // corner by corner, frame by frame
    let corners: Vec<Vec<Vec<Vec3>>> = soles
        .iter()
        .map(|(_, sole)| {
            sole.corners.iter().map(|(link, at)| all.iter().map(|k| k.point(*link, at)).collect()).collect()
        })
        .collect();
    let mut lows: Vec<f64> = (0..clip.frames())
        .filter_map(|f| corners.iter().flatten().map(|c| c[f].y).min_by(f64::total_cmp))
        .collect();
    if lows.is_empty() {
        return (ContactPlan::default(), None);
    }
    lows.sort_by(f64::total_cmp);
    let ground = lows[lows.len() / 10];
    let half = ((0.5 * OVER_S * clip.rate_hz).round() as usize).max(1);
    let least = (LEAST_S * clip.rate_hz).ceil() as usize;
    let mut contacts = Vec::new();
    for ((limb, _), corners) in soles.iter().zip(&corners) {
        let down: Vec<bool> = (0..clip.frames())
            .map(|f| {
                let (a, b) = (f.saturating_sub(half), (f + half).min(clip.frames() - 1));
                let seconds = (b - a) as f64 / clip.rate_hz;
                corners.iter().any(|c| c[f].y < ground + LOW_M && (c[b] - c[a]).norm() < SLOW_M_S * seconds)
            })
            .collect();
        let mut spans: Vec<(usize, usize)> = Vec::new();
        for f in (0..down.len()).filter(|f| down[*f]) {
            match spans.last_mut() {
                Some(last) if f <= last.1 + 1 + least => last.1 = f,
                _ => spans.push((f, f)),
            }
        }
        for (from, to) in spans.into_iter().filter(|s| s.1 - s.0 >= least) {
            let time = |f: usize| f as f64 / clip.rate_hz;
            let point = limb.name.clone();
            contacts.push(Contact { point, from_s: time(from), to_s: time(to), world_from_point: None });
        }
    }
    // spans of a leg are apart by more than a gap
    (ContactPlan::new(contacts).unwrap_or_default(), Some(ground))
}
