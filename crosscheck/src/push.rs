//! The push-recovery map in MuJoCo: the same test, the same controllers, MuJoCo's state.
//!
//! In: a stage that stands. Out: its [`PushMap`], simulated by MuJoCo, or a check of the two engines' maps.
//! Every thread talks to a MuJoCo of its own; directions are searched by themselves, so the map is the same on
//! any number of threads. Definitions: [`scenes::push`].

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use scenes::Stage;
use scenes::push::{self, PushError, PushMap, PushSettings, PushTest};
use sim::WorldError;

use crate::bridge::Bridge;
use crate::check::Check;
use crate::environment;
use crate::ground::{Shared, standing};
use crate::subject::CrossCheckError;
use crate::world::MujocoWorld;

/// The mean ratios of the two engines differ by no more than this part of MuJoCo's.
pub const MEAN_WITHIN: f64 = 0.10;

thread_local! {
    /// This thread's MuJoCo.
    static OWN: RefCell<Option<(PathBuf, Shared)>> = const { RefCell::new(None) };
}

/// The MuJoCo of this thread, started by its first use.
fn own(python: &Path) -> Result<Shared, WorldError> {
    OWN.with_borrow_mut(|own| match own {
        Some((of, bridge)) if of == python => Ok(bridge.clone()),
        _ => {
            let bridge = Bridge::start(python).map_err(|e| WorldError::Engine(e.to_string()))?;
            let bridge = Rc::new(RefCell::new(bridge));
            *own = Some((python.to_owned(), bridge.clone()));
            Ok(bridge)
        }
    })
}

/// A map of a stage in MuJoCo; `say` is told when its environment is made, `progress` the fraction done, from any
/// thread.
///
/// # Errors
/// No MuJoCo; what [`PushTest`] finds wrong.
pub fn map(
    stage: &Stage,
    settings: PushSettings,
    say: &mut dyn FnMut(&str),
    progress: &(dyn Fn(f64) + Sync),
) -> Result<PushMap, CrossCheckError> {
    let python = environment::prepare(say)?;
    let integration = standing();
    let test = PushTest::new(stage, settings, |character: &_, world, q: &[f64], v: &[f64]| {
        MujocoWorld::new(own(&python)?, &integration, character, world, q, v)
    })?;
    Ok(test.map(progress)?)
}

/// The maps of a stage in both engines.
pub struct PushPair {
    /// Mean ratio, ours and MuJoCo's.
    pub check: Check,
    /// In rapier.
    pub ours: PushMap,
    /// In MuJoCo.
    pub theirs: PushMap,
}

/// Makes both maps and compares their mean ratios.
///
/// # Errors
/// As [`map`]. A body that stands in one engine only is one here.
pub fn compare(
    stage: &Stage,
    settings: PushSettings,
    say: &mut dyn FnMut(&str),
    progress: &(dyn Fn(f64) + Sync),
) -> Result<PushPair, CrossCheckError> {
    // rapier's share of the time
    const FIRST: f64 = 0.15;
    let ours = push::map(stage, settings, &|x| progress(FIRST * x))?;
    let theirs = map(stage, settings, say, &|x| progress(FIRST + (1.0 - FIRST) * x))?;
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
