//! Standing is free: scenes at every tension and rate, a quiet minute, nudges, ankles too soft to stand alone, and what each
//! strategy of balance is worth.

use dynamics::{Push, RootMode, Trace};
use motion::{Clip, Kinematics, Vec3};
use scenes::overrides::Strategy;
use sim::EngineEntry;
use studies::push::{PushError, PushSettings, PushTest};
use takes::{Ask, Engines, Take};

fn take(name: &str) -> Take {
    takes::open(support::scene(name), &Ask::default()).unwrap()
}

fn feet(t: &Trace, row: usize) -> Vec<Vec3> {
    let s = &t.character.skeleton;
    let k = Kinematics::new(s, t.pose(row));
    t.character.legs().map(|l| k.origin(l.end)).collect()
}

/// The largest pitch of the chest, degrees; farthest way of an ankle, m.
fn pitch_and_slip(t: &Trace) -> (f64, f64) {
    let s = &t.character.skeleton;
    let (chest, home) = (s.link("chest").unwrap(), feet(t, 0));
    (0..t.rows()).fold((0.0, 0.0), |(pitch, slip): (f64, f64), row| {
        let up = Kinematics::new(s, t.pose(row)).world[chest].rotation * Vec3::y();
        let moved = feet(t, row).iter().zip(&home).map(|(a, b)| (a - b).norm()).fold(slip, f64::max);
        (pitch.max(up.z.atan2(up.y).to_degrees()), moved)
    })
}

/// With the same parameters at T = 0.5, 1, 2, 4 and 120, 240, 480 Hz.
fn stands_everywhere(name: &str, least_pitch: f64) {
    for rate_hz in [120.0, 240.0, 480.0] {
        for tension in [0.5, 1.0, 2.0, 4.0] {
            let mut take = take(name);
            (take.conditions.physics.rate_hz, take.conditions.physics.tension) = (Some(rate_hz), tension);
            assert_eq!(take.conditions.physics.root, RootMode::Free);
            let out = take.outcome(&Engines::default(), &mut |_| {}).unwrap();
            let at = format!("{name}, T = {tension}, {rate_hz} Hz");
            assert!(out.fell_s.is_none() && out.diverged.is_none(), "{at}: fell {:?}", out.fell_s);
            let raised = out.leg_tension.iter().any(|l| l.used > l.asked);
            assert_eq!(raised, tension < 0.6, "{at}: {:?}", out.leg_tension);
            let (pitch, slip) = pitch_and_slip(&out.trace);
            println!("{at}: {pitch:.1}°, feet {:.1} mm", 1e3 * slip);
            assert!(pitch >= least_pitch, "{at}: {pitch}°");
            assert!(slip < 0.015, "{at}: {slip} m");
        }
    }
}

/// 61.0° to 65.4° seen; feet within 1.3 mm.
#[test]
fn slow_the_bow_stands_at_every_tension_and_rate() {
    stands_everywhere("bow.ron", 60.0);
}

/// To the end of its crescendo; feet turn by up to 10 mm.
#[test]
fn slow_the_twist_stands_at_every_tension_and_rate() {
    stands_everywhere("twist.ron", 0.0);
}

#[test]
fn slow_the_reach_stands_at_every_tension_and_rate() {
    stands_everywhere("reach.ron", 0.0);
}

