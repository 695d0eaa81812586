//! Degrees of freedom as a script sees them, and the values they take.
//!
//! A DOF is one thing a track moves: the angle of a hinge, the way of a slide, the rotation of a ball
//! joint or of a free root, or one coordinate of a free root. Every skeleton has one ordered list of
//! them ([`Dof::all`]); labels count in it.
//!
//! Names: the link's name for its joint value or rotation (`elbow_r`, `pelvis`), and `pelvis_x`,
//! `pelvis_y`, `pelvis_z` for the coordinates of a free link, m. A link of such a name wins.

use crate::rotation::{Quat, Vec3, exp, log, slerp};
use crate::skeleton::{Joint, Skeleton, quat_at};

/// One degree of freedom of a skeleton; the number is the link's index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Dof {
    /// The angle of a hinge, rad, or the way of a slide, m.
    Axis(usize),
    /// The rotation of a ball joint or of a free link.
    Rotation(usize),
    /// One coordinate (0, 1, 2 = x, y, z) of a free link, m.
    Coordinate(usize, usize),
}

/// A value of a DOF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// Of a hinge (rad), a slide or a root coordinate (m).
    Scalar(f64),
    /// Of a ball joint or a free root. `q` and `−q` are the same rotation.
    Rotation(Quat),
}

impl Value {
    /// The value at the fraction `s` of the way from `start` to `end`: linear, or slerp along the shorter
    /// arc; extrapolates outside [0, 1]. Exactly `start` at 0 and `end` at 1.
    ///
    /// Values of different kinds do not mix: then `end` is returned.
    pub fn between(start: &Value, end: &Value, s: f64) -> Value {
        if s == 0.0 {
            return *start;
        }
        if s == 1.0 {
            return *end;
        }
        match (start, end) {
            (Value::Scalar(a), Value::Scalar(b)) => Value::Scalar(a + (b - a) * s),
            (Value::Rotation(a), Value::Rotation(b)) => Value::Rotation(slerp(a, b, s)),
            _ => *end,
        }
    }

    /// How far apart two values are: rad or m; infinite for values of different kinds.
    pub fn distance(&self, other: &Value) -> f64 {
        match (self, other) {
            (Value::Scalar(a), Value::Scalar(b)) => (a - b).abs(),
            (Value::Rotation(a), Value::Rotation(b)) => log(&(b * a.inverse())).norm(),
            _ => f64::INFINITY,
        }
    }

    /// The mean: of scalars the arithmetic one, of rotations the one whose squared angles to all sum up least (Karcher), found
    /// from the middle one. `None` of nothing, or of values of different kinds.
    pub fn mean(values: &[Value]) -> Option<Value> {
        let n = values.len() as f64;
        match values.get(values.len() / 2)? {
            Value::Scalar(_) => {
                let all: Option<Vec<f64>> = values.iter().map(Value::scalar).collect();
                Some(Value::Scalar(all?.iter().sum::<f64>() / n))
            }
            Value::Rotation(middle) => {
                let all: Option<Vec<Quat>> = values.iter().map(Value::rotation).collect();
                let (all, mut mean) = (all?, *middle);
                // converges by the square of the spread: a few steps for joints
                for _ in 0..50 {
                    let step = all.iter().map(|q| log(&(q * mean.inverse()))).sum::<Vec3>() / n;
                    mean = exp(&step) * mean;
                    if step.norm() < 1e-12 {
                        break;
                    }
                }
                Some(Value::Rotation(mean))
            }
        }
    }

    /// The number of a scalar.
    pub fn scalar(&self) -> Option<f64> {
        match self {
            Value::Scalar(x) => Some(*x),
            Value::Rotation(_) => None,
        }
    }

    /// The quaternion of a rotation.
    pub fn rotation(&self) -> Option<Quat> {
        match self {
            Value::Rotation(r) => Some(*r),
            Value::Scalar(_) => None,
        }
    }

    /// Whether every number is finite and a rotation has unit length (within 1e-6).
    pub fn is_valid(&self) -> bool {
        match self {
            Value::Scalar(x) => x.is_finite(),
            // a NaN fails the comparison
            Value::Rotation(r) => (r.coords.norm() - 1.0).abs() < 1e-6,
        }
    }
}

