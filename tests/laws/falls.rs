//! Falls: what one is, that a run ends with it, and that a fallen body comes to rest.

use std::sync::Arc;

use dynamics::{ContactSample, Disturbed, Model, RootMode, Trace, fall};
use motion::{Joint, Kinematics, Vec3};
use takes::{Ask, Engines, Input, Outcome};

use super::bodies::human;

/// A human who is pushed over, and what comes of it.
fn pushed(past_fall: bool, settle_s: f64) -> Outcome {
    let ron = format!(
        "Scene(character: \"characters/human.ron\", settle_s: {settle_s},
            pushes: [Push(link: \"chest\", impulse_ns: 60, towards_deg: 180, start_s: 0.5)])"
    );
    let input = Input::Text { ron, base: support::root().join("scenes") };
    let mut take = takes::open(input, &Ask::default()).unwrap();
    take.conditions.physics.past_fall = past_fall;
    take.outcome(&Engines::default(), &mut |_| {}).unwrap()
}

/// Power of the muscles in a row, W: they act on the joints, not on the root.
fn power(t: &Trace, row: usize) -> f64 {
    let nv = t.character.skeleton.nv();
    (row * nv..(row + 1) * nv).map(|i| t.torque[i] * t.v[i]).sum()
}

/// After a fall control lets go: muscles take energy and give none, and within two seconds the body lies still, for good.
#[test]
fn slow_a_fallen_body_comes_to_rest() {
    let out = pushed(true, 8.0);
    let (t, fell_s) = (&out.trace, out.fell_s.unwrap());
    assert!((t.rows() as f64 / t.rate_hz - 8.0).abs() < 0.01, "the run goes on");
    let fell = (fell_s * t.rate_hz).round() as usize;
    let powers: Vec<f64> = (fell + 1..t.rows()).map(|row| power(t, row)).collect();
    let work: f64 = powers.iter().sum::<f64>() / t.rate_hz;
    let most = powers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let kinetic = |row: usize| t.energy[2 * row];
    let still = fell + (2.0 * t.rate_hz) as usize;
    let left = (still..t.rows()).map(kinetic).fold(0.0, f64::max);
    println!(
        "fell at {fell_s:.2} s with {:.0} J; muscles do {work:.1} J, {most:.1e} W at most; {left:.2e} J left",
        kinetic(fell)
    );
    assert!(most <= 0.0 && work < -1.0, "{most} W, {work} J");
    assert!(left < 1.0, "{left} J");
}

/// Without being asked to go on a run ends with its fall, and numbers are of what was performed.
#[test]
fn slow_a_run_ends_with_its_fall() {
    let (cut, whole) = (pushed(false, 4.0), pushed(true, 4.0));
    let fell = (cut.fell_s.unwrap() * cut.trace.rate_hz).round() as usize;
    assert_eq!(cut.trace.rows(), fell + 1);
    assert_eq!((cut.fell_s, &cut.fall), (whole.fell_s, &whole.fall));
    assert_eq!(cut.trace.q, whole.performed().q);
    assert_eq!(cut.verdict, whole.verdict);
    assert_eq!(fall::of(&cut.trace), cut.fall);
    assert_eq!(fall::of(&whole.trace), whole.fall);
}

/// A trace of one row in which one link carries half the weight, in a pose that was asked for.
fn carrying(link: &str, asked: &[f64], performed: &[f64]) -> bool {
    let c = Arc::new(human());
    let (nq, nv) = (c.skeleton.nq(), c.skeleton.nv());
    let link = c.skeleton.link(link).unwrap();
    let mut point = Kinematics::new(&c.skeleton, performed).origin(link);
    point.y = 0.0;
    let force = Vec3::y() * 370.0;
    let rows = 2;
    let trace = Trace {
        rate_hz: 240.0,
        substeps: 2,
        root: RootMode::Free,
        ground_m: Some(0.0),
        gravity: Vec3::y() * -9.81,
        q: performed.repeat(rows),
        v: vec![0.0; rows * nv],
        target: asked.repeat(rows),
        torque: vec![0.0; rows * nv],
        stop_torque: vec![0.0; rows * nv],
        k_lo: vec![0.0; rows * nv],
        k_hi: vec![0.0; rows * nv],
        kd: vec![0.0; rows * nv],
        contacts: vec![ContactSample { row: 1, link, against: Default::default(), point, force, depth: 0.0 }],
        root_wrench: vec![0.0; rows * 6],
        com: vec![0.0; rows * 3],
        momentum: vec![0.0; rows * 6],
        link_com: Vec::new(),
        plan: motion::ContactPlan::default(),
        colors: Vec::new(),
        disturbed: Disturbed::default(),
        energy: vec![0.0; rows * 2],
        wall_s: 0.0,
        character: c.clone(),
    };
    assert_eq!(trace.q.len(), rows * nq);
    fall::fallen(&trace, &Model::new(&c, trace.gravity), 1)
}

/// The rest pose with some hinges bent (rad), lowered until its lowest solid is on the ground.
fn pose(bent: &[(&str, f64)], pitch: f64) -> Vec<f64> {
    let c = human();
    let s = &c.skeleton;
    let mut q = c.rest.clone();
    for (name, angle) in bent {
        let link = s.link(name).unwrap();
        assert!(matches!(s.links()[link].joint, Joint::Revolute(_)), "{name}");
        q[s.q_at(link)] = *angle;
    }
    s.set_rotation(&mut q, 0, &motion::rotation::exp(&(Vec3::x() * pitch)));
    let k = Kinematics::new(s, &q);
    let solids = c.bodies.iter().zip(&k.world);
    let lowest = solids.flat_map(|(b, w)| b.shapes.iter().map(move |x| -x.reach(w, &-Vec3::y())));
    let up = Vec3::y() * lowest.fold(f64::INFINITY, f64::min);
    let root = s.position(&q, 0) - up;
    s.set_position(&mut q, 0, &root);
    q
}

/// Load outside the contact plan is a fall; load inside it is none: who is asked to kneel, to lie or to stand on hands may.
#[test]
fn what_is_asked_to_touch_may_carry() {
    let stands = pose(&[], 0.0);
    let kneels = pose(&[("knee_l", 1.6), ("knee_r", 1.6)], 0.0);
    let lies = pose(&[], std::f64::consts::FRAC_PI_2);
    let on_hands = pose(&[], std::f64::consts::PI);
    for (link, asked) in [("knee_l", &kneels), ("chest", &lies), ("head", &on_hands), ("ankle_r", &stands)] {
        assert!(!carrying(link, asked, asked), "{link} is asked to");
    }
    for (link, asked, performed) in
        [("knee_l", &stands, &kneels), ("chest", &stands, &lies), ("head", &kneels, &on_hands)]
    {
        assert!(carrying(link, asked, performed), "{link} is not");
    }
    // the feet carry, but the body is far lower than asked
    assert!(carrying("ankle_r", &stands, &lies));
}
