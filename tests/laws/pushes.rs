//! Pushes: an impulse is an impulse, and a push in a scene is survived or ends in a reported fall.

use std::sync::Arc;

use dynamics::{Push, RootMode};
use motion::Vec3;

use super::bodies::human;
use super::stage::{bow, hold, perform, run};

/// A body adrift without gravity takes up exactly the impulse of a push, and its moment.
#[test]
fn a_floating_body_takes_up_the_impulse() {
    let c = Arc::new(human());
    for (link, force) in [("chest", Vec3::new(30.0, -20.0, 10.0)), ("wrist_l", Vec3::new(0.0, 5.0, -8.0))] {
        let link = c.skeleton.link(link).unwrap();
        let (start_s, duration_s) = (0.2, 0.1);
        let at = Vec3::new(0.03, 0.05, -0.02);
        let mut pass = hold(&c, Vec3::zeros(), 2.0, 0.6);
        pass.pushes.push(Push { link, at, force, start_s, duration_s });
        let t = run(pass).trace;
        let momentum = |row: usize, k: usize| motion::skeleton::vec_at(&t.momentum, 6 * row + k);
        let last = t.rows() - 1;
        let before = (start_s * t.rate_hz) as usize;
        let after = ((start_s + duration_s) * t.rate_hz) as usize;
        assert!(momentum(before, 0).norm() < 1e-12);
        let impulse = force * duration_s;
        let error = (momentum(after, 0) - impulse).norm() / impulse.norm();
        println!("linear error {error:.1e}");
        assert!(error < 0.01, "{:?} after an impulse of {impulse:?}", momentum(after, 0));
        // moment of the push about the moving centre of mass
        let s = &c.skeleton;
        let spin: Vec3 = (before..after)
            .map(|r| {
                let k = motion::Kinematics::new(s, t.pose(r));
                (k.point(link, &at) - t.com_at(r)).cross(&force) / t.rate_hz
            })
            .sum();
        let error = (momentum(after, 3) - spin).norm() / spin.norm();
        println!("angular error {error:.1e}");
        assert!(error < 0.02, "{:?} after {spin:?}", momentum(after, 3));
        // afterwards nothing acts: muscles cannot change momentum
        let drift = (momentum(last, 0) - momentum(after, 0)).norm() / impulse.norm();
        let turned = (momentum(last, 3) - momentum(after, 3)).norm() / spin.norm();
        println!("drift {drift:.1e} {turned:.1e}");
        assert!(drift < 0.01 && turned < 0.02, "{drift} {turned}");
    }
}

/// A light push is survived; a heavy one ends in a fall, reported with a time after it.
#[test]
fn slow_a_push_is_survived_or_reported() {
    let c = Arc::new(human());
    let mut tracks = bow(&c);
    tracks.tracks.clear();
    let link = c.skeleton.link("chest").unwrap();
    for (newtons, falls) in [(60.0, false), (2000.0, true)] {
        let mut pass = perform(&c, &tracks, RootMode::Free, 240.0, 2);
        let force = Vec3::z() * newtons;
        pass.pushes.push(Push { link, at: Vec3::zeros(), force, start_s: 0.5, duration_s: 0.2 });
        let out = run(pass);
        println!("{newtons} N: fell {:?}", out.fell_s);
        assert_eq!(out.fell_s.is_some(), falls, "{newtons} N");
        assert!(out.fell_s.is_none_or(|t| t > 0.5 && t < 3.0));
    }
}

/// Where each foot keeps its half of the load, a push to the side throws the body over; with weight shift the feet
/// all but stay (4 mm seen), and the body comes back (0.4 mm).
#[test]
fn slow_weight_shift_keeps_the_feet_in_a_push_to_the_side() {
    let c = Arc::new(human());
    let s = &c.skeleton;
    let mut tracks = bow(&c);
    tracks.tracks.clear();
    tracks.duration_s = 5.6;
    let link = s.link("abdomen").unwrap();
    let feet = ["ankle_l", "ankle_r"].map(|n| s.link(n).unwrap());
    for newtons in [280.0, -280.0] {
        for weight_shift in [true, false] {
            let mut pass = perform(&c, &tracks, RootMode::Free, 120.0, 2);
            pass.setup.balance.weight_shift = weight_shift;
            pass.setup.balance.hip = false; // which alone would halve the slip
            let force = Vec3::x() * newtons;
            pass.pushes.push(Push { link, at: Vec3::zeros(), force, start_s: 0.5, duration_s: 0.1 });
            let out = run(pass);
            let t = out.trace;
            let at =
                |row: usize| feet.map(|f| motion::Kinematics::new(s, t.pose(row)).point(f, &Vec3::zeros()));
            let start = at(60);
            let moved = (60..t.rows())
                .flat_map(|r| at(r).into_iter().zip(start).map(|(p, s)| (p - s).norm()))
                .fold(0.0, f64::max);
            let back = (t.com_at(t.rows() - 1) - t.com_at(60)).norm();
            println!(
                "{newtons} N, shift {weight_shift}: feet {:.1} mm, back {:.1} mm",
                moved * 1e3,
                back * 1e3
            );
            if weight_shift {
                assert!(out.fell_s.is_none() && back < 0.02, "{newtons} N: {back} m, fell {:?}", out.fell_s);
                assert!(moved < 0.012, "{newtons} N: {moved} m");
            } else {
                assert!(moved > 0.03, "{newtons} N: {moved} m");
            }
        }
    }
}
