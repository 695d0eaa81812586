//! The least tension: above it a body stands, below it sags or falls, and the run says where.

use std::sync::Arc;

use controllers::tension::stability_margin;
use controllers::{Drive, Plan, Rest};
use dynamics::{Model, State};
use motion::{Joint, Vec3};
use nalgebra::DMatrix;
use sim::{Engine, EngineSettings, Rapier};

use super::bodies::{ROD_LENGTH, ROD_MASS, human, locked, poses, rods};
use super::stage::{RATE_HZ, gravity, hold, run};

/// Worst angle of any joint from upright after 20 s, rad, of rods held at zero from a slight lean.
fn lean_after(body: &Arc<bodies::Character>, stiffness: &[f64]) -> f64 {
    let model = Model::new(body, gravity());
    let settings = EngineSettings {
        rate_hz: RATE_HZ,
        substeps: 1,
        gravity: gravity(),
        ground: None,
        pinned: false,
        contact: Default::default(),
        props: Default::default(),
        self_collision: false,
    };
    let mut world = Rapier::new(body, settings, &body.rest, &vec![0.0; model.nv()]).unwrap();
    let mut q = body.rest.clone();
    model.skeleton.integrate(&mut q, &vec![1e-3; model.nv()], 1.0);
    world.set_state(&q, &vec![0.0; model.nv()]);
    let drives: Vec<Drive> = model
        .bodies
        .iter()
        .enumerate()
        .map(|(i, b)| Drive {
            stiffness: stiffness[i],
            damping: if b.joint.nv() > 0 { 0.1 } else { 0.0 },
            rest: controllers::rest_of(&model, i, &body.rest),
        })
        .collect();
    for _ in 0..(20.0 * RATE_HZ) as usize {
        world.set_drives(&drives);
        world.step().unwrap();
    }
    let mut away = vec![0.0; model.nv()];
    model.skeleton.difference(&body.rest, world.q(), 1.0, &mut away);
    away.iter().fold(0.0, |a, x| a.max(x.abs()))
}

/// An upright rod without load falls below m g l and stands above it.
#[test]
fn an_upright_rod_needs_m_g_l() {
    let least = ROD_MASS * 9.81 * ROD_LENGTH / 2.0;
    for joint in [Joint::Revolute(Vec3::z()), Joint::Revolute(Vec3::x()), Joint::Spherical] {
        let body = Arc::new(rods(1, joint, Vec3::y()));
        let setup = hold(&body, gravity(), 1.0, 0.1).setup;
        let scale = Plan::new(setup, &[]).scale;
        let (found, k1) = (scale.least[1], scale.k1[1]);
        assert!((found / least - 1.0).abs() < 1e-12, "{joint:?}: {found} {least}");
        assert!(lean_after(&body, &[0.0, 0.97 * least]) > 0.1, "{joint:?} stands without the means");
        assert!(lean_after(&body, &[0.0, 1.03 * least]) < 1e-4, "{joint:?} falls");
        // the report says so, although the load is zero
        let sagging = run(hold(&body, gravity(), 0.97 * least / k1, 0.5)).sagging;
        assert_eq!((sagging.len(), sagging[0].link), (1, 1));
        assert!((sagging[0].least / least - 1.0).abs() < 1e-12);
        assert!(run(hold(&body, gravity(), 1.03 * least / k1, 0.5)).sagging.is_empty());
    }
}

/// Rods in series stand where diag K + ∂²V/∂q² is positive definite and fall where it is not, although
/// each joint has more than it needs alone; the least tension found is enough.
#[test]
fn a_chain_stands_where_its_hessian_is_positive() {
    for (count, joint) in
        [(2, Joint::Revolute(Vec3::z())), (3, Joint::Revolute(Vec3::x())), (2, Joint::Spherical)]
    {
        let body = Arc::new(rods(count, joint, Vec3::y()));
        let model = Model::new(&body, gravity());
        let n = model.nv();
        let mut state = State::new(&model);
        state.update(&model, &body.rest, &vec![0.0; n]);
        let mut h = DMatrix::zeros(n, n);
        state.gravity_stiffness(&model, &mut h);
        // what each joint needs alone, by one common factor to the edge of stability
        let own: Vec<f64> =
            model.bodies.iter().map(|b| if b.joint.nv() > 0 { -h[(b.v_at, b.v_at)] } else { 0.0 }).collect();
        let scaled = |f: f64| -> Vec<f64> { own.iter().map(|d| d * f).collect() };
        let (mut low, mut high) = (1.0, 10.0);
        for _ in 0..60 {
            let mid = 0.5 * (low + high);
            if stability_margin(&model, &body.rest, &scaled(mid)) > 0.0 { high = mid } else { low = mid }
        }
        assert!(high > 1.1, "in series a chain needs more than its joints alone: {high}");
        assert!(lean_after(&body, &scaled(0.97 * high)) > 0.1, "{count} {joint:?} stand");
        assert!(lean_after(&body, &scaled(1.03 * high)) < 1e-3, "{count} {joint:?} fall");
        let setup = hold(&body, gravity(), 1.0, 0.1).setup;
        let found = Plan::new(setup, &[]).scale.least;
        assert!(stability_margin(&model, &body.rest, &found) > -1e-9, "{found:?}");
        let less: Vec<f64> = found.iter().map(|k| 0.99 * k).collect();
        assert!(stability_margin(&model, &body.rest, &less) < 0.0, "{found:?} is more than the least");
    }
}

