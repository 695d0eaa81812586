//! Flights of the human stay flights of the character.
//!
//! In: the human clip, a clip of the character. Out: spans in which the human is in the air, and clips in which the character is
//! too. A flight is a span without contact of the human, at least [`SHORTEST_S`] long, over which the human's centre of mass falls at
//! [`FALLING`] of gravity at least: standing on a step above the ground that was found is none, nor is a cartwheel.
//!
//! *Height* is the greatest height of the lowest contact point over the flight. Of the human's it is scaled by the ratio of the
//! statures. A stage lowers it to no less than [`KEPT`] of the stage before and raises it to no more than its inverse share,
//! `1 + (1 − KEPT)`; where it would, the root is lifted by `c (4s(1 − s))³` over the flight, which begins and ends at rest, or lowered by a share of what the lowest point has.

use motion::{Clip, Kinematics, Vec3, smoothstep};

use crate::contacts::phases::human_contacts;
use crate::fit::place_root;
use crate::global_transform::{MomentumPath, stature};
use crate::options::ContactOptions;
use crate::phase::{PhaseFrames, rests, runs};
use crate::{Performer, Puppet};

/// Share of a flight's height that a stage keeps at least.
pub const KEPT: f64 = 0.8;
/// The same with which a stage's own flights are made, so that rounding leaves it.
const AIMED: f64 = 0.82;
/// Shortest flight, s.
pub const SHORTEST_S: f64 = 0.15;
/// Least mean downward acceleration of the centre of mass over a flight, over gravity's.
pub const FALLING: f64 = 0.5;
/// Share of a flight at its ends over which lowering comes and goes.
const ENDS: f64 = 0.2;
/// Heights below this share of the stature are none.
const NONE: f64 = 0.01;

/// A flight of the human.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// First and last frame in the air.
    pub frames: PhaseFrames,
    /// Its height, scaled to the character's stature, m.
    pub scaled_m: f64,
}

/// The human's flights; `human` on ground at height 0.
pub fn find(
    performer: &Performer,
    human: &Clip,
    puppet: &Puppet,
    options: &ContactOptions,
    gravity_m_s2: f64,
) -> Vec<Flight> {
    let contacts = human_contacts(performer, human, options);
    let (rate, frames) = (human.rate_hz, human.frames());
    let com = MomentumPath::of(&performer.character, human).com;
    let heights = lowest(&performer.character.skeleton, &performer.character.contacts, human);
    let ratio = stature(&puppet.character) / stature(&performer.character).max(1e-9);
    let up = |i: usize| !contacts.iter().any(|c| c[i]);
    let mut out = Vec::new();
    for flight in runs(0..frames, up) {
        let PhaseFrames { first, last } = flight;
        if first == 0 || last + 1 == frames || ((last - first) as f64) < SHORTEST_S * rate {
            continue;
        }
        let rise = |a: usize| (com[a + 1].y - com[a].y) * rate;
        let fall = (rise(first) - rise(last - 1)) / ((last - 1 - first) as f64 / rate);
        if fall < FALLING * gravity_m_s2 {
            continue;
        }
        let height = heights[first..=last].iter().copied().fold(0.0, f64::max);
        out.push(Flight { frames: flight, scaled_m: ratio * height });
    }
    out
}

/// Height of the lowest of some sites in every frame, m.
fn lowest(s: &motion::Skeleton, sites: &[usize], clip: &Clip) -> Vec<f64> {
    let mut k = Kinematics::new(s, &s.zero_pose());
    let of_frame = |i: usize| {
        k.update(s, clip.pose(i));
        let heights = sites.iter().map(|&x| k.point(s.sites()[x].link, &s.sites()[x].at).y);
        heights.reduce(f64::min).unwrap_or(0.0)
    };
    (0..clip.frames()).map(of_frame).collect()
}

/// Heights of the flights of a clip of the puppet, m.
pub fn heights(puppet: &Puppet, clip: &Clip, flights: &[Flight]) -> Vec<f64> {
    let sites: Vec<usize> = puppet.contacts.iter().map(|c| c.site).collect();
    let low = lowest(&clip.skeleton, &sites, clip);
    let top = |f: &Flight| low[f.frames.first..=f.frames.last].iter().copied().fold(0.0, f64::max);
    flights.iter().map(top).collect()
}

/// Lifts the clip where a flight is lower than the human's, scaled.
pub fn lift(puppet: &Puppet, clip: &mut Clip, flights: &[Flight]) {
    let wanted: Vec<[f64; 2]> = flights.iter().map(|f| [KEPT * f.scaled_m, f64::INFINITY]).collect();
    put(puppet, clip, flights, &[], &wanted);
}

/// Gives the flights of the clip the heights that they had, within the share that a stage may change.
///
/// * `was`: heights before the stage; `spans`: phases of the contact points, in which nothing is lifted
pub fn keep(puppet: &Puppet, clip: &mut Clip, flights: &[Flight], was: &[f64], spans: &[Vec<PhaseFrames>]) {
    let none = NONE * stature(&puppet.character);
    let wanted: Vec<[f64; 2]> = was
        .iter()
        .map(|h| if *h > none { [AIMED * h, (2.0 - AIMED) * h] } else { [0.0, f64::INFINITY] })
        .collect();
    put(puppet, clip, flights, spans, &wanted);
}

fn put(
    puppet: &Puppet,
    clip: &mut Clip,
    flights: &[Flight],
    spans: &[Vec<PhaseFrames>],
    wanted: &[[f64; 2]],
) {
    let sites: Vec<usize> = puppet.contacts.iter().map(|c| c.site).collect();
    let low = lowest(&clip.skeleton.clone(), &sites, clip);
    for (flight, [least, most]) in flights.iter().zip(wanted) {
        let Some(free) = free(flight, spans, clip.rate_hz) else { continue };
        let bump = |i: usize| {
            let s = (i - free.first) as f64 / (free.last - free.first) as f64;
            (4.0 * s * (1.0 - s)).powi(3)
        };
        let inside = || free.first + 1..free.last;
        let top = low[flight.frames.first..=flight.frames.last].iter().copied().fold(0.0, f64::max);
        let lift = inside().map(|i| (least - low[i]) / bump(i)).fold(f64::INFINITY, f64::min);
        let rise = |i: usize| {
            if top < *least {
                lift * bump(i)
            } else {
                // lower by its share of the height, so that nothing comes into the ground
                let s = (i - free.first) as f64 / (free.last - free.first) as f64;
                (most / top - 1.0) * low[i].max(0.0) * smoothstep(s.min(1.0 - s) / ENDS)
            }
        };
        if (*least..=*most).contains(&top) {
            continue;
        }
        let s = clip.skeleton.clone();
        for i in inside() {
            let up = Vec3::y() * rise(i);
            place_root(&s, clip.pose_mut(i), |w| {
                let mut w = *w;
                w.translation.vector += up;
                w
            });
        }
    }
}

/// The longest part of a flight in which no point rests; `None` if that is shorter than a flight.
fn free(flight: &Flight, spans: &[Vec<PhaseFrames>], rate_hz: f64) -> Option<PhaseFrames> {
    let PhaseFrames { first, last } = flight.frames;
    let up = |i: usize| !spans.iter().any(|s| rests(s, i));
    let mut best: Option<PhaseFrames> = None;
    for run in runs(first..last + 1, up) {
        if best.is_none_or(|b| run.last - run.first > b.last - b.first) {
            best = Some(run);
        }
    }
    best.filter(|b| (b.last - b.first) as f64 >= SHORTEST_S * rate_hz)
}
