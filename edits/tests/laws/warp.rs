//! Laws of the warp: identity, length, spans, contacts, the way back, velocities, refusals.

use edits::{EditLog, Warp, Where};
use motion::TimeMap;

use crate::clip_body::{RATE_HZ, WALK, apart, danced, edited, refused, strays};

fn warp(anchors: &[(f64, f64)]) -> Warp {
    Warp { anchors: anchors.to_vec() }
}

/// A dwell: what was at 1.5 s comes at 2.2 s, and from 3 s on all is half a second late.
const DWELL: [(f64, f64); 3] = [(1.0, 1.0), (1.5, 2.2), (3.0, 3.5)];

#[test]
fn identity_to_the_bit() {
    for motion in [&*WALK, &danced()] {
        for anchors in [&[(1.0, 1.0), (1.7, 1.7)][..], &[(0.5, 0.5)], &[(0.0, 0.0), (0.1, 0.1), (1.9, 1.9)]] {
            for at in [Where::default(), Where::span(0.0, 2.0)] {
                let (edited, log) = edited(&warp(anchors), motion, &at);
                // Debug prints every bit of every number
                assert_eq!(format!("{:?}", edited.clip), format!("{:?}", motion.clip));
                assert_eq!((&edited.contacts, edited.times), (&motion.contacts, TimeMap::identity()));
                assert!(log.clip_changes().is_empty() && log.notes().is_empty());
            }
        }
    }
}

#[test]
fn length_follows_the_anchors() {
    for (anchors, end_s) in [
        (&DWELL[..], 4.5),
        (&[(0.0, 0.0), (4.0, 6.0)], 6.0),
        (&[(2.0, 1.5)], 3.5),
        (&[(1.0, 1.0), (2.0, 2.4), (4.0, 3.0)], 3.0),
    ] {
        let (edited, log) = edited(&warp(anchors), &WALK, &Where::default());
        assert_eq!(edited.clip.duration_s(), end_s);
        assert_eq!(edited.times.at(4.0), end_s);
        assert_eq!(log.clip_changes()[0].lengths_s, (4.0, end_s));
        let last = edited.clip.frames() - 1;
        assert_eq!((edited.clip.pose(0), edited.clip.pose(last)), (WALK.clip.pose(0), WALK.clip.pose(200)));
    }
}

/// Before the first anchor nothing changes to the bit, after the last all is shifted, to the bit where the shift is a
/// whole number of frames.
#[test]
fn what_is_outside_is_only_shifted() {
    for at in [Where::default(), Where::span(1.0, 3.0), Where::span(0.4, 3.6)] {
        let (edited, log) = edited(&warp(&DWELL), &WALK, &at);
        let same = |f: usize, shift: usize| assert_eq!(edited.clip.pose(f + shift), WALK.clip.pose(f), "{f}");
        (0..=50).for_each(|f| same(f, 0));
        same(75, 35);
        (150..=200).for_each(|f| same(f, 25));
        let change = &log.clip_changes()[0];
        assert_eq!((change.from_s, change.to_s), (1.02, 3.48));
        assert!(log.notes().is_empty(), "{log}"); // slopes are continuous
    }
}

/// Where the first anchor is moved, what is between it and the beginning of the span is stretched; the span decides
/// where that is.
#[test]
fn the_beginning_of_the_span_stays() {
    let late = warp(&[(2.0, 2.5), (3.0, 3.0)]);
    let (whole, _) = edited(&late, &WALK, &Where::default());
    let (part, log) = edited(&late, &WALK, &Where::span(1.0, 3.0));
    for (edited, stays_s) in [(&whole, 0.0), (&part, 1.0)] {
        assert_eq!(
            (edited.times.at(stays_s), edited.times.at(2.0), edited.times.at(3.5)),
            (stays_s, 2.5, 3.5)
        );
    }
    assert!(whole.times.at(0.5) > 0.55);
    (0..=50).for_each(|f| assert_eq!(part.clip.pose(f), WALK.clip.pose(f), "{f}"));
    assert!(log.notes().is_empty());
}

/// Feet stand where the plan says after the warp as before: to 1e-12 m (seen 4.5e-16). The plan that was not retimed is
/// wrong by decimetres.
#[test]
fn contacts_stand_where_feet_stand() {
    assert!(strays(&WALK.clip, &WALK.contacts) < 1e-12);
    for at in [Where::default(), Where::span(0.8, 3.2)] {
        let (edited, _) = edited(&warp(&DWELL), &WALK, &at);
        assert_eq!(edited.contacts.contacts().len(), WALK.contacts.contacts().len());
        let stray = strays(&edited.clip, &edited.contacts);
        assert!(stray < 1e-12, "{stray}");
        assert!(strays(&edited.clip, &WALK.contacts) > 0.1);
    }
}

/// The inverse map returns the clip, but for what slerp between frames of 50 Hz does not restore: 2.1e-2 rad seen in the
/// dance, whose transitions take a quarter second and are hurried. A uniform warp is undone by its anchors turned round:
/// 8.8e-4 m seen in the walk.
#[test]
fn the_way_back() {
    let dance = danced();
    let there = edited(&warp(&[(0.4, 0.4), (1.0, 1.5), (2.4, 2.6)]), &dance, &Where::default()).0;
    let again = there.times.inverse().retime(&there.clip);
    assert_eq!(again.frames(), dance.clip.frames());
    let residue = apart(&dance.clip, &again);
    assert!(residue < 3e-2, "{residue}");

    let slow = edited(&warp(&[(0.0, 0.0), (4.0, 6.0)]), &WALK, &Where::default()).0;
    let slow = WALK.clone().with(slow);
    let (back, _) = edited(&warp(&[(0.0, 0.0), (6.0, 4.0)]), &slow, &Where::default());
    let residue = apart(&WALK.clip, &back.clip);
    assert!(residue < 2e-3, "{residue}");
    for (a, b) in WALK.contacts.contacts().iter().zip(back.contacts.contacts()) {
        assert!((a.from_s - b.from_s).abs() < 1e-14 && (a.to_s - b.to_s).abs() < 1e-14);
    }
}

