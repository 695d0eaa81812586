//! Torques of joints: about each axis, with their signs.

use dynamics::Trace;
use motion::rotation::exp;
use motion::{Clip, Vec3};
use plots::figure::Mark;
use plots::style::{BLUE, Color, GREEN, INK, VERMILION};
use plots::{Excerpt, Figure, joint_torques};

use crate::sample;

/// A second in the rest pose, one link turned, without any torque.
fn still(link: &str, turn: Vec3) -> (Trace, usize) {
    let character = sample::human();
    let skeleton = &character.skeleton;
    let at = skeleton.link(link).unwrap();
    let mut q = character.rest.clone();
    if turn != Vec3::zeros() {
        skeleton.set_rotation(&mut q, at, &exp(&turn));
    }
    let mut trace = sample::trace(&character, &Clip::new(skeleton.clone(), 120.0, q.repeat(121)));
    trace.torque.fill(0.0);
    (trace, at)
}

fn set(data: &mut [f64], trace: (usize, usize), values: impl Fn(usize) -> Vec<f64>) {
    let (nv, at) = trace;
    for (row, cells) in data.chunks_exact_mut(nv).enumerate() {
        let values = values(row);
        cells[at..at + values.len()].copy_from_slice(&values);
    }
}

fn of(trace: &Trace, link: usize) -> Figure {
    joint_torques(Excerpt::whole(trace).of_joints(vec![link]), &[], "")
}

/// Heights of the corners of the curve of a colour, px down the page.
fn curve(figure: &Figure, color: Color) -> Vec<f64> {
    let long = |m: &&Mark| {
        let [left, _, right, _] = Figure::bounds(m);
        matches!(m, Mark::Line { color: c, .. } if *c == color) && right - left > 200.0
    };
    let curves: Vec<&Mark> = figure.marks.iter().filter(long).collect();
    match curves[..] {
        [Mark::Line { points, .. }] => points.iter().map(|p| p[1]).collect(),
        _ => panic!("{} curves of {color:?}", curves.len()),
    }
}

/// The words in the colour of a curve.
fn tag(figure: &Figure, color: Color) -> Vec<String> {
    let words = figure.marks.iter().filter_map(|m| match m {
        Mark::Text { text, color: c, .. } if *c == color.mix(INK, 0.15) => Some(text.clone()),
        _ => None,
    });
    words.collect()
}

/// A ball has a curve for each of its axes, named, each with the sign of the torque about it: the twist about the axis as the
/// swing turned it.
#[test]
fn torques_of_a_ball_are_drawn_about_each_axis() {
    let torque = Vec3::new(10.0, -4.0, -20.0);
    let swing = -0.5_f64;
    // its axes are x, z and −y; the swing about x turns −y to (0, −cos, −sin)
    let twisted = torque.dot(&Vec3::new(0.0, -swing.cos(), -swing.sin()));
    for (turn, asked) in [(0.0, [10.0, -20.0, 4.0]), (swing, [10.0, -20.0, twisted])] {
        let (mut trace, link) = still("arm_l", Vec3::new(turn, 0.0, 0.0));
        let cells = (trace.character.skeleton.nv(), trace.character.skeleton.v_at(link));
        set(&mut trace.torque, cells, |_| torque.as_slice().to_vec());
        let figure = of(&trace, link);
        let heights = [BLUE, VERMILION, GREEN].map(|color| {
            let all = curve(&figure, color);
            assert!(all.iter().all(|y| (y - all[0]).abs() < 1e-9), "constant torques are level");
            all[0]
        });
        // px per N·m by the first pair, the others by it; up is positive
        let scale = (heights[1] - heights[0]) / (asked[0] - asked[1]);
        assert!(scale > 0.5, "{heights:?}");
        let third = asked[0] - (heights[2] - heights[0]) / scale;
        assert!((third - asked[2]).abs() < 1e-6, "turned by {turn}: {third} for {}", asked[2]);
        let names = [BLUE, VERMILION, GREEN].map(|color| tag(&figure, color));
        assert_eq!(names, [["swing x"], ["swing z"], ["twist −y"]].map(|n| n.map(String::from).to_vec()));
        // the largest about an axis, not the length of (10, −4, −20), which is 22.7
        let title = |m: &Mark| matches!(m, Mark::Text { text, .. } if text.starts_with("arm_l · 20.0 N·m, "));
        assert!(figure.marks.iter().any(title));
    }
}

/// The torque of a hinge keeps its sign through zero: 10, 0 and −30 N·m go down the page in steps of one to three.
#[test]
fn torques_of_a_hinge_have_signs() {
    let (mut trace, link) = still("forearm_l", Vec3::zeros());
    let cells = (trace.character.skeleton.nv(), trace.character.skeleton.v_at(link));
    let at = |row: usize| [10.0, 0.0, -30.0][(row / 41).min(2)];
    set(&mut trace.torque, cells, |row| vec![at(row)]);
    let figure = of(&trace, link);
    let heights = curve(&figure, BLUE);
    let (first, last) = (heights[0], heights[heights.len() - 1]);
    assert!(heights.windows(2).all(|w| w[1] >= w[0] - 1e-9) && last - first > 50.0, "{heights:?}");
    let zero = first + 0.25 * (last - first);
    assert!(heights.iter().any(|y| (y - zero).abs() < 1e-6), "{heights:?}");
    assert!(tag(&figure, BLUE).is_empty(), "one axis needs no name");
}

/// The torque of the stops is drawn about the axis it acts about, thinner, and about no other.
#[test]
fn stops_are_drawn_about_their_axis() {
    let (mut trace, link) = still("arm_l", Vec3::zeros());
    let cells = (trace.character.skeleton.nv(), trace.character.skeleton.v_at(link));
    set(&mut trace.torque, cells, |_| vec![10.0, 0.0, -20.0]);
    // z is the second axis
    set(&mut trace.stop_torque, cells, |_| vec![0.0, 0.0, 15.0]);
    let figure = of(&trace, link);
    let dashes: Vec<(Color, f64)> = (figure.marks.iter())
        .filter_map(|m| match m {
            Mark::Line { points, color, width } if *width == 1.2 => Some((*color, points[0][1])),
            _ => None,
        })
        .collect();
    assert!(dashes.len() > 5 && dashes.iter().all(|d| d.0 == VERMILION), "{dashes:?}");
    let [ten, minus_twenty] = [BLUE, VERMILION].map(|color| curve(&figure, color)[0]);
    let fifteen = ten - (minus_twenty - ten) / 6.0;
    assert!(dashes.iter().all(|d| (d.1 - fifteen).abs() < 1e-6), "{fifteen}: {dashes:?}");
}
