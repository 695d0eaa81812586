//! A motion that steps, performed free in the core, in rapier and in MuJoCo.
//!
//! In: a [`Take`] that looks ahead. Out: whether it kept its feet in each engine, how far it strayed, what foresight had to do; the traces.
//!
//! The controller and the foresight are the same code, closed loop on each engine's own state: rollouts run in the core, from the state that MuJoCo
//! or rapier is in. What is compared is what a body may be judged by. Step by step the runs part: a search that starts from another state
//! finds other offsets.

use dynamics::Walked;
use sim::{EngineEntry, Outcome, PassError, core, rapier};
use takes::Take;

use crate::check::Check;
use crate::ground::SceneRun;

/// By how much the distances from what was asked may differ, mm.
const LINKS_MM: f64 = 30.0;
/// By how much turns of joints may differ, degrees.
const JOINTS_DEG: f64 = 1.5;
/// By how much offsets may differ, degrees.
const OFFSETS_DEG: f64 = 1.5;

/// Performs the take in the three engines; `mujoco` is MuJoCo's.
///
/// # Errors
/// Of any engine; a divergence of the core or of rapier is one, MuJoCo's is the end of its run.
pub fn stepping(
    take: &Take,
    mujoco: &EngineEntry,
    progress: &mut dyn FnMut(f64),
) -> Result<SceneRun, PassError> {
    let mut done = 0.0;
    let mut perform = |engine: &EngineEntry| {
        let outcome = take.pass().run(engine, &mut |x| progress((done + x) / 3.0))?;
        done += 1.0;
        Ok::<_, PassError>(outcome)
    };
    let (core, ours, theirs) = (perform(&core::engine())?, perform(&rapier::engine())?, perform(mujoco)?);
    if let Some(error) = ours.diverged.clone().or(core.diverged.clone()) {
        return Err(error.into());
    }
    let rows = take.pass().setup.goal.rows();
    let walked = [&core, &ours, &theirs].map(|o| Walked::of(&o.trace, rows));
    let checks = checks(&walked, [&core, &ours, &theirs].map(offsets_deg));
    Ok(SceneRun {
        checks,
        nothing: vec!["stepping: forces step by step: each search finds other offsets".into()],
        ours: ours.trace,
        theirs: theirs.trace,
        core: core.trace,
    })
}

/// RMS of the offsets of a run, degrees; zero without foresight.
fn offsets_deg(outcome: &Outcome) -> f64 {
    outcome.foresight.as_ref().map_or(0.0, |f| f.offset_rms().to_degrees())
}

/// The checks of how the core, rapier and MuJoCo walked, in this order.
fn checks([core, ours, theirs]: &[Walked; 3], offsets_deg: [f64; 3]) -> Vec<Check> {
    let kept = |w: &Walked| f64::from(u8::from(w.lost.is_none()));
    let end = |w: &Walked| match &w.lost {
        None => format!("kept its feet for {:.2} s", w.kept_s),
        Some((t, loss)) => format!("{t:.2} s: {loss}"),
    };
    let verdict =
        Check::absolute("stepping: kept its feet, 1 yes or 0 no", "", kept(ours), kept(theirs), 0.0)
            .with_core(kept(core), 1.0)
            .at(format!("core: {}; rapier: {}; MuJoCo: {}", end(core), end(ours), end(theirs)));
    let measure = |what: &str, unit: &str, [core, ours, theirs]: [f64; 3], allowed: f64| {
        Check::absolute(what, unit, ours, theirs, allowed)
            .with_core(core, 1.0)
            .at("RMS while each kept its feet")
    };
    let of = |f: fn(&Walked) -> f64| [f(core), f(ours), f(theirs)];
    vec![
        verdict,
        measure("stepping: links from what was asked", "mm", of(|w| w.links_mm), LINKS_MM),
        measure("stepping: joints from what was asked", "°", of(|w| w.joints_deg), JOINTS_DEG),
        measure("stepping: offsets of foresight", "°", offsets_deg, OFFSETS_DEG),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use dynamics::walked::Loss;

    fn walked(links_mm: f64, lost: Option<(f64, Loss)>) -> Walked {
        Walked {
            lost,
            kept_s: 2.0,
            links_mm,
            joints_deg: 1.0,
            slips_mm: Vec::new(),
            unexplained: 0.0,
            acceleration: 0.0,
            peak: 1.0,
            away_m: 0.0,
            way_m: 1.0,
        }
    }

    /// One that falls where the others walk is told, and one that strays; three that walk alike pass.
    #[test]
    fn who_falls_or_strays_is_named() {
        let all = |w: [Walked; 3]| checks(&w, [1.0; 3]);
        let good = all([walked(15.0, None), walked(20.0, None), walked(25.0, None)]);
        assert!(good.iter().all(|c| c.pass));
        let falls = all([walked(15.0, None), walked(20.0, None), walked(25.0, Some((1.0, Loss::Low(0.7))))]);
        assert_eq!(falls[0].differ(), ["rapier, MuJoCo", "core, MuJoCo"]);
        assert!(falls[0].at.contains("MuJoCo: 1.00 s: root at 70 %"), "{}", falls[0].at);
        let strays = all([walked(15.0, None), walked(60.0, None), walked(25.0, None)]);
        assert!(strays[0].pass && !strays[1].pass);
    }
}
