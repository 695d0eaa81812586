//! A push map confirmed by a second engine: two pushes per direction, a little inside the border found and a little outside.
//!
//! In: a map, the take and settings of which it was made, the second engine. Out: a [`Confirmation`]. A map that was searched in a fast
//! engine is believed where the second engine survives the inner push and fails the outer one; the share where it does is printed beside the
//! map, never corrected.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use sim::EngineEntry;

use super::map::{Confirmation, ConfirmedDirection, PushMap};
use super::{PushError, PushSettings, PushTest, Verdict};
use takes::Take;

/// How far inside and outside of the border the two pushes are, as a part of the impulse.
pub const WITHIN: f64 = 0.03;

/// Pushes the take in `engine`, twice per direction of `map`; `progress` is called with the fraction done, from any thread.
///
/// # Errors
/// As [`PushTest::new`] and [`PushTest::push`]: also where the body does not stand in the second engine.
pub fn confirm(
    map: &PushMap,
    take: &Take,
    settings: PushSettings,
    engine: &EngineEntry,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Confirmation, PushError> {
    let test = PushTest::new(take, settings, engine)?;
    let pushes: Vec<(f64, f64)> = (map.directions.iter())
        .flat_map(|d| [(d.deg, (1.0 - WITHIN) * d.survived_ns), (d.deg, (1.0 + WITHIN) * d.failed_ns)])
        .collect();
    let done = AtomicUsize::new(0);
    let push = |&(deg, impulse_ns): &(f64, f64)| {
        let ended = test.push(deg, impulse_ns);
        progress((1 + done.fetch_add(1, Ordering::Relaxed)) as f64 / pushes.len() as f64);
        ended
    };
    // the first error in the order of directions is returned, so that it does not depend on threads
    let ended: Vec<_> = pushes.par_iter().with_max_len(1).map(push).collect();
    let ended = ended.into_iter().collect::<Result<Vec<Verdict>, _>>()?;
    let directions: Vec<ConfirmedDirection> = (pushes.chunks_exact(2).zip(ended.chunks_exact(2)))
        .map(|(pushes, ended)| ConfirmedDirection {
            deg: pushes[0].0,
            inside_ns: pushes[0].1,
            inside: ended[0].name(),
            outside_ns: pushes[1].1,
            outside: ended[1].name(),
            confirmed: ended[0] == Verdict::Survived && ended[1] != Verdict::Survived,
        })
        .collect();
    Ok(Confirmation {
        engine: engine.name().to_owned(),
        within_percent: 100.0 * WITHIN,
        confirmed: directions.iter().filter(|d| d.confirmed).count(),
        directions,
    })
}
