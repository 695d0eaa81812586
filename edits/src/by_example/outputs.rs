//! What is predicted: how a target differs from its source, frame by frame.
//!
//! In: two clips of one rig with the same frames, and when the target's frames come. Out: one row of differences a frame, zero
//! where the target is the source; and back: a source with differences is a target.
//!
//! | columns | meaning | unit |
//! |---|---|---|
//! | joints, in the rig's order | `Sᵀ log(R_tgt R_srcᵀ)` in body axes of the zero pose; the difference of a hinge or slide | rad, sizes |
//! | tilt, 3 | `log(T_srcᵀ T_tgt)` of the root's orientation without its heading, body axes | rad |
//! | height | height of the root | sizes |
//! | sideways, forward | speed of the root, each in the heading frame of its own clip | sizes per s |
//! | turn | rate of the heading | rad/s |
//! | time | `ln(seconds of the target / seconds of the source)` | – |
//!
//! S is one with [`Axes::Parent`]; with [`Axes::Joint`] it is the mean of R_src over 0.125 s (fewer frames at the ends of a clip): with `S = R_src` the first is `log(R_srcᵀ R_tgt)`. What trembles in the source (mocap: twist of an upper arm)
//! would then turn the axes of the edit, and swing an arm that the edit has raised; so it stays a twist.
//!
//! Rotation vectors are continued over ±π from frame to frame. Speeds and rates are of source time and belong to the step
//! from a frame to the next; the last frame has those of the step before it. Lengths are in sizes of the own skeleton of each, so that
//! a pair may be of two bodies of one rig.

use std::f64::consts::TAU;
use std::sync::Arc;

use motion::rotation::{Quat, Vec3, exp, log};
use motion::{Clip, Joint, Skeleton};
use nalgebra::DMatrix;

use super::features::headings;
use super::rig::{Axes, Moves, Rig, RigFile, Signed};

/// Columns after those of the joints.
pub(super) const ROOT: usize = 8;
/// Among them: first of the tilt, height, sideways, forward, turn, time.
pub(super) const TILT: usize = 0;
pub(super) const HEIGHT: usize = 3;
const SIDEWAYS: usize = 4;
const FORWARD: usize = 5;
const TURN: usize = 6;
pub(super) const TIME: usize = 7;

/// Number of columns.
pub fn width(rig: &Rig) -> usize {
    joints_width(rig) + ROOT
}

pub(super) fn joints_width(rig: &Rig) -> usize {
    rig.joints().iter().map(|(_, m)| m.width()).sum()
}

/// Where the root's tilt and height are among the columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RootColumns {
    /// First of three.
    pub tilt: usize,
    pub height: usize,
}

/// Columns of the root that are no steps.
pub(super) fn root_columns(rig: &Rig) -> RootColumns {
    let root = joints_width(rig);
    RootColumns { tilt: root + TILT, height: root + HEIGHT }
}

/// Column of the logarithm of the ratio of times.
pub fn time_column(rig: &Rig) -> usize {
    joints_width(rig) + TIME
}

/// Columns that are differences of poses one frame apart: sideways, forward, turn.
pub(super) fn rates(rig: &Rig) -> std::ops::Range<usize> {
    joints_width(rig) + SIDEWAYS..joints_width(rig) + TURN + 1
}

/// Columns of a joint's difference; `None` of a joint that is not predicted.
///
/// A ball has three, the rotation vector in body axes (x lateral, y up); a hinge or slide one.
pub fn joint_columns(rig: &RigFile, joint: &str) -> Option<std::ops::Range<usize>> {
    named_columns(rig, "").into_iter().find(|(_, name)| name == joint).map(|(columns, _)| columns)
}

/// Columns and names of all joints of a rig, in its order, then of the lean of the root.
pub(super) fn named_columns(rig: &RigFile, root: &str) -> Vec<(std::ops::Range<usize>, String)> {
    let mut at = 0;
    let mut out = Vec::new();
    for (name, moves) in &rig.joints {
        out.push((at..at + moves.width(), name.clone()));
        at += moves.width();
    }
    out.push((at + TILT..at + TILT + 3, root.into()));
    out
}

/// How rows are mirrored; `None` without left and right.
pub(super) fn mirror(rig: &Rig) -> Option<Signed> {
    let mut out = rig.mirror_joints()?;
    let at = out.len();
    let signs = [1.0, -1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0];
    out.extend(signs.iter().enumerate().map(|(i, s)| (at + i, *s)));
    Some(out)
}

