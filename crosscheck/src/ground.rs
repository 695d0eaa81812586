//! Contact: a box at rest, on a slope and landing; a body standing; a scene on its feet.
//!
//! In: MuJoCo, a stage. Out: checks of contact forces, and the curves behind them. Each engine starts from the
//! same pose and settles to its own rest.
//!
//! Compliance. The box lands on spring contacts of a known stiffness and damping on both sides (see
//! [`landing`]), resolved by the step. Bodies stand on contacts as stiff as each solver allows: rapier's default of
//! `sim` and MuJoCo's `solref` (4 ms, critically damped); how deep each sinks is stated beside the forces.
//!
//! MuJoCo integrates with `discrete`, which lets the contact solver see the implicit damping. With
//! `implicitfast` it does not, and the damping of an ankle, huge against the inertia of a foot, makes the feet
//! rock between heel and toe: forces then differ by tens of % of body weight for single steps.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use controllers::{BalanceSettings, GainBlend, Goal, Setup};
use dynamics::fall::Fall;
use dynamics::{Body, Character, JointClass, RootMode, Trace};
use motion::{Clip, Joint, Link, Quat, Shape, Skeleton, Vec3};
use nalgebra::Matrix3;
use scenes::Stage;
use sim::{ContactLaw, Engine, Ground, Outcome, Pass, PassError, World, WorldError, WorldSettings};

use crate::bridge::Bridge;
use crate::check::{Check, Measure};
use crate::world::{Integration, MujocoWorld};

/// A MuJoCo shared by the runs of a cross-check.
pub type Shared = Rc<RefCell<Bridge>>;

/// How bodies stand in MuJoCo.
pub fn standing() -> Integration {
    Integration {
        integrator: "discrete",
        substeps: 8,
        solref: Some([0.004, 1.0]),
        solimp: Some([0.9, 0.95, 0.001, 0.5, 2.0]),
    }
}

const G: f64 = 9.81;
const BOX_MASS: f64 = 12.0;
const BOX_HALF: [f64; 3] = [0.15, 0.1, 0.2];
const BOX_RATE_HZ: f64 = 1920.0;
const SLOPE: f64 = 0.3;

fn solid_box() -> Character {
    let half = Vec3::from(BOX_HALF);
    let square = half.component_mul(&half) * (BOX_MASS / 3.0);
    let inertia = Vec3::new(square.y + square.z, square.x + square.z, square.x + square.y);
    let link = Link::new("box", None, Vec3::zeros(), Joint::Free);
    let skeleton = Arc::new(Skeleton::new(vec![link]).expect("one link"));
    let shapes = vec![Shape::Box { center: Vec3::zeros(), half, rotation: Quat::identity() }];
    Character {
        name: "box".into(),
        bodies: vec![Body {
            mass: BOX_MASS,
            com: Vec3::zeros(),
            inertia: Matrix3::from_diagonal(&inertia),
            shapes,
        }],
        classes: vec![JointClass::Root],
        contacts: Vec::new(),
        rest: skeleton.zero_pose(),
        skeleton,
    }
}

fn box_settings(rate_hz: f64, gravity: Vec3, contact: ContactLaw) -> WorldSettings {
    let ground = Some(Ground::level(0.0, 0.8));
    WorldSettings { rate_hz, substeps: 1, gravity, ground, pinned: false, contact }
}

/// Total contact force of each step.
fn forces(world: &mut impl Engine, steps: usize) -> Result<Vec<Vec3>, WorldError> {
    let mut touching = Vec::new();
    let mut out = Vec::with_capacity(steps);
    for _ in 0..steps {
        world.step()?;
        touching.clear();
        world.contacts(0, &mut touching);
        out.push(touching.iter().map(|c| c.force).sum());
    }
    Ok(out)
}

