//! Momentum that neither gravity nor contacts explain, against the limit of the table of [`dynamics::verdict`].

use std::sync::Arc;

use bodies::{Body, Character, JointClass};
use dynamics::verdict::{Ending, Grade, Reason, UNEXPLAINED, UNEXPLAINED_N, UNEXPLAINED_S, Verdict, What};
use dynamics::{ContactSample, Disturbed, RootMode, Trace};
use motion::{Joint, Link, Shape, Skeleton, Vec3};
use nalgebra::Matrix3;

const RATE: f64 = 120.0;
const ROWS: usize = 61;
const G: f64 = 9.81;

/// A ball of `mass` kg that lies on the ground for half a second. Its weight is carried to the last bit.
fn lying(mass: f64) -> Trace {
    let skeleton =
        Arc::new(Skeleton::new(vec![Link::new("ball", None, Vec3::zeros(), Joint::Free)]).unwrap());
    let mut rest = skeleton.zero_pose();
    rest[1] = 0.1;
    let body = Body {
        mass,
        com: Vec3::zeros(),
        inertia: Matrix3::identity() * (0.004 * mass),
        shapes: vec![Shape::Sphere { center: Vec3::zeros(), radius: 0.1 }],
    };
    let character = Character {
        name: "ball".into(),
        skeleton,
        bodies: vec![body],
        classes: vec![JointClass::Root],
        contacts: vec![],
        rest: rest.clone(),
    };
    let contact = |row| ContactSample {
        against: Default::default(),
        row,
        link: 0,
        point: Vec3::zeros(),
        force: Vec3::new(0.0, mass * G, 0.0),
        depth: 0.0,
    };
    let zeros = |n: usize| vec![0.0; ROWS * n];
    Trace {
        character: Arc::new(character.check().unwrap()),
        rate_hz: RATE,
        substeps: 1,
        root: RootMode::Free,
        ground_m: Some(0.0),
        gravity: Vec3::new(0.0, -G, 0.0),
        q: rest.repeat(ROWS),
        v: zeros(6),
        target: rest.repeat(ROWS),
        torque: zeros(6),
        stop_torque: zeros(6),
        k_lo: zeros(6),
        k_hi: zeros(6),
        kd: zeros(6),
        contacts: (1..ROWS).map(contact).collect(),
        root_wrench: zeros(6),
        com: [0.0, 0.1, 0.0].repeat(ROWS),
        momentum: zeros(6),
        link_com: Vec::new(),
        disturbed: Disturbed::default(),
        plan: motion::ContactPlan::default(),
        colors: Vec::new(),
        energy: zeros(2),
        wall_s: 0.0,
    }
}

/// Lets a force of `newtons` along x that nothing explains act during `rows`: the momentum takes it, no contact gives it.
fn haunt(trace: &mut Trace, newtons: f64, rows: std::ops::Range<usize>) {
    for row in rows.start..ROWS {
        let steps = (row.min(rows.end - 1) + 1 - rows.start) as f64;
        trace.momentum[6 * row] += newtons * steps / RATE;
    }
}

fn judged(trace: &Trace) -> Verdict {
    Verdict::of(trace, None, None)
}

/// Asserts that the trace is as asked with a force of 0.99 `limit` and a warning with 1.01 `limit`; returns the warning's reason.
fn warns_beyond(trace: &Trace, limit: f64) -> Reason {
    let with = |share: f64| {
        let mut t = trace.clone();
        haunt(&mut t, share * limit, 20..40);
        judged(&t)
    };
    let below = with(0.99);
    assert_eq!((below.grade(), &below.reasons[..]), (Grade::AsAsked, &[][..]), "{limit} N");
    assert!(below.to_string().starts_with("performed as asked, "), "{below}");
    let above = with(1.01);
    assert_eq!(above.grade(), Grade::But, "{limit} N");
    assert!(!above.to_string().contains("as asked"), "{above}");
    let [reason] = &above.reasons[..] else { panic!("{above:?}") };
    assert_eq!(
        (&reason.what, reason.name(), reason.unit()),
        (&What::Unexplained, "momentum unexplained", "N")
    );
    // rounding of differences of N·s times Hz: 1e-9 N; seen 3e-14
    assert!((reason.limit - limit).abs() < 1e-9 && (reason.value - 1.01 * limit).abs() < 1e-9, "{reason:?}");
    reason.clone()
}

