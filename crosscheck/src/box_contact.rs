//! Contact of a single box: at rest on level ground, on a slope, landing.
//!
//! In: MuJoCo. Out: checks of contact forces against the other engine and against what statics says, and the curves of the
//! landing. Y up, SI.
//!
//! Compliance. The box lands on spring contacts of a known stiffness and damping on both sides (see
//! [`landing`]), resolved by the step. At rest it lies on contacts as stiff as each solver allows.

use std::sync::Arc;

use bodies::{Body, Character, JointClass};
use motion::{Floor, Joint, Link, Quat, Shape, Skeleton, Vec3};
use nalgebra::Matrix3;
use sim::{ContactLaw, Engine, EngineError, EngineSettings, core, rapier};

use crate::bridge::Shared;
use crate::check::{Check, Measure, ratio};
use crate::engine::{engine_in, standing};
use crate::mujoco::Integration;

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

fn box_settings(rate_hz: f64, gravity: Vec3, contact: ContactLaw) -> EngineSettings {
    let ground = Some(Floor::level(0.0, 0.8));
    EngineSettings {
        rate_hz,
        substeps: 1,
        gravity,
        ground,
        pinned: false,
        contact,
        props: Default::default(),
        self_collision: false,
    }
}

/// Total contact force of each step.
fn forces(engine: &mut dyn Engine, steps: usize) -> Result<Vec<Vec3>, EngineError> {
    let mut touching = Vec::new();
    let mut out = Vec::with_capacity(steps);
    for _ in 0..steps {
        engine.step()?;
        touching.clear();
        engine.contacts(&mut touching);
        out.push(touching.iter().map(|c| c.force).sum());
    }
    Ok(out)
}