/// A box at rest on level ground and on a slope (gravity tilted by 0.3 rad; friction 0.8 holds it).
///
/// # Errors
/// Of either engine.
pub fn resting_box(bridge: &Shared) -> Result<Vec<Check>, WorldError> {
    let character = solid_box();
    let mut q = character.rest.clone();
    q[1] = BOX_HALF[1];
    let v = [0.0; 6];
    let mut checks = Vec::new();
    for (name, tilt) in [("box at rest", 0.0), ("box on a slope", SLOPE)] {
        let gravity = Vec3::new(G * f64::sin(tilt), -G * f64::cos(tilt), 0.0);
        let settings = box_settings(240.0, gravity, ContactLaw::Stiff);
        let mut ours = World::new(&character, settings, &q, &v)?;
        let mut theirs = MujocoWorld::new(bridge.clone(), &standing(), &character, settings, &q, &v)?;
        let last = |f: Vec<Vec3>| f[f.len() - 60..].iter().sum::<Vec3>() / 60.0;
        let (a, b) = (last(forces(&mut ours, 480)?), last(forces(&mut theirs, 480)?));
        let expected = -gravity * BOX_MASS;
        let weight = BOX_MASS * G;
        let mut both = |what: &str, axis: usize| {
            let error = (a[axis] - expected[axis]).abs().max((b[axis] - expected[axis]).abs());
            checks.push(
                Check::of(
                    &format!("{name}: {what}"),
                    "N",
                    (a[axis], b[axis]),
                    error,
                    error / weight,
                    1e-3,
                    Measure::Relative,
                )
                .at(format!("against {:.4} N", expected[axis])),
            );
        };
        both("normal force", 1);
        if tilt > 0.0 {
            both("friction", 0);
        }
    }
    Ok(checks)
}

/// A landing in numbers.
#[derive(Clone, Copy, Debug)]
struct Landing {
    impulse: f64,
    peak: f64,
    time: f64,
}

/// First contact of a series of vertical forces: from the first load to the first step without.
fn first_contact(force: &[Vec3], rate_hz: f64) -> Landing {
    let start = force.iter().position(|f| f.y > 0.0).unwrap_or(0);
    let length = force[start..].iter().take_while(|f| f.y > 0.0).count();
    let span = &force[start..start + length];
    // the ends at which the force crosses zero lie within the first and the last step
    Landing {
        impulse: span.iter().map(|f| f.y).sum::<f64>() / rate_hz,
        peak: span.iter().map(|f| f.y).fold(0.0, f64::max),
        time: length as f64 / rate_hz,
    }
}

/// Drop height, natural frequency and damping ratio of the landing.
const DROP: f64 = 0.05;
const LANDING_HZ: f64 = 8.0;
const LANDING_ZETA: f64 = 0.2;

/// Curves of a landing, for the page.
pub struct LandingRun {
    /// The checks.
    pub checks: Vec<Check>,
    /// Steps per second.
    pub rate_hz: f64,
    /// Vertical forces, N: rapier's and MuJoCo's.
    pub force: [Vec<f64>; 2],
}

