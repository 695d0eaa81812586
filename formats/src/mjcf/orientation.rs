//! Orientations: five attributes that mean one.
//!
//! In: the attributes of an element, the file's angle unit and Euler sequence. Out: a unit quaternion.

use nalgebra::{Matrix3, Quaternion, Rotation3};

use super::defaults::ORIENTATIONS;
use crate::attributes::Reader;
use crate::model_file::{ModelFault, ModelFileError};
use motion::rotation::{Quat, Vec3, between, exp};

/// How angles are written.
#[derive(Clone, Copy, Debug)]
pub struct Angles {
    /// Radians in one unit of the file.
    pub unit: f64,
    /// Axes of Euler angles, 0 x, 1 y, 2 z; and whether each turns about the fixed axes.
    pub sequence: [(usize, bool); 3],
}

/// The orientation, from whichever attribute gives it; identity if none does.
pub fn orientation(r: &Reader, angles: &Angles) -> Result<Quat, ModelFileError> {
    let found: Vec<&'static str> = ORIENTATIONS.into_iter().filter(|name| r.get(name).is_some()).collect();
    if found.len() > 1 {
        let fault = ModelFault::Exclusive { element: r.element.into(), attributes: found.clone() };
        return Err(r.fault(found[1], fault));
    }
    if let Some([w, x, y, z]) = r.array("quat")? {
        let q = Quaternion::new(w, x, y, z);
        if q.norm() < 1e-10 || !q.norm().is_finite() {
            return Err(r.bounds("quat", "a quaternion, not all zeros"));
        }
        return Ok(Quat::new_normalize(q));
    }
    if let Some([x, y, z, angle]) = r.array("axisangle")? {
        let axis = Vec3::new(x, y, z);
        if axis.norm() < 1e-10 || !axis.norm().is_finite() {
            return Err(r.bounds("axisangle", "an axis, not all zeros, and an angle"));
        }
        return Ok(exp(&(axis.normalize() * (angle * angles.unit))));
    }
    if let Some([a, b, c, d, e, f]) = r.array("xyaxes")? {
        let (x, y) = (Vec3::new(a, b, c), Vec3::new(d, e, f));
        let x = x / x.norm();
        let y = y - x * x.dot(&y);
        let y = y / y.norm();
        let m = Matrix3::from_columns(&[x, y, x.cross(&y)]);
        if !m.iter().all(|v| v.is_finite()) || y.dot(&x).abs() > 1e-6 {
            return Err(r.bounds("xyaxes", "two directions, not parallel"));
        }
        return Ok(Quat::from_rotation_matrix(&Rotation3::from_matrix_unchecked(m)));
    }
    if let Some(z) = r.direction("zaxis")? {
        return Ok(between(&Vec3::z(), &z));
    }
    if let Some(turns) = r.array::<3>("euler")? {
        let mut q = Quat::identity();
        for ((axis, fixed), angle) in angles.sequence.into_iter().zip(turns) {
            let mut turn = Vec3::zeros();
            turn[axis] = angle * angles.unit;
            q = if fixed { exp(&turn) * q } else { q * exp(&turn) };
        }
        return Ok(q);
    }
    Ok(Quat::identity())
}
