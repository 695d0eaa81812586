//! Laws of time maps: anchors, slopes, inverse, composition, retimed clips, refusals.

use std::sync::Arc;

use motion::rotation::exp;
use motion::time_map::{End, LEAST_SLOPE, MOST_SLOPE};
use motion::{Clip, Joint, Link, Skeleton, TimeMap, Vec3};
use proptest::prelude::*;

/// Late at 1 s, hurried afterwards, in step again at 3 s.
const LATE: [(f64, f64); 4] = [(0.5, 0.5), (1.0, 1.4), (2.2, 2.5), (3.0, 3.0)];

fn map(anchors: &[(f64, f64)]) -> TimeMap {
    TimeMap::new(anchors).unwrap()
}

/// Times that avoid and meet the anchors of [`LATE`].
fn times() -> impl Iterator<Item = f64> {
    (-40..=420).map(|i| f64::from(i) / 100.0)
}

/// Free root on a bow, a ball that turns, a hinge at constant speed: 4 s at 50 Hz.
fn clip() -> Clip {
    let links = vec![
        Link::new("pelvis", None, Vec3::new(0.1, 0.9, 0.0), Joint::Free),
        Link::new("spine", Some(0), Vec3::new(0.0, 0.2, -0.05), Joint::Spherical),
        Link::new("elbow", Some(1), Vec3::new(-0.3, 0.3, 0.0), Joint::Revolute(Vec3::x())),
    ];
    let s = Arc::new(Skeleton::new(links).unwrap());
    let mut q = Vec::new();
    for i in 0..=200 {
        let t = f64::from(i) / 50.0;
        let mut pose = s.zero_pose();
        s.set_position(&mut pose, 0, &Vec3::new(0.3 * t, 0.9 + 0.05 * (2.0 * t).sin(), -0.1 * t * t));
        s.set_rotation(&mut pose, 0, &exp(&Vec3::new(0.1 * t, 0.4 * t.sin(), 0.2)));
        s.set_rotation(&mut pose, 1, &exp(&Vec3::new(0.3 * (1.5 * t).cos(), 0.1, -0.2 * t)));
        pose[s.q_at(2)] = SPEED * t - 0.4;
        q.extend(pose);
    }
    Clip::new(s, 50.0, q)
}

/// Speed of the hinge of [`clip`], rad/s.
const SPEED: f64 = 0.7;

/// Largest difference between two clips over the frames of the first, rad or m.
fn apart(a: &Clip, b: &Clip) -> f64 {
    let mut v = vec![0.0; a.skeleton.nv()];
    let mut worst = 0.0_f64;
    for f in 0..a.frames() {
        a.skeleton.difference(a.pose(f), b.pose(f), 1.0, &mut v);
        worst = v.iter().fold(worst, |m, x| m.max(x.abs()));
    }
    worst
}

#[test]
fn identity_to_the_bit() {
    let clip = clip();
    for map in
        [TimeMap::identity(), map(&[(0.3, 0.3), (0.7, 0.7), (1.9, 1.9)]), TimeMap::identity().inverse()]
    {
        assert!(map.is_identity());
        for t in times() {
            assert_eq!(map.at(t).to_bits(), t.to_bits());
            assert_eq!(map.rate(t), 1.0);
        }
        assert_eq!(map.retime(&clip), clip);
        assert_eq!(map.then(&self::map(&LATE)), self::map(&LATE));
    }
}

#[test]
fn anchors_are_met_to_the_bit_and_time_is_shifted_outside() {
    let anchors = [(0.5, 0.7), (1.0, 1.4), (2.2, 2.5), (3.0, 3.9)];
    let map = map(&anchors);
    for (from, to) in anchors {
        assert_eq!(map.at(from), to);
        assert_eq!(map.inverse().at(to), from);
    }
    for t in [-3.0, -0.1, 0.4, 3.1, 7.0] {
        let shift = if t < 1.0 { 0.7 - 0.5 } else { 3.9 - 3.0 };
        assert_eq!(map.at(t), t + shift);
        assert_eq!(map.rate(t), 1.0);
    }
}

/// The rate is the derivative, and it is the same from both sides of every anchor, the outer ones too.
/// The map's curvature, below 10 /s, moves a difference over 1e-6 s by 4.3e-6 (seen).
#[test]
fn slopes_are_continuous_at_anchors() {
    let map = map(&LATE);
    let e = 1e-6;
    for (from, _) in LATE {
        let left = (map.at(from) - map.at(from - e)) / e;
        let right = (map.at(from + e) - map.at(from)) / e;
        assert!((left - right).abs() < 1e-5, "{from}: {left} {right}");
        assert!((map.rate(from) - right).abs() < 1e-5, "{from}: {} {right}", map.rate(from));
    }
    assert_eq!((map.rate(0.5), map.rate(3.0)), (1.0, 1.0));
}

