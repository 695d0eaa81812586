//! Laws of whole-body inverse kinematics: goals are met, what is met stays, limits hold, both methods agree.

use std::sync::Arc;

use motion::ik::{Floor, Goal, Method, Point, Problem, Unknowns, WholeBody};
use motion::limits::tangent_correction;
use motion::rotation::exp;
use motion::{BallLimits, Joint, Kinematics, Limits, Link, Range, Skeleton, Vec3};

const ELBOW: usize = 3;
const HANDS: [usize; 2] = [4, 7];
const GAUSS_NEWTON: Method = Method::GaussNewton { most_steps: 30, full_steps: 10, settle: 2, still: 1e-10 };
const MARQUARDT: Method = Method::LevenbergMarquardt { most_steps: 60, enough: 1e-12 };
const METHODS: [Method; 2] = [GAUSS_NEWTON, MARQUARDT];

/// A trunk with two arms and a sliding head; zero frames turned, balls, hinges and the slide limited.
fn body() -> Arc<Skeleton> {
    let ball = |half: f64| {
        let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
        Some(Limits::Ball(BallLimits { axes, ranges: [Range::new(-half, half); 3] }))
    };
    let mut links = vec![
        Link::new("pelvis", None, Vec3::zeros(), Joint::Free),
        Link::new("chest", Some(0), Vec3::new(0.0, 0.3, 0.02), Joint::Spherical),
    ];
    links[1].limits = ball(0.6);
    for (side, x) in [("l", 1.0), ("r", -1.0)] {
        let at = links.len();
        links.push(Link::new(
            format!("shoulder_{side}"),
            Some(1),
            Vec3::new(0.2 * x, 0.2, 0.0),
            Joint::Spherical,
        ));
        links.push(Link::new(
            format!("elbow_{side}"),
            Some(at),
            Vec3::new(0.3 * x, 0.0, 0.01),
            Joint::Revolute(Vec3::y()),
        ));
        links.push(Link::new(
            format!("hand_{side}"),
            Some(at + 1),
            Vec3::new(0.25 * x, 0.0, 0.0),
            Joint::Spherical,
        ));
        links[at].limits = ball(1.5);
        links[at].parent_from_zero.rotation = exp(&Vec3::new(0.2, -0.1 * x, 0.3));
        let bend = if x > 0.0 { Range::new(-2.4, 0.0) } else { Range::new(0.0, 2.4) };
        links[at + 1].limits = Some(Limits::Axis(bend));
        links[at + 2].limits = ball(0.8);
    }
    links.push(Link::new("head", Some(1), Vec3::new(0.0, 0.3, 0.0), Joint::Prismatic(Vec3::y())));
    links[8].limits = Some(Limits::Axis(Range::new(-0.05, 0.1)));
    Arc::new(Skeleton::new(links).unwrap())
}

/// A pose within the limits, other for every `seed`.
fn pose(s: &Skeleton, seed: f64, size: f64) -> Vec<f64> {
    let mut q = s.zero_pose();
    s.set_position(&mut q, 0, &Vec3::new(0.2, 1.0, -0.3));
    q[s.q_at(ELBOW)] = -0.9;
    q[s.q_at(6)] = 0.9;
    let v: Vec<f64> = (0..s.nv()).map(|i| size * (seed * 1.7 + 2.3 * i as f64).sin()).collect();
    s.integrate(&mut q, &v, 1.0);
    s.clamp_to_limits(&mut q);
    q
}

/// A point off the origin of each of these links, to be where the pose `q` has it.
fn points(s: &Skeleton, q: &[f64], links: &[usize], weight: f64) -> Vec<Point> {
    let (k, at) = (Kinematics::new(s, q), Vec3::new(0.05, 0.02, -0.03));
    let point = |&link: &usize| Point {
        link,
        at,
        goal: Some(Goal { place: k.point(link, &at), weight, along: None }),
        on_floor: false,
    };
    links.iter().map(point).collect()
}