/// Differences of all frames. `source` and `target` are clips of the rigs beside them, of the same number of frames; `times_s` are
/// the times of the target's frames, those of the source where there are none.
///
/// # Panics
/// If the numbers of frames differ.
pub fn differences(source: (&Rig, &Clip), target: (&Rig, &Clip), times_s: Option<&[f64]>) -> DMatrix<f64> {
    let ((rig, from), (other, to)) = (source, target);
    let frames = from.frames();
    assert_eq!(frames, to.frames(), "frames of a pair");
    let mut out = DMatrix::zeros(frames, width(rig));
    let root = joints_width(rig);
    let paths = [Path::of(rig, from), Path::of(other, to)];
    let smooth = Smooth::of(rig, from);
    for f in 0..frames {
        let (a, b) = (from.pose(f), to.pose(f));
        let mut column = 0;
        for (joint, (&(i, moves), &(j, _))) in rig.joints().iter().zip(other.joints()).enumerate() {
            match moves {
                Moves::Ball => {
                    let turn = other.skeleton().rotation(b, j) * rig.skeleton().rotation(a, i).inverse();
                    let turn = smooth.at(f, joint).inverse() * log(&turn);
                    write3(&mut out, f, column, &(rig.axes_from_link(i) * turn));
                }
                Moves::Axis => out[(f, column)] = axis(other, b, j) - axis(rig, a, i),
            }
            column += moves.width();
        }
        let tilt = paths[0].tilts[f].inverse() * paths[1].tilts[f];
        write3(&mut out, f, root + TILT, &log(&tilt));
        out[(f, root + HEIGHT)] = paths[1].places[f].y / other.size_m - paths[0].places[f].y / rig.size_m;
        if frames > 1 {
            let step = f.min(frames - 2);
            let (s, t) = (paths[0].rates(step, from.rate_hz), paths[1].rates(step, from.rate_hz));
            out[(f, root + SIDEWAYS)] = t.x / other.size_m - s.x / rig.size_m;
            out[(f, root + FORWARD)] = t.z / other.size_m - s.z / rig.size_m;
            out[(f, root + TURN)] = t.y - s.y;
            out[(f, root + TIME)] = times_s.map_or(0.0, |times| log_step(times, f, from.rate_hz));
        }
    }
    continue_all(rig, &mut out);
    out
}

/// Logarithm of the time from frame `f` to the next over that of the rate; of the step before it at the last frame.
pub(super) fn log_step(times: &[f64], f: usize, rate_hz: f64) -> f64 {
    let Some(last_step) = times.len().checked_sub(2) else { return 0.0 };
    let step = f.min(last_step);
    ((times[step + 1] - times[step]) * rate_hz).ln()
}

/// First columns of the joints that are balls.
pub(super) fn balls(rig: &Rig) -> Vec<usize> {
    let mut column = 0;
    let mut out = Vec::new();
    for (_, moves) in rig.joints() {
        if *moves == Moves::Ball {
            out.push(column);
        }
        column += moves.width();
    }
    out
}

/// Continues the rotation vectors of all joints and of the lean over ±π.
pub(super) fn continue_all(rig: &Rig, out: &mut DMatrix<f64>) {
    balls(rig).into_iter().for_each(|column| continue_over_pi(out, column));
    continue_over_pi(out, joints_width(rig) + TILT);
}

/// The angle of a hinge, or the way of a slide in sizes.
pub(super) fn axis(rig: &Rig, q: &[f64], link: usize) -> f64 {
    let x = q[rig.skeleton().q_at(link)];
    match rig.skeleton().links()[link].joint {
        Joint::Prismatic(_) => x / rig.size_m,
        _ => x,
    }
}

pub(super) fn write3(out: &mut DMatrix<f64>, row: usize, column: usize, v: &Vec3) {
    for c in 0..3 {
        out[(row, column + c)] = v[c];
    }
}

pub(super) fn read3(d: &DMatrix<f64>, row: usize, column: usize) -> Vec3 {
    Vec3::new(d[(row, column)], d[(row, column + 1)], d[(row, column + 2)])
}

