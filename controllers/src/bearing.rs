//! Bearing: the contacts of a clip where forces speak.
//!
//! Height and speed (`motion::contacts`) say most of what stands in a captured clip, and some things wrong: floors of captures are not
//! level to centimetres, a rolling foot is fast, a toe that lifts is low. What the body needs of the ground says the rest: the
//! share of its weight that the ground bears, and where.
//!
//! In: a smooth clip, its found plan. Out: the plan that bears it: contacts by whole frames. World frame, y up; m, s.

use std::ops::Range;

use dynamics::Model;
use motion::support::Vec2;
use motion::{Clip, Contact, ContactPlan, Kinematics, Sole, Vec3, runs};

use crate::shift::{Ground, asked, com_and_spin};

/// The ground bears a body that it carries this share of the weight of.
pub(crate) const BEARS: f64 = 0.25;
/// ... by a sole that is no higher than this over where it usually stands, m.
const NEAR_M: f64 = 0.04;
/// A sole below this does not swing in a time shorter than [`GAP_S`], m.
const LOW_M: f64 = 0.06;
/// See [`LOW_M`], s.
const GAP_S: f64 = 0.15;
/// ... and does not get this far, m.
const STEP_M: f64 = 0.1;
/// A sole is low enough to bear below this, m ...
const PRESSED_LOW_M: f64 = 0.04;
/// ... where the pressure is this far outside those that stand, m.
const PRESSED_OUT_M: f64 = 0.02;
/// ... and this long before and after it was found to stand, s.
const CONTACT_S: f64 = 0.05;
/// A foot rests below this speed, m/s, ...
const RESTS_M_S: f64 = 0.25;
/// ... taken over this time, s, ...
const SPEED_OVER_S: f64 = 0.05;
/// ... for no less than this, s, ...
const RESTS_S: f64 = 0.08;
/// ... if it bears in this share of it.
const RESTS: f64 = 0.3;
/// Something else than soles bears the body for no less than this, s.
pub(crate) const HELD_S: f64 = 0.1;
/// A sole beside a flight has left the ground, or is not there yet, this far over its lowest, m ...
const LIFTED_M: f64 = 0.015;
/// ... while the ground bears less than this share of the weight, or ...
const LIGHT: f64 = 0.5;
/// ... than this share of the most that it bears in [`AROUND_S`]: a smoothed landing begins before its time, the harder the more.
const LIGHT_OF_MOST: f64 = 0.25;
/// See [`LIGHT_OF_MOST`], s.
const AROUND_S: f64 = 0.1;
/// Shorter flights are none, nor are touches beside a sole that stands, s.
const SHORT_S: f64 = 0.06;
/// What a clip needs of the ground in every frame: the share of the weight that it bears, and where it presses.
pub(crate) fn needs(model: &Model, clip: &Clip, ground_m: f64) -> Vec<(f64, Option<Vec2>)> {
    let (com, spin) = com_and_spin(model, clip);
    let level = Ground::of(&ContactPlan::default(), &[], clip, ground_m, 0.0);
    let g = model.gravity.norm().max(1e-9);
    let asked = asked(model, &com, &spin, clip.rate_hz, &level);
    asked.iter().map(|a| (a.force.y / g, a.pressure(g).filter(|_| a.force.y > BEARS * g))).collect()
}

