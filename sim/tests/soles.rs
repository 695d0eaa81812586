//! Laws of soles that yield, in every engine of this crate: how deep a body stands, how hard it lands, where its energy goes.

mod solids;

use bodies::soles::{Pad, Pads, Toes};
use bodies::{Body, Carried, Character, OnSoles, Soles};
use dynamics::{Against, Model, State};
use motion::rotation::exp;
use motion::{Floor, Joint, Limb, LimbKind, Link, Quat, Shape, Site, Skeleton, Vec3};
use sim::{Engine, EngineEntry, EngineSettings, core, rapier};
use solids::character;

const G: f64 = 9.81;
/// kg.
const MASS: f64 = 40.0;
/// Half the edges of the block, m.
const HALF: [f64; 3] = [0.06, 0.04, 0.13];
const PAD: Pad = Pad { stiffness_n_m: 6e4, damping_n_s_m: 250.0, travel_m: 0.012, compact_n_m: 2e5 };
const PADS: Soles = Soles { pads: Some(Pads { heel: PAD, ball: PAD }), toes: None };

/// A block that is a leg whose foot it is, with toes welded to it.
fn block() -> Character {
    let half = Vec3::from(HALF);
    let c = Carried::solid_box(0, MASS, Vec3::zeros(), half * 2.0);
    let shapes = vec![Shape::Box { center: Vec3::zeros(), half, rotation: Quat::identity() }];
    let body = Body { mass: c.mass, com: c.at, inertia: c.inertia, shapes };
    let toes = Body { mass: 0.0, com: Vec3::zeros(), inertia: Default::default(), shapes: Vec::new() };
    let at = Vec3::new(0.0, -0.02, 0.5 * HALF[2]);
    let links = vec![
        Link::new("block", None, Vec3::zeros(), Joint::Free),
        Link::new("tip", Some(0), at, Joint::Fixed),
    ];
    let mut c = character(links, vec![body, toes]);
    let corner = |(i, (x, z)): (usize, (f64, f64))| Site {
        name: format!("corner_{i}"),
        link: 0,
        at: half.component_mul(&Vec3::new(x, -1.0, z)),
    };
    let sites = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].into_iter().enumerate().map(corner);
    let leg = Limb { name: "leg".into(), kind: LimbKind::Leg, upper: 0, lower: 0, end: 0 };
    let skeleton = Skeleton::clone(&c.skeleton).with_sites(sites.collect()).unwrap();
    c.skeleton = skeleton.with_limbs(vec![leg]).unwrap().into();
    c.contacts = (0..4).collect();
    c.check().unwrap()
}

fn settings(rate_hz: f64, substeps: usize) -> EngineSettings {
    EngineSettings::free(rate_hz, substeps, Some(Floor::level(0.0, 0.8)))
}

/// The block at a height of its sole, m, turned by a rotation vector, falling at a speed, m/s.
fn placed(
    entry: &EngineEntry,
    soles: Soles,
    settings: EngineSettings,
    (height, turn, speed): (f64, Vec3, f64),
) -> Box<dyn Engine> {
    let c = block();
    let mut q = c.rest.clone();
    c.skeleton.set_position(&mut q, 0, &(Vec3::y() * (HALF[1] + height)));
    let r = exp(&turn);
    q[3..7].copy_from_slice(&[r.w, r.i, r.j, r.k]);
    let v = [0.0, -speed, 0.0, 0.0, 0.0, 0.0];
    sim::soles::entry(entry, soles).build(&c, settings, &q, &v).unwrap()
}

fn engines() -> [EngineEntry; 2] {
    [rapier::engine(), core::engine()]
}

/// How far the pads hang below the sole, m: half of what one foot gives way under the block.
fn sag() -> f64 {
    0.5 * MASS * 9.80665 / (2.0 * PAD.stiffness_n_m)
}

/// Vertical force of the last step, N.
fn force(engine: &dyn Engine) -> f64 {
    let mut all = Vec::new();
    engine.contacts(&mut all);
    assert!(all.iter().all(|c| c.link == 0 && c.against == Against::Ground), "{all:?}");
    all.iter().map(|c| c.force.y).sum()
}

/// A block on the two pads of one foot sinks by m g / (2 k) from where they touch, whatever the step, and its contacts are those of its foot.
#[test]
fn a_block_sinks_by_its_weight_over_the_stiffness_of_its_pads() {
    for entry in engines() {
        for (rate_hz, substeps) in [(240.0, 1), (240.0, 2), (240.0, 4), (480.0, 2)] {
            let mut engine = placed(&entry, PADS, settings(rate_hz, substeps), (0.0, Vec3::zeros(), 0.0));
            assert_eq!((engine.q().len(), engine.v().len(), engine.model().bodies.len()), (7, 6, 1));
            for _ in 0..(2.0 * rate_hz) as usize {
                engine.step().unwrap();
            }
            let sunk = HALF[1] - engine.q()[1];
            // the pads themselves do not weigh on their springs, and hang below the sole where nothing presses them
            let asked = 0.9 * MASS * G / (2.0 * PAD.stiffness_n_m) - sag();
            let pads = &engine.whole().0[7..];
            println!(
                "{} {rate_hz} Hz, {substeps}: {:.4} mm of {:.4}, pads {:.4} {:.4}, {:.2} N",
                entry.name(),
                1e3 * sunk,
                1e3 * asked,
                1e3 * pads[0],
                1e3 * pads[1],
                force(engine.as_ref())
            );
            assert!((sunk - asked).abs() < 0.02 * asked, "{sunk} {asked}");
            assert!((force(engine.as_ref()) / (MASS * G) - 1.0).abs() < 1e-3);
        }
    }
}

