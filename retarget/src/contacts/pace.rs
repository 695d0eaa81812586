//! Phases shortened where the flights between them are too quick for the character.
//!
//! In: phases as they were found, the paths of the character's points. Out: phases of which some begin a little later and
//! end a little earlier.
//!
//! A character whose steps are long for its human's, or that hops where its human shifts a foot, has to make its way between two
//! phases in the time that the human took; the least peak jerk of a way d in a time T is 32 d/T³. Where the corrected path is
//! jerked more than the motion itself near any end of a phase, the ends beside that flight are moved, a 30th of a second
//! at a time, until it is not, up to [`ContactOptions::phase_slack_s`] each. All points of the link that land or leave in the
//! same frame go together, and no phase becomes shorter than [`ContactOptions::shortest_s`].

use super::paths::{by_link, held_paths};
use super::{ALLOWED, peak, peak_near};
use crate::Puppet;
use crate::options::ContactOptions;
use crate::phase::{Path, PhaseFrames};

/// Time by which an end is moved at once, s.
const ROUND_S: f64 = 1.0 / 30.0;

/// Phases whose flights are long enough, and the paths that the points then take. See the module header.
pub(super) fn pace(
    puppet: &Puppet,
    source: &[Path],
    mut spans: Vec<Vec<PhaseFrames>>,
    rate_hz: f64,
    options: &ContactOptions,
) -> (Vec<Vec<PhaseFrames>>, Vec<Path>) {
    let by = (ROUND_S * rate_hz).round().max(1.0) as usize;
    let shortest = (options.shortest_s * rate_hz).round() as usize;
    let mut rounds = (options.phase_slack_s * rate_hz).round() as usize / by;
    loop {
        let held = held_paths(puppet, source, &spans, rate_hz);
        let allowed = ALLOWED * peak(source, &spans, rate_hz);
        let mut changed = false;
        if rounds > 0 {
            for of_link in &by_link(puppet) {
                changed |= shorten(&held, &mut spans, of_link, allowed, (by, shortest), rate_hz);
            }
        }
        if !changed {
            return (spans, held);
        }
        rounds -= 1;
    }
}

/// Moves the ends of one link's phases near which a point is jerked more than allowed; whether there were any.
fn shorten(
    held: &[Path],
    spans: &mut [Vec<PhaseFrames>],
    of_link: &[usize],
    allowed: f64,
    (by, shortest): (usize, usize),
    rate_hz: f64,
) -> bool {
    let frames = held[of_link[0]].len();
    let ends = |of: fn(&PhaseFrames) -> usize| -> Vec<usize> {
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
