//! Random bodies in the core: trees of all joint types, masses over six decades, thrown on random slopes and props, their links touching
//! each other: 10⁵ steps.
//!
//! Whatever they do, a state is finite and has no energy that nothing gave, or its step is an error that names step and body.

mod solids;

use bodies::{Body, Character, Prop};
use controllers::{Drive, Rest};
use dynamics::State;
use motion::rotation::exp;
use motion::{Floor, Joint, Link, Shape, Vec3};
use nalgebra::Matrix3;
use sim::{Core, Engine, EngineError, EngineSettings};
use solids::character;

/// Bodies, and control steps of each.
const BODIES: u64 = 500;
const STEPS: usize = 200;

/// Numbers from a seed: a 64-bit linear congruential generator (Knuth, MMIX).
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn within(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    fn vector(&mut self, size: f64) -> Vec3 {
        Vec3::new(self.within(-size, size), self.within(-size, size), self.within(-size, size))
    }
}

fn tree(r: &mut Random) -> Character {
    let count = 1 + (r.unit() * 9.0) as usize;
    let (mut links, mut bodies) = (Vec::new(), Vec::new());
    for i in 0..count {
        let parent = (i > 0).then(|| (r.unit() * i as f64) as usize);
        let axis = (r.vector(1.0) + Vec3::x() * 1e-3).normalize();
        let joint = match (i, (r.unit() * 4.0) as usize) {
            (0, 0..=2) => Joint::Free,
            (0, _) => Joint::Spherical,
            (_, 0) => Joint::Spherical,
            (_, 1) => Joint::Revolute(axis),
            (_, 2) => Joint::Prismatic(axis),
            _ => Joint::Fixed,
        };
        let mut link =
            Link::new(format!("l{i}"), parent, if i == 0 { Vec3::zeros() } else { r.vector(0.3) }, joint);
        if i > 0 {
            link.parent_from_zero.rotation = exp(&r.vector(1.0));
        }
        links.push(link);
        let mass = 10f64.powf(r.within(-3.0, 3.0));
        let half = Vec3::repeat(0.05) + r.vector(0.03);
        let square = half.component_mul(&half) * (mass / 3.0);
        let inertia = Vec3::new(square.y + square.z, square.x + square.z, square.x + square.y);
        let shape = match (r.unit() * 4.0) as usize {
            0 => Shape::Box { center: Vec3::zeros(), half, rotation: exp(&r.vector(1.0)) },
            1 => Shape::Sphere { center: r.vector(0.05), radius: 0.05 },
            2 => Shape::Cone { a: -half, b: half, radius_a: 0.03, radius_b: 0.05 },
            _ => Shape::Capsule { a: -half, b: half, radius: 0.03 },
        };
        bodies.push(Body {
            mass,
            com: r.vector(0.02),
            inertia: Matrix3::from_diagonal(&inertia),
            shapes: vec![shape],
        });
    }
    character(links, bodies)
}

#[test]
fn random_bodies_stay_finite_or_say_so() {
    let (mut steps, mut diverged, mut unsolved, mut solutions, mut halved) = (0, 0, 0, 0, 0);
    let (mut most, mut whose) = (0.0_f64, 0);
    for seed in 0..BODIES {
        let mut r = Random(seed * 7919 + 1);
        for _ in 0..8 {
            r.unit();
        }
        let c = tree(&mut r);
        let ground = Floor::level(0.0, r.within(0.0, 1.2)).tilted(r.within(0.0, 0.4), r.within(-3.0, 3.0));
        let settings = EngineSettings {
            rate_hz: 480.0,
            substeps: 1,
            gravity: Vec3::new(0.0, -9.81, 0.0),
            ground: Some(ground),
            pinned: false,
            contact: Default::default(),
            props: (0..(r.unit() * 3.0) as usize)
                .map(|i| {
                    let (at, size) = (r.vector(0.5), Vec3::repeat(0.35) + r.vector(0.3));
                    let at = Vec3::new(at.x, 0.0, at.z);
                    match i {
                        0 => Prop::upright("box", at, size, r.within(-3.0, 3.0), r.within(0.0, 1.2)),
                        _ => Prop::ramp(
                            "ramp",
                            at,
                            (1.0, size.x, 0.1),
                            (r.within(0.0, 1.0), r.within(-3.0, 3.0)),
                            0.5,
                        ),
                    }
                })
                .collect(),
            self_collision: r.unit() < 0.5,
        };
        let mut q = c.rest.clone();
        if matches!(c.skeleton.links()[0].joint, Joint::Free) {
            let turn = exp(&r.vector(2.0));
            q[1] = 1.0;
            q[3..7].copy_from_slice(&[turn.w, turn.i, turn.j, turn.k]);
        }
        let v: Vec<f64> = (0..c.skeleton.nv()).map(|_| r.within(-1.0, 1.0)).collect();
        let mut core = match Core::new(&c, settings, &q, &v) {
            Ok(core) => core,
            Err(e) => panic!("seed {seed}: {e}"),
        };
        let damping = 10f64.powf(r.within(-3.0, 1.0));
        let drives = vec![Drive { stiffness: 0.0, damping, rest: Rest::None }; core.model.bodies.len()];
        let mut state = State::new(&core.model);
        let mut energy = |core: &Core| {
            state.update(&core.model, core.q(), core.v());
            let (kinetic, potential) = state.energy(&core.model);
            (kinetic, kinetic + potential)
        };
        let (_, start) = energy(&core);
        let mut largest = core.model.mass * 9.81;
        for _ in 0..STEPS {
            core.set_drives(&drives);
            match core.step() {
                Ok(()) => {}
                Err(EngineError::Diverged { step, body, .. }) => {
                    assert!(step <= STEPS && c.skeleton.link(&body).is_some(), "seed {seed}: {step} {body}");
                    diverged += 1;
                    break;
                }
                Err(e) => panic!("seed {seed}: {e}"),
            }
            steps += 1;
            assert!(core.q().iter().chain(core.v()).all(|x| x.is_finite()), "seed {seed}");
            let (kinetic, total) = energy(&core);
            largest = largest.max(kinetic);
            // pushing out of the ground works, and is counted
            let pushed = core.ledger().unwrap().push_out_j.max(0.0);
            let gained = (total - start - pushed) / largest;
            if gained > most {
                (most, whose) = (gained, seed);
            }
        }
        let l = core.ledger().unwrap();
        unsolved += l.above_loose;
        solutions += l.touching;
        halved += l.halved;
    }
    println!(
        "{steps} steps, {diverged} of {BODIES} bodies diverged; {unsolved} of {solutions} contacts not solved; {halved} substeps halved; gained at most {most:.2e} of the largest kinetic energy (body {whose})"
    );
    assert!(steps + diverged as usize * STEPS >= BODIES as usize * STEPS);
    // 17 seen: light roots under limbs a million times as heavy, whose momentum corrections would work
    assert!(diverged <= BODIES / 20, "{diverged} diverged");
    assert!(most < 1e-3, "body {whose} gained {most} of its largest kinetic energy"); // none seen
    assert!(unsolved * 1000 < solutions, "{unsolved} of {solutions} contact solutions are none"); // 3e-4 seen
}
