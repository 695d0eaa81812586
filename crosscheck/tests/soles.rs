//! Soles that yield, in MuJoCo: the laws of `sim/tests/soles.rs` in a third engine.
//!
//! MuJoCo's Python environment is made on the first run.

use std::sync::Arc;

use bodies::soles::{Pad, Pads};
use bodies::{Body, Carried, Character, JointClass, Soles};
use motion::{Floor, Joint, Limb, LimbKind, Link, Quat, Shape, Site, Skeleton, Vec3};
use sim::{ContactLaw, Engine, EngineSettings};

const G: f64 = 9.81;
const MASS: f64 = 40.0;
const HALF: [f64; 3] = [0.06, 0.04, 0.13];
const PAD: Pad = Pad { stiffness_n_m: 6e4, damping_n_s_m: 250.0, travel_m: 0.012, compact_n_m: 2e5 };

/// A block that is a leg whose foot it is.
fn block() -> Character {
    let half = Vec3::from(HALF);
    let c = Carried::solid_box(0, MASS, Vec3::zeros(), half * 2.0);
    let shapes = vec![Shape::Box { center: Vec3::zeros(), half, rotation: Quat::identity() }];
    let corner = |(i, (x, z)): (usize, (f64, f64))| Site {
        name: format!("corner_{i}"),
        link: 0,
        at: half.component_mul(&Vec3::new(x, -1.0, z)),
    };
    let sites = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].into_iter().enumerate().map(corner);
    let leg = Limb { name: "leg".into(), kind: LimbKind::Leg, upper: 0, lower: 0, end: 0 };
    let skeleton = Skeleton::new(vec![Link::new("block", None, Vec3::zeros(), Joint::Free)]).unwrap();
    let skeleton = skeleton.with_sites(sites.collect()).unwrap().with_limbs(vec![leg]).unwrap();
    Character {
        name: "block".into(),
        rest: skeleton.zero_pose(),
        skeleton: Arc::new(skeleton),
        bodies: vec![Body { mass: c.mass, com: c.at, inertia: c.inertia, shapes }],
        classes: vec![JointClass::Other],
        contacts: (0..4).collect(),
    }
    .check()
    .unwrap()
}

fn force(engine: &dyn Engine) -> f64 {
    let mut all = Vec::new();
    engine.contacts(&mut all);
    assert!(all.iter().all(|c| c.link == 0), "{all:?}");
    all.iter().map(|c| c.force.y).sum()
}

/// A block that falls on its pads has the peak force of a mass on two springs and dampers, and comes to rest m g / (2 k) deep.
#[test]
fn slow_a_block_lands_and_stands_on_its_pads() {
    let c = block();
    let (height, thrown) = (0.005, 0.25_f64);
    let speed = (thrown * thrown + 2.0 * G * height).sqrt();
    // how far the pads hang below the sole
    let sag = 0.5 * MASS * 9.80665 / (2.0 * PAD.stiffness_n_m);
    let settings = EngineSettings {
        rate_hz: 240.0,
        substeps: 8,
        gravity: Vec3::new(0.0, -G, 0.0),
        ground: Some(Floor::level(0.0, 0.8)),
        pinned: false,
        contact: ContactLaw::Stiff,
        props: Default::default(),
        self_collision: false,
    };
    let mut q = c.rest.clone();
    c.skeleton.set_position(&mut q, 0, &(Vec3::y() * (HALF[1] + sag + height)));
    let soles = Soles { pads: Some(Pads { heel: PAD, ball: PAD }), toes: None };
    let entry = sim::soles::entry(&crosscheck::engine(|_| {}), soles);
    let mut engine = entry.build(&c, settings, &q, &[0.0, -thrown, 0.0, 0.0, 0.0, 0.0]).unwrap();
    let (mut most, mut deepest) = (0.0_f64, 0.0_f64);
    let mut touched = 0;
    for _ in 0..720 {
        engine.step().unwrap();
        let now = force(engine.as_ref());
        touched += usize::from(now > 0.0);
        // the pads themselves stop at once: their momentum is not the springs'
        if touched > 1 {
            most = most.max(now);
        }
        deepest = deepest.max(HALF[1] - engine.q()[1] + sag);
    }
    // by hand, in steps of a microsecond
    let (k, d, mass) = (2.0 * PAD.stiffness_n_m, 2.0 * PAD.damping_n_s_m, 0.9 * MASS);
    let (mut x, mut v, mut peak, mut low) = (0.0_f64, speed, 0.0_f64, 0.0_f64);
    for _ in 0..60_000 {
        let f = k * x + d * v;
        v += (G - f / mass) * 1e-6;
        x += v * 1e-6;
        (peak, low) = (peak.max(f), low.max(x));
    }
    let (sunk, asked) = (HALF[1] - engine.q()[1] + sag, mass * G / k);
    println!(
        "{most:.0} N of {peak:.0}; {:.2} mm of {:.2}; rests at {:.3} mm of {:.3}, {:.2} N",
        1e3 * deepest,
        1e3 * low,
        1e3 * sunk,
        1e3 * asked,
        force(engine.as_ref())
    );
    assert!((most / peak - 1.0).abs() < 0.1, "{most} {peak}");
    assert!((deepest / low - 1.0).abs() < 0.1, "{deepest} {low}");
    assert!((sunk / asked - 1.0).abs() < 0.1, "{sunk} {asked}");
    assert!((force(engine.as_ref()) / (MASS * G) - 1.0).abs() < 1e-3);
}
