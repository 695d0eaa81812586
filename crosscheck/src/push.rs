//! The push-recovery maps of three engines compared: the same test, the same controllers, each engine's own state.
//!
//! In: a take that stands, the other engine. Out: a check of the two maps' mean ratios. Definitions: [`studies::push`].

use sim::{EngineEntry, core, rapier};
use studies::push::{self, PushError, PushMap, PushSettings};
use takes::Take;

use crate::check::Check;
use crate::error::CrossCheckError;

/// The mean ratios of the two engines differ by no more than this part of MuJoCo's.
pub const MEAN_WITHIN: f64 = 0.10;

/// The maps of a take in all three engines.
pub struct PushMaps {
    /// Mean ratio: the core's, rapier's and MuJoCo's.
    pub check: Check,
    /// In rapier.
    pub ours: PushMap,
    /// In MuJoCo.
    pub theirs: PushMap,
    /// In the core.
    pub core: PushMap,
}

/// Makes the map of a take in the core, in rapier and in the engine `theirs` and compares their mean ratios; `progress` is called with the
/// fraction done, from any thread.
///
/// # Errors
/// What [`push::map`] finds wrong. A body that stands in one engine only is one here.
pub fn compare(
    take: &Take,
    settings: PushSettings,
    theirs: &EngineEntry,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<PushMaps, CrossCheckError> {
    // share of the time that the core and rapier take
    const FIRST: f64 = 0.15;
    let core = push::map(take, settings, &core::engine(), &|x| progress(0.1 * FIRST * x))?;
    let ours = push::map(take, settings, &rapier::engine(), &|x| progress(FIRST * (0.1 + 0.9 * x)))?;
    let theirs = push::map(take, settings, theirs, &|x| progress(FIRST + (1.0 - FIRST) * x))?;
    Ok(PushMaps { check: check(&ours, &theirs, &core), ours, theirs, core })
}

fn check(ours: &PushMap, theirs: &PushMap, core: &PushMap) -> Check {
    let each: Vec<String> = ours
        .directions
        .iter()
        .zip(&theirs.directions)
        .zip(&core.directions)
        .map(|((a, b), c)| {
            format!("{:.0}° {:.1}, {:.1} and {:.1} N·s", a.deg, c.survived_ns, a.survived_ns, b.survived_ns)
        })
        .collect();
    Check::relative(
        "push map: mean of survived over limit",
        "",
        ours.mean_ratio,
        theirs.mean_ratio,
        theirs.mean_ratio,
        MEAN_WITHIN,
    )
    .with_core(core.mean_ratio, theirs.mean_ratio)
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
