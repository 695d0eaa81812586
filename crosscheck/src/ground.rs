//! Contact of bodies: one standing, a scene on its feet. A single box is in [`crate::box_contact`].
//!
//! In: MuJoCo, a take. Out: checks of contact forces, and the curves behind them. Each engine starts from the
//! same pose and settles to its own rest.
//!
//! Compliance. Bodies stand on contacts as stiff as each solver allows: rapier's default of
//! `sim` and MuJoCo's `solref` (4 ms, critically damped); how deep each sinks is stated beside the forces.
//!
//! MuJoCo integrates with `discrete`, which lets the contact solver see the implicit damping. With
//! `implicitfast` it does not, and the damping of an ankle, huge against the inertia of a foot, makes the feet
//! rock between heel and toe: forces then differ by tens of % of body weight for single steps.

use controllers::{BalanceSettings, GainBlend, Goal, Setup};
use dynamics::fall::Fall;
use dynamics::{RootMode, Trace};
use motion::Clip;
use sim::{Outcome, Pass, PassError, core, rapier};
use takes::Take;

use crate::bridge::Shared;
use crate::check::{Check, CoreSeen, Measure, ratio};
use crate::engine::{engine_in, standing};
use crate::mujoco::Integration;

/// How long the standing check lasts, and the span at its end that is averaged, s.
const STAND: f64 = 3.0;
const STILL: f64 = 0.5;

/// The take's body standing at its first frame: mean vertical force over the last half second.
///
/// # Errors
/// Of either engine.
pub fn standing_weight(bridge: &Shared, take: &Take) -> Result<Check, PassError> {
    let still = |take: &Take| -> Pass {
        let first = take.asked.clip.pose(0).to_vec();
        let frames = (STAND * take.asked.clip.rate_hz) as usize;
        let clip =
            Clip::new(take.body.character.skeleton.clone(), take.asked.clip.rate_hz, first.repeat(frames));
        let p = &take.conditions.physics;
        Pass {
            setup: Setup {
                character: take.body.character.clone(),
                gravity: p.gravity,
                goal: Goal::new(&clip, take.control_rate_hz()),
                tracks: None,
                dense: Default::default(),
                tension: 1.0,
                plants: take.asked.plants.clone(),
                ground_m: p.ground.map(|g| g.height_m),
                contacts: motion::ContactPlan::default(),
                balance: BalanceSettings::default(),
                blend: GainBlend::RestAngle,
            },
            reactive: Vec::new(),
            substeps: p.substeps,
            root: RootMode::Free,
            ground: p.ground,
            tilts: Vec::new(),
            props: take.conditions.props.clone(),
            self_collision: take.conditions.self_collision,
            pushes: Vec::new(),
            carried: Vec::new(),
            past_fall: false,
            foresight: None,
            soles: take.soles(),
        }
    };
    let ours = still(take).run(&rapier::engine(), &mut |_| {})?.trace;
    let core = still(take).run(&core::engine(), &mut |_| {})?.trace;
    let theirs = in_mujoco(bridge, still(take), &standing(), f64::INFINITY, &mut |_| {})?.trace;
    let weight = take.body.character.mass() * take.conditions.physics.gravity.norm();
    let mean = |t: &Trace| {
        let sums = t.contact_sums();
        let n = ((STILL * t.rate_hz) as usize).min(sums.len());
        sums[sums.len() - n..].iter().map(|f| f.y).sum::<f64>() / n as f64
    };
    let (a, b, c) = (mean(&ours), mean(&theirs), mean(&core));
    let error = (a - weight).abs().max((b - weight).abs());
    let off = (c - weight).abs() / weight;
    let check = Check::of("standing weight", "N", (a, b), error, error / weight, 1e-3, Measure::Relative)
        .with_core_off(c, off);
    Ok(check.at(format!("mean of the last {STILL} s of {STAND}; m g = {weight:.2} N")))
}

/// Runs a pass in MuJoCo up to `end_s`.
///
/// # Errors
/// Of the engine; a divergence is one here.
pub fn in_mujoco(
    bridge: &Shared,
    pass: Pass,
    integration: &Integration,
    end_s: f64,
    progress: &mut dyn FnMut(f64),
) -> Result<Outcome, PassError> {
    let rate = pass.setup.goal.rate_hz;
    let mut run = pass.start(&engine_in(bridge, integration.clone()))?;
    let last = ((end_s * rate).min(run.rows() as f64)) as usize;
    while run.row() < last && run.step()? {
        if run.row().is_multiple_of(64) {
            progress(run.row() as f64 / last as f64);
        }
    }
    let outcome = run.finish();
    match outcome.diverged {
        Some(error) => Err(error.into()),
        None => Ok(outcome),
    }
}