/// The root walks at 0.6 m/s. Warped uniformly it walks at that speed divided by the slope.
#[test]
fn velocities_are_divided_by_the_slope() {
    for (to_s, slope) in [(6.0, 1.5), (2.0, 0.5)] {
        let (edited, log) = edited(&warp(&[(0.0, 0.0), (4.0, to_s)]), &WALK, &Where::default());
        let z = |f: usize| edited.clip.skeleton.position(edited.clip.pose(f), 0).z;
        for f in 1..edited.clip.frames() {
            let speed = (z(f) - z(f - 1)) * RATE_HZ;
            assert!((speed - 0.6 / slope).abs() < 1e-12, "{f}: {speed}"); // 4.4e-14 seen
        }
        let (least, most) = log.clip_changes()[0].slopes.unwrap();
        assert!((least - slope).abs() < 1e-14 && (most - slope).abs() < 1e-14);
    }
}

/// An interval at the outside that runs more than twice as fast leaves a jump, and the log says so.
#[test]
fn jumps_of_the_slope_are_noted() {
    let (_, log) = edited(&warp(&[(1.0, 1.0), (2.0, 1.3)]), &WALK, &Where::default());
    let notes: Vec<&str> = log.notes().iter().map(|(_, text)| text.as_str()).collect();
    assert_eq!(
        notes,
        [
            "the slope of time jumps between 1 and 0.600 at the anchor at 1.000 s",
            "the slope of time jumps between 1 and 0.600 at the anchor at 2.000 s"
        ]
    );
    // at the ends of the clip no motion is outside
    let (_, log) = edited(&warp(&[(0.0, 0.0), (4.0, 1.2)]), &WALK, &Where::default());
    assert!(log.notes().is_empty());
}

/// Warps are chained: times of the second are those of the clip after the first, labels follow.
#[test]
fn a_second_warp_sees_the_first() {
    let dance = danced();
    let mut log = EditLog::default();
    let first = edits::ClipEdit::apply(&warp(&[(0.5, 0.5), (1.0, 1.6)]), &dance, &Where::default(), &mut log)
        .unwrap();
    let late = dance.clone().with(first);
    let (before, after) =
        (Where::label("wave").in_clip(&dance).unwrap(), Where::label("wave").in_clip(&late).unwrap());
    assert_eq!((before.from_s, after.from_s), (0.5, 0.5));
    assert!((after.to_s - before.to_s - 0.6).abs() < 1e-12);
    let second =
        edits::ClipEdit::apply(&warp(&[(1.6, 1.6), (2.0, 2.3)]), &late, &Where::label("wave"), &mut log)
            .unwrap();
    let end = late.with(second);
    assert!((end.times.at(1.0) - 1.6).abs() < 1e-12);
    assert!((end.times.at(1.4) - 2.3).abs() < 1e-12);
    assert_eq!(end.clip.pose(115), dance.clip.pose(70));
    assert_eq!(log.edits(), ["warp", "warp"]);
}

#[test]
fn refusals_say_what_was_found_and_what_is_allowed() {
    let words = |anchors: &[(f64, f64)], at: Where| refused(&warp(anchors), &WALK, &at);
    let all = Where::default;
    assert_eq!(
        words(&DWELL, Where::default().of(["foot_l", "pelvis"])),
        "warp: applies to the whole body; found `parts`: foot_l, pelvis; leave them out"
    );
    assert_eq!(words(&[], all()), "warp: a time map has 0 anchors; it needs at least 2");
    assert_eq!(
        words(&[(1.0, 1.0), (4.5, 5.0)], all()),
        "warp: anchor 1 is at 4.5 s; allowed: 0.000 s to 4.000 s, the span of the edit"
    );
    assert_eq!(
        words(&[(0.9, 1.0), (2.0, 2.0)], Where::span(1.0, 3.0)),
        "warp: anchor 0 is at 0.9 s; allowed: 1.000 s to 3.000 s, the span of the edit"
    );
    assert_eq!(
        words(&[(1.0, 1.2), (2.0, 2.0)], Where::span(1.0, 3.0)),
        "warp: the first anchor moves 1.000 s, the beginning of the span, to 1.2 s; it must stay, as what is before it does"
    );
    // anchors are counted as written, though the beginning was put before them
    assert_eq!(
        words(&[(1.0, 1.5), (2.0, 1.4)], all()),
        "warp: anchor 1 goes from 2 s to 1.4 s, the one before from 1 s to 1.5 s; both times must increase by at least 0.000001 s"
    );
    assert_eq!(
        words(&[(1.0, 1.0), (2.0, f64::INFINITY)], all()),
        "warp: anchor 1 goes from 2 s to inf s; both must be finite"
    );
    assert_eq!(
        words(&[(0.0, 0.0), (4.0, 100.0)], all()),
        "warp: between the anchors at 0 s and 4 s the time map has slope 25.000; allowed: 0.05 (20 times as fast) to 20 (20 times as slow)"
    );
}
