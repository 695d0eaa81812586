//! No hidden hand: what moves the centre of mass is gravity, contacts and the reported root wrench.
//!
//! Momentum is differenced from the recorded link centres as well: a road that does not pass through the
//! recorded velocities.

use std::sync::Arc;

use dynamics::{RootMode, Trace};
use motion::Vec3;

use super::bodies::human;
use super::stage::{bow, perform, run};

/// RMS over the rows of d(momentum)/dt − m g − Σ contacts − root force, N.
fn residual_rms(t: &Trace) -> f64 {
    let mass = t.character.mass();
    let sums = t.contact_sums();
    let momentum = |row: usize| motion::skeleton::vec_at(&t.momentum, 6 * row);
    let square = (1..t.rows()).map(|r| {
        let rate = (momentum(r) - momentum(r - 1)) * t.rate_hz;
        let held = motion::skeleton::vec_at(&t.root_wrench, 6 * r);
        (rate - t.gravity * mass - sums[r] - held).norm_squared()
    });
    (square.sum::<f64>() / (t.rows() - 1) as f64).sqrt()
}

/// The same from the recorded centres of the links: momentum is Σ m Δx/Δt, RMS, N.
fn residual_of_places_rms(t: &Trace) -> f64 {
    let links = t.character.bodies.len();
    let mass = t.character.mass();
    let sums = t.contact_sums();
    let momentum = |r: usize| -> Vec3 {
        let at = |row: usize, l: usize| motion::skeleton::vec_at(&t.link_com, 3 * (row * links + l));
        (0..links).map(|l| (at(r, l) - at(r - 1, l)) * (t.rate_hz * t.character.bodies[l].mass)).sum()
    };
    let square = (2..t.rows()).map(|r| {
        let held = motion::skeleton::vec_at(&t.root_wrench, 6 * r);
        let rate = (momentum(r) - momentum(r - 1)) * t.rate_hz;
        (rate - t.gravity * mass - sums[r] - held).norm_squared()
    });
    (square.sum::<f64>() / (t.rows() - 2) as f64).sqrt()
}

/// The bow on free feet: balance of momentum, the weight on the ground at the end, feet that stay.
#[test]
fn slow_the_bow_stands_on_contacts_alone() {
    let c = Arc::new(human());
    let weight = c.mass() * 9.81;
    let tracks = bow(&c);
    let out = run(perform(&c, &tracks, RootMode::Free, 240.0, 2));
    let t = &out.trace;
    assert!(out.fell_s.is_none(), "fell at {:?}", out.fell_s);
    assert!(t.root_wrench.iter().all(|x| *x == 0.0));
    let residual = residual_rms(t) / weight;
    let places = residual_of_places_rms(t) / weight;
    let still = 192; // 0.8 s
    let sums = t.contact_sums();
    let mean = sums[t.rows() - still..].iter().map(|f| f.y).sum::<f64>() / still as f64 / weight;
    let sites: Vec<_> = c.contacts.iter().map(|&i| &c.skeleton.sites()[i]).collect();
    let feet = motion::metrics::feet(&t.clip(), &sites, 0.0);
    println!(
        "residual {:.4} %, from places {:.4} %, weight {mean:.5}, {feet:?}",
        residual * 100.0,
        places * 100.0
    );
    assert!(residual < 0.005, "{residual}");
    assert!(places < 0.005, "{places}");
    assert!((mean - 1.0).abs() < 0.005, "{mean}");
    assert!(feet.slip_mm_max < 3.0 && feet.penetration_mm_max < 3.0, "{feet:?}");
    for f in &sums {
        assert!(f.xz().norm() <= 0.8 * f.y + 1e-6, "outside the friction cone: {f:?}");
    }
}

/// An assisted root: the same balance with the recorded wrench, which never exceeds its budget.
#[test]
fn slow_assist_is_on_the_record_and_within_budget() {
    let c = Arc::new(human());
    let tracks = bow(&c);
    let (force_n, moment_nm) = (20.0, 8.0);
    let out = run(perform(&c, &tracks, RootMode::Assisted { force_n, moment_nm }, 240.0, 2));
    let t = &out.trace;
    let weight = c.mass() * 9.81;
    assert!(residual_rms(t) < 0.005 * weight, "{} N", residual_rms(t));
    let mut used = (0.0_f64, 0.0_f64);
    for r in 0..t.rows() {
        let at = |k: usize| motion::skeleton::vec_at(&t.root_wrench, 6 * r + k).norm();
        used = (used.0.max(at(0)), used.1.max(at(3)));
    }
    assert!(used.0 > 1.0 && used.0 <= force_n * (1.0 + 1e-12), "{used:?}");
    assert!(used.1 > 1.0 && used.1 <= moment_nm * (1.0 + 1e-12), "{used:?}");
}
