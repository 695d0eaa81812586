//! [`Clip`] to BVH text.
//!
//! | link | channels |
//! |---|---|
//! | the root, whatever its joint | three positions, three rotations; OFFSET zero |
//! | `Free`, `Prismatic` | three positions, three rotations |
//! | `Spherical`, `Revolute` about any axis | three rotations |
//! | `Fixed` | three rotations, always zero |
//!
//! A fixed link could be `CHANNELS 0`, but many readers take three angles for every joint and would shift
//! all columns after it; three zeros cost little and are read alike everywhere.
//!
//! # Zero frames that are turned
//!
//! BVH has no rest rotations: at zero channels every joint's axes are the world's. Let `W_j` be a link's
//! world rotation, `Z_j` the rotation of `parent_from_zero`, `R_j` the joint's and `A_j = A_parent Z_j`
//! the link's world rotation in the zero pose. The BVH joint frame is `B_j = W_j A_j⁻¹`, so that
//!
//! - rotation channels are `C_j = B_parent⁻¹ B_j = A_j R_j A_j⁻¹`,
//! - offsets and positions are `A_parent · (t_j + Z_j d_j)`, `d_j` the joint's translation,
//! - end sites are `A_j · end`.
//!
//! World positions are kept exactly, world rotations up to the constant `A_j`; where no zero frame is
//! turned, all numbers are those of the clip.
//!
//! # Angles
//!
//! Of the two triples of Euler angles that give a rotation, (a, b, c) and (a + π, π − b, c + π), the one
//! nearer to the frame before is taken, and each angle is unwrapped by whole turns. In gimbal lock the
//! first angle stays and the others follow from the remaining rotation.

use std::fmt::Write;

use thiserror::Error;

use motion::rotation::{EulerOrder, Quat, Vec3};
use motion::{Clip, Joint, Skeleton, Transform};

use super::fixed;

/// How a clip is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WriteOptions {
    /// Metres per file unit; default 0.01, centimetres.
    pub metres_per_unit: f64,
    /// Order of the rotation channels; default `Zrotation Yrotation Xrotation`.
    pub order: EulerOrder,
    /// Digits after the point; default 6: 1e-8 m, 1e-6°. At most 15.
    pub decimals: usize,
}

impl Default for WriteOptions {
    fn default() -> Self {
        Self { metres_per_unit: 0.01, order: EulerOrder::ZYX, decimals: 6 }
    }
}

/// Why a clip cannot be written.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum WriteError {
    /// A unit that is no length.
    #[error("{0} metres per unit; expected a positive number")]
    Units(f64),
    /// An order that repeats an axis.
    #[error("the Euler order {0:?} is not one of the six orders of x, y and z")]
    Order([usize; 3]),
    /// A value that is NaN or infinite.
    #[error("frame {frame} of `{link}` is not finite")]
    NotFinite {
        /// Frame, from 0.
        frame: usize,
        /// The link.
        link: String,
    },
}

const AXES: [char; 3] = ['X', 'Y', 'Z'];

/// Text of a clip: LF line ends, links depth first.
///
/// Braces and line ends in link names, which would break the text, become `_`.
///
/// # Errors
/// See [`WriteError`].
pub fn write(clip: &Clip, options: &WriteOptions) -> Result<String, WriteError> {
    if !(options.metres_per_unit.is_finite() && options.metres_per_unit > 0.0) {
        return Err(WriteError::Units(options.metres_per_unit));
    }
    let mut sorted = options.order.0;
    sorted.sort_unstable();
    if sorted != [0, 1, 2] {
        return Err(WriteError::Order(options.order.0));
    }
    let mut writer = Writer {
        skeleton: &clip.skeleton,
        upright: zero_rotations(&clip.skeleton),
        decimals: options.decimals.min(15),
        units: 1.0 / options.metres_per_unit,
        order: options.order,
        out: String::new(),
    };
    let rows = writer.hierarchy();
    let frame_time = 1.0 / clip.rate_hz;
    let _ = write!(writer.out, "MOTION\nFrames: {}\nFrame Time: {frame_time}\n", clip.frames());
    writer.motion(clip, &rows)?;
    Ok(writer.out)
}