/// `stand.ron` for a minute, with nudges of 1 N·s forward at 20 s and to the left at 40 s.
fn minute(ankle_stiffness: Option<f64>) -> Trace {
    let mut take = take("stand.ron");
    let clip = &take.asked.clip;
    let last = clip.pose(clip.frames() - 1).to_vec();
    let mut q = clip.data().to_vec();
    while q.len() < (60.5 * clip.rate_hz) as usize * last.len() {
        q.extend_from_slice(&last);
    }
    take.asked.clip = Clip::new(clip.skeleton.clone(), clip.rate_hz, q);
    take.asked.tracks.as_mut().unwrap().duration_s = take.asked.clip.duration_s();
    take.conditions.physics.balance.ankle_stiffness = ankle_stiffness;
    let link = take.body.character.skeleton.link("pelvis").unwrap();
    for (start_s, force) in [(20.0, Vec3::z() * 10.0), (40.0, Vec3::x() * 10.0)] {
        take.conditions.pushes.push(Push { link, at: Vec3::zeros(), force, start_s, duration_s: 0.1 });
    }
    let out = take.outcome(&Engines::default(), &mut |_| {}).unwrap();
    assert!(out.fell_s.is_none() && out.diverged.is_none());
    out.trace
}

/// No drift, hardly any sway from 5 s after a nudge on, feet that stay: also with ankles that alone would let the body
/// fall (0.8 m g h). 0.01 mm of drift, 0.02 mm of sway and 1 µm of creep seen.
#[test]
fn slow_a_minute_of_quiet_standing() {
    for ankle_stiffness in [None, Some(0.8)] {
        let t = minute(ankle_stiffness);
        let row = |s: f64| (s * t.rate_hz) as usize;
        let sway = |from: f64, to: f64| {
            let n = (row(to) - row(from)) as f64;
            let rows = || (row(from)..row(to)).map(|r| t.com_at(r));
            let mean = rows().sum::<Vec3>() / n;
            (rows().map(|c| (c - mean).norm_squared()).sum::<f64>() / n).sqrt()
        };
        for (from, to) in [(5.0, 20.0), (25.0, 40.0), (45.0, 60.0)] {
            assert!(sway(from, to) < 2e-4, "{ankle_stiffness:?}: {} m from {from} s", sway(from, to));
        }
        let drift = (t.com_at(row(60.0)) - t.com_at(row(5.0))).norm();
        assert!(drift < 2e-4, "{ankle_stiffness:?}: {drift} m");
        let creep = |(a, b): (&Vec3, &Vec3)| (a - b).norm();
        let creep = feet(&t, row(5.0)).iter().zip(&feet(&t, row(60.0))).map(creep).fold(0.0, f64::max);
        assert!(creep < 2e-4, "{ankle_stiffness:?}: {creep} m");
        // the nudges are felt: 0.5 mm forward, 0.3 mm to the left after 0.3 s
        let felt = |s: f64| (t.com_at(row(s + 0.3)) - t.com_at(row(s))).norm();
        assert!(felt(20.0) > 2e-4 && felt(40.0) > 2e-4, "{} {}", felt(20.0), felt(40.0));
    }
}

/// Largest impulse survived, N·s; none of a body that does not stand by itself.
fn survived(without: Option<Strategy>, deg: f64) -> f64 {
    let mut take = take("stand.ron");
    if let Some(strategy) = without {
        take.conditions.physics.balance = take.conditions.physics.balance.without(strategy);
    }
    let settings = PushSettings { directions: 1, tolerance: 0.03, ..PushSettings::default() };
    match PushTest::new(&take, settings, &EngineEntry::default()) {
        Ok(test) => test.search(deg, &|_| {}).unwrap().survived_ns,
        Err(PushError::Unsteady { .. }) => 0.0,
        Err(e) => panic!("{e}"),
    }
}

/// Each strategy switched off costs its own figure at least 5 %: the hips and the ankles pushes forward, the weight shift pushes
/// to the side.
#[test]
fn slow_every_strategy_carries_its_part() {
    let (forward, left) = (survived(None, 0.0), survived(None, 90.0));
    for (strategy, deg, whole) in
        [(Strategy::Hip, 0.0, forward), (Strategy::Ankle, 0.0, forward), (Strategy::Weight, 90.0, left)]
    {
        let part = survived(Some(strategy), deg);
        println!("without {strategy:?}: {part:.1} of {whole:.1} N·s");
        assert!(part < 0.95 * whole, "{strategy:?}: {part} of {whole} N·s");
    }
}