impl Dof {
    /// All DOFs of a skeleton, link by link; a free link gives its x, y, z and then its rotation.
    pub fn all(skeleton: &Skeleton) -> Vec<Dof> {
        let mut all = Vec::new();
        for (i, link) in skeleton.links().iter().enumerate() {
            match link.joint {
                Joint::Free => {
                    all.extend([0, 1, 2].map(|k| Dof::Coordinate(i, k)));
                    all.push(Dof::Rotation(i));
                }
                Joint::Spherical => all.push(Dof::Rotation(i)),
                Joint::Revolute(_) | Joint::Prismatic(_) => all.push(Dof::Axis(i)),
                Joint::Fixed => {}
            }
        }
        all
    }

    /// The DOF of this name, if the skeleton has it.
    pub fn find(skeleton: &Skeleton, name: &str) -> Option<Dof> {
        if let Some(i) = skeleton.link(name) {
            return match skeleton.links()[i].joint {
                Joint::Free | Joint::Spherical => Some(Dof::Rotation(i)),
                Joint::Revolute(_) | Joint::Prismatic(_) => Some(Dof::Axis(i)),
                Joint::Fixed => None,
            };
        }
        let (stem, axis) = name.rsplit_once('_')?;
        let k = ["x", "y", "z"].iter().position(|a| *a == axis)?;
        let i = skeleton.link(stem)?;
        matches!(skeleton.links()[i].joint, Joint::Free).then_some(Dof::Coordinate(i, k))
    }

    /// The DOF that holds the joint value or rotation of a link; `None` for a welded link.
    pub fn of_link(skeleton: &Skeleton, link: usize) -> Option<Dof> {
        match skeleton.links()[link].joint {
            Joint::Free | Joint::Spherical => Some(Dof::Rotation(link)),
            Joint::Revolute(_) | Joint::Prismatic(_) => Some(Dof::Axis(link)),
            Joint::Fixed => None,
        }
    }

    /// Index in [`Dof::all`]; `None` for a DOF the skeleton does not have.
    pub fn index(self, skeleton: &Skeleton) -> Option<usize> {
        Dof::all(skeleton).iter().position(|d| *d == self)
    }

    /// The link it moves.
    pub fn link(self) -> usize {
        match self {
            Dof::Axis(i) | Dof::Rotation(i) | Dof::Coordinate(i, _) => i,
        }
    }

    /// Its name: see the module header.
    pub fn name(self, skeleton: &Skeleton) -> String {
        let name = &skeleton.links()[self.link()].name;
        match self {
            Dof::Axis(_) | Dof::Rotation(_) => name.clone(),
            Dof::Coordinate(_, k) => format!("{name}_{}", ["x", "y", "z"][k.min(2)]),
        }
    }

    /// Whether its values are rotations.
    pub fn is_rotation(self) -> bool {
        matches!(self, Dof::Rotation(_))
    }

    /// Its value in the pose `q` (length `nq`).
    pub fn read(self, skeleton: &Skeleton, q: &[f64]) -> Value {
        let at = skeleton.q_at(self.link());
        match self {
            Dof::Axis(_) => Value::Scalar(q[at]),
            Dof::Coordinate(_, k) => Value::Scalar(q[at + k]),
            Dof::Rotation(i) => {
                let free = matches!(skeleton.links()[i].joint, Joint::Free);
                Value::Rotation(quat_at(q, if free { at + 3 } else { at }))
            }
        }
    }

    /// Writes its value into the pose `q` (length `nq`); a value of the wrong kind is ignored.
    pub fn write(self, skeleton: &Skeleton, q: &mut [f64], value: &Value) {
        let at = skeleton.q_at(self.link());
        match (self, value) {
            (Dof::Axis(_), Value::Scalar(x)) => q[at] = *x,
            (Dof::Coordinate(_, k), Value::Scalar(x)) => q[at + k] = *x,
            (Dof::Rotation(i), Value::Rotation(r)) => skeleton.set_rotation(q, i, r),
            _ => {}
        }
    }
}