fn missed(s: &Skeleton, q: &[f64], points: &[Point]) -> f64 {
    let k = Kinematics::new(s, q);
    let distance = |p: &Point| p.goal.map_or(0.0, |g| (k.point(p.link, &p.at) - g.place).norm());
    points.iter().map(distance).fold(0.0, f64::max)
}

fn beyond(s: &Skeleton, q: &[f64]) -> f64 {
    let way = |l: usize| tangent_correction(s, q, l).map_or(0.0, |e| e.norm());
    (0..s.links().len()).map(way).fold(0.0, f64::max)
}

fn free(_: &Skeleton, _: &mut [f64]) {}

/// Goals that a pose within the limits meets are met from another one, by either method.
#[test]
fn reachable_goals_are_reached() {
    let s = body();
    let (weights, mut solver) = (vec![1.0; s.nv()], WholeBody::new(&s, Unknowns::All));
    for method in METHODS {
        let (mut worst, mut most) = (0.0f64, 0);
        for i in 0..100 {
            let from = pose(&s, f64::from(i), 0.25);
            let points = points(&s, &pose(&s, f64::from(i) + 0.4, 0.3), &[4, 7, 8], 1e7);
            let mut q = from.clone();
            let problem = Problem {
                points: &points,
                reference: &from,
                weights: &weights,
                limit_weight: 1e5,
                floor: None,
            };
            most = most.max(solver.solve(&problem, method, &mut q, &free));
            worst = worst.max(missed(&s, &q, &points));
        }
        println!("{method:?}: {worst:.1e} m, at most {most} steps");
        assert!(worst < 1e-6, "{method:?}: {worst}"); // 1.7e-7 m seen, by either
    }
}

/// Where all goals are met and no joint is beyond its limits, nothing moves.
#[test]
fn what_is_met_stays() {
    let s = body();
    let weights = vec![1.0; s.nv()];
    for unknowns in [Unknowns::All, Unknowns::HeightRollPitch] {
        let mut solver = WholeBody::new(&s, unknowns);
        for (i, method) in (0..20).flat_map(|i| METHODS.map(|m| (i, m))) {
            let from = pose(&s, f64::from(i), 0.3);
            let points = points(&s, &from, &HANDS, 1e7);
            let floor = Some(Floor { height_m: -1.0, weight: 1e6 });
            let problem =
                Problem { points: &points, reference: &from, weights: &weights, limit_weight: 1e5, floor };
            let mut q = from.clone();
            solver.solve(&problem, method, &mut q, &free);
            let change = q.iter().zip(&from).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(change < 1e-12, "{method:?}: {change}"); // 2e-16 seen
        }
    }
}

/// A goal that only an overstretched elbow reaches leaves the elbow at its limit; without the weight of limits it does not.
#[test]
fn limits_hold_against_goals() {
    let s = body();
    let mut from = pose(&s, 0.3, 0.1);
    // the arm alone may move, and its elbow most of all
    let mut weights = vec![1e6; s.nv()];
    weights[s.v_at(ELBOW)] = 1.0;
    from[s.q_at(ELBOW)] = -0.2;
    let mut bent = from.clone();
    bent[s.q_at(ELBOW)] = 0.7;
    let points = points(&s, &bent, &[4], 100.0);
    let mut solver = WholeBody::new(&s, Unknowns::All);
    for method in METHODS {
        let mut solve = |limit_weight: f64| {
            let problem =
                Problem { points: &points, reference: &from, weights: &weights, limit_weight, floor: None };
            let mut q = from.clone();
            solver.solve(&problem, method, &mut q, &free);
            q
        };
        let (kept, loose) = (solve(1e6), solve(0.0));
        assert!(beyond(&s, &kept) < 1e-4, "{method:?}: {}", beyond(&s, &kept)); // 6e-6 rad seen
        assert!(beyond(&s, &loose) > 0.2, "{method:?}: {}", beyond(&s, &loose));
    }
}

