//! Treads: the ways of feet that stand where a plan says, and roll without slipping.
//!
//! In: a clip, the soles of its feet, a [`ContactPlan`] that names them. Out: for every sole `world_from_link` in every frame.
//!
//! Captured feet hover, sink, creep and are tilted by what was guessed of their soles. A tread changes as little of them as
//! makes them feet that stand:
//!
//! 1. The tilt that a sole has on average where it lies flat is the guess's, and taken back everywhere; tilts below
//!    [`LEVEL`] on the ground are none, those above [`ROLLED`] stay: a heel that strikes and a heel that rises do so.
//! 2. While it stands, its lowest corner is on the ground, and it rolls: the corners that bear it do not move. Corners
//!    bear by how low they are, [`BEARS_M`].
//! 3. Where it lies flat it lies at the place that the plan has for it; without one, where it was.
//! 4. Between two contacts the correction goes from one to the next, and leaves and arrives as fast as it was.
//!
//! Headings are kept, but for what the plan's place turns. Units: m, rad, s; world frame, y up.

use std::ops::Range;

use crate::contacts::{corner_paths, flat_part};
use crate::rotation::{between, exp, log};
use crate::stance::{normal, place};
use crate::{Clip, ContactPlan, Kinematics, Quat, Sole, Transform, Vec3, smoothstep};

/// A sole on the ground tilted by less is level, rad.
pub const LEVEL: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// A sole tilted by more than this keeps its tilt, rad; a mean tilt beyond it is no error of a guess.
pub const ROLLED: f64 = 15.0 * std::f64::consts::PI / 180.0;
/// A corner so much higher than the lowest bears 1/e as much, m.
pub const BEARS_M: f64 = 0.005;
/// Over this time a correction leaves the ground and comes to it, s.
const LEAVES_S: f64 = 0.1;

/// The way of a sole.
#[derive(Clone, Debug, PartialEq)]
pub struct Tread {
    /// `world_from_link`, frame by frame.
    pub way: Vec<Transform>,
    /// Frames in which it lies flat on the ground, contact by contact; none of a sole that never stands.
    pub flat: Vec<Range<usize>>,
    /// How far it was moved where it lies flat, on average, m.
    pub moved: Vec3,
}

/// The ways of `soles`, in their order. See the module header. `ground_m`: the height of
/// contacts without a place. A sole that never stands goes as it went.
pub fn treads(clip: &Clip, soles: &[Sole], plan: &ContactPlan, ground_m: f64) -> Vec<Tread> {
    soles.iter().map(|sole| tread(clip, sole, plan, ground_m)).collect()
}

/// A contact on the way of a sole.
struct Stand {
    frames: Range<usize>,
    /// Correction of the sole's middle in each of its frames.
    by: Vec<Vec3>,
    /// Turn about the vertical.
    yaw: f64,
}