/// A scene performed on its feet in three engines.
pub struct SceneRun {
    /// The checks.
    pub checks: Vec<Check>,
    /// What there is nothing to compare of, with the reason.
    pub nothing: Vec<String>,
    /// The trace of rapier's run.
    pub ours: Trace,
    /// The trace of MuJoCo's run.
    pub theirs: Trace,
    /// The trace of the core's run.
    pub core: Trace,
}

/// Forces of the first half second are not compared: each engine settles to its own rest.
const SETTLE: f64 = 0.5;
/// A jump of the total vertical force within one control step, part of the body weight, that is an impact.
const IMPACT: f64 = 0.02;
/// Around an impact forces are compared by their impulse, s.
const AROUND: f64 = 0.05;

/// Shorter spans before a fall have no forces to compare, s.
const LEAST_SPAN: f64 = 0.5;

/// Whether the body stands (1) or falls (0) in each engine.
fn verdict(ours: &Outcome, theirs: &Outcome, core: &Outcome) -> Check {
    let stands = |o: &Outcome| f64::from(u8::from(o.fell_s.is_none()));
    let end = |o: &Outcome| o.fall.as_ref().map_or_else(|| o.verdict.ending.to_string(), Fall::to_string);
    let at = match (ours.fell_s, theirs.fell_s, core.fell_s) {
        (None, None, None) => "stands in all three".to_owned(),
        _ => format!("core: {}; rapier: {}; MuJoCo: {}", end(core), end(ours), end(theirs)),
    };
    Check::absolute("scene: verdict, 1 stands or 0 falls", "", stands(ours), stands(theirs), 0.0)
        .with_core(stands(core), 1.0)
        .at(at)
}

/// An RMS difference below this part of the body weight is noise of the contact solvers and has no order.
const VISIBLE: f64 = 3e-4;