/// Peak force and deepest place of a mass on a spring and a damper that meets the ground at `speed`: N, m, by small steps.
fn by_hand(mass: f64, stiffness: f64, damping: f64, speed: f64) -> (f64, f64) {
    let (mut x, mut v, mut peak, mut deepest) = (0.0_f64, speed, 0.0_f64, 0.0_f64);
    let dt = 1e-6;
    for _ in 0..60_000 {
        let f = stiffness * x + damping * v;
        v += (G - f / mass) * dt;
        x += v * dt;
        (peak, deepest) = (peak.max(f), deepest.max(x));
    }
    (peak, deepest)
}

/// A block that lands flat has the peak force of a mass on two springs and dampers.
#[test]
fn a_block_lands_as_a_mass_on_a_spring_and_a_damper() {
    let (height, thrown) = (0.005, 0.25_f64);
    let speed = (thrown * thrown + 2.0 * G * height).sqrt();
    let (peak, deepest) = by_hand(0.9 * MASS, 2.0 * PAD.stiffness_n_m, 2.0 * PAD.damping_n_s_m, speed);
    for entry in engines() {
        for (rate_hz, substeps, tolerance) in [(240.0, 2, 0.15), (960.0, 4, 0.05)] {
            let height = 1e-4;
            let mut engine =
                placed(&entry, PADS, settings(rate_hz, substeps), (height, Vec3::zeros(), speed));
            let (mut most, mut low) = (0.0_f64, 0.0_f64);
            let mut touched = 0;
            for _ in 0..(0.12 * rate_hz) as usize {
                engine.step().unwrap();
                let now = force(engine.as_ref());
                touched += usize::from(now > 0.0);
                // the pads themselves stop within a step: their momentum is not the spring's
                if touched as f64 / rate_hz > 0.005 {
                    most = most.max(now);
                }
                low = low.max(HALF[1] - engine.q()[1] + sag());
            }
            println!(
                "{} {rate_hz} Hz, {substeps}: {most:.0} N of {peak:.0}, {:.2} mm of {:.2}",
                entry.name(),
                1e3 * low,
                1e3 * deepest
            );
            assert!((most / peak - 1.0).abs() < tolerance, "{most} {peak}");
            assert!((low / deepest - 1.0).abs() < tolerance, "{low} {deepest}");
        }
    }
}

/// On its heel edge a rigid block lands at least half as hard again.
#[test]
fn a_rigid_block_lands_harder() {
    for entry in engines() {
        let peak = |soles: Soles| {
            let mut engine =
                placed(&entry, soles, settings(240.0, 2), (sag(), Vec3::new(0.2, 0.0, 0.0), 0.8));
            (0..60)
                .map(|_| {
                    engine.step().unwrap();
                    force(engine.as_ref())
                })
                .fold(0.0, f64::max)
        };
        let (soft, hard) = (peak(PADS), peak(Soles::default()));
        println!("{}: {soft:.0} N, rigid {hard:.0} N", entry.name());
        assert!(hard > 1.5 * soft, "{hard} {soft}");
    }
}

/// No energy comes from nothing: what falls on its pads or its toes, at any angle, has less of it after every step, springs included, and comes to rest.
#[test]
fn no_energy_comes_from_nothing() {
    let bent = Soles { toes: Some(Toes::default()), ..PADS };
    for entry in engines() {
        for soles in [Soles::default(), PADS, bent] {
            for turn in [
                Vec3::zeros(),
                Vec3::new(0.4, 0.0, 0.0),
                Vec3::new(-0.5, 0.3, 0.2),
                Vec3::new(0.9, 0.0, -0.4),
            ] {
                let mut engine = placed(&entry, soles, settings(240.0, 2), (0.12 + sag(), turn, 0.3));
                let on = OnSoles::new(&block(), &soles).unwrap();
                let model = Model::new(&on.character, Vec3::new(0.0, -G, 0.0));
                let mut state = State::new(&model);
                let mut energy = |engine: &dyn Engine| {
                    let (q, v) = engine.whole();
                    state.update(&model, q, v);
                    let (kinetic, potential) = state.energy(&model);
                    let springs = on.parts.iter().zip(&q[7..]).map(|(part, x)| {
                        let Some(motion::Limits::Axis(r)) = on.character.skeleton.links()[part.link].limits
                        else {
                            unreachable!()
                        };
                        0.5 * part.stiffness * (x - part.rest).powi(2)
                            + 0.5 * part.stop * (x - r.clamp(*x)).powi(2)
                    });
                    kinetic + potential + springs.sum::<f64>()
                };
                let (mut last, mut gained) = (energy(engine.as_ref()), 0.0_f64);
                for _ in 0..720 {
                    engine.step().unwrap();
                    let now = energy(engine.as_ref());
                    gained = gained.max(now - last);
                    last = now;
                }
                let speed = engine.v().iter().fold(0.0_f64, |a, v| a.max(v.abs()));
                println!("{} {turn:?}: gains {gained:.2e} J at most, {speed:.1e} at the end", entry.name());
                // of the 47 J of the fall. 1e-8 J seen in the core; rapier's own impacts gain 0.73 J of a rigid block, 0.024 J of one on pads,
                // 0.63 J of toes on which a corner of it comes down
                let allowed = if engine.name() == core::NAME { 1e-6 } else { 1.0 };
                assert!(gained < allowed, "{gained}");
                assert!(speed < 1e-2, "{speed}");
            }
        }
    }
}