/// Both sides of 5 % of the weight, of 5 % of a larger ground force, and of the 10 N that a light body is always allowed.
#[test]
fn momentum_unexplained_beyond_its_limit_warns() {
    assert_eq!((UNEXPLAINED, UNEXPLAINED_N, UNEXPLAINED_S), (0.05, 10.0, 0.05));
    let heavy = lying(50.0);
    let still = judged(&heavy);
    assert_eq!(still.ending, Ending::Rests(vec!["ball".into()]));
    assert_eq!(still.grade(), Grade::AsAsked, "{still}");
    warns_beyond(&heavy, 0.05 * 50.0 * G);

    // one step of twice the weight, which the momentum shows: explained, and the largest force
    let mut pushed = heavy.clone();
    pushed.contacts[9].force *= 2.0;
    (pushed.contacts[9].row..ROWS).for_each(|row| pushed.momentum[6 * row + 1] += 50.0 * G / RATE);
    warns_beyond(&pushed, 0.05 * 2.0 * 50.0 * G);

    // 5 % of its weight are 2.5 N
    warns_beyond(&lying(5.0), 10.0);
}

/// The headline says the force, the limit and when, and that the run is not to be trusted.
#[test]
fn the_headline_of_unexplained_momentum_is_a_warning() {
    let mut trace = lying(50.0);
    haunt(&mut trace, 40.0, 30..45);
    let said = judged(&trace).to_string();
    let words = "the body has no legs and rests on ball, but WARNING: 40 N are unexplained, more than 25 N: do not trust it";
    assert!(said.starts_with(words), "{said}");
    let at_s = judged(&trace).reasons[0].at_s.expect("a time");
    assert!((0.25..0.375).contains(&at_s), "{at_s}");
    // a run that failed keeps its warning
    let failed = Verdict::of(&trace, None, Some("it diverged".into()));
    assert_eq!(failed.grade(), Grade::Failed);
    assert!(failed.to_string().contains("WARNING: 40 N are unexplained"), "{failed}");
}

/// What is taken back within [`UNEXPLAINED_S`], a hand's push on record, and what holds a root are no errors.
#[test]
fn momentum_that_is_explained_does_not_warn() {
    let lying = lying(50.0);
    let limit = 0.05 * 50.0 * G;
    // six rows are 0.05 s: a step of five times the limit is 5/6 of it over them, one of seven times is beyond
    for (times, grade) in [(5.0, Grade::AsAsked), (7.0, Grade::But)] {
        let mut spike = lying.clone();
        haunt(&mut spike, times * limit, 30..31);
        assert_eq!(judged(&spike).grade(), grade, "{times} times the limit in one step");
    }
    let mut haunted = lying.clone();
    haunt(&mut haunted, 4.0 * limit, 20..40);
    assert_eq!(judged(&haunted).grade(), Grade::But);
    let mut pushed = haunted.clone();
    pushed.disturbed.wrench = vec![0.0; 6 * ROWS];
    (20..40).for_each(|row| pushed.disturbed.wrench[6 * row] = 4.0 * limit);
    assert_eq!(judged(&pushed).grade(), Grade::AsAsked, "{}", judged(&pushed));
    let mut held = Trace { root: RootMode::Pinned, ..haunted };
    held.root_wrench.fill(4.0 * limit);
    assert_eq!(judged(&held).grade(), Grade::AsAsked, "{}", judged(&held));
}