/// A box at rest on level ground and on a slope (gravity tilted by 0.3 rad; friction 0.8 holds it).
///
/// # Errors
/// Of either engine.
pub fn resting_box(bridge: &Shared) -> Result<Vec<Check>, EngineError> {
    let character = solid_box();
    let mut q = character.rest.clone();
    q[1] = BOX_HALF[1];
    let v = [0.0; 6];
    let mut checks = Vec::new();
    for (name, tilt) in [("box at rest", 0.0), ("box on a slope", SLOPE)] {
        let gravity = Vec3::new(G * f64::sin(tilt), -G * f64::cos(tilt), 0.0);
        let settings = box_settings(240.0, gravity, ContactLaw::Stiff);
        let mut ours = rapier::engine().build(&character, settings.clone(), &q, &v)?;
        let mut fast = core::engine().build(&character, settings.clone(), &q, &v)?;
        let mut theirs = engine_in(bridge, standing()).build(&character, settings, &q, &v)?;
        let last = |f: Vec<Vec3>| f[f.len() - 60..].iter().sum::<Vec3>() / 60.0;
        let (a, b) = (last(forces(ours.as_mut(), 480)?), last(forces(theirs.as_mut(), 480)?));
        let c = last(forces(fast.as_mut(), 480)?);
        let expected = -gravity * BOX_MASS;
        let weight = BOX_MASS * G;
        let mut both = |what: &str, axis: usize| {
            let off = |x: Vec3| (x[axis] - expected[axis]).abs();
            let (error, core) = (off(a).max(off(b)), off(c) / weight);
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
                .with_core_off(c[axis], core)
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
///
/// # Errors
/// If nothing lands.
fn first_contact(force: &[Vec3], rate_hz: f64) -> Result<Landing, EngineError> {
    let nothing = || EngineError::Failed("the box of the landing touches nothing".into());
    let start = force.iter().position(|f| f.y > 0.0).ok_or_else(nothing)?;
    let length = force[start..].iter().take_while(|f| f.y > 0.0).count();
    let span = &force[start..start + length];
    // the ends at which the force crosses zero lie within the first and the last step
    Ok(Landing {
        impulse: span.iter().map(|f| f.y).sum::<f64>() / rate_hz,
        peak: span.iter().map(|f| f.y).fold(0.0, f64::max),
        time: length as f64 / rate_hz,
    })
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
    /// Vertical forces, N: rapier's, MuJoCo's and the core's.
    pub force: [Vec<f64>; 3],
}

/// A box dropped flat onto springs of matched compliance.
///
/// rapier gives each of the four corners stiffness m' ω² and damping 2 ζ m' ω with its apparent mass
/// m' = 1/(1/m + (r × n)ᵀ I⁻¹ (r × n)). MuJoCo in direct mode (negative `solref`) with impedance d → 0 gives
/// each stiffness m K and damping m D; K = ω² m'/m and D = 2 ζ ω m'/m make them the same springs.
///
/// # Errors
/// Of either engine.
pub fn landing(bridge: &Shared) -> Result<LandingRun, EngineError> {
    let landings = |forces: &[Vec<Vec3>; 3], rate_hz: f64| -> Result<[Landing; 3], EngineError> {
        Ok([
            first_contact(&forces[0], rate_hz)?,
            first_contact(&forces[1], rate_hz)?,
            first_contact(&forces[2], rate_hz)?,
        ])
    };
    let forces = drop(bridge, BOX_RATE_HZ, LANDING_HZ)?;
    let [ours, mujoco, core] = landings(&forces, BOX_RATE_HZ)?;
    let half_step = drop(bridge, 2.0 * BOX_RATE_HZ, LANDING_HZ)?;
    let [finer, reference, finer_core] = landings(&half_step, 2.0 * BOX_RATE_HZ)?;
    let off = |l: &Landing| (l.peak - reference.peak) / reference.peak;
    let (gap, core_gap) = ([off(&ours), off(&finer)], [off(&core), off(&finer_core)]);
    let stiffer = drop(bridge, BOX_RATE_HZ, 2.0 * LANDING_HZ)?;
    let stiffer = landings(&stiffer, BOX_RATE_HZ)?.map(|l| l.peak);
    let compliance = format!(
        "four corner springs of {LANDING_HZ} Hz and damping ratio {LANDING_ZETA} per apparent mass on all sides"
    );
    let reason = format!(
        "steps are first order: halving them takes the gap of the peak from {:+.2} % to {:+.2} % in rapier, from {:+.2} % to {:+.2} % in the core. Twice the natural frequency takes the peaks to {:.0} N (core), {:.0} N (rapier) and {:.0} N (MuJoCo) together",
        100.0 * gap[0],
        100.0 * gap[1],
        100.0 * core_gap[0],
        100.0 * core_gap[1],
        stiffer[2],
        stiffer[0],
        stiffer[1]
    );
    let check = |what: &str, unit: &str, of: fn(&Landing) -> f64, threshold: f64| {
        let (x, y) = (of(&ours), of(&mujoco));
        Check::relative(&format!("landing: {what}"), unit, x, y, y.abs(), threshold)
            .with_core(of(&core), y.abs())
            .at(compliance.clone())
    };
    let halved = ratio(core_gap[1], core_gap[0]);
    let checks = vec![
        check("impulse", "N·s", |l| l.impulse, 0.01),
        check("peak force", "N", |l| l.peak, 0.10).because(reason),
        check("contact time", "s", |l| l.time, 0.10),
        // the reason itself is checked: first order halves the gap
        Check::absolute(
            "landing: gap of the peak at half the step over the gap",
            "",
            ratio(gap[1], gap[0]),
            0.5,
            0.2,
        )
        .with_core_off(halved, (halved - 0.5).abs())
        .at("MuJoCo's column: what first order predicts"),
    ];
    let vertical = |f: &Vec<Vec3>| f.iter().map(|f| f.y).collect();
    Ok(LandingRun { checks, rate_hz: BOX_RATE_HZ, force: forces.each_ref().map(vertical) })
}

/// Vertical forces of a box dropped onto springs: in rapier, in MuJoCo, in the core.
fn drop(bridge: &Shared, rate_hz: f64, natural_hz: f64) -> Result<[Vec<Vec3>; 3], EngineError> {
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
    let mut ours = rapier::engine().build(&character, settings.clone(), &q, &v)?;
    let mut theirs = engine_in(bridge, integration).build(&character, settings.clone(), &q, &v)?;
    let mut core = core::engine().build(&character, settings, &q, &v)?;
    Ok([forces(ours.as_mut(), steps)?, forces(theirs.as_mut(), steps)?, forces(core.as_mut(), steps)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_landing_without_contact_is_an_error() {
        for forces in [vec![], vec![Vec3::zeros(); 4], vec![-Vec3::y(); 2]] {
            assert!(first_contact(&forces, 100.0).is_err(), "{forces:?}");
        }
        let forces = [0.0, 2.0, 4.0, 0.0, 9.0].map(|y| Vec3::new(0.0, y, 0.0));
        let landing = first_contact(&forces, 100.0).expect("a contact");
        assert_eq!((landing.impulse, landing.peak, landing.time), (0.06, 4.0, 0.02));
    }
}