/// A limb below its least tension sags, and the report names it, its time and what it lacks; above, it
/// does neither.
#[test]
fn a_slack_limb_sags_and_is_named() {
    let figure = human();
    let q = &poses(&figure)[1].1;
    for name in ["shoulder_l", "elbow_r", "hip_l", "knee_l", "wrist_r"] {
        let link = figure.skeleton.link(name).unwrap();
        let body = Arc::new(locked(&figure, q, &[link]));
        let scale = Plan::new(hold(&body, gravity(), 1.0, 0.1).setup, &[]).scale;
        let least = scale.least[1];
        for (factor, sags) in [(0.8, true), (1.2, false)] {
            let out = run(hold(&body, gravity(), factor * least / scale.k1[1], 8.0));
            let last = out.trace.rows() - 1;
            let angle = match controllers::rest_of(&Model::new(&body, gravity()), 1, out.trace.pose(last)) {
                Rest::Scalar(x) => (x - body.rest[0]).abs(),
                _ => {
                    let s = &body.skeleton;
                    s.rotation(out.trace.pose(last), link).angle_to(&s.rotation(&body.rest, link))
                }
            };
            assert_eq!(angle.to_degrees() > 0.5, sags, "{name} at {factor}: {}°", angle.to_degrees());
            assert_eq!(!out.sagging.is_empty(), sags, "{name} at {factor}");
            if let Some(s) = out.sagging.first() {
                assert_eq!((out.sagging.len(), s.link), (1, link));
                assert!(s.time_s <= 1.0 / RATE_HZ && (s.lasts_s - 8.0).abs() < 0.01, "{s:?}");
                assert!((s.tension / s.least - factor).abs() < 1e-9, "{s:?}");
            }
        }
    }
}

/// Only the poses that ask too much are reported, at their time: an arm lifted at 1 s.
#[test]
fn sagging_knows_its_time() {
    let body = Arc::new(rods(1, Joint::Revolute(Vec3::z()), -Vec3::y()));
    let rise = motion::script::PoseValue::scalar("rod_0", 1.5);
    let mut tracks = one_pose(&body, rise, 1.0, 0.5);
    tracks.duration_s += 1.0;
    let scale = |t: f64| {
        let clip = tracks.sample(RATE_HZ);
        let mut pass = super::stage::follow(&body, &clip, gravity(), t, RATE_HZ);
        pass.setup.tracks = Some(tracks.clone());
        pass
    };
    let s = Plan::new(scale(1.0).setup, &[]).scale;
    let out = run(scale(0.9 * s.least[1] / s.k1[1]));
    assert_eq!(out.sagging.len(), 1, "{:?}", out.sagging);
    assert_eq!(out.sagging[0].link, 1);
    assert!((out.sagging[0].time_s - 1.5).abs() < 1e-9, "{:?}", out.sagging);
    assert!(run(scale(1.1 * s.least[1] / s.k1[1])).sagging.is_empty());
}

fn one_pose(
    body: &Arc<bodies::Character>,
    value: motion::script::PoseValue,
    start_s: f64,
    duration_s: f64,
) -> motion::Tracks {
    use motion::script::{Action, Cycle, Pose, Properties};
    let none = Properties::default;
    let properties = Properties { duration_s: Some(duration_s), ..none() };
    let poses = vec![Pose { properties: none(), values: vec![value] }];
    let cycles = vec![Cycle { repetitions: 1, properties: none(), poses }];
    let action = Action { name: "rise".into(), start_s, properties, cycles };
    let script = motion::Script { properties: none(), actions: vec![action], inserts: Vec::new() };
    script.build(&body.skeleton, &body.rest).unwrap()
}
