//! Features: what a frame of the source motion is recognised by (IAF09 §4.5).
//!
//! In: a clip and its [`Rig`]. Out: for every frame two rows: the configuration feature x^(k), places of all points 0.125 s before (b),
//! now (n) and 0.125 s after (a) in the heading frame of now, and where the root is 0.25 s before and after, times [`Recognised::path_weight`] and the square root of the number of
//! points; and the acceleration feature x^(a), accelerations of all points relative to the
//! root, from a parabola fitted over 0.125 s, in the same frame.
//!
//! Distances between frames are those of the paper's coordinates, but these are turned, so that what a body is doing falls into groups that a model may
//! weigh each for itself (`configuration_groups`):
//!
//! | group | of | coordinates |
//! |---|---|---|
//! | 0, pose | all points | (b + n + a)/√3 |
//! | 1, velocity | root and points | (a − b)/√2 |
//! | 2, bend | root and points | (b − 2 n + a)/√6; of the root, where n is zero, (b + a)/√2 |
//! | 3, way | the root, ±0.25 s | (after − before)/√2 |
//! | 4, bend of the way | the root, ±0.25 s | (after + before)/√2 |
//!
//! The root's way is not in the paper: within 0.25 s a body that slows down is told from one that walks by its pose alone, and an edit
//! that depends on speed changes with every step.
//!
//! The paper removes the whole orientation of the root; the default here removes the heading and leaves the lean
//! ([`Orientation`]). Before the first and after the last frame a point goes on as it came: `p(−t) = 2 p(0) − p(t)`.
//!
//! Units: places in parts of the body's size, accelerations in sizes per s².

use std::f64::consts::FRAC_1_SQRT_2;

use motion::derivatives::parabola;
use motion::rotation::{Quat, Vec3};
use motion::{Clip, names::Word};
use nalgebra::DMatrix;

use super::Rig;
use super::rig::Signed;

/// How far before and after the frame the other two configurations are, s (IAF09).
pub const APART_S: f64 = 0.125;

/// How far before and after the frame the two places of the root's way are, s.
pub const PATH_S: f64 = 0.25;

/// [`Recognised::path_weight`] if nothing else is said.
pub const PATH_WEIGHT: f64 = 1.0;

/// What is removed of the root's orientation in features.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Orientation {
    /// The turn about the vertical: a lean is a feature.
    #[default]
    Heading,
    /// All of it, as in the paper.
    Whole,
}

impl Word for Orientation {
    const KIND: &'static str = "what is removed of the root's orientation";
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Heading, "heading", "the turn about the vertical: a lean is a feature"),
        (Self::Whole, "whole", "all of it, as the paper has it"),
    ];
}

/// What features are made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recognised {
    /// What is removed of the root's orientation.
    pub orientation: Orientation,
    /// How much the root's way over ±[`PATH_S`] counts, 0 or more: at 1 each of its two places as much as one more configuration of
    /// the whole body, carried there as it is now; at 0 features are those of the paper.
    pub path_weight: f64,
}

impl Default for Recognised {
    fn default() -> Self {
        Self { orientation: Orientation::default(), path_weight: PATH_WEIGHT }
    }
}

/// Number of coordinates of x^(k) of a rig with so many points.
pub(super) fn configuration_width(points: usize) -> usize {
    3 * (4 + 3 * points)
}

/// The group of each coordinate of x^(k) of a rig with so many points: see the module header.
pub(super) fn configuration_groups(points: usize) -> Vec<usize> {
    let sizes = [points, points + 1, points + 1, 1, 1];
    sizes.iter().enumerate().flat_map(|(group, size)| std::iter::repeat_n(group, 3 * size)).collect()
}

/// Features of all frames: one row each.
#[derive(Clone, Debug, PartialEq)]
pub struct Features {
    /// x^(k): the groups of the module header, one after the other.
    pub configuration: DMatrix<f64>,
    /// x^(a): all points.
    pub acceleration: DMatrix<f64>,
}

