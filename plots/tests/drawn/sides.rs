//! From which side a strip is seen: that of the body, wherever it stands and turns to.

use motion::{Clip, Vec3};
use nalgebra::UnitQuaternion;
use plots::figure::Mark;
use plots::{StripOptions, StripRow, View, film_strip_with};

use super::around;
use crate::sample;

/// The rectangle around what is filled on a strip of the same pose, the right arm raised, turned about the vertical and put
/// elsewhere.
fn seen(turn_deg: f64, view_deg: f64) -> [f64; 4] {
    let character = sample::human();
    let s = &character.skeleton;
    let mut q = character.rest.clone();
    let arm = s.link("arm_r").or_else(|| s.link("upper_arm_r")).expect("an arm");
    let raise = UnitQuaternion::from_axis_angle(&Vec3::z_axis(), -1.2);
    q[s.q_at(arm)..s.q_at(arm) + 4].copy_from_slice(&[raise.w, raise.i, raise.j, raise.k]);
    let turn = UnitQuaternion::from_axis_angle(&Vec3::y_axis(), turn_deg.to_radians());
    let at = turn * Vec3::new(q[0], q[1], q[2]) + Vec3::new(3.0, 0.0, -2.0) * (turn_deg / 90.0);
    let r = turn * UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(q[3], q[4], q[5], q[6]));
    q[..7].copy_from_slice(&[at.x, at.y, at.z, r.w, r.i, r.j, r.k]);
    let clip = Clip::new(s.clone(), 120.0, q.repeat(3));
    let options =
        StripOptions { count: 1, view: View::degrees(view_deg).unwrap(), ..StripOptions::default() };
    let marks = film_strip_with(&[StripRow::new("run", &clip)], &character, "", &options).marks;
    // the floor and the page are wider than a body
    let body = |m: &Mark| {
        let [left, _, right, _] = plots::Figure::bounds(m);
        matches!(m, Mark::Fill { .. }) && right - left < 300.0
    };
    around(&marks.into_iter().filter(body).collect::<Vec<_>>())
}

/// A clip of a body that faces anywhere and a scene whose body faces +z are drawn from the same side of the body.
#[test]
fn strips_are_seen_from_a_side_of_the_body() {
    for view in [0.0, 90.0, 38.0] {
        let home = seen(0.0, view);
        for turn in [90.0, 180.0, -135.0] {
            let there = seen(turn, view);
            for (a, b) in home.iter().zip(there) {
                assert!((a - b).abs() < 1.5, "{view}° of a body turned by {turn}°: {home:?} {there:?}");
            }
        }
    }
    // and the views are not all alike: the raised arm is seen from the front only
    let [front, side] = [seen(0.0, 0.0), seen(0.0, 90.0)];
    assert!(front[2] - front[0] > 1.3 * (side[2] - side[0]), "{front:?} {side:?}");
}