/// World rotation `A_j` of every link in the zero pose.
fn zero_rotations(skeleton: &Skeleton) -> Vec<Quat> {
    let mut a: Vec<Quat> = Vec::with_capacity(skeleton.links().len());
    for link in skeleton.links() {
        let z = link.parent_from_zero.rotation;
        a.push(link.parent.map_or(z, |p| a[p] * z));
    }
    a
}

struct Writer<'a> {
    skeleton: &'a Skeleton,
    upright: Vec<Quat>,
    decimals: usize,
    /// File units per metre.
    units: f64,
    order: EulerOrder,
    out: String,
}

impl Writer<'_> {
    /// Writes the tree depth first; returns the links in that order, which is that of the columns.
    fn hierarchy(&mut self) -> Vec<usize> {
        enum Step {
            Open(usize, usize),
            Close(usize),
        }
        let links = self.skeleton.links();
        let mut children = vec![Vec::new(); links.len()];
        for (i, link) in links.iter().enumerate().skip(1) {
            children[link.parent.unwrap_or(0)].push(i);
        }
        let mut rows = Vec::with_capacity(links.len());
        let mut steps = vec![Step::Open(0, 0)];
        self.out.push_str("HIERARCHY\n");
        while let Some(step) = steps.pop() {
            match step {
                Step::Open(i, depth) => {
                    rows.push(i);
                    let link = &links[i];
                    let keyword = if i == 0 { "ROOT" } else { "JOINT" };
                    let name: String =
                        link.name.chars().map(|c| if "{}\r\n".contains(c) { '_' } else { c }).collect();
                    self.line(depth, &format!("{keyword} {name}"));
                    self.line(depth, "{");
                    let offset = if i == 0 { Vec3::zeros() } else { self.position(i, &Vec3::zeros()) };
                    self.vector_line(depth + 1, offset);
                    let [a, b, c] = self.order.0.map(|axis| AXES[axis]);
                    let rotations = format!("{a}rotation {b}rotation {c}rotation");
                    if self.has_positions(i) {
                        self.line(
                            depth + 1,
                            &format!("CHANNELS 6 Xposition Yposition Zposition {rotations}"),
                        );
                    } else {
                        self.line(depth + 1, &format!("CHANNELS 3 {rotations}"));
                    }
                    if link.end.is_some() || children[i].is_empty() {
                        self.line(depth + 1, "End Site");
                        self.line(depth + 1, "{");
                        let end = self.upright[i] * link.end.unwrap_or_default() * self.units;
                        self.vector_line(depth + 2, end);
                        self.line(depth + 1, "}");
                    }
                    steps.push(Step::Close(depth));
                    steps.extend(children[i].iter().rev().map(|&c| Step::Open(c, depth + 1)));
                }
                Step::Close(depth) => self.line(depth, "}"),
            }
        }
        rows
    }

    fn motion(&mut self, clip: &Clip, rows: &[usize]) -> Result<(), WriteError> {
        let mut before: Vec<Option<Vec3>> = vec![None; rows.len()];
        for frame in 0..clip.frames() {
            let q = clip.pose(frame);
            for (k, &i) in rows.iter().enumerate() {
                let Transform { rotation, translation } = self.skeleton.joint_transform(q, i);
                if k > 0 {
                    self.out.push(' ');
                }
                if self.has_positions(i) {
                    let p = self.position(i, &translation.vector);
                    self.vector(p);
                    self.out.push(' ');
                }
                let a = &self.upright[i];
                let r = if *a == Quat::identity() { rotation } else { a * rotation * a.inverse() };
                let angles = angles_near(self.order, &r, before[i].as_ref());
                if !(angles.sum() + translation.vector.sum()).is_finite() {
                    let link = self.skeleton.links()[i].name.clone();
                    return Err(WriteError::NotFinite { frame, link });
                }
                before[i] = Some(angles);
                self.vector(angles.map(f64::to_degrees));
            }
            self.out.push('\n');
        }
        Ok(())
    }

    fn has_positions(&self, i: usize) -> bool {
        i == 0 || matches!(self.skeleton.links()[i].joint, Joint::Free | Joint::Prismatic(_))
    }

    /// Origin of a link in its parent's BVH frame, file units; `moved` is the joint's translation.
    fn position(&self, i: usize, moved: &Vec3) -> Vec3 {
        let link = &self.skeleton.links()[i];
        let zero = &link.parent_from_zero;
        let parent = link.parent.map_or_else(Quat::identity, |p| self.upright[p]);
        parent * (zero.translation.vector + zero.rotation * moved) * self.units
    }

    fn line(&mut self, depth: usize, text: &str) {
        // Indentation is for people; a chain of thousands of links must not make megabytes of it.
        self.out.extend(std::iter::repeat_n('\t', depth.min(40)));
        self.out.push_str(text);
        self.out.push('\n');
    }

    fn vector_line(&mut self, depth: usize, v: Vec3) {
        self.out.extend(std::iter::repeat_n('\t', depth.min(40)));
        self.out.push_str("OFFSET ");
        self.vector(v);
        self.out.push('\n');
    }

    fn vector(&mut self, v: Vec3) {
        let half_digit = 0.5 * 0.1f64.powi(self.decimals as i32);
        for k in 0..3 {
            if k > 0 {
                self.out.push(' ');
            }
            // no `-0.000000`
            let x = if v[k].abs() < half_digit { 0.0 } else { v[k] };
            fixed::push(&mut self.out, x, self.decimals);
        }
    }
}