/// Chooses among the rotation vectors of one rotation, `v + 2πk v/|v|`, the one nearest to the frame before.
fn continue_over_pi(out: &mut DMatrix<f64>, column: usize) {
    for f in 1..out.nrows() {
        let (before, v) = (read3(out, f - 1, column), read3(out, f, column));
        let angle = v.norm();
        if before.norm() < 0.5 || angle < 1e-9 {
            continue;
        }
        let axis = v / angle;
        let turns = ((before.dot(&axis) - angle) / TAU).round();
        let other = axis * (angle + TAU * turns);
        if turns != 0.0 && (other - before).norm() < (v - before).norm() {
            write3(out, f, column, &other);
        }
    }
}

/// The axes that differences are in: rotations of all joints of a clip, means over 0.125 s (fewer frames at the ends, equally many before and
/// after), or none with [`Axes::Parent`].
#[derive(Clone, Debug)]
pub(super) struct Smooth {
    joints: usize,
    rotations: Vec<Quat>,
}

impl Smooth {
    pub fn of(rig: &Rig, clip: &Clip) -> Self {
        let (s, last) = (rig.skeleton(), clip.frames() - 1);
        let half = (0.5 * super::features::APART_S * clip.rate_hz).round() as usize;
        let mut rotations = Vec::with_capacity(clip.frames() * rig.joints().len());
        for f in 0..clip.frames() {
            let half = half.min(f).min(last - f);
            for &(link, moves) in rig.joints() {
                let own = s.rotation(clip.pose(f), link);
                let mut sum = own.coords;
                if rig.axes() == Axes::Parent {
                    rotations.push(Quat::identity());
                    continue;
                }
                if moves == Moves::Ball {
                    for g in (f - half..=f + half).filter(|&g| g != f) {
                        let other = s.rotation(clip.pose(g), link).coords;
                        sum += other * own.coords.dot(&other).signum();
                    }
                }
                rotations.push(Quat::new_normalize(nalgebra::Quaternion::from_vector(sum)));
            }
        }
        Self { joints: rig.joints().len(), rotations }
    }

    /// Of the joint with this number in the rig.
    pub fn at(&self, f: usize, joint: usize) -> &Quat {
        &self.rotations[f * self.joints + joint]
    }

    /// The rotation `source` of a joint turned by a difference in these axes.
    pub fn turned(&self, f: usize, joint: usize, source: &Quat, by: &Vec3) -> Quat {
        exp(&(self.at(f, joint) * by)) * source
    }
}

/// The path of a root: where it is, which way it faces, how it leans.
pub(super) struct Path {
    pub places: Vec<Vec3>,
    headings: Vec<Quat>,
    pub tilts: Vec<Quat>,
}

impl Path {
    pub fn of(rig: &Rig, clip: &Clip) -> Self {
        let zero = clip.skeleton.links()[0].parent_from_zero;
        let place = |f: usize| zero * nalgebra::Point3::from(clip.skeleton.position(clip.pose(f), 0));
        let headings = headings(rig, clip);
        let from_zero = rig.axes_from_link(0).inverse();
        let tilts = rig
            .root_rotations(clip)
            .iter()
            .zip(&headings)
            .map(|(r, h)| h.inverse() * (r * from_zero))
            .collect();
        Self { places: (0..clip.frames()).map(|f| place(f).coords).collect(), headings, tilts }
    }

    /// The way of the root in the heading frame of this frame, m, and the turn of the heading, rad, to the next frame.
    fn step(&self, f: usize) -> (Vec3, f64) {
        let way = self.headings[f].inverse() * (self.places[f + 1] - self.places[f]);
        (way, log(&(self.headings[f].inverse() * self.headings[f + 1])).y)
    }

    /// Sideways and forward speed (x, z; m/s) and turn (y; rad/s) from this frame to the next.
    pub fn rates(&self, f: usize, rate_hz: f64) -> Vec3 {
        let (way, turn) = self.step(f);
        Vec3::new(way.x, turn, way.z) * rate_hz
    }
}

/// What differences may change.
#[derive(Clone, Debug, PartialEq)]
pub struct Allowed {
    /// For every joint of the rig.
    pub joints: Vec<bool>,
    /// The lean of the root.
    pub tilt: bool,
    /// Its height.
    pub height: bool,
    /// Its way over the ground, and its heading.
    pub steps: bool,
    /// Time.
    pub time: bool,
}

