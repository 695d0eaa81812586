//! Laws of weight shifts: flights fall, pressures are the nearest that soles carry, mirrored plans shift mirrored.

use controllers::shift::{Asked, Ground, MARGIN_M, heights, inside, path};
use motion::Vec3;
use motion::support::{Support, Vec2};

const RATE: f64 = 120.0;
const G: f64 = 9.81;

fn sole(x: f64, z: f64) -> Support {
    let corner = |(a, b): (f64, f64)| Vec2::new(x + a, z + b);
    Support::of_plane([(-0.04, -0.1), (0.04, -0.1), (0.05, 0.15), (-0.05, 0.15)].map(corner).to_vec())
}

/// Steps to the left and right, with a flight in the middle; mirrored if `side` is −1.
fn ground(frames: usize, side: f64, friction: f64) -> Ground {
    let flies = |f: usize| (110..140).contains(&f);
    let one = |f: usize| {
        if flies(f) {
            Support::default()
        } else if (f / 60).is_multiple_of(2) {
            sole(0.1 * side, 0.0)
        } else {
            sole(-0.1 * side, 0.2)
        }
    };
    let support: Vec<Support> = (0..frames).map(one).collect();
    Ground {
        hull: support.clone(),
        support,
        held: vec![false; frames],
        height_m: vec![0.0; frames],
        friction,
    }
}

/// A path that sways, and is not over its soles.
fn sway(frames: usize, side: f64) -> Vec<Vec3> {
    let at = |f: usize| {
        let t = f as f64 / RATE;
        let across = 0.06 * (5.0 * t).sin();
        Vec3::new(side * across, 0.95 + 0.01 * (9.0 * t).cos(), 0.1 * t + 0.02 * (3.0 * t).sin())
    };
    (0..frames).map(at).collect()
}

/// What a path without angular momentum asks, as in `controllers::shift::asked`.
fn asked(com: &[Vec3]) -> Vec<Asked> {
    let n = com.len();
    (0..n)
        .map(|f| {
            let f1 = f.clamp(1, n - 2);
            let bend = (com[f1 - 1] + com[f1 + 1] - com[f1] * 2.0) * RATE * RATE;
            let force = bend + Vec3::y() * G;
            let moment = (Vec3::y() * com[f].y).cross(&force);
            Asked { force, moment, height_m: com[f].y, under: Vec2::new(com[f].x, com[f].z) }
        })
        .collect()
}

fn moved(com: &[Vec3], x: &[Vec2], y: &[f64]) -> Vec<Vec3> {
    com.iter().zip(x.iter().zip(y)).map(|(c, (x, y))| c + Vec3::new(x.x, *y, x.y)).collect()
}

/// The whole of it: heights, then the path over the ground.
fn solved(com: &[Vec3], ground: &Ground) -> (Vec<Vec3>, Vec<Vec3>) {
    let n = com.len();
    let y = heights(com, &vec![0.0; n], G, RATE, ground);
    let risen = moved(com, &vec![Vec2::zeros(); n], &y);
    let x = path(&asked(&risen), G, RATE, ground);
    (risen.clone(), moved(&risen, &x, &vec![0.0; n]))
}

/// In flight the centre of mass falls, at g and nothing else; on the ground nothing pulls.
#[test]
fn flights_fall() {
    let ground = ground(240, 1.0, 0.8);
    let (_, path) = solved(&sway(240, 1.0), &ground);
    let mut worst: f64 = 0.0;
    for (f, a) in asked(&path).iter().enumerate().skip(1).take(238) {
        if ground.flies(f) {
            worst = worst.max(a.force.norm());
        } else {
            assert!(a.force.y > -1e-3, "{f}: {}", a.force.y);
        }
    }
    println!("flights fall at g within {worst:.1e} m/s²");
    assert!(worst < 1e-8, "{worst} m/s²"); // 7e-12 seen
    assert_eq!((path[0], path[239]), (sway(240, 1.0)[0], sway(240, 1.0)[239]));
}

