//! Motion without contacts: rapier and the core against MuJoCo's fourth-order integrator, with the order of convergence.
//!
//! In: MuJoCo, a take whose root is pinned. Out: checks and the curves of the joint that differs most. The
//! ground is taken away, so that nothing but inertia, gravity and muscles is compared. The reference holds
//! its drives for 1/7680 s and takes one Runge–Kutta step in each.

use dynamics::Trace;
use motion::Clip;
use motion::metrics::{joint_errors, joint_rms_deg};
use sim::{EngineEntry, PassError, core, rapier};
use takes::Take;

use crate::bridge::Shared;
use crate::check::{Check, CoreSeen, Measure};
use crate::ground::in_mujoco;
use crate::mujoco::Integration;

/// Control steps per second of the reference.
pub const REFERENCE_HZ: f64 = 7680.0;
/// Control steps per second both are tried at, each with two substeps; the second is the default.
pub const RATES_HZ: [f64; 4] = [120.0, 240.0, 480.0, 960.0];
const SUBSTEPS: usize = 2;
/// Longest span compared, s.
pub const LONGEST: f64 = 4.0;
/// Motions are compared at this rate, at times all of them have, Hz.
const COMMON_HZ: f64 = 120.0;

/// What came of it.
pub struct ForwardRun {
    /// The checks.
    pub checks: Vec<Check>,
    /// Why there is none, if so.
    pub nothing: Vec<String>,
    /// Joint RMS of rapier at each of [`RATES_HZ`], degrees.
    pub errors_deg: [f64; 4],
    /// The same of the core.
    pub core_deg: [f64; 4],
    /// Link whose joint differs most at the default step.
    pub link: usize,
    /// Rapier's motion at the default step, the reference, and the core's motion, at the common rate.
    pub clips: [Clip; 3],
}

/// Compares up to [`LONGEST`] seconds of a take.
///
/// # Errors
/// Of either engine.
pub fn compare(bridge: &Shared, take: &Take, progress: &mut dyn FnMut(f64)) -> Result<ForwardRun, PassError> {
    let pass = |rate_hz: f64| {
        let mut at = take.clone();
        at.conditions.physics.rate_hz = Some(rate_hz);
        let mut pass = at.pass();
        pass.substeps = Some(SUBSTEPS);
        pass.ground = None;
        pass.setup.ground_m = None;
        // an impact has no order
        pass.props.clear();
        pass.self_collision = false;
        pass
    };
    let end_s = take.asked.clip.duration_s().min(LONGEST);
    let common = |trace: &Trace| {
        let clip = trace.clip().resample(COMMON_HZ);
        let frames = ((end_s * COMMON_HZ) as usize + 1).min(clip.frames());
        let nq = clip.skeleton.nq();
        Clip::new(clip.skeleton.clone(), COMMON_HZ, clip.data()[..frames * nq].to_vec())
    };
    let reference = in_mujoco(bridge, pass(REFERENCE_HZ), &Integration::reference(1), end_s, progress)?;
    let reference = common(&reference.trace);
    let tried = |engine: &EngineEntry| -> Result<([f64; 4], Clip), PassError> {
        let mut errors_deg = [0.0; 4];
        let mut at_default = None;
        for (error, rate_hz) in errors_deg.iter_mut().zip(RATES_HZ) {
            let outcome = pass(rate_hz).run(engine, &mut |_| {})?;
            if let Some(why) = outcome.diverged {
                return Err(why.into());
            }
            let clip = common(&outcome.trace);
            *error = joint_rms_deg(&joint_errors(&clip, &reference));
            if rate_hz == RATES_HZ[1] {
                at_default = Some(clip);
            }
        }
        Ok((errors_deg, at_default.expect("the default is among the rates")))
    };
    let (errors_deg, ours) = tried(&rapier::engine())?;
    let (core_deg, core) = tried(&core::engine())?;
    let worst = joint_errors(&ours, &reference).into_iter().max_by(|a, b| a.rms_deg.total_cmp(&b.rms_deg));
    let Some(worst) = worst.filter(|_| reference.frames() > 1) else {
        let why = if reference.frames() > 1 { "no joint turns" } else { "the motion has no duration" };
        let nothing = vec![format!("motion without contact: {why}")];
        let clips = [ours, reference, core];
        return Ok(ForwardRun { checks: Vec::new(), nothing, errors_deg, core_deg, link: 0, clips });
    };
    let link = worst.link;
    let name = &ours.skeleton.links()[link].name;
    let mut checks = vec![
        Check::of(
            "motion without contact: joint RMS at the default step",
            "°",
            (errors_deg[1], 0.0),
            errors_deg[1],
            errors_deg[1],
            0.5,
            Measure::Absolute,
        )
        .with_core_errors(CoreSeen {
            value: core_deg[1],
            to_rapier: joint_rms_deg(&joint_errors(&core, &ours)),
            to_mujoco: core_deg[1],
        })
        .at(format!("240 Hz, {SUBSTEPS} substeps, {end_s:.1} s; most at `{name}`"))
        .because("both integrators are first order: the error halves with the step, as the orders below say"),
    ];
    for k in 0..3 {
        // below the rounding of the comparison the order cannot be measured
        if errors_deg[k + 1] > 1e-6 {
            let order = (errors_deg[k] / errors_deg[k + 1]).log2();
            let name =
                format!("motion without contact: order from {} to {} Hz", RATES_HZ[k], RATES_HZ[k + 1]);
            let value = (core_deg[k] / core_deg[k + 1]).log2();
            let errors = format!(
                "rapier {:.4}° to {:.4}°, core {:.4}° to {:.4}°",
                errors_deg[k],
                errors_deg[k + 1],
                core_deg[k],
                core_deg[k + 1]
            );
            let check =
                Check::absolute(&name, "", order, 1.0, 0.25).with_core_off(value, (value - 1.0).abs());
            checks.push(check.at(errors));
        }
    }
    let clips = [ours, reference, core];
    Ok(ForwardRun { checks, nothing: Vec::new(), errors_deg, core_deg, link, clips })
}