/// The derivative between anchors, against central differences. 3.6e-9 seen.
#[test]
fn rate_is_the_derivative() {
    let map = map(&LATE);
    for map in [&map, &map.inverse()] {
        let e = 1e-5;
        for t in (0..50).map(|i| 0.503 + f64::from(i) * 0.0497) {
            let difference = (map.at(t + e) - map.at(t - e)) / (2.0 * e);
            if LATE.iter().any(|(from, to)| (from - t).abs() < 2.0 * e || (to - t).abs() < 2.0 * e) {
                continue;
            }
            assert!((map.rate(t) - difference).abs() < 1e-8, "{t}: {} {difference}", map.rate(t));
        }
    }
}

#[test]
fn free_ends_follow_the_anchors() {
    let line = TimeMap::with_ends(&[(0.0, 0.0), (2.0, 3.0)], [End::Free; 2]).unwrap();
    for t in [0.0, 0.3, 1.0, 1.7, 2.0] {
        assert_eq!(line.rate(t), 1.5);
        assert!((line.at(t) - 1.5 * t).abs() < 1e-15);
    }
    // one end each way: 1 where the motion goes on, steeper than its interval where it does not
    let eased = TimeMap::with_ends(&[(0.0, 0.0), (2.0, 3.0)], [End::Free, End::Joined]).unwrap();
    assert_eq!((eased.rate(0.0), eased.rate(2.0)), (1.5, 1.0));
    // three-point formula: ((2·1 + 1)·0.5 − 1·0.8)/2 = 0.35
    let three = TimeMap::with_ends(&[(0.0, 0.0), (1.0, 0.5), (2.0, 1.3)], [End::Free; 2]).unwrap();
    assert!((three.rate(0.0) - 0.35).abs() < 1e-15);
}

/// Where an interval runs more than twice as fast, the joint has a jump, of the size stated.
#[test]
fn fast_intervals_end_at_twice_their_slope() {
    let map = map(&[(0.0, 0.0), (1.0, 0.3)]);
    assert_eq!((map.rate(-1e-9), map.rate(0.0)), (1.0, 0.6));
    assert_eq!((map.rate(1.0), map.rate(1.0 + 1e-9)), (0.6, 1.0));
    // the middle of the interval hurries no more than twice as much as asked
    assert!((map.rate(0.5) - 0.15).abs() < 1e-15);
}

#[test]
fn maps_compose() {
    let (first, second) = (map(&LATE), map(&[(0.2, 0.2), (1.3, 0.9), (2.0, 2.4)]));
    let both = first.then(&second);
    for t in times() {
        assert_eq!(both.at(t), second.at(first.at(t)));
        assert_eq!(both.rate(t), first.rate(t) * second.rate(first.at(t)));
        // 8.9e-16 seen
        assert!((both.inverse().at(both.at(t)) - t).abs() < 1e-14, "{t}");
    }
}

/// Anchors with slopes in [½, 2], and a time.
fn gentle() -> impl Strategy<Value = (Vec<(f64, f64)>, f64)> {
    let steps = prop::collection::vec((0.05..1.5_f64, 0.5..2.0_f64), 1..7);
    (steps, -1.0..10.0_f64).prop_map(|(steps, t)| {
        let mut anchors = vec![(0.3, 0.1)];
        for (h, slope) in steps {
            let (from, to) = anchors[anchors.len() - 1];
            anchors.push((from + h, to + h * slope));
        }
        (anchors, t)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, rng_seed: prop::test_runner::RngSeed::Fixed(11), ..ProptestConfig::default() })]

    /// Round trips to rounding: see the residue at [`TimeMap::inverse`].
    #[test]
    fn inverse_is_the_way_back((anchors, t) in gentle()) {
        let map = map(&anchors);
        let back = map.inverse();
        let there = map.at(t);
        let miss = (back.at(there) - t).abs();
        prop_assert!(miss <= 1e-14, "{miss:e} at {t}");
        prop_assert!((map.at(back.at(t)) - t).abs() <= 1e-14);
        prop_assert!((map.rate(t) * back.rate(there) - 1.0).abs() < 1e-12);
    }

    /// Strictly increasing, inside the anchors of its interval, slopes within their bounds.
    #[test]
    fn strictly_increasing((anchors, _) in gentle()) {
        let map = map(&anchors);
        let (from, until) = (anchors[0].0, anchors[anchors.len() - 1].0);
        let mut before = map.at(from);
        for i in 1..=300 {
            let t = from + (until - from) * f64::from(i) / 300.0;
            let now = map.at(t);
            prop_assert!(now > before, "{t}");
            prop_assert!((LEAST_SLOPE..=MOST_SLOPE).contains(&map.rate(t)));
            before = now;
        }
    }
}