/// The KKT conditions of the least movement of the pressure: inside the soles; where it was inside, where it was; else at
/// the nearest point, so that no other point of the set makes an acute angle with the way there.
#[test]
fn the_pressure_is_the_nearest_that_soles_carry() {
    // enough friction never to matter
    let ground = ground(240, 1.0, 50.0);
    let (before, after) = solved(&sway(240, 1.0), &ground);
    let (mut kept, mut active, mut worst) = (0, 0, 0.0f64);
    for (f, (a, b)) in asked(&before).iter().zip(&asked(&after)).enumerate().skip(1).take(238) {
        let (Some(p), Some(q)) = (a.pressure(G), b.pressure(G)) else { continue };
        let wanted = inside(&ground.support[f], p);
        worst = worst.max((q - wanted).norm());
        assert!(ground.support[f].margin(&q) > MARGIN_M * 0.1 - 1e-9, "{f}: {q}");
        if (wanted - p).norm() < 1e-12 {
            kept += 1;
        } else {
            active += 1;
            for corner in ground.support[f].corners() {
                // corners of the shrunk set lie towards the centroid of the support
                let center = ground.support[f].centroid().unwrap();
                let other = inside(&ground.support[f], center + (corner - center) * 0.999);
                assert!((other - wanted).dot(&(p - wanted)) < 1e-9, "{f}");
            }
        }
    }
    assert!(kept > 20 && active > 20, "{kept} kept, {active} moved");
    println!("{kept} frames kept, {active} moved, to their nearest point within {worst:.1e} m");
    assert!(worst < 1e-9, "{worst} m"); // 1e-13 seen
}

/// Forces stay inside the friction cone, also where soles and friction do not agree.
#[test]
fn forces_stay_inside_the_friction_cone() {
    let ground = ground(240, 1.0, 0.05);
    let (_, after) = solved(&sway(240, 1.0), &ground);
    let mut used: f64 = 0.0;
    for a in &asked(&after)[1..239] {
        let across = a.force.x.hypot(a.force.z);
        assert!(across < 0.05 * a.force.y.max(0.0) * 1.02 + 1e-6, "{across} of {}", a.force.y);
        used = used.max(across / (0.05 * a.force.y.max(1e-3)));
    }
    assert!(used > 0.99, "the cone is reached: {used}");
}

/// A mirrored plan of a mirrored path shifts mirrored, and what is carried does not move at all.
#[test]
fn mirrored_plans_shift_mirrored() {
    let [left, right] = [1.0, -1.0].map(|side| solved(&sway(240, side), &ground(240, side, 0.8)).1);
    let worst =
        left.iter().zip(&right).map(|(l, r)| (l - Vec3::new(-r.x, r.y, r.z)).norm()).fold(0.0, f64::max);
    println!("mirrored within {worst:.1e} m");
    assert!(worst < 1e-12, "{worst} m"); // 3e-17 seen
    let mut stands = ground(240, 1.0, 0.8);
    stands.support = vec![sole(0.0, 0.0); 240];
    stands.hull = stands.support.clone();
    let still = vec![Vec3::new(0.0, 0.95, 0.02); 240];
    assert_eq!(solved(&still, &stands).1, still);
}

/// A weight shifts before the foot leaves, and what is far away does not notice: the solution does not grow.
#[test]
fn a_weight_shifts_before_the_foot_leaves() {
    let frames = 1200;
    let mut ground = ground(frames, 1.0, 0.8);
    let both = |f: usize| {
        let feet = [sole(0.1, 0.0), sole(-0.1, 0.0)];
        let of = if f < 600 { &feet[..] } else { &feet[..1] };
        Support::of_plane(of.iter().flat_map(|s| s.corners().iter().copied()).collect())
    };
    ground.support = (0..frames).map(both).collect();
    ground.hull = ground.support.clone();
    let middle = vec![Vec3::new(0.0, 0.95, 0.02); frames];
    let x: Vec<f64> = solved(&middle, &ground).1.iter().map(|c| c.x).collect();
    assert!(
        x[600] > 0.02 && x[560] > 0.005,
        "{} m as it leaves, {} m a third of a second before",
        x[600],
        x[560]
    );
    assert!(x[100] < 1e-5 && x[900] > 0.05, "{} {}", x[100], x[900]);
    assert!(x.windows(2).take(700).all(|w| w[1] >= w[0] - 1e-12), "it goes one way");
}