fn tread(clip: &Clip, sole: &Sole, plan: &ContactPlan, ground_m: f64) -> Tread {
    let (frames, rate_hz) = (clip.frames(), clip.rate_hz);
    let world: Vec<Transform> =
        (0..frames).map(|f| Kinematics::new(&clip.skeleton, clip.pose(f)).world[sole.link]).collect();
    let spans: Vec<(Range<usize>, Option<Transform>)> = plan
        .of(&sole.name)
        .map(|c| (c.frames(rate_hz, frames), c.world_from_point))
        .filter(|(span, _)| !span.is_empty())
        .collect();
    let shape = Shape::of(clip, sole);
    if spans.is_empty() || shape.corners.is_empty() {
        return Tread { way: world, flat: Vec::new(), moved: Vec3::zeros() };
    }
    let paths = corner_paths(clip, std::slice::from_ref(sole)).remove(0);
    let flats: Vec<Range<usize>> = spans.iter().map(|(span, _)| flat_part(&paths, span.clone())).collect();
    let turns = shape.turns(&world, &spans, &flats, rate_hz);
    let middles: Vec<Vec3> = world.iter().map(|w| w.transform_point(&shape.center.into()).coords).collect();
    let stand = |((span, given), flat): (&(Range<usize>, Option<Transform>), &Range<usize>)| {
        let now = place(clip, sole, flat.clone(), ground_m);
        let target = given.unwrap_or(now);
        let ahead = log(&(target.rotation * now.rotation.inverse()));
        let yaw = Quat::from_axis_angle(&Vec3::y_axis(), ahead.y);
        let arms = |f: usize| -> Vec<Vec3> {
            shape.corners.iter().map(|c| yaw * (turns[f] * (c - shape.center))).collect()
        };
        let floor = |c: &Vec3| target.transform_point(&(*c).into()).y;
        let floor = shape.corners.iter().map(floor).fold(f64::INFINITY, f64::min);
        // the middle such that the bearing corners stay
        let mut by = Vec::with_capacity(span.len());
        let mut at = Vec3::zeros();
        let mut before: Option<Vec<Vec3>> = None;
        for f in span.clone() {
            let arms = arms(f);
            let low = arms.iter().map(|a| a.y).fold(f64::INFINITY, f64::min);
            if let Some(before) = &before {
                let bears = |a: &Vec3| (-(a.y - low) / BEARS_M).exp();
                let all: f64 = arms.iter().map(bears).sum();
                let moved: Vec3 =
                    arms.iter().zip(before).map(|(now, then)| (now - then) * (bears(now) / all)).sum();
                at -= moved;
            }
            at.y = floor - low;
            by.push(at);
            before = Some(arms);
        }
        let lies = |f: usize| by[f - span.start];
        let mean = flat.clone().map(lies).sum::<Vec3>() / flat.len().max(1) as f64;
        let goes = target.transform_point(&shape.center.into()).coords - mean;
        for (f, at) in span.clone().zip(&mut by) {
            *at += Vec3::new(goes.x, 0.0, goes.z) - middles[f];
        }
        Stand { frames: span.clone(), by, yaw: ahead.y }
    };
    let stands: Vec<Stand> = spans.iter().zip(&flats).map(stand).collect();
    let way: Vec<Transform> = (0..frames)
        .map(|f| {
            let (by, yaw) = correction(&stands, f, rate_hz);
            let turn = Quat::from_axis_angle(&Vec3::y_axis(), yaw) * turns[f];
            let mut middle = middles[f] + by;
            // a swinging sole stays out of the ground
            let low =
                shape.corners.iter().map(|c| (turn * (c - shape.center)).y).fold(f64::INFINITY, f64::min);
            let floor = ground_m.min(lowest_of(&spans, &shape.corners));
            middle.y += (floor - low - middle.y).max(0.0);
            Transform::from_parts((middle - turn * shape.center).into(), turn)
        })
        .collect();
    let moved = |f: usize| way[f].transform_point(&shape.center.into()).coords - middles[f];
    let lies: Vec<Vec3> = flats.iter().cloned().flatten().map(moved).collect();
    let moved = lies.iter().sum::<Vec3>() / lies.len().max(1) as f64;
    Tread { way, flat: flats, moved }
}

/// The lowest height of a place, m.
fn lowest_of(spans: &[(Range<usize>, Option<Transform>)], corners: &[Vec3]) -> f64 {
    let places = spans.iter().filter_map(|(_, place)| *place);
    let heights = places.flat_map(|p| corners.iter().map(move |c| p.transform_point(&(*c).into()).y));
    heights.fold(f64::INFINITY, f64::min)
}