/// Euler angles (rad) of `r` nearest to those before; without any, the middle one in [−π/2, π/2].
fn angles_near(order: EulerOrder, r: &Quat, before: Option<&Vec3>) -> Vec3 {
    use std::f64::consts::{PI, TAU};
    let plain = order.from_quat(r);
    let Some(before) = before else { return plain };
    let near = |v: Vec3| v.zip_map(before, |x, b| x + TAU * ((b - x) / TAU).round());
    if plain.y.cos() < 1e-6 {
        return near(with_first(order, r, before.x));
    }
    // The rest from the remaining rotation: near lock, errors of the first angle then cancel.
    let one = near(with_first(order, r, plain.x));
    let other = near(Vec3::new(one.x + PI, PI - one.y, one.z + PI));
    if (other - before).norm_squared() < (one - before).norm_squared() { other } else { one }
}

/// The second and third angle for a given first: `R_i(a)⁻¹ R = M = R_j(b) R_k(c)`.
///
/// `M e_k = R_j(b) e_k` gives b, `Mᵀ e_j = R_k(−c) e_j` gives c.
fn with_first(order: EulerOrder, r: &Quat, a: f64) -> Vec3 {
    let [i, j, k] = order.0;
    let m = order.to_quat(&Vec3::new(-a, 0.0, 0.0)) * r;
    let m = m.to_rotation_matrix();
    let m = m.matrix();
    let sign = if (j + 3 - i) % 3 == 1 { 1.0 } else { -1.0 };
    let b = (sign * m[(i, k)]).atan2(m[(k, k)]);
    let c = (sign * m[(j, i)]).atan2(m[(j, j)]);
    Vec3::new(a, b, c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use motion::rotation::{exp, log};

    /// Through gimbal lock and round several times: the rotation stays, no angle jumps.
    #[test]
    fn angles_are_continuous_and_give_the_rotation_back() {
        for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]].map(EulerOrder) {
            let mut middle = Vec3::zeros();
            middle[order.0[1]] = 1.0;
            let mut before: Option<Vec3> = None;
            for step in 0..4000 {
                // spins about the middle axis through both locks, twenty turns
                let r = exp(&(middle * (f64::from(step) * 0.0314159))) * exp(&Vec3::new(0.2, -0.1, 0.3));
                let angles = angles_near(order, &r, before.as_ref());
                let error = log(&(order.to_quat(&angles) * r.inverse())).norm();
                assert!(error < 1e-12, "{order:?} {step}: {error}"); // 1.9e-14 seen
                before = Some(angles);
            }
            let mut before: Option<Vec3> = None;
            for step in 0..4000 {
                let r = exp(&(middle * (f64::from(step) * 0.0314159)));
                let angles = angles_near(order, &r, before.as_ref());
                if let Some(b) = before {
                    let jump = (angles - b).amax(); // exactly the step
                    assert!(jump < 0.04, "{order:?} {step}: {jump}");
                }
                before = Some(angles);
            }
        }
    }
}
