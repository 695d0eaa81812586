//! Carried masses: crates, bags and weights that move with a link.
//!
//! In: a [`Character`] and what it carries. Out: the same character with other masses: the mass is rigid with
//! its link, so mass, centre of mass and inertia of that link are those of the two bodies taken as one.

use motion::Vec3;
use nalgebra::Matrix3;

use crate::Character;
use crate::mass::fuse;

/// A rigid mass that moves with a link.
#[derive(Clone, Debug, PartialEq)]
pub struct Carried {
    /// Link that carries it.
    pub link: usize,
    /// Mass, kg.
    pub mass: f64,
    /// Its centre of mass in the link's frame, m.
    pub at: Vec3,
    /// Its inertia about that point, link axes, kg·m².
    pub inertia: Matrix3<f64>,
}

impl Carried {
    /// A solid box of uniform density with its edges along the link's axes; `size` m.
    pub fn solid_box(link: usize, mass: f64, at: Vec3, size: Vec3) -> Self {
        let s = size.component_mul(&size) * (mass / 12.0);
        Self { link, mass, at, inertia: Matrix3::from_diagonal(&Vec3::new(s.y + s.z, s.x + s.z, s.x + s.y)) }
    }
}

impl Character {
    /// The character with the masses it carries as parts of its links.
    pub fn carrying<'a>(&self, carried: impl IntoIterator<Item = &'a Carried>) -> Self {
        let mut out = self.clone();
        for c in carried {
            let b = &mut out.bodies[c.link];
            (b.mass, b.com, b.inertia) = fuse((b.mass, b.com, b.inertia), (c.mass, c.at, c.inertia));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The inertia of a box is that of the points it is made of.
    #[test]
    fn a_box_is_its_points() {
        let (mass, size, n) = (5.0, Vec3::new(0.3, 0.2, 0.4), 40);
        let c = Carried::solid_box(0, mass, Vec3::zeros(), size);
        let mut sum = Matrix3::zeros();
        let along = |i: usize, s: f64| ((i as f64 + 0.5) / n as f64 - 0.5) * s;
        for i in 0..n {
            for j in 0..n {
                for k in 0..n {
                    let r = Vec3::new(along(i, size.x), along(j, size.y), along(k, size.z));
                    sum += crate::mass::point_inertia(mass / (n * n * n) as f64, r);
                }
            }
        }
        // the midpoint rule is short by 1/n²
        let error = (sum - c.inertia).norm() / c.inertia.norm();
        assert!(error < 1e-3, "{error}"); // 6e-4 seen
    }
}