/// The clip that differs from `source` by `differences` (one row a frame), at the times of the source, on `onto` (a skeleton of the same
/// links). Where nothing differs it is the source, to the bit.
pub fn add(
    rig: &Rig,
    source: &Clip,
    differences: &DMatrix<f64>,
    allowed: &Allowed,
    onto: &Arc<Skeleton>,
    onto_size_m: f64,
) -> Clip {
    let d = differences;
    let root = joints_width(rig);
    let larger = onto_size_m / rig.size_m;
    let path = Path::of(rig, source);
    let smooth = Smooth::of(rig, source);
    let step_s = 1.0 / source.rate_hz;
    let same = std::ptr::eq(onto.as_ref(), source.skeleton.as_ref()) || **onto == *source.skeleton;
    let steps = allowed.steps
        && (0..d.nrows()).any(|f| [SIDEWAYS, FORWARD, TURN].iter().any(|c| d[(f, root + c)] != 0.0));
    let back = onto.links()[0].parent_from_zero.inverse();
    let (mut turn, mut place) = (0.0_f64, path.places.first().map_or(Vec3::zeros(), |p| p * larger));
    let mut q = Vec::with_capacity(source.data().len());
    for f in 0..source.frames() {
        let from = source.pose(f);
        let mut to = from.to_vec();
        let mut column = 0;
        for (joint, (&(_, moves), &may)) in rig.joints().iter().zip(&allowed.joints).enumerate() {
            if may {
                move_joint(rig, &smooth, &mut to, joint, d, f, column);
            }
            column += moves.width();
        }
        let mut heading = path.headings[f];
        let mut tilt = path.tilts[f];
        let lean = read3(d, f, root + TILT);
        let leans = allowed.tilt && lean != Vec3::zeros();
        if leans {
            tilt *= exp(&lean);
        }
        if steps {
            heading = Quat::from_axis_angle(&Vec3::y_axis(), turn) * heading;
        }
        if leans || steps {
            let world = heading * tilt * rig.axes_from_link(0);
            let own = onto.links()[0].parent_from_zero.rotation.inverse() * world;
            onto.set_rotation(&mut to, 0, &own);
        }
        let height = if allowed.height { d[(f, root + HEIGHT)] } else { 0.0 };
        if steps || height != 0.0 || !same {
            let mut at = if steps { place } else { path.places[f] * larger };
            at.y = path.places[f].y * larger + height * onto_size_m;
            onto.set_position(&mut to, 0, &(back * nalgebra::Point3::from(at)).coords);
        }
        q.extend_from_slice(&to);
        if steps && f + 1 < source.frames() {
            let way = path.step(f).0 * larger;
            let more =
                Vec3::new(d[(f, root + SIDEWAYS)], 0.0, d[(f, root + FORWARD)]) * (onto_size_m * step_s);
            place += heading * (way + more);
            turn += d[(f, root + TURN)] * step_s;
        }
    }
    Clip::new(onto.clone(), source.rate_hz, q)
}

/// Turns or moves one joint of the pose `to` by its difference.
fn move_joint(
    rig: &Rig,
    smooth: &Smooth,
    to: &mut [f64],
    joint: usize,
    d: &DMatrix<f64>,
    f: usize,
    column: usize,
) {
    let s = rig.skeleton();
    let (link, moves) = rig.joints()[joint];
    match moves {
        Moves::Ball => {
            let turn = read3(d, f, column);
            if turn == Vec3::zeros() {
                return;
            }
            let own = rig.axes_from_link(link).inverse() * turn;
            match s.links()[link].joint {
                Joint::Spherical | Joint::Free => {
                    let r = smooth.turned(f, joint, &s.rotation(to, link), &own);
                    s.set_rotation(to, link, &r);
                }
                // what a ball was taught, a hinge does about its axis
                Joint::Revolute(axis) => to[s.q_at(link)] += own.dot(&axis),
                Joint::Prismatic(_) | Joint::Fixed => {}
            }
        }
        Moves::Axis => match s.links()[link].joint {
            Joint::Revolute(_) => to[s.q_at(link)] += d[(f, column)],
            Joint::Prismatic(_) => to[s.q_at(link)] += d[(f, column)] * rig.size_m,
            _ => {}
        },
    }
}

/// Times of the frames when seconds are stretched by `exp(logarithms)`, s; the first at 0.
pub fn elapsed(logarithms: impl Iterator<Item = f64>, step_s: f64) -> Vec<f64> {
    let mut at = 0.0;
    logarithms
        .map(|l| {
            let now = at;
            at += step_s * l.exp();
            now
        })
        .collect()
}
