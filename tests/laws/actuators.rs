//! Actuators: springs that only pull, torques that are gains times errors, dampers that only take.

use std::sync::Arc;

use controllers::{Controller, Plan, SetPoints};
use dynamics::{Model, RootMode};
use motion::rotation::log;
use motion::{Joint, Vec3};
use sim::Engine;

use super::bodies::{human, rods};
use super::stage::{bow, follow, gravity, hold, mocap, perform, performer, run};

/// The trace of a script and of a clip, slack and braced: gains are never negative, and the torque of
/// each hinge is k_lo (θ_L − θ) + k_hi (θ_H − θ) − k_d θ̇.
#[test]
fn slow_springs_only_pull_and_torque_is_gain_times_error() {
    let c = Arc::new(human());
    let tracks = bow(&c);
    let mut traces = Vec::new();
    for (root, tension) in [(RootMode::Free, 1.0), (RootMode::Pinned, 0.1), (RootMode::Pinned, 4.0)] {
        let mut pass = perform(&c, &tracks, root, 240.0, 1);
        pass.setup.tension = tension;
        traces.push(run(pass).trace);
    }
    let (c, clip) = performer(&mocap("49_07.bvh"));
    for tension in [0.1, 4.0] {
        let mut pass = follow(&c, &clip, gravity(), tension, 240.0);
        pass.root = RootMode::Pinned;
        traces.push(run(pass).trace);
    }
    let (mut hinges, mut worst) = (0, 0.0_f64);
    for t in &traces {
        assert!(t.k_lo.iter().chain(&t.k_hi).all(|k| *k >= 0.0));
        assert!(t.kd.iter().all(|k| *k >= 0.0));
        let model = Model::new(&t.character, t.gravity);
        let nv = model.nv();
        for b in &model.bodies {
            let limits = model.skeleton.links()[b.link].limits.as_ref();
            let SetPoints::Axis(set) = SetPoints::of(&b.joint, limits) else { continue };
            for row in 1..t.rows() {
                let (q, v) = (t.pose(row)[b.q_at], t.v[row * nv + b.v_at]);
                let cell = row * nv + b.v_at;
                let (lo, hi, kd) = (t.k_lo[cell], t.k_hi[cell], t.kd[cell]);
                let torque = lo * (set.lo - q) + hi * (set.hi - q) - kd * v;
                worst = worst.max((torque - t.torque[cell]).abs() / (lo + hi));
                hinges += 1;
            }
        }
    }
    println!("{hinges} torques of hinges, worst {worst:.1e} K");
    assert!(hinges > 10_000 && worst < 1e-12);
}

/// Balls: the torque at the target is that of their pairs, with the load they carry.
#[test]
fn the_torque_of_a_ball_is_in_the_trace() {
    let body = Arc::new(rods(2, Joint::Spherical, Vec3::new(0.6, 0.0, 0.8)));
    let out = run(hold(&body, gravity(), 1.5, 12.0));
    let t = &out.trace;
    let last = t.rows() - 1;
    // at rest the springs carry gravity: recomputed from masses and arms alone
    let s = &body.skeleton;
    let k = motion::Kinematics::new(s, t.pose(last));
    for (link, carried) in [(1, vec![1, 2]), (2, vec![2])] {
        let load: Vec3 = carried
            .iter()
            .map(|&l| {
                (k.point(l, &body.bodies[l].com) - k.origin(link)).cross(&(gravity() * body.bodies[l].mass))
            })
            .sum();
        let parent = k.world[link - 1].rotation;
        let at = last * s.nv() + s.v_at(link);
        let torque = parent * Vec3::new(t.torque[at], t.torque[at + 1], t.torque[at + 2]);
        let error = (torque + load).norm() / load.norm();
        assert!(error < 1e-6, "{torque:?} {load:?}"); // 1e-10 seen
        assert!(log(&s.rotation(t.pose(last), link)).norm() < 1e-6);
    }
}

/// A released limb with constant muscles only loses energy: kinetic, gravity's and the springs'.
#[test]
fn dampers_only_take() {
    for joint in [Joint::Revolute(Vec3::z()), Joint::Spherical] {
        let mut body = rods(2, joint, -Vec3::y());
        let aim = body.rest.clone();
        let speed = vec![0.7; body.skeleton.nv()];
        let skeleton = body.skeleton.clone();
        skeleton.integrate(&mut body.rest, &speed, 1.0);
        let start = std::mem::replace(&mut body.rest, aim);
        let body = Arc::new(body);
        let model = Model::new(&body, gravity());
        let setup = hold(&body, gravity(), 1.0, 3.0).setup;
        let mut controller = Controller::new(Plan::new(setup, &[]), Vec::new());
        let settings = sim::EngineSettings {
            rate_hz: 960.0,
            substeps: 1,
            gravity: gravity(),
            ground: None,
            pinned: false,
            contact: Default::default(),
            props: Default::default(),
            self_collision: false,
        };
        let mut world = sim::Rapier::new(&body, settings, &start, &vec![0.0; model.nv()]).unwrap();
        let drives = controller.step(1, &start, &vec![0.0; model.nv()]).unwrap().to_vec();
        let mut state = dynamics::State::new(&model);
        let mut energies = Vec::new();
        for _ in 0..2880 {
            state.update(&model, world.q(), world.v());
            let (kinetic, potential) = state.energy(&model);
            // hanging at zero there is no load: the springs' potential is ½ K |δ|²
            let springs: f64 = model
                .bodies
                .iter()
                .zip(&drives)
                .map(|(b, d)| {
                    let delta = match b.joint {
                        Joint::Revolute(_) => world.q()[b.q_at],
                        Joint::Spherical => log(&skeleton.rotation(world.q(), b.link)).norm(),
                        _ => 0.0,
                    };
                    0.5 * d.stiffness * delta * delta
                })
                .sum();
            energies.push(kinetic + potential + springs);
            world.set_drives(&drives);
            world.step().unwrap();
        }
        let lost = energies[0] - energies[energies.len() - 1];
        let gain = energies.windows(2).map(|w| w[1] - w[0]).fold(f64::NEG_INFINITY, f64::max);
        println!("{joint:?}: {lost:.2} J lost, largest gain in a step {gain:.1e} J");
        assert!(lost > 1.0 && gain < 1e-9 * lost, "{gain} of {lost}");
    }
}
