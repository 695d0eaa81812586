//! Inertia of a body with all it carries, and the momenta of its unit motions.
//!
//! In: mass, inertia and centre of mass along world axes. Out: the same about any origin, sums, and the linear and angular momentum of
//! motions at unit rate: `I^c S` of the composite-rigid-body algorithm ([`crate::crba`]).

use motion::Vec3;
use nalgebra::{Matrix3, SVector};

/// A body with all it carries, about the body's origin, world axes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Composite {
    /// Mass, kg.
    mass: f64,
    /// Mass times centre of mass, kg·m.
    first: Vec3,
    /// Inertia about the origin, kg·m²: xx, yy, zz, xy, xz, yz.
    second: [f64; 6],
}

impl Composite {
    /// A rigid body: mass (kg), inertia about its centre of mass (kg·m²), where that is seen from the origin (m).
    #[inline(always)]
    pub fn of(mass: f64, i: &Matrix3<f64>, to_com: &Vec3) -> Self {
        let at_com = Self {
            mass,
            first: Vec3::zeros(),
            second: [i[(0, 0)], i[(1, 1)], i[(2, 2)], i[(0, 1)], i[(0, 2)], i[(1, 2)]],
        };
        at_com.about(to_com)
    }

    /// The same about a point from which this origin is seen at `r`.
    ///
    /// I' = I + 2 (k·r) 1 − (k rᵀ + r kᵀ) with k = m c + ½ m r.
    #[inline(always)]
    pub fn about(&self, r: &Vec3) -> Self {
        let k = self.first + r * (0.5 * self.mass);
        let (x, y, z) = (2.0 * k.x * r.x, 2.0 * k.y * r.y, 2.0 * k.z * r.z);
        let [xx, yy, zz, xy, xz, yz] = self.second;
        Self {
            mass: self.mass,
            first: self.first + r * self.mass,
            second: [
                xx + y + z,
                yy + x + z,
                zz + x + y,
                xy - k.x * r.y - k.y * r.x,
                xz - k.x * r.z - k.z * r.x,
                yz - k.y * r.z - k.z * r.y,
            ],
        }
    }

    /// Adds a body about the same origin.
    pub fn add(&mut self, other: &Self) {
        self.mass += other.mass;
        self.first += other.first;
        for (a, b) in self.second.iter_mut().zip(other.second) {
            *a += b;
        }
    }

    /// Momentum about the origin while the axes in the lanes of `w` turn at unit rate about it.
    #[inline(always)]
    pub fn turning<const N: usize>(&self, w: &Axes<N>) -> Momenta<N> {
        let [xx, yy, zz, xy, xz, yz] = self.second;
        let h = &self.first;
        let [x, y, z] = w;
        Momenta {
            p: [y * h.z - z * h.y, z * h.x - x * h.z, x * h.y - y * h.x],
            l: [x * xx + y * xy + z * xz, x * xy + y * yy + z * yz, x * xz + y * yz + z * zz],
        }
    }

    /// Momentum about the origin while all slides along the axes at unit speed.
    #[inline(always)]
    pub fn sliding<const N: usize>(&self, u: &Axes<N>) -> Momenta<N> {
        let h = &self.first;
        let [x, y, z] = u;
        Momenta {
            p: [x * self.mass, y * self.mass, z * self.mass],
            l: [z * h.y - y * h.z, x * h.z - z * h.x, y * h.x - x * h.y],
        }
    }
}

/// Components x, y, z of N vectors side by side: one lane per axis of a joint, so that processors work
/// on all of them at once. Balls take four lanes, of which the last is idle.
pub(crate) type Axes<const N: usize> = [SVector<f64, N>; 3];

/// Linear and angular momenta of N unit motions.
#[derive(Clone, Copy)]
pub(crate) struct Momenta<const N: usize> {
    /// Linear, kg·m/s per unit rate.
    pub p: Axes<N>,
    /// Angular about the origin.
    pub l: Axes<N>,
}

impl<const N: usize> Momenta<N> {
    /// Angular momenta about a point from which the present one is seen at `r`: l + r × p.
    #[inline(always)]
    pub fn angular_about(&self, r: &Vec3) -> Axes<N> {
        let [px, py, pz] = &self.p;
        let [lx, ly, lz] = &self.l;
        [lx + (pz * r.y - py * r.z), ly + (px * r.z - pz * r.x), lz + (py * r.x - px * r.y)]
    }
}