/// Performs the take in the core, in rapier and in MuJoCo, controllers closed over each engine's own state, and compares whether the
/// body stands and the vertical ground forces: until a margin of balance is lost, if it falls.
///
/// An impact (an edge of a foot that lands) happens a few milliseconds apart in the two; there the impulse over
/// ±50 ms is compared, and elsewhere the force step by step.
///
/// # Errors
/// Of either engine.
pub fn scene(bridge: &Shared, take: &Take, progress: &mut dyn FnMut(f64)) -> Result<SceneRun, PassError> {
    let (core, ours, theirs) = (
        take.pass().run(&core::engine(), &mut |_| {})?,
        take.pass().run(&rapier::engine(), &mut |_| {})?,
        in_mujoco(bridge, take.pass(), &standing(), f64::INFINITY, &mut |x| progress(0.5 * x))?,
    );
    if let Some(error) = ours.diverged.clone().or(core.diverged.clone()) {
        return Err(error.into());
    }
    let verdict = verdict(&ours, &theirs, &core);
    let falls = [&ours.fall, &theirs.fall, &core.fall];
    let lost_s = falls.into_iter().flatten().map(Fall::first_s).fold(f64::INFINITY, f64::min);
    let (mut ours, mut theirs, mut core) = (ours.trace, theirs.trace, core.trace);
    if lost_s < SETTLE + LEAST_SPAN {
        let nothing = vec!["scene: forces: it falls before they can be compared".into()];
        return Ok(SceneRun { checks: vec![verdict], nothing, ours, theirs, core });
    }
    let before = |t: &Trace| ((lost_s * t.rate_hz) as usize).clamp(1, t.rows());
    ours = ours.cut(0..before(&ours));
    theirs = theirs.cut(0..before(&theirs));
    core = core.cut(0..before(&core));
    let mut finer = take.clone();
    finer.conditions.physics.rate_hz = Some(2.0 * take.control_rate_hz());
    let finer_ours = finer.pass().run(&rapier::engine(), &mut |_| {})?.trace;
    let finer_theirs =
        in_mujoco(bridge, finer.pass(), &standing(), lost_s, &mut |x| progress(0.5 + 0.5 * x))?.trace;
    let finer_core = finer.pass().run(&core::engine(), &mut |_| {})?.trace;
    let finer_core = finer_core.cut(0..before(&finer_core));
    let finer_ours = finer_ours.cut(0..before(&finer_ours));
    let finer_theirs = finer_theirs.cut(0..before(&finer_theirs));
    let weight = take.body.character.mass() * take.conditions.physics.gravity.norm();
    let total = |t: &Trace| Vertical::of(t, None);
    let (a, b, c) = (total(&ours), total(&theirs), total(&core));
    let gap = a.compare(&b, weight);
    // every pair spares the steps around its own impacts
    let (to_mujoco, to_rapier) = (c.compare(&b, weight), c.compare(&a, weight));
    if gap.count == 0 {
        let why = format!("every step is within {SETTLE} s of the start or {AROUND} s of an impact");
        let nothing = vec![format!("scene: forces: {why}")];
        return Ok(SceneRun { checks: vec![verdict], nothing, ours, theirs, core });
    }
    let half = total(&finer_ours).compare(&total(&finer_theirs), weight);
    let half_core = total(&finer_core).compare(&total(&finer_theirs), weight);
    let sink = |t: &Trace| {
        let deepest = t.contacts.iter().filter(|c| c.row + 1 == t.rows()).map(|c| c.depth);
        1e3 * deepest.fold(0.0, f64::max)
    };
    let compliance = format!(
        "contacts as stiff as each solver allows: at the end the soles are {:.3} mm (core), {:.3} mm (rapier) and {:.3} mm (MuJoCo) deep",
        sink(&core),
        sink(&ours),
        sink(&theirs)
    );
    let reason = format!(
        "the integrators and the held drives are first order: at half the step the RMS difference to MuJoCo goes from {:.3} % to {:.3} % of body weight in rapier, from {:.3} % to {:.3} % in the core",
        100.0 * gap.rms,
        100.0 * half.rms,
        100.0 * to_mujoco.rms,
        100.0 * half_core.rms
    );
    let percent = |name: &str, of: fn(&Gap) -> f64, allowed: f64| {
        let (share, at) = (of(&gap), gap.at);
        let (x, y) = (a.force[at], b.force[at]);
        let value = c.force.get(at).copied().unwrap_or(f64::NAN);
        Check::of(name, "N", (x, y), share * weight, share, allowed, Measure::Relative)
            .with_core_errors(CoreSeen { value, to_rapier: of(&to_rapier), to_mujoco: of(&to_mujoco) })
            .at(format!("{:.3} s", at as f64 / a.rate_hz))
    };
    let mut checks = vec![
        verdict,
        percent("scene: vertical force, RMS difference", |g| g.rms, 0.01)
            .because(format!("{reason}; {compliance}")),
        percent("scene: vertical force, largest difference", |g| g.peak, 0.05),
    ];
    for leg in take.body.character.legs() {
        let leg_of = |t: &Trace| Vertical::of(t, Some(leg.end));
        let (x, y, z) = (leg_of(&ours), leg_of(&theirs), leg_of(&core));
        let g = x.compare_spared(&y, weight, &gap.spared);
        let core = CoreSeen {
            value: z.force.get(g.at).copied().unwrap_or(f64::NAN),
            to_rapier: z.compare_spared(&x, weight, &to_rapier.spared).rms,
            to_mujoco: z.compare_spared(&y, weight, &to_mujoco.spared).rms,
        };
        let name = format!("scene: vertical force of {}, RMS difference", leg.name);
        let check = Check::of(
            &name,
            "N",
            (x.force[g.at], y.force[g.at]),
            g.rms * weight,
            g.rms,
            0.02,
            Measure::Relative,
        );
        checks.push(check.with_core_errors(core).at(format!("{:.3} s", g.at as f64 / x.rate_hz)));
    }
    if gap.rms > VISIBLE {
        let mut order = Check::absolute(
            "scene: difference at half the step over the difference",
            "",
            ratio(half.rms, gap.rms),
            0.5,
            0.25,
        );
        if to_mujoco.rms > VISIBLE {
            let value = ratio(half_core.rms, to_mujoco.rms);
            order = order.with_core_off(value, (value - 0.5).abs());
        }
        checks.push(order.at("MuJoCo's column: what first order predicts"));
    }
    let off = |at: usize| ratio((a.impulse(at) - b.impulse(at)).abs(), b.impulse(at).abs());
    if let Some(&(at, _)) = gap.impacts.iter().max_by(|x, y| off(x.0).total_cmp(&off(y.0))) {
        let times: Vec<String> =
            gap.impacts.iter().map(|(k, _)| format!("{:.2}", *k as f64 / a.rate_hz)).collect();
        let largest = gap.impacts.iter().map(|i| i.1).fold(0.0, f64::max);
        let (x, y, z) = (a.impulse(at), b.impulse(at), c.impulse(at));
        let reason = format!(
            "edges of the feet land a few milliseconds apart in the engines, with jumps of up to {:.0} % of body weight in one step, at {} s",
            100.0 * largest,
            times.join(", ")
        );
        checks.push(
            Check::relative("scene: impulse around an impact, ±50 ms", "N·s", x, y, y.abs(), 0.02)
                .with_core(z, y.abs())
                .at(format!("{:.3} s, the worst of {}", at as f64 / a.rate_hz, times.len()))
                .because(reason),
        );
    }
    Ok(SceneRun { checks, nothing: Vec::new(), ours, theirs, core })
}