/// Correction of a sole's middle and heading in a frame: that of its contact, or between two.
fn correction(stands: &[Stand], f: usize, rate_hz: f64) -> (Vec3, f64) {
    if let Some(stand) = stands.iter().find(|s| s.frames.contains(&f)) {
        return (stand.by[f - stand.frames.start], stand.yaw);
    }
    let before = stands.iter().rev().find(|s| s.frames.end <= f);
    let after = stands.iter().find(|s| s.frames.start > f);
    let rate = |from: Vec3, to: Vec3| (to - from) * rate_hz;
    let left = before.map(|s| {
        let n = s.by.len();
        let slope = if n > 1 { rate(s.by[n - 2], s.by[n - 1]) } else { Vec3::zeros() };
        (s.frames.end - 1, s.by[n - 1], slope, s.yaw)
    });
    let right = after.map(|s| {
        let slope = if s.by.len() > 1 { rate(s.by[0], s.by[1]) } else { Vec3::zeros() };
        (s.frames.start, s.by[0], slope, s.yaw)
    });
    let fading = |slope: Vec3, from: usize, most_s: f64| {
        let t = f.abs_diff(from) as f64 / rate_hz;
        let u = (t / most_s).min(1.0);
        slope * (t * (1.0 - u) * (1.0 - u))
    };
    match (left, right) {
        (Some(l), Some(r)) => {
            let air_s = (r.0 - l.0) as f64 / rate_hz;
            let u = smoothstep((f - l.0) as f64 / (r.0 - l.0) as f64);
            let most = LEAVES_S.min(0.5 * air_s);
            let ends = fading(l.2, l.0, most) - fading(r.2, r.0, most);
            (l.1 + (r.1 - l.1) * u + ends, l.3 + (r.3 - l.3) * u)
        }
        (Some(l), None) => (l.1 + fading(l.2, l.0, LEAVES_S), l.3),
        (None, Some(r)) => (r.1 - fading(r.2, r.0, LEAVES_S), r.3),
        (None, None) => (Vec3::zeros(), 0.0),
    }
}

/// The corners of a sole in its link's frame.
struct Shape {
    corners: Vec<Vec3>,
    center: Vec3,
    normal: Option<Vec3>,
}

impl Shape {
    fn of(clip: &Clip, sole: &Sole) -> Self {
        let corners = sole.in_link(&Kinematics::new(&clip.skeleton, clip.pose(0)));
        let center = corners.iter().sum::<Vec3>() / corners.len().max(1) as f64;
        let normal = if corners.len() > 2 { normal(&corners) } else { None };
        Self { corners, center, normal }
    }

    /// Rotations of the link, without the tilt of a guess, level where nearly level on the ground.
    fn turns(
        &self,
        world: &[Transform],
        spans: &[(Range<usize>, Option<Transform>)],
        flats: &[Range<usize>],
        rate_hz: f64,
    ) -> Vec<Quat> {
        let captured = || world.iter().map(|w| w.rotation).collect::<Vec<Quat>>();
        let Some(normal) = self.normal else { return captured() };
        let ups = flats.iter().cloned().flatten().map(|f| world[f].rotation.inverse() * Vec3::y());
        let Some(up) = ups.sum::<Vec3>().try_normalize(1e-9) else { return captured() };
        let normal = if normal.dot(&up) < 0.0 { -normal } else { normal };
        let back = between(&normal, &up);
        let back = if back.angle() < ROLLED { back } else { Quat::identity() };
        let near = (LEAVES_S * rate_hz).max(1.0);
        let on = |f: usize| {
            let off = spans.iter().map(|(s, _)| s.start.saturating_sub(f).max((f + 1).saturating_sub(s.end)));
            off.min().map_or(0.0, |off| 1.0 - smoothstep((off as f64 / near).min(1.0)))
        };
        (0..world.len())
            .map(|f| {
                let turn = world[f].rotation * back;
                let tilt = between(&(turn * normal), &Vec3::y());
                let angle = tilt.angle();
                let rolled = smoothstep(((angle - LEVEL) / (ROLLED - LEVEL)).clamp(0.0, 1.0));
                exp(&(log(&tilt) * ((1.0 - rolled) * on(f)))) * turn
            })
            .collect()
    }
}