impl Features {
    /// Features of the frames `frames` of a clip.
    pub fn of(rig: &Rig, clip: &Clip, frames: &[usize], recognised: Recognised) -> Self {
        let Recognised { orientation, path_weight } = recognised;
        let path = Path { places: rig.places(clip), width: 1 + rig.points(), frames: clip.frames() };
        let turns = rig.root_rotations(clip);
        let (n, points) = (frames.len(), rig.points());
        let mut configuration = DMatrix::zeros(n, configuration_width(points));
        let weight = path_weight * (points as f64).sqrt();
        let mut acceleration = DMatrix::zeros(n, 3 * points);
        let step = APART_S * clip.rate_hz;
        let half = ((0.5 * APART_S * clip.rate_hz).round() as i64).max(1);
        let weights = parabola(-half, half, clip.rate_hz);
        for (row, &frame) in frames.iter().enumerate() {
            let frame_from_world = match orientation {
                Orientation::Heading => rig.heading(&turns[frame]).inverse(),
                Orientation::Whole => rig.axes_from_link(0) * turns[frame].inverse(),
            };
            let now = path.at(frame as f64, 0);
            let local = |p: Vec3| frame_from_world * (p - now) / rig.size_m;
            let mut put = |block: usize, point: usize, p: Vec3| {
                for c in 0..3 {
                    configuration[(row, 3 * (block + point) + c)] = p[c];
                }
            };
            let (velocity, bend, way) = (points, 2 * points + 1, 3 * points + 2);
            for point in 0..=points {
                let at = |offset: f64| local(path.at(frame as f64 + offset, point));
                let (b, n, a) = (at(-step), at(0.0), at(step));
                put(velocity, point, (a - b) * FRAC_1_SQRT_2);
                if point == 0 {
                    put(bend, point, (b + a) * FRAC_1_SQRT_2);
                } else {
                    put(0, point - 1, (b + n + a) / 3.0_f64.sqrt());
                    put(bend, point, (b - n * 2.0 + a) / 6.0_f64.sqrt());
                }
            }
            let at = |offset: f64| local(path.at(frame as f64 + offset * clip.rate_hz, 0)) * weight;
            let (b, a) = (at(-PATH_S), at(PATH_S));
            put(way, 0, (a - b) * FRAC_1_SQRT_2);
            put(way, 1, (a + b) * FRAC_1_SQRT_2);
            for point in 1..=points {
                let mut a = Vec3::zeros();
                for (offset, (_, bend)) in (-half..=half).zip(&weights) {
                    let at = frame as f64 + offset as f64;
                    a += (path.at(at, point) - path.at(at, 0)) * *bend;
                }
                let a = frame_from_world * a / rig.size_m;
                for c in 0..3 {
                    acceleration[(row, 3 * (point - 1) + c)] = a[c];
                }
            }
        }
        Self { configuration, acceleration }
    }
}

/// How configuration features are mirrored; `None` without left and right.
pub(super) fn mirror_configuration(rig: &Rig) -> Option<Signed> {
    let mut out = rig.mirror_points(&[false, true, true])?;
    let at = out.len();
    for p in 0..2 {
        out.extend([(at + 3 * p, -1.0), (at + 3 * p + 1, 1.0), (at + 3 * p + 2, 1.0)]);
    }
    Some(out)
}

/// How acceleration features are mirrored.
pub(super) fn mirror_acceleration(rig: &Rig) -> Option<Signed> {
    rig.mirror_points(&[false])
}

/// Places of root and points over time.
struct Path {
    places: Vec<Vec3>,
    width: usize,
    frames: usize,
}

impl Path {
    /// Where a point (0 is the root) is at a time in frames, m; beyond the ends it goes on as it came.
    fn at(&self, t: f64, point: usize) -> Vec3 {
        let last = (self.frames - 1) as f64;
        if t < 0.0 {
            return 2.0 * self.at(0.0, point) - self.within((-t).min(last), point);
        }
        if t > last {
            return 2.0 * self.at(last, point) - self.within((2.0 * last - t).max(0.0), point);
        }
        self.within(t, point)
    }

    fn within(&self, t: f64, point: usize) -> Vec3 {
        let near = t.round();
        let place = |f: usize| self.places[f.min(self.frames - 1) * self.width + point];
        if (t - near).abs() < 1e-6 {
            return place(near as usize);
        }
        let f = t.floor();
        let (a, b) = (place(f as usize), place(f as usize + 1));
        a + (b - a) * (t - f)
    }
}

/// The heading of every frame, world from heading frame.
pub(super) fn headings(rig: &Rig, clip: &Clip) -> Vec<Quat> {
    rig.root_rotations(clip).iter().map(|r| rig.heading(r)).collect()
}
