//! The push-recovery maps of two engines compared: the same test, the same controllers, each engine's own state.
//!
//! In: a take that stands, the other engine. Out: a check of the two maps' mean ratios. Definitions: [`studies::push`].

use sim::{EngineEntry, rapier};
use studies::push::{self, PushError, PushMap, PushSettings};
use takes::Take;

use crate::check::Check;
use crate::error::CrossCheckError;

/// The mean ratios of the two engines differ by no more than this part of MuJoCo's.
pub const MEAN_WITHIN: f64 = 0.10;

/// The maps of a take in both engines.
pub struct PushPair {
    /// Mean ratio, ours and MuJoCo's.
    pub check: Check,
    /// In rapier.
    pub ours: PushMap,
    /// In MuJoCo.
    pub theirs: PushMap,
}

/// Makes the map of a take in rapier and in the engine `theirs` and compares their mean ratios; `progress` is called with the
/// fraction done, from any thread.
///
/// # Errors
/// What [`push::map`] finds wrong. A body that stands in one engine only is one here.
pub fn compare(
    take: &Take,
    settings: PushSettings,
    theirs: &EngineEntry,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<PushPair, CrossCheckError> {
    // rapier's share of the time
    const FIRST: f64 = 0.15;
    let ours = push::map(take, settings, &rapier::engine(), &|x| progress(FIRST * x))?;
    let theirs = push::map(take, settings, theirs, &|x| progress(FIRST + (1.0 - FIRST) * x))?;
    Ok(PushPair { check: check(&ours, &theirs), ours, theirs })
}

fn check(ours: &PushMap, theirs: &PushMap) -> Check {
    let each: Vec<String> = ours
        .directions
        .iter()
        .zip(&theirs.directions)
        .map(|(a, b)| format!("{:.0}° {:.1} and {:.1} N·s", a.deg, a.survived_ns, b.survived_ns))
        .collect();
    Check::relative(
        "push map: mean of survived over limit",
        "",
        ours.mean_ratio,
        theirs.mean_ratio,
        theirs.mean_ratio,
        MEAN_WITHIN,
    )
    .at(format!("{} directions, each to {} %", ours.directions.len(), ours.tolerance_percent))
    .because(format!("each engine searches its own border: {}", each.join(", ")))
}

impl From<PushError> for CrossCheckError {
    fn from(e: PushError) -> Self {
        match e {
            PushError::Pass(e) => Self::Pass(e),
            e => Self::Push(e),
        }
    }
}