/// Both methods find the same pose for goals that no pose meets, and no pose near it costs less.
#[test]
fn both_methods_find_the_least_cost() {
    let s = body();
    let weights: Vec<f64> = (0..s.nv()).map(|i| 0.5 + 0.1 * i as f64).collect();
    let mut solver = WholeBody::new(&s, Unknowns::All);
    let mut apart = 0.0f64;
    for i in 0..20 {
        let from = pose(&s, f64::from(i), 0.2);
        let mut points = points(&s, &pose(&s, f64::from(i) + 0.5, 0.2), &[0, 4, 7, 8], 40.0);
        points[3].goal.as_mut().unwrap().place.x += 0.1;
        let problem =
            Problem { points: &points, reference: &from, weights: &weights, limit_weight: 30.0, floor: None };
        let found = METHODS.map(|method| {
            let mut q = from.clone();
            solver.solve(&problem, method, &mut q, &free);
            q
        });
        let costs = found.each_ref().map(|q| solver.cost(&problem, q));
        assert!(costs[0] < solver.cost(&problem, &from));
        apart = apart.max((costs[0] / costs[1] - 1.0).abs());
        let mut v = vec![0.0; s.nv()];
        for (dof, step) in (0..s.nv()).flat_map(|d| [-0.02, 0.02].map(|x| (d, x))) {
            let mut q = found[1].clone();
            v.fill(0.0);
            v[dof] = step;
            s.integrate(&mut q, &v, 1.0);
            assert!(solver.cost(&problem, &q) > costs[1], "{i}: {dof} by {step}");
        }
    }
    println!("costs differ by {apart:.1e}");
    assert!(apart < 1e-6, "{apart}"); // 9e-8 seen
}

/// Points below the floor are pushed onto it, those that it does not concern are not.
#[test]
fn the_floor_pushes_points_out() {
    let s = body();
    let (weights, from) = (vec![1.0; s.nv()], pose(&s, 0.9, 0.2));
    let mut solver = WholeBody::new(&s, Unknowns::All);
    let hands = HANDS.map(|h| Kinematics::new(&s, &from).origin(h).y);
    let height_m = hands[0].max(hands[1]) + 0.1;
    for method in METHODS {
        let height = |solver: &mut WholeBody, on_floor: bool| {
            let points = HANDS.map(|link| Point { link, at: Vec3::zeros(), goal: None, on_floor });
            let floor = Some(Floor { height_m, weight: 1e6 });
            let problem =
                Problem { points: &points, reference: &from, weights: &weights, limit_weight: 1e5, floor };
            let mut q = from.clone();
            solver.solve(&problem, method, &mut q, &free);
            let k = Kinematics::new(&s, &q);
            HANDS.map(|h| k.origin(h).y)
        };
        for y in height(&mut solver, true) {
            assert!((y - height_m).abs() < 1e-4, "{method:?}: {}", y - height_m); // 1e-6 m seen
        }
        assert_eq!(height(&mut solver, false), hands);
    }
}

/// Where place and heading have another owner, the root goes neither sideways nor forward.
#[test]
fn the_root_rises_and_leans_only() {
    let s = body();
    let (from, weights) = (pose(&s, 0.2, 0.1), vec![1e-3; s.nv()]);
    let mut lower = from.clone();
    lower[1] -= 0.2;
    let leaning = exp(&Vec3::new(0.25, 0.0, -0.15)) * s.rotation(&lower, 0);
    s.set_rotation(&mut lower, 0, &leaning);
    let points = points(&s, &lower, &[0, 1, 4, 7], 1.0);
    let mut solver = WholeBody::new(&s, Unknowns::HeightRollPitch);
    let problem =
        Problem { points: &points, reference: &from, weights: &weights, limit_weight: 1e3, floor: None };
    let mut q = from.clone();
    solver.solve(&problem, MARQUARDT, &mut q, &free);
    // 9e-5 m seen: the heading that the lean changes a little is left to the joints
    assert!(missed(&s, &q, &points) < 1e-3, "{}", missed(&s, &q, &points));
    assert!((q[1] - lower[1]).abs() < 1e-3);
    assert_eq!((q[0], q[2]), (from[0], from[2]));
}
