//! Who kept its feet: limits one by one, what may carry, and how far feet slide.

use std::sync::Arc;

use bodies::anthropometry::human::human;
use dynamics::walked::{HIGH, Loss};
use dynamics::{Against, ContactSample, Disturbed, Model, Rejoined, RootMode, State, Trace, Walked};
use motion::{Kinematics, Vec3};

/// A human at rest as asked, moved and turned in its last rows.
fn standing(rows: usize, shift: Vec3, contacts: Vec<ContactSample>) -> Trace {
    let c = Arc::new(human().0);
    let model = Model::new(&c, Vec3::new(0.0, -9.81, 0.0));
    let (nq, nv, links) = (c.skeleton.nq(), c.skeleton.nv(), c.bodies.len());
    let mut state = State::new(&model);
    let mut t = Trace {
        character: c.clone(),
        rate_hz: 100.0,
        substeps: 1,
        root: RootMode::Free,
        ground_m: Some(0.0),
        gravity: model.gravity,
        q: Vec::new(),
        v: vec![0.0; rows * nv],
        target: c.rest.repeat(rows),
        torque: vec![0.0; rows * nv],
        stop_torque: vec![0.0; rows * nv],
        k_lo: vec![0.0; rows * nv],
        k_hi: vec![0.0; rows * nv],
        kd: vec![0.0; rows * nv],
        contacts,
        root_wrench: vec![0.0; 6 * rows],
        com: Vec::new(),
        momentum: vec![0.0; 6 * rows],
        link_com: Vec::new(),
        disturbed: Disturbed { ground_up: vec![Vec3::y()], ..Disturbed::default() },
        energy: vec![0.0; 2 * rows],
        colors: Vec::new(),
        plan: Default::default(),
        wall_s: 0.0,
    };
    for row in 0..rows {
        let mut q = c.rest.clone();
        if row >= rows / 2 {
            for k in 0..3 {
                q[k] += shift[k];
            }
        }
        state.update(&model, &q, &vec![0.0; nv]);
        t.com.extend_from_slice(state.com(&model).as_slice());
        for (l, body) in c.bodies.iter().enumerate() {
            t.link_com.extend_from_slice(state.point(&model, l, &body.com).as_slice());
        }
        t.q.extend(q);
    }
    assert_eq!((t.q.len(), t.link_com.len()), (rows * nq, 3 * rows * links));
    t
}

fn lost(shift: Vec3) -> Option<(f64, Loss)> {
    Walked::of(&standing(20, shift, Vec::new()), 20).lost
}

/// Each limit by itself: near it the feet are kept, beyond it they are lost when it is passed.
#[test]
fn feet_are_lost_beyond_each_limit() {
    assert_eq!(lost(Vec3::zeros()), None);
    assert_eq!(lost(Vec3::new(0.4, 0.0, 0.25)), None); // 0.47 m
    assert!(matches!(lost(Vec3::new(0.4, 0.0, 0.35)), Some((t, Loss::Away(x))) if t == 0.1 && x > 0.5));
    assert!(matches!(lost(Vec3::new(0.0, -0.3, 0.0)), Some((_, Loss::Low(x))) if x < HIGH));
    let mut held = standing(20, Vec3::zeros(), Vec::new());
    held.root_wrench[6 * 3] = 1e-9;
    assert!(matches!(Walked::of(&held, 20).lost, Some((t, Loss::Held(_))) if t == 0.03));
    assert_eq!(Walked::of(&held.cut(0..3), 20).lost, Some((0.02, Loss::Ended)));
}

/// Hands may not carry; feet may, and slide by what they slide.
#[test]
fn hands_may_not_carry_and_feet_may() {
    let c = human().0;
    let weight = c.mass() * 9.81;
    let carries = |name: &str, part: f64| {
        let link = c.skeleton.limb(name).unwrap().end;
        let force = Vec3::y() * (part * weight);
        // where the limb ends, so that the motion asked for does not bring that point to the ground
        let point = Kinematics::new(&c.skeleton, &c.rest).origin(link);
        let sample = |row| ContactSample { row, link, point, force, depth: 0.0, against: Against::Ground };
        let mut t = standing(20, Vec3::zeros(), (5..20).map(sample).collect());
        for row in 0..20 {
            t.v[row * c.skeleton.nv()] = 0.1; // m/s, the whole body
        }
        Walked::of(&t, 20)
    };
    assert!(matches!(carries("arm_l", 0.06).lost, Some((t, Loss::Carried(..))) if t == 0.05));
    assert_eq!(carries("arm_l", 0.04).lost, None);
    let stands = carries("leg_l", 1.0);
    assert_eq!(stands.lost, None);
    let [slip] = stands.slips_mm[..] else { panic!("{:?}", stands.slips_mm) };
    assert!((slip - 15.0).abs() < 1e-9, "{slip}"); // 15 rows of 0.1 m/s at 100 Hz
    assert_eq!(stands.slip_mm(), slip);
    assert_eq!(carries("leg_l", 0.05).slip_mm(), 0.0);
}

/// Thrown 50 mm aside from 0.1 to 0.15 s, a body is back from then on: all links are as far as the root went. Of a throw that goes on, of one that
/// comes back and leaves again, and of no rows there is no return.
#[test]
fn who_is_back_stays_back() {
    let thrown = |rows: std::ops::Range<usize>| {
        let mut t = standing(20, Vec3::new(0.03, 0.0, 0.04), Vec::new());
        let (links, still) = (t.character.bodies.len(), standing(1, Vec3::zeros(), Vec::new()).link_com);
        for row in (10..20).filter(|row| !rows.contains(row)) {
            t.link_com[3 * row * links..3 * (row + 1) * links].copy_from_slice(&still[..3 * links]);
        }
        t
    };
    let seen = Rejoined::of(&thrown(10..15), 0.05, 0.01);
    assert!((seen.furthest_m - 0.05).abs() < 1e-12 && seen.furthest_s == 0.1, "{seen:?}");
    assert_eq!(seen.back_s, Some(0.15));
    assert_eq!(Rejoined::of(&thrown(10..20), 0.05, 0.01).back_s, None);
    assert_eq!(Rejoined::of(&thrown(19..20), 0.05, 0.01).back_s, None);
    assert_eq!(Rejoined::of(&thrown(10..15), 0.05, 0.06).back_s, Some(0.05));
    assert_eq!(
        Rejoined::of(&thrown(10..15), 0.3, 0.01),
        Rejoined { furthest_m: 0.0, furthest_s: 0.3, back_s: None }
    );
}