/// A box dropped flat onto springs of matched compliance.
///
/// rapier gives each of the four corners stiffness m' ω² and damping 2 ζ m' ω with its apparent mass
/// m' = 1/(1/m + (r × n)ᵀ I⁻¹ (r × n)). MuJoCo in direct mode (negative `solref`) with impedance d → 0 gives
/// each stiffness m K and damping m D; K = ω² m'/m and D = 2 ζ ω m'/m make them the same springs.
///
/// # Errors
/// Of either engine.
pub fn landing(bridge: &Shared) -> Result<LandingRun, WorldError> {
    let (a, theirs) = drop(bridge, BOX_RATE_HZ, LANDING_HZ)?;
    let (ours, mujoco) = (first_contact(&a, BOX_RATE_HZ), first_contact(&theirs, BOX_RATE_HZ));
    let half_step = drop(bridge, 2.0 * BOX_RATE_HZ, LANDING_HZ)?;
    let finer = first_contact(&half_step.0, 2.0 * BOX_RATE_HZ);
    let reference = first_contact(&half_step.1, 2.0 * BOX_RATE_HZ);
    let gap = [(ours.peak - reference.peak) / reference.peak, (finer.peak - reference.peak) / reference.peak];
    let stiffer = drop(bridge, BOX_RATE_HZ, 2.0 * LANDING_HZ)?;
    let stiffer = [first_contact(&stiffer.0, BOX_RATE_HZ).peak, first_contact(&stiffer.1, BOX_RATE_HZ).peak];
    let compliance = format!(
        "four corner springs of {LANDING_HZ} Hz and damping ratio {LANDING_ZETA} per apparent mass on both sides"
    );
    let reason = format!(
        "rapier's step is first order: halving it takes the gap of the peak from {:+.2} % to {:+.2} %. Twice the natural frequency takes the peaks to {:.0} N and {:.0} N together",
        100.0 * gap[0],
        100.0 * gap[1],
        stiffer[0],
        stiffer[1]
    );
    let check = |what: &str, unit: &str, of: fn(&Landing) -> f64, threshold: f64| {
        let (x, y) = (of(&ours), of(&mujoco));
        Check::relative(&format!("landing: {what}"), unit, x, y, y.abs(), threshold).at(compliance.clone())
    };
    let checks = vec![
        check("impulse", "N·s", |l| l.impulse, 0.01),
        check("peak force", "N", |l| l.peak, 0.10).because(reason),
        check("contact time", "s", |l| l.time, 0.10),
        // the reason itself is checked: first order halves the gap
        Check::absolute(
            "landing: gap of the peak at half the step over the gap",
            "",
            gap[1] / gap[0],
            0.5,
            0.2,
        )
        .at("MuJoCo's column: what first order predicts"),
    ];
    let vertical = |f: &[Vec3]| f.iter().map(|f| f.y).collect();
    Ok(LandingRun { checks, rate_hz: BOX_RATE_HZ, force: [vertical(&a), vertical(&theirs)] })
}

fn drop(bridge: &Shared, rate_hz: f64, natural_hz: f64) -> Result<(Vec<Vec3>, Vec<Vec3>), WorldError> {
    let character = solid_box();
    let mut q = character.rest.clone();
    q[1] = BOX_HALF[1] + DROP;
    let v = [0.0; 6];
    let inertia = &character.bodies[0].inertia;
    let [x, _, z] = BOX_HALF;
    let apparent = 1.0 / (1.0 / BOX_MASS + z * z / inertia[(0, 0)] + x * x / inertia[(2, 2)]);
    let omega = std::f64::consts::TAU * natural_hz;
    let share = apparent / BOX_MASS;
    let impedance = 1e-4;
    let integration = Integration {
        integrator: "rk4",
        substeps: 4,
        solref: Some([-omega * omega * share, -2.0 * LANDING_ZETA * omega * share]),
        solimp: Some([impedance, impedance, 0.001, 0.5, 2.0]),
    };
    let law = ContactLaw::Spring { natural_frequency_hz: natural_hz, damping_ratio: LANDING_ZETA };
    let settings = box_settings(rate_hz, Vec3::new(0.0, -G, 0.0), law);
    let steps = (0.35 * rate_hz) as usize;
    let mut ours = World::new(&character, settings, &q, &v)?;
    let mut theirs = MujocoWorld::new(bridge.clone(), &integration, &character, settings, &q, &v)?;
    Ok((forces(&mut ours, steps)?, forces(&mut theirs, steps)?))
}

/// How long the standing check lasts, and the span at its end that is averaged, s.
const STAND: f64 = 3.0;
const STILL: f64 = 0.5;