#[test]
fn retimed_clips_follow_their_anchors() {
    let clip = clip();
    for (anchors, frames) in [
        (vec![(0.0, 0.0), (4.0, 6.0)], 301),
        (vec![(1.0, 1.0), (2.0, 2.5)], 226),
        (vec![(1.0, 1.0), (2.0, 1.75)], 189), // 3.75 s are 187.5 steps: the last frame comes half a step later
    ] {
        let map = map(&anchors);
        let out = map.retime(&clip);
        assert_eq!((out.frames(), out.rate_hz), (frames, 50.0));
        assert_eq!(out.pose(0), clip.pose(0));
        assert_eq!(out.pose(frames - 1), clip.pose(200));
        // anchors that lie on frames are those frames, to the bit
        for (from, to) in anchors.iter().filter(|(_, to)| (to * 50.0).fract() == 0.0) {
            assert_eq!(out.pose((to * 50.0) as usize), clip.pose((from * 50.0) as usize), "{from}");
        }
    }
}

/// The hinge turns at constant speed; retimed it turns at that speed divided by the slope. At 1000 Hz central
/// differences differ from the derivative by 2.1e-3 of it at most (seen), where an anchor lies.
#[test]
fn velocities_scale_with_the_slope() {
    let (clip, map) = (clip().resample(1000.0), map(&LATE));
    let (out, back) = (map.retime(&clip), map.inverse());
    let q = |f: usize| out.pose(f)[out.skeleton.q_at(2)];
    let mut slowest = f64::INFINITY;
    for f in 1..out.frames() - 1 {
        let speed = (q(f + 1) - q(f - 1)) * 0.5 * out.rate_hz;
        let slope = map.rate(back.at(f as f64 / out.rate_hz));
        assert!((speed * slope / SPEED - 1.0).abs() < 4e-3, "frame {f}: {speed} {slope}");
        slowest = slowest.min(speed);
    }
    assert!(slowest < 0.5 * SPEED, "{slowest}"); // it was retimed
}

/// There and back: what slerp between frames does not restore, at 50 Hz. 1.6e-4 rad or m seen.
#[test]
fn back_from_a_retiming() {
    let (clip, map) = (clip(), map(&LATE));
    let again = map.inverse().retime(&map.retime(&clip));
    assert_eq!(again.frames(), clip.frames());
    let residue = apart(&clip, &again);
    assert!(residue < 3e-4, "{residue}");
    assert!(apart(&clip, &map.retime(&clip)) > 0.05);
}

#[test]
fn a_beginning_that_moves_is_held_or_cut() {
    let clip = clip();
    let later = map(&[(1.0, 1.5), (2.0, 2.0)]).retime(&clip);
    assert_eq!(later.frames(), clip.frames());
    for f in 0..=25 {
        assert_eq!(later.pose(f), clip.pose(0), "{f}");
    }
    assert_eq!(later.pose(75), clip.pose(50));
    let earlier = map(&[(1.0, 0.5), (2.0, 2.0)]).retime(&clip);
    assert_eq!((earlier.pose(0), earlier.pose(25)), (clip.pose(25), clip.pose(50)));
}

#[test]
fn refusals_say_what_was_found_and_what_is_allowed() {
    let words = |anchors: &[(f64, f64)]| TimeMap::new(anchors).unwrap_err().to_string();
    assert_eq!(words(&[]), "a time map has 0 anchors; it needs at least 2");
    assert_eq!(words(&[(0.0, 0.0)]), "a time map has 1 anchors; it needs at least 2");
    assert_eq!(words(&[(0.0, 0.0), (1.0, f64::NAN)]), "anchor 1 goes from 1 s to NaN s; both must be finite");
    let order = "both times must increase by at least 0.000001 s";
    assert_eq!(
        words(&[(0.0, 0.0), (1.0, 2.0), (2.0, 1.5)]),
        format!("anchor 2 goes from 2 s to 1.5 s, the one before from 1 s to 2 s; {order}")
    );
    assert_eq!(
        words(&[(0.0, 0.0), (0.0, 1.0)]),
        format!("anchor 1 goes from 0 s to 1 s, the one before from 0 s to 0 s; {order}")
    );
    let allowed = "allowed: 0.05 (20 times as fast) to 20 (20 times as slow)";
    assert_eq!(
        words(&[(0.0, 0.0), (1.0, 1.0), (2.0, 31.0)]),
        format!("between the anchors at 1 s and 2 s the time map has slope 44.267; {allowed}")
    );
    let fast = TimeMap::with_ends(&[(0.0, 0.0), (1.0, 0.01)], [End::Free; 2]).unwrap_err().to_string();
    assert_eq!(fast, format!("between the anchors at 0 s and 1 s the time map has slope 0.010; {allowed}"));
}