/// The plan where forces speak: while the ground bears weight and no sole was found on it, the lowest does if it is near; gaps
/// of a sole that stays low are none, nor are flights as short.
pub(crate) fn borne(
    plan: &ContactPlan,
    needs: &[(f64, Option<Vec2>)],
    clip: &Clip,
    soles: &[Sole],
    ground_m: f64,
) -> ContactPlan {
    let (frames, rate_hz) = (clip.frames(), clip.rate_hz);
    let mut stands: Vec<Vec<bool>> = soles.iter().map(|s| plan.stands(&s.name, rate_hz, frames)).collect();
    let height = |f: usize| -> Vec<f64> {
        let k = Kinematics::new(&clip.skeleton, clip.pose(f));
        soles.iter().map(|s| s.points(&k).map(|p| p.y).fold(f64::INFINITY, f64::min) - ground_m).collect()
    };
    let heights: Vec<Vec<f64>> = (0..frames).map(height).collect();
    let lowest = |f: usize| (0..soles.len()).min_by(|a, b| heights[f][*a].total_cmp(&heights[f][*b]));
    rested(&mut stands, needs, clip, soles);
    // height of each sole where it stands, contact by contact: guessed soles dig in and hover
    let levels: Vec<Vec<(Range<usize>, f64)>> = (0..soles.len())
        .map(|s| {
            let of = |run: Range<usize>| {
                let mut on: Vec<f64> = run.clone().map(|f| heights[f][s]).collect();
                on.sort_by(f64::total_cmp);
                (run, on[on.len() / 2])
            };
            runs(0..frames, |f| stands[s][f]).into_iter().map(of).collect()
        })
        .collect();
    let level = |f: usize, s: usize| {
        let off = |run: &Range<usize>| run.start.saturating_sub(f).max((f + 1).saturating_sub(run.end));
        levels[s].iter().min_by_key(|(run, _)| off(run)).map_or(0.0, |(_, level)| *level)
    };
    for f in 0..frames {
        let bare = needs[f].0 > BEARS && !stands.iter().any(|s| s[f]);
        if let Some(sole) = lowest(f).filter(|s| bare && heights[f][*s] - level(f, *s) < NEAR_M) {
            stands[sole][f] = true;
        }
    }
    pressed(&mut stands, needs, clip, soles, &heights);
    let short = |run: &Range<usize>, s: f64| (run.len() as f64) < s * rate_hz;
    let inside = |run: &Range<usize>| run.start > 0 && run.end < frames;
    for sole in 0..soles.len() {
        let low = |run: &Range<usize>| run.clone().all(|f| heights[f][sole] < LOW_M);
        let stays = |run: &Range<usize>| {
            let middle = |f: usize| soles[sole].center(&Kinematics::new(&clip.skeleton, clip.pose(f)));
            (middle(run.end) - middle(run.start - 1)).norm() < STEP_M
        };
        for run in runs(0..frames, |f| !stands[sole][f]) {
            if inside(&run) && short(&run, GAP_S) && low(&run) && stays(&run) {
                stands[sole][run].fill(true);
            }
        }
    }
    for run in runs(0..frames, |f| !stands.iter().any(|s| s[f])) {
        if inside(&run) && short(&run, SHORT_S) {
            run.for_each(|f| lowest(f).into_iter().for_each(|s| stands[s][f] = true));
        }
    }
    // touches while another sole stands
    for sole in 0..soles.len() {
        for run in runs(0..frames, |f| stands[sole][f]) {
            let other = |f: usize| (0..soles.len()).any(|s| s != sole && stands[s][f]);
            if inside(&run) && short(&run, SHORT_S) && run.clone().all(other) {
                stands[sole][run].fill(false);
            }
        }
    }
    lifted(&mut stands, needs, &heights, rate_hz);
    let mut contacts: Vec<Contact> =
        plan.contacts().iter().filter(|c| !soles.iter().any(|s| s.name == c.point)).cloned().collect();
    for (sole, stands) in soles.iter().zip(&stands) {
        contacts.extend(runs(0..frames, |f| stands[f]).into_iter().map(|run| Contact {
            point: sole.name.clone(),
            from_s: run.start as f64 / rate_hz,
            to_s: (run.end - 1) as f64 / rate_hz,
            world_from_point: None,
        }));
    }
    // runs of frames are apart
    ContactPlan::new(contacts).unwrap_or_else(|_| plan.clone())
}

