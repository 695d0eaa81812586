//! Feet: the box that a foot stands on, and where its sole, heel and toes are.
//!
//! In: a [`Character`] and one of its soles. Out: a [`Foot`], in the frame of the link that has the box.

use motion::{Kinematics, Quat, Range, Shape, Sole, Transform, Vec3};
use nalgebra::Matrix3;

use super::SolesError;
use crate::character::Character;

/// Where the hinge of toes may be, from the heel, parts of the length of the box.
pub(super) const HINGES: Range = Range { lo: 0.6, hi: 0.9 };
/// Points and faces farther than this from the plane of a sole are not of it, m.
const FLAT: f64 = 2e-3;

/// A foot that stands on a box. Directions are unit vectors of the frame of `link`.
pub(super) struct Foot {
    pub link: usize,
    /// Which of the link's shapes.
    pub shape: usize,
    pub rotation: Quat,
    pub up: Vec3,
    pub front: Vec3,
    /// Middle of the lower rear edge.
    pub heel: Vec3,
    pub length: f64,
    pub height: f64,
    half: Vec3,
    /// Axes of the box: across the sole, along the foot.
    axes: [usize; 2],
}

impl Foot {
    pub fn of(character: &Character, sole: &Sole) -> Result<Self, SolesError> {
        let k = Kinematics::new(&character.skeleton, &character.rest);
        let corners = sole.in_link(&k);
        let flat = |found: String| SolesError::NotFlat { foot: sole.name.clone(), found };
        let (at, mut up) =
            plane(&corners).ok_or_else(|| flat(format!("{} points in a line", corners.len())))?;
        let off = corners.iter().map(|c| (c - at).dot(&up).abs()).fold(0.0, f64::max);
        if off > FLAT {
            return Err(flat(format!("one is {:.0} mm out of their plane", 1e3 * off)));
        }
        // the ankle is over the sole
        if at.dot(&up) > 0.0 {
            up = -up;
        }
        let back = k.world[sole.link].inverse();
        let mut found = Vec::new();
        for (link, body) in character.bodies.iter().enumerate() {
            if character.skeleton.welded_to(link) != character.skeleton.welded_to(sole.link) {
                continue;
            }
            let frame = back * k.world[link];
            for (i, shape) in body.shapes.iter().enumerate() {
                if shape.reach(&frame, &-up) > -at.dot(&up) - FLAT {
                    found.push((link, i, *shape, frame));
                }
            }
        }
        let not_a_box = |found: String| SolesError::NotABox { foot: sole.name.clone(), found };
        let [(link, shape, Shape::Box { center, half, rotation }, frame)] = found[..] else {
            return Err(not_a_box(match found.len() {
                0 => "no shapes".into(),
                1 => "a shape that is no box".into(),
                n => format!("{n} shapes"),
            }));
        };
        // from here on in the frame of the link that has the box
        let frame: Transform = frame;
        let (up, at) = (frame.rotation.inverse() * up, frame.inverse().transform_point(&at.into()).coords);
        let axis = |i: usize| rotation * Vec3::ith(i, 1.0);
        let across =
            (0..3).max_by(|&a, &b| axis(a).dot(&up).abs().total_cmp(&axis(b).dot(&up).abs())).unwrap_or(1);
        let up = axis(across) * axis(across).dot(&up).signum();
        let low = center - up * half[across];
        if (low - at).dot(&up).abs() > FLAT || (0..3).all(|i| axis(i).dot(&up).abs() < 1.0 - 1e-3) {
            return Err(not_a_box("a box that is turned against its sole, and no other shape,".into()));
        }
        let [a, b] = [(across + 1) % 3, (across + 2) % 3];
        let along = if half[a] > half[b] { a } else { b };
        // the ankle is nearer to the heel
        let front = axis(along) * axis(along).dot(&(center - frame.inverse().translation.vector)).signum();
        Ok(Self {
            link,
            shape,
            rotation,
            up,
            front,
            heel: low - front * half[along],
            length: 2.0 * half[along],
            height: 2.0 * half[across],
            half,
            axes: [across, along],
        })
    }

    /// Centre and half edges of the part of the box between two parts of its length, `height` high.
    pub fn slice(&self, from: f64, to: f64, height: f64) -> (Vec3, Vec3) {
        let mut half = self.half;
        half[self.axes[0]] = 0.5 * height;
        half[self.axes[1]] = 0.5 * (to - from) * self.length;
        (self.heel + self.front * (0.5 * (from + to) * self.length) + self.up * (0.5 * height), half)
    }

    /// Lower corners of a part about `center`, at its front (`outward` 1) or rear (-1).
    pub fn edge(&self, center: &Vec3, half: &Vec3, outward: f64) -> [Vec3; 2] {
        let [upright, along] = self.axes;
        let middle = center - self.up * half[upright] + self.front * (outward * half[along]);
        let aside = self.front.cross(&self.up) * half[3 - upright - along];
        [middle + aside, middle - aside]
    }

    /// Where the toes of the rig begin, from the heel, part of the length.
    pub fn toes_at(&self, character: &Character) -> Option<f64> {
        let skeleton = &character.skeleton;
        let k = Kinematics::new(skeleton, &character.rest);
        let back = k.world[self.link].inverse();
        let own = skeleton.welded_to(self.link);
        let welded = |l: &usize| *l != own && skeleton.welded_to(*l) == own;
        let at = |l: usize| (back * k.world[l]).translation.vector;
        let along = (0..skeleton.links().len())
            .filter(welded)
            .map(|l| (at(l) - self.heel).dot(&self.front) / self.length);
        along.filter(|x| HINGES.contains(*x)).min_by(f64::total_cmp)
    }
}

/// Middle and normal of the plane nearest to some points; `None` for fewer than three, or for a line.
fn plane(points: &[Vec3]) -> Option<(Vec3, Vec3)> {
    let middle = points.iter().sum::<Vec3>() / points.len().max(1) as f64;
    let spread: Matrix3<f64> = points.iter().map(|p| (p - middle) * (p - middle).transpose()).sum();
    let eigen = spread.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let wide = eigen.eigenvalues[order[1]] > 1e-6 && points.len() >= 3;
    wide.then(|| (middle, eigen.eigenvectors.column(order[0]).into_owned().normalize()))
}