struct Vertical {
    rate_hz: f64,
    force: Vec<f64>,
}

struct Gap {
    /// Steps compared.
    count: usize,
    rms: f64,
    peak: f64,
    at: usize,
    spared: Vec<bool>,
    impacts: Vec<(usize, f64)>,
}

impl Vertical {
    /// Vertical ground force of each row, N: of a link, or in total.
    fn of(trace: &Trace, link: Option<usize>) -> Self {
        let mut force = vec![0.0; trace.rows()];
        for c in trace.contacts.iter().filter(|c| link.is_none_or(|l| belongs(trace, c.link, l))) {
            force[c.row] += c.force.y;
        }
        Self { rate_hz: trace.rate_hz, force }
    }

    fn compare(&self, other: &Self, weight: f64) -> Gap {
        let n = self.force.len().min(other.force.len());
        let settled = (SETTLE * self.rate_hz) as usize;
        let near = (AROUND * self.rate_hz) as usize;
        let mut spared = vec![false; n];
        let mut impacts: Vec<(usize, f64)> = Vec::new();
        for k in settled.max(1)..n {
            let jump = |f: &[f64]| (f[k] - f[k - 1]).abs() / weight;
            let jump = jump(&self.force).max(jump(&other.force));
            if jump > IMPACT {
                match impacts.last_mut() {
                    Some((at, share)) if k - *at <= near => *share = share.max(jump),
                    _ => impacts.push((k, jump)),
                }
                spared[k.saturating_sub(near)..(k + near + 1).min(n)].fill(true);
            }
        }
        let mut gap = self.compare_spared(other, weight, &spared);
        gap.spared = spared;
        gap.impacts = impacts;
        gap
    }

    fn compare_spared(&self, other: &Self, weight: f64, spared: &[bool]) -> Gap {
        let settled = (SETTLE * self.rate_hz) as usize;
        let (mut sum, mut count, mut peak, mut at) =
            (0.0, 0_usize, 0.0, settled.min(spared.len().saturating_sub(1)));
        for k in settled..spared.len() {
            if spared[k] {
                continue;
            }
            let d = (self.force[k] - other.force[k]).abs() / weight;
            sum += d * d;
            count += 1;
            if d > peak {
                (peak, at) = (d, k);
            }
        }
        let rms = ratio(sum, count as f64).sqrt();
        Gap { count, rms, peak, at, spared: Vec::new(), impacts: Vec::new() }
    }

    fn impulse(&self, at: usize) -> f64 {
        let near = (AROUND * self.rate_hz) as usize;
        let span = at.saturating_sub(near)..(at + near + 1).min(self.force.len());
        self.force[span].iter().sum::<f64>() / self.rate_hz
    }
}

/// Whether a link hangs on `on` or is it.
fn belongs(trace: &Trace, link: usize, on: usize) -> bool {
    trace.character.skeleton.ancestors(link).any(|l| l == on)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vertical(force: Vec<f64>) -> Vertical {
        Vertical { rate_hz: 100.0, force }
    }

    /// Of no steps, and of steps that are all spared, nothing is compared: the count says so, and no number is made up.
    #[test]
    fn nothing_compared_is_counted_as_nothing() {
        for force in [vec![], vec![1.0], vec![0.0; 50]] {
            let gap = vertical(force.clone()).compare(&vertical(force), 700.0);
            assert_eq!((gap.count, gap.rms, gap.peak), (0, 0.0, 0.0));
        }
        let jumps: Vec<f64> = (0..60).map(|k| f64::from(k % 2) * 700.0).collect();
        assert_eq!(vertical(jumps.clone()).compare(&vertical(jumps), 700.0).count, 0);
    }

    #[test]
    fn zeros_agree_and_differences_are_parts_of_the_weight() {
        let zeros = vertical(vec![0.0; 80]).compare(&vertical(vec![0.0; 80]), 700.0);
        assert_eq!((zeros.count, zeros.rms, zeros.peak), (30, 0.0, 0.0));
        let apart = vertical(vec![7.0; 80]).compare(&vertical(vec![0.0; 80]), 700.0);
        assert!((apart.rms - 0.01).abs() < 1e-15 && apart.peak == 0.01, "{} {}", apart.rms, apart.peak);
        assert_eq!(vertical(vec![]).impulse(0), 0.0);
    }
}