/// Soles that are on their way up or down beside a flight do not stand: they are [`LIFTED_M`] over where they are lowest in the contact, no
/// other stands, and the ground need not bear the body yet or any more.
fn lifted(stands: &mut [Vec<bool>], needs: &[(f64, Option<Vec2>)], heights: &[Vec<f64>], rate_hz: f64) {
    let (frames, found) = (needs.len(), stands.to_vec());
    for sole in 0..found.len() {
        for run in runs(0..frames, |f| found[sole][f]) {
            let low = run.clone().map(|f| heights[f][sole]).fold(f64::INFINITY, f64::min);
            let light = |f: usize| {
                let around = (AROUND_S * rate_hz).round() as usize;
                let near = &needs[f.saturating_sub(around)..(f + around + 1).min(frames)];
                let most = near.iter().map(|n| n.0).fold(0.0, f64::max);
                needs[f].0 < LIGHT.max(LIGHT_OF_MOST * most)
            };
            let up = |f: &usize| {
                let alone = !(0..found.len()).any(|s| s != sole && found[s][*f]);
                alone && heights[*f][sole] > low + LIFTED_M && light(*f)
            };
            let most = (CONTACT_S * rate_hz).round() as usize;
            let (from, to) = (run.start, run.end);
            // the motion may begin or end in a contact
            if from > 0 {
                run.clone().take(most).take_while(up).for_each(|f| stands[sole][f] = false);
            }
            if to < frames {
                run.rev().take(most).take_while(up).for_each(|f| stands[sole][f] = false);
            }
        }
    }
}

/// Whether the pressure `p` lies outside the soles that stand, and `sole` would bring it nearer.
fn wants<'a>(
    p: &Vec2,
    sole: &'a Sole,
    standing: impl Iterator<Item = &'a Sole> + Clone,
    k: &Kinematics,
) -> bool {
    let without = Sole::support(standing.clone(), k).margin(p);
    let with = Sole::support(standing.chain([sole]), k).margin(p);
    without < -PRESSED_OUT_M && with > without
}

/// Feet that rest higher than the ground was thought to be, and bear: floors of captures are not level to a centimetre. The
/// pressure lies outside the soles that stand, towards them, for a good part of the time in which they are slow.
fn rested(stands: &mut [Vec<bool>], needs: &[(f64, Option<Vec2>)], clip: &Clip, soles: &[Sole]) {
    let (frames, found) = (clip.frames(), stands.to_vec());
    let all: Vec<Kinematics> = (0..frames).map(|f| Kinematics::new(&clip.skeleton, clip.pose(f))).collect();
    let half = ((0.5 * SPEED_OVER_S * clip.rate_hz).round() as usize).max(1);
    for (i, sole) in soles.iter().enumerate() {
        let middles: Vec<Vec3> = all.iter().map(|k| sole.center(k)).collect();
        let slow = |f: usize| {
            let (a, b) = (f.saturating_sub(half), (f + half).min(frames - 1));
            (middles[b] - middles[a]).norm() * clip.rate_hz < RESTS_M_S * (b - a).max(1) as f64
        };
        let bears = |f: usize| {
            let Some(p) = needs[f].1 else { return false };
            let standing = (0..soles.len()).filter(|s| *s != i && found[*s][f]).map(|s| &soles[s]);
            wants(&p, sole, standing, &all[f])
        };
        for run in runs(0..frames, slow) {
            let bearing = run.clone().filter(|f| bears(*f)).count() as f64;
            if run.len() as f64 >= RESTS_S * clip.rate_hz && bearing > RESTS * run.len() as f64 {
                stands[i][run].fill(true);
            }
        }
    }
}

/// Feet that bear although they were not found to stand: just before a contact and just after, while the pressure lies
/// outside the soles that stand, towards them, and they are low.
fn pressed(
    stands: &mut [Vec<bool>],
    needs: &[(f64, Option<Vec2>)],
    clip: &Clip,
    soles: &[Sole],
    heights: &[Vec<f64>],
) {
    let (frames, found) = (clip.frames(), stands.to_vec());
    let most = (CONTACT_S * clip.rate_hz).round() as usize;
    let bears = |f: usize, sole: usize| {
        let Some(p) = needs[f].1 else { return false };
        let k = Kinematics::new(&clip.skeleton, clip.pose(f));
        let standing = (0..soles.len()).filter(|s| found[*s][f]).map(|s| &soles[s]);
        heights[f][sole] < PRESSED_LOW_M && wants(&p, &soles[sole], standing, &k)
    };
    for sole in 0..soles.len() {
        for run in runs(0..frames, |f| found[sole][f]) {
            (0..run.start)
                .rev()
                .take(most)
                .take_while(|f| bears(*f, sole))
                .for_each(|f| stands[sole][f] = true);
            (run.end..frames).take(most).take_while(|f| bears(*f, sole)).for_each(|f| stands[sole][f] = true);
        }
    }
}
