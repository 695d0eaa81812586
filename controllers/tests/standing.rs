//! Standing: support, posture, planted feet, the ankle's limit, the assist's budget; no engine.

use std::sync::Arc;

use bodies::Character;
use controllers::assist::{Assist, Budget};
use controllers::posture::settle;
use controllers::support::{Foot, polygon, shares, wrenches};
use controllers::{BalanceSettings, Controller, Drive, GainBlend, Goal, Plan, Setup};
use dynamics::{Model, State};
use motion::plant::{Plant, plant};
use motion::rotation::exp;
use motion::support::{Support, Vec2, ground};
use motion::{Clip, Kinematics, Script, Vec3};

const GRAVITY: Vec3 = Vec3::new(0.0, -9.81, 0.0);

fn human() -> (Arc<Character>, Model, State, Vec<Plant>) {
    let c = Arc::new(bodies::anthropometry::human::human().0);
    let model = Model::new(&c, GRAVITY);
    let mut state = State::new(&model);
    state.update(&model, &c.rest, &vec![0.0; model.nv()]);
    let plants = c.legs().map(|l| Plant::here(&c.skeleton, &c.rest, l)).collect();
    (c, model, state, plants)
}

/// Farthest any planted foot is from its place, m, and the largest turn against it, rad.
fn displaced(c: &Character, q: &[f64], plants: &[Plant]) -> (f64, f64) {
    let k = Kinematics::new(&c.skeleton, q);
    plants.iter().fold((0.0, 0.0), |worst: (f64, f64), p| {
        let (now, then) = (k.world[p.limb.end], p.world_from_end);
        let moved = (now.translation.vector - then.translation.vector).norm();
        let turned = motion::rotation::log(&(now.rotation * then.rotation.inverse())).norm();
        (worst.0.max(moved), worst.1.max(turned))
    })
}

/// Poses of the upper body that carry the centre of mass away.
fn gestures(c: &Character) -> Vec<Vec<f64>> {
    let s = &c.skeleton;
    [[0.5, 0.0, 0.0], [0.9, 0.3, 0.1], [-0.2, 0.0, 0.3], [0.1, -0.8, -0.2]]
        .into_iter()
        .map(|bend| {
            let mut q = c.rest.clone();
            for name in ["pelvis", "abdomen", "chest"] {
                let link = s.link(name).unwrap();
                let r = exp(&(Vec3::from(bend) / 3.0)) * s.rotation(&q, link);
                s.set_rotation(&mut q, link, &r);
            }
            let arm = s.link("shoulder_l").unwrap();
            let r = exp(&Vec3::new(-bend[0], bend[2], 0.5)) * s.rotation(&q, arm);
            s.set_rotation(&mut q, arm, &r);
            q
        })
        .collect()
}

/// Wherever the pelvis goes within reach, and above it, the feet stay where they stand.
#[test]
fn planted_feet_stay() {
    let (c, _, _, plants) = human();
    let s = &c.skeleton;
    for (i, mut q) in gestures(&c).into_iter().enumerate() {
        let shift = Vec3::new(0.05 - 0.03 * i as f64, [-0.2, -0.05, 0.0, 0.1][i], 0.04);
        let p = s.position(&q, 0) + shift;
        s.set_position(&mut q, 0, &p);
        let residue = plant(s, &mut q, &plants).unwrap();
        let (moved, turned) = displaced(&c, &q, &plants);
        assert!(residue < 1e-9, "gesture {i}: {residue}");
        assert!(moved < 1e-9 && turned < 1e-9, "gesture {i}: {moved} m, {turned} rad"); // 1e-15 seen
        assert!(s.position(&q, 0).y <= p.y, "the root only comes down");
    }
}

/// A settled pose has its centre of mass where it was asked for, feet fixed, the upper body untouched.
#[test]
fn a_settled_pose_is_over_its_feet() {
    let (c, model, mut state, plants) = human();
    let over = ground(&state.com(&model));
    for (i, mut q) in gestures(&c).into_iter().enumerate() {
        let before = q.clone();
        let target = over + Vec2::new(0.01, -0.005) * i as f64;
        let left = settle(&model, &mut state, &mut q, &plants, target).unwrap();
        state.update(&model, &q, &vec![0.0; model.nv()]);
        let error = (ground(&state.com(&model)) - target).norm();
        assert!((error - left).abs() < 1e-9 && error < 1e-4, "gesture {i}: {error} m, said {left}");
        let (moved, turned) = displaced(&c, &q, &plants);
        assert!(moved < 1e-9 && turned < 1e-9, "gesture {i}: {moved} m, {turned} rad");
        for name in ["abdomen", "chest", "shoulder_l", "elbow_r"] {
            let at = c.skeleton.q_at(c.skeleton.link(name).unwrap());
            assert_eq!(q[at], before[at], "{name}");
        }
    }
}

/// The feet's wrenches add up to the force at its centre of pressure, between the feet, on one of them and
/// beyond.
#[test]
fn wrenches_add_up() {
    let (c, model, state, _) = human();
    let feet = Foot::of(&c, &model);
    assert_eq!(feet.len(), 2);
    let center = polygon(&feet, &model, &state).centroid().unwrap();
    for cop in [Vec2::zeros(), Vec2::new(0.03, 0.05), Vec2::new(-0.087, 0.0), Vec2::new(0.3, -0.1)] {
        let cop = center + cop;
        let force = Vec3::new(12.0, 700.0, -30.0);
        let all = wrenches(&feet, &model, &state, cop, force);
        let sum: Vec3 = all.iter().map(|w| w.force).sum();
        assert!((sum - force).norm() < 1e-9);
        let height = all[0].point.y;
        let about = Vec3::new(cop.x, height, cop.y);
        let moment: Vec3 = all.iter().map(|w| w.moment + (w.point - about).cross(&w.force)).sum();
        assert!(moment.norm() < 1e-9, "{moment:?}"); // 1e-14 seen
        assert!(all.iter().all(|w| w.force.y >= -1e-12), "feet do not pull");
    }
}

