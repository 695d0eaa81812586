//! The time that steps need.
//!
//! In: phases as they were found, the character's clip in the world. Out: phases of which some begin a little later and
//! end a little earlier.
//!
//! A character whose steps are long for its human's, or that hops where its human shifts a foot, has to make its way between two
//! phases in the time that the human took; the least peak jerk of a way d in a time T is 32 d/T³. Where the corrected path is
//! jerked more than the motion itself near any end of a phase, the ends beside that flight give way, a 30th of a second
//! at a time, until it is not, up to [`ContactOptions::give_s`] each. All points of the link that land or leave in the
//! same frame go together, and no phase becomes shorter than [`ContactOptions::shortest_s`].

use motion::Clip;

use super::paths::{Path, Span, by_link, held_paths};
use super::{ALLOWED, Phase, peak, peak_near, phases, point_paths};
use crate::options::ContactOptions;
use crate::{Puppet, RetargetError};

/// Time by which an end gives way at once, s.
const ROUND_S: f64 = 1.0 / 30.0;

/// Phases whose flights are long enough. See the module header.
///
/// * `clip`: of the character, in the world
///
/// # Errors
/// As [`phases::spans`].
pub fn pace(
    puppet: &Puppet,
    clip: &Clip,
    found: &[Phase],
    options: &ContactOptions,
) -> Result<Vec<Phase>, RetargetError> {
    let mut spans = phases::spans(puppet, found, clip)?;
    let source = point_paths(puppet, clip);
    let links = by_link(puppet);
    let by = (ROUND_S * clip.rate_hz).round().max(1.0) as usize;
    let shortest = (options.shortest_s * clip.rate_hz).round() as usize;
    let most = (options.give_s * clip.rate_hz).round() as usize;
    for _ in 0..most / by {
        let held = held_paths(puppet, &source, &spans, clip.rate_hz);
        let allowed = ALLOWED * peak(&source, &spans, clip.rate_hz);
        let mut changed = false;
        for of_link in &links {
            changed |= give(&held, &mut spans, of_link, allowed, (by, shortest), clip.rate_hz);
        }
        if !changed {
            break;
        }
    }
    let at = |frame: usize| frame as f64 / clip.rate_hz;
    let sites = puppet.character.skeleton.sites();
    let of_point = |(c, spans): (usize, &Vec<Span>)| -> Vec<Phase> {
        let point = &sites[puppet.contacts[c].site].name;
        let phase = |s: &Span| Phase { point: point.clone(), from_s: at(s.first), to_s: at(s.last) };
        spans.iter().map(phase).collect()
    };
    Ok(spans.iter().enumerate().flat_map(of_point).collect())
}

/// Moves the ends of one link's phases near which a point is jerked more than allowed; whether there were any.
fn give(
    held: &[Path],
    spans: &mut [Vec<Span>],
    of_link: &[usize],
    allowed: f64,
    (by, shortest): (usize, usize),
    rate_hz: f64,
) -> bool {
    let frames = held[of_link[0]].len();
    let ends = |of: fn(&Span) -> usize| -> Vec<usize> {
        let of_point = |&c: &usize| {
            let jerked = move |end: &usize| {
                *end > 0 && *end + 1 < frames && peak_near(&held[c], *end, rate_hz) > allowed
            };
            spans[c].iter().map(of).filter(jerked).collect::<Vec<_>>()
        };
        of_link.iter().flat_map(of_point).collect()
    };
    let (lands, leaves) = (ends(|s| s.first), ends(|s| s.last));
    let mut changed = false;
    for &c in of_link {
        for s in &mut spans[c] {
            if lands.contains(&s.first) && s.last - s.first >= shortest + by {
                s.first += by;
                changed = true;
            }
            if leaves.contains(&s.last) && s.last - s.first >= shortest + by {
                s.last -= by;
                changed = true;
            }
        }
    }
    changed
}
