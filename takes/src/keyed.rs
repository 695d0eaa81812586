//! How much the keys of a script rule what balance or planted feet set otherwise.
//!
//! In: tracks, a coordinate or a joint. Out: a track from 0 (as balance and feet have it) to 1 (as the key says), along the curves of the keys.

use motion::{Dof, Tracks, Value};

/// Tracks of how much a key rules a coordinate: 1 at a key, 0 before any and at one at rest. `None` without keys.
pub(crate) fn keyed(tracks: &Tracks, dof: Dof) -> Option<motion::Track> {
    let rest = dof.read(&tracks.skeleton, &tracks.base);
    let mut track = tracks.track(dof)?.clone();
    for e in &mut track.elements {
        let at_rest = e.end.distance(&rest) < 1e-9;
        e.end = Value::Scalar(if at_rest { 0.0 } else { 1.0 });
    }
    Some(track)
}

/// How much a key rules at a time (s), 0 to 1: an overshooting curve gives no more than all.
pub(crate) fn share(keyed: &motion::Track, t_s: f64) -> f64 {
    keyed.value_at(t_s, &Value::Scalar(0.0)).scalar().unwrap_or(0.0).clamp(0.0, 1.0)
}