/// The stage's body standing at its first frame: mean vertical force over the last half second.
///
/// # Errors
/// Of either engine.
pub fn standing_weight(bridge: &Shared, stage: &Stage) -> Result<Check, PassError> {
    let still = |stage: &Stage| -> Pass {
        let first = stage.kinematic.pose(0).to_vec();
        let frames = (STAND * stage.kinematic.rate_hz) as usize;
        let clip = Clip::new(stage.character.skeleton.clone(), stage.kinematic.rate_hz, first.repeat(frames));
        let p = &stage.physics;
        Pass {
            setup: Setup {
                character: stage.character.clone(),
                gravity: p.gravity,
                goal: Goal::new(&clip, p.rate_hz),
                tracks: None,
                tension: 1.0,
                plants: stage.plants.clone(),
                ground_m: p.ground.map(|g| g.height_m),
                balance: BalanceSettings::default(),
                blend: GainBlend::RestAngle,
                reactive: Vec::new(),
            },
            substeps: p.substeps,
            root: RootMode::Free,
            ground: p.ground,
            tilts: Vec::new(),
            pushes: Vec::new(),
            carried: Vec::new(),
        }
    };
    let ours = still(stage).run(&mut |_| {})?.trace;
    let theirs = in_mujoco(bridge, still(stage), &standing(), f64::INFINITY, &mut |_| {})?.trace;
    let weight = stage.character.mass() * stage.physics.gravity.norm();
    let mean = |t: &Trace| {
        let sums = t.contact_sums();
        let n = ((STILL * t.rate_hz) as usize).min(sums.len());
        sums[sums.len() - n..].iter().map(|f| f.y).sum::<f64>() / n as f64
    };
    let (a, b) = (mean(&ours), mean(&theirs));
    let error = (a - weight).abs().max((b - weight).abs());
    let check = Check::of("standing weight", "N", (a, b), error, error / weight, 1e-3, Measure::Relative);
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
    let mut run =
        pass.start_in(|c, settings, q, v| MujocoWorld::new(bridge.clone(), integration, c, settings, q, v))?;
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

/// A scene performed on its feet in both engines.
pub struct SceneRun {
    /// The checks.
    pub checks: Vec<Check>,
    /// The trace of rapier's run.
    pub ours: Trace,
    /// The trace of MuJoCo's run.
    pub theirs: Trace,
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
fn verdict(ours: &Outcome, theirs: &Outcome) -> Check {
    let stands = |o: &Outcome| f64::from(u8::from(o.fell_s.is_none()));
    let end = |o: &Outcome| match (&o.fall, o.fell_s) {
        (Some(fall), _) => fall.to_string(),
        (None, Some(at)) => format!("falls at {at:.2} s"),
        (None, None) => "stands".to_owned(),
    };
    let at = match (ours.fell_s, theirs.fell_s) {
        (None, None) => "stands in both".to_owned(),
        _ => format!("rapier: {}; MuJoCo: {}", end(ours), end(theirs)),
    };
    Check::absolute("scene: verdict, 1 stands or 0 falls", "", stands(ours), stands(theirs), 0.0).at(at)
}

/// An RMS difference below this part of the body weight is noise of the contact solvers and has no order.
const VISIBLE: f64 = 3e-4;

/// Performs the stage in both engines, controllers closed over each engine's own state, and compares whether the
/// body stands and the vertical ground forces: until a margin of balance is lost, if it falls.
///
/// An impact (an edge of a foot that lands) happens a few milliseconds apart in the two; there the impulse over
/// ±50 ms is compared, and elsewhere the force step by step.
///
/// # Errors
/// Of either engine.
pub fn scene(bridge: &Shared, stage: &Stage, progress: &mut dyn FnMut(f64)) -> Result<SceneRun, PassError> {
    let (ours, theirs) = (
        stage.pass().run(&mut |_| {})?,
        in_mujoco(bridge, stage.pass(), &standing(), f64::INFINITY, &mut |x| progress(0.5 * x))?,
    );
    if let Some(error) = ours.diverged {
        return Err(error.into());
    }
    let verdict = verdict(&ours, &theirs);
    let lost_s =
        [&ours.fall, &theirs.fall].into_iter().flatten().map(Fall::first_s).fold(f64::INFINITY, f64::min);
    let (mut ours, mut theirs) = (ours.trace, theirs.trace);
    if lost_s < SETTLE + LEAST_SPAN {
        return Ok(SceneRun { checks: vec![verdict], ours, theirs });
    }
    let before = |t: &Trace| ((lost_s * t.rate_hz) as usize).clamp(1, t.rows());
    ours = ours.cut(0..before(&ours));
    theirs = theirs.cut(0..before(&theirs));
    let mut finer = stage.clone();
    finer.physics.rate_hz *= 2.0;
    let finer_ours = finer.pass().run(&mut |_| {})?.trace;
    let finer_theirs =
        in_mujoco(bridge, finer.pass(), &standing(), lost_s, &mut |x| progress(0.5 + 0.5 * x))?.trace;
    let finer_ours = finer_ours.cut(0..before(&finer_ours));
    let finer_theirs = finer_theirs.cut(0..before(&finer_theirs));
    let weight = stage.character.mass() * stage.physics.gravity.norm();
    let (a, b) = (Vertical::of(&ours, None), Vertical::of(&theirs, None));
    let gap = a.compare(&b, weight);
    let half = Vertical::of(&finer_ours, None).compare(&Vertical::of(&finer_theirs, None), weight);
    let sink = |t: &Trace| {
        let deepest = t.contacts.iter().filter(|c| c.row + 1 == t.rows()).map(|c| c.depth);
        1e3 * deepest.fold(0.0, f64::max)
    };
    let compliance = format!(
        "contacts as stiff as each solver allows: at the end the soles are {:.3} mm and {:.3} mm deep",
        sink(&ours),
        sink(&theirs)
    );
    let reason = format!(
        "both integrators and the held drives are first order: at half the step the RMS difference goes from {:.3} % to {:.3} % of body weight",
        100.0 * gap.rms,
        100.0 * half.rms
    );
    let percent = |name: &str, share: f64, at: usize, allowed: f64| {
        let (x, y) = (a.force[at], b.force[at]);
        Check::of(name, "N", (x, y), share * weight, share, allowed, Measure::Relative)
            .at(format!("{:.3} s", at as f64 / a.rate_hz))
    };
    let mut checks = vec![
        verdict,
        percent("scene: vertical force, RMS difference", gap.rms, gap.at, 0.01)
            .because(format!("{reason}; {compliance}")),
        percent("scene: vertical force, largest difference", gap.peak, gap.at, 0.05),
    ];
    for leg in stage.character.legs() {
        let (x, y) = (Vertical::of(&ours, Some(leg.end)), Vertical::of(&theirs, Some(leg.end)));
        let g = x.compare_spared(&y, weight, &gap.spared);
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
        checks.push(check.at(format!("{:.3} s", g.at as f64 / x.rate_hz)));
    }
    if gap.rms > VISIBLE {
        let order = Check::absolute(
            "scene: difference at half the step over the difference",
            "",
            half.rms / gap.rms,
            0.5,
            0.25,
        );
        checks.push(order.at("MuJoCo's column: what first order predicts"));
    }
    let off = |at: usize| (a.impulse(at) - b.impulse(at)).abs() / b.impulse(at).abs().max(f64::MIN_POSITIVE);
    if let Some(&(at, _)) = gap.impacts.iter().max_by(|x, y| off(x.0).total_cmp(&off(y.0))) {
        let times: Vec<String> =
            gap.impacts.iter().map(|(k, _)| format!("{:.2}", *k as f64 / a.rate_hz)).collect();
        let largest = gap.impacts.iter().map(|i| i.1).fold(0.0, f64::max);
        let (x, y) = (a.impulse(at), b.impulse(at));
        let reason = format!(
            "edges of the feet land a few milliseconds apart in the two, with jumps of up to {:.0} % of body weight in one step, at {} s",
            100.0 * largest,
            times.join(", ")
        );
        checks.push(
            Check::relative("scene: impulse around an impact, ±50 ms", "N·s", x, y, y.abs(), 0.02)
                .at(format!("{:.3} s, the worst of {}", at as f64 / a.rate_hz, times.len()))
                .because(reason),
        );
    }
    Ok(SceneRun { checks, ours, theirs })
}

struct Vertical {
    rate_hz: f64,
    force: Vec<f64>,
}

struct Gap {
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
            (0.0, 0, 0.0, settled.min(spared.len().saturating_sub(1)));
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
        Gap { rms: (sum / f64::from(count.max(1))).sqrt(), peak, at, spared: Vec::new(), impacts: Vec::new() }
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