/// Shares are of one, and go to the nearer foot.
#[test]
fn shares_sum_to_one() {
    let centers = [Vec3::new(0.1, 0.0, 0.0), Vec3::new(-0.1, 0.0, 0.1), Vec3::new(0.0, 0.0, -0.4)];
    for n in 1..=3 {
        for cop in [Vec2::new(0.05, 0.0), Vec2::new(-3.0, 1.0)] {
            let all = shares(&centers[..n], cop);
            assert!((all.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{all:?}");
            assert!(all.iter().all(|s| *s >= 0.0));
        }
    }
    let near = shares(&centers[..2], Vec2::new(0.09, 0.0));
    assert!(near[0] > 0.8, "{near:?}");
}

/// Drives of a standing controller for the state `q`, `v`.
fn drives(
    c: &Arc<Character>,
    plants: &[Plant],
    balance: BalanceSettings,
    q: &[f64],
    v: &[f64],
) -> Vec<Drive> {
    let s = &c.skeleton;
    let script = Script { properties: Default::default(), actions: Vec::new(), inserts: Vec::new() };
    let clip = Clip::new(s.clone(), 240.0, c.rest.repeat(4));
    let setup = Setup {
        character: c.clone(),
        gravity: GRAVITY,
        goal: Goal::new(&clip, 240.0),
        tracks: Some(script.build(s, &c.rest).unwrap()),
        dense: Default::default(),
        tension: 1.0,
        plants: plants.to_vec(),
        ground_m: None,
        contacts: motion::ContactPlan::default(),
        balance,
        blend: GainBlend::RestAngle,
    };
    Controller::new(Plan::new(setup, &[]), Vec::new()).step(1, q, v).unwrap().to_vec()
}

/// An ankle never presses beyond its sole, however far the body leans; without the limit it would.
#[test]
fn ankles_keep_their_pressure_inside_the_sole() {
    let (c, model, mut state, plants) = human();
    let s = &c.skeleton;
    let feet = Foot::of(&c, &model);
    let margin_m = BalanceSettings::default().margin_m;
    let unlimited = BalanceSettings { margin_m: -10.0, ..BalanceSettings::default() };
    // The pressure under each foot of a symmetric stance from the torque of its ankle.
    let margins = |settings: BalanceSettings, q: &[f64], v: &[f64], state: &State| -> Vec<f64> {
        let drives = drives(&c, &plants, settings, q, v);
        let force = 0.5 * model.mass * GRAVITY.norm();
        feet.iter()
            .map(|foot| {
                let b = &model.bodies[foot.body];
                let torque = drives[foot.body].torque(b, q, v);
                let world = state.bodies[foot.body].zero * torque;
                let ankle = ground(&state.bodies[foot.body].world.translation.vector);
                let pressure = ankle + Vec2::new(-world.z / force, world.x / force);
                Support::of(foot.corners_in_world(&model, state).iter()).margin(&pressure)
            })
            .collect()
    };
    let mut beyond = 0;
    for (lean, speed) in [(0.10, 0.0), (-0.06, 0.0), (0.04, 0.5), (-0.02, -0.4)] {
        let mut q = c.rest.clone();
        let p = s.position(&q, 0) + Vec3::new(0.0, -0.01, lean);
        s.set_position(&mut q, 0, &p);
        plant(s, &mut q, &plants).unwrap();
        let mut v = vec![0.0; model.nv()];
        v[2] = speed;
        state.update(&model, &q, &v);
        for m in margins(BalanceSettings::default(), &q, &v, &state) {
            assert!(m > margin_m - 1e-6, "lean {lean} m, {speed} m/s: {m} m inside");
        }
        beyond += margins(unlimited, &q, &v, &state).iter().filter(|m| **m < 0.0).count();
    }
    assert!(beyond >= 4, "only {beyond} ankles needed the limit");
}

/// The assist pulls towards the goal and never beyond its budget, however far that is.
#[test]
fn the_assist_stays_within_its_budget() {
    let (c, model, mut state, _) = human();
    let s = &c.skeleton;
    let still = vec![0.0; model.nv()];
    for budget in [Budget { force_n: 15.0, moment_nm: 4.0 }, Budget { force_n: 0.0, moment_nm: 0.0 }] {
        for away in [1e-4, 0.1, 100.0] {
            let mut goal = c.rest.clone();
            let p = s.position(&goal, 0) + Vec3::new(away, 0.0, -away);
            s.set_position(&mut goal, 0, &p);
            let r = exp(&Vec3::new(0.0, away.min(1.0), 0.0)) * s.rotation(&goal, 0);
            s.set_rotation(&mut goal, 0, &r);
            let w = Assist::new(&model, budget).wrench(&model, &mut state, &c.rest, (&goal, &still));
            assert!(w.force.norm() <= budget.force_n * (1.0 + 1e-12), "{w:?}");
            assert!(w.moment.norm() <= budget.moment_nm * (1.0 + 1e-12), "{w:?}");
            if budget.force_n > 0.0 {
                assert!(w.force.x > 0.0 && w.force.z < 0.0 && w.moment.y > 0.0, "{w:?}");
            }
        }
    }
}
