//! Joint values as people write them: degrees.
//!
//! A hinge takes one number, a ball joint three Euler angles `(x, y, z)` that are applied as
//! `R = Ry · Rz · Rx` ([`motion::EulerOrder::YZX`]): bend or twist about x first, then z, turn about y last.

use std::fmt;

use motion::Vec3;
pub use motion::rotation::{deg_from_quat, quat_from_deg};
use serde::de::{self, Deserialize, Deserializer, SeqAccess, Visitor};

/// The value of a hinge (deg) or slide (m), or of a ball joint (deg).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Angle {
    /// One number.
    One(f64),
    /// `(x, y, z)`, degrees.
    Ball([f64; 3]),
}

impl<'de> Deserialize<'de> for Angle {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct Read;
        impl<'de> Visitor<'de> for Read {
            type Value = Angle;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number of degrees for a hinge, or (x, y, z) in degrees for a ball joint")
            }
            fn visit_f64<E: de::Error>(self, x: f64) -> Result<Angle, E> {
                Ok(Angle::One(x))
            }
            fn visit_i64<E: de::Error>(self, x: i64) -> Result<Angle, E> {
                Ok(Angle::One(x as f64))
            }
            fn visit_u64<E: de::Error>(self, x: u64) -> Result<Angle, E> {
                Ok(Angle::One(x as f64))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Angle, A::Error> {
                let mut out = [0.0; 3];
                for (i, x) in out.iter_mut().enumerate() {
                    *x = seq.next_element()?.ok_or_else(|| de::Error::invalid_length(i, &self))?;
                }
                match seq.next_element::<f64>()? {
                    None => Ok(Angle::Ball(out)),
                    Some(_) => Err(de::Error::invalid_length(4, &self)),
                }
            }
        }
        d.deserialize_any(Read)
    }
}

/// Horizontal unit vector of a direction: 0° forward (+Z), 90° left (+X), 180° back, 270° right.
pub fn direction(deg: f64) -> Vec3 {
    let (s, c) = deg.to_radians().sin_cos();
    Vec3::new(s, 0.0, c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_are_read() {
        let read = |s: &str| ron::from_str::<Angle>(s);
        assert_eq!(read("20").unwrap(), Angle::One(20.0));
        assert_eq!(read("-2.5").unwrap(), Angle::One(-2.5));
        assert_eq!(read("(1, 2.5, -3)").unwrap(), Angle::Ball([1.0, 2.5, -3.0]));
        assert!(read("(1, 2)").is_err() && read("(1, 2, 3, 4)").is_err() && read("\"a\"").is_err());
    }

    /// x first, then z, then y: a quarter turn about x takes y to z, which the turn about y takes to x.
    #[test]
    fn the_order_is_as_documented() {
        let v = quat_from_deg([90.0, 90.0, 0.0]) * Vec3::y();
        assert!((v - Vec3::x()).norm() < 1e-12, "{v:?}");
        for xyz in [[10.0, -20.0, 30.0], [170.0, 5.0, -80.0]] {
            let back = deg_from_quat(&quat_from_deg(xyz));
            assert!((0..3).all(|i| (back[i] - xyz[i]).abs() < 1e-9), "{back:?}");
        }
    }
}
